"""Classes -> FlatModel: instances are made, names resolved, loops and ifs unrolled."""

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import partial
from typing import Any

from lagrangia.base.diagnostics import Diagnostic, LagError, Report, Span, TooMuchError, fail
from lagrangia.language.algorithms import Functions
from lagrangia.language.alike_elements import Alike
from lagrangia.language.array_connections import joined_elements
from lagrangia.language.assertions import guard_of
from lagrangia.language.attitudes import ROTATION
from lagrangia.language.attributes import display_unit_of, unit_of
from lagrangia.language.call_equations import refuse_call
from lagrangia.language.chosen_equations import chosen_of
from lagrangia.language.classes import ClassTable
from lagrangia.language.connections import Bindings, Connection, bound_to, connected, find_repeated, flanges_of, require_bindings
from lagrangia.language.delays import check_delays, declare_delays, variable_of, with_delays
from lagrangia.language.discrete import as_numbers, signals_of
from lagrangia.language.discrete_arrays import dealt_out, dealt_sides, is_dealt_out
from lagrangia.language.drawing_words import figure_of
from lagrangia.language.event_clauses import EventClauses
from lagrangia.language.experiments import allowed_of, experiment_of, find_rivals
from lagrangia.language.flat import (
    Energy,
    Equation,
    Figure,
    FlatModel,
    Frame,
    FrameEquation,
    State,
    Variable,
    When,
    Work,
    is_frame,
)
from lagrangia.language.hinge_angles import hinge_angles
from lagrangia.language.idle import find_idle
from lagrangia.language.instances import (
    DISCRETE_TYPES,
    FrameSlot,
    Instance,
    Member,
    Modification,
    Scope,
    Slot,
    is_absent,
    outside,
)
from lagrangia.language.instantiation import Instantiation
from lagrangia.language.kept_components import KeptComponents, KeptScene
from lagrangia.language.left_out_text import find_unknown_names
from lagrangia.language.limits import (
    flag_of,
    has_annotation,
    kind_of,
    read_limit,
    refuse_missing,
    require_within,
)
from lagrangia.language.mentions import leaves
from lagrangia.language.moving_inputs import with_moving_inputs
from lagrangia.language.names import Names
from lagrangia.language.open_flanges import find_open_flanges
from lagrangia.language.other_starts import with_other_starts
from lagrangia.language.overrides import override_tree
from lagrangia.language.samplers import check_held, declare_held
from lagrangia.language.short_vectors import find_short_vectors
from lagrangia.language.space_values import fitted, is_inertia, least_of
from lagrangia.language.spaces import Found, FoundSpaceError
from lagrangia.language.stamps import stamp
from lagrangia.language.states import find_states, mechanics_of, refuse_states_elsewhere
from lagrangia.language.tree import (
    Array,
    Boolean,
    Call,
    CallEquation,
    ClassDefinition,
    Clause,
    EnergyTerm,
    Equality,
    Expression,
    Field,
    Flat,
    ForBlock,
    FrameRef,
    IfBlock,
    Number,
    Ref,
    Result,
    Results,
    String,
    WhenBlock,
    WorkTerm,
)
from lagrangia.language.truths import NO, number_of
from lagrangia.language.unread import find_unread
from lagrangia.language.without_effect import find_without_effect

_MOMENTS = {"initial": "an initial equation", "when": "an event", "sample": "a value that is held"}


def flatten(table: ClassTable, definition: ClassDefinition, structural: Mapping[str, Any] | None = None,
            kept: KeptScene | None = None) -> FlatModel:
    """The flat model of one class. `structural` holds values for its structural parameters, `kept` what was made of it before.

    Raises LagError with all that is wrong in names, modifications and arrays (L02xx).
    """
    def flattened(found: Found) -> FlatModel:
        before = kept.within(found.space) if kept is not None else None
        return _Flattening(table, definition, Report(), found).flatten(structural or {}, before)

    try:
        return flattened(Found())
    except FoundSpaceError as left:
        return flattened(left.found)


class _Flattening:
    def __init__(self, table: ClassTable, definition: ClassDefinition, report: Report, found: Found) -> None:
        self.table, self.definition, self.report, self.found = table, definition, report, found
        self.functions = Functions()
        self.names = self.functions.names = Names(table, report, self.functions.define, space=found.space)
        self.variables: dict[str, Variable] = {}
        self.frames: dict[str, Frame] = {}
        self.frame_equations: list[FrameEquation] = []
        self.equations: list[Equation] = []
        self.joined: list[Equation] = []  # signals, by connect
        self.repeats: dict[int, object] = {}
        self.frames_joined: set[tuple[int, int]] = set()  # connect(a, b) of frames, by the ids of calls and instances
        self.connections: list[Connection] = []
        self.ends: set[str] = set()  # variables of connectors
        self.inputs: set[str] = set()  # of components
        self.energies: list[Energy] = []
        self.works: list[Work] = []
        self.initial: list[Equation] = []
        self.whens: list[When] = []
        self.figures: list[Figure] = []
        self.guards = self.names.guards
        self.at_rest: Span | None = None  # initial equation equilibrium();
        self.events = EventClauses(self.names, report, self._clause)
        self.structural: dict[str, float | bool | str] = {}
        self.components: dict[str, str] = {}
        self.flanges: dict[str, str] = {}
        self.states: Mapping[str, State] = {}

    def flatten(self, overrides: Mapping[str, Any], kept: KeptComponents | None) -> FlatModel:
        definition = self.definition
        self._require_model()
        root = Instance("", definition, definition.name_span)
        instantiation = Instantiation(self.table, self.names, self.report, before=kept)
        self.names.make_package = instantiation.constants_of
        root = instantiation.instantiate(definition, "", override_tree(overrides, root), definition.name_span, None)
        self.report.raise_errors()
        self._add_world(root, instantiation)
        self._visit(root, self._visit_member if kept is None else self._once(kept))
        self.report.add(find_unknown_names(root, self.table, self.names).diagnostics)
        delays = declare_delays(self.names.delays, self.report)
        self.report.raise_errors()
        self.variables.update({delay.name: variable_of(delay) for delay in delays.values()})
        self.variables.update(hinge_angles(self))
        bound = self._bind_variables()
        find_repeated(self.connections, self.table.library_sources, self.report)
        self.report.raise_errors()
        model = FlatModel(
            definition.name, definition.description, self.variables, self.frames, tuple(self.frame_equations), bound,
            tuple(self.energies), tuple(self.works), tuple(self.initial), tuple(self.whens), self.functions.flat,
            self.structural,
            experiment_of(self.table, definition, self.names, Scope(root)), definition.name_span, (), tuple(self.figures),
            self.states, self.names.lookups, samplers=tuple(self.events.samplers), constants=tuple(self.names.written.values()),
            guards=tuple(dict.fromkeys(self.guards)),
            at_rest=self.at_rest, allowed=allowed_of(self.table, definition), components=self.components, found=self.found,
            repeats=self.repeats, flanges=self.flanges, connections=tuple((c.a, c.b) for c in self.connections),
        )
        model = with_delays(model, delays)
        for check in (refuse_states_elsewhere, check_held, check_delays):
            check(model, self.report)
        self.report.raise_errors()
        looks = (find_unread, find_idle, find_open_flanges, find_without_effect, find_short_vectors)
        found = (d for look in looks for d in look(model, root, self.table).diagnostics)
        rivals = find_rivals(self.table, definition, self.names, Scope(root))
        warnings = (*self.report.diagnostics, *found, *rivals.diagnostics)
        return with_moving_inputs(with_other_starts(replace(model, warnings=warnings)))

    def _require_model(self) -> None:
        if self.definition.kind not in ("model", "block") or self.definition.is_partial:
            what = "partial" if self.definition.is_partial else f"a {self.definition.kind}"
            fail("L0205", f"'{self.definition.name}' is {what}, not a model that can run", self.definition.name_span)

    def _add_world(self, root: Instance, instantiation: Instantiation) -> None:
        world = root.members.get("world")
        if world is None:
            ground = self.table.library["World"]
            root.members["world"] = instantiation.instantiate(ground, "world", Modification(), root.span, root)
        elif not (isinstance(world, Instance) and self._is_world(world)):
            place = self.table.declared(root.definition)["world"].name_span
            fail("L0220", "the name 'world' belongs to the ground", place,
                 "declare it as World world(...), or choose another name")

    def _is_world(self, instance: Instance) -> bool:
        return any(base.name == "World" for base in self.table.lineage(instance.definition))

    def _place(self, span: Span, owner: Instance | None) -> Span:
        """Where people look for what is declared at `span`: for the inside of a library component, its declaration."""
        return outside(self.table, span, owner)

    # ------------------------------------------------------------ members

    def _once(self, kept: KeptComponents) -> Callable[[Member, Instance], None]:
        """Visits members of the scene, or adds what they brought before."""
        kept.visits.begin()

        def visit(member: Member, root: Instance) -> None:
            if (declaration := kept.declared.get(id(member))) is None:
                self._visit_member(member, root)
            else:
                kept.visits.visit(self, root, member, declaration, partial(self._visit_member, member, root))

        return visit

    def _visit(self, instance: Instance, visit: Callable[[Member, Instance], None]) -> None:
        if instance.description:
            self.components[instance.path] = instance.description
        if instance.frame is not None:
            self._add_frame(instance.frame, instance)
        if instance.definition.kind == "connector":
            self.ends |= {member.path for member in instance.members.values() if isinstance(member, Slot)}
            self.flanges.update(flanges_of(self.table, instance))
            self._guard(lambda: self.connections.extend(bound_to(instance, self.names)), instance)
        for name, member in list(instance.members.items()):
            if name not in instance.outer:
                visit(member, instance)
        for kind, clause in instance.clauses:
            self._clause(kind, clause, Scope(instance))

    def _visit_member(self, member: Member, owner: Instance) -> None:
        if isinstance(member, list):
            visit = partial(self._visit_member, owner=owner)
            for element in stamp(self, member, visit) if isinstance(member, Alike) else member:
                visit(element)
        elif isinstance(member, Instance):
            self._visit(member, self._visit_member)
        elif isinstance(member, FrameSlot):
            self._add_frame(member, owner)
        else:
            self._guard(lambda: self._add_variable(member, owner), owner, member)

    def _guard(self, action: Any, owner: Instance, slot: Slot | None = None) -> None:
        """Collect what is wrong with one clause or declaration of an instance and go on with the next."""
        try:
            action()
        except FoundSpaceError as left:
            raise left.placed(lambda span: self._place(span, owner)) from None
        except TooMuchError as error:
            raise TooMuchError(self._placed(d, owner) for d in error.diagnostics) from None
        except LagError as error:
            self.report.add(self._placed(d, owner, slot) for d in error.diagnostics)

    def _placed(self, found: Diagnostic, owner: Instance, slot: Slot | None = None) -> Diagnostic:
        """What was found in a line of the library, where people gave it what it is wrong for; the line is a hint."""
        if found.span is None or (place := self._place(found.span, owner)) == found.span:
            return found
        name = slot.declaration.name if slot is not None and kind_of(slot) == "variable" else ""
        return found.placed(place, f", as the usual '{name}': another can be given, {name} = ..." if name else "")

    def _add_variable(self, slot: Slot, owner: Instance) -> None:
        declaration = slot.declaration
        if slot.is_structural:
            value = self.names.structural_value(slot, declaration.name_span)
            require_within(self.names, slot, value)
            if isinstance(value, Number | Boolean | String):
                self.structural[slot.path] = value.value
            return
        kind = kind_of(slot)
        if kind == "input" and owner.parent is not None:
            kind = "variable"  # of a component: what it is connected or bound to, or else one of the scene
            self.inputs.add(slot.path)
        if slot.binding is None and kind == "parameter":
            refuse_missing(self.table, slot, owner)
        if slot.binding is not None and kind == "coordinate":
            fail("L0218", f"the coordinate '{declaration.name}' cannot be bound", slot.binding.expression.span,
                 f"give it a start, {declaration.name}(start = ...), or state an equation")
        binding = self.names.flatten_bound(slot.binding, slot.dimensions) if slot.binding is not None else None
        if binding is not None and (declaration.dimensions or declaration.annotation):
            binding = self.fitted(binding, slot)
        start = self.names.flatten_bound(slot.attributes["start"]) if "start" in slot.attributes else None
        if slot.base == "Boolean":
            binding, start = (value and number_of(value, NO) for value in (binding, start))
        made = Variable(
            slot.path, kind, slot.dimensions, unit_of(slot.attributes, self.names.flatten_bound),
            display_unit_of(slot.attributes, self.names.flatten_bound), binding, start,
            flag_of(self.names, slot, "fixed"), least_of(slot, read_limit(self.names, slot, "min")),
            read_limit(self.names, slot, "max"),
            "output" in declaration.prefixes and _is_of_scene(owner), declaration.description,
            self._place(declaration.name_span, owner), kind == "parameter" and has_annotation(declaration, "Evaluate"),
            kind == "parameter" and has_annotation(declaration, "Varying"),
            "final" if slot.is_final else "protected" if "protected" in declaration.prefixes else "",
            kind == "coordinate" and declaration.type_name == ROTATION, is_inertia(slot),
            slot.base if slot.base in DISCRETE_TYPES else "Real",
        )
        parts = [*dealt_out(made, self.names.size)] if is_dealt_out(slot) else [made]
        self.variables |= {part.name: part for part in parts}
        if slot.base in DISCRETE_TYPES:
            self.events.declare(parts)

    def fitted(self, value: Flat, slot: Slot) -> Flat:
        """What a variable is bound to, as the space has it."""
        return fitted(value, slot, self.found.space, self.names.size)

    def _add_frame(self, slot: FrameSlot, owner: Instance) -> None:
        is_ground = owner.frame is slot and self._is_world(owner)
        if is_ground and slot.path != "world":
            self.report.error("L0220", f"the World must be called world, at the top of the scene, not '{slot.path}'", slot.span)
        starts = {}
        for name, bound in slot.starts.items():
            self._guard(lambda name=name, bound=bound: starts.update({name: self.names.flatten_bound(bound)}), owner)
        place = self._place(slot.span, owner)
        self.frames[slot.path] = Frame(slot.path, is_ground, starts, slot.fixed, owner.definition.name, place)
        if slot.binding is not None:
            self._guard(lambda: self.frame_equations.append(self.bound_frame(slot)), owner)

    def bound_frame(self, slot: FrameSlot) -> FrameEquation:
        """The equation of a port that is given a frame. Raises LagError L0221."""
        assert slot.binding is not None
        value = self.names.flatten_bound(slot.binding)
        span = slot.binding.expression.span
        if not is_frame(value):
            fail("L0221", f"the port '{slot.path}' needs a frame", span,
                 "bind it to a port, as bar.a, or to shift(...), turn(...)")
        frame = FrameRef(slot.path, "", (), span, self.found.space.is_spatial)
        return FrameEquation(frame, value, self._place(span, slot.owner))

    # ------------------------------------------------------------ clauses

    def _clause(self, kind: str, clause: Clause, scope: Scope) -> None:
        self.names.moment = _MOMENTS.get(kind, "")
        self._guard(lambda: self._add_clause(kind, clause, scope), scope.instance)
        self.names.moment = ""

    def _add_clause(self, kind: str, clause: Clause, scope: Scope) -> None:
        place = self._place(clause.span, scope.instance)
        match clause:
            case ForBlock(iterators, body, _):
                for inner in self.names.loop(iterators, scope, body):
                    for part in body:
                        self._clause(kind, part, inner)
            case IfBlock():
                for part in chosen_of(clause, kind, scope, self.names):
                    self._clause(kind, part, scope)
            case Equality():
                self._add_equality(kind, clause, scope, place)
            case CallEquation() | WhenBlock() if kind == "sample":
                fail("L0222", "what is held from an instant on is said by u = ...", clause.span)
            case CallEquation(call, _) if kind == "when":
                self.events.add_call(call, scope, place)
            case CallEquation(call, _) if kind == "drawing":
                self.figures.append(figure_of(call, scope, place, self.names))
            case CallEquation(Call("equilibrium", arguments, named, _), _) if kind == "initial" and not arguments and not named:
                self.at_rest = self.at_rest or place
            case CallEquation(call, _):
                self._add_call(call, scope, place)
            case EnergyTerm(what, value, _, _):
                of_library = clause.span.source in self.table.library_sources
                self.energies.append(Energy(what, self.names.flatten(value, scope), scope.instance.path, place, of_library))
            case WorkTerm(force, position, _, _):
                flat = self.names.flatten(force, scope), self.names.flatten(position, scope)
                self.works.append(Work(*flat, scope.instance.path, place))
            case WhenBlock() if kind == "equation":
                self.events.add(clause, scope, place)
            case _:
                fail("L0222", "an algorithm belongs into a function", clause.span,
                     "write equations, y = ...; or call a function that has the algorithm")

    def _add_equality(self, kind: str, clause: Equality, scope: Scope, place: Span) -> None:
        left, right = clause.left, clause.right
        if isinstance(left, Results):
            for k, item in enumerate(left.items):
                if item is not None:
                    self._clause(kind, Equality(item, Result(right, k, right.span), "", clause.span), scope)
            return
        if fields := self.names.fields(left, scope) or self.names.fields(right, scope):
            for name in fields:
                self._clause(kind, Equality(Field(left, name, left.span), Field(right, name, right.span), "", clause.span), scope)
            return
        whole = as_numbers(left, self.names.flatten(left, scope), self.names.flatten(right, scope))
        for sides in dealt_sides(*whole, self.names.size) if kind == "when" or self.events.are_of(whole[0]) else [whole]:
            if kind in ("when", "sample"):
                self.events.assign(kind, *sides, place)
            elif kind == "initial":
                self.initial.append(Equation(*sides, place))
            else:
                self._add_equation(*sides, scope.instance.path, place)

    def _add_equation(self, left: Flat, right: Flat, component: str, span: Span) -> None:
        if is_frame(left) != is_frame(right):
            wrong = right if is_frame(left) else left
            fail("L0221", "a frame cannot equal a number", wrong.span, "use shift(frame, {x, y}) or turn(frame, angle)")
        if is_frame(left):
            self.frame_equations.append(FrameEquation(left, right, span))
        else:
            self.equations.append(Equation(left, right, span, component))

    def _add_call(self, call: Expression, scope: Scope, span: Span) -> None:
        if not isinstance(call, Call):
            fail("L0222", "this is no equation", span, "an equation has a '=' between two expressions")
        if call.function != "connect":
            if call.function == "assert":
                self.guards += guard_of(call, scope, span, self.names, self.report, self.events.whole)
                return
            refuse_call(call, span)
        if len(call.arguments) != 2:
            fail("L0215", f"connect takes two frames, not {len(call.arguments)}", span, "write: connect(a, b)")
        key = id(call), id(scope.instance)  # elements of arrays are of one class: what they have is the same in all passes
        if key not in self.frames_joined:
            if any(is_absent(argument, scope) for argument in call.arguments):
                return  # to a component that is not there nothing is connected
            if elements := joined_elements(call, scope, self.names):
                for one in elements:
                    self._clause("equation", CallEquation(one, one.span), scope)
                return
            if (between := connected(call, scope, span, self.names)) is not None:
                self.connections += between
                return
        a, b = signals_of(call.arguments, [self.names.flatten(argument, scope) for argument in call.arguments], span)
        if all(isinstance(end, Ref) for end in (a, b)):
            self.joined.append(Equation(a, b, span, scope.instance.path))
            return
        for end in (a, b):
            if not is_frame(end):
                each = ["element by element: for i in 1:n loop connect(a[i], b[i]); end for;"] if isinstance(end, Array) else []
                fail("L0221", "connect joins frames, or signals, this is none", end.span, *each,
                     "a frame is a port, as bar.a, or shift(...) or turn(...) of one; a signal is a variable")
        self.frames_joined.add(key)
        self.frame_equations.append(FrameEquation(a, b, span))

    def _bind_variables(self) -> tuple[Equation, ...]:
        """Equations `y = expression` of variables without a binding become their bindings; the others are constraints."""
        self.variables.update(declare_held(self.events.samplers, self.variables, self.report))
        discrete = self.events.finish(self.variables, self.equations)
        self.variables.update(discrete.variables)
        self.whens = discrete.whens
        self.equations += discrete.equations
        self.initial += discrete.initial
        mechanics = mechanics_of(self.energies, self.works, self.frame_equations, self.whens, self.variables)
        found = find_states(self.variables, [*self.equations, *self.joined], self.ends, mechanics, self.report)
        self.states = found.states
        self.variables.update(found.variables)
        self.energies += found.energies
        self.works += found.works
        bindings = Bindings(self.variables, frozenset(self.ends))
        constraints = bindings.take(found.equations)
        if not self.report.errors:
            constraints += bindings.connect(self.connections)
        self.variables = bindings.with_inputs(self.inputs)
        if not self.report.errors:  # an equation that is wrong may have been meant to give the value
            require_bindings(self.variables, constraints, self.report)
        self._let_vary()
        return tuple(constraints)

    def _let_vary(self) -> None:
        """What may vary and is bound to what does so, is a variable."""
        bindings = {name: variable.binding for name, variable in self.variables.items()}
        kinds = ("coordinate", "input", "held", "delayed")
        moving = {name for name, variable in self.variables.items() if variable.kind in kinds}
        for name, variable in self.variables.items():
            if variable.may_vary and variable.binding is not None and any(
                    not isinstance(leaf, Ref) or leaf.name in moving for leaf in leaves([variable.binding], bindings)):
                self.variables[name] = replace(variable, kind="variable")


def _is_of_scene(owner: Instance) -> bool:
    """Whether what belongs to it is the scene's own: also what its records are made of."""
    while owner.definition.kind == "record" and owner.parent is not None:
        owner = owner.parent
    return owner.parent is None
