"""Lagrange's equations of random trees against Newton and Euler's, against plain differentiation, and against themselves.

From the functions of a model, with J_i = dr_i/dq and the kinetic energy T of the model itself or that of its bodies:

    M = sum_i m_i J_i^T J_i + I_i (dphi_i/dq)^T (dphi_i/dq)
    h = d/dt(dT/dv) - dT/dq + dV/dq + dD/dv - f,          f = J^T F + (dphi/dq)^T torque
"""

from dataclasses import dataclass, field
from functools import cache
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.random_trees import FX, FY, TORQUE, Body, RandomTree, random_tree
from lagrangia.dynamics.bodies import find_bodies
from lagrangia.dynamics.elimination import articulate
from lagrangia.dynamics.motion import solve_dense

# Of bodies, and seeds: an odd one moves the base. Large trees, which take longest, are one of each size, every other one moved.
TREES = [*((seed, count) for count in range(1, 5) for seed in range(3)), (1, 5), (0, 6), (1, 7), (0, 8)]
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"


@dataclass(frozen=True)
class Tree:
    """A random tree, compiled, with symbols for its states."""

    tree: RandomTree
    model: lag.Model
    functions: dict[str, ca.Function] = field(init=False)
    t: ca.SX = field(default_factory=lambda: ca.SX.sym("t"))
    q: ca.SX = field(init=False)
    v: ca.SX = field(init=False)

    def __post_init__(self) -> None:
        n = self.model.scene.n
        object.__setattr__(self, "functions", self.model.functions())
        object.__setattr__(self, "q", ca.SX.sym("q", n))
        object.__setattr__(self, "v", ca.SX.sym("v", n))

    def value(self, function: str) -> ca.SX | tuple[ca.SX, ...]:
        """The outputs of one of the model's functions in these symbols."""
        return self.functions[function](self.t, self.q, self.v, ca.SX(0, 1), self.model.parameter_values())

    def outputs(self) -> dict[str, ca.SX]:
        return dict(zip((c.name for c in self.model.scene.outputs), ca.vertsplit(self.value("outputs")), strict=True))

    def random_state(self, k: int) -> tuple[float, np.ndarray, np.ndarray]:
        random = np.random.default_rng(k)
        return random.uniform(0, 3), *random.uniform(-2, 2, (2, self.model.scene.n))

    def numbers(self, *expressions: ca.SX) -> list[np.ndarray]:
        """The expressions at 5 random states, each of shape (5, rows, columns)."""
        function = ca.Function("numbers", [self.t, self.q, self.v], expressions)
        rows = [function.call([ca.DM(x) for x in self.random_state(k)]) for k in range(5)]
        return [np.stack([np.array(x) for x in column]) for column in zip(*rows, strict=True)]


@cache
def compiled(folder: Path, seed: int, count: int) -> Tree:
    tree = random_tree(1000 * count + seed, count)
    path = folder / f"tree_{count}_{seed}.lag"
    path.write_text(tree.text, encoding="utf-8")
    wanted = [f"{body.name}.center.{x}" for body in tree.bodies for x in ("x", "y", "phi")]
    wanted += [f"{tree.force_at}.x", f"{tree.force_at}.y", f"{tree.torque_on}.phi"]
    return Tree(tree, lag.Model(path, outputs=tuple(dict.fromkeys(wanted))))


@pytest.fixture(params=TREES, ids=lambda p: f"{p[1]}_bodies_{p[0]}")
def scene(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Tree:
    return compiled(tmp_path_factory.getbasetemp(), *request.param)


def kinetic_energy(body: Body, at: dict[str, ca.SX], scene: Tree) -> ca.SX:
    """m v^2/2 + I w^2/2 from the body's place alone."""
    x, y, w = (rate(at[f"{body.name}.center.{name}"], scene) for name in ("x", "y", "phi"))
    return body.m * (x**2 + y**2) / 2 + body.I * w**2 / 2


def rate(expression: ca.SX, scene: Tree) -> ca.SX:
    """d/dt along the motion at zero accelerations."""
    return ca.jtimes(expression, ca.vertcat(scene.q, scene.t), ca.vertcat(scene.v, 1))


def forces(scene: Tree, T: ca.SX) -> ca.SX:
    """h as Lagrange wrote it."""
    at = scene.outputs()
    _, V, D = scene.value("energies")
    F = ca.vertcat(FX, FY * ca.sin(2 * scene.t), TORQUE * ca.cos(1.5 * scene.t))
    pushed, twisted = scene.tree.force_at, scene.tree.torque_on
    place = ca.vertcat(*(at[name] for name in (f"{pushed}.x", f"{pushed}.y", f"{twisted}.phi")))
    momentum = ca.gradient(T, scene.v)
    return rate(momentum, scene) + ca.gradient(V - T, scene.q) + ca.gradient(D, scene.v) - ca.jacobian(place, scene.q).T @ F


def assert_equal(found: np.ndarray, expected: np.ndarray, digits: float) -> None:
    np.testing.assert_allclose(found, expected, rtol=0, atol=digits * max(1, np.abs(expected).max()))


# ---------------------------------------------------------------- the equations


def test_h_is_what_differentiation_makes_of_the_energies(scene: Tree) -> None:
    T, _, _ = scene.value("energies")
    h, expected = scene.numbers(scene.value("h"), forces(scene, T))
    assert_equal(h, expected, 1e-10)


def test_m_and_h_are_those_of_newton_and_euler(scene: Tree) -> None:
    at = scene.outputs()
    T = sum(kinetic_energy(body, at, scene) for body in scene.tree.bodies)
    M, h, of_bodies, expected = scene.numbers(scene.value("M"), scene.value("h"), ca.hessian(T, scene.v)[0], forces(scene, T))
    assert_equal(M, of_bodies, 1e-12)
    assert_equal(h, expected, 1e-10)


def test_m_is_symmetric_and_positive(scene: Tree) -> None:
    (M,) = scene.numbers(scene.value("M"))
    assert_equal(M, M.transpose(0, 2, 1), 1e-14)
    assert np.linalg.eigvalsh(M).min() > 0


def test_both_ways_of_solving_agree(scene: Tree) -> None:
    """Elimination along the tree, M factored as a whole, and the accelerations the model gives."""
    compilation = scene.model.compilation
    motion = compilation.motion
    tree = articulate(compilation.kinematics, find_bodies(compilation.kinematics, compilation.energies))
    assert tree is not None
    along = tree.solve(-motion.h)
    dense = solve_dense(motion.momentum, -motion.h, motion.v)
    both = ca.Function("both", [motion.t, motion.q, motion.v, motion.p], [along, dense, motion.acceleration])
    for k in range(5):
        found = [np.array(x) for x in both(*scene.random_state(k), scene.model.parameter_values())]
        assert_equal(found[0], found[1], 1e-11)
        assert_equal(found[2], found[1], 1e-11)


# ---------------------------------------------------------------- the motion


@pytest.mark.parametrize("tolerance", [1e-6, 1e-10])
def test_the_energy_account_closes(scene: Tree, tolerance: float) -> None:
    energy = scene.model.simulate(stop=2, tolerance=tolerance).energy
    scale = max(np.abs(part).max() for part in (energy.kinetic, energy.potential, energy.dissipated, energy.work))
    assert energy.dissipated[-1] > 0
    assert np.abs(energy.residual).max() < 1e3 * tolerance * scale


@pytest.mark.parametrize(("name", "solver"), [
    ("cart_pole", "erk"), ("spring_pendulum", "erk"), ("suspended_bar", "erk"), ("pendulum", "taylor"), ("cart_pole", "taylor"),
])
def test_the_error_follows_the_tolerance(name: str, solver: str) -> None:
    """From 1e-4 to 1e-11 a tenth of the tolerance is a tenth of the error, on the whole and nearly at each step."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    times = np.linspace(0, 3, 31)
    states = slice(1, 1 + 2 * model.scene.n)
    exact = model.simulate(at=times, tolerance=1e-14, solver="erk").rows[:, states]
    tolerances = 10.0 ** np.arange(-4, -12, -1)
    size = np.abs(exact).max(axis=0)
    runs = [model.simulate(at=times, tolerance=t, solver=solver).rows[:, states] for t in tolerances]
    errors = [np.abs(run - exact).max(axis=0) / size for run in runs]
    worst = np.max(errors, axis=1)
    known = worst > 1e-13  # the reference has rounding of its own
    slope = np.polyfit(np.log(tolerances[known]), np.log(worst[known]), 1)[0]
    assert 0.85 < slope < 1.15
    assert np.all(worst < 50 * tolerances)
