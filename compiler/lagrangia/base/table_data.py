"""Tables of one variable as plain data: knots, and polynomials between them. runtime/model/table.h states the same for C."""

from array import array
from bisect import bisect_right
from collections.abc import Sequence
from enum import IntEnum
from math import floor, nan
from typing import Any

from lagrangia.base.records import dataclass


class Beyond(IntEnum):
    """LAG_BEYOND_... of table.h: what a table says beyond its ends."""

    HOLD = 0
    LINEAR = 1
    PERIODIC = 2
    ERROR = 3


# Of the polynomials between two knots, by what is asked for.
DEGREES = {"steps": 0, "linear": 1, "cubic": 3, "monotone": 3}


def curvature(width: Any, rise: Any, a: Any, b: Any) -> tuple[Any, Any]:
    """Of the cubic over a width that rises by `rise` on average and has the slopes a and b at its ends: the coefficients of the
    square and the cube, numbers or arrays."""
    return (3 * rise - 2 * a - b) / width, (a + b - 2 * rise) / width**2


@dataclass(frozen=True, eq=False)
class TableData:
    """`y` and, of degree 3, the `slopes` at the knots are buffers of doubles, as are the knots `x`; where these lie evenly x is
    empty: knot k is start + k pitch. `name` is what people call it."""

    name: str
    degree: int
    beyond: Beyond
    start: float
    pitch: float
    x: Any
    y: Any
    slopes: Any

    @property
    def n(self) -> int:
        """The number of knots."""
        return len(self.y)

    def is_like(self, other: "TableData") -> bool:
        """Whether both say the same."""
        plain = [(t.degree, t.beyond, t.n, t.start, t.pitch) for t in (self, other)]
        return self is other or (plain[0] == plain[1] and all(
            bytes(getattr(self, name)) == bytes(getattr(other, name)) for name in ("x", "y", "slopes")))

    def knot(self, k: int) -> float:
        """Where the k-th knot lies, counted from 0."""
        return float(self.x[k]) if len(self.x) else self.start + k * self.pitch

    def knots(self) -> "Sequence[float]":
        """All of them."""
        return self.x if len(self.x) else [self.start + k * self.pitch for k in range(self.n)]

    @property
    def period(self) -> float:
        """From the first knot to the last."""
        return self.knot(self.n - 1) - self.knot(0)

    def piece(self, x: float) -> list[float]:
        """The place x0 and the coefficients of the polynomial in x - x0 that holds at x, the constant first; NaN for them where
        the table says nothing."""
        moved = floor((x - self.knot(0)) / self.period) * self.period if self.beyond is Beyond.PERIODIC else 0.0
        number = self._number(x - moved)
        if number == self.n and self.beyond is Beyond.ERROR and x == self.knot(self.n - 1):
            number -= 1
        place, *coefficients = self.piece_number(number)
        return [place + moved, *coefficients]

    def _number(self, x: float) -> int:
        return bisect_right(range(self.n), x, key=self.knot)

    def piece_number(self, number: int) -> list[float]:
        """The same of a piece: 0 before the first knot, n behind the last one."""
        k = min(max(number - 1, 0), self.n - 2)
        width = self.knot(k + 1) - self.knot(k)
        rise = (self.y[k + 1] - self.y[k]) / width
        if 0 < number < self.n:
            return [self.knot(k), *self._coefficients(k, width, rise)]
        end = 0 if number == 0 else self.n - 1
        slope = self.slopes[end] if self.degree == 3 else rise
        flat = [float(self.y[end]), float(slope) if self.beyond is Beyond.LINEAR else 0.0, 0.0, 0.0][: self.degree + 1]
        return [self.knot(end), *([nan] * len(flat) if self.beyond is Beyond.ERROR else flat)]

    def _coefficients(self, k: int, width: float, rise: float) -> list[float]:
        y = float(self.y[k])
        if self.degree < 3:
            return [y, float(rise)][: self.degree + 1]
        a, b = self.slopes[k], self.slopes[k + 1]
        return [y, float(a), *map(float, curvature(width, rise, a, b))]

    def between(self, begin: float, end: float) -> list[float]:
        """The knots inside an interval, however often the table comes again."""
        first, last = self.knot(0), self.knot(self.n - 1)
        turns = [0] if self.beyond is not Beyond.PERIODIC else range(floor((begin - first) / self.period),
                                                                    floor((end - first) / self.period) + 1)
        found = {self.knot(k) + turn * self.period for turn in turns
                 for k in range(self._number(begin - turn * self.period), self._number(end - turn * self.period))}
        return sorted(x for x in found if begin < x < end and first <= last)


def lines_between(xs: Sequence[float], ys: Sequence[float], name: str = "points") -> TableData:
    """Straight lines, held beyond the ends."""
    knots, values = array("d", map(float, xs)), array("d", map(float, ys))
    return TableData(name, 1, Beyond.HOLD, knots[0], (knots[-1] - knots[0]) / (len(knots) - 1), knots, values, array("d"))
