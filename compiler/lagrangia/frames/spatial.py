"""Frames in space: their pose, how steps and displacements move it, and what attributes are read off it.

Along a tree: shift(a, d): r_b = r_a + R_a d;  turn(a, phi, e): R_b = R_a exp(phi [e]),  w_b = w_a + R_a e phi'. A twist is the
velocity of the origin along the axes of the world, m/s, and the angular velocity in these, rad/s; a wrench a force, N, and a
torque about the origin, N.m. Numbers that are 0 or 1 fall away: a hinge about an axis of coordinates costs twelve products.
"""

from collections.abc import Callable, Mapping, Sequence
from math import cos, pi, sin, sqrt

from lagrangia.algebra.duals import Algebra, Dual, Scalar, base_of, dot, is_zero, minus, plus, rate_of, times, value_of
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.language.frame_attributes import ABOUT_Z, SPACE
from lagrangia.language.frame_steps import Step

SIZE = 6  # of a twist, a wrench
Value = Scalar | tuple[Scalar, ...]
Vector = tuple[Scalar, ...]  # (3,)
Matrix = tuple[Vector, ...]  # (3, 3), by rows
NOWHERE: Vector = (0.0, 0.0, 0.0)
UNIT: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
_ONE_ANGLE = "turn(a, phi, axis) takes one angle; a coordinate Rotation S turns as a whole, and no multiple of it: turn(a, S)"
_LEAST = 1e-280  # of squares that have all their digits
_TINY = 1e-14  # of the cosine of an angle that is a number: a right angle, but for rounding


@dataclass(frozen=True, slots=True)
class Pose:
    """Place of a frame: origin (m), the matrix that takes vectors in its axes to the world's, which is plain where the origin is
    of Duals, and the angular velocity in the world's axes (rad/s), which is a level below the origin."""

    origin: Vector
    axes: Matrix
    spin: Vector
    level: int

    @property
    def lowered(self) -> "Pose":
        """The same a level below, with its values alone."""
        spin = tuple(map(value_of, self.spin)) if self.level > 1 else NOWHERE
        return Pose(tuple(map(value_of, self.origin)), self.axes, spin, self.level - 1)

    @property
    def twist(self) -> tuple[Scalar, ...]:
        """Velocity and angular velocity, (SIZE,), a level below the pose."""
        return *map(rate_of, self.origin), *self.spin

    def to_world(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the world's axes of a vector in the frame's, at the level of the pose."""
        return _turned(self.axes, self.spin, vector, self.level)

    def to_frame(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the frame's axes of a plain vector in the world's."""
        return times_matrix(transposed(self.axes), vector)

    def at(self, origin: Sequence[Scalar]) -> "Pose":
        """With its origin elsewhere."""
        return Pose(tuple(origin), self.axes, self.spin, self.level)

    def moved(self, ahead: Sequence[Scalar]) -> "Pose":
        """With its origin further by a vector in the world's axes."""
        return self.at(tuple(plus(x, d) for x, d in zip(self.origin, ahead, strict=True)))

    def turned(self, angle: Scalar, axis: Sequence[Scalar], algebra: Algebra) -> "Pose":
        """After a turn about its origin, about an axis of length 1 in its axes."""
        axes = product(self.axes, rotation(axis, base_of(angle), algebra))
        spin = self.spin
        if self.level > 0 and not is_zero(rate := rate_of(angle)):
            about = _turned(self.axes, tuple(map(value_of, spin)), axis, self.level - 1)
            spin = tuple(plus(w, times(x, rate)) for w, x in zip(spin, about, strict=True))
        return Pose(self.origin, axes, spin, self.level)

    def oriented(self, axes: Matrix, s: Sequence[Scalar], is_inverse: bool) -> "Pose":
        """After a turn that takes vectors in the turned axes to these; the rates of `s`, which are at the level of the pose, are
        the angular velocity in the turned axes."""
        turned = product(self.axes, transposed(axes) if is_inverse else axes)
        spin = self.spin
        if self.level > 0:
            below = tuple(map(value_of, spin)) if self.level > 1 else spin
            # in the turned axes it is the same whichever of both frames carries them: w x w = 0
            about = _turned(self.axes if is_inverse else turned, below, tuple(map(rate_of, s)), self.level - 1)
            spin = tuple((minus if is_inverse else plus)(w, x) for w, x in zip(spin, about, strict=True))
        return Pose(self.origin, turned, spin, self.level)

    def displaced(self, displacement: Sequence[Scalar], algebra: Algebra) -> "Pose":
        """After a small displacement, (SIZE,), along and about the world's axes: exact in its first derivatives where it is 0."""
        angles = displacement[3:]
        columns = (cross(tuple(map(base_of, angles)), column) for column in transposed(self.axes))
        turn = transposed(tuple(columns))
        axes = tuple(tuple(plus(x, d) for x, d in zip(row, more, strict=True)) for row, more in zip(self.axes, turn, strict=True))
        rates = (rate_of(x) for x in angles) if self.level else NOWHERE
        spin = tuple(plus(w, rate) for w, rate in zip(self.spin, rates, strict=True))
        return Pose(self.origin, axes, spin, self.level).moved(displacement[:3])


HERE = Pose(NOWHERE, UNIT, NOWHERE, 0)  # of a frame, seen from itself


def attribute_of(pose: Pose, name: str) -> Value:
    """An attribute of a frame that its pose says; a velocity is a level below the pose."""
    if name == "R":
        return transposed(tuple(pose.to_world(unit) for unit in UNIT))
    if name == "omega":
        return _seen_from(transposed(pose.axes), pose.spin, pose.level - 1)
    if name == ABOUT_Z:
        return attribute_of(pose, "omega")[2]
    known = SPACE.attributes[name]
    return picked(name, pose.twist if known.kind == "velocity" else pose.origin)


def picked(name: str, numbers: Sequence[Value]) -> Value:
    """What an attribute is of a place, a twist or a wrench."""
    known = SPACE.attributes[name]
    found = tuple(numbers[k] for k in known.components)
    return found if known.is_vector else found[0]


def root_pose(place: Mapping[str, Scalar], number: Callable[[float], Scalar], algebra: Algebra, level: int) -> Pose:
    """Of the ground, or of a floating frame with these coordinates, whose axes are the world's."""
    return Pose(tuple(place.get(name, number(0.0)) for name in "xyz"), UNIT, NOWHERE, level)


def step(pose: Pose, step: Step, amount: Value, axis: Value | None, algebra: Algebra) -> Pose:
    """The pose after a step of this amount; of a turn about an axis, or about z. Raises LagError L0303."""
    if step.kind == "turn":
        if isinstance(amount, tuple):
            fail("L0303", "an angle is a number", step.amount.span, _ONE_ANGLE)
        return pose.turned(-amount if step.is_inverse else amount, unit_axis(step, axis, algebra), algebra)
    if not isinstance(amount, tuple) or len(amount) != 3:
        fail("L0303", "a shift needs a vector of three components", step.amount.span, "write {x, y, z}")
    return pose.moved(pose.to_world(tuple(-a for a in amount) if step.is_inverse else amount))


def unit_axis(step: Step, axis: Value | None, algebra: Algebra) -> Vector:
    """Of a turn, of length 1. Raises LagError L0303."""
    if axis is None:
        return UNIT[2]
    if not isinstance(axis, tuple) or len(axis) != 3:
        assert step.axis is not None
        fail("L0303", "an axis is a vector of three components", step.axis.span, "write {x, y, z}")
    squares = dot(axis, axis)
    if not isinstance(squares, float | int):
        size = algebra.call("sqrt", squares)
        return tuple(0.0 if is_zero(x) else x / size for x in axis)
    largest = max(abs(x) for x in axis)
    if largest == 0:
        assert step.axis is not None
        fail("L0303", "the axis of a turn has the length 0", step.axis.span, "give it a direction, as {0, 0, 1}")
    if not _LEAST < squares < 1 / _LEAST:  # the squares are no numbers of all digits
        axis = tuple(x / largest for x in axis)
    return tuple(x / sqrt(dot(axis, axis)) for x in axis)


# -------------------------------------------------------------------- turns


def rotation(axis: Sequence[Scalar], angle: Scalar, algebra: Algebra) -> Matrix:
    """exp(angle [axis]) = c 1 + s [axis] + (1 - c) axis axis^T, of an axis of length 1."""
    c, s = _cos_sin(angle, algebra)
    sides = [k for k, x in enumerate(axis) if not is_zero(x)]
    if len(sides) == 1 and isinstance(axis[sides[0]], float | int):  # along an axis of coordinates
        k, s = sides[0], (s if axis[sides[0]] > 0 else minus(0.0, s))
        i, j = (k + 1) % 3, (k + 2) % 3
        rows = [[0.0] * 3 for _ in range(3)]
        rows[k][k], rows[i][i], rows[j][j], rows[i][j], rows[j][i] = 1.0, c, c, minus(0.0, s), s
        return tuple(map(tuple, rows))
    rest = minus(1.0, c)
    x, y, z = (times(s, part) for part in axis)
    turning = ((0.0, minus(0.0, z), y), (z, 0.0, minus(0.0, x)), (minus(0.0, y), x, 0.0))
    return tuple(tuple(plus(plus(c if i == j else 0.0, turning[i][j]), times(times(axis[i], axis[j]), rest)) for j in range(3))
                 for i in range(3))


def _cos_sin(angle: Scalar, algebra: Algebra) -> tuple[Scalar, Scalar]:
    """Of a number without the rounding of right angles: what is along an axis stays so."""
    if not isinstance(angle, float | int):
        return algebra.call("cos", angle), algebra.call("sin", angle)
    return _plain(cos(angle), angle), _plain(sin(angle), angle)


def _plain(x: float, angle: float) -> float:
    return float(round(x)) if abs(x - round(x)) < _TINY * max(1.0, abs(angle) / pi) else x


def _turned(axes: Matrix, spin: Sequence[Scalar], vector: Sequence[Scalar], level: int) -> Vector:
    """R d at a level: its rate is R d' + w x (R d), which reuses R d instead of differentiating R."""
    if level == 0:
        return times_matrix(axes, vector)
    below = tuple(map(value_of, spin)) if level > 1 else spin
    ahead = _turned(axes, below, tuple(map(value_of, vector)), level - 1)
    rates = cross(spin, ahead)
    if any(isinstance(x, Dual) for x in vector):
        stretch = _turned(axes, below, tuple(map(rate_of, vector)), level - 1)
        rates = tuple(plus(a, b) for a, b in zip(stretch, rates, strict=True))
    return tuple(x if is_zero(rate) else Dual(x, rate) for x, rate in zip(ahead, rates, strict=True))


def _seen_from(back: Matrix, spin: Sequence[Scalar], level: int) -> Vector:
    """The angular velocity in the axes of what turns with it: its rate is that of those in the world's, seen likewise."""
    values = times_matrix(back, tuple(map(base_of, spin)))
    if level == 0:
        return values
    rates = times_matrix(back, tuple(map(rate_of, spin)))
    return tuple(Dual(x, rate) for x, rate in zip(values, rates, strict=True))


# -------------------------------------------------------------------- vectors and matrices


def cross(a: Sequence[Scalar], b: Sequence[Scalar]) -> Vector:
    """a x b."""
    return tuple(minus(times(a[i], b[j]), times(a[j], b[i])) for i, j in ((1, 2), (2, 0), (0, 1)))


def transposed(matrix: Matrix) -> Matrix:
    """Rows as columns."""
    return tuple(zip(*matrix, strict=True))


def times_matrix(matrix: Matrix, vector: Sequence[Scalar]) -> Vector:
    """A x."""
    return tuple(dot(row, vector) for row in matrix)


def product(a: Matrix, b: Matrix) -> Matrix:
    """A B."""
    columns = transposed(b)
    return tuple(tuple(dot(row, column) for column in columns) for row in a)


def plain_matrix(matrix: Matrix) -> Matrix:
    """Without the rounding of entries that are 0, 1 or -1."""
    return tuple(tuple(map(_without_rounding, row)) for row in matrix)


def _without_rounding(x: Scalar) -> Scalar:
    return float(round(x)) if isinstance(x, float | int) and abs(x - round(x)) < _TINY else x
