"""The linear system of constrained motion, written out: straight-line, sparse, without pivoting, and safe without it.

    [ M  J^T ] [ x      ]   [ a ]
    [ J  0   ] [ lambda ] = [ b ]

is factored as L D L^T with -E in place of 0, E a small diagonal, and one step of iterative refinement takes E's effect out. With
E no pivot can vanish: where constraints repeat each other, or a mechanism passes a singular position, the multipliers stay
bounded and J x = b is kept as far as it can be. Where M itself is singular (massless links in a loop) J^T W J is added to it,
which changes nothing on the motions that the constraints allow. The coordinates are eliminated first, then the multipliers, each
ordered by minimum degree. Source: Vanderbei, Symmetric quasi-definite matrices (1995); Golub and Van Loan, section 3.5.
"""

from dataclasses import dataclass
from itertools import pairwise

import casadi as ca

_SMALL = 1e-10  # of E, relative to the diagonal of J M^-1 J^T


@dataclass(frozen=True)
class KKT:
    """The factored system: M (n, n), J (m, n)."""

    M: ca.SX
    J: ca.SX
    weight: ca.SX | None  # W of the augmentation, (m,)
    order: tuple[int, ...]
    diagonal: ca.SX
    upper: ca.SX

    def solve(self, a: ca.SX, b: ca.SX, refine: bool = True) -> tuple[ca.SX, ca.SX]:
        """x and lambda."""
        n = self.M.size1()
        top = a if self.weight is None else a + self.J.T @ (self.weight * b)
        found = self._backsolve(ca.vertcat(top, b))
        if refine:
            x, multipliers = found[:n], found[n:]
            rest = ca.vertcat(top - self.M @ x - self.J.T @ multipliers, b - self.J @ x)
            found = found + self._backsolve(rest)
        return found[:n], found[n:]

    def _backsolve(self, right: ca.SX) -> ca.SX:
        inverse = sorted(range(len(self.order)), key=lambda k: self.order[k])
        permuted = ca.ldl_solve(ca.densify(right)[list(self.order)], self.diagonal, self.upper, list(range(len(self.order))))
        return permuted[inverse]


def factor(M: ca.SX, J: ca.SX, is_singular: bool) -> KKT:
    """M may be singular where `is_singular`; it must be positive definite on the kernel of J."""
    n = M.size1()
    weight = None
    if is_singular:
        squares = ca.densify((J * J) @ ca.SX.ones(n))
        weight = ca.trace(M) / n / squares
        M = M + J.T @ (ca.diag(weight) @ J)
    diagonal = ca.vertcat(*[M[k, k] for k in range(n)])
    small = _SMALL * ((J * J) @ (1 / diagonal))
    K = ca.blockcat([[M, J.T], [J, -ca.diag(small)]])
    order = _order(M.sparsity(), J.sparsity())
    D, upper, _ = ca.ldl(K[list(order), list(order)], False)
    return KKT(M, J, weight, order, D, upper)


def _order(M: ca.Sparsity, J: ca.Sparsity) -> tuple[int, ...]:
    """Coordinates by minimum degree on M, then multipliers by minimum degree on the pattern of J M^-1 J^T."""
    n = M.size1()
    _, members, starts = M.scc()
    blocks = [members[i:j] for i, j in pairwise(starts)]
    pairs = [(i, j) for block in blocks for i in block for j in block]
    reach = ca.DM(ca.Sparsity.triplet(n, n, [i for i, _ in pairs], [j for _, j in pairs]), 1)
    rows = ca.DM(J, 1)
    return (*M.amd(), *(n + k for k in ca.mtimes([rows, reach, rows.T]).sparsity().amd()))
