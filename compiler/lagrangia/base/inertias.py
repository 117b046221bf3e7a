"""Moments of inertia about three axes, as numbers: which of them no rigid body has."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

ROUNDING = 1e-12  # relative, of moments of inertia


def principal(own: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The moments (3,) and the axes, columns of (3, 3), of three moments or of a symmetric matrix, in kg.m2."""
    moments, axes = np.linalg.eigh(own) if own.ndim == 2 else (own, np.eye(3))
    return moments, axes


def are_of_a_body(own: Sequence[float]) -> bool:
    """Whether three moments, or nine entries of a symmetric matrix, surely are those of some body, without principal axes.

    No moment is more than the other two together where half the trace, less the matrix, is negative along no axis (Sylvester).
    """
    if len(own) == 3:
        x, y, z = own
        return x <= y + z and y <= z + x and z <= x + y
    half = (own[0] + own[4] + own[8]) / 2
    x, y, z, xy, yz, zx = half - own[0], half - own[4], half - own[8], own[1], own[5], own[2]
    if xy == 0 and yz == 0 and zx == 0:
        return x >= 0 and y >= 0 and z >= 0
    return x > 0 and x * y > xy * xy and x * (y * z - yz * yz) > xy * (xy * z + yz * zx) + zx * (xy * yz + y * zx)


def told_beyond_others(name: str, own: NDArray[np.float64]) -> str:
    """What is told of an inertia with one moment more than the other two together; nothing of others."""
    moments, axes = principal(own)
    k = int(np.argmax(moments))
    rest = moments.sum() - moments[k]
    if not are_beyond_others(moments):
        return ""
    return (f"no rigid body has the inertia '{name}': about {axis_words(axes[:, k])} it is {moments[k]:g} kg.m2, more than about "
            f"the other two together, {rest:g}")


def are_beyond_others(moments: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Of many inertias by their moments, (..., 3): (...). What is negative is no such inertia: it is refused."""
    rounding = ROUNDING * np.abs(moments).max(-1)
    found: NDArray[np.bool_] = (2 * moments.max(-1) > moments.sum(-1) + rounding) & (moments.min(-1) >= -rounding)
    return found


def axis_words(direction: NDArray[np.float64]) -> str:
    """A direction (3,), by its letter where it is one of the three."""
    along = np.flatnonzero(direction)
    return "xyz"[along[0]] if len(along) == 1 else "the axis {" + ", ".join(f"{x:.3g}" for x in direction) + "}"
