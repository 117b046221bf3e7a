"""What a record has that its constructor is not given: its default, of which other parts are as they are given."""

from collections.abc import Iterator, Mapping
from dataclasses import replace
from typing import Any

from lagrangia.base.diagnostics import Span
from lagrangia.language.classes import ClassTable
from lagrangia.language.implied_ranges import references
from lagrangia.language.tree import Call, ClassDefinition, Declaration, Expression, Made


def default_of(table: ClassTable, declaration: Declaration) -> Expression | None:
    """Of a record in a record: what its own constructor makes, with the values that it is declared with."""
    if declaration.binding is not None or declaration.dimensions:
        return declaration.binding
    found = table.found(declaration.type_name, declaration.type_span)
    if found is None or found.kind != "record":
        return None
    named = tuple((a.name, a.value) for a in declaration.arguments if a.value is not None)
    return Call(declaration.type_name, (), named, declaration.type_span)


def made_part(table: ClassTable, definition: ClassDefinition, given: Mapping[str, Expression], name: str, span: Span
              ) -> Expression:
    """The default of a part of a record of which others are `given`: a function of these, where it names any part."""
    declared = {field: replace(d, binding=default_of(table, d)) for field, d in table.declared(definition).items()}
    default = declared[name].binding
    assert default is not None
    if not _is_made(table, declared[name], set(_names(default)) & declared.keys()):
        return default
    needed = dict.fromkeys(_needed(name, declared, given))
    made = [replace(declared[field], prefixes=frozenset({_role(field, name, given)}),
                    binding=None if field in given else declared[field].binding) for field in needed]
    known = [field for field in needed if field in given]  # of other ones it is another function
    own = ClassDefinition("function", False, f"{definition.name}.{name}({', '.join(known)})", definition.description, tuple(made),
                          (), (), definition.span, definition.name_span)
    return Made(Call(own.name, (), tuple((field, given[field]) for field in known), span), own, span)


def _is_made(table: ClassTable, declaration: Declaration, parts: set[str]) -> bool:
    """Whether its default is another one where the constructor is called: it names parts, or constants around the record."""
    base = table.base_type(declaration.type_name, declaration.type_span)
    is_number = base is not None and base.builtin in ("Real", "Integer", "Boolean")
    return bool(parts) or (is_number and any(True for _ in _names(declaration.binding)))


def _role(field: str, name: str, given: Mapping[str, Expression]) -> str:
    return "input" if field in given else "output" if field == name else "protected"


def _needed(name: str, declared: Mapping[str, Declaration], given: Mapping[str, Expression], under: tuple[str, ...] = ()
            ) -> Iterator[str]:
    """A part behind those that its default names, which are each computed before it."""
    if name not in given and name not in under:
        for other in _names(declared[name].binding):
            if other in declared:
                yield from _needed(other, declared, given, (*under, name))
    yield name


def _names(node: Any) -> Iterator[str]:
    """What the names in a piece of syntax begin with."""
    return (reference.parts[0].name for reference in references(node))
