"""Scenes in space in pictures, films and pages, by the command and from Python; what is of the plane alone says so."""

import json
import re
import struct
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import main
from lagrangia.solids.showing import stage_of

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
ZOO = """model Zoo "one of each"
  World world(gravity = {0, 0, -9.81});
  Universal u(a = world, phi_a(start = 0.4), phi_b(start = 0.3));
  Cylinder c(m = 1, r = 0.1, h = 0.4, center = shift(u.b, {0, 0, -0.5}));
  Cylindrical cy(a = shift(world, {1, 0, 0}), axis = {1, 1, 1}, w(start = 2));
  Box b(m = 1, size = {0.3, 0.2, 0.1}, center = cy.b);
  Screw sc(a = shift(world, {0, 1, 0}), pitch = 0.2, w(start = 3));
  Cone k(m = 1, r = 0.2, h = 0.5, center = sc.b);
  Prismatic p(a = shift(world, {1, 1, 0}), along = {0, 1, 1}, v(start = 1));
  Disc d(m = 1, r = 0.2, center = p.b);
  Revolute h(a = shift(world, {-1, 0, 0.3}), axis = {0, 1, 0}, phi(start = 1));
  Ball ball(m = 1, r = 0.15, center = shift(h.b, {0, 0, -0.7}));
  BodyForce f(at = ball.center, force = {0, 3, 1});
  AppliedTorque t(on = c.center, torque = {0, 0, 2});
drawing
  trace(ball.center);
  polygon(shift(world, {2, 2, 0}), shift(world, {2, 3, 0}), {2, 2.5, 1}, style = "dashed");
end Zoo;
"""
FLAT = "model Flat Revolute h(a = world); Bar bar(m = 1, L = 1, a = h.b); end Flat;"


@pytest.fixture
def zoo(tmp_path: Path) -> Path:
    file = tmp_path / "zoo.lag"
    file.write_text(ZOO)
    return file


def test_a_drawing_has_each_body_and_its_name(zoo: Path) -> None:
    model = lag.load(zoo)
    text = model.draw()
    assert text.count("<circle") == 2, "the ball, and the hub of the disc"
    for words in ("m_ball", "t.torque", "m_b", "f"):
        pieces = "".join(f"<tspan[^>]*>{part}</tspan>" for part in words.split("_"))
        assert re.search(pieces, text), words
    assert "stroke-dasharray" in text and "<title>one of each</title>" in text
    above, front = model.draw(view=(-90, 90)), model.draw(view=(-90, 0))
    assert len({text, above, front}) == 3


def test_a_run_becomes_a_page_a_film_and_gltf(zoo: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for name in ("zoo.html", "zoo.gif", "zoo.glb"):
        assert main(["animate", str(zoo), "--stop", "0.2", "--interval", "0.1", "-o", str(zoo.parent / name)]) == 0
    page = (zoo.parent / "zoo.html").read_text(encoding="utf-8")
    told = json.loads(re.findall(r'<script id="data" type="application/json">(.*?)</script>', page)[0])
    assert len(told["bodies"]) == 13 and [t["name"] for t in told["traces"]] == ["ball.center"]
    assert told["up"] == [0, 0, 9.81]
    data = (zoo.parent / "zoo.glb").read_bytes()
    size = struct.unpack("<I", data[12:16])[0]
    scene = json.loads(data[20 : 20 + size])
    assert scene["animations"][0]["channels"] and len(scene["nodes"]) > len(told["bodies"])
    names = [node.get("name") for node in scene["nodes"]]
    assert {"u", "c", "b", "k", "d", "ball", "f", "t"} <= {*names}, "viewers show the components"
    at = [scene["nodes"][names.index(name)]["translation"] for name in ("ball", "c")]
    known = [[-1 - 0.7 * np.sin(1), 0, 0.3 - 0.7 * np.cos(1)], lag.load(zoo).simulate(at=[0])["c.center.r"][0]]
    assert np.allclose(at, known, atol=1e-6), "where they are"
    assert capsys.readouterr().err == ""


def test_poses_are_those_of_the_run(zoo: Path) -> None:
    """The ball hangs 0.7 m below its hinge and turns about y."""
    from lagrangia.solids.showing import stage_of

    run = lag.load(zoo).simulate(stop=0.5, interval=0.25)
    stage = stage_of(run, {}, ["ball.center"])
    phi = np.asarray(run["h.phi"])
    centres = np.stack([-1 - 0.7 * np.sin(phi), 0 * phi, 0.3 - 0.7 * np.cos(phi)], axis=1)
    assert np.abs(stage.traces[-1][1] - centres).max() < 1e-14
    (ball,) = (body for body in stage.bodies if body.solid.radius == 0.15)
    assert np.abs(ball.poses[:, :3] - centres).max() < 1e-14
    assert np.abs(ball.poses[:, 3:] - np.stack([np.cos(phi / 2), 0 * phi, np.sin(phi / 2), 0 * phi], axis=1)).max() < 1e-14


@pytest.mark.parametrize(("arguments", "told"), [
    (["animate", "zoo.lag", "-o", "x.svg"], "moving SVG of scenes in space"),
    (["animate", "zoo.lag", "--stroboscope", "3"], "many positions of a scene in space"),
    (["animate", "zoo.lag", "--beside", "u.phi_a=1"], "several runs in one picture of a scene in space"),
    (["animate", "flat.lag", "-o", "x.glb"], "glTF, which is of scenes in space"),
    (["draw", "flat.lag", "--view=1,2"], "this one lies in the plane"),
    (["draw", "zoo.lag", "--view=1"], "an azimuth and an elevation from -90 to 90"),
    (["draw", "zoo.lag", "--view=1,inf"], "an azimuth and an elevation from -90 to 90"),
    (["draw", "wrong.lag"], "'ball' is drawn in space, and this scene lies in the plane"),
])
def test_what_is_not_there_is_told(zoo: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
                                   arguments: list[str], told: str) -> None:
    monkeypatch.chdir(zoo.parent)
    Path("flat.lag").write_text(FLAT)
    Path("wrong.lag").write_text(FLAT.replace("end Flat", "drawing ball(bar.center, 0.1); end Flat"))
    assert main(arguments) == 2
    assert told in capsys.readouterr().err
    assert sorted(path.name for path in zoo.parent.iterdir()) == ["flat.lag", "wrong.lag", "zoo.lag"]


def test_what_floats_without_weight_is_drawn_and_turns_as_it_does() -> None:
    """The poses of a satellite are those of its quaternion, whatever its attitude is counted against."""
    from lagrangia.solids.showing import stage_of

    model = lag.load(data_folder("models") / "examples" / "satellite.lag")
    run = model.simulate(stop=20, interval=5)
    stage = stage_of(run, {}, [])
    hull = stage.bodies[0]
    turned = np.stack([np.asarray(run[f"hull.center.S[{k}]"]) for k in range(1, 5)], axis=1)
    same = np.abs(np.sum(hull.poses[:, 3:] * turned, axis=1))
    assert np.abs(same - 1).max() < 1e-14 and np.ptp(turned, axis=0).max() > 0.1
    assert (stage.up == [0, 0, 1]).all() and "<circle" in model.draw()


def test_what_turns_unseen_between_two_pictures_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """500 rows of 60 s of a wheel at 100 rad/s are 1.9 turns apart: a page or a .glb shows another turn."""
    scene = tmp_path / "wheel.lag"
    scene.write_text("""model Wheel
      World world(gravity = {0, 0, -9.81});
      Revolute spin(a = world, axis = {1, 0, 0}, w(start = 100)); Disc wheel(m = 1, r = 0.1, center = spin.b);
      Revolute tip(a = spin.b, axis = {0, 1, 0}); Body rod(m = 1, I = {1, 1, 2}, center = tip.b);
    end Wheel;""")
    for stop, is_told in (("60", True), ("1", False)):
        assert main(["animate", str(scene), "--stop", stop, "-o", str(tmp_path / "wheel.glb")]) == 0
        assert ("turns from one picture to the next" in capsys.readouterr().err) == is_told


def test_symbols_are_as_large_as_a_scene_and_not_as_its_way() -> None:
    """A bicycle that rode 9 m had joints larger than its wheels."""
    model = lag.load(EXAMPLES / "bicycle.lag")
    still, ridden = (stage_of(model.simulate(at=at), {}, ()) for at in ([0], [0, 1, 2]))
    assert ridden.symbol == pytest.approx(still.symbol, rel=0.05) and still.symbol < 0.15
