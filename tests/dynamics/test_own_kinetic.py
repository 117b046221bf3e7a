"""Kinetic energies of one's own that are not quadratic in the rates: what is kept is v dT/dv - T + V, and the account knows."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
@pytest.mark.parametrize(("parts", "names", "slope", "start"), [
    ("coordinate Angle a(start = 0.5); energy kinetic 0.25[kg.m2]*der(a)^2/2 + (8[rad/s]*0.5[m]*sin(a))^2*1[kg]/2; "
     "potential -9.81[m/s2]*0.5[m]*1[kg]*cos(a);",  # a bead on a hoop that turns evenly
     ["a"], lambda t, y: [y[1], (64 * np.cos(y[0]) - 9.81 / 0.5) * np.sin(y[0])], [0.5, 0.0]),
    ("coordinate Length x(start = 0.3), y; energy kinetic 1[kg]*(der(x)^2 + der(y)^2)/2 + 3[kg/s]*x*der(y); "
     "potential 2[N/m]*(x^2 + y^2);",  # a charge in a field
     ["x", "y"], lambda t, z: [z[2], z[3], -4 * z[0] + 3 * z[3], -4 * z[1] - 3 * z[2]], [0.3, 0.0, 0.0, 0.0]),
    ("coordinate Length x(start = 1); energy kinetic 1[kg]*der(x)^2/2 + 0.5[kg.s2/m2]*der(x)^4; potential 3[N/m]*x^2;",
     ["x"], lambda t, y: [y[1], -6 * y[0] / (1 + 6 * y[1] ** 2)], [1.0, 0.0]),
])
def test_the_account_closes_and_the_motion_is_right(parts: str, names: list[str], slope: Callable[..., list[float]],
                                                    start: list[float], solver: str, scene: Write) -> None:
    """They ended with exit code 1, as T + V is not kept."""
    run = scene(f"model Own {parts} end Own;").simulate(at=[0.5, 1.0, 2.0], tolerance=1e-9, solver=solver)
    right = solve_ivp(slope, (0, 2), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=run.time).y
    for name, values in zip(names, right, strict=False):
        assert run[name] == pytest.approx(values, abs=1e-7)
    assert not run.warnings and np.abs(run.energy.residual).max() < 1e-7


def test_momenta_are_those_of_quadratic_energies(scene: Write) -> None:
    """v = M^-1 dT/dv where nothing in T is linear in v: conservative steps of a charge in a field went their own way."""
    field = scene("""model Field coordinate Length x(start = 0.3), y;
      energy kinetic 1[kg]*(der(x)^2 + der(y)^2)/2 + 3[kg/s]*x*der(y);
      potential 2[N/m]*(x^2 + y^2); end Field;""")
    with pytest.raises(lag.LagError, match="not quadratic"):
        field.simulate(at=[1.0], solver="conservative")
    hoop = scene("""model Hoop coordinate Angle a(start = 0.5); energy kinetic 1[kg.m2]*der(a)^2/2 + 32[J]*sin(a)^2;
      potential -9.81[J]*cos(a); end Hoop;""")
    right = hoop.simulate(at=[1.0], tolerance=1e-11)
    assert hoop.simulate(at=[1.0], tolerance=1e-8, solver="conservative")["a"] == pytest.approx(right["a"], abs=1e-6)
