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


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("rows", [[1.0, 2.0], [0.5, 2.0], [1.025, 2.05]])
def test_what_comes_where_a_rate_is_found_to_be_exactly_zero(scene: Write, rows: list[float], solver: str) -> None:
    """A step to 0.5 s left v = 0, where abs(v) <= 0 was held without an event; as rows fell."""
    run = scene("""model Scene World world(gravity = {0, 0}); Block b(m = 1, base = world, v(start = 2));
      DryFriction f(rate = b.v, F = 4);
      Boolean moves = abs(b.v) > 0; discrete Integer n(start = 0), k(start = 0), l(start = 0); discrete Real at(start = 0);
    equation
      when edge(abs(b.v) <= 0) then n = pre(n) + 1; at = time; end when;
      when change(moves) then k = pre(k) + 1; end when;
      when b.v^2 <= 0 then l = pre(l) + 1; end when; end Scene;""").simulate(at=rows, tolerance=1e-9, solver=solver)
    assert [run[x][-1] for x in "nkl"] == [1, 1, 1]
    assert run["at"][-1] == pytest.approx(0.5, rel=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("condition", "right"), [
    ("b.v < 0", 0.2), ("change(back)", 0.2), ("b.v < c.v", 0.15), ("b.s < 0.1", 0.2 + 0.1**0.5)])
def test_what_comes_where_forces_turn_round(scene: Write, condition: str, right: float, solver: str) -> None:
    """Friction, or a step of a force, changes at the very level, and holds nothing there: the event never came."""
    run = scene("model Scene World world(gravity = {0, 0}); Block b(m = 1, base = world, v(start = 2)), c(m = 1, base = world, "
                "v(start = 0.5)); DryFriction f(rate = b.v, F = 4), g(rate = b.v - c.v, F = 1e-9); Boolean back = b.v < 0; "
                "AppliedForce p(at = b.center, force = {-6, 0}), q(at = b.center, force = {if b.s > 0.1 then -1e-9 else 0, 0}); "
                "discrete Integer n(start = 0); discrete Real at(start = 0); "
                f"equation when {condition} then n = pre(n) + 1; at = time; end when; end Scene;").simulate(
                    at=[1.0, 2.0], tolerance=1e-9, solver=solver)
    assert run["n"][-1] == 1
    assert run["at"][-1] == pytest.approx(right, rel=1e-8)
