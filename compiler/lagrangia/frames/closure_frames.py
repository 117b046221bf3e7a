"""What closures of loops ask about frames."""

from collections.abc import Sequence
from typing import Any, Protocol

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Leaves, Value
from lagrangia.frames.geometry import Geometry, Pose
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.quaternions import Quaternion
from lagrangia.frames.spatial import Matrix
from lagrangia.language.frame_steps import Step


class Frames(Leaves, Protocol):
    """kinematics.Kinematics."""

    graph: ComponentGraph
    algebra: CasadiAlgebra
    evaluator: Evaluator
    seen: dict[tuple[str, int], dict[str, Any]]  # poses from bases of loops, by levels
    closed: dict[tuple[int, int], list[Scalar]]  # gaps, by ids of closures in space and levels

    @property
    def is_displaced(self) -> bool:
        """Whether there are virtual displacements."""
    @property
    def geometry(self) -> Geometry:
        """What frames are."""

    def pose(self, name: str, level: int) -> Pose:
        """That of a frame, at a level."""

    def follow(self, edge: Edge, pose: Pose, level: int) -> Pose:
        """The pose of the edge's child, given its parent's."""

    def step(self, step: Step, pose: Pose, level: int) -> Pose:
        """The pose behind a step that begins at another one."""

    def attitude_of(self, step: Step) -> str | None:
        """The coordinate that a turn is by, if it is an attitude."""

    def turn_by(self, step: Step, level: int) -> Quaternion | None:
        """The quaternion of a turn by an attitude; None of other steps."""

    def coordinate(self, name: str, level: int) -> Scalar:
        """A coordinate at a level."""

    def quaternion(self, attitude: str, level: int) -> Quaternion:
        """Of a coordinate that is one."""

    def axes_of(self, attitude: str) -> Matrix:
        """What takes vectors in the turned axes to the others."""

    def without_accelerations(self) -> "Frames":
        """The same motion with dv/dt = 0."""


class _Held:
    """Leaves of an evaluator in which one coordinate has a given number for its value."""

    def __init__(self, frames: Frames, coordinate: str, at: Scalar) -> None:
        self.frames, self.coordinate, self.at = frames, coordinate, at

    def symbol(self, name: str, level: int) -> Value | None:
        return self.at if name == self.coordinate else self.frames.symbol(name, level)

    def time(self, level: int) -> Scalar:
        return self.frames.time(level)

    def frame(self, name: str, attribute: str, level: int) -> Value:
        raise AssertionError("a joint depends on no frame")


def way_of_shift(frames: Frames, step: Step, coordinate: str) -> tuple[Sequence[Scalar], Sequence[Scalar]]:
    """Where a shift that is linear in its coordinate is at 0, and at 1, in the axes of the frame that it begins at."""
    places = (frames.algebra.number(0.0), frames.algebra.number(1.0))
    held = (_Held(frames, coordinate, at) for at in places)
    origin, ahead = (Evaluator(frames.graph.model, frames.algebra, leaves).value(step.amount) for leaves in held)
    return origin, ahead
