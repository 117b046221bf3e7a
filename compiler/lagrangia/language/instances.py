"""ClassTable -> tree of Instances: inheritance, modifications, arrays of components, conditional components.

A modification is kept with the scope it was written in (`Bound`), so that names in it mean what they mean there.
"""

from collections.abc import Collection, Iterator, Mapping, Sequence
from dataclasses import field
from math import prod
from typing import Any, Protocol, TypeAlias

from lagrangia.base.diagnostics import Report, Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.classes import ClassTable
from lagrangia.language.frame_attributes import OF_ANY_FRAME
from lagrangia.language.suggestions import explain
from lagrangia.language.tree import Argument, Boolean, ClassDefinition, Clause, Declaration, Expression, Extends, Number, String

ATTRIBUTES = frozenset({"unit", "displayUnit", "min", "max", "start", "fixed", "nominal", "quantity", "stateSelect"})
_ROLES = frozenset({"parameter", "constant", "input", "output", "coordinate"})
_MOST_ELEMENTS = 1_000_000
_MOST_COMPONENTS = 100_000


def held_port(frames: Sequence[str]) -> str | None:
    """The frame of a component that its reaction acts on: b of a and b, the center that a base carries, else the last one; None
    with fewer than two."""
    if {"base", "center"} <= set(frames):
        return "center"
    return "b" if {"a", "b"} <= set(frames) else frames[-1] if len(frames) > 1 else None


@dataclass(frozen=True)
class Scope:
    """Where names are looked up: an instance, and the loop variables in force."""

    instance: "Instance"
    iterators: Mapping[str, int] = field(default_factory=dict)

    def bind(self, name: str, value: int) -> "Scope":
        """The same scope with a value for one more iterator."""
        return Scope(self.instance, {**self.iterators, name: value})


@dataclass(frozen=True)
class Bound:
    """An expression with its scope. `selection` holds (index, size) for each array of components it is dealt out over."""

    expression: Expression
    scope: Scope
    selection: tuple[tuple[int, int], ...] = ()


@dataclass(frozen=True)
class Modification:
    """A tree of modifications as it applies to one member."""

    value: Bound | None = None
    children: Mapping[str, "Modification"] = field(default_factory=dict)
    is_each: bool = False
    is_final: bool = False
    span: Span | None = None


NOTHING = Modification()


@dataclass(eq=False)
class Slot:
    """A variable of a builtin type."""

    path: str
    declaration: Declaration
    base: str
    attributes: Mapping[str, Bound]
    binding: Bound | None
    scope: Scope
    dimensions: tuple[int, ...] = ()
    is_final: bool = False

    @property
    def is_structural(self) -> bool:
        """Integer, Boolean and String parameters and all constants are known when the scene is compiled."""
        prefixes = self.declaration.prefixes
        return "constant" in prefixes or ("parameter" in prefixes and self.base in ("Integer", "Boolean", "String"))


@dataclass(eq=False)
class FrameSlot:
    """A frame: a declared port, or an instance of a class that extends Frame."""

    path: str
    span: Span
    starts: Mapping[str, Bound]
    fixed: frozenset[str]
    binding: Bound | None
    owner: "Instance"


@dataclass(eq=False)
class Instance:
    """A class at its place in a model, with its members."""

    path: str
    definition: ClassDefinition
    span: Span
    members: dict[str, "Member"] = field(default_factory=dict)
    clauses: list[tuple[str, Clause]] = field(default_factory=list)
    frame: FrameSlot | None = None
    parent: "Instance | None" = None
    absent: set[str] = field(default_factory=set)  # conditional components that are not there
    protected: set[str] = field(default_factory=set)  # members that only the class itself, and what extends it, may name
    description: str = ""  # of its declaration
    joined_to: Bound | None = None  # of a connector: another one

    def child_path(self, name: str) -> str:
        """The full name of a member."""
        return f"{self.path}.{name}" if self.path else name


Member: TypeAlias = Slot | FrameSlot | Instance | list[Any]


def outside(table: ClassTable, span: Span, owner: Instance | None) -> Span:
    """Where people look for what stands at `span`: for the inside of a library component, its declaration."""
    while owner is not None and span.source in table.library_sources:
        span, owner = owner.span, owner.parent
    return span


class StructuralValues(Protocol):
    """Evaluates what must be known at compile time (names.py)."""

    def integer(self, expression: Expression, scope: Scope, what: str) -> int:
        """The integer that an expression must be. Raises LagError L0210."""
    def boolean(self, expression: Expression, scope: Scope, what: str) -> bool:
        """The truth value that an expression must be. Raises LagError L0210."""


@dataclass
class Instantiation:
    """Builds the instance tree of one model; errors are collected in `report`."""

    table: ClassTable
    values: StructuralValues
    report: Report
    stack: list[ClassDefinition] = field(default_factory=list)
    count: int = 0
    of_types: dict[int, Modification] = field(default_factory=dict)  # by the ids of declarations, which the table keeps

    def instantiate(
        self, definition: ClassDefinition, path: str, modification: Modification, span: Span, parent: Instance | None
    ) -> Instance:
        """The instance of a class at a path, with all that is in it. Raises LagError."""
        instance = Instance(path, definition, span, parent=parent)
        if any(definition is outer for outer in self.stack):
            self.report.error("L0207", f"{definition.name} contains itself", span,
                              " > ".join(outer.name for outer in (*self.stack, definition)))
            return instance
        self.stack.append(definition)
        members = list(self._members(definition, modification, Scope(instance)))
        self._check_names(instance, members, modification)
        self._add_variables(instance, [m for m in members if self._is_scalar(m[0])])
        for declaration, change in members:
            if not self._is_scalar(declaration):
                self._add_component(instance, declaration, change)
        self.stack.pop()
        return instance

    # ------------------------------------------------------------ the members of a class

    def _members(
        self, definition: ClassDefinition, modification: Modification, scope: Scope, bases: tuple[ClassDefinition, ...] = ()
    ) -> Iterator[tuple[Declaration, Modification]]:
        """Declarations of the class and of all it extends, each with what modifies it, bases first."""
        if any(definition is base for base in bases):
            self.report.error("L0206", f"{definition.name} extends itself", definition.name_span,
                              " > ".join(base.name for base in (*bases, definition)))
            return
        inherited = len(scope.instance.clauses)
        for element in definition.elements:
            if isinstance(element, Declaration):
                own = modification_of(element.arguments, scope, element.binding, element.name_span, "final" in element.prefixes)
                given = modification.children.get(element.name, NOTHING)
                self._refuse_final(element.name, given, own)
                yield element, merge(given, own)
            elif element.type_name == "Frame":
                starts, fixed = self._frame_starts(modification)
                scope.instance.frame = FrameSlot(scope.instance.path, scope.instance.span, starts, fixed, None, scope.instance)
            else:
                base = self.table.lookup(element.type_name, element.span)
                if base.kind not in ("model", "record", "connector"):
                    self.report.error("L0205", f"a model cannot extend the {base.kind} '{base.name}'", element.span)
                    continue
                inner = modification_of(element.arguments, scope, None, element.span)
                self._check_extends(base, inner)
                for name in modification.children.keys() & inner.children.keys():
                    self._refuse_final(name, modification.children[name], inner.children[name])
                yield from self._members(base, merge(modification, inner), scope, (*bases, definition))
        if any(section.kind == "drawing" for section in definition.sections):  # in place of what is inherited
            kept = [(kind, clause) for kind, clause in scope.instance.clauses[inherited:] if kind != "drawing"]
            scope.instance.clauses[inherited:] = kept
        scope.instance.clauses += [(s.kind, clause) for s in definition.sections for clause in s.clauses]

    def _refuse_final(self, name: str, given: Modification, own: Modification) -> None:
        """Nothing may be given for what is final, nor for a part of it that is."""
        if own.is_final and (given.value is not None or given.children):
            place = given.span or next(iter(given.children.values())).span
            if place != own.span:
                self.report.error("L0227", f"'{name}' is final: it keeps the value that it was declared with", place,
                                  f"it was made final at {own.span}; leave this out, or take `final` away there")
            return
        for inner in given.children.keys() & own.children.keys():
            self._refuse_final(inner, given.children[inner], own.children[inner])

    def _check_extends(self, base: ClassDefinition, inner: Modification) -> None:
        if inner.children:
            self._refuse_unknown(base, inner, self.table.declared(base).keys())

    def _refuse_unknown(self, definition: ClassDefinition, change: Modification, known: Collection[str]) -> None:
        for name, inner in change.children.items():
            if name not in known:
                self.report.error("L0203", f"{definition.name} has no parameter or port '{name}'", inner.span,
                                  *explain(self.table, definition, name, change.children.keys()))

    def _check_names(self, instance: Instance, members: list[tuple[Declaration, Modification]], change: Modification) -> None:
        known = {declaration.name for declaration, _ in members} | (OF_ANY_FRAME if instance.frame else frozenset())
        self._refuse_unknown(instance.definition, change, known)
        instance.protected |= {declaration.name for declaration, _ in members if "protected" in declaration.prefixes}
        for name in instance.protected & change.children.keys():
            self.report.error("L0228", f"'{name}' of {instance.definition.name} is protected: it cannot be given from outside",
                              change.children[name].span, "declare it before `protected`, or after `public`, if it is for others")
        seen: set[str] = set()
        for declaration, _ in members:
            if declaration.name in seen:
                self.report.error("L0202", f"{instance.definition.name} inherits '{declaration.name}' already",
                                  declaration.name_span, f"to give it another value: extends ...({declaration.name} = ...)")
            seen.add(declaration.name)

    # ------------------------------------------------------------ variables and frames

    def _is_scalar(self, declaration: Declaration) -> bool:
        base = self.table.base_type(declaration.type_name, declaration.type_span)
        return base is not None and base[0] != "Frame"

    def _add_variables(self, instance: Instance, members: list[tuple[Declaration, Modification]]) -> None:
        """All variables first, then their sizes: a size may use a parameter declared further down."""
        scope = Scope(instance)
        slots: list[Slot] = []
        for declaration, written in members:
            base = self.table.base_type(declaration.type_name, declaration.type_span)
            assert base is not None
            change = merge(written, self._said_by_type(declaration, base[1], scope))
            for name, inner in change.children.items():
                if name not in ATTRIBUTES:
                    self.report.error("L0208", f"{declaration.type_name} has no attribute '{name}'", inner.span,
                                      *filter(None, [suggest(name, ATTRIBUTES)]))
            attributes = {name: inner.value for name, inner in change.children.items() if inner.value is not None}
            slot = Slot(instance.child_path(declaration.name), declaration, base[0], attributes, change.value, scope,
                        is_final=change.is_final)
            instance.members[declaration.name] = slot
            slots.append(slot)
        for slot in slots:
            slot.dimensions = self._dimensions(slot.declaration, scope)

    def _said_by_type(self, declaration: Declaration, arguments: tuple[Argument, ...], scope: Scope) -> Modification:
        """The attributes of a variable's type. Where they are literals, as they mostly are, they are the same in every scope."""
        found = self.of_types.get(id(declaration))
        if found is None:
            found = modification_of(arguments, scope, None, declaration.name_span)
            if all(isinstance(a.value, Number | String | Boolean) and not a.arguments for a in arguments):
                self.of_types[id(declaration)] = found
        return found

    def _dimensions(self, declaration: Declaration, scope: Scope) -> tuple[int, ...]:
        sizes = []
        for size in declaration.dimensions:
            value = self.values.integer(size, scope, f"the size of '{declaration.name}'")
            if value < 0:
                self.report.error("L0209", f"'{declaration.name}' has the negative size {value}",
                                  outside(self.table, size.span, scope.instance))
            sizes.append(max(0, value))
        if (total := prod(sizes)) > _MOST_ELEMENTS:
            self.report.error("L0209", f"'{declaration.name}' has {total} elements; at most {_MOST_ELEMENTS} are possible",
                              outside(self.table, declaration.name_span, scope.instance))
            return tuple(0 for _ in sizes)
        return tuple(sizes)

    def _frame_starts(self, change: Modification) -> tuple[dict[str, Bound], frozenset[str]]:
        starts, fixed = {}, set()
        for name, inner in change.children.items():
            if name not in OF_ANY_FRAME:
                continue
            for attribute, what in inner.children.items():
                if attribute == "start" and what.value is not None:
                    starts[name] = what.value
                elif attribute == "fixed" and what.value is not None:
                    if self.values.boolean(what.value.expression, what.value.scope, "fixed"):
                        fixed.add(name)
                else:
                    self.report.error("L0208", f"a frame's {name} has no attribute '{attribute}'", what.span,
                                      "it has start and fixed")
            if inner.value is not None:
                self.report.error("L0208", f"'{name}' of a frame cannot be set", inner.span, f"write {name}(start = ...)")
        return starts, frozenset(fixed)

    # ------------------------------------------------------------ components

    def _add_component(self, instance: Instance, declaration: Declaration, change: Modification) -> None:
        scope = Scope(instance)
        condition = declaration.condition
        if condition is not None and not self.values.boolean(condition, scope, f"the condition of '{declaration.name}'"):
            instance.absent.add(declaration.name)
            return
        if roles := declaration.prefixes & _ROLES:
            what = f"the component '{declaration.name}' cannot be {_with_article(min(roles))}"
            self.report.error("L0205", what, declaration.type_span, "numbers can, such as Real, or Length and other quantities")
        sizes = self._dimensions(declaration, scope)
        if self.count + prod(sizes) > _MOST_COMPONENTS:
            fail("L0209", f"more than {_MOST_COMPONENTS} components", outside(self.table, declaration.name_span, instance))
        instance.members[declaration.name] = self._elements(instance, declaration, change, sizes, ())

    def _elements(
        self, instance: Instance, declaration: Declaration, change: Modification, sizes: tuple[int, ...], at: tuple[int, ...]
    ) -> Member:
        if not sizes:
            suffix = f"[{','.join(map(str, at))}]" if at else ""
            return self._one(instance, declaration, change, instance.child_path(declaration.name) + suffix)
        return [
            self._elements(instance, declaration, deal_out(change, index, sizes[0], len(sizes)), sizes[1:], (*at, index))
            for index in range(1, sizes[0] + 1)
        ]

    def _one(self, instance: Instance, declaration: Declaration, change: Modification, path: str) -> Member:
        base = self.table.base_type(declaration.type_name, declaration.type_span)
        if base is not None:
            for name, inner in change.children.items():
                if name not in OF_ANY_FRAME:
                    self.report.error("L0208", f"Frame has no attribute '{name}'", inner.span,
                                      *filter(None, [suggest(name, OF_ANY_FRAME)]))
            starts, fixed = self._frame_starts(change)
            return FrameSlot(path, declaration.name_span, starts, fixed, change.value, instance)
        definition = self.table.lookup(declaration.type_name, declaration.type_span)
        if definition.kind == "function" or definition.is_partial:
            what = "a function" if definition.kind == "function" else "partial: extend it and complete its energy"
            self.report.error("L0205", f"'{definition.name}' cannot be a component, it is {what}", declaration.type_span)
        is_port = self._is_frame_class(definition) or definition.kind == "connector"
        if change.value is not None and not is_port:
            self.report.error("L0205", f"the component '{declaration.name}' cannot be given a value",
                              change.value.expression.span, "modify its parameters and ports: (name = value)")
        self.count += 1
        found = self.instantiate(definition, path, change, declaration.name_span, instance)
        found.description, found.joined_to = declaration.description, change.value
        return found

    def _is_frame_class(self, definition: ClassDefinition) -> bool:
        return any(isinstance(e, Extends) and e.type_name == "Frame" for e in definition.elements)


def _with_article(word: str) -> str:
    return f"an {word}" if word[0] in "aeiou" else f"a {word}"


# -------------------------------------------------------------------- modifications


def modification_of(arguments: tuple[Argument, ...], scope: Scope, value: Expression | None, span: Span,
                    is_final: bool = False) -> Modification:
    """The tree of modifications written in one place; a later one of the same name is merged into the first."""
    children: dict[str, Modification] = {}
    for argument in arguments:
        inner = modification_of(argument.arguments, scope, argument.value, argument.name_span)
        child = Modification(inner.value, inner.children, "each" in argument.prefixes, "final" in argument.prefixes,
                             argument.name_span)
        children[argument.name] = merge(children[argument.name], child) if argument.name in children else child
    return Modification(Bound(value, scope) if value is not None else None, children, False, is_final, span)


def merge(outer: Modification, inner: Modification) -> Modification:
    """What the outer scope says wins over what the inner one says."""
    if outer is NOTHING:
        return inner
    children = dict(inner.children)
    for name, change in outer.children.items():
        children[name] = merge(change, children[name]) if name in children else change
    return Modification(outer.value or inner.value, children, outer.is_each if outer.value else inner.is_each,
                        outer.is_final or inner.is_final, outer.span or inner.span)


def deal_out(change: Modification, index: int, size: int, dimensions: int, is_each: bool = False) -> Modification:
    """The part of a modification of an array of components that goes to element `index`; `each` goes to all unchanged,
    in every one of the array's dimensions."""
    is_each = is_each or change.is_each
    value = change.value
    if value is not None and not is_each:
        value = Bound(value.expression, value.scope, (*value.selection, (index, size)))
    children = {name: deal_out(inner, index, size, dimensions, is_each) for name, inner in change.children.items()}
    return Modification(value, children, change.is_each and dimensions > 1, change.is_final, change.span)
