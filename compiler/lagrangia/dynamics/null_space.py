"""The linear system of constrained motion in independent coordinates (constraints/partition.py):

    x = N z + x_b,    N^T M N z = N^T (a - M x_b),    J N = 0,    J x_b = b

The columns of N say how all coordinates move with one independent one; x_b is what b asks for while these rest. No multipliers
are needed: for a mechanism of one degree of freedom one division is left beside those of its dyads. Source: the null space method
(Kim and Vanderploeg 1986), N found by back substitution.
"""

from functools import cached_property

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.constraints.partition import Group, Partition

_DOUBTFUL = 1e-2  # sine of a transmission angle: other ways keep more digits below


@dataclass(frozen=True)
class NullSpace:
    """The system, with M (n, n) and J (m, n). Where one coordinate is independent M may be singular: N^T M N is then a sum of
    squares."""

    M: ca.SX
    J: ca.SX
    partition: Partition

    @property
    def doubt(self) -> ca.SX:
        """Above 0 where a group is near a dead point."""
        return sum((self._is_doubtful(group) for group in self.partition.groups), ca.SX(0))

    def solve(self, a: ca.SX, b: ca.SX) -> tuple[ca.SX, ca.SX]:
        """x and lambda of M x + J^T lambda = a, J x = b."""
        x = self._least(a, self._follow(b))
        return x, self._multipliers(a - self.M @ x)

    def least(self, b: ca.SX) -> ca.SX:
        """The x of least x^T M x with J x = b."""
        return self._least(ca.SX(self.M.size1(), 1), self._follow(b))

    @cached_property
    def _motions(self) -> ca.SX:
        """N, (n, d)."""
        n, independent = self.M.size1(), self.partition.independent
        N = ca.SX(n, len(independent))
        for j, k in enumerate(independent):
            N[k, j] = 1
        return self._continued(N, ca.SX(self.J.size1(), len(independent)))

    @cached_property
    def _momenta(self) -> ca.SX:
        """M N, (n, d)."""
        return self.M @ self._motions

    @cached_property
    def _factors(self) -> tuple[ca.SX, ca.SX, list[int]]:
        """Of N^T M N, (d, d)."""
        mass = self._motions.T @ self._momenta
        return tuple(ca.ldl(ca.sparsify(mass), True))

    def _least(self, a: ca.SX, x: ca.SX) -> ca.SX:
        if not self.partition.independent:
            return x
        right = self._motions.T @ a - self._momenta.T @ x
        return x + self._motions @ ca.ldl_solve(ca.densify(right), *self._factors)

    def _follow(self, b: ca.SX) -> ca.SX:
        """x_b, (n,)."""
        return self._continued(ca.SX(self.M.size1(), 1), b)

    def _continued(self, x: ca.SX, b: ca.SX) -> ca.SX:
        """Columns (n, k) of which the independent coordinates are given, continued to all with J x = b."""
        for group in self.partition.groups:
            rest = b[list(group.rows), :] - self.J[list(group.rows), :] @ x
            x[list(group.coordinates), :] = ca.sparsify(self._solved(group, rest, False))
        return x

    def _multipliers(self, rest: ca.SX) -> ca.SX:
        """lambda of J^T lambda = rest, (m,): the groups from the last to the first."""
        found = ca.SX(self.J.size1(), 1)
        for group in reversed(self.partition.groups):
            columns = list(group.coordinates)
            found[list(group.rows)] = self._solved(group, rest[columns] - self.J[:, columns].T @ found, True)
        return found

    def _is_doubtful(self, group: Group) -> ca.SX:
        """Of two coordinates: their columns are nearly in line. Of one: the others of its row act on much longer levers."""
        determinant, product = self._determinant(group)
        if product is not None:
            return ca.SX(ca.fabs(determinant) < _DOUBTFUL * ca.fabs(product))
        reach, (own,), (row,) = self.partition.reach, group.coordinates, group.rows
        others = [k for k in self.J[row, :].sparsity().get_triplet()[1] if k != own]
        levers = sum((ca.fabs(self.J[row, k]) * (_DOUBTFUL * reach[own] / reach[k]) for k in others), ca.SX(0))
        return ca.SX(ca.fabs(determinant) < levers)

    @cached_property
    def _inverses(self) -> dict[Group, ca.SX]:
        return {group: 1 / self._determinant(group)[0] for group in self.partition.groups}

    def _block(self, group: Group) -> ca.SX:
        return self.J[list(group.rows), list(group.coordinates)]

    def _determinant(self, group: Group) -> tuple[ca.SX, ca.SX | None]:
        """And, of two coordinates, the inner product of their columns: the two are the sine and the cosine of the transmission
        angle, times the columns' lengths."""
        J = self._block(group)
        if len(group.rows) == 1:
            return J, None
        return J[0, 0] * J[1, 1] - J[0, 1] * J[1, 0], J[0, 0] * J[0, 1] + J[1, 0] * J[1, 1]

    def _solved(self, group: Group, right: ca.SX, is_transposed: bool) -> ca.SX:
        """Of one group, by Cramer's rule: columns (1 or 2, k)."""
        J, inverse = self._block(group), self._inverses[group]
        if len(group.rows) == 1:
            return right * inverse
        if is_transposed:
            J = J.T
        return inverse * ca.vertcat(J[1, 1] * right[0, :] - J[0, 1] * right[1, :], J[0, 0] * right[1, :] - J[1, 0] * right[0, :])
