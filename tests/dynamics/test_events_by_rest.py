"""Events that come by what friction is found to hold: they are struck before the rest that follows is passed."""

from collections.abc import Callable, Mapping

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "erk9", "pirk", "implicit", "taylor")
SCENES: Mapping[str, tuple[str, Mapping[str, float]]] = {
    "by an edge": ("""Block b(m = 1, base = world, v(start = 2)), c(m = 1, base = world); DryFriction f(rate = b.v, F = 4);
      discrete Integer n(start = 0); discrete Real at(start = 0);
    equation
      when edge(abs(b.v) <= 0) then n = pre(n) + 1; at = time; reinit(c.v, 1); end when;""",
                   {"n": 1, "at": 0.5, "b.s": 0.5, "c.s": 1.55}),
    "by a change": ("""Block b(m = 1, base = world, v(start = 2)), c(m = 1, base = world); DryFriction f(rate = b.v, F = 4);
      Boolean still = abs(b.v) <= 0; discrete Integer n(start = 0), k(start = 0);
    equation
      when change(still) then n = pre(n) + 1; end when;
      when n == 1 then k = pre(k) + 1; reinit(c.v, 1); end when;""", {"n": 1, "k": 1, "c.s": 1.55}),
    "which loads another": ("""Block b(m = 1, base = world, v(start = 2)), c(m = 1, base = world); discrete Force T(start = 0);
      DryFriction f(rate = b.v, F = 4), g(rate = c.v, F = 1); AppliedForce push(at = c.center, force = {T, 0});
      discrete Integer n(start = 0), k(start = 0);
    equation
      when abs(b.v) <= 0 then n = pre(n) + 1; T = 3; end when;
      when edge(c.v > 0) then k = pre(k) + 1; end when;""", {"n": 1, "k": 1, "c.s": 1.55**2}),
    "after a push": ("""Block b(m = 1, base = world); DryFriction f(rate = b.v, F = 4); discrete Integer n(start = 0);
      discrete Real at(start = 0);
      AppliedForce push(at = b.center, force = {if time > 0.5 and time < 0.7 then 5 else 1, 0});
    equation
      when abs(b.v) <= 0 then n = pre(n) + 1; at = time; end when;""", {"n": 1, "at": 0.7 + 0.2 / 3, "b.s": 0.02 * 4 / 3}),
    "again and again": ("""Block b(m = 1, base = world); DryFriction f(rate = b.v, F = 2); discrete Integer n(start = 0);
    equation
      when time > 0.2 then reinit(b.v, 0.2); end when;
      when abs(b.v) <= 0 then n = pre(n) + 1; reinit(b.v, 0.2); end when;""", {"n": 18, "b.s": 0.01 * 18 + 0.2 * 0.05 - 0.05**2}),
}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", SCENES)
def test_what_comes_by_rest(scene: Write, name: str, solver: str) -> None:
    """No event came: the rest began, and its step was recorded over them."""
    text, right = SCENES[name]
    run = scene(f"model Scene World world(gravity = {{0, 0}}); {text} end Scene;").simulate(
        at=[1.0, 2.05], tolerance=1e-10, solver=solver)
    np.testing.assert_allclose([run[x][-1] for x in right], list(right.values()), rtol=1e-9)
