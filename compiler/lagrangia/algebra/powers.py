"""Powers of what is never negative, by the lengths that they are powers of.

(x^2)^b is |x|^(2 b), sqrt(2 x^2 + x^4) is |x| sqrt(2 + x^2), and exp(b log(x^2)) is (x^2)^b: all of them bend where x is 0, which
squares do not tell. Steps, and series above all, would go on there as if x did: with sqrt(4 x^2) as 2 x.
"""

from collections.abc import Callable, Sequence
from functools import partial

import casadi as ca

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import Expression, apply_to_one, as_expression

_PRODUCTS = frozenset({ca.OP_MUL, ca.OP_DIV, ca.OP_SQ, ca.OP_TWICE, ca.OP_NEG})
_SUMS = frozenset({ca.OP_ADD, ca.OP_SUB})
_NEVER_NEGATIVE = frozenset({ca.OP_SQ, ca.OP_FABS, ca.OP_SQRT, ca.OP_EXP, ca.OP_COSH})
_MOST_TERMS = 8  # of a sum
_DEPTH = 9  # down to which expressions are compared
_DEEPEST = 8  # down to which they are taken apart, as what is said twice in each operation is twice as much in each
Factor = tuple[Expression, int]  # with its power


def length_powers(base: ca.SX, is_steady: Callable[[ca.SX], bool]) -> tuple[list[Factor], Expression]:
    """Of what is raised to a power that is not whole: |x| and k of its factors |x|^k that change, and all else. A power of |x|
    alone, but for what is steady and no length itself, is told by itself."""
    if base.op() not in _PRODUCTS | _SUMS:
        return [], as_expression(base)
    factors = _factors(as_expression(base))
    is_length = [power > 0 and x.op() == ca.OP_FABS and not is_steady(x) for x, power in factors]
    lengths = [factor for factor, found in zip(factors, is_length, strict=True) if found]
    rest = _product([factor for factor, found in zip(factors, is_length, strict=True) if not found])
    is_told = len(lengths) == 1 and lengths[0][1] == 1 and is_steady(rest) and (rest.is_constant() or not never_negative(rest))
    return ([], as_expression(base)) if is_told else (lengths, rest)


def powers_in_exponent(exponent: ca.SX) -> tuple[list[tuple[Expression, Expression | float]], Expression]:
    """x and b of the terms b log(x) of an exponent whose x is never negative, and all its other terms."""
    found, others = list[tuple[Expression, Expression | float]](), as_expression(0.0)
    for sign, term in terms_of(as_expression(exponent)) or [(1, as_expression(exponent))]:
        factors = _factors(term, opens_sums=False)
        logarithm = next((x for x, power in factors if x.op() == ca.OP_LOG and power == 1 and never_negative(x.dep(0))), None)
        if logarithm is None:
            others = as_expression(others + sign * term)
            continue
        b = as_expression(sign * _product([factor for factor in factors if factor[0] is not logarithm]))
        found.append((as_expression(logarithm.dep(0)), float(b) if b.is_constant() else b))
    return found, others


def never_negative(x: ca.SX, depth: int = _DEEPEST) -> bool:
    """By the operations that it is made by."""
    if x.is_constant() or depth == 0:
        return x.is_constant() and bool(float(x) >= 0)
    is_so = partial(never_negative, depth=depth - 1)
    operands = [x.dep(k) for k in range(x.n_dep())]
    if x.op() == ca.OP_FMAX:
        return any(map(is_so, operands)) or _are_opposite(*operands)
    if x.op() in (ca.OP_ADD, ca.OP_MUL, ca.OP_DIV, ca.OP_FMIN, ca.OP_TWICE):
        return all(map(is_so, operands))
    return x.op() in _NEVER_NEGATIVE


def bound_known(is_larger: bool, a: Scalar, b: Scalar) -> Scalar | None:
    """The larger or smaller of what is never negative and a number that is not positive, or |x| of x and -x; None: neither."""
    for x, other in ((a, b), (b, a)):
        if isinstance(x, ca.SX) and isinstance(other, float | int) and other <= 0 and never_negative(x):
            return x if is_larger else other
    if isinstance(a, ca.SX) and isinstance(b, ca.SX) and _are_opposite(a, b):
        length = apply_to_one(ca.OP_FABS, b.dep(0) if b.op() == ca.OP_NEG else b)
        return length if is_larger else as_expression(-length)
    return None


def _are_opposite(a: ca.SX, b: ca.SX) -> bool:
    return any(x.op() == ca.OP_NEG and ca.is_equal(x.dep(0), y, _DEPTH) for x, y in ((a, b), (b, a)))


def _factors(x: Expression, opens_sums: bool = True, depth: int = _DEEPEST) -> list[Factor]:
    """What a product or quotient is made of, once each; of sums, what all terms are multiples of, and the rest."""
    if opens_sums and (terms := terms_of(x)):
        return _common(x, terms)
    if x.op() not in _PRODUCTS or depth == 0:
        return [(x, 1)]
    found = _factors(as_expression(x.dep(0)), opens_sums, depth - 1)
    match x.op():
        case ca.OP_SQ:
            return [(y if never_negative(y) else apply_to_one(ca.OP_FABS, y), 2 * power) for y, power in found]
        case ca.OP_TWICE | ca.OP_NEG:
            return [*found, (as_expression(2.0 if x.op() == ca.OP_TWICE else -1.0), 1)]
    sign = 1 if x.op() == ca.OP_MUL else -1
    for y, power in _factors(as_expression(x.dep(1)), opens_sums, depth - 1):
        place = _place(found, y)
        if place is None:
            found.append((y, sign * power))
        else:
            found[place] = y, found[place][1] + sign * power
    return found


def _common(x: Expression, terms: Sequence[tuple[int, Expression]]) -> list[Factor]:
    each = [_factors(term, opens_sums=False) for _, term in terms]
    powers = {k: [_power(factors, y) for factors in each] for k, (y, _) in enumerate(each[0]) if not y.is_constant()}
    shared = [(each[0][k][0], min(found)) for k, found in powers.items() if min(found) > 0]
    if not shared:
        return [(x, 1)]
    rest = as_expression(0.0)
    for (sign, _), factors in zip(terms, each, strict=True):
        rest = as_expression(rest + sign * _product([(y, power - max(0, _power(shared, y))) for y, power in factors]))
    return [*shared, (rest, 1)]


def terms_of(x: Expression) -> list[tuple[int, Expression]]:
    """With their signs; none of what is no sum, or a long one."""
    if x.op() not in _SUMS:
        return []
    found, waiting = list[tuple[int, Expression]](), [(1, x)]
    while waiting:
        sign, term = waiting.pop()
        if term.op() in _SUMS:
            other = sign if term.op() == ca.OP_ADD else -sign
            waiting += [(other, as_expression(term.dep(1))), (sign, as_expression(term.dep(0)))]
        else:
            found.append((sign, term))
        if len(found) + len(waiting) > _MOST_TERMS:
            return []
    return found


def _product(factors: Sequence[Factor]) -> Expression:
    above, below = as_expression(1.0), as_expression(1.0)
    for x, power in factors:
        if power > 0:
            above = as_expression(above * x**power)
        elif power < 0:
            below = as_expression(below * x**-power)
    return above if below.is_one() else as_expression(above / below)


def _place(factors: Sequence[Factor], x: Expression) -> int | None:
    return next((k for k, (y, _) in enumerate(factors) if ca.is_equal(x, y, _DEPTH)), None)


def _power(factors: Sequence[Factor], x: Expression) -> int:
    place = _place(factors, x)
    return 0 if place is None else factors[place][1]
