"""On paper, loops that joints in space close: what their multipliers are, and what is not written."""

from pathlib import Path

import pytest

from lagrangia.base.folders import data_folder
from lagrangia.command.cli import WRONG, main

EXAMPLES = data_folder("models") / "examples"


@pytest.mark.slow
def test_multipliers_are_forces_and_torques_of_the_cut_joint(tmp_path: Path) -> None:
    """A cut joint in space has three lengths and three angles; the paper knew the two or three of the plane."""
    page = tmp_path / "shaft.tex"
    assert main(["export", "--to", "latex", str(EXAMPLES / "cardan_shaft.lag"), "-o", str(page)]) == 0
    told = page.read_text()
    assert all(f"the force along ${axis}$ in far, on " in told for axis in "xyz") and "the torque in far, on " in told


def test_angles_of_a_ball_joint_that_closes_a_loop_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", "--angles", "zxz", str(EXAMPLES / "spatial_four_bar.lag")]) == WRONG
    assert "equations by angles of a loop that a ball joint closes ('far.S')" in capsys.readouterr().err
