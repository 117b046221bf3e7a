"""Distances of start values: as in runtime/start/metric.c, constant for constant, which states what it does and why."""

from collections.abc import Callable
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector
from lagrangia.constraints.initial import FREE

_EASE, _LEAST_PIVOT, _NO_MASS = 100.0, 1e-10, 1e-30
Momenta = Callable[[Vector, Vector], Vector]  # q (n,), rates (n, k) -> M(q) rates (n, k)


class Way(Enum):
    """How values are measured: LAG_METRIC_... of runtime/start/metric.h."""

    MASS = 0
    UNITS = 1
    EVEN = 2


class Metric:
    """Distances |z| of values, dx = B z, B = D L'^-1 with D M D = L L': see runtime/start/metric.c."""

    def __init__(self, momenta: Momenta | None, q: Vector, fixed: NDArray[np.int_], unit: Vector, way: Way) -> None:
        moving = np.flatnonzero(unit > 0)
        is_free = (fixed[moving] >= FREE) & (way is not Way.EVEN)
        self.order = np.concatenate([moving[is_free], moving[~is_free]])
        self.unit = unit[self.order]
        self.size = unit.size
        count = self.order.size
        M = _mass(momenta, q, self.order, self.unit) if way is Way.MASS and momenta is not None else np.zeros((count, count))
        largest = float(M.diagonal().max(initial=0.0)) if np.isfinite(M).all() else 0.0
        self.factor = _cholesky(M / largest) if largest > 0 else np.eye(count)
        self.factor[:, : int(is_free.sum())] /= _EASE

    def of_gradients(self, gradients: Vector) -> Vector:
        """Rows g -> rows B' g."""
        if not self.order.size:
            return np.zeros((len(gradients), 0))
        return np.asarray(np.linalg.solve(self.factor, (gradients[:, self.order] * self.unit).T).T)

    def to_step(self, z: Vector) -> Vector:
        """The change of the coordinates, (n,), that z stands for."""
        dx = np.zeros(self.size)
        if self.order.size:
            dx[self.order] = np.linalg.solve(self.factor.T, z) * self.unit
        return dx

    def from_step(self, dx: Vector) -> Vector:
        """The z of a change dx of the coordinates."""
        return np.asarray(self.factor.T @ (dx[self.order] / self.unit))


def _mass(momenta: Momenta, q: Vector, order: NDArray[np.int_], unit: Vector) -> Vector:
    if not order.size:
        return np.zeros((0, 0))
    rates = np.zeros((q.size, order.size))
    rates[order, np.arange(order.size)] = unit
    return np.asarray(momenta(q, rates)[order] * unit[:, None])


def _cholesky(M: Vector) -> Vector:
    L = np.zeros_like(M)
    for k in range(len(M)):
        column = M[k:, k] - L[k:, :k] @ L[k, :k]
        floor = _LEAST_PIVOT * (M[k, k] if M[k, k] > _NO_MASS else 1.0)
        L[k, k] = np.sqrt(max(column[0], floor))
        L[k + 1 :, k] = column[1:] / L[k, k]
    return L
