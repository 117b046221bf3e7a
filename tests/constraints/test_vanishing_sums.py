"""Sums that are nowhere negative and are to vanish, as a rod of length 0 between two parts of a loop: each part vanishes."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
CRANK = """model M Prismatic guide(a = world, s(start = 1.1)); Body slider(m = 1, I = 1, center = guide.b);
  Revolute h(a = world, phi(start = 0.9)), h2(a = bar.b, phi(start = -1.8));
  Bar bar(m = 1, L = 1, a = h.b), bar2(m = 1, L = 1, a = h2.b); {} end M;"""
PIN = "Revolute pin(a = slider.center, b = bar2.b);"
TIES = ["Link l(a = slider.center, b = bar2.b, L = 0);",
        "parameter Length L = 0; Link l(a = slider.center, b = bar2.b, L = 2*L);",
        "equation (slider.center.x - bar2.b.x)^2 + 3*(slider.center.y - bar2.b.y)^2 = 0;",
        "equation abs(slider.center.x - bar2.b.x) + abs(slider.center.y - bar2.b.y) = 0;",
        "equation 0 = distance(bar2.b, slider.center)*4;",
        "PointMass p(m = 0); Link l(a = slider.center, b = p.center, L = 0); Link k(a = p.center, b = bar2.b, L = 0);"]


@pytest.mark.parametrize("tie", TIES)
def test_as_with_a_pin(scene: Write, tie: str) -> None:
    pinned = scene(CRANK.format(PIN)).simulate(at=[0.0, 0.5, 1.0], tolerance=1e-11)
    model = scene(CRANK.format(tie))
    found = model.simulate(at=[0.0, 0.5, 1.0], tolerance=1e-11)
    np.testing.assert_allclose(found["h.phi"] - found["h.phi"][0], pinned["h.phi"] - pinned["h.phi"][0], atol=2e-9)
    assert found["h.phi"][0] == pytest.approx(pinned["h.phi"][0], abs=1e-9)
    assert model.freedom["degrees_of_freedom"] == 1


def test_a_length_that_is_given_later(scene: Write) -> None:
    model = scene(CRANK.format(TIES[0]))
    found = model.simulate(at=[0.0, 0.5], parameters={"l.L": 0.2})
    tip = np.exp(1j * found["h.phi"]) + np.exp(1j * (found["h.phi"] + found["h2.phi"]))
    assert np.abs(tip - found["guide.s"]) == pytest.approx([0.2, 0.2], abs=1e-9)


def test_what_cannot_vanish(scene: Write) -> None:
    with pytest.raises(LagError, match="L0606"):
        scene("""model M Prismatic p(a = world), q(a = shift(world, {0, 1}));
          PointMass m(m = 1, center = p.b), n(m = 1, center = q.b);
          Link l(a = m.center, b = n.center, L = 0); end M;""").simulate(stop=1)
