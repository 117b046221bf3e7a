"""What a scene states -> what Modelica.Mechanics.MultiBody has for it: bodies; forces in joints, between points, on frames.

The virtual work of all that is stated is told by what it moves: coordinates, distances of two frames, places and attitudes of
frames. Whatever the energies are, a formula says what acts along each; bodies, springs and dampers are known by theirs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field
from typing import Any, NoReturn

import sympy as sp

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.algebra.with_sympy import TIME, Expr, SympyAlgebra, exact_throughout, slope
from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.records import dataclass
from lagrangia.frames.evaluation import Value, scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.flat import Energy, FlatModel, Work
from lagrangia.language.frame_attributes import ABOUT_Z, ANGLE
from lagrangia.language.tree import Call, Flat, FrameRef
from lagrangia.paper.parameter_symbols import ParameterTable, ReadableEvaluator

INSTEAD = "lag export --to modelica without --components writes the equations of motion"


def refuse(what: str, span: Span | None) -> NoReturn:
    """Raises LagError L0901."""
    fail("L0901", f"not supported yet: {what} among components of Modelica.Mechanics.MultiBody", span, INSTEAD)


@dataclass(frozen=True)
class Quantity:
    """What a symbol stands for: a "coordinate", the "distance" of two frames, a component of a "place", an "angle" in the plane,
    an entry of the "axes" of a frame, a component of a "spin", or an "input"; `order` 1 of its rate."""

    kind: str
    of: tuple[str, ...]
    place: tuple[int, ...] = ()
    order: int = 0

    @property
    def still(self) -> "Quantity":
        """What it is the rate of."""
        return Quantity(self.kind, self.of, self.place)


@dataclass(frozen=True)
class RigidBody:
    """Its mass, at the origin of its frame, and its inertia in the axes of that: kg, kg.m2."""

    component: str
    frame: str
    mass: Expr
    inertia: tuple[tuple[Expr, ...], ...]
    span: Span


@dataclass
class Stated:
    """What acts, by component and what it acts on: forces along quantities, torques on frames; and what moves."""

    forces: dict[tuple[str, Quantity], Expr] = field(default_factory=dict)
    torques: dict[tuple[str, str], list[Expr]] = field(default_factory=dict)
    bodies: list[RigidBody] = field(default_factory=list)
    spans: dict[str, Span] = field(default_factory=dict)


class Reading:
    """Leaves of an evaluator to which all that moves is a symbol; knows what each stands for."""

    def __init__(self, kinematics: Kinematics) -> None:
        self.model: FlatModel = kinematics.graph.model
        algebra = SympyAlgebra()
        self.table = ParameterTable(kinematics, algebra)
        self.evaluator = _Evaluator(self.model, algebra, self)
        self.evaluator.reading = self
        self.known: dict[Expr, Quantity] = {}
        self.size = 3 if self.model.space.is_spatial else 2

    def lifted(self, what: Quantity, level: int) -> Scalar:
        """Its symbol, with those of its rates."""
        s, v, a = (self.symbol_of(Quantity(what.kind, what.of, what.place, order)) for order in range(3))
        return (s, Dual(s, v), Dual(Dual(s, v), Dual(v, a)))[level]

    def symbol_of(self, what: Quantity) -> Expr:
        """One for each quantity."""
        label = f"{what.kind} {' '.join(what.of)} {what.place} {what.order}"
        found = sp.Symbol(label, real=True, **({"nonnegative": True} if what.kind == "distance" and not what.order else {}))
        self.known[found] = what
        return found

    def symbol(self, name: str, level: int) -> Value | None:
        """Raises LagError L0901 for what has no counterpart."""
        if name not in self.model.variables:  # the force of an equation
            refuse(f"'{name}'", None)
        variable = self.model.variables[name]
        if variable.kind == "parameter":
            return self.table.symbol(name, level)
        if variable.kind == "coordinate" and not variable.is_attitude:
            return self.lifted(Quantity("coordinate", (name,)), level)
        if variable.kind == "input" and not variable.shape:
            return self.lifted(Quantity("input", (name,)), level)
        if variable.kind != "variable":
            refuse(f"'{name}'", variable.span)
        return None

    def time(self, level: int) -> Scalar:
        """With its rate."""
        return (TIME, Dual(TIME, sp.S.One), Dual(Dual(TIME, sp.S.One), Dual(sp.S.One, sp.S.Zero)))[level]

    def frame(self, name: str, attribute: str, level: int) -> Value:
        """Raises LagError L0901 for attributes that components do not tell."""
        axes = {"x": 0, "y": 1, "z": 2}
        if attribute in axes:
            return self._place(name, axes[attribute], level)
        if attribute in ("r", "v"):
            place = tuple(self._place(name, k, level + (attribute == "v")) for k in range(self.size))
            return place if attribute == "r" else tuple(x.rate for x in place)
        if attribute in ("w", "omega", ABOUT_Z) and level == 0:
            spin = tuple(self.symbol_of(Quantity("spin", (name, attribute), (k,), 1)) for k in range(3))
            return spin if attribute == "omega" or (attribute == "w" and self.size == 3) else spin[2]
        if attribute == ANGLE and level == 0:
            return self.lifted(Quantity("angle", (name,)), level)
        if attribute == "R" and level == 0:
            return tuple(tuple(self.symbol_of(Quantity("axes", (name,), (i, j))) for j in range(3)) for i in range(3))
        refuse(f"'{name}.{attribute}'", self.model.frames[name].span)

    def _place(self, name: str, k: int, level: int) -> Scalar:
        is_still = self.model.frames[name].is_ground
        return sp.S.Zero if k >= self.size or (is_still and not level) else self.lifted(Quantity("place", (name,), (k,)), level)


class _Evaluator(ReadableEvaluator):
    reading: Reading

    def _distance(self, node: Call[Flat], level: int) -> Scalar:
        ends = [end for end in node.arguments if isinstance(end, FrameRef) and end.attribute in ("", "r") and not end.index]
        if len(ends) < 2:
            return super()._distance(node, level)
        return self.reading.lifted(Quantity("distance", tuple(end.name for end in ends)), level)


def read_statements(reading: Reading) -> Stated:
    """Raises LagError L0901 for what has no counterpart."""
    found, model = Stated(), reading.model
    for energy in model.energies:
        found.spans[energy.component] = place_of(model, energy)
        value = exact_throughout(reading.evaluator.value(energy.value))
        if energy.kind == "kinetic":
            if value != 0:
                _add_body(found, _body(reading, energy, value, found.spans[energy.component]))
            continue
        for s in value.free_symbols & reading.known.keys():
            what = reading.known[s]
            if what.kind != "input" and what.order == (energy.kind == "dissipation"):
                _add(found, energy.component, what.still, -slope(value, s))
    for work in model.works:
        found.spans[work.component] = place_of(model, work)
        _add_work(reading, found, work)
    return found


def _add_body(found: Stated, body: RigidBody) -> None:
    """One body for all that a component states of a frame, as of its mass and of its inertia."""
    for k, other in enumerate(found.bodies):
        if (other.component, other.frame) == (body.component, body.frame):
            inertia = tuple(tuple(x + y for x, y in zip(*rows, strict=True))
                            for rows in zip(other.inertia, body.inertia, strict=True))
            found.bodies[k] = RigidBody(body.component, body.frame, other.mass + body.mass, inertia, body.span)
            return
    found.bodies.append(body)


def _add(found: Stated, component: str, what: Quantity, force: Expr) -> None:
    if what.kind in ("axes", "spin"):
        refuse(f"what {told(component)} states of attitudes", found.spans[component])
    key = component, what
    found.forces[key] = found.forces.get(key, sp.S.Zero) + force


def _add_work(reading: Reading, found: Stated, work: Work) -> None:
    value, component = reading.evaluator.value, work.component
    force = [exact_throughout(x) for x in scalars_of(value(work.force))]
    if isinstance(work.position, FrameRef) and work.position.attribute == "attitude":
        torque = found.torques.setdefault((component, work.position.name), [sp.S.Zero] * 3)
        torque[:] = [x + y for x, y in zip(torque, force, strict=True)]
        return
    for f, x in zip(force, scalars_of(value(work.position)), strict=True):
        moved = exact_throughout(x)
        for s in moved.free_symbols & reading.known.keys():
            if reading.known[s].order or reading.known[s].kind == "input":
                refuse(f"work on a rate, as {told(component)} states it", found.spans[component])
            _add(found, component, reading.known[s], f * slope(moved, s))


def told(component: str) -> str:
    """A component in a message; the scene itself has no name."""
    return f"'{component}'" if component else "the scene"


def place_of(model: FlatModel, statement: Energy | Work) -> Span:
    """Where a statement of the library is used, or of one's own stands."""
    port = f"{statement.component}." if statement.component else " "
    return next((frame.span for name, frame in model.frames.items() if name.startswith(port)), statement.span)


def _body(reading: Reading, energy: Energy, value: Expr, span: Span) -> RigidBody:
    """Of a kinetic energy in the velocity of one frame and its spin, in its own axes. Raises LagError L0901 where these are
    coupled: velocities are told in the world's axes, in which no centre of mass rests."""
    what_is_told = f"the kinetic energy of {told(energy.component)}, which is no rigid body's,"
    moving = {reading.known[s] for s in value.free_symbols & reading.known.keys()}
    frames = {what.of[0] for what in moving}
    is_plain = all(what.kind in ("place", "spin") and what.order for what in moving)
    in_world = any(what.of[1:] == ("w",) for what in moving) and reading.size == 3
    if len(frames) != 1 or not is_plain or in_world or value.has(TIME):
        refuse(what_is_told, span)
    frame = frames.pop()
    names = {what.of[1] for what in moving if what.kind == "spin"} or {"omega"}
    v = [reading.symbol_of(Quantity("place", (frame,), (k,), 1)) for k in range(3)]
    w = [sp.Symbol(f"w{k}", real=True) for k in range(3)]
    known = {reading.symbol_of(Quantity("spin", (frame, name), (k,), 1)): w[k] for name in names for k in range(3)}
    H = sp.hessian(value.xreplace(known), [*v, *w])
    m, moved = H[0, 0], sp.Matrix([*v, *w])
    same = range(reading.size)
    is_body = all(sp.simplify(H[i, j] - (m if i == j else 0)) == 0 for i in same for j in same)
    is_whole = sp.simplify(value.xreplace(known) - (moved.T * H * moved)[0] / 2) == 0
    if not is_body or not is_whole or sp.simplify(H[:3, 3:]) != sp.zeros(3) or H.free_symbols & {*v, *w}:
        refuse(what_is_told, span)
    return RigidBody(energy.component, frame, m, tuple(tuple(H[3 + i, 3 + j] for j in range(3)) for i in range(3)), span)


def spring_of(force: Expr, s: Expr, v: Expr, moving: Mapping[Expr, Any]) -> tuple[Expr, Expr, Expr] | None:
    """Stiffness, damping and unstretched length where a force along a distance is -k (s - L) - d v; None of others."""
    k, d, rest = -slope(force, s), -slope(force, v), force.xreplace({s: sp.S.Zero, v: sp.S.Zero})
    if any(x.free_symbols & (moving.keys() | {TIME}) for x in (k, d, rest)) or (k == 0 and rest != 0):
        return None
    return sp.simplify(k), sp.simplify(d), sp.simplify(rest / k) if k != 0 else sp.S.Zero


def padded(vector: Sequence[Scalar]) -> list[Expr]:
    """Of three components."""
    return [*(exact_throughout(x) for x in vector), sp.S.Zero, sp.S.Zero, sp.S.Zero][:3]
