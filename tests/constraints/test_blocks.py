"""Rows of loops close loop by loop where all of them together do not."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.constraints import assembly

Write = Callable[[str], lag.Model]
OBLIQUE = ", axis = {0, -sin(0.4), cos(0.4)}"


def row(count: int, axis: str, guess: Callable[[int], str]) -> str:
    """Four-bars, each hung on the coupler of the one before."""
    lines, base = ["model Row"], "world"
    for k in range(1, count + 1):
        origin = "{1, 0, 0}" if axis else "{1, 0}"
        lines.append(f"Revolute a{k}(a = {base}{axis}{guess(k)}); Bar crank{k}(m = 1, L = 0.3, a = a{k}.b);"
                     f"Revolute b{k}(a = crank{k}.b{axis}); Bar coupler{k}(m = 1, L = 1, a = b{k}.b);"
                     f"Revolute c{k}(a = coupler{k}.b{axis}); Bar rocker{k}(m = 1, L = 0.6, a = c{k}.b);"
                     f"Revolute d{k}(a = rocker{k}.b, b = shift({base}, {origin}){axis});")
        base = f"coupler{k}.b"
    return "\n".join([*lines, "end Row;"])


@pytest.mark.parametrize(("axis", "count"), [("", 12), (OBLIQUE, 12), pytest.param(OBLIQUE, 50, marks=pytest.mark.slow)],
                         ids=["plane", "space", "long"])
def test_a_row_of_loops_keeps_its_guesses(axis: str, count: int, scene: Write) -> None:
    """Each loop can close with its crank as guessed; together they moved the cranks, and 50 were refused (L0606)."""
    model = scene(row(count, axis, lambda _: ", phi(start = 1.2)"))
    made = model.compilation
    x, worst = assembly.begin(made.kinematics, made.initial, made.functions.table).assemble()
    assert worst == -1
    run = model.simulate(at=[0, 1e-6])
    np.testing.assert_allclose([run[f"a{k}.phi"][0] for k in range(1, count + 1)], 1.2, atol=1e-12)
    found = [run[name][0] for name in model.coordinate_names]
    np.testing.assert_allclose(found, x[: len(found)], rtol=1e-9, atol=1e-9)


def test_a_guess_that_leaves_its_loop_open_moves(scene: Write) -> None:
    """The fourth coupler is too short for its crank as guessed."""
    text = row(12, OBLIQUE, lambda k: ", phi(start = 1.2)")
    model = scene(text.replace("Bar coupler4(m = 1, L = 1", "Bar coupler4(m = 1, L = 0.3"))
    run = model.simulate(at=[0, 1e-6])
    assert run.statistics.steps > 0
    assert max(abs(run[f"a{k}.phi"][0] - 1.2) for k in range(1, 13)) > 1e-3
