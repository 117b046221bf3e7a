"""Energies that jump with a position are told of: no force is their slope."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]


@pytest.mark.parametrize(("what", "is_told"), [
    ("GeneralSpring s(stretch = b.s, V = if b.s > 1 then 5 else 0);", True),
    ("GeneralSpring s(stretch = b.s, V = 5*floor(b.s/0.1));", True),
    ("GeneralSpring s(stretch = b.s, V = if b.s > L then 50*b.s^2 else 0);", True),
    ("GeneralSpring s(stretch = b.s, V = if b.s > L then 50*(b.s - L)^2 else 0);", False),
    ("GeneralSpring s(stretch = b.s, V = if time > 1 then 50*b.s^2 else 0);", False),
    ("PointMass p(m = 1); GeneralSpring s(stretch = b.s, V = if distance(p.center, b.center) > L then 3 else 2);", True),
    ("PointMass p(m = 1); energy potential if p.center.x < 0 and p.center.y < 0 then 50[N/m]*p.center.y^2 else 0;", True),
    ("energy kinetic (if b.s > 0.5 then 2 else 1)*b.v^2/2;", True),
    ("energy kinetic (if b.s > 0.5 then 4[kg/m]*b.s - 1 else 1)*b.v^2/2;", False),
])
def test_energies_that_jump_are_told(what: str, is_told: bool, scene: Write) -> None:
    told = scene(f"model Jump parameter Length L = 0.3; Block b(m = 1, base = world); {what} end Jump;").warnings
    assert any("L0744" in warning for warning in told) == is_told
