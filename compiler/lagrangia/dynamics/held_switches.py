"""Switches in place of what conditions say. Where they may be shares of a jump, forces are made linear in each of them."""

from collections.abc import Iterator, Mapping, Sequence
from functools import reduce
from types import MappingProxyType

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, apply, as_expression, operate, symbols_in
from lagrangia.dynamics.directions import Direction, Directions, Factor, is_product, length_power, sides
from lagrangia.dynamics.driven_conditions import COUNTED, SIDED, Pair, is_of_one_side, sides_of
from lagrangia.dynamics.held_roots import Roots, is_length

RELATIONS = (ca.OP_LT, ca.OP_LE, ca.OP_FMIN, ca.OP_FMAX)
JUMPS = (ca.OP_LT, ca.OP_LE, ca.OP_SIGN)
SIGNS = (ca.OP_FABS, ca.OP_SIGN)
_EQUALITIES = (ca.OP_EQ, ca.OP_NE)
_EVEN = (ca.OP_FABS, ca.OP_SQ)
_PRODUCTS = (ca.OP_MUL, ca.OP_IF_ELSE_ZERO)
_MULTIPLES = {ca.OP_TWICE: 2.0, ca.OP_NEG: -1.0}  # products with these numbers
_NOTHING = frozenset[int]()
_POINTS, _ROUNDING = 32, 1e-12
WHOLE = (ca.OP_FLOOR, ca.OP_CEIL)
Levels = Mapping[Pair, tuple[Expression, Expression]]
EITHER, ZERO, HALF, ONE, OF_WHOLE = -1, 0, 1, 2, 3  # in LagModel's at_level: LAG_LEVEL_... of standing.h


def ordered(a: int, b: int) -> Pair:
    """The same two, the smaller one first."""
    return (a, b) if a < b else (b, a)


def pair_of(numbering: Numbering, op: int, numbers: list[int]) -> Pair | None:
    """What an operation compares: a with b, or with 0, as atan2(a, x) does, whose cut lies there; or with whole numbers."""
    if op in WHOLE:
        return numbers[0], COUNTED
    if op in SIGNS or op == ca.OP_ATAN2:
        numbers = [numbers[0], numbering.of_number(0.0)]
    elif op not in RELATIONS:
        return None
    a, b = sorted(numbers)
    return (a, b) if a != b else None


def side_on_level(op: int, is_first: bool) -> int:
    """The switch of a pair that an operation with a jump asks for where both are equal, as in `at_level`; `is_first`: its first
    operand has the smaller number."""
    if op in WHOLE:
        return OF_WHOLE
    return HALF if op == ca.OP_SIGN else ONE if (op == ca.OP_LT) == is_first else ZERO


def value_on_level(side: int) -> float:
    """What a switch holds that is so on its level."""
    return 0.5 if side in (EITHER, OF_WHOLE) else 0.5 * side


def rest_asked(numbering: Numbering, op: int, numbers: list[int]) -> tuple[tuple[Pair, ...], bool] | None:
    """What a condition compares that is true, or false, just where both are equal: a == b, a <> b, |a| > 0, |a| <= 0 (without its
    factors, and as it is), a^2 > 0, |sign(a)| > 0; and whether it is true there."""
    zero = numbering.of_number(0.0)
    if op in _EQUALITIES:
        a, b = ordered(*numbers)
        inner = [k for k in numbers if zero in numbers and numbering.keys[k][0] in (*_EVEN, ca.OP_SIGN)]
        if a == b:
            return None
        bare = ordered(_without_factors(numbering, b if a == zero else a), zero) if zero in (a, b) else (a, b)
        pairs = _zeros_of(numbering, inner[0]) if inner else ((a, b), bare)  # |-x| is |x|, and -x == 0 stays as it is
        return pairs, op == ca.OP_EQ
    if op not in (ca.OP_LT, ca.OP_LE) or zero not in numbers:
        return None
    place = 1 if numbers[0] == zero else 0
    even = _without_factors(numbering, numbers[place])
    is_asked = numbering.keys[even][0] in _EVEN and _is_positive(numbering, numbers[place]) == ((op == ca.OP_LT) == (place == 1))
    return (_zeros_of(numbering, even), op == ca.OP_LE) if is_asked else None


def _is_positive(numbering: Numbering, number: int) -> bool:
    """Of a product of numbers and of what is not negative."""
    op, *operands = numbering.keys[number]
    if op in (ca.OP_MUL, ca.OP_TWICE):
        return sum(not _is_positive(numbering, int(x)) for x in operands) % 2 == 0
    return op != ca.OP_NEG and not (op == ca.OP_CONST and operands[0] < 0)


def _zeros_of(numbering: Numbering, number: int) -> tuple[Pair, ...]:
    """Of |a|, a^2, a^4 or sign(a): a with 0, without its factors, and as it is."""
    inner, zero = int(numbering.keys[number][1]), numbering.of_number(0.0)
    while numbering.keys[(even := _without_factors(numbering, inner))][0] in _EVEN:
        inner = int(numbering.keys[even][1])
    return ordered(_without_factors(numbering, inner), zero), ordered(inner, zero)


def _without_factors(numbering: Numbering, number: int) -> int:
    """The value that is 0 where this one is: of -2 x or of sign(x), x."""
    op, *operands = numbering.keys[number]
    inner = [int(x) for x in operands] if op in (ca.OP_NEG, ca.OP_TWICE, ca.OP_MUL, ca.OP_SIGN) else []
    left = [x for x in inner if numbering.keys[x][0] != ca.OP_CONST]
    return _without_factors(numbering, left[0]) if len(left) == 1 else number


def _are_equal(a: ca.SX, b: ca.SX) -> bool:
    """Whether they are so whatever they depend on, but for rounding; what switches hold is 0 or 1."""
    sides = ca.Function("sides", [ca.vertcat(ca.SX(0, 1), *ca.symvar(ca.vertcat(a, b)))], [a, b])
    random, n = np.random.default_rng(1), sides.numel_in(0)
    points = [np.where(random.random(n) < 0.5, random.integers(0, 2, n), random.uniform(-2.0, 2.0, n)) for _ in range(_POINTS)]
    values = np.array([sides(point) for point in points], float).reshape(-1, 2)
    values = values[np.isfinite(values).all(axis=1)]
    return bool(values.size > 0 and np.allclose(values[:, 0], values[:, 1], rtol=_ROUNDING, atol=0))


class Holding:
    """`places`: the symbols of switches; `shares`: the hashes of those that may be between 0 and 1; `rests`: symbols that are 1
    where both of a pair are held equal, and 0 elsewhere; `nothing`: whether both are 0, of those whose factor may be; `halves`:
    those that are no shares and 0.5 where both are equal, or x is whole; `levels`: of such, both sides, what moves first;
    `movers`: hashes of what changes between events, where conditions of what is on these levels alone are told by them."""

    def __init__(self, places: Mapping[Pair, Expression], shares: frozenset[int], rests: Mapping[Pair, Expression],
                 numbering: Numbering, nothing: Mapping[Pair, Expression] = MappingProxyType({}),
                 halves: frozenset[Pair] = frozenset(), levels: Levels = MappingProxyType({}), movers: frozenset[int] = _NOTHING
                 ) -> None:
        self.places, self.shares, self.rests, self.numbering, self.nothing = places, shares, rests, numbering, nothing
        self.halves, self.movers = halves, movers
        self.symbols = {s.__hash__(): s for s in places.values() if s.is_symbolic()}
        self.has_sides = any(map(is_of_one_side, places))
        self.jumps = dict[int, tuple[Expression, frozenset[int]]]()  # of expressions by their hashes: the shares they jump with
        self.products = dict[int, tuple[int, list[int], list[Expression]]]()  # by their numbers
        self.levels = {**levels}  # both sides of halves, what moves first
        self.directions = Directions(numbering)
        rates = frozenset(k for pair, s in places.items() if self._shares_in(s) for k in pair)
        self.roots = Roots(numbering, rates - {numbering.of_number(0.0)}, self._combined)

    def made(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression:
        """An instruction with switches for its conditions."""
        if (rests := self._rests(op, numbers, operands)) is not None:
            return rests
        if self.has_sides and op in SIDED and (told := self._told_apart(op, numbers)) is not None:
            return told
        if op == ca.OP_CEIL and (opposite := (self.numbering.of(ca.OP_NEG, numbers), COUNTED)) in self.places:
            return as_expression(-self._whole(ca.OP_FLOOR, as_expression(-operands[0]), self.places[opposite]))
        pair = pair_of(self.numbering, op, numbers)
        if pair is not None and pair in self.places:
            if pair in self.halves and op not in WHOLE:
                a, b = operands if op in RELATIONS else (operands[0], as_expression(0.0))
                self.levels[pair] = (b, a) if a.is_constant() else (a, b)
            value = self._switched(op, numbers, operands, pair)
            return self._noted_length(op, numbers, self._told_on_levels(op, operands, pair, value), pair)
        if (root := self.roots.made(op, numbers, operands)) is not None:
            return root
        self.roots.note(op, numbers, operands)
        directed = self._directed(op, numbers, operands)
        return self._combined(op, operands) if directed is None else directed

    def _on_levels(self, operands: list[Expression], asked: Sequence[Pair]) -> list[Expression] | None:
        """With what bends or jumps in them on its level just there, not but for rounding: max(y, 0) == 0. None: nothing does, but
        what is asked."""
        own, places = symbols_in(ca.vertcat(*operands)), dict[int, tuple[Expression, list[tuple[Expression, Expression]]]]()
        for pair, (moving, level) in self.levels.items():
            s = self.places[pair]
            if pair not in asked and not own.isdisjoint(symbols_in(s) & self.symbols.keys()):
                places.setdefault(self.numbering.number(moving), (moving, []))[1].append((as_expression(s * (1 - s)), level))
        if not places or not own.isdisjoint(self.shares):
            return None

        def on_levels(number: int, moving: Expression) -> Expression:
            for is_half, level in places[number][1]:
                moving = as_expression(ca.if_else(is_half, level, moving))
            return moving

        def make(op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
            number = self.numbering.of(op, numbers)
            return on_levels(number, operate(op, operands)) if number in places else None

        made = rebuilt(operands, self.numbering, make)
        bare = [(moving, on_levels(number, moving)) for number, (moving, _) in places.items() if moving.is_symbolic()]
        made = ca.substitute(made, *([ca.vertcat(*column)] for column in zip(*bare, strict=True))) if bare else made
        return list(map(as_expression, made))

    def _told_on_levels(self, op: int, operands: list[Expression], pair: Pair, value: Expression) -> Expression:
        """A condition, as max(v, 0) > 0, that is told where all that moves in it is on its level, or both sides are equal there,
        and its value elsewhere."""
        if not self.movers or op not in JUMPS or pair in self.halves:
            return value
        own = symbols_in(ca.vertcat(*operands, self.places[pair]))
        if not own.isdisjoint(self.shares):
            return value
        moving = {pair: x for pair, (x, _) in self.levels.items() if not own.isdisjoint(symbols_in(x))}
        places = {self.numbering.number(x): pair for pair, x in moving.items()}
        bare = {self.numbering.number(x): x for x in moving.values() if x.is_symbolic()}
        used = set(bare)

        def make(op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
            number = self.numbering.of(op, numbers)
            used.update({number} & places.keys())
            return self.levels[places[number]][1] if number in places else None

        symbols, levels = (ca.vertcat(ca.SX(0, 1), *x) for x in (bare.values(), (self.levels[places[k]][1] for k in bare)))
        made = ca.substitute(rebuilt(operands, self.numbering, make), [symbols], [levels])
        if not used:
            return value
        told = operate(op, list(map(as_expression, made)))
        if not self.movers.isdisjoint(symbols_in(ca.vertcat(*made))):
            if not _are_equal(*made, *[ca.SX(0)] * (2 - len(made))):
                return value
            told = as_expression(float(op == ca.OP_LE))
        sides = [self.places[places[k]] for k in used]
        is_on_level = reduce(ca.logic_and, (s * (1 - s) for s in sides))
        return as_expression(ca.if_else(is_on_level, told, value))

    def _told_apart(self, op: int, numbers: list[int]) -> Expression | None:
        """By switches of both sides, of what may be equal for a while."""
        less, more = (self.places.get(pair) for pair in sides_of(self.numbering, op, numbers))
        if op == ca.OP_LT:
            return less
        if op == ca.OP_LE:
            return None if more is None else as_expression(1.0 - more)
        if less is None or more is None:
            return None
        return as_expression(less - more if op == ca.OP_SIGN else less + more if op == ca.OP_NE else 1.0 - less - more)

    def _noted_length(self, op: int, numbers: list[int], value: Expression, pair: Pair) -> Expression:
        if is_length(self.numbering, op, numbers):
            clipped = self._noted(apply(ca.OP_FMAX, value, 0.0), self.jumps_of(value))
            self.roots.note_length(self.numbering.of(op, numbers), clipped, bool(self._shares_in(self.places[pair])))
        return value

    def _rests(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        asked = rest_asked(self.numbering, op, numbers) if self.rests or self.halves else None
        if asked is None:
            return None
        rest = next((self.rests[pair] for pair in asked[0] if pair in self.rests), None)
        if rest is not None:
            return rest if asked[1] else as_expression(1.0 - rest)
        s = next((self.places[pair] for pair in asked[0] if pair in self.halves), None)
        equal = None if s is None else as_expression(4 * s * (1 - s))  # a half where both are equal
        on_levels = self._on_levels(operands, asked[0])
        bending = _NOTHING if s is None else (symbols_in(ca.vertcat(*operands)) & self.symbols.keys()) - symbols_in(s)
        if on_levels is None and not bending:
            return equal if equal is None or asked[1] else as_expression(1.0 - equal)
        told = self._combined(op, on_levels or operands)  # with a corner both may be equal on one side of it
        if equal is None:
            return told
        return as_expression(ca.fmax(equal, told) if asked[1] else ca.fmin(1.0 - equal, told))

    def _switched(self, op: int, numbers: list[int], operands: list[Expression], pair: Pair) -> Expression:
        is_positive = self.places[pair]  # a > b, where a has the smaller number
        if op in WHOLE:
            whole = self._whole(op, operands[0], is_positive)
            here = operate(ca.OP_FLOOR, [as_expression(operands[0] + 0.5)])  # a whole number but for rounding
            return as_expression(ca.if_else(is_positive * (1 - is_positive), here, whole)) if pair in self.halves else whole
        if op not in JUMPS:
            is_positive = self._bounded(is_positive)
        if op == ca.OP_SIGN:
            return self._sign(pair, numbers[0])
        if op == ca.OP_ATAN2:
            return self._angle(op, operands, is_positive if numbers[0] == pair[0] else as_expression(1.0 - is_positive))
        if op == ca.OP_FABS:
            return as_expression((2 * is_positive - 1 if numbers[0] == pair[0] else 1 - 2 * is_positive) * operands[0])
        is_half = pair in self.halves
        opposite = as_expression(1.0 - is_positive) if is_half else self._opposite(is_positive)
        is_less = is_positive if numbers[1] == pair[0] else opposite
        if pair in self.nothing:
            is_less = as_expression(ca.if_else(self.nothing[pair], 0.0 if op == ca.OP_LT else 1.0, is_less))
        if op in JUMPS and is_half:
            return as_expression(is_less * (2 * is_less - 1) if op == ca.OP_LT else is_less * (3 - 2 * is_less))
        if op in JUMPS:
            return self._noted(is_less, self._shares_in(is_less))
        smaller, larger = operands if op == ca.OP_FMIN else operands[::-1]
        return as_expression(self._chosen(is_less, smaller) + self._chosen(self._opposite(is_less), larger))

    def _sign(self, pair: Pair, number: int) -> Expression:
        """Of the value with this number."""
        is_positive = self.places[pair]
        sign = as_expression(2 * is_positive - 1 if number == pair[0] else 1 - 2 * is_positive)
        return self._noted(sign, self._shares_in(sign))

    def _whole(self, op: int, x: Expression, is_even: Expression) -> Expression:
        """floor(x) or ceil(x) where the former is even, or odd: it stays so for half of 1 beyond both ends."""
        below = 2 * operate(ca.OP_FLOOR, [as_expression((x + is_even - 0.5) / 2)]) + 1 - is_even
        return as_expression(below if op == ca.OP_FLOOR else below + 1)

    def _angle(self, op: int, operands: list[Expression], is_above: Expression) -> Expression:
        """atan2(y, x) by a quarter turn that takes its cut to the other side than that of y: it goes on as y passes 0."""
        side = as_expression(2 * is_above - 1)
        y, x = operands
        return as_expression(side * (ca.pi / 2) + operate(op, [as_expression(-side * x), as_expression(side * y)]))

    def _directed(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        """A product or quotient in which a rate stands above and its length below; of others, it keeps the operands."""
        found = (self._direction(list(self._factors(op, numbers, operands)), x) for x in self.directions.found(op, numbers))
        directed = next((x for x in found if x is not None), None)
        if directed is None and is_product(op):
            self.products[self.numbering.of(op, numbers)] = op, numbers, operands
        return directed

    def _direction(self, factors: list[tuple[Factor, Expression]], found: Direction) -> Expression | None:
        """A component of v/|v|, which has none at rest, times all else."""
        values = dict(factors)
        length = (found.length, found.square is None)
        if length not in values and length_power(self.numbering, found.length) is not None:
            length = (found.length, False)
        if (found.above, False) not in values or length not in values:
            return None
        share = self._share(found, values[found.above, False], values[length], length[1])
        if share is None:
            return None
        left = [(found.above, False), length, *([] if found.square is None else [(found.square, True)])]
        above, below = as_expression(1.0), as_expression(1.0)
        for factor, value in factors:
            if factor in left:
                left.remove(factor)
            elif factor[1]:
                below = self._combined(ca.OP_MUL, [below, value])
            else:
                above = self._combined(ca.OP_MUL, [above, value])
        return self._combined(ca.OP_MUL, [self._combined(ca.OP_DIV, [above, below]), share])

    def _share(self, found: Direction, component: Expression, length: Expression, is_below: bool) -> Expression | None:
        """At rest a force holds v with components of its own, as signs."""
        zero = self.numbering.of_number(0.0)
        pairs = [ordered(x, zero) for x in found.components]
        if any(pair not in (self.rests if len(pairs) > 1 else self.places) for pair in pairs):
            return None
        sign = self._sign(ordered(found.component, zero), found.component)
        held = self._combined(ca.OP_MUL, [as_expression(1 / found.ratio), sign])
        if len(pairs) == 1:
            power = self.roots.times_length(found.length, is_below)
            return held if power is None else self._combined(ca.OP_MUL, [held, power])
        both = as_expression(self.rests[pairs[0]] * self.rests[pairs[1]])
        held = self._combined(ca.OP_MUL, [both, held])
        moves = operate(ca.OP_DIV, [component, length])
        return self._noted(as_expression(held + operate(ca.OP_IF_ELSE_ZERO, [operate(ca.OP_NOT, [both]), moves])),
                           self.jumps_of(held))

    def _factors(self, op: int, numbers: list[int], operands: list[Expression], is_below: bool = False
                 ) -> Iterator[tuple[Factor, Expression]]:
        """Of a product or quotient, with their values."""
        if op in _MULTIPLES:
            number = self.numbering.of_number(_MULTIPLES[op])
            yield (number, is_below), as_expression(_MULTIPLES[op])
        for number, value, side in zip(numbers, operands, sides(op, is_below), strict=True):
            if number in self.products:
                yield from self._factors(*self.products[number], side)
            else:
                yield (number, side), value

    def _combined(self, op: int, operands: Sequence[Expression]) -> Expression:
        """Products of what jumps with one share are linear in it, as its square is where it is 0 or 1."""
        found = [self.jumps_of(x) for x in operands]
        common = found[0] & found[1] if op in _PRODUCTS else found[0] if op == ca.OP_SQ else _NOTHING
        if not common:
            return self._noted(self._plain(op, operands), _NOTHING.union(*found))
        share = self.symbols[min(common)]
        whole, none = (self._combined(op, [self._with(x, share, value) for x in operands]) for value in (1, 0))
        return self._noted(as_expression(none + share * (whole - none)), _NOTHING.union(*found))

    def _with(self, x: Expression, share: Expression, value: int) -> Expression:
        rest = self.jumps_of(x) - {share.__hash__()}
        return self._noted(as_expression(ca.substitute(x, share, value)), rest)

    def _plain(self, op: int, operands: Sequence[Expression]) -> Expression:
        if op == ca.OP_NOT:
            return self._opposite(operands[0])
        return self._chosen(*operands) if op == ca.OP_IF_ELSE_ZERO else operate(op, operands)

    def _opposite(self, condition: Expression) -> Expression:
        return as_expression(1.0 - condition) if self._shares_in(condition) else operate(ca.OP_NOT, [condition])

    def _chosen(self, condition: Expression, value: Expression) -> Expression:
        """A share of nothing is nothing, even of what has no value there."""
        return operate(ca.OP_IF_ELSE_ZERO, [condition, condition * value if self._shares_in(condition) else value])

    def _bounded(self, condition: Expression) -> Expression:
        """Of what does not jump: no part of it is more than the whole, or less than nothing."""
        if not self._shares_in(condition):
            return condition
        return as_expression(apply(ca.OP_FMIN, apply(ca.OP_FMAX, condition, 0.0), 1.0))

    def _shares_in(self, x: Expression) -> frozenset[int]:
        if x.is_symbolic():
            return frozenset({x.__hash__()}) & self.shares
        return self.shares & symbols_in(x) if self.shares else _NOTHING

    def jumps_of(self, x: Expression) -> frozenset[int]:
        """The shares with which it jumps."""
        return self.jumps[x.__hash__()][1] if x.__hash__() in self.jumps else _NOTHING

    def _noted(self, x: Expression, jumps: frozenset[int]) -> Expression:
        if jumps and (left := jumps & symbols_in(x)):
            self.jumps[x.__hash__()] = x, left
        return x
