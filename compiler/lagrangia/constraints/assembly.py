"""Start values in numbers: g(q, v) = 0, as near to the guesses as can be, without a C compiler.

The same algorithm as runtime/start/assemble.c, constant for constant, which states what it does and why. A test holds the two
together.
"""

from collections.abc import Iterator, Mapping

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import Vector, independent_columns
from lagrangia.base.records import dataclass
from lagrangia.constraints.blocks import blocks, solve_blocks
from lagrangia.constraints.initial import (
    FIXED,
    FREE,
    GUESS,
    LOOSE,
    InitialConditions,
    initial_function,
    start_function,
)
from lagrangia.constraints.metric import Way
from lagrangia.constraints.newton import GOLDEN_RATIO, Equations, General, Newton, pattern, start_equations
from lagrangia.frames.kinematics import Kinematics

_DEPENDENT, _LONGEST_STEP = 1e-10, 0.5
_CLOSED, _MOST_CLOSINGS = 1e-11, 40
_NO_MASS = 1e-30
_CLOSE, _SHORTEST_LEAN, _FALL, _SINGULAR, _SPREAD, _MOVED = 1e-7, 0.1, 1e-13, 1e-5, 1.0, 1e-9
_WIDE_SPREAD, _NEAR, _FREE_SEARCHES, _MOST_SEARCHES, _LAST_SEARCHES, _MANY = 2 * np.pi, 0.5, 12, 20, 32, 100
_BOUNDLESS = 1e100  # a slope: the direction of a vector that vanishes
_STEPS_ASIDE, _MOST_ASIDE = (0.00390625, 1.0, 0.25, 4.0, 0.0625, 16.0, 0.015625, 64.0), 32  # to where equations are finite
_MOST_ITERATIONS, _FEW_ITERATIONS, _MOST_PUSHES, _MOST_LEANS, _MOST_RETURNS, _MOST_TRIES = 100, 30, 3, 30, 20, 4


def begin(kinematics: Kinematics, initial: InitialConditions, table: Mapping[str, ca.Function]) -> "Assembly":
    """The assembly of a scene with its parameters as declared, from its own guesses."""
    equations = start_equations(kinematics, initial, table)
    guess = np.concatenate([x.full().ravel() for x in table["start"](equations.p)])
    return Assembly(equations, np.array(initial.fixed), guess)


def assembled(kinematics: Kinematics, initial: InitialConditions) -> tuple[Vector, int]:
    """What `assemble` gives from the scene's own guesses with its parameters as declared, looked for once."""
    known = kinematics.assembled
    if known is None or known[0] is not initial:
        table = {"initial": initial_function(kinematics, initial), "start": start_function(kinematics, initial)}
        known = kinematics.assembled = initial, begin(kinematics, initial, table).assemble()
    start, failed = known[1]
    return start.copy(), failed


@dataclass(frozen=True)
class Followed:
    """Where values that follow guesses have come to, all together and block by block, and whether all equations hold."""

    x: Vector
    apart: Vector
    is_solved: bool


class Assembly:
    """A state in the making; `reach` are the natural sizes of its values."""

    def __init__(self, equations: Equations, fixed: NDArray[np.int_], guess: Vector) -> None:
        self.equations, self.fixed, self.n = equations, fixed, equations.n
        self.guess = self._step_aside(guess)
        angles = np.where(equations.is_angle, pattern(self.n, 0), 0.0)
        self.near = equations(self.guess + np.concatenate([angles, np.zeros(self.n)]))
        self.reach = self._reach()
        length = np.linalg.norm(self.near[1] * self.reach, axis=1)
        self.general = General(self.near[1], np.where(np.isfinite(length), length, 0.0), self.near[0])

    @np.errstate(all="ignore")
    def assemble(self) -> tuple[Vector, int]:
        """The state (2 n,) found from the guess; and -1, or the equation that fails most."""
        all_of_them, positions, x, n = self.equations.initial.numel_out(0), self.equations.n_positions, self.guess, self.n
        if all_of_them == 0:
            return x, -1
        if positions > 0:
            x, worst = self._solve(positions, 0, n, x)
            found = self._search() if worst >= 0 else x
            if found is None:
                return x, worst
            x = found
            x = self._prefer_regular(x)
            if positions == all_of_them:
                return x, -1
        elif (followed := self._follow_guesses(x)) is not None:
            return followed, -1
        rates = self._solve(all_of_them, n, 2 * n, x)
        if rates[1] < 0:
            return rates
        if (found := self._search_rates(x)) is not None:
            return found, -1
        together = self._solve(all_of_them, 0, 2 * n, x)
        return together if together[1] < 0 else rates  # positions close: what fails are rates

    def _step_aside(self, guess: Vector) -> Vector:
        """The guess, or a place beside it where all equations are finite: y/x = 2 says nothing where both are 0."""
        n, fixed = self.n, self.fixed
        lost, slopes = self._lost_at(guess)
        if not lost.any():
            return guess
        like = np.concatenate([self._like(guess[:n]), self._like(guess[n:])])
        size = np.where((like > 0) & ~np.tile(self.equations.is_angle, 2), like, 1.0)
        concerned = (slopes[lost] != 0).any(axis=0) & (fixed != FIXED)
        for moving in self._in_turn(concerned):
            for turn in range(1, _MOST_ASIDE + 1):
                width = _STEPS_ASIDE[turn % len(_STEPS_ASIDE)]
                trial = guess + np.where(moving, width * size * _all_ways(2 * n, turn), 0.0)
                if not self._lost_at(trial)[0].any():
                    return trial
        return guess

    def _in_turn(self, concerned: NDArray[np.bool_]) -> Iterator[NDArray[np.bool_]]:
        """Of these values what steps aside first: places that move no mass, places, rates; what is guessed, last."""
        places, free = np.arange(2 * self.n) < self.n, self.fixed >= FREE
        loose = places & np.tile(self.fixed[self.n :] == LOOSE, 2)
        for among in (loose & free, places & free, free, places, concerned):
            if (concerned & among).any():
                yield concerned & among

    def _lost_at(self, x: Vector) -> tuple[NDArray[np.bool_], Vector]:
        """The equations that are not finite, or whose slopes are not, and all slopes."""
        g, jacobian = self.equations(x)
        return ~(np.isfinite(g) & (np.abs(jacobian) < _BOUNDLESS).all(axis=1)), jacobian

    def _like(self, x: Vector) -> Vector:
        """The largest of its kind, of each."""
        kind = self.equations.kind
        return np.array([np.abs(x[kind == k]).max() for k in kind])

    def _reach(self) -> Vector:
        """Natural sizes: an angle by 1, another value by itself and by the lever of the angles it is tied to."""
        n, angles, q = self.n, self.equations.is_angle, self.guess[: self.n]
        reach, tied = np.where(angles, 1.0, np.abs(q)), np.zeros(n, bool)
        g, jacobian = self.near
        for gap, row in zip(np.abs(g), np.abs(jacobian[: self.equations.n_positions, :n]), strict=False):
            turned, shifted = row[angles].max(initial=0.0), row[~angles].max(initial=0.0)
            if turned > 0 and shifted > 0:
                levered = ~angles & (row > 0)
                tied |= levered
                reach[levered] = np.maximum(reach[levered], max(turned, gap) / shifted)
        reach = np.where(tied | angles, reach, self._like(q))
        reach[~(np.isfinite(reach) & (reach > 0))] = 1.0
        return np.concatenate([reach, np.maximum(self._like(self.guess[n:]), reach)])

    def _solve(self, active: int, first: int, last: int, x: Vector, ways: tuple[Way, ...] = tuple(Way)) -> tuple[Vector, int]:
        scale = self._scale(first, last)
        limits = (_MOST_ITERATIONS, _MOST_PUSHES) if len(ways) > 1 else (_FEW_ITERATIONS, 0)
        followed = self._follow(active, scale, x, Way.MASS if first > 0 else Way.UNITS)
        if followed.is_solved:
            return followed.x, -1
        x = followed.x if first == 0 else x
        measured = self.guess if first == 0 else x
        for way in ways:
            newton = self._newton(active, scale, measured, way)
            found, worst = newton.solve(x, *limits)
            if worst < 0:
                return self._approach(newton, found), worst
        is_guessed = ((self.fixed == GUESS) & (scale > 0)).any()  # elsewhere there may be a place nearer to a guess
        apart = [] if is_guessed else blocks(self.general, np.arange(active), scale)
        for way in ways if len(apart) > 1 else ():
            found, worst = solve_blocks(apart, self.equations, self.general, scale, self.fixed, followed.apart, way, *limits)
            if worst < 0:
                newton = self._newton(active, scale, measured if first == 0 else found, way)
                newton.evaluate(found)
                newton.scale_equations()
                return self._approach(newton, found), worst
        return found, worst

    def _newton(self, active: int, scale: Vector, x: Vector, way: Way) -> Newton:
        return Newton(self.equations, self.general, np.arange(active), scale, self.fixed, x, way)

    def _scale(self, first: int, last: int) -> Vector:
        """The sizes of what may move."""
        places = np.arange(2 * self.n)
        return np.where((places < first) | (places >= last) | (self.fixed == FIXED), 0.0, self.reach)

    def _follow_guesses(self, x: Vector) -> Vector | None:
        """All equations by what nobody guessed: rates, or where these do not do, positions as well."""
        for first, way in ((self.n, Way.MASS), (0, Way.UNITS)):
            followed = self._follow(self.equations.initial.numel_out(0), self._scale(first, 2 * self.n), x, way)
            if followed.is_solved:
                return followed.x
        return None

    def _follow(self, active: int, scale: Vector, x: Vector, way: Way) -> "Followed":
        """Moves what nobody guessed, the guesses held, first what moves no mass."""
        followed = self._follow_by(active, scale, x, LOOSE, way)
        return followed if followed.is_solved else self._follow_by(active, scale, x, FREE, way)

    def _follow_by(self, active: int, scale: Vector, x: Vector, least: int, way: Way) -> "Followed":
        free = np.where(self.fixed >= least, scale, 0.0)
        if not free.any() or (free == scale).all():
            return Followed(x, x, False)
        found, worst = self._newton(active, free, x, way).solve(x, _MOST_RETURNS, 0)
        apart = blocks(self.general, np.arange(active), free) if worst >= 0 else []
        if len(apart) < 2:
            return Followed(found, x, worst < 0)
        solved, worst = solve_blocks(apart, self.equations, self.general, free, self.fixed, x, way, _MOST_RETURNS, 0)
        return Followed(solved if worst < 0 else found, solved, worst < 0)

    def _approach(self, newton: Newton, x: Vector) -> Vector:
        for _ in range(_MOST_LEANS if newton.distance2(self.guess, x) > 0 else 0):
            if not newton.lean(self.guess, x) > _CLOSE:
                break
            before, lean, part = newton.distance2(self.guess, x), newton.step, 1.0
            while part > _SHORTEST_LEAN:
                trial, worst = newton.solve(x + part * lean, _MOST_RETURNS, 0)
                if worst < 0 and newton.distance2(self.guess, trial) < (1 - _FALL) * before:
                    break
                part /= 2
            else:
                break
            x = trial
        return x

    def slopes(self, x: Vector) -> Vector:
        """Of the equations of positions, in natural sizes; rows are compared with what they are at a general position."""
        n, positions = self.n, self.equations.n_positions
        size = self.general.length[:positions]
        return np.asarray(self.equations(x)[1][:positions, :n] * self.reach[:n] / np.where(size > 0, size, np.inf)[:, None])

    def close(self, x: Vector, rows: slice, dependent: NDArray[np.int_], size: Vector) -> Vector | None:
        """The solution of these equations, of this size, found from x in a few steps by moving these values alone."""
        weight = np.where(size > 0, size, np.inf)
        for _ in range(_MOST_CLOSINGS):
            g, jacobian = (part[rows] for part in self.equations(x))
            if not (np.abs(g) > _CLOSED * size).any():
                return x
            if not (np.isfinite(g).all() and np.isfinite(jacobian).all()):
                return None  # turned over, where a joint in space is as far from closed as can be
            slopes = jacobian[:, dependent] * self.reach[dependent] / weight[:, None]
            step = np.linalg.lstsq(slopes, -g / weight, rcond=_DEPENDENT)[0]
            step *= min(1.0, _LONGEST_STEP / max(float(np.abs(step).max()), _LONGEST_STEP))
            x = x.copy()
            x[dependent] += step * self.reach[dependent]
        return None

    def least_gaps(self, x: Vector) -> Vector:
        """The residuals of positions where the sum of their squares, in m and rad, is least: Levenberg and Marquardt from x."""
        positions, damping = self.equations.n_positions, 1e-3
        moving = np.flatnonzero(self.fixed[: self.n] != FIXED)
        g, jacobian = (part[:positions] for part in self.equations(x))
        for _ in range(_MOST_ITERATIONS):
            slopes = jacobian[:, moving] * self.reach[moving]
            squares = slopes.T @ slopes
            ease = damping * max(float(squares.diagonal().max(initial=0.0)), _NO_MASS) * np.eye(moving.size)
            trial = x.copy()
            trial[moving] -= self.reach[moving] * np.linalg.solve(squares + ease, slopes.T @ g)
            ahead, slope = (part[:positions] for part in self.equations(trial))
            is_better = bool(ahead @ ahead < g @ g)
            damping *= 0.2 if is_better else 5.0
            if is_better:
                x, g, jacobian = trial, ahead, slope
        return np.asarray(g)

    def _rank_at(self, x: Vector) -> int:
        return independent_columns(self.slopes(x).T, _SINGULAR).size

    def _is_open(self, x: Vector) -> bool:
        moved = np.abs(x - self.guess)[: self.n] > _MOVED * self.reach[: self.n]
        return bool(moved.any() and (self.fixed[: self.n] == FREE).any())

    def _solve_elsewhere(self, turn: int, width: float, least: int, ways: tuple[Way, ...]) -> tuple[Vector, int]:
        n, fixed = self.n, self.fixed[: self.n]
        places = pattern(n, turn) if turn <= _MOST_SEARCHES else _all_ways(n, turn)
        push = np.where((fixed != FIXED) & (fixed >= least), width * self.reach[:n] * places, 0.0)
        return self._solve(self.equations.n_positions, 0, n, self.guess + np.concatenate([push, np.zeros(n)]), ways)

    def _prefer_regular(self, x: Vector) -> Vector:
        positions = self.equations.n_positions
        rank = self._rank_at(x) if self._is_open(x) else positions
        for turn in range(1, _MOST_TRIES + 1):
            if rank == positions:
                break
            other, worst = self._solve_elsewhere(turn, _SPREAD, FREE, tuple(Way))
            if worst < 0 and self._rank_at(other) > rank:
                return other
        return x

    def _missed(self, x: Vector) -> float:
        is_guess = self.fixed[: self.n] == GUESS
        return float((np.abs(x - self.guess)[: self.n] / self.reach[: self.n])[is_guess].max(initial=0.0))

    def _is_tried(self, turn: int, nearest: float) -> bool:
        if turn > _MOST_SEARCHES:
            return nearest == np.inf
        return nearest > _NEAR and bool((self.fixed[: self.n] == (FREE if turn <= _FREE_SEARCHES else GUESS)).any())

    def _search(self) -> Vector | None:
        nearest, best = np.inf, None
        for turn in range(1, _LAST_SEARCHES + 1 if self.n < _MANY else 0):
            if not self._is_tried(turn, nearest):
                continue
            x, worst = self._solve_elsewhere(turn, _WIDE_SPREAD, FREE if turn <= _FREE_SEARCHES else GUESS, (Way.EVEN,))
            if worst < 0 and self._missed(x) < nearest:
                nearest, best = self._missed(x), x
        return best

    def _search_rates(self, x: Vector) -> Vector | None:
        """What nobody guessed of the rates is tried elsewhere, where there are equations for all of it."""
        n, all_of_them = self.n, self.equations.initial.numel_out(0)
        is_free = np.concatenate([np.zeros(n, bool), self.fixed[n:] >= FREE])
        is_determined = 0 < is_free.sum() <= all_of_them - self.equations.n_positions
        for turn in range(1, _FREE_SEARCHES + 1 if n < _MANY and is_determined else 0):
            trial = x + np.where(is_free, _WIDE_SPREAD * self.reach * _all_ways(2 * n, turn), 0.0)
            found, worst = self._solve(all_of_them, n, 2 * n, trial, (Way.EVEN,))
            if worst < 0:
                return found
        return None


def _all_ways(n: int, turn: int) -> Vector:
    """As `pattern`, the signs of different values independent of each other."""
    return np.asarray(np.fmod((np.arange(n) + 1) * turn * GOLDEN_RATIO, 1) - 0.5)
