"""Ranges that loops leave out: `for i loop` runs over the elements of the arrays that `i` alone picks from (Modelica 3.6, section
11.2.2.1)."""

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from lagrangia.base.diagnostics import Span
from lagrangia.language.tree import Call, Comprehension, Expression, ForBlock, Number, Part, Reference


def sizes_asked(name: str, body: Sequence[Any], span: Span) -> list[Expression]:
    """size(x, k) for each place in the clauses or expressions where the iterator stands as the k-th subscript of x."""
    found: dict[str, Expression] = {}
    for reference in references(tuple(body), name):
        for at, part in enumerate(reference.parts):
            for k, subscript in enumerate(part.subscripts, 1):
                if isinstance(subscript, Reference) and str(subscript) == name and not subscript.parts[0].subscripts:
                    array = Reference((*map(_first, reference.parts[:at]), replace(part, subscripts=())), reference.span)
                    found.setdefault(f"{reference} {at} {k}", Call("size", (array, Number(float(k), None, span, True)), (), span))
    return list(found.values())


def _first(part: Part) -> Part:
    """The same step through the first element: elements of arrays of components are of one class."""
    return replace(part, subscripts=tuple(Number(1.0, None, part.span, True) for _ in part.subscripts))


def references(node: Any, but_of: str = "") -> Iterator[Reference]:
    """Those in a piece of syntax, from its first to its last, without the bodies of loops whose own iterator has the name
    `but_of`, which mean that one."""
    if isinstance(node, Reference):
        yield node
    if isinstance(node, tuple):
        for item in node:
            yield from references(item, but_of)
    elif isinstance(node, ForBlock | Comprehension) and any(own.name == but_of for own in node.iterators):
        for own in node.iterators:
            yield from references(own, but_of)
            if own.name == but_of:
                break
    elif is_dataclass(node) and not isinstance(node, Span):
        for one in fields(node):
            yield from references(getattr(node, one.name), but_of)
