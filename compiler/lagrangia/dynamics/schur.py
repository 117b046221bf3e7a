"""The linear system of constrained motion by its multipliers, where M is solved along the tree of bodies:

    J M^-1 J^T lambda = J M^-1 a - b,    x = M^-1 (a - J^T lambda)

In joint coordinates the M of a long loop is full: to write out its factors takes n^3/3 operations (kkt.py), this so many a
body, and a third of it again for each constraint. As there, a small E on the diagonal of J M^-1 J^T keeps every pivot from 0
where constraints repeat each other or a mechanism passes a singular position, a step of refinement takes its effect out, and
`doubt` tells where they are needed.
"""

from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property, reduce

import casadi as ca

from lagrangia.algebra.duals import is_zero
from lagrangia.algebra.scalars import column, scalars_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.along_tree import Tree
from lagrangia.dynamics.forces import Forces
from lagrangia.dynamics.kkt import DOUBTFUL, SMALL, count_operations
from lagrangia.dynamics.loops_in_tree import Ball, ClosedTree, Granted, meeting

# Operations along the tree, of a body and of a body for each constraint that moves all; and of an entry of M. Measured on ropes.
_BODY, _PASS, _ENTRY = 75, 30, 16
_DENSE = 6  # entries of J for each body and each constraint
# Ratios of these estimates that leave no doubt; between them both ways are written out and counted, unless that is too much. Many
# constraints move no more than half of the bodies each.
_LONGER, _SHORTER, _MANY, _HALF = 8, 3, 50_000, 2
# The mass of a body beside that of another one.
_HEAVIER = 1e3


@dataclass(frozen=True)
class FreeTree:
    """The tree, of which some coordinates, that act on no others, are looked at."""

    bodies: Tree
    acceleration: ca.SX  # -M^-1 h of these coordinates, (n,)
    forces: Sequence[Forces | None]  # of their constraints, where it is known what bodies they act on, (m,)
    chosen: Sequence[int]  # their places among all
    acting: Granted | None = None  # what makes the acceleration, where that is known
    balls: Sequence[Ball] = ()  # of their constraints

    @property
    def mass(self) -> ca.SX:
        """The diagonal of M, (n,)."""
        return self.bodies.diagonal[list(self.chosen)]

    @property
    def pivots(self) -> ca.SX:
        """Of the factors of M, relative to its diagonal, (n,)."""
        return self.bodies.pivots[list(self.chosen)] / self.mass

    @property
    def balance(self) -> ca.SX:
        """Above 1 where no body is so much lighter than another one that what the tree would do alone is nearly all taken back by
        the constraints, and its digits with it."""
        masses = [ca.SX(x) for x in self.bodies.masses if not is_zero(x)]
        return _HEAVIER * reduce(ca.fmin, masses) / reduce(ca.fmax, masses) if masses else ca.SX(0)

    def part(self, among: Sequence[int], rows: Sequence[int]) -> "FreeTree":
        """Some of these coordinates, with their constraints."""
        line = {row: k for k, row in enumerate(rows)}
        balls = [replace(ball, rows=tuple(line[row] for row in ball.rows)) for ball in self.balls if ball.rows[0] in line]
        return FreeTree(self.bodies, self.acceleration[list(among), 0], [self.forces[k] for k in rows],
                        [self.chosen[k] for k in among], self.acting, balls)

    def solve(self, r: ca.SX) -> ca.SX:
        """M^-1 r, (n,)."""
        whole = ca.SX(self.bodies.size, 1)
        whole[list(self.chosen)] = r
        return self.bodies.solve(whole)[list(self.chosen)]

    def reach(self, J: ca.SX) -> ca.SX:
        """M^-1 J^T, (n, m)."""
        columns = [self.solve(J[k, :].T) if force is None else -self.bodies.yield_to(force)[list(self.chosen)]
                   for k, force in enumerate(self.forces)]
        return ca.horzcat(*[ca.sparsify(column) for column in columns])


@dataclass(frozen=True)
class SchurComplement:
    """The system, with M (n, n) and J (m, n)."""

    tree: FreeTree
    J: ca.SX
    reach: ca.SX  # M^-1 J^T, (n, m)
    S: ca.SX  # J M^-1 J^T, (m, m)
    is_regular: bool  # without E
    small: float = SMALL

    @cached_property
    def _factors(self) -> tuple[ca.SX, ca.SX]:
        small = 0.0 if self.is_regular else self.small
        diagonal, upper, _ = ca.ldl(self.S + ca.diag(small * ca.diag(self.S)), False)
        return diagonal, upper

    @property
    def doubt(self) -> ca.SX:
        """Above 0 where S loses digits: a pivot is much less than what it was before others were eliminated."""
        diagonal, upper = self._factors
        starts = upper.sparsity().colind()
        later = [k for k in range(self.J.size1()) if starts[k + 1] > starts[k]]
        return sum((diagonal[k] < DOUBTFUL * self.S[k, k] for k in later), ca.SX(0))

    def solve(self, free: ca.SX, b: ca.SX, refine: bool = True) -> tuple[ca.SX, ca.SX]:
        """x and lambda; free (n,) is M^-1 a."""
        right = self.J @ free - b
        multipliers = self._backsolve(right)
        if refine:
            multipliers = multipliers + self._backsolve(right - self.S @ multipliers)
        return free - self.reach @ multipliers, multipliers

    def least(self, b: ca.SX) -> ca.SX:
        """The x of least x^T M x with J x = b."""
        return self.reach @ self._backsolve(b)

    def first(self, k: int) -> "SchurComplement":
        """The system of the first k constraints alone."""
        return replace(self, J=self.J[:k, :], reach=self.reach[:, :k], S=self.S[:k, :k])

    def without_small(self) -> "SchurComplement":
        """The system without E."""
        return replace(self, is_regular=True)

    def _backsolve(self, right: ca.SX) -> ca.SX:
        diagonal, upper = self._factors
        return ca.ldl_solve(ca.densify(right), diagonal, upper, list(range(self.J.size1())))


@dataclass(frozen=True)
class LoopByLoop:
    """The system, factored loop by loop (loops_in_tree.py)."""

    tree: FreeTree
    J: ca.SX
    is_regular: bool  # without E
    small: float = SMALL

    @cached_property
    def _closed(self) -> ClosedTree:
        bodies = self.tree.bodies
        wrenches = [bodies.on_carriers(force) for force in self.tree.forces if force is not None]
        return ClosedTree(bodies, wrenches, 0.0 if self.is_regular else self.small)

    @property
    def doubt(self) -> ca.SX:
        """Above 0 where digits are lost: a pivot is much less than what it was before others were eliminated."""
        return self._closed.doubt

    def solve(self, free: ca.SX, b: ca.SX, refine: bool = True) -> tuple[ca.SX, ca.SX]:
        """x and lambda; free (n,) is M^-1 a."""
        acting = self.tree.acting
        if acting is not None and ca.is_equal(free, self.tree.acceleration, 1):
            x, multipliers = self._closed_by(b, acting)
        else:
            x, multipliers = self._closed_by(b - self._rates(free))
            x = free + x
        if refine:
            more, pull = self._closed_by(b - self._rates(x))
            x, multipliers = x + more, multipliers + pull
        return x, multipliers

    def least(self, b: ca.SX) -> ca.SX:
        """The x of least x^T M x with J x = b."""
        return self._closed_by(b)[0]

    def first(self, k: int) -> "LoopByLoop":
        """The system of the first k constraints alone."""
        return replace(self, J=self.J[:k, :], tree=replace(self.tree, forces=self.tree.forces[:k]))

    def without_small(self) -> "LoopByLoop":
        """The system without E."""
        return replace(self, is_regular=True)

    def _rates(self, x: ca.SX) -> ca.SX:
        """J x, by the shorter way: where loops are written in axes of the world, what carries them stands in J, too."""
        if self.J.nnz() <= _DENSE * (len(self._closed.carriers) + self.J.size1()):
            return self.J @ x
        whole = ca.SX.zeros(self.tree.bodies.size)
        whole[list(self.tree.chosen)] = x
        return column(*self._closed.rates(scalars_in(whole)))

    def _closed_by(self, b: ca.SX, acting: Granted | None = None) -> tuple[ca.SX, ca.SX]:
        x, multipliers = self._closed.solve(scalars_in(ca.densify(b)), acting)
        return column(*x)[list(self.tree.chosen)], column(*multipliers)


def form(tree: FreeTree, J: ca.SX, small: float = SMALL) -> SchurComplement | LoopByLoop:
    """J M^-1 J^T by way of the tree of bodies, (m, m); where some loops close within the tree, one by one."""
    in_space = tree.bodies.kinematics.geometry.by_rates
    if all(force is not None for force in tree.forces) and (in_space or _has_inner_loops(tree)):
        return LoopByLoop(tree, J, False, small)
    reach = tree.reach(J)
    product = J @ reach
    above = ca.triu(product, False)
    return SchurComplement(tree, J, reach, above + above.T + ca.diag(ca.diag(product)), False, small)


def _has_inner_loops(tree: FreeTree) -> bool:
    carriers = tree.bodies.carriers()
    return any(meeting(carriers, *tree.bodies.on_carriers(force)) is not None for force in tree.forces if force is not None)


def prefers(M: ca.Sparsity, J: ca.Sparsity, is_loop_by_loop: bool) -> bool | None:
    """Whether this takes less than forming M and factoring it with J; None where that is to be counted."""
    m, n = J.shape
    if is_loop_by_loop:
        return True if count_operations(M, J) + _ENTRY * M.nnz() > _MANY else None
    most = (_BODY + m * (_PASS + m)) * n + m**3 / 3
    whole = count_operations(M, J) + _ENTRY * M.nnz()
    if max(most, whole) > _MANY:
        return bool(most < _HALF * whole)
    return True if _SHORTER * most < whole else False if most > _LONGER * whole else None


__all__ = ["FreeTree", "LoopByLoop", "SchurComplement", "form", "prefers"]
