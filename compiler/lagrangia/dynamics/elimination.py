"""M a = r solved along the tree of bodies, leaf to root, without forming M: O(n) for any tree.

A rigid body is a cluster of frames joined by rigid edges; its inertia at its reference frame is taken from the Hessian of its
kinetic terms in the twist (frames/planar_inertia.py). Towards the root, for every coordinate with motion direction s:

    U = I s,   D = s . U,   I -= U U^T / D,   p += U u / D,   u = r - s . p,

then I and p move to the parent's reference frame. What I becomes is the same for every r. p begins with the forces on the body
(forces.py). Back from the root: a = (u - U . A) / D, A += s a.
Source: Featherstone, Rigid Body Dynamics Algorithms (2008), chapter 7.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import field
from functools import cached_property, partial
from itertools import pairwise, zip_longest

import casadi as ca

from lagrangia.algebra.duals import Dual, Scalar, added, dot, is_zero, minus, plus, times
from lagrangia.algebra.scalars import column, scalars_in
from lagrangia.algebra.scans import each, scan
from lagrangia.base.records import dataclass
from lagrangia.dynamics.bodies import Bodies
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.forces import Forces, find_forces
from lagrangia.dynamics.loops_in_tree import Carrier, Granted
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Value
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.planar import HERE, SIZE, Pose, stays, turning
from lagrangia.frames.planar_inertia import (
    NOTHING,
    PLACE,
    UPPER,
    Inertia,
    Vector,
    about,
    add_moved,
    add_upper,
    from_upper,
    inertial_force,
    momentum,
    motion_numbers,
    moved_inertia,
    moved_twist,
    no_inertia,
    upper,
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
        self.ways = _ways(clusters)
        reduced = self._inertias()
        for way in self.ways:
            inputs = [[*(x for _, s in cluster.directions for x in s), *cluster.joint, *upper(reduced[ahead.frame])]
                      for cluster, ahead in pairwise(way)]
            last, found = scan(_give_way, upper(reduced[way[0].frame]), inputs)
            for cluster, values in zip(way, found, strict=False):
                parts = (values[k : k + 2 * SIZE + 1] for k in range(0, len(values), 2 * SIZE + 1))
                self.joints[cluster.frame] = [
                    _Joint(index, s, part[:SIZE], part[SIZE], part[SIZE + 1 :])
                    for (index, s), part in zip(reversed(cluster.directions), parts, strict=True)]
            I, end = from_upper(last), way[-1]
            self.joints[end.frame] = [_reduce(I, index, s) for index, s in reversed(end.directions)]
            if end.parent is not None and not end.parent.is_ground:
                add_moved(reduced[end.parent.frame], I, end.joint)

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
        if forces is None:
            return None
        moving = {name: x for name, x in self.clusters.items() if not x.is_ground}
        rows = [[*upper(x.inertia), *motion_numbers(still.pose(name, 2))] for name, x in moving.items()]
        return self._yield_to(forces, dict(zip(moving, each(_inertial_force, rows), strict=True)))

    def carriers(self) -> list[Carrier]:
        """The bodies that move."""
        place = {name: k for k, name in enumerate(self._moving)}
        found = []
        for name in self._moving:
            cluster = self.clusters[name]
            parent = None if cluster.parent is None else place.get(cluster.parent.frame)
            found.append(Carrier(parent, cluster.directions, cluster.inertia, partial(_inertia_ahead, cluster.joint),
                                 partial(_wrench_ahead, cluster.joint), partial(_twist_behind, cluster.joint)))
        return found

    def on_carriers(self, forces: Forces) -> tuple[dict[int, Vector], bool]:
        """The wrenches on bodies, and whether the ground is held, too."""
        place, found = {name: k for k, name in enumerate(self._moving)}, dict[int, Vector]()
        is_held = False
        for frame, force in forces.on_frames.items():
            k = place.get(home := self.bodies.home[frame])
            is_held |= k is None
            if k is None:
                continue
            load = _about_reference([*_ahead(self.clusters[home].turn, self.bodies.local[frame]), *force])
            found[k] = added(found.get(k, [*NOTHING]), load)
        return found, is_held

    def granted(self, energies: Energies) -> Granted | None:
        """What acts where bodies are accelerated as the rates alone do; None where that is not known."""
        forces = find_forces(self.kinematics, energies)
        if forces is None:
            return None
        still, (loads, _) = self.kinematics.without_accelerations(), self.on_carriers(forces)
        for k, name in enumerate(self._moving):
            own = _inertial_force([*upper(self.clusters[name].inertia), *motion_numbers(still.pose(name, 2))])
            loads[k] = added(loads.get(k, [*NOTHING]), own)
        r = [minus(0.0, forces.on_coordinates.get(c.name, 0.0)) for c in self.kinematics.graph.coordinates]
        return Granted(loads, r)

    @cached_property
    def _moving(self) -> list[str]:
        return [name for name, cluster in self.clusters.items() if not cluster.is_ground]

    def _yield_to(self, forces: Forces, loads: dict[str, Vector]) -> ca.SX:
        homes = [self.bodies.home[frame] for frame in forces.on_frames]
        rows = [[*_ahead(self.clusters[home].turn, self.bodies.local[frame]), *force]
                for home, (frame, force) in zip(homes, forces.on_frames.items(), strict=True)]
        _add_loads(loads, homes, each(_about_reference, rows))
        return self._solve([minus(0.0, forces.on_coordinates.get(c.name, 0.0)) for c in self.kinematics.graph.coordinates], loads)

    def _solve(self, r: Vector, loads: dict[str, Vector]) -> ca.SX:
        left = self._left(r, {name: loads.get(name, [*NOTHING]) for name in self.clusters})
        acceleration: list[Scalar] = [0.0] * len(r)
        for k in self.alone:
            acceleration[k] = r[k]
        twists: dict[str, Vector] = {}
        for way in reversed(self.ways):
            first = way[-1]
            twist = twists[first.parent.frame] if first.parent else [*NOTHING]
            joints = [self.joints[cluster.frame][::-1] for cluster in reversed(way)]
            inputs = [[*cluster.joint, *(x for j in own for x in (*j.direction, *j.momentum, left[j.index], j.inverse))]
                      for cluster, own in zip(reversed(way), joints, strict=True)]
            twists[way[0].frame], found = scan(_follow, twist, inputs)
            for own, values in zip(joints, found, strict=True):
                for joint, a in zip(own, values, strict=True):
                    acceleration[joint.index] = a
        return column(*acceleration)

    def _left(self, r: Vector, p: dict[str, Vector]) -> dict[int, Scalar]:
        """u by the places of coordinates, of forces r and loads p, which are passed on."""
        left: dict[int, Scalar] = {}
        for way in self.ways:
            inputs = [[*(x for j in self.joints[cluster.frame] for x in (*j.direction, *j.share, r[j.index])), *cluster.joint,
                       *(p[ahead.frame] if ahead is not None else NOTHING)] for cluster, ahead in zip_longest(way, way[1:])]
            last, found = scan(_pass_on, p[way[0].frame], inputs)
            for cluster, values in zip(way, found, strict=True):
                left |= {joint.index: u for joint, u in zip(self.joints[cluster.frame], values, strict=True)}
            parent = way[-1].parent
            if parent is not None and not parent.is_ground:
                p[parent.frame] = added(p[parent.frame], last)
        return left


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
    found = [(clusters[bodies.home[x.frame]], x, bodies.local[x.frame]) for x in bodies.inertias]
    moving = [(cluster, x, local) for cluster, x, local in found if not cluster.is_ground]
    rows = [[x.mass, x.moment_x, x.moment_y, x.second_moment, *local.axis, *_ahead(cluster.turn, local)]
            for cluster, x, local in moving]
    for (cluster, _, _), values in zip(moving, each(_moved_inertia, rows), strict=True):
        add_upper(cluster.inertia, values)
    return clusters


def _joined(kinematics: Kinematics, bodies: Bodies) -> dict[str, Cluster]:
    graph = kinematics.graph
    number = {c.name: k for k, c in enumerate(graph.coordinates)}
    units = {part.name: [1.0 if i == k else 0.0 for i in range(SIZE)] for k, part in enumerate(COMPONENTS)}
    clusters: dict[str, Cluster] = {}
    for root in graph.roots:
        directions = [(number[name], units[a]) for a in root.attributes if (name := f"{root.frame}.{a}") in number]
        clusters[root.frame] = Cluster(root.frame, None, directions, kinematics.pose(root.frame, 0))
    moving = [edge for edge in graph.edges if not edge.is_rigid]
    rows = [_ahead(kinematics.pose(bodies.home[edge.parent], 0), bodies.local[edge.parent]) for edge in moving]
    for edge, ahead in zip(moving, each(_turned, rows), strict=True):
        directions = [(number[name], _direction(kinematics, edge, name)) for name in edge.coordinates if name in number]
        place: Sequence[Scalar] = ahead
        if not all(map(stays, edge.steps)):
            place = kinematics.follow(edge, kinematics.pose(edge.parent, 0).at(ahead), 0).origin
        parent = clusters[bodies.home[edge.parent]]
        clusters[edge.child] = Cluster(edge.child, parent, directions, kinematics.pose(edge.child, 0), place)
    return clusters


# Of one body, by numbers: see `each` of algebra/scans.py.


def _ahead(turn: Pose, local: Pose) -> Vector:
    """What tells, in the world's axes, where a frame sits in a body."""
    return [*turn.axis, *local.origin]


def _turned(ahead: Vector) -> Vector:
    cos, sin, *place = ahead
    return [*HERE.with_axis(cos, sin).to_world(place)]


def _moved_inertia(values: Vector) -> Vector:
    m, moment_x, moment_y, second, cos, sin, turn_cos, turn_sin, *place = values
    return moved_inertia(Inertia("", m, moment_x, moment_y, second), HERE.at(place).with_axis(cos, sin),
                         HERE.with_axis(turn_cos, turn_sin))


def _inertial_force(values: Vector) -> Vector:
    return inertial_force(from_upper(values[:UPPER]), values[UPPER:])


def _about_reference(values: Vector) -> Vector:
    return about(values[-SIZE:], _turned(values[:-SIZE]))


def _add_loads(loads: dict[str, Vector], homes: Sequence[str], wrenches: Sequence[Vector]) -> None:
    """One after the other; those that are the first of their bodies together, then the second ones."""
    turns: list[dict[str, Vector]] = []
    count: Counter[str] = Counter()
    for home, wrench in zip(homes, wrenches, strict=True):
        if count[home] == len(turns):
            turns.append({})
        turns[count[home]][home] = wrench
        count[home] += 1
    for turn in turns:
        sums = each(_halves_added, [[*loads.get(home, NOTHING), *wrench] for home, wrench in turn.items()])
        loads.update(zip(turn, sums, strict=True))


def _inertia_ahead(joint: Sequence[Scalar], I: list[Vector]) -> list[Vector]:
    found = no_inertia()
    add_moved(found, I, joint)
    return found


def _wrench_ahead(joint: Sequence[Scalar], wrench: Vector) -> Vector:
    return about(wrench, joint)


def _twist_behind(joint: Sequence[Scalar], twist: Vector) -> Vector:
    return moved_twist(twist, joint)


def _halves_added(values: Vector) -> Vector:
    return added(values[:SIZE], values[SIZE:])


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
    if len(edge.steps) == 1 and stays(edge.steps[0]) and not kinematics.geometry.by_poses:
        return turning(edge.steps[0], evaluator.value(edge.steps[0].amount, 1))
    pose = kinematics.follow(edge, kinematics.pose(edge.parent, 0), 1, evaluator)
    return [*pose.twist]


# -------------------------------------------------------------------- elimination


def _ways(clusters: Mapping[str, Cluster]) -> list[list[Cluster]]:
    """The bodies in rows, each towards the root of the tree: all but the first carry the one before, and no other. What hangs on
    the first of a row has rows of its own, before it."""
    carried = Counter(cluster.parent.frame for cluster in clusters.values() if cluster.parent is not None)
    found: list[list[Cluster]] = []
    done: set[str] = set()
    for cluster in reversed([*clusters.values()]):
        if cluster.frame not in done:
            way = [cluster]
            while (ahead := way[-1].parent) is not None and carried[ahead.frame] == 1 and not ahead.is_ground:
                way.append(ahead)
            done |= {member.frame for member in way}
            found.append(way)
    return found


# Steps of recursions (algebra/scans.py): what is handed on, and the inputs of a body.


def _give_way(state: Vector, inputs: Vector) -> tuple[Vector, Vector]:
    """Of an inertia, to that of the body ahead: U, 1/D and U/D of each coordinate. Inputs: the directions, where the body sits in
    the one ahead, and its inertia."""
    I, ahead = from_upper(state), from_upper(inputs[-UPPER:])
    place = inputs[-UPPER - PLACE : -UPPER]
    directions = [inputs[k : k + SIZE] for k in range(0, len(inputs) - UPPER - PLACE, SIZE)]
    joints = [_reduce(I, 0, s) for s in reversed(directions)]
    add_moved(ahead, I, place)
    return upper(ahead), [x for joint in joints for x in (*joint.momentum, joint.inverse, *joint.share)]


def _pass_on(state: Vector, inputs: Vector) -> tuple[Vector, Vector]:
    """Of a load, to that of the body ahead: u of each coordinate. Inputs: directions, U/D and r of these, where the body sits in
    the one ahead, and what acts on that."""
    p, left = state, list[Scalar]()
    own, place, more = inputs[: -SIZE - PLACE], inputs[-SIZE - PLACE : -SIZE], inputs[-SIZE:]
    for k in range(0, len(own), 2 * SIZE + 1):
        s, share, r = own[k : k + SIZE], own[k + SIZE : k + 2 * SIZE], own[k + 2 * SIZE]
        left.append(minus(r, dot(s, p)))
        p = _passed_on(s, share, p, r, left[-1])
    return added(more, about(p, place)), left


def _follow(state: Vector, inputs: Vector) -> tuple[Vector, Vector]:
    """Of a twist, to that of a body behind: the accelerations of its coordinates. Inputs: where it sits in the one before it,
    directions, U, u and 1/D of these."""
    twist, found = moved_twist(state, inputs[:PLACE]), list[Scalar]()
    for k in range(PLACE, len(inputs), 2 * SIZE + 2):
        s, U, (u, inverse) = inputs[k : k + SIZE], inputs[k + SIZE : k + 2 * SIZE], inputs[k + 2 * SIZE : k + 2 * SIZE + 2]
        a = times(minus(u, dot(U, twist)), inverse)
        found.append(a)
        twist = added(twist, [times(x, a) for x in s])
    return twist, found


def _reduce(I: list[Vector], index: int, s: Vector) -> _Joint:
    """Takes from the inertia what the coordinate gives way to; along an axis nothing is left."""
    U = momentum(I, s)
    inverse, axis = 1.0 / dot(s, U), _axis(s)
    share = [times(U[k], inverse) if k != axis else 0.0 for k in range(SIZE)]
    for i in range(SIZE):
        for j in range(i, SIZE):
            I[i][j] = minus(I[i][j], times(share[i], U[j])) if axis not in (i, j) else 0.0
    return _Joint(index, s, U, inverse, share)


def _passed_on(s: Vector, share: Vector, p: Vector, r: Scalar, u: Scalar) -> Vector:
    """The load that is left for what carries the joint; along an axis it is exactly what r says."""
    axis = _axis(s)
    return [r if k == axis else plus(x, times(part, u)) for k, (x, part) in enumerate(zip(p, share, strict=True))]


def _axis(s: Vector) -> int | None:
    """k when s is the k-th unit vector."""
    nonzero = [k for k, x in enumerate(s) if not is_zero(x)]
    return nonzero[0] if len(nonzero) == 1 and isinstance(s[nonzero[0]], float) and s[nonzero[0]] == 1.0 else None
