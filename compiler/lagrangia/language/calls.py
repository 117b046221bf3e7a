"""Calls of functions: of the kernel, of arrays, and people's own."""

from dataclasses import replace
from typing import NoReturn, Protocol

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.attitudes import ATTITUDES
from lagrangia.language.classes import ClassTable
from lagrangia.language.component_sizes import OF_SIZES, shape_of_components, with_sizes
from lagrangia.language.elements import element, length
from lagrangia.language.enumerations import literal_numbered
from lagrangia.language.foreign_words import FOREIGN_CALLS, function_meant
from lagrangia.language.frame_attributes import ANGLE, Space
from lagrangia.language.frame_words import FRAME_WORDS, frame_call
from lagrangia.language.function_calls import OwnCalls
from lagrangia.language.functions import FUNCTIONS, REWRITTEN, SCALAR_FUNCTIONS
from lagrangia.language.hinge_angles import HINGE_ANGLE, frames_of, name_of
from lagrangia.language.instances import Scope
from lagrangia.language.lookups import Lookup, lookup_of, options_of, plane_of
from lagrangia.language.loops import Loops
from lagrangia.language.matrices import ARRAY_FUNCTIONS as OF_ARRAYS
from lagrangia.language.matrices import cross_of_three
from lagrangia.language.record_parts import default_of, made_part
from lagrangia.language.requirements import Requirements
from lagrangia.language.texts import text_of
from lagrangia.language.tree import (
    Array,
    Binary,
    Call,
    Comprehension,
    Expression,
    Field,
    Flat,
    FrameRef,
    IfExpression,
    Made,
    Part,
    Ref,
    Reference,
    Result,
)

ARRAY_FUNCTIONS = {**OF_ARRAYS, **ATTITUDES}


class Calls(Loops, Requirements, OwnCalls, Protocol):
    """What names.py does with calls."""

    table: ClassTable
    space: Space
    lookups: dict[Lookup, Span]
    delays: dict[str, Call[Flat]]
    turned: dict[str, Call[Flat]]
    asked: int

    def call(self, node: Call[Expression], scope: Scope) -> Flat:
        """A call with its arguments flattened. Raises LagError L0204, L0215."""
        if node.function in ("connect", "assert", "reinit"):
            fail("L0215", f"{node.function}(...) is an equation, not a value", node.span)
        if (last := node.function.rpartition(".")[2]) in FOREIGN_CALLS and self.table.found(node.function, node.span) is None:
            fail("L0901", f"not of this language: {node.function}(...)", node.span, FOREIGN_CALLS[last])
        if node.function == "sample":
            fail("L0215", "sample(...) is a condition of its own", node.span,
                 "write: when sample(0, 0.01) then u = ...; end when;")
        if (kernel := self.table.scopes.of_kernel(node.function, node.span)) is not None:
            node = replace(node, function=kernel)
        elif (own := self.table.function(node.function, node.span)) is not None:
            return self.own_call(node, own, scope)
        if node.function in OF_SIZES and node.arguments and (
                shape := self.shape_of_components(node.arguments[0], scope)) is not None:
            node = with_sizes(node, shape)
        arguments = tuple(self.flatten(a, scope) for a in node.arguments)
        named = tuple((name, self.flatten(a, scope)) for name, a in node.named)
        if node.function in scope.instance.members:
            fail("L0204", f"'{node.function}' is no function", node.span,
                 f"elements are picked with square brackets: {node.function}[1]")
        call = Call(node.function, arguments, named, node.span)
        if node.function == "delay":
            return self.late(call)
        if node.function == HINGE_ANGLE:
            return self.hinge_angle(call)
        if node.function == "String":
            return text_of(replace(call, arguments=tuple(self.made.with_known_calls(a, self.work) for a in arguments)))
        return self.checked_call(call)

    def shape_of_components(self, node: Expression, scope: Scope) -> tuple[int, ...] | None:
        """Of an array of components or records; None for anything else."""
        return shape_of_components(node, scope, self)

    def late(self, call: Call[Flat]) -> Ref:
        """The variable that stands for a call of `delay`."""
        name = f"delay({len(self.delays) + 1})"
        self.delays[name] = call
        return Ref(name, (), call.span)

    def hinge_angle(self, call: Call[Flat]) -> Flat:
        """b.phi - a.phi in the plane, the variable that stands for it in space. Raises LagError L0215, L0221."""
        if call.named:
            _refuse_named(call)
        _check_count(call, FUNCTIONS[HINGE_ANGLE])
        a, b = frames_of(call)
        if not self.space.is_spatial:
            end, begin = (FrameRef(frame.name, ANGLE, (), call.span) for frame in (b, a))
            return Binary("-", end, begin, call.span)
        name, self.asked = name_of(a.name, b.name), self.asked + 1
        self.turned.setdefault(name, call)
        return Ref(name, (), call.span)

    def part(self, record: Expression, name: str, span: Span) -> Expression:
        """What a record has under a name, as an expression. Raises LagError L0302."""
        match record:
            case Reference(parts, place):
                return Reference((*parts, Part(name, (), place)), place)
            case IfExpression(condition, then, otherwise, place):
                return IfExpression(condition, self.part(then, name, span), self.part(otherwise, name, span), place)
            case Array(items, place):
                return Array(tuple(self.part(item, name, span) for item in items), place)
            case Comprehension("", body, iterators, place):
                return Comprehension("", self.part(body, name, span), iterators, place)
            case Call("fill", (value, *sizes), (), place) if sizes:
                return Call("fill", (self.part(value, name, span), *sizes), (), place)
            case Field(inner, outer, _):
                return self.part(self.part(inner, outer, span), name, span)
            case Call() if self.own_of(record) is None:
                return self.part_of_call(record, name)
            case Call() | Result() | Made():
                return Field(record, name, span)
        fail("L0302", "this is no record", record.span, "a record is a name of one, or made by its constructor: R(a = 1, b = 2)")

    def part_of_call(self, call: Call[Expression], name: str) -> Expression:
        """What a record has under a name that its constructor makes. Raises LagError L0215, L0302."""
        definition = self.table.found(call.function, call.span)
        if definition is None or definition.kind != "record":
            fail("L0302", f"{call.function}(...) is no record", call.span, "a record is made by its constructor: R(a = 1, b = 2)")
        declared = self.table.declared(definition)
        given: dict[str, Expression] = dict(zip(declared, call.arguments, strict=False))
        for field, value in call.named:
            if field not in declared or field in given:
                fail("L0215", f"{definition.name} has no other part '{field}'", call.span,
                     *filter(None, [suggest(field, list(declared))]))
            given[field] = value
        if len(call.arguments) > len(declared):
            fail("L0215", f"{definition.name} has {len(declared)} parts ({', '.join(declared)}), not {len(call.arguments)}",
                 call.span)
        missing = [field for field in declared if field not in given and default_of(self.table, declared[field]) is None]
        if missing:
            fail("L0215", f"{definition.name} also needs {', '.join(missing)}", call.span)
        return given[name] if name in given else made_part(self.table, definition, given, name, call.span)

    def checked_call(self, node: Call[Flat]) -> Flat:
        """A call whose arguments are flat already; array functions are written out. Raises LagError L0204, L0215, L0303."""
        if node.function in ARRAY_FUNCTIONS:
            return self._array_call(node)
        record = self.table.found(node.function, node.span) if node.function not in FUNCTIONS else None
        if record is not None and record.literals:
            return literal_numbered(record, node)
        if record is not None:
            what = "a record, not a number" if record.kind == "record" else f"a {record.kind}, no function"
            hint = f"declare one: {record.name} r = {node.span.text}; and name its parts, as r.x"
            fail("L0302", f"{record.name} is {what}", node.span, *([hint] if record.kind == "record" else []))
        if node.function in REWRITTEN:
            count, make = REWRITTEN[node.function]
            arguments = (*node.arguments, *_by_name(node))
            _check_count(replace(node, arguments=arguments), (count,))
            return make(*arguments, node.span)
        if (last := node.function.rpartition(".")[2]) in FOREIGN_CALLS:
            fail("L0901", f"not of this language: {node.function}(...)", node.span, FOREIGN_CALLS[last])
        if node.function not in FUNCTIONS:
            user = [name for name, c in {**self.table.library, **self.table.user}.items() if c.kind == "function"]
            if last != node.function and last in FUNCTIONS:
                fail("L0204", f"there is no function '{node.function}'", node.span, f"write: {last}(...)")
            known = [*FUNCTIONS, *ARRAY_FUNCTIONS, *REWRITTEN, *user]
            hint = function_meant(node.function) or suggest(node.function, known)
            fail("L0204", f"there is no function '{node.function}'", node.span, *filter(None, [hint]))
        if node.function == "table" and (node.named or len(node.arguments) == 2):
            return self._table(node)
        if node.function == "table2" and len(node.arguments) == 3:
            self._look_up(plane_of(node), node.arguments[2].span)
            return node
        if node.named:
            _refuse_named(node)
        _check_count(node, FUNCTIONS[node.function])
        if node.function in FRAME_WORDS:
            return frame_call(node, self.space, self.size, self.work)
        if node.function == "cross" and any(length(a, self.size) == 3 for a in node.arguments):
            return cross_of_three(node, self.size)
        if node.function in SCALAR_FUNCTIONS and any(length(a, self.size) is not None for a in node.arguments):
            return self._of_each(node)
        return node

    def _array_call(self, node: Call[Flat]) -> Flat:
        wanted, make = ARRAY_FUNCTIONS[node.function]
        if node.named:
            _refuse_named(node)
        _check_count(node, wanted)
        return make(node, self.size)

    def _of_each(self, node: Call[Flat]) -> Flat:
        """sin({a, b}) is {sin(a), sin(b)}."""
        counts = {n for a in node.arguments if (n := length(a, self.size)) is not None}
        if not counts:
            return node
        if len(counts) > 1:
            fail("L0303", f"arrays of {' and '.join(map(str, sorted(counts)))} do not go together", node.span)

        def at(k: int) -> Flat:
            return self._of_each(Call(node.function, tuple(element(a, k, self.size) for a in node.arguments), (), node.span))

        return Array(tuple(map(at, range(1, counts.pop() + 1))), node.span)

    def _table(self, node: Call[Flat]) -> Call[Flat]:
        """Of a file, or of points with options. Raises LagError L0215."""
        if len(node.arguments) == 3:
            options_of(node)
        elif len(node.arguments) == 2:
            self._look_up(lookup_of(node), node.arguments[1].span)
        else:
            fail("L0215", f"table takes 2 or 3 arguments, not {len(node.arguments)}, and options by name", node.span)
        return node

    def _look_up(self, file: Lookup, span: Span) -> None:
        self.asked += 1
        self.lookups.setdefault(file, span)


def _by_name(node: Call[Flat]) -> list[Flat]:
    """The arguments of homotopy(actual = ..., simplified = ...) in their order. Raises LagError L0215 for all others."""
    given = dict(node.named)
    if given and (node.function != "homotopy" or node.arguments or given.keys() != {"actual", "simplified"}):
        _refuse_named(node)
    return [given["actual"], given["simplified"]] if given else []


def _refuse_named(node: Call[Flat]) -> NoReturn:
    if node.function == "homotopy":
        fail("L0215", "homotopy takes both of its arguments by name, or none", node.span,
             "write: homotopy(actual = ..., simplified = ...); the actual one is what runs")
    values = ", ".join([*(a.span.text for a in node.arguments), *(value.span.text for _, value in node.named)])
    fail("L0215", f"{node.function} takes no named arguments", node.span, f"write them in their order: {node.function}({values})")


def _check_count(node: Call[Flat], wanted: tuple[int, ...] | None) -> None:
    given = len(node.arguments)
    if given == 0 or (wanted is not None and given not in wanted):
        count = " or ".join(map(str, wanted)) if wanted else "at least 1"
        fail("L0215", f"{node.function} takes {count} argument{'s' if count[-1] != '1' else ''}, not {given}", node.span)
