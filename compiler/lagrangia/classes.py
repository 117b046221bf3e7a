"""Syntax trees -> ClassTable: which class a name means, and what a quantity type stands for."""

from collections.abc import Iterable
from dataclasses import dataclass, field

from lagrangia.diagnostics import Report, Source, Span, fail, suggest
from lagrangia.tree import Argument, ClassDefinition, Declaration, Extends, Syntax

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
        fail("L0201", f"there is no model or type '{name}'", span, *filter(None, [suggest(name, known)]))

    def function(self, name: str, span: Span) -> ClassDefinition | None:
        found = self.user.get(name) if span.source not in self.library_sources else None
        found = found or self.library.get(name)
        return found if found is not None and found.kind == "function" else None

    def base_type(self, name: str, span: Span) -> tuple[str, tuple[Argument, ...]] | None:
        """For a type: the builtin it derives from and its attributes, the innermost first. None for a model."""
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

    def ancestors(self, definition: ClassDefinition) -> set[str]:
        """Names of the class and of all it extends."""
        names = {definition.name}
        for element in definition.elements:
            if isinstance(element, Extends) and element.type_name not in BUILTIN_TYPES:
                base = self.lookup(element.type_name, element.span)
                if base.name not in names:
                    names |= self.ancestors(base)
        return names


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
