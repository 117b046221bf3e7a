"""Solids in pictures: outlines and edges on paper, pages that are turned in a browser, glTF that others read."""

import json
import re
import shutil
import struct
import subprocess
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

from lagrangia.draw.animation import Curve
from lagrangia.draw.svg import write_svg
from lagrangia.solids.camera import Camera, page_at, strokes_at, usual
from lagrangia.solids.gltf import write_gltf
from lagrangia.solids.orbit import write_orbit
from lagrangia.solids.shapes import Solid, across, arrow, box, brake, coil, cylinder, sphere, turns_of
from lagrangia.solids.stage import Body, Line, Stage, matrices, quaternions

UP = np.array([0.0, 0.0, 1.0])
SOLIDS = {"box": box(1, 2, 3), "cylinder": cylinder(1, 2), "cone": cylinder(1, 2, 0.0), "sphere": sphere(1.0)}


def still(*pose: float) -> np.ndarray:
    return np.tile(np.array(pose, float), (2, 1))


def stage(*bodies: Body, lines: tuple[Line, ...] = ()) -> Stage:
    return Stage(np.array([0.0, 1.0]), bodies, lines, (), (), 0.1, UP)


@pytest.mark.parametrize("name", SOLIDS)
def test_solids_are_closed_and_convex_and_look_outwards(name: str) -> None:
    solid: Solid = SOLIDS[name]
    assert all(len(edge) == 4 for edge in solid.edges)
    assert len(solid.vertices) - len(solid.edges) + len(solid.faces) == 2, "Euler's formula of what is closed"
    for face, normal in zip(solid.faces, solid.normals, strict=True):
        heights = (solid.vertices - solid.vertices[face[0]]) @ normal
        assert heights.max() < 1e-9 and heights.min() < -0.1


def test_volumes() -> None:
    def volume(solid: Solid) -> float:
        total = 0.0
        for face in solid.faces:
            a, *rest = (solid.vertices[k] for k in face)
            total += sum(float(a @ np.cross(b, c)) / 6 for b, c in pairwise(rest))
        return total

    assert volume(SOLIDS["box"]) == pytest.approx(6)
    assert volume(SOLIDS["cylinder"]) == pytest.approx(2 * 18 * np.sin(np.pi / 18), rel=1e-12)
    assert volume(SOLIDS["cone"]) == pytest.approx(2 * np.pi / 3, rel=0.02)
    assert volume(SOLIDS["sphere"]) == pytest.approx(4 * np.pi / 3, rel=0.06)


def test_a_coil_reaches_from_end_to_end_and_winds_about_the_way() -> None:
    a, b = np.array([1.0, 2.0, 3.0]), np.array([-1.0, 0.5, 4.0])
    points = coil(a, b, 0.2, 7)
    way = (b - a) / np.linalg.norm(b - a)
    assert np.array_equal(points[0], a) and np.array_equal(points[-1], b)
    inner = points[1:-1] - a
    assert np.linalg.norm(inner - np.outer(inner @ way, way), axis=1) == pytest.approx(0.2)
    assert turns_of(a[None], b[None], 0.1) == 16 and turns_of(a[None], a[None], 0.1) == 4
    assert np.isfinite(coil(a, a, 0.2, 5)).all()
    assert arrow(a[None], b[None], 0.1).shape == (1, 5, 3)
    for shoe in brake(a[None], way[None], 0.1):
        assert np.allclose((shoe[0] - a) @ way, 0, atol=1e-12) and np.ptp(np.linalg.norm(shoe[0] - a, axis=1)) < 1e-12


def test_turns_become_quaternions_and_back() -> None:
    chance = np.random.default_rng(1)
    turns = matrices(chance.normal(size=(40, 4)))
    assert np.abs(turns @ turns.transpose(0, 2, 1) - np.eye(3)).max() < 1e-15 * 8
    found = quaternions(turns)
    assert np.abs(matrices(found) - turns).max() < 1e-14 and found[0, 0] >= 0
    angles = np.linspace(0, 20, 200)
    about_z = np.stack([np.cos(angles / 2), 0 * angles, 0 * angles, np.sin(angles / 2)], axis=1)
    assert np.abs(quaternions(matrices(about_z)) - about_z).max() < 1e-14, "continuous in its sign over several turns"
    for axis in ([0, 0, 1], [0, 0, -2], [1, 2, 3]):
        turn = across(np.array(axis, float))
        assert np.allclose(turn @ [0, 0, 1], np.array(axis) / np.linalg.norm(axis)) and np.linalg.det(turn) == pytest.approx(1)


def test_a_cube_from_its_corner_is_a_hexagon_with_three_edges_inside() -> None:
    camera = Camera(np.pi / 4, np.arctan(np.sqrt(0.5)), UP)
    outline, *edges = strokes_at(stage(Body(box(1, 1, 1), still(0, 0, 0, 1, 0, 0, 0))), 0, camera)
    assert len(outline.points) == 6 and outline.is_closed and outline.fill == "white"
    assert np.linalg.norm(outline.points, axis=1) == pytest.approx(np.sqrt(2 / 3))
    assert len(edges) == 3
    assert np.allclose([edge.points[np.linalg.norm(edge.points, axis=1).argmin()] for edge in edges], 0, atol=1e-12)


def test_what_is_nearer_is_drawn_later() -> None:
    camera = Camera(-np.pi / 2, 0.0, UP)  # from -y
    assert camera.axes == pytest.approx(np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]]), abs=1e-15)
    far, near = Body(sphere(1.0), still(0, 5, 0, 1, 0, 0, 0), "grey"), Body(sphere(1.0), still(0, -5, 0, 1, 0, 0, 0), "black")
    for bodies in ((far, near), (near, far)):
        assert [stroke.fill for stroke in strokes_at(stage(*bodies), 0, camera)] == ["grey", "black"]
    gone = Body(sphere(1.0), still(np.nan, 0, 0, 1, 0, 0, 0))
    assert strokes_at(stage(gone, lines=(Line(np.full((2, 2, 3), np.nan)),)), 0, camera) == []


def moving() -> Stage:
    """A cone that turns about its own axis while it rises, a coil and a line beside it."""
    t = np.linspace(0, 1, 5)
    poses = np.stack([0 * t, 0 * t, t, np.cos(t), 0 * t, 0 * t, np.sin(t)], axis=1)
    ends = np.stack([np.zeros((5, 3)), np.stack([0 * t, 1 + t, 0 * t], axis=1)], axis=1)
    plate = Body(box(1, 1, 0.1), np.tile([0, 0, -0.5, 1, 0, 0, 0.0], (5, 1)), "grey")
    lines = Line(ends, turns=6, radius=0.05), Line(ends[:, ::-1], "dashed")
    return Stage(t, (Body(cylinder(0.3, 0.5, 0.0), poses), plate), lines, (), (("tip", poses[:, :3]),), 0.1, UP)


def test_paper() -> None:
    text = write_svg(page_at(moving(), 4, usual(UP), "cone"))
    assert text.count("<polygon") == 2 and "stroke-dasharray" in text and "<title>cone</title>" in text
    first, last = (page_at(moving(), k, usual(UP), whole=True) for k in (0, 4))
    assert (first.width, first.height) == (last.width, last.height), "pictures of a film are alike"


def test_gltf_is_whole_and_says_where_everything_is() -> None:
    data = write_gltf(moving())
    assert struct.unpack("<4sII", data[:12]) == (b"glTF", 2, len(data))
    size, kind = struct.unpack("<I4s", data[12:20])
    told = json.loads(data[20 : 20 + size])
    binary = data[28 + size :]
    assert kind == b"JSON" and struct.unpack("<I4s", data[20 + size : 28 + size]) == (len(binary), b"BIN\0")
    assert len(binary) == told["buffers"][0]["byteLength"] and size % 4 == len(binary) % 4 == 0

    def numbers(k: int) -> np.ndarray:
        accessor = told["accessors"][k]
        view = told["bufferViews"][accessor["bufferView"]]
        kind = {5126: "<f4", 5125: "<u4"}[accessor["componentType"]]
        found = np.frombuffer(binary[view["byteOffset"] :][: view["byteLength"]], kind)
        wide = {"SCALAR": 1, "VEC3": 3, "VEC4": 4}[accessor["type"]]
        assert len(found) == wide * accessor["count"]
        return found.reshape(-1, wide)

    (animation,) = told["animations"]
    of = {(c["target"]["node"], c["target"]["path"]): animation["samplers"][c["sampler"]] for c in animation["channels"]}
    assert np.allclose(numbers(of[0, "translation"]["output"])[:, 2], numbers(of[0, "translation"]["input"])[:, 0])
    assert np.allclose(np.linalg.norm(numbers(of[0, "rotation"]["output"]), axis=1), 1)
    assert np.allclose(numbers(of[0, "rotation"]["output"])[-1], [0, 0, np.sin(1), np.cos(1)], atol=1e-6), "real part last"
    assert (1, "translation") not in of, "what stands has no track"
    assert np.allclose(numbers(of[2, "scale"]["output"])[:, 2], np.linspace(1, 2, 5)), "the coil is stretched"
    assert [told["meshes"][node["mesh"]]["primitives"][0].get("mode", 4) for node in told["nodes"][:4]] == [4, 4, 3, 3]
    x, y, z, w = told["nodes"][-1]["rotation"]
    assert matrices(np.array([w, x, y, z])) @ UP == pytest.approx([0, 1, 0]), "y is up there"
    assert write_gltf(stage())[:4] == b"glTF"


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser") or shutil.which("google-chrome")


@pytest.mark.skipif(BROWSER is None, reason="needs a browser")
def test_a_page_is_turned_and_played_in_a_browser(tmp_path: Path) -> None:
    """Pixels of the middle say whether something is seen; the eye turns, zooms, comes back."""
    curve = Curve("z", "m", np.linspace(0, 1, 5))
    page = write_orbit(moving(), "a <cone>", [curve], [curve], np.array([0.5]))
    assert "http" not in page.replace("http://www.w3.org", "") and "<title>a &lt;cone&gt;</title>" in page
    asked = """
<script>
const told = [], c = $("scene"), box = c.getBoundingClientRect();
const dark = () => c.getContext("2d").getImageData(0, 0, c.width, c.height).data.filter((x, k) => k % 4 === 3 && x > 0).length;
told.push(lagrangia.eye.azimuth.toFixed(3), dark() > 1000);
const fire = (kind, x, y) => c.dispatchEvent(new PointerEvent(kind, { pointerId: 1, clientX: x, clientY: y, buttons: 1 }));
c.setPointerCapture = () => {};
fire("pointerdown", 100, 100); fire("pointermove", 200, 100); fire("pointerup", 200, 100);
told.push(lagrangia.eye.azimuth.toFixed(3));
c.dispatchEvent(new WheelEvent("wheel", { deltaY: -500, clientX: 280, clientY: 250 }));
told.push(lagrangia.eye.zoom > 1.5, dark() > 1000);
document.querySelectorAll("[data-view]")[3].click(); told.push(lagrangia.eye.elevation.toFixed(3));
c.dispatchEvent(new MouseEvent("dblclick")); told.push(lagrangia.eye.zoom);
lagrangia.go(0.375); told.push(lagrangia.time, lagrangia.value("z").toFixed(3));
document.title = told.join(" ");
</script></body>"""
    (tmp_path / "page.html").write_text(page.replace("</body>", asked), encoding="utf-8")
    done = subprocess.run([str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", "--window-size=900,600", "--dump-dom",
                           (tmp_path / "page.html").as_uri()], capture_output=True, text=True, timeout=60, check=False)
    title = re.search(r"<title>(.*?)</title>", done.stdout)
    assert title is not None
    assert title[1].split() == ["-1.047", "true", "-1.847", "true", "true", "1.571", "1", "0.375", "0.375"]
