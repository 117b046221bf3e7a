"""A cut joint, seen from the frames on its two sides: what must vanish, and the coordinate it had (planar_joints.py)."""

from collections.abc import Sequence

from lagrangia.algebra.duals import Scalar, minus
from lagrangia.base.diagnostics import LagError
from lagrangia.frames import in_plane, planar_joints, spatial_closures
from lagrangia.frames.closure_frames import Frames, way_of_shift
from lagrangia.frames.edges import Closure
from lagrangia.frames.geometry import Pose
from lagrangia.frames.planar_joints import Slide
from lagrangia.frames.spatial import unit_axis
from lagrangia.language.frame_steps import Step

_LENGTHS = 3  # of the gaps of a cut joint in space, before as many angles


def gaps(frames: Frames, closure: Closure, level: int) -> list[Scalar]:
    """What must vanish, at a level of the kinematics; lengths in m, angles in rad."""
    try:
        if frames.geometry.by_rates:
            return spatial_closures.gaps(frames, closure, level)
        a, b = _ends(frames, closure, level)
        slide = _slide(frames, closure, a)
        found = planar_joints.gaps(closure.kind, a, _alike(frames, a, b), slide)
        return [*found, *_beside(frames, a, b, slide)]
    except LagError as error:
        raise error.placed(closure.span) from None


def gap_of(frames: Frames, closure: Closure, part: int) -> str:
    """What its so-manieth gap is: x, y, z, angle, or across a slide."""
    if not frames.geometry.by_rates:
        own = planar_joints.GAPS[closure.kind]
        return planar_joints.gap_of(closure.kind, part) if part < own else "z" if part == own else "angle"
    if part >= _LENGTHS:
        return "angle"
    return "xyz"[part] if closure.freedom is None or closure.kind in ("hinge", "ball", "cross") else "across"


def gaps_of_start(frames: Frames, closure: Closure) -> list[Scalar]:
    """What must vanish at the start, from places that may be far from closed."""
    return spatial_closures.gaps_of_start(frames, closure) if frames.geometry.by_rates else gaps(frames, closure, 0)


def is_across(frames: Frames, closure: Closure, part: int) -> bool:
    """Whether its so-manieth gap is across the plane in which all of a scene in space moves, where there is one."""
    return frames.geometry.by_poses and not frames.geometry.by_rates and part >= planar_joints.GAPS[closure.kind]


def cut_coordinate(frames: Frames, closure: Closure, level: int) -> Scalar:
    """The coordinate of the cut joint, read off the frames."""
    assert closure.freedom is not None
    a, b = _ends(frames, closure, level)
    return planar_joints.coordinate(a, _alike(frames, a, b), _slide(frames, closure, a), _is_inverse(frames, closure.freedom, a))


def wrench_on_b(frames: Frames, closure: Closure, forces: Sequence[Scalar], drive: Scalar) -> list[Scalar]:
    """What holds the frame b: `forces` push the gaps shut, `drive` takes from what acts on the joint's coordinate."""
    if frames.geometry.by_rates:
        return spatial_closures.wrench_on_b(frames, closure, forces)
    a = _ends(frames, closure, 0)[0]
    is_inverse = closure.freedom is not None and _is_inverse(frames, closure.freedom, a)
    return planar_joints.wrench_on_b(closure.kind, a, _slide(frames, closure, a), is_inverse, forces, drive)


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
    return (a.lowered, b.lowered) if level == 0 else (a, b)


def _alike(frames: Frames, a: Pose, b: Pose) -> Pose:
    """b, with an angle to be compared with a's."""
    return in_plane.seen_alike(a, b, frames.evaluator.algebras[0]) if frames.geometry.by_poses else b


def _is_inverse(frames: Frames, freedom: Step, a: Pose) -> bool:
    """Whether a's side of a hinge turns ahead of b's: by the way that it is written, or as its axis points down the normal."""
    if freedom.kind != "turn" or not frames.geometry.by_poses:
        return freedom.is_inverse
    axis = frames.evaluator.value(freedom.axis) if freedom.axis is not None else None
    side = in_plane.along_normal(a.in_plane(unit_axis(freedom, axis, frames.algebra)))
    assert side, "found_plane.py has seen that the axis is along the normal, and compiled its numbers in"
    return freedom.is_inverse != (side < 0)


def _beside(frames: Frames, a: Pose, b: Pose, slide: Slide | None) -> Sequence[Scalar]:
    """What holds in a plane of space as long as nothing leaves it."""
    if not frames.geometry.by_poses:
        return ()
    rise, *tilts = in_plane.beside(a, b)
    return [minus(rise, slide.rise) if slide is not None else rise, *tilts]


def _slide(frames: Frames, closure: Closure, a: Pose) -> Slide | None:
    """Offset and direction of a slider's shift from a, which is linear in its coordinate."""
    if closure.kind != "slider":
        return None
    assert closure.freedom is not None
    origin, ahead = way_of_shift(frames, closure.freedom, closure.coordinate)
    sign, rise = -1 if closure.freedom.is_inverse else 1, 0.0
    if frames.geometry.by_poses:
        (*origin, rise), (*ahead, _) = (a.in_plane(vector) for vector in (origin, ahead))
    direction = tuple(sign * (y - x) for x, y in zip(origin, ahead, strict=True))
    return Slide(tuple(sign * x for x in origin), direction, frames.evaluator.norm(direction, 0), sign * rise)
