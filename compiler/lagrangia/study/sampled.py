"""Small motion with a sampled controller: from instant to instant, z_{k+1} = A z_k + B w_k.

z are the states of the mechanism and all values that are held, just before an instant; w are inputs, held over a period. A period
is its instants and the flows between them, of the mechanism with constant inputs: exact, by exponentials of A t with B beside.
"""

from dataclasses import replace

import casadi as ca
import numpy as np

from lagrangia.base.cutting import stem
from lagrangia.base.diagnostics import fail
from lagrangia.dynamics.sampling import find_sampling
from lagrangia.language.moving_inputs import rate_inputs
from lagrangia.study.analysis import Study
from lagrangia.study.linearization import Linearization, Matrix, Sampled
from lagrangia.study.small_run import exponential

_SAME = 1e-9  # of an interval: instants that are one
_AT_REST = 1e-9
_MOST_INSTANTS = 50  # in which a controller comes to rest


def with_sampled_system(study: Study, linear: Linearization, about: str) -> Linearization:
    """The linearisation of the mechanism with the sampled system beside it. Raises LagError L0901 for several intervals."""
    held = [name for sampler in study.c.flat.samplers for name in (x.name for x in sampler.held)]
    moving = {name for name, is_placing in study.c.flat.moving_inputs.items() if is_placing} | rate_inputs(study.c.flat)
    inputs = [item.name for item in study.scene.inputs if stem(item.name) not in moving and item.name not in moving]
    flow = study.linearize(about, [*inputs, *held], ())
    columns = {name: flow.B[:, k] for k, name in enumerate(flow.inputs)}
    nothing = np.zeros(len(flow.states))
    B_w, B_h = (np.array([columns.get(name, nothing) for name in names]).T.reshape(nothing.size, len(names))
                for names in (inputs, held))
    interval, phases = _phases(study)
    at = _Sampler(study, flow, inputs)
    at.settle(B_h)
    n, h, w = nothing.size, len(held), len(inputs)
    whole, now = np.eye(n + h + w), 0.0
    for phase, fires in phases:
        whole = at.instant(fires) @ _over(flow.A, B_h, B_w, phase - now) @ whole
        now = phase
    whole = _over(flow.A, B_h, B_w, interval - now) @ whole
    notes = at.told(held)
    return replace(linear, sampled=Sampled(interval, (*flow.states, *held), tuple(inputs), whole[: n + h, : n + h],
                                           whole[: n + h, n + h :]), notes=(*linear.notes, *notes))


def _over(A: Matrix, B_h: Matrix, B_w: Matrix, t: float) -> Matrix:
    """z, h and w after a time in which h and w stay as they are."""
    n, others = len(A), B_h.shape[1] + B_w.shape[1]
    return exponential(np.block([[A, B_h, B_w], [np.zeros((others, n + others))]]) * t)


def _phases(study: Study) -> tuple[float, list[tuple[float, Matrix]]]:
    """The interval, and its instants from the first one on, with which samplers fire."""
    kinematics = study.c.kinematics
    of = {mode.of_sampler[0]: mode.arguments[0] for mode in kinematics.algebra.modes if mode.of_sampler is not None}
    arguments = ca.vertcat(*[of[k] for k in range(len(of))])
    table = ca.Function("instants", [kinematics.symbols.time, study.c.motion.p], [arguments])
    first, second = (table(t, study.p).full().ravel() for t in (0.0, 1.0))
    intervals = 1 / (second - first)
    interval = float(intervals[0])
    if np.abs(intervals - interval).max() > _SAME * interval:
        fail("L0901", "not supported yet: the sampled system of several intervals", study.c.flat.samplers[1].span,
             "lag simulate and FMUs have them")
    starts = -first * interval
    phases = np.mod(starts - starts.min(), interval)
    phases[np.abs(phases - interval) < _SAME * interval] = 0.0
    found: list[tuple[float, Matrix]] = []
    for phase in sorted(set(phases)):
        if not found or phase - found[-1][0] > _SAME * interval:
            found.append((float(phase), (np.abs(phases - phase) <= _SAME * interval).astype(float)))
    return interval, found


class _Sampler:
    def __init__(self, study: Study, flow: Linearization, inputs: list[str]) -> None:
        c, self.study = study.c, study
        sampling, m = find_sampling(c.struck), c.motion
        symbols = [mode.symbol for mode in c.kinematics.algebra.modes]
        self.samplers = list(sampling.samplers)
        self.held = ca.vertcat(*[symbols[k] for k in sampling.places])
        others = [mode for mode in c.kinematics.algebra.modes if mode.of_sampler is None]
        values = ca.substitute(sampling.values, ca.vertcat(*[x.symbol for x in others]), ca.vertcat(*[x.value for x in others])) \
            if others else sampling.values
        slopes = [ca.densify(ca.jacobian(values, x)) for x in (m.q, m.v, m.u, self.held)]
        arguments = [m.t, m.q, m.v, m.u, m.p, self.held, sampling.fires]
        self.function = ca.Function("samples", arguments, [values, *slopes, sampling.first])
        rates = {f"der({name})": state for name, state in study.scene.signals.items()}
        self.q = np.array([0.0 if name in study.scene.signals else flow.point[name] for name in study.names])
        self.v = np.array([flow.point.get(rates.get(f"der({name})", ""), 0.0) for name in study.names])
        f, pace = len(flow.coordinates), flow.tangent.W
        raw = [*flow.coordinates, *(pace.shape[1] * [""])]
        kept = [k for k, name in enumerate(raw) if name not in study.scene.signals]
        N = flow.tangent.N
        self.of_q = np.hstack([N, np.zeros((N.shape[0], pace.shape[1]))])[:, kept]
        self.of_v = np.hstack([np.zeros((N.shape[0], f)), N @ pace])[:, kept]
        names = [item.name for item in study.scene.inputs]
        self.of_u = np.array([[float(name == own) for own in inputs] for name in names]).reshape(len(names), len(inputs))
        nothing = np.zeros(self.held.numel()), np.ones(len(study.c.flat.samplers))
        self.held_there = np.array(self.function(*self._here(*nothing))[5]).ravel()

    def _here(self, held: Matrix, fires: Matrix) -> tuple[object, ...]:
        return self.study.time, self.q, self.v, self.study.u, self.study.p, held, fires[self.samplers]

    def instant(self, fires: Matrix) -> Matrix:
        """z, h and w just after an instant in terms of those before."""
        _, q, v, u, h, _ = (x.full() for x in self.function(*self._here(self.held_there, fires)))
        n, size, w = self.of_q.shape[1], h.shape[0], self.of_u.shape[1]
        found = np.eye(n + size + w)
        found[n : n + size] = np.hstack([q @ self.of_q + v @ self.of_v, h, u @ self.of_u])
        return found

    def _next(self, held: Matrix) -> Matrix:
        fires = np.ones(len(self.study.c.flat.samplers))
        return np.asarray(self.function(*self._here(held, fires))[0].full().ravel())

    def settle(self, B_h: Matrix) -> None:
        """Held values come to rest where the mechanism does, if it stays there."""
        held = self.held_there
        for _ in range(_MOST_INSTANTS):
            held, before = self._next(held), held
            if np.abs(held - before).max(initial=0.0) <= _AT_REST * (1 + np.abs(held).max(initial=0.0)):
                stays = np.abs(B_h @ (held - self.held_there)).max(initial=0.0) <= _AT_REST
                self.held_there = held if stays else self.held_there
                return

    def told(self, names: list[str]) -> list[str]:
        """Whether the controller rests there as well."""
        here, wanted = self.held_there, self._next(self.held_there)
        off = [k for k in range(len(names)) if abs(wanted[k] - here[k]) > _AT_REST * (1 + abs(here[k]))]
        if not off:
            return []
        what = ", ".join(f"{names[k]} = {here[k]:.6g}, not {wanted[k]:.6g}" for k in off[:4])
        return [f"held values are taken as they are at first ({what}, which they would be from the next instant on): the sampled "
                "system tells of deviations alone"]
