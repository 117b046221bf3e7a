"""Widths that keep roots of rates from 0, as w does in sqrt(v^2 + w^2): where w is 0 it is |v|, whose corner no square tells.

A root whose width is 0 as declared is chosen by a condition on parameters, and what is divided by it as well. Of others it is
kept what must not be 0 where something is divided by them (compile/divisors.py).
"""

from collections.abc import Callable
from dataclasses import field

import casadi as ca

from lagrangia.algebra.condition_forms import choice_of
from lagrangia.algebra.duals import TINY
from lagrangia.algebra.powers import never_negative, terms_of
from lagrangia.algebra.scalars import Expression, as_expression, operate, symbols_in
from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass

_FACTORS = frozenset({ca.OP_MUL, ca.OP_DIV, ca.OP_TWICE, ca.OP_NEG})
_DEPTH = 9  # down to which products are taken apart
Arms = tuple[Expression, Expression, Expression]


@dataclass
class Divisors:
    """What must not be 0: `roots` by their numbers, with their widths; parameters that something is divided by, and where;
    whether lengths of rates are among the divisors."""

    roots: dict[int, Expression] = field(default_factory=dict)
    steady: dict[int, tuple[Expression, Span]] = field(default_factory=dict)  # by the hashes of expressions
    has_lengths: bool = False

    def note(self, x: Expression, place: Span) -> None:
        """Of parameters alone."""
        self.steady.setdefault(x.__hash__(), (x, place))


def width_beside(x: ca.SX, rates: frozenset[int], is_steady: Callable[[ca.SX], bool]) -> tuple[Expression, Expression] | None:
    """v^2 and w^2 of what stands under a root, v^2 + w^2, where v^2 is a sum of squares, each with `rates`, and w^2 of
    parameters; of |v| + w, and of max(|v|, w), the same."""
    terms = [(1, x.dep(k)) for k in range(2)] if x.op() == ca.OP_FMAX else terms_of(as_expression(x))
    numbers = [term for _, term in terms if term.is_constant()]
    others = [(sign, term) for sign, term in terms if not term.is_constant()]
    steady = [is_steady(term) for _, term in others]
    if all(steady) or not any(steady) or any(abs(float(number)) > TINY for number in numbers):
        return None
    moving = [pair for pair, known in zip(others, steady, strict=True) if not known]
    if not all(sign > 0 and never_negative(term) and not rates.isdisjoint(symbols_in(term)) for sign, term in moving):
        return None
    square, width = as_expression(0.0), as_expression(0.0)
    for (sign, term), known in zip(others, steady, strict=True):
        square, width = (square, as_expression(width + sign * term)) if known else (as_expression(square + term), width)
    return as_expression(square + TINY) if numbers and len(moving) > 1 else square, width


def arms_of(x: ca.SX, depth: int = _DEPTH) -> Arms | None:
    """A condition, and what x is where it is true and where not: of a choice, and of products with one."""
    if x.op() in _FACTORS and depth:
        operands = [x.dep(k) for k in range(x.n_dep())]
        for k, operand in enumerate(operands):
            if (inner := arms_of(operand, depth - 1)) is not None:
                condition, *arms = inner
                a, b = ([*operands[:k], arm, *operands[k + 1 :]] for arm in arms)
                return condition, operate(x.op(), a), operate(x.op(), b)
    found = choice_of(x)
    return None if found is None else (as_expression(found[0]), as_expression(found[1]), as_expression(found[2]))
