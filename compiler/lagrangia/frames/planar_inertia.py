"""Rigid bodies of the plane: inertia, momentum and wrenches in the three numbers of a twist, vx, vy, w.

About the reference frame's origin, with the mass m, the first moment b and the second moment J: p = m v + w x b,
L = J w + b x v. Of symmetric matrices the upper triangle is kept.
"""

from collections.abc import Sequence
from functools import cached_property

import casadi as ca

from lagrangia.algebra.duals import Scalar, dot, minus, plus, rate_of, times, value_of
from lagrangia.algebra.scalars import scalars_in, symbol
from lagrangia.base.records import dataclass
from lagrangia.frames.planar import HERE, SIZE, Pose, Value

Vector = list[Scalar]  # (SIZE,): vx, vy, w or fx, fy, torque
NOTHING: tuple[Scalar, ...] = (0.0,) * SIZE
_ENTRIES = [(i, j) for i in range(SIZE) for j in range(i, SIZE)]  # of the upper triangle: xx, xy, xw, yy, yw, ww
UPPER, PLACE = len(_ENTRIES), len(HERE.origin)  # how many numbers an inertia and a place have


@dataclass(frozen=True)
class Inertia:
    """Of a rigid body about the origin of one of its frames, in that frame's axes: kg, kg.m, kg.m2."""

    frame: str
    mass: Scalar
    moment_x: Scalar
    moment_y: Scalar
    second_moment: Scalar


# -------------------------------------------------------------------- inertias found


class FreeBody:
    """A body with a free twist in its own axes, at a general angle."""

    def __init__(self) -> None:
        self.cos, self.sin = symbol("c"), symbol("s")
        self.twist = symbol("vx"), symbol("vy"), symbol("w")

    def velocity(self, attribute: str, place: Pose, own: Pose) -> Value:
        """v or w, in the world's axes, of a frame of the body; `own`: where the frame of the body sits."""
        vx, vy, w = self.twist
        if attribute == "w":
            return w
        if place is own:
            return self._own
        ahead = tuple(x - y for x, y in zip(place.origin, own.origin, strict=True))
        return self._turned(vx - w * ahead[1], vy + w * ahead[0])

    @cached_property
    def _own(self) -> Value:
        return self._turned(*self.twist[:2])

    def _turned(self, x: Scalar, y: Scalar) -> Value:
        return self.cos * x - self.sin * y, self.sin * x + self.cos * y

    def hessians(self, energies: Sequence[Scalar]) -> ca.SX:
        """d2T/d(twist)2 of each energy: a row of the entries of the upper triangle. NaN where T is not quadratic."""
        moving = ca.vertcat(*self.twist)
        slopes = ca.densify(ca.jacobian(ca.vertcat(ca.SX(0, 1), *energies), moving))
        columns = (ca.densify(ca.jacobian(slopes[:, k], moving)) for k in range(SIZE))
        table = ca.horzcat(*[column[:, k:] for k, column in enumerate(columns)])
        return ca.substitute(table, moving, ca.SX.nan(SIZE)) if ca.depends_on(table, moving) else table

    def straight(self, turned: ca.SX) -> ca.SX:
        """Hessians at the angle 0."""
        return ca.substitute([turned], [self.cos, self.sin], [ca.SX(1), ca.SX(0)])[0]

    @property
    def general(self) -> dict[int, float]:
        """Numbers of a general angle, by the hashes of the symbols."""
        return {self.cos.__hash__(): 0.6, self.sin.__hash__(): 0.8}


def unlike_a_body(straight: ca.SX) -> ca.SX:
    """What is 0 in rows of Hessians of rigid bodies: the mass is the same along all axes."""
    return ca.horzcat(straight[:, 0] - straight[:, 3], straight[:, 1])


def inertias(frames: Sequence[str], straight: ca.SX) -> list[Inertia]:
    """Of bodies by their frames, with their rows of Hessians."""
    columns = [scalars_in(straight[:, k]) for k in range(len(_ENTRIES))]
    return [Inertia(frame, columns[0][k], columns[4][k], minus(0.0, columns[2][k]), columns[5][k])
            for k, frame in enumerate(frames)]


def inertial_reaction(inertia: Inertia, place: Pose, pose: Pose) -> list[tuple[Scalar, Scalar]]:
    """The place x, y, phi of a body's frame and the wrench its inertia asks for: with the first moment b,

    F = m a - w^2 b + alpha x b,   tau = J alpha + b x a.   `pose`: with its rates and their rates.
    """
    ax, ay, alpha = (rate_of(rate_of(x)) for x in pose.place)
    w = value_of(rate_of(pose.phi))
    fx, fy, torque = inertia.mass * ax, inertia.mass * ay, inertia.second_moment * alpha
    if not (ca.SX(inertia.moment_x).is_zero() and ca.SX(inertia.moment_y).is_zero()):
        bx, by = place.to_world((inertia.moment_x, inertia.moment_y))
        fx, fy = fx - w * w * bx - alpha * by, fy - w * w * by + alpha * bx
        torque = torque + bx * ay - by * ax
    return list(zip(place.place, (fx, fy, torque), strict=True))


# -------------------------------------------------------------------- matrices and vectors of a twist


def no_inertia() -> list[Vector]:
    """A matrix of zeros."""
    return [[*NOTHING] for _ in range(SIZE)]


def upper(I: list[Vector]) -> Vector:
    """The numbers of an inertia, (UPPER,)."""
    return [I[i][j] for i, j in _ENTRIES]


def from_upper(values: Sequence[Scalar]) -> list[Vector]:
    """The inertia that has these."""
    I = no_inertia()
    for (i, j), value in zip(_ENTRIES, values, strict=True):
        I[i][j] = value
    return I


def moved_inertia(inertia: Inertia, local: Pose, turn: Pose) -> Vector:
    """An inertia, (UPPER,), moved from where its frame sits in the body to the reference frame (parallel axes), and turned into
    the world's axes."""
    m = inertia.mass
    ahead = [local.x, local.y]
    bx, by = local.to_world((inertia.moment_x, inertia.moment_y))
    J = plus(inertia.second_moment, plus(times(2.0, dot(ahead, [bx, by])), times(m, dot(ahead, ahead))))
    x, y = turn.to_world((plus(bx, times(m, ahead[0])), plus(by, times(m, ahead[1]))))
    return [m, 0.0, minus(0.0, y), m, x, J]


def add_upper(I: list[Vector], values: Sequence[Scalar]) -> None:
    """Adds an inertia that is given by its numbers, (UPPER,)."""
    for (i, j), value in zip(_ENTRIES, values, strict=True):
        I[i][j] = plus(I[i][j], value)


def add_moved(parent: list[Vector], I: list[Vector], joint: Sequence[Scalar]) -> None:
    """Adds the inertia of a body to its parent's, moved to the parent's reference frame."""
    dx, dy = joint
    # X^T I X with X = [[1, 0, -dy], [0, 1, dx], [0, 0, 1]]
    xz = plus(minus(I[0][2], times(I[0][0], dy)), times(I[0][1], dx))
    yz = plus(minus(I[1][2], times(I[0][1], dy)), times(I[1][1], dx))
    zz = minus(plus(minus(plus(I[2][2], times(I[1][2], dx)), times(I[0][2], dy)), times(yz, dx)), times(xz, dy))
    for (i, j), value in {(0, 0): I[0][0], (0, 1): I[0][1], (1, 1): I[1][1], (0, 2): xz, (1, 2): yz, (2, 2): zz}.items():
        parent[i][j] = plus(parent[i][j], value)


def moved_twist(twist: Vector, joint: Sequence[Scalar]) -> Vector:
    """That of the body's point that is further by a vector."""
    vx, vy, w = twist
    return [minus(vx, times(w, joint[1])), plus(vy, times(w, joint[0])), w]


def about(wrench: Vector, ahead: Sequence[Scalar]) -> Vector:
    """A wrench that acts further by a vector, with its moment about the origin."""
    fx, fy, torque = wrench
    return [fx, fy, minus(plus(torque, times(fy, ahead[0])), times(fx, ahead[1]))]


def momentum(I: list[Vector], twist: Vector) -> Vector:
    """I s."""
    return [dot([I[min(i, j)][max(i, j)] for j in range(SIZE)], twist) for i in range(SIZE)]


def motion_numbers(pose: Pose) -> Vector:
    """The angular velocity of a body, and the rate of its twist."""
    return [value_of(rate_of(pose.phi)), *(rate_of(rate_of(x)) for x in pose.place)]


def inertial_force(I: list[Vector], motion: Sequence[Scalar]) -> Vector:
    """What a body's inertia asks for when dv/dt = 0: F = m a - w^2 b + alpha x b, tau = J alpha + b x a. `motion`: as
    `motion_numbers` tells it."""
    w, *rate = motion
    square = times(w, w)
    x, y, torque = momentum(I, rate)
    return [minus(x, times(square, I[1][2])), plus(y, times(square, I[0][2])), torque]


def wrench_about(wrench: ca.SX, here: Pose, there: Pose) -> ca.SX:
    """A wrench that acts at `here`, its torque taken about the origin of `there`."""
    return ca.vertcat(wrench[0], wrench[1], wrench[2] + (here.x - there.x) * wrench[1] - (here.y - there.y) * wrench[0])
