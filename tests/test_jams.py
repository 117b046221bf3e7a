"""Friction that jams: where sticking is the only answer, at rest and in impacts, and every force that slides would pull."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.native import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
G = 9.81

ROCKING = """model Rocking "a block is tilted and let go on a floor so rough that it does not slide; plastic impacts"
  parameter Length b = 0.25, h = 1; parameter Real mu = 2; parameter Angle lean = 5[deg];
  Body block(m = 3, I = 3*(b^2 + h^2)/3);
  Frame A = shift(block.center, {-b, -h}), B = shift(block.center, {b, -h});
  RoughStop fa(mu = mu, gap = A.y, slip = A.v[1]), fb(mu = mu, gap = B.y, slip = B.v[1]);
initial equation
  block.center.phi = -lean; B.y = 0; B.x = b;
end Rocking;"""


def rocking_on_paper(end: float, b: float, h: float, lean: float) -> tuple[float, float]:
    """phi and w: it turns about one corner after the other, and each impact leaves 1 - 3/2 sin^2 of its rate (G.W. Housner, The
    behavior of inverted pendulum structures during earthquakes, Bull. Seismol. Soc. Am. 53 (1963))."""
    R, corner, side, t, state = np.hypot(b, h), np.arctan2(b, h), -1.0, 0.0, [lean, 0.0]
    left = 1 - 1.5 * np.sin(corner) ** 2

    def down(t: float, y: np.ndarray) -> float:
        return float(y[0])

    down.terminal, down.direction = True, -1  # type: ignore[attr-defined]
    while left > 0 and (t == 0 or abs(state[1]) > 1e-12):
        run = solve_ivp(lambda t, y: [y[1], -0.75 * G / R * np.sin(corner - y[0])], (t, end), state, method="DOP853",
                        rtol=1e-13, atol=1e-15, events=down)
        t, (phi, w) = run.t[-1], run.y[:, -1]
        if run.status == 0:
            return side * phi, side * w
        side, state = -side, [0.0, -left * w]
    return 0.0, 0.0


@pytest.mark.parametrize(("b", "h", "mu"), [(0.25, 1, 1.6), (0.25, 1, 1.7), (0.25, 1, 2.0), (0.25, 1, 50.0), (0.05, 2, 5.0),
                                            (0.5, 1, 1.2), (1, 1, 2.0), (2, 1, 4.0)])
def test_a_block_rocks_on_a_rough_floor(b: float, h: float, mu: float, scene: Write) -> None:
    """With mu b h/I > 1/m + b^2/I no impulse that slides pushes: events without end. A squat one stays where it falls."""
    model, lean = scene(ROCKING), 0.4 * np.arctan2(b, h)
    wanted = rocking_on_paper(1.5, b, h, lean)
    for solver in ("auto", "erk", "implicit"):
        for tolerance in (1e-5, 1e-10):
            run = model.simulate(at=[0.7, 1.5], solver=solver, tolerance=tolerance,
                                 parameters={"b": b, "h": h, "mu": mu, "lean": lean})
            found = run["block.center.phi"][-1], run["block.center.w"][-1]
            np.testing.assert_allclose(found, wanted, rtol=0, atol=20 * tolerance)


STANCE = """model StanceLeg "a hub on one massless leg that stands on a rough floor: it turns about its foot without slip"
  parameter Real mu = 0.5; parameter Inertia I = 1e-5;
  Body hub(m = 1, I = I);
  Frame foot = shift(hub.center, {0, -1});
  RoughStop ground(mu = mu, gap = foot.y, slip = foot.v[1]);
  output Length away = foot.x;
initial equation
  hub.center.phi = 0; foot.x = 0; foot.y = 0;
  hub.center.w = -1.5; hub.center.v[1] = 1.5; hub.center.v[2] = 0;
end StanceLeg;"""


@pytest.mark.parametrize("I", [1.0, 1e-3, 1e-5, 1e-7])
@pytest.mark.parametrize("at", [[0.1, 0.2], np.linspace(0, 0.2, 41)[1:]], ids=["few", "many"])
def test_a_leg_of_little_inertia_stands(I: float, at: list[float], scene: Write) -> None:
    """H/N < 0.33: it turns as a pendulum does. A force that is usual in rates is a millionth of the one that holds; what slides
    jams."""
    pendulum = solve_ivp(lambda t, y: [y[1], G / (1 + I) * np.sin(y[0])], (0, 0.2), [0, -1.5], method="DOP853",
                         rtol=1e-13, atol=1e-15)
    model = scene(STANCE)
    for solver in ("auto", "erk", "implicit"):
        for tolerance in (1e-5, 1e-9, 1e-12):
            run = model.simulate(at=at, solver=solver, tolerance=tolerance, parameters={"I": I}, max_steps=2000)
            found = run["hub.center.phi"][-1], run["hub.center.w"][-1], run["away"][-1]
            np.testing.assert_allclose(found, [*pendulum.y[:, -1], 0], rtol=0, atol=max(20 * tolerance, 1e-15 / I))
