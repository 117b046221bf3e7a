"""Expressions in a scope -> flat expressions: names resolved, loops unrolled, structural values put in."""

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import field
from functools import reduce
from typing import Any, NoReturn, cast

from lagrangia.base.diagnostics import Diagnostic, Report, Span, TooMuchError, fail, nearest, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.elements import element, length
from lagrangia.language.folding import fold, folded
from lagrangia.language.frame_attributes import ATTRIBUTES, OF_ANY_FRAME, REACTIONS, WORDS, WORDS_OF_ELEMENTS
from lagrangia.language.instances import Bound, FrameSlot, Instance, Member, Scope, Slot, held_port
from lagrangia.language.lookups import Lookup, lookup_of, options_of
from lagrangia.language.suggestions import explain
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    Comprehension,
    Expression,
    Flat,
    FrameRef,
    IfExpression,
    Iterator,
    Number,
    Range,
    Ref,
    Reference,
    String,
    Time,
    Unary,
    Whole,
)
from lagrangia.language.units import Unit, known_units, parse_unit, respelled

# Number of arguments of each function of the kernel; None: any number, at least one.
FUNCTIONS: Mapping[str, tuple[int, ...] | None] = {
    **dict.fromkeys(("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
                     "log", "log10", "sqrt", "abs", "sign", "floor", "ceil", "norm", "der", "pre", "virtual",
                     "contact_force", "constraint_force"), (1,)),
    **dict.fromkeys(("atan2", "mod", "dot", "cross", "distance", "rotate", "shift", "turn"), (2,)),
    "table": (2, 3), "table2": (5,), "min": None, "max": None, "sum": None, "product": None,
}
FRAME_FUNCTIONS = frozenset({"shift", "turn"})
CONSTANTS = {"pi": math.pi}
_ALIASES = {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "ln": "log", "ceiling": "ceil", "pow": "^", "hypot": "norm"}
_EACH_WHOLE = "write `each` before it if every element is to have the whole of it"
_UNIT_BEHIND = "a unit stands behind a literal alone, as in 30[deg]; square brackets behind a name pick an element"
_MOST_ITERATIONS = 100_000  # of one loop
_MOST_PASSES = 300_000  # of all loops of a model, each times the clauses in it: some 10 us each


@dataclass
class Work:
    """How many clauses and elements the loops of a model were unrolled to."""

    passes: int = 0

    def spend(self, count: int, span: Span) -> None:
        """Raises TooMuchError L0209 before more is unrolled than can be looked at in good time."""
        self.passes += count
        if self.passes > _MOST_PASSES:
            what = f"the loops and sums of this model have more than {_MOST_PASSES} passes in all"
            raise TooMuchError([Diagnostic("error", "L0209", what, span, "", ("those inside each other multiply",))])


@dataclass
class Names:
    """Resolves names; what is wrong is raised as LagError, caught and collected clause by clause in flat.py."""

    table: ClassTable
    report: Report
    functions: dict[str, Any]
    define_function: Callable[[str, Span], None] = lambda name, span: None
    root: Instance | None = None
    work: Work = field(default_factory=Work)
    lookups: dict[Lookup, Span] = field(default_factory=dict)  # tables of files, and where they are asked for first
    delays: dict[str, Call[Flat]] = field(default_factory=dict)  # what acts late, by the names of what stands for it
    _structural: dict[str, Flat] = field(default_factory=dict)
    _pending: list[str] = field(default_factory=list)
    _dealt: dict[tuple[int, int], tuple[Bound, Flat]] = field(default_factory=dict)

    # ------------------------------------------------------------ structural values

    def integer(self, expression: Expression, scope: Scope, what: str) -> int:
        """The integer that an expression must be. Raises LagError L0210."""
        value = self._constant(expression, scope, what)
        if isinstance(value, bool) or not float(value).is_integer():
            fail("L0210", f"{what} must be an integer, not {value}", expression.span)
        return int(value)

    def boolean(self, expression: Expression, scope: Scope, what: str) -> bool:
        """The truth value that an expression must be. Raises LagError L0210."""
        value = self._constant(expression, scope, what)
        if not isinstance(value, bool):
            fail("L0210", f"{what} must be true or false", expression.span)
        return value

    def _constant(self, expression: Expression, scope: Scope, what: str) -> float | bool:
        value = fold(self.flatten(expression, scope))
        if value is None:
            fail("L0210", f"{what} must be known when the scene is compiled", expression.span,
                 "use numbers, constants and Integer or Boolean parameters")
        return value

    def structural_value(self, slot: Slot, span: Span) -> Flat:
        """The folded value of a constant or of an Integer, Boolean or String parameter. Raises LagError L0210 to L0212."""
        if slot.path in self._structural:
            return self._structural[slot.path]
        if slot.binding is None:
            fail("L0211", f"'{slot.path}' has no value", slot.declaration.name_span, f"it is needed at {span}")
        if slot.path in self._pending:
            fail("L0212", f"'{slot.path}' depends on itself", slot.declaration.name_span, " > ".join([*self._pending, slot.path]))
        self._pending.append(slot.path)
        try:
            value = folded(self.flatten_bound(slot.binding))
        finally:
            self._pending.pop()
        if value is None:
            fail("L0210", f"'{slot.path}' must be known when the scene is compiled", slot.binding.expression.span,
                 "it is structural (Integer, Boolean or constant): use numbers and structural values")
        self._check_kind(slot, value)
        self._structural[slot.path] = value
        return value

    def _check_kind(self, slot: Slot, value: Flat) -> None:
        items = value.items if isinstance(value, Array) else (value,)
        wanted = {"Integer": "an integer", "Boolean": "true or false", "String": "a text"}.get(slot.base, "a number")
        for item in items:
            good = {"Integer": isinstance(item, Number) and item.value.is_integer(), "Boolean": isinstance(item, Boolean),
                    "String": isinstance(item, String)}.get(slot.base, isinstance(item, Number | Array))
            if not good:
                what = f", not {item.value:g}" if isinstance(item, Number) else ""
                fail("L0210", f"'{slot.path}' must be {wanted}{what}", value.span)

    # ------------------------------------------------------------ expressions

    def flatten_bound(self, bound: Bound, shape: tuple[int, ...] = ()) -> Flat:
        """`shape` is of what it is bound to. Raises LagError L0213."""
        flat = self._flatten_dealt(bound) if bound.selection else self.flatten(bound.expression, bound.scope)
        for index, size in bound.selection:
            flat = self._deal(flat, index, size, shape)
        if bound.selection and shape and length(flat, self._size) is None:
            fail("L0213", f"one number for an array of {shape[0]}, of every component", bound.expression.span, _EACH_WHOLE)
        return flat

    def _flatten_dealt(self, bound: Bound) -> Flat:
        """The whole of an array that is dealt out to many elements, flattened when the first of them asks."""
        key = id(bound.expression), id(bound.scope)
        if key not in self._dealt:
            self._dealt[key] = bound, self.flatten(bound.expression, bound.scope)  # bound is kept, and so its ids stay its own
        return self._dealt[key][1]

    def _deal(self, flat: Flat, index: int, size: int, shape: tuple[int, ...]) -> Flat:
        found = length(flat, self._size)
        if found is None:
            fail("L0213", "one value for an array of components", flat.span,
                 "write `each` before it to give it to every element, or give an array")
        if found != size:
            hints = [_EACH_WHOLE] if shape[:1] == (found,) else []
            fail("L0213", f"{found} values for an array of {size}", flat.span, *hints)
        return element(flat, index, self._size)

    def _size(self, ref: Ref) -> int | None:
        member = self._find(ref.name)
        is_array = isinstance(member, Slot) and len(member.dimensions) > len(ref.index)
        return cast(Slot, member).dimensions[len(ref.index)] if is_array else None

    def _find(self, path: str) -> Member | None:
        member: Member | None = self.root
        for step in path.replace("[", ".[").split("."):
            if isinstance(member, list):
                member = reduce(lambda inner, i: inner[int(i) - 1], step[1:-1].split(","), cast(Any, member))
            else:
                member = member.members.get(step) if isinstance(member, Instance) else None
        return member

    def flatten(self, node: Expression, scope: Scope) -> Flat:
        """An expression with full names, in SI units, its structural values put in. Raises LagError."""
        match node:
            case Number():
                return _in_si(node)
            case Boolean() | String():
                return node
            case Reference():
                return self.resolve(node, scope)
            case Unary(operator, operand, span):
                inner = self.flatten(operand, scope)
                if operator == "+":
                    return inner
                if isinstance(inner, Number):
                    return Number(-inner.value, inner.unit, span, inner.is_integer)
                return Unary(operator, inner, span)
            case Binary(operator, left, right, span):
                return Binary(operator, self.flatten(left, scope), self.flatten(right, scope), span)
            case IfExpression():
                return self._choose(node, scope)
            case Call():
                return self._call(node, scope)
            case Array(items, span):
                return Array(tuple(self.flatten(item, scope) for item in items), span)
            case Comprehension(function, body, iterators, span):
                array = Array(tuple(self.flatten(body, inner) for inner in self.loop(iterators, scope)), span)
                return self._checked_call(Call(function, (array,), (), span)) if function else array
            case Range():
                values = self._range(node, scope)
                return Array(tuple(Number(float(v), None, node.span, True) for v in values), node.span)
            case Whole(span):
                fail("L0214", "':' stands only in subscripts", span)

    def _choose(self, node: IfExpression[Expression], scope: Scope) -> Flat:
        condition = self.flatten(node.condition, scope)
        known = fold(condition)
        if isinstance(known, bool):
            return self.flatten(node.then if known else node.otherwise, scope)
        then, otherwise = self.flatten(node.then, scope), self.flatten(node.otherwise, scope)
        return IfExpression(condition, then, otherwise, node.span)

    def _call(self, node: Call[Expression], scope: Scope) -> Flat:
        if node.function in ("connect", "assert", "reinit"):
            fail("L0215", f"{node.function}(...) is an equation, not a value", node.span)
        if node.function == "sample":
            fail("L0215", "sample(...) is a condition of its own", node.span,
                 "write: when sample(0, 0.01) then u = ...; end when;")
        arguments = tuple(self.flatten(a, scope) for a in node.arguments)
        named = tuple((name, self.flatten(a, scope)) for name, a in node.named)
        if node.function in scope.instance.members and self.table.function(node.function, node.span) is None:
            fail("L0204", f"'{node.function}' is no function", node.span,
                 f"elements are picked with square brackets: {node.function}[1]")
        call = Call(node.function, arguments, named, node.span)
        if node.function == "delay" and self.table.function("delay", node.span) is None:
            name = f"delay({len(self.delays) + 1})"
            self.delays[name] = call
            return Ref(name, (), node.span)
        return self._checked_call(call)

    def _checked_call(self, node: Call[Flat]) -> Call[Flat]:
        if self.table.function(node.function, node.span) is not None:
            self.define_function(node.function, node.span)
            function = self.functions[node.function]
            return Call(node.function, function.arrange(node), (), node.span)
        if node.function not in FUNCTIONS:
            user = [name for name, c in {**self.table.library, **self.table.user}.items() if c.kind == "function"]
            hint = f"it is called '{_ALIASES[node.function]}' here" if node.function in _ALIASES else suggest(
                node.function, [*FUNCTIONS, *user])
            fail("L0204", f"there is no function '{node.function}'", node.span, *filter(None, [hint]))
        if node.function == "table" and (node.named or len(node.arguments) == 2):
            return self._table(node)
        if node.named:
            fail("L0215", f"{node.function} takes no named arguments", node.span)
        wanted, given = FUNCTIONS[node.function], len(node.arguments)
        if given == 0 or (wanted is not None and given not in wanted):
            count = " or ".join(map(str, wanted)) if wanted else "at least 1"
            fail("L0215", f"{node.function} takes {count} argument{'s' if count[-1] != '1' else ''}, not {given}", node.span)
        return node

    def _table(self, node: Call[Flat]) -> Call[Flat]:
        """Of a file, or of points with options. Raises LagError L0215."""
        if len(node.arguments) == 3:
            options_of(node)
        elif len(node.arguments) == 2:
            self.lookups.setdefault(lookup_of(node), node.arguments[1].span)
        else:
            fail("L0215", f"table takes 2 or 3 arguments, not {len(node.arguments)}, and options by name", node.span)
        return node

    # ------------------------------------------------------------ loops

    def loop(self, iterators: tuple[Iterator, ...], scope: Scope, size: int = 1) -> Iterable[Scope]:
        """The scopes of all passes of a loop over so many clauses, the last iterator running fastest. Raises LagError
        L0209, L0214."""
        scopes = [scope]
        for iterator in iterators:
            if iterator.range is None:
                fail("L0214", f"the range of '{iterator.name}' is missing", iterator.span, "write: for i in 1:n")
            passes: list[Scope] = []
            for outer in scopes:
                passes += [outer.bind(iterator.name, value) for value in self._values(iterator.range, outer)]
                if len(passes) > _MOST_ITERATIONS:
                    fail("L0209", f"a loop of more than {_MOST_ITERATIONS} passes", iterator.span)
            scopes = passes
        self.work.spend(len(scopes) * size, iterators[0].span)
        return scopes

    def _values(self, node: Expression, scope: Scope) -> list[int]:
        if isinstance(node, Range):
            return self._range(node, scope)
        if isinstance(node, Array):
            return [self.integer(item, scope, "a loop's value") for item in node.items]
        fail("L0214", "a loop runs over a range or a list of integers", node.span, "write: for i in 1:n")

    def _range(self, node: Range, scope: Scope) -> list[int]:
        start, stop = (self.integer(e, scope, "the end of a range") for e in (node.start, node.stop))
        step = self.integer(node.step, scope, "the step of a range") if node.step is not None else 1
        if step == 0 or (stop - start) // step > _MOST_ITERATIONS:
            fail("L0209", f"a range of more than {_MOST_ITERATIONS} values", node.span)
        return list(range(start, stop + (1 if step > 0 else -1), step))

    # ------------------------------------------------------------ references

    def resolve(self, node: Reference, scope: Scope) -> Flat:
        """What a name stands for where it is written. Raises LagError."""
        first = node.parts[0]
        if first.name in scope.iterators and len(node.parts) == 1 and not first.subscripts:
            return Number(float(scope.iterators[first.name]), None, node.span, True)
        member = scope.instance.members.get(first.name)
        if member is None:
            if first.name == "time" or first.name in CONSTANTS or first.name in scope.iterators:
                self._require_plain(node)
            if first.name == "time":
                return Time(node.span)
            if first.name in CONSTANTS:
                return Number(CONSTANTS[first.name], "1", node.span)
            if first.name == "world" and self.root is not None:
                member = self.root.members.get("world")
        if member is None:
            self._unknown(node, scope)
        return self._follow(node, 0, member, scope)

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
        subscripts = [self._subscript(s, scope, member, k) for k, s in enumerate(part.subscripts)]
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
                return FrameRef(member.path, "", (), node.span)
            fail("L0216", f"'{node}' is a component ({member.definition.name}), not a value", node.span,
                 _ports(member))
        inner = member.members.get(rest[0].name)
        if rest[0].name in member.protected:
            owner = member.definition.name
            fail("L0228", f"'{rest[0].name}' of {owner} is protected: only {owner} and what extends it may name it", rest[0].span,
                 "declare it before `protected`, or after `public`, if others may read it")
        if inner is None:
            if member.frame is not None and rest[0].name in OF_ANY_FRAME:
                return self._frame(node, at + 1, member.frame, scope)
            if rest[0].name in REACTIONS and held_port(_frames(member)) is not None:
                return self._reaction(node, at + 1, member, scope)
            self._no_member(member, rest[0].name, rest[0].span)
        return self._follow(node, at + 1, inner, scope)

    def _variable(self, slot: Slot, subscripts: list[int | list[int]], span: Span) -> Flat:
        if len(subscripts) > len(slot.dimensions):
            fail("L0214", f"'{slot.declaration.name}' has {len(slot.dimensions)} dimensions, not {len(subscripts)}", span)
        for subscript, size in zip(subscripts, slot.dimensions, strict=False):
            for pick in [subscript] if isinstance(subscript, int) else subscript:
                if not 1 <= pick <= size:
                    fail("L0214", f"'{slot.declaration.name}' has {size} elements, not {pick}", span)
        if slot.is_structural:
            return _pick(self.structural_value(slot, span), subscripts)

        def build(index: tuple[int, ...], left: list[int | list[int]]) -> Flat:
            if not left:
                return Ref(slot.path, index, span)
            if isinstance(left[0], int):
                return build((*index, left[0]), left[1:])
            return Array(tuple(build((*index, i), left[1:]) for i in left[0]), span)

        return build((), subscripts)

    def _frame(self, node: Reference, at: int, frame: FrameSlot, scope: Scope) -> Flat:
        if at == len(node.parts):
            return FrameRef(frame.path, "", (), node.span)
        part = node.parts[at]
        if part.name not in OF_ANY_FRAME or at + 1 < len(node.parts):
            wrong = part if part.name not in OF_ANY_FRAME else node.parts[at + 1]
            fail("L0216", f"a frame has no '{wrong.name}'", wrong.span, WORDS)
        index = tuple(self.integer(s, scope, "a subscript") for s in part.subscripts)
        if not ATTRIBUTES[part.name].has_element(index):
            fail("L0214", f"'{part.name}' of a frame has no element {list(index)}", part.span, WORDS_OF_ELEMENTS)
        return FrameRef(frame.path, part.name, index, node.span)

    def _reaction(self, node: Reference, at: int, joint: Instance, scope: Scope) -> Flat:
        """`hinge.reaction`: the force of a joint on its held port, b of a and b; `hinge.reaction_torque`."""
        part, port = node.parts[at], joint.members[held_port(_frames(joint)) or ""]
        if not isinstance(port, FrameSlot) or at + 1 < len(node.parts):
            self._no_member(joint, part.name, part.span)
        index = tuple(self.integer(s, scope, "a subscript") for s in part.subscripts)
        if not ATTRIBUTES[part.name].has_element(index):
            fail("L0214", f"'{part.name}' has no element {list(index)}", part.span)
        return FrameRef(port.path, part.name, index, node.span)

    def _subscript(self, node: Expression, scope: Scope, member: Member, dimension: int) -> int | list[int]:
        if isinstance(node, Whole):
            size = len(member) if isinstance(member, list) else member.dimensions[dimension] if isinstance(member, Slot) else 0
            return list(range(1, size + 1))
        if isinstance(node, Range | Array):
            return self._values(node, scope)
        return self.integer(node, scope, "a subscript")

    def _unknown(self, node: Reference, scope: Scope) -> NoReturn:
        first = node.parts[0]
        known = {*scope.instance.members, *scope.iterators, "time", "world"}
        hints = [suggest(first.name, known)]
        if first.name in scope.instance.absent:
            hints = ["its condition is false, so it is not there"]
        elif scope.instance.parent is not None and first.name in scope.instance.parent.members:
            hints.append(f"'{first.name}' belongs to {scope.instance.parent.definition.name}: pass it in a modification")
        where = scope.instance.definition.name
        fail("L0204", f"'{first.name}' is not known in {where}", first.span, *filter(None, hints))

    def _no_member(self, instance: Instance, name: str, span: Span) -> NoReturn:
        if name in instance.absent:
            fail("L0204", f"'{name}' is not there: its condition is false", span)
        what = f"{instance.definition.name} '{instance.path}'"
        if name in REACTIONS:
            joints = [str(slot.binding.expression).rpartition(".")[0] for slot in instance.members.values()
                      if isinstance(slot, Slot) and slot.binding is not None and isinstance(slot.binding.expression, Reference)]
            driven = next((f": {joint}.reaction, {joint}.reaction_torque" for joint in joints if joint), "")
            own = [f"what it takes is {instance.path}.reaction, a force along what it moves, or a torque"]
            fail("L0216", f"{what} has no {name}", span, "components with two ports have one; what acts on the coordinate of a "
                 f"joint is in the reaction of the joint{driven}",
                 *(own if "reaction" in instance.members else ()))
        fail("L0216", f"{what} has no member '{name}'", span, *explain(self.table, instance.definition, name))


def _ports(instance: Instance) -> str:
    frames = [name for name, member in instance.members.items() if isinstance(member, FrameSlot)]
    return f"its ports are {', '.join(frames)}" if frames else "name one of its variables"


def _pick(value: Flat, subscripts: list[int | list[int]]) -> Flat:
    for subscript in subscripts:
        assert isinstance(value, Array)
        if isinstance(subscript, int):
            value = value.items[subscript - 1]
        else:
            value = Array(tuple(value.items[i - 1] for i in subscript), value.span)
    return value


def read_unit(text: str, span: Span) -> Unit:
    """Raises LagError L0301."""
    try:
        return parse_unit(text)
    except ValueError as error:
        near = nearest(text, known_units()) or ""
        near = near if near.lower() == text.lower() else respelled(text) or near
        habit = "units are written as in the SI: m, mm, kg, kN/m, deg, rad/s, N.m"
        fail("L0301", str(error), span, f"did you mean '{near}'?" if near else habit)


def _in_si(node: Number) -> Number:
    if node.unit is None:
        return node
    unit = read_unit(node.unit, node.span)
    return Number(node.value * unit.factor + unit.offset, node.unit, node.span, False)


def _frames(instance: Instance) -> list[str]:
    """The names of a component's own frames, as declared."""
    return [name for name, member in instance.members.items() if isinstance(member, FrameSlot)]
