"""Loops of a tree of bodies, closed one by one on the way from the leaves to the root: O(n) for loops hung on each other.

J M^-1 J^T of loops that hang on each other is full: what holds one moves all that it carries, and all others with it. But a
loop is felt by what carries it as inertia and a load, as a joint is. A multiplier of 1 loads what it moves with the wrench P;
towards the root P is what is left of it, for every coordinate with the direction s as for the load p of spatial_elimination.py,

    t_i = P_i . s,   P_i -= U t_i / D,   N_ij += t_i t_j / D,   g_i += t_i u / D   (g = -b as it begins)

and where all that the multiplier acts on has come together, on a body that is accelerated by A, N lambda = P . A + g gives it:

    I += P P^T / N,   p += P g / N,   and of others that are still open

    P_o -= P N_o / N,   N_oo' -= N_o N_o' / N,   g_o -= N_o g / N.

Back from the root: a = (u - sum t_i lambda_i - U . A) / D, then the multipliers of the body. Source: Sathya and Carpentier,
Constrained articulated body dynamics algorithms (2024), after Popov and Vereshchagin (1974).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from functools import cached_property
from itertools import islice
from typing import Protocol

import casadi as ca

from lagrangia.algebra.duals import Scalar, added, dot, is_zero, minus, plus, times
from lagrangia.algebra.scalars import column, scalars_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.forces import Forces
from lagrangia.dynamics.kkt import DOUBTFUL, LEAST
from lagrangia.frames.spatial_inertia import SIZE, Matrix

Vector = list[Scalar]
Inertia = list[Vector]  # the upper triangle counts
Wrenches = Mapping[int, Vector]  # by the carriers they act on


@dataclass(frozen=True)
class Carrier:
    """A rigid body with the joint that carries it, in numbers of its own axes."""

    parent: int | None  # its place among the carriers, which stand parents first; None: the world
    directions: Sequence[tuple[int, Vector]]  # (coordinate, s)
    inertia: Inertia
    inertia_to_parent: Callable[[Inertia], Inertia]
    wrench_to_parent: Callable[[Vector], Vector]
    twist_to_child: Callable[[Vector], Vector]


@dataclass(frozen=True)
class Granted:
    """What acts where the bodies have the accelerations that rates alone make: M a = r - what the wrenches on carriers take."""

    loads: Wrenches
    r: Vector  # (n,)
    w: Sequence[Sequence[Scalar]] = ()  # in space: of the carriers' axes, (3,)
    accelerations: Sequence[Vector] = ()  # in space: that their axes have then, (6,)


@dataclass(frozen=True)
class Ball:
    """The three constraints of two points held together in space, in axes of their own."""

    rows: tuple[int, ...]  # their places, along the axes of the world
    axes: Matrix  # of the world from their own
    wrenches: Sequence[Mapping[int, Vector]]  # of each of the three, by carriers
    bias: Vector  # of their rates: what they are without accelerations, (3,)


class LoopTree(Protocol):
    """along_tree.Tree."""

    @property
    def size(self) -> int:
        """How many coordinates there are."""
    def carriers(self) -> Sequence[Carrier]:
        """The bodies."""
    def on_carriers(self, forces: Forces) -> tuple[Wrenches, bool]:
        """Wrenches by carriers, and whether the world is held, too."""
    def granted(self, energies: Energies) -> Granted | None:
        """What acts; None where that is not known."""


@dataclass(frozen=True)
class _Closing:
    """A multiplier, eliminated: P / N, 1 / N, and N_o / N of those that are open."""

    row: int
    share: Vector
    inverse: Scalar
    ratios: Mapping[int, Scalar]


@dataclass(frozen=True)
class _Giving:
    """A coordinate, eliminated: s, U / D, 1 / D, and t of the multipliers that are open."""

    index: int
    direction: Vector
    share: Vector
    inverse: Scalar
    pulls: Mapping[int, Scalar]


@dataclass
class _Bonds:
    """N between multipliers, and what their own would be if no other were closed."""

    between: dict[tuple[int, int], Scalar] = field(default_factory=dict)
    plain: dict[int, Scalar] = field(default_factory=dict)
    places: dict[int, int] = field(default_factory=dict)  # of these, one after another
    sums: list[Scalar] = field(default_factory=list)  # of the first, the first two ..., as far as none has changed since
    doubt: list[ca.SX] = field(default_factory=list)
    may_vanish: bool = False  # whether nothing may move along a constraint at a position, as about an axis in space

    def add(self, i: int, j: int, value: Scalar) -> None:
        """To N_ij."""
        key = (min(i, j), max(i, j))
        self.between[key] = plus(self.between.get(key, 0.0), value)
        if i == j:
            self.plain[i] = plus(self.plain.get(i, 0.0), value)
            del self.sums[self.places.setdefault(i, len(self.places)) :]

    def take(self, i: int, j: int, value: Scalar) -> None:
        """From N_ij, of what is closed."""
        key = (min(i, j), max(i, j))
        self.between[key] = minus(self.between.get(key, 0.0), value)

    def of(self, i: int, j: int) -> Scalar:
        """N_ij."""
        return self.between.get((min(i, j), max(i, j)), 0.0)

    def pivot(self, i: int, small: float) -> Scalar:
        """N_ii and a small part of what it was; takes notice of whether digits were lost."""
        own, plain = self.of(i, i), self.plain.get(i, 0.0)
        if own is not plain or (self.may_vanish and not is_zero(plain)):
            self.doubt.append(self.is_lost(own, plain))
        found = own + self.beside(plain, small) if small else own
        return ca.SX(0) if is_zero(found) else found  # of a loop that nothing moves: told where it begins, infinite where it runs

    def beside(self, plain: Scalar, small: float) -> Scalar:
        """E: a small part of what N_ii is by itself, where it may vanish with a part of what those of others are."""
        if is_zero(plain) or not self.may_vanish:
            return small * plain
        for value in islice(self.plain.values(), len(self.sums), None):
            self.sums.append(plus(self.sums[-1], value) if self.sums else value)
        return small * (plain + LEAST * self.sums[-1])

    def is_lost(self, own: Scalar, plain: Scalar) -> ca.SX:
        """Whether N_ii has lost digits to what is closed."""
        return ca.SX(own <= DOUBTFUL * plain if self.may_vanish else own < DOUBTFUL * plain)


class ClosedTree:
    """M and the multipliers of loops, factored together. `at`: the carrier at which each closes, None for the world."""

    def __init__(self, tree: LoopTree, forces: Sequence[tuple[Wrenches, bool]], small: float) -> None:
        self.size, self.carriers, self.forces, self.small = tree.size, tree.carriers(), forces, small
        self.at = [meeting(self.carriers, *force) for force in forces]
        self.bonds = _Bonds(may_vanish=self.span == SIZE)
        self.closings: list[list[_Closing]] = [[] for _ in self.carriers]
        self.givings: list[list[_Giving]] = [[] for _ in self.carriers]
        feels = [[row[:] for row in carrier.inertia] for carrier in self.carriers]
        open_rows: list[dict[int, Vector]] = [{} for _ in self.carriers]
        for row, (wrenches, _) in enumerate(forces):
            for k, wrench in wrenches.items():
                open_rows[k][row] = wrench
        for k in reversed(range(len(self.carriers))):
            self._eliminate(k, feels, open_rows)
        self.last = [row for row, at in enumerate(self.at) if at is None]

    def _eliminate(self, k: int, feels: list[Inertia], open_rows: list[dict[int, Vector]]) -> None:
        carrier, I, P = self.carriers[k], feels[k], open_rows[k]
        for row in [row for row in P if self.at[row] == k]:
            self.closings[k].append(_close(I, P, row, self.bonds, self.small))
        for index, s in reversed(carrier.directions):
            self.givings[k].append(_give_way(I, P, index, s, self.bonds))
        if carrier.parent is None:
            return
        feels[carrier.parent] = _together(feels[carrier.parent], carrier.inertia_to_parent(I))
        whole = open_rows[carrier.parent]
        for row, wrench in P.items():
            moved = carrier.wrench_to_parent(wrench)
            whole[row] = added(whole[row], moved) if row in whole else moved

    @property
    def span(self) -> int:
        """How many numbers a twist has."""
        return len(self.carriers[0].inertia) if self.carriers else 0

    @cached_property
    def _factors(self) -> tuple[ca.SX, ca.SX, list[int]]:
        """Of N of the loops that the world closes."""
        place = {row: k for k, row in enumerate(self.last)}
        N = ca.SX(len(self.last), len(self.last))
        for (i, j), value in self.bonds.between.items():
            if i in place and j in place and not is_zero(value):
                N[place[i], place[j]] = N[place[j], place[i]] = value
        plain = [self.bonds.plain.get(row, 0.0) for row in self.last]
        E = ca.vertcat(*[self.bonds.beside(x, self.small) if self.small else 0.0 for x in plain])
        return tuple(ca.ldl(N + ca.diag(E), True))

    @property
    def doubt(self) -> ca.SX:
        """Above 0 where a pivot is much less than what it was before others were eliminated."""
        total = sum(self.bonds.doubt, ca.SX(0))
        if not self.last:
            return total
        diagonal, upper, order = self._factors
        starts = upper.sparsity().colind()
        later = [k for k in range(len(self.last)) if starts[k + 1] > starts[k] or self.bonds.may_vanish]
        plain = [self.bonds.plain.get(self.last[k], 0.0) for k in order]
        return total + sum((self.bonds.is_lost(diagonal[k], plain[k]) for k in later), ca.SX(0))

    def solve(self, b: Sequence[Scalar], acting: Granted | None = None) -> tuple[Vector, Vector]:
        """x (n,) and lambda (m,) of M x + J^T lambda = what acts, J x = b."""
        gaps: Vector = [minus(0.0, x) for x in b]
        left = self._leaf_to_root(gaps, acting)
        multipliers: Vector = [0.0] * len(b)
        if self.last:
            found = ca.ldl_solve(ca.densify(column(*[gaps[row] for row in self.last])), *self._factors)
            for row, value in zip(self.last, scalars_in(ca.densify(found)), strict=True):
                multipliers[row] = value
        return self._root_to_leaf(gaps, left, multipliers, acting), multipliers

    def rates(self, x: Sequence[Scalar]) -> Vector:
        """J x, (m,): what the wrenches feel of the bodies' motion where the coordinates have the rates x."""
        found: Vector = [0.0] * len(self.at)
        twists: list[Vector] = []
        for carrier in self.carriers:
            twist = carrier.twist_to_child(twists[carrier.parent]) if carrier.parent is not None else [0.0] * self.span
            for index, s in carrier.directions:
                twist = _further(twist, x[index], s)
            twists.append(twist)
        for row, (wrenches, _) in enumerate(self.forces):
            for k, wrench in wrenches.items():
                found[row] = plus(found[row], dot(wrench, twists[k]))
        return found

    def _leaf_to_root(self, gaps: Vector, acting: Granted | None) -> dict[int, Scalar]:
        """u of each coordinate; g becomes what it is where its multiplier is closed."""
        nothing: Vector = [0.0] * self.span
        loads = [[*(acting.loads.get(k, nothing) if acting is not None else nothing)] for k in range(len(self.carriers))]
        left: dict[int, Scalar] = {}
        for k in reversed(range(len(self.carriers))):
            p = loads[k]
            for closing in self.closings[k]:
                gap = gaps[closing.row]
                p = _further(p, gap, closing.share)
                for row, ratio in closing.ratios.items():
                    gaps[row] = minus(gaps[row], times(ratio, gap))
            for giving in self.givings[k]:
                u = minus(acting.r[giving.index] if acting is not None else 0.0, dot(giving.direction, p))
                left[giving.index], p = u, _further(p, u, giving.share)
                eased = times(u, giving.inverse)
                for row, pull in giving.pulls.items():
                    gaps[row] = plus(gaps[row], times(pull, eased))
            parent = self.carriers[k].parent
            if parent is not None:
                loads[parent] = added(loads[parent], self.carriers[k].wrench_to_parent(p))
        return left

    def _alone(self, acting: Granted | None) -> Vector:
        """Of coordinates that no carrier has, (n,), which are of inertia 1; 0 of the others."""
        carried = {index for carrier in self.carriers for index, _ in carrier.directions}
        return [0.0 if acting is None or k in carried else acting.r[k] for k in range(self.size)]

    def _root_to_leaf(self, gaps: Vector, left: Mapping[int, Scalar], multipliers: Vector, acting: Granted | None) -> Vector:
        """The accelerations; the multipliers are added."""
        found = self._alone(acting)
        twists: list[Vector] = []
        for k, carrier in enumerate(self.carriers):
            A = carrier.twist_to_child(twists[carrier.parent]) if carrier.parent is not None else [0.0] * self.span
            for giving in reversed(self.givings[k]):
                u = left[giving.index]
                for row, pull in giving.pulls.items():
                    u = minus(u, times(pull, multipliers[row]))
                a = minus(times(u, giving.inverse), dot(giving.share, A))
                found[giving.index], A = a, _further(A, a, giving.direction)
            for closing in reversed(self.closings[k]):
                value = plus(dot(closing.share, A), times(gaps[closing.row], closing.inverse))
                for row, ratio in closing.ratios.items():
                    value = minus(value, times(ratio, multipliers[row]))
                multipliers[closing.row] = value
            twists.append(A)
        return found


def meeting(carriers: Sequence[Carrier], wrenches: Wrenches, is_held: bool) -> int | None:
    """The carrier behind which all that the wrenches act on hangs; None for the world."""
    left = set(wrenches)
    if is_held or not left:
        return None
    while len(left) > 1:
        last = max(left)
        left.remove(last)
        parent = carriers[last].parent
        if parent is None:
            return None
        left.add(parent)
    return left.pop()


def _close(I: Inertia, P: dict[int, Vector], row: int, bonds: _Bonds, small: float) -> _Closing:
    """Takes a multiplier out of what is felt, and out of what others do."""
    own = P.pop(row)
    inverse = 1.0 / bonds.pivot(row, small)
    share = [times(x, inverse) for x in own]
    _add_square(I, share, own, plus)
    ratios = {other: times(N, inverse) for other in P if not is_zero(N := bonds.of(row, other))}
    for other, ratio in ratios.items():
        P[other] = [minus(x, times(ratio, y)) for x, y in zip(P[other], own, strict=True)]
        for another in ratios:
            if other <= another:
                bonds.take(other, another, times(ratio, bonds.of(row, another)))
    return _Closing(row, share, inverse, ratios)


def _give_way(I: Inertia, P: dict[int, Vector], index: int, s: Vector, bonds: _Bonds) -> _Giving:
    """Takes a coordinate out. Raises ZeroDivisionError where it moves nothing."""
    U = [dot([I[min(i, j)][max(i, j)] for j in range(len(s))], s) for i in range(len(s))]
    inverse = 1.0 / dot(s, U)
    share = [times(x, inverse) for x in U]
    pulls = {row: t for row, wrench in P.items() if not is_zero(t := dot(wrench, s))}
    axis = _axis(s)
    for row, t in pulls.items():
        P[row] = [0.0 if k == axis else minus(x, times(t, y)) for k, (x, y) in enumerate(zip(P[row], share, strict=True))]
        eased = times(t, inverse)
        for other, pull in pulls.items():
            if row <= other:
                bonds.add(row, other, times(eased, pull))
    _add_square(I, share, U, minus)
    if axis is not None:
        for k in range(len(s)):
            I[min(k, axis)][max(k, axis)] = 0.0
    return _Giving(index, s, share, inverse, pulls)


def _add_square(I: Inertia, share: Vector, whole: Vector, how: Callable[[Scalar, Scalar], Scalar]) -> None:
    for i, x in enumerate(share):
        for j in range(i, len(whole)):
            I[i][j] = how(I[i][j], times(x, whole[j]))


def _axis(s: Vector) -> int | None:
    """k when s is a multiple of the k-th unit vector."""
    nonzero = [k for k, x in enumerate(s) if not is_zero(x)]
    return nonzero[0] if len(nonzero) == 1 else None


def _further(vector: Vector, factor: Scalar, way: Vector) -> Vector:
    return [plus(x, times(factor, y)) for x, y in zip(vector, way, strict=True)]


def _together(a: Inertia, b: Inertia) -> Inertia:
    return [added(x, y) for x, y in zip(a, b, strict=True)]
