"""Rows that are no motion of the scene, as their energy account tells: RunWarning in Python, exit code 1 of commands."""

import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.native.build import find_compiler

STEP = """model Step
  World world(gravity = {0, 0}); input Force F(start = 0); parameter Length at = 0;
  Block b(m = 1, base = world, s(start = -0.6, fixed = true), v(start = 1, fixed = true));
  AppliedForce f(at = b.center, force = {F, 0});
energy
  potential noEvent(if b.s > at then 0.4[J] else 0);
  annotation(experiment(StopTime = 1.2), allow = "L0744");
end Step;"""
MODEL = lag.loads(STEP)
GIVEN = {"inputs": {"F": 0.0}}
pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def step_by_step() -> None:
    run = MODEL.start(inputs={"F": 0.0})
    for _ in range(4):
        run.step(0.3)
    assert len(run.warnings) == 1


def prepared() -> None:
    MODEL.prepare(**GIVEN)()


@pytest.mark.parametrize(("ask", "told"), [
    (lambda: MODEL.simulate(**GIVEN), "does not close at all"),
    (lambda: MODEL.simulate(controllers={"F": lambda t, run: 0.0}, every=0.3), "does not close at all"),
    (step_by_step, "does not close at all"),
    (lambda: MODEL.start(inputs={"F": 0.0}).steps(4, 0.3), "does not close at all"),
    (prepared, "does not close at all"),
    (lambda: MODEL.simulate_many(parameters={"at": [-0.1, 0, 5]}, **GIVEN), "2 of 3 runs"),
    (lambda: MODEL.rollout(p={"at": np.array([0, 5])}, u=np.zeros((2, 1, 1)), times=[0, 1.2]), "1 of 2 runs"),
])
def test_python_is_told_without_asking(ask: Callable[[], object], told: str) -> None:
    """Once, at the line that asked; their rows came without a word, beside `warnings` that nobody need look at."""
    with pytest.warns(lag.RunWarning, match="the energy account") as found:
        ask()
    (warning,) = found
    assert warning.filename == __file__ and told in str(warning.message)


def test_runs_that_are_right_are_not_told_of() -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error", lag.RunWarning)
        run = MODEL.prepare(parameters={"at": 0.0}, **GIVEN)
        assert run((), [5.0])[-1, 1] == pytest.approx(0.6)
        with pytest.raises(lag.RunWarning):
            run((), [0.0])
        assert MODEL.simulate(parameters={"at": 5}, **GIVEN)["b.s"][-1] == pytest.approx(0.6)
        assert MODEL.simulate_many(parameters={"at": [4, 5]}, **GIVEN).ok.all()


def test_commands_that_show_runs_fail(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
                                        ) -> None:
    """What they show is written; `lag test` passed, and the others ended with exit code 0."""
    monkeypatch.chdir(tmp_path)
    Path("step.lag").write_text(STEP.replace("input Force F(start = 0)", "parameter Force F = 0"))
    for words in (["draw", "--at", "1.2", "-o", "x.svg"], ["animate", "-o", "y.svg"], ["test"]):
        assert main([words[0], "step.lag", *words[1:]]) == 1
        shown = capsys.readouterr()
        assert (shown.err + shown.out).count("the energy account does not close at all") == 1
    assert Path("x.svg").exists() and Path("y.svg").exists()
