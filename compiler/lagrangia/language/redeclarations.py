"""replaceable and redeclare, inner and outer (Modelica 3.6, sections 5.4 and 7.3)."""

from collections.abc import Sequence
from dataclasses import replace

from lagrangia.base.diagnostics import Report, Span, fail
from lagrangia.language.classes import BUILTIN_TYPES, ClassTable
from lagrangia.language.instances import (
    NOTHING,
    FrameSlot,
    Instance,
    Member,
    Modification,
    Redeclared,
    ReplacedClass,
    Scope,
    Slot,
    StructuralValues,
    inner_key,
)
from lagrangia.language.modifications import merge, modification_of
from lagrangia.language.tree import Argument, Array, Call, CallEquation, ClassDefinition, Clause, Declaration, Extends
from lagrangia.language.variants import check_kind, limit_of_first

_KEPT = frozenset({"parameter", "constant", "input", "output", "coordinate", "final", "inner", "protected"})


def known_names(table: ClassTable, definition: ClassDefinition) -> set[str]:
    """What of a class can be modified: its elements, and the classes in it that can be redeclared."""
    bases = table.lineage(definition)
    return {name for base in bases for name in (*(e.name for e in base.elements if isinstance(e, Declaration)),
                                                *(c.name for c in base.classes))}


# ------------------------------------------------------------ replaceable and redeclare


def with_redeclared_elements(definition: ClassDefinition, modification: Modification, scope: Scope) -> Modification:
    """`redeclare` before an element of a class: as if it were written behind what it extends."""
    own = {e.name: e for e in definition.elements if isinstance(e, Declaration) and "redeclare" in e.prefixes}
    if not own:
        return modification
    children = dict(modification.children)
    for name, element in own.items():
        inner = modification_of(element.arguments, scope, element.binding, element.name_span)
        change = Modification(inner.value, inner.children, False, False, element.name_span, Redeclared(element, element.span))
        children[name] = merge(children.get(name, NOTHING), change)
    return replace(modification, children=children)


def redeclared(table: ClassTable, report: Report, element: Declaration, given: Modification, own: Modification, scope: Scope
               ) -> tuple[Declaration, Modification]:
    """What takes the place of a replaceable element, with what modifies it: what constrains the element applies to it, too."""
    assert given.redeclared is not None
    new, constraining = given.redeclared.declaration, element.constraining
    if "replaceable" not in element.prefixes:
        report.error("L0234", f"'{element.name}' cannot be redeclared: it is not replaceable", given.redeclared.span,
                     "a component of the library has the type that it has" if element.name_span.source in table.library_sources
                     else f"write `replaceable` before it, at {element.name_span}")
        return element, own
    wanted = (constraining.type_name, constraining.span) if constraining else (element.type_name, element.type_span)
    if not _fits(table, report, (new.type_name, new.type_span), wanted, f"'{element.name}'"):
        return element, own
    check_constraint(table, report, new)
    declaration = replace(
        new, name=element.name, prefixes=(element.prefixes & _KEPT) | (new.prefixes & (_KEPT | {"replaceable"})),
        dimensions=new.dimensions or element.dimensions, condition=element.condition, name_span=element.name_span,
        description=new.description or element.description, constraining=new.constraining or constraining)
    kept = modification_of(constraining.arguments, scope, None, element.name_span) if constraining else own
    return declaration, merge(replace(given, redeclared=None), kept)


def with_redeclared_classes(table: ClassTable, values: StructuralValues, definition: ClassDefinition, change: Modification
                            ) -> tuple[ClassDefinition, Modification]:
    """A class as it is where packages, functions or types in it are redeclared, and the rest of what modifies it. What such a
    class is given has to be known when the scene is compiled. Raises LagError."""
    arguments, left = [], dict(change.children)
    for name, given in change.children.items():
        if given.redeclared is None or "class" not in given.redeclared.declaration.prefixes:
            continue
        if not table.takes_class(definition, name):
            table.variants.check_record(definition.name, name, given.redeclared.declaration, given.redeclared.span)
        else:
            new = given.redeclared.declaration
            inner = tuple(_settled_argument(values, key, one) for key, one in given.children.items())
            arguments.append(Argument(frozenset(), name, (), None, given.redeclared.span, new.name_span,
                                      replace(new, arguments=inner)))
            del left[name]
    if not arguments:
        return definition, change
    return table.variants.variant(definition.name, tuple(arguments)), replace(change, children=left)


def _settled_argument(values: StructuralValues, name: str, given: Modification) -> Argument:
    value = None
    place = given.span or (given.value.expression.span if given.value is not None else None)
    assert place is not None
    if given.value is not None:
        value = values.known(given.value)
        if value is None:
            fail("L0210", f"'{name}' of a redeclared class must be known when the scene is compiled", given.value.expression.span,
                 "use numbers, constants and Integer or Boolean parameters")
    return Argument(frozenset(), name, tuple(_settled_argument(values, key, one) for key, one in given.children.items()), value,
                    place, place, given.redeclared.declaration if given.redeclared is not None else None)


def replace_local_classes(table: ClassTable, report: Report, definition: ClassDefinition, modification: Modification,
                          instance: Instance) -> None:
    """redeclare model M = Other(...): for a replaceable class that stands in the definition."""
    for local in definition.classes:
        given = modification.children.get(local.name)
        if given is None or local.name in instance.classes:
            _check_limit(table, report, local)
            continue
        if given.redeclared is None or "class" not in given.redeclared.declaration.prefixes:
            report.error("L0234", f"'{local.name}' is a class: it cannot be modified", given.span,
                         f"write: redeclare {local.kind} {local.name} = Other(...)")
            continue
        new = given.redeclared.declaration
        if "replaceable" not in local.prefixes:
            report.error("L0234", f"'{local.name}' cannot be redeclared: it is not replaceable", given.redeclared.span,
                         f"write `replaceable` before it, at {local.name_span}")
            continue
        check_kind(new, local)
        if not table.is_of_components(instance.definition, local):
            owner = instance.definition.name
            report.error("L0901", f"not supported yet: '{local.name}' is redeclared in what {owner} inherits, and another class "
                         f"in {owner} uses it", given.redeclared.span, f"say in {owner} itself what takes its place, with "
                         f"numbers alone: extends ...(redeclare {local.kind} {local.name} = ...)")
            continue
        target, limit = limit_of_first(local, [c for base in table.lineage(definition) for c in base.classes])
        wanted = (limit.type_name, limit.span) if limit is not None else (target.name, target.name_span)
        if not _fits(table, report, (new.type_name, new.type_span), wanted, f"'{local.name}'"):
            continue
        check_constraint(table, report, new)
        said = modification_of(limit.arguments, Scope(instance), None, limit.span) if limit is not None else NOTHING
        whole = merge(replace(given, redeclared=None), said)
        instance.classes[local.name] = ReplacedClass(new.type_name, new.type_span, Modification(None, {
            name: replace(change, is_each=True) for name, change in whole.children.items()}))


def _check_limit(table: ClassTable, report: Report, local: ClassDefinition) -> None:
    """Of a replaceable class in another one that is not replaced."""
    base = next((e for e in local.elements if isinstance(e, Extends)), None)
    if (wanted := local.constraining) is not None and base is not None:
        _fits(table, report, (base.type_name, base.span), (wanted.type_name, wanted.span), f"'{local.name}'")


def check_constraint(table: ClassTable, report: Report, element: Declaration) -> None:
    """Of a replaceable element that is not replaced."""
    if (wanted := element.constraining) is not None:
        _fits(table, report, (element.type_name, element.type_span), (wanted.type_name, wanted.span), f"'{element.name}'")


def _fits(table: ClassTable, report: Report, new: tuple[str, Span], wanted: tuple[str, Span], what: str) -> bool:
    """Whether one type has all that another one has, by their names. Raises LagError L0201."""
    a, b = (table.base_type(*one) for one in (new, wanted))
    if a is not None or b is not None:
        if a is None or b is None or a.builtin != b.builtin:
            report.error("L0235", f"{what} is of type {wanted[0]}: {new[0]} cannot take its place", new[1])
            return False
        return True
    first, second = table.lookup(*new), table.lookup(*wanted)
    if any(base is second for base in table.lineage(first)):
        return True
    have, need = table.declared(first), table.declared(second)
    missing = [name for name, e in need.items() if name not in have and "protected" not in e.prefixes]
    if missing:
        report.error("L0235", f"{first.name} cannot stand for {what}: it lacks {_listed(missing)} of {second.name}", new[1],
                     f"what takes its place has all that {second.name} has; extending it is the surest way")
    return not missing


def _listed(names: Sequence[str]) -> str:
    return ", ".join(f"'{name}'" for name in names[:6]) + (", ..." if len(names) > 6 else "")


def modifying(element: Extends) -> tuple[Argument, ...]:
    """The arguments of an extends clause but for connections that are left out."""
    return tuple(a for a in element.arguments if not (a.is_left_out and a.value is not None))


def leave_out_connections(report: Report, base: ClassDefinition, element: Extends, clauses: list[tuple[str, Clause]],
                          first: int) -> None:
    """extends A(break connect(a, b)): the connections of these texts are not taken over, of the clauses from `first` on."""
    for argument in element.arguments:
        if not (argument.is_left_out and isinstance(argument.value, Array)):
            continue
        wanted = tuple(map(str, argument.value.items))
        found = [k for k in range(first, len(clauses)) if _connected(clauses[k][1]) == wanted]
        if not found:
            report.error("L0203", f"{base.name} has no connect({', '.join(wanted)})", argument.span,
                         "what is left out is written as it is there")
        for k in reversed(found):
            del clauses[k]


def _connected(clause: Clause) -> tuple[str, ...]:
    call = clause.call if isinstance(clause, CallEquation) else None
    is_connect = isinstance(call, Call) and call.function == "connect"
    return tuple(map(str, call.arguments)) if is_connect and isinstance(call, Call) else ()


def refuse_redeclared_nothing(definition: ClassDefinition, members: Sequence[tuple[Declaration, Modification]], report: Report
                              ) -> None:
    """Reports L0234 for `redeclare` before an element of a class that inherits none of its name."""
    own = [e for e in definition.elements if isinstance(e, Declaration) and "redeclare" in e.prefixes]
    names = {declaration.name for declaration, _ in members} if own else set()
    for element in own:
        if element.name not in names:
            report.error("L0234", f"nothing is inherited that '{element.name}' could take the place of", element.name_span,
                         "leave `redeclare` out: this is a component of its own")


# ------------------------------------------------------------ inner and outer


def add_outer(table: ClassTable, report: Report, instance: Instance, declaration: Declaration, change: Modification) -> bool:
    """Whether it is an `outer` element alone, which is that of the same name that a component around declares `inner`."""
    if "outer" not in declaration.prefixes:
        return False
    name = declaration.name
    is_inner = "inner" in declaration.prefixes
    if not is_inner and (change.value is not None or change.children):
        report.error("L0236", f"'{name}' is outer: it cannot be modified here", declaration.name_span,
                     "modify the inner one that it stands for")
    around = instance.parent
    while around is not None and name not in around.inner:
        around = around.parent
    found = (around.members.get(inner_key(name)) or around.members.get(name)) if around is not None else None
    if around is not None and found is not None:
        instance.members[name] = found
        instance.outer.add(name)
        _check_outer(table, report, declaration, found, around)
    elif name != "world":  # which is there in any case
        report.error("L0236", f"no component around {instance.definition.name} has an inner '{name}'", declaration.name_span,
                     f"declare it where it belongs: inner {declaration.type_name} {name};")
    return not is_inner


def _check_outer(table: ClassTable, report: Report, declaration: Declaration, found: Member, around: Instance) -> None:
    one = found
    while isinstance(one, list) and one:
        one = one[0]
    if declaration.type_name in BUILTIN_TYPES or table.base_type(declaration.type_name, declaration.type_span) is not None:
        base = table.base_type(declaration.type_name, declaration.type_span)
        is_right = base is not None and (one.base == base.builtin if isinstance(one, Slot) else
                                         isinstance(one, FrameSlot) and base.builtin == "Frame")
    else:
        wanted = table.lookup(declaration.type_name, declaration.type_span)
        is_right = isinstance(one, Instance) and any(base is wanted for base in table.lineage(one.definition))
    if not is_right:
        report.error("L0236", f"the inner '{declaration.name}' of {around.definition.name} is no {declaration.type_name}",
                     declaration.type_span, "inner and outer are of one type")
