"""Small motion about a motion that turns, in axes that turn along: a wheel that rolls round a circle, a top that precesses.

Of such a relative equilibrium (E.J. Routh, 1877) the matrix A(t) of deviations changes, as the motion's heading does. A linear
map moves its deviations along: u = (dq, dv) -> exp(Gt) u, where G turns lengths among each other (a turn of the plane takes x to
y), and small turns and rates of an attitude about an axis e of its body (which spins about its own axis), both skew. With what is
free, x and z, as u = E(t) (x, z) and (x, z) = c u, deviations told in turned axes, (x, z) = T y with T = c exp(Gt) E(0), have

    y' = T^-1 (A T - T') y,   at first A - c G E,

whose matrix must be the same at all times: then its eigenvalues tell what the motion does. G is what fits the first changes of
A, E and the rates; it is tried by the states themselves at later times.
"""

from collections.abc import Callable, Iterator
from dataclasses import replace
from itertools import combinations

import numpy as np
from numpy.typing import NDArray

from lagrangia.base.diagnostics import RunError
from lagrangia.dynamics.turned_positions import crossing
from lagrangia.study.linearization import Linearization
from lagrangia.study.moved import Moment, State, Study
from lagrangia.study.small_motion import SmallMotion

Matrix = NDArray[np.float64]
_MOST, _RANK, _FITS, _STAYS = 24, 1e-8, 1e-8, 1e-8
_STEP = 0.01  # rad, of the differences by which first changes are told
_EIGHTH = (4 / 5, -1 / 5, 4 / 105, -1 / 280)  # central differences of order 8
_LOOKS = (0.7, 2.3)  # rad: how far on it is to be the same


class TurningAxes:
    """`at`: of a study and a state (q, v, multipliers) in its attitudes, their Moment."""

    def __init__(self, study: Study, e: SmallMotion, state: State, at: Callable[[Study, State], Moment]) -> None:
        self.study, self.e, self.at = study, e, at
        self.q, self.v, self.free = state
        self.n = self.v.size
        self.sizes = np.concatenate([study.reach, study.reach])
        self.pace = float(np.abs(self.v / study.reach).max())
        self.here = at(study, state)

    @property
    def _skew(self) -> Iterator[Matrix]:
        """All of which B, in G = (B, B), is made, (n, n) each."""
        lengths = [k for k in range(self.n) if not self.study.is_angle[k]]
        pairs = [*combinations(lengths, 2)] if len(lengths) <= _MOST else []
        for i, k in pairs:
            B = np.zeros((self.n, self.n))
            B[i, k], B[k, i] = -1.0, 1.0
            yield B
        for places in self.study.turned.places:
            for axis in np.eye(3):
                B = np.zeros((self.n, self.n))
                B[np.ix_(places, places)] = -crossing(axis)
                yield B

    def _first_changes(self) -> tuple[Matrix, Matrix]:
        """dA/dt and dE/dt along the motion."""
        step = _STEP / self.pace
        A, E = np.zeros_like(self.here.linear.A), np.zeros_like(self.here.E)
        for k, weight in enumerate(_EIGHTH, 1):
            for side in (1, -1):
                moment = side * k * step
                study, q = self.study.advanced(self.q, self.v, moment)
                there = self.at(study, (q, self.v + moment * self.here.a, self.free))
                A += side * weight / step * there.linear.A
                E += side * weight / step * there.E
        return A, E

    def found(self) -> Linearization | None:
        """In turned axes; None where none make it steady."""
        skew = [*self._skew]
        if not skew:
            return None
        try:
            B = self._fitting(skew)
            return None if B is None else self._steady(B)
        except (RunError, np.linalg.LinAlgError):  # some motion moves no mass nearby, or other rates follow there
            return None

    def _fitting(self, skew: list[Matrix]) -> Matrix | None:
        """The least B by which rates, A and E change as they do at first."""
        A, E, c = self.here.linear.A, self.here.E, self.here.places
        full = self.sizes * np.repeat([1.0, self.pace], self.n)

        def told(dA: Matrix, dE: Matrix) -> Matrix:
            parts = (dA * full[c] / full[c][:, None] / self.pace, dE * full[c] / full[:, None])
            return np.concatenate([x.ravel() for x in parts]) / self.pace

        dA, dE = self._first_changes()
        columns = []
        for B in skew:
            GE, turned = _both(B, E), _both(B, dE)[c]
            columns.append(told(GE[c] @ A - A @ GE[c] + turned, GE - E @ GE[c]))
        table, wanted = np.array(columns).T, told(dA, dE)
        largest = float(np.abs(wanted).max())
        if not largest > _FITS * float(np.abs(told(A, E)).max()):  # nothing turns
            return None
        weights = np.linalg.lstsq(table, wanted, rcond=_RANK)[0]
        missed = float(np.abs(table @ weights - wanted).max())
        return np.tensordot(weights, skew, 1) if missed <= _FITS * largest else None

    def _steady(self, B: Matrix) -> Linearization | None:
        """In axes that turn so, if the motion is the same in them later on."""
        here, E, c = self.here, self.here.E, self.here.places
        A = here.linear.A - _both(B, E)[c]
        size = float(np.abs(A).max(initial=1e-300))
        for look in _LOOKS:
            moment = look / self.pace
            study, q, v = self._after(B, moment)
            there, turn = self.at(study, (q, v, self.free)), turned_by(B, moment)
            moved = _both(turn, E)
            T, rate = moved[c], _both(B, moved)[c]
            A_there = np.linalg.solve(T, there.linear.A @ T - rate)
            gaps = (np.abs(A_there - A).max() / size, np.abs((there.a - B @ v) / self.study.reach).max() / self.pace**2,
                    *(np.abs(x).max(initial=0.0) for x in self._gaps(study, q, v)))
            if not max(gaps) <= _STAYS:
                return None
        return self._told(B, A)

    def _after(self, B: Matrix, moment: float) -> tuple[Study, Matrix, Matrix]:
        """The state so many seconds later, of rates that are turned along."""
        turned, spin, mean = self.study.turned, np.zeros(self.n), turned_by(B, moment, is_mean=True) @ self.v
        for places in turned.places:
            block = -B[np.ix_(places, places)]
            spin[places] = block[2, 1], block[0, 2], block[1, 0]
        mean[turned.all] = (self.v - spin)[turned.all]
        study, q = self.study.advanced(self.q, mean, moment)
        return *study.advanced(q, spin, moment), turned_by(B, moment) @ self.v

    def _gaps(self, study: Study, q: Matrix, v: Matrix) -> list[Matrix]:
        """By which rows are missed, of places and of rates, in natural sizes."""
        phi, rate = (x.ravel() for x in study.call(self.e.static, q, self.free, 1.0, v)[1:3])
        size = float(study.reach.max())
        return [phi / size, rate / size / self.pace]

    def _told(self, B: Matrix, A: Matrix) -> Linearization:
        """The matrices with rates of what is told in turned axes: M z' + C z + K x stays as it is with z' + (G (x, z))."""
        linear, f = self.here.linear, self.here.held.N.shape[1]
        G = (linear.A - A)[f:]
        return replace(linear, A=A, K=linear.K + linear.M @ G[:, :f], C=linear.C + linear.M @ G[:, f:],
                       load=np.zeros_like(linear.load), drift=np.zeros_like(linear.drift))


def _both(B: Matrix, u: Matrix) -> Matrix:
    """(B, B) u, (2 n, .)."""
    n = B.shape[0]
    return np.vstack([B @ u[:n], B @ u[n:]])


def turned_by(B: Matrix, time: float, is_mean: bool = False) -> Matrix:
    """exp(B t) of a skew B, (n, n), or its mean from 0 to t."""
    angles, axes = np.linalg.eigh(1j * B)
    phases = -1j * angles * time
    small = np.abs(phases) < 1e-8
    growth = np.where(small, 1.0, np.expm1(phases) / np.where(small, 1.0, phases)) if is_mean else np.exp(phases)
    return np.asarray((axes * growth @ axes.conj().T).real)
