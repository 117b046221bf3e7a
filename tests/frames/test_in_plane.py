"""Scenes in space whose parts move in parallel planes run with the equations of the plane."""

from collections.abc import Mapping
from dataclasses import replace

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.frames.planes import NoPlane, Plane
from lagrangia.model import Model

TILT, ANGLE = np.array([1, 2, -2]) / 3, 0.7
PARTS = """
  Revolute crank(a = {base}, AXIS phi(start = 0.5, fixed = true), w(start = 4, fixed = true));
  Bar arm(m = 1, L = 0.3, a = crank.b);
  Revolute pin(a = arm.b, AXIS phi(start = -0.8));
  Bar rod(m = 0.5, L = 0.8, a = pin.b);
  Revolute wrist(a = rod.b, AXIS phi(start = 0.3));
  Body slider(m = 2, I = {{0, 0, 0.01}}, center = wrist.b);
  Prismatic guide(a = shift({base}, {{0, 0.05}}), along = {{1, 0}}, b = wrist.b, s(start = 1));
  Spring spring(k = 30, s_rel0 = 0.5, a = {base}, b = rod.b);
  AppliedForce push(at = rod.b, force = {force});
"""


def rotation(axis: np.ndarray, angle: float) -> np.ndarray:
    x, y, z = axis
    S = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * S + (1 - np.cos(angle)) * S @ S


def curly(x: np.ndarray) -> str:
    return "{" + ", ".join(repr(float(part)) for part in x) + "}"


def scene(parts: str, axis: np.ndarray | None, angle: float = ANGLE, across: float = 0.0) -> Model:
    """In the plane, or in one that is turned about an axis, with a gravity and a load that leave it as well."""
    if axis is None:
        return lag.loads("model M World world; " + parts.replace("AXIS", "").format(base="world", force="{0.3, 0.4}") + "end M;")
    R = rotation(axis, angle)
    world = f"World world(gravity = {curly(R @ [0, -9.81, across])});"
    base = f"turn(world, {angle!r}, {curly(axis)})"
    parts = parts.replace("AXIS", "axis = {{0, 0, 1}},").format(base=base, force=curly(R @ [0.3, 0.4, across]))
    return lag.loads(f"model M {world} {parts} end M;")


def plane_of(model: Model) -> Plane | NoPlane | None:
    return model.compilation.graph.plane


@pytest.mark.parametrize("axis", [np.array([1.0, 0, 0]), np.array([0, -1.0, 0]), TILT])
@pytest.mark.parametrize("across", [0.0, 3.0])
def test_a_slider_crank_in_any_plane(axis: np.ndarray, across: float) -> None:
    """A loop whose slider is cut; what leaves the plane does no work."""
    flat, tilted = scene(PARTS, None), scene(PARTS, axis, across=across)
    assert isinstance(plane_of(tilted), Plane) and tilted.compilation.motion.way == flat.compilation.motion.way
    a, b = (model.simulate(stop=1, interval=0.25, tolerance=1e-11) for model in (flat, tilted))
    for name in ("crank.phi", "pin.phi", "wrist.phi", "guide.s", "der(guide.s)"):
        assert b[name] == pytest.approx(a[name], abs=1e-9)
    assert b.energy.residual == pytest.approx(np.zeros(b.time.size), abs=1e-8)


def test_a_slider_that_points_into_the_plane_from_outside_it() -> None:
    """Its axes are the world's: only by its numbers does it keep to the plane. What leaves it by a tenth stands still."""
    R = rotation(TILT, ANGLE)
    back = f"turn(wrist.b, {-ANGLE!r}, {{{curly(TILT)}}})"

    def guided(way: list[float], rod: float, place: float, fixed: str = ", fixed = true") -> Model:
        guide = (f"guide(a = shift(world, {{{curly(R @ [0, 0.05, 0])}}}), along = {{{curly(R @ way)}}}, "
                 f"b = {back}, s(start = {place}))")
        parts = PARTS.replace("guide(a = shift({base}, {{0, 0.05}}), along = {{1, 0}}, b = wrist.b, s(start = 1))", guide)
        return scene(parts.replace("0.8, a = pin", f"{rod}, a = pin").replace(", fixed = true", fixed), TILT)

    model = guided([0.6, 0.8, 0], 0.8, 1)
    assert isinstance(plane_of(model), Plane) and model.freedom["degrees_of_freedom"] == 1
    in_space = model._in(replace(model.formulas, in_space=True))
    a, b = (x.simulate(stop=0.5, interval=0.25, tolerance=1e-10) for x in (model, in_space))
    assert a["crank.phi"] == pytest.approx(b["crank.phi"], abs=1e-9) and a["guide.s"] == pytest.approx(b["guide.s"], abs=1e-9)
    assert guided([0.6, 0.8, 0.1], 0.3, 0, "").freedom["degrees_of_freedom"] == 0


def test_a_plane_of_coordinates_costs_what_the_plane_costs() -> None:
    flat, upright = (scene(PARTS.replace("AppliedForce push(at = rod.b, force = {force});", ""), *way)
                     for way in ((None,), (np.array([1.0, 0, 0]), np.pi / 2)))
    assert upright.compilation.motion.nodes == flat.compilation.motion.nodes


CHAIN = """
  Revolute first(a = world, {axis} phi(start = 0.4));
  Bar upper(m = 1, L = 0.7, a = first.b);
  Weld bend(a = upper.b, {weld});
  Revolute second(a = bend.b, {back} phi(start = -0.3), w(start = 1));
  Body lower(m = 0.5, {inertia}, center = shift(second.b, {ahead}));
"""


def test_axes_of_frames_may_point_anywhere() -> None:
    """The second body has its own axes, and its hinge turns about the other side of the normal."""
    flat = CHAIN.format(axis="", weld="angle = 0", back="", inertia="I = 0.2", ahead="{0.3, -0.1}")
    # Seen in the welded frame, x is up the normal, and y goes ahead.
    turned = CHAIN.format(axis="axis = {0, 0, 1},", weld="offset = {0, 0, 0.1}, angle = 120[deg], axis = {1, 1, 1}",
                          back="axis = {0, -2, 0},", inertia="I = {0.1, 0.2, 0.3}", ahead="{-0.1, 0.7, 0.3}")
    a, b = (lag.loads(f"model M World world; {text} end M;") for text in (flat, turned))
    assert isinstance(plane_of(b), Plane) and plane_of(a) is None
    start = {"second.phi": -0.3, "second.w": 1.0}
    planar = a.simulate(stop=1, interval=0.25, tolerance=1e-11, initial=start)
    inverse = b.simulate(stop=1, interval=0.25, tolerance=1e-11, initial={name: -x for name, x in start.items()})
    assert inverse["first.phi"] == pytest.approx(planar["first.phi"], abs=1e-9)
    assert inverse["second.phi"] == pytest.approx(-planar["second.phi"], abs=1e-9)


def test_frames_of_a_plane_have_their_words_of_space() -> None:
    """Their velocities are rates of their places, Q is R, omega is w in their own axes."""
    words = """output Real slope[3] = der(slider.center.r) - slider.center.v;
      output Real spin[3] = to_world(rod.center, rod.center.omega) - rod.center.w;
      output Real one[3] = rod.center.R*{1, 2, 3} - to_world(rod.center, {1, 2, 3});
      output Real way[3] = velocity_at(rod.center, rod.b.r) - rod.b.v;
      output Real side = dot(rod.center.w, slider.center.v);"""
    run = scene(PARTS + words.replace("{", "{{").replace("}", "}}"), TILT).simulate(stop=1, interval=0.5)
    names = [name for name in run.names if name.split("[")[0] in ("slope", "spin", "one", "way", "side")]
    assert len(names) == 13
    for name in names:
        assert run[name] == pytest.approx(np.zeros(run.time.size), abs=1e-12), name


LOOP = """parameter Length h = 0.2;
  World world(gravity = {0, 0, -9.81});
  Revolute j1(a = world, axis = {1, 0, 0}, phi(start = 1, fixed = true));
  Body crank(m = 1, I = {0, 0.02, 0.02}, center = shift(j1.b, {0, 0.2, 0}));
  Revolute j2(a = shift(j1.b, {0.2, 0.4, 0}), axis = {1, 0, 0}, phi(start = -1));
  Body coupler(m = 1, I = {0, 0.1, 0.1}, center = shift(j2.b, {0, 0.5, 0}));
  Revolute j3(a = shift(j2.b, {0, 1, 0}), axis = {-1, 0, 0});
  Body rocker(m = 1, I = {0, 0.05, 0.05}, center = shift(j3.b, {0, -0.35, 0}));
  Revolute j4(a = shift(j3.b, {0, -0.7, 0}), axis = {1, 0, 0}, b = shift(world, {h, 0.9, 0}), phi(start = 0));
"""


def test_a_loop_that_is_no_longer_in_one_plane_is_told() -> None:
    model = lag.loads(f"model M {LOOP} end M;")
    assert isinstance(plane_of(model), Plane) and len(model.compilation.constraints.rows) == 2
    assert "across" in model.freedom["repeated"][0]
    with pytest.raises(LagError, match="loop"):
        model.simulate(stop=0.1, parameters={"h": 0.3})


def test_another_axis_takes_other_equations() -> None:
    """Numbers by which all lies in a plane are those of the text alone."""
    text = "World world; Revolute a(a = world, axis = {0.6, 0, 0.8}, phi(start = 1)); Body p(m = 1, I = {0.1, 0.2, 0.3}, " \
           "center = shift(a.b, {1, 0, 0})); Revolute b(a = p.center, axis = {0.6, 0, 0.8}, w(start = 1)); " \
           "Body q(m = 1, I = {0.1, 0.2, 0.3}, center = shift(b.b, {1, 0, 0}));"
    others = text.replace("p.center, axis = {0.6", "p.center, axis = {-0.6")
    model, other = (lag.loads(f"model M {parts} end M;") for parts in (text, others))
    assert isinstance(plane_of(model), Plane) and isinstance(plane_of(other), NoPlane)
    found = model.simulate(stop=1, interval=0.5, tolerance=1e-10, parameters={"b.axis[1]": -0.6})
    assert found["b.phi"] == pytest.approx(other.simulate(stop=1, interval=0.5, tolerance=1e-10)["b.phi"], abs=1e-8)


REASONS: Mapping[str, tuple[str, str]] = {
    "another axis": ("Revolute k(a = b.center, axis = {0, 1, 0});", "'k.phi' turns about an axis that is not parallel to others"),
    "along": ("Prismatic k(a = b.center, along = {1, 0, 0});", "'k.s' shifts along an axis about which others turn"),
    "attitude": ("Spherical k(a = b.center);", "the attitude 'k.S' has no plane"),
    "floating": ("Spring s(k = 1, a = b.center, b = k.center);", "'k.center' floats"),
    "reaction": ("output Force x = h.b.reaction[1]; Weld k(a = b.center);", "h.b.reaction[1] is asked for"),
}


@pytest.mark.parametrize("name", REASONS)
def test_what_lies_in_no_plane_is_told(name: str) -> None:
    parts, why = REASONS[name]
    more = "PointMass k(m = 1);" if name == "floating" else "Body c(m = 1, I = {1, 1, 1}, center = k.b);"
    model = lag.loads("model M World world; Revolute h(a = world, axis = {1, 0, 0}); "
                      f"Body b(m = 1, I = {{1, 1, 1}}, center = shift(h.b, {{0, 1, 0}})); {parts} {more} end M;")
    plane = plane_of(model)
    assert isinstance(plane, NoPlane) and plane.why.startswith(why)


def in_space(model: Model) -> Model:
    """The same with the equations of space."""
    return model._in(replace(model.formulas, in_space=True))


HINGE = "model M World world; {before} Revolute h(a = {base}, axis = {{0, 0, 1}}, phi(start = 2.5)); " \
        "Body b(m = 1, I = {{0.01, 0.01, 0.01}}, center = shift(h.b, {{0.5, 0, {rise}}})); end M;"
CORNERS = {
    "a cam": ("", "world", "0.4[m]*max(0, h.phi - 2)"),
    "time": ("", "shift(world, {0, 0, max(0, (time - 2)*1[m/s])})", "0"),
    "a branch": ("", "shift(world, {0, 0, if time < 2 then 0 else (time - 2)*1[m/s]})", "0"),
    "an input": ("input Length up;", "shift(world, {0, 0, max(up, 5[m])})", "0"),
    "a parameter": ("parameter Real k = 1;", "world", "0.4[m]*max(0, k - 2)*h.phi"),
    "steep": ("", "world", "0.1[m]*tanh(1e6*(h.phi - 2))"),
    "small": ("", "world", "1e-13[m]*exp(20*h.phi)"),
    "tilted": ("", "turn(world, max(0, (time - 2)*1[rad/s]), {1, 0, 0})", "0"),
}


@pytest.mark.parametrize("name", CORNERS)
def test_what_leaves_the_plane_elsewhere_is_seen(name: str) -> None:
    """Where slopes are 0 at most places, or too small there."""
    before, base, rise = CORNERS[name]
    assert isinstance(plane_of(lag.loads(HINGE.format(before=before, base=base, rise=rise))), NoPlane)


def test_a_cam_across_the_plane_runs_in_space() -> None:
    model = lag.loads(HINGE.format(before="", base="world", rise="0.4[m]*max(0, h.phi - 2)"))
    assert model.simulate(stop=1, interval=1, tolerance=1e-10)["h.phi"][-1] == pytest.approx(6.4206567, abs=1e-6)


@pytest.mark.parametrize("way", ["{max(0, h.phi - 2)*1[m], 0.3*sin(h.phi)*1[m], 0}",
                                 "{h.phi/3*1[m], (if h.phi > 2 then 0.1 else 0.2*h.phi)*1[m], 0}"])
def test_corners_in_a_tilted_plane_stay_there(way: str) -> None:
    """Their rounding along the normal is no change."""
    back = rotation(TILT, -0.9)
    shift = " + ".join(f"{curly(back[:, k])}*({part})" for k, part in enumerate(way[1:-1].rsplit(", ", 2)))
    base = f"turn(h.b, 0.9, {curly(TILT)})"
    text = HINGE.format(before="", base=f"turn(world, 0.7, {curly(TILT)})", rise="0")
    model = lag.loads(text.replace("shift(h.b, {0.5, 0, 0})", f"shift({base}, {shift})"))
    assert isinstance(plane_of(model), Plane)


FOUR_BAR = """model M World world(gravity = {{0, -9.81, 0}});
  Revolute h1(a = world, axis = {{0, 0, 1}}, phi(start = 1));
  Body b1(m = 1, I = {{0.01, 0.01, 0.01}}, center = shift(h1.b, {{0.5, 0, 0}}));
  Revolute h2(a = shift(h1.b, {{1, 0, 0}}), axis = {{0, 0, -1}}, phi(start = 1.2));
  Body b2(m = 1, I = {{0.01, 0.01, 0.01}}, center = shift(h2.b, {{0.5, 0, 0}}));
  Revolute h3(a = shift(h2.b, {{1, 0, 0}}), axis = {{0, 0, 1}}, phi(start = 1));
  Body b3(m = 1, I = {{0.01, 0.01, 0.01}}, center = shift(h3.b, {{-0.4, 0, 0}}));
  {closed} end M;"""
LAST = "Revolute h4(a = turn(shift(world, {1.2, 0, 0}), 0.7, {1, 0, 0}), axis = {0, AXIS}, " \
       "b = turn(shift(h3.b, {-0.8, 0, 0}), 0.7, {1, 0, 0})); energy potential 30*(h4.phi - 1)^2/2;"


@pytest.mark.parametrize("axis", ["sin(0.7), cos(0.7)", "-sin(0.7), -cos(0.7)"])
def test_a_cut_hinge_turns_about_its_own_axis(axis: str) -> None:
    """Its angle, and the force of it, where the axis is told by an expression."""
    model = lag.loads(FOUR_BAR.format(closed=LAST.replace("AXIS", axis)))
    assert isinstance(plane_of(model), Plane)
    a, b = (x.simulate(stop=0.5, interval=0.25, tolerance=1e-10) for x in (model, in_space(model)))
    for name in ("h1.phi", "h4.phi", "der(h4.phi)"):
        assert a[name] == pytest.approx(b[name], abs=1e-7), name


ACROSS = {
    "a hinge": ("Revolute h4(a = shift(world, {1.2, 0, 0}), axis = {1, 0, 0}, b = shift(h3.b, {-0.8, 0, 0}));",
                "'h4.phi' turns", 0),
    "a slider": ("Prismatic h4(a = shift(world, {1.2, 0, 0}), along = {0, 0, 1}, b = shift(h3.b, {-0.8, 0, 0}));",
                 "'h4.s' shifts", 0),
    "a fifth bar": ("Revolute h4(a = shift(h3.b, {-0.8, 0, 0}), axis = {0, 0, 1}, phi(start = 1)); "
                    "Body b4(m = 1, I = {0.01, 0.01, 0.01}, center = shift(h4.b, {0.3, 0, 0})); "
                    "Revolute h5(a = shift(world, {1.2, 0, 0}), axis = {1, 0, 0}, b = shift(h4.b, {0.6, 0, 0}));",
                    "'h5.phi' turns", 1),
}


@pytest.mark.parametrize("name", ACROSS)
def test_a_cut_joint_across_the_plane_leaves_it(name: str) -> None:
    closed, why, count = ACROSS[name]
    model = lag.loads(FOUR_BAR.format(closed=closed))
    plane = plane_of(model)
    assert isinstance(plane, NoPlane) and plane.why.startswith(why)
    assert model.freedom["degrees_of_freedom"] == count


SLIDERS = """model M World world(gravity = {{0, 0, -9.81}}); Revolute h(a = world, axis = {{1, 0, 0}}, phi(start = 0.3));
  Body b(m = 1, I = {{0.1, 0.1, 0.1}}, center = shift(h.b, {{0, 0.2, 0}}));
  Prismatic p(a = h.b, along = {{0, 1, 0}}, s(start = 0.3)); Body c(m = 1, I = {{0.1, 0.1, 0.1}}, center = p.b);
  Prismatic q(a = p.b, along = {{0, 0, 1}}, s(start = 0.4)); Body d(m = 1, I = {{0.1, 0.1, 0.1}}, center = q.b);
  Spring spring(k = 20, s_rel0 = 0.5, a = world, b = q.b); Prismatic r(a = h.b, along = {{{along}}}, b = q.b); end M;"""


def test_a_cut_slider_keeps_to_the_plane_or_leaves_it() -> None:
    """A loop of sliders alone; that which is cut points anywhere in the plane."""
    model, other = (lag.loads(SLIDERS.format(along=along)) for along in ("0, 0.6, 0.8", "0.1, 0.6, 0.8"))
    assert isinstance(plane_of(model), Plane) and model.compilation.graph.closures[0].kind == "slider"
    a, b = (x.simulate(stop=0.5, interval=0.25, tolerance=1e-10) for x in (model, in_space(model)))
    for name in ("h.phi", "p.s", "r.s"):
        assert a[name] == pytest.approx(b[name], abs=1e-8), name
    left = plane_of(other)
    assert isinstance(left, NoPlane) and left.why == "'r.s' shifts along an axis about which others turn"


def test_reactions_at_rest_are_those_of_space() -> None:
    """Across the plane, the hinge carries what gravity has there."""
    hinge = """Revolute h(a = world, axis = {1, 0, 0}, phi(start = -0.4));
      Body b(m = 2, I = {1, 1, 1}, center = shift(h.b, {0.5, 0, -1}));"""
    model = lag.loads(f"model M World world(gravity = {{3, 0, -9}}); {hinge} end M;")
    assert isinstance(plane_of(model), Plane)
    (rest, *_) = model.equilibrium()
    assert rest.position["h.phi"] == pytest.approx(0, abs=1e-9)
    force = [rest.reactions[f"h.reaction[{k}]"] for k in (1, 2, 3)]
    assert force == pytest.approx([-6, 0, 18], abs=1e-9)
    linear = model.linearize(outputs=["h.reaction[1]"])
    assert linear.outputs == ("h.reaction[1]",)
