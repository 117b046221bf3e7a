"""Dry friction: forces that jump with a velocity, and hold it at their jump."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "taylor", "erk", "erk5", "adams", "implicit")
G = 9.81

# The same friction said in three ways.
LAWS = {
    "dissipation": "DryFriction f(F = 5, rate = b.v);",
    "sign": "AppliedForce f(at = b.center, force = {-5*sign(b.v), 0});",
    "if": "AppliedForce f(at = b.center, force = {if b.v > 0[m/s] then -5 else 5, 0});",
}


def stopping(law: str) -> str:
    return f"""model Stopping "swings on a rough plane until it sticks"
      Block b(m = 2, base = world, s(start = 0.95));
      Spring k(k = 50, stretch = b.s);
      {LAWS[law]}
    end Stopping;"""


def stopping_on_paper(t: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Half swings about +F/k and -F/k in turn, each shorter by 2 F/k, until the spring cannot tear it off."""
    w, shift, s, begin = 5.0, 0.1, 0.95, 0.0
    place, rate = np.empty_like(t), np.zeros_like(t)
    while abs(s) > shift:
        middle = np.copysign(shift, s)
        now = (t >= begin) & (t < begin + np.pi / w)
        place[now] = middle + (s - middle) * np.cos(w * (t[now] - begin))
        rate[now] = -w * (s - middle) * np.sin(w * (t[now] - begin))
        s, begin = 2 * middle - s, begin + np.pi / w
    place[t >= begin] = s
    return place, rate


@pytest.mark.parametrize("law", LAWS)
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_a_block_swings_until_it_sticks(scene: Write, law: str, solver: str, tolerance: float) -> None:
    t = np.linspace(0, 10, 101)
    run = scene(stopping(law)).simulate(at=t, tolerance=tolerance, solver=solver)
    place, rate = stopping_on_paper(t)
    np.testing.assert_allclose(run["b.s"], place, rtol=0, atol=max(5 * tolerance, 1e-12))
    np.testing.assert_allclose(run["b.v"], rate, rtol=0, atol=max(25 * tolerance, 5e-12))
    assert run.statistics.rhs_evaluations < 15_000


PUSHED = """model Pushed "held by its friction until the load is too large"
  Block b(m = 1, base = world);
  Force F = -3*sign(b.v);
  AppliedForce f(at = b.center, force = {F, 0}), load(at = b.center, force = {4*sin(1[rad/s]*time), 0});
  output Force holding = F;
  output Acceleration a = der(b.v);
end Pushed;"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_friction_holds_what_it_can(scene: Write, solver: str) -> None:
    """At rest it is as large as the load; then v = 4 (cos t1 - cos t) - 3 (t - t1) with 4 sin t1 = 3."""
    t, torn = np.linspace(0, 1.5, 31), np.arcsin(0.75)
    run = scene(PUSHED).simulate(at=t, tolerance=1e-9, solver=solver)
    rests = t < torn
    np.testing.assert_allclose(run["holding"], np.where(rests, -4 * np.sin(t), -3), rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["a"], np.where(rests, 0, 4 * np.sin(t) - 3), rtol=0, atol=1e-12)
    np.testing.assert_allclose(run["b.v"], np.where(rests, 0, 4 * (np.cos(torn) - np.cos(t)) - 3 * (t - torn)), rtol=0, atol=1e-9)
    assert run.statistics.events == 1


def test_series_go_on_as_soon_as_nothing_sticks() -> None:
    """Three slips and four times of sticking in 5 s: 33 steps once, as what is torn off was left to short ones for a while."""
    model = lag.load(Path(__file__).parents[2] / "models" / "examples" / "stick_slip.lag")
    run = model.simulate(at=[5.0], tolerance=1e-8)
    exact = model.simulate(at=[5.0], tolerance=1e-12, solver="erk")
    assert run.statistics.events == exact.statistics.events == 6
    assert run.statistics.steps < 23
    np.testing.assert_allclose(run["block.s"], exact["block.s"], rtol=0, atol=1e-10)


@pytest.mark.parametrize("angle", [10, 25])
def test_a_block_on_an_incline_stays_or_slides(scene: Write, angle: float) -> None:
    """It stays where tan(angle) < 0.3."""
    phi, m, mu = np.radians(angle), 2.0, 0.3
    model = scene(f"""model Incline
      Prismatic p(a = world, along = {{cos({angle}[deg]), -sin({angle}[deg])}});
      PointMass b(m = {m}, center = p.b);
      DryFriction f(F = {mu * m * G * np.cos(phi)}, rate = p.v);
    end Incline;""")
    slope = max(0.0, G * (np.sin(phi) - mu * np.cos(phi)))
    assert model.simulate(at=[2.0], tolerance=1e-9)["p.s"][-1] == pytest.approx(2 * slope, rel=1e-12, abs=1e-14)


ROLLING = """model Rolling "A disc slips on a floor until it rolls: what sticks is the rate of its lowest point"
  Prismatic x(a = world, along = {1, 0}, v(start = 3));
  Revolute r(a = x.b);
  Disc d(m = 2, r = 0.1, center = r.b);
  DryFriction f(F = 0.2*2*9.81, rate = x.v + 0.1[m]*r.w);
end Rolling;"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_disc_slips_until_it_rolls(scene: Write, solver: str) -> None:
    """Of a disc I = m r^2/2, so that two thirds of its speed are left."""
    run = scene(ROLLING).simulate(at=[0.25, 3.0], tolerance=1e-9, solver=solver)
    rolls = 1 / (0.2 * G)
    np.testing.assert_allclose(run["x.v"], [3 - 0.2 * G * 0.25, 2], rtol=1e-12)
    np.testing.assert_allclose(run["r.w"][-1], -20, rtol=1e-12)
    assert run["x.s"][-1] == pytest.approx(3 * rolls - 0.1 * G * rolls**2 + 2 * (3 - rolls), rel=1e-12)


BRAKES = """model Brakes "Two brakes on one shaft, and a clutch between it and another one"
  World world(gravity = {0, 0});
  Revolute r1(a = world), r2(a = world, w(start = -5));
  Disc d1(m = 2, r = 0.2, center = r1.b), d2(m = 1, r = 0.2, center = r2.b);
  AppliedTorque t(on = r1.b, torque = 8*sin(2[rad/s]*time));
  TorsionDryFriction b1(tau = 2, a = world, b = r1.b), b2(tau = 3, a = world, rate = 2*r1.w), clutch(tau = 1, a = r2.b, b = r1.b);
end Brakes;"""


def test_brakes_that_hold_the_same_shaft(scene: Write) -> None:
    """2 + 2*3 are more than 8 sin: nothing moves it, whatever each of them does; the clutch stops the other one in 0.02*5/1 s."""
    model = scene(BRAKES.replace("8*sin", "7*sin"))
    run = model.simulate(at=np.linspace(0, 5, 51), tolerance=1e-9)
    assert np.abs(run["r1.w"]).max() < 1e-12
    np.testing.assert_allclose(run["r2.w"], np.minimum(-5 + 50 * run["time"], 0), rtol=0, atol=1e-12)
    slips = scene(BRAKES.replace("8*sin", "20*sin")).simulate(stop=5, tolerance=1e-9)
    assert np.abs(slips["r1.w"]).max() > 10
    assert slips.statistics.energy_residual < 1e-8


ROD = """model Rod "Two pendulums whose tips rub on a rod between them: what sticks is the rate of a distance"
  Revolute h[2](a = {world, shift(world, {1.5, 0})}, phi(start = {-1, -2.5}));
  PointMass p[2](m = {1, 2}, center = {shift(h[i].b, {1, 0}) for i in 1:2});
  Length d = distance(p[1].center, p[2].center);
  DryFriction f(F = 4, a = p[1].center, b = p[2].center);
  output Length gap = d;
end Rod;"""
CRANK = """model Crank "A slider crank whose piston rubs until it stops"
  World     world(gravity = {0, 0});
  Revolute  O(a = world, phi(start = 0.5, fixed = true), w(start = 10)),
            pin(a = crank.b, b = rod.a), wrist(a = rod.b, b = piston.center);
  Prismatic guide(a = world, s(start = 0.4));
  Bar       crank(m = 1, L = 0.1, a = O.b), rod(m = 0.5, L = 0.3);
  PointMass piston(m = 2, center = guide.b);
  AppliedForce f(at = piston.center, force = {15*cos(3[rad/s]*time), 0});
  DryFriction rub(F = 10, rate = guide.v);
end Crank;"""
ROW = """model Row "Blocks on a rough plane in a row of springs, drawn by a belt (R. Burridge, L. Knopoff, 1967)"
  parameter Integer n = 12;
  Block b[n](each m = 1, each base = world, s(start = {0.01*sin(7*i) for i in 1:n}));
  SpringDamper k[n-1](each k = 30, each c = 0.1, stretch = {b[i+1].s - b[i].s for i in 1:n-1});
  Spring l[n](each k = 5, stretch = {b[i].s - 0.1[m/s]*time for i in 1:n});
  DryFriction f[n](each F = 1, rate = {b[i].v for i in 1:n});
end Row;"""


@pytest.mark.parametrize(("text", "stop", "most"), [(ROD, 10.0, 20_000), (CRANK, 5.0, 20_000), (ROW, 12.0, 30_000)],
                         ids=["rod", "crank", "row"])
@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
def test_solvers_agree_on_what_sticks(scene: Write, text: str, stop: float, most: int, solver: str) -> None:
    """Loops, rates of distances, and many at once; the reference comes of another method, a hundred times as tight."""
    t, model = np.linspace(0, stop, 41), scene(text)
    best, run = (model.simulate(at=t, tolerance=tol, solver=which) for tol, which in ((1e-10, "erk"), (1e-8, solver)))
    for column in model.scene.coordinates:
        size = np.abs(best[column.name]).max()
        np.testing.assert_allclose(run[column.name], best[column.name], rtol=0, atol=2e-8 * size + 2e-10)
    assert run.statistics.rhs_evaluations < most
    assert run.statistics.energy_residual < 1e-7 * run.statistics.energy_scale


SWINGING = """model Swinging
  Block a(m = 1, base = world, s(start = 1));
  Spring k(k = 20, stretch = a.s);
  AppliedForce f(at = a.center, force = {%s, 0});
end Swinging;"""


@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
@pytest.mark.parametrize(("force", "end"), [
    ("-4[N]*sign(a.v)*(1.3 + 0.3*sign(a.v))", -0.04),  # 6.4 N one way, 4 N the other
    ("-4[N]*a.v/abs(a.v)", 0.2),
    ("-4[N]*sign(a.v)^3*sign(a.v)^2", 0.2),
    ("if a.v > 0[m/s] and time < 3 then -4.5[N] elseif a.v > 0[m/s] then -1[N] else 2[N]", 0.05),
    ("if a.v > 0[m/s] then (if a.s < 0[m] then -4[N] else -6[N]) else 4[N]", np.sqrt(0.21) - 0.3),
    ("-4[N]*sign(a.v)*(1 + 0.5*exp(-abs(a.v)/1e-4[m/s]))", 0.2),
])
def test_laws_of_friction(scene: Write, force: str, end: float, solver: str) -> None:
    """Half swings about force/k, however the law is written."""
    run = scene(SWINGING % force).simulate(at=[6.0], tolerance=1e-8, solver=solver)
    assert run["a.s"][-1] == pytest.approx(end, abs=1e-6 if "exp" in force else 2e-9)
    assert run["a.v"][-1] == pytest.approx(0, abs=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_brake_that_is_released(scene: Write, solver: str) -> None:
    """From exact rest: 10 (2 - t) = 2 at 1.8 s, v = 5 (t - 1.8)^2 until 2 s, and 2 N pull it on."""
    run = scene("""model Released
      Block a(m = 1, base = world);
      AppliedForce f(at = a.center, force = {-10[N]*(1 - ramp(time, 1, 1))*sign(a.v) + 2[N], 0});
    end Released;""").simulate(at=[1.0, 1.8, 2.0, 4.0], tolerance=1e-8, solver=solver)
    np.testing.assert_allclose(run["a.s"], [0, 0, 0.04 / 3, 0.04 / 3 + 4.4], rtol=0, atol=1e-8)
    assert run.statistics.rhs_evaluations < 40_000


@pytest.mark.parametrize("limit", ["abs(sin(2[rad/s]*time))", "max(0, cos(2[rad/s]*time))"])
@pytest.mark.parametrize("solver", SOLVERS)
def test_what_nothing_draws_at_rests_without_friction_too(scene: Write, limit: str, solver: str) -> None:
    run = scene(f"""model Resting
      Block a(m = 1, base = world);
      AppliedForce f(at = a.center, force = {{-10[N]*{limit}*sign(a.v), 0}});
    end Resting;""").simulate(stop=8, tolerance=1e-8, solver=solver)
    assert np.abs(run["a.s"]).max() < 1e-9
    assert run.statistics.rhs_evaluations < 20_000


BELT = """model Belt
  input Velocity belt;
  Block a(m = 1, base = world);
  Force rub = -2[N]*sign(a.v - belt);
  AppliedForce f(at = a.center, force = {rub, 0});
  output Force rubbing = rub;
end Belt;"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_an_input_draws_what_sticks_along(scene: Write, solver: str) -> None:
    """With 0.5 m/s2; then the belt is torn away, and the block comes after it with 2 m/s2."""
    table = [0.0, 2.0, 2.5, 4.0], {"belt": [0.0, 1.0, 3.0, 3.0]}
    run = scene(BELT).simulate(at=[2.0, 2.5, 3.0, 4.0], tolerance=1e-9, solver=solver, inputs=table)
    np.testing.assert_allclose(run["a.v"], [1, 2, 3, 3], rtol=0, atol=1e-8)
    np.testing.assert_allclose(run["a.s"][:2], [1, 1.75], rtol=0, atol=1e-8)
    np.testing.assert_allclose(run["rubbing"][[0, 1, 3]], [0.5, 2, 0], rtol=0, atol=1e-9)


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_an_input_that_jumps_moves_nothing_at_once(tmp_path: Path, kind: str) -> None:
    path = tmp_path / "belt.lag"
    path.write_text(BELT, encoding="utf-8")
    table = np.array([(0, 0), (1 - 1e-9, 0), (1, 1), (3, 1)], dtype=[("time", float), ("belt", float)])
    found = simulated(path, "2", kind, ["a.v"], stop_time=3.0, output_interval=0.01, relative_tolerance=1e-9, input=table)
    at = np.interp([0.9, 1.1, 1.4, 1.6, 3.0], found["time"], found["a.v"])
    np.testing.assert_allclose(at, [0, 0.2, 0.8, 1, 1], rtol=0, atol=1e-6)


def test_islands_stick_each_by_itself(scene: Write) -> None:
    """And rows of the whole know what holds them."""
    model = scene("""model Islands
      Block b[3](each m = 1, each base = world, s(start = {0.1, 0.2, 0.3}));
      Spring k[3](each k = 30, stretch = {b[i].s for i in 1:3});
      Force F[3] = {-(0.5 + 0.1*i)*sign(b[i].v) for i in 1:3};
      AppliedForce f[3](at = {b[i].center for i in 1:3}, force = {{F[i], 0} for i in 1:3});
      output Force holding[3] = F;
    end Islands;""")
    apart, together = (model.simulate(at=[0.0, 0.3, 9.0], tolerance=1e-10, solver=solver) for solver in ("islands", "erk"))
    for k in (1, 2, 3):
        for name in (f"b[{k}].s", f"b[{k}].v", f"holding[{k}]"):
            np.testing.assert_allclose(apart[name], together[name], rtol=0, atol=1e-9)
        assert apart[f"holding[{k}]"][-1] == pytest.approx(30 * apart[f"b[{k}].s"][-1], abs=1e-12)


@pytest.mark.parametrize("version", ["2", "3"])
@pytest.mark.parametrize(("kind", "error"), [("CoSimulation", 1e-8), ("ModelExchange", 1e-6)])
@pytest.mark.parametrize(("text", "name", "stop"), [(stopping("sign"), "b.s", 10.0), (CRANK, "guide.s", 4.0)],
                         ids=["block", "crank"])
@pytest.mark.parametrize("rows", [20, 2000])
def test_fmus_stick(tmp_path: Path, version: str, kind: str, error: float, text: str, name: str, stop: float, rows: int) -> None:
    """Importers find by event indicators where it sticks and is torn off."""
    path, t = tmp_path / "scene.lag", np.linspace(0, stop, 21)
    path.write_text(text, encoding="utf-8")
    found = simulated(path, version, kind, [name], stop_time=stop, output_interval=stop / rows, relative_tolerance=1e-9)
    own = lag.load(path).simulate(at=t, tolerance=1e-11)[name]
    np.testing.assert_allclose(np.interp(t, found["time"], found[name]), own, rtol=0, atol=error)


def test_fmus_tell_of_their_switches(tmp_path: Path) -> None:
    """As many indicators as conditions, and the checker agrees with what is said of them."""
    path = tmp_path / "scene.lag"
    path.write_text(CRANK, encoding="utf-8")
    for version in ("2", "3"):
        fmu = tmp_path / f"scene{version}.fmu"
        lag.load(path).export_fmu(fmu, fmi=version)
        description = read_model_description(fmu)
        assert description.numberOfEventIndicators == 1
        assert "switch[1]" in [variable.name for variable in description.modelVariables]


def test_runs_of_a_sweep_stick(scene: Write) -> None:
    """A sixth of the mass swings sqrt(6) times as often, and stops at the same place."""
    sweep = scene(stopping("dissipation")).simulate_many(parameters={"b.m": [1 / 3, 2.0]}, stop=10.0, tolerance=1e-10)
    np.testing.assert_allclose(sweep["final(b.s)"], 0.05, rtol=0, atol=1e-9)


def test_a_sharp_valley(scene: Write) -> None:
    """A force that jumps with a place holds nothing: V = F |s| is a parabola to each side, of period 4 sqrt(2 m s/F)."""
    model = scene("""model Valley
      World world(gravity = {0, 0});
      Block b(m = 1, base = world, s(start = 1));
      GeneralSpring g(stretch = b.s, V = 3[N]*abs(b.s));
    end Valley;""")
    period = 4 * np.sqrt(2 / 3)
    run = model.simulate(at=[period / 4, period / 2, 10 * period], tolerance=1e-10)
    np.testing.assert_allclose(run["b.s"], [0, -1, 1], rtol=0, atol=1e-11)


# ---------------------------------------------------------------- stiff scenes

BRAKED = """model Braked "stiff damped shafts, and a brake that holds until the drive tears it off"
  Revolute axle[2]; Disc disc[2](each m = 1, each r = 0.1);
  TorsionSpringDamper shaft(k = 1e3, c = 100, a = axle[1].b, b = axle[2].b);
  TorsionDryFriction brake(tau = 3, a = world, b = axle[2].b);
  AppliedTorque drive(on = disc[1].center, torque = 5*sin(4*time));
equation
  for i in 1:2 loop connect(world, axle[i].a); connect(axle[i].b, disc[i].center); end for;
end Braked;"""

STIFF_TRAIN = """model Train "the brake slips a little when the drive is at its most"
  Revolute ax[4](each a = world);
  Disc d1(m = 1.8, r = 0.2, center = ax[1].b), d2(m = 1.3, r = 0.2, center = ax[2].b);
  Disc d3(m = 2.04, r = 0.2, center = ax[3].b), d4(m = 0.94, r = 0.2, center = ax[4].b);
  TorsionSpring s1(k = 5.741e8, a = ax[1].b, b = ax[2].b);
  TorsionSpringDamper s2(k = 2.641e8, c = 311.7, a = ax[2].b, b = ax[3].b), s3(k = 4077, c = 4.134, a = ax[3].b, b = ax[4].b);
  TorsionDryFriction f(tau = 0.117, a = ax[3].b, b = ax[2].b), brake(tau = 1.305, a = world, b = ax[3].b);
  AppliedTorque drive(on = d1.center, torque = 1.34*sin(2.08*time));
end Train;"""

CARRIED = """model Carried "a stiff light mass on a block that sticks to a belt, slips, and sticks again"
  Block block(m = 1, base = world), small(m = 0.01, base = block.center);
  Spring pull(stretch = block.s, k = 100);
  DryFriction belt(F = 5, rate = block.v - 0.3);
  SpringDamper stiff(stretch = small.s, k = 1e8, c = 100);
end Carried;"""

STANDING = """model Standing "a shaken weight comes to rest on the floor, with a stiff one on it"
  Prismatic y(a = world, along = {0, 1}, s(start = 0.1)), top(a = y.b, along = {0, 1});
  PointMass low(m = 1, center = y.b), small(m = 0.1, center = top.b);
  Stop floor(e = 0.5, gap = y.s);
  SpringDamper stiff(stretch = top.s, k = 1e8, c = 1000);
  AppliedForce F(at = low.center, force = {0, 6*sin(3*time)});
end Standing;"""


@pytest.mark.parametrize(("text", "name", "end", "work"), [
    (BRAKED, "axle[1].phi", 0.4844131584236, 30_000), (CARRIED, "block.s", 0.0315685586666, 20_000),
    (STANDING, "top.s", -9.81e-9, 20_000)], ids=["braked", "carried", "standing"])
@pytest.mark.parametrize("solver", ["auto", "implicit"])
@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-8])
def test_stiff_scenes_slide(text: str, name: str, end: float, work: int, solver: str, tolerance: float, scene: Write) -> None:
    """In implicit steps; explicit ones take half a million evaluations. References: implicit at 1e-10 and 1e-12, which agree."""
    run = scene(text).simulate(stop=5, interval=1, tolerance=tolerance, solver=solver)
    assert abs(run[name][-1] / end - 1) < 10 * tolerance + 1e-9
    assert run.statistics.rhs_evaluations < work
    assert run.statistics.implicit_steps > 50


@pytest.mark.parametrize("tolerance", [1e-5, 1e-8])
def test_errors_of_stages_are_no_sizes(tolerance: float, scene: Write) -> None:
    """A step that is too long by far for an explicit method ends anywhere: accelerations there tell nothing about rounding."""
    run = scene(BRAKED).simulate(stop=2, interval=1, tolerance=tolerance, solver="erk")
    reference = scene(BRAKED).simulate(stop=2, interval=1, tolerance=1e-10, solver="implicit")
    np.testing.assert_allclose(run["axle[1].phi"], reference["axle[1].phi"], rtol=1e-3 if tolerance == 1e-5 else 1e-7)


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-7])
def test_a_slip_begins_inside_a_long_step(tolerance: float, scene: Write) -> None:
    """Where friction holds, an implicit step may take a second, and the force that holds is not told by its dense output: springs
    of 1e8 make much of errors within the tolerance. What slips one way in the first half slips back in the second."""
    for solver in ("auto", "implicit"):
        run = scene(STIFF_TRAIN).simulate(at=[1.5, 3.0], tolerance=tolerance, solver=solver)
        np.testing.assert_allclose(run["ax[3].phi"], [0.007860224, 0], rtol=1e-5, atol=1e-8)


TURNED = """model Turned "A wall that turns round carries a box back over a rough floor, which carries a second one"
  parameter Force F = 0.5;
  Prismatic wall(a = world); Motion d(of = wall.s, to = 0.1*sin(5*time));
  Block box(m = 2, base = world, s(start = -0.001), v(start = 1)), other(m = 1, base = world, s(start = -0.04));
  DryFriction floor(F = F, rate = box.v), floor2(F = 0.7*F, rate = other.v);
  Stop stop(along = {-1, 0}, a = wall.b, b = box.center), between(along = {-1, 0}, a = box.center, b = other.center);
end Turned;"""
LEVER = """model Lever "A cam lifts a lever and lowers it again; its bearing rubs"
  parameter Torque tau = 0.5;
  Prismatic cam(a = world, along = {0, 1}); Motion d(of = cam.s, to = 0.1*sin(3*time));
  Revolute h(a = world, phi(start = 0.3)); Bar bar(m = 2, L = 1, a = h.b);
  TorsionDryFriction f(tau = tau, a = world, b = h.b);
  Stop s(a = cam.b, b = shift(h.b, {0.5, 0}));
end Lever;"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_friction_gives_way_to_what_a_contact_prescribes(scene: Write, solver: str) -> None:
    """Where the wall turns round, its contact and friction hold the same rate: one of them cannot. Nor where the lever does,
    whose weight is more than its friction by enough to follow the cam."""
    boxes, lever = scene(TURNED), scene(LEVER)
    for share in np.linspace(0.05, 1, 12):
        run = boxes.simulate(at=[0.6], tolerance=1e-9, solver=solver, parameters={"F": 4.4 * share})
        np.testing.assert_allclose(run["box.s"], 0.1 * np.sin(3), rtol=0, atol=1e-9)
        run = lever.simulate(at=[0.7, 1.2], tolerance=1e-9, solver=solver, parameters={"tau": 6 * share})
        np.testing.assert_allclose(np.sin(run["h.phi"]), 0.2 * np.sin([2.1, 3.6]), rtol=0, atol=1e-8)
