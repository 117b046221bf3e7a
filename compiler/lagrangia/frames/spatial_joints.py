"""Cut joints in space, between a frame a and a frame b: what must vanish, and how fast it changes.

A joint keeps its coordinates, each in one equation of its own, of slope -1 in its rate: that equation says what it is, and the
others hold without it. With the axes e1, e2, e3 fixed to a, u = w_b - w_a and r = r_b - r_a:

    weld     r = 0, u . ek = 0
    hinge    r = 0, u . e1 = u . e2 = 0, u . e3 = phi'      e3 along the axis
    slider   r . e1 = r . e2 = 0, r . e3 = s, u . ek = 0    e3 along the way
    cylinder r . e1 = r . e2 = 0, r . e3 = s, and the turns of a hinge
    ball     r = 0, u . ek = wk                             the axes of b
    cross    r = 0, u . (q x p) = 0, u . p* = phi_a', u . q* = phi_b'    of a universal joint: p, an axis of a, q, one of b, and
             p* = (p - c q)/(1 - c^2), q* = (q - c p)/(1 - c^2), c = p . q

What vanishes for the turns are elements of matrices that have these rates where the loop is closed: their errors are those of
second order of the gaps themselves. They vanish for joints put together the wrong way round as well. A start is told by half
angles, twice the vector part of the quaternion of what is turned too far, which vanishes nowhere else: `turned_too_far`.
Source: O. Bottema, B. Roth, Theoretical Kinematics (1979), chapter VI.
"""

from collections.abc import Sequence
from dataclasses import replace
from numbers import Real

from lagrangia.algebra.duals import Algebra, Dual, Scalar, base_of, dot, is_zero, minus, rate_of, times, value_of
from lagrangia.base.records import dataclass
from lagrangia.frames.quaternions import Quaternion, conjugate, quaternion_product
from lagrangia.frames.spatial import HERE, Matrix, Pose, Vector, cross, product, times_matrix, transposed

UNIT = HERE.axes
_LIKE_NO_AXIS = 0.7320508, 1.4142136, 0.5772157  # along which no axis is that is a parameter, as those along x, y or z are


@dataclass(frozen=True)
class Kept:
    """What a cut joint keeps: the values of its coordinates at a level, and of an attitude its matrix and quaternion."""

    kind: str
    axes: Matrix  # e1, e2, e3 by rows, in a's axes; of a cross p, and q in b's
    values: tuple[Scalar, ...] = ()
    attitude: Matrix = UNIT
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
    beside: tuple[Scalar, ...] = ()  # of what slides: what it is away along e1 and e2

    @property
    def slides(self) -> bool:
        """Along e3, by the first of its values."""
        return self.kind in ("slider", "cylinder")

    @property
    def turns(self) -> bool:
        """About e3, by the last of its values."""
        return self.kind in ("hinge", "cylinder")

    def turning_axes(self, a: Pose, b: Pose) -> list[Vector]:
        """The axes, in the world's, about which the last three gaps are turns."""
        if self.kind == "ball":
            return [b.to_world(e) for e in UNIT]
        if self.kind != "cross":
            return [a.to_world(e) for e in self.axes]
        p, q, cos = a.to_world(self.axes[0]), b.to_world(self.axes[1]), dot([*self.axes[0]], [*self.axes[1]])
        scale = 1.0 if is_zero(cos) else 1.0 / minus(1.0, times(cos, cos))
        duals = (tuple(times(scale, minus(x, times(cos, y))) for x, y in zip(*pair, strict=True)) for pair in ((p, q), (q, p)))
        return [cross(q, p), *duals]


def gaps(a: Pose, b: Pose, back: Matrix, kept: Kept, algebra: Algebra) -> list[Scalar]:
    """What must vanish at the level of the poses: lengths in m, angles in rad. `back`: takes vectors to the axes in which lengths
    are told."""
    ahead = tuple(minus(x, y) for x, y in zip(b.origin, a.origin, strict=True))
    if kept.slides:
        lengths = [dot(a.to_world(e), ahead) for e in kept.axes]
        lengths = [minus(x, y) for x, y in zip(lengths, (*kept.beside, kept.values[0]), strict=True)]
    else:
        lengths = [*times_matrix(back, ahead)]
    return [*lengths, *_turns(a, b, kept, _too_far(a, b, kept, algebra), a.level)]


def axes_of_gaps(a: Pose, b: Pose, kept: Kept) -> list[Vector]:
    """The axes, in the world's, about which the last three gaps are turns."""
    return kept.turning_axes(a, b)


def axes_of_lengths(a: Pose, back: Matrix, kept: Kept) -> Matrix:
    """The axes, in the world's, along which the first three gaps are lengths."""
    return tuple(times_matrix(a.axes, e) for e in kept.axes) if kept.slides else back


def turned_too_far(a: Quaternion, b: Quaternion, kept: Kept, algebra: Algebra) -> list[Scalar]:
    """Twice the vector part of what is left of the turn of b against a, of plain quaternions."""
    turn = quaternion_product(conjugate(a), b)
    if kept.kind == "ball":
        return [times(2.0, x) for x in quaternion_product(conjugate(kept.quaternion), turn)[1:]]
    halves = [times(0.5, base_of(value)) for value in kept.values]
    if kept.kind == "cross":
        (p, q), turns = kept.axes[:2], [(algebra.call("cos", x), algebra.call("sin", x)) for x in halves]
        before, behind = ((cos, *(times(sin, -x) for x in axis)) for axis, (cos, sin) in zip((p, q), turns, strict=True))
        left = quaternion_product(quaternion_product(before, turn), behind)[1:]
        axes = (cross(p, q), p, q)  # as what vanishes: square to each other, turned about the first, and about the second
        return [times(2.0, dot(left, e)) for e in axes]
    found = [times(2.0, dot(turn[1:], e)) for e in kept.axes]
    if kept.turns:
        cos, sin = algebra.call("cos", halves[-1]), algebra.call("sin", halves[-1])
        found[2] = minus(times(found[2], cos), times(times(2.0, turn[0]), sin))
    return found


def triad(axis: Sequence[Scalar], algebra: Algebra) -> Matrix:
    """Three axes across each other, by rows, the last one along an axis of length 1."""
    along = [k for k, x in enumerate(axis) if not is_zero(x)]
    if len(along) == 1 and isinstance(axis[along[0]], Real):
        k, side = along[0], axis[along[0]]
        return UNIT[(k + 1) % 3], tuple(times(side, x) for x in UNIT[(k + 2) % 3]), tuple(axis)
    sizes = [abs(float(x)) if isinstance(x, Real) else 0.5 for x in axis]
    any_known = any(isinstance(x, Real) for x in axis)
    across = cross(axis, UNIT[sizes.index(min(sizes))] if any_known else _LIKE_NO_AXIS)
    length = algebra.call("sqrt", dot(across, across))
    first = tuple(0.0 if is_zero(x) else x / length for x in across)
    return first, cross(axis, first), tuple(axis)


def _too_far(a: Pose, b: Pose, kept: Kept, algebra: Algebra) -> Vector:
    """What vanishes, in plain scalars."""
    A, B = transposed(a.axes), transposed(b.axes)  # their axes, by rows
    if kept.kind == "cross":
        return _crossed(times_matrix(A, times_matrix(b.axes, kept.axes[1])), times_matrix(B, times_matrix(a.axes, kept.axes[0])),
                        kept, algebra)
    if kept.turns:
        first, second = (times_matrix(a.axes, e) for e in kept.axes[:2])
        ahead, axis = times_matrix(b.axes, kept.axes[0]), times_matrix(b.axes, kept.axes[2])
        angle = base_of(kept.values[-1])
        cos, sin = algebra.call("cos", angle), algebra.call("sin", angle)
        return (minus(0.0, dot(axis, second)), dot(axis, first),
                minus(times(dot(second, ahead), cos), times(dot(first, ahead), sin)))
    if kept.kind == "ball":
        return _half_of_skew(product(transposed(kept.attitude), product(A, b.axes)))
    own = tuple(times_matrix(transposed(a.axes), x) for x in B)  # b's axes in a's, by rows
    return times_matrix(kept.axes, _half_of_skew(transposed(own)))


def _crossed(second: Vector, first: Vector, kept: Kept, algebra: Algebra) -> Vector:
    """Of a cross, from where q is in a's axes and p in b's: how far these are from square, and from their angles."""
    p, q = kept.axes[:2]
    across, between = [*cross(p, q)], dot([*p], [*q])
    scale = 1.0 if is_zero(between) else 1.0 / minus(1.0, times(between, between))
    found = [minus(dot([*p], [*second]), between)]
    for axis, other, seen, value in ((p, q, second, kept.values[0]), (q, p, first, kept.values[1])):
        upright = [minus(x, times(between, y)) for x, y in zip(other, axis, strict=True)]
        cos, sin = (algebra.call(name, base_of(value)) for name in ("cos", "sin"))
        found.append(times(scale, minus(times(cos, dot(across, [*seen])), times(sin, dot(upright, [*seen])))))
    return tuple(found)


def _half_of_skew(R: Matrix) -> Vector:
    return tuple(times(0.5, minus(R[j][i], R[i][j])) for i, j in ((1, 2), (2, 0), (0, 1)))


def _turns(a: Pose, b: Pose, kept: Kept, plain: Vector, level: int) -> list[Scalar]:
    """With their rates up to a level."""
    if level == 0:
        return [*plain]
    lower = _turns(a.lowered, b.lowered, _lowered(kept), plain, level - 1)
    u = tuple(minus(x, y) for x, y in zip(b.spin, a.spin, strict=True))
    rates = [dot([*axis], [*u]) for axis in kept.turning_axes(a.lowered, b.lowered)]
    angles = kept.values[-1:] if kept.turns else () if kept.slides else kept.values
    for k, value in zip(range(3 - len(angles), 3), angles, strict=True):
        rates[k] = minus(rates[k], rate_of(value))
    return [x if is_zero(rate) else Dual(x, rate) for x, rate in zip(lower, rates, strict=True)]


def _lowered(kept: Kept) -> Kept:
    return replace(kept, values=tuple(map(value_of, kept.values)))


