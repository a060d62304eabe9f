"""What a caller sees of long work: a bar in notebooks, lines elsewhere, or calls of a function of its own."""

from __future__ import annotations

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Callable, Union

    #: Called with how much is done, how much there is, and what comes next.
    Call = Callable[[int, int, str], None]
    Progress = Union[bool, Call]


def told(progress: Progress, what: str) -> Call:
    """The function to call: ``True`` shows ``what``, ``False`` nothing."""
    if progress is True:
        return _Shown(what)
    return progress or (lambda done, count, title: None)


class _Shown:
    """A bar in a notebook, which is drawn anew; elsewhere a line on standard error, at each tenth or title."""

    def __init__(self, what: str) -> None:
        self.what = what
        self.said = (-1, "")
        self.handle: Any = None
        self.notebook = _in_notebook()

    def __call__(self, done: int, count: int, title: str) -> None:
        if self.notebook:
            self._draw(done, count, title)
            return
        now = (10 * done // max(count, 1), title)
        if now != self.said and done < count:
            import sys

            self.said = now
            print(f"{self.what} {done + 1} of {count}{': ' + title if title else ''}", file=sys.stderr, flush=True)

    def _draw(self, done: int, count: int, title: str) -> None:
        import IPython.display

        from ._html import escape

        bar = f"<progress value='{done}' max='{max(count, 1)}'></progress>"
        show: Any = IPython.display
        html = show.HTML(f"{bar} {escape(self.what)} {done} of {count} {escape(title)}")
        if self.handle is None:
            self.handle = show.display(html, display_id=True)
        else:
            self.handle.update(html)


def _in_notebook() -> bool:
    """Whether a kernel of Jupyter runs this; IPython is not imported for the question."""
    import sys

    ipython = sys.modules.get("IPython")
    shell = ipython.get_ipython() if ipython else None
    return shell is not None and hasattr(shell, "kernel")
