"""Where a run cannot begin, the length that may not be 0 is named where a start beside it has accelerations, and only there."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
POLAR = "World world; Revolute h(a = world); Prismatic arm(a = h.b); PointMass P(m = 1, center = arm.b);"
CARRIED = "World world; PointMass P(m = 1); Revolute r(a = P.center); Prismatic arm(a = r.b); PointMass Q(m = 1, center = arm.b);"
NOWHERE = "World world; PointMass P(m = 1); AppliedForce f(at = P.center, force = {1[N]*log(-1 - time/1[s]), 0});"


@pytest.mark.parametrize("parts", [POLAR, CARRIED])
def test_a_slider_of_no_length_is_named(parts: str, scene: Write) -> None:
    model = scene(f"model M {parts} end M;")
    with pytest.raises(lag.RunError, match=r"not finite.* begins where arm.s is not 0 .*: --initial arm.s=1e-3$"):
        model.simulate()
    assert model.simulate(initial={"arm.s": 1e-3}).time[-1] == 1.0


def test_what_does_not_help_is_not_told(scene: Write) -> None:
    with pytest.raises(lag.RunError, match=r"look at the parameters and start values$"):
        scene(f"model M {NOWHERE} end M;").simulate()
