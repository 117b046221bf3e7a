"""Numbers far apart: stiffness, masses, arms of no length, bars of no mass."""

import math
from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import RunError
from lagrangia.native.build import find_compiler
from lagrangia.run.solvers import applicable

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Scene = Callable[[str], lag.Model]
EPS = np.finfo(float).eps


def difference(run: lag.Trajectory, exact: lag.Trajectory, *names: str) -> float:
    """Largest difference of coordinates, rad and m."""
    return max(float(np.abs(run[name] - exact[name]).max()) for name in names or [c.name for c in run.scene.coordinates])


# ---------------------------------------------------------------- stiffness

FOLLOWER = """model Follower "A spring and a damper, however stiff, hold a mass on the way sin t"
  parameter Real k = 1, c = 1, k3 = 1;
  coordinate Real x;
energy
  kinetic der(x)^2/2; potential k*x^2/2 + k3*x^4/4; dissipation c*der(x)^2/2;
  work (k - 1)*sin(1*time) + c*cos(1*time) + k3*sin(1*time)^3 on x;
initial equation
  der(x) = 1;
end Follower;
"""


@pytest.mark.parametrize("exponent", range(0, 15, 2))
@pytest.mark.parametrize("solver", ["auto", "implicit"])
def test_stiffness(exponent: int, solver: str, scene: Scene) -> None:
    """Springs 1 to 1e14 times as stiff as the motion needs, one of them hardening: the motion is sin t, and what it costs is
    bounded. The tolerance stays above eps k/c, below which rounding of the place moves the rate.

    Explicit steps are short for their accuracy before they are for their stability, the shorter the tighter the tolerance: `auto`
    stays with them below 1e14 at 1e-8, at a cost that is bounded as well."""
    k = 10.0**exponent
    model = scene(FOLLOWER)
    for tolerance in (1e-4, 1e-6, 1e-8):
        if tolerance < 3 * EPS * k**0.5:
            continue
        run = model.simulate(at=np.linspace(0, 2, 5), tolerance=tolerance, solver=solver, max_steps=300_000,
                             parameters={"k": k, "c": k**0.5, "k3": k})
        assert np.abs(run["x"] - np.sin(run.time)).max() < tolerance
        assert np.abs(run["der(x)"] - np.cos(run.time)).max() < 300 * tolerance
        assert run.statistics.steps < 1000 or (solver == "auto" and (exponent < 8 or tolerance < 1e-7))


# ---------------------------------------------------------------- masses

ARMS = """model Arms
  parameter Mass m1 = 1, m2 = 1;
  Revolute A(a = world, phi(start = 1)), B(a = upper.b, phi(start = 0.5));
  Bar upper(m = m1, L = 1, a = A.b), lower(m = m2, L = 1, a = B.b);
end Arms;
"""


@pytest.mark.parametrize("solver", ["auto", "implicit", "taylor"])
def test_mass_ratios(solver: str, scene: Scene) -> None:
    """A light arm moves as one without mass, and the error is in step with its mass, from 1e-3 to 1e-15; so it is beside masses
    of 1 kg, 1e9 kg and 1e-9 kg."""
    model = scene(ARMS)
    if solver not in ("auto", *applicable(model.scene)):
        pytest.skip(f"{solver} does not run this scene")

    def run(m1: float, m2: float) -> lag.Trajectory:
        return model.simulate(at=np.linspace(0, 3, 7), tolerance=1e-12, solver=solver, parameters={"m1": m1, "m2": m2})

    bare = run(0, 1)
    alone = scene(ARMS.replace(", lower(m = m2, L = 1, a = B.b)", "").replace(", B(a = upper.b, phi(start = 0.5))", ""))
    single = alone.simulate(at=np.linspace(0, 3, 7), tolerance=1e-12, solver=solver)
    for unit in (1.0, 1e9, 1e-9):
        for ratio in 10.0 ** -np.arange(3, 16, 3):
            upper, lower = run(ratio * unit, unit), run(unit, ratio * unit)
            assert difference(upper, bare) < 200 * ratio + 1e-10
            assert difference(lower, single, "A.phi") < 200 * ratio + 1e-10
            for motion in (upper, lower):
                assert motion.statistics.energy_residual < 1e-11 * motion.statistics.energy_scale


@pytest.mark.parametrize("ratio", [1e-12, 1e-6, 1e6, 1e12])
def test_two_masses_on_a_spring(ratio: float, scene: Scene) -> None:
    """They swing with k (1/m1 + 1/m2) about a centre of mass that moves on evenly; the spring hardens, in vain: no amplitude."""
    model = scene("""model Pair
  parameter Mass m = 1, M = 1; parameter Stiffness k = 4;
  Block a(m = m, base = world), b(m = M, base = world, s(start = 1), v(start = 0.5));
  GeneralSpring s(stretch = b.s - a.s - 1, V = k*s.stretch^2/2 + 1e-12*k*s.stretch^4/1[m2]);
initial equation
  der(a.s) = 0.25;
end Pair;""")
    run = model.simulate(at=np.linspace(0, 5, 11), tolerance=1e-11, parameters={"m": ratio, "k": 4 * min(ratio, 1)})
    w = np.sqrt(4 * min(ratio, 1) * (1 / ratio + 1))
    centre = (ratio * run["a.s"] + run["b.s"]) / (1 + ratio)
    assert centre == pytest.approx(1 / (1 + ratio) + (0.25 * ratio + 0.5) / (1 + ratio) * run.time, abs=1e-9)
    assert run["b.s"] - run["a.s"] - 1 == pytest.approx(0.25 / w * np.sin(w * run.time), abs=1e-9)


# ---------------------------------------------------------------- near-singular M

KNEE = """model Knee "A bar on an arm of length e without mass: det M falls as e^2"
  parameter Length e = 1e-3;
  Revolute A(a = world, phi(start = 1)), B(a = shift(A.b, {0, -e}), phi(start = 0.2));
  Bar bar(m = 1, L = 1, a = turn(B.b, -90[deg]));
end Knee;
"""


@pytest.mark.parametrize("e", [1.0, 1e-1, 1e-2, 1e-3])
def test_a_nearly_singular_mass_matrix(e: float, scene: Scene) -> None:
    """Explicit and implicit steps agree, and the energy account closes, with a condition number of M up to 1e6."""
    model, at = scene(KNEE), np.linspace(0, 1, 5)
    runs = [model.simulate(at=at, tolerance=1e-9, solver=solver, parameters={"e": e}) for solver in ("erk", "implicit", "auto")]
    for run in runs:
        assert run.statistics.energy_residual < 1e-8 * run.statistics.energy_scale
        assert difference(run, runs[0]) < 1e-6 / e


@pytest.mark.parametrize("e", [1e-8, 1e-10, 1e-12])
def test_a_hardly_regular_mass_matrix_is_right_as_far_as_the_steps_reach(e: float, scene: Scene) -> None:
    """M is collected: the determinant keeps its digits, and the arm turns 1/e times a second."""
    with pytest.raises(RunError, match="limit of steps") as failure:
        scene(KNEE).simulate(stop=1, parameters={"e": e}, max_steps=5_000, interval=1e-4)
    kept = failure.value.trajectory
    assert np.abs(kept.energy.residual).max() < 1e-8 * 5


def test_a_singular_mass_matrix_is_refused_with_its_coordinate(scene: Scene) -> None:
    with pytest.raises(RunError, match=r"t = 0 .*(A|B)\.phi") as failure:
        scene(KNEE).simulate(stop=1, parameters={"e": 0}, max_steps=100_000)
    kept = failure.value.trajectory
    assert kept is None or np.isfinite(kept.rows).all()


@pytest.mark.parametrize("e", [1e-6, 1e-5])
def test_a_tolerance_below_the_rounding_of_m_never_ends_silently(e: float, scene: Scene) -> None:
    """The accelerations have no digit beyond eps cond M: at 1e-11 the steps go on shrinking, the limit of steps is told with
    its time, and all rows that are there are right by their energy."""
    with pytest.raises(RunError, match="limit of steps") as failure:
        scene(KNEE).simulate(stop=3, tolerance=1e-11, parameters={"e": e}, max_steps=20_000, interval=1e-5)
    kept = failure.value.trajectory
    assert np.isfinite(kept.rows).all()
    assert np.abs(kept.energy.residual).max() < 1e-8 * 5


# ---------------------------------------------------------------- bars of nearly no mass

FOUR_BAR = """model Light "A four-bar with a coupler of any mass"
  parameter Mass m = 1;
  Revolute O(a = world, phi(start = 40[deg], fixed = true)), A(a = crank.b), B(a = coupler.b, b = rocker.b),
           C(a = shift(world, {1, 0}), phi(start = 75[deg]));
  Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = m, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
end Light;
"""


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_nearly_massless_bars(solver: str, scene: Scene) -> None:
    """From 1e-3 kg to 1e-15 kg the motion goes over into that of a coupler without mass, in step with its mass."""
    model, at = scene(FOUR_BAR), np.linspace(0, 1, 6)
    bare = model.simulate(at=at, tolerance=1e-12, solver=solver, parameters={"m": 0})
    for m in (1e-3, 1e-6, 1e-9, 1e-12, 1e-15):
        run = model.simulate(at=at, tolerance=1e-12, solver=solver, parameters={"m": m})
        assert difference(run, bare) < 100 * m + 1e-9
        assert run.statistics.constraint_residual < 1e-13
        assert run.statistics.energy_residual < 1e-10 * run.statistics.energy_scale


def test_a_light_end_of_a_heavy_row_keeps_its_digits() -> None:
    """10 ug on a kilogram: off by up to 5e-7 m at any tolerance, as its inertia was rounded beside what the row weighs."""
    at = [0.5, 1.0, 1.5, 2.0]
    rows = lag.loads("""model Rods
      World world(gravity = {0, -9.81});
      PointMass a(m = 1); Link r(L = 1, a = world, b = a.center);
      PointMass b(m = 1e-8); Link s(L = 1, a = a.center, b = b.center);
    initial equation
      a.center.x = 1; a.center.y = 0; b.center.x = 1; b.center.y = -1;
    end Rods;""")
    hinges = lag.loads(f"""model Hinges
      World world(gravity = {{0, -9.81}});
      Revolute h(a = world, phi(start = {math.pi / 2})); PointMass a(m = 1, center = shift(h.b, {{0, -1}}));
      Revolute g(a = a.center, phi(start = {-math.pi / 2})); PointMass b(m = 1e-8, center = shift(g.b, {{0, -1}}));
    end Hinges;""")
    right = hinges.simulate(solver="erk9", tolerance=1e-13, at=at)
    x = np.sin(right["h.phi"]) + np.sin(right["h.phi"] + right["g.phi"])
    for solver in ("auto", "erk", "implicit"):
        for tolerance in (1e-9, 1e-12):
            found = rows.simulate(solver=solver, tolerance=tolerance, at=at)
            assert found["b.center.x"] == pytest.approx(x, abs=max(tolerance, 1e-11))
