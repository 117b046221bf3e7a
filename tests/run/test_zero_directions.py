"""A run whose axis has no length says which one."""

import pytest

import lagrangia as lag

TILTED = """model Tilted
  parameter Real lean = 1;
  World world(gravity = {0, 0, -9.81});
  Revolute hinge(a = world, axis = {0, lean, 0}, phi(start = 0.3));
  Body rod(m = 1, I = {0.01, 0.01, 0.005}, center = shift(hinge.b, {0, 0, 0.2}));
end Tilted;"""


def test_an_axis_that_became_0_is_named() -> None:
    model = lag.loads(TILTED)
    with pytest.raises(lag.LagError, match=r"the direction 'hinge.axis' has no length"):
        model.simulate(parameters={"lean": 0}, stop=1)
    model.simulate(parameters={"lean": -2}, stop=0.1)
