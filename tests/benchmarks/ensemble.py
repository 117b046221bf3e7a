"""Many runs of the double pendulum on one core, 5 s each, from bends of 0.1 to 1 rad: time a run beside its error.

    python tests/benchmarks/ensemble.py [--runs N] [--repeats N]

Our sweep as it is, in lanes, the same with one run after another, and heyoka's taylor_adaptive_batch (8 lanes, its loop over
batches in Python) where it is installed. The error is the median over the runs of that of elbow.phi at the end, against series
at a tolerance of 1e-14. Processor time of this process: the shortest of the repeats, in which all ways take turns.
"""

import argparse
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np

import lagrangia as lag
from lagrangia.bench.heyoka_peer import translate
from lagrangia.run.request import Request
from lagrangia.study.sweep.journal import Ledger
from lagrangia.study.sweep.measures import read_measures
from lagrangia.study.sweep.plan import Design
from lagrangia.study.sweep.threads import run_on_threads

SCENE = Path(__file__).resolve().parents[2] / "models" / "examples" / "double_pendulum.lag"
STOP, LANES = 5.0, 8
TOLERANCES = {"ours": (1e-3, 1e-5, 1e-6, 1e-8, 1e-10, 1e-12), "heyoka": (1e-5, 1e-6, 1e-8, 1e-10, 1e-12, 1e-14, 2.3e-16)}
Work = Callable[[], np.ndarray]  # elbow.phi at the end of each run


def ours(model: lag.Model, starts: np.ndarray, tolerance: float, in_lanes: bool = True, solver: str = "auto") -> Work:
    request = Request(stop=STOP, tolerance=tolerance, initial={"elbow.phi": starts}, solver=solver)
    suited, job = model.prepared_for(read_measures("final(elbow.phi)"), request, Design())
    job = replace(job, sweep=replace(job.sweep, in_lanes=in_lanes))
    engine = suited.engine_for(solver)
    if engine is None:
        raise SystemExit("there is no run time here, and no C compiler")

    def work() -> np.ndarray:
        ledger = Ledger(job)
        run_on_threads(job, engine, ledger, 1)
        return ledger.results[:, 0]

    return work


def by_heyoka(model: lag.Model, starts: np.ndarray, tolerance: float) -> Work:
    import heyoka

    rhs, p = model.functions()["rhs"], model.parameter_values()
    t, x = ca.SX.sym("t"), ca.SX.sym("x", 4)
    slope = ca.Function("slope", [t, x], [ca.vertcat(x[2:], rhs.expand()(t, x[:2], x[2:], ca.SX(0, 1), p))])
    variables = heyoka.make_vars("a", "b", "c", "d")
    slopes = translate(slope, [[heyoka.time], list(variables)])
    steps = heyoka.taylor_adaptive_batch(list(zip(variables, slopes, strict=True)), np.zeros((4, LANES)), tol=tolerance)
    first = model.simulate(at=[0.0])["shoulder.phi"][0]
    padded = np.concatenate([starts, np.repeat(starts[-1:], -len(starts) % LANES)])

    def work() -> np.ndarray:
        found = np.empty(len(padded))
        for k in range(0, len(padded), LANES):
            steps.set_time(0.0)
            steps.state[:] = 0.0
            steps.state[0], steps.state[1] = first, padded[k : k + LANES]
            steps.propagate_until(STOP)
            found[k : k + LANES] = steps.state[1]
        return found[: len(starts)]

    return work


def measured(ways: dict[str, Work], repeats: int, exact: np.ndarray) -> dict[str, tuple[float, float]]:
    """The shortest time and the median error of each."""
    found: dict[str, tuple[float, float]] = {}
    for _ in range(repeats):
        for name, work in ways.items():
            begin = time.process_time()
            ends = work()
            seconds = time.process_time() - begin
            found[name] = min(seconds, found.get(name, (seconds, 0.0))[0]), float(np.median(np.abs(ends - exact)))
    return found


def main() -> None:
    """Prints a line a way and a tolerance."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=4000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    model, starts = lag.load(SCENE), np.linspace(0.1, 1.0, options.runs)
    exact = ours(model, starts, 1e-14, False, "taylor")()
    ways: dict[str, Work] = {}
    for tolerance in TOLERANCES["ours"]:
        ways[f"lanes, {tolerance:g}"] = ours(model, starts, tolerance)
        ways[f"one by one, {tolerance:g}"] = ours(model, starts, tolerance, False)
    try:
        ways |= {f"heyoka, {tolerance:g}": by_heyoka(model, starts, tolerance) for tolerance in TOLERANCES["heyoka"]}
    except ImportError:
        print("heyoka: not installed")
    for name, (seconds, error) in sorted(measured(ways, options.repeats, exact).items(), key=lambda item: item[0].split(",")[0]):
        print(f"{name:20} {1e6 * seconds / options.runs:7.1f} us a run, error 1e{np.log10(max(error, 1e-17)):.1f} rad")


if __name__ == "__main__":
    main()
