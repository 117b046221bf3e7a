"""Points that are held together in space, as by a ball joint: three constraints, along the axes of the world or of a body.

Along the axes of the world each of the three knows of all turns of both bodies. Along those of a bar that stands on a ball joint
one knows nothing of its turns, for the bar stays as long as it is, and the others of one each.
"""

from collections.abc import Sequence

from lagrangia.base.records import dataclass
from lagrangia.constraints.rows import Row
from lagrangia.language.tree import FrameRef

_COMPONENTS = 3


@dataclass(frozen=True)
class HeldPoints:
    """The three constraints of (other.r - own.r) sign = 0, looked at along the axes of the frame `own`."""

    rows: tuple[int, ...]
    own: str
    other: str
    sign: float

    @property
    def swapped(self) -> "HeldPoints":
        """Along the axes of the other frame."""
        return HeldPoints(self.rows, self.other, self.own, -self.sign)


def find_held_points(rows: Sequence[Row]) -> list[HeldPoints]:
    """Of closed ball joints, and of equations a.r = b.r."""
    groups: dict[int, list[int]] = {}
    for k, row in enumerate(rows):
        if row.part < _COMPONENTS:
            groups.setdefault(id(row.loop or row.equation), []).append(k)
    found = []
    for group in groups.values():
        ends = _ends(rows[group[0]])
        if ends is not None and [rows[k].part for k in group] == [*range(_COMPONENTS)]:
            found.append(HeldPoints(tuple(group), *ends, 1.0))
    return found


def _ends(row: Row) -> tuple[str, str] | None:
    if row.loop is not None:
        loop = row.loop
        return (loop.a, loop.b) if loop.kind == "ball" and not (loop.steps_a or loop.steps_b) else None
    sides = (row.equation.right, row.equation.left) if row.equation is not None else ()
    names = [x.name for x in sides if isinstance(x, FrameRef) and x.attribute == "r" and not x.index]
    return (names[0], names[1]) if len(names) > 1 else None
