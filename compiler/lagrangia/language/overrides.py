"""Values given for structural parameters -> modifications, as if they were written."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangia.base.checked_values import a_number
from lagrangia.base.diagnostics import Source, Span
from lagrangia.base.spelling import read_number
from lagrangia.language.instances import Bound, Instance, Modification, Scope
from lagrangia.language.tree import Array, Boolean, Expression, Number, String


def override_tree(overrides: Mapping[str, Any], root: Instance) -> Modification:
    """{"n": 20, "sub.k": 3} as a tree of modifications."""
    tree: dict[str, Any] = {}
    for name, value in overrides.items():
        *path, last = name.split(".")
        node = tree
        for step in path:
            node = node.setdefault(step, {})
        given = Source(f"the value given for {name}", str(value))
        node[last] = _literal(value, Span(given, 0, len(given.text)))

    def build(node: Any) -> Modification:
        if isinstance(node, dict):
            return Modification(None, {name: build(inner) for name, inner in node.items()}, is_each=True)
        return Modification(Bound(node, Scope(root)), {}, is_each=True, span=root.span)

    return build(tree)


def as_written(name: str, text: str) -> Expression:
    """A number, or several in braces, with their units: `3[mm]`, for checks of these. Raises ValueError."""
    given = Source(f"the value given for {name}", text)
    span = Span(given, 0, len(text))

    def scalar(part: str) -> Number:
        number, _, unit = part.strip().removesuffix("]").partition("[")
        return Number(read_number(number), unit or None, span)

    if not text.startswith("{"):
        return scalar(text)
    return Array(tuple(map(scalar, text[1:-1].split(","))), span)


def _literal(value: Any, span: Span) -> Expression:
    if isinstance(value, Number | Array):
        return value
    if isinstance(value, bool):
        return Boolean(value, span)
    if isinstance(value, str):
        return String(value, span)
    if isinstance(value, Sequence):
        return Array(tuple(_literal(item, span) for item in value), span)
    number = a_number(span.source.name.removeprefix("the "), value)
    return Number(number, None, span, number.is_integer())
