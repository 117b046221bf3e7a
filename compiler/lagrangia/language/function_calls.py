"""Calls of people's own functions: what goes to which input, for which sizes the function is made, and what comes back."""

from collections.abc import Mapping
from typing import Any, Protocol

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.classes import ENUMERATION, ClassTable
from lagrangia.language.elements import element
from lagrangia.language.folding import fold, folded
from lagrangia.language.function_variables import Assertion, Built, Given, Tree, dealt, flat_of, leaves_of, part_of
from lagrangia.language.instances import Scope
from lagrangia.language.known_calls import MadeFunctions
from lagrangia.language.matrices import shape_of
from lagrangia.language.number_checks import refuse_no_number
from lagrangia.language.tree import (
    Array,
    Call,
    ClassDefinition,
    Clause,
    Declaration,
    EnumerationLiteral,
    Expression,
    Field,
    Flat,
    ForBlock,
    IfBlock,
    Made,
    Ref,
    Reference,
    Result,
    String,
    WhileBlock,
)
from lagrangia.language.truths import number_of, truth_of


class OwnCalls(Protocol):
    """What names.py does with calls of people's own functions."""

    table: ClassTable
    made: MadeFunctions

    def define_function(self, definition: ClassDefinition, given: Given, span: Span) -> Built:
        """The function for what a call gives it. Raises LagError for one that is wrong."""

    def flatten(self, node: Expression, scope: Scope) -> Flat:
        """An expression with full names. Raises LagError."""

    def require(self, one: Assertion, cells: Mapping[str, Flat], span: Span, scope: Scope) -> None:
        """That an assertion of a function holds for what a call gives it. Raises LagError."""

    def size(self, ref: Ref) -> int | None:
        """Of the next dimension of a variable; None where it has none."""

    def fields(self, node: Expression, scope: Scope) -> list[str]:
        """The names of what a record has; none for anything else."""

    def own_call(self, call: Call[Expression], own: ClassDefinition, scope: Scope, output: int = 0, way: tuple[str, ...] = ()
                 ) -> Flat:
        """A result of a call, or what it has under the names `way`; of an array where the function takes a number that of each
        element (Modelica 3.6, section 12.4.6). Raises LagError L0215, L0303."""
        declared = [e for e in own.elements if isinstance(e, Declaration)]
        if own.is_partial:
            fail("L0205", f"the function '{own.name}' is partial: it cannot be called", call.span,
                 "a function that extends it, or takes its place, says what it computes")
        inputs = {d.name: d for d in declared if "input" in d.prefixes}
        given = _arranged(call, own.name, inputs)
        values = {name: self.flatten(node, scope) for name, node in given.items() if not self._record(inputs[name])}
        arrays = {name: shape for name, value in values.items() if not inputs[name].dimensions
                  and (shape := shape_of(value, self.size)) and not self._has_size(inputs[name])}
        if not arrays:
            return self._called(call, own, given, values, scope, output, way)
        if len(set(arrays.values())) > 1:
            fail("L0303", f"{own.name} is given arrays of different sizes where it takes numbers: {', '.join(arrays)}", call.span)

        def of_each(values: dict[str, Flat], shape: tuple[int, ...]) -> Flat:
            if not shape:
                return self._called(call, own, given, values, scope, output, way)
            return Array(tuple(of_each(values | {name: element(values[name], k, self.size) for name in arrays}, shape[1:])
                               for k in range(1, shape[0] + 1)), call.span)

        return of_each(values, next(iter(arrays.values())))

    def _has_size(self, declaration: Declaration) -> bool:
        """Whether its type is one of arrays."""
        base = self.table.base_type(declaration.type_name, declaration.type_span)
        return base is not None and bool(base.dimensions)

    def _called(self, call: Call[Expression], own: ClassDefinition, given: dict[str, Expression], values: dict[str, Flat],
                scope: Scope, output: int, way: tuple[str, ...]) -> Flat:
        """A result of a call whose numbers and arrays are flat."""
        inputs = {e.name: e for e in own.elements if isinstance(e, Declaration) and "input" in e.prefixes}
        for name, value in values.items():
            self._refuse_other(inputs[name], value)
        shapes = {name: shape_of(values[name], self.size) if name in values else (
                      self._record_shape(given[name], inputs[name], scope)) for name in inputs if name in given}
        constants = _constants(own, inputs, values)
        built = self.define_function(own, Given(shapes, constants), call.span)
        self.made.functions |= built.functions
        named: dict[str, Flat] = {}
        for name, tree in built.inputs.items():
            named |= zip(leaves_of(tree), self._cells(given[name], values.get(name), tree, scope, f"'{name}' of {own.name}"),
                         strict=True)
        named = {leaf: number_of(value) if leaf in built.truths else value for leaf, value in named.items()}
        cells = tuple(named.values())
        for assertion in built.assertions:
            self.require(assertion, named, call.span, scope)
        outputs = list(built.outputs.values())
        if output >= len(outputs):
            fail("L0303", f"{own.name} has {_counted(len(outputs), 'result')}, not {output + 1}", call.span)
        found = outputs[output]
        for name in way:
            found = part_of(found, name, call.span)

        def result(function: str) -> Flat:
            made = Call[Flat](function, cells, (), call.span)
            return truth_of(made) if function in built.truths else made

        return flat_of(found, result, call.span)

    def _refuse_other(self, declaration: Declaration, value: Flat) -> None:
        """Raises LagError L0302 for what is no number where an input is one, and for no condition where it is Boolean."""
        base = self.table.base_type(declaration.type_name, declaration.type_span)
        if base is not None and base.builtin in ("Real", "Integer"):
            refuse_no_number(value)
        elif base is not None and base.builtin == "Boolean":
            number_of(value)
        elif base is not None and base.builtin == "String" and not isinstance(value, String):
            fail("L0302", f"'{declaration.name}' is a text that is known when the scene is compiled, this is none", value.span)
        elif base is not None and base.definition is not None and base.builtin == ENUMERATION and not (
                isinstance(value, EnumerationLiteral) and value.type_name == base.definition.name):
            fail("L0302", f"'{declaration.name}' is a value of {base.definition.name}, this is none", value.span)

    def own_of(self, node: Expression) -> tuple[Call[Expression], ClassDefinition, int] | None:
        """The call of a function of people's own that an expression is a result of, the function, and which result."""
        call, output = (node.call, node.output) if isinstance(node, Result) else (
            node.call if isinstance(node, Made) else node, 0)
        own = node.own if isinstance(node, Made) else (
            self.table.function(call.function, call.span) if isinstance(call, Call) else None)
        return (call, own, output) if own is not None and isinstance(call, Call) else None

    def field_of_result(self, node: Field, scope: Scope) -> Flat | None:
        """Of a record that a function gives; None where it is another one."""
        way: tuple[str, ...] = (node.name,)
        record = node.record
        while isinstance(record, Field):
            way, record = (record.name, *way), record.record
        found = self.own_of(record)
        return None if found is None else self.own_call(found[0], found[1], scope, found[2], way)

    def result(self, node: Result | Made, scope: Scope) -> Flat:
        """One of several. Raises LagError L0302 where there are none."""
        found = self.own_of(node)
        if found is None:
            fail("L0302", "this gives no several results", node.span, "call a function that has them: (a, b) = f(x);")
        return self.own_call(found[0], found[1], scope, found[2])

    def fields_of_result(self, call: Call[Expression], own: ClassDefinition, output: int) -> list[str]:
        """The names of what a result has that is a record."""
        declared = [e for e in own.elements if isinstance(e, Declaration) and "output" in e.prefixes]
        kind = self.table.found(declared[output].type_name, call.span) if output < len(declared) else None
        return list(self.table.declared(kind)) if kind is not None and kind.kind == "record" else []

    def _record(self, declaration: Declaration) -> bool:
        found = self.table.found(declaration.type_name, declaration.type_span)
        return found is not None and found.kind == "record"

    def _record_shape(self, node: Expression, declaration: Declaration, scope: Scope) -> tuple[int, ...]:
        """Of as many dimensions as the input has."""
        if not declaration.dimensions:
            return ()
        part, number = declaration, node
        while self._record(part):
            definition = self.table.lookup(part.type_name, part.type_span)
            first = next(iter(self.table.declared(definition).items()), None)
            if first is None:
                fail("L0902", "not supported yet: arrays of records without parts", node.span)
            number, part = Field(number, first[0], node.span), first[1]
        return shape_of(self.flatten(number, scope), self.size)[: len(declaration.dimensions)]

    def _cells(self, node: Expression, value: Flat | None, tree: Tree, scope: Scope, what: str) -> list[Flat]:
        if isinstance(tree, dict):
            if isinstance(node, Reference) and not self.fields(node, scope):
                fail("L0302", f"{what} is a record, this is none", node.span)
            return [cell for name, part in tree.items()
                    for cell in self._cells(Field(node, name, node.span), None, part, scope, f"'{name}' in {what}")]
        flat = self.flatten(node, scope) if value is None else value
        return [cell for _, cell in dealt(flat, tree, self.size, what)]


def _arranged(call: Call[Expression], name: str, inputs: dict[str, Declaration]) -> dict[str, Expression]:
    given: dict[str, Expression] = dict(zip(inputs, call.arguments, strict=False))
    if len(call.arguments) > len(inputs):
        wanted = f"{_counted(len(inputs), 'argument')} ({', '.join(inputs)})"
        fail("L0215", f"{name} takes {wanted}, not {len(call.arguments)}", call.span)
    for own, value in call.named:
        if own in given:
            fail("L0215", f"the input '{own}' of {name} is given twice", call.span,
                 f"values without a name come first, in their order: {', '.join(inputs)}")
        if own not in inputs:
            fail("L0215", f"{name} has no other input '{own}'", call.span, *filter(None, [suggest(own, list(inputs))]))
        given[own] = value
    missing = [own for own, declaration in inputs.items() if own not in given and declaration.binding is None]
    if missing:
        fail("L0215", f"{name} also needs {', '.join(missing)}", call.span)
    return given


def _constants(own: ClassDefinition, inputs: dict[str, Declaration], values: dict[str, Flat]) -> dict[str, Flat]:
    """Of texts, values of enumerations, and Integer and Boolean inputs, where sizes or passes of loops may depend on them."""
    found = {}
    for name, value in values.items():
        kind = inputs[name].type_name
        if isinstance(value, String | EnumerationLiteral) or (
                (kind == "Boolean" or (kind == "Integer" and _is_structured(own))) and fold(value) is not None):
            constant = folded(value)
            assert constant is not None
            found[name] = constant
    return found


def _is_structured(own: ClassDefinition) -> bool:
    return any(isinstance(e, Declaration) and e.dimensions for e in own.elements) or any(
        map(_loops, (clause for section in own.sections for clause in section.clauses)))


def _loops(clause: Clause) -> bool:
    inner: tuple[Any, ...] = (*clause.then, *clause.otherwise) if isinstance(clause, IfBlock) else ()
    return isinstance(clause, ForBlock | WhileBlock) or any(map(_loops, inner))


def _counted(n: int, what: str) -> str:
    return f"{n} {what}{'s' if n != 1 else ''}"
