"""Scene -> rows of results: checks the values given, builds or finds the native code, and drives the run time.

The run time itself is C (runtime/); rows come in portions, so that memory stays bounded and a run can be watched and stopped.
"""

import math
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import pairwise
from typing import Any

from lagrangia.diagnostics import Diagnostic, LagError, Report, RunError, fail, suggest, tell_miss
from lagrangia.engines import Engine
from lagrangia.given import a_count, a_number, by_name, numbers
from lagrangia.runtime import Failure, Run, Settings, Statistics, Status
from lagrangia.scene import Scene
from lagrangia.solvers import AUTO, is_casadi, number_of

_PORTION = 4096  # rows
_PAUSE = 0.1  # seconds between two looks at the clock and the keyboard
_MOST_ROWS = 100_000_000
_MANY_STEPS, _MUCH = 100, 100.0
DOUBTFUL = 0.1  # of all energy: an account that misses by more
_LITTLE = 1e-9  # J: less may be rounding of energies that cancel


@dataclass(frozen=True)
class Experiment:
    """What to compute. `at` holds the ascending times of the rows; without it they are `interval` apart."""

    start: float
    stop: float
    tolerance: float
    interval: float
    at: tuple[float, ...] | None = None
    max_step: float = 0.0
    max_steps: int = 0
    solver: str = AUTO

    def count(self) -> int:
        if self.at is not None:
            return len(self.at)
        intervals = min((self.stop - self.start) / self.interval, 2.0 * _MOST_ROWS)
        nearest = round(intervals)
        is_on_grid = abs(intervals - nearest) <= 1e-9 + 1e-12 * nearest
        return 1 + (nearest if is_on_grid else math.ceil(intervals))  # the stop time has a row of its own

    def times(self) -> Iterator[list[float]]:
        """The times of the rows, in portions."""
        if self.at is not None:
            for k in range(0, len(self.at), _PORTION):
                yield list(self.at[k : k + _PORTION])
            return
        count = self.count()
        for k in range(0, count, _PORTION):
            portion = [self.start + i * self.interval for i in range(k, min(count, k + _PORTION))]
            if k + len(portion) == count:
                portion[-1] = self.stop
            yield portion


@dataclass(frozen=True)
class Values:
    """Values given for a run: parameters with a mask, start values with NaN where nothing is given, and a table of inputs."""

    parameters: tuple[float, ...]
    mask: tuple[float, ...]
    q: tuple[float, ...]
    v: tuple[float, ...]
    input_times: Sequence[float] = (0.0,)
    input_values: Sequence[float] = ()
    lost: tuple[float, ...] = ()  # as `scene.lost` places them, NaN where nothing is given


@dataclass
class Progress:
    """What is known of a run while it goes on and when it has ended."""

    experiment: Experiment
    rows: int = 0
    time: float = math.nan
    seconds: float = 0.0
    statistics: Statistics | None = None
    parameters: list[float] = field(default_factory=list)
    has_power: bool = False  # the account holds integrals of powers, which have errors of their own
    is_driven: bool = False  # something is moved in time, and may bring energy whatever the steps
    contacts: tuple[str, ...] = ()  # of each event, what to call it
    interrupted: bool = False


# -------------------------------------------------------------------- checking what is given


def plan(scene: Scene, *, stop: float | None = None, start: float | None = None, tolerance: float | None = None,
         interval: float | None = None, at: Sequence[float] | None = None, max_step: float = 0.0,
         max_steps: int = 0, solver: str = AUTO) -> Experiment:
    """The experiment of the annotation with what is given instead. Raises LagError L0702."""
    report = Report()
    given = (("start time", start), ("stop time", stop), ("tolerance", tolerance), ("interval", interval))
    start, stop, tolerance, interval = (None if value is None else a_number(what, value) for what, value in given)
    max_step, max_steps = a_number("largest step", max_step), a_count("number of steps", max_steps)
    begin = scene.start if start is None else start
    end = (at[-1] if at and stop is None else scene.stop if stop is None else stop) if at is None or len(at) else scene.stop
    accuracy = scene.tolerance if tolerance is None else tolerance
    if not is_casadi(str(solver)):
        number_of(solver, scene)
    _check_times(at, begin, end, report)
    report.raise_errors()
    for name, value in (("start time", begin), ("stop time", end), ("tolerance", accuracy)):
        if not math.isfinite(value):
            report.error("L0702", f"the {name} must be a finite number, not {value}")
    report.raise_errors()
    if not end > begin and not (at and end == begin):
        report.error("L0702", f"the stop time {end:g} must be later than the start time {begin:g}")
    if not 0 < accuracy < 1:
        report.error("L0702", f"the tolerance must lie between 0 and 1, not {accuracy:g}", None, "1e-6 is loose, 1e-12 is tight")
    usual = scene.interval if scene.interval is not None and stop is None else (end - begin) / 500
    step = usual if interval is None else interval
    if interval is not None and not (math.isfinite(interval) and interval > 0):
        report.error("L0702", f"the interval must be a positive number, not {interval}")
    if max_step < 0 or not math.isfinite(max_step):
        report.error("L0702", f"the largest step must be a positive number, not {max_step}")
    if max_steps < 0:
        report.error("L0702", f"the number of steps must not be negative, as {max_steps} is; 0 sets no limit")
    report.raise_errors()
    experiment = Experiment(begin, end, accuracy, step or 1.0, tuple(at) if at is not None else None, max_step, max_steps,
                            solver)
    if experiment.count() > _MOST_ROWS:
        report.error("L0702", f"more than {_MOST_ROWS} rows are asked for", None, "choose a longer interval")
        report.raise_errors()
    return experiment


def _check_times(at: Sequence[float] | None, begin: float, end: float, report: Report) -> None:
    if at is None:
        return
    if not at:
        report.error("L0702", "no output time is given")
    elif any(not math.isfinite(t) for t in at) or any(b <= a for a, b in pairwise(at)):
        report.error("L0702", "the output times must be finite and rising")
    elif at[0] < begin or at[-1] > end:
        report.error("L0702", f"the output times must lie between {begin:g} and {end:g}")


def check_values(
    scene: Scene, parameters: Mapping[str, float] | None = None, initial: Mapping[str, float] | None = None,
    inputs: "Mapping[str, float] | tuple[Sequence[float], Mapping[str, Sequence[float]]] | None" = None,
) -> Values:
    """Names to places. `inputs`: constants by name, or (times, values by name). Raises LagError (L06xx, L07xx)."""
    report = Report()
    place = {p.name: k for k, p in enumerate(scene.parameters)}
    values = [0.0 if p.value is None else p.value for p in scene.parameters]
    mask = [0.0 if p.value is None else 1.0 for p in scene.parameters]
    for name, value in by_name("parameters", parameters).items():
        if name not in place:
            _unknown("parameter", name, [*place, *scene.structural], report)
        elif locked := scene.parameters[place[name]].locked:
            report.error("L0701", f"the parameter '{name}' is {locked}: it cannot be set", None,
                         f"declared at {scene.parameters[place[name]].place}")
        elif not math.isfinite(a_number(f"parameter '{name}'", value)):
            report.error("L0605", f"the parameter '{name}' must be a finite number, not {value}")
        else:
            values[place[name]], mask[place[name]] = float(value), 1.0
    start, lost = _start_values(scene, by_name("start values", initial), report)
    times, table = _input_table(scene, inputs, report)
    report.raise_errors()
    return Values(tuple(values), tuple(mask), tuple(start[: scene.n]), tuple(start[scene.n :]), times, table, tuple(lost))


def _start_values(scene: Scene, initial: Mapping[str, float], report: Report) -> tuple[list[float], list[float]]:
    """Of coordinates and rates; of lost ones and their rates."""
    start, lost = [math.nan] * (2 * scene.n), [math.nan] * (2 * scene.sizes["n_lost"])
    outputs = {column.name for column in scene.outputs}
    for name, value in initial.items():
        slot = scene.slot(name)
        if not math.isfinite(a_number(f"initial value of '{name}'", value)):
            report.error("L0605", f"the initial value of '{name}' must be a finite number, not {value}")
        elif slot is not None:
            start[slot] = float(value)
        elif name in scene.lost:
            lost[scene.lost[name][0]] = float(value)
        elif name.removeprefix("der(").removesuffix(")") in scene.notes["prescribed"]:
            report.error("L0701", f"'{name}' is prescribed as a function of time: it starts as that says", None,
                         "change the function, or parameters in it")
        elif name in outputs:
            report.error("L0701", f"'{name}' follows from the coordinates, and the scene states no start for it", None,
                         f"start one of {', '.join(c.name for c in scene.coordinates[:6])}, or declare a start for "
                         f"'{name}' in the model: it can then be given here")
        else:
            known = [*(c.name for c in (*scene.coordinates, *scene.rates)), *scene.aliases, *scene.lost]
            _unknown("coordinate or rate", name, known, report)
    return start, lost


def _input_table(scene: Scene, inputs: Any, report: Report) -> tuple[Sequence[float], Sequence[float]]:
    names = [p.name for p in scene.inputs]
    times: Sequence[float] = [scene.start]
    columns: dict[str, Sequence[float]] = {}
    if isinstance(inputs, tuple):
        if len(inputs) != 2:
            fail("L0703", f"a table of inputs is a pair (times, values by name), not {len(inputs)} things")
        times = numbers("times of the inputs", inputs[0])
        columns = {name: numbers(f"values of the input '{name}'", given) for name, given in by_name("inputs", inputs[1]).items()}
    else:
        columns = {name: [a_number(f"input '{name}'", value)] for name, value in by_name("inputs", inputs).items()}
    for name, column in columns.items():
        if name not in names:
            _unknown("input", name, names, report)
        if len(column) != len(times):
            report.error("L0703", f"the input '{name}' has {len(column)} values for {len(times)} times")
        if not all(map(math.isfinite, (*column, *times))):
            report.error("L0703", f"the input '{name}' must be finite everywhere")
    if any(b < a for a, b in pairwise(times)):
        report.error("L0703", "the times of the inputs must not fall")
    full = [columns.get(p.name, [p.value or 0.0] * len(times)) for p in scene.inputs]
    return times, [column[row] for row in range(len(times)) for column in full if row < len(column)]


def _unknown(what: str, name: str, known: Sequence[str], report: Report) -> None:
    report.error("L0701", f"the scene has no {what} '{name}'", None, *filter(None, [suggest(name, known)]))


def check_parameters(scene: Scene, parameters: Sequence[float]) -> None:
    """All parameters, dependent ones too, must be finite and within the limits of their types. Raises LagError L0605."""
    report = Report()
    for known, value in zip(scene.parameters, parameters, strict=True):
        unit = f" {known.unit}" if known.unit else ""
        what, where = f"the parameter '{known.name}'", f"declared at {known.place}"
        if not math.isfinite(value):
            report.error("L0605", f"{what} has no finite value: {value}", None, where)
        elif known.minimum is not None and value < known.minimum:
            report.error("L0605", f"{what} is {value:g}{unit}, less than its minimum {known.minimum:g}{unit}", None, where)
        elif known.maximum is not None and value > known.maximum:
            report.error("L0605", f"{what} is {value:g}{unit}, more than its maximum {known.maximum:g}{unit}", None, where)
    report.raise_errors()


# -------------------------------------------------------------------- the run


def simulate(
    scene: Scene, engine: Engine, experiment: Experiment, values: Values, watch: Callable[[Progress], None] | None = None
) -> "tuple[Progress, Iterator[Sequence[float]]]":
    """The progress, and an iterator over portions of rows (flat; t, q, v, y, T, V, H, dissipated, work).

    Raises LagError for values the scene cannot have, at once; the iterator raises RunError when the run cannot go on, after the
    rows computed so far. KeyboardInterrupt ends the rows and marks the progress.
    """
    run = start_run(scene, engine, experiment, values)
    progress = Progress(experiment, parameters=run.parameters, has_power=scene.sizes["n_power"] > 0,
                        is_driven=bool(scene.notes["is_driven"]), contacts=tuple(scene.notes["contacts"]))
    return progress, _rows(scene, engine, run, progress, watch)


def start_run(scene: Scene, engine: Engine, experiment: Experiment, values: Values) -> Run:
    """A run of the run time, assembled and ready to advance; to be closed. Raises LagError, RunError."""
    settings = Settings(experiment.start, experiment.stop, experiment.tolerance, experiment.max_step, 0.0, experiment.max_steps,
                        number_of(experiment.solver, scene))
    run = engine.runtime.run(engine.model, settings)
    try:
        run.set_parameters(values.parameters, values.mask)
        check_parameters(scene, run.parameters)
        if scene.inputs:
            run.set_inputs(values.input_times, values.input_values)
        run.set_lost(values.lost or [math.nan] * (2 * scene.sizes["n_lost"]))
        status = run.start(values.q, values.v)
        if status is not Status.OK:
            _fail_start(scene, run.failure)
    except BaseException:
        run.close()
        raise
    return run


def _rows(
    scene: Scene, engine: Engine, run: Run, progress: Progress, watch: Callable[[Progress], None] | None
) -> Iterator[Sequence[float]]:
    begin = time.perf_counter()
    start, span = progress.experiment.start, progress.experiment.stop - progress.experiment.start
    with run:
        for times in progress.experiment.times():
            done = 0
            while done < len(times):
                try:
                    rows = run.advance(times[done:], _PAUSE)
                except KeyboardInterrupt:
                    progress.interrupted = True
                    return
                finally:
                    progress.seconds, progress.statistics, progress.time = time.perf_counter() - begin, run.statistics, run.time
                engine.look(progress.seconds, (progress.time - start) / span if span > 0 else 1.0)
                done += rows.count
                progress.rows += rows.count
                if rows.count:
                    yield rows.values
                if watch is not None:
                    watch(progress)
                if rows.status not in (Status.OK, Status.PAUSED):
                    raise RunError(explain(scene, run.failure))


def _fail_start(scene: Scene, failure: Failure) -> None:
    if failure.status is Status.INITIAL_FAILED:
        what, excerpt = scene.initial_places[failure.index]
        unit = "m or rad" if failure.index < scene.sizes["n_initial_positions"] else "m/s or rad/s"
        raise LagError([Diagnostic("error", "L0606", f"{what}: {tell_miss(failure.value, unit)}", None, "",
                                   ("change the parameters it depends on, or the start values it is solved from",), excerpt)])
    raise RunError(explain(scene, failure))


def explain(scene: Scene, failure: Failure) -> str:
    """When, where and what to try."""
    if failure.status is Status.INITIAL_FAILED:
        return f"the initial equations cannot all hold: one misses by {abs(failure.value):.3g}"
    column = (scene.rates if failure.rate else scene.coordinates)[failure.index] if 0 <= failure.index < scene.n else None
    where = f" ({column.name})" if column else ""
    if failure.status is Status.NOT_FINITE:
        return (f"at t = {failure.time:.6g} the accelerations are not finite{where}: a coordinate that moves no mass, "
                "points that coincide, or a function outside its domain; look at the parameters and start values")
    if failure.status is Status.STEP_TOO_SMALL:
        return (f"the motion cannot be continued beyond t = {failure.time:.9g}: no step is small enough{where}; a singularity "
                "(a collision, a spring of zero length, a division by zero) or values beyond the range of numbers")
    if failure.status is Status.EVENTS_GO_ON:
        return (f"the motion cannot be continued beyond t = {failure.time:.9g}: events that reset rates bring each other about "
                "without end; look at what `when` and reinit make of each other there")
    if failure.status is Status.NO_IMPULSE:
        return (f"the motion cannot be continued beyond t = {failure.time:.9g}: contacts and their friction have neither forces "
                "nor impulses that go together (Painleve's paradox: rigid bodies jam); try less friction, or springs in between")
    if failure.status is Status.CONSTRAINTS_OPEN:
        return (f"the constraints do not close at t = {failure.time:.6g}: one is open by {failure.value:.1e} of the motion, near "
                "a singular position or between masses too uneven for the tolerance; try a smaller one, or another solver")
    if failure.status is Status.NO_PROGRESS:
        return (f"there is no progress at t = {failure.time:.9g}{where}: the rest would take {failure.value:.1e} steps as short "
                "as are needed there, where something jumps, bends or vibrates; try another solver or a larger tolerance, or let "
                "it go on with --max-steps")
    if failure.status is Status.TOO_MANY_STEPS:
        return (f"the limit of steps is reached at t = {failure.time:.6g}{where}; raise --max-steps, or loosen the tolerance")
    return f"the run stopped at t = {failure.time:.6g}: {failure.status.name.lower().replace('_', ' ')}"


def shortcomings(progress: Progress) -> list[str]:
    """What kept a run from its tolerance, in words; empty when nothing did.

    Beside what the run time counted: an energy account that closes MUCH worse than the tolerance shows that errors have added up,
    in runs of many steps (in a few, the rounding of the first state can be all that moves). Where powers are integrated, whose
    errors do not limit steps, they may be those of the account alone; where that is DOUBTFUL as a whole, so is the motion.
    """
    statistics, tolerance = progress.statistics, progress.experiment.tolerance
    if statistics is None:
        return []
    found: list[str] = []
    if statistics.tolerance_raised:
        found.append("the tolerance was raised to 1e-14, the smallest that double precision can keep")
    if statistics.tolerance_missed:
        steps = f"{statistics.tolerance_missed} step{'s' if statistics.tolerance_missed != 1 else ''}"
        found.append(f"{steps} missed the tolerance, as happens near singular positions, and where little but rounding is left")
    if statistics.passed:
        found.append(f"{progress.contacts[statistics.passed - 1]} is passed at the start already, so that nothing "
                     "strikes it before it has been left: start outside it")
    missed = _missed_energy(progress)
    if missed > _MUCH * tolerance and not loss(progress):
        what = f"errors have added up until the energy account misses by {missed:.1e} of its size"
        if not progress.has_power:
            found.append(f"the tolerance {tolerance:g} was not kept to the end: {what}")
        else:
            doubt = "; more likely the motion itself is wrong: compare with a smaller tolerance, or another solver"
            found.append(f"{what}, perhaps in its integrals of powers alone{doubt if missed > DOUBTFUL else ''}")
    return found


def loss(progress: Progress) -> str:
    """Why rows cannot be those of the scene; empty where nothing tells so.

    The run time judges the energy account at each row, by the tolerance, the number of steps and what these know of the errors of
    its integrals of powers; CasADi's integrators tell nothing of that.
    """
    s = progress.statistics
    if s is None or not (s.energy_is_open or _is_beyond_doubt(progress)):
        return ""
    relative, reason = s.energy_residual / s.energy_size, ""
    what = (f"misses by {s.energy_residual:.1e} J, {relative:.1e} of its size, more than the tolerance "
            f"{progress.experiment.tolerance:g} explains,")
    if relative > DOUBTFUL:
        what, reason = "does not close at all", "has a singularity (a collision, a division by zero) or "
    since = f" from t = {s.energy_open:.6g} on" if s.energy_is_open else ""
    return (f"the energy account {what}{since}: the rows there are not the motion of this scene, which {reason}needs a smaller "
            "tolerance, or another solver")


def _is_beyond_doubt(progress: Progress) -> bool:
    if _missed_energy(progress) <= max(DOUBTFUL, _MUCH * progress.experiment.tolerance):
        return False
    return not progress.has_power or _rises_from_nothing(progress)


def _rises_from_nothing(progress: Progress) -> bool:
    """Whether H rose by MUCH more than powers ever gave it: however badly they are integrated, they would have shown. What is
    moved in time may have energy whether steps saw it move or not."""
    s = progress.statistics
    return s is not None and not progress.is_driven and s.energy_risen > max(DOUBTFUL * s.energy_stored, _MUCH * s.energy_given)


def _missed_energy(progress: Progress) -> float:
    """By how much the energy account misses, relative; 0 for short runs, unless that is DOUBTFUL and no rounding. CasADi's
    integrators do not tell their steps."""
    statistics = progress.statistics
    if statistics is None or not 0 < statistics.energy_size < math.inf:
        return 0.0
    missed = statistics.energy_residual / statistics.energy_size
    is_long = (statistics.steps or progress.rows) > _MANY_STEPS
    return missed if is_long or (missed > DOUBTFUL and statistics.energy_residual > _LITTLE) else 0.0


__all__ = [
    "DOUBTFUL", "Engine", "Experiment", "Progress", "Values", "check_values", "explain", "loss", "plan", "shortcomings",
    "simulate", "start_run",
]
