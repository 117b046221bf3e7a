"""ClassTable -> tree of Instances: inheritance, modifications, arrays of components, conditional components."""

from collections.abc import Collection, Iterator
from dataclasses import field, replace
from math import prod

from lagrangia.base.diagnostics import LagError, Report, Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.alike_elements import FEWEST, Alike, First, can_be_copied, copies_of
from lagrangia.language.attributes import unknown_attributes
from lagrangia.language.classes import ClassTable
from lagrangia.language.foreseen import Foreseen
from lagrangia.language.frame_attributes import OF_ANY_FRAME, SPATIAL_ONLY
from lagrangia.language.instances import (
    NOTHING,
    Bound,
    FrameSlot,
    Instance,
    Member,
    Modification,
    Scope,
    Slot,
    StructuralValues,
    key_of,
    outside,
)
from lagrangia.language.kept_components import Asked, KeptComponents
from lagrangia.language.modifications import deal_out, dealt_to_fields, merge, modification_of, redeclares
from lagrangia.language.redeclarations import (
    add_outer,
    check_constraint,
    known_names,
    leave_out_connections,
    modifying,
    redeclared,
    refuse_redeclared_nothing,
    replace_local_classes,
    with_redeclared_classes,
    with_redeclared_elements,
)
from lagrangia.language.space_values import dimensions_of, form_of, prefixes_of
from lagrangia.language.spaces import name_of_space
from lagrangia.language.suggestions import explain
from lagrangia.language.tree import (
    Argument,
    Boolean,
    ClassDefinition,
    Declaration,
    Expression,
    Extends,
    Number,
    Reference,
    String,
    Whole,
)

_ROLES = frozenset({"parameter", "constant", "input", "output", "coordinate"})
_MOST_ELEMENTS = 100_000  # some 50 us each
_MOST_COMPONENTS = 100_000
_MOST_CLASSES = 10_000  # that one inherits


@dataclass
class Instantiation:
    """Builds the instance tree of one model; errors are collected in `report`."""

    table: ClassTable
    values: StructuralValues
    report: Report
    stack: list[ClassDefinition] = field(default_factory=list)
    count: int = 0
    of_types: dict[int, Modification] = field(default_factory=dict)  # by the ids of declarations, which are kept
    kept: list[Declaration] = field(default_factory=list)
    is_package: bool = False  # of which constants alone are made
    before: KeptComponents | None = None  # what was made of the scene as it was

    def __post_init__(self) -> None:
        self.foreseen = Foreseen(self.table)

    def instantiate(
        self, definition: ClassDefinition, path: str, modification: Modification, span: Span, parent: Instance | None,
        roles: frozenset[str] = frozenset()
    ) -> Instance:
        """The instance of a class at a path, with all that is in it; `roles` are prefixes that a record gives to all that it has.
        Raises LagError."""
        definition = definition if path else self.table.settled(definition)
        instance = Instance(path, definition, span, parent=parent)
        if not path:
            instance = self.before.begin(self.table, instance, self.values.space) if self.before is not None else instance
            self.values.begin(instance)
        if any(definition is outer for outer in self.stack):
            self.report.error("L0207", f"{definition.name} contains itself", span,
                              " > ".join(outer.name for outer in (*self.stack, definition)))
            return instance
        if self.foreseen.classes_of(definition) > _MOST_CLASSES:
            fail("L0209", f"{definition.name} inherits more than {_MOST_CLASSES} classes, each counted as often as it does", span,
                 "extend each class once")
        self.stack.append(definition)
        members = list(self._members(definition, modification, Scope(instance)))
        self._check_names(instance, members, modification)
        refuse_redeclared_nothing(definition, members, self.report)
        own = [m for m in members if not add_outer(self.table, self.report, instance, *m)]
        scalar, others = list[tuple[Declaration, Modification]](), list[tuple[Declaration, Modification]]()
        for m in own:
            (scalar if self._is_scalar(m[0]) else others).append(m)
        instance.inner |= {declaration.name for declaration, _ in own if "inner" in declaration.prefixes}
        self._add_variables(instance, scalar, roles)
        components = [(replace(d, prefixes=d.prefixes | roles) if roles else d, change) for d, change in others]
        for declaration, change in sorted(components, key=lambda m: "inner" not in m[0].prefixes):  # what is inside may name them
            self._add_component(instance, declaration, change)
        self.stack.pop()
        return instance

    def constants_of(self, definition: ClassDefinition) -> Instance:
        """The constants alone of a class, of a package mostly."""
        inside = Instantiation(self.table, self.values, self.report, is_package=True)
        return inside.instantiate(definition, definition.name, NOTHING, definition.name_span, None)

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
        modification = with_redeclared_elements(definition, modification, scope)
        replace_local_classes(self.table, self.report, definition, modification, scope.instance)
        for element in definition.elements:
            if isinstance(element, Declaration):
                given = modification.children.get(element.name, NOTHING)
                if given.is_left_out:
                    scope.instance.absent.add(element.name)
                elif self.is_package and scope.instance.parent is None and "constant" not in element.prefixes:
                    continue
                elif "redeclare" not in element.prefixes:
                    yield self._modified(element, given, scope)
            elif element.type_name == "Frame":
                starts, fixed = self._frame_starts(modification)
                scope.instance.frame = FrameSlot(scope.instance.path, scope.instance.span, starts, fixed, None, scope.instance)
            else:
                base = self.table.lookup(element.type_name, element.span)
                if base.kind not in ("model", "record", "block", "connector", "package"):
                    self.report.error("L0205", f"a model cannot extend the {base.kind} '{base.name}'", element.span)
                    continue
                inner = modification_of(modifying(element), scope, None, element.span)
                first = len(scope.instance.clauses)
                if inner.children:
                    self._refuse_unknown(base, inner, known_names(self.table, base))
                for name in modification.children.keys() & inner.children.keys():
                    self._refuse_final(name, modification.children[name], inner.children[name])
                yield from self._members(base, merge(modification, inner), scope, (*bases, definition))
                leave_out_connections(self.report, base, element, scope.instance.clauses, first)
        if any(section.kind == "drawing" for section in definition.sections):  # in place of what is inherited
            kept = [(kind, clause) for kind, clause in scope.instance.clauses[inherited:] if kind != "drawing"]
            scope.instance.clauses[inherited:] = kept
        scope.instance.clauses += [(s.kind, clause) for s in definition.sections for clause in s.clauses]

    def _modified(self, element: Declaration, given: Modification, scope: Scope) -> tuple[Declaration, Modification]:
        """A declaration with what modifies it, or what takes its place."""
        own = modification_of(element.arguments, scope, element.binding, element.name_span, "final" in element.prefixes)
        self._refuse_final(element.name, given, own)
        if given.redeclared is not None:
            return redeclared(self.table, self.report, element, given, own, scope)
        check_constraint(self.table, self.report, element)
        local = scope.instance.classes.get(element.type_name)
        if local is not None:
            element = replace(element, type_name=local.type_name, type_span=local.type_span)
            own = merge(own, local.modification)
        return element, merge(given, own)

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

    def _refuse_unknown(self, definition: ClassDefinition, change: Modification, known: Collection[str]) -> None:
        for name, inner in change.children.items():
            if name not in known:
                self.report.error("L0203", f"{definition.name} has no parameter or port '{name}'", inner.span,
                                  *explain(self.table, definition, name, change.children.keys()))

    def _refuse_unknown_within(self, declaration: Declaration, change: Modification) -> None:
        """What is said of a component that is not there has to be of what it would have."""
        base = self.table.base_type(declaration.type_name, declaration.type_span)
        if base is not None:
            if base.builtin == "Frame":
                self._refuse_unknown_of_frame(change)
            else:
                self.report.add(unknown_attributes(self.table, declaration, base.builtin, change))
            return
        definition = self.table.lookup(declaration.type_name, declaration.type_span)
        if "replaceable" in definition.prefixes or any(inner.redeclared is not None for inner in change.children.values()):
            return
        of_frame = OF_ANY_FRAME | SPATIAL_ONLY if self._is_frame_class(definition) else frozenset()
        self._refuse_unknown(definition, change, known_names(self.table, definition) | of_frame)
        own = self.table.as_extended(definition)
        for name in own.keys() & {name for name, inner in change.children.items() if inner.children}:
            self._refuse_unknown_within(own[name], change.children[name])

    def _refuse_unknown_of_frame(self, change: Modification) -> None:
        space = self.values.space
        for name, inner in change.children.items():
            if name not in space.of_any_frame | SPATIAL_ONLY:
                self.report.error("L0208", f"Frame has no attribute '{name}'", inner.span,
                                  *filter(None, [space.missing.get(name) or suggest(name, space.of_any_frame)]))

    def _check_names(self, instance: Instance, members: list[tuple[Declaration, Modification]], change: Modification) -> None:
        of_frame = OF_ANY_FRAME | SPATIAL_ONLY if instance.frame else frozenset()
        known = {declaration.name for declaration, _ in members} | of_frame
        if change.children.keys() - known:
            known |= known_names(self.table, instance.definition)  # classes that can be redeclared, and what is not there
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
        return base is not None and base.builtin != "Frame"

    def _add_variables(self, instance: Instance, members: list[tuple[Declaration, Modification]], roles: frozenset[str]) -> None:
        """All variables first, then their sizes: a size may use a parameter declared further down."""
        scope = Scope(instance)
        slots: list[tuple[Slot, tuple[Expression, ...]]] = []
        for declaration, written in members:
            base = self.table.base_type(declaration.type_name, declaration.type_span)
            assert base is not None
            said = self._said_by_type(declaration, base.attributes, scope)
            for name in written.children.keys() & said.children.keys():
                self._refuse_final(name, written.children[name], said.children[name])
            change = merge(written, said)
            if change.children:
                self.report.add(unknown_attributes(self.table, declaration, base.builtin, change))
            attributes = {name: inner.value for name, inner in change.children.items() if inner.value is not None}
            form = form_of(declaration) if declaration.annotation else ""
            more = base.prefixes | roles | (prefixes_of(form, self.values.space) if form else frozenset())
            full = replace(declaration, prefixes=declaration.prefixes | more) if more else declaration
            slot = Slot(instance.child_path(declaration.name), full, base.builtin, attributes, change.value, scope,
                        is_final=change.is_final, enumeration=base.definition.name if base.definition is not None else "")
            instance.members[key_of(declaration)] = slot
            slots.append((slot, base.dimensions))
        for slot, _ in slots:
            if not self._is_there(slot.declaration, scope):
                del instance.members[key_of(slot.declaration)]
        for slot, more_sizes in slots:
            if key_of(slot.declaration) not in instance.members:
                continue
            if slot.declaration.dimensions or more_sizes:
                slot.dimensions = self._dimensions(slot.declaration, scope, slot.binding, more_sizes)
            elif slot.declaration.annotation and (form := form_of(slot.declaration)):
                slot.dimensions = dimensions_of(form, self.values, slot.binding)

    def _said_by_type(self, declaration: Declaration, arguments: tuple[Argument, ...], scope: Scope) -> Modification:
        """The attributes of a variable's type. Where they are literals, as they mostly are, they are the same in every scope."""
        found = self.of_types.get(id(declaration))
        if found is None:
            found = modification_of(arguments, scope, None, declaration.name_span)
            if all(isinstance(a.value, Number | String | Boolean) and not a.arguments for a in arguments):
                self.of_types[id(declaration)] = found
                self.kept.append(declaration)
        return found

    def _dimensions(self, declaration: Declaration, scope: Scope, binding: Bound | None = None,
                    more_sizes: tuple[Expression, ...] = ()) -> tuple[int, ...]:
        """`more_sizes` are those of its type; a size `:` is that of what it is bound to."""
        sizes = []
        for k, size in enumerate((*declaration.dimensions, *more_sizes)):
            value = self._dimension(declaration, k, size, scope, binding)
            if value < 0:
                self.report.error("L0209", f"'{declaration.name}' has the negative size {value}",
                                  outside(self.table, size.span, scope.instance))
            sizes.append(max(0, value))
        if (total := prod(sizes)) > _MOST_ELEMENTS:
            self.report.error("L0209", f"'{declaration.name}' has {total} elements; at most {_MOST_ELEMENTS} are possible",
                              outside(self.table, declaration.name_span, scope.instance))
            return tuple(0 for _ in sizes)
        return tuple(sizes)

    def _dimension(self, declaration: Declaration, k: int, size: Expression, scope: Scope, binding: Bound | None) -> int:
        if isinstance(size, Whole):
            found = self.values.shape(binding) if binding is not None else ()
            if k >= len(found):
                fail("L0211", f"'{declaration.name}' has no value that would say how many elements it has", declaration.name_span,
                     f"write: {declaration.name}[:] = {{1, 2, 3}}, or its size: {declaration.name}[3]")
            return found[k]
        if isinstance(size, Reference) and (count := self.values.count_of_literals(size)) is not None:
            return count
        return self.values.integer(size, scope, f"the size of '{declaration.name}'")

    def _frame_starts(self, change: Modification) -> tuple[dict[str, Bound], frozenset[str]]:
        starts, fixed = {}, set()
        for name, inner in change.children.items():
            name_of_space(self.values.space, name, inner.span)
            if name not in self.values.space.of_any_frame:
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
        if not self._is_there(declaration, scope):
            self._refuse_unknown_within(declaration, change)
            return
        self._refuse_roles(declaration)
        sizes = self._dimensions(declaration, scope)
        foreseen = 1 if redeclares(change) else max(1, self.foreseen.components_of(declaration))
        if self.count + prod(sizes) * foreseen > _MOST_COMPONENTS:
            fail("L0209", f"more than {_MOST_COMPONENTS} components", outside(self.table, declaration.name_span, instance))
        if self.before is not None and instance.parent is None:
            instance.members[key_of(declaration)] = self._kept(self.before, instance, declaration, change, sizes)
        else:
            instance.members[key_of(declaration)] = self._elements(instance, declaration, change, sizes, ())

    def _kept(self, kept: KeptComponents, instance: Instance, declaration: Declaration, change: Modification,
              sizes: tuple[int, ...]) -> Member:
        """A component of the scene as it was made before, or made now."""
        if (found := kept.found(declaration, sizes)) is not None:
            self.count += found.count
            return found.member
        told, count, values = len(self.report.diagnostics), self.count, self.values
        self.values = asked = Asked(values)
        try:
            member = self._elements(instance, declaration, change, sizes, ())
        finally:
            self.values = values
        if not asked.any and len(self.report.diagnostics) == told:
            kept.keep(declaration, sizes, member, self.count - count)
        return member

    def _is_there(self, declaration: Declaration, scope: Scope) -> bool:
        """Whether its condition is true, or it has none. What is not there is kept in mind."""
        condition = declaration.condition
        if condition is None or self.values.boolean(condition, scope, f"the condition of '{declaration.name}'"):
            return True
        scope.instance.absent.add(declaration.name)
        return False

    def _refuse_roles(self, declaration: Declaration) -> None:
        roles = declaration.prefixes & _ROLES
        if not roles:
            return
        definition = self.table.found(declaration.type_name, declaration.type_span)
        if definition is None or definition.kind != "record" or "coordinate" in roles:
            what = f"the component '{declaration.name}' cannot be {_with_article(min(roles))}"
            self.report.error("L0205", what, declaration.type_span, "numbers can, such as Real, or Length and other quantities")

    def _elements(
        self, instance: Instance, declaration: Declaration, change: Modification, sizes: tuple[int, ...], at: tuple[int, ...]
    ) -> Member:
        if not sizes:
            suffix = f"[{','.join(map(str, at))}]" if at else ""
            return self._one(instance, declaration, change, instance.child_path(declaration.name) + suffix)
        if sizes[0] > 1 and prod(sizes) >= FEWEST and (found := self._alike(instance, declaration, change, sizes, at)):
            return found
        return [
            self._elements(instance, declaration, deal_out(change, index, sizes[0], len(sizes)), sizes[1:], (*at, index))
            for index in range(1, sizes[0] + 1)
        ]

    def _alike(self, instance: Instance, declaration: Declaration, change: Modification, sizes: tuple[int, ...],
               at: tuple[int, ...]) -> Alike | None:
        """The elements of an array in its first dimension, where they are copies of the first; None where they may differ, or
        something is wrong with it."""
        told, count, mark, size = len(self.report.diagnostics), self.count, First(1), sizes[0]
        first = self._elements(instance, declaration, deal_out(change, mark, size, len(sizes)), sizes[1:], (*at, mark))
        whole = count + size * (self.count - count)
        if (isinstance(first, FrameSlot) or len(self.report.diagnostics) > told or whole > _MOST_COMPONENTS
                or not can_be_copied(first, mark)):
            self.count = count
            return None
        self.count = whole
        stem = f"{instance.child_path(declaration.name)}[{''.join(f'{k},' for k in at)}"
        return copies_of(first, instance, mark, size, stem)

    def _one(self, instance: Instance, declaration: Declaration, change: Modification, path: str) -> Member:
        base = self.table.base_type(declaration.type_name, declaration.type_span)
        if base is not None:
            self._refuse_unknown_of_frame(change)
            starts, fixed = self._frame_starts(change)
            return FrameSlot(path, declaration.name_span, starts, fixed, change.value, instance)
        definition = self.table.lookup(declaration.type_name, declaration.type_span)
        try:
            definition, change = with_redeclared_classes(self.table, self.values, definition, change)
        except LagError as error:  # what else is wrong is told, too
            self.report.add(error.diagnostics)
            return Instance(path, definition, declaration.name_span, parent=instance)
        if definition.kind in ("function", "package") or definition.is_partial:
            what = "partial: extend it and complete its energy" if definition.kind not in ("function", "package") else (
                f"a {definition.kind}")
            hints = [f"where this is used: (redeclare {definition.kind} {definition.name_span.text} = ...)"] if (
                "replaceable" in definition.prefixes) else []
            self.report.error("L0205", f"'{definition.name}' cannot be a component, it is {what}", declaration.type_span, *hints)
        roles = declaration.prefixes & _ROLES if definition.kind == "record" else frozenset()
        if definition.kind == "record" and change.value is not None:
            change = dealt_to_fields(change, self.table.declared(definition))
        elif change.value is not None and not (self._is_frame_class(definition) or definition.kind == "connector"):
            self.report.error("L0205", f"the component '{declaration.name}' cannot be given a value",
                              change.value.expression.span, "modify its parameters and ports: (name = value)")
        self.count += 1
        found = self.instantiate(definition, path, change, declaration.name_span, instance, roles)
        found.description, found.joined_to = declaration.description, change.value
        return found

    def _is_frame_class(self, definition: ClassDefinition) -> bool:
        return any(isinstance(e, Extends) and e.type_name == "Frame" for e in definition.elements)


def _with_article(word: str) -> str:
    return f"an {word}" if word[0] in "aeiou" else f"a {word}"
