"""What the subcommands of `lag` do."""

import csv
import math
import re
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

from lagrangia.diagnostics import LagError, RunError, fail, render_all
from lagrangia.engines import Engine, describe
from lagrangia.interruptions import undisturbed
from lagrangia.model import Model
from lagrangia.pipeline import ALL_REACTIONS
from lagrangia.plot import require_format
from lagrangia.simulate import Experiment, Progress, check_values, is_lost, plan, shortcomings
from lagrangia.solvers import name_of
from lagrangia.statics import is_static, reaction_table
from lagrangia.targets import keep_apart, require_kind
from lagrangia.trajectory import ENERGIES, CsvWriter, EmptyCells, columns, csv_lines
from lagrangia.values import read_value

_BAR_AFTER = 2.0  # seconds
_TABLES = (".csv", ".txt", ".dat")
_FIXED = 1  # LAG_START_FIXED of runtime/model.h


def check_command(options: Namespace) -> int:
    """Compiles every file; the exit code is 2 when one is wrong."""
    wrong = 0
    for file in options.files:
        try:
            model = Model(file)
            freedom = model.freedom
        except LagError as error:
            wrong += 1
            print(render_all(error.diagnostics, sys.stderr.isatty()), file=sys.stderr)
            continue
        if freedom["problem"]:
            wrong += 1
            print(freedom["problem"], file=sys.stderr)
            continue
        print(f"{file}: {_describe(model.scene, freedom)}")
    return 2 if wrong else 0


def explain_command(options: Namespace) -> int:
    """The scene with the parameters given, as it would be run."""
    from lagrangia.casadi_solvers import casadi_refusal
    from lagrangia.explain import as_json, as_text, solver_of, without_compiler
    from lagrangia.needs import find_needs

    given = [assignment(text, "-p") for text in options.parameter]
    model = load_model(options, given, ())
    values = check_values(model.scene, open_parameters(model.scene, given))
    model = model.suited(values)
    c = model.compilation
    scene = model.scene
    if model.engine is None:
        scene = without_compiler(scene, (casadi_refusal(c) or ("",))[0])
    parameters = c.functions.table["parameters"](values.parameters, values.mask)
    needs = find_needs(c.kinematics, c.constraints, c.energies, c.motion, c.initial, scene, parameters)
    print((as_json if options.json else as_text)(scene, needs, solver_of(scene, model.engine)))
    return 0


def open_parameters(scene: Any, given: list[tuple[str, str]]) -> dict[str, float]:
    """Those given that are not structural, in SI units."""
    return values_with_units([(name, value) for name, value in given if name.partition("[")[0] not in scene.structural],
                             {p.name: p.unit for p in scene.parameters})


def _describe(scene: Any, freedom: Mapping[str, Any]) -> str:
    """Degrees of freedom, coordinates, loops and redundant constraints."""
    notes = scene.notes
    names = [c.name for c in scene.coordinates]
    shown = ", ".join(names[:6]) + (f", ... ({len(names)})" if len(names) > 6 else "")
    degrees = freedom["degrees_of_freedom"]
    still = "" if degrees else ": its motion is prescribed" if notes["is_driven"] else ", so it stands still: statics"
    lines = [f"{scene.name}: {degrees} degree{'s' if degrees != 1 else ''} of freedom{still}"]
    held = scene.sizes["n_multipliers"]
    closed = f", {notes['loops']} closed loop{'s' if notes['loops'] != 1 else ''}" if notes["loops"] else ""
    if names:
        lines.append(f"  coordinates {shown}" + (f"; {held} constraint{'s' if held != 1 else ''}{closed}" if held else ""))
    if notes["dependent"]:
        lines.append(f"  given by others: {', '.join(notes['dependent'][:8])}")
    if freedom["degrees_at_start"] > degrees:
        lines.append(f"  the start is a singular position: {freedom['degrees_at_start']} degrees of freedom there")
    lines += [f"  {text}" for text in (*freedom["repeated"], *freedom["assemblies"])]
    return "\n".join(lines)


def simulate_command(options: Namespace) -> int:
    if options.kind is not None:
        fail("L0706", "--kind belongs to FMUs", None, f"'{options.file}' is none: its name would end in .fmu")
    target = prepare_target(options)
    begin = time.perf_counter()
    outputs = split_names(options.outputs) + ((ALL_REACTIONS,) if options.reactions else ())
    given = [assignment(text, "-p") for text in options.parameter]
    model = load_model(options, given, outputs)
    if is_static(model.scene) and not options.reactions:
        model = load_model(options, given, (*outputs, ALL_REACTIONS))
    model = _without_repeated(options, model, given)
    scene = model.scene
    if options.dump is not None:
        from lagrangia.dumps import dump

        print(dump(model.compilation, options.dump))
        return 0
    at = None if options.at is None else [number(text, "--at") for text in options.at.split(",")]
    experiment = plan(scene, stop=options.stop, start=options.start, tolerance=options.tolerance, interval=options.interval,
                      at=at, max_step=options.max_step, max_steps=options.max_steps,
                      solver=options.solver)
    parameters = open_parameters(scene, given)
    units = {c.name: c.unit for c in (*scene.coordinates, *scene.rates)}
    units |= {alias: scene.rates[slot - scene.n].unit for alias, slot in scene.aliases.items()}
    units |= {name: unit for name, (_, unit) in scene.lost.items()}
    initial = values_with_units([assignment(text, "--initial") for text in options.initial], units)
    values = check_values(scene, parameters, initial, read_inputs(options.input, scene))
    model = model.suited(values)
    compiled = time.perf_counter() - begin
    return _run(options, model, experiment, values, compiled, target)


def _without_repeated(options: Namespace, model: Model, given: list[tuple[str, str]]) -> Model:
    """The model without outputs that are among its coordinates and rates, whose columns are there anyway."""
    there = {column.name for column in (*model.scene.coordinates, *model.scene.rates)}
    kept = tuple(name for name in model.outputs if name not in there)
    return model if kept == model.outputs else load_model(options, given, kept)


def prepare_target(options: Namespace) -> str:
    """Where the rows go. Raises LagError L0004 for a place, or a picture's, that results cannot take."""
    target: str = options.output or f"{options.file.stem}.csv"
    require_kind(target, *_TABLES)
    if options.plot is not None:
        require_format(options.plot)
    if options.dump is None:
        keep_inputs(options, target)
    return target


def load_model(options: Namespace, given: list[tuple[str, str]], outputs: tuple[str, ...]) -> Model:
    """The model; parameters that turn out to be structural are compiled in."""
    names = {name for name, _ in given}
    structural = {}
    if names:
        known = _structural_names(options, outputs)
        structural = {name: structural_value(value) for name, value in given if name in known}
    model = Model(options.file, options.model, structural, outputs)
    model.native = {"native": True, "tape": False}.get(getattr(options, "engine", "auto"))
    return model


def _structural_names(options: Namespace, outputs: tuple[str, ...]) -> set[str]:
    from lagrangia.cache import find_scene

    found = find_scene(options.file, options.model, {}, outputs)
    if found is not None:
        return set(found.structural)
    from lagrangia.pipeline import flatten_file

    return set(flatten_file(options.file, options.model)[1].structural)


def structural_value(text: str) -> Any:
    if text in ("true", "false"):
        return text == "true"
    try:
        return read_value(text, "")
    except ValueError:
        return text


def _run(options: Namespace, model: Model, experiment: Experiment, values: Any, compiled: float, target: str) -> int:
    scene = model.scene
    begin = time.perf_counter()
    if model.falls_back(options.solver) and not options.quiet:
        print("no C compiler was found: CasADi's cvodes is used, which is slower and less accurate "
              "(pip install ziglang brings a compiler)",
              file=sys.stderr)
    bar = _Bar(experiment, sys.stderr)
    progress, portions = model.start(experiment, values, bar)
    loaded = time.perf_counter() - begin
    keep: list[Sequence[float]] = []
    first: Sequence[float] = ()
    last: Sequence[float] = ()
    failure: RunError | None = None
    with _writer(target, scene) as writer:
        try:
            for portion in portions:
                writer(portion)
                first = first or portion[: 1 + 2 * scene.n]
                last = portion[-len(columns(scene)) - ENERGIES :]
                if options.plot is not None:
                    keep.append(portion)
        except RunError as error:
            failure = error
        except KeyboardInterrupt:  # while rows were written
            progress.interrupted = True
    bar.close()
    if options.plot is not None:
        _plot(options, model, progress, keep, values)
    if not options.quiet:
        _summarise(options, model, progress, target, compiled, loaded)
        _tell_assembly(scene, experiment, first, sys.stdout if target != "-" else sys.stderr)
        _tell_reactions(scene, last, sys.stdout if target != "-" else sys.stderr)
    if progress.interrupted:
        print(f"interrupted at t = {progress.time:.6g}; the {progress.rows} rows before are kept", file=sys.stderr)
        return 1
    _raise_failure(failure, progress, target)
    return 0


def _raise_failure(failure: RunError | None, progress: Progress, target: str) -> None:
    """Raises RunError for a run that stopped, and for one that went on beyond all sense."""
    if failure is not None:
        raise RunError(f"{failure}\n{progress.rows} rows before it are kept in {target}")
    if is_lost(progress):
        raise RunError(f"the energy account does not close at all: the rows in {target} are not the motion of this scene, which "
                       "has a singularity (a collision, a division by zero) or needs a far smaller tolerance")


class _writer:
    """Rows to a file, or to standard output for "-"."""

    def __init__(self, target: str, scene: Any) -> None:
        self.file = CsvWriter(Path(target), scene) if target != "-" else None
        self.scene = scene
        self.empty = self.file.empty if self.file is not None else EmptyCells(scene)

    def __enter__(self) -> Callable[[Sequence[float]], None]:
        if self.file is not None:
            self.file.__enter__()
            return self.file.write if self.file.temporary is None else self._write_whole
        shown = columns(self.scene)
        print(",".join(c.name for c in shown))
        return lambda rows: print("\n".join(csv_lines(rows, len(shown), self.empty)))

    def _write_whole(self, rows: Sequence[float]) -> None:
        """To a file; a pipe may keep its writer waiting for ever."""
        assert self.file is not None
        with undisturbed():
            self.file.write(rows)

    def __exit__(self, *exception: Any) -> None:
        if self.file is not None:
            self.file.__exit__(*exception)
        for text in self.empty.describe():
            print(f"warning: {text}", file=sys.stderr)


def _plot(options: Namespace, model: Model, progress: Progress, rows: list[Sequence[float]], values: Any) -> None:
    import numpy as np

    from lagrangia.trajectory import Trajectory, collect

    observer = model.observer(np.array(progress.parameters), values)
    trajectory = Trajectory(model.scene, collect(model.scene, rows), progress, observer)
    trajectory.plot(*split_names(options.plot_quantities), path=options.plot)


# -------------------------------------------------------------------- what is said


def _summarise(options: Namespace, model: Model, progress: Progress, target: str, compiled: float, loaded: float) -> None:
    scene, experiment, statistics = model.scene, progress.experiment, progress.statistics
    out = sys.stdout if target != "-" else sys.stderr

    def say(text: str) -> None:
        print(text, file=out)

    say(f"{scene.name}: {scene.description}" if scene.description else scene.name)
    names = ", ".join(c.name for c in scene.coordinates[:6]) + (", ..." if scene.n > 6 else "")
    say(f"  {scene.n} coordinate{'s' if scene.n != 1 else ''}{f' ({names})' if names else ''}, "
        f"{experiment.start:g} to {experiment.stop:g} s, tolerance {experiment.tolerance:g}")
    engine = model.engine_for(options.solver)
    solver = "" if engine else f"casadi:{options.solver.partition(':')[2] or 'cvodes'}"
    how = ""
    if statistics is not None and engine is not None:
        solver = name_of(statistics.solver)
        if statistics.switches:
            implicit = statistics.implicit_steps
            parts = f"{statistics.steps - implicit} steps explicit, {implicit} implicit, {statistics.switches} switches"
            solver = f"{options.solver} ({parts})"
        how = f", {engine.how}: {statistics.steps} steps, {statistics.rhs_evaluations} evaluations"
    say(f"  {solver}{how} in {_time(progress.seconds)}")
    if statistics is not None:
        scale = statistics.energy_scale
        relative = f" ({statistics.energy_residual / scale:.1e} of {scale:.3g} J)" if 0 < scale < math.inf else ""
        say(f"  energy account closes to {statistics.energy_residual:.1e} J{relative}")
        for text in shortcomings(progress):
            say(f"  {text}")
    say(f"  {progress.rows} rows in {target}" + (f", picture in {options.plot}" if options.plot else ""))
    if options.stats:
        _tell(model, engine, progress, compiled, loaded, say)


def _tell_assembly(scene: Any, experiment: Experiment, row: Sequence[float], out: Any) -> None:
    """Where the loops were closed, when start values were free to choose."""
    free = [k for k in range(scene.n) if scene.fixed[k] != _FIXED]
    if not (scene.notes["loops"] and scene.sizes["n_initial_positions"] and free and row and row[0] == experiment.start):
        return
    size = max(map(abs, row[1 : 1 + scene.n]))
    kept = [x if abs(x) > 1e-12 * size else 0.0 for x in row[1 : 1 + scene.n]]  # but for rounding
    shown = [f"{scene.coordinates[k].name} = {_quantity(kept[k], scene.coordinates[k].unit)}" for k in free[:4]]
    more = ", ..." if len(free) > 4 else ""
    print(f"  loops closed at {', '.join(shown)}{more}; `lag check` tells whether there are other ways", file=out)


def _quantity(value: float, unit: str) -> str:
    """To four digits; angles from -180 to 180 degrees."""
    return f"{math.degrees(math.remainder(value, 2 * math.pi)):.4g} deg" if unit == "rad" else f"{value:.4g} {unit}"


def _tell_reactions(scene: Any, row: Sequence[float], out: Any) -> None:
    """What a scene that cannot move is computed for."""
    if is_static(scene) and row:
        print(f"  no freedom is left, so it stands still; on the port b of each joint act, at t = {row[0]:g} s", file=out)
        print("\n".join(f"    {line}" for line in reaction_table(scene, row)), file=out)


def _tell(model: Model, engine: Engine | None, progress: Progress, compiled: float, loaded: float,
          say: Callable[[str], None]) -> None:
    scene, statistics = model.scene, progress.statistics
    notes = scene.notes
    ways = ", ".join(f"{way} {count}" for way, count in notes["ways"].items())
    say(f"  accelerations: {notes['way']}, {notes['acceleration_nodes']} nodes, "
        f"{notes['nodes_per_coordinate']} a coordinate (tried: {ways})")
    say(f"  right-hand side: {notes['rhs_operations']} operations; {scene.sizes['n_hoisted']} values hoisted out of it")
    how = "found in the cache" if model.is_cached else "; ".join(f"{k} {_time(v)}" for k, v in model.compilation.seconds.items())
    ready = f"{'native code' if engine.how == 'native' else 'run time'} in {_time(loaded)}" if engine else "no native code"
    say(f"  compiled in {_time(compiled)} ({how}); {ready}")
    if engine is not None:
        say(f"  {describe(scene)}")
    if statistics is not None and statistics.steps:
        say(f"  steps {statistics.smallest_step:.3g} to {statistics.largest_step:.3g} s, {statistics.rejected} rejected, "
            f"{statistics.dense_outputs} dense outputs, {statistics.events} events; "
            f"{_time(progress.seconds / statistics.rhs_evaluations)} an evaluation")
        worst = (*scene.coordinates, *scene.rates)[statistics.worst].name if 0 <= statistics.worst < 2 * scene.n else "none"
        say(f"  the steps were limited last by {worst}")


def _time(seconds: float) -> str:
    for unit, factor in (("s", 1.0), ("ms", 1e-3), ("us", 1e-6)):
        if seconds >= factor:
            return f"{seconds / factor:.3g} {unit}"
    return f"{seconds / 1e-9:.3g} ns"


class _Bar:
    """A progress bar with the time left, on runs over two seconds, where somebody watches."""

    def __init__(self, experiment: Experiment, stream: Any) -> None:
        self.experiment, self.stream = experiment, stream
        self.begin = time.perf_counter()
        self.is_shown = False

    def __call__(self, progress: Progress) -> None:
        elapsed = time.perf_counter() - self.begin
        if elapsed < _BAR_AFTER or not self.stream.isatty():
            return
        whole = self.experiment.stop - self.experiment.start
        done = min(1.0, max(0.0, (progress.time - self.experiment.start) / whole)) if whole > 0 else 1.0
        left = f"{elapsed / done - elapsed:.0f} s left" if done > 0 else "..."
        filled = int(30 * done)
        self.stream.write(f"\r[{'#' * filled}{'.' * (30 - filled)}] {100 * done:5.1f} %  t = {progress.time:.4g} s  {left}   ")
        self.stream.flush()
        self.is_shown = True

    def close(self) -> None:
        if self.is_shown:
            self.stream.write("\r" + " " * 78 + "\r")


# -------------------------------------------------------------------- what is given


def split_names(text: str | None) -> tuple[str, ...]:
    """Names between commas; a comma in brackets belongs to its name, x[1,2]."""
    return tuple(name.strip() for name in re.split(r",(?![^\[]*\])", text or "") if name.strip())


def assignment(text: str, option: str) -> tuple[str, str]:
    """`NAME=VALUE`. Raises LagError L0706."""
    name, equals, value = text.partition("=")
    if not equals or not name.strip() or not value.strip():
        fail("L0706", f"'{text}' after {option} is not of the form NAME=VALUE")
    return name.strip(), value.strip()


def number(text: str, option: str) -> float:
    try:
        return float(text)
    except ValueError:
        fail("L0706", f"'{text}' after {option} is no number")


def keep_inputs(options: Namespace, *targets: str | Path | None) -> None:
    """Raises LagError L0004 where a result would take the place of the model or of a table that is read."""
    tables = input_tables(getattr(options, "input", []))
    keep_apart([*targets, getattr(options, "plot", None)], [options.file, *tables])


def values_with_units(given: list[tuple[str, str]], units: dict[str, str]) -> dict[str, float]:
    """Values in SI units; `world.gravity={0,0}` sets the elements of an array."""
    found: dict[str, Any] = {}
    for name, text in given:
        elements = [known for known in units if re.fullmatch(rf"{re.escape(name)}\[[\d,]+\]", known)]
        try:
            value = read_value(text, units.get(elements[0] if elements else name, ""))
        except ValueError as error:
            fail("L0706", f"{name} = {text}: {error}")
        count = len(value) if isinstance(value, list) else 0
        if count != len(elements) and (elements or name in units):
            wanted = f"{len(elements)} numbers in braces" if elements else "one number"
            fail("L0706", f"{name} = {text}: {wanted} {'are' if elements else 'is'} needed, not {count or 'one'}")
        found |= dict(zip(elements, value, strict=True)) if isinstance(value, list) and elements else {name: value}
    return found


def input_tables(given: list[str]) -> list[str]:
    """Those that are files."""
    return [text for text in given if "=" not in text or Path(text).suffix == ".csv"]


def read_inputs(given: list[str], scene: Any) -> Any:
    """Constants by name, or one table from a CSV file with a column `time`."""
    files = input_tables(given)
    units = {p.name: p.unit for p in scene.inputs}
    constants = values_with_units([assignment(text, "-u") for text in given if text not in files], units)
    if not files:
        return constants
    if len(files) > 1:
        fail("L0703", "one table of inputs can be given", None, "put its columns into one file")
    times, columns = read_table(Path(files[0]))
    return times, columns | {name: [value] * len(times) for name, value in constants.items()}


def read_table(path: Path) -> tuple[list[float], dict[str, list[float]]]:
    """A CSV file with a line of names, one of them time. Raises LagError L0703."""
    try:
        with path.open(newline="", encoding="utf-8") as stream:
            rows = [row for row in csv.reader(stream) if row]
    except (OSError, UnicodeDecodeError, csv.Error) as error:
        fail("L0703", f"the table '{path}' cannot be read: {getattr(error, 'strerror', None) or error}")
    if len(rows) < 2 or "time" not in [cell.strip() for cell in rows[0]]:
        fail("L0703", f"the table '{path}' needs a line of names, one of them time, and at least one row")
    names = [cell.strip() for cell in rows[0]]
    columns: dict[str, list[float]] = {name: [] for name in names}
    for number, row in enumerate(rows[1:], 2):
        if len(row) != len(names):
            fail("L0703", f"{path}:{number} has {len(row)} cells, not {len(names)}")
        for name, cell in zip(names, row, strict=True):
            try:
                columns[name].append(float(cell))
            except ValueError:
                fail("L0703", f"{path}:{number}: '{cell}' is no number")
    return columns.pop("time"), columns


__all__ = [
    "assignment", "check_command", "explain_command", "input_tables", "keep_inputs", "load_model", "number", "open_parameters",
    "prepare_target", "read_inputs", "read_table", "simulate_command", "split_names", "structural_value", "values_with_units",
]
