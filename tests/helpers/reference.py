"""Independent solutions of equations of motion that somebody wrote by hand: nothing here knows of Lagrangia."""

from collections.abc import Callable, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.integrate import solve_ivp
from scipy.linalg import expm
from scipy.special import ellipj, ellipk

Array = NDArray[np.float64]
Acceleration = Callable[[float, Array, Array], ArrayLike]


def integrate(
    acceleration: Acceleration, q0: Sequence[float], v0: Sequence[float], times: Array, breaks: Sequence[float] = ()
) -> tuple[Array, Array]:
    """q and v of q'' = acceleration(t, q, v), each of shape (n, len(times)), for ascending times from the start on.

    SciPy's DOP853 at its finest, begun afresh at each of `breaks`, where the acceleration jumps or bends.
    """
    n = len(q0)

    def derivative(t: float, y: Array) -> Array:
        return np.concatenate([y[n:], np.asarray(acceleration(t, y[:n], y[n:]), dtype=float)])

    y = np.array([*q0, *v0], dtype=float)
    pieces = [y[:, None]]
    for begin, end in pairwise([times[0], *breaks, times[-1]]):
        inside = times[(begin < times) & (times <= end)]
        piece = solve_ivp(derivative, (begin, end), y, method="DOP853", t_eval=np.union1d(inside, end), rtol=3e-14, atol=1e-14)
        pieces.append(piece.y[:, : len(inside)])
        y = piece.y[:, -1]
    q, v = np.split(np.hstack(pieces), 2)
    return q, v


def linear_response(
    M: ArrayLike, C: ArrayLike, K: ArrayLike, times: Array, *, load: Sequence[float], Omega: float, q0: Sequence[float]
) -> Array:
    """q, of shape (n, len(times)), of M q'' + C q' + K q = load sin(Omega t) from rest at q0.

    The state (q, q', sin Omega t, cos Omega t) obeys z' = A z with constant A, so z(t) = exp(A t) z(0).
    """
    n = len(q0)
    inverse = np.linalg.inv(M)
    A = np.zeros((2 * n + 2, 2 * n + 2))
    A[:n, n : 2 * n] = np.eye(n)
    A[n : 2 * n, :n] = -inverse @ np.asarray(K)
    A[n : 2 * n, n : 2 * n] = -inverse @ np.asarray(C)
    A[n : 2 * n, 2 * n] = inverse @ np.asarray(load)
    A[2 * n, 2 * n + 1], A[2 * n + 1, 2 * n] = Omega, -Omega
    start = np.concatenate([q0, np.zeros(n), [0, 1]])
    return (expm(np.multiply.outer(times, A)) @ start)[:, :n].T


def pendulum_angle(times: Array, *, L: float, phi0: float, g: float = 9.81) -> Array:
    """phi of L phi'' = -g sin phi from rest at phi0: sin(phi/2) = k sn(K(k) - sqrt(g/L) t, k) with k = sin(phi0/2)."""
    k = np.sin(phi0 / 2)
    sn = ellipj(ellipk(k**2) - np.sqrt(g / L) * times, k**2)[0]
    return 2 * np.arcsin(k * sn)
