"""Forms of conditions in CasADi's expressions: choices, relations turned round, and what is as positive, or as much 0."""

from collections.abc import Mapping

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import apply, apply_to_one, as_expression

OPPOSITES = {ca.OP_LT: ca.OP_LE, ca.OP_LE: ca.OP_LT, ca.OP_EQ: ca.OP_NE, ca.OP_NE: ca.OP_EQ}
_DEPTH = 9  # down to which conditions are compared


def choice_of(x: ca.SX) -> tuple[ca.SX, ca.SX, ca.SX] | None:
    """The condition of a choice, and what it is where that is true and where not."""
    if x.op() != ca.OP_ADD or any(x.dep(k).op() != ca.OP_IF_ELSE_ZERO for k in range(2)):
        return None
    (condition, a), (other, b) = ([x.dep(k).dep(j) for j in range(2)] for k in range(2))
    return (condition, a, b) if other.op() == ca.OP_NOT and ca.is_equal(other.dep(0), condition, _DEPTH) else None


def chosen_numbers(x: Scalar) -> tuple[ca.SX, Scalar, Scalar] | None:
    """The condition and both values of a choice among numbers, one of which may be a choice again. A value of 0 has no term."""
    if not isinstance(x, ca.SX):
        return None
    found = (x.dep(0), x.dep(1), ca.SX(0)) if x.op() == ca.OP_IF_ELSE_ZERO else choice_of(x)
    if found is None:
        return None
    condition, *values = found
    a, b = (float(value) if value.is_constant() else value for value in values)
    return (condition, a, b) if all(isinstance(y, float) or chosen_numbers(y) is not None for y in (a, b)) else None


def without_sign(x: ca.SX) -> ca.SX:
    """x of what is x, -x or sign(y) x."""
    if x.op() == ca.OP_NEG:
        return without_sign(x.dep(0))
    factors = [x.dep(k) for k in range(2)] if x.op() == ca.OP_MUL else []
    found = next((k for k, factor in enumerate(factors) if factor.op() == ca.OP_SIGN), None)
    return x if found is None else without_sign(factors[1 - found])


def turned_relation(condition: Scalar, table: Mapping[int, int]) -> Scalar | None:
    """The one that is true where the condition is not: b <= a for a < b."""
    if not isinstance(condition, ca.SX) or condition.op() not in table:
        return None
    return apply(table[condition.op()], condition.dep(1), condition.dep(0))


def are_mirrored(a: Scalar, b: Scalar, op: int) -> bool:
    """Whether they are x op y and y op x."""
    return (isinstance(a, ca.SX) and isinstance(b, ca.SX) and a.op() == b.op() == op
            and ca.is_equal(a.dep(0), b.dep(1), _DEPTH) and ca.is_equal(a.dep(1), b.dep(0), _DEPTH))


def in_one(x: Scalar) -> Scalar:
    """|c| |x| as |c x|, of which it is asked whether it is 0."""
    if not isinstance(x, ca.SX) or x.op() not in (ca.OP_MUL, ca.OP_DIV):
        return x
    parts = [in_one(as_expression(x.dep(k))) for k in range(2)]
    if any(not isinstance(part, ca.SX) or part.op() != ca.OP_FABS for part in parts):
        return as_expression(apply(x.op(), *parts))
    return apply_to_one(ca.OP_FABS, apply(x.op(), *(part.dep(0) for part in parts)))


def of_sign(x: Scalar) -> Scalar:
    """What is as positive as x."""
    return x.dep(0) if isinstance(x, ca.SX) and x.op() == ca.OP_SIGN else x
