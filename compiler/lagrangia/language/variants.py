"""Classes as they are in what inherits or redeclares them (Modelica 3.6, sections 5.6.1 and 7.3).

A package that gives other constants or classes to what it extends (`package Water extends Medium(rho = 1000); redeclare
function density ... `), and a class of which a class is redeclared (`Tank t(redeclare package Medium = Water)`), have what they
inherit as it is in themselves: copies of its text, in which names mean what they mean in the heir.
"""

from collections.abc import Callable, Iterator, Sequence
from dataclasses import field, fields, is_dataclass, replace
from typing import Any, Protocol

from lagrangia.base.diagnostics import Source, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.language.scoping import Copy, Scopes
from lagrangia.language.tree import Argument, ClassDefinition, Constraining, Declaration, Extends, Number, Reference, String, over

COMPONENTS = ("model", "block")  # classes that are redeclared with what modifies them, where they are used (redeclarations.py)


class Table(Protocol):
    """What names mean (classes.py)."""

    @property
    def scopes(self) -> Scopes:
        """Looks names up by what encloses them."""
    def lookup(self, name: str, span: Span) -> ClassDefinition:
        """The class that `name` means where `span` is. Raises LagError L0201."""
    def lineage(self, definition: ClassDefinition) -> list[ClassDefinition]:
        """The class and all it extends."""


@dataclass
class Variants:
    """Makes them when they are first named. `share` is told of each copy, from which source its text is."""

    table: Table
    share: Callable[[Source, Source], None]
    builtin: frozenset[str]
    _settled: set[str] = field(default_factory=set)
    _variants: dict[tuple[Any, ...], str] = field(default_factory=dict)
    _of_components: dict[tuple[str, str], bool] = field(default_factory=dict)
    _kept: list[tuple[Argument, ...]] = field(default_factory=list)  # whose ids are in the keys of `_variants`

    def settled(self, name: str) -> ClassDefinition:
        """The class of a full name; what it inherits is its own where it changes that. Raises LagError L0234, L0235."""
        definition = self.scopes.classes[name]
        if name not in self._settled:
            self._settled.add(name)
            if self._changes(definition, name):
                definition = self.scopes.classes[name] = self._with_copies(definition, name)
        return definition

    def variant(self, name: str, arguments: tuple[Argument, ...]) -> ClassDefinition:
        """A class of which others are redeclared. Raises LagError L0201, L0234, L0235."""
        definition = self.scopes.classes[name]
        targets = [self._named(a.redeclared) for a in arguments if a.redeclared is not None]
        key = (name, *((a.name, target, _signature(a)) for a, target in zip(arguments, targets, strict=True)))
        if key not in self._variants:
            self._kept.append(arguments)
            said = (f"{a.name} = {target.removeprefix('.')}" for a, target in zip(arguments, targets, strict=True))
            stem = f"{name}{{{', '.join(said)}}}"
            full, count = stem, 1
            while full in self.scopes.classes:
                full, count = f"{stem} {count + 1}", count + 1
            base = Extends(f".{name}", arguments, definition.span)
            self.scopes.classes[full] = replace(definition, name=full, elements=(base,), sections=(), classes=(), imports=(),
                                                annotation=())
            self._variants[key] = full
        return self.settled(self._variants[key])

    def inner(self, name: str, wanted: str) -> tuple[str, ClassDefinition] | None:
        """A class in a class, or in what that extends: where it is, and what it is."""
        for owner in self.scopes.lineage(name):
            for definition in self.scopes.classes[owner].classes:
                if definition.name == wanted:
                    return owner, definition
        return None

    def is_of_components(self, name: str, inner: ClassDefinition) -> bool:
        """Whether a record, model or block in a class is the type of some of its components, and is named nowhere else in it:
        neither by a function or another class in it, nor in what modifies a component, nor as a constructor. It is redeclared
        where these components are made, then."""
        key = name, inner.name
        if key not in self._of_components:
            self._of_components[key] = self._is_of_components(name, inner)
        return self._of_components[key]

    def _is_of_components(self, name: str, inner: ClassDefinition) -> bool:
        lineage = [self.scopes.classes[owner] for owner in self.scopes.lineage(name)]
        if inner.kind not in COMPONENTS and (sum(c.name == inner.name for one in lineage for c in one.classes) != 1 or (
                inner.constraining is not None and inner.constraining.arguments)):
            return False
        for one in lineage:
            behind = max((k for k, e in enumerate(one.elements) if isinstance(e, Extends)), default=-1)
            elements = tuple(_but_for(e, inner.name, k > behind) for k, e in enumerate(one.elements))
            if _names((elements, one.sections, tuple(c for c in one.classes if c.name != inner.name)), inner.name):
                return False
        return True

    def check_record(self, owner: str, name: str, new: Declaration, span: Span) -> None:
        """Raises LagError L0234, L0235 where a record in a class cannot be redeclared so."""
        found = self.inner(owner, name) if owner in self.scopes.classes else None
        if found is not None and found[1].kind == "record":
            taken = self.table.lookup(new.type_name, new.type_span)
            check_kind(new, found[1])
            self._check_replaceable(found[1], span)
            self._check_place(found[1], f"{found[0]}.{name}", taken, new.type_span)

    @property
    def scopes(self) -> Scopes:
        """Where names are looked up."""
        return self.table.scopes

    # ------------------------------------------------------------ what changes, and the copies

    def _changes(self, definition: ClassDefinition, name: str) -> bool:
        if any("redeclare" in inner.prefixes for inner in definition.classes):
            return True
        is_package = definition.kind == "package"
        return any((is_package and bool(e.arguments)) or any(self._is_taken(a, name, is_package) for a in e.arguments)
                   if isinstance(e, Extends) else is_package and "redeclare" in e.prefixes for e in definition.elements)

    def _is_taken(self, argument: Argument, name: str, is_package: bool) -> bool:
        """Whether an argument of an extends clause redeclares a class that is looked up as one."""
        if argument.redeclared is None or "class" not in argument.redeclared.prefixes:
            return False
        found = self.inner(name, argument.name)
        return found is not None and (is_package or found[1].kind not in COMPONENTS or not self.is_of_components(name, found[1]))

    def _with_copies(self, definition: ClassDefinition, name: str) -> ClassDefinition:
        """With classes of its own in the place of arguments that redeclare some, and copies of what it extends."""
        self._refuse_circle(name, (), set())
        own = {inner.name: inner for inner in definition.classes}
        elements: list[Declaration | Extends] = []
        bases: list[str] = []
        for element in definition.elements:
            base = self._base(element, name)
            if base is None or not isinstance(element, Extends):
                elements.append(element)
                continue
            taken = [a for a in element.arguments if self._is_taken(a, name, definition.kind == "package")]
            for argument in taken:
                made = self._redeclared(argument, name)
                own[argument.name] = made
                self.scopes.classes[f"{name}.{argument.name}"] = replace(made, name=f"{name}.{argument.name}")
            left = tuple(a for a in element.arguments if a not in taken)
            elements.append(replace(element, arguments=left, type_name=f".{base}"))
            bases.append(base)
        for inner in definition.classes:
            if "redeclare" in inner.prefixes:
                self._check(inner, f"{name}.{inner.name}", bases, inner.name_span)
        copies = {f".{base}": f".{self._copied(base, name)}" for base in bases}
        for inner in definition.classes:
            if "extends" in inner.prefixes:
                self._extend_inherited(inner, (f"{name}.{inner.name}",), [copies[f".{base}"][1:] for base in bases])
        return replace(definition, classes=tuple(own.values()), elements=tuple(
            replace(e, type_name=copies.get(e.type_name, e.type_name)) if isinstance(e, Extends) else e for e in elements))

    def _refuse_circle(self, name: str, heirs: tuple[str, ...], clear: set[str]) -> None:
        """Of a class that is among what it extends no copy would be the last. Raises LagError L0206."""
        if name in heirs:
            definition = self.scopes.classes[name]
            fail("L0206", f"{definition.name} extends itself", definition.name_span, " > ".join((*heirs, name)))
        if name not in clear:
            for element in self.scopes.classes[name].elements if name in self.scopes.classes else ():
                if (base := self._base(element, name)) is not None:
                    self._refuse_circle(base, (*heirs, name), clear)
            clear.add(name)

    def _base(self, element: Declaration | Extends, name: str) -> str | None:
        if not isinstance(element, Extends) or element.type_name in self.builtin:
            return None
        return self.scopes.base(element, name)

    def _copied(self, base: str, heir: str) -> str:
        """The name of a copy of a class, and of all it extends, whose names are those of the heir."""
        key = f"{heir} < {base}"
        if key in self.scopes.classes:
            return key
        original = self.settled(base)
        old = original.span.source
        source = Source(old.name, old.text)
        self.share(old, source)
        copy: ClassDefinition = _moved(replace(original, classes=tuple(c for c in original.classes if not c.literals)), source)
        kept = tuple(c for c in original.classes if c.literals)  # a value of an enumeration is one wherever it is named
        self.scopes.copies[source] = Copy(copy, heir, base, tuple(self.scopes.around(original.name_span)[1:]))
        self.scopes.classes[key] = copy
        for full, inner in _named_classes(copy, heir):
            hidden = f"{key}{full[len(heir):]}"
            self.scopes.classes[hidden] = replace(inner, name=full)
            self.scopes.classes.setdefault(full, replace(inner, name=full))
        for inner in kept:
            self.scopes.classes.setdefault(f"{heir}.{inner.name}", self.scopes.classes[f"{base}.{inner.name}"])
        elements = tuple(replace(e, type_name=f".{self._copied(found, heir)}")
                         if isinstance(e, Extends) and (found := self._base(was, base)) is not None else e
                         for e, was in zip(copy.elements, original.elements, strict=True))
        self.scopes.classes[key] = replace(copy, elements=elements, classes=(*copy.classes, *kept))
        bases = [e.type_name[1:] for e in elements if isinstance(e, Extends) and e.type_name.startswith(".")]
        for inner in copy.classes:
            if "extends" in inner.prefixes:
                visible = self.scopes.classes[f"{heir}.{inner.name}"].span.source is source
                self._extend_inherited(inner, (f"{key}.{inner.name}", *((f"{heir}.{inner.name}",) if visible else ())), bases)
        return key

    def _extend_inherited(self, inner: ClassDefinition, names: Sequence[str], copies: Sequence[str]) -> None:
        """redeclare model extends M: what takes the place of an inherited class extends it."""
        hidden = next((full for copy in copies for owner in self.scopes.lineage(copy)
                       if (full := f"{owner}.{inner.name}") in self.scopes.classes), None)
        for name in names if hidden is not None else ():
            first, *others = inner.elements
            assert isinstance(first, Extends)
            self.scopes.classes[name] = replace(inner, name=self.scopes.classes[name].name,
                                                elements=(replace(first, type_name=f".{hidden}"), *others))

    # ------------------------------------------------------------ what may take the place

    def _redeclared(self, argument: Argument, heir: str) -> ClassDefinition:
        """A class that is what a redeclaration says."""
        new = argument.redeclared
        assert new is not None
        found = self.inner(heir, argument.name)
        assert found is not None
        _, target = found
        check_kind(new, target)
        limit = limit_of(target)
        arguments = over(new.arguments, limit.arguments) if limit is not None else new.arguments
        self._check_replaceable(target, argument.span)
        if new.type_name not in self.builtin or target.kind != "type":
            taking = self.table.lookup(new.type_name, new.type_span)
            self._check_place(target, f"{found[0]}.{target.name}", taking, new.type_span)
            if new.constraining is not None:
                wanted = self.table.lookup(new.constraining.type_name, new.constraining.span)
                self._check_has(target.name, wanted, taking, new.type_span)
        elif target.is_partial:
            fail("L0235", f"'{target.name}' is any enumeration: {new.type_name}, which is none, cannot take its place",
                 new.type_span)
        if new.constraining is not None:
            limit = replace(new.constraining, arguments=over(new.constraining.arguments, limit.arguments if limit else ()))
        elif limit is not None and limit.type_name in self.builtin:
            limit = None
        return ClassDefinition(target.kind, False, argument.name, target.description,
                               (Extends(self._named(new), arguments, new.type_span),), (), (), argument.span,
                               argument.name_span, prefixes=new.prefixes & {"replaceable"}, constraining=limit)

    def _named(self, new: Declaration) -> str:
        """The class that a redeclaration names: in full, where it is none of the library."""
        found = self.scopes.full_name(new.type_name, new.type_span)
        return f".{found}" if found is not None and found in self.scopes.classes else new.type_name

    def _check(self, inner: ClassDefinition, full: str, bases: Sequence[str], span: Span) -> None:
        """Of a class that is redeclared as an element."""
        found = next((found for base in bases if (found := self.inner(base, inner.name)) is not None), None)
        if found is None:
            fail("L0234", f"nothing is inherited that '{inner.name}' could take the place of", span,
                 "leave `redeclare` out: this is a class of its own")
        self._check_replaceable(found[1], span)
        self._check_place(found[1], f"{found[0]}.{inner.name}", self.scopes.classes[full], span)

    def _check_replaceable(self, target: ClassDefinition, span: Span) -> None:
        if "replaceable" not in target.prefixes:
            fail("L0234", f"'{target.name}' cannot be redeclared: it is not replaceable", span,
                 f"write `replaceable` before it, at {target.name_span}")

    def _check_place(self, target: ClassDefinition, old: str, new: ClassDefinition, new_span: Span) -> None:
        """Raises LagError where a class cannot take the place of another one, by what it has."""
        name = target.name
        if new.kind != target.kind and not {new.kind, target.kind} <= {"model", "block"}:
            fail("L0235", f"'{name}' is a {target.kind}: the {new.kind} {new.name} cannot take its place", new_span)
        if target.kind == "type" and target.is_partial and not any(base.literals for base in self.table.lineage(new)):
            fail("L0235", f"'{name}' is any enumeration: {new.name}, which is none, cannot take its place", new_span)
        owners = self.scopes.lineage(old.rpartition(".")[0])
        classes = {owner: self.scopes.classes[owner].classes for owner in owners}
        first, _ = limit_of_first(target, [c for inside in classes.values() for c in inside])
        of_first = next((f"{owner}.{name}" for owner, inside in classes.items() if any(c is first for c in inside)), old)
        limit = first.constraining
        wanted = self.scopes.classes[of_first] if limit is None else self.table.lookup(limit.type_name, limit.span)
        self._check_has(name, wanted, new, new_span)

    def _check_has(self, name: str, wanted: ClassDefinition, new: ClassDefinition, new_span: Span) -> None:
        """Raises LagError where a class lacks something that another one has."""
        lineage = self.table.lineage(new) if "extends" not in new.prefixes else []
        if not lineage or wanted.name in [base.name for base in lineage]:
            return
        missing = [item for item in self._offered(wanted) if item not in self._offered(new)]
        if missing:
            listed = ", ".join(f"'{item}'" for item in missing[:6]) + (", ..." if len(missing) > 6 else "")
            fail("L0235", f"{new.name} cannot stand for '{name}': it lacks {listed} of {wanted.name}", new_span,
                 f"what takes its place has all that {wanted.name} has; extending it is the surest way")

    def _offered(self, definition: ClassDefinition) -> list[str]:
        """What others see of a class: declarations and classes."""
        return [item.name for one in self.table.lineage(definition) for item in (*one.elements, *one.classes)
                if not isinstance(item, Extends) and "protected" not in item.prefixes]


def check_kind(new: Declaration, target: ClassDefinition) -> None:
    """Raises LagError L0235 where a redeclaration says another kind than that of the class whose place it takes."""
    if new.kind != target.kind and not {new.kind, target.kind} <= {*COMPONENTS}:
        fail("L0235", f"'{target.name}' is a {target.kind}, no {new.kind}", new.span,
             f"write: redeclare {target.kind} {target.name} = ...")


def limit_of(target: ClassDefinition) -> Constraining | None:
    """What limits what may take the place of a class, and modifies it: the constraining clause, or what a short class is."""
    base = target.elements[0] if len(target.elements) == 1 else None
    if target.constraining is None and isinstance(base, Extends) and base.span == target.span:
        return Constraining(base.type_name, base.arguments, base.span)
    return target.constraining


def limit_of_first(target: ClassDefinition, inherited: Sequence[ClassDefinition]) -> tuple[ClassDefinition, Constraining | None]:
    """The class whose limit holds for what may take the place of a class, and that limit: of the one that a redeclaration without
    a constraining clause has taken the place of (Modelica 3.6, section 7.3.2). `inherited`: classes in a class and in what it
    extends."""
    limit = limit_of(target)
    for other in (c for c in inherited if c.name == target.name and c is not target):
        if limit is not None or "redeclare" not in target.prefixes:
            break
        target, limit = other, limit_of(other)
    return target, limit


def _signature(argument: Argument) -> tuple[Any, ...]:
    """What tells one redeclaration from another to the same class."""
    assert argument.redeclared is not None
    return tuple((a.name, a.value.value if isinstance(a.value, Number) and not a.arguments else id(a))
                 for a in argument.redeclared.arguments)


def _named_classes(definition: ClassDefinition, prefix: str) -> Iterator[tuple[str, ClassDefinition]]:
    for inner in definition.classes:
        yield f"{prefix}.{inner.name}", inner
        yield from _named_classes(inner, f"{prefix}.{inner.name}")


def _but_for(element: Declaration | Extends, name: str, is_behind: bool) -> Declaration | Extends:
    """An element without what makes a class the type of a component, or redeclares it in what is inherited."""
    if isinstance(element, Extends):
        return replace(element, arguments=tuple(a for a in element.arguments if a.name != name or a.redeclared is None))
    return replace(element, type_name="") if is_behind and element.type_name == name else element


_NO_CLASSES = frozenset({"description", "annotation", "annotations"})  # fields of syntax that name none


def _names(node: Any, name: str) -> bool:
    """Whether a class is named in a piece of syntax, or is a part of what is: not by texts, nor by a variable called so and what
    gives that its value."""
    if isinstance(node, str):
        return name in node.split(".")
    if isinstance(node, tuple):
        return any(_names(item, name) for item in node)
    if not is_dataclass(node) or isinstance(node, Span | String):
        return False
    if isinstance(node, Reference) and len(node.parts) == 1:
        return _names(node.parts[0].subscripts, name)
    is_variable = (isinstance(node, Declaration) and not node.kind) or (isinstance(node, Argument) and node.redeclared is None)
    own = {"name"} if is_variable else frozenset[str]()
    return any(_names(getattr(node, f.name), name) for f in fields(node) if f.name not in _NO_CLASSES | own)


def _moved(node: Any, source: Source) -> Any:
    """A piece of syntax as if it stood at the same place of another source."""
    if isinstance(node, Span):
        return Span(source, node.start, node.end)
    if isinstance(node, tuple):
        return tuple(_moved(item, source) for item in node)
    if is_dataclass(node) and not isinstance(node, type):
        return type(node)(*(_moved(getattr(node, f.name), source) for f in fields(node)))
    return node
