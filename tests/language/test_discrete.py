"""Discrete variables: counters, flags and what was read at events, beside closed forms."""

import math
from pathlib import Path

import pytest

import lagrangia
from lagrangia.draw.modes_film import animate_mode
from lagrangia.study.sweep.measures import usual_measures
from lagrangia.view.rows import shown

G = 9.81
BALL = """
model Ball "Bounces; what happens is counted, and after the third impact a flag is up"
  Prismatic way(a = world, along = {0, 1}, s(start = 1));
  PointMass ball(m = 1, center = way.b);
  Integer n(start = 0);
  Boolean low = way.s < 0, done;
  discrete Velocity fastest(start = 0);
  discrete Time last(start = -1), gap;
  output Real flag = if done then 1 else 0;
equation
  when low then
    reinit(der(way.s), -0.8*pre(der(way.s)));
    n = pre(n) + 1;
    done = n >= 3;
    fastest = max(pre(fastest), -pre(der(way.s)));
    gap = last - pre(last);
    last = time;
  end when;
end Ball;
"""
COUNTS = """
model Part "Counts how often u comes true"
  Boolean u;
  Integer n(start = 0);
equation
  when u then
    n = pre(n) + 1;
  end when;
end Part;
model Counts "x = cos(t)"
  Block block(m = 1, base = world, s(start = 1));
  Spring spring(k = 1, stretch = block.s);
  Boolean down = block.s < 0, up = block.s > 0;
  Integer first(start = 4, fixed = true), once(start = 0), both(start = 0), sampled(start = 0), jumps(start = 0);
  Integer edges(start = 0), turns(start = 0);
  Boolean even(start = true), then_on;
  Part part[9](u = {block.s < 0.1*i for i in 1:9});
  output Integer total = sum(part.n);
equation
  when {initial(), edge(down)} then
    first = pre(first) + 1;
  end when;
  when {block.s < 0, 2*block.s < 0, time > 99} then
    once = pre(once) + 1;
  end when;
  when {down, up} then
    both = pre(both) + 1;
  end when;
  when change(down) then
    edges = pre(edges) + 1;
  end when;
  when both > 2 then
    jumps = pre(jumps) + 1;
  end when;
  when sample(0.5, 1) then
    sampled = pre(sampled) + 1;
    even = not pre(even);
  end when;
  when block.s > 0 then
    turns = 2;
    then_on = true;
  elsewhen not up then
    turns = integer(turns_of(pre(turns)));
    then_on = false;
  end when;
end Counts;
function turns_of
  input Real x;
  output Real y = floor(x + 1);
end turns_of;
"""


def run(tmp_path: Path, text: str, name: str, **options: object) -> lagrangia.Trajectory:
    file = tmp_path / f"{name}.lag"
    file.write_text(text, encoding="utf-8")
    return lagrangia.load(file, model=name).simulate(**options)


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_ball(tmp_path: Path, solver: str) -> None:
    result = run(tmp_path, BALL, "Ball", stop=2.5, solver=solver, tolerance=1e-10)
    speed, first = math.sqrt(2 * G), math.sqrt(2 / G)
    impacts = [first]
    while impacts[-1] < 2.5:
        speed *= 0.8
        impacts.append(impacts[-1] + 2 * speed / G)
    times = impacts[:-1]
    end = {name: float(result[name][-1]) for name in ("n", "done", "flag", "fastest", "last", "gap")}
    assert end == pytest.approx({"n": len(times), "done": 1, "flag": 1, "fastest": math.sqrt(2 * G), "last": times[-1],
                                 "gap": times[-1] - times[-2]}, rel=1e-9)
    counted = [sum(t > x for x in times) for t in result.time]
    near = [min(abs(t - x) for x in times) < 1e-9 for t in result.time]
    assert all(n == k for n, k, is_near in zip(result["n"], counted, near, strict=True) if not is_near)  # whole to the last digit
    assert all(done == (k >= 3) for done, k, is_near in zip(result["done"], counted, near, strict=True) if not is_near)


def test_lists_edges_and_the_start(tmp_path: Path) -> None:
    """Down at pi/2 + 2 pi k, up a half turn later: within 20 s three times each; below 0.1 i once more where i > 4."""
    result = run(tmp_path, COUNTS, "Counts", stop=20.0)
    names = ("first", "once", "both", "edges", "jumps", "sampled", "even", "turns", "then_on", "total")
    start, end = ({name: float(result[name][k]) for name in names} for k in (0, -1))
    assert start == {"first": 5, "once": 0, "both": 0, "edges": 0, "jumps": 0, "sampled": 0, "even": 1, "turns": 0, "then_on": 0,
                     "total": 0}
    assert end == {"first": 8, "once": 3, "both": 6, "edges": 6, "jumps": 1, "sampled": 20, "even": 1, "turns": 2, "then_on": 1,
                   "total": 9 * 3 + 5}


def test_small_motion_keeps_them(tmp_path: Path) -> None:
    """m s'' + c s' + k s = 2 n rests, and dies out, about 0.5 n: n is no unknown, no state, no mode."""
    file = tmp_path / "held.lag"
    file.write_text("""
model Held "A spring beside a force that events make larger"
  Block block(m = 1, base = world, s(start = 3));
  Spring spring(k = 4, stretch = block.s);
  Damper damper(c = 0.4, rate = der(block.s));
  Integer n(start = 2);
  Boolean up;
energy
  work 2[N]*n on block.s;
equation
  when block.s < 1 then
    n = pre(n) + 1;
    up = true;
  end when;
end Held;
""", encoding="utf-8")
    model = lagrangia.load(file)
    (rest,) = model.equilibrium()
    assert rest.stability == "asymptotically stable" and rest.n_neutral == 0
    assert {**rest.position} == pytest.approx({"block.s": 1, "n": 2, "up": 0})
    assert model.equilibrium(initial={"n": 5})[0].position["block.s"] == pytest.approx(2.5)
    linear, modes = model.linearize(), model.modes()
    assert linear.states == ("block.s", "der(block.s)") and linear.outputs == ("block.s",)
    assert linear.K.tolist() == [[4]] and linear.C.tolist() == [[0.4]]
    assert modes.coordinates == ("block.s",) and modes.omega == pytest.approx([2]) and len(modes.damped) == 1
    modes.plot(tmp_path / "modes.svg")
    assert "</html>" in animate_mode(model, model.study(), modes, 0)
    assert model.linearize(about="start").states == linear.states


LEVELS = """
model Levels "n = 1, 2, 1, 0, 1, 2, 1, 0, 1, 2 at 0.5, 1, ...; x jumps onto 1, and falls"
  Block block(m = 3, base = world);
  Integer k(start = 0), n(start = 0), from(start = 0), above(start = 0), upto(start = 0), below(start = 0), both(start = 0);
  Integer lists(start = 0), on(start = 0), over(start = 0), fast(start = 0), faster(start = 0), begun(start = 0);
  Real x(start = 0);
  discrete Real part(start = 0), third(start = 0);
  Boolean high = not n < 2;
equation
  der(x) = -0.1;
  when time > 0.5*(k + 1) then
    k = pre(k) + 1;
    n = pre(n) + (if mod(k, 4) == 1 or mod(k, 4) == 2 then 1 else -1);
    part = k/10;
  end when;
  when n >= 1 then from = pre(from) + 1; end when;
  when n > 1 then above = pre(above) + 1; end when;
  when n <= 1 then upto = pre(upto) + 1; end when;
  when n < 1 then below = pre(below) + 1; end when;
  when high and block.s >= 0 or n < -9 then both = pre(both) + 1; end when;
  when {n >= 1, n >= 2} then lists = pre(lists) + 1; end when;
  when part >= 0.3 then third = time; end when;
  when time > 1.2 then
    reinit(x, 1);
    reinit(der(block.s), 0.7);
  end when;
  when x >= 1 then on = pre(on) + 1; end when;
  when x > 1 then over = pre(over) + 1; end when;
  when der(block.s) >= 0.7 then fast = pre(fast) + 1; end when;
  when der(block.s) > 0.7 then faster = pre(faster) + 1; end when;
  when n >= 0 or time >= 0 then begun = 1; end when;
  assert(n < 2, "two", AssertionLevel.warning);
  assert(k <= 10, "more than ten", AssertionLevel.warning);
  when k >= 10 then terminate("ten"); end when;
  annotation(experiment(StopTime = 9));
end Levels;
"""
MET = {"k": 10, "n": 2, "from": 3, "above": 3, "upto": 2, "below": 2, "both": 3, "lists": 6, "on": 1, "over": 0, "fast": 1,
       "faster": 0, "begun": 0}


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_events_that_jump_onto_a_level(tmp_path: Path, solver: str) -> None:
    """>= and <= are true there, > and < are not; what is true at the start does not come."""
    result = run(tmp_path, LEVELS, "Levels", solver=solver)
    assert {name: float(result[name][-1]) for name in MET} == MET
    assert result["third"][-1] == pytest.approx(1.5) and result.time[-1] == pytest.approx(5)
    said = [text for text in result.warnings if "assertion" in text]
    assert len(said) == 1 and "t = 1:" in said[0]

@pytest.mark.parametrize("first", ["when initial() then n = 5; end when;", "when {initial(), time > 3} then n = 5; end when;"])
def test_two_whens_and_the_start(tmp_path: Path, first: str) -> None:
    """One at the start and another one later is right; two later ones are told, whatever begins."""
    text = f"""
model Begins "Turns at 1"
  Block block(m = 1, base = world, s(start = 1));
  Spring spring(k = 1, stretch = block.s);
  Integer n(start = 0), turns(start = 0);
equation
  {first}
  when block.s < 0 then n = pre(n) + 1; end when;
  when change(n) then turns = pre(turns) + 1; end when;
end Begins;
""".replace("change(n)", "change(block.s < 0)")
    if "time" in first:
        with pytest.raises(lagrangia.LagError, match="given a value in two places"):
            run(tmp_path, text, "Begins")
        return
    result = run(tmp_path, text, "Begins", stop=3.0)
    assert (result["n"][0], result["n"][-1], result["turns"][-1], list(result.warnings)) == (5, 6, 1, [])


def test_a_start_alone_is_no_idle_one(tmp_path: Path) -> None:
    file = tmp_path / "alone.lag"
    file.write_text("""
model Alone "x'' = n"
  Block block(m = 1, base = world);
  Integer n(start = 0);
energy
  work 1[N]*n on block.s;
equation
  when initial() then n = 2; end when;
end Alone;
""", encoding="utf-8")
    model = lagrangia.load(file)
    assert not model.warnings and model.simulate(stop=1.0)["block.s"][-1] == pytest.approx(1)


EQUAL = """
model Equal "n = 1, 2, ..., 5 at 0.5, 1, ...; x = t; b is true where n is odd"
  Block block(m = 1, base = world);
  Integer n(start = 0), c[0];
  Boolean b(start = false), late = n > 2;
  Counter count[12](u = {n == 3, n <> 1, not n == 3, floor(block.s) == 1, b == true, b == late, b <> late, mod(n, 2) == 0,
    mod(n, 2) > 0, abs(n - 2) == 1, n == 1 or n == 4, n == 5 and block.s > 1});
equation
  when time > 0.5*(n + 1) then
    n = pre(n) + 1;
    b = not pre(b);
  end when;
initial equation
  der(block.s) = 1;
  annotation(experiment(StopTime = 2.7));
end Equal;
model Counter
  Boolean u;
  Integer k(start = 0);
equation
  when u then k = pre(k) + 1; end when;
end Counter;
""".replace(", c[0]", "")


def test_equal_numbers(tmp_path: Path) -> None:
    """Of whole numbers, and of what is true or false; what is so at the start comes when it has been false."""
    result = run(tmp_path, EQUAL, "Equal")
    assert [result[f"count[{k}].k"][-1] for k in range(1, 13)] == [1, 1, 1, 1, 3, 2, 2, 2, 3, 2, 2, 1]


OF_FUNCTIONS = """
function twice
  input Integer n;
  output Integer y = 2*n;
end twice;
function upto "How many of 1, 2, 3 are not above n"
  input Integer n;
  input Real x;
  output Integer y;
protected
  Integer s = 0;
algorithm
  for i in 1:3 loop
    if i <= n then s := s + 1; end if;
  end for;
  if x > 100 then y := s + integer(x); else y := s; end if;
end upto;
function half
  input Integer n;
  output Integer y = n/2;
end half;
function is_far
  input Real x;
  output Boolean y = x > 0.7;
end is_far;
model OfFunctions "n = 1, 2, ..., 5 at 0.5, 1, ...; x = t"
  Block block(m = 1, base = world, v(start = 1));
  Integer n(start = 0), fours(start = 0), m = twice(n), over(start = 0), three(start = 0), z(start = 0), far(start = 0);
  Boolean is_up(start = false), is_away = is_far(block.s);
equation
  when time > 0.5*(n + 1) then n = pre(n) + 1; is_up = is_far(block.s + 0.1); end when;
  when twice(n) == 4 then fours = pre(fours) + 1; end when;
  when m > 4 then over = pre(over) + 1; z = twice(pre(z) + 3); end when;
  when upto(n, block.s) >= 3 then three = upto(4, pre(z)); end when;
  when {is_far(block.s), not is_away} then far = twice(pre(far)) + 1; end when;
  assert(twice(n) <> 6, "six", AssertionLevel.warning);
  annotation(experiment(StopTime = 2.7));
end OfFunctions;
"""


def test_results_of_functions(tmp_path: Path) -> None:
    """Integer and Boolean ones are whole, true or false; a function that divides, or is given what is not whole, is refused."""
    result = run(tmp_path, OF_FUNCTIONS, "OfFunctions")
    wanted = {"n": 5, "fours": 1, "over": 1, "z": 6, "three": 3, "far": 1, "is_up": 1}
    assert {name: float(result[name][-1]) for name in wanted} == wanted
    assert [said for said in result.warnings if "six" in said and "t = 1.5" in said]
    for wrong in ("half(pre(z))", "twice(0.5*pre(z))"):
        with pytest.raises(lagrangia.LagError, match="an Integer takes whole numbers"):
            run(tmp_path, OF_FUNCTIONS.replace("twice(pre(z) + 3)", wrong), "OfFunctions")


def test_elements_of_arrays_are_as_they_were_and_as_they_are(tmp_path: Path) -> None:
    """y, z, w and p follow from a, which is 1 from t = 1 on: new in the `when` of a, and as before under pre behind it."""
    text = """model Arrays
      Real x(start = 0, fixed = true), y[2], z[2], w[2, 2], p[2];
      parameter Real A[2, 2] = {{1, 2}, {3, 4}};
      Integer a(start = 0), new(start = 0), was(start = 5), is(start = 0);
    equation
      der(x) = 1;
      for i in 1:2 loop y[i] = 10*a*i; end for;
      z[1:2] = 2*y; w = {z, y}; p = A*y + {x, 0};
      when x > 1 then a = 1; new = integer(y[2] + w[1, 2]); end when;
      when a > 0 then
        was = integer(pre(y[2]) + pre(sum(z)) + pre(w[2, 1]) + pre(p[2])); is = integer(y[2] + z[1] + w[1, 2] + p[2]);
      end when;
      annotation(experiment(StopTime = 2));
    end Arrays;"""
    result = run(tmp_path, text, "Arrays")
    assert [result[name][-1] for name in ("new", "was", "is")] == [60, 0, 20 + 20 + 40 + 110]


@pytest.mark.parametrize(("first", "other", "are_told"), [
    ("n == 2", "n >= 2", True), ("n >= 2", "n == 2", True), ("n <= 2 and n >= 2", "n >= 2", True), ("n == 2", "n <> 3", True),
    ("n >= 2", "n <= 2", False), ("n == 2", "n == 3", False), ("n == 2", "n <> 2", False), ("n > 2", "n < 2", False),
])
def test_conditions_that_come_true_at_once_are_told(first: str, other: str, are_told: bool, tmp_path: Path) -> None:
    """The second of a `when` and its elsewhen, where it resets what moves."""
    file = tmp_path / "model.lag"
    file.write_text(f"""model M Block b(m = 1, base = world, along = {{1, 0}});
        Spring s(k = 1, stretch = b.s); Integer n(start = 0), k(start = 0);
        equation when {first} then k = pre(k) + 1; elsewhen {other} then reinit(der(b.s), 1); end when;
        when sin(4*pi*time/1[s]) > 0.1 then n = pre(n) + 1; end when; end M;""", encoding="utf-8")
    assert any("L0237" in told for told in lagrangia.load(file).warnings) is are_told


def test_a_condition_that_is_said_to_be_true_is_a_contact(tmp_path: Path) -> None:
    text = BALL.replace("Boolean low = way.s < 0", "Boolean low = (way.s < 0) == true")
    assert run(tmp_path, text, "Ball", stop=4.0)["n"][-1] == run(tmp_path, BALL, "Ball", stop=4.0)["n"][-1] > 3


def test_a_number_that_is_not_what_it_was_has_changed(tmp_path: Path) -> None:
    """n <> pre(n), as Modelica has it, is change(n); for what is true or false, too."""
    text = """model Told "n goes to 1 at 1 s and to 5 at 2 s, o to and fro at 1.5 and 1.7 s"
      Block b(m = 1, base = world, v(start = 1));
      Integer n(start = 0), k(start = 0), j(start = 0), f(start = 0);
      Boolean o(start = false);
    equation
      when b.s > 1 then n = pre(n) + 1; elsewhen b.s > 2 then n = 5; end when;
      when {b.s > 1.5, b.s > 1.7} then o = not pre(o); end when;
      when n <> pre(n) then k = pre(k) + 10*n + pre(n); end when;
      when pre(n) <> n then j = pre(j) + 1; end when;
      when o <> pre(o) then f = pre(f) + 1; end when;
    end Told;"""
    found = run(tmp_path, text, "Told", stop=2.5)
    assert [found[name][-1] for name in "nkjf"] == [5, 61, 2, 2]


def test_what_events_know_of_changes_is_in_no_table(tmp_path: Path) -> None:
    """n.before is the event's own, in results, sweeps and FMUs, and cannot be started."""
    file = tmp_path / "ball.lag"
    counted = "Integer changes(start = 0); equation when change(n) then changes = pre(changes) + 1; end when;"
    file.write_text(BALL.replace("equation", counted, 1), encoding="utf-8")
    model = lagrangia.load(file)
    names = {column.name for column in shown(model.scene)[0].rates} | {m.quantity for m in usual_measures(model.scene)}
    assert {"n", "changes", "der(way.s)"} <= names and not any("before" in name or "integral" in name for name in names)
    for name in (*model.scene.inner, *(f"der({x})" for x in model.scene.inner)):
        with pytest.raises(lagrangia.LagError, match="no coordinate or rate") as said:
            model.simulate(initial={name: 4.0})
        assert "n.before'" not in str(said.value).replace(f"'{name}'", "")


GEARS = """
model Gears "x = cos(t); the gear goes 1, 2, 3, 1 at pi/3, 2 pi/3 and 2 pi - acos(0.9)"
  Block b(m = 1, base = world, s(start = 1));
  Spring spring(k = 1, stretch = b.s);
  parameter Integer last = 9;
  Integer gear(start = 1), shifts(start = 0), sum(start = 0), late(start = 0);
  discrete Real level(start = 0);
  discrete Time third(start = 0);
equation
  when b.s < 0.5 and gear == 1 then gear = 2;
  elsewhen b.s < -0.5 and pre(gear) == 2 then gear = 3; third = time;
  elsewhen b.s > 0.9 and gear >= 3 then gear = 1;
  end when;
  when change(gear) then shifts = pre(shifts) + 1; level = 0.5; end when;
  when shifts > 0 then sum = pre(sum) + shifts; end when;
  when not (level < 0.5 or b.s > -0.9) then late = pre(late) + 1; end when;
  when b.s < -0.7 and gear == last then terminate("there"); end when;
  annotation(experiment(StopTime = 7));
end Gears;
"""


@pytest.mark.parametrize("solver", ["auto", "erk", "pirk", "implicit"])
def test_what_moves_beside_what_is_on_its_level(solver: str, tmp_path: Path) -> None:
    """gear == 1 holds on its level alone, so that x < 0.5 beside it is what comes; and what is added up is no one-way rate."""
    result = run(tmp_path, GEARS, "Gears", solver=solver)
    assert [result[name][-1] for name in ("gear", "shifts", "sum", "late")] == [1, 3, 1, 1]
    assert result["third"][-1] == pytest.approx(2*math.pi/3, abs=1e-7)


def test_runs_end_where_what_moves_comes_beside_a_counter(tmp_path: Path) -> None:
    result = run(tmp_path, GEARS.replace("last = 9", "last = 3"), "Gears")
    assert result.time[-1] == pytest.approx(math.acos(-0.7), abs=1e-7)


def test_what_moves_beside_counters_that_are_counted_round(tmp_path: Path) -> None:
    """mod(gear, 3) == 1 jumps, and is as gear == 1: also where it says what a moving part is compared with, or ends the run."""
    text = GEARS
    for plain, jumping in (("gear == 1", "mod(gear, 3) == 1"), ("pre(gear) == 2", "rem(pre(gear), 3) == 2"),
                           ("b.s > 0.9 and gear >= 3", "(if mod(gear, 3) == 0 then b.s else 0) > 0.9"),
                           ("gear == last", "mod(gear, 4) == last")):
        assert text.count(plain) == 1
        text = text.replace(plain, jumping)
    result = run(tmp_path, text, "Gears")
    assert [result[name][-1] for name in ("gear", "shifts", "sum", "late")] == [1, 3, 1, 1]
    assert result["third"][-1] == pytest.approx(2*math.pi/3, abs=1e-7)
    assert run(tmp_path, text.replace("last = 9", "last = 3"), "Gears").time[-1] == pytest.approx(math.acos(-0.7), abs=1e-7)


@pytest.mark.parametrize("begin", ["equilibrium", {"der(b.s)": 0.0}])
def test_starts_that_are_found_name_no_inner_ones(begin: "str | dict[str, float]", tmp_path: Path) -> None:
    file = tmp_path / "gears.lag"
    file.write_text(GEARS.replace("s(start = 1)", "s(start = 0)"), encoding="utf-8")
    result = lagrangia.load(file).simulate(from_=begin, stop=1.0)
    assert (result["gear"][-1], result["b.s"][-1]) == (1, pytest.approx(0, abs=1e-9))


STEPPED = """
model Stepped "pushed from 1 s on by 1 N"
  Block b(m = 1, base = world);
  input Real on(start = 0);
  Integer n(start = 0);
  AppliedForce f(at = b.center, force = {if on > 0.5 then 1 else 0, 0});
equation
  when on > 0.5 then n = pre(n) + 1; end when;
end Stepped;
"""


def test_inputs_that_step_bring_events(tmp_path: Path) -> None:
    """As the message of a Boolean input says (L0219)."""
    result = run(tmp_path, STEPPED, "Stepped", stop=2.0, inputs=([0, 1, 1, 2], {"on": [0, 0, 1, 1]}))
    assert [result[name][-1] for name in ("n", "b.s")] == [1, pytest.approx(0.5, abs=1e-9)]
