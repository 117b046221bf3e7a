"""Equations of start values solved from guesses: the algorithm of runtime/start/newton.c, which states what it does and why."""

from collections.abc import Mapping
from functools import cached_property

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector, nearest
from lagrangia.algebra.pointers import Pointer
from lagrangia.base.records import dataclass
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.metric import Metric, Momenta, Way
from lagrangia.constraints.parameters import default_parameters, input_symbols, with_declared_inputs
from lagrangia.frames.kinematics import Kinematics

_SATISFIED, _DEPENDENT, _ROUNDING, _ROUNDED = 1e-10, 1e-10, 1e-10, 1e-14
_SHORTEST_STEP, _LONGEST_STEP, _FAITHFUL, _STEEPEST = 1e-4, 0.5, 0.9, 1e9
_CRITICAL, _PUSH, GOLDEN_RATIO = 1e-6, 1e-2, 0.6180339887498949


@dataclass(frozen=True)
class Equations:
    """g(q, v, p) = 0 at parameters p: those of positions come first. `momentum` is q, v, p -> M v."""

    initial: ca.Function
    momentum: ca.Function | None
    p: Vector
    is_angle: NDArray[np.bool_]  # (n,)
    kind: NDArray[np.int_]  # (n,)
    n_positions: int
    u: Vector | None = None  # inputs, where they move what is held

    @property
    def n(self) -> int:
        """The number of coordinates."""
        return self.is_angle.size

    @property
    def momenta(self) -> Momenta | None:
        """q, rates -> momenta, with the parameters put in; None without masses."""
        momentum, p = self.momentum, self.p
        return None if momentum is None else lambda q, rates: np.asarray(momentum(q, rates, p).full())

    def __call__(self, x: Vector) -> tuple[Vector, Vector]:
        """g (m,) and its Jacobian (m, 2 n)."""
        inputs = () if self.u is None else (self.u,)
        g, gradients = self._initial.matrices(x[: self.n], x[self.n :], self.p, *inputs)
        return g.ravel(), gradients.T

    @cached_property
    def _initial(self) -> Pointer:
        return Pointer(self.initial)


def start_equations(kinematics: Kinematics, initial: InitialConditions, table: Mapping[str, ca.Function]) -> Equations:
    """Those of a scene with its parameters as declared. `table`: its functions; without momenta masses do not count."""
    units = [c.unit for c in (*kinematics.graph.coordinates, *initial.lost)]
    kinds = np.array([sorted(set(units)).index(unit) for unit in units])
    p, is_angle = default_parameters(kinematics)[1].full().ravel(), np.array([unit == "rad" for unit in units], bool)
    u = None
    if table["initial"].n_in() > 3:
        u = ca.evalf(with_declared_inputs(kinematics, [input_symbols(kinematics)])[0]).full().ravel()
    return Equations(table["initial"], table.get("momentum"), p, is_angle, kinds, initial.n_positions, u)


def pattern(n: int, turn: int) -> Vector:
    """From -0.5 to 0.5, different for each value."""
    places = (np.arange(n) + 1) * GOLDEN_RATIO + turn * GOLDEN_RATIO * GOLDEN_RATIO
    return np.asarray(np.fmod(places, 1) - 0.5)


@dataclass(frozen=True)
class General:
    """The Jacobian at a general position near the guess, the lengths of its scaled rows, and the residuals there."""

    jacobian: Vector
    length: Vector
    g: Vector


class Newton:
    """The equations numbered `active`, solved by moving the values with a scale."""

    def __init__(
        self, equations: Equations, general: General, active: NDArray[np.int_], scale: Vector, fixed: NDArray[np.int_], x: Vector,
        way: Way,
    ) -> None:
        n = equations.n
        self.equations, self.active, self.scale, self.n = equations, active, scale, n
        self.general_length = general.length[active]
        longest = _STEEPEST * (general.length + np.abs(general.g))[active]
        self.longest = np.where(longest > 0, longest, np.inf)
        halves = (slice(0, n), slice(n, 2 * n))
        self.metrics = [Metric(equations.momenta, x[:n], fixed[half], scale[half], way) for half in halves]
        self.middle = self.metrics[0].order.size
        weight = np.linalg.norm(self._measured(general.jacobian[active]), axis=1)
        self.weight = np.where(np.isfinite(weight), weight, 0.0)

    def solve(self, x: Vector, most_iterations: int, most_pushes: int) -> tuple[Vector, int]:
        """Iterates from x; the place reached, and the number of the equation that misses most there, -1 when all hold."""
        pushes, size, worst = 0, np.inf, 0
        self.trusted = _LONGEST_STEP
        self.evaluate(x)
        for _ in range(most_iterations):
            self.scale_equations()
            sizes = np.abs(self.g) / self.length
            worst = int(sizes.argmax())
            size = float(sizes[worst]) if np.isfinite(sizes).all() else np.inf
            if not 0 < size < np.inf:
                break
            better = self._improve(x, size)
            if better is not None:
                x = better
                continue
            if size <= _SATISFIED or pushes == most_pushes:
                break
            pushes += 1
            x = x + np.concatenate([_PUSH * self.scale[: self.n] * pattern(self.n, 0), np.zeros(self.n)])
            self.evaluate(x)
        failed = self._unsatisfied(size, worst)
        return x, int(self.active[failed]) if failed >= 0 else failed

    def _unsatisfied(self, size: float, worst: int) -> int:
        """-1, or an equation that does not hold at the place evaluated last, as 0/0 holds for nothing."""
        if not size <= _SATISFIED:
            return worst
        void = ~(np.linalg.norm(self.jacobian * self.scale, axis=1) <= self.longest)
        return int(void.argmax()) if void.any() else -1

    def lean(self, guess: Vector, x: Vector) -> float:
        """Prepares the step from x towards the guess along the equations; its largest part, in natural sizes."""
        self.trusted = _LONGEST_STEP
        return self._correct(self.wish(x, guess))

    def distance2(self, a: Vector, b: Vector) -> float:
        """The square of the distance from a to b in the metric."""
        z = self.wish(a, b)
        return float(z @ z)

    def evaluate(self, x: Vector) -> None:
        """Residuals and slopes at x, kept."""
        g, jacobian = self.equations(x)
        self.g, self.jacobian = g[self.active], jacobian[self.active]

    def scale_equations(self) -> None:
        """Divides the slopes by the size of each equation, at this place or in general."""
        scaled = self.jacobian * self.scale
        length = np.maximum(np.linalg.norm(scaled, axis=1), self.general_length)
        self.length = np.where(length > 0, length, 1.0)
        self.scaled = scaled / self.length[:, None]

    def wish(self, a: Vector, b: Vector) -> Vector:
        """From a to b, in the steps of both metrics."""
        return np.concatenate([metric.from_step(part) for metric, part in zip(self.metrics, self._parts(b - a), strict=True)])

    def _parts(self, x: Vector) -> tuple[Vector, Vector]:
        return x[..., : self.n], x[..., self.n :]

    def _measured(self, jacobian: Vector) -> Vector:
        """The gradients in the metrics."""
        parts = zip(self.metrics, self._parts(jacobian), strict=True)
        return np.concatenate([metric.of_gradients(part) for metric, part in parts], axis=1)

    def _correct(self, wish: Vector) -> float:
        rows = self._measured(np.where(np.isfinite(self.jacobian), self.jacobian, 0.0))
        own = np.linalg.norm(rows, axis=1)
        length = np.maximum(own, self.weight)
        is_measured = (own > _ROUNDING * length) & np.isfinite(length) & np.isfinite(self.jacobian).all(axis=1)
        unit = np.where(is_measured, length, np.inf)  # others are left out
        share = np.where(is_measured, length / self.length, 0.0)
        right = np.where(is_measured, -self.g / unit, 0.0)
        z, _ = nearest(np.where(is_measured[:, None], rows / unit[:, None], 0.0), right, wish, _DEPENDENT, share)
        self.step = np.concatenate([self.metrics[0].to_step(z[: self.middle]), self.metrics[1].to_step(z[self.middle :])])
        size = np.abs(self.step) / np.where(self.scale > 0, self.scale, np.inf)
        excess = size[: self.n] / np.where(self.equations.is_angle, _LONGEST_STEP, self.trusted)
        self.part = 1 / max(1.0, float(excess.max(initial=0.0)))
        self.step *= self.part
        return float(size.max(initial=0.0))

    def _sum_of_squares(self) -> float:
        scaled = self.g / self.length
        return float(scaled @ scaled)

    def _improve(self, x: Vector, size: float) -> Vector | None:
        before = self._sum_of_squares()
        length = self._correct(np.zeros(sum(metric.order.size for metric in self.metrics)))
        better = self._descend(x) if length > 0 else None
        if better is not None and self.part < 1 and self._sum_of_squares() <= (1 - _FAITHFUL * self.part) ** 2 * before:
            self.trusted *= 2
        if better is None and size > _SATISFIED and self._steepest():
            better = self._descend(x)
        return better

    def _steepest(self) -> bool:
        slope = -(self.scaled.T @ (self.g / self.length))
        length2 = float(slope @ slope)
        if not length2 > _CRITICAL**2 * self._sum_of_squares():
            return False
        change = self.scaled @ slope
        self.step = self.scale * slope * (length2 / float(change @ change))
        return True

    def _descend(self, x: Vector) -> Vector | None:
        before, part = self._sum_of_squares(), 1.0
        shortest = 1.0 if before < _ROUNDED**2 else _SHORTEST_STEP
        while part >= shortest:
            trial = x + part * self.step
            self.evaluate(trial)
            if self._sum_of_squares() < before:
                return trial
            part /= 2
        self.evaluate(x)
        return None
