"""Tables that notebooks show."""

import html
from collections.abc import Iterable, Sequence
from typing import Any


def html_table(heads: Sequence[str], rows: Iterable[Sequence[Any]], caption: str = "") -> str:
    """A table of plain HTML: numbers by six digits, None as an empty cell, all other as text, whatever it holds."""
    told = f"<caption>{html.escape(caption)}</caption>" if caption else ""
    head = "".join(f"<th>{html.escape(name)}</th>" for name in heads)
    body = "".join("<tr>" + "".join(f"<td>{_cell(x)}</td>" for x in row) + "</tr>" for row in rows)
    return f"<table>{told}<thead><tr>{head}</tr></thead><tbody>{body}</tbody></table>"


_LEAST = 1e-12
MOST_COLUMNS, MOST_ROWS = 20, 60


def unrounded(x: float) -> float:
    """0 for what rounding leaves of it."""
    return 0.0 if abs(x) < _LEAST else x


def missing(count: int, what: str) -> list[str]:
    """What to note of a table with so many columns."""
    return [f"{MOST_COLUMNS} of {count} {what} are shown"] if count > MOST_COLUMNS else []


def headed(name: str, unit: str) -> str:
    """A name with its unit."""
    return f"{name} [{unit}]" if unit and unit != "1" else name


def html_notes(notes: Iterable[str]) -> str:
    """A paragraph each."""
    return "".join(f"<p>{html.escape(note)}</p>" for note in notes)


def _cell(value: Any) -> str:
    return "" if value is None else f"{value:.6g}" if isinstance(value, float) else html.escape(str(value))
