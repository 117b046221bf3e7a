"""Accelerations of trees in space by another way: Jacobians and Newton-Euler sums in the axes of the world, in NumPy.

M = sum_k m J_v^T J_v + J_w^T I J_w about the centre of mass; h by the accelerations at dv/dt = 0. Source: Siciliano et al.,
Robotics (2009), section 7.1.
"""

from collections.abc import Sequence

import numpy as np

from lagrangia.dynamics.spatial_axes import SpatialJoint


def turned(axis: Sequence[float], angle: float) -> np.ndarray:
    """Rodrigues' formula."""
    x, y, z = axis
    across = np.array([[0, -z, y], [z, 0, -x], [-y, x, 0]])
    return np.eye(3) + np.sin(angle) * across + (1 - np.cos(angle)) * across @ across


def accelerations(joints: Sequence[SpatialJoint], size: int, r: np.ndarray, gravity: np.ndarray) -> np.ndarray:
    """Of joints whose numbers are floats, (n,): M a = r - h."""
    M, h = np.zeros((size, size)), np.zeros(size)
    states = []
    for joint in joints:
        R, place, w, v, alpha, a, Jv, Jw = states[joint.parent] if joint.parent is not None else (
            np.eye(3), np.zeros(3), *np.zeros((4, 3)), *np.zeros((2, 3, size)))
        ahead = R @ np.asarray(joint.origin, float)
        R = R @ np.asarray(joint.R, float)
        n, rate = R @ np.asarray(joint.axis, float), np.asarray(joint.motion[0], float)
        Jv, Jw = Jv.copy(), Jw.copy()
        if joint.kind == "shift":
            ahead = ahead + R @ np.asarray(joint.ahead, float)
        Jv += np.cross(Jw.T, ahead).T
        a = a + np.cross(alpha, ahead) + np.cross(w, np.cross(w, ahead))
        if joint.kind == "shift":
            a = a + 2 * np.cross(w, R @ rate)
            for index, slope in zip(joint.coordinates, joint.slopes, strict=True):
                Jv[:, index] += R @ np.asarray(slope, float)
        elif joint.kind == "turn":
            R = R @ turned(joint.axis, joint.amount)
            alpha, w = alpha + np.cross(w, n * rate[0]), w + n * rate[0]
            for index in joint.coordinates:  # none where time moves it
                Jw[:, index] += n
        else:
            R = R @ np.asarray(joint.attitude, float)
            spin = R @ rate
            alpha, w = alpha + np.cross(w, spin), w + spin
            Jw[:, list(joint.coordinates)] += R
        states.append((R, place + ahead, w, v, alpha, a, Jv, Jw))
        body = joint.body
        if body is not None:
            m, b, J = body.mass, R @ np.asarray(body.moment, float), R @ np.asarray(body.second_moment, float) @ R.T
            B = np.array([[0, b[2], -b[1]], [-b[2], 0, b[0]], [b[1], -b[0], 0]])  # w x b = B w
            M += m * Jv.T @ Jv + Jv.T @ B @ Jw + Jw.T @ B.T @ Jv + Jw.T @ J @ Jw
            felt = a - gravity
            h += Jv.T @ (m * felt + np.cross(alpha, b) + np.cross(w, np.cross(w, b)))
            h += Jw.T @ (J @ alpha + np.cross(w, J @ w) + np.cross(b, felt))
    return np.linalg.solve(M, r - h)
