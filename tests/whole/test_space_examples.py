"""Equations of the spatial examples, by hand: test_examples.py compares."""

from collections.abc import Callable

import numpy as np
from numpy import cos, sin

from helpers.bodies_in_space import GROUND, Body, accelerations, slip_of_disc
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


def rolling_disc_space(t: Array) -> Columns:
    """Euler's angles zxz and w3 = psi' + phi' cos theta, A = m r^2/4, C = m r^2/2 (E.J. Routh):

    (A + m r^2) theta'' = A phi'^2 sin theta cos theta - (C + m r^2) w3 phi' sin theta - m g r cos theta
    A phi'' sin theta = C w3 theta' - 2 A phi' theta' cos theta,   (C + m r^2) w3' = m r^2 theta' phi' sin theta

    The centre's velocity is r (theta' e3 - w3 e1), e1 level along the disc, e3 its axis.
    """
    m, r = 2, 0.25
    A, C, heavy = m * r**2 / 4, m * r**2 / 2, m * r**2

    def acceleration(t: float, q: Array, v: Array) -> Array:
        (phi, theta, *_), (dphi, dtheta, w3, *_) = q, v
        s, c = sin(theta), cos(theta)
        tilting = (A * dphi**2 * s * c - (C + heavy) * w3 * dphi * s - m * g * r * c) / (A + heavy)
        spinning = heavy * dtheta * dphi * s / (C + heavy)
        along, aside = -spinning + dtheta * dphi * s, tilting * s + dtheta**2 * c + w3 * dphi
        return np.array([(C * w3 - 2 * A * dphi * c) * dtheta / (A * s), tilting, spinning,
                         r * (along * cos(phi) + aside * sin(phi)), r * (along * sin(phi) - aside * cos(phi))])

    start = np.radians(60)
    (phi, theta, _, x, y), v = integrate(acceleration, [0, start, 0, 0, 0], [1.3 / sin(start), 0, -8, 8 * r, 0], t)
    ahead = r * cos(theta)
    place = {"disc.center.x": x, "disc.center.y": y, "disc.center.z": r * sin(theta), "der(disc.center.S)[3]": v[2]}
    return place | {"contact[1]": x + ahead * sin(phi), "contact[2]": y - ahead * cos(phi)}


def bicycle(t: Array) -> Columns:
    """Newton and Euler in numbers, with the contacts of both wheels as constraints on velocities."""
    base, trail, tilt, head, v0 = 1.02, 0.08, np.radians(18), 0.8, 4.6
    radii, back = (0.3, 0.35), head * np.tan(tilt) - trail

    def look(q: Array, v: Array) -> tuple[list[Body], Array]:
        x, y, yaw, z, lean, pitch, rear, steer, front = zip(q, v, strict=True)
        path = GROUND.slid([1, 0, 0], *x).slid([0, 1, 0], *y).turned([0, 0, 1], *yaw).slid([0, 0, 1], *z)
        frame = path.turned([1, 0, 0], *lean).turned([0, 1, 0], *pitch)
        fork = frame.shifted([base - back, 0, head - 0.3]).turned([sin(tilt), 0, -cos(tilt)], *steer)
        wheels = frame.turned([0, 1, 0], *rear), fork.shifted([back, 0, 0.35 - head]).turned([0, 1, 0], *front)
        bodies = [(85, np.array([[9.2, 0, -2.4], [0, 11, 0], [-2.4, 0, 2.8]]), frame.shifted([0.3, 0, 0.6])),
                  (2, np.diag([0.0603, 0.12, 0.0603]), wheels[0]), (3, np.diag([0.1405, 0.28, 0.1405]), wheels[1]),
                  (4, np.array([[0.05892, 0, 0.00756], [0, 0.06, 0], [0.00756, 0, 0.00708]]),
                   fork.shifted([0.9 - base + back, 0, 0.7 - head]))]
        return bodies, np.concatenate([slip_of_disc(wheel, [0, 1, 0], r) for wheel, r in zip(wheels, radii, strict=True)])

    start, free = np.zeros(9), np.array([v0, -0.15, 0, 0, 0.5, 0, v0 / 0.3, 0, v0 / 0.35])
    start[3] = 0.3
    q, _ = integrate(lambda t, q, v: accelerations(look, q, v, np.array([0, 0, -g])), start, free, t)
    names = ("path.x", "path.y", "path.phi", "height.s", "lean.phi", "pitch.phi", "rear.phi", "steer.phi", "front.phi")
    return {name: x for name, x in zip(names, q, strict=True) if name != "pitch.phi"}  # which is small


def robot_arm(t: Array) -> Columns:
    """Newton and Euler in numbers, in the frames of Denavit and Hartenberg."""
    alpha, a, d = np.radians([90, 0, -90, 90, -90, 0]), [0, 0.4318, 0.0203, 0, 0, 0], [0, 0, 0.15005, 0.4318, 0, 0]
    m = [0, 17.4, 4.8, 0.82, 0.34, 0.09]
    centres = [[0, 0, 0], [-0.3638, 0.006, 0.2275], [-0.0203, -0.0141, 0.07], [0, 0.019, 0], [0, 0, 0], [0, 0, 0.032]]
    moments = [[0.35, 0.35, 0], [0.13, 0.524, 0.539], [0.066, 0.086, 0.0125], [0.0018, 0.0013, 0.0018],
               [3.0e-4, 4.0e-4, 3.0e-4], [1.5e-4, 1.5e-4, 4.0e-5]]

    def look(q: Array, v: Array) -> tuple[list[Body], Array]:
        here, bodies = GROUND, []
        for k in range(6):
            here = here.turned([0, 0, 1], q[k], v[k]).shifted([a[k], 0, d[k]]).turned([1, 0, 0], alpha[k])
            bodies.append((m[k], np.diag(moments[k]), here.shifted(centres[k])))
        return bodies, np.zeros(0)

    start = [0, 0.7854, 3.1416, 0, 0.7854, 0]
    q, v = integrate(lambda t, q, v: accelerations(look, q, v, np.array([0, 0, -g])), start, np.zeros(6), t)
    return {f"joint[{k}].phi": q[k - 1] for k in (1, 2, 3, 5)} | {f"joint[{k}].w": v[k - 1] for k in (1, 2, 3, 5)}


REFERENCES: dict[str, Callable[[Array], Columns]] = {
    "top": top, "robot_arm": robot_arm, "satellite": satellite, "rolling_disc_space": rolling_disc_space, "bicycle": bicycle}
