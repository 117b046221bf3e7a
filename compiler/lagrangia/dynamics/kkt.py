"""The linear system of constrained motion, written out: straight-line, sparse, without pivoting, and safe without it.

    [ M  J^T ] [ x      ]   [ a ]
    [ J  0   ] [ lambda ] = [ b ]

is factored as L D L^T with -E in place of 0, E a small diagonal, and one step of iterative refinement takes E's effect out. With
E no pivot can vanish: where constraints repeat each other, or a mechanism passes a singular position, the multipliers stay
bounded and J x = b is kept as far as it can be. Where M itself is singular (massless links in a loop) J^T W J is added to it,
which changes nothing on the motions that the constraints allow; W is the mass of the coordinates in a row, by the row's own
scale, so that a light mechanism beside a heavy one keeps its digits. Refinement knows M without it: beside the W of a heavy body
that it is tied to the inertia of a light one is rounded. Away from such places E and the refinement, a quarter of all
operations, can be left out: `doubt` tells where not. Each multiplier is eliminated after all its coordinates:
after all coordinates at all where M is sparse (rounding at singular positions is least then), as soon as may be where J^T W J
has filled M in. Source: Vanderbei, Symmetric quasi-definite matrices (1995); Golub and Van Loan, section 3.5.
"""

from heapq import heapify, heappop, heappush
from itertools import pairwise

import casadi as ca

from lagrangia.base.records import dataclass

SMALL = 1e-10  # of E, relative to the diagonal of J M^-1 J^T
# The same where rows repeat each other at all closed positions and at no others, as those of loops in space do: beside these,
# where the stages of steps are, squares of the gaps must not be more. Measured on Bricard's six-bar: 523 steps to 62.
SMALL_IN_SPACE = 1e-7
LEAST = 1e-13  # of E in space, relative to that of all constraints: along one nothing may move at a position, about an axis say
DOUBTFUL = 1e-6  # pivots without E below this, relative to the same: with E and a refinement they keep more digits


@dataclass(frozen=True)
class KKT:
    """The factored system: M (n, n), J (m, n)."""

    M: ca.SX
    J: ca.SX
    weight: ca.SX | None  # W of the augmentation, (m,)
    order: tuple[int, ...]
    diagonal: ca.SX
    upper: ca.SX
    small: float = SMALL

    @property
    def _may_vanish(self) -> bool:
        """Whether nothing may move along a constraint at a position, as about an axis in space."""
        return self.small == SMALL_IN_SPACE

    @property
    def doubt(self) -> ca.SX:
        """Above 0 where J M^-1 J^T loses digits: a pivot is much less than what it was before others were eliminated."""
        n, total, pattern = self.M.size1(), ca.SX(0), self.upper.sparsity()
        starts, rows = pattern.colind(), pattern.row()
        for k, row in enumerate(self.order):
            above = [i for i in rows[starts[k] : starts[k + 1]] if i < k]
            if row < n or (not self._may_vanish and all(self.order[i] < n for i in above)):
                continue
            before = sum((self.upper[i, k] ** 2 * self.diagonal[i] for i in above if self.order[i] < n), ca.SX(0))
            total += -self.diagonal[k] <= DOUBTFUL * before if self._may_vanish else -self.diagonal[k] < DOUBTFUL * before
        return total

    def solve(self, a: ca.SX, b: ca.SX, refine: bool = True) -> tuple[ca.SX, ca.SX]:
        """x and lambda."""
        n = self.M.size1()
        top = a if self.weight is None else a + self.J.T @ (self.weight * b)
        found = self._backsolve(ca.vertcat(top, b))
        if refine:
            x, multipliers = found[:n, :], found[n:, :]
            missed = b - self.J @ x
            forces = multipliers if self.weight is None else multipliers - self.weight * missed
            found = found + self._backsolve(ca.vertcat(a - self.M @ x - self.J.T @ forces, missed))
        return found[:n, :], found[n:, :]

    def least(self, b: ca.SX) -> ca.SX:
        """The x of least x^T M x with J x = b."""
        return self.solve(ca.SX.zeros(self.M.size1()), b, refine=False)[0]

    def first(self, k: int) -> "KKT":
        """The system of the first k constraints alone; M must be regular."""
        return factor(self.M, self.J[:k, :], False, small=self.small)

    def without_small(self) -> "KKT":
        """The system without E; M must be regular."""
        return factor(self.M, self.J, False, is_regular=True)

    def _backsolve(self, right: ca.SX) -> ca.SX:
        inverse = sorted(range(len(self.order)), key=lambda k: self.order[k])
        permuted = ca.ldl_solve(ca.densify(right)[list(self.order)], self.diagonal, self.upper, list(range(len(self.order))))
        return permuted[inverse]


def factor(M: ca.SX, J: ca.SX, is_singular: bool, is_regular: bool = False, small: float = SMALL) -> KKT:
    """M may be singular where `is_singular`; it must be positive definite on the kernel of J. Without E where `is_regular`."""
    n = M.size1()
    weight, augmented = None, M
    if is_singular:
        squares = ca.densify((J * J) @ ca.SX.ones(n))
        weight = _masses(M, J) / squares
        augmented = M + J.T @ (ca.diag(weight) @ J)
    E = ca.SX.zeros(J.size1()) if is_regular else small * ((J * J) @ (1 / diagonal_of(augmented)))
    if small == SMALL_IN_SPACE and not is_regular:
        least = LEAST * ca.sum1(E)
        E = ca.vertcat(ca.SX(0, 1), *[x if x.is_zero() else x + least for x in ca.vertsplit(ca.densify(E))])
    K = ca.blockcat([[augmented, J.T], [J, -ca.diag(E)]])
    order = (_front if is_singular else _levels)(augmented.sparsity(), J.sparsity())
    D, upper, _ = ca.ldl(K[list(order), list(order)], False)
    return KKT(M, J, weight, order, D, upper, small)


def diagonal_of(M: ca.SX) -> ca.SX:
    """(n,), with its zeros."""
    return ca.vertcat(ca.SX(0, 1), *[M[k, k] for k in range(M.size1())])


def count_operations(M: ca.Sparsity, J: ca.Sparsity) -> int:
    """Multiplications and additions of the factors, where M is regular."""
    rows, order = ca.DM(J, 1), list(_levels(M, J))
    K = ca.blockcat([[ca.DM(M, 1), rows.T], [rows, ca.DM.eye(J.size1())]])
    upper, _ = K[order, order].sparsity().ldl(False)
    below = [0] * len(order)
    for row in upper.row():
        below[row] += 1
    return sum(count * (count + 1) for count in below)


def _masses(M: ca.SX, J: ca.SX) -> ca.SX:
    """The mass of the coordinates in each row; of all where these have none (bars of a truss, integrals), 1 where nothing has.
    None where nothing has any and the rows are too few to hold it: no pivot is to hide that nothing determines the motion."""
    own = diagonal_of(M)
    of_rows = ca.vertsplit(ca.densify(ca.DM(J.sparsity(), 1) @ own))
    total = ca.sum1(own)
    anything = ca.SX(1) if J.size1() >= J.size2() else ca.if_else(ca.sum1(own) > 0, 1, 0)
    others = ca.if_else(total > 0, total, anything)
    return ca.vertcat(ca.SX(0, 1), *[ca.if_else(x > 0, x, others) for x in of_rows])


def _levels(M: ca.Sparsity, J: ca.Sparsity) -> tuple[int, ...]:
    """Coordinates by minimum degree on M, then multipliers by minimum degree on the pattern of J M^-1 J^T."""
    n = M.size1()
    _, members, starts = M.scc()
    blocks = [members[i:j] for i, j in pairwise(starts)]
    pairs = [(i, j) for block in blocks for i in block for j in block]
    reach = ca.DM(ca.Sparsity.triplet(n, n, [i for i, _ in pairs], [j for _, j in pairs]), 1)
    rows = ca.DM(J, 1)
    return (*M.amd(), *(n + k for k in ca.mtimes([rows, reach, rows.T]).sparsity().amd()))


def _front(M: ca.Sparsity, J: ca.Sparsity) -> tuple[int, ...]:
    """Minimum degree on the whole matrix, a multiplier not before the last of its coordinates, when its pivot is as large as it
    will be. A row of loops is so eliminated loop by loop: what is filled in grows with their number, also where M couples them.
    """
    n, m = M.size1(), J.size1()
    neighbours: list[set[int]] = [set() for _ in range(n + m)]
    for i, j in zip(*M.get_triplet(), strict=True):
        neighbours[i] |= {j} - {i}
    users: list[list[int]] = [[] for _ in range(n)]
    waiting = [0] * (n + m)  # coordinates that a multiplier waits for
    for r, k in zip(*J.get_triplet(), strict=True):
        neighbours[n + r].add(k)
        neighbours[k].add(n + r)
        users[k].append(n + r)
        waiting[n + r] += 1
    queue = [(len(neighbours[k]), k) for k in range(n + m) if not waiting[k]]
    heapify(queue)
    order: list[int] = []
    left = set(range(n + m))
    while queue:
        degree, k = heappop(queue)
        if k not in left or degree != len(neighbours[k]):
            continue  # it has been taken, or stands in the queue with its present degree, too
        left.remove(k)
        order.append(k)
        for user in users[k] if k < n else ():
            waiting[user] -= 1
        for other in neighbours[k]:
            neighbours[other] |= neighbours[k]
            neighbours[other] -= {k, other}
            if not waiting[other]:
                heappush(queue, (len(neighbours[other]), other))
    return tuple(order)
