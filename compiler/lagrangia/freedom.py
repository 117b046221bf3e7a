"""Constraints -> degrees of freedom: assembles the scene with its declared parameters and takes ranks.

The rank is taken at the assembled position and at general positions near it, for a mechanism may start in a singular one. A rank
decision counts singular values above 1e-9 of the largest, rows and columns scaled to unit size.
"""

from collections.abc import Callable
from dataclasses import dataclass

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.constraints import Constraints, Row
from lagrangia.diagnostics import Diagnostic
from lagrangia.functions import at_declared_values
from lagrangia.initial import FIXED, FREE, InitialConditions
from lagrangia.kinematics import Kinematics
from lagrangia.motion import ConstrainedMotion, Motion

_RANK = 1e-9
_CLOSED = 1e-9
_THERE = 1e-13  # of a position that is taken to be on the constraints, relative to the scene's size
_TRIES = 60
_PUSH = 0.01  # in m and rad
Vector = NDArray[np.float64]
System = Callable[[Vector], list[Vector]]


@dataclass(frozen=True)
class Freedom:
    """`degrees` of freedom at general positions and `now`, at the start; rows that repeat others; what does not assemble."""

    degrees: int
    now: int
    repeated: tuple[str, ...]
    problem: Diagnostic | None


def find_freedom(kinematics: Kinematics, motion: Motion, constraints: Constraints, initial: InitialConditions) -> Freedom:
    """The freedom of a constrained scene with its parameters as declared."""
    held = motion.constrained
    n = motion.q.numel()
    told = tuple(_tell(row) for row in constraints.repeated)
    if held is None:
        return Freedom(n, n, told, None)
    numbers = _Numbers(kinematics, motion, held, initial)
    q, gap, worst = numbers.assemble()
    if gap > _CLOSED * numbers.size(q):
        return Freedom(n, n, told, _problem(initial, worst, gap))
    places = [q, *numbers.nearby(q)]
    ranks = [numbers.rank(x) for x in places]
    general = places[int(np.argmax(ranks))]
    repeated = [constraints.rows[k] for k in numbers.dependent_rows(general)]
    return Freedom(n - max(ranks), n - ranks[0], told + tuple(dict.fromkeys(map(_tell, repeated))), None)


def _tell(row: Row) -> str:
    what = f"the loop {row.loop.around}" if row.loop else f"the equation '{row.span.text}' at {row.span}"
    return f"{what} repeats in part what others already impose"


def _problem(initial: InitialConditions, worst: int, gap: float) -> Diagnostic:
    span, loop = initial.residual_spans[worst], initial.residual_loops[worst]
    what = f"the loop {loop} cannot close" if loop else "this cannot hold at the start"
    return Diagnostic("error", "L0606", f"{what}: it misses by {gap:.3g} (m or rad)", span, "",
                      ("change the lengths, the places of the joints, or the start values it is solved from",))


class _Numbers:
    """Constraint equations in numbers: residuals of the start and of the positions, with their slopes."""

    def __init__(self, kinematics: Kinematics, motion: Motion, held: ConstrainedMotion, initial: InitialConditions) -> None:
        q, n = motion.q, motion.q.numel()
        self.n, self.fixed = n, np.array(initial.fixed[:n]) == FIXED
        self.weight = np.where(np.array(initial.fixed[:n]) == FREE, 10.0, 1.0)

        def numeric(name: str, results: list[ca.SX]) -> ca.Function:
            return ca.Function(name, [q], [ca.densify(x) for x in at_declared_values(kinematics, results)])

        g = initial.residuals[: initial.n_positions]
        self.start = numeric("start", [initial.q])
        self.residuals = numeric("residuals", [g, ca.jacobian(g, q)])
        self.positions = numeric("positions", [held.phi, ca.jacobian(held.phi, q)])
        self.slopes = numeric("slopes", [held.J])

    def size(self, q: Vector) -> float:
        return max(1.0, float(np.abs(q).max(initial=0.0)))

    def assemble(self) -> tuple[Vector, float, int]:
        """Positions by damped Gauss-Newton from the start values, the largest residual left and its row."""
        start = np.array(self.start(np.zeros(self.n))).ravel()
        best = self._solve(start, lambda x: [np.array(y) for y in self.residuals(x)])
        g = np.abs(np.array(self.residuals(best)[0]).ravel())
        return best, float(g.max(initial=0.0)), int(g.argmax()) if g.size else 0

    def nearby(self, q: Vector) -> list[Vector]:
        """General positions near an assembled one: a small step along what the constraints allow, and back onto them."""
        J = np.array(self.slopes(q))
        random = np.random.default_rng(1)
        found = []
        for size in (0.1, 0.03, 0.01):
            step = random.standard_normal(self.n)
            step -= np.linalg.pinv(J, rcond=_RANK) @ (J @ step)
            free = np.zeros(self.n, bool)
            x = self._solve(q + size * step, lambda y: [np.array(z) for z in self.positions(y)], free)
            if np.abs(np.array(self.positions(x)[0])).max(initial=0.0) < _THERE * self.size(q):
                found.append(x)
        return found

    def _solve(self, q: Vector, system: System, fixed: "NDArray[np.bool_] | None" = None) -> Vector:
        held = self.fixed if fixed is None else fixed
        g, J = system(q)
        for _ in range(_TRIES):
            if np.abs(g).max(initial=0.0) < 1e-14:
                break
            if np.linalg.norm(J[:, ~held].T @ g) < 1e-7 * np.linalg.norm(g):  # nothing leads on from here: a push
                q = q + np.where(held, 0.0, _PUSH * np.cos(np.arange(self.n)))
                g, J = system(q)
            step = np.zeros(self.n)
            weight = self.weight[~held]
            step[~held] = -weight * (np.linalg.pinv(J[:, ~held] * weight, rcond=1e-7) @ g.ravel())
            scale = 1.0
            while scale > 1e-4:
                ahead, slope = system(q + scale * step)
                if np.linalg.norm(ahead) < np.linalg.norm(g):
                    break
                scale /= 2
            else:
                break
            q, g, J = q + scale * step, ahead, slope
        return q

    def _scaled(self, q: Vector) -> Vector:
        J = np.array(self.slopes(q))
        J = J / np.maximum(np.abs(J).max(axis=0, keepdims=True), 1e-300)
        return np.asarray(J / np.maximum(np.linalg.norm(J, axis=1, keepdims=True), 1e-300), dtype=np.float64)

    def rank(self, q: Vector) -> int:
        values = np.linalg.svd(self._scaled(q), compute_uv=False)
        return int((values > _RANK * values.max(initial=0.0)).sum())

    def dependent_rows(self, q: Vector) -> list[int]:
        """Rows that lie in the span of the rows before them."""
        basis: list[Vector] = []
        found = []
        for k, row in enumerate(self._scaled(q)):
            rest = row.copy()
            for _ in range(2):
                for b in basis:
                    rest -= (rest @ b) * b
            size = float(np.linalg.norm(rest))
            if size > 1e-7:
                basis.append(rest / size)
            else:
                found.append(k)
        return found
