"""A run that begins in steady motion: given rates stay as they are, and all else stands still beside them.

A relative equilibrium (E.J. Routh, 1877): accelerations know nothing of the coordinates whose rates are given, the cyclic ones;
all others are where no coordinate is accelerated, and first-order states are where their rates vanish.
"""

from collections.abc import Mapping
from typing import Any

import numpy as np

from lagrangia.base.checked_values import by_name
from lagrangia.base.diagnostics import RunError, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.frames.attitude_starts import HINGES, refuse_attitudes
from lagrangia.run.request import check_values
from lagrangia.study.rest_start import RestStart, start_at_rest

_STEPS, _HALVES, _SMALL, _CLOSED, _TINY = 60, 12, 1e-13, 1e-9, 1e-300
_LOOKS = (0.7, 2.3, 5.9)  # radians or metres, and seconds: elsewhere and later it is to be the same


def begun(model: Any, start_from: "str | Mapping[str, float]", parameters: Any, guesses: Any, inputs: Any, time: float
          ) -> RestStart:
    """At rest ("equilibrium"), or in steady motion: with the rates that are mapped, or ("steady") those among the guesses. Raises
    LagError, RunError."""
    if isinstance(start_from, str) and start_from != "steady":
        return start_at_rest(model, start_from, parameters, guesses, inputs, time)
    return start_steady(model, by_name("from_", {} if start_from == "steady" else start_from), parameters, guesses, inputs, time)


def start_steady(model: Any, rates: Mapping[str, float], parameters: Any, guesses: Mapping[str, float] | None, inputs: Any,
                 time: float) -> RestStart:
    """The steady motion with these rates, or with those among the guesses, that is reached from the guesses. Raises LagError
    L0706, L0901, RunError."""
    scene, compilation = model.scene, model.compilation
    refuse_attitudes(compilation.graph.attitudes, "a start in steady motion", "state its rates with --initial", HINGES)
    if compilation.motion.constrained is not None:
        fail("L0901", "not supported yet: a start in steady motion of a scene with closed loops or rolling", None,
             "state its rates and positions with --initial")
    places = {rate.name: k for k, rate in enumerate(scene.rates)} | {name: k - scene.n for name, k in scene.aliases.items()}
    signals = [k for k, c in enumerate(scene.coordinates) if c.name in scene.signals]
    stated = {**(guesses or {}), **rates}
    given = {places[name]: value for name, value in stated.items() if name in places and places[name] not in signals}
    if unknown := next((name for name in rates if places.get(name, -1) not in given), None):
        fail("L0706", f"'{unknown}' is no rate of a coordinate", None, *filter(None, [suggest(unknown, places)]))
    if not given:
        fail("L0706", "steady motion is said by rates of coordinates, and none is given", None,
             'write: --from "steady hinge.w=12", or --from steady --initial hinge.w=12')
    run = model.start(parameters=parameters, initial=stated, inputs=inputs, start=time)
    state = run.state
    q, v = np.array(state[: scene.n]), np.array(state[scene.n : 2 * scene.n])
    steady = _Steady(model, parameters, inputs, time, q, v, given, signals)
    x, missed = steady.solved()
    wrong = steady.told_of(x, missed)
    if wrong:
        raise RunError(f"there is no such steady motion near the start values: {wrong}")
    q, v = steady.state(x)
    values = {c.name: q[k] for k, c in enumerate(scene.coordinates) if k not in signals}
    values |= {rate.name: v[k] for k, rate in enumerate(scene.rates) if k not in signals}
    values |= {name: v[k] for k, name in ((k, scene.signals[scene.coordinates[k].name]) for k in signals)}
    shown = [f"{rate.name} = {v[k]:.6g}" for k, rate in enumerate(scene.rates) if k in given]
    shown += [f"{scene.coordinates[k].name} = {q[k]:.6g}" for k in steady.places]
    more = f", ... ({len(shown)})" if len(shown) > 6 else ""
    return RestStart({name: float(value) for name, value in values.items()},
                     f"starts in steady motion: {', '.join(shown[:6])}{more}")


@dataclass
class _Steady:
    """Unknown x: the positions whose rates are not given, and the first-order states."""

    model: Any
    parameters: Any
    inputs: Any
    time: float
    q: "np.ndarray"
    v: "np.ndarray"
    given: Mapping[int, float]
    signals: list[int]

    def __post_init__(self) -> None:
        model, values = self.model, check_values(self.model.scene, self.parameters, None, self.inputs)
        self.places = [k for k in range(model.scene.n) if k not in self.given and k not in self.signals]
        self.p = model.parameter_values(self.parameters)
        self.u = np.array(values.input_values[: len(model.scene.inputs)])
        self.function = model.functions(given=self.parameters or ())["rhs"]
        self.derivatives = self.function.factory("derivatives", self.function.name_in(),
                                                 [f"jac:{self.function.name_out(0)}:{self.function.name_in(k)}" for k in (1, 2)])
        for k in range(model.scene.n):
            if k not in self.signals:
                self.v[k] = self.given.get(k, 0.0)

    def state(self, x: "np.ndarray") -> "tuple[np.ndarray, np.ndarray]":
        q, v, n = self.q.copy(), self.v.copy(), len(self.places)
        q[self.places], v[self.signals] = x[:n], x[n:]
        return q, v

    def accelerations(self, x: "np.ndarray", moved: float = 0.0, later: float = 0.0) -> "np.ndarray":
        """Of all coordinates, the given ones `moved` by so much."""
        q, v = self.state(x)
        q[list(self.given)] += moved
        return np.array(self.function(self.time + later, q, v, self.u, self.p), dtype=float).ravel()

    def residual(self, x: "np.ndarray") -> "np.ndarray":
        return self.accelerations(x)[[*self.places, *self.signals]]

    def slopes(self, x: "np.ndarray") -> "np.ndarray":
        """Of the accelerations of all coordinates, by x."""
        q, v = self.state(x)
        by_q, by_v = (np.array(each, dtype=float) for each in self.derivatives(self.time, q, v, self.u, self.p))
        return np.hstack([by_q[:, self.places], by_v[:, self.signals]])

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
            x = x + scale * dx
            step = float(np.abs(dx / np.maximum(1.0, np.abs(x))).max())
            if step < _SMALL:
                break
        return x, step

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
        for look in _LOOKS:
            for what, other in (("the positions whose rates are given", self.accelerations(x, moved=look)),
                                ("time", self.accelerations(x, later=look))):
                if not (np.abs(other - a) <= _CLOSED * size).all():
                    return f"accelerations depend on {what}, so that nothing stays as it is"
        return ""
