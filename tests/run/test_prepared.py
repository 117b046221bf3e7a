"""Prepared runs give the rows of `simulate`, call after call, and refuse what it refuses."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError, RunError
from lagrangia.run.prepared import PreparedRun

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
PENDULUM = lag.load(EXAMPLES / "double_pendulum.lag")


def test_each_call_gives_the_rows_of_simulate() -> None:
    names, bodies = ("shoulder.phi", "der(elbow.phi)"), ("upper.L", "lower.m")
    run = PENDULUM.prepare(dict.fromkeys(names, 0.1), dict.fromkeys(bodies, 1.0), stop=2, interval=0.1)
    for start, values in (((0.4, 1.0), (1.2, 3.0)), ((0.5, -1.0), (0.7, 0.2)), ((0.4, 1.0), (1.2, 3.0))):
        wanted = PENDULUM.simulate(stop=2, interval=0.1, initial=dict(zip(names, start, strict=True)),
                                   parameters=dict(zip(bodies, values, strict=True)))
        found = run(start, values)
        assert np.array_equal(found, wanted.rows)
        assert np.array_equal(found[:, run.columns.index("H")], wanted.energy.total)
        assert run.statistics.steps == wanted.statistics.steps
        assert run.warnings == []


def test_all_else_is_as_it_was_given_once() -> None:
    """Starts that are not named are those of the scene; loops are closed anew."""
    model = lag.load(EXAMPLES / "four_bar.lag")
    name = model.coordinate_names[0]
    start = float(model.simulate(stop=0.1).rows[0, 1])
    run = model.prepare({name: start}, stop=0.5, at=[0.25, 0.5], solver="erk")
    for value in (start, start + 0.02, start):
        wanted = model.simulate(stop=0.5, at=[0.25, 0.5], solver="erk", initial={name: value})
        assert np.array_equal(run([value]), wanted.rows)
    assert model.prepare(stop=0.5, at=[0.5])().shape == (1, len(run.columns))


def test_starts_are_found_anew_where_anything_is_asked_otherwise() -> None:
    """The latest one is kept: with another length, from another guess, after one that does not close, it is not the start."""
    model = lag.load(EXAMPLES / "four_bar.lag")

    def prepared() -> PreparedRun:
        return model.prepare({"O.phi": 0.5}, {"coupler.L": 1.0}, at=[0, 0.1], tolerance=1e-10)

    run = prepared()
    for start, length in ((0.7, 1), (0.7, 1), (0.8, 1), (0.8, 1.1), (0.8, 9), (0.8, 1.1), (0.8, 1.1), (0.7, 1)):
        if length == 9:
            with pytest.raises(LagError, match="L0606"):
                run([start], [length])
            continue
        rows = run([start], [length])
        assert np.array_equal(rows, prepared()([start], [length]))
        assert rows[0, run.columns.index("O.phi")] == pytest.approx(start, abs=1e-15)
        assert run.statistics.constraint_residual < 1e-14


@pytest.mark.parametrize(("scene", "mass"), [("four_bar", "coupler.m"), ("spatial_four_bar", "rod.m")])
def test_masses_far_apart_get_formulas_that_bear_them(scene: str, mass: str) -> None:
    """And those of one kind have in space the shorter ones of `simulate`, before and after."""
    model = lag.load(EXAMPLES / f"{scene}.lag")
    asked = {"stop": 0.2, "at": [0.1, 0.2], "tolerance": 1e-9}
    run = model.prepare(parameters={mass: 1.0}, **asked)
    steps = []
    for value in (0.5, 1e-12, 0.7, 0.0, 1e9, 0.5):
        wanted = model.simulate(parameters={mass: value}, **asked)
        found = run((), [value])
        for name in (c.name for c in wanted.scene.coordinates if c.name not in wanted.scene.turned):
            assert found[:, run.columns.index(name)] == pytest.approx(wanted[name], rel=1e-7, abs=1e-7), (name, value)
        assert run.warnings == []
        steps.append(run.statistics.steps)
    assert (run.scene.unevenness is None) == (scene == "four_bar") and steps[0] == steps[-1]


def test_what_bears_any_masses_is_made_when_masses_are_uneven(monkeypatch: pytest.MonkeyPatch) -> None:
    """Weights never ask for it; what masses are made of does. The latest run is told of, by whichever formulas it was made."""
    monkeypatch.setattr("lagrangia.run.formulas._SHORT", 0)
    text = (EXAMPLES / "pantograph.lag").read_text(encoding="utf-8").replace("Bar inner(m = 1", "Bar inner(m = own")
    model = lag.loads(text.replace("  Revolute", "  parameter Mass own = 1;\n  Revolute", 1))
    run = model.prepare(parameters={"world.gravity[2]": -1.0}, stop=0.5, at=[0.25, 0.5])
    assert np.array_equal(run((), [-5.0]), model.simulate(stop=0.5, at=[0.25, 0.5], parameters={"world.gravity[2]": -5.0}).rows)
    again = model.prepare(parameters={"own": 1.0}, stop=0.5, at=[0.25, 0.5])
    for own, close in ((0.9, 0.0), (1e-12, 1e-6), (0.9, 0.0)):
        wanted = model.simulate(stop=0.5, at=[0.25, 0.5], parameters={"own": own})
        assert again((), [own]) == pytest.approx(wanted.rows, rel=close, abs=close)
        assert again.statistics.rhs_evaluations == wanted.statistics.rhs_evaluations


@pytest.mark.parametrize(("start", "values", "told"), [
    ([np.nan], [1.0], "initial value of 'shoulder.phi' must be a finite number"),
    ([0.1], [-1.0], "'upper.L' is -1 m, less than its minimum"),
    ([0.1], [np.inf], "'upper.L' has no finite value"),
    ([0.1], [], "1 start values and 1 parameters are needed, not 1 and 0"),
])
def test_wrong_values_are_refused_and_the_next_call_runs(start: list[float], values: list[float], told: str) -> None:
    run = PENDULUM.prepare({"shoulder.phi": 0.1}, {"upper.L": 1.0}, stop=0.1)
    with pytest.raises(LagError, match=told):
        run(start, values)
    assert np.array_equal(run([0.2], [1.5]), PENDULUM.simulate(stop=0.1, initial={"shoulder.phi": 0.2},
                                                               parameters={"upper.L": 1.5}).rows)


def test_wrong_names_are_refused_at_once_and_a_run_that_ends_early_says_why() -> None:
    with pytest.raises(LagError, match=r"no parameter 'upper\.k'"):
        PENDULUM.prepare(parameters={"upper.k": 1.0})
    with pytest.raises(RunError, match="limit of steps"):
        PENDULUM.prepare(stop=100, max_steps=3)()


def test_parameters_are_asked_for_what_they_enter() -> None:
    """Limits of all, and the requirements that a parameter enters: no other can be missed."""
    model = lag.loads("""model M
      World world(gravity = {0, 0, -9.81});
      parameter Real axis[3] = {0, 1, 0.2};
      parameter Length d(min = 0.1) = 0.5;
      Revolute joint(a = world, axis = axis, phi(start = 0.3));
      Body body(m = 1, I = {1, 1, 1}, center = shift(joint.b, {d, 0, 0}));
    end M;""")
    for names, values, said in ((["d"], [0.05], "less than its minimum"), (["d"], [np.nan], "no finite value"),
                                (["axis[2]", "axis[3]"], [0, 0], "has no length")):
        run = model.prepare(parameters=dict.fromkeys(names, 1.0), at=[0, 0.1])
        with pytest.raises(LagError, match=f"L0605.*{said}"):
            run([], values)
        assert run([], [0.5] * len(names)).shape[0] == 2
