"""Motion -> switches: what a condition on the state decides, which a step of the run time holds.

Forces bend or jump where such a condition changes: at a stop, at a point of a table along a coordinate, where a rate turns. No
step is short enough to be smooth there. So a step takes what the conditions say at its beginning, and where one of them is found
changed at its end the run goes back to the place: the equations are smooth in every step, and have Taylor series.

The switch s of a < b, of max(a, b), abs(a - b) and sign(a - b) is 1 where g = a - b > 0, and 0 where g < 0; that of
atan2(a, x), which jumps at its cut, by the sign of a; that of floor(a), by that of sin(pi a). Where forces that jump with a
velocity hold it at their jump (dry friction that sticks), s is the share in between that keeps g at 0: forces are as linear in
s as they can be made (A.F. Filippov, Differential equations with discontinuous righthand sides, 1988). Conditions that are true
only where a velocity is 0 (v == 0, not abs(v) > 0) are a number of their own, 1 just while it is held there: friction that holds
more than it rubs.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from typing import NoReturn

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbol, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, STEPS, operations_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.dynamics.directions import Directions, components_of
from lagrangia.dynamics.driven_conditions import SIDED, Pair, driven_conditions, is_of_one_side
from lagrangia.dynamics.held_switches import (
    JUMPS,
    RELATIONS,
    SIGNS,
    WHOLE,
    Holding,
    ordered,
    pair_of,
    rest_asked,
)
from lagrangia.dynamics.levels import EDGE, Levels
from lagrangia.dynamics.levels import JUMPS as ALL_JUMPS
from lagrangia.dynamics.motion import SMOOTH, Motion
from lagrangia.dynamics.same_conditions import Same, bends_by, match, multiples

_BENT = CORNERS | {ca.OP_ATAN2}
_NONE = ca.SX(0, 1)
_ROOTED = frozenset({ca.OP_SQRT, ca.OP_FLOOR, ca.OP_CEIL})


@dataclass(frozen=True)
class Switches:
    """`symbols` (k,) for the switches; `values` g (k,) of t, q, v, u, d, p, and `rates` along a motion with accelerations,
    where inputs change by `slopes` (n_u,)."""

    symbols: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    values: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    rates: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    slopes: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    places: "dict[Pair, Expression]" = field(default_factory=dict)  # the symbol of each
    shares: frozenset[int] = frozenset()  # hashes of the symbols that may be between 0 and 1
    rests: "dict[Pair, Expression]" = field(default_factory=dict)  # symbols that say whether the two are held equal
    cones: tuple[tuple[Pair, Pair], ...] = ()  # pairs of `rests` that are asked about together, as both components of a slip
    numbering: Numbering = field(default_factory=Numbering)
    aliases: "dict[Pair, Expression]" = field(default_factory=dict)  # the same conditions in other shapes: s or 1 - s
    rest_aliases: "dict[Pair, Expression]" = field(default_factory=dict)
    lengths: int = 0  # the first so many: the signs of what lengths are, which ordinary motion does not change
    nothing: "dict[Pair, Expression]" = field(default_factory=dict)  # of aliases, whether both sides are 0
    rubs: tuple[int, ...] = ()  # of friction that presses with the force of contacts: the switch of its slip, the event, and
    # whether the switch is in no other force
    edge: ca.SX = field(default_factory=lambda: ca.SX(0, 1))  # (0 or 1,): what conditions of events that may be held have beside

    def hold(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """The same with the symbols in place of what they stand for."""
        if not self.places:
            return list(expressions)
        holding = Holding(self.places | self.aliases, self.shares, self.rests | self.rest_aliases, self.numbering, self.nothing)
        return rebuilt(expressions, self.numbering, holding.made)

    def rates_of(self, x: ca.SX, motion: Motion) -> ca.SX:
        """Along the motion, while all is held."""
        return _rates_of(x, motion, self.slopes)

    @property
    def rest_symbols(self) -> ca.SX:
        """The symbols of what is said of rest, as a column."""
        return ca.vertcat(ca.SX(0, 1), *self.rests.values())

    @property
    def patterns(self) -> dict[str, tuple[int, ...]]:
        """Lists of places of LagModel: `rests`, the switch of each of them."""
        order = {pair: k for k, pair in enumerate(self.places)}
        cones = [order[pair] for cone in self.cones for pair in cone]
        return {"rubs": self.rubs, "rests": tuple(order[pair] for pair in self.rests), "cones": tuple(cones)}


def bends(motion: Motion) -> bool:
    """Whether its forces bend or jump somewhere."""
    return not _BENT.isdisjoint(motion.operations)


def _bent_rows(motion: Motion) -> list[ca.SX]:
    """Rates of constraints that bend or jump somewhere, as at the corners of a cam."""
    if motion.constrained is None or motion.asked <= SMOOTH:
        return []
    rows = motion.constrained.rows
    return [x for x in (rows.rate, rows.bias) if not _BENT.isdisjoint(operations_in(x))]


def counts_whole_numbers(motion: Motion) -> bool:
    """Whether its forces may jump where floor(x) changes: by which a step has passed two, nothing at its ends tells."""
    return not motion.operations.isdisjoint(WHOLE)


def corners_remain(motion: Motion) -> bool:
    """Whether they do where no length is 0."""
    if not motion.lengths or not bends(motion):
        return bends(motion) or bool(_bent_rows(motion))
    numbering = Numbering()
    signs = {sign_of(x, numbering): symbol("s") for x in motion.lengths}
    (h,) = rebuilt([motion.h], numbering, Holding(signs, frozenset(), {}, numbering).made)
    return not _BENT.isdisjoint(operations_in(h))


def sign_of(x: ca.SX, numbering: Numbering) -> Pair:
    """The condition whether x is positive."""
    first, second = sorted((numbering.number(x), numbering.of_number(0.0)))
    return first, second


def _sided(x: ca.SX, numbering: Numbering) -> tuple[Pair, Expression]:
    """The same, and what is positive where the first of the pair is the larger: -x where 0 has the smaller number."""
    pair = sign_of(x, numbering)
    return pair, as_expression(x if pair[0] == numbering.number(x) else -x)


def find_switches(motion: Motion, late: ca.SX | None = None, bends: Sequence[ca.SX] = ()) -> Switches:
    """Those of the conditions in the forces, and in what acts `late`, that the state decides, or time in a way that is not known
    beforehand, and `bends` of inputs;
    behind them those of events, the gaps of those that are contacts (or rates that go one way), and the rates of
    these, which are kept at 0 where something rests."""
    numbering, events = Numbering(), motion.impacts.conditions
    others = _bent_rows(motion) + ([late] if late is not None and late.numel() else [])
    may_have = not motion.operations.union(*map(operations_in, others)).isdisjoint(_BENT | {ca.OP_SQRT})
    if not may_have and not events.numel() and not bends:
        return Switches()
    signs = {sign_of(x, numbering) for x in motion.lengths}
    known = motion.unsolved or motion
    laws, reactions = ([known.felt.laws], known.felt.reactions) if known.felt else ([], ca.SX(0, 1))
    movers = ca.vertcat(motion.t, motion.q, motion.v, motion.u, reactions)
    found, rests, cones = conditions_in([known.h, *laws, *others], movers, motion.v, numbering, _given(known))
    same = multiples(found, motion.v, ca.vertcat(_between_events(known), known.stepped), numbering)
    found, rests, cones = _merged(found, rests, cones, same)
    found = dict(_sided(g, numbering) for g in bends) | found
    found = found | {pair: g for pair, g in _kinks_of(motion, numbering).items() if pair not in found}
    same |= _other_shapes(known, found, same, movers, numbering)
    if not found and not events.numel():
        return Switches()
    found = {pair: found[pair] for pair in sorted(found, key=lambda pair: pair not in signs)}
    slopes, places = ca.SX.sym("du", motion.u.numel()), {pair: symbol(f"s_{k}") for k, pair in enumerate(found)}
    shares = frozenset(places[pair].__hash__() for pair, g in found.items() if _is_rate(motion.v, g))
    edge = motion.impacts.edge if shares or motion.impacts.may_hold else _NONE
    values = ca.vertcat(ca.SX(0, 1), *found.values(), *_values_of_events(motion, slopes, edge))
    symbols = ca.vertcat(ca.SX(0, 1), *places.values(), ca.SX.sym("event", 2 * events.numel()), motion.impacts.forces)
    lengths = sum(pair in signs for pair in found)
    rates = _rates_of(values, motion, slopes)
    switches = Switches(symbols, values, rates, slopes, places, shares, rests, cones, numbering, lengths=lengths)
    switches = _with_aliases(replace(switches, edge=edge), same, ca.veccat(known.h, *laws))
    return replace(switches, rubs=_find_rubs(motion, switches)) if motion.impacts.pressing else switches


def _with_aliases(switches: Switches, same: Same, forces: ca.SX) -> Switches:
    """With what stands for conditions in other shapes; what is said of rates that rest is left out where it is moot."""
    places, rests, numbering = switches.places, switches.rests, switches.numbering
    aliases = {pair: x.switch(places[x.of]) for pair, x in same.items()}
    nothing = {pair: x.is_nothing for pair, x in same.items() if x.may_vanish}
    held = {pair: rests[x.of] for pair, x in same.items() if x.of in rests}
    holding = Holding(places | aliases, switches.shares, rests | held, numbering, nothing)
    moot = _moot_rests(forces, holding, switches.cones)
    held = {pair: same[pair].rests(moot.get(x, x)) for pair, x in held.items()}
    return replace(switches, rests={pair: x for pair, x in rests.items() if x not in moot}, aliases=aliases, nothing=nothing,
                   rest_aliases=held | {pair: moot[x] for pair, x in rests.items() if x in moot})


def _values_of_events(motion: Motion, slopes: ca.SX, edge: ca.SX) -> list[ca.SX]:
    """Their conditions, the gaps, and the rates of these."""
    impacts, paces = motion.impacts, _rates_of(motion.impacts.arms, motion, slopes)
    resting = [impacts.gaps[k] if impacts.one_way[k] else paces[k] for k in range(impacts.gaps.numel())]
    return [impacts.edged if edge.numel() else impacts.conditions, impacts.gaps, *resting]


def _merged(found: dict[Pair, Expression], rests: dict[Pair, Expression], cones: tuple[tuple[Pair, Pair], ...], same: Same
            ) -> tuple[dict[Pair, Expression], dict[Pair, Expression], tuple[tuple[Pair, Pair], ...]]:
    """Without those that are `same` as others, which stand for them."""
    one = {pair: same[pair].of if pair in same else pair for pair in found}
    found = {x.of: x.bare for x in same.values()} | found
    return ({pair: found[pair] for pair in one.values()}, {one[pair]: x for pair, x in rests.items()},
            tuple((one[a], one[b]) for a, b in cones))


def _between_events(motion: Motion) -> ca.SX:
    """What does not change between events, beside discrete variables: parameters, and what is held."""
    return ca.vertcat(motion.p, motion.pieces)


def _given(motion: Motion) -> tuple[ca.SX, ca.SX, ca.SX]:
    """What changes at events alone, what does not between them, and what else goes its way whatever moves: time and inputs."""
    return motion.stepped, _between_events(motion), ca.vertcat(motion.t, motion.u)


def _kinks_of(motion: Motion, numbering: Numbering) -> dict[Pair, Expression]:
    """What limits and conditions in the gaps of contacts compare: where time or inputs alone decide the pace of a wall jumps,
    where conditions do the wall itself, and nothing of what rests on it tells when."""
    movers, others, found = ca.vertcat(motion.t, motion.u), ca.vertcat(motion.q, motion.v), dict[Pair, Expression]()
    finding = _finding(ca.vertcat(movers, others), motion.v, numbering, _given(motion))

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        if finding.is_driven(op, operands):
            found.update(driven_conditions(numbering, op, numbers, operands, finding.level))
            return
        pair = pair_of(numbering, op, numbers) if op in (*RELATIONS, *SIGNS, *WHOLE) else None
        if pair is None or pair in found:
            return
        a, b = operands if op in RELATIONS else (operands[0], as_expression(0.0))
        g = as_expression(ca.sin(ca.pi * a) if op in WHOLE else a - b if numbers[0] == pair[0] else b - a)
        moves = ca.depends_on(g, others)
        if moves if op in (*JUMPS, *WHOLE) else ca.depends_on(g, movers) and not moves:
            found[pair] = g

    rebuilt([motion.impacts.arms], numbering, note)
    return found


def _other_shapes(known: Motion, found: dict[Pair, Expression], same: Same, movers: ca.SX, numbering: Numbering) -> Same:
    """Conditions of reactions that forces feel: those of `found`, or else they come to them."""
    if known.felt is None:
        return {}
    others, _, _ = conditions_in([known.felt.values], movers, known.v, numbering, _given(known))
    aliases = match(found, {pair: g for pair, g in others.items()
                            if pair not in found and pair not in same and not is_of_one_side(pair)})
    found.update({pair: g for pair, g in others.items() if pair not in aliases and pair not in same})
    return aliases


def _rates_of(x: ca.SX, motion: Motion, slopes: ca.SX) -> ca.SX:
    return ca.jtimes(x, ca.vertcat(motion.q, motion.v, motion.t, motion.u), ca.vertcat(motion.pace, motion.a, 1, slopes))


def jumps_at_rest(force: ca.SX, shares: ca.SX, v: ca.SX) -> list[bool]:
    """Of each share, whether forces jump with it where nothing moves: those of dry friction do, those of dampers do not."""
    jumps = ca.substitute(ca.densify(ca.jacobian(force, shares)), v, ca.SX.zeros(v.numel()))
    return [not jumps[:, k].is_zero() for k in range(shares.numel())]


def find_thresholds(motion: Motion, switches: Switches) -> tuple[float, ...]:
    """The numbers other than 0, in SI units, with which rates are compared where forces jump about rest."""
    keys, found = switches.numbering.keys, dict[float, Expression]()
    for pair, share in switches.places.items():
        is_square = any(keys[k][0] == ca.OP_SQ for k in pair)
        constants = (abs(float(keys[k][1])) for k in pair if keys[k][0] == ca.OP_CONST)
        found |= {x**0.5 if is_square else x: share for x in constants if x > 0 and share.__hash__() in switches.shares}
    if not found:
        return ()
    jumps = jumps_at_rest(switches.hold([(motion.unsolved or motion).h])[0], ca.vertcat(*found.values()), motion.v)
    return tuple(x for x, is_jump in zip(found, jumps, strict=True) if is_jump)


def has_dry_friction(motion: Motion) -> bool:
    """Whether a force jumps where a rate passes through zero."""
    switches = find_switches(motion)
    shares = ca.vertcat(ca.SX(0, 1), *(x for x in switches.places.values() if x.__hash__() in switches.shares))
    return any(jumps_at_rest(switches.hold([(motion.unsolved or motion).h])[0], shares, motion.v))


@dataclass
class _Finding:
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
    both: dict[tuple[Pair, Pair], None] = field(default_factory=dict)
    equalities: dict[Pair, Expression] = field(default_factory=dict)
    equal: dict[Pair, bool] = field(default_factory=dict)  # which may be equal for a while: how these are compared
    either: set[Pair] = field(default_factory=set)  # the same, of which so far only the larger or the smaller is asked for
    squares: dict[int, Expression] = field(default_factory=dict)  # by the numbers of their roots: of lengths

    def __post_init__(self) -> None:
        self.directions, self.movers = Directions(self.numbering), symbols_in(self.moving)

    def note(self, op: int, numbers: list[int], operands: list[Expression]) -> None:
        """Of an instruction."""
        keys = [self.numbering.keys[k] for k in numbers]
        if op == ca.OP_MUL and all(key[0] == ca.OP_EQ for key in keys):
            a, b = (ordered(int(key[1]), int(key[2])) for key in keys)
            self.both[a, b] = None
        if op == ca.OP_SQRT and components_of(self.numbering, number := self.numbering.of(op, numbers)):
            self.squares[number] = operands[0]
        for direction in self.directions.found(op, numbers):
            if direction.length in self.squares:
                self._note_direction(self.squares[direction.length])
        if self.is_driven(op, operands):
            self.found = driven_conditions(self.numbering, op, numbers, operands, self.level) | self.found
            return
        rest = rest_asked(self.numbering, op, numbers)
        if rest is not None:
            self.asked.append(rest[0])
            self._note_square(operands)
            if op in (ca.OP_EQ, ca.OP_NE):
                self.equalities[ordered(*numbers)] = as_expression(operands[0] - operands[1] if numbers[0] < numbers[1]
                                                                   else operands[1] - operands[0])
            if op in RELATIONS or len(rest[0]) > 1:  # of |a|, which is found by itself
                return
        pair = rest[0][0] if rest else pair_of(self.numbering, op, numbers)
        is_of_first = pair is not None and (op == ca.OP_LT) == (numbers[0] == pair[0])
        if pair in self.equal and op in JUMPS and (op == ca.OP_SIGN or self.equal[pair] != is_of_first):
            _refuse_equal()
        if pair in self.either and op in JUMPS:
            self.either.discard(pair)
            self.found.pop(pair, None)
        if pair is None or pair in self.found or (op in WHOLE and _only_jumps(operands[0], self.moving)):
            return
        g = self._difference(op, numbers, operands, pair)
        if op in (*WHOLE, ca.OP_ATAN2) and _is_rate(self.v, g):  # nothing holds it there
            return
        if self._moves(g):
            self.found[pair] = g

    def _difference(self, op: int, numbers: list[int], operands: list[Expression], pair: Pair) -> Expression:
        """What changes its sign where the operation bends or jumps."""
        if op in WHOLE:
            return as_expression(ca.sin(ca.pi * operands[0]))
        a, b = (operands[0], as_expression(0.0)) if op in SIGNS or op == ca.OP_ATAN2 else operands
        difference, is_first = as_expression(a - b if numbers[0] == pair[0] else b - a), numbers[0] == pair[0]
        if op == ca.OP_ATAN2 or operations_in(difference).isdisjoint(ALL_JUMPS):
            return difference
        levels = Levels(self.moving)
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
            return _taken_apart(Levels(self.moving, edge=EDGE), as_expression(a < b))
        is_step = symbols_in(difference).isdisjoint(self.driven)  # no error of it tells more than its side
        return as_expression(ca.fmax(ca.fmin(difference / EDGE - 1, 1), -1) if is_step else difference - EDGE)

    def is_driven(self, op: int, operands: list[Expression]) -> bool:
        """Whether nothing decides that answers to forces: it may stay on a level."""
        if op not in (*SIDED, *WHOLE) or (op in WHOLE and _only_jumps(operands[0], self.moving)):
            return False
        moving = self.movers & symbols_in(ca.veccat(*operands))
        is_told = moving.isdisjoint(self.driven) and (op not in JUMPS or not moving)  # what stands between events is as it is
        return not is_told and moving <= self.driven | self.stepped

    def _moves(self, x: Expression) -> bool:
        return not self.movers.isdisjoint(symbols_in(x))

    def _note_square(self, operands: list[Expression]) -> None:
        """Of a^2 > 0, a^4 > 0 or a^2 == 0: a."""
        root = next((x for x in operands if not x.is_constant() and x.op() == ca.OP_SQ), None)
        if root is None:
            return
        while not root.is_symbolic() and root.op() == ca.OP_SQ:
            root = as_expression(root.dep(0))
        number = self.numbering.number(root)
        pair = ordered(number, self.numbering.of_number(0.0))
        if self._moves(root):
            self.found.setdefault(pair, root if pair[0] == number else as_expression(-root))

    def _note_direction(self, square: Expression) -> None:
        """Of a rate that is a vector: both components are to rest where it has none."""
        square = next((square.dep(k) for k in (0, 1) if square.dep(1 - k).is_constant()), square)
        components, zero = [as_expression(square.dep(k).dep(0)) for k in (0, 1)], self.numbering.of_number(0.0)
        if not all(_is_rate(self.v, x) for x in components):
            return
        numbers = [self.numbering.number(x) for x in components]
        a, b = (ordered(number, zero) for number in numbers)
        for pair, number, x in zip((a, b), numbers, components, strict=True):
            self.found.setdefault(pair, x if pair[0] == number else as_expression(-x))
        self.asked += [(a,), (b,)]
        self.both[a, b] = None


def _finding(movers: ca.SX, v: ca.SX, numbering: Numbering, known: tuple[ca.SX, ca.SX, ca.SX]) -> _Finding:
    return _Finding(movers, v, numbering, symbols_in(known[0]), symbols_in(known[1]), symbols_in(known[2]))


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
                  known: tuple[ca.SX, ca.SX, ca.SX] = (_NONE, _NONE, _NONE)
                  ) -> tuple[dict[Pair, Expression], dict[Pair, Expression], tuple[tuple[Pair, Pair], ...]]:
    """Differences of what conditions in the forces compare, of those that `movers` decide (`known`: what changes at events alone,
    what does not change between events, and what goes its way whatever moves); symbols for the rates of which it is asked whether
    they rest; and pairs of the latter that are asked about together."""
    finding = _finding(movers, v, numbering, known)
    rebuilt(forces, numbering, finding.note)
    found = finding.found
    same = multiples(found | finding.equalities, v, known[1], numbering) if finding.equalities else {}
    found |= {pair: g for pair, g in finding.equalities.items() if pair in same and same[pair].of in found}
    rests = _rests(v, found, finding.asked)
    found = _without_unused(forces, found, rests, numbering) if rests else found
    return found, rests, tuple(cone for cone in finding.both if all(pair in rests for pair in cone))


def _only_jumps(x: Expression, moving: ca.SX) -> bool:
    """Whether x is constant while its parts are held: it may rest on a whole number then, and rounding tells no side of it."""
    return not operations_in(x).isdisjoint(STEPS) and ca.jacobian(x, moving).is_zero()


def _is_rate(v: ca.SX, g: Expression) -> bool:
    return not symbols_in(v).isdisjoint(symbols_in(g))


def _rests(v: ca.SX, found: Mapping[Pair, Expression], asked: Sequence[Sequence[Pair]]) -> dict[Pair, Expression]:
    """Symbols for the rates of which it is asked whether they rest."""
    chosen = [next((pair for pair in pairs if pair in found and _is_rate(v, found[pair])), None) for pairs in asked]
    return {pair: symbol(f"rest_{k}") for k, pair in enumerate(dict.fromkeys(chosen)) if pair is not None}


def _without_unused(forces: Sequence[ca.SX], found: Mapping[Pair, Expression], rests: Mapping[Pair, Expression],
                    numbering: Numbering) -> dict[Pair, Expression]:
    """Those that forces still have: |v|, of which nothing was asked but whether it is 0, is none."""
    places = {pair: symbol(f"s_{k}") for k, pair in enumerate(found)}
    used = symbols_in(ca.veccat(*rebuilt(forces, numbering, Holding(places, frozenset(), rests, numbering).made)))
    return {pair: g for pair, g in found.items() if pair in rests or places[pair].__hash__() in used}


def _moot_rests(forces: ca.SX, holding: Holding, cones: Sequence[tuple[Pair, Pair]]) -> dict[Expression, Expression]:
    """The symbols of rates that rub as they move, and have a force of their own at rest, as a clamped load (Karnopp's law): what
    holds there is a share of what rubs, as of a rate that is never found at rest. With 0 for each."""
    together = {pair for cone in cones for pair in cone}
    signs = {pair for pair, sign in holding.places.items() if sign.is_symbolic()}
    asked = {pair: rest for pair, rest in holding.rests.items() if pair in signs and pair not in together}
    if not asked:
        return {}
    (held,) = rebuilt([forces], holding.numbering, holding.made)
    moot = dict[Expression, Expression]()
    for pair, rest in asked.items():
        at_rest, moving = (ca.jacobian(ca.substitute(held, rest, value), holding.places[pair]) for value in (1, 0))
        if at_rest.is_zero() and not moving.is_zero():
            moot[rest] = as_expression(0.0)
    return moot


def find_roots(motion: Motion, switches: Switches) -> tuple[ca.SX, ca.SX]:
    """What stands under square roots in the forces and depends on positions, with its rates (r,): where it touches 0 forces bend,
    or jump, and no sign changes. Where whole numbers are counted, sin(pi x)^2 is what touches 0."""
    if _ROOTED.isdisjoint(motion.operations):
        return ca.SX(0, 1), ca.SX(0, 1)
    moving, rates, movers = symbols_in(motion.q), symbols_in(motion.v), ca.vertcat(motion.t, motion.q)
    numbering, found = Numbering(), dict[int, ca.SX]()

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        is_asked = op in _ROOTED and not moving.isdisjoint(known := symbols_in(operands[0]))
        if is_asked and rates.isdisjoint(known) and (op == ca.OP_SQRT or not _only_jumps(operands[0], movers)):
            found.setdefault(numbers[0], operands[0] if op == ca.OP_SQRT else ca.sin(ca.pi * operands[0]) ** 2)

    rebuilt(switches.hold([(motion.unsolved or motion).h]), numbering, note)
    values = ca.vertcat(ca.SX(0, 1), *found.values())
    return values, ca.jtimes(values, ca.vertcat(motion.q, motion.t), ca.vertcat(motion.pace, 1)) if found else values


def _find_rubs(motion: Motion, switches: Switches) -> tuple[int, ...]:
    """Switches whose shares tell the directions of impulses."""
    (h,) = switches.hold([motion.h])
    pressing = ca.vertcat(*(x for pair in motion.impacts.pressing.values() for x in pair))
    others = symbols_in(ca.substitute(h, pressing, ca.SX.zeros(pressing.numel())))
    acting = [(event, symbols_in(ca.jacobian(h, impulse))) for event, (_, impulse) in motion.impacts.pressing.items()]
    places = {s.__hash__(): k for k, s in enumerate(switches.places.values())}
    found = [(k, event, int(s not in others)) for event, symbols in acting for s, k in places.items() if s in symbols]
    return tuple(x for rub in found for x in rub)


def live(name: str, functions: Mapping[str, ca.Function], resting: Sequence[int] = ()) -> ca.Function:
    """`rhs` or `outputs` of the run time's functions with each switch as its condition is; `resting`: `rests` of its patterns."""
    held, switches = functions[name], functions.get("switches")
    if switches is None:
        return held
    names = [held.name_in(k) for k in range(held.n_in())]
    given = {label: ca.SX.sym(label, held.size1_in(label)) for label in names}
    told = switches.numel_out("g") + len(resting)  # which some conditions are made of
    given["d"] = ca.SX.sym("d", switches.size1_in("d") - (told if switches.size1_in("d") == held.size1_in("d") else 0))
    known = {switches.name_in(k): ca.SX.zeros(switches.size1_in(k)) for k in range(switches.n_in())}
    g = switches.call(known | {label: given[label] for label in names if label in known})["g"]
    rests = [g[k] == 0 for k in resting]
    found = held.call(given | {"d": ca.vertcat(given["d"], (g > 0) + 0.5 * (g == 0), *rests)})
    results = [held.name_out(k) for k in range(held.n_out())]
    return ca.Function(name, [given[label] for label in names], [found[label] for label in results], names, results)
