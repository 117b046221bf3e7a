"""Directions in products: v/|v| has none at rest, however a force is written: v (c/|v|), c/|v| v, v/(c |v|), v |v|/|v|^2; and
v/|v|^a, which is 0/0 there, or v |v|^-a, is sign(v) |v|^(1-a).

Of a product or quotient its factors are those above and below; where a rate is above and its length below, both make the
direction, and what is left are its factors.
"""

from collections.abc import Iterator
from dataclasses import field

import casadi as ca

from lagrangia.algebra.numbering import Numbering
from lagrangia.base.records import dataclass

_PRODUCTS = frozenset({ca.OP_MUL, ca.OP_DIV, ca.OP_INV, ca.OP_NEG, ca.OP_TWICE})
_POWERS = frozenset({ca.OP_SQRT, ca.OP_POW, ca.OP_CONSTPOW})
Factor = tuple[int, bool]  # its number, and whether it is below


@dataclass(frozen=True)
class Direction:
    """c x/|v|: the numbers of the components of v, of x, of the length (or its power), and of that which is x times `ratio`."""

    components: tuple[int, ...]
    above: int
    length: int
    component: int
    ratio: float
    square: int | None  # where the length stands above, and its square below


@dataclass
class Directions:
    """In what has been numbered."""

    numbering: Numbering
    lengths: dict[int, frozenset[Factor]] = field(default_factory=dict)  # by number: lengths, or their squares, among its factors

    def found(self, op: int, numbers: list[int]) -> Iterator[Direction]:
        """At the instruction where a component and its length meet: in c x/|c x| those of c and of x."""
        if op not in _PRODUCTS:
            return
        below = [number for number, is_below in self._lengths_in(op, numbers, False) if is_below]
        above = [number for number, is_below in self._factors(op, numbers) if not is_below] if below else []
        for length in below:
            direction = self._direction(length, above)
            if direction is not None and not any(self._meet(direction, number) for number in numbers):
                yield direction

    def _direction(self, below: int, above: list[int]) -> Direction | None:
        square = below if self.numbering.keys[below][0] == ca.OP_ADD else None
        components = _components_below(self.numbering, below)
        lengths = [n for n in above if self.numbering.keys[n][0] == ca.OP_SQRT and components_of(self.numbering, n) == components]
        if square is not None and not lengths:
            return None
        found = [(x, c, ratio) for c in components for bare, factor in [self._bare(c)]
                 for x, ratio in ((c, 1.0), (bare, factor)) if x in above]
        if len({c for _, c, _ in found}) != 1:
            return None
        x, component, ratio = found[0]
        return Direction(components, x, below if square is None else lengths[0], component, ratio, square)

    def _meet(self, direction: Direction, number: int) -> bool:
        """In this operand already."""
        op, *operands = self.numbering.keys[number]
        if op not in _PRODUCTS:
            return False
        factors = set(self._factors(int(op), [int(x) for x in operands]))
        below = direction.length if direction.square is None else direction.square
        found = {(below, True)} if length_power(self.numbering, below) is None else {(below, True), (below, False)}
        return (direction.above, False) in factors and not factors.isdisjoint(found)

    def _bare(self, number: int) -> tuple[int, float]:
        """A component without the numbers that it is multiplied by, and these."""
        op, *operands = self.numbering.keys[number]
        if op in (ca.OP_NEG, ca.OP_TWICE):
            inner, ratio = self._bare(int(operands[0]))
            return inner, ratio * (-1.0 if op == ca.OP_NEG else 2.0)
        if op == ca.OP_DIV and self.numbering.keys[int(operands[1])][0] == ca.OP_CONST:
            inner, ratio = self._bare(int(operands[0]))
            return inner, ratio / float(self.numbering.keys[int(operands[1])][1])
        constants = [int(x) for x in operands if op == ca.OP_MUL and self.numbering.keys[int(x)][0] == ca.OP_CONST]
        if len(constants) != 1:
            return number, 1.0
        inner, ratio = self._bare(next(int(x) for x in operands if x != constants[0]))
        return inner, ratio * float(self.numbering.keys[constants[0]][1])

    def _factors(self, op: int, numbers: list[int], is_below: bool = False) -> Iterator[Factor]:
        for number, side in zip(numbers, sides(op, is_below), strict=True):
            inner, *operands = self.numbering.keys[number]
            if inner in _PRODUCTS:
                yield from self._factors(int(inner), [int(x) for x in operands], side)
            else:
                yield number, side

    def _lengths_in(self, op: int, numbers: list[int], is_below: bool) -> frozenset[Factor]:
        """The lengths among the factors, and the squares of such."""
        found = frozenset[Factor]()
        for number, side in zip(numbers, sides(op, is_below), strict=True):
            found |= frozenset((n, is_other != side) for n, is_other in self._lengths_of(number))
        return found

    def _lengths_of(self, number: int) -> frozenset[Factor]:
        if number not in self.lengths:
            op, *operands = self.numbering.keys[number]
            if op in _PRODUCTS:
                self.lengths[number] = self._lengths_in(int(op), [int(x) for x in operands], False)
            elif power := length_power(self.numbering, number):
                self.lengths[number] = frozenset((number, sign < 0) for sign in power)
            else:
                self.lengths[number] = frozenset({(number, False)} if components_of(self.numbering, number) else ())
        return self.lengths[number]


def sides(op: int, is_below: bool) -> tuple[bool, ...]:
    """Of the operands of a product or quotient that is itself above or below: whether they are below."""
    if op == ca.OP_DIV:
        return is_below, not is_below
    return (not is_below,) if op == ca.OP_INV else (is_below,) * (2 if op == ca.OP_MUL else 1)


def is_product(op: int) -> bool:
    """Or a quotient, or the opposite, or twice something."""
    return op in _PRODUCTS


def length_power(numbering: Numbering, number: int) -> tuple[int, ...] | None:
    """Of |x|^a with 0 < |a| < 1: the sign of a; both where a is no number."""
    op, *operands = numbering.keys[number]
    if op not in _POWERS or numbering.keys[int(operands[0])][0] != ca.OP_FABS:
        return None
    key = (ca.OP_CONST, 0.5) if op == ca.OP_SQRT else numbering.keys[int(operands[1])]
    if key[0] != ca.OP_CONST:
        return 1, -1
    return (1 if key[1] > 0 else -1,) if 0 < abs(key[1]) < 1 else None


def _components_below(numbering: Numbering, number: int) -> tuple[int, ...]:
    """Of a length, its square, or of |x|^a."""
    is_power = length_power(numbering, number) is not None
    return components_of(numbering, int(numbering.keys[number][1]) if is_power else number)


def components_of(numbering: Numbering, number: int) -> tuple[int, ...]:
    """Of |x|, sqrt(x^2 + y^2) and of x^2 + y^2: the numbers of x and y."""
    op, *operands = numbering.keys[number]
    if op == ca.OP_FABS:
        return (int(operands[0]),)
    outer, *squares = numbering.keys[int(operands[0])] if op == ca.OP_SQRT else (op, *operands)
    constants = [k for k in squares if outer == ca.OP_ADD and numbering.keys[int(k)][0] == ca.OP_CONST]
    if constants:  # that keeps slopes finite
        outer, *squares = numbering.keys[int(next(k for k in squares if k not in constants))]
    if outer != ca.OP_ADD:
        return ()
    inner = [numbering.keys[int(k)] for k in squares]
    return tuple(int(key[1]) for key in inner) if all(key[0] == ca.OP_SQ for key in inner) else ()
