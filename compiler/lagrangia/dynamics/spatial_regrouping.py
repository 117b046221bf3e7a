"""What a joint does not feel of a body is handed to the body that carries the joint: accelerations stay, operations go.

A hinge moves no point of its axis: the mass of what it carries, the first moment along the axis and as much second moment about
everything across as one likes may be points on the axis, and those the parent's. Likewise the mass at the centre of a ball
joint, and the second moment of what a slider carries. No weight or bias changes, since twists do not tell the two apart.
Mass grows from joint to joint, so that it stays now and then; the rest lessens with each tilt.
Source: Gautier and Khalil, Direct calculation of minimum set of inertial parameters of serial robots (1990).
"""

from collections.abc import Sequence
from dataclasses import replace

from lagrangia.algebra.duals import Scalar, is_zero, minus, plus, times
from lagrangia.base.records import dataclass
from lagrangia.frames.spatial_inertia import SAME, RigidInertia, scaled

_MOST_HANDED = 8  # joints in a row over which mass goes: it grows with each, and what is taken back costs digits
_LARGEST_COSINE = 0.9  # between hinges
_AXIS = (0.0, 0.0, 1.0)
_STILL = (0.0, 0.0, 0.0)
_NO_MOMENT = (_STILL,) * 3
_OF_MASS = 9  # operations of accelerations, about; of first moments with 0 to 3 components that are not 0:
_OF_MOMENT = (0, 13, 26, 36)


@dataclass(frozen=True)
class Meeting:
    """A joint where it meets its parent's link: `kind` as of SpatialJoint, or "screw", which feels all of its body; centre and
    axis in the axes in which the parent's body is constant; `ahead`: of the centre along the axis, from the origin of its own
    link."""

    parent: int | None
    kind: str
    centre: Sequence[Scalar]
    axis: Sequence[Scalar] = _AXIS
    ahead: Scalar = 0.0


def regrouped(meetings: Sequence[Meeting], bodies: Sequence[RigidInertia | None]) -> list[RigidInertia | None]:
    """Bodies that take fewer operations and make the same motion. Each in the axes of its link in which it is constant, z along a
    hinge. Only to a link with a body something is handed, so that what moves nothing is known as before."""
    found, handed = [*bodies], [0] * len(bodies)
    for k in reversed(range(len(found))):
        body, at = found[k], meetings[k]
        carrier = found[at.parent] if at.parent is not None else None
        if body is None or body.is_nothing or at.kind == "screw" or (at.parent is not None and carrier is None):
            continue
        if (is_far := handed[k] >= _MOST_HANDED) and not _is_aslant(at):
            continue
        kept, given = _split(body, at, keeps_mass=is_far)
        if carrier is None:
            found[k] = kept
        elif at.parent is not None and _cost(kept) + _cost(more := carrier.with_other(given)) < _cost(body) + _cost(carrier):
            found[k], found[at.parent] = kept, more
            handed[at.parent] = max(handed[at.parent], 0 if is_far else handed[k] + 1)
    return found


def _split(body: RigidInertia, at: Meeting, keeps_mass: bool) -> tuple[RigidInertia, RigidInertia]:
    """What a joint feels, in the axes of its link, and what it does not, in those of the parent's. The mass may stay, at the
    origin of a hinge's link."""
    if at.kind == "rotation":
        return (RigidInertia(0.0, body.moment, body.second_moment),
                RigidInertia(body.mass, _STILL, _NO_MOMENT).placed(SAME, at.centre))
    if at.kind == "shift":
        return RigidInertia(body.mass, body.moment, _NO_MOMENT), RigidInertia(0.0, _STILL, body.second_moment)
    kept, across = _without_axis(body)
    mass = 0.0 if keeps_mass else body.mass
    along = RigidInertia(mass, (0.0, 0.0, body.moment[2]), ((across, 0.0, 0.0), (0.0, across, 0.0), _STILL))
    along = along.placed(SAME, (0.0, 0.0, minus(0.0, at.ahead)))
    J = [[times(along.second_moment[0][0], minus(1.0 if i == j else 0.0, times(x, y))) for j, y in enumerate(at.axis)]
         for i, x in enumerate(at.axis)]
    given = RigidInertia(mass, scaled(along.moment[2], at.axis), J)
    return replace(kept, mass=body.mass) if keeps_mass else kept, given.placed(SAME, at.centre)


def _without_axis(body: RigidInertia) -> tuple[RigidInertia, Scalar]:
    """A body behind a hinge along z without what is on it, which is flat, and the second moment across that is taken away."""
    J = [[*row] for row in body.second_moment]
    across = times(0.5, minus(plus(J[0][0], J[1][1]), J[2][2]))
    J[0][0], J[1][1] = minus(J[0][0], across), minus(J[1][1], across)
    return RigidInertia(0.0, [*body.moment[:2], 0.0], J, is_flat=True), across


def _is_aslant(at: Meeting) -> bool:
    """Whether a hinge is tilted against the parent's so that second moments about both lessen from one to the next."""
    z = at.axis[2]
    return at.kind == "turn" and isinstance(z, float) and abs(z) <= _LARGEST_COSINE


def _cost(body: RigidInertia) -> int:
    """Operations of accelerations that come of it, about."""
    J = body.second_moment
    rows = [sum(not is_zero(x) for x in row) for row in J]
    moment = sum(not is_zero(x) for x in body.moment)
    mixed = 0 if body.is_diagonal else sum(2 * count for count in rows)
    return (0 if is_zero(body.mass) else _OF_MASS) + _OF_MOMENT[moment] + sum(rows) + mixed
