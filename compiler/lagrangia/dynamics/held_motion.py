"""What moves, and what is told of it, while conditions are held by switches.

A rate that forces hold at a level, as friction does, is on it for all but these forces: their switch is a share of a jump
there (switches.py), which is what they need to hold it. They are so wherever they are asked for: in outputs, in reactions, and
in forces on what pushes back.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import accumulate, chain

import casadi as ca

from lagrangia.algebra.numbering import rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, places_in, symbol, symbols_in
from lagrangia.base.later import Later
from lagrangia.dynamics.driven_conditions import Pair
from lagrangia.dynamics.held_switches import Holding
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.own_forces import Force, Level, OwnForces, jumping_in
from lagrangia.dynamics.switches import Switches

Put = Callable[[Sequence[ca.SX]], list[ca.SX]]


class HeldMotion:
    """Of a motion with its switches; `declared`: values of its parameters."""

    def __init__(self, motion: Motion, switches: Switches, declared: ca.DM) -> None:
        self.switches, self.motion = switches, motion.unsolved or motion
        self.own, self.levels = Later(self._own_forces), Later(self._levels)
        self.shares = {x.__hash__(): pair for pair, x in switches.places.items() if x.__hash__() in switches.shares}
        self.all, self.decides = frozenset(self.shares.values()), self._decides()
        symbols = ca.vertcat(ca.SX(0, 1), *switches.places.values())
        at_rest = ca.vertcat(ca.SX(0, 1), *(x for x in switches.rests.values() if x.is_symbolic()))
        self.movers = symbols_in(ca.vertcat(motion.t, motion.q, motion.v, motion.u))
        self._level = Level(symbols, switches.values[: symbols.numel()], self.motion.v, at_rest, self.motion.p, declared)

    def rows(self, expressions: Sequence[ca.SX], rows: ca.SX | None = None, v: ca.SX | None = None,
             against: tuple[Later[ca.SX], ca.SX] | None = None) -> list[ca.SX]:
        """Held expressions, the first a row for each rate, and the last one for each of `rows`, made of the rates v. `against`:
        forces (n,) and the rates, against which the second is power, taken out and put in, with their rows as they are held."""
        groups, counts = self.switches.groups, against is not None and expressions[1].numel() > 0
        if not self.switches.reach:
            return self.switches.hold(expressions)
        asked = [*expressions, against[0].value] if against is not None and counts else [*expressions]
        held, of = self.switches.hold(asked), dict[int, Sequence[int | None]]({0: groups})
        if rows is not None and v is not None:
            of[len(expressions) - 1] = [next((groups[k] for k in found), -1) for found in places_in(rows, v)]
        of |= {len(expressions): groups} if counts else {}
        column, column_held = (ca.vertcat(*(ca.densify(x[k]) for k in of)) for x in (asked, held))
        apart = self._apart(column, column_held, [*chain(*of.values())])
        if apart is column_held:
            return held[: len(expressions)]
        told = dict(zip(of, ca.vertsplit(apart, [0, *accumulate(map(len, of.values()))]), strict=True))
        if against is not None and counts:
            held[1] += ca.vertcat(0, ca.dot(against[1], held.pop() - told.pop(len(expressions))))
        return [told.get(k, x) for k, x in enumerate(held)]

    def outputs(self, y: ca.SX, put: Put) -> ca.SX:
        """Held outputs (k,): each of no group of rates. `put` puts reactions in the place of their symbols."""
        (told,) = put([y])
        if not self.shares or not any(self._asked(told)):
            return self.switches.hold([told])[0]
        (y,), forces = self._taken_out(y)
        told, *values = put([y, *(force.value for force in forces)])
        held = self._apart(told, self.switches.hold([told])[0], [None] * y.numel())
        return self._put_back(held, [replace(x, value=value) for x, value in zip(forces, values, strict=True)], self.all)

    def _apart(self, rows: ca.SX, held: ca.SX, groups: Sequence[int | None]) -> ca.SX:
        """Held rows, each of a group of rates: a rate that forces on others hold is on its level there, where its switch is no
        share."""
        reach, asked = self.switches.reach, self._asked(rows)
        apart = [frozenset(pair for pair in own if group is None or group not in reach[pair])
                 for group, own in zip(groups, asked, strict=True)]
        return _told(rows, held, asked, apart, self._seen)

    def _asked(self, rows: ca.SX) -> list[set[Pair]]:
        """What each row asks of rates that may be held, with even parts of jumps, as sign(v)^2 is, which no share is in."""
        switches = self.switches
        holding = Holding(switches.places | switches.aliases, frozenset(), switches.rests | switches.rest_aliases,
                          switches.numbering, switches.nothing)
        (told,) = rebuilt([rows], switches.numbering, holding.made)
        places = list(switches.places)
        found = places_in(told, ca.vertcat(ca.SX(0, 1), *switches.places.values()))
        return [set[Pair]().union(*(self.decides[places[k]] for k in own)) for own in found]

    def _decides(self) -> dict[Pair, set[Pair]]:
        """Of each condition, the rates that may be held which it is of, itself or as max(v, 0) > 0."""
        v, places, pairs = symbols_in(self.motion.v), self.switches.places, frozenset(self.shares.values())
        moving = {pair: v & symbols_in(self.switches.values[k]) for k, pair in enumerate(places)} if pairs else {}
        return {pair: {pair} if pair in pairs else {x for x in pairs if moving[x] <= own} for pair, own in moving.items()}

    def _seen(self, rows: ca.SX, pairs: frozenset[Pair]) -> ca.SX:
        """Held, and these on their level but in the forces that hold them."""
        (rows,), forces = self._taken_out(rows)
        return self._put_back(self._on_level(rows, pairs), forces, pairs)

    def _taken_out(self, x: ca.SX) -> tuple[list[ca.SX], list[Force]]:
        own, switches = self.own.value, self.switches
        own.note_alike(jumping_in([x], switches.holding(), switches.numbering), self._level)
        return own.taken_out([x])

    def _put_back(self, held: ca.SX, forces: Sequence[Force], pairs: frozenset[Pair]) -> ca.SX:
        """With these where they stand, each on the level of those of the pairs that it does not hold."""
        if not forces:
            return held
        values, symbols = ca.vertcat(*(force.value for force in forces)), [force.symbol for force in forces]
        asked = self._asked(values)
        on_level = [own & pairs - {self.shares[x] for x in force.shares} for own, force in zip(asked, forces, strict=True)]
        values = _told(values, self.switches.hold([values])[0], asked, list(map(frozenset, on_level)), self._on_level)
        _, (made,) = ca.substitute_inplace(symbols, ca.vertsplit(values), [held], False)
        return made

    def _on_level(self, rows: ca.SX, pairs: frozenset[Pair]) -> ca.SX:
        """Held, and both sides of these equal while something holds them so."""
        switches = self.switches
        held, symbols = switches.rests | switches.rest_aliases, ca.vertcat(*(switches.places[pair] for pair in pairs))
        levels = {pair: symbol("level") for pair in pairs}
        own = frozenset(switches.places[pair].__hash__() for pair in pairs)
        shapes = {pair: x for pair, x in switches.aliases.items() if not own.isdisjoint(symbols_in(x))}
        on_levels = ca.substitute([*shapes.values()], [symbols], [ca.vertcat(*levels.values())]) if shapes else []
        places = switches.places | levels | switches.aliases | dict(zip(shapes, map(as_expression, on_levels), strict=True))
        others = pairs | shapes.keys()
        rests = {pair: x for pair, x in held.items() if pair not in others or not x.is_constant()}
        holding = Holding(places, switches.shares - own, rests, switches.numbering, switches.nothing, switches.halves | others,
                          {pair: self.levels.value[pair] for pair in pairs & self.levels.value.keys()}, self.movers)
        (made,) = rebuilt([rows], switches.numbering, holding.made)
        is_held = [switches.rests[pair] if pair in switches.rests else s * (1 - s)
                   for pair, s in zip(pairs, ca.vertsplit(symbols), strict=True)]
        values = [ca.if_else(x, 0.5, s) for x, s in zip(is_held, ca.vertsplit(symbols), strict=True)]
        return ca.substitute(made, ca.vertcat(*levels.values()), ca.vertcat(*values))

    def _levels(self) -> dict[Pair, tuple[Expression, Expression]]:
        """Rates that alone are held by their conditions, and what they are then."""
        found, v = dict[Pair, tuple[Expression, Expression]](), symbols_in(self.motion.v)
        for pair, g in zip(self.switches.places, self.switches.values.elements(), strict=False):
            rates = [x for x in ca.symvar(g) if x.__hash__() in v] if pair in self.all else []
            slope = ca.jacobian(g, rates[0]) if len(rates) == 1 else ca.SX(0, 0)
            if slope.numel() and slope.is_constant():
                rest = ca.substitute(g, rates[0], 0)
                found[pair] = as_expression(rates[0]), as_expression(0.0 if rest.is_zero() else -rest / slope)
        return found

    def _own_forces(self) -> OwnForces:
        """In the forces with their amounts, and with the laws of these."""
        known, switches, felt = self.motion, self.switches, self.motion.felt
        acting = [known.h] if felt is None else [known.h, ca.substitute(known.h, felt.amounts, felt.laws)]
        own = OwnForces(switches.numbering, jumping_in(acting, switches.holding(), switches.numbering))
        groups = switches.groups
        slopes = ca.densify(ca.jacobian(switches.values[: len(switches.places)], known.v))
        rows = [(k, row) for h in acting for k, row in enumerate(ca.vertsplit(ca.densify(h)))]
        for k, row in rows:
            along = {s.__hash__(): as_expression(slopes[place, k]) for place, (pair, s) in enumerate(switches.places.items())
                     if pair in self.all and (not switches.reach or groups[k] in switches.reach[pair])}
            own.note(switches.numbering.number(as_expression(row)), along)
        return own


def _told(rows: ca.SX, held: ca.SX, asked: Sequence[set[Pair]], on_level: Sequence[frozenset[Pair]],
          tell: Callable[[ca.SX, frozenset[Pair]], ca.SX]) -> ca.SX:
    """Held rows, with those told that ask for rates on their level: together, where what is so for one is for all that ask."""
    told = list[tuple[list[int], set[Pair], set[Pair]]]()  # rows, what is on its level for them, and what they ask else
    for row, (own, pairs) in enumerate(zip(asked, on_level, strict=True)):
        if not pairs:
            continue
        others = own - pairs
        fit = next((x for x in told if x[1].isdisjoint(others) and x[2].isdisjoint(pairs)), None)
        if fit is None:
            told.append(fit := ([], set(), set()))
        fit[0].append(row)
        fit[1].update(pairs)
        fit[2].update(others)
    if not told:
        return held
    rows, found = ca.densify(rows), ca.vertsplit(held)
    for places, on_their_level, _ in told:
        for row, x in zip(places, ca.vertsplit(tell(rows[places], frozenset(on_their_level))), strict=True):
            found[row] = x
    return ca.vertcat(*found)
