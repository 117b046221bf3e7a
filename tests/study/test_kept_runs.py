"""Whole trajectories of the runs of a sweep: those of single runs, in memory and in files, after a kill too."""

import shutil
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import main
from lagrangia.native.build import find_compiler
from lagrangia.run.batch import Batch
from study.test_sweep import EXPLOSION

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"


def test_they_are_those_of_single_runs() -> None:
    model = lag.load(EXAMPLES / "quarter_car.lag")
    sweep = model.simulate_many(parameters={"m1": [1, 2.5, 40]}, outputs=["max(car.s)"], interval=0.01, keep=True)
    for k, m in enumerate((1, 2.5, 40)):
        alone = model.simulate(parameters={"m1": m}, interval=0.01)
        np.testing.assert_allclose(sweep.trajectories[k], alone.rows[:, : len(alone.names)], rtol=0, atol=1e-8)
        assert sweep["max(car.s)"][k] >= alone["car.s"].max() - 1e-12
    found = pytest.importorskip("xarray") and sweep.to_xarray()
    assert found["car.s"].dims == ("run", "time") and found["car.s"].attrs["units"] == "m"
    assert found["m1"].values.tolist() == [1, 2.5, 40] and found.sizes == {"run": 3, "time": 301}
    with pytest.raises(LagError, match="were not kept"):
        model.simulate_many(parameters={"m1": [1]}).trajectories.sum()


def test_runs_that_fail_keep_what_they_came_to(tmp_path: Path) -> None:
    (tmp_path / "a.lag").write_text(EXPLOSION)
    model = lag.load(tmp_path / "a.lag")
    sweep = model.simulate_many(initial={"v": [2, -2]}, interval=0.1, keep=True)
    assert list(sweep.failures) == [0]
    assert np.isfinite(sweep.trajectories[0, :10]).all() and np.isnan(sweep.trajectories[0, 11:]).all()
    assert sweep.trajectories[0, 5, 1] == pytest.approx(4, rel=1e-6) and np.isfinite(sweep.trajectories[1]).all()
    with pytest.raises(LagError, match="GB of memory"):
        model.simulate_many(initial={"v": np.linspace(-2, -1, 1000)}, interval=1e-6, keep=True)
    with pytest.raises(LagError, match="not supported yet"):
        model.simulate_many(initial={"v": [-2]}, keep=True, path=tmp_path / "x.csv")


def test_files_of_an_interrupted_sweep_are_gone_on_with(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                        capsys: pytest.CaptureFixture[str]) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    monkeypatch.chdir(tmp_path)
    shutil.copy(EXAMPLES / "pendulum.lag", "p.lag")
    command = ["sweep", "p.lag", "-p", "m=1:40:1", "--keep", "--interval", "0.5", "--jobs", "1", "-o", "x.csv"]
    whole, count = Batch.advance, [0]

    def cut(batch: Batch, *given: object) -> object:
        count[0] += 1
        if count[0] == 2:
            raise KeyboardInterrupt
        return whole(batch, *given)

    with monkeypatch.context() as patch:
        patch.setattr(Batch, "advance", cut)
        assert main(command) == 130
    left = list(Path("x_runs").iterdir())
    assert left and Path("x.csv.part").exists()
    (tmp_path / "x_runs" / "part-30-4.parquet").write_bytes(b"of runs that were lost with a killed sweep")
    assert main(command) == 0
    assert "rows of each run in x_runs" in capsys.readouterr().out
    table = parquet.read_table("x_runs").to_pandas()
    assert sorted(table["run"].unique()) == list(range(40)) and len(table) == 40 * len(table["time"].unique())
    alone = lag.load("p.lag").simulate(interval=0.5, parameters={"m": 8})
    assert table[table["run"] == 7]["hinge.phi"].tolist() == pytest.approx(alone["hinge.phi"].tolist(), abs=1e-7)
    Path("x_runs/other.txt").write_text("mine")
    assert main(command) == 2 and Path("x_runs/other.txt").exists()
    assert main([*command[:-1], "-"]) == 2
