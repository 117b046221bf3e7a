"""Vectors that stay on a line through zero: r = phi e with a unit vector e, as between the two sides of a slider that turns.

The length of such a vector is |phi|, which has a corner where phi is 0: a condition that changes its sign there, and
sqrt(r . r) has none. Others pass through zero by chance alone.
"""

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.duals import Scalar
from lagrangia.base.records import dataclass

_MOST_SYMBOLS = 40  # in larger vectors nothing is looked for
_SAME = 1e-12  # relative difference of what is the same but for rounding
_LOOKS = 3
Numbers = NDArray[np.float64]


@dataclass(frozen=True)
class Line:
    """phi = constant(p) + sum of coefficient(p) * coordinate."""

    constant: Scalar
    terms: Mapping[str, Scalar]


def line_of(vector: Sequence[Scalar], names: Mapping[int, str], moving: frozenset[int]) -> Line | None:
    """`names` of coordinates by the hashes of their symbols, `moving` those of all that changes. None where the vector leaves
    each line, where phi is no such sum, or something else moves it."""
    r = ca.vertcat(*vector)
    symbols = ca.symvar(r)
    own = [x for x in symbols if x.__hash__() in names]
    others = [x for x in symbols if x.__hash__() not in names]
    if not own or len(symbols) > _MOST_SYMBOLS or not moving.isdisjoint(x.__hash__() for x in others):
        return None
    q, p = ca.vertcat(*own), ca.vertcat(ca.SX(0, 1), *others)
    slopes = ca.jacobian(r, q)
    column = _direction(ca.Function("look", [q, p], [r, slopes]))
    if column is None:
        return None
    along = slopes[:, column]
    phi = ca.dot(r, along) / ca.norm_2(along)
    constant, *factors = ca.substitute(ca.vertcat(phi, ca.densify(ca.gradient(phi, q))), q, ca.SX.zeros(q.numel())).elements()
    total = constant + ca.dot(ca.vertcat(*factors), q)
    if not _are_equal(ca.Function("compare", [q, p], [ca.dot(r, r), total**2])):
        return None
    terms = {names[x.__hash__()]: _plain(factor) for x, factor in zip(own, factors, strict=True) if not factor.is_zero()}
    return Line(_plain(constant), terms)


def _points(function: ca.Function) -> list[list[Numbers]]:
    """Results at states and parameters like any others."""
    random = np.random.default_rng(5)
    return [[np.array(x) for x in function(*(random.uniform(0.4, 1.6, function.numel_in(k)) for k in range(2)))]
            for _ in range(_LOOKS)]


def _direction(look: ca.Function) -> int | None:
    """A coordinate by which the vector always moves along itself."""
    good = None
    for r, slopes in _points(look):
        (x, y), (dx, dy) = r.ravel(), slopes
        size = np.hypot(x, y) * np.hypot(dx, dy)
        here = (np.abs(x * dy - y * dx) <= _SAME * size) & (size > 0)
        good = here if good is None else good & here
    return int(np.argmax(good)) if good is not None and good.any() else None


def _are_equal(compare: ca.Function) -> bool:
    return all(np.abs(a - b).item() <= _SAME * np.abs(a).item() for a, b in _points(compare))


def _plain(x: ca.SX) -> Scalar:
    """Numbers as such, whole ones without their rounding."""
    if not x.is_constant():
        return x
    number = float(x)
    return float(round(number)) if abs(number - round(number)) <= 4 * np.finfo(float).eps * abs(number) else number
