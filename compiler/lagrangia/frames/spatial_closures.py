"""The closures of a scene in space, seen from the frame at which the two sides of a loop part: what lies before that is not felt,
so that a row of loops costs as many times what one costs."""

from collections.abc import Sequence
from dataclasses import replace

from lagrangia.algebra.duals import Scalar, dot, is_zero, minus
from lagrangia.frames import spatial_joints
from lagrangia.frames.closure_frames import Frames, way_of_shift
from lagrangia.frames.edges import Closure, Edge
from lagrangia.frames.quaternions import Quaternion, quaternion_along
from lagrangia.frames.spatial import NOWHERE, Matrix, Pose, Vector, plain_matrix, product, rotation, transposed, unit_axis
from lagrangia.frames.spatial_joints import UNIT, Kept, triad
from lagrangia.language.attitudes import parts_of
from lagrangia.language.frame_steps import Step
from lagrangia.language.tree import Ref


def gaps(frames: Frames, closure: Closure, level: int) -> list[Scalar]:
    """What must vanish, at a level; lengths in m, angles in rad. Made once for all rows that ask."""
    found = frames.closed.get((id(closure), level))
    if found is None:
        a, b, back = _sides(frames, closure, level)
        found = spatial_joints.gaps(a, b, back, _kept(frames, closure, level), frames.algebra)
        frames.closed[id(closure), level] = found
    return found


def gaps_of_start(frames: Frames, closure: Closure) -> list[Scalar]:
    """The same of a place that may be far from closed: nothing that is put together the wrong way round makes them vanish."""
    a, b = (_quaternion(frames, closure.base, name, steps)
            for name, steps in ((closure.a, closure.steps_a), (closure.b, closure.steps_b)))
    turns = spatial_joints.turned_too_far(a, b, _kept(frames, closure, 0), frames.algebra)
    return [*gaps(frames, closure, 0)[:3], *turns]


def wrench_on_b(frames: Frames, closure: Closure, forces: Sequence[Scalar]) -> list[Scalar]:
    """Force and torque that push the gaps shut, along the world's axes."""
    a, b = (_behind(frames, frames.pose(name, 1), steps, 1).lowered
            for name, steps in ((closure.a, closure.steps_a), (closure.b, closure.steps_b)))
    kept, back = _kept(frames, closure, 0), _back_of(frames, closure, 1)
    axes = spatial_joints.axes_of_lengths(a, back, kept), spatial_joints.axes_of_gaps(a, b, kept)
    return [x for part, along in zip((forces[:3], forces[3:]), axes, strict=True) for x in _sum(part, along)]


def _sum(amounts: Sequence[Scalar], axes: Sequence[Vector]) -> Vector:
    return tuple(dot([*amounts], [axis[k] for axis in axes]) for k in range(3))


def _sides(frames: Frames, closure: Closure, level: int) -> tuple[Pose, Pose, Matrix]:
    """The poses of both sides of the joint, and what takes vectors to the axes of the base."""
    at = max(1, level)
    if frames.is_displaced:
        a, b = frames.pose(closure.a, at), frames.pose(closure.b, at)
        back = _back_of(frames, closure, at)
    else:
        a, b = (_from_base(frames, closure, name, at) for name in (closure.a, closure.b))
        back = UNIT
    a, b = _behind(frames, a, closure.steps_a, at), _behind(frames, b, closure.steps_b, at)
    return (a.lowered, b.lowered, back) if level == 0 else (a, b, back)


def _behind(frames: Frames, pose: Pose, steps: Sequence[Step], level: int) -> Pose:
    for step in steps:
        pose = frames.step(step, pose, level)
    return pose


def _from_base(frames: Frames, closure: Closure, name: str, level: int) -> Pose:
    """The pose of a frame behind the base, in its axes as they are turned for all loops that part there."""
    first = _first_at(frames, closure)
    if level == 1 and len(frames.evaluator.algebras) > 2:  # the second level has the first one in it
        return _from_base(frames.without_accelerations(), closure, name, 2).lowered
    known = frames.seen.setdefault((first.base, level), {})
    if not known:
        known[first.base] = Pose(NOWHERE, _axes_of_base(frames, first), NOWHERE, level)
    for edge in _way(frames, name, known):
        pose = frames.follow(edge, known[edge.parent], level)
        known[edge.child] = replace(pose, axes=plain_matrix(pose.axes))  # so that a loop in a plane of its own is seen there
    found: Pose = known[name]
    return found


def _first_at(frames: Frames, closure: Closure) -> Closure:
    """Of the loops that part at one frame, the one that says how its axes are turned."""
    return next(cut for cut in frames.graph.closures if cut.base == closure.base)


def _back_of(frames: Frames, closure: Closure, level: int) -> Matrix:
    """What takes vectors in the world's axes to those of the base, as they are turned."""
    return product(_axes_of_base(frames, _first_at(frames, closure)), transposed(frames.pose(closure.base, level).axes))


def _axes_of_base(frames: Frames, closure: Closure) -> Matrix:
    """The axes of the base seen from where the loop first moves: a loop in a plane of its own keeps to two of these."""
    turned = UNIT
    for edge in _way(frames, closure.a, {closure.base: Pose(NOWHERE, UNIT, NOWHERE, 0)}):
        for step in edge.steps:
            if step.kind != "turn":
                continue
            if frames.attitude_of(step) is not None:
                return transposed(turned)
            angle, axis = frames.evaluator.value(step.amount), _axis_of(frames, step)
            if not all(isinstance(x, float | int) for x in (angle, *axis)):
                return transposed(turned)
            turned = product(turned, rotation(axis, -angle if step.is_inverse else angle, frames.algebra))
    return transposed(turned)


def _axis_of(frames: Frames, step: Step) -> Vector:
    value = frames.evaluator.value(step.axis) if step.axis is not None else None
    return unit_axis(step, value, frames.algebra)


def _way(frames: Frames, name: str, known: dict[str, Pose]) -> list[Edge]:
    """The edges to a frame from the first one ahead of it that is known."""
    way: list[Edge] = []
    while name not in known:
        way.append(frames.graph.edge_to[name])
        name = way[-1].parent
    return way[::-1]


def _quaternion(frames: Frames, base: str, name: str, steps: Sequence[Step]) -> Quaternion:
    whole = [*(step for edge in _way(frames, name, {base: Pose(NOWHERE, UNIT, NOWHERE, 0)}) for step in edge.steps), *steps]
    return quaternion_along(whole, frames.evaluator.value, 0, frames.algebra, frames.turn_by)


def _kept(frames: Frames, closure: Closure, level: int) -> Kept:
    """The coordinates that a cut joint keeps, with its axes."""
    step, value, algebra = closure.freedom, frames.evaluator.value, frames.algebra
    if step is None:
        return Kept("weld", UNIT)
    if closure.kind == "ball":
        assert isinstance(step.amount, Ref)
        name = step.amount.name
        values = tuple(frames.coordinate(part, level) for part in parts_of(name))
        return Kept("ball", UNIT, values, frames.axes_of(name), frames.quaternion(name, 0))
    if closure.kind == "hinge":
        return Kept("hinge", triad(_axis_of(frames, step), algebra), (value(step.amount, level),))
    if closure.kind == "cross":
        assert closure.ahead is not None
        return Kept("cross", (_axis_of(frames, closure.ahead), _axis_of(frames, step)),
                    (value(closure.ahead.amount, level), value(step.amount, level)))
    if closure.ahead is not None:
        axes, offset = triad(_axis_of(frames, step), algebra), way_of_shift(frames, closure.ahead, closure.ahead_kept)[0]
        along = dot([*axes[2]], [*value(closure.ahead.amount, level)])
        beside = (dot([*axes[0]], [*offset]), dot([*axes[1]], [*offset]))
        return Kept("cylinder", axes, (along, value(step.amount, level)), beside=beside)
    offset, end = way_of_shift(frames, step, closure.kept)
    way = [minus(x, y) for x, y in zip(end, offset, strict=True)]
    length = frames.evaluator.norm(tuple(way), 0)
    axes = triad(tuple(0.0 if is_zero(x) else x / length for x in way), algebra)
    along = dot([*axes[2]], [*value(step.amount, level)])
    return Kept("slider", axes, (along,), beside=(dot([*axes[0]], [*offset]), dot([*axes[1]], [*offset])))
