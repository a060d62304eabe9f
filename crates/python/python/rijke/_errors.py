"""Errors: what is wrong, in which file, at which place, and the remedy."""

from __future__ import annotations

TYPE_CHECKING = False  # without importing typing, which is half of the time of this package
if TYPE_CHECKING:
    from typing import Optional, Tuple


class RijkeError(Exception):
    """Something could not be done.

    Attributes
    ----------
    message : str
        What is wrong.
    file : str or None
        The file it is about, if there is one.
    place : str or None
        The place in the file: line, element or table.
    remedy : str or None
        What to do about it.
    """

    def __init__(
        self,
        message: str,
        file: Optional[str] = None,
        place: Optional[str] = None,
        remedy: Optional[str] = None,
    ) -> None:
        super().__init__(message, file, place, remedy)
        self.message = message
        self.file = file
        self.place = place
        self.remedy = remedy

    def __str__(self) -> str:
        named = [word for word in (self.file, self.place) if word and word not in self.message]
        text = ": ".join([*named, self.message])
        return f"{text}\n  remedy: {self.remedy}" if self.remedy else text

    def __reduce__(self) -> Tuple[type, Tuple[Optional[str], ...]]:
        return type(self), (self.message, self.file, self.place, self.remedy)


class InputError(RijkeError, ValueError):
    """A file or an argument is wrong. The program `rijke` ends with exit status 2 where this is raised."""


class ComputationError(RijkeError, ArithmeticError):
    """The input is sound, but the work could not be done: no mode near a guess, a search that did not converge."""
