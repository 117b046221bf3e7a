"""The values of flat expressions that are made of numbers alone."""

import math
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.language.tree import Array, Binary, Boolean, Call, EnumerationLiteral, Flat, Number, Ref, String, Unary

Known = Callable[[Ref], float | None]

_ARITHMETIC = frozenset("+-*/^")
_FOLD: Mapping[str, Callable[[Any, Any], Any]] = {
    "+": lambda a, b: a + b, "-": lambda a, b: a - b, "*": lambda a, b: a * b, "/": lambda a, b: a / b, "^": math.pow,
    "==": lambda a, b: a == b, "<>": lambda a, b: a != b, "<": lambda a, b: a < b, "<=": lambda a, b: a <= b,
    ">": lambda a, b: a > b, ">=": lambda a, b: a >= b, "and": lambda a, b: a and b, "or": lambda a, b: a or b,
}
_FOLD_CALLS: Mapping[str, Callable[..., Any]] = {
    "floor": math.floor, "ceil": math.ceil, "abs": abs, "mod": lambda a, b: a - b * math.floor(a / b), "sqrt": math.sqrt,
    "sin": math.sin, "cos": math.cos, "tan": math.tan, "exp": math.exp, "log": math.log,
    "log10": math.log10, "asin": math.asin, "acos": math.acos, "atan": math.atan, "atan2": math.atan2, "sinh": math.sinh,
    "cosh": math.cosh, "tanh": math.tanh,
}
_FOLD_ALL: Mapping[str, Callable[[Any], Any]] = {"sum": sum, "product": math.prod, "min": min, "max": max}


def _scalars(nodes: Iterable[Flat]) -> list[Flat]:
    return [x for node in nodes for x in (_scalars(node.items) if isinstance(node, Array) else [node])]


def fold(node: Flat, known: Known | None = None) -> float | bool | None:
    """The value of a scalar expression of numbers alone, and of names whose values are `known`, else None. Raises LagError L0217
    where it has none."""
    try:
        match node:
            case Number(value) | Boolean(value):
                return value
            case Ref() if known is not None:
                return known(node)
            case Binary(operator, left, right) if operator in _ARITHMETIC:
                return _folded_pair(operator, left, right, known)
            case EnumerationLiteral():
                return None
            case Binary(("==" | "<>" | "<" | "<=" | ">" | ">=") as operator, EnumerationLiteral() as left,
                        EnumerationLiteral() as right, span):
                if left.type_name != right.type_name:
                    fail("L0302", f"values of {left.type_name} and of {right.type_name} cannot be compared", span)
                return bool(_FOLD[operator](left.ordinal, right.ordinal))
            case Binary(("==" | "<>") as operator, String() as left, String() as right, _):
                return bool(_FOLD[operator](left.value, right.value))
            case Call("sum" | "product" | "min" | "max" as function, arguments, (), _):
                values = [fold(x, known) for x in _scalars(arguments)]
                return None if None in values or not values else _FOLD_ALL[function](values)
            case Unary(operator, operand):
                inner = fold(operand, known)
                return None if inner is None else (not inner) if operator == "not" else -inner
            case Binary(operator, left, right):
                return _folded_pair(operator, left, right, known)
            case Call(function, arguments, (), _) if function in _FOLD_CALLS:
                values = [fold(a, known) for a in arguments]
                return None if None in values else _FOLD_CALLS[function](*values)
    except (ArithmeticError, ValueError):
        fail("L0217", "this cannot be computed", node.span, "a division by zero or a function outside its domain")
    return None


def _folded_pair(operator: str, left: Flat, right: Flat, known: Known | None) -> float | bool | None:
    a, b = fold(left, known), fold(right, known)
    found: float | bool | None = None if a is None or b is None else _FOLD[operator](a, b)
    return found


def numbers_of(binding: Flat, shape: tuple[int, ...], known: Known | None = None) -> list[float | None]:
    """The elements of a binding: values where it says numbers, None where it depends on something that is not `known`."""
    if shape and not isinstance(binding, Array):
        return [None] * math.prod(shape)
    items = binding.items if isinstance(binding, Array) else (binding,)
    found: list[float | None] = []
    for item in items:
        value = None if isinstance(item, Array) else fold(item, known)
        found += numbers_of(item, (), known) if isinstance(item, Array) else [None if value is None else float(value)]
    return found


def folded(node: Flat) -> Flat | None:
    """The literal, or array of literals, that an expression of numbers alone stands for, else None."""
    if isinstance(node, String | EnumerationLiteral):
        return node
    if isinstance(node, Array):
        items = [known for item in node.items if (known := folded(item)) is not None]
        return Array(tuple(items), node.span) if len(items) == len(node.items) else None
    value = fold(node)
    if value is None:
        return None
    if isinstance(value, bool):
        return Boolean(value, node.span)
    return Number(float(value), node.unit if isinstance(node, Number) else None, node.span, float(value).is_integer())
