"""Events that never come, assertions that always hold, and frames that are nowhere are warned of; what may come is not."""

from collections.abc import Callable

import pytest

import lagrangia as lag
from lagrangia.command.cli import main

Write = Callable[[str], lag.Model]
SCENE = """type E = enumeration(a, b);
model M
  parameter Stiffness k(min = 0) = 1; parameter Real few(min = 1, max = 3) = 2; parameter Real any = 2;
  Real z = abs(b.s)/1[m] + 1;
  Block b(m = 1, base = world, s(start = 1)); Spring s(k = k, stretch = b.s);
  output Real shown = few + any + u; input Real u;
STATED
  annotation(experiment(StopTime = 5));
end M;"""
NEVER = (
    "sin(b.s/1[m]) > 2", "b.s^2 < 0", "abs(b.v) < 0", "b.s > 1 and b.s < 0", "time > 5", "z < 1", "few*abs(b.s) < 0",
    "k < -b.s^2*1[N/m3]", "2 + cos(1[rad/s]*time) <= 0.5", "max(b.s, 1) < 1", "not b.s^2 >= 0", "time >= 2 and time <= 2",
    "floor(b.s/1[m]) >= 3 and floor(b.s/1[m]) <= 2", "b.s^2 >= 0", "b.s^2/few < 0",
    "sqrt(abs(b.s)/1[m]) < 0 or time > 7", "few + b.s^2/1[m2] < 1", "exp(b.s/1[m]) < 0", "few > 0.5 or b.s > 1")
MAY = (
    "sin(b.s/1[m]) > 0.9", "b.s^2 < 1", "b.s < 0", "b.s > 0 and b.s < 1", "time > 4", "z < 1.5", "few*b.s < 0", "any < b.s/1[m]",
    "b.s > 1 or b.s < 0", "b.s^3 < 0", "k < b.s*1[N/m2]", "b.s/few < 0", "min(b.s, 1) < 0.5", "few > 2.5 + b.s/1[m]",
    "atan2(b.s, b.v*1[s]) > 3", "integer(time/1[s]) >= 2 and integer(time/1[s]) <= 2", "z >= 2 and z <= 2 + sign(b.s)")

TOUCHING = ("sin(2*pi*time/1[s]) >= 1", "not cos(b.s/1[m]) > -1", "sin(b.s/1[m]) < 1", "(time - 1)^2 <= 0", "z <= 1",
            "b.v > 0 and abs(b.s) <= 0", "distance(world, b.center) <= 0", "k*b.s^2 <= 0 or time > 2",
            "time*(2 - time) >= 1", "b.s^2 + 9 > 6*b.s", "2*time - time^2/2 < 2")
KEPT = ("time*(2 - time) >= 0.99", "time*(2 - time) > 1", "b.s^2 - 4*b.s < 4",
        "sign(b.s) >= 1", "max(b.s, 0) <= 0", "time >= 4", "mod(time, 1) <= 0", "(if b.s > 0 then 1 else sin(b.s/1[m])) >= 1",
        "sin(b.s/1[m]) >= 1 - 1e-6", "distance(world, b.center) <= 1[mm]", "abs(b.v) <= 0", "(b.s - 1[m])^2 > 0", "abs(u) > 0",
        'abs(table(time, {0, 1, 2}, {0, 0, 1}, smoothness = "steps")) > 0', "distance(world, b.center) > 1[m]*few - 1[m]*few")


@pytest.mark.parametrize("condition", [*TOUCHING, *KEPT])
def test_what_just_reaches_a_level_is_told(condition: str, scene: Write) -> None:
    """The sine came to its level at 0.25 and 1.25 s, and not at 2.25 s, where rounding kept it below."""
    found = scene(SCENE.replace("STATED", f'equation when {condition} then terminate("x"); end when;')).compilation.flat.warnings
    assert [d.code for d in found] == ["L0239"] * (condition in TOUCHING)


def test_starts_without_a_value_are_told_where_they_stand(scene: Write) -> None:
    """1/s has none at the start, and two that follow from each other never have (it was nested too deeply)."""
    text = SCENE.replace("STATED", 'equation when 1/b.s^2 > 0 then terminate("x"); end when;')
    found = scene(text.replace("s(start = 1)", "s(start = 0)")).compilation.flat.warnings
    assert all(d.code != "L0239" for d in found)
    with pytest.raises(lag.LagError, match="L0602"):
        scene(SCENE.replace("STATED", 'Block c(m = 1, base = world, s(start = b.s)); equation when (b.s - c.s)^2 > 0 then '
                            'terminate("x"); end when;').replace("s(start = 1)", "s(start = c.s)")).compile()


def told(model: lag.Model) -> list[str]:
    return [d.message for d in model.compilation.flat.warnings if d.code == "L0224"]


@pytest.mark.parametrize("condition", NEVER)
def test_what_never_comes_is_told(condition: str, scene: Write) -> None:
    (said,) = told(scene(SCENE.replace("STATED", f'equation when {condition} then terminate("x"); end when;')))
    assert said.startswith("this event never comes")


def test_no_event_comes_before_the_start(scene: Write) -> None:
    text = SCENE.replace("STATED", 'equation when time < -1 then terminate("x"); end when; assert(time > -2, "x");')
    early, held = scene(text).compilation.flat.warnings
    assert "never true" in early.message and early.hints == ("the experiment begins at 0 s and ends at StopTime = 5 s",)
    assert held.message == "this holds whatever happens: 'time > -2'"
    assert told(scene(text.replace("StopTime = 5", "StartTime = -3"))) == []


def test_a_stop_time_counts_where_it_is_stated(scene: Write) -> None:
    """One of 1 s had been taken for none."""
    text = SCENE.replace("STATED", 'equation when time > 1 then terminate("x"); end when;')
    assert len(told(scene(text.replace("StopTime = 5", "StopTime = 1")))) == 1
    assert told(scene(text.replace("StopTime = 5", "Interval = 1"))) == []


@pytest.mark.parametrize("condition", MAY)
def test_what_may_come_is_not(condition: str, scene: Write) -> None:
    stated = f'equation when {condition} then terminate("x"); end when; assert({condition}, "x");'
    assert told(scene(SCENE.replace("STATED", stated))) == []


def test_assertions_that_always_hold_are_told(scene: Write) -> None:
    text = SCENE.replace("STATED", 'equation assert(b.s^2 >= 0, "x"); assert(few < 4, "x"); assert(b.s^2 > 0, "x");')
    assert told(scene(text)) == ["this holds whatever happens: 'b.s^2 >= 0'", "this holds whatever happens: 'few < 4'"]
    assert scene(text.replace("experiment(", 'allow = "L0224", experiment(')).warnings == []


def test_events_of_parts_in_arrays_and_subclasses_are_told(scene: Write) -> None:
    part = """model Part Block b(m = 1, base = world); equation when b.s^2 < 0 then reinit(b.v, 0); end when; end Part;
      model Sub extends Part; end Sub; package P model In extends Sub; end In; end P; model M PARTS end M;"""
    for parts, count in (("Part p[3];", 1), ("Sub p;", 1), ("P.In p[9];", 1)):
        assert len(told(scene(part.replace("PARTS", parts)))) == count


def test_frames_that_are_nowhere_are_told_once(scene: Write) -> None:
    model = scene("model M Block b(m = 1, base = world); Frame f[3]; Frame g if true; Frame h = shift(b.center, {1, 0}); end M;")
    found = [text for text in model.warnings if "nothing uses the frame" in text]
    assert len(found) == 2 and "'f'" in found[0] and "'g'" in found[1]


def test_enumerations_that_nothing_reads_are_told(scene: Write) -> None:
    assert told(scene(SCENE.replace("STATED", "parameter E e = E.a;"))) == ["nothing reads the parameter 'e'"]


def test_of_a_run_its_own_start_and_stop_count(scene: Write, capsys: pytest.CaptureFixture[str]) -> None:
    text = SCENE.replace("STATED", 'equation when time > -3 then reinit(b.v, 1); end when; when time > 15 then reinit(b.v, 2);'
                                   ' end when; assert(time < 12, "late"); when b.s^2 < 0 then reinit(b.v, 3); end when;')
    file = scene(text).path
    for asked, kept in ((["--stop", "4"], ["time > -3", "time > 15", "time < 12", "b.s^2 < 0"]),
                        (["--start", "-2.5", "--stop", "11"], ["time > -3", "time > 15", "time < 12", "b.s^2 < 0"]),
                        (["--start", "-5"], ["time > 15", "time < 12", "b.s^2 < 0"]),
                        (["--stop", "13"], ["time > -3", "time > 15", "b.s^2 < 0"]),
                        (["--start", "-5", "--stop", "20"], ["b.s^2 < 0"])):
        main(["simulate", str(file), "--output", "-", *asked])
        told = capsys.readouterr().err
        assert told.count("L0224") == len(kept) and all(f"'{condition}'" in told for condition in kept), asked
    main(["draw", str(file), "--output", "-", "--at", "18"])
    told = capsys.readouterr().err
    assert told.count("L0224") == 2 and "'time > 15'" not in told and "'time < 12'" not in told
