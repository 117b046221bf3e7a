"""`lag bench`: work against precision of one scene."""

import sys
from argparse import Namespace
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from lagrangia.base.diagnostics import RunError, fail, suggest
from lagrangia.base.result_files import write_text
from lagrangia.command.arguments import keep_inputs, load_given, number
from lagrangia.native.build import find_compiler
from lagrangia.run.request import Request

_TABLES = (".csv", ".json")


def bench_command(options: Namespace) -> int:
    """What is asked for. Raises LagError, RunError."""
    return _right_hand_sides(options) if options.rhs else _work_and_precision(options)


def _work_and_precision(options: Namespace) -> int:
    """Measures, prints the table, writes what is asked for."""
    from lagrangia.bench.measure import TOLERANCES, Point, Skipped, all_solvers, measure
    from lagrangia.bench.problem import build_problem
    from lagrangia.bench.reference import NoReference, find_reference
    from lagrangia.bench.table import as_text
    from lagrangia.view.curves import require_format

    solvers = _choose(all_solvers(), options.solvers)
    tolerances = _tolerances(options.tolerances) or TOLERANCES
    _check(options)
    if options.plot is not None:
        require_format(options.plot)
    if find_compiler() is None:
        fail("L0901", "not supported yet: a benchmark without a C compiler, which compiles all that is measured", None,
             "pip install ziglang brings one")
    model, parameters = load_given(options)
    problem = build_problem(model, Request(stop=options.stop, parameters=parameters), options.points)
    try:
        reference = find_reference(problem)
    except NoReference as reason:
        raise RunError(f"no reference for the errors: {reason}; choose a shorter time with --stop") from None
    experiment = problem.experiment
    print(f"{model.name}: {problem.n} coordinates, {experiment.start:g} to {experiment.stop:g} s, {options.points} output times")
    print(f"  reference: {reference.how}; its own error about {reference.error:.0e}")
    found: list[Point] = []
    for item in measure(problem, reference, solvers, tolerances, options.repeat):
        if isinstance(item, Skipped):
            print(f"  skipped {item.solver}: {item.reason}")
        else:
            found.append(item)
            _show_progress(item)
    ours = [solver.name for solver in solvers if solver.is_ours]
    _clear_progress()
    print("\n".join(as_text(found, ours, reference.error)))
    _write(options, found, ours, reference, {s.name: s.version for s in solvers}, model.name)
    return 0


def _right_hand_sides(options: Namespace) -> int:
    """Prints a line for each; exit code 1 where the scene is none that can be measured so. Raises LagError, RunError."""
    from lagrangia.bench.right_hand_sides import Side, measure_sides
    from lagrangia.bench.tree_peers import Unfit

    if find_compiler() is None:
        fail("L0901", "not supported yet: a benchmark without a C compiler, which compiles all that is measured", None,
             "pip install ziglang brings one")
    model, _ = load_given(options)
    n = model.scene.n
    try:
        print(f"{model.name}: {n} coordinates; accelerations at one state, the shortest of many calls")
        print(f"  {'':18} {'a call':>12} {'a coordinate':>14}  {'difference':>10}")
        for side in measure_sides(model.compilation):
            if isinstance(side, Side):
                told = f"{side.seconds * 1e9:9.0f} ns {side.seconds * 1e9 / n:11.1f} ns  {side.difference:10.1e}"
                print(f"  {side.name:18} {told}  {side.how}", flush=True)
            else:
                print(f"  skipped {side[0]}: {side[1]}")
    except Unfit as reason:
        raise RunError(f"these right-hand sides are not measured: {reason}") from None
    return 0


def _check(options: Namespace) -> None:
    for name in ("repeat", "points"):
        if not 1 <= getattr(options, name) <= 100_000:
            fail("L0702", f"--{name} must be a number from 1 to 100000, not {getattr(options, name)}")
    if options.output is not None and Path(options.output).suffix not in _TABLES:
        fail("L0004", f"'{options.output}' is no table that can be written", None, f"its name should end in {', '.join(_TABLES)}")
    keep_inputs(options, options.output)


def _choose(solvers: Sequence[Any], names: str | None) -> list[Any]:
    """Those asked for, in the order of the table; a name with no colon also means all of a package: casadi, scipy."""
    if names is None:
        return list(solvers)
    known = {solver.name for solver in solvers} | {solver.name.partition(":")[0] for solver in solvers}
    asked = [name.strip() for name in names.split(",")]
    for name in asked:
        if name not in known:
            fail("L0704", f"there is no solver '{name}' to be measured", None, *filter(None, [suggest(name, sorted(known))]),
                 f"the solvers are {', '.join(solver.name for solver in solvers)}")
    return [solver for solver in solvers if {solver.name, solver.name.partition(":")[0]} & set(asked)]


def _tolerances(text: str | None) -> tuple[float, ...]:
    values = tuple(number(part, "--tolerances") for part in text.split(",")) if text is not None else ()
    for value in values:
        if not 0 < value < 1:
            fail("L0702", f"the tolerance must lie between 0 and 1, not {value:g}", None, "1e-6 is loose, 1e-12 is tight")
    return values


def _show_progress(point: Any) -> None:
    if sys.stderr.isatty():
        print(f"\r  {point.solver} {point.tolerance:.0e}\x1b[K", end="", file=sys.stderr, flush=True)


def _clear_progress() -> None:
    if sys.stderr.isatty():
        print("\r\x1b[K", end="", file=sys.stderr)


def _write(options: Namespace, points: list[Any], ours: list[str], reference: Any, versions: dict[str, Any], name: str) -> None:
    from lagrangia.bench.table import as_csv, as_json

    if options.output is not None:
        path = Path(options.output)
        facts = {"scene": name, "reference": reference.how, "reference_error": reference.error, "versions": versions}
        write_text(path, as_csv(points) if path.suffix == ".csv" else as_json(points, facts))
    if options.plot is not None:
        from lagrangia.bench.plot import draw_points

        draw_points(f"{name}: work against precision", points, ours, reference.error, options.plot)
