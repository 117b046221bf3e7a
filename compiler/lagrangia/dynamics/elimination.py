"""M a = r solved along the tree of bodies, leaf to root, without forming M: O(n) for any tree.

A rigid body is a cluster of frames joined by rigid edges; its inertia at its reference frame is taken from the Hessian of its
kinetic terms in the twist (frames/planar_inertia.py). Towards the root, for every coordinate with motion direction s:

    U = I s,   D = s . U,   I -= U U^T / D,   p += U u / D,   u = r - s . p,

then I and p move to the parent's reference frame. What I becomes is the same for every r. p begins with the forces on the body
(forces.py). Back from the root: a = (u - U . A) / D, A += s a.
Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 7.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import field
from functools import cached_property

import casadi as ca

from lagrangia.algebra.duals import Dual, Scalar, dot, is_zero, minus, plus, times
from lagrangia.algebra.scalars import scalars_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.bodies import Bodies
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.forces import Forces, find_forces
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Value
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.planar import HERE, SIZE, Pose, stays, turning
from lagrangia.frames.planar_inertia import (
    NOTHING,
    Inertia,
    Vector,
    about,
    add_inertia,
    add_moved,
    inertial_force,
    momentum,
    moved_twist,
    no_inertia,
)
from lagrangia.language.frame_attributes import COMPONENTS


@dataclass
class Cluster:
    """A rigid body. `joint` is where its reference frame sits in the parent, in world axes from the parent's reference."""

    frame: str
    parent: "Cluster | None"
    directions: list[tuple[int, Vector]]  # (index of the coordinate, s) in the order of the joint
    turn: Pose  # of the reference frame; only the angle is used
    joint: Sequence[Scalar] = HERE.origin
    inertia: list[Vector] = field(default_factory=no_inertia)  # world axes

    @property
    def is_ground(self) -> bool:
        """Whether it is fixed to the world: no parent, and no direction to move in."""
        return self.parent is None and not self.directions

    def add(self, inertia: Inertia, local: Pose) -> None:
        """That of a frame of the body, which sits here."""
        if not self.is_ground:
            add_inertia(self.inertia, inertia, local, self.turn)

    def inertial_force(self, still: Kinematics) -> Vector:
        """What the body's inertia asks for when dv/dt = 0."""
        return [*NOTHING] if self.is_ground else inertial_force(self.inertia, still.pose(self.frame, 2))


@dataclass(frozen=True)
class _Joint:
    """A coordinate, eliminated."""

    index: int
    direction: Vector  # s
    momentum: Vector  # U
    inverse: Scalar  # 1 / D
    share: Vector  # U / D


class ArticulatedBodies:
    """M, factored along the tree of bodies."""

    def __init__(self, kinematics: Kinematics, bodies: Bodies, clusters: dict[str, Cluster]) -> None:
        self.kinematics, self.bodies, self.clusters = kinematics, bodies, clusters
        self.joints: dict[str, list[_Joint]] = {}  # by the cluster they move, leaf to root
        signals = {state.coordinate for state in kinematics.graph.model.states.values()}
        self.alone = [k for k, c in enumerate(kinematics.graph.coordinates) if c.name in signals]  # of inertia 1
        reduced = self._inertias()
        for name, cluster in reversed(clusters.items()):
            self.joints[name] = [_reduce(reduced[name], index, s) for index, s in reversed(cluster.directions)]
            if cluster.parent is not None and not cluster.parent.is_ground:
                add_moved(reduced[cluster.parent.frame], reduced[name], cluster.joint)

    @property
    def size(self) -> int:
        """How many coordinates there are."""
        return len(self.kinematics.graph.coordinates)

    @property
    def masses(self) -> list[Scalar]:
        """Of the bodies, kg."""
        return [cluster.inertia[0][0] for cluster in self.clusters.values()]

    def _inertias(self) -> dict[str, list[Vector]]:
        return {name: [row[:] for row in cluster.inertia] for name, cluster in self.clusters.items()}

    @property
    def pivots(self) -> ca.SX:
        """D of each coordinate, (n,)."""
        inverse = {joint.index: joint.inverse for joints in self.joints.values() for joint in joints}
        inverse |= dict.fromkeys(self.alone, 1.0)
        return ca.vertcat(*[1 / inverse[k] for k in range(len(inverse))])

    @cached_property
    def diagonal(self) -> ca.SX:
        """Of M, (n,): s . I s with the inertia of all that the coordinate moves."""
        whole = self._inertias()
        found: dict[int, Scalar] = dict.fromkeys(self.alone, 1.0)
        for name, cluster in reversed(self.clusters.items()):
            found |= {index: dot(s, momentum(whole[name], s)) for index, s in cluster.directions}
            if cluster.parent is not None:
                add_moved(whole[cluster.parent.frame], whole[name], cluster.joint)
        return ca.vertcat(*[found[k] for k in range(len(found))])

    def solve(self, r: ca.SX) -> ca.SX:
        """The solution a (n,) of M a = r."""
        return self._solve(scalars_in(ca.densify(r)), {})

    def yield_to(self, forces: Forces) -> ca.SX:
        """The solution a (n,) of M a = -h, where h is what the forces take from the motion."""
        return self._yield_to(forces, {})

    def accelerate(self, energies: Energies) -> ca.SX | None:
        """The accelerations, as solve(-h) would give them, but with every force on the body it acts on. None where that is not
        known."""
        still = self.kinematics.without_accelerations()
        forces = find_forces(self.kinematics, energies)
        return self._yield_to(forces, {name: x.inertial_force(still) for name, x in self.clusters.items()}) if forces else None

    def _yield_to(self, forces: Forces, loads: dict[str, Vector]) -> ca.SX:
        for frame, force in forces.on_frames.items():
            home, local = self.bodies.home[frame], self.bodies.local[frame]
            ahead = self.clusters[home].turn.to_world(local.origin)
            loads[home] = _sum(loads.get(home, [*NOTHING]), about(force, ahead))
        return self._solve([minus(0.0, forces.on_coordinates.get(c.name, 0.0)) for c in self.kinematics.graph.coordinates], loads)

    def _solve(self, r: Vector, loads: dict[str, Vector]) -> ca.SX:
        p = {name: loads.get(name, [*NOTHING]) for name in self.clusters}
        left: dict[int, Scalar] = {}  # u
        for name, cluster in reversed(self.clusters.items()):
            for joint in self.joints[name]:
                left[joint.index] = minus(r[joint.index], dot(joint.direction, p[name]))
                p[name] = _passed_on(joint, p[name], r[joint.index], left[joint.index])
            parent = cluster.parent
            if parent is not None and not parent.is_ground:
                p[parent.frame] = _sum(p[parent.frame], about(p[name], cluster.joint))
        acceleration: list[Scalar] = [0.0] * len(r)
        for k in self.alone:
            acceleration[k] = r[k]
        twists: dict[str, Vector] = {}
        for name, cluster in self.clusters.items():
            twist = moved_twist(twists[cluster.parent.frame], cluster.joint) if cluster.parent else [*NOTHING]
            for joint in reversed(self.joints[name]):
                a = times(minus(left[joint.index], dot(joint.momentum, twist)), joint.inverse)
                acceleration[joint.index] = a
                twist = _sum(twist, [times(x, a) for x in joint.direction])
            twists[name] = twist
        return ca.vertcat(*acceleration)


def articulate(kinematics: Kinematics, bodies: Bodies) -> ArticulatedBodies | None:
    """None when the scene is no tree of rigid bodies: a coordinate that moves several joints, none, or no mass of its own, or a
    kinetic term that couples several bodies or is no body's."""
    clusters = _clusters(kinematics, bodies)
    try:
        return ArticulatedBodies(kinematics, bodies, clusters) if clusters is not None else None
    except ZeroDivisionError:  # D is the number 0
        return None


# -------------------------------------------------------------------- bodies


def _clusters(kinematics: Kinematics, bodies: Bodies) -> dict[str, Cluster] | None:
    """The rigid bodies with their inertias by their reference frames, parents first; None when they are no tree."""
    uses = Counter(name for edge in kinematics.graph.edges for name in edge.coordinates)
    tied = any(dependent.terms for dependent in kinematics.dependents.values())
    if bodies.rest or tied or any(count > 1 for count in uses.values()):
        return None
    clusters = _joined(kinematics, bodies)
    graph = kinematics.graph
    if sum(len(cluster.directions) for cluster in clusters.values()) < len(graph.coordinates) - len(graph.model.states):
        return None
    for inertia in bodies.inertias:
        clusters[bodies.home[inertia.frame]].add(inertia, bodies.local[inertia.frame])
    return clusters


def _joined(kinematics: Kinematics, bodies: Bodies) -> dict[str, Cluster]:
    graph = kinematics.graph
    number = {c.name: k for k, c in enumerate(graph.coordinates)}
    units = {part.name: [1.0 if i == k else 0.0 for i in range(SIZE)] for k, part in enumerate(COMPONENTS)}
    clusters: dict[str, Cluster] = {}
    for root in graph.roots:
        directions = [(number[name], units[a]) for a in root.attributes if (name := f"{root.frame}.{a}") in number]
        clusters[root.frame] = Cluster(root.frame, None, directions, kinematics.pose(root.frame, 0))
    for edge in graph.edges:
        if edge.is_rigid:
            continue
        parent, local = clusters[bodies.home[edge.parent]], bodies.local[edge.parent]
        directions = [(number[name], _direction(kinematics, edge, name)) for name in edge.coordinates if name in number]
        here = kinematics.pose(edge.parent, 0).at(parent.turn.to_world(local.origin))
        ahead = here.origin if all(map(stays, edge.steps)) else kinematics.follow(edge, here, 0).origin
        clusters[edge.child] = Cluster(edge.child, parent, directions, kinematics.pose(edge.child, 0), ahead)
    return clusters


class OneMoves:
    """Leaves of an evaluator in which a single coordinate moves, at rate 1."""

    def __init__(self, kinematics: Kinematics, mover: str) -> None:
        self.kinematics, self.mover = kinematics, mover

    def symbol(self, name: str, level: int) -> Value | None:
        """A coordinate with its rate at level 1; all else as the kinematics know it."""
        positions = self.kinematics.symbols.positions
        if name not in positions:
            return self.kinematics.symbol(name, level)
        return Dual(positions[name], 1.0 if name == self.mover else 0.0) if level else positions[name]

    def time(self, level: int) -> Scalar:
        """It stands still."""
        return self.kinematics.symbols.time

    def frame(self, name: str, attribute: str, level: int) -> Value:
        """Is not asked for."""
        raise AssertionError("a joint depends on no frame")


def _direction(kinematics: Kinematics, edge: Edge, mover: str) -> Vector:
    """Twist of the edge's child when its parent rests and one coordinate moves at rate 1."""
    evaluator = Evaluator(kinematics.graph.model, kinematics.algebra, OneMoves(kinematics, mover))
    if len(edge.steps) == 1 and stays(edge.steps[0]):
        return turning(edge.steps[0], evaluator.value(edge.steps[0].amount, 1))
    pose = kinematics.follow(edge, kinematics.pose(edge.parent, 0), 1, evaluator)
    return [*pose.twist]


# -------------------------------------------------------------------- elimination


def _reduce(I: list[Vector], index: int, s: Vector) -> _Joint:
    """Takes from the inertia what the coordinate gives way to; along an axis nothing is left."""
    U = momentum(I, s)
    inverse, axis = 1.0 / dot(s, U), _axis(s)
    share = [times(U[k], inverse) if k != axis else 0.0 for k in range(SIZE)]
    for i in range(SIZE):
        for j in range(i, SIZE):
            I[i][j] = minus(I[i][j], times(share[i], U[j])) if axis not in (i, j) else 0.0
    return _Joint(index, s, U, inverse, share)


def _passed_on(joint: _Joint, p: Vector, r: Scalar, u: Scalar) -> Vector:
    """The load that is left for what carries the joint; along an axis it is exactly what r says."""
    axis = _axis(joint.direction)
    return [r if k == axis else plus(x, times(part, u)) for k, (x, part) in enumerate(zip(p, joint.share, strict=True))]


def _axis(s: Vector) -> int | None:
    """k when s is the k-th unit vector."""
    nonzero = [k for k, x in enumerate(s) if not is_zero(x)]
    return nonzero[0] if len(nonzero) == 1 and isinstance(s[nonzero[0]], float) and s[nonzero[0]] == 1.0 else None






def _sum(a: Vector, b: Vector) -> Vector:
    return [plus(x, y) for x, y in zip(a, b, strict=True)]
