"""Events that reset rates: impacts, what comes to rest at them, and kicks."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.base.diagnostics import RunError
from lagrangia.command.scene_export import export
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "taylor", "erk", "erk5", "adams", "implicit")
G = 9.81

BALL = """model Ball
  parameter Real e = 0.8;
  Prismatic p(a = world, along = {0, 1}, s(start = 1));
  PointMass ball(m = 2, center = p.b);
equation
  when p.s < 0 then reinit(der(p.s), -e*pre(der(p.s))); end when;
end Ball;"""


def bounces(t: np.ndarray, e: float) -> tuple[np.ndarray, np.ndarray]:
    """A ball falls from 1 m: parabolas until they have no height."""
    begin, u = np.sqrt(2 / G), e * np.sqrt(2 * G)
    place, rate = 1 - G * t**2 / 2, -G * t
    while u > 1e-14 and begin <= t[-1]:
        now = t >= begin
        place[now], rate[now] = u * (t[now] - begin) - G * (t[now] - begin) ** 2 / 2, u - G * (t[now] - begin)
        begin, u = begin + 2 * u / G, e * u
    rests = t >= begin if u <= 1e-14 else t > t[-1]
    place[rests] = rate[rests] = 0
    return place, rate


def test_flights_that_are_cubics_are_not_looked_at_twice(scene: Write) -> None:
    """A parabola is one from its beginning to an impact as well, and what is foreseen by iterations has settled at once: 22.5
    accelerations an impact, where it was seen anew and iterated on 26.5."""
    run = scene(BALL).simulate(at=[6.0], tolerance=1e-8, parameters={"e": 0.9})
    assert run.statistics.events > 9
    assert run.statistics.rhs_evaluations < 23 * run.statistics.events


@pytest.mark.parametrize("e", [0.0, 0.5, 0.8, 0.95, 1.0])
@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
def test_a_ball_bounces_until_it_rests(scene: Write, e: float, solver: str, tolerance: float) -> None:
    """Through infinitely many bounces, at 4.06 s where e = 0.8."""
    t = np.linspace(0, 5, 501)[1:] - 1e-3
    run = scene(BALL).simulate(at=t, tolerance=tolerance, solver=solver, parameters={"e": e})
    place, rate = bounces(t, e)
    np.testing.assert_allclose(run["p.s"], place, rtol=0, atol=1e-11)
    np.testing.assert_allclose(run["der(p.s)"], rate, rtol=0, atol=1e-10)
    assert run.statistics.events < 130
    assert run.statistics.rhs_evaluations < 15_000
    lost = 2 * G * (1 - place[-1]) - rate[-1] ** 2
    assert run.energy.dissipated[-1] == pytest.approx(lost, abs=1e-10)
    assert np.abs(run.energy.residual).max() < 1e-11


CRADLE = """model Cradle
  parameter Integer n = 5;  parameter Real e = 1;
  World world(gravity = {0, 0});
  Prismatic p[n](each a = world, each along = {1, 0});
  PointMass ball[n](each m = 0.3, center = {p[i].b for i in 1:n});
  Stop stop[n-1](each e = e, gap = {p[i+1].s - p[i].s for i in 1:n-1});
end Cradle;"""


@pytest.mark.parametrize("coming", [1, 2, 3])
@pytest.mark.parametrize("solver", SOLVERS)
def test_newtons_cradle(scene: Write, coming: int, solver: str) -> None:
    """As many balls leave as come."""
    start = {f"p[{k}].s": -1.0 for k in range(1, coming + 1)} | {f"der(p[{k}].s)": 1.0 for k in range(1, coming + 1)}
    run = scene(CRADLE).simulate(at=[3.0], solver=solver, initial=start)
    rates = [run[f"der(p[{k}].s)"][-1] for k in range(1, 6)]
    np.testing.assert_allclose(rates, [0] * (5 - coming) + [1] * coming, rtol=0, atol=1e-12)


@pytest.mark.parametrize("e", [0.0, 0.3])
def test_a_cradle_that_loses_energy_keeps_its_momentum(scene: Write, e: float) -> None:
    run = scene(CRADLE).simulate(at=[3.0], parameters={"e": e}, initial={"p[1].s": -1.0, "der(p[1].s)": 1.0})
    rates = np.array([run[f"der(p[{k}].s)"][-1] for k in range(1, 6)])
    assert rates.sum() == pytest.approx(1, abs=1e-13)
    assert (np.diff(rates) > -1e-9).all()
    if e == 0:
        np.testing.assert_allclose(rates, 0.2, rtol=0, atol=1e-9)


@pytest.mark.parametrize(("ratio", "count"), [(1, 3), (100, 31), (1e4, 314), (1e6, 3141)])
def test_collisions_count_the_digits_of_pi(scene: Write, ratio: float, count: int) -> None:
    """G. Galperin, Playing pool with pi, Regular and Chaotic Dynamics 8 (2003)."""
    model = scene(f"""model Pi
      World world(gravity = {{0, 0}});
      Prismatic small(a = world, along = {{1, 0}}, s(start = 1)), large(a = world, along = {{1, 0}}, s(start = 2), v(start = -1));
      PointMass m(m = 1, center = small.b), M(m = {ratio}, center = large.b);
      Stop wall(e = 1, gap = small.s), hit(e = 1, gap = large.s - small.s);
    end Pi;""")
    run = model.simulate(stop=10)
    assert run.statistics.events == count
    kinetic = run["der(small.s)"][-1] ** 2 + ratio * run["der(large.s)"][-1] ** 2
    assert kinetic == pytest.approx(ratio, rel=1e-12)


def test_a_free_bar_is_struck_at_its_end(scene: Write) -> None:
    """An impulse J at the end changes its rate by J (1/m + (L/2)^2/I) = 4 J/m: v = u/4 of the centre, w = 3 u/(2 L)."""
    run = scene("""model Struck
      World world(gravity = {0, 0});
      Planar free(a = world);  Bar bar(m = 3, L = 0.5, center = free.b);
    equation
      when time > 1 then reinit(bar.b.v[2], 2); end when;
    end Struck;""").simulate(at=[0.5, 1.0, 2.0])
    np.testing.assert_allclose(run["der(free.y)"], [0, 0, 0.5], rtol=0, atol=1e-14)
    np.testing.assert_allclose(run["der(free.phi)"], [0, 0, 6], rtol=0, atol=1e-13)
    assert run.energy.work[-1] == pytest.approx(3 * 0.5**2 / 2 + 3 * 0.5**2 / 12 * 6**2 / 2, rel=1e-12)


FOUR_BAR = """model Stopped "a four-bar whose rocker strikes a stop"
  Revolute h[4](a = {world, crank.b, coupler.b, shift(world, {2, 0})}, phi(start = {1.5, -1.2, 0, 1.7}));
  Bar crank(m = 1, L = 1, a = h[1].b), coupler(m = 1, L = 2, a = h[2].b), rocker(m = 1, L = 1.5, a = h[4].b);
  Stop stop(e = 0.5, gap = 2.6[m] - rocker.b.x);
  output Velocity nearing = der(stop.gap);
equation
  connect(h[3].b, rocker.b);
end Stopped;"""


@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
def test_the_rates_of_a_linkage_turn_together(scene: Write, solver: str) -> None:
    """With one degree of freedom all are multiplied with -e, and the loop stays closed."""
    model, begin, width = scene(FOUR_BAR), 0.0, 2.0
    for _ in range(2):  # the hardest stroke, ever closer
        run = model.simulate(at=np.linspace(begin, begin + width, 2001), solver=solver, tolerance=1e-10)
        k = int(np.argmax(np.diff(run["nearing"])))
        begin, width = run.time[k], run.time[k + 1] - run.time[k]
    factors = [run[f"der(h[{i}].phi)"][k + 1] / run[f"der(h[{i}].phi)"][k] for i in (1, 2, 4)]
    np.testing.assert_allclose(factors, -0.5, rtol=1e-5)
    assert run.statistics.constraint_rate_residual < 1e-12
    assert np.abs(run.energy.residual).max() < 1e-8


SHAKEN = """model Shaken
  parameter Real e = 0;  parameter AngularFrequency w = 12;  parameter Length A = 0.1;
  Prismatic p(a = world, along = {0, 1});  PointMass ball(m = 0.1, center = p.b);
  Length table = A*sin(w*time);
  Stop stop(e = e, gap = p.s - table);
  output Length gap = stop.gap;
end Shaken;"""


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-5, 1e-9])
def test_a_table_lets_go_where_it_falls_faster(scene: Write, solver: str, tolerance: float) -> None:
    """At A w^2 sin(w t) = g, and not before."""
    w = 12.0
    t = np.arcsin(G / (0.1 * w**2)) / w
    y, v = 0.1 * np.sin(w * t), 0.1 * w * np.cos(w * t)
    at = np.array([t / 2, t, t + 0.02, t + 0.05])
    run = scene(SHAKEN).simulate(at=at, solver=solver, tolerance=tolerance, initial={"der(p.s)": 0.1 * w})
    expected = np.where(at <= t, 0.1 * np.sin(w * at), y + v * (at - t) - G * (at - t) ** 2 / 2)
    np.testing.assert_allclose(run["p.s"], expected, rtol=0, atol=max(tolerance, 1e-11))
    whole = scene(SHAKEN).simulate(stop=20, interval=0.003, solver=solver, tolerance=tolerance, parameters={"e": 0.4})
    assert whole["gap"].min() > -tolerance
    assert whole.statistics.rhs_evaluations < 250_000


def test_bounces_that_times_cannot_tell_end_on_a_shaken_table(scene: Write) -> None:
    """The last ones are lower than what the table moves by from one time to the next."""
    model = scene(SHAKEN)
    runs = {"e": [0.37844675011918316, 0.3434500741910351, 0.4757449705891207],
            "A": [0.017479451409174805, 0.01706672926248869, 0.010742185966004071],
            "w": [31.241981979723757, 31.696830188442757, 63.198709113972846],
            "p.s": [0.23827155562328348, 0.06359187840682955, 0.2617381211970584]}
    for tolerance in (1e-6, 1e-8, 1e-10):
        found = model.simulate_many(runs=runs, stop=3, tolerance=tolerance, progress=False)
        assert not found.failures


def test_what_rests_is_held_for_long(scene: Write) -> None:
    """A bar with two corners on the floor, drawn to and fro: x'' = 1.5 sin 2 t, from x' = 0."""
    run = scene("""model Held
      Planar free(a = world, y(start = 0.1));  Bar bar(m = 2, L = 1, center = free.b);
      AppliedForce F(at = bar.center, force = {3*sin(2*time), 0});
      Stop left(e = 0.3, a = world, b = bar.a), right(e = 0.3, a = world, b = bar.b);
    end Held;""").simulate(at=[1e3, 1e4], tolerance=1e-9)
    np.testing.assert_allclose(run["free.x"], [0.75 * t - 0.375 * np.sin(2 * t) for t in (1e3, 1e4)], rtol=1e-8)
    np.testing.assert_allclose(run["free.y"], 0, rtol=0, atol=1e-8)
    np.testing.assert_allclose(run["der(free.y)"], 0, rtol=0, atol=1e-10)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_a_stack_comes_to_rest(scene: Write, solver: str, tolerance: float) -> None:
    """Through bounces of bounces: the same by all solvers, and nothing passes another."""
    model = scene("""model Stack
      Prismatic p[3](each a = world, each along = {0, 1}, s(start = {0.6, 0.7, 0.8}));
      PointMass m[3](m = {3, 2, 1}, center = {p[i].b for i in 1:3});
      Stop floor(e = 0.6, gap = p[1].s), on[2](each e = 0.6, gap = {p[i+1].s - p[i].s for i in 1:2});
    end Stack;""")
    run = model.simulate(at=[0.5, 0.8, 0.9, 5.0], tolerance=tolerance, solver=solver)
    places = np.array([run[f"p[{k}].s"] for k in (1, 2, 3)])
    np.testing.assert_allclose(places[:, 1], [7.12430147e-4, 1.843035187e-3, 3.153292675e-3], rtol=0, atol=10 * tolerance)
    np.testing.assert_allclose(places[:, 3], 0, rtol=0, atol=10 * tolerance)
    assert run.statistics.rhs_evaluations < 120_000


TRAIN = """model Train
  Prismatic p[5](each a = world, each along = {1, 0},
              s(start = {0, 1.4072, 1.9072, 2.4072, 3.7046}), v(start = {1.152, 0, -1.812, 1.381, -1.089}));
  PointMass b[5](each m = 1, center = p.b);
  Spring spring(k = 263.889, stretch = p[4].s - 0.36);
  Stop stop[4](each e = 0.565, gap = {p[i+1].s - p[i].s - 0.5 for i in 1:4});
end Train;"""


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_what_has_left_is_seen_to_return_while_others_strike(scene: Write, solver: str, tolerance: float) -> None:
    """Bounces of 1 um and 0.1 ms, beside steps of 0.1 s; twenty of a train of three bring it together."""
    run = scene(TRAIN).simulate(at=np.linspace(0, 1.5, 20_001), tolerance=tolerance, solver=solver)
    assert min(run[f"stop[{k}].gap"].min() for k in range(1, 5)) > -1e-12
    np.testing.assert_allclose([run[f"p[{k}].s"][-1] for k in range(1, 6)],
                               [-20.9578447, -20.4578447, -19.9578447, -0.2179115, 2.0711], rtol=0, atol=3e-6)


TWO = """model Two "beside each other: the lower one lands while the other one bounces"
  parameter Length lead = 0.1;
  Prismatic p[2](each a = world, each along = {0, 1}, s(start = {1 + lead, 1}), v(start = {0, 0}));
  PointMass b[2](each m = 1, center = p.b);
  Stop stop[2](each e = 0.5, gap = p.s);
end Two;"""


@pytest.mark.parametrize("lead", [0, 1e-9, 1e-6, 0.1])
def test_the_first_of_several_contacts_in_a_step_is_found(lead: float, scene: Write) -> None:
    """Also where the next one follows within rounding of positions, or at once; a landing ends the fall of one of them alone."""
    run = scene(TWO).simulate(at=np.linspace(0, 1, 101), tolerance=1e-9, parameters={"lead": lead})
    for k, height in ((1, 1 + lead), (2, 1.0)):
        t = run.time
        landing = np.sqrt(2 * height / G)
        up = 0.5 * G * landing
        bounced = np.where(t < landing, height - G * t**2 / 2, up * (t - landing) - G * (t - landing)**2 / 2)
        first = t < landing + 2 * up / G
        np.testing.assert_allclose(run[f"p[{k}].s"][first], bounced[first], rtol=0, atol=1e-13)
        assert run[f"p[{k}].s"].min() > -1e-13


@pytest.mark.parametrize(("y", "v", "end"), [(0, 0, 0), (-1e-17, 0, 0), (1e-16, 0, 0), (0, -1, 0), (-0.1, 0, -0.1 - G / 2)])
def test_starts_at_a_contact(scene: Write, y: float, v: float, end: float) -> None:
    """What begins on the far side stays there, as no event comes: the run says so."""
    run = scene(BALL).simulate(at=[1.0], parameters={"e": 0.5}, initial={"p.s": y, "der(p.s)": v})
    assert run["p.s"][-1] == pytest.approx(end, abs=1e-12)
    told = ["scene.lag:6:3) is passed at the start already" in text for text in run.warnings]
    assert told == [True] * (y < -0.01)


KICKS = {
    "slower": ("when x.s > 1 then reinit(der(x.s), 0.5*pre(der(x.s))); end when;", {"x.s": 2.5, "der(x.s)": 1}),
    "the same": ("when x.s > 1 then reinit(der(x.s), pre(der(x.s))); end when;", {"x.s": 4, "der(x.s)": 2}),
    "faster": ("when x.s > 1 then reinit(der(x.s), 2*pre(der(x.s))); end when;", {"x.s": 7, "der(x.s)": 4}),
    "given": ("when x.s >= 1 then reinit(der(x.s), -1); end when;", {"x.s": -0.5, "der(x.s)": -1}),
    "another": ("when x.s > 1 then reinit(y.v, 3); end when;", {"x.s": 4, "y.s": 4.5}),
    "both": ("when x.s > 1 then reinit(y.v, pre(x.v)); reinit(x.v, pre(y.v)); end when;", {"x.s": 1, "y.s": 3}),
    "at a time": ("when time > 1.5 then reinit(der(y.s), 2); end when;", {"x.s": 4, "y.s": 1}),
    "either side": ("when abs(x.s) > 1 then reinit(der(x.s), -pre(der(x.s))); end when;", {"x.s": 0, "der(x.s)": 2}),
    "in chains": ("when x.s > 1 then reinit(y.v, 1); end when; when y.v > 0.5 then reinit(x.v, -1); end when;",
                  {"x.s": -0.5, "y.s": 1.5}),
    "neither": ("when not (x.s < 1) and y.s > 1 then reinit(x.v, 0); end when;", {"x.s": 4}),
    "no more": ("when x.s > 1 or time > 1 then reinit(x.v, 0); end when;", {"x.s": 1, "der(x.s)": 0}),
}


@pytest.mark.parametrize("kick", KICKS)
@pytest.mark.parametrize("solver", SOLVERS)
def test_kicks(scene: Write, kick: str, solver: str) -> None:
    """A mass that moves with 2 m/s, 2 s later."""
    text, expected = KICKS[kick]
    run = scene(f"""model Kicked
      World world(gravity = {{0, 0}});
      Prismatic x(a = world, along = {{1, 0}}, v(start = 2)), y(a = x.b, along = {{0, 1}});
      PointMass m(m = 0.7, center = y.b);
    equation
      {text}
    end Kicked;""").simulate(at=[2.0], solver=solver)
    for name, value in expected.items():
        assert run[name][-1] == pytest.approx(value, abs=1e-10), name


def test_velocities_make_events(scene: Write) -> None:
    """x'' = 1 back to rest whenever it is 1 m/s: half a metre a second."""
    for solver in SOLVERS:
        run = scene("""model Saw
          Prismatic x(a = world, along = {1, 0});  PointMass m(m = 2, center = x.b);
          AppliedForce F(at = m.center, force = {2, 0});
        equation
          when x.v >= 1 then reinit(x.v, 0); end when;
        end Saw;""").simulate(at=[5.5], solver=solver)
        assert run["x.s"][-1] == pytest.approx(2.625, abs=1e-10)
        assert run["x.v"][-1] == pytest.approx(0.5, abs=1e-10)


def test_contacts_that_say_the_same(scene: Write) -> None:
    run = scene(BALL.replace("equation", "  Stop again(e = e, gap = p.s), double(e = e, gap = 2*p.s);\nequation")).simulate(
        at=[1.0, 3.0], parameters={"e": 0.5})
    np.testing.assert_allclose(run["p.s"], bounces(np.array([1.0, 3.0]), 0.5)[0], rtol=0, atol=1e-11)
    assert run.statistics.rhs_evaluations < 5_000


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-6, 1e-9])
def test_what_grazes_is_seen(scene: Write, solver: str, tolerance: float) -> None:
    """A ball on a spring dips by 1e-5 of its swing, six times; the end is that of erk at 1e-13."""
    model = scene("""model Grazing
      World world(gravity = {0, 0});
      Prismatic p(a = world, along = {0, 1}, v(start = 0.2));  PointMass m(m = 1, center = p.b);
      Spring k(k = 200, stretch = p.s - 1);
      Stop floor(e = 0.7, gap = p.s);
    end Grazing;""")
    run = model.simulate(at=[3.0], solver=solver, tolerance=tolerance)
    assert run.statistics.events == 6
    assert run["p.s"][-1] == pytest.approx(0.90040916, abs=2e-5 if tolerance > 1e-7 else 1e-6)


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "adams", "implicit"])
@pytest.mark.parametrize("tolerance", [1e-6, 1e-8, 1e-10])
def test_a_contact_without_a_force_at_first_is_left_again(scene: Write, solver: str, tolerance: float) -> None:
    """A mass strikes one on a spring at rest: together for half a period of sqrt(k/4), and apart with 3/4 m/s."""
    run = scene("""model Parting
      World world(gravity = {0, 0});
      Prismatic x(a = world, along = {1, 0}), y(a = world, along = {1, 0}, s(start = 2), v(start = -1));
      PointMass a(m = 1, center = x.b), b(m = 3, center = y.b);
      Spring k(k = 10, stretch = x.s);
      Stop hit(gap = y.s - x.s - 0.5[m]);
    end Parting;""").simulate(at=[10.0], solver=solver, tolerance=tolerance)
    assert run["y.s"][-1] == pytest.approx(0.5 + 0.75 * (10 - 1.5 - np.pi / np.sqrt(2.5)), abs=max(20 * tolerance, 1e-9))


@pytest.mark.parametrize("M", [1.0, 10.0, 1e3, 1e4, 1e6])
@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
def test_heavy_on_light_without_restitution(scene: Write, M: float, solver: str) -> None:
    """One impact brings about the other, and both stop at once."""
    run = scene(f"""model Heavy
      Prismatic a(a = world, along = {{0, 1}}, s(start = 1)), b(a = world, along = {{0, 1}}, s(start = 2));
      PointMass A(m = 1, center = a.b), B(m = {M}, center = b.b);
      Stop floor(gap = a.s), on(gap = b.s - a.s - 0.5[m]);
    end Heavy;""").simulate(at=[0.5, 2.0], solver=solver)
    np.testing.assert_allclose(run["b.s"], [2 - G / 8, 0.5], rtol=0, atol=1e-9)
    assert run.statistics.rhs_evaluations < 20_000


def test_a_contact_is_not_passed_from_the_side(scene: Write) -> None:
    """Under the table and away from it: nothing happens; and from above it is met."""
    model = scene("""model Side
      World world(gravity = {0, 0});
      Prismatic x(a = world, along = {1, 0}, s(start = -1), v(start = 1)), y(a = x.b, along = {0, 1});
      PointMass m(m = 1, center = y.b);
    equation
      when y.s < 0 and x.s > 0 then reinit(y.v, -0.5*pre(y.v)); end when;
    end Side;""")
    under = model.simulate(at=[0.9, 1.1, 2.0], initial={"y.s": -0.5, "y.v": 0.1})
    np.testing.assert_allclose(under["y.s"], [-0.41, -0.39, -0.3], rtol=0, atol=1e-12)
    above = model.simulate(at=[0.9, 1.1, 3.0], initial={"y.s": 0.2, "y.v": -0.1})
    np.testing.assert_allclose(above["y.s"], [0.11, 0.09, 0.05], rtol=0, atol=1e-12)


@pytest.mark.parametrize("phi", [0.05, 0.3, 0.8, 1.3])
def test_a_bar_that_spins_does_not_pass_the_floor(scene: Write, phi: float) -> None:
    """Both ends strike in turn, ever quicker than before the impact."""
    model = scene("""model Tumbling
      Planar free(a = world, y(start = 1.4));  Bar bar(m = 0.7, L = 0.43, center = free.b);
      Stop left(e = 0.9, a = world, b = bar.a), right(e = 0.9, a = world, b = bar.b);
      output Length low = min(left.gap, right.gap);
    end Tumbling;""")
    runs = [model.simulate(stop=2, interval=5e-3, tolerance=tolerance, solver=solver, initial={"free.phi": phi})
            for solver in ("auto", "erk5") for tolerance in (1e-7, 1e-10)]
    for run in runs:
        assert run["low"].min() > -1e-9
        np.testing.assert_allclose(run["free.y"], runs[-1]["free.y"], rtol=0, atol=1e-4)


def test_a_support_that_is_torn_away_leaves_no_force(scene: Write) -> None:
    run = scene("""model Torn
      Prismatic p(a = world, along = {0, 1});  PointMass m(m = 0.1, center = p.b);
      Stop floor(e = 0.5, gap = p.s - (if time < 1 then 0 else 2*(time - 1)));
      output Acceleration a = der(der(p.s));
    end Torn;""").simulate(at=[0.5, 1.02, 1.05])
    np.testing.assert_allclose(run["a"], [0, -G, -G], rtol=0, atol=1e-11)


def test_friction_beside_a_contact(scene: Write) -> None:
    """Both hold: mu g = 2 m/s2 stops it after 1 m, while the floor carries it."""
    run = scene("""model Both
      Prismatic x(a = world, along = {1, 0}, v(start = 2)), y(a = x.b, along = {0, 1});  PointMass m(m = 1, center = y.b);
      DryFriction rub(F = 2, rate = x.v);
      Stop floor(e = 0.5, gap = y.s);
    end Both;""").simulate(at=[0.5, 3.0], tolerance=1e-9)
    np.testing.assert_allclose(run["x.s"], [0.75, 1], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run["y.s"], 0, rtol=0, atol=1e-12)


def test_a_reaction_knows_of_a_contact(scene: Write) -> None:
    """A bar on a hinge, whose end rests on a stop: each carries half of it."""
    run = scene("""model Shelf
      Revolute h(a = world);  Bar bar(m = 2, L = 1, a = h.b);
      Stop stop(a = world, b = bar.b);
      output Force carried[2] = h.reaction, held[2] = stop.reaction;
    end Shelf;""").simulate(at=[1.0])
    for name in ("carried", "held"):
        np.testing.assert_allclose([run[f"{name}[1]"][-1], run[f"{name}[2]"][-1]], [0, G], rtol=0, atol=1e-11)


def test_a_contact_tells_its_force(scene: Write) -> None:
    """m (g + a) on a table that shakes, while it touches; along the slope it lies on."""
    model = scene(SHAKEN.replace("gap = p.s - table", "a = shift(world, {0, table}), b = ball.center").replace(
        "  output", "  output Force N[2] = stop.reaction;\n  output"))
    t = np.array([0.01, 0.05])
    run = model.simulate(at=np.append(t, 0.11), initial={"der(p.s)": 1.2})
    np.testing.assert_allclose(run["N[2]"], [*(0.1 * (G - 0.1 * 144 * np.sin(12 * t))), 0], rtol=0, atol=1e-8)


def test_a_bar_slides_down_a_slope_on_both_ends(scene: Write) -> None:
    """With g sin 36.9 deg, and half of m g cos 36.9 deg on each."""
    run = scene("""model Slope
      Planar free(a = world, x(start = 4), y(start = 3), phi(start = atan(0.75)));  Bar bar(m = 2, L = 0.4, center = free.b);
      Stop left(along = {-0.6, 0.8}, a = world, b = bar.a), right(along = {-0.6, 0.8}, a = world, b = bar.b);
      output Force N[2] = left.reaction, K[2] = right.reaction;
    end Slope;""").simulate(at=[1.0])
    np.testing.assert_allclose([run["free.x"][-1], run["free.y"][-1]], [4 - 0.24 * G, 3 - 0.18 * G], rtol=0, atol=1e-9)
    for name in ("N", "K"):
        np.testing.assert_allclose([run[f"{name}[1]"][-1], run[f"{name}[2]"][-1]], [-0.48 * G, 0.64 * G], rtol=0, atol=1e-8)


def test_events_without_end_are_told(scene: Write) -> None:
    told = "bring each other about without end, one of them the event 'y.v > 0.5' "
    with pytest.raises(RunError, match=re.escape(told)):
        scene("""model Endless
          Prismatic x(a = world, along = {1, 0}, v(start = 1)), y(a = x.b, along = {0, 1});  PointMass m(m = 1, center = y.b);
        equation
          when x.v > 0 and time > 1 then reinit(x.v, -1); reinit(y.v, 1); end when;
          when y.v > 0.5 then reinit(y.v, 0); reinit(x.v, 1); end when;
        end Endless;""").simulate(stop=2)


@pytest.mark.parametrize(("version", "kind", "error"), [("2", "CoSimulation", 1e-7), ("3", "CoSimulation", 1e-7),
                                                        ("2", "ModelExchange", 2e-6), ("3", "ModelExchange", 2e-6)])
@pytest.mark.parametrize(("text", "name", "stop"), [
    (BALL, "p.s", 5.0), (SHAKEN.replace("Real e = 0;", "Real e = 0.3;"), "p.s", 2.0), (FOUR_BAR, "h[1].phi", 2.0),
], ids=["ball", "table", "linkage"])
def test_fmus_have_impacts(tmp_path: Path, scene: Write, version: str, kind: str, error: float, text: str, name: str,
                           stop: float) -> None:
    path = tmp_path / "impact.lag"
    path.write_text(text, encoding="utf-8")
    found = simulated(path, version, kind, [name], stop_time=stop, output_interval=stop / 100, relative_tolerance=1e-9)
    t, places = np.unique(found["time"], return_index=True)
    expected = scene(text).simulate(at=t, tolerance=1e-11)[name]
    np.testing.assert_allclose(found[name][places], expected, rtol=0, atol=error)
    assert len(found["time"]) < 2_000


def test_runs_are_the_same_again(scene: Write) -> None:
    model = scene(SHAKEN)
    first, second = (model.simulate(stop=3, parameters={"e": 0.3}) for _ in range(2))
    assert np.array_equal(first["p.s"], second["p.s"])


@pytest.mark.parametrize("say", [
    lambda model: model.simulate(solver="linear"), lambda model: model.simulate(solver="conservative"),
    lambda model: model.simulate(solver="islands"), lambda model: model.simulate(solver="casadi:cvodes"),
    lambda model: export(model, "modelica", Path("ball.mo")), lambda model: export(model, "python", Path("ball.py")),
], ids=["linear", "conservative", "islands", "casadi", "modelica", "python"])
def test_what_cannot_have_them_says_so(scene: Write, say: Callable[[lag.Model], object]) -> None:
    with pytest.raises(lag.LagError, match=r"L0704|L0909"):
        say(scene(BALL))


def test_equations_tell_of_events(scene: Write) -> None:
    told = " ".join(scene(BALL).equations().split())
    assert "where − s comes to be positive, s' becomes − e s'" in told
    assert "Between events: Nothing depends on time and nothing is lost" in told


