"""Equations of the spatial examples, by hand: test_examples.py compares."""

from collections.abc import Callable

import numpy as np
from numpy import cos, sin

from helpers.reference import Array, integrate

g = 9.81
Columns = dict[str, Array]


def top(t: Array) -> Columns:
    """Euler's angles zxz with the constants w3 and p_phi = A phi' sin^2 theta + C w3 cos theta; A = I1 + m l^2, C = I3:

    A theta'' = A phi'^2 sin theta cos theta - C w3 phi' sin theta + m g l sin theta
    A phi'' sin theta = C w3 theta' - 2 A theta' phi' cos theta
    """
    m, l, w3, A, C = 0.5, 0.1, 200, 0.0058, 0.001

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (_, theta), (dphi, dtheta) = q, v
        s, c = sin(theta), cos(theta)
        turning = (C * w3 * dtheta / A - 2 * dtheta * dphi * c) / s
        return np.array([turning, dphi**2 * s * c + (m * g * l - C * w3 * dphi) * s / A])

    (phi, theta), _ = integrate(acceleration, [0, np.radians(30)], [0, 0], t)
    place = {"x": sin(theta) * sin(phi), "y": -sin(theta) * cos(phi), "z": cos(theta)}
    return {f"top.center.{name}": l * x for name, x in place.items()} | {"tip.w[3]": np.full(len(t), float(w3))}


def satellite(t: Array) -> Columns:
    """A gyrostat. The inertia J is about the common centre of mass, the wheel as if it did not turn; C is the wheel.s own:

    H = J w + C phi' e_z,   H' + w x H = 0,   C (phi'' + w_z') = drive;   Q' = Q (0, w)/2
    """
    m, mw, C, d = 20, 2, 2 * 0.1**2 / 2, np.array([0, 0.2, 0])
    across = 2 * (3 * 0.1**2 + 0.03**2) / 12
    J = np.diag([1.3 + across, 2.1 + across, 3 + C]) + m * mw / (m + mw) * (d @ d * np.eye(3) - np.outer(d, d))

    def times(a: Array, b: Array) -> Array:
        return np.array([a[0] * b[0] - a[1:] @ b[1:], *(a[0] * b[1:] + b[0] * a[1:] + np.cross(a[1:], b[1:]))])

    def rates(q: Array, v: Array) -> Array:
        return 2 * times(q[:4] * [1, -1, -1, -1], v[:4])[1:]

    def acceleration(t: float, q: Array, v: Array) -> Array:
        w, drive = rates(q, v), 0.02 * (t < 20)
        H = J @ w + [0, 0, C * v[4]]
        turned = np.linalg.solve(J - np.diag([0, 0, C]), -np.cross(w, H) - [0, 0, drive])
        Q = (times(v[:4], np.array([0, *w])) + times(q[:4], np.array([0, *turned]))) / 2
        return np.array([*Q, drive / C - turned[2]])

    def half(axis: int, angle: float) -> Array:
        return np.array([cos(angle / 2), *(sin(angle / 2) * np.eye(3)[axis])])

    Q, w = times(half(2, np.radians(20)), half(1, np.radians(10))), np.array([0.02, 0.01, 0])
    q, v = integrate(acceleration, [*Q, 0], [*times(Q, np.array([0, *w])) / 2, 0], t, breaks=[20])

    def turned(Q: Array, x: Array) -> Array:
        return times(times(Q, np.array([0, *x])), Q * [1, -1, -1, -1])[1:]

    share = mw / (m + mw)
    centre = share * turned(Q, d) + np.multiply.outer(t, share * turned(Q, np.cross(w, d)))
    place = centre - share * np.array([turned(q[:4, k], d) for k in range(len(t))])
    omega = np.array([rates(q[:, k], v[:, k]) for k in range(len(t))])
    found = {"axle.phi": q[4], "axle.w": v[4]} | {f"hull.center.Q[{k + 1}]": q[k] for k in range(4)}
    found |= {f"hull.center.{name}": place[:, k] for k, name in enumerate("xyz")}
    return found | {f"hull.center.omega[{k + 1}]": omega[:, k] for k in range(3)}


REFERENCES: dict[str, Callable[[Array], Columns]] = {"top": top, "satellite": satellite}
