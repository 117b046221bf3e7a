"""Runs with events in lanes: each leaves its lane for an event, goes on alone as far as that reaches, and comes back."""

from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import lagrangia as lag
from helpers.lanes import DRIVER, advanced, one_by_one
from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.command.sweep import _in_lanes
from lagrangia.native.c_code import write_c
from lagrangia.run.batch import Lanes
from lagrangia.run.request import Request
from lagrangia.study.sweep.measures import quantities, read_measures
from lagrangia.study.sweep.plan import Design, Job

WALL = """model Wall "a pendulum that a wall at its lowest place throws back"
  Revolute hinge(a = world);
  Bar bar(m = 1, L = 1, a = hinge.b);
  Stop wall(e = 1, gap = bar.b.x);
end Wall;"""
ARM = """model Arm "a double pendulum whose tip hits a wall, and whose elbow is thrown back"
  Revolute shoulder(a = world, phi(start = 1)), elbow(a = upper.b, phi(start = 0.5));
  Bar upper(m = 1, L = 1, a = shoulder.b), lower(m = 1, L = 1, a = elbow.b);
  Stop wall(e = 0.8, gap = lower.b.x + 1.2);
  Real count(start = 0);
equation
  when elbow.phi > 0.7 then
    reinit(elbow.w, -0.5*pre(elbow.w));
    count = pre(count) + 1;
  end when;
end Arm;"""
WALLED = """model Walled "a double pendulum whose tip hits a wall"
  Revolute shoulder(a = world, phi(start = 1)), elbow(a = upper.b, phi(start = 0.5));
  Bar upper(m = 1, L = 1, a = shoulder.b), lower(m = 1, L = 1, a = elbow.b);
  Stop wall(e = 0.8, gap = lower.b.x + 1.2);
end Walled;"""
PUSHED = """model Pushed "a pendulum beside a wall, pushed the other way from 1.3 s on, and against a spring beyond a corner"
  Revolute hinge(a = world);
  Bar bar(m = 1, L = 1, a = hinge.b);
  Stop wall(e = 0.7, gap = bar.b.x + 0.1);
  AppliedTorque motor(on = bar.center, torque = if time < 1.3 then 0.8 else -0.6);
  AppliedTorque stopper(on = bar.center, torque = if bar.b.x > 0.3 then -4*(bar.b.x - 0.3) else 0);
end Pushed;"""
RUBBED = """model Rubbed "a double pendulum whose shoulder friction holds in the end"
  Revolute shoulder(a = world, phi(start = 1)), elbow(a = upper.b, phi(start = 0.5));
  Bar upper(m = 1, L = 1, a = shoulder.b), lower(m = 0.2, L = 0.3, a = elbow.b);
  TorsionDryFriction brake(tau = 1.5, a = world, b = shoulder.b);
end Rubbed;"""


def prepared(text: str, outputs: str, coordinate: str, starts: np.ndarray, **asked: object) -> tuple[lag.Model, Job]:
    measures = read_measures(outputs)
    request = Request(**{"stop": 5.0, "tolerance": 1e-8, "initial": {coordinate: starts}, **asked})
    return lag.loads(text).reporting(quantities(measures)).prepared_for(measures, request, Design())


def test_a_pendulum_thrown_back_again_and_again_is_the_free_one_folded() -> None:
    """|a| of the free one, from the lowest place: sin(a/2) = k sn(K - w t), k = sin(a(0)/2), w^2 = 3 g/(2 L)."""
    starts = np.linspace(0.3, 1.4, 29)
    suited, job = prepared(WALL, "final(hinge.phi), at(1.7, hinge.phi), max(abs(hinge.w))", "hinge.phi", starts - np.pi / 2,
                           stop=20.0)
    found, outcomes, lanes = advanced(suited, job, job.variations.values(0, job.runs))
    assert lanes.runs == job.runs and lanes.alone == 0 and (outcomes["kind"] == 0).all()
    assert lanes.left > 20 * job.runs
    k, w = np.sin(starts / 2), np.sqrt(1.5 * 9.81)
    for column, time in enumerate((20.0, 1.7)):
        exact = np.abs(2 * np.arcsin(k * ellipj(ellipk(k**2) - w * time, k**2)[0]))
        np.testing.assert_allclose(found[:, column] + np.pi / 2, exact, rtol=0, atol=1e-6)
    np.testing.assert_allclose(found[:, 2], 2 * w * k, rtol=0, atol=1e-6)


@pytest.mark.parametrize(("text", "names", "start", "stop"), [
    (ARM, ("elbow.phi", "shoulder.phi"), 0.3, 3.0), (RUBBED, ("shoulder.phi", "elbow.phi"), 0.3, 8.0),
    (PUSHED, ("hinge.phi", "bar.b.x"), -1.2, 6.0)])
def test_results_are_those_of_runs_alone(text: str, names: tuple[str, str], start: float, stop: float) -> None:
    """Against another method at a smaller tolerance."""
    starts = np.linspace(start, start + 0.3, 21)
    coordinate, other_name = names
    outputs = f"final({coordinate}), mean({other_name}), max(der({coordinate})), at(1.3, {other_name}), at(1.9, {coordinate})"
    suited, job = prepared(text, outputs, coordinate, starts, stop=stop)
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    assert lanes.runs == job.runs and lanes.left >= job.runs and (outcomes["kind"] == 0).all()
    other, reference = prepared(text, outputs, coordinate, starts, stop=stop, tolerance=1e-11, solver="erk")
    exact, _, none = advanced(other, one_by_one(reference), values)
    alone, _, _ = advanced(suited, one_by_one(job), values)
    assert none == Lanes()
    error, error_alone = np.abs(found - exact), np.abs(alone - exact)
    assert np.median(error) < 1e-7
    assert error.max() < max(1e-7, 10 * error_alone.max())


def test_a_run_does_not_depend_on_its_company() -> None:
    """Bit by bit: in another order, and few at a time."""
    suited, job = prepared(ARM, "final(shoulder.phi), final(count), max(elbow.phi)", "elbow.phi", np.linspace(0.2, 0.65, 37))
    values = job.variations.values(0, job.runs)
    found, outcomes, lanes = advanced(suited, job, values)
    assert lanes.left > 2 * lanes.runs
    order = np.random.default_rng(5).permutation(job.runs)
    again, others, _ = advanced(suited, job, np.ascontiguousarray(values[order]))
    assert again.tobytes() == found[order].tobytes()
    assert (others["steps"] == outcomes["steps"][order]).all()
    few = np.concatenate([advanced(suited, job, values[k:k + 2])[0] for k in range(0, job.runs, 2)])
    assert few.tobytes() == found.tobytes()
    assert found[:, 1].max() >= 2


@pytest.mark.slow
@needs_sanitizers
def test_lanes_of_events_under_sanitizers(tmp_path: Path) -> None:
    suited, _ = prepared(WALLED, "final(elbow.phi), max(elbow.phi), mean(lower.b.y)", "elbow.phi", np.linspace(0.1, 1, 21))
    scene = suited.scene
    source = write_c(scene.name, scene.sizes, scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                     tuple(scene.tapes))
    left = "lag_batch_lanes(batch, counts);\n    failed |= counts[LAG_LANES_LEFT] < 5;"
    run_sanitized(tmp_path, {"driver.c": DRIVER.replace("lag_batch_lanes(batch, counts);", left), "scene.c": source})


def test_how_often_they_left_is_told() -> None:
    starts = np.linspace(-1.2, 0, 16)
    sweep = lag.loads(WALL).simulate_many(initial={"hinge.phi": starts}, outputs=["final(hinge.phi)"], stop=5.0, jobs=1)
    text = _in_lanes(sweep, sweep.runs)
    assert text.startswith("lanes: 16 of 16 runs eight at a time; ") and "they left for events" in text
