"""What is wrong in a file beside the model that is run: in models, types and functions that it does not use."""

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from lagrangia.base.diagnostics import Diagnostic, LagError, Source
from lagrangia.base.records import dataclass
from lagrangia.compile.packages import Packages
from lagrangia.compile.pipeline import compile_file, deep_recursion, read_files
from lagrangia.language.classes import ClassTable, build_class_table
from lagrangia.language.component_library import library_classes
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.flattening import flatten
from lagrangia.language.syntax import parse
from lagrangia.language.tree import ClassDefinition, Declaration, Extends, Number, Syntax

_LACKS_A_VALUE = "L0211"
_NOTHING_MOVES = "L0505"
_OUT_OF_LIMITS = "L0605"


@dataclass(frozen=True)
class Beside:
    """A model beside the one that is run, by its full name; `is_whole`: all that needs a value has one. A scene can be run as it
    is; a part leaves places to who uses it, or only computes something, and of it only the values are what they are."""

    name: str
    is_whole: bool
    is_scene: bool

    def is_fault(self, diagnostic: Diagnostic) -> bool:
        """Whether it is one of this model, whatever it is used for."""
        return diagnostic.code != _NOTHING_MOVES if self.is_scene else diagnostic.code == _OUT_OF_LIMITS


def faults_elsewhere(path: Path) -> list[Diagnostic]:
    """All but values that only who uses a model can give. Raises LagError where the file cannot be read."""
    with deep_recursion():
        syntax, imported = read_files(path)
        return faults_beside(build_class_table(library_classes(), [syntax, *imported], Packages(syntax).find), syntax)


def faults_beside(table: ClassTable, syntax: Syntax) -> list[Diagnostic]:
    """The same of a file that is read, and its classes."""
    with deep_recursion():
        own = [c for c in table.user.values() if c.name_span.source is syntax.source]
        used = {element.type_name.rpartition(".")[2] for c in own for element in c.elements if element.type_name != c.name}
        own = [c for c in own if not _waits(table, c)]
        others = [c for c in _models_beside(own, syntax) if c.name_span.text not in used]
        found: dict[Diagnostic, None] = {}
        for definition in others:
            found |= dict.fromkeys(_faults(table, definition))
        for package in (c for c in own if c.kind == "package"):
            found |= dict.fromkeys(_faults_of_package(table, package))
        for stand_in in _stand_ins(table, syntax.source.name, own, used):
            place = stand_in.name_span.source
            found |= dict.fromkeys(d for d in _faults(table, stand_in) if d.span is not None and d.span.source is not place)
        return list(found)


def _waits(table: ClassTable, definition: ClassDefinition) -> bool:
    """Whether something else has to be put in its place, or in its parts, before it says anything."""
    around = definition.name.split(".")
    outer = (table.user.get(".".join(around[:k])) for k in range(1, len(around)))
    if any(c is not None and c.is_partial for c in outer):
        return True
    try:
        return any("replaceable" in inner.prefixes for c in table.lineage(definition) for inner in c.classes)
    except LagError:  # which is told of what is looked at
        return False


def models_beside(path: Path) -> list[Beside]:
    """All but partial ones, and those that stand in another model of the file or are extended there, with which they
    are checked. Raises LagError where the file cannot be read."""
    with deep_recursion():
        syntax, imported = read_files(path)
        table = build_class_table(library_classes(), [syntax, *imported], Packages(syntax).find)
        own = [c for c in table.user.values() if c.name_span.source is syntax.source]
        placed = {e.type_name.rpartition(".")[2] for c in own for e in c.elements if isinstance(e, Declaration | Extends)}
        found = []
        for c in _models_beside(own, syntax):
            if not c.is_partial and c.name_span.text not in placed and not _waits(table, c):
                is_whole = _is_whole(table, c)
                found.append(Beside(c.name, is_whole, is_whole and _stands_alone(table, c)))
        return found


def faults_of_motion(path: Path) -> list[Diagnostic]:
    """What all phases of the compiler say of the models of a file, and of the values in them, first of the one that is run.
    Raises LagError where the file cannot be read."""
    found = dict.fromkeys(_compiled_faults(path, None))
    for other in models_beside(path):
        found |= dict.fromkeys(filter(other.is_fault, _compiled_faults(path, other.name) if other.is_whole else ()))
    return list(found)


def _compiled_faults(path: Path, name: str | None) -> tuple[Diagnostic, ...]:
    from lagrangia.constraints.parameters import require_possible

    try:
        require_possible(compile_file(path, name).kinematics)
    except LagError as error:
        return error.diagnostics
    return ()


def _models_beside(own: Sequence[ClassDefinition], syntax: Syntax) -> list[ClassDefinition]:
    run = next((c for c in reversed(syntax.classes) if c.kind in ("model", "block") and not c.is_partial), None)
    return [c for c in own if c.kind in ("model", "block") and not (run and c.name_span == run.name_span)]


def _is_whole(table: ClassTable, definition: ClassDefinition) -> bool:
    """Whether it flattens, with a value for all that needs one."""
    try:
        check_dimensions(flatten(table, definition))
    except LagError:
        return False
    return True


def _stands_alone(table: ClassTable, definition: ClassDefinition) -> bool:
    """Whether it has no port that who uses it would join to something."""
    return not any(_is_port(table, declaration) for declaration in table.declared(definition).values())


def _is_port(table: ClassTable, declaration: Declaration) -> bool:
    if declaration.binding is not None or "protected" in declaration.prefixes:
        return False
    found = table.found(declaration.type_name, declaration.type_span)
    return declaration.type_name == "Frame" or (found is not None and found.kind == "connector")


def _faults(table: ClassTable, definition: ClassDefinition) -> Iterator[Diagnostic]:
    try:
        check_dimensions(flatten(table, replace(definition, is_partial=False)))
    except LagError as error:
        yield from (diagnostic for diagnostic in error.diagnostics if diagnostic.code != _LACKS_A_VALUE)


def _faults_of_package(table: ClassTable, package: ClassDefinition) -> list[Diagnostic]:
    """Of its constants, but of those without a value."""
    try:
        table.refuse_circle(package)
        return list(_faults(table, replace(package, kind="model")))
    except LagError as error:
        return list(error.diagnostics)


def _some(table: ClassTable, declaration: Declaration) -> str:
    """What could be given to an input; "" where that is not known: records, and arrays of any size."""
    found = table.found(declaration.type_name, declaration.type_span)
    base = table.base_type(declaration.type_name, declaration.type_span) if found is None or found.kind == "type" else None
    dimensions = (*declaration.dimensions, *(base.dimensions if base is not None else ()))
    sizes = [size.value for size in dimensions if isinstance(size, Number)]
    if base is None or len(sizes) < len(dimensions):
        return ""
    one = "true" if base.builtin == "Boolean" else "1"
    return f"fill({one}, {', '.join(f'{size:g}' for size in sizes)})" if sizes else one


def _stand_ins(table: ClassTable, file: str, own: Sequence[ClassDefinition], used: set[str]) -> Iterator[ClassDefinition]:
    """Models of which each calls a function of the file, or has a coordinate of a type that is not used."""
    for definition in own:
        name, line = definition.name_span.text, ""
        if "." in definition.name:
            name = definition.name
        if definition.kind == "function":
            inputs = [e for e in definition.elements if isinstance(e, Declaration) and "input" in e.prefixes]
            some = [_some(table, declaration) for declaration in inputs]
            line = f"Real y = {name}({', '.join(some)});" if all(some) else ""
        elif definition.kind == "type" and definition.name_span.text not in used and not definition.literals:
            line = f"coordinate {name} q;"
        if line:
            yield from parse(Source(file, f"model UsesIt {line} end UsesIt;")).classes
