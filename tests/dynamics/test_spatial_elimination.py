"""Accelerations along trees in space: against Jacobians in the axes of the world, published numbers, and counts of operations."""

from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest
import yaml

from helpers.spatial_reference import accelerations, turned
from lagrangia.algebra.scalars import symbol
from lagrangia.dynamics.motion import count_nodes
from lagrangia.dynamics.spatial_axes import SpatialJoint, lay_axes
from lagrangia.dynamics.spatial_drift import drift_of
from lagrangia.dynamics.spatial_elimination import SpatialTree
from lagrangia.frames.spatial_inertia import SAME, RigidInertia

X, Y, Z = (1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0)
GRAVITY = (0.3, -0.2, -9.81)


def general_body(random: np.random.Generator) -> RigidInertia:
    """Of a general shape, away from its frame."""
    rod = random.uniform(-1, 1, (3, 3))
    J, b, m = rod @ rod.T, random.uniform(-0.3, 0.3, 3), random.uniform(0.5, 2)
    J = np.trace(J) * np.eye(3) - J + (b @ b * np.eye(3) - np.outer(b, b)) / m
    return RigidInertia(float(m), b.tolist(), J.tolist())


def general_attitude(random: np.random.Generator) -> list[list[float]]:
    n = random.normal(size=3)
    return turned(n / np.linalg.norm(n), 1.3).tolist()


def joint(random: np.random.Generator, parent: int | None, kind: str, at: int, axis: Sequence[float] | None = None,
          R: Any = None) -> SpatialJoint:
    """At a general place; without an axis about a general one."""
    if axis is None:
        axis = random.normal(size=3)
        axis = (axis / np.linalg.norm(axis)).tolist()
    places = (at, at + 1, at + 2) if kind == "rotation" else (at,)
    R = general_attitude(random) if R is None else R
    amount, rates = float(random.uniform(-1, 1)), random.uniform(-2, 2, len(places)).tolist()
    ahead = [amount * x for x in axis]
    slopes = (axis,) if kind == "shift" else (1.0,)
    motion = ([rates[0] * x for x in axis], (0.0,) * 3) if kind == "shift" else (rates, (0.0,) * len(places))
    return SpatialJoint(parent, kind, R, random.uniform(-1, 1, 3).tolist(), places, slopes, axis, amount, ahead,
                        general_attitude(random), motion, general_body(random))


def solve(joints: Sequence[SpatialJoint], size: int, r: Sequence[Any], gravity: Sequence[Any]) -> tuple[SpatialTree, list[Any]]:
    links, _ = lay_axes(joints)
    tree, drift = SpatialTree(links, size), drift_of(links)
    return tree, tree.solve(r, {}, drift, [-x for x in gravity])


def check(joints: Sequence[SpatialJoint], size: int, within: float = 1e-11) -> None:
    r = np.linspace(-1, 2, size)
    _, found = solve(joints, size, r.tolist(), GRAVITY)
    expected = accelerations(joints, size, r, np.array(GRAVITY))
    assert np.abs(np.array(found) - expected).max() <= within * np.abs(expected).max()


TREES: dict[str, list[tuple[int | None, str, Any, Any]]] = {
    "general hinges": [(k - 1 if k else None, "turn", None, None) for k in range(6)],
    "branches": [(None, "turn", None, None), (0, "turn", None, None), (0, "turn", None, None), (0, "turn", X, None),
                 (1, "turn", None, None)],
    "aslant": [(k - 1 if k else None, "turn", axis, SAME) for k, axis in enumerate(
        ((0.0, 0.6, 0.8), Z, (0.6, 0.0, 0.8), (0.0, -0.8, 0.6), Z, (-0.28, 0.0, 0.96), Y))],
    "aslant beside others": [(None, "shift", X, SAME), (0, "turn", None, None), (1, "turn", None, None), (2, "rotation", X, None),
                             (3, "turn", None, None), (4, "turn", None, None), (5, "turn", None, None), (4, "turn", None, None),
                             (6, "shift", None, None), (8, "turn", None, None)],
    "hinges about coordinate axes": [(k - 1 if k else None, "turn", axis, SAME) for k, axis in enumerate((Z, Y, Y, X, Y, X))],
    "parallel": [(k - 1 if k else None, "turn", (0.0, -1.0, 0.0) if k == 2 else Y, SAME) for k in range(4)],
    "parallel, then others": [(None, "turn", Z, SAME), (0, "turn", X, SAME), (1, "turn", X, SAME), (2, "turn", None, SAME),
                              (2, "shift", None, SAME), (4, "turn", X, SAME), (5, "turn", None, None), (1, "rotation", X, None)],
    "sliders": [(None, "shift", X, SAME), (0, "turn", None, None), (1, "shift", None, None), (2, "turn", None, None),
                (3, "shift", Z, SAME)],
    "balls": [(None, "rotation", X, None), (0, "rotation", X, None), (1, "turn", None, None), (2, "rotation", X, None)],
    "floating": [(None, "shift", X, SAME), (0, "shift", Y, SAME), (1, "shift", Z, SAME), (2, "rotation", X, SAME),
                 (3, "turn", Y, SAME), (3, "turn", None, None)],
}


@pytest.mark.parametrize("name", TREES)
def test_accelerations_are_those_of_jacobians_in_the_world(name: str) -> None:
    random, at, joints = np.random.default_rng(3), 0, []
    for parent, kind, axis, R in TREES[name]:
        joints.append(joint(random, parent, kind, at, axis, R))
        at += len(joints[-1].coordinates)
    if name == "floating":
        joints[:3] = [replace(x, body=None) for x in joints[:3]]
    check(joints, at)


def test_a_hinge_that_time_moves_is_felt_by_the_one_before() -> None:
    random = np.random.default_rng(3)
    joints = [joint(random, k - 1 if k else None, "turn", k) for k in range(2)]
    joints.append(replace(joint(random, 1, "turn", 2), coordinates=(), slopes=()))
    check([*joints, joint(random, 2, "turn", 2)], 3)


@pytest.mark.parametrize("axes", [[X, Y, Z], [Y, Z, (0.6, 0.0, 0.8), Y], [(0.6, 0.0, 0.8), Y, X, (0.0, 0.6, 0.8)]])
def test_a_hinge_across_the_next_one_gives_way_to_five_numbers(axes: list[Any]) -> None:
    joints = chain(8, axes, SAME, (0.3, 0.2, 0.5), slender=True)
    tree, _ = solve(joints, 8, [0.0] * 8, GRAVITY)
    assert sum(told.a != 0.0 for told in tree.told) >= 2
    check(joints, 8, 1e-13)


def test_pivots_of_hinges_that_are_aslant() -> None:
    """Their product is the determinant of M."""
    random = np.random.default_rng(7)
    joints = [joint(random, k - 1 if k else None, "turn", k) for k in range(5)]
    tree, _ = solve(joints, 5, [0.0] * 5, GRAVITY)
    assert sum(crossing is not None for crossing in tree.crossings) >= 3
    inverse = [tree.solve(row, {}) for row in np.eye(5).tolist()]
    np.testing.assert_allclose(np.prod(tree.pivots) * np.linalg.det(inverse), 1.0, rtol=1e-12)
    np.testing.assert_allclose(tree.diagonal, np.diag(np.linalg.inv(inverse)), rtol=1e-12)


# -------------------------------------------------------------------- published numbers


def about_x(angle: float) -> list[list[float]]:
    c, s = round(float(np.cos(angle)), 15), float(np.sin(angle))
    return [[1.0, 0.0, 0.0], [0.0, c, -s], [0.0, s, c]]


def numbers(values: Sequence[str]) -> list[float]:
    return [float(eval(x, {"pi": np.pi})) for x in values]  # of the case's file: "pi/2"


def puma(case: dict[str, Any], q: Sequence[Any], v: Sequence[Any]) -> list[SpatialJoint]:
    data = case["parameters"]
    alpha, a, d, m = (numbers(data[name]) for name in ("alpha", "a", "d", "m"))
    joints: list[SpatialJoint] = []
    for k in range(6):
        J = np.diag(numbers(data["I"][k])).tolist()
        about_center = RigidInertia(m[k], (0.0, 0.0, 0.0), J).placed(SAME, numbers(data["r"][k]))
        R, origin = (about_x(alpha[k - 1]), (a[k - 1], 0.0, d[k - 1])) if k else (SAME, (0.0, 0.0, 0.0))
        body = about_center.placed(about_x(alpha[k]), (a[k], 0.0, d[k]))
        joints.append(SpatialJoint(k - 1 if k else None, "turn", R, origin, (k,), amount=q[k], motion=((v[k],), (0.0,)),
                                   body=body))
    return joints


CASE = yaml.safe_load((Path(__file__).parents[1] / "cases" / "puma560_forward_dynamics.yaml").read_text())


@pytest.mark.parametrize("name", CASE["reference"]["configurations"])
def test_puma_560(name: str) -> None:
    place = CASE["reference"]["configurations"][name]
    q, v, tau, expected = (numbers(place[x]) for x in ("q", "qd", "tau", "qdd_without_motor_inertia"))
    _, found = solve(puma(CASE, q, v), 6, tau, (0.0, 0.0, -9.81))
    assert np.abs(np.array(found) - expected).max() <= 1e-13 * np.abs(expected).max()


# -------------------------------------------------------------------- operations


class Written:
    """Symbols in place of the numbers of joints that are not 0, 1 or -1, with their values."""

    def __init__(self, keeps_axes: bool = False) -> None:
        self.keeps_axes = keeps_axes
        self.values: dict[Any, float] = {}
        self.moving: list[Any] = []

    def symbol(self, value: float, moves: bool = False) -> Any:
        if not moves and value in (0.0, 1.0, -1.0):
            return value
        found = symbol(f"x{len(self.values)}")
        self.values[found] = value
        self.moving += [found] if moves else []
        return found

    def joint(self, joint: SpatialJoint) -> SpatialJoint:
        vector, body = (lambda values: [self.symbol(x) for x in values]), joint.body
        if body is not None:
            J = [[0.0] * 3 for _ in range(3)]
            for i in range(3):
                for j in range(i, 3):
                    J[i][j] = J[j][i] = self.symbol(body.second_moment[i][j])
            body = RigidInertia(self.symbol(body.mass), vector(body.moment), J)
        moved: dict[str, Any] = {"amount": self.symbol(joint.amount, True)} if joint.kind != "rotation" else {
            "attitude": [[self.symbol(x, True) for x in row] for row in joint.attitude]}
        if not self.keeps_axes:
            moved |= {"R": [vector(row) for row in joint.R], "axis": vector(joint.axis)}
        return replace(joint, origin=vector(joint.origin), body=body,
                       motion=([self.symbol(x, True) for x in joint.motion[0]], joint.motion[1]), **moved)

    def values_of(self, expressions: Sequence[Any]) -> np.ndarray:
        function = ca.Function("f", [ca.vertcat(*self.values)], [ca.vertcat(*expressions)])
        return np.array(function(list(self.values.values()))).ravel()


def operations(joints: Sequence[SpatialJoint], size: int, keeps_axes: bool = False) -> int:
    """That depend on the state; what they give is checked as well."""
    written = Written(keeps_axes)
    symbolic = [written.joint(x) for x in joints]
    gravity = [written.symbol(x) for x in GRAVITY]
    _, found = solve(symbolic, size, [0.0] * size, gravity)
    expected = accelerations(joints, size, np.zeros(size), np.array(GRAVITY))
    assert np.abs(written.values_of(found) - expected).max() <= 1e-9 * np.abs(expected).max()
    return count_nodes([ca.vertcat(*found)], written.moving)


SLENDER = RigidInertia(1.1, (0.3, 0.0, 0.0), ((0.01, 0.0, 0.0), (0.0, 0.12, 0.0), (0.0, 0.0, 0.13)))


def chain(n: int, axes: Sequence[Any], R: Any, origin: Any = None, kind: str = "turn",
          slender: bool = False) -> list[SpatialJoint]:
    random, joints, width = np.random.default_rng(1), [], 3 if kind == "rotation" else 1
    for k in range(n):
        found = joint(random, k - 1 if k else None, kind, width * k, axes[k % len(axes)], R)
        if slender:
            found = replace(found, body=SLENDER)
        joints.append(replace(found, origin=origin or found.origin))
    return joints


AHEAD = (0.7, 0.0, 0.0)
COUNTED = {
    "general hinges": (lambda n: chain(n, [None], None), 392),
    "general hinges of known axes": (lambda n: chain(n, [None], None), 357),
    "hinges about y and z in turns": (lambda n: chain(n, [Y, Z], SAME, AHEAD, slender=True), 191),
    "hinges about x, y and z in turns": (lambda n: chain(n, [X, Y, Z], SAME, AHEAD, slender=True), 175),
    "hinges about z": (lambda n: chain(n, [Z], SAME, AHEAD, slender=True), 68),
    "balls": (lambda n: chain(n, [X], SAME, AHEAD, "rotation", slender=True), 550),
    "general balls": (lambda n: chain(n, [X], SAME, None, "rotation"), 550),
}


@pytest.mark.parametrize("name", COUNTED)
def test_operations_a_joint(name: str) -> None:
    make, most = COUNTED[name]
    width = 3 if "balls" in name else 1
    less, more = (operations(make(n), width * n, "known" in name) for n in (6, 12))
    assert more - less <= 6 * most


def test_long_chains_take_as_much_a_hinge() -> None:
    counts = [operations(chain(n, [None], None), n) for n in (9, 18, 27)]
    assert counts[2] - counts[1] == counts[1] - counts[0]


@pytest.mark.parametrize("axes", [[None], [(0.0, 0.6, 0.8)], [Y, Z]])
def test_long_chains_keep_their_digits(axes: list[Any]) -> None:
    """Of 27 hinges in symbols, whose directions follow from one link to the next: errors must not grow with each."""
    joints, written = chain(27, axes, None), Written()
    _, found = solve([written.joint(x) for x in joints], 27, [0.0] * 27, GRAVITY)
    expected = accelerations(joints, 27, np.zeros(27), np.array(GRAVITY))
    assert np.abs(written.values_of(found) - expected).max() <= 3e-12 * np.abs(expected).max()


@pytest.mark.parametrize("kind", ["turn", "shift", "rotation"])
def test_what_a_joint_does_not_feel_stands_on_its_parent(kind: str) -> None:
    random = np.random.default_rng(5)
    joints = [joint(random, None, "turn", 0), joint(random, 0, kind, 1, None)]
    body = lay_axes(joints)[0][1].body
    assert body is not None
    if kind == "shift":
        assert not np.any(body.second_moment) and body.mass > 0
    else:
        assert body.mass == 0.0 and (kind == "rotation" or (body.moment[2] == 0.0 and body.is_flat))
    check(joints, 1 + len(joints[1].coordinates))


def test_mass_that_has_come_far_stays_alone() -> None:
    """At the origin of every ninth link; all the rest that a hinge does not feel is handed on there, too."""
    joints = chain(27, [None], None)
    bodies = [link.body for link in lay_axes(joints)[0]]
    assert all(body is not None and body.is_flat and body.moment[2] == 0.0 for body in bodies)
    assert [k for k, body in enumerate(bodies) if body is not None and body.mass] == [0, 9, 18]
    check(joints, 27)
