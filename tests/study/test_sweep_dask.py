"""A sweep on a Dask cluster of processes, one of which is killed on the way."""

import os
import re
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.native.build import find_compiler

pytest.importorskip("distributed")
pytestmark = [
    pytest.mark.skipif(find_compiler() is None, reason="no C compiler"),
    pytest.mark.skipif(sys.platform == "win32", reason="kills with SIGKILL"),
]

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
SWEEP = (str(EXAMPLES / "double_pendulum.lag"), "--initial", "elbow.phi=linspace(-1,1,4000)", "--stop", "20",
         "--tolerance", "1e-7", "--outputs", "max(lower.b.y),final(shoulder.phi)")


class Cluster:
    """A scheduler and workers, each a process of its own with a cache of its own."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.scheduler = self._start("scheduler", "--host", "127.0.0.1", "--port", "0", "--no-dashboard", "--no-show")
        self.address = self._said(self.scheduler, r"Scheduler at:\s+(tcp://\S+)")
        self.workers = [self.worker(k) for k in range(2)]

    def _start(self, *arguments: str, cache: str = "none") -> subprocess.Popen[bytes]:
        environment = os.environ | {"LAGRANGIA_CACHE": str(self.folder / cache)}
        log = (self.folder / f"log-{len(list(self.folder.glob('log-*')))}").open("wb")
        with log:
            process = subprocess.Popen([sys.executable, "-m", "dask", *arguments], stdout=log, stderr=log, env=environment,
                                       cwd=self.folder)
        process.log = Path(log.name)  # type: ignore[attr-defined]
        return process

    def _said(self, process: subprocess.Popen[bytes], pattern: str) -> str:
        begin = time.monotonic()
        while not (match := re.search(pattern, process.log.read_text())):  # type: ignore[attr-defined]
            assert process.poll() is None and time.monotonic() - begin < 60, process.log.read_text()  # type: ignore[attr-defined]
            time.sleep(0.05)
        return match[match.lastindex or 0]

    def worker(self, k: int) -> subprocess.Popen[bytes]:
        process = self._start("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard", cache=f"cache-{k}")
        self._said(process, "Registered to")
        return process

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture
def cluster(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[Cluster]:
    monkeypatch.chdir(tmp_path)
    found = Cluster(tmp_path)
    yield found
    found.close()


def size(name: str) -> int:
    return Path(name).stat().st_size if Path(name).exists() else 0


@pytest.mark.slow
def test_a_worker_that_is_killed_costs_no_run(cluster: Cluster) -> None:
    """The same table as here, byte by byte; workers have caches of their own."""
    command = [sys.executable, "-m", "lagrangia.command.cli", "sweep", *SWEEP, "--dask", cluster.address, "-o", "there.csv"]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    begin = time.monotonic()
    while size("there.csv.part") < 20_000:
        assert process.poll() is None, process.communicate()
        assert time.monotonic() - begin < 100
        time.sleep(0.01)
    victim = 0
    cluster.workers[victim].send_signal(signal.SIGKILL)
    assert process.poll() is None, "or it was killed too late"
    out, err = process.communicate(timeout=200)
    assert process.returncode == 0, err
    assert "4000 runs, 0 failed" in out
    assert main(["sweep", *SWEEP, "-o", "here.csv", "--quiet"]) == 0
    assert Path("there.csv").read_bytes() == Path("here.csv").read_bytes()
    assert cluster.workers[victim].wait() == -signal.SIGKILL


IMPATIENT = """import sys
from lagrangia.command.cli import main
from lagrangia.study.sweep import dask_cluster
dask_cluster._SILENT = 2
sys.exit(main(sys.argv[1:]))
"""


@pytest.mark.parametrize(("by", "what"), [(signal.SIGKILL, "has gone away"), (signal.SIGSTOP, "does not answer")])
def test_a_scheduler_that_is_lost_is_told_and_the_sweep_goes_on(by: signal.Signals, what: str, cluster: Cluster) -> None:
    command = [sys.executable, "-c", IMPATIENT, "sweep", *SWEEP, "-o", "x.csv"]
    pipes = {"stdout": subprocess.PIPE, "stderr": subprocess.PIPE, "text": True}
    with subprocess.Popen([*command, "--dask", cluster.address], cwd=cluster.folder, **pipes) as process:
        begin = time.monotonic()
        while not ((part := cluster.folder / "x.csv.part").exists() and part.stat().st_size > 20_000):
            assert time.monotonic() - begin < 60 and process.poll() is None
            time.sleep(0.02)
        cluster.scheduler.send_signal(by)
        out, said = process.communicate(timeout=120)
    assert process.returncode == 1, (out, said)
    assert what in said and "goes on" in said and "bug:" not in said
    done = subprocess.run(command, cwd=cluster.folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0 and "goes on with x.csv.part" in done.stderr
    assert len((cluster.folder / "x.csv").read_text().splitlines()) == 4001


def test_from_python_and_with_failures(cluster: Cluster) -> None:
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    options = {"parameters": {"upper.m": [1, -1, 2, 3, 4]}, "stop": 1.0, "outputs": ["final(elbow.phi)"]}
    there, here = model.simulate_many(**options, dask=cluster.address), model.simulate_many(**options)
    assert there.failures == here.failures
    assert list(there.failures) == [1]
    assert there.ledger.results.tobytes() == here.ledger.results.tobytes() and there.ledger.lanes.runs == 4
    assert model.simulate_many(stop=1.0, dask=cluster.address).runs == 1, "nothing varied"


def test_workers_take_the_engine_that_is_asked_for(cluster: Cluster) -> None:
    """A worker's cache has the scene as a whole where engine 'native' asks for it, and nothing of it where nobody does."""
    for native in (False, True):
        model = lag.load(EXAMPLES / "double_pendulum.lag")
        model.native = native
        model.simulate_many(initial={"elbow.phi": np.linspace(0.1, 1, 16)}, stop=1.0, dask=cluster.address)
        assert any(any((cluster.folder / f"cache-{k}").glob("scene-*")) for k in range(2)) == native


def test_a_cluster_without_workers_is_told(cluster: Cluster, monkeypatch: pytest.MonkeyPatch) -> None:
    for worker in cluster.workers:
        worker.kill()
        worker.wait()
    monkeypatch.setattr("lagrangia.study.sweep.dask_cluster._TIMEOUT", 3)
    time.sleep(0.5)
    with pytest.raises(lag.LagError, match="no workers"):
        lag.load(EXAMPLES / "pendulum.lag").simulate_many(stop=1.0, dask=cluster.address)


def test_without_dask_it_is_told(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with pytest.raises(lag.LagError, match="pip install dask"):
        lag.load(EXAMPLES / "pendulum.lag").simulate_many(stop=1.0, dask="tcp://127.0.0.1:1")


@pytest.mark.slow
def test_trajectories_come_from_a_cluster(cluster: Cluster) -> None:
    """The same as here, with inputs from run to run; in memory and in files."""
    model = lag.load(EXAMPLES / "suspended_bar.lag")
    asked = {"parameters": {"k1": [900, 1000, 1100]}, "outputs": "max(y)", "stop": 2, "interval": 0.1, "keep": True}
    there, here = model.simulate_many(**asked, dask=cluster.address), model.simulate_many(**asked)
    assert there["max(y)"].tolist() == here["max(y)"].tolist()
    np.testing.assert_array_equal(there.trajectories, here.trajectories)
    command = ["sweep", str(EXAMPLES / "pendulum.lag"), "-p", "L=1,2", "--stop", "1", "--interval", "0.25", "--keep", "--quiet"]
    assert main([*command, "--dask", cluster.address, "-o", "x.csv"]) == 0
    table = pytest.importorskip("pandas").read_parquet("x_runs")
    assert sorted(table["run"].unique()) == [0, 1] and len(table) == 10
    pushed = lag.loads("model M input Force F; Block b(m = 2, base = world); AppliedForce p(at = b.center, force = {F, 0});\n"
                       "annotation(experiment(StopTime = 1)); end M;")
    found = pushed.simulate_many(inputs=[{"F": 1.0}, ([0.0, 1.0], {"F": [0.0, 3.0]})], outputs="b.s", dask=cluster.address)
    assert found["b.s"] == pytest.approx([0.25, 0.25], abs=1e-9)
