"""Conditions that are met in another shape: of what was found in forces, in themselves and in the reactions that they make.

sign(-x) is -sign(x), abs(x/c) is that of x for any parameter c, and x - y is -(y - x): of rates these have one switch, as two
would not change at the same time. That of c x, or c x + d x, is the one of x, too, whatever c and d are of what does not change
between events; where c, or c + d, is 0, neither is positive or negative. Of reactions sums are the same in any order: by their
values at random states, x of one is x of the other but for a factor.
"""

from collections.abc import Mapping, Set

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import Expression, as_expression, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, operations_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.driven_conditions import Pair
from lagrangia.dynamics.held_switches import ordered

_NONE = ca.SX(0, 1)
_LOOKS, _SAME = 4, 1e-9
_SAME_DEPTH = 9  # of instructions that are compared one by one: deeper ones are the same where they are one object
_MOST_ADDENDS = 16  # open at once, of those with a common part


@dataclass(frozen=True)
class Multiple:
    """A condition that is another one, whose difference is `bare`, but for a factor."""

    of: Pair
    bare: Expression
    factor: Expression
    may_vanish: bool = False  # whether the factor may be 0
    signs: tuple[Pair, Pair] | None = None  # whether the factor is positive, or negative, where it changes between events

    def switch(self, places: Mapping[Pair, Expression]) -> Expression:
        """By that of the other; half of it where there is nothing to compare."""
        s = places[self.of]
        if self.signs is not None:
            positive, negative = (places[pair] for pair in self.signs)
            return as_expression(0.5 + (positive - negative) * (s - 0.5))
        found = ca.if_else(self.factor > 0, s, 1.0 - s)
        return as_expression(ca.if_else(self.is_nothing(places), 0.5, found) if self.may_vanish else found)

    def rests(self, rest: Expression, places: Mapping[Pair, Expression]) -> Expression:
        """Whether it is held at 0, by whether the other is."""
        return as_expression(ca.logic_or(self.is_nothing(places), rest)) if self.may_vanish else rest

    def is_nothing(self, places: Mapping[Pair, Expression]) -> Expression:
        """Whether the factor is 0."""
        if self.signs is not None:
            return as_expression(1.0 - places[self.signs[0]] - places[self.signs[1]])
        return as_expression(self.factor == 0)


Same = dict[Pair, Multiple]


def multiples(found: Mapping[Pair, Expression], v: ca.SX, constant: ca.SX, numbering: Numbering, driven: ca.SX = _NONE) -> Same:
    """Of conditions, those that are another one, or one that is not among them, but for a factor of what is `constant` between
    events, or `driven`; where it cannot be 0, of rates alone."""
    rates, symbols, same = symbols_in(v) - symbols_in(constant), symbols_in(ca.vertcat(constant, driven)), Same()
    found = {pair: g for pair, g in found.items() if not symbols_in(g) <= symbols or symbols_in(g) <= symbols_in(constant)}
    apart = {pair: without_factors(g, symbols) for pair, g in found.items()}
    vanishing = [pair for pair, (_, _, may_vanish) in apart.items() if may_vanish]
    wanted = [pair for pair, g in found.items() if vanishing or not rates.isdisjoint(symbols_in(g))]
    first = dict[tuple[int, ...], tuple[Pair, Expression]]()
    smooth = [pair for pair in wanted if not bends_by(CORNERS, found[pair], symbols, numbering)]
    for pair in sorted(smooth, key=vanishing.__contains__):
        bare, factor, may_vanish = apart[pair]
        key, sign = _key(bare, numbering)
        if key not in first and may_vanish:
            number, zero = numbering.number(bare), numbering.of_number(0.0)
            first[key] = ordered(number, zero), as_expression(sign if number < zero else -sign)
        of, other = first.setdefault(key, (pair, as_expression(factor * sign)))
        if of != pair and (may_vanish or not rates.isdisjoint(symbols_in(bare))):
            same[pair] = Multiple(of, as_expression(bare * sign * other), as_expression(factor * sign * other), may_vanish)
    return same


def without_factors(g: Expression, constant: frozenset[int], of_sums: bool = True) -> tuple[Expression, Expression, bool]:
    """g but for a factor, that factor, and whether it may be 0."""
    factor, may_vanish = as_expression(1.0), False
    while g.n_dep():
        known = [symbols_in(g.dep(k)) <= constant for k in range(2)] if g.op() in (ca.OP_MUL, ca.OP_DIV) else []
        if g.op() == ca.OP_NEG:
            factor, g = -factor, g.dep(0)
        elif g.op() == ca.OP_TWICE:
            factor, g = as_expression(2 * factor), g.dep(0)
        elif g.op() == ca.OP_DIV and known[1]:
            factor, g = factor / g.dep(1), g.dep(0)
        elif g.op() == ca.OP_MUL and known[0] != known[1]:
            other = g.dep(known.index(True))
            factor, g, may_vanish = factor * other, g.dep(known.index(False)), may_vanish or not other.is_constant()
        elif of_sums and (common := _common_part(g, constant)) is not None:
            g, total = common
            factor, may_vanish = factor * total, True
        else:
            break
    return as_expression(g), as_expression(factor), may_vanish


def _common_part(g: ca.SX, constant: frozenset[int]) -> tuple[Expression, Expression] | None:
    """x and a + b - c of a x + b x - c x."""
    addends, found, total = [(g, 1.0)], as_expression(0.0), as_expression(0.0)
    while addends:
        g, sign = addends.pop()
        if g.op() in (ca.OP_ADD, ca.OP_SUB):
            addends += [(g.dep(1), sign if g.op() == ca.OP_ADD else -sign), (g.dep(0), sign)]
            if len(addends) > _MOST_ADDENDS:
                return None
            continue
        x, factor, _ = without_factors(as_expression(g), constant, False)
        if symbols_in(x) <= constant or not (found.is_zero() or ca.is_equal(x, found, _SAME_DEPTH)):
            return None
        found, total = x, as_expression(total + sign * factor)
    return None if total.is_constant() else (found, total)


def bends_by(operations: Set[int], g: Expression, constant: frozenset[int], numbering: Numbering) -> bool:
    """Whether it bends or jumps with one of the operations where something else than constants decides."""
    corners = list[int]()

    def note(op: int, _: list[int], operands: list[Expression]) -> None:
        if op in operations:
            corners.extend(symbols_in(ca.veccat(*operands[: 1 if op == ca.OP_IF_ELSE_ZERO else 2])) - constant)

    if not operations_in(g).isdisjoint(operations):
        rebuilt([g], numbering, note)
    return bool(corners)


def _key(g: Expression, numbering: Numbering) -> tuple[tuple[int, ...], float]:
    """Numbers that tell g but for its sign, and that."""
    if g.n_dep() == 0 or g.op() != ca.OP_SUB:
        return (numbering.number(g),), 1.0
    a, b = numbering.number(g.dep(0)), numbering.number(g.dep(1))
    return ((a, b), 1.0) if a < b else ((b, a), -1.0)


def match(known: Mapping[Pair, Expression], others: Mapping[Pair, Expression]) -> Same:
    """For those of `others` that are one of the `known`: which."""
    if not others:
        return {}
    values = _values([*known.values(), *others.values()])
    own, rest = values[:, : len(known)], values[:, len(known) :]
    found = Same()
    for k, pair in enumerate(others):
        for (first, own_g), column in zip(known.items(), own.T, strict=True):
            factor = rest[0, k] / column[0] if column[0] else 0.0
            if factor and np.allclose(rest[:, k], factor * column, rtol=_SAME, atol=0.0):
                found.setdefault(pair, Multiple(first, own_g, as_expression(np.sign(factor))))
    return found


def _values(expressions: list[Expression]) -> Vector:
    """At random values of all symbols, (_LOOKS, k)."""
    column = ca.vertcat(*expressions)
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(column))
    look, random = ca.Function("look", [symbols], [column]), np.random.default_rng(6)
    return np.array([np.array(look(random.uniform(0.4, 1.6, symbols.numel()))).ravel() for _ in range(_LOOKS)])
