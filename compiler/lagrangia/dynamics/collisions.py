"""Resets of bodies that meet, all of which are turned back: whether they are what an impulse between these does.

The rates r = R v are reset to w, and the rate of the gap is s v, s = c R. An impulse L between the bodies gives M dv = s^T L, and
so w - r = R M^-1 R^T c^T L; where constraints hold J v = 0, these give impulses of their own, M dv = s^T L + J^T N. One of a
hand that takes hold of them does not: it leaves them no momentum, or gives them some.
"""

from enum import IntEnum

import casadi as ca
import numpy as np
from numpy.typing import NDArray

_SAME = 1e-9  # relative difference of what is the same but for rounding
Numbers = NDArray[np.float64]


class Meeting(IntEnum):
    """What resets do: nothing like an impact; turn back what approaches; and that by an impulse between those that meet, for the
    parameters as they are declared or for all."""

    NONE = 0
    BACK = 1
    AS_DECLARED = 2
    BETWEEN = 3


def shares_of(pace: ca.SX, rates: ca.SX, v: ca.SX) -> ca.SX:
    """c: by how much the rate of a gap changes with each of the rates that are reset."""
    R = ca.jacobian(rates, v)
    return ca.solve(R @ R.T, R @ ca.gradient(pace, v))


def look_at_meeting(look: ca.Function, p: Numbers, random: "np.random.Generator") -> Meeting:
    """At a random state; `look` gives pace, r, w, s, R, M and J of v, what else is known, and parameters."""
    v, known = (random.uniform(0.4, 1.6, look.numel_in(k)) for k in range(2))

    def at(v: Numbers) -> list[Numbers]:
        pace, r, w, s, R, M, J = (np.array(x) for x in look(v, known, p))
        return [pace.ravel(), r.ravel(), w.ravel(), s.ravel(), R, M, J]

    (pace,), r, _, s, R, M, J = at(v)
    if not all(np.isfinite(x).all() for x in (pace, r, s, R, M, J)) or not np.dot(s, s) > 0:
        return Meeting.NONE
    c = np.linalg.lstsq(R.T, s, rcond=None)[0]
    if np.linalg.matrix_rank(R) < len(r) or not np.linalg.norm(c) > 0:
        return Meeting.NONE
    still, towards = (v + s * ((x - pace) / np.dot(s, s)) for x in (0, 1))
    (_, r_still, w_still, *_), (_, r, w, *_) = at(still), at(towards)
    change, size = w - r, np.abs(R) @ np.abs(v) + np.abs(r)
    if (np.abs(w_still - r_still) > _SAME * size).any() or 1 + np.dot(c, change) > _SAME:
        return Meeting.NONE
    held = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]])
    way = R @ np.linalg.lstsq(held, np.append(R.T @ c, np.zeros(len(J))), rcond=None)[0][:len(v)]
    are_all = np.linalg.norm(R.T @ c - s) <= _SAME * np.linalg.norm(s)
    is_between = are_all and np.linalg.norm(change - way * (np.dot(c, change) / np.dot(c, way))) <= _SAME * np.linalg.norm(change)
    return Meeting.BETWEEN if is_between else Meeting.BACK
