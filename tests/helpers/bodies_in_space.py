"""Mechanisms of rigid bodies in space by hand: velocities of bodies are written down, equations follow in numbers.

sum over bodies of Jv^T (m a - F) + Jw^T (I alpha + w x I w) = A^T lambda, A a + d(A)/dt v = 0, where velocities are linear in the
rates and what they change along the motion is a complex step, exact to rounding. Nothing here knows of Lagrangia.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

Array = np.ndarray
_STEP = 1e-40


def cross(a: Array, b: Array) -> Array:
    """NumPy's own takes several times as long."""
    return np.array([a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]])


@dataclass(frozen=True)
class Moving:
    """A place with its axes, and how it moves: all in the world's axes."""

    r: Array
    R: Array
    v: Array
    w: Array

    def shifted(self, ahead: Sequence[float]) -> "Moving":
        d = self.R @ np.asarray(ahead)
        return Moving(self.r + d, self.R, self.v + cross(self.w, d), self.w)

    def slid(self, along: Sequence[float], s: complex, rate: complex) -> "Moving":
        d = self.R @ np.asarray(along)
        there = Moving(self.r + s * d, self.R, self.v + cross(self.w, s * d), self.w)
        return Moving(there.r, there.R, there.v + rate * d, there.w)

    def turned(self, axis: Sequence[float], angle: complex, rate: complex = 0.0) -> "Moving":
        n = np.asarray(axis) / np.linalg.norm(axis)
        x, y, z = n
        across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
        turn = np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across
        return Moving(self.r, self.R @ turn, self.v, self.w + rate * (self.R @ n))


GROUND = Moving(np.zeros(3), np.eye(3), np.zeros(3), np.zeros(3))
Body = tuple[float, Array, Moving]  # mass, inertia about the centre of mass in own axes, centre of mass
Look = Callable[[Array, Array], tuple[list[Body], Array]]  # q, v -> bodies, and what constraints say of v


def accelerations(look: Look, q: Array, v: Array, gravity: Array, pushed: Array | float = 0.0) -> Array:
    """(n,); `pushed`: generalised forces beside those of gravity."""
    n = len(q)
    ways = [look(q, e) for e in np.eye(n)]
    moved = look(q + 1j * _STEP * v, v.astype(complex))
    M, h = np.zeros((n, n)), np.zeros(n)
    for k, (m, inertia, there) in enumerate(moved[0]):
        R, w = there.R.real, there.w.real
        Jv, Jw = (np.array([getattr(bodies[k][2], name) for bodies, _ in ways]).T for name in "vw")
        a, alpha = (x.imag / _STEP for x in (there.v, there.w))
        I = R @ inertia @ R.T
        M += m * Jv.T @ Jv + Jw.T @ I @ Jw
        h += Jv.T @ (m * (a - gravity)) + Jw.T @ (I @ alpha + cross(w, I @ w))
    A = np.array([rates for _, rates in ways]).T.reshape(-1, n)
    table = np.block([[M, A.T], [A, np.zeros((len(A),) * 2)]])
    return np.linalg.solve(table, -np.concatenate([h - pushed, moved[1].imag / _STEP]))[:n]


def slip_of_disc(center: Moving, axis: Sequence[float], r: float) -> Array:
    """The velocity of the lowest point of a disc, in the plane and out of it: all vanish where it rolls."""
    n = center.R @ np.asarray(axis)
    up = np.array([0, 0, 1]) - n[2] * n
    return center.v + cross(center.w, -r * up / np.sqrt(up @ up))
