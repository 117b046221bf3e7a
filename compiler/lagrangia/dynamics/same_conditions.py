"""Conditions that are met in another shape: of what was found in forces, in themselves and in the reactions that they make.

sign(-x) is -sign(x), abs(x/c) is that of x for any parameter c, and x - y is -(y - x): of rates these have one switch, as two
would not change at the same time. That of c x is another, as c may be 0. Of reactions sums are the same in any order: by their
values at random states, x of one is x of the other but for a factor.
"""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import Expression, as_expression, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, operations_in
from lagrangia.dynamics.held_switches import Pair

_LOOKS, _SAME = 4, 1e-9
Same = dict[Pair, tuple[Pair, Expression]]  # by conditions: another one, and what is positive where both have the same sign


def multiples(found: Mapping[Pair, Expression], v: ca.SX, p: ca.SX, numbering: Numbering) -> Same:
    """Of conditions on rates, those that are another one but for a factor of numbers and parameters."""
    rates, constant = symbols_in(v), symbols_in(p)
    first, same = dict[tuple[int, ...], tuple[Pair, Expression]](), Same()
    for pair, g in found.items():
        if not rates.isdisjoint(symbols_in(g)) and operations_in(g).isdisjoint(CORNERS):
            key, factor = _apart(g, constant, numbering)
            of, other = first.setdefault(key, (pair, factor))
            if of != pair:
                same[pair] = of, as_expression(factor * other)
    return same


def _apart(g: Expression, constant: frozenset[int], numbering: Numbering) -> tuple[tuple[int, ...], Expression]:
    """Numbers that tell g but for a factor, and a factor with the sign of that one."""
    factor = as_expression(1.0)
    while g.n_dep():
        if g.op() == ca.OP_NEG:
            factor, g = -factor, g.dep(0)
        elif g.op() == ca.OP_TWICE:
            g = g.dep(0)
        elif (g.op() == ca.OP_DIV and symbols_in(g.dep(1)) <= constant) or (g.op() == ca.OP_MUL and g.dep(1).is_constant()):
            factor, g = factor * g.dep(1), g.dep(0)
        elif g.op() == ca.OP_MUL and g.dep(0).is_constant():
            factor, g = factor * g.dep(0), g.dep(1)
        else:
            break
    if g.n_dep() == 0 or g.op() != ca.OP_SUB:
        return (numbering.number(g),), factor
    a, b = numbering.number(g.dep(0)), numbering.number(g.dep(1))
    return ((a, b), factor) if a < b else ((b, a), -factor)


def match(known: Mapping[Pair, Expression], others: Mapping[Pair, Expression]) -> Same:
    """For those of `others` that are one of the `known`: which."""
    if not others:
        return {}
    values = _values([*known.values(), *others.values()])
    own, rest = values[:, : len(known)], values[:, len(known) :]
    found = Same()
    for k, pair in enumerate(others):
        for first, column in zip(known, own.T, strict=True):
            factor = rest[0, k] / column[0] if column[0] else 0.0
            if factor and np.allclose(rest[:, k], factor * column, rtol=_SAME, atol=0.0):
                found.setdefault(pair, (first, as_expression(np.sign(factor))))
    return found


def _values(expressions: list[Expression]) -> Vector:
    """At random values of all symbols, (_LOOKS, k)."""
    column = ca.vertcat(*expressions)
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(column))
    look, random = ca.Function("look", [symbols], [column]), np.random.default_rng(6)
    return np.array([np.array(look(random.uniform(0.4, 1.6, symbols.numel()))).ravel() for _ in range(_LOOKS)])
