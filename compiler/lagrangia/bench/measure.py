"""Work against precision: the run time of every solver on a scene, against the true error it reaches.

Each solver integrates the same equations from the same start to the same output times. Times are the processor's time of this
process, so that other work on the machine counts little; the median of several runs. The error is that of the positions.
"""

import statistics
import time
from collections.abc import Callable, Iterator, Sequence
from functools import partial

from lagrangia.base.records import dataclass
from lagrangia.bench.heyoka_peer import prepare_heyoka
from lagrangia.bench.peers import (
    CASADI_METHODS,
    SCIPY_METHODS,
    Prepared,
    Solver,
    Unsuitable,
    prepare_casadi,
    prepare_ours,
    prepare_scipy,
)
from lagrangia.bench.problem import Problem
from lagrangia.bench.reference import Reference
from lagrangia.native.build import CompilerError
from lagrangia.run.solvers import WAYS

TOLERANCES = tuple(10.0**-k for k in range(2, 14))
_MOST_SECONDS = 1.0  # for the repetitions of one point


def all_solvers() -> tuple[Solver, ...]:
    """In the order of the table."""
    return (
        *(Solver(name, "lagrangia", partial(prepare_ours, name)) for name in WAYS),
        *(Solver(f"casadi:{name}", "casadi", partial(prepare_casadi, name)) for name in CASADI_METHODS),
        *(Solver(f"scipy:{name}", "scipy", partial(prepare_scipy, name)) for name in SCIPY_METHODS),
        Solver("heyoka", "heyoka", prepare_heyoka),
    )


@dataclass(frozen=True)
class Point:
    """What one solver took, processor time in s, for which error, at a tolerance."""

    solver: str
    tolerance: float
    seconds: float
    error: float


@dataclass(frozen=True)
class Skipped:
    """A solver that cannot run the scene, and why."""

    solver: str
    reason: str


def measure(problem: Problem, reference: Reference, solvers: Sequence[Solver], tolerances: Sequence[float] = TOLERANCES,
            repeat: int = 15, longest: float = 20.0) -> "Iterator[Point | Skipped]":
    """A point each solver and tolerance, as it is measured; a solver that cannot go on is skipped with its reason.

    A solver whose run takes longer than `longest` seconds is asked for no more digits.
    """
    for solver in solvers:
        if solver.version is None:
            yield Skipped(solver.name, "not installed")
            continue
        for tolerance in sorted(tolerances, reverse=True):
            try:
                prepared = solver.prepare(problem, tolerance)
                result, seconds = _measure(prepared, repeat)
            except (Unsuitable, ArithmeticError, RuntimeError, CompilerError) as failure:
                yield Skipped(solver.name, f"tolerance {tolerance:.0e}: {str(failure).splitlines()[-1]}")
                if isinstance(failure, Unsuitable):
                    break
                continue
            yield Point(solver.name, tolerance, seconds, problem.error(prepared.read(result), reference.positions))
            if seconds > longest:
                yield Skipped(solver.name, f"tighter than {tolerance:.0e}: takes too long")
                break


def _measure(prepared: Prepared, repeat: int) -> tuple[object, float]:
    """What the run returned, and the median of its seconds; the first run warms up and does not count, unless it is long."""
    is_fine = time.get_clock_info("process_time").resolution < 1e-6  # not so on Windows
    clock: Callable[[], float] = time.process_time if is_fine else time.perf_counter
    found: list[float] = []
    total = 0.0
    while len(found) <= repeat and (total < _MOST_SECONDS or not found):
        token = prepared.begin()
        begin = clock()
        result = prepared.run(token)
        found.append(clock() - begin)
        total += found[-1]
    return result, statistics.median(found[1:] if len(found) > 1 else found)
