"""A cut joint, seen from the frames on its two sides: what must vanish, and the coordinate it had.

hinge: r_b = r_a, phi = phi_b - phi_a;  slider along d from the offset o: phi_b = phi_a, d x (R_a^T (r_b - r_a) - o) = 0,
s = d . (R_a^T (r_b - r_a) - o)/|d|^2;  weld: r_b = r_a, phi_b = phi_a.
"""

from typing import Protocol

from lagrangia.algebra.duals import Scalar, value_of
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.frames.edges import Closure, Step
from lagrangia.frames.evaluation import Evaluator, Leaves, Value
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.planar import Pose


class Frames(Leaves, Protocol):
    """What is asked about frames: kinematics.Kinematics."""

    graph: ComponentGraph
    algebra: CasadiAlgebra
    evaluator: Evaluator

    def pose(self, name: str, level: int) -> Pose:
        """That of a frame, at a level."""

    def step(self, step: Step, pose: Pose, level: int) -> Pose:
        """The pose behind a step that begins at another one."""


def gaps(frames: Frames, closure: Closure, level: int) -> list[Scalar]:
    """What must vanish, at a level of the kinematics; lengths in m, angles in rad."""
    a, b = _ends(frames, closure, level)
    if closure.kind == "slider":
        x, y, dx, dy, length = _along(frames, closure, a, b)
        return [b.phi - a.phi, (dx * y - dy * x) / length]
    place = [b.x - a.x, b.y - a.y]
    return place if closure.kind == "hinge" else [*place, b.phi - a.phi]


def cut_coordinate(frames: Frames, closure: Closure, level: int) -> Scalar:
    """The coordinate of the cut joint, read off the frames."""
    a, b = _ends(frames, closure, level)
    assert closure.freedom is not None
    if closure.kind == "hinge":
        return a.phi - b.phi if closure.freedom.is_inverse else b.phi - a.phi
    x, y, dx, dy, length = _along(frames, closure, a, b)
    return (dx * x + dy * y) / (length * length)


def slide_normal(frames: Frames, closure: Closure) -> tuple[Scalar, Scalar, Scalar]:
    """Unit vector across a cut slider, in world axes, and the way that the slider goes when its coordinate grows by 1."""
    a, b = _ends(frames, closure, 0)
    _, _, dx, dy, length = _along(frames, closure, a, b)
    return (a.cos * -dy - a.sin * dx) / length, (a.sin * -dy + a.cos * dx) / length, length


def meeting_place(frames: Frames, closure: Closure) -> Pose:
    """Where the frame b of a closure is held: b itself, or what its joint has fixed to it."""
    return _ends(frames, closure, 0)[1]


def _ends(frames: Frames, closure: Closure, level: int) -> tuple[Pose, Pose]:
    """The two poses that a closure brings together; at level 0 the values of those at level 1."""
    at = max(1, level)
    a, b = frames.pose(closure.a, at), frames.pose(closure.b, at)
    for step in closure.steps_a:
        a = frames.step(step, a, at)
    for step in closure.steps_b:
        b = frames.step(step, b, at)
    return (a.map(value_of), b.map(value_of)) if level == 0 else (a, b)


def _along(frames: Frames, closure: Closure, a: Pose, b: Pose) -> tuple[Scalar, Scalar, Scalar, Scalar, Scalar]:
    """b's origin from the slider's offset in a's axes, the slider's direction and its length."""
    assert closure.freedom is not None
    (ox, oy), (dx, dy) = _slide(frames, closure.freedom, closure.coordinate)
    x, y = b.x - a.x, b.y - a.y
    local = a.cos * x + a.sin * y - ox, a.cos * y - a.sin * x - oy
    return *local, dx, dy, frames.evaluator.norm((dx, dy), 0)


def _slide(frames: Frames, freedom: Step, coordinate: str) -> tuple[Value, Value]:
    """Offset and direction of a shift that is linear in its coordinate."""
    model, algebra = frames.graph.model, frames.algebra
    places = (algebra.number(0.0), algebra.number(1.0))
    origin, ahead = (Evaluator(model, algebra, _Held(frames, coordinate, at)).value(freedom.amount) for at in places)
    sign = -1 if freedom.is_inverse else 1
    return tuple(sign * x for x in origin), tuple(sign * (y - x) for x, y in zip(origin, ahead, strict=True))


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
