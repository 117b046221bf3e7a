"""What the elimination along a tree in space leaves out, since axes, centres and moments of inertia are as they are.

Each saving is counted: the same tree is built once more with parameters in the place of the numbers that make products fall away.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import cached_property

import casadi as ca

from lagrangia.algebra.duals import Scalar, is_zero
from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.dynamics.along_tree import articulate
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.spatial_axes import SpatialJoint
from lagrangia.dynamics.spatial_drift import Link
from lagrangia.dynamics.spatial_tree import SpatialBodies
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.spatial_inertia import RigidInertia, Shift, Turn

_ALONG_TREE = ("tree", "constrained along the tree")


@dataclass(frozen=True)
class Skipped:
    """`needing` are joints, by coordinate and place, that need what the others, of `count` in all, do not."""

    what: str
    otherwise: str  # how those are that do not need it
    needing: tuple[tuple[str, Span | None], ...]
    count: int
    operations: tuple[int, int]  # as it is, and with parameters in place of the numbers


@dataclass(frozen=True)
class _Tree:
    bodies: SpatialBodies
    energies: Energies
    count: Callable[[ca.SX], int]

    @cached_property
    def operations(self) -> int:
        """Of the accelerations along the tree as it is."""
        return self._of(self.bodies)

    def with_joints(self, change: Callable[[SpatialJoint], SpatialJoint]) -> tuple[int, int]:
        """Operations as it is, and with other joints."""
        old = self.bodies
        return self.operations, self._of(SpatialBodies(old.kinematics, old.bodies, [*map(change, old.joints)], old.places))

    def _of(self, bodies: SpatialBodies) -> int:
        found = bodies.accelerate(self.energies)
        assert found is not None
        return self.count(found)

    @property
    def hinges(self) -> list[tuple[SpatialJoint, Link]]:
        """That turn about an axis, with their links."""
        return [(joint, link) for joint, link in zip(self.bodies.joints, self.bodies.tree.links, strict=True)
                if joint.kind == "turn"]

    @property
    def carried(self) -> list[tuple[SpatialJoint, RigidInertia]]:
        """Joints whose frames have bodies, and these in the axes of their links."""
        pairs = zip(self.bodies.joints, self.bodies.seats, strict=True)
        own = [(joint, seat.turned(seat.steady(joint.body))) for joint, seat in pairs]
        return [(joint, body) for joint, body in own if body is not None]

    def named(self, joint: SpatialJoint) -> tuple[str, Span | None]:
        """By its coordinate; one without has the name of none."""
        if not joint.coordinates:
            return "what time moves", None
        coordinate = self.bodies.kinematics.graph.coordinates[joint.coordinates[0]]
        name, _, part = coordinate.name.rpartition(".")
        return (name if part.startswith("s[") else coordinate.name), coordinate.span


def skipped_along_axes(kinematics: Kinematics, energies: Energies, motion: Motion,
                       count: Callable[[ca.SX], int]) -> Iterator[Skipped]:
    """Of scenes in space whose accelerations come along the tree; `count`: operations of them."""
    if not kinematics.geometry.by_rates or motion.way not in _ALONG_TREE:
        return
    found = articulate(kinematics, motion.bodies)
    if not isinstance(found, SpatialBodies) or found.accelerate(energies) is None:
        return
    tree = _Tree(found, energies, count)
    if tree.hinges:
        tilted = [joint for joint, link in tree.hinges if any(map(_is_oblique, link.moves))]
        yield Skipped("tilted axes", "parallel to the axis before it, or at right angles whatever the parameters",
                      _names(tree, tilted), len(tree.hinges), tree.with_joints(_with_any_axis))
    inner = [(j, link) for j, link in zip(found.joints, found.tree.links, strict=True) if j.kind != "shift"]
    apart = [joint for joint, link in inner if any(isinstance(m, Shift) and not all(map(is_zero, m.ahead)) for m in link.moves)]
    yield Skipped("offsets of joints", "without a distance across or along the axis before", _names(tree, apart), len(inner),
                  tree.with_joints(_with_any_place))
    outside = [joint for joint, body in tree.carried if not all(map(is_zero, _across(joint, body.moment)))]
    yield Skipped("centres beside axes", "with the centre of mass on the axis of a hinge, or where a ball is",
                  _names(tree, outside), len(tree.carried), tree.with_joints(_with_any_centre))
    mixed = [joint for joint, body in tree.carried
             if not all(is_zero(body.second_moment[i][j]) for i, j in ((0, 1), (1, 2), (0, 2)))]
    yield Skipped("products of inertia", "with the axes of the joint as principal axes", _names(tree, mixed), len(tree.carried),
                  tree.with_joints(_with_any_products))
    uneven = [joint for joint, body in tree.carried if not _is_same(body.second_moment[0][0], body.second_moment[1][1])]
    yield Skipped("unequal moments", "symmetric about the axis of the joint whatever the parameters", _names(tree, uneven),
                  len(tree.carried), tree.with_joints(_with_any_moments))


def _names(tree: _Tree, joints: Sequence[SpatialJoint]) -> tuple[tuple[str, Span | None], ...]:
    return tuple(dict.fromkeys(map(tree.named, joints)))


def _is_oblique(move: object) -> bool:
    """A turn about x or y that leads to an axis by another angle than a right one."""
    if not isinstance(move, Turn) or move.axis == 2:
        return False
    return not all(isinstance(x, float) and x in (0.0, 1.0, -1.0) for x in (move.c, move.s))


def _is_same(a: Scalar, b: Scalar) -> bool:
    """Whether they are one number, or one parameter."""
    return bool(ca.is_equal(ca.SX(a), ca.SX(b)))


def _across(joint: SpatialJoint, moment: Sequence[Scalar]) -> Sequence[Scalar]:
    """The components that are not along a hinge."""
    return moment[:2] if joint.kind == "turn" else moment


# -------------------------------------------------------------------- parameters in place of numbers


def _vector() -> list[Scalar]:
    return [*ca.vertsplit(ca.SX.sym("any", 3))]


def _with_any_axis(joint: SpatialJoint) -> SpatialJoint:
    return replace(joint, axis=_vector()) if joint.kind == "turn" else joint


def _with_any_place(joint: SpatialJoint) -> SpatialJoint:
    return joint if joint.kind == "shift" else replace(joint, origin=_vector())


def _with_any_centre(joint: SpatialJoint) -> SpatialJoint:
    return joint if joint.body is None else replace(joint, body=replace(joint.body, moment=_vector()))


def _with_any_products(joint: SpatialJoint) -> SpatialJoint:
    if joint.body is None:
        return joint
    J, (d, e, f) = joint.body.second_moment, _vector()
    return replace(joint, body=replace(joint.body, second_moment=((J[0][0], d, e), (d, J[1][1], f), (e, f, J[2][2]))))


def _with_any_moments(joint: SpatialJoint) -> SpatialJoint:
    if joint.body is None:
        return joint
    rows = [[*row] for row in joint.body.second_moment]
    for k, x in enumerate(_vector()):
        rows[k][k] = x
    return replace(joint, body=replace(joint.body, second_moment=rows))
