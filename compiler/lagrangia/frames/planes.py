"""That all of a scene in space moves in parallel planes, or why it does not: found by constraints/found_plane.py."""

from collections.abc import Mapping

from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.frames.spatial import Matrix


@dataclass(frozen=True)
class Plane:
    """`axes` takes vectors in the axes of the plane, two in it and its normal, to the world's; `numbers` are those of parameters
    by which all lies in it: they are compiled in."""

    axes: Matrix
    numbers: Mapping[str, tuple[float | None, ...]]
    span: Span  # of what turns first


@dataclass(frozen=True)
class NoPlane:
    """Why a scene in space lies in none, and the statement that says so."""

    why: str
    span: Span | None
