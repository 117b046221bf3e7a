"""Many short motions from arrays: 1 000 of a pole on a pushed cart, 100 steps of 0.02 s, each with another force, on all cores.

    python tests/benchmarks/rollouts.py [--runs N] [--repeats N]

Beside model.rollout: CasADi's map over threads of Runge-Kutta 4 (one step of it a sample) on the same equations, and MuJoCo's
rollout (RK4, one step a sample) where it is installed. The error is the median over the runs of the largest miss of the pole's
angle, against erk9 at 1e-13. Wall time: the shortest of the repeats, of all in turn.
"""

import argparse
import os
import time
from collections.abc import Callable

import numpy as np

import lagrangia as lag

DT, STEPS = 0.02, 100
SCENE = """model Pushed
  input Force F;
  Block    cart(m = 1, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, -90[deg]), phi(start = 0.1));
  Bar      pole(m = 0.1, L = 1, a = hinge.b);
  AppliedForce push(at = cart.center, force = {F, 0});
end Pushed;
"""
MJCF = """<mujoco><option gravity="0 0 -9.81" timestep="0.02" integrator="RK4"><flag contact="disable"/></option><worldbody>
  <body><joint name="s" type="slide" axis="1 0 0"/><inertial pos="0 0 0" mass="1" diaginertia="1e-9 1e-9 1e-9"/>
    <body><joint name="phi" type="hinge" axis="0 -1 0"/>
      <inertial pos="0 0 -0.5" mass="0.1" diaginertia="0.00833333333333 0.00833333333333 1e-9"/></body></body></worldbody>
  <actuator><motor joint="s"/></actuator></mujoco>"""
Work = Callable[[], np.ndarray]  # the angle, (runs, STEPS + 1)


def ours(u: np.ndarray, tolerance: float, solver: str = "auto") -> Work:
    model, times = lag.loads(SCENE), DT * np.arange(STEPS + 1)
    return lambda: model.rollout(u=u, times=times, tolerance=tolerance, solver=solver)["hinge.phi"]


def by_casadi(u: np.ndarray) -> Work:
    import casadi as ca

    model = lag.loads(SCENE)
    rhs, p = model.functions()["rhs"], model.parameter_values()
    x, force = ca.MX.sym("x", 4), ca.MX.sym("F")

    def slope(y: ca.MX) -> ca.MX:
        return ca.vertcat(y[2:], rhs(0, y[:2], y[2:], force, p))

    k1 = slope(x)
    k2 = slope(x + DT / 2 * k1)
    k3 = slope(x + DT / 2 * k2)
    step = ca.Function("step", [x, force], [x + DT / 6 * (k1 + 2 * k2 + 2 * k3 + slope(x + DT * k3))])
    every = step.expand().mapaccum(STEPS).map(len(u), "thread", os.cpu_count() or 1)
    forces, start = u.reshape(1, -1), np.tile([[0.0], [0.1], [0.0], [0.0]], (1, len(u)))
    first = np.full((len(u), 1), 0.1)
    return lambda: np.hstack([first, every(start, forces).full()[1].reshape(len(u), STEPS)])


def by_mujoco(u: np.ndarray) -> Work:
    import mujoco
    from mujoco import rollout

    model = mujoco.MjModel.from_xml_string(MJCF)
    data = [mujoco.MjData(model) for _ in range(os.cpu_count() or 1)]
    start = np.tile([0.0, 0.0, 0.1, 0.0, 0.0], (len(u), 1))
    first = np.full((len(u), 1), 0.1)
    return lambda: np.hstack([first, rollout.rollout(model, data, start, u)[0][:, :, 2]])


def main() -> None:
    """Prints a line a way."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=1000)
    parser.add_argument("--repeats", type=int, default=7)
    options = parser.parse_args()
    u = np.random.default_rng(0).normal(size=(options.runs, STEPS, 1))
    exact = ours(u, 1e-13, "erk9")()
    ways: dict[str, Work] = {f"rollout, tolerance {tolerance:g}": ours(u, tolerance) for tolerance in (1e-3, 1e-6, 1e-9)}
    for name, prepare in (("CasADi map, RK4", by_casadi), ("MuJoCo rollout, RK4", by_mujoco)):
        try:
            ways[name] = prepare(u)
        except ImportError:
            print(f"{name}: not installed")
    best = dict.fromkeys(ways, float("inf"))
    errors = {}
    for _ in range(options.repeats):
        for name, work in ways.items():
            begin = time.perf_counter()
            found = work()
            best[name] = min(best[name], time.perf_counter() - begin)
            errors[name] = float(np.median(np.abs(found - exact).max(axis=1)))
    for name, seconds in best.items():
        step = seconds / (options.runs * STEPS)
        print(f"{name}: {1e3 * seconds:.1f} ms, {1e9 * step:.0f} ns a step, error {errors[name]:.1e} rad")


if __name__ == "__main__":
    main()
