"""What texts of imported robots are written with: names unlike all others, numbers, rows, angles, vectors in turned axes."""

import math
import re
from collections.abc import Sequence

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.base.spelling import read_number
from lagrangia.fmu.xmltree import Element
from lagrangia.language.syntax import tables

_TAKEN = ("world", "time", "pi")
_IDENTIFIER = re.compile(r"[^\W\d]\w*")
_NOISE = 1e-15  # m, kg.m2: what programs leave of what is 0; no body could be with such moments


class Names:
    """Names that a text has used."""

    def __init__(self) -> None:
        self.used: set[str] = set(_TAKEN)

    def fresh(self, name: str, ending: str = "_") -> str:
        """As it may be written on one line, unlike all others."""
        name = " ".join(name.split())
        while name in self.used or name in tables().words:
            name += ending
        self.used.add(name)
        return name if _IDENTIFIER.fullmatch(name) else "'" + name.replace("\\", "\\\\").replace("'", "\\'") + "'"


def read_numbers(element: Element, name: str, count: int, text: str | None = None) -> list[float]:
    """The numbers of an attribute; `text` is it where the element does not say it itself. Raises LagError L0730."""
    text = element.get(name) or "" if text is None else text
    try:
        found = [read_number(part) for part in text.split()]
    except ValueError:
        found = []
    if len(found) != count or not all(map(math.isfinite, found)):
        what = "a number" if count == 1 else f"{count} numbers"
        fail("L0730", f"'{name}' of <{element.tag}> is {what}", element.span(name))
    return found


def quoted(text: str) -> str:
    """What may stand between quotes."""
    return text.replace("\\", "\\\\").replace('"', '\\"')


def number(x: float) -> str:
    """To the last digit."""
    return repr(int(x)) if x == int(x) and abs(x) < 1e15 else repr(x)


def difference(what: str, x: float) -> str:
    """Less a number, in brackets if that is none."""
    return f"({what} {'-' if x > 0 else '+'} {number(abs(x))})" if x else what


def row(values: Sequence[float]) -> str:
    """A vector."""
    return "{" + ", ".join(map(number, values)) + "}"


def inertia_matrix(rows: Sequence[Sequence[float]]) -> str:
    """Three moments, or the rows of the matrix where the axes are no principal ones. kg.m2."""
    rows = [[0.0 if abs(x) < _NOISE else x for x in line] for line in rows]
    if any(rows[i][j] for i in range(3) for j in range(3) if i != j):
        return "{" + ", ".join(map(row, rows)) + "}"
    return row([rows[k][k] for k in range(3)])


def radians(x: float) -> str:
    """Radians; parts of pi as such, when they are that to the last digit."""
    for parts in (1, 2, 3, 4, 6):
        times = round(x * parts / math.pi)
        if times and x == times * math.pi / parts:
            factor = {1: "", -1: "-"}.get(times, f"{times}*")
            return f"{factor}pi" + (f"/{parts}" if parts > 1 else "")
    return number(x)


@dataclass(frozen=True)
class Place:
    """A frame with a displacement in its axes, which is written once however many lead to it. m."""

    frame: str
    ahead: tuple[float, ...] = (0.0, 0.0, 0.0)

    def __str__(self) -> str:
        ahead = [0.0 if abs(x) < _NOISE else x for x in self.ahead]
        return f"shift({self.frame}, {row(ahead)})" if any(ahead) else self.frame

    def shifted(self, by: Sequence[float]) -> "Place":
        """Further in the same axes."""
        return Place(self.frame, tuple(a + b for a, b in zip(self.ahead, by, strict=True)))

    def turned(self, angle: float, axis: Sequence[float]) -> "Place":
        """By radians about an axis in its own axes."""
        about = "" if tuple(axis) == (0, 0, 1) else f", {row(axis)}"
        return Place(f"turn({self}, {radians(angle)}{about})") if angle else self


def counted(*parts: tuple[int, str]) -> str:
    """2 hinges, 1 slider; nothing of which there is none."""
    return ", ".join(f"{count} {what}{'s' * (count != 1)}" for count, what in parts if count)
