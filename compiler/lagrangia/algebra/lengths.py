"""Lengths sqrt(x^2 + y^2 + TINY) as they are in value: 0 where all that is squared is 0.

TINY keeps their slopes finite there (duals.py). Its root is subtracted, which changes no digit of lengths above 1e-134. What
divides by a length keeps it: 0/0 is 0.
"""

import math
from collections.abc import Sequence

import casadi as ca

from lagrangia.algebra.duals import TINY
from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, operate

_ROOT = math.sqrt(TINY)


def exact_lengths(expressions: Sequence[ca.SX]) -> list[ca.SX]:
    """The expressions, of scalars, with lengths that are 0 at 0; others are the same."""
    made = ca.vertcat(ca.SX(0, 1), *expressions)
    function = ca.Function("made", [ca.vertcat(ca.SX(0, 1), *ca.symvar(made))], [made])
    has_length = any(function.instruction_id(k) == ca.OP_CONST and function.instruction_constant(k) == TINY
                     for k in range(function.n_instructions()))
    lengths = _Lengths()
    return rebuilt([*map(ca.SX, expressions)], lengths.numbering, lengths.made) if has_length else list(expressions)


class _Lengths:
    """`lengthened`: by the numbers of values that lengths are in, the same with TINY in them."""

    def __init__(self) -> None:
        self.numbering, self.lengthened = Numbering(), dict[int, Expression]()

    def made(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        """An instruction whose lengths are exact, but for those that it divides by."""
        number, tiny = self.numbering.of(op, numbers), self.numbering.of_number(TINY)
        plain = [self.lengthened.get(k, x) for k, x in zip(numbers, operands, strict=True)]
        adds_tiny = op == ca.OP_ADD and tiny in numbers
        if self.lengthened.keys().isdisjoint(numbers) and not adds_tiny:
            return None
        self.lengthened[number] = operate(op, plain)
        if adds_tiny:
            return operands[numbers[0] == tiny]
        if op == ca.OP_SQRT and tiny in self.numbering.keys[numbers[0]][1:]:
            return as_expression(self.lengthened[number] - _ROOT)
        if op == ca.OP_SUB and operands[1].is_constant() and float(operands[1]) == _ROOT:
            self.lengthened[number] = plain[0]
            return operands[0]  # it is exact already
        if op == ca.OP_DIV:
            return operate(op, [operands[0], plain[1]])
        is_below = op == ca.OP_INV or (op in (ca.OP_POW, ca.OP_CONSTPOW) and operands[1].is_constant() and float(operands[1]) < 0)
        return self.lengthened[number] if is_below else None
