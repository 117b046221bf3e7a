"""Equations of the examples of loops in space, by hand: test_examples.py compares."""

from collections.abc import Callable

import numpy as np
from numpy import cos, sin

from helpers.bodies_in_space import GROUND, Body, Moving, accelerations, cross
from helpers.reference import Array, integrate

g = 9.81
Columns = dict[str, Array]


def cardan_shaft(t: Array) -> Columns:
    """The shaft turns about its own axis k(phi) times as fast as motor and wheel:

    (J + Js k^2) phi'' + Js k k_phi phi'^2 = drive - c phi'
    """
    bend, drive, c, J, Js = np.radians(35), 0.5, 0.02, 0.02 + 0.05, 0.01

    def ratio(phi: Array) -> tuple[Array, Array]:
        k = cos(bend) / (1 - (sin(bend) * sin(phi)) ** 2)
        return k, k**2 / cos(bend) * sin(bend) ** 2 * sin(2 * phi)

    def acceleration(t: float, q: Array, v: Array) -> Array:
        k, slope = ratio(q)
        return (drive - c * v - Js * k * slope * v**2) / (J + Js * k**2)

    (phi,), (w,) = integrate(acceleration, [0], [10], t)
    found = {"motor.phi": phi, "motor.w": w, "axle.phi": phi, "axle.w": w, "uneven": ratio(phi)[0] * w}
    return found | {"near.phi_a": np.arctan(np.tan(bend) * cos(phi)), "near.phi_b": -np.arcsin(sin(bend) * sin(phi))}


def spatial_four_bar(t: Array) -> Columns:
    """The rod does not turn about itself; the rocker follows the crank, whose pin is at q from the rocker's axis:

    q_x cos phi - q_z sin phi = (q q + b^2 - c^2)/(2 b)
    """
    a, b, c, D = 0.3, 0.6, 1.1, np.array([0.9, 0.5, 0.2])

    def rocker(theta: Array) -> tuple[Array, Array]:
        x, y, z = a * cos(theta) - D[0], a * sin(theta) - D[1], -D[2]
        side, size = (x**2 + y**2 + z**2 + b**2 - c**2) / (2 * b), np.sqrt(x**2 + z**2)
        root = np.sqrt(size**2 - side**2)  # sin and cos of phi from their sum and difference; the pin is above
        cosine, sine = (x * side + z * root) / size**2, (x * root - z * side) / size**2
        slope_x, slope_y = -a * sin(theta), a * cos(theta)
        along = slope_x * (x - b * cosine) + slope_y * y
        return np.array([cosine, sine]), along / (-b * (x * sine + z * cosine))

    def look(q: Array, v: Array) -> tuple[list[Body], Array]:
        (cosine, sine), slope = rocker(q[0])
        turning, hinge = GROUND.turned([0, 0, 1], q[0], v[0]), GROUND.shifted(D)
        rocking = hinge.turned([0, 1, 0], np.arctan(sine / cosine) + np.pi * (cosine.real < 0), slope * v[0])
        near, far = turning.shifted([a, 0, 0]), rocking.shifted([b, 0, 0])
        w = cross((far.r - near.r) / c**2, far.v - near.v)
        rod = Moving((near.r + far.r) / 2, np.eye(3), (near.v + far.v) / 2, w)
        return [(1, np.diag([0.001, 0.02, 0.02]), turning.shifted([a / 2, 0, 0])), (2, 0.2 * np.eye(3), rod),
                (1.5, np.diag([0.001, 0.05, 0.05]), rocking.shifted([b / 2, 0, 0]))], np.zeros(0)

    q, v = integrate(lambda t, q, v: accelerations(look, q, v, np.array([0, 0, -g])), [0], [8], t)
    (cosine, sine), slope = rocker(q[0])
    return {"turning.phi": q[0], "turning.w": v[0], "rocking.phi": np.arctan2(sine, cosine), "rocking.w": slope * v[0]}


def bricard(t: Array) -> Columns:
    """Every second angle is the same, theta and phi in turns: sin theta + sin phi + sin theta sin phi = 0."""
    axes = [[0, 1, 0], [0, 0, 1], [1, 0, 0]] * 2
    rods = [[1, 0, 0], [0, -1, 0], [0, 0, 1], [-1, 0, 0], [0, 1, 0]]

    def other(theta: Array) -> tuple[Array, Array]:
        s = sin(theta)
        phi = -np.arcsin(s / (1 + s))
        return phi, -cos(theta) / (1 + s) ** 2 / cos(phi)

    def look(q: Array, v: Array) -> tuple[list[Body], Array]:
        (phi, slope), here, bodies = other(q[0]), GROUND, []
        angles, rates = (q[0], phi), (v[0], slope * v[0])
        for k, rod in enumerate(np.array(rods)):
            here = here.turned(axes[k], angles[k % 2], rates[k % 2])
            bodies.append((1, np.diag((1.01 - 0.99 * rod**2) / 12), here.shifted(rod / 2)))
            here = here.shifted(rod)
        return bodies, np.zeros(0)

    (theta,), (w,) = integrate(lambda t, q, v: accelerations(look, q, v, np.array([0, -g, 0])), [0], [0], t)
    phi, slope = other(theta)
    return {f"p{k}.phi": x for k, x in zip(range(1, 7), [theta, phi] * 3, strict=True)} | {"p1.w": w, "p4.w": slope * w}


def plate(q: Array, v: Array) -> Moving:
    """The plate of the hexapod from its place and its angles zyx."""
    x, y, z, *angles = zip(q, v, strict=True)
    place = GROUND.slid([1, 0, 0], *x).slid([0, 1, 0], *y).slid([0, 0, 1], *z)
    return place.turned([0, 0, 1], *angles[0]).turned([0, 1, 0], *angles[1]).turned([1, 0, 0], *angles[2])


def leg(foot: Array, end: Moving) -> list[Body]:
    """Its tube and its rod, which follow the point that they carry."""
    d = end.r - foot
    s = np.sqrt(d @ d)
    u, rate = d / s, d @ end.v / s
    du = (end.v - u * rate) / s
    stand = GROUND.shifted(foot).turned([1, 0, 0], -np.arctan(u[1] / u[2]), (u[1] * du[2] - du[1] * u[2]) / (u[1]**2 + u[2]**2))
    stand = stand.turned([0, 1, 0], np.arcsin(u[0]), du[0] / np.sqrt(1 - u[0]**2))
    places = stand.shifted([0, 0, 0.2]), stand.slid([0, 0, 1], s, rate).shifted([0, 0, -0.2])
    return [(0.5, np.diag([0.01, 0.01, 0.001]), place) for place in places]


def hexapod(t: Array) -> Columns:
    """Newton and Euler in numbers, with the place and the angles zyx of the plate as coordinates."""
    R, r, k, s0 = 1, 0.5, 4000, 1.1
    low, high = np.radians([-10, 70, 110, 190, 230, 310]), np.radians([20, 40, 140, 160, 260, 280])
    feet, tops = (np.array([size * cos(x), size * sin(x), 0 * x]).T for size, x in ((R, low), (r, high)))
    across, level = 10 * (r**2 / 4 + 0.05**2 / 12), 10 * r**2 / 2

    def look(q: Array, v: Array) -> tuple[list[Body], Array]:
        carried = plate(q, v)
        legs = [body for foot, top in zip(feet, tops, strict=True) for body in leg(foot, carried.shifted(top))]
        return [(10, np.diag([across, across, level]), carried), *legs], np.zeros(0)

    def lengths(q: Array) -> Array:
        at = plate(q, 0 * q)
        d = at.r + tops @ at.R.T - feet
        return np.sqrt((d * d).sum(axis=1))

    def acceleration(t: float, q: Array, v: Array) -> Array:
        slopes = np.array([lengths(q + 1j * 1e-40 * e).imag / 1e-40 for e in np.eye(6)])
        return accelerations(look, q, v, np.array([0, 0, -g]), -k * slopes @ (lengths(q) - s0))

    q, v = integrate(acceleration, [0.05, 0, 0.9, np.radians(10), np.radians(5), 0], np.zeros(6), t)
    s = np.array([lengths(x) for x in q.T])
    places = {f"pose.{name}": x for name, x in zip("xyz", q, strict=False)}
    return places | {f"leg[{k + 1}].s": s[:, k] for k in range(6)} | {"der(pose.z)": v[2]}


REFERENCES: dict[str, Callable[[Array], Columns]] = {
    "cardan_shaft": cardan_shaft, "spatial_four_bar": spatial_four_bar, "bricard": bricard, "hexapod": hexapod}
