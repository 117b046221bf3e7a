"""How many elements arrays of components and of records have: size(p, 1) of `Bar p[3]`."""

from collections.abc import Mapping
from typing import Any, Protocol

from lagrangia.base.diagnostics import Span
from lagrangia.language.classes import ClassTable
from lagrangia.language.function_variables import Tree
from lagrangia.language.instances import Instance, Member, Scope
from lagrangia.language.tree import Array, Call, Declaration, Expression, Number, Reference

OF_SIZES = frozenset({"size", "ndims"})  # functions that ask for nothing else of their first argument


class Names(Protocol):
    """What names mean (names.py)."""

    def integer(self, expression: Expression, scope: Scope, what: str) -> int:
        """The integer that an expression must be. Raises LagError L0210."""


def with_sizes(call: Call[Expression], shape: tuple[int, ...]) -> Call[Expression]:
    """The same call, of an array of numbers of this shape."""
    return Call(call.function, (_zeros(shape, call.span), *call.arguments[1:]), call.named, call.span)


def _zeros(shape: tuple[int, ...], span: Span) -> Any:
    return Array((_zeros(shape[1:], span),) * shape[0], span) if shape else Number(0.0, None, span, True)


def shape_of_components(node: Expression, scope: Scope, names: Names) -> tuple[int, ...] | None:
    """Of what a name without ranges in it stands for, one size for each subscript that it leaves out; None for what is no array
    of components."""
    if not isinstance(node, Reference):
        return None
    members: Mapping[str, Member] = scope.instance.members
    found: Any = None
    shape: list[int] = []
    for part in node.parts:
        found = members.get(part.name)
        for subscript in part.subscripts:
            if not isinstance(found, list) or not found:
                return None
            pick = names.integer(subscript, scope, "a subscript")
            found = found[pick - 1] if 1 <= pick <= len(found) else None
        while isinstance(found, list):
            shape.append(len(found))
            found = found[0] if found else None
        members = found.members if isinstance(found, Instance) else {}
    return tuple(shape) if shape and (found is None or isinstance(found, Instance)) else None


def shape_of_records(tree: Tree, node: Reference, declared: Mapping[str, Declaration], table: ClassTable
                     ) -> tuple[int, ...] | None:
    """Of what a name stands for in a function, where it is an array of records; None for anything else. `tree`: what it names."""
    if not isinstance(tree, dict):
        return None
    rank = 0
    for part in node.parts:
        declaration = declared[part.name]
        rank += len(declaration.dimensions) - len(part.subscripts)
        declared = table.declared(table.lookup(declaration.type_name, declaration.type_span))
    shape: list[int] = []
    while len(shape) < rank:
        while isinstance(tree, dict):
            tree = next(iter(tree.values()))
        shape.append(len(tree))
        tree = tree[0] if tree else ()
    return tuple(shape) or None
