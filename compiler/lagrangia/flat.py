"""Syntax -> FlatModel: one list of variables, frames, equations and energy terms, with names like `link[2].phi`."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

from lagrangia.algorithms import FlatFunction, flatten_function
from lagrangia.classes import ClassTable
from lagrangia.diagnostics import LagError, Report, Span, fail, suggest
from lagrangia.folding import fold
from lagrangia.instances import Bound, FrameSlot, Instance, Instantiation, Member, Modification, Scope, Slot
from lagrangia.names import FRAME_FUNCTIONS, Names
from lagrangia.tree import (
    Argument,
    Array,
    Boolean,
    Call,
    CallEquation,
    ClassDefinition,
    Clause,
    EnergyKind,
    EnergyTerm,
    Equality,
    Expression,
    Flat,
    ForBlock,
    FrameRef,
    IfBlock,
    Number,
    Ref,
    String,
    WhenBlock,
    WorkTerm,
)

Kind = Literal["parameter", "input", "coordinate", "variable"]


@dataclass(frozen=True)
class Variable:
    """A quantity of the flat model; `shape` is () for a scalar. Values are in SI units."""

    name: str
    kind: Kind
    shape: tuple[int, ...]
    unit: str  # as declared; "" when no unit is known
    display_unit: str
    binding: Flat | None
    start: Flat | None
    is_fixed: bool
    minimum: float | None
    maximum: float | None
    is_output: bool
    description: str
    span: Span

    def elements(self) -> list[tuple[str, tuple[int, ...]]]:
        """Names and indices of the scalars it is made of."""
        indices: list[tuple[int, ...]] = [()]
        for size in self.shape:
            indices = [(*index, i) for index in indices for i in range(1, size + 1)]
        return [(self.name + (f"[{','.join(map(str, i))}]" if i else ""), i) for i in indices]


@dataclass(frozen=True)
class Frame:
    name: str
    is_ground: bool
    starts: Mapping[str, Flat]  # of r, phi, v, w, x, y
    fixed: frozenset[str]
    owner: str  # class of the component whose port it is
    span: Span


@dataclass(frozen=True)
class FrameEquation:
    """left = right, both frame expressions: a frame, or shift(...) and turn(...) of one."""

    left: Flat
    right: Flat
    span: Span


@dataclass(frozen=True)
class Equation:
    left: Flat
    right: Flat
    span: Span


@dataclass(frozen=True)
class Energy:
    """A term of T, V or D."""

    kind: EnergyKind
    value: Flat
    component: str
    span: Span


@dataclass(frozen=True)
class Work:
    """A term of the virtual work: force . delta(position)."""

    force: Flat
    position: Flat
    component: str
    span: Span


@dataclass(frozen=True)
class Experiment:
    start: float = 0.0
    stop: float = 1.0
    tolerance: float = 1e-8
    interval: float | None = None


@dataclass(frozen=True)
class FlatModel:
    name: str
    description: str
    variables: Mapping[str, Variable]
    frames: Mapping[str, Frame]
    frame_equations: tuple[FrameEquation, ...]
    constraints: tuple[Equation, ...]
    energies: tuple[Energy, ...]
    works: tuple[Work, ...]
    initial_equations: tuple[Equation, ...]
    functions: Mapping[str, FlatFunction]
    structural: Mapping[str, float | bool | str]
    experiment: Experiment
    span: Span


def flatten(table: ClassTable, definition: ClassDefinition, structural: Mapping[str, Any] | None = None) -> FlatModel:
    """The flat model of one class. `structural` holds values for its structural parameters.

    Raises LagError with all that is wrong in names, modifications and arrays (L02xx).
    """
    report = Report()
    return _Flattening(table, definition, report).flatten(structural or {})


class _Flattening:
    def __init__(self, table: ClassTable, definition: ClassDefinition, report: Report) -> None:
        self.table, self.definition, self.report = table, definition, report
        self.functions: dict[str, FlatFunction] = {}
        self.names = Names(table, report, self.functions, self._define_function)
        self.variables: dict[str, Variable] = {}
        self.frames: dict[str, Frame] = {}
        self.frame_equations: list[FrameEquation] = []
        self.equations: list[Equation] = []
        self.energies: list[Energy] = []
        self.works: list[Work] = []
        self.initial: list[Equation] = []
        self.structural: dict[str, float | bool | str] = {}

    def flatten(self, overrides: Mapping[str, Any]) -> FlatModel:
        definition = self.definition
        self._require_model()
        root = Instance("", definition, definition.name_span)
        instantiation = Instantiation(self.table, self.names, self.report)
        root = instantiation.instantiate(definition, "", _override_tree(overrides, root), definition.name_span, None)
        self.report.raise_errors()
        self.names.root = root
        self._add_world(root, instantiation)
        self._visit(root)
        bound = self._bind_variables()
        self.report.raise_errors()
        return FlatModel(
            definition.name, definition.description, self.variables, self.frames, tuple(self.frame_equations), bound,
            tuple(self.energies), tuple(self.works), tuple(self.initial), self.functions, self.structural,
            self._experiment(definition.annotation, Scope(root)), definition.name_span,
        )

    def _require_model(self) -> None:
        if self.definition.kind != "model" or self.definition.is_partial:
            what = "partial" if self.definition.is_partial else f"a {self.definition.kind}"
            fail("L0205", f"'{self.definition.name}' is {what}, not a model that can run", self.definition.name_span)

    def _add_world(self, root: Instance, instantiation: Instantiation) -> None:
        if "world" not in root.members:
            world = self.table.library["World"]
            root.members["world"] = instantiation.instantiate(world, "world", Modification(), root.span, root)

    def _define_function(self, name: str, span: Span) -> None:
        if name not in self.functions:
            definition = self.table.function(name, span)
            assert definition is not None
            flatten_function(definition, self.names, self.functions)

    # ------------------------------------------------------------ members

    def _visit(self, instance: Instance) -> None:
        if instance.frame is not None:
            self._add_frame(instance.frame, instance)
        for member in list(instance.members.values()):
            self._visit_member(member, instance)
        for kind, clause in instance.clauses:
            self._clause(kind, clause, Scope(instance))

    def _visit_member(self, member: Member, owner: Instance) -> None:
        if isinstance(member, list):
            for element in member:
                self._visit_member(element, owner)
        elif isinstance(member, Instance):
            self._visit(member)
        elif isinstance(member, FrameSlot):
            self._add_frame(member, owner)
        else:
            self._guard(lambda: self._add_variable(member, owner))

    def _guard(self, action: Any) -> None:
        """Collect what is wrong with one clause or declaration and go on with the next."""
        try:
            action()
        except LagError as error:
            self.report.diagnostics += [d for d in error.diagnostics if d not in self.report.diagnostics]

    def _add_variable(self, slot: Slot, owner: Instance) -> None:
        declaration = slot.declaration
        if slot.is_structural:
            value = self.names.structural_value(slot, declaration.name_span)
            if isinstance(value, Number | Boolean | String):
                self.structural[slot.path] = value.value
            return
        kind = self._kind(slot)
        if slot.binding is None and kind == "parameter":
            self._missing_value(slot, owner)
        if slot.binding is not None and kind == "coordinate":
            fail("L0218", f"the coordinate '{declaration.name}' cannot be bound", slot.binding.expression.span,
                 f"give it a start, {declaration.name}(start = ...), or state an equation")
        binding = self.names.flatten_bound(slot.binding) if slot.binding is not None else None
        start = self.names.flatten_bound(slot.attributes["start"]) if "start" in slot.attributes else None
        self.variables[slot.path] = Variable(
            slot.path, kind, slot.dimensions, self._text(slot, "unit"), self._text(slot, "displayUnit"), binding, start,
            self._flag(slot, "fixed"), self._limit(slot, "min"), self._limit(slot, "max"),
            "output" in declaration.prefixes and owner.parent is None, declaration.description, declaration.name_span,
        )

    def _kind(self, slot: Slot) -> Kind:
        prefixes = slot.declaration.prefixes
        if slot.base in ("Integer", "Boolean", "String") and "parameter" not in prefixes:
            fail("L0219", f"not supported yet: the {slot.base} variable '{slot.declaration.name}'", slot.declaration.name_span,
                 "Integer and Boolean parameters are supported")
        kinds: tuple[Kind, ...] = ("parameter", "coordinate", "input")
        return next((kind for kind in kinds if kind in prefixes), "variable")

    def _missing_value(self, slot: Slot, owner: Instance) -> None:
        name = slot.declaration.name
        if owner.parent is None:
            fail("L0211", f"parameter '{name}' has no value", slot.declaration.name_span, f"write: {name} = ...")
        fail("L0211", f"{owner.definition.name} '{owner.path}' needs a value for its parameter '{name}'", owner.span,
             f"{slot.declaration.description or name}: write {owner.span.text}({name} = ...)")

    def _text(self, slot: Slot, attribute: str) -> str:
        bound = slot.attributes.get(attribute)
        value = self.names.flatten_bound(bound) if bound is not None else None
        if value is not None and not isinstance(value, String):
            fail("L0208", f"'{attribute}' must be a text", value.span)
        return value.value if isinstance(value, String) else ""

    def _limit(self, slot: Slot, attribute: str) -> float | None:
        bound = slot.attributes.get(attribute)
        if bound is None:
            return None
        value = fold(self.names.flatten_bound(bound))
        if value is None or isinstance(value, bool):
            fail("L0208", f"'{attribute}' must be a number", bound.expression.span)
        return float(value)

    def _flag(self, slot: Slot, attribute: str) -> bool:
        bound = slot.attributes.get(attribute)
        return bound is not None and self.names.boolean(bound.expression, bound.scope, f"'{attribute}'")

    def _add_frame(self, slot: FrameSlot, owner: Instance) -> None:
        is_ground = owner.frame is slot and "World" in self.table.ancestors(owner.definition)
        if is_ground and slot.path != "world":
            self.report.error("L0220", f"the World must be called world, at the top of the scene, not '{slot.path}'", slot.span)
        starts = {}
        for name, bound in slot.starts.items():
            self._guard(lambda name=name, bound=bound: starts.update({name: self.names.flatten_bound(bound)}))
        self.frames[slot.path] = Frame(slot.path, is_ground, starts, slot.fixed, owner.definition.name, slot.span)
        if slot.binding is not None:
            self._guard(lambda: self._bind_frame(slot))

    def _bind_frame(self, slot: FrameSlot) -> None:
        assert slot.binding is not None
        value = self.names.flatten_bound(slot.binding)
        span = slot.binding.expression.span
        if not is_frame(value):
            fail("L0221", f"the port '{slot.path}' needs a frame", span,
                 "bind it to a port, as bar.a, or to shift(...), turn(...)")
        self.frame_equations.append(FrameEquation(FrameRef(slot.path, "", (), span), value, span))

    # ------------------------------------------------------------ clauses

    def _clause(self, kind: str, clause: Clause, scope: Scope) -> None:
        self._guard(lambda: self._add_clause(kind, clause, scope))

    def _add_clause(self, kind: str, clause: Clause, scope: Scope) -> None:
        match clause:
            case ForBlock(iterators, body, _):
                for inner in self.names.loop(iterators, scope):
                    for part in body:
                        self._clause(kind, part, inner)
            case IfBlock(condition, then, otherwise, _):
                chosen = then if self.names.boolean(condition, scope, "the condition of an if block") else otherwise
                for part in chosen:
                    self._clause(kind, part, scope)
            case Equality(left, right, _, span) if kind == "initial":
                self.initial.append(Equation(self.names.flatten(left, scope), self.names.flatten(right, scope), span))
            case Equality(left, right, _, span):
                self._add_equation(self.names.flatten(left, scope), self.names.flatten(right, scope), span)
            case CallEquation(call, span):
                self._add_call(call, scope, span)
            case EnergyTerm(what, value, _, span):
                self.energies.append(Energy(what, self.names.flatten(value, scope), scope.instance.path, span))
            case WorkTerm(force, position, _, span):
                flat = self.names.flatten(force, scope), self.names.flatten(position, scope)
                self.works.append(Work(*flat, scope.instance.path, span))
            case WhenBlock(_, _, span):
                fail("L0901", "not supported yet: when (state events)", span)
            case _:
                fail("L0222", "an algorithm belongs into a function", clause.span)

    def _add_equation(self, left: Flat, right: Flat, span: Span) -> None:
        if is_frame(left) != is_frame(right):
            wrong = right if is_frame(left) else left
            fail("L0221", "a frame cannot equal a number", wrong.span, "use shift(frame, {x, y}) or turn(frame, angle)")
        if is_frame(left):
            self.frame_equations.append(FrameEquation(left, right, span))
        else:
            self.equations.append(Equation(left, right, span))

    def _add_call(self, call: Expression, scope: Scope, span: Span) -> None:
        if not isinstance(call, Call):
            fail("L0222", "this is no equation", span, "an equation has a '=' between two expressions")
        if call.function != "connect":
            if call.function in ("assert", "reinit", "terminate"):
                fail("L0901", f"not supported yet: {call.function}", span)
            fail("L0222", f"{call.function}(...) is no equation", span, *filter(None, [suggest(call.function, ["connect"])]))
        if len(call.arguments) != 2:
            fail("L0215", "connect takes two frames", span)
        ends = [self.names.flatten(argument, scope) for argument in call.arguments]
        for end in ends:
            if not is_frame(end):
                fail("L0221", "connect joins frames", end.span)
        self.frame_equations.append(FrameEquation(ends[0], ends[1], span))

    def _bind_variables(self) -> tuple[Equation, ...]:
        """Equations `y = expression` of variables without a binding become their bindings; the others are constraints."""
        constraints = []
        for equation in self.equations:
            for side, other in ((equation.left, equation.right), (equation.right, equation.left)):
                variable = self.variables.get(side.name) if isinstance(side, Ref) and not side.index else None
                if variable is not None and variable.kind == "variable" and variable.binding is None:
                    self.variables[variable.name] = replace(variable, binding=other)
                    break
            else:
                constraints.append(equation)
        for variable in self.variables.values():
            if variable.kind == "variable" and variable.binding is None:
                self.report.error("L0211", f"the variable '{variable.name}' has no value", variable.span,
                                  "bind it, or state an equation for it; a coordinate is declared with `coordinate`")
        return tuple(constraints)

    # ------------------------------------------------------------ experiment

    def _experiment(self, annotation: tuple[Argument, ...], scope: Scope) -> Experiment:
        fields = {"StartTime": "start", "StopTime": "stop", "Tolerance": "tolerance", "Interval": "interval"}
        values: dict[str, float] = {}
        for argument in (a for top in annotation if top.name == "experiment" for a in top.arguments):
            if argument.name not in fields:
                fail("L0208", f"experiment has no '{argument.name}'", argument.span,
                     *filter(None, [suggest(argument.name, fields)]))
            value = fold(self.names.flatten(argument.value, scope)) if argument.value is not None else None
            if value is None or isinstance(value, bool):
                fail("L0208", f"'{argument.name}' must be a number", argument.span)
            values[fields[argument.name]] = float(value)
        experiment = Experiment(**values)
        if not experiment.stop > experiment.start:
            fail("L0208", "StopTime must be later than StartTime", annotation[0].span)
        if not 0 < experiment.tolerance < 1:
            fail("L0208", "Tolerance must lie between 0 and 1", annotation[0].span)
        if experiment.interval is not None and not experiment.interval > 0:
            fail("L0208", "Interval must be positive", annotation[0].span)
        return experiment


def is_frame(node: Flat) -> bool:
    return (isinstance(node, FrameRef) and node.attribute == "") or (isinstance(node, Call) and node.function in FRAME_FUNCTIONS)


def _override_tree(overrides: Mapping[str, Any], root: Instance) -> Modification:
    """{"n": 20, "sub.k": 3} as a tree of modifications."""
    tree: dict[str, Any] = {}
    for name, value in overrides.items():
        *path, last = name.split(".")
        node = tree
        for step in path:
            node = node.setdefault(step, {})
        node[last] = _literal(value, root.span)

    def build(node: Any) -> Modification:
        if isinstance(node, dict):
            return Modification(None, {name: build(inner) for name, inner in node.items()}, is_each=True)
        return Modification(Bound(node, Scope(root)), {}, is_each=True, span=root.span)

    return build(tree)


def _literal(value: Any, span: Span) -> Expression:
    if isinstance(value, bool):
        return Boolean(value, span)
    if isinstance(value, str):
        return String(value, span)
    if isinstance(value, Sequence):
        return Array(tuple(_literal(item, span) for item in value), span)
    return Number(float(value), None, span, float(value).is_integer())
