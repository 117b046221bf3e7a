"""Flat arrays, and what is computed of them, dealt out: how many elements an expression has, and each of them."""

from collections.abc import Callable, Mapping
from dataclasses import replace

from lagrangia.base.diagnostics import LagError, Span, fail
from lagrangia.language.frame_attributes import frame_shape
from lagrangia.language.tree import Array, Binary, Call, Flat, FrameRef, IfExpression, Number, Ref, Unary

_OF_EACH = frozenset({"der", "virtual"})  # functions that give an array for an array
Size = Callable[[Ref], int | None]  # of the next dimension of a variable


def length(node: Flat, size: Size) -> int | None:
    """None for a single number. Raises LagError L0303 for arrays that do not go together."""
    match node:
        case Array(items, _):
            return len(items)
        case Ref():
            return size(node)
        case FrameRef():
            return next(iter(frame_shape(node)), None)
        case Call("rotate", _, _, _):
            return 2
        case Call(function, (inner,), _, _) if function in _OF_EACH:
            return length(inner, size)
        case Unary("-", operand, _):
            return length(operand, size)
        case Binary("+" | "-", left, right, span) | IfExpression(_, left, right, span):
            return _common(length(left, size), length(right, size), span)
        case Binary("*", left, right, _):
            a, b = length(left, size), length(right, size)
            return None if a is not None and b is not None else b if a is None else a  # two vectors: their inner product
        case Binary("/", left, _, _):
            return length(left, size)
    return None


def _common(a: int | None, b: int | None, span: Span) -> int | None:
    if a != b:
        first, second = ("a number" if n is None else f"an array of {n}" for n in (a, b))
        fail("L0303", f"{first} and {second} do not go together", span)
    return a


def element(node: Flat, index: int, size: Size) -> Flat:
    """One of an expression that has a length; the first is 1. Numbers in it stay as they are."""
    if length(node, size) is None:
        return node

    def of(part: Flat) -> Flat:
        return element(part, index, size)

    match node:
        case Array(items, _):
            return items[index - 1]
        case Ref(name, at, span):
            return Ref(name, (*at, index), span)
        case FrameRef(_, _, at, _):
            return replace(node, index=(*at, index))
        case Call("rotate", _, _, span):
            return Call("element", (node, Number(float(index), None, span, True)), (), span)
        case Call(function, (inner,), _, span):
            return Call(function, (of(inner),), (), span)
        case Unary(operator, operand, span):
            return Unary(operator, of(operand), span)
        case Binary(operator, left, right, span):
            return Binary(operator, of(left), of(right), span)
        case IfExpression(condition, then, otherwise, span):
            return IfExpression(condition, of(then), of(otherwise), span)
    return node


def array_of(shape: tuple[int, ...], index: tuple[int, ...], elements: Mapping[tuple[int, ...], Flat], span: Span) -> Flat:
    """The elements of an array, row by row."""
    if not shape:
        return elements[index]
    return Array(tuple(array_of(shape[1:], (*index, k), elements, span) for k in range(1, shape[0] + 1)), span)


def dealt_out(node: Flat, shape: tuple[int, ...], size: Size) -> Flat:
    """An array as one of its elements; as it is where what it is made of is no sum of arrays."""
    try:
        if not shape or length(node, size) != shape[0]:
            return node
    except LagError:  # matrices are multiplied in it
        return node
    rows = (element(node, k, size) for k in range(1, shape[0] + 1))
    return Array(tuple(dealt_out(row, shape[1:], size) for row in rows), node.span)
