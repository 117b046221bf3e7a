"""Functions of time as sums of waves: t^k exp(E) (c cos(A) + s sin(A)), with E and A of degree one in t.

Such a sum solves a linear differential equation with constant coefficients, so a scene that is linear but for it is linear as a
whole. Constants, polynomials, (decaying) sines and cosines and their products are of this kind; between time events also
what is made of pieces of them.
"""

from collections.abc import Callable, Mapping
from dataclasses import field
from typing import Any

import casadi as ca

from lagrangia.algebra.scalars import apply, apply_to_one
from lagrangia.base.records import dataclass

_LARGEST_DEGREE = 8
DEPTH = 12  # of the comparison of two expressions


class NotAWave(Exception):
    """The function of time is none of these; the message says why."""


@dataclass(frozen=True)
class Wave:
    """exp(exponent) times the cosine and sine of `angle`; None stands for zero."""

    exponent: ca.SX | None
    angle: ca.SX | None


Sum = dict[tuple[int, int], tuple[ca.SX, ca.SX]]  # (wave, power of t) -> factors of cosine and sine
_ZERO = ca.SX(0)


@dataclass
class Waves:
    """The waves found so far; the first one is the constant 1."""

    t: ca.SX
    found: list[Wave] = field(default_factory=lambda: [Wave(None, None)])

    def place(self, exponent: ca.SX | None, angle: ca.SX | None) -> int:
        """The number of a wave, a new one where it has not been found before."""
        for k, wave in enumerate(self.found):
            if _same(wave.exponent, exponent) and _same(wave.angle, angle):
                return k
        self.found.append(Wave(exponent, angle))
        return len(self.found) - 1

    def decompose(self, loads: ca.SX, constants: list[ca.SX]) -> list[Sum]:
        """Each of the functions of t and of the symbols `constants` as a sum of waves. Raises NotAWave."""
        arguments = [self.t, *constants]
        function = ca.Function("loads", arguments, [ca.densify(loads)])
        elements = [ca.vertsplit(ca.vec(x)) if x.numel() else [] for x in arguments]
        work: dict[int, Term] = {}
        results: list[Sum] = [{} for _ in range(loads.numel())]
        for k in range(function.n_instructions()):
            op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if op == ca.OP_INPUT:
                value = elements[inputs[0]][inputs[1]]
                work[outputs[0]] = Term(value, {(0, 1): (ca.SX(1), _ZERO)}) if inputs[0] == 0 else constant(value)
            elif op == ca.OP_OUTPUT:
                results[outputs[1]] = work[inputs[0]].sum
            elif op == ca.OP_CONST:
                work[outputs[0]] = constant(ca.SX(function.instruction_constant(k)))
            else:
                work[outputs[0]] = self._combine(op, [work[i] for i in inputs])
        return results

    def _combine(self, op: int, terms: "list[Term]") -> "Term":
        values = [term.value for term in terms]
        value = apply_to_one(op, values[0]) if len(values) == 1 else apply(op, *values)
        if all(term.is_constant for term in terms):
            return constant(value)
        if op not in _RULES:
            raise NotAWave(f"'{_name(op)}' of the time is no polynomial, sine or exponential")
        found = {key: pair for key, pair in _RULES[op](self, *terms).items() if not all(x.is_zero() for x in pair)}
        if any(power > _LARGEST_DEGREE for _, power in found):
            raise NotAWave(f"a power of the time above {_LARGEST_DEGREE}")
        if not found.keys() - {(0, 0)}:  # time has cancelled, in what the value is but not as it is written
            return constant(found.get((0, 0), (_ZERO, _ZERO))[0])
        return Term(value, found)

    def slope(self, x: ca.SX | None) -> ca.SX:
        """d/dt of an exponent or an angle, zero for None."""
        return _ZERO if x is None else ca.densify(ca.jacobian(x, self.t))


@dataclass(frozen=True)
class Term:
    """A node: its expression, and the sum of waves it is."""

    value: ca.SX
    sum: Sum

    @property
    def is_constant(self) -> bool:
        """Whether it is made of the constant wave alone."""
        return all(key == (0, 0) for key in self.sum)


def constant(value: ca.SX) -> Term:
    """A term without waves."""
    return Term(value, {} if value.is_zero() else {(0, 0): (value, _ZERO)})


def _same(a: ca.SX | None, b: ca.SX | None) -> bool:
    return a is b if a is None or b is None else ca.is_equal(a, b, DEPTH)


def _name(op: int) -> str:
    names = (name for name in dir(ca) if name.startswith("OP_") and getattr(ca, name) == op)
    return next(names, "OP_?").removeprefix("OP_").lower()


def _scaled(a: Term, factor: Callable[[ca.SX], ca.SX]) -> Sum:
    return {key: (factor(c), factor(s)) for key, (c, s) in a.sum.items()}


def _added(a: Sum, b: Sum) -> Sum:
    total = dict(a)
    for key, (c, s) in b.items():
        before = total.get(key)
        total[key] = (c, s) if before is None else (before[0] + c, before[1] + s)
    return total


def _add(waves: Waves, a: Term, b: Term) -> Sum:
    return _added(a.sum, b.sum)


def _subtract(waves: Waves, a: Term, b: Term) -> Sum:
    return _added(a.sum, _scaled(b, lambda x: -x))


def _multiply(waves: Waves, a: Term, b: Term) -> Sum:
    """cos x cos y = (cos(x - y) + cos(x + y))/2 and so on."""
    total: Sum = {}
    for (i, k), first in a.sum.items():
        for (j, m), second in b.sum.items():
            one, two = waves.found[i], waves.found[j]
            exponent = _plus(one.exponent, two.exponent)
            for angle, pair in _products(one.angle, two.angle, first, second):
                total = _added(total, {(waves.place(exponent, angle), k + m): pair})
    return total


def _products(x: ca.SX | None, y: ca.SX | None, first: tuple[ca.SX, ca.SX],
              second: tuple[ca.SX, ca.SX]) -> list[tuple[ca.SX | None, tuple[ca.SX, ca.SX]]]:
    (c1, s1), (c2, s2) = first, second
    if y is None:
        return [(x, (c1 * c2, s1 * c2))]
    if x is None:
        return [(y, (c1 * c2, c1 * s2))]
    difference = None if _same(x, y) else x - y
    return [(difference, ((c1 * c2 + s1 * s2) / 2, _ZERO if difference is None else (s1 * c2 - c1 * s2) / 2)),
            (x + y, ((c1 * c2 - s1 * s2) / 2, (s1 * c2 + c1 * s2) / 2))]


def _plus(a: ca.SX | None, b: ca.SX | None) -> ca.SX | None:
    return b if a is None else a if b is None else a + b


def _divide(waves: Waves, a: Term, b: Term) -> Sum:
    if not b.is_constant:
        raise NotAWave("it divides by a function of the time")
    return _scaled(a, lambda x: x / b.value)


def _power(waves: Waves, a: Term, b: Term) -> Sum:
    exponent = float(b.value) if b.value.is_constant() else 0.5
    if exponent != int(exponent) or not 1 <= exponent <= _LARGEST_DEGREE:
        raise NotAWave("a power of a function of the time that is no small whole number")
    total = a
    for _ in range(int(exponent) - 1):
        total = Term(total.value, _multiply(waves, total, a))
    return total.sum


def _select(waves: Waves, a: Term, b: Term) -> Sum:
    if not a.is_constant:
        raise NotAWave("a condition on the time whose moment is not known beforehand")
    return _scaled(b, lambda x: apply(ca.OP_IF_ELSE_ZERO, a.value, x))


def _argument(waves: Waves, a: Term) -> ca.SX:
    if any(wave != 0 or power > 1 for wave, power in a.sum):
        raise NotAWave("a sine or an exponential whose argument is not a + b t")
    return a.value


def _sine(waves: Waves, a: Term) -> Sum:
    return {(waves.place(None, _argument(waves, a)), 0): (_ZERO, ca.SX(1))}


def _cosine(waves: Waves, a: Term) -> Sum:
    return {(waves.place(None, _argument(waves, a)), 0): (ca.SX(1), _ZERO)}


def _exponential(waves: Waves, a: Term) -> Sum:
    return {(waves.place(_argument(waves, a), None), 0): (ca.SX(1), _ZERO)}


_RULES: Mapping[int, Callable[..., Any]] = {
    ca.OP_ASSIGN: lambda waves, a: a.sum,
    ca.OP_ADD: _add, ca.OP_SUB: _subtract, ca.OP_MUL: _multiply, ca.OP_DIV: _divide, ca.OP_CONSTPOW: _power, ca.OP_POW: _power,
    ca.OP_NEG: lambda waves, a: _scaled(a, lambda x: -x), ca.OP_TWICE: lambda waves, a: _scaled(a, lambda x: 2 * x),
    ca.OP_SQ: lambda waves, a: _multiply(waves, a, a), ca.OP_IF_ELSE_ZERO: _select,
    ca.OP_SIN: _sine, ca.OP_COS: _cosine, ca.OP_EXP: _exponential,
}
