"""What the plane is: the pose of a frame."""

from collections.abc import Callable
from dataclasses import dataclass

from lagrangia.algebra.duals import Scalar


@dataclass(frozen=True, slots=True)
class Pose:
    """Place of a frame: origin (m), angle (rad), and the cosine and sine of the angle."""

    x: Scalar
    y: Scalar
    phi: Scalar
    cos: Scalar
    sin: Scalar

    def map(self, function: Callable[[Scalar], Scalar]) -> "Pose":
        """The pose whose numbers are the function's of these."""
        return Pose(*(function(x) for x in (self.x, self.y, self.phi, self.cos, self.sin)))
