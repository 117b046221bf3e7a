"""Taylor series of motions with attitudes, beside other methods."""

from pathlib import Path

import numpy as np
import pytest

from lagrangia.model import Model
from lagrangia.native.build import find_compiler
from lagrangia.run.runtime import Solver
from whole.test_space_cases import FOLDER, scene

DRIVEN = """\
model Driven "A top that is pushed, sampled and damped, beside a ball that bounces"
  World world(gravity = {0, 0, -9.81});
  input Force F = 0;
  Force u;
  Spherical tip(a = world, S(start = angles("zxz", 0, 0.5, 0)), w(start = {0.3, 0.1, 30}));
  Body top(m = 0.5, I = {0.0021, 0.0025, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
  Prismatic down(a = world, along = {0, 0, 1}, s(start = 1));
  PointMass ball(m = 1, center = down.b);
  energy work -0.0004[N.m.s]*tip.w on top.center.attitude;
  energy work {u, F, 0.3[N]*sin(3[rad/s]*time)} on top.center.r;
equation
  when down.s < 0 then
    reinit(down.v, -0.5*down.v);
  end when;
  when sample(0, 0.4) then
    u = top.center.x*1[N/m];
  end when;
end Driven;
"""
SPUN = """\
model Spun "A body that a torque sets spinning about an axis aslant"
  parameter AngularVelocity w = 0;
  parameter Torque M = 0;
  World world(gravity = {0, 0, 0});
  Body body(m = 1, I = {2, 2, 2}, center(omega(start = {0.6*w, 0, 0.8*w})));
  energy work {0.6*M, 0, 0.8*M} on body.center.attitude;
end Spun;
"""


def told(model: Model, **more: object) -> np.ndarray:
    """All columns that say something by themselves."""
    run = model.simulate(**more)
    return np.array([run[name] for name in run.names if name not in model.scene.turned])


def test_series_go_on_behind_events(tmp_path: Path) -> None:
    """Dense rows, contacts, samples, corners of inputs and the account of energy."""
    (tmp_path / "driven.lag").write_text(DRIVEN)
    model = Model(tmp_path / "driven.lag")
    asked = {"at": np.linspace(0, 1.5, 40), "tolerance": 1e-12, "inputs": ([0, 0.5, 1, 3], {"F": [0, 1, -1, 2]})}
    assert told(model, solver="taylor", **asked) == pytest.approx(told(model, solver="erk", **asked), abs=1e-10)
    run = model.simulate(solver="taylor", **asked)
    assert run.statistics.steps_by[Solver.TAYLOR] > 2 * run.statistics.steps_by[Solver.ERK], "which takes those to events"
    assert run.statistics.energy_residual < 1e-12 * run.statistics.energy_scale * run.statistics.steps


@pytest.mark.parametrize(("w", "torque"), [(50, 0), (0, 100)])
def test_no_step_turns_farther_than_its_positions_tell(tmp_path: Path, w: float, torque: float) -> None:
    """Series of what spins evenly would reach farther than a turn."""
    (tmp_path / "spun.lag").write_text(SPUN)
    model = Model(tmp_path / "spun.lag")
    run = model.simulate(at=[0, 2], tolerance=1e-3, solver="taylor", parameters={"w": w, "M": torque})
    angle = 2 * w + torque / 2 * 2**2 / 2
    found = [run[f"body.center.S[{k}]"][-1] for k in range(1, 5)]
    assert found == pytest.approx([np.cos(angle / 2), 0.6 * np.sin(angle / 2), 0, 0.8 * np.sin(angle / 2)], abs=1e-4)
    assert run.statistics.steps >= angle / 5


@pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
def test_tapes_of_attitudes_have_the_digits_of_native_code() -> None:
    native = Model(FOLDER / "cases.lag", model="HeavyTop")
    native.native = True
    interpreted, asked = scene("HeavyTop"), {"stop": 0.5, "tolerance": 1e-9, "solver": "taylor"}
    interpreted.native = False
    assert np.array_equal(told(native, **asked), told(interpreted, **asked))
