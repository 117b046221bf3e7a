"""Closed loops: Andrews' squeezing mechanism beside CasADi's idas on the same equations, and the cost of N four-bars.

    python tests/benchmarks/closed_loops.py [--repeats N] [--largest N]

idas integrates the index-1 system M a + h + J^T lambda = 0, J a + bias = 0 with a and lambda as algebraic variables, compiled
by the system's C compiler. Our time is that of the run itself, without Python's work around it. Errors are the largest of the
seven angles at 0.03 s against tests/cases/testset_andrews_squeezer.yaml. The ladder runs on tapes throughout, so that one way
to run is compared with itself.
"""

import argparse
import statistics
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import casadi as ca
import numpy as np
import yaml

import lagrangia as lag
from lagrangia.simulate import Engine, check_values, load_engine, plan, simulate

ROOT = Path(__file__).resolve().parents[2]
ANGLES = {"O.phi": "beta", "F.phi": "Theta", "B.phi": "gamma", "G.phi": "Phi", "A5.phi": "delta", "H.phi": "Omega",
          "A7.phi": "epsilon"}
STOP = 0.03


def median(work: Callable[[], object], repeats: int) -> float:
    seconds = []
    for _ in range(repeats):
        begin = time.perf_counter()
        work()
        seconds.append(time.perf_counter() - begin)
    return statistics.median(seconds)


def reference(names: tuple[str, ...]) -> np.ndarray:
    case = yaml.safe_load((ROOT / "tests" / "cases" / "testset_andrews_squeezer.yaml").read_text(encoding="utf-8"))
    (row,) = [row for row in case["runs"]["Andrews"] if float(row["t"]) == STOP]
    return np.array([float(row[ANGLES[name]]) for name in names])


def andrews(repeats: int) -> Iterator[str]:
    model = lag.load(ROOT / "models" / "examples" / "andrews_squeezer.lag")
    exact = reference(model.coordinate_names)
    yield f"{'Andrews':14} {'tolerance':>9} {'time':>10} {'error':>9}"
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        run = model.simulate(at=[STOP], tolerance=tolerance)
        seconds = statistics.median(model.simulate(at=[STOP], tolerance=tolerance).progress.seconds for _ in range(repeats))
        yield f"{'ours':14} {tolerance:9.0e} {seconds * 1e6:8.0f}us {np.abs(run.rows[-1, 1:8] - exact).max():9.1e}"
    start = model.simulate(at=[0.0, STOP], tolerance=1e-8).rows[0, 1:15]
    for tolerance in (1e-6, 1e-8, 1e-10):
        solve = idas(model, start, tolerance)
        error = np.abs(solve() - exact).max()
        yield f"{'casadi idas':14} {tolerance:9.0e} {median(solve, max(3, repeats // 4)) * 1e6:8.0f}us {error:9.1e}"


def idas(model: lag.Model, start: np.ndarray, tolerance: float) -> Callable[[], np.ndarray]:
    """The angles at the end, by idas."""
    motion = model.compilation.motion
    held, n = motion.constrained, motion.q.numel()
    assert held is not None
    p = model.parameter_values()
    remaining = model.compilation.kinematics.without_accelerations()
    bias = ca.vertcat(*[row.second_rate(remaining) for row in model.compilation.constraints.rows])
    bias = ca.substitute(bias, model.compilation.kinematics.symbols.tau, ca.SX(1))
    M = ca.jacobian(motion.momentum, motion.v)
    balance = ca.vertcat(M @ motion.a + motion.h + held.J.T @ held.symbols, held.J @ motion.a + bias)
    balance = ca.substitute(balance, motion.p, ca.DM(p))
    guess = ca.Function("guess", [motion.t, motion.q, motion.v, motion.p], [motion.acceleration, held.multipliers])
    z0 = ca.vertcat(*guess(0, start[:n], start[n:], p))
    dae = {"t": motion.t, "x": ca.vertcat(motion.q, motion.v), "z": ca.vertcat(motion.a, held.symbols),
           "ode": ca.vertcat(motion.v, motion.a), "alg": balance}
    options = {"reltol": tolerance, "abstol": tolerance, "max_num_steps": 1_000_000, "calc_ic": True, "suppress_algebraic": True,
               "jit": True, "compiler": "shell", "jit_options": {"flags": ["-O2"], "verbose": False}}
    solver = ca.integrator("solver", "idas", dae, 0, STOP, options)

    def solve() -> np.ndarray:
        return np.array(solver(x0=start, z0=z0)["xf"])[:n].ravel()

    return solve


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
    progress, rows = simulate(model.scene, engine, plan(model.scene, at=[2.0], tolerance=1e-6), check_values(model.scene))
    for _ in rows:
        pass
    return progress.seconds


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--repeats", type=int, default=20)
    parser.add_argument("--largest", type=int, default=200)
    options = parser.parse_args()
    for line in (*andrews(options.repeats), *ladder(options.largest)):
        print(line, flush=True)


if __name__ == "__main__":
    main()
