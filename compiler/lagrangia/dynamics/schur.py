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
from lagrangia.base.records import dataclass
from lagrangia.dynamics.along_tree import Tree
from lagrangia.dynamics.forces import Forces
from lagrangia.dynamics.kkt import DOUBTFUL, SMALL, count_operations

# Operations along the tree, of a body and of a body for each constraint that moves all; and of an entry of M. Measured on ropes.
_BODY, _PASS, _ENTRY = 75, 30, 16
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
        return FreeTree(self.bodies, self.acceleration[list(among)], [self.forces[k] for k in rows],
                        [self.chosen[k] for k in among])

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


def form(tree: FreeTree, J: ca.SX, small: float = SMALL) -> SchurComplement:
    """J M^-1 J^T by way of the tree of bodies, (m, m)."""
    reach = tree.reach(J)
    product = J @ reach
    above = ca.triu(product, False)
    return SchurComplement(tree, J, reach, above + above.T + ca.diag(ca.diag(product)), False, small)


def prefers(M: ca.Sparsity, J: ca.Sparsity) -> bool | None:
    """Whether this takes less than forming M and factoring it with J; None where that is to be counted."""
    m, n = J.shape
    most = (_BODY + m * (_PASS + m)) * n + m**3 / 3
    whole = count_operations(M, J) + _ENTRY * M.nnz()
    if max(most, whole) > _MANY:
        return bool(most < _HALF * whole)
    return True if _SHORTER * most < whole else False if most > _LONGER * whole else None


__all__ = ["FreeTree", "SchurComplement", "form", "prefers"]
