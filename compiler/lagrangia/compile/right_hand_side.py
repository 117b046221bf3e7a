"""What steps evaluate of a motion, with its conditions held by switches."""

import casadi as ca

from lagrangia.dynamics.held_motion import HeldMotion
from lagrangia.dynamics.motion import Motion, kept_rates
from lagrangia.frames.kinematics import Kinematics


def right_hand_side(kinematics: Kinematics, motion: Motion, held: HeldMotion, acceleration: ca.SX, source: ca.SX,
                    *multipliers: ca.SX) -> list[ca.SX]:
    """Accelerations (n,), power as of `power_of`, and multipliers, if given; `source`: the power put in where these are so."""
    rows = motion.constrained.rows.rate if multipliers and motion.constrained is not None else None
    against = motion.inertial, kept_rates(kinematics, motion.v)
    return held.rows([acceleration, power_of(motion, source), *multipliers], rows, motion.v, against)


def power_of(motion: Motion, source: ca.SX) -> ca.SX:
    """Taken out and put in, (2,); empty where there are neither."""
    has_power = not (motion.dissipated_power.is_zero() and motion.source_power.is_zero())
    return ca.vertcat(motion.dissipated_power, source) if has_power else ca.SX(0, 1)
