"""A run that begins in steady motion: given rates stay as they are, and all else stands still beside them.

A relative equilibrium (E.J. Routh, 1877): accelerations know nothing of the coordinates whose rates are given, the cyclic ones;
all others are where no coordinate is accelerated, and first-order states are where their rates vanish. Attitudes are looked for
as a whole, in small turns (turned.py), whether their rates are given or not: a body spins steadily about some of its axes, and
those point somewhere.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lagrangia.base.checked_values import by_name
from lagrangia.base.diagnostics import RunError, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.run.request import check_values
from lagrangia.study.rest_start import RestStart, start_at_rest
from lagrangia.study.turned import product, turned_of

_STEPS, _HALVES, _SMALL, _CLOSED, _TINY = 60, 12, 1e-13, 1e-9, 1e-300
_LOOKS = (0.7, 2.3, 5.9)  # radians or metres, and seconds: further on and later it is to be the same


def begun(model: Any, start_from: "str | Mapping[str, float]", parameters: Any, guesses: Any, inputs: Any, time: float
          ) -> RestStart:
    """At rest ("equilibrium"), or in steady motion: with the rates that are mapped, or ("steady") those among the guesses. Raises
    LagError, RunError."""
    if isinstance(start_from, str) and start_from != "steady":
        return start_at_rest(model, start_from, parameters, guesses, inputs, time)
    rates = {} if isinstance(start_from, str) else by_name("from_", start_from)
    return start_steady(model, rates, parameters, guesses, inputs, time)


def start_steady(model: Any, rates: Mapping[str, float], parameters: Any, guesses: Mapping[str, float] | None, inputs: Any,
                 time: float) -> RestStart:
    """The steady motion with these rates, or with those among the guesses, that is reached from the guesses. Raises LagError
    L0706, RunError."""
    scene, compilation = model.scene, model.compilation
    places = {rate.name: k for k, rate in enumerate(scene.rates)} | {name: k - scene.n for name, k in scene.aliases.items()}
    signals = [k for k, c in enumerate(scene.coordinates) if c.name in scene.signals]
    stated = {**(guesses or {}), **rates}
    given = {places[name]: value for name, value in stated.items() if name in places and places[name] not in signals}
    if unknown := next((name for name in rates if places.get(name, -1) not in given), None):
        fail("L0706", f"'{unknown}' is no rate of a coordinate", None, *filter(None, [suggest(unknown, places)]))
    if not given:
        fail("L0706", "steady motion is said by rates of coordinates, and none is given", None,
             'write: --from "steady hinge.w=12", or --from steady --initial hinge.w=12')
    if compilation.motion.constrained is not None:
        from lagrangia.study.steady_held import steady_held

        guessed = {name: value for name, value in stated.items() if places.get(name, -1) not in given}
        point, v = steady_held(model, parameters, guessed, inputs, time, given)
        return _told(scene, given, point, v)
    run = model.start(parameters=parameters, initial=stated, inputs=inputs, start=time)
    quaternions = np.array([[run[f"{name}[{k}]"] for k in range(1, 5)] for name in scene.attitudes]).reshape(-1, 4)
    q, v = np.array(run.state[: scene.n]), np.array(run.state[scene.n : 2 * scene.n])
    steady = _Steady(model, parameters, inputs, time, q, v, quaternions, given, signals)
    x, missed = steady.solved()
    wrong = steady.told_of(x, missed)
    if wrong:
        raise RunError(f"there is no such steady motion near the start values: {wrong}")
    q, v, turned = steady.state(x)
    point = {c.name: q[k] for k, c in enumerate(scene.coordinates) if k not in signals and c.name not in scene.turned}
    point |= steady.turned.told(np.zeros(scene.n), turned)
    point |= {scene.signals[name]: v[k] for k in signals if (name := scene.coordinates[k].name) not in scene.inner}
    return _told(scene, given, point, v)


def _told(scene: Any, given: Mapping[int, float], point: Mapping[str, float], v: "np.ndarray") -> RestStart:
    """`point`: positions, quaternions and first-order states by their names; v (n,)."""
    rates = {rate.name: v[k] for k, (c, rate) in enumerate(zip(scene.coordinates, scene.rates, strict=True))
             if c.name not in scene.signals}
    known = {scene.coordinates[k].name for k in given if scene.coordinates[k].name not in scene.turned}
    shown = [f"{scene.rates[k].name} = {v[k]:.6g}" for k in sorted(given)]
    shown += [f"{name} = {value:.6g}" for name, value in point.items() if name not in known]
    more = f", ... ({len(shown)})" if len(shown) > 6 else ""
    return RestStart({name: float(value) for name, value in {**point, **rates}.items()},
                     f"starts in steady motion: {', '.join(shown[:6])}{more}")


@dataclass
class _Steady:
    """Unknown x: the positions whose rates are not given, small turns of all attitudes, and the first-order states. `quaternions`
    (attitudes, 4) are where the turns begin."""

    model: Any
    parameters: Any
    inputs: Any
    time: float
    q: "np.ndarray"
    v: "np.ndarray"
    quaternions: "np.ndarray"
    given: Mapping[int, float]
    signals: list[int]

    def __post_init__(self) -> None:
        model, values = self.model, check_values(self.model.scene, self.parameters, None, self.inputs)
        self.turned = turned_of(model.scene)
        turned, firsts = self.turned.all, self.turned.firsts
        self.columns = [(k, firsts.index(k) if k in firsts else None) for k in range(model.scene.n)
                        if k in firsts or k not in turned]
        self.places = [k for k in range(model.scene.n) if k in turned or (k not in self.given and k not in self.signals)]
        self.p = model.parameter_values(self.parameters)
        self.u = np.array(values.input_values[: len(model.scene.inputs)])
        self.function = model.functions(given=self.parameters or ())["rhs"]
        self.derivatives = self.function.factory("derivatives", self.function.name_in(),
                                                 [f"jac:{self.function.name_out(0)}:{self.function.name_in(k)}" for k in (1, 2)])
        self.q[turned] = 0.0
        for k in range(model.scene.n):
            if k not in self.signals:
                self.v[k] = self.given.get(k, 0.0)

    def state(self, x: "np.ndarray") -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
        """Positions with nothing turned, rates, and the quaternions."""
        q, v, n = self.q.copy(), self.v.copy(), len(self.places)
        q[self.places], v[self.signals] = x[:n], x[n:]
        q, quaternions = self.turned.centred(q, self.quaternions)
        return q, v, quaternions

    def told(self, q: "np.ndarray", quaternions: "np.ndarray") -> "np.ndarray":
        """Positions in the order of Model.position_names."""
        return np.concatenate([q[k : k + 1] if which is None else quaternions[which] for k, which in self.columns])

    def told_by(self, quaternions: "np.ndarray") -> "np.ndarray":
        """Derivatives of what is told by positions, (told, n), where small turns d are dQ = Q (0, d)/2."""
        still = np.eye(self.q.size)
        return np.vstack([still[k] if which is None else
                          np.array([product(quaternions[which], turn) for turn in np.eye(4)[1:] / 2]).T @ still[k : k + 3]
                          for k, which in self.columns])

    def accelerations(self, x: "np.ndarray", after: float = 0.0, later: float = 0.0) -> "np.ndarray":
        """Of all coordinates, as far on as the given rates lead `after` so many seconds, or when it is `later`."""
        q, v, quaternions = self.state(x)
        on = self.turned.advanced(q, np.where(np.isin(np.arange(q.size), self.signals), 0.0, v), after)
        q, quaternions = self.turned.centred(on, quaternions)
        return np.array(self.function(self.time + later, self.told(q, quaternions), v, self.u, self.p), dtype=float).ravel()

    def residual(self, x: "np.ndarray") -> "np.ndarray":
        return self.accelerations(x)[[*self.places, *self.signals]]

    def slopes(self, x: "np.ndarray") -> "np.ndarray":
        """Of the accelerations of all coordinates, by x."""
        q, v, quaternions = self.state(x)
        by_q, by_v = (np.array(each, dtype=float) for each in
                      self.derivatives(self.time, self.told(q, quaternions), v, self.u, self.p))
        return np.hstack([(by_q @ self.told_by(quaternions))[:, self.places], by_v[:, self.signals]])

    def solved(self) -> "tuple[np.ndarray, float]":
        """By Newton's method, shortened where it leads away; how far the last step went."""
        x = np.concatenate([self.q[self.places], self.v[self.signals]])
        step = 0.0
        for _ in range(_STEPS if x.size else 0):
            r = self.residual(x)
            if not np.isfinite(r).all():
                return x, np.inf
            dx = -np.linalg.lstsq(self.slopes(x)[[*self.places, *self.signals]], r, rcond=1e-9)[0]
            scale = 1.0
            for _ in range(_HALVES):
                if np.linalg.norm(self.residual(x + scale * dx)) <= np.linalg.norm(r):
                    break
                scale /= 2
            x = self.recentred(x + scale * dx)
            step = float(np.abs(dx / np.maximum(1.0, np.abs(x))).max())
            if step < _SMALL:
                break
        return x, step

    def recentred(self, x: "np.ndarray") -> "np.ndarray":
        """The same, with quaternions from which nothing is turned."""
        _, _, self.quaternions = self.state(x)
        return np.where(np.isin(np.arange(x.size), np.flatnonzero(np.isin(self.places, self.turned.all))), 0.0, x)

    def told_of(self, x: "np.ndarray", missed: float) -> str:
        """Why it is none; "" where it is one."""
        scene, a = self.model.scene, self.accelerations(x)
        size = np.abs(self.slopes(x)) @ np.maximum(1.0, np.abs(x)) if x.size else np.zeros(scene.n)
        size = size + max(abs(w) for w in self.given.values()) ** 2 + _TINY
        if not np.isfinite(a).all() or missed > np.sqrt(_CLOSED):
            return "positions at which nothing else is accelerated are not found; try other guesses with --initial"
        worst = int(np.argmax(np.abs(a) / size))
        if abs(a[worst]) > _CLOSED * size[worst]:
            name = scene.coordinates[worst].name
            why = "something has to drive it" if worst in self.given else "try other guesses with --initial"
            return f"{name} is accelerated ({a[worst]:.3g}); {why}"
        moments = [look / abs(w) for w in self.given.values() if w for look in _LOOKS]
        for what, others in (("the positions whose rates are given", (self.accelerations(x, after=moment) for moment in moments)),
                             ("time", (self.accelerations(x, later=look) for look in _LOOKS))):
            if not all((np.abs(other - a) <= _CLOSED * size).all() for other in others):
                return f"accelerations depend on {what}, so that nothing stays as it is"
        return ""
