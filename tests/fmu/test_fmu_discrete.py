"""Discrete variables in FMUs: of the types that they have in the model, changed at events alone."""

import math
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

import lagrangia
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
  Integer ticks(start = 0);
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
    told = {"first": math.pi / 2, "last": 5 * math.pi / 2, "third": 1.5, "ticked": 2.25}
    for kind in ("ModelExchange", "CoSimulation"):
        end = simulate_fmu(str(path), fmi_type=kind, stop_time=9.9, output=[*counted, *told], relative_tolerance=1e-8)[-1]
        assert {name: end[name] for name in counted} == counted, kind
        assert {name: end[name] for name in told} == pytest.approx(told, abs=1e-4), kind
