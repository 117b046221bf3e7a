"""Expressions in a scope -> flat expressions: names resolved, loops unrolled, structural values put in."""

from collections.abc import Callable
from dataclasses import field, replace
from typing import Any, cast

from lagrangia.base.diagnostics import Report, Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.attributes import constant_of, in_declared_unit, is_bare, is_literal
from lagrangia.language.calls import Calls
from lagrangia.language.classes import ClassTable
from lagrangia.language.discrete_arrays import referred
from lagrangia.language.element_references import ElementReference, element_reference
from lagrangia.language.elements import element, length
from lagrangia.language.enumerations import literal_named, ordinal_of, subscripts_of
from lagrangia.language.flat import Guard, Variable
from lagrangia.language.folding import fold, folded
from lagrangia.language.frame_attributes import PLANE, REACTIONS, SPATIAL_ONLY, Space, frame_shape
from lagrangia.language.frame_words import attribute_of
from lagrangia.language.function_variables import Built, Given
from lagrangia.language.functions import CONSTANTS, DIMENSIONS
from lagrangia.language.instances import Bound, FrameSlot, Instance, Member, Scope, Slot, held_port
from lagrangia.language.kinds import require_kind
from lagrangia.language.known_calls import MadeFunctions
from lagrangia.language.lookups import Lookup
from lagrangia.language.loops import Work
from lagrangia.language.matrices import EACH, each, matrix_power, product, shape_of, side_by_side
from lagrangia.language.missing_names import ports_of, refuse_member, refuse_name
from lagrangia.language.texts import joined
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    ClassDefinition,
    Comprehension,
    EnumerationLiteral,
    Expression,
    Field,
    Flat,
    FrameRef,
    IfExpression,
    Last,
    Made,
    Matrix,
    Number,
    Range,
    Ref,
    Reference,
    Result,
    Results,
    String,
    Time,
    Unary,
    Whole,
)
from lagrangia.language.units_written import in_si

_EACH_WHOLE = "write `each` before it if every element is to have the whole of it"
_UNIT_BEHIND = "a unit stands behind a literal alone, as in 30[deg]; square brackets behind a name pick an element"


@dataclass
class Names(Calls):
    """Resolves names; what is wrong is raised as LagError, caught and collected clause by clause in flat.py."""

    table: ClassTable
    report: Report
    define: Callable[[ClassDefinition, Given, Span], Built]
    make_package: Callable[[ClassDefinition], Instance] | None = None  # an instance of constants alone
    root: Instance | None = None
    space: Space = PLANE
    work: Work = field(default_factory=Work)
    made: MadeFunctions = field(default_factory=MadeFunctions)
    lookups: dict[Lookup, Span] = field(default_factory=dict)  # tables of files, and where they are asked for first
    delays: dict[str, Call[Flat]] = field(default_factory=dict)  # what acts late, by the names of what stands for it
    turned: dict[str, Call[Flat]] = field(default_factory=dict)  # angles of hinges, by the names of what stands for them
    packages: dict[str, Instance] = field(default_factory=dict)  # of the constants of each
    guards: list[Guard] = field(default_factory=list)  # what has to hold in a run
    written: dict[str, Variable] = field(default_factory=dict)  # constants and limits that are no bare literals
    under: list[Flat] = field(default_factory=list)
    inside: tuple[str, ...] = ("",)  # how full names begin in the component that is visited
    asked: int = 0  # how often there was asked for what is not its own alone: values that are put in, and what is made once
    moment: str = ""
    _structural: dict[Slot, Flat] = field(default_factory=dict)
    _pending: list[str] = field(default_factory=list)
    _arrays: dict[str, Slot] = field(default_factory=dict)  # variables that were named as arrays
    _dealt: dict[tuple[int, int], tuple[Bound, Flat]] = field(default_factory=dict)
    _elements: dict[tuple[int, int], ElementReference] = field(default_factory=dict)  # by the ids of nodes and instances

    def define_function(self, definition: ClassDefinition, given: Given, span: Span) -> Built:
        """The function for what a call gives it. Raises LagError for one that is wrong."""
        self.asked += 1
        return self.define(definition, given, span)

    def begin(self, root: Instance) -> None:
        """Names are looked up in an instance whose members are being made."""
        self.root = root

    # ------------------------------------------------------------ structural values

    def integer(self, expression: Expression, scope: Scope, what: str, hint: str = "") -> int:
        """The integer that an expression must be. Raises LagError L0210."""
        value = self.number(expression, scope, what)
        if not value.is_integer():
            fail("L0210", f"{what} must be an integer, not {value:g}", expression.span, *filter(None, [hint]))
        return int(value)

    def number(self, expression: Expression, scope: Scope, what: str) -> float:
        """The number that an expression must be. Raises LagError L0210."""
        value = self._constant(expression, scope, what)
        if isinstance(value, bool):
            fail("L0210", f"{what} must be a number, not {str(value).lower()}", expression.span)
        return float(value)

    def boolean(self, expression: Expression, scope: Scope, what: str, *hints: str) -> bool:
        """The truth value that an expression must be. Raises LagError L0210."""
        value = self._constant(expression, scope, what, *hints)
        if not isinstance(value, bool):
            fail("L0210", f"{what} must be true or false", expression.span)
        return value

    def is_known(self, expression: Expression, scope: Scope) -> bool:
        """Whether an expression is a number, or true or false, when the scene is compiled. Raises LagError."""
        return fold(self.made.with_known_calls(self.flatten(expression, scope), self.work)) is not None

    def _constant(self, expression: Expression, scope: Scope, what: str, *hints: str) -> float | bool:
        value = fold(self.made.with_known_calls(self.flatten(expression, scope), self.work))
        if value is None:
            fail("L0210", f"{what} must be known when the scene is compiled", expression.span,
                 "use numbers, constants and Integer or Boolean parameters", *hints)
        return value

    def structural_value(self, slot: Slot, span: Span) -> Flat:
        """The folded value of a constant or of an Integer, Boolean or String parameter. Raises LagError L0210 to L0212."""
        self.asked += not self._is_own(slot)
        if slot in self._structural:
            return self._structural[slot]
        if slot.binding is None:
            fail("L0211", f"'{slot.path}' has no value", slot.declaration.name_span, f"it is needed at {span}")
        if slot.path in self._pending:
            fail("L0212", f"'{slot.path}' depends on itself", slot.declaration.name_span, " > ".join([*self._pending, slot.path]))
        self._pending.append(slot.path)
        try:
            flat = self.flatten_bound(slot.binding, slot.dimensions)
            value = folded(self.made.with_known_calls(flat, self.work))
        finally:
            self._pending.pop()
        if value is None:
            fail("L0210", f"'{slot.path}' must be known when the scene is compiled", slot.binding.expression.span,
                 "it is structural (Integer, Boolean or constant): use numbers and structural values")
        require_kind(slot, value)
        constant = constant_of(slot, flat, self.flatten_bound)
        if slot.dimensions or not is_bare(flat):
            self.written[slot.path] = constant
        self._structural[slot] = value = in_declared_unit(value, constant.unit if slot.base == "Real" else "")
        return value

    def _is_own(self, slot: Slot) -> bool:
        """Whether its value is a literal in the component that is visited, and noted there if it is to be."""
        if slot.binding is None or not (slot.path.startswith(self.inside) and is_literal(slot.binding.expression)):
            return False
        return slot not in self._structural or slot.path in self.written or is_bare(slot.binding.expression)

    # ------------------------------------------------------------ expressions

    def flatten_bound(self, bound: Bound, shape: tuple[int, ...] = ()) -> Flat:
        """`shape` is of what it is bound to. Raises LagError L0213."""
        flat = self._flatten_dealt(bound) if bound.selection else self.flatten(bound.expression, bound.scope)
        if bound.is_each and shape_of(flat, self.size) == shape:
            return flat
        for index, size in bound.selection:
            flat = self._deal(flat, index, size, shape)
        if bound.selection and shape and length(flat, self.size) is None:
            fail("L0213", f"one number for an array of {shape[0]}, of every component", bound.expression.span, _EACH_WHOLE)
        return flat

    def _flatten_dealt(self, bound: Bound) -> Flat:
        """The whole of an array that is dealt out to many elements, flattened when the first of them asks."""
        key = id(bound.expression), id(bound.scope)
        if key not in self._dealt:
            self._dealt[key] = bound, self.flatten(bound.expression, bound.scope)  # bound is kept, and so its ids stay its own
        return self._dealt[key][1]

    def _deal(self, flat: Flat, index: int, size: int, shape: tuple[int, ...]) -> Flat:
        found = length(flat, self.size)
        if found is None:
            fail("L0213", "one value for an array of components", flat.span,
                 "write `each` before it to give it to every element, or give an array")
        if found != size:
            hints = [_EACH_WHOLE] if shape[:1] == (found,) else []
            fail("L0213", f"{found} values for an array of {size}", flat.span, *hints)
        return element(flat, index, self.size)

    def known(self, bound: Bound) -> Expression | None:
        """The value of what is bound, where it is known when the scene is compiled."""
        return cast("Expression | None", folded(self.made.with_known_calls(self.flatten_bound(bound), self.work)))

    def shape(self, bound: Bound) -> tuple[int, ...]:
        """The sizes of what is bound."""
        return shape_of(self.flatten_bound(bound), self.size)

    def size(self, ref: Ref) -> int | None:
        """Of the next dimension of a variable; None where it has none."""
        slot = self._arrays.get(ref.name)
        return slot.dimensions[len(ref.index)] if slot is not None and len(slot.dimensions) > len(ref.index) else None

    def flatten(self, node: Expression, scope: Scope) -> Flat:
        """An expression with full names, in SI units, its structural values put in. Raises LagError."""
        match node:  # what stands most often comes first
            case Reference():
                return self._in_pass(node, scope) if scope.iterators else self.resolve(node, scope)
            case Number():
                return in_si(node)
            case Boolean() | String() | EnumerationLiteral():
                return node
            case Unary(operator, operand, span):
                inner = self.flatten(operand, scope)
                if operator == "+":
                    return inner
                if isinstance(inner, Number):
                    return Number(-inner.value, inner.unit, span, inner.is_integer)
                return Unary(operator, inner, span)
            case Binary(operator, left, right, span):
                return self._operated(operator, self.flatten(left, scope), self.flatten(right, scope), span)
            case IfExpression():
                return self.choose(node, scope)
            case Matrix(rows, span):
                return side_by_side([[self.flatten(item, scope) for item in row] for row in rows], self.size, span)
            case Last(span):
                return self._last(scope, span)
            case Call():
                return self.call(node, scope)
            case Array(items, span):
                return Array(tuple(self.flatten(item, scope) for item in items), span)
            case Comprehension():
                return self._comprehended(node, scope)
            case Range():
                values = self._range(node, scope)
                return Array(tuple(Number(float(v), None, node.span, True) if isinstance(v, int) else v for v in values),
                             node.span)
            case Field() | Result() | Made():
                return self._field(node, scope) if isinstance(node, Field) else self.result(node, scope)
            case Results(_, span):
                fail("L0302", "several results are taken by an equation of their own", span, "write: (a, b) = f(x);")
            case Whole(span):
                fail("L0214", "':' stands only in subscripts", span)

    def _comprehended(self, node: Comprehension, scope: Scope) -> Flat:
        """{e for i in r, j in s} is {{e for i in r} for j in s}."""
        body, iterators = node.body, node.iterators
        if not node.function and len(iterators) > 1:
            body, iterators = Comprehension("", body, iterators[:-1], node.span), iterators[-1:]
        array = Array(tuple(self.flatten(body, inner) for inner in self.loop(iterators, scope, (node.body,))), node.span)
        return self.checked_call(Call(node.function, (array,), (), node.span)) if node.function else array

    def _operated(self, operator: str, left: Flat, right: Flat, span: Span) -> Flat:
        """Products of matrices, and what is done element after element, are written out; the rest is left to the evaluator."""
        if operator == "+" and (isinstance(left, String) or isinstance(right, String)):
            return joined(left, right, span)
        if operator in EACH:
            return each(operator, left, right, self.size, span)
        if operator == "*" and (self._is_matrix(left) or self._is_matrix(right)):
            return product(left, right, self.size, span, self.work)
        if operator == "^" and self._is_matrix(left):
            return matrix_power(left, right, self.size, span, self.work)
        return Binary(operator, left, right, span)

    def _is_matrix(self, node: Flat) -> bool:
        match node:
            case Array(items, _):
                return any(length(item, self.size) is not None for item in items[:1])
            case Ref(name, index, _):
                slot = self._arrays.get(name)
                return slot is not None and len(slot.dimensions) > len(index) + 1
            case FrameRef() if node.attribute:
                return len(frame_shape(node)) == 2
            case Unary("-", operand, _) | Call("der", (operand,), _, _):
                return self._is_matrix(operand)
            case Binary("+" | "-", left, right, _) | IfExpression(_, left, right, _):
                return self._is_matrix(left) or self._is_matrix(right)
            case Binary("/", left, _, _):
                return self._is_matrix(left)
        return False

    # ------------------------------------------------------------ records

    def fields(self, node: Expression, scope: Scope) -> list[str]:
        """The names of what a record has that a name stands for; none for anything else."""
        if (found := self.own_of(node)) is not None:
            return self.fields_of_result(*found)
        if not isinstance(node, Reference):
            return []
        member: Any = scope.instance.members.get(node.parts[0].name)
        for part in node.parts[1:]:
            while isinstance(member, list) and member:
                member = member[0]
            member = member.members.get(part.name) if isinstance(member, Instance) else None
        while isinstance(member, list) and member:
            member = member[0]
        return list(member.members) if isinstance(member, Instance) and member.definition.kind == "record" else []

    def _field(self, node: Field, scope: Scope) -> Flat:
        found = self.field_of_result(node, scope)
        return self.flatten(self.part(node.record, node.name, node.span), scope) if found is None else found

    def _last(self, scope: Scope, span: Span) -> Flat:
        size = scope.iterators.get("end")
        if not isinstance(size, int):
            fail("L0214", "'end' stands only in subscripts", span)
        return Number(float(size), None, span, True)

    # ------------------------------------------------------------ references

    def _in_pass(self, node: Reference, scope: Scope) -> Flat:
        """What a name stands for in one of the passes of a loop."""
        key = id(node), id(scope.instance)
        known = self._elements.get(key)
        if known is not None and (again := known.at(scope.iterators)) is not None:
            self.work.spend(len(known.sizes), node.parts[0].span)
            return again
        found = self.resolve(node, scope)
        if known is None and (new := element_reference(node, scope, found, self.integer)) is not None:
            self._elements[key] = new
        return found

    def resolve(self, node: Reference, scope: Scope) -> Flat:
        """What a name stands for where it is written. Raises LagError."""
        first = node.parts[0]
        if first.name in scope.iterators and len(node.parts) == 1 and not first.subscripts:
            value = scope.iterators[first.name]
            return Number(float(value), None, node.span, True) if isinstance(value, int) else value
        member = scope.instance.members.get(first.name)
        if member is None:
            if first.name == "time" or first.name in CONSTANTS or first.name in scope.iterators:
                self._require_plain(node)
            if first.name == "time":
                return Time(node.span)
            if first.name in CONSTANTS:
                return Number(CONSTANTS[first.name], "1", node.span)
            if first.name == DIMENSIONS:
                return Number(float(self.space.dimensions), None, node.span, True)
            if first.name == "world" and self.root is not None:
                member = self.root.members.get("world")
        if member is None:
            return self._of_class(node, scope)
        return self._follow(node, 0, member, scope)

    def _of_class(self, node: Reference, scope: Scope) -> Flat:
        """A constant of a package, or a value of an enumeration. Raises LagError L0204."""
        for k in range(len(node.parts) - 1, 0, -1):
            if not any(part.subscripts for part in node.parts[:k]):
                name = ".".join(part.name for part in node.parts[:k])
                definition = self.table.found(name, node.span)
                if definition is not None and definition.kind != "function":
                    return self._in_class(node, k, definition, scope)
        if self.table.function(str(node), node.span) is not None:
            fail("L0901", "not supported yet: a function as a value", node.span, f"call it: {node}(x)")
        if node.span.source in self.table.files and (found := self.table.scopes.constant(node.parts[0].name, node.span)):
            renamed = replace(node, parts=(replace(node.parts[0], name=found[1]), *node.parts[1:]))
            return self._in_class(renamed, 0, found[0], scope)
        refuse_name(node, scope)

    def _in_class(self, node: Reference, at: int, definition: ClassDefinition, scope: Scope) -> Flat:
        part = node.parts[at]
        if definition.literals:
            rest = "" if part.subscripts else ".".join(p.name for p in node.parts[at:])
            return replace(literal_named(definition, rest, part.span), span=node.span)
        declared = self.table.declared(definition)
        constants = [e.name for e in declared.values() if "constant" in e.prefixes]
        if part.name not in constants:
            self.table.refuse_circle(definition)
            what = f"'{part.name}' of {definition.name} is no constant" if part.name in declared else (
                f"{definition.name} has no constant '{part.name}'")
            fail("L0204", what, part.span, suggest(part.name, constants) or
                 "a package has constants: constant Real k = 2;")
        if definition.name not in self.packages:
            assert self.make_package is not None
            self.packages[definition.name] = self.make_package(definition)
        return self._follow(node, at, self.packages[definition.name].members[part.name], scope)

    def _require_plain(self, node: Reference) -> None:
        """`time`, `pi` and the variable of a loop are numbers: no part of them can be picked, and no unit be put behind them."""
        first, *rest = node.parts
        if rest:
            fail("L0216", f"'{first.name}' is a number and has no '{rest[0].name}'", rest[0].span)
        if first.subscripts:
            fail("L0214", f"'{first.name}' is a number, not an array", node.span, _UNIT_BEHIND)

    def _follow(self, node: Reference, at: int, member: Member, scope: Scope) -> Flat:
        """Goes down the dotted name; arrays of components without subscripts make arrays of what follows."""
        part = node.parts[at]
        if part.subscripts and isinstance(member, Slot) and not member.dimensions:
            fail("L0214", f"'{part.name}' is a number, not an array", node.span, _UNIT_BEHIND)
        subscripts = [self.picks(s, scope, member, k) for k, s in enumerate(part.subscripts)]
        return self._index(node, at, member, subscripts, scope)

    def _index(self, node: Reference, at: int, member: Member, subscripts: list[int | list[int]], scope: Scope) -> Flat:
        part, rest = node.parts[at], node.parts[at + 1 :]
        if isinstance(member, list):
            head, tail = (subscripts[0], subscripts[1:]) if subscripts else (list(range(1, len(member) + 1)), [])
            picks = [head] if isinstance(head, int) else head
            for pick in picks:
                if not 1 <= pick <= len(member):
                    fail("L0214", f"'{part.name}' has {len(member)} elements, not {pick}", part.span)
            if scope.iterators:
                self.work.spend(len(picks), part.span)
            items = [self._index(node, at, member[pick - 1], tail, scope) for pick in picks]
            return items[0] if isinstance(head, int) else Array(tuple(items), node.span)
        if isinstance(member, Slot):
            if rest:
                fail("L0216", f"'{part.name}' is a number and has no '{rest[0].name}'", rest[0].span,
                     f"its rate is der({part.name})")
            return self._variable(member, subscripts, node.span)
        if subscripts:
            fail("L0214", f"'{part.name}' is not an array", part.span)
        if isinstance(member, FrameSlot):
            return self._frame(node, at + 1, member, scope)
        if not rest:
            if member.frame is not None:
                return FrameRef(member.path, "", (), node.span, self.space.is_spatial)
            fail("L0216", f"'{node}' is a component ({member.definition.name}), not a value", node.span,
                 ports_of(member))
        inner = member.members.get(rest[0].name)
        if rest[0].name in member.protected:
            owner = member.definition.name
            fail("L0228", f"'{rest[0].name}' of {owner} is protected: only {owner} and what extends it may name it", rest[0].span,
                 "declare it before `protected`, or after `public`, if others may read it")
        if inner is None:
            if member.frame is not None and rest[0].name in self.space.of_any_frame | SPATIAL_ONLY | self.space.missing.keys():
                return self._frame(node, at + 1, member.frame, scope)
            if rest[0].name in REACTIONS and held_port(_frames(member)) is not None:
                return self._reaction(node, at + 1, member, scope)
            refuse_member(self.table, member, rest[0].name, rest[0].span)
        return self._follow(node, at + 1, inner, scope)

    def _variable(self, slot: Slot, subscripts: list[int | list[int]], span: Span) -> Flat:
        if len(subscripts) > len(slot.dimensions):
            fail("L0214", f"'{slot.declaration.name}' has {len(slot.dimensions)} dimensions, not {len(subscripts)}", span)
        for subscript, size in zip(subscripts, slot.dimensions, strict=False):
            for pick in [subscript] if isinstance(subscript, int) else subscript:
                if not 1 <= pick <= size:
                    fail("L0214", f"'{slot.declaration.name}' has {size} elements, not {pick}", span)
        if slot.is_structural:
            return replace(_pick(self.structural_value(slot, span), subscripts), span=span)
        if len(subscripts) < len(slot.dimensions):
            self._arrays[slot.path] = slot
        return referred(slot, subscripts, span)

    def _frame(self, node: Reference, at: int, frame: FrameSlot, scope: Scope) -> Flat:
        if at == len(node.parts):
            return FrameRef(frame.path, "", (), node.span, self.space.is_spatial)
        part = node.parts[at]
        index = tuple(self.integer(s, scope, "a subscript") for s in part.subscripts)
        found = attribute_of(self.space, frame.path, part, index, node.span)
        if at + 1 < len(node.parts):
            wrong = node.parts[at + 1]
            fail("L0216", f"a frame has no '{wrong.name}'", wrong.span, self.space.words)
        return found

    def _reaction(self, node: Reference, at: int, joint: Instance, scope: Scope) -> Flat:
        """`hinge.reaction`: the force of a joint on its held port, b of a and b; `hinge.reaction_torque`."""
        part, port = node.parts[at], joint.members[held_port(_frames(joint)) or ""]
        if not isinstance(port, FrameSlot) or at + 1 < len(node.parts):
            refuse_member(self.table, joint, part.name, part.span)
        index = tuple(self.integer(s, scope, "a subscript") for s in part.subscripts)
        if not self.space.attributes[part.name].has_element(index):
            fail("L0214", f"'{part.name}' has no element {list(index)}", part.span)
        return FrameRef(port.path, part.name, index, node.span, self.space.is_spatial)

    def picks(self, node: Expression, scope: Scope, member: Member, dimension: int) -> int | list[int]:
        """Which elements of a member a subscript means. Raises LagError L0210."""
        if isinstance(node, Whole):
            size = len(member) if isinstance(member, list) else member.dimensions[dimension] if isinstance(member, Slot) else 0
            return list(range(1, size + 1))
        if isinstance(member, list) or (isinstance(member, Slot) and dimension < len(member.dimensions)):
            scope = scope.bind("end", len(member) if isinstance(member, list) else member.dimensions[dimension])
        if isinstance(node, Range | Array):
            return subscripts_of(self._values(node, scope), node.span)
        if isinstance(node, Reference | Comprehension) and isinstance(picked := self.flatten(node, scope), Array):
            return subscripts_of(picked.items, node.span)
        if isinstance(node, Reference | Boolean | Call | IfExpression) and (k := ordinal_of(self.flatten(node, scope))):
            return k
        return self.integer(node, scope, "a subscript")


def _pick(value: Flat, subscripts: list[int | list[int]]) -> Flat:
    for subscript in subscripts:
        assert isinstance(value, Array)
        if isinstance(subscript, int):
            value = value.items[subscript - 1]
        else:
            value = Array(tuple(value.items[i - 1] for i in subscript), value.span)
    return value


def _frames(instance: Instance) -> list[str]:
    """The names of a component's own frames, as declared."""
    return [name for name, member in instance.members.items() if isinstance(member, FrameSlot)]
