"""The benchmark suite: work against precision on all scenes, beside all peers that are installed, and who is first where.

    python tests/benchmarks/suite.py [--scenes NAME,...] [--solvers NAME,...] [--tolerances TOL,...] [--share X] [-o FOLDER]

Peers are those of `lag bench` (see `lag help bench`) and MuJoCo, Exudyn and rumoca, which have scenes of their own here
(peer_*.py). `pip install "lagrangia[bench]"` brings all; a peer that is missing is listed as skipped. -o keeps the points of
each scene as CSV, a picture of them, and the last table as summary.md. At each error of the summary stands our time, and the
ratio of ours to that of the best peer.
"""

import argparse
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path

import peer_exudyn
import peer_mujoco
import peer_rumoca

from cases import SUITE, Case
from lagrangia.bench.measure import TOLERANCES, Point, Skipped, all_solvers, measure
from lagrangia.bench.peers import Solver
from lagrangia.bench.plot import draw_points
from lagrangia.bench.reference import NoReference, find_reference
from lagrangia.bench.table import ERRORS, as_csv, as_text, duel, duration


@dataclass(frozen=True)
class Result:
    case: Case
    points: list[Point]
    ours: list[str]
    floor: float  # the reference's own error


def solvers_of(case: Case, names: Sequence[str] | None) -> list[Solver]:
    """All, or those named; a name without colon also means all of a package."""
    own = (peer_mujoco.solver(case.name), peer_exudyn.solver(case.name), peer_rumoca.SOLVER)
    every = [*all_solvers(), *own]
    return [s for s in every if names is None or {s.name, s.name.partition(":")[0]} & set(names)]


def run(case: Case, options: argparse.Namespace) -> Iterator[str | Result]:
    """Lines as they come, and the result."""
    problem = case.problem(case.stop * options.share)
    try:
        reference = find_reference(problem, seconds=300.0)
    except NoReference as reason:
        yield f"== {case.name}: no reference: {reason}"
        return
    yield f"== {case.name}: {problem.n} coordinates, {problem.times[-1]:g} s; reference within {reference.error:.0e}"
    points: list[Point] = []
    solvers = solvers_of(case, options.solvers)
    for item in measure(problem, reference, solvers, options.tolerances, options.repeat, options.longest):
        if isinstance(item, Skipped):
            yield f"skipped {item.solver}: {item.reason}"
        else:
            points.append(item)
            print(f"{case.name} {item.solver} {item.tolerance:.0e}", end="\x1b[K\r", file=sys.stderr, flush=True)
    result = Result(case, points, [solver.name for solver in solvers if solver.is_ours], reference.error)
    yield from as_text(points, result.ours, result.floor)
    if options.output is not None:
        name = case.name.replace(" ", "_").lower()
        (options.output / f"{name}.csv").write_text(as_csv(points), encoding="utf-8")
        draw_points(f"{case.name}: work against precision", points, result.ours, result.floor, options.output / f"{name}.png")
    yield result


def summary(results: Sequence[Result]) -> Iterator[str]:
    """A table in Markdown, and how often we are first."""
    yield f"| scene | {' | '.join(f'{error:.0e}' for error in ERRORS)} |"
    yield "| --- |" + " --- |" * len(ERRORS)
    ratios = []
    for result in results:
        cells = dict.fromkeys(ERRORS, "")
        for error, own, other in duel(result.points, result.ours, result.floor):
            if own and other:
                ratios.append(own.seconds / other.seconds)
                cells[error] = f"{duration(own.seconds)}, {ratios[-1]:.2g} {other.solver}"
            elif own:
                cells[error] = f"{duration(own.seconds)}, alone"
            elif other:
                ratios.append(float("inf"))
                cells[error] = f"not reached; {duration(other.seconds)} {other.solver}"
        yield f"| {result.case.name} | {' | '.join(cells.values())} |"
    first, third = (sum(ratio <= limit for ratio in ratios) for limit in (1, 1 / 3))
    yield ""
    yield f"{len(ratios)} points that a peer reaches: we are first at {first}, at most a third of the best peer at {third}."


def versions() -> str:
    every = [*all_solvers(), peer_mujoco.solver(""), peer_exudyn.solver(""), peer_rumoca.SOLVER]
    found = {solver.package: solver.version or "not installed" for solver in every}
    return ", ".join(f"{package} {version}" for package, version in found.items())


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--scenes", type=lambda text: text.split(","), help=", ".join(case.name for case in SUITE))
    add("--solvers", type=lambda text: text.split(","))
    add("--tolerances", type=lambda text: [float(part) for part in text.split(",")], default=list(TOLERANCES))
    add("--repeat", type=int, default=9)
    add("--longest", type=float, default=3.0, help="seconds of a run beyond which a solver is asked for no more digits")
    add("--share", type=float, default=1.0, help="of each scene's time")
    add("-o", "--output", type=Path)
    return parser.parse_args()


def main() -> None:
    options = _parse()
    if options.output is not None:
        options.output.mkdir(parents=True, exist_ok=True)
    results = []
    print(versions(), flush=True)
    for case in SUITE:
        if options.scenes is not None and case.name not in options.scenes:
            continue
        for item in run(case, options):
            if isinstance(item, Result):
                results.append(item)
            else:
                print(item, flush=True)
        print(flush=True)
    lines = list(summary(results))
    print("\n".join(lines))
    if options.output is not None:
        (options.output / "summary.md").write_text("\n".join([versions(), "", *lines, ""]), encoding="utf-8")


if __name__ == "__main__":
    main()
