"""First-order states of scenes whose loops are closed one by one along the tree of bodies: no body carries their coordinates."""

import numpy as np
import pytest

import lagrangia as lag

MOTOR = """
  Real i(start = 1.5);
  AppliedTorque motor(on = crank.center, torque = {0, 0, 0.6*i});
initial equation
  rod.center.omega[1] = 0;
equation
  0.05*der(i) = 12 - 2*i - BACK;
"""
UNTOLD = MOTOR.replace("initial equation\n  rod.center.omega[1] = 0;\n", "")
SLIDER = """model Slider
  World world(gravity = {0, 0, -9.81});
  Revolute turning(a = world, phi(start = 0.3, fixed = true), w(start = 8));
  Body crank(m = 1, I = {0.001, 0.02, 0.02}, center = shift(turning.b, {0.15, 0, 0}));
  Prismatic slide(a = world, along = {1, 0, 0}, s(start = 1.383));
  Body block(m = 1.5, I = {0.001, 0.05, 0.05}, center = slide.b);
  Universal near(a = shift(turning.b, {0.3, 0, 0}), phi_a(start = 1.57), phi_b(start = -0.38));
  Body rod(m = 2, I = {0.002, 0.2, 0.2}, center = shift(near.b, {0.55, 0, 0}));
  Spherical far(a = shift(near.b, {1.1, 0, 0}), b = slide.b);""" + UNTOLD + "end Slider;"
FOUR_BAR = """model FourBar
  World world(gravity = {0, 0, -9.81});
  Revolute turning(a = world, phi(start = 0), w(start = 8));
  Body crank(m = 1, I = {0.001, 0.02, 0.02}, center = shift(turning.b, {0.15, 0, 0}));
  Revolute rocking(a = shift(world, {0.9, 0.5, 0.2}), axis = {0, 1, 0}, phi(start = -1.6));
  Body rocker(m = 1.5, I = {0.001, 0.05, 0.05}, center = shift(rocking.b, {0.3, 0, 0}));
  Spherical near(a = shift(turning.b, {0.3, 0, 0}), S(start = angles("zyx", 40[deg], -45[deg], 0)));
  Body rod(m = 2, I = {0.002, 0.2, 0.2}, center = shift(near.b, {0.55, 0, 0}));
  Spherical far(a = shift(near.b, {1.1, 0, 0}), b = shift(rocking.b, {0.6, 0, 0}));""" + MOTOR + "end FourBar;"
ROW = "model Row\n  World world;" + "".join(f"""
  Revolute O{k}(a = {home}, phi(start = 0.7), w(start = 0.5)); Bar crank{k}(m = 1, L = 0.4, a = O{k}.b);
  Revolute B{k}(a = crank{k}.b, phi(start = -1.8)); Bar coupler{k}(m = 1, L = 1, a = B{k}.b);
  Revolute C{k}(a = shift({home}, {{1.2, 0}}), phi(start = -2.2)); Bar rocker{k}(m = 1, L = 0.8, a = C{k}.b);
  Revolute D{k}(a = coupler{k}.b, b = rocker{k}.b);""" for k, home in enumerate(("world", "rocker0.b", "rocker1.b", "rocker2.b"))
) + UNTOLD.replace("crank.center", "crank0.b").replace("{0, 0, 0.6*i}", "0.6*i") + "end Row;"
SCENES = {"slider": SLIDER, "four-bar": FOUR_BAR, "row": ROW}


@pytest.mark.parametrize(("scene", "solver"), [
    (scene, solver) for scene in SCENES for solver in ("auto", "erk5", "pirk", "taylor", "implicit")
    if (scene, solver) != ("row", "taylor")])  # too long for series
def test_a_current_rises_in_its_coil(scene: str, solver: str) -> None:
    """i = 6 - 4.5 exp(-40 t): it stayed as it began, without a word."""
    run = lag.loads(SCENES[scene].replace("BACK", "0")).simulate(at=[0, 0.01, 0.1], tolerance=1e-10, solver=solver)
    assert run["i"] == pytest.approx(6 - 4.5 * np.exp([0, -0.4, -4]), rel=1e-8)


@pytest.mark.parametrize("scene", ["slider", "four-bar"])
def test_a_current_is_as_the_rate_of_a_mass_of_its_own(scene: str) -> None:
    """That of 1 kg, which is pushed as the current says."""
    text = SCENES[scene].replace("BACK", "0.6*turning.w")
    first, last = text.split("  Real i(start = 1.5);")
    begins = last[last.index("initial"):last.index("equation\n  0.05")] if "initial" in last else ""
    heavy = f"""{first}  Prismatic slider(a = world, along = {{1, 0, 0}}, s(start = 0), v(start = 1.5));
  PointMass own(m = 1, center = slider.b);
  AppliedForce push(at = slider.b, force = {{20*(12 - 2*slider.v - 0.6*turning.w), 0, 0}});
  AppliedTorque motor(on = crank.center, torque = {{0, 0, 0.6*slider.v}});
{begins}end {text.split()[1]};"""
    run, other = (lag.loads(x).simulate(at=[0, 0.1, 0.5], tolerance=1e-12) for x in (text, heavy))
    assert run["i"] == pytest.approx(other["slider.v"], abs=1e-9)
    assert run["turning.phi"] == pytest.approx(other["turning.phi"], abs=1e-9)
