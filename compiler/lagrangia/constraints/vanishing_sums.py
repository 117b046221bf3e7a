"""Sums that are nowhere negative, and equations that ask them to vanish: a length of 0, x^2 + y^2 = 0, |x| + |y| = 0.

Such an equation has no slopes where it holds, though it says as much as one for each of its parts: each of them vanishes, and
these have slopes. So it is with a root, sqrt(x) = 0, whose slope has no bound there.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from functools import partial
from math import isfinite, nan

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import symbols_in
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import at_declared_values, parameter_symbols
from lagrangia.constraints.rows import Constraints, Row, derived
from lagrangia.frames.kinematics import Kinematics

_NOTHING = 1e-15  # of a length, as declared
_TINY = 1e-200  # what roots are kept away from 0 with
_MOST_PARTS = 64


def split_vanishing_sums(kinematics: Kinematics, constraints: Constraints) -> Constraints | None:
    """The constraints with the parts of such sums in their places; None where there are none with the parameters as declared."""
    if not constraints.rows:
        return None
    sums, rows, found = VanishingSums(kinematics).declared, list[Row](), list[Row]()
    for row in constraints.rows:
        parts = sums.parts_of(ca.SX(row.value(kinematics, 0))) if row.is_holonomic else None
        if parts is None:
            rows.append(row)
        else:
            found.append(row)
            rows += [Row(partial(_value, part), True, None, row.span, k, row.component, row.is_timed)
                     for k, part in enumerate(parts)]
    return replace(constraints, rows=tuple(rows), touching=tuple(found)) if found else None


def _value(part: ca.SX, kinematics: Kinematics, level: int) -> Scalar:
    return derived(part, kinematics, level)


class VanishingSums:
    """Those of a scene, with the parameters as declared or whatever they are."""

    def __init__(self, kinematics: Kinematics) -> None:
        symbols = kinematics.symbols
        state = frozenset(x.__hash__() for x in (*symbols.positions.values(), *symbols.rates.values(), symbols.time)
                          ) | frozenset(x.__hash__() for x in kinematics.algebra.state.elements())
        self.declared, self.general = (_Sums(kinematics, state, is_general) for is_general in (False, True))

    def only_touches(self, gap: ca.SX) -> bool:
        """Whether a gap is such a sum with the parameters as declared alone, as x^2 + p where p is 0: it has no slopes where it
        vanishes, and cannot be taken apart, as it is another one with other parameters."""
        return self.declared.parts_of(gap) is not None and self.general.parts_of(gap) is None


@dataclass(frozen=True)
class _Sums:
    """With the parameters as declared, or where it `is_general` with none."""

    kinematics: Kinematics
    state: frozenset[int]  # hashes of what moves
    is_general: bool

    def parts_of(self, gap: ca.SX) -> list[ca.SX] | None:
        """What vanishes with it, each a function of positions; None where it is no such sum, or cannot vanish."""
        parts = self._vanishing(gap)
        if not parts:
            return None
        fixed = [x for x in parts if not self._moves(x)]
        if not all(abs(self._number(x)) <= _NOTHING for x in fixed):
            return None
        return [x for x in parts if self._moves(x)] or None

    def _vanishing(self, total: ca.SX) -> list[ca.SX] | None:
        """The parts of a sum of one sign, which vanishes with all of them."""
        found, signs, constant = list[ca.SX](), set[int](), ca.SX(0)
        terms = list(_terms(total))
        if len(terms) == 1 and (scaled := self._scaled(terms[0][1])) is not None:
            return scaled
        for sign, term in terms:
            parts = self._parts(term)
            if parts is None and self._moves(term):
                return None
            if parts is None:
                constant += sign * term
            else:
                signs.add(sign)
                found += parts
            if len(signs) > 1 or len(found) > _MOST_PARTS:
                return None
        return found if found and abs(self._number(constant)) <= _NOTHING else None

    def _parts(self, term: ca.SX) -> list[ca.SX] | None:
        """Those that vanish with a term that is nowhere negative; None for another, and for one that does not move."""
        if term.is_symbolic() or term.is_constant() or term.n_dep() == 0:
            return None
        op, first = term.op(), term.dep(0)
        if op in (ca.OP_SQ, ca.OP_FABS, ca.OP_SQRT):
            return self._vanishing(first) or [first]
        if op == ca.OP_TWICE:
            return self._vanishing(first)
        if op not in (ca.OP_MUL, ca.OP_DIV):
            return None
        second = term.dep(1)
        for factor, other in ((first, second), (second, first))[op == ca.OP_DIV :]:
            if not self._moves(factor):
                return self._vanishing(other) if self._number(factor) > 0 else None
        return [first] if op == ca.OP_MUL and ca.is_equal(first, second, 1) else None

    def _scaled(self, term: ca.SX) -> list[ca.SX] | None:
        """Of a single term with a factor of parameters, which may be 0 or negative: the parts of the rest, times that."""
        if term.is_symbolic() or term.is_constant() or term.op() not in (ca.OP_MUL, ca.OP_DIV):
            return None
        pairs = ((term.dep(0), term.dep(1)), (term.dep(1), term.dep(0)))[term.op() == ca.OP_DIV :]
        for factor, other in pairs:
            if not self._moves(factor) and self._moves(other) and not isfinite(self._number(factor)):
                parts = self._vanishing(other)
                return None if parts is None else [x * factor if term.op() == ca.OP_MUL else x / factor for x in parts]
        return None

    def _moves(self, x: ca.SX) -> bool:
        return not self.state.isdisjoint(symbols_in(x))

    def _number(self, x: ca.SX) -> float:
        """NaN where it is none yet."""
        if x.is_constant():
            return float(x)
        if self.is_general and ca.depends_on(x, parameter_symbols(self.kinematics)):
            return nan
        return float(ca.evalf(at_declared_values(self.kinematics, [x])[0]))


def _terms(total: ca.SX, sign: int = 1) -> Iterator[tuple[int, ca.SX]]:
    """Of a sum, with their signs; without what keeps roots away from 0."""
    pending: Sequence[tuple[int, ca.SX]] = [(sign, total)]
    while pending:
        (sign, x), *pending = pending
        op = x.op() if not (x.is_symbolic() or x.is_constant()) else None
        if op in (ca.OP_ADD, ca.OP_SUB):
            pending = [(sign, x.dep(0)), (sign if op == ca.OP_ADD else -sign, x.dep(1)), *pending]
        elif op == ca.OP_NEG:
            pending = [(-sign, x.dep(0)), *pending]
        elif not (x.is_constant() and abs(float(x)) <= _TINY):
            yield sign, x
