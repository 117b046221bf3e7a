"""Coordinates that are held or prescribed, however that is written, and the forces that it takes."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]

# ---------------------------------------------------------------- coordinates of free bodies

PENDULUM = "Revolute h(a = A.b, phi(start = 0.4)); Bar c(m = 1, L = 0.7, a = h.b);"
HELD = {
    "x": "{x} = 0;",
    "angle in time": "{phi} = 0.3*sin(2[rad/s]*time);",
    "x and y": "{x} = 0.1*sin(3[rad/s]*time); {y} = 0.2[m/s]*time;",
    "all": "{x} = 0.1*sin(3[rad/s]*time); {y} = 0; {phi} = 1[rad/s]*time;",
}


@pytest.mark.parametrize("case", HELD)
def test_a_free_body_is_held_as_one_on_a_joint_of_three_freedoms(case: str, scene: Write) -> None:
    free = scene(f"model M Bar A(m = 2, L = 1); {PENDULUM} equation "
                 f"{HELD[case].format(x='A.center.x', y='A.center.y', phi='A.center.phi')} end M;")
    joined = scene(f"model M Planar p(a = world); Bar A(m = 2, L = 1, center = p.b); {PENDULUM} equation "
                   f"{HELD[case].format(x='p.x', y='p.y', phi='p.phi')} end M;")
    found, right = (model.simulate(stop=1, interval=0.25, tolerance=1e-11) for model in (free, joined))
    for name in ("x", "y", "phi"):
        np.testing.assert_allclose(found[f"A.center.{name}"], right[f"p.{name}"], atol=1e-10)
    np.testing.assert_allclose(found["h.phi"], right["h.phi"], atol=1e-10)


def test_a_mass_falls_along_the_line_it_is_held_on(scene: Write) -> None:
    model = scene("model M PointMass A(m = 2); equation A.center.x = 0; end M;")
    assert model.freedom["degrees_of_freedom"] == 1
    assert model.simulate(stop=1)["A.center.y"][-1] == pytest.approx(-4.905, abs=1e-14)


# ---------------------------------------------------------------- the torque that it takes

GENEVA = ("World world(gravity = {{0, 0}}); Revolute crank(a = world), wheel(a = shift(world, {{0.1*sqrt(2), 0}})); "
          "Body load(m = 1, I = 0.02, center = wheel.b), fly(m = 1, I = 0.001, center = crank.b); {drive} "
          "Angle alpha = {angle}; equation {more} {wheel} = -atan2(sin(alpha), sqrt(2) - cos(alpha));")
DRIVES = {
    "Motion": {"drive": "Motion motor(of = crank.phi, to = 4[rad/s]*time - 0.5);", "more": "", "angle": "crank.phi",
               "wheel": "wheel.phi"},
    "an equation": {"drive": "", "more": "crank.phi = 4[rad/s]*time - 0.5;", "angle": "crank.phi", "wheel": "wheel.phi"},
    "after the tie": {"drive": "Motion motor(of = 4[rad/s]*time - 0.5, to = crank.phi);", "more": "", "angle": "crank.phi",
                      "wheel": "wheel.phi"},
    "with frames": {"drive": "Motion motor(of = crank.phi, to = 4[rad/s]*time - 0.5);", "more": "", "angle": "crank.b.phi",
                    "wheel": "wheel.b.phi"},
}


def _geneva_torque(alpha: np.ndarray) -> np.ndarray:
    """I b'' b' 16 with b = -atan2(sin a, sqrt 2 - cos a): tan b = s/(c - k), b' = (c k - 1)/(3 - 2 c k), all by hand."""
    k, root = np.cos(alpha), np.sqrt(2)
    first = -(root * k - 1) / (3 - 2 * root * k)
    second = root * np.sin(alpha) / (3 - 2 * root * k) ** 2
    return 0.02 * 16 * first * second


@pytest.mark.parametrize("case", DRIVES)
def test_the_drive_of_a_geneva_wheel_has_a_torque_however_it_is_written(case: str, scene: Write) -> None:
    model = scene(f"model M {GENEVA.format(**DRIVES[case])} output Torque tau = crank.reaction_torque; "
                  "output Torque other = wheel.reaction_torque; end M;")
    run = model.simulate(stop=0.25, interval=0.05, tolerance=1e-10)
    np.testing.assert_allclose(run["tau"], _geneva_torque(4 * run.time - 0.5), rtol=1e-9, atol=1e-12)


def test_the_force_of_a_driven_slide_is_that_of_its_load(scene: Write) -> None:
    """A slide moved as x = 0.1 sin 3t carries a tied block of twice its travel: F = (1 + 2^2 2) x''."""
    model = scene("model M World world(gravity = {0, 0}); Prismatic s(a = world, along = {0, 2}); "
                  "PointMass p(m = 1, center = s.b); Block b(m = 2, base = world); "
                  "equation b.s = 2*s.s; s.s = 0.1*sin(3[rad/s]*time); "
                  "output Force F[2] = s.reaction; end M;")
    run = model.simulate(stop=1, interval=0.1, tolerance=1e-11)
    np.testing.assert_allclose(run["F[2]"], -9 * 0.9 * np.sin(3 * run.time), atol=1e-10)
    np.testing.assert_allclose(run["F[1]"], 0, atol=1e-13)


GIVEN = {
    "bound": "Motion motor(of = b.s, to = {to}); equation",
    "by equations": "Motion motor; equation motor.of = b.s; motor.to = {to};",
    "the other way round": "Motion motor; equation b.s = motor.of; {to} = motor.to;",
    "one bound": "Motion motor(of = b.s); equation motor.to = {to};",
    "the other bound": "Motion motor(to = {to}); equation motor.of = b.s;",
    "the other side": "Motion motor(to = b.s); equation motor.of = {to};",
}


@pytest.mark.parametrize("case", GIVEN)
def test_a_motion_tells_its_force_however_its_parts_are_given(case: str, scene: Write) -> None:
    """Equations for its parts had the sign turned round, in loops over arrays too, or were refused."""
    model = scene("model M World world(gravity = {0, 0}); Block b(m = 2, base = world), c(m = 3, base = world); "
                  f"output Force F = motor.reaction, same = constraint_force(b.s); {GIVEN[case].format(to='1[m/s2]*time^2')} "
                  "c.s = 0; end M;")
    run = model.simulate(at=[0, 0.5])
    assert [*run["F"], *run["same"]] == pytest.approx([4, 4, 4, 4], abs=1e-12)


def test_a_motion_that_another_body_gives_tells_the_force_on_what_it_moves(scene: Write) -> None:
    """7 N on c, whose half b goes: c'' = 7/(3 + 2/4) = 2 m/s2, and the force on b is 2 kg 1 m/s2."""
    model = scene("model M World world(gravity = {0, 0}); Block b(m = 2, base = world), c(m = 3, base = world, along = {0, 1}); "
                  "Motion tie[1]; "
                  "AppliedForce P(at = c.center, force = {0, 7}); output Force F = tie[1].reaction; "
                  "equation tie[1].to = 0.5*c.s; tie[1].of = b.s; end M;")
    assert model.simulate(at=[0, 0.5])["F"] == pytest.approx([2, 2], abs=1e-12)


def test_the_force_of_what_follows_time_alone_is_that_on_what_it_moves(scene: Write) -> None:
    model = scene("model M World world(gravity = {0, 0}); Block b(m = 2, base = world); Length x; "
                  "output Force F = constraint_force(x); "
                  "equation x = 1[m/s2]*time^2; x = b.s; end M;")
    assert model.simulate(at=[0, 0.5])["F"] == pytest.approx([4, 4], abs=1e-12)


DRIVEN = """model M
  {world}
  Revolute crank(a = world), wheel(a = shift(world, {{0.5, 0}}));
  Prismatic slide(a = crank.b, along = {{1, 0.5}}), rider(a = slide.b, along = {{0, 1}});
  Body fly(m = 1, I = {I}, center = shift(crank.b, {{0.1, 0}})), load(m = 1, I = {I}, center = wheel.b),
    a(m = 1, I = {I}, center = slide.b), b(m = 1, I = {I}, center = rider.b);
  output Force F[2] = {{crank.reaction[1], slide.reaction[2]}};
  output Torque T[2] = {{crank.reaction_torque{z}, wheel.reaction_torque{z}}};
equation
  crank.phi = 4[rad/s]*time - 0.5;
  wheel.phi = sin(crank.phi) + crank.phi^2/2;
  slide.s = 2[m/s]*time;
  rider.s = 0.1[m]*sin(slide.s/1[m]);
end M;"""


def test_driven_joints_in_space_have_the_reactions_of_the_plane(scene: Write) -> None:
    """Where a drive's coordinate is tied to others, too: gravity that points out of the plane adds nothing in it."""
    plane = scene(DRIVEN.format(world="", I="0.02", z=""))
    space = scene(DRIVEN.format(world="World world(gravity = {0, -9.81, 3});", I="{0.02, 0.02, 0.02}", z="[3]"))
    runs = [model.simulate(at=[0.1, 0.3], tolerance=1e-11) for model in (plane, space)]
    for name in ("F", "T"):
        np.testing.assert_allclose(runs[1][name], runs[0][name], rtol=0, atol=1e-9)


def test_a_pendulum_on_a_driven_shaft_rests_in_its_frame(scene: Write) -> None:
    """cos(phi) = g/(w^2 l); the bearing holds the ball on its circle: m w^2 r and m g."""
    model = scene("""model M
      parameter AngularVelocity w = 6;
      World world(gravity = {0, 0, -9.81});
      Revolute shaft(a = world, axis = {0, 0, 1}), swing(a = shaft.b, axis = {0, 1, 0}, phi(start = -1));
      PointMass ball(m = 1, center = shift(swing.b, {0, 0, -0.5}));
    equation
      shaft.phi = w*time;
    end M;""")
    (rest,) = model.equilibrium(starts=1).found
    phi = rest.position["swing.phi"]
    assert np.cos(phi) == pytest.approx(9.81 / 36 / 0.5, abs=1e-12)
    assert rest.reactions["shaft.reaction[1]"] == pytest.approx(36 * 0.5 * np.sin(phi), abs=1e-11)
    assert rest.reactions["shaft.reaction[3]"] == pytest.approx(9.81, abs=1e-12)
