"""Runs in lanes whose bodies turn in space: references of attitudes go with each lane's own steps."""

import numpy as np
import pytest

import lagrangia as lag
from helpers.lanes import advanced, one_by_one
from lagrangia.run.batch import Lanes
from lagrangia.run.request import Request
from lagrangia.study.sweep.measures import quantities, read_measures
from lagrangia.study.sweep.plan import Design, Job

BALLS = """model Balls
  parameter Mass m = 1;
  Spherical j(a = world, S(start = angles("zxz", 0, 0.5, 0)), w(start = {0.1, 0.2, 30}));
  Body b(m = m, I = {0.01, 0.012, 0.002}, center = shift(j.b, {0.02, 0, 0.1}));
  SECOND
  output Length height = b.center.z;
end Balls;
"""
SECOND = """Spherical k(a = shift(j.b, {0, 0.1, 0.2}), S(start = axis_angle({1, 0, 0}, 0.3)), w(start = {0.1, 0.2, 5}));
  Body c(m = 0.5, I = {0.01, 0.012, 0.002}, center = shift(k.b, {0.02, 0, 0.1}));
  Damper d(a = world, b = c.center, c = 0.2);"""
INSIDE = "final(j.S[1]), final(j.S[3]), final(j.w[2]), max(height), at(0.7, j.S[2]), time_of_max(j.w[1])"


@pytest.mark.parametrize(("second", "asked", "tolerance", "within"), [
    ("", INSIDE, 1e-9, 3e-8), ("", INSIDE, 1e-3, 0.03), (SECOND, INSIDE, 1e-9, 1e-7),
    (SECOND, "final(j.S[1]), final(k.S[3])", 1e-9, 1e-7)])
def test_attitudes_turn_in_lanes(second: str, asked: str, tolerance: float, within: float) -> None:
    """By series, by Dormand's pair and by Verner's, whose references move with each lane's own steps."""
    model = lag.loads(BALLS.replace("SECOND", second))
    measures = read_measures(asked)

    def prepared(**asked: object) -> tuple[lag.Model, Job]:
        request = Request(stop=1.0, parameters={"m": np.linspace(0.8, 1.2, 19)}, **asked)
        return model.reporting(quantities(measures)).prepared_for(measures, request, Design())

    suited, job = prepared(tolerance=tolerance)
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    assert lanes.runs == job.runs and (outcomes["kind"] == 0).all()
    other, reference = prepared(tolerance=1e-12, solver="erk")
    exact, _, none = advanced(other, one_by_one(reference), values)
    assert none == Lanes() and found == pytest.approx(exact, abs=within)
    backward = advanced(suited, job, values[::-1])[0]
    assert found.tobytes() == np.ascontiguousarray(backward[::-1]).tobytes()


def test_attitudes_do_not_depend_on_their_company() -> None:
    """Where rows inside the run stop the lanes: first slopes were worked out anew when another run came (97 of 400 differed)."""
    model = lag.loads("""model Top
      Spherical tip(a = world, S(start = axis_angle({1, 0, 0}, lean)), w(start = {0, 0, 20})); parameter Angle lean = 0.5;
      Body top(m = 0.5, I = {0.0008, 0.0009, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
      AppliedForce P(at = shift(tip.b, {0, 0, 0.1}), force = {0.01*sin(5*time), 0, 0});
      output Real a = der(tip.w[1]); output Real x = top.center.r[1];
    end Top;""")
    measures = read_measures("x, a, at(0.37, x)")
    request = Request(stop=1.0, tolerance=1e-4, parameters={"lean": np.linspace(0.4, 1.3, 100)})
    suited, job = model.reporting(quantities(measures)).prepared_for(measures, request, Design())
    values = job.variations.values(0, job.runs)
    order = np.random.default_rng(3).permutation(job.runs)
    found, _, lanes = advanced(suited, job, values)
    assert lanes.runs == job.runs and advanced(suited, job, values[order])[0].tobytes() == found[order].tobytes()


def test_attitudes_in_lanes_go_on_at_each_run_s_own_events() -> None:
    """A thrust that ends at another time in each run: references are handed over with the state."""
    model = lag.loads("""model Thrown
  parameter Time T = 0.7;
  Free f(a = world, S(start = angles("zxz", 0.3, 0.5, 0)), w(start = {0.1, 5, 2}));
  Body b(m = 1, I = {0.01, 0.012, 0.002}, center = shift(f.b, {0.02, 0, 0.1}));
  AppliedForce push(at = shift(b.center, {0.1, 0, 0}), force = {if time < T then 1.5 else 0.2, 0, 0});
end Thrown;""")
    measures = read_measures("final(f.S[1]), final(f.w[2]), max(f.x), at(0.71, f.S[2])")
    suited, job = model.reporting(quantities(measures)).prepared_for(
        measures, Request(stop=1.5, tolerance=1e-9, parameters={"T": np.linspace(0.3, 1.0, 11)}), Design())
    values = job.variations.values(0, job.runs)
    found, _, lanes = advanced(suited, job, values)
    alone, _, none = advanced(suited, one_by_one(job), values)
    assert none == Lanes() and lanes.runs == 11 and found == pytest.approx(alone, abs=2e-8)
