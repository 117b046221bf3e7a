"""Scene -> the initial value problem that every solver of a benchmark gets: dy/dt = slope(t, y), y = (q, v).

Parameters and inputs are numbers in it, so that no solver pays for them. Between two time events the equations are smooth; each
such piece has a slope of its own, and solvers without events of their own start anew at its beginning.
"""

from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.dynamics.switches import live
from lagrangia.frames.attitude_starts import HINGES, refuse_attitudes
from lagrangia.model import Model
from lagrangia.run.request import USUAL, Experiment, Request, check_values, plan
from lagrangia.study.casadi_solvers import segments, switching_times

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LOOSEST = 1e-3


@dataclass(frozen=True)
class Piece:
    """A smooth piece of the motion: from `begin` to `end`, with those output times that fall into it."""

    begin: float
    end: float
    times: tuple[float, ...]
    slope: ca.Function  # t, y (2 n,) -> dy/dt (2 n,)

    @property
    def grid(self) -> list[float]:
        """Output times after the beginning, and the end."""
        return sorted({*(t for t in self.times if t > self.begin), self.end})


@dataclass(frozen=True)
class Problem:
    """A scene that all solvers are given, with output times, parameters and one state to begin from."""

    model: Model
    experiment: Experiment  # `at` holds the output times; the tolerance is each solver's own
    parameters: Mapping[str, float]
    start: "NDArray[np.float64]"  # (2 n,): on the constraints
    pieces: tuple[Piece, ...]

    @property
    def n(self) -> int:
        """The number of coordinates."""
        return self.model.scene.n

    @property
    def times(self) -> tuple[float, ...]:
        """Output times, s."""
        assert self.experiment.at is not None
        return self.experiment.at

    @property
    def is_constrained(self) -> bool:
        """Whether multipliers are left."""
        return bool(self.model.scene.sizes["n_multipliers"])

    @cached_property
    def groups(self) -> list[list[int]]:
        """Coordinates of one unit: their errors are measured by the largest of them."""
        units = [column.unit for column in self.model.scene.coordinates]
        return [[k for k, unit in enumerate(units) if unit == chosen] for chosen in dict.fromkeys(units)]

    def error(self, found: "NDArray[Any]", exact: "NDArray[Any]") -> float:
        """Largest error of a coordinate at an output time, relative to the largest value of the coordinates of its unit.

        Both (len(times), n). Angles that stay small count as at least 1e-3 rad, so do lengths in m: rounding is no error.
        """
        worst = 0.0
        for group in self.groups:
            scale = max(float(np.abs(exact[:, group]).max()), 1e-3)
            difference = float(np.abs(found[:, group] - exact[:, group]).max())
            worst = max(worst, difference / scale if np.isfinite(difference) else np.inf)
        return worst

    def collect(self, portions: "list[NDArray[Any]]") -> "NDArray[Any]":
        """States on the grids of the pieces, (rows, 2 n) each -> positions at the output times, (len(times), n)."""
        rows = [self.start[None, : self.n]] if self.times[0] <= self.pieces[0].begin else []
        for piece, states in zip(self.pieces, portions, strict=True):
            wanted = set(piece.times)
            rows.append(states[[k for k, t in enumerate(piece.grid) if t in wanted], : self.n])
        return np.concatenate(rows)


def build_problem(model: Model, request: Request = USUAL, points: int = 10) -> Problem:
    """`points` output times at equal distances, the last at the stop time. Raises LagError, RunError."""
    model.native = True  # compiled as a whole before the clock runs, as the peers are
    whole = plan(model.scene, request)
    given = dict(request.parameters or {})
    model = model.fitting(given)
    values = check_values(model.scene, given)
    table = model.compilation.functions.table
    if not model.scene.coordinates:
        fail("L0505", "nothing moves: there is no motion whose error could be measured")
    refuse_attitudes(model.compilation.graph.attitudes, "comparing integrators", HINGES)
    if "kick" in table or "resets" in table:
        fail("L0909", "not supported yet: to compare integrators on a scene whose rates or supports jump", None,
             "they would have to be told of the impulses; lag simulate takes them into account")
    p = np.array(table["parameters"](values.parameters, values.mask))
    corners = [float(t) for t in switching_times(model.compilation, whole, p)]
    length = whole.stop - whole.start
    times = tuple(_beside(whole.start + length * k / points, corners, length) for k in range(1, points + 1))
    experiment = replace(whole, at=times)
    # Assembly is no part of the integration: everyone starts where our run starts.
    instant = replace(whole, stop=whole.start, at=(whole.start,), tolerance=_LOOSEST)
    _, portions = model.launch(instant, values)
    row = np.concatenate([np.asarray(portion) for portion in portions])
    start = row[1 : 1 + 2 * model.scene.n].copy()
    pieces, now = [], experiment.start
    for end, inside in segments(now, list(times), corners):
        pieces.append(Piece(now, end, tuple(inside), _slope(model, p, values.input_values, 0.5 * (now + end))))
        now = end
    return Problem(model, experiment, given, start, tuple(pieces))


def _beside(time: float, corners: list[float], length: float) -> float:
    """An output time that rounding alone parts from an event is the event's: no solver makes a step of 1e-16 s."""
    return next((corner for corner in corners if abs(corner - time) < 1e-12 * length), time)


def _slope(model: Model, p: Any, inputs: Any, middle: float) -> ca.Function:
    """The accelerations that our own run time evaluates, as they are between two events."""
    table, n = model.compilation.functions.table, model.scene.n
    t, y = ca.SX.sym("t"), ca.SX.sym("y", 2 * n)
    d = table["modes"](middle, p, 0) if "modes" in table else ca.DM(0, 1)
    u = ca.DM(list(inputs)) if len(inputs) else ca.DM(0, 1)
    a = live("rhs", table)(t, y[:n], y[n:], u, d, table["hoist"](p))[0]
    return ca.Function("slope", [t, y], [ca.cse(ca.densify(ca.vertcat(y[n:], a)))], ["t", "y"], ["dy"])
