"""For which parameters an event is what it was taken for when its scene was compiled, a contact or a kick: comparisons of these.

What collisions.py sees at random states by numbers is written out for the same states as expressions of the parameters. What is
equal for parameters beside those that are declared is so for all, but where parameters choose between branches.
"""

from collections.abc import Iterable, Iterator, Sequence
from itertools import islice, product

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import as_expression, symbols_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.arms import SAME, SIZES, SPEEDS, Look
from lagrangia.dynamics.collisions import SPREAD, Mobility
from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import children
from lagrangia.language.tree import Call, Flat, Ref

_FEW = 2  # of the random states that are looked at
_TIMES = np.concatenate((np.geomspace(1e-6, 1e4, 41), np.linspace(0.5, 20, 40)))  # at which parameters choose with time
_FINITE = 1e300
_LOOKS = 3  # sets of parameters for which comparisons are told apart


@dataclass(frozen=True)
class Comparison:
    """1 where it holds and else 0, of all parameters; `makes`: where it does not, the event becomes a contact, else it ceases to
    be one."""

    holds: ca.SX
    makes: bool


_Part = tuple[ca.SX, ca.SX]  # whether it counts, and what is 0 or more where it holds


@dataclass(frozen=True)
class _State:
    """Where a reset is looked at: all else that is known, the arm, and whether that can be there."""

    known: ca.SX
    arm: ca.SX
    exists: ca.SX


@dataclass(frozen=True)
class _Approach:
    """Rates that go with the wall, others that approach it, whether there are such, and whether both are in the same arm."""

    still: ca.SX
    turned: ca.SX
    exists: ca.SX
    is_both: ca.SX


class Recognition:
    """Of gaps and resets that are looked at with `look`, whose parameters `p` are expressions, beside `bound`, numbers."""

    def __init__(self, look: Look, p: ca.SX, bound: Vector) -> None:
        self.look, self.p, self.bound = look.where(bound, look.declared), p, bound
        self.look.seeds = look.seeds[:_FEW]
        self.symbols, every = symbols_in(p), self.look.inputs[2]
        self.masses = every if self.symbols else p  # what gives these follows from what is written, under names of its own

    # ------------------------------------------------------------ one reset

    def stays_contact(self, k: int, j: int, is_timed: bool, side: int) -> list[Comparison]:
        """Of reset j that is turned back at gap k, where `side` is not 0 from that side."""
        found = (parts for ways in self._turns(k, j, is_timed, side) for parts in ways)
        return self._all_hold([(exists, x) for exists, acts, left, back in found for x in (acts, left, back)])

    def stays_kick(self, k: int, j: int, is_timed: bool) -> list[Comparison]:
        """Of reset j that is not turned back at gap k."""
        parts = list[_Part]()
        for ways in self._turns(k, j, is_timed, 0):
            for exists, *own in ways:
                if any(self._never(exists, x) for x in own):
                    return []
                parts += [(exists, x) for x in own]
        return self._not_all_hold(parts)

    def _turns(self, k: int, j: int, is_timed: bool, side: int) -> Iterator[Iterator[tuple[ca.SX, ca.SX, ca.SX, ca.SX]]]:
        """Of each state and arm whether it can be, and what is 0 or more where the reset acts along the gap, leaves what goes
        with the wall, and turns back what approaches."""
        look = self.look
        for v, known in islice(look.places((1, SPREAD) if is_timed else (1,)), _FEW):
            places = [place for place, has_slope in look.crossings(k, j, known) if has_slope]
            for state in self._states(known):
                is_level = look.crossed is not None and not look.at(v, known, np.zeros(len(look.differences)))[3][k].any()
                for place in [*([] if is_level else [known]), *places]:
                    there = ca.SX(place)
                    there[look.time] = state.known[look.time]
                    yield self._turned(k, j, ca.SX(v), _State(there, state.arm, state.exists), side)

    def _turned(self, k: int, j: int, v: ca.SX, state: _State, side: int) -> Iterator[tuple[ca.SX, ca.SX, ca.SX, ca.SX]]:
        def at(v: ca.SX) -> list[ca.SX]:
            paces, rates, wanted, slopes, own = self._at(v, state)
            return [ca.vec(paces)[k], ca.vec(rates)[j], ca.vec(wanted)[j], slopes[k, :].T, own[j, :].T]

        pace, rate, _, slope, own = at(v)
        along, square = ca.dot(slope, own), ca.dot(own, own)
        sign = side or ca.sign(along)
        acts = (along * side if side else ca.fabs(along)) / (ca.norm_2(slope) * ca.norm_2(own)) - SAME
        for way in self._approaches(v, own * (sign / square), pace, slope, state):
            (_, wall, left, *_), (_, _, back, *_) = at(way.still), at(way.turned)
            size = SAME * (ca.dot(ca.fabs(own), ca.fabs(way.turned)) + ca.fabs(rate) + ca.fabs(wall))
            exists = _all(state.exists, way.exists, _is_finite(pace, rate, slope, own),
                          _is_finite(wall, back) if state.arm.numel() else ca.SX(1))
            yield exists, acts, ca.if_else(way.is_both, size - ca.fabs(left - wall), 0), size - (back - wall) * sign

    # ------------------------------------------------------------ several

    def stays_collision(self, k: int, own: NDArray[np.intp], mobility: Mobility, is_declared: bool) -> list[Comparison]:
        """Of the resets `own` that turn back together what meets at gap k, by an impulse between these for parameters as they are
        declared, where it `is_declared`, or for all."""
        is_asked = is_declared or any(self.look.by_parameters)
        return self._all_hold([(exists, x) for exists, closes, *between in self._meets(k, own, mobility)
                               for x in (closes, *(between if is_asked else ()))])

    def stays_apart(self, k: int, own: NDArray[np.intp], mobility: Mobility) -> list[Comparison]:
        """Of those that would do so, but for what approaches there."""
        usual = Recognition(self.look, ca.SX(self.bound), self.bound)
        here = [float(x) for _, _, *between in usual._meets(k, own, mobility) for x in between]
        if not here or not all(x >= 0 for x in here):
            return []
        return self._not_all_hold([(exists, closes) for exists, closes, *_ in self._meets(k, own, mobility)])

    def _meets(self, k: int, own: NDArray[np.intp], mobility: Mobility) -> Iterator[tuple[ca.SX, ...]]:
        """Of each state and arm whether it can be, and what is 0 or more where what approaches is turned back, what goes along is
        left, and that is done by an impulse between these, of all that moves the gap."""
        places = own.tolist()
        for numbers, known in islice(self.look.places((1,)), _FEW):
            R0 = self.look.at(numbers, known, np.zeros(len(self.look.differences)))[4][own]
            if not (np.isfinite(R0).all() and np.linalg.matrix_rank(R0) == len(R0)):
                return
            for state in self._states(known):
                def at(v: ca.SX, state: _State = state) -> list[ca.SX]:
                    paces, r, w, slopes, R = self._at(v, state)
                    return [ca.vec(paces)[k], ca.vec(r)[places], ca.vec(w)[places], slopes[k, :].T, R[places, :]]

                v = ca.SX(numbers)
                pace, r, _, s, R = at(v)
                c = ca.solve(R @ R.T, R @ s)
                along = R.T @ c
                way = R @ mobility.moved_by(v, state.known[: self.look.time + 1], self.masses, along)
                for how in self._approaches(v, s / ca.dot(s, s), pace, s, state):
                    (_, rest, left, *_), (fast, before, after, *_) = at(how.still), at(how.turned)
                    change, size = after - before, SAME * (ca.fabs(R) @ ca.fabs(how.turned) + ca.fabs(before))
                    off = change - way * (ca.dot(c, change) / ca.dot(c, way))
                    yield (_all(state.exists, how.exists, _is_finite(pace, r, s, R), _is_finite(change)),
                           SAME * fast - fast - ca.dot(c, change),
                           ca.if_else(how.is_both, ca.mmin(size - ca.fabs(left - rest)), 0),
                           SAME * ca.norm_2(s) - ca.norm_2(along - s), SAME * ca.norm_2(change) - ca.norm_2(off))

    # ------------------------------------------------------------ parts

    def as_declared(self, comparisons: list[Comparison]) -> list[Comparison]:
        """Those that hold for parameters as they are declared: no others say anything of these."""
        if not comparisons:
            return []
        own = ca.Function("own", [self.look.inputs[2]], [ca.vertcat(*(x.holds for x in comparisons))])(self.look.declared)
        return [x for x, holds in zip(comparisons, np.array(own).ravel(), strict=True) if holds]

    def _never(self, exists: ca.SX, x: ca.SX) -> bool:
        """Whether it counts, and does not hold, for all parameters."""
        return exists.is_constant() and x.is_constant() and bool(float(exists)) and not float(x) >= 0

    def _all_hold(self, parts: list[_Part]) -> list[Comparison]:
        found = (Comparison(_implied(*part), False) for part in self._distinct(parts))
        return [x for x in found if not x.holds.is_constant()]

    def _not_all_hold(self, parts: list[_Part]) -> list[Comparison]:
        """That, and that some count; nothing where they never do, whatever the parameters are."""
        if not parts:
            return []
        own = self._distinct(parts)
        counts = [exists for exists, _ in parts]
        some = ca.SX(1) if any(x.is_constant() and float(x) for x in counts) else _not(_all(*map(_not, counts)))
        holds = _not(_all(some, *(_implied(*part) for part in own)))
        return [Comparison(holds, True)] if not holds.is_constant() else []

    def _distinct(self, parts: list[_Part]) -> list[_Part]:
        """Those that parameters decide, each once."""
        symbols, random = self.look.inputs[2], np.random.default_rng(5)
        moving = [x for x in parts if not symbols_in(symbols).isdisjoint(symbols_in(ca.vertcat(*x)))]
        if len(moving) < 2:
            return moving
        near = self.bound[:, None] * random.uniform(-1.6, 1.6, (self.bound.size, _LOOKS))
        values = np.array(ca.Function("values", [symbols], [ca.vertcat(*(ca.vertcat(*x) for x in moving))])(near))
        known = {(*np.round(pair.ravel(), 9).tolist(),): n for n, pair in reversed([*enumerate(values.reshape(len(moving), -1))])}
        return [moving[n] for n in sorted(known.values())]

    # ------------------------------------------------------------ states, arms, approaches

    def _at(self, v: ca.SX, state: _State) -> list[ca.SX]:
        found: Sequence[ca.SX] = self.look.look(v, state.known, self.p, state.arm)
        return [ca.SX(x) for x in found]

    def _states(self, known: Vector) -> Iterator[_State]:
        """In all arms, where what parameters choose is an expression of these."""
        look = self.look
        chosen = [k for k, is_chosen in enumerate(look.by_parameters) if is_chosen]
        timed = [k for k, is_timed in enumerate(look.by_time) if is_timed and k not in chosen]
        if any(self._depends(look.differences[k]) for k in timed):
            yield from self._timed_states(known, chosen, timed)
            return
        for place, numbers in look.arms(known):
            arm = ca.SX(numbers)
            for k in chosen:
                arm[k] = self._is_true(k, ca.SX(place), arm)
            yield _State(ca.SX(place), arm, ca.SX(1))

    def _timed_states(self, known: Vector, chosen: list[int], timed: list[int]) -> Iterator[_State]:
        """Where times at which arms are there depend on parameters."""
        for free, case in self.look.free_arms():
            first = ca.SX.zeros(len(self.look.differences))
            first[free.tolist()] = ca.SX([*case])
            for k in chosen:
                first[k] = self._is_true(k, ca.SX(known), first)
            for bits in product((0.0, 1.0), repeat=len(timed)):
                arm, exists, time = ca.SX(first), ca.SX(0), ca.SX(known[self.look.time])
                for k, bit in zip(timed, bits, strict=True):
                    arm[k] = bit
                for moment in _TIMES[::-1]:
                    there = ca.SX(known)
                    there[self.look.time] = moment
                    is_it = _all(*(self._is_true(k, there, arm) == arm[k] for k in timed))
                    exists, time = _either(exists, is_it), ca.if_else(is_it, moment, time)
                place = ca.SX(known)
                place[self.look.time] = time
                yield _State(place, arm, exists)

    def _is_true(self, k: int, known: ca.SX, arm: ca.SX) -> ca.SX:
        return self.look.is_true(k, self._beyond(ca.SX.ones(self.look.inputs[0].numel()), known, arm)[k])

    def _beyond(self, v: ca.SX, known: ca.SX, arm: ca.SX) -> ca.SX:
        assert self.look.beyond is not None
        return ca.SX(self.look.beyond(v, known, self.p, arm))

    def _depends(self, x: ca.SX) -> bool:
        return not self.symbols.isdisjoint(symbols_in(x))

    def _approaches(self, v: ca.SX, step: ca.SX, pace: ca.SX, slope: ca.SX, state: _State) -> Iterator[_Approach]:
        """As Look.approaches says, at the first speed at which the arm is chosen."""
        still, by = v - step * (pace / ca.dot(slope, step)), [k for k, x in enumerate(self.look.by_rates) if x]
        if self.look.beyond is None or not by:
            yield _Approach(still, still + step, ca.SX(1), ca.SX(1))
            return
        seen = set[tuple[float, ...]]()
        for size in SIZES:
            still = size * v - step * ((pace + ca.dot(slope, size * v - v)) / ca.dot(slope, step))
            numbers = tuple(np.round(np.array(self._here(still)).ravel(), 9).tolist())
            if numbers in seen:
                continue
            seen.add(numbers)
            exists, speed, most = ca.SX(0), ca.SX(SPEEDS[0]), ca.SX(0)
            for fast in SPEEDS[::-1]:
                beyond = self._beyond(still + fast * step, state.known, state.arm)
                is_it = _all(*(self.look.is_true(k, beyond[k]) == state.arm[k] for k in by))
                exists, speed = _either(exists, is_it), ca.if_else(is_it, fast, speed)
                most = ca.fmax(most, ca.fabs(beyond[by]))
            beyond = self._beyond(still, state.known, state.arm)
            is_both = _all(*(_either(self.look.is_true(k, beyond[k]) == state.arm[k], ca.fabs(beyond[k]) <= SAME * most[n])
                             for n, k in enumerate(by)))
            yield _Approach(still, still + speed * step, exists, is_both)

    def _here(self, x: ca.SX) -> ca.DM:
        return ca.evalf(ca.substitute(x, self.look.inputs[2], ca.SX(self.bound)))


def parameters_in(model: FlatModel, roots: Iterable[Flat]) -> frozenset[str]:
    """The parameters that are written in expressions, or in variables in them; but those that only rates, der(...), are of."""
    return frozenset(name for name in _names(model, roots) if model.variables[name].kind == "parameter")


def _names(model: FlatModel, roots: Iterable[Flat]) -> Iterator[str]:
    pending, seen = list(roots), set[str]()
    while pending:
        node = pending.pop()
        if isinstance(node, Ref) and node.name in model.variables and node.name not in seen:
            seen.add(node.name)
            yield node.name
            variable = model.variables[node.name]
            if variable.kind == "variable" and variable.binding is not None:
                pending.append(variable.binding)
        elif not (isinstance(node, Call) and node.function == "der"):
            pending.extend(children(node))


def _all(*parts: ca.SX) -> ca.SX:
    if any(x.is_constant() and not float(x) for x in parts):
        return ca.SX(0)
    found, *others = [x for x in parts if not x.is_constant()] or [ca.SX(1)]
    for x in others:
        found = ca.logic_and(found, x)
    return found


def _not(x: ca.SX) -> ca.SX:
    return ca.SX(1 - float(x)) if x.is_constant() else ca.logic_not(x)


def _either(a: ca.SX, b: ca.SX) -> ca.SX:
    return _not(_all(_not(a), _not(b)))


def _implied(exists: ca.SX, x: ca.SX) -> ca.SX:
    return _not(_all(exists, _not(as_expression(x >= 0))))


def _is_finite(*values: ca.SX) -> ca.SX:
    return as_expression(ca.fabs(ca.sum1(ca.veccat(*values))) < _FINITE)
