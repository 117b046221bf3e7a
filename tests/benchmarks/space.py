"""Time to an error of scenes in space whose motion is known: a fast top, a swinging robot arm, 20 bars on ball joints, Bricard's
six-bar, a spatial four-bar. Beside them what is installed of the peers in the Python that runs this: heyoka on the top's
equations written by hand, Pinocchio's ABA under SciPy's DOP853 on the bars, MuJoCo, Exudyn on the arm (space_peers.py).
Processor time, the shortest of some runs.

    python tests/benchmarks/space.py [--repeat N] [--only top,arm,chain,bricard,rssr]
"""

import sys
import time
from argparse import ArgumentParser
from collections.abc import Callable, Iterator
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

sys.path.insert(0, str(Path(__file__).parents[1]))

from benchmarks import space_peers as peers
from lagrangia.model import Model
from whole.test_space_cases import EXAMPLES, FOLDER, REFERENCES, chain, rod_start

TOLERANCES = (1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
Found = tuple[float, float]  # ms, error


def shortest(run: Callable[[], Any], repeat: int) -> tuple[float, Any]:
    """ms of processor time, and the last result."""
    best, result = np.inf, None
    for _ in range(repeat):
        begin = time.process_time()
        result = run()
        best = min(best, time.process_time() - begin)
    return 1e3 * best, result


def ours(model: Model, stop: float, error: Callable[[Any], float], repeat: int, **more: Any) -> list[Found]:
    found = []
    for tolerance in TOLERANCES:
        took, run = shortest(lambda t=tolerance: model.simulate(at=[0, stop], tolerance=t, **more), repeat)
        found.append((took, error(run)))
    return found


def ours_compiled(model: Model, stop: float, error: Callable[[Any], float], repeat: int) -> list[Found]:
    """Prepared runs in native code, as heyoka's are."""
    model.native = True
    found = []
    for tolerance in TOLERANCES:
        asked = {"at": [0, stop], "tolerance": tolerance}
        took, _ = shortest(model.prepare(**asked), repeat)
        found.append((took, error(model.simulate(**asked))))
    return found


def peer(make: Callable[[float], peers.Case], repeat: int, package: str = "mujoco") -> list[Found] | None:
    """Of runs made for each tolerance; None where the package is missing."""
    if find_spec(package) is None:
        return None
    found = []
    for tolerance in TOLERANCES:
        run, error = make(tolerance)
        took, _ = shortest(run, repeat)
        found.append((took, error()))
    return found


def by_steps(pace: float, tolerance: float) -> float:
    """Steps a second of a method of fourth order; `pace` at tolerance 1."""
    return pace * tolerance**-0.25


def top(repeat: int) -> Iterator[tuple[str, list[Found] | None]]:
    centre = np.array(REFERENCES["top"]["fast"][-1]["centre"])
    model = Model(FOLDER / "cases.lag", model="HeavyTop")
    yield "lagrangia", ours_compiled(model, 2, lambda run: np.abs(run["top.center.r"][-1] - centre).max() / 0.1, repeat)
    yield "MuJoCo", peer(lambda tolerance: peers.top(by_steps(250, tolerance), centre), 1)
    try:
        import heyoka as hy
    except ImportError:
        return
    a, x, y, z, p, q, r = hy.make_vars(*"axyzpqr")
    A, C, pull = 0.007, 0.001, 0.5 * 9.81 * 0.1
    level = 2 * (x * z - a * y), 2 * (y * z + a * x)  # components of the vertical in body axes
    motion = [(a, -0.5 * (x * p + y * q + z * r)), (x, 0.5 * (a * p + y * r - z * q)), (y, 0.5 * (a * q + z * p - x * r)),
              (z, 0.5 * (a * r + x * q - y * p)), (p, ((A - C) * q * r + pull * level[1]) / A),
              (q, ((C - A) * r * p - pull * level[0]) / A), (r, 0.0 * p)]
    start, found = [np.cos(0.25), np.sin(0.25), 0, 0, 0, 0, 200.0], []
    for tolerance in TOLERANCES:
        solver = hy.taylor_adaptive(motion, start, tol=tolerance)

        def run(solver: Any = solver) -> None:
            solver.time, solver.state[:] = 0.0, start
            solver.propagate_until(2.0)

        took, _ = shortest(run, repeat)
        a_, x_, y_, z_ = solver.state[:4] / np.linalg.norm(solver.state[:4])
        axis = np.array([2 * (x_ * z_ + a_ * y_), 2 * (y_ * z_ - a_ * x_), 1 - 2 * (x_**2 + y_**2)])
        found.append((took, np.abs(axis - 10 * centre).max()))
    yield "heyoka", found


def arm(repeat: int) -> Iterator[tuple[str, list[Found] | None]]:
    known = np.array(REFERENCES["robot_arm_swing"][-1]["q"])
    start = [0, np.pi / 4, np.pi, 0.3, np.pi / 4, 0]
    initial = {f"joint[{k}].phi": x for k, x in enumerate(start, 1)} | {"joint[1].w": 0.5}
    model = Model(EXAMPLES / "robot_arm.lag")
    yield "lagrangia", ours(model, 2, lambda run: max(
        abs(run[f"joint[{k}].phi"][-1] - known[k - 1]) for k in range(1, 7)), repeat, initial=initial)
    values, rates = dict(zip(model.parameter_names, model.parameter_values(), strict=True)), [0.5, 0, 0, 0, 0, 0]
    yield "Exudyn", peer(lambda tolerance: peers.arm(values, tolerance, start, rates, known), 1, "exudyn")


def bars(repeat: int) -> Iterator[tuple[str, list[Found] | None]]:
    n = 20
    m = L = 1 / n
    across, known = m * L**2 / 12 + m * 0.01**2 / 4, np.array(REFERENCES["hanging_20"][-1]["end"])
    model = chain([(m, L, (m * 0.01**2 / 2, across, across), 1)] * n,
                  [Rotation.from_rotvec([0, 0, 1.2 * k / n]) for k in range(1, n + 1)], np.array([[10, 0, 0]] * n))
    yield "lagrangia", ours(model, 1, lambda run: np.abs([run[f"tip[{k}]"][-1] - known[k - 1] for k in (1, 2, 3)]).max(), repeat)
    yield "MuJoCo", peer(lambda tolerance: peers.bars(by_steps(60, tolerance), n, (m * 0.01**2 / 2, across, across), known), 1)
    try:
        import pinocchio as pin
        from scipy.integrate import solve_ivp
    except ImportError:
        return
    tree, parent, place, q, v = pin.Model(), 0, pin.SE3.Identity(), [], []
    tree.gravity.linear = np.array([0, 0, -9.81])
    for k in range(n):
        parent = tree.addJoint(parent, pin.JointModelSpherical(), place, f"j{k}")
        inertia = pin.Inertia(m, np.zeros(3), np.diag([m * 0.01**2 / 2, across, across]))
        tree.appendBodyToJoint(parent, inertia, pin.SE3(np.eye(3), np.array([L / 2, 0, 0])))
        place, half, spin = pin.SE3(np.eye(3), np.array([L, 0, 0])), 0.6 / n, np.array([10.0, 0, 0])
        q += [0, 0, np.sin(half), np.cos(half)]
        v += list(spin - (Rotation.from_rotvec([0, 0, -1.2 / n]).apply(spin) if k else 0))
    tip = tree.addFrame(pin.Frame("tip", parent, 0, place, pin.FrameType.OP_FRAME))
    data, still = tree.createData(), np.zeros(3 * n)

    def derivative(_: float, state: np.ndarray) -> np.ndarray:
        turns, w = state[: 4 * n].reshape(n, 4), state[4 * n :].reshape(n, 3)
        turns = turns / np.linalg.norm(turns, axis=1)[:, None]
        x, real = turns[:, :3], turns[:, 3:]
        rates = np.hstack([(real * w + np.cross(x, w)) / 2, -(x * w).sum(1, keepdims=True) / 2])
        return np.concatenate([rates.ravel(), pin.aba(tree, data, turns.ravel(), state[4 * n :], still)])

    found = []
    for tolerance in TOLERANCES:
        took, run = shortest(lambda t=tolerance: solve_ivp(derivative, (0, 1), q + v, method="DOP853", rtol=t, atol=t), 1)
        turns = run.y[: 4 * n, -1].reshape(n, 4)
        pin.framesForwardKinematics(tree, data, (turns / np.linalg.norm(turns, axis=1)[:, None]).ravel())
        found.append((took, np.abs(data.oMf[tip].translation - known).max()))
    yield "Pinocchio, SciPy", found


def bricard(repeat: int) -> Iterator[tuple[str, list[Found] | None]]:
    model, known = Model(FOLDER / "bricard.lag"), 2.89332820598129336
    yield "lagrangia", ours(model, 2, lambda run: abs(run["p0.phi"][-1] - known), repeat)
    begin = model.simulate(at=[0])
    yield "MuJoCo", peer(lambda tolerance: peers.bricard(by_steps(20, tolerance), begin, known), 1)


def rssr(repeat: int) -> Iterator[tuple[str, list[Found] | None]]:
    model, known, values = Model(FOLDER / "cases.lag", model="Rssr"), REFERENCES["rssr"][-1]["theta"], rod_start()
    yield "lagrangia", ours(model, 2, lambda run: abs(run["turning.phi"][-1] - known), repeat, parameters=values)
    begin = model.simulate(at=[0], parameters=values)
    yield "MuJoCo", peer(lambda tolerance: peers.rssr(by_steps(20, tolerance), begin, known), 1)


SCENES = {"top": top, "arm": arm, "chain": bars, "bricard": bricard, "rssr": rssr}


def main() -> None:
    parser = ArgumentParser(description="time to an error of scenes in space")
    parser.add_argument("--repeat", type=int, default=5)
    parser.add_argument("--only", default=",".join(SCENES))
    options = parser.parse_args()
    for name in options.only.split(","):
        for who, found in SCENES[name](options.repeat):
            told = ["not installed"] if found is None else [f"{took:.3g} ms to {error:.0e}" for took, error in found]
            print(f"{name:8}{who:18}" + "  ".join(told))


if __name__ == "__main__":
    main()
