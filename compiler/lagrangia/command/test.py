"""`lag test`: runs the models that test others, and compares what they do with stored tables."""

import math
import sys
import time
import warnings
from argparse import Namespace
from collections.abc import Iterator, Sequence
from pathlib import Path

import numpy as np

from lagrangia.base.diagnostics import LagError, RunError, RunWarning, fail, render_all
from lagrangia.base.spelling import plain_text
from lagrangia.base.tables import read_table
from lagrangia.command.arguments import number, tell_broken, tell_warnings
from lagrangia.compile.pipeline import read_files
from lagrangia.model import Model
from lagrangia.view.trajectory import Trajectory

_PREFIX = "Test"


def test_command(options: Namespace) -> int:
    """The exit code is 1 where a test fails, 2 where a text is wrong. Raises LagError L0001 where there is nothing to test."""
    tolerance = number(options.tolerance, "--tolerance")
    if not 0 <= tolerance < math.inf:
        fail("L0706", f"'{options.tolerance}' after --tolerance is no share of a value", None, "0 or more: --tolerance 1e-6")
    passed = failed = wrong = 0
    for file in _files(options.files):
        for model in _models(file, is_named=str(file) in options.files):
            begin = time.perf_counter()
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("error", RunWarning)
                    said = _tried(options, file, model, tolerance)
            except (RunError, RunWarning) as error:
                said = str(error)
            except LagError as error:
                wrong += 1
                said = render_all(error.diagnostics, sys.stdout.isatty())
            passed, failed = passed + (not said), failed + bool(said)
            took, how = f"{time.perf_counter() - begin:.2f} s", "FAILED" if said else "updated" if options.update else "passed"
            print(plain_text(f"{how} {model} ({file}, {took})"), *([said] if said else []), sep="\n")
    if not passed + failed:
        fail("L0001", "there is nothing to test", None, f"the names of models that test begin with {_PREFIX}")
    print(f"{passed} {'updated' if options.update else 'passed'}, {failed} failed")
    return 2 if wrong else 1 if failed else 0


def _files(names: Sequence[str]) -> list[Path]:
    """Those given, and those in folders that are given; in the folder `tests` where none are."""
    found: list[Path] = []
    for path in map(Path, names or ["tests"]):
        inside = sorted(path.rglob("*.lag")) if path.is_dir() else [path] if names else []
        if not inside:
            fail("L0001", f"there is no .lag file in '{path}'", None, "lag test FILE tests the models of a file, or of a folder")
        found += inside
    return found


def _models(file: Path, is_named: bool) -> Iterator[str]:
    """Those whose names begin with Test; of a file that is named, and has none, the last one."""
    models = [c.name for c in read_files(file)[0].classes if c.kind == "model" and not c.is_partial]
    yield from [name for name in models if name.startswith(_PREFIX)] or models[-1 if is_named else len(models) :]


def _tried(options: Namespace, file: Path, name: str, tolerance: float) -> str:
    """What is wrong with a run, "" for nothing. Raises LagError, RunError."""
    model = Model(file, name)
    tell_warnings(options, model)
    table = file.with_name(f"{name}.csv")
    if options.update or not table.exists():
        run = model.simulate()
        tell_broken(options, model, run.progress)
        if options.update:
            run.to_csv(table)
        return ""
    times, columns = read_table(table)
    run = model.simulate(at=times)
    tell_broken(options, model, run.progress)
    if len(run.time) != len(times):
        return f"   the run {run.ended}; {table.name} goes on to t = {times[-1]:g} s"
    return "\n".join(_differences(run, columns, tolerance, table))


def _differences(run: Trajectory, columns: dict[str, list[float]], tolerance: float, table: Path) -> Iterator[str]:
    """Columns that differ by more than a share of the largest value in them."""
    for name, stored in columns.items():
        wanted = np.array(stored)
        if not np.isfinite(wanted).all():
            row = int(np.argmin(np.isfinite(wanted)))
            yield f"   {table.name} has {wanted[row]} for {name} at t = {run.time[row]:g} s, which nothing can be compared with"
            continue
        off = np.abs(run[name.partition(" [")[0]] - wanted)
        size = float(np.abs(wanted).max()) or 1.0
        worst = int(np.argmax(np.where(np.isnan(off), np.inf, off)))
        if not off[worst] <= tolerance * size:
            yield (f"   {name} differs by {off[worst]:.3g} at t = {run.time[worst]:g} s, where {table.name} says "
                   f"{wanted[worst]:.9g}: {off[worst] / size:.2g} of its size, {tolerance:g} allowed")
