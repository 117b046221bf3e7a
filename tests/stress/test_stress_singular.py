"""Rows of parallelograms that fold flat on their way, where each may open in two ways, at any tolerance."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
TOLERANCES = np.logspace(-3, -12, 37)


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 10, 100])
def test_flat_positions_are_passed_at_any_tolerance(n: int) -> None:
    """A step may end anywhere near them. Where rounding is magnified too much for the tolerance to be reached, the run goes on
    and says so."""
    model = lag.load(EXAMPLES / "n_four_bars.lag", n=n)
    exact = model.simulate(stop=2, interval=0.5, tolerance=1e-12)
    size = np.abs(exact.rows[:, 1 : 1 + 2 * model.scene.n]).max()
    for tolerance in TOLERANCES:
        run = model.simulate(stop=2, interval=0.5, tolerance=tolerance)
        error = np.abs((run.rows - exact.rows)[:, 1 : 1 + 2 * model.scene.n]).max() / size
        assert error < 10 * tolerance + 1e-10, f"at {tolerance:.1e}"
        assert (run.statistics.tolerance_missed > 0) == bool(run.warnings)
