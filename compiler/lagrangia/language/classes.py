"""Syntax trees -> ClassTable: which class a name means, and what a quantity type stands for."""

from collections.abc import Iterable
from dataclasses import field

from lagrangia.base.diagnostics import Report, Source, Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.tree import Argument, ClassDefinition, Declaration, Extends, Syntax

_FOREIGN = {"double": "Real", "float": "Real", "int": "Integer", "long": "Integer", "bool": "Boolean", "string": "String"}
BUILTIN_TYPES = frozenset({"Real", "Integer", "Boolean", "String", "Frame"})


@dataclass(frozen=True)
class ClassTable:
    """The classes of the library and of the user's files. A user's class hides a library class of the same name,
    but not from the library itself."""

    library: dict[str, ClassDefinition]
    user: dict[str, ClassDefinition]
    library_sources: frozenset[Source] = field(default_factory=frozenset)

    def lookup(self, name: str, span: Span) -> ClassDefinition:
        """The class that `name` means where `span` is. Raises LagError L0201."""
        if span.source not in self.library_sources and name in self.user:
            return self.user[name]
        if name in self.library:
            return self.library[name]
        known = {n for n, c in {**self.library, **self.user}.items() if c.kind != "function"} | BUILTIN_TYPES
        hint = f"a number is a {_FOREIGN[name]}, or a quantity such as Length" if name in _FOREIGN else suggest(name, known)
        fail("L0201", f"there is no model or type '{name}'", span, hint or 'is a file to be imported? import "file.lag";')

    def function(self, name: str, span: Span) -> ClassDefinition | None:
        """The function of that name which is seen from a place; None where there is none."""
        found = self.user.get(name) if span.source not in self.library_sources else None
        found = found or self.library.get(name)
        return found if found is not None and found.kind == "function" else None

    def base_type(self, name: str, span: Span) -> tuple[str, tuple[Argument, ...]] | None:
        """For a type: the builtin it derives from and its attributes, the innermost first; None for a model. Raises
        LagError L0206."""
        attributes: tuple[Argument, ...] = ()
        seen: list[str] = []
        while name not in BUILTIN_TYPES:
            definition = self.lookup(name, span)
            if definition.kind != "type":
                return None
            if name in seen:
                fail("L0206", f"type '{name}' is defined by itself", definition.name_span)
            seen.append(name)
            (extends,) = definition.elements
            assert isinstance(extends, Extends)
            attributes = extends.arguments + attributes
            name, span = extends.type_name, definition.span
        return name, attributes

    def declared(self, definition: ClassDefinition) -> dict[str, Declaration]:
        """Declarations of the class and of all it extends, by name."""
        return {e.name: e for base in self.lineage(definition) for e in base.elements if isinstance(e, Declaration)}

    def lineage(self, definition: ClassDefinition) -> list[ClassDefinition]:
        """The class and all it extends, each once, though it may extend itself."""
        found, pending = {id(definition): definition}, [definition]
        while pending:
            for element in pending.pop().elements:
                if isinstance(element, Extends) and element.type_name not in BUILTIN_TYPES:
                    base = self.lookup(element.type_name, element.span)
                    if id(base) not in found:
                        found[id(base)] = base
                        pending.append(base)
        return list(found.values())


def build_class_table(library: Iterable[Syntax], user: Iterable[Syntax]) -> ClassTable:
    """Raises LagError L0202 when a file set defines a name twice."""
    report = Report()
    library = tuple(library)
    tables = [_collect(files, report) for files in (library, tuple(user))]
    report.raise_errors()
    return ClassTable(tables[0], tables[1], frozenset(syntax.source for syntax in library))


def _collect(files: Iterable[Syntax], report: Report) -> dict[str, ClassDefinition]:
    classes: dict[str, ClassDefinition] = {}
    for definition in (c for syntax in files for c in syntax.classes):
        if definition.name in BUILTIN_TYPES:
            report.error("L0202", f"'{definition.name}' is a builtin type", definition.name_span, "choose another name")
        elif definition.name in classes:
            first = classes[definition.name].name_span
            report.error("L0202", f"'{definition.name}' is defined twice", definition.name_span, f"the first is at {first}")
        else:
            _check_members(definition, report)
            classes[definition.name] = definition
    return classes


def _check_members(definition: ClassDefinition, report: Report) -> None:
    seen: dict[str, Declaration] = {}
    for element in definition.elements:
        if isinstance(element, Declaration):
            if element.name in seen:
                report.error("L0202", f"'{element.name}' is declared twice in {definition.name}", element.name_span,
                             f"the first is at {seen[element.name].name_span}")
            seen.setdefault(element.name, element)
        _check_arguments(element.arguments, report)
    _check_arguments(definition.annotation, report)


def _check_arguments(arguments: tuple[Argument, ...], report: Report, given: dict[str, Argument] | None = None, path: str = ""
                     ) -> None:
    """Each value once, though its name may be opened in several brackets: s(start = 1), s(fixed = true)."""
    given = {} if given is None else given
    for argument in arguments:
        name = f"{path}{argument.name}"
        if argument.value is not None and name in given:
            first = given[name].name_span
            report.error("L0202", f"'{argument.name}' is given twice", argument.name_span, f"the first is at {first}")
        if argument.value is not None:
            given.setdefault(name, argument)
        _check_arguments(argument.arguments, report, given, f"{name}.")
