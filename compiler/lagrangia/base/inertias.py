"""Moments of inertia about three axes, as numbers: which of them no rigid body has."""

import numpy as np
from numpy.typing import NDArray

ROUNDING = 1e-12  # relative, of moments of inertia


def principal(own: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """The moments (3,) and the axes, columns of (3, 3), of three moments or of a symmetric matrix, in kg.m2."""
    moments, axes = np.linalg.eigh(own) if own.ndim == 2 else (own, np.eye(3))
    return moments, axes


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
