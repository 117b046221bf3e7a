"""Start values in numbers: g(q, v) = 0, as near to the guesses as can be, without a C compiler.

The same algorithm as runtime/assemble.c, newton.c and metric.c, constant for constant; they state what it does and why. A test
holds the two together.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.initial import FIXED, FREE, GUESS, InitialConditions
from lagrangia.kinematics import Kinematics
from lagrangia.parameters import default_parameters

_SATISFIED, _DEPENDENT, _SHORTEST_STEP, _LONGEST_STEP, _FAITHFUL = 1e-10, 1e-10, 1e-4, 0.5, 0.9
_CLOSED, _MOST_CLOSINGS = 1e-11, 40
_CRITICAL, _PUSH, _GOLDEN_RATIO = 1e-6, 1e-2, 0.6180339887498949
_EASE, _LEAST_PIVOT, _NO_MASS = 100.0, 1e-10, 1e-30
_CLOSE, _SHORTEST_LEAN, _FALL, _SINGULAR, _SPREAD, _MOVED = 1e-7, 0.1, 1e-13, 1e-5, 1.0, 1e-9
_WIDE_SPREAD, _NEAR, _FREE_SEARCHES, _MOST_SEARCHES, _MANY = 2 * np.pi, 0.5, 12, 20, 100
_MOST_ITERATIONS, _FEW_ITERATIONS, _MOST_PUSHES, _MOST_LEANS, _MOST_RETURNS, _MOST_TRIES = 100, 30, 3, 30, 20, 4
Vector = NDArray[np.float64]


@dataclass(frozen=True)
class Equations:
    """g(q, v, p) = 0 at parameters p: those of positions come first. `momentum` is q, v, p -> M v."""

    initial: ca.Function
    momentum: ca.Function | None
    p: Vector
    is_angle: NDArray[np.bool_]  # (n,)
    kind: NDArray[np.int_]  # (n,)
    n_positions: int

    @property
    def n(self) -> int:
        return self.is_angle.size

    def __call__(self, x: Vector) -> tuple[Vector, Vector]:
        """g (m,) and its Jacobian (m, 2 n)."""
        g, jacobian = self.initial(x[: self.n], x[self.n :], self.p)
        values = g.full().ravel()
        return values, jacobian.full().reshape(values.size, 2 * self.n, order="F")


def start_equations(kinematics: Kinematics, initial: InitialConditions, table: Mapping[str, ca.Function]) -> Equations:
    """Those of a scene with its parameters as declared. `table`: its functions; without momenta masses do not count."""
    units = [c.unit for c in (*kinematics.graph.coordinates, *initial.lost)]
    kinds = np.array([sorted(set(units)).index(unit) for unit in units])
    p, is_angle = default_parameters(kinematics)[1].full().ravel(), np.array([unit == "rad" for unit in units])
    return Equations(table["initial"], table.get("momentum"), p, is_angle, kinds, initial.n_positions)


def begin(kinematics: Kinematics, initial: InitialConditions, table: Mapping[str, ca.Function]) -> "Assembly":
    """The assembly of a scene with its parameters as declared, from its own guesses."""
    equations = start_equations(kinematics, initial, table)
    guess = np.concatenate([x.full().ravel() for x in table["start"](equations.p)])
    return Assembly(equations, np.array(initial.fixed), guess)


class Way(Enum):
    """How values are measured: LAG_METRIC_... of runtime/metric.h."""

    MASS = 0
    UNITS = 1
    EVEN = 2


class Metric:
    """Distances |z| of values, dx = B z, B = D L'^-1 with D M D = L L': see runtime/metric.c."""

    def __init__(self, equations: Equations, q: Vector, fixed: NDArray[np.int_], unit: Vector, way: Way) -> None:
        moving = np.flatnonzero(unit > 0)
        is_free = (fixed[moving] == FREE) & (way is not Way.EVEN)
        self.order = np.concatenate([moving[is_free], moving[~is_free]])
        self.unit = unit[self.order]
        self.size = unit.size
        count = self.order.size
        has_mass = way is Way.MASS and equations.momentum is not None
        M = _mass(equations, q, self.order, self.unit) if has_mass else np.zeros((count, count))
        largest = float(M.diagonal().max(initial=0.0)) if np.isfinite(M).all() else 0.0
        self.factor = _cholesky(M / largest) if largest > 0 else np.eye(count)
        self.factor[:, : int(is_free.sum())] /= _EASE

    def of_gradients(self, gradients: Vector) -> Vector:
        """Rows g -> rows B' g."""
        if not self.order.size:
            return np.zeros((len(gradients), 0))
        return np.asarray(np.linalg.solve(self.factor, (gradients[:, self.order] * self.unit).T).T)

    def to_step(self, z: Vector) -> Vector:
        dx = np.zeros(self.size)
        if self.order.size:
            dx[self.order] = np.linalg.solve(self.factor.T, z) * self.unit
        return dx

    def from_step(self, dx: Vector) -> Vector:
        return np.asarray(self.factor.T @ (dx[self.order] / self.unit))


def _mass(equations: Equations, q: Vector, order: NDArray[np.int_], unit: Vector) -> Vector:
    rates = np.zeros((q.size, order.size))
    rates[order, np.arange(order.size)] = unit
    assert equations.momentum is not None
    if not order.size:
        return np.zeros((0, 0))
    momenta = equations.momentum(q, rates, equations.p).full()
    return np.asarray(momenta[order] * unit[:, None])


def _cholesky(M: Vector) -> Vector:
    L = np.zeros_like(M)
    for k in range(len(M)):
        column = M[k:, k] - L[k:, :k] @ L[k, :k]
        floor = _LEAST_PIVOT * (M[k, k] if M[k, k] > _NO_MASS else 1.0)
        L[k, k] = np.sqrt(max(column[0], floor))
        L[k + 1 :, k] = column[1:] / L[k, k]
    return L


def nearest(A: Vector, b: Vector, wish: Vector, tolerance: float, weight: Vector | None = None) -> tuple[Vector, int]:
    """The place nearest to the wish where A x = b, and the rank of A: Householder QR of A' with pivoting.

    In the sense of weighted least squares where rows are dependent.
    """
    columns, x = A.T.copy(), wish.copy()
    reflectors, chosen, first = [], list(range(len(b))), 0.0
    for k in range(min(columns.shape)):
        norms = np.sqrt((columns[k:, k:] ** 2).sum(axis=0))
        longest = k + int(norms.argmax())
        norm = float(norms.max())
        columns[:, [k, longest]] = columns[:, [longest, k]]
        chosen[k], chosen[longest] = chosen[longest], chosen[k]
        first = norm if k == 0 else first
        if not norm > tolerance * first:
            break
        u = columns[k:, k].copy()
        diagonal = -norm if u[0] > 0 else norm
        u[0] -= diagonal
        factor = 2 / (u @ u)
        columns[k:, k + 1 :] -= np.outer(factor * u, u @ columns[k:, k + 1 :])
        x[k:] -= factor * (u @ x[k:]) * u
        columns[k, k], columns[k + 1 :, k] = diagonal, 0.0
        reflectors.append((u, factor))
    rank = len(reflectors)
    left, wanted = columns[:rank].T, b[chosen]
    if rank == len(b):
        x[:rank] = np.linalg.solve(left, wanted)
    else:
        shares = np.ones(len(b)) if weight is None else weight[chosen]
        x[:rank] = np.linalg.lstsq(left * shares[:, None], wanted * shares, rcond=0.0)[0]
    for k in range(rank - 1, -1, -1):
        u, factor = reflectors[k]
        x[k:] -= factor * (u @ x[k:]) * u
    return x, rank


def independent_columns(columns: Vector, tolerance: float, longest: Callable[[Vector], int] = lambda norms: int(norms.argmax())
                ) -> NDArray[np.int_]:
    """The places of independent columns, the longest remainder first, as pivots of a QR factorisation. `longest` finds it."""
    rest, found, first = columns.copy(), [], 0.0
    for _ in range(min(columns.shape)):
        norms = np.linalg.norm(rest, axis=0)
        k = longest(norms)
        first = first or float(norms[k])
        if not norms[k] > tolerance * first:
            break
        found.append(k)
        direction = rest[:, k] / norms[k]
        for _twice in range(2):
            rest -= np.outer(direction, direction @ rest)
        rest[:, k] = 0.0
    return np.array(found, int)


def _pattern(n: int, turn: int) -> Vector:
    """From -0.5 to 0.5, different for each value."""
    places = (np.arange(n) + 1) * _GOLDEN_RATIO + turn * _GOLDEN_RATIO * _GOLDEN_RATIO
    return np.asarray(np.fmod(places, 1) - 0.5)


@dataclass(frozen=True)
class _General:
    """The Jacobian at a general position near the guess, and the lengths of its scaled rows."""

    jacobian: Vector
    length: Vector


class _Newton:
    """The first `active` equations, solved by moving the values with a scale."""

    def __init__(
        self, equations: Equations, general: _General, active: int, scale: Vector, fixed: NDArray[np.int_], x: Vector,
        way: Way,
    ) -> None:
        n = equations.n
        self.equations, self.active, self.scale, self.n = equations, active, scale, n
        self.general_length = general.length[:active]
        self.metrics = [Metric(equations, x[:n], fixed[part], scale[part], way) for part in (slice(0, n), slice(n, 2 * n))]
        self.middle = self.metrics[0].order.size
        self.weight = np.linalg.norm(self._measured(general.jacobian[:active]), axis=1)

    def solve(self, x: Vector, most_iterations: int, most_pushes: int) -> tuple[Vector, int]:
        pushes, size, worst = 0, np.inf, 0
        self.trusted = _LONGEST_STEP
        self.evaluate(x)
        for _ in range(most_iterations):
            self.scale_equations()
            sizes = np.abs(self.g) / self.length
            worst = int(sizes.argmax())
            size = float(sizes[worst]) if np.isfinite(sizes).all() else np.inf
            if not 0 < size < np.inf:
                break
            better = self._improve(x, size)
            if better is not None:
                x = better
                continue
            if size <= _SATISFIED or pushes == most_pushes:
                break
            pushes += 1
            x = x + np.concatenate([_PUSH * self.scale[: self.n] * _pattern(self.n, 0), np.zeros(self.n)])
            self.evaluate(x)
        return x, -1 if size <= _SATISFIED else worst

    def lean(self, guess: Vector, x: Vector) -> float:
        self.trusted = _LONGEST_STEP
        return self._correct(self.wish(x, guess))

    def distance2(self, a: Vector, b: Vector) -> float:
        z = self.wish(a, b)
        return float(z @ z)

    def evaluate(self, x: Vector) -> None:
        g, jacobian = self.equations(x)
        self.g, self.jacobian = g[: self.active], jacobian[: self.active]

    def scale_equations(self) -> None:
        scaled = self.jacobian * self.scale
        length = np.maximum(np.linalg.norm(scaled, axis=1), self.general_length)
        self.length = np.where(length > 0, length, 1.0)
        self.scaled = scaled / self.length[:, None]

    def wish(self, a: Vector, b: Vector) -> Vector:
        return np.concatenate([metric.from_step(part) for metric, part in zip(self.metrics, self._parts(b - a), strict=True)])

    def _parts(self, x: Vector) -> tuple[Vector, Vector]:
        return x[..., : self.n], x[..., self.n :]

    def _measured(self, jacobian: Vector) -> Vector:
        """The gradients in the metrics."""
        parts = zip(self.metrics, self._parts(jacobian), strict=True)
        return np.concatenate([metric.of_gradients(part) for metric, part in parts], axis=1)

    def _correct(self, wish: Vector) -> float:
        rows = self._measured(self.jacobian)
        length = np.maximum(np.linalg.norm(rows, axis=1), self.weight)
        unit = np.where(length > 0, length, np.inf)
        z, _ = nearest(rows / unit[:, None], -self.g / unit, wish, _DEPENDENT, length / self.length)
        self.step = np.concatenate([self.metrics[0].to_step(z[: self.middle]), self.metrics[1].to_step(z[self.middle :])])
        size = np.abs(self.step) / np.where(self.scale > 0, self.scale, np.inf)
        excess = size[: self.n] / np.where(self.equations.is_angle, _LONGEST_STEP, self.trusted)
        self.part = 1 / max(1.0, float(excess.max(initial=0.0)))
        self.step *= self.part
        return float(size.max(initial=0.0))

    def _sum_of_squares(self) -> float:
        scaled = self.g / self.length
        return float(scaled @ scaled)

    def _improve(self, x: Vector, size: float) -> Vector | None:
        before = self._sum_of_squares()
        self._correct(np.zeros(sum(metric.order.size for metric in self.metrics)))
        better = self._descend(x)
        if better is not None and self.part < 1 and self._sum_of_squares() <= (1 - _FAITHFUL * self.part) ** 2 * before:
            self.trusted *= 2
        if better is None and size > _SATISFIED and self._steepest():
            better = self._descend(x)
        return better

    def _steepest(self) -> bool:
        slope = -(self.scaled.T @ (self.g / self.length))
        length2 = float(slope @ slope)
        if not length2 > _CRITICAL**2 * self._sum_of_squares():
            return False
        change = self.scaled @ slope
        self.step = self.scale * slope * (length2 / float(change @ change))
        return True

    def _descend(self, x: Vector) -> Vector | None:
        before, part = self._sum_of_squares(), 1.0
        while part > _SHORTEST_STEP:
            trial = x + part * self.step
            self.evaluate(trial)
            if self._sum_of_squares() < before:
                return trial
            part /= 2
        self.evaluate(x)
        return None


class Assembly:
    """A state in the making; `reach` are the natural sizes of its values."""

    def __init__(self, equations: Equations, fixed: NDArray[np.int_], guess: Vector) -> None:
        self.equations, self.fixed, self.guess, self.n = equations, fixed, guess, equations.n
        angles = np.where(equations.is_angle, _pattern(self.n, 0), 0.0)
        self.near = equations(guess + np.concatenate([angles, np.zeros(self.n)]))
        self.reach = self._reach()
        length = np.linalg.norm(self.near[1] * self.reach, axis=1)
        self.general = _General(self.near[1], np.where(np.isfinite(length), length, 0.0))

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
            found, worst = self._solve(all_of_them, n, 2 * n, x)
            if worst < 0:
                return found, -1
        return self._solve(all_of_them, 0, 2 * n, x)

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
        places = np.arange(2 * self.n)
        scale = np.where((places < first) | (places >= last) | (self.fixed == FIXED), 0.0, self.reach)
        found, is_solved = self._follow(active, scale, x, Way.MASS if first > 0 else Way.UNITS)
        if is_solved:
            return found, -1
        x = found if first == 0 else x
        for way in ways:
            newton = _Newton(self.equations, self.general, active, scale, self.fixed, self.guess if first == 0 else x, way)
            found, worst = newton.solve(x, *((_MOST_ITERATIONS, _MOST_PUSHES) if len(ways) > 1 else (_FEW_ITERATIONS, 0)))
            if worst < 0:
                return self._approach(newton, found), worst
        return found, worst

    def _follow(self, active: int, scale: Vector, x: Vector, way: Way) -> tuple[Vector, bool]:
        """Moves what nobody guessed, the guesses held; whether that is enough."""
        free = np.where(self.fixed == FREE, scale, 0.0)
        if not free.any() or (free == scale).all():
            return x, False
        x, worst = _Newton(self.equations, self.general, active, free, self.fixed, x, way).solve(x, _MOST_RETURNS, 0)
        return x, worst < 0

    def _approach(self, newton: _Newton, x: Vector) -> Vector:
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

    def close(self, x: Vector, dependent: NDArray[np.int_]) -> Vector | None:
        """The solution found from x in a few steps by moving these positions alone."""
        size, positions = self.general.length[: self.equations.n_positions], self.equations.n_positions
        for _ in range(_MOST_CLOSINGS):
            g, jacobian = (part[:positions] for part in self.equations(x))
            if not (np.abs(g) > _CLOSED * size).any():
                return x
            slopes = jacobian[:, dependent] * self.reach[dependent] / np.where(size > 0, size, np.inf)[:, None]
            step = np.linalg.lstsq(slopes, -g / np.where(size > 0, size, np.inf), rcond=_DEPENDENT)[0]
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
        push = np.where((fixed != FIXED) & (fixed >= least), width * self.reach[:n] * _pattern(n, turn), 0.0)
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

    def _search(self) -> Vector | None:
        n, nearest, best = self.n, np.inf, None
        first = 1 if (self.fixed[:n] == FREE).any() else _FREE_SEARCHES + 1
        last = 0 if n >= _MANY else _MOST_SEARCHES if (self.fixed[:n] == GUESS).any() else _FREE_SEARCHES
        for turn in range(first, last + 1):
            if nearest <= _NEAR:
                break
            x, worst = self._solve_elsewhere(turn, _WIDE_SPREAD, FREE if turn <= _FREE_SEARCHES else GUESS, (Way.EVEN,))
            if worst < 0 and self._missed(x) < nearest:
                nearest, best = self._missed(x), x
        return best
