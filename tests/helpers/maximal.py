"""An independent reference: bodies in maximal coordinates (x, y, phi each), joints as constraints with multipliers, contacts and
dry friction by their states, chosen by trying them all. Nothing here knows of Lagrangia; slow, plain, and right to some 1e-10.

    M a = f + J' lambda,  J a = -dJ/dt v          (Lagrange's equations of the first kind)

A contact is open or closed (gap'' = 0, force >= 0), a brake slides (force -F sign) or sticks (rate' = 0, |force| <= F). Where one
of these changes, the integration stops, and goes on with the first set of states whose forces and accelerations fit them.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from itertools import product
from math import inf

import numpy as np
from scipy.integrate import solve_ivp

from helpers.reference import Array

GROUND = -1
_CLOSED = 1e-8  # m, m/s: a gap, or a rate, that counts as none
_FORCE = 1e-8  # of the largest force: one that counts as none


@dataclass(frozen=True)
class Point:
    """A place on a body, in its axes (m); on the ground in world axes."""

    body: int
    at: tuple[float, float] = (0.0, 0.0)

    def place(self, x: Array) -> Array:
        if self.body == GROUND:
            return np.array(self.at)
        return x[3 * self.body : 3 * self.body + 2] + _turned(self.at, x[3 * self.body + 2])

    def rows(self, x: Array, v: Array) -> tuple[Array, Array]:
        """dr/dx, (2, 3 n), and the part of r'' that holds no acceleration, (2,)."""
        J, bias = np.zeros((2, x.size)), np.zeros(2)
        if self.body != GROUND:
            k = 3 * self.body
            arm = _turned(self.at, x[k + 2])
            J[0, k] = J[1, k + 1] = 1
            J[:, k + 2] = -arm[1], arm[0]
            bias = -v[k + 2] ** 2 * arm
        return J, bias


def _turned(at: tuple[float, float], phi: float) -> Array:
    c, s = np.cos(phi), np.sin(phi)
    return np.array([c * at[0] - s * at[1], s * at[0] + c * at[1]])


class Tie:
    """A constraint: its residual (m), its rows J, and the part of its second derivative that holds no acceleration."""

    def residual(self, x: Array) -> Array:
        raise NotImplementedError

    def rows(self, x: Array, v: Array) -> tuple[Array, Array]:
        raise NotImplementedError


@dataclass(frozen=True)
class Pin(Tie):
    a: Point
    b: Point

    def residual(self, x: Array) -> Array:
        return self.b.place(x) - self.a.place(x)

    def rows(self, x: Array, v: Array) -> tuple[Array, Array]:
        (Ja, ba), (Jb, bb) = self.a.rows(x, v), self.b.rows(x, v)
        return Jb - Ja, bb - ba


@dataclass(frozen=True)
class Rod(Tie):
    """(|d|^2 - L^2)/(2 L) = 0."""

    a: Point
    b: Point
    L: float

    def residual(self, x: Array) -> Array:
        d = self.b.place(x) - self.a.place(x)
        return np.array([(d @ d - self.L**2) / (2 * self.L)])

    def rows(self, x: Array, v: Array) -> tuple[Array, Array]:
        d = self.b.place(x) - self.a.place(x)
        (Ja, ba), (Jb, bb) = self.a.rows(x, v), self.b.rows(x, v)
        J = Jb - Ja
        return (d @ J)[None] / self.L, np.array([(d @ (bb - ba) + (J @ v) @ (J @ v)) / self.L])


@dataclass(frozen=True)
class Along(Tie):
    """normal . (r - at) = offset, in world axes: a track on the ground, or the gap of a stop."""

    point: Point
    normal: tuple[float, float]
    at: tuple[float, float] = (0.0, 0.0)

    def residual(self, x: Array) -> Array:
        return np.array([np.dot(self.normal, self.point.place(x) - self.at)])

    def rows(self, x: Array, v: Array) -> tuple[Array, Array]:
        J, bias = self.point.rows(x, v)
        return (np.array(self.normal) @ J)[None], np.array([np.dot(self.normal, bias)])


@dataclass(frozen=True)
class Turn(Tie):
    """phi_b - phi_a = angle."""

    a: int
    b: int
    angle: float = 0.0

    def residual(self, x: Array) -> Array:
        return np.array([_angle(x, self.b) - _angle(x, self.a) - self.angle])

    def rows(self, x: Array, v: Array) -> tuple[Array, Array]:
        J = np.zeros((1, x.size))
        for body, sign in ((self.a, -1), (self.b, 1)):
            if body != GROUND:
                J[0, 3 * body + 2] = sign
        return J, np.zeros(1)


def _angle(x: Array, body: int) -> float:
    return 0.0 if body == GROUND else float(x[3 * body + 2])


# A load adds its generalised force to f. `kinks` are zero where it bends.
Load = Callable[[float, Array, Array, Array], None]
Kink = Callable[[Array], float]


def spring(a: Point, b: Point, k: float, s_rel0: float, c: float = 0.0) -> Load:
    def load(t: float, x: Array, v: Array, f: Array) -> None:
        d = b.place(x) - a.place(x)
        length = float(np.hypot(*d))
        J = b.rows(x, v)[0] - a.rows(x, v)[0]
        along = d / length if length > 0 else np.zeros(2)
        f -= (k * (length - s_rel0) + c * (along @ (J @ v))) * (along @ J)

    return load


def torsion(a: int, b: int, k: float, c: float) -> Load:
    tie = Turn(a, b)

    def load(t: float, x: Array, v: Array, f: Array) -> None:
        J = tie.rows(x, v)[0][0]
        f -= (k * tie.residual(x)[0] + c * (J @ v)) * J

    return load


def push(at: Point, force: Callable[[float, Array], Array]) -> Load:
    """A force in world axes of time (s) and of the place of its point (m)."""

    def load(t: float, x: Array, v: Array, f: Array) -> None:
        f += force(t, at.place(x)) @ at.rows(x, v)[0]

    return load


@dataclass(frozen=True)
class Contact:
    gap: Along
    e: float


@dataclass(frozen=True)
class Brake:
    """Coulomb's friction of constant size F (N, N m) against the rate of a tie's residual."""

    tie: Tie
    F: float


@dataclass
class System:
    """Bodies of masses m (kg) and inertias I (kg m2) with what acts on them; gravity in m/s2."""

    m: Sequence[float]
    I: Sequence[float]
    gravity: tuple[float, float]
    ties: Sequence[Tie] = ()
    loads: Sequence[Load] = ()
    kinks: Sequence[Kink] = ()
    contacts: Sequence[Contact] = ()
    brakes: Sequence[Brake] = ()
    masses: Array = field(init=False)

    def __post_init__(self) -> None:
        self.masses = np.array([value for m, I in zip(self.m, self.I, strict=True) for value in (m, m, I)])

    def applied(self, t: float, x: Array, v: Array) -> Array:
        f = np.zeros(x.size)
        for k, m in enumerate(self.m):
            f[3 * k : 3 * k + 2] = m * np.array(self.gravity)
        for load in self.loads:
            load(t, x, v, f)
        return f


@dataclass(frozen=True)
class State:
    """Which contacts are closed, and how brakes slide: -1, 0 (sticks), 1."""

    closed: tuple[bool, ...]
    slides: tuple[int, ...]


@dataclass
class Motion:
    """Rows of places (n_times, 3 n), and how many of them could be had; what happened on the way."""

    rows: Array
    count: int
    events: int
    why: str = ""  # what ended it before its time


class _Stopped(Exception):
    """The motion cannot be told further: bounces without end, no state that fits."""


def _solve(weights: Array, J: Array, a: Array, right: Array) -> tuple[Array, Array]:
    """The x nearest to a in the masses with J x = right, and the multipliers: M (x - a) = J' lambda. By QR of M^-1/2 J'."""
    if not len(J):
        return a, np.zeros(0)
    A = (J / weights).T
    size = np.linalg.norm(A, axis=0)
    Q, R = np.linalg.qr(A / size)
    z = np.linalg.solve(R.T, (right - J @ a) / size)
    return a + (Q @ z) / weights, np.linalg.solve(R, z) / size


@dataclass(frozen=True, eq=False)
class _Watch:
    """What is looked at along the way: where it falls through 0 (or passes it, direction 0), the state after it is this one."""

    value: Callable[[float, Array], float]
    direction: int
    after: State | None = None
    terminal: bool = True

    def __call__(self, t: float, y: Array) -> float:
        return self.value(t, y)


class _Run:
    def __init__(self, system: System, max_step: float, rtol: float) -> None:
        self.system, self.max_step, self.rtol = system, max_step, rtol
        self.weights = np.sqrt(system.masses)
        self.events, self.why = 0, ""

    # ---------------------------------------------------------------- what holds in a state

    def held(self, state: State) -> list[Tie]:
        s = self.system
        return [*s.ties, *(c.gap for c, is_closed in zip(s.contacts, state.closed, strict=True) if is_closed),
                *(b.tie for b, slides in zip(s.brakes, state.slides, strict=True) if not slides)]

    def accelerations(self, t: float, y: Array, state: State) -> tuple[Array, Array, Array]:
        """a, the forces of contacts (0 where open) and of brakes that stick (0 where they slide)."""
        s, n = self.system, y.size // 2
        x, v = y[:n], y[n:]
        f = s.applied(t, x, v)
        for brake, slides in zip(s.brakes, state.slides, strict=True):
            if slides:
                f -= brake.F * slides * brake.tie.rows(x, v)[0][0]
        J, bias = _stack(self.held(state), x, v)
        a, forces = _solve(self.weights, J, f / s.masses, -bias)
        forces = forces[sum(len(tie.residual(x)) for tie in s.ties) :]
        normal, rub = np.zeros(len(s.contacts)), np.zeros(len(s.brakes))
        closed, sticks = np.flatnonzero(state.closed), np.flatnonzero([not k for k in state.slides])
        normal[closed], rub[sticks] = forces[: len(closed)], forces[len(closed) :]
        return a, normal, rub

    def project(self, y: Array, state: State) -> Array:
        """Places and rates put back onto what holds."""
        n = y.size // 2
        x, v = y[:n].copy(), y[n:]
        holonomic = [tie for tie in self.held(state) if not any(tie is b.tie for b in self.system.brakes)]
        if not self.held(state):
            return y
        for _ in range(3):
            if not holonomic:
                break
            residual = np.concatenate([tie.residual(x) for tie in holonomic])
            x = x + _solve(self.weights, _stack(holonomic, x, v)[0], np.zeros(n), -residual)[0]
        J = _stack(self.held(state), x, v)[0]
        return np.concatenate([x, _solve(self.weights, J, v, np.zeros(len(J)))[0]])

    # ---------------------------------------------------------------- where states change

    def choose(self, t: float, y: Array) -> tuple[Array, State]:
        """Impacts first, then the first set of states that fits."""
        y = self.strike(y)
        s, n = self.system, y.size // 2
        x, v = y[:n], y[n:]
        options: list[list[bool]] = []
        for contact in s.contacts:
            touches = contact.gap.residual(x)[0] < _CLOSED and abs(contact.gap.rows(x, v)[0][0] @ v) < _CLOSED
            options.append([True, False] if touches else [False])
        ways: list[list[int]] = []
        for brake in s.brakes:
            rate = float(brake.tie.rows(x, v)[0][0] @ v)
            ways.append([0, 1, -1] if abs(rate) < _CLOSED else [1 if rate > 0 else -1])
        for closed in product(*options):
            for slides in product(*ways):
                state = State(closed, slides)
                if self.fits(t, y, state, options, ways):
                    return self.project(y, state), state
        raise _Stopped("no state fits")

    def fits(self, t: float, y: Array, state: State, options: list[list[bool]], ways: list[list[int]]) -> bool:
        s, n = self.system, y.size // 2
        x, v = y[:n], y[n:]
        try:
            a, normal, rub = self.accelerations(t, y, state)
        except np.linalg.LinAlgError:
            return False
        size = _FORCE * max(1e-300, float(np.abs(s.masses * a).max()), *np.abs(normal), *np.abs(rub), *(b.F for b in s.brakes))
        speed = 1e-9 * (1 + float(np.abs(a).max()))
        for k, contact in enumerate(s.contacts):
            J, bias = contact.gap.rows(x, v)
            if state.closed[k] and normal[k] < -size:
                return False
            if not state.closed[k] and len(options[k]) > 1 and J[0] @ a + bias[0] < -speed:
                return False
        for k, brake in enumerate(s.brakes):
            J, bias = brake.tie.rows(x, v)
            if not state.slides[k] and abs(rub[k]) > brake.F + size:
                return False
            if state.slides[k] and len(ways[k]) > 1 and (J[0] @ a + bias[0]) * state.slides[k] < speed:
                return False
        return True

    def strike(self, y: Array) -> Array:
        """Newton's impacts of all contacts that close, those at rest and the ties answering."""
        s, n = self.system, y.size // 2
        for _ in range(4):
            x, v = y[:n], y[n:]
            touching = [k for k, c in enumerate(s.contacts) if c.gap.residual(x)[0] < _CLOSED]
            rates = {k: float(s.contacts[k].gap.rows(x, v)[0][0] @ v) for k in touching}
            if not any(rate < -_CLOSED for rate in rates.values()):
                return y
            y = np.concatenate([x, self.impact(x, v, rates)])
        raise _Stopped("impacts without end")

    def impact(self, x: Array, v: Array, rates: dict[int, float]) -> Array:
        s = self.system
        for pattern in product([True, False], repeat=len(rates)):
            struck = [k for k, is_struck in zip(rates, pattern, strict=True) if is_struck]
            J, _ = _stack([*s.ties, *(s.contacts[k].gap for k in struck)], x, v)
            wanted = [max(0.0, -s.contacts[k].e * rates[k]) for k in struck]
            right = np.concatenate([np.zeros(len(J) - len(struck)), wanted])
            try:
                after, impulses = _solve(self.weights, J, v, right)
            except np.linalg.LinAlgError:
                continue
            impulses = impulses[len(J) - len(struck) :]
            others = [s.contacts[k].gap.rows(x, v)[0][0] @ after for k in rates if k not in struck]
            if all(p > -1e-12 for p in impulses) and all(rate > -_CLOSED for rate in others):
                for rate in wanted:
                    if 0 < rate < 0.05:
                        raise _Stopped("bounces ever lower")
                if any(p > 1e-9 and rates[k] > -_CLOSED for k, p in zip(struck, impulses, strict=True)):
                    raise _Stopped("what rests at one contact is struck at another: no one answer")
                return after
        raise _Stopped("no impact fits")

    # ---------------------------------------------------------------- the motion

    def watches(self, state: State, n: int) -> list["_Watch"]:
        s, found = self.system, []
        for k, (contact, is_closed) in enumerate(zip(s.contacts, state.closed, strict=True)):
            if is_closed:
                left = replace(state, closed=tuple(c and j != k for j, c in enumerate(state.closed)))
                found.append(_Watch(lambda t, y, k=k: float(self.accelerations(t, y, state)[1][k]), -1, left))
            else:
                found.append(_Watch(lambda t, y, gap=contact.gap: float(gap.residual(y[:n])[0]), -1))
        for k, (brake, slides) in enumerate(zip(s.brakes, state.slides, strict=True)):
            if slides:
                found.append(_Watch(lambda t, y, tie=brake.tie, d=slides: d * float(tie.rows(y[:n], y[n:])[0][0] @ y[n:]), -1))
                continue
            for sign in (-1, 1):  # torn off into this direction, where friction pushes against it by all it has
                torn = replace(state, slides=tuple(sign if j == k else old for j, old in enumerate(state.slides)))
                found.append(_Watch(lambda t, y, k=k, b=brake, d=sign: b.F + d * float(self.accelerations(t, y, state)[2][k]),
                                    -1, torn))
        return found + [_Watch(lambda t, y, kink=kink: kink(y[:n]), 0) for kink in s.kinks]

    def advance(self, t: float, y: Array, state: State, until: float) -> tuple[float, Array, State | None, bool]:
        """To `until` or the next event: the state after it where that is known, and whether there was one."""
        n = y.size // 2
        watches = self.watches(state, n)
        # What is at its threshold already is not met there again: it is looked at once it has left it.
        live = [watch for watch in watches if abs(watch(t, y)) > 1e-11]
        late = [watch for watch in watches if watch not in live]
        end = min(until, t + 1e-5) if late else until

        def slope(t: float, y: Array) -> Array:
            return np.concatenate([y[n:], self.accelerations(t, y, state)[0]])

        solution = solve_ivp(slope, (t, end), y, method="DOP853", rtol=self.rtol, atol=1e-14, max_step=self.max_step, events=live)
        if solution.status < 0 or not np.isfinite(solution.y).all():
            raise _Stopped("the integration failed")
        t, y = float(solution.t[-1]), solution.y[:, -1]
        fired = [watch for watch, times in zip(live, solution.t_events or (), strict=True) if len(times)]
        fired += [watch for watch in late if watch.direction < 0 and watch(t, y) < -1e-11]
        return t, y, fired[0].after if len(fired) == 1 else None, bool(fired)

    def rows(self, x0: Array, v0: Array, times: Sequence[float]) -> Motion:
        y, t = np.concatenate([x0, v0]), 0.0
        rows: list[Array] = []
        try:
            y, state = self.choose(t, y)
            for row in times:
                while t < row:
                    t, y, after, is_event = self.advance(t, self.project(y, state), state, row)
                    if is_event:
                        self.events += 1
                        if self.events > 60:
                            raise _Stopped("events without end")
                        y, state = (y, after) if after is not None else self.choose(t, y)
                    y = self.project(y, state)
                rows.append(y[: len(x0)])
        except (_Stopped, np.linalg.LinAlgError) as stopped:
            self.why = str(stopped)
        return Motion(np.array(rows).reshape(-1, len(x0)), len(rows), self.events, self.why)


def _stack(ties: Sequence[Tie], x: Array, v: Array) -> tuple[Array, Array]:
    found = [tie.rows(x, v) for tie in ties]
    if not found:
        return np.zeros((0, x.size)), np.zeros(0)
    return np.vstack([J for J, _ in found]), np.concatenate([bias for _, bias in found])


def reference(system: System, x0: Array, v0: Array, times: Sequence[float], *, max_step: float = inf,
              rtol: float = 1e-12) -> Motion:
    """Places of all bodies at ascending `times` (s) from 0 on, as far as they can be told."""
    return _Run(system, max_step, rtol).rows(x0, v0, times)
