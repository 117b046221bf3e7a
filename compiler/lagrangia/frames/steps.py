"""The parts of the way from one frame to another, as the language writes it: shifts and turns."""

from lagrangia.base.records import dataclass
from lagrangia.language.tree import Flat


@dataclass(frozen=True, slots=True)
class Step:
    """A part of the way from one frame to another: shift by a vector or turn by an angle, forwards or backwards."""

    kind: str  # "shift" or "turn"
    amount: Flat
    is_inverse: bool = False
    axis: Flat | None = None  # of a turn in space, in the axes of the frame it begins at; None: z

    def inverse(self) -> "Step":
        """The way back."""
        return Step(self.kind, self.amount, not self.is_inverse, self.axis)
