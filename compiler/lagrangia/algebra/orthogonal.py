"""Equations A x = b that may be dependent, and columns that are not: by orthogonal transformations."""

from random import Random

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
_ALIKE = 1e-9  # of lengths


def general_numbers(seed: int, low: float, high: float, count: int) -> Vector:
    """Numbers at random between bounds, (count,), the same each time. NumPy's generator would take 5 ms to be imported."""
    random = Random(seed)
    return np.array([random.uniform(low, high) for _ in range(count)])


def nearest(A: Vector, b: Vector, wish: Vector, tolerance: float, weight: Vector | None = None) -> tuple[Vector, int]:
    """The place nearest to the wish where A x = b, and the rank of A: Householder QR of A' with pivoting.

    In the sense of weighted least squares where rows are dependent.
    """
    columns, x = A.T.copy(), wish.copy()
    reflectors, chosen, first = [], list(range(len(b))), 0.0
    for k in range(min(columns.shape)):
        norms = np.sqrt((columns[k:, k:] ** 2).sum(axis=0))
        longest = k + int(norms.argmax())
        norm = float(norms.max())
        columns[:, [k, longest]] = columns[:, [longest, k]]
        chosen[k], chosen[longest] = chosen[longest], chosen[k]
        first = norm if k == 0 else first
        if not norm > tolerance * first:
            break
        u = columns[k:, k].copy()
        diagonal = -norm if u[0] > 0 else norm
        u[0] -= diagonal
        factor = 2 / (u @ u)
        along = u @ columns[k:, k + 1 :]
        touched = along.nonzero()[0]  # of loops side by side few
        columns[k:, k + 1 + touched] -= np.outer(factor * u, along[touched])
        x[k:] -= factor * (u @ x[k:]) * u
        columns[k, k], columns[k + 1 :, k] = diagonal, 0.0
        reflectors.append((u, factor))
    rank = len(reflectors)
    left, wanted = columns[:rank].T, b[chosen]
    if rank == len(b):
        x[:rank] = np.linalg.solve(left, wanted)
    else:
        shares = np.ones(len(b)) if weight is None else weight[chosen]
        Q, R = np.linalg.qr(left * shares[:, None])  # of full rank, as its pivots are above the tolerance
        x[:rank] = np.linalg.solve(R, Q.T @ (wanted * shares))
    for k in range(rank - 1, -1, -1):
        u, factor = reflectors[k]
        x[k:] -= factor * (u @ x[k:]) * u
    return x, rank


def independent_columns(columns: Vector, tolerance: float, is_last: bool = False) -> NDArray[np.int_]:
    """The places of independent columns, the longest remainder first, as pivots of a QR factorisation; of those that rounding
    alone tells apart the first or the last, so that the choice is the same on every processor."""
    rest, found, first = columns.copy(), [], 0.0
    for _ in range(min(columns.shape)):
        norms = np.linalg.norm(rest, axis=0)
        k = int(np.flatnonzero(norms >= (1 - _ALIKE) * norms.max())[-1 if is_last else 0])
        first = first or float(norms[k])
        if not norms[k] > tolerance * first:
            break
        found.append(k)
        direction = rest[:, k] / norms[k]
        for _twice in range(2):
            rest -= np.outer(direction, direction @ rest)
        rest[:, k] = 0.0
    return np.array(found, int)
