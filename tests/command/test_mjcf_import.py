"""`lag import` of scenes in MJCF: accelerations beside MuJoCo's, names, limits, and what is told of what has no counterpart."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.bench.clock import hoisted
from lagrangia.command.cli import main
from lagrangia.run.interpret import evaluate

SCENE = """<mujoco model="two legs">
  <compiler angle="degree" eulerseq="zyx" settotalmass="7"/>
  <option gravity="0 0.5 -9.81"/>
  <default>
    <joint damping="0.3"/>
    <geom density="900" contype="0" conaffinity="0"/>
    <default class="light">
      <joint armature="0.02" stiffness="4" springref="20"/>
      <default class="lighter"><geom density="400"/></default>
    </default>
  </default>
  <worldbody>
    <geom type="plane" size="1 1 1"/>
    <body name="trunk" pos="0.1 0 1.2" euler="30 0 20">
      <joint name="lift" type="slide" axis="0 1 2" ref="0.1" pos="0.1 0.2 0.3"/>
      <joint name="sway" axis="1 0.5 0" pos="0.05 0 0.1" ref="15" range="-40 50"/>
      <geom type="capsule" fromto="0 0 -0.2 0.1 0 0.3" size="0.06"/>
      <geom type="box" size="0.1 0.05 0.08" pos="0 0.1 0" axisangle="1 1 0 40"/>
      <body name="swing" pos="0 0.1 -0.3" zaxis="0 1 1" childclass="light">
        <joint name="hip" pos="0 0 0.05" axis="0 1 0"/>
        <geom type="ellipsoid" size="0.05 0.07 0.2" quat="1 0.2 0 0.1"/>
        <frame pos="0 0 -0.2" xyaxes="0 1 0 -1 0 0.2">
          <geom class="lighter" type="cylinder" size="0.04 0.1" pos="0.02 0 0"/>
          <body name="foot" pos="0.1 0 0">
            <joint name="ankle" type="ball" class="main" damping="0.05" pos="0 0.01 0"/>
            <inertial pos="0.01 0.02 -0.03" euler="10 20 30" mass="0.8" diaginertia="0.004 0.003 0.002"/>
          </body>
        </frame>
      </body>
      <body name="fixed part" pos="0 -0.1 0"><geom type="sphere" size="0.05"/></body>
    </body>
    <body name="free part" pos="1 0 2" quat="1 1 0 0">
      <freejoint/>
      <inertial pos="0.1 0 0" mass="0.5" fullinertia="0.02 0.03 0.04 0.001 0.002 -0.003"/>
    </body>
  </worldbody>
  <actuator>
    <position name="hold" joint="hip" kp="30" kv="2" gear="1.5"/>
    <motor name="push" joint="lift" gear="3" ctrlrange="-1 1"/>
  </actuator>
</mujoco>
"""
# qacc of MuJoCo 4.0.0 after mj_forward, without limits, with the commands 0.25 and -0.5.
PLACE = {"lift.s": 0.17, "sway.phi": 0.6617993877991495, "hip.phi": -0.6}
RATES = 0.3, -0.8, 1.1, 0.5, -0.4, 0.9, 0.2, -0.1, 0.3, 1.2, -0.7, 0.6
EXPECTED = (4.513210012307704, -24.879186439984643, 764.8087201918478, -1757.9113791467346, 43.37087390559665, -782.3337002011731,
            0.08500000000000005, 0.5054226995940461, -9.751464563599459, 0.29074678619756456, 0.6657730040595402,
            0.2546456359945868)
STARTS = (1.0, 0.0, 0.0, 0.0), (0.7071067811865475, 0.7071067811865475, 0.0, 0.0)  # of the attitudes, in MuJoCo as well


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("scene.xml").write_text(SCENE, encoding="utf-8")
    return tmp_path


def imported_text(text: str) -> str:
    """Of a scene, with the spaces of one line."""
    Path("scene.xml").write_text(text, encoding="utf-8")
    assert main(["import", "scene.xml", "-o", "scene.lag"]) in (0, 1)
    return " ".join(Path("scene.lag").read_text(encoding="utf-8").split())


def test_a_scene_moves_as_in_mujoco(folder: Path) -> None:
    assert main(["import", "scene.xml"]) == 0
    assert main(["format", "--check", "scene.lag"]) == 0
    scene = lag.load("scene.lag").scene
    names = [coordinate.name for coordinate in scene.coordinates]
    c = hoisted(scene)
    q = [PLACE.get(name, 0.0) for name in names]
    q[names.index("'free part_joint'.x")], q[names.index("'free part_joint'.z")] = 1.0, 2.0
    found = evaluate(scene.tapes["rhs"], [0.0], q, [*RATES], [0.25, -0.5], [x for start in STARTS for x in start], [*c])[0]
    assert np.abs(np.array(found) - EXPECTED).max() <= 1e-12 * np.abs(EXPECTED).max()


def test_names_and_limits_stay(folder: Path) -> None:
    text = imported_text(SCENE)
    assert "Spherical ankle(" in text and "Frame 'fixed part';" in text and "input Real push \"command from -1 to 1\";" in text
    assert 'phi(start = 0.2617993877991494)) "from -0.6981317007977318 to 0.8726646259971648 rad";' in text
    assert "work 45*hold - 67.5*hip.phi - 4.5*hip.w on hip.phi;" in text
    assert "potential 4*(hip.phi - 0.3490658503988659)^2/2;" in text


FRAMES = """<mujoco>
  <default><general gear="5"/><default class="c"><joint damping="7"/></default></default>
  <worldbody><body name="a" pos="0 0 1">
    <frame pos="0 0.1 0.2" euler="90 0 0" childclass="c"><frame pos="0.1 0 0" euler="0 30 0">
      <joint name="j" axis="0 0 1" pos="0 0.1 0" ref="20" actuatorfrcrange="-2 3"/></frame>
      <joint name="k" axis="0 1 0" pos="0 0 0.3" class="main"/></frame>
    <geom type="box" size="0.1 0.2 0.3" contype="0" conaffinity="0"/>
  </body></worldbody>
  <actuator><motor name="mo" joint="j"/></actuator>
</mujoco>"""


def test_joints_stand_in_frames_and_motors_have_the_defaults_of_all(folder: Path) -> None:
    """That it moves so in MuJoCo 4.0.0 was looked at, to 3e-16."""
    text = imported_text(FRAMES)
    assert "axis = {0.4999999999999999, -0.8660254037844386, 0}, phi(start = 0.3490658503988659))" in text
    assert '"motors from -2 to 3 N.m";' in text and "b = a_at2, axis = {0, 0, 1});" in text
    assert "work 5*mo on j.phi;" in text and "dissipation 7*j.w^2/2;" in text and "k.w" not in text


def test_a_joint_follows_another(folder: Path) -> None:
    follows = '<equality><joint joint1="hip" joint2="sway" polycoef="0.1 2 0 -1"/></equality></mujoco>'
    text = imported_text(SCENE.replace("</mujoco>", follows))
    assert "hip.phi = 0.1 + 2*(sway.phi - 0.2617993877991494) - 1*(sway.phi - 0.2617993877991494)^3;" in text


def test_files_are_included(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    part = SCENE[SCENE.index("  <default>"): SCENE.index("  <worldbody>")]
    whole = imported_text(SCENE)
    for root in ("mujoco", "mujocoinclude", "parts"):  # of any name, as MuJoCo's reader takes it
        Path("part.xml").write_text(f"<{root}>{part}</{root}>", encoding="utf-8")
        assert imported_text(SCENE.replace(part, '<include file="part.xml"/>')) == whole
    Path("part.xml").write_text('<mujoco><include file="part.xml"/></mujoco>', encoding="utf-8")
    assert main(["import", "scene.xml", "-o", "scene.lag"]) == 2
    assert "these files include each other" in capsys.readouterr().err


def test_of_what_is_included_and_is_no_scene_no_line_is_shown(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A scene of others names a file of one's own; and files that include others twice are no work without end."""
    Path("scene.xml").write_text('<mujoco><include file="secret"/><worldbody/></mujoco>', encoding="utf-8")
    Path("secret").write_text("account: anna, pass phrase: mountain", encoding="utf-8")
    assert main(["import", "scene.xml"]) == 2
    said = capsys.readouterr().err
    assert "'secret' cannot be included" in said and "scene.xml:1:" in said and "mountain" not in said
    for k in range(12):
        Path(f"s{k}.xml").write_text("<mujoco>" + f'<include file="s{k + 1}.xml"/>' * 2 + "</mujoco>", encoding="utf-8")
    Path("s12.xml").write_text("<mujoco/>", encoding="utf-8")
    assert main(["import", "s0.xml"]) == 2
    assert "more than 1000 files are included" in capsys.readouterr().err


def test_what_has_no_counterpart_is_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = SCENE.replace('contype="0" conaffinity="0"', "").replace('kv="2"', 'kv="2" timeconst="0.1"')
    text = text.replace('name="ankle" type="ball"', 'name="ankle" type="ball" stiffness="3"')
    Path("scene.xml").write_text(text.replace("</mujoco>", "<tendon/></mujoco>"), encoding="utf-8")
    assert main(["import", "scene.xml"]) == 1
    told = capsys.readouterr().err
    for what in ("contact between shapes", "<position> hold", "stiffness of joint ankle", "<tendon>"):
        assert f"no counterpart: {what}\n" in told


def test_attributes_that_nothing_reads_are_told(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = SCENE.replace('<joint damping="0.3"/>', '<joint dampng="0.3"/>').replace('gravity="0 0.5', 'grvity="0 0.5')
    text = text.replace('name="swing"', 'name="swing" gravcomp="1"').replace("fullinertia=", 'moment="3" fullinertia=')
    text = text.replace("</worldbody>", '<body><composite type="cable"><joint kind="main"/></composite></body></worldbody>')
    Path("scene.xml").write_text(text, encoding="utf-8")
    assert main(["import", "scene.xml"]) == 1
    told = [line for line in capsys.readouterr().err.splitlines() if "no counterpart" in line]
    assert [line for line in told if "<composite> in a body" in line] and not [line for line in told if "kind" in line]
    assert len(told) == 5
    for what in ("dampng of <joint>, which is unknown (did you mean 'damping'?)", "grvity of <option>", "gravcomp of body swing",
                 "moment of <inertial>"):
        assert any(what in line for line in told)


@pytest.mark.parametrize("change, told", [
    (('class="lighter" type', 'class="heavy" type'), "there is no class of defaults 'heavy'"),
    (('axis="0 1 2"', 'axis="0 0 0"'), "the axis of joint lift has no direction"),
    (('type="ball"', 'type="balls"'), "there is no joint of type 'balls'"),
    (('zaxis="0 1 1"', 'zaxis="0 1 1" quat="1 0 0 0"'), "both say how <body> is turned"),
    (('quat="1 0.2 0 0.1"', 'quat="0 0 0 0"'), "'quat' of <geom> has no direction"),
    (('mass="0.8"', 'mass="heavy"'), "'mass' of <inertial> is a number"),
    (("<freejoint/>", '<freejoint/><joint type="hinge"/>'), "a free joint is the only one of its body"),
    (('size="0.06"', 'size="0"'), "a capsule has sizes above zero"),
    (('size="0.06"', 'size="1e150"'), "beyond all numbers"),
    (("<worldbody>", '<include file="nothing.xml"/><worldbody>'), "there is no file 'nothing.xml' to include"),
    (('<mujoco model="two legs">', "<model>"), "this is no XML"),
    (('eulerseq="zyx"', 'eulerseq="zzz1"'), "'eulerseq' is three of the letters"),
    (('settotalmass="7"', 'settotalmass="much"'), "'settotalmass' of <compiler> is a number"),
    (('angle="degree"', 'angle="gradian"'), "'angle' is degree or radian"),
    (('range="-40 50"', 'range="50 -40"'), "'range' ends below where it begins"),
    (('name="sway"', 'name="lift"'), "there are two joints of the name 'lift'"),
    (("<worldbody>", '<worldbody><body name="trunk"/>'), "there are two bodies of the name 'trunk'"),
])
def test_wrong_scenes(folder: Path, change: tuple[str, str], told: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("scene.xml").write_text(SCENE.replace(*change), encoding="utf-8")
    assert main(["import", "scene.xml"]) == 2
    said = capsys.readouterr().err
    assert told in said and "error[L0730]" in said and "scene.xml:" in said


@pytest.mark.parametrize("text, told", [
    ("<html/>", "neither a scene in MJCF nor a robot but <html>"),
    ("<mujoco/>", "there is no body in this scene"),
    ("<mujoco><worldbody>" + "<body>" * 300 + "</body>" * 300 + "</worldbody></mujoco>", "elements more than 250 deep"),
])
def test_what_is_no_scene(folder: Path, text: str, told: str, capsys: pytest.CaptureFixture[str]) -> None:
    Path("scene.xml").write_text(text, encoding="utf-8")
    assert main(["import", "scene.xml"]) == 2
    assert told in capsys.readouterr().err


def test_a_long_chain_of_bodies(folder: Path) -> None:
    body = '<body pos="0 0 -1"><joint axis="0 1 0"/><geom size="0.1" contype="0" conaffinity="0"/>'
    text = imported_text("<mujoco><worldbody>" + body * 240 + "</body>" * 240 + "</worldbody></mujoco>")
    assert text.count("Revolute ") == 240 and "Body body240_body(center = body240, " in text


def test_names_stand_on_one_line(folder: Path) -> None:
    Path("scene.xml").write_text(SCENE.replace('name="sway"', 'name="sway&#10;}"'), encoding="utf-8")
    assert main(["import", "scene.xml", "-o", "scene.lag"]) in (0, 1)
    assert main(["check", "scene.lag"]) == 0
