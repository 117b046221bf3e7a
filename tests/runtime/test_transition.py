"""Transition matrices in doubles, which `auto` takes for linear scenes of few states, and when it goes on otherwise."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.request import check_values
from lagrangia.run.runtime import Run, Settings, Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"

LOADS = {
    "none": "0", "constant": "2", "sine": "sin(3*time/1[s])", "ramp": "0.3*time/1[s] - 1",
    "decay": "exp(-0.5*time/1[s])*cos(time/1[s])",
    "pieces": "if time < 0.7 then 1 else if time < 2.9 then cos(2*time/1[s]) else 0.2*time/1[s]",
    "input": "u",
}


def row(n: int, load: str = "0", c: float = 0.1, k: float = 4.0) -> str:
    """n masses, held on the left, pushed on the right."""
    lines = [f"parameter Stiffness k = {k}; parameter Damping c = {c}; input Real u = 0.5;", "World world(gravity = {0, -9.81});"]
    for i in range(n):
        before = f"b{i - 1}.s" if i else "0"
        lines += [f"Block b{i}(m = {1 + i}, base = world, along = {{0, 1}}, s(start = {0.3 * i}), v(start = {1 - i}));",
                  f"SpringDamper s{i}(k = k, c = c, stretch = b{i}.s - {before});"]
    return "\n".join(["model Row", *lines, f"AppliedForce F(at = b{n - 1}.center, force = {{0, 1}}*({load})*1[N]);", "end Row;"])


def both(model: lag.Model, tolerance: float = 1e-8, **how: Any) -> tuple[lag.Trajectory, lag.Trajectory, float]:
    """By `auto` and by `linear`, and how far positions and rates are apart."""
    runs = [model.simulate(solver=solver, tolerance=tolerance, **how) for solver in ("auto", "linear")]
    a, b = (run.rows[:, 1 : 1 + 2 * model.scene.n] for run in runs)
    return runs[0], runs[1], float(np.abs(a - b).max() / np.abs(b).max())


@pytest.mark.parametrize("n", [1, 2, 4])
@pytest.mark.parametrize("load", LOADS)
def test_digits_do_not_depend_on_the_tolerance(n: int, load: str, scene: Write) -> None:
    model = scene(row(min(n, 3) if load == "pieces" else n, LOADS[load]))  # 6 states of loads, with that of the weights
    for at in (np.linspace(0, 5, 11), np.sort(np.random.default_rng(n).uniform(0, 5, 40)), [5.0]):
        for tolerance in (1e-3, 1e-8, 1e-12):
            run, exact, error = both(model, tolerance, at=at)
            assert run.statistics.solver is Solver.LINEAR
            assert error < 3e-14
            assert run.statistics.rhs_evaluations < 10 + 2 * run.statistics.events
            rounding = 1e-13 * run.statistics.energy_size
            assert run.statistics.energy_residual < rounding
            for part in ("dissipated", "work"):
                assert getattr(run.energy, part) == pytest.approx(getattr(exact.energy, part), abs=rounding)


def test_a_table_of_inputs(scene: Write) -> None:
    model = scene(row(2, "u"))
    times = np.array([0, 0.4, 1.1, 1.1, 3.0])
    inputs = (times, {"u": np.array([0.0, 2.0, 1.0, -1.0, 0.5])})
    run, _, error = both(model, at=np.linspace(0, 5, 101), inputs=inputs)
    assert error < 1e-14
    assert run.statistics.energy_residual < 1e-13 * run.statistics.energy_size


def test_what_is_too_long_or_too_stiff_for_doubles(scene: Write) -> None:
    """A free mass beside a stiff spring: rounding of what is stiff would move it. It goes on as other scenes do."""
    model = scene(row(2, "0", 0.0))
    for stop, tolerance, is_linear in ((10, 1e-6, True), (1e3, 1e-6, True), (1e3, 1e-13, False), (1e4, 1e-12, False)):
        run = model.simulate(stop=stop, interval=stop / 4, tolerance=tolerance)
        assert (run.statistics.solver is Solver.LINEAR) is is_linear
    stiff = scene(row(2, "0", 0.0, 1e9))
    _, _, error = both(stiff, 1e-9, stop=2)
    assert error < 1e-9


def started(model: lag.Model, stop: float, tolerance: float = 1e-8, parameters: dict[str, float] | None = None) -> Run:
    engine = model.engine
    assert engine is not None
    values = check_values(model.scene, parameters)
    run = engine.runtime.run(engine.model, Settings(0, stop, tolerance=tolerance))
    run.set_parameters(values.parameters, values.mask)
    assert run.start(values.q, values.v) is Status.OK
    return run


def test_it_goes_on_otherwise_when_parameters_or_the_stop_change(scene: Write) -> None:
    model = scene(row(2, "sin(3*time/1[s])"))
    stiff = check_values(model.scene, {"k": 1e9})
    with started(model, 2.0) as run, started(model, 2.0) as other:
        assert run.advance([1.0]).status is Status.OK
        assert run.statistics.solver is Solver.LINEAR
        run.set_parameters(stiff.parameters, stiff.mask)
        assert run.advance([1.5]).status is Status.OK
        assert run.statistics.solver is not Solver.LINEAR
        assert other.advance([1.0]).status is Status.OK
        other.set_stop(1e6)
        rows = other.advance([2.0, 3.0])
        assert rows.status is Status.OK
        assert other.statistics.solver is Solver.LINEAR
        assert other.advance([1e5], 0.2).status in (Status.OK, Status.PAUSED)
        assert other.statistics.solver is not Solver.LINEAR
    exact = model.simulate(at=[2.0, 3.0], solver="linear")
    assert np.array(rows.values).reshape(2, -1)[:, 1:5] == pytest.approx(exact.rows[:, 1:5], abs=1e-13)


def test_a_run_that_begins_again_gives_the_same_digits(scene: Write) -> None:
    """Matrices are kept; those for rows at other distances, and of other parameters, are not."""
    model = scene(row(3, LOADS["pieces"]))
    at = np.linspace(0, 4, 9)
    fresh = started(model, 4.0).advance(at).values
    values = check_values(model.scene)
    with started(model, 4.0, parameters={"k": 7.0}) as run:
        run.advance([0.1, 0.2, 0.3, 0.4, 0.5, 1.7])
        run.set_parameters(values.parameters, values.mask)
        assert run.start(values.q, values.v) is Status.OK
        assert np.array(run.advance(at).values) == pytest.approx(np.array(fresh), abs=1e-13)
    times = np.array([0.1, 0.37, 0.9, 1.5, 2.1, 2.7, 3.3, 3.9])
    uneven = started(model, 4.0).advance(times).values
    with started(model, 4.0) as run:
        for _ in range(3):
            assert run.start(values.q, values.v) is Status.OK
            assert list(run.advance(at).values) == list(fresh)
            assert run.start(values.q, values.v) is Status.OK
            assert list(run.advance(times).values) == list(uneven)


def test_rows_inside_a_step_and_steps_of_all_lengths(scene: Write) -> None:
    model = scene(row(2, LOADS["sine"]))
    times = np.cumsum([1e-12, 1e-12, 1e-12, 1e-12, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 1e-3, 2.0])
    _, _, error = both(model, at=times)
    assert error < 1e-14
    with started(model, 4.0) as run:
        assert run.advance([3.0]).status is Status.OK
        inside = run.advance([0.2, 0.9, 2.9]) if run.time == 3.0 else None
    exact = model.simulate(at=[0.2, 0.9, 2.9], solver="linear")
    assert inside is not None and inside.status is Status.OK
    assert np.array(inside.values).reshape(3, -1)[:, 1:5] == pytest.approx(exact.rows[:, 1:5], abs=1e-13)


def test_many_equal_rows_do_not_lag_behind(scene: Write) -> None:
    """k/10 s is not k times 1/10 s in doubles: 100 000 roundings would add up."""
    model = scene(row(1, "0", 0.0))
    _, _, error = both(model, 1e-6, at=np.arange(1, 20001) / 10)
    assert error < 1e-11


def test_loads_share_states_under_the_same_conditions() -> None:
    """The road's height and its rate: 1, cosine and sine while the car is on the bump."""
    model = lag.load(EXAMPLES / "quarter_car.lag")
    assert model.scene.patterns["linear_pattern"][0] == 3
    run, _, error = both(model, at=np.linspace(0, 3, 61))
    assert run.statistics.solver is Solver.LINEAR
    assert error < 1e-13
    by_steps = model.simulate(at=np.linspace(0, 3, 61), solver="erk", tolerance=1e-13)
    assert run["car.s"] == pytest.approx(by_steps["car.s"], abs=1e-13)
    assert run.energy.work == pytest.approx(by_steps.energy.work, abs=1e-10)


@pytest.mark.parametrize("engine", ["native", "tape"])
def test_on_tapes_too(engine: str, scene: Write, tmp_path: Path) -> None:
    model = scene(row(4, LOADS["decay"]))
    model.native = engine == "native"
    run, _, error = both(model, at=np.linspace(0, 3, 7))
    assert run.statistics.solver is Solver.LINEAR
    assert error < 1e-14


def test_masses_that_are_no_masses(scene: Write) -> None:
    """A negative one gains energy as it moves: told, as is what does not move."""
    model = scene("""
model Odd
  parameter Real m = 1; coordinate Real x(start = 1);
energy
  kinetic m*der(x)^2/2; potential x^2/2;
end Odd;""")
    with pytest.raises(lag.RunError, match="a kinetic energy that is negative"):
        model.simulate(at=[1.0], tolerance=1e-12, parameters={"m": -1.0})
    with pytest.raises(lag.RunError):
        model.simulate(at=[1.0], parameters={"m": 0.0})
