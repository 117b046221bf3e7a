"""Reactions against Newton and Euler: mass times acceleration of each body is the sum of the forces on it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.random_loops import random_loops
from helpers.reference import Array

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
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


GENEVA = """model Geneva
  parameter Length r = 0.1; parameter Real c = sqrt(2);
  World world(gravity = {{0, 0}});
  Revolute crank(a = world), wheel(a = shift(world, {{c*r, 0}}));
  Body load(m = 1, I = 0.02, center = wheel.b), fly(m = 1, I = 0.001, center = crank.b);
  Angle alpha = crank.phi; {drive}
  wheel.phi = if abs(alpha) < pi/4 then -atan2(sin(alpha), c - cos(alpha)) else -sign(alpha)*pi/4;
end Geneva;"""


@pytest.mark.parametrize(("drive", "name"), [("Motion motor(of = crank.phi, to = 4*time - 2); equation", "motor.reaction"),
                                             ("Torque M = constraint_force(crank.phi); equation crank.phi = 4*time - 2;", "M"),
                                             ("Torque M = -constraint_force(crank.phi); equation 4*time - 2 = crank.phi;", "M")])
def test_what_a_motion_takes_is_told_by_its_equation(drive: str, name: str, scene: Write) -> None:
    """I b'' b' of the wheel: the joint has the force of the drive alone, as has the drive."""
    at = np.array([0.31, 0.4, 0.5, 0.55, 0.6])
    a, c, h = 4 * at - 2, np.sqrt(2), 1e-4

    def rate(a: Array) -> Array:
        return 4 * (1 - c * np.cos(a)) / (3 - 2 * c * np.cos(a))  # atan2(sin a, c - cos a), of a = 4 t - 2

    accelerated = 4 * (rate(a - 2 * h) - 8 * rate(a - h) + 8 * rate(a + h) - rate(a + 2 * h)) / (12 * h)
    run = scene(GENEVA.format(drive=drive)).simulate(at=[0.0, *at], tolerance=1e-9)
    sign = -1 if "4*time - 2 = crank" in drive else 1
    np.testing.assert_allclose(sign * run[name][1:], 0.02 * accelerated * rate(a) / 4, rtol=1e-9)
    np.testing.assert_allclose(sign * run[name], run["crank.reaction_torque"], atol=1e-9)


def test_the_power_of_motions_is_what_energies_gain(scene: Write) -> None:
    """A cart on a moving slide with a pendulum that is driven as well, a spring and a damper: force and torque are exact."""
    run = scene("""model M
      Prismatic slide(a = world, along = {1, 0}), height(a = slide.b, along = {0, 1});
      Revolute hinge(a = height.b), free(a = rod.b, phi(start = 0.3));
      Bar rod(m = 2, L = 0.5, a = hinge.b), last(m = 1, L = 0.4, a = free.b);
      Spring s(k = 300, a = world, b = last.b); TorsionDamper d(c = 0.3, rate = free.w);
      Motion along(of = slide.s, to = 0.2*sin(3*time)), up(of = height.s, to = 0.1*time^2);
      Motion turn(of = hinge.phi, to = 0.5*cos(2*time));
    end M;""").simulate(stop=2, interval=0.001, tolerance=1e-11)
    t = run.time
    power = run["along.reaction"] * 0.6 * np.cos(3 * t) + run["up.reaction"] * 0.2 * t - run["turn.reaction"] * np.sin(2 * t)
    stored = run.energy.kinetic + run.energy.potential
    weights = np.array([1, -9, 45, 0, -45, 9, -1]) / 0.06  # of the slope in the middle of seven rows
    gained = np.convolve(stored, weights, "valid") + 0.3 * run["free.w"][3:-3] ** 2
    assert np.abs(power).max() > 5
    np.testing.assert_allclose(gained, power[3:-3], rtol=0, atol=1e-7 * np.abs(power).max())  # of differences


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


BEAM = "Bar beam(m = 20, L = 4); Revolute pin(a = world, b = beam.a);"
LOAD = "AppliedForce P(at = beam.b, force = {0, -100*sin(3*time)});"
RESTING = {
    "its weight alone": (BEAM + "PointOnLine r(line = world, point = beam.b);",
                         {"pin": lambda P: 98.1 + P, "r": lambda P: 98.1 + P}),
    "a metre up": (BEAM.replace("world", "shift(world, {0, 1})") + "PointOnLine r(line = shift(world, {0, 1}), point = beam.b);",
                   {"pin": lambda P: 98.1 + P, "r": lambda P: 98.1 + P}),
    "a load beyond": (BEAM + LOAD + "PointOnLine r(line = world, point = shift(beam.center, {1, 0}));",
                      {"pin": lambda P: 196.2 / 3 - P / 3, "r": lambda P: 196.2 * 2 / 3 + P * 4 / 3}),
    "free to slide": ("Bar beam(m = 20, L = 4); PointOnLine r(line = world, point = beam.a), r2(line = world, point = beam.b);",
                      {"r": lambda P: 98.1 + P, "r2": lambda P: 98.1 + P}),
    "redundant": (BEAM + LOAD + "PointOnLine r(line = world, point = beam.b), r2(line = world, point = beam.center);",
                  {"pin r r2": lambda P: 196.2 + P}),
}


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "implicit"])
@pytest.mark.parametrize("case", RESTING)
def test_what_rests_where_its_coordinates_are_zero_rests_in_a_few_steps(case: str, solver: str, scene: Write) -> None:
    """Nothing moves it but rounding, of accelerations of 1e-17: there is no motion that tells how large that is."""
    text, reactions = RESTING[case]
    model = scene(f"model M {text} end M;")
    for tolerance in (1e-3, 1e-8, 1e-12):
        run = model.simulate(stop=10, interval=0.1, tolerance=tolerance, solver=solver)
        assert run.statistics.steps + run.statistics.rejected < 200
        P = 100 * np.sin(3 * run.time) if LOAD in text else 0 * run.time
        for names, wanted in reactions.items():
            found = sum(run[f"{name}.reaction"][:, 1] for name in names.split())
            np.testing.assert_allclose(found, wanted(P), rtol=1e-9)


TRUSS = """model M
  Bar b1(m = {m}, I = 0, L = 5), b2(m = {m}, I = 0, L = 5);
  Revolute A(a = world, b = b1.a, phi(start = 53[deg])), B(a = shift(world, {{6, 0}}), b = b2.b, phi(start = -53[deg]));
  Revolute C(a = b1.b, b = b2.a);
  AppliedForce P(at = b1.b, force = {{100, -200}});
end M;"""


@pytest.mark.parametrize("declared", [0, 1e-9, 1])
def test_a_truss_of_bars_without_mass(declared: float, scene: Write) -> None:
    """By hand: the load at the top of two bars of slopes 4/3 and -4/3."""
    model = scene(TRUSS.format(m=declared))
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(stop=5, interval=0.5, solver=solver, parameters={"b1.m": 0.0, "b2.m": 0.0})
        assert run.statistics.steps < 100
        np.testing.assert_allclose(run["A.reaction"], [[25, 100 / 3]] * 11, rtol=1e-9)
        np.testing.assert_allclose(run["B.reaction"], [[-125, 500 / 3]] * 11, rtol=1e-9)


def test_a_cantilever_has_no_coordinate_but_a_reaction(scene: Write) -> None:
    """m g + P and m g L/2 + P L in the wall, with a load P = 50 t."""
    m, L = 2, 1.5
    model = scene("""model M
      Weld wall(a = world); Bar beam(m = 2, L = 1.5, a = wall.b);
      AppliedForce load(at = beam.b, force = {0, -50[N/s]*time});
    end M;""")
    assert model.coordinate_names == ()
    assert (model.freedom["degrees_of_freedom"], model.scene.notes["is_driven"]) == (0, False)
    run = model.simulate(at=[0, 0.3, 2])
    P = 50 * run.time
    np.testing.assert_allclose(run["wall.reaction"], np.stack([0 * P, m * g + P], axis=1), atol=1e-12)
    np.testing.assert_allclose(run["wall.reaction_torque"], m * g * L / 2 + P * L, rtol=1e-14)


def test_a_prescribed_support_is_no_statics(scene: Write) -> None:
    run = scene("""model M
      Weld arm(a = turn(world, 3[rad/s]*time)); PointMass ball(m = 2, center = shift(arm.b, {0.5, 0}));
      World world(gravity = {0, 0});
    end M;""")
    assert run.scene.notes["is_driven"]
    assert np.hypot(*run.simulate(at=[0, 0.5, 1])["arm.reaction"].T) == pytest.approx([2 * 0.5 * 9] * 3)


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


# ---------------------------------------------------------------- ties


@pytest.mark.parametrize("seed", range(4))
def test_every_body_of_a_random_mechanism_is_in_balance(seed: int, scene: Write) -> None:
    """Loops of bars, links, a gear and a belt: rows with multipliers and rows that gave a coordinate, all at once."""
    made = random_loops(seed, 2 + seed % 2)
    model = scene(made.text)
    assert model.scene.sizes["n_multipliers"] > 0
    assert len(model.scene.notes["dependent"]) == 3
    run = model.simulate(stop=0.5, interval=0.1, tolerance=1e-11)
    for body in made.bodies:
        assert_balance(run, body.name, body.m, body.I, body.held)


def wheels(tie: str, place: str) -> str:
    return f"""model M
      Revolute left(a = world), right(a = shift(world, {place}));
      Disc small(m = 1, r = 0.1, center = left.b), large(m = 2, r = 0.2, center = right.b);
      {tie} tie(r_a = 0.1, r_b = 0.2, a = left.b, b = right.b, carrier = world);
      AppliedTorque drive(on = small.center, torque = 2);
    end M;"""


def test_bearings_carry_the_tooth_force(scene: Write) -> None:
    """F = I_b alpha_b/r_b with alpha_a = torque/(I_a + I_b r_a^2/r_b^2): it turns the large wheel and lies on both bearings."""
    run = scene(wheels("Gear", "{0, 0.3}")).simulate(stop=1, interval=0.5)
    inertia, other = 1 * 0.1**2 / 2, 2 * 0.2**2 / 2
    tooth = other * (2 / (inertia + other / 4)) / 2 / 0.2
    np.testing.assert_allclose(run["tie.reaction"], [[-tooth, 0]] * 3, atol=1e-10)
    np.testing.assert_allclose(run["tie.reaction_torque"], -tooth * 0.2, atol=1e-10)
    np.testing.assert_allclose(run["left.reaction"], [[-tooth, 1 * g]] * 3, atol=1e-10)
    np.testing.assert_allclose(run["right.reaction"], [[tooth, 2 * g]] * 3, atol=1e-10)


def test_bearings_carry_the_slanting_strands_of_a_belt(scene: Write) -> None:
    """The strands slant by sin psi = (r_a - r_b)/d: so much of the difference of their tensions lies across the axles' line."""
    run = scene(wheels("Belt", "{0.5, 0}")).simulate(stop=1, interval=0.5)
    inertia, other = 1 * 0.1**2 / 2, 2 * 0.2**2 / 2
    difference = other * (2 / (inertia + other / 4)) / 2 / 0.2
    across = difference * (0.1 - 0.2) / 0.5
    np.testing.assert_allclose(run["tie.reaction_torque"], difference * 0.2, atol=1e-10)
    np.testing.assert_allclose(run["tie.reaction"], [[0, across]] * 3, atol=1e-10)
    np.testing.assert_allclose(run["right.reaction"], [[0, 2 * g - across]] * 3, atol=1e-10)


def test_wheels_on_one_axle_have_no_tooth_force_but_a_torque(scene: Write) -> None:
    run = scene(wheels("Gear", "{0, 0}")).simulate(stop=1, interval=0.5)
    np.testing.assert_allclose(run["right.reaction"], [[0, 2 * g]] * 3, atol=1e-10)
    assert np.abs(run["tie.reaction_torque"]).min() > 1


def test_a_planet_hangs_on_its_carrier(scene: Write) -> None:
    """A sun held still, a planet on an arm: Newton and Euler for planet and arm, the tooth force a reaction of the gear."""
    run = scene("""model M
      Revolute axle(a = world, phi(start = 0.3)), pin(a = arm.b);
      Bar arm(m = 1, L = 0.3, a = axle.b); Disc planet(m = 2, r = 0.2, center = pin.b);
      Gear gear(r_a = 0.1, r_b = 0.2, a = world, b = planet.center, carrier = arm.center);
    end M;""").simulate(stop=1, interval=0.1, tolerance=1e-10)
    assert_balance(run, "arm", *bar(1, 0.3), {"axle": 1, "pin": -1})
    assert_balance(run, "planet", 2, 2 * 0.2**2 / 2, {"pin": 1, "gear": 1})
    np.testing.assert_allclose(run["axle.reaction_torque"], 0, atol=1e-10)
    np.testing.assert_allclose(run["pin.reaction_torque"], 0, atol=1e-10)
    along = np.stack([np.cos(run["axle.phi"]), np.sin(run["axle.phi"])], axis=1)
    np.testing.assert_allclose((run["gear.reaction"] * along).sum(axis=1), 0, atol=1e-10)


def test_friction_holds_a_rolling_disc_back(scene: Write) -> None:
    """On a slope a disc needs the friction m g sin/3, and m g cos from below."""
    m, slope = 2, np.radians(30)
    run = scene("""model M
      Rolling wheel(r = 0.1, base = turn(world, -30[deg])); Disc disc(m = 2, r = 0.1, center = wheel.center);
    end M;""").simulate(stop=1, interval=0.5)
    down, up = np.array([np.cos(slope), -np.sin(slope)]), np.array([np.sin(slope), np.cos(slope)])
    friction = m * g * np.sin(slope) / 3
    np.testing.assert_allclose(run["wheel.reaction"], [m * g * np.cos(slope) * up - friction * down] * 3, atol=1e-10)
    np.testing.assert_allclose(run["wheel.reaction_torque"], -friction * 0.1, atol=1e-10)


def test_a_link_pulls_along_itself(scene: Write) -> None:
    """The tension of a pendulum's thread: m g cos + m v^2/L."""
    run = scene("""model M
      PointMass ball(m = 2, center(x(start = 0.6), y(start = -0.8))); Link rod(L = 1, a = world, b = ball.center);
      output Force F[2] = rod.reaction;
    end M;""").simulate(stop=1, interval=0.1, tolerance=1e-11)
    r, v = run["ball.center.r"], run["ball.center.v"]
    tension = 2 * (-g * r[:, 1] + (v**2).sum(axis=1))
    np.testing.assert_allclose(run["F"], -tension[:, None] * r, atol=1e-8)


# ---------------------------------------------------------------- rows that gave a coordinate, welds, other inertias


def test_a_slider_whose_equations_gave_coordinates(scene: Write) -> None:
    """Two sliders carry a mass along a third one at 45 degrees, which bears m g cos 45."""
    run = scene("""model M
      Prismatic flat(a = world), steep(a = flat.b, along = {0, 1}), slanting(a = world, b = steep.b, along = {1, 1});
      PointMass block(m = 1, center = steep.b);
    end M;""").simulate(stop=1, interval=0.5)
    np.testing.assert_allclose(run["slanting.reaction"], [[-g / 2, g / 2]] * 3, atol=1e-10)
    np.testing.assert_allclose(run["flat.reaction"], 0, atol=1e-10)


SLOT = """model Slot "Slider and hinge in one"
  Frame a, b; coordinate Length s; coordinate Angle phi;
equation
  b = turn(shift(a, {s, 0.1}), phi);
end Slot;
"""


def test_a_joint_that_closes_its_loop_as_a_whole(scene: Write) -> None:
    """A rod between two slots: the one with a spring on its coordinate is cut with both coordinates, which stay."""
    model = scene(SLOT + """model M
      Slot one(a = world, s(start = -0.5), phi(start = 0.5)), two(a = turn(world, 90[deg]), b = rod, s(start = 0.5));
      Frame rod = shift(one.b, {1, 0});
      Body lump(m = 2, I = 0.3, center = shift(one.b, {0.5, 0})); Spring spring(k = 5, stretch = two.s);
    end M;""")
    assert [cut.kind for cut in model.compilation.graph.closures] == ["weld"]
    run = model.simulate(stop=1, interval=0.1, tolerance=1e-11)
    assert_balance(run, "lump", 2, 0.3, {"one": 1, "two": 1})
    np.testing.assert_allclose(run["two.reaction"][:, 1], -5 * run["two.s"], atol=1e-8)
    np.testing.assert_allclose(run["two.reaction_torque"], 0, atol=1e-8)


def test_a_second_weld_carries_nothing(scene: Write) -> None:
    run = scene("""model M
      Weld left(a = world), right(a = shift(world, {1, 0}), b = beam.b); Bar beam(m = 2, L = 1, a = left.b);
      Revolute hinge(a = beam.center); Bar hung(m = 1, L = 1, a = hinge.b);
    end M;""").simulate(stop=1, interval=0.5)
    assert_balance(run, "beam", *bar(2, 1), {"left": 1, "right": 1, "hinge": -1})
    np.testing.assert_allclose(run["right.reaction"], 0, atol=1e-12)


def test_reactions_beside_a_geared_rotor(scene: Write) -> None:
    """A rotor that turns with 3 phi_1 - phi_2 asks the hinges for the torques of its own Lagrange terms."""
    run = scene("""model Rotor "Turns with a difference of two angles"
      parameter Inertia I; Angle of;
    energy
      kinetic I*der(of)^2/2;
    end Rotor;
    model M
      Revolute hinge(a = world), elbow(a = upper.b, phi(start = 0.5));
      Bar upper(m = 1, L = 1, a = hinge.b), lower(m = 1, L = 1, a = elbow.b);
      Rotor rotor(I = 1, of = 3*hinge.phi - elbow.phi);
    end M;""").simulate(stop=1, interval=0.1, tolerance=1e-11)
    assert_balance(run, "upper", *bar(1, 1), {"hinge": 1, "elbow": -1})
    assert_balance(run, "lower", *bar(1, 1), {"elbow": 1})
    spin = 3 * run["der(der(hinge.phi))"] - run["der(der(elbow.phi))"]
    np.testing.assert_allclose(run["hinge.reaction_torque"], -3 * spin, atol=1e-8)
    np.testing.assert_allclose(run["elbow.reaction_torque"], spin, atol=1e-8)


def test_reactions_beside_a_kinetic_energy_of_two_bodies(scene: Write) -> None:
    """T = m |v_1 + v_2|^2/8 is that of a mass m half way between two points: reactions as with the mass itself on a bar."""
    text = """model Between "A mass half way between two points"
      parameter Mass m; Frame a, b;
    energy
      kinetic m*dot(a.v + b.v, a.v + b.v)/8;
      potential -m*dot(world.gravity, a.r + b.r)/2;
    end Between;
    model M
      Revolute hinge(a = world, phi(start = 0.3)), elbow(a = upper.b, phi(start = 0.5));
      Bar upper(m = 1, L = 1, a = hinge.b), lower(m = 1, L = 1, a = elbow.b);
      {};
    end M;"""
    runs = [scene(text.format(lump)).simulate(stop=1, interval=0.1, tolerance=1e-11) for lump in
            ("Between lump(m = 2, a = lower.a, b = lower.b)", "PointMass lump(m = 2, center = lower.center)")]
    for joint in ("hinge", "elbow"):
        np.testing.assert_allclose(runs[0][f"{joint}.reaction"], runs[1][f"{joint}.reaction"], atol=1e-7)


def test_a_block_and_a_slide_tell_the_same_reaction(scene: Write) -> None:
    """What carries them pushes up against the weight."""
    model = scene("model M Block b(m = 2, base = world); Prismatic s(a = world); PointMass p(m = 2, center = s.b); "
                  "output Force B[2] = b.reaction; output Force S[2] = s.reaction; end M;")
    run = model.simulate(stop=0.1)
    assert (run["B[1]"][-1], run["B[2]"][-1]) == (run["S[1]"][-1], run["S[2]"][-1]) == (0.0, pytest.approx(2 * 9.81, rel=1e-14))
