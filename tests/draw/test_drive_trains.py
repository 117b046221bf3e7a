"""Drive trains as pictures: every line is a connection of the scene, and every connection is drawn."""

import random
import time
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.draw.drive_parts import Part, parts_of
from lagrangia.draw.drive_symbols import symbol_of
from lagrangia.draw.drive_train import Sketch, draw_train, icon_of_train, sketch_of

Scene = Callable[[str], lag.Model]
Point = tuple[float, float]
Line = tuple[Point, Point]  # along x or along y, lower end first


def lines_of(sketch: Sketch) -> dict[int, list[Line]]:
    """By shafts, in steps of a micrometre."""
    found: dict[int, list[Line]] = {}
    for wire in sketch.wires:
        points = [(round(float(x), 3), round(float(y), 3)) for x, y in wire.points]
        for a, b in pairwise(points):
            assert a[0] == b[0] or a[1] == b[1]
            found.setdefault(wire.shaft, []).append((min(a, b), max(a, b)))
    return found


def holds(line: Line, at: Point) -> bool:
    (x, y), (u, v) = line
    return x <= at[0] <= u and y <= at[1] <= v


def touch(p: Line, q: Line) -> bool:
    """Whether two lines meet otherwise than by crossing each other."""
    if any(holds(p, at) for at in q) or any(holds(q, at) for at in p):
        return True
    is_across = (p[0][0] == p[1][0]) != (q[0][0] == q[1][0])
    return not is_across and p[0] <= q[1] and q[0] <= p[1] and (holds(p, q[0]) or holds(q, p[0]))


def check(sketch: Sketch) -> None:
    """What is joined in the picture, read from its lines alone, is what is joined in the scene."""
    lines = lines_of(sketch)
    ends: dict[int, list[Point]] = {}
    for part, places, feet in zip(sketch.parts, sketch.ends, sketch.feet, strict=True):
        outs = [places[0], *([] if part.right is None else [places[1]]), *feet]
        for shaft, (x, y) in zip(part.shafts, outs, strict=True):
            ends.setdefault(shaft, []).append((round(float(x), 3), round(float(y), 3)))
    for shaft, points in ends.items():
        mine = lines.get(shaft, [])
        if len(points) == 1:
            assert not mine
            continue
        assert mine and all(any(holds(line, at) for line in mine) for at in points)
        reached, left = [mine[0]], mine[1:]
        while near := [line for line in left if any(touch(line, other) for other in reached)]:
            reached, left = reached + near, [line for line in left if line not in near]
        assert not left
    flat = [(shaft, line) for shaft, found in lines.items() for line in found]
    for k, (shaft, line) in enumerate(flat):
        assert not any(touch(line, other) for owner, other in flat[k + 1 :] if owner != shaft)
    for shaft, (x, y) in sketch.dots:
        at = round(float(x), 3), round(float(y), 3)
        assert {owner for owner, line in flat if holds(line, at)} == {shaft}
    boxes = [((a + b) / 2 - (6.6, 6.0), (a + b) / 2 + (6.6, 6.0)) for a, b in sketch.ends]
    for k, (low, high) in enumerate(boxes):
        assert not any(np.all(low < top) and np.all(high > bottom) for bottom, top in boxes[k + 1 :])
        for shaft, (a, b) in flat:
            inside = all(max(a[i], low[i]) < min(b[i], high[i]) or (a[i] == b[i] and low[i] < a[i] < high[i]) for i in (0, 1))
            assert not inside or shaft in sketch.parts[k].shafts


def parts_at_random(seed: int) -> list[Part]:
    """Circles, several parts between the same two shafts, both ends on one, three ends, housings."""
    dice = random.Random(seed)
    shafts = range(1, dice.randint(2, 14))
    parts = []
    for k in range(dice.randint(1, 25)):
        right = dice.choice([None, *shafts, *shafts])
        further = tuple(dice.choices(shafts, k=dice.choice([0, 0, 0, 1, 2]))) if right is not None else ()
        parts.append(Part(f"p{k}", "", dice.choice(shafts), right, further, dice.choice([None, None, None, *shafts[:1]])))
    return parts


def test_at_random() -> None:
    for seed in range(60):
        parts = parts_at_random(seed)
        check(sketch_of(parts, [float(seed % 20)] * len(parts)))


TRAIN = """model Gearbox "Two ways" import Rotational.*;
  model Final "With flanges of what is in it" Flange input_shaft, output_shaft; IdealGear gear(ratio = 4);
    Inertia wheel(J = 3);
    equation connect(input_shaft, gear.flange_a); connect(gear.flange_b, wheel.flange_a); connect(wheel.flange_b, output_shaft);
  end Final;
  model Own Flange port; coordinate Angle x; equation port.phi = x; energy kinetic 1[kg.m2]*der(x)^2/2; end Own;
  model Reel extends Inertia(J = 1); Translational.Flange rope; equation rope.s = 0.1[m]*phi; end Reel;
  Torque m(tau = 1, flange = motor.flange_a);
  Inertia motor(J = 1), sun(J = 1); Reel ring(J = 2);
  SpringDamper shaft(c = 3, d = 2, flange_a = motor.flange_b, flange_b = sun.flange_a);
  Spring soft(c = 1, flange_a = motor.flange_b, flange_b = sun.flange_a);
  IdealPlanetary planets(ratio = 3); Fixed housing; SpeedSensor speed; Final last; Own own; Flange hub;
  Spring turns[2](each c = 1);
  Brake brake(fn_max = 3, f_normalized = 1, useSupport = true, support = housing.flange);
  Revolute crank(a = world); Body arm(m = 1, I = 1, center = crank.b); HingeFlange drive(of = crank.phi);
  equation connect(sun.flange_b, planets.sun); connect(planets.ring, ring.flange_a); connect(ring.flange_b, brake.flange_a);
  connect(planets.carrier, last.input_shaft); connect(speed.flange, planets.carrier); connect(last.output_shaft, hub);
  connect(hub, own.port); for k in 1:2 loop connect(hub, turns[k].flange_a); connect(turns[k].flange_b, drive.flange); end for;
  end Gearbox;"""


def test_a_scene(scene: Scene, tmp_path: Path) -> None:
    """Its parts, their shafts, and the page: the mechanism above, the train below."""
    model = scene(TRAIN)
    flat = model.compilation.flat
    found = parts_of(flat)
    check(sketch_of(found, [9.0] * len(found)))
    parts = {part.name: part for part in found}
    ends = {"motor.a": parts["motor"].left, "motor.b": parts["motor"].right, "sun.b": parts["sun"].right,
            "carrier": parts["planets"].right, "ring.b": parts["ring"].right, "hub": parts["hub"].left}
    others = [parts["drive"].left, parts["last.gear"].right, parts["housing"].left, parts["brake"].right]
    assert len({*ends.values(), *others}) == len(ends) + len(others)
    assert parts["m"].left == ends["motor.a"] and parts["planets"].left == ends["sun.b"]
    assert parts["shaft"].left == parts["soft"].left == ends["motor.b"]
    assert parts["planets"].further == (parts["ring"].left,) and parts["brake"].left == ends["ring.b"]
    assert parts["last.gear"].left == parts["speed"].left == ends["carrier"]
    assert parts["last.wheel"].right == parts["own"].left == parts["turns[1]"].left == parts["turns[2]"].left == ends["hub"]
    assert parts["turns[1]"].right == parts["turns[2]"].right == parts["drive"].left
    assert parts["brake"].housing == parts["housing"].left
    assert parts["ring"].kind == "Inertia" and len(parts["ring"].further) == 1
    assert (parts["turns[1]"].kind, parts["own"].kind, parts["drive"].of) == ("Spring", "", "crank")
    page = draw_train(flat, {"motor": "M"})
    assert page is not None and page.title == "Two ways"
    assert sorted(label.words.plain for label in page.labels) == sorted(
        {*parts} - {"motor", "drive"} | {"M", "drive (crank)"}) and "last" not in parts
    assert sum(path.fill == "grey" for path in page.paths) == 4
    text = model.draw(tmp_path / "train.svg", names={"motor": "M", "crank.phi": "a"})
    assert ">planets</tspan>" in text and ">M</tspan>" in text and "stroke-dasharray" in text and ">a</tspan>" in text
    with pytest.raises(lag.LagError, match="motr"):
        model.draw(names={"motr": "M"})


def test_long_trains_go_on_in_a_further_line() -> None:
    """800 parts in a chain, on one shaft, and in a circle, which is cut nowhere: no time grows with their square."""
    chain = [Part(f"p{k}", "Spring", k, k + 1) for k in range(800)]
    begin = time.perf_counter()
    star = sketch_of([Part(f"p{k}", "Inertia", 0) for k in range(800)], [9.0] * 800)
    circle = sketch_of([*chain, Part("back", "Spring", 800, 0)], [9.0] * 801)
    folded = sketch_of(chain, [9.0] * 800)
    assert time.perf_counter() - begin < 10
    assert max(b[0] for _, b in folded.ends) < 180 < max(a[0] for a, _ in circle.ends)
    assert len({float(a[1]) for a, _ in folded.ends}) > 60 and len(star.dots) > 300
    check(sketch_of(chain[:40], [9.0] * 40))


def test_scenes_without_flanges_are_drawn_as_before(scene: Scene) -> None:
    model = scene("model M coordinate Length x; energy kinetic 1[kg]*der(x)^2/2; end M;")
    assert draw_train(model.compilation.flat, {}) is None


def test_rods_discs_and_what_acts_between_two_ends_are_no_boxes() -> None:
    """Each has a symbol of its own, as high as is said."""
    a, b = np.array([0.0, 0.0]), np.array([13.0, 0.0])
    box = symbol_of("Anything", a, b, False)[0]
    drawn = {kind: symbol_of(kind, a, b, False)[0] for kind in ("Disc", "Rod", "Torque2", "Force2")}
    shapes = {kind: [np.round(stroke.points, 6).tolist() for stroke in strokes] for kind, strokes in (*drawn.items(), ("", box))}
    assert all(shapes[one] != shapes[other] for one in shapes for other in shapes if one != other)


def test_sources_of_motion_show_what_they_prescribe() -> None:
    """A graph each, against time: an angle that swings, a rate that grows, an acceleration, a rate that stays."""
    a, b = np.array([0.0, 0.0]), np.array([13.0, 0.0])
    graphs = [symbol_of(kind, a, b, True)[0][-1].points for kind in ("Position", "Speed", "Accelerate", "ConstantSpeed")]
    for graph in graphs:
        assert abs(graph[:, 0] - 6.5).max() < 3.0 and abs(graph[:, 1]).max() < 2.2  # within its box
    assert len({tuple(np.round(graph[:, 1], 6)) for graph in graphs}) == 4


def test_the_icon_of_a_drive_train_is_its_first_parts(scene: Scene) -> None:
    """It was an empty box."""
    flat = scene("""model M Rotational.ConstantSpeed motor(w_fixed = 1); Rotational.Spring s(c = 1, flange_a = motor.flange);
      Rotational.Inertia j[20](each J = 1); equation connect(s.flange_b, j[1].flange_a);
      for i in 1:19 loop connect(j[i].flange_b, j[i + 1].flange_a); end for; end M;""").compilation.flat
    icon, whole = icon_of_train(flat), draw_train(flat, {})
    assert icon is not None and whole is not None
    assert icon.paths and not icon.labels and icon.width < 70.0 < whole.width
