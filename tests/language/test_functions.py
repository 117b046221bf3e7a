"""User functions: assignments, branches and loops mean what they say, in values and in the units of their results."""

from collections.abc import Callable

import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError

Write = Callable[[str], lag.Model]

ALGORITHMS = {  # statements; what y becomes of x = 2
    "straight": ("y := x; y := y*y + 1;", 5.0),
    "condition overwritten": ("z := x; y := 0; if z > 0 then z := -1; y := 5; else y := 7; end if;", 5.0),
    "condition overwritten, otherwise": ("z := -x; y := 0; if z > 0 then y := 5; else z := 1; y := 7; end if;", 7.0),
    "read before both assign": ("z := x; y := 1; if x < 0 then z := 9; y := 9; else y := z; z := 10; end if; y := y + z;", 12.0),
    "swapped": ("z := 3; y := x; if x > 0 then w := y; y := z; z := w; end if; y := 10*y + z;", 32.0),
    "twice in a branch": ("y := 1; if x > 1 then y := y + 1; y := 10*y; else y := 0; y := y - 1; end if;", 20.0),
    "nested": ("y := 0; if x > 1 then if x > 3 then y := 1; else y := 2; w := y; y := y + w; end if; else y := 3; end if;", 4.0),
    "elseif": ("if x < 1 then y := 1; elseif x < 3 then y := 2; else y := 3; end if;", 2.0),
    "loop": ("y := 0; for i in 1:4 loop if i > x then y := y + i; else z := i; y := y - z; end if; end for;", 4.0),
    "one branch alone, then again": ("if x > 1 then z := 1; end if; z := 4; y := z;", 4.0),
}


@pytest.mark.parametrize("name", ALGORITHMS)
def test_algorithms(name: str, scene: Write) -> None:
    statements, there = ALGORITHMS[name]
    model = scene(f"""function f
      input Real x; output Real y;
      protected Real z; Real w;
    algorithm
      {statements}
    end f;
    model M
      Block b(m = 1, base = world, s(start = 1));
      output Real rests = f(2), moves = f(2*b.s/1[m]);
    end M;""")
    run = model.simulate(at=[0.0])
    assert run["rests"][0] == run["moves"][0] == there


def test_what_one_branch_alone_gives_has_no_value_behind_it(scene: Write) -> None:
    with pytest.raises(lag.LagError, match="'z' is used before it is given a value"):
        scene("""function f input Real x; output Real y; protected Real z; algorithm if x > 0 then z := 1; end if; y := z; end f;
        model M Block b(m = 1, base = world); output Real o = f(b.s/1[m]); end M;""")


def test_the_unit_of_a_result_that_branches_give(scene: Write) -> None:
    model = scene("""function f input Length x; output Force y;
    algorithm if x > 0[m] then y := 3[N]; else y := 2[N/m]*x; end if; end f;
    model M Block b(m = 1, base = world, s(start = 1)); AppliedForce a(at = b.center, force = {f(b.s), 0[N]}); end M;""")
    assert model.simulate(stop=1, interval=1)["b.s"][-1] == pytest.approx(2.5, abs=1e-12)


LOGIC = """function inside "whether x lies within"
  input Real x; input Real low; input Real high; output Boolean y;
algorithm
  y := x > low and x < high;
end inside;
function pick
  input Boolean on; input Real a; input Real b; output Real y;
  protected Boolean c, d = false, e[2];
algorithm
  c := not on;
  e := {c, d};
  if a > 5 then d := e[1] or d; else d := false; end if;
  y := if d then a else b;
  c := true;
  if not c then y := 0; end if;
end pick;
function odd input Integer n; output Boolean y; algorithm y := mod(n, 2) == 1; end odd;
model M
  parameter Boolean is_odd = odd(3);
  Prismatic s(a = world, s(start = 1));
  PointMass m(m = if is_odd then 1 else 2, center = s.b);
  Spring k(k = 3, a = world, b = m.center) if odd(5);
  AppliedForce f(at = m.center, force = {if inside(s.s, -0.5, 0.5) then -2 else pick(s.s > 0.7, 6, -1), 0});
equation
  assert(not inside(s.s, 100, 200), "too far");
  when inside(s.s, -0.2, 0.2) then reinit(s.v, 1.2*pre(s.v)); end when;
end M;
"""


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_truths_that_move_are_given_to_functions_and_by_them(scene: Callable[[str], lag.Model], solver: str) -> None:
    """As the same conditions written out: all events are found, also those of a `when`."""
    plain = LOGIC.replace("if inside(s.s, -0.5, 0.5) then", "if s.s > -0.5 and s.s < 0.5 then").replace(
        "pick(s.s > 0.7, 6, -1)", "(if not s.s > 0.7 then 6 else -1)").replace(
        "when inside(s.s, -0.2, 0.2)", "when s.s > -0.2 and s.s < 0.2")
    runs = [scene(text).simulate(at=[2.0, 6.0], solver=solver, tolerance=1e-10) for text in (LOGIC, plain)]
    assert runs[0]["s.s"] == pytest.approx(runs[1]["s.s"], abs=1e-8)
    assert runs[0]["s.v"] == pytest.approx(runs[1]["s.v"], abs=1e-8)


def test_what_is_no_truth_is_no_boolean(scene: Callable[[str], lag.Model]) -> None:
    for wrong, code in (("y := x;", "L0302"), ("y := x > 0; y := y + 1;", "L0302")):
        with pytest.raises(LagError, match=code):
            assert scene(LOGIC.replace("y := x > low and x < high;", wrong)).scene
    with pytest.raises(LagError, match="L0302"):
        assert scene(LOGIC.replace("pick(s.s > 0.7, 6, -1)", "pick(s.s, 6, -1)")).scene


SWINGS = """model Swings
  Prismatic s(a = world, s(start = 1)), c(a = world); PointMass m(m = 1, center = s.b), n(m = 1, center = c.b);
  Spring k(k = 4, stretch = s.s);
equation
  when CONDITION then reinit(c.v, pre(c.v) + 1); end when;
end Swings;
"""


@pytest.mark.parametrize("condition", ["(if s.s > 0.5 then 1 else 0) > 0.5", "(if s.s > 0.5 then 0 else 1) < 0.5",
                                       "floor(3*s.s) >= 1", "ceil(3*s.s) >= 1"])
def test_events_of_choices_between_0_and_another_number(scene: Callable[[str], lag.Model], condition: str) -> None:
    """cos 2t rises through 0.5 three times in 10 s."""
    for solver in ("taylor", "erk", "implicit"):
        assert scene(SWINGS.replace("CONDITION", condition)).simulate(at=[0, 10.0], solver=solver)["c.v"][-1] == 3


INTEGERS = """
function count "whole numbers of a whole number, and a Real of them"
  input Integer n;
  input Integer v[3];
  output Real y;
protected
  Integer k = 0, a[3] = {1, 2, 3}, m;
algorithm
  m := div(n, 2) + rem(n, 2) + mod(n, 3) + integer(0.4*n) + size(v, 1);
  for i in 1:3 loop k := k + i*v[i]; a[i] := a[i] + k; end for;
  for z in v loop k := k + z; end for;
  if m > 2 then k := k + a[3]; else k := 0; end if;
  assert(k == 37 or n <> 3, "no 37");
  y := k + m/10;
end count;
model M
  Block b(m = 1, base = world);
  output Real y = count(n, {1, 2, 3});
  parameter Integer n = 3;
end M;
"""


def test_integers_in_functions_are_whole(scene: Write) -> None:
    """Modelica has no Integer of a Real; ratios of whole numbers are Reals."""
    assert scene(INTEGERS).simulate(stop=0.1)["y"][-1] == pytest.approx(37.6)
    with pytest.raises(LagError, match="no 37"):
        scene(INTEGERS.replace("k == 37", "k == 36"))
    for wrong in ("m := n/2;", "a := {1, 2, 3.5};", "if n > 1 then k := n/2; end if;",
                  "for z in {0.5} loop k := z; end for;"):
        with pytest.raises(LagError, match="an Integer takes whole numbers"):
            scene(INTEGERS.replace("  assert", f"  {wrong} assert"))
