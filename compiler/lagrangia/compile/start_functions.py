"""What the run time evaluates of start values, beside those that are given."""

from collections.abc import Mapping
from itertools import pairwise

import casadi as ca

from lagrangia.constraints.initial import InitialConditions, initial_function
from lagrangia.constraints.parameters import at_start
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.kinematics import Kinematics


def start_functions(kinematics: Kinematics, motion: Motion, initial: InitialConditions) -> dict[str, ca.Function]:
    """Residuals of start equations, and momenta; none where no equation is stated."""
    if not initial.residual_spans:
        return {}
    return {"initial": initial_function(kinematics, initial), "momentum": _momentum_function(kinematics, motion, initial)}


def start_patterns(table: Mapping[str, ca.Function]) -> dict[str, tuple[int, ...]]:
    """Of which values each start equation speaks, and which coordinates have momenta by each other's rates."""
    if "initial" not in table:
        return {}
    gradients = table["initial"].sparsity_out("G")
    _count, order, starts = table["momentum"].jac_sparsity(0, 1).scc()
    blocks = {j: k for k, (first, end) in enumerate(pairwise(starts)) for j in order[first:end]}
    return {"initial_pattern": (*gradients.colind(), *gradients.row()), "mass_blocks": tuple(blocks[j] for j in sorted(blocks))}


def _momentum_function(kinematics: Kinematics, motion: Motion, initial: InitialConditions) -> ca.Function:
    """M v at the start time, inputs zero: the metric in which start values are near to their guesses.

    A lost coordinate s(q) is measured by what remains of M along its gradient g: count/sum(g_k^2/M_kk), over M_kk > 0.
    """
    q, v, p = motion.q, motion.v, motion.p
    (momentum,) = at_start(kinematics, [ca.jtimes(motion.momentum, v, v)])
    momenta = [momentum]
    if initial.lost:
        masses = ca.diag(ca.densify(ca.jacobian(momentum, v))).T
        slopes = ca.densify(ca.jacobian(at_start(kinematics, [initial.lost_values])[0], q))
        for k, rate in enumerate(ca.vertsplit(initial.lost_v)):
            counted = ca.logic_and(masses > 0, slopes[k, :] != 0)
            ease = ca.sum2(ca.if_else(counted, slopes[k, :] ** 2 / masses, 0))
            momenta.append(ca.if_else(ease > 0, ca.sum2(counted) / ease, 0) * rate)
    arguments = [ca.vertcat(q, initial.lost_q), ca.vertcat(v, initial.lost_v), p]
    return ca.Function("momentum", arguments, [ca.densify(ca.vertcat(*momenta))], ["q", "v", "p"], ["Mv"])
