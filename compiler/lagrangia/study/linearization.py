"""Small motion about a point: the matrices in the coordinates that are left free, and the state-space form.

With dq = N x + P s on the tangent of the constraints (J N = 0, J P = -dPhi/ds), s the excitations,

    M x'' + C x' + K x = -(E0 s + E1 s' + E2 s''),   M = N^T (dR/da) N, C = N^T (dR/dv) N, K = N^T (dR/dq) N,

where dR/dq holds the stiffness that multipliers give to curved constraints. x are coordinates of the scene, so that they have
names: those whose columns of J are not needed to solve for the others. Works with loops, redundant rows and rigid-body motions.
"""

import json
from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace
from functools import cached_property
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.orthogonal import independent_columns
from lagrangia.base.diagnostics import RunError, fail
from lagrangia.base.records import dataclass
from lagrangia.base.result_files import Target, write_text

Matrix = NDArray[np.float64]
_RANK = 1e-9
_NO_ROW = 1e-11  # of the longest constraint
_ROUNDING = 1e-14  # of the terms that cancel in an output
PREFERRED = 0.1  # weight in the choice of dependent coordinates of those that the model starts itself
_NO_MASS = 1e-14  # of the mass matrix, scaled to a diagonal of 1: eigenvalues


@dataclass(frozen=True)
class Tangent:
    """All at one point. N (n, f), P (n, k): dq = N x + P s. M, C, K, E0, E1, E2 in x; `full` in all coordinates.

    `rolling`: constraints on velocities let x' only be W z, W (f, w); the identity without them.
    """

    independent: tuple[int, ...]
    N: Matrix
    P: Matrix
    W: Matrix
    M: Matrix
    C: Matrix
    K: Matrix
    E: tuple[Matrix, Matrix, Matrix]
    full: tuple[Matrix, ...]  # M, C, K (n, n), what multipliers do (m, n), and dR/ds, ds', ds'' at fixed coordinates (n, k)


@dataclass(frozen=True)
class TangentParts:
    """dR/da, dR/dv, dR/dq (n, n), dPhi/dq (m_h, n), d rate/dv (m, n), dR/ds, ds', ds'' (n, k), dPhi/ds (m_h, k).

    `pulls`: what multipliers do, (m, n), where that is not what the rates say, as where friction has its limit from a contact.
    `grazed`: (g, n), of gaps that are closed without force.
    """

    M: Matrix
    C: Matrix
    K: Matrix
    J: Matrix
    rates: Matrix
    E: tuple[Matrix, Matrix, Matrix]
    pushed: Matrix
    pulls: Matrix | None = None
    grazed: Matrix | None = None


def tangent_of(x: TangentParts, is_preferred: Sequence[bool], reach: Matrix, plane: Matrix | None = None,
               kept: Collection[int] = ()) -> Tangent:
    """Coordinates that are preferred stay free where the choice is open. `plane` (n, f): of one way of moving of several; `kept`:
    coordinates of discrete variables, which do not change in small motion."""
    M, C, K, J, rates, (E0, E1, E2), pushed = x.M, x.C, x.K, x.J, x.rates, x.E, x.pushed
    n = M.shape[0]
    weight = reach * np.where(is_preferred, PREFERRED, 1.0)
    if plane is not None:  # what is normal to it takes the place of the constraints
        J, pushed = _null_space(plane.T).T, np.zeros((n - plane.shape[1], E0.shape[1]))
        rates = np.vstack([J, rates[x.J.shape[0]:]])
    dependent = pivots(J, weight)
    independent = tuple(k for k in range(n) if k not in {*dependent, *kept})
    N, P = np.zeros((n, len(independent))), np.zeros((n, E0.shape[1]))
    N[list(independent), range(len(independent))] = 1.0
    if dependent:
        inverse = np.linalg.pinv(J[:, dependent], rcond=_RANK)
        N[dependent] = -inverse @ J[:, list(independent)]
        P[dependent] = -inverse @ pushed
    W = _null_space(rates @ N) if rates.shape[0] > J.shape[0] else np.eye(len(independent))
    E = (E0 + K @ P, E1 + C @ P, E2 + M @ P)
    L = N if x.pulls is None or plane is not None else _untouched(N, M, x.pulls[:J.shape[0]], kept)
    return Tangent(independent, N, P, W, L.T @ M @ N, L.T @ C @ N, L.T @ K @ N, (L.T @ E[0], L.T @ E[1], L.T @ E[2]),
                   (M, C, K, x.rates if x.pulls is None else x.pulls, E0, E1, E2))


def _untouched(N: Matrix, M: Matrix, pulls: Matrix, kept: Collection[int]) -> Matrix:
    """L, (n, f): sums of equations without multipliers, L^T pulls^T = 0. N itself where these pull along what they hold; else, as
    where a force acts on what lies on a wall and not on the wall, those with the same mass: L^T M N = N^T M N."""
    if np.abs(pulls @ N).max(initial=0.0) <= _RANK * np.abs(pulls).max(initial=0.0):
        return N
    free = [k for k in range(len(N)) if k not in kept]
    L = np.zeros((len(N), len(free) - pulls.shape[0]))
    L[free] = _null_space(pulls[:, free])
    return np.asarray(L @ np.linalg.pinv(N.T @ M.T @ L, rcond=_RANK) @ (N.T @ M.T @ N))


def pivots(J: Matrix, weight: Matrix) -> list[int]:
    """Columns that span all others: Gram and Schmidt, the longest remainder first."""
    lengths = lengths_of_rows(J * weight)
    rows = J * weight * np.divide(1.0, lengths, out=np.zeros_like(lengths), where=lengths > 0)[:, None]
    return sorted(independent_columns(rows, _RANK, is_last=True).tolist())


def lengths_of_rows(rows: Matrix) -> Matrix:
    """In natural sizes, (m,); 0 of what is rounding beside the longest, which holds nothing."""
    lengths = np.linalg.norm(rows, axis=1)
    return np.where(lengths > _NO_ROW * lengths.max(initial=0.0), lengths, 0.0)


def barred_by(grazed: Matrix, t: Tangent) -> Matrix | None:
    """Of the free rates, (g, w): the rows of the gaps that they would pass; None where they pass none."""
    free = t.N @ t.W
    rows = grazed @ free
    passed = np.abs(rows) > _RANK * (np.abs(grazed) @ np.abs(free))
    return rows * passed if passed.any() else None


def _null_space(A: Matrix) -> Matrix:
    _, sizes, rows = np.linalg.svd(A)
    rank = int((sizes > _RANK * sizes.max(initial=0.0)).sum())
    return np.asarray(rows[rank:].T)


# -------------------------------------------------------------------- state space


@dataclass(frozen=True)
class Sampled:
    """From instant to instant of a sampled controller: z_{k+1} = A z_k + B w_k, with z just before an instant, w held."""

    interval: float  # s
    states: tuple[str, ...]  # of the mechanism, then what is held
    inputs: tuple[str, ...]
    A: Matrix
    B: Matrix

    @property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Of A: within the unit circle where motion dies out."""
        found = np.linalg.eigvals(self.A).astype(complex)
        return np.asarray(found[np.lexsort((found.imag, -np.round(np.abs(found), 12)))])


@dataclass(frozen=True)
class Linearization:
    """M x'' + C x' + K x = F0 u + F1 u' + F2 u'' + load, and z' = A z + B w + drift, y = D w + G z + y0 about the point.

    `coordinates` name x, `states` z = (x, x'), `inputs` w: the excitations u, and where they matter their derivatives.
    Matrices are NumPy arrays in SI units; `output` is the C of the state-space form, which is not the damping matrix C.
    """

    name: str
    coordinates: tuple[str, ...]
    states: tuple[str, ...]
    inputs: tuple[str, ...]
    input_orders: tuple[tuple[int, int], ...]  # of each input: which derivative, of which excitation
    outputs: tuple[str, ...]
    excitations: tuple[str, ...]
    point: Mapping[str, float]
    outputs_at_point: tuple[float, ...]
    is_equilibrium: bool
    M: Matrix
    C: Matrix
    K: Matrix
    F: tuple[Matrix, Matrix, Matrix]  # of u, u', u''
    load: Matrix  # what is left of the forces at the point: zero at an equilibrium
    A: Matrix
    B: Matrix
    output: Matrix
    D: Matrix
    drift: Matrix
    tangent: Tangent
    notes: tuple[str, ...] = ()  # what holds at the point beside constraints, and what it is only for
    sampled: Sampled | None = None  # where values are held between instants
    barred: Matrix | None = None  # (g, w): rates at which gaps that are just closed would be passed, by those that are free
    free_rates: tuple[str, ...] = ()  # z of M z' + C z + K x = F u, which holds about a state that moves and is held (moving.py)

    @property
    def has_signals(self) -> bool:
        """Whether first-order states are among the states."""
        return len(self.states) < len(self.coordinates) + int(self.tangent.W.shape[1])

    @cached_property
    def eigenvalues(self) -> NDArray[np.complex128]:
        """Of A, by size."""
        found = np.linalg.eigvals(self.A).astype(complex)
        return np.asarray(found[np.lexsort((found.imag, np.round(np.abs(found), 12)))])

    def tables(self) -> dict[str, Matrix]:
        """All matrices by the names that files give them."""
        found = {"M": self.M, "C": self.C, "K": self.K, "F": self.F[0], "load": self.load,
                 "A": self.A, "B": self.B, "C_output": self.output, "D": self.D, "drift": self.drift}
        found |= {f"F_{k}": x for k, x in enumerate(self.F) if k and x.any()}
        return found | ({"A_sampled": self.sampled.A, "B_sampled": self.sampled.B} if self.sampled is not None else {})

    def to_dict(self) -> dict[str, Any]:
        """Plain lists and names, as the JSON file has them."""
        names = {"name": self.name, "is_equilibrium": self.is_equilibrium, "point": dict(self.point),
                 "coordinates": self.coordinates, "states": self.states, "excitations": self.excitations, "inputs": self.inputs,
                 "outputs": self.outputs, "outputs_at_point": self.outputs_at_point, "notes": self.notes}
        if self.sampled is not None:
            s = self.sampled
            names |= {"interval": s.interval, "states_sampled": s.states, "inputs_sampled": s.inputs}
        return names | {name: table.tolist() for name, table in self.tables().items()}

    def save(self, path: "str | Path") -> Path:
        """.json, .npz or .mat (for which SciPy is needed). Raises LagError L0004 for another ending, L0901 without SciPy."""
        path = Path(path)
        names = {key: list(getattr(self, key)) for key in ("coordinates", "states", "excitations", "inputs", "outputs")}
        if path.suffix == ".json":
            write_text(path, json.dumps(self.to_dict(), indent=1) + "\n")
        elif path.suffix == ".npz":
            with Target(path, binary=True) as target:
                np.savez(target.stream, **self.tables(), **{key: np.array(x, dtype=str) for key, x in names.items()})  # type: ignore[arg-type]
        elif path.suffix == ".mat":
            savemat = _scipy_io().savemat
            with Target(path, binary=True) as target:
                savemat(target.stream, self.tables() | {key: np.array(x, dtype=object) for key, x in names.items()})
        else:
            fail("L0004", f"'{path}' is no file for matrices", None, "its name should end in .json, .mat or .npz")
        return path

    def to_control(self) -> Any:
        """A control.StateSpace with named states, inputs and outputs, `_` for the dots that python-control does not allow.

        Raises LagError L0901 without python-control.
        """
        try:
            import control
        except ImportError:
            fail("L0901", "python-control is not installed", None, "pip install control")

        def plain(names: Sequence[str]) -> list[str]:
            return [name.replace(".", "_") for name in names]

        return control.ss(self.A, self.B, self.output, self.D, states=plain(self.states), inputs=plain(self.inputs),
                          outputs=plain(self.outputs), name=self.name)


def _scipy_io() -> Any:
    try:
        import scipy.io
    except ImportError:
        fail("L0901", "SciPy, which writes .mat files, is not installed", None, "pip install scipy, or write .json or .npz")
    return scipy.io


@dataclass(frozen=True)
class Given:
    """What a linearisation is told of its point: names, the residual there, and the outputs with their derivatives."""

    name: str
    coordinates: tuple[str, ...]
    excitations: tuple[str, ...]
    outputs: tuple[str, ...]
    point: Mapping[str, float]
    residual: Matrix  # R at zero accelerations of the free coordinates, (n,)
    is_equilibrium: bool
    observed: Sequence[Matrix]  # y, dy/dq, dv, da, dlambda, ds, ds', ds''


def linearization(tangent: Tangent, given: Given) -> Linearization:
    """Raises RunError where M is singular."""
    t, f = tangent, tangent.M.shape[0]
    inverse = inverse_mass(t)
    names = [given.coordinates[k] for k in t.independent]
    rates = [f"der({name})" for name in names]
    w = t.W.shape[1]
    if w < f:  # a rolling wheel cannot move aside: fewer rates than coordinates
        rates = [f"rate[{k + 1}]" for k in range(w)]
    load = -t.N.T @ given.residual
    A = np.block([[np.zeros((f, f)), t.W], [-inverse @ t.K, -inverse @ t.C @ t.W]])
    drift = np.concatenate([np.zeros(f), inverse @ load])
    inputs = inputs_of(t, given)
    columns = [np.concatenate([np.zeros(f), -inverse @ t.E[order][:, k]]) for _, order, k in inputs]
    B = np.array(columns).T if columns else np.zeros((f + w, 0))
    output, D = _observation(t, given, inverse, inputs)
    return Linearization(
        given.name, tuple(names), (*names, *rates), tuple(name for name, _, _ in inputs),
        tuple((order, k) for _, order, k in inputs), given.outputs, given.excitations, given.point,
        tuple(map(float, given.observed[0].ravel())), given.is_equilibrium, t.M, t.C, t.K, (-t.E[0], -t.E[1], -t.E[2]), load,
        A, B, output, D, drift, t,
    )


def with_signals(linear: Linearization, signals: Mapping[str, str]) -> Linearization:
    """Without the coordinates whose rates are first-order states, on which nothing depends; the states have their own names.
    M, C and K keep them: a state's row of C is its rate's."""
    kept = [k for k, name in enumerate(linear.states) if name not in signals]
    names = {f"der({name})": state for name, state in signals.items()}
    states = tuple(names.get(linear.states[k], linear.states[k]) for k in kept)
    point = {signals.get(name, name): value for name, value in linear.point.items()}
    return replace(linear, states=states, point=point, A=linear.A[np.ix_(kept, kept)], B=linear.B[kept],
                   output=linear.output[:, kept], drift=linear.drift[kept])


def no_mass(least: float = 0.0) -> RunError:
    """The error of a motion that moves no mass, or, where the least eigenvalue of M is negative, less than none."""
    if least < -_NO_MASS:
        return RunError("the mass matrix is not positive definite at this point: the kinetic energy of some motion is negative")
    return RunError("the mass matrix is singular at this point: a motion that the constraints allow moves no mass")


def inverse_mass(t: Tangent) -> Matrix:
    """(W^T M W)^-1 W^T: forces -> z'' of the rates that are free."""
    M = t.W.T @ t.M @ t.W
    scale = np.sqrt(np.abs(np.diag(M)))
    if M.size and (not np.isfinite(M).all() or not scale.all()):
        raise no_mass()
    if M.size and (least := float(np.linalg.eigvalsh(M / np.outer(scale, scale)).min())) < _NO_MASS:
        raise no_mass(least)
    inverse = np.asarray(np.linalg.solve(M, t.W.T)) if M.size else np.zeros((0, t.M.shape[0]))
    with np.errstate(all="ignore"):
        if not all(np.isfinite(inverse @ x).all() for x in (t.K, t.C, *t.E)):
            raise RunError("small motion is out of the range of numbers here: forces by masses are above 1.8e308; larger masses "
                           "or softer springs have numbers")
    return inverse


Column = tuple[str, int, int]  # name, order of the derivative, excitation
Pair = tuple[Matrix, Matrix]  # by z and by w


def inputs_of(t: Tangent, given: Given) -> list[Column]:
    """The excitations, and those derivatives of theirs that matter anywhere."""
    _, _, yv, ya, yl, *ys = given.observed
    found = []
    for order, wrap in enumerate(("{}", "der({})", "der(der({}))")):
        for k, excitation in enumerate(given.excitations):
            is_carried = t.P[:, k].any() and (ya.any() or yl.any() or (order < 2 and yv.any()))
            if order == 0 or is_carried or any(E[:, k].any() for higher in range(order, 3) for E in (t.E[higher], ys[higher])):
                found.append((wrap.format(excitation), order, k))
    return found


def _observation(t: Tangent, given: Given, inverse: Matrix, inputs: Sequence[Column]) -> Pair:
    """y = output z + D w: with accelerations and multipliers as they follow from z and w."""
    f = t.M.shape[0]
    moved, pushed = np.hstack([np.eye(f), np.zeros((f, t.W.shape[1]))]), np.zeros((f, len(inputs)))
    rate, eased = np.hstack([np.zeros((f, f)), t.W]), pushed
    fast = -t.W @ inverse @ (t.K @ moved + t.C @ rate)
    columns = [-t.W @ inverse @ t.E[order][:, [k]] for _, order, k in inputs]
    jolt = np.hstack(columns) if columns else pushed
    q, v, a = (t.N @ moved, t.N @ pushed), (t.N @ rate, t.N @ eased), (t.N @ fast, t.N @ jolt)
    q, v, a = ((x[0], x[1] + _follow(t.P, inputs, order)) for order, x in enumerate((q, v, a)))
    return observation(t.full, given, inputs, q, v, a)


def observation(full: tuple[Matrix, ...], given: Given, inputs: Sequence[Column], q: Pair, v: Pair, a: Pair) -> Pair:
    """C and D of y = C z + D w, where dq, dv and da are as said by z and by w."""
    _, yq, yv, ya, yl, *ys = given.observed
    M, C, K, J, *E = full
    direct = [np.hstack([e[order][:, [k]] if order == own else np.zeros((e[0].shape[0], 1)) for _, order, k in inputs])
              if inputs else np.zeros((e[0].shape[0], 0)) for e in (E, ys) for own in range(3)]
    held = np.linalg.pinv(J.T, rcond=_RANK) if J.size else np.zeros((J.shape[0], M.shape[0]))
    force = [M @ a[0] + C @ v[0] + K @ q[0], M @ a[1] + C @ v[1] + K @ q[1] + sum(direct[:3])]
    lam = [-held @ x for x in force]
    found = [yq @ q[k] + yv @ v[k] + ya @ a[k] + yl @ lam[k] for k in (0, 1)]
    sizes = [abs(yq) @ abs(q[k]) + abs(yv) @ abs(v[k]) + abs(ya) @ abs(a[k]) + abs(yl) @ abs(lam[k]) for k in (0, 1)]
    found[1] = found[1] + sum(direct[3:])
    output, D = (np.where(np.abs(x) > _ROUNDING * size, x, 0.0) for x, size in zip(found, sizes, strict=True))
    return np.asarray(output), np.asarray(D)


def _follow(P: Matrix, inputs: Sequence[Column], order: int) -> Matrix:
    """What the inputs move of the dependent coordinates, or of their rates or accelerations."""
    found = np.zeros((P.shape[0], len(inputs)))
    for column, (_, own, k) in enumerate(inputs):
        if own == order:
            found[:, column] = P[:, k]
    return found
