"""Pages that compute scenes in space: digits of the run, solids and lines of pictures, an eye that is moved by hand."""

import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.pages import computed, heard, needs_browser, needs_node
from lagrangia.base.folders import data_folder
from lagrangia.draw.drawing import figures_of, states_of
from lagrangia.draw.film import thinned
from lagrangia.play.player import play_scene
from lagrangia.run.request import Request, check_values
from lagrangia.solids.seen import build_stage, look
from lagrangia.solids.stage import matrices

EXAMPLES = data_folder("models") / "examples"
ZOO = """model Zoo "one of each word"
  World world(gravity = {0, 0, -9.81});
  Universal u(a = world, phi_a(start = 0.4), phi_b(start = 0.3));
  Cylinder c(m = 1, r = 0.1, h = 0.4, center = shift(u.b, {0, 0, -0.5}));
  Cylindrical cy(a = shift(world, {1, 0, 0}), axis = {1, 1, 1}, w(start = 2));
  Box b(m = 1, size = {0.3, 0.2, 0.1}, center = cy.b);
  Spherical s(a = shift(world, {0, 1, 0}), S(start = angles("zxz", 0.3, 1, 0)), w(start = {0, 1, 5}));
  Cone k(m = 1, r = 0.2, h = 0.5, center = shift(s.b, {0, 0, 0.2}));
  Prismatic p(a = shift(world, {1, 1, 0}), along = {0, 1, 1}, v(start = 1));
  Disc d(m = 1, r = 0.2, center = p.b);
  Spring spring(a = k.center, b = d.center, k = 10, s_rel0 = 1);
  Damper damper(a = k.center, b = c.center, c = 1);
  Ball ball(m = 1, r = 0.15, center(r(start = {-1, 0, 2}), omega(start = {1, 2, 3})));
  BodyForce f(at = ball.center, force = {0, 3, 1});
  AppliedTorque t(on = c.center, torque = {0, 1, 2});
  Revolute h(a = shift(world, {2, 0, 0}), axis = {1, 2, 3}, w(start = 1));
  Ball knob(m = 1, r = 0.1, center = shift(h.b, {0.3, 0, 0}));
  TorsionSpringDamper twisted(a = h.a, b = h.b, k = 2, c = 0.1);
drawing
  trace(ball.center);
  polygon(shift(world, {2, 2, 0}), shift(world, {2, 3, 0}), {2, 2.5, 1}, style = "dashed");
  circle(d.center, 0.3, along = {1, 0, 1});
  arc(c.center, 0.2, 0, 2);
  cylinder(ball.center, 0.05, 0.5, along = {1, 0.2, 0}, fill = "black");
  box(d.center, 0.4, 0.1, along = {1, 1, 0});
  cuboid(shift(world, {0, 0, -1}), 1[m], 2[m], 0.1[m]);
  arrow(ball.center, 0.1[s]*ball.center.v);
  hatch(world);
  text(k.center, "cone");
end Zoo;
"""
WATCHED = """const canvas = $("scene"), box = canvas.getBoundingClientRect();
  const x = box.left + box.width / 5, y = box.top + box.height / 5;  // beside all parts
  canvas.setPointerCapture = () => {};
  const send = (kind, id, dx, dy, more = {}) =>
    canvas.dispatchEvent(new PointerEvent(kind, { pointerId: id, clientX: x + dx, clientY: y + dy, ...more }));
  const eye = () => Object.values(lagrangia.eye), Q = () => [1, 2, 3, 4].map(k => lagrangia.value(`hull.center.S[${k}]`));
  send("pointerdown", 1, 0, 0); send("pointermove", 1, 50, 25); send("pointerup", 1, 50, 25); values.push(eye());
  send("pointerdown", 1, 0, 0); send("pointermove", 1, 30, 10, { shiftKey: true }); send("pointerup", 1, 30, 10);
  values.push(eye());
  document.querySelector("[data-view='-90 90']").click(); canvas.dispatchEvent(new MouseEvent("dblclick"));
  send("pointerdown", 1, -40, 0); send("pointerdown", 2, 40, 0); send("pointermove", 1, -80, 0); send("pointermove", 2, 80, 0);
  send("pointerup", 1, -80, 0); send("pointerup", 2, 80, 0); values.push(eye());
  canvas.dispatchEvent(new WheelEvent("wheel", { deltaY: -100, clientX: x, clientY: y, cancelable: true })); values.push(eye());
  values.push(Q()); lagrangia.set("hull.center.S about z", Math.PI / 2); values.push(Q()); lagrangia.go(20); values.push(Q());
  document.getElementById("defaults").click(); values.push(Q());"""
DRAGGED = """const canvas = $("scene"), box = canvas.getBoundingClientRect(), before = { ...lagrangia.eye };
  const point = D.frames.reduce((a, b) => point_of(a)[2] < point_of(b)[2] ? a : b), from = window_of(point_of(point));
  canvas.setPointerCapture = () => {};
  const send = (kind, step) => canvas.dispatchEvent(new PointerEvent(kind, { pointerId: 1, pointerType: "touch",
    clientX: box.left + from[0] + 5 * step, clientY: box.top + from[1] + 3 * step }));
  send("pointerdown", 0);
  for (let step = 1; step <= 5; step++) send("pointermove", step);
  const to = window_of(point_of(held));
  send("pointerup", 5);
  values.push(to[0] - from[0], to[1] - from[1], JSON.stringify(before) === JSON.stringify(lagrangia.eye), held);
  const shown = D.shown.map(v => v.name); lagrangia.go(lagrangia.time + 0.2);
  values.push(Object.fromEntries(D.controls.filter(c => c.kind === "start" && !c.refs).map(c => [c.name, c.now])));
  values.push(Object.fromEntries(D.controls.filter(c => c.refs).map(c => [c.name, c.base])));
  values.push(Object.fromEntries(shown.map(name => [name, lagrangia.value(name)])));"""


def written(model: lag.Model, page: Path, **asked) -> Path:
    play_scene(model, page, Request(**asked), {})
    return page


@needs_node
def test_digits_are_those_of_the_run(tmp_path: Path) -> None:
    """Of a loop that ball joints close."""
    model = lag.load(EXAMPLES / "spatial_four_bar.lag")
    page = written(model, tmp_path / "x.html")
    told = computed(page, """
        if (!m.begin(D.given, D.tolerance, D.stop) || !m.step(0.3) || !m.step(0.5 - m.values()[0])) return m.message;
        const found = m.values(); return Object.fromEntries(D.shown.map(v => [v.name, found[v.ref]]));""")
    run = model.simulate(at=[0.0, 0.5], stop=model.scene.stop)
    places = [c.name for c in model.scene.told_positions]
    assert [told[name] for name in places] == pytest.approx([run[name][-1] for name in places], abs=1e-8)
    assert told["energy.kinetic"] == pytest.approx(run.energy.kinetic[-1], rel=1e-8)


@needs_node
def test_solids_and_lines_are_those_of_pictures(scene: Callable[[str], lag.Model], tmp_path: Path) -> None:
    model = scene(ZOO)
    page = written(model, tmp_path / "x.html", stop=0.5)
    run = thinned(model.run(Request(stop=0.5)), 60)
    states = states_of(model, run, check_values(model.scene))
    figures = figures_of(model)
    stage, looked = build_stage(model.compilation, figures, states, {}, []), look(model.compilation, figures, states)
    for moment in (0, 30):
        told = computed(page, f"""
            const {{ bodies, lines, names }} = moment(D, {json.dumps(looked.values[moment].tolist())});
            return {{ lines, names, bodies: bodies.map(b => {{
                const v = new Float32Array(bytes(D.forms[b.form].v)), found = [];
                for (let i = 0; i < v.length; i += 3) found.push(plus(b.at, times(b.turn, [v[i], v[i + 1], v[i + 2]])));
                return [b.s, found]; }}) }}""")
        ours = [(body.shade, body.solid.vertices @ matrices(body.poses[moment, 3:]).T + body.poses[moment, :3])
                for body in stage.bodies]
        assert len(ours) == len(told["bodies"]) > 12
        for (shade, vertices), (other, found) in zip(ours, told["bodies"], strict=True):
            assert shade == other and np.allclose(vertices, found, atol=1e-6)
        lines = [line for line in stage.lines if np.isfinite(line.points[moment]).all()]
        assert len(lines) == len(told["lines"]) > 10
        for line, found in zip(lines, told["lines"], strict=True):
            assert line.line == found["l"] and np.allclose(line.at(moment), found["points"], atol=1e-9)
        assert np.allclose([c.at[moment] for c in stage.captions], [n["at"] for n in told["names"]], atol=1e-12)
    coil = next(line for line in stage.lines if line.turns == 4 and line.line == "thin")
    way = np.ptp(coil.points[30], axis=0)
    assert np.allclose(way / np.linalg.norm(way), np.array([1, 2, 3]) / np.sqrt(14), atol=1e-12)  # about the hinge's axis


HELD = """model Held "a ball as large as what is held says, beside two attitudes"
  Position level(start = 0.2);
  World world(gravity = {0, 0, -9.81});
  Spherical s(a = world, S(start = axis_angle({1, 0, 0}, 0.5)), w(start = {0, 0, 30}));
  Body b(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(s.b, {0, 0, 0.1}));
  Spherical t(a = shift(world, {0.5, 0, 0}), S(start = axis_angle({1, 1, 0}, 0.7)), w(start = {0, 0, 50}));
  Body c(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(t.b, {0, 0, 0.1}));
equation
  when sample(0, 0.1) then
    level = 0.05[m] + b.center.x;
  end when;
drawing
  ball(b.center, 0.01[m] + abs(level));
  cuboid(c.center, 0.1[m], 0.02[m], 0.03[m]);
end Held;"""


@needs_node
def test_attitudes_and_held_values_are_those_of_the_moment(scene: Callable[[str], lag.Model], tmp_path: Path) -> None:
    """The numbers of the drawing, with references that have moved on with the steps."""
    model = scene(HELD).opened(None, "a page")
    page = written(model, tmp_path / "x.html", stop=0.5)
    run = model.run(Request(at=[0.0, 0.37, 0.5]))
    ours = look(model.compilation, figures_of(model), states_of(model, run, check_values(model.scene))).values
    told = computed(page, """m.begin(D.given, D.tolerance, D.stop); const found = [[...m.drawing()]];
        for (const t of [0.37, 0.5]) { m.step(t - m.values()[0]); found.push([...m.drawing()]); } return found;""")
    assert np.abs(np.array(told) - ours).max() < 1e-12 and np.ptp(run["level"]) > 0.01


@needs_browser
def test_an_eye_is_moved_and_attitudes_are_turned_by_hand(tmp_path: Path) -> None:
    model = lag.load(EXAMPLES / "satellite.lag")
    told = heard(written(model, tmp_path / "x.html"), WATCHED)
    assert (told["faults"], told["message"]) == ([], "")
    turned, shifted, pinched, zoomed, first, about_z, later, again = told["values"]
    assert turned == pytest.approx([-np.pi / 3 - 0.4, np.radians(22) + 0.2, 1, 0, 0])
    assert shifted == pytest.approx([*turned[:3], 30, 10])
    assert pinched[:3] == pytest.approx([-np.pi / 3, np.radians(22), 2], abs=1e-9)
    assert zoomed[2] == pytest.approx(2 * np.exp(0.15))
    a, x, y, z = first
    half = np.sqrt(0.5)
    start = [half * (a - z), half * (x - y), half * (y + x), half * (z + a)]
    assert about_z == pytest.approx(start, abs=1e-12)
    run = model.simulate(at=[0.0, 20.0], initial={"hull.center.S": start})
    assert later == pytest.approx([run[f"hull.center.S[{k}]"][-1] for k in range(1, 5)], abs=1e-8)
    assert again == pytest.approx(first, abs=1e-12)


@needs_browser
@pytest.mark.parametrize("name", ["robot_arm", "satellite"])
def test_parts_follow_where_they_are_dragged(name: str, tmp_path: Path) -> None:
    """By touch, in the plane of view, which the eye keeps; coordinates alone, or an attitude with them. The run begins there."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    told = heard(written(model, tmp_path / "x.html"), DRAGGED)
    assert (told["faults"], told["message"]) == ([], "")
    right, down, is_same_eye, held, starts, attitudes, later = told["values"]
    assert (right, down) == pytest.approx((25, 15), abs=0.01) and is_same_eye and held is None
    coordinates = {c.name for c in model.scene.coordinates}
    initial = {coordinate: x for coordinate, x in starts.items() if coordinate in coordinates}
    initial |= {turn.removesuffix(" about x"): q for turn, q in attitudes.items() if turn.endswith(" about x")}
    run = model.simulate(at=[0.0, 0.2], stop=model.scene.stop, initial=initial)
    places = [c.name for c in model.scene.told_positions]
    assert [later[place] for place in places] == pytest.approx([run[place][-1] for place in places], abs=1e-7)


def test_springs_along_a_line_are_no_coils_of_torsion(scene: Callable[[str], lag.Model]) -> None:
    """Where their ends coincide at the start, on a hinge, too."""
    model = scene("""model Own
      model Pull Frame a, b; energy potential 5[N/m]*dot(b.r - a.r, b.r - a.r); drawing zigzag(a, b); end Pull;
      World world(gravity = {0, 0, -9.81}); PointMass p(m = 1, center(r(start = {0, 0, 0}), v(start = {2, 0, 1})));
      Pull pull(a = world, b = p.center); Ball k(m = 1, r = 0.1, center = h.b);
      Revolute h(a = world, axis = {0, 1, 0}), h2(a = shift(h.b, {1, 0, 0}), axis = {0, 1, 0});
      PointMass q(m = 1, center = shift(h2.b, {-1, 0, 0})); Pull far(a = world, b = q.center);
      TorsionSpring t(a = h.a, b = h.b, k = 1); end Own;""")
    run = model.simulate(at=[0.0])
    given = look(model.compilation, figures_of(model), states_of(model, run, check_values(model.scene))).given
    assert {g.figure.component: g.hinge is not None for g in given if g.figure.word == "zigzag"} == {
        "pull": False, "far": False, "t": True}
