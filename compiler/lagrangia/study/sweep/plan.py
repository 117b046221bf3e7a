"""What is asked of a sweep -> a job: plain data from which any thread or machine computes any of its runs."""

import hashlib
import json
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from lagrangia.base.attitude_values import HINT
from lagrangia.base.checked_values import a_count, a_number, an_array, by_name
from lagrangia.base.cutting import stem
from lagrangia.base.diagnostics import Diagnostic, LagError, Report, fail, nearest, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.values import read_value
from lagrangia.run.batch import Kind, Reduction, Sweep
from lagrangia.run.interpret import evaluate
from lagrangia.run.request import Request, check_values, plan
from lagrangia.run.rules import Moment, solver_by
from lagrangia.run.runtime import Settings, Solver
from lagrangia.run.scene import Scene, to_json
from lagrangia.run.solvers import AUTO, applicable, is_casadi, number_of
from lagrangia.study.sweep.measures import Measure, reductions
from lagrangia.study.sweep.until import Until, read_until
from lagrangia.study.sweep.values import (
    ATTITUDE,
    MOST_RUNS,
    Distribution,
    Factor,
    Variations,
    columns_of_runs,
    is_single,
    read_attitudes,
    read_cell,
    read_runs,
    read_variation,
    sample,
)

if TYPE_CHECKING:
    import numpy as np

WAYS = ("random", "lhs", "saltelli")
INPUTS = "inputs"  # the column of their number, where each run has its own
_PORTION = 1024  # sets of parameters
_LOOKS = 50  # windows at least in a run, when no interval says how closely to look
_FEWEST_IN_LANES = 4  # runs, for which eight lanes cost less than making them one by one


@dataclass(frozen=True)
class Design:
    """How the runs are chosen from the values of a request: numbers, sequences, arrays, or text as on the command line."""

    runs: Any = None  # a table with a row for each run: a path, a DataFrame, or columns by name
    samples: int | None = None
    seed: int = 0
    sampling: str = "random"
    together: bool = False  # lists side by side instead of all their combinations
    seconds: float = 0.0  # of wall time a run may take
    keeps: bool = False  # rows of each run, an interval apart
    until: str | None = None  # what ends it early: se(mean(max(y))) < 1e-3
    held: Any = None  # inputs of each run from each row to the next, (runs, rows - 1, inputs)


@dataclass(frozen=True)
class Job:
    """All runs of a sweep."""

    scene: Scene
    measures: tuple[Measure, ...]
    variations: Variations
    sweep: Sweep
    sampling: str = ""  # random, lhs, saltelli, where all that differs from run to run is random
    seed: int = 0
    until: Until | None = None
    held: "np.ndarray | None" = None

    @property
    def runs(self) -> int:
        """How many there are."""
        return self.variations.runs

    @property
    def varied_parameters(self) -> Variations:
        """The factors that have parameters."""
        n = len(self.scene.parameters)
        return Variations(tuple(f for f in self.variations.factors if any(place < n for place in f.places)))

    def among(self, places: Sequence[int]) -> "Job":
        """Its runs as far as they differ by what is at these places alone; each factor's once where all have the same."""
        factors = list[Factor]()
        for factor in self.variations.factors:
            if own := [k for k, place in enumerate(factor.places) if place in places]:
                values = factor.values[:, own]
                shared = values[:1] if (values == values[:1]).all() else values
                factors.append(Factor(tuple(factor.names[k] for k in own), tuple(factor.places[k] for k in own), shared))
        return replace(self, variations=Variations(tuple(factors)))

    def first(self, runs: int) -> "Job":
        """So many of its runs, of one factor."""
        (factor,) = self.variations.factors
        return replace(self, variations=Variations((replace(factor, values=factor.values[:runs]),)))

    def parameter_sets(self) -> "Iterator[tuple[list[np.ndarray | float], list[float]]]":
        """The parameters of all runs, each combination once, in portions: arrays (sets,) of what varies, and which are given."""
        n, varied = len(self.scene.parameters), self.varied_parameters
        for first in range(0, varied.runs, _PORTION):
            given: list[np.ndarray | float] = list(self.sweep.given)
            mask = list(self.sweep.mask)
            values = varied.values(first, min(varied.runs, first + _PORTION))
            for place, column in zip(varied.places, values.T, strict=True):
                if place < n:
                    given[place], mask[place] = column, 1.0
            yield given, mask

    def parameters_of(self, run: int) -> list[float]:
        """All of one run."""
        given, mask = list(self.sweep.given), list(self.sweep.mask)
        for place, value in zip(self.variations.places, self.variations.values(run, run + 1)[0].tolist(), strict=True):
            if place < len(given):
                given[place], mask[place] = value, 1.0
        return evaluate(self.scene.tapes["parameters"], given, mask)[0]

    def fingerprint(self) -> str:
        """The same for equal sweeps only: results of different ones are never mixed. Where the model is written, and its
        descriptions, make no difference."""
        scene = json.loads(to_json(self.scene))
        for name in ("description", "notes", "initial_places", "start", "stop", "tolerance", "interval"):
            scene.pop(name)
        for item in (*scene["parameters"], *scene["inputs"]):
            item.pop("place"), item.pop("description")
        what = [scene, [m.text for m in self.measures], asdict(self.sweep), self.variations.names]
        hashed = hashlib.sha256(json.dumps(what, sort_keys=True, default=list).encode())
        if self.held is not None:
            hashed.update(self.held.tobytes())
        for factor in self.variations.factors:
            hashed.update(repr(factor.values.shape).encode() + factor.values.tobytes())
        return hashed.hexdigest()[:32]


def build_job(scene: Scene, measures: Sequence[Measure], request: Request, design: Design) -> Job:
    """`request.interval` says how closely the motion is looked at.

    Raises LagError for names the scene does not know and values it cannot have.
    """
    experiment = plan(scene, request)
    fixed, factors = _factors(scene, request, design)
    variations = Variations(tuple(factors))
    if variations.runs > MOST_RUNS:
        fail("L0712", f"the sweep has {variations.runs} runs; at most {MOST_RUNS} are possible", None, "take fewer values")
    cases = [check_values(scene, *fixed, case) for case in _cases(request)]
    values = cases[0]
    reduced = reductions(scene, measures, experiment)
    settings = Settings(experiment.start, experiment.stop, experiment.tolerance, experiment.max_step, 0.0, experiment.max_steps,
                        _solver(scene, experiment.solver, reduced, request))
    if not (seconds := a_number("seconds per run", design.seconds)) >= 0:
        fail("L0702", f"the seconds per run must be a positive number, not {seconds}")
    window = float(request.interval or (experiment.stop - experiment.start) / _LOOKS)
    told = tuple((tuple(case.input_times_from(experiment.start)), tuple(case.input_values)) for case in cases)
    moments, u = told[0] if scene.inputs else ((), ())
    sweep = Sweep(settings, window, seconds, reduced, variations.places,
                  values.parameters, values.mask, (*values.q, *values.v), *scene.limits,
                  tuple(moments), tuple(u), told if len(told) > 1 else (), bool(scene.notes["is_driven"]),
                  tuple(t for times in experiment.times() for t in times) if design.keeps else (),
                  variations.runs >= _FEWEST_IN_LANES)
    sampling = design.sampling if design.samples is not None and len(factors) == 1 else ""
    return Job(scene, tuple(measures), variations, sweep, sampling, design.seed, _until(scene, measures, design, sampling),
              _held(scene, design.held, variations.runs, len(sweep.row_times)))


def _held(scene: Scene, given: Any, runs: int, rows: int) -> "np.ndarray | None":
    import numpy as np

    if given is None:
        return None
    wanted = (runs, rows - 1, len(scene.inputs))
    try:
        held: np.ndarray = np.ascontiguousarray(np.broadcast_to(np.asarray(given, dtype=np.float64), wanted))
    except (TypeError, ValueError):
        fail("L0712", f"inputs that are held are numbers of the shape (runs, times - 1, inputs) = {wanted}")
    if not np.isfinite(held).all():
        first = tuple(np.argwhere(~np.isfinite(held))[0].tolist())
        fail("L0605", f"the inputs must be finite numbers, and u{[*first]} is {held[first]}")
    return held


def _until(scene: Scene, measures: Sequence[Measure], design: Design, sampling: str) -> Until | None:
    if design.until is None:
        return None
    if sampling != WAYS[0]:
        fail("L0712", f"'{design.until}': standard errors are those of random runs that do not depend on each other", None,
             "-p k=normal(100,5) --samples 100000, no other lists, and --sampling random")
    if design.keeps:
        fail("L0901", "not supported yet: trajectories of a sweep that ends early", None, "leave one of them out")
    return read_until(design.until, scene, measures)


def _solver(scene: Scene, name: str, reduced: Sequence[Reduction], request: Request) -> Solver:
    """Where a motion is looked at between rows, its solver's steps must be as short as the motion is quick. Those of the linear
    solver are as long as one likes, so that it needs an interval; islands do not go back. Raises LagError L0704."""
    if is_casadi(name):
        fail("L0704", f"a sweep runs in the run time's own solvers, not in '{name}'", None,
             f"the solvers are {', '.join((AUTO, *applicable(scene)))}")
    number = number_of(name, scene)
    if all(reduction.kind is Kind.AT for reduction in reduced):
        return number
    if number is Solver.ISLANDS:
        fail("L0704", "the solver 'islands' does not show what a motion does between rows", None,
             "measure at times, as with final(y) or at(0.5, y), or choose --solver erk")
    if number is Solver.LINEAR and request.interval is None:
        fail("L0704", "the solver 'linear' makes steps of any length: it does not show what a motion does between them", None,
             "say with --interval how closely it is to be looked at, or choose --solver erk")
    if number is not Solver.AUTO:
        return number
    possible = applicable(scene)
    has_long_steps = request.interval is None and "linear" in possible
    return solver_by(Moment.SWEEP, {"has_islands": "islands" in possible, "has_long_steps": has_long_steps})


# -------------------------------------------------------------------- names and factors


@dataclass(frozen=True)
class _Name:
    """Where values of a name go, and their unit; elements: of a vector."""

    name: str
    kind: str
    elements: tuple[str, ...]
    places: tuple[int, ...]
    unit: str


def _inputs_from(scene: Scene) -> int:
    """The place of the first input; behind the last one is that of the number of a case."""
    return len(scene.parameters) + 2 * scene.n


def _cases(request: Request) -> list[Any]:
    """What inputs there are: a list has some for each run. Raises LagError L0712."""
    if not isinstance(request.inputs, list):
        return [request.inputs]
    if not request.inputs:
        fail("L0712", "the list of inputs is empty", None, "inputs=[{'F': 1}, {'F': 2}] has some for each run")
    return request.inputs


def _inputs_factor(scene: Scene, request: Request) -> list[Factor]:
    import numpy as np

    if not isinstance(request.inputs, list):
        return []
    if any(p.name == INPUTS for p in scene.parameters):
        fail("L0901", f"not supported yet: inputs for each run of a scene with a parameter '{INPUTS}'")
    place = _inputs_from(scene) + len(scene.inputs)
    return [Factor((INPUTS,), (place,), np.arange(len(_cases(request)), dtype=float)[:, np.newaxis])]


def _resolve(scene: Scene, kind: str, name: str) -> _Name:
    """Raises LagError L0701, or L0901 for a structural parameter."""
    place = {p.name: k for k, p in enumerate(scene.parameters)}
    if kind == "parameter":
        elements = (name,) if name in place else tuple(n for n in place if re.fullmatch(rf"{re.escape(name)}\[[\d,]+\]", n))
        if elements:
            if locked := scene.parameters[place[elements[0]]].locked:
                fail("L0701", f"the parameter '{name}' is {locked}: it cannot be set", None,
                     f"declared at {scene.parameters[place[elements[0]]].place}")
            return _Name(name, kind, elements, tuple(place[n] for n in elements), scene.parameters[place[elements[0]]].unit)
        if stem(name) in scene.structural:
            fail("L0901", f"not supported yet: a sweep over '{name}', which is compiled in, as all Integers and Booleans", None,
                 f"run once for each of its values, with -p {name}=...; a parameter Real need not be compiled in")
        fail("L0701", f"the scene has no parameter '{name}'", None, *filter(None, [suggest(name, [*place, *scene.structural])]))
    if name in scene.attitudes:
        return _Name(name, kind, scene.attitudes[name], tuple(_place_of(scene, part) for part in scene.attitudes[name]), ATTITUDE)
    slot = scene.slot(name)
    if slot is None and kind == "input":
        k = [p.name for p in scene.inputs].index(name)
        return _Name(name, kind, (name,), (_inputs_from(scene) + k,), scene.inputs[k].unit)
    if slot is None and name in scene.lost:
        fail("L0901", f"not supported yet: a sweep over the start of '{name}', which other coordinates give", None,
             f"make it a parameter of the model, {name.rpartition('.')[2]}(start = begin), and sweep over that")
    if slot is None:
        known = [*(c.name for c in (*scene.coordinates, *scene.rates)), *scene.aliases]
        fail("L0701", f"the scene has no coordinate or rate '{name}'", None, *filter(None, [suggest(name, known)]))
    unit = (*scene.coordinates, *scene.rates)[slot].unit
    return _Name(name, kind, (name,), (_place_of(scene, name),), unit)


def _place_of(scene: Scene, name: str) -> int:
    """Of a coordinate or a rate among parameters and start values."""
    slot = scene.slot(name)
    assert slot is not None
    return len(scene.parameters) + slot


def _factors(scene: Scene, request: Request, design: Design
             ) -> tuple[tuple[dict[str, float], dict[str, float]], list[Factor]]:
    """Values that are the same in all runs (parameters, start values), and the factors: table, lists, samples."""
    import numpy as np

    fixed: tuple[dict[str, float], dict[str, float]] = ({}, {})
    lists: list[Factor] = []
    random: list[tuple[_Name, Distribution]] = []
    names = [(_resolve(scene, "parameter", name), value) for name, value in by_name("parameters", request.parameters).items()]
    names += [(_resolve(scene, "initial", name), value) for name, value in by_name("start values", request.initial).items()]
    for name, value in names:
        found, is_alone = _values(name, value)
        if isinstance(found, Distribution):
            random.append((name, found))
        elif is_alone:
            fixed[name.kind == "initial"].update(zip(name.elements, found[0].tolist(), strict=True))
        else:
            lists.append(Factor(name.elements, name.places, found))
    lists += _inputs_factor(scene, request)
    table = [_table(scene, design.runs)] if design.runs is not None else []
    if design.runs is None and design.held is not None:
        table = [Factor((), (), np.empty((len(design.held), 0)))]
    held = {name for factor in table for name in factor.names}
    for case in _cases(request):
        given = case[-1] if isinstance(case, tuple) and case else case
        if isinstance(given, Mapping) and (twice := held & {*given}):
            fail("L0712", f"'{min(twice)}' is given twice")
    _check_once([*(name.places for name, _ in names), *(factor.places for factor in table)], scene)
    if design.together and len(lists) < 2:
        fail("L0712", "there are no lists to be taken side by side", None, "-p m=1,2 -p k=3,4 are two")
    factors = [*table, *(_side_by_side(lists) if design.together else lists), *_samples(random, design)]
    for factor in factors:
        _check_finite(factor)
    _check_whole(scene, {*fixed[1], *(name for factor in factors for name in factor.names)})
    return fixed, factors


def _check_whole(scene: Scene, given: set[str]) -> None:
    """Attitudes begin as a whole. Raises LagError L0706."""
    for name, parts in scene.attitudes.items():
        if (some := given & {*parts}) and len(some) < len(parts):
            fail("L0706", f"'{min(some)}' is a part of the attitude '{name}', which begins as a whole", None, HINT)


def _check_once(claims: Sequence[tuple[int, ...]], scene: Scene) -> None:
    names = [*(p.name for p in scene.parameters), *(c.name for c in (*scene.coordinates, *scene.rates)),
             *(p.name for p in scene.inputs)]
    places = [place for claim in claims for place in claim]
    for place in places:
        if places.count(place) > 1:
            fail("L0712", f"'{names[place]}' is given twice")


def _check_finite(factor: Factor) -> None:
    import numpy as np

    for name, column in zip(factor.names, factor.values.T, strict=True):
        if not np.isfinite(column).all():
            first = int(np.argmin(np.isfinite(column)))
            fail("L0605", f"the values of '{name}' must be finite numbers, and number {first + 1} is {column[first]}")


def _values(name: _Name, value: Any) -> "tuple[np.ndarray | Distribution, bool]":
    """(number of values, elements of the name), and whether it is one value alone; a list of one is a list."""
    import numpy as np

    is_alone = False
    if name.unit == ATTITUDE:
        return read_attitudes(name.name, value)
    if isinstance(value, str):
        found, is_alone = read_variation(name.name, value, name.unit), is_single(value)
        if isinstance(found, Distribution):
            if len(name.elements) != 1:
                fail("L0712", f"'{name.name}' has {len(name.elements)} elements", None, f"choose one, such as {name.elements[0]}")
            return found, False
    else:
        found = an_array(f"the values of '{name.name}'", value)
        if found.ndim == 0 or (found.ndim == 1 and len(name.elements) > 1):
            found, is_alone = found[np.newaxis], True
    found = found.reshape(len(found), -1 if found.size else 0)
    if found.shape[1] != len(name.elements):
        wanted = "numbers are" if len(name.elements) == 1 else f"vectors of {len(name.elements)} elements are"
        fail("L0712", f"the values of '{name.name}' do not fit: {wanted} needed")
    return found, is_alone


def _side_by_side(lists: Sequence[Factor]) -> list[Factor]:
    """One factor of lists of equal length; lists of one value have it in all runs."""
    import numpy as np

    if not lists:
        return []
    lengths = {factor.names[0]: len(factor.values) for factor in lists}
    if len({*lengths.values()} - {1}) > 1:
        told = ", ".join(f"{name} has {length}" for name, length in lengths.items())
        fail("L0712", f"lists side by side must have the same number of values: {told}")
    names, places = (tuple(x for factor in lists for x in getattr(factor, what)) for what in ("names", "places"))
    longest = max(lengths.values())
    values = [np.repeat(f.values, longest, axis=0) if len(f.values) == 1 else f.values for f in lists]
    return [Factor(names, places, np.concatenate(values, axis=1))]


def _samples(random: Sequence[tuple[_Name, Distribution]], design: Design) -> list[Factor]:
    if design.sampling not in WAYS:
        fail("L0712", f"there is no sampling '{design.sampling}'", None, f"the ways are {', '.join(WAYS)}")
    if a_count("seed", design.seed) < 0:
        fail("L0712", f"the seed must not be negative: {design.seed}")
    if design.samples is not None and not 1 <= a_count("number of samples", design.samples) <= MOST_RUNS:
        fail("L0712", f"the number of samples must lie between 1 and {MOST_RUNS}, not {design.samples}")
    if not random:
        if design.samples is not None or design.seed or design.sampling != WAYS[0]:
            fail("L0712", "nothing is random, so there is nothing to take samples of", None,
                 "say how a value is distributed: k=normal(100,5)")
        return []
    if design.samples is None:
        fail("L0712", f"'{random[0][0].name}' is random, but the number of samples is not given", None, "say --samples 1000")
    values = sample([distribution for _, distribution in random], design.samples, design.seed, design.sampling)
    return [Factor(tuple(name.name for name, _ in random), tuple(name.places[0] for name, _ in random), values)]


def _table(scene: Scene, runs: Any) -> Factor:
    """Columns are parameters, inputs that are held, or else coordinates and rates. Raises LagError L0713."""
    import numpy as np

    if isinstance(runs, Path):
        headings, rows = read_runs(runs)
        names = _columns(scene, str(runs), headings)
        values = np.array([[read_cell(runs, line, name.name, cell, name.unit) for name, cell in zip(names, cells, strict=True)]
                           for line, cells in rows])
    else:
        columns = columns_of_runs(runs)
        names = _columns(scene, "the table of runs", [*columns])
        units = getattr(runs, "attrs", {}).get("units", {})
        values = np.stack([column * _factor_to_si(name, units.get(name.name, name.unit))
                           for name, column in zip(names, columns.values(), strict=True)], axis=1)
    return Factor(tuple(name.name for name in names), tuple(p for name in names for p in name.places), values)


def _columns(scene: Scene, table: str, headings: Sequence[str]) -> list[_Name]:
    report = Report()
    names: list[_Name] = []
    known = {**{c.name: "input" for c in scene.inputs}, **{p.name: "parameter" for p in scene.parameters}}
    for heading in headings:
        try:
            kind = known.get(heading) or ("initial" if scene.slot(heading) is not None else "parameter")
            names.append(_resolve(scene, kind, heading))
            if len(names[-1].elements) > 1:
                fail("L0713", f"{table}: '{heading}' is a vector", None, "give its elements columns of their own")
        except LagError as error:
            report.add([_of_column(scene, table, heading, found) for found in error.diagnostics])
    report.raise_errors()
    return names


def _of_column(scene: Scene, table: str, heading: str, found: Diagnostic) -> Diagnostic:
    """With the table's name, and the nearest of what is no parameter."""
    states = [column.name for column in (*scene.coordinates, *scene.rates)]
    near = nearest(heading, [*states, *scene.aliases, *(entry.name for entry in scene.inputs)])
    hints = [f"did you mean '{near}'?"] if near and found.code == "L0701" else found.hints
    return replace(found, hints=(*hints, *([] if table in found.message else [f"'{heading}' is a column of {table}"])))


def _factor_to_si(name: _Name, unit: str) -> float:
    """Raises LagError L0713 for a unit that does not fit."""
    import numpy as np

    try:
        one = read_value(f"1[{unit}]", name.unit) if unit != name.unit else 1.0
    except ValueError as error:
        fail("L0713", f"the table of runs: the unit of '{name.name}': {error}")
    return float(np.asarray(one, dtype=float))
