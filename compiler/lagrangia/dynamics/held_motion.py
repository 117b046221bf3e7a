"""What moves, and what is told of it, while conditions are held by switches.

A rate that forces hold at a level, as friction does, is on it for all but these forces: their switch is a share of a jump
there (switches.py), which is what they need to hold it. They are so wherever they are asked for: in outputs, in reactions, and
in forces on what pushes back.
"""

from collections.abc import Callable, Sequence
from dataclasses import replace

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
    """Of a motion with its switches."""

    def __init__(self, motion: Motion, switches: Switches) -> None:
        self.switches, self.motion = switches, motion.unsolved or motion
        self.own, self.levels = Later(self._own_forces), Later(self._levels)
        self.shares = {x.__hash__(): pair for pair, x in switches.places.items() if x.__hash__() in switches.shares}
        self.all, self.decides = frozenset(self.shares.values()), self._decides()
        symbols = ca.vertcat(ca.SX(0, 1), *switches.places.values())
        at_rest = ca.vertcat(ca.SX(0, 1), *(x for x in switches.rests.values() if x.is_symbolic()))
        self.movers = symbols_in(ca.vertcat(motion.t, motion.q, motion.v, motion.u))
        self._level = Level(symbols, switches.values[: symbols.numel()], self.motion.v, at_rest)

    def rows(self, expressions: Sequence[ca.SX], rows: ca.SX | None = None, v: ca.SX | None = None) -> list[ca.SX]:
        """Held expressions, the first a row for each rate, and the last one for each of `rows`, made of the rates v."""
        switches, held = self.switches, self.switches.hold(expressions)
        if not switches.reach:
            return held
        held[0] = self._apart(expressions[0], held[0], switches.groups)
        if rows is not None and v is not None:
            groups = [next((switches.groups[k] for k in found), -1) for found in places_in(rows, v)]
            held[-1] = self._apart(expressions[-1], held[-1], groups)
        return held

    def power(self, power: ca.SX, forces: Later[ca.SX], rates: ca.SX) -> ca.SX:
        """Held power, taken out and put in by forces (n,) against `rates`, with their rows as they are held."""
        if not self.switches.reach or not power.numel():
            return power
        (held,) = self.switches.hold([forces.value])
        return power + ca.vertcat(0, ca.dot(rates, held - self._apart(forces.value, held, self.switches.groups)))

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
        reach, found = self.switches.reach, dict[int, ca.SX]()
        apart = [frozenset(pair for pair in own if group is None or group not in reach[pair])
                 for group, own in zip(groups, self._asked(rows), strict=True)]
        for pairs in dict.fromkeys(x for x in apart if x):
            own = [row for row, x in enumerate(apart) if x == pairs]
            found |= zip(own, ca.vertsplit(self._seen(ca.densify(rows)[own], pairs)), strict=True)
        return ca.vertcat(*(found.get(row, x) for row, x in enumerate(ca.vertsplit(held)))) if found else held

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
        for force in reversed(forces):
            on_level = pairs - {self.shares[x] for x in force.shares}
            value = self._on_level(force.value, on_level) if on_level else self.switches.hold([force.value])[0]
            held = ca.substitute(held, force.symbol, value)
        return held

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
        groups = switches.groups or (0,) * known.v.numel()
        slopes = {x: ca.densify(ca.jacobian(self._rate_of(pair), known.v)) for x, pair in self.shares.items()}
        rows = [(k, group, ca.densify(h)[k]) for h in acting for k, group in enumerate(groups)]
        for k, group, row in rows:
            along = {x: as_expression(slopes[x][k]) for x, pair in self.shares.items()
                     if not switches.reach or group in switches.reach[pair]}
            own.note(switches.numbering.number(as_expression(row)), along)
        return own

    def _rate_of(self, pair: Pair) -> ca.SX:
        return self.switches.values[list(self.switches.places).index(pair)]
