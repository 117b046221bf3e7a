"""`nearest`, both corrections onto the constraints in one function, beside the functions that it stands for."""

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from lagrangia.compile.pipeline import compile_file
from lagrangia.native.build import find_compiler
from lagrangia.run.engines import load_engine
from lagrangia.run.request import Request, check_values, plan
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import start_run

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
LOOPS = {"four_bar": {}, "slider_crank": {}, "andrews_squeezer": {}, "n_four_bars": {"n": 3}}
loops = pytest.mark.parametrize(("file", "structural"), LOOPS.items())


def states(file: str, structural: Mapping[str, int]) -> tuple[Mapping[str, ca.Function], list, list, list]:
    """The compiled functions, what else they take, and a state on the constraints and one beside it, q and v each."""
    compilation = compile_file(EXAMPLES / f"{file}.lag", structural=structural)
    scene, table = compilation.scene, compilation.functions.table
    model = lag.load(EXAMPLES / f"{file}.lag", **structural)
    time = 0.4 * plan(scene).stop
    run = model.simulate(at=[time], tolerance=1e-12)
    closed = [np.array([run[c.name][-1] for c in columns]) for columns in (scene.coordinates, scene.rates)]
    beside = [x * (1 + 1e-5 * np.cos(1.0 + np.arange(scene.n))) for x in closed]
    p = model.parameter_values()
    rest = [ca.DM.zeros(len(scene.inputs)), table["modes"](time, p, 0) if "modes" in table else ca.DM(0, 1), table["hoist"](p)]
    return table, [time, *rest], closed, beside


@loops
def test_it_is_place_then_steer(file: str, structural: Mapping[str, int]) -> None:
    table, (time, *rest), _, (q, v) = states(file, structural)
    dq, dv, *_, doubt = (x.full().ravel() for x in table["nearest"](time, q, v, *rest))
    assert doubt == 0
    assert dq == pytest.approx(table["place"](time, q, *rest).full().ravel(), rel=1e-6, abs=1e-12)
    there = table["steer"](time, q + dq, v, *rest).full().ravel()
    assert dv == pytest.approx(there, abs=1e-3 * np.abs(there).max())  # the metric is that of a state 1e-5 away


@loops
def test_what_it_tells_is_that_of_the_corrected_state(file: str, structural: Mapping[str, int]) -> None:
    table, (time, *rest), _, (q, v) = states(file, structural)
    dq, dv, phi, rate, energies, _ = (x.full().ravel() for x in table["nearest"](time, q, v, *rest))
    expected = [x.full().ravel() for x in table["residual"](time, q + dq, v + dv, *rest)]
    before = [np.abs(x.full()).max() for x in table["residual"](time, q, v, *rest)]
    for found, right, size in zip((phi, rate), expected, before, strict=True):
        assert found == pytest.approx(right, abs=1e-9 * size)
        assert np.abs(found).max() < 1e-3 * size
    assert energies == pytest.approx(table["energies"](time, q + dq, v + dv, *rest).full().ravel(), rel=1e-12)


@loops
def test_a_closed_state_is_left_alone(file: str, structural: Mapping[str, int]) -> None:
    table, (time, *rest), (q, v), _ = states(file, structural)
    dq, dv, *_ = (x.full().ravel() for x in table["nearest"](time, q, v, *rest))
    assert np.abs(dq).max() < 1e-14 * max(1, np.abs(q).max())
    assert np.abs(dv).max() < 1e-13 * np.abs(v).max()


def rows(scene: Scene, tolerance: float) -> tuple[np.ndarray, float, float]:
    """100 rows, and the residuals of positions and rates."""
    experiment = plan(scene, Request(stop=0.2 * plan(scene).stop, tolerance=tolerance))
    engine = load_engine(scene, native=False)
    assert engine is not None
    with start_run(scene, engine, experiment, check_values(scene)) as run:
        found = run.advance([experiment.stop * k / 100 for k in range(1, 101)])
        told = run.statistics
        return np.asarray(found.values).reshape(100, -1), told.constraint_residual, told.constraint_rate_residual


@pytest.mark.parametrize("tolerance", [1e-2, 1e-5, 1e-9])
@loops
def test_rows_are_those_of_runs_without_it(file: str, structural: Mapping[str, int], tolerance: float) -> None:
    """The account and the residuals, too. The runs differ by what steps leave to the constraints, a thousandth of their error."""
    scene = compile_file(EXAMPLES / f"{file}.lag", structural=structural).scene
    without = replace(scene, tapes={name: tape for name, tape in scene.tapes.items() if name != "nearest"})
    assert "nearest" in scene.tapes
    found, expected = (rows(each, tolerance) for each in (scene, without))
    size = np.abs(expected[0]).max(axis=0)
    assert (np.abs(found[0] - expected[0]) <= (1e-4 * tolerance + 1e-9) * size).all()
    assert found[1] < 2 * max(expected[1], 1e-15)
    assert found[2] < 2 * max(expected[2], 1e-14 * size.max())
