"""Coordinates that a loop in space does not feel, but for rounding.

Two joints along one axis of many digits, or put together by frames that are turned, have axes that differ in their last digits:
then an equation that says nothing about a coordinate has it 1e-17 times. Solved for that coordinate it would say where this is,
and measured by its own slopes rounding would be a way to go.
"""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.algebra.orthogonal import general_numbers
from lagrangia.frames.kinematics import Kinematics

_ROUNDING = 1e-13  # of slopes, beside the largest one
_PLACES = 2


def find_unfelt(kinematics: Kinematics, gaps: ca.SX, rates: ca.SX) -> list[tuple[str, ...]]:
    """Of each gap, (m,), with its rate: the coordinates by which neither changes, nor the rate with theirs, at places in general
    and with parameters in general."""
    symbols = kinematics.symbols
    q, v = (ca.vertcat(*x.values()) for x in (symbols.positions, symbols.rates))
    slopes = [ca.jacobian(gaps, q), ca.jacobian(rates, v), ca.jacobian(rates, q)]
    mentioned = slopes[0].sparsity() + slopes[1].sparsity() + slopes[2].sparsity()
    entries = [ca.fabs(ca.vertcat(ca.SX(0, 1), *ca.project(x, mentioned).nonzeros())) for x in slopes]
    inner = ca.symvar(ca.vertcat(*entries))
    sizes = ca.Function("sizes", [ca.vertcat(ca.SX(0, 1), *inner)], [ca.horzcat(*entries)])
    found = np.hstack([sizes(general_numbers(1 + k, 0.3, 1.7, len(inner))).full() for k in range(_PLACES)])
    least = _ROUNDING * np.max(found, initial=0.0, where=np.isfinite(found))
    names, unfelt = list(symbols.positions), [list[str]() for _ in range(gaps.numel())]
    for row, k, size in zip(*mentioned.get_triplet(), found.max(axis=1, initial=0.0), strict=True):
        if size <= least:
            unfelt[row].append(names[k])
    return [tuple(row) for row in unfelt]


def without_unfelt(kinematics: Kinematics, value: Scalar, unfelt: Sequence[str]) -> Scalar:
    """Of a gap at some level, where those coordinates are 0 and stay so."""
    symbols = kinematics.symbols
    motion = [x[name] for x in (symbols.positions, symbols.rates, symbols.accelerations) for name in unfelt if name in x]
    return _at_rest(value, [x for x in motion if isinstance(x, ca.SX)])


def _at_rest(value: Scalar, motion: list[ca.SX]) -> Scalar:
    if isinstance(value, Dual):
        return Dual(_at_rest(value.value, motion), _at_rest(value.rate, motion))
    return ca.substitute([value], motion, [ca.SX(0)] * len(motion))[0] if isinstance(value, ca.SX) and motion else value
