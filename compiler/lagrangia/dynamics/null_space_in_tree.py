"""Independent coordinates of a tree of bodies in space whose loops points close that are held together (ball_joints.py).

M is full in joint coordinates, and what would be left of it in independent ones was summed up over bodies before: here

    N^T M N = sum t_i . I t_j,    N^T (r - M x_b - ...) = N . r - sum t_i . (I t_b + p)

over the bodies' own axes, with the twists t_i of a body where one independent coordinate moves, t_b where these rest, and the
loads p that act where bodies have the accelerations that rates alone make. Source: Kane and Levinson, Dynamics (1985), whose
partial velocities t_i are.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

import casadi as ca

from lagrangia.algebra.duals import Scalar, added, dot, is_zero, minus, plus, times
from lagrangia.algebra.scalars import scalars_in
from lagrangia.base.records import dataclass
from lagrangia.constraints.partition import Partition
from lagrangia.dynamics.loops_in_tree import Ball, Carrier, Granted, Vector
from lagrangia.dynamics.null_space import NullSpace
from lagrangia.dynamics.schur import FreeTree
from lagrangia.frames.spatial_inertia import SIZE, momentum, scaled


@dataclass(frozen=True)
class NullSpaceInTree(NullSpace):
    """The system, with J (m, n) in the balls' own axes."""

    tree: FreeTree

    def solve(self, a: ca.SX, b: ca.SX) -> tuple[ca.SX, ca.SX]:
        """x and lambda where x are the accelerations: what acts is known by bodies, b of balls in their own axes."""
        b = self._turned(b)
        for ball in self.tree.balls:
            b[list(ball.rows)] = -ca.vertcat(*ball.bias)
        x = self._least_with(self._follow(b), self.tree.acting)
        multipliers = self._multipliers(a - self.M @ x)
        for ball in self.tree.balls:
            rows = list(ball.rows)
            multipliers[rows] = _matrix(ball) @ multipliers[rows]
        return x, multipliers

    def least(self, b: ca.SX) -> ca.SX:
        """The x of least x^T M x with J x = b, along the axes of the world."""
        return self._least_with(self._follow(self._turned(b)), None)

    def _turned(self, b: ca.SX) -> ca.SX:
        found = ca.densify(b)
        for ball in self.tree.balls:
            rows = list(ball.rows)
            found[rows] = _matrix(ball).T @ found[rows]
        return found

    @cached_property
    def _carriers(self) -> Sequence[Carrier]:
        return self.tree.bodies.carriers()

    @cached_property
    def _uncarried(self) -> list[int]:
        """The places of coordinates that move no body, as those whose rates are first-order states."""
        moved = {index for carrier in self._carriers for index, _ in carrier.directions}
        return [j for j, k in enumerate(self.tree.chosen) if k not in moved]

    @cached_property
    def _partial(self) -> list[list[Vector]]:
        """The twists t_i of all carriers, for each independent coordinate."""
        return [twists_of(self._carriers, self._by_places(self._motions[:, j])) for j in range(self._motions.size2())]

    @cached_property
    def _factors(self) -> tuple[ca.SX, ca.SX, list[int]]:
        """Of N^T M N, (d, d)."""
        uncarried = self._uncarried
        motions = self._motions[uncarried, :]
        mass = motions.T @ self.M[uncarried, uncarried] @ motions
        for j, twists in enumerate(self._partial):
            momenta = self._momenta_of(twists)
            for i in range(j + 1):
                if not is_zero(value := _power(self._partial[i], momenta)):
                    mass[i, j] = mass[j, i] = mass[i, j] + value
        return tuple(ca.ldl(mass, True))

    def _momenta_of(self, twists: Sequence[Vector]) -> list[Vector]:
        return [momentum(carrier.inertia, twist) for carrier, twist in zip(self._carriers, twists, strict=True)]

    def _by_places(self, x: ca.SX) -> Mapping[int, Scalar]:
        """Of the tree's coordinates what is not 0."""
        values = zip(self.tree.chosen, scalars_in(ca.densify(x)), strict=True)
        return {k: value for k, value in values if not ca.SX(value).is_zero()}

    def _least_with(self, x: ca.SX, acting: Granted | None) -> ca.SX:
        if not self.partition.independent:
            return x
        taken = self._momenta_of(twists_of(self._carriers, self._by_places(x)))
        for k, load in (acting.loads if acting is not None else {}).items():
            taken[k] = added(taken[k], load)
        right = [minus(0.0, _power(twists, taken)) for twists in self._partial]
        if acting is not None:
            for j in range(len(right)):
                for k, value in self._by_places(self._motions[:, j]).items():
                    right[j] = plus(right[j], times(value, acting.r[k]))
        return x + self._motions @ ca.ldl_solve(ca.vertcat(*right), *self._factors)


def null_space_in_tree(M: ca.SX, J: ca.SX, partition: Partition, tree: FreeTree) -> NullSpaceInTree | None:
    """None where rows along axes of bodies know of more than they seemed to with the parameters as declared."""
    own = J[:, :]
    carriers = tree.bodies.carriers()
    known = {k for carrier in carriers for k, _ in carrier.directions}
    units = {j: twists_of(carriers, {k: 1.0}) for j, k in enumerate(tree.chosen) if k in known}
    for ball in tree.balls:
        for row, wrenches in zip(ball.rows, ball.wrenches, strict=True):
            slopes = ca.SX(1, J.size2())
            for j, twists in units.items():
                value: Scalar = 0.0
                for k, wrench in wrenches.items():
                    value = plus(value, dot(wrench, twists[k]))
                if not ca.SX(value).is_zero():
                    slopes[j] = value
            own[row, :] = slopes
    own = ca.sparsify(own)
    return NullSpaceInTree(M, own, partition, tree) if _follows(partition, own) else None


def twists_of(carriers: Sequence[Carrier], x: Mapping[int, Scalar]) -> list[Vector]:
    """Of all carriers, where coordinates have these rates and others none."""
    found: list[Vector] = []
    for carrier in carriers:
        twist = carrier.twist_to_child(found[carrier.parent]) if carrier.parent is not None else [0.0] * SIZE
        for k, s in carrier.directions:
            twist = added(twist, scaled(x[k], s)) if k in x else twist
        found.append(twist)
    return found


def _power(twists: Sequence[Vector], wrenches: Sequence[Vector]) -> Scalar:
    found: Scalar = 0.0
    for twist, wrench in zip(twists, wrenches, strict=True):
        found = plus(found, dot(twist, wrench))
    return found


def _matrix(ball: Ball) -> ca.SX:
    return ca.vertcat(*[ca.horzcat(*row) for row in ball.axes])


def _follows(partition: Partition, J: ca.SX) -> bool:
    """Whether the rows of every group know of nothing but what is known before, and its own."""
    known, rows = set(partition.independent), J.sparsity().get_triplet()
    members: dict[int, set[int]] = {}
    for row, k in zip(*rows, strict=True):
        members.setdefault(row, set()).add(k)
    for group in partition.groups:
        known.update(group.coordinates)
        if any(not members.get(row, set()) <= known for row in group.rows):
            return False
    return True
