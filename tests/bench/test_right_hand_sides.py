"""`lag bench --rhs`: the accelerations of trees in space beside those of peers; those not installed are skipped with a word."""

from pathlib import Path

import pytest

from lagrangia.bench import tree_peers
from lagrangia.command.cli import main

ARM = """model Arm
  World world(gravity = {0, 0, -9.81});
  Revolute waist(a = world), shoulder(a = waist.b, axis = {0, 1, 0});
  Prismatic reach(a = shoulder.b, along = {1, 0.2, 0});
  Body upper(center = shift(waist.b, {0, 0, 0.3}), m = 1, I = {0.1, 0.12, 0.14});
  Body fore(center = shift(shoulder.b, {0.1, 0, 0}), m = 1, I = {0.1, 0.12, 0.14});
  Body hand(center = reach.b, m = 1, I = {{0.1, 0.01, 0}, {0.01, 0.12, 0}, {0, 0, 0.14}});
  Spherical wrist(a = shift(reach.b, {0.1, 0.02, 0}));
  Body tool(center = shift(wrist.b, {0.05, 0, 0.1}), m = 0.5, I = {0.01, 0.012, 0.014});
  Revolute blade(a = wrist.b, axis = {0.6, 0, 0.8});
  Body tip(center = shift(blade.b, {0.05, 0, 0.1}), m = 0.5, I = {0.01, 0.012, 0.014});
end Arm;
"""


@pytest.mark.parametrize("largest", [200, 6])
def test_a_line_for_each(largest: int, tmp_path: Path, capsys: pytest.CaptureFixture[str],
                         monkeypatch: pytest.MonkeyPatch) -> None:
    """Also of trees for which Pinocchio is not given room for all that it could work out: of 1 000 hinges that takes 32 GB."""
    monkeypatch.setattr(tree_peers, "_LARGEST_WHOLE", largest)
    (tmp_path / "arm.lag").write_text(ARM, encoding="utf-8")
    assert main(["bench", str(tmp_path / "arm.lag"), "--rhs"]) == 0
    told = capsys.readouterr().out
    assert "Arm: 7 coordinates" in told and " operations" in told
    for peer, package in (("pinocchio", "pin"), ("mujoco", "mujoco")):
        line = next(line for line in told.splitlines() if peer in line)
        assert f"pip install {package}" in line or float(line.split()[5]) < 1e-13


def test_what_is_no_tree_in_space_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    damped = ARM.replace("end Arm;", "energy\n  dissipation 3*waist.w^2;\nend Arm;")
    (tmp_path / "arm.lag").write_text(damped, encoding="utf-8")
    assert main(["bench", str(tmp_path / "arm.lag"), "--rhs"]) == 1
    assert "without springs, dampers and loads" in capsys.readouterr().err
