"""Assertions and terminate: where they break, whatever runs; what they say; and that the motion knows nothing of them."""

from collections.abc import Callable
from math import acos, pi, sqrt
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError, RunError
from lagrangia.command.cli import DONE, FAILED, main
from lagrangia.command.parser import WRONG

Write = Callable[[str], lag.Model]
FALLING = """
model Falling
  parameter Length h = 1;
  Prismatic a(a = world, along = {0, 1}, s(start = h)), b(a = world, along = {0, 1}, s(start = 2*h));
  PointMass m(m = 1, center = a.b), n(m = 2, center = b.b);
equation
  STATED
  annotation(experiment(StopTime = 2, Interval = 0.1));
end Falling;
"""
SOLVERS = ("erk", "erk5", "erk9", "pirk", "adams", "implicit", "taylor", "linear", "conservative")
def time_in(told: str) -> float:
    return float(told.partition("t = ")[2].partition(":")[0])


HALF = sqrt(2 * 0.5 / 9.81)  # s in which half a metre is fallen


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_run_fails_exactly_where_an_assertion_breaks(solver: str, scene: Write) -> None:
    model = scene(FALLING.replace("STATED", 'assert(a.s > 0.5, "low");'))
    with pytest.raises(RunError) as failed:
        model.simulate(solver=solver)
    told = str(failed.value)
    assert "low" in told and "a.s > 0.5" in told and "scene.lag:7:3" in told and "a.s = 0.5" in told
    assert time_in(told) == pytest.approx(HALF, abs=1e-8)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_run_ends_where_it_is_terminated(solver: str, scene: Write) -> None:
    run = scene(FALLING.replace("STATED", 'when a.s < 0.5 then terminate("low"); end when;')).simulate(solver=solver)
    assert run.time[-1] == pytest.approx(HALF, abs=1e-8) and run["a.s"][-1] == pytest.approx(0.5, abs=1e-8)
    assert len(run.time) == 5 and "low" in run.ended and run.warnings == []


def test_what_is_within_a_tolerance_of_its_bound_at_places_of_a_step_ends_it_where_it_is_met(scene: Write) -> None:
    """Beside what is a kilometre off, 5 mm are none: the run ended 5 ms late."""
    model = scene("""model M World world(gravity = {0, 0}); Block far(m = 1, base = world, s(start = 1000));
      Block slow(m = 1, base = world, v(start = 0.1)), swing(m = 1, base = world, s(start = 1));
      Spring k(k = 400, stretch = swing.s);
      equation when slow.s > 0.05 then terminate("there"); end when; annotation(experiment(StopTime = 3)); end M;""")
    for solver in ("auto", "erk9", "adams"):
        assert model.simulate(solver=solver, tolerance=1e-3, interval=0.01).time[-1] == pytest.approx(0.5, abs=1e-9)


@pytest.mark.parametrize("solver", ["erk", "erk5", "adams"])
def test_what_is_sure_in_a_later_step_ends_where_it_was_met(solver: str, scene: Write) -> None:
    """A step that ends less than an error beyond tells nothing for sure: 33 of 180 ended up to 5 ms late."""
    model = scene("""model M World world(gravity = {0, 0}); parameter Length far = 0;
      Block b(m = 1, base = world, s(start = 1000)), slow(m = 1, base = world, v(start = 0.1));
      Block swing(m = 1, base = world, s(start = 1)); Spring k(k = 400, stretch = swing.s);
      equation when slow.s > far then terminate("there"); end when; annotation(experiment(StopTime = 3)); end M;""")
    for far in np.linspace(0.05, 0.11, 30):
        run = model.simulate(solver=solver, tolerance=1e-3, interval=0.01, parameters={"far": far})
        assert run.time[-1] == pytest.approx(10 * far, abs=1e-9)


def test_events_stay_where_they_are_beside_what_is_not_sure(scene: Write) -> None:
    """A step that ended with the event went back to what might have ended the run, and the event came there: 2e-9 too high."""
    model = scene("""model M World world(gravity = {0, 0}); Block b(m = 1, base = world, s(start = 1), v(start = -1));
      equation when b.s < 0.5 then reinit(b.v, 1); end when;
      when b.s < 0.5[m] + 1e-9[m] then terminate("there"); end when; annotation(experiment(StopTime = 3)); end M;""")
    for solver in ("auto", "erk9", "implicit"):
        assert model.simulate(solver=solver, tolerance=1e-6, at=[3])["b.s"][-1] == pytest.approx(3, abs=1e-12)


def test_the_motion_knows_nothing_of_them(scene: Write) -> None:
    alone = scene(FALLING.replace("STATED", "")).simulate().rows
    stated = 'assert(a.s > 0.5, "low", AssertionLevel.warning); when b.s < -100 then terminate("far"); end when;'
    assert np.array_equal(scene(FALLING.replace("STATED", stated)).simulate().rows, alone)


@pytest.mark.parametrize("solver", ["erk", "taylor", "linear", "pirk", "conservative"])
def test_dips_between_steps_and_rows_are_found(solver: str, scene: Write) -> None:
    """x = cos(10 t) is below -0.9999 for 3 ms; rows are half a second apart, where an exact solver steps to."""
    model = scene("""model M Block b(m = 1, base = world, s(start = 1)); Spring k(k = 100, stretch = b.s);
      equation assert(b.s > -0.9999, "left", AssertionLevel.warning); assert(b.s <= 1, "touched");
      annotation(experiment(StopTime = 5, Interval = 0.5)); end M;""")
    (told,) = model.simulate(solver=solver).warnings
    assert time_in(told) == pytest.approx(acos(-0.9999) / 10, abs=1e-6)


def test_forces_of_joints_can_be_asserted(scene: Write) -> None:
    """From the horizontal, the force of a pendulum is 3 m g sin(angle fallen)."""
    model = scene("""model M Revolute h(a = world); PointMass m(m = 2, center = shift(h.b, {1, 0}));
      equation when norm(h.reaction) > 1.5*2[kg]*9.81[m/s2] then terminate("half"); end when; end M;""")
    assert model.simulate()["h.phi"][-1] == pytest.approx(-np.pi / 6, abs=1e-8)


BALL = """model Ball Prismatic p(a = world, along = {0, 1}, s(start = 1)); PointMass m(m = 1, center = p.b);
equation when p.s < 0 then reinit(p.v, -0.5*pre(p.v)); end when; STATED annotation(experiment(StopTime = 5)); end Ball;"""


def test_jumps_break_them_and_rest_does_not(scene: Write) -> None:
    assert scene(BALL.replace("STATED", 'assert(p.s >= 0, "in the floor");')).simulate().warnings == []
    with pytest.raises(RunError, match="thrown up") as failed:
        scene(BALL.replace("STATED", 'assert(p.v < 2, "thrown up");')).simulate()
    assert time_in(str(failed.value)) == pytest.approx(sqrt(2 / 9.81), abs=1e-8)


def test_what_is_true_at_the_start_does_not_end_a_run(scene: Write) -> None:
    run = scene(BALL.replace("STATED", 'when p.s > 0.5 then terminate("high"); end when;')).simulate()
    fall = sqrt(2 * 0.5 / 9.81)
    assert run.time[-1] == 5 and fall < 5 and run.ended == ""


CHECKED = FALLING.replace("STATED", """assert(h < 3, "too high"); assert(h > 0.2, "too low", AssertionLevel.warning);
  when a.s < 0 then terminate("down"); end when;""")


def test_parameters_are_checked_at_the_start(scene: Write) -> None:
    model = scene(CHECKED)
    with pytest.raises(LagError, match=r"an assertion of parameters does not hold: too high .*h = 4"):
        model.simulate(parameters={"h": 4})
    assert "too low" in model.simulate(parameters={"h": 0.1}).warnings[0]
    prepared = model.prepare(parameters={"h": 1.0})
    assert prepared([], [1.0])[-1, 1] == pytest.approx(0, abs=1e-8)
    assert prepared.ended.startswith("ended at t = 0.4515") and "down" in prepared.ended
    with pytest.raises(LagError, match="too high"):
        prepared([], [4.0])
    assert not prepared.ended


def test_runs_in_steps_end_where_they_are_terminated(scene: Write) -> None:
    run = scene(CHECKED).start()
    run.step(0.3)
    kept = run.save()
    for go_on in (lambda: run.step(0.3), lambda: run.steps(5, 0.1)):
        run.restore(kept)
        assert not run.ended
        found = go_on()
        assert run.ended.startswith("ended at t = 0.45152364: down") or "0.451523641: down" in run.ended
        assert run.time == pytest.approx(0.4515236409857, abs=1e-9) and run["a.s"] == pytest.approx(0, abs=1e-8)
        assert len(found) in (2, len(run.state)) and found.flat[-1] == (run.row[-1] if found.ndim == 2 else run.state[-1])
        with pytest.raises(RunError, match="down"):
            run.step(0.1)


def test_sweeps_have_a_row_for_each_run(scene: Write) -> None:
    sweep = scene(CHECKED).simulate_many(parameters={"h": [0.1, 1, 4]}, outputs=["final(a.s)", "min(a.s)", "max(b.s)"])
    assert sweep["final(a.s)"][:2] == pytest.approx([0, 0], abs=1e-8) and sweep["min(a.s)"][:2] == pytest.approx([0, 0], abs=1e-8)
    assert list(sweep.failures) == [2] and "too high" in sweep.failures[2]
    assert sweep.warnings() == [f"1 of 3 runs: {sweep.warnings()[0].partition(': ')[2]}"] and "too low" in sweep.warnings()[0]
    assert "too high" in sweep.common_failures()[0][0]
    both = 'assert(a.s > 0.9, "one", AssertionLevel.warning); assert(b.s > 1.9, "other", AssertionLevel.warning);'
    sweep = scene(FALLING.replace("STATED", both)).simulate_many(parameters={"h": [1, 4]}, outputs=["final(a.s)"])
    assert [told.partition(" (")[0] for told in sweep.warnings()] == [
        "2 of 2 runs: an assertion does not hold: one", "2 of 2 runs: an assertion does not hold: other"]


@pytest.mark.parametrize("end", [0.0, 1.23, 4.5])
def test_time_ends_runs_in_swings_at_rest_and_alone(end: float, scene: Write) -> None:
    """Of what swings back the way it came, of what lies, of what is driven by a sine, and of what falls."""
    swing = "Revolute h(a = world, phi(start = 1)); Bar bar(m = 1, L = 1, a = h.b);"
    driven = "Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {sin(3[rad/s]*time)*1[N], 0});"
    for text in (f"model M {swing} equation STATED end M;", BALL, f"model M {driven} equation STATED end M;", FALLING):
        run = scene(text.replace("STATED", f'when time > {end} then terminate("late"); end when;')).simulate(stop=5)
        assert run.time[-1] == pytest.approx(end, abs=1e-12)


def test_exit_codes_and_the_last_row(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("e.lag").write_text(CHECKED)
    assert main(["simulate", "e.lag"]) == DONE
    assert "ended at t = 0.451523641: down (a.s < 0, e.lag:8:21)" in capsys.readouterr().out
    assert Path("e.csv").read_text().splitlines()[-1].startswith("0.4515236409857")
    assert main(["simulate", "e.lag", "-p", "h=4"]) == WRONG
    told = capsys.readouterr().err
    assert "error[L0605]: an assertion of parameters does not hold: too high" in told and "^^^" in told


LOWER = 'assert(b.s > 1.5, "lower", AssertionLevel.warning);'


def test_models_that_test_others_fail_with_their_text(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                      capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("t.lag").write_text(FALLING.replace("Falling", "TestFails").replace("STATED", 'assert(a.s > 0.5, "low");')
                             + FALLING.replace("Falling", "TestWarns").replace("STATED", LOWER))
    assert main(["test", "t.lag"]) == FAILED
    told, warned = capsys.readouterr()
    assert "FAILED TestFails" in told and "low (a.s > 0.5" in told and "passed TestWarns" in told
    assert "warning[L0610]" in warned and "lower" in warned and "^^^" in warned
    Path("t.lag").write_text(FALLING.replace("STATED", LOWER.replace("b.s", "a.s")))
    for command in ("sweep t.lag --samples 2 -p n.m=normal(1,0.1) --strict -o t.csv", "animate t.lag --strict -o t.html"):
        assert main(command.split()) == WRONG
        assert "warning[L0610]" in (told := capsys.readouterr().err) and "^^^" in told


@pytest.mark.parametrize(("stated", "code", "said"), [
    ('assert(a.s, "x");', "L0225", "this does not"),
    ('assert(a.s > 1, a.s);', "L0302", "is a text"),
    ('assert(a.s > 1[kg], "x");', "L0304", "kg"),
    ('terminate("x");', "L0222", "terminate stands in a when"),
    ('when a.s < 0 then terminate(); end when;', "L0215", "takes a text"),
    ('when h < 0 then terminate("x"); end when;', "L0225", "for good"),
    ('when a.s < 0 then assert(b.s > 0, "x"); end when;', "L0222", "holds all the time"),
])
def test_what_is_wrong_is_told(stated: str, code: str, said: str, scene: Write) -> None:
    with pytest.raises(LagError) as found:
        scene(FALLING.replace("STATED", stated)).simulate()
    assert [d.code for d in found.value.diagnostics] == [code]
    assert said in found.value.diagnostics[0].render()


SWINGING = """
model Swinging
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, s(start = 1));
  Spring k(k = 1, stretch = b.s);
  Real s = b.s, v = der(b.s);
equation
  STATED
  annotation(experiment(StopTime = 7));
end Swinging;
"""
JUMPING = {"floor(3*s) < -1": acos(-1 / 3), "ceil(s) <= 0": pi / 2, "sign(s) < 0": pi / 2, "rem(3*s, 1) < -0.5": acos(-1 / 6),
           "div(3*s, 1) <= -2": acos(-2 / 3), "integer(4*s) <= -2 or v > 2": acos(-0.25), "not (floor(2*s) > -1)": pi / 2,
           "(if v > 0 then s else -1) > 0.5": 2 * pi - pi / 3, "(if s > 0 then 1 else -1)*v > 0.3": pi / 2,
           "mod(time, 1) > 0.7 and s < 0": 1.7, "max(floor(3*s), floor(3*v)) < 0": pi / 2}


@pytest.mark.parametrize("condition", JUMPING)
def test_conditions_that_jump_break_and_end_where_they_say(condition: str, scene: Write) -> None:
    """s = cos t, v = -sin t: what jumps has no root, and what rests at 0, as floor does, is not beyond it."""
    ends, breaks = (scene(SWINGING.replace("STATED", stated)) for stated in
                    (f'when {condition} then terminate("there"); end when;', f'assert(not ({condition}), "not there");'))
    for solver in ("auto", "erk", "pirk", "implicit"):
        assert ends.simulate(solver=solver, tolerance=1e-9)["time"][-1] == pytest.approx(JUMPING[condition], abs=1e-7)
        with pytest.raises(RunError) as failed:
            breaks.simulate(solver=solver, tolerance=1e-9)
        assert time_in(str(failed.value)) == pytest.approx(JUMPING[condition], abs=1e-7)


def test_what_jumps_on_both_sides_of_equality_is_told(scene: Write) -> None:
    with pytest.raises(LagError, match="L0225") as refused:
        scene(SWINGING.replace("STATED", 'assert((if floor(s) == 1 then 2*v else v) > -2, "odd");'))
    assert "in a way that is not taken apart" in str(refused.value)


def test_what_is_far_costs_no_evaluations(scene: Write) -> None:
    """Verner's method steps to what is looked at inside: 76 evaluations a step for 16, with what nothing comes near."""
    text = """model M Block b(m = 1, base = world, s(start = 1)); Spring k(k = 4, stretch = b.s); STATED end M;"""
    free = scene(text.replace("STATED", "")).simulate(solver="erk9", stop=10, interval=0.2)
    model = scene(text.replace("STATED", "parameter Length most = 100; equation assert(b.s < most, \"far\");"))
    watched = model.simulate(solver="erk9", stop=10, interval=0.2)
    assert watched.statistics.rhs_evaluations == free.statistics.rhs_evaluations and (watched.rows == free.rows).all()
    with pytest.raises(RunError, match="far"):
        model.simulate(solver="erk9", stop=10, interval=10, parameters={"most": 0.99999}, tolerance=1e-9)


def test_what_moves_within_a_step_alone_is_seen(scene: Write) -> None:
    """A block that rests at both ends of a step, which a force pushes forth and back in it."""
    model = scene("""model M World world(gravity = {0, 0}); Block b(m = 1, base = world); Real u = 2*(time/1[s] - 4);
      AppliedForce f(at = b.center, force = {(4*u^2 - 2)*exp(-u^2)*4[N], 0});
      equation assert(b.s < 0.9[m], "there"); annotation(experiment(StopTime = 8, Interval = 8)); end M;""")
    for solver in ("erk", "erk9"):
        with pytest.raises(RunError, match="there"):
            model.simulate(solver=solver, tolerance=1e-3)
