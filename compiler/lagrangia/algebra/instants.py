"""When what is no straight line of time is 0, in closed form: polynomials up to cubic ones, as inputs are
between two rows, and what can be turned round step by step.

exp(u) = y where u = log(y), u^2 = y where u is either root, and so on down to a straight line u = a + b t. Where there is no
such time, as that of u^2 = -1, a time is told at which nothing happens, or one that is no number or infinite, which never comes.
"""

from collections.abc import Callable, Mapping, Sequence
from itertools import accumulate

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.records import dataclass

_CORRECTIONS = 3
Found = tuple[list[ca.SX], list[ca.SX]]  # straight lines that are 0 there, and phases that are whole numbers there
Waves = Callable[[ca.SX], list[ca.SX]]  # phases of a wave; nothing of all else


def _root(y: ca.SX) -> ca.SX:
    return ca.sqrt(ca.fmax(y, 0))


def _nearest(y: ca.SX) -> ca.SX:
    return ca.floor(y + 0.5)


_INVERSES: Mapping[int, Callable[[ca.SX], list[ca.SX]]] = {  # u of f(u) = y
    ca.OP_NEG: lambda y: [-y], ca.OP_TWICE: lambda y: [y / 2], ca.OP_INV: lambda y: [1 / y],
    ca.OP_SQ: lambda y: [_root(y), -_root(y)], ca.OP_SQRT: lambda y: [y * y], ca.OP_EXP: lambda y: [ca.log(ca.fmax(y, 0))],
    ca.OP_LOG: lambda y: [ca.exp(y)], ca.OP_ATAN: lambda y: [ca.tan(y)], ca.OP_SINH: lambda y: [ca.asinh(y)],
    ca.OP_TANH: lambda y: [ca.atanh(ca.fmax(ca.fmin(y, 1), -1))],
    ca.OP_COSH: lambda y: [ca.acosh(ca.fmax(y, 1)), -ca.acosh(ca.fmax(y, 1))],
    ca.OP_FLOOR: lambda y: [_nearest(y), _nearest(y) + 1],  # from where on it is y, or more than y
    ca.OP_CEIL: lambda y: [_nearest(y) - 1, _nearest(y)],
}


@dataclass(frozen=True)
class Instants:
    """Looks for times: `is_straight` tells a + b t, `jumps` what time makes jump, which no slope tells, `phases_of` those of
    waves."""

    time: ca.SX
    numbering: Numbering
    is_straight: Callable[[ca.SX], bool]
    jumps: Callable[[ca.SX], bool]
    phases_of: Waves
    places: Sequence[ca.SX] = ()  # from which pieces of inputs count time

    def of(self, x: ca.SX, y: ca.SX) -> Found | None:
        """Where x = y, which time does not change; None where that is not known. What time does not change is never there."""
        if not ca.depends_on(x, self.time):
            return [], []
        if self.is_straight(x):
            return [x - y], []
        if self.jumps(x):
            return self._of_parts(x, y)
        if phases := self.phases_of(x - y):
            return ([], phases) if all(map(self.is_straight, phases)) else None
        bend = ca.jacobian(ca.jacobian(x, self.time), self.time)
        if self.is_straight(bend) and not ca.depends_on(ca.jacobian(bend, self.time), self.time):
            return [self.time - t for t in self._of_polynomial(x - y, ca.depends_on(bend, self.time))], []
        return self._of_parts(x, y)

    def _of_parts(self, x: ca.SX, y: ca.SX) -> Found | None:
        if x.n_dep() == 1:
            return self._all([(x.dep(0), u) for u in _INVERSES[x.op()](y)]) if x.op() in _INVERSES else None
        return self._of_two(x, y) if x.n_dep() == 2 else None

    def _all(self, asked: list[tuple[ca.SX, ca.SX]]) -> Found | None:
        lines, phases = list[ca.SX](), list[ca.SX]()
        for x, y in asked:
            found = self.of(x, y)
            if found is None:
                return None
            lines, phases = lines + found[0], phases + found[1]
        return lines, phases

    def _of_polynomial(self, x: ca.SX, is_cubic: bool) -> list[ca.SX]:
        """Of a parabola, or of what may be a parabola or a cubic one: some of these times mean nothing."""
        known = symbols_in(x)
        begin = next((place for place in self.places if place.__hash__() in known), ca.SX(0))
        slopes = accumulate(range(1, 4), lambda of, k: ca.jacobian(of, self.time) / k, initial=x)
        c, b, a, third = (ca.substitute(slope, self.time, begin) for slope in slopes)
        half = -(b + ca.if_else(b < 0, -1, 1) * _root(b * b - 4 * a * c)) / 2
        found = [half / a, c / half]
        if is_cubic:
            found = [_closer(t, c, b, a, third) for t in (*found, *_roots_of_cubic(c / third, b / third, a / third))]
        return [begin + t for t in found]

    def _of_two(self, x: ca.SX, y: ca.SX) -> Found | None:
        first, second = x.dep(0), x.dep(1)
        if x.op() == ca.OP_MUL and ca.depends_on(first, self.time) and ca.depends_on(second, self.time):
            return self._of_product(first, second, y)
        if ca.depends_on(second, self.time):
            turned = {ca.OP_ADD: y - first, ca.OP_SUB: first - y, ca.OP_MUL: y / first, ca.OP_DIV: first / y}
            asked = [] if ca.depends_on(first, self.time) or x.op() not in turned else [(second, turned[x.op()])]
            if not asked and x.op() == ca.OP_DIV and y.is_zero():
                asked = [(first, y)]
            return self._all(asked) if asked else None
        turned = {ca.OP_ADD: y - second, ca.OP_SUB: y + second, ca.OP_MUL: y / second, ca.OP_DIV: y * second}
        if x.op() in (ca.OP_POW, ca.OP_CONSTPOW):
            size = ca.fabs(y) ** (1 / second)
            return self._all([(first, size), (first, -size)])
        return self._all([(first, turned[x.op()])]) if x.op() in turned else None

    def _of_product(self, first: ca.SX, second: ca.SX, y: ca.SX) -> Found | None:
        """0 where a factor is; and u u^2."""
        if y.is_zero():
            return self._all([(factor, y) for factor in (first, second) if factor.op() != ca.OP_EXP])
        for u, square in ((first, second), (second, first)):
            if square.op() == ca.OP_SQ and self.numbering.number(square.dep(0)) == self.numbering.number(u):
                return self._all([(u, ca.if_else(y < 0, -1, 1) * ca.fabs(y) ** (1 / 3))])
        return None


def _roots_of_cubic(c: ca.SX, b: ca.SX, a: ca.SX) -> list[ca.SX]:
    """Of t^3 + a t^2 + b t + c, by Cardano where there is one, and by Vieta where there are three; both are told."""
    shift = a / 3
    p, q = b / 3 - shift**2, shift**3 - shift * b / 2 + c / 2
    w = -q - ca.if_else(q < 0, -1, 1) * _root(q * q + p * p * p)
    single = ca.if_else(w < 0, -1, 1) * ca.fabs(w) ** (1 / 3)
    size = _root(-p)
    angle = ca.acos(ca.fmax(ca.fmin(-q / size**3, 1), -1)) / 3
    return [single - p / single - shift, *(2 * size * ca.cos(angle - 2 * ca.pi * k / 3) - shift for k in range(3))]


def _closer(t: ca.SX, c: ca.SX, b: ca.SX, a: ca.SX, third: ca.SX) -> ca.SX:
    """By Newton, where closed forms lose digits: a cubic one may be a parabola but for rounding."""
    for _ in range(_CORRECTIONS):
        t -= (c + t * (b + t * (a + t * third))) / (b + t * (2 * a + t * 3 * third))
    return t
