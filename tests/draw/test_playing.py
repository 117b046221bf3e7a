"""Pages that compute: their digits are those of the run, their strokes those of the drawing, their controls change the motion."""

import json
import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.pages import computed, heard, needs_browser, needs_node
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import FAILED, WRONG, main
from lagrangia.draw.drawing import figures_of, states_of
from lagrangia.draw.film import thinned
from lagrangia.draw.picture import arms_of
from lagrangia.draw.reel import build_reel
from lagrangia.draw.strokes import Stroke
from lagrangia.play import wasm
from lagrangia.play.player import play_scene
from lagrangia.run.request import Request, check_values

EXAMPLES = data_folder("models") / "examples"
SCENES = ["double_pendulum", "bouncing_ball", "four_bar", "suspended_bar", "stick_slip", "rough_road", "dc_motor_stick_slip"]


def written(model: lag.Model, page: Path, **asked) -> Path:
    play_scene(model, page, Request(**asked), {})
    return page


def written_for(scene: str, page: Path) -> lag.Model:
    model = lag.load(EXAMPLES / f"{scene}.lag")
    written(model, page)
    return model


@needs_node
@pytest.mark.parametrize("scene", SCENES)
def test_digits_are_those_of_the_run(scene: str, tmp_path: Path) -> None:
    """After 1 s, with events (the ball, friction) and with a closed loop (four bars), looked at between."""
    model = written_for(scene, tmp_path / "x.html")
    told = computed(tmp_path / "x.html", """
        if (!m.begin(D.given, D.tolerance, D.stop) || !m.step(0.3) || !m.step(1 - m.values()[0])) return m.message;
        return [...m.values()];""")
    run = model.opened(None, "a page").simulate(at=[0.0, 1.0], stop=model.scene.stop)
    ours = np.array(told[: 1 + 2 * model.scene.n])
    assert np.allclose(ours, run.rows[-1][: len(ours)], rtol=1e-12, atol=1e-12)
    energies = told[1 + 4 * model.scene.n + len(model.scene.outputs) :]
    assert energies[:2] == pytest.approx([run.energy.kinetic[-1], run.energy.potential[-1]], rel=1e-11, abs=1e-11)


@needs_node
def test_a_page_goes_on_behind_the_end(tmp_path: Path) -> None:
    model = written_for("pendulum", tmp_path / "x.html")
    script = """m.begin(D.given, D.tolerance, D.stop); m.step(D.stop);
        const end = m.values()[1]; m.step(1.5); return [end, ...m.values()];"""
    end, time, later = computed(tmp_path / "x.html", script)[:3]
    assert end == pytest.approx(model.simulate()["hinge.phi"][-1], abs=1e-12)
    assert time == pytest.approx(model.scene.stop + 1.5)
    assert later == pytest.approx(model.simulate(stop=model.scene.stop + 1.5)["hinge.phi"][-1], abs=1e-6)


@needs_node
@pytest.mark.parametrize("scene", SCENES)
def test_strokes_are_those_of_drawings(scene: str, tmp_path: Path) -> None:
    model = written_for(scene, tmp_path / "x.html")
    run = thinned(model.run(Request()), 60)
    reel = build_reel(model.compilation, figures_of(model), states_of(model, run, check_values(model.scene)), {}, [])
    scenery = reel.scenery
    for moment in (0, 20, len(run.rows) - 1):
        rows = scenery.numbers.values[:, moment].tolist()
        told = computed(tmp_path / "x.html", f"return picture(D, {json.dumps(rows)})")["strokes"]
        shown = [k for k in scenery.shown if scenery.numbers.items[k].word != "trace"]
        ours = [stroke for k in shown for stroke in scenery.shape(k, moment).strokes] + arms_of(scenery, moment)
        assert sorted(map(by_python, ours)) == sorted(map(by_page, told))


def by_python(stroke: Stroke) -> tuple:
    return (stroke.layer, stroke.line, stroke.fill, stroke.is_closed, *rounded([stroke.radius, *stroke.points.ravel()]))


def by_page(told: dict) -> tuple:
    return (told["layer"], told["l"], told["f"], told["c"], *rounded([told["r"], *told["p"]]))


def rounded(numbers: list) -> list:
    return [round(float(x) + 1.2345e-7, 6) for x in numbers]  # to no border at which exact numbers stand


@needs_node
def test_values_change_the_motion_and_what_stops_it_is_told(tmp_path: Path) -> None:
    model = written_for("pendulum", tmp_path / "x.html")
    script = """const ref = name => D.controls.find(c => c.name === name).ref, told = [];
        m.begin([[ref("L"), 0.5], [ref("hinge.phi"), 1]], D.tolerance, D.stop); m.step(1); told.push(m.values()[1]);
        m.set(ref("L"), 2); m.step(0.5); told.push(m.values()[1]);
        told.push(m.begin([[ref("m"), 0]], D.tolerance, D.stop) && m.step(1), m.message);
        told.push(m.begin([], D.tolerance, D.stop) && m.step(1), m.message, m.values()[1]); return told;"""
    short, changed, ran, why, again, silence, whole = computed(tmp_path / "x.html", script)
    first = model.simulate(at=[0.0, 1.0], parameters={"L": 0.5}, initial={"hinge.phi": 1.0})
    later = model.simulate(at=[0.0, 0.5], parameters={"L": 2.0}, initial={"hinge.phi": first["hinge.phi"][-1],
                                                                         "hinge.w": first["hinge.w"][-1]})
    assert short == pytest.approx(first["hinge.phi"][-1], abs=1e-11)
    assert changed == pytest.approx(later["hinge.phi"][-1], abs=1e-6)
    assert not ran and why
    assert again and silence == ""
    assert whole == pytest.approx(model.simulate(at=[0.0, 1.0], stop=model.scene.stop)["hinge.phi"][-1], abs=1e-12)


def test_a_table_may_be_too_long_for_a_page(scene: Callable[[str], lag.Model], tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("lagrangia.play.player.build_wasm", lambda: b"")
    rows = ", ".join(str(k) for k in range(2001))
    model = scene(f"model A Frame road = shift(world, {{0, table(time/1[s], {{{rows}}}, {{{rows}}})*1e-3}});\n"
                  "PointMass m(m = 1); Spring s(a = road, b = m.center, k = 1, s_rel0 = 1); end A;")
    with pytest.raises(lag.Error, match="not supported yet: a page that computes and draws a table of 2001 rows"):
        written(model, tmp_path / "x.html", stop=0.01)


@needs_node
def test_states_are_told_by_their_names(tmp_path: Path) -> None:
    """Not by the coordinates whose rates they are: as curves and values, and with a slider for where they start."""
    model = written_for("dc_motor_stick_slip", tmp_path / "x.html")
    data = computed(tmp_path / "x.html", "return D")
    assert [c["name"] for c in data["curves"]] == ["axle.phi", "bearing.phi", "motor.i", "control.I", "load_speed"]
    names = [v["name"] for v in (*data["shown"], *data["controls"])]
    assert names.count("motor.i") == 2 and not any("integral" in name for name in names)
    told = computed(tmp_path / "x.html", """m.begin(D.given, D.tolerance, D.stop); m.step(1);
        return D.curves.map(c => m.values()[c.ref] * c.scale);""")
    run = model.opened(None, "a page").simulate(at=[0.0, 1.0], stop=model.scene.stop)
    assert told[2:] == pytest.approx([run[name][-1] for name in ("motor.i", "control.I", "load_speed")], abs=1e-9)


@needs_node
def test_numbers_that_a_scene_has_compiled_in_are_open_in_a_page(tmp_path: Path) -> None:
    """Gravity to the side is 0, and costs the run nothing; its slider acts (it changed nothing, without a word)."""
    model = written_for("pendulum", tmp_path / "x.html")
    told = computed(tmp_path / "x.html", """const ref = D.controls.find(c => c.name === "world.gravity[1]").ref;
        m.begin([[ref, 5]], D.tolerance, D.stop); m.step(1); return m.values()[1];""")
    run = model.simulate(at=[0.0, 1.0], stop=model.scene.stop, parameters={"world.gravity[1]": 5.0})
    assert told == pytest.approx(run["hinge.phi"][-1], abs=1e-8)


@needs_node
def test_inputs_act_from_where_they_are_set(scene: Callable[[str], lag.Model], tmp_path: Path) -> None:
    model = scene("model M input Force F; Block b(m = 2, base = world); AppliedForce p(at = b.center, force = {F, 0}); end M;")
    written(model, tmp_path / "x.html", inputs={"F": 1.0})
    script = """m.begin(D.given, D.tolerance, D.stop); m.step(0.5);
        m.set(D.controls.find(c => c.kind === "input").ref, 4); m.step(0.25); return m.values();"""
    told = computed(tmp_path / "x.html", script)
    assert told["0"] == 0.75
    assert told["1"] == pytest.approx(0.5 * 0.5 * 0.5**2 + 0.25 * 0.25 + 0.5 * 2 * 0.25**2, abs=1e-12)


@needs_node
def test_a_run_that_stops_is_told_here_and_there(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    Path("x.lag").write_text("model X Block b(m = 1, base = world, s(start = 1), v(start = 1));\n"
                             "GeneralSpring s(V = -1[N/m2]*b.s^3); annotation(experiment(StopTime = 10)); end X;")
    assert main(["play", "x.lag", "-o", "x.html"]) == FAILED
    assert "x.html computes them" in capsys.readouterr().err
    why = computed(Path("x.html"), "m.begin(D.given, D.tolerance, D.stop); return [m.step(9), m.message]")
    assert why[0] is False and "no step is small enough" in why[1]


def test_names_are_text(scene: Callable[[str], lag.Model], tmp_path: Path, monkeypatch) -> None:
    monkeypatch.setattr("lagrangia.play.player.build_wasm", lambda: b"")
    model = scene('model A "</script><b>" Revolute h(a = world); Bar bar(m = 1, L = 1, a = h.b);\n'
                  'drawing text(bar.b, "</script>"); end A;')
    page = written(model, tmp_path / "x.html").read_text()
    assert page.count("</script>") == 2 and "<b>" not in page


@needs_node
def test_what_was_asked_for_is_where_the_page_begins(tmp_path: Path) -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    asked = {"parameters": {"L": 0.7}, "initial": {"hinge.phi": 0.4, "hinge.w": -1.0}}
    written(model, tmp_path / "x.html", **asked)
    told = computed(tmp_path / "x.html", "m.begin(D.given, D.tolerance, D.stop); m.step(1); return m.values()[1];")
    assert told == pytest.approx(model.simulate(at=[0.0, 1.0], stop=model.scene.stop, **asked)["hinge.phi"][-1], abs=1e-12)


PLAY = """values.push(lagrangia.go(1), lagrangia.time, lagrangia.value("hinge.phi"));
  const press = key => document.dispatchEvent(new KeyboardEvent("keydown", {key}));
  press("ArrowRight"); values.push(lagrangia.time); press("r"); values.push(lagrangia.time);
  lagrangia.set("L", 0.5); lagrangia.go(1); values.push(lagrangia.value("hinge.phi"));
  document.getElementById("defaults").click();
  held = D.frames.reduce((a, b) => rows[a[0]] > rows[b[0]] ? a : b);
  for (let i = 0; i < 5; i++) pull(0.6, -0.8);
  values.push(D.controls.find(c => c.name === "hinge.phi").now);
  document.getElementById("play").click(); values.push(lagrangia.running);"""
PULL = """held = D.frames.reduce((a, b) => rows[a[0] + 1] > rows[b[0] + 1] ? a : b);
  const [x, y] = place_of(held, rows);
  for (let i = 1; i <= 4; i++) pull(x - 0.03 * i, y + 0.001 * i);
  values.push(x, place_of(held, rows)[0], now[1], now[2], now[3]); lagrangia.go(0.5); values.push(lagrangia.time);"""


@needs_browser
def test_a_browser_runs_it(tmp_path: Path) -> None:
    model = written_for("pendulum", tmp_path / "x.html")
    page = (tmp_path / "x.html").read_text()
    assert not re.search(r"https?://|src=|@[A-Z]+@", re.sub(r'<script id="data".*?</script>', "", page, flags=re.DOTALL))
    assert len(page) < 500_000
    told = heard(tmp_path / "x.html", PLAY)
    assert (told["faults"], told["message"]) == ([], "")
    went, time, phi, following, back, shorter, dragged, running = told["values"]
    assert went and running and time == pytest.approx(1.0) and following > 1.0 and back == 0.0
    assert phi == pytest.approx(model.simulate(at=[0.0, 1.0], stop=model.scene.stop)["hinge.phi"][-1], abs=1e-11)
    assert shorter == pytest.approx(model.simulate(at=[0.0, 1.0], parameters={"L": 0.5})["hinge.phi"][-1], abs=1e-11)
    assert dragged == pytest.approx(np.arctan2(0.6, 0.8), abs=1e-3)


@needs_browser
def test_a_loop_is_dragged_as_a_whole(tmp_path: Path) -> None:
    model = written_for("four_bar", tmp_path / "x.html")
    told = heard(tmp_path / "x.html", PULL)
    assert (told["faults"], told["message"]) == ([], "")
    begin, end, *angles, time = told["values"]
    assert end == pytest.approx(begin - 0.12, abs=0.01)
    assert time == pytest.approx(0.5)
    started = model.simulate(at=[0.0], initial={"O.phi": angles[0]})
    assert angles == pytest.approx(started.rows[0, 1:4].tolist(), abs=1e-9)


def test_without_zig_it_is_said_how_to_get_it(tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(wasm, "zig", lambda: None)
    assert main(["play", str(EXAMPLES / "pendulum.lag"), "-o", "x.html"]) == WRONG
    told = capsys.readouterr().err
    assert "error[L0706]" in told and "pip install ziglang" in told
    assert not Path("x.html").exists()


@pytest.mark.parametrize(("given", "code"), [(["-o", "x.gif"], "L0004"), (["-o", "x.html", "--trace", "bob"], "L0701")])
def test_what_cannot_be_played_is_told(given: list[str], code: str, tmp_path: Path, monkeypatch, capsys) -> None:
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("lagrangia.play.player.build_wasm", lambda: b"")
    monkeypatch.setattr("lagrangia.command.play.require_zig", lambda: [])
    assert main(["play", str(EXAMPLES / "pendulum.lag"), *given]) == WRONG
    assert f"error[{code}]" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


PUSHED = """model Pushed input Force u; parameter Mass m = 2; Block b(m = m, base = world); Spring s(k = 50, stretch = b.s);
AppliedForce f(at = b.center, force = {u, 0}); annotation(experiment(StopTime = 3)); end Pushed;"""


@needs_node
def test_inputs_over_time_play_until_they_are_set(scene: Callable[[str], lag.Model], tmp_path: Path) -> None:
    """Digits of the run with the same table, events at its corners; what is set is held, and given again at the next start."""
    times, u = [0.0, 1.0, 1.0, 2.5], [0.0, 10.0, -4.0, 3.0]
    model = scene(PUSHED)
    page = written(model, tmp_path / "x.html", inputs=(times, {"u": u}))
    told = computed(page, """
        const ref = D.controls.find(c => c.kind === "input").ref, told = [];
        const go = (...to) => {
            for (const t of to) if (!m.step(t - m.values()[0])) throw m.message;
            told.push(m.values()[1], m.values()[ref]);
        };
        m.begin(D.given, D.tolerance, D.stop); go(0.5, 3); told.push([...m.events()]);
        m.begin(D.given, D.tolerance, D.stop); go(0.5); m.set(ref, 2); go(3);
        m.begin(D.given, D.tolerance, D.stop); go(3); return told;""")
    run = model.simulate(at=[0.0, 0.5, 3.0], inputs=(times, {"u": u}))
    assert told[:2] == pytest.approx([run["b.s"][2], 3.0], rel=1e-9)
    assert told[2] == pytest.approx([1.0, 2.5])
    assert told[3:5] == pytest.approx([run["b.s"][1], 5.0], rel=1e-9)
    held = model.simulate(at=[0.0, 3.0], inputs=([0.0, 0.5, 0.5], {"u": [0.0, 5.0, 2.0]}))
    assert told[5:7] == pytest.approx([held["b.s"][1], 2.0], rel=1e-7)
    assert told[7:] == pytest.approx(told[:2], rel=1e-12)
    slider = next(c for c in json.loads(re.search(r'application/json">(.*?)</script>', page.read_text())[1])["controls"])
    assert (slider["name"], slider["varies"], slider["high"]) == ("u", True, 10.0)
