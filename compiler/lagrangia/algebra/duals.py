"""The algebra in which kinematics and energies are evaluated, whatever its scalars: see with_casadi.py and with_sympy.py.

A scalar is a Python float, a symbol of the algebra, or a Dual of such scalars. Python's operators work on all of them; what
operators cannot say (functions, conditions) goes through the methods of an Algebra.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Protocol

from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.base.table_data import TableData

Scalar = Any  # float | ca.SX | Dual

_NUMBERS = (float, int)
# Keeps the square root in distances differentiable where two points coincide: the direction is then zero, not NaN.
TINY = 1e-300


class NotATimeError(Exception):
    """A table that is too long, or says too little, for anything but a + b*time."""

    def __init__(self, table: TableData) -> None:
        super().__init__(table.name)
        self.table = table


class Algebra(Protocol):
    """The functions of expressions, for one kind of scalars."""

    @property
    def tiny(self) -> float:
        """Added under the square root of a distance; see TINY."""

    @property
    def most_points(self) -> float:
        """Of a table that it can write out."""

    def number(self, value: float) -> Scalar:
        """A number of the source as a scalar of the algebra."""

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        """A function of the language, by its name: "sin", "sqrt", "fmax", ..."""
    def product(self, x: Scalar, y: Scalar) -> Scalar:
        """x y, without factors that are 0 or 1."""

    def quotient(self, x: Scalar, y: Scalar, place: Span) -> Scalar:
        """x/y, as is written at this place."""

    def note_length(self, x: Scalar) -> None:
        """|x| is a length: it hardly ever is 0, unlike what else has a corner there."""

    def compare(self, operator: str, a: Scalar, b: Scalar, of_rates: bool = False) -> Scalar:
        """1 where a < b, or another operator, holds; else 0. `of_rates`: it decides about rates, which may jump there."""
    def side(self, x: Scalar) -> Scalar:
        """The sign of x, which decides about rates."""
    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        """One of two values, by a condition."""
    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        """"and", "or" and "not" of conditions."""
    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        """Straight lines between points (xs, ys), held beyond their ends: the value at x and, when asked for, the slope."""
    def pieces(self, x: Scalar, table: TableData) -> list[Scalar]:
        """Place x0 and coefficients of the polynomial in x - x0 that a table is at x, the constant first."""


def slopes_of(xs: Sequence[Scalar], ys: Sequence[Scalar]) -> list[Scalar]:
    """The slope of each segment between points (xs, ys)."""
    return [(d - c) / (b - a) for a, b, c, d in zip(xs, xs[1:], ys, ys[1:], strict=False)]


def nested_lines(algebra: Algebra, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
    """Algebra.lines, one choice in the other."""
    slopes = slopes_of(xs, ys)

    def choose(pieces: Sequence[Scalar], before: Scalar, after: Scalar) -> Scalar:
        for at, piece in zip(reversed(xs[1:]), reversed(pieces), strict=True):
            after = algebra.choose(algebra.compare("<", x, at), piece, after)
        return algebra.choose(algebra.compare("<", x, xs[0]), before, after)

    lines = [y + (x - at) * slope for at, y, slope in zip(xs, ys, slopes, strict=False)]
    return choose(lines, ys[0], ys[-1]), lambda: choose(slopes, 0.0, 0.0)


def looked_up(algebra: Algebra, x: Scalar, table: TableData) -> Scalar:
    """What a table is at x, with its rates."""
    place, *coefficients = algebra.pieces(x, table)
    return polynomial(x, place, coefficients)


def polynomial(x: Scalar, place: Scalar, coefficients: Sequence[Scalar]) -> Scalar:
    """Of x - place, the constant first, with its rates."""
    value, way = coefficients[-1], minus(x, place)
    for coefficient in reversed(coefficients[:-1]):
        value = plus(times(way, value), coefficient)
    return value


# -------------------------------------------------------------------- values with their rates


class Dual:
    """A scalar and its rate along the motion. A rate that is the float 0 costs nothing."""

    __slots__ = ("rate", "value")

    def __init__(self, value: Scalar, rate: Scalar) -> None:
        self.value, self.rate = value, rate

    def __add__(self, other: Scalar) -> "Dual":
        if isinstance(other, Dual):
            return Dual(self.value + other.value, plus(self.rate, other.rate))
        return Dual(self.value + other, self.rate)

    __radd__ = __add__

    def __neg__(self) -> "Dual":
        return Dual(-self.value, 0.0 if is_zero(self.rate) else -self.rate)

    def __sub__(self, other: Scalar) -> "Dual":
        return self.__add__(-other)

    def __rsub__(self, other: Scalar) -> "Dual":
        return (-self).__add__(other)

    def __mul__(self, other: Scalar) -> "Dual":
        if isinstance(other, Dual):
            return Dual(self.value * other.value, plus(times(self.rate, other.value), times(other.rate, self.value)))
        return Dual(self.value * other, times(self.rate, other))

    __rmul__ = __mul__

    def __truediv__(self, other: Scalar) -> "Dual":
        if not isinstance(other, Dual):
            return Dual(self.value / other, 0.0 if is_zero(self.rate) else self.rate / other)
        quotient = self.value / other.value
        top = plus(self.rate, times(minus(0.0, other.rate), quotient))
        return Dual(quotient, 0.0 if is_zero(top) else top / other.value)

    def __rtruediv__(self, other: Scalar) -> "Dual":
        return Dual(other, 0.0) / self


# Sums and products in which the numbers 0 and 1 cost nothing.


def is_zero(x: Scalar) -> bool:
    """Whether it is the number 0; an expression never is."""
    return isinstance(x, _NUMBERS) and x == 0


def plus(a: Scalar, b: Scalar) -> Scalar:
    """a + b, without terms that are 0."""
    if isinstance(a, _NUMBERS) and a == 0:  # is_zero, which is called more often than all else
        return b
    return a if isinstance(b, _NUMBERS) and b == 0 else a + b


def minus(a: Scalar, b: Scalar) -> Scalar:
    """a - b, without terms that are 0."""
    if isinstance(b, _NUMBERS) and b == 0:
        return a
    return -b if isinstance(a, _NUMBERS) and a == 0 else a - b


def times(a: Scalar, b: Scalar) -> Scalar:
    """a b, without factors that are 0 or 1."""
    if isinstance(a, _NUMBERS):
        return 0.0 if a == 0 else b if a == 1 else a * b
    if isinstance(b, _NUMBERS):
        return 0.0 if b == 0 else a if b == 1 else a * b
    return a * b


def dot(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """Inner product, without terms that are 0."""
    total: Scalar = 0.0
    for x, y in zip(a, b, strict=True):
        total = plus(total, times(x, y))
    return total


def added(a: Sequence[Scalar], b: Sequence[Scalar]) -> list[Scalar]:
    """a + b of two vectors of one length, without terms that are 0."""
    return [plus(x, y) for x, y in zip(a, b, strict=True)]


def value_of(x: Scalar) -> Scalar:
    """A dual's value; other scalars are their own."""
    return x.value if isinstance(x, Dual) else x


def base_of(x: Scalar) -> Scalar:
    """The plain scalar under Duals of any level."""
    while isinstance(x, Dual):
        x = x.value
    return x


def rate_of(x: Scalar) -> Scalar:
    """A dual's rate; 0 for other scalars, which do not move."""
    return x.rate if isinstance(x, Dual) else 0.0


@dataclass(frozen=True)
class DualAlgebra:
    """Duals over the scalars of `base`: every function carries its derivative along."""

    base: Algebra

    @property
    def tiny(self) -> float:
        """As of the algebra beneath."""
        return self.base.tiny

    @property
    def most_points(self) -> float:
        """As of the algebra beneath."""
        return self.base.most_points

    def number(self, value: float) -> Scalar:
        """As of the algebra beneath: numbers do not move."""
        return self.base.number(value)

    def product(self, x: Scalar, y: Scalar) -> Scalar:
        """Of the value as of the algebra beneath."""
        if not isinstance(x, Dual) and not isinstance(y, Dual):
            return self.base.product(x, y)
        made = times(x, y)
        return Dual(self.base.product(value_of(x), value_of(y)), made.rate) if isinstance(made, Dual) else made

    def quotient(self, x: Scalar, y: Scalar, place: Span) -> Scalar:
        """Of the value as of the algebra beneath."""
        if not isinstance(x, Dual) and not isinstance(y, Dual):
            return self.base.quotient(x, y, place)
        value = self.base.quotient(value_of(x), value_of(y), place)
        top = plus(rate_of(x), times(minus(0.0, rate_of(y)), value))
        return Dual(value, 0.0 if is_zero(top) else self.base.quotient(top, value_of(y), place))

    def note_length(self, x: Scalar) -> None:
        """As of the algebra beneath, of the value."""
        self.base.note_length(value_of(x))

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        """Of values, with the rate by the chain rule."""
        if not any(isinstance(a, Dual) for a in arguments):
            return self.base.call(function, *arguments)
        values, rates = [value_of(a) for a in arguments], [rate_of(a) for a in arguments]
        if function in ("fmin", "fmax"):
            first = self.base.compare("<" if function == "fmin" else ">", values[0], values[1], True)
            return Dual(self.base.call(function, *values), self.base.choose(first, *rates))
        value = self.base.call(function, *values)
        partials = _PARTIALS[function](self.base, value, *values)
        total: Scalar = 0.0
        for slope, rate in zip(partials, rates, strict=True):
            total = plus(total, times(slope() if not is_zero(rate) else 0.0, rate))
        return Dual(value, total)

    def compare(self, operator: str, a: Scalar, b: Scalar, of_rates: bool = False) -> Scalar:
        """Of values: between its jumps a condition does not move."""
        return self.base.compare(operator, value_of(a), value_of(b), True)

    def side(self, x: Scalar) -> Scalar:
        """Of the value: it does not move."""
        return self.base.side(value_of(x))

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        """The value and the rate of the one that is chosen."""
        if not isinstance(then, Dual) and not isinstance(otherwise, Dual):
            return self.base.choose(condition, then, otherwise)
        rates = rate_of(then), rate_of(otherwise)
        rate = 0.0 if is_zero(rates[0]) and is_zero(rates[1]) else self.base.choose(condition, *rates)
        return Dual(self.base.choose(condition, value_of(then), value_of(otherwise)), rate)

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        """Of values."""
        return self.base.logic(operator, *(value_of(c) for c in conditions))

    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        """The table's value, with its slope times the rate."""
        value, slope = self.base.lines(value_of(x), xs, ys)
        return Dual(value, times(slope(), rate_of(x)) if not is_zero(rate_of(x)) else 0.0), slope

    def pieces(self, x: Scalar, table: TableData) -> list[Scalar]:
        """As of the algebra beneath: between knots they do not move."""
        return self.base.pieces(value_of(x), table)


@dataclass(frozen=True)
class GlidingAlgebra(DualAlgebra):
    """Duals in which modes have rates, as if what jumps at a time event went over evenly. `glide`: of a value, the rate that the
    modes in it give it. Tables do not jump."""

    glide: Callable[[Scalar], Scalar]

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        """As of duals, with rates of floor, ceil and mod where they jump."""
        if function == "mod":
            a, b = arguments
            return a - b * self.call("floor", a / b)
        found = super().call(function, *arguments)
        return self._gliding(value_of(found), rate_of(found)) if function in ("floor", "ceil") else found

    def compare(self, operator: str, a: Scalar, b: Scalar, of_rates: bool = False) -> Scalar:
        """The condition, with the rate that its modes have."""
        return self._gliding(super().compare(operator, a, b), 0.0)

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        """As of duals, with the rate at which it goes over from one value to the other."""
        chosen = super().choose(value_of(condition), then, otherwise)
        more = times(rate_of(condition), minus(value_of(then), value_of(otherwise)))
        return chosen if is_zero(more) else Dual(value_of(chosen), plus(rate_of(chosen), more))

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        """By sums and products of conditions, whose rates follow."""
        if operator == "not":
            return 1.0 - conditions[0]
        a, b = conditions
        return a * b if operator == "and" else a + b - a * b

    def pieces(self, x: Scalar, table: TableData) -> list[Scalar]:
        """Only steps jump."""
        found = super().pieces(x, table)
        return found if table.degree else [found[0], self._gliding(found[1], 0.0)]

    def _gliding(self, value: Scalar, rate: Scalar) -> Scalar:
        rate = plus(rate, self.glide(value))
        return value if is_zero(rate) else Dual(value, rate)


# Partial derivatives of f = function(x, ...): one closure for each argument, called only when that argument moves.
_PARTIALS: Mapping[str, Callable[..., list[Callable[[], Scalar]]]] = {
    "sin": lambda g, f, x: [lambda: g.call("cos", x)],
    "cos": lambda g, f, x: [lambda: -g.call("sin", x)],
    "tan": lambda g, f, x: [lambda: 1 + f * f],
    "asin": lambda g, f, x: [lambda: 1 / g.call("sqrt", 1 - x * x)],
    "acos": lambda g, f, x: [lambda: -1 / g.call("sqrt", 1 - x * x)],
    "atan": lambda g, f, x: [lambda: 1 / (1 + x * x)],
    "sinh": lambda g, f, x: [lambda: g.call("cosh", x)],
    "cosh": lambda g, f, x: [lambda: g.call("sinh", x)],
    "tanh": lambda g, f, x: [lambda: 1 - f * f],
    "asinh": lambda g, f, x: [lambda: 1 / g.call("sqrt", x * x + 1)],
    "acosh": lambda g, f, x: [lambda: 1 / g.call("sqrt", x * x - 1)],
    "atanh": lambda g, f, x: [lambda: 1 / (1 - x * x)],
    "exp": lambda g, f, x: [lambda: f],
    "log": lambda g, f, x: [lambda: 1 / x],
    "log10": lambda g, f, x: [lambda: 1 / (x * g.call("log", g.number(10.0)))],
    "sqrt": lambda g, f, x: [lambda: g.number(0.5) / f],
    "abs": lambda g, f, x: [lambda: g.side(x)],
    "sign": lambda g, f, x: [lambda: 0.0],
    "floor": lambda g, f, x: [lambda: 0.0],
    "ceil": lambda g, f, x: [lambda: 0.0],
    "atan2": lambda g, f, y, x: [lambda: x / (x * x + y * y), lambda: -y / (x * x + y * y)],
    "mod": lambda g, f, a, b: [lambda: 1.0, lambda: -g.call("floor", a / b)],
    "pow": lambda g, f, a, b: [lambda: b * g.call("pow", a, b - 1), lambda: f * g.call("log", a)],
}
