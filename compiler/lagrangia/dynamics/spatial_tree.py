"""A scene in space as a tree of joints and rigid bodies, solved along the tree (spatial_elimination.py).

Every step of an edge that moves is a joint; what stands between two of them is a constant pose. A potential that is a uniform
field for every body, as weight is, is an acceleration of the world instead of forces on bodies.
"""

from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace

import casadi as ca

from lagrangia.algebra.duals import Dual, Scalar, added, base_of, dot, is_zero, minus, plus, rate_of, times, value_of
from lagrangia.algebra.scalars import scalars_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.bodies import Bodies
from lagrangia.dynamics.elimination import OneMoves
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.forces import Forces, find_forces
from lagrangia.dynamics.loops_in_tree import Carrier, Granted
from lagrangia.dynamics.spatial_axes import SpatialJoint, lay_axes
from lagrangia.dynamics.spatial_drift import STILL, Drift, drift_of
from lagrangia.dynamics.spatial_elimination import SpatialTree
from lagrangia.frames.attitude_starts import FLOATING
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Value, scalars_of
from lagrangia.frames.geometry import Pose
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.spatial import unit_axis
from lagrangia.frames.spatial_inertia import (
    SAME,
    Matrix,
    RigidInertia,
    Vector,
    composed,
    cross,
    is_nothing,
    no_inertia,
    product,
    transposed,
)
from lagrangia.language.attitudes import parts_of
from lagrangia.language.frame_steps import Step

_COORDINATES = "xyz"
_SAME_FIELD = 1e-12  # of a force, what may be left of it


@dataclass(frozen=True)
class _Place:
    """Of a frame behind a joint, or in the world: in the joint's frame."""

    joint: int | None
    R: Matrix = SAME
    origin: Sequence[Scalar] = STILL

    def followed(self, R: Matrix, origin: Sequence[Scalar]) -> "_Place":
        """By a constant pose."""
        return _Place(self.joint, composed(self.R, R), added(self.origin, product(self.R, origin)))


class SpatialBodies:
    """M, factored along the tree of bodies."""

    def __init__(self, kinematics: Kinematics, bodies: Bodies, joints: Sequence[SpatialJoint],
                 places: Mapping[str, _Place]) -> None:
        self.kinematics, self.bodies, self.joints, self.places = kinematics, bodies, joints, places
        links, self.seats = lay_axes(joints)
        self.tree = SpatialTree(links, self.size)

    @property
    def size(self) -> int:
        """How many coordinates there are."""
        return len(self.kinematics.graph.coordinates)

    @property
    def masses(self) -> list[Scalar]:
        """Of the bodies, kg."""
        return [joint.body.mass for joint in self.joints if joint.body is not None and not joint.body.is_nothing]

    @property
    def pivots(self) -> ca.SX:
        """D of each coordinate, (n,)."""
        return ca.vertcat(*self.tree.pivots)

    @property
    def diagonal(self) -> ca.SX:
        """Of M, (n,)."""
        return ca.vertcat(*self.tree.diagonal)

    def solve(self, r: ca.SX) -> ca.SX:
        """The solution a (n,) of M a = r."""
        return ca.vertcat(*self.tree.solve(scalars_in(ca.densify(r)), {}))

    def yield_to(self, forces: Forces) -> ca.SX:
        """The solution a (n,) of M a = -h, where h is what the forces take from the motion."""
        return self._yield_to(forces, None, STILL)

    def accelerate(self, energies: Energies) -> ca.SX | None:
        """The accelerations, as solve(-h) would give them, but with every force on the body it acts on. None where that is not
        known."""
        forces = find_forces(self.kinematics, energies)
        if forces is None:
            return None
        field, forces = self._without_field(forces)
        drift = drift_of(self.tree.links)
        return self._yield_to(forces, drift, [minus(0.0, x) for x in field])

    def granted(self, energies: Energies) -> Granted | None:
        """What acts where bodies are accelerated as the rates alone do; None where that is not known."""
        forces = find_forces(self.kinematics, energies)
        if forces is None:
            return None
        field, forces = self._without_field(forces)
        drift = drift_of(self.tree.links, [minus(0.0, x) for x in field])
        loads = self.tree.bias_loads(drift)
        for joint, load in self.on_carriers(forces)[0].items():
            loads[joint] = added(loads.get(joint, [0.0] * 6), load)
        return Granted(loads, self._on_coordinates(forces), drift.w, drift.granted)

    def field(self, energies: Energies) -> tuple[Sequence[Scalar], Forces | None]:
        """The acceleration with which all bodies fall, (3,), and the forces beside it; None where these have no place."""
        forces = find_forces(self.kinematics, energies)
        return (STILL, None) if forces is None else self._without_field(forces)

    def _yield_to(self, forces: Forces, drift: Drift | None, base: Sequence[Scalar]) -> ca.SX:
        return ca.vertcat(*self.tree.solve(self._on_coordinates(forces), self.on_carriers(forces)[0], drift, base))

    def _on_coordinates(self, forces: Forces) -> Vector:
        """r, (n,)."""
        return [minus(0.0, forces.on_coordinates.get(c.name, 0.0)) for c in self.kinematics.graph.coordinates]

    def carriers(self) -> list[Carrier]:
        """The links."""
        bodies = [link.body.matrix() if link.body is not None else no_inertia() for link in self.tree.links]
        return [Carrier(link.parent, link.directions, body, link.inertia_to_parent, link.wrench_to_parent, link.twist_to_child)
                for link, body in zip(self.tree.links, bodies, strict=True)]

    def on_carriers(self, forces: Forces) -> tuple[dict[int, Vector], bool]:
        """The wrenches on links, and whether the world is held, too."""
        found: dict[int, Vector] = {}
        is_held = False
        for frame, wrench in forces.on_frames.items():
            joint, load = self.load(frame, wrench)
            is_held |= joint is None
            if joint is not None:
                found[joint] = added(found.get(joint, [0.0] * 6), load)
        return found, is_held

    def load(self, frame: str, wrench: Sequence[Scalar]) -> tuple[int | None, Vector]:
        """A wrench along the world's axes, on the link that the frame is fixed to, in its axes."""
        if self.places[self.bodies.home[frame]].joint is None:
            return None, []
        back = transposed(self.kinematics.pose(frame, 0).axes)
        return self.own_load(frame, [*product(back, wrench[:3]), *product(back, wrench[3:])])

    def own_load(self, frame: str, wrench: Sequence[Scalar]) -> tuple[int | None, Vector]:
        """A wrench along the frame's own axes, on the link that the frame is fixed to, in that one's axes."""
        local, place = self.bodies.local[frame], self.places[self.bodies.home[frame]]
        if place.joint is None:
            return None, []
        joint, place = place.joint, place.followed(local.axes, local.origin)
        seat = self.seats[joint]
        force, torque = (product(place.R, part) for part in (wrench[:3], wrench[3:]))
        torque = added(torque, cross(place.origin, force))
        force, torque = product(seat.G, force), product(seat.G, torque)
        torque = added(torque, cross(seat.origin, force))
        return joint, [*seat.turn.to_parent(force), *seat.turn.to_parent(torque)]

    def point(self, frame: str) -> Vector:
        """Where the origin of a frame is that is fixed to a link, in that one's axes, (3,)."""
        local, place = self.bodies.local[frame], self.places[self.bodies.home[frame]]
        assert place.joint is not None
        seat = self.seats[place.joint]
        place = place.followed(local.axes, local.origin)
        return seat.turn.to_parent(added(seat.origin, product(seat.G, place.origin)))

    # ------------------------------------------------------------ weight

    def _without_field(self, forces: Forces) -> tuple[Sequence[Scalar], Forces]:
        """The acceleration with which all bodies fall, (3,), and the forces but for that; STILL where there is none."""
        masses: dict[str, Scalar] = {}
        for inertia in self.bodies.inertias:
            if self.places[self.bodies.home[inertia.frame]].joint is not None and not is_zero(inertia.mass):
                known = all(is_zero(x) for x in inertia.first_moment)
                masses[inertia.frame] = plus(masses.get(inertia.frame, 0.0), inertia.mass) if known else float("nan")
        pulls = {frame: forces.on_frames.get(frame, [0.0] * 6) for frame in masses}
        if not masses or not all(is_nothing(pull[3:]) for pull in pulls.values()):
            return STILL, forces
        first = next(iter(masses))
        field = [0.0 if is_zero(x) else minus(0.0, x) / masses[first] for x in pulls[first][:3]]
        left = [plus(x, times(masses[frame], y)) for frame, pull in pulls.items() for x, y in zip(pull, field, strict=False)]
        if is_nothing(field) or not self._vanish(left, [x for pull in pulls.values() for x in pull[:3]]):
            return STILL, forces
        return field, Forces({name: x for name, x in forces.on_frames.items() if name not in masses}, forces.on_coordinates)

    def _vanish(self, left: Sequence[Scalar], beside: Sequence[Scalar]) -> bool:
        """Whether they are 0 whatever the parameters, tried with numbers, and depend on nothing that moves."""
        moving = ca.vertcat(self.kinematics.algebra.state, self.kinematics.symbols.time)
        return not ca.depends_on(ca.SX(ca.vertcat(*left, *beside)), moving) and _is_rounding(left, beside)


def _is_rounding(left: Sequence[Scalar], beside: Sequence[Scalar]) -> bool:
    """Whether numbers are 0 whatever their symbols are, tried with numbers, as rounding of others lets them be."""
    table = ca.SX(ca.vertcat(*left, *beside))
    free = ca.symvar(table)
    values = ca.DM([0.7 + 0.31 * (k % 17) for k in range(len(free))])
    found = abs((ca.Function("field", [ca.vertcat(*free)], [table])(values) if free else ca.evalf(table)).full()).ravel()
    return bool(found[: len(left)].max() <= _SAME_FIELD * found[len(left) :].max())


def articulate_in_space(kinematics: Kinematics, bodies: Bodies) -> SpatialBodies | None:
    """None when the scene is no tree of rigid bodies: a coordinate that moves several joints, none, or no mass of its own, or a
    kinetic term that couples several bodies or is no body's."""
    uses = Counter(name for edge in kinematics.graph.edges for name in edge.coordinates)
    tied = any(dependent.terms for dependent in kinematics.dependents.values())
    if bodies.rest or tied or any(count > 1 for count in uses.values()):
        return None
    found = _Finding(kinematics, bodies)
    moved = Counter(index for joint in found.joints for index in joint.coordinates)
    graph = kinematics.graph
    is_whole = len(moved) >= len(graph.coordinates) - len(graph.model.states) - len(graph.kept_coordinates)
    if not (found.is_known and is_whole) or any(count > 1 for count in moved.values()):
        return None
    try:
        return SpatialBodies(kinematics, bodies, found.with_bodies(), found.places)
    except ZeroDivisionError:  # D is the number 0
        return None


class _Finding:
    """The joints of a scene, in the order of its edges."""

    def __init__(self, kinematics: Kinematics, bodies: Bodies) -> None:
        self.kinematics, self.bodies = kinematics, bodies
        self.number = {c.name: k for k, c in enumerate(kinematics.graph.coordinates)}
        self.still = kinematics.without_accelerations()
        self.joints: list[SpatialJoint] = []
        self.places: dict[str, _Place] = {}
        self.is_known = True
        for root in kinematics.graph.roots:
            self.places[root.frame] = self._root(root.frame, root.attributes)
        for edge in kinematics.graph.edges:
            if not edge.is_rigid:
                local, home = bodies.local[edge.parent], self.places[bodies.home[edge.parent]]
                self.places[edge.child] = self._along(edge, home.followed(local.axes, local.origin))

    def with_bodies(self) -> list[SpatialJoint]:
        """The joints with the inertias of what is fixed to the frames behind them."""
        found: dict[int, RigidInertia] = {}
        for inertia in self.bodies.inertias:
            local = self.bodies.local[inertia.frame]
            place = self.places[self.bodies.home[inertia.frame]].followed(local.axes, local.origin)
            if place.joint is not None:
                body = RigidInertia(inertia.mass, inertia.first_moment, inertia.second_moment).placed(place.R, place.origin)
                found[place.joint] = found[place.joint].with_other(body) if place.joint in found else body
        return [replace(joint, body=found.get(k)) for k, joint in enumerate(self.joints)]

    def _root(self, frame: str, attributes: Sequence[str]) -> _Place:
        if not attributes:
            return _Place(None)
        self.is_known &= all(part in _COORDINATES or part == FLOATING for part in attributes)
        vectors: list[Vector] = [[0.0] * 3 for _ in range(3)]
        slopes: dict[int, Vector] = {}
        for part in (x for x in attributes if x != FLOATING):
            k, name = _COORDINATES.index(part), f"{frame}.{part}"
            for vector, x in zip(vectors, _levels(self.still.coordinate(name, 2)), strict=True):
                vector[k] = x
            if name in self.number:
                slopes[self.number[name]] = [1.0 if i == k else 0.0 for i in range(3)]
        ahead, rate, second = vectors
        joint = SpatialJoint(None, "shift", SAME, STILL, tuple(slopes), [*slopes.values()], ahead=ahead, motion=(rate, second))
        self.joints.append(joint)
        place = _Place(len(self.joints) - 1)
        return self._rotation(f"{frame}.{FLOATING}", place) if FLOATING in attributes else place

    def _along(self, edge: Edge, place: _Place) -> _Place:
        for step in edge.steps:
            if (attitude := self.kinematics.attitude_of(step)) is not None:
                self.is_known &= not step.is_inverse
                place = self._rotation(attitude, place)
                continue
            amount = self.still.evaluator.value(step.amount, 2)
            if not any(isinstance(x, Dual) for x in scalars_of(amount)):
                pose: Pose = self.kinematics.step(step, self.kinematics.geometry.here, 0)
                place = place.followed(pose.axes, pose.origin)
                continue
            slopes = {self.number[name]: slope for name in edge.coordinates if name in self.number
                      if not is_nothing(slope := self._slope(step, name))}
            place = self._shift(step, amount, slopes, place) if step.kind == "shift" else self._turn(step, amount, slopes, place)
        return place

    def _rotation(self, attitude: str, place: _Place) -> _Place:
        parts = parts_of(attitude)
        w = [base_of(rate_of(value_of(self.still.coordinate(part, 2)))) for part in parts]
        coordinates = tuple(self.number[part] for part in parts)
        joint = SpatialJoint(place.joint, "rotation", place.R, place.origin, coordinates, (1.0,) * 3,
                             attitude=self.kinematics.axes_of(attitude), motion=(w, STILL))
        self.joints.append(joint)
        return _Place(len(self.joints) - 1)

    def _slope(self, step: Step, name: str) -> Vector:
        evaluator = Evaluator(self.kinematics.graph.model, self.kinematics.algebra, OneMoves(self.kinematics, name))
        rates = [rate_of(x) for x in scalars_of(evaluator.value(step.amount, 1))]
        return [minus(0.0, x) for x in rates] if step.is_inverse else rates

    def _shift(self, step: Step, amount: Value, slopes: Mapping[int, Vector], place: _Place) -> _Place:
        ahead, rate, second = zip(*[_levels(minus(0.0, x) if step.is_inverse else x) for x in scalars_of(amount)], strict=True)
        joint = SpatialJoint(place.joint, "shift", place.R, place.origin, tuple(slopes), [*slopes.values()], ahead=ahead,
                             motion=(rate, second))
        self.joints.append(joint)
        return _Place(len(self.joints) - 1)

    def _turn(self, step: Step, amount: Value, slopes: Mapping[int, Vector], place: _Place) -> _Place:
        self.is_known &= len(slopes) <= 1 and not isinstance(amount, tuple)
        angle, rate, second = _levels(minus(0.0, amount) if step.is_inverse else amount)
        algebra = self.kinematics.algebra
        axis = unit_axis(step, self.kinematics.evaluator.value(step.axis) if step.axis is not None else None, algebra)
        joint = SpatialJoint(place.joint, "turn", place.R, place.origin, tuple(slopes), [x for (x,) in slopes.values()], axis,
                             angle, motion=((rate,), (second,)))
        if (shift := self._travel(joint, place)) is not None:
            travel = [dot([*axis], x) for x in (shift.ahead, *shift.motion, shift.slopes[0])]
            joint = replace(joint, parent=shift.parent, R=shift.R, origin=shift.origin, travel=travel)
            self.joints.pop()
        self.joints.append(joint)
        return _Place(len(self.joints) - 1)

    def _travel(self, turn: SpatialJoint, place: _Place) -> SpatialJoint | None:
        """The shift just ahead of a turn by the same coordinate, along its axis: both are a screw."""
        shift = self.joints[-1] if self.joints and place.joint == len(self.joints) - 1 else None
        if shift is None or shift.kind != "shift" or len(turn.coordinates) != 1 or shift.coordinates != turn.coordinates:
            return None
        if place.R is not SAME or place.origin is not STILL:
            return None
        ways = [shift.ahead, *shift.motion, shift.slopes[0]]
        across = [x for way in ways for x in cross(turn.axis, way)]
        return shift if _is_rounding(across, [x for way in ways for x in way]) else None


def _levels(x: Scalar) -> tuple[Scalar, Scalar, Scalar]:
    """A value, its rate and its second derivative, of a Dual of Duals."""
    return base_of(x), base_of(rate_of(value_of(x))), base_of(rate_of(rate_of(x)))
