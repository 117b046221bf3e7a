"""Enumerations: their values by name, by number, and in a row."""

from collections.abc import Sequence
from dataclasses import replace
from typing import Protocol

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.classes import ClassTable
from lagrangia.language.folding import fold
from lagrangia.language.tree import Boolean, Call, ClassDefinition, EnumerationLiteral, Flat, Reference


class Enumerations(Protocol):
    """What names.py does with them."""

    table: ClassTable

    def literals(self, node: Reference) -> list[Flat]:
        """The values of the enumeration that a name stands for, false and true of Boolean; none for anything else."""
        if any(part.subscripts for part in node.parts):
            return []
        name = ".".join(part.name for part in node.parts)
        if name == "Boolean":
            return [Boolean(False, node.span), Boolean(True, node.span)]
        definition = self.table.found(name, node.span)
        return [] if definition is None else [literal(definition, k, node.span) for k in range(1, len(definition.literals) + 1)]

    def count_of_literals(self, node: Reference) -> int | None:
        """How many values an enumeration has, Boolean two; None for what is none."""
        return len(self.literals(node)) or None


def literal(definition: ClassDefinition, ordinal: int, span: Span) -> EnumerationLiteral:
    """A value of an enumeration; the first has the number 1."""
    names = tuple(one.name for one in definition.literals)
    return EnumerationLiteral(definition.name, names[ordinal - 1], ordinal, span, names)


def literal_named(definition: ClassDefinition, name: str, span: Span) -> EnumerationLiteral:
    """Raises LagError L0204."""
    names = [one.name for one in definition.literals]
    if name not in names:
        fail("L0204", f"{definition.name} has no value '{name}'", span,
             suggest(name, names) or f"its values are {', '.join(names)}")
    return literal(definition, names.index(name) + 1, span)


def literal_numbered(definition: ClassDefinition, call: Call[Flat]) -> EnumerationLiteral:
    """E(2), the second value of E. Raises LagError L0210, L0214, L0215."""
    if len(call.arguments) != 1 or call.named:
        fail("L0215", f"{definition.name} takes the number of a value", call.span, f"write: {definition.name}(1)")
    number = fold(call.arguments[0])
    if number is None or isinstance(number, bool):
        fail("L0210", "the number of a value must be known when the scene is compiled", call.arguments[0].span)
    if number not in range(1, len(definition.literals) + 1):
        fail("L0214", f"{definition.name} has {len(definition.literals)} values, not one of number {number:g}", call.span)
    return literal(definition, int(number), call.span)


def from_to(start: EnumerationLiteral, stop: Flat) -> list[Flat]:
    """The values of E.a:E.c. Raises LagError L0214."""
    if not isinstance(stop, EnumerationLiteral) or stop.type_name != start.type_name:
        fail("L0214", f"a range that begins with a value of {start.type_name} ends with one", stop.span)
    return [replace(start, name=start.names[k - 1], ordinal=k) for k in range(start.ordinal, stop.ordinal + 1)]


def ordinal_of(value: Flat) -> int | None:
    """As a subscript: the number of an enumeration's value; 1 of false and 2 of true; None for anything else."""
    if isinstance(value, EnumerationLiteral):
        return value.ordinal
    return 1 + value.value if isinstance(value, Boolean) else None


def subscripts_of(values: Sequence[int | Flat], span: Span) -> list[int]:
    """Integers, or values of enumerations, that pick elements. Raises LagError L0210."""
    found = []
    for value in values:
        number = value if isinstance(value, int) else ordinal_of(value) or fold(value)
        if number is None:
            fail("L0210", "subscripts must be known when the scene is compiled", span)
        if not float(number).is_integer():
            fail("L0210", f"a subscript must be an integer, not {number:g}", span)
        found.append(int(number))
    return found
