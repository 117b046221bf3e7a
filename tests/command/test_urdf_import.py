"""`lag import` of robots: forward dynamics beside Pinocchio's, names, limits, and what is told of what has no counterpart."""

import re
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.bench.clock import hoisted
from lagrangia.command.cli import main
from lagrangia.editor.urdf_import import imported_robot
from lagrangia.run.interpret import evaluate

ROBOT = """<?xml version="1.0"?>
<robot name="two-arm">
  <link name="world"/>
  <link name="base">
    <inertial><mass value="3"/><inertia ixx="1" iyy="1" izz="1"
      ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="upper">
    <inertial><origin xyz="0.1 0 0.2" rpy="0 0.3 0"/><mass value="2.5"/>
      <inertia ixx="0.1" iyy="0.12" izz="0.05" ixy="0.01" ixz="0" iyz="0.002"/></inertial>
    <visual><geometry><sphere radius="1"/></geometry></visual>
  </link>
  <link name="fore-arm">
    <inertial><origin xyz="0 0 0.2"/><mass value="1.5"/><inertia ixx="0.1" iyy="0.12" izz="0.05"
      ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="tool">
    <inertial><origin xyz="0.05 0 0.02"/><mass value="0.5"/><inertia ixx="0.001" iyy="0.0012" izz="0.0015"
      ixy="0" ixz="0" iyz="0"/></inertial></link>
  <link name="finger">
    <inertial><mass value="0.1"/><inertia ixx="0.0001" iyy="0.00012" izz="0.00015"
      ixy="0" ixz="0" iyz="0"/></inertial></link>
  <joint name="fix" type="fixed"><parent link="world"/><child link="base"/><origin xyz="0 0 0.5" rpy="0 0 0.2"/></joint>
  <joint name="shoulder" type="revolute"><parent link="base"/><child link="upper"/>
    <origin xyz="0 0 0.3" rpy="-1.5707963267948966 0 0"/><axis xyz="0 0 1"/>
    <limit lower="-2" upper="2.5" effort="80" velocity="2"/><dynamics damping="0.5"/></joint>
  <joint name="elbow" type="continuous"><parent link="upper"/><child link="fore-arm"/>
    <origin xyz="0.4 0.02 0.01" rpy="0.1 0.2 0.3"/><axis xyz="0 1 1"/></joint>
  <joint name="weld" type="fixed"><parent link="fore-arm"/><child link="tool"/>
    <origin xyz="0 0 0.5" rpy="0.2 0 1.5707963267948966"/></joint>
  <joint name="slide" type="prismatic"><parent link="tool"/><child link="finger"/>
    <origin xyz="0 0 0.1"/><axis xyz="1 0 0"/><limit lower="0" upper="0.05" effort="10" velocity="0.1"/></joint>
</robot>
"""
# Of pin.aba, Pinocchio 4.1.0, on pin.buildModelFromXML(ROBOT), with the torque -0.5 v of the damper on the shoulder.
PLACE, RATES, EXPECTED = (0.4, -0.7, 0.02), (0.9, -1.3, 0.1), (21.716217041134733, 3.1702047174856722, 4.475061266705942)


def accelerations(file: Path, q: tuple[float, ...], v: tuple[float, ...]) -> np.ndarray:
    scene = lag.load(file).scene
    c = hoisted(scene)
    return np.array(evaluate(scene.tapes["rhs"], [0.0], [*q], [*v], [], [], [*c])[0])


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("robot.urdf").write_text(ROBOT, encoding="utf-8")
    return tmp_path


def test_a_robot_falls_as_in_pinocchio(folder: Path) -> None:
    assert main(["import", "robot.urdf"]) == 0
    assert main(["format", "--check", "robot.lag"]) == 0
    found = accelerations(Path("robot.lag"), PLACE, RATES)
    assert np.abs(found - EXPECTED).max() <= 1e-12 * np.abs(EXPECTED).max()


def test_names_and_limits_stay(folder: Path) -> None:
    assert main(["import", "robot.urdf"]) == 0
    text = " ".join(Path("robot.lag").read_text(encoding="utf-8").split())
    assert "Frame 'fore-arm';" in text and "Body 'fore-arm_body'(center = shift('fore-arm', {0, 0, 0.2})" in text
    assert 'axis = {0, 0, 1}) "from -2 to 2.5 rad; torque up to 80 N.m; speed up to 2 rad/s";' in text
    assert "turn(shift(base, {0, 0, 0.3}), -pi/2, {1, 0, 0})" in text
    assert "I = {{0.1, 0.01, 0}, {0.01, 0.12, 0.002}, {0, 0.002, 0.05}}" in text
    assert "dissipation 0.5*shoulder.w^2/2;" in text


def test_what_has_no_counterpart_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = ROBOT.replace('damping="0.5"', 'damping="0.5" friction="0.2"').replace("</robot>", "<gazebo/><gazebo/></robot>")
    Path("robot.urdf").write_text(text.replace('type="continuous"', 'type="rope"'), encoding="utf-8")
    assert main(["import", "robot.urdf"]) == 1
    told = capsys.readouterr().err
    assert "<gazebo> in a robot, 2 of them" in told and "friction of joint shoulder, 0.2" in told
    assert "joint elbow of type 'rope': its child 'fore-arm' is joined to nothing now" in told


@pytest.mark.parametrize("kind", ["floating", "planar"])
def test_joints_of_several_coordinates_begin_where_they_are(kind: str) -> None:
    """A body in free fall, or in a plane whose normal lies aslant: where its link is, and how it falls."""
    text = ROBOT.replace("fore-arm", "fore").replace('<parent link="upper"/>', '<parent link="base"/>')

    def run(kind: str) -> tuple[np.ndarray, np.ndarray]:
        found = imported_robot("r", text.replace('type="continuous"', f'type="{kind}"').encode())
        assert not found.left_out
        run = lag.loads(found.text).simulate(at=[0.0, 0.1])
        return (np.array([run[f"fore.r[{i}]"] for i in (1, 2, 3)]),
                np.array([[run[f"fore.R[{i},{j}]"][0] for j in (1, 2, 3)] for i in (1, 2, 3)]))

    (r, R), (place, axes) = run(kind), run("fixed")
    assert np.abs(r[:, 0] - place[:, 0]).max() < 1e-12 and np.abs(R - axes).max() < 1e-12
    ahead = r[:, 1] - r[:, 0]
    assert ahead[2] < -0.01
    assert kind == "floating" or abs(ahead @ axes @ [0, 1, 1]) < 1e-12


def test_a_joint_that_mimics_another_follows_it() -> None:
    text = ROBOT.replace('effort="10" velocity="0.1"/>', 'effort="10" velocity="0.1"/><mimic joint="elbow" multiplier="0.1"/>')
    assert "slide.s = 0.1*elbow.phi;" in imported_robot("r", text.encode()).text


def test_what_rounding_left_of_moments_is_nothing() -> None:
    """A robot's head has ixz = 2.4e-35 and no other moment: no body has that."""
    moments = 'ixx="0.0001" iyy="0.00012" izz="0.00015"\n      ixy="0" ixz="0"'
    text = ROBOT.replace(moments, 'ixx="0" iyy="0" izz="0" ixy="0" ixz="2.4e-35"')
    assert "Body finger_body(center = finger, m = 0.1, I = {0, 0, 0});" in imported_robot("r", text.encode()).text


@pytest.mark.parametrize("change, told", [
    (('link="upper"/><child', 'link="uper"/><child'), "the parent of joint elbow is no link of the robot"),
    (('<child link="finger"/>', '<child link="upper"/>'), "the link 'upper' is the child of 2 joints: robots of URDF are trees"),
    (('xyz="0.4 0.02 0.01"', 'xyz="0.4 0.02"'), "'xyz' of <origin> is 3 numbers"),
    (('value="2.5"', 'value="heavy"'), "'value' of <mass> is a number"),
    (('<robot name="two-arm">', "<model>"), "this is no XML: mismatched tag"),
    (('<link name="tool">', "<link>"), "a link needs a name"),
    (('<link name="tool">', '<link name="upper">'), "there are two links of the name 'upper'"),
    (('<joint name="weld"', '<joint name="elbow"'), "there are two joints of the name 'elbow'"),
    (('<parent link="world"/>', '<parent link="finger"/>'), "carries itself"),
    (('effort="10" velocity="0.1"/>', 'effort="10" velocity="0.1"/><mimic joint="elbo"/>'),
     "what joint slide mimics is no joint of the robot"),
])
def test_wrong_robots(change: tuple[str, str], told: str) -> None:
    with pytest.raises(LagError, match=re.escape(told)) as error:
        imported_robot("robot.urdf", ROBOT.replace(*change).encode())
    assert "L0730" in str(error.value) and "robot.urdf:" in str(error.value)


def test_xacro_is_told() -> None:
    with pytest.raises(LagError, match="this is xacro"):
        imported_robot("r.urdf", ROBOT.replace("<link name=\"world\"/>", '<link name="world"/><xacro:arm/>').encode())


def test_a_file_of_xacro_is_told_by_its_name(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["import", str(tmp_path / "robot.urdf.xacro")]) == 2
    assert "run it first: xacro robot.urdf.xacro > robot.urdf" in capsys.readouterr().err
