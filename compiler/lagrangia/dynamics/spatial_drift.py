"""Links of a tree in space, and what they do where no coordinate is accelerated.

A link is accelerated against its parent by what the rates alone make: its origin by w x (w x d) at the parent's end of the
joint, its angular velocity by w x s v. Either this is felt by all that the link carries (reset: a product with the articulated
inertia), or it is taken for granted there and all behind it is accelerated with it (carried: products with the inertias of the
bodies alone). What takes fewer operations is done, link by link, for origins and for angular velocities.
"""

from collections.abc import Sequence
from dataclasses import field

from lagrangia.algebra.duals import Scalar, added, is_zero
from lagrangia.base.records import dataclass
from lagrangia.frames.spatial_inertia import Inertia, Move, RigidInertia, Shift, Turn, Vector, cross, is_nothing

STILL: Sequence[Scalar] = (0.0,) * 3
_TURNED = 6  # operations of a turn about an axis, of a vector
_FELT, _FELT_SPIN = 33, 24  # of what is reset: the articulated inertia's product, and the sums on the way out


@dataclass(frozen=True)
class Link:
    """A rigid body and the joint between it and its parent. Its frame need not turn with the body: only `body` and what moves
    lead on to others are then different from time to time."""

    parent: int | None  # its place among the links, which stand parents first; None: the world
    moves: tuple[Move, ...]  # from the parent's frame to its own
    directions: tuple[tuple[int, Vector], ...]  # (coordinate, s (6,) in its own axes), in the order of the joint
    spin: Sequence[Scalar] = STILL  # its angular velocity against the parent, in its own axes
    spin_rate: Sequence[Scalar] = STILL  # of the spin, but for what second derivatives of coordinates add
    body: RigidInertia | None = None  # in its own frame

    def inertia_to_parent(self, I: Inertia) -> Inertia:
        """What the parent feels of an inertia at its own frame."""
        for move in reversed(self.moves):
            I = move.inertia_to_parent(I)
        return I

    def wrench_to_parent(self, wrench: Vector) -> Vector:
        """A wrench at its own frame, in the parent's."""
        for move in reversed(self.moves):
            wrench = move.wrench_to_parent(wrench) if isinstance(move, Shift) else move.to_parent(wrench)
        return wrench

    def twist_to_child(self, twist: Vector) -> Vector:
        """Of the parent's twist, what its own frame has where the joint stands still."""
        for move in self.moves:
            twist = move.twist_to_child(twist) if isinstance(move, Shift) else move.to_child(twist)
        return twist


@dataclass
class Drift:
    """Of every link, what it does where dv/dt = 0, in its own axes or in those beside its moves."""

    w: list[Sequence[Scalar]] = field(default_factory=list)
    granted: list[Vector] = field(default_factory=list)  # acceleration (6,) with which it and all that it carries moves unasked
    shifts: list[tuple[Vector, ...]] = field(default_factory=list)  # what is felt of the origin's, (3,), beside each move
    spins: list[Vector] = field(default_factory=list)  # and of the angular velocity's, (3,)


def drift_of(links: Sequence[Link], base: Sequence[Scalar] | None = None) -> Drift:
    """Root to leaf. With the acceleration (3,) of the world nothing is felt, and all is taken for granted."""
    found, is_granted = Drift(), base is not None
    for link in links:
        w = found.w[link.parent] if link.parent is not None else STILL
        granted = found.granted[link.parent] if link.parent is not None else [*(base or STILL), *STILL]
        is_reset, shifts = not is_granted and feels_shift(link), []
        spins: Vector | None = None
        for at, move in enumerate(link.moves):
            shifts.append([*STILL])
            if not isinstance(move, Shift):
                w, granted = move.to_child(w), move.to_child(granted)
                continue
            if move.is_behind and is_nothing((spun := _spun(link, w, granted, is_granted))[0][:2]):
                spins, w, granted = spun  # what is felt is felt where the link's origin is, at the end of this
            whole = move.acceleration_to_child(w, granted, is_shared=at == 0)
            if is_reset:
                shifts[-1], whole = whole, [*STILL]
            granted = [*whole, *granted[3:]]
        if spins is None:
            spins, w, granted = _spun(link, w, granted, is_granted)
        found.shifts.append(tuple(shifts))
        found.spins.append(spins)
        found.granted.append(granted)
        found.w.append(w)
    return found


def _spun(link: Link, w: Sequence[Scalar], granted: Vector, is_granted: bool) -> tuple[Vector, Vector, Vector]:
    """What is felt of the rate of the angular velocity; the angular velocity with that of the joint, and what is granted with
    it."""
    spin = added(granted[3:], added(cross(w, link.spin), link.spin_rate))
    spins, kept = ([*STILL], spin) if is_granted else _split_spin(link, spin)
    return spins, added(w, link.spin), [*granted[:3], *kept]


def feels_shift(link: Link) -> bool:
    """Whether the acceleration of its origin is reset."""
    body = link.body
    carried = _turns(link) + (0 if body is None or is_zero(body.mass) else 6 + 4 * _count(body.moment))
    return carried >= _FELT or _given_way(link) >= {0, 1, 2}


def _split_spin(link: Link, whole: Vector) -> tuple[Vector, Vector]:
    """What is felt of the angular velocity's rate, and what is taken for granted. Where the joint gives way nothing is felt."""
    free = {k - 3 for k in _given_way(link) if k >= 3}
    body, ahead = link.body, [_count(move.ahead) for move in link.moves if isinstance(move, Shift)]
    carried = _turns(link) + 2 + sum(2 * count**2 for count in ahead)
    if body is not None and body.is_flat and not body.is_diagonal:
        carried += 4 if max(ahead, default=0) < 2 else 12  # sums of products of w that shifts have, too
    elif body is not None:
        carried += 2 * _count(body.moment) + 2 * sum(_count(row) for k, row in enumerate(body.second_moment) if k not in free)
    if len(free) == 3 or carried >= _FELT_SPIN:
        return whole, [*STILL]
    kept: Vector = [0.0 if k in free else x for k, x in enumerate(whole)]
    return [x if k in free else 0.0 for k, x in enumerate(whole)], kept


def _given_way(link: Link) -> set[int]:
    """The components of a twist that directions along axes leave to themselves."""
    nonzero = [[k for k, x in enumerate(s) if not is_zero(x)] for _, s in link.directions]
    return {places[0] for places in nonzero if len(places) == 1}


def _turns(link: Link) -> int:
    """Operations that the turns of its moves take, of a vector."""
    found = 0
    for move in link.moves:
        if isinstance(move, Turn):
            found += 0 if is_zero(move.c) or is_zero(move.s) else _TURNED
        elif not isinstance(move, Shift):
            found += 15
    return found


def _count(vector: Sequence[Scalar]) -> int:
    return sum(not is_zero(x) for x in vector)
