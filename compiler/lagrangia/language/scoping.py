"""What a name means where it is written: classes in classes, imports, packages (Modelica 3.6, sections 5.3 and 13.2)."""

from collections.abc import Callable, Iterable, Iterator, MutableMapping, Sequence
from dataclasses import field, replace

from lagrangia.base.diagnostics import Source, Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.functions import FUNCTIONS, OF_MATH
from lagrangia.language.tree import ClassDefinition, Declaration, Extends, Import, Syntax

KERNEL = "Modelica.Math"  # whose functions are those of this language
Finder = Callable[[str], Syntax | None]  # the file of a package, or of a class of one


def nowhere(name: str) -> Syntax | None:
    """Where there is no folder to look for packages."""
    return None


@dataclass(frozen=True)
class Enclosing:
    """A class or file that names are looked up in: the full name ("" of a file beside no package), and its imports. `only`: the
    class of which it has what is named there, where that was written in another one than the heir (variants.py)."""

    name: str
    imports: tuple[Import, ...]
    only: str = ""


@dataclass(frozen=True)
class Copy:
    """A class as an heir has it, by the names of both, and what is around the class that was copied."""

    definition: ClassDefinition
    heir: str
    base: str
    outer: tuple[Enclosing, ...]


def lifted(syntax: Syntax) -> Iterator[ClassDefinition]:
    """All classes of a file, those inside others too, by their full names."""
    def inside(definition: ClassDefinition, prefix: str) -> Iterator[ClassDefinition]:
        name = f"{prefix}{definition.name}"
        yield replace(definition, name=name) if prefix else definition
        for inner in definition.classes:
            yield from inside(inner, f"{name}.")

    for definition in syntax.classes:
        yield from inside(definition, f"{syntax.within}." if syntax.within else "")


def has_scopes(syntax: Syntax) -> bool:
    """Whether a name of the file may mean something else than a class beside it."""
    return bool(syntax.within or syntax.named or any(c.classes or c.imports for c in syntax.classes))


def _inside(span: Span, classes: Sequence[ClassDefinition], prefix: str) -> list[Enclosing]:
    """The classes in classes that a place lies in, the outermost first."""
    found: list[Enclosing] = []
    while one := next((c for c in classes if c.span.start <= span.start < c.span.end), None):
        found.append(Enclosing(f"{prefix}{one.name}", one.imports))
        prefix, classes = f"{prefix}{one.name}.", one.classes
    return found


@dataclass
class Scopes:
    """Looks for classes by what encloses the place where they are named. `classes` is filled with what is found on the way."""

    classes: MutableMapping[str, ClassDefinition]
    files: dict[Source, Syntax]
    take: Callable[[Syntax], None]  # puts the classes of one more file among the others
    find: Finder
    settled: Callable[[str], object]  # makes what a class inherits its own where it changes that
    copies: dict[Source, Copy] = field(default_factory=dict)
    used: set[str] = field(default_factory=set)  # short names that imports gave a meaning
    _known: dict[tuple[str, str, int], str | None] = field(default_factory=dict)
    _missing: set[str] = field(default_factory=set)
    _looking: set[tuple[str, str]] = field(default_factory=set)

    def full_name(self, name: str, span: Span) -> str | None:
        """The full name of the class that `name` means where `span` is; None where there is none. Raises LagError L0204."""
        around = self.around(span)
        key = name, around[0].name if around else "", id(span.source)
        if key not in self._known:
            self._known[key] = self._resolved(name, around)
        return self._known[key]

    def package(self, name: str, span: Span) -> str | None:
        """The full name of the package or class that the beginning of a dotted name means where `span` is."""
        return self._resolved(f"{name}.", self.around(span)) if name else None

    def of_kernel(self, name: str, span: Span) -> str | None:
        """The function of the language that a name means where `span` is, by an import or written in full; None of others."""
        package, _, last = (self.full_name(name, span) or "").rpartition(".")
        if package != KERNEL and last != name:
            package, _, last = name.rpartition(".")
            package = self.package(package, span) or ""
        return last if package == KERNEL and last in FUNCTIONS else None

    def around(self, span: Span) -> list[Enclosing]:
        """What encloses a place, the innermost first."""
        if (copy := self.copies.get(span.source)) is not None:
            inside = _inside(span, copy.definition.classes, f"{copy.heir}.")
            return [*inside[::-1], Enclosing(copy.heir, copy.definition.imports, copy.base), *copy.outer]
        syntax = self.files.get(span.source)
        if syntax is None:
            return []
        prefix = f"{syntax.within}." if syntax.within else ""
        packages = syntax.within.split(".") if syntax.within else []
        found = [Enclosing(".".join(packages[:k]), ()) for k in range(1, len(packages) + 1)]
        found.insert(0, Enclosing("", syntax.named))
        return [*found, *_inside(span, syntax.classes, prefix)][::-1]

    def constant(self, name: str, span: Span) -> tuple[ClassDefinition, str] | None:
        """The class around a place, or the package of an import, that declares a constant; and its name there."""
        for scope in self.around(span):
            if scope.name and self.declares(scope.name, name) and (not scope.only or self.declares(scope.only, name)):
                return self.classes[scope.name], name
            for package, element in self._imported(name, scope):
                if package and self._reach(package) and self.declares(package, element):
                    self.used.add(name)
                    return self.classes[package], element
        return None

    def declares(self, owner: str, name: str) -> bool:
        """Whether a class or what it extends has a constant of this name."""
        self.settled(owner)
        return any(isinstance(e, Declaration) and e.name == name and "constant" in e.prefixes
                   for base in self.lineage(owner) for e in self.classes[base].elements)

    def lineage(self, name: str) -> list[str]:
        """A class and all it extends, as far as they are known, by their full names."""
        found = [name] if name in self.classes else []
        for owner in found:
            for element in self.classes[owner].elements:
                base = self.base(element, owner) if isinstance(element, Extends) else None
                if base is not None and base not in found:
                    found.append(base)
        return found

    def base(self, element: Extends, owner: str) -> str | None:
        """Of an extends clause. What it names is not looked for in what the class inherits."""
        if element.type_name.startswith("."):
            return element.type_name[1:]
        if (owner, element.type_name) in self._looking:
            return None
        self._looking.add((owner, element.type_name))
        try:
            return self._resolved(element.type_name, [e for e in self.around(element.span) if e.name != owner] or [])
        finally:
            self._looking.discard((owner, element.type_name))

    def _resolved(self, name: str, around: Iterable[Enclosing]) -> str | None:
        if name.startswith("."):  # a full name
            return name[1:] if self._reach(name[1:]) else None
        first, *rest = name.split(".")
        at = self._first(first, around, bool(rest))
        for step in filter(None, rest):
            owner, at = at, self._within(at, step) if at is not None else None
            if owner is not None and at is not None:
                self._refuse_redeclared(owner, step)
        return at

    def _refuse_redeclared(self, owner: str, name: str) -> None:
        """Raises LagError L0901 for a class that is redeclared for components alone where another one inherits it."""
        for heir in self.lineage(owner):
            if f"{heir}.{name}" in self.classes:
                return
            for argument in (a for e in self.classes[heir].elements if isinstance(e, Extends) for a in e.arguments):
                if argument.name == name and argument.redeclared is not None and "class" in argument.redeclared.prefixes:
                    fail("L0901", f"not supported yet: '{name}' of {heir}, which is redeclared here, as the type of what stands "
                         "elsewhere", argument.span, f"write there what it is: {argument.redeclared.type_name}")

    def _first(self, name: str, around: Iterable[Enclosing], is_package: bool) -> str | None:
        for scope in around:
            if not scope.only and scope.name and scope.name.rpartition(".")[2] == name and scope.name in self.classes:
                return scope.name
            if scope.only and scope.only.rpartition(".")[2] == name:
                return scope.name
            if scope.name and (not scope.only or self._within(scope.only, name) is not None) and (
                    found := self._within(scope.name, name)) is not None:
                return found
            for package, element in self._imported(name, scope):
                if (full := self._imports(f"{package}.{element}" if package else element)) is not None:
                    self.used.add(name)
                    return full
        return name if name in self.classes or (is_package and self._reach(name)) else None

    def _within(self, owner: str, name: str, seen: tuple[str, ...] = ()) -> str | None:
        """A class that stands in another one, or in what that extends."""
        self.settled(owner)
        if self._reach(f"{owner}.{name}") or (owner == KERNEL and name in OF_MATH and self._reach(owner)):
            return f"{owner}.{name}"
        for element in self.classes[owner].elements if owner in self.classes else ():
            base = self.base(element, owner) if isinstance(element, Extends) else None
            if base is None or base not in self.classes or base in (owner, *seen):
                continue
            if found := self._within(base, name, (*seen, owner)):
                return found
        return None

    def _imported(self, name: str, scope: Enclosing) -> Iterator[tuple[str, str]]:
        """What imports say that a name is: a package and the name in it. Names come before all of a package."""
        for item in scope.imports:
            for short, full in item.names:
                if short == name:
                    package, _, element = full.rpartition(".")
                    if self._imports(full) is None and not (self._reach(package) and self.declares(package, element)):
                        fail("L0204", f"there is no '{full}' to be imported", item.span, *self._hints(package or full))
                    yield package, element
        for item in scope.imports:
            for short, full in item.names:
                if short == "*":
                    if not self._reach(full):
                        fail("L0204", f"there is no package '{full}' to be imported", item.span, *self._hints(full))
                    yield full, name

    def _imports(self, full: str) -> str | None:
        """The class that an import names in full, which may stand in what a package extends."""
        return full if self._reach(full) else self._resolved(full, ()) if "." in full else None

    def _hints(self, package: str) -> list[str]:
        if package.partition(".")[0] == "Modelica":
            return ["of the Modelica Standard Library these are here: Units.SI, Constants, functions of Math, "
                    "Mechanics.Rotational, Mechanics.Translational and Blocks, as far as lag help library has them",
                    "lag import FILE.mo makes a .lag file of a Modelica one, and says what has no counterpart"]
        inside = [name for name in self.classes if name.rpartition(".")[0] == package]
        if inside:
            return [f"{package} has {', '.join(name.rpartition('.')[2] for name in inside)}"[:300]]
        near = suggest(package, [c.name for c in self.classes.values() if c.kind == "package"])
        return [near or "packages are looked for beside the file, in the folders of --path and of LAGRANGIA_PATH, as Name.lag or "
                "Name/package.lag"]

    def _reach(self, full: str) -> bool:
        """Whether there is a class of this full name, in the files that were read or in the folders of packages."""
        if full in self.classes:
            return True
        owner = full.rpartition(".")[0]
        if full in self._missing or (owner and owner not in self.classes and not self._reach(owner)):
            return False
        syntax = self.find(full)
        if syntax is not None:
            self.take(syntax)
        if full not in self.classes:
            self._missing.add(full)
        return full in self.classes
