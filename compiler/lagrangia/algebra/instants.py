"""When what is no straight line of time is 0, in closed form: parabolas, and what can be turned round step by step.

exp(u) = y where u = log(y), u^2 = y where u is either root, and so on down to a straight line u = a + b t. Where there is no
such time, as that of u^2 = -1, a time is told at which nothing happens, or one that is no number or infinite, which never comes.
"""

from collections.abc import Callable, Mapping

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.base.records import dataclass

Found = tuple[list[ca.SX], list[ca.SX]]  # straight lines that are 0 there, and phases that are whole numbers there
Waves = Callable[[ca.SX], list[ca.SX]]  # phases of a wave; nothing of all else


def _root(y: ca.SX) -> ca.SX:
    return ca.sqrt(ca.fmax(y, 0))


_INVERSES: Mapping[int, Callable[[ca.SX], list[ca.SX]]] = {  # u of f(u) = y
    ca.OP_NEG: lambda y: [-y], ca.OP_TWICE: lambda y: [y / 2], ca.OP_INV: lambda y: [1 / y],
    ca.OP_SQ: lambda y: [_root(y), -_root(y)], ca.OP_SQRT: lambda y: [y * y], ca.OP_EXP: lambda y: [ca.log(ca.fmax(y, 0))],
    ca.OP_LOG: lambda y: [ca.exp(y)], ca.OP_ATAN: lambda y: [ca.tan(y)], ca.OP_SINH: lambda y: [ca.asinh(y)],
    ca.OP_TANH: lambda y: [ca.atanh(ca.fmax(ca.fmin(y, 1), -1))],
    ca.OP_COSH: lambda y: [ca.acosh(ca.fmax(y, 1)), -ca.acosh(ca.fmax(y, 1))],
}


@dataclass(frozen=True)
class Instants:
    """Looks for times: `is_straight` tells a + b t, `phases_of` those of waves."""

    time: ca.SX
    numbering: Numbering
    is_straight: Callable[[ca.SX], bool]
    phases_of: Waves

    def of(self, x: ca.SX, y: ca.SX) -> Found | None:
        """Where x = y, which time does not change; None where that is not known. What time does not change is never there."""
        if not ca.depends_on(x, self.time):
            return [], []
        if self.is_straight(x):
            return [x - y], []
        if phases := self.phases_of(x - y):
            return ([], phases) if all(map(self.is_straight, phases)) else None
        bend = ca.jacobian(ca.jacobian(x, self.time), self.time)
        if self.is_straight(bend) and not ca.depends_on(bend, self.time):
            return [self.time - t for t in self._of_parabola(x, y, bend / 2)], []
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

    def _of_parabola(self, x: ca.SX, y: ca.SX, a: ca.SX) -> list[ca.SX]:
        """a t^2 + b t + c = 0, without differences of what is nearly the same."""
        b, c = (ca.substitute(value, self.time, ca.SX(0)) for value in (ca.jacobian(x, self.time), x - y))
        half = -(b + ca.if_else(b < 0, -1, 1) * _root(b * b - 4 * a * c)) / 2
        return [half / a, c / half]

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
