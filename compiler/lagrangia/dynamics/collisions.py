"""Resets that turn back what meets: whether they are those of a contact, in every arm that what they set may take (arms.py).

The rates r = R v are reset to w, and the rate of the gap is s v, s = c R. An impulse L between the bodies gives M dv = s^T L, and
so w - r = R M^-1 R^T c^T L. One of a hand that takes hold of them does not: it leaves them no momentum, or gives them some.
With constraints J v = 0, M^-1 is that of what these leave free.
"""

from collections.abc import Iterator, Sequence
from enum import IntEnum
from functools import cached_property
from itertools import islice

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector, independent_columns
from lagrangia.algebra.scalars import as_expression, column, symbols_in
from lagrangia.constraints.parameters import parameter_symbols, parameters_of, usual_parameters
from lagrangia.constraints.rows import Row
from lagrangia.dynamics.arms import SAME, Look, State
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.mentions import leaves

_ROUNDING = 1e-14  # of rates of what is at rest
STILL, MOVED, BODIES = range(3)  # walls
_CROSSED = 2  # of the random states, from which it is looked for where gaps change
SPREAD = 25  # 0.4 to 1.6 become times of 1e-10 s to 1e5 s


class Meeting(IntEnum):
    """What resets do: nothing like an impact; turn back what approaches in some of their arms; turn it back, but move the wall
    along; turn back all that meet; and that by an impulse between these, for parameters as they are declared or for all."""

    NONE = 0
    IN_SOME = 1
    CARRIED = 2
    BACK = 3
    AS_DECLARED = 4
    BETWEEN = 5


class Mobility:
    """How rates v, (n,), answer to impulses, by a kinetic energy and rows of constraints."""

    def __init__(self, kinematics: Kinematics, v: ca.SX, kinetic: ca.SX, rows: Sequence[Row]) -> None:
        self.kinematics, self.v, self.kinetic, self.rows = kinematics, v, kinetic, rows

    @cached_property
    def bound(self) -> Vector:
        """Usual parameters, where those that follow from others do."""
        p, usual = usual_parameters(self.kinematics)
        bindings = (x.binding for x in self.kinematics.graph.model.variables.values() if x.kind == "parameter")
        if all(binding is None or not {*leaves([binding], {})} for binding in bindings):
            return usual
        return np.array(ca.Function("bound", [p], [parameters_of(self.kinematics, p)])(usual)).ravel()

    @cached_property
    def function(self) -> ca.Function:
        """M (n, n) and J (m, n) of v, of places and time, of parameters, and of what else is given."""
        symbols, v = self.kinematics.symbols, self.v
        rates = column(*(ca.substitute(ca.SX(row.rate(self.kinematics)), symbols.tau, ca.SX(1)) for row in self.rows))
        results = self.kinematics.algebra.with_modes([ca.hessian(self.kinetic, v)[0], ca.jacobian(rates, v)])
        places = column(*symbols.positions.values(), symbols.time)
        stated = [v, places, parameter_symbols(self.kinematics)]
        known = symbols_in(ca.vertcat(*stated))
        others = column(*(x for x in ca.symvar(ca.veccat(*results)) if x.__hash__() not in known))
        return ca.Function("mobility", [*stated, others], [ca.densify(x) for x in results])

    def moved(self, look: Look, v: Vector, known: Vector, impulses: Vector, is_bound: bool = True) -> Vector:
        """The changes of v by impulses, both (n, k), at a state; without the constraints if not `is_bound`."""
        others = np.full(self.function.numel_in(3), 0.7)
        M, J = (np.array(x) for x in self.function(v, known[:look.time + 1], look.p, others))
        J = J if is_bound else J[:0]
        both, pushed = np.block([[M, J.T], [J, np.zeros((len(J), len(J)))]]), np.vstack((impulses, np.zeros((len(J), 1))))
        if not (np.isfinite(both).all() and np.isfinite(pushed).all()):
            return np.full(impulses.shape, np.nan)
        return np.asarray(np.linalg.lstsq(both, pushed, rcond=None)[0][:len(M)])

    def moved_by(self, v: ca.SX, places: ca.SX, p: ca.SX, impulse: ca.SX) -> ca.SX:
        """The same of one impulse as an expression of parameters p; which rows others repeat is told as they are usual.
        NaN where that leaves it open."""
        others = ca.SX([0.7] * self.function.numel_in(3))
        M, J = (ca.SX(x) for x in self.function(v, places, p, others))
        usual = [np.array(x) for x in self.function(ca.evalf(v), ca.evalf(places), self.bound, ca.evalf(others))]
        if not all(np.isfinite(x).all() for x in usual):
            return ca.SX.nan(v.numel())
        kept = independent_columns(usual[1].T, SAME).tolist()
        M0, J0, J = usual[0], usual[1][kept], J[kept, :]
        if np.linalg.matrix_rank(np.block([[M0, J0.T], [J0, np.zeros((len(kept), len(kept)))]])) < len(M0) + len(kept):
            return ca.SX.nan(v.numel())
        both = ca.vertcat(ca.horzcat(M, J.T), ca.horzcat(J, ca.SX(J.shape[0], J.shape[0])))
        return as_expression(ca.solve(both, ca.vertcat(impulse, ca.SX.zeros(J.shape[0])))[: v.numel()])


def shares_of(pace: ca.SX, rates: ca.SX, v: ca.SX) -> ca.SX:
    """c: by how much the rate of a gap changes with each of the rates that are reset."""
    R = ca.jacobian(rates, v)
    return ca.solve(R @ R.T, R @ ca.gradient(pace, v))


def turned_back(look: Look, k: int, j: int, is_timed: bool) -> tuple[Meeting, int]:
    """Whether reset j leaves as it is what goes at the rate of the wall of gap k, and turns back what approaches; and the sign of
    the factor between their rates, 0 where it is met from both sides; also early and late where time is written in the gap, as a
    wall may set out after any time. `look` gives the rates of gaps, r, w, and the slopes of rates of gaps and of r."""
    signs = set[int]()
    for n, states in enumerate(look.states((1, SPREAD) if is_timed else (1,))):
        turned = _turned_everywhere if n < _CROSSED else _turned_anywhere
        found = [x for state in states for x in turned(look, k, j, *state) if x is not None]
        if not found:
            continue
        if not all(found):
            return (Meeting.IN_SOME if {1, -1} & {*found} else Meeting.NONE), 0
        signs |= {int(np.sign(found[0]))}
    return (Meeting.BACK, sum(signs)) if signs else (Meeting.NONE, 0)


def is_flat(look: Look, k: int, j: int, is_timed: bool) -> bool:
    """Whether gap k changes along reset j somewhere without a slope; at the places that `look` keeps."""
    states = (state for found in islice(look.states((1, SPREAD) if is_timed else (1,)), _CROSSED) for state in found)
    return not all(has_slope for _, known, _ in states for _, has_slope in look.crossings(k, j, known))


def is_passed(look: Look, k: int, j: int) -> bool:
    """Whether reset j lets through what approaches gap k, at states which tell that without a look at where the gap changes."""
    return any(x == 0 for states in islice(look.states(), 2) for state in states for x in _turned_anywhere(look, k, j, *state))


def turns_somewhere(look: Look, k: int, j: int) -> bool:
    """Whether reset j is turned back at gap k in some arm."""
    return any(_turned_back(look, k, j, *state) for states in islice(look.states(), 2) for state in states)


def _turned_everywhere(look: Look, k: int, j: int, v: Vector, known: Vector, arm: Vector) -> Iterator[int | None]:
    """That in one arm, and where the gap changes there; 0, too, where it only does so without a slope, along which nothing is
    held."""
    places = look.crossings(k, j, known)
    if places and not any(has_slope for _, has_slope in places):
        yield 0
    yield from _turned_anywhere(look, k, j, v, known, arm)
    for place, has_slope in places:
        yield _turned_back(look, k, j, v, place, arm) if has_slope else None


def _turned_anywhere(look: Look, k: int, j: int, v: Vector, known: Vector, arm: Vector) -> Iterator[int | None]:
    """That in one arm, but where the gap is level there, as tanh(1000*x) is all but where it changes."""
    is_level = look.crossed is not None and not look.at(v, known, arm)[3][k].any()
    yield None if is_level else _turned_back(look, k, j, v, known, arm)


def _turned_back(look: Look, k: int, j: int, v: Vector, known: Vector, arm: Vector) -> int | None:
    """The sign in one arm, twice that where only what is fast chooses it, 0 where it is not turned back; None: cannot be."""

    def at(v: Vector) -> list[Vector]:
        paces, rates, wanted, slopes, own = look.at(v, known, arm)
        return [paces.ravel()[k], rates.ravel()[j], wanted.ravel()[j], slopes[k], own[j]]

    pace, rate, _, slope, own = at(v)
    square, along = np.dot(own, own), float(np.dot(slope, own))
    if not np.isfinite([pace, rate, *slope, *own]).all():
        return None
    if not abs(along) > SAME * np.linalg.norm(slope) * np.linalg.norm(own) > 0:
        return 0
    found, is_slow = set[bool](), False
    for still, turned, is_both in look.approaches(v, own * (np.sign(along) / square), float(pace), slope, (known, arm)):
        (_, wall, left, *_), (_, _, back, *_) = at(still), at(turned)
        size = np.abs(own) @ np.abs(turned) + abs(rate) + abs(wall)
        if not arm.size or np.isfinite([wall, back]).all():
            is_slow |= is_both
            found.add(bool((not is_both or abs(left - wall) <= SAME * size) and (back - wall) * np.sign(along) <= SAME * size))
    return int(np.sign(along)) * (1 if is_slow else 2) if found == {True} else 0 if found else None


def look_at_meeting(look: Look, k: int, own: NDArray[np.intp], mobility: Mobility) -> Meeting:
    """What the resets `own` do together at gap k."""
    found = set[Meeting]()
    for states in islice(look.states(), 2):
        found |= {x for state in states if (x := _meeting(look, k, own, mobility, state)) is not None}
        if max(found, default=Meeting.NONE) == Meeting.NONE:
            return Meeting.NONE
    return min(found) or Meeting.IN_SOME


def _meeting(look: Look, k: int, own: NDArray[np.intp], mobility: Mobility, state: State) -> Meeting | None:
    """That in one arm; None where it cannot be so."""
    v, known, arm = state

    def at(v: Vector) -> list[Vector]:
        paces, r, w, slopes, R = look.at(v, known, arm)
        return [paces.ravel()[k], r.ravel()[own], w.ravel()[own], slopes[k], R[own]]

    pace, r, _, s, R = at(v)
    if not all(np.isfinite(x).all() for x in (pace, r, s, R)):
        return None if arm.size else Meeting.NONE
    c = np.linalg.lstsq(R.T, s, rcond=None)[0]
    if not np.linalg.norm(c) > 0 or np.linalg.matrix_rank(R) < len(r):
        return Meeting.NONE
    found, way = list[Meeting](), R @ mobility.moved(look, v, known, (R.T @ c)[:, None]).ravel()
    are_all = np.linalg.norm(R.T @ c - s) <= SAME * np.linalg.norm(s)
    for still, towards, is_both in look.approaches(v, s / np.dot(s, s), float(pace), s, (known, arm)):
        (_, r_still, w_still, *_), (fast, r, w, *_) = at(still), at(towards)
        change, size = w - r, np.abs(R) @ np.abs(towards) + np.abs(r)
        if arm.size and not np.isfinite(change).all():
            continue
        is_left = not is_both or (np.abs(w_still - r_still) <= SAME * size).all()
        off = change - way * (np.dot(c, change) / np.dot(c, way))
        is_between = are_all and np.linalg.norm(off) <= SAME * np.linalg.norm(change)
        found.append(Meeting.NONE if not is_left or not fast + np.dot(c, change) <= SAME * fast else
                     Meeting.BETWEEN if is_between else Meeting.BACK)
    return min(found, default=None)


def wall_of(look: Look, k: int, j: int) -> int:
    """Against what reset j is turned back at gap k: STILL where the two rates are the same but for a factor, MOVED where their
    slopes are, else BODIES."""
    return max((_wall(look, k, j, state) for states in look.states((SPREAD,)) for state in states), default=STILL)


def _wall(look: Look, k: int, j: int, state: State) -> int:
    """That at a state."""
    v, known, arm = state
    slope, own = (x[i] for x, i in zip(look.at(v, known, arm)[3:], (k, j), strict=True))
    pace, rate = (x.ravel()[i] for x, i in zip(look.at(0 * v, known, arm)[:2], (k, j), strict=True))
    if not np.isfinite([pace, rate, *slope, *own]).all():
        return STILL
    if not own.any():  # what is reset is no rate
        return MOVED
    factor = np.dot(slope, own) / np.dot(own, own)
    if np.linalg.norm(slope - factor * own) > SAME * np.linalg.norm(slope):
        return BODIES
    return STILL if abs(pace - factor * rate) <= _ROUNDING * np.abs(slope) @ np.abs(v) else MOVED


def is_carried(look: Look, mobility: Mobility) -> bool:
    """Whether an impulse along a rate changes that of its wall, or none of both, as constraints take it. `look` gives the slopes
    of both."""
    v, known, arm = next(look.states())[0]
    wall, own = (x.ravel() for x in look.at(v, known, arm))
    moved, unbound = (mobility.moved(look, v, known, own[:, None], is_bound).ravel() for is_bound in (True, False))
    size = np.linalg.norm(moved)
    return not (size > SAME * np.linalg.norm(unbound) and abs(np.dot(wall, moved)) <= SAME * np.linalg.norm(wall) * size)
