"""Random mechanisms with closed loops, side by side and beside a stiff oscillator: apart they move as together."""

import re
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.random_loops import random_loops
from lagrangia.native.build import find_compiler
from lagrangia.run.runtime import Solver

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")


def named(name: str, seed: int, arms: int) -> str:
    text = re.sub(r"model \w+", f"model {name}", random_loops(seed, arms).text, count=1)
    return re.sub(r"end \w+;", f"end {name};", text)


@pytest.mark.parametrize("seed", range(1, 9))
def test_mechanisms_beside_each_other(seed: int, tmp_path: Path) -> None:
    path = tmp_path / "both.lag"
    path.write_text(f"""{named("First", 2 * seed, 2)}
{named("Second", 2 * seed + 1, 1 + seed % 2)}
model Both
  First first; Second second;
  Block block(m = 0.3, base = world, s(start = 0.01));
  DuffingSpring spring(k = 1e5, k3 = 1e6, stretch = block.s);
end Both;""")
    model, at = lag.load(path), [0.1, 0.2, 0.3]
    assert len(model.scene.islands) >= 2
    apart = model.simulate(at=at, tolerance=1e-10)
    whole = model.simulate(at=at, tolerance=1e-10, solver="erk")
    assert apart.statistics.solver is Solver.ISLANDS
    states = slice(1, 1 + 2 * model.scene.n)
    assert apart.rows[:, states] == pytest.approx(whole.rows[:, states], abs=1e-9 * np.abs(whole.rows[:, states]).max())
    assert np.abs(apart.energy.residual).max() < 1e-8
    assert apart.statistics.rhs_evaluations * 4 < whole.statistics.rhs_evaluations
