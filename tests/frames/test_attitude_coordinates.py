"""Attitudes as coordinates: ball joints, floating bodies, starts; beside closed forms and quadruple precision (shared cases)."""

import math
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.base.folders import data_folder

SOLVERS = ("auto", "erk", "erk5", "implicit", "pirk")


def scene(tmp_path: Path, text: str) -> lag.Model:
    path = tmp_path / "scene.lag"
    path.write_text(text, encoding="utf-8")
    return lag.load(path)


def same_attitude(found: np.ndarray, wanted: list[float], error: float) -> bool:
    """Whichever sign a quaternion has."""
    return min(np.abs(found - wanted).max(), np.abs(found + wanted).max()) < error


HEAVY = """
model Heavy "heavy_symmetric_top of the shared cases"
  World world(gravity = {0, 0, -9.81});
  parameter Angle theta0 = 90[deg];
  parameter AngularVelocity w3 = 5, precession = 2, nodding = 1;
  Spherical joint(a = world, S(start = angles("zxz", 0, theta0, 0)), w(start = {nodding, precession*sin(theta0), w3}));
  Body b(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(joint.b, {0, 0, 0.1}));
end Heavy;
"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_heavy_top(tmp_path: Path, solver: str) -> None:
    """Slow: it swings below the horizontal, where Euler's angles are of no use."""
    run = scene(tmp_path, HEAVY).simulate(stop=2, tolerance=1e-13, solver=solver, at=[0, 2])
    wanted = [0.12604409641879458326, 0.69716192816983944602, -0.11523402566216685991, -0.69627526955807665594]
    assert same_attitude(run["joint.S"][-1], wanted, 2e-13)
    assert same_attitude(run["b.center.Q"][-1], wanted, 2e-13)
    assert run["joint.w"][-1] == pytest.approx([-2.1779723288812500454, -0.15574254814868348274, 5], abs=1e-12)
    assert run["b.center.r"][-1] == pytest.approx([-0.0999882356206742889, -0.0015277086027128866828, 1.3727304804053885623e-4],
                                                  abs=1e-13)
    assert run.names == ["time", *(f"joint.S.s[{k}]" for k in (1, 2, 3)), *(f"der(joint.S)[{k}]" for k in (1, 2, 3)),
                         *(f"joint.S[{k}]" for k in (1, 2, 3, 4))]


def test_fast_top_costs_no_more_than_a_quaternion(tmp_path: Path) -> None:
    """A unit quaternion by SciPy's DOP853 takes 23 066 evaluations to 9.4e-9, and 5 270 to 5.8e-8 of the one of medium speed."""
    model = scene(tmp_path, HEAVY)
    fast = {"theta0": math.pi / 6, "w3": 200.0, "precession": 0.0, "nodding": 0.0}
    medium = {"theta0": math.pi / 3, "w3": 40.0, "precession": 4.0, "nodding": 0.0}
    for parameters, wanted, most, error in (
        (fast, [0.016344614987628815621, -0.125085247235362226, 0.22681606092430144762, -0.9657334047198316004], 23_066, 9.4e-9),
        (medium, [0.11371799369942964107, -0.39742933319940800014, -0.34236954271780240879, -0.84374240099739759732], 5_270,
         5.8e-8),
    ):
        run = model.simulate(stop=5, tolerance=3e-8, parameters=parameters, at=[0, 5], solver="erk9")
        assert run.statistics.rhs_evaluations < 1.2 * most
        assert same_attitude(run["joint.S"][-1], wanted, error)


BARS = """
model Bars "double_pendulum_ball_joints of the shared cases"
  World world(gravity = {0, 0, -9.81});
  Spherical j1(a = world, w(start = {3, -0.5, 1}, fixed = true));
  Body b1(m = 1, I = {0.01, 1/12, 1/12}, center = shift(j1.b, {0.5, 0, 0}));
  Spherical j2(a = shift(j1.b, {1, 0, 0}), S(start = axis_angle({0, 0, 2}, 60[deg])));
  Body b2(m = 0.7, I = {0.02, 0.7*0.64/12, 0.7*0.64/12}, center = shift(j2.b, {0.4, 0, 0}));
initial equation
  b2.center.omega = {-2, 1, 2};
end Bars;
"""


def test_two_bars_on_ball_joints(tmp_path: Path) -> None:
    """The reactions are those that Newton's equations of each bar ask for."""
    run = scene(tmp_path, BARS).simulate(stop=1, tolerance=1e-12, at=[0, 1])
    assert run["b1.center.R"][-1][[0, 3, 6]] == pytest.approx(
        [-0.690406335619192725, -0.675042461520410721, -0.260109144170948796], abs=1e-11)
    assert run["b2.center.omega"][-1] == pytest.approx([-2, 3.74778472301124969, 3.91626504551895591], abs=1e-10)
    assert run["j1.reaction"][-1] == pytest.approx([7.81203170717058231, 9.68885836945431019, 5.24366454023680852], abs=1e-9)
    assert run["j2.reaction"][-1] == pytest.approx([7.16374181381908386, 3.20269079262932428, 3.04528805321285935], abs=1e-9)
    assert run["j1.w[1]"] == pytest.approx([3, 3], abs=1e-12)


FLOATING = """
model Floating "euler_top_free of the shared cases, flying"
  World world(gravity = {0, 0, -2});
  Body b(m = 1, I = {1.3, 2.1, 3}, center(r(start = {1, 2, 3}), v(start = {0, 1, 0}), omega(start = {0.8, 0.9, -0.6})));
end Floating;
"""


def test_native_code_from_the_start_is_chosen_by_as_the_tape_is() -> None:
    """Its library had series, which attitudes had no steps for: the run ended with "bad settings"."""
    tape, native = (lag.load(data_folder("models") / "examples" / "top.lag") for _ in range(2))
    native.native = True
    assert native.simulate(stop=0.1).statistics.solver == tape.simulate(stop=0.1).statistics.solver


def test_a_body_floats_with_an_attitude(tmp_path: Path) -> None:
    run = scene(tmp_path, FLOATING).simulate(stop=10, tolerance=1e-12, at=[0, 10])
    wanted = [0.699042422505348825, 0.164308163409162285, -0.633812223093282067, 0.287444924868248543]
    assert same_attitude(run["b.center.S"][-1], wanted, 1e-12)
    assert run["b.center.r"][-1] == pytest.approx([1, 12, -97], abs=1e-10)


def test_a_potential_of_a_quaternion(tmp_path: Path) -> None:
    """As that of the elements of R, whose forces are found on the body."""
    ends = []
    for square in ("b.center.Q[2]^2", "(1 + b.center.R[1,1] - b.center.R[2,2] - b.center.R[3,3])/4"):
        body = "World world(gravity = {0, 0, -9.81}); Body b(m = 1, I = {0.1, 0.2, 0.3}, center(omega(start = {0.6, 0.1, 0.8})));"
        run = scene(tmp_path, f"model Tied {body} energy potential 1[J]*{square}; end Tied;").simulate(stop=1, tolerance=1e-11)
        ends.append(run["b.center.omega"][-1])
    assert ends[0] == pytest.approx(ends[1], abs=1e-9)


def test_a_held_tip_is_a_constraint(tmp_path: Path) -> None:
    """A floating top whose tip is held at one point moves as that on a ball joint."""
    held = """
model Heavy
  World world(gravity = {0, 0, -9.81});
  Body b(m = 0.5, I = {0.0008, 0.0008, 0.001}, center(Q(start = angles("zxz", 0, 90[deg], 0), fixed = true),
                                                      omega(start = {1, 2, 5}, fixed = true)));
  Frame tip = shift(b.center, {0, 0, -0.1});
equation
  tip.r = {0, 0, 0};
end Heavy;
"""
    for solver in ("erk", "implicit"):
        run = scene(tmp_path, held).simulate(stop=0.5, tolerance=1e-11, at=[0, 0.5], solver=solver)
        wanted = [0.10913155364584639689, -0.58194273658414615716, 0.6216305046737554242, 0.5128435151143582156]
        assert same_attitude(run["b.center.Q"][-1], wanted, 2e-9)
        assert np.abs(run["tip.r"]).max() < 1e-13


def rotation(axis: str, angle: float) -> np.ndarray:
    k = "xyz".index(axis)
    i, j = (k + 1) % 3, (k + 2) % 3
    found = np.eye(3)
    found[i, i] = found[j, j] = math.cos(angle)
    found[i, j], found[j, i] = -math.sin(angle), math.sin(angle)
    return found


def test_all_sequences_of_angles(tmp_path: Path) -> None:
    sequences = [a + b + c for a in "xyz" for b in "xyz" for c in "xyz" if b not in (a, c)]
    text = "model All\n  World world;\n"
    for name in sequences:
        text += (f'  Spherical {name}(a = world, S(start = angles("{name}", 0.4, -1.1, 2.3)), w(start = {{0, 0, 1}}));\n'
                 f"  Body b_{name}(m = 1, I = {{1, 1, 1}}, center = {name}.b);\n")
    run = scene(tmp_path, text + "end All;\n").simulate(stop=0.1, at=[0])
    for name in sequences:
        wanted = rotation(name[0], 0.4) @ rotation(name[1], -1.1) @ rotation(name[2], 2.3)
        assert run[f"{name}.b.R"][0].reshape(3, 3) == pytest.approx(wanted, abs=1e-15)
        assert run[f"{name}.S[1]"][0] >= 0
        assert run[f"b_{name}.center.w"][0] == pytest.approx(wanted[:, 2], abs=1e-15)


def test_floating_frames_start_by_velocities_in_either_axes(tmp_path: Path) -> None:
    text = """
model Two
  World world(gravity = {0, 0, 0});
  Body a(m = 1, I = {1, 2, 3}, center(Q(start = quaternion(1, 2, 3, 4)), w(start = {0.3, -0.4, 0.5})));
  Body b(m = 1, I = {1, 2, 3}, center(Q(start = quaternion(1, 2, 3, 4)), omega(start = {0.3, -0.4, 0.5})));
end Two;
"""
    run = scene(tmp_path, text).simulate(stop=0.1, at=[0])
    R = run["a.center.R"][0].reshape(3, 3)
    assert run["a.center.Q"][0] == pytest.approx(np.array([1, 2, 3, 4]) / math.sqrt(30), abs=1e-15)
    assert run["a.center.w"][0] == pytest.approx([0.3, -0.4, 0.5], abs=1e-15)
    assert run["a.center.omega"][0] == pytest.approx(R.T @ [0.3, -0.4, 0.5], abs=1e-15)
    assert run["b.center.omega"][0] == pytest.approx([0.3, -0.4, 0.5], abs=1e-15)


@pytest.mark.parametrize(("line", "told"), [
    ('Spherical j(a = world, S(start = angles("zzx", 0, 1, 0)));', "neighbours differ"),
    ("Spherical j(a = world, S(start = quaternion(1, 2, 3)));", "quaternion takes 1 or 4 arguments"),
    ("Spherical j(a = world, S(start = axis_angle({1, 0}, 1)));", "an axis has three components"),
    ("Spherical j(a = world, S(start = angles(\"zxz\", 1[m], 1, 0)));", "the argument of cos must be a number without unit"),
    ("Spherical j(a = world, S(start = time*{1, 0, 0, 0}));", "depends on parameters only"),
    ("Spherical j(a = world); Real x = j.S[1];", "is an attitude, and no number"),
    ("coordinate Rotation S;", "turns no frame"),
])
def test_what_is_wrong_is_told(tmp_path: Path, line: str, told: str) -> None:
    text = f"model Wrong\n  World world;\n  {line}\n  Spherical k(a = world);\n  Body b(m = 1, I = {{1, 1, 1}}, center = k.b);\n"
    if " j(" in line:
        text += "  Body c(m = 1, I = {1, 1, 1}, center = j.b);\n"
    if " x = " in line:
        text += "energy\n  potential x*1[J];\n"
    with pytest.raises(LagError, match=told):
        scene(tmp_path, text + "end Wrong;\n")


@pytest.mark.parametrize("solver", ["adams", "conservative", "linear", "islands"])
def test_solvers_that_know_no_attitudes_are_refused(tmp_path: Path, solver: str) -> None:
    with pytest.raises(LagError, match="attitude"):
        scene(tmp_path, HEAVY).simulate(stop=1, solver=solver)
