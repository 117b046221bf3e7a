"""Coefficients of rates that are divided by the lengths of these, in sums and choices: v (a/|v| + b) as v a/|v| + v b.

What holds v, a v/|v|, is found in products alone (dynamics/directions.py): between steps the sum would go on over the jump of it.
"""

import casadi as ca

from lagrangia.algebra.scalars import Expression, as_expression, operate, symbols_in

_SUMS = frozenset({ca.OP_ADD, ca.OP_SUB})
_FACTORS = frozenset({ca.OP_MUL, ca.OP_NEG, ca.OP_TWICE})
_LENGTHS = frozenset({ca.OP_FABS, ca.OP_SQRT})
_DEPTH = 8  # down to which a coefficient is taken apart


def spread(v: ca.SX, coefficient: ca.SX, rates: frozenset[int]) -> Expression | None:
    """Their product, of what has `rates`, by the hashes of these, where the coefficient is such a sum or choice."""
    is_one = v.numel() == coefficient.numel() == 1  # columns are energies of bodies alike
    if not is_one or not _divides_in_sum(coefficient, rates, False, _DEPTH) or rates.isdisjoint(symbols_in(v)):
        return None
    return _times(as_expression(v), as_expression(coefficient), rates, _DEPTH)


def _divides_in_sum(x: ca.SX, rates: frozenset[int], is_in_sum: bool, depth: int) -> bool:
    """Whether a length with rates divides in a sum, or in what stands `is_in_sum`."""
    if depth == 0:
        return False
    operands = [x.dep(k) for k in range(x.n_dep())]
    if x.op() in (ca.OP_DIV, ca.OP_INV) and is_in_sum and is_length(operands[-1], rates, depth):
        return True
    within = is_in_sum or x.op() in _SUMS
    if x.op() in _SUMS | _FACTORS or x.op() in (ca.OP_DIV, ca.OP_IF_ELSE_ZERO):
        inner = operands[:1] if x.op() == ca.OP_DIV else operands[-1:] if x.op() == ca.OP_IF_ELSE_ZERO else operands
        return any(_divides_in_sum(part, rates, within, depth - 1) for part in inner)
    return False


def is_length(x: ca.SX, rates: frozenset[int], depth: int = _DEPTH) -> bool:
    """Whether it is a length with rates, or a product with one."""
    if x.op() in _LENGTHS:
        return not rates.isdisjoint(symbols_in(x))
    return depth > 0 and x.op() in _FACTORS and any(is_length(x.dep(k), rates, depth - 1) for k in range(x.n_dep()))


def _times(v: Expression, x: Expression, rates: frozenset[int], depth: int) -> Expression:
    """v x, by the terms of x."""
    if not _divides_in_sum(x, rates, False, depth):
        return as_expression(v * x)
    operands = [as_expression(x.dep(k)) for k in range(x.n_dep())]
    if x.op() in _SUMS:
        return operate(x.op(), [_times(v, term, rates, depth - 1) for term in operands])
    if x.op() == ca.OP_IF_ELSE_ZERO:
        return operate(x.op(), [operands[0], _times(v, operands[1], rates, depth - 1)])
    if x.op() == ca.OP_MUL:
        k = 0 if _divides_in_sum(operands[0], rates, False, depth - 1) else 1
        return _times(as_expression(v * operands[1 - k]), operands[k], rates, depth - 1)
    return operate(x.op(), [_times(v, operands[0], rates, depth - 1), *operands[1:]])
