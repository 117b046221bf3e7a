"""What holds at rest beside constraints: contacts, which only push, and friction, which holds up to its limit.

    R + J^T lambda + sum F dR/dF + sum x d = 0,   F >= 0, F gap = 0,   |x| <= b(F)

R: the forces without them; F: contact forces; x: what friction holds along the direction d in which it slips; b: its limit,
which may grow with contact forces; of friction in the plane x is a vector. All are unknowns of one linear complementarity
problem, which at rest is one of feasibility: least squares with unknowns that are not negative. What those leave is where the
scene would begin to move. The round limit of a vector is made of planes that touch it where it was exceeded (J. E. Kelley, The
cutting-plane method for solving convex programs, 1960).
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.nonnegative_least_squares import nonnegative
from lagrangia.base.records import dataclass
from lagrangia.dynamics.equilibrium import Rest, StaticEquations, find_rest, find_rest_near, onto_constraints, starts

Vector = NDArray[np.float64]
_TOUCHES = 1e-7  # in natural displacements
_STILL = 1e-12  # slips in natural rates
_BALANCED = 1e-9  # of the forces there
_FIRM = 10.0  # what limits weigh beside forces
_SPREAD = 1e-2  # what is undetermined is spread evenly
_SLACK = 1e-9  # of a limit
_MOST_CUTS = 20
_MOST_STEPS, _POLISHED, _LONGEST = 150, 5, 0.2
_SAME, _NEAR = 1e-4, 0.5


@dataclass(frozen=True)
class Look:
    """At a position, all in natural sizes: R (n,) without contact forces, friction half way; rows of the rates (m, n); of
    contacts dR/dF (c, n), gaps (c,), whether their conditions hold, rows of the gaps (c, n); of friction slips (f,), their rows
    (f, n), dR/dshare without contact forces (f, n) and what each unit of them adds (c, f, n). The gap of a contact of a rate is
    by how much the rate is beyond its level."""

    R: Vector
    rows: Vector
    pulls: Vector
    gaps: Vector
    is_open: NDArray[np.bool_]
    gap_rows: Vector
    slips: Vector
    slip_rows: Vector
    spans: Vector
    pressed: Vector
    cones: tuple[tuple[int, int], ...] = ()  # pairs of slips that are the components of one
    one_way: tuple[int, ...] = ()  # contacts of rates

    def touching(self, is_passed: bool = False) -> list[int]:
        """Contacts that are closed, or that are passed, too."""
        sizes = np.maximum(np.linalg.norm(self.gap_rows, axis=1), 1e-300)
        return [int(k) for k in np.flatnonzero(self.is_open) if self.gaps[k] > -_TOUCHES * sizes[k]
                and (is_passed or self.gaps[k] <= _TOUCHES * sizes[k])]

    def passed(self) -> list[int]:
        """The contacts that are open, by more than what still touches."""
        sizes = np.maximum(np.linalg.norm(self.gap_rows, axis=1), 1e-300)
        return [int(k) for k in np.flatnonzero(self.is_open) if self.gaps[k] > _TOUCHES * sizes[k]]


@dataclass(frozen=True)
class Grip:
    """`forces` (c,) of contacts; `shares` (f,) of friction, what it `held` and its `limits` (f,), in units of its slip.
    `pressing`, `sticking`: the places of those that hold; `grazing`: of contacts that touch without force."""

    forces: Vector
    shares: Vector
    held: Vector
    limits: Vector
    pressing: tuple[int, ...] = ()
    sticking: tuple[int, ...] = ()
    grazing: tuple[int, ...] = ()
    cones: tuple[tuple[int, int], ...] = ()

    def size(self, k: int) -> float:
        """Of what friction holds, in all directions together."""
        others = [i + j - k for i, j in self.cones if k in (i, j) and i in self.sticking and j in self.sticking]
        return float(np.linalg.norm(self.held[[k, *others]]))

    @property
    def is_on_the_verge(self) -> tuple[int, ...]:
        """Friction at its limit."""
        return tuple(k for k in self.sticking if self.size(k) >= self.limits[k] * (1 - 1e-6))


@dataclass(frozen=True)
class GripEquations:
    """`look` at a position; `statics` with these contacts as constraints on positions and this friction as constraints on rates;
    `multipliers` of constraints, contact forces, shares -> all of them."""

    look: Callable[[Vector], Look]
    statics: Callable[[tuple[int, ...], tuple[int, ...]], StaticEquations]
    multipliers: Callable[[Vector, Vector, Vector], Vector]
    reach: Vector


# ------------------------------------------------------------ balance


@dataclass(frozen=True)
class Balance:
    """What is left of the forces (n,), natural; their size; the grip that leaves least."""

    left: Vector
    size: float
    grip: Grip

    @property
    def is_rest(self) -> bool:
        """Whether nothing is left that would move it."""
        return bool(np.abs(self.left).max(initial=0.0) <= _BALANCED * self.size)


def balance(look: Look, usual: float) -> Balance:
    """By contacts that are closed and friction that does not slip. `usual`: the size of forces elsewhere."""
    touching = look.touching()
    slopes, own, by_forces, rubbing = _limits(look, touching)
    size = max(float(np.abs(look.R).max(initial=0.0)), float(own.max(initial=0.0)), usual, 1e-300)
    N = _null_space(look.rows)
    c, f = len(touching), len(rubbing)
    A = np.block([[N.T @ look.pulls[touching].T, -N.T @ slopes.T / 2, N.T @ slopes.T / 2],
                  [-2 * _FIRM * by_forces, _FIRM * np.eye(f), _FIRM * np.eye(f)]])
    b = np.concatenate([-N.T @ look.R, 2 * _FIRM * own]) / size
    x = _within(_cones(look, rubbing), A, b, c, f) * size
    forces, shares, held, limits = np.zeros(look.gaps.size), np.full(look.slips.size, 0.5), *np.zeros((2, look.slips.size))
    forces[touching] = x[:c]
    for place, k in enumerate(rubbing):
        limits[k] = own[place] + by_forces[place] @ x[:c]
        held[k] = (x[c + f + place] - x[c + place]) / 2
        if limits[k] > 0:
            towards = 1.0 if (look.spans[k] + np.tensordot(forces, look.pressed[:, k], 1)) @ slopes[place] > 0 else -1.0
            shares[k] = 0.5 + towards * held[k] / (2 * limits[k])
    sliding = np.abs(look.slips) > _STILL
    shares = np.where(sliding, look.slips > 0, shares)
    left = N @ (N.T @ (look.R + forces @ look.pulls + held[rubbing] @ slopes))
    units = np.linalg.norm(look.slip_rows, axis=1)
    units = np.where(units > 0, units, 1.0)
    pressing = tuple(k for k in touching if forces[k] > _BALANCED * size)
    sticking = tuple(k for k in rubbing if limits[k] > _BALANCED * size)
    grazing = tuple(k for k in touching if k not in pressing)
    return Balance(left, size, Grip(forces, shares, held / units, limits / units, pressing, sticking, grazing, look.cones))


def _limits(look: Look, touching: list[int]) -> tuple[Vector, Vector, Vector, list[int]]:
    """Of friction that does not slip: unit directions (f', n), limits without contact forces (f',), and by each (f', c')."""
    directions, own, by_forces, rubbing = [], [], [], []
    for k in range(look.slips.size):
        row = look.slip_rows[k]
        length = float(np.linalg.norm(row))
        spans = np.vstack([look.spans[k][None], look.pressed[touching, k]]) / 2
        if abs(look.slips[k]) > _STILL or length == 0 or not spans.any():
            continue
        along = spans @ row / length
        if np.abs(spans - np.outer(along, row / length)).max() > 1e-6 * np.abs(spans).max() or (along.min() < 0 < along.max()):
            continue  # no friction along its slip: it gives what it gives half way
        directions.append(row / length)
        own.append(abs(along[0]))
        by_forces.append(np.abs(along[1:]))
        rubbing.append(k)
    n = look.R.size
    return (np.array(directions).reshape(-1, n), np.array(own), np.array(by_forces).reshape(len(own), len(touching)), rubbing)


def _cones(look: Look, rubbing: list[int]) -> list[tuple[int, int, float, float]]:
    """The places of both components among those that rub, with the length of the row of each."""
    where = {k: place for place, k in enumerate(rubbing)}
    lengths = np.linalg.norm(look.slip_rows, axis=1)
    return [(where[i], where[j], float(lengths[i]), float(lengths[j])) for i, j in look.cones if i in where and j in where]


def _within(cones: list[tuple[int, int, float, float]], A: Vector, b: Vector, c: int, f: int) -> Vector:
    """As `_spread`, with what friction holds in the plane within its limit in each direction in which it was beyond."""
    x = _spread(A, b, c, f)
    for _ in range(_MOST_CUTS if cones else 0):
        cuts = []
        for i, j, at_i, at_j in cones:
            (plus, minus) = ([c + i, c + j], [c + f + i, c + f + j])
            held, limit = (x[minus] - x[plus]) / 2 / (at_i, at_j), float(x[plus[0]] + x[minus[0]]) / 2 / at_i
            if np.linalg.norm(held) > limit * (1 + _SLACK):
                cut, way = np.zeros(A.shape[1]), held / np.linalg.norm(held) / (at_i, at_j)
                cut[plus], cut[minus] = -way, way
                cut[[plus[0], minus[0]]] -= 1 / at_i
                cuts.append(_FIRM * at_i / 2 * cut)  # not positive
        if not cuts:
            return x
        A = np.block([[A, np.zeros((len(A), len(cuts)))], [np.array(cuts), _FIRM * np.eye(len(cuts))]])
        b = np.concatenate([b, np.zeros(len(cuts))])
        x = _spread(A, b, c, f)
    return x


def _spread(A: Vector, b: Vector, c: int, f: int) -> Vector:
    """A solution that is not negative; of several, where there are, one with even forces and friction away from its limits."""
    plain = nonnegative(A, b)
    if np.linalg.norm(A @ plain - b) > _BALANCED or not plain.size:
        return plain
    even = np.zeros((c + f, A.shape[1]))
    even[:c, :c] = np.eye(c)
    even[c:, c : c + f], even[c:, c + f : c + 2 * f] = -np.eye(f), np.eye(f)
    x = nonnegative(np.vstack([A, _SPREAD * even]), np.concatenate([b, np.zeros(c + f)]))
    taken = x > 0
    x[taken] -= np.linalg.pinv(A[:, taken], rcond=1e-10) @ (A @ x - b)
    return x if x.min(initial=0.0) >= 0 and np.linalg.norm(A @ x - b) <= _BALANCED else plain


def _null_space(A: Vector) -> Vector:
    if not A.shape[0]:
        return np.eye(A.shape[1])
    lengths = np.linalg.norm(A, axis=1)
    _, sizes, rows = np.linalg.svd(A / np.where(lengths > 0, lengths, 1.0)[:, None])
    return np.asarray(rows[int((sizes > 1e-9).sum()):].T)


# ------------------------------------------------------------ where it rests


def find_held(e: GripEquations, start: Vector) -> tuple[Rest, Grip] | None:
    """The start where it holds; the position of rest of what is not held there; the one near by, without friction; or where it
    would settle."""
    with np.errstate(all="ignore"):
        closed = _closed(e, start)
        if (found := holds_at(e, closed)) is not None:
            return found
        if closed is not None and (found := _with_what_sticks(e, closed)) is not None:
            return found
        if not e.look(start).gaps.size:
            return _press(e, start, find_rest) or _settle(e, start)
        near = _press(e, start, find_rest_near)
        if near is not None and np.abs((near[0].q - start) / e.reach).max() < _NEAR:
            return near
        return _settle(e, start) or near or _press(e, start, find_rest)


def find_all_held(e: GripEquations, start: Vector, most: int) -> tuple[list[tuple[Rest, Grip]], bool]:
    """As equilibrium.find_all."""
    found: list[tuple[Rest, Grip]] = []
    first = find_held(e, start)
    for k, guess in enumerate(starts(e.statics((), ()), start, most)):
        rest = _press(e, guess, find_rest_near) if k else first
        if rest is not None and not any(_is_same(e, rest, other) for other in found):
            found.append(rest)
    kept = 0 if first is None else 1
    return [*found[:kept], *sorted(found[kept:], key=lambda x: x[0].V)], first is not None


def _is_same(e: GripEquations, a: tuple[Rest, Grip], b: tuple[Rest, Grip]) -> bool:
    """The same place, or two of a family that costs nothing to go through."""
    gap = a[0].q - b[0].q
    gap = np.where(e.statics((), ()).is_angle, gap - 2 * np.pi * np.round(gap / (2 * np.pi)), gap)
    is_family = max(a[0].n_neutral, b[0].n_neutral) > 0 and a[1].pressing == b[1].pressing
    size = max(1e3 * _usual(e, a[0].q), float(np.abs(e.look(a[0].q).R).max(initial=0.0)))
    alike = abs(a[0].V - b[0].V) <= 1e-6 * max(abs(a[0].V), abs(b[0].V), size)
    return bool(np.abs(gap / e.reach).max() < _SAME or (is_family and alike))


def _closed(e: GripEquations, q: Vector) -> Vector | None:
    """On the constraints, and out of what contacts keep out of."""
    everywhere = np.full(q.size, True)
    holding: tuple[int, ...] = ()
    for _ in range(4):
        found = onto_constraints(e.statics(holding, ()), q, everywhere)
        if found is None:
            return None
        passed = e.look(found).passed()
        if not passed:
            return found
        holding, q = tuple(sorted({*holding, *passed})), found
    return None


def _usual(e: GripEquations, q: Vector) -> float:
    """The size of forces: those that act, or that natural displacements call up."""
    K, _, _ = e.statics((), ()).stiffness(q, np.zeros(0))
    return float(np.abs(K * e.reach * e.reach[:, None]).max(initial=0.0)) * 1e-3


def holds_at(e: GripEquations, q: Vector | None) -> tuple[Rest, Grip] | None:
    """A position, if it is one of rest."""
    if q is None:
        return None
    look = e.look(q)
    found = balance(look, _usual(e, q))
    if look.passed() or not found.is_rest:
        return None
    return _rest(e, q, look, found.grip), found.grip


def _rest(e: GripEquations, q: Vector, look: Look, grip: Grip) -> Rest:
    plain = e.statics((), ())
    forces = look.R + grip.forces @ look.pulls + (grip.shares - 0.5) @ (look.spans + np.tensordot(grip.forces, look.pressed, 1))
    lam = -np.linalg.pinv(look.rows.T, rcond=1e-9) @ forces if look.rows.size else np.zeros(len(look.rows))
    multipliers = e.multipliers(lam, grip.forces, grip.shares)
    K, _, _ = plain.stiffness(q, multipliers)
    N = _null_space(np.vstack([look.rows, look.gap_rows[list(grip.pressing)], look.slip_rows[list(grip.sticking)]]))
    whole = K * e.reach * e.reach[:, None]
    sizes = np.linalg.svd(N.T @ whole @ N, compute_uv=False)
    largest = max(float(sizes.max(initial=0.0)), 1e-3 * float(np.abs(whole).max(initial=0.0)))
    neutral = int((sizes <= 1e-9 * largest).sum())
    return Rest(q, multipliers, plain.static(q)[2], neutral)


def _press(e: GripEquations, start: Vector, find: Callable[[StaticEquations, Vector], Rest | None], kept: tuple[int, ...] = (),
           sticking: tuple[int, ...] = ()) -> tuple[Rest, Grip] | None:
    """With contacts of places as constraints: what is passed is closed, and what pulls is let go, one after the other. `kept`:
    contacts of rates that press all along, as `sticking` sticks."""
    look = e.look(start)
    pressing = frozenset(look.touching(is_passed=True)) - set(look.one_way)
    seen = set[frozenset[int]]()
    while pressing not in seen:
        seen.add(pressing)
        rest = find(e.statics((*sorted(pressing), *kept), sticking), start)
        if rest is None:
            if not pressing or frozenset() in seen:
                return None
            pressing = frozenset()
            continue
        look = e.look(rest.q)
        passed = [k for k in look.passed() if k not in pressing]
        if passed:
            pressing |= {max(passed, key=lambda k: look.gaps[k] / max(float(np.linalg.norm(look.gap_rows[k])), 1e-300))}
            continue
        if (held := holds_at(e, rest.q)) is not None:
            is_free = not (held[1].pressing or held[1].sticking)
            return replace(held[0], ways=rest.ways if is_free else None, n_neutral=rest.n_neutral), held[1]
        pulls = look.pulls[sorted(pressing)]
        others = np.vstack([look.rows, look.pulls[[*kept]], look.slip_rows[[*sticking]]])
        forces = np.linalg.lstsq(np.vstack([pulls, others]).T, -look.R, rcond=1e-9)[0][: len(pressing)]
        if not forces.size or forces.min() >= 0:
            return None
        pressing -= {sorted(pressing)[int(forces.argmin())]}
    return None


def _with_what_sticks(e: GripEquations, start: Vector) -> tuple[Rest, Grip] | None:
    """At rest with what friction and contacts of rates hold at the start as it is there."""
    look = e.look(start)
    grip = balance(look, _usual(e, start)).grip
    sticking = tuple(k for k in grip.sticking if grip.size(k) < grip.limits[k] * (1 - _SLACK))
    pushing = [k for k in grip.pressing if k in look.one_way]
    is_held = bool(sticking or pushing) and all(_are_along(look.pulls[k], look.gap_rows[k]) for k in pushing)
    if not is_held:
        return None
    rest = find_rest(e.statics(grip.pressing, sticking), start)
    found = None if rest is None else holds_at(e, rest.q)
    return found or _press(e, start, find_rest, tuple(pushing), sticking)


def _are_along(a: Vector, b: Vector) -> bool:
    return bool(abs(a @ b) >= (1 - 1e-9) * np.linalg.norm(a) * np.linalg.norm(b))


def _settle(e: GripEquations, start: Vector) -> tuple[Rest, Grip] | None:
    """Where forces lead that contacts and friction do not hold, a step at a time; the last digits by Newton's method."""
    q = _closed(e, start)
    for k in range(_MOST_STEPS):
        if q is None:
            return None
        look = e.look(q)
        found = balance(look, _usual(e, q))
        if found.is_rest:
            return holds_at(e, q)
        if k % _POLISHED == _POLISHED - 1 and (rest := _polished(e, q, found.grip)) is not None:
            return rest
        q = _closed(e, q + _step(e, q, found) * e.reach)
    return None


def _step(e: GripEquations, q: Vector, found: Balance) -> Vector:
    """Along the forces that are left, to where they would vanish, or as far as one step may go."""
    K, _, _ = e.statics((), ()).stiffness(q, np.zeros(0))
    r = found.left
    bend = float(r @ (K * e.reach * e.reach[:, None]) @ r)
    step = -r * (float(r @ r) / bend if bend > 0 else np.inf) if np.abs(r).max() > 0 else r
    longest = float(np.abs(r).max())
    return step if np.isfinite(step).all() and np.abs(step).max() <= _LONGEST else -r / longest * _LONGEST


def _polished(e: GripEquations, q: Vector, grip: Grip) -> tuple[Rest, Grip] | None:
    """With what holds as constraints, but for friction at its limit."""
    sticking = tuple(k for k in grip.sticking if grip.size(k) < grip.limits[k] * (1 - _SLACK))
    rest = find_rest_near(e.statics(grip.pressing, sticking), q)
    if rest is None or np.abs((rest.q - q) / e.reach).max() > 1.0:
        return None
    return holds_at(e, rest.q)
