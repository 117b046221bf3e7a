"""Run time against error: our solver beside SciPy's DOP853 and CasADi's cvodes on the same equations, in one run.

    python tests/benchmarks/work_precision.py [--repeats N]

Every method integrates the same accelerations (for SciPy and cvodes: the CasADi function of `model.functions()`), asks for the
end state only, and is measured by the median of several runs. The error is the largest of all positions at the end, against
our own result at tolerance 1e-14; the tests check that result against published references (tests/test_cases.py).
"""

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from functools import partial
from pathlib import Path

import casadi as ca
import numpy as np
from scipy.integrate import solve_ivp

import lagrangia as lag

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
SCENES = {"double_pendulum": (5.0, {}), "chain": (2.0, {"n": 5}), "suspended_bar": (10.0, {})}
TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


def measure_ours(rivals: "Rivals", tolerance: float, repeats: int) -> tuple[float, np.ndarray]:
    """Median seconds of the run itself, without Python's work around it, and the result."""
    runs = [rivals.run(tolerance) for _ in range(repeats)]
    return statistics.median(run.progress.seconds for run in runs), runs[-1].rows[-1, 1 : 1 + rivals.n]


def measure(work: Callable[[], np.ndarray], repeats: int) -> tuple[float, np.ndarray]:
    """Median seconds and the last result."""
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter()
        result = work()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds), result


class Rivals:
    """The solvers compared, each a function of a tolerance that returns the positions at the end."""

    def __init__(self, model: lag.Model, stop: float) -> None:
        self.model, self.stop, self.n = model, stop, model.scene.n
        self.p = model.parameter_values()
        self.rhs = model.functions()["rhs"]
        table = model.compilation.functions.table
        self.start = np.concatenate([np.array(x).ravel() for x in table["start"](self.p)])

    def run(self, tolerance: float) -> lag.Trajectory:
        return self.model.simulate(at=[self.stop], tolerance=tolerance)

    def scipy_dop853(self, tolerance: float) -> np.ndarray:
        def slope(t: float, y: np.ndarray) -> np.ndarray:
            return np.concatenate([y[self.n :], np.array(self.rhs(t, y[: self.n], y[self.n :], [], self.p)).ravel()])

        return solve_ivp(slope, (0, self.stop), self.start, "DOP853", rtol=tolerance, atol=tolerance * 1e-2).y[: self.n, -1]

    def casadi_cvodes(self, tolerance: float) -> Callable[[], np.ndarray]:
        t, y = ca.SX.sym("t"), ca.SX.sym("y", 2 * self.n)
        slope = ca.vertcat(y[self.n :], self.rhs(t, y[: self.n], y[self.n :], [], self.p))
        options = {"reltol": tolerance, "abstol": tolerance * 1e-2, "max_num_steps": 1_000_000}
        solver = ca.integrator("solver", "cvodes", {"t": t, "x": y, "ode": slope}, 0, self.stop, options)

        def integrate() -> np.ndarray:
            return np.array(solver(x0=self.start)["xf"])[: self.n].ravel()

        return integrate


def table(repeats: int) -> Iterator[str]:
    yield f"{'scene':16} {'solver':14} {'tolerance':>9} {'time':>10} {'error':>9}"
    for name, (stop, structural) in SCENES.items():
        model = lag.load(EXAMPLES / f"{name}.lag", **structural)
        rivals = Rivals(model, stop)
        _, exact = measure_ours(rivals, 1e-14, 1)
        for tolerance in TOLERANCES:
            ours = measure_ours(rivals, tolerance, repeats)
            scipy = measure(partial(rivals.scipy_dop853, tolerance), max(1, repeats // 4))
            for label, (seconds, q) in (("ours", ours), ("scipy DOP853", scipy)):
                yield _row(name, label, tolerance, seconds, q, exact)
            if tolerance >= 1e-10:
                yield _row(
                    name, "casadi cvodes", tolerance, *measure(rivals.casadi_cvodes(tolerance), max(1, repeats // 4)), exact
                )


def _row(name: str, label: str, tolerance: float, seconds: float, q: np.ndarray, exact: np.ndarray) -> str:
    return f"{name:16} {label:14} {tolerance:9.0e} {seconds * 1e6:8.0f}us {np.abs(q - exact).max():9.1e}"


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=40)
    for line in table(parser.parse_args().repeats):
        print(line, flush=True)


if __name__ == "__main__":
    main()
