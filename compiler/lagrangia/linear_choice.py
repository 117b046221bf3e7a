"""Does the matrix exponential cost less than steps? Both ways are right; this is about time alone.

An explicit method takes some steps for each radian of the fastest motion, more for tighter tolerances; the exponential costs its
set-up, whatever the horizon, and each row, whatever lies between the rows. Measured on scenes of 1 to 7 states of loads and
coordinates, 501 rows: even at some 150 radians at a tolerance of 1e-8; time events ask for parts of intervals, which cost more.
"""

import casadi as ca
import numpy as np

from lagrangia.kinematics import Kinematics
from lagrangia.motion import Motion, mass_matrix
from lagrangia.parameters import default_parameters

_RADIANS, _RADIANS_WITH_EVENTS = 150, 1500
_ORDER, _USUAL_TOLERANCE = 8, 1e-8
_LARGEST = 100  # coordinates; beyond, rows of exponentials are summed up as series and cost like steps


def linear_pays(kinematics: Kinematics, motion: Motion) -> bool:
    """At the parameters as declared and over the experiment's horizon."""
    experiment = kinematics.graph.model.experiment
    if motion.q.numel() > _LARGEST:
        return False
    radians = fastest_rate(kinematics, motion) * (experiment.stop - experiment.start)
    more = (_USUAL_TOLERANCE / experiment.tolerance) ** (1 / _ORDER)
    return bool(radians * more > (_RADIANS_WITH_EVENTS if kinematics.algebra.modes else _RADIANS))


def fastest_rate(kinematics: Kinematics, motion: Motion) -> float:
    """The largest |lambda| of the motion's equations, 1/s; 0 where they have no value."""
    p, defaults = default_parameters(kinematics)
    n, modes = motion.q.numel(), ca.vertcat(*[mode.symbol for mode in kinematics.algebra.modes])
    slopes = ca.densify(ca.jacobian(motion.h, ca.vertcat(motion.q, motion.v)))
    function = ca.Function("matrices", [p, modes], [ca.densify(mass_matrix(motion)), slopes])
    M, KC = (np.array(x) for x in function(defaults, 0))
    try:
        A = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), -np.linalg.solve(M, KC)])
        rates = np.abs(np.linalg.eigvals(A))
    except np.linalg.LinAlgError:
        return 0.0
    return float(rates.max()) if np.all(np.isfinite(rates)) else 0.0
