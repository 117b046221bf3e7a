"""Adams' methods: accuracy, evaluations, rows, and where they give way to others."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.runtime import Solver
from runtime.test_stiffness import FLEXIBLE

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
ROOT = Path(__file__).parents[2]
EXAMPLES = ROOT / "models" / "examples"

DAMPED = FLEXIBLE.replace("n = 4", "n = 20").replace("= 1e6", "= 0").replace("= 1e3", "= 0.01")

HIDING = DAMPED.replace("equation\n", """
  AppliedTorque faint(on = link[1].a, torque = 1e-12[N.m]*tanh(hinge[1].phi));
equation
""", 1)


def positions(model: lag.Model, **settings: object) -> tuple[np.ndarray, lag.Trajectory]:
    run = model.simulate(**settings)  # type: ignore[arg-type]
    return run.rows[:, 1 : 1 + model.scene.n], run


@pytest.mark.parametrize(("name", "stop", "sizes"), [
    ("double_pendulum", 2, {}), ("pendulum", 10, {}), ("spring_pendulum", 5, {}), ("chain", 1, {"n": 17}), ("four_bar", 2, {}),
    ("andrews_squeezer", 0.03, {}), ("suspended_bar", 5, {})])
def test_a_tolerance_means_what_it_does_elsewhere_for_half_the_evaluations(name: str, stop: float, sizes: dict[str, int]) -> None:
    model = lag.load(EXAMPLES / f"{name}.lag", **sizes)
    at = np.linspace(stop / 10, stop, 10)
    exact, _ = positions(model, at=at, tolerance=1e-14, solver="erk")
    size = np.abs(exact).max()
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        found, run = positions(model, at=at, tolerance=tolerance, solver="adams")
        others, other = positions(model, at=at, tolerance=tolerance, solver="erk")
        assert run.statistics.solver is Solver.ADAMS
        assert np.abs(found - exact).max() < max(10 * tolerance * size, 3 * np.abs(others - exact).max())
        assert run.statistics.rhs_evaluations < 0.7 * other.statistics.rhs_evaluations
        assert run.statistics.energy_residual < max(1e3 * tolerance, 1e-13) * run.statistics.energy_scale


@pytest.mark.parametrize("name", ["cart_pole", "four_bar", "disc_and_block_damped"])
def test_rows_do_not_change_the_run(name: str) -> None:
    """They are read from the polynomial that the step has integrated; those of closed loops are projected."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    at = np.linspace(0, 2, 2001)
    many, run = positions(model, at=at, tolerance=1e-9, solver="adams")
    few, other = positions(model, at=[2], tolerance=1e-9, solver="adams")
    exact, _ = positions(model, at=at, tolerance=1e-13, solver="erk")
    assert run.statistics.steps == other.statistics.steps < 1000
    assert np.array_equal(many[-1], few[-1])
    assert np.abs(many - exact).max() < 2e-9
    assert run.statistics.constraint_residual < 1e-14


def test_tight_tolerances_reach_rounding() -> None:
    """Pendulum of 1 rad, a hundred periods and more: the energy tells."""
    run = lag.load(EXAMPLES / "pendulum.lag").simulate(stop=200, interval=1, tolerance=1e-14, solver="adams")
    assert run.statistics.rejected < 0.01 * run.statistics.steps
    assert run.statistics.energy_residual < 3e-13 * run.statistics.energy_scale


def test_auto_takes_them_where_equations_are_long(scene: Write) -> None:
    """Nearly exactly so: where something may hide in long steps (an exponential), or rows are many."""
    chain, short = (scene(HIDING.replace("n = 20", f"n = {n}")) for n in (25, 5))
    rope = lag.load(ROOT / "tests" / "benchmarks" / "scenes" / "rope.lag", n=25)
    pushed = scene(HIDING.replace("equation\n", """
      AppliedForce push(at = link[n].b, force = {if time < 0.1 then 1 else 0, 0});\nequation\n""", 1))

    def taken(model: lag.Model, tolerance: float) -> Solver:
        return model.simulate(stop=0.2, tolerance=tolerance).statistics.solver

    assert [taken(chain, tolerance) for tolerance in (1e-3, 1e-6, 1e-12)] == 3 * [Solver.ADAMS]
    assert Solver.ADAMS not in (taken(short, 1e-6), taken(rope, 1e-6), taken(pushed, 1e-6))
    both = [chain.simulate(stop=2, tolerance=1e-8, solver=solver).statistics.rhs_evaluations for solver in ("auto", "erk")]
    assert both[0] < 0.65 * both[1]


@pytest.mark.parametrize(("c", "k"), [(0, 0), (0.1, 0), (1, 0), (10, 0), (100, 0), (1e3, 0), (0.1, 1e5), (10, 1e5)])
def test_auto_leaves_them_where_stability_rules(scene: Write, c: float, k: float) -> None:
    """For methods that are stable for longer steps, and from there for implicit ones."""
    model = scene(HIDING)
    given = {"c": c, "k": k}
    exact, _ = positions(model, at=[1, 2], parameters=given, tolerance=1e-12)
    for tolerance in (1e-3, 1e-6):
        found, run = positions(model, at=[1, 2], parameters=given, tolerance=tolerance)
        _, other = positions(model, at=[1, 2], parameters=given, tolerance=tolerance, solver="erk")
        assert np.abs(found - exact).max() < 10 * tolerance
        assert run.statistics.rhs_evaluations < 1.3 * other.statistics.rhs_evaluations
    assert (run.statistics.implicit_steps > 0) >= (c >= 100)
    assert (run.statistics.solver is Solver.ADAMS) >= (c <= 0.1 and k == 0)


@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9, 1e-12])
def test_a_motion_that_sets_in_out_of_nothing(tolerance: float) -> None:
    """Forces of t and t^3 at rest: no step of order one is short enough to be right to a share of such motion."""
    model = lag.load(EXAMPLES / "disc_and_block.lag")
    exact, _ = positions(model, at=[0.1, 10], tolerance=1e-13, solver="erk")
    found, run = positions(model, at=[0.1, 10], tolerance=tolerance, solver="adams")
    assert np.abs(found - exact).max() < 10 * tolerance * np.abs(exact).max()
    assert run.statistics.rhs_evaluations < 1500


def test_pulses_and_bends_are_met(scene: Write) -> None:
    """Each begins the motion anew, at its time: where nothing else moves, the way is a polynomial in pieces."""
    model = scene("""model Pushed
      World world(gravity = {0, 0});
      Block b(m = 2, base = world);
      AppliedForce push(at = b.center, force = {if time < 1 then 6*time else if time < 2 then 0 else -4, 0});
    end Pushed;""")
    run = model.simulate(at=[1, 2, 4], tolerance=1e-9, solver="adams")
    np.testing.assert_allclose(run["b.s"], [0.5, 2, 1], rtol=1e-12)
    assert run.statistics.events == 2
