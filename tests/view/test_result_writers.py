"""Results in files of all kinds, read back by who reads them: the same numbers, units, descriptions."""

import csv
import json
import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import main

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"


@pytest.fixture(scope="module")
def run() -> lag.Trajectory:
    return lag.load(EXAMPLES / "quarter_car.lag").simulate(stop=1.0)


def shown(run: lag.Trajectory) -> np.ndarray:
    return run.rows[:, : len(run.names)]


def test_json_lines_and_csv_hold_all_digits(run: lag.Trajectory, tmp_path: Path) -> None:
    run.write(tmp_path / "x.jsonl")
    objects = [json.loads(line) for line in (tmp_path / "x.jsonl").read_text().splitlines()]
    assert list(objects[0]) == run.names
    assert [list(row.values()) for row in objects] == shown(run).tolist()
    run.write(tmp_path / "x.csv")
    names, *rows = csv.reader((tmp_path / "x.csv").open(newline=""))
    assert names == run.names and np.array(rows, float).tolist() == shown(run).tolist()


def test_parquet_has_units_and_descriptions(run: lag.Trajectory, tmp_path: Path) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    run.write(tmp_path / "x.parquet")
    table = parquet.read_table(tmp_path / "x.parquet")
    assert table.column_names == run.names
    assert np.array([column.to_numpy() for column in table.columns]).T.tolist() == shown(run).tolist()
    fields = {field.name: field.metadata for field in table.schema}
    assert fields["car.s"] == {b"unit": b"m", b"description": b"travel along the line"}


def test_arrays_of_numpy(run: lag.Trajectory, tmp_path: Path) -> None:
    run.write(tmp_path / "x.npz")
    with np.load(tmp_path / "x.npz") as found:
        assert [*found] == ["__units__", *run.names]
        assert found["__units__"].tolist() == [column.unit for column in run.columns]
        assert all((found[name] == run[name]).all() for name in run.names)


def test_matlab_files_are_those_of_modelica(run: lag.Trajectory, tmp_path: Path) -> None:
    """Read by DyMat, and by SciPy as any file of version 4."""
    dymat, scipy_io = pytest.importorskip("DyMat"), pytest.importorskip("scipy.io")
    run.write(tmp_path / "x.mat")
    found = dymat.DyMatFile(str(tmp_path / "x.mat"))
    for name in run.names[1:]:
        assert found.data(name).tolist() == run[name].tolist()
        assert found.abscissa(name)[0].tolist() == run.time.tolist()
    assert found.description("car.s") == "travel along the line [m]"
    known = dict(zip((p.name for p in run.scene.parameters), run.progress.parameters, strict=True))
    assert found.data("m1").tolist() == [known["m1"]] * 2
    whole = scipy_io.loadmat(tmp_path / "x.mat")
    assert [line.strip() for line in whole["Aclass"]] == ["Atrajectory", "1.1", "", "binTrans"]
    assert whole["dataInfo"].shape == (4, len(run.names) + len(known))


def test_frames_know_units(run: lag.Trajectory) -> None:
    pytest.importorskip("pandas"), pytest.importorskip("xarray")
    assert run.to_pandas().attrs["units"]["car.s"] == "m"
    found = run.to_xarray()
    assert found["der(car.s)"].attrs["units"] == "m/s" and found["car.s"].dims == ("time",)
    assert found["car.s"].sel(time=1.0).item() == run["car.s"][-1]


def test_what_has_no_finite_value_is_told_in_every_kind(tmp_path: Path, capsys: pytest.CaptureFixture[str],
                                                        monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("a.lag").write_text("model A Block b(m = 1, base = world, along = {1, 0}, v(start = 1)); "
                             "output Real y = sqrt(0.5 - time); annotation(experiment(StopTime = 1)); end A;")
    for kind in ("csv", "jsonl", "parquet", "npz", "mat"):
        assert main(["simulate", "a.lag", "-o", f"x.{kind}"]) == 0
        said = capsys.readouterr().err
        assert "'y' has no finite value in 250 rows, first at t = 0.502" in said, kind


def test_a_file_that_fails_leaves_the_one_before(run: lag.Trajectory, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "x.mat").write_text("before")
    monkeypatch.setattr("lagrangia.view.result_writers._matrix", lambda *_: 1 / 0)
    with pytest.raises(ZeroDivisionError):
        run.write(tmp_path / "x.mat")
    assert [path.name for path in tmp_path.iterdir()] == ["x.mat"] and (tmp_path / "x.mat").read_text() == "before"


def test_names_that_are_no_results_are_refused(run: lag.Trajectory, tmp_path: Path) -> None:
    with pytest.raises(LagError, match="L0004"):
        run.write(tmp_path / "x.xlsx")
    assert main(["simulate", str(EXAMPLES / "pendulum.lag"), "-o", str(tmp_path / "x.mat"), "--stream"]) == 2
    assert main(["simulate", str(EXAMPLES / "pendulum.lag"), "-o", "-", "--stream"]) == 2


@pytest.mark.skipif(sys.platform == "win32", reason="a process is killed")
@pytest.mark.parametrize("kind", ["csv", "jsonl"])
def test_a_killed_stream_keeps_its_rows(kind: str, tmp_path: Path) -> None:
    scene = str(EXAMPLES / "double_pendulum.lag")
    command = [sys.executable, "-m", "lagrangia", "simulate", scene, "--stop", "9e5", "--interval", "0.01", "--stream", "-o",
               f"x.{kind}"]
    file = tmp_path / f"x.{kind}"
    with subprocess.Popen(command, cwd=tmp_path, env=os.environ, stdout=subprocess.DEVNULL) as process:
        begin = time.monotonic()
        while not (file.exists() and file.stat().st_size > 100_000):
            assert time.monotonic() - begin < 60 and process.poll() is None
            time.sleep(0.02)
        process.send_signal(signal.SIGKILL)
    rows = file.read_text().splitlines()
    assert len(rows) > 500 and [path.name for path in tmp_path.iterdir()] == [file.name]
