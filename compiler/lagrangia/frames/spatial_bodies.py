"""Rigid bodies in space: inertias found in kinetic energies, and what they ask for.

With the mass m, the first moment b = m c and the second moments J about the origin of the body's frame: F = m a + alpha x b +
w x (w x b), tau = J alpha + w x J w + b x a. Of symmetric matrices the upper triangle is kept.
"""

from collections.abc import Sequence

import casadi as ca

from lagrangia.algebra.duals import Scalar, is_zero, minus, plus, rate_of, times, value_of
from lagrangia.algebra.scalars import as_expression, scalars_in, symbol
from lagrangia.base.records import dataclass
from lagrangia.frames.spatial import SIZE, Matrix, Pose, Value, Vector, cross, times_matrix, transposed
from lagrangia.language.frame_attributes import ABOUT_Z

_ENTRIES = [(i, j) for i in range(SIZE) for j in range(i, SIZE)]  # of the upper triangle
_PLACE = {entry: k for k, entry in enumerate(_ENTRIES)}
# A rotation like any other whose entries are short: that of the quaternion (1, 2, 3, 4).
_GENERAL = ((-20 / 30, 4 / 30, 22 / 30), (20 / 30, -10 / 30, 20 / 30), (10 / 30, 28 / 30, 4 / 30))


@dataclass(frozen=True)
class Inertia:
    """Of a rigid body about the origin of one of its frames, in that frame's axes: kg, kg.m, kg.m2."""

    frame: str
    mass: Scalar
    first_moment: Vector
    second_moment: Matrix


class FreeBody:
    """A body with a free twist in its own axes, at a general attitude."""

    def __init__(self) -> None:
        self.axes = tuple(tuple(symbol(f"R{i}{j}") for j in range(3)) for i in range(3))
        self.velocity_of, self.spin = (tuple(symbol(f"{name}{k}") for k in range(3)) for name in "vw")

    def velocity(self, attribute: str, place: Pose, own: Pose) -> Value:
        """v or w, in the world's axes, or omega, in its own, of a frame of the body; `own`: where the frame of the body sits."""
        if attribute == ABOUT_Z:
            return self.velocity("omega", place, own)[2]
        if attribute == "omega":
            return times_matrix(transposed(place.axes), times_matrix(own.axes, self.spin))
        if attribute == "w":
            return times_matrix(self.axes, self.spin)
        if place is own:
            return times_matrix(self.axes, self.velocity_of)
        ahead = own.to_frame([minus(x, y) for x, y in zip(place.origin, own.origin, strict=True)])
        moved = (plus(v, d) for v, d in zip(self.velocity_of, cross(self.spin, ahead), strict=True))
        return times_matrix(self.axes, tuple(moved))

    def hessians(self, energies: Sequence[Scalar]) -> ca.SX:
        """d2T/d(twist)2 of each energy: a row of the entries of the upper triangle. NaN where T is not quadratic."""
        moving = ca.vertcat(*self.velocity_of, *self.spin)
        slopes = ca.densify(ca.jacobian(ca.vertcat(ca.SX(0, 1), *energies), moving))
        columns = (ca.densify(ca.jacobian(slopes[:, k], moving)) for k in range(SIZE))
        table = ca.horzcat(*[column[:, k:] for k, column in enumerate(columns)])
        return ca.substitute(table, moving, ca.SX.nan(SIZE)) if ca.depends_on(table, moving) else table

    def straight(self, turned: ca.SX) -> ca.SX:
        """Hessians where the body's axes are the world's."""
        symbols = [x for row in self.axes for x in row]
        return ca.substitute([turned], symbols, [ca.SX(float(k % 4 == 0)) for k in range(9)])[0]

    @property
    def general(self) -> dict[int, float]:
        """Numbers of a general attitude, by the hashes of the symbols."""
        return {x.__hash__(): value for row, values in zip(self.axes, _GENERAL, strict=True)
                for x, value in zip(row, values, strict=True)}


def unlike_a_body(straight: ca.SX) -> ca.SX:
    """What is 0 in rows of Hessians of rigid bodies: the mass is the same along all axes, and couples by a first moment alone."""
    def entry(i: int, j: int) -> ca.SX:
        return straight[:, _PLACE[i, j]]

    pairs = ((0, 1), (0, 2), (1, 2))
    mass = [entry(0, 0) - entry(k, k) for k in (1, 2)] + [entry(i, j) for i, j in pairs]
    coupling = [entry(i, 3 + i) for i in range(3)] + [entry(i, 3 + j) + entry(j, 3 + i) for i, j in pairs]
    return ca.horzcat(*mass, *coupling)


def inertias(frames: Sequence[str], straight: ca.SX) -> list[Inertia]:
    """Of bodies by their frames, with their rows of Hessians."""
    columns = [scalars_in(straight[:, k]) for k in range(len(_ENTRIES))]

    def entry(k: int, i: int, j: int) -> Scalar:
        return columns[_PLACE[min(i, j), max(i, j)]][k]

    return [Inertia(frame, entry(k, 0, 0), (entry(k, 1, 5), entry(k, 2, 3), entry(k, 0, 4)),
                    tuple(tuple(entry(k, 3 + i, 3 + j) for j in range(3)) for i in range(3)))
            for k, frame in enumerate(frames)]


def inertial_wrench(inertia: Inertia, pose: Pose) -> list[Scalar]:
    """The force along the world's axes and the torque about the frame's origin that an inertia asks for, (SIZE,). `pose`: at
    level 2, with its rates and their rates."""
    spin, turning = tuple(map(value_of, pose.spin)), tuple(map(rate_of, pose.spin))
    pull = tuple(rate_of(rate_of(x)) for x in pose.origin)
    w, alpha = pose.to_frame(spin), pose.to_frame(turning)
    J = inertia.second_moment
    gyroscopic = cross(w, times_matrix(J, w))
    own = tuple(plus(x, y) for x, y in zip(times_matrix(J, alpha), gyroscopic, strict=True))
    torque = times_matrix(pose.axes, own)
    force = tuple(times(inertia.mass, x) for x in pull)
    if not all(is_zero(x) for x in inertia.first_moment):
        b = times_matrix(pose.axes, inertia.first_moment)
        bent = zip(cross(turning, b), cross(spin, cross(spin, b)), strict=True)
        force = tuple(plus(f, plus(x, y)) for f, (x, y) in zip(force, bent, strict=True))
        torque = tuple(plus(x, y) for x, y in zip(torque, cross(b, pull), strict=True))
    return [as_expression(x) if isinstance(x, ca.SX) else x for x in (*force, *torque)]


def wrench_about(wrench: ca.SX, here: Pose, there: Pose) -> ca.SX:
    """A wrench that acts at `here`, its torque taken about the origin of `there`."""
    arm = ca.vertcat(*[minus(x, y) for x, y in zip(here.origin, there.origin, strict=True)])
    return ca.vertcat(wrench[:3], wrench[3:] + ca.cross(arm, wrench[:3]))


def unit_load(slopes: Sequence[ca.SX]) -> ca.SX:
    """The wrench that does the work of a unit force on a coordinate by which a body moves with this twist."""
    along, about = ca.vertcat(*slopes[:3]), ca.vertcat(*slopes[3:])
    if about.is_zero():
        return ca.vertcat(along / ca.dot(along, along), ca.SX.zeros(3))
    return ca.vertcat(ca.SX.zeros(3), about / ca.dot(about, about))
