"""Cams: followers that an equation moves, whose profile is made of pieces."""

from collections.abc import Callable
from math import cos, pi, sin

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]

CAM = """
function lift "Half a turn of rise, then a dwell"
  input Angle p;
  output Length s;
algorithm
  if p < pi then
    s := 0.025*(1 - cos(p));
  else
    s := 0.05;
  end if;
end lift;

model Cam
  Revolute cam(a = world);
  Body wheel(m = 1, I = 0.004, center = cam.b);
  Block follower(m = 2, base = world, along = {0, 1});
  Spring spring(k = 300, stretch = follower.s + 0.02);
  output Torque told = constraint_force(cam.phi);
equation
  follower.s = lift(cam.phi);
  cam.phi = MOTION;
end Cam;
"""
TIMES = [0, 0.1, 0.3, 0.55, 0.9]


def torque(phi: float, w: float, e: float) -> float:
    """Of the drive, N m: the power that energies take, by the rate."""
    if phi >= pi:
        return 0.004 * e
    s, slope, bend = 0.025 * (1 - cos(phi)), 0.025 * sin(phi), 0.025 * cos(phi)
    return 0.004 * e + slope * (2 * (bend * w**2 + slope * e) + 2 * 9.81 + 300 * (s + 0.02))


@pytest.mark.parametrize("solver", ["auto", "erk", "pirk", "implicit"])
@pytest.mark.parametrize(("motion", "w", "e"), [("4*time", 4, 0), ("4*time + 0.5*time^2", 4, 1)])
def test_a_driven_cam_goes_over_from_one_piece_to_the_next(motion: str, w: float, e: float, solver: str,
                                                            scene: Write) -> None:
    """Time decides on the pieces: at an even pace where it is linear, and else as any condition. Torques were a fault of the
    compiler at an even pace (the displacement that finds them stood in the condition), and steps missed their tolerance."""
    run = scene(CAM.replace("MOTION", motion)).simulate(at=TIMES, tolerance=1e-6, solver=solver)
    right = [torque(w * t + e * t**2 / 2, w + e * t, e) for t in TIMES]
    assert run["told"] == pytest.approx(right, rel=1e-9, abs=1e-9)
    assert run["cam.reaction_torque"] == pytest.approx(right, rel=1e-9, abs=1e-9)
    assert run.warnings == []
