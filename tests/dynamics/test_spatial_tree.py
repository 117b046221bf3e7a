"""Scenes in space along their trees: the same accelerations as by M and h, with forces on the bodies that they act on."""

from pathlib import Path

import casadi as ca
import numpy as np
import pytest

from lagrangia.compile.pipeline import Compilation, compile_file
from lagrangia.dynamics.along_tree import articulate
from lagrangia.dynamics.motion import mass_matrix, solve_dense
from lagrangia.dynamics.spatial_tree import SpatialBodies
from lagrangia.model import Model, loads

BODY = "m = 2, I = {{0.1, 0.01, 0.02}, {0.01, 0.2, 0.03}, {0.02, 0.03, 0.25}}"
HINGES = f"""
  World world(gravity = {{0.3, -0.2, -9.81}});
  Revolute j1(a = world), j2(a = shift(j1.b, {{0.2, 0, 0.4}}), axis = {{0, 1, 0}}), j3(a = elbow, axis = {{0.6, 0.7, 0.1}});
  Revolute j4(a = shift(j3.b, {{0.5, 0, 0}}), axis = {{0, 1, 0}}), j5(a = shift(j4.b, {{0.5, 0.2, 0}}), axis = {{0, -1, 0}});
  Prismatic slide(a = turn(shift(j2.b, {{0.6, 0, 0}}), 0.7), along = {{1, 0, 0.2}});
  Frame elbow = turn(shift(j2.b, {{0.6, 0, 0}}), 0.4, {{1, 0, 0}});
  Body b1(center = shift(j1.b, {{0.1, 0.05, 0.2}}), {BODY}), b2(center = shift(j2.b, {{0.3, 0, 0.01}}), {BODY});
  Body b3(center = shift(j3.b, {{0.1, 0.2, 0.3}}), {BODY}), b4(center = shift(j4.b, {{0.1, 0.02, 0.3}}), {BODY});
  Body b5(center = shift(j5.b, {{0.1, 0.02, 0.3}}), {BODY}), b6(center = slide.b, {BODY});
"""
LOADS = """
  Spring spring(k = 20, s_rel0 = 0.3, a = b3.center, b = b6.center);
  Damper damper(c = 0.2, a = b5.center, b = world);
energy
  work {0.3, 0.2, 0.1} on b2.center.r;
  work {0.1, 0.5, -0.2} on b4.center.attitude;
  dissipation 0.2*dot(b1.center.omega, b1.center.omega) + 0.1*slide.v^2;
"""
DRIVEN = f"""
  World world(gravity = {{0, 0, -9.81}});
  Frame stand = turn(shift(world, {{0, 0.1*sin(3*time), 0}}), 2*time + 0.3*time^2, {{1, 0, 0.5}});
  Universal u(a = shift(stand, {{0, 0, 0.3}}), axis_a = {{1, 0, 0}}, axis_b = {{0, 1, 0}});
  Cylindrical c(a = shift(u.b, {{0, 0.1, -0.7}}), axis = {{0, 1, 1}});
  Body b1(center = shift(u.b, {{0, 0.1, -0.5}}), {BODY}), b2(center = shift(c.b, {{0, 0.1, -0.5}}), {BODY});
  coordinate Length s(start = 0.2);
  PointMass bead(m = 0.7, center = shift(c.b, {{s, 0.3[1/m]*s^2, 0.1[m]*sin(s/0.5[m])}}));
  coordinate Angle phi;
  Frame geared = turn(shift(world, {{1, 0, 0}}), 2*phi);
  Body b4(center = shift(geared, {{0.2, 0, 0}}), {BODY});
"""
SCREWS = f"""
  World world(gravity = {{0.3, -0.2, -9.81}});
  Revolute j1(a = world, axis = {{0, 1, 0}});
  Screw s1(a = turn(shift(j1.b, {{0.2, 0, 0.4}}), 0.3, {{1, 0, 0}}), axis = {{0.3, -0.2, 0.5}}, pitch = 0.7);
  Screw s2(a = shift(s1.b, {{0.1, 0.2, 0}}), axis = {{0, 0, -1}}, pitch = -0.4);
  Revolute j2(a = shift(s2.b, {{0.1, 0, 0}})), j3(a = shift(s1.b, {{0, 0.1, 0}}), axis = {{0, 1, 1}});
  Body b1(center = shift(j1.b, {{0.1, 0.05, 0.2}}), {BODY}), b2(center = shift(s1.b, {{0.3, 0, 0.01}}), {BODY});
  Body b3(center = shift(s2.b, {{0.1, 0.2, 0.3}}), {BODY}), b4(center = shift(j2.b, {{0.1, 0.02, 0.3}}), {BODY});
  Body b5(center = shift(j3.b, {{0.1, 0.02, 0.3}}), {BODY});
"""
SCENES = {"hinges and sliders": HINGES, "screws": SCREWS, "loads": HINGES + LOADS, "moved by time, along a wire, geared": DRIVEN}


def compiled(folder: Path, text: str) -> Compilation:
    (folder / "scene.lag").write_text(f"model Scene\n{text}end Scene;\n", encoding="utf-8")
    return compile_file(folder / "scene.lag")


def numbers(expressions: list[ca.SX]) -> list[np.ndarray]:
    """At one general place, whatever they depend on."""
    symbols = ca.vertcat(*ca.symvar(ca.veccat(*expressions)))
    values = np.random.default_rng(0).uniform(0.2, 1, symbols.numel())
    return [np.array(x) for x in ca.Function("at", [symbols], expressions)(values)]


@pytest.mark.parametrize("name", SCENES)
def test_the_tree_moves_as_by_its_mass_matrix(name: str, tmp_path: Path) -> None:
    made = compiled(tmp_path, SCENES[name])
    motion, tree = made.motion, articulate(made.kinematics, made.motion.bodies)
    assert isinstance(tree, SpatialBodies) and motion.way == "tree"
    r = ca.SX(ca.DM(range(1, tree.size + 1)))
    h = ca.substitute(motion.h, made.kinematics.symbols.tau, ca.SX(1))
    dense = solve_dense(motion.momentum, -h, motion.v)
    along, dense, M, diagonal, solved = numbers([motion.acceleration, dense, mass_matrix(motion), tree.diagonal, tree.solve(r)])
    assert np.abs(along - dense).max() <= 1e-13 * np.abs(dense).max()
    assert np.abs(diagonal.ravel() - np.diag(M)).max() <= 1e-13 * np.abs(M).max()
    assert np.abs(M @ solved - np.arange(1, tree.size + 1)[:, None]).max() <= 1e-12


def test_weight_is_an_acceleration_of_the_world(tmp_path: Path) -> None:
    """For all bodies, or for none: a balloon that floats asks for forces."""
    made = compiled(tmp_path, HINGES)
    tree = articulate(made.kinematics, made.motion.bodies)
    assert isinstance(tree, SpatialBodies)
    field, others = tree.field(made.energies)
    assert len(field) == 3 and others is not None and not others.on_frames and not others.on_coordinates
    balloon = """
  Revolute j7(a = world, axis = {1, 0, 0});
  PointMass floats(m = 1, center = shift(j7.b, {0, 0, 1}));
energy
  potential -9.81[m/s2]*floats.m*floats.center.z;
"""
    made = compiled(tmp_path, HINGES + balloon)
    tree = articulate(made.kinematics, made.motion.bodies)
    assert isinstance(tree, SpatialBodies)
    field, others = tree.field(made.energies)
    assert tuple(field) == (0.0, 0.0, 0.0) and others is not None and "floats.center" in others.on_frames
    along, h, M = numbers([made.motion.acceleration, made.motion.h, mass_matrix(made.motion)])
    assert np.abs(M @ along + h).max() <= 1e-12 * np.abs(h).max()


def test_a_coordinate_that_turns_and_shifts_aslant_is_left_to_the_mass_matrix(tmp_path: Path) -> None:
    moved = "  coordinate Angle phi;\n  Frame b = turn(shift(world, {0.1[m]*phi, 0, 0.1[m]*phi}), phi, {1, 0, 0});\n"
    body = f"  Body body(center = shift(b, {{0.1, 0, 0}}), {BODY});\n"
    other = "  Revolute j(a = world, axis = {1, 0, 0});\n  Body other(center = j.b, m = 1, I = {1, 1, 1});\n"
    made = compiled(tmp_path, moved + body + other)
    assert articulate(made.kinematics, made.motion.bodies) is None


def test_a_screw_costs_about_what_a_hinge_does(tmp_path: Path) -> None:
    made = [compiled(tmp_path, text).scene.notes["acceleration_nodes"]
            for text in (SCREWS, SCREWS.replace("Screw", "Revolute").replace(", pitch = 0.7", "").replace(", pitch = -0.4", ""))]
    assert made[0] <= made[1] + 2 * 150


@pytest.mark.parametrize("n", [10, 20])
def test_operations_a_hinge_of_a_scene(n: int, tmp_path: Path) -> None:
    text = f"""
  Revolute joint[{n}](each axis = {{0.3, 0.5, 0.8}});
  Body link[{n}](each m = 0.1, each I = {{{{0.01, 0.001, 0.002}}, {{0.001, 0.012, 0.003}}, {{0.002, 0.003, 0.014}}}});
equation
  joint[1].a = world;
  for i in 1:{n} loop
    link[i].center = shift(joint[i].b, {{0.05, 0.01, 0.02}});
  end for;
  for i in 2:{n} loop
    joint[i].a = turn(shift(joint[i-1].b, {{0.1, 0.03, 0.05}}), 0.7, {{1, 2, 0.5}});
  end for;
"""
    made = compiled(tmp_path, text)
    assert made.motion.way == "tree" and made.scene.notes["acceleration_nodes"] <= 370 * n - 500


def test_rates_of_attitudes_feel_their_dampers(tmp_path: Path) -> None:
    text = f"""
  Spherical s1(a = world), s2(a = shift(s1.b, {{0.5, 0.1, 0}}));
  Body b1(center = shift(s1.b, {{0.2, 0.1, 0}}), {BODY}), b2(center = shift(s2.b, {{0.2, 0.1, 0}}), {BODY});
energy
  dissipation 0.3*dot(s2.w, s2.w);
"""
    made = compiled(tmp_path, text)
    parts = made.kinematics.unturned([made.motion.acceleration, made.motion.h, mass_matrix(made.motion)])
    given = [(s, ca.SX(0.1 + 0.01 * int(name[-4]) * int(name[-2]))) for s in ca.symvar(ca.veccat(*parts))
             if (name := str(s)).endswith("]") and ".I[" in name]  # symmetric
    parts = ca.substitute(parts, [s for s, _ in given], [x for _, x in given])
    along, h, M = numbers(parts)
    assert made.motion.way == "tree" and np.abs(M @ along + h).max() <= 1e-13 * np.abs(h).max()


def test_axes_in_numbers_are_compiled_in_and_can_be_set() -> None:
    """With other axes the scene runs as with these in its text, by formulas that hold for any."""
    def chain(axis: str) -> Model:
        text = "World world(gravity = {0.3, -0.2, -9.81});"
        for k, before in enumerate(("world", "j0.b", "j1.b")):
            text += f"""
              Revolute j{k}(a = turn(shift({before}, {{0.3, 0.1, -0.2}}), 0.7, {{1, 2, 0.5}}), axis = {axis}, phi(start = {k}));
              Body b{k}({BODY}, center = shift(j{k}.b, {{0.1, 0.05, 0.2}}));"""
        return loads(f"model M {text} end M;")

    told, other = chain("{0.6, 0.7, 0.1}"), "{-0.2, 0.5, 0.9}"
    given = {f"j{k}.axis[{i}]": x for k in range(3) for i, x in enumerate([-0.2, 0.5, 0.9], 1)}
    run = told.simulate(at=[0.3], tolerance=1e-10, parameters=given)
    known = chain(other).simulate(at=[0.3], tolerance=1e-10)
    assert all(abs(run[f"j{k}.phi"][-1] - known[f"j{k}.phi"][-1]) < 1e-8 for k in range(3))
    assert told.scene.notes["acceleration_nodes"] < told.general.scene.notes["acceleration_nodes"]
