"""A spring in a row with dry friction (Jenkins element), alone and several beside each other (Iwan), against closed forms."""

from pathlib import Path

import fmpy
import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import KINDS, unpacked

FREE = """model Free "a mass that is thrown against one"
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, s(start = 0), v(start = 5));
  JenkinsSpring j(k = 100, F = 20, stretch = b.s);
  annotation(experiment(StopTime = 2, Tolerance = 1e-8));
end Free;"""
DRIVEN = """model Driven "Iwan's model, whose stretch is given"
  World world(gravity = {0, 0});
  Prismatic p(a = world);  Block b(m = 1, base = p.b);
  JenkinsSpring j[3](each k = 25, F = {1, 2, 3}, each stretch = p.s);
equation
  p.s = 0.1[m]*sin(2[rad/s]*time) + 0.1[m]*sin(5[rad/s]*time);
end Driven;"""
SHAKEN = """model Slips "an element of a user's own, whose slip is a state"
  parameter Stiffness k;  parameter Force F;  Length x, z(start = 0);
  Force f = k*(x - z);  Velocity v = der(x);
equation
  der(z) = if f >= F and v > 0 or f <= -F and v < 0 then v else 0;
energy
  work -f on x;
end Slips;
model Shaken "a mass between four of them"
  World world(gravity = {0, 0});
  Block block(m = 1, base = world);  Spring s(k = 1, stretch = block.s);
  Slips e[4](each k = 1, F = {0.02, 0.04, 0.06, 0.08}, each x = block.s);
  AppliedForce P(at = block.center, force = {0.1*sin(2*time) + 0.1*sin(5*time), 0});
end Shaken;"""
W, LIMIT, A = 10.0, 0.2, 20.0  # angular frequency while it sticks, stretch until it slips, acceleration while it does


def thrown(t: float, x: float = 0.0, v: float = 5.0, slip: float = 0.0) -> float:
    """Where the mass of Free is: it swings about what has slipped, and brakes while it slips."""
    while True:
        u = x - slip
        size, phase = np.hypot(u, v / W), np.arctan2(u, v / W)
        if size <= LIMIT * (1 + 1e-12):
            return slip + size * np.sin(W * t + phase)
        first = np.arcsin(LIMIT / size)
        angle, sign = min(((sign * first - phase + 1e-12) % (2 * np.pi), sign) for sign in (1, -1))
        if t < angle / W:
            return slip + size * np.sin(W * t + phase)
        t, x, v = t - angle / W, slip + sign * LIMIT, size * W * np.cos(sign * first)
        if angle > np.pi or v * sign < 0:
            v = sign * abs(v)
        if t < abs(v) / A:
            return x + v * t - sign * A * t * t / 2
        t, x, v = t - abs(v) / A, x + sign * v * v / (2 * A), 0.0
        slip = x - sign * LIMIT


@pytest.mark.parametrize("solver", ["auto", "erk", "erk9", "pirk", "taylor", "implicit", "adams"])
def test_a_mass_slips_until_it_swings(solver: str) -> None:
    at = np.linspace(0, 2, 41)
    run = lag.loads(FREE).simulate(at=at, solver=solver)
    assert np.array(run["b.s"]) == pytest.approx([thrown(t) for t in at], abs=1e-8)
    assert np.abs(run.energy.residual).max() < 1e-6


def test_it_begins_within_its_limit() -> None:
    """What is stretched too far at the start has slipped."""
    at = np.linspace(0, 1, 21)
    run = lag.loads(FREE.replace("s(start = 0), v(start = 5)", "s(start = 1), v(start = 3)")).simulate(at=at)
    assert run["j.elastic"][0] == pytest.approx(0.2, abs=1e-12)
    assert np.array(run["b.s"]) == pytest.approx([thrown(t, 1.0, 3.0, 0.8) for t in at], abs=1e-8)


@pytest.mark.parametrize("solver", ["auto", "erk9", "implicit"])
def test_several_remember_where_they_turned(solver: str) -> None:
    """Each is the play operator: what is elastic stays between its limits."""
    times = np.linspace(0, 6, 120_001)
    stretch = 0.1 * np.sin(2 * times) + 0.1 * np.sin(5 * times)
    run = lag.loads(DRIVEN).simulate(at=times[::3000], solver=solver, tolerance=1e-8)
    for n, limit in enumerate((0.04, 0.08, 0.12), start=1):
        elastic, found = 0.0, [0.0]
        for change in np.diff(stretch):
            elastic = min(max(elastic + change, -limit), limit)
            found.append(elastic)
        assert np.array(run[f"j[{n}].elastic"]) == pytest.approx(found[::3000], abs=1e-8)


@pytest.mark.parametrize("solver", ["erk", "pirk", "implicit", "adams"])
def test_what_slips_stays_beside_the_motion(solver: str) -> None:
    """Rounding of forces at their limits does not end slips: implicit was 160 tolerances off after 84 events for 26."""
    at, names = np.linspace(0, 10, 21), ["block.s", *(f"e[{i}].z" for i in range(1, 5))]
    model = lag.loads(SHAKEN)
    right, run = (model.simulate(at=at, solver=name, tolerance=1e-10) for name in ("taylor", solver))
    assert run.statistics.events <= 28
    for name in names:
        assert np.array(run[name]) == pytest.approx(np.array(right[name]), abs=1e-11)


def test_its_loop_is_masings() -> None:
    """At the stretch X cos(w t) each takes 4 F (X - F/k) in a round."""
    model = lag.loads(DRIVEN.replace("0.1[m]*sin(2[rad/s]*time) + 0.1[m]*sin(5[rad/s]*time)", "0.3[m]*cos(1[rad/s]*time)")
                      .replace("equation", "Energy lost(start = 0);\nequation\n der(lost) = sum(j.loss);"))
    run = model.simulate(at=[2 * np.pi, 4 * np.pi, 6 * np.pi], tolerance=1e-10)
    assert np.diff(run["lost"]) == pytest.approx(sum(4 * F * (0.3 - F / 25) for F in (1, 2, 3)) * np.ones(2), abs=1e-7)


@pytest.mark.parametrize("kind", KINDS)
def test_fmus_slip_as_runs_do(kind: str, tmp_path: Path) -> None:
    (tmp_path / "scene.lag").write_text(FREE)
    run = fmpy.simulate_fmu(str(unpacked(tmp_path / "scene.lag", "3")), fmi_type=kind, stop_time=2, step_size=0.05,
                            relative_tolerance=1e-9, output=["b.s"], output_interval=0.05)
    assert np.abs(run["b.s"] - [thrown(t) for t in run["time"]]).max() < (1e-7 if kind == "CoSimulation" else 1e-4)


def test_a_place_between_spring_and_friction_says_what_to_write() -> None:
    scene = """model M Prismatic x(a = world), n(a = world);  PointMass m(m = 1, center = x.b);
      Spring k(k = 100, stretch = x.s - n.s);  DryFriction f(F = 20, rate = n.v); end M;"""
    with pytest.raises(lag.LagError, match="JenkinsSpring"):
        assert lag.loads(scene).scene
