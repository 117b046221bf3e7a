"""Places and states that stand on a level of a condition in a force: nothing moves them to a side of it."""

import re
from collections.abc import Callable

import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "implicit")
SCENE = """model M parameter Real k = 2; World world(gravity = {0, 0});
    Block a(m = 1, base = world, along = {1, 0}, s(start = 1)%s);
    Block c(m = 1, base = world, along = {0, 1}, v(start = 1)); Real x = a.s/1[m]; energy work -0.2*(%s)*1[N] on c.s; %s end M;"""

LAWS: dict[str, tuple[float, float, float]] = {  # below the level, on it, and above
    "if x > 1 then 1 else 0": (0, 0, 1), "if x >= 1 then 1 else 0": (0, 1, 1), "if 1 > x then 1 else 0": (1, 0, 0),
    "if 1 >= x then 1 else 0": (1, 1, 0), "if not k*x > k then 1 else 0": (1, 1, 0), "1 + sign(x - 1)": (0, 1, 2),
    "if x > 1 then 1 elseif x < 1 then 0.5 else 2": (0.5, 2, 1),
    "(if x > 1 then 1 else 0.5)*(1 + 0.5*sign(x - 1))": (0.25, 0.5, 1.5), "floor(x)": (0, 1, 1),
}
WAYS = {  # how a moves from 1 s on, which is below the level, on it, or above
    "": 1, "energy work (if time > 1 then 0.3 else 0)*1[N] on a.s;": 2, "energy work -0.3*max(time - 1, 0)*1[N] on a.s;": 0,
    "energy work ((if time > 1 then 0.9 else 0.3) - 0.6*sign(a.v))*1[N] on a.s;": 2,
    "discrete Real n(start = 0); equation when time > 1 then n = pre(n) + 1; end when;": 1,
    "equation when time > 1 then reinit(a.v, -0.3); end when;": 0,
}


@pytest.mark.parametrize("law", LAWS)
def test_places_on_a_level(law: str, scene: Write) -> None:
    """A force of 1 if x > 1 acted at x = 1, where sign(x - 1) was 1."""
    for way, side in WAYS.items():
        model, forces = scene(SCENE % ("", law, way)), LAWS[law]
        want = 2 - 0.2 * (1.5 * forces[1] + 0.5 * forces[side])
        for solver in SOLVERS:
            assert model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0] == pytest.approx(want, abs=2e-6)


@pytest.mark.parametrize("side", [-1, 1])
def test_a_start_on_the_level_with_a_rate(side: int, scene: Write) -> None:
    """It is on the side to which it moves, from the start on."""
    for law, forces in LAWS.items():
        model = scene(SCENE % (f", v(start = {0.3 * side})", law, ""))
        assert model.simulate(at=[2.0], tolerance=1e-8)["c.s"][0] == pytest.approx(2 - 0.4 * forces[1 + side], abs=1e-7)


@pytest.mark.parametrize(("law", "want"), [
    ("if x > 1 then 1 else 0", 2), ("if x >= 1 then 1 else 0", 1.6), ("1 + sign(x - 1)", 1.6),
    ("if k*(x - 1) > 0 then 1 else 0", 2), ("if k*(1 - x) >= 0 then 1 else 0", 1.6),
    ("(if x > 1 then 1 else 0.5)*(1 + sign(x - 1))", 1.8)])
def test_first_order_states_and_free_rates_on_a_level(law: str, want: float, scene: Write) -> None:
    """sign(y) of a state that stays 0, and of the rate of a body that nothing moves, was 1; k*(y - 1) > 0 was true by half."""
    c = f"Block c(m = 1, base = world, v(start = 1)); energy work -0.2*({law})*1[N] on c.s;"
    for x in ("Real x(start = 1, fixed = true); equation der(x) = (1 - x)*1[1/s];",
              "Real x = 1 + a.v*1[s/m]; Block a(m = 1, base = world);"):
        model = scene(f"model M parameter Real k = 2; World world(gravity = {{0, 0}}); {c} {x} end M;")
        for solver in (*SOLVERS, "taylor"):
            assert model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0] == pytest.approx(want, abs=1e-7)


@pytest.mark.parametrize(("law", "forces"), [
    ("if x >= 0 and x <= 0 then 1 else 0", (0, 1)), ("if x > 0 or x < 0 then 1 else 0", (1, 0)),
    ("if x*x > 0 then 1 else 0", (1, 0)), ("if abs(k*x) <= 0 then 1 else 0", (0, 1)), ("if x == 0 then 1 else 0", (0, 1)),
    ("if k*x <> 0 then 1 else 0", (1, 0))])
def test_places_that_come_to_rest_where_both_sides_are_equal(law: str, forces: tuple[float, float], scene: Write) -> None:
    """x >= 0 and x <= 0 was asked of what rounding left of 0 (2 m for 1.775)."""
    model = scene(f"""model M parameter Real k = 2; World world(gravity = {{0, 0}}); Block c(m = 1, base = world, v(start = 1));
        Block a(m = 1, base = world, v(start = 1)); DryFriction f(F = 2, rate = a.v); Real x = (a.s - 0.25[m])/1[m];
        energy work -0.2*({law})*1[N] on c.s; end M;""")
    for solver in (*SOLVERS, "taylor"):
        found = model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0]
        assert found == pytest.approx(2 - 0.175 * forces[0] - 0.225 * forces[1], abs=2e-6)


@pytest.mark.parametrize(("law", "forces"), [
    ("if x > 0 then 1 else 0", (0, 1)), ("if x >= 0 then 1 else 0", (1, 1)), ("sign(x)", (0, 1)),
    ("if x == 0 then 1 else 0", (1, 0))])
@pytest.mark.parametrize("stiffness", [3, 7])
def test_forces_that_balance_but_for_rounding(law: str, forces: tuple[float, float], stiffness: int, scene: Write) -> None:
    """0.3 - 3*0.1 is -6e-17, which moved what rests (2 m for 1.6)."""
    way = "discrete Real n(start = 0); equation when time > 0.4 then n = pre(n) + 1; end when;"
    for push, side in (("0", 0), ("if time > 1 then 5 else 0", 1)):
        model = scene(f"""model M World world(gravity = {{0, 0}}); Block c(m = 1, base = world, v(start = 1));
            Block a(m = 1, base = world, s(start = 0.1)); Real x = a.s/1[m] - 0.1; energy potential {stiffness}*a.s^2*1[N/m]/2;
            energy work ({push} + {stiffness}/10)*1[N] on a.s; energy work -0.2*({law})*1[N] on c.s; {way} end M;""")
        for solver in (*SOLVERS, "taylor"):
            found = model.simulate(at=[1.2], solver=solver, tolerance=1e-8)["c.s"][0]
            assert found == pytest.approx(1.2 - 0.14 * forces[0] - 0.004 * forces[side], abs=2e-6)


@pytest.mark.parametrize("jump", ["floor(u)", "(if u >= 1 then 1 else 0)"])
@pytest.mark.parametrize(("law", "forces"), [
    ("sign(x - J)", (-1, 0, 1)), ("sign(J - x)", (1, 0, -1)), ("if x >= J then 1 else 0", (0, 1, 1))])
def test_places_on_a_level_that_jumps_with_an_input(jump: str, law: str, forces: tuple[int, int, int], scene: Write) -> None:
    """sign(x - floor(u)) was -1 at x = floor(u), and where a ramp reached the level it changed too late (2.10013 m for 2.1)."""
    for start in (0, 1):
        model = scene(f"""model M input Real u = 0; World world(gravity = {{0, 0}}); Block c(m = 1, base = world, v(start = 1));
            Block a(m = 1, base = world, s(start = {start})); Real x = a.s/1[m];
            energy work -0.2*({law.replace("J", jump)})*1[N] on c.s; end M;""")
        want = 2 - 0.3 * forces[1 + start] - 0.1 * forces[start]
        for given in (([0, 1, 1, 2], [0.5, 0.5, 1.5, 1.5]), ([0, 2], [0.3, 1.7])):
            for solver in SOLVERS:
                run = model.simulate(at=[2.0], solver=solver, tolerance=1e-8, inputs=(given[0], {"u": given[1]}))
                assert run["c.s"][0] == pytest.approx(want, abs=2e-6)


@pytest.mark.parametrize(("law", "forces"), [
    ("floor(x)", (-1, 0)), ("floor(x/10 + 3)", (2, 3)), ("ceil(-x)", (1, 0)), ("floor(x + 3)", (2, 3))])
def test_whole_numbers_of_what_sticks(law: str, forces: tuple[float, float], scene: Write) -> None:
    """floor(x) was that of what rounding has put before 0 (2.4 m for 2.175), and floor(x + 3) of what is loaded 2."""
    comes = 2 - 0.175 * forces[0] - 0.225 * forces[1]
    for start, want in (("s(start = -0.25), v(start = 1)", comes), ("s(start = 0)", 2 - 0.4 * forces[1])):
        model = scene(f"""model M World world(gravity = {{0, 0}}); Block c(m = 1, base = world, v(start = 1));
            Block a(m = 1, base = world, {start}); Real x = a.s/1[m]; energy work -0.2*({law})*1[N] on c.s;
            energy work -2*sign(a.v/1[m/s])*1[N] on a.s; energy work (if time > 0.6 then 0.7 else 0)*1[N] on a.s; end M;""")
        for solver in SOLVERS:
            assert model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0] == pytest.approx(want, abs=2e-6)


@pytest.mark.parametrize(("law", "solver", "force"), [("x > 0", "erk", 0), ("x >= 0", "erk9", 1)])
def test_balanced_forces_move_nothing_by_rounding(law: str, solver: str, force: int, scene: Write) -> None:
    """Between two springs, over steps so long that rounding grows (2.94768 m for 3, 2.10126 for 2.1)."""
    model = scene(f"""model M World world(gravity = {{0, -9.81}}); Block c(m = 1, base = world, along = {{1, 0}}, v(start = 1));
        Block a(m = 1, base = world, along = {{1, 0}}, s(start = 0.7)); Real x = a.s/1[m] - 0.7;
        energy potential (0.5*3*a.s^2 + 0.5*7*(a.s - 1[m])^2)*1[N/m];
        energy work -0.2*(if {law} then 1 else 0)*1[N] on c.s; end M;""")
    run = model.simulate(at=[0.0, 3.0], solver=solver, tolerance=1e-8)
    assert run["c.s"][-1] == pytest.approx(3 - 0.9 * force, abs=1e-9)
    assert run["a.s"][-1] == run["a.s"][0]


@pytest.mark.parametrize(("law", "forces"), [
    ("if y == L then 1 else 0", (0, 1)), ("if y >= L and y <= L then 0 else 1", (1, 0)),
    ("if k*(y - L) > 0 then 1 else 0", (0, 0)), ("if y == L then 2 else 1 + sign(y - L)", (0, 2))])
def test_first_order_states_that_come_to_a_level(law: str, forces: tuple[float, float], scene: Write) -> None:
    """What asked for equality was told by the last digit (2 m for 1.775), and any event or contact made k*(y - L) > 0 a half."""
    text = f"""model M parameter Real k = 2; parameter Real L = 0.3; World world(gravity = {{0, 0}});
        Block c(m = 1, base = world, v(start = 1)); energy work -0.2*({law})*1[N] on c.s; Real y(start = 0, fixed = true);
        %s equation der(y) = 0.6*(if time < 0.5 then 1 else 0)*1[1/s]; %s end M;"""
    lies = "Block a(m = 1, base = world); Stop floor(gap = a.s); DryFriction f(F = 1, rate = a.v); energy work -1[N] on a.s;"
    rubs = "RoughPrismatic g(a = world, mu = 0.2, v(start = 1)); PointMass w(m = 1, center = g.b);"
    for company in (("", ""), ("", "when time > 0.7 then reinit(c.v, pre(c.v)); end when;"), (lies, ""), (rubs, "")):
        model = scene(text % company)
        for solver in (*SOLVERS, "taylor"):
            found = model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0]
            assert found == pytest.approx(2 - 0.175 * forces[0] - 0.225 * forces[1], abs=1e-7)


@pytest.mark.parametrize(("law", "forces"), [
    ("if min(x, 0) == 0 then 1 else 0", (0, 1, 1)), ("if max(x, 0)^2 > 0 then 1 else 0", (0, 0, 1)),
    ("if abs(max(k*x, 0)) <= 0 then 1 else 0", (1, 1, 0)), ("if max(x, 0) + min(x, 0) <> 0 then 1 else 0", (1, 0, 1)),
    ("if abs(x + 0.5) == 0.5 then 1 else 0", (0, 1, 0)), ("if max(x, w) == x then 1 else 0", (0, 1, 1)),
    ("if (if x >= 0 then x else 0) == 0 then 1 else 0", (1, 1, 0)), ("if max(min(x, 0.5), -0.5) == 0 then 1 else 0", (0, 1, 0))])
def test_equalities_with_corners(law: str, forces: tuple[float, float, float], scene: Write) -> None:
    """min(x, 0) == 0 of what sticks at 0, from below and above, was told by the last digit (2 m for 1.775), as is what passes."""
    text = f"""model M parameter Real k = 2; parameter Real w = 0; World world(gravity = {{0, 0}});
        Block c(m = 1, base = world, v(start = 1)), a(m = 1, base = world, v(start = %g)); Real x = %g + a.s/1[m];
        DryFriction f(F = %g, rate = a.v); energy work -0.2*({law})*1[N] on c.s; end M;"""
    for v, x, friction, parts in ((1, -0.25, 2, ((0.175, 0), (0.225, 1))), (-1, 0.25, 2, ((0.175, 2), (0.225, 1))),
                                  (0.3, -0.3, 0, ((0.3, 0), (0.1, 2)))):
        model = scene(text % (v, x, friction))
        want = 2 - sum(part * forces[side] for part, side in parts)
        for solver in SOLVERS:
            assert model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0] == pytest.approx(want, abs=2e-6)


@pytest.mark.parametrize(("law", "below", "above"), [
    ("max(x, 0) == 0", 1, 0), ("min(x, 0) == 0", 0, 1), ("max(x, 0)^2 > 0", 0, 1), ("max(x, 0) == x", 0, 1),
    ("abs(x) == x", 0, 1), ("min(max(x, 0), 0.1) == 0", 1, 0)])
def test_equalities_with_corners_of_what_passes(law: str, below: float, above: float, scene: Write) -> None:
    """Rates and states that go through 0 at 1 s, both ways; max(x, 0)^2 > 0 of a rate that sinks acted all the time."""
    movers = {"a.v/1[m/s]": 0.4, "b.v/1[m/s]": -0.4, "y": 0.4, "z": -0.4}
    pushed = [re.sub(r"\bx\b", x, law) for x in movers]
    model = scene(f"""model M World world(gravity = {{0, 0}}); Block c[4](each m = 1, each base = world, each v(start = 1));
        Block a(m = 1, base = world, v(start = 0.4)), b(m = 1, base = world, v(start = -0.4));
        Real y(start = 0.4), z(start = -0.4);
        energy work -0.4[N] on a.s; work 0.4[N] on b.s;
        {"".join(f"work -0.3[N]*(if {x} then 1 else 0) on c[{k + 1}].s;" for k, x in enumerate(pushed))}
        equation der(y) = -0.4[1/s]; der(z) = 0.4[1/s]; end M;""")
    for solver in SOLVERS:
        found = model.simulate(at=[2.0], solver=solver, tolerance=1e-8)
        for k, (x, start) in enumerate(movers.items()):
            early, late = (above, below) if start > 0 else (below, above)
            assert found[f"c[{k + 1}].s"][0] == pytest.approx(2 - 0.45 * early - 0.15 * late, abs=1e-7), (x, solver)
