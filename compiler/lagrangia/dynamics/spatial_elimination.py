"""M a = r solved along a tree of rigid bodies in space, leaf to root, in the axes of each body: O(n) for any tree.

A link is a body with the joint that carries it. From its parent's frame moves lead to its own: constant turns, a shift, the turn
of the joint; there its directions are, for a hinge the unit vector of wz. Towards the root, for every direction s:

    U = I s,   D = s . U,   I -= U U^T / D,   p += U u / D,   u = r - s . p.

Of a unit vector U is a column, and its row and column of what is left are 0, so that the turn that comes next is cheaper. Then
p += I c with c, the acceleration at dv/dt = 0 of the link against its parent (spatial_drift.py), and I and p go the moves back.
From the root: A = X A + c, a = (u - U . A) / D, A += s a. A uniform field is an acceleration of the root. To a hinge that is
aslant to the one before it ways are shorter in oblique numbers (spatial_crossing.py), by which the twist of the parent is told.
Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 7; McMillan and Orin, Efficient computation of
articulated-body inertias using successive axial screws (1995), for the turns about two axes instead of one matrix.
"""

from collections.abc import Mapping, Sequence
from functools import cached_property

from lagrangia.algebra.duals import Scalar, added, dot, is_zero, minus, plus, times
from lagrangia.base.records import dataclass
from lagrangia.dynamics.spatial_crossing import PLAIN, Crossing, Oblique, crossings
from lagrangia.dynamics.spatial_drift import STILL, Drift, Link
from lagrangia.frames.spatial_inertia import (
    SIZE,
    Inertia,
    Shift,
    Vector,
    is_nothing,
    momentum,
    no_inertia,
    scaled,
    together,
)


@dataclass(frozen=True)
class _Direction:
    """A coordinate, eliminated."""

    index: int
    direction: Vector  # s
    axis: int | None  # where s is not 0, if it is a multiple of a unit vector
    inverse: Scalar  # -1 / D: by 1 / D CasADi would divide each number anew
    share: Vector  # -U / D


@dataclass(frozen=True)
class _Factor:
    """What is left of a link: its directions, last first, and the inertia that is felt before each move back to the parent."""

    directions: tuple[_Direction, ...]
    left: Inertia
    shifted: tuple[Inertia | None, ...]  # beside each move: at the child's end of a shift


class SpatialTree:
    """M, factored along links. `size`: coordinates; those that no link has are alone and of inertia 1."""

    def __init__(self, links: Sequence[Link], size: int) -> None:
        self.links, self.size = links, size
        self.factors: list[_Factor] = []
        self.told, self.crossings = crossings(links)
        feels = [told.inertia(I) for told, I in zip(self.told, self._inertias(), strict=True)]
        for k in reversed(range(len(links))):
            link, I = links[k], feels[k]
            directions = tuple(_reduce(I, index, s) for index, s in reversed(link.directions))
            I = self.told[k].late_inertia(I)
            felt, shifted = self._to_parent(k, I)
            self.factors.append(_Factor(directions, I, shifted))
            if link.parent is not None:
                feels[link.parent] = together(felt, feels[link.parent])
        self.factors.reverse()
        moved = {index for link in links for index, _ in link.directions}
        self.alone = [k for k in range(size) if k not in moved]

    def _inertias(self) -> list[Inertia]:
        return [link.body.matrix() if link.body is not None else no_inertia() for link in self.links]

    def _to_parent(self, k: int, I: Inertia) -> tuple[Inertia, tuple[Inertia | None, ...]]:
        """What the parent feels, and what is felt at the child's end of each shift. Nobody feels for the world."""
        moves, crossing = self.links[k].moves, self.crossings[k]
        shifted: list[Inertia | None] = [None] * len(moves)
        if self.links[k].parent is None:
            return I, tuple(shifted)
        I = self._scaling(k).plain_inertia(I)
        for at in reversed(range(self._crossed(k), len(moves))):
            move = moves[at]
            shifted[at] = I if isinstance(move, Shift) else None
            I = move.inertia_to_parent(I)
        return crossing.inertia_to_parent(I) if crossing else I, tuple(shifted)

    def _crossed(self, k: int) -> int:
        """How many of a link's moves it is come to by its crossing."""
        crossing = self.crossings[k]
        return crossing.count if crossing else 0

    def _scaling(self, k: int) -> Oblique:
        """By what a link's numbers ahead of its hinge are told, if its crossing does not see to that."""
        return PLAIN if isinstance(self.crossings[k], Crossing) else self.told[k]

    @property
    def pivots(self) -> list[Scalar]:
        """D of each coordinate, (n,)."""
        found: list[Scalar] = [1.0] * self.size
        for told, factor in zip(self.told, self.factors, strict=True):
            for direction in factor.directions:
                found[direction.index] = -told.s * told.s / direction.inverse
        return found

    @cached_property
    def diagonal(self) -> list[Scalar]:
        """Of M, (n,): s . I s with the inertia of all that the coordinate moves."""
        whole, found = self._inertias(), [1.0] * self.size
        for k in reversed(range(len(self.links))):
            link = self.links[k]
            for index, s in link.directions:
                found[index] = dot(s, momentum(whole[k], s))
            if link.parent is not None:
                whole[link.parent] = together(link.inertia_to_parent(whole[k]), whole[link.parent])
        return found

    def bias_loads(self, drift: Drift, is_plain: bool = True) -> dict[int, Vector]:
        """The wrenches that the bodies ask for where they turn as they do and have the accelerations taken for granted, by their
        places; along axes or, if not plain, by the numbers that twists are told by."""
        leading = {link.parent for link in self.links if link.moves and isinstance(link.moves[0], Shift)}
        return {k: (PLAIN if is_plain else told).load(link.body, drift.w[k], drift.granted[k], k in leading)
                for k, (link, told) in enumerate(zip(self.links, self.told, strict=True)) if link.body is not None}

    def solve(self, r: Sequence[Scalar], loads: Mapping[int, Vector], drift: Drift | None = None,
              base: Sequence[Scalar] = STILL) -> list[Scalar]:
        """The accelerations (n,) with M a = r less what the wrenches on links take from the motion, in their axes; with `drift`
        also what bodies and joints ask for at dv/dt = 0. `base`: the acceleration of the world, (3,)."""
        p = self.bias_loads(drift, is_plain=False) if drift else {}
        for k, load in loads.items():
            p[k] = added(p.get(k, [0.0] * SIZE), self.told[k].wrench(load))
        left = self._leaf_to_root(r, [p.get(k, [0.0] * SIZE) for k in range(len(self.links))], drift)
        found: list[Scalar] = [0.0] * self.size
        for k in self.alone:
            found[k] = r[k]
        twists: list[Vector] = []
        for k, link in enumerate(self.links):
            twist = twists[link.parent] if link.parent is not None else [*base, *STILL]
            told, crossing = self.told[k], self.crossings[k]
            twist = crossing.twist_to_child(twist) if crossing else twist
            for at, move in enumerate(link.moves[self._crossed(k) :], self._crossed(k)):
                if isinstance(move, Shift):
                    twist = move.twist_to_child(twist)
                    twist = [*added(twist[:3], drift.shifts[k][at]), *twist[3:]] if drift else twist
                else:
                    twist = move.to_child(twist)
            twist = self._scaling(k).of_plain(twist)
            if drift:
                twist = [*twist[:3], *added(twist[3:], drift.spins[k])]
            twist = told.late_twist(twist)
            for direction in reversed(self.factors[k].directions):
                found[direction.index], twist = _accelerated(direction, left[direction.index], twist, told)
            twists.append(twist)
        return found

    def _leaf_to_root(self, r: Sequence[Scalar], p: list[Vector], drift: Drift | None) -> dict[int, Scalar]:
        """u of each coordinate."""
        left: dict[int, Scalar] = {}
        late = {k: [*p[k][:5], 0.0] for k, told in enumerate(self.told) if not is_zero(told.a)}  # added after the hinge
        for k in late:
            p[k] = [*[0.0] * 5, p[k][5]]
        for k in reversed(range(len(self.links))):
            link, factor, load, told, crossing = self.links[k], self.factors[k], p[k], self.told[k], self.crossings[k]
            for direction in factor.directions:
                u = minus(times(1.0 / told.s, r[direction.index]), dot(direction.direction, load))
                load, left[direction.index] = told.of_hinge(_passed_on(direction, load, r[direction.index], u)), u
            if link.parent is None:
                continue
            if k in late:
                load = added(told.late_wrench(load), late[k])
            if drift and not is_nothing(drift.spins[k]):
                load = added(load, momentum(factor.left, [*STILL, *drift.spins[k]]))
            load = self._scaling(k).plain_wrench(load)
            for at in reversed(range(self._crossed(k), len(link.moves))):
                move = link.moves[at]
                if not isinstance(move, Shift):
                    load = move.to_parent(load)
                    continue
                felt = factor.shifted[at]
                if drift and felt is not None and not is_nothing(drift.shifts[k][at]):
                    load = added(load, momentum(felt, [*drift.shifts[k][at], *STILL]))
                load = move.wrench_to_parent(load)
            p[link.parent] = added(crossing.wrench_to_parent(load) if crossing else load, p[link.parent])
        return left


def _reduce(I: Inertia, index: int, s: Vector) -> _Direction:
    """Takes from the inertia what the coordinate gives way to; along an axis nothing is left. Raises ZeroDivisionError where the
    coordinate moves nothing."""
    U, axis = momentum(I, s), _axis(s)
    inverse = -1.0 / dot(s, U)
    share = [times(x, inverse) if k != axis else 0.0 for k, x in enumerate(U)]
    for i in range(SIZE):
        for j in range(i, SIZE):
            I[i][j] = plus(I[i][j], times(share[i], U[j])) if axis not in (i, j) else 0.0
    return _Direction(index, s, axis, inverse, share)


def _axis(s: Vector) -> int | None:
    """k when s is a multiple of the k-th unit vector."""
    nonzero = [k for k, x in enumerate(s) if not is_zero(x)]
    return nonzero[0] if len(nonzero) == 1 else None


def _passed_on(direction: _Direction, p: Vector, r: Scalar, u: Scalar) -> Vector:
    """The load that is left for what carries the joint; along an axis it is exactly what r says."""
    found = [minus(x, times(u, share)) for x, share in zip(p, direction.share, strict=True)]
    if direction.axis is not None:
        factor = direction.direction[direction.axis]
        found[direction.axis] = r if isinstance(factor, float) and factor == 1.0 else 0.0 if is_zero(r) else r / factor
    return found


def _accelerated(direction: _Direction, u: Scalar, twist: Vector, told: Oblique) -> tuple[Scalar, Vector]:
    """The coordinate's acceleration, and the twist with it."""
    axis, s = direction.axis, direction.direction
    others = minus(dot(direction.share, twist), times(u, direction.inverse))
    if axis is None:
        return others, added(twist, scaled(others, s))
    found = [*twist]
    if isinstance(s[axis], float) and s[axis] == 1.0:  # u / D - U . A / D is the whole component, which knows no rounding of A's
        found[axis] = others
        return minus(others if told.is_plain else told.hinge_rate(found), twist[axis]), found
    found[axis] = times(s[axis], others)
    rest = 0.0 if is_zero(twist[axis]) else twist[axis] / s[axis]
    return minus(others, rest), found
