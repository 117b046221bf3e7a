"""ComponentGraph -> position, angle, velocity and rate of every frame as functions of q, v and t.

The poses (planar.py) are evaluated with Duals, so the velocities come with the positions."""

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import field, replace
from functools import cached_property, partial
from typing import Any

import casadi as ca

from lagrangia.algebra.duals import Dual, GlidingAlgebra, Scalar, base_of, plus, polynomial, times
from lagrangia.algebra.scalars import as_expression, column, symbol, symbols_in
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.base.diagnostics import LagError, fail
from lagrangia.base.records import dataclass
from lagrangia.frames.alike import evaluate_all
from lagrangia.frames.attitude_starts import FLOATING, Attitude
from lagrangia.frames.attitudes import Attitudes
from lagrangia.frames.closures import cut_coordinate
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Evaluator, Value, scalars_of
from lagrangia.frames.geometry import Geometry, Pose, geometry_of
from lagrangia.frames.graph import ComponentGraph
from lagrangia.frames.parameter_symbols import VanishAsDeclared, compiled_in, shaped_symbols
from lagrangia.frames.planes import Plane
from lagrangia.frames.quaternions import NOT_TURNED, Quaternion, quaternion_along
from lagrangia.frames.space_checks import require_about_z
from lagrangia.frames.spatial import Matrix
from lagrangia.frames.stamped_poses import FEWEST, Placed, place_way, ways
from lagrangia.frames.vectors_on_a_line import line_of
from lagrangia.language.attitudes import parts_of
from lagrangia.language.compiled_numbers import compiled_numbers
from lagrangia.language.consequences import CONSTRAINT_FORCE
from lagrangia.language.flat import FlatModel, Sampler
from lagrangia.language.frame_attributes import ABOUT_Z
from lagrangia.language.frame_steps import Step
from lagrangia.language.moving_inputs import rate_names

_JUST_AFTER = 1e-9  # of the time from start to stop
Displacement = tuple[ca.SX, ...]  # a virtual one and its rate, or those of an excitation, with its second derivative


@dataclass(frozen=True)
class Dependent:
    """A coordinate that a linear constraint gives: constant(t, p) + sum of coefficient(p) * coordinate.

    `constant` holds the constant and its first two derivatives in time.
    """

    constant: tuple[Scalar, Scalar, Scalar]
    terms: Mapping[str, Scalar]


@dataclass(frozen=True)
class Symbols:
    """The symbols of one scene. tau is the rate of time, 1: kept apart so that powers of moving supports can be told."""

    time: Scalar
    tau: Scalar
    positions: dict[str, Scalar]
    rates: dict[str, Scalar]
    accelerations: dict[str, Scalar]
    values: dict[str, Any]  # parameters and inputs; tuples for arrays
    compiled: Mapping[str, Any] = field(default_factory=dict)  # the same, with numbers where these are compiled in
    pieces: Mapping[str, Any] = field(default_factory=dict)  # of moving inputs, as polynomials of time: Piece; tuples for arrays
    attitudes: dict[str, tuple[Scalar, ...]] = field(default_factory=dict)  # references of coordinates that are attitudes
    held: dict[str, Scalar] = field(default_factory=dict)  # values that are held between instants
    asked: set[str] = field(default_factory=set)  # "time" as soon as an expression speaks of it, and "accelerations"


@dataclass(frozen=True)
class Piece:
    """What an input is between two times: a polynomial of the time since `place`, the constant first."""

    place: ca.SX
    coefficients: tuple[ca.SX, ...]


@dataclass
class Kinematics(Attitudes):
    """Frames and symbols at each level; the `Leaves` of an Evaluator."""

    graph: ComponentGraph
    symbols: Symbols
    algebra: CasadiAlgebra  # paper/symbolic.py puts SymPy's in its place
    dependents: Mapping[str, Dependent] = field(default_factory=dict)
    released: Mapping[str, Displacement] = field(default_factory=dict)
    moved: Mapping[str, Displacement] = field(default_factory=dict)  # those of single frames, nothing behind them
    reactions: dict[str, tuple[ca.SX, ...]] = field(default_factory=dict)  # symbols of those that outputs and forces ask for
    forces: dict[str, ca.SX] = field(default_factory=dict)  # the same of equations: language/consequences.py
    evaluator: Evaluator = field(init=False)
    declared: tuple[ca.SX, ca.DM] | None = None  # once somebody asked: constraints/parameters.py
    assembled: tuple[Any, tuple[Any, int]] | None = None  # the same of the start: constraints/assembly.py
    _poses: list[dict[str, Pose]] = field(default_factory=lambda: [{}, {}, {}])  # that were asked for, by levels
    _places: list[dict[str, Placed]] = field(default_factory=lambda: [{}, {}, {}])
    _still: "Kinematics | None" = None
    quaternions: dict[str, Quaternion] = field(default_factory=dict)  # plain ones of attitudes, and their matrices
    axes: dict[str, Matrix] = field(default_factory=dict)
    seen: dict[tuple[str, int], dict[str, Any]] = field(default_factory=dict)  # poses from bases of loops, by levels
    closed: dict[tuple[int, int], list[Scalar]] = field(default_factory=dict)  # gaps, by ids of closures in space and levels
    _amounts: dict[int, Value] = field(default_factory=dict)  # of steps that never change, by the ids of their expressions

    def __post_init__(self) -> None:
        displacements = [x for pair in (*self.released.values(), *self.moved.values()) for x in pair]
        virtual = partial(_change, displacements) if displacements else None
        lengths = self._signed_length if isinstance(self.algebra, CasadiAlgebra) else None  # others may be SymPy's: symbolic.py
        self.evaluator = Evaluator(self.graph.model, self.algebra, self, virtual, lengths)

    @property
    def is_displaced(self) -> bool:
        """Whether there are virtual displacements."""
        return bool(self.released or self.moved)

    @cached_property
    def geometry(self) -> Geometry:
        """What frames are, in the plane or in space."""
        return geometry_of(self.graph.model.space, self.graph.plane)

    def seen_from_itself(self, frame: str) -> Pose:
        """The pose of a frame in its own axes."""
        here = self.geometry.here
        return replace(here, own=self.pose(frame, 1).own) if self.graph.lies_in_plane else here

    # ------------------------------------------------------------ leaves of expressions

    def symbol(self, name: str, level: int) -> Value | None:
        """The value of a coordinate, parameter or input; None for a variable with a binding."""
        if name in self.symbols.positions or name in self.dependents:
            return self.coordinate(name, level)
        if name in self.symbols.attitudes:
            return self.rates_of_attitude(name, level)
        if name in self.graph.cut_coordinates:
            read = cut_coordinate(self, self.graph.cut_coordinates[name], level)
            return read + displacement(self.released[name], level) if name in self.released else read
        if name in self.symbols.pieces:
            return self._moved_input(self.symbols.pieces[name], level)
        if name.startswith(CONSTRAINT_FORCE):
            return self.forces.setdefault(name, symbol(name))
        if name.startswith("pre("):
            return self.symbols.held[name[4:-1]]
        if name in self.symbols.held:
            return self.symbols.values.get(name, self.symbols.held[name])
        return self.symbols.compiled.get(name, self.symbols.values.get(name))

    def _moved_input(self, piece: Value, level: int) -> Value:
        if isinstance(piece, tuple):
            return tuple(self._moved_input(item, level) for item in piece)
        return polynomial(self.time(level), piece.place, piece.coefficients)

    def coordinate(self, name: str, level: int) -> Scalar:
        """A coordinate with its rate, and its acceleration at level 2."""
        if name in self.dependents:
            given = self._dependent(self.dependents[name], level)
            return given + displacement(self.released[name], level) if name in self.released else given
        q, v, a = (values[name] for values in (self.symbols.positions, self.symbols.rates, self.symbols.accelerations))
        if level == 2 and isinstance(a, ca.SX):
            self.symbols.asked.add("accelerations")
        return (q, Dual(q, v), Dual(Dual(q, v), Dual(v, a)))[level]

    def _dependent(self, dependent: Dependent, level: int) -> Scalar:
        tau = self.symbols.tau
        c, c1, c2 = dependent.constant
        total = (c, Dual(c, c1 * tau), Dual(Dual(c, c1 * tau), Dual(c1 * tau, c2 * tau * tau)))[level]
        for name, coefficient in dependent.terms.items():
            total = total + coefficient * self.coordinate(name, level)
        return total

    def at_start(self, expressions: list[ca.SX]) -> list[ca.SX]:
        """At the start time, with modes as they are just after it."""
        t, experiment, present = self.symbols.time, self.graph.model.experiment, symbols_in(ca.veccat(ca.SX(0, 1), *expressions))
        modes = [mode for mode in self.algebra.modes if mode.hash in present]
        just_after = experiment.start + _JUST_AFTER * (experiment.stop - experiment.start)
        begins = [just_after if mode.of_input is None else experiment.start for mode in modes]
        values = [ca.substitute(mode.value, t, ca.SX(begin)) for mode, begin in zip(modes, begins, strict=True)]
        expressions = ca.substitute(expressions, [mode.symbol for mode in modes], values) if modes else expressions
        return list(ca.substitute(expressions, [t, self.symbols.tau], [ca.SX(experiment.start), ca.SX(1)]))

    def time(self, level: int) -> Scalar:
        """The time, s, with its rate tau."""
        t, tau = self.symbols.time, self.symbols.tau
        self.symbols.asked.add("time")
        return (t, Dual(t, tau), Dual(Dual(t, tau), Dual(tau, 0.0)))[level]

    def frame(self, name: str, attribute: str, level: int) -> Value:
        """An attribute of a frame (language/frame_attributes.py). Raises LagError."""
        kind = self.graph.model.space.attributes[attribute].kind
        if kind == "attitude" and attribute != "R":
            if attribute != "Q":
                fail("L0302", f"{name}.{attribute} is no number: a torque works on it", self.graph.model.frames[name].span,
                     "write: work M on frame.attitude; the attitude itself is R (a matrix) or Q (a quaternion)")
            if self.is_displaced:  # by which its way along the tree knows nothing
                fail("L0901", f"not supported yet: reactions, and forces on frames, where something depends on {name}.Q",
                     self.graph.model.frames[name].span, "the elements of its matrix R are known there")
            return self.attitude(name, level)
        if kind == "reaction":
            return self._reaction(name, attribute, level)
        if kind == "velocity" and level >= 2:
            fail("L0503", f"the second derivative of {name}.{attribute} is not known", self.graph.model.frames[name].span)
        if attribute == ABOUT_Z and not self.is_displaced:  # virtual displacements turn as nothing turns
            own = self.geometry.attribute_of(self.pose(name, 1), "omega")
            require_about_z(name, own, self.symbols.rates, self.graph.model.frames[name].span)
        return self.geometry.attribute_of(self.pose(name, level + 1 if kind == "velocity" else level), attribute)

    def attitude(self, name: str, level: int) -> Value:
        """The quaternion of a frame, without what displaces it."""
        edges, way = {edge.child: edge for edge in self.graph.edges}, list[Edge]()
        while name in edges:
            way.insert(0, edges[name])
            name = way[0].parent
        steps = (step for edge in way for step in edge.steps)
        floating = f"{name}.{FLOATING}"
        first = self.quaternion(floating, level) if floating in self.symbols.attitudes else NOT_TURNED
        return quaternion_along(steps, self.evaluator.value, level, self.evaluator.algebras[level], self.turn_by, first)

    def _reaction(self, name: str, attribute: str, level: int) -> Value:
        """Symbols that stand for the force and torque of a joint on its port b, until dynamics/reactions.py works them out."""
        if level > 0:
            fail("L0911", "the rate of a reaction is not known", self.graph.model.frames[name].span)
        if self.graph.lies_in_plane:
            fail("L0911", f"the reaction of '{name}' has parts across the plane of the scene", self.graph.model.frames[name].span,
                 "declare what it is for as an output")
        if name not in self.reactions:
            self.reactions[name] = tuple(symbol(f"{name}.{part}") for part in self.graph.model.space.wrench)
        return self.geometry.picked(attribute, self.reactions[name])

    def knowing(self, values: Mapping[str, Scalar]) -> "Kinematics":
        """The same motion where more is known by name."""
        symbols = replace(self.symbols, values={**self.symbols.values, **values})
        return Kinematics(self.graph, symbols, self.algebra, self.dependents, reactions=self.reactions, forces=self.forces)

    def without_accelerations(self) -> "Kinematics":
        """The same motion with dv/dt = 0: its second derivatives are what the rates alone make."""
        if self._still is None:
            at_rest = dict.fromkeys(self.symbols.accelerations, 0.0)
            self._still = Kinematics(self.graph, replace(self.symbols, accelerations=at_rest), self.algebra, self.dependents,
                                     reactions=self.reactions, forces=self.forces)
            self._still._still, self._still._amounts = self._still, self._amounts
        return self._still

    def gliding(self, pace: ca.SX, given: Sequence[ca.SX]) -> "Kinematics":
        """Positions and velocities, these with what modes would add that change at this pace (n_modes,), and with what `given`
        adds to the rates of dependent coordinates, of each; the rate of time is 1."""
        modes = self.algebra.mode_symbols
        pace = ca.vertcat(*[0 if mode.of_attitude else pace[k] for k, mode in enumerate(self.algebra.modes)])

        def glide(value: Scalar) -> Scalar:
            moves = isinstance(value, ca.SX) and ca.depends_on(value, modes)
            return ca.jtimes(value, modes, pace) if moves else 0.0

        dependents = {name: replace(dependent, constant=(dependent.constant[0], plus(dependent.constant[1], more), 0.0))
                      for (name, dependent), more in zip(self.dependents.items(), given, strict=True)}
        found = Kinematics(self.graph, replace(self.symbols, tau=ca.SX(1)), self.algebra, dependents)
        found.evaluator.algebras[1:] = [GlidingAlgebra(self.algebra, glide)]  # accelerations are not known here
        return found

    def displaced(
        self, released: Mapping[str, Displacement], moved: Mapping[str, Displacement] | None = None
    ) -> "Kinematics":
        """The same motion with virtual displacements and their rates: of a frame with all that lies behind it (a place), of
        the coordinate of a cut joint, or of a coordinate that a constraint gives. `moved`: of frames alone."""
        return Kinematics(self.graph, self.symbols, self.algebra, self.dependents, released, moved or {}, self.reactions,
                          self.forces)

    def _signed_length(self, vector: list[Scalar], level: int) -> Scalar | None:
        if not any(isinstance(x, ca.SX) for x in vector):
            return None
        line = line_of(vector, self._names, self.algebra.changing)
        if line is None:
            return None
        total = line.constant
        for name, factor in line.terms.items():
            total = plus(total, times(factor, self.coordinate(name, level)))
        return total

    @cached_property
    def _names(self) -> dict[int, str]:
        """Of coordinates, by the hashes of their symbols."""
        return {x.__hash__(): name for name, x in self.symbols.positions.items()}

    @property
    def is_timed(self) -> bool:
        """Whether time stands in what was evaluated so far; looking for its symbol takes as long as deriving with it."""
        return "time" in self.symbols.asked or bool(self.dependents)

    # ------------------------------------------------------------ poses

    def pose(self, name: str, level: int) -> Pose:
        """Raises LagError L0401 for a frame that is joined to nothing."""
        pose = self._poses[level].get(name)
        if pose is None:
            pose = self._poses[level][name] = self._placed(name, level)
        return self._displaced(pose, self.moved[name], level) if level and name in self.moved else pose

    def poses(self, level: int) -> Mapping[str, Pose]:
        """Of all frames; the level is 1 or 2."""
        placed = (*(root.frame for root in self.graph.roots), *(edge.child for edge in self.graph.edges))
        return {name: self.pose(name, level) for name in placed}

    def _placed(self, name: str, level: int) -> Pose:
        """A pose that was not asked for before."""
        if level == 0:
            return self.pose(name, 1).lowered
        if level == 1 and len(self.evaluator.algebras) > 2 and not (self.released or self.moved):
            # the inertial forces need the second level in any case, and it has the first one in it
            return self.without_accelerations().pose(name, 2).lowered
        if not self._places[level]:
            self._place_all(level)
        place = self._places[level].get(name)
        if place is None:
            fail("L0401", f"the frame '{name}' is joined to nothing", self.graph.model.frames[name].span)
        return place() if callable(place) else place

    def _place_all(self, level: int) -> None:
        self._measure_rigid()
        poses: dict[str, Pose] = {}
        for root in self.graph.roots:
            poses[root.frame] = self._root_pose(root.frame, root.attributes, level)
        self._places[level].update(poses)
        if self._place_ways(level):
            return
        for edge in self.graph.edges:
            poses[edge.child] = self.follow(edge, poses[edge.parent], level)
            if edge.child in self.released:
                poses[edge.child] = self._displaced(poses[edge.child], self.released[edge.child], level)
        self._places[level].update(poses)

    def _place_ways(self, level: int) -> bool:
        """Whether that was done along ways: of many frames of the plane, where nothing is displaced; what is wrong is told one by
        one."""
        edges, places = self.graph.edges, self._places[level]
        is_other = self.graph.model.space.is_spatial or not isinstance(self.algebra, CasadiAlgebra)
        if len(edges) < FEWEST or self.released or self.moved or is_other:
            return False
        with suppress(LagError):
            found = dict(places)
            for way in ways(edges):
                amounts = [[self.amount_of(step, level) for step in edge.steps] for edge in way]
                begin = found[way[0].parent]
                placed = place_way(way, amounts, begin() if callable(begin) else begin,
                                   lambda step, amount, pose: self.along(step, amount, pose, level))
                found.update(zip((edge.child for edge in way), placed, strict=True))
            places |= found
            return True
        return False

    def _measure_rigid(self) -> None:
        """The amounts of all steps within rigid bodies, together; what is wrong with one of them is told when it is its turn."""
        if self._amounts:
            return
        fixed = [step.amount for edge in self.graph.edges if edge.is_rigid for step in edge.steps]
        with suppress(LagError):
            found = evaluate_all(fixed, [self.evaluator] * len(fixed))
            self._amounts.update(zip(map(id, fixed), found, strict=True))

    def _displaced(self, pose: Pose, moved: Displacement, level: int) -> Pose:
        parts = [displacement([part[k] for part in moved], level) for k in range(self.geometry.size)]
        return pose.displaced(parts, self.evaluator.algebras[level])

    def _root_pose(self, frame: str, attributes: tuple[str, ...], level: int) -> Pose:
        place = {a: self.coordinate(f"{frame}.{a}", level) for a in attributes if a != FLOATING}
        pose = self.geometry.root_pose(place, self.algebra.number, self.evaluator.algebras[level], level)
        return self._turned(pose, f"{frame}.{FLOATING}", False, level) if FLOATING in attributes else pose

    def follow(self, edge: Edge, pose: Pose, level: int, evaluator: Evaluator | None = None) -> Pose:
        """The pose of the edge's child, given its parent's."""
        try:
            for step in edge.steps:
                pose = self.step(step, pose, level, evaluator)
        except LagError as error:
            raise error.placed(edge.span) from None
        return pose

    def step(self, step: Step, pose: Pose, level: int, evaluator: Evaluator | None = None) -> Pose:
        """The pose behind a step that begins at another one."""
        if (attitude := self.attitude_of(step)) is not None:
            return self._turned(pose, attitude, step.is_inverse, level)
        axis = self.evaluator.value(step.axis) if step.axis is not None else None
        return self.along(step, self.amount_of(step, level, evaluator), pose, level, axis)

    def amount_of(self, step: Step, level: int, evaluator: Evaluator | None = None) -> Value:
        """By how much it shifts or turns. Raises LagError."""
        amount = self._amounts.get(id(step.amount)) if evaluator is None else None
        return (evaluator or self.evaluator).value(step.amount, level) if amount is None else amount

    def _turned(self, pose: Pose, attitude: str, is_inverse: bool, level: int) -> Pose:
        s = tuple(self.coordinate(part, level) for part in parts_of(attitude))
        return pose.oriented(self.axes_of(attitude), s, is_inverse)

    def along(self, step: Step, amount: Value, pose: Pose, level: int, axis: Value | None = None) -> Pose:
        """The pose after a step of this amount."""
        return self.geometry.step(pose, step, amount, axis, self.evaluator.algebras[level])


def displacement(moved: Sequence[Scalar], level: int) -> Scalar:
    """At a level of the kinematics."""
    shift, rate, second = (*moved, 0.0, 0.0)[:3]
    return (shift, Dual(shift, rate), Dual(Dual(shift, rate), Dual(rate, second)))[level]


def _change(displacements: list[ca.SX], value: Scalar) -> Scalar:
    """What virtual displacements and their rates add to a value."""
    value = base_of(value)
    if not isinstance(value, ca.SX):
        return 0.0
    return value - ca.substitute([value], displacements, [ca.SX.zeros(x.numel()) for x in displacements])[0]


def build_kinematics(graph: ComponentGraph, is_general: bool = True, massless: tuple[str, ...] | None = None) -> Kinematics:
    """The kinematics of a scene in fresh CasADi symbols. Numbers are compiled in: see compiled_numbers."""
    def symbols(names: list[str]) -> dict[str, ca.SX]:
        return {name: symbol(name) for name in names}

    names = [c.name for c in graph.coordinates]
    positions, rates = symbols(names), {name: symbol(f"der({name})") for name in names}
    accelerations = {name: symbol(f"der(der({name}))") for name in names}
    time, tau = symbol("t"), symbol("tau")
    variables = [v for v in graph.model.variables.values() if v.kind in ("parameter", "input", "delayed")]
    values = {v.name: shaped_symbols(v.name, v.shape) for v in variables}
    inputs = [(v.name, x) for v in variables if v.kind == "input" for x in scalars_of(values[v.name])]
    late = (values[delay.name] for delay in graph.model.delays)
    moving = column(*positions.values(), *rates.values(), *accelerations.values(), *(x for _, x in inputs), *late)
    of_plane = graph.plane.numbers if isinstance(graph.plane, Plane) else {}
    numbers = {**compiled_numbers(graph.model, is_general, massless), **of_plane}
    compiled = {name: compiled_in(values[name], known) for name, known in numbers.items()}
    algebra = CasadiAlgebra(time, moving, symbols_in(column(*rates.values())), VanishAsDeclared(graph.model, values))
    pieces = {name: _pieces(algebra, graph.model, name, values, [x for x, _ in inputs]) for name in graph.model.moving_inputs}
    found = Kinematics(graph, Symbols(time, tau, positions, rates, accelerations, values, compiled, pieces), algebra)
    for attitude in graph.attitudes.values():
        _refer(found, attitude)
    for k, sampler in enumerate(graph.model.samplers):
        _hold(found, k, sampler)
    return found


def _refer(kinematics: Kinematics, attitude: Attitude) -> None:
    """An attitude's reference: four modes that the run time moves along, at first what is said of its start."""
    algebra, first = kinematics.algebra, (1.0, 0.0, 0.0, 0.0)
    if attitude.start is not None:
        first = kinematics.evaluator.value(attitude.start)
        if not isinstance(first, tuple) or len(first) != len(NOT_TURNED) or any(isinstance(x, tuple) for x in first):
            fail("L0303", f"'{attitude.name}' begins at an attitude", attitude.start.span,
                 'write angles("zxz", 10[deg], 20[deg], 0), axis_angle({1, 0, 0}, 30[deg]) or quaternion(1, 0, 0, 0)')
        if not algebra.changing.isdisjoint(symbols_in(ca.vertcat(ca.SX(0, 1), *first))):
            fail("L0602", "a start value depends on parameters only", attitude.start.span, "write an initial equation instead")
    kinematics.symbols.attitudes[attitude.name] = tuple(
        algebra.reference(attitude.name, k, as_expression(x)) for k, x in enumerate(first))


def _hold(kinematics: Kinematics, number: int, sampler: Sampler) -> None:
    """The values of a sampler are modes, which change where a + b t is a whole number."""
    algebra, value = kinematics.algebra, kinematics.evaluator.value
    start, interval = (as_expression(value(x)) for x in (sampler.start, sampler.interval))
    starts = [as_expression(value(v.start) if (v := kinematics.graph.model.variables[x.name]).start is not None else 0.0)
              for x in sampler.held]
    spans = (sampler.start.span, sampler.interval.span, *(held.span for held in sampler.held))
    for x, span in zip((start, interval, *starts), spans, strict=True):
        if not algebra.changing.isdisjoint(symbols_in(x)):
            fail("L0232", "instants and first values depend on parameters only", span)
    arguments = [(kinematics.symbols.time - start) / interval]
    for held, first in zip(sampler.held, starts, strict=True):
        kinematics.symbols.held[held.name] = algebra.held(held.name, (number, held.rank), first, arguments)


def _pieces(algebra: CasadiAlgebra, model: FlatModel, name: str, values: Mapping[str, Any], inputs: list[str]) -> Value:
    """Of a moving input, in the shape of its value. `inputs`: of each scalar among the inputs, whose it is."""
    rates = rate_names(name) if model.moving_inputs[name] else ()
    columns = [scalars_of(values[part]) for part in (name, *rates)]
    firsts = [inputs.index(part) for part in (name, *rates)]
    found = []
    for k, parts in enumerate(zip(*columns, strict=True)):
        y, rate, second = (*parts, 0.0, 0.0)[:3]
        at = (firsts[0] + k, firsts[1] + k if rates else -1, firsts[2] + k if rates else -1)
        place, *coefficients = algebra.pieces_of_input(at, y, rate, second)
        found.append(Piece(place, tuple(coefficients)))
    return _nested(iter(found), model.variables[name].shape)


def _nested(items: Iterator[Piece], shape: tuple[int, ...]) -> Value:
    return tuple(_nested(items, shape[1:]) for _ in range(shape[0])) if shape else next(items)
