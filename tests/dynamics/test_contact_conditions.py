"""Conditions of resets that turn back: each is that of a contact, which holds what comes to rest, or is told to hold nothing."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "implicit")
AT = [0.4, 0.7, 0.9, 3.0]


def thrown(event: str, declared: str = "", g: float = -10, start: float = 1) -> str:
    return f"""model Thrown
      parameter Real e = 0.5;
      World world(gravity = {{{g}, 0}});
      Block b(m = 1, base = world, s(start = {start}));
      {declared}
    equation
      {event}
    end Thrown;"""


def height(t: float, h: float, e: float = 0.5) -> float:
    """Above a floor, of what falls from h with 10 m/s2."""
    begin, v = 0.0, 0.0
    while True:
        hit = (v + np.sqrt(v**2 + 20*h))/10
        if t < begin + hit:
            return h + v*(t - begin) - 5*(t - begin)**2
        begin, v, h = begin + hit, e*(10*hit - v), 0.0
        if v < 1e-9:
            return 0.0


START = "initial equation b.v = 0.1;"
BACK = "reinit(b.v, -e*b.v); end when;"
OBSTACLES = [("b.s < 0.5 and b.s > -0.5", 0.0), ("b.s > -0.5 and b.s < 0.5", 0.0), ("b.s > 0.7 and b.s < 1.7", 1.2),
             ("sign(b.s - 0.5) < 0 and b.s > -0.5", 0.0), ("floor(b.s + 0.5) == 0", 0.0),
             ("abs(b.s - 1) < 0.5", 1.0), ("min(0.5 - b.s, b.s + 0.5) > 0", 0.0), ("not (b.s >= 0.5 or b.s <= -0.5)", 0.0)]


@pytest.mark.parametrize(("condition", "middle"), OBSTACLES)
@pytest.mark.parametrize("side", [1, -1])
def test_obstacles_are_contacts_on_both_sides(scene: Write, condition: str, middle: float, side: int) -> None:
    """The side that is written last was gone through when bounces had ended (30 for -0.5)."""
    model = scene(thrown(f"when {condition} then {BACK}", g=-10*side, start=middle + side))
    assert not model.warnings
    right = [middle + side*(0.5 + height(t, 0.5)) for t in AT]
    for solver in SOLVERS:
        np.testing.assert_allclose(model.simulate(at=AT, solver=solver, tolerance=1e-9)["b.s"], right, rtol=0, atol=1e-8)


@pytest.mark.parametrize("side", [1, -1])
@pytest.mark.parametrize("wall", ["Block x(m = 1e9, base = world, v(start = 0.1));", "Prismatic x(a = world);"])
def test_plates_that_move_are_contacts_on_both_sides(scene: Write, wall: str, side: int) -> None:
    """A force on what is reset alone holds it there: its sense is that of the side on which it lies."""
    law = "x.s = 0.1[m/s]*time;" if "Prismatic" in wall else ""
    for parts in ("b.s > x.s - 0.5 and b.s < x.s + 0.5", "b.s < x.s + 0.5 and b.s > x.s - 0.5"):
        text = thrown(f"when {parts} then reinit(b.v, x.v - e*(b.v - x.v)); end when; {law} {START}", wall, 0, side)
        model = scene(text.replace("    equation", f"energy work {-10*side}[N] on b.s; equation"))
        right = [0.1*t + side*(0.5 + height(t, 0.5)) for t in AT]
        for solver in SOLVERS:
            run = model.simulate(at=AT, solver=solver, tolerance=1e-9)
            np.testing.assert_allclose(run["b.s"], right, rtol=0, atol=2e-8, err_msg=solver)
            assert np.abs(run.energy.residual).max() < 1e-6*abs(run.energy.kinetic).max()


@pytest.mark.parametrize("condition", ["(b.s - x.s)^2 < 0.25", "abs(b.s - x.s) < 0.5"])
@pytest.mark.parametrize("side", [1, -1])
def test_smooth_gaps_to_plates_that_move_hold_on_both_sides(scene: Write, condition: str, side: int) -> None:
    """A square was taken to be met from one side: from the other runs ended at the limit of steps."""
    event = f"when {condition} then reinit(b.v, x.v - e*(b.v - x.v)); end when; {START}"
    text = thrown(event, "Block x(m = 1e9, base = world, v(start = 0.1));", 0, side)
    model = scene(text.replace("    equation", f"energy work {-10*side}[N] on b.s; equation"))
    found = model.simulate(at=AT, tolerance=1e-9)["b.s"]
    np.testing.assert_allclose(found, [0.1*t + side*(0.5 + height(t, 0.5)) for t in AT], rtol=0, atol=2e-8)


@pytest.mark.parametrize("condition", ["abs(b.s - x.s) < 0.5", "b.s - x.s < 0.5 and b.s - x.s > -0.5", "(b.s - x.s)^2 < 0.25"])
@pytest.mark.parametrize("side", [1, -1])
def test_bodies_that_meet_from_both_sides_exchange_momentum(scene: Write, condition: str, side: int) -> None:
    """1 kg and 2 kg, e = 0.5, each as if the other were a wall: -0.5 and -0.5 m/s."""
    event = (f"when {condition} then reinit(b.v, (b.v + 2*x.v)/3 - 1/3*(b.v - x.v)); "
             f"reinit(x.v, (b.v + 2*x.v)/3 + 0.5/3*(b.v - x.v)); end when; initial equation b.v = {-side};")
    run = scene(thrown(event, "Block x(m = 2, base = world, v(start = 0));", 0, side)).simulate(at=[3.0], tolerance=1e-9)
    np.testing.assert_allclose([run["b.s"][0], run["x.s"][0]], [0.5*side, -1.25*side], rtol=0, atol=1e-9)


def carried(gap: str) -> str:
    decl = "energy potential 100*x.s^2; energy dissipation 2*x.v^2; Block x(m = 2, base = world);"
    both = "(b.m*b.v + x.m*x.v)/(b.m + x.m)"
    return thrown(f"""when {gap} < 0 then reinit(b.v, {both} - e*x.m/(b.m + x.m)*(b.v - x.v));
      reinit(x.v, {both} + e*b.m/(b.m + x.m)*(b.v - x.v)); end when;""", decl)


@pytest.mark.parametrize("gap", ["(b.s - x.s - 0.5)^3", "tanh(1000*(b.s - x.s - 0.5))", "sign(b.s - x.s - 0.5)"])
def test_bodies_that_meet_are_held_by_gaps_of_all_kinds(scene: Write, gap: str) -> None:
    """As by the distance itself; functions of it and what jumps let b fall when bounces had ended."""
    plain, model = scene(carried("b.s - x.s - 0.5")), scene(carried(gap))
    assert not model.warnings
    for solver in SOLVERS:
        right, found = (x.simulate(at=[*AT, 5.0], solver=solver, tolerance=1e-9) for x in (plain, model))
        np.testing.assert_allclose([right["b.s"][-1], right["x.s"][-1]], [0.35, -0.15], rtol=0, atol=0.01)
        np.testing.assert_allclose([found["b.s"], found["x.s"]], [right["b.s"], right["x.s"]], rtol=0, atol=1e-8, err_msg=solver)
        assert np.abs(found.energy.residual).max() < 1e-7


def test_contacts_whose_force_rubs_have_one_side_and_the_other_is_told(scene: Write) -> None:
    """Friction drove what was met at the other side: 5 m/s became 7.17."""
    for parts in ("b.s < 0 and b.s > -1", "b.s > -1 and b.s < 0"):
        rubs = "Block x(m = 1, base = world, along = {0, 1}, v(start = 5)); energy work -0.5*contact_force(b.s)*sign(x.v) on x.s;"
        model = scene(thrown(f"when {parts} then {BACK}", rubs))
        assert any("where 'b.s > -1'" in x and "without an event" in x for x in model.warnings)
        found = model.simulate(at=[0.46], tolerance=1e-9)["der(x.s)"]
        np.testing.assert_allclose(found, 5 - 0.5*1.5*np.sqrt(20), rtol=0, atol=1e-8)


BESIDE = "Block x(m = 1, base = world, along = {0, 1}, s(start = 0.5));"
HOLDING = ["(if x.s > 0 and x.s < 1 then b.s else 1) < 0", "sign(b.s) < 0", "floor(b.s) < 0", "(if b.s < 0 then 1 else 0) > 0.5",
           "b.s^3 < 0", "0 > b.s^5", "exp(b.s/1[m]) < 1", "b.s/(1 + abs(b.s)) < 0", "-1e6*b.s > 0", "not (b.s >= 0)",
           "b.s*(b.s + 2) < 0", "(if x.s > 0 then b.s else b.s + 1) < 0", "b.s < -0.1[m]*floor(x.s/1[m])",
           "b.s < 0.1[m]*sign(x.s) - 0.1",
           "1/(b.s + 1) > 1", "sqrt(b.s + 1) < 1", "b.s*abs(b.s) < 0", "2*b.s^3 < 0", "b.s*b.s*b.s < 0", "tanh(1000*b.s) < 0",
           "b.s^3/(1 + b.s^2) < 0", "sqrt(abs(b.s))*sign(b.s) < 0", "0 < abs(b.s)^(1/3)*sign(-b.s)", "b.s*(b.s - 1[m])^2 < 0",
           "tanh(1000*b.s) < x0 - 0.1", "b.s < 0 and b.s < 1", "b.s < 0 and b.v < 0",
           "max(b.s, 2*b.s) < 0", "min(b.s, 2*b.s) < 0", "b.s + 0.5*abs(b.s) < 0", "(if b.s > 0 then b.s else 2*b.s) < 0",
           "b.s*(2 + sign(b.s)) < 0"]


@pytest.mark.parametrize("condition", HOLDING)
def test_what_comes_to_rest_is_held_by_conditions_of_all_kinds(scene: Write, condition: str) -> None:
    """The first four let it fall when bounces had ended, as tanh did, without a word; cubes, roots and squares with a sign ended
    at the limit of steps, or 0.014 m off; those that bend where they change fell, and were told to turn back in some branches."""
    model = scene(thrown(f"when {condition} then {BACK}", BESIDE + ("parameter Real x0 = 0.1;" if "x0" in condition else "")))
    assert not model.warnings
    for solver in SOLVERS:
        found = model.simulate(at=AT, solver=solver, tolerance=1e-9)["b.s"]
        np.testing.assert_allclose(found, [height(t, 1) for t in AT], rtol=0, atol=1e-8, err_msg=solver)


@pytest.mark.parametrize("condition", ["min(b.s, x.s) < 0", "abs(b.s) - b.s > 0", "sqrt(b.s^2) > b.s", "b.s*x.s < 0",
                                       "b.s + x.s < 0.5", "b.s - abs(x.s - 0.5) < 0", "b.s/1[m] < sin(b.s/1[m])",
                                       "(if b.s > 0 then b.s^2 else -b.s^2) < 0", "b.s^3 < (x.s - 0.5[m])^3"])
def test_conditions_that_hold_nothing_are_told(scene: Write, condition: str) -> None:
    warnings = scene(thrown(f"when {condition} then {BACK}", BESIDE)).warnings
    assert any("L0224" in x and ("nothing keeps" in x or "not kept" in x) for x in warnings)


def test_places_without_a_slope_are_told_beside_those_that_hold(scene: Write) -> None:
    """Of s^5 < 0.1 s^3 that at sqrt(0.1) holds (it fell through); of (s - sin(s)) (s + 1) that at -1, not that at 0."""
    for condition, level, side in (("b.s^5 < 0.1*b.s^3", np.sqrt(0.1), 1), ("(b.s/1[m] - sin(b.s/1[m]))*(b.s + 1) < 0", -1, -1)):
        model = scene(thrown(f"when {condition} then {BACK}", g=-10*side, start=level + side))
        assert ["has no slope at a place" in x for x in model.warnings] == [True]
        found = model.simulate(at=AT, tolerance=1e-9)["b.s"]
        np.testing.assert_allclose(found, [level + side*height(t, 1) for t in AT], rtol=0, atol=1e-8)


def test_a_side_of_a_box_that_holds_nothing_is_told(scene: Write) -> None:
    """One `when` is one contact, here of b."""
    box = "when b.s > -0.5 and b.s < 0.5 and x.s > -0.5 and x.s < 0.6 then reinit(b.v, -e*b.v); reinit(x.v, -e*x.v); end when;"
    (warning,) = scene(thrown(box, BESIDE)).warnings
    assert "where 'x.s" in warning


@pytest.mark.parametrize("event", ["when x.s > 1 then reinit(x.v, x.v - 1); end when;",
                                   "when b.s < 0 then reinit(b.v, 3); end when;",
                                   "when b.s < 0 or time > 3 then reinit(b.v, b.v + 1); end when;",
                                   "when abs(b.s) > 2 and x.s > 0 then reinit(x.v, -x.v); end when;",
                                   "when sin(time/1[s]) > 0.5 then reinit(b.v, -b.v); end when;"])
def test_kicks_are_not_told(scene: Write, event: str) -> None:
    assert not any("nothing keeps" in x for x in scene(thrown(event, BESIDE)).warnings)


ARM = "if r > 0.5 then -e*b.v else b.v + 1"


@pytest.mark.parametrize(("declared", "value", "within", "beyond"), [
    ("r = -0.5", "-r*b.v", -0.1, [0, 0.5]), ("r = 0.5", "-r*b.v", 0, [-0.1]), ("r = 0.5", "(1 - r)*b.v", -3, [1, 1.5]),
    ("r = 1.5", "(1 - r)*b.v", 1, [0.9]), ("r = 0", ARM, 0.5, [0.6]), ("r = 1", ARM, 0.6, [0.5]),
    ("r = 1; constant Velocity up = 1", "-e*b.v + r*up", 0.1, [0]), ("r = 0.5; parameter Real k = 2*r", "-k*b.v", 0.1, [-0.1])])
def test_runs_whose_parameters_make_or_end_contacts_are_told(scene: Write, declared: str, value: str, within: float,
                                                             beyond: list[float]) -> None:
    """They went through what holds for these parameters: b.s(3) = 13.75 for 0 with r*b.v, from 0.5 to -0.5."""
    model = scene(thrown(f"when b.s < 0 then reinit(b.v, {value}); end when;", f"parameter Real {declared};"))
    assert all("nothing reads the parameter 'e'" in x for x in model.warnings)
    model.simulate(at=[0.6], parameters={"r": within})
    run = model.prepare(parameters={"r": within}, at=[0.6])
    for r in beyond:
        for call in (lambda: model.simulate(at=[0.6], parameters={"r": r}), lambda: run((), [r])):  # noqa: B023 (called here)
            with pytest.raises(lag.LagError, match=r"L0605.*the event at 'b.s < 0' (becomes|ceases to be) a contact"):
                call()
    failures = model.simulate_many(stop=0.6, parameters={"r": [within, *beyond]}).failures
    assert len(failures) == len(beyond)


@pytest.mark.parametrize(("declared", "value", "within", "beyond"), [
    ("k1 = 2, k2 = 1", "-0.5*(k1 - k2)*b.v", (2.2, 0.8), (1.6, 1.8)),
    ("k1 = 1, k2 = 2", "-0.5*(k1 - k2)*b.v", (0.8, 2.2), (1.6, 1.4)),
    ("k1 = 1, k2 = 2", "if k1 > k2 then -e*b.v else b.v + 1", (0.9, 1.9), (1.6, 1.55)),
    ("k1 = 0.5, k2 = 1", "(k1*k2 - 1)*b.v", (0.6, 1.1), (0.86, 1.2))])
def test_parameters_that_make_or_end_contacts_together_are_told(scene: Write, declared: str, value: str,
                                                               within: tuple[float, float], beyond: tuple[float, float]) -> None:
    """Each had its limits with the other as declared: b.s(3) = -30.1 for 0 without a word with k1 = 1.6, k2 = 1.4, a contact."""
    model = scene(thrown(f"when b.s < 0 then reinit(b.v, {value}); end when;", f"parameter Real {declared};"))
    model.simulate(at=[0.6], parameters=dict(zip(("k1", "k2"), within, strict=True)))
    with pytest.raises(lag.LagError, match="L0605"):
        model.simulate(at=[0.6], parameters=dict(zip(("k1", "k2"), beyond, strict=True)))
    several = {"k1": [within[0], beyond[0]], "k2": [within[1], beyond[1]]}
    assert model.simulate_many(stop=0.6, parameters=several).failures


def accepted(model: lag.Model, **parameters: float) -> bool:
    try:
        model.simulate(at=[0.6], parameters=parameters)
    except lag.LagError as error:
        assert "L0605" in str(error)
        return False
    return True


@pytest.mark.parametrize(("declared", "value", "right"), [
    ("r1 = 0.5, r2 = 0.5", "-r1*r2*b.v", lambda r1, r2: r1*r2 >= 0),
    ("k1 = 3, k2 = 1", "-0.5*(k1 - k2)*b.v", lambda k1, k2: k1 >= k2),
    ("m1 = 1, m2 = 4", "(m1 - e*m2)/(m1 + m2)*b.v", lambda m1, m2: m1 <= 0.5*m2),
    ("m1 = 4, m2 = 1", "(m1 - e*m2)/(m1 + m2)*b.v", lambda m1, m2: m1 > 0.5*m2),
    ("d1 = 0.2, d2 = 0.2", "-sqrt(1 - d1 - d2)*b.v", lambda d1, d2: d1 + d2 <= 1),
    ("k1 = 1, k2 = 2", "if k1 > k2 then -e*b.v else b.v + 1", lambda k1, k2: k1 <= k2),
    ("k1 = 2, k2 = 1", "if k1 > k2 then -e*b.v else (if k2 > 3 then b.v + 1 else 0)", lambda k1, k2: k1 > k2 or k2 <= 3)])
def test_parameters_are_refused_where_they_make_or_end_contacts_and_nowhere_else(
        scene: Write, declared: str, value: str, right: Callable[[float, float], bool]) -> None:
    """Whatever the others are: one number was refused that is right (e = 0.5, k2 = 1.5 of k1 - k2), as a box of all was asked."""
    model = scene(thrown(f"when b.s < 0 then reinit(b.v, {value}); end when;", f"parameter Real {declared};"))
    names, numbers = [x.split(" = ")[0] for x in declared.split(", ")], (0.1, 0.45, 1.3, 2.6, 5, 230)
    found = {(x, y): accepted(model, **dict(zip(names, (x, y), strict=True))) for x in numbers for y in numbers}
    assert found == {pair: right(*pair) for pair in found}


@pytest.mark.parametrize(("declared", "restitution", "right"), [
    (0.5, "e", lambda e: e >= 0), (-0.5, "e", lambda e: e < 0), (0.5, "max(e, 0)", lambda e: True),
    (0, "(if e > 2 then -1 else e)", lambda e: 0 <= e <= 2)])
def test_bodies_that_collide_are_refused_by_their_restitution_alone(
        scene: Write, declared: float, restitution: str, right: Callable[[float], bool]) -> None:
    """Whatever their masses are, of which each impulse tells by its own."""
    back = (f"reinit(b.v, b.v - (1 + {restitution})*(b.v - x.v)*m2/(m1 + m2)); "
            f"reinit(x.v, x.v + (1 + {restitution})*(b.v - x.v)*m1/(m1 + m2));")
    model = scene(f"""model Collide parameter Real e = {declared}; parameter Mass m1 = 1, m2 = 3;
        World world(gravity = {{0, 0}}); Block b(m = m1, base = world, s(start = 1), v(start = -2)), x(m = m2, base = world);
        equation when b.s < x.s then {back} end when; end Collide;""")
    found = {(e, m): accepted(model, e=e, m1=m) for e in (-0.7, -0.1, 0, 0.3, 1, 2.5) for m in (1, 200)}
    assert found == {(e, m): right(e) for e, m in found}


def test_bodies_that_collide_as_declared_alone_are_so_for_parameters_that_say_the_same(scene: Write) -> None:
    """Shares of numbers are an impulse between the two for masses as 1 and 2 alone: as 2 and 2 declared, nothing is held."""
    share = "(1 + e)*(b.v - x.v)"
    model = scene(f"""model Shares parameter Real e = 0.5; World world(gravity = {{-10, 0}});
        Block b(m = 1, base = world, s(start = 1)); Block x(m = 2, base = world); energy potential 25[N/m]*x.s^2; equation
        when b.s - x.s - 0.5 < 0 then reinit(b.v, b.v - {share}*2/3); reinit(x.v, x.v + {share}/3); end when; end Shares;""")
    assert all(accepted(model, **{"b.m": m, "x.m": 2*m}) for m in (1, 2, 30)) and accepted(model, e=0)
    assert not accepted(model, **{"b.m": 2}) and not accepted(model, **{"x.m": 3}) and not accepted(model, e=-0.2)
    with pytest.raises(lag.LagError, match="L0605"):
        model.equilibrium(parameters={"e": -0.2})


def test_walls_as_declared_alone_are_so_for_parameters_that_say_the_same(scene: Write) -> None:
    """What is turned back goes with the wall where u is w: it was held on walls of other speeds (0.9 m for -16.57)."""
    model = scene(thrown("when b.s < w*time then reinit(b.v, w - e*(b.v - u)); end when;", "parameter Real w = 0.1, u = 0.1;"))
    assert accepted(model, w=0.3, u=0.3) and accepted(model, e=0.2)
    assert not accepted(model, w=0.3) and not accepted(model, u=0.3) and not accepted(model, e=-0.2)


def test_times_at_which_parameters_choose_are_asked(scene: Write) -> None:
    model = scene(thrown("when b.s < 0 then reinit(b.v, if time > after then -e*b.v else b.v + 1); end when;",
                         "parameter Time after = -1;"))
    assert accepted(model, after=-7) and not accepted(model, after=0.3)


def test_parameters_that_decide_nothing_are_free(scene: Write) -> None:
    text = thrown("when b.s < x0 then reinit(b.v, if abs(b.v) < slow then 0 else -e*b.v); reinit(x.v, x.v + kick); end when;",
                  "Block x(m = 1, base = world, along = {0, 1}); parameter Real x0 = 0, slow = 0.1, kick = 1;")
    model = scene(text)
    assert all(accepted(model, **{name: x}) for name in ("x0", "slow", "kick") for x in (-30, -0.1, 0, 7))
    assert accepted(model, e=30) and not accepted(model, e=-0.1)


def test_impulses_that_move_nothing_make_no_contact(scene: Write) -> None:
    """The constraint takes them all; it was a contact without a word."""
    law = "b.s + 0.1[m]*sin(b.s/1[m]) = 1[m] - 1[m/s]*time;"
    event = f"{law} when b.s < x.s then reinit(b.v, x.v - e*(b.v - x.v)); end when;"
    (warning,) = scene(thrown(event, "Block x(m = 1, base = world);")).warnings
    assert "moves along what it is turned back from" in warning
