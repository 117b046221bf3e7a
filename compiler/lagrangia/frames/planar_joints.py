"""Cut joints of the plane, between a frame a and a frame b: what must vanish, the coordinate, the wrench on b.

hinge: r_b = r_a, phi = phi_b - phi_a;  slider along d from the offset o: phi_b = phi_a, d x (R_a^T (r_b - r_a) - o) = 0,
s = d . (R_a^T (r_b - r_a) - o)/|d|^2;  weld: r_b = r_a, phi_b = phi_a.
"""

from collections.abc import Sequence

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.base.records import dataclass
from lagrangia.frames.planar import Pose
from lagrangia.language.frame_steps import Step
from lagrangia.language.mentions import is_linear
from lagrangia.language.tree import Ref

# How well a loop is cut at each kind, and by 1 better where nothing is said about the start of its coordinate.
WORTH_CUTTING = {"weld": 0, "slider": 1, "hinge": 3, "cross": 5, "cylinder": 5, "ball": 7}
GAPS = {"weld": 3, "slider": 2, "hinge": 2}  # in the plane


def cut_as(step: Step, coordinate: str) -> str:
    """The kind of a cut joint with one coordinate, which moves this step alone."""
    if step.kind == "turn" and isinstance(step.amount, Ref):
        return "hinge"
    return "slider" if step.kind == "shift" and is_linear(step.amount, coordinate) else "weld"


@dataclass(frozen=True)
class Slide:
    """A shift from a's origin that is linear in its coordinate, in a's axes; `length` is that of its direction, `rise` is out of
    the plane."""

    offset: Sequence[Scalar]
    direction: Sequence[Scalar]
    length: Scalar
    rise: Scalar = 0.0

    def seen(self, a: Pose, b: Pose) -> tuple[Scalar, Scalar]:
        """b's origin from the offset, in a's axes."""
        (x, y), (cos, sin) = (b.x - a.x, b.y - a.y), a.axis
        return cos * x + sin * y - self.offset[0], cos * y - sin * x - self.offset[1]


def gaps(kind: str, a: Pose, b: Pose, slide: Slide | None) -> list[Scalar]:
    """What must vanish, lengths in m, angles in rad; `slide` of a slider."""
    if slide is not None:
        (x, y), (dx, dy) = slide.seen(a, b), slide.direction
        return [b.phi - a.phi, (dx * y - dy * x) / slide.length]
    place = [b.x - a.x, b.y - a.y]
    return place if kind == "hinge" else [*place, b.phi - a.phi]


def gap_of(kind: str, part: int) -> str:
    """What the gap of a cut joint is: x, y, angle, or across a slide."""
    return (("angle", "across") if kind == "slider" else ("x", "y", "angle"))[part]


def coordinate(a: Pose, b: Pose, slide: Slide | None, is_inverse: bool) -> Scalar:
    """That of a hinge or slider."""
    if slide is None:
        return a.phi - b.phi if is_inverse else b.phi - a.phi
    (x, y), (dx, dy) = slide.seen(a, b), slide.direction
    return (dx * x + dy * y) / (slide.length * slide.length)


def wrench_on_b(kind: str, a: Pose, slide: Slide | None, is_inverse: bool, forces: Sequence[Scalar],
                drive: Scalar) -> list[Scalar]:
    """What holds b: `forces` push the gaps shut, `drive` takes from what acts on the coordinate."""
    if kind == "weld":
        return [*forces]
    if slide is None:
        return [*forces, drive if is_inverse else -drive]
    torque, across = forces
    dx, dy = slide.direction
    x, y = (a.cos * -dy - a.sin * dx) / slide.length, (a.sin * -dy + a.cos * dx) / slide.length  # across, in the world's axes
    along = -drive / slide.length
    return [across * x + along * y, across * y - along * x, torque]


def unit_load(slopes: Sequence[ca.SX]) -> ca.SX:
    """The wrench that does the work of a unit force on a coordinate by which a place changes with these slopes."""
    x, y, turn = slopes
    if turn.is_zero():
        return ca.vertcat(x, y, 0) / (x * x + y * y)
    return ca.vertcat(0, 0, 1 / turn)
