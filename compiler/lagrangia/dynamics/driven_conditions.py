"""Conditions on what goes its way whatever moves, as inputs do: it may stay on a level for a while, and no rate tells its side.

A switch of a < b is 1 where b - a is more than EDGE, and so 0 on the level, as that of b < a is: a <= b is where the latter is 0,
and sign(b - a) the difference of both. floor(x) is even or odd on whole numbers, too.
"""

from collections.abc import Callable

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import Expression, as_expression
from lagrangia.dynamics.levels import EDGE

SIDED = (ca.OP_LT, ca.OP_LE, ca.OP_SIGN, ca.OP_EQ, ca.OP_NE)
Pair = tuple[int, int]  # the numbers of a and b, the smaller one first; of a and COUNTED, where whole numbers are asked for
COUNTED = -1


def sides_of(numbering: Numbering, op: int, numbers: list[int]) -> tuple[Pair, Pair]:
    """The conditions that the first of what an operation compares is less, and that it is more. Other pairs have their smaller
    number first."""
    zero = numbering.of_number(0.0)
    a, b = (zero, numbers[0]) if op == ca.OP_SIGN else numbers
    less, more = (numbering.of(ca.OP_LT, [numbering.of(ca.OP_SUB, [x, y]), zero]) for x, y in ((a, b), (b, a)))
    return (less, zero), (more, zero)


def is_of_one_side(pair: Pair) -> bool:
    """Whether it is one of those."""
    return pair[0] > pair[1] > COUNTED


def driven_conditions(numbering: Numbering, op: int, numbers: list[int], operands: list[Expression],
                      level: Callable[[Expression, Expression], Expression]) -> dict[Pair, Expression]:
    """Those that an operation asks for, and what is positive where they are true: `level` of a < b."""
    if op == ca.OP_FLOOR:
        return {(numbers[0], COUNTED): _level_of_even(operands[0])}
    if op == ca.OP_CEIL:
        return {(numbering.of(ca.OP_NEG, numbers), COUNTED): _level_of_even(as_expression(-operands[0]))}
    a, b = (as_expression(0.0), operands[0]) if op == ca.OP_SIGN else operands
    less, more = sides_of(numbering, op, numbers)
    found = {} if op == ca.OP_LE else {less: level(a, b)}
    return found if op == ca.OP_LT else found | {more: level(b, a)}


def _level_of_even(x: Expression) -> Expression:
    """Of an even floor(x)."""
    rest = x - 2 * ca.floor(x / 2)
    return as_expression(ca.if_else(rest < 1, rest * (1 - rest) + EDGE, (rest - 1) * (rest - 2) - EDGE))
