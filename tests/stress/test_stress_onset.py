"""Motion that sets in smoothly from exact rest: nothing has a size at first, and loads begin below their own rounding."""

import math
from collections.abc import Callable
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Scene = Callable[[str], lag.Model]
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"

PULSE = """model Pulse "A block at rest is pushed by a Gaussian pulse, and rests on nothing"
  parameter Time w = 0.1;
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, along = {1, 0});
  AppliedForce f(at = b.center, force = {exp(-((time - 5)/w)^2)/w*1[N.s], 0});
  annotation(experiment(StopTime = 10));
end Pulse;"""
HEAVILY_DAMPED = """model HeavilyDamped "A gram on a heavy damper and a hardening spring, pushed by 1 - cos from t0 on"
  World world(gravity = {0, 0});
  parameter Damping c = 1e4; parameter Time t0 = 0;
  Block w(m = 1e-3, base = world, along = {1, 0});
  Damper d(c = c, rate = der(w.s)); DuffingSpring s(k = 1000, k3 = 10, stretch = w.s);
  AppliedForce f(at = w.center, force = {10*(if time < t0 then 0 else 1 - cos(20*(time - t0))), 0});
  annotation(experiment(StopTime = 1));
end HeavilyDamped;"""


@pytest.mark.parametrize("w", [0.05, 0.1, 0.2])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-9])
def test_a_pulse_out_of_nothing(scene: Scene, w: float, tolerance: float) -> None:
    """It begins at e^-10000, and in between with numbers that have lost their digits: 1e-310."""
    run = scene(PULSE).simulate(parameters={"w": w}, tolerance=tolerance, at=[0, 5, 10], max_steps=400)
    assert run["b.s"][-1] == pytest.approx(5 * math.sqrt(math.pi), rel=10 * tolerance)
    assert run["der(b.s)"][-1] == pytest.approx(math.sqrt(math.pi), rel=10 * tolerance)


@pytest.mark.parametrize("c", [1e3, 1e5])
@pytest.mark.parametrize("t0", [0.0, 0.5])
def test_a_stiff_scene_that_is_pushed_gently(scene: Scene, c: float, t0: float) -> None:
    """Explicit steps end anywhere at first, which tells nothing about the motion; implicit ones need few."""
    model = scene(HEAVILY_DAMPED)
    exact = model.simulate(parameters={"c": c, "t0": t0}, solver="implicit", tolerance=1e-11, max_steps=5000)
    size = abs(exact["w.s"]).max()
    for solver in ("auto", "implicit"):
        for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
            run = model.simulate(parameters={"c": c, "t0": t0}, solver=solver, tolerance=tolerance, max_steps=5000)
            assert abs(run["w.s"] - exact["w.s"]).max() < max(10 * tolerance, 1e-11) * size


@pytest.mark.parametrize("tolerance", [1e-3, 1e-8, 1e-10])
@pytest.mark.parametrize("m2", [1e-3, 1e-6])
def test_a_wheel_of_a_gram_on_a_road_that_begins_to_rise(m2: float, tolerance: float) -> None:
    model = lag.load(EXAMPLES / "quarter_car.lag")
    auto, implicit = (model.simulate(parameters={"m2": m2}, solver=solver, tolerance=tolerance, at=[0.4, 0.7, 1], max_steps=2000)
                      for solver in ("auto", "implicit"))
    heights = auto["wheel.s"], implicit["wheel.s"]
    assert heights[0] == pytest.approx(heights[1], abs=max(10 * tolerance, 1e-12) * abs(heights[1]).max())
