"""Pages that play: their numbers are the run's; films have a picture for each position; what fails is shown as far as it went."""

import base64
import json
import re
import shutil
import subprocess
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import FAILED, WRONG, main

EXAMPLES = data_folder("models") / "examples"


def data_of(page: str) -> dict:
    found = re.search(r'<script id="data" type="application/json">(.*?)</script>', page, re.DOTALL)
    assert found is not None
    return json.loads(found[1])


def numbers(text: str, kind: str) -> np.ndarray:
    return np.frombuffer(base64.b64decode(text), dtype=kind)


def test_the_numbers_of_a_page_are_those_of_the_run() -> None:
    run = lag.load(EXAMPLES / "pendulum.lag").simulate(stop=2, interval=0.05)
    page = run.animate(traces=["bob.center"], quantities=["hinge.phi", "bob.center.y"])
    data = data_of(page)
    assert np.array_equal(numbers(data["t"], "<f8"), run.time)
    phi, y = data["curves"]
    assert (phi["name"], phi["unit"], y["name"]) == ("hinge.phi", "deg", "bob.center.y")
    assert np.allclose(numbers(phi["y"], "<f4"), np.degrees(run["hinge.phi"]), atol=1e-4)
    way = numbers(data["traces"][0]["at"], "<u2").reshape(-1, 2) * data["span"] / 65534 + np.array(data["low"])
    assert np.allclose(way, run["bob.center.r"], atol=data["span"] / 60000)
    (bob,) = [s for s in data["strokes"] if s["f"] == "grey"]
    assert np.allclose(numbers(bob["poses"], "<f4").reshape(-1, 3)[:, :2], run["bob.center.r"], atol=1e-6)
    assert len(page) < 500_000
    assert not re.search(r"https?://(?!www\.w3\.org)|src=|@[A-Z]+@", page), "it needs nothing but itself"


def test_a_spring_is_drawn_where_its_ends_are() -> None:
    run = lag.load(EXAMPLES / "spring_pendulum.lag").simulate(stop=3, interval=0.1)
    data = data_of(run.animate())
    coils = max((s for s in data["strokes"] if "points" in s), key=lambda s: s["n"])
    points = numbers(coils["points"], "<u2").reshape(len(run.time), -1, 2) * data["span"] / 65534 + np.array(data["low"])
    assert np.allclose(points[:, 0], 0.0, atol=data["span"] / 60000)
    ahead = run["bob.center.r"] - points[:, -1]
    assert np.allclose(np.linalg.norm(ahead, axis=1), 0.5 * data["symbol"], rtol=1e-2), "it ends at the bob"


def test_curves_that_vary_little_are_told(scene: Callable[[str], lag.Model]) -> None:
    """A place a thousand kilometres away that moves by micrometres: four bytes alone would show steps."""
    model = scene("model A Prismatic p(a = world, s(start = 1e6)); PointMass m(m = 1, center = p.b);\n"
                  "AppliedForce F(at = p.b, force = {1e-6, 0}); end A;")
    run = model.simulate(stop=2, interval=0.1)
    (curve,) = data_of(run.animate(quantities=["p.s"]))["curves"]
    assert np.ptp(run["p.s"]) == pytest.approx(2e-6, rel=1e-3)
    assert np.allclose(curve["base"] + numbers(curve["y"], "<f4").astype(float), run["p.s"], rtol=0, atol=1e-9)


def test_names_are_text(scene: Callable[[str], lag.Model]) -> None:
    model = scene('model A "</script><b>" Revolute h(a = world); Bar bar(m = 1, L = 1, a = h.b);\n'
                  'drawing text(bar.b, "</script>"); end A;')
    page = model.simulate(stop=1, interval=0.5).animate()
    assert page.count("</script>") == 2 and "<b>" not in page
    assert [["</script>", 0, 0]] in [c["words"] for c in data_of(page)["captions"]]


SHORT = ["animate", str(EXAMPLES / "pendulum.lag"), "--stop", "2", "--interval", "0.25", "--trace", "bob.center", "-o"]


@pytest.mark.parametrize(("suffix", "kind"), [("gif", "GIF"), ("webp", "WEBP")])
def test_films_have_a_picture_for_each_position(suffix: str, kind: str, tmp_path: Path, monkeypatch) -> None:
    from PIL import Image, features

    if suffix == "webp" and not features.check("webp"):
        pytest.skip("this Pillow knows no WebP")
    monkeypatch.chdir(tmp_path)
    assert main([*SHORT, f"x.{suffix}"]) == 0
    with Image.open(f"x.{suffix}") as film:
        assert (film.format, getattr(film, "n_frames", 1)) == (kind, 9)
        assert max(film.size) > 300
        if suffix == "gif":
            assert film.info["duration"] == 250
    assert not list(tmp_path.glob(".x*")), "nothing is left beside it"


def test_an_mp4_has_pictures_at_an_even_rate(tmp_path: Path, monkeypatch) -> None:
    ffmpeg = pytest.importorskip("imageio_ffmpeg")
    monkeypatch.chdir(tmp_path)
    assert main([*SHORT, "x.mp4"]) == 0
    reader = ffmpeg.read_frames("x.mp4")
    found = next(reader)
    width, height = found["source_size"]
    frames = [np.frombuffer(frame, np.uint8).reshape(height, width, 3) for frame in reader]
    assert (found["fps"], len(frames)) == (25.0, 51)
    assert width % 2 == height % 2 == 0 and min(width, height) > 100
    assert (frames[0] < 100).any() and np.abs(frames[0].astype(int) - frames[20]).max() > 100, "it moves"


def test_an_mp4_needs_ffmpeg(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("lagrangia.draw.film.find_spec", lambda name: None)
    assert main([*SHORT, "x.mp4"]) == WRONG
    assert "pip install imageio-ffmpeg" in capsys.readouterr().err


SVG = "{http://www.w3.org/2000/svg}"


def test_a_moving_svg_is_where_the_run_is(tmp_path: Path, monkeypatch) -> None:
    """Its bob at each row, in one round as long as the run; without a script."""
    monkeypatch.chdir(tmp_path)
    assert main([*SHORT, "x.svg"]) == 0
    root = ElementTree.parse("x.svg").getroot()
    (bob,) = [g for g in root.iter(f"{SVG}g") if g.find(f"{SVG}g/{SVG}circle[@fill='#c8c8c8']") is not None]
    motion = bob.find(f"{SVG}animateTransform")
    assert motion.attrib["type"] == "translate" and motion.attrib["dur"] == "2s" and motion.attrib["repeatCount"] == "indefinite"
    places = np.array([[float(x) for x in pair.split(",")] for pair in motion.attrib["values"].split(";")])
    run = lag.load(EXAMPLES / "pendulum.lag").simulate(stop=2, interval=0.25)
    lengths = np.linalg.norm(np.diff(places, axis=0), axis=1) / np.linalg.norm(np.diff(run["bob.center.r"], axis=0), axis=1)
    assert len(places) == 9 and np.ptp(lengths) < 0.05 * lengths.mean(), "all at one scale"
    assert root.find(f"{SVG}polyline[@pathLength]") is not None and "<script" not in Path("x.svg").read_text()


def test_rows_stand_at_impacts(tmp_path: Path) -> None:
    """Pages show times of the run itself, and mark events beside their curves."""
    run = lag.load(EXAMPLES / "bouncing_ball.lag").simulate(stop=1, interval=0.1)
    assert len(run.events) == 2 and not set(run.events) <= set(run.time)
    data = data_of(run.animate())
    times = numbers(data["t"], "<f8")
    assert set(run.events) <= set(times) and len(times) == len(run.time) + 2
    assert np.allclose(data["events"], run.events)


def test_many_positions_in_one_picture(tmp_path: Path, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    asked = ["--stop", "1", "--stroboscope", "7", "--trace", "bob.center", "-o", "x.svg"]
    assert main(["animate", str(EXAMPLES / "pendulum.lag"), *asked]) == 0
    root = ElementTree.parse("x.svg").getroot()
    radii = [c.attrib["r"] for c in root.iter("{http://www.w3.org/2000/svg}circle")]
    assert radii.count(max(radii, key=float)) == 7
    assert "dasharray" in Path("x.svg").read_text()


def test_a_run_that_fails_is_shown_as_far_as_it_went(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.lag").write_text("model X Block b(m = 1, base = world, s(start = 1), v(start = 1));\n"
                             "GeneralSpring s(V = -1[N/m2]*b.s^3, stretch = b.s); annotation(experiment(StopTime = 10)); end X;")
    assert main(["animate", "x.lag"]) == FAILED
    assert "what was computed before is shown in x.html" in capsys.readouterr().err
    data = data_of(Path("x.html").read_text())
    assert 0 < numbers(data["t"], "<f8")[-1] < 10


@pytest.mark.parametrize(("given", "code"), [
    (["-o", "x.csv"], "L0004"), (["--trace", "bob"], "L0701"), (["--curves", "theta"], "L0701"),
    (["--stroboscope", "0"], "L0702"),
    (["--stroboscope", "3", "--curves", "hinge.phi"], "L0706"), (["-o", "x.gif", "--names", "hinge.phi=theta"], "L0706"),
    (["--beside", "L=1:2:0.001"], "L0706"), (["--beside", "L=normal(1,2)"], "L0706"), (["--beside", "L=1,L=2"], "L0712"),
    (["--beside", "none.csv"], "L0713"), (["--beside", "x=1:2:1"], "L0701"),
])
def test_what_cannot_be_shown_is_told(given: list[str], code: str, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["animate", str(EXAMPLES / "pendulum.lag"), "--stop", "0.5", *given]) == WRONG
    assert f"error[{code}]" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


BROWSER = shutil.which("chromium") or shutil.which("chromium-browser")
PLAY = """<script>
const told = document.createElement("pre"); told.id = "told";
lagrangia.go(0.7); const values = [lagrangia.time, lagrangia.value("hinge.phi")];
const press = key => document.dispatchEvent(new KeyboardEvent("keydown", {key}));
press("ArrowRight"); values.push(lagrangia.time); press("ArrowLeft"); press("End"); values.push(lagrangia.time);
document.getElementById("play").click(); values.push(lagrangia.playing);
told.textContent = JSON.stringify({values, faults: window.faults}); document.body.append(told);
</script></body>"""


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
def test_a_browser_plays_it(tmp_path: Path) -> None:
    run = lag.load(EXAMPLES / "pendulum.lag").simulate(stop=2, interval=0.1)
    page = run.animate().replace("<head>", "<head><script>window.faults = []; onerror = e => faults.push(e);</script>")
    (tmp_path / "x.html").write_text(page.replace("</body>", PLAY))
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}/profile", "--dump-dom",
               (tmp_path / "x.html").as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
    found = re.search(r'<pre id="told">(.*?)</pre>', dom)
    assert found is not None
    told = json.loads(found[1])
    assert told["faults"] == []
    time, phi, following, end, playing = told["values"]
    assert (time, following, end, playing) == (pytest.approx(0.7), pytest.approx(0.8), 2.0, True)
    assert phi == pytest.approx(np.degrees(run["hinge.phi"][7]), abs=1e-4)


def test_notebooks_show_models_and_runs() -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    assert model._repr_html_().startswith("<svg")
    run = model.simulate(stop=0.5)
    assert run._repr_html_().startswith("<iframe srcdoc=")
    for figure in (run.plot(), model.modes().plot()):
        assert figure._repr_png_().startswith(b"\x89PNG"), "without a word to matplotlib"


def test_runs_beside_are_in_the_same_picture(tmp_path: Path) -> None:
    """Thin, at the places of their own run; curves by their values."""
    page = tmp_path / "two.html"
    asked = ["animate", str(EXAMPLES / "double_pendulum.lag"), "--stop", "2", "--interval", "0.1", "-o", str(page)]
    assert main([*asked, "--beside", "elbow.phi=1", "--curves", "elbow.phi"]) == 0
    data = data_of(page.read_text())
    own, other = data["curves"]
    run = lag.load(EXAMPLES / "double_pendulum.lag").simulate(stop=2, interval=0.1, initial={"elbow.phi": 1})
    assert (own["name"], other["name"]) == ("elbow.phi", "elbow.phi, elbow.phi=1")
    assert np.allclose(numbers(other["y"], "<f4"), np.degrees(run["elbow.phi"]), atol=1e-3)
    thin = [numbers(s["poses"], "<f4").reshape(-1, 3) for s in data["strokes"] if "poses" in s and s["l"] == "thin"]
    frames = [run[f"lower.{frame}.r"] for frame in ("a", "b", "center")]
    assert any(np.allclose(poses[:, :2], places, atol=1e-5) for poses in thin for places in frames), "its lower bar"


LEGEND = """<script>
const told = document.createElement("pre"); told.id = "told";
const entries = [...document.querySelectorAll("figcaption span")], boxes = entries.map(e => e.getBoundingClientRect());
const legend = document.querySelector("figcaption"), canvas = document.querySelector("figure canvas").clientHeight;
told.textContent = JSON.stringify({ names: entries.map(e => e.textContent),
  inside: boxes.every(b => b.left >= 0 && b.right <= innerWidth),
  apart: boxes.every((a, i) => boxes.slice(0, i).every(b => a.top >= b.bottom - 1 || a.left >= b.right)),
  reached: legend.scrollHeight <= legend.clientHeight || getComputedStyle(legend).overflowY === "auto",
  canvas, faults: window.faults });
document.body.append(told);
</script></body>"""


@pytest.mark.skipif(BROWSER is None, reason="needs Chromium")
def test_a_legend_names_all_curves(tmp_path: Path) -> None:
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    runs = {f"run {k} of many": model.simulate(stop=0.5, interval=0.1, initial={"elbow.phi": 0.1 * k}) for k in range(8)}
    page = runs["run 0 of many"].animate(quantities=["shoulder.phi", "lower.b.r"], beside=runs)
    page = page.replace("<head>", "<head><script>window.faults = []; onerror = e => faults.push(e);</script>")
    (tmp_path / "x.html").write_text(page.replace("</body>", LEGEND))
    command = [str(BROWSER), "--headless", "--no-sandbox", "--disable-gpu", f"--user-data-dir={tmp_path}/profile", "--dump-dom",
               "--window-size=500,700", (tmp_path / "x.html").as_uri()]
    dom = subprocess.run(command, capture_output=True, text=True, timeout=60, check=True).stdout
    told = json.loads(re.search(r'<pre id="told">(.*?)</pre>', dom)[1])  # type: ignore[index]
    assert told["faults"] == []
    assert len(told["names"]) == 27 and {c["unit"] for c in data_of(page)["curves"]} == {"deg", "m"}
    assert told["inside"] and told["apart"] and told["reached"] and told["canvas"] > 30


@pytest.mark.parametrize("options", [["--beside", "elbow.q=1"], ["--beside", ","], ["--beside", "lower.L=2[kg]"],
                                     ["--beside", "elbow.phi=1", "--beside", "elbow.phi=1"],
                                     ["--beside", "elbow.phi=1", "--stroboscope", "3"]])
def test_runs_beside_that_cannot_be_are_told(options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["animate", str(EXAMPLES / "double_pendulum.lag"), *options]) == WRONG
    assert not list(tmp_path.iterdir())


def test_rows_of_a_sweep_are_shown_together(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """As a range or as the table that a sweep wrote; and in Python, by runs."""
    monkeypatch.chdir(tmp_path)
    scene = str(EXAMPLES / "pendulum.lag")
    assert main(["sweep", scene, "-p", "L=1:2:0.5", "--stop", "1", "-o", "table.csv", "--quiet"]) == 0
    asked = ["animate", scene, "--stop", "1", "--interval", "0.25", "--curves", "bob.center.x"]
    assert main([*asked, "--beside", "L=1:2:0.5", "-o", "range.html"]) == 0
    assert main([*asked, "--beside", "table.csv", "-o", "table.html"]) == 0
    first, second = (data_of(Path(f"{name}.html").read_text()) for name in ("range", "table"))
    assert [curve["name"] for curve in first["curves"][1:]] == [f"bob.center.x, L = {x} m" for x in ("1", "1.5", "2")]
    assert first["curves"] == second["curves"]
    model = lag.load(EXAMPLES / "pendulum.lag")
    runs = {f"L = {x:g} m": model.simulate(stop=1, interval=0.25, parameters={"L": x}) for x in (1, 1.5, 2)}
    page = model.simulate(stop=1, interval=0.25).animate(quantities=["bob.center.x"], beside=runs)
    assert data_of(page)["curves"] == first["curves"]


def test_a_table_of_something_else_is_refused(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    for text, why in (("L,height\n1,2\n", "'height' is no parameter"), ("run,max(x)\n0,1\n", "its columns are no"),
                      ("L\n1[kg]\n", "kg"), ("L,L\n1,2\n", "two columns 'L'")):
        Path("x.csv").write_text(text)
        assert main(["animate", str(EXAMPLES / "pendulum.lag"), "--beside", "x.csv"]) == WRONG
        assert why in capsys.readouterr().err
    assert main(["animate", str(EXAMPLES / "pendulum.lag"), "--beside", "x.csv", "-o", "x.csv"]) == WRONG


NAMES = """
const { readFileSync } = require("fs"), [page, places, lines] = process.argv.slice(1), shown = [], at = [0, 0];
const g = { canvas: { clientWidth: 400, clientHeight: 600 }, measureText: text => ({ width: 8 * text.length }),
  translate(x, y) { at[0] = x; at[1] = y; }, fillText: (text, x, y) => shown.push([text, at[0] + x, at[1] + y]) };
for (const name of ["strokeText", "scale", "save", "restore", "beginPath", "moveTo", "lineTo"]) g[name] = () => {};
new Function("g", "all", "lines", "const css = { bg: '', fg: '' };" + readFileSync(page, "utf8") + `
  for (const steps of lines) {
    const pen = new Pen(g, 400, 600, true); pen.begin(); for (const [x, y] of steps) pen.to(x, y); captions(pen, all, false);
  }`)(g, JSON.parse(places), JSON.parse(lines));
console.log(JSON.stringify(shown));
"""


def names_shown(places: list[dict], *lines: list) -> list:
    """Text, x and y of what is written on pictures of these lines, one after another."""
    page = Path(lag.__file__).parent / "draw" / "captions.js"
    command = ["node", "-e", NAMES, str(page), json.dumps(places), json.dumps(lines)]
    return json.loads(subprocess.run(command, capture_output=True, text=True, check=True).stdout)


@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node.js")
def test_names_on_a_page_give_way_to_each_other() -> None:
    """Very many in one place: those that are shown are apart, the others wait; one alone stands where it belongs."""
    crowd = [{"words": [[f"name{k}", 1, 0]], "x": 200, "y": 200 + 3 * k, "u": 1, "v": 0} for k in range(300)]
    found = names_shown(crowd, [])
    assert 30 < len(found) < 300
    boxes = [(x, y - 13, x + 8 * len(text), y + 4) for text, x, y in found]
    for k, a in enumerate(boxes):
        assert all(a[0] >= b[2] or a[2] <= b[0] or a[1] >= b[3] or a[3] <= b[1] for b in boxes[:k])
    ((_, x, y),) = names_shown(crowd[:1], [])
    assert (x, y) == (pytest.approx(203), 205)


@pytest.mark.skipif(shutil.which("node") is None, reason="needs Node.js")
def test_names_on_a_page_give_way_to_lines() -> None:
    """And stay where they are while it is free, though the line that drove them there has gone."""
    name = [{"words": [["name", 1, 0]], "x": 200, "y": 200, "u": 1, "v": 0}]
    bar, elsewhere = [[150, 200], [300, 201]], [[10, 10], [20, 500]]
    first, there, after = ((x, y) for _, x, y in names_shown(name, elsewhere, bar, elsewhere))
    assert first == (pytest.approx(203), 205)
    assert there[1] < 205 - 4 - 8 or there[1] - 13 > 205, "above or below the bar, by letters 13 high of which 4 hang"
    assert after == there
