"""The gradient of a dissipation function by rates. Of c |v| it is c v/|v|, which friction in the plane is known by.

Differentiation writes the root's slope as 2x c/(2 sqrt(x^2 + y^2)); here it is c x/sqrt(x^2 + y^2), where x are rates.
"""

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, operate, symbols_in
from lagrangia.algebra.with_casadi import uses


def gradient_by_rates(D: ca.SX, rates: ca.SX) -> ca.SX:
    """dD/d(rates), (n,)."""
    slope = ca.gradient(D, rates)
    if not uses(ca.Function("slope", [ca.vertcat(ca.SX(0, 1), *ca.symvar(slope))], [slope]), frozenset({ca.OP_SQRT})):
        return slope
    numbering = Numbering()
    return rebuilt([slope], numbering, _Directions(numbering, symbols_in(rates)).made)[0]


class _Directions:
    """`doubled`: what stands twice in an expression, by the number of that; `slopes`: c and |v| of c/(2 |v|), likewise."""

    def __init__(self, numbering: Numbering, rates: frozenset[int]) -> None:
        self.numbering, self.rates = numbering, rates
        self.doubled = dict[int, Expression]()
        self.lengths = set[int]()  # numbers of roots of what holds rates
        self.slopes = dict[int, tuple[Expression, Expression]]()

    def made(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        number = self.numbering.of(op, numbers)
        if op == ca.OP_SQRT and symbols_in(operands[0]) & self.rates:
            self.lengths.add(number)
        elif op == ca.OP_TWICE:
            self.doubled[number] = operands[0]
            if numbers[0] in self.lengths:
                self.lengths.add(number)
        elif op == ca.OP_DIV and numbers[1] in self.lengths and numbers[1] in self.doubled:
            self.slopes[number] = operands[0], self.doubled[numbers[1]]
        elif op == ca.OP_MUL:
            for k in (0, 1):
                if numbers[k] in self.slopes and numbers[1 - k] in self.doubled:
                    factor, length = self.slopes[numbers[k]]
                    above = operate(ca.OP_MUL, [factor, self.doubled[numbers[1 - k]]])
                    return operate(ca.OP_DIV, [above, length])
        return None
