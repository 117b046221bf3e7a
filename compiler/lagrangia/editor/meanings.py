"""Syntax and classes -> what each name in a text stands for: a class, a declaration, an iterator.

Names are followed as far as they are right; what is wrong with the others is told elsewhere.
"""

import re
from bisect import bisect_right
from collections.abc import Iterator as IteratorType
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from typing import Any

from lagrangia.base.diagnostics import LagError, Source, Span
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.tree import (
    Argument,
    Call,
    ClassDefinition,
    Comprehension,
    Declaration,
    Extends,
    ForBlock,
    Iterator,
    Reference,
    Syntax,
)


@dataclass(frozen=True)
class Meaning:
    """What a name stands for, and where that is declared; `node` is its class or declaration, None for an iterator."""

    name: str
    place: Span
    node: ClassDefinition | Declaration | None

    @property
    def key(self) -> tuple[str, int]:
        """The same for the same thing, in whichever reading of its file."""
        return self.place.source.name, self.place.start


@dataclass(frozen=True)
class Occurrence:
    """A name as it stands in a text; `owner` is the class whose text it is."""

    span: Span
    meaning: Meaning
    owner: ClassDefinition


class Index:
    """All names of a file that mean something, in their order."""

    def __init__(self, syntax: Syntax, table: ClassTable) -> None:
        self.syntax, self.table = syntax, table
        self.known: dict[int, Mapping[str, Declaration]] = {}
        self.found: dict[int, Occurrence] = {}
        for definition in syntax.classes:
            _Walk(self, definition, {}).whole()
        self.occurrences = [self.found[start] for start in sorted(self.found)]
        self._starts = [found.span.start for found in self.occurrences]

    def members(self, definition: ClassDefinition) -> Mapping[str, Declaration]:
        """What a class declares, and all it extends as far as that is known."""
        if id(definition) not in self.known:
            self.known[id(definition)] = members(self.table, definition)
        return self.known[id(definition)]

    def at(self, offset: int) -> Occurrence | None:
        """The name that stands there, or ends there."""
        for k in (bisect_right(self._starts, offset) - 1, bisect_right(self._starts, offset - 1) - 1):
            if k >= 0 and self.occurrences[k].span.start <= offset <= self.occurrences[k].span.end:
                return self.occurrences[k]
        return None

    def class_around(self, offset: int) -> ClassDefinition | None:
        """The class in whose text a place is."""
        around = [c for c in _all_classes(self.syntax.classes) if c.span.start <= offset <= c.span.end]
        return around[-1] if around else None


def _all_classes(classes: tuple[ClassDefinition, ...]) -> IteratorType[ClassDefinition]:
    for definition in classes:
        yield definition
        yield from _all_classes(getattr(definition, "classes", ()))


def class_named(table: ClassTable, name: str, span: Span) -> ClassDefinition | None:
    """None for builtin types and names that nobody knows."""
    try:
        return table.lookup(name, span)
    except LagError:
        return None


def members(table: ClassTable, definition: ClassDefinition) -> Mapping[str, Declaration]:
    """What a class declares, and all it extends as far as that is known."""
    try:
        return table.declared(definition)
    except LagError:
        return {element.name: element for element in definition.elements if isinstance(element, Declaration)}


class _Walk:
    """Through one class, with the iterators that are in force."""

    def __init__(self, index: Index, owner: ClassDefinition, iterators: Mapping[str, Meaning]) -> None:
        self.index, self.table, self.owner, self.iterators = index, index.table, owner, iterators

    def whole(self) -> None:
        """The class with its name, before and behind it."""
        owner = self.owner
        meaning = Meaning(owner.name, owner.name_span, owner)
        self._add(owner.name_span, meaning)
        text = owner.span.source.text
        if end := re.search(rf"\bend\s+({re.escape(owner.name)})\s*;?$", text[owner.span.start : owner.span.end]):
            self._add(Span(owner.span.source, owner.span.start + end.start(1), owner.span.start + end.end(1)), meaning)
        for inner in getattr(owner, "classes", ()):
            _Walk(self.index, inner, {}).whole()
        for element in owner.elements:
            self._element(element)
        for section in owner.sections:
            self._walk(section.clauses)

    def _element(self, element: Declaration | Extends) -> None:
        kind = class_named(self.table, element.type_name, element.span)
        if isinstance(element, Declaration):
            self._add(element.name_span, Meaning(element.name, element.name_span, element))
            type_span: Span | None = element.type_span
        else:
            type_span = _find(element.type_name, element.span)
        if kind is not None and type_span is not None:
            self._add(_last_part(type_span), Meaning(kind.name, kind.name_span, kind))
        self._arguments(element.arguments, kind)
        if isinstance(element, Declaration):
            self._walk((element.dimensions, element.binding, element.condition))

    def _arguments(self, arguments: tuple[Argument, ...], kind: ClassDefinition | None) -> None:
        declared = self.index.members(kind) if kind is not None else {}
        for argument in arguments:
            target = declared.get(argument.name)
            inner = None
            if target is not None:
                self._add(argument.name_span, Meaning(target.name, target.name_span, target))
                inner = class_named(self.table, target.type_name, target.type_span)
            self._arguments(argument.arguments, inner)
            self._walk(argument.value)

    def _walk(self, node: Any) -> None:
        if isinstance(node, tuple):
            for item in node:
                self._walk(item)
        elif isinstance(node, Reference):
            self._reference(node)
        elif isinstance(node, ForBlock | Comprehension):
            self._loop(node)
        elif is_dataclass(node) and not isinstance(node, Span | Source):
            if isinstance(node, Call):
                self._call(node)
            for field in fields(node):
                self._walk(getattr(node, field.name))

    def _call(self, call: Call[Any]) -> None:
        function = class_named(self.table, call.function, call.span)
        if function is not None and function.kind == "function":
            place = Span(call.span.source, call.span.start, call.span.start + len(call.function))
            self._add(_last_part(place), Meaning(function.name, function.name_span, function))

    def _loop(self, loop: ForBlock | Comprehension) -> None:
        iterators = dict(self.iterators)
        for iterator in loop.iterators:
            self._walk(iterator.range)
            meaning = self._iterator(iterator)
            iterators[iterator.name] = meaning
            self._add(meaning.place, meaning)
        _Walk(self.index, self.owner, iterators)._walk(loop.body)

    @staticmethod
    def _iterator(iterator: Iterator) -> Meaning:
        start = iterator.span.start
        return Meaning(iterator.name, Span(iterator.span.source, start, start + len(iterator.name)), None)

    def _reference(self, reference: Reference) -> None:
        inside: ClassDefinition | None = self.owner
        for k, part in enumerate(reference.parts):
            self._walk(part.subscripts)
            place = Span(part.span.source, part.span.start, part.span.start + len(part.name))
            if k == 0 and part.name in self.iterators:
                self._add(place, self.iterators[part.name])
                inside = None
                continue
            target = self.index.members(inside).get(part.name) if inside is not None else None
            if target is not None:
                self._add(place, Meaning(target.name, target.name_span, target))
                inside = class_named(self.table, target.type_name, target.type_span)
            elif k == 0 and part.name == "world" and (ground := class_named(self.table, "World", part.span)) is not None:
                self._add(place, Meaning("world", ground.name_span, ground))
                inside = ground
            else:
                inside = None

    def _add(self, span: Span, meaning: Meaning) -> None:
        if span.source is self.index.syntax.source:
            self.index.found[span.start] = Occurrence(span, meaning, self.owner)


def _last_part(span: Span) -> Span:
    """Of a dotted name."""
    return Span(span.source, span.end - len(span.text.rpartition(".")[2].lstrip()), span.end)


def _find(name: str, span: Span) -> Span | None:
    """Where a name stands first in a piece of text, behind its first word or =."""
    if found := re.search(rf"(?:\bextends\s+|=\s*(?:\w+\s+)*)({re.escape(name)})\b", span.text):
        return Span(span.source, span.start + found.start(1), span.start + found.end(1))
    return None
