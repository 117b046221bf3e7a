"""Runs that begin in steady motion stay in it."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

GOVERNOR = """model Governor "A ball on a turning arm, held by a spring, and the lag of what measures it"
  parameter Mass m = 0.5; parameter Stiffness k = 200; parameter Length l = 0.2;
  World world(gravity = {0, 0});
  Revolute hinge(a = world); Disc hub(m = 1, r = 0.1, center = hinge.b);
  Prismatic arm(a = hinge.b, along = {1, 0}, s(start = 0.25)); PointMass ball(m = m, center = arm.b);
  Spring s(k = k, stretch = arm.s - l);
  FirstOrder seen(T = 0.1, u = arm.s/1[m]);
  annotation(experiment(StopTime = 1, Tolerance = 1e-11));
end Governor;"""
FLYBALLS = """model Watt "Flyballs: m l^2 w^2 sin cos = (m + M) g l sin at constant spin, as a ring of inertia of its own"
  parameter Mass m = 0.5, M = 2; parameter Length l = 0.3; parameter Inertia J = 0.1; parameter Acceleration g = 9.81;
  coordinate Angle spin; coordinate Angle theta(start = 40[deg]);
  energy
    kinetic J*der(spin)^2/2 + m*(l^2*der(theta)^2 + (der(spin)*l*sin(theta))^2);
    kinetic M*(2*l*sin(theta)*der(theta))^2/2;
    potential -2*(m + M)*g*l*cos(theta);
  annotation(experiment(StopTime = 1, Tolerance = 1e-11));
end Watt;"""


def test_a_ball_stays_where_its_spring_holds_it() -> None:
    """k (s - l) = m w^2 s."""
    run = lag.loads(GOVERNOR).simulate(at=np.linspace(0, 1, 11), from_={"hinge.w": 8.0})
    s = 200 * 0.2 / (200 - 0.5 * 64)
    assert np.abs(np.array(run["arm.s"]) - s).max() < 1e-11 and np.abs(np.array(run["seen.y"]) - s).max() < 1e-11
    assert np.abs(np.array(run["hinge.w"]) - 8).max() < 1e-11


def test_flyballs_rise_with_the_speed() -> None:
    """cos(theta) = (m + M) g/(m l w^2)."""
    model = lag.loads(FLYBALLS)
    for w in (20.0, 30.0):
        run = model.simulate(at=[0.0, 1.0], from_="steady", initial={"der(spin)": w})
        assert np.abs(np.array(run["theta"]) - np.arccos(2.5 * 9.81 / (0.5 * 0.3 * w**2))).max() < 1e-10


def test_the_command_line_says_where_it_begins(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "scene.lag").write_text(GOVERNOR)
    command = ["simulate", str(tmp_path / "scene.lag"), "-o", str(tmp_path / "rows.csv"), "--from"]
    assert main([*command, "steady hinge.w=8"]) == 0
    assert "starts in steady motion: der(hinge.phi) = 8, arm.s = 0.238095" in capsys.readouterr().err
    assert main([*command, "steady hinge.x=8"]) == 2
    assert main([*command, "equilibrium hinge.w=8"]) == 2


@pytest.mark.parametrize(("text", "rates", "said"), [
    ("AppliedTorque t(on = hub.center, torque = 1);", {"hinge.w": 8.0}, r"hinge.phi is accelerated \(.*has to drive it"),
    ("AxialSpring more(a = world, b = ball.center, k = 5, along = {1, 0});", {"hinge.w": 8.0}, "depend on the positions"),
    ("AppliedForce f(at = ball.center, force = {1[N]*sin(9*time), 0});", {"hinge.w": 8.0}, "is accelerated|depend on"),
    ("", {"arm.v": 1.0}, "arm.s is accelerated"),
])
def test_what_is_no_steady_motion_is_told(text: str, rates: dict[str, float], said: str) -> None:
    with pytest.raises(lag.RunError, match=f"no such steady motion.*({said})"):
        lag.loads(GOVERNOR.replace("  annotation", f"  {text}\n  annotation")).simulate(at=[1.0], from_=rates)


RIDE = """model Ride "A bar on a ball joint at the rim of a turning disc"
  World world(gravity = {0, 0, -9.81});
  Revolute hinge(a = world); Body hub(m = 1, I = {0.1, 0.1, 0.2}, center = hinge.b);
  Spherical ball(a = shift(hinge.b, {0.5, 0, 0}), S(start = axis_angle({1, 1, 1}, 0.3)));
  Body bar(m = 1, I = {0.02, 0.02, 0.001}, center = shift(ball.b, {0, 0, -0.4}));
end Ride;"""
TOP = """model Top
  World world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, S(start = axis_angle({1, 0, 0}, 1.2)));
  Body top(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
end Top;"""


def test_a_bar_on_a_ball_joint_goes_round_aslant() -> None:
    """(A - C) w^2 sin cos + m R l w^2 cos = m g l sin."""
    w = 2.0
    run = lag.loads(RIDE).simulate(at=np.linspace(0, 2, 5), from_={"hinge.w": w}, tolerance=1e-11)
    a, x, y, z = (np.array(run[f"ball.S[{k}]"]) for k in (1, 2, 3, 4))
    out, level, up = 2 * (x * z + a * y), 2 * (y * z - a * x), 1 - 2 * (x**2 + y**2)
    angle = np.arctan2(-out, up)
    balance = (0.02 + 0.16 - 0.001) * w**2 * np.sin(angle) * np.cos(angle) + 0.2 * w**2 * np.cos(angle) - 3.924 * np.sin(angle)
    assert np.abs(balance).max() < 1e-9 and np.abs(level).max() < 1e-9 and 0.2 < angle[0] < 0.3


def test_a_top_spins_steadily_where_it_points_up_or_down() -> None:
    run = lag.loads(TOP).simulate(at=[0.0, 0.1], from_={"tip.w[3]": 200.0})
    assert np.abs([run["tip.S[2]"], run["tip.S[3]"]]).max() < 1e-12
    with pytest.raises(lag.RunError, match=r"no such steady motion.*depend on the positions whose rates are given"):
        lag.loads(TOP).simulate(at=[0.1], from_={"tip.w[1]": 1.0})


def test_hinges_that_turn_against_each_other_are_steady_along_their_way() -> None:
    """What stays as it is as both go on need not stay where one goes on alone."""
    text = """model Still World world; Revolute one(a = world, phi(start = 0.4)); Disc d(m = 1, r = 0.1, center = one.b);
      Revolute two(a = one.b, phi(start = -0.4)); Body b(m = 1, I = 0.1, center = two.b);
      Prismatic p(a = two.b, along = {0, 1}); PointMass m(m = 1, center = p.b);
      Spring s(k = 9, stretch = p.s - 0.2); end Still;"""
    run = lag.loads(text).simulate(at=[0.0, 1.0], from_={"one.w": 2.0, "two.w": -2.0})
    assert np.abs(np.array(run["p.s"]) - (0.2 - 9.81 / 9)).max() < 1e-9


SLEEVE = """model Watt "Flyballs on links, and a sleeve that goes round with them on an axle of the world"
  World world(gravity = {0, 0, -9.81});
  Revolute shaft(a = world); Body hub(m = 1, I = {0.01, 0.01, 0.02}, center = shaft.b);
  Revolute arm(a = shaft.b, axis = {0, 1, 0}, phi(start = -0.6)); PointMass ball(m = 0.5, center = shift(arm.b, {0, 0, -0.3}));
  Revolute knee(a = ball.center, axis = {0, 1, 0}, phi(start = 1.2)), foot(axis = {0, 1, 0});
  Cylindrical sleeve(a = world, axis = {0, 0, 1}); Body ring(m = 2, I = {0.01, 0.01, 0.02}, center = sleeve.b);
equation
  connect(foot.a, sleeve.b);
  connect(foot.b, shift(knee.b, {0, 0, -0.3}));
end Watt;"""
COIN = """model Coin "A disc that rolls round a circle, aslant"
  World world(gravity = {0, 0, -9.81});
  PlanarJoint path(a = world, x(start = 0), phi(start = 0)); Prismatic height(a = path.b, along = {0, 0, 1});
  Revolute lean(a = height.b, axis = {1, 0, 0}, phi(start = 0.2)), spin(a = lean.b, axis = {0, 1, 0});
  Body disc(m = 2, I = {0.03, 0.0625, 0.03}, center = spin.b);
  RollingDisc rolling(r = 0.25, axis = {0, 1, 0}, base = world, center = disc.center);
end Coin;"""


def test_flyballs_on_links_rise_with_the_speed() -> None:
    """cos(theta) = (m + 2 M) g/(m l w^2) of one ball that carries the sleeve; theta = 0 below cos(theta) = 1."""
    model = lag.loads(SLEEVE)
    for w in (12.0, 18.0, 22.0):
        run = model.simulate(at=[0.0, 0.5], from_={"shaft.w": w}, tolerance=1e-10)
        cosine = min(1.0, 4.5 * 9.81 / (0.5 * 0.3 * w**2))
        assert np.abs(np.cos(run["arm.phi"]) - cosine).max() < 1e-10 and np.abs(np.array(run["shaft.w"]) - w).max() < 1e-9


def test_a_motor_that_drives_flyballs_on_links_has_its_current() -> None:
    """V = R i + k w and k i = load: the current is a first-order state, from which the run begins as well."""
    text = SLEEVE.replace("equation", "DCMotor motor(a = world, b = shaft.b, V = 12, R = 1, k = 0.5, L = 0.01);\nequation", 1)
    text = text.replace("end Watt;", "energy\n  work -2[N.m] on shaft.phi;\nend Watt;")
    run = lag.loads(text).simulate(at=[0.0, 0.01, 0.5], from_={"shaft.w": 16.0}, tolerance=1e-10)
    assert np.abs(np.array(run["motor.i"]) - 4).max() < 1e-9 and np.abs(np.array(run["shaft.w"]) - 16).max() < 1e-9


@pytest.mark.parametrize(("spin", "yaw"), [(8.0, 1.5), (-8.0, 3.0), (8.0, 0.0)])
def test_a_disc_rolls_round_a_circle(spin: float, yaw: float) -> None:
    """Angular momentum about the centre and the force where it touches: A, C, m, r at a lean from the vertical."""
    run = lag.loads(COIN).simulate(at=np.linspace(0, 2, 5), from_={"spin.w": spin, "der(path.phi)": yaw}, tolerance=1e-11)
    lean, A, C, m, r, g = np.array(run["lean.phi"]), 0.03, 0.0625, 2.0, 0.25, 9.81
    about = spin + yaw * np.sin(lean)  # the angular velocity about the axle
    balance = (C + m * r * r) * about * yaw * np.cos(lean) - A * yaw**2 * np.sin(lean) * np.cos(lean) + m * g * r * np.sin(lean)
    assert np.abs(balance).max() < 1e-9 and np.ptp(lean) < 1e-10 and np.ptp(run["path.x"]) > 0.1


def test_what_loops_and_rolling_do_not_let_be() -> None:
    loop = """model L Revolute O(a = world, phi(start = 1)), A; Bar one(m = 1, L = 1, a = O.b), two(m = 1, L = 1, a = A.b);
  Prismatic p(a = world, along = {1, 0}); equation connect(one.b, A.a); connect(two.b, p.b); end L;"""
    with pytest.raises(lag.RunError, match=r"no such steady motion.*the loop world .* does not let all else rest"):
        lag.loads(loop).simulate(at=[1.0], from_={"O.w": 1.0})
    pushed = COIN.replace("end Coin", "  TorsionDamper d(c = 0.1, a = spin.a, b = spin.b);\nend Coin")
    with pytest.raises(lag.RunError, match=r"no such steady motion.*spin.phi is accelerated \(.*something has to drive it"):
        lag.loads(pushed).simulate(at=[1.0], from_={"spin.w": 8.0})
