"""Small motion about a state that moves while loops or rolling hold it, in free coordinates x and free rates z.

Rows Phi(q) = 0 and A(q) v + b(q) = 0, and what second rates they have, let small changes be dq = N x, dv = P z + S x and
da = P z' + Tz z + Tx x, where x and z are entries of dq and dv. Virtual motion is along P, so that multipliers fall away:

    M' z' + C' z + K' x = -P^T (E0 s + E1 s' + E2 s''),   M' = P^T M P, C' = P^T (C P + M Tz), K' = P^T (C S + K N + M Tx)

with M, C, K as in linearization.py. Of a wheel that rolls forward, x' is not z alone: a small turn aside makes it leave its line.
First-order states are among z; nothing depends on the coordinates whose rates they are.
"""

from dataclasses import replace

import numpy as np

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.records import dataclass
from lagrangia.constraints.initial import FIXED, GUESS
from lagrangia.dynamics.equilibrium import onto_constraints
from lagrangia.study.linearization import (
    PREFERRED,
    Given,
    Linearization,
    Matrix,
    Tangent,
    TangentParts,
    inputs_of,
    inverse_mass,
    lengths_of_rows,
    observation,
    pivots,
    with_signals,
)
from lagrangia.study.moved import Held, Moment, State, Study
from lagrangia.study.small_motion import SmallMotion
from lagrangia.study.turning_axes import TurningAxes

_RANK, _STEADY = 1e-9, 1e-9
_NO_MASS = 1e-13  # of the heaviest, in natural sizes
_SEEN = ("attitudes turn, and small turns are told in the turned axes: frequencies are as they are seen from there, those of the "
         "world less or more by what it turns")
_TURNS = ("the motion there is steady in axes that turn with it, in which deviations and frequencies are told; inputs and "
          "outputs are of that moment")
_LATER = (0.0123, 1.71)  # s: moments at which steady motion is as it was


@dataclass(frozen=True)
class Choice:
    """The places of the coordinates and of the rates that follow from the others; `kept`: those of discrete variables."""

    dependent: list[int]
    followers: list[int]
    kept: list[int]


def choose(parts: TangentParts, weights: tuple[Matrix, Matrix], kept: list[int]) -> Choice:
    """`weights` (n,) each, of coordinates and rates: what weighs little stays free."""
    dependent = pivots(parts.J, weights[0])
    rolls = parts.rates.shape[0] > parts.J.shape[0]
    return Choice(dependent, pivots(parts.rates, weights[1]) if rolls else dependent, kept)


def held_changes(parts: TangentParts, turned: Matrix, second: tuple[Matrix, Matrix], choice: Choice) -> Held:
    """`turned` (m, n): d rate/dq; `second`: of the second rates by q and by v."""
    n, dependent, followers = parts.M.shape[0], choice.dependent, choice.followers
    coordinates = tuple(k for k in range(n) if k not in {*dependent, *choice.kept})
    rates = tuple(k for k in range(n) if k not in {*followers, *choice.kept})
    N, P = np.eye(n)[:, list(coordinates)], np.eye(n)[:, list(rates)]
    N[dependent] = _follow(parts.J, dependent, N)
    P[followers] = _follow(parts.rates, followers, P)
    S, Tz, Tx = np.zeros_like(N), np.zeros_like(P), np.zeros_like(N)
    inverse = np.linalg.pinv(parts.rates[:, followers], rcond=_RANK)
    by_q, by_v = second
    S[followers] = -inverse @ turned @ N
    Tz[followers], Tx[followers] = -inverse @ by_v @ P, -inverse @ (by_v @ S + by_q @ N)
    return Held(coordinates, rates, N, P, S, Tz, Tx)


def _follow(rows: Matrix, dependent: list[int], free: Matrix) -> Matrix:
    return np.asarray(-np.linalg.pinv(rows[:, dependent], rcond=_RANK) @ rows @ free)


def accelerations(M: Matrix, rows: Matrix, force: Matrix, bias: Matrix, reach: Matrix) -> tuple[Matrix, Matrix]:
    """a (n,) and multipliers (m,): M a + force + A^T lambda = 0, A a + bias = 0; the least ones where rows repeat each other.
    `reach` (n,): natural sizes, in which what moves no mass counts as the heaviest, and rows of rounding hold nothing."""
    masses, n = np.abs(np.diag(M)) * reach**2, M.shape[0]
    heaviest = float(masses.max(initial=0.0)) or 1.0
    weigh = reach / np.sqrt(np.where(masses > _NO_MASS * heaviest, masses, heaviest))
    there = lengths_of_rows(rows * reach) > 0
    A = np.where(there[:, None], rows * weigh, 0.0)
    sizes = np.where(there, np.linalg.norm(A, axis=1), 1.0)
    A = A / sizes[:, None]
    table = np.block([[M * np.outer(weigh, weigh), A.T], [A, np.zeros((A.shape[0],) * 2)]])
    found = np.linalg.lstsq(table, -np.concatenate([force * weigh, np.where(there, bias, 0.0) / sizes]), rcond=1e-12)[0]
    return found[:n] * weigh, found[n:] / sizes


def moving_linearization(parts: TangentParts, held: Held, given: Given, a: Matrix, of_rates: tuple[str, ...], dragging: Matrix
                         ) -> Linearization:
    """`a` (n,): the accelerations at the point; `of_rates`: names; `dragging` (n, n): what dx/dt has of x beside dv, as small
    turns have that are told in turning axes. Raises RunError where M is singular."""
    M, C, K, E = parts.M, parts.C, parts.K, parts.E
    N, P, S, Tz, Tx = held.N, held.P, held.S, held.Tz, held.Tx
    f, w = N.shape[1], P.shape[1]
    small = tuple(P.T @ x for x in E)
    mass, damping, stiffness = P.T @ M @ P, P.T @ (C @ P + M @ Tz), P.T @ (C @ S + K @ N + M @ Tx)
    same = [held.coordinates.index(k) if k in held.coordinates else -1 for k in held.rates]
    own = np.array([stiffness[:, k] if k >= 0 else np.zeros(w) for k in same]).T.reshape(w, w)
    reduced = Tangent(held.rates, P, np.zeros((M.shape[0], E[0].shape[1])), np.eye(w), mass, damping, own,
                      (small[0], small[1], small[2]), (M, C, K, parts.rates, *E))
    inverse = inverse_mass(reduced)
    places = list(held.coordinates)
    A = np.block([[(S + dragging @ N)[places], P[places]], [-inverse @ stiffness, -inverse @ damping]])
    inputs = inputs_of(reduced, given)
    columns = [-inverse @ small[order][:, [k]] for _, order, k in inputs]
    jolt = np.hstack(columns) if columns else np.zeros((w, 0))
    states, pushed = np.eye(f + w), np.zeros((M.shape[0], len(inputs)))
    x, z = states[:f], states[f:]
    output, D = observation(reduced.full, given, inputs, (N @ x, pushed), (S @ x + P @ z, pushed),
                            (P @ A[f:] + Tx @ x + Tz @ z, P @ jolt))
    names = tuple(given.coordinates[k] for k in held.coordinates)
    rates = tuple(of_rates[k] for k in held.rates)
    pace = a[list(held.rates)]
    return Linearization(
        given.name, names, (*names, *rates), tuple(name for name, _, _ in inputs),
        tuple((order, k) for _, order, k in inputs), given.outputs, given.excitations, given.point,
        tuple(map(float, given.observed[0].ravel())), False, mass, damping, stiffness, (-small[0], -small[1], -small[2]),
        mass @ pace, A, np.vstack([np.zeros((f, len(inputs))), jolt]), output, D, np.concatenate([np.zeros(f), pace]), reduced,
        free_rates=rates,
    )


def about_motion(study: Study, e: SmallMotion, state: State, pace: float) -> Linearization:
    """About q, v and, behind the multipliers, forces of contacts and shares of friction. Time goes on: supports that move have
    their rates and accelerations; where it matters, `pace` is 0 and the motion not steady. Raises LagError L0916 where a support
    is what excites, RunError."""
    centred, place, choice = _centred(study, e, state, pace)
    here = _at(centred, e, place, choice).linear
    size = _STEADY * float(np.abs(here.A).max(initial=1e-300))
    later = (_later(study, e, state, choice, moment) for moment in _LATER)
    alike = (other is not None and np.abs(other.A - here.A).max(initial=0.0) <= size for other in later)
    stays = pace != 0.0 and not e.is_timed and all(alike)
    is_steady = stays and float(np.abs(here.drift).max(initial=0.0)) <= size
    if not is_steady and (turned := in_turning_axes(study, e, state, pace)) is not None:
        return turned
    word = ("the motion there is steady: free rates stay as they are" if is_steady else "the motion there is not steady: the "
            "matrices are of that moment, and eigenvalues do not tell whether it is stable")
    seen = (_SEEN,) if study.turned.names else ()
    return _told(study, here, word, *seen)


def in_turning_axes(study: Study, e: SmallMotion, state: State, pace: float) -> Linearization | None:
    """About q, v and the rest, as `about_motion`, where the motion is steady in axes that turn with it; else None."""
    if pace == 0.0 or e.is_timed or not state[1].any():
        return None
    centred, place, choice = _centred(study, e, state, pace)
    found = TurningAxes(centred, e, place, lambda other, there: _at(other, e, there, choice)).found()
    return None if found is None else _told(study, found, _TURNS)


def _told(study: Study, linear: Linearization, *notes: str) -> Linearization:
    """With these notes, and first-order states by their names."""
    return with_signals(replace(linear, notes=(*linear.notes, *notes)), study.scene.signals)


def _centred(study: Study, e: SmallMotion, state: State, pace: float) -> tuple[Study, State, Choice]:
    """With attitudes told against those of the state, and what follows there."""
    q, v, free = state
    choice = choose(study.tangent(e, q, free, pace, v)[0], _weights(study), study.signals.kept_places)
    centred, position = study.advanced(q, v, 0.0)
    return centred, (position, v, free), choice


def _weights(study: Study) -> tuple[Matrix, Matrix]:
    """Of coordinates and of rates, (n,) each, in the choice of those that follow others: what the model starts is light."""
    initial, n = study.c.initial, study.scene.n
    is_given = [kind in (GUESS, FIXED) for kind in initial.fixed[n + len(initial.lost) :][:n]]
    places, rates = (study.reach * np.where(light, PREFERRED, 1.0) for light in (study.is_preferred, is_given))
    return places, rates


def _later(study: Study, e: SmallMotion, state: State, choice: Choice, moment: float
           ) -> Linearization | None:
    """After so many seconds at these free rates, the others following; None where the scene does not come there."""
    q, v, free = state
    there, position = study.advanced(q, v, moment)
    if choice.dependent:
        follows = np.isin(np.arange(e.n), choice.dependent)
        closed = onto_constraints(there.resting(e, 1.0).statics(), position, follows)
        if closed is None:
            return None
        there, position = there.centred(closed)
    rates, held = there.call(e.static, position, free, 1.0, v)[2].ravel(), choice.followers
    v = v.copy()
    v[held] -= np.linalg.pinv(there.tangent(e, position, free, 1.0, v)[0].rates[:, held], rcond=_RANK) @ rates
    try:
        return _at(there, e, (position, v, free), choice).linear
    except RunError:  # some motion moves no mass there
        return None


def _at(study: Study, e: SmallMotion, state: State, choice: Choice) -> Moment:
    q, v, free = state
    R, bias = (study.call(function, q, free, 1.0, v)[0].ravel() for function in (e.static, e.second))
    first, _ = study.tangent(e, q, free, 1.0, v)
    a, lam = accelerations(first.M, first.rates, R, bias, study.reach)
    lam = np.concatenate([lam, free[e.m:]])
    parts, places = study.tangent(e, q, lam, 1.0, v, a)
    if parts.pushed.any():
        fail("L0916", "not supported yet: supports that are moved in small motion about a point that is no equilibrium",
             study.c.flat.span, "name what else excites with --from")
    turned = study.slopes(e, e.slopes, ("q",), q, lam, 1.0, v, a)["q"][2]
    second = study.slopes(e, e.second_slopes, ("q", "v"), q, lam, 1.0, v, a)
    held = held_changes(parts, turned, (second["q"][0], second["v"][0]), choice)
    y, yq, yv, ya, yl, *ys = study.observed(e, q, lam, 1.0, v, a)
    given = Given(study.scene.name, study.names, tuple(p.name for p in e.probes), e.outputs,
                  study.point(q, v), R, False, (y, yq, yv, ya, yl[:, places], *ys))
    names = tuple(rate.name for rate in study.scene.rates)
    return Moment(moving_linearization(parts, held, given, a, names, study.turned.dragging(v)), held, a)
