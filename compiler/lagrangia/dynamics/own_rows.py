"""Coordinates that cut joints keep (frames/spatial_joints.py): each moves no mass and stands in one constraint of its own.

What acts on such a coordinate is what its constraint carries; the others are solved without both, and then it follows:

    lambda_o = a_o / c,    M x + J^T lambda = a - J_o^T lambda_o,  J x = b,    y = (b_o - J_o x) / c
"""

from dataclasses import replace
from functools import cached_property

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.dynamics.kkt import KKT, factor
from lagrangia.dynamics.schur import FreeTree, LoopByLoop, SchurComplement, form
from lagrangia.frames.kinematics import Kinematics


@dataclass(frozen=True)
class OwnRows:
    """Of n coordinates and m constraints, (row, coordinate) of these pairs, and the places of the others."""

    pairs: tuple[tuple[int, int], ...]
    others: tuple[int, ...]  # coordinates
    rows: tuple[int, ...]  # constraints of these

    def of_matrix(self, M: ca.SX) -> ca.SX:
        """M (n, n), of the others."""
        return M[list(self.others), list(self.others)]

    def of_slopes(self, J: ca.SX) -> ca.SX:
        """J (m, n), of the others."""
        return J[list(self.rows), list(self.others)]


def find_own_rows(kinematics: Kinematics, J: ca.SX, momentum: ca.SX, v: ca.SX) -> OwnRows | None:
    """None where cut joints keep nothing, or all that they keep moves masses, as an energy of the model says, or something else
    moves by it, too. `momentum` (n,) of the rates v (n,)."""
    names = {name: k for k, name in enumerate(kinematics.symbols.positions)}
    (m, n), pattern = J.shape, J.sparsity()
    users: dict[int, list[int]] = {}
    for row, k in zip(*pattern.get_triplet(), strict=True):
        users.setdefault(k, []).append(row)
    pairs, heavy = [], set[int]()
    moving = ca.vertcat(kinematics.algebra.state, kinematics.symbols.time)
    if kinematics.graph.kept_coordinates:
        for pair in zip(*ca.jacobian_sparsity(momentum, v).get_triplet(), strict=True):
            heavy.update(pair)
    for name in sorted(kinematics.graph.kept_coordinates):
        k = names.get(name)
        if k is not None and k not in heavy and len(users.get(k, ())) == 1 and not ca.depends_on(J[users[k][0], k], moving):
            pairs.append((users[k][0], k))
    if not pairs:
        return None
    own, rows = {k for _, k in pairs}, {row for row, _ in pairs}
    return OwnRows(tuple(pairs), tuple(k for k in range(n) if k not in own), tuple(r for r in range(m) if r not in rows))


def knows_all(tree: FreeTree, own: OwnRows | None) -> bool:
    """Whether the bodies of a tree move by all that is left: they know nothing of what cut joints keep."""
    left = own.others if own is not None else range(tree.bodies.size)
    kept = tree.bodies.kinematics.graph.kept_coordinates
    return not any(name in kept for k, name in enumerate(tree.bodies.kinematics.symbols.positions) if k in left)


@dataclass(frozen=True)
class WithOwnRows:
    """The system, with M (n, n) and J (m, n): `inner` is that of the others, None where no row is left for these."""

    inner: KKT | SchurComplement | LoopByLoop
    J: ca.SX
    own: OwnRows
    count: int  # the rows that count: those behind it are not asked for

    @property
    def tree(self) -> FreeTree | None:
        """Along which M of the others is solved."""
        return None if isinstance(self.inner, KKT) else self.inner.tree

    @property
    def doubt(self) -> ca.SX:
        """Above 0 where the others' system loses digits."""
        return self.inner.doubt

    @cached_property
    def _slopes(self) -> ca.SX:
        return self.J[[row for row, _ in self.own.pairs], list(self.own.others)]

    @cached_property
    def _scale(self) -> ca.SX:
        return ca.vertcat(*[self.J[row, k] for row, k in self.own.pairs])

    def solve(self, a: ca.SX, b: ca.SX, refine: bool = True) -> tuple[ca.SX, ca.SX]:
        """x and lambda. Along the tree, a is M^-1 a."""
        held = ca.densify(a)[[k for _, k in self.own.pairs]] / self._scale
        pull = self._slopes.T @ held
        is_free = bool(ca.densify(held).is_zero())
        others = ca.densify(a)[list(self.own.others), 0]
        if not isinstance(self.inner, KKT):
            others = others if is_free else others - self.inner.tree.solve(pull)
        elif not is_free:
            others = others - pull
        x, multipliers = self.inner.solve(others, ca.densify(b)[list(self.own.rows), 0], refine)
        whole = ca.SX.zeros(self.J.size1())
        whole[list(self.own.rows)] = multipliers
        whole[[row for row, _ in self.own.pairs]] = held
        return self._with_own(x, b), whole

    def least(self, b: ca.SX) -> ca.SX:
        """The x of least x^T M x with J x = b."""
        return self._with_own(self.inner.least(ca.densify(b)[list(self.own.rows), 0]), b)

    def first(self, k: int) -> "WithOwnRows":
        """The system of the first k constraints alone."""
        own = replace(self.own, rows=tuple(row for row in self.own.rows if row < k))
        return replace(self, inner=self.inner.first(len(own.rows)), own=own, count=k)

    def without_small(self) -> "WithOwnRows":
        """The system without E; M of the others must be regular."""
        return replace(self, inner=self.inner.without_small())

    def _with_own(self, x: ca.SX, b: ca.SX) -> ca.SX:
        found = ca.SX.zeros(self.J.size2())
        found[list(self.own.others)] = x
        own = [row for row, _ in self.own.pairs]
        values = (ca.densify(b)[[row if row < b.numel() else 0 for row in own]] - self._slopes @ x) / self._scale
        for k, (row, coordinate) in enumerate(self.own.pairs):
            found[coordinate] = values[k] if row < self.count else 0
        return found


def factor_others(M: ca.SX, J: ca.SX, own: OwnRows, is_singular: bool, small: float) -> WithOwnRows:
    """With M factored."""
    return WithOwnRows(factor(own.of_matrix(M), own.of_slopes(J), is_singular, small=small), J, own, J.size1())


def form_others(tree: FreeTree, J: ca.SX, own: OwnRows, small: float) -> WithOwnRows:
    """Along the tree of bodies."""
    part = tree.part(own.others, own.rows)
    return WithOwnRows(form(part, own.of_slopes(J), small), J, own, J.size1())


