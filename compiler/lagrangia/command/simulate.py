"""`lag simulate`: rows as they come, a picture, and what is said of the run."""

import re
import sys
import time
from argparse import Namespace
from collections.abc import Callable, Sequence
from dataclasses import replace
from typing import Any

from lagrangia.base.diagnostics import LagError, RunError, fail
from lagrangia.base.interruptions import INTERRUPTED, undisturbed
from lagrangia.base.result_files import is_device
from lagrangia.command.arguments import (
    asked,
    assignments,
    keep_foreign,
    load_model,
    names_once,
    open_parameters,
    prepare_target,
    read_inputs,
    refuse_idle_sharing,
    start_values,
    tell_broken,
    tell_given,
    tell_inputs,
    tell_warnings,
    values_with_units,
)
from lagrangia.command.summary import (
    stated_singular,
    summarise,
    tell_assembly,
    tell_moved,
    tell_reactions,
    tell_shared,
    tell_singular_start,
)
from lagrangia.model import NO_COMPILER, Model
from lagrangia.run.request import Experiment, Request, check_values, plan
from lagrangia.run.scene import ALL_REACTIONS
from lagrangia.run.simulate import Progress, loss
from lagrangia.view.result_writers import RESULTS, EmptyCells, csv_lines, csv_names, open_writer
from lagrangia.view.rows import ENERGIES, collect, columns, shown
from lagrangia.view.statics import tells_reactions
from lagrangia.view.trajectory import Trajectory

_BAR_AFTER = 2.0  # seconds


def simulate_command(options: Namespace) -> int:
    """`lag simulate`: runs a scene, or an FMU, and writes its rows; returns the exit code. Raises LagError, RunError."""
    if options.file.suffix.lower() == ".fmu":
        from lagrangia.command.fmu_simulate import simulate_fmu_command

        return simulate_fmu_command(options)
    target = _target(options)
    begin = time.perf_counter()
    named = names_once(options.outputs, "--outputs")
    measured = [name for name in named if re.match(r"(?!der\b)\w+\(", name)]  # max(y), but not der(y)
    outputs = tuple(name for name in named if name not in measured) + ((ALL_REACTIONS,) if options.reactions else ())
    given = assignments(options.parameter, "-p")
    model = _load(options, given, outputs)
    if tells_reactions(model.scene) and not options.reactions:
        model = load_model(options, given, (*outputs, ALL_REACTIONS))
    model = _without_repeated(options, model, given)
    refuse_idle_sharing(model)
    scene = model.scene
    if options.dump is not None:
        return _dump(options, model, given)
    keep_foreign(options, target, [column.name for column in (*scene.moving, *shown(scene)[0].rates)])
    initial = start_values(options.initial, scene)
    request = asked(options, open_parameters(scene, given), initial, read_inputs(options.input, scene))
    experiment = plan(scene, request)
    asked_for, request = request, _from_rest(options, model, request, experiment.start)
    values = check_values(scene, request.parameters, request.initial, request.inputs)
    picture = _planned(options, model, request) if options.plot is not None else None
    tell_warnings(options, model)
    tell_inputs(options, model, experiment, request.inputs)
    tell_given(options, model, asked_for)
    tell_measures = _measuring(model, measured, request) if measured else None
    compiled = time.perf_counter() - begin
    code = _run(options, model, experiment, values, compiled, target, picture)
    if tell_measures is not None and code == 0:
        tell_measures(sys.stdout if target != "-" else sys.stderr)
    return code


def _dump(options: Namespace, model: Model, given: list[tuple[str, str]]) -> int:
    """What a phase of the compiler makes. Raises LagError."""
    from lagrangia.compile.dumps import dump

    for name in open_parameters(model.scene, given):
        fail("L0706", f"-p {name} has no effect here", None, "phases of the compiler have values of structural parameters")
    tell_warnings(options, model)
    print(dump(model.completed().compilation, str(options.dump)))
    return 0


def _target(options: Namespace) -> str:
    """Where the rows go."""
    if options.kind is not None:
        fail("L0706", "--kind belongs to FMUs", None, f"'{options.file}' is none: its name would end in .fmu")
    target = prepare_target(options, RESULTS)
    if options.stream and target == "-":
        fail("L0706", "--stream has no effect: rows on standard output are a stream anyway", None, "leave it out")
    return target


def _measuring(model: Model, texts: list[str], request: Request) -> Callable[[Any], None]:
    """What tells them after the run. Raises LagError before it."""
    from lagrangia.study.measuring import measure_lines, prepare_measures

    take = prepare_measures(model, texts, request)
    return lambda out: print("\n".join(measure_lines(take())), file=out)


def _from_rest(options: Namespace, model: Model, request: Request, time: float) -> Request:
    """The same, begun at rest where that is asked for."""
    if options.start_from is None:
        return request
    from lagrangia.study.steady_start import begun

    name, *rates = options.start_from.split()
    given = values_with_units(assignments(rates, "--from steady"), model.scene.start_units)
    if given and name != "steady":
        fail("L0706", "rates belong to steady motion", None, f'write: --from "steady {rates[0]}"')
    found = begun(model, given or name, request.parameters, request.initial, request.inputs, time)
    if not options.quiet:
        print(found.told, file=sys.stderr)
    return replace(request, initial=found.values)


def _planned(options: Namespace, model: Model, request: Request) -> Any:
    from lagrangia.command.run_picture import plan_picture

    return plan_picture(options, model, request)


def _draw(options: Namespace, picture: Any, model: Model, run: Trajectory) -> RunError | None:
    from lagrangia.command.run_picture import draw_picture

    return draw_picture(options, picture, model, run)


def _load(options: Namespace, given: list[tuple[str, str]], outputs: tuple[str, ...]) -> Model:
    try:
        return load_model(options, given, outputs)
    except LagError as error:
        (first, *others) = error.diagnostics
        if first.code != "L0701" or others or not (named := [name for name in outputs if name.startswith("energy.")]):
            raise
        fail(first.code, first.message, None, f"`lag sweep` measures energies, as in final({named[0]}); in Python a run has "
             f"them, run.{named[0]}", "a table has what the model declares: output Energy T = ...")


def _without_repeated(options: Namespace, model: Model, given: list[tuple[str, str]]) -> Model:
    """The model without outputs that are among its coordinates and rates, whose columns are there anyway."""
    there = {column.name for column in (*model.scene.coordinates, *model.scene.rates)}
    kept = tuple(name for name in model.outputs if name not in there)
    return model if kept == model.outputs else load_model(options, given, kept)


def _launched(options: Namespace, model: Model, experiment: Experiment, values: Any, bar: "_Bar") -> Any:
    """Raises RunError, which says what is singular about the start where it fails there."""
    try:
        return model.launch(experiment, values, bar)
    except RunError as error:
        if experiment.start == model.scene.start and (said := stated_singular(options, model)):
            raise RunError(f"{error}\n{said}") from error
        raise


def _run(options: Namespace, model: Model, experiment: Experiment, values: Any, compiled: float, target: str,
         picture: Any) -> int:
    scene = model.scene
    begin = time.perf_counter()
    bar = _Bar(experiment, sys.stderr)
    progress, portions = _launched(options, model, experiment, values, bar)
    if model.falls_back(options.solver) and not options.quiet:  # what CasADi cannot run was refused, with the same reason
        print(NO_COMPILER, file=sys.stderr)
    loaded = time.perf_counter() - begin
    keep: list[Sequence[float]] = []
    first: Sequence[float] = ()
    last: Sequence[float] = ()
    failure: RunError | None = None
    with _Rows(options, target, scene, progress) as writer:
        try:
            for portion in portions:
                writer(portion)
                first = first or portion[: 1 + 2 * scene.n + len(scene.outputs)]
                last = portion[-len(columns(scene)) - ENERGIES :]
                if picture is not None:
                    keep.append(portion)
        except RunError as error:
            failure = error
        except KeyboardInterrupt:  # while rows were written
            progress.interrupted = True
    bar.close()
    undrawn = None
    if picture is not None and progress.rows:
        undrawn = _draw(options, picture, model, _trajectory(model, progress, keep, values))
    if not options.quiet:
        summarise(options, model, progress, target, compiled, loaded)
        tell_assembly(scene, experiment, first, sys.stdout if target != "-" else sys.stderr)
        tell_singular_start(options, model, progress, sys.stdout if target != "-" else sys.stderr)
        tell_moved(scene, progress, values, first, sys.stdout if target != "-" else sys.stderr)
        tell_reactions(scene, last, sys.stdout if target != "-" else sys.stderr)
        tell_shared(model, last, sys.stdout if target != "-" else sys.stderr)
    return _end(options, model, progress, failure, target, undrawn)


def _end(options: Namespace, model: Model, progress: Progress, failure: RunError | None, target: str,
         undrawn: RunError | None) -> int:
    """The exit code, behind what assertions warn of. Raises LagError L0710, RunError."""
    if progress.interrupted:
        print(f"interrupted at t = {progress.time:.6g}; the {progress.rows} rows before are kept", file=sys.stderr)
    try:
        tell_broken(options, model, progress)
    finally:  # under --strict too a run that failed says so
        if not progress.interrupted:
            _raise_failure(failure, progress, target, undrawn)
    return INTERRUPTED if progress.interrupted else 0


def _raise_failure(failure: RunError | None, progress: Progress, target: str, undrawn: RunError | None) -> None:
    """Raises RunError for a run that stopped, for one that went on beyond all sense, and for what a picture lacks."""
    if failure is not None:
        raise RunError(f"{failure}\n{progress.rows} rows before it are kept in {target}")
    if why := loss(progress):
        raise RunError(f"{why}\nthe rows are kept in {target}")
    if undrawn is not None:
        raise undrawn


class _Rows:
    """Rows to a file, or to standard output for "-"."""

    def __init__(self, options: Namespace, target: str, scene: Any, progress: Progress) -> None:
        self.scene, self.as_shown = shown(scene)
        self.file = open_writer(target, self.scene, progress, options.stream) if target != "-" else None
        self.is_disturbed = target == "-" or is_device(target)  # what reads it may keep its writer waiting for ever
        self.empty = self.file.empty if self.file is not None else EmptyCells(self.scene)

    def __enter__(self) -> Callable[[Sequence[float]], None]:
        if self.file is not None:
            self.file.__enter__()
            write = self.file.write if self.is_disturbed else self._write_whole
            return lambda rows: write(self.as_shown(rows))
        count = len(columns(self.scene))
        print(csv_names(self.scene))
        return lambda rows: print(b"\n".join(csv_lines(self.as_shown(rows), count, self.empty)).decode())

    def _write_whole(self, rows: Sequence[float]) -> None:
        assert self.file is not None
        with undisturbed():
            self.file.write(rows)

    def __exit__(self, *exception: Any) -> None:
        if self.file is not None:
            self.file.__exit__(*exception)
        for text in self.empty.describe():
            print(f"warning: {text}", file=sys.stderr)


def _trajectory(model: Model, progress: Progress, rows: list[Sequence[float]], values: Any) -> Trajectory:
    import numpy as np

    observer = model.observer(np.array(progress.parameters), values)
    return Trajectory(model.scene, collect(model.scene, rows), progress, observer, sight=model.sight(values))


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
