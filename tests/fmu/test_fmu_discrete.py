"""Discrete variables in FMUs: of the types that they have in the model, changed at events alone."""

import math
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

from fmpy import read_model_description, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.validation import validate_fmu

import lagrangia
from helpers.broken_fmus import described
from lagrangia.fmu.check import check_fmu

BALL = """
model Ball "Bounces; what happens is counted"
  Prismatic way(a = world, along = {0, 1}, s(start = 1));
  PointMass ball(m = 1, center = way.b);
  Integer n(start = 0);
  Boolean low = way.s < 0, done;
  discrete Time last(start = -1);
  output Integer k(start = 2);
equation
  when low then
    reinit(der(way.s), -0.8*pre(der(way.s)));
    n = pre(n) + 1;
    done = n >= 3;
    k = pre(k) + 2;
    last = time;
  end when;
  annotation(experiment(StopTime = 2.5));
end Ball;
"""
TYPES = {"n": ("Int32", "Integer", "local"), "done": ("Boolean", "Boolean", "local"), "last": ("Float64", "Real", "local"),
         "k": ("Int32", "Integer", "output")}


@pytest.mark.parametrize("version", ["2", "3"])
def test_types_and_values(tmp_path: Path, version: str) -> None:
    file = tmp_path / "ball.lag"
    file.write_text(BALL, encoding="utf-8")
    model = lagrangia.load(file)
    (path,) = model.export_fmu(tmp_path / "ball.fmu", fmi=version)
    assert not validate_fmu(str(path)) and not check_fmu(path).faults
    known = {v.name: v for v in read_model_description(str(path)).modelVariables}
    assert {name: (known[name].type, known[name].causality, known[name].variability) for name in TYPES} == {
        name: (own[version == "2"], own[2], "discrete") for name, own in TYPES.items()}
    native = model.simulate()
    for kind in ("ModelExchange", "CoSimulation"):
        end = simulate_fmu(str(path), fmi_type=kind, stop_time=2.5, output=[*TYPES], relative_tolerance=1e-8)[-1]
        assert {name: end[name] for name in ("n", "done", "k")} == {"n": 4, "done": True, "k": 10}, kind
        assert end["last"] == pytest.approx(native["last"][-1], abs=1e-6), kind


COUNTS = """
model Counts "x = cos(t): down at pi/2 + 2 pi k; n = 1, 2, ... at 0.5, 1, ..."
  Block block(m = 1, base = world, s(start = 1));
  Spring spring(k = 1, stretch = block.s);
  Integer n(start = 0), downs(start = 0), turns(start = 0), two(start = 0), more(start = 0);
  Boolean down(start = false);
  discrete Time first(start = 0), last(start = 0), third(start = 0), ticked(start = 0);
  Integer ticks(start = 0), mark(start = 0), shown(start = 0);
  discrete Time seen(start = 0);
equation
  when time > 0.5*(n + 1) then n = pre(n) + 1; end when;
  when block.s < 0 then down = true; downs = pre(downs) + 1; elsewhen block.s > 0 then down = false; end when;
  when change(down) then turns = pre(turns) + 1; last = time; end when;
  when downs >= 1 then first = time; end when;
  when downs >= 2 then two = pre(two) + 1; end when;
  when downs > 2 then more = pre(more) + 1; end when;
  when n >= 3 then third = time; end when;
  when sample(0.25, 1) then ticks = pre(ticks) + 1; end when;
  when ticks >= 3 then ticked = time; end when;
  when time >= 3 then mark = 7; end when;
  when sample(0, 1) then shown = mark; end when;
  when shown > 5 then seen = time; end when;
  annotation(experiment(StopTime = 9.9));
end Counts;
"""


@pytest.mark.parametrize("version", ["2", "3"])
def test_events_of_discrete_variables(tmp_path: Path, version: str) -> None:
    """Model Exchange has them where the run time has: those that read others at the same moment too."""
    file = tmp_path / "counts.lag"
    file.write_text(COUNTS, encoding="utf-8")
    (path,) = lagrangia.load(file).export_fmu(tmp_path / "counts.fmu", fmi=version)
    counted = {"n": 19, "downs": 2, "turns": 3, "two": 1, "more": 0}
    told = {"first": math.pi / 2, "last": 5 * math.pi / 2, "third": 1.5, "ticked": 2.25, "seen": 3}
    for kind in ("ModelExchange", "CoSimulation"):
        end = simulate_fmu(str(path), fmi_type=kind, stop_time=9.9, output=[*counted, *told], relative_tolerance=1e-8)[-1]
        assert {name: end[name] for name in counted} == counted, kind
        assert {name: end[name] for name in told} == pytest.approx(told, abs=1e-4), kind


OUTPUTS = """
model Outputs "A ball falls from 1 m and is stopped at 0.451... s; what changes at events alone is told so"
  Prismatic way(a = world, along = {0, 1}, s(start = 1));
  PointMass ball(m = 1, center = way.b);
  input Real u(start = 0.5);
  Integer n(start = 0);
  output Integer twice = 2*n + 1, mm = integer(floor(10*way.s/1[m])), pair[2](each start = 0);
  output Boolean deep = way.s < 0.25, done = n > 0;
  output Real sampled(start = 0), scaled = 2*sampled + n, moved = sampled + u, chosen = if done then 1 else 2;
equation
  when way.s < 0 then reinit(der(way.s), 0); n = pre(n) + 1; pair = pre(pair) + {1, 2}; end when;
  when sample(0, 0.1) then sampled = way.s/1[m]; end when;
  annotation(experiment(StopTime = 0.95));
end Outputs;
"""
KINDS = {"twice": "Integer", "mm": "Integer", "pair[1]": "Integer", "pair[2]": "Integer", "deep": "Boolean", "done": "Boolean",
         "sampled": "Real", "scaled": "Real", "chosen": "Real"}


@pytest.mark.parametrize("version", ["2", "3"])
def test_outputs_that_change_at_events_alone(tmp_path: Path, version: str) -> None:
    file = tmp_path / "outputs.lag"
    file.write_text(OUTPUTS, encoding="utf-8")
    (path,) = lagrangia.load(file).export_fmu(tmp_path / "outputs.fmu", fmi=version)
    assert not validate_fmu(str(path)) and not check_fmu(path).faults
    description = read_model_description(str(path))
    outputs = {v.name: v for v in description.modelVariables if v.causality == "output"}
    told = {name: v.type for name, v in outputs.items() if v.variability == "discrete"}
    assert told == ({**KINDS} if version == "2" else {
        name: {"Integer": "Int32", "Real": "Float64"}.get(kind, kind) for name, kind in KINDS.items()})
    assert outputs["moved"].variability == "continuous"
    kinds = {u.variable.name: set(u.dependenciesKind or ()) for u in description.outputs}
    assert all(kinds[name] <= {"dependent"} for name, kind in KINDS.items() if kind != "Real")
    reference = outputs["twice"].valueReference if version == "3" else 1 + description.modelVariables.index(outputs["twice"])
    row = rf'((index|valueReference)="{reference}"[^\n]*Kind=)"dependent"'
    wrong = described(path, tmp_path / "wrong.fmu", row, r'\1"constant"')
    assert "'twice' is no real number" in str(check_fmu(wrong).faults)
    end = simulate_fmu(str(path), fmi_type="CoSimulation", stop_time=0.95, output=[*KINDS])[-1]
    assert {name: end[name] for name, kind in KINDS.items() if kind != "Real"} == {
        "twice": 3, "mm": 0, "pair[1]": 1, "pair[2]": 2, "deep": True, "done": True}
    assert (end["sampled"], end["scaled"], end["chosen"]) == pytest.approx((0, 1, 1), abs=1e-7)


@pytest.mark.parametrize("version", ["2", "3"])
def test_whole_numbers_beyond_32_bits_are_errors(tmp_path: Path, version: str) -> None:
    """The last that there is, and one that is beyond it from x = 0.5 on."""
    model = lagrangia.loads("""
        model Large
          coordinate Length x(start = 0, fixed = true); Velocity v(start = 1, fixed = true) = der(x);
          Integer n(start = 0); output Integer last, large;
        equation
          when x > 0.5[m] then n = 1; end when;
          last = 2147483646 + n; large = 2147483647 + n;
          energy kinetic 0.5*der(x)^2;
          annotation(experiment(StopTime = 1));
        end Large;""")
    (path,) = model.export_fmu(tmp_path / "large.fmu", fmi=version, kind="cs")
    assert simulate_fmu(str(path), output=["last"])[-1]["last"] == 2147483647
    assert simulate_fmu(str(path), output=["large"], stop_time=0.4)[-1]["large"] == 2147483647
    with pytest.raises(FMICallException):
        simulate_fmu(str(path), output=["large"])
