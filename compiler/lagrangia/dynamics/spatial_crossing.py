"""From a hinge to the next one whose axis is aslant: in oblique numbers, where less is to be done than for a shift and a turn.

Both axes are across x, their common perpendicular: the shift a is along it, the tilt, of cosine c and sine s, about it. With the
parent's axes y', z' and the child's y, z, y' = c y - s z and s z' = y - c y': rows of an inertia along y', then along s z',
follow from those along y and z. Of the parent's angular velocity w = c wy' + s wz', which is the child's wy, stands for wz': it
alone is what the parent's hinge moves, so that it is eliminated, and the child's rows of angular velocities stay as they are.
The child's origin moves with it by a / s along y', and with wy' by -a / s along y. Wrenches are told by their power with these
numbers: fx, fy, s fz, tx, ty - c / s tz, tz / s. Where s is small digits are lost: there shifts and turns stay.
Where c is 0 the child feels wy' by the shift alone. There v_z - a wy' stands for v_z until the parent's hinge is eliminated,
which then gives way to one number less, if the parent's body does not tie wy' to wz'.
"""

from collections import Counter
from collections.abc import Sequence

from lagrangia.algebra.duals import Scalar, is_zero, minus, plus, times
from lagrangia.base.records import dataclass
from lagrangia.dynamics.spatial_drift import Link, feels_shift
from lagrangia.frames.spatial_inertia import SIZE, Inertia, RigidInertia, Shift, Turn, Vector, is_nothing, no_inertia

_LEAST_SINE = 0.25  # between two hinges: digits are lost as its square
_HINGE = [0.0, 0.0, 0.0, 0.0, 0.0, 1.0]


@dataclass(frozen=True)
class Oblique:
    """Of a link's twist v_z / s stands for v_z, and c w_j + s w_z for w_z, where j is 0 or 1: x or y; until its hinge is
    eliminated v_z - a w_j for v_z, where c is 0 and s is 1."""

    j: int = 1
    c: float = 0.0
    s: float = 1.0
    a: Scalar = 0.0

    @property
    def is_plain(self) -> bool:
        """Whether the numbers are those along the axes where the hinge is eliminated."""
        return self.c == 0.0 and self.s == 1.0

    @property
    def _others(self) -> list[int]:
        return [k for k in range(SIZE) if k != 3 + self.j]

    def wrench(self, plain: Sequence[Scalar]) -> Vector:
        """Of one along the axes."""
        found = [*plain]
        found[2], found[5] = times(self.s, plain[2]), times(1.0 / self.s, plain[5])
        found[3 + self.j] = minus(plain[3 + self.j], times(self.c, found[5]))
        return found

    def load(self, body: RigidInertia, w: Sequence[Scalar], granted: Sequence[Scalar], is_shared: bool) -> Vector:
        """The wrench that a body asks for (RigidInertia.load); s is a factor of the body's own numbers."""
        found = body.load(w, granted, is_shared)
        if not self.is_plain:
            found[2] = body.scaled(self.s).force(w, granted, is_shared)[2]
            found[5] = body.scaled(1.0 / self.s).torque(w, granted)[2]
            found[3 + self.j] = minus(found[3 + self.j], times(self.c, found[5]))
        return found

    def inertia(self, I: Inertia) -> Inertia:
        """Of one along the axes. Where v_z - a w_j stands for v_z, nobody asks for that of w_j itself: it goes half the way."""
        if self.is_plain:
            return self._late(I, self.a, (3 + self.j, *self._others))
        half = [self.wrench([I[min(i, k)][max(i, k)] for k in range(SIZE)]) for i in range(SIZE)]
        return [self.wrench(column) for column in zip(*half, strict=True)]

    def late_inertia(self, I: Inertia) -> Inertia:
        """Where the hinge is eliminated."""
        return self._late(I, minus(0.0, self.a), (*self._others, 3 + self.j))

    def _late(self, I: Inertia, a: Scalar, order: Sequence[int]) -> Inertia:
        found, w = [row[:] for row in I], 3 + self.j
        for at in () if is_zero(a) else order:
            i, k = min(at, w), max(at, w)
            found[i][k] = plus(found[i][k], times(a, found[min(at, 2)][max(at, 2)]))
        return found

    def late_wrench(self, wrench: Sequence[Scalar]) -> Vector:
        """Where the hinge is eliminated."""
        found = [*wrench]
        found[3 + self.j] = minus(wrench[3 + self.j], times(self.a, wrench[2]))
        return found

    def late_twist(self, twist: Sequence[Scalar]) -> Vector:
        """Before the hinge, of one behind it."""
        return [*twist[:2], minus(twist[2], times(self.a, twist[3 + self.j])), *twist[3:]]

    def plain_inertia(self, I: Inertia) -> Inertia:
        """Along the axes, of one that does not feel w_z."""
        found, factor = [row[:] for row in I], 1.0 / self.s
        for k in (*range(SIZE), 2):
            found[min(k, 2)][max(k, 2)] = times(factor, found[min(k, 2)][max(k, 2)])
        return found

    def plain_wrench(self, wrench: Sequence[Scalar]) -> Vector:
        """Along the axes, of one that already has its torque along z."""
        return [*wrench[:2], times(1.0 / self.s, wrench[2]), *wrench[3:]]

    def of_hinge(self, wrench: Sequence[Scalar]) -> Vector:
        """Where the torque along z is that of the hinge: before it, where the number for w_z is w_z."""
        found = [*wrench]
        found[3 + self.j] = plus(wrench[3 + self.j], times(self.c / self.s, wrench[5]))
        return found

    def of_plain(self, twist: Sequence[Scalar]) -> Vector:
        """Of one along the axes, but for its turn along z, which the hinge gives."""
        return [*twist[:2], times(1.0 / self.s, twist[2]), *twist[3:]]

    def hinge_rate(self, twist: Sequence[Scalar]) -> Scalar:
        """w_z, from the numbers of this."""
        return minus(times(1.0 / self.s, twist[5]), times(self.c / self.s, twist[3 + self.j]))


PLAIN = Oblique()


@dataclass(frozen=True)
class Crossing:
    """From the oblique numbers of a hinge to those along the axes of the next, in which v_z / scale stands for v_z."""

    oblique: Oblique
    b: Scalar  # a / s
    scale: float
    count: int  # of the link's moves, instead of which it is

    def inertia_to_parent(self, I: Inertia) -> Inertia:
        """Of one that does not feel w_z."""
        j, c, b, k = self.oblique.j, self.oblique.c, self.b, self.oblique.s / self.scale
        x, y, z, wx, wy, w = 1 - j, j, 2, 4 - j, 3 + j, 5
        found = no_inertia()

        def of(i: int, k: int) -> Scalar:
            return I[min(i, k)][max(i, k)]

        def put(i: int, k: int, value: Scalar) -> Scalar:
            found[min(i, k)][max(i, k)] = value
            return value

        skew = times(k, of(y, z))
        near = minus(times(c, of(y, y)), skew)  # of y and y'
        far = minus(of(y, y), times(c, near))  # of y and s z'
        own = put(y, y, plus(times(c, minus(near, skew)), times(k * k, of(z, z))))
        mixed = put(y, z, minus(near, times(c, own)))
        put(z, z, minus(far, times(c, mixed)))
        for at, to in ((x, x), (wx, wx), (wy, w)):
            along = put(to, y, minus(times(c, of(at, y)), times(k, of(at, z))))
            put(to, z, minus(of(at, y), times(c, along)))
        pulled = found[y][w]
        put(y, w, plus(pulled, times(b, own)))
        put(z, w, plus(found[z][w], times(b, mixed)))
        for at in (x, wx):
            put(at, at, of(at, at))
            put(at, w, plus(of(at, wy), times(b, found[min(at, y)][max(at, y)])))
            put(at, wy, minus(0.0, times(b, of(at, y))))
        put(x, wx, of(x, wx))
        put(w, w, plus(of(wy, wy), times(b, plus(pulled, found[y][w]))))
        back = put(y, wy, minus(0.0, times(b, near)))
        put(z, wy, minus(0.0, times(b, far)))
        put(wy, w, minus(0.0, times(b, minus(of(y, wy), back))))
        put(wy, wy, times(times(b, b), of(y, y)))
        return found

    def wrench_to_parent(self, wrench: Sequence[Scalar]) -> Vector:
        """From the numbers along the axes of the child."""
        j, c, s = self.oblique.j, self.oblique.c, self.oblique.s
        found, force = [*wrench], wrench[j]
        found[j] = minus(times(c, force), times(s / self.scale, wrench[2]))
        found[2] = minus(force, times(c, found[j]))
        found[5] = plus(plus(wrench[3 + j], times(self.b, found[j])), times(c / s, wrench[5]))
        found[3 + j] = minus(minus(0.0, times(self.b, force)), times(1.0 / s, wrench[5]))
        return found

    def twist_to_child(self, twist: Sequence[Scalar]) -> Vector:
        """To the numbers along the axes of the child."""
        j, c, s = self.oblique.j, self.oblique.c, self.oblique.s
        found = [*twist]
        along = minus(plus(twist[j], times(self.b, twist[5])), times(c, twist[2]))
        found[j] = plus(minus(twist[2], times(self.b, twist[3 + j])), times(c, along))
        found[2] = minus(0.0, times(s / self.scale, along))
        found[3 + j], found[5] = twist[5], minus(times(c / s, twist[5]), times(1.0 / s, twist[3 + j]))
        return found


@dataclass(frozen=True)
class HalfShift:
    """By a to a parallel axis, where v_z - a w_j already stands for v_z."""

    j: int
    a: Scalar
    count: int = 1  # of the link's moves, instead of which it is

    def inertia_to_parent(self, I: Inertia) -> Inertia:
        """As Shift's."""
        found = [row[:] for row in I]
        for k in range(SIZE):
            found[k][5] = plus(I[k][5], times(self.a, plus(I[self.j][5], found[self.j][5]) if k == 5
                                              else I[min(k, self.j)][max(k, self.j)]))
        return found

    def wrench_to_parent(self, wrench: Sequence[Scalar]) -> Vector:
        """As Shift's."""
        return [*wrench[:5], plus(wrench[5], times(self.a, wrench[self.j]))]

    def twist_to_child(self, twist: Sequence[Scalar]) -> Vector:
        """As Shift's."""
        found = [*twist]
        found[self.j] = plus(twist[self.j], times(self.a, twist[5]))
        return found


def crossings(links: Sequence[Link]) -> tuple[list[Oblique], list[Crossing | HalfShift | None]]:
    """What each link's twist is told by, and how it is come to from its parent, if not by its first moves alone."""
    children = Counter(link.parent for link in links)
    told, found = [PLAIN for _ in links], list[Crossing | HalfShift | None]([None] * len(links))
    for k in reversed(range(len(links))):  # of which the last are told first
        parent = links[k].parent
        if parent is None or children[parent] != 1 or not _is_hinge(links[parent]) or feels_shift(links[k]):
            continue
        if not _gives_way(links[k]):  # time moves it
            continue
        if (way := _aslant(links[k])) is None:
            continue
        oblique, a, count = way
        if oblique.c == 0.0:
            if not is_zero(a) and not _is_tied(links[parent], oblique.j):
                told[parent], found[k] = Oblique(oblique.j, a=a), HalfShift(oblique.j, a)
            continue
        told[parent] = oblique
        found[k] = Crossing(told[parent], a if isinstance(a, float) and a == 0.0 else a / told[parent].s, told[k].s, count)
    return told, found


def _is_hinge(link: Link) -> bool:
    """Whether it gives way about z alone, by a coordinate that is the angle."""
    return len(link.directions) == 1 and all(
        isinstance(x, float) and x == y for x, y in zip(link.directions[0][1], _HINGE, strict=True))


def _is_tied(link: Link, j: int) -> bool:
    """Whether the body ties w_j to w_z."""
    return link.body is not None and not is_zero(link.body.second_moment[j][2])


def _gives_way(link: Link) -> bool:
    """Whether a turn about z is left to itself, so that it is not felt ahead of the link."""
    return any([k for k, x in enumerate(s) if not is_zero(x)] == [5] for _, s in link.directions)


def _aslant(link: Link) -> tuple[Oblique, Scalar, int] | None:
    """How a link that turns about z after it, and is shifted along it, is tilted against its parent, and the shift across."""
    shift, *others = link.moves if link.moves and isinstance(link.moves[0], Shift) else (Shift((0.0, 0.0, 0.0)), *link.moves)
    if not others or not isinstance(tilt := others[0], Turn) or tilt.axis == 2 or not isinstance(shift, Shift):
        return None
    c, s, ahead = tilt.c, tilt.s, [*shift.ahead]
    if not isinstance(c, float) or not isinstance(s, float) or abs(s) < _LEAST_SINE:
        return None
    a = ahead[tilt.axis]
    ahead[tilt.axis] = 0.0
    if not all(map(is_nothing, (ahead, shift.rate, shift.second))) or not all(map(_is_along, others[1:])):
        return None
    count = len(link.moves) - len(others) + 1
    return (Oblique(1, c, s), a, count) if tilt.axis == 0 else (Oblique(0, c, -s), minus(0.0, a), count)


def _is_along(move: object) -> bool:
    """Whether it is about z or along it."""
    if isinstance(move, Shift):
        return is_nothing([*move.ahead[:2], *move.rate, *move.second])
    return isinstance(move, Turn) and move.axis == 2
