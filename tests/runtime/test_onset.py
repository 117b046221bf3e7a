"""Motion that sets in out of rest, and rest that is disturbed by rounding alone: neither is resolved against noise."""

import math
from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]

SWITCHED_ON = """model SwitchedOn "A force that begins at the square root of 2 s, by a condition that is not linear in time"
  World world(gravity = {0, 0});
  Block b(m = 2, base = world);
  SpringDamper k(k = 50, c = 0.8, stretch = b.s);
  AppliedForce f(at = b.center, force = {if time^2 < 2 then 0 else 2, 0});
end SwitchedOn;"""
KERB = """model Kerb "A symmetric car falls, its front wheel meets a kerb: its pitch sets in behind the corner of a force"
  Prismatic up(a = world, along = {0, 1}, s(start = 0.5));
  Revolute  pitch(a = up.b);
  Bar       body(m = 1000, L = 2.6, center = pitch.b);
  Prismatic front(a = world, along = {0, 1}, s(start = 0.1)), rear(a = world, along = {0, 1}, s(start = 0.1));
  PointMass f(m = 40, center = front.b), r(m = 40, center = rear.b);
  Spring    fs(k = 3e4, stretch = body.b.y - front.s - 0.5), rs(k = 3e4, stretch = body.a.y - rear.s - 0.5);
  Length    df = max(0.05 - front.s, 0[m]), dr = max(-rear.s, 0[m]);
  GeneralSpring ft(stretch = df, V = 2e5[N/m]*df^2/2), rt(stretch = dr, V = 2e5[N/m]*dr^2/2);
end Kerb;"""
HANGING = """model Hanging "A double pendulum at rest, but for rounding of -90 degrees"
  Revolute upper(a = world, phi(start = -90[deg])), lower(a = one.b);
  Bar      one(m = 1, L = 1, a = upper.b), two(m = 1, L = 1, a = lower.b);
end Hanging;"""
NET = """model Net "Damped masses hung on each other by springs, at rest"
  parameter Integer n = 10;
  PointMass p[n](each m = 1, center(x(each start = 0), y(start = {-i - sum(9.81*(n + 1 - j)/1e5 for j in 1:i) for i in 1:n})));
  SpringDamper s[n](each k = 1e5, each c = 100, each s_rel0 = 1);
equation
  connect(s[1].a, world);
  for i in 1:n loop connect(s[i].b, p[i].center); end for;
  for i in 2:n loop connect(s[i].a, p[i-1].center); end for;
end Net;"""


@pytest.mark.parametrize("solver", ["auto", "erk5"])
@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-8, 1e-10, 1e-11])
def test_a_jump_nobody_announced_sets_a_mass_in_motion(scene: Write, solver: str, tolerance: float) -> None:
    run = scene(SWITCHED_ON).simulate(stop=5, solver=solver, tolerance=tolerance)
    damping, ratio = 0.8 / 4, np.sqrt(25 - 0.04)
    late = 5 - np.sqrt(2)
    there = 0.04 * (1 - np.exp(-damping * late) * (np.cos(ratio * late) + damping / ratio * np.sin(ratio * late)))
    assert run["b.s"][-1] == pytest.approx(there, abs=0.2 * tolerance)


@pytest.mark.parametrize("solver", ["auto", "erk5"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-9, 1e-10])
def test_what_sets_in_behind_a_corner_is_not_resolved_against_rounding(scene: Write, solver: str, tolerance: float) -> None:
    """Steps ended with "no step is small enough", or 52 000 were made."""
    run = scene(KERB).simulate(stop=2, solver=solver, tolerance=tolerance)
    assert run["pitch.phi"][-1] == pytest.approx(0.0111212840, abs=max(tolerance, 2e-9))
    assert run.statistics.steps < 12_000


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
@pytest.mark.parametrize(("text", "most"), [(HANGING, 500), (NET, 500)])
def test_rest_is_not_resolved_against_rounding(scene: Write, text: str, most: int, tolerance: float) -> None:
    """100 000 steps, where all motion was rounding."""
    run = scene(text).simulate(stop=20, tolerance=tolerance)
    assert run.statistics.steps < most
    np.testing.assert_allclose(run.rows[-1][1:], run.rows[0][1:], atol=1e-11)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_series_stand_rounding_about_an_equilibrium(scene: Write, tolerance: float) -> None:
    """A million series were rejected, each compared with rates of rounding."""
    run = scene(HANGING.replace("-90", "90")).simulate(stop=3, tolerance=tolerance, solver="taylor")
    assert run.statistics.rejected < 100


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "erk9", "pirk", "adams", "implicit"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-6, 1e-12])
def test_what_symmetry_keeps_at_rest_is_noise(scene: Write, solver: str, tolerance: float) -> None:
    """The block falls straight through the hinge, and the force has no moment about it but by rounding: once 16 million steps."""
    run = scene("""model M Revolute h(a = world); Bar bar(m = 0.75, L = 1.3, center = h.b);
      Block b(m = 1, base = bar.center, along = {0, 1}, s(start = 0.35));
      ForcePair f(a = shift(b.center, {0.4, -0.2}), b = bar.center, force = 1.76[N/s]*time); end M;""").simulate(
          stop=1, solver=solver, tolerance=tolerance, max_steps=2_000)
    assert np.abs(run["h.phi"]).max() < 1e-12


@pytest.mark.parametrize("solver", ["auto", "erk", "erk9", "implicit"])
def test_what_falls_freely_does_not_move_in_itself(scene: Write, solver: str) -> None:
    """Sprung parts of a body that falls: their accelerations are 0 but for rounding of what is computed of parameters: once
    627 000 steps."""
    run = scene("""model Falling
      World world(gravity = {0, 0, -9.81});
      Frame body, f[6];
      Free root(a = world, b = body, z(start = 1));
      Body trunk(center = shift(body, {0.01, 0.02, 0.03}), m = 8, I = {0.1, 0.12, 0.13});
      Revolute h[6](each axis = {1, 0.2, 0.5}, b = f, a = {shift(body, {0.1, 0.2, 0.3}), f[1], shift(f[2], {0, 0.3, 0.1}),
        shift(body, {0.1, -0.2, 0}), shift(f[4], {0, 0, -0.3}), shift(f[5], {0, 0.1, -0.3})});
      Body b[6](center = {shift(f[i], {0.02*i, 0.1, -0.1}) for i in 1:6}, each m = 1, each I = {0.002, 0.003, 0.004});
    energy
      for i in 1:6 loop
        kinetic 0.01*h[i].w^2/2; potential 20*h[i].phi^2/2; dissipation 5*h[i].w^2/2;
      end for;
    end Falling;""").simulate(stop=0.5, solver=solver, max_steps=2_000)
    assert max(np.abs(run[f"h[{i}].phi"]).max() for i in range(1, 7)) < 1e-12
    assert run["root.z"][-1] == pytest.approx(1 - 9.81 * 0.5**2 / 2, abs=1e-14)


@pytest.mark.parametrize("solver", ["erk9", "implicit"])
def test_a_small_motion_is_none(scene: Write, solver: str) -> None:
    """An oscillation of 1e-15 rad beside a mass that falls 5 m is as exact as one of 1 rad."""
    run = scene("""model M Revolute h(a = world, phi(start = 1e-15)); Body disc(m = 1, I = 1, center = h.b);
      Block b(m = 1, base = world, along = {0, 1}); energy potential 4.5[J]*h.phi^2 + 0.1[J]*sin(h.phi)^4; end M;""").simulate(
          at=[0, 10, 100], solver=solver, tolerance=1e-9)
    np.testing.assert_allclose(run["h.phi"], 1e-15 * np.cos(3 * run.time), atol=1e-23)


@pytest.mark.parametrize("begins", [1.0, 1e3, 1e6])
def test_what_is_torn_off_late_begins_with_rounding_of_time(scene: Write, begins: float) -> None:
    """Drawn by 4 N/s, it holds for 2.5 s, and then a = 2 t: at 1e6 s it is let go up to 1e-10 s late, and what moves it first is
    of that size (no step was small enough)."""
    model = scene(f"""model Late
      Block b(m = 2, base = world);
      DryFriction f(F = 10, rate = b.v);
      AppliedForce p(at = b.center, force = {{4[N/s]*max(time - {begins}, 0[s]), 0}});
    end Late;""")
    for solver in ("auto", "erk", "erk5", "adams", "implicit"):
        for tolerance in (1e-3, 1e-6, 1e-9, 1e-12):
            run = model.simulate(at=[begins + 2.4, begins + 4.5], start=begins, solver=solver, tolerance=tolerance)
            np.testing.assert_allclose(run["b.s"], [0, 8 / 3], rtol=0, atol=max(100 * tolerance, 1e-15 * begins))


@pytest.mark.parametrize("solver", ["erk", "erk5", "pirk"])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-8, 1e-12])
def test_a_step_into_a_steep_wall_tells_no_size(scene: Write, solver: str, tolerance: float) -> None:
    """Where no load acts as a step begins, its end at 1e286 m was taken for the size of the motion: "no step is small
    enough", or rows off by 16 000 tolerances with a note (erk5 at 1e-8)."""
    run = scene("""model Wall "Free as far as a wall of the 30th power"
      World world(gravity = {0, 0});
      Block b(m = 1, base = world, s(start = 0), v(start = 1));
    energy
      potential 0.001[J]*(b.s/0.1[m])^30;
    end Wall;""").simulate(at=0.25*np.arange(7), solver=solver, tolerance=tolerance)
    half = 0.2 * 500 ** (1 / 30) * math.sqrt(math.pi) * math.gamma(1 + 1 / 30) / math.gamma(0.5 + 1 / 30)  # a period
    right = [(-1) ** k * k * (0.25 - half) for k in range(7)]
    np.testing.assert_allclose(run["b.s"], right, rtol=0, atol=10 * tolerance + 1e-12)
