"""A belt that slips: the torque that it hands on follows Euler and Eytelwein, and it sticks exactly."""

import math
from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]


def test_a_belt_slips_where_it_has_to_hand_on_too_much(scene: Write) -> None:
    """Two pulleys, a motor whose torque grows: they turn together until the limit at rest, and then with that of sliding."""
    model = scene("""model Drive
      Revolute axle1(a = world), axle2(a = shift(world, {1, 0}));
      Disc d1(m = 1, r = 0.1, I = 0.02, center = axle1.b), d2(m = 1, r = 0.2, I = 0.1, center = axle2.b);
      RoughBelt belt(r_a = 0.1, r_b = 0.2, mu = 0.3, mu_static = 0.4, angle = 2.5, tension = 30,
                     a = axle1.b, b = axle2.b, carrier = world);
      AppliedTorque motor(on = d1.center, torque = 2[N.m/s]*time);
    end Drive;""")
    run = model.simulate(at=[0.0, 2.0, 8.0], tolerance=1e-9)
    at_rest, sliding = (60*math.tanh(mu*2.5/2) for mu in (0.4, 0.3))
    together = 0.02 + 0.1*(0.1/0.2)**2
    begin = at_rest/(0.1*0.5/0.2/together*2)
    before = begin**2/together
    first = before + ((64 - begin**2) - 0.1*sliding*(8 - begin))/0.02
    second = before/2 + 0.2*sliding*(8 - begin)/0.1
    assert run["der(axle1.phi)"][1] == pytest.approx(4/together, rel=1e-12)
    assert abs(run["belt.slip"][1]) < 1e-12
    assert run["der(axle1.phi)"][2] == pytest.approx(first, rel=1e-12)
    assert run["der(axle2.phi)"][2] == pytest.approx(second, rel=1e-12)
