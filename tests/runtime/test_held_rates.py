"""Events on rates and places that friction and contacts hold: at their level, and not where rounding takes them."""

from collections.abc import Callable
from math import asin
from pathlib import Path
from typing import Any

import pytest

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.dynamics import held_motion
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "erk9", "adams", "implicit", "pirk", "taylor")
BLOCK = """
  Block b(m = 1, base = world, v(start = %s));  DryFriction f(F = 3, rate = b.v);
  AppliedForce w(at = b.center, force = {%s, 0});
"""
CLUTCH = """
  Revolute p(a = world), q(a = world, w(start = 3));
  Disc d(m = 1, r = 1, I = 1, center = p.b), e(m = 1, r = 1, I = 2, center = q.b);
  DryFriction f(F = 5, rate = 1[m]*(q.w - p.w));  AppliedTorque T(on = d.center, torque = 2*sin(3*time));
"""
TABLE = """
  PointMass P(m = 1);  RoughStop floor(a = world, b = P.center, mu = 0.5);
  AppliedForce w(at = P.center, force = {2*sin(5*time), 3*cos(7*time)});
initial equation
  P.center.x = 0;  P.center.y = 0;  P.center.v[1] = 0;  P.center.v[2] = 0;
"""
STUCK, TEARS_OFF = "2.9*sin(9*time)", "5*sin(1*time)"


@pytest.mark.parametrize(("text", "condition", "right"), [
    (BLOCK % (0, STUCK), "b.v > 0", 0), (BLOCK % (0, STUCK), "b.v >= 0", 0), (BLOCK % (0, STUCK), "abs(b.v) > 0", 0),
    (BLOCK % (1, STUCK), "b.v < 0", 0), (BLOCK % (-1, STUCK), "b.v >= 0", 1), (BLOCK % (-1, STUCK), "b.v > 0", 0),
    (BLOCK % (0, TEARS_OFF), "b.v > 0", 1), (BLOCK % (0, TEARS_OFF), "b.v < 0", 0), (BLOCK % (0, TEARS_OFF), "abs(b.v) > 0", 1),
    (CLUTCH, "q.w < p.w", 0), (CLUTCH, "p.w >= q.w", 1), (CLUTCH, "q.w > p.w", 0),
    (TABLE, "P.center.v[2] > 0", 0), (TABLE, "P.center.v[1] < 0", 0),
    (BLOCK % (0, STUCK), "b.s > 0", 0), (BLOCK % (0, STUCK), "b.s < 0", 0), (BLOCK % (0, STUCK), "b.s >= 0", 0),
    (BLOCK % (0, TEARS_OFF), "b.s > 0", 1), (BLOCK % (0, TEARS_OFF), "b.s < 0", 0)])
def test_what_is_held_is_at_its_level(scene: Write, text: str, condition: str, right: int) -> None:
    """Of a block that sticks for ever `b.v > 0` came up to 1 960 times, or the run could not be continued."""
    begin, mark, end = text.partition("initial equation")
    model = scene(f"""model Held {begin} discrete Real n(start = 0);{mark}{end}
    equation when {condition} then n = pre(n) + 1; end when; end Held;""")
    for solver in SOLVERS:
        assert model.simulate(at=[0.0, 0.5, 1.0, 1.5, 2.0], solver=solver)["n"][-1] == right, solver


def test_what_is_held_ends_no_run(scene: Write) -> None:
    model = scene(f"model Held {BLOCK % (0, STUCK)} equation when b.v > 0 then terminate(\"moves\"); end when; end Held;")
    for solver in SOLVERS:
        assert model.simulate(at=[0.0, 1.0, 2.0], solver=solver)["time"][-1] == 2, solver


def test_what_else_decides_comes_at_its_time(scene: Write) -> None:
    """While the rate stays at its level."""
    for other, at in (("c.s > 1[m]", 1.0), ("time > 1.1", 1.1)):
        model = scene(f"""model Other {BLOCK % (0, "0")}  Block c(m = 1, base = world, v(start = 1));
          discrete Time came(start = 0);
        equation when b.v > 0 or {other} then came = time; end when; end Other;""")
        for solver in SOLVERS:
            assert model.simulate(at=[0.0, 2.0], solver=solver)["came"][-1] == pytest.approx(at, abs=1e-9), (other, solver)


def test_what_does_not_count_yet_may_later(scene: Write) -> None:
    """c.v = 10 t and c.s = 5 t^2 decide where b sticks."""
    for condition, at in (("b.v > 0 or c.v > 3", 0.3), ("max(b.v, c.v - 3[m/s]) > 0", 0.3), ("max(b.s, c.s - 0.8[m]) > 0", 0.4)):
        stuck = BLOCK % (0, "0")
        model = scene(f"""model Later {stuck}  Block c(m = 1, base = world);  AppliedForce h(at = c.center, force = {{10, 0}});
          discrete Time came(start = 0);
        equation when {condition} then came = time; end when; end Later;""")
        for solver in SOLVERS:
            assert model.simulate(at=[0.0, 2.0], solver=solver)["came"][-1] == pytest.approx(at, abs=1e-7), (condition, solver)


AT_3, BESIDE = 0.3, """  Block c(m = 1, base = world);  AppliedForce h(at = c.center, force = {10, 0});
  discrete Time came(start = 0);  discrete Real n(start = 0);
"""


@pytest.mark.parametrize(("text", "condition", "at"), [
    (BLOCK % (0, STUCK), "b.v > 0 or c.v > 3", AT_3), (BLOCK % (0, STUCK), "b.v >= 0 and c.v > 3", AT_3),
    (BLOCK % (0, STUCK), "b.v > 0 or b.s > 0 or c.v > 3", AT_3), (BLOCK % (0, STUCK), "max(b.v, c.v - 3[m/s]) > 0", AT_3),
    (BLOCK % (0, STUCK), "b.s + 0.1[s]*b.v > 0", None), (BLOCK % (0, STUCK), "b.s > 0 and c.v > 3", None),
    (BLOCK % (0, STUCK), "b.s < (if time > 1 then 0.1 else 0)", 1.0), (BLOCK % (0, STUCK), "b.v > 0 or time > 1.1", 1.1),
    (BLOCK % (-1, STUCK), "b.v >= 0 and time > 1.1", 1.1), (BLOCK % (0, TEARS_OFF), "b.v > 0 or time > 1.1", asin(0.6)),
    (CLUTCH, "q.w < p.w or time > 1.1", 1.1)])
def test_each_comparison_is_decided_by_itself(scene: Write, text: str, condition: str, at: float | None) -> None:
    """c.v = 10 t decides beside what is held, whose level rounding passed up to 12 times: at t = 0 or by 0.04 too early."""
    model = scene(f"""model Several {text} {BESIDE}
    equation when {condition} then came = time; n = pre(n) + 1; end when; end Several;""")
    for solver in SOLVERS:
        run = model.simulate(at=[0.0, 2.0], solver=solver)
        assert (run["n"][-1], run["came"][-1]) == (at is not None, pytest.approx(at or 0, abs=1e-7)), solver


def test_what_is_carried_moves(scene: Write) -> None:
    """By a table with a period of 1 s, which is at rest at the start and whole seconds later."""
    model = scene("""model Carried
      discrete Real n(start = 0);  Block b(m = 1, base = world);  Prismatic t(a = world);
      Motion to_and_fro(of = t.s, to = 0.001*(1 - cos(2*pi*time)));  DryFriction f(F = 300, rate = b.v - t.v);
    equation when b.v > 0 then n = pre(n) + 1; end when; end Carried;""")
    for solver in ("erk5", "erk9", "implicit"):
        assert model.simulate(at=[0.0, 0.3, 1.2, 2.2], solver=solver)["n"][1:].tolist() == [1, 2, 3], solver


FREE = """
  Block h(m = 1, base = world);  DryFriction f(F = 3, rate = h.v);
  Block a(m = 1, base = world), b(m = 1, base = world), c(m = 1, base = world), d(m = 1, base = world);
  AppliedForce wa(at = a.center, force = {1, 0}), wb(at = b.center, force = {2*time, 0}), wc(at = c.center, force = {1, 0}),
    wd(at = d.center, force = {2*time, 0});
"""


@pytest.mark.parametrize("condition", ["b.v^2 > a.v^2", "abs(b.v) > abs(a.v)", "b.v + d.v > a.v + c.v", "b.v*d.v > a.v*c.v"])
def test_what_moves_freely_is_not_taken_for_held(scene: Write, condition: str) -> None:
    """Rates equal at rest, beside a body that sticks: these events never came while rates of 1 and -1 were tried alone."""
    model = scene(f"""model Free {FREE} discrete Real n(start = 0);
    equation when {condition} then n = pre(n) + 1; end when; end Free;""")
    for solver in ("auto", "erk5", "implicit"):
        assert list(model.simulate(at=[0.9, 1.1, 2.0], solver=solver)["n"]) == [0, 1, 1], solver


HOLDS = "DryFriction f(F = 2, rate = b.v);"
SLOPE = HOLDS + "  AppliedForce p(at = b.center, force = {-1.2, 0});"
STATIC = "DryFriction f(F = 2, F_static = 3, rate = b.v);  AppliedForce p(at = b.center, force = {2.5*step(time - 0.6), 0});"
BELT = "DryFriction f(F = 0.5, rate = b.v - 0.1*time);"
RATCHET = "AppliedForce p(at = b.center, force = {-2, 0});"


@pytest.mark.parametrize(("holds", "law", "right"), [
    (HOLDS, "if b.v > 0 then 1 else 0", 0.5), (HOLDS, "if b.v >= 0 then 1 else 0", 2), (HOLDS, "if -3*b.v > 0 then 1 else 0", 0),
    (HOLDS, "if b.v > 0 and time > 0.25 then 1 else 0", 0.25), (HOLDS, "if b.v == 0 then 1 else 0", 1.5),
    (SLOPE, "sign(b.v)", 1 / 3.2), (SLOPE, "if b.v >= 0 then 1 else 0", 2), (STATIC, "if b.v > 0 then 1 else 0", 0.5),
    (SLOPE, "sign(b.v)^2", 1 / 3.2), (HOLDS, "3 - sign(b.v)*sign(b.v)", 5.5),
    (HOLDS, "if b.v > 0 then 1 elseif b.v < 0 then 0.3 else 0.1", 0.65), (STATIC, "sign(b.v)", 0.5),
    (BELT, "if b.v - 0.1*time > 0 then 1 else 0", 1 / 0.6),
    (RATCHET, "if b.v > 0 then 1 else 0", 0.5), *((HOLDS, f"if {law} then 1 else 0", right) for law, right in {
        "max(b.v, 0) > 0": 0.5, "min(b.v, 0) < 0": 0, "max(b.v, -b.v) > 0": 0.5, "abs(b.v) + b.v > 0": 0.5,
        "abs(b.v)^1.5 > 0": 0.5, "max(b.v, 0) >= 0": 2, "max(b.v, 0) > 0.5": 0.25, "exp(b.v/1[m/s]) > 1": 0.5, "b.v^3 > 0": 0.5,
        "b.v*abs(b.v) > 0": 0.5, "sign(max(b.v, 0)) > 0": 0.5, "max(abs(b.v) - 0.2, 0) > 0": 0.4,
        "max(b.v - 0.2, 0) > 0": 0.4, "max(abs(b.v), 0.2) > 0.2": 0.4}.items()),
    (BELT, "if max(b.v - 0.1*time, 0) > 0 then 1 else 0", 1 / 0.6)])
def test_others_know_what_is_held_on_its_level(scene: Write, holds: str, law: str, right: float) -> None:
    """For how long the block moves: the share of friction was counted while it sticks (1.25 s for 0.5)."""
    stop = "when b.v < 0 then reinit(b.v, 0); end when;" if holds == RATCHET else ""
    model = scene(f"""model Timer  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {holds}
      Time y(start = 0);  equation der(y) = {law};  {stop} end Timer;""")
    for solver in ("auto", "erk", "erk5", "erk9", "adams", "implicit", "taylor"):
        assert model.simulate(at=[0.0, 2.0], solver=solver)["y"][-1] == pytest.approx(right, abs=1e-7), solver


LOOSE = "DryFriction f(F = 0, rate = b.v);"
RAMP = "AppliedForce p(at = b.center, force = {max(time - 1, 0)*1[N/s], 0});"


@pytest.mark.parametrize(("holds", "law", "right"), [
    (LOOSE, "b.v == 0", 2), (LOOSE, "b.v <> 0", 0), (LOOSE, "b.v^2 <= 0", 2), (LOOSE + RAMP, "b.v == 0", 1),
    (LOOSE + RAMP, "abs(b.v) > 0", 1), ("DryFriction f(F = 2*abs(sin(3*time)), rate = b.v);", "b.v == 0", 2),
    ("Friction f(mu = 0.3, normal = 2[N]*max(sin(4*time), 0), rate = b.v);", "b.v == 0", 2),
    ("DryFriction f(F = if time > 0.7 then 1 else 0, rate = b.v);", "b.v == 0", 2),
    ("DryFriction f(F = if time < 0.7 then 3 else 0, rate = b.v);  AppliedForce p(at = b.center, force = {2, 0});",
     "b.v == 0", 0.7),
    (LOOSE + "Spring k(k = 9, stretch = b.s);", "b.v == 0", 2), (LOOSE + "Spring k(k = 9, stretch = b.s - 1);", "b.v == 0", 0),
    (LOOSE + "KICK", "b.v == 0", 1)])
def test_what_no_friction_holds_may_be_at_rest(scene: Write, holds: str, law: str, right: float) -> None:
    """Friction of no force holds nothing: rates that are 0 and stay so were never found to be 0."""
    kick = "when time > 1 then reinit(b.v, 1); end when;" if "KICK" in holds else ""
    model = scene(f"""model Still  World world(gravity = {{0, 0}});  Block b(m = 1, base = world);  {holds.replace("KICK", "")}
      Time y(start = 0);  equation der(y) = if {law} then 1 else 0;  {kick} end Still;""")
    for solver in ("auto", "erk5", "erk9", "implicit", "taylor"):
        assert model.simulate(at=[0.0, 2.0], solver=solver)["y"][-1] == pytest.approx(right, abs=1e-7), solver


LOADED = "Force F = -3*sign(b.v);  AppliedForce g(at = b.center, force = {F, 0}), p(at = b.center, force = {-1, 0});"
FIRM = "DryFriction f(F = 2, F_static = 3, rate = b.v);  AppliedForce p(at = b.center, force = {-1.2, 0});"
BORNE = """import Rotational.*;  Inertia i(J = 1, w(start = 1));  BearingFriction r(tau_pos = [0, 2; 1, 3], peak = 1.2);
  ConstantTorque w(tau_constant = -1.2);  equation  connect(i.flange_b, r.flange_a);  connect(r.flange_b, w.flange);"""


@pytest.mark.parametrize(("holds", "y", "right"), [
    (SLOPE, "if b.v > 0 then 1 else 0", 0), (SLOPE, "if b.v >= 0 then 1 else 0", 1), (SLOPE, "if b.v == 0 then 1 else 0", 1),
    (SLOPE, "if max(b.v, 0) > 0 then 1 else 0", 0), (SLOPE, "if abs(b.v)^1.5 <= 0 then 1 else 0", 1),
    (SLOPE, "5*sign(b.v)", 0), (SLOPE, "if -3*b.v < 0 then 5 else 0", 0), (SLOPE, "if b.v > 0 then b.s else 7[m]", 7),
    (FIRM, "abs(sign(b.v))", 0), (SLOPE, "sign(b.v)^2", 0), (BELT, "if b.v - 0.1*time > 0 then 1 else 0", 0),
    (BELT, "sign(b.v - 0.1*time) + 3", 3),
    (RATCHET, "if b.v > 0 then 1 else 0", 0), (LOADED, "if b.v < 0 then 3 else 0", 0),
    (SLOPE, "f.F*sign(f.rate)", -1.2), (SLOPE, "2*b.s - f.F*sign(f.rate)*1[m/N]", 2 / 6.4 + 1.2), (LOADED, "F", 1),
    (LOADED, "-F", -1), (FIRM, "(if b.v <> 0 then f.F else f.F_static)*sign(b.v)", -1.2), (BORNE, "r.tau", -1.2),
    (BORNE, "sign(i.w)", 0)])
def test_outputs_know_what_is_held_on_its_level(scene: Write, holds: str, y: str, right: float) -> None:
    """But what the friction's own force is: `if b.v > 0 then 1 else 0` was 0.2 while it holds."""
    parts, _, rest = holds.partition("equation")
    stop = "when b.v < 0 then reinit(b.v, 0); end when;" if holds == RATCHET else ""
    model = scene(f"""model Told  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {parts}
      output Real y = {y};  equation {rest} {stop} end Told;""")
    for solver in ("auto", "erk9", "implicit"):
        assert model.simulate(at=[0.0, 2.0], solver=solver)["y"][-1] == pytest.approx(right, abs=1e-9), solver


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_outputs_of_fmus_know_it_too(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "told.lag"
    path.write_text(f"""model Told  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {SLOPE}
      output Real on = if b.v > 0 then 1 else 0, held = f.F*sign(f.rate)/1[N];  end Told;""", encoding="utf-8")
    found = simulated(path, "2", kind, ["on", "held"], stop_time=2.0, output_interval=0.1, relative_tolerance=1e-9)
    assert list(found["on"][[1, -1]]) == [1, 0]
    assert found["held"][[1, -1]] == pytest.approx([2, -1.2], abs=1e-9)


def test_reactions_of_trees_know_it(scene: Write) -> None:
    """A force on the bar that asks for the rate of a block which sticks: as one that is given."""
    text = """model Tree  World world(gravity = {0, -9.81});  Block b(m = 1, base = world, v(start = 1));  %s
      Revolute O(a = world, phi(start = 0.3));  Bar bar(m = 1, L = 1, a = O.b);
      output Force x = O.reaction[1], y = O.reaction[2];
      AppliedForce p(at = bar.b, force = {if %s then -3 else 0, 1}); end Tree;"""
    asked, given = (scene(text % (HOLDS, law)).simulate(at=[0.0, 1.0, 2.0], tolerance=1e-10)
                    for law in ("b.v > 0", "time < 0.5"))
    for name in ("O.phi", "x", "y"):
        assert asked[name] == pytest.approx(given[name], rel=1e-7), name


OWN = "Force F = -2*sign(b.v);  AppliedForce g(at = b.center, force = {F, 0}), p(at = b.center, force = {1, 0});"
CHOSEN = OWN.replace("-2*sign(b.v)", "if b.v > 0 then -2 else 2")


@pytest.mark.parametrize(("holds", "force", "right"), [
    *((OWN, law, right) for law, right in {
        "if b.v > 0 then 2 else -2": 0, "if b.v >= 0 then 2 else -2": 4, "if b.v < 0 then 2 else -2": -4,
        "4*(if b.v > 0 then 1 else 0) - 2": 0, "if b.v > 0 then 2 elseif b.v < 0 then -2 else 0": 2,
        "if sign(b.v) > 0 then 2 else -2": 0, "F": -3, "-F": 3, "2*F": -6, "2*sign(b.v)": 3, "3*sign(b.v)": 3,
        "-F + (if b.v > 0 then 2 else -2)": 3, "if time > 0.5 then -F else 0": 2}.items()),
    (CHOSEN, "if b.v > 0 then 5 else 2", 7), (CHOSEN, "if b.v > 0 then -2 else 7", 5), (CHOSEN, "F", -3), (CHOSEN, "-F", 3),
    (CHOSEN, "if b.v > 0 then 2 else -2", 0),
    ("DryFriction f(F = 2, rate = b.v);  AppliedForce p(at = b.center, force = {1, 0});", "if b.v > 0 then f.F else -f.F", 0)])
def test_conditions_are_no_forces_that_hold(scene: Write, holds: str, force: str, right: float) -> None:
    """Of a block that comes to rest at 1 s, where 1 N holds it, another is pushed by what is as large (3 m/s for 0)."""
    model = scene(f"""model Alike  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {holds}
      Block c(m = 1, base = world);  AppliedForce h(at = c.center, force = {{{force}, 0}});  end Alike;""")
    for solver in ("auto", "erk9", "implicit"):
        assert model.simulate(at=[0.0, 2.0], solver=solver)["c.v"][-1] == pytest.approx(right, abs=1e-8), solver


@pytest.mark.parametrize(("law", "right"), [
    ("max(b.v, u) > u", 0), ("min(b.v, u) < u", 0), ("max(b.v, u) <= u", 3), ("2*max(b.v, u) - 2*u > 0", 0), ("b.v^3 > u^3", 0),
    ("max(b.v, u) > 0.5*u", 3)])
def test_levels_that_move_are_told_where_both_sides_are_equal(scene: Write, law: str, right: float) -> None:
    """A block that goes along with a belt from the start: implicit steps found max(b.v, u) > u for ever."""
    model = scene(f"""model Carried  World world(gravity = {{0, 0}});  Block b(m = 1, base = world);
      Velocity u = 0.1[m/s^2]*time;  DryFriction f(F = 0.5, rate = b.v - u);  Time y(start = 0);
      equation der(y) = if {law} then 1 else 0;  end Carried;""")
    for solver in ("auto", "erk9", "implicit"):
        assert model.simulate(at=[0.0, 3.0], solver=solver)["y"][-1] == pytest.approx(right, abs=1e-7), solver


def test_blocks_in_a_row_are_told_together(scene: Write, monkeypatch: pytest.MonkeyPatch) -> None:
    """Each asks the next one's rate: what holds them is put in as often of four as of sixteen."""
    made = list[int]()

    class Counted(held_motion.Holding):
        def __init__(self, *arguments: Any, **others: Any) -> None:
            made.append(1)
            super().__init__(*arguments, **others)

    monkeypatch.setattr(held_motion, "Holding", Counted)
    counts = []
    for n in (4, 16):
        made.clear()
        blocks = [f"Block b{k}(m = 1, base = world, v(start = 1));  DryFriction f{k}(F = 2, rate = b{k}.v);" for k in range(n)]
        asked = [f"AppliedForce p{k}(at = b{k}.center, force = {{if b{k + 1}.v > 0 then 1 else -1, 0}});" for k in range(n - 1)]
        text = ["model Row  World world(gravity = {0, 0});", *blocks, *asked, "end Row;"]
        scene("\n".join(text)).simulate(at=[0.0, 0.1], solver="erk5")
        counts.append(len(made))
    assert counts[0] == counts[1] > 0


def test_what_pushes_back_feels_the_force_that_holds(scene: Write) -> None:
    """A block rubs on another by a law of its own rate: the force is on both, and its impulse too, while it holds as well."""
    model = scene(f"""model Third  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {LOADED}
      Block c(m = 1, base = world);  AppliedForce back(at = c.center, force = {{-F, 0}});
      Real y(start = 0, fixed = true);  equation der(y) = F/1[N.s];  end Third;""")
    for solver in ("auto", "erk", "erk5", "erk9", "implicit", "taylor"):
        run = model.simulate(at=[0.0, 2.0], solver=solver)
        assert run["der(c.s)"][-1] == pytest.approx(-1, abs=1e-8), solver  # 3*0.25 - 1.75
        assert run["y"][-1] == pytest.approx(1, abs=1e-8), solver
        assert abs(run.energy.residual[-1]) < 1e-9, solver


@pytest.mark.parametrize(("law", "sliding", "stuck"), [
    ("work -0.2[N]*(if b.v > 0 then 1 else 0) on c.s;", -0.2, 0),
    ("work -0.2[N]*(if b.v >= 0 then 1 else 0) on c.s;", -0.2, -0.2),
    ("work (if b.v > 0 then -0.2 elseif b.v < 0 then 0.3 else 0.1) on c.s;", -0.2, 0.1)])
def test_forces_on_others_and_their_work_know_it_too(scene: Write, law: str, sliding: float, stuck: float) -> None:
    model = scene(f"""model Pushed  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {HOLDS}
      Block c(m = 1, base = world, v(start = 1));  energy {law} end Pushed;""")
    v, x = 1 + 0.5 * sliding, 0.5 + sliding / 8
    for solver in ("auto", "erk9", "implicit", "taylor"):
        run = model.simulate(at=[0.0, 2.0], solver=solver)
        assert run["c.s"][-1] == pytest.approx(x + 1.5 * v + 1.125 * stuck, abs=1e-7), solver
        assert abs(run.energy.residual[-1]) < 1e-9, solver
    table = model.simulate_many(parameters={"b.m": [1.0] * 9}, outputs=["c.s"], stop=2)
    assert [*table["c.s"]] == pytest.approx([x + 1.5 * v + 1.125 * stuck] * 9, abs=1e-7)


@pytest.mark.parametrize(("law", "right"), [
    ("b.v == 0 and c.v == 0", 1), ("b.v <> 0 or c.v <> 0", 1), ("b.v == 0 or c.v == 0", 1.5)])
def test_two_that_stick_are_asked_about_together(scene: Write, law: str, right: float) -> None:
    """Each by a friction of its own: they are no components of one slip, and were never found at rest together."""
    model = scene(f"""model Both  World world(gravity = {{0, 0}});  Block b(m = 1, base = world, v(start = 1));  {HOLDS}
      Block c(m = 1, base = world, v(start = 1));  DryFriction g(F = 1, rate = c.v);
      Time y(start = 0);  equation der(y) = if {law} then 1 else 0; end Both;""")
    for solver in ("auto", "erk9", "implicit"):
        assert model.simulate(at=[0.0, 2.0], solver=solver)["y"][-1] == pytest.approx(right, abs=1e-7), solver


def test_forces_of_loops_know_what_is_held_elsewhere(scene: Write) -> None:
    """A torque on the crank that asks for the rate of a block which sticks is as one for ever, and so are the reactions."""
    text = """model Loop  World world(gravity = {0, -9.81});
      Block b(m = 1, base = world, v(start = 1));  DryFriction f(F = 2, rate = b.v);
      Revolute O(a = world, phi(start = 40[deg], fixed = true)), A(a = crank.b), B(a = coupler.b, b = rocker.b),
               C(a = shift(world, {1, 0}), phi(start = 75[deg]));
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
      output Force x = B.reaction[1], y = C.reaction[2];  energy work -3[N.m]*(if %s then 1 else 0) on O.phi; end Loop;"""
    asked, always = (scene(text % law).simulate(at=[0.0, 1.0, 2.0], tolerance=1e-9) for law in ("b.v >= 0", "time >= 0"))
    for name in ("O.phi", "x", "y"):
        assert asked[name] == pytest.approx(always[name], rel=1e-6), name


@pytest.mark.parametrize("law", ["F = 2", "F = G", "F = 2*G/2"])
@pytest.mark.parametrize("back", ["2[N]*sign(b.v)", "G*sign(b.v)"])
def test_what_pushes_back_may_be_written_anew(scene: Write, law: str, back: str) -> None:
    """Beside a component's friction of 2 N: 1.5 t is held up to t = 4/3 s and goes on to c, and 2 N after it. It was 0 there."""
    model = scene(f"""model Held
      World world(gravity = {{0, 0}}); Block b(m = 1, base = world), c(m = 3, base = world); parameter Force G = 2;
      DryFriction f(rate = b.v, {law}); AppliedForce g(at = c.center, force = {{{back}, 0}});
      AppliedForce h(at = b.center, force = {{1.5[N/s]*time, 0}});
    end Held;""")
    for solver in ("auto", "erk9", "implicit", "taylor"):
        run = model.simulate(at=[1.0, 3.0], solver=solver, tolerance=1e-10)
        assert run["der(c.s)"] == pytest.approx([0.25, 4 / 9 + 10 / 9], abs=1e-8), solver
        assert run["c.s"][0] == pytest.approx(1 / 12, abs=1e-8), solver
