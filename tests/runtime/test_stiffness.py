"""`auto` finds stiffness while running, goes over to implicit steps and back; and hard places for implicit steps."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.runtime import Solver
from lagrangia.run.solvers import name_of

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
Write = Callable[[str], lag.Model]

FLEXIBLE = """model Flexible "A chain whose hinges are stiff and heavily damped"
  parameter Integer n = 4; parameter Real k(unit = "N.m/rad") = 1e6; parameter Real c(unit = "N.m.s/rad") = 1e3;
  Revolute hinge[n]; Bar link[n](each m = 1, each L = 0.5);
  TorsionSpringDamper s[n-1](each k = k, each c = c);
equation
  connect(world, hinge[1].a);
  for i in 1:n loop connect(hinge[i].b, link[i].a); end for;
  for i in 1:n-1 loop
    connect(link[i].b, hinge[i+1].a); connect(s[i].a, link[i].center); connect(s[i].b, link[i+1].center);
  end for;
initial equation
  hinge[1].phi = 1;
end Flexible;
"""
RELAXATION = """model Relaxation "B. van der Pol's oscillator: slow stretches, and jumps between them"
  parameter Real mu = 300; parameter Stiffness k = 1; parameter Damping c = 1; parameter Length one = 1;
  Block b(m = 1, base = world, s(start = 2));
  Spring s(k = k, stretch = b.s);
  AppliedForce f(at = b.center, force = {mu*c*(1 - (b.s/one)^2)*b.v, 0});
end Relaxation;
"""
GOVERNOR = """model Governor "Flyball: the shaft turns by psi, the arms hang at alpha, the sleeve sits at s"
  parameter Length R = 0.04, A = 0.9, H = 0.95, d0 = 0.45;
  parameter Mass M = 4, S = 2.5, mr = 0.2;
  parameter Inertia J = 0.004;
  parameter Stiffness K = 9e5;
  parameter Damping C = 5e4;
  coordinate Angle psi(fixed = true), alpha(start = 32[deg], fixed = true);
  coordinate Length s(start = 0.45, fixed = true);
  Length reach = R + A*cos(alpha), mid = R + A*cos(alpha)/2, d = sqrt((A*cos(alpha)/2)^2 + (H - A*sin(alpha)/2 - s)^2);
energy
  kinetic J*der(psi)^2/2 + S*der(s)^2/2 + M*(A^2*der(alpha)^2 + reach^2*der(psi)^2)
    + mr*((A/2)^2*der(alpha)^2 + mid^2*der(psi)^2) + mr*A^2/12*(der(alpha)^2 + cos(alpha)^2*der(psi)^2);
  potential S*9.81[m/s2]*s - 2*M*9.81[m/s2]*A*sin(alpha) - mr*9.81[m/s2]*A*sin(alpha) + K*(d - d0)^2;
  dissipation C*der(d)^2;
initial equation
  der(psi) = 6[rad/s];
end Governor;
"""
COLLAR = """model Collar "A loop that carries a plate on a stiff, damped spring"
  parameter Stiffness K = 2e5; parameter Damping C = 2e4;
  Revolute h(a = world, phi(start = 0.5)); Bar arm(m = 1, L = 0.5, a = h.b);
  Prismatic slide(a = world, along = {0, 1}); Body collar(m = 2, I = 0.1, center = slide.b);
  Link link(a = arm.b, b = collar.center, L = 0.6);
  Prismatic s2(a = collar.center, along = {0, 1}, s(start = 0.2)); Body plate(m = 1.5, I = 0.1, center = s2.b);
  Spring k(stretch = s2.s - 0.2[m], k = K); Damper c(rate = s2.v, c = C);
end Collar;
"""


def difference(run: lag.Trajectory, exact: lag.Trajectory, model: lag.Model) -> float:
    return max(np.abs(run[c.name] - exact[c.name]).max() / np.abs(exact[c.name]).max() for c in model.scene.coordinates)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_a_stiff_scene_goes_over_to_implicit_steps(scene: Write, tolerance: float) -> None:
    model, at = scene(FLEXIBLE), np.linspace(0, 1, 9)
    exact = model.simulate(at=at, tolerance=1e-13, solver="implicit")
    run = model.simulate(at=at, tolerance=tolerance)
    assert difference(run, exact, model) < 3 * tolerance
    assert run.statistics.switches > 0
    assert run.statistics.implicit_steps > 10
    assert run.statistics.steps < 600  # erk alone takes 23 000


@pytest.mark.parametrize(("K", "C", "tolerance"), [
    (9e5, 5e4, 1e-9), (9e5, 5e4, 1e-10), (9e5, 5e4, 1e-12), (9e3, 5e3, 1e-10), (9e6, 5e4, 1e-11), (9e4, 5e3, 1e-8)])
def test_what_has_died_out_limits_steps_before_stability_does(scene: Write, K: float, C: float, tolerance: float) -> None:
    """erk alone takes 6000 to 75 000 steps, each near 1 in units of the damping, which is far from where it gets unstable."""
    model = scene(GOVERNOR)
    run = model.simulate(at=[0.0, 10.0], tolerance=tolerance, parameters={"K": K, "C": C})
    assert run.statistics.implicit_steps > 100 and run.statistics.steps < 1500
    if (K, C) == (9e5, 5e4):  # SciPy's Radau at 1e-10, of equations made by SymPy
        assert [run["s"][-1], run["psi"][-1]] == pytest.approx([0.48152215517, 54.8118084162], rel=max(1e-9, tolerance))
    else:
        exact = model.simulate(at=[0.0, 10.0], tolerance=1e-13, parameters={"K": K, "C": C}, solver="implicit")
        assert difference(run, exact, model) < 30 * tolerance


def test_the_same_in_a_closed_loop(scene: Write) -> None:
    model, at = scene(COLLAR), [0.0, 5.0, 10.0]
    run = model.simulate(at=at, tolerance=1e-10)
    assert run.statistics.steps < 6000  # erk alone: 35 000
    assert difference(run, model.simulate(at=at, tolerance=1e-13, solver="implicit"), model) < 1e-8


def test_it_goes_there_and_back(scene: Write) -> None:
    model, at = scene(RELAXATION), np.linspace(0, 700, 15)
    exact = model.simulate(at=at, tolerance=1e-12, solver="implicit")
    run = model.simulate(at=at, tolerance=1e-8)
    assert run.statistics.switches >= 2
    assert 0 < run.statistics.implicit_steps < run.statistics.steps
    assert difference(run, exact, model) < 1e-6
    again = model.simulate(at=at, tolerance=1e-8)
    assert np.array_equal(run["b.s"], again["b.s"])


@pytest.mark.parametrize(("name", "tolerance"), [
    ("spring_pendulum", 1e-8), ("slider_crank", 1e-8), ("chain", 1e-3), ("chain", 1e-8)])
def test_scenes_that_are_not_stiff_stay_explicit(name: str, tolerance: float) -> None:
    """To the last bit: looking at the spectrum changes nothing."""
    model, at = lag.load(EXAMPLES / f"{name}.lag"), [1.0, 2.0, 3.0]
    run = model.simulate(at=at, tolerance=tolerance)
    assert run.statistics.solver in (Solver.PIRK, Solver.TAYLOR)
    explicit = model.simulate(at=at, tolerance=tolerance, solver=name_of(run.statistics.solver))
    assert run.statistics.switches == 0
    assert all(np.array_equal(run[c.name], explicit[c.name]) for c in model.scene.coordinates)
    assert run.statistics.rhs_evaluations < 1.05 * explicit.statistics.rhs_evaluations + 20


PULSED = """model Pulsed "A mass that is held fast for 3 s of every 6"
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, s(start = 1)), e(m = 1, base = world);
  DuffingSpring one(k = 1, k3 = 1, stretch = b.s), two(k = 1, k3 = 10, stretch = e.s - b.s);
  AppliedForce f(at = b.center, force = {-1e6[N.s/m]*pulse_train(time, 1, 3, 6)*b.v, 0});
end Pulsed;
"""


@pytest.mark.parametrize(("text", "stop"), [(PULSED, 240), (RELAXATION, 9000)])
def test_stiffness_that_comes_again_and_again_is_found_each_time(scene: Write, text: str, stop: float) -> None:
    """The wait before the next trial grew with each: 9 million steps."""
    model = scene(text)
    auto, implicit = (model.simulate(stop=stop, tolerance=1e-6, solver=solver) for solver in ("auto", "implicit"))
    assert auto.statistics.steps < 12 * implicit.statistics.steps


def test_energy_is_kept_over_switches(scene: Write) -> None:
    model = scene(FLEXIBLE)
    run = model.simulate(stop=1, tolerance=1e-8)
    assert run.statistics.switches > 0
    assert run.energy.dissipated[-1] > 0
    assert np.abs(run.energy.residual).max() < 1e-6 * run.statistics.energy_scale


def test_the_summary_says_what_was_used(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    from lagrangia.command.cli import main

    file = tmp_path / "flexible.lag"
    file.write_text(FLEXIBLE)
    assert main(["simulate", str(file), "--stop", "1", "-o", str(tmp_path / "x.csv")]) == 0
    captured = capsys.readouterr()
    assert re.search(r"erk \(\d+ steps\), implicit \(\d+ steps\)|implicit \(\d+ steps\)", captured.out + captured.err)


CONTACT = """model Contact "A ball on a stiff floor that only pushes"
  parameter Real k(unit = "N/m3") = 1e9; parameter Length z = 0.5;
  Block ball(m = 1, base = world, along = {0, 1}, s(start = 1));
  GeneralSpring floor(stretch = max(z - ball.s, 0), V = k*floor.stretch^4/4);
end Contact;
"""


@pytest.mark.parametrize("solver", ["implicit", "auto"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8, 1e-10])
def test_contact_is_not_jumped_over(scene: Write, solver: str, tolerance: float) -> None:
    run = scene(CONTACT).simulate(stop=5, tolerance=tolerance, solver=solver)
    assert np.abs(run.energy.residual).max() < 300 * tolerance * run.statistics.energy_scale
    assert run["ball.s"].min() > 0.45
    assert run["ball.s"].max() < 1.01


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10, 1e-12])
def test_implicit_steps_pass_singular_positions(tolerance: float) -> None:
    model = lag.load(EXAMPLES / "n_four_bars.lag")  # all fold flat at the same time
    at = np.linspace(0, 2, 11)
    exact = model.simulate(at=at, tolerance=1e-13, solver="erk")
    run = model.simulate(at=at, tolerance=tolerance, solver="implicit")
    assert difference(run, exact, model) < max(10 * tolerance, 1e-11)
    assert run.statistics.constraint_residual < 1e-12


def test_motion_that_sets_in_from_rest_is_not_resolved_against_noise() -> None:
    model = lag.load(EXAMPLES / "quarter_car.lag")  # the road begins to rise at t = 0.5, by its square
    for tolerance, most in ((1e-8, 300), (1e-10, 600), (1e-12, 3000)):
        run = model.simulate(stop=3, tolerance=tolerance, solver="implicit")
        assert run.statistics.steps < most


def test_nearly_massless_bars_are_stiff_and_pass(scene: Write) -> None:
    """A four-bar whose coupler weighs a billionth of the others, with heavy dampers."""
    model = scene("""model Light
  Revolute O(a = world, phi(start = 40[deg], fixed = true)), A(a = crank.b), B(a = coupler.b, b = rocker.b),
           C(a = shift(world, {1, 0}), phi(start = 75[deg]));
  Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 1e-9, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
  TorsionDamper d(a = crank.center, b = coupler.center, c = 10);
end Light;
""")
    at = np.linspace(0, 1, 6)
    exact = model.simulate(at=at, tolerance=1e-12, solver="implicit")
    for tolerance in (1e-5, 1e-8):
        for solver in ("implicit", "auto"):
            assert difference(model.simulate(at=at, tolerance=tolerance, solver=solver), exact, model) < 10 * tolerance


def test_a_smooth_run_is_not_looked_at() -> None:
    """Sweeps that come near fast say that stability does not rule: `auto` makes the same steps for the same evaluations."""
    model = lag.load(Path(__file__).parents[1] / "benchmarks" / "scenes" / "top_of_hinges.lag")
    found, asked = (model.simulate(at=[0, 2], tolerance=1e-3, solver=solver).statistics for solver in ("auto", "pirk"))
    assert name_of(found.solver) == "pirk" and found.rhs_evaluations == asked.rhs_evaluations
