"""Events whose conditions are conditions on time: each comes at its time, exactly, and none is lost."""

from collections.abc import Callable
from itertools import pairwise
from math import ceil, floor, sin
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.native.build import find_compiler

Write = Callable[[str], lag.Model]
KICKED = """model Kicked "its rate grows by 1 whenever the condition comes true"
  parameter Time T = 0.1;  parameter Real one = 1;
  World world(gravity = {{0, 0}});
  Block b(m = 1, base = world), c(m = 1, base = world, s(start = -0.333), v(start = 1));
  Real saw = mod(time, T)/T;
equation
  when {condition} then reinit(b.v, pre(b.v) + 1); end when;
end Kicked;"""
# Conditions and the same for Python, of t and of the place of the other block.
CONDITIONS = {
    "mod(time, 0.1) < 0.05": lambda t, s: t - 0.1 * floor(t / 0.1) < 0.05,
    "mod(time, 0.1) <= 0.03": lambda t, s: t - 0.1 * floor(t / 0.1) <= 0.03,
    "0.07 < mod(time, 0.1)": lambda t, s: t - 0.1 * floor(t / 0.1) > 0.07,
    "not mod(time, 0.1) < 0.05": lambda t, s: t - 0.1 * floor(t / 0.1) >= 0.05,
    "floor(time/0.1) > 4": lambda t, s: floor(t / 0.1) > 4,
    "floor(time/0.1) >= 5": lambda t, s: floor(t / 0.1) >= 5,
    "ceil(time/0.1) > 4": lambda t, s: ceil(t / 0.1) > 4,
    "mod(floor(time/0.1), 3) < 1": lambda t, s: floor(t / 0.1) % 3 < 1,
    "floor(time/0.1) - 2*floor(time/0.2) >= 1": lambda t, s: floor(t / 0.1) - 2 * floor(t / 0.2) >= 1,
    "pulse_train(time, 0.1, 0.05, 0.2) > 0.5": lambda t, s: t >= 0.1 and (t - 0.1) % 0.2 < 0.05,
    "pulse_train(time, 0.1, 0.05, 0.2) >= 1": lambda t, s: t >= 0.1 and (t - 0.1) % 0.2 < 0.05,
    "pulse(time, 0.3, 0.2) + step(time - 0.4) > 1.5": lambda t, s: 0.4 <= t < 0.5,
    "saw < 0.25": lambda t, s: t - 0.1 * floor(t / 0.1) < 0.025,
    "saw*one > 0.25": lambda t, s: t - 0.1 * floor(t / 0.1) > 0.025,
    "(if time < 0.45 then mod(time, 0.1) else 0.1) > 0.06": lambda t, s: t >= 0.45 or t - 0.1 * floor(t / 0.1) > 0.06,
    "sin(40*time) > 0.5": lambda t, s: sin(40 * t) > 0.5,
    "sin(40*time)*floor(time/0.25) > 0.5": lambda t, s: sin(40 * t) * floor(t / 0.25) > 0.5,
    "mod(time, 0.1) < 0.05 and c.s > 0": lambda t, s: t - 0.1 * floor(t / 0.1) < 0.05 and s > 0,
    "c.s > 0 or mod(time, 0.1) > 0.05": lambda t, s: s > 0 or t - 0.1 * floor(t / 0.1) > 0.05,
    "c.s > 0.1*floor(time/0.3)": lambda t, s: s > 0.1 * floor(t / 0.3),
    "floor(c.s/0.1) >= 2": lambda t, s: floor(s / 0.1) >= 2,
    "not (c.s < 0 or time < 0.6)": lambda t, s: s >= 0 and t >= 0.6,
    "time > 0.5": lambda t, s: t > 0.5,
}


def rising(holds: Callable[[float, float], bool], stop: float) -> list[float]:
    """When a condition comes true after the start, to rounding."""
    ticks = np.linspace(1e-9, stop, 20011)
    return [_root(holds, a, b) for a, b in pairwise(ticks) if holds(b, b - 0.333) and not holds(a, a - 0.333)]


def _root(holds: Callable[[float, float], bool], low: float, high: float) -> float:
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if holds(middle, middle - 0.333) else (middle, high)
    return high


@pytest.mark.parametrize("condition", CONDITIONS)
def test_events_come_at_their_times(scene: Write, condition: str) -> None:
    times = rising(CONDITIONS[condition], 0.95)
    assert times
    model = scene(KICKED.format(condition=condition))
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.0, 0.95], tolerance=1e-6, solver=solver)
        assert run["b.v"][-1] == len(times), solver
        assert run["b.s"][-1] == pytest.approx(sum(0.95 - t for t in times), abs=1e-13), solver


def test_parameters_move_the_times(scene: Write) -> None:
    model = scene(KICKED.format(condition="mod(time, T) < T/2"))
    sweep = model.simulate_many(parameters={"T": [0.1, 0.2, 0.3]}, stop=0.95)
    for period, end in zip((0.1, 0.2, 0.3), sweep["final(b.s)"], strict=True):
        assert end == pytest.approx(sum(0.95 - period * k for k in range(1, floor(0.95 / period) + 1)), abs=1e-13)


FLOOR = """model Floor "a ball, on a floor that is there for some time"
  Prismatic p(a = world, along = {{0, 1}}, s(start = {start}));
  PointMass ball(m = 2, center = p.b);
equation
  when p.s < 0 and {condition} then reinit(der(p.s), -0.5*pre(der(p.s))); end when;
end Floor;"""


def test_a_floor_opens_and_closes(scene: Write) -> None:
    """What rests on it falls from where it rests; what is below it when it comes is turned back once, and passes no more."""
    rest = scene(FLOOR.format(start="0", condition="time < 1")).simulate(at=[0.5, 1.5], tolerance=1e-9)
    np.testing.assert_allclose(rest["p.s"], [0, -9.81 * 0.5**2 / 2], rtol=0, atol=1e-12)
    late = scene(FLOOR.format(start="-0.1", condition="time > 0.1")).simulate(at=[0.1, 0.2], tolerance=1e-9)
    place, rate = -0.1 - 9.81 * 0.1**2 / 2, 0.5 * 9.81 * 0.1
    np.testing.assert_allclose(late["p.s"], [place, place + rate * 0.1 - 9.81 * 0.1**2 / 2], rtol=0, atol=1e-12)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_fmus_have_them(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "kicked.lag"
    path.write_text(KICKED.format(condition="mod(time, T) < T/2"), encoding="utf-8")
    found = simulated(path, "2", kind, ["b.s", "b.v"], stop_time=0.95, output_interval=0.05, relative_tolerance=1e-9)
    assert found["b.v"][-1] == 9
    assert found["b.s"][-1] == pytest.approx(4.05, abs=1e-7)
