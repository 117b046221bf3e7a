"""Coefficients of rates that are divided by the lengths of these, in sums, choices and bounds: v (a/|v| + b) as v a/|v| + v b,
v max(a/|v|, b) as v/|v| max(a, b |v|).

What holds v, a v/|v|, is found in products alone (dynamics/directions.py): between steps the sum would go on over the jump of it.
"""

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import Expression, apply_to_one, as_expression, operate, symbols_in

_SUMS = frozenset({ca.OP_ADD, ca.OP_SUB})
_BOUNDS = frozenset({ca.OP_FMAX, ca.OP_FMIN})
_FACTORS = frozenset({ca.OP_MUL, ca.OP_NEG, ca.OP_TWICE})
_LENGTHS = frozenset({ca.OP_FABS, ca.OP_SQRT})
_DEPTH = 8  # down to which a coefficient is taken apart


def spread(v: ca.SX, coefficient: ca.SX, rates: frozenset[int]) -> Expression | None:
    """Their product, of what has `rates`, by the hashes of these, where the coefficient is such a sum, choice or bound."""
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
    within = is_in_sum or x.op() in _SUMS | _BOUNDS
    if x.op() in _SUMS | _BOUNDS | _FACTORS or x.op() in (ca.OP_DIV, ca.OP_IF_ELSE_ZERO):
        inner = operands[:1] if x.op() == ca.OP_DIV else operands[-1:] if x.op() == ca.OP_IF_ELSE_ZERO else operands
        return any(_divides_in_sum(part, rates, within, depth - 1) for part in inner)
    return False


def is_length(x: ca.SX, rates: frozenset[int], depth: int = _DEPTH) -> bool:
    """Whether it is a length with rates, or a product with one."""
    return _length_in(x, rates, depth) is not None


def _length_in(x: ca.SX, rates: frozenset[int], depth: int) -> Expression | None:
    """The first length with rates among the factors."""
    if x.op() in _LENGTHS:
        return None if rates.isdisjoint(symbols_in(x)) else as_expression(x)
    parts = range(x.n_dep()) if depth > 0 and x.op() in _FACTORS else ()
    return next((found for k in parts if (found := _length_in(x.dep(k), rates, depth - 1)) is not None), None)


def _length_below(x: ca.SX, rates: frozenset[int], depth: int) -> Expression | None:
    """The first length with rates that something is divided by."""
    if depth == 0 or x.is_constant() or x.is_symbolic():
        return None
    if x.op() in (ca.OP_DIV, ca.OP_INV) and (found := _length_in(x.dep(x.n_dep() - 1), rates, depth)) is not None:
        return found
    return next((found for k in range(x.n_dep()) if (found := _length_below(x.dep(k), rates, depth - 1)) is not None), None)


def _above(x: Expression, length: Expression, depth: int) -> Expression:
    """length x, without the length where x is divided by it; which is never negative, so that the larger stays the larger."""
    if depth == 0:
        return as_expression(x * length)
    operands = [as_expression(x.dep(k)) for k in range(x.n_dep())]
    if x.op() in _SUMS | _BOUNDS:
        return operate(x.op(), [_above(y, length, depth - 1) for y in operands])
    if x.op() in (ca.OP_NEG, ca.OP_TWICE):
        return operate(x.op(), [_above(operands[0], length, depth - 1)])
    if x.op() == ca.OP_IF_ELSE_ZERO:
        return operate(x.op(), [operands[0], _above(operands[1], length, depth - 1)])
    if x.op() in (ca.OP_DIV, ca.OP_INV) and (rest := _without(operands[-1], length, depth)) is not None:
        return as_expression((operands[0] if x.op() == ca.OP_DIV else 1.0) / rest)
    if x.op() in (ca.OP_MUL, ca.OP_DIV):
        k = next((k for k in range(1 if x.op() == ca.OP_DIV else 2) if _is_below(operands[k], length, depth - 1)), None)
        if k is not None:
            operands[k] = _above(operands[k], length, depth - 1)
            return operate(x.op(), operands)
    return as_expression(x * length)


def _is_below(x: Expression, length: Expression, depth: int) -> bool:
    """Whether something in it is divided by the length."""
    if depth == 0:
        return False
    operands = [as_expression(x.dep(k)) for k in range(x.n_dep())]
    if x.op() in (ca.OP_DIV, ca.OP_INV) and _without(operands[-1], length, depth) is not None:
        return True
    return any(_is_below(y, length, depth - 1) for y in operands)


def _without(x: Expression, length: Expression, depth: int) -> Expression | None:
    """What the length is multiplied by in a product; None: it is no factor."""
    if ca.is_equal(x, length, _DEPTH):
        return as_expression(1.0)
    operands = [as_expression(x.dep(k)) for k in range(x.n_dep())] if depth > 0 and x.op() in _FACTORS else []
    for k, operand in enumerate(operands):
        if (rest := _without(operand, length, depth - 1)) is not None:
            return operate(x.op(), [*operands[:k], rest, *operands[k + 1 :]])
    return None


def signed(x: Scalar, rates: frozenset[int], depth: int = _DEPTH) -> Scalar:
    """The same with sign(v) for v/|v| and |v|/v of what has `rates`: where a bound or a condition is its value on one side of 0,
    as in max(v/|v|, -1), 0/0 decides about nothing."""
    if not isinstance(x, ca.SX) or depth == 0 or x.is_constant() or x.is_symbolic() or rates.isdisjoint(symbols_in(x)):
        return x
    operands = [as_expression(x.dep(k)) for k in range(x.n_dep())]
    if x.op() == ca.OP_DIV and (made := _direction(operands[0], operands[1], rates, depth)) is not None:
        return made
    if x.op() in _SUMS | _BOUNDS | _FACTORS | {ca.OP_DIV}:
        return operate(x.op(), [as_expression(signed(y, rates, depth - 1)) for y in operands])
    return x


def _direction(above: Expression, below: Expression, rates: frozenset[int], depth: int) -> Expression | None:
    """a v/(b |v|) as sign(v) a/b, a |v|/(b v) so, too; None: it is neither."""
    for one, other in ((above, below), (below, above)):
        length = _length_in(other, rates, depth)
        if length is None or length.op() != ca.OP_FABS:
            continue
        v = as_expression(length.dep(0))
        rest, rest_of_length = _without(one, v, depth), _without(other, length, depth)
        if rest is not None and rest_of_length is not None:
            ratio = rest / rest_of_length if one is above else rest_of_length / rest
            return as_expression(apply_to_one(ca.OP_SIGN, v) * ratio)
    return None


def _times(v: Expression, x: Expression, rates: frozenset[int], depth: int) -> Expression:
    """v x, by the terms of x."""
    if not _divides_in_sum(x, rates, False, depth):
        return as_expression(v * x)
    operands = [as_expression(x.dep(k)) for k in range(x.n_dep())]
    if x.op() in _SUMS:
        return operate(x.op(), [_times(v, term, rates, depth - 1) for term in operands])
    if x.op() in _BOUNDS and (length := _length_below(x, rates, depth)) is not None:
        return as_expression(v / length * _above(x, length, depth))
    if x.op() == ca.OP_IF_ELSE_ZERO:
        return operate(x.op(), [operands[0], _times(v, operands[1], rates, depth - 1)])
    if x.op() == ca.OP_MUL:
        k = 0 if _divides_in_sum(operands[0], rates, False, depth - 1) else 1
        return _times(as_expression(v * operands[1 - k]), operands[k], rates, depth - 1)
    return operate(x.op(), [_times(v, operands[0], rates, depth - 1), *operands[1:]])
