"""Equations of scenes of space.py as one writes them by hand, for heyoka and for SciPy (their right-hand side compiled by
heyoka), and trees whose accelerations Pinocchio tells, for SciPy and SUNDIALS' CVODE.

The spatial four-bar and Bricard's six-bar have one coordinate here: J(q) q'' + J'(q) q'^2/2 + V'(q) = 0, whose J and V follow
from how the loop closes, solved by hand.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import numpy as np
from scipy.integrate import solve_ivp

Array = np.ndarray
Case = tuple[Callable[[], Any], Callable[[], float]]  # a run, and how far it ended from what is known
Error = Callable[[Array], float]


class Equations(NamedTuple):
    motion: list[tuple[Any, Any]]  # heyoka's variables and their rates
    start: Sequence[float]
    stop: float  # s
    error: Error  # of the last state


def by_heyoka(problem: Equations, tolerance: float) -> Case:
    import heyoka as hy

    solver = hy.taylor_adaptive(problem.motion, list(problem.start), tol=tolerance)

    def run() -> None:
        solver.time, solver.state[:] = 0.0, problem.start
        solver.propagate_until(problem.stop)

    return run, lambda: problem.error(solver.state)


def by_scipy(derivative: Callable[[float, Array], Array], problem: Equations, method: str, tolerance: float) -> Case:
    found = []

    def run() -> None:
        motion = solve_ivp(derivative, (0, problem.stop), problem.start, method=method, rtol=tolerance, atol=tolerance)
        found[:] = [motion.y[:, -1]]

    return run, lambda: problem.error(found[0])


def compiled(problem: Equations) -> Callable[[float, Array], Array]:
    import heyoka as hy

    rates = hy.cfunc([rate for _, rate in problem.motion], [name for name, _ in problem.motion])
    return lambda _, state: rates(state)


def by_cvode(derivative: Callable[[float, Array], Array], problem: Equations, tolerance: float) -> Case:
    from sksundae.cvode import CVODE

    def residual(t: float, state: Array, rate: Array) -> None:
        rate[:] = derivative(t, state)

    solver, found = CVODE(residual, rtol=tolerance, atol=tolerance, method="Adams", max_num_steps=20_000), []

    def run() -> None:
        motion = solver.solve(np.array([0, problem.stop]), np.array(problem.start))
        if not motion.success:
            raise ArithmeticError("CVODE gave up")
        found[:] = [motion.y[-1]]

    return run, lambda: problem.error(found[0])


# -------------------------------------------------------------------- by hand


def top(centre: Array) -> Equations:
    """Unit quaternion and rates in own axes."""
    import heyoka as hy

    a, x, y, z, p, q, r = hy.make_vars(*"axyzpqr")
    A, C, pull = 0.007, 0.001, 0.5 * 9.81 * 0.1
    level = 2 * (x * z - a * y), 2 * (y * z + a * x)  # components of the vertical in body axes
    motion = [(a, -0.5 * (x * p + y * q + z * r)), (x, 0.5 * (a * p + y * r - z * q)), (y, 0.5 * (a * q + z * p - x * r)),
              (z, 0.5 * (a * r + x * q - y * p)), (p, ((A - C) * q * r + pull * level[1]) / A),
              (q, ((C - A) * r * p - pull * level[0]) / A), (r, 0.0 * p)]

    def error(state: Array) -> float:
        a, x, y, z = state[:4] / np.linalg.norm(state[:4])
        return float(np.abs([2 * (x * z + a * y), 2 * (y * z - a * x), 1 - 2 * (x**2 + y**2)] - 10 * centre).max())

    return Equations(motion, [np.cos(0.25), np.sin(0.25), 0, 0, 0, 0, 200.0], 2, error)


def top_in_angles(centre: Array) -> Equations:
    """Euler's angles, whose two momenta are constant: nutation, precession and spin."""
    import heyoka as hy

    theta, rate, phi, psi = hy.make_vars("theta", "rate", "phi", "psi")
    A, C, pull, spin = 0.007, 0.001, 0.5 * 9.81 * 0.1, 200.0
    s, c = hy.sin(theta), hy.cos(theta)
    turning = C * spin * (np.cos(0.5) - c) / (A * s * s)
    motion = [(theta, rate), (rate, (pull - C * spin * turning) * s / A + turning * turning * s * c), (phi, turning),
              (psi, spin - turning * c)]
    return Equations(motion, [0.5, 0, 0, 0], 2, lambda state: float(np.abs(
        [np.sin(state[2]) * np.sin(state[0]), -np.cos(state[2]) * np.sin(state[0]), np.cos(state[0])] - 10 * centre).max()))


def _one_coordinate(J: Any, V: Any, q: Any, start: Sequence[float], known: float) -> Equations:
    import heyoka as hy

    w = hy.expression("w")
    return Equations([(q, w), (w, -(hy.diff(J, q) * w * w / 2 + hy.diff(V, q)) / J)], start, 2,
                     lambda state: abs(float(state[0]) - known))


def rssr(known: float) -> Equations:
    """By the crank's angle: C = cos(rocker), S = sin(rocker) follow from the rod's length."""
    import heyoka as hy

    q, D = hy.expression("q"), (0.9, 0.5, 0.2)
    crank = [0.3 * hy.cos(q), 0.3 * hy.sin(q), 0 * q]
    x, y, z = (a - d for a, d in zip(crank, D, strict=True))
    square = x * x + z * z
    K = (square + y * y + 0.6**2 - 1.1**2) / 1.2
    root = hy.sqrt(square - K * K)
    C, S = (K * x + root * z) / square, (root * x - K * z) / square
    rocker = [D[0] + 0.6 * C, D[1] + 0 * q, D[2] - 0.6 * S]

    def swept(vector: Sequence[Any]) -> Any:
        return sum(hy.diff(part, q) ** 2 for part in vector)

    centre, rod = ([(a + b) / 2 for a, b in zip(crank, rocker, strict=True)], [b - a for a, b in zip(crank, rocker, strict=True)])
    J = 0.0425 + (0.05 + 1.5 * 0.09) / 0.36 * swept(rocker) + 2 * swept(centre) + 0.2 / 1.21 * swept(rod)
    return _one_coordinate(J, 9.81 * (2 * centre[2] - 1.5 * 0.3 * S), q, [0, 8], known)


def bricard(known: float) -> Equations:
    """By the first angle: the first, third and fifth are the same, the second and fourth too, and (1 + sin q) sin p = -sin q."""
    import heyoka as hy

    q = hy.expression("q")
    s, c = hy.sin(q), hy.cos(q)
    s2, c2 = -s / (1 + s), hy.sqrt(1 + 2 * s) / (1 + s)
    rate2 = -c / ((1 + s) ** 2 * c2)
    R, spin, place = [[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0 * q] * 3, [0 * q] * 3  # columns of R are a rod's axes
    J = V = 0 * q
    joints = ((1, s, c, 1), (2, s2, c2, rate2), (0, s, c, 1), (1, s2, c2, rate2), (2, s, c, 1))
    for (axis, sine, cosine, rate), (along, sign) in zip(joints, ((0, 1), (1, -1), (2, 1), (0, -1), (1, 1)), strict=True):
        spin = [w + rate * part for w, part in zip(spin, R[axis], strict=True)]
        i, j = (axis + 1) % 3, (axis + 2) % 3
        R[i], R[j] = ([cosine * a + sine * b for a, b in zip(R[i], R[j], strict=True)],
                      [cosine * b - sine * a for a, b in zip(R[i], R[j], strict=True)])
        rod = [sign * part for part in R[along]]
        centre = [a + b / 2 for a, b in zip(place, rod, strict=True)]
        place = [a + b for a, b in zip(place, rod, strict=True)]
        J += sum(hy.diff(part, q) ** 2 for part in centre) + 1.01 / 12 * sum(hy.diff(part, q) ** 2 for part in rod)
        J += 0.02 / 12 * sum(a * b for a, b in zip(spin, rod, strict=True)) ** 2
        V += 9.81 * centre[1]
    return _one_coordinate(J, V, q, [0, 0], known)


# -------------------------------------------------------------------- Pinocchio


def bars(n: int, inertia: Sequence[float], known: Array) -> tuple[Callable[[float, Array], Array], Equations]:
    """Hanging bars of length and mass 1/n on ball joints."""
    import pinocchio as pin
    from scipy.spatial.transform import Rotation

    tree, parent, place, q, v, m = pin.Model(), 0, pin.SE3.Identity(), [], [], 1 / n
    tree.gravity.linear = np.array([0, 0, -9.81])
    for k in range(n):
        parent = tree.addJoint(parent, pin.JointModelSpherical(), place, f"j{k}")
        tree.appendBodyToJoint(parent, pin.Inertia(m, np.zeros(3), np.diag(inertia)), pin.SE3(np.eye(3), np.array([m / 2, 0, 0])))
        place, half, spin = pin.SE3(np.eye(3), np.array([m, 0, 0])), 0.6 / n, np.array([10.0, 0, 0])
        q += [0, 0, np.sin(half), np.cos(half)]
        v += list(spin - (Rotation.from_rotvec([0, 0, -1.2 / n]).apply(spin) if k else 0))
    tip = tree.addFrame(pin.Frame("tip", parent, 0, place, pin.FrameType.OP_FRAME))
    data, still = tree.createData(), np.zeros(3 * n)

    def units(state: Array) -> Array:
        turns = state[: 4 * n].reshape(n, 4)
        return turns / np.linalg.norm(turns, axis=1)[:, None]

    def derivative(_: float, state: Array) -> Array:
        turns, w = units(state), state[4 * n :].reshape(n, 3)
        x, real = turns[:, :3], turns[:, 3:]
        rates = np.hstack([(real * w + np.cross(x, w)) / 2, -(x * w).sum(1, keepdims=True) / 2])
        return np.concatenate([rates.ravel(), pin.aba(tree, data, turns.ravel(), state[4 * n :], still)])

    def error(state: Array) -> float:
        pin.framesForwardKinematics(tree, data, units(state).ravel())
        return float(np.abs(data.oMf[tip].translation - known).max())

    return derivative, Equations([], q + v, 1, error)


def arm(links: Sequence[tuple[float, Array, Array, Array, Array]], start: Sequence[float],
        known: Array) -> tuple[Callable[[float, Array], Array], Equations]:
    """Hinges about their own z; of each link mass, centre, inertia about it, turn and way to the next hinge."""
    import pinocchio as pin

    tree, parent, place = pin.Model(), 0, pin.SE3.Identity()
    tree.gravity.linear = np.array([0, 0, -9.81])
    for k, (m, centre, inertia, turn, ahead) in enumerate(links):
        parent = tree.addJoint(parent, pin.JointModelRZ(), place, f"j{k}")
        tree.appendBodyToJoint(parent, pin.Inertia(m, centre, inertia), pin.SE3.Identity())
        place = pin.SE3(turn, ahead)
    data, n, still = tree.createData(), len(links), np.zeros(len(links))
    return (lambda _, state: np.concatenate([state[n:], pin.aba(tree, data, state[:n], state[n:], still)]),
            Equations([], start, 2, lambda state: float(np.abs(state[:n] - known).max())))
