"""Points held together in space, along the axes of a rod: the motion, reactions and account of formulas for any masses."""

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.model import Model
from lagrangia.run.formulas import Formulas

TOLD = ("turning.reaction", "rocking.reaction")


def rssr(crank: float, turning: float, rocking: float, end: str) -> str:
    return f"""
model Rssr
  World world(gravity = {{0, 2, -9.81}});
  Revolute turning(a = world, phi(start = {turning}, fixed = true), w(start = 3));
  Body crank(m = 1, I = {{0.001, 0.02, 0.02}}, center = shift(turning.b, {{0.15, 0, 0}}));
  Revolute rocking(a = shift(world, {{0.9, 0.5, 0.2}}), axis = {{0, 1, 0}}, phi(start = {rocking}));
  Body rocker(m = 1.5, I = {{0.001, 0.05, 0.05}}, center = shift(rocking.b, {{0.3, 0, 0}}));
  Spherical ball(a = shift(turning.b, {{{crank}, 0, 0}}));
  Body rod(m = 2, I = {{0.002, 0.2, 0.15}}, center = shift(ball.b, {{0.55, 0, 0}}));
  Frame far = shift(ball.b, {{1.1, 0, 0}}), near = shift(rocking.b, {{0.6, 0, 0}});
  output Length place[3] = rod.center.r;
  output Real held = dot(near.r - rod.center.r, cross({{0, 1, 0}}, near.r - rocking.b.r)) "0 where rod and rocker are in line";
equation
  {end};
end Rssr;
"""


@pytest.mark.parametrize(("crank", "turning", "rocking", "end"), [
    (0.3, 0.3, -1.6, "far.r = near.r"), (0.3, 0.3, 2.5, "near.r = far.r"),
    (0.58, 1.2, -1.6, "far.r = near.r"),  # passes places where rod and rocker are in line
])
def test_along_the_axes_of_a_rod(crank: float, turning: float, rocking: float, end: str) -> None:
    path = lag.loads(rssr(crank, turning, rocking, end)).path
    model, other = Model(path, outputs=TOLD), Model(path, outputs=TOLD, formulas=Formulas(for_any_mass=True))
    partition = model.compilation.motion.constrained.partition
    assert [len(points.rows) for points in partition.points] == [3] and {points.own for points in partition.points} == {"far"}
    at = np.linspace(0, 2, 9)
    run, known = model.simulate(at=at, tolerance=1e-11), other.simulate(at=at, tolerance=1e-11)
    assert run.statistics.energy_residual < 1e-9
    for name in ("turning.phi", "rocking.phi", *(f"{told}[{k}]" for told in ("place", *TOLD) for k in (1, 2, 3))):
        assert run[name] == pytest.approx(known[name], abs=1e-8 * max(1, np.abs(known[name]).max())), name
    assert (run["held"].min() * run["held"].max() < 0) == (crank == 0.58)

