"""Directions of springs, dampers and stops have any length but 0: what they feel is along them, however long they are written."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
PARTS = """World world(gravity = {{0, 0}}); Block b(m = 2, base = world, s(start = 0.3));
  AxialSpring s(k = 200, a = world, b = b.center, along = {{{0}, 0}});
  AxialDamper d(c = 3, a = world, b = b.center, along = {{{0}, 0}});
  PointMass P(m = 1, center(x(start = 0), y(start = 0.1))); RoughStop f(a = world, b = P.center, along = {{0, {0}}}, mu = 0.1);
  AppliedForce push(at = P.center, force = {{2, -9.81}}); output Real held(unit = "N") = f.force;"""


def test_their_length_does_not_count(scene: Write) -> None:
    """A spring along {2, 0} had four times its stiffness, a stop along {0, 2} half the force."""
    runs = [scene(f"model M {PARTS.format(length)} end M;").simulate() for length in (1, 2, 0.5)]
    w, r = np.sqrt(100 - 0.75**2), 0.75
    assert runs[1]["b.s"] == pytest.approx(0.3 * np.exp(-r * runs[1].time) * (np.cos(w * runs[1].time)
                                                                              + r / w * np.sin(w * runs[1].time)), abs=1e-7)
    assert runs[1]["held"][-1] == pytest.approx(9.81)
    for run in runs[1:]:
        assert all(run[name] == pytest.approx(runs[0][name], abs=1e-12) for name in ("b.s", "P.center.x", "P.center.y", "held"))


def test_none_is_refused(scene: Write) -> None:
    with pytest.raises(lag.LagError, match=r"L0217.* is 0, which has no direction"):
        scene(f"model M {PARTS.format(1).replace('along = {1, 0}', 'along = {0, 0}')} end M;")
