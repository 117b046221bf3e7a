"""Names of what excites a scene -> kinematics in which it is moved by s(t), with its rates: the inputs of small motion.

An excitation is anything that is given from outside: an `input`, a variable that loads or supports are made of (P.force[2]), a
prescribed coordinate (the `to` of a Motion), or the place of a frame (road.y) that is moved with all that it carries.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field, replace

import casadi as ca

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import scalars
from lagrangia.constraints.rows import Constraints
from lagrangia.frames.edges import Edge
from lagrangia.frames.evaluation import Value, scalars_of
from lagrangia.frames.kinematics import Displacement, Kinematics, Symbols
from lagrangia.frames.planar import SIZE
from lagrangia.language.frame_attributes import ATTRIBUTES, COMPONENTS
from lagrangia.language.mentions import nodes
from lagrangia.language.moving_inputs import rate_inputs
from lagrangia.language.observables import observe
from lagrangia.language.space_limits import refuse_in_space
from lagrangia.language.tree import FrameRef, Ref, Time

Triple = tuple[ca.SX, ca.SX, ca.SX]
_PORTS = ("force", "torque", "to")  # what a component of the library that excites is called by


@dataclass(frozen=True)
class Probe:
    """One scalar excitation: an element of a variable, a prescribed coordinate, or a place of a frame."""

    name: str
    kind: str  # "variable", "coordinate", "frame"
    of: str
    element: int  # of the variable's scalars; of a frame's place
    unit: str


@dataclass
class ProbedKinematics(Kinematics):
    """`moved_values`: what is added to variables, as nested tuples; `moved_coordinates`: to coordinates that constraints give."""

    moved_values: Mapping[str, tuple[Value, Value, Value]] = field(default_factory=dict)
    moved_coordinates: Mapping[str, Triple] = field(default_factory=dict)

    def symbol(self, name: str, level: int) -> Value | None:
        """As of the scene, moved where a probe moves it."""
        found = super().symbol(name, level)
        if name not in self.moved_values:
            return found
        if found is None:
            binding = self.graph.model.variables[name].binding
            assert binding is not None
            found = self.evaluator.value(binding, level)
        return _added(found, self.moved_values[name], level)

    def coordinate(self, name: str, level: int) -> Scalar:
        """As of the scene, moved where a probe moves it."""
        found = super().coordinate(name, level)
        return _displaced(*self.moved_coordinates[name], level) + found if name in self.moved_coordinates else found

    def without_accelerations(self) -> Kinematics:
        """The same with accelerations of 0."""
        at_rest = dict.fromkeys(self.symbols.accelerations, 0.0)
        return _with_symbols(self, replace(self.symbols, accelerations=at_rest))

    def displaced(self, released: Mapping[str, Displacement], moved: Mapping[str, Displacement] | None = None) -> Kinematics:
        """The same with further virtual displacements."""
        return ProbedKinematics(self.graph, self.symbols, self.algebra, self.dependents, {**self.released, **released},
                                {**self.moved, **(moved or {})}, moved_values=self.moved_values,
                                moved_coordinates=self.moved_coordinates)


def _with_symbols(k: ProbedKinematics, symbols: Symbols) -> ProbedKinematics:
    return ProbedKinematics(k.graph, symbols, k.algebra, k.dependents, k.released, k.moved,
                            moved_values=k.moved_values, moved_coordinates=k.moved_coordinates)


def _displaced(s: ca.SX, rate: ca.SX, second: ca.SX, level: int) -> Scalar:
    return (s, Dual(s, rate), Dual(Dual(s, rate), Dual(rate, second)))[level]


def _added(value: Value, probe: tuple[Value, Value, Value], level: int) -> Value:
    if isinstance(value, tuple):
        return tuple(_added(x, parts, level) for x, parts in zip(value, zip(*probe, strict=True), strict=True))
    return _displaced(*probe, level) + value


# -------------------------------------------------------------------- names


def find_probes(kinematics: Kinematics, constraints: Constraints, names: Sequence[str]) -> tuple[Probe, ...]:
    """The excitations of these names, vectors by their elements. Raises LagError L0701, L0717."""
    return tuple(probe for name in names for probe in _find(kinematics, constraints, name.strip()))


def usual_probes(kinematics: Kinematics) -> tuple[Probe, ...]:
    """The declared inputs, and all variables and frames whose own formula mentions time."""
    model = kinematics.graph.model
    found, rates = [], rate_inputs(model)
    for variable in model.variables.values():
        driven = variable.kind not in ("parameter", "coordinate", "input") and variable.binding is not None \
            and not variable.is_output and any(isinstance(node, Time) for node in nodes(variable.binding))
        if variable.kind in ("input", "held"):
            found += [] if variable.name in rates else _elements(kinematics, variable.name)
        elif driven:
            probes = _elements(kinematics, variable.name)
            values = scalars_of(kinematics.evaluator.variable(variable.name, 0, variable.span))
            found += [p for p, x in zip(probes, values, strict=True) if ca.depends_on(ca.SX(x), kinematics.symbols.time)]
    return (*found, *_moving_frames(kinematics))


def _moving_frames(kinematics: Kinematics) -> list[Probe]:
    """The places of frames whose own equation mentions time."""
    found, t = list[Probe](), kinematics.symbols.time
    if kinematics.graph.model.space.is_spatial:
        return found  # unprobed: these are told
    for edge in kinematics.graph.edges:
        if _is_timed(edge):
            above, here = kinematics.pose(edge.parent, 0), kinematics.pose(edge.child, 0)
            found += [Probe(f"{edge.child}.{part.name}", "frame", edge.child, k, part.unit)
                      for k, (part, x, y) in enumerate(zip(COMPONENTS, here.place, above.place, strict=True))
                      if ca.depends_on(ca.SX(x), t) and not ca.depends_on(ca.SX(y), t)]
    return found


def _is_timed(edge: Edge) -> bool:
    return any(isinstance(node, Time) for step in edge.steps for node in nodes(step.amount))


def unprobed(kinematics: Kinematics) -> tuple[str, ...]:
    """A word for what moves frames in space, and is none of the usual excitations."""
    names = [edge.child for edge in kinematics.graph.edges if _is_timed(edge)]
    if not (names and kinematics.graph.model.space.is_spatial):
        return ()
    return (f"what moves {', '.join(names[:4])} is not among the excitations: not supported yet in space",)


def _find(kinematics: Kinematics, constraints: Constraints, name: str) -> list[Probe]:
    model = kinematics.graph.model
    inner = [f"{name}.{port}" for port in _PORTS if f"{name}.{port}" in model.variables]
    if name not in model.variables and inner:
        name = inner[0]
    node = observe(model, name)
    if isinstance(node, FrameRef):
        return [_frame(kinematics, node, name)]
    if not isinstance(node, Ref):
        fail("L0717", f"'{name}' follows from the motion, so it cannot excite it", None, _what_excites(kinematics))
    variable = model.variables[node.name]
    if variable.kind == "parameter":
        fail("L0717", f"'{name}' is a parameter, it does not change in time", variable.span, _what_excites(kinematics))
    if variable.kind == "coordinate":
        return [_coordinate(kinematics, name)]
    return [p for p in _elements(kinematics, node.name) if p.name == name or not node.index]


def _elements(kinematics: Kinematics, name: str) -> list[Probe]:
    variable = kinematics.graph.model.variables[name]
    value = kinematics.evaluator.variable(name, 0, variable.span)
    return [Probe(label, "variable", name, k, variable.unit) for k, (label, _) in enumerate(scalars(name, value))]


def _coordinate(kinematics: Kinematics, name: str) -> Probe:
    dependent = kinematics.dependents.get(name)
    variable = kinematics.graph.model.variables[name]
    if dependent is None or dependent.terms:
        fail("L0717", f"'{name}' moves as it likes: nothing prescribes it, so it cannot excite", variable.span,
             "let a force act on it, or prescribe it with a Motion", _what_excites(kinematics))
    return Probe(name, "coordinate", name, 0, variable.unit)


def _frame(kinematics: Kinematics, node: FrameRef, name: str) -> Probe:
    refuse_in_space(kinematics.graph.model, "probes")
    known, children = ATTRIBUTES[node.attribute], {edge.child for edge in kinematics.graph.edges}
    places = known.picked(node.index)
    if known.kind != "place" or len(places) != 1 or node.name not in children:
        fail("L0717", f"'{name}' is no place that could be moved from outside", None,
             f"of a frame that hangs on another one, {node.name}.x, .y or .phi can be", _what_excites(kinematics))
    return Probe(name, "frame", node.name, places[0], known.unit)


def _what_excites(kinematics: Kinematics) -> str:
    known = [p.name for p in usual_probes(kinematics)]
    known += [f"{edge.child}.y" for edge in kinematics.graph.edges if edge.moves_with_time]
    return f"what excites here: {', '.join(known[:8])}" if known else "an input, a load or the motion of a support excites"


# -------------------------------------------------------------------- the kinematics


def probe_kinematics(kinematics: Kinematics, constraints: Constraints, probes: Sequence[Probe], s: Triple) -> ProbedKinematics:
    """`s`: the excitations and their first two derivatives, (k,) each.

    Coordinates that constraints have absorbed are moved so that those still hold: dPhi/dx dx + dPhi/ds s = 0.
    """
    values: dict[str, list[list[Scalar]]] = {}
    for k, probe in enumerate(probes):
        if probe.kind == "variable":
            count = len(_elements(kinematics, probe.of))
            parts = values.setdefault(probe.of, [[0.0] * count for _ in range(3)])
            for part, x in zip(parts, s, strict=True):
                part[probe.element] = x[k]
    shapes = {name: kinematics.graph.model.variables[name].shape for name in values}
    moved = {name: tuple(_nest([ca.SX(x) for x in part], shapes[name]) for part in parts) for name, parts in values.items()}
    released = _released_frames(probes, s)
    first = ProbedKinematics(kinematics.graph, kinematics.symbols, kinematics.algebra, kinematics.dependents, released,
                             moved_values=moved)
    carried = _carried(first, constraints, probes, s)
    return ProbedKinematics(kinematics.graph, kinematics.symbols, kinematics.algebra, kinematics.dependents, released,
                            moved_values=moved, moved_coordinates=carried)


def _released_frames(probes: Sequence[Probe], s: Triple) -> dict[str, Displacement]:
    found: dict[str, Displacement] = {}
    for k, probe in enumerate(probes):
        if probe.kind == "frame":
            moved = found.setdefault(probe.of, (ca.SX.zeros(SIZE), ca.SX.zeros(SIZE), ca.SX.zeros(SIZE)))
            for part, x in zip(moved, s, strict=True):
                part[probe.element] = x[k]
    return found


def _carried(first: ProbedKinematics, constraints: Constraints, probes: Sequence[Probe], s: Triple) -> dict[str, Triple]:
    """What the excitations move of the coordinates that absorbed rows give."""
    names = list(first.dependents)
    if not names or not s[0].numel():
        return {}
    x = ca.SX.sym("shift", len(names))
    nothing = ca.SX.zeros(1)
    free = ProbedKinematics(first.graph, first.symbols, first.algebra, first.dependents, first.released,
                            moved_values=first.moved_values,
                            moved_coordinates={name: (x[k], nothing, nothing) for k, name in enumerate(names)})
    rows = ca.vertcat(*[ca.SX(row.value(free, 0)) for row in constraints.absorbed])
    slopes, pushed = ca.jacobian(rows, x), ca.jacobian(rows, s[0])
    for k, probe in enumerate(probes):
        if probe.kind == "coordinate":
            place = names.index(probe.of)
            driven = [r for r in range(rows.numel()) if slopes[r, place].nnz() and slopes[r, :].nnz() == 1]
            if not driven:
                fail("L0717", f"'{probe.name}' is carried along by other coordinates, so it cannot excite", None,
                     "name the coordinate that is prescribed itself")
            pushed[driven[0], k] = -slopes[driven[0], place]
    if not pushed.nnz():
        return {}
    moved = -ca.solve(ca.densify(slopes), ca.densify(pushed))
    return {name: (moved[k, :] @ s[0], moved[k, :] @ s[1], moved[k, :] @ s[2]) for k, name in enumerate(names)}


def _nest(values: list[ca.SX], shape: tuple[int, ...]) -> Value:
    if not shape:
        return values[0]
    size = len(values) // shape[0]
    return tuple(_nest(values[k * size : (k + 1) * size], shape[1:]) for k in range(shape[0]))
