"""What is right, but could be written better: what nothing uses, what hides something else, numbers without a name, names."""

import re
from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from typing import Any

from lagrangia.base.diagnostics import Diagnostic, Report, Source, Span
from lagrangia.editor.formatting import formatted
from lagrangia.editor.meanings import Index, class_named
from lagrangia.language.experiments import allowed_of
from lagrangia.language.functions import CONSTANTS, FUNCTIONS
from lagrangia.language.tree import (
    Binary,
    Call,
    ClassDefinition,
    Comprehension,
    Declaration,
    Extends,
    ForBlock,
    Number,
    String,
)

_CLASS_NAME = re.compile(r"[A-Z][A-Za-z0-9]*")
_FUNCTION_NAME = re.compile(r"[a-z][A-Za-z0-9_]*")
_LIKE_A_CLASS = re.compile(r"[A-Z][a-z]{2,}[A-Za-z]*")
_PLAIN = (0.0, 1.0)  # of which a quantity is no measured number: 0[m], 1[s]
_ANGLES = ("deg", "rad", "rev")


def look_at_style(index: Index) -> list[Diagnostic]:
    """Warnings L0801 to L0806, but those that the class they are about allows; of the layout any class of the text may."""
    found: list[Diagnostic] = []
    everywhere: set[str] = set()
    for definition, allowed in _classes(index, index.syntax.classes, ()):
        report = Report()
        for look in (_unused, _shadowed, _numbers, _names, _units_spelled_out):
            look(index, definition, report)
        found += [diagnostic for diagnostic in report.diagnostics if diagnostic.code not in allowed]
        everywhere.update(allowed)
    return found if "L0806" in everywhere else [*found, *_layout(index.syntax.source)]


def _classes(index: Index, classes: Sequence[ClassDefinition], allowed: tuple[str, ...]
             ) -> Iterator[tuple[ClassDefinition, tuple[str, ...]]]:
    """All of a text, those in others too, each with the codes that it or one around it allows."""
    for definition in classes:
        own = (*allowed, *allowed_of(index.table, definition))
        yield definition, own
        yield from _classes(index, definition.classes, own)


def _unused(index: Index, definition: ClassDefinition, report: Report) -> None:
    """Of files that end with a model that runs: what others import, these may use."""
    last = index.syntax.classes[-1]
    if definition is last or definition not in index.syntax.classes or last.kind != "model" or last.is_partial or not (
            definition.is_partial or definition.kind in ("function", "type")):
        return
    named = [found for found in index.occurrences
             if found.meaning.node is definition and found.owner is not definition]
    if not named:
        kind = f"partial {definition.kind}" if definition.is_partial else definition.kind
        report.warning("L0801", f"nothing in this file uses the {kind} '{definition.name}'", definition.name_span, "leave it out")


def _shadowed(index: Index, definition: ClassDefinition, report: Report) -> None:
    name = definition.name_span.text
    place = index.table.library[name].name_span if name in index.table.library else None
    is_itself = place is not None and place.source.text == definition.name_span.source.text
    if place is not None and not is_itself and definition in index.syntax.classes:
        report.warning("L0802", f"'{name}' hides the library's, which is at {place}", definition.name_span, "choose another name")
    elif definition.kind == "function" and name in FUNCTIONS:
        report.warning("L0802", f"'{name}' hides the language's own", definition.name_span, "choose another name")
    for element in definition.elements:
        if isinstance(element, Declaration) and element.name in CONSTANTS:
            report.warning("L0802", f"'{element.name}' hides the constant of the language", element.name_span,
                           "choose another name")
    members = index.members(definition)
    for loop in _nodes((definition.elements, definition.sections), ForBlock | Comprehension):
        for iterator in loop.iterators:
            if iterator.name in members:
                place = Span(iterator.span.source, iterator.span.start, iterator.span.start + len(iterator.name))
                report.warning("L0802", f"this '{iterator.name}' hides what is declared at {members[iterator.name].name_span}",
                               place, "choose another name for the iterator")


def _numbers(index: Index, definition: ClassDefinition, report: Report) -> None:
    """In equations, energies and formulas of variables; drawings, starts, parameters and variables that are a number alone are
    where such numbers belong."""
    written: list[Any] = [section.clauses for section in definition.sections if section.kind in ("equation", "energy")]
    written += [element.binding for element in definition.elements if isinstance(element, Declaration)
                and isinstance(element.binding, Binary) and not {"parameter", "constant"} & element.prefixes]
    for clauses in written:
        sampled = {id(number) for call in _nodes(clauses, Call) if call.function == "sample"
                   for number in _nodes(call.arguments, Number)}
        for number in _nodes(clauses, Number):
            if number.unit not in (None, "1", *_ANGLES) and number.value not in _PLAIN and id(number) not in sampled:
                report.warning("L0803", f"{number.span.text} stands in a formula without a name", number.span,
                               "declare it: parameter ... = " + number.span.text)


def _names(index: Index, definition: ClassDefinition, report: Report) -> None:
    is_function = definition.kind == "function"
    if not (_FUNCTION_NAME if is_function else _CLASS_NAME).fullmatch(definition.name):
        wanted = "a small letter, as in soft_step" if is_function else "a capital and has no _, as in SoftSpring"
        what = "a function" if is_function else f"a {definition.kind}"
        report.warning("L0804", f"the name of {what} begins with {wanted}", definition.name_span)
    for element in definition.elements:
        if not isinstance(element, Declaration) or not _LIKE_A_CLASS.fullmatch(element.name):
            continue
        kind = class_named(index.table, element.type_name, element.type_span)
        if element.type_name == "Frame" or (kind is not None and kind.kind != "type"):  # quantities may be symbols: Omega
            report.warning("L0804", f"'{element.name}' is called as classes are", element.name_span,
                           f"components begin with a small letter: {element.name[0].lower()}{element.name[1:]}")


def _units_spelled_out(index: Index, definition: ClassDefinition, report: Report) -> None:
    """Where a quantity type says the same, and its name means it there."""
    if definition.kind == "type":
        return
    types: dict[str, str] = {}
    for kind in index.table.library.values():
        if kind.kind == "type" and isinstance(kind.elements[0], Extends):
            for unit in _given_units(kind.elements[0]):
                types.setdefault(unit, kind.name)
    for element in definition.elements:
        if isinstance(element, Declaration) and element.type_name == "Real":
            for unit in _given_units(element):
                known = class_named(index.table, types[unit], element.type_span) if unit in types else None
                if known is not None and known.kind == "type":
                    report.warning("L0805", f"Real(unit = \"{unit}\") has a name", element.type_span,
                                   f"write {types[unit]} {element.name}")


def _given_units(element: Declaration | Extends) -> Iterator[str]:
    for argument in element.arguments:
        if argument.name == "unit" and isinstance(argument.value, String):
            yield argument.value.value


def _layout(source: Source) -> Iterator[Diagnostic]:
    text = formatted(source)
    if text == source.text:
        return
    before, after = source.text.splitlines(), text.splitlines()
    line = next((k for k, (old, new) in enumerate(zip(before, after, strict=False)) if old != new), min(len(before), len(after)))
    start = sum(len(row) + 1 for row in source.text.split("\n")[:line])
    stop = source.text.find("\n", start)
    place = Span(source, min(start, len(source.text)), stop if stop >= 0 else len(source.text))
    yield Diagnostic("warning", "L0806", "this is not laid out as lag format does it", place, hints=("lag format FILE",))


def _nodes(node: Any, kinds: Any) -> Iterator[Any]:
    if isinstance(node, tuple):
        for item in node:
            yield from _nodes(item, kinds)
    elif is_dataclass(node) and not isinstance(node, Span | Source):
        if isinstance(node, kinds):
            yield node
        for field in fields(node):
            yield from _nodes(getattr(node, field.name), kinds)
