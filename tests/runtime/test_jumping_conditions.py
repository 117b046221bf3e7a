"""Events of conditions in which something jumps: choices, signs and whole numbers of what moves."""

from collections.abc import Callable
from itertools import pairwise
from math import atan2, ceil, copysign, cos, floor, sin, trunc
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.dynamics.levels import Levels
from lagrangia.native.build import find_compiler

Write = Callable[[str], lag.Model]
A, W, PHI, STOP = 1.97, 2.0, 0.3, 4.2
KICKED = f"""model Kicked "an oscillator, and a block whose rate grows by 1 whenever a condition comes true"
  World world(gravity = {{{{0, 0}}}});
  Block b(m = 1, base = world);
  Block c(m = 1, base = world, s(start = {A * sin(PHI)!r}), v(start = {A * W * cos(PHI)!r}));
  Real s = c.s/1[m];  Real v = c.v/1[m/s];
energy
  potential {W**2 / 2}*c.s^2;
equation
  when {{condition}} then reinit(b.v, pre(b.v) + 1); end when;
end Kicked;"""
Holds = Callable[[float, float, float], bool]


def mod(a: float, b: float) -> float:
    return a - b * floor(a / b)


# Conditions and the same for Python, of s, v and t. Some of them meet at 0 with what chooses among them.
CONDITIONS: dict[str, Holds] = {
    "(if s > 0 then v else s + 1) > 0": lambda s, v, t: (v if s > 0 else s + 1) > 0,
    "(if s > v then s - 0.3 else -v) > 0.2": lambda s, v, t: (s - 0.3 if s > v else -v) > 0.2,
    "not ((if s > 0 then v else s) > 0 or mod(s, 1) > 0.25)": lambda s, v, t: not ((v if s > 0 else s) > 0 or mod(s, 1) > 0.25),
    "(if s > 0 and v > 0 or s < -1 then v - s else s) > 0.4":
        lambda s, v, t: (v - s if (s > 0 and v > 0) or s < -1 else s) > 0.4,
    "mod(3*s, 1) > 0.5": lambda s, v, t: mod(3 * s, 1) > 0.5,
    "2*floor(3*s) + 1 < 0": lambda s, v, t: 2 * floor(3 * s) + 1 < 0,
    "ceil(2*s) <= -2": lambda s, v, t: ceil(2 * s) <= -2,
    "rem(s, 0.6) > 0.3": lambda s, v, t: s - 0.6 * trunc(s / 0.6) > 0.3,
    "div(s, 0.6) + div(v, 1) >= 2": lambda s, v, t: trunc(s / 0.6) + trunc(v) >= 2,
    "v*sign(s) > 1": lambda s, v, t: v * copysign(1, s) > 1,
    "mod(floor(4*s), 3) < 1": lambda s, v, t: mod(floor(4 * s), 3) < 1,
    "max(s, mod(v, 2)) > 1.5": lambda s, v, t: max(s, mod(v, 2)) > 1.5,
    "atan2(sin(s + 3), cos(s + 3)) > 2 and s > -0.5": lambda s, v, t: atan2(sin(s + 3), cos(s + 3)) > 2 and s > -0.5,
    "mod(s, 0.5) + mod(v, 1.5) > 1.2": lambda s, v, t: mod(s, 0.5) + mod(v, 1.5) > 1.2,
    "(if mod(s, 1) > 0.5 then v else -v) > 0": lambda s, v, t: (v if mod(s, 1) > 0.5 else -v) > 0,
    "mod(time, 0.5) > 0.2*s": lambda s, v, t: mod(t, 0.5) > 0.2 * s,
    "(if s < -1 then 0 elseif s < 0 then 1 elseif s < 1 then 2 else 3)*v > 1.5":
        lambda s, v, t: v * (0 if s < -1 else 1 if s < 0 else 2 if s < 1 else 3) > 1.5,
    "table(s, {-2, -1, 0, 1, 2}, {0, 1, 0, 2, 1}) > 0.7":
        lambda s, v, t: bool(np.interp(s, [-2, -1, 0, 1, 2], [0, 1, 0, 2, 1]) > 0.7),
}
SOLVERS = ("erk", "erk9", "implicit", "adams", "pirk", "taylor")


def rising(holds: Holds, stop: float) -> list[float]:
    """When a condition comes true after the start, to rounding."""
    def at(t: float) -> bool:
        return holds(A * sin(W * t + PHI), A * W * cos(W * t + PHI), t)

    ticks = [float(t) for t in np.linspace(1e-9, stop, 20011)]
    return [_root(at, a, b) for a, b in pairwise(ticks) if at(b) and not at(a)]


def _root(at: Callable[[float], bool], low: float, high: float) -> float:
    for _ in range(60):
        middle = (low + high) / 2
        low, high = (low, middle) if at(middle) else (middle, high)
    return high


@pytest.mark.parametrize("condition", CONDITIONS)
def test_events_come_at_their_times(scene: Write, condition: str) -> None:
    times = rising(CONDITIONS[condition], STOP)
    assert times
    model = scene(KICKED.format(condition=condition))
    for solver in ("auto", SOLVERS[list(CONDITIONS).index(condition) % len(SOLVERS)]):
        run = model.simulate(at=[0.0, STOP], tolerance=1e-8, solver=solver)
        assert run["b.v"][-1] == len(times), solver
        assert run["b.s"][-1] == pytest.approx(sum(STOP - t for t in times), abs=1e-6), solver


def test_levels_are_positive_where_conditions_are_true() -> None:
    """At random places; and go on where conditions do not change, however they are written."""
    s, v = ca.SX.sym("s"), ca.SX.sym("v")
    whole, part = ca.floor(3 * s), ca.if_else(s > 0, v, s + 1)
    conditions = [whole * v > 1, part + whole > 0.5, ca.ceil(s) - ca.floor(v) < 0, ca.sign(s) * part <= 0.3,
                  ca.logic_or(ca.logic_not(part > 0), s - ca.floor(s) > 0.6), (part > 0) + (s > 1) + (v < 0.5) > 1.5,
                  ca.if_else(s < 1, s - 1, -5) > 0, ca.if_else(s < 1, ca.floor(s), -5) > 0.5]
    levels = [Levels(ca.vertcat(s, v)).of(condition) for condition in conditions]
    look = ca.Function("look", [s, v], [ca.vertcat(*conditions), ca.vertcat(*levels)])
    random = np.random.default_rng(1)
    places = random.uniform(-3, 3, (2, 2000))
    truths, values = (np.array(x) for x in look(places[:1], places[1:]))
    np.testing.assert_array_equal(values > 0, truths)
    line = np.linspace(-3, 3, 60001)[None, :]
    assert np.abs(np.diff(np.array(look(line, 0.3 + 0.7 * line)[1]))).max() < 0.01


def test_what_cannot_be_taken_apart_is_refused(scene: Write) -> None:
    with pytest.raises(lag.LagError, match="L0225") as caught:
        scene(KICKED.format(condition="(if floor(s) == 1 then v else -v) > 0"))
    assert "not with ==" in str(caught.value)


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_indicators_of_model_exchange_are_these(tmp_path: Path) -> None:
    path, condition = tmp_path / "kicked.lag", "(if s > v then s - 0.3 else -v) > 0.2"
    path.write_text(KICKED.format(condition=condition), encoding="utf-8")
    times = rising(CONDITIONS[condition], STOP)
    found = simulated(path, "2", "ModelExchange", ["b.s", "b.v"], stop_time=STOP, output_interval=0.05, relative_tolerance=1e-9)
    assert found["b.v"][-1] == len(times)
    assert found["b.s"][-1] == pytest.approx(sum(STOP - t for t in times), abs=1e-5)


PUSHED = """model Pushed
  World world(gravity = {{0, 0}});
  Block c(m = 1, base = world, s(start = 0.5), v(start = 3));
  Real s = c.s/1[m];
energy
  potential 2*c.s^2;
  work {force}*1[N] on c.s;
end Pushed;"""
SAME = {  # forces that jump where something in a condition does, and the same by places
    "(if mod(2*s, 1) > 0.5 then 1 else 0)": "(if s < -1 and s > -1.25 or s < -0.5 and s > -0.75 or s < 0 and s > -0.25 or "
        "s < 0.5 and s > 0.25 or s < 1 and s > 0.75 or s < 1.5 and s > 1.25 then 1 else 0)",
    "(if floor(s) + floor(s + 0.3) > 0 then 1 else -1)": "(if s > 0.7 then 1 else -1)",
    "(if (if s > 0.2 then 1 - s else s) > 0 then 1 else 2)": "(if s > 0.2 and s < 1 or s > 0 and s < 0.2 then 1 else 2)",
    "(if sign(s - 0.5)*s > 0.25 then 1 else 0)": "(if s > 0.5 or s < -0.25 then 1 else 0)",
    "max(mod(s, 0.7) - 0.3, 0)": "(if mod(s, 0.7) > 0.3 then mod(s, 0.7) - 0.3 else 0)",
    "abs(mod(s, 0.7) - 0.3)": "(if mod(s, 0.7) > 0.3 then mod(s, 0.7) - 0.3 else 0.3 - mod(s, 0.7))",
    "(if mod(floor(4*s), 2) == 0 then 1 else -1)": "(if mod(s, 0.5) < 0.25 then 1 else -1)",
    "mod(floor(6*s), 2)": "(if mod(3*s, 1) < 0.5 then 0 else 1)",
    "floor(floor(5*s)/2)": "floor(5*s/2)",
    "(if atan2(sin(s + 3), cos(s + 3)) > 2 then 1 else -1)": "(if s > -1 and s < 0.1415926535897932 then 1 else -1)",  # its cut
    "(if (if s > 0 then c.v else abs(c.v)) > 0.5[m/s] then 1 else -1)":  # which are the same where v is positive
        "(if s > 0 and c.v < 0.5[m/s] or s <= 0 and c.v < 0.5[m/s] and c.v > -0.5[m/s] then -1 else 1)",
}


@pytest.mark.parametrize("force", SAME)
def test_forces_jump_where_their_conditions_do(scene: Write, force: str) -> None:
    """mod(3 s, 1) > 0.5 was 0.09 m off by the series, 0.5 m by all others."""
    at = np.linspace(0.25, 3, 12)
    right = scene(PUSHED.format(force=SAME[force])).simulate(at=at, tolerance=1e-10)["c.s"]
    model = scene(PUSHED.format(force=force))
    for solver in ("auto", "erk9", "implicit"):
        assert model.simulate(at=at, tolerance=1e-10, solver=solver)["c.s"] == pytest.approx(right, abs=1e-8), solver


def test_no_step_passes_two_whole_numbers(scene: Write) -> None:
    """Where 6 s went from 4 to 1.5 in a step of sweeps, floor(6 s) was odd at its end as in it: off by 1."""
    force = "(if mod(floor(6*s), 2) == 0 then 1 else -1)"
    model = scene(PUSHED.format(force=force).replace("2*c.s^2", "1*c.s^2"))
    start = {"c.s": 0.9233143873275735, "der(c.s)": 0.8991597630941346}
    right, found = (model.simulate(at=np.linspace(0, 4, 41), tolerance=1e-12, solver=solver, initial=start)
                    for solver in ("erk9", "pirk"))
    assert len(found.events) == len(right.events) == 17
    assert found["c.s"] == pytest.approx(right["c.s"], abs=1e-10)


@pytest.mark.parametrize("solver", ["erk", "erk5", "erk9", "pirk"])
def test_stairs_that_go_by_ever_faster(scene: Write, solver: str) -> None:
    """Steps came to pass two of them in their narrowest parts, or were taken for shaking: off by 10^3 tolerances."""
    model = scene("""model Stairs
      World world(gravity = {0, 0});
      Block c(m = 1, base = world, v(start = 0.1));
    energy
      potential -8[N/m]*c.s^2;
      work 300[N]*mod(floor(20[1/m]*c.s), 2) on c.s;
    end Stairs;""")
    run = model.simulate(at=[1.7], tolerance=1e-8, solver=solver)
    s, v = run["c.s"][-1], run["c.v"][-1]
    count = floor(20 * s)
    assert run.statistics.events >= count > 10_000
    odd = count // 2 / 20 + (s - count / 20) * (count % 2)
    assert v**2 == pytest.approx(0.1**2 + 16 * s**2 + 600 * odd, rel=1e-10)


def test_forces_of_numbers_that_are_equal_for_a_while_are_refused(scene: Write) -> None:
    for force in ("sign(floor(s))", "(if floor(s) > 0 then 1 elseif floor(s) >= 0 then 2 else 3)"):
        with pytest.raises(lag.LagError, match="L0914") as caught:
            assert scene(PUSHED.format(force=force)).scene
        assert "work" in str(caught.value)
