"""Frames of the plane: their pose, how steps and displacements move it, and what attributes are read off it.

Along a tree: shift(a, d): r_b = r_a + R(phi_a) d;  turn(a, alpha): phi_b = phi_a + alpha. A twist is the rate of the place: a
velocity along x and y of the world, m/s, and an angular velocity, rad/s; a wrench a force along them, N, and a torque, N.m.
"""

from collections.abc import Callable, Mapping, Sequence

from lagrangia.algebra.duals import Algebra, Dual, Scalar, base_of, minus, plus, rate_of, times, value_of
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.language.frame_attributes import ATTRIBUTES, COMPONENTS
from lagrangia.language.frame_steps import Step

SIZE = len(COMPONENTS)  # of a place, a twist, a wrench
LENGTHS, ANGLES = slice(0, 2), slice(2, 3)  # where they are among the numbers of a place
Value = Scalar | tuple[Scalar, ...]


@dataclass(frozen=True, slots=True)
class Pose:
    """Place of a frame: origin (m), angle (rad), and the cosine and sine of the angle, which are plain where the others are
    Duals: what turns with the frame has the angle's rate."""

    x: Scalar
    y: Scalar
    phi: Scalar
    cos: Scalar
    sin: Scalar

    @property
    def lowered(self) -> "Pose":
        """The same a level below, with its values alone."""
        return Pose(value_of(self.x), value_of(self.y), value_of(self.phi), value_of(self.cos), value_of(self.sin))

    @property
    def place(self) -> tuple[Scalar, ...]:
        """The numbers whose rates are the twist, (SIZE,)."""
        return self.x, self.y, self.phi

    @property
    def twist(self) -> tuple[Scalar, ...]:
        """The rates of the place, (SIZE,), where the pose is of Duals."""
        return tuple(rate_of(x) for x in self.place)

    @property
    def origin(self) -> tuple[Scalar, ...]:
        """Where it is, m."""
        return self.x, self.y

    def to_world(self, vector: Sequence[Scalar]) -> tuple[Scalar, ...]:
        """Components along the world's axes of a vector in the frame's."""
        return _rotated(self, self.phi, rate_of(self.phi), *vector)

    @property
    def axis(self) -> tuple[Scalar, Scalar]:
        """The cosine and sine of the angle, with their rates where it is a Dual."""
        return _axis(self.cos, self.sin, self.phi)

    def moved(self, ahead: Sequence[Scalar]) -> "Pose":
        """With its origin further by a vector in the world's axes."""
        return Pose(self.x + ahead[0], self.y + ahead[1], self.phi, self.cos, self.sin)

    def at(self, origin: Sequence[Scalar]) -> "Pose":
        """With its origin elsewhere."""
        x, y = origin
        return Pose(x, y, self.phi, self.cos, self.sin)

    def with_axis(self, cos: Scalar, sin: Scalar) -> "Pose":
        """Turned by an angle that is known by these alone, and does not change."""
        return Pose(self.x, self.y, self.phi, cos, sin)

    def turned(self, angle: Scalar, algebra: Algebra) -> "Pose":
        """After a turn about its origin."""
        phi = self.phi + angle
        plain = base_of(phi)
        return Pose(self.x, self.y, phi, algebra.call("cos", plain), algebra.call("sin", plain))

    def displaced(self, displacement: Sequence[Scalar], algebra: Algebra) -> "Pose":
        """After a displacement, (SIZE,), along the world's axes and about its origin."""
        *ahead, angle = displacement
        return self.moved(ahead).turned(angle, algebra)


HERE = Pose(0.0, 0.0, 0.0, 1.0, 0.0)  # of a frame, seen from itself


def attribute_of(pose: Pose, name: str) -> Value:
    """An attribute of a frame that its pose says; a velocity, where the pose is of Duals."""
    known = ATTRIBUTES[name]
    numbers = pose.twist if known.kind == "velocity" else pose.place
    return picked(name, numbers)


def picked(name: str, numbers: Sequence[Value]) -> Value:
    """What an attribute is of a place, a twist or a wrench, (SIZE,)."""
    known = ATTRIBUTES[name]
    found = tuple(numbers[k] for k in known.components)
    return found if known.is_vector else found[0]


def root_pose(place: Mapping[str, Scalar], number: Callable[[float], Scalar], algebra: Algebra) -> Pose:
    """Of the ground, or of a floating frame with these coordinates."""
    zero, one = number(0.0), number(1.0)
    origin = Pose(place.get("x", zero), place.get("y", zero), zero, one, zero)
    return origin.turned(place["phi"], algebra) if "phi" in place else origin


def step(pose: Pose, step: Step, amount: Value, algebra: Algebra) -> Pose:
    """The pose after a step of this amount. Raises LagError L0303."""
    if step.kind == "turn":
        if isinstance(amount, tuple):
            fail("L0303", "an angle is a number", step.amount.span)
        return pose.turned(-amount if step.is_inverse else amount, algebra)
    if not isinstance(amount, tuple) or len(amount) != len(pose.origin):
        fail("L0303", "a shift needs a vector of two components", step.amount.span, "write {x, y}")
    return pose.moved(pose.to_world(tuple(-a for a in amount) if step.is_inverse else amount))


def stays(step: Step) -> bool:
    """Whether it leaves the origin where it is."""
    return step.kind == "turn"


def turning(turn: Step, angle: Scalar) -> list[Scalar]:
    """The twist, (SIZE,), of a frame that does nothing but turn, by an angle that is a Dual."""
    return [0.0, 0.0, rate_of(-angle if turn.is_inverse else angle)]


def _rotated(pose: Pose, phi: Scalar, w: Scalar, x: Scalar, y: Scalar) -> tuple[Scalar, Scalar]:
    """R d with d = (x, y), at the level of the angle phi, which has the rate w, and of d. Its rate is R d' + w x (R d), which
    reuses R d instead of differentiating the cosine and sine."""
    is_turned = not (isinstance(x, Dual) or isinstance(y, Dual))  # as most are: it only turns
    if is_turned and not isinstance(phi, Dual):
        return minus(times(pose.cos, x), times(pose.sin, y)), plus(times(pose.sin, x), times(pose.cos, y))
    below = value_of(phi), value_of(w)
    ahead_x, ahead_y = _rotated(pose, *below, value_of(x), value_of(y))
    if is_turned:
        return Dual(ahead_x, minus(0.0, times(w, ahead_y))), Dual(ahead_y, times(w, ahead_x))
    stretch_x, stretch_y = _rotated(pose, *below, rate_of(x), rate_of(y))
    return Dual(ahead_x, minus(stretch_x, times(w, ahead_y))), Dual(ahead_y, plus(stretch_y, times(w, ahead_x)))


def _axis(cos: Scalar, sin: Scalar, phi: Scalar) -> tuple[Scalar, Scalar]:
    if not isinstance(phi, Dual):
        return cos, sin
    c, s = _axis(cos, sin, phi.value)
    return Dual(c, times(-s, phi.rate)), Dual(s, times(c, phi.rate))


def cross(a: Sequence[Scalar], b: Sequence[Scalar]) -> Scalar:
    """a x b, about z."""
    (ax, ay), (bx, by) = a, b
    return ax * by - ay * bx


def turned_vector(vector: Sequence[Scalar], angle: Scalar, algebra: Algebra) -> tuple[Scalar, ...]:
    """Counter-clockwise."""
    x, y = vector
    c, s = algebra.call("cos", angle), algebra.call("sin", angle)
    return c * x - s * y, s * x + c * y
