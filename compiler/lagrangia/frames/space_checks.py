"""What is asked of a spatial scene before its numbers are: that what is known about z alone turns about no other axis."""

from collections.abc import Mapping, Sequence

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar, base_of
from lagrangia.base.diagnostics import Span, fail

_SAME = 1e-12  # relative difference of what is the same but for rounding
_LOOKS = 3


def require_about_z(frame: str, own: Sequence[Scalar], rates: Mapping[str, Scalar], span: Span) -> None:
    """Raises LagError L0507 for a frame that turns about another axis than its own z, where an inertia is known about z alone.
    `own`: its angular velocity in its own axes; `rates` of coordinates."""
    omega = [base_of(x) for x in own]
    if all(isinstance(x, float | int) and x == 0 for x in omega[:2]):
        return
    turning = ca.vertcat(*omega)
    symbols = ca.symvar(turning)
    look = ca.Function("look", [ca.vertcat(ca.SX(0, 1), *symbols)], [turning])
    random = np.random.default_rng(3)
    looks = [np.array(look(random.uniform(0.4, 1.6, len(symbols)))).ravel() for _ in range(_LOOKS)]
    if all(np.abs(x[:2]).max() <= _SAME * np.abs(x).max() for x in looks):
        return
    joint = next((name for name, rate in rates.items() if ca.depends_on(turning[:2], rate)), "")
    body = frame.rpartition(".")[0] or frame
    joint, _, part = joint.partition(".s[")
    by = f"{'the attitude ' if part else ''}'{joint}' turns it there" if joint else "it is turned there"
    fail("L0507", f"the inertia of '{body}' is given about z alone, and it turns about its x or y as well: {by}",
         span, "give the inertia about all axes: I = {Ixx, Iyy, Izz}")
