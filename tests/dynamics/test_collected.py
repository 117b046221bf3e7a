"""Collected inertia: nothing is left that cancels, and what is left is what AD finds in world axes."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.random_trees import random_tree
from helpers.reference import pendulum_angle
from lagrangia.algebra.harmonics import Harmonics, TooLarge, added
from lagrangia.compile.pipeline import Compilation, compile_file, flatten_file
from lagrangia.constraints.rows import reduce_kinematics
from lagrangia.dynamics.bodies import find_bodies
from lagrangia.dynamics.collected_inertia import split_weights
from lagrangia.dynamics.energies import build_energies
from lagrangia.dynamics.motion import mass_matrix
from lagrangia.frames.graph import build_graph
from lagrangia.frames.kinematics import build_kinematics

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
X, Y, K = ca.SX.sym("x"), ca.SX.sym("y"), ca.SX.sym("k")


def sums(*expressions: ca.SX) -> list[int]:
    """The number of terms of each."""
    return [len(total) for total in Harmonics().sums(ca.vertcat(*expressions))]


def test_what_is_equal_cancels() -> None:
    s, c = ca.sin(X), ca.cos(X)
    assert sums(s * s + c * c, s * (c * K) - c * (s * K), s * ca.cos(Y) + c * ca.sin(Y) - ca.sin(X + Y)) == [1, 0, 0]
    assert sums(ca.sin(X + np.pi / 2) - c, ca.cos(X - np.pi) + c, ca.sin(-X) + s, ca.cos(X - Y) - ca.cos(Y - X)) == [0, 0, 0, 0]
    assert sums(K * X / K - X, (X + Y) ** 2 - X**2 - Y**2 - 2 * X * Y, (0.1 + 0.2) * X - 0.3 * X) == [0, 0, 0]


def test_other_functions_are_left_alone() -> None:
    root = ca.sqrt(X * X + Y * Y)
    assert sums(root * (X + Y) - Y * root, 1 / (1 + X), ca.sin(ca.sin(X))) == [1, 1, 1]


def test_it_gives_up_in_time() -> None:
    many = ca.SX.sym("q", 40)
    with pytest.raises(TooLarge):
        Harmonics().sums(ca.sum1(many) ** 2 * ca.sum1(ca.sin(many)) ** 2)


def test_sums_of_sums() -> None:
    one, two = Harmonics().sums(ca.vertcat(3 * ca.cos(X), 2 * ca.cos(X)))
    assert list(added(one, two, -1.5)) == []


def values(expressions: list[ca.SX], seed: int = 3) -> list[np.ndarray]:
    free = ca.symvar(ca.veccat(*expressions))
    numbers = np.random.default_rng(seed).uniform(0.3, 1.4, len(free))
    return [x.full() for x in ca.Function("f", free, expressions)(*numbers)] if free else []


def world(scene: Path, **structural: int) -> tuple[Compilation, ca.SX, ca.SX]:
    """A scene as it is compiled, with M and h of the same symbols in world axes, by AD alone."""
    compiled = compile_file(scene, None, structural)
    symbols, energies = compiled.kinematics.symbols, compiled.energies
    q, v = (ca.vertcat(*x.values()) for x in (symbols.positions, symbols.rates))
    L = energies.total(energies.kinetic) - energies.total(energies.potential)
    p = ca.gradient(L, v)
    h = ca.jtimes(p, ca.vertcat(q, symbols.time), ca.vertcat(v, symbols.tau)) - ca.gradient(L, q)
    h += ca.gradient(energies.total(energies.dissipation), v)
    for load in energies.loads:
        h -= ca.jacobian(ca.vertcat(*load.position), q).T @ ca.vertcat(*load.force)
    M, h = ca.substitute([ca.jacobian(p, v), h], [symbols.tau], [ca.SX(1)])
    return compiled, M, h


@pytest.mark.parametrize("name, most, longer", [
    ("pendulum", 3, "tree"), ("double_pendulum", 33, "tree"), ("chain", 84, "tree"),
    ("cart_pole", 29, "dense"),  # along the tree hardly shorter, but for M and h
])
def test_examples_are_collected(name: str, most: int, longer: str) -> None:
    compiled, M, h = world(EXAMPLES / f"{name}.lag", **({"n": 3} if name == "chain" else {}))
    motion = compiled.motion
    assert motion.way == "collected"
    assert motion.nodes["collected"] <= most < motion.nodes[longer]
    own_M, own_h, exact_M, exact_h, a = values([mass_matrix(motion), motion.h, M, h, motion.acceleration])
    assert own_M == pytest.approx(exact_M, rel=1e-13, abs=1e-13 * np.abs(exact_M).max())
    assert own_h == pytest.approx(exact_h, rel=1e-13, abs=1e-13 * np.abs(exact_h).max())
    assert exact_M @ a == pytest.approx(-exact_h, rel=1e-12, abs=1e-12 * np.abs(exact_h).max())


@pytest.mark.parametrize("name", ["four_bar", "slider_crank", "suspended_bar", "rolling_disc", "ellipse_trammel", "free_bar"])
def test_it_is_the_same_motion(name: str) -> None:
    compiled, M, h = world(EXAMPLES / f"{name}.lag")
    own_M, own_h, exact_M, exact_h = values([mass_matrix(compiled.motion), compiled.motion.h, M, h])
    assert own_M == pytest.approx(exact_M, rel=1e-13, abs=1e-13 * np.abs(exact_M).max())
    assert own_h == pytest.approx(exact_h, rel=1e-13, abs=1e-13 * np.abs(exact_h).max())


def test_a_pendulum_has_no_centrifugal_terms_and_a_constant_mass() -> None:
    motion = compile_file(EXAMPLES / "pendulum.lag").motion
    assert not ca.depends_on(motion.h, motion.v)
    assert not ca.depends_on(mass_matrix(motion), motion.q)


@pytest.mark.parametrize("seed", range(12))
def test_random_trees(seed: int, tmp_path: Path) -> None:
    scene = tmp_path / "scene.lag"
    scene.write_text(random_tree(seed, 1 + seed % 5).text)
    compiled, M, h = world(scene)
    own_M, own_h, exact_M, exact_h = values([mass_matrix(compiled.motion), compiled.motion.h, M, h])
    assert own_M == pytest.approx(exact_M, rel=1e-12, abs=1e-12 * np.abs(exact_M).max())
    assert own_h == pytest.approx(exact_h, rel=1e-12, abs=1e-12 * np.abs(exact_h).max())


def test_springs_are_not_multiplied_out() -> None:
    """k (x - y)^2 would lose the digits of x - y."""
    _, flat = flatten_file(EXAMPLES / "suspended_bar.lag")
    kinematics, _ = reduce_kinematics(build_kinematics(build_graph(flat)))
    energies = build_energies(kinematics)
    weights, springs = split_weights(kinematics, energies.potential)
    assert {term.component for term in springs} == {"s1", "s2"}
    assert {term.component for term in weights} == {"bar"}
    assert find_bodies(kinematics, energies).inertias


def test_differences_of_parameters_are_not_multiplied_out() -> None:
    L = ca.SX.sym("L")
    harmonics = Harmonics(fixed={x.__hash__() for x in (K, L)})
    square, other, kept = harmonics.sums(ca.vertcat((L - K) ** 2 * X, (K - L) * (X - K / L * X), (K + L) ** 2 * X))
    assert [len(total) for total in (square, other, kept)] == [1, 1, 3]


@pytest.mark.parametrize("r", [0.9, 0.9999, 0.999999])
def test_a_disc_nearly_as_large_as_its_trough(r: float, tmp_path: Path) -> None:
    """It swings as a pendulum of the length 1.5 (R - r); I (1 - R/r)^2 multiplied out was 4e-4 off at the last."""
    scene = tmp_path / "trough.lag"
    scene.write_text("""model Trough
  parameter Length r = 0.1;
  RollingInTrough j(r = r, R = 1, base = world, alpha(start = 1.5, fixed = true)); Disc d(m = 1, r = r, center = j.center);
end Trough;""")
    at = np.linspace(0, 20 * np.sqrt(1 - r), 41)
    run = lag.load(scene).simulate(at=at, tolerance=1e-12, parameters={"r": r})
    assert np.abs(run["j.alpha"] - pendulum_angle(at, L=1.5 * (1 - r), phi0=1.5)).max() < 1e-12 + 1e-15 / (1 - r)


def test_a_slider_near_its_hinge_keeps_its_digits(tmp_path: Path) -> None:
    """(L - s)^2 multiplied out would lose those of L - s: 1764 steps and 5e-9 J, where 326 and 7e-13 J do."""
    (tmp_path / "scene.lag").write_text("""model Slide
  Revolute h(phi(start = 1.57)); Prismatic guide(along = {-1, 0}, s(start = 0.9));
  Body hub(m = 0, I = 1e-10); PointMass ball(m = 1);
equation
  connect(h.a, world); connect(hub.center, h.b); connect(guide.a, shift(h.b, {1, 1e-4})); connect(ball.center, guide.b);
initial equation
  guide.v = 0; h.w = 0.01;
end Slide;""", encoding="utf-8")
    run = lag.load(tmp_path / "scene.lag").simulate(stop=1, tolerance=1e-12, solver="erk")
    assert run.statistics.steps < 500
    assert np.abs(run.energy.residual).max() < 1e-11


def test_many_blocks_are_collected_one_by_one(tmp_path: Path) -> None:
    """Ten double pendulums joined by springs: the operations of ten, and of the springs."""
    (tmp_path / "scene.lag").write_text("""model Many
  Revolute h[10](each phi(start = 0.3)), k[10]; Spring s[9](each k = 10);
  Bar a[10](each m = 1, each L = 0.5), b[10](each m = 1, each L = 0.5);
equation
  for i in 1:10 loop
    connect(h[i].a, shift(world, {0.4*i, 0})); connect(a[i].a, h[i].b); connect(k[i].a, a[i].b); connect(b[i].a, k[i].b);
  end for;
  for i in 1:9 loop connect(s[i].a, b[i].b); connect(s[i].b, b[i+1].b); end for;
end Many;""", encoding="utf-8")
    compiled, M, h = world(tmp_path / "scene.lag")
    assert compiled.motion.way == "collected"
    own_M, own_h, exact_M, exact_h = values([mass_matrix(compiled.motion), compiled.motion.h, M, h])
    assert own_M == pytest.approx(exact_M, rel=1e-13, abs=1e-13 * np.abs(exact_M).max())
    assert own_h == pytest.approx(exact_h, rel=1e-12, abs=1e-12 * np.abs(exact_h).max())
