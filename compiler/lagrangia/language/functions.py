"""The functions and constants of the kernel, by their names."""

import math
from collections.abc import Callable, Mapping
from dataclasses import replace

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.tree import Array, Binary, Call, EnumerationLiteral, Flat, IfExpression, Number

# Number of arguments of each function of the kernel; None: any number, at least one.
FUNCTIONS: Mapping[str, tuple[int, ...] | None] = {
    **dict.fromkeys(("sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp",
                     "log", "log10", "sqrt", "abs", "sign", "floor", "ceil", "norm", "der", "pre", "virtual",
                     "contact_force", "constraint_force"), (1,)),
    **dict.fromkeys(("atan2", "mod", "dot", "cross", "distance", "rotate", "shift", "to_world", "to_frame", "velocity_at",
                     "hinge_angle"), (2,)),
    "turn": (2, 3),
    "table": (2, 3), "table2": (3, 5), "min": None, "max": None, "sum": None, "product": None,
}
# Those of numbers: of an array they are that of each element.
SCALAR_FUNCTIONS = frozenset({"sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh",
                              "exp", "log", "log10", "sqrt", "abs", "sign", "floor", "ceil", "atan2", "mod"})
# Those that Modelica has in Modelica.Math; others of these it knows without a package.
OF_MATH = SCALAR_FUNCTIONS - {"abs", "sign", "floor", "ceil", "mod", "sqrt"}
FRAME_FUNCTIONS = frozenset({"shift", "turn"})
CONSTANTS = {"pi": math.pi}
DIMENSIONS = "dimensions"  # 2 in the plane, 3 in space: the size of vectors in components for both
ALIASES = {"arcsin": "asin", "arccos": "acos", "arctan": "atan", "ln": "log", "ceiling": "ceil", "pow": "^", "hypot": "norm"}


def _toward_zero(x: Flat, span: Span) -> Flat:
    up, down = (Call(name, (x,), (), span) for name in ("ceil", "floor"))
    return IfExpression(Binary("<", x, Number(0.0, "1", span), span), up, down, span)


def _div(a: Flat, b: Flat, span: Span) -> Flat:
    """Of quantities with the same unit: how often is a number, as the 0 it is compared with. A bare b takes the unit of a."""
    divisor = replace(b, is_integer=False) if isinstance(b, Number) and b.unit is None else b
    return _toward_zero(Binary("/", a, divisor, span), span)


def _semi_linear(x: Flat, above: Flat, below: Flat, span: Span) -> Flat:
    slope = IfExpression(Binary("<", x, Number(0.0, None, span), span), below, above, span)
    return Binary("*", x, slope, span)


def _ordinal(value: Flat, span: Span) -> Flat:
    if not isinstance(value, EnumerationLiteral):
        fail("L0302", "Integer(...) is the place of a value of an enumeration", span, "the whole number below x is floor(x)")
    return Number(float(value.ordinal), None, span, True)


# Functions of Modelica that are said by others: how many arguments they take, and what they stand for. Kinks are located exactly
# whether noEvent and smooth say that they need not be or not.
def _pre(x: Flat, span: Span) -> Flat:
    """Of a comparison, what it is of what was before; of an array, that of each element."""
    if isinstance(x, Array):
        return Array(tuple(_pre(item, span) for item in x.items), x.span)
    if isinstance(x, Binary) and x.operator in ("<", "<=", ">", ">="):
        return Binary(x.operator, _pre(x.left, span), x.right if isinstance(x.right, Number) else _pre(x.right, span), x.span)
    return Call("pre", (x,), (), span)


REWRITTEN: Mapping[str, tuple[int, Callable[..., Flat]]] = {
    "noEvent": (1, lambda x, span: x), "smooth": (2, lambda order, x, span: x), "homotopy": (2, lambda x, simple, span: x),
    "integer": (1, lambda x, span: Call("floor", (x,), (), span)), "div": (2, _div),
    "rem": (2, lambda a, b, span: Binary("-", a, Binary("*", b, _div(a, b, span), span), span)),
    "pre": (1, _pre), "semiLinear": (3, _semi_linear), "Integer": (1, _ordinal),
}
# What stands before brackets alone, so that it is no type.
CALLED = frozenset({*FUNCTIONS, *REWRITTEN, *ALIASES, "connect", "assert", "terminate", "reinit", "delay"})
