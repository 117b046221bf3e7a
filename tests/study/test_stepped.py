"""Runs in the caller's hands: the same digits as a run whose inputs are known beforehand, and back to any state."""

import math
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.linalg import expm

import lagrangia as lag
from lagrangia.base.diagnostics import LagError, RunError
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
CART_POLE = """model CartPole
  input Force F;
  Block cart(m = 1, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, 90[deg]), phi(start = 0.1));
  Bar pole(m = 0.1, L = 1, a = hinge.b);
  AppliedForce push(at = cart.center, force = {F, 0});
  output Length top = pole.b.y;
  annotation(experiment(StopTime = 4, Tolerance = 1e-10));
end CartPole;
"""
BLOCK = """model Pushed
  input Force F; input Force G(start = 1);
  Block block(m = 2, base = world, along = {1, 0}, s(start = 0.3));
  SpringDamper spring(k = 8, c = 0.6, stretch = block.s);
  AppliedForce push(at = block.center, force = {F + 2*G, 0});
  annotation(experiment(StopTime = 4, Tolerance = 1e-11));
end Pushed;
"""
BALL = """model Ball
  input Force F;
  Block ball(m = 1, base = world, along = {0, 1}, s(start = 1));
  AppliedForce push(at = ball.center, force = {0, F});
equation
  when ball.s < 0 then reinit(ball.v, -0.8*pre(ball.v)); end when;
  annotation(experiment(StopTime = 3, Tolerance = 1e-10));
end Ball;
"""
Scene = Callable[[str], lag.Model]


def held(times: np.ndarray, u: np.ndarray) -> tuple[list[float], list[float]]:
    """A table that holds each value until the next time."""
    return np.repeat(times, 2)[1:-1].tolist(), np.repeat(u, 2).tolist()


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "erk9", "taylor", "pirk", "adams", "implicit"])
@pytest.mark.parametrize("text", [CART_POLE, BALL], ids=["cart", "ball"])
def test_steps_are_those_of_a_run_with_a_table(scene: Scene, text: str, solver: str) -> None:
    model = scene(text)
    times = np.linspace(0, 1.5, 76)
    u = 2 * np.sin(7 * times[:-1])
    whole = model.simulate(at=times.tolist(), inputs=(held(times, u)[0], {"F": held(times, u)[1]}), solver=solver)
    one, many = model.start(solver=solver), model.start(solver=solver)
    rows = [one.row]
    for value in u:
        one.set(F=value)
        one.step(0.02)
        rows.append(one.row)
    table = many.steps(u, 0.02)
    np.testing.assert_allclose(np.array(rows), whole.rows, rtol=0, atol=2e-7)
    np.testing.assert_array_equal(table, np.array(rows)[1:])
    name = "top" if text is CART_POLE else "ball.s"
    assert one.time == pytest.approx(1.5) and one[name] == pytest.approx(whole[name][-1], abs=2e-7)


def test_a_held_input_is_exact(scene: Scene) -> None:
    """Against the matrix exponential of the sampled system."""
    run = scene(BLOCK).start()
    A = np.array([[0, 1, 0], [-4, -0.3, 0.5], [0, 0, 0]])
    step, x = expm(0.05 * A), np.array([0.3, 0.0])
    for k in range(100):
        F = math.cos(k)
        x = (step @ [*x, F + 2])[:2]
        run.set(F=F)
        state = run.step(0.05)
        assert state.tolist() == pytest.approx(x.tolist(), abs=2e-10)
    assert run.inputs == {"F": math.cos(99), "G": 1.0}


def test_a_state_is_come_back_to(scene: Scene) -> None:
    model = scene(BALL)
    run = model.start()
    run.steps(37, 0.02)
    kept = run.save()
    run.set(F=0.5)
    once = run.steps(60, 0.02)
    run.restore(kept)
    assert run.time == pytest.approx(0.74) and run.inputs == {"F": 0.0}
    run.set(F=0.5)
    np.testing.assert_array_equal(run.steps(60, 0.02), once)
    other = model.start()
    other.restore(kept)
    other.set(F=0.5)
    np.testing.assert_array_equal(other.steps(60, 0.02), once)
    for wrong in (b"", kept[:-8], b"x" * len(kept)):
        with pytest.raises(LagError, match="no state of this run"):
            other.restore(wrong)


def test_controllers_are_asked_at_equal_times(scene: Scene) -> None:
    """A sampled feedback against its closed loop, and quantities that the rows do not hold."""
    asked: list[float] = []

    def control(t: float, run: lag.SteppedRun) -> float:
        asked.append(t)
        return -3 * run["block.s"] - run["der(block.s)"]

    found = scene(BLOCK).simulate(controllers={"F": control}, every=0.05, stop=2.02)
    assert asked == pytest.approx([0.05 * k for k in range(41)])
    A = np.array([[0, 1, 0], [-4, -0.3, 0.5], [0, 0, 0]])
    x = np.array([0.3, 0.0])
    for k in range(40):
        x = (expm(0.05 * A) @ [*x, -3 * x[0] - x[1] + 2])[:2]
        assert [found["block.s"][k + 1], found["der(block.s)"][k + 1]] == pytest.approx(x.tolist(), abs=2e-10)
    assert found.time[-1] == pytest.approx(2.02) and len(found.time) == 42
    assert found["F"][0] == pytest.approx(-0.9)
    assert found.warnings == []


def test_a_controller_that_fails_is_heard_and_a_run_that_fails_keeps_its_rows(scene: Scene) -> None:
    model = scene(BLOCK)
    with pytest.raises(ZeroDivisionError):
        model.simulate(controllers={"F": lambda t, run: 1 / (t < 0.5)}, every=0.1)
    with pytest.raises(LagError, match="finite"):
        model.simulate(controllers={"F": lambda t, run: math.nan}, every=0.1)
    wall = scene("model Wall "
                 "input Force F; Block b(m = 1, base = world, along = {1, 0}, v(start = 1)); energy potential "
                 "-log(1 - b.s/1[m])*1[J]*0 + 1[J]*sqrt(0.5 - b.s/1[m]); annotation(experiment(StopTime = 2)); end Wall;")
    with pytest.raises(RunError) as failed:
        wall.simulate(controllers={"F": lambda t, run: 100.0}, every=0.1)
    assert 1 < len(failed.value.trajectory.rows) < 10


@pytest.mark.parametrize(("asked", "said"), [
    ({"every": 0.1}, "no meaning without controllers"), ({"controllers": {"F": lambda t, r: 0}}, "need a period"),
    ({"controllers": {"H": lambda t, r: 0}, "every": 0.1}, "no input 'H'"),
    ({"controllers": {"F": 3}, "every": 0.1}, "a function"),
    ({"controllers": {"F": lambda t, r: 0}, "every": 0.1, "interval": 0.1}, "rows stand where"),
    ({"controllers": {"F": lambda t, r: 0}, "every": math.inf}, "positive number of seconds"),
])
def test_what_no_feedback_can_be_is_told(scene: Scene, asked: dict[str, object], said: str) -> None:
    with pytest.raises(LagError, match=said):
        scene(BLOCK).simulate(**asked)


def test_what_no_step_can_be_is_told(scene: Scene) -> None:
    model = scene(BLOCK)
    run = model.start()
    for wrong in (lambda: run.step(0), lambda: run.step(math.nan), lambda: run.steps(0, 0.1), lambda: run.steps([[1.0]], 0.1),
                  lambda: run.steps([[1.0, math.nan]], 0.1), lambda: run.set(H=1), lambda: run.set(F=math.inf),
                  lambda: run.steps([[1.0, 2.0], [3.0]], 0.1), lambda: run.steps(np.ma.masked_less([[1.0, 2.0]], 2), 0.1),
                  lambda: run.steps(np.full((1, 2), 1j), 0.1), lambda: run.set(F=np.complex128(1 + 1j)),  # imaginary parts went
                  lambda: run["nope"], lambda: model.start(solver="islands"),
                  lambda: model.start(inputs=([0, 1], {"F": [0, 1], "G": [0, 1]}))):
        with pytest.raises(LagError):
            wrong()
    assert run.time == 0


def test_steps_are_quick(scene: Scene) -> None:
    """Far from what a busy machine could do: what is measured stands in tests/benchmarks/stepping.py."""
    run = scene(CART_POLE).start(tolerance=1e-6)
    begin = time.process_time()
    run.steps(np.zeros((20_000, 1)), 0.02)
    assert time.process_time() - begin < 2


def test_a_run_that_has_ended_has_ended_when_come_back_to(scene: Scene) -> None:
    model = scene("""model Falls
      Block block(m = 1, base = world, along = {0, 1}, s(start = 1));
    equation
      when block.s < 0.5 then terminate("low"); end when;
    end Falls;""")
    run = model.start()
    before = run.save()
    run.steps(10, 0.1)
    after = run.save()
    assert run.ended
    said = run.ended
    run.restore(before)
    assert run.ended == "" and len(run.steps(2, 0.1)) == 2
    run.restore(after)
    assert run.ended == said
    with pytest.raises(RunError):
        run.step(0.1)


def test_what_runs_in_islands_is_saved_with_them(tmp_path: Path) -> None:
    """A run goes back to where it was saved before several events; another one goes on from there, once the first has ended."""
    path = tmp_path / "apart.lag"
    path.write_text("""model Apart
  World world(gravity = {0, 0});
  Block p(m = 1, base = world), q(m = 1, base = world, v(start = 1));
  Spring s(k = 300, stretch = q.s);
  AppliedForce f(at = p.center, force = {0.1 + 4*sin(3*p.s)*mod(time/1[s], 0.25), 0});
end Apart;""")
    model = lag.load(path)
    one = model.start(tolerance=1e-9)
    one.step(0.3)
    assert "islands" in one.statistics.solver.name.lower()
    kept = one.save()
    right = [one.step(0.4).copy() for _ in range(3)][-1]
    one.restore(kept)
    again = [one.step(0.4).copy() for _ in range(3)][-1]
    del one
    other = model.start(tolerance=1e-9, initial={"p.s": 2.0, "q.v": -3.0})
    other.restore(kept)
    there = [other.step(0.4).copy() for _ in range(3)][-1]
    assert again.tolist() == there.tolist() == right.tolist()
