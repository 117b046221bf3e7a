"""First-order states in small motion about a state that moves: each as the rate of a mass of 1 kg that is pushed as it says."""

import re

import numpy as np
import pytest

import lagrangia as lag

CURRENT = "Real i(start = 0.7);"
SLIDER = """Prismatic slider(a = world, along = {1, 0, 0}, s(start = 0), v(start = 0.7));
  PointMass own(m = 1, center = slider.b); AppliedForce push(at = slider.b, force = {%s, 0, 0});"""
FLAT = SLIDER.replace(", 0, 0}", ", 0}").replace(", 0, 0)", ", 0)")
LOOP = """
  World world;
  Prismatic lift(a = world, along = {0, 1}, s(start = 0.3));
  Revolute A(a = lift.b, phi(start = 1.2), w(start = 2)); Bar crank(m = 1, L = 0.4, a = A.b);
  Revolute B(a = crank.b); Bar coupler(m = 1, L = 1, a = B.b);
  Revolute C(a = shift(world, {1.2, 0})); Bar rocker(m = 1, L = 0.8, a = C.b);
  Revolute D(a = coupler.b, b = rocker.b);
  AppliedTorque motor(on = crank.b, torque = 0.8*i + 0.3*i*A.w);
  OWN
equation
  lift.s = 0.3*cos(5*time);
"""
SKATE = """
  World world(gravity = {0, 1});
  Body skate(m = 70, I = 2, center(phi(start = 0.4), v(start = {0.8, 0.4}), w(start = 2)));
  AppliedTorque motor(on = skate.center, torque = -2*i);
  OWN
equation
  dot(skate.center.v, rotate({0, 1}, skate.center.phi)) = 0;
"""
BALL = """
  World world(gravity = {0, 0, -9.81});
  Spherical h(a = world, w(start = {1, 0.3, -0.4}));
  Body b(m = 1, I = {0.1, 0.08, 0.02}, center = shift(h.b, {0, 0.15, 0}));
  AppliedTorque motor(on = b.center, torque = {0.6*i, 0, 0.1*i^2});
  OWN
equation
"""
COIN = """
  World world(gravity = {0, 0, -9.81});
  Disc disc(m = 2, r = 0.25, center(Q(start = angles("zxz", 0, 1.05, 0)), x(start = 0), y(start = 0),
    omega(start = {0, 1.3, -8})));
  RollingDisc rolling(r = 0.25, base = world, center = disc.center);
  AppliedTorque motor(on = disc.center, torque = {0, 0, 0.6*i + 0.1*i^2});
  OWN
equation
"""
ARM = """
  World world(gravity = {0, 0, -9.81});
  Revolute pan(a = world, phi(start = 0), w(start = 2));
  Body hub(m = 1, I = {0.1, 0.1, 0.2}, center = pan.b);
  Revolute arm(a = shift(pan.b, {0.2, 0, 0}), axis = {0, 1, 0}, phi(start = 0.9));
  Body bob(m = 1, I = {0.01, 0.01, 0.02}, center = shift(arm.b, {0.5, 0, 0}));
  Revolute back(a = shift(pan.b, {0, 0, 0.3}), axis = {0, 1, 0}, phi(start = 0.9));
  Body rod(m = 1, I = {0.01, 0.01, 0.02}, center = shift(back.b, {0.25, 0, 0}));
  Revolute tip(a = shift(back.b, {0.5, 0, 0}), axis = {0, 1, 0});
  Prismatic sleeve(a = tip.b, along = {1, 0, 0}, s(start = 0.3));
  Body ring(m = 0.2, I = {0.001, 0.001, 0.001}, center = sleeve.b);
  Revolute close(a = sleeve.b, b = shift(arm.b, {0.3, 0, 0}), axis = {0, 1, 0});
  AppliedTorque motor(on = hub.center, torque = {0, 0, 0.6*i});
  OWN
equation
"""


@pytest.mark.parametrize(("scene", "rate"), [
    (LOOP, "2*(3 - 2*i - 0.8*A.w*B.phi)"), (SKATE, "5*(skate.center.v[1] - i)"),
    (BALL, "20*(12 - 2*i - 0.6*h.w[1] + b.center.x)"),
    (COIN, "20*(1 - 2*i - 0.6*disc.center.w[3])"), (ARM, "20*(12 - 2*i - 0.6*pan.w)")])
def test_a_state_is_as_the_rate_of_a_pushed_mass(scene: str, rate: str) -> None:
    """Refused before (L0916)."""
    linear = lag.loads(f"model A{scene.replace('OWN', CURRENT)}  der(i) = {rate};\nend A;").linearize(about="start")
    own = (SLIDER if "{0, 0," in scene else FLAT) % rate
    pushed = re.sub(r"\bi\b", "slider.v", scene.replace("OWN", own))
    other = lag.loads(f"model B{pushed}end B;").linearize(about="start")
    places = [other.states.index("der(slider.s)" if name == "i" else name) for name in linear.states]
    assert "i" in linear.states and len(places) == len(other.states) - 1
    assert other.A[np.ix_(places, places)] == pytest.approx(linear.A, rel=1e-10, abs=1e-10)
    assert linear.drift == pytest.approx(other.drift[places], rel=1e-10, abs=1e-10)
    outputs = [k for k, name in enumerate(linear.outputs) if name in other.outputs]
    there = [other.outputs.index(linear.outputs[k]) for k in outputs]
    assert outputs and linear.output[outputs] == pytest.approx(other.output[np.ix_(there, places)], rel=1e-10, abs=1e-10)


def test_a_motor_of_a_loop_by_runs_beside_each_other() -> None:
    """A is what differences of the motion itself say."""
    scene = LOOP.replace("lift.s = 0.3*cos(5*time);", "lift.s = 0.3;").replace("OWN", CURRENT)
    model, t, h = lag.loads(f"model A{scene}  der(i) = 2*(3 - 2*i - 0.8*A.w);\nend A;"), 1e-3, 1e-3
    linear, start = model.linearize(about="start"), np.array([1.2, 2, 0.7])
    assert linear.states == ("A.phi", "der(A.phi)", "i") and "not steady" in linear.notes[0]

    def rates(state: np.ndarray) -> np.ndarray:
        run = model.simulate(at=[0, t, 2 * t], tolerance=1e-13, initial=dict(zip(("A.phi", "A.w", "i"), state, strict=True)))
        return np.array([np.dot([-3, 4, -1], run[name]) / (2 * t) for name in linear.states])

    slopes = np.array([(rates(start + h * e) - rates(start - h * e)) / (2 * h) for e in np.eye(3)]).T
    assert slopes == pytest.approx(linear.A, rel=1e-4, abs=1e-4)
    assert linear.drift[1:] == pytest.approx(rates(start)[1:], rel=1e-4, abs=1e-4)


def test_the_response_of_a_ball_that_turns_is_that_of_its_matrices() -> None:
    """Small turns that are told in turned axes are no integrals of the rates: the response was 0.3 of its size off."""
    scene = BALL.replace("OWN", "").replace("0.6*i", "0.42 + 0*time").replace("0.1*i^2", "0.049")
    model, s = lag.loads(f"model A{scene}end A;"), 1.7j
    linear = model.linearize(about="start", excitations=["motor.torque[1]"])
    found = model.response(about="start", excitations=["motor.torque[1]"], frequencies=[1.7 / (2 * np.pi)])
    known = linear.output @ np.linalg.solve(s * np.eye(6) - linear.A, linear.B) + linear.D
    assert found.values[0] == pytest.approx(known, rel=1e-12)
