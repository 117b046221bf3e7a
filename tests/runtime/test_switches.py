"""Conditions on the state: steps hold them, and a run goes back to where one changes."""

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "taylor", "erk", "erk5", "adams", "implicit")

BILINEAR = """model Bilinear "A mass between two springs, of which one is pushed only"
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, s(start = -0.1), v(start = 0));
  GeneralSpring free(stretch = b.s, V = 100[N/m]*b.s^2/2), stop(stretch = b.s, V = 800[N/m]*max(b.s, 0[m])^2/2);
end Bilinear;"""
BALL = """model Ball "falls on an elastic ground"
  Prismatic y(a = world, along = {0, 1}, s(start = 1));
  PointMass m(m = 1, center = y.b);
  GeneralSpring ground(stretch = y.s, V = 1e5[N/m]*min(y.s, 0[m])^2/2);
end Ball;"""
BALLS = """model Balls "swing through each other but for their contact, in which force grows with the power 3/2 of the depth"
  Revolute h[2](phi(start = {-90[deg] - 0.5, -90[deg]}));
  PointMass p[2](each m = 0.1, center = {shift(h[i].b, {1, 0}) for i in 1:2});
  Length d = max(0.04 - distance(p[1].center, p[2].center), 0[m]);
  GeneralSpring c(stretch = d, V = 4e8[N/m]*(d/1[m])^2.5*1[m2]);
equation
  for i in 1:2 loop connect(h[i].a, shift(world, {0.0401*i, 0})); end for;
end Balls;"""
CAM = """model Cam "A free wheel, whose angle switches a force"
  World world(gravity = {0, 0});
  Disc w(m = 1, r = 0.1, center(x(fixed = true), y(fixed = true), w(start = 20)));
  Block b(m = 1, base = world);
  AppliedForce f(at = b.center, force = {if sin(w.center.phi) > 0 then 1[N] else -1[N], 0[N]});
end Cam;"""


def bilinear(t: np.ndarray) -> np.ndarray:
    """Half a period with k = 100, then half a period with k = 900, and so on: places by their phases."""
    slow, fast = 10.0, 30.0
    quarter, half = np.pi / (2 * slow), np.pi / fast
    period = 2 * quarter + half
    phase = np.mod(t - quarter, period)
    pushed = phase < half
    return np.where(pushed, np.sin(fast * phase) / fast, -np.sin(slow * (phase - half)) / slow)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_a_stop_keeps_the_tolerance(scene: Write, solver: str, tolerance: float) -> None:
    t = np.linspace(0, 10, 101)
    run = scene(BILINEAR).simulate(at=t, tolerance=tolerance, solver=solver)
    np.testing.assert_allclose(run["b.s"], 1.0 * bilinear(t), rtol=0, atol=max(10 * tolerance * 0.1, 3e-12))
    assert run.statistics.events == 48


def test_series_cross_corners_without_a_rejection(scene: Write) -> None:
    run = scene(BILINEAR).simulate(stop=10, tolerance=1e-9)
    assert run.statistics.solver.name == "TAYLOR"
    assert run.statistics.rejected == 0


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_ball_bounces_to_its_height(scene: Write, solver: str) -> None:
    """Times of flight and of contact are known: the 10th summit is at their sum."""
    g, k = 9.81, 1e5
    fall, w = np.sqrt(2 / g), np.sqrt(k)
    speed = g * fall
    contact = (2 * np.pi - 2 * np.arctan2(speed * w, g)) / w  # half a period and twice the way to the middle
    times = [(2 * fall + contact) * n for n in range(1, 11)]
    run = scene(BALL).simulate(at=times, tolerance=1e-10, solver=solver)
    np.testing.assert_allclose(run["y.s"], 1, rtol=0, atol=1e-8)
    assert run.statistics.events == 20


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "adams", "implicit"])
def test_nothing_passes_through_a_contact_within_a_step(scene: Write, solver: str) -> None:
    """A force with a root of what is negative elsewhere: steps that cannot hold it go without."""
    model = scene(BALLS)
    for tolerance in np.logspace(-2, -8, 25):
        run = model.simulate(stop=1, tolerance=tolerance, solver=solver)
        assert run.statistics.energy_residual < 1e-2
        assert run["h[2].phi"][-1] > -1.5


@pytest.mark.parametrize("solver", ["taylor", "erk", "islands"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-9])
def test_a_wheel_that_turns_freely_switches_as_often_as_it_turns(scene: Write, solver: str, tolerance: float) -> None:
    """Nothing limits the steps but the condition."""
    t = np.linspace(0, 9, 91)
    run = scene(CAM).simulate(at=t, tolerance=tolerance, solver=solver)
    half = np.pi / 20
    count, rest = np.floor(t / half), np.mod(t, half)
    speed = np.where(count % 2 == 0, rest, half - rest)
    np.testing.assert_allclose(run["b.v"], speed, rtol=0, atol=max(tolerance, 1e-9))
    assert solver == "islands" or run.statistics.events == np.floor(9 / half)


@pytest.mark.parametrize(("kind", "error"), [("CoSimulation", 1e-8), ("ModelExchange", 1e-5)])
def test_fmus_bounce(tmp_path: Path, kind: str, error: float) -> None:
    """A run of our own has events between two communication points; importers find them by event indicators."""
    path = tmp_path / "ball.lag"
    path.write_text(BALL, encoding="utf-8")
    own = lag.load(path).simulate(at=np.linspace(0, 3, 31), tolerance=1e-12)["y.s"]
    found = simulated(path, "2", kind, ["y.s"], stop_time=3.0, output_interval=0.1, relative_tolerance=1e-9)
    np.testing.assert_allclose(np.interp(np.linspace(0, 3, 31), found["time"], found["y.s"]), own, rtol=0, atol=error)


def test_runs_of_a_sweep_have_events_of_their_own(scene: Write) -> None:
    sweep = scene(BALL).simulate_many(parameters={"m.m": [0.5, 2.0]}, stop=2.0, tolerance=1e-10)
    for mass, end in zip((0.5, 2.0), sweep["final(y.s)"], strict=True):
        run = scene(BALL.replace("m = 1", f"m = {mass}")).simulate(at=[2.0], tolerance=1e-10)
        assert end == pytest.approx(run["y.s"][-1], abs=1e-9)


def test_rows_do_not_depend_on_where_events_are(scene: Write) -> None:
    """Rows inside a step that ended at an event come of the step itself."""
    model = scene(BILINEAR)
    coarse = model.simulate(at=[0.0, 10.0], tolerance=1e-9)
    fine = model.simulate(at=np.linspace(0, 10, 1001), tolerance=1e-9)
    assert coarse["b.s"][-1] == pytest.approx(fine["b.s"][-1], abs=1e-13)
    jumps = np.abs(np.diff(fine["b.v"]))
    assert jumps.max() < 1.1 * 30 * 0.01
    assert all(a < b for a, b in pairwise(fine["time"]))


@pytest.mark.parametrize("solver", (*SOLVERS, "erk9", "pirk"))
def test_narrow_windows_about_another_change(scene: Write, solver: str) -> None:
    """A dead band of 1e-7 about a sign that changes in it, so that the rate stays; a force of 1e7 N there for 3e-7 s, that gives
    1 kg 3 m/s. Where the condition is the same at both ends of a step it was stepped over: 0.2 m for 0.21, and 0 or 2 m/s."""
    band = scene("""model Band
      World world(gravity = {0, 0}); Block b(m = 2, base = world, v(start = 1));
      AppliedForce q(at = b.center, force = {if abs(b.v) > 1e-7 then -5*sign(b.v) else 0, 0});
    end Band;""")
    pulse = scene("""model Pulse
      World world(gravity = {0, 0}); Block b(m = 1, base = world, v(start = 1)), c(m = 1, base = world);
      AppliedForce q(at = b.center, force = {if b.v > 0 then -1 else -0.5, 0});
      AppliedForce r(at = c.center, force = {if abs(b.v) < 1e-7 then 1e7 else 0, 0});
    end Pulse;""")
    for tolerance in (1e-8, 1e-9, 1e-10):
        run = band.simulate(at=[1e5], solver=solver, tolerance=tolerance)
        assert run["b.s"][0] == pytest.approx(0.2 + 1e-7 * (1e5 - 0.4), abs=1e-7)
        run = pulse.simulate(at=[3.0], solver=solver, tolerance=tolerance)
        assert run["der(c.s)"][0] == pytest.approx(3, abs=2e-6)


@pytest.mark.parametrize("width", [1e-6, 1e-8])
def test_narrow_windows_in_conditions(scene: Write, width: float) -> None:
    """A mass that swings passes 0.3 m six times in three periods, however narrow the window of its event; and a condition of time
    ends 1e-8 s after one of a place begins. Counts were 0 to 5 as width, tolerance and solver chose, and 0."""
    swing = scene(f"""model Swing
      World world(gravity = {{0, 0}}); Block b(m = 1, base = world, s(start = 1)); Spring k(k = 4, stretch = b.s);
      discrete Integer n(start = 0);
    equation
      when abs(b.s - 0.3) < {width} then n = pre(n) + 1; end when;
    end Swing;""")
    meeting = scene(f"""model Meeting
      World world(gravity = {{0, 0}}); Block b(m = 1, base = world, v(start = 1)); discrete Integer n(start = 0);
      AppliedForce f(at = b.center, force = {{if time > 1 + {width} then 1 else 0, 0}});
    equation
      when b.s > 1 and time < 1 + {width} then n = pre(n) + 1; end when;
    end Meeting;""")
    for solver in ("auto", "taylor", "erk", "erk5", "erk9"):
        for tolerance in (1e-6, 1e-8, 1e-10):
            assert swing.simulate(at=[9.3], solver=solver, tolerance=tolerance)["n"][0] == 6, (solver, tolerance)
            assert meeting.simulate(at=[2.0], solver=solver, tolerance=tolerance)["n"][0] == 1, (solver, tolerance)
