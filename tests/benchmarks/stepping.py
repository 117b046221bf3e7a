"""Steps in the caller's hands: what a step of 0.02 s of a pole on a pushed cart costs, alone and in batches, beside a plain run.

    python tests/benchmarks/stepping.py [--steps N] [--repeats N]

Each step has another force; tolerance 1e-6. The plain run is `simulate` with the same forces as a table and the same rows; the
error is that of the row after 100 steps against erk9 at 1e-13 (later ones are chaos). The shortest of the repeats.
"""

import argparse
import time
from collections.abc import Callable

import numpy as np

import lagrangia as lag

DT, SEEN = 0.02, 100
SCENE = """model Pushed
  input Force F;
  Block    cart(m = 1, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, 90[deg]), phi(start = 0.1));
  Bar      pole(m = 0.1, L = 1, a = hinge.b);
  AppliedForce push(at = cart.center, force = {F, 0});
  annotation(experiment(StopTime = 10, Tolerance = 1e-6));
end Pushed;
"""


def shortest(work: Callable[[], np.ndarray], repeats: int) -> tuple[float, np.ndarray]:
    """Seconds, and the row that is compared."""
    best, row = float("inf"), np.empty(0)
    for _ in range(repeats):
        begin = time.process_time()
        row = work()
        best = min(best, time.process_time() - begin)
    return best, row


def main() -> None:
    """Prints a line a way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--steps", type=int, default=20_000)
    parser.add_argument("--repeats", type=int, default=5)
    options = parser.parse_args()
    count = options.steps
    model = lag.loads(SCENE)
    u = np.random.default_rng(0).normal(size=(count, 1))
    times = DT * np.arange(count + 1)
    table = np.repeat(times, 2)[1:-1], {"F": np.repeat(u[:, 0], 2)}
    exact = model.simulate(at=[times[SEEN]], inputs=table, tolerance=1e-13, solver="erk9").rows[-1]

    def one() -> np.ndarray:
        run = model.start()
        row = run.row
        for k, force in enumerate(u[:, 0].tolist(), 1):
            run.set(F=force)
            run.step(DT)
            row = run.row if k == SEEN else row
        return row

    ways = {"one at a time": one, "in a batch": lambda: model.start().steps(u, DT)[SEEN - 1],
            "plain run": lambda: model.simulate(at=times, inputs=table).rows[SEEN]}
    print(f"{'way':16}{'engine':8}{'steps a second':>16}{'error':>10}")
    for native in (False, True):
        model.native, model._has_engine = native, False
        for name, work in ways.items():
            seconds, row = shortest(work, options.repeats)
            print(f"{name:16}{'native' if native else 'tape':8}{count / seconds:16.0f}{abs(row[1:5] - exact[1:5]).max():10.1e}")


if __name__ == "__main__":
    main()
