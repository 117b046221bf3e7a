"""Frames of a scene in space whose parts all move in parallel planes: poses of the plane, which know how it lies in space.

A frame has its place x, y along two axes of the plane and its angle phi about the third, the normal; what never changes beside
these is its height along the normal and how its own axes lie against those of the plane at phi = 0. So all equations are those of
the plane, of three numbers a body, and what is asked of frames has three components, in the axes of the world.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from functools import cached_property
from math import atan2
from typing import Any

import casadi as ca

from lagrangia.algebra.duals import Algebra, Scalar, base_of, minus, plus, times, value_of
from lagrangia.algebra.scalars import symbol
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.frames import planar, planar_inertia, spatial
from lagrangia.frames.planes import Plane
from lagrangia.frames.spatial import Matrix, Value, Vector
from lagrangia.language.frame_attributes import ABOUT_Z, SPACE
from lagrangia.language.frame_steps import Step

_PARALLEL = 1e-12  # of components of vectors of length 1: rounding
_NORMAL = 2  # of the axes of the plane


@dataclass(frozen=True, slots=True)
class Pose(planar.Pose):
    """`own`: takes vectors in the frame's axes to those of the plane, where phi is 0; numbers."""

    height: Scalar
    own: Matrix
    world: Matrix  # Plane.axes

    @property
    def lowered(self) -> "Pose":
        """The same a level below, with its values alone."""
        flat = planar.Pose(*map(value_of, (self.x, self.y, self.phi, self.cos, self.sin)))
        return self._with(flat)

    def _with(self, flat: planar.Pose) -> "Pose":
        return Pose(flat.x, flat.y, flat.phi, flat.cos, flat.sin, self.height, self.own, self.world)

    def moved(self, ahead: Sequence[Scalar]) -> "Pose":
        """With its origin further by a vector in the plane, along its axes."""
        return self._with(planar.Pose.moved(self, ahead))

    def at(self, origin: Sequence[Scalar]) -> "Pose":
        """With its origin elsewhere in the plane."""
        return self._with(planar.Pose.at(self, origin))

    def turned(self, angle: Scalar, algebra: Algebra) -> "Pose":
        """After a turn about its origin and the normal."""
        return self._with(planar.Pose.turned(self, angle, algebra))

    def displaced(self, displacement: Sequence[Scalar], algebra: Algebra) -> "Pose":
        """After a small displacement in the plane: exact in its first derivatives where it is 0."""
        *ahead, angle = displacement
        turn, flat = base_of(angle), self.moved(ahead)
        cos, sin = minus(self.cos, times(self.sin, turn)), plus(self.sin, times(self.cos, turn))
        return Pose(flat.x, flat.y, plus(self.phi, angle), cos, sin, self.height, self.own, self.world)

    def in_plane(self, vector: Sequence[Scalar]) -> Vector:
        """Components along the axes of the plane at phi = 0 of a vector in the frame's axes."""
        return spatial.times_matrix(self.own, vector)

    def turned_axes(self) -> Matrix:
        """What takes vectors in the frame's axes to those of the plane, with its rates where the pose has some."""
        columns = ((*self.to_world(column[:_NORMAL]), column[_NORMAL]) for column in spatial.transposed(self.own))
        return spatial.transposed(tuple(columns))


def here(plane: Plane) -> Pose:
    """Of a frame that has the axes of the plane, seen from itself."""
    return Pose(0.0, 0.0, 0.0, 1.0, 0.0, 0.0, spatial.HERE.axes, plane.axes)


def root_pose(plane: Plane, number: Callable[[float], Scalar]) -> Pose:
    """Of the ground."""
    zero, one = number(0.0), number(1.0)
    return Pose(zero, zero, zero, one, zero, 0.0, spatial.transposed(plane.axes), plane.axes)


def attribute_of(pose: Pose, name: str) -> Value:
    """An attribute of a frame, with three components in the world's axes; a velocity, where the pose is of Duals."""
    if name == "R":
        return spatial.product(pose.world, pose.turned_axes())
    about = planar.attribute_of(pose, "w") if SPACE.attributes[name].kind == "velocity" else 0.0
    if name in ("omega", ABOUT_Z):
        omega = tuple(times(x, about) for x in pose.own[_NORMAL])
        return omega[2] if name == ABOUT_Z else omega
    if SPACE.attributes[name].kind == "velocity":
        flat = (*planar.attribute_of(pose, "v"), 0.0), (0.0, 0.0, about)
        numbers: tuple[Scalar, ...] = tuple(x for part in flat for x in spatial.times_matrix(pose.world, part))
    else:
        numbers = spatial.times_matrix(pose.world, (pose.x, pose.y, pose.height))
    return spatial.picked(name, numbers)


def step(pose: Pose, step: Step, amount: Value, axis: Value | None, algebra: Algebra) -> Pose:
    """The pose after a step of this amount. Raises LagError L0303."""
    if step.kind == "turn":
        if isinstance(amount, tuple):
            fail("L0303", "an angle is a number", step.amount.span)
        side = along_normal(pose.in_plane(spatial.unit_axis(step, axis, algebra)))
        if side:
            return pose.turned(amount if (side > 0) != step.is_inverse else -amount, algebra)
        turn = spatial.rotation(spatial.unit_axis(step, axis, algebra), -amount if step.is_inverse else amount, algebra)
        return replace(pose, own=spatial.plain_matrix(spatial.product(pose.own, turn)))
    if not isinstance(amount, tuple) or len(amount) != 3:
        fail("L0303", "a shift needs a vector of three components", step.amount.span, "write {x, y, z}")
    ahead = pose.in_plane(tuple(-a for a in amount) if step.is_inverse else amount)
    further = replace(pose, height=plus(pose.height, base_of(ahead[_NORMAL])))
    return further.moved(further.to_world(ahead[:_NORMAL]))


def along_normal(axis: Sequence[Scalar]) -> int:
    """The side, 1 or -1, to which an axis of length 1 points along the normal; 0 of one that lies elsewhere."""
    if not all(isinstance(x, float | int) for x in axis) or max(abs(axis[0]), abs(axis[1])) > _PARALLEL:
        return 0
    return 1 if axis[_NORMAL] > 0 else -1


def beside(a: Pose, b: Pose) -> tuple[Scalar, Scalar, Scalar]:
    """How far b is above a's plane, m, and how it is tilted against it, rad: nothing moves these."""
    turn = spatial.plain_matrix(spatial.product(b.own, spatial.transposed(a.own)))
    return minus(b.height, a.height), turn[1][_NORMAL], minus(0.0, turn[0][_NORMAL])


def seen_alike(a: Pose, b: Pose, algebra: Algebra) -> Pose:
    """b with its own axes as a's are, and with the angle that this takes."""
    turn = spatial.plain_matrix(spatial.product(b.own, spatial.transposed(a.own)))
    ahead = atan2(turn[1][0], turn[0][0])
    if ahead == 0:
        return b
    return replace(b.turned(ahead, algebra), own=spatial.product(spatial.rotation((0, 0, 1), -ahead, algebra), b.own))


class FreeBody(planar_inertia.FreeBody):
    """A body with a free twist in the plane, at a general angle. The plane lies as it does, or, where the body's own numbers are
    read off, as if its axes were the world's, which these do not feel."""

    def __init__(self, plane: Plane) -> None:
        super().__init__()
        self.plane = plane

    @cached_property
    def _world(self) -> Matrix:
        return tuple(tuple(symbol(f"W{i}{j}") for j in range(3)) for i in range(3))

    def velocity(self, attribute: str, place: Any, own: Any) -> Value:
        """v or w, in the world's axes, or omega, in its own, of a frame of the body; `own`: where the frame of the body sits."""
        w = self.twist[_NORMAL]
        if attribute in ("omega", ABOUT_Z):
            omega = tuple(times(x, w) for x in place.own[_NORMAL])
            return omega[2] if attribute == ABOUT_Z else omega
        flat = (0.0, 0.0, w) if attribute == "w" else (*super().velocity("v", place, own), 0.0)
        return spatial.times_matrix(self._world, flat)

    def straight(self, turned: ca.SX) -> ca.SX:
        """Hessians at the angle 0."""
        symbols = [x for row in self._world for x in row]
        (found,) = ca.substitute([super().straight(turned)], symbols, [ca.SX(float(k % 4 == 0)) for k in range(9)])
        return found

    @property
    def general(self) -> dict[int, float]:
        """Numbers of a general angle, by the hashes of the symbols."""
        pairs = zip(self._world, self.plane.axes, strict=True)
        return super().general | {x.__hash__(): value for row, values in pairs for x, value in zip(row, values, strict=True)}
