"""Joints in space as they are written -> links in axes of their own, in which few operations are left.

A hinge's link has z along the hinge, and its origin on it, mostly nearest to the parent's. From the parent's z to its own a turn
about z and one about x lead; the first adds to the angle of the parent's hinge, once. Where the tilt is a number, not a small
one, the frame lies where the common perpendicular to the next hinge begins: both shifts are then along axes, and what the joint
gives way along is 0 where they and the tilt take it. Hinges that follow each other about parallel axes share axes that turn with
none of them, as bodies of the plane do: then their bodies are turned, not all that they carry. A slider keeps the axes of its
parent. What follows from parameters alone is worked out once, before a run.
Source: Denavit and Hartenberg (1955); Craig, Introduction to Robotics (1989), for the frame at the near end of a link.
"""

import math
from collections.abc import Sequence
from dataclasses import replace
from typing import Any

import casadi as ca

from lagrangia.algebra.duals import Scalar, added, dot, is_zero, minus, plus, times
from lagrangia.algebra.scalars import as_expression
from lagrangia.base.records import dataclass
from lagrangia.dynamics.spatial_drift import STILL, Link
from lagrangia.dynamics.spatial_regrouping import Meeting, regrouped
from lagrangia.frames.spatial_inertia import (
    SAME,
    Matrix,
    Move,
    RigidInertia,
    Rotation,
    Shift,
    Turn,
    Vector,
    composed,
    cross,
    is_nothing,
    product,
    transposed,
)

_MOST_SLID = 8  # links in a row
_LEAST_SINE = 0.12  # between two hinges whose common perpendicular is at most eight times as far as where they are written
_EXACT = 4e-16  # what differs less from 0, 1 or -1 is that number: cos(pi/2) is 6e-17


@dataclass(frozen=True)
class SpatialJoint:
    """A joint in space: in the parent's frame at the end of a constant pose, the frame behind it turned or shifted.

    kind "turn": about `axis` by `amount`, with the rate and the second derivative that `motion` tells, and of a screw along it by
    `travel`: a length, its rate, its second derivative and its slope by the coordinate; "shift": by the vector
    `ahead`, likewise; "rotation": to the axes that are the columns of `attitude`, with the angular velocity and its rate in them.
    Second derivatives are those at dv/dt = 0.
    """

    parent: int | None  # its place among the joints, which stand parents first; None: the world
    kind: str
    R: Matrix  # of the constant pose: its axes are columns along the parent's
    origin: Sequence[Scalar]
    coordinates: tuple[int, ...]  # at most one of a turn, three of a rotation; none where time moves it
    slopes: Sequence[Any] = (1.0,)  # by its coordinates, of the amount, or of the shift (3,)
    axis: Sequence[Scalar] = (0.0, 0.0, 1.0)  # of length 1, in the axes of the constant pose
    amount: Scalar = 0.0
    ahead: Sequence[Scalar] = STILL
    attitude: Matrix = SAME
    motion: tuple[Sequence[Scalar], Sequence[Scalar]] = (STILL, STILL)  # (1,) of a turn
    body: RigidInertia | None = None  # in the frame behind it
    travel: Sequence[Scalar] = ()


@dataclass(frozen=True)
class Seat:
    """Where the frame behind a joint sits in its link: its vectors are turned by G, then about z by an angle."""

    link: int | None  # None: the world
    G: Matrix = SAME
    origin: Sequence[Scalar] = STILL  # before the turn about z
    angle: Scalar = 0.0
    slid: int = 0  # links since one had its origin where its hinge is written

    @property
    def turn(self) -> Turn:
        """About z."""
        return _turn(2, self.angle)

    def to_link(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the link's axes, (3,)."""
        return self.turn.to_parent(product(self.G, vector))

    def steady(self, body: RigidInertia | None) -> RigidInertia | None:
        """A body of the frame in axes in which it is constant: the link's but for the turn about z."""
        return body.placed(self.G, self.origin) if body is not None and not body.is_nothing else None

    def turned(self, body: RigidInertia | None) -> RigidInertia | None:
        """The same in the link's axes."""
        return body if body is None or is_zero(self.angle) else body.turned(self.turn)


def lay_axes(joints: Sequence[SpatialJoint]) -> tuple[list[Link], list[Seat]]:
    """A link for each joint, and where the frame behind it sits in it."""
    layout = _Layout(joints)
    for k in range(len(joints)):
        layout.lay(k)
    bodies = [seat.steady(joint.body) for joint, seat in zip(joints, layout.seats, strict=True)]
    bodies = regrouped([*map(layout.meeting, range(len(joints)))], bodies)
    return [replace(link, body=seat.turned(body)) for link, seat, body in
            zip(layout.links, layout.seats, bodies, strict=True)], layout.seats


class _Layout:
    def __init__(self, joints: Sequence[SpatialJoint]) -> None:
        self.joints = joints
        self.children: list[list[int]] = [[] for _ in joints]
        for k, joint in enumerate(joints):
            if joint.parent is not None:
                self.children[joint.parent].append(k)
        self.follows = [self._is_parallel(joint) for joint in joints]
        self.seats: list[Seat] = []
        self.links: list[Link] = []
        self.led: dict[int, _Way] = {}  # to hinges that their parent's angle is led to

    def lay(self, k: int) -> None:
        """The next link; those before it are there."""
        joint = self.joints[k]
        seat = self.seats[joint.parent] if joint.parent is not None else Seat(None)
        if joint.kind == "shift":
            moves, own, directions = self._slide(joint, seat)
            spin = spin_rate = STILL
        elif joint.kind == "rotation":
            moves, own = self._turn_freely(joint, seat)
            directions, (spin, spin_rate) = [[*STILL, *row] for row in SAME], joint.motion
        else:
            moves, own, sign = self._follow(joint, seat) if self.follows[k] else self._tilt(k, joint, seat)
            directions = [[*STILL, 0.0, 0.0, times(sign, slope)] for slope in joint.slopes]
            spin, spin_rate = ([0.0, 0.0, times(sign, x[0])] for x in joint.motion)
            if joint.travel:
                *along, slope = joint.travel
                ahead, rate, second = ([0.0, 0.0, x] for x in along)
                moves = (*moves, Shift(ahead, rate, second))
                directions = [[0.0, 0.0, slope, *turning[3:]] for turning in directions]
        pairs = tuple(zip(joint.coordinates, directions, strict=False))  # of no coordinate where time moves it
        self.links.append(Link(joint.parent, moves, pairs, spin, spin_rate))
        self.seats.append(own)

    def meeting(self, k: int) -> Meeting:
        """Where a joint meets the link of its parent."""
        joint, own = self.joints[k], self.seats[k]
        seat = self.seats[joint.parent] if joint.parent is not None else Seat(None)
        centre = added(seat.origin, product(seat.G, joint.origin))
        if joint.kind != "turn" or joint.travel:
            return Meeting(joint.parent, "screw" if joint.travel else joint.kind, centre)
        axis = SAME[2] if self.follows[k] else product(_product(seat.G, joint.R), joint.axis)
        return Meeting(joint.parent, joint.kind, centre, axis, own.origin[2])

    def _is_parallel(self, joint: SpatialJoint) -> bool:
        """Whether a hinge is parallel to the hinge that its parent is, whatever the parameters."""
        if joint.parent is None or joint.kind != "turn" or joint.travel or self.joints[joint.parent].kind != "turn":
            return False
        before, own = self.joints[joint.parent].axis, _snapped(product(joint.R, joint.axis))
        if all(isinstance(x, float) for x in (*before, *own)):
            along = dot(before, own)
            return all(abs(x - along * y) <= _EXACT for x, y in zip(own, before, strict=True))
        return all(_is_same(x, y) for x, y in zip(own, before, strict=True))

    def _slide(self, joint: SpatialJoint, seat: Seat) -> tuple[tuple[Move, ...], Seat, list[Vector]]:
        """In the axes of the parent's link; the last are its directions."""
        G = _product(seat.G, joint.R)
        place = added(added(seat.origin, product(seat.G, joint.origin)), product(G, joint.ahead))
        own = Seat(len(self.links), G, STILL, seat.angle)
        rate, second = map(own.to_link, joint.motion)
        shift = Shift(seat.turn.to_parent(place), rate, second)
        return (shift,), own, [[*own.to_link(slope), *STILL] for slope in joint.slopes]

    def _turn_freely(self, joint: SpatialJoint, seat: Seat) -> tuple[tuple[Move, ...], Seat]:
        """In the axes of the frame behind it."""
        place = added(seat.origin, product(seat.G, joint.origin))
        turns = () if is_zero(seat.angle) else (seat.turn,)
        return (*turns, Shift(place), Rotation(_product(_product(seat.G, joint.R), joint.attitude))), Seat(len(self.links))

    def _follow(self, joint: SpatialJoint, seat: Seat) -> tuple[tuple[Move, ...], Seat, Scalar]:
        """A hinge parallel to the one before it, in the same axes; the last is 1, or -1 where it turns the other way."""
        place, origin, slid = _slid(added(seat.origin, product(seat.G, joint.origin)), seat)
        G = _product(seat.G, joint.R)
        along = product(G, joint.axis)[2]
        sign = along if isinstance(along, float) else 1.0
        moves = (Shift(seat.turn.to_parent(place)),)
        return moves, Seat(len(self.links), G, origin, plus(seat.angle, times(sign, joint.amount)), slid), sign

    def _tilt(self, k: int, joint: SpatialJoint, seat: Seat) -> tuple[tuple[Move, ...], Seat, Scalar]:
        """Any other hinge: tilted to have z along it, and turned with it where none that follows is parallel."""
        way = self.led.get(k) or _way(joint, seat.G, seat.origin)
        ahead = _turn(2, 0.0, way.lead)
        W = _along_child(way.tilt, _along_child(ahead, _product(seat.G, joint.R)))
        if way.foot is not None:
            origin, slid = [0.0, 0.0, way.beyond], 1
            found: list[Move] = [Shift(way.foot), way.tilt]
        else:
            place = way.tilt.to_child(ahead.to_child(added(seat.origin, product(seat.G, joint.origin))))
            place, origin, slid = _slid(place, seat)
            found = [way.tilt, Shift(place)]
        moves = [move for move in (_turn(2, seat.angle, way.lead), *found) if not _is_nothing(move)]
        if any(self.follows[child] for child in self.children[k]):
            return tuple(moves), Seat(k, _about(joint.axis, W), origin, joint.amount, slid), 1.0
        onward, tail = self._lead_on(k, W, origin)
        moves.append(_turn(2, joint.amount, onward))
        if not is_zero(tail):
            moves.append(Shift([0.0, 0.0, tail], is_behind=True))
            origin = [0.0, 0.0, minus(origin[2], tail)]
        return tuple(moves), Seat(k, _about(joint.axis, _along_child(_turn(2, 0.0, onward), W)), origin, slid=slid), 1.0

    def _lead_on(self, k: int, W: Matrix, origin: Vector) -> tuple[Scalar, Scalar]:
        """What to add to the angle of a hinge so that the next one is tilted about x or y alone, and how far along z its own
        origin is to be so that the next one's is on the other axis of that tilt."""
        for child in self.children[k]:
            joint = self.joints[child]
            if joint.kind == "turn":
                way = _way(joint, W, origin)
                x, y, z = way.foot or STILL
                self.led[child] = replace(way, lead=0.0, foot=[x, y, 0.0] if way.foot is not None else None)
                return way.lead, z
        return 0.0, 0.0


@dataclass(frozen=True)
class _Way:
    """From a hinge to the next: turned about z by `lead`, then to `foot`, the nearest point of the next hinge to this one,
    which is written `beyond` it, then tilted. None of a foot that may be far away."""

    lead: Scalar
    tilt: Turn
    foot: Vector | None = None
    beyond: Scalar = 0.0


def _way(joint: SpatialJoint, G: Matrix, origin: Sequence[Scalar]) -> _Way:
    """To a hinge that is written in axes G from an origin."""
    lead, tilt = _way_to(product(_product(G, joint.R), joint.axis))
    if not isinstance(tilt.s, float) or abs(tilt.s) < _LEAST_SINE:
        return _Way(lead, tilt)
    place, along = _turn(2, 0.0, lead).to_child(added(origin, product(G, joint.origin))), tilt.to_parent(SAME[2])
    across = 1 - tilt.axis
    beyond = 0.0 if is_zero(place[across]) else place[across] / along[across]
    foot = [minus(x, times(beyond, n)) for x, n in zip(place, along, strict=True)]
    foot[across] = 0.0
    return _Way(lead, tilt, foot, beyond)


def _slid(place: Sequence[Scalar], seat: Seat) -> tuple[Vector, Vector, int]:
    """Where a link's origin is, on its hinge and nearest to the parent's, where the hinge is written from there, and how many
    links in a row have slid so: about origins that are far away inertias have fewer digits."""
    x, y, z = place
    if is_zero(z):
        return [x, y, 0.0], [0.0] * 3, 0
    if seat.slid < _MOST_SLID:
        return [x, y, 0.0], [0.0, 0.0, z], seat.slid + 1
    return [x, y, z], [0.0] * 3, 0


def _way_to(axis: Sequence[Scalar]) -> tuple[Scalar, Turn]:
    """The angle about z, and the turn about x or y after it, that lead from z to an axis."""
    x, y, z = _snapped(axis)
    if is_zero(x):
        return 0.0, _tilted(0, z, minus(0.0, y))
    if is_zero(y):
        return 0.0, _tilted(1, z, x)
    if isinstance(x, float) and isinstance(y, float):
        return math.atan2(x, -y), _tilted(0, z, math.hypot(x, y))
    return as_expression(ca.atan2(x, -y)), _tilted(0, z, as_expression(ca.sqrt(plus(times(x, x), times(y, y)))))


def _tilted(axis: int, c: Scalar, s: Scalar) -> Turn:
    """By an angle whose cosine and sine are in this ratio: what rounding makes longer would grow from link to link."""
    if all(isinstance(x, float) and x in (0.0, 1.0, -1.0) for x in (c, s)):
        return Turn(axis, c, s)
    size = _root(plus(times(c, c), times(s, s)))
    return Turn(axis, *(0.0 if is_zero(x) else x / size for x in (c, s)))


def _about(axis: Sequence[Scalar], G: Matrix) -> Matrix:
    """G, which takes the axis to z, orthogonal to the last digit however many links lie before it."""
    if all(isinstance(x, float) for row in G for x in row):
        return G
    along = dot(G[0], axis)
    first = [minus(x, times(along, n)) for x, n in zip(G[0], axis, strict=True)]
    size = _root(dot(first, first))
    first = [0.0 if is_zero(x) else x / size for x in first]
    return [first, cross(axis, first), [*axis]]


def _root(x: Scalar) -> Scalar:
    return math.sqrt(x) if isinstance(x, float) else as_expression(ca.sqrt(x))


def _turn(axis: int, amount: Scalar, more: Scalar = 0.0) -> Turn:
    """By amount + more. Quarters are exact."""
    if isinstance(amount, float) and isinstance(more, float):
        amount, more = 0.0, amount + more
    quarters = round(2 * more / math.pi) if isinstance(more, float) else 0
    if isinstance(more, float) and abs(more - quarters * math.pi / 2) <= _EXACT * (1 + abs(quarters)):
        more = 0.0
    else:
        quarters = 0
    total = plus(amount, more)
    if isinstance(total, float):
        cos, sin = math.cos(total), math.sin(total)
    else:
        cos, sin = as_expression(ca.cos(total)), as_expression(ca.sin(total))
    for _ in range(quarters % 4):
        cos, sin = minus(0.0, sin), cos
    return Turn(axis, cos, sin)


def _along_child(turn: Turn, R: Matrix) -> list[Vector]:
    """The axes that are R's columns, in components along the turned axes."""
    return [_snapped(row) for row in transposed([turn.to_child(column) for column in transposed(R)])]


def _product(a: Matrix, b: Matrix) -> list[Vector]:
    return [_snapped(row) for row in composed(a, b)]


def _is_nothing(move: Move) -> bool:
    if isinstance(move, Shift):
        return is_nothing(move.ahead)
    return isinstance(move, Turn) and is_zero(move.s) and isinstance(move.c, float) and move.c == 1.0


def _snapped(vector: Sequence[Scalar]) -> Vector:
    """With 0, 1 and -1 for numbers that only rounding tells from them."""
    return [float(round(x)) if isinstance(x, (float, int)) and abs(x - round(x)) <= _EXACT else x for x in vector]


def _is_same(a: Scalar, b: Scalar) -> bool:
    return bool(a == b) if isinstance(a, float) and isinstance(b, float) else bool(ca.is_equal(ca.SX(a), ca.SX(b), 2))
