"""Attributes of declarations: what each type has, and units by one rule for variables, constants, what records have, and
variables of functions."""

from collections.abc import Callable, Iterator, Mapping

from lagrangia.base.diagnostics import Diagnostic, fail, nearest, suggest
from lagrangia.language.classes import ENUMERATION, ClassTable
from lagrangia.language.flat import Variable
from lagrangia.language.instances import Bound, Modification, Slot
from lagrangia.language.suggestions import component_of
from lagrangia.language.tree import Array, Boolean, Declaration, EnumerationLiteral, Expression, Flat, Number, String
from lagrangia.language.units_written import read_own_unit, read_unit

Flatten = Callable[[Bound], Flat]
_OF_ALL = frozenset({"quantity", "start", "fixed"})
_OF_INTEGERS = _OF_ALL | {"min", "max"}
NEVER_READ = ("nominal", "stateSelect", "quantity")  # whatever they say
ATTRIBUTES = _OF_INTEGERS | {"unit", "displayUnit", "nominal", "stateSelect"}
_OF_TYPES = {"Real": ATTRIBUTES, "Integer": _OF_INTEGERS, "Boolean": _OF_ALL, "String": _OF_ALL, ENUMERATION: _OF_INTEGERS}


def unknown_attributes(table: ClassTable, declaration: Declaration, base: str, change: Modification) -> Iterator[Diagnostic]:
    """L0208 for what is said of a variable that its builtin type has not."""
    known = _OF_TYPES.get(base, ATTRIBUTES)
    unknown = [name for name in change.children if name not in known]
    is_meant = any(nearest(name, known) for name in unknown)  # as an attribute
    component = [] if is_meant or not unknown else component_of(table, declaration, unknown)
    for name in unknown:
        hints = [f"of Real variables alone: {base} has {', '.join(sorted(known))}"] if name in ATTRIBUTES else (
            component or [*filter(None, [suggest(name, known)])])
        yield Diagnostic("error", "L0208", f"{declaration.type_name} has no attribute '{name}'", change.children[name].span,
                         hints=tuple(hints) if not component or name == unknown[0] else ())


def unit_of(attributes: Mapping[str, Bound], flatten: Flatten) -> str:
    """As it is declared, "" where none is. Raises LagError L0208 for what is no text; L0301 for no unit, or none of the SI."""
    unit = _text(attributes, "unit", flatten)
    if unit:
        read_own_unit(unit, attributes["unit"].expression.span)
    return unit


def display_unit_of(attributes: Mapping[str, Bound], flatten: Flatten) -> str:
    """Raises LagError L0208; L0301 for one that is none, or that the variable cannot be shown in."""
    shown = _text(attributes, "displayUnit", flatten)
    if shown:
        unit = _text(attributes, "unit", flatten)
        place = attributes["displayUnit"].expression.span
        if read_unit(shown, place).dimension != read_unit(unit or "1", place).dimension:
            fail("L0301", f"what is in {unit or '1'} cannot be shown in {shown}", place)
    return shown


def constant_of(slot: Slot, value: Flat, flatten: Flatten) -> Variable:
    """What is known when the scene is compiled, as it is written, for its dimension to be looked at."""
    return _written(slot.path, slot.dimensions, slot.declaration, slot.base, slot.attributes, value, flatten)


def note_limit(written: dict[str, Variable], path: str, attribute: str, declaration: Declaration, base: str,
               attributes: Mapping[str, Bound], flatten: Flatten) -> Flat:
    """The `min` or `max` of a variable, as it is written; its dimension is looked at with those of constants."""
    value = flatten(attributes[attribute])
    if not is_bare(value):
        name = f"{path}.{attribute}"
        written[name] = _written(name, (), declaration, base, attributes, value, flatten)
    return value


def _written(name: str, shape: tuple[int, ...], declaration: Declaration, base: str, attributes: Mapping[str, Bound], value: Flat,
             flatten: Flatten) -> Variable:
    """Integers have no unit."""
    unit, shown = unit_of(attributes, flatten), display_unit_of(attributes, flatten)
    return Variable(name, "parameter", shape, "1" if base == "Integer" else unit, shown, value, None, False, None, None, False,
                    declaration.description, declaration.name_span, type_name=base)


def is_literal(value: Flat | Expression) -> bool:
    """Whether it is a number, a text, true or false, or an array of such."""
    return isinstance(value, Number | Boolean | String) or (isinstance(value, Array) and all(map(is_literal, value.items)))


def is_bare(value: Flat | Expression) -> bool:
    """Whether it is a literal without a unit, of which there is nothing to look at."""
    return not value.unit if isinstance(value, Number) else isinstance(value, Boolean | String | EnumerationLiteral)


def in_declared_unit(value: Flat, unit: str) -> Flat:
    """What a constant stands for: its bare numbers are in the unit that it is declared in, if it is in one."""
    if isinstance(value, Array):
        return Array(tuple(in_declared_unit(item, unit) for item in value.items), value.span)
    return Number(value.value, unit, value.span) if unit and isinstance(value, Number) and value.unit is None else value


def _text(attributes: Mapping[str, Bound], name: str, flatten: Flatten) -> str:
    bound = attributes.get(name)
    if bound is None:
        return ""
    if bound.expression.__class__ is String and not bound.selection:
        return bound.expression.value  # as most are
    value = flatten(bound)
    found = {item.value if isinstance(item, String) else fail("L0208", f"'{name}' must be a text", item.span)
             for item in _items(value)}
    if len(found) > 1:
        fail("L0208", f"'{name}' is one for all elements of an array, not {' and '.join(sorted(map(repr, found)))}", value.span,
             "declare what has another unit as a variable of its own")
    return found.pop() if found else ""


def _items(value: Flat) -> Iterator[Flat]:
    if isinstance(value, Array):
        for item in value.items:
            yield from _items(item)
    else:
        yield value
