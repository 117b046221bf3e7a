"""A run whose inputs are a caller's functions of what is seen at equal distances of time: sampled feedback."""

import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from typing import TYPE_CHECKING, Any, Protocol

from lagrangia.base.checked_values import a_number
from lagrangia.base.diagnostics import Interrupted, RunError, fail
from lagrangia.run.remarks import warn_of_loss
from lagrangia.run.request import Experiment, Request, Values, check_values, plan
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import progress_of
from lagrangia.run.stepped import SteppedRun
from lagrangia.study.observing import observe
from lagrangia.view.trajectory import Trajectory

if TYPE_CHECKING:
    import numpy as np

    from lagrangia.compile.pipeline import Compilation

Controller = Callable[[float, SteppedRun], float]
_CLOSE = 1e-9  # of a period: the last step


class Startable(Protocol):
    """A model that runs in steps."""

    scene: Scene

    @property
    def compilation(self) -> "Compilation":
        """What each phase made."""

    def start(self, *, parameters: Any, initial: Any, inputs: Any, start: float, tolerance: float, solver: str, max_step: float
              ) -> SteppedRun:
        """A run in the caller's hands."""


def simulate_controlled(model: Startable, request: Request, controllers: Mapping[str, Controller], every: float) -> Trajectory:
    """Rows `every` so many seconds, at which the controllers are asked for the inputs that hold until the next one.

    Raises LagError, RunError and Interrupted with what was computed; what a controller raises goes through.
    """
    experiment = plan(model.scene, request)
    _check(model.scene, request, controllers, every)
    begin = time.perf_counter()
    run = model.start(parameters=request.parameters, initial=request.initial, inputs=request.inputs, start=experiment.start,
                      tolerance=experiment.tolerance, solver=experiment.solver, max_step=experiment.max_step)
    rows, held = [run.row], []
    failure: BaseException | None = None
    try:
        for dt in _periods(experiment, every):
            run.set({name: control(run.time, run) for name, control in controllers.items()})
            held.append(list(run.inputs.values()))
            run.step(dt)
            rows.append(run.row)
    except (RunError, KeyboardInterrupt) as error:
        failure = error
    trajectory = _trajectory(model, request, experiment, run, rows, held, time.perf_counter() - begin)
    if isinstance(failure, RunError):
        failure.trajectory = trajectory
        raise failure
    if failure is not None:
        trajectory.progress.interrupted = True
        raise Interrupted.with_result(trajectory, f"at t = {run.time:.6g}")
    if not run.told_open:
        warn_of_loss(trajectory.progress)
    return trajectory


def _check(scene: Scene, request: Request, controllers: Mapping[str, Controller], every: float) -> None:
    if not controllers:
        fail("L0702", "`every` has no meaning without controllers", None, 'controllers={"F": f} asks f(t, run) for the input F')
    if not (math.isfinite(a_number("period of the controllers", every)) and every > 0):
        fail("L0702", f"the controllers need a period: every is a positive number of seconds, not {every}")
    given = request.inputs[1] if isinstance(request.inputs, tuple) and len(request.inputs) == 2 else request.inputs or {}
    if twice := next((name for name in controllers if name in given), None):
        fail("L0712", f"'{twice}' is given twice", None, "by inputs, and by a controller")
    if request.interval is not None or request.at is not None:
        fail("L0702", "rows stand where the controllers are asked: interval and at have no effect")
    if request.max_steps:
        fail("L0702", "not supported yet: a limit of steps beside controllers")
    known = [item.name for item in scene.inputs]
    for name, control in controllers.items():
        if name not in known:
            fail("L0701", f"the scene has no input '{name}'", None, f"its inputs are {', '.join(known) or 'none'}")
        if not callable(control):
            fail("L0702", f"the controller of '{name}' is a function f(t, run), not {control!r}"[:200])


def _periods(experiment: Experiment, every: float) -> "Sequence[float]":
    whole = (experiment.stop - experiment.start) / every
    count = math.floor(whole + _CLOSE)
    rest = (whole - count) * every
    return [every] * count + ([rest] if rest > _CLOSE * every else [])


def _trajectory(model: Startable, request: Request, experiment: Experiment, run: SteppedRun, rows: "list[np.ndarray]",
                held: list[list[float]], seconds: float) -> Trajectory:
    import numpy as np

    scene = run.scene
    table = np.array(rows)
    values = check_values(scene, request.parameters, request.initial, request.inputs)
    times = table[:, 0]
    if held:
        u = np.repeat(held[: len(rows) - 1] or held[:1], 2, axis=0)
        moments = np.repeat(times, 2)[1:-1] if len(rows) > 1 else np.repeat(times, 2)
        values = replace(values, input_times=moments.tolist(), input_values=u.ravel().tolist())
    progress = progress_of(scene, experiment, rows=len(rows), time=run.time, seconds=seconds, statistics=run.statistics,
                           parameters=run.parameters, engine=run.engine)
    return Trajectory(scene, table, progress, partial(_observe, model, scene, np.array(run.parameters), values))


def _observe(model: Startable, scene: Scene, parameters: "np.ndarray", values: Values, name: str, rows: "np.ndarray",
             start: float) -> "np.ndarray":
    return observe(scene, model.compilation, parameters, values, name, rows, start)
