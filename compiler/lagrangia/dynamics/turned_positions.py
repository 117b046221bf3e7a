"""Positions (n,) of which some are s of attitudes, 4 tan(angle/4) along the axis (runtime/state/attitudes.c), in numbers.

`turned`: of each attitude the places of its three.
"""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
Turned = Sequence[Sequence[int]]
_HALF = 4.0  # |s| of half a turn


def crossing(w: Vector) -> Vector:
    """What makes w x u of u, (3, 3)."""
    x, y, z = w
    return np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])


def pacing(s: Vector) -> Vector:
    """N(s), (3, 3): small turns about the turned axes -> changes of s."""
    return np.asarray((1 - s @ s / 16) * np.eye(3) + crossing(s) / 2 + np.outer(s, s) / 8)


def pacing_of(turned: Turned, q: Vector) -> Vector:
    """The same of all positions, (n, n)."""
    found = np.eye(q.size)
    for places in map(list, turned):
        found[np.ix_(places, places)] = pacing(q[places])
    return found


def half_turned(turned: Turned, q: Vector) -> list[Vector]:
    """With each attitude turned by half a turn about each of its axes instead."""
    found = []
    for places in turned:
        for place in places:
            other = q.copy()
            other[list(places)] = 0.0
            other[place] = _HALF
            found.append(other)
    return found


def shorter(turned: Turned, q: Vector) -> Vector:
    """The same attitudes by turns the shorter way, of at most half a turn."""
    found = q.copy()
    for places in map(list, turned):
        square = float(q[places] @ q[places])
        if square > _HALF**2:
            found[places] = -(_HALF**2) / square * q[places]
    return found


def apart(turned: Turned, a: Vector, b: Vector) -> Vector:
    """a - b, where half a turn one way is half a turn the other way."""
    gap = a - b
    for places in map(list, turned):
        square = float(a[places] @ a[places])
        if square > 1:
            gap[places] = min(gap[places], -(_HALF**2) / square * a[places] - b[places], key=lambda x: float(np.linalg.norm(x)))
    return np.asarray(gap)
