"""On paper, loops that joints in space close: what their multipliers are, and what is not written."""

import re
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


def test_a_four_bar_in_a_tilted_plane_is_written_in_space(tmp_path: Path) -> None:
    """It runs with the equations of its plane, which have other coordinates: starts and positions of rest were of these."""
    scene = tmp_path / "tilted.lag"
    scene.write_text("""model Tilted
      World world(gravity = {0, 0, -9.81});
      Frame plane;
      Revolute O(a = plane, phi(start = 1)), A, B, C(a = shift(plane, {1, 0, 0}));
      Bar one(m = 1, L = 0.4, a = O.b), two(m = 1, L = 1, a = A.b), three(m = 1, L = 0.7, a = C.b);
    equation
      plane = turn(world, 0.5, {1, 0.3, 0});
      connect(one.b, A.a); connect(two.b, B.a); connect(three.b, B.b);
    end Tilted;""")
    assert main(["export", "--to", "modelica", str(scene), "-o", str(tmp_path / "tilted.mo")]) == 0
    text = (tmp_path / "tilted.mo").read_text()
    assert "Real phi_B(start = " in text
    assert re.search(r"(?<![.\d])\d{17}(?![.\d]*e)", text) is None  # integers that nothing reads


def test_angles_of_a_ball_joint_that_closes_a_loop_are_refused(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", "--angles", "zxz", str(EXAMPLES / "spatial_four_bar.lag")]) == WRONG
    assert "equations by angles of a loop that a ball joint closes ('far.S')" in capsys.readouterr().err
    assert main(["equations", "--form", "worked", str(EXAMPLES / "spatial_four_bar.lag")]) == WRONG
    assert "--angles" not in capsys.readouterr().err  # which is refused


def test_a_loop_that_lies_in_a_plane_is_written_without_ones(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Axes along z were met by axes across them in decimals, whose squares add up to 1 by rounding: - 1 sin(...)."""
    scene = tmp_path / "four.lag"
    scene.write_text("""model Four
      World world(gravity = {0, -9.81, 3});
      Revolute O(a = world, phi(start = 40[deg], fixed = true)), C(a = shift(world, {1, 0}), phi(start = 75[deg]));
      Revolute A(a = crank.b), B(a = coupler.b, b = rocker.b);
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
    end Four;""")
    assert main(["equations", str(scene)]) == 0
    told = capsys.readouterr().out
    assert "Φ₃ = − sin(φ_O − φ_C + φ_A + φ_B) = 0" in told and "1 λ₃" not in told
