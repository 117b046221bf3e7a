"""Forces stay on the bodies they act on when accelerations are solved for along the tree."""

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.rounding import needs_longer_numbers, noise
from lagrangia.dynamics.elimination import articulate
from lagrangia.dynamics.motion import solve_dense

Scene = Callable[[str], lag.Model]
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"

ALL_KINDS = """model AllKinds "energies of frames, of coordinates and of both, on an arm that time turns"
  parameter Stiffness stiff = 3;
  parameter Damping c = 2; input Force push;
  Frame arm = turn(world, 2*time);
  Prismatic rail(a = arm); Block sled(m = 2, base = rail.b, along = {0.6, 0.8});
  Revolute elbow(a = sled.center); Bar rod(m = 1, L = 0.7, a = elbow.b);
  Planar loose(a = world); Disc wheel(m = 3, r = 0.2, center = loose.b);
  Spring s1(a = rod.b, b = wheel.center, k = 50), s2(k = 20, stretch = 0.3[m]*elbow.phi + sled.s);
  TorsionSpring t1(a = arm, b = rod.a, k = 4);
  Damper d1(a = rod.b, b = shift(arm, {1, 0}), c = 0.4), d2(c = 0.1, rate = der(sled.s)*cos(elbow.phi));
  TorsionDamper d3(a = wheel.center, b = rod.b, c = 0.3);
  AppliedForce f1(at = rod.b, force = {push, if rail.b.phi > 1 then 5 else 1});
  TorquePair f2(a = wheel.center, b = rod.b, torque = if rod.b.y > 0.1 then 2 else floor(2*time) + 3[N]*rail.s);
  ForcePair f3(a = world, b = wheel.center, force = table(time, {0, 1, 2}, {1, 3, 2}));
energy
  potential if rail.s > 0.2 then stiff*rail.s^2 else stiff*rail.s^2/2;
  potential stiff*cos(rod.b.phi)*wheel.center.x*sled.s;
  dissipation c*(dot(rod.b.v, rod.b.v)*(1 + sin(elbow.phi)) + (0.3[m]*wheel.center.w)^2);
  annotation(experiment(StopTime = 2));
end AllKinds;"""


def state(n: int, inputs: int, seed: int, size: float) -> list[np.ndarray]:
    random = np.random.default_rng(seed)
    q, v = random.uniform(-size, size, n), random.uniform(-5 * size, 5 * size, n)
    return [np.array([0.7]), q, v, random.uniform(-1, 1, inputs)]


def test_they_do_what_generalised_forces_do(scene: Scene) -> None:
    model = scene(ALL_KINDS)
    compilation = model.compilation
    motion, kinematics = compilation.motion, compilation.kinematics
    modes = ca.vertcat(*[mode.symbol for mode in kinematics.algebra.modes])
    tree = articulate(kinematics, motion.bodies)
    assert tree is not None
    found = tree.accelerate(compilation.energies)
    assert len(kinematics.algebra.modes) == modes.numel() > 2
    wanted = solve_dense(motion.momentum, -motion.h, motion.v)
    arguments = [motion.t, motion.q, motion.v, motion.u, motion.p, kinematics.symbols.tau, modes]
    both = ca.Function("both", arguments, [found, wanted])
    for seed in range(20):
        values = state(motion.v.numel(), 1, seed, 1.0)
        mine, other = (np.array(x).ravel() for x in both(*values, model.parameter_values(), 1, np.arange(modes.numel())))
        assert mine == pytest.approx(other, rel=1e-11, abs=1e-11 * np.abs(other).max())


@needs_longer_numbers
@pytest.mark.parametrize("n", [20, 60])
def test_rounding_stays_that_of_one_body(n: int) -> None:
    """Sums over all links behind a hinge lose three digits here."""
    model = lag.load(EXAMPLES / "chain.lag", n=n)
    assert noise(model, [state(n, 0, seed, 0.5) for seed in range(10)]) < 1e-14
