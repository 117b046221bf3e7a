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
