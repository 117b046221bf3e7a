"""Closed loops: run time of N four-bars per simulated second, and its exponent in N.

    python tests/benchmarks/four_bars.py [--largest N]

The ladder runs on tapes throughout, so that one way to run is compared with itself.
"""

import argparse
import statistics
from collections.abc import Iterator
from pathlib import Path

import numpy as np

import lagrangia as lag
from lagrangia.run.engines import Engine, load_engine
from lagrangia.run.request import Request, check_values, plan
from lagrangia.run.simulate import simulate

ROOT = Path(__file__).resolve().parents[2]


def ladder(largest: int) -> Iterator[str]:
    """Run time per simulated second of N four-bars, and its exponent in N."""
    yield f"{'N':>4} {'nodes':>7} {'per second':>11} {'exponent':>9}"
    before: tuple[int, float] | None = None
    for n in (size for size in (2, 10, 40, 100, 200) if size <= largest):
        model = lag.load(ROOT / "models" / "examples" / "n_four_bars.lag", n=n)
        engine = load_engine(model.scene, native=False)
        assert engine is not None, "this benchmark needs a C compiler"
        each = statistics.median(_seconds(model, engine) for _ in range(5)) / 2.0
        exponent = f"{np.log(each / before[1]) / np.log(n / before[0]):9.2f}" if before else ""
        yield f"{n:4} {model.scene.notes['acceleration_nodes']:7} {each * 1e3:9.2f}ms {exponent}"
        before = n, each


def _seconds(model: lag.Model, engine: Engine) -> float:
    experiment = plan(model.scene, Request(at=[2.0], tolerance=1e-6))
    progress, rows = simulate(model.scene, engine, experiment, check_values(model.scene))
    for _ in rows:
        pass
    return progress.seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=200)
    for line in ladder(parser.parse_args().largest):
        print(line, flush=True)


if __name__ == "__main__":
    main()
