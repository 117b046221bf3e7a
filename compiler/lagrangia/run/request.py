"""What a run is asked for -> the experiment and the values of a scene, checked.

One request is handed down from the command line, from Python, from sweeps, benchmarks and FMUs; what they add (how values of many
runs are chosen, which kind of FMU) stands beside it.
"""

import math
from collections.abc import Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from lagrangia.base.attitude_values import HINT, read_attitude, turn_of
from lagrangia.base.checked_values import a_count, a_number, by_name, misfit, numbers
from lagrangia.base.diagnostics import Report, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.run.input_rates import complete_rates
from lagrangia.run.requirements import check_requirements
from lagrangia.run.scene import Parameter, Scene
from lagrangia.run.solvers import AUTO, is_casadi, number_of

_PORTION = 4096  # rows
_INTERVALS = 500
_MOST_ROWS = 100_000_000


@dataclass(frozen=True)
class Request:
    """What a person asks of a run. None stands for what the scene, or the FMU, says itself.

    Times in s; rows stand `interval` apart, or at the times `at`. The tolerance is relative to the size of each coordinate and
    rate. Values in SI units by name (in a sweep, what they go through); inputs are constants by name or a table (check_values).
    """

    start: float | None = None
    stop: float | None = None
    tolerance: float | None = None
    interval: float | None = None
    at: Sequence[float] | None = None
    solver: str = AUTO
    max_step: float = 0.0  # none where it is 0
    max_steps: int = 0
    parameters: Mapping[str, Any] | None = None
    initial: Mapping[str, Any] | None = None
    inputs: Any = None
    outputs: Sequence[str] = ()


USUAL = Request()


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
        """The number of rows."""
        if self.at is not None:
            return len(self.at)
        intervals = min((self.stop - self.start) / self.interval, 2.0 * _MOST_ROWS)
        nearest = round(intervals)
        is_on_grid = nearest > 0 and abs(intervals - nearest) <= 1e-9 + 1e-12 * nearest
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

    def input_times_from(self, start: float) -> Sequence[float]:
        """Of the table of inputs; what is given once holds, or begins, at the start."""
        return (start,) if len(self.input_times) == 1 else self.input_times


@dataclass(frozen=True)
class Default:
    """The experiment of who is run, a scene's annotation or an FMU's: s; without an interval there are 500."""

    start: float
    stop: float
    tolerance: float
    interval: float | None = None


def plan(scene: Scene, request: Request = USUAL) -> Experiment:
    """The experiment of the annotation with what is asked for instead. Raises LagError L0702."""
    if not is_casadi(str(request.solver)):
        number_of(request.solver, scene)
    return instead_of(Default(scene.start, scene.stop, scene.tolerance, scene.interval), request)


def _check_idle_limits(solver: str, max_step: float, max_steps: int, report: Report) -> None:
    """Limits of steps that the method does not take."""
    if max_step and solver == "linear":
        report.error("L0702", "the largest step has no effect: the matrix exponential is exact in steps of any length", None,
                     "leave max_step out, or take another solver")
    elif (max_step or max_steps) and is_casadi(solver):
        what = "largest step" if max_step else "number of steps"
        report.error("L0702", f"the {what} has no effect: integrators of CasADi have their own", None,
                     "leave it out, or take another solver")


def instead_of(default: Default, request: Request) -> Experiment:
    """What is asked for, the rest by default. Raises LagError L0702."""
    report = Report()
    asked = (("start time", request.start), ("stop time", request.stop), ("tolerance", request.tolerance),
             ("interval", request.interval))
    start, stop, tolerance, interval = (None if value is None else a_number(what, value) for what, value in asked)
    at = None if request.at is None else numbers("output times", request.at)
    max_step, max_steps = a_number("largest step", request.max_step), a_count("number of steps", request.max_steps)
    begin = default.start if start is None else start
    end = (at[-1] if at and stop is None else default.stop if stop is None else stop) if at is None or len(at) else default.stop
    accuracy = default.tolerance if tolerance is None else tolerance
    _check_times(at, begin, end, report)
    if at is not None and interval is not None:
        report.error("L0702", "the interval has no effect: the output times are given", None, "leave interval out, or at")
    _check_idle_limits(str(request.solver), max_step, max_steps, report)
    report.raise_errors()
    for name, value in (("start time", begin), ("stop time", end), ("tolerance", accuracy)):
        if not math.isfinite(value):
            report.error("L0702", f"the {name} must be a finite number, not {value}")
    report.raise_errors()
    if not end > begin and not (at and end == begin):
        report.error("L0702", f"the stop time {end:g} must be later than the start time {begin:g}")
    if not 0 < accuracy < 1:
        report.error("L0702", f"the tolerance must lie between 0 and 1, not {accuracy:g}", None, "1e-6 is loose, 1e-12 is tight")
    usual = default.interval if default.interval is not None and stop is None else (end - begin) / _INTERVALS
    step = usual if interval is None else interval
    if interval is not None and not (math.isfinite(interval) and interval > 0):
        report.error("L0702", f"the interval must be a positive number, not {interval}")
    if max_step < 0 or not math.isfinite(max_step):
        report.error("L0702", f"the largest step must be a positive number, not {max_step}")
    if max_steps < 0:
        report.error("L0702", f"the number of steps must not be negative, as {max_steps} is; 0 sets no limit")
    report.raise_errors()
    experiment = Experiment(begin, end, accuracy, step or 1.0, tuple(at) if at is not None else None, max_step, max_steps,
                            request.solver)
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
    unknown = scene.inner | {f"der({name})" for name in scene.inner}
    outputs = {column.name for column in scene.outputs} - unknown
    initial, names = _told_attitudes(scene, initial, report), dict[object, str]()
    for name, value in initial.items():
        slot = scene.slot(name) if name not in unknown else None
        place = scene.lost.get(name) if slot is None else slot
        if place is not None and (other := names.setdefault(place, name)) != name:
            report.error("L0712", f"'{name}' is given twice, as '{other}' too", None, "these are names of one and the same")
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
            _unknown("coordinate or rate", name, [x for x in known if x not in unknown], report)
    return start, lost


def _told_attitudes(scene: Scene, initial: Mapping[str, Any], report: Report) -> Mapping[str, Any]:
    """With the three coordinates of each attitude that begins elsewhere: said by its name, or by all parts of its quaternion."""
    found = dict(initial)
    for name, parts in scene.attitudes.items():
        columns = [f"{name}[{k}]" for k in range(1, 5)]
        given = [key for key in (*columns, *parts) if key in found]
        if name in found and given:
            report.error("L0712", f"'{name}' is given twice, by '{given[0]}' too")
            found = {key: value for key, value in found.items() if key not in (name, *given)}
        elif name in found or (given and all(column in found for column in columns) and len(given) == len(columns)):
            whole = found[name] if name in found else [a_number(f"initial value of '{key}'", found[key]) for key in columns]
            for key in (name, *columns):
                found.pop(key, None)
            try:
                found |= dict(zip(parts, turn_of(read_attitude(whole)), strict=True))
            except (ValueError, TypeError) as error:
                report.error("L0706", f"the start of the attitude '{name}': {error}")
        elif given and given != list(parts):
            report.error("L0706", f"'{given[0]}' is a part of the attitude '{name}', which begins as a whole", None, HINT)
            found = {key: value for key, value in found.items() if key not in given}
    return found


def _input_table(scene: Scene, inputs: Any, report: Report) -> tuple[Sequence[float], Sequence[float]]:
    names = [p.name for p in scene.inputs]
    times: Sequence[float] = [scene.start]
    columns: dict[str, Sequence[float]] = {}
    if isinstance(inputs, tuple):
        if len(inputs) != 2:
            fail("L0703", f"a table of inputs is a pair (times, values by name), not {len(inputs)} things")
        times = numbers("times of the inputs", inputs[0])
        columns = {name: numbers(f"values of the input '{name}'", given) for name, given in by_name("inputs", inputs[1]).items()}
        if not columns:
            fail("L0703", "the table of inputs has no column beside its times")
    else:
        how = "what varies is a pair: inputs=(times, {'u': values})"
        columns = {name: [a_number(f"input '{name}'", value, how)] for name, value in by_name("inputs", inputs).items()}
    if not times:
        fail("L0703", "the table of inputs has no times")
    for name, column in columns.items():
        if name not in names:
            _unknown("input", name, names, report)
        if len(column) != len(times):
            report.error("L0703", f"the input '{name}' has {len(column)} values for {len(times)} times")
        if not all(map(math.isfinite, (*column, *times))):
            report.error("L0703", f"the input '{name}' must be finite everywhere")
    if any(b < a for a, b in pairwise(times)):
        report.error("L0703", "the times of the inputs must not fall")
    columns = complete_rates(scene, times, columns) if scene.pieces else columns
    full = [columns.get(p.name, [p.value or 0.0] * len(times)) for p in scene.inputs]
    for known, column in zip(scene.inputs, full, strict=True):
        if not column:  # as was told
            continue
        for value in filter(math.isfinite, dict.fromkeys((min(column), max(column)))):
            _require_possible("input", known, value, report)
    return times, [column[row] for row in range(len(times)) for column in full if row < len(column)]


def _unknown(what: str, name: str, known: Sequence[str], report: Report) -> None:
    report.error("L0701", f"the scene has no {what} '{name}'", None, *filter(None, [suggest(name, known)]))


def check_parameters(scene: Scene, parameters: Sequence[float]) -> None:
    """All parameters, dependent ones too, must be finite, within the limits of their types, and meet what else is required.

    Raises LagError L0605."""
    report = Report()
    for known, value in zip(scene.parameters, parameters, strict=True):
        _require_possible("parameter", known, value, report)
    report.raise_errors()
    check_requirements(scene, parameters)


def _require_possible(what: str, known: Parameter, value: float, report: Report) -> None:
    unit = f" {known.unit}" if known.unit else ""
    if wrong := misfit(value, unit, known.minimum, known.maximum):
        report.error("L0605", f"the {what} '{known.name}' {wrong}", None, f"declared at {known.place}")
