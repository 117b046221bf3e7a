"""Small motion over time, beside a run: z' = A z + B w + drift from the run's first row, excited as the run is.

Between fine times w is linear, so that z follows exactly from exponentials:

    exp([A h, B h, 0; 0, 0, 1; 0, 0, 0]) = [Phi, G1, G2; ...],   z(t + h) = Phi z + (G1 - G2) w(t) + G2 w(t + h)

(Franklin, Powell, Workman, Digital Control of Dynamic Systems, 1998, 4.3: the triangle hold).
"""

from collections.abc import Callable, Sequence
from functools import cache
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import fail
from lagrangia.compile.functions import observer
from lagrangia.language.samplers import refuse_held
from lagrangia.run.request import Values
from lagrangia.study.analysis import Study
from lagrangia.study.linearization import Linearization
from lagrangia.study.turned import between
from lagrangia.view.rows import columns, moments

if TYPE_CHECKING:
    from lagrangia.compile.pipeline import Compilation

Matrix = NDArray[np.float64]
_A_PERIOD = 40  # fine times in the shortest period of the scene
_MOST = 200  # between two rows
_LEAST = 8
_TERMS, _SMALL = 18, 0.5


def small_run(compilation: "Compilation", values: Values, rows: Matrix, names: Sequence[str]) -> dict[str, Matrix]:
    """Quantities of the small motion about the equilibrium near the start, at the times of the rows, (rows,) each.

    Raises LagError L0918 for rolling and for inputs whose rates matter; RunError where there is no equilibrium.
    """
    refuse_held(compilation.flat, "small motion over time")
    study = Study(compilation, values, float(rows[0, 0]))
    linear = study.linearize("equilibrium", None, names)
    scene = compilation.scene
    if linear.tangent.W.shape[1] < len(linear.coordinates):
        fail("L0918", "not supported yet: small motion over time of a scene that rolls without slip", compilation.flat.span)
    own = {known.name for known in scene.inputs}
    for (order, k), name in zip(linear.input_orders, linear.inputs, strict=True):
        if order and linear.excitations[k] in own:
            fail("L0918", f"not supported yet: small motion over time that depends on {name}, the rate of an input",
                 compilation.flat.span)
    with np.errstate(all="ignore"):  # what runs away leaves the range of numbers
        y = _follow(linear, _first(study, linear, rows[0]), rows[:, 0], lambda t: _exciting(study, linear, values, t))
    return dict(zip(linear.outputs, y, strict=True))


def _first(study: Study, linear: Linearization, row: Matrix) -> Matrix:
    """The states at a row less those at the point: of attitudes the turns from there."""
    scene, point = study.scene, linear.point
    now = {column.name: float(x) for column, x in zip(columns(scene), row, strict=False)}
    states: dict[str, float] = {}
    for place, rate in zip(scene.coordinates, scene.rates, strict=True):
        change = now[rate.name] - point.get(rate.name, 0.0)  # of a first-order state, which is a rate
        states |= {place.name: now[place.name] - point.get(place.name, 0.0), f"der({place.name})": change, rate.name: change}
    for reference, (name, parts) in zip(study.turned.read(point), scene.attitudes.items(), strict=True):
        turn = between(reference, np.array([now[f"{name}[{k}]"] for k in range(1, 5)]))
        states |= dict(zip(parts, turn, strict=True))
    return np.array([states[name] for name in linear.states])


def _exciting(study: Study, linear: Linearization, values: Values, times: Matrix) -> Matrix:
    """What the inputs of the state-space form are at these times, less what they are at the point: (inputs, times)."""
    c = study.c
    if not linear.inputs:
        return np.zeros((0, times.size))
    _, function = observer(c.kinematics, c.motion, c.constraints, linear.inputs)
    here = np.tile([linear.point.get(column.name, 0.0) for column in columns(c.scene)], (times.size + 1, 1))
    here[:, 0] = np.append(times, study.time)
    found = np.array(function(*moments(c.scene, study.p, values, here)))
    is_placed = np.array([[order == 0] for order, _ in linear.input_orders])
    return np.asarray(found[:, :-1] - np.where(is_placed, found[:, -1:], 0.0))


def _follow(linear: Linearization, z: Matrix, times: Matrix, exciting: Callable[[Matrix], Matrix]) -> Matrix:
    """(outputs, times)."""
    n, drift = z.size, linear.drift.reshape(-1, 1)
    B = np.hstack([linear.B, drift])
    fastest = float(np.abs(linear.eigenvalues).max(initial=0.0)) / (2 * np.pi)
    parts = [min(_MOST, max(_LEAST, int(np.ceil(_A_PERIOD * fastest * h)))) for h in np.diff(times)]
    fine = np.concatenate([times[:1], *[np.linspace(a, b, k + 1)[1:] for a, b, k in zip(times, times[1:], parts, strict=False)]])
    w = np.vstack([exciting(fine), np.ones(fine.size)])
    step = cache(lambda h: _held(linear.A, B, h))
    states, at = [z], 0
    for h, count in zip(np.diff(times), parts, strict=True):
        Phi, G0, G1 = step(float(f"{h / count:.12g}"))
        for _ in range(count):
            z = Phi @ z + G0 @ w[:, at] + G1 @ w[:, at + 1]
            at += 1
        states.append(z)
    rows = np.concatenate([[0], np.cumsum(parts, dtype=int)])
    found = linear.output @ np.array(states).T.reshape(n, -1) + linear.D @ w[:-1, rows]
    return np.asarray(found + np.array(linear.outputs_at_point)[:, None])


def _held(A: Matrix, B: Matrix, h: float) -> tuple[Matrix, Matrix, Matrix]:
    n, k = B.shape
    whole = np.zeros((n + 2 * k, n + 2 * k))
    whole[:n, :n], whole[:n, n : n + k] = A * h, B * h
    whole[n : n + k, n + k :] = np.eye(k)
    E = exponential(whole)
    G1, G2 = E[:n, n : n + k], E[:n, n + k :]
    return E[:n, :n], G1 - G2, G2


def exponential(X: Matrix) -> Matrix:
    """Of a matrix, by Taylor's series of X/2^s, squared s times."""
    size = float(np.abs(X).sum(axis=0).max(initial=0.0))
    halvings = max(0, int(np.ceil(np.log2(size / _SMALL)))) if size > 0 else 0
    X = X / 2.0**halvings
    E = term = np.eye(len(X))
    for k in range(1, _TERMS + 1):
        term = term @ X / k
        E = E + term
    for _ in range(halvings):
        E = E @ E
    return E
