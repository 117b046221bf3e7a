"""Where a loop in space is closed: what must vanish between a frame a and a frame b.

Every edge outside the tree is closed as a whole, with its coordinates kept: r_b = r_a, and the turn of b against a vanishes. It
is told by twice the vector part of its quaternion (q0, p), 2 p = 2 sin(angle/2) axis along the world's axes, which is an angle
near closure and vanishes nowhere else: a joint that is put together the wrong way round is not closed. The quaternion is made of
half angles along the loop, without roots and divisions. With u = w_b - R w_a, R w = w + 2 p x (p x w + q0 w):
2 p' = q0 u + u x p.  Source: O. Bottema, B. Roth, Theoretical Kinematics (1979), chapter VI.
"""

from collections.abc import Sequence

from lagrangia.algebra.duals import Dual, Scalar, dot, is_zero, minus, plus, times
from lagrangia.frames.spatial import Pose, Vector, cross, product, transposed


def gaps(a: Pose, b: Pose, turn: Sequence[Scalar], is_displaced: bool) -> list[Scalar]:
    """What must vanish: lengths in m, angles in rad. `turn`: the quaternion of b against a, in the world's axes, without what
    displaces them."""
    scalar, part = turn[0], _displaced(a, b, turn[0]) if is_displaced else tuple(turn[1:])
    lengths = (minus(x, y) for x, y in zip(b.origin, a.origin, strict=True))
    return [*lengths, *(times(2.0, x) for x in _turn(a, b, scalar, part, a.level)[1])]


def _displaced(a: Pose, b: Pose, scalar: Scalar) -> Vector:
    """The vector part where the loop is closed, and frames are displaced a little."""
    R = product(b.axes, transposed(a.axes))
    sides = (minus(R[i][j], R[j][i]) for i, j in ((2, 1), (0, 2), (1, 0)))
    return tuple(0.0 if is_zero(side) else side / times(4.0, scalar) for side in sides)


def _turn(a: Pose, b: Pose, scalar: Scalar, part: Vector, level: int) -> tuple[Scalar, Vector]:
    """q0 and p at a level."""
    if level == 0:
        return scalar, part
    q, p = _turn(a, b, scalar, part, level - 1)
    spin_a, spin_b = (pose.spin if level == pose.level else pose.lowered.spin for pose in (a, b))
    inner = cross(p, tuple(plus(x, times(q, w)) for x, w in zip(cross(p, spin_a), spin_a, strict=True)))
    u = tuple(minus(w, plus(v, times(2.0, x))) for w, v, x in zip(spin_b, spin_a, inner, strict=True))
    rates = tuple(times(0.5, plus(times(q, x), y)) for x, y in zip(u, cross(u, p), strict=True))
    return _dual(q, times(-0.5, dot(u, p))), tuple(map(_dual, p, rates))


def _dual(value: Scalar, rate: Scalar) -> Scalar:
    return value if is_zero(rate) else Dual(value, rate)
