"""Frames in space: rates against differences, virtual displacements against the twist, inertias against sums over mass points."""

import casadi as ca
import numpy as np
import pytest

from lagrangia.algebra.duals import Dual, DualAlgebra, rate_of, value_of
from lagrangia.algebra.with_casadi import CasadiAlgebra
from lagrangia.base.diagnostics import LagError, Source, Span
from lagrangia.frames import spatial
from lagrangia.frames.spatial import HERE, NOWHERE, SIZE, Pose, rotation
from lagrangia.frames.spatial_bodies import FreeBody, Inertia, inertial_wrench, inertias, unit_load, unlike_a_body, wrench_about
from lagrangia.language.frame_steps import Step
from lagrangia.language.tree import Array, Number

PLACE = Span(Source("test", "turn"), 0, 4)
NUMBERS = CasadiAlgebra(ca.SX.sym("t"), ca.SX.sym("x"))
AXES = [(0.0, 0.0, 1.0), (1.0, 0.0, 0.0), (0.0, -1.0, 0.0), (0.6, 0.0, 0.8), (1 / 3, -2 / 3, 2 / 3)]
random = np.random.default_rng(3)


def skew(a: np.ndarray) -> np.ndarray:
    return np.array([[0, -a[2], a[1]], [a[2], 0, -a[0]], [-a[1], a[0], 0]])


def exponential(matrix: np.ndarray) -> np.ndarray:
    total, term = np.eye(3), np.eye(3)
    for k in range(1, 30):
        term = term @ matrix / k
        total = total + term
    return total


@pytest.mark.parametrize("axis", AXES)
def test_a_turn_is_the_exponential_of_its_axis(axis: tuple[float, ...]) -> None:
    found = np.array(rotation(axis, 0.7, NUMBERS))
    assert found == pytest.approx(exponential(0.7 * skew(np.array(axis))), abs=1e-15)


def test_right_angles_leave_axes_along_axes() -> None:
    assert rotation((1.0, 0.0, 0.0), np.pi / 2, NUMBERS) == ((1.0, 0.0, 0.0), (0.0, 0.0, -1.0), (0.0, 1.0, 0.0))


def path(t: float, level: int) -> tuple[Pose, list[np.ndarray]]:
    """A frame behind three turns and two shifts that move with time, and its pose at t; at level 2 with rates of rates."""
    def moving(values: tuple[float, float, float]) -> Dual | float:
        x, v, a = values
        return Dual(Dual(x, v), Dual(v, a)) if level == 2 else Dual(x, v) if level == 1 else x

    algebra = [NUMBERS, DualAlgebra(NUMBERS), DualAlgebra(DualAlgebra(NUMBERS))][level]
    pose = spatial.root_pose({}, float, algebra, level)
    for k, axis in enumerate(AXES[:1] + AXES[3:]):
        rate = 0.5 + k
        pose = pose.turned(moving((np.sin(rate * t), rate * np.cos(rate * t), -rate**2 * np.sin(rate * t))), axis, algebra)
        pose = pose.moved(pose.to_world((0.3, -0.2 * k, moving((t**3 / 6, t**2 / 2, t)))))
    return pose, [np.array(row, dtype=float) for row in pose.axes]


def plain(pose: Pose) -> tuple[np.ndarray, np.ndarray]:
    return np.array([float(x) for x in pose.origin]), np.array(pose.axes, dtype=float)


def test_rates_of_a_pose_are_those_of_differences() -> None:
    h, t = 1e-4, 0.8
    pose, _ = path(t, 2)
    below = pose.lowered
    places = [plain(path(t + k * h, 0)[0]) for k in (-2, -1, 1, 2)]
    r_rate = sum(c * r for c, (r, _) in zip((1, -8, 8, -1), places, strict=True)) / (12 * h)
    R_rate = sum(c * R for c, (_, R) in zip((1, -8, 8, -1), places, strict=True)) / (12 * h)
    spin = [float(x) for x in below.spin]
    assert [float(rate_of(x)) for x in below.origin] == pytest.approx(r_rate, abs=1e-10)
    assert skew(np.array(spin)) == pytest.approx(R_rate @ plain(below.lowered)[1].T, abs=1e-10)
    spins = [np.array([float(x) for x in path(t + k * h, 1)[0].spin]) for k in (-2, -1, 1, 2)]
    speeds = [np.array([float(rate_of(x)) for x in path(t + k * h, 1)[0].origin]) for k in (-2, -1, 1, 2)]
    for found, values in ((pose.spin, spins), ([rate_of(x) for x in pose.origin], speeds)):
        turning = sum(c * w for c, w in zip((1, -8, 8, -1), values, strict=True)) / (12 * h)
        assert [float(rate_of(x)) for x in found] == pytest.approx(turning, abs=1e-9)


def test_the_matrix_and_the_own_angular_velocity_have_their_rates() -> None:
    pose = path(0.8, 1)[0]
    R = spatial.attribute_of(pose, "R")
    spin = np.array([float(x) for x in pose.spin])
    assert np.array([[float(rate_of(x)) for x in row] for row in R]) == pytest.approx(skew(spin) @ np.array(pose.axes), abs=1e-14)
    own = spatial.attribute_of(path(0.8, 2)[0], "omega")
    h = 1e-4
    near = [np.array([float(x) for x in spatial.attribute_of(path(0.8 + k * h, 1)[0], "omega")]) for k in (-1, 1)]
    assert [float(value_of(x)) for x in own] == pytest.approx(np.array(pose.axes).T @ spin, abs=1e-14)
    assert [float(rate_of(x)) for x in own] == pytest.approx((near[1] - near[0]) / (2 * h), abs=1e-7)


def test_a_small_displacement_moves_as_a_twist_does() -> None:
    pose, h = path(0.8, 0)[0], 1e-7
    for k in range(SIZE):
        parts = np.eye(SIZE)[k]
        r, R = plain(pose.displaced(h * parts, NUMBERS))
        assert (r - plain(pose)[0]) / h == pytest.approx(parts[:3], abs=1e-7)
        assert (R - plain(pose)[1]) / h == pytest.approx(skew(parts[3:]) @ plain(pose)[1], abs=1e-7)


def test_steps_go_back() -> None:
    shift = Step("shift", Array((), PLACE))
    turn = Step("turn", Number(0.4, None, PLACE), axis=Array((), PLACE))
    ahead = spatial.step(spatial.step(HERE, shift, (1.0, 2.0, 3.0), None, NUMBERS), turn, 0.4, (1.0, 2.0, 2.0), NUMBERS)
    turned = spatial.step(ahead, turn.inverse(), 0.4, (1.0, 2.0, 2.0), NUMBERS)
    back = spatial.step(turned, shift.inverse(), (1.0, 2.0, 3.0), None, NUMBERS)
    assert plain(back)[0] == pytest.approx([0, 0, 0], abs=1e-15) and plain(back)[1] == pytest.approx(np.eye(3), abs=1e-15)
    with pytest.raises(LagError, match="length 0"):
        spatial.step(HERE, turn, 0.4, (0.0, 0.0, 0.0), NUMBERS)


@pytest.mark.parametrize("size", [1e-200, 1e155, 1e300])
def test_axes_of_any_length(size: float) -> None:
    """Their squares are 0 or infinite: 'the length 0', and a division by zero."""
    turn = Step("turn", Number(0.4, None, PLACE), axis=Array((), PLACE))
    axis = spatial.unit_axis(turn, (size, -2*size, 2*size), NUMBERS)
    assert axis == pytest.approx([1/3, -2/3, 2/3], rel=1e-15)


def body() -> tuple[np.ndarray, np.ndarray, Inertia]:
    masses, places = random.uniform(1, 2, 6), random.uniform(-1, 1, (6, 3))
    J = sum(m * (p @ p * np.eye(3) - np.outer(p, p)) for m, p in zip(masses, places, strict=True))
    b = masses @ places
    return masses, places, Inertia("f", float(masses.sum()), tuple(map(float, b)), tuple(tuple(map(float, row)) for row in J))


def test_what_an_inertia_asks_for_is_the_sum_over_its_points() -> None:
    masses, places, inertia = body()
    pose = path(0.8, 2)[0]
    R = np.array(pose.axes)
    a = np.array([float(rate_of(rate_of(x))) for x in pose.origin])
    w, alpha = (np.array([float(f(x)) for x in pose.spin]) for f in (value_of, rate_of))
    points = places @ R.T
    pulls = masses[:, None] * (a + np.cross(alpha, points) + np.cross(w, np.cross(w, points)))
    found = [float(x) for x in inertial_wrench(inertia, pose)]
    assert found == pytest.approx([*pulls.sum(0), *np.cross(points, pulls).sum(0)], rel=1e-13)


def test_an_inertia_is_found_in_a_kinetic_energy() -> None:
    masses, places, inertia = body()
    free = FreeBody()
    speeds = [free.velocity("v", HERE.at(tuple(map(float, p))), HERE) for p in places]
    T = sum(m / 2 * sum(x * x for x in v) for m, v in zip(masses, speeds, strict=True))
    turned = free.hessians([T])
    straight = free.straight(turned)
    (found,) = inertias(["f"], straight)
    assert float(found.mass) == pytest.approx(inertia.mass)
    assert [float(x) for x in found.first_moment] == pytest.approx(inertia.first_moment)
    assert np.array(found.second_moment, dtype=float) == pytest.approx(np.array(inertia.second_moment))
    assert float(ca.norm_inf(unlike_a_body(straight))) < 1e-14
    look = ca.Function("look", [x for row in free.axes for x in row], [turned - straight])
    assert float(ca.norm_inf(look(*[x for row in np.array(rotation(AXES[4], 0.3, NUMBERS)) for x in row]))) < 1e-13
    assert float(ca.norm_inf(unlike_a_body(free.straight(free.hessians([T + free.velocity("v", HERE, HERE)[0] ** 2]))))) > 1


def test_wrenches_keep_their_power() -> None:
    wrench, spin = random.uniform(-1, 1, SIZE), random.uniform(-1, 1, 3)
    here, there = HERE.at((1.0, 2.0, 3.0)), HERE.at((0.5, -1.0, 0.0))
    velocity = random.uniform(-1, 1, 3)
    moved = np.array(wrench_about(ca.DM(wrench), here, there)).ravel()
    at_there = velocity + np.cross(spin, np.array(there.origin) - np.array(here.origin))
    assert wrench[:3] @ velocity + wrench[3:] @ spin == pytest.approx(moved[:3] @ at_there + moved[3:] @ spin)
    for slopes in ([1.0, 2.0, 0.0, 0.0, 0.0, 0.0], [*NOWHERE, 0.6, 0.0, 0.8]):
        load = unit_load([ca.SX(x) for x in slopes])
        assert float(ca.dot(load, ca.DM(slopes))) == pytest.approx(1)
