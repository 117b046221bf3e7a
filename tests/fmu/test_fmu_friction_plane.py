"""Model Exchange of friction in the plane: an importer's steps end anywhere, and its derivatives by rates may be old ones."""

from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")

import lagrangia as lag
from helpers.fmus import simulated

PUCK = """model Puck World world(gravity = {{0, 0}}); PointMass p(m = 2);
  SlidingFriction f(a = world, b = p.center, mu = 0.5, normal = 10); {more}
initial equation p.center.x = 0; p.center.y = 0; p.center.v[1] = 1; p.center.v[2] = 0.5; end Puck;"""
ARM = """model Arm World world(gravity = {0, 0}); Frame table = turn(world, 2[rad/s]*time);
  Revolute h(a = table, phi(start = 0.5), w(start = 1)); Bar d(m = 1, L = 2, a = h.b);
  AppliedTorque t(on = h.b, torque = 8[N.m]*sin(2[rad/s]*time));
  SlidingFriction f(mu = 0.3, normal = 10, a = table, b = d.b); end Arm;"""
PLACE = ("p.center.x", "p.center.y")
SCENES = {
    "stops": (PUCK.format(more=""), PLACE, 2.0),
    "pushed on": (PUCK.format(more="AppliedForce q(at = p.center, force = {2, 1});"), PLACE, 3.0),
    "turns back": (PUCK.format(more="AppliedForce q(at = p.center, force = {-8, -4});"), PLACE, 2.0),
    "stops and is torn off": (PUCK.format(more="AppliedForce q(at = p.center, force = "
                                               "{7*sin(2[rad/s]*time), 2*cos(3[rad/s]*time)});"), PLACE, 4.0),
    "arm on a turntable": (ARM, ("h.phi",), 4.0),
}


def errors(path: Path, names: tuple[str, ...], stop: float, **options: object) -> float:
    at = np.linspace(0, stop, 21)
    run = lag.load(path).simulate(at=at, tolerance=1e-11)
    rows = simulated(path, "3", "ModelExchange", list(names), stop_time=stop, **options)
    last = [np.flatnonzero(np.abs(rows["time"] - t) < 1e-9)[-1] for t in at]
    return max(np.abs(rows[name][last] - run[name]).max() for name in names)


@pytest.mark.parametrize("case", SCENES)
def test_pucks_come_to_rest_in_an_importer(case: str, tmp_path: Path) -> None:
    """CVode gave up, went off with 27 m/s, or held a puck that moves on; Euler, who looks for no place, chattered."""
    text, names, stop = SCENES[case]
    path = tmp_path / f"{case}.lag"
    path.write_text(text)
    for tolerance, most in ((1e-6, 4e-5), (1e-8, 1e-6), (1e-10, 4e-7)):
        assert errors(path, names, stop, relative_tolerance=tolerance, step_size=stop / 20, output_interval=stop / 20) < most
    assert errors(path, names, stop, solver="Euler", step_size=5e-4, output_interval=5e-4) < 5e-3
