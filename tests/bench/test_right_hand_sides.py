"""`lag bench --rhs`: the accelerations of trees in space beside those of peers; those not installed are skipped with a word."""

import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.bench import tree_peers
from lagrangia.bench.clock import state
from lagrangia.bench.right_hand_sides import loads_of
from lagrangia.command.cli import main
from lagrangia.dynamics.spatial_tree import articulate_in_space

ARM = """model Arm
  World world(gravity = {0, 0, -9.81});
  Revolute waist(a = world), shoulder(a = waist.b, axis = {0, 1, 0});
  Prismatic reach(a = shoulder.b, along = {1, 0.2, 0});
  Body upper(center = shift(waist.b, {0, 0, 0.3}), m = 1, I = {0.1, 0.12, 0.14});
  Body fore(center = shift(shoulder.b, {0.1, 0, 0}), m = 1, I = {0.1, 0.12, 0.14});
  Body hand(center = reach.b, m = 1, I = {{0.1, 0.01, 0}, {0.01, 0.12, 0}, {0, 0, 0.14}});
  Spherical wrist(a = shift(reach.b, {0.1, 0.02, 0}));
  Body tool(center = shift(wrist.b, {0.05, 0, 0.1}), m = 0.5, I = {0.01, 0.012, 0.014});
  Revolute blade(a = wrist.b, axis = {0.6, 0, 0.8});
  Body tip(center = shift(blade.b, {0.05, 0, 0.1}), m = 0.5, I = {0.01, 0.012, 0.014});
end Arm;
"""


@pytest.mark.parametrize("largest", [200, 6])
def test_a_line_for_each(largest: int, tmp_path: Path, capsys: pytest.CaptureFixture[str],
                         monkeypatch: pytest.MonkeyPatch) -> None:
    """Also of trees for which Pinocchio is not given room for all that it could work out: of 1 000 hinges that takes 32 GB."""
    monkeypatch.setattr(tree_peers, "_LARGEST_WHOLE", largest)
    (tmp_path / "arm.lag").write_text(ARM, encoding="utf-8")
    assert main(["bench", str(tmp_path / "arm.lag"), "--rhs"]) == 0
    told = capsys.readouterr().out
    assert "Arm: 7 coordinates" in told and " operations" in told
    for peer, package in (("pinocchio", "pin"), ("mujoco", "mujoco")):
        line = next(line for line in told.splitlines() if peer in line)
        assert f"pip install {package}" in line or float(line.split()[5]) < 1e-13


LOADS = """
  Spring spring(a = world, b = tool.center, k = 30, s_rel0 = 0.1);
  TorsionDamper damper(c = 0.4, rate = shoulder.w);
  AppliedForce push(at = tip.center, force = {3[N]*cos(5[rad/s]*time), 2, -1});
  AppliedTorque twist(on = tool.center, torque = {0.1, 0.2, 0.3});
  TorsionSpring hold(a = wrist.a, b = wrist.b, k = 3);
energy
  dissipation 3*waist.w^2;
  work 2[N.m] on waist.phi;
end Arm;
"""


def test_peers_are_given_the_loads() -> None:
    """Q = M (a - a0), with the accelerations a0 of the same arm without loads."""
    arm = ARM.replace("Spherical wrist(", "Revolute wrist(axis = {1, 0, 0}, ")
    model, bare = lag.loads(arm.replace("end Arm;", LOADS)), lag.loads(arm)
    made, inputs = model.compilation, state(model.scene)
    tree = articulate_in_space(made.kinematics, made.motion.bodies)
    assert tree is not None
    forces = tree.field(made.energies)[1]
    assert forces is not None
    t, q, v = inputs[0][0], inputs[1][: model.scene.n], inputs[2][: model.scene.n]
    given = [[t, q, v, 0, m.parameter_values()] for m in (model, bare)]
    a, a0 = (np.asarray(m.functions()["rhs"](*x)).ravel() for m, x in zip((model, bare), given, strict=True))
    M = np.asarray(bare.functions()["M"](*given[1]))
    np.testing.assert_allclose(loads_of(made, forces, inputs), M @ (a - a0), rtol=0, atol=1e-12)


def test_what_a_peer_refuses_is_skipped(monkeypatch: pytest.MonkeyPatch) -> None:
    class Spec:
        def compile(self) -> None:
            raise ValueError("Error: mass and inertia\nof body 3")

    monkeypatch.setitem(sys.modules, "mujoco", ModuleType("mujoco"))
    monkeypatch.setattr(tree_peers, "_mujoco_spec", lambda tree: Spec())
    nothing = np.zeros(0)
    with pytest.raises(tree_peers.Unfit, match=r"it refuses the model: Error: mass and inertia$"):
        tree_peers._mujoco(tree_peers.Tree([], 0, nothing, nothing, nothing, nothing))


def test_what_is_no_tree_in_space_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (tmp_path / "pin.lag").write_text("model Pin Revolute pin(a = world); Bar bar(m = 1, L = 1, a = pin.b); end Pin;")
    assert main(["bench", str(tmp_path / "pin.lag"), "--rhs"]) == 1
    assert "only trees in space" in capsys.readouterr().err
