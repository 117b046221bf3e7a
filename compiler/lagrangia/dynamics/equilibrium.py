"""Positions of rest: N^T (R + J^T lambda) = 0 on Phi = 0, by Newton's method with line search, from one start or from many.

The residual is that of the free directions N, the null space of J, so that redundant constraints and directions that cost nothing
do no harm; the exact derivative has the stiffness that multipliers give to curved constraints. After each step the position goes
back onto the constraints by the shortest corrections. Far from any position of rest Newton's method is erratic: from there the
scene is let down, by steps that turn back in directions of negative stiffness, to where it would settle.
"""

from collections.abc import Callable
from dataclasses import replace
from functools import cached_property, partial
from itertools import product

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.records import dataclass
from lagrangia.constraints.singular_positions import Ways, find_ways
from lagrangia.dynamics.turned_positions import apart, half_turned, pacing_of, shorter

Vector = NDArray[np.float64]
_MOST_STEPS, _MOST_DESCENTS, _MOST_RETURNS, _SHORTEST = 50, 300, 15, 1e-3
_RANK = 1e-9
_NEAR = 0.5  # natural sizes: rad, or the size of the scene
_ASIDE, _FAR, _SAFE = 0.03, 0.3, 1e-6  # where the rank is compared; constraints less independent leave no digits
_DOUBTFUL, _MET, _MOST_MEETINGS = 1e-4, 1e-12, 8  # of normalised rows: where a singular position may be near; is found
_STALLED, _PATIENCE = 0.5, 8  # so many steps that take off less than half of the residual
_AT_REST = 1e-9  # of the forces that a natural displacement calls up,
_STEEPEST = 1e4  # which are at most so many times those at the start
_CUSP = 1e12  # by which stiffness grows where a potential has a corner, as that of a spring of no length: nothing rests there
_SAME = 1e-6
_SHUT = 1e-9  # a constraint, in natural displacements
_LARGEST_TURN, _SETTLING = 0.8, 0.2  # of one step, in natural sizes


@dataclass(frozen=True)
class Rest:
    """A position of rest, its multipliers, its potential energy, and how many free directions cost nothing there.

    Where fewer constraints are independent than in general positions `ways` tells the ways of moving that meet, in natural sizes.
    """

    q: Vector
    multipliers: Vector
    V: float
    n_neutral: int
    ways: Ways | None = None


@dataclass(frozen=True)
class StaticEquations:
    """`static`: q -> R at rest without multipliers (n,), Phi (m_h,), V; `stiffness`: q, lambda -> dR/dq (n, n), dPhi/dq (m_h, n),
    rows of the rates (m, n). `reach`: natural sizes of the coordinates. `is_angle`: those that may go round. `closes`: whether a
    position at which Phi vanishes is one of this scene, and not one of joints put together the wrong way round."""

    static: Callable[[Vector], tuple[Vector, Vector, float]]
    stiffness: Callable[[Vector, Vector], tuple[Vector, Vector, Vector]]
    reach: Vector
    is_angle: NDArray[np.bool_]
    is_rolling: bool = False  # there are constraints on rates
    turned: tuple[tuple[int, ...], ...] = ()  # of each attitude, the places of its s: 4 tan(angle/4) along the axis
    closes: Callable[[Vector], bool] = lambda q: True


def find_rest(equations: StaticEquations, start: Vector) -> Rest | None:
    """The position of rest near the start, or else the one where it would settle; None when there is no rest to be found."""
    newton = _Newton(equations, start)
    with np.errstate(all="ignore"):
        if (stuck := newton.find_rigid(start)) is not None:
            return stuck
        near = newton.solve(start)
        if near is not None and np.abs((near.q - start) / equations.reach).max(initial=0.0) < _NEAR:
            return near
        return newton.settle(start) or near


def find_rest_near(equations: StaticEquations, start: Vector) -> Rest | None:
    """By Newton's method alone."""
    with np.errstate(all="ignore"):
        return _Newton(equations, start).solve(start)


def ways_at(equations: StaticEquations, q: Vector) -> Ways | None:
    """The ways of moving that meet at a position or very near it; None where constraints are as independent as elsewhere."""
    with np.errstate(all="ignore"):
        try:
            return _Newton(equations, q).ways_near(q)
        except np.linalg.LinAlgError:
            return None


def onto_constraints(equations: StaticEquations, q: Vector, is_free: NDArray[np.bool_]) -> Vector | None:
    """The nearest position on the constraints that differs in the free coordinates alone; None when there is none."""
    with np.errstate(all="ignore"):
        try:
            return _Newton(equations, q).onto(q, is_free)
        except np.linalg.LinAlgError:
            return None


def find_all(equations: StaticEquations, start: Vector, most: int) -> tuple[list[Rest], bool]:
    """Positions of rest from `most` starts, each once, angles modulo 2 pi; and whether there is one from the given start. That
    one comes first; the others are ordered by potential energy."""
    found: list[Rest] = []
    newton = _Newton(equations, start)
    first = find_rest(equations, start)
    for k, guess in enumerate(starts(equations, start, most)):
        with np.errstate(all="ignore"):
            rest = newton.solve(guess) if k else first
        if rest is None:
            continue
        rest = _unwound(equations, rest)
        if not any(_is_same(equations, rest, other) for other in found):
            found.append(rest)
    kept = 0 if first is None else 1
    return [*found[:kept], *sorted(found[kept:], key=lambda rest: rest.V)], first is not None


def starts(equations: StaticEquations, start: Vector, most: int) -> list[Vector]:
    """The given one, those with angles turned by half a turn, and random ones all over the circle: the same every time."""
    angles = np.flatnonzero(equations.is_angle)
    found = [start, *half_turned(equations.turned, start)]
    if angles.size <= 5:
        for turns in list(product((0.0, np.pi), repeat=angles.size))[1:]:
            other = start.copy()
            other[angles] += turns
            found.append(other)
    random = np.random.default_rng(1)
    while len(found) < most:
        other = start + equations.reach * random.uniform(-2, 2, start.size)
        other[angles] = random.uniform(-np.pi, np.pi, angles.size)
        found.append(other)
    return found[:most]


def _unwound(equations: StaticEquations, rest: Rest) -> Rest:
    """The same position with its angles between -pi and pi, where that is the same: a wound torsion spring is not."""
    if equations.turned:
        rest = replace(rest, q=shorter(equations.turned, rest.q))
    turns = np.where(equations.is_angle, np.round(rest.q / (2 * np.pi)), 0.0)
    if not turns.any():
        return rest
    other = rest.q - 2 * np.pi * turns
    size, reach = _energy_size(equations, rest), equations.reach
    R, phi, V = equations.static(other)
    here, gaps, _ = equations.static(rest.q)
    same = np.abs((R - here) * reach).max(initial=0.0) <= 1e-6 * size
    closes = not (np.abs(phi - gaps) > _SHUT * _gap_sizes(equations, rest.q)).any()
    return replace(rest, q=other, V=V) if same and closes and abs(V - rest.V) <= 1e-6 * size else rest


def _energy_size(equations: StaticEquations, rest: Rest) -> float:
    """What natural displacements cost: the same all round a circle of positions."""
    K, _, _ = equations.stiffness(rest.q, rest.multipliers)
    if equations.turned:
        N = pacing_of(equations.turned, rest.q)
        K = N.T @ K @ N
    return float(np.linalg.norm(K * equations.reach * equations.reach[:, None])) + 1e-300


def _gap_sizes(equations: StaticEquations, q: Vector) -> Vector:
    """By how much natural displacements open each constraint, (m_h,)."""
    _, J, _ = equations.stiffness(q, np.zeros(0))
    sizes = np.abs(J * equations.reach).max(axis=1, initial=0.0)
    return np.where(sizes > 0, sizes, 1.0)


def _is_same(equations: StaticEquations, a: Rest, b: Rest) -> bool:
    """The same place; or two of a family that costs nothing to go through, with the same energy and stiffness."""
    gap = apart(equations.turned, a.q, b.q)
    turned = gap - 2 * np.pi * np.round(gap / (2 * np.pi))
    gap = np.where(equations.is_angle & (np.abs(np.abs(a.q) - np.pi) < 0.1), turned, gap)
    if np.abs(gap / equations.reach).max(initial=0.0) < _SAME * 100:
        return True
    size = _energy_size(equations, a)
    is_alike = abs(size - _energy_size(equations, b)) <= 1e-4 * size
    if equations.is_rolling:  # going through the family may take work, against the constraint on the rates
        largest = np.abs(a.multipliers).max(initial=0.0)
        is_alike = is_alike and bool(np.abs(a.multipliers - b.multipliers).max(initial=0.0) <= 1e-6 * largest)
    else:
        is_alike = is_alike and abs(a.V - b.V) <= 1e-6 * size
    return a.n_neutral == b.n_neutral > 0 and is_alike


class _Newton:
    def __init__(self, equations: StaticEquations, start: Vector) -> None:
        self.e, self.reach, self.start = equations, equations.reach, start

    def solve(self, start: Vector) -> Rest | None:
        try:
            found = self.onto(start)
            return None if found is None else self._judge(self._iterate(self._look(found)))
        except np.linalg.LinAlgError:  # of what is not finite
            return None

    def _iterate(self, best: "_Look") -> "_Look":
        history: list[float] = []
        for _ in range(_MOST_STEPS):
            q, r, N, K, _, _ = best
            size = float(r @ r)
            history.append(size)
            if len(history) > _PATIENCE and size > _STALLED * history[-1 - _PATIENCE]:
                break
            step = N @ np.linalg.lstsq(_finite(N.T @ K @ N), -_finite(r), rcond=1e-12)[0]
            longest = float(np.abs(step).max(initial=0.0))
            better = self._descend(q, step * min(1.0, _LARGEST_TURN / longest), size) if longest > 1e-14 else None
            if better is None:
                break
            best = better
        return best

    def settle(self, start: Vector) -> Rest | None:
        """Downhill, the stiffness taken without its signs, and the last digits by Newton's method."""
        try:
            q = self.onto(start)
            for _ in range(_MOST_DESCENTS):
                if q is None:
                    return None
                _, r, N, K, _, _ = look = self._look(q)
                reduced = _finite(N.T @ K @ N)
                values, vectors = np.linalg.eigh((reduced + reduced.T) / 2)
                sizes = np.maximum(np.abs(values), 1e-6 * np.abs(values).max(initial=0.0) + 1e-300)
                step = N @ (vectors @ (-(vectors.T @ r) / sizes))
                longest = float(np.abs(step).max(initial=0.0))
                if longest < 1e-6:
                    return self._judge(self._iterate(look))
                q = self.onto(q + step * min(1.0, _SETTLING / longest) * self.reach)
        except np.linalg.LinAlgError:
            pass
        return None

    def _judge(self, best: "_Look") -> Rest | None:
        q, r, N, K, lam, V = best
        reduced = N.T @ K @ N
        nearby = self._nearby(q, N)
        around = [N.T @ self._stiffness(x) @ N for x in nearby]  # a critical load leaves no stiffness here, but there
        if around and np.abs(reduced).max(initial=0.0) > _CUSP * max(np.abs(x).max(initial=0.0) for x in around) > 0:
            return None
        size = max(float(np.abs(K).max(initial=0.0)) * 1e-6, self._held(q), *(float(np.abs(x).max(initial=0.0)) for x in
                                                                            (reduced, *around)))
        usual = _STEEPEST * self.usual or size
        if not np.isfinite(r).all() or np.abs(r).max(initial=0.0) > _AT_REST * max(min(size, usual), 1e-300):
            return None
        sizes = np.linalg.svd(reduced, compute_uv=False)
        neutral = int((sizes <= 1e-9 * max(sizes.max(initial=0.0), 1e-3 * size)).sum()) if sizes.size else 0
        rank, margin = self._rank(q)
        sizes = self._decomposed(q)[1]
        if ((sizes > _MET) & (sizes <= _DOUBTFUL)).any() and (meeting := self._onto_singular(q)) is not None:
            return self._judge(self._look(meeting))  # forces vanish quadratically about it: they tell half of its digits
        if margin <= _SAFE:
            return None
        ways = self._ways(q, max((self._rank(x)[0] for x in nearby), default=rank))
        return Rest(q, lam, V, neutral, ways)

    def find_rigid(self, start: Vector) -> Rest | None:
        """The start, where it is a singular position in which nothing moves, as of two bars that are just long enough."""
        try:
            q = self.onto(start)
            ways = None if q is None else self.ways_near(q)
            if q is None or ways is None or not ways.is_rigid or (q := self._onto_singular(q)) is None:
                return None
            look = self._look(q)
            return Rest(q, look[4], look[5], 0, ways)
        except np.linalg.LinAlgError:
            return None

    def ways_near(self, q: Vector) -> Ways | None:
        """At the singular position very near by; others are tried along the constraints, and where there are none, anywhere."""
        if not (self._decomposed(q)[1] <= _DOUBTFUL).any() or (meeting := self._onto_singular(q)) is None:
            return None
        _, sizes, right = self._decomposed(meeting)
        nearby = self._nearby(meeting, right[int((sizes > _RANK).sum()):].T)
        distinct = [x for x in nearby if np.abs((x - meeting) / self.reach).max() > _ASIDE / 10]
        return self._ways(meeting, max(self._rank(x)[0] for x in distinct or [self.aside]))

    def _ways(self, q: Vector, general: int) -> Ways | None:
        """Those that meet at a singular position, others having `general` independent constraints; None at an ordinary one."""
        left, sizes, right = self._decomposed(q)
        rank = int((sizes > _RANK).sum())
        if rank == len(left):
            return None
        N = right[rank:].T
        ways = find_ways(N, [self._bend(q, w) for w in left[:, rank:].T], q.size - general, partial(self._leads_on, q))
        return None if len(ways.planes) == 1 and ways.planes[0].shape[1] == q.size - rank else ways

    def _leads_on(self, q: Vector, direction: Vector) -> bool:
        """Whether positions lie along it, either way."""
        ends = [self.onto(q + side * _ASIDE * self.reach * direction) for side in (-1, 1)]
        gone = [-1.0 if x is None else side * ((x - q) / self.reach) @ direction for side, x in zip((-1, 1), ends, strict=True)]
        return bool(min(gone) > _ASIDE / 2)

    def _bend(self, q: Vector, w: Vector) -> Vector:
        """w^T d2Phi/dq2 of the normalised holonomic rows, in natural sizes."""
        is_place = np.arange(w.size) < self.e.static(q)[1].size
        plain, _, _ = self.e.stiffness(q, np.zeros(w.size))
        bent, _, _ = self.e.stiffness(q, np.where(is_place, w / self.row_sizes, 0.0))
        return np.asarray((bent - plain) * self.reach * self.reach[:, None])

    def _decomposed(self, q: Vector) -> tuple[Vector, Vector, Vector]:
        """The singular values of the normalised rows, as many as there are rows, and their vectors."""
        _, _, rows = self.e.stiffness(q, np.zeros(0))
        left, sizes, right = np.linalg.svd(self._scaled(rows))
        return left, np.concatenate([sizes, np.zeros(len(rows) - sizes.size)]), right

    def _onto_singular(self, q: Vector) -> Vector | None:
        """The singular position very near by: Newton's method for Phi = 0 and w^T dPhi/dq = 0 in the free directions N."""
        for _ in range(_MOST_MEETINGS):
            left, sizes, right = self._decomposed(q)
            rank = int((sizes > _DOUBTFUL).sum())
            if (sizes[rank:] <= _MET).all():
                return q
            _, phi, _ = self.e.static(q)
            gaps = np.concatenate([phi, np.zeros(len(left) - phi.size)]) / self.row_sizes
            N, A, b = right[rank:].T, [sizes[:rank, None] * right[:rank]], [-(left.T @ gaps)[:rank]]
            for k in range(rank, len(left)):
                A.append(N.T @ self._bend(q, left[:, k]))
                b.append(-(N.T @ right[k]) * sizes[k] if k < len(right) else np.zeros(N.shape[1]))
            q = q + np.linalg.lstsq(np.vstack(A), np.concatenate(b), rcond=1e-8)[0] * self.reach
        return None

    def _nearby(self, q: Vector, N: Vector) -> list[Vector]:
        """Other positions near by that the constraints allow."""
        random = np.random.default_rng(3)
        moved = [self.onto(q + _ASIDE * self.reach * (N @ random.uniform(-1, 1, N.shape[1]))) for _ in range(2)]
        return [x for x in moved if x is not None]

    def _rank(self, q: Vector) -> tuple[int, float]:
        """How many constraints are independent, and the least of them beside the largest."""
        _, _, rows = self.e.stiffness(q, np.zeros(0))
        sizes = np.linalg.svd(self._scaled(rows), compute_uv=False)
        kept = sizes[sizes > _RANK * max(1.0, sizes.max(initial=0.0))]
        return kept.size, float(kept.min() / max(1.0, kept.max())) if kept.size else 1.0

    def _scaled(self, rows: Vector) -> Vector:
        """In natural displacements, each row by its usual size: one that vanishes in a singular position stays small."""
        return np.asarray(rows * self.reach / self.row_sizes[:, None])

    @cached_property
    def row_sizes(self) -> Vector:
        far = self.start + _FAR / _ASIDE * (self.aside - self.start)
        sizes = [np.abs(self.e.stiffness(q, np.zeros(0))[2] * self.reach).max(axis=1, initial=0.0) for q in (self.start, far)]
        largest = np.maximum(*sizes)
        return np.where(largest > 0, largest, 1.0)

    @cached_property
    def usual(self) -> float:
        """The size of forces and stiffness at the start: a place where distances vanish has stiffness without bounds."""
        stiffness = max(float(np.abs(self._stiffness(q)).max(initial=0.0)) for q in (self.start, self.aside))
        return max(stiffness, self._held(self.start))

    def _stiffness(self, q: Vector) -> Vector:
        """In natural sizes, without that of multipliers."""
        K, _, _ = self.e.stiffness(q, np.zeros(0))
        return np.asarray(K * self.reach * self.reach[:, None])

    def _held(self, q: Vector) -> float:
        """The size of the forces themselves, in natural displacements."""
        R, _, _ = self.e.static(q)
        return float(np.abs(R * self.reach).max(initial=0.0))

    def _look(self, q: Vector) -> "_Look":
        """In natural sizes: the residual in the free directions, those directions, the stiffness, the multipliers, V."""
        R, _, V = self.e.static(q)
        K, _, rows = self.e.stiffness(q, np.zeros(0))
        scaled = self._scaled(rows)
        lam, N = _held(scaled, R * self.reach)
        lam = lam / self.row_sizes
        if lam.size:
            K, _, _ = self.e.stiffness(q, lam)
        return q, N.T @ (R * self.reach), N, K * self.reach * self.reach[:, None], lam, V

    def _descend(self, q: Vector, step: Vector, before: float) -> "_Look | None":
        part = 1.0
        while part > _SHORTEST:
            trial = self.onto(q + part * step * self.reach)
            if trial is not None:
                look = self._look(trial)
                after = float(look[1] @ look[1])
                if after < before:
                    return look
            part /= 2
        return None

    def onto(self, q: Vector, is_free: NDArray[np.bool_] | None = None) -> Vector | None:
        """Onto the constraints, by the shortest corrections; None where that is no position of the scene."""
        found = self._onto_rows(q, is_free)
        return found if found is not None and self.e.closes(found) else None

    def _onto_rows(self, q: Vector, is_free: NDArray[np.bool_] | None) -> Vector | None:
        reach = self.reach if is_free is None else self.reach * is_free
        last, before = np.inf, q
        for _ in range(_MOST_RETURNS):
            _, phi, _ = self.e.static(q)
            if not np.isfinite(phi).all():
                return None
            size = float(np.abs(phi / self.gap_sizes).max(initial=0.0))
            if size == 0.0 or (size < _SHUT and size >= 0.5 * last):
                return q
            if last < _SHUT <= size:
                return before  # a slope of nothing but rounding leads away
            _, J, _ = self.e.stiffness(q, np.zeros(0))
            if not np.isfinite(J).all():
                return None
            step = np.linalg.lstsq(J * reach / self.gap_sizes[:, None], -phi / self.gap_sizes, rcond=1e-8)[0]
            longest = float(np.abs(step).max(initial=0.0))
            before, q = q, q + step * min(1.0, _LARGEST_TURN / max(longest, 1e-300)) * reach
            last = size
        return q if size < _SHUT else None

    @cached_property
    def gap_sizes(self) -> Vector:
        """At the start, or a little aside, where rows that vanish in singular positions do not."""
        return np.maximum(_gap_sizes(self.e, self.start), _gap_sizes(self.e, self.aside))

    @cached_property
    def aside(self) -> Vector:
        """A position like any other near the start."""
        return np.asarray(self.start + _ASIDE * self.reach * np.random.default_rng(4).uniform(-1, 1, self.start.size))


_Look = tuple[Vector, Vector, Vector, Vector, Vector, float]


def _held(rows: Vector, force: Vector) -> tuple[Vector, Vector]:
    """Multipliers of normalised rows that balance the force as well as they can, and the directions that are left free."""
    if not rows.shape[0]:
        return np.zeros(0), np.eye(rows.shape[1])
    left, sizes, right = np.linalg.svd(rows)
    rank = int((sizes > _RANK * max(1.0, sizes.max(initial=0.0))).sum())
    return -left[:, :rank] @ ((right[:rank] @ force) / sizes[:rank]), np.asarray(right[rank:].T)


def _finite(A: Vector) -> Vector:
    """The same; raises LinAlgError where it is none, before LAPACK prints what it thinks of it."""
    if not np.isfinite(A).all():
        raise np.linalg.LinAlgError
    return A
