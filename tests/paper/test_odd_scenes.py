"""Scenes on whose pages something is missing, or has no value."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
NO_POTENTIAL = "model M Block b(m = 1, base = world); Damper d(c = 2, rate = b.v); " \
               "AppliedForce f(at = world, force = {2*cos(3*time), -5}); end M;"


def test_a_potential_that_is_none(scene: Write) -> None:
    """A load that is given in time has one, and here none that depends on anything."""
    assert "V = 0" in scene(NO_POTENTIAL).equations("worked")


@pytest.mark.parametrize(("text", "said"), [
    ("parameter Real z = 0; Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {1/z, 0});",
     "L0713.*the forces have no finite value"),
    ("parameter Real z = -1; Block b(m = 1, base = world); Spring s(k = sqrt(z), stretch = b.s);", "L0605.*no finite value"),
    ("Block b(m = 1, base = world); equation when b.s < 0 then reinit(b.v, {0, 0}); end when;", "L0303.*2 values for one value"),
])
def test_what_has_no_value_is_told(scene: Write, text: str, said: str) -> None:
    with pytest.raises(lag.LagError, match=said):
        scene(f"model M {text} end M;").equations("linear")
