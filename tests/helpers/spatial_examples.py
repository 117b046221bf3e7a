"""The examples in space, on paper."""

from collections.abc import Callable

import numpy as np
from numpy import cos, sin

from helpers.reference import Array, integrate

g = 9.81
Columns = dict[str, Array]


def furuta(t: Array) -> Columns:
    """Arm at alpha about z, rod at beta about it: T = ((J + K sin^2 beta) alpha'^2 + 2 C cos beta alpha' beta' + D beta'^2)/2,
    V = -m g l cos beta."""
    m, l, L = 0.2, 0.2, 0.3
    J, K = 0.00225 + 0.3 * 0.15**2 + m * L**2 + 0.00001, m * l**2 + 0.00267 - 0.00001
    C, D = m * L * l, m * l**2 + 0.00267

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (_, beta), (da, db) = q, v
        s, c = sin(beta), cos(beta)
        M = np.array([[J + K * s * s, C * c], [C * c, D]])
        return np.linalg.solve(M, [C * s * db**2 - 2 * K * s * c * da * db, K * s * c * da**2 - m * g * l * s])

    (alpha, beta), (da, db) = integrate(acceleration, [0, 2.5], [4, 0.5], t)
    columns = {"turning.phi": alpha, "swinging.phi": beta, "turning.w": da, "swinging.w": db}
    reached = (0.3 * cos(alpha) - 0.4 * sin(beta) * sin(alpha), 0.3 * sin(alpha) + 0.4 * sin(beta) * cos(alpha), -0.4 * cos(beta))
    return columns | {f"reached[{k}]": x for k, x in enumerate(reached, 1)}


def gyroscope(t: Array) -> Columns:
    """Gimbals at alpha about z and beta about x, rotor at gamma: p = Jz (gamma' + alpha' cos beta) is constant, and

    A alpha'' + A_beta alpha' beta' - p sin beta beta' = 0,   B beta'' - A_beta alpha'^2/2 + p sin beta alpha' = m g h sin beta,
    A = 0.01 + (0.003 + Jt) sin^2 beta + 0.006 cos^2 beta.
    """
    m, h, Jz = 1.5, 0.02, 0.0035
    Jt = 0.002 + m * h**2
    B, difference = 0.004 + Jt, 0.003 + Jt - 0.006

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (_, beta, _), (da, db, dc) = q, v
        s, c = sin(beta), cos(beta)
        p, A, slope = Jz * (dc + da * c), 0.016 + difference * s * s, 2 * difference * s * c
        dda = (p * s * db - slope * da * db) / A
        return np.array([dda, (slope * da**2 / 2 - p * s * da + m * g * h * s) / B, da * s * db - dda * c])

    angles, rates = integrate(acceleration, [0, np.pi / 3, 0], [0.2, 0, 150], t)
    names = ("outer", "inner", "spinning")
    return {f"{name}.phi": x for name, x in zip(names, angles, strict=True)} | {
        f"{name}.w": x for name, x in zip(names, rates, strict=True)}


REFERENCES: dict[str, Callable[[Array], Columns]] = {"furuta": furuta, "gyroscope": gyroscope}
