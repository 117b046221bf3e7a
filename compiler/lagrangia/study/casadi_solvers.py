"""Runs with CasADi's own integrators: an independent check, and the way without a C compiler.

Between two time events the equations are smooth; each such segment is one integrator with the grid of rows that fall into it.
Source: the integrators of CasADi (CVODES and IDAS of SUNDIALS, Hindmarsh et al., 2005).
"""

import bisect
import math
import time
from array import array
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise
from typing import Any

import casadi as ca
import numpy as np

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.interruptions import noticed
from lagrangia.base.records import dataclass
from lagrangia.compile.pipeline import Compilation
from lagrangia.dynamics.switches import has_dry_friction, live
from lagrangia.run.input_pieces import InputTable
from lagrangia.run.request import Experiment, Values, check_parameters
from lagrangia.run.runtime import Statistics
from lagrangia.run.simulate import Progress
from lagrangia.run.solvers import AUTO
from lagrangia.study.turned_state import TurnedState

_INTEGRATORS = ("cvodes", "idas", "rk", "collocation")
_MOST_STEPS = 10_000_000
_SHARE = 0.001  # of the tolerance, where one takes the place of our own solver: errors of CVODES are larger than its tolerance


def simulate_casadi(
    compilation: Compilation, experiment: Experiment, values: Values, watch: Callable[[Progress], None] | None = None
) -> tuple[Progress, Iterator[Sequence[float]]]:
    """Like simulate.simulate, with an integrator of CasADi: `casadi:cvodes`, `casadi:idas`, ...; others mean cvodes.

    Raises LagError L0704 for one that does not fit, and what simulate.simulate raises."""
    name = experiment.solver.partition(":")[2] or "cvodes"
    if name not in _INTEGRATORS:
        fail("L0704", f"CasADi has no integrator '{name}' that fits", None, f"known here: {', '.join(_INTEGRATORS)}")
    run = _Run(compilation, experiment, values, name)
    check_parameters(compilation.scene, run.p.ravel().tolist())
    progress = Progress(experiment, parameters=run.p.ravel().tolist(), has_power=compilation.scene.sizes["n_power"] > 0,
                        engine=f"casadi:{name}")
    return progress, run.rows(progress, watch)


def casadi_refusal(compilation: Compilation) -> tuple[str, str] | None:
    """Why CasADi's integrators cannot run the scene, and what helps."""
    if not compilation.motion.q.numel():
        return ("not supported yet: a scene without coordinates, with CasADi's integrators",
                "the run time takes it: it needs a C compiler (pip install ziglang)")
    if compilation.motion.constrained:
        return ("not supported yet: constraints that stay in the equations, with CasADi's integrators",
                "closed loops and the like need the run time: a C compiler (pip install ziglang)")
    if "resets" in compilation.functions.table:
        return (f"not supported yet: a scene in which {compilation.flat.set_at_events} at events, with CasADi's integrators",
                "the run time takes them: a C compiler (pip install ziglang)")
    if "initial" in compilation.functions.table:
        return ("not supported yet: initial equations to be solved, with CasADi's integrators",
                "give the start values of coordinates and rates, or install a C compiler (pip install ziglang)")
    if compilation.flat.samplers:
        return ("not supported yet: values that are held between instants, with CasADi's integrators",
                "the run time takes them: a C compiler (pip install ziglang)")
    if compilation.flat.guards:
        return ("not supported yet: assertions and terminate, with CasADi's integrators",
                "the run time takes them: a C compiler (pip install ziglang)")
    if compilation.flat.delays:
        return ("not supported yet: delays, with CasADi's integrators",
                "the run time takes them: a C compiler (pip install ziglang)")
    if has_dry_friction(compilation.run):
        return ("not supported yet: dry friction, which sticks, with CasADi's integrators, which chatter about rest",
                "the run time takes it: a C compiler (pip install ziglang)")
    return None


@dataclass
class _Run:
    compilation: Compilation
    experiment: Experiment
    values: Values
    integrator: str
    begin: float | None = None  # H in the first row
    given: float = 0.0  # energy given by jumps at events, where no work is integrated
    modes: Any = None  # of the segment before
    residual: float = 0.0
    scale: float = 0.0

    def __post_init__(self) -> None:
        table = self.compilation.functions.table
        self.n = self.compilation.scene.n
        self.state = TurnedState(self.compilation.scene)
        self.p = np.array(table["parameters"](self.values.parameters, self.values.mask))
        self.c = table["hoist"](self.p)
        self.inputs = InputTable(self.compilation.scene, self.values, self.experiment.start)
        self.y = self._start(table)

    def _start(self, table: Any) -> np.ndarray:
        if refusal := casadi_refusal(self.compilation):
            fail("L0909", refusal[0], None, refusal[1])
        q, v = (np.array(x).ravel() for x in table["start"](self.p))
        given = np.array([*self.values.q, *self.values.v])
        start = np.where(np.isnan(given), np.concatenate([q, v]), given)
        references = self._declared_modes()
        told = self.state.begun(start[: self.n], np.array(self.values.q), references)
        return np.concatenate([told, start[self.n :], np.zeros(2 * bool(self.compilation.functions.n_power))])

    def _declared_modes(self) -> np.ndarray:
        """Modes at the start, where references of attitudes are as parameters say."""
        table = self.compilation.functions.table
        return np.array(table["modes"](self.experiment.start, self.p, 0)).ravel() if "modes" in table else np.zeros(0)

    def rows(self, progress: Progress, watch: Callable[[Progress], None] | None) -> Iterator[Sequence[float]]:
        begin = time.perf_counter()
        corners = switching_times(self.compilation, self.experiment, self.p, self.inputs)
        now = self.experiment.start
        for times in self.experiment.times():
            for target, wanted in segments(now, times, corners):
                try:
                    found = self._advance_noticing(now, target, wanted)
                except RuntimeError as error:
                    reason = str(error).splitlines()[-1]
                    between = f"between t = {now:.6g} and {target:.6g}"
                    raise RunError(f"CasADi's {self.integrator} gave up {between}: {reason}") from None
                except KeyboardInterrupt:
                    progress.interrupted = True
                    return
                finally:
                    progress.seconds, progress.time = time.perf_counter() - begin, now
                now = target
                progress.rows, progress.time = progress.rows + len(wanted), now
                if wanted:
                    rows = self._full_rows(wanted, found)
                    progress.statistics = self._account(rows)
                    yield array("d", rows.ravel())
                if watch is not None:
                    watch(progress)

    def _account(self, rows: np.ndarray) -> Statistics:
        """The largest residual of the energy account in all rows so far; CasADi tells nothing of its steps."""
        T, V, H, dissipated, work = rows[:, -5:].T
        if self.begin is None:
            self.begin = float(H[0])
        residual = float(np.abs(H - self.begin + dissipated - work).max())
        scale = float(np.abs([T, V, H, dissipated, work]).max())
        self.residual, self.scale = max(self.residual, residual), max(self.scale, scale)
        return Statistics(0, 0, 0, 0, 0, 0.0, 0.0, self.residual, self.scale, 0, False)

    # ------------------------------------------------------------ segments

    def _inputs(self, t: Any, now: float, target: float) -> Any:
        """u(t) on a segment: linear between the table's rows, held outside."""
        if not self.compilation.scene.inputs:
            return ca.DM(0, 1)
        table, times = np.nan_to_num(self.inputs.rows), self.inputs.times
        middle = 0.5 * (now + target)
        k = bisect.bisect_right(list(times), middle)
        if k in (0, len(times)):
            return ca.DM(table[min(k, len(times) - 1)])
        slope = (table[k] - table[k - 1]) / (times[k] - times[k - 1])
        return ca.DM(table[k - 1]) + ca.DM(slope) * (t - times[k - 1])

    def _modes(self, now: float, target: float) -> Any:
        table = self.compilation.functions.table
        if "modes" not in table:
            return ca.DM(0, 1)
        middle = 0.5 * (now + target)
        given = _given(self.compilation, self.inputs, middle)
        found, (a, b) = np.array(table["modes"](middle, self.p, given)).ravel(), table["events"](self.p, given)
        lookups, kinds = self.compilation.functions.patterns["lookups"], self.compilation.functions.event_kinds
        for event, first in zip(lookups[::2], lookups[1::2], strict=True):
            piece = self.compilation.scene.tables[kinds[event] - 2].piece(float(a[event] + b[event] * middle))
            found[first : first + len(piece)] = piece
        return ca.DM(np.where(given != 0, given, found))

    def _advance_noticing(self, now: float, target: float, wanted: list[float]) -> np.ndarray:
        """Ctrl-C within an integrator, which says then that the right-hand side has failed, stays Ctrl-C."""
        with noticed() as came:
            try:
                return self._advance(now, target, wanted)
            except RuntimeError:
                if came:
                    raise KeyboardInterrupt from None
                raise

    def _advance(self, now: float, target: float, wanted: list[float]) -> np.ndarray:
        """States at the wanted times (columns); the state goes on to the target."""
        if target <= now:
            return np.tile(self.y[:, None], (1, len(wanted)))
        self.segment = now, target
        self._enter(now, target)
        rhs = live("rhs", self.compilation.functions.table, self.compilation.functions.patterns)
        t, y = ca.SX.sym("t"), ca.SX.sym("y", self.y.size)
        q, v, d, pace = self.state.split(y, self._modes(now, target))
        a, power, _ = rhs(t, q, v, self._inputs(t, now, target), d, self.c)
        grid = sorted({*[w for w in wanted if w > now], target})
        options: dict[str, Any] = {}
        if self.integrator in ("cvodes", "idas"):
            share = _SHARE if self.experiment.solver == AUTO else 1.0
            tolerance = max(share * self.experiment.tolerance, 1e-13)
            options = {"reltol": tolerance, "abstol": tolerance * 1e-2, "max_num_steps": _MOST_STEPS}
        elif self.integrator == "collocation":
            options = {"number_of_finite_elements": 20}
        equations = {"t": t, "x": y, "ode": ca.vertcat(pace, a, ca.vec(power))}
        solver = ca.integrator("run", self.integrator, equations, now, grid, options)
        states = np.array(solver(x0=self.y)["xf"])
        before, self.y = self.y, states[:, -1]
        place = {when: states[:, k] for k, when in enumerate(grid)} | {now: before}
        return np.array([place[w] for w in wanted]).T if wanted else np.empty((self.y.size, 0))

    def _enter(self, now: float, target: float) -> None:
        """What the modes of a new segment change at once: rates, where supports' rates jump, and H."""
        table, n, d = self.compilation.functions.table, self.n, self._modes(now, target)
        before, self.modes = self.modes, d
        if before is None or bool(ca.logic_all(before == d)):
            return
        u, first, n_y = self._inputs(now, now, target), self.state.positions, self.state.size
        (q, v, before, _), (_, _, d, _) = self.state.split(self.y, before), self.state.split(self.y, d)
        jump = -float(table["energies"](now, q, v, u, before, self.c)[2])
        if "kick" in table:
            self.y[first : first + n] += np.array(table["kick"](now, q, v, u, d, self.c, before)).ravel()
            v = self.y[first : first + n]
        jump += float(table["energies"](now, q, v, u, d, self.c)[2])
        if self.y.size > n_y:
            self.y[n_y + 1] += jump
        else:
            self.given += jump

    def _full_rows(self, times: list[float], states: np.ndarray) -> np.ndarray:
        table = self.compilation.functions.table
        now, target = getattr(self, "segment", (times[0], times[0]))
        modes = self._modes(now, target)
        patterns = self.compilation.functions.patterns
        rhs, outputs_of, rows = live("rhs", table, patterns), live("outputs", table, patterns), []
        for t, y in zip(times, states.T, strict=True):
            q, v, d, _ = self.state.split(y, modes)
            e, q, v = y[self.state.size :], np.array(q).ravel(), np.array(v).ravel()
            u = self._inputs(t, now, target)
            a, _, multipliers = rhs(t, q, v, u, d, self.c)
            outputs = outputs_of(t, q, v, a, multipliers, u, d, self.c)
            energies = table["energies"](t, q, v, u, d, self.c)
            rows.append(np.concatenate([[t], q, v, np.array(outputs).ravel(), np.array(energies).ravel(),
                                        e if e.size else [0.0, self.given]]))
        return np.array(rows)


def switching_times(
    compilation: Compilation, experiment: Experiment, p: np.ndarray, inputs: InputTable | None = None
) -> list[float]:
    """Times at which the equations jump or bend, inside the experiment; p are all parameters."""
    begin, end = experiment.start, experiment.stop
    rows = [float(t) for t in inputs.times if begin < t < end] if inputs is not None and len(inputs.times) > 1 else []
    found, table = set(rows), compilation.functions.table
    bounds = [begin, *sorted(found), end] if "pieces" in compilation.functions.patterns else [begin, end]
    for first, last in pairwise(bounds) if "events" in table else []:
        a, b = (np.array(x).ravel() for x in table["events"](p, _given(compilation, inputs, 0.5 * (first + last))))
        found |= {t for t in _crossings(compilation, a, b, first, last) if first < t < last}
    return sorted(found)


def _given(compilation: Compilation, inputs: InputTable | None, middle: float) -> np.ndarray:
    """Modes of which those are filled in that are pieces of inputs."""
    found = np.zeros(len(compilation.kinematics.algebra.modes))
    for first, piece in inputs.pieces_within(middle) if inputs is not None else []:
        found[first : first + len(piece)] = piece
    return found


def _crossings(compilation: Compilation, a: np.ndarray, b: np.ndarray, begin: float, end: float) -> Iterator[float]:
    """Where arguments a + b t of events cross what their kinds say, and perhaps beyond the ends."""
    for offset, slope, kind in zip(a, b, compilation.functions.event_kinds, strict=True):
        ends = sorted((offset + slope * begin, offset + slope * end))
        if slope == 0 or not np.isfinite(offset):
            continue
        if kind == 0:
            yield -offset / slope
        elif kind > 1:
            yield from ((x - offset) / slope for x in compilation.scene.tables[kind - 2].between(*ends))
        else:
            yield from ((k - offset) / slope for k in range(math.ceil(ends[0]), math.floor(ends[1]) + 1))


def segments(now: float, times: list[float], corners: list[float]) -> Iterator[tuple[float, list[float]]]:
    """(end of the segment, wanted times in it), cut at the corners; a time on a corner belongs before it."""
    left = list(times)
    for corner in [c for c in corners if now < c < times[-1]]:
        inside = [t for t in left if t <= corner]
        yield corner, inside
        left = left[len(inside) :]
    if left:
        yield left[-1], left
