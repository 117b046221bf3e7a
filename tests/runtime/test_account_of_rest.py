"""The energy account of scenes in which all that loads do is held: energies are rounding there, and rows are right."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

SCENES = {
    "a force that rises presses on a stop":
        "Stop floor(a = world, b = y.center); AppliedForce f(at = y.center, force = {0, -5[N]*(1 - exp(-time/1[s]))});",
    "and pushes along it, less than it rubs":
        "Block x(m = 1, base = y.center); RoughStop floor(mu = 0.5, a = world, b = x.center);"
        "AppliedForce f(at = x.center, force = {min(4[N/s]*time, 3[N]), -max(10[N/s]*time, 0)});",
}


@pytest.mark.parametrize("parts", SCENES.values(), ids=SCENES)
@pytest.mark.parametrize("solver", ["auto", "erk9", "implicit"])
def test_what_is_held_from_the_start_closes(solver: str, parts: str, scene: Callable[[str], lag.Model]) -> None:
    """They ended with 'the energy account does not close at all', of 5e-33 J and 8e-17 J."""
    model = scene(f"model H World world(gravity = {{0, 0}}); Block y(m = 1, base = world, along = {{0, 1}}); {parts} end H;")
    run = model.simulate(at=[0.01, 0.5, 1, 1.4, 3], tolerance=1e-7, solver=solver)
    assert np.abs(run.rows[:, 1:]).max() < 1e-12
