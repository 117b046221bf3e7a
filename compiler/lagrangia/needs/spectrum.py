"""The spectrum of the motion near its start: how fast its fastest and slowest parts are."""

import math

import casadi as ca
import numpy as np

from lagrangia.base.records import dataclass
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.kinematics import Kinematics

_STILL = 1e-6  # eigenvalues this much smaller than the largest are those of rigid-body motion
_STIFF_SPAN = 1e3  # how much faster decay must be than the rest
_DAMPED = 0.9  # of |lambda|: what decays faster than it swings


@dataclass(frozen=True)
class Spectrum:
    """|lambda| of dx/dt = A x at the start, 1/s; `decay` is the fastest rate that dies away, `swing` the fastest
    that swings."""

    slowest: float
    fastest: float
    decay: float
    swing: float

    def is_stiff(self, horizon: float) -> bool:
        """Whether what dies away at once would dictate the steps: it is much faster than what swings and than the horizon."""
        return self.decay > _STIFF_SPAN * max(self.swing, 1 / horizon) if horizon > 0 else False


def find_spectrum(kinematics: Kinematics, motion: Motion, initial: InitialConditions, given: ca.DM | None = None
                  ) -> Spectrum | None:
    """At the guesses and with the parameters as declared or `given`; None when the accelerations have no value there."""
    n = motion.q.numel()
    slopes = ca.jacobian(motion.acceleration, ca.vertcat(motion.q, motion.v))
    p, declared = default_parameters(kinematics)
    parameters, start = declared if given is None else given, [initial.q[:n], initial.v[:n]]
    if p.numel():
        start = ca.substitute(start, [p], [ca.SX(parameters)])
    freed = ca.vertcat(motion.impacts.forces, motion.impacts.impulses)  # between impacts nothing holds at contacts
    slopes = kinematics.algebra.with_modes([ca.substitute(slopes, freed, ca.SX.zeros(freed.numel()))])
    function = ca.Function("slopes", [motion.t, motion.q, motion.v, motion.u, motion.p], slopes)
    instant = kinematics.graph.model.experiment.start
    q, v = (ca.evalf(x)[:n] for x in start)
    numbers = function(instant, q, v, 0, parameters).full()
    if not np.all(np.isfinite(numbers)):
        return None
    matrix = np.vstack([np.hstack([np.zeros((n, n)), np.eye(n)]), numbers])
    found = np.linalg.eigvals(matrix)
    sizes = np.abs(found)
    moving = sizes > _STILL * max(sizes.max(initial=0.0), math.ulp(0.0))
    slowest = float(sizes[moving].min()) if moving.any() else 0.0
    dies = -found.real > _DAMPED * sizes
    decay, swing = (float(sizes[which].max(initial=0.0)) for which in (dies, ~dies))
    return Spectrum(slowest, float(sizes.max(initial=0.0)), decay, swing)
