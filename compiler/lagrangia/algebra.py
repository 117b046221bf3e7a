"""The algebra in which kinematics and energies are evaluated: CasADi here, SymPy in symbolic.py.

A scalar is a Python float, a symbol of the algebra, or a Dual of such scalars. Python's operators work on all of them; what
operators cannot say (functions, conditions) goes through the methods of an Algebra.
"""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property, partial, reduce
from itertools import accumulate, pairwise
from typing import Any, Protocol

import casadi as ca

from lagrangia.scalars import apply, apply_to_one, as_expression, symbols_in
from lagrangia.scalars import symbol as make_symbol

Scalar = Any  # float | ca.SX | Dual

_NUMBERS = (float, int)
_COMMUTATIVE = (ca.OP_ADD, ca.OP_MUL)
# Keeps the square root in distances differentiable where two points coincide: the direction is then zero, not NaN.
TINY = 1e-300


class Algebra(Protocol):
    @property
    def tiny(self) -> float:
        """Added under the square root of a distance; see TINY."""

    @property
    def most_points(self) -> float:
        """Of a table that it can write out."""

    def number(self, value: float) -> Scalar:
        """A number of the source as a scalar of the algebra."""

    def call(self, function: str, *arguments: Scalar) -> Scalar: ...
    def compare(self, operator: str, a: Scalar, b: Scalar) -> Scalar: ...
    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar: ...
    def logic(self, operator: str, *conditions: Scalar) -> Scalar: ...
    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        """Straight lines between points (xs, ys), held beyond their ends: the value at x and, when asked for, the slope."""


# -------------------------------------------------------------------- CasADi


@dataclass
class Mode:
    """A quantity that is constant between two time events: a relation, a floor, or what a table in time says of a line.

    `value` gives it as a function of t (the middle of the segment) and p; the events are where one of the arguments crosses
    zero (kind 0) or an integer (kind 1).
    """

    symbol: ca.SX
    value: ca.SX
    arguments: Sequence[ca.SX]
    kind: int


@dataclass
class ModeIndex:
    """Finds the mode that says the same, however its expression was built: what is the same has one number."""

    numbers: dict[tuple[float, ...], int] = field(default_factory=dict)  # of all parts of arguments
    keys: list[tuple[float, ...]] = field(default_factory=list)  # by number
    symbols: dict[Hashable, ca.SX] = field(default_factory=dict)  # by operator and argument
    hashes: set[int] = field(default_factory=set)  # of these symbols
    modes: list[Mode] = field(default_factory=list)  # all of them, of all islands

    def number(self, function: ca.Function, symbols: list[ca.SX]) -> int:
        """Of the value of a scalar function of these symbols."""
        held = [0] * max(1, function.sz_w())
        made = 0
        for k in range(function.n_instructions()):
            op, inputs = function.instruction_id(k), function.instruction_input(k)
            if op == ca.OP_INPUT:
                key: tuple[float, ...] = (op, symbols[inputs[0]].__hash__())
            elif op == ca.OP_CONST:
                key = (op, function.instruction_constant(k))
            else:
                operands = [held[place] for place in inputs]
                if op == ca.OP_SUB:  # a - 1 is a + -1
                    op, operands[1] = ca.OP_ADD, self._negative(operands[1])
                key = (op, *(sorted(operands) if op in _COMMUTATIVE else operands))
            made = held[function.instruction_output(k)[0]] = self._numbered(key)
        return made

    def _numbered(self, key: tuple[float, ...]) -> int:
        if key not in self.numbers:
            self.numbers[key] = len(self.keys)
            self.keys.append(key)
        return self.numbers[key]

    def _negative(self, number: int) -> int:
        op, *operands = self.keys[number]
        return self._numbered((ca.OP_CONST, -operands[0]) if op == ca.OP_CONST else (ca.OP_NEG, number))


@dataclass(frozen=True)
class _Crossing:
    """Where a + b t, or a + b t + s floor(c + d t), crosses levels."""

    number: int  # of all that says the same
    value: ca.SX  # in time and parameters alone
    straight: ca.SX  # a + b t
    step: ca.SX | None = None  # s
    jumps: Sequence[ca.SX] = ()  # c + d t

    @property
    def kind(self) -> int:
        return 0 if self.step is None else 1

    def arguments(self, levels: Sequence[Scalar]) -> list[ca.SX]:
        """Of events. With a step, straight + s n is the level for some integer n: at each crossing, and at other times."""
        if self.step is None:
            return [minus(self.straight, level) for level in levels]
        return [*self.jumps, *((level - self.straight) / self.step for level in levels)]


@dataclass
class CasadiAlgebra:
    """Scalars are ca.SX or float. Conditions on time and parameters alone become modes, so that the right-hand side is smooth
    between time events and the integrator can stop exactly at them."""

    time: ca.SX
    state: ca.SX  # all symbols that change continuously besides time: q, v, u
    modes: list[Mode] = field(default_factory=list)
    index: ModeIndex = field(default_factory=ModeIndex)  # of these modes
    tiny: float = TINY
    most_points: float = math.inf

    def number(self, value: float) -> Scalar:
        return value

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        if function in ("floor", "ceil"):
            inner = arguments[0] if function == "floor" else -arguments[0]
            crossing = self._crossing(inner)
            if crossing is not None and crossing.step is None:
                mode = self._mode(("floor", crossing.number), ca.floor(inner), [inner], 1)
                return mode if function == "floor" else -mode
        if function == "mod":
            a, b = arguments
            return a - b * self.call("floor", a / b)
        if all(isinstance(a, float | int) for a in arguments):
            return _call_float(function, *arguments)
        return _SX_FUNCTIONS[function](*arguments)

    def compare(self, operator: str, a: Scalar, b: Scalar) -> Scalar:
        if isinstance(a, float | int) and isinstance(b, float | int):
            return float(_COMPARE[operator](a, b))
        difference = a - b
        crossing = self._crossing(difference) if operator not in ("==", "<>") else None
        if crossing is not None:
            key, value = (operator, crossing.number), _COMPARE[operator](crossing.value, 0)
            return self._mode(key, value, crossing.arguments([0.0]), crossing.kind)
        return as_expression(_COMPARE[operator](a, b))

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        if isinstance(condition, float | int):
            return then if condition else otherwise
        opposite = apply_to_one(ca.OP_NOT, condition)
        return apply(ca.OP_IF_ELSE_ZERO, condition, then) + apply(ca.OP_IF_ELSE_ZERO, opposite, otherwise)

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        if operator == "not":
            return 1.0 - conditions[0]
        a, b = conditions
        return a * b if operator == "and" else a + b - a * b

    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        if not isinstance(x, ca.SX):
            return nested_lines(self, x, xs, ys)
        columns = [[xs[0], *xs], [ys[0], *ys], [0.0, *_slopes(xs, ys), 0.0]]
        rest = self._at_rest(x)
        crossing = self._crossing(rest) if self._are_fixed([*xs, *ys]) else None
        where = _cases([apply(ca.OP_LT, crossing.value, at) if crossing else self.compare("<", rest, at) for at in xs], xs)
        found = [_in_force(where, column) for column in columns]
        if crossing:
            key, arguments = (crossing.number, *(self._key(entry) for entry in (*xs, *ys))), crossing.arguments(xs)
            found = [self._mode(("lines", k, key), value, arguments, crossing.kind) for k, value in enumerate(found)]
        place, value, slope = found
        return value + (x - place) * slope, lambda: slope

    def _at_rest(self, x: Scalar) -> Scalar:
        """What decides about conditions."""
        return x

    def _are_fixed(self, values: list[Scalar]) -> bool:
        """Whether they depend on parameters alone."""
        moving = self._moving | self.index.hashes | {self.time.__hash__()}
        return moving.isdisjoint(symbols_in(ca.vertcat(ca.SX(0, 1), *values)))

    def _key(self, value: Scalar) -> Hashable:
        """The same for what says the same, of numbers and of expressions of parameters."""
        return ("expression", self._number(value)) if isinstance(value, ca.SX) else float(value)

    def _crossing(self, value: Scalar) -> "_Crossing | None":
        """Of what depends on time, and on nothing else that changes, in such a way that its crossings can be computed. None for
        all else: what depends on other modes crosses at other times in each segment and stays a plain condition."""
        if not isinstance(value, ca.SX):
            return None
        hashes = symbols_in(value)
        if not hashes.isdisjoint(self._moving):
            return None
        if hashes.isdisjoint(self.index.hashes):
            is_timed = self.time.__hash__() in hashes and self._is_straight(value)
            return _Crossing(self._number(value), value, value) if is_timed else None
        floor, *others = [mode for mode in self.index.modes if mode.symbol.__hash__() in hashes]
        straight, step = ca.substitute(value, floor.symbol, ca.SX(0)), ca.jacobian(value, floor.symbol)
        if others or floor.value.op() != ca.OP_FLOOR or ca.depends_on(step, ca.vertcat(self.time, floor.symbol)):
            return None
        if not self._is_straight(straight):
            return None
        return _Crossing(self._number(value), ca.substitute(value, floor.symbol, floor.value), straight, step, floor.arguments)

    def _is_straight(self, value: ca.SX) -> bool:
        """a + b t; a slope does not tell of jumps."""
        steps = uses(ca.Function("value", ca.symvar(value), [value]), STEPS)
        return not steps and not ca.depends_on(ca.jacobian(value, self.time), self.time)

    def _number(self, value: ca.SX) -> int:
        symbols = ca.symvar(value)
        return self.index.number(ca.Function("value", symbols, [value]), symbols)

    @cached_property
    def _moving(self) -> frozenset[int]:
        return frozenset(x.__hash__() for x in self.state.elements())

    def _mode(self, key: Hashable, value: ca.SX, arguments: Sequence[ca.SX], kind: int) -> ca.SX:
        if key not in self.index.symbols:
            made = self.index.symbols[key] = make_symbol(f"d_{len(self.modes)}")
            self.index.hashes.add(made.__hash__())
            mode = Mode(made, value, arguments, kind)
            self.modes.append(mode)
            self.index.modes.append(mode)
        return self.index.symbols[key]


def _slopes(xs: Sequence[Scalar], ys: Sequence[Scalar]) -> list[Scalar]:
    return [(d - c) / (b - a) for a, b, c, d in zip(xs, xs[1:], ys, ys[1:], strict=False)]


def nested_lines(algebra: Algebra, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
    """Algebra.lines, one choice in the other."""
    slopes = _slopes(xs, ys)

    def choose(pieces: Sequence[Scalar], before: Scalar, after: Scalar) -> Scalar:
        for at, piece in zip(reversed(xs[1:]), reversed(pieces), strict=True):
            after = algebra.choose(algebra.compare("<", x, at), piece, after)
        return algebra.choose(algebra.compare("<", x, xs[0]), before, after)

    lines = [y + (x - at) * slope for at, y, slope in zip(xs, ys, slopes, strict=False)]
    return choose(lines, ys[0], ys[-1]), lambda: choose(slopes, 0.0, 0.0)


def _cases(less: list[Scalar], xs: Sequence[Scalar]) -> list[Scalar]:
    """Which point x is first less than: one condition each, the last where there is none. Parameters may make points fall."""
    if not all(isinstance(at, _NUMBERS) for at in xs):
        less = list(accumulate(less, lambda a, b: apply(ca.OP_OR, a, b)))
    return [less[0], *(b - a for a, b in pairwise(less)), apply_to_one(ca.OP_NOT, less[-1])]


def _in_force(where: list[Scalar], column: list[Scalar]) -> Scalar:
    """What stands in the column where a condition holds. No choice is in another one: what is made of them grows with the column,
    not with its square."""
    pieces = [apply(ca.OP_IF_ELSE_ZERO, here, x) for here, x in zip(where, column, strict=True) if not is_zero(x)]
    return reduce(lambda a, b: a + b, pieces, as_expression(0.0))


STEPS = frozenset(getattr(ca, f"OP_{name}") for name in ("FLOOR", "CEIL", "SIGN", "FMOD", "COPYSIGN", "LT", "LE", "EQ", "NE",
                                                         "IF_ELSE_ZERO"))
CORNERS = STEPS | {ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX}


def uses(function: ca.Function, operations: frozenset[int]) -> bool:
    """Whether one of CasADi's operations is among a function's instructions."""
    return not operations.isdisjoint(function.instruction_id(k) for k in range(function.n_instructions()))


_SX_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: partial(apply_to_one, getattr(ca, f"OP_{name.upper()}")) for name in (
        "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "log", "sqrt",
        "floor", "ceil", "sign")},
    **{name: partial(apply, getattr(ca, f"OP_{name.upper()}")) for name in ("fmin", "fmax", "atan2")},
    "abs": partial(apply_to_one, ca.OP_FABS), "log10": lambda x: as_expression(ca.log10(x)),
    "pow": lambda a, b: as_expression(a**b),
}
_COMPARE: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "<>": lambda a, b: a != b,
}
_FLOAT_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "abs": abs, "fmin": min, "fmax": max, "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
    "floor": lambda x: float(math.floor(x)), "ceil": lambda x: float(math.ceil(x)),
    "pow": math.pow,
}


def _call_float(function: str, *arguments: float) -> float:
    """Raises ValueError or ArithmeticError outside the function's domain."""
    chosen = _FLOAT_FUNCTIONS.get(function) or getattr(math, function)
    return float(chosen(*arguments))


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
    return isinstance(x, _NUMBERS) and x == 0


def plus(a: Scalar, b: Scalar) -> Scalar:
    return b if is_zero(a) else a if is_zero(b) else a + b


def minus(a: Scalar, b: Scalar) -> Scalar:
    return a if is_zero(b) else -b if is_zero(a) else a - b


def times(a: Scalar, b: Scalar) -> Scalar:
    if isinstance(a, _NUMBERS):
        return 0.0 if a == 0 else b if a == 1 else a * b
    if isinstance(b, _NUMBERS):
        return 0.0 if b == 0 else a if b == 1 else a * b
    return a * b


def value_of(x: Scalar) -> Scalar:
    return x.value if isinstance(x, Dual) else x


def rate_of(x: Scalar) -> Scalar:
    return x.rate if isinstance(x, Dual) else 0.0


@dataclass(frozen=True)
class DualAlgebra:
    """Duals over the scalars of `base`: every function carries its derivative along."""

    base: Algebra

    @property
    def tiny(self) -> float:
        return self.base.tiny

    @property
    def most_points(self) -> float:
        return self.base.most_points

    def number(self, value: float) -> Scalar:
        return self.base.number(value)

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        if not any(isinstance(a, Dual) for a in arguments):
            return self.base.call(function, *arguments)
        values, rates = [value_of(a) for a in arguments], [rate_of(a) for a in arguments]
        if function in ("fmin", "fmax"):
            first = self.base.compare("<" if function == "fmin" else ">", *values)
            return Dual(self.base.call(function, *values), self.base.choose(first, *rates))
        value = self.base.call(function, *values)
        partials = _PARTIALS[function](self.base, value, *values)
        total: Scalar = 0.0
        for slope, rate in zip(partials, rates, strict=True):
            total = plus(total, times(slope() if not is_zero(rate) else 0.0, rate))
        return Dual(value, total)

    def compare(self, operator: str, a: Scalar, b: Scalar) -> Scalar:
        return self.base.compare(operator, value_of(a), value_of(b))

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        if not isinstance(then, Dual) and not isinstance(otherwise, Dual):
            return self.base.choose(condition, then, otherwise)
        rates = rate_of(then), rate_of(otherwise)
        rate = 0.0 if is_zero(rates[0]) and is_zero(rates[1]) else self.base.choose(condition, *rates)
        return Dual(self.base.choose(condition, value_of(then), value_of(otherwise)), rate)

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        return self.base.logic(operator, *(value_of(c) for c in conditions))

    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        value, slope = self.base.lines(value_of(x), xs, ys)
        return Dual(value, times(slope(), rate_of(x)) if not is_zero(rate_of(x)) else 0.0), slope


@dataclass(frozen=True)
class GlidingAlgebra(DualAlgebra):
    """Duals in which modes have rates, as if what jumps at a time event went over evenly. `glide`: of a value, the rate that the
    modes in it give it. Tables do not jump."""

    glide: Callable[[Scalar], Scalar]

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        if function == "mod":
            a, b = arguments
            return a - b * self.call("floor", a / b)
        found = super().call(function, *arguments)
        return self._gliding(value_of(found), rate_of(found)) if function in ("floor", "ceil") else found

    def compare(self, operator: str, a: Scalar, b: Scalar) -> Scalar:
        return self._gliding(super().compare(operator, a, b), 0.0)

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        chosen = super().choose(value_of(condition), then, otherwise)
        more = times(rate_of(condition), minus(value_of(then), value_of(otherwise)))
        return chosen if is_zero(more) else Dual(value_of(chosen), plus(rate_of(chosen), more))

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        if operator == "not":
            return 1.0 - conditions[0]
        a, b = conditions
        return a * b if operator == "and" else a + b - a * b

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
    "abs": lambda g, f, x: [lambda: g.call("sign", x)],
    "sign": lambda g, f, x: [lambda: 0.0],
    "floor": lambda g, f, x: [lambda: 0.0],
    "ceil": lambda g, f, x: [lambda: 0.0],
    "atan2": lambda g, f, y, x: [lambda: x / (x * x + y * y), lambda: -y / (x * x + y * y)],
    "mod": lambda g, f, a, b: [lambda: 1.0, lambda: -g.call("floor", a / b)],
    "pow": lambda g, f, a, b: [lambda: b * g.call("pow", a, b - 1), lambda: f * g.call("log", a)],
}
