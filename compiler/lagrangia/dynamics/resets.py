"""What an event resets, and how that turns back what comes to where its comparisons change (collisions.py)."""

from collections.abc import Sequence

import casadi as ca
import numpy as np

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.scalars import column, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, operations_in
from lagrangia.constraints.parameters import default_parameters
from lagrangia.dynamics import collisions as meets
from lagrangia.dynamics.arms import Look
from lagrangia.dynamics.collisions import MOVED, STILL, Meeting, Mobility
from lagrangia.dynamics.crossings import crossing_of
from lagrangia.dynamics.levels import Meetings
from lagrangia.dynamics.recognition import parameters_in
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.events import COMPARED, level_of, without_not
from lagrangia.language.flat import When
from lagrangia.language.tree import Binary, Flat


class Resets:
    """Of one event, with the `parts` of its condition, which all have to be true."""

    moving: ca.SX  # what is not the same for ever

    def __init__(self, kinematics: Kinematics, mobility: Mobility, when: When) -> None:
        self.when, self.condition, self.g = when, without_not(when.condition), ca.SX(0)
        self.kinematics, self.mobility, self.meetings = kinematics, mobility, Meetings(kinematics)
        self.positions, self.places = list[Flat](), list[Flat]()  # of what is reset, and for each scalar of it
        self.rates, self.wanted, self.may_rest = list[ca.SX](), list[ca.SX](), list[bool]()  # may_rest: no discrete variable
        self.parts, self.gaps = list[Flat](), list[Flat]()
        self.levels, self.branches = dict[int, ca.SX](), set[int]()  # of what is compared, by identity; parts of what jumps
        self.joined = set[int]()  # of these, what is the least of several
        self.back, self.beside = dict[int, list[Flat]](), list[Flat]()  # where resets turn back, and where as declared alone

    def _expression(self, x: Scalar) -> ca.SX:
        """With der(n) = 0 of discrete variables."""
        tau, at_rest = self.kinematics.symbols.tau, self.meetings.at_rest
        return ca.substitute(ca.SX(x), ca.vertcat(tau, at_rest), ca.vertcat(1, ca.SX.zeros(at_rest.numel())))

    def _pace_of(self, g: ca.SX) -> ca.SX:
        symbols = self.kinematics.symbols
        q, rates = (column(*x.values()) for x in (symbols.positions, symbols.rates))
        (arm,) = self.kinematics.algebra.arms_in_force([g])
        return ca.jtimes(arm, ca.vertcat(q, symbols.time), ca.vertcat(self.kinematics.paced(rates.elements()), 1))

    def _wall_of(self, g: ca.SX, rate: ca.SX) -> tuple[ca.SX, ca.SX]:
        """The rate at which g stays as it is; and all rates, where that is reset to it."""
        v = self.meetings.rates
        own, pace = ca.densify(ca.gradient(rate, v)), self._pace_of(g)
        square = ca.dot(own, own)
        wall = rate - pace * square / ca.dot(ca.gradient(pace, v), own)
        (wall,) = ca.substitute([wall], [v], [v - own * (ca.dot(own, v) / square)])
        return wall, v + own * ((wall - rate) / square)

    def _level_at(self, node: Flat) -> ca.SX:
        if id(node) not in self.levels:
            level = self._expression(self.kinematics.evaluator.value(level_of(node)))
            self.levels[id(node)] = simple = crossing_of(level, self.moving)
            if simple is not level:
                self.branches.add(id(node))
        return self.levels[id(node)]

    def _is_gap(self, node: Flat) -> bool:
        """Whether it compares places; a part of what jumps has to be one comparison, and what is held there a scalar."""
        if not is_comparison(node) or ca.depends_on(level := self._level_at(node), self.meetings.rates):
            return False
        if id(node) not in self.branches:
            return True
        is_one = id(node) in self.joined or operations_in(level).isdisjoint((ca.OP_FMIN, ca.OP_FMAX))
        return len(self.places) == len(self.positions) and is_one

    def _is_timed(self, value: ca.SX) -> bool:
        """Whether time is written in it, whenever it may come to count: a wall may set out after any time that is looked at."""
        return bool(ca.depends_on(value, ca.vertcat(self.kinematics.symbols.time, self.kinematics.algebra.mode_symbols)))

    def _look(self, results: list[ca.SX], wanted: list[ca.SX], crossed: Sequence[ca.SX] = ()) -> Look:
        return Look(self.kinematics, self.meetings.rates, results, wanted, crossed)

    def _look_at(self, nodes: list[Flat], choosing: Sequence[ca.SX] = ()) -> Look:
        """The rates of gaps, of what is reset, what that is reset to, and the slopes of both; with the arms of `choosing`."""
        v = self.meetings.rates
        paces, rates, wanted = (column(*x) for x in (
            [self._pace_of(self._level_at(x)) for x in nodes], self.rates, self.wanted))
        slopes = [ca.densify(ca.jacobian(x, v)) for x in (paces, rates)]
        is_curved = ca.depends_on(slopes[0], column(*self.kinematics.symbols.positions.values()))
        crossed = [column(*map(self._level_at, nodes)), self._along(slopes[1])] if is_curved else []
        return self._look([*map(ca.densify, (paces, rates, wanted)), *slopes], [*choosing, *self.wanted], crossed)

    def _along(self, own: ca.SX) -> ca.SX:
        """(n, r): the changes of positions along the slopes, (r, n), of what is reset."""
        v, rates = self.meetings.rates, self.kinematics.symbols.rates.values()
        moved = self.kinematics.paced(column(*rates).elements())
        return ca.densify(ca.horzcat(*(ca.jtimes(moved, v, own[j, :].T) for j in range(own.shape[0]))))

    def _find_turned(self, nodes: list[Flat]) -> dict[int, tuple[Flat, Meeting, int]]:
        """Of resets that turn back, or do so in some arms, the comparison among `nodes`, which of both, and the sign of the
        factor between its rate and theirs."""
        self.gaps, self.beside, self.back = list[Flat](), list[Flat](), dict[int, list[Flat]]()
        nodes = [x for x in nodes if self._is_gap(x)]
        if not nodes or not any(self.may_rest):
            return {}
        self.gaps, self.look, found = nodes, self._look_at(nodes), dict[int, tuple[Flat, Meeting, int]]()
        self.returning = np.flatnonzero(self.may_rest)
        for j in self.returning.tolist():
            ways = [(node, *self._turned(k, j, node)) for k, node in enumerate(nodes)]
            best = max(ways, key=lambda way: way[1])
            self.back[j] = [node for node, meeting, _ in ways if meeting == Meeting.BACK]
            if best[1] != Meeting.NONE:
                found[j] = best
        return found

    def _always_turns(self, node: Flat) -> bool:
        """Whether one reset is turned back at a comparison in all the branches that it has."""
        if not self._is_gap(node):
            return False
        level = self._level_at(node)
        look = self._look_at([node], [level]).where(self.mobility.bound)
        return any(meets.turned_back(look, 0, j, self._is_timed(level))[0] == Meeting.BACK
                   for j in np.flatnonzero(self.may_rest).tolist())

    def _turned(self, k: int, j: int, node: Flat) -> tuple[Meeting, int]:
        """How reset j is turned back at gap k, `node`: for parameters beside those that are declared, or else as declared."""
        is_timed = self._is_timed(self._level_at(node))
        general = meets.turned_back(self.look.where(self.mobility.bound), k, j, is_timed)
        if general[0] == Meeting.BACK and not meets.is_passed(self.look.where(self.look.declared), k, j):
            return general
        own = meets.turned_back(self.look.where(self.look.declared), k, j, is_timed)
        if own[0] == Meeting.BACK:
            self.beside.append(node)
        return own if general[0] == Meeting.BACK else max(own, general)

    def _wall(self, node: Flat, j: int) -> int:
        """Against what a contact turns a rate back: STILL, MOVED in time, or BODIES that move as they may."""
        found = meets.wall_of(self.look, next(k for k, x in enumerate(self.gaps) if x is node), j)
        is_moved = found == STILL and self._is_timed(self._level_at(node)) and not self._is_timed(self.rates[j])
        return MOVED if is_moved else found

    def _find_collision(self) -> tuple[Flat, Meeting] | None:
        """The comparison at which several that are reset are turned back together, and how."""
        if sum(self.may_rest) < 2:
            return None
        most = [Meeting.CARRIED if id(x) in self.joined else Meeting.BETWEEN for x in self.gaps]  # no impulse goes along several
        found = [(x, min(self._meeting(k), most[k])) for k, x in enumerate(self.gaps)]
        return max((x for x in found if x[1] != Meeting.NONE), key=lambda x: x[1], default=None)

    def _meeting(self, k: int) -> Meeting:
        general, own = (meets.look_at_meeting(self.look.where(x), k, np.flatnonzero(self.may_rest), self.mobility)
                        for x in (self.mobility.bound, self.look.declared))
        return Meeting.AS_DECLARED if own > max(general, Meeting.BACK) else min(general, own)

    def _find_alone(self) -> Flat | None:
        """The comparison at which what is reset would be turned back if all else that moves there stood still."""
        v, (j,) = self.meetings.rates, np.flatnonzero(self.may_rest).tolist()
        own = ca.densify(ca.gradient(self.rates[j], v))
        alone = own * (ca.dot(own, v) / ca.dot(own, own))
        for node in filter(self._is_gap, self.parts):
            pace, rate, wanted = ca.substitute([self._pace_of(self._level_at(node)), self.rates[j], self.wanted[j]], [v], [alone])
            (drift,) = ca.substitute([pace], [v], [ca.SX.zeros(v.numel())])
            slopes = [ca.densify(ca.jacobian(x, v)) for x in (pace, rate)]
            look = self._look([pace - drift, rate, wanted, *slopes], [wanted])
            if meets.turned_back(look.where(self.mobility.bound), 0, 0, self._is_timed(self._level_at(node)))[0] == Meeting.BACK:
                return node
        return None

    def _find_in_some(self) -> Flat | None:
        """The condition, where a reset is turned back in some of the branches that it has."""
        v = self.meetings.rates
        pace, rates, wanted = (ca.densify(column(*x)) for x in ([self._pace_of(self.g)], self.rates, self.wanted))
        slopes = [ca.densify(ca.jacobian(x, v)) for x in (pace, rates)]
        if not (slopes[0].is_zero() or operations_in(self.g).isdisjoint(CORNERS)):
            look = self._look([pace, rates, wanted, *slopes], [self.g, *self.wanted]).where(self.mobility.bound)
            if any(meets.turns_somewhere(look, 0, j) for j in np.flatnonzero(self.may_rest).tolist()):
                return self.condition
        return None

    def _find_flat(self, node: Flat | None) -> Flat | None:
        """What is met, where it changes without a slope at some place, along which nothing is held."""
        k = next((k for k, x in enumerate(self.gaps) if x is node), None)
        if node is None or k is None:
            return None
        look, is_timed = self.look.where(self.mobility.bound), self._is_timed(self._level_at(node))
        return node if any(meets.is_flat(look, k, j, is_timed) for j in np.flatnonzero(self.may_rest).tolist()) else None

    def _felt_parameters(self) -> ca.SX:
        """All of them, numbers but for those that are written in what is compared and reset."""
        model, (symbols, _) = self.kinematics.graph.model, default_parameters(self.kinematics)
        roots = [*(reset.value for reset in self.when.resets), *(level_of(x) for x in self.gaps if id(x) not in self.branches)]
        written, felt = parameters_in(model, roots), symbols_in(ca.veccat(*self.look.expressions))
        names = [v.name for v in model.variables.values() if v.kind == "parameter" for _ in v.elements()]
        return ca.vertcat(ca.SX(0, 1), *(x if name in written and x.__hash__() in felt else number for name, x, number in zip(
            names, symbols.elements(), self.mobility.bound.tolist(), strict=True)))


def is_comparison(node: Flat) -> bool:
    """Whether it is <, <=, > or >=."""
    return isinstance(node, Binary) and node.operator in COMPARED
