"""What a frame is, in the plane or in space, behind one set of functions: planar.py and planar_inertia.py, spatial.py and
spatial_bodies.py; in_plane.py of what lies in a plane of space."""

from collections.abc import Callable
from dataclasses import replace
from typing import Any, TypeAlias

from lagrangia.base.records import dataclass
from lagrangia.frames import in_plane, planar, planar_inertia, spatial, spatial_bodies
from lagrangia.frames.planar_joints import unit_load
from lagrangia.frames.planes import NoPlane, Plane
from lagrangia.language.frame_attributes import Space

Pose: TypeAlias = Any  # planar.Pose or spatial.Pose, which have lowered, twist, origin, to_world, at, moved, displaced
Inertia: TypeAlias = Any


@dataclass(frozen=True)
class Geometry:
    """Functions of poses and inertias; `size` is that of a twist and of a wrench.

    `by_rates`: what bodies ask for works on their twists, not on their places; `by_poses`: displacements are those of poses, and
    add to no numbers of attributes.
    """

    size: int
    here: Pose  # of a frame, seen from itself
    attribute_of: Callable[[Pose, str], Any]
    picked: Callable[..., Any]
    root_pose: Callable[..., Pose]  # of a place, numbers, an algebra and a level
    step: Callable[..., Pose]  # of a pose, a step, its amount, its axis, an algebra
    free_body: Callable[[], Any]
    unlike_a_body: Callable[..., Any]
    inertias: Callable[..., list[Inertia]]
    wrench_about: Callable[..., Any]
    unit_load: Callable[..., Any]
    by_rates: bool
    by_poses: bool


_PLANE = Geometry(
    planar.SIZE, planar.HERE, planar.attribute_of, planar.picked,
    lambda place, number, algebra, level: planar.root_pose(place, number, algebra),
    lambda pose, step, amount, axis, algebra: planar.step(pose, step, amount, algebra),
    planar_inertia.FreeBody, planar_inertia.unlike_a_body, planar_inertia.inertias, planar_inertia.wrench_about, unit_load,
    by_rates=False, by_poses=False)
_SPACE = Geometry(
    spatial.SIZE, spatial.HERE, spatial.attribute_of, spatial.picked, spatial.root_pose, spatial.step,
    spatial_bodies.FreeBody, spatial_bodies.unlike_a_body, spatial_bodies.inertias, spatial_bodies.wrench_about,
    spatial_bodies.unit_load, by_rates=True, by_poses=True)


def geometry_of(space: Space, plane: Plane | NoPlane | None = None) -> Geometry:
    """That of the plane, or of space; there of what lies in a plane, where there is one."""
    if isinstance(plane, Plane):
        return _in(plane)
    return _SPACE if space.is_spatial else _PLANE


def _in(plane: Plane) -> Geometry:
    return replace(
        _PLANE, here=in_plane.here(plane), attribute_of=in_plane.attribute_of, picked=spatial.picked, step=in_plane.step,
        root_pose=lambda place, number, algebra, level: in_plane.root_pose(plane, number),
        free_body=lambda: in_plane.FreeBody(plane), by_poses=True)


def inertial_reaction(inertia: Inertia, place: Pose, pose: Pose, geometry: Geometry) -> list[tuple[Any, Any]]:
    """What moves a body's frame, number by number, beside what its inertia asks for: a place or a twist, and a wrench. `place`:
    its pose; `pose`: at level 2, with its rates and their rates."""
    if not geometry.by_rates:
        return planar_inertia.inertial_reaction(inertia, place, pose)
    return list(zip(pose.lowered.twist, spatial_bodies.inertial_wrench(inertia, pose), strict=True))
