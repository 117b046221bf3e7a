"""Contacts that resets tell of, whose walls move: bounces end there, and what rests goes along, is left behind or caught."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "implicit")
AT = [0.4, 0.7, 1.2, 1.5, 2.0, 3.0]


def falling(law: str, event: str) -> str:
    """A block over a wall, which moves as `law` says."""
    return f"""model Falling
      parameter Real e = 0.5, A = 0.1, w = 3;
      World world(gravity = {{0, -9.81}});
      Prismatic x(a = world, along = {{0, 1}});
      Block b(m = 1, base = world, along = {{0, 1}}, s(start = 1));
      {"Stop stop(e = e, gap = b.s - x.s);" if not event else ""}
    equation
      x.s = {law};
      {event}
    end Falling;"""


BOUNCE = "when b.s < x.s then reinit(b.v, x.v - e*(b.v - x.v)); end when;"
WALLS = [
    ("0.3*time/1[s]", BOUNCE),  # -12.83 for 0.9 at 3 s
    ("0.001*time/1[s]", BOUNCE),
    ("A*sin(w*time/1[s])", BOUNCE),
    ("A*sin(w*time/1[s])", "when x.s - b.s >= 0 then reinit(der(b.s), -e*pre(b.v) + (1 + e)*der(x.s)); end when;"),
    ("0.3*abs(time/1[s] - 0.5)", BOUNCE),
    ("0.3*max(0, time/1[s] - 1.4)", BOUNCE),  # the wall stood still wherever it was looked at
    ("if time < 2.2 then 0 else 0.3*(time/1[s] - 2.2)", BOUNCE),
    ("0.2*time/1[s] - 6*max(0, time/1[s] - 1.3)^2", BOUNCE),  # goes away faster than what lies on it falls
    ("0.3*time/1[s]", "when b.s < 0.3*time/1[s] then reinit(b.v, 0.3 + e*abs(b.v - 0.3)); end when;"),
    ("1e-9*time/1[s]", BOUNCE),  # without end, with e = 0
    ("0.3*time/1[s]", "when b.s < x.s then reinit(b.v, if time < 0.6 then x.v - e*(b.v - x.v) elseif b.v < x.v then "
                      "0.3 + e*abs(b.v - 0.3) else b.v); end when;"),  # which turns back in all that it can be
    ("0.3*time/1[s]", "when b.s < x.s then reinit(b.v, min(50, x.v + max(0, -e*(b.v - x.v)))); end when;"),
]


@pytest.mark.parametrize(("law", "event"), WALLS)
def test_a_wall_that_moves_is_one_of_the_library(scene: Write, law: str, event: str) -> None:
    """What came to rest fell through it, or there was no progress (e = 0)."""
    wall, stop = scene(falling(law, event)), scene(falling(law, ""))
    for given in ({"e": 0.5}, {"e": 0.0, "A": 0.2, "w": 8.0}):
        right = stop.simulate(at=AT, solver="erk", tolerance=1e-10, parameters=given)
        for solver in SOLVERS:
            for tolerance in (1e-3, 1e-9):
                run = wall.simulate(at=AT, solver=solver, tolerance=tolerance, parameters=given)
                np.testing.assert_allclose(run["b.s"], right["b.s"], rtol=0, atol=tolerance, err_msg=f"{solver} {tolerance}")
                np.testing.assert_allclose(run.energy.dissipated, right.energy.dissipated, rtol=0, atol=1e2*tolerance)


@pytest.mark.parametrize("e", [0.5, 0.0])
def test_a_wall_that_is_a_body(scene: Write, e: float) -> None:
    """It is not reset, and so it goes on as if nothing lay on it: as one whose motion is given in time."""
    text = """model Plate
      parameter Real e = 0.5;
      World world(gravity = {{0, -10}});
      {wall}
      Block b(m = 1, base = world, along = {{0, 1}}, s(start = 1));
    equation
      {law}
      when b.s < x.s then reinit(b.v, x.v - e*(b.v - x.v)); end when;
    end Plate;"""
    body = "Block x(m = 2, base = world, along = {0, 1}, s(start = 0.1)); Spring k(stretch = x.s, k = 200);"
    model = scene(text.format(wall=body, law=""))
    right = scene(text.format(wall="Prismatic x(a = world, along = {0, 1});", law="x.s = 0.2*cos(10*time/1[s]) - 0.1;"))
    at, given = [0.4, 0.7, 0.9, 1.3, 1.8, 2.0], {"e": e}
    place = right.simulate(at=at, solver="erk", tolerance=1e-11, parameters=given)["b.s"]
    for solver in SOLVERS:
        found = model.simulate(at=at, solver=solver, tolerance=1e-10, parameters=given)["b.s"]
        np.testing.assert_allclose(found, place, rtol=0, atol=1e-6, err_msg=solver)


NO_WALLS = [  # resets, and what they make of the rate v: no contacts
    ("3", lambda v: 3), ("x.v + 2", lambda v: 2.3), ("b.v + 5", lambda v: v + 5), ("x.v - 0.5*b.v", lambda v: 0.3 - 0.5*v),
]


@pytest.mark.parametrize(("reset", "after"), NO_WALLS)
def test_kicks_at_a_wall_that_moves(scene: Write, reset: str, after: Callable[[float], float]) -> None:
    model = scene(falling("0.3*time/1[s] - 2", f"when b.s < x.s then reinit(b.v, {reset}); end when;"))
    hit = (-0.3 + np.sqrt(0.09 + 6*9.81))/9.81
    run = model.simulate(at=[hit + 0.1], tolerance=1e-9)
    assert run["b.s"][0] == pytest.approx(0.3*hit - 2 + 0.1*after(-9.81*hit) - 9.81*0.1**2/2, abs=1e-9)


GONE = ["when b.s < l then reinit(b.v, 0); end when;", "when b.s < 0 then l = -5; end when;"]


@pytest.mark.parametrize("order", [1, -1])
def test_a_wall_that_goes_where_it_is_reached(scene: Write, order: int) -> None:
    """Written first, it stopped what falls, once."""
    model = scene(f"""model Gone
      World world(gravity = {{0, -10}});
      Block b(m = 1, base = world, along = {{0, 1}}, s(start = 1));
      discrete Length l(start = 0);
    equation
      {" ".join(GONE[::order])}
    end Gone;""")
    for solver in SOLVERS:
        found = model.simulate(at=[0.3, 0.5, 1.0, 1.5], solver=solver, tolerance=1e-9)["b.s"]
        np.testing.assert_allclose(found, [0.55, -0.25, -4.0, -5.0], rtol=0, atol=1e-9, err_msg=solver)


MET = [  # what sets the rates of both, by names or by numbers
    ("b.v + (1 + e)*m2*(x.v - b.v)/(m1 + m2)", "x.v + (1 + e)*m1*(b.v - x.v)/(m1 + m2)", ""),
    ("(m1*b.v + m2*x.v + e*m2*(x.v - b.v))/(m1 + m2)", "(m1*b.v + m2*x.v + e*m1*(b.v - x.v))/(m1 + m2)", "n = pre(n) + 1;"),
    ("b.v + (1 + e)*2*(x.v - b.v)/3", "x.v + (1 + e)*(b.v - x.v)/3", ""),
]


def meeting(event: str, declared: str = "") -> str:
    return f"""model Meeting
      parameter Real e = 0.5;
      parameter Mass m1 = 1, m2 = 2;
      World world(gravity = {{0, -9.81}});
      Block x(m = m2, base = world, along = {{0, 1}}), b(m = m1, base = world, along = {{0, 1}}, s(start = 1));
      Spring k(stretch = x.s + 0.05, k = 400);
      {declared}
    equation
      {event}
    end Meeting;"""


@pytest.mark.parametrize("e", [0.5, 0.0])
def test_bodies_that_are_both_reset_rest_on_each_other(scene: Write, e: float) -> None:
    """An impulse between them does the same: the upper one fell through the lower one when bounces ended (-9.1 for -0.12)."""
    at, given = [0.4, 0.7, 1.2, 2.0, 3.0], {"e": e}
    right = scene(meeting("", "Stop stop(e = e, gap = b.s - x.s);").replace("equation", "")).simulate(
        at=at, solver="erk", tolerance=1e-11, parameters=given)
    for upper, lower, more in MET:
        model = scene(meeting(f"when b.s < x.s then reinit(b.v, {upper}); reinit(x.v, {lower}); {more} end when;",
                              "discrete Integer n(start = 0);" if more else ""))
        assert any("for the masses as they are declared" in x for x in model.warnings) == ("3" in upper)
        for solver in SOLVERS:
            run = model.simulate(at=at, solver=solver, tolerance=1e-9, parameters=given)
            for name in ("b.s", "x.s"):
                np.testing.assert_allclose(run[name], right[name], rtol=0, atol=1e-7, err_msg=f"{solver} {upper}")


BETWEEN = ("b.v + (1 + e)*m2*(x.v - b.v)/(m1 + m2)", "x.v + (1 + e)*m1*(b.v - x.v)/(m1 + m2)")
BRANCHES = [  # values that are those of a contact in some of their branches, and b.s at 0.5 s
    (falling("-0.3*time/1[s]", "when b.s < x.s then reinit(b.v, if b.v - x.v < -3 then b.v + 1 else x.v - e*(b.v - x.v)); "
                               "end when;"),
     -0.2093891005),
    (falling("0", "when b.s < x.s then reinit(b.v, if b.v < -3 then b.v + 1 else -e*b.v); end when;"), -0.177773641),
    (falling("-0.3*time/1[s]", "when b.s < x.s then reinit(b.v, if b.s < 0 then b.v + 1 else x.v - e*(b.v - x.v)); end when;"),
     -0.2093891005),  # was refused
    (meeting(f"when b.s < x.s then reinit(b.v, if time > 0.46 then {BETWEEN[0]} else b.v + 5); reinit(x.v, {BETWEEN[1]}); "
             "end when;"),
     0.0155273793),  # a kick at 0.4516 s
    (meeting(f"when b.s < x.s then reinit(b.v, if b.v - x.v < -3 then b.v + 1 else {BETWEEN[0]}); "
             f"reinit(x.v, if b.v - x.v < -3 then x.v - 0.5 else {BETWEEN[1]}); end when;"), -0.1778945241),
    (meeting(f"when b.s < x.s then reinit(b.v, if n > 3 then {BETWEEN[0]} else b.v + 5); reinit(x.v, {BETWEEN[1]}); "
             "n = pre(n) + 1; end when;", "discrete Integer n(start = 0);"), 0.0155273793),
]


@pytest.mark.parametrize(("text", "place"), BRANCHES)
def test_what_is_a_contact_in_some_branches_is_what_is_written(scene: Write, text: str, place: float) -> None:
    """It was looked at in one of them: kicks were left out, and what breaks through was turned back, without a word."""
    given = {"e": 0.0} if "Meeting" in text else {}
    model = scene(text)
    assert any("in some of its branches" in x for x in model.warnings)
    assert model.simulate(at=[0.5], tolerance=1e-9, parameters=given)["b.s"][0] == pytest.approx(place, abs=1e-8)


def test_walls_on_both_sides_that_branches_tell_apart(scene: Write) -> None:
    """abs in the gap and the comparison in what is set choose together: each of them turns back."""
    event = "when abs(b.s - 0.5) > 0.6 then reinit(b.v, if b.s > 0.5 then -e*abs(b.v) else e*abs(b.v)); end when;"
    model = scene(falling("0", event))
    assert not any("branches" in x for x in model.warnings)
    assert model.simulate(at=[3.0], tolerance=1e-9)["b.s"][0] == pytest.approx(-0.1, abs=1e-8)


def test_parameters_choose_as_they_are_declared(scene: Write) -> None:
    """They were taken for about 1 where they are 0."""
    text = meeting(f"when b.s < x.s then reinit(b.v, if k2 > 0.5 then {BETWEEN[0]} else b.v + 5); reinit(x.v, {BETWEEN[1]}); "
                   "end when;",
                   "parameter Real k2 = 0;").replace("e = 0.5", "e = 0")
    assert scene(text).simulate(at=[0.5], tolerance=1e-9)["b.s"][0] == pytest.approx(0.0155273793, abs=1e-8)
    held = scene(text.replace("k2 = 0", "k2 = 1")).simulate(at=[3.0], tolerance=1e-9)
    assert held["b.s"][0] == pytest.approx(held["x.s"][0], abs=1e-8)


@pytest.mark.parametrize("text", [meeting(f"when b.s < x.s then reinit(b.v, {BETWEEN[0]}); reinit(x.v, {BETWEEN[1]});"
                                          " end when;"), falling("0.1*time/1[s]", BOUNCE),
                                  falling("0", "when b.s < 0 then reinit(b.v, -e*b.v); end when;")])
def test_contacts_that_turn_nothing_back_in_a_run_end_it(scene: Write, text: str) -> None:
    """With e < 0 what was known as a contact was struck again and again, or passed, without a word. Where e alone tells, it has a
    minimum."""
    with pytest.raises((lag.LagError, lag.RunError), match=r"does not turn back what approaches|ceases to be a contact"):
        scene(text).simulate(at=[1.0], parameters={"e": -0.5})


def test_a_reset_that_moves_its_own_wall_is_what_is_written(scene: Write) -> None:
    """It set y.v to 3.2 and made 1.045 J 3.895 J, as the impulse moved x."""
    model = scene("""model Carried
      parameter Real e = 0.5;
      World world(gravity = {0, 0});
      Prismatic x(a = world), y(a = x.b, s(start = 1));
      PointMass M(m = 1, center = x.b), m(m = 2, center = y.b);
    equation
      when x.s + y.s < 0 then reinit(y.v, -x.v - e*(x.v + y.v)); end when;
    initial equation
      x.v = 0.3; y.v = -1.3;
    end Carried;""")
    run = model.simulate(at=[0.9, 2.0], tolerance=1e-9)
    np.testing.assert_allclose([run["y.v"][1], run["x.v"][1], *run.energy.kinetic], [0.2, -0.7, 1.045, 0.495], atol=1e-8)
    assert any("moves along what it is turned back from" in x for x in model.warnings)


@pytest.mark.parametrize(("condition", "begin"), [
    ("floor(time^2) >= 4", 2.0), ("sign(floor(time^2) - 1) > 0", 2**0.5), ("ceil(time^2) > 2", 2**0.5),
    ("floor(floor(time^2)/2) > 0", 2**0.5), ("0.1*floor(time^2) > 0.25", 3**0.5)])
def test_what_begins_at_a_whole_number_of_what_bends_in_time(scene: Write, condition: str, begin: float) -> None:
    """A floor that is let down, and a force: no slope tells of jumps, which were taken for none (both from 0 s on, or never)."""
    model = scene(f"""model Beginning "one block on a floor, one that is pushed"
      World world(gravity = {{0, -2}});
      Block a(m = 1, base = world, along = {{0, 1}}), b(m = 1, base = world);
      Stop f(e = 0, gap = a.s + (if {condition} then 10[m] else 0[m]));
      energy work (if {condition} then 2[N] else 0[N]) on b.s;
    end Beginning;""")
    for solver in ("auto", "implicit"):
        run = model.simulate(at=[begin - 0.1, 2.9], tolerance=1e-9, solver=solver)
        np.testing.assert_allclose(run["b.s"], [0, (2.9 - begin)**2], rtol=0, atol=1e-7)
        np.testing.assert_allclose(run["a.s"], -run["b.s"], rtol=0, atol=1e-7)


def test_bodies_that_meet_beside_a_loop_rest_on_each_other(scene: Write) -> None:
    """They fell through each other without a word, as some loop was in the scene."""
    loop = """Revolute A(a = shift(world, {5, 0}), phi(start = 0.8)), B(a = shift(world, {6, 0}), phi(start = 0.8));
      Bar p(m = 1, L = 1, a = A.b), q(m = 1, L = 1, a = B.b), top(m = 3, L = 1);
      Revolute A2(a = p.b, b = top.a), B2(a = q.b, b = top.b);"""
    event = f"when b.s < x.s then reinit(b.v, {BETWEEN[0]}); reinit(x.v, {BETWEEN[1]}); end when;"
    run = scene(meeting(event, loop)).simulate(at=[1.2, 3.0], tolerance=1e-9)
    np.testing.assert_allclose(run["b.s"], [-0.1129528487, -0.0958700766], rtol=0, atol=1e-7)


@pytest.mark.parametrize("sets", [("x.v", "b.v"), ("x.v - 0.5*(b.v - x.v)", "x.v + 0*b.v")])
def test_what_turns_back_without_an_impulse_between_is_told(scene: Write, sets: tuple[str, str]) -> None:
    """Bodies of 1 kg and 2 kg."""
    text = meeting(f"when b.s < x.s then reinit(b.v, {sets[0]}); reinit(x.v, {sets[1]}); end when;")
    assert any("no impulse between them" in x for x in scene(text).warnings)


def test_discs_that_meet_in_the_plane(scene: Write) -> None:
    """Four rates along the line of their centres."""
    impulse = "((1 + e)*m1*m2/(m1 + m2)*((ax.v - cx.v)*nx + (ay.v - cy.v)*ny))"
    text = """model Discs
      parameter Real e = 0;
      parameter Mass m1 = 1, m2 = 3;
      World world(gravity = {{0, -9.81}});
      Prismatic ax(a = world, s(start = -0.1)), ay(a = ax.b, along = {{0, 1}}, s(start = 2));
      Prismatic cx(a = world), cy(a = cx.b, along = {{0, 1}}, s(start = 0.5));
      PointMass A(m = m1, center = ay.b), C(m = m2, center = cy.b);
      Spring k(stretch = cy.s - 0.5, k = 300), k2(stretch = cx.s, k = 100);
      Real d = sqrt((ax.s - cx.s)^2 + (ay.s - cy.s)^2), nx = (cx.s - ax.s)/d, ny = (cy.s - ay.s)/d;
      {}
    end Discs;"""
    event = f"""equation when d < 0.4 then
      reinit(ax.v, ax.v - {impulse}*nx/m1); reinit(ay.v, ay.v - {impulse}*ny/m1);
      reinit(cx.v, cx.v + {impulse}*nx/m2); reinit(cy.v, cy.v + {impulse}*ny/m2);
    end when;"""
    right, run = (scene(text.format(x)).simulate(at=[0.6, 0.8, 0.9, 1.2], tolerance=1e-10)
                  for x in ("Stop stop(e = e, gap = d - 0.4);", event))
    for name in ("ax.s", "ay.s", "cx.s", "cy.s"):
        np.testing.assert_allclose(run[name], right[name], rtol=0, atol=1e-8)


def test_what_is_a_contact_as_declared_alone_is_told_and_holds(scene: Write) -> None:
    """It was a kick, through which what fell there went (-12.83 for 0.9 m)."""
    model = scene(falling("0.3*time/1[s]", "when b.s < x.s then reinit(b.v, -e*b.v + 1.5*x.v); end when;"))
    assert any("for parameters as they are declared" in x for x in model.warnings)
    assert model.simulate(at=[3.0], solver="erk")["b.s"][0] == pytest.approx(0.9, abs=1e-7)


@pytest.mark.parametrize("law", ["0.3*max(0, time/1[s] - 1200)", "if time < 1200 then 0 else 0.3*(time/1[s] - 1200)"])
def test_walls_that_set_out_late_carry_along_what_lies_there(scene: Write, law: str) -> None:
    """They stand still at all times up to 1100 s, and still take part in what is turned back: a kick does not rest."""
    model = scene(falling(law, BOUNCE))
    assert not any("kick" in x for x in model.warnings)
    np.testing.assert_allclose(model.simulate(at=[1190, 1210], solver="erk")["b.s"], [0, 3], rtol=0, atol=1e-6)
    kick = scene(falling(law, "when b.s < x.s then reinit(b.v, -e*b.v); end when;"))
    assert any("it is a kick" in x for x in kick.warnings)


@pytest.mark.parametrize("start", [0.3, 1.0])
@pytest.mark.parametrize("law", ["floor(u)", "div(u, 1)", "sign(floor(u))", "(if u < 1 then 0 else 1)",
                                 "(if u > 1 then 1 else 0)", "(if floor(u) > 0 then 1 else 0)",
                                 "(if floor(u) >= 1 then 1 else 0)", "(if ceil(u) >= 2 then 1 else 0)",
                                 "(if u - floor(u) < u then 1 else 0)"])
def test_floors_that_inputs_let_down(scene: Write, law: str, start: float) -> None:
    """By 0.1 m at 0.8 s: what lies there falls, as inputs alone tell when (it stayed for 0.4 s, or for good)."""
    model = scene(f"""model Falling "a block on a floor"
      input Real u = 0;
      World world(gravity = {{0, -9.81}});
      Block b(m = 1, base = world, along = {{0, 1}}, s(start = {start}));
      Stop f(e = 0, gap = b.s - 0.3 + 0.1*({law}));
    end Falling;""")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.7, 0.85, 0.9, 1.1], inputs=([0, 2], {"u": [0.2, 2.2]}), tolerance=1e-9, solver=solver)
        np.testing.assert_allclose(run["b.s"], [0.3, 0.3 - 9.81/2*0.05**2, 0.3 - 9.81/2*0.1**2, 0.2], rtol=0, atol=1e-7)


def test_bodies_that_meet_beside_a_loop(scene: Write) -> None:
    """Constraints give impulses of their own; these do not matter here."""
    loop = """Prismatic p(a = world, s(start = 3)), r(a = world, along = {0, 1}, s(start = 4));
      PointMass P(m = 1, center = p.b), R(m = 1, center = r.b);"""
    event = f"when b.s < x.s then reinit(b.v, {MET[0][0]}); reinit(x.v, {MET[0][1]}); end when;"
    model, right = scene(meeting("p.s^2 + r.s^2 = 25; " + event, loop)), scene(meeting("", "Stop stop(e = e, gap = b.s - x.s);"))
    assert not model.warnings
    at = [0.7, 1.2, 2.0, 3.0]
    np.testing.assert_allclose(model.simulate(at=at, tolerance=1e-9)["b.s"], right.simulate(at=at, tolerance=1e-11)["b.s"],
                               rtol=0, atol=1e-7)
