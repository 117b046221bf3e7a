"""Cut joints in space, between a frame a and a frame b: what must vanish, and how fast it changes.

A joint keeps its coordinates, each in one equation of its own, of slope -1 in its rate: that equation says what it is, and the
others hold without it. With the axes e1, e2, e3 fixed to a, u = w_b - w_a and r = r_b - r_a:

    weld     r = 0, u . ek = 0
    hinge    r = 0, u . e1 = u . e2 = 0, u . e3 = phi'      e3 along the axis
    slider   r . e1 = r . e2 = 0, r . e3 = s, u . ek = 0    e3 along the way
    ball     r = 0, u . ek = wk                             the axes of b

What vanishes for the turns are elements of matrices that have these rates where the loop is closed: their errors are those of
second order of the gaps themselves. They vanish for joints put together the wrong way round as well. A start is told by half
angles, twice the vector part of the quaternion of what is turned too far, which vanishes nowhere else: `turned_too_far`.
Source: O. Bottema, B. Roth, Theoretical Kinematics (1979), chapter VI.
"""

from collections.abc import Sequence
from dataclasses import replace

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
    axes: Matrix  # e1, e2, e3 by rows, in a's axes
    values: tuple[Scalar, ...] = ()
    attitude: Matrix = UNIT
    quaternion: Quaternion = (1.0, 0.0, 0.0, 0.0)
    beside: tuple[Scalar, ...] = ()  # of a slider: what it is away along e1 and e2


def gaps(a: Pose, b: Pose, back: Matrix, kept: Kept, algebra: Algebra) -> list[Scalar]:
    """What must vanish at the level of the poses: lengths in m, angles in rad. `back`: takes vectors to the axes in which lengths
    are told."""
    ahead = tuple(minus(x, y) for x, y in zip(b.origin, a.origin, strict=True))
    if kept.kind == "slider":
        lengths = [dot(a.to_world(e), ahead) for e in kept.axes]
        lengths = [minus(x, y) for x, y in zip(lengths, (*kept.beside, *kept.values), strict=True)]
    else:
        lengths = [*times_matrix(back, ahead)]
    return [*lengths, *_turns(a, b, kept, _too_far(a, b, kept, algebra), a.level)]


def axes_of_gaps(a: Pose, b: Pose, kept: Kept) -> list[Vector]:
    """The axes, in the world's, about which the last three gaps are turns."""
    held = b if kept.kind == "ball" else a
    return [times_matrix(held.axes, e) for e in (UNIT if kept.kind == "ball" else kept.axes)]


def axes_of_lengths(a: Pose, back: Matrix, kept: Kept) -> Matrix:
    """The axes, in the world's, along which the first three gaps are lengths."""
    return tuple(times_matrix(a.axes, e) for e in kept.axes) if kept.kind == "slider" else back


def turned_too_far(a: Quaternion, b: Quaternion, kept: Kept, algebra: Algebra) -> list[Scalar]:
    """Twice the vector part of what is left of the turn of b against a, of plain quaternions."""
    turn = quaternion_product(conjugate(a), b)
    if kept.kind == "ball":
        return [times(2.0, x) for x in quaternion_product(conjugate(kept.quaternion), turn)[1:]]
    found = [times(2.0, dot(turn[1:], e)) for e in kept.axes]
    if kept.kind == "hinge":
        half = times(0.5, base_of(kept.values[0]))
        cos, sin = algebra.call("cos", half), algebra.call("sin", half)
        found[2] = minus(times(found[2], cos), times(times(2.0, turn[0]), sin))
    return found


def triad(axis: Sequence[Scalar], algebra: Algebra) -> Matrix:
    """Three axes across each other, by rows, the last one along an axis of length 1."""
    along = [k for k, x in enumerate(axis) if not is_zero(x)]
    if len(along) == 1 and isinstance(axis[along[0]], float | int):
        k, side = along[0], float(axis[along[0]])
        return UNIT[(k + 1) % 3], tuple(times(side, x) for x in UNIT[(k + 2) % 3]), tuple(axis)
    sizes = [abs(x) if isinstance(x, float | int) else 0.5 for x in axis]
    any_known = any(isinstance(x, float | int) for x in axis)
    across = cross(axis, UNIT[sizes.index(min(sizes))] if any_known else _LIKE_NO_AXIS)
    length = algebra.call("sqrt", dot(across, across))
    first = tuple(0.0 if is_zero(x) else x / length for x in across)
    return first, cross(axis, first), tuple(axis)


def _too_far(a: Pose, b: Pose, kept: Kept, algebra: Algebra) -> Vector:
    """What vanishes, in plain scalars."""
    A, B = transposed(a.axes), transposed(b.axes)  # their axes, by rows
    if kept.kind == "hinge":
        first, second = (times_matrix(a.axes, e) for e in kept.axes[:2])
        ahead, axis = times_matrix(b.axes, kept.axes[0]), times_matrix(b.axes, kept.axes[2])
        angle = base_of(kept.values[0])
        cos, sin = algebra.call("cos", angle), algebra.call("sin", angle)
        return (minus(0.0, dot(axis, second)), dot(axis, first),
                minus(times(dot(second, ahead), cos), times(dot(first, ahead), sin)))
    if kept.kind == "ball":
        return _half_of_skew(product(transposed(kept.attitude), product(A, b.axes)))
    own = tuple(times_matrix(transposed(a.axes), x) for x in B)  # b's axes in a's, by rows
    return times_matrix(kept.axes, _half_of_skew(transposed(own)))


def _half_of_skew(R: Matrix) -> Vector:
    return tuple(times(0.5, minus(R[j][i], R[i][j])) for i, j in ((1, 2), (2, 0), (0, 1)))


def _turns(a: Pose, b: Pose, kept: Kept, plain: Vector, level: int) -> list[Scalar]:
    """With their rates up to a level."""
    if level == 0:
        return [*plain]
    lower = _turns(a.lowered, b.lowered, _lowered(kept), plain, level - 1)
    held, axes = (b, UNIT) if kept.kind == "ball" else (a, kept.axes)
    u = tuple(minus(x, y) for x, y in zip(b.spin, a.spin, strict=True))
    rates = [dot(held.lowered.to_world(e), u) for e in axes]
    if kept.kind == "hinge":
        rates[2] = minus(rates[2], rate_of(kept.values[0]))
    elif kept.kind == "ball":
        rates = [minus(x, rate_of(value)) for x, value in zip(rates, kept.values, strict=True)]
    return [x if is_zero(rate) else Dual(x, rate) for x, rate in zip(lower, rates, strict=True)]


def _lowered(kept: Kept) -> Kept:
    return replace(kept, values=tuple(map(value_of, kept.values)))


