"""A free point mass has no angle of its own, whatever hangs on it by hinges."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
ONE = "PointMass a(m = 1); Revolute h(a = a.center, phi(start = 0.3)); Bar c(m = 2, L = 1, a = h.b);"
SCENES = {  # the text, and its degrees of freedom
    "one hinge": (ONE, 3),
    "two hinges": (ONE + "Revolute k(a = a.center, phi(start = 2)); Bar d(m = 1, L = 1, a = k.b);", 4),
    "a chain": (ONE + "Revolute k(a = c.b, phi(start = 2)); Bar d(m = 1, L = 1, a = k.b);", 4),
    "turned round": ("PointMass a(m = 1); Bar c(m = 2, L = 1); Revolute h(a = c.a, b = a.center, phi(start = 0.3));", 3),
    "a body": (ONE.replace("PointMass a(m = 1)", "Body a(m = 1, I = 1)"), 4),
    "a spring in the hinge of a body": (ONE.replace("PointMass a(m = 1)", "Body a(m = 1, I = 1)")
                                        + "TorsionSpring t(a = a.center, b = c.center, k = 3);", 4),
}


@pytest.mark.parametrize("case", SCENES)
def test_its_freedom_is_counted_without_an_angle(case: str, scene: Write) -> None:
    parts, freedom = SCENES[case]
    model = scene(f"model M {parts} end M;")
    assert model.freedom["degrees_of_freedom"] == freedom
    run = model.simulate(stop=0.5, tolerance=1e-10)
    assert run.time[-1] == 0.5


def test_it_moves_about_the_common_centre_of_mass(scene: Write) -> None:
    """A point of 1 kg and a bar of 2 kg, 1 m, hinged to it and turning with 2 rad/s about it, without gravity: their
    centre of mass, 1/3 m along the bar, moves on evenly, and the bar turns evenly about it."""
    parts = ONE.replace("phi(start = 0.3)", "w(start = 2)")
    model = scene(f"model M World world(gravity = {{0, 0}}); {parts} initial equation h.phi = 0; end M;")
    run = model.simulate(stop=1, interval=0.25, tolerance=1e-11)
    t = run.time
    np.testing.assert_allclose(run["h.phi"], 2 * t, atol=1e-9)
    np.testing.assert_allclose(run["a.center.x"], (1 - np.cos(2 * t)) / 3, atol=1e-9)
    np.testing.assert_allclose(run["a.center.y"], 2 / 3 * t - np.sin(2 * t) / 3, atol=1e-9)
