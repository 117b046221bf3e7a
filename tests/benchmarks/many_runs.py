"""Many runs of the double pendulum on one core: the batch loop in C beside a Python loop over model.simulate.

    python tests/benchmarks/many_runs.py [--runs N] [--repeats N]

Each run is 5 s at a tolerance of 1e-6 from start values of its own. The ways take turns, and the best of the repeats counts, so
that what else the machine does touches all of them alike. Then: what a run costs besides its steps, and how the threads scale.
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

import lagrangia as lag
from lagrangia.study.sweep.table import Sweep
from lagrangia.study.sweep.threads import cores

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
STOP, TOLERANCE = 5.0, 1e-6
MEASURES = {
    "end state": ["final(shoulder.phi)", "final(elbow.phi)"],
    "maximum of a coordinate": ["max(shoulder.phi)"],
    "maximum of an output": ["max(lower.b.y)"],
    "mean": ["mean(shoulder.phi)"],
    "first crossing": ["first_time(elbow.phi > 4)"],
    "ten measures": ["final(shoulder.phi)", "max(shoulder.phi)", "min(shoulder.phi)", "max(lower.b.y)", "range(elbow.phi)",
                     "rms(der(elbow.phi))", "mean(lower.b.y)", "first_time(elbow.phi > 1)", "at(2.5, elbow.phi)",
                     "max(abs(der(elbow.phi)))"],
}


def starts(runs: int) -> dict[str, np.ndarray]:
    generator = np.random.default_rng(0)
    return {"shoulder.phi": generator.uniform(-2.5, -0.5, runs), "elbow.phi": generator.uniform(-1, 1, runs)}


def sweep(model: lag.Model, outputs: list[str], runs: int, jobs: int = 1, stop: float = STOP) -> Callable[[], Sweep]:
    return lambda: model.simulate_many(initial=starts(runs), outputs=outputs, together=True, stop=stop, tolerance=TOLERANCE,
                                       jobs=jobs)


def python_loop(model: lag.Model, runs: int) -> Callable[[], object]:
    """What one would write without it."""
    table = starts(runs)

    def loop() -> list[float]:
        points = ({name: float(column[i]) for name, column in table.items()} for i in range(runs))
        return [model.simulate(at=[STOP], tolerance=TOLERANCE, initial=point)["elbow.phi"][-1] for point in points]

    return loop


def best(ways: dict[str, tuple[int, Callable[[], object]]], repeats: int) -> dict[str, float]:
    """Runs a second of each way: the best of the rounds in which all take their turn."""
    found = dict.fromkeys(ways, 0.0)
    for _ in range(repeats):
        for name, (runs, work) in ways.items():
            begin = time.perf_counter()
            work()
            found[name] = max(found[name], runs / (time.perf_counter() - begin))
    return found


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--runs", type=int, default=4000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    runs = options.runs
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    ways: dict[str, tuple[int, Callable[[], object]]] = {"Python loop": (runs // 10, python_loop(model, runs // 10))}
    ways |= {name: (runs, sweep(model, outputs, runs)) for name, outputs in MEASURES.items()}
    ways["a run of no length"] = (runs, sweep(model, MEASURES["end state"], runs, stop=1e-9))
    ways[f"end state, {cores()} threads"] = (runs, sweep(model, MEASURES["end state"], runs, cores()))
    steps = sweep(model, MEASURES["end state"], runs)().ledger.outcomes["steps"].mean()
    print(f"double pendulum, {STOP:g} s at {TOLERANCE:g}: {steps:.0f} steps a run")
    for name, rate in best(ways, options.repeats).items():
        print(f"{name:26} {rate:9.0f} runs/s  {1e6 / rate:8.1f} us a run", flush=True)


if __name__ == "__main__":
    main()
