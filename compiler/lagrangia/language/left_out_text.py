"""Names in what is written for other values of structural parameters: in components whose condition is false, and in branches.

Nothing of such text is in the flat model, but what names nothing is as wrong there as anywhere.
"""

import re
from collections.abc import Iterator
from typing import Any

from lagrangia.base.diagnostics import Diagnostic, LagError, Report, Span
from lagrangia.language.assertions import LEVELS
from lagrangia.language.attributes import NEVER_READ
from lagrangia.language.classes import ClassTable
from lagrangia.language.functions import CALLED
from lagrangia.language.instances import Instance, Scope, is_absent
from lagrangia.language.names import Names
from lagrangia.language.spaces import FoundSpaceError
from lagrangia.language.syntax_parts import parts_of
from lagrangia.language.tree import (
    Argument,
    Call,
    CallEquation,
    ClassDefinition,
    Comprehension,
    Declaration,
    ForBlock,
    IfBlock,
    IfExpression,
    Reference,
)
from lagrangia.language.tree import Iterator as SyntaxIterator
from lagrangia.language.unread import inside

_MAY_BE_LEFT_OUT = re.compile(r"\bif\b")


def find_unknown_names(root: Instance, table: ClassTable, names: Names) -> Report:
    """L0204, L0216 for names that mean nothing, in each class of people's own."""
    report, seen = Report(), set[int]()
    for instance in (root, *inside(root)):
        for definition in table.lineage(instance.definition):
            if id(definition) in seen or definition.span.source in table.library_sources:
                continue
            seen.add(id(definition))
            if _MAY_BE_LEFT_OUT.search(definition.span.text):
                told = dict[Span | None, Diagnostic]()
                for node, scope in _left_out(definition, Scope(instance), names):
                    told |= {found.span: found for found in _unknown(node, scope, table, names)}
                report.add(sorted(told.values(), key=lambda d: d.span.start if d.span is not None else 0))
    return report


def _left_out(definition: ClassDefinition, scope: Scope, names: Names) -> Iterator[tuple[Reference | Call[Any], Scope]]:
    """The names, and the functions that are called, in branches and components with a condition; of loops the first pass."""
    pending: list[tuple[Any, Scope, bool]] = [(definition.elements, scope, False), (definition.sections, scope, False)]
    while pending:
        node, around, may_be_left_out = pending.pop()
        if isinstance(node, IfBlock | IfExpression):
            pending += [(node.condition, around, may_be_left_out), (node.then, around, True), (node.otherwise, around, True)]
            continue
        if isinstance(node, Argument) and node.redeclared is not None:
            continue
        if isinstance(node, Declaration):
            may_be_left_out = node.condition is not None
        elif isinstance(node, ForBlock | Comprehension):
            for iterator in node.iterators:
                around = around.bind(iterator.name, 1)
        if may_be_left_out and isinstance(node, Reference | Call):
            yield node, around
        pending += [(part, around, may_be_left_out) for part in _values_in(node, names)]


def _values_in(node: Any, names: Names) -> Iterator[Any]:
    """The parts of a piece of syntax that stand for values: no annotations, levels of assertions, attributes that nothing reads,
    or types that count elements and passes."""
    match node:
        case Declaration():
            yield from (_unless_counted(size, names) for size in node.dimensions)
            yield from (node.arguments, node.binding, node.condition, node.constraining)
        case Argument():
            yield from (node.arguments, None if node.name in NEVER_READ else node.value)
        case SyntaxIterator():
            yield _unless_counted(node.range, names)
        case CallEquation(Call() as call, _):
            given = (*call.arguments, *(value for _, value in call.named))
            yield from (value for value in given if not (isinstance(value, Reference) and str(value) in LEVELS))
        case _:
            yield from parts_of(node)


def _unless_counted(node: Any, names: Names) -> Any:
    """The size of a dimension or the range of a loop; None for an enumeration and for Boolean."""
    return None if isinstance(node, Reference) and names.literals(node) else node


def _unknown(node: Reference | Call[Any], scope: Scope, table: ClassTable, names: Names) -> list[Diagnostic]:
    """What is wrong with a name; nothing where it is that of something which is not there."""
    try:
        if isinstance(node, Reference):
            if node.parts[0].name not in scope.iterators and not is_absent(node, scope):
                names.resolve(node, scope)
        elif node.function not in CALLED and table.found(node.function, node.span) is None:
            names.call(Call(node.function, (), (), node.span), scope)
    except LagError as error:
        return [found for found in error.diagnostics if found.code == "L0204" or (
            found.code == "L0216" and _has_no_member(node, scope))]
    except FoundSpaceError:  # it would say so where it is there
        pass
    return []


def _has_no_member(node: Reference | Call[Any], scope: Scope) -> bool:
    """Whether a name leads through components to one that does not have what is named: a component itself is no value either."""
    member: Any = scope.instance
    for part in node.parts if isinstance(node, Reference) else ():
        while isinstance(member, list) and member:
            member = member[0]
        if not isinstance(member, Instance) or member.frame is not None:
            return False
        if part.name not in member.members:
            return True
        member = member.members[part.name]
    return False
