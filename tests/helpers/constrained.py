"""Constrained scenes for the run time, as the compiler would make them: energies aside, everything from M, f and Phi."""

import casadi as ca

from lagrangia.compile.instructions import tape_of
from lagrangia.native.tapes import Tape
from lagrangia.run.runtime import Model

EPSILON = 1e-8  # keeps the KKT matrix regular where constraints repeat each other; 1e-12 leaves noise of 5e-8 in a


def constrained(
    q: ca.SX, v: ca.SX, M: ca.SX, f: ca.SX, phi: ca.SX, *,
    skates: ca.SX | None = None, guess: list[float] | None = None, kinds: list[int] | None = None,
) -> Model:
    """M(q) a + J' lambda = f(q, v), phi(q) = 0, skates(q, v) = 0 linear in v; outputs are the multipliers.

    With a guess of q, start values are assembled from it.
    """
    n = q.numel()
    t, u, d, c, p = ca.SX.sym("t"), *(ca.SX.sym(name, 0) for name in "udcp")
    rate = ca.vertcat(ca.jtimes(phi, q, v), skates if skates is not None else ca.SX(0, 1))
    J = ca.jacobian(rate, v)
    m, drift = J.shape[0], ca.jtimes(rate, q, v)
    a_lambda = _solve(M, J, ca.vertcat(f, -drift))
    holonomic = J[: phi.numel(), :]
    a, multipliers = ca.SX.sym("a", n), ca.SX.sym("lambda", m)
    functions = {
        "start": ([p], [ca.SX(guess or [0] * n), ca.SX.zeros(n)]),
        "rhs": ([t, q, v, u, d, c], [a_lambda[:n], ca.SX(0, 1), a_lambda[n:]]),
        "outputs": ([t, q, v, a, multipliers, u, d, c], [multipliers]),
        "place": ([t, q, u, d, c], [_solve(M, holonomic, ca.vertcat(ca.SX.zeros(n), -phi))[:n]]),
        "steer": ([t, q, v, u, d, c], [_solve(M, J, ca.vertcat(ca.SX.zeros(n), -rate))[:n]]),
        "residual": ([t, q, v, u, d, c], [phi, rate]),
    }
    sizes = {"n": n, "n_holonomic": phi.numel(), "n_multipliers": m, "n_outputs": m, "outputs_need_acceleration": 1}
    patterns = dict[str, tuple[int, ...]]()
    if guess:
        g = ca.vertcat(phi, rate)
        functions["initial"] = ([q, v, p], [g, ca.vec(ca.densify(ca.jacobian(g, ca.vertcat(q, v))).T)])
        patterns["initial_pattern"] = (*range(0, 2 * n * g.numel() + 1, 2 * n), *([*range(2 * n)] * g.numel()))
        sizes |= {"n_initial": g.numel(), "n_initial_positions": phi.numel()}
    tapes = {name: _tape(name, inputs, outputs) for name, (inputs, outputs) in functions.items()}
    return Model.from_tapes(sizes, tapes, kinds or [0] * n, [0] * (2 * n), patterns=patterns)


def _tape(name: str, inputs: list[ca.SX], outputs: list[ca.SX]) -> Tape:
    return tape_of(ca.Function(name, inputs, [ca.densify(x) for x in ca.cse(outputs)]))


def _solve(M: ca.SX, J: ca.SX, right: ca.SX) -> ca.SX:
    """x of [M J'; J 0] x = right, by the regularised matrix and one step of refinement."""
    m = J.shape[0]
    exact = ca.blockcat([[M, J.T], [J, ca.SX.zeros(m, m)]])
    regular = ca.blockcat([[M, J.T], [J, -EPSILON * ca.SX.eye(m)]])
    x = ca.solve(regular, right)
    return x + ca.solve(regular, right - exact @ x)


def _unit(angle: ca.SX) -> ca.SX:
    return ca.vertcat(ca.cos(angle), ca.sin(angle))


def pendulum() -> Model:
    """A unit mass at (x, y), y downwards, on a rod of length 1; g = 1."""
    q, v = ca.SX.sym("q", 2), ca.SX.sym("v", 2)
    return constrained(q, v, ca.SX.eye(2), ca.SX([0, 1]), ca.sumsqr(q) - 1, kinds=[1, 1])


def skate() -> Model:
    """A blade (x, y, phi) on a slope: the acceleration 1 along x."""
    q, v = ca.SX.sym("q", 3), ca.SX.sym("v", 3)
    sideways = ca.cos(q[2]) * v[1] - ca.sin(q[2]) * v[0]
    return constrained(q, v, ca.SX.eye(3), ca.SX([1, 0, 0]), ca.SX(0, 1), skates=sideways, kinds=[1, 1, 0])


def linkage(lengths: list[float], base: float, guess: list[float]) -> Model:
    """Crank, coupler and rocker as uniform bars of their own angles, under gravity.

    A fourth angle guessed is that of a third bar, as long as the crank, at half way: it repeats what the others impose.
    """
    count = len(guess)
    q, v = ca.SX.sym("q", count), ca.SX.sym("v", count)
    crank, coupler, rocker = lengths
    ends = [crank * _unit(q[0]), coupler * _unit(q[1]), rocker * _unit(q[2])]
    phi = [ends[0] + ends[1] - ca.DM([base, 0]) - ends[2]]
    centres = [ends[0] / 2, ends[0] + ends[1] / 2, ends[2] / 2]
    if count == 4:
        third = crank * _unit(q[3])
        phi.append(ends[0] + ends[1] / 2 - ca.DM([base / 2, 0]) - third)
        centres.append(third / 2)
        lengths = [*lengths, crank]
    speeds = [ca.jtimes(r, q, v) for r in centres]
    T = sum(L * ca.sumsqr(w) / 2 + L**3 / 24 * v[i] ** 2 for i, (L, w) in enumerate(zip(lengths, speeds, strict=True)))
    V = sum(9.81 * L * r[1] for L, r in zip(lengths, centres, strict=True))
    momentum = ca.gradient(T, v)
    f = ca.gradient(T - V, q) - ca.jtimes(momentum, q, v)
    return constrained(q, v, ca.jacobian(momentum, v), f, ca.vertcat(*phi), guess=guess)
