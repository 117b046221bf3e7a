"""Reactions that the mechanics leave open, by least squares: a door on two hinges, a table on four legs.

Where rows of constraints repeat each other, J^T lambda = 0 has solutions N, self-stresses that no motion feels: reactions are
P + S N z for any z. Asked for are those whose squares add up to least, forces in N and torques in N.m over a length, of all
joints, ties and equations. Where rows only seem to repeat others (parameters of a run may change that) they share nothing.
Source: Golub and Van Loan, section 5.5; Wojtyra and Fraczek, Multibody Syst. Dyn. 30 (2013), 153: pseudoinverses and lengths.
"""

from collections.abc import Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from lagrangia.algebra.orthogonal import general_numbers
from lagrangia.algebra.scalars import symbols_in
from lagrangia.constraints.assembly import assembled
from lagrangia.constraints.initial import InitialConditions
from lagrangia.constraints.parameters import at_declared_values
from lagrangia.constraints.rows import Constraints, LeastSquares
from lagrangia.dynamics.constrained_motion import ConstrainedMotion, constraint_rows
from lagrangia.dynamics.freedom import ranks_at
from lagrangia.dynamics.kkt import factor
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.released_directions import Released
from lagrangia.frames.kinematics import Kinematics

_APART = 1e-6  # of a row's slopes, what others do not say: less is rounding, and what is left of the gaps
_NOTHING = 1e-12  # of the largest: what cancels, as what a loop does to joints that are not in it


def asking_for_least_squares(
    kinematics: Kinematics, constraints: Constraints, initial: InitialConditions, length: float | None
) -> Constraints:
    """The constraints with what repeats others, at general positions near the start, with the parameters as declared; the same
    where no length (m) asks for it."""
    if length is None:
        return constraints
    dependent: tuple[int, ...] = ()
    if constraints.rows:
        rows = constraint_rows(kinematics, constraints)
        v = ca.vertcat(*kinematics.symbols.rates.values())
        q = assembled(kinematics, initial)[0][: v.numel()]
        dependent = ranks_at(kinematics, rows.phi, ca.jacobian(rows.rate, v), q)[1]
    return replace(constraints, least_squares=LeastSquares(length, dependent))


def shared_by_least_squares(
    kinematics: Kinematics, constraints: Constraints, motion: Motion, released: Released, wrenches: Sequence[ca.SX],
    forces: ca.SX, values: ca.SX
) -> ca.SX:
    """`values`, affine in multipliers, with those that make the squares of all wrenches and other forces add up to least."""
    asked, held = constraints.least_squares, motion.constrained
    if asked is None or not (asked.dependent or constraints.repeated):
        return values
    parts = [part for wrench in wrenches for part in _by_length(kinematics, wrench, asked.length)]
    told = ca.vertcat(*parts, forces)
    ways, surely = _self_stresses(held, asked.dependent) if held and asked.dependent else (ca.SX(0, 0), ca.SX(0, 1))
    multipliers, n_open = held.symbols if held else ca.SX(0, 1), released.open.numel()
    unknown = ca.vertcat(multipliers, released.open)
    freely = ca.diagcat(ways, ca.SX.eye(n_open)) if ways.numel() else ca.SX.eye(n_open)
    freely = freely if ways.numel() or not multipliers.numel() else ca.vertcat(ca.SX(multipliers.numel(), n_open), freely)
    slopes = _where_it_matters(kinematics, ca.jacobian(told, unknown)) @ freely
    (told, values_at) = ca.substitute([told, values], [released.open], [ca.SX.zeros(n_open)])
    kept = ca.horzcat(ca.diag(1 - surely), ca.SX(surely.numel(), n_open))
    system = factor(ca.SX.eye(told.numel() + surely.numel()), ca.vertcat(slopes, kept).T, False, is_regular=True)
    _, z = system.solve(ca.vertcat(told, ca.SX.zeros(surely.numel())), ca.SX.zeros(freely.size2()))
    return values_at - ca.jacobian(values, unknown) @ (freely @ z)


def _by_length(kinematics: Kinematics, wrench: ca.SX, length: float) -> list[ca.SX]:
    """A force as it is, a torque over the length."""
    n = 3 if kinematics.geometry.by_poses else 2
    return [wrench[:n], wrench[n:] / length]


def _self_stresses(held: ConstrainedMotion, dependent: Sequence[int]) -> tuple[ca.SX, ca.SX]:
    """Multipliers that move nothing, (m, r), one for each row that repeats others; and 1 where one does, else 0."""
    others = [k for k in range(held.J.size1()) if k not in dependent]
    J, rest = held.J[others, :], held.J[list(dependent), :]
    apart, shares = factor(ca.SX.eye(J.size2()), J, False).solve(rest.T, ca.SX(len(others), len(dependent)))
    surely = ca.vertcat(*[ca.sumsqr(apart[:, k]) <= _APART**2 * ca.sumsqr(rest[k, :]) for k in range(len(dependent))])
    ways = ca.SX(held.J.size1(), len(dependent))
    ways[others, :] = -shares
    ways[list(dependent), :] = ca.SX.eye(len(dependent))
    return ways @ ca.diag(surely), surely


def _where_it_matters(kinematics: Kinematics, slopes: ca.SX) -> ca.SX:
    """Without what vanishes at all places, whose terms only cancel in numbers."""
    (numbers,) = at_declared_values(kinematics, [slopes])
    symbols = [x for x in ca.symvar(numbers) if x.__hash__() in symbols_in(slopes)]
    sizes = np.zeros(slopes.shape)
    for seed in (5, 6):
        here = ca.DM(general_numbers(seed, 0.3, 1.7, len(symbols)))
        found = ca.evalf(ca.substitute(numbers, ca.vertcat(ca.SX(0, 1), *symbols), here)).full()
        sizes = np.maximum(sizes, np.abs(found))
    rows, columns = np.nonzero(sizes > _NOTHING * sizes.max(initial=0.0))
    left = ca.SX(*slopes.shape)
    for i, k in zip(map(int, rows), map(int, columns), strict=True):
        left[i, k] = slopes[i, k]
    return left
