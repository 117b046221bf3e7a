"""Reactions against Newton and Euler: mass times acceleration of each body is the sum of the forces on it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np

import lagrangia as lag
from reference import Array

EXAMPLES = Path(__file__).resolve().parent.parent / "models" / "examples"
g = 9.81
Write = Callable[[str], lag.Model]


def cross(a: Array, b: Array) -> Array:
    return a[:, 0] * b[:, 1] - a[:, 1] * b[:, 0]


def assert_balance(
    run: lag.Trajectory, body: str, m: float, inertia: float, joints: dict[str, int], *, gravity: float = g, torque: float = 0.0
) -> None:
    """m a = F and I alpha = M about the centre. `joints` maps a joint to 1 where the body is on its side b, to -1 on side a."""
    place = run[f"{body}.center.r"]
    acceleration = np.stack([run[f"der(der({body}.center.{x}))"] for x in "xy"], axis=1)
    force = np.tile([0.0, -m * gravity], (len(place), 1))
    moment = np.full(len(place), torque)
    for joint, side in joints.items():
        pull = side * run[f"{joint}.reaction"]
        force += pull
        moment += cross(run[f"{joint}.b.r"] - place, pull) + side * run[f"{joint}.reaction_torque"]
    spin = inertia * run[f"der(der({body}.center.phi))"]
    np.testing.assert_allclose(force, m * acceleration, rtol=0, atol=1e-9 * max(1, np.abs(force).max(), np.abs(pull).max()))
    np.testing.assert_allclose(moment, spin, rtol=0, atol=1e-9 * max(1, np.abs(pull).max()))


def bar(m: float, L: float) -> tuple[float, float]:
    return m, m * L**2 / 12


def test_a_double_pendulum_with_a_spring_and_a_damper_in_its_joints(scene: Write) -> None:
    run = scene("""model M
      Revolute shoulder(a = world, phi(start = 0.5)), elbow(a = upper.b, phi(start = 1));
      Bar upper(m = 2, L = 1, a = shoulder.b), lower(m = 1, L = 0.7, a = elbow.b);
      TorsionSpring spring(k = 3, twist = shoulder.phi); TorsionDamper damper(c = 0.4, rate = elbow.w);
    end M;""").simulate(stop=1, interval=0.1, tolerance=1e-10)
    assert_balance(run, "upper", *bar(2, 1), {"shoulder": 1, "elbow": -1})
    assert_balance(run, "lower", *bar(1, 0.7), {"elbow": 1})
    np.testing.assert_allclose(run["shoulder.reaction_torque"], -3 * run["shoulder.phi"], atol=1e-10)
    np.testing.assert_allclose(run["elbow.reaction_torque"], -0.4 * run["elbow.w"], atol=1e-10)


def test_a_slider_crank() -> None:
    run = lag.load(EXAMPLES / "slider_crank.lag").simulate(interval=0.1, tolerance=1e-10)
    assert_balance(run, "crank", *bar(1, 0.1), {"O": 1, "pin": -1}, gravity=0, torque=0.5)
    assert_balance(run, "rod", *bar(0.5, 0.3), {"pin": 1, "wrist": -1}, gravity=0)
    push, guide = run["wrist.reaction"], run["guide.reaction"]
    np.testing.assert_allclose(push[:, 0], 2 * run["der(der(guide.s))"], atol=1e-9)
    np.testing.assert_allclose(push[:, 1] + guide[:, 1], 0, atol=1e-9)
    np.testing.assert_allclose(guide[:, 0], 0, atol=1e-9)


FOUR_BAR = """model M
  Revolute O(a = world, phi(start = 40[deg], fixed = true)), C(a = shift(world, {{1, 0}}), phi(start = 75[deg]));
  Revolute {joints};
  Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
  TorsionSpring s(k = 20, twist = A.phi), z(k = 10, twist = B.phi); TorsionDamper d(c = 0.3, rate = A.w);
end M;"""
HINGES = ["A(a = crank.b)", "B(a = coupler.b, b = rocker.b)"]


def test_it_does_not_matter_where_a_loop_is_cut(scene: Write) -> None:
    runs, cuts = [], []
    for joints in (HINGES, HINGES[::-1]):
        model = scene(FOUR_BAR.format(joints=", ".join(joints)))
        cuts.append(set(model.compilation.graph.cut_coordinates))
        runs.append(model.simulate(stop=1, interval=0.1, tolerance=1e-12))
    assert cuts == [{"B.phi"}, {"A.phi"}]
    for run in runs:
        assert_balance(run, "crank", *bar(1, 0.4), {"O": 1, "A": -1})
        assert_balance(run, "coupler", *bar(2, 1), {"A": 1, "B": -1})
        assert_balance(run, "rocker", *bar(1.5, 0.8), {"C": 1, "B": 1})
        np.testing.assert_allclose(run["A.reaction_torque"], -20 * run["A.phi"] - 0.3 * run["A.w"], atol=1e-8)
        np.testing.assert_allclose(run["B.reaction_torque"], -10 * run["B.phi"], atol=1e-8)
    for name in ("O.reaction", "A.reaction", "B.reaction", "C.reaction"):
        np.testing.assert_allclose(runs[0][name], runs[1][name], atol=1e-8)


def test_the_torque_of_a_prescribed_motion_is_that_of_inverse_dynamics(scene: Write) -> None:
    """m L^2/3 phi'' + m g L/2 cos phi, with phi = 0.3 sin 2 t; nothing is free to move."""
    run = scene("""model M
      Revolute hinge(a = world); Bar bar(m = 2, L = 0.5, a = hinge.b);
      Motion motor(of = hinge.phi, to = 0.3*sin(2[rad/s]*time));
    end M;""").simulate(stop=3, interval=0.1)
    t = run.time
    phi, acceleration = 0.3 * np.sin(2 * t), -1.2 * np.sin(2 * t)
    np.testing.assert_allclose(run["hinge.phi"], phi, atol=1e-12)
    torque = 2 * 0.5**2 / 3 * acceleration + 2 * g * 0.25 * np.cos(phi)
    np.testing.assert_allclose(run["hinge.reaction_torque"], torque, atol=1e-9)
    assert_balance(run, "bar", *bar(2, 0.5), {"hinge": 1})


def test_a_driven_loop() -> None:
    run = lag.load(EXAMPLES / "crank_press.lag").simulate(interval=0.001, tolerance=1e-10)
    assert_balance(run, "crank", *bar(5, 0.1), {"O": 1, "pin": -1})
    assert_balance(run, "rod", *bar(3, 0.4), {"pin": 1, "wrist": -1})
    power = run["O.reaction_torque"] * 10
    work = np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(run.time))
    assert np.ptp(work) > 1
    np.testing.assert_allclose(np.diff(run.energy.total).cumsum(), work, atol=1e-3 * np.ptp(work))
    np.testing.assert_allclose(np.diff(run.energy.work).cumsum(), work, atol=1e-3 * np.ptp(work))


def test_a_weld_carries_a_cantilever_with_a_pendulum_at_its_end(scene: Write) -> None:
    run = scene("""model M
      Weld wall(a = world, offset = {0.2, 0}); Bar beam(m = 3, L = 1, a = wall.b);
      Revolute hinge(a = beam.b, phi(start = -60[deg])); Bar hung(m = 1, L = 0.5, a = hinge.b);
    end M;""").simulate(stop=1, interval=0.1, tolerance=1e-10)
    assert_balance(run, "hung", *bar(1, 0.5), {"hinge": 1})
    assert_balance(run, "beam", *bar(3, 1), {"wall": 1, "hinge": -1})
    assert np.ptp(run["wall.reaction_torque"]) > 1


def test_a_slide_pushes_across_and_holds_against_turning(scene: Write) -> None:
    """m g cos of the slope across it, and m g cos times the overhang against tipping over."""
    slope, m, arm = np.radians(30), 2, 0.4
    run = scene("""model M
      Prismatic slide(a = turn(world, 30[deg]), along = {-2, 0}); PointMass lump(m = 2, center = shift(slide.b, {0.4, 0}));
    end M;""").simulate(stop=1, interval=0.25)
    across = np.array([-np.sin(slope), np.cos(slope)])
    np.testing.assert_allclose(run["slide.reaction"], np.tile(m * g * np.cos(slope) * across, (5, 1)), atol=1e-9)
    np.testing.assert_allclose(run["slide.reaction_torque"], m * g * np.cos(slope) * arm, atol=1e-9)


def test_an_arch_of_three_hinges_stands_still(scene: Write) -> None:
    """Two bars from the feet (0, 0) and (2, 0) to the apex (1, h), and a load P on it: statics."""
    h, m, P = 0.75, 4, 100
    run = scene("""model M
      Revolute left(a = world, phi(start = 40[deg])), right(a = shift(world, {2, 0}), phi(start = 140[deg]));
      Revolute apex(a = l.b, b = r.b);
      Bar l(m = 4, L = 1.25, a = left.b), r(m = 4, L = 1.25, a = right.b);
      AppliedForce load(at = l.b, force = {0, -100});
    end M;""").simulate(stop=1, interval=0.5)
    up = m * g + P / 2
    thrust = (up - m * g / 2) / h
    np.testing.assert_allclose(run["left.reaction"], [[thrust, up]] * 3, rtol=1e-9)
    np.testing.assert_allclose(run["right.reaction"], [[-thrust, up]] * 3, rtol=1e-9)
    np.testing.assert_allclose(run["apex.reaction"], [[thrust, -P / 2]] * 3, rtol=1e-9)
    np.testing.assert_allclose(run["apex.b.y"], h, rtol=1e-12)


def test_declared_outputs_and_units(scene: Write) -> None:
    model = scene("""model M Revolute hinge(a = world); Bar bar(m = 1, L = 1, a = hinge.b);
      output Force F[2] = hinge.reaction; output Torque M = hinge.reaction_torque; end M;""")
    run = model.simulate(stop=0.1)
    np.testing.assert_allclose(run["F"][0], [0, g / 4], atol=1e-9)
    assert [column.unit for column in model.scene.outputs] == ["N", "N", "N.m"]
    F = model.functions()["outputs"](0, 0, 0, [], model.parameter_values())
    np.testing.assert_allclose(np.array(F).ravel(), [0, g / 4, 0], atol=1e-9)


def test_a_motion_keeps_its_hinge_in_the_tree(scene: Write) -> None:
    """The hinge that a loop would be cut at is prescribed: it stays, its torque is the only one, and it does the work."""
    run = scene("""model M
      Revolute O(a = world, phi(start = 40[deg])), A(a = crank.b), B(a = coupler.b, b = rocker.b),
               C(a = shift(world, {1, 0}), phi(start = 75[deg]));
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
      Motion motor(of = B.phi, to = 0.82 + 0.1*sin(2[rad/s]*time));
    end M;""").simulate(stop=2, interval=0.001, tolerance=1e-10)
    for hinge in "OAC":
        np.testing.assert_allclose(run[f"{hinge}.reaction_torque"], 0, atol=1e-9)
    power = run["B.reaction_torque"] * run["der(B.phi)"]
    work = np.cumsum((power[1:] + power[:-1]) / 2 * np.diff(run.time))
    np.testing.assert_allclose(np.diff(run.energy.work).cumsum(), work, atol=1e-4 * np.ptp(work))
