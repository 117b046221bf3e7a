"""What stands on a level of a condition in a force is left as soon as something moves it, whatever else is in the scene."""

from collections.abc import Callable

import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk9", "implicit")
AT_WHICH = ("if min(x, 0) == 0 then 1 else 0", "if abs(x) == x then 1 else 0", "if max(x, 0) == max(x, -1) then 1 else 0",
            "if min(x, 0) >= 0 and min(x, 0) <= 0 then 1 else 0", "if abs(min(x, 0)) > 0 then 0 else 1")


@pytest.mark.parametrize("law", AT_WHICH)
def test_equalities_that_are_true_on_one_side(law: str, scene: Write) -> None:
    """Where min(x, 0) stays 0 it has a side, by which min(x, 0) == 0 was false (2 m for 1.711)."""
    model = scene(f"""model M World world(gravity = {{0, 0}}); Block a(m = 1, base = world, s(start = -0.3), v(start = 1));
        Block c(m = 1, base = world, v(start = 1)); Real x = a.s/1[m]; energy work -0.2*({law})*1[N] on c.s; end M;""")
    for solver in SOLVERS:
        assert model.simulate(at=[2.0], solver=solver, tolerance=1e-8)["c.s"][0] == pytest.approx(1.711, abs=1e-7)


@pytest.mark.parametrize("far", [1, 100, 1e6])
def test_loads_that_set_in_slowly(far: float, scene: Write) -> None:
    """They were none up to rounding of what is farthest away (100 m: 0.37761 for 0.386899 of SciPy at 1e-12; 2.271 for 2.1)."""
    for push, law, T, want in (("sign(a.s/1[m]) + 0.001*(time/1[s])^3", "0", 1.0, 0.38689875292),
                               ("1e-10*time/1[s]", "if a.s > 0[m] then 1 else 0", 3.0, 2.1)):
        model = scene(f"""model M World world(gravity = {{0, 0}}); Block d(m = 1, base = world, s(start = {far}));
            Block a(m = 1, base = world); Block c(m = 1, base = world, v(start = 1)); energy potential 3*a.s^2*1[N/m]/2;
            energy work ({push})*1[N] on a.s; energy work -0.2*({law})*1[N] on c.s; end M;""")
        for solver in SOLVERS:
            found = model.simulate(at=[T], solver=solver, tolerance=1e-10)["a.s" if law == "0" else "c.s"][0]
            assert found == pytest.approx(want, abs=1e-8)
