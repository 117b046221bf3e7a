"""Conditions on inputs and functions of time that stay on a level for a while."""

from collections.abc import Callable

import numpy as np
import pytest
from numpy.typing import NDArray

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk5", "implicit")
SLIDES = "World world(gravity = {0, 0}); Block b(m = 1, base = world, v(start = 1)); energy work -(%s)*1[N] on b.s; end M;"

LAWS: dict[str, Callable[[NDArray[np.float64]], NDArray[np.float64]]] = {
    "if u > 0 then 1 else 0": lambda u: u > 0, "if u >= 0 then 1 else 0": lambda u: u >= 0,
    "if 0 > u then 1 else 0": lambda u: u < 0, "sign(u)": np.sign, "sign(sign(2*u))": np.sign,
    "if u == 0 then 1 else 0": lambda u: u == 0,
    "if u > 0 then 1 elseif u < 0 then 0.5 else 2": lambda u: 2 - (u > 0) - 1.5 * (u < 0),
    "floor(u) + ceil(u)": lambda u: np.floor(u) + np.ceil(u), "if mod(u, 2) >= 1 then 1 else 0": lambda u: u % 2 >= 1,
}
WAYS = {"still": ([0, 9], [0, 0]), "there and on": ([0, 1, 1.5, 2.5, 9], [1, 0, 0, -1, -1]), "back": ([0, 1, 2, 9], [1, 0, 1, 1]),
        "whole": ([0, 1, 2, 2.5, 3, 9], [1, 1, 2, 2, 1.5, 1.5])}


def pushed(law: str, way: str, end: float) -> float:
    """x = end - integral of (end - t) F(u(t)), by pieces between whole numbers."""
    times, values = (np.array(x, float) for x in WAYS[way])
    fine = np.linspace(0, end, 161)  # all whole numbers are passed at multiples of 1/40
    nodes, weights = np.polynomial.legendre.leggauss(2)
    t = (fine[:-1, None] + (fine[1] - fine[0]) * (nodes + 1) / 2).ravel()
    w = np.tile(weights, 160) * (fine[1] - fine[0]) / 2
    return float(end - (w * (end - t) * 0.1 * LAWS[law](np.round(np.interp(t, times, values), 12))).sum())


@pytest.mark.parametrize("law", LAWS)
def test_inputs_that_stay_on_a_level(law: str, scene: Write) -> None:
    """A force of 0.1 (if u > 0 ...) acted at u = 0, and 0.1 sign(u) was -0.1 there."""
    model = scene(f"model M input Real u; {SLIDES % f'0.1*({law})'}")
    for way, (times, values) in WAYS.items():
        for solver in SOLVERS:
            run = model.simulate(at=[0.0, 4.0], inputs=(times, {"u": values}), solver=solver, tolerance=1e-8)
            assert run["b.s"][-1] == pytest.approx(pushed(law, way, 4.0), abs=1e-7), (way, solver)
        if way == "still":
            assert model.simulate(at=[0.0, 4.0], inputs={"u": 0.0})["b.s"][-1] == pytest.approx(pushed(law, way, 4.0), abs=1e-7)


@pytest.mark.parametrize("law", ["if u > 0 then 1 else 0", "sign(u)"])
def test_functions_of_time_that_stay_on_a_level(law: str, scene: Write) -> None:
    """v falls by 0.5 m/s^2 until t = 0.5, stays, and falls again from t = 1 on (1.1875 m for 1.375)."""
    model = scene(f"model M Real u = max(0, abs(time - 0.75) - 0.25); {SLIDES % f'0.5*({law})*sign(b.v)'}")
    for solver in SOLVERS:
        run = model.simulate(at=[0.0, 0.5, 1.0, 5.0], solver=solver, tolerance=1e-6)
        assert run["b.s"][1:] == pytest.approx([0.4375, 0.8125, 1.375], abs=1e-5), solver


@pytest.mark.parametrize(("law", "sign"), [
    ("sign(u*b.v)", np.sign), ("if -2*b.v*u >= 0 then 1 else 0", lambda u: u <= 0),
    ("if u*b.s > 0 then 1 else 0", lambda u: u > 0), ("sign(sign(u)*b.v)", np.sign),
    ("sign(floor(u)*b.v)", lambda u: min(u, 0)), ("sign((if u > 0 then 1 else -1)*b.v)", lambda u: 1 if u > 0 else -1)])
def test_products_of_inputs_and_rates(law: str, sign: Callable[[float], float], scene: Write) -> None:
    """sign(u v) is 0 while u is, whichever way v goes: it was 1 (2.6 m for 3), or what it had been."""
    model = scene(f"model M input Real u; {SLIDES % f'0.2*({law})'}")
    for way, (first, second) in {(0.0, 0.0): (0, 0), (1.0, 0.0): (1, 0), (-1.0, 0.0): (-1, 0)}.items():
        times, values = [0, 1, 9], [way[0], way[1], way[1]]
        want = 2 - 0.2 * (1.5 * sign(first) + 0.5 * sign(second))
        for solver in (*SOLVERS, "taylor"):
            run = model.simulate(at=[0.0, 2.0], inputs=(times, {"u": values}), solver=solver, tolerance=1e-8)
            assert run["b.s"][-1] == pytest.approx(want, abs=1e-7), (way, solver)


def test_friction_with_a_factor_that_vanishes(scene: Write) -> None:
    """What 0.3 sign(u v) holds against 0.1 N goes while u is 0, between 1 s and 2 s, and stops again."""
    model = scene("model M input Real u; World world(gravity = {0, 0}); Block b(m = 1, base = world); "
                  "energy work (0.1 - 0.3*sign(u*b.v))*1[N] on b.s; end M;")
    for solver in SOLVERS:
        run = model.simulate(at=[1.0, 2.0, 3.0], inputs=([0, 1, 2, 3], {"u": [1, 0, 0, 1]}), solver=solver, tolerance=1e-8)
        assert run["b.s"] == pytest.approx([0, 0.05, 0.075], abs=1e-7)
