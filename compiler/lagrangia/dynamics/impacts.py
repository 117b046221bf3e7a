"""Kinematics -> what happens at events of `when`: impulses that give rates new values, and the forces of what stays in contact.

A reset of the rate of x is an impulse that works on x, as a force does that is infinite for no time,
M dv = sum_j (dx_j/dq)^T L_j, and what holds the scene gives impulses of its own. Where several events come at once their
impulses are found together.

A condition is positive where it is true: g = b - a of a < b. A reset is that of a contact where der(g) = k (der(x) - w), with the
rate w of a wall, and what approaches is turned back or stopped: der(x) = w - e (der(x) - w). What rests there is kept from g > 0
by a force along -g, or on x alone where other bodies are the wall: these are not reset. Where all that meet there are reset as
an impulse between them does it, that is the reset of der(g) (collisions.py).

A rate that is reset to where its condition ends (a pawl, a freewheel: when v < 0 then reinit(v, 0)) may go one way, and is kept
there by a force on x that only pushes.
"""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field, replace
from itertools import accumulate

import casadi as ca

from lagrangia.algebra.duals import Scalar, rate_of, value_of
from lagrangia.algebra.scalars import column, symbol, symbols_in
from lagrangia.algebra.with_casadi import jumps_with, operations_in
from lagrangia.base.diagnostics import fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import parameter_symbols, require_possible
from lagrangia.constraints.rows import Row
from lagrangia.dynamics import collisions as meets
from lagrangia.dynamics.asked_forces import Asking
from lagrangia.dynamics.collisions import BODIES, STILL, Meeting, Mobility
from lagrangia.dynamics.crossings import crossing_of
from lagrangia.dynamics.energies import Load, paced
from lagrangia.dynamics.levels import EDGE, JUMPS, Edge, Levels, Meetings, Steps, least_of, level_of_parts
from lagrangia.dynamics.limits import changes_nothing, side_of
from lagrangia.dynamics.recognition import Comparison, Recognition
from lagrangia.dynamics.resets import Resets, is_comparison
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.consequences import contact_forces_in
from lagrangia.language.events import (
    are_alike,
    comparisons_in,
    condition_of,
    contact_of,
    held_by,
    level_of,
    name_of_contact,
    parts_of,
    position_of,
)
from lagrangia.language.flat import Reset, When, Work
from lagrangia.language.tree import Binary, Call, Flat, Number, Unary

KICK, CONTACT, ONE_WAY = range(3)  # LAG_KICK, ...
_TOLD = ("as_declared", "as_if_still", "unheld", "flat", "recognized", "met")
_NONE = ca.SX(0, 1)


@dataclass(frozen=True)
class Impacts:
    """w conditions and r resets. `places` has for each reset that of its condition, and what it is: CONTACT, ONE_WAY, KICK."""

    conditions: ca.SX = _NONE  # (w,): g, of t, q, v, u, p and modes; of contacts that of all else which has to be true; of
    # those that ask for forces, -1
    gaps: ca.SX = _NONE  # (w,): g of the comparison that is a contact or goes one way, 0 where none is
    arms: ca.SX = _NONE  # (w,): the same gaps, with modes for the arms of max, min and abs that time decides on
    rates: ca.SX = _NONE  # (r,): of what is reset
    wanted: ca.SX = _NONE  # (r,): after the event
    forces: ca.SX = _NONE  # (w,): symbols of the forces along -gaps
    impulses: ca.SX = _NONE  # (r,): symbols of forces on what is reset
    places: tuple[int, ...] = ()
    one_way: tuple[bool, ...] = ()  # (w,): gaps that are rates
    on_level: tuple[int, ...] = ()  # (w,): Meetings.of_rates of each
    known: tuple[bool, ...] = ()  # (r,): whether what is set does not come from the motion, with whose errors
    loads: tuple[Load, ...] = ()
    pressing: Mapping[int, tuple[ca.SX, ca.SX]] = field(default_factory=dict)  # of what rests, by their events: forces, impulses
    alternatives: tuple[Flat | None, ...] = ()  # (w,): beside `or`, a comparison that would be a contact, or go one way, without
    collisions: tuple[tuple[Flat, Meeting] | None, ...] = ()  # (w,): a comparison at which all that meet are turned back, and how
    as_declared: tuple[Flat | None, ...] = ()  # (w,): a comparison that is a contact for parameters as they are declared alone
    as_if_still: tuple[Flat | None, ...] = ()  # (w,): one that would be a contact if what is met there stood still
    unheld: tuple[Flat | None, ...] = ()  # (w,): one that turns back what comes there, and that holds nothing
    flat: tuple[Flat | None, ...] = ()  # (w,): one that turns back, and changes without a slope at some place
    recognized: tuple[list[Comparison], ...] = ()  # (w,): what parameters have to be for it to stay what it is taken for
    met: tuple[Flat | None, ...] = ()  # (w,): the gap of a contact; of what goes one way that of the place
    edge: ca.SX = _NONE  # (0 or 1,): the size of an Edge
    edged: ca.SX = _NONE  # (w,): the conditions with it, where they compare several things that may be held
    are_several: tuple[bool, ...] = ()  # (w,): which do
    loaded: Mapping[int, ca.SX] = field(default_factory=dict, kw_only=True)  # conditions of forces, by events

    def may_hide(self, t: ca.SX) -> bool:
        """Whether conditions may come and go however slow the motion is: with time or forces, or where they jump."""
        is_given = bool(self.loaded) or bool(ca.depends_on(self.conditions, t))
        return is_given or not operations_in(self.conditions).isdisjoint(JUMPS)

    def with_edges(self, events: "Sequence[_Event]") -> "Impacts":
        """With `edge`, `edged` and `are_several`."""
        several, edge = tuple(event.are_several for event in events), symbol("edge")
        edged = column(*(event.with_edge(edge) if some else event.level for some, event in zip(several, events, strict=True)))
        return replace(self, edge=edge, edged=edged, are_several=several) if any(several) else self

    @property
    def of_forces(self) -> ca.SX:
        """The conditions that ask for forces, as a column."""
        return ca.vertcat(_NONE, *self.loaded.values())

    @property
    def may_hold(self) -> bool:
        """Whether something may rest at a contact, or where it goes one way."""
        return any(kind != KICK for kind in self.places[1::2])

    def contacts_of(self, component: str) -> list[Load]:
        """The forces that hold what rests at the contacts of a component."""
        held = symbols_in(self.forces)
        own = (load for load in self.loads if load.statement.component == component)
        return [load for load in own if not held.isdisjoint(symbols_in(ca.SX(load.force[0])))]

    def contact_forces(self) -> dict[str, Scalar]:
        """By the names that the evaluator asks for them; while a way is looked for, with the impulse."""
        return {name_of_contact(k): force + impulse for k, (force, impulse) in self.pressing.items()}

    def gaps_in(self, kinematics: Kinematics) -> dict[int, ca.SX]:
        """Those of what holds what rests, by their events, where positions are others; what jumps is as it is here."""
        value, found, symbols = kinematics.evaluator.value, dict[int, ca.SX](), kinematics.symbols
        for k, node in enumerate(self.met):
            if node is not None:
                g = crossing_of(ca.SX(value(node)), column(*symbols.positions.values(), *symbols.rates.values()))
                found[k] = g if operations_in(g).isdisjoint(JUMPS) else self.gaps[k]
        return found

    def loads_in(self, kinematics: Kinematics) -> tuple[Load, ...]:
        """The same where positions are others."""
        value = kinematics.evaluator.value
        return tuple(paced(Load(x.force, tuple(scalars_of(value(x.statement.position))), x.statement), kinematics)
                     for x in self.loads)


def find_impacts(kinematics: Kinematics, kinetic: ca.SX, rows: Sequence[Row]) -> Impacts:
    """Of the kinetic energy and the rows of constraints. Raises LagError L0225 for a condition that never comes true, or for what
    is no rate, L0226, L0230, L0303, L0501."""
    whens = kinematics.graph.model.whens
    if not whens:
        return Impacts()
    asking = Asking(kinematics)
    steps, mobility = Steps(kinematics), Mobility(kinematics, Meetings(kinematics).rates, kinetic, rows)
    found = [_Event(kinematics, when, steps, mobility, asking) for when in whens]
    kept = [event.kept_position for event in found]
    for asked in contact_forces_in(kinematics.graph.model, has_events=True):
        event = contact_of(kept, asked.arguments[0])
        if event is not None and (found[event].kept is None or ONE_WAY in found[event].kinds):
            require_possible(kinematics)  # along a direction of no length nothing is a contact
            fail("L0226", "this event is no contact, whose force is asked for", whens[event].span,
                 "a contact turns what approaches back, or stops it: reinit(der(x), -e*pre(der(x))) with e >= 0")
    places = [(k, kind) for k, event in enumerate(found) for kind in event.kinds]
    forces, impulses = ca.SX.sym("contact", len(found)), ca.SX.sym("impulse", len(places))
    strengths = iter(impulses.elements())
    loads = [load for event, force in zip(found, forces.elements(), strict=True) for load in event.loads(force, strengths)]
    conditions, gaps, arms, rates, wanted = (column(*parts) for parts in (
        [event.level for event in found],
        [event.gap for event in found], [event.arm for event in found],
        [x for event in found for x in event.rates],
        [x for event in found for x in event.wanted]))
    flags = tuple(x for pair in places for x in pair)
    firsts = accumulate((len(event.kinds) for event in found), initial=0)
    pressing = {k: (forces[k], impulses[first + event.kept])
                for k, (event, first) in enumerate(zip(found, firsts, strict=False)) if event.kept is not None}
    one_way = tuple(ONE_WAY in event.kinds for event in found)
    on_level = tuple(-1 if event.is_loaded else event.meetings.of_rates() for event in found)
    known = _find_known(kinematics, rates, wanted)
    alternatives = tuple(event.alternative for event in found)
    loaded = asking.told({k: event.g for k, event in enumerate(found) if event.is_loaded}, pressing)
    impacts = Impacts(conditions, gaps, arms, rates, wanted, forces, impulses, flags, one_way, on_level, known, tuple(loads),
                      pressing, alternatives, tuple(event.collision for event in found),
                      *(tuple(getattr(event, name) for event in found) for name in _TOLD))
    return replace(impacts, loaded=loaded).with_edges(found)


def _find_known(kinematics: Kinematics, rates: ca.SX, wanted: ca.SX) -> tuple[bool, ...]:
    """Of each reset whether it sets a discrete variable, which may keep what it reads, or sets something to what follows from
    parameters, and from such discrete variables as are only set to that."""
    kept = {state.coordinate for state in kinematics.graph.model.states.values() if state.is_kept}
    discrete = {symbols_in(kinematics.symbols.rates[name]) for name in kept}
    found = [(symbols_in(x), symbols_in(value)) for x, value in zip(rates.elements(), wanted.elements(), strict=True)]
    known = symbols_in(parameter_symbols(kinematics)).union(*discrete)
    while moved := {x for own, value in found if own in discrete and not value <= known for x in own & known}:
        known -= moved
    return tuple(own in discrete or value <= known for own, value in found)


class _Event(Resets):
    """One `when`, evaluated."""

    def __init__(self, kinematics: Kinematics, when: When, steps: Steps, mobility: Mobility, asking: Asking) -> None:
        super().__init__(kinematics, mobility, when)
        self.steps, self.asking, self.is_loaded, model = steps, asking, asking.asks(when.condition), kinematics.graph.model
        self.moving = ca.vertcat(kinematics.symbols.time, kinematics.algebra.state, *kinematics.symbols.held.values())
        self.moving = ca.vertcat(self.moving, asking.forces_in(self.condition))
        g = self._level(self.condition)
        self.g = g if ca.depends_on(g, self.moving) else ca.fmax(ca.fmin(g, 1), -1)
        self.positions = [position_of(reset, model) for reset in when.resets]
        for reset, position in zip(when.resets, self.positions, strict=True):
            self._add(reset, position)
        self._check()
        self.kept_position = held_by(model, when)
        kept = next((k for k, x in enumerate(self.places) if are_alike(x, self.kept_position)), None)
        self.gap = self.arm = ca.SX(0)
        self.held: Flat | None = None
        self.met: Flat | None = None
        self.struck = list[tuple[Flat, ca.SX]]()  # what meets, and its shares in the rate of a gap along which no impulse goes
        self.sense, self.is_sided = ca.SX(1), False  # whether the force is along what is reset by a side that is found
        self.condition = condition_of(when, model)
        self.parts = self._find_parts()
        contacts, self.collision = self._find_contacts()
        self.flat = self._find_flat(next((x for x in contacts if x is not None), self.collision and self.collision[0]))
        if self.collision is not None and self.collision[1] > Meeting.BACK:
            kept, contacts = None, self._strike(self.collision[0])
        limits = [] if any(contacts) else self._find_limits(self.parts)
        kind, found = (ONE_WAY, limits) if any(limits) else (CONTACT, contacts)
        chosen = next((x for x in (found[kept] if kept is not None else None, *found) if x is not None), None)
        self.kinds = [kind if chosen is not None and x is chosen else KICK for x in found]
        self.kept = kept if kept is not None and self.kinds[kept] != KICK else None  # whose contact force may be asked for
        if chosen is not None and self.is_loaded:
            fail("L0914", "not supported yet: a contact that a force ends", self.when.condition.span.within(self.when.span),
                 "let an event remember it, by a discrete Boolean: when norm(hinge.reaction) > 25 then torn = true; end when",
                 "and the contact is: when x < 0 and not torn then ...")
        if chosen is not None:
            self._divide(chosen, kind)
            self.met = level_of(chosen)
            self._ride()
        elif is_comparison(self.condition):
            self._require_change()
        self._find_what_is_told(chosen, found)

    @property
    def level(self) -> ca.SX:
        """Its condition; never so of one that asks for forces, which is told apart."""
        return ca.SX(-1) if self.is_loaded else self.g

    def _find_what_is_told(self, chosen: Flat | None, found: Sequence[Flat | None]) -> None:
        """What people may take for a contact, and is none."""
        is_kick = chosen is None and self.collision is None
        turning = [node for nodes in self.back.values() for node in nodes]
        self.as_declared = chosen if any(x is chosen for x in self.beside) and self.collision is None else None
        self.unheld = None if chosen is None else next((x for x in turning if x is not chosen), None)
        held = [x if kind == CONTACT else None for kind, x in zip(self.kinds, found, strict=True)]
        self.recognized = self._find_recognized(held)
        self.alternative = self._find_alternative() if chosen is None else None
        self.as_if_still = self._find_alone() if is_kick and sum(self.may_rest) == 1 else None
        if is_kick and self.alternative is None and self.as_if_still is None:
            self.unheld = self._find_in_some()

    def _find_recognized(self, contacts: Sequence[Flat | None]) -> list[Comparison]:
        """What parameters have to be where resets are those of `contacts`, at which comparisons, and all others are none, as was
        found for these."""
        collision, found = self.collision, list[Comparison]()
        if not self.gaps:
            return found
        recognition = Recognition(self.look, self._felt_parameters(), self.mobility.bound)
        for k, node in enumerate(self.gaps if recognition.symbols else []):
            if collision is not None and collision[1] > Meeting.BACK:
                is_declared = collision[1] == Meeting.AS_DECLARED
                if collision[0] is node:
                    found += recognition.stays_collision(k, self.returning, self.mobility, is_declared)
                continue
            is_timed = self._is_timed(self._level_at(node))
            for j in self.returning.tolist():
                if contacts[j] is node:
                    found += recognition.stays_contact(k, j, is_timed, self.walls[j][1] if self.is_sided else 0)
                elif all(x is not node for x in self.back.get(j, [])):
                    kick = recognition.stays_kick(k, j, is_timed)
                    found += kick if kick and self._may_hold(k, j) else []
            if self.returning.size > 1 and collision is None:
                found += recognition.stays_apart(k, self.returning, self.mobility)
        return recognition.as_declared(found)

    def _find_parts(self) -> list[Flat]:
        """What all has to be true; of comparisons that jump where something moves, the comparisons that these are made of."""
        found, q = list[Flat](), column(*self.kinematics.symbols.positions.values())
        for node in parts_of(self.condition):
            if self.asking.asks(node):
                continue
            is_apart = isinstance(node, Binary) and is_comparison(node) and jumps_with(self._level_at(node), q)
            if not is_apart or self._always_turns(node):
                found.append(node)
                continue
            for level in least_of(self._level(node)):
                found.append(replace(node))
                self.levels[id(found[-1])] = level
                self.branches.add(id(found[-1]))
        return found

    def _join(self) -> None:
        """Where several parts turn the same rate back, as both sides of an obstacle do, they are one contact; but where its force
        rubs, whose impulses have the sense of one side."""
        several, own = next((x for x in self.back.values() if len(x) > 1), []), self.kept_position
        asked = (x.arguments[0] for x in contact_forces_in(self.kinematics.graph.model))
        if several and own is not None and any(are_alike(own, x) for x in asked):
            (x,) = scalars_of(self.kinematics.evaluator.value(own))
            self.parts.sort(key=lambda node: not (is_comparison(node) and self._expression(x + self._level_at(node)).is_zero()))
            self.turned = self._find_turned(self.parts)
        elif several:
            span = several[0].span
            least: Flat = Binary(">", Call("min", tuple(map(level_of, several)), (), span), Number(0.0, None, span), span)
            if any(id(x) in self.branches for x in several):
                self.levels[id(least)] = ca.mmin(ca.vertcat(*map(self._level_at, several)))
                self.branches.add(id(least))
                self.joined.add(id(least))
            self.parts = [*(x for x in self.parts if all(x is not own for own in several)), least]
            self.turned = self._find_turned(self.parts)

    def _level(self, node: Flat) -> ca.SX:
        """Positive where a condition is true, else 0 or negative."""
        return level_of_parts(node, self._level_of_part)

    @property
    def are_several(self) -> bool:
        """Whether it is no contact, and compares several things that may be held."""
        is_kick = all(kind == KICK for kind in self.kinds) and not self.struck
        return is_kick and not self.is_loaded and self.meetings.are_several()

    def with_edge(self, size: ca.SX) -> ca.SX:
        """The level of such a condition where comparisons have an edge of that size."""
        moving = column(*self.kinematics.symbols.positions.values(), *self.meetings.rates.elements())
        edge = Edge(size, moving)
        return level_of_parts(self.condition, lambda node: self._level_of_part(node, edge))

    def _level_of_part(self, node: Flat, edge: Edge | None = None) -> ca.SX:
        value, level = self.asking.kinematics.evaluator.value, level_of(node)
        g = crossing_of(self._expression(value(level)), self.moving)
        truth = self._expression(value(node)) if is_comparison(node) else g
        if edge is None:
            self.meetings.note(node, g)
        goes_on = ca.depends_on(g, self.moving) and operations_in(g).isdisjoint(JUMPS)
        if goes_on or self.steps.decide(g) or not is_comparison(node):
            return self.steps.level(node, g, edge)
        found = Levels(self.steps.beside(self.moving), edge=EDGE, beside=edge).of(truth)
        if found is None:
            fail("L0225", "this comes true where something in it jumps, in a way that is not taken apart",
                 node.span.within(self.when.span), "compare with <, <=, > or >= in it, not with == or <>; and join conditions "
                 "with and, or, not, as x > 0 and x < 1")
        return found

    def _add(self, reset: Reset, position: Flat) -> None:
        evaluator = self.kinematics.evaluator
        moving, wanted = scalars_of(evaluator.value(position, 1)), scalars_of(evaluator.value(reset.value))
        if len(moving) != len(wanted):
            fail("L0303", f"{_counted(len(wanted))} for {_counted(len(moving))}", reset.span)
        self.places += [position] * len(moving)
        self.may_rest += [not reset.is_kept] * len(moving)
        in_force = self.kinematics.algebra.arms_in_force
        self.rates += in_force([self._expression(value_of(rate_of(x))) for x in moving])
        self.wanted += in_force([self._expression(x) for x in wanted])

    def _check(self) -> None:
        symbols, rates = self.kinematics.symbols, column(*self.rates)
        accelerations = column(*symbols.accelerations.values())
        known = ca.vertcat(self.kinematics.algebra.state, symbols.time, self.kinematics.algebra.mode_symbols,
                           self.asking.forces_in(self.condition))
        if not ca.depends_on(self.g, known):
            fail("L0225", "this is true or false for good, and no event", self.when.condition.span.within(self.when.span),
                 "compare what moves, as x < 0")
        if ca.depends_on(ca.vertcat(self.g, *self.wanted), accelerations):
            fail("L0501", "an event cannot depend on accelerations", self.when.span)
        for reset, rate in zip(self.when.resets, rates.elements(), strict=False):
            if not ca.depends_on(rate, column(*symbols.rates.values())):
                fail("L0225", "this is given in time, and cannot be reset", reset.rate.span.within(reset.span),
                     "name a rate that the motion decides")

    def loads(self, force: ca.SX, impulses: Iterator[ca.SX]) -> Iterator[Load]:
        """`force` along the gap where there is a contact, and a force for each reset."""
        value, component, span = self.kinematics.evaluator.value, self.when.component, self.when.span
        unit, impulse = Number(1.0, None, span), next(impulses) if self.struck else ca.SX(0)
        held = [(self.held, self.sense)] if self.held is not None else [(x, -share) for x, share in self.struck]
        for position, sense in held:
            load = Load((force * sense,), tuple(scalars_of(value(position))), Work(unit, position, component, span))
            yield paced(load, self.kinematics)
        for position, share in self.struck:
            yield Load((impulse * share,), tuple(scalars_of(value(position))), Work(unit, position, component, span))
        for position in self.positions[bool(self.struck):]:
            moved = tuple(scalars_of(value(position)))
            yield Load(tuple(next(impulses) for _ in moved), moved, Work(unit, position, component, span))

    def _divide(self, chosen: Flat, kind: int) -> None:
        """The condition into what was chosen, and what else has to be true; and along what a force holds what rests."""
        guards = [self._level_at(x) if id(x) in self.branches else self._level(x) for x in self.parts if x is not chosen]
        self.gap = self._level_at(chosen)
        (self.arm,) = self.kinematics.algebra.arms_in_force([self.gap])
        self.g = ca.mmin(ca.vertcat(*guards)) if guards else ca.SX(1)
        if self.struck:
            return
        own = next(k for k, x in enumerate(self.kinds) if x == kind)
        closing = self._closing(own)
        is_met = kind == CONTACT and ca.depends_on(closing, column(*self.kinematics.symbols.positions.values()))
        if kind == CONTACT and self.walls[own][0] != BODIES and id(chosen) not in self.branches:
            self.held = Unary("-", level_of(chosen), self.when.span)
            return
        if is_met:
            self.held, self.sense = self.places[own], closing  # that of the side that is met
            return
        is_least = (self.walls[own][1] if kind == CONTACT else self._stops(self.gap, self.rates[own], self.wanted[own])) < 0
        self.held, self.is_sided = self.places[own] if is_least else Unary("-", self.places[own], self.when.span), True

    def _closing(self, k: int) -> ca.SX:
        """How fast the gap closes, as a multiple of the rate that is reset."""
        slope, along = (ca.densify(ca.gradient(x, self.meetings.rates)) for x in (self._pace_of(self.gap), self.rates[k]))
        return -ca.dot(slope, along) / ca.dot(along, along)

    def _find_contacts(self) -> tuple[list[Flat | None], tuple[Flat, Meeting] | None]:
        """Of each reset the comparison at which it is one of a contact; where there is none, a comparison at which all that meet
        are turned back together, or at which some are, but nothing is held, and how."""
        self.turned = self._find_turned(self.parts)
        self._join()
        turned = self.turned
        self.walls = {j: (self._wall(node, j), side) for j, (node, meeting, side) in turned.items() if meeting == Meeting.BACK}
        contacts = [turned[k][0] if k in self.walls and self._is_free(k, turned[k][0], self.walls[k]) else None
                    for k in range(len(self.rates))]
        if any(contacts):
            return contacts, None
        parted = ((node, Meeting.IN_SOME if k not in self.walls else Meeting.CARRIED) for k, (node, *_) in turned.items())
        return contacts, self._find_collision() or next(parted, None)

    def _is_free(self, k: int, node: Flat, wall: tuple[int, int]) -> bool:
        """Whether neither reset k, which is turned back at `node`, changes the rate of the wall, nor others of the event."""
        if wall[1] == 0 and id(node) in self.branches - self.joined:
            return False
        if wall[0] != BODIES:
            return True
        v, met = self.meetings.rates, self._wall_of(self._level_at(node), self.rates[k])[0]
        moving = symbols_in(met) & symbols_in(v)
        if not all(moving.isdisjoint(symbols_in(rate)) for j, rate in enumerate(self.rates) if j != k):
            return False
        return not meets.is_carried(self._look([ca.densify(ca.gradient(x, v)) for x in (met, self.rates[k])], []), self.mobility)

    def _may_hold(self, k: int, j: int) -> bool:
        """Whether reset j would be one of a contact if it were turned back at gap k."""
        return self._is_free(j, self.gaps[k], (meets.wall_of(self.look, k, j), 1))

    def _ride(self) -> None:
        """Of contacts whose wall moves: rates, and what these are reset to, as they are seen from it."""
        for k, (rate, wanted) in enumerate(zip(self.rates, self.wanted, strict=True)):
            if self.kinds[k] == CONTACT and self.walls[k][0] != STILL:
                wall, riding = self._wall_of(self.gap, rate)
                self.rates[k], self.wanted[k] = rate - wall, wanted - ca.substitute(wanted, self.meetings.rates, riding)

    def _strike(self, node: Flat) -> list[Flat | None]:
        """The reset of the rate of the gap in the place of those of what meets there; returns of each reset whether it is one."""
        moving, others = ([k for k, x in enumerate(self.may_rest) if x == is_moving] for is_moving in (True, False))
        pace = self._pace_of(self._level_at(node))
        rates, wanted = (ca.vertcat(*(x[k] for k in moving)) for x in (self.rates, self.wanted))
        shares = meets.shares_of(pace, rates, self.meetings.rates)
        after = pace + ca.dot(shares, wanted - rates)
        if id(node) in self.branches:
            self.struck = [(self.places[k], share) for k, share in zip(moving, shares.elements(), strict=True)]
        kept = [x for reset, x in zip(self.when.resets, self.positions, strict=True) if reset.is_kept]
        self.positions, self.places = [level_of(node), *kept], [level_of(node), *(self.places[k] for k in others)]
        self.rates, self.wanted = [pace, *(self.rates[k] for k in others)], [after, *(self.wanted[k] for k in others)]
        self.may_rest, self.walls = [True] + [False] * len(others), {0: (STILL, 1)}
        return [node] + [None] * len(others)

    def _find_alternative(self) -> Flat | None:
        """Where some parts are alternatives: a comparison in one at which a reset would hold."""
        among = [x for part in self.parts if not is_comparison(part) for x in comparisons_in(part)]
        turned = (node for node, meeting, _ in self._find_turned(among).values() if meeting == Meeting.BACK)
        return next(turned, None) or next((end for end in self._find_limits(among) if end is not None), None)

    def _find_limits(self, nodes: list[Flat]) -> list[Flat | None]:
        """Of each reset the comparison among `nodes` at which it leaves its rate."""
        value = self.kinematics.evaluator.value
        parts = [(node, self._expression(value(level_of(node)))) for node in nodes if is_comparison(node)]
        return [next((node for node, g in parts if may_rest and self._stops(g, rate, wanted)), None)
                for rate, wanted, may_rest in zip(self.rates, self.wanted, self.may_rest, strict=True)]

    def _stops(self, g: ca.SX, rate: ca.SX, wanted: ca.SX) -> int:
        """On which side of what the rate is reset to g is positive: 1 above, -1 below, 0 if it does not end there. By numbers."""
        v = self.meetings.rates
        if not ca.depends_on(g, v) or len(self.places) != len(self.positions):
            return 0
        slopes = [ca.densify(ca.gradient(x, v)) for x in (g, rate - wanted, rate, wanted)]
        return side_of(self._look([g, rate - wanted, *slopes], [wanted]))

    def _require_change(self) -> None:
        """A rate comes to the place where its condition changes without a jump: there, it has to be set to something else."""
        v = self.meetings.rates
        if len(self.rates) != len(self.when.resets):
            return
        for reset, rate, wanted in zip(self.when.resets, self.rates, self.wanted, strict=True):
            if reset.is_kept or not ca.depends_on(self.g, v):
                continue
            slopes = [ca.densify(ca.gradient(x, v)) for x in (self.g, rate)]
            if changes_nothing(self._look([self.g, rate - wanted, *slopes], [wanted])):
                text = reset.rate.span.text
                fail("L0230", f"this changes nothing: where the event comes, '{text}' is what it is set to", reset.span,
                     f"to keep '{text}' from going on, set it to the value at which it is to stay: reinit({text}, 0)",
                     "a collision is told by a distance: when gap < 0 then reinit(der(gap), -e*pre(der(gap)))")


def _counted(n: int) -> str:
    return "one value" if n == 1 else f"{n} values"

