"""Singular positions: the ways of moving that meet where constraints are less independent than elsewhere.

With N the null space of J and w that of J^T, what moves as q + N x s + ... has to keep w^T Phi to second order, too:

    Q_i(x) = x^T N^T (w_i^T d2Phi/dq2) N x = 0.

Where the x that do fill planes, each plane is a way of moving: linearised motion on it is that of ordinary positions. Where there
is none but 0 nothing moves. A cone that is made of no planes has no linear motion.
Source: the second-order analysis of kinematic bifurcation (S. Kumar and S. Pellegrino, Int. J. Solids Struct. 37, 2000, 7003).
"""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import independent_columns
from lagrangia.base.records import dataclass

Matrix = NDArray[np.float64]
_FLAT = 1e-7  # of second derivatives of normalised rows: positions are known to half the digits where constraints are singular
_STARTS, _STEPS = 96, 40
_MET = 1e-13  # Q_i on unit vectors
_SAME = 1e-5
_REDUCED = 1e-9


@dataclass(frozen=True)
class Ways:
    """`planes`: orthonormal bases (n, f), one a way of moving. `is_open`: second order does not tell, or what moves fills no
    planes."""

    planes: tuple[Matrix, ...]
    is_open: bool = False

    @property
    def is_rigid(self) -> bool:
        """Nothing moves there."""
        return not self.planes and not self.is_open


def find_ways(N: Matrix, bends: Sequence[Matrix], freedom: int, leads_on: Callable[[Matrix], bool]) -> Ways:
    """`N` (n, d): what first order allows. `bends`: w_i^T d2Phi/dq2 (n, n) of rows normalised to slopes of about 1. `freedom`: of
    general positions near by, at most d. `leads_on`: whether a direction (n,) that second order leaves open is one of motion."""
    d = N.shape[1]
    forms = _independent([N.T @ ((x + x.T) / 2) @ N for x in bends])
    if not forms:
        return Ways((N,) if d == freedom else (), d != freedom)
    if len(forms) == 1 and (kernel := _kernel_of_definite(forms[0])) is not None:
        left = [leads_on(N @ x) for x in kernel.T]
        return Ways((N @ kernel,) if left and all(left) else (), any(left) and not all(left))
    found: list[Matrix] = []
    is_open = False
    for direction in _solutions(forms, d):
        plane = _null_space(np.array([Q @ direction for Q in forms]))
        is_flat = plane.size > 0 and all(np.abs(plane.T @ Q @ plane).max() <= _SAME for Q in forms)
        if not is_flat or (plane.shape[1] != freedom and not all(leads_on(N @ x) for x in plane.T)):
            is_open = True
        elif all(np.linalg.norm(plane @ plane.T - other @ other.T) > _SAME for other in found):
            found.append(plane)
    return Ways(() if is_open else tuple(sorted((N @ x for x in found), key=_order)), is_open)


def told(plane: Matrix, names: Sequence[str]) -> str:
    """A way of moving by the coordinates that move, each set that moves together: `pin.phi = -2 hinge.phi, guide.s = ...`."""
    rows = independent_columns(plane.T, _REDUCED)
    reduced = plane @ np.linalg.inv(plane[rows])
    parts = []
    for place, k in enumerate(rows):
        column = reduced[:, place]
        others = [f"{names[i]} = {x:.6g} {names[k]}" for i, x in enumerate(column) if i != k and abs(x) > _SAME]
        parts.append(", ".join(others) if others else f"{names[k]} alone")
    return "; ".join(parts)


def _order(plane: Matrix) -> tuple[float, ...]:
    """The same however the bases came out."""
    return tuple(-np.round((plane @ plane.T).ravel(), 6) + 0.0)


def _independent(forms: Sequence[Matrix]) -> list[Matrix]:
    """Of the space that they span, by size."""
    if not forms:
        return []
    d = forms[0].shape[0]
    _, sizes, rows = np.linalg.svd(np.array([x.ravel() for x in forms]), full_matrices=False)
    return [row.reshape(d, d) * size for size, row in zip(sizes, rows, strict=True) if size > _FLAT]


def _kernel_of_definite(Q: Matrix) -> Matrix | None:
    """Where a form of one sign vanishes; None for one of both."""
    values, vectors = np.linalg.eigh(Q)
    nothing = _FLAT * max(1.0, float(np.abs(values).max()))
    if (values > nothing).any() and (values < -nothing).any():
        return None
    return np.asarray(vectors[:, np.abs(values) <= nothing])


def _solutions(forms: Sequence[Matrix], d: int) -> list[Matrix]:
    """Unit vectors on which all forms vanish, by Gauss and Newton's method from many starts."""
    random = np.random.default_rng(6)
    found = []
    scaled = [Q / np.linalg.norm(Q) for Q in forms]
    for _ in range(_STARTS):
        x = random.standard_normal(d)
        for _ in range(_STEPS):
            x /= np.linalg.norm(x)
            values = np.array([x @ Q @ x for Q in scaled])
            if np.abs(values).max() <= _MET:
                found.append(x)
                break
            slopes = np.array([*(2 * Q @ x for Q in scaled), x])  # and as long as it was
            x = x - np.linalg.lstsq(slopes, np.append(values, 0.0), rcond=1e-10)[0]
    return found


def _null_space(A: Matrix) -> Matrix:
    _, sizes, rows = np.linalg.svd(A)
    rank = int((sizes > _SAME * sizes.max(initial=0.0)).sum())
    return np.asarray(rows[rank:].T)
