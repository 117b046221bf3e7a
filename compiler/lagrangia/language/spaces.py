"""Whether a scene lies in a plane or in space: found while its text is flattened, and not declared.

A text is taken for a planar one until a statement says what no plane has: a turn about an axis that is not along z, a third
component that is not plainly 0, or a word of space. Then it is flattened anew, as one in space. All that decides stands here.
"""

from collections.abc import Callable
from dataclasses import replace
from typing import NoReturn

from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.language.folding import fold
from lagrangia.language.frame_attributes import PLANE, SPACE, SPATIAL_ONLY, Space
from lagrangia.language.tree import Array, Call, Flat, Number, Unary

ANNOTATION = "Space"  # of variables that are otherwise in space: space_values.py
FUNCTIONS = frozenset({"to_world", "to_frame", "velocity_at"})  # that no plane has


@dataclass(frozen=True)
class Found:
    """What a scene is in; where it is space, the statement that says so, and what it says."""

    space: Space = PLANE
    span: Span | None = None
    why: str = ""


class FoundSpaceError(Exception):
    """A statement of a text that was taken for a planar one says otherwise."""

    def __init__(self, found: Found) -> None:
        super().__init__(found.why)
        self.found = found

    def placed(self, outside: Callable[[Span], Span]) -> "FoundSpaceError":
        """The same, told where people look for what a library says."""
        span = self.found.span
        return FoundSpaceError(replace(self.found, span=outside(span) if span is not None else None))


def leave_plane(span: Span | None, why: str) -> NoReturn:
    """What no plane has was found."""
    raise FoundSpaceError(Found(SPACE, span, why))


def name_of_space(space: Space, name: str, span: Span | None) -> None:
    """Leaves the plane for an attribute or a function that only space has."""
    if not space.is_spatial and (name in SPATIAL_ONLY or name in FUNCTIONS):
        leave_plane(span, f"it speaks of {name}")


def vector_of_plane(node: Flat, third: Flat, what: str) -> None:
    """Leaves the plane where the third component is not plainly 0."""
    if fold(third) != 0:
        leave_plane(node.span, f"{what} has a third component")


def along_z(axis: Flat) -> int | None:
    """The side, 1 or -1, to which an axis points that is plainly along z; None for others."""
    if not isinstance(axis, Array) or len(axis.items) != 3:
        return None
    x, y, z = (fold(item) for item in axis.items)
    if x != 0 or y != 0 or z is None or z == 0:
        return None
    return 1 if z > 0 else -1


def turn_of_plane(call: Call[Flat]) -> Call[Flat]:
    """turn(a, phi, axis) as turn(a, phi), where the axis is along z; leaves the plane for others."""
    base, angle, axis = call.arguments
    side = along_z(axis)
    if side is None:
        leave_plane(call.span, f"it turns about the axis {_written(axis)}")
    if side < 0:
        angle = Number(-angle.value, angle.unit, angle.span) if isinstance(angle, Number) else Unary("-", angle, angle.span)
    return Call("turn", (base, angle), (), call.span)


def _written(axis: Flat) -> str:
    """Its numbers where they are known: a structural value is marked where it is used, by its name."""
    numbers = [fold(item) for item in axis.items] if isinstance(axis, Array) else [None]
    return axis.span.text if None in numbers else "{" + ", ".join(f"{x:g}" for x in numbers if x is not None) + "}"
