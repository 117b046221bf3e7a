"""What must not be 0 as forces are divided by it: parameters alone, and widths that keep roots of rates from 0.

v/w is infinite where w is 0, and v/sqrt(v^2 + w^2) jumps there as v does, which nothing of it tells: tanh of the one, and the
other, end in steps without end. What conditions on the motion may leave out is not asked for.
"""

from collections import defaultdict
from collections.abc import Iterator

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbols_in
from lagrangia.base.diagnostics import Span
from lagrangia.constraints.parameters import parameter_symbols
from lagrangia.dynamics.motion import Motion
from lagrangia.frames.kinematics import Kinematics

_FACTORS = frozenset({ca.OP_MUL, ca.OP_TWICE, ca.OP_NEG})
_NONE = frozenset[int]()


def what_divides(kinematics: Kinematics, motion: Motion) -> Iterator[tuple[ca.SX, ca.SX, Span | None]]:
    """1 where it is not 0, or nothing is divided by it; what it is, of parameters; where the division is written, if known."""
    known, numbering = kinematics.algebra.index.divisors, kinematics.algebra.index.numbering
    if not known.steady and not known.roots:
        return
    steady = {numbering.number(x): (x, place) for x, place in known.steady.values()}
    divided = _Divided(numbering, symbols_in(parameter_symbols(kinematics)), frozenset(steady), frozenset(known.roots))
    forces = (motion.unsolved or motion).h
    rebuilt([forces], numbering, divided.note)
    for number, asked in divided.asked().items():
        x, place = (known.roots[number], None) if number in known.roots else steady[number]
        yield ca.logic_or(ca.logic_not(asked), x != 0), x, place


class _Divided:
    """Notes the instructions of forces, of parameters with these symbols, and by what they divide."""

    def __init__(self, numbering: Numbering, parameters: frozenset[int], steady: frozenset[int], roots: frozenset[int]) -> None:
        self.numbering, self.parameters, self.steady = numbering, parameters, steady
        self.roots = {root: frozenset({root}) for root in roots}  # among the factors of values, by the numbers of these
        self.made = list[tuple[int, list[int], Expression | None, frozenset[int]]]()  # number, operands, condition, divisors

    def note(self, op: int, numbers: list[int], operands: list[Expression]) -> None:
        """An instruction; those that it takes come before it."""
        number = self.numbering.of(op, numbers)
        if op in _FACTORS and (found := _NONE.union(*(self.roots.get(k, _NONE) for k in numbers))):
            self.roots[number] = found
        below = numbers[-1:] if op in (ca.OP_DIV, ca.OP_INV) else []
        divisors = _NONE.union(*(self.roots.get(k, _NONE) | (self.steady & {k}) for k in below))
        self.made.append((number, numbers, operands[0] if op == ca.OP_IF_ELSE_ZERO else None, divisors))

    def asked(self) -> dict[int, Expression]:
        """Of divisors, by their numbers, whether forces ask for what is divided by them, whatever moves."""
        inner = {k for _, numbers, *_ in self.made for k in numbers}
        taken, found = (defaultdict[int, Expression](lambda: as_expression(0.0)) for _ in range(2))
        for number, numbers, condition, divisors in reversed(self.made):
            here = as_expression(1.0) if number not in inner else taken[number]
            for divisor in divisors:
                found[divisor] = as_expression(ca.logic_or(found[divisor], here))
            for k in numbers[:1] if condition is not None else numbers:
                taken[k] = as_expression(ca.logic_or(taken[k], here))
            if condition is not None and self.parameters >= symbols_in(condition):
                taken[numbers[1]] = as_expression(ca.logic_or(taken[numbers[1]], ca.logic_and(here, condition)))
        return {number: asked for number, asked in found.items() if not asked.is_zero()}
