"""The forces by which conditions hold rates, as friction does: of all that jumps with these, they alone are shares of a jump.

From rows of forces down through sums, and products with what does not jump, all that jumps is such a force, as F sign(v) is of
-F sign(v) cos(phi); but no bare condition, as sign(v) is one. In other words it is known by what it is on either side of its
jump, there where it holds: as a torque by rows of a table, which is the slope of a loss.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, operate, symbol, symbols_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.held_switches import JUMPS, Holding

_COMPARISONS = frozenset({ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE})
_CONDITIONS = frozenset({*JUMPS, *_COMPARISONS, ca.OP_NOT, ca.OP_AND, ca.OP_OR})
_BARE = frozenset({ca.OP_ADD, ca.OP_MUL, ca.OP_NEG, ca.OP_IF_ELSE_ZERO, ca.OP_FABS, ca.OP_SQ, ca.OP_FMIN, ca.OP_FMAX})
_PRODUCTS = frozenset({ca.OP_MUL, ca.OP_DIV, ca.OP_IF_ELSE_ZERO})
_LINEAR = frozenset({ca.OP_ADD, ca.OP_NEG, ca.OP_TWICE})
_ALIKE, _LEAST = 1e-9, 1e-300
_NONE = frozenset[int]()

Jumping = dict[int, tuple[Expression, frozenset[int]]]  # by the numbers of expressions: held, and the hashes of their shares


@dataclass(frozen=True)
class Force:
    """`symbol` stands for it; `shares`: hashes of those with which it holds rates."""

    symbol: Expression
    value: ca.SX
    shares: frozenset[int]


@dataclass
class OwnForces:
    """`jumping`: all instructions of the rows of forces that jump; `found`: by their numbers, with which shares each holds rates;
    `sums`: of a row and of a share what it jumps with, what holds."""

    numbering: Numbering
    jumping: Jumping
    found: dict[int, frozenset[int]] = field(default_factory=dict)
    sums: list[tuple[int, Expression]] = field(default_factory=list)

    def note(self, number: int, slopes: Mapping[int, Expression]) -> None:
        """Of a row of forces, which holds rates with these shares, whose slopes along the row are these."""
        seen, left = set[int](), [number]
        while left:
            at = left.pop()
            held = self._shares_of(at) & slopes.keys()
            if at in seen or not held:
                continue
            seen.add(at)
            for one in self._signs(at):
                self.found[one] = self.found.get(one, _NONE) | held
            left += self._parts(at)
        for share in slopes.keys() & self._shares_of(number):
            if not slopes[share].is_zero():
                self.sums.append((share, as_expression(self._sum_of(number, share) / slopes[share])))

    def _shares_of(self, number: int) -> frozenset[int]:
        inner = self._bare_of(number)
        return self.jumping[number if number in self.jumping else inner][1] if {number, inner} & self.jumping.keys() else _NONE

    def _sum_of(self, number: int, share: int) -> Expression:
        """Of what jumps with it in a sum."""
        if share not in self._shares_of(number):
            return as_expression(0.0)
        op, *operands = self.numbering.keys[number]
        if op == ca.OP_ADD:
            return as_expression(self._sum_of(int(operands[0]), share) + self._sum_of(int(operands[1]), share))
        return as_expression(-self._sum_of(int(operands[0]), share)) if op == ca.OP_NEG else self.jumping[number][0]

    def _parts(self, number: int) -> list[int]:
        if self._is_choice(number):
            return []
        op, *operands = self.numbering.keys[number]
        inner = [int(x) for x in operands] if op in _LINEAR | _PRODUCTS else []
        jumping = [x for x in inner if self._shares_of(x)]
        return [x for x in jumping if op in _LINEAR or (len(jumping) == 1 and not self._is_bare(x))]

    def _is_choice(self, number: int) -> bool:
        """Whether it is a sum of two values of which a condition that jumps takes one: as one they are a force."""
        op, *operands = self.numbering.keys[number]
        arms = [self.numbering.keys[int(x)] for x in operands] if op == ca.OP_ADD else []
        if len(arms) < 2 or any(arm[0] != ca.OP_IF_ELSE_ZERO for arm in arms):
            return False
        a, b = (int(arm[1]) for arm in arms)
        denied = [self.numbering.of(ca.OP_NOT, [x]) for x in (b, a)]
        return any(x == y and self._shares_of(x) for x, y in zip((a, b), denied, strict=True))

    def _signs(self, number: int) -> Iterator[int]:
        """The force and its reaction: of rows, which take forces from the motion, the latter is the force."""
        op, *operands = self.numbering.keys[number]
        inner = [int(x) for x in operands] if op in _BARE else []
        yield inner[0] if op == ca.OP_NEG else self.numbering.of(ca.OP_NEG, [number])
        if not self._is_bare(number):
            yield number
        factor = next((x for x in inner if op == ca.OP_MUL and self.numbering.keys[x][0] == ca.OP_CONST), None)
        if factor is not None:
            others = [x for x in inner if x != factor]
            yield self.numbering.of(ca.OP_MUL, [self.numbering.of_number(-self.numbering.keys[factor][1]), *others])

    def _is_bare(self, number: int) -> bool:
        """Whether it is a condition, or made of such and of 0 and 1."""
        op, *operands = self.numbering.keys[number]
        if op == ca.OP_CONST:
            return abs(operands[0]) in (0, 1)
        return op in _CONDITIONS or (op in _BARE and all(self._is_bare(int(x)) for x in operands))

    def note_alike(self, jumping: Jumping, level: "Level") -> None:
        """Of other expressions that jump, and not by comparisons, those that are on both sides what holds, or its reaction: with
        any parameters, or as these are declared."""
        compared = self._compared(jumping)
        asked = {number: x for number, x in jumping.items() if number not in self.found and not self._is_bare(number)
                 and number not in compared}
        for share in {share for share, _ in self.sums} & _NONE.union(*(shares for _, shares in asked.values())):
            numbers = [number for number, (_, shares) in asked.items() if share in shares]
            sums = [x for own, x in self.sums if own == share]
            for is_declared in (False, True):
                sides = level.sides([*sums, *(asked[number][0] for number in numbers)], share, is_declared)
                for number, own in zip(numbers, sides[len(sums) :], strict=True):
                    if any(np.allclose(sign * a, b, rtol=_ALIKE, atol=0) and (a.any() or not is_declared)
                           for x in sides[: len(sums)] for a, b in zip(own, x, strict=True) for sign in (1, -1)):
                        self.found[number] = self.found.get(number, _NONE) | {share}

    def _compared(self, jumping: Jumping) -> set[int]:
        """Of those, comparisons and what is made of them."""
        found = set[int]()
        for number in jumping:
            op, *operands = self.numbering.keys[number]
            if op in _COMPARISONS or (op != ca.OP_CONST and not found.isdisjoint(self._bare_of(int(x)) for x in operands)):
                found.add(number)
        return found

    def _bare_of(self, number: int) -> int:
        """Without the sign of a difference, which no instruction makes."""
        op, *operands = self.numbering.keys[number]
        return int(operands[0]) if op == ca.OP_NEG else number

    def taken_out(self, expressions: Sequence[ca.SX]) -> tuple[list[ca.SX], list[Force]]:
        """The expressions with symbols for these; they have those of earlier ones in them."""
        taken, arms = dict[int, Force](), set[int]()

        def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
            if self._is_choice(self.numbering.of(op, numbers)):
                arms.update(numbers)

        def make(op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
            number = self.numbering.of(op, numbers)
            if number not in self.found or number in arms:
                return None
            if number not in taken:
                taken[number] = Force(symbol("force"), operate(op, operands), self.found[number])
            return taken[number].symbol

        rebuilt(expressions, self.numbering, note)
        return rebuilt(expressions, self.numbering, make), [*taken.values()]


@dataclass(frozen=True)
class Level:
    """States in which a rate is on its level: `symbols` (k,) of switches with their `values`, of v; those `at_rest` are said to
    be there. Of the parameters p what is `declared`, if known."""

    symbols: ca.SX
    values: ca.SX
    v: ca.SX
    at_rest: ca.SX
    p: ca.SX
    declared: ca.DM

    def sides(self, expressions: Sequence[ca.SX], share: int, is_declared: bool) -> NDArray[np.float64]:
        """Of each expression its values where a share is 0 and 1, in two states, at rest and not, with random parameters or as
        they are declared: (expressions, 2, 4)."""
        asked = ca.vertcat(ca.SX(0, 1), *expressions)
        k = next(k for k, x in enumerate(self.symbols.elements()) if x.__hash__() == share)
        own = symbols_in(ca.vertcat(self.v, self.at_rest, self.symbols))
        others = ca.vertcat(ca.SX(0, 1), *(x for x in ca.symvar(ca.veccat(asked, self.values)) if x.__hash__() not in own))
        known = dict(zip(map(ca.SX.__hash__, self.p.elements()), self.declared.elements(), strict=True)) if is_declared else {}
        rates = ca.Function("rates", [self.v, others], [self.values, ca.jacobian(self.values[k], self.v)])
        value = ca.Function("value", [self.v, others, self.at_rest, self.symbols], [asked])
        random, found = np.random.default_rng(1), list[list[NDArray[np.float64]]]()
        for _ in range(2):
            v, given = (random.uniform(0.1, 0.9, x.numel()) for x in (self.v, others))
            given = [known.get(x.__hash__(), y) for x, y in zip(others.elements(), given, strict=True)]
            off, along = (x.full() for x in rates(v, given))
            v = v - along.ravel() * off[k] / max(along.ravel() @ along.ravel(), _LEAST)
            switches = (rates(v, given)[0].full() > 0).astype(float)
            for switches[k] in (0, 1):
                found.append([value(v, given, at_rest, switches).full().ravel() for at_rest in (1, 0)])
        return np.array(found).T


def jumping_in(expressions: Sequence[ca.SX], holding: Holding, numbering: Numbering) -> Jumping:
    """All instructions that jump with shares."""
    found = Jumping()

    def make(op: int, numbers: list[int], operands: list[Expression]) -> Expression:
        made = holding.made(op, numbers, operands)
        if jumps := holding.jumps_of(made):
            found[numbering.of(op, numbers)] = made, jumps
        return made

    rebuilt(expressions, numbering, make)
    return found
