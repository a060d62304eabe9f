"""What found things have in common."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any


class Table:
    """Named arrays that belong together. They are attributes, and are not to be changed."""

    def __init__(self, **columns: Any) -> None:
        self.__dict__.update(columns)
