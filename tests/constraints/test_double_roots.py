"""Constraints that only just hold, as a rod exactly as long as the way can be: Phi and its slopes vanish together, everywhere."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]

PARALLEL = """model Parallel "The least distance of the tips keeps two hinged bars parallel"
  Revolute h1(a = world, phi(start = 40[deg])), h2(a = world, phi(start = {start}[deg]));
  Bar b1(m = 1, L = 1, a = h1.b), b2(m = 1, L = 2, a = h2.b);
  {tie}
end Parallel;"""
LINK = "Link l(a = b1.b, b = b2.b, L = 1);"
BARS = "Revolute h1(a = world, phi(start = 0.4)), h2(a = b1.b, phi(start = 0)); Bar b1(m = 1, L = 0.8, a = h1.b);"
STRAIGHT = {
    "link": BARS + "Bar b2(m = 1, L = 0.8, a = h2.b); Link tie(a = b1.a, b = b2.b, L = 1.6);",
    "loop": BARS + "Bar b2(m = 1, L = 0.8, a = h2.b), b3(m = 1, L = 1.6, a = h3.b);"
            "Revolute h3(a = world, phi(start = 0.4)), h4(a = b3.b, b = b2.b);",
    "three": BARS + "Bar b2(m = 0.625, L = 0.5, a = h2.b), b3(m = 0.375, L = 0.3, a = h3.b);"
             "Revolute h3(a = b2.b, phi(start = 0)); Link tie(a = b1.a, b = b3.b, L = 1.6);",
}
CART = """model OnCart Prismatic rail(a = world); Body cart(m = 2, I = 1, center = rail.b);
  Revolute h1(a = cart.center, phi(start = 0.4)); {bars}
  Revolute h3(a = {tip}, phi(start = -0.3)); Bar b3(m = 0.5, L = 0.7, a = h3.b);
end OnCart;"""


@pytest.mark.parametrize("solver", ["auto", "erk", "erk9", "pirk", "implicit", "adams"])
def test_bars_that_a_rod_keeps_parallel(scene: Write, solver: str) -> None:
    """phi" = -1.5 g/(5/3) cos phi, by DOP853 at 1e-13."""
    model = scene(PARALLEL.format(start=40, tie=LINK))
    run = model.simulate(at=[0.0, 1.0, 2.0], solver=solver, tolerance=1e-10)
    assert run["h1.phi"][1:] == pytest.approx([-2.6913255005, -3.1137802880], abs=3e-9)
    assert np.abs(run["h1.phi"] - run["h2.phi"]).max() < 1e-13
    assert model.freedom["degrees_of_freedom"] == model.freedom["degrees_at_start"] == 1


def test_starts_that_do_not_fit_are_moved(scene: Write) -> None:
    model = scene(PARALLEL.format(start=45, tie="equation (h1.phi - h2.phi)^2 = 0;"))
    run = model.simulate(at=[0.0, 1.0], tolerance=1e-11)
    assert run["h1.phi"][0] == pytest.approx(run["h2.phi"][0], abs=1e-13)
    assert run["h1.phi"][1] == pytest.approx(run["h2.phi"][1], abs=1e-12)


@pytest.mark.parametrize("how", sorted(STRAIGHT))
def test_bars_that_are_held_straight(scene: Write, how: str) -> None:
    """One bar of 1.6 m: phi" = -3 g/3.2 cos phi, by DOP853 at 1e-13."""
    model = scene(f"model Straight {STRAIGHT[how]} end Straight;")
    run = model.simulate(at=[0.0, 1.0], tolerance=1e-11)
    assert run["h1.phi"][1] == pytest.approx(-2.965546802515, abs=1e-9)
    assert abs(run["h2.phi"][1]) < 1e-13
    assert model.freedom["degrees_of_freedom"] == 1


def test_held_straight_in_a_larger_scene(scene: Write) -> None:
    bars = "Revolute h2(a = b1.b, phi(start = 0)); Bar b1(m = 1, L = 0.8, a = h1.b), b2(m = 1, L = 0.8, a = h2.b);"
    tied = scene(CART.format(bars=bars + "Link tie(a = b1.a, b = b2.b, L = 1.6);", tip="b2.b")).simulate(
        at=[0.0, 2.0], tolerance=1e-11)
    rigid = scene(CART.format(bars="Bar b1(m = 2, L = 1.6, a = h1.b);", tip="b1.b")).simulate(at=[0.0, 2.0], tolerance=1e-11)
    for name in ("rail.s", "h1.phi", "h3.phi"):
        assert tied[name][1] == pytest.approx(rigid[name][1], abs=1e-9)


def test_held_straight_while_it_is_driven(scene: Write) -> None:
    run = scene(f"model Driven {STRAIGHT['link']} Motion drive(of = h1.phi, to = 0.4 + sin(1[1/s]*time)); end Driven;").simulate(
        at=[0.0, 1.0, 2.0])
    assert np.abs(run["h2.phi"]).max() < 1e-13
    assert run["h1.phi"][2] == pytest.approx(0.4 + np.sin(2.0), abs=1e-12)


def test_other_parameters_let_it_go(scene: Write) -> None:
    """A longer rod is an ordinary constraint; a shorter one cannot be; other masses change nothing of that."""
    model = scene(PARALLEL.format(start=40, tie=LINK))
    longer = model.simulate(at=[0.0, 1.0], tolerance=1e-10, parameters={"l.L": 1.1})
    gap = np.exp(1j * longer["h1.phi"]) - 2 * np.exp(1j * longer["h2.phi"])
    assert np.abs(gap) == pytest.approx([1.1, 1.1], abs=1e-12)
    with pytest.raises(LagError, match="L0606"):
        model.simulate(at=[0.0, 1.0], parameters={"l.L": 0.9})
    heavy = model.simulate(at=[0.0, 1.0], parameters={"b1.m": 2, "b2.m": 2}, tolerance=1e-10)
    assert heavy["h1.phi"][1] == pytest.approx(-2.6913255005, abs=3e-9)
    sweep = model.simulate_many(parameters={"l.L": [1.0, 1.1]}, outputs="final(h2.phi)", stop=1.0, tolerance=1e-10, jobs=1)
    assert sweep["final(h2.phi)"][1] == pytest.approx(longer["h2.phi"][1], abs=1e-8)


def test_nothing_bounds_the_forces(scene: Write) -> None:
    text = PARALLEL.format(start=40, tie=LINK + " output Force F[2] = h1.reaction;")
    with pytest.raises(LagError, match=r"L0911.*only just holds"):
        scene(text)


def test_what_is_just_long_enough_stands_still(scene: Write) -> None:
    model = scene("model Taut Revolute h1(a = world, phi(start = 10[deg])), h2(a = b1.b, phi(start = -10[deg]));"
                  "Bar b1(m = 1, L = 1, a = h1.b), b2(m = 1, L = 1, a = h2.b);"
                  "Link l(a = shift(world, {3, 0}), b = b2.b, L = 1); end Taut;")
    run = model.simulate(at=[0.0, 1.0])
    assert max(np.abs(run["h1.phi"]).max(), np.abs(run["h2.phi"]).max()) < 1e-12
