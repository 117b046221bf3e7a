"""Holonomic constraints in numbers, with the parameters as declared: onto them, and along what they allow."""

from collections.abc import Iterator

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.pointers import Pointer
from lagrangia.constraints.parameters import at_declared_values
from lagrangia.frames.kinematics import Kinematics

_DEPENDENT = 1e-9  # singular values below, relative to the largest, are of rows that repeat others
_RETURNS = 60
Vector = NDArray[np.float64]


class Positions:
    """Phi(q) and all slopes J(q) at the start time."""

    def __init__(self, kinematics: Kinematics, phi: ca.SX, J: ca.SX) -> None:
        q = ca.vertcat(*kinematics.symbols.positions.values())
        phi, J = (ca.densify(x) for x in at_declared_values(kinematics, [phi, J]))
        self.n, self._shape = q.numel(), J.shape
        self._gaps = Pointer(ca.Function("gaps", [q], [phi, ca.densify(ca.jacobian(phi, q))]))
        self._slopes = Pointer(ca.Function("slopes", [q], [J]))

    def gap(self, q: Vector) -> float:
        """The largest |Phi|."""
        return float(np.abs(self._gaps(q)).max(initial=0.0))

    def slopes(self, q: Vector) -> Vector:
        """J, (m, n)."""
        return np.ascontiguousarray(self._slopes(q).T).reshape(self._shape)

    def _near(self, q: Vector) -> tuple[Vector, Vector]:
        """Phi, and its slopes."""
        phi, slopes = self._gaps.outputs(q)
        return phi, np.ascontiguousarray(slopes.T).reshape(phi.size, self.n)

    def onto(self, q: Vector, units: Vector | None = None) -> Vector:
        """Onto the constraints by the shortest corrections, lengths measured in `units`, as long as they help."""
        units = np.ones(self.n) if units is None else units
        g, J = self._near(q)
        for _ in range(_RETURNS):
            step = units * shortest(J * units, -g)
            ahead, slopes = self._near(q + step)
            if not np.linalg.norm(ahead) < np.linalg.norm(g):
                break
            q, g, J = q + step, ahead, slopes
        return q

    def along(self, q: Vector, wish: Vector, units: Vector, length: float) -> Iterator[Vector]:
        """One after the other, positions along the way that begins most nearly as wished, lengths measured in `units`."""
        while True:
            J = self.slopes(q) * units
            wish = wish - shortest(J, J @ wish)
            step = units * wish * (length / max(float(np.linalg.norm(wish)), np.finfo(float).tiny))
            q = self.onto(q + step, units)
            yield q


def shortest(A: Vector, b: Vector) -> Vector:
    """The shortest x with A x = b, in the sense of least squares where rows are dependent; 0 where these are no numbers."""
    if not (np.isfinite(A).all() and np.isfinite(b).all()):
        return np.zeros(A.shape[1])
    return np.asarray(np.linalg.lstsq(A, b, rcond=_DEPENDENT)[0])
