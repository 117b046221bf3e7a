"""The explicit methods beside each other: coefficients, order, what a tolerance means, and how few steps are rejected."""

import re
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.native_models import FOLDER, OSCILLATOR, compiled, started
from lagrangia.native.build import find_compiler
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"


def rows_of(name: str, size: int = 7, method: str = "tsit5") -> np.ndarray:
    """An array of rows of a method's tableau, with zeros filled in."""
    text = (FOLDER / "methods" / f"{method}_tableau.h").read_text()
    body = re.search(rf"lag_{method}_{name}(?:\[[\w +]+\])? =\s*(.*?);", text, re.S)
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
    nodes = re.search(r"lag_tsit5_node\[[\w +]+\] = \{([^}]+)\}", (FOLDER / "methods" / "tsit5_tableau.h").read_text())
    assert nodes and np.allclose(A.sum(axis=1), [float(c) for c in nodes[1].split(",")], atol=1e-14)
    b = A[6]
    assert conditions(b, A, 1, 5) == pytest.approx([0] * 17, abs=3e-14)
    assert conditions(b - error, A, 1, 4) == pytest.approx([0] * 8, abs=3e-14)
    assert max(map(abs, conditions(b - error, A, 1, 5))) > 1e-4
    first, last = np.eye(7)[0], np.eye(7)[6]
    for x in (0.2, 0.7):  # Hermite's cubic and one more coefficient: of order 4 inside the step
        w = x * (b + (1 - x) * (first - b + x * (2 * b - first - last + (1 - x) * d)))
        assert conditions(w, A, x, 4) == pytest.approx([0] * 8, abs=3e-14)


def bushes(w: np.ndarray, A: np.ndarray, c: np.ndarray, order: int) -> list[float]:
    """What is left of the conditions of the trees [tau^m], [tau^m [tau^k]] and [tau^m [tau^l [tau^k]]]."""
    left = [w @ c**m - 1 / (m + 1) for m in range(order)]
    left += [w @ (c**m * (A @ c**k)) - 1 / ((k + 1) * (k + m + 2)) for m in range(order - 1) for k in range(order - 1 - m)]
    left += [w @ (c**m * (A @ (c**l * (A @ c**k)))) - 1 / ((k + 1) * (k + l + 2) * (k + l + m + 3))
             for m in range(order - 2) for l in range(order - 2 - m) for k in range(order - 2 - m - l)]
    return [float(x) for x in left]


def test_the_coefficients_of_order_nine() -> None:
    """Its 486 conditions are Verner's; these are those of long stems and bushes."""
    A, error = rows_of("stage", 17, "verner9"), rows_of("error", 17, "verner9")[0]
    nodes = re.search(r"lag_verner9_node\[[\w +]+\] = \{([^}]+)\}", (FOLDER / "methods" / "verner9_tableau.h").read_text())
    c, b = np.append(A[:16].sum(axis=1), 0), A[16].copy()
    assert nodes and np.allclose([*c[:16], 1], [float(x) for x in nodes[1].split(",")], atol=1e-14)
    A[16] = 0
    assert bushes(b, A, c, 9) == pytest.approx([0] * 129, abs=5e-15)
    assert [(b - error) @ c**m - 1 / (m + 1) for m in range(8)] == pytest.approx([0] * 8, abs=5e-15)
    assert abs((b - error) @ c**8 - 1 / 9) > 1e-5


def test_the_order_nine_shows(runtime: Runtime) -> None:
    """In steps, and inside one, which is stepped to."""
    model, errors, inside = compiled(1, rhs=OSCILLATOR), [], []
    for h in (0.5, 0.25):
        with started(runtime, model, [1], [0], t_stop=8, tolerance=1e3, first_step=h, max_step=h, solver=Solver.ERK9) as run:
            assert run.advance([8.0]).status is Status.OK
            assert run.statistics.steps == 8 / h
            rows = run.advance([8 - 0.3 * h, 8.0])
        errors.append(abs(rows[1][1] - np.cos(8)))
        inside.append(abs(rows[0][1] - np.cos(8 - 0.3 * h)))
    assert 8.5 < np.log2(errors[0] / errors[1]) < 10.5
    assert np.log2(inside[0] / inside[1]) > 8


def test_its_steps_end_at_rows_unless_there_are_many() -> None:
    """Where auto takes it: in closed loops at loose tolerances."""
    crank = lag.load(EXAMPLES / "slider_crank.lag")
    few, many = (crank.simulate(at=np.linspace(0, 1, rows), tolerance=1e-3) for rows in (5, 501))
    assert few.statistics.solver is Solver.ERK9 and few.statistics.dense_outputs == 0
    assert many.statistics.solver is Solver.ERK5 and many.statistics.switches == 0
    chain, at = lag.load(EXAMPLES / "chain.lag"), np.linspace(0, 2, 5)
    exact = chain.simulate(at=at, tolerance=1e-14, solver="erk").rows[:, 1:6]
    by_nine, by_eight = (chain.simulate(at=at, tolerance=1e-10, solver=solver) for solver in ("erk9", "erk"))
    assert np.abs(by_nine.rows[:, 1:6] - exact).max() < 1e-10
    assert by_nine.statistics.rhs_evaluations < 0.85 * by_eight.statistics.rhs_evaluations


@pytest.mark.parametrize("name", ["chain", "slider_crank", "andrews_squeezer", "double_pendulum", "cart_pole"])
def test_a_tolerance_means_the_same_at_order_nine(name: str) -> None:
    model, stop = lag.load(EXAMPLES / f"{name}.lag"), 0.03 if name == "andrews_squeezer" else 2.0
    at, columns = np.linspace(stop / 5, stop, 5), slice(1, 1 + model.scene.n)
    exact = model.simulate(at=at, tolerance=1e-14, solver="erk").rows[:, columns]
    for tolerance in (1e-4, 1e-7, 1e-10):
        run = model.simulate(at=at, tolerance=tolerance, solver="erk9")
        assert run.statistics.solver is Solver.ERK9
        assert np.abs(run.rows[:, columns] - exact).max() < 5 * tolerance * np.abs(exact).max()
        assert run.statistics.energy_residual < 100 * tolerance * run.statistics.energy_size
        assert run.statistics.constraint_residual < 1e-13


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

    assert [taken(chain, 1e-4), taken(chain, 1e-6)] == [Solver.ERK5, Solver.PIRK]
    assert [taken(bars, 1e-3), taken(bars, 1e-4)] == [Solver.ERK5, Solver.PIRK]
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
