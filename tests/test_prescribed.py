"""Coordinates that are held or prescribed, however that is written, and the forces that it takes."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]

# ---------------------------------------------------------------- coordinates of free bodies

PENDULUM = "Revolute h(a = A.b, phi(start = 0.4)); Bar c(m = 1, L = 0.7, a = h.b);"
HELD = {
    "x": "{x} = 0;",
    "angle in time": "{phi} = 0.3*sin(2[rad/s]*time);",
    "x and y": "{x} = 0.1*sin(3[rad/s]*time); {y} = 0.2[m/s]*time;",
    "all": "{x} = 0.1*sin(3[rad/s]*time); {y} = 0; {phi} = 1[rad/s]*time;",
}


@pytest.mark.parametrize("case", HELD)
def test_a_free_body_is_held_as_one_on_a_joint_of_three_freedoms(case: str, scene: Write) -> None:
    free = scene(f"model M Bar A(m = 2, L = 1); {PENDULUM} equation "
                 f"{HELD[case].format(x='A.center.x', y='A.center.y', phi='A.center.phi')} end M;")
    joined = scene(f"model M Planar p(a = world); Bar A(m = 2, L = 1, center = p.b); {PENDULUM} equation "
                   f"{HELD[case].format(x='p.x', y='p.y', phi='p.phi')} end M;")
    found, right = (model.simulate(stop=1, interval=0.25, tolerance=1e-11) for model in (free, joined))
    for name in ("x", "y", "phi"):
        np.testing.assert_allclose(found[f"A.center.{name}"], right[f"p.{name}"], atol=1e-10)
    np.testing.assert_allclose(found["h.phi"], right["h.phi"], atol=1e-10)


def test_a_mass_falls_along_the_line_it_is_held_on(scene: Write) -> None:
    model = scene("model M PointMass A(m = 2); equation A.center.x = 0; end M;")
    assert model.freedom["degrees_of_freedom"] == 1
    assert model.simulate(stop=1)["A.center.y"][-1] == pytest.approx(-4.905, abs=1e-14)
