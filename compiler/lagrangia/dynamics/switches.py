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
from functools import partial
from types import MappingProxyType

import casadi as ca

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbol, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, operations_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.acting_rates import groups_in, groups_of_rates, that_may_hold
from lagrangia.dynamics.driven_conditions import Pair, driven_conditions, is_of_one_side, sides_of
from lagrangia.dynamics.found_conditions import Finding, conditions_in, finding_in, is_rate, only_jumps
from lagrangia.dynamics.held_switches import (
    EITHER,
    HALF,
    JUMPS,
    OF_WHOLE,
    ONE,
    RELATIONS,
    SIGNS,
    WHOLE,
    ZERO,
    Holding,
    pair_of,
    value_on_level,
)
from lagrangia.dynamics.motion import SMOOTH, Motion
from lagrangia.dynamics.same_conditions import Same, match, multiples

_BENT = CORNERS | {ca.OP_ATAN2}
_NONE = ca.SX(0, 1)
_JUMPING = frozenset({*JUMPS, *WHOLE})
_ROOTED = frozenset({ca.OP_SQRT, ca.OP_FLOOR, ca.OP_CEIL})
_LEAST = 1e-290  # as in standing.c
_UNKNOWN = {ZERO, ONE}  # on which side a condition is of which a factor may be negative: as if both were asked


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
    at_level: "dict[Pair, int]" = field(default_factory=dict)  # `side_on_level` of places and aliases with which something jumps
    edge: ca.SX = field(default_factory=lambda: ca.SX(0, 1))  # (0 or 1,): what conditions of events that may be held have beside
    groups: tuple[int, ...] = ()  # of rates, where there are several: those of one are accelerated together
    reach: "dict[Pair, frozenset[int]]" = field(default_factory=dict)  # of shares: the groups of the rates that they hold
    halves: frozenset[Pair] = frozenset()  # those that are no shares and 0.5 on their level

    def hold(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """The same with the symbols in place of what they stand for."""
        if not self.places:
            return list(expressions)
        return rebuilt(expressions, self.numbering, self.holding().made)

    def holding(self) -> Holding:
        """What does so, of one set of expressions."""
        return Holding(self.places | self.aliases, self.shares, self.rests | self.rest_aliases, self.numbering, self.nothing,
                       self.halves)

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
        return {"rubs": self.rubs, "rests": tuple(order[pair] for pair in self.rests), "cones": tuple(cones),
                "at_level": tuple(self.at_level.get(pair, HALF if pair in self.rests else EITHER) for pair in self.places)}


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
    unfelt = _unfelt(motion.unsolved or motion, numbering)
    if not unfelt and not may_have and not events.numel() and not bends:
        return Switches()
    signs = {sign_of(x, numbering) for x in motion.lengths}
    known = motion.unsolved or motion
    laws, reactions = ([known.felt.laws], known.felt.reactions) if known.felt else ([], ca.SX(0, 1))
    movers = ca.vertcat(motion.t, motion.q, motion.v, motion.u, reactions)
    free = partial(_that_nothing_holds, known, numbering) if not others else None
    found, rests, cones, sides = conditions_in([known.h, *laws, *others], movers, motion.v, numbering, _given(known), free)
    driven = ca.vertcat(known.t, known.u)
    same = multiples(found, motion.v, ca.vertcat(_between_events(known), known.stepped), numbering, driven)
    found, rests, cones = _merged(found, rests, cones, same)
    found |= _signs_of_factors(same, driven, finding_in(movers, motion.v, numbering, _given(known)))
    found = unfelt | dict(_sided(g, numbering) for g in bends) | found
    found = found | {pair: g for pair, g in _kinks_of(motion, numbering).items() if pair not in found}
    same |= _other_shapes(known, found, same, movers, numbering, sides)
    if not found and not events.numel():
        return Switches()
    found = {pair: found[pair] for pair in sorted(found, key=lambda pair: pair not in signs)}
    slopes, places = ca.SX.sym("du", motion.u.numel()), {pair: symbol(f"s_{k}") for k, pair in enumerate(found)}
    loose = _that_hold_nothing(known, found, places, rests, same, numbering) if not others else frozenset()
    rests, cones = _without_free(rests, cones, loose, sides)
    sharing = {pair: g for pair, g in found.items() if pair not in loose and is_rate(motion.v, g)}
    shares = frozenset(places[pair].__hash__() for pair in sharing)
    edge = motion.impacts.edge if shares or motion.impacts.may_hold else _NONE
    values = ca.vertcat(ca.SX(0, 1), *found.values(), *_values_of_events(motion, slopes, edge))
    symbols = ca.vertcat(ca.SX(0, 1), *places.values(), ca.SX.sym("event", 2 * events.numel()), motion.impacts.forces)
    switches = Switches(symbols, values, _rates_of(values, motion, slopes), slopes, places, shares, rests, cones, numbering,
                        lengths=sum(pair in signs for pair in found), edge=edge)
    switches = replace(_with_reach(switches, known, {} if others else sharing), at_level=_at_level(sides, {*found, *same}, same))
    switches = _with_aliases(switches, same, ca.veccat(known.h, *laws))
    return replace(switches, rubs=_find_rubs(motion, switches)) if motion.impacts.pressing else switches


def _with_reach(switches: Switches, known: Motion, sharing: Mapping[Pair, Expression]) -> Switches:
    """With the groups that forces hold together, if there are several."""
    groups = groups_of_rates(known) if sharing else ()
    if len(set(groups)) <= 1:
        return switches
    return replace(switches, groups=groups, reach={pair: groups_in(g, known.v, groups) for pair, g in sharing.items()})


def held_switches(motion: Motion, conditions: Mapping[Pair, Expression], rests: dict[Pair, Expression], numbering: Numbering
                  ) -> Switches:
    """Of conditions on rates alone, those that forces may hold: symbols of shares, and the rates as `values`; `rests`: whether
    they are at rest."""
    places = {pair: symbol(f"s_{k}") for k, pair in enumerate(conditions)}
    held = that_may_hold(motion, conditions, places, rests, numbering, groups_of_rates(motion)) if conditions else frozenset()
    places = {pair: s for pair, s in places.items() if pair in held}
    symbols, values = (ca.vertcat(ca.SX(0, 1), *column) for column in (places.values(), (conditions[pair] for pair in places)))
    shares = frozenset(s.__hash__() for s in places.values())
    switches = Switches(symbols, values, places=places, shares=shares, numbering=numbering,
                        rests={pair: x for pair, x in rests.items() if pair in held})
    return _with_reach(switches, motion, {pair: conditions[pair] for pair in places})


def _that_hold_nothing(known: Motion, found: Mapping[Pair, Expression], places: Mapping[Pair, Expression],
                       rests: Mapping[Pair, Expression], same: Same, numbering: Numbering) -> frozenset[Pair]:
    """Of conditions on rates, those whose forces hold none of these."""
    rates = {pair: g for pair, g in found.items() if is_rate(known.v, g)}
    aliases = {pair: x.switch(places) for pair, x in same.items()}
    if not rates:
        return frozenset()
    return frozenset(rates) - that_may_hold(known, rates, {**places, **aliases}, rests, numbering, groups_of_rates(known))


def _that_nothing_holds(known: Motion, numbering: Numbering, alone: Mapping[Pair, Expression]) -> frozenset[Pair]:
    """Of equalities of rates, those of which no force holds any."""
    symbols = {pair: symbol("s") for pair in alone}
    return _that_hold_nothing(known, alone, symbols, symbols, {}, numbering)


def _without_free(rests: dict[Pair, Expression], cones: tuple[tuple[Pair, Pair], ...], free: frozenset[Pair],
                  sides: dict[Pair, set[int]]) -> tuple[dict[Pair, Expression], tuple[tuple[Pair, Pair], ...]]:
    """What is asked of rest, without rates that nothing holds: these are equal as places are."""
    for pair in free & rests.keys():
        sides.setdefault(pair, set()).add(HALF)
    return ({pair: x for pair, x in rests.items() if pair not in free},
            tuple(cone for cone in cones if free.isdisjoint(cone)))


def _unfelt(motion: Motion, numbering: Numbering) -> dict[Pair, Expression]:
    """Conditions on what goes its way whatever moves, with which a potential or an inertia jumps, felt by forces or not: what the
    jump of energy is, and that of rates, is looked at there. Comparisons in inertias are modes, whose times are known."""
    if motion.asked <= SMOOTH:
        return {}
    counted = not operations_in(motion.momentum).isdisjoint(WHOLE)
    asked = [motion.V] * (not operations_in(motion.V).isdisjoint(_JUMPING)) + [motion.momentum] * counted
    if not asked:
        return {}
    driven, moving = ca.vertcat(motion.t, motion.u), symbols_in(ca.vertcat(motion.q, motion.v))
    finding = finding_in(driven, motion.v, numbering, _given(motion))

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        if op in _JUMPING and moving.isdisjoint(symbols_in(ca.vertcat(*operands))):
            finding.note(op, numbers, operands)

    rebuilt(asked, numbering, note)
    return finding.found


def _signs_of_factors(same: Same, driven: ca.SX, finding: Finding) -> dict[Pair, Expression]:
    """Into `same`, conditions whether factors are positive, or negative, that go their way whatever moves; and these."""
    found = dict[Pair, Expression]()
    for pair, x in same.items():
        if ca.depends_on(x.factor, driven):
            number = [finding.numbering.number(x.factor)]
            found |= driven_conditions(finding.numbering, ca.OP_SIGN, number, [x.factor], finding.level)
            same[pair] = replace(x, signs=sides_of(finding.numbering, ca.OP_SIGN, number))
    return found


def _at_level(sides: Mapping[Pair, set[int]], known: set[Pair], same: Same) -> dict[Pair, int]:
    """Of conditions with which something jumps: half of a switch, where what jumps does not ask for the same."""
    asked = dict[Pair, set[int]]()
    for pair, found in sides.items():
        of, is_same = (same[pair].of, found == {HALF}) if pair in same else (pair, True)
        asked.setdefault(of, set()).update(found if is_same else _UNKNOWN)
    one = {pair: next(iter(found)) if len(found) == 1 else HALF for pair, found in asked.items()}
    return {pair: one[pair] for pair in known & one.keys()} | {pair: one[x.of] for pair, x in same.items() if x.of in one}


def _with_aliases(switches: Switches, same: Same, forces: ca.SX) -> Switches:
    """With what stands for conditions in other shapes; what is said of rates that rest is left out where it is moot."""
    places, rests, numbering = switches.places, switches.rests, switches.numbering
    aliases = {pair: x.switch(places) for pair, x in same.items()}
    nothing = {pair: x.is_nothing(places) for pair, x in same.items() if x.may_vanish}
    held = {pair: rests[x.of] for pair, x in same.items() if x.of in rests}
    holding = Holding(places | aliases, switches.shares, rests | held, numbering, nothing)
    moot = _moot_rests(forces, holding, switches.cones)
    held = {pair: same[pair].rests(moot.get(x, x), places) for pair, x in held.items()}
    halves = frozenset(pair for pair, side in switches.at_level.items()
                       if side in (HALF, OF_WHOLE) and switches.shares.isdisjoint(symbols_in(holding.places[pair])))
    return replace(switches, rests={pair: x for pair, x in rests.items() if x not in moot}, aliases=aliases, nothing=nothing,
                   halves=halves, rest_aliases=held | {pair: moot[x] for pair, x in rests.items() if x in moot})


def _values_of_events(motion: Motion, slopes: ca.SX, edge: ca.SX) -> list[ca.SX]:
    """Their conditions, the gaps, and the rates of these."""
    impacts, paces = motion.impacts, _rates_of(motion.impacts.arms, motion, slopes)
    resting = [impacts.gaps[k] if impacts.one_way[k] else paces[k] for k in range(impacts.gaps.numel())]
    return [impacts.edged if edge.numel() else impacts.conditions, impacts.arms, *resting]


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
    finding = finding_in(ca.vertcat(movers, others), motion.v, numbering, _given(motion))

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


def _other_shapes(known: Motion, found: dict[Pair, Expression], same: Same, movers: ca.SX, numbering: Numbering,
                  sides: dict[Pair, set[int]]) -> Same:
    """Conditions of reactions that forces feel: those of `found`, or else they come to them."""
    if known.felt is None:
        return {}
    others, _, _, more_sides = conditions_in([known.felt.values], movers, known.v, numbering, _given(known))
    for pair, asked in more_sides.items():
        sides.setdefault(pair, set()).update(asked)
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
        if is_asked and rates.isdisjoint(known) and (op == ca.OP_SQRT or not only_jumps(operands[0], movers)):
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


def live(name: str, functions: Mapping[str, ca.Function],
         patterns: Mapping[str, Sequence[int]] = MappingProxyType({})) -> ca.Function:
    """`rhs` or `outputs` of the run time's functions with each switch as its condition is; `patterns`: those of the switches."""
    held, switches = functions[name], functions.get("switches")
    if switches is None:
        return held
    names = [held.name_in(k) for k in range(held.n_in())]
    given = {label: ca.SX.sym(label, held.size1_in(label)) for label in names}
    told = switches.numel_out("g") + len(patterns.get("rests", ()))  # which some conditions are made of
    given["d"] = ca.SX.sym("d", switches.size1_in("d") - (told if switches.size1_in("d") == held.size1_in("d") else 0))
    known = {switches.name_in(k): ca.SX.zeros(switches.size1_in(k)) for k in range(switches.n_in())}
    g = switches.call(known | {label: given[label] for label in names if label in known})["g"]
    rests = [g[k] == 0 for k in patterns.get("rests", ())]
    sides = patterns.get("at_level", ())
    others = g.numel() - len(sides)
    at_level = ca.DM([*map(value_on_level, sides), *[0.5] * others])
    least = ca.DM([*(0.0 if side == EITHER else _LEAST for side in sides), *[0.0] * others])
    is_equal = ca.fabs(g) <= least
    found = held.call(given | {"d": ca.vertcat(given["d"], ca.if_else(is_equal, at_level, g > 0), *rests)})
    results = [held.name_out(k) for k in range(held.n_out())]
    return ca.Function(name, [given[label] for label in names], [found[label] for label in results], names, results)
