"""What conditions in forces compare, and where it is asked whether rates rest: of all instructions, those that decide."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import field
from typing import NoReturn

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbol, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, STEPS, operations_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.dynamics.directions import Directions, components_of
from lagrangia.dynamics.driven_conditions import SIDED, Pair, driven_conditions
from lagrangia.dynamics.held_switches import (
    HALF,
    JUMPS,
    RELATIONS,
    SIGNS,
    WHOLE,
    Holding,
    ordered,
    pair_of,
    rest_asked,
    side_on_level,
)
from lagrangia.dynamics.levels import EDGE, Levels, step_of
from lagrangia.dynamics.levels import JUMPS as ALL_JUMPS
from lagrangia.dynamics.same_conditions import bends_by, multiples, without_factors

Free = Callable[[Mapping[Pair, Expression]], frozenset[Pair]]
_NONE = ca.SX(0, 1)


@dataclass
class Finding:
    """What is found in the forces: differences of what conditions compare, rates of which it is asked whether they rest, and
    pairs of those of which it is asked whether both do."""

    moving: ca.SX
    v: ca.SX
    numbering: Numbering
    stepped: frozenset[int]  # hashes of the symbols that change at events alone
    constant: frozenset[int]  # of those that do not change between events
    driven: frozenset[int]  # of those that go their way whatever moves
    found: dict[Pair, Expression] = field(default_factory=dict)
    asked: list[tuple[Pair, ...]] = field(default_factory=list)
    both: dict[tuple[Pair, Pair], bool] = field(default_factory=dict)  # whether these are the components of a direction
    equalities: dict[Pair, Expression] = field(default_factory=dict)
    equal: dict[Pair, bool] = field(default_factory=dict)  # which may be equal for a while: how these are compared
    either: set[Pair] = field(default_factory=set)  # the same, of which so far only the larger or the smaller is asked for
    squares: dict[int, Expression] = field(default_factory=dict)  # by the numbers of their roots: of lengths
    sides: dict[Pair, set[int]] = field(default_factory=dict)  # `side_on_level` of what jumps with them
    compared: dict[int, frozenset[Pair]] = field(default_factory=dict)  # by the numbers of what bends or jumps with them
    inside: set[Pair] = field(default_factory=set)  # those of both sides of equalities

    def __post_init__(self) -> None:
        self.directions, self.movers = Directions(self.numbering), symbols_in(self.moving)

    def note(self, op: int, numbers: list[int], operands: list[Expression]) -> None:
        """Of an instruction."""
        self._note_both(op, numbers)
        if op == ca.OP_SQRT and components_of(self.numbering, number := self.numbering.of(op, numbers)):
            self.squares[number] = operands[0]
        for direction in self.directions.found(op, numbers):
            if direction.length in self.squares:
                self._note_direction(self.squares[direction.length])
        if self.is_driven(op, operands):
            self.found = driven_conditions(self.numbering, op, numbers, operands, self.level) | self.found
            return
        self._note_compared(op, numbers)
        rest = rest_asked(self.numbering, op, numbers)
        if rest is not None:
            self.asked.append(rest[0])
            self.inside.update(*(self.compared.get(k, ()) for k in rest[0][0]))
            self._note_square(operands)
            if op in (ca.OP_EQ, ca.OP_NE):
                self.equalities[ordered(*numbers)] = as_expression(operands[0] - operands[1] if numbers[0] < numbers[1]
                                                                   else operands[1] - operands[0])
                self._note_equal(ordered(*numbers))
            if op in RELATIONS or len(rest[0]) > 1:  # of |a|, which is found by itself
                return
        pair = rest[0][0] if rest else pair_of(self.numbering, op, numbers)
        is_of_first = pair is not None and (op == ca.OP_LT) == (numbers[0] == pair[0])
        if pair is not None and op in (*JUMPS, *WHOLE):
            self.sides.setdefault(pair, set()).add(side_on_level(op, numbers[0] == pair[0]))
        if pair in self.equal and op in JUMPS and (op == ca.OP_SIGN or self.equal[pair] != is_of_first):
            _refuse_equal()
        if pair in self.either and op in JUMPS:
            self.either.discard(pair)
            self.found.pop(pair, None)
        if pair is None or pair in self.found or (op in WHOLE and only_jumps(operands[0], self.moving)):
            return
        g = self._difference(op, numbers, operands, pair)
        if op in (*WHOLE, ca.OP_ATAN2) and is_rate(self.v, g):  # nothing holds it there
            return
        if self._moves(g):
            self.found[pair] = g

    def _note_both(self, op: int, numbers: list[int]) -> None:
        keys = [self.numbering.keys[k] for k in numbers]
        if op == ca.OP_MUL and all(key[0] == ca.OP_EQ for key in keys):
            a, b = (ordered(int(key[1]), int(key[2])) for key in keys)
            self.both.setdefault((a, b), False)

    def _note_compared(self, op: int, numbers: list[int]) -> None:
        pair = pair_of(self.numbering, op, numbers) if op in (*RELATIONS, *SIGNS) else None
        parts = [self.compared[k] for k in numbers if k in self.compared]
        if pair is not None or parts:
            own = frozenset() if pair is None else frozenset({pair})
            self.compared[self.numbering.of(op, numbers)] = own.union(*parts)

    def _difference(self, op: int, numbers: list[int], operands: list[Expression], pair: Pair) -> Expression:
        """What changes its sign where the operation bends or jumps."""
        if op in WHOLE:
            return as_expression(ca.sin(ca.pi * operands[0]))
        a, b = (operands[0], as_expression(0.0)) if op in SIGNS or op == ca.OP_ATAN2 else operands
        difference, is_first = as_expression(a - b if numbers[0] == pair[0] else b - a), numbers[0] == pair[0]
        if op == ca.OP_ATAN2 or operations_in(self._bare(difference)).isdisjoint(ALL_JUMPS):
            return difference
        levels = Levels(self.moving, edge=EDGE)
        level = _taken_apart(levels, as_expression(a <= b if op == ca.OP_LE else a < b))
        if levels.may_rest and op == ca.OP_SIGN and self._moves(difference):
            _refuse_equal()
        if levels.may_rest and op not in JUMPS:
            self.either.add(pair)
        elif levels.may_rest:
            self.equal[pair] = (op == ca.OP_LT) == is_first
        return as_expression(-level if is_first else level)

    def level(self, a: Expression, b: Expression) -> Expression:
        """Of a < b, which nothing that answers to forces decides: on it, a is not less."""
        difference = as_expression(b - a)
        if bends_by(ALL_JUMPS, difference, self.constant | self.stepped, self.numbering):
            return _taken_apart(Levels(self.moving, edge=EDGE, may_stay=True), as_expression(a < b))
        is_step = symbols_in(difference).isdisjoint(self.driven)  # no error of it tells more than its side
        return step_of(difference, -EDGE) if is_step else as_expression(difference - EDGE)

    def is_driven(self, op: int, operands: list[Expression]) -> bool:
        """Whether nothing decides that answers to forces: it may stay on a level."""
        if op not in (*SIDED, *WHOLE) or (op in WHOLE and only_jumps(operands[0], self.moving)):
            return False
        moving = self.movers & symbols_in(ca.veccat(*operands))
        is_told = moving.isdisjoint(self.driven) and (op not in JUMPS or not moving)  # what stands between events is as it is
        return not is_told and moving <= self.driven | self.stepped

    def _bare(self, difference: Expression) -> Expression:
        """Without what goes its way whatever moves and is a factor of it: that has conditions of its own, as in `multiples`."""
        known = self.constant | self.stepped | self.driven
        return without_factors(difference, known)[0] if self._moves(difference) else difference

    def _moves(self, x: Expression) -> bool:
        return not self.movers.isdisjoint(symbols_in(x))

    def _note_equal(self, pair: Pair) -> None:
        """Of a == b: where it changes, if they are no rates and do not jump."""
        g = self.equalities[pair]
        if self.may_cross(g) and not is_rate(self.v, g):
            self.found.setdefault(pair, g)

    def may_cross(self, g: Expression) -> bool:
        """Whether g changes, and does not jump, nor bends where it is of rates: with a corner both sides may stay equal on one
        side, of which the condition that bends is to tell."""
        return self._moves(g) and operations_in(g).isdisjoint(ALL_JUMPS | CORNERS if is_rate(self.v, g) else ALL_JUMPS)

    def _note_square(self, operands: list[Expression]) -> None:
        """Of a^2 > 0, a^4 > 0 or a^2 == 0: a."""
        root = next((x for x in operands if not x.is_constant() and x.op() == ca.OP_SQ), None)
        if root is None:
            return
        while not root.is_symbolic() and root.op() == ca.OP_SQ:
            root = as_expression(root.dep(0))
        number = self.numbering.number(root)
        pair = ordered(number, self.numbering.of_number(0.0))
        if self.may_cross(root):
            self.found.setdefault(pair, root if pair[0] == number else as_expression(-root))

    def _note_direction(self, square: Expression) -> None:
        """Of a rate that is a vector: both components are to rest where it has none."""
        square = next((square.dep(k) for k in (0, 1) if square.dep(1 - k).is_constant()), square)
        components, zero = [as_expression(square.dep(k).dep(0)) for k in (0, 1)], self.numbering.of_number(0.0)
        if not all(is_rate(self.v, x) for x in components):
            return
        numbers = [self.numbering.number(x) for x in components]
        a, b = (ordered(number, zero) for number in numbers)
        for pair, number, x in zip((a, b), numbers, components, strict=True):
            self.found.setdefault(pair, x if pair[0] == number else as_expression(-x))
        self.asked += [(a,), (b,)]
        self.both[a, b] = True


def finding_in(movers: ca.SX, v: ca.SX, numbering: Numbering, known: tuple[ca.SX, ca.SX, ca.SX]) -> Finding:
    """One that has found nothing yet; `known` as of `conditions_in`."""
    return Finding(movers, v, numbering, symbols_in(known[0]), symbols_in(known[1]), symbols_in(known[2]))


def _taken_apart(levels: Levels, truth: Expression) -> Expression:
    level = levels.of(truth)
    if level is None:
        fail("L0914", "not supported yet: a force that compares what jumps in a way that is not taken apart", None,
             "compare with <, <=, > or >= in it, not with == or <>, and fewer things that jump at once")
    return as_expression(level)


def _refuse_equal() -> NoReturn:
    fail("L0914", "not supported yet: a force that tells numbers apart on both sides which may be equal for a while, as "
         "sign(floor(x)) does", None,
         "compare with numbers: if x >= 1 then 1 elseif x >= 0 then 0 else -1")


def conditions_in(forces: Sequence[ca.SX], movers: ca.SX, v: ca.SX, numbering: Numbering,
                  known: tuple[ca.SX, ca.SX, ca.SX] = (_NONE, _NONE, _NONE), free: Free | None = None
                  ) -> tuple[dict[Pair, Expression], dict[Pair, Expression], tuple[tuple[Pair, Pair], ...], dict[Pair, set[int]]]:
    """Differences of what conditions in the forces compare, of those that `movers` decide (`known`: what changes at events alone,
    what does not change between events, and what goes its way whatever moves; `free`: of conditions on rates those that nothing
    holds); symbols for the rates of which it is asked whether they rest; pairs of the latter that are asked about together; and
    `side_on_level` of all that jumps with each condition."""
    finding = finding_in(movers, v, numbering, known)
    rebuilt(forces, numbering, finding.note)
    found = finding.found
    alone = {pair: g for pair, g in finding.equalities.items() if pair not in found and finding.may_cross(g) and is_rate(v, g)}
    found |= {pair: alone[pair] for pair in free(alone)} if alone and free is not None else {}
    same = multiples(found | finding.equalities, v, known[1], numbering) if finding.equalities else {}
    found |= {pair: g for pair, g in finding.equalities.items() if pair in same and same[pair].of in found}
    rests, equal = _rests(v, found, finding.asked), _equal(v, found, finding.asked)
    inside = {pair: found[pair] for pair in finding.inside if pair in found}
    rates = {pair: g for pair, g in inside.items() if is_rate(v, g)}
    for pair in equal.union(inside.keys() - rates.keys(), free(rates) if rates and free is not None else ()):
        finding.sides.setdefault(pair, set()).add(HALF)
    found = _without_unused(forces, found, rests, numbering, equal) if rests or equal else found
    return found, rests, _cones(v, found, rests, finding.both), finding.sides


def only_jumps(x: Expression, moving: ca.SX) -> bool:
    """Whether x is constant while its parts are held: it may rest on a whole number then, and rounding tells no side of it."""
    return not operations_in(x).isdisjoint(STEPS) and ca.jacobian(x, moving).is_zero()


def is_rate(v: ca.SX, g: Expression) -> bool:
    """Whether it changes with velocities."""
    return not symbols_in(v).isdisjoint(symbols_in(g))


def _cones(v: ca.SX, found: Mapping[Pair, Expression], rests: Mapping[Pair, Expression], both: Mapping[tuple[Pair, Pair], bool]
           ) -> tuple[tuple[Pair, Pair], ...]:
    """Of what is asked about together, components of one slip: rates of their own are none, unless they stand in a direction."""
    known, moving = [cone for cone in both if all(pair in rests for pair in cone)], symbols_in(v)
    return tuple((a, b) for a, b in known
                 if both[a, b] or not moving.isdisjoint(symbols_in(found[a]) & symbols_in(found[b])))


def _rests(v: ca.SX, found: Mapping[Pair, Expression], asked: Sequence[Sequence[Pair]]) -> dict[Pair, Expression]:
    """Symbols for the rates of which it is asked whether they rest."""
    chosen = [next((pair for pair in pairs if pair in found and is_rate(v, found[pair])), None) for pairs in asked]
    return {pair: symbol(f"rest_{k}") for k, pair in enumerate(dict.fromkeys(chosen)) if pair is not None}


def _equal(v: ca.SX, found: Mapping[Pair, Expression], asked: Sequence[Sequence[Pair]]) -> frozenset[Pair]:
    """Places of which it is asked whether both sides are equal, where these do not jump."""
    known = [next((pair for pair in pairs if pair in found), None) for pairs in asked]
    places = [pair for pair in known if pair is not None and not is_rate(v, found[pair])]
    return frozenset(pair for pair in places if operations_in(found[pair]).isdisjoint(ALL_JUMPS))


def _without_unused(forces: Sequence[ca.SX], found: Mapping[Pair, Expression], rests: Mapping[Pair, Expression],
                    numbering: Numbering, equal: frozenset[Pair]) -> dict[Pair, Expression]:
    """Those that forces still have, and those with which these bend: |v|, of which nothing was asked but whether it is 0, is
    none."""
    places = {pair: symbol(f"s_{k}") for k, pair in enumerate(found)}
    left, used = list(forces), set[Pair]()
    while left:
        holding = Holding(places, frozenset(), rests, numbering, halves=equal)
        held = symbols_in(ca.veccat(*rebuilt(left, numbering, holding.made)))
        added = [pair for pair, s in places.items() if s.__hash__() in held and pair not in used]
        left = [found[pair] for pair in added]
        used.update(added)
    return {pair: g for pair, g in found.items() if pair in rests or pair in used}
