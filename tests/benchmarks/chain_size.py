"""Size: nodes of the accelerations, time to compile and time of one evaluation, against the number of links of a chain.

    python tests/benchmarks/chain_size.py [--largest N]

The cache is switched off. One evaluation is the run time's whole right-hand side, as it is called while integrating.
"""

import argparse
import os
import tempfile
import time
from collections.abc import Iterator
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
SIZES = (2, 5, 20, 100, 300, 1000)


def table(largest: int) -> Iterator[str]:
    import lagrangia as lag

    head = f"{'links':>6} {'nodes':>8} {'a link':>7} {'way':>6} {'compile':>9} {'load':>8} {'how':>7}"
    yield f"{head} {'evaluation':>11} {'a link':>8}"
    for n in (size for size in SIZES if size <= largest):
        begin = time.perf_counter()
        model = lag.load(EXAMPLES / "chain.lag", n=n)
        compiled = time.perf_counter() - begin
        engine = model.engine
        assert engine is not None, "this benchmark needs a C compiler"
        run = model.simulate(at=[min(1.0, 20.0 / n)], tolerance=1e-8)
        each = run.progress.seconds / run.statistics.rhs_evaluations
        nodes = model.scene.notes["acceleration_nodes"]
        yield (
            f"{n:6} {nodes:8} {nodes / n:7.1f} {model.scene.notes['way']:>6} {compiled:8.2f}s {engine.seconds:7.2f}s "
            f"{engine.how:>7} "
            f"{each * 1e6:9.3f}us {each / n * 1e9:6.1f}ns"
        )


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--largest", type=int, default=1000)
    largest = parser.parse_args().largest
    with tempfile.TemporaryDirectory() as folder:
        os.environ["LAGRANGIA_CACHE"] = folder
        for line in table(largest):
            print(line, flush=True)


if __name__ == "__main__":
    main()
