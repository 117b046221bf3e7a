"""Large scenes get the matrix of implicit steps when a run asks for it."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.run.engines import load_engine
from lagrangia.run.request import check_values, plan
from lagrangia.run.runtime import Status
from lagrangia.run.simulate import start_run

N = 31  # one more than are compiled with their matrix
CREEPING = f"""
model Creeping
  parameter Damping c = 2000;
  Revolute hinge[{N}]; Bar link[{N}](each m = 1, each L = 0.5);
equation
  connect(world, hinge[1].a);
  for i in 1:{N} loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:{N - 1} loop connect(link[i].b, hinge[i+1].a); end for;
energy
  dissipation sum(c*1[m2]*der(hinge[i].phi)^2/2 for i in 1:{N});
initial equation
  hinge[1].phi = 1;
  annotation(experiment(StopTime = 1, Tolerance = 1e-6));
end Creeping;
"""


@pytest.fixture
def path(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path / "cache"))
    found = tmp_path / "creeping.lag"
    found.write_text(CREEPING, encoding="utf-8")
    return found


def matrices(model: lag.Model) -> set[str]:
    return {"jacobian", "tangent"} & model.scene.tapes.keys()


def test_a_run_of_explicit_steps_makes_none(path: Path) -> None:
    model = lag.load(path)
    model.simulate(parameters={"c": 0.1}, stop=0.05)
    model.simulate(solver="erk", stop=0.001)
    assert not matrices(model) and "implicit" not in model.scene.refused
    assert not matrices(lag.load(path))


def test_a_run_that_goes_over_to_implicit_steps_has_the_rows_it_has_with_the_matrix_there(path: Path) -> None:
    model = lag.load(path)
    first = model.simulate()
    statistics = first.progress.statistics
    assert statistics is not None and statistics.jacobians > 0
    assert matrices(model) == {"tangent"}
    again = lag.load(path)
    assert again.is_cached and matrices(again) == {"tangent"}
    assert np.array_equal(first.rows, again.simulate().rows)
    assert first.progress.rows == len(first.rows) == 501


def test_the_run_time_says_that_it_wants_one(path: Path) -> None:
    scene = lag.load(path).scene
    engine = load_engine(scene, native=False)
    assert engine is not None
    with start_run(scene, engine, plan(scene), check_values(scene)) as run:
        rows = run.advance([0.002 * k for k in range(501)])
        assert rows.status is Status.WANTS_JACOBIAN and 0 < rows.count < 501


def test_who_may_need_it_at_any_time_has_it_made_first(path: Path) -> None:
    named, prepared, swept = (lag.load(path) for _ in range(3))
    assert not matrices(swept)
    swept.simulate_many(parameters={"c": [1.0, 3000.0]}, stop=0.01, jobs=1)
    assert matrices(swept)
    assert not matrices(named)
    named.simulate(solver="implicit", stop=0.01)
    assert matrices(named)
    prepared.prepare(stop=0.01)
    assert matrices(prepared)


def test_momenta_of_large_scenes_wait_for_conservative_steps(path: Path) -> None:
    path.write_text(CREEPING.replace(f"energy\n  dissipation sum(c*1[m2]*der(hinge[i].phi)^2/2 for i in 1:{N});", ""),
                    encoding="utf-8")
    model = lag.load(path)
    assert "velocity" not in model.scene.tapes and not model.scene.sizes["is_separable"]
    run = model.simulate(solver="conservative", stop=0.01, max_step=0.001)
    assert "velocity" in model.scene.tapes
    assert run["hinge[1].phi"][-1] == pytest.approx(lag.load(path).simulate(stop=0.01)["hinge[1].phi"][-1], rel=1e-4)
