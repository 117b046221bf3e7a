"""Forms of conditions in CasADi's expressions: choices, relations turned round, and what is as positive, or as much 0."""

from collections.abc import Mapping

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import apply, apply_to_one, as_expression

OPPOSITES = {ca.OP_LT: ca.OP_LE, ca.OP_LE: ca.OP_LT, ca.OP_EQ: ca.OP_NE, ca.OP_NE: ca.OP_EQ}


def chosen_numbers(x: Scalar) -> tuple[ca.SX, Scalar, Scalar] | None:
    """The condition and both values of a choice among numbers, one of which may be a choice again. A value of 0 has no term."""
    if not isinstance(x, ca.SX) or x.op() not in (ca.OP_ADD, ca.OP_IF_ELSE_ZERO):
        return None
    terms = [x] if x.op() == ca.OP_IF_ELSE_ZERO else [x.dep(0), x.dep(1)]
    for term in terms[1:]:
        if terms[0].op() != ca.OP_IF_ELSE_ZERO or term.op() != ca.OP_IF_ELSE_ZERO or term.dep(0).op() != ca.OP_NOT:
            return None
        if not ca.is_equal(term.dep(0).dep(0), terms[0].dep(0), 9):
            return None
    values = [float(term.dep(1)) if term.dep(1).is_constant() else term.dep(1) for term in terms]
    is_known = all(isinstance(value, float) or chosen_numbers(value) is not None for value in values)
    return (terms[0].dep(0), values[0], values[1] if len(values) > 1 else 0.0) if is_known else None


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
            and ca.is_equal(a.dep(0), b.dep(1), 9) and ca.is_equal(a.dep(1), b.dep(0), 9))


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
