"""Attributes of variables: the least and the largest value that a declaration allows, whether a start is fixed."""

import operator
from typing import NoReturn

from lagrangia.base.diagnostics import fail
from lagrangia.language.attributes import note_limit
from lagrangia.language.classes import ClassTable
from lagrangia.language.flat import Kind
from lagrangia.language.folding import folded
from lagrangia.language.instances import DISCRETE_TYPES, STRUCTURAL_TYPES, Instance, Slot, outside
from lagrangia.language.names import Names
from lagrangia.language.tree import Array, Boolean, Declaration, EnumerationLiteral, Flat, Number

_KINDS: tuple[Kind, ...] = ("parameter", "coordinate", "input")
_BEYOND = (("min", "less than its minimum", operator.lt), ("max", "more than its maximum", operator.gt))


def read_limit(names: Names, slot: Slot, attribute: str) -> float | None:
    """A number, of an enumeration the place of its value, or None where there is no limit; its unit is looked at with those of
    constants. Raises LagError L0208."""
    bound = slot.attributes.get(attribute)
    if bound is None:
        return None
    flat = note_limit(names.written, slot.path, attribute, slot.declaration, slot.base, slot.attributes, names.flatten_bound)
    value = folded(names.made.with_known_calls(flat, names.work))
    if value is None:
        fail("L0208", f"'{attribute}' must be known when the scene is compiled", bound.expression.span)
    if slot.enumeration:
        if not isinstance(value, EnumerationLiteral) or value.type_name != slot.enumeration:
            fail("L0208", f"'{attribute}' must be a value of {slot.enumeration}", bound.expression.span)
        return float(value.ordinal)
    if not isinstance(value, Number):
        fail("L0208", f"'{attribute}' must be a number", bound.expression.span)
    return float(value.value)


def refuse_missing(table: ClassTable, slot: Slot, owner: Instance) -> NoReturn:
    """Of a parameter that has to be given. Raises LagError L0211."""
    name, span = slot.declaration.name, slot.declaration.name_span
    said = f" ({slot.declaration.description})" if slot.declaration.description else ""
    if (fixed := slot.attributes.get("fixed")) is not None and fixed.expression.span.text == "false":
        fail("L0901", f"not supported yet: the parameter '{name}' that initial equations would give", fixed.expression.span,
             "give it a value, or start values that follow from it")
    if owner.parent is not None:
        fail("L0211", f"{owner.definition.name} '{owner.path}' needs a value for its parameter '{name}'{said}",
             outside(table, owner.span, owner.parent), f"write: {owner.span.text}({name} = ...)")
    if any(slot.declaration is element for element in owner.definition.elements):
        fail("L0211", f"the parameter '{name}'{said} has no value", span, f"write: {name} = ...")
    fail("L0211", f"{owner.definition.name} inherits the parameter '{name}'{said} without a value", owner.span,
         f"write: extends ...({name} = ...)")


def require_within(names: Names, slot: Slot, value: Flat) -> None:
    """Of a structural value, which no run can change, or of each in an array. Raises LagError L0605."""
    kind = "constant" if "constant" in slot.declaration.prefixes else "parameter"
    for attribute, words, is_beyond in _BEYOND:
        limit = read_limit(names, slot, attribute)
        for item in value.items if isinstance(value, Array) else (value,):
            if limit is not None and isinstance(item, Number | EnumerationLiteral) and is_beyond(_place(item), limit):
                fail("L0605", f"the {kind} '{slot.path}' is {_said(item, _place(item))}, {words} {_said(item, limit)}", item.span,
                     f"declared at {slot.declaration.name_span}")


def _place(item: Number | EnumerationLiteral) -> float:
    return item.value if isinstance(item, Number) else item.ordinal


def _said(item: Number | EnumerationLiteral, place: float) -> str:
    """A value of the same kind."""
    return f"{place:g}" if isinstance(item, Number) else item.names[int(place) - 1]


def flag_of(names: Names, slot: Slot, attribute: str) -> bool:
    """Whether an attribute is said to be true. Raises LagError L0210."""
    bound = slot.attributes.get(attribute)
    return bound is not None and names.boolean(bound.expression, bound.scope, f"'{attribute}'")


def has_annotation(declaration: Declaration, name: str) -> bool:
    """Whether a declaration has annotation(name = true). Raises LagError L0208."""
    values = [argument.value for argument in declaration.annotation if argument.name == name]
    for value in values:
        if not isinstance(value, Boolean):
            fail("L0208", f"'{name}' is true or false", declaration.name_span)
    return any(isinstance(value, Boolean) and value.value for value in values)


def kind_of(slot: Slot) -> Kind:
    """What a variable is by its prefixes. Raises LagError L0219 for what varies and is no number and not true or false."""
    prefixes = slot.declaration.prefixes
    kind: Kind = next((kind for kind in _KINDS if kind in prefixes), "variable")
    if slot.base in STRUCTURAL_TYPES and kind != "parameter" and (slot.base not in DISCRETE_TYPES or kind != "variable"):
        what = f"the {slot.base} {kind}" if not slot.enumeration else f"the {kind} of the enumeration {slot.enumeration},"
        if slot.dimensions and not slot.enumeration:
            what = f"the array of {slot.base} {kind}s"
        name = slot.declaration.name
        steps = (f"declare it as input Real {name}, which steps where a table has two lines at one time; {name} > 0.5 is then "
                 "true or false, and an event where it changes",) if kind == "input" and not slot.enumeration else ()
        fail("L0219", f"not supported yet: {what} '{name}'", slot.declaration.name_span,
             "Integer, Boolean, String and enumeration parameters are supported, and Integer and Boolean variables", *steps)
    return kind
