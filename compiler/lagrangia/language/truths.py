"""Boolean variables of functions, as numbers: 1 where they are true, -1 where they are not.

Functions are of numbers. What a condition decides is one where it is made, where its change is an event; where the number is
read it is a condition again, y > 0, which changes with it.
"""

from lagrangia.base.diagnostics import fail
from lagrangia.language.number_checks import CONDITIONS
from lagrangia.language.tree import Array, Binary, Boolean, Flat, IfExpression, Number, Unary


def number_of(truth: Flat) -> Flat:
    """Of a condition, or an array of some. Raises LagError L0302."""
    match truth:
        case Boolean(value, span):
            return Number(1.0 if value else -1.0, None, span)
        case Array(items, span):
            return Array(tuple(map(number_of, items)), span)
        case IfExpression(condition, then, otherwise, span):
            return IfExpression(condition, number_of(then), number_of(otherwise), span)
        case Unary("not", _, span):
            return IfExpression(truth, Number(1.0, None, span), Number(-1.0, None, span), span)
        case Binary(operator, _, _, span) if operator in CONDITIONS:
            return IfExpression(truth, Number(1.0, None, span), Number(-1.0, None, span), span)
    fail("L0302", "a condition is true or false", truth.span, "compare it with something, as x > 0")


def truth_of(number: Flat) -> Flat:
    """The condition that such a number says."""
    return Binary(">", number, Number(0.0, None, number.span), number.span)
