"""Runs in lanes by Runge-Kutta pairs that are asked for by name: the steps of runs alone, the same in any company."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.batch import Batch, Lanes
from lagrangia.run.request import Request
from lagrangia.study.sweep.measures import read_measures
from lagrangia.study.sweep.plan import Design

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
PAIRS = ("erk", "erk5", "erk9")
NARROW = """model Narrow "Too long for series; what pushes is 1e-4 rad wide"
  parameter Integer n = 3; parameter Real w = 1e-4;
  Revolute hinge[n](phi(each start = 0.6)); Bar link[n](each m = 1, each L = 0.5);
  AppliedTorque push(on = link[1].center, torque = 2e4*exp(-((hinge[1].phi - 0.1)/w)^2));
equation
  connect(world, hinge[1].a);
  for i in 1:n loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:n-1 loop connect(link[i].b, hinge[i+1].a); end for;
end Narrow;
"""


def advanced(model: lag.Model, outputs: str, initial: Mapping[str, np.ndarray], in_lanes: bool = True,
             some: slice = slice(None), **asked: object) -> tuple[np.ndarray, np.ndarray, Lanes]:
    """Results, steps and lanes of `some` runs."""
    request = Request(**{"stop": 2.0, "tolerance": 1e-8, "initial": initial, **asked})
    suited, job = model.prepared_for(read_measures(outputs), request, Design())
    engine = suited.engine_for(request.solver)
    assert engine is not None
    with Batch(engine.runtime, engine.model, replace(job.sweep, in_lanes=in_lanes)) as batch:
        results, outcomes, _ = batch.advance(job.variations.values(0, job.runs)[some])
        return results, outcomes["steps"], batch.lanes


@pytest.mark.parametrize("outputs", ["final(elbow.phi)", "final(elbow.phi), max(elbow.phi), at(0.7, der(elbow.phi))"])
@pytest.mark.parametrize("solver", PAIRS)
def test_runs_are_those_that_are_made_alone(solver: str, outputs: str) -> None:
    model, starts = lag.load(EXAMPLES / "double_pendulum.lag"), {"elbow.phi": np.linspace(0.1, 1, 21)}
    found, steps, lanes = advanced(model, outputs, starts, solver=solver)
    alone, others, none = advanced(model, outputs, starts, in_lanes=False, solver=solver)
    assert (lanes.runs, lanes.alone, none) == (21, 0, Lanes())
    assert found == pytest.approx(alone, abs=2e-9 if solver == "erk9" else 1e-11)
    assert abs(steps - others).max() <= 2
    for k in (0, 8, 20):  # the last one beside nobody
        assert advanced(model, outputs, starts, some=slice(k, k + 1), solver=solver)[0].tobytes() == found[k : k + 1].tobytes()


@pytest.mark.parametrize("solver", PAIRS)
def test_ends_are_those_of_scipy(solver: str) -> None:
    starts = np.linspace(0.5, 3.0, 9)
    model = lag.load(EXAMPLES / "pendulum.lag")
    found = advanced(model, "final(hinge.phi)", {"hinge.phi": starts}, solver=solver, tolerance=1e-10)
    rhs, p = model.functions()["rhs"], model.parameter_values()
    ends = [solve_ivp(lambda t, y: [y[1], float(rhs(t, [y[0]], [y[1]], [], p))], (0, 2), [start, 0], "DOP853", rtol=1e-12,
                      atol=1e-12).y[0, -1] for start in starts]
    assert found[2].runs == 9 and found[0][:, 0] == pytest.approx(ends, abs=2e-9)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("solver", PAIRS)
def test_compiled_and_interpreted_ones_have_the_same_digits(solver: str) -> None:
    found = []
    for native in (False, True):
        model = lag.load(EXAMPLES / "double_pendulum.lag")
        model.native = native
        found.append(advanced(model, "final(elbow.phi)", {"elbow.phi": np.linspace(0.1, 1, 9)}, solver=solver))
    assert found[0][0].tobytes() == found[1][0].tobytes() and found[0][2] == found[1][2]


@pytest.mark.parametrize("solver", ["auto", *PAIRS])
def test_narrow_forces_are_not_passed_over(solver: str) -> None:
    """Steps alone look for them: runs in lanes went on as if there were none, 0.63 rad off."""
    model, starts = lag.loads(NARROW), {"hinge[1].phi": np.linspace(0.55, 0.65, 9)}
    found = advanced(model, "final(hinge[1].phi)", starts, solver=solver, stop=1.0)[0]
    alone = advanced(model, "final(hinge[1].phi)", starts, False, solver=solver, stop=1.0)[0]
    free = advanced(lag.loads(NARROW.replace("2e4*", "0*")), "final(hinge[1].phi)", starts, False, solver=solver, stop=1.0)[0]
    assert found == pytest.approx(alone, abs=1e-6)
    assert abs(found - free).min() > 0.05


def test_other_methods_are_made_alone() -> None:
    starts = {"elbow.phi": np.linspace(0.1, 1, 9)}
    assert advanced(lag.load(EXAMPLES / "double_pendulum.lag"), "final(elbow.phi)", starts, solver="pirk")[2] == Lanes()


LOOPS = {"four_bar": ("O.phi", np.linspace(0.5, 0.7, 11)), "slider_crank": ("O.phi", np.linspace(0.2, 1.2, 11))}


@pytest.mark.parametrize("solver", PAIRS)
@pytest.mark.parametrize("name", LOOPS)
def test_loops_are_projected_as_alone(name: str, solver: str) -> None:
    model, (angle, starts) = lag.load(EXAMPLES / f"{name}.lag"), LOOPS[name]
    outputs = f"final({angle}), max({angle}), at(0.3, der({angle}))"
    found, steps, lanes = advanced(model, outputs, {angle: starts}, solver=solver, stop=1.0)
    alone, others, _ = advanced(model, outputs, {angle: starts}, False, solver=solver, stop=1.0)
    assert (lanes.runs, lanes.alone) == (11, 0)
    assert found == pytest.approx(alone, rel=1e-8 if solver == "erk9" else 1e-10)
    assert abs(steps / others - 1).max() < 0.05
    for some in (slice(0, 1), slice(7, 11)):
        assert advanced(model, outputs, {angle: starts}, some=some, solver=solver, stop=1.0)[0].tobytes() == found[some].tobytes()


@pytest.mark.parametrize("solver", PAIRS)
def test_loops_stay_closed_in_lanes(solver: str) -> None:
    """Rows at and inside steps, by the four-bar's own equations."""
    many = lag.load(EXAMPLES / "four_bar.lag").simulate_many(
        initial={"O.phi": np.linspace(0.5, 0.7, 11)}, stop=2.0, interval=0.1, keep=True, tolerance=1e-6, solver=solver)
    crank, elbow, rocker = np.moveaxis(many.trajectories[..., 1:4], -1, 0)
    gap = 0.4*np.exp(1j*crank) + np.exp(1j*(crank + elbow)) - 1 - 0.8*np.exp(1j*rocker)
    assert many.ledger.lanes.runs == 11 and gap.shape == (11, 21)
    assert abs(gap).max() < 1e-14
