"""Syntax trees -> ClassTable: which class a name means, and what a quantity type stands for."""

from collections import ChainMap
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import field, replace
from functools import cached_property

from lagrangia.base.diagnostics import LIBRARY, Report, Source, Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.component_library import library_package, packages_with
from lagrangia.language.foreign_words import FOREIGN_CALLS, FOREIGN_TYPES, section_meant
from lagrangia.language.functions import FUNCTIONS
from lagrangia.language.plain_tree import PlainClasses
from lagrangia.language.scoping import Finder, Scopes, has_scopes, lifted, nowhere
from lagrangia.language.tree import Argument, Array, ClassDefinition, Declaration, Expression, Extends, Section, Syntax
from lagrangia.language.variants import COMPONENTS, Variants

BUILTIN_TYPES = frozenset({"Real", "Integer", "Boolean", "String", "Frame"})
_OF_CLASSES = frozenset({"encapsulated", "replaceable", "redeclare", "final", "protected", "extends"})
ENUMERATION = "enumeration"


@dataclass(frozen=True)
class BaseType:
    """The builtin type that a type derives from (ENUMERATION: one of people's own, `definition`), its attributes, the outermost
    first, sizes, and prefixes as of a connector that is an input."""

    builtin: str
    attributes: tuple[Argument, ...] = ()
    dimensions: tuple[Expression, ...] = ()
    prefixes: frozenset[str] = frozenset()
    definition: ClassDefinition | None = None


_BUILTIN = {name: BaseType(name) for name in BUILTIN_TYPES}


@dataclass(frozen=True)
class ClassTable:
    """The classes of the library and of the user's files, those in packages by their full names. A user's class hides a library
    class of the same name, but not from the library itself."""

    library: Mapping[str, ClassDefinition]
    user: dict[str, ClassDefinition]
    library_sources: set[Source] = field(default_factory=set)  # with those of its packages that are named
    files: dict[Source, Syntax] = field(default_factory=dict)  # those in which names may mean something else in each class
    find: Finder = nowhere
    functions: dict[int, tuple[ClassDefinition, ClassDefinition]] = field(default_factory=dict)  # with what they extend, by ids

    @cached_property
    def scopes(self) -> Scopes:
        """Looks names up by what encloses them."""
        return Scopes(ChainMap({}, self.user), self.files, self._take, lambda name: self.find(name) or library_package(name),
                      lambda name: self.variants.settled(name) if name in self.scopes.classes else None)

    @cached_property
    def variants(self) -> Variants:
        """Classes as they are in what inherits or redeclares them."""
        return Variants(self, self._share, BUILTIN_TYPES)

    def _share(self, old: Source, new: Source) -> None:
        self.files[new] = Syntax(new, (), ())
        if old in self.library_sources:
            self.library_sources.add(new)

    def settled(self, definition: ClassDefinition) -> ClassDefinition:
        """The class with what it inherits as it is in it, where it changes that. Raises LagError L0234, L0235."""
        if definition.span.source in self.files and self.scopes.classes.get(definition.name) is not None:
            found = self.variants.settled(definition.name)
            return replace(found, is_partial=definition.is_partial) if found.is_partial is not definition.is_partial else found
        return definition

    def _take(self, syntax: Syntax) -> None:
        report = Report()
        self.user.update(_collect([syntax], report, self.user))
        self.files[syntax.source] = syntax
        if syntax.source.name.startswith(LIBRARY):
            self.library_sources.add(syntax.source)
        report.raise_errors()

    def takes_class(self, definition: ClassDefinition, name: str) -> bool:
        """Whether a class in another one is redeclared by making the other one anew: packages, functions, types, and records and
        models but those that are the types of components alone."""
        if definition.span.source not in self.files or definition.name not in self.scopes.classes:
            return False
        found = self.variants.inner(definition.name, name)
        return found is not None and not (
            found[1].kind in ("record", *COMPONENTS) and self.variants.is_of_components(definition.name, found[1]))

    def is_of_components(self, definition: ClassDefinition, inner: ClassDefinition) -> bool:
        """Whether no other class in a class uses one that stands in it, or in what it extends."""
        return definition.name not in self.scopes.classes or self.variants.is_of_components(definition.name, inner)

    def found(self, name: str, span: Span) -> ClassDefinition | None:
        """The class that `name` means where `span` is; None where there is none. Raises LagError L0204 for imports of nothing."""
        is_library = span.source in self.library_sources
        if name.startswith("."):
            return self.variants.settled(name[1:])
        if span.source in self.files or (not is_library and "." in name):
            full = self.scopes.full_name(name, span)
            if full is not None and full in self.scopes.classes and not (
                    is_library and self.scopes.classes[full].span.source not in self.library_sources):
                return self.variants.settled(full)
        elif not is_library and name in self.user:
            return self.user[name]
        return self.library.get(name)

    def lookup(self, name: str, span: Span) -> ClassDefinition:
        """The class that `name` means where `span` is. Raises LagError L0201."""
        definition = self.found(name, span)
        if definition is not None:
            return definition
        kinds = {**_kinds(self.library), **_kinds(self.user)}
        known = {n for n, kind in kinds.items() if kind != "function"} | BUILTIN_TYPES
        if name.startswith("Modelica."):
            fail("L0201", f"'{name}' is of the Modelica Standard Library, which is not here", span,
                 *_of_modelica(name, self.library))
        if name in FUNCTIONS:
            fail("L0201", f"'{name}' is a function of the language, no class", span, "a function of one's own may call it: "
                 f"function f input Real x; output Real y; algorithm y := {name}(x); end f;")
        if name == "Clock":
            fail("L0901", "not of this language: Clock", span, FOREIGN_CALLS[name])
        if name == "ExternalObject":
            fail("L0901", "not of this language: external objects", span, "give the values as a table of a file: lag help tables")
        hint = FOREIGN_TYPES.get(name) or suggest(name, known)
        inside = [full for full in self.user if full.rpartition(".")[2] == name]
        if inside:
            hint = f"did you mean '{inside[0]}'?"
        elif packages := packages_with(name):
            hint = f"it is in {' and in '.join(packages)}: import {packages[0]}.{name};"
        fail("L0201", f"there is no model or type '{name}'", span, hint or 'is a file to be imported? import "file.lag";')

    def function(self, name: str, span: Span) -> ClassDefinition | None:
        """The function of that name which is seen from a place, with what it extends; None where there is none. Raises LagError
        L0205, L0206."""
        found = self.found(name, span)
        return self._whole_function(found, ()) if found is not None and found.kind == "function" else None

    def _whole_function(self, definition: ClassDefinition, heirs: tuple[ClassDefinition, ...]) -> ClassDefinition:
        """With inputs, results and algorithms of what it extends before its own."""
        if any(definition is heir for heir in heirs):
            fail("L0206", f"{definition.name} extends itself", definition.name_span)
        if all(isinstance(e, Declaration) for e in definition.elements):
            return definition
        if id(definition) not in self.functions:
            elements: list[Declaration | Extends] = []
            sections: list[Section] = []
            for element in definition.elements:
                if isinstance(element, Declaration):
                    elements.append(element)
                    continue
                base = self.lookup(element.type_name, element.span)
                if base.kind != "function":
                    fail("L0205", f"a function cannot extend the {base.kind} '{base.name}'", element.span)
                whole = self._whole_function(base, (*heirs, definition))
                elements += _given(whole, element.arguments)
                sections += whole.sections
            whole = replace(definition, elements=tuple(elements), sections=(*sections, *definition.sections))
            self.functions[id(definition)] = definition, whole
        return self.functions[id(definition)][1]

    def base_type(self, name: str, span: Span) -> BaseType | None:
        """For a type: the builtin it derives from and its attributes; None for a model. Raises LagError L0206."""
        if name in BUILTIN_TYPES:
            return _BUILTIN[name]
        definition = self.lookup(name, span)
        if definition.kind not in ("type", "connector"):
            return None
        if definition.is_partial and definition.kind == "type":
            fail("L0205", f"'{name}' is any enumeration, enumeration(:): another one has to take its place", span,
                 f"where this is used: (redeclare type {definition.name_span.text} = ...)")
        return self._base_of(definition, ())

    def _base_of(self, definition: ClassDefinition, seen: tuple[ClassDefinition, ...]) -> BaseType | None:
        if any(definition is one for one in seen):
            fail("L0206", f"type '{definition.name}' is defined by itself", definition.name_span)
        if definition.literals:
            return BaseType(ENUMERATION, definition=definition)
        if definition.kind not in ("type", "connector") or len(definition.elements) != 1:
            return None
        (extends,) = definition.elements
        if not isinstance(extends, Extends):
            return None
        name = extends.type_name
        base = _BUILTIN[name] if name in BUILTIN_TYPES else self._base_of(self.lookup(name, extends.span), (*seen, definition))
        if base is None or (base.builtin == "Frame" and definition.kind == "connector"):
            return base
        final = {a.name: a for a in base.attributes if "final" in a.prefixes}
        for a in (a for a in extends.arguments if a.name in final):
            fail("L0227", f"'{a.name}' is final: it keeps the value that it was declared with", a.name_span,
                 f"it was made final at {final[a.name].span}; leave this out, or take `final` away there")
        return BaseType(base.builtin, extends.arguments + base.attributes, (*extends.dimensions, *base.dimensions),
                        base.prefixes | extends.prefixes, base.definition)

    def declared(self, definition: ClassDefinition) -> dict[str, Declaration]:
        """Declarations of the class and of all it extends, by name, with the values that extends clauses give them."""
        lineage = self.lineage(definition)
        found = {e.name: e for base in lineage for e in base.elements if isinstance(e, Declaration)}
        for base in reversed(lineage):
            for argument in (a for e in base.elements if isinstance(e, Extends) for a in e.arguments):
                if argument.value is not None and argument.name in found:
                    found[argument.name] = replace(found[argument.name], binding=argument.value)
        return found

    def as_extended(self, definition: ClassDefinition) -> dict[str, Declaration]:
        """As `declared`, with those that extends clauses redeclare in the places of what is inherited."""
        found = self.declared(definition)
        for base in reversed(self.lineage(definition)):
            for a in (a for e in base.elements if isinstance(e, Extends) for a in e.arguments):
                if a.redeclared is not None and not a.redeclared.kind and a.name in found:
                    found[a.name] = a.redeclared
        return found

    def refuse_circle(self, definition: ClassDefinition, heirs: tuple[ClassDefinition, ...] = (),
                      clear: dict[int, ClassDefinition] | None = None) -> None:
        """Raises LagError L0206 for a class that extends itself; `clear` are those that do not, by their ids."""
        clear = {} if clear is None else clear
        if id(definition) in clear:
            return
        if any(definition is heir for heir in heirs):
            fail("L0206", f"{definition.name} extends itself", definition.name_span,
                 " > ".join(heir.name for heir in (*heirs, definition)))
        for element in definition.elements:
            if isinstance(element, Extends) and element.type_name not in BUILTIN_TYPES:
                self.refuse_circle(self.lookup(element.type_name, element.span), (*heirs, definition), clear)
        clear[id(definition)] = definition

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


def _given(function: ClassDefinition, arguments: tuple[Argument, ...]) -> Iterator[Declaration | Extends]:
    """What a function declares, with the values that another one gives it. Raises LagError L0203."""
    names = {e.name for e in function.elements if isinstance(e, Declaration)}
    for argument in arguments:
        if argument.name not in names:
            fail("L0203", f"{function.name} has no input '{argument.name}'", argument.name_span, *filter(None, [
                suggest(argument.name, names)]))
    values = {a.name: a for a in arguments}
    for element in function.elements:
        given = values.get(element.name) if isinstance(element, Declaration) else None
        if given is None or not isinstance(element, Declaration):
            yield element
        else:
            yield replace(element, binding=given.value if given.value is not None else element.binding,
                          arguments=(*element.arguments, *given.arguments))


def _kinds(classes: Mapping[str, ClassDefinition]) -> Mapping[str, str]:
    """What each is: no class of the library is made for it."""
    return classes.kinds if isinstance(classes, PlainClasses) else {name: found.kind for name, found in classes.items()}


def _of_modelica(name: str, library: Mapping[str, ClassDefinition]) -> list[str]:
    last = name.rpartition(".")[2]
    is_alike = last in library and (library[last].kind == "type") is (".Units." in name or ".SIunits." in name)
    return [f"the library of this language has {last} of its own: write {last}" if is_alike else
            suggest(last, library) or "lag help library lists what there is"]


def build_class_table(library: Iterable[Syntax] | PlainClasses, user: Iterable[Syntax], find: Finder = nowhere) -> ClassTable:
    """`find` brings packages of folders when they are named. Raises LagError L0202 when a file set defines a name twice."""
    report, user = Report(), tuple(user)
    if isinstance(library, PlainClasses):
        known: Mapping[str, ClassDefinition] = library
        sources = {*library.sources}
    else:
        library = tuple(library)
        known, sources = _collect(library, report, {}), {syntax.source for syntax in library}
    own = _collect(user, report, {})
    report.raise_errors()
    scoped = {syntax.source: syntax for syntax in user} if any(map(has_scopes, user)) else {}
    return ClassTable(known, own, sources, scoped, find)


def _collect(files: Iterable[Syntax], report: Report, known: dict[str, ClassDefinition]) -> dict[str, ClassDefinition]:
    classes: dict[str, ClassDefinition] = {}
    files = tuple(files)
    for definition in (c for syntax in files for c in lifted(syntax)):
        first = classes.get(definition.name) or known.get(definition.name)
        if definition.name in BUILTIN_TYPES:
            report.error("L0202", f"'{definition.name}' is a builtin type", definition.name_span, "choose another name")
        elif first is not None:
            report.error("L0202", f"'{definition.name}' is defined twice", definition.name_span,
                         f"the first is at {first.name_span}")
        else:
            _check_members(definition, report)
            classes[definition.name] = definition
    for top in (c for syntax in files for c in syntax.classes if "redeclare" in c.prefixes):
        report.error("L0234", f"'{top.name}' stands in no class that inherits another one of this name", top.name_span,
                     "leave `redeclare` out: this is a class of its own")
    return classes


def _check_members(definition: ClassDefinition, report: Report) -> None:
    seen: dict[str, Declaration] = {}
    for k, literal in enumerate(definition.literals):
        if literal.name in [one.name for one in definition.literals[:k]]:
            report.error("L0202", f"'{literal.name}' is twice a value of {definition.name}", literal.span)
    if definition.kind == "function":
        for extends in (e for e in definition.elements if isinstance(e, Extends) and e.type_name == "der"):
            report.error("L0901", "not of this language: functions that are derivatives of others", extends.span,
                         "der(f(x)) is computed exactly")
    for element in definition.elements:
        if isinstance(element, Declaration):
            if element.name in seen:
                report.error("L0202", f"'{element.name}' is declared twice in {definition.name}", element.name_span,
                             section_meant(element.type_name) or f"the first is at {seen[element.name].name_span}")
            seen.setdefault(element.name, element)
            _check_prefixes(element, report)
        _check_arguments(element.arguments, report)
        _check_left_out(element.arguments, isinstance(element, Extends), report)
    _check_arguments(definition.annotation, report)
    _check_class_prefixes(definition, report)


def _check_prefixes(element: Declaration, report: Report) -> None:
    if "encapsulated" in element.prefixes:
        report.error("L0236", "a class is encapsulated, a component cannot be", element.name_span, "leave `encapsulated` out")
    if element.constraining is not None and not element.prefixes & {"replaceable", "redeclare"}:
        report.error("L0234", f"'{element.name}' is not replaceable, so that constrainedby has no effect",
                     element.constraining.span, "write `replaceable` before the declaration")


def _check_class_prefixes(definition: ClassDefinition, report: Report) -> None:
    if wrong := definition.prefixes - _OF_CLASSES:
        report.error("L0236", f"a class cannot be {' '.join(sorted(wrong))}", definition.name_span,
                     "numbers can: they are declared as `parameter Real x`")
    if "extends" in definition.prefixes and "redeclare" not in definition.prefixes:
        kind, name = definition.kind, definition.name_span.text
        report.error("L0234", f"`{kind} extends {name}` extends what is inherited, and takes its place", definition.name_span,
                     f"in a class that extends another one: redeclare {kind} extends {name} ... end {name};",
                     f"or give it a name of its own: {kind} N extends {name}; ... end N;")


def _check_left_out(arguments: tuple[Argument, ...], is_extends: bool, report: Report) -> None:
    for argument in arguments:
        if argument.is_left_out and not is_extends:
            report.error("L0236", "break leaves out what is inherited: it stands in extends", argument.span,
                         "a component that may be missing has a condition: Spring s if has_spring;")
        _check_left_out(argument.arguments, False, report)


def _check_arguments(arguments: tuple[Argument, ...], report: Report, given: dict[str, Argument] | None = None, path: str = ""
                     ) -> None:
    """Each value once, though its name may be opened in several brackets: s(start = 1), s(fixed = true)."""
    given = {} if given is None else given
    for argument in arguments:
        name = f"{path}{argument.name}"
        if argument.is_left_out and isinstance(argument.value, Array):  # a connection, which has no name but its text
            name += f"({', '.join(map(str, argument.value.items))})"
        if argument.value is not None and name in given:
            first = given[name].name_span
            report.error("L0202", f"'{argument.name}' is given twice", argument.name_span, f"the first is at {first}")
        if argument.value is not None:
            given.setdefault(name, argument)
        _check_arguments(argument.arguments, report, given, f"{name}.")
