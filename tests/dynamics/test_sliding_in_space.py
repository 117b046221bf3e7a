"""Coulomb's friction in a plane of space: of a box on a slope, and of a puck on a disc that turns."""

import numpy as np
import pytest

import lagrangia as lag

SLOPE = """model Slope
  parameter Real mu = 0.4;
  World world(gravity = {0, 0, -9.81});
  Frame plane;
  PlanarJoint on(a = plane, phi(start = 0.2));
  Box b(m = 1, size = {0.1, 0.2, 0.3}, center = shift(on.b, {0, 0, 0.15}));
  SlidingFriction f(a = plane, b = on.b, mu = mu, normal = 9.81*cos(30[deg]));
  Revolute beside(a = world, axis = {1, 0, 0}), across(a = beside.b);
  Body pendulum(m = 0.1, I = {0.1, 0.1, 0.1}, center = shift(across.b, {0.1, 0, -0.2}));
equation
  plane = turn(world, 30[deg], {1, 1, 0});
end Slope;"""
DISC = """model Carried
  World world(gravity = {0, 0, -9.81});
  Revolute turning(a = world, axis = {0, 0, 1}), aside(a = turning.b, axis = {1, 0, 0});
  Body hand(m = 1, I = {1, 1, 1}, center = aside.b);
  PlanarJoint on(a = world, x(start = 0.3));
  Body puck(m = 1, I = {0.1, 0.1, 0.1}, center = on.b);
  SlidingFriction f(a = turning.b, b = on.b, mu = MU, normal = 9.81);
equation
  turning.phi = 2*time;
end Carried;"""


@pytest.mark.parametrize("solver", ["auto", "implicit", "erk9"])
def test_a_box_slides_down_a_slope_or_stays(solver: str) -> None:
    """a = g (sin - mu cos) down it, and none where mu is larger than the tangent."""
    model = lag.loads(SLOPE)
    run = model.simulate(at=[0.0, 1.0], solver=solver, tolerance=1e-10)
    down = 9.81 * (0.5 - 0.4 * np.sqrt(3) / 2) / 2
    assert np.hypot(run["on.x"][-1], run["on.y"][-1]) == pytest.approx(down, rel=1e-9)
    still = model.simulate(at=[0.0, 1.0], parameters={"mu": 0.6}, solver=solver)
    assert still["on.x"][-1] == still["on.y"][-1] == 0.0


def test_a_box_stops_where_energy_says() -> None:
    """Thrown up the slope it comes to rest after v^2/(2 g (sin + mu cos)), and stays."""
    run = lag.loads(SLOPE).simulate(initial={"der(on.x)": -1, "der(on.y)": 1}, at=[0.0, 3.0],
                                    parameters={"mu": 0.7}, tolerance=1e-10)
    assert np.hypot(run["on.x"][-1], run["on.y"][-1]) == pytest.approx(2 / (2 * 9.81 * (0.5 + 0.7 * np.sqrt(3) / 2)), rel=1e-8)
    assert run["der(on.x)"][-1] == run["der(on.y)"][-1] == 0.0


def test_a_disc_carries_a_puck_or_loses_it() -> None:
    """It needs w^2 r/g = 0.122 of friction."""
    run = lag.loads(DISC.replace("MU", "0.15")).simulate(at=np.linspace(0, 2, 9), initial={"der(on.y)": 0.6})
    x, y, t = (np.array(run[name]) for name in ("on.x", "on.y", "time"))
    assert np.abs([x - 0.3 * np.cos(2 * t), y - 0.3 * np.sin(2 * t)]).max() < 1e-8
    lost = lag.loads(DISC.replace("MU", "0.1")).simulate(at=[0.0, 2.0], initial={"der(on.y)": 0.6})
    assert np.hypot(lost["on.x"][-1], lost["on.y"][-1]) > 0.4
