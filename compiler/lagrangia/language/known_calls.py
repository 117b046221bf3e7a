"""Calls of people's own functions whose arguments are known when the scene is compiled: `parameter Integer n = count(3)`."""

from collections.abc import Mapping, Sequence
from dataclasses import replace

from lagrangia.language.folding import folded
from lagrangia.language.function_variables import FlatFunction
from lagrangia.language.tree import Array, Binary, Boolean, Call, Flat, IfExpression, Local, Unary


def with_known_calls(node: Flat, functions: Mapping[str, FlatFunction], locals_: Mapping[str, Flat] | None = None) -> Flat:
    """An expression in which such calls, and `locals_`, are the values that they have."""
    known = locals_ or {}

    def inside(part: Flat) -> Flat:
        return with_known_calls(part, functions, known)

    match node:
        case Local(name):
            return known.get(name, node)
        case Array(items, span):
            return Array(tuple(map(inside, items)), span)
        case Unary(operator, operand, span):
            return Unary(operator, inside(operand), span)
        case Binary(operator, left, right, span):
            return Binary(operator, inside(left), inside(right), span)
        case IfExpression(condition, then, otherwise, _):
            chosen = folded(inside(condition))
            return inside(then if chosen.value else otherwise) if isinstance(chosen, Boolean) else node
        case Call(function, arguments, (), _):
            values = tuple(map(inside, arguments))
            found = _result(functions[function], values, functions) if function in functions else None
            return found if found is not None else replace(node, arguments=values)
    return node


def _result(function: FlatFunction, values: Sequence[Flat], functions: Mapping[str, FlatFunction]) -> Flat | None:
    known: dict[str, Flat] = {}
    for name, value in (*zip(function.inputs, values, strict=True), *function.steps):
        found = folded(with_known_calls(value, functions, known))
        if found is None:
            return None
        known[name] = found
    return known.get(function.output)
