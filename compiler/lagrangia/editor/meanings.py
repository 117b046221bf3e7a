"""Syntax and classes -> what each name in a text stands for: a class, a declaration, an iterator.

Names are followed as far as they are right; what is wrong with the others is told elsewhere.
"""

import re
from bisect import bisect_right
from collections.abc import Iterator as IteratorType
from collections.abc import Mapping
from contextlib import suppress
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
    Constraining,
    Declaration,
    Extends,
    ForBlock,
    Import,
    Iterator,
    LiteralDefinition,
    Reference,
    Syntax,
)


@dataclass(frozen=True)
class Meaning:
    """What a name stands for, and where that is declared; `node` is its class, declaration or value of an enumeration, None for
    an iterator."""

    name: str
    place: Span
    node: ClassDefinition | Declaration | LiteralDefinition | None

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


_PARTS = re.compile(r"[^\W\d]\w*")
_DOTTED = re.compile(r"[^\W\d]\w*(?:\s*\.\s*[^\W\d]\w*)*")


class Index:
    """All names of a file that mean something, in their order."""

    def __init__(self, syntax: Syntax, table: ClassTable) -> None:
        self.syntax, self.table = syntax, table
        self.known: dict[int, Mapping[str, Declaration]] = {}
        self.found: dict[int, Occurrence] = {}
        for item in syntax.named:
            self.add_import(item)
        for definition in syntax.classes:
            _Walk(self, definition, {}).whole()
        self.occurrences = [self.found[start] for start in sorted(self.found)]
        self._starts = [found.span.start for found in self.occurrences]

    def members(self, definition: ClassDefinition) -> Mapping[str, Declaration]:
        """What a class declares, and all it extends as far as that is known."""
        if id(definition) not in self.known:
            self.known[id(definition)] = members(self.table, definition)
        return self.known[id(definition)]

    def add(self, span: Span, meaning: Meaning, owner: ClassDefinition) -> None:
        """A name in this file."""
        if span.source is self.syntax.source:
            self.found[span.start] = Occurrence(span, meaning, owner)

    def add_class(self, name: str, span: Span, owner: ClassDefinition | None = None) -> None:
        """The dotted name of a class, whose text the span is, with the packages before it."""
        ends = [found.end() for found in _PARTS.finditer(span.text)]
        for k, part in enumerate(parts := name.split(".")):
            known = k < len(ends) and self.class_or_package(".".join(parts[: k + 1]), span)
            if known:
                place = Span(span.source, span.start + ends[k] - len(part), span.start + ends[k])
                self.add(place, Meaning(known.name.rpartition(".")[2], known.name_span, known), owner or known)

    def add_import(self, item: Import, owner: ClassDefinition | None = None) -> None:
        """The names in import A.B; import C = A.B; import A.{b, c}; import A.*;"""
        text, start = item.span.text, item.span.start
        head, _, inner = text.partition("{")
        names = [found for found in _DOTTED.finditer(head) if found[0] != "import"]
        short = dict(item.names)
        for found in names:
            name = re.sub(r"\s", "", found[0])
            self.add_class(short.get(name, name) if len(names) > 1 else name,
                           Span(item.span.source, start + found.start(), start + found.end()), owner)
        for found in _PARTS.finditer(inner):
            if (known := self.class_or_package(short.get(found[0], ""), item.span)) is not None:
                place = start + len(head) + 1 + found.start()
                self.add(Span(item.span.source, place, place + len(found[0])),
                         Meaning(found[0], known.name_span, known), owner or known)

    def class_or_package(self, name: str, span: Span) -> ClassDefinition | None:
        """None for names that nobody knows."""
        try:
            package = self.table.scopes.package(name, span)
        except LagError:
            package = None
        return self.table.scopes.classes[package] if package else class_named(self.table, name, span)

    def at(self, offset: int) -> Occurrence | None:
        """The name that stands there, or ends there."""
        for k in (bisect_right(self._starts, offset) - 1, bisect_right(self._starts, offset - 1) - 1):
            if k >= 0 and self.occurrences[k].span.start <= offset <= self.occurrences[k].span.end:
                return self.occurrences[k]
        return None

    def class_around(self, offset: int) -> ClassDefinition | None:
        """The class in whose text a place is."""
        around = [c for c in all_classes(self.syntax.classes) if c.span.start <= offset <= c.span.end]
        return around[-1] if around else None


def all_classes(classes: tuple[ClassDefinition, ...]) -> IteratorType[ClassDefinition]:
    """These, and those that stand in them."""
    for definition in classes:
        yield definition
        yield from all_classes(definition.classes)


def class_named(table: ClassTable, name: str, span: Span) -> ClassDefinition | None:
    """None for builtin types and names that nobody knows."""
    try:
        return table.found(name, span)  # not lookup: what might be meant in its place takes long to find
    except LagError:
        return None


def members(table: ClassTable, definition: ClassDefinition) -> Mapping[str, Declaration]:
    """What a class declares, and all it extends as far as that is known."""
    try:
        return table.declared(definition)
    except LagError:
        return {element.name: element for element in definition.elements if isinstance(element, Declaration)}


def lineage(table: ClassTable, definition: ClassDefinition) -> list[ClassDefinition]:
    """The class and all that it extends, as far as that is known."""
    try:
        return table.lineage(definition)
    except LagError:
        return [definition]


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
        for item in owner.imports:
            self.index.add_import(item, owner)
        for literal in owner.literals:
            self._add(_first_part(literal.span), Meaning(literal.name, _first_part(literal.span), literal))
        for inner in owner.classes:
            _Walk(self.index, inner, {}).whole()
        for element in owner.elements:
            self._element(element)
        self._constraining(owner.constraining)
        for section in owner.sections:
            self._walk(section.clauses)

    def _element(self, element: Declaration | Extends) -> None:
        kind = class_named(self.table, element.type_name, element.span)
        if isinstance(element, Declaration):
            self._add(element.name_span, Meaning(element.name, element.name_span, element))
            type_span: Span | None = element.type_span
            self._constraining(element.constraining)
        else:
            type_span = _find(element.type_name, element.span)
        if type_span is not None:
            self.index.add_class(element.type_name, type_span, self.owner)
        self._arguments(element.arguments, kind)
        if isinstance(element, Declaration):
            self._walk((element.dimensions, element.binding, element.condition))

    def _constraining(self, limit: Constraining | None) -> None:
        if limit is not None and (place := _find(limit.type_name, limit.span)) is not None:
            self.index.add_class(limit.type_name, place, self.owner)
            self._arguments(limit.arguments, class_named(self.table, limit.type_name, limit.span))

    def _arguments(self, arguments: tuple[Argument, ...], kind: ClassDefinition | None) -> None:
        declared = self.index.members(kind) if kind is not None else {}
        for argument in arguments:
            target: Declaration | ClassDefinition | None = declared.get(argument.name)
            inner = None
            if isinstance(target, Declaration):
                inner = class_named(self.table, target.type_name, target.type_span)
            elif argument.redeclared is not None and kind is not None:
                target = next((c for base in lineage(self.table, kind) for c in base.classes if c.name == argument.name), None)
            if target is not None:
                self._add(argument.name_span, Meaning(target.name, target.name_span, target))
            if argument.redeclared is not None:
                self._put_in_its_place(argument.redeclared)
                continue
            self._arguments(argument.arguments, inner)
            self._walk(argument.value)

    def _put_in_its_place(self, new: Declaration) -> None:
        """What a redeclaration says beside the name."""
        self.index.add_class(new.type_name, _find(new.type_name, new.type_span) or new.type_span, self.owner)
        self._arguments(new.arguments, class_named(self.table, new.type_name, new.type_span))
        self._constraining(new.constraining)
        self._walk((new.dimensions, new.binding, new.condition))

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
        if not self._elsewhere(reference):
            self._member(reference)

    def _elsewhere(self, reference: Reference) -> bool:
        """Whether it is a constant of a package around it or imported, or begins with the name of a class."""
        first, names = reference.parts[0], [part.name for part in reference.parts]
        places = [Span(part.span.source, part.span.start, part.span.start + len(part.name)) for part in reference.parts]
        if first.name in self.iterators or first.name in self.index.members(self.owner) or first.name == "world":
            return False
        with suppress(LagError):
            found = self.table.scopes.constant(first.name, first.span)
            constant = self.index.members(found[0]).get(found[1]) if found is not None else None
            if constant is not None:
                self._add(places[0], Meaning(constant.name, constant.name_span, constant))
                return True
        owner = None
        for k, name in enumerate(names):
            known = self.index.class_or_package(".".join(names[: k + 1]), first.span)
            if known is None:
                if owner is not None and (meaning := self._of_class(owner, name)) is not None:
                    self._add(places[k], meaning)
                break
            self._add(places[k], Meaning(known.name.rpartition(".")[2], known.name_span, known))
            owner = known
        return owner is not None

    def _of_class(self, owner: ClassDefinition, name: str) -> Meaning | None:
        """A value of an enumeration, or a constant of a package."""
        for literal in owner.literals:
            if literal.name == name:
                return Meaning(name, _first_part(literal.span), literal)
        constant = self.index.members(owner).get(name)
        return Meaning(name, constant.name_span, constant) if constant is not None else None

    def _member(self, reference: Reference) -> None:
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
        self.index.add(span, meaning, self.owner)


def _last_part(span: Span) -> Span:
    """Of a dotted name."""
    return Span(span.source, span.end - len(span.text.rpartition(".")[2].lstrip()), span.end)


def _first_part(span: Span) -> Span:
    """The name that a text begins with."""
    return Span(span.source, span.start, span.start + len((_PARTS.match(span.text) or [""])[0]))


def _find(name: str, span: Span) -> Span | None:
    """Where a name stands first in a piece of text, behind its first word or =."""
    if found := re.search(rf"(?:\bextends\s+|\bconstrainedby\s+|=\s*(?:\w+\s+)*?)({re.escape(name)})\b", span.text):
        return Span(span.source, span.start + found.start(1), span.start + found.end(1))
    return None
