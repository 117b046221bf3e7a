"""Loops of space whose cut joint keeps coordinates of its own, beside what they do not act on."""

import numpy as np
import pytest

import lagrangia as lag

WORLD = "World world(gravity = {0, 0, -9.81});"
BESIDE = "Revolute z(a = world, axis = {0, 1, 0}, phi(start = 1)); Body d(m = 2, I = {1, 1, 1}, center = shift(z.b, {1, 0, 0}));"
LOOP = """model Loop
  %s
  Universal h[6]; Body b[6](each m = 1, each I = {0.1, 0.2, 0.3});
  Universal c(a = shift(world, {1.5, 0, 0})); Revolute e(axis = {1, 0, 0});
equation
  connect(h[1].a, world);
  for i in 1:6 loop connect(b[i].center, shift(h[i].b, {0.15, 0, 0})); end for;
  for i in 1:5 loop connect(shift(h[i].b, {0.3, 0, 0}), h[i+1].a); end for;
  connect(shift(h[6].b, {0.3, 0, 0}), e.a);
  connect(e.b, c.b);
end Loop;"""


def test_a_loop_along_the_tree_moves_as_without_them() -> None:
    both, alone = lag.loads(LOOP % (WORLD + BESIDE)), lag.loads(LOOP % WORLD)
    right = both.simulate(at=[0, 0.3])
    names = [name for name in right.names if not name.startswith(("der", "z.", "time"))]
    run = alone.simulate(at=[0, 0.3], initial={name: float(right[name][0]) for name in names})
    for name in names:
        np.testing.assert_allclose(run[name], right[name], atol=1e-7)


@pytest.mark.parametrize("others", ["", "Block block(m = 1, base = world);"])
def test_a_loop_that_nothing_moves(others: str) -> None:
    """All that is there has rows of its own: no constraint is left for others."""
    run = lag.loads(f"model M {others} Universal c(a = world, b = world); end M;").simulate(at=[1])
    assert run["c.phi_a"][0] == run["c.phi_b"][0] == 0


FOUR_BAR = """
  Revolute turning(a = world, phi(start = 0), w(start = 8));
  Body crank(m = 1, I = {0.001, 0.02, 0.02}, center = shift(turning.b, {0.15, 0, 0}));
  Revolute rocking(a = shift(world, {0.9, 0.5, 0.2}), axis = {0, 1, 0}, phi(start = -1.6));
  Body rocker(m = 1.5, I = {0.001, 0.05, 0.05}, center = shift(rocking.b, {0.3, 0, 0}));
  Spherical near(a = shift(turning.b, {0.3, 0, 0}), S(start = angles("zyx", 40[deg], -45[deg], 0)));
  Body rod(m = 2, I = {0.002, 0.2, 0.2}, center = shift(near.b, {0.55, 0, 0}));
  Spherical far(a = shift(near.b, {1.1, 0, 0}), b = shift(rocking.b, {0.6, 0, 0}));"""
COIN = """
  Disc disc(m = 2, r = 0.25, center(Q(start = angles("zxz", 0, 1.05, 0), fixed = true), x(start = 0), y(start = 0),
    omega(start = {0, 1.3, -8})));
  RollingDisc rolling(r = 0.25, base = world, center = disc.center);"""


@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
def test_what_rolls_beside_a_loop_moves_as_without_it(solver: str) -> None:
    """Its rates are tied, not its places: the loop's constraints are not the first ones alone ("Out of bounds error" before)."""
    alone, both = (lag.loads(f"model A {WORLD}{COIN}{loop} end A;") for loop in ("", FOUR_BAR))
    run, right = both.simulate(at=[0, 0.5, 1], tolerance=1e-11, solver=solver), alone.simulate(at=[0, 0.5, 1], tolerance=1e-12)
    for name in (f"disc.center.{x}" for x in ("x", "y", "z", "S[1]", "S[2]", "S[3]", "S[4]")):
        assert run[name] == pytest.approx(right[name], abs=1e-9)


def test_rates_that_are_tied_beside_a_loop() -> None:
    """u' = y y' beside a loop in space: u - y^2/2 stays, and (2 + 3 y^2) y'^2 + 20 y^2 with it."""
    run = lag.loads(f"""model Tied {WORLD}{FOUR_BAR}
  coordinate Real y(start = 0.3), u(start = 0.1);
equation
  der(u) = y*der(y);
energy
  kinetic 2*der(y)^2/2 + 3*der(u)^2/2;
  potential 20*y^2/2;
end Tied;""").simulate(at=[0, 0.5, 1, 2], tolerance=1e-11)
    y, rate = run["y"], run["der(y)"]
    assert run["u"] == pytest.approx(0.1 + (y**2 - 0.09) / 2, abs=1e-10)
    assert (2 + 3 * y**2) * rate**2 + 20 * y**2 == pytest.approx(1.8, abs=1e-9)
    assert np.ptp(y) > 0.1
