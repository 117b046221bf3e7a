"""Least squares with unknowns that are not negative: min |A x - b|, x >= 0.

Source: C. L. Lawson and R. J. Hanson, Solving Least Squares Problems, 1974, algorithm NNLS.
"""

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
_NOTHING = 1e-12


def nonnegative(A: Vector, b: Vector) -> Vector:
    """x (k,) of A (m, k), b (m,)."""
    k = A.shape[1]
    x, taken = np.zeros(k), np.full(k, False)
    scale = np.linalg.norm(A, axis=0)
    for _ in range(10 * k + 10):
        pull = A.T @ (b - A @ x)
        open_ = ~taken & (pull > _NOTHING * np.where(scale > 0, scale, np.inf) * max(float(np.linalg.norm(b)), 1e-300))
        if not open_.any():
            break
        taken[int(np.argmax(np.where(open_, pull / np.where(scale > 0, scale, 1.0), -np.inf)))] = True
        x, taken = _solved(A, b, x, taken)
    return x


def _solved(A: Vector, b: Vector, x: Vector, taken: NDArray[np.bool_]) -> tuple[Vector, NDArray[np.bool_]]:
    """The least squares of those that are taken; what would become negative is let go on the way there."""
    taken = taken.copy()
    while taken.any():
        wish = np.zeros(x.size)
        wish[taken] = np.linalg.lstsq(A[:, taken], b, rcond=None)[0]
        falling = taken & (wish <= 0)
        if not falling.any():
            return wish, taken
        with np.errstate(all="ignore"):
            part = float((x[falling] / (x[falling] - wish[falling])).min())
        x = x + (part if np.isfinite(part) else 0.0) * (wish - x)
        taken &= ~(falling & (x <= _NOTHING * np.abs(x).max(initial=0.0)))
        x = np.where(taken, x, 0.0)
    return np.zeros(x.size), taken
