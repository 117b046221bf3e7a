"""Modes that play: the shape about the point, loops closed, as fast as it vibrates."""

import base64
import json
import re
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import WRONG, main
from lagrangia.draw.modes_film import swaying

EXAMPLES = data_folder("models") / "examples"


def data_of(page: str) -> dict:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def test_a_mode_sways_in_its_shape_with_its_period(tmp_path: Path) -> None:
    """The bar's second mode: its ends move against each other in the ratio of the shape."""
    page = tmp_path / "mode.html"
    assert main(["modes", str(EXAMPLES / "suspended_bar.lag"), "--animate", str(page), "--mode", "2"]) == 0
    mode = lag.load(EXAMPLES / "suspended_bar.lag").modes()[1]
    data = data_of(page.read_text())
    t = np.frombuffer(base64.b64decode(data["t"]), dtype="<f8")
    assert t[-1] == pytest.approx(4 / mode.frequency)
    poses = [np.frombuffer(base64.b64decode(s["poses"]), dtype="<f4").reshape(-1, 3) for s in data["strokes"] if "poses" in s]
    bar = max(poses, key=lambda p: np.ptp(p[:, 2]))
    angle = bar[:, 2] - bar[0, 2]
    largest = float(np.abs(angle).max())
    assert largest > 0.05
    np.testing.assert_allclose(angle, largest * np.sign(angle[9]) * np.sin(2 * np.pi * mode.frequency * t), atol=1e-5)
    assert not data["energies"]
    assert f"mode 2: {mode.title}" in page.read_text()


def test_loops_stay_closed() -> None:
    model = lag.load(EXAMPLES / "four_bar.lag")
    study, gap = model.study(), model.functions()["Phi"]
    modes = study.modes("equilibrium", False)
    q = np.array([modes.linearization.point[name] for name in modes.coordinates])
    beside = q + 0.3 * modes.shapes[:, 0] / np.abs(modes.shapes[:, 0]).max()
    open_by, left = (float(np.abs(np.array(gap(0, x, 0 * x, [], study.p))).max()) for x in (beside, study.closing(beside)))
    assert open_by > 1e-3
    assert left < 1e-9


def test_places_of_a_period_are_closed_once(monkeypatch: pytest.MonkeyPatch) -> None:
    """sin goes through each of its values again and again."""
    study = lag.load(EXAMPLES / "four_bar.lag").study()
    modes, closed = study.modes("equilibrium", False), []
    monkeypatch.setattr("lagrangia.study.motion_numbers.onto_constraints", lambda _, q, free: closed.append(q) or q)
    t, states = swaying(study, modes, 0, 0.1)
    assert len(closed) == 19 and states.q.shape[1] == t.size == 145
    assert np.abs(states.q[:, :36] - states.q[:, 36:72]).max() < 1e-12


@pytest.mark.parametrize("options", [["--mode", "2"], ["--animate", "x.html", "--mode", "9"], ["--animate", "x.csv"]])
def test_wrong_options_are_told(options: list[str], capfd: pytest.CaptureFixture[str]) -> None:
    assert main(["modes", str(EXAMPLES / "suspended_bar.lag"), *options]) == WRONG
    assert capfd.readouterr().err.startswith("error[L")


def test_modes_sway_in_space(tmp_path: Path) -> None:
    """Of a ball joint about its own attitude, as far as its shape says."""
    scene, page = tmp_path / "hang.lag", tmp_path / "mode.html"
    scene.write_text("""model Hang
      World world(gravity = {0, 0, -9.81});
      Spherical s(a = world, S(start = angles("zxz", 0.3, 0.2, 0)));
      Cylinder c(m = 1, r = 0.05, h = 0.5, center = shift(s.b, {0, 0, -0.25}));
    end Hang;""")
    modes = lag.load(scene).modes()
    k = next(k for k in range(3) if modes[k].frequency and modes[k].frequency > 0.1)
    assert main(["modes", str(scene), "--animate", str(page), "--mode", str(k + 1), "--view=10,20"]) == 0
    data = data_of(page.read_text())
    t = np.frombuffer(base64.b64decode(data["t"]), dtype="<f8")
    assert t[-1] == pytest.approx(4 / modes[k].frequency)
    poses = [np.frombuffer(base64.b64decode(body["poses"]), dtype="<f4").reshape(-1, 7) for body in data["bodies"]]
    rod = max(poses, key=lambda p: np.ptp(p[:, :3]))
    turns = 2 * np.arccos(np.clip(np.abs(rod[:, 3:] @ rod[0, 3:]), 0, 1))
    sines = np.abs(np.sin(2 * np.pi * modes[k].frequency * t))
    assert 0.05 < turns.max() < 0.6
    np.testing.assert_allclose(np.tan(turns / 4), np.tan(turns.max() / 4) * sines, atol=1e-3)
    assert main(["modes", str(scene), "--animate", str(tmp_path / "mode.glb")]) == 0
    for name in ("mode.svg", "mode.csv"):
        assert main(["modes", str(scene), "--animate", str(tmp_path / name)]) == WRONG
    assert main(["modes", str(EXAMPLES / "suspended_bar.lag"), "--animate", str(page), "--view=1,2"]) == WRONG
