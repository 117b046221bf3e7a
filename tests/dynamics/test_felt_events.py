"""Friction that feels reactions, in scenes with events that reset rates."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.base.diagnostics import LagError

Write = Callable[[str], lag.Model]
G = 9.81

PENDULUM = """model Pendulum
  RoughRevolute hinge(a = world, mu = 0.2, radius = 0.05, phi(start = 0.5), w(start = 8));
  Bar bar(m = 2, L = 1, a = hinge.b);
equation
  when hinge.phi > 2 then reinit(hinge.w, -1.5); end when;
end Pendulum;"""


def newton_euler(_: float, y: np.ndarray) -> list[float]:
    """Of the bar: its pin carries m (g - a), and rubs with 0.2 times 0.05 of that, which is solved for by iteration."""
    phi, w = y
    m, h, J, rub = 2.0, 0.5, 2 / 3, 0.0
    for _ in range(60):
        turn = (-m * G * h * np.cos(phi) - rub * np.sign(w)) / J
        force = m * (h * turn * np.array([-np.sin(phi), np.cos(phi)]) - h * w**2 * np.array([np.cos(phi), np.sin(phi)])
                     + np.array([0, G]))
        rub = 0.01 * np.hypot(*force)
    return [w, turn]


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_a_pendulum_that_is_struck(scene: Write, solver: str) -> None:
    def at_2(_: float, y: np.ndarray) -> float:
        return y[0] - 2

    at_2.terminal, at_2.direction = True, 1  # type: ignore[attr-defined]
    first = solve_ivp(newton_euler, (0, 1), [0.5, 8.0], rtol=1e-11, atol=1e-12, events=at_2)
    second = solve_ivp(newton_euler, (first.t[-1], 0.6), [2.0, -1.5], rtol=1e-11, atol=1e-12)
    run = scene(PENDULUM).simulate(at=[0.6], solver=solver, tolerance=1e-10)
    assert run["hinge.phi"][-1] == pytest.approx(second.y[0, -1], abs=3e-9)
    assert run["hinge.w"][-1] == pytest.approx(second.y[1, -1], abs=3e-8)


def test_a_block_that_bounces_along_its_guide(scene: Write) -> None:
    """Down against mu m g cos, back with half of its speed, and up with it: the guide takes no impulse."""
    run = scene("""model Slope
      RoughPrismatic guide(a = world, along = {cos(0.5), sin(0.5)}, mu = 0.2, s(start = 1));
      PointMass m(m = 2, center = guide.b);
    equation
      when guide.s < 0 then reinit(guide.v, -0.5*pre(guide.v)); end when;
    end Slope;""").simulate(at=[3.0], tolerance=1e-10)
    down, up = G * (np.sin(0.5) - 0.2 * np.cos(0.5)), G * (np.sin(0.5) + 0.2 * np.cos(0.5))
    s, v, t = 1.0, 0.0, 0.0
    while True:
        fall = np.sqrt(2 * s / down)
        if t + fall > 3:
            assert run["guide.s"][-1] == pytest.approx(s - down * (3 - t) ** 2 / 2, abs=1e-8)
            return
        t, v = t + fall, 0.5 * down * fall
        if t + v / up > 3:
            assert run["guide.s"][-1] == pytest.approx(v * (3 - t) - up * (3 - t) ** 2 / 2, abs=1e-8)
            return
        t, s = t + v / up, v**2 / (2 * up)
        if s < 1e-12:
            assert run["guide.s"][-1] == pytest.approx(0, abs=1e-8)
            return


CRANK = """model SliderCrank
  RoughRevolute crank(a = world, radius = 0.05, mu = 0.3, phi(start = 0.3, fixed = true), w(start = 5, fixed = true));
  Bar arm(m = 2, L = 0.3, a = crank.b);
  RoughRevolute pin(a = arm.b, radius = 0.03, mu = 0.2);
  Bar rod(m = 1, L = 0.8, a = pin.b);
  RoughPrismatic guide(a = world, mu = 0.1, s(start = 1));
  Revolute wrist(a = guide.b, b = rod.b);
  PointMass piston(m = 1.5, center = guide.b);
  AppliedTorque drive(on = arm.a, torque = 8);
equation
  when EVENT end when;
end SliderCrank;"""


@pytest.mark.parametrize(("event", "w"), [("time > 0.5 then reinit(crank.w, 3);", 3.0),
                                          ("time > 0.5 then reinit(guide.v, -0.4);", None)])
def test_all_rates_of_a_slider_crank_are_set(scene: Write, event: str, w: float | None) -> None:
    """It goes on as one does that begins there; what a reset of the piston makes of the crank follows from the loop alone."""
    run = scene(CRANK.replace("EVENT", event)).simulate(at=[0.5 - 1e-12, 0.5 + 1e-9, 1.2], tolerance=1e-10)
    phi, s = float(run["crank.phi"][0]), float(run["guide.s"][0])
    x = 0.3 * np.cos(phi)
    slope = -0.3 * np.sin(phi) - 0.3 * np.sin(phi) * x / (s - x)  # ds/dphi where (s - x)^2 + (0.3 sin phi)^2 = 0.8^2
    w = w if w is not None else float(-0.4 / slope)
    assert run["crank.w"][1] == pytest.approx(w, abs=1e-7)
    free = CRANK.replace("EVENT", "time > 9 then reinit(crank.w, 3);").replace("start = 0.3,", f"start = {phi!r},").replace(
        "w(start = 5", f"w(start = {w!r}").replace("s(start = 1)", f"s(start = {s!r})")
    rest = scene(free).simulate(at=[0.7], tolerance=1e-10)
    assert run["crank.phi"][-1] == pytest.approx(rest["crank.phi"][-1], abs=1e-8)


@pytest.mark.parametrize(("text", "why"), [
    (CRANK.replace("EVENT", "guide.s < 0.6 then reinit(guide.v, -pre(guide.v));"), "rest at a contact that loads them"),
    ("""model M
      RoughRevolute one(a = world, radius = 0.1, mu = 0.2), two(a = bar.b, radius = 0.1, mu = 0.2);
      Bar bar(m = 1, L = 1, a = one.b), other(m = 1, L = 1, a = two.b);
    equation
      when one.phi < -1 then reinit(one.w, 1); end when;
    end M;""", "leaves its rate open")])
def test_impulses_that_would_rub_are_refused(scene: Write, text: str, why: str) -> None:
    with pytest.raises(LagError, match=why):
        scene(text).simulate(at=[1.0])
