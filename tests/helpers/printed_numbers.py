"""What is printed, as a number: layouts evaluated with a value for every name, beside the expressions they were made of."""

import math
import operator
import random
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager

import pytest
import sympy as sp

from lagrangia.paper import layout
from lagrangia.paper.layout import Name, Node
from lagrangia.paper.presentation import Presentation

_METHODS = ("sum", "coefficient", "gentle", "momentum", "motion")
_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "ln": math.log, "abs": abs, "sgn": lambda x: (x > 0) - (x < 0), "arcsin": math.asin, "arccos": math.acos, "arctan": math.atan,
    "min": min, "max": max, "ceil": math.ceil, "floor": math.floor, "exp": math.exp,
    **{name: getattr(math, name) for name in ("sin", "cos", "tan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "atan2")},
}
_HOLDS: Mapping[str, Callable[[float, float], bool]] = {
    "<": operator.lt, "≤": operator.le, ">": operator.gt, "≥": operator.ge, "=": operator.eq, "≠": operator.ne}


def number(node: Node, values: Mapping[Name, float]) -> float:
    """The value of a formula; KeyError for a name that has none."""
    def of(x: Node) -> float:
        return number(x, values)

    match node:
        case layout.Name():
            return math.pi if node.base == "pi" and node not in values else values[node]
        case layout.Numeral(value):
            return float(value)
        case layout.Product(items):
            return math.prod(map(of, items))
        case layout.Total(items):
            return sum(sign * of(x) for sign, x in items)
        case layout.Quotient(top, bottom):
            return of(top) / of(bottom)
        case layout.Power(base, exponent):
            return of(base) ** of(exponent)
        case layout.Root(inside):
            return math.sqrt(of(inside))
        case layout.Bracket(inside):
            return of(inside)
        case layout.Apply(function, layout.Listing(items)):
            return _FUNCTIONS[function](*map(of, items))
        case layout.Apply(function, argument, power):
            return _FUNCTIONS[function](of(argument)) ** power
        case layout.Cases(items):
            return next(of(value) for value, when in items if when is None or _holds(when, values))
    raise TypeError(f"{node} is no number")


def _holds(node: Node, values: Mapping[Name, float]) -> bool:
    match node:
        case layout.Relation(left, right, symbol):
            return _HOLDS[symbol](number(left, values), number(right, values))
        case layout.Product(items):
            parts, word = items[::2], items[1].text  # type: ignore[union-attr]
            return (all if word == " and " else any)(_holds(x, values) for x in parts)
    raise TypeError(f"{node} is no condition")


@contextmanager
def everything_laid_out() -> Iterator[list[str]]:
    """Compares all that a Presentation lays out meanwhile with its expression; the list tells of each, empty where they agree."""
    told: list[str] = []
    with pytest.MonkeyPatch.context() as patch:
        for name in (*_METHODS, "equation"):
            patch.setattr(Presentation, name, _watched(getattr(Presentation, name), told))
        yield told


def _watched(method: Callable[..., Node], told: list[str]) -> Callable[..., Node]:
    def watched(self: Presentation, expression: sp.Expr, *others: object) -> Node:
        node = method(self, expression, *others)
        wanted = sp.sympify(expression)
        if isinstance(node, layout.Relation):
            wanted -= sp.sympify(others[0])
        numbers, values = _values(self, wanted)
        x, y = float(wanted.xreplace(numbers).evalf()), \
            number(node.left, values) - number(node.right, values) if isinstance(node, layout.Relation) else number(node, values)
        told.append("" if abs(x - y) <= 1e-4 * max(1.0, abs(x)) else f"{wanted} is {x}, printed {y}")
        return node

    return watched


def _values(p: Presentation, expression: sp.Expr) -> tuple[dict[sp.Expr, sp.Float], dict[Name, float]]:
    """The same random numbers by symbol and by name; roots of long sums have names, too."""
    chosen = random.Random(5)
    free = {s for x in (*p.symbols.names, *p.symbols.lengths, expression) for s in x.free_symbols}
    symbols = sorted(free, key=lambda s: s.name)
    numbers = {s: sp.Float(chosen.uniform(0.3, 1.2)) for s in symbols}
    values = {name: float(numbers[s]) for s, name in p.symbols.names.items()}
    return numbers, values | {name: math.sqrt(float(x.xreplace(numbers))) for x, name in p.symbols.lengths.items()}
