"""What `lag simulate` takes, beside the best peer: for each scene and decade of error, the ratio of the two run times.

    python tests/benchmarks/ratios.py [--scenes NAME,...] [--solvers NAME,...] [--tolerances TOL,...] [--rounds N] [-o FILE.csv]

Below 1 we are faster. Two ratios stand in a cell: that of `auto`, the solver a user gets, and after a bar that of our best one
there. All solvers take turns, and the shortest of many runs counts: other work on the machine only adds to it. A solver's first
turn in a round follows one that is not counted, so that none is charged for what others left in the processor's caches.
"""

import argparse
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import groupby
from math import inf
from pathlib import Path

from cases import SUITE, Case
from lagrangia.bench.measure import TOLERANCES, Point, all_solvers
from lagrangia.bench.peers import Prepared, Solver, Unsuitable, prepare_ours
from lagrangia.bench.problem import Problem
from lagrangia.bench.reference import NoReference, Reference, find_reference
from lagrangia.bench.table import ERRORS, as_csv, by_solver, duration, seconds_at
from lagrangia.native.build import CompilerError
from lagrangia.run.solvers import WAYS

SOLVERS = ("auto", "pirk", "erk", "erk5", "taylor", "linear", "implicit", "casadi:erk", "heyoka")
OURS = ("auto", *WAYS)
AUTO = Solver("auto", "lagrangia", partial(prepare_ours, "auto"))
FAILURES = (Unsuitable, ArithmeticError, RuntimeError, CompilerError)


@dataclass
class Turn:
    """A solver at a tolerance: ready to run, and the shortest time so far."""

    solver: str
    tolerance: float
    prepared: Prepared
    error: float
    seconds: float

    def run(self) -> float:
        """Takes one turn; how long it took."""
        token = self.prepared.begin()
        begin = time.process_time()
        self.prepared.run(token)
        elapsed = time.process_time() - begin
        self.seconds = min(self.seconds, elapsed)
        return elapsed


def turns(problem: Problem, reference: Reference, solvers: Sequence[Solver], tolerances: Sequence[float],
          longest: float) -> Iterator[Turn]:
    for solver in solvers:
        for tolerance in sorted(tolerances, reverse=True):
            try:
                prepared = solver.prepare(problem, tolerance)
                token = prepared.begin()
                begin = time.process_time()
                result = prepared.run(token)
                elapsed = time.process_time() - begin
            except FAILURES as failure:
                print(f"  {solver.name} {tolerance:.0e}: {(str(failure).splitlines() or ['no reason'])[-1]}", file=sys.stderr)
                if isinstance(failure, Unsuitable):
                    break
                continue
            yield Turn(solver.name, tolerance, prepared, problem.error(prepared.read(result), reference.positions), elapsed)
            if elapsed > longest:
                break


def measure(found: list[Turn], rounds: int, budget: float) -> list[Point]:
    """The shortest times of runs that alternate; `budget` seconds a scene at most, but two rounds of all."""
    begin = time.process_time()
    for number in range(rounds):
        if number >= 2 and time.process_time() - begin > budget:
            break
        for _, group in groupby(found, key=lambda turn: turn.solver):
            turns_of_one = list(group)
            replace(turns_of_one[0]).run()
            for turn in turns_of_one:
                turn.run()
    return [Point(turn.solver, turn.tolerance, turn.seconds, turn.error) for turn in found]


@dataclass(frozen=True)
class Duel:
    """At one error: seconds of auto, of our best and of the best peer, None where it is not reached."""

    error: float
    auto: float | None
    best: tuple[float, str] | None
    peer: tuple[float, str] | None

    def ratio(self, seconds: float | None) -> float | None:
        if self.peer is None:
            return None
        return seconds / self.peer[0] if seconds is not None else inf


def duels(points: Sequence[Point], floor: float) -> list[Duel]:
    groups = by_solver(points)
    found = []
    for error in (e for e in ERRORS if e > floor):
        times = {name: seconds for name, group in groups.items() if (seconds := seconds_at(group, error)) is not None}
        ours = [(seconds, name) for name, seconds in times.items() if name in OURS]
        peers = [(seconds, name) for name, seconds in times.items() if name not in OURS]
        found.append(Duel(error, times.get("auto"), min(ours, default=None), min(peers, default=None)))
    return found


def row(case: Case, found: Sequence[Duel]) -> str:
    cells = dict.fromkeys(ERRORS, "")
    for duel in found:
        auto, best = duel.ratio(duel.auto), duel.ratio(duel.best[0] if duel.best else None)
        if auto is not None and best is not None:
            cells[duel.error] = f"{auto:.2f}|{best:.2f}"
    return f"{case.name:22}" + "".join(f"{cell:>12}" for cell in cells.values())


def verdict(ratios: Sequence[float]) -> str:
    first, third = (sum(ratio <= limit for ratio in ratios) for limit in (1, 1 / 3))
    return f"of {len(ratios)} points that a peer reaches, first at {first}, at most a third of its time at {third}"


def examine(case: Case, options: argparse.Namespace) -> tuple[list[Point], list[Duel]] | None:
    problem = case.problem()
    try:
        reference = find_reference(problem, seconds=300.0)
    except NoReference as reason:
        print(f"{case.name}: no reference: {reason}")
        return None
    known = {solver.name: solver for solver in (AUTO, *all_solvers())}
    solvers = [known[name] for name in options.solvers if known[name].version is not None]
    ready = list(turns(problem, reference, solvers, options.tolerances, options.longest))
    points = measure(ready, options.rounds, options.budget)
    return points, duels(points, reference.error)


def details(found: Sequence[Duel]) -> Iterator[str]:
    for duel in found:
        if duel.best and duel.peer:
            auto = duration(duel.auto) if duel.auto is not None else "-"
            yield (f"  {duel.error:.0e} auto {auto:>8}  best {duration(duel.best[0]):>8} {duel.best[1]:9} "
                   f"peer {duration(duel.peer[0]):>8} {duel.peer[1]}")


def _parse() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    add = parser.add_argument
    add("--scenes", type=lambda text: text.split(","), help=", ".join(case.name for case in SUITE))
    add("--solvers", type=lambda text: text.split(","), default=SOLVERS)
    add("--tolerances", type=lambda text: [float(part) for part in text.split(",")], default=[0.1, *TOLERANCES])
    add("--rounds", type=int, default=60)
    add("--budget", type=float, default=20.0, help="seconds of measuring a scene")
    add("--longest", type=float, default=1.0, help="seconds of a run beyond which a solver is asked for no more digits")
    add("--details", action="store_true", help="times, and who is best")
    add("-o", "--output", type=Path, help="all points as CSV")
    return parser.parse_args()


def main() -> None:
    options = _parse()
    autos, bests, kept = list[float](), list[float](), list[Point]()
    print(f"{'':22}" + "".join(f"{error:>12.0e}" for error in ERRORS), flush=True)
    for case in SUITE:
        if options.scenes is not None and case.name not in options.scenes:
            continue
        result = examine(case, options)
        if result is None:
            continue
        points, found = result
        kept += [replace(point, solver=f"{case.name}/{point.solver}") for point in points]
        autos += [ratio for duel in found if (ratio := duel.ratio(duel.auto)) is not None]
        bests += [ratio for duel in found if (ratio := duel.ratio(duel.best[0] if duel.best else None)) is not None]
        print(row(case, found), *(details(found) if options.details else ()), sep="\n", flush=True)
    print(f"auto: {verdict(autos)}", f"the best of ours: {verdict(bests)}", sep="\n")
    if options.output is not None:
        options.output.write_text(as_csv(kept), encoding="utf-8")


if __name__ == "__main__":
    main()
