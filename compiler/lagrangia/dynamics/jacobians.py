"""Motion -> the matrix of implicit steps, on one sparse pattern.

An implicit step solves, for several numbers mu (real or complex, about 1/step),

    [ mu M + C + K/mu   J^T ] [ x ]
    [ mu J + B + A/mu   0   ] [ l ]        M a + h + J^T lambda = 0,   J a + bias = 0

with C = dh/dv, K = d(M a + h + J^T lambda)/dq at given a and lambda, B = d bias/dv and A = d(J a + bias)/dq. It is
mu S0 + S1 + S2/mu on one pattern. For few coordinates, or columns of few colours, all values are written out; otherwise one
function gives products with a direction: it is as long as the equations, and is called twice a colour. Elimination takes the
columns in an order of little fill; the memory it can need, whatever rows it pivots on, is bounded beforehand.
Sources: E. Hairer, G. Wanner, Solving Ordinary Differential Equations II (1996), IV.8; A. George, E. Ng, Symbolic factorization
for sparse Gaussian elimination with partial pivoting, SIAM J. Sci. Stat. Comput. 8 (1987).
"""

from collections.abc import Mapping

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.dynamics.motion import Motion, coupled_pairs
from lagrangia.frames.kinematics import Kinematics

# Written out, a Jacobian has some such many operations as the equations times the colours of its columns: above this, compiling
# takes longer than runs save (a chain of 20 links: 0.7 s for 22 000).
_LONGEST = 4_000
_MOST_ENTRIES = 2_000_000  # of the matrix: some 1 400 links in a chain
# Coordinates up to which it is made with the scene: of a chain of 100 it takes a quarter of the compilation, of 1 000 two fifths,
# and few runs ask for it.
_AT_ONCE = 30
# Sparse elimination pays when it takes so many times fewer operations than dense loops, which run several times faster.
_SPARSE_PAYS = 6


@dataclass(frozen=True)
class Jacobian:
    """Either `parts` are S0, S1, S2 as vectors of values, or `tangent` is {S0 (dv, 0), S1 (dv, 0) + S2 (dq, 0)} for the symbols
    `along`; `pattern` holds column starts, rows, the order of the columns, and the colour of those of the coordinates."""

    parts: tuple[ca.SX, ...]
    tangent: tuple[ca.SX, ...]
    along: tuple[ca.SX, ca.SX]
    pattern: tuple[int, ...]
    sizes: Mapping[str, int]  # n_entries; n_lower, n_upper: entries of the factors, 0 when elimination is dense; n_colours;
    # jacobian_waits where there are none of them yet

    @property
    def values(self) -> tuple[ca.SX, ...]:
        """Whichever there are."""
        return self.parts or self.tangent


def waits(motion: Motion) -> bool:
    """Whether what few runs ask for is made when they do: this matrix, and the momenta of conservative steps."""
    return bool(motion.q.numel() > _AT_ONCE)


def build_jacobian(kinematics: Kinematics, motion: Motion, is_asked: bool = True) -> Jacobian:
    """Neither parts nor a tangent when the matrix would be too large to be of use: its pattern alone takes O(n^2) for a chain.
    Nor where it is large and not `is_asked`, before somebody asks: then it waits."""
    is_too_large = coupled_pairs(kinematics) > _MOST_ENTRIES
    if is_too_large or (waits(motion) and not is_asked):
        sizes = dict.fromkeys(("n_entries", "n_lower", "n_upper", "n_colours"), 0)
        return Jacobian((), (), (ca.SX(0, 1), ca.SX(0, 1)), (), sizes if is_too_large else sizes | {"jacobian_waits": 1})
    held = motion.constrained
    q, v, a, nothing = motion.q, motion.v, motion.a, ca.SX(0, 1)
    force, momentum, bias = ca.jtimes(motion.momentum, v, a) + motion.h, motion.momentum, nothing
    if held:
        force = force + ca.jtimes(held.rows.rate, v, held.symbols, True)
        bias = ca.jtimes(held.rows.rate, ca.vertcat(q, motion.t), ca.vertcat(motion.pace, 1))
        momentum = ca.vertcat(momentum, held.rows.rate)
        bias = bias + ca.jtimes(held.rows.rate, v, a)
    residual = ca.vertcat(force, bias)
    sparsity = _pattern(momentum, residual, motion)
    colours = _colours(sparsity, q.numel())
    order, n_lower, n_upper = _elimination(sparsity)
    pattern = (*sparsity.colind(), *sparsity.row(), *order, *colours)
    sizes = {"n_entries": sparsity.nnz(), "n_lower": n_lower, "n_upper": n_upper, "n_colours": max(colours, default=0) + 1}
    along = (ca.SX.sym("dq", q.numel()), ca.SX.sym("dv", v.numel()))
    if sizes["n_colours"] * ca.n_nodes(ca.vertcat(momentum, residual)) <= _LONGEST:
        return Jacobian(_written_out(momentum, residual, motion, sparsity), (), along, pattern, sizes)
    tangent = (ca.jtimes(momentum, v, along[1]), ca.jtimes(residual, ca.vertcat(q, v), ca.vertcat(*along)))
    return Jacobian((), tangent, along, pattern, sizes)


def _written_out(momentum: ca.SX, residual: ca.SX, motion: Motion, sparsity: ca.Sparsity) -> tuple[ca.SX, ...]:
    """The values of S0, S1 and S2."""
    n, size = motion.q.numel(), sparsity.size1()
    aside = ca.SX(size, size - n)
    turned = ca.vertcat(motion.constrained.J.T, ca.SX(size - n, size - n)) if motion.constrained else aside
    parts = [
        ca.horzcat(ca.jacobian(momentum, motion.v), aside),
        ca.horzcat(ca.jacobian(residual, motion.v), turned),
        ca.horzcat(ca.jacobian(residual, motion.q), aside),
    ]
    return tuple(ca.vertcat(*ca.project(part, sparsity).nonzeros()) for part in parts)


def _pattern(momentum: ca.SX, residual: ca.SX, motion: Motion) -> ca.Sparsity:
    """Of all parts, with the diagonal."""
    n, size = motion.q.numel(), residual.numel()
    found = ca.jacobian_sparsity(momentum, motion.v)
    for x in (motion.v, motion.q):
        found = found.unite(ca.jacobian_sparsity(residual, x))
    aside = ca.Sparsity(size, size - n)
    if motion.constrained:
        aside = ca.vertcat(motion.constrained.J.sparsity().T, ca.Sparsity(size - n, size - n))
    return ca.horzcat(found, aside).unite(ca.Sparsity.diag(size))


def _colours(sparsity: ca.Sparsity, n: int) -> list[int]:
    """Columns of one colour have no row in common: each takes the first colour that its rows have not seen."""
    starts, rows = sparsity.colind(), sparsity.row()
    seen: list[int] = [0] * sparsity.size1()  # colours of each row, as bits
    found = []
    for column in range(n):
        mine = rows[starts[column] : starts[column + 1]]
        taken = 0
        for row in mine:
            taken |= seen[row]
        bit = ~taken & (taken + 1)
        for row in mine:
            seen[row] |= bit
        found.append(bit.bit_length() - 1)
    return found


def _elimination(sparsity: ca.Sparsity) -> tuple[list[int], int, int]:
    """The order of the columns, and the most entries that the factors L and U can have."""
    size = sparsity.size1()
    reflectors, upper, _, order = sparsity.qr_sparse(True)
    lengths = _column_lengths(reflectors)
    rows, starts = upper.row(), upper.colind()
    operations = sum(lengths[row] for column in range(size) for row in rows[starts[column] : starts[column + 1]])
    if _SPARSE_PAYS * operations > size**3 / 3:
        return list(range(size)), 0, 0
    return list(order), reflectors.nnz(), upper.nnz()


def _column_lengths(pattern: ca.Sparsity) -> list[int]:
    starts = pattern.colind()
    return [starts[k + 1] - starts[k] for k in range(pattern.size2())]
