"""Modifications as they are written, merged, and dealt out to the elements of arrays."""

from collections.abc import Iterable
from dataclasses import replace

from lagrangia.base.diagnostics import Span
from lagrangia.language.instances import NOTHING, Bound, Modification, Redeclared, Scope
from lagrangia.language.tree import Argument, Expression, Field


def modification_of(arguments: tuple[Argument, ...], scope: Scope, value: Expression | None, span: Span,
                    is_final: bool = False) -> Modification:
    """The tree of modifications written in one place; a later one of the same name is merged into the first."""
    children: dict[str, Modification] = {}
    for argument in arguments:
        inner = modification_of(argument.arguments, scope, argument.value, argument.name_span)
        redeclared = Redeclared(argument.redeclared, argument.span) if argument.redeclared is not None else None
        child = Modification(inner.value, inner.children, "each" in argument.prefixes, "final" in argument.prefixes,
                             argument.name_span, redeclared, argument.is_left_out)
        children[argument.name] = merge(children[argument.name], child) if argument.name in children else child
    return Modification(Bound(value, scope) if value is not None else None, children, False, is_final, span)


def merge(outer: Modification, inner: Modification) -> Modification:
    """What the outer scope says wins over what the inner one says."""
    if outer is NOTHING:
        return inner
    if outer.redeclared is not None and inner.redeclared is not None:
        return outer
    children = {name: replace(c, is_below=True) for name, c in inner.children.items()} if outer.value else dict(inner.children)
    for name, change in outer.children.items():
        children[name] = merge(change, children[name]) if name in children else change
    return Modification(outer.value or inner.value, children, outer.is_each if outer.value else inner.is_each,
                        outer.is_final or inner.is_final, outer.span or inner.span, outer.redeclared or inner.redeclared,
                        outer.is_left_out or inner.is_left_out, outer.was_each if outer.value else inner.was_each,
                        outer.is_below and inner.is_below)


def deal_out(change: Modification, index: int, size: int, dimensions: int, is_each: bool = False) -> Modification:
    """The part of a modification of an array of components that goes to element `index`; `each` goes to all unchanged,
    in every one of the array's dimensions."""
    stays_each = change.is_each and (is_each or dimensions > 1)  # under another one, it is that of an array within
    is_each = is_each or change.is_each
    value = change.value
    if value is not None and not is_each:
        value = Bound(value.expression, value.scope, (*value.selection, (index, size)), change.was_each)
    children = {name: deal_out(inner, index, size, dimensions, is_each) for name, inner in change.children.items()}
    return Modification(value, children, stays_each, change.is_final, change.span, change.redeclared,
                        was_each=change.was_each or change.is_each, is_below=change.is_below)


def dealt_to_fields(change: Modification, fields: Iterable[str]) -> Modification:
    """The value of a record as values of what it has; what is given beside it comes first, what was given before it last."""
    value = change.value
    assert value is not None

    def of(name: str) -> Modification:
        assert value is not None
        part = Field(value.expression, name, value.expression.span)
        return Modification(Bound(part, value.scope, value.selection, value.is_each), {}, False, False, change.span)

    found = {name: of(name) for name in fields}
    for name, inner in change.children.items():
        found[name] = merge(found[name], inner) if inner.is_below and name in found else inner
    return Modification(None, found, False, change.is_final, change.span)


def redeclares(change: Modification) -> bool:
    """Whether something is redeclared, in a part of a component as well."""
    return change.redeclared is not None or any(map(redeclares, change.children.values()))
