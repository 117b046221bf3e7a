"""Roots, powers and logarithms of what is 0 where a rate rests, as |v|^a is and sqrt(2 |v| + v^2).

With the sign of v held |v| is negative where a step passes v = 0, and they have no value there: their |v| is 0 beyond. Where
slopes at 0 have no bounds the whole is 0 beyond, with its slopes. A power whose exponent is a parameter is a whole one while that
is whole, and stays as it is then. |a| of places is 0 beyond under constant powers above 1 alone: implicit steps make too little
of slopes of roots of places.
"""

from collections.abc import Callable, Sequence

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import Expression, apply, as_expression

_PRODUCTS = frozenset({ca.OP_MUL, ca.OP_DIV, ca.OP_NEG, ca.OP_TWICE})
_POWERS = (ca.OP_POW, ca.OP_CONSTPOW)
_LEAST = 1e-300  # under a root whose slope has a bound
Combine = Callable[[int, Sequence[Expression]], Expression]


def is_length(numbering: Numbering, op: int, numbers: Sequence[int]) -> bool:
    """Of |a|, and of max(a, -a)."""
    if op != ca.OP_FMAX:
        return bool(op == ca.OP_FABS)
    a, b = numbers
    return numbering.keys[a] == (ca.OP_NEG, b) or numbering.keys[b] == (ca.OP_NEG, a)


class Roots:
    """`rates`: the numbers of rates whose signs are held; `combined`: makes instructions of operands that jump."""

    def __init__(self, numbering: Numbering, rates: frozenset[int], combined: Combine) -> None:
        self.numbering, self.rates, self.combined = numbering, rates, combined
        self.powers = dict[int, tuple[int, Expression, Expression]]()  # by number: the base's number, the base, and the exponent
        self.clipped = dict[int, tuple[Expression, bool]]()  # what is 0 with a length, of lengths that are 0 beyond; of a rate?

    def note_length(self, number: int, clipped: Expression, is_rate: bool) -> None:
        """|a| that is 0 where a has another sign than it is held with."""
        self.clipped[number] = clipped, is_rate

    def note(self, op: int, numbers: Sequence[int], operands: Sequence[Expression]) -> None:
        """An instruction that may be 0 with the lengths among its operands."""
        found = [self.clipped.get(k) for k in numbers]
        if any(found) and self._is_zero(op, numbers):
            clipped = [x if known is None else known[0] for known, x in zip(found, operands, strict=True)]
            is_rate = any(known is not None and known[1] for known in found)
            self.clipped[self.numbering.of(op, list(numbers))] = self.combined(op, clipped), is_rate

    def made(self, op: int, numbers: Sequence[int], operands: Sequence[Expression]) -> Expression | None:
        """A root, power or logarithm of such; of others, None."""
        if numbers[0] not in self.clipped or op not in (ca.OP_SQRT, ca.OP_LOG, *_POWERS):
            return None
        clipped, is_rate = self.clipped[numbers[0]]
        if op == ca.OP_LOG:
            return self.combined(op, [clipped]) if is_rate else None
        exponent = as_expression(0.5) if op == ca.OP_SQRT else operands[1]
        self.powers[self.numbering.of(op, list(numbers))] = numbers[0], operands[0], exponent
        if not exponent.is_constant():
            return self._rooted(op, operands, clipped, exponent) if is_rate else None
        if float(exponent) <= 0 or float(exponent).is_integer():
            return None
        if float(exponent) > 1:
            return self.combined(op, [clipped, *operands[1:]])
        return self._rooted(op, operands, clipped, exponent) if is_rate else None

    def times_length(self, number: int, is_below: bool) -> Expression | None:
        """|x|^(1 + a) of the number of |x|^a, or |x|^(1 - a) where that is below; of no power, None."""
        if number not in self.powers:
            return None
        base, value, exponent = self.powers[number]
        more = as_expression(1 - exponent if is_below else 1 + exponent)
        made = self.made(ca.OP_POW, [base, self.numbering.number(more)], [value, more])
        return self.combined(ca.OP_POW, [value, more]) if made is None else made

    def _rooted(self, op: int, operands: Sequence[Expression], clipped: Expression, exponent: Expression) -> Expression:
        bounded, is_some = apply(ca.OP_FMAX, clipped, _LEAST), as_expression(clipped > 0)
        if not exponent.is_constant():
            is_whole = as_expression(ca.logic_or(exponent <= 0, ca.floor(exponent) == exponent))
            bounded, is_some = ca.if_else(is_whole, operands[0], bounded), ca.logic_or(is_whole, is_some)
        rooted = self.combined(op, [as_expression(bounded), *operands[1:]])
        return self.combined(ca.OP_IF_ELSE_ZERO, [as_expression(is_some), rooted])

    def _is_zero(self, op: int, numbers: Sequence[int]) -> bool:
        """Where its operands that are lengths are 0."""
        if op in (ca.OP_ADD, ca.OP_SUB):
            return all(self._vanishes(k) for k in numbers)
        return op in (ca.OP_MUL, ca.OP_NEG, ca.OP_TWICE, ca.OP_SQ) or (op == ca.OP_DIV and numbers[0] in self.clipped)

    def _vanishes(self, number: int) -> bool:
        if number in self.clipped or number in self.rates:
            return True
        op, *operands = self.numbering.keys[number]
        inner = [int(x) for x in operands] if op in _PRODUCTS or op == ca.OP_SQ else []
        return any(self._vanishes(k) for k in (inner[:1] if op == ca.OP_DIV else inner))
