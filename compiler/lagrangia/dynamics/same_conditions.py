"""Conditions that are met in another shape: of what was found in forces, in the reactions that these forces make.

sign(-x) is -sign(x), and a sum is the same in any order: by their values at random states, x of one is x of the other but for a
factor.
"""

from collections.abc import Mapping

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import Expression
from lagrangia.dynamics.held_switches import Pair

_LOOKS, _SAME = 4, 1e-9


def match(known: Mapping[Pair, Expression], others: Mapping[Pair, Expression]) -> dict[Pair, tuple[Pair, bool]]:
    """For those of `others` that are one of the `known`: which, and whether both have the same sign."""
    if not others:
        return {}
    values = _values([*known.values(), *others.values()])
    own, rest = values[:, : len(known)], values[:, len(known) :]
    found = dict[Pair, tuple[Pair, bool]]()
    for k, pair in enumerate(others):
        for first, column in zip(known, own.T, strict=True):
            factor = rest[0, k] / column[0] if column[0] else 0.0
            if factor and np.allclose(rest[:, k], factor * column, rtol=_SAME, atol=0.0):
                found.setdefault(pair, (first, factor > 0))
    return found


def _values(expressions: list[Expression]) -> Vector:
    """At random values of all symbols, (_LOOKS, k)."""
    column = ca.vertcat(*expressions)
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(column))
    look, random = ca.Function("look", [symbols], [column]), np.random.default_rng(6)
    return np.array([np.array(look(random.uniform(0.4, 1.6, symbols.numel()))).ravel() for _ in range(_LOOKS)])
