"""Forces that jump or bend at known times: the integrator stops exactly there, so a mass of 1 kg moves as on paper.

s'' = F(t) from rest: v is the area under F.
"""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag

EXACT = 1e-11
Pushed = Callable[[str], lag.Model]


@pytest.fixture
def pushed(tmp_path: Path) -> Pushed:
    """A block of 1 kg under a force, given as an expression of time."""

    def write(force: str) -> lag.Model:
        path = tmp_path / "pushed.lag"
        path.write_text(f"""
            model Pushed
              parameter Time T = 1;
              Block block(m = 1, base = world);
              AppliedForce push(at = block.center, force = {{{force}, 0}});
            end Pushed;""")
        return lag.load(path)

    return write


def area(t: np.ndarray, corners: list[float], values: list[float]) -> np.ndarray:
    """The integral from 0 to t of straight lines between the corners, held beyond the last one; a jump has two values."""
    x, y = np.array([*corners, 1e3]), np.array([*values, values[-1]])
    at_corners = np.concatenate([[0], np.cumsum(np.diff(x) * (y[1:] + y[:-1]) / 2)])
    k = np.searchsorted(x, t, side="right") - 1
    slope = (y[k + 1] - y[k]) / (x[k + 1] - x[k])
    return at_corners[k] + (t - x[k]) * (y[k] + slope * (t - x[k]) / 2)


FORCES = {
    "step(time - 0.5)": ([0, 0.5, 0.5], [0, 0, 1]),
    "3*pulse(time, 0.3, 0.4)": ([0, 0.3, 0.3, 0.7, 0.7], [0, 0, 3, 3, 0]),
    "2*ramp(time, 0.25, 1.5)": ([0, 0.25, 1.75], [0, 0, 2]),
    "table(time, {0, 1, 1.5, 3}, {0, 2, -1, 0.5})": ([0, 1, 1.5, 3], [0, 2, -1, 0.5]),
    "if time < T/3 then 2 elseif 2*time - 1 <= T then -1 else 0": ([0, 1 / 3, 1 / 3, 1, 1], [2, 2, -1, -1, 0]),
    "floor(2*time)": ([0, *np.repeat(np.arange(0.5, 4, 0.5), 2)], [0, *np.repeat(np.arange(8), 2)[1:-1]]),
    "step(time - 0.3)*step(0.7 - time) + step(time - 0.3)": ([0, 0.3, 0.3, 0.7, 0.7], [0, 0, 2, 2, 1]),
}


@pytest.mark.parametrize("force", FORCES)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-12])
def test_the_velocity_is_the_area_under_the_force(pushed: Pushed, force: str, tolerance: float) -> None:
    """At a coarse tolerance too: each piece is a polynomial, which the method integrates exactly."""
    t = np.linspace(0, 4, 81)
    run = pushed(force).simulate(at=t, tolerance=tolerance)
    np.testing.assert_allclose(run["block.v"], area(t, *FORCES[force]), rtol=0, atol=EXACT)


@pytest.mark.parametrize("force", ["if sign(time - T) > 0 then 2 else 1", "max(1, 2[N]*sign(time - T))"])
def test_a_jump_hidden_in_a_function_holds_to_tolerance(pushed: Pushed, force: str) -> None:
    """A slope of zero does not make it constant."""
    t = np.linspace(0, 3, 31)
    run = pushed(force).simulate(at=t, tolerance=1e-9)
    np.testing.assert_allclose(run["block.v"], t + np.maximum(t - 1, 0), rtol=0, atol=1e-7)


def test_the_place_of_a_jump_follows_its_parameter(pushed: Pushed) -> None:
    model = pushed("step(time - T)")
    for T in (0.5, 2 / 3):
        run = model.simulate(at=[3], parameters={"T": T})
        assert run["block.s"][0] == pytest.approx((3 - T) ** 2 / 2, abs=EXACT)


def test_a_pulse_train_over_fifty_periods(pushed: Pushed) -> None:
    period, width, start = 0.7, 0.2, 0.1
    t = np.linspace(0, 50 * period, 501)
    run = pushed(f"pulse_train(time, {start}, {width}, {period})").simulate(at=t)
    whole, part = np.divmod(np.maximum(t - start, 0), period)
    np.testing.assert_allclose(run["block.v"], whole * width + np.minimum(part, width), rtol=0, atol=EXACT)
    assert run.statistics.events >= 100


def test_a_pulse_train_of_ones_own_holds_to_tolerance(pushed: Pushed) -> None:
    """Its ends depend on the number of the period, so they are not computed ahead."""
    t = np.linspace(0, 5, 51)
    run = pushed("if mod(time, T/2) < 0.2 then 1 else 0").simulate(at=t, tolerance=1e-9)
    whole, part = np.divmod(t, 0.5)
    np.testing.assert_allclose(run["block.v"], whole * 0.2 + np.minimum(part, 0.2), rtol=0, atol=1e-7)


def test_a_condition_that_is_not_affine_in_time_holds_to_tolerance(pushed: Pushed) -> None:
    """1 while sin 3t is positive: no crossing is computed ahead, so the steps get short there."""
    t = np.linspace(0, 6, 61)
    run = pushed("if sin(3*time) > 0 then 1 else 0").simulate(at=t, tolerance=1e-9)
    half = np.pi / 3
    whole, part = np.divmod(t, 2 * half)
    np.testing.assert_allclose(run["block.v"], whole * half + np.minimum(part, half), rtol=0, atol=1e-7)


def test_a_support_that_starts_to_move_carries_its_load(tmp_path: Path) -> None:
    """A support that starts to move at 0.5 s with acceleration 2 carries a mass on a spring, w = 10:

    z = s - x obeys z'' = -w^2 z - 2, so z = -(2/w^2)(1 - cos w tau).
    """
    path = tmp_path / "carried.lag"
    path.write_text("""
        model Carried
          Frame cart = shift(world, {if time < 0.5 then 0 else 1[m/s2]*(time - 0.5)^2, 0});
          Block block(m = 1, base = cart);
          Spring spring(k = 100, stretch = block.s);
        end Carried;""")
    t = np.linspace(0, 2, 41)
    tau = np.maximum(t - 0.5, 0)
    run = lag.load(path).simulate(at=t, tolerance=1e-12)
    np.testing.assert_allclose(run["block.s"], -0.02 * (1 - np.cos(10 * tau)), rtol=0, atol=EXACT)
    np.testing.assert_allclose(run["block.center.x"], tau**2 - 0.02 * (1 - np.cos(10 * tau)), rtol=0, atol=EXACT)


@pytest.mark.parametrize("more", ["", "discrete Integer k(start = 0); equation when edge(time > 1) then k = n + m; end when;"])
def test_counts_that_bring_each_other_about_end_by_themselves(more: str, tmp_path: Path) -> None:
    """In twenty rounds at 1 s, none of which changes a rate of what moves."""
    path = tmp_path / "counts.lag"
    declared, _, equation = more.partition("equation")
    path.write_text(f"""
        model Counts
          Block b(m = 1, base = world, v(start = 1));
          discrete Integer n(start = 0), m(start = 0); {declared}
        equation
          when time > 1 and n == m and n < 10 then n = pre(n) + 1; end when;
          when m < n then m = pre(m) + 1; end when;
          {equation}
        end Counts;""")
    run = lag.load(path).simulate(at=[0, 0.9, 1.1])
    assert (run["n"][1], run["n"][2], run["m"][2]) == (0, 10, 10)
