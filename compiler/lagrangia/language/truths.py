"""Boolean variables, as numbers: 1 where they are true; where they are not, -1 in functions and 0 elsewhere.

Equations and functions are of numbers. What a condition decides is one where it is made, where its change is an event; where the
number is read it is a condition again, which changes with it.
"""

from lagrangia.base.diagnostics import fail
from lagrangia.language.number_checks import CONDITIONS
from lagrangia.language.tree import Array, Binary, Boolean, Flat, IfExpression, Number, Unary

NO = 0.0  # of variables of models: results show 0 and 1
_NO_OF_FUNCTIONS = -1.0


def number_of(truth: Flat, no: float = _NO_OF_FUNCTIONS) -> Flat:
    """Of a condition, or an array of some; `no` is what is not true. Raises LagError L0302."""
    match truth:
        case Boolean(value, span):
            return Number(1.0 if value else no, None, span)
        case Array(items, span):
            return Array(tuple(number_of(item, no) for item in items), span)
        case IfExpression(condition, then, otherwise, span):
            return IfExpression(condition, number_of(then, no), number_of(otherwise, no), span)
        case Unary("not", _, span):
            return IfExpression(truth, Number(1.0, None, span), Number(no, None, span), span)
        case Binary(operator, _, _, span) if operator in CONDITIONS:
            return IfExpression(truth, Number(1.0, None, span), Number(no, None, span), span)
    fail("L0302", "a condition is true or false", truth.span, "compare it with something, as x > 0")


def truth_of(number: Flat, no: float = _NO_OF_FUNCTIONS) -> Flat:
    """The condition that such a number says."""
    return Binary(">", number, Number((1 + no) / 2, None, number.span), number.span)
