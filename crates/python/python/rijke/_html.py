"""Tables for notebooks."""

from __future__ import annotations

from html import escape

TYPE_CHECKING = False
if TYPE_CHECKING:
    from typing import Any, Sequence

__all__ = ["escape", "table"]


def table(head: Sequence[str], rows: Sequence[Sequence[Any]]) -> str:
    """A table of HTML. Heads may hold marks of HTML; cells are text."""
    heads = "".join(f"<th>{word}</th>" for word in head)
    body = "".join("<tr>" + "".join(f"<td>{escape(str(cell))}</td>" for cell in row) + "</tr>" for row in rows)
    return f"<table><thead><tr>{heads}</tr></thead><tbody>{body}</tbody></table>"
