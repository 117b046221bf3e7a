"""The examples of closed loops, constraints and prescribed motion, on paper."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp
from numpy import cos, sin
from scipy.special import ellipj, ellipk

import lagrangia as lag
from helpers.mechanisms import Mechanism, Point, at, four_bar, g, meet, phi, polar
from helpers.reference import Array, integrate

FOLDER = Path(__file__).parents[2] / "models" / "examples"

Columns = dict[str, Array]


# ---------------------------------------------------------------- the examples, on paper


def four_bar_linkage(t: Array) -> Columns:
    """Mechanism of one angle, the coupler's end where two circles meet."""
    mechanism, end = four_bar(masses=(1, 2, 1.5), lengths=(0.4, 1, 0.8, 1))
    angle, w = mechanism.motion(t, start=np.radians(40))
    return {"O.phi": angle, "O.w": w} | at({"coupler.b.x": end[0], "coupler.b.y": end[1]}, angle)


def slider_crank(t: Array) -> Columns:
    """s = r cos phi + sqrt(L^2 - r^2 sin^2 phi), and out of the dead centre phi = 0 without a preferred side."""
    r, L = 0.1, 0.3
    pin = polar(r, phi)
    s = pin[0] + sp.sqrt(L**2 - pin[1] ** 2)
    mechanism = Mechanism(gravity=0, force=0.5)
    mechanism.bar(1, (0, 0), pin)
    mechanism.bar(0.5, pin, (s, 0))
    mechanism.point(2, (s, sp.Integer(0)))
    angle, w = mechanism.motion(t, start=0)
    return {"O.phi": angle, "O.w": w} | at({"guide.s": s}, angle)


def rolling_disc(t: Array) -> Columns:
    """Centre at s = -r phi, the lump at (s + r sin phi, r - r cos phi)."""
    r = 0.2
    s = -r * phi
    mechanism = Mechanism()
    mechanism.point(1, (s, sp.Integer(0)))
    mechanism.weighted.append((1 * r**2 / 2, phi))
    mechanism.point(0.5, (s + r * sp.sin(phi), r - r * sp.cos(phi)))
    angle, w = mechanism.motion(t, start=np.radians(100))
    return {"track.phi": angle, "der(track.phi)": w} | at({"track.s": s}, angle)


def incline_disc(t: Array) -> Columns:
    """(3/2) m s'' + k s = m g sin slope, from rest at s = 0."""
    m, k = 2, 150
    rest = m * g * sin(np.radians(30)) / k
    s = rest * (1 - cos(np.sqrt(k / (1.5 * m)) * t))
    return {"track.s": s, "track.phi": -s / 0.1}


def atwood(t: Array) -> Columns:
    """(m1 + m2 + I/r^2) s'' = (m1 - m2) g, I/r^2 = 4/2."""
    s = (3 - 2) * g / (3 + 2 + 4 / 2) * t**2 / 2
    return {"left.s": s, "right.s": -s, "axle.phi": s / 0.1}


def gear_train(t: Array) -> Columns:
    """phi2 = -phi1/4, phi3 = phi1/8:  J w1' + (c/64) w1 = T with J = I1 + I2/16 + I3/64."""
    J = 1 * 0.05**2 / 2 + 2 * 0.08**2 / 2 / 16 + 5 * 0.2**2 / 2 / 64
    c, T = 0.2 / 64, 0.1
    w = T / c * (1 - np.exp(-c / J * t))
    angle = (T * t - J * w) / c
    return {"shaft[1].phi": angle, "shaft[2].phi": -angle / 4, "shaft[3].phi": angle / 8, "shaft[3].w": w / 8}


def pantograph(t: Array) -> Columns:
    """Every centre lies at a e(A) + b e(B), A and B the angles of the long bars and e(A) the unit vector, and the stylus at
    P = L e(A) + L e(B), pulled to C by the spring:

    J A'' + sum m a^2 A'' + sum m a b (B'' cos(A - B) + B'^2 sin(A - B)) = k (C - P) . dP/dA,   likewise for B
    """
    L, k = 0.5, 40
    C = np.array([0.6, -0.4])
    m, a, b = np.array([2, 2, 1, 1]), L * np.array([1, 2, 1, 1.5]), L * np.array([0, 1, 0.5, 1])
    J = 2 * (2 * L) ** 2 / 12 + 1 * L**2 / 12
    aa, ab, bb = (m * a * a).sum() + J, (m * a * b).sum(), (m * b * b).sum() + J

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (A, B), (dA, dB) = q, v
        M = [[aa, ab * cos(A - B)], [ab * cos(A - B), bb]]
        pull = k * (C - L * (np.array([cos(A), sin(A)]) + np.array([cos(B), sin(B)])))
        load = [
            -ab * dB**2 * sin(A - B) + pull @ [-L * sin(A), L * cos(A)],
            ab * dA**2 * sin(A - B) + pull @ [-L * sin(B), L * cos(B)],
        ]
        return np.linalg.solve(M, load)

    (A, B), (dA, dB) = integrate(acceleration, np.radians([-20, -100]), [0, 0], t)
    x, y = L * (cos(A) + cos(B)), L * (sin(A) + sin(B))
    return {"pivot.phi": A, "elbow.phi": B - A, "elbow.w": dB - dA, "original[1]": x, "original[2]": y,
            "copy[1]": 2 * x, "copy[2]": 2 * y}  # fmt: skip


def scissor_lift(t: Array) -> Columns:
    """Bars at the angles phi and -phi: foot at L cos phi, centres of the pair i at the height (i - 1/2) L sin phi."""
    n, L, k = 3, 1, 4000
    foot, top = L * sp.cos(phi), n * L * sp.sin(phi)
    mechanism = Mechanism(potential=k * (foot - 0.6) ** 2 / 2)
    for i in range(n):
        low, high = i * L * sp.sin(phi), (i + 1) * L * sp.sin(phi)
        mechanism.bar(2, (0, low), (foot, high))
        mechanism.bar(2, (0, high), (foot, low))
    mechanism.point(10, (sp.Integer(0), top))
    angle, _ = mechanism.motion(t, start=np.arccos(0.8))
    return at({"foot.s": foot, "load.center.y": top}, angle)


def ellipse_trammel(t: Array) -> Columns:
    """The centre runs on a circle, so the rod turns evenly; the point at the distance d beyond b draws ((L + d) cos, d sin)."""
    angle, L, d = -2 * t, 1, 0.4
    return {"rod.center.phi": angle, "rod.center.x": L / 2 * cos(angle), "rod.center.y": -L / 2 * sin(angle),
            "pen.x": (L + d) * cos(angle), "pen.y": d * sin(angle)}  # fmt: skip


def skate(t: Array) -> Columns:
    """Heading w t, and along it v' = g cos w t: the blade runs a cycloid across the slope."""
    slope, w = 1, 2
    x = slope / (2 * w**2) * sin(w * t) ** 2
    y = slope / (2 * w**2) * (w * t - sin(2 * w * t) / 2)
    return {"skate.center.phi": w * t, "skate.center.x": x, "skate.center.y": y}


def crank_press(t: Array) -> Columns:
    """Ram at the depth S = sqrt(L^2 - r^2 cos^2 wt) - r sin wt; table at u above 1 m of depth:

    m u'' = K (1 - S - u - l0) - k u - m g
    """
    r, L, w, m, k, K = 0.1, 0.4, 10, 40, 50e3, 20e3

    def depth(t: Array) -> Array:
        return np.sqrt(L**2 - (r * cos(w * t)) ** 2) - r * sin(w * t)

    def acceleration(t: float, q: Array, v: Array) -> Array:
        return np.array([(K * (1 - depth(t) - q[0] - 0.6) - k * q[0]) / m - g])

    u, _ = integrate(acceleration, [0], [0], t)
    return {"O.phi": w * t, "ram.s": depth(t), "table.s": u[0]}


def parallelogram(t: Array) -> Columns:
    """sum m L^2/3 over the bars + m_seat L^2 = 3,  weights 3/2 + 2:  3 theta'' = -3.5 g sin theta, an elliptic function of t."""
    k = sin(np.radians(60) / 2)
    theta = 2 * np.arcsin(k * ellipj(ellipk(k**2) - np.sqrt(3.5 / 3 * g) * t, k**2)[0])
    return {f"hook[{i}].phi": theta - np.pi / 2 for i in (1, 2, 3)} | {"seat.center.x": sin(theta), "seat.center.y": -cos(theta)}


def n_four_bars(t: Array) -> Columns:
    """n + 1 cranks at one angle from the x axis: ((n + 1)/3 + n) L phi'' = -((n + 1)/2 + n) g cos phi."""
    n = 2
    ratio = ((n + 1) / 2 + n) / ((n + 1) / 3 + n)
    (angle,), (w,) = integrate(lambda t, q, v: -ratio * g * cos(q), [np.pi / 2], [-1], t)
    return {f"foot[{i}].phi": angle for i in range(1, n + 2)} | {"foot[1].w": w}


def andrews_squeezer(t: Array) -> Columns:
    """The crank's angle places F; E lies where circles about F and B meet, G and H where circles about A and E meet.

    A point given in a bar's own axes is `beyond` the bar's beginning: p + x e + y e', e from p to q.
    """
    mm = 1e-3
    A, B, C = (-69.34 * mm, -2.27 * mm), (-36.35 * mm, 32.73 * mm), (14 * mm, 72 * mm)

    def beyond(p: Point, q: Point, L: float, x: float, y: float) -> Point:
        ex, ey = (q[0] - p[0]) / L, (q[1] - p[1]) / L
        return p[0] + x * ex - y * ey, p[1] + x * ey + y * ex

    F = polar(7 * mm, phi)
    E = meet(F, 28 * mm, B, 35 * mm)
    G, H = meet(A, 40 * mm, E, 20 * mm), meet(E, 20 * mm, A, 40 * mm)
    mechanism = Mechanism(gravity=0, force=0.033)

    def body(m: float, I: float, p: Point, q: Point, L: float, x: float, y: float) -> None:
        mechanism.point(m, beyond(p, q, L, x * mm, y * mm))
        mechanism.turning(I / L**2, p, q)

    body(0.04325, 2.194e-6, (0, 0), F, 7 * mm, 0.92, 0)
    body(0.00365, 4.410e-7, E, F, 28 * mm, 28 - 11.5, 0)
    body(0.02373, 5.255e-6, B, E, 35 * mm, 18.74, 10.43)
    body(0.00706, 5.667e-7, G, E, 20 * mm, 5.79, 0)
    body(0.07050, 1.169e-5, A, G, 40 * mm, 23.08, 9.16)
    body(0.00706, 5.667e-7, H, E, 20 * mm, 5.79, 0)
    body(0.05498, 1.912e-5, A, H, 40 * mm, 12.28, -4.49)
    D = beyond(B, E, 35 * mm, 18 * mm, 20 * mm)
    length = sp.sqrt((D[0] - C[0]) ** 2 + (D[1] - C[1]) ** 2)
    mechanism.potential = 4530 * (length - 77.85 * mm) ** 2 / 2
    angle, w = mechanism.motion(t, start=-0.0617138900142764496358948458001)
    return {"O.phi": angle, "O.w": w} | at({"F.a.x": F[0], "E3.a.x": E[0], "E3.a.y": E[1]}, angle)


REFERENCES: dict[str, Callable[[Array], Columns]] = {
    "andrews_squeezer": andrews_squeezer,
    "atwood": atwood,
    "crank_press": crank_press,
    "ellipse_trammel": ellipse_trammel,
    "four_bar": four_bar_linkage,
    "gear_train": gear_train,
    "incline_disc": incline_disc,
    "n_four_bars": n_four_bars,
    "pantograph": pantograph,
    "parallelogram": parallelogram,
    "rolling_disc": rolling_disc,
    "scissor_lift": scissor_lift,
    "skate": skate,
    "slider_crank": slider_crank,
}

# ---------------------------------------------------------------- the tests


@pytest.mark.parametrize("name", REFERENCES)
def test_stays_on_its_constraints(name: str) -> None:
    """At a loose tolerance too: to rounding, in m and rad, and in m/s and rad/s."""
    run = lag.load(FOLDER / f"{name}.lag").simulate(tolerance=1e-4)
    speed = max(1, *(np.abs(run[column.name]).max() for column in run.scene.rates))
    assert run.statistics.constraint_residual < 1e-12
    assert run.statistics.constraint_rate_residual < 1e-12 * speed


@pytest.mark.parametrize("name", ["atwood", "gear_train", "incline_disc", "rolling_disc"])
def test_linear_ties_leave_one_coordinate_and_no_multiplier(name: str) -> None:
    scene = lag.load(FOLDER / f"{name}.lag").scene
    assert scene.n == 1
    assert scene.sizes["n_multipliers"] == 0
