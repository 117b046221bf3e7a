"""What a text consists of: what can be folded, names by what they stand for, numbers with the units that they take."""

from collections.abc import Iterator
from dataclasses import fields, is_dataclass
from typing import Any

from lagrangia.base.diagnostics import LagError, Source, Span
from lagrangia.base.records import dataclass
from lagrangia.editor.meanings import Index, all_classes, class_named
from lagrangia.editor.telling import unit_of
from lagrangia.editor.words import COMMENT, pieces_of
from lagrangia.language.tree import (
    Argument,
    Array,
    ClassDefinition,
    Declaration,
    ForBlock,
    IfBlock,
    LiteralDefinition,
    Number,
    Section,
    Unary,
    WhenBlock,
)

TOKENS = ("class", "type", "function", "parameter", "variable", "property")
MODIFIERS = ("declaration", "readonly", "defaultLibrary")


@dataclass(frozen=True)
class Token:
    """A name: what it stands for (of TOKENS), and what is to be said of that (of MODIFIERS)."""

    span: Span
    kind: str
    modifiers: tuple[str, ...]


def folds(index: Index) -> list[Span]:
    """Classes, sections, blocks and comments of several lines."""
    source = index.syntax.source
    found = [span for span in _blocks(index.syntax.classes) if span.source is source and "\n" in span.text]
    try:
        comments = [Span(source, piece.start, piece.start + len(piece.text)) for piece in pieces_of(source)
                    if piece.kind == COMMENT and "\n" in piece.text]
    except LagError:
        comments = []
    return [*found, *comments]


def _blocks(node: Any) -> Iterator[Span]:
    if isinstance(node, tuple):
        for item in node:
            yield from _blocks(item)
    elif is_dataclass(node) and not isinstance(node, Span | Source):
        if isinstance(node, ClassDefinition | Section | ForBlock | IfBlock | WhenBlock):
            yield node.span
        for field in fields(node):
            yield from _blocks(getattr(node, field.name))


def tokens(index: Index) -> list[Token]:
    """In the order in which they stand."""
    found = []
    for occurrence in index.occurrences:
        node, place = occurrence.meaning.node, occurrence.meaning.place
        modifiers = ["declaration"] if occurrence.span == place else []
        if place.source in index.table.library_sources:
            modifiers.append("defaultLibrary")
        if isinstance(node, ClassDefinition):
            kind = node.kind if node.kind in ("type", "function") else "class"
        elif isinstance(node, LiteralDefinition) or (isinstance(node, Declaration) and {"parameter", "constant"} & node.prefixes):
            kind = "parameter"
            modifiers.append("readonly")
        elif isinstance(node, Declaration) and node.type_name == "Frame":
            kind = "property"
        else:
            kind = "variable"
        found.append(Token(occurrence.span, kind, tuple(modifiers)))
    return found


def units_of_numbers(index: Index) -> Iterator[tuple[int, str]]:
    """Behind which characters bare numbers stand that take a unit from their place, and which."""
    source = index.syntax.source
    for definition in all_classes(index.syntax.classes):
        for element in definition.elements:
            if isinstance(element, Declaration):
                yield from _unit_behind(element.binding, unit_of(index.table, element), source)
            yield from _in_arguments(index, element.arguments, class_named(index.table, element.type_name, element.span), source)


def _in_arguments(index: Index, arguments: tuple[Argument, ...], kind: ClassDefinition | None, source: Source
                  ) -> Iterator[tuple[int, str]]:
    declared = index.members(kind) if kind is not None and kind.kind != "type" else {}
    for argument in arguments:
        target = declared.get(argument.name)
        if target is not None:
            unit = unit_of(index.table, target)
            yield from _unit_behind(argument.value, unit, source)
            starts = next((a.value for a in argument.arguments if a.name == "start"), None)
            yield from _unit_behind(starts, unit, source)
            inner = class_named(index.table, target.type_name, target.type_span)
            yield from _in_arguments(index, argument.arguments, inner, source)


def _unit_behind(value: Any, unit: str, source: Source) -> Iterator[tuple[int, str]]:
    if unit in ("", "1") or value is None or value.span.source is not source:
        return
    number = value.operand if isinstance(value, Unary) else value
    is_bare = isinstance(number, Number) and number.unit is None and number.value != 0
    is_array = isinstance(value, Array) and all(isinstance(item, Number) and item.unit is None for item in value.items) \
        and any(isinstance(item, Number) and item.value for item in value.items)
    if is_bare or is_array:
        yield value.span.end, unit
