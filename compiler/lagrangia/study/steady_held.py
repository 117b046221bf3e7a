"""Steady motion where loops or rolling hold it, by all equations at once.

With the given rates u, those of followers w, and all others 0, are looked for: positions q, w, followers' accelerations b and
multipliers lambda, so that

    M a + h(q, v) + A^T lambda = 0,   Phi(q) = 0,   A v + b0 = 0,   d/dt (A v + b0) = 0,

where nothing but followers is accelerated. The first is not asked of the given rates: what is left there has to drive them.
Followers may be accelerated, as the place of a wheel that rolls round a circle is (steady in its own axes): they are those whose
places nothing depends on, as far as rows tie them; where that is none, as for a ring that goes round with others, as many as rows
tie, first those that the given rates lead.
"""

from copy import copy
from typing import TYPE_CHECKING, Any, Self

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import RunError
from lagrangia.base.records import dataclass
from lagrangia.study.linearization import pivots
from lagrangia.study.moving import accelerations

if TYPE_CHECKING:
    from collections.abc import Iterator, Mapping

    from lagrangia.study.analysis import Study

Vector = NDArray[np.float64]
_STEPS, _HALVES, _SMALL, _CLOSED, _RANK, _TINY = 60, 12, 1e-12, 1e-9, 1e-11, 1e-300
_LOOKS = (0.7, 2.3, 5.9)  # radians or metres, and seconds: further on and later it is to be the same
_IDLE, _LIGHT = 1e3, 1e-6  # how much sooner than others those follow on whose places nothing depends, and how late those at rest


@dataclass(frozen=True)
class State:
    """Positions, rates, accelerations (n,) and multipliers (m,)."""

    q: Vector
    v: Vector
    a: Vector
    lam: Vector


class SteadyHeld:
    """`given`: rates by places of coordinates."""

    def __init__(self, study: "Study", given: "Mapping[int, float]", is_wide: bool) -> None:
        self.study, self.given, self.e = study, given, study.equations()
        self.n, self.reach = study.scene.n, study.reach
        self.u = list(given)
        self.states = study.signals.places
        self.others = [k for k in range(self.n) if k not in given]  # whose forces are in balance
        self.places = [k for k in self.others if k not in self.states]
        q, v = study.start
        rates = np.where(np.isin(np.arange(self.n), self.states), v, 0.0)
        rates[self.u] = list(given.values())
        self.pace = float(max(abs(w) / self.reach[k] for k, w in given.items())) or 1.0
        self.followers = self._followers(q, rates, is_wide)
        start = State(q, rates, np.zeros(self.n), np.zeros(self.e.m))
        self.force = float(np.abs(self._forces(start) * self.reach).max(initial=_TINY))
        self.begin = self._following(start)

    def _forces(self, x: State) -> Vector:
        return self.study.call(self.e.static, x.q, self.e.multipliers(x.lam), 1.0, x.v, x.a)[0].ravel()

    def _followers(self, q: Vector, v: Vector, is_wide: bool) -> list[int]:
        """Places of rates that follow from the others: of those on which nothing depends; `is_wide`: of all."""
        aside = q + 0.1 * self.reach * np.random.default_rng(3).uniform(-1, 1, self.n) * np.isin(np.arange(self.n), self.places)
        aside[self.study.turned.all] = 0.0
        moved = v + self.pace * self.reach * np.random.default_rng(4).uniform(-1, 1, self.n)
        by = self._slopes(State(aside, moved, np.zeros(self.n), np.ones(self.e.m)))
        told = sum(np.abs(by[name]["q"]).sum(axis=0) for name in ("force", "rate", "second")) * self.reach
        idle = told <= _CLOSED * float(told.max(initial=_TINY))
        rows = self._slopes(State(q, v, np.zeros(self.n), np.zeros(self.e.m)))["rate"]["v"]
        rate = self.study.call(self.e.static, q, self.e.multipliers(), 1.0, v)[2].ravel()
        led = np.zeros(self.n)
        led[self.places] = np.abs(np.linalg.lstsq((rows * self.reach)[:, self.places], -rate, rcond=_CLOSED)[0])
        weight = np.where(idle, _IDLE, _LIGHT + led / max(float(led.max(initial=0.0)), self.pace * _CLOSED))
        places = [k for k in self.places if is_wide or idle[k]]
        return [places[k] for k in pivots(rows[:, places], (self.reach * weight)[places])]

    def _slopes(self, x: State) -> dict[str, dict[str, Vector]]:
        """Of forces, positions, rates and second rates by q, v, a and multipliers."""
        free, names = self.e.multipliers(x.lam), ("q", "v", "a", "lambda")
        by = self.study.slopes(self.e, self.e.slopes, names, x.q, free, 1.0, x.v, x.a)
        second = self.study.slopes(self.e, self.e.second_slopes, names, x.q, free, 1.0, x.v, x.a)
        found = {what: {name: by[name][k] for name in names} for k, what in enumerate(("force", "place", "rate"))}
        return found | {"second": {name: second[name][0] for name in names}}

    def residual(self, x: State) -> Vector:
        """In natural sizes: forces, positions, rates, second rates."""
        R, phi, rate, _ = (y.ravel() for y in self.study.call(self.e.static, x.q, self.e.multipliers(x.lam), 1.0, x.v, x.a))
        second = self.study.call(self.e.second, x.q, self.e.multipliers(), 1.0, x.v, x.a)[0].ravel()
        size = self.study.size
        return np.concatenate([(R * self.reach / self.force)[self.others], phi / size, rate / size / self.pace,
                               second / size / self.pace**2])

    def slopes(self, x: State) -> Vector:
        """Of the residual by x."""
        by, m, size = self._slopes(x), self.e.m, self.study.size
        rows = []
        for what, scale in (("force", self.reach[:, None] / self.force), ("place", 1 / size), ("rate", 1 / size / self.pace),
                            ("second", 1 / size / self.pace**2)):
            parts = by[what]
            row = np.hstack([parts["q"][:, self.places], parts["v"][:, self.moving], parts["a"][:, self.followers],
                             parts["lambda"][:, :m]]) * scale
            rows.append(row[self.others] if what == "force" else row)
        return np.vstack(rows)

    @property
    def moving(self) -> list[int]:
        """Places of the rates that are looked for."""
        return [*self.followers, *self.states]

    def moved(self, x: State, step: Vector) -> State:
        """By a step of q, w, b and multipliers."""
        parts = np.split(step, np.cumsum([len(self.places), len(self.moving), len(self.followers)]))
        q, v, a = x.q.copy(), x.v.copy(), x.a.copy()
        q[self.places] += parts[0]
        v[self.moving] += parts[1]
        a[self.followers] += parts[2]
        return State(q, v, a, x.lam + parts[3])

    def centred(self, x: State) -> "tuple[Self, State]":
        """The same where attitudes are told against those that are reached."""
        study, q = self.study.centred(x.q)
        return self.about(study), State(q, x.v, x.a, x.lam)

    def about(self, study: "Study") -> Self:
        """The same of another study."""
        other = copy(self)
        other.study = study
        return other

    def _following(self, x: State) -> State:
        """With rates of followers that the rows ask for, accelerations and multipliers."""
        v = x.v.copy()
        rate = self.study.call(self.e.static, x.q, self.e.multipliers(), 1.0, v)[2].ravel()
        rows = self._slopes(x)["rate"]["v"]
        v[self.followers] -= np.linalg.pinv(rows[:, self.followers], rcond=_CLOSED) @ rate
        a, lam = self._accelerated(x.q, v)
        kept = np.where(np.isin(np.arange(self.n), self.followers), a, 0.0)
        return State(x.q, v, kept, lam)

    def _accelerated(self, q: Vector, v: Vector) -> tuple[Vector, Vector]:
        """Accelerations and multipliers of the scene at a state."""
        still = State(q, v, np.zeros(self.n), np.zeros(self.e.m))
        by = self._slopes(still)
        bias = self.study.call(self.e.second, q, self.e.multipliers(), 1.0, v)[0].ravel()
        return accelerations(by["force"]["a"], by["rate"]["v"], self._forces(still), bias, self.reach)

    def solved(self) -> "tuple[Self, State, float]":
        """By Newton's method, shortened where it leads away; how far the last step went, in natural sizes."""
        here, x, step = self, self.begin, np.inf
        sizes = np.concatenate([self.reach[self.places], (self.reach * self.pace)[self.moving],
                                (self.reach * self.pace**2)[self.followers],
                                np.full(self.e.m, self.force / self.study.size)])
        for _ in range(_STEPS):
            r = here.residual(x)
            if not np.isfinite(r).all():
                return here, x, np.inf
            dx = -np.linalg.lstsq(here.slopes(x) * sizes, r, rcond=_RANK)[0]
            scale = 1.0
            for _ in range(_HALVES):
                if np.linalg.norm(here.residual(here.moved(x, scale * sizes * dx))) <= np.linalg.norm(r):
                    break
                scale /= 2
            here, x = here.centred(here.moved(x, scale * sizes * dx))
            step = float(np.abs(dx).max(initial=0.0))
            if step < _SMALL:
                break
        return here, x, step

    def told_of(self, x: State, missed: float) -> str:
        """Why it is none; "" where it is one."""
        left: Vector = np.abs(self.residual(x))
        rates = left[left.size - 2 * self.e.m : left.size - self.e.m]
        if not rates.max(initial=0.0) <= _CLOSED:
            row = self.study.c.constraints.rows[int(np.argmax(rates))]
            return f"{row.told} does not let all else rest beside the given rates; try other guesses with --initial"
        if missed > np.sqrt(_CLOSED) or not left.max(initial=0.0) <= _CLOSED:
            return "positions at which nothing else is accelerated are not found; try other guesses with --initial"
        a = self._accelerated(x.q, x.v)[0]
        free = [k for k in range(self.n) if k not in self.followers]
        size = self._sizes(x)
        worst = max(free, key=lambda k: abs(a[k]) / size[k])
        if not abs(a[worst]) <= _CLOSED * size[worst]:
            name = self.study.scene.coordinates[worst].name
            why = "something has to drive it" if worst in self.given else "try other guesses with --initial"
            return f"{name} is accelerated ({a[worst]:.3g}); {why}"
        for what, others in (("the positions whose rates are given", self._further(x)), ("time", self._later(x))):
            for other, state in others:
                after = other._accelerated(state.q, state.v)[0]
                gaps = other.study.call(self.e.static, state.q, self.e.multipliers(), 1.0, state.v)[1:3]
                closes = max(float(np.abs(y).max(initial=0.0)) / scale for y, scale in
                             zip(gaps, (self.study.size, self.study.size * self.pace), strict=True))
                if closes > _CLOSED or not (np.abs(after - a)[free] <= _CLOSED * size[free]).all():
                    return f"accelerations depend on {what}, so that nothing stays as it is"
        return ""

    def _sizes(self, x: State) -> Vector:
        """Of accelerations, (n,): those that forces alone would give, and those of the given rates."""
        M, still = self._slopes(x)["force"]["a"], State(x.q, x.v, np.zeros(self.n), np.zeros(self.e.m))
        parts = np.abs(np.linalg.lstsq(M, self._forces(still), rcond=_CLOSED)[0] / self.reach).max(initial=0.0)
        return np.asarray(self.reach * (parts + self.pace**2))

    def _further(self, x: State) -> "Iterator[tuple[Self, State]]":
        """As far on as the rates lead."""
        for moment in (look / abs(w) for w in self.given.values() if w for look in _LOOKS):
            study, q = self.study.advanced(x.q, np.where(np.isin(np.arange(self.n), self.states), 0.0, x.v), moment)
            other = self.about(study)
            yield other, other._following(State(q, x.v, x.a, x.lam))

    def _later(self, x: State) -> "Iterator[tuple[Self, State]]":
        """The same when it is later."""
        for moment in _LOOKS:
            study = copy(self.study)
            study.time = self.study.time + moment
            other = self.about(study)
            yield other, x


def steady_held(model: Any, parameters: Any, guesses: "Mapping[str, float]", inputs: Any, time: float,
                given: "Mapping[int, float]") -> tuple[dict[str, float], Vector]:
    """Positions, quaternions and first-order states by their names, and rates (n,). Raises RunError."""
    study, wrong = model.study(parameters, guesses, inputs, time), ""
    for is_wide in (False, True):
        found, x, missed = SteadyHeld(study, given, is_wide).solved()
        if not (left := found.told_of(x, missed)):
            states, inner = study.scene.signals, study.scene.inner
            point = {states.get(name, name): value for name, value in found.study.point(x.q, x.v).items()}
            return {name: value for name, value in point.items() if name not in inner}, x.v
        wrong = wrong or left
    raise RunError(f"there is no such steady motion near the start values: {wrong}")
