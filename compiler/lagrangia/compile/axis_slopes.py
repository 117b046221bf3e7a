"""Derivatives of accelerations by axes of hinges in space.

The elimination along a tree lays links by angles of these axes (dynamics/spatial_axes.py), by which nothing can be derived where
an axis lies along another, though the accelerations can: of r = M dv/dt + h + J^T lambda = 0 and J dv/dt + bias = 0, which know
no such angles, d(dv/dt, lambda)/dp = -K^-1 dr/dp with K = [M J^T; J 0]. Where rows repeat each other K has no inverse: there the
derivatives are those of the elimination, NaN by such axes.
"""

import casadi as ca

from lagrangia.dynamics.motion import Motion, mass_matrix
from lagrangia.frames.kinematics import Kinematics


def slopes_by_parameters(kinematics: Kinematics, motion: Motion, has_repeated: bool) -> ca.SX:
    """d(dv/dt)/dp, (n, n_p); `has_repeated`: whether rows of constraints repeat each other."""
    (a,), p = kinematics.algebra.by_inputs([motion.acceleration]), motion.p
    slopes = ca.jacobian(a, p)
    is_sought = kinematics.graph.model.found.space.is_spatial and not has_repeated
    if columns := _of_axes(a, p) if is_sought else []:
        slopes[:, columns] = _by_equations(kinematics, motion, columns)
    return slopes


def _of_axes(a: ca.SX, p: ca.SX) -> list[int]:
    """The parameters of which some angle is made that follows from parameters alone."""
    angles = [part for part in ca.extract_parametric(a, p)[2] if _has_angle(part, p)]
    if not angles:
        return []
    return sorted(set(ca.jacobian_sparsity(ca.vertcat(*angles), p).get_triplet()[1]))


def _has_angle(part: ca.SX, p: ca.SX) -> bool:
    steps = ca.Function("part", [p], [part])
    return any(steps.instruction_id(k) == ca.OP_ATAN2 for k in range(steps.n_instructions()))


def _by_equations(kinematics: Kinematics, motion: Motion, columns: list[int]) -> ca.SX:
    """d(dv/dt)/dp of these columns, (n, len(columns))."""
    n, held = motion.v.numel(), motion.constrained
    M, a, J, multipliers, bias = mass_matrix(motion), motion.acceleration, ca.SX(0, n), ca.SX(0, 1), ca.SX(0, 1)
    if held:
        J, multipliers, bias = held.J, held.multipliers, held.rows.bias
    known = ca.SX.sym("y", n + J.rows())
    M, h, J, bias, found = kinematics.algebra.by_inputs([M, motion.h, J, bias, ca.vertcat(a, multipliers)])
    across = J @ known[:n, :] + bias
    rest = ca.vertcat(M @ known[:n, :] + h + J.T @ (known[n:, :] + across), across)
    slopes = ca.substitute(ca.jacobian(rest, motion.p)[:, columns], known, found)
    D, upper, order = ca.ldl(ca.blockcat([[M + J.T @ J, J.T], [J, ca.SX(J.rows(), J.rows())]]), not held)
    return -ca.ldl_solve(ca.densify(slopes), D, upper, order)[:n, :]
