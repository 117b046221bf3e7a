"""Ctrl-C in Python ends what runs at once, as KeyboardInterrupt, and what was computed is kept; engines are named."""

import os
import signal
import subprocess
import sys
import threading
import time
import warnings
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.base.own_python import own_environment

PENDULUM = """
model Pendulum
  Revolute hinge(a = world, phi(start = 2));
  Bar bar(m = 1, L = 1, a = hinge.b);
  annotation(experiment(StopTime = 5, Tolerance = 1e-10));
end Pendulum;
"""


@pytest.fixture(scope="module")
def pendulum(tmp_path_factory: pytest.TempPathFactory) -> lag.Model:
    path = tmp_path_factory.mktemp("interruptions") / "pendulum.lag"
    path.write_text(PENDULUM)
    return lag.load(path)


@pytest.fixture(scope="module")
def endless(tmp_path_factory: pytest.TempPathFactory) -> lag.Model:
    """A double pendulum: swings of a single one are read from one of them, and a million seconds are over in no time."""
    path = tmp_path_factory.mktemp("endless") / "double.lag"
    path.write_text(PENDULUM.replace("hinge.b);", "hinge.b); Revolute elbow(a = bar.b); Bar lower(m = 1, L = 1, a = elbow.b);"))
    return lag.load(path)


def interrupted_after(seconds: float) -> float:
    """When Ctrl-C comes."""
    threading.Timer(seconds, lambda: os.kill(os.getpid(), signal.SIGINT)).start()
    return time.perf_counter() + seconds


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
@pytest.mark.parametrize("solver", ["auto", "implicit", "conservative", "casadi:cvodes"])
def test_control_c_ends_a_run(endless: lag.Model, solver: str) -> None:
    before = endless.simulate(solver=solver)["hinge.phi"]
    when = interrupted_after(0.5)
    with pytest.raises(KeyboardInterrupt) as caught:
        endless.simulate(solver=solver, stop=1e6, interval=1.0, tolerance=1e-12)
    assert time.perf_counter() - when < 2
    assert isinstance(caught.value, lag.Interrupted) and "interrupted at t =" in str(caught.value)
    kept = caught.value.result
    assert kept.progress.interrupted and kept.time.tolist() == [float(k) for k in range(len(kept.time))]
    assert endless.simulate(solver=solver)["hinge.phi"].tolist() == before.tolist()
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
def test_control_c_within_one_row(pendulum: lag.Model) -> None:
    when = interrupted_after(0.3)
    with pytest.raises(KeyboardInterrupt):
        pendulum.simulate(at=[1e7], solver="erk", tolerance=1e-12)
    assert time.perf_counter() - when < 2


@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
def test_control_c_ends_many_runs(endless: lag.Model) -> None:
    assert endless.simulate_many(parameters={"bar.m": "1:2:0.5"}).ok.all()  # what is compiled for many runs is there now
    when = interrupted_after(0.5)
    with pytest.raises(KeyboardInterrupt) as caught:
        endless.simulate_many(parameters={"bar.m": "1:2:0.5"}, stop=1e6, tolerance=1e-12)
    assert time.perf_counter() - when < 5
    assert isinstance(caught.value, lag.Interrupted) and caught.value.result.interrupted and not caught.value.result.ok.any()
    assert endless.simulate_many(parameters={"bar.m": "1:2:0.5"}).ok.all()


def test_without_a_compiler_python_says_what_runs(pendulum: lag.Model, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        usual = pendulum.simulate()
    assert usual.engine in ("tape", "tape, then native")  # by how busy the machine is
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    monkeypatch.setenv("LAGRANGIA_CACHE", str(tmp_path))
    other = lag.load(pendulum.path)
    with warnings.catch_warnings(record=True) as told:
        warnings.simplefilter("always")
        run = other.simulate()
    if run.engine == "tape":  # the run time came with the package
        assert not told and run["hinge.phi"].tolist() == usual["hinge.phi"].tolist()
        return
    assert told[0].category is lag.EngineWarning and told[0].filename == __file__ and "CasADi's cvodes" in str(told[0].message)
    assert run.engine == "casadi:cvodes" and other.simulate(solver="casadi:idas").engine == "casadi:idas"
    assert abs(run["hinge.phi"] - usual["hinge.phi"]).max() < 1e-9


def test_an_import_that_turns_control_c_into_an_error_is_no_bug(tmp_path: Path, capsys: pytest.CaptureFixture[str],
                                                                monkeypatch: pytest.MonkeyPatch) -> None:
    """As NumPy's core does: 'PyCapsule_Import could not import module'."""
    from lagrangia.command import cli

    def imported(*_: object) -> None:
        try:
            os.kill(os.getpid(), signal.SIGINT)
        except KeyboardInterrupt:
            raise ImportError("could not import module") from None

    monkeypatch.setattr(cli, "refuse_idle", imported)
    assert cli.main(["check", str(tmp_path / "none.lag")]) == 130
    assert capsys.readouterr().err == "interrupted\n"
    assert signal.getsignal(signal.SIGINT) is signal.default_int_handler


def test_ctrl_c_while_modules_are_imported_is_no_traceback() -> None:
    """In the first tenth of a second it showed where Python's imports were."""
    ask = """import os, signal, sys
class Finder:
    def find_spec(self, name, *rest):
        if name == "lagrangia.command.cli":
            os.kill(os.getpid(), signal.SIGINT)
sys.meta_path.insert(0, Finder())
from lagrangia.__main__ import main
sys.exit(main())"""
    done = subprocess.run([sys.executable, "-P", "-c", ask], env=own_environment(), capture_output=True, text=True, timeout=60,
                          check=False)
    assert (done.returncode, done.stdout, done.stderr) == (130, "", "interrupted\n")
