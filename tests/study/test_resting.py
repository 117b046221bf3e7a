"""What holds at rest beside constraints, against closed forms: contacts, which only push, and friction up to its limit."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

G = 9.81
Write = Callable[[str], lag.Model]


def close(found: object, wanted: object, tolerance: float = 1e-9) -> None:
    np.testing.assert_allclose(np.asarray(found), np.asarray(wanted), rtol=tolerance, atol=tolerance)


# ---------------------------------------------------------------- contacts


@pytest.mark.parametrize(("k", "relaxed", "place", "force"), [
    (10, 0.5, 0, {"floor": G - 5}), (100, 0.5, 0.5 - G / 100, {}), (100, 2, 0.6, {"ceiling": 140 - G}), (0, 0, 0, {"floor": G})])
def test_a_weight_on_a_spring_between_two_stops(k: float, relaxed: float, place: float, force: dict[str, float],
                                                scene: Write) -> None:
    """Above both, on the floor, or pressed against the ceiling; without a spring it falls onto the floor."""
    model = scene(f"""model Between Block b(m = 1, base = world, along = {{0, 1}}, s(start = 0.2));
      Spring k(k = {k}, stretch = b.s - {relaxed}); Stop floor(e = 0.4, gap = b.s), ceiling(gap = 0.6 - b.s); end Between;""")
    found = model.equilibrium()
    assert len(found) == 1 and found.is_reached
    close(found[0].position["b.s"], place)
    assert found[0].contacts == pytest.approx(force) and found[0].stability == ("fixed" if force else "stable")
    modes = model.modes()
    close(modes.omega, [] if force else [np.sqrt(k)])
    assert len(modes.notes) == len(force) and all("presses with" in note for note in modes.notes)


def test_stops_upon_stops(scene: Write) -> None:
    """Three weights fall onto each other; each stop carries all above it."""
    found = scene("""model Stack Block a(m = 1, base = world, along = {0, 1}, s(start = 1)),
      b(m = 2, base = world, along = {0, 1}, s(start = 2)), c(m = 3, base = world, along = {0, 1}, s(start = 3));
      Stop s1(gap = a.s), s2(gap = b.s - a.s - 0.1), s3(gap = c.s - b.s - 0.1); end Stack;""").equilibrium()
    close([found[0].position[x] for x in ("a.s", "b.s", "c.s")], [0, 0.1, 0.2])
    assert found[0].contacts == pytest.approx({"s1": 6 * G, "s2": 5 * G, "s3": 3 * G})


@pytest.mark.parametrize("place", [0.0, 0.25, 0.5])
def test_a_bar_on_two_stops(place: float, scene: Write) -> None:
    """Its own weight and another one on it: lever arms. Over one of them the other still carries half the bar."""
    model = scene(f"""model Bar2 Bar b(m = 1, L = 1); PointMass w(m = 1, center = shift(b.center, {{{place}, 0}}));
      Stop s1(a = world, b = b.a), s2(a = world, b = b.b); initial equation b.center.y = 0.2; end Bar2;""")
    first = model.equilibrium()[0]
    assert first.contacts == pytest.approx({"s1": G * (1 - place), "s2": G * (1 + place)})
    assert first.stability == "neutral"  # it slides along
    modes = model.modes()
    assert [mode.kind for mode in modes] == ["rigid body"] and modes[0].shape["b.center.phi"] == pytest.approx(0, abs=1e-12)


def test_a_one_way_rope_is_taut_where_it_hangs(scene: Write) -> None:
    """A pendulum whose rope only pulls, slack at the start: omega^2 = g/L. Also where a stop holds the turning of a hinge."""
    model = scene("""model Rope1 PointMass P(m = 2); Length r = distance(world, P.center);
      equation when r > 0.8 then reinit(der(r), 0); end when; initial equation P.center.x = 0.3; P.center.y = -0.4; end Rope1;""")
    first = model.equilibrium()[0]
    close([first.position["P.center.x"], first.position["P.center.y"]], [0, -0.8])
    assert first.contacts == pytest.approx({"r > 0.8": 2 * G}) and first.stability == "stable"
    close(model.modes().omega, [np.sqrt(G / 0.8)])
    hinged = scene("""model Hinged Revolute h(a = world, phi(start = 0.2)); Bar b(m = 1, L = 1, a = h.b);
      TorsionStop t(gap = h.phi + 0.3); end Hinged;""").equilibrium()
    assert hinged[0].contacts == pytest.approx({"t": G / 2 * np.cos(0.3)}) and hinged[0].stability == "fixed"
    assert sorted(x.stability for x in hinged) == ["fixed", "stable", "unstable"]


@pytest.mark.parametrize("condition", ["(b.s - 0.5)^3 < 0", "tanh(100*(b.s - 0.5)) < 0", "sign(b.s - 0.5) < 0",
                                       "max(b.s - 0.5, 2*b.s - 1) < 0", "b.s < 0.5 and b.s > -0.5"])
def test_contacts_told_by_resets_hold_where_their_gap_is_closed(condition: str, scene: Write) -> None:
    """The first three held at 0, where what is reset has its own."""
    model = scene(f"""model Falls Block b(m = 1, base = world, along = {{0, 1}}, s(start = 1)); equation
      when {condition} then reinit(b.v, -0.5*b.v); end when; end Falls;""")
    (first,) = model.equilibrium()
    close(first.position["b.s"], 0.5)
    assert first.stability == "fixed" and ("max" in condition or list(first.contacts.values()) == pytest.approx([G]))


@pytest.mark.parametrize("start", [-0.2, 0.4])
def test_what_lies_on_a_body_that_feels_nothing_of_it(start: float, scene: Write) -> None:
    """x = -10/50, b half a metre above it (it was at 0), y on a spring at b: x and y swing by themselves."""
    model = scene(f"""model Rides World world(gravity = {{-10, 0}}); Block b(m = 1, base = world, s(start = 1));
      Block x(m = 1, base = world, s(start = {start})), y(m = 1, base = world, s(start = 2));
      energy potential 25*x.s^2 + 15*(y.s - b.s - 1)^2;
      equation when b.s < x.s + 0.5 then reinit(b.v, x.v - 0.5*(b.v - x.v)); end when; end Rides;""")
    (first,) = model.equilibrium()
    close([first.position[x] for x in ("x.s", "b.s", "y.s")], [-0.2, 0.3, 1.3 - 1/3])
    assert list(first.contacts.values()) == pytest.approx([20])
    modes = model.modes()
    close(modes.omega, np.sqrt([30, 50]))
    close(modes[1].shape["b.s"]/modes[1].shape["y.s"], -2/3)


@pytest.mark.parametrize("gap", ["b.s - x.s - 0.5", "(b.s - x.s - 0.5)^3", "sign(b.s - x.s - 0.5)"])
def test_what_lies_on_a_body_that_carries_it(gap: str, scene: Write) -> None:
    """Both are reset: x = -20/50 (nothing was found), and 2 kg swing on 50 N/m."""
    model = scene(f"""model Carried World world(gravity = {{-10, 0}}); parameter Mass m = 1;
      Block b(m = m, base = world, s(start = 1)), x(m = m, base = world, s(start = -0.2)); energy potential 25*x.s^2;
      equation when {gap} < 0 then reinit(b.v, (m*b.v + m*x.v)/(m + m) - 0.5*m/(m + m)*(b.v - x.v));
        reinit(x.v, (m*b.v + m*x.v)/(m + m) + 0.5*m/(m + m)*(b.v - x.v)); end when; end Carried;""")
    (first,) = model.equilibrium()
    close([first.position["x.s"], first.position["b.s"]], [-0.4, 0.1])
    assert list(first.contacts.values()) == pytest.approx([10])
    close(model.modes().omega, [5])


def test_what_stands_on_its_end_falls(scene: Write) -> None:
    """A free bar upright on a floor, found from there: growth sqrt(m g L/2 / (m L^2/12)), for its foot slides."""
    model = scene("""model Upright Bar b(m = 3, L = 1); Stop s1(a = world, b = b.a), s2(a = world, b = b.b);
      initial equation b.center.y = 0.5; b.center.phi = pi/2; end Upright;""")
    first = model.equilibrium(starts=1)[0]
    assert first.contacts == pytest.approx({"s1": 3 * G})
    close(first.growth, np.sqrt(6 * G))


def test_contacts_carry_what_excites(scene: Write) -> None:
    """A mass on a platform, with a spring along it: the platform's motion goes through, the force on it answers to loads."""
    model = scene("""model Platform
      Frame platform = shift(world, {0, 0.1}); PointMass P(m = 2); Stop on(a = platform, b = P.center);
      AxialSpring s(a = world, b = P.center, k = 50, along = {1, 0}); AppliedForce F(at = P.center, force = {0, 0});
      output Force N = on.force; initial equation P.center.x = 0; P.center.y = 0.1; end Platform;""")
    w = 2 * np.pi * np.array([0.3, 2.0])
    excited, seen = ["F.force[1]", "F.force[2]", "platform.y"], ["P.center.x", "P.center.y", "N"]
    response = model.response(excited, seen, frequencies=w / (2 * np.pi))
    for k, x in enumerate(w):
        close(response.values[k], [[1 / (50 - 2 * x**2), 0, 0], [0, 0, 1], [0, -1, -2 * x**2]])
    linear = model.linearize(excitations=["F.force[1]"], outputs=["N"])
    assert linear.coordinates == ("P.center.x",) and linear.notes
    close(linear.outputs_at_point, [2 * G])
    close(model.modes(about="start").omega, [5])


# ---------------------------------------------------------------- friction


BLOCK = """model Held Frame incline = turn(world, {angle}[deg]); Block b(m = 1, base = incline); {what} end Held;"""


@pytest.mark.parametrize("what", ["Friction f(mu = {mu}, normal = 9.81*cos({angle}[deg]), rate = b.v);",
                                  "DryFriction f(F = {mu}*9.81*cos({angle}[deg]), rate = b.v);"])
@pytest.mark.parametrize(("angle", "mu", "holds"), [(20, 0.7, True), (20, 0.3639702343, True), (20, 0.36397, False),
                                                    (-35, 0.71, True)])
def test_a_block_on_a_slope(what: str, angle: float, mu: float, holds: bool, scene: Write) -> None:
    """tan 20 deg = 0.36397023426620234 is enough."""
    model = scene(BLOCK.format(angle=angle, what=what.format(mu=mu, angle=angle)))
    if not holds:
        with pytest.raises(lag.RunError, match="no equilibrium was found"):
            model.modes()
        assert not model.equilibrium(starts=1).found
        return
    first = model.equilibrium()[0]
    close(first.position["b.s"], 0)
    angle = np.radians(angle)
    close(first.friction["f"], [abs(G * np.sin(angle)), mu * G * np.cos(angle)])
    assert first.stability == "fixed" and len(model.modes()) == 0


@pytest.mark.parametrize("what", ["DryFriction f(F = 8, F_static = {most}, rate = b.v);",
    "AppliedForce f(at = b.center, force = {{-(if abs(b.v) > 0 then 8 else {most})*sign(b.v), 0}});"])
@pytest.mark.parametrize(("most", "holds"), [(10.001, True), (9.999, False)])
def test_what_holds_at_rest_is_static_friction(what: str, most: float, holds: bool, scene: Write) -> None:
    found = scene(f"""model Static World world(gravity = {{5, 0}}); Block b(m = 2, base = world); {what.format(most=most)}
      end Static;""").equilibrium(starts=1)
    assert len(found) == holds
    if holds:
        close(found[0].friction["f"], [10, most])


@pytest.mark.parametrize(("J1", "J2", "k", "tau"), [(1, 0.125, 150, 10), (0.02, 0.09, 5, 1e-3)])
def test_a_locked_clutch_carries_its_other_half(J1: float, J2: float, k: float, tau: float, scene: Write) -> None:
    model = scene(f"""model Clutch World world(gravity = {{0, 0}}); Revolute r1(a = world), r2(a = world);
      Body d1(m = 1, I = {J1}, center = r1.b), d2(m = 1, I = {J2}, center = r2.b);
      TorsionSpring s(a = world, b = d1.center, k = {k}); TorsionDryFriction c(tau = {tau}, a = d1.center, b = d2.center);
      AppliedTorque T(on = d2.center, torque = 0); end Clutch;""")
    modes = model.modes()
    close(modes.omega, [np.sqrt(k / (J1 + J2))])
    close([modes[0].shape["r1.phi"], modes[0].shape["r2.phi"]], [1, 1])
    assert len(modes.notes) == 1 and modes.notes[0].startswith("c sticks")
    assert len(model.equilibrium()) == 1
    w = 3.0
    close(model.response(["T"], ["r1.phi"], frequencies=[w / (2 * np.pi)]).values.ravel(), [1 / (k - (J1 + J2) * w**2)])


@pytest.mark.parametrize(("friction", "name"), [("DryFriction f(a = world, b = p.center, F = 5);", "f"),
                                                ("energy dissipation 5[N]*abs(der(p.s));", "friction")])
def test_what_sticks_at_the_start_stays_there(friction: str, name: str, scene: Write) -> None:
    """p, which friction holds at 0.1 m, draws q off the place that it had without friction: q by 10 0.1/(10 + 30)."""
    model = scene(f"""model Drawn World world(gravity = {{0, 0}}); Block p(m = 1, base = world, s(start = 0.1));
      Block q(m = 2, base = world); Spring s(k = 10, stretch = p.s - q.s), t(k = 30, stretch = q.s); {friction} end Drawn;""")
    found, modes = model.equilibrium(), model.modes()
    close([found[0].position["p.s"], found[0].position["q.s"]], [0.1, 0.025])
    close(modes.omega, [np.sqrt(40 / 2)])
    assert found.is_reached and modes.notes[0].startswith(f"{name} sticks, it holds 0.75 of 5")


def test_a_clutch_on_a_train_of_gears(scene: Write) -> None:
    """k over J1 + (r1/r2)^2 (J2 + J3); with a brake that is held by nothing else no motion is left of J3."""
    train = """model Train World world(gravity = {{0, 0}}); Revolute r1(a = world), r2(a = world), r3(a = world);
      Body d1(m = 1, I = 1, center = r1.b), d2(m = 1, I = 0.5, center = r2.b), d3(m = 1, I = 0.25, center = r3.b);
      Gear g(carrier = world, r_a = 0.1, r_b = 0.2, a = d1.center, b = d2.center);
      TorsionSpring s(k = 8, a = world, b = d1.center); TorsionDryFriction c(tau = {tau}, a = d2.center, b = d3.center),
      brake(tau = {brake}, a = world, b = d3.center); end Train;"""
    close(scene(train.format(tau=5, brake=0)).modes().omega, [np.sqrt(8 / (1 + 0.75 / 4))])
    close(scene(train.format(tau=0, brake=1)).modes().omega, [np.sqrt(8 / (1 + 0.5 / 4))])
    assert len(scene(train.format(tau=5, brake=1)).modes()) == 0


def test_a_load_behind_a_clutch(scene: Write) -> None:
    """The clutch carries a torque of 2 to a spring: both turn by 2/5 where it is strong enough, and nothing rests where not."""
    text = """model Loaded Revolute r1(a = world), r2(a = world);
      Body d1(m = 1, I = 1, center = r1.b), d2(m = 1, I = 0.5, center = r2.b);
      TorsionSpring s(k = 5, a = world, b = d1.center); TorsionDryFriction c(tau = {tau}, a = d1.center, b = d2.center);
      AppliedTorque w(on = d2.center, torque = -2); end Loaded;"""
    model = scene(text.format(tau=2.001))
    first = model.equilibrium()[0]
    close([first.position["r1.phi"], first.position["r2.phi"]], [-0.4, -0.4], 1e-8)
    close(first.friction["c"], [2, 2.001], 1e-8)
    close(model.modes().omega, [np.sqrt(5 / 1.5)])
    with pytest.raises(lag.RunError, match="no equilibrium was found"):
        scene(text.format(tau=1.999)).modes()


@pytest.mark.parametrize(("mu", "rests"), [(0.5, 0.3), (0.2, None)])
def test_a_rough_stop_holds_across_as_much_as_it_presses(mu: float, rests: float | None, scene: Write) -> None:
    """Held by 3 N of mu m g where that is enough; else it settles where the spring does not pull more than that."""
    model = scene(f"""model Rough PointMass P(m = 1); RoughStop floor(a = world, b = P.center, mu = {mu});
      AxialSpring s(a = world, b = P.center, k = 10, along = {{1, 0}});
      initial equation P.center.x = 0.3; P.center.y = 0; end Rough;""")
    first = model.equilibrium()[0]
    x = first.position["P.center.x"]
    close(first.friction["floor"], [10 * x, mu * G])
    assert abs(10 * x) <= mu * G and first.contacts == pytest.approx({"floor": G}) and first.stability == "fixed"
    if rests is not None:
        close(x, rests)


def test_a_block_falls_onto_a_rough_slope_and_carries_a_pendulum(scene: Write) -> None:
    """The pendulum swings as if its pivot were fixed; the slope carries both weights."""
    model = scene("""model Carried Body P(m = 1, I = 0.1); parameter Angle t = 20[deg];
      RoughStop left(a = world, b = shift(P.center, {-0.1, 0}), mu = 0.7, along = {-sin(20[deg]), cos(20[deg])}),
                right(a = world, b = shift(P.center, {0.1, 0}), mu = 0.7, along = {-sin(20[deg]), cos(20[deg])});
      Revolute h(a = P.center, phi(start = -20[deg])); PointMass Q(m = 0.5, center = shift(h.b, {0, -1}));
      initial equation P.center.x = 0; P.center.y = 0; P.center.phi = t; end Carried;""")
    first = model.equilibrium(starts=1)[0]
    close(sum(first.contacts.values()), 1.5 * G * np.cos(np.radians(20)), 1e-8)
    close([x for x, _ in first.friction.values()], [0.75 * G * np.sin(np.radians(20))] * 2, 1e-8)
    modes = model.modes()
    close(modes.omega, [np.sqrt(G)], 1e-8)


def test_friction_on_a_belt_slips_at_rest(scene: Write) -> None:
    """The belt drags with F: k x = F, and swings about there as if nothing held."""
    model = scene("""model Belt2 World world(gravity = {0, 0}); Block b(m = 1, base = world); Spring s(k = 10, stretch = b.s);
      DryFriction f(F = 3, rate = b.v - 2); end Belt2;""")
    first = model.equilibrium()[0]
    close(first.position["b.s"], 0.3)
    assert not first.friction
    close(model.modes().omega, [np.sqrt(10)])


def test_what_is_held_away_from_rest_is_not_linearised(scene: Write) -> None:
    model = scene("""model Pushed PointMass P(m = 1); Stop on(a = world, b = P.center);
      AppliedForce F(at = P.center, force = {1, 0});
      initial equation P.center.x = 0; P.center.y = 0; end Pushed;""")
    with pytest.raises(lag.LagError, match=r"(?s)L0916.*contacts or friction hold: on"):
        model.linearize(about="start")


# ---------------------------------------------------------------- corners


@pytest.mark.parametrize(("what", "is_told"), [
    ("GeneralSpring s(stretch = b.s, V = 50*max(0, -b.s)^2 + 5*max(0, b.s)^2);", True),
    ("GeneralSpring s(stretch = b.s, V = 50*max(0, -b.s)^2 + 5*max(0, b.s)^2 - 0.5*b.s);", False),
    ("AppliedForce s(at = b.center, force = {-table(b.s, {-1, 0, 1}, {-5, 0, 10}), 0});", True),
    ("AppliedForce s(at = b.center, force = {-table(b.s, {-1, 0, 1}, {-5, 0, 5}), 0});", False),
    ("GeneralSpring s(stretch = b.s, V = 2*abs(b.s) + 3*b.s^2);", True),
    ("GeneralSpring s(stretch = b.s, V = 1[N/m2]*abs(b.s)^3 + 3[N/m]*b.s^2);", False),
    ("Spring s(k = 4, stretch = b.s); GeneralDamper d(rate = b.v, D = (if b.v > 0 then 1 else 3)*1[N.s/m]*b.v^2);", True),
    ("Spring s(k = 4, stretch = b.s); QuadraticDamper d(c = 3, rate = b.v);", False),
    ("Spring s(k = 4, stretch = b.s); DryFriction d(F = 1, rate = b.v - 1[m/s]);", False),
])
def test_places_where_forces_bend_are_told(what: str, is_told: bool, scene: Write) -> None:
    """Where stiffness or damping is another one to either side, no frequency is one of small motion."""
    model = scene(f"model Bent World world(gravity = {{0, 0}}); Block b(m = 1, base = world); {what} end Bent;")
    for notes in (model.modes().notes, model.linearize().notes, model.equilibrium().notes):
        assert any("L0743" in note for note in notes) == is_told


RATCHET = "when b.v < 0 then reinit(b.v, 0); end when;"


@pytest.mark.parametrize(("events", "c", "stability", "kind"), [
    ("", 0, "stable", "oscillation"), (RATCHET, 0, "one-sided", "one way"), (RATCHET, 0.3, "one-sided", "one way"),
    ("when b.s < 0 then reinit(b.v, -0.5*pre(b.v)); end when;", 0, "one-sided", "one way"),
    ("when b.s < -1 then reinit(b.v, -0.5*pre(b.v)); end when;", 0, "stable", "oscillation"),
])
def test_what_just_touches_lets_nothing_swing_through(events: str, c: float, stability: str, kind: str, scene: Write) -> None:
    """A block that may go one way ends where the spring draws it to, and stays there: no frequency is that of an oscillation."""
    model = scene(f"""model Ratchet World world(gravity = {{0, 0}}); Block b(m = 1, base = world, v(start = 1));
      Spring s(k = 1, stretch = b.s); Damper d(c = {c}, rate = b.v); equation {events} end Ratchet;""")
    found, modes = model.equilibrium()[0], model.modes()
    assert found.stability == stability and found.is_stable and bool(found.eigenvalues) == (stability == "stable")
    assert modes[0].kind == kind and modes[0].omega == pytest.approx(1)
    assert any("L0743" in note for note in modes.notes) == (kind == "one way")


def test_what_touches_across_the_motion_changes_nothing(scene: Write) -> None:
    """A table that presses on nothing beside a spring along it."""
    model = scene("""model Beside World world(gravity = {0, 0}); Block x(m = 1, base = world); Block y(m = 1, base = world);
      Spring s(k = 4, stretch = x.s); Spring r(k = 9, stretch = y.s);
      equation when y.s < 0 then reinit(y.v, 0); end when; end Beside;""")
    assert [(mode.kind, mode.omega) for mode in model.modes()] == [("oscillation", 2), ("one way", 3)]


# ---------------------------------------------------------------- time


@pytest.mark.parametrize(("what", "is_told"), [
    ("Frame pivot = shift(world, {0, 0.05*cos(200*time)}); Revolute h(a = pivot);", True),
    ("Frame pivot = shift(world, {0.05*cos(200*time), 0}); Revolute h(a = pivot);", False),
    ("Revolute h(a = world); AppliedForce f(at = P.center, force = {0, 3*sin(2*time)});", True),
    ("Revolute h(a = world); AppliedForce f(at = P.center, force = {3*sin(2*time), 0});", False),
    ("Revolute h(a = world); TorsionSpring s(k = 2, twist = h.phi*(1 + 0.2*sin(3*time)));", True),
])
def test_coefficients_that_change_with_time_are_told(what: str, is_told: bool, scene: Write) -> None:
    """Of a hanging pendulum: a pivot that shakes up and down, a load along it, a spring that changes; not what pushes aside."""
    model = scene(f"model Timed {what} PointMass P(m = 1, center = shift(h.b, {{0, -1}})); end Timed;")
    for notes in (model.modes().notes, model.linearize().notes, model.equilibrium().notes):
        assert any(note.startswith("warning[L0740]") for note in notes) == is_told


def test_a_bead_on_a_turning_rod_has_coefficients_that_stay(scene: Write) -> None:
    """k/m - W^2; what time does to the damping of it is rounding alone."""
    modes = scene("""model Turning World world(gravity = {0, 0}); Revolute h(a = world); Motion d(of = h.phi, to = 3*time);
      Block b(m = 1, base = h.b); Spring s(k = 25, stretch = b.s); end Turning;""").modes()
    close(modes.omega, [4])
    assert not modes.notes


@pytest.mark.parametrize(("to", "is_told"), [("0.05*cos(200*time)", True), ("0.05", False)])
def test_a_rod_to_a_support_that_moves_is_told(to: str, is_told: bool, scene: Write) -> None:
    """Kapitza's pendulum of a rod, whose equation knows the time."""
    model = scene(f"model Timed Prismatic g(a = world, along = {{0, 1}}); Motion drive(of = g.s, to = {to}); "
                  "PointMass P(m = 1, center(y(start = -1))); Link rod(a = g.b, b = P.center, L = 1); end Timed;")
    for notes in (model.modes().notes, model.linearize().notes, model.equilibrium().notes):
        assert any(note.startswith("warning[L0740]") for note in notes) == is_told


@pytest.mark.parametrize(("mu", "rests"), [(0.289, True), (0.288, False)])
def test_a_ladder_against_a_smooth_wall(mu: float, rests: bool, scene: Write) -> None:
    """At 60 degrees it takes mu = 1/(2 tan 60 deg) = 0.288675 at its foot; the wall carries what the foot holds."""
    found = scene(f"""model Ladder Bar b(m = 1, L = 2); RoughStop floor(a = world, b = b.a, mu = {mu});
      Stop wall(a = world, b = b.b, along = {{-1, 0}});
      initial equation b.center.phi = 60[deg]; b.a.y = 0; b.b.x = 0; end Ladder;""").equilibrium(starts=1)
    is_start = bool(found.found) and abs(found[0].position["b.center.phi"] - np.pi / 3) < 1e-9
    assert is_start == rests
    if rests:
        push = G / (2 * np.tan(np.pi / 3))
        assert found[0].contacts == pytest.approx({"floor": G, "wall": push})
        close(found[0].friction["floor"], [push, mu * G])


def test_friction_holds_against_a_turning_frame(scene: Write) -> None:
    """A block on a turntable: m w^2 r = 2 N of 3 N."""
    first = scene("""model Table2 Frame turning = turn(world, 2*time); World world(gravity = {0, 0});
      Block b(m = 1, base = turning, s(start = 0.5)); DryFriction f(F = 3, rate = b.v); end Table2;""").equilibrium()[0]
    close(first.position["b.s"], 0.5)
    close(first.friction["f"], [2, 3])


PUCK = """model Puck World world(gravity = {0, 0});
  PointMass b(m = 1, center(r(start = {%.17g, %.17g})));
  Spring k(k = 10, a = world, b = b.center);
  SlidingFriction f(mu = 0.2, mu_static = 0.3, normal = 9.81, a = world, b = b.center); end Puck;"""


@pytest.mark.parametrize("angle", [0.0, 0.3, np.pi / 4, 2.0, -2.5])
@pytest.mark.parametrize("share", [0.5, 0.9999, 1.0001, 1.3])
def test_friction_in_the_plane_holds_inside_its_cone(angle: float, share: float, scene: Write) -> None:
    """Up to mu_static N in each direction; beyond, nothing holds where it starts."""
    limit = 0.3 * 9.81
    start = share * limit / 10 * np.array([np.cos(angle), np.sin(angle)])
    model = scene(PUCK % tuple(start))
    first = model.equilibrium().found[0]
    place = [first.position["b.center.x"], first.position["b.center.y"]]
    if share < 1:
        close(place, start)
        close(first.friction["f"], (share * limit, limit))
        assert model.modes().modes == ()
    else:
        assert np.hypot(*place) < 0.9 * limit / 10


@pytest.mark.parametrize("law", ["-3*b.center.v/norm(b.center.v)", "-b.center.v*(3/norm(b.center.v))"])
def test_friction_in_the_plane_written_as_a_force_holds(law: str, scene: Write) -> None:
    """2.5 of 3 N. It was told to rest elsewhere, and to be damped as exp(-2e150 t): no corner of |x| stands in it."""
    rub = f"AppliedForce f(at = b.center, force = {law}); end Puck;"
    model = scene((PUCK % (0.15, 0.2)).partition("SlidingFriction")[0] + rub)
    first = model.equilibrium().found[0]
    close([first.position["b.center.x"], first.position["b.center.y"]], [0.15, 0.2])
    close(first.friction["f"], (2.5, 3))
    assert len(model.modes()) == 0


@pytest.mark.parametrize(("phi", "torque", "holds"), [
    (0.0, 5.99, True), (0.5, 5.99, True), (np.pi / 4, 5.99, True), (2.0, 5.99, True), (0.5, 6.01, False)])
def test_an_arm_whose_tip_rubs_in_the_plane(phi: float, torque: float, holds: bool, scene: Write) -> None:
    """mu N L = 6 N.m, whichever way it points: both components of the slip are one rate."""
    model = scene(f"""model Arm World world(gravity = {{0, 0}});
      Revolute h(a = world, phi(start = {phi})); Bar d(m = 1, L = 2, a = h.b); AppliedTorque t(on = h.b, torque = {torque});
      SlidingFriction f(mu = 0.3, normal = 10, a = world, b = d.b); end Arm;""")
    found = model.equilibrium().found
    assert [rest.position["h.phi"] for rest in found] == ([pytest.approx(phi)] if holds else [])


# ---------------------------------------------------------------- supports that move


def test_a_mass_on_a_rough_table_that_sways(scene: Write) -> None:
    """Time stands still: the table's weight is carried, and nothing draws at it. It ended in an error of the compiler."""
    model = scene("""model Sways Frame table = shift(world, {0.02[m]*sin(3[rad/s]*time), 0}); PointMass p(m = 2);
      RoughStop s(a = table, b = p.center, mu = 0.5); initial equation p.center.x = 0; p.center.y = 0; end Sways;""")
    found = model.equilibrium()[0]
    assert found.contacts == pytest.approx({"s": 2 * G}) and found.stability == "fixed"
    assert len(model.modes()) == 0


MOVED = {
    "a cam": ("Block f(m = 1, base = world, along = {0, 1}); Spring back(k = 200, stretch = f.s + 0.02);"
              "Stop s(gap = f.s - 0.01[m]*(1 - cos(10[rad/s]*time)));", G + 4 + 1),
    "a table": ("Frame table = shift(world, {0, 0.002[m]*(1 - cos(10[rad/s]*time))}); PointMass p(m = 2);"
                "Stop s(a = table, b = p.center);", 2 * (G + 0.2)),
    "a lift": ("Prismatic l(a = world, along = {0, 1}); Motion d(of = l.s, to = 0.5[m/s2]*time^2);"
               "Block b(m = 2, base = l.b, along = {0, 1}); Stop s(gap = b.s);", 2 * (G + 1)),
    "an incline": ("Frame t = turn(shift(world, {0, -0.1[m/s2]*time^2}), 0.3); Block b(m = 2, base = t);"
                   "Stop s(gap = b.s);", 2 * (G - 0.2) * np.sin(0.3)),
}


@pytest.mark.parametrize("case", MOVED)
@pytest.mark.parametrize("solver", ["auto", "implicit"])
def test_the_first_row_on_a_support_that_moves_has_the_force_of_the_next_ones(case: str, solver: str, scene: Write) -> None:
    text, force = MOVED[case]
    model = scene(f"model Moved {text} output Force N = s.force; end Moved;")
    run = model.simulate(at=[0, 1e-6, 1e-4], solver=solver, tolerance=1e-9)
    np.testing.assert_allclose(run["N"][:2], force, rtol=0, atol=1e-8)
    np.testing.assert_allclose(run["N"][2], force, rtol=0, atol=1e-5)


@pytest.mark.parametrize("command", ["equilibrium", "modes"])
def test_forces_beyond_all_numbers_have_no_rest(command: str, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "big.lag").write_text("model M Block b(m = 1e308, base = world, s(start = 1e308)); "
                                      "Spring s(a = world, b = b.center, k = 1e308); end M;")
    assert main([command, str(tmp_path / "big.lag")]) == 1
    told = capfd.readouterr()
    assert "no equilibrium was found" in told.err and "DLASCL" not in told.out + told.err  # which LAPACK says past Python


HELD = """World world(gravity = {0, 0}); Block b(m = 1, base = world); DryFriction f(F = 2, rate = b.v);
  AppliedForce p(at = b.center, force = {-1, 0});"""


@pytest.mark.parametrize(("law", "x"), [
    ("if b.v > 0 then 1 else 0", 0), ("if b.v >= 0 then 1 else 0", 1), ("sign(b.v)", 0), ("if b.v == 0 then 3 else 0", 3)])
def test_first_order_states_know_what_sticks_on_its_level(scene: Write, law: str, x: float) -> None:
    """Nothing balanced: half of the condition was taken."""
    model = scene(f"model Asked {HELD} Real x(start = 0.5); equation der(x) = 1[1/s]*(({law}) - x); end Asked;")
    assert model.equilibrium().found[0].position["x"] == pytest.approx(x, abs=1e-12)


@pytest.mark.parametrize(("law", "right"), [("if b.v > 0 then 1 else 0.6", 0.6), ("if b.v >= 0 then 1 else 0.6", 1),
                                           ("if sign(b.v) == 0 then 0.6 else 1", 0.6)])
def test_linear_models_know_it_too(scene: Write, law: str, right: float) -> None:
    """Of stiffness, input and output of what is not held; B was 0.8."""
    model = scene(f"""model Asked {HELD} Block c(m = 1, base = world); Spring k(k = 4, stretch = c.s); input Force u;
      AppliedForce q(at = c.center, force = {{({law})*(u - c.s*1[N/m]), 0}}); output Length y = ({law})*c.s;
      output Force held = f.F*sign(f.rate); end Asked;""")
    linear = model.linearize(outputs=["y", "held"])
    close(linear.A, [[0, 1], [-4 - right, 0]])
    close(linear.B, [[0], [right]])
    close(linear.output, [[right, 0], [0, 0]])
    close(linear.outputs_at_point, [0, -1])
    assert model.modes().modes[0].omega2 == pytest.approx(4 + right, abs=1e-12)
