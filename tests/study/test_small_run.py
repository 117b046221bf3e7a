"""Small motion beside a run, where attitudes are coordinates and where signals have states."""

from pathlib import Path

import numpy as np

import lagrangia as lag
from lagrangia.command.cli import main

BALL = """model Ball
  World world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, S(start = axis_angle({1, 1e-5, 1e-5}, 180[deg])), w(start = {1e-5, 2e-5, 3e-6}));
  Body bar(m = 0.5, I = {0.008, 0.006, 0.0025}, center = shift(tip.b, {0, 0, 0.3}));
  input Force push = 0;
  energy work push on bar.center.r[1];
  output Length x = bar.center.x;
end Ball;"""
LAGGING = """model Lagging
  World world(gravity = {0, 0});
  Prismatic arm(a = world, along = {1, 0}, s(start = 0.25)); PointMass ball(m = 0.5, center = arm.b);
  Spring s(k = 200, stretch = arm.s - 0.2);
  FirstOrder seen(T = 0.1, u = arm.s/1[m]);
end Lagging;"""


def test_small_motion_of_an_attitude_is_its_run() -> None:
    run = lag.loads(BALL).simulate(at=np.linspace(0, 3, 16), inputs={"push": 1e-6}, tolerance=1e-11)
    names = ["x", *(f"tip.S[{k}]" for k in (1, 2, 3, 4)), "tip.w[2]"]
    for name, small in run.sight.small_motion(run.rows, names).items():
        assert np.abs(np.asarray(run[name]) - small).max() < 1e-8, name
    assert np.ptp(run["x"]) > 1e-6


def test_small_motion_of_what_lags_is_its_run(tmp_path: Path) -> None:
    run = lag.loads(LAGGING).simulate(at=np.linspace(0, 1, 11), tolerance=1e-11)
    for name, small in run.sight.small_motion(run.rows, ["arm.s", "seen.y"]).items():
        assert np.abs(np.asarray(run[name]) - small).max() < 1e-5, name  # w is linear between fine times


def test_pictures_show_attitudes_by_quaternions(tmp_path: Path) -> None:
    """Parts of attitudes are against references that move along: what they are in a row says nothing."""
    (tmp_path / "ball.lag").write_text(BALL)
    command = ["simulate", str(tmp_path / "ball.lag"), "--stop", "0.1", "--linear", "--plot", str(tmp_path / "ball.svg")]
    assert main([*command, "-o", str(tmp_path / "x.csv")]) == 0
    assert [c.name for c in lag.load(tmp_path / "ball.lag").scene.moving] == [f"tip.S[{k}]" for k in (1, 2, 3, 4)]
