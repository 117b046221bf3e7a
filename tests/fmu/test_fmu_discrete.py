"""Discrete variables in FMUs: of the types that they have in the model, changed at events alone."""

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
