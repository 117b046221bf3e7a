"""Poses within rigid bodies: those that shifts lead to in the same way, as in alike bodies, are found together, by columns."""

from collections.abc import Sequence

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scans import each
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.frames.edges import Edge
from lagrangia.frames.geometry import Pose
from lagrangia.frames.kinematics import Kinematics

_FEWEST = 24  # edges: fewer are as soon followed one by one


def follow_rigid(kinematics: Kinematics, edges: Sequence[Edge], poses: dict[str, Pose]) -> None:
    """Adds the poses behind edges that never move, parents first, to those where bodies begin. Raises LagError."""
    has_columns = isinstance(kinematics.algebra, CasadiAlgebra) and not kinematics.graph.model.space.is_spatial
    for wave in _waves(edges) if has_columns else [edges]:
        groups: dict[tuple[bool, ...], list[Edge]] = {}
        for edge in wave if has_columns else ():
            if all(step.kind == "shift" for step in edge.steps):
                groups.setdefault(tuple([step.is_inverse for step in edge.steps]), []).append(edge)
        many = [group for group in groups.values() if len(group) >= _FEWEST]
        for group in many:
            _shift_together(kinematics, group, poses)
        for edge in wave:
            if not many or edge.child not in poses:
                poses[edge.child] = kinematics.follow(edge, poses[edge.parent], 0)


def _waves(edges: Sequence[Edge]) -> list[list[Edge]]:
    """By how many edges lie before each in its body."""
    found: list[list[Edge]] = []
    depth: dict[str, int] = {}
    for edge in edges:
        k = depth.get(edge.parent, 0)
        depth[edge.child] = k + 1
        if k == len(found):
            found.append([])
        found[k].append(edge)
    return found


def _shift_together(kinematics: Kinematics, edges: Sequence[Edge], poses: dict[str, Pose]) -> None:
    """Of edges whose steps go the same ways."""
    kind = type(kinematics.geometry.here)
    steps, names = edges[0].steps, kind.__match_args__
    rows = [[getattr(poses[edge.parent], name) for name in names]
            + [x for step in edge.steps for x in kinematics.amount_of(step, 0)] for edge in edges]
    size, width = len(names), (len(rows[0]) - len(names)) // len(steps) if steps else 0

    def work(values: list[Scalar]) -> list[Scalar]:
        pose = kind(*values[:size])
        for k, step in enumerate(steps):
            pose = kinematics.along(step, tuple(values[size + width * k : size + width * (k + 1)]), pose, 0)
        return [getattr(pose, name) for name in names]

    poses.update((edge.child, kind(*row)) for edge, row in zip(edges, each(work, rows), strict=True))
