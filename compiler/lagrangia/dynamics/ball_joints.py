"""What holds two points of bodies in space together, along the axes of one of them (constraints/held_points.py)."""

from collections.abc import Mapping

from lagrangia.algebra.duals import Scalar, dot, plus
from lagrangia.constraints.held_points import HeldPoints
from lagrangia.dynamics.loops_in_tree import Ball, Granted, Vector
from lagrangia.dynamics.spatial_drift import STILL
from lagrangia.dynamics.spatial_tree import SpatialBodies
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.spatial_inertia import SAME, SIZE, carried, scaled, transposed


def ball_at(kinematics: Kinematics, tree: SpatialBodies, points: HeldPoints, acting: Granted) -> Ball | None:
    """None where one is in the world, or both are of one body."""
    ends, signs = (points.own, points.other), (-points.sign, points.sign)
    places = [k for frame in ends if (k := tree.own_load(frame, [0.0] * SIZE)[0]) is not None]
    if len(set(places)) < len(ends):
        return None
    axes, at = kinematics.pose(points.own, 0).axes, dict(zip(places, map(tree.point, ends), strict=True))
    wrenches = []
    for unit, along in zip(SAME, transposed(axes), strict=True):
        own = tree.own_load(points.own, [*scaled(signs[0], unit), *STILL])[1]
        wrenches.append({places[0]: own, places[1]: tree.load(points.other, [*scaled(signs[1], along), *STILL])[1]})
    return Ball(points.rows, axes, wrenches, [_bias(wrench, at, acting) for wrench in wrenches])


def _bias(wrenches: Mapping[int, Vector], points: Mapping[int, Vector], acting: Granted) -> Scalar:
    """What the rate of a row's rate is without accelerations of coordinates."""
    found: Scalar = 0.0
    for k, wrench in wrenches.items():
        inwards = carried(acting.w[k], STILL, points[k])
        found = plus(found, plus(dot(wrench, acting.accelerations[k]), dot(wrench[:3], inwards)))
    return found
