"""Constraints, M and h -> accelerations and multipliers from the index-1 system, and the corrections onto the constraints."""

from dataclasses import replace
from functools import cached_property

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.constraints.partition import Partition
from lagrangia.constraints.rows import Constraints
from lagrangia.dynamics.kkt import KKT, SMALL, SMALL_IN_SPACE, diagonal_of, factor
from lagrangia.dynamics.null_space import NullSpace
from lagrangia.dynamics.own_rows import OwnRows, WithOwnRows, factor_others, find_own_rows, form_others, knows_all
from lagrangia.dynamics.regularity import find_evenness, is_even, relative_pivots
from lagrangia.dynamics.schur import FreeTree, LoopByLoop, SchurComplement, form
from lagrangia.frames.kinematics import Kinematics

System = KKT | SchurComplement | LoopByLoop | WithOwnRows


@dataclass(frozen=True)
class ConstraintRows:
    """m constraints on rates, J v + dPhi/dt = 0, of which the first are the rates of Phi(q, t) = 0."""

    phi: ca.SX
    rate: ca.SX  # J v + dPhi/dt
    bias: ca.SX  # of their rates: J dv/dt + bias = 0


@dataclass(frozen=True)
class FreeMotion:
    """What would move if nothing held it: M dv/dt + h = 0."""

    q: ca.SX  # (n,)
    v: ca.SX
    momentum: ca.SX  # M v
    h: ca.SX
    load_power: ca.SX  # put in by loads
    tree: FreeTree | None = None  # along which M is solved; None: by its factors
    pace: ca.SX | None = None  # what v is of positions, (n,); None: the same

    def moved(self, correction: ca.SX) -> ca.SX:
        """Of positions, (n,), what a small motion along the rates is."""
        return correction if self.pace is None else ca.substitute(self.pace, self.v, ca.densify(correction))

    @cached_property
    def M(self) -> ca.SX:
        """The mass matrix, (n, n): the slopes of the momentum by the rates."""
        return ca.jacobian(self.momentum, self.v)


@dataclass(frozen=True)
class RegularMotion:
    """The same accelerations for less, where no constraint nearly repeats others: `doubt` is 0 there."""

    acceleration: ca.SX
    doubt: ca.SX
    source_power: ca.SX
    place: ca.SX  # dq, as above
    steer: ca.SX  # dv at q + dq, in the metric of q; both empty where some constraints are on rates alone


@dataclass(frozen=True)
class ConstrainedMotion:
    """What the constraints add to a motion."""

    rows: ConstraintRows
    J: ca.SX  # (m, n)
    load_power: ca.SX  # put in by loads; what moving supports put in comes to it
    multipliers: ca.SX  # lambda: M a + h + J^T lambda = 0
    symbols: ca.SX  # of the multipliers, for outputs
    place: ca.SX  # dq, one Newton correction onto Phi = 0 in the mass metric
    steer: ca.SX  # dv, the correction of the rates
    evenness: ca.SX  # of p, above 1 all over where these formulas hold; empty where they hold for all masses
    regular: RegularMotion | None
    tree: FreeTree | None = None  # along which M was solved; None: it was factored
    partition: Partition | None = None  # to whose independent coordinates the regular motion was brought down

    @property
    def way(self) -> str:
        """As Motion tells it."""
        return "independent coordinates" if self.partition else "constrained along the tree" if self.tree else "constrained"


def constraint_rows(kinematics: Kinematics, constraints: Constraints) -> ConstraintRows:
    """Phi, the rates of all rows, and what their second rates are without accelerations."""
    remaining = kinematics.without_accelerations()
    phi = ca.vertcat(*[row.value(kinematics, 0) for row in constraints.rows if row.is_holonomic])
    rate = ca.vertcat(*[row.rate(kinematics) for row in constraints.rows])
    bias = ca.vertcat(*[row.second_rate(remaining) for row in constraints.rows])
    rate, bias = ca.substitute([rate, bias], [kinematics.symbols.tau], [ca.SX(1)])
    return ConstraintRows(phi, rate, bias)


def constrain(
    kinematics: Kinematics, rows: ConstraintRows, free: FreeMotion, for_any_mass: bool
) -> tuple[ca.SX, ca.SX, ConstrainedMotion]:
    """Accelerations from the index-1 system, the power put in by loads and moving supports, and what else the constraints add.

    `for_any_mass`: formulas that hold where parameters make M singular or uneven, too.
    """
    J = ca.jacobian(rows.rate, free.v)
    own = find_own_rows(kinematics, J, free.momentum, free.v)
    if free.tree is not None and not knows_all(free.tree, own):
        free = replace(free, tree=None)
    small = SMALL_IN_SPACE if kinematics.geometry.by_rates else SMALL
    evenness = _evenness(kinematics, free, J, own)
    is_robust = for_any_mass or not is_even(kinematics, evenness)
    if free.tree is not None and not is_robust:
        system: System = form(free.tree, J, small) if own is None else form_others(free.tree, J, own, small)
    else:
        system = factor(free.M, J, is_robust, small=small) if own is None else factor_others(free.M, J, own, is_robust, small)
    acceleration, multipliers = map(ca.densify, _accelerate(system, rows, free, refine=True))  # what rests is among them
    lambdas = ca.vertcat(*[ca.SX.sym(f"lambda_{i}") for i in range(J.size1())])
    regular = None if is_robust else _regular(rows, free, system.without_small())
    place, steer = free.moved(_place(system, rows, is_robust)), system.least(-rows.rate)
    held = ConstrainedMotion(rows, J, free.load_power, multipliers, lambdas, place, steer, ca.SX(0, 1) if is_robust else evenness,
                             regular, free.tree if _tree_of(system) else None)
    return acceleration, free.load_power + _power(rows.rate, free.v, multipliers), held


def _evenness(kinematics: Kinematics, free: FreeMotion, J: ca.SX, own: OwnRows | None) -> ca.SX:
    """Of the coordinates that no cut joint keeps."""
    if free.tree is not None:
        tree = free.tree if own is None else free.tree.part(own.others, own.rows)
        mass, pivots, balance = tree.mass, tree.pivots, tree.balance
    else:
        M = free.M if own is None else own.of_matrix(free.M)
        mass, pivots, balance = diagonal_of(M), relative_pivots(M), ca.SX(0, 1)
    return ca.vertcat(find_evenness(kinematics, mass, pivots, J if own is None else own.of_slopes(J)), balance)


def _tree_of(system: System) -> FreeTree | None:
    return None if isinstance(system, KKT) else system.tree


def bring_down(held: ConstrainedMotion, free: FreeMotion, partition: Partition) -> ConstrainedMotion | None:
    """The same, regular motions in independent coordinates. None where masses are too uneven for several of them, or points
    are held together whose bodies are not known."""
    if held.evenness.numel() == 0 and len(partition.independent) > 1:
        return None
    system: NullSpace | None = None
    if not partition.points:
        system = NullSpace(free.M, held.J, partition)
    elif free.tree is not None and len(free.tree.balls) == len(partition.points):
        from lagrangia.dynamics.null_space_in_tree import null_space_in_tree

        system = null_space_in_tree(free.M, held.J, partition, free.tree)
    if system is None:
        return None
    return replace(held, regular=_regular(held.rows, free, system), partition=partition)


def _accelerate(system: System, rows: ConstraintRows, free: FreeMotion, refine: bool) -> tuple[ca.SX, ca.SX]:
    if _tree_of(system) is not None:
        assert free.tree is not None
        return system.solve(free.tree.acceleration, -rows.bias, refine)
    return system.solve(-free.h, -rows.bias, refine)


def _place(system: System, rows: ConstraintRows, is_robust: bool) -> ca.SX:
    """One Newton correction onto Phi = 0."""
    m, k = rows.rate.numel(), rows.phi.numel()
    if k == 0:
        return ca.SX.zeros(system.J.size2())
    if k == m or is_robust:  # massless coordinates may be in other rows alone
        return system.least(ca.vertcat(-rows.phi, ca.SX.zeros(m - k)))
    return system.first(k).least(-rows.phi)


def _regular(rows: ConstraintRows, free: FreeMotion, system: System | NullSpace) -> RegularMotion:
    if isinstance(system, NullSpace):
        acceleration, multipliers = system.solve(-free.h, -rows.bias)
    else:
        acceleration, multipliers = _accelerate(system, rows, free, refine=False)
    source = free.load_power + _power(rows.rate, free.v, multipliers)
    dq = dv = ca.SX(0, 1)
    if rows.phi.numel() == rows.rate.numel():
        dq = free.moved(system.least(-rows.phi))
        dv = system.least(-ca.substitute(rows.rate, free.q, free.q + dq))
    return RegularMotion(acceleration, system.doubt, source, dq, dv)


def _power(rate: ca.SX, v: ca.SX, multipliers: ca.SX) -> ca.SX:
    """lambda . dPhi/dt: what supports that move with time put in."""
    return ca.dot(multipliers, ca.substitute(rate, v, ca.SX.zeros(v.numel())))
