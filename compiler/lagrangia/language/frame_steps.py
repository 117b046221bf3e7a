"""The parts of the way from one frame to another, as the language writes it: shifts and turns."""

from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.language.tree import Call, Flat, FrameRef


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


def unfold(node: Flat) -> tuple[str, tuple[Step, ...]]:
    """shift(turn(a, phi), d) as the frame a and the steps from it. Raises LagError L0221."""
    if isinstance(node, FrameRef) and not node.attribute:
        return node.name, ()
    if isinstance(node, Call) and node.function in ("shift", "turn"):
        base, steps = unfold(node.arguments[0])
        _, amount, *axis = node.arguments
        return base, (*steps, Step(node.function, amount, axis=axis[0] if axis else None))
    fail("L0221", "this is no frame", node.span, "a frame is a port, as bar.a, or shift(...) or turn(...) of one")


def between(left: Flat, right: Flat) -> tuple[str, str, tuple[Step, ...]]:
    """Of an equation of frames: the frame on its right, that on its left, and the steps from the one to the other."""
    (child, left_steps), (parent, right_steps) = unfold(left), unfold(right)
    return parent, child, right_steps + tuple(step.inverse() for step in reversed(left_steps))
