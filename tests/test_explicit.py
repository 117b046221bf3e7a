"""The explicit methods beside each other: coefficients, order, what a tolerance means, and how few steps are rejected."""

import re
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native import find_compiler
from lagrangia.runtime import Solver
from native_models import FOLDER

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).parents[1] / "models" / "examples"


def rows_of(name: str, size: int = 7) -> np.ndarray:
    """An array of rows of tsit5_tableau.h, with zeros filled in."""
    body = re.search(rf"lag_tsit5_{name}(?:\[[\w +]+\])? =\s*(.*?);", (FOLDER / "tsit5_tableau.h").read_text(), re.S)
    assert body
    found = re.findall(r"\{\d+, \{([\d, ]+)\},\s*\{([^}]+)\}\}", body[1])
    rows = np.zeros((len(found), size))
    for row, (columns, weights) in zip(rows, found, strict=True):
        row[[int(column) for column in columns.split(",")]] = [float(weight) for weight in weights.split(",")]
    return rows


def conditions(w: np.ndarray, A: np.ndarray, x: float, order: int) -> list[float]:
    """What is left of the order conditions of quadrature weights w on [0, x], up to order 5."""
    c = A.sum(axis=1)
    trees = [[np.ones(7)], [c], [c**2, A @ c], [c**3, c * (A @ c), A @ c**2, A @ (A @ c)],
             [c**4, c**2 * (A @ c), (A @ c) ** 2, c * (A @ c**2), A @ c**3, c * (A @ (A @ c)), A @ (c * (A @ c)),
              A @ (A @ c**2), A @ (A @ (A @ c))]]
    values = [[1], [2], [3, 6], [4, 8, 12, 24], [5, 10, 20, 15, 20, 30, 40, 60, 120]]
    return [float(w @ tree) - x**p / value for p in range(1, order + 1)
            for tree, value in zip(trees[p - 1], values[p - 1], strict=True)]


def test_tableau_satisfies_order_conditions() -> None:
    A, error, d = rows_of("stage"), rows_of("error")[0], rows_of("dense")[0]
    nodes = re.search(r"lag_tsit5_node\[[\w +]+\] = \{([^}]+)\}", (FOLDER / "tsit5_tableau.h").read_text())
    assert nodes and np.allclose(A.sum(axis=1), [float(c) for c in nodes[1].split(",")], atol=1e-14)
    b = A[6]
    assert conditions(b, A, 1, 5) == pytest.approx([0] * 17, abs=3e-14)
    assert conditions(b - error, A, 1, 4) == pytest.approx([0] * 8, abs=3e-14)
    assert max(map(abs, conditions(b - error, A, 1, 5))) > 1e-4
    first, last = np.eye(7)[0], np.eye(7)[6]
    for x in (0.2, 0.7):  # Hermite's cubic and one more coefficient: of order 4 inside the step
        w = x * (b + (1 - x) * (first - b + x * (2 * b - first - last + (1 - x) * d)))
        assert conditions(w, A, x, 4) == pytest.approx([0] * 8, abs=3e-14)


@pytest.mark.parametrize("name", ["double_pendulum", "four_bar", "cart_pole"])
def test_a_tolerance_means_the_same_by_both(name: str) -> None:
    model = lag.load(EXAMPLES / f"{name}.lag")
    at = np.linspace(0.2, 2, 10)
    columns = slice(1, 1 + model.scene.n)
    exact = model.simulate(at=at, tolerance=1e-13, solver="erk").rows[:, columns]
    for tolerance in (1e-4, 1e-5, 1e-6):
        run = model.simulate(at=at, tolerance=tolerance, solver="erk5")
        assert run.statistics.solver is Solver.ERK5
        assert np.abs(run.rows[:, columns] - exact).max() < 10 * tolerance * np.abs(exact).max()


def test_auto_takes_the_low_order_where_it_costs_less() -> None:
    chain, spring = (lag.load(EXAMPLES / f"{name}.lag") for name in ("chain", "spring_pendulum"))
    bars = lag.load(EXAMPLES / "four_bar.lag")

    def taken(model: lag.Model, tolerance: float) -> Solver:
        return model.simulate(stop=0.5, tolerance=tolerance).statistics.solver

    assert [taken(chain, 1e-4), taken(chain, 1e-6)] == [Solver.ERK5, Solver.ERK]
    assert [taken(bars, 1e-5), taken(bars, 1e-6)] == [Solver.ERK5, Solver.ERK]
    assert taken(spring, 1e-4) is not Solver.ERK5
    both = [bars.simulate(stop=2, tolerance=1e-4, solver=solver).statistics.rhs_evaluations for solver in ("erk5", "erk")]
    assert both[0] < 0.85 * both[1]


@pytest.mark.parametrize(("name", "tolerance", "most"), [("slider_crank", 1e-3, 3500), ("andrews_squeezer", 1e-2, 450)])
def test_rejected_steps_of_loops_are_mended_by_shorter_ones(name: str, tolerance: float, most: int) -> None:
    """Errors that are far above rounding say nothing about singular positions: projected slopes are not tried on them."""
    stop = 2.0 if name == "slider_crank" else 0.03
    statistics = lag.load(EXAMPLES / f"{name}.lag").simulate(at=[stop], tolerance=tolerance, solver="erk").statistics
    assert statistics.rhs_evaluations < most
    assert statistics.projections < 5 * (statistics.steps + statistics.rejected)


@pytest.mark.parametrize("solver", ["erk", "erk5"])
def test_rows_lie_on_the_constraints_at_loose_tolerances(solver: str) -> None:
    """Steps are projected as far as their tolerance asks for, rows to rounding, wherever steps end."""
    model = lag.load(EXAMPLES / "four_bar.lag")
    statistics = model.simulate(stop=2, interval=0.01, tolerance=1e-2, solver=solver).statistics
    assert statistics.constraint_residual < 1e-12
    assert statistics.constraint_rate_residual < 1e-12
    assert statistics.steps < 60


@pytest.mark.parametrize(("tolerance", "most"), [(1e-3, 100), (1e-12, 1000)])
def test_a_long_chain_starts_from_rest(tolerance: float, most: int) -> None:
    """Far links hardly move at first, and their accelerations are noise of 1e-10: neither is resolved."""
    chain = lag.load(EXAMPLES / "chain.lag", n=100)
    run, fine = (chain.simulate(at=[0.5, 1.0], tolerance=t, solver="erk") for t in (tolerance, 1e-9))
    assert run.statistics.steps + run.statistics.rejected < most
    assert np.abs(run.rows[:, 1:101] - fine.rows[:, 1:101]).max() < max(10 * tolerance, 1e-7)


def test_a_very_long_chain_is_let_go() -> None:
    """At 1e-8 rounding matters among 1 000 links: they took 1 003 steps of noise."""
    chain = lag.load(EXAMPLES / "chain.lag", n=1000)
    chain.native = False
    run, fine = (chain.simulate(at=[0.01], tolerance=t, solver="erk") for t in (1e-8, 1e-10))
    assert run.statistics.steps < 20
    assert np.abs(run.rows - fine.rows)[0, 1:2001].max() < 1e-8
