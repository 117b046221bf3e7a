"""Supports and prescribed coordinates whose rate jumps: momentum stays, but for the impulses of what holds the scene."""

import math
from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

Scene = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "adams", "taylor", "implicit", "linear", "casadi:cvodes")

FREE = """model Free "nothing acts on a mass that is told in the frame of a table pushed by a ramp"
  World world(gravity = {0, 0});
  Frame table = shift(world, {0.5*ramp(time, 1, 1), 0});
  Block mass(m = 2, base = table, v(start = 0.25));
  output Length x = mass.center.x;
  annotation(experiment(StopTime = 3));
end Free;"""

PENDULUM = """model Driven "a pendulum on a slider that goes to and fro along straight lines"
  Prismatic slider(a = world); Motion motion(of = slider.s, to = table(time, {0, 1, 2}, {0, 0.5, 0}));
  Revolute hinge(a = slider.b); PointMass ball(m = 3, center = shift(hinge.b, {0, -1}));
  annotation(experiment(StopTime = 3, Tolerance = 1e-11));
end Driven;"""

ROD = """model Rod "a pendulum whose rod grows, held by a constraint"
  PointMass ball(m = 2, center(x(start = 0.6), y(start = -0.8)));
equation
  distance(world, ball.center) = 1[m] + 0.2[m]*ramp(time, 1, 1);
  annotation(experiment(StopTime = 3, Tolerance = 1e-11));
end Rod;"""
POLAR = """model Polar "the same without a constraint"
  Revolute hinge(a = world, phi(start = -0.9272952180016123));
  Prismatic rod(a = hinge.b); Motion motion(of = rod.s, to = 1[m] + 0.2[m]*ramp(time, 1, 1));
  PointMass ball(m = 2, center = rod.b);
  annotation(experiment(StopTime = 3, Tolerance = 1e-11));
end Polar;"""


@pytest.mark.parametrize("solver", SOLVERS)
def test_a_free_mass_does_not_mind_the_frame_it_is_told_in(solver: str, scene: Scene) -> None:
    run = scene(FREE).simulate(solver=solver, at=[0.0, 0.5, 1.5, 2.5, 3.0], tolerance=1e-10)
    assert run["x"] == pytest.approx(0.25 * run.time, abs=1e-9)
    assert run["der(mass.s)"] == pytest.approx([0.25, 0.25, -0.25, 0.25, 0.25], abs=1e-9)
    assert np.abs(run.energy.residual).max() < 1e-9
    assert run.energy.work == pytest.approx(0.0, abs=1e-9)


def test_carts_at_a_prescribed_distance_keep_their_momentum(scene: Scene) -> None:
    run = scene("""model Carts
  World world(gravity = {0, 0});
  Block a(m = 1, base = world, s(start = 0, fixed = true)), b(m = 3, base = world);
equation
  b.s - a.s = 1[m] + table(time, {0, 1, 2}, {0, 1, 1});
initial equation
  a.v = 0;
  annotation(experiment(StopTime = 2));
end Carts;""").simulate(at=[0.5, 1.5, 2.0])
    assert run["der(a.s)"] == pytest.approx([0.0, 0.75, 0.75], abs=1e-12)
    assert run["b.s"] - run["a.s"] == pytest.approx([1.5, 2.0, 2.0], abs=1e-12)
    assert run.energy.work == pytest.approx([0.0, -0.375, -0.375], abs=1e-12)  # the tie takes 3/2 - 9/8 J
    assert np.abs(run.energy.residual).max() < 1e-12


@pytest.mark.parametrize("solver", ["erk", "taylor", "implicit"])
def test_a_pendulum_on_a_slider_beside_a_rounded_corner(solver: str, scene: Scene) -> None:
    """A corner is the limit of round ones, which are so far from it as they are wide."""
    times = [0.5, 1.25, 1.75, 2.5, 3.0]
    sharp = scene(PENDULUM).simulate(solver=solver, at=times)["hinge.phi"]
    errors = []
    for w in (1e-3, 1e-4):
        x = "(time/1[s])"
        rounded = f"1[m]*(0.25*{x} - 0.5*sqrt(({x} - 1)^2 + {w}^2) + 0.25*sqrt(({x} - 2)^2 + {w}^2))"
        model = scene(PENDULUM.replace("table(time, {0, 1, 2}, {0, 0.5, 0})", rounded))
        errors.append(np.abs(model.simulate(solver="erk", at=times, max_step=1e-3)["hinge.phi"] - sharp).max())
    assert errors[0] < 0.01
    assert errors[1] < 0.15 * errors[0]


@pytest.mark.parametrize("solver", ["erk", "erk5", "implicit"])
def test_a_constraint_whose_rate_jumps_gives_the_impulse_along_itself(solver: str, scene: Scene) -> None:
    times = [0.5, 1.5, 2.5, 3.0]
    held = scene(ROD).simulate(solver=solver, at=times)
    free = scene(POLAR).simulate(solver="erk", at=times)
    r, phi, w = free["rod.s"], free["hinge.phi"], free["der(hinge.phi)"]
    assert held["ball.center.x"] == pytest.approx(r * np.cos(phi), abs=1e-9)
    assert held["ball.center.y"] == pytest.approx(r * np.sin(phi), abs=1e-9)
    rate = np.array([0.0, 0.2, 0.0, 0.0])
    assert held["der(ball.center.x)"] == pytest.approx(rate * np.cos(phi) - r * w * np.sin(phi), abs=1e-9)
    for run in (held, free):
        assert np.abs(run.energy.residual).max() < 1e-8
    assert held.energy.work == pytest.approx(free.energy.work, abs=1e-8)


def test_angular_momentum_stays_where_a_rod_begins_to_grow(scene: Scene) -> None:
    run = scene(POLAR.replace("Revolute hinge(", "World world(gravity = {0, 0});\n  Revolute hinge(w(start = 2), ")).simulate()
    L = 2 * run["rod.s"] ** 2 * run["der(hinge.phi)"]
    assert pytest.approx(4.0, rel=1e-10) == L


def test_islands_and_batches_take_impulses(scene: Scene) -> None:
    model = scene(PENDULUM.replace("Revolute hinge(", "Block apart(m = 1, base = slider.b, along = {0, 1}); "
                                                      "Spring spring(k = 1e4, stretch = apart.s - 0.1[m]);\n  Revolute hinge("))
    assert model.scene.islands
    at = [1.5, 3.0]
    apart, whole = (model.simulate(solver=solver, at=at, tolerance=1e-11)["hinge.phi"] for solver in ("islands", "erk"))
    assert apart == pytest.approx(whole, abs=1e-9)
    assert abs(whole[0]) > 0.3
    sweep = model.simulate_many(parameters={"ball.m": [3.0, 5.0]}, outputs=["at(1.5, hinge.phi)"], tolerance=1e-11)
    assert np.asarray(sweep["at(1.5, hinge.phi)"]) == pytest.approx(whole[0], abs=1e-9)


def test_a_mass_that_is_halved_at_once_keeps_its_momentum(scene: Scene) -> None:
    """As Lagrange's equation has it: d(m v)/dt = 0."""
    run = scene("""model Halved
  coordinate Length x(start = 0); coordinate Length y(start = 0);
energy
  kinetic 1[kg]*(if time < 1 then 2 else 1)*der(x)^2/2 + 1[kg]*der(y)^2/2;
initial equation
  der(x) = 1;
  annotation(experiment(StopTime = 2));
end Halved;""").simulate(at=[0.5, 1.5])
    assert run["der(x)"] == pytest.approx([1.0, 2.0], abs=1e-12)
    assert math.isclose(run["x"][-1], 2.0, abs_tol=1e-12)

ROAD = """model Road "a mass on a spring and a damper over a road that {how}"
  World world(gravity = {{0, 0}});
  Frame road = shift(world, {{0, 0.05*{law}}});
  Block b(m = 2, base = world, along = {{0, 1}});
  AxialSpring  spring(a = road, b = b.center, k = 300, along = {{0, 1}});
  AxialDamper  damper(a = road, b = b.center, c = 5, along = {{0, 1}});
end Road;"""
PUSHED = """model Pushed "the same by a prescribed coordinate that no mass moves with, and in a loop of tie and lever"
  World world(gravity = {{0, 0}});
  coordinate Length x; Motion motion(of = x, to = 0.05*{law});
  Block b(m = 2, base = world);
  SpringDamper spring(k = 300, c = 5, stretch = b.s - x);
end Pushed;"""
RAMP = "ramp(time, 1, 1e-7)"
AFTER = np.array([0.9, 1.1, 1.3, 2.0])


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("text", [ROAD, PUSHED])
def test_a_damper_on_a_support_that_jumps_gives_an_impulse(text: str, solver: str, scene: Scene) -> None:
    """c times the way: the limit of ever steeper ramps."""
    jumps, glides = (scene(text.format(law=law, how="steps")) for law in ("step(time - 1)", RAMP))
    found, limit = (model.simulate(solver=which, at=AFTER, tolerance=1e-10)
                    for model, which in ((jumps, solver), (glides, "implicit")))
    assert found["b.s"] == pytest.approx(limit["b.s"], abs=1e-7)
    assert np.abs(found.energy.residual).max() < 1e-8


def test_an_impulse_of_a_slanted_damper_goes_along_it(scene: Scene) -> None:
    """And the direction is the mean of those before and after the jump."""
    model = scene("""model Slanted World world(gravity = {0, 0}); Frame post = shift(world, {0.3*pulse(time, 1, 1), 0});
      PointMass p(m = 2, center(x(start = 3), y(start = 4)));
      GeneralDamper d(rate = (p.center.v[1] - post.v[1])*0.6 + (p.center.v[2] - post.v[2])*0.8, D = 0.5*4[N.s/m]*d.rate^2);
    end Slanted;""")
    run = model.simulate(at=[0.5, 1 + 1e-9], tolerance=1e-10)
    assert run["der(p.center.x)"][-1] == pytest.approx(4 * 0.18 / 2 * 0.6, abs=1e-7)
    assert run["der(p.center.y)"][-1] == pytest.approx(4 * 0.18 / 2 * 0.8, abs=1e-7)


@pytest.mark.parametrize("law", ["ramp(time, 1, 0.5)", "table(time, {0, 0.5, 1, 1.7}, {0, 1, -1, 0.3})", "mod(time, 0.5[s])/1[s]",
                                 "abs(time/1[s] - 1)", "min(time/1[s], 1)", "max(time/1[s] - 1, 0)"])
def test_what_bends_without_a_jump_gives_no_impulse_of_dampers(law: str, scene: Scene) -> None:
    rates = scene(ROAD.format(law=law, how="bends")).simulate(at=[1 - 1e-9, 1 + 1e-9], tolerance=1e-11)["der(b.s)"]
    jump = -5 * 0.05 * 0.5 / 2 if "mod" in law else 0.0
    assert rates[1] - rates[0] == pytest.approx(jump, abs=1e-7)


def test_an_impulse_is_known_to_islands(scene: Scene) -> None:
    """The jump stands in no equation of its own: the damper knows the rate of the road alone."""
    text = """model Apart World world(gravity = {{0, 0}}); Frame road = shift(world, {{0, 0.05*{law}}});
      Block b(m = 2, base = world, along = {{0, 1}}); AxialDamper d(a = road, b = b.center, c = 5, along = {{0, 1}});
      Block o(m = 1, base = world, s(start = 1)); DuffingSpring s(k = 1e4, k3 = 1e4, stretch = o.s); end Apart;"""
    jumps, glides = (scene(text.format(law=law)) for law in ("step(time - 1)", RAMP))
    runs = ((jumps, "islands"), (glides, "erk"))
    found, limit = (model.simulate(solver=solver, at=AFTER, tolerance=1e-10) for model, solver in runs)
    assert found["b.s"] == pytest.approx(limit["b.s"], abs=1e-7)
    assert found["b.s"][-1] > 0.01


BENDS = {  # the way of a support, and where what it carries freely is at 0.5, 1.25, 1.5 and 2.5 s
    "0.3*abs(time/1[s] - 1) - 0.3": [-0.15, -0.375, -0.45, -0.75],
    "max(0, min(0.1, 0.3*(time/1[s] - 1)))": [0, 0, 0, 0],
    "0.1*abs(sin(2*time/1[s]))": [0.1, 0.25, 0.3, 0.5],
}


@pytest.mark.parametrize("way", BENDS)
def test_a_support_whose_rate_bends_takes_nothing_along_that_slides_on_it(way: str, scene: Scene) -> None:
    model = scene(f"model M Prismatic x(a = world), r(a = x.b); PointMass p(m = 1, center = r.b); output Length X = p.center.x; "
                  f"equation x.s = {way}; end M;")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.5, 1.25, 1.5, 2.5], solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["X"], BENDS[way], rtol=0, atol=1e-8, err_msg=solver)


def test_a_support_whose_rate_bends_pulls_on_its_rod(scene: Scene) -> None:
    model = scene("model M Prismatic x(a = world, along = {0, 1}); PointMass q(m = 1); Link l(a = x.b, b = q.center, L = 1); "
                  "equation x.s = 0.3*abs(time/1[s] - 1); initial equation q.center.x = 0; q.center.y = -0.7; end M;")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.5, 1.5, 2.5], solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["q.center.y"], [-0.85, -0.85, -0.55], rtol=0, atol=1e-9, err_msg=solver)


S = "(time/1[s])"
FREE_SLIDER = ("model M {}Prismatic x(a = world), r(a = x.b); PointMass p(m = 1, center = r.b); equation x.s = {}; "
               "annotation(experiment(StopTime = 35)); end M;")
CURVED = {  # and where the free slider is relative to the support: it goes on as the support began
    f"max(0, 0.1*({S}^2 - c))": [0, -0.3],
    f"max(0, 0.1*(({S} + 1)^3 - 4 - 4*c)/19)": [0, -0.1],
    f"0.1*abs(({S} - c)*({S} + 5))": [0.025, -1.0],
    f"min(0.1*exp({S} - c), 0.1)": [0.1 * (-math.exp(-0.5) + 1.5 * math.exp(-1)), 0.3 * math.exp(-1) - 0.1],
    f"(if time < 1 then 0.1*{S} else 0.1) + 0.1*max(0, {S}^2 - 1)^2": [0, -0.8],
    f"min(c*10, 0.1*{S}^2)": [-0.025, -0.4],
}


@pytest.mark.parametrize("way", CURVED)
def test_rates_jump_where_curves_of_time_turn(way: str, scene: Scene) -> None:
    """Also where parameters of the run say when, and long after what is looked at beforehand."""
    model = scene(FREE_SLIDER.format("parameter Real c = 900; ", way))
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.5, 2.0], parameters={"c": 1}, solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["r.s"], CURVED[way], rtol=0, atol=1e-8, err_msg=solver)


def test_a_rate_that_jumps_at_an_unknown_time_is_refused(scene: Scene) -> None:
    """Its square does not jump; a sum of two sines is 0 at such times. It is not asked for where the run does not come."""
    sines = f"0.1[m]*max(0, sin({S}) + 0.5*sin(3*{S})){{}}"
    with pytest.raises(lag.LagError, match="L0914"):
        scene(FREE_SLIDER.format("", sines.format(""))).simulate(stop=1)
    assert scene(FREE_SLIDER.format("", sines.format("^2"))).simulate(at=[0.0], tolerance=1e-9)["x.s"][0] == 0
    early = FREE_SLIDER.format("", sines.format("")).replace("35", "2")
    assert scene(early).simulate(at=[0.5]).time[0] == 0.5


def test_a_light_slider_beside_a_heavy_body_is_kicked_at_an_unknown_time(scene: Scene) -> None:
    text = FREE_SLIDER.format("Block heavy(m = 1000, base = world); Spring f(a = p.center, b = heavy.center, k = 1e-12); ",
                              f"0.1*max(0, sin({S}) + 0.5*sin(3*{S}))")
    with pytest.raises(lag.LagError, match="L0914"):
        scene(text.replace("m = 1,", "m = 1e-9,")).simulate(stop=1)


def test_a_support_by_an_input_that_bends_is_no_time_that_is_looked_for(scene: Scene) -> None:
    text = "model M input Real u; Frame f = shift(world, {%s, 0}); Prismatic r(a = f); PointMass p(m = 1, center = r.b); end M;"
    run = scene(text % f"max(0, u)*1[m] + 0.1[m]*max(0, (sin({S}) + 0.5*sin(3*{S})))^2").simulate(inputs={"u": 0.5}, at=[0.5])
    assert run["p.center.x"][0] == pytest.approx(0.5, abs=1e-9)
