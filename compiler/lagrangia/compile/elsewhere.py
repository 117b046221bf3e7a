"""What is wrong in a file beside the model that is run: in models, types and functions that it does not use."""

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

from lagrangia.base.diagnostics import Diagnostic, LagError, Source
from lagrangia.compile.pipeline import deep_recursion, read_files
from lagrangia.language.classes import ClassTable, build_class_table
from lagrangia.language.component_library import library
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.flattening import flatten
from lagrangia.language.syntax import parse
from lagrangia.language.tree import ClassDefinition, Declaration, Syntax

_LACKS_A_VALUE = "L0211"


def faults_elsewhere(path: Path) -> list[Diagnostic]:
    """All but values that only who uses a model can give. Raises LagError where the file cannot be read."""
    with deep_recursion():
        syntax, imported = read_files(path)
        return faults_beside(build_class_table(library(), [syntax, *imported]), syntax)


def faults_beside(table: ClassTable, syntax: Syntax) -> list[Diagnostic]:
    """The same of a file that is read, and its classes."""
    with deep_recursion():
        used = {element.type_name for c in syntax.classes for element in c.elements if element.type_name != c.name}
        run = next((c for c in reversed(syntax.classes) if c.kind == "model" and not c.is_partial), None)
        others = [c for c in syntax.classes if c.kind == "model" and c is not run and c.name not in used]
        found: dict[Diagnostic, None] = {}
        for definition in others:
            found |= dict.fromkeys(_faults(table, definition))
        for stand_in in _stand_ins(syntax, used):
            own = stand_in.name_span.source
            found |= dict.fromkeys(d for d in _faults(table, stand_in) if d.span is not None and d.span.source is not own)
        return list(found)


def _faults(table: ClassTable, definition: ClassDefinition) -> Iterator[Diagnostic]:
    try:
        check_dimensions(flatten(table, replace(definition, is_partial=False)))
    except LagError as error:
        yield from (diagnostic for diagnostic in error.diagnostics if diagnostic.code != _LACKS_A_VALUE)


def _stand_ins(syntax: Syntax, used: set[str]) -> Iterator[ClassDefinition]:
    """Models of which each calls a function of the file, or has a coordinate of a type that is not used."""
    for definition in syntax.classes:
        name, line = definition.name_span.text, ""
        if definition.kind == "function":
            inputs = [e for e in definition.elements if isinstance(e, Declaration) and "input" in e.prefixes]
            line = f"Real y = {name}({', '.join('1' for _ in inputs)});"
        elif definition.kind == "type" and definition.name not in used:
            line = f"coordinate {name} q;"
        if line:
            yield from parse(Source(syntax.source.name, f"model UsesIt {line} end UsesIt;")).classes
