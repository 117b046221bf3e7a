"""Events with conditions of several parts, and resets that leave a rate at the end of a one-way range."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "adams", "implicit")
G = 9.81


def edge(condition: str, x: tuple[float, float], y: tuple[float, float], value: str = "0") -> str:
    return f"""model Edge
      Prismatic x(a = world, along = {{1, 0}}, s(start = {x[0]}), v(start = {x[1]}));
      Prismatic y(a = x.b, along = {{0, 1}}, s(start = {y[0]}), v(start = {y[1]}));
      PointMass p(m = 1, center = y.b);
    equation
      when {condition} then reinit(y.v, {value}); end when;
    end Edge;"""


TABLE, WINDOW = "y.s < 0 and x.s < 0", "y.s < 0 and x.s < 1 and x.s > -0.1"
EDGES = [
    (TABLE, (0.0, -3.0), (-0.05, 0.0), 1.0, -0.05 - G / 2),  # begins at the edge, below the top
    (TABLE, (0.0, -3.0), (-0.05, -1.0), 1.0, -0.05 - G / 2),
    (TABLE, (0.1, -3.0), (-0.05, 0.0), 1.0, -0.05 - G / 1800 - G * (29 / 30) ** 2 / 2),  # comes from beside
    (TABLE, (0.1, -3.0), (-0.5, 3.0), 0.5, -0.4 - G / 1800 - G * (0.5 - 1 / 30) ** 2 / 2),  # and rises
    (TABLE, (0.0, -3.0), (0.05, 0.0), 1.0, 0.0),  # from above
    (TABLE, (0.0, 3.0), (0.0, 0.0), 1.0, -G / 2),  # lies at the edge, and leaves
    (WINDOW, (-1.0, 3.0), (0.2, 0.0), 1.0, 0.2 - G * 0.09 / 2 - G * 0.49 / 2),  # is below when it comes to the ledge
    (WINDOW, (-1.0, 3.0), (0.6, 0.0), 1.0, -G / 18),  # comes onto it, and leaves
    ("y.s < 0 and x.s <= 0", (0.0, 0.0), (-0.05, -0.5), 1.0, -0.55 - G / 2),  # below, and at the edge, which counts
    ("y.s < 0 and x.s >= 0", (0.0, -1.0), (-0.05, 0.5), 1.0, 0.45 - G / 2),
    ("not (y.s > 0) and not (x.s > 0)", (0.1, -3.0), (-0.05, 0.0), 1.0, -0.05 - G / 1800 - G * (29 / 30) ** 2 / 2),
    ("not (y.s > 0 or x.s > 0)", (0.1, -3.0), (-0.05, 0.0), 1.0, -0.05 - G / 1800 - G * (29 / 30) ** 2 / 2),
    ("not (y.s > 0 or not x.s < 0)", (0.0, -3.0), (0.05, 0.0), 1.0, 0.0),
    ("max(max(y.s, x.s - 1[m]), -0.1[m] - x.s) < 0", (-1.0, 3.0), (0.6, 0.0), 1.0, -G / 18),
    ("0 < min({-y.s, 1[m] - x.s, x.s + 0.1[m]})", (-1.0, 3.0), (0.2, 0.0), 1.0, 0.2 - G * 0.09 / 2 - G * 0.49 / 2),
    ("y.s < 0 or x.s < 0", (1.0, -2.0), (0.5, 0.0), 1.0, -G * (1 - np.sqrt(1 / G)) ** 2 / 2),  # once
]


@pytest.mark.parametrize(("condition", "x", "y", "t", "right"), EDGES)
def test_an_edge(scene: Write, condition: str, x: tuple[float, float], y: tuple[float, float], t: float, right: float) -> None:
    """The event comes where the last part comes true; what is held must have come from above."""
    model = scene(edge(condition, x, y))
    for solver in SOLVERS:
        for tolerance in (1e-6, 1e-12):
            run = model.simulate(at=[t], solver=solver, tolerance=tolerance)
            assert run["y.s"][-1] == pytest.approx(right, abs=1e-8 if tolerance > 1e-9 else 1e-11), (solver, tolerance)


def test_stairs(scene: Write) -> None:
    """Down three steps and off the last one."""
    model = scene("""model Stairs
      Prismatic x(a = world, along = {1, 0}, s(start = -1), v(start = 1)), y(a = x.b, along = {0, 1}, s(start = 2));
      PointMass p(m = 1, center = y.b);
    equation
      when y.s < 1.5 and x.s < 1 then reinit(y.v, 0); end when;
      for i in 2:4 loop
        when y.s < 2 - 0.5*i and x.s < i and x.s > i - 1 then reinit(y.v, 0); end when;
      end for;
    end Stairs;""")
    for solver in SOLVERS:
        run = model.simulate(at=[1.5, 2.9, 3.9, 4.9, 6.0], solver=solver, tolerance=1e-10)
        np.testing.assert_allclose(run["y.s"], [1.5, 1.0, 0.5, 0.0, -G / 2], rtol=0, atol=1e-9, err_msg=solver)


def pushed(condition: str, value: str, force: str, v: float) -> str:
    return f"""model Pushed
      World world(gravity = {{0, 0}});
      Block b(m = 1, base = world, v(start = {v}));
      AppliedForce push(at = b.center, force = {{{force}, 0}});
    equation
      when {condition} then reinit(b.v, {value}); end when;
    end Pushed;"""


WAVE = "-1[N]*cos(1[rad/s]*time)"
PUSHED = [
    ("b.v < 0", "0", "-1", 1.0, 3.0, 0.5, 0.0),  # a ratchet
    ("b.v < 0", "0", "-1", 0.0, 3.0, 0.0, 0.0),
    ("b.v < 0", "0", "(if time > 4[s] then 2[N] else -1[N])", 1.0, 5.0, 1.5, 2.0),  # and lets go
    ("0 > b.v", "0", WAVE, 0.5, 4.0, np.pi / 12 + np.cos(np.pi / 6) - 1 + 4 - np.pi / 2 + np.cos(4), 1 - np.sin(4)),
    ("b.v < -1", "-1", "-1", 1.0, 5.0, -3.0, -1.0),  # a limit of speed
    ("b.v > 1", "1", "2", 0.0, 5.0, 4.75, 1.0),
    ("b.v < 0 and time < 3", "0", "-1", 1.0, 5.0, -1.5, -2.0),  # as long as the pawl is there
    ("b.v < 0", "0.5", "-1", 0.0, 1.25, 0.34375, 0.25),  # thrown forwards again and again: no end of a range
]


@pytest.mark.parametrize(("condition", "value", "force", "v", "t", "place", "rate"), PUSHED)
def test_a_rate_goes_one_way(
    scene: Write, condition: str, value: str, force: str, v: float, t: float, place: float, rate: float
) -> None:
    model = scene(pushed(condition, value, force, v))
    for solver in SOLVERS:
        for tolerance in (1e-4, 1e-10):
            run = model.simulate(at=[t], solver=solver, tolerance=tolerance)
            found = [run["b.s"][-1], run["b.v"][-1]]
            np.testing.assert_allclose(found, [place, rate], rtol=0, atol=10 * tolerance, err_msg=f"{solver} {tolerance}")
            assert np.abs(run.energy.residual).max() < tolerance + 1e-12


def test_a_freewheel(scene: Write) -> None:
    """A shaft drives another one, but does not hold it back: together with cos(t)/4 until t = pi/2, then apart."""
    model = scene("""model Freewheel
      Revolute one(a = world), two(a = world);
      Disc d1(m = 2, r = 1, I = 1, center = one.b), d2(m = 2, r = 1, I = 3, center = two.b);
      AppliedTorque drive(on = d1.center, torque = 1[N.m]*cos(1[rad/s]*time));
      Angle slip = two.phi - one.phi;
    equation
      when der(slip) < 0 then reinit(der(slip), 0); end when;
    end Freewheel;""")
    apart = 3 - np.pi / 2
    right = [0.25 - 0.75 * apart - np.cos(3), 0.25 + 0.25 * apart]
    for solver in SOLVERS:
        run = model.simulate(at=[1.0, 3.0], solver=solver, tolerance=1e-10)
        assert run["one.phi"][0] == pytest.approx((1 - np.cos(1)) / 4, abs=1e-9)
        np.testing.assert_allclose([run["one.phi"][-1], run["two.phi"][-1]], right, rtol=0, atol=1e-9, err_msg=solver)


def test_a_wheel_with_two_pawls(scene: Write) -> None:
    """One on the ground, one on a lever that swings: when the lever begins to drive the wheel from rest both hold the same rate
    at once, and the ground's has to let go (the accelerations were not finite)."""
    model = scene("""model Pawls
      World world(gravity = {0, 0});
      Revolute lever(a = world), wheel(a = world);
      Motion swing(of = lever.phi, to = -0.5*sin(3*time));
      Body disc(m = 1, I = 2, center = wheel.b);
      AppliedTorque load(on = disc.center, torque = -1);
      TorsionDamper bearing(a = world, b = disc.center, c = 0.3);
    equation
      when wheel.w < 0 then reinit(wheel.w, 0); end when;
      when wheel.w < lever.w then reinit(wheel.w, lever.w); end when;
    end Pawls;""")
    for solver in SOLVERS:
        for tolerance in (1e-3, 1e-6, 1e-9):
            run = model.simulate(at=[np.pi / 3], solver=solver, tolerance=tolerance)
            found = [run["wheel.phi"][-1], run["wheel.w"][-1]]
            np.testing.assert_allclose(found, [0.5, 1.5], rtol=0, atol=10 * tolerance, err_msg=f"{solver} {tolerance}")


FREE = """model Free "b turns no slower than a, by a component of one's own"
  Frame a, b;
  AngularVelocity rels[2] = {b.w - a.w, 0}, rel = rels[1];
equation
  when rel < 0 then reinit(RATE, 0); end when;
end Free;
model Row
  World world(gravity = {0, 0});
  Revolute h[3](each a = world); Body d[3](each m = 1, I = {1, 3, 2}, center = h.b);
  Free f[2](a = d[1:2].center, b = d[2:3].center);
  AppliedTorque drive(on = d[1].center, torque = 1[N.m]*cos(1[rad/s]*time));
end Row;"""


@pytest.mark.parametrize("rate", ["rel", "rels[1]", "b.w - a.w", "der(b.phi) - der(a.phi)", "-(a.w - b.w)", "2*b.w - 2*a.w"])
def test_differences_of_rates_are_rates(rate: str, scene: Write) -> None:
    """Three shafts in a row of freewheels: together with sin(t)/6, from pi/2 on the first one alone."""
    model = scene(FREE.replace("RATE", rate))
    run = model.simulate(at=[1.0, 3.0], tolerance=1e-10)
    np.testing.assert_allclose(run["h[3].w"], [np.sin(1) / 6, 1 / 6], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run["h[1].w"], [np.sin(1) / 6, 1 / 6 + np.sin(3) - 1], rtol=0, atol=1e-9)


def test_a_block_is_struck_against_its_pawl(scene: Write) -> None:
    """The impact brings about that of the pawl, as it does at a stop: the ball leaves with a quarter of 0.5 m/s times 2."""
    model = scene("""model Struck
      World world(gravity = {0, 0});
      Block b(m = 1, base = world), ball(m = 1, base = world, s(start = 1), v(start = -2));
      Stop hit(e = 0.5, gap = ball.s - b.s);
    equation
      when b.v < 0 then reinit(b.v, 0); end when;
    end Struck;""")
    run = model.simulate(at=[2.0])
    np.testing.assert_allclose([run["b.s"][-1], run["ball.s"][-1]], [0, 0.375], rtol=0, atol=1e-12)


def test_the_first_row_has_the_force_of_the_next_ones(scene: Write) -> None:
    """The cam lifts the follower from rest: friction is against that from the first moment."""
    model = scene("""model Cam
      parameter AngularVelocity w = 10;  parameter Length h = 0.01;
      Block follower(m = 1, base = world, along = {0, 1});
      Spring back(k = 200, stretch = follower.s + 0.02);
      DryFriction guide(F = 1, rate = follower.v);
      Stop cam(e = 0, gap = follower.s - h*(1 - cos(w*time)));
      output Force N = cam.force;
    end Cam;""")
    for solver in SOLVERS:
        run = model.simulate(at=[0.0, 1e-4], solver=solver)
        assert run["N"][0] == pytest.approx(9.81 + 1 + 4 + 1, abs=1e-9), solver
        assert run["N"][1] == pytest.approx(9.81 + np.cos(1e-3) + 4 + 2 * (1 - np.cos(1e-3)) + 1, abs=1e-7), solver


@pytest.mark.parametrize("solver", ["pirk", "adams", "taylor", "auto"])
def test_what_a_pawl_lets_go_begins_from_nothing(scene: Write, solver: str) -> None:
    """At t = asin(0.3)/4, where the load turns round: the first steps are no longer than time can resolve."""
    model = scene("""model Driven
      Block b(m = 2, base = world);
      AppliedForce load(at = b.center, force = {1[N]*(sin(4*time) - 0.3), 0});
    equation
      when b.v < 0 then reinit(b.v, 0); end when;
    end Driven;""")
    begin, t = np.arcsin(0.3) / 4, 0.5
    speed = (np.cos(4 * begin) - np.cos(4 * t)) / 8 - 0.15 * (t - begin)
    for tolerance in np.geomspace(1e-8, 1e-10, 12):
        run = model.simulate(at=[t], tolerance=float(tolerance), solver=solver)
        assert run["der(b.s)"][-1] == pytest.approx(speed, abs=100 * tolerance), tolerance


@pytest.mark.parametrize(("condition", "value"), [("b.v < 0", "-0.5*b.v"), ("b.v < 0", "abs(b.v)"), ("b.v > 1", "2 - b.v")])
def test_a_rate_that_is_set_to_what_it_is(scene: Write, condition: str, value: str) -> None:
    """Nothing comes to a rate's own place with a jump: these came once, without effect, and never again."""
    with pytest.raises(lag.LagError, match="L0230"):
        scene(pushed(condition, value, "-1", 0.5))


@pytest.mark.parametrize(("condition", "v"), [("b.v < 0", -1.0), ("b.v > 0.5", 1.0), ("b.v < 0 or b.s < 1", 1.0)])
def test_what_holds_at_the_start_already_is_told(scene: Write, condition: str, v: float) -> None:
    run = scene(pushed(condition, "0.25", "-1", v)).simulate(at=[0.1])
    assert any("holds at the start already" in warning for warning in run.warnings)
    assert not scene(pushed("b.v < 0", "0", "-1", 0.0)).simulate(at=[0.1]).warnings


def test_the_force_that_carries_along_is_known(scene: Write) -> None:
    """Two blocks of which the second never falls behind: 2 kg are carried by two thirds of the push, until it turns round."""
    run = scene("""model Carried Block a(m = 1, base = world), b(m = 2, base = world); Length ahead = b.s - a.s;
      AppliedForce P(at = a.center, force = {3[N]*sin(2[rad/s]*time), 0}); output Force N = contact_force(ahead);
      equation when der(ahead) < 0 then reinit(der(ahead), 0); end when; end Carried;""").simulate(at=[0.3, 1.1, 1.5, 1.7, 2.5])
    assert run["N"] == pytest.approx(np.maximum(2 * np.sin(2 * run.time), 0) * (run.time < np.pi / 2), abs=1e-12)


GATES = [
    ("time > 0.5 then open = true", "y.s < 0 and open", 3.0, 0.2 - G * 0.125 - G * 2.5**2 / 2),  # is below when it opens
    ("y.s < -1 then open = true", "y.s < 0 and open", 3.0, -1 - G * (3 - np.sqrt(2.4 / G)) ** 2 / 2),  # by its own fall
    ("time > 0.1 then open = true", "y.s < 0 and time < 1 and open", 3.0, -G * 2),  # is above: held until the time is up
]


@pytest.mark.parametrize(("event", "condition", "t", "right"), GATES)
def test_an_edge_that_an_event_opens(scene: Write, event: str, condition: str, t: float, right: float) -> None:
    """What events set makes the rest of a condition true: what is below then was lifted to the edge, 1 m, at once."""
    model = scene(f"""model Gate
      Prismatic y(a = world, along = {{0, 1}}, s(start = 0.2));
      PointMass p(m = 1, center = y.b);
      discrete Boolean open(start = false);
    equation
      when {event}; end when;
      when {condition} then reinit(y.v, 0); end when;
    end Gate;""")
    for solver in SOLVERS:
        assert model.simulate(at=[t], solver=solver, tolerance=1e-9)["y.s"][-1] == pytest.approx(right, abs=1e-9), solver


def test_a_condition_on_a_rate_below_the_edge(scene: Write) -> None:
    """Each time that it falls faster than 1 m/s below, it is thrown up anew: Taylor's long steps missed the fifth time."""
    model = scene("""model Again
      Prismatic y(a = world, along = {0, 1}, s(start = 0.2));
      PointMass p(m = 1, center = y.b);
    equation
      when y.s < 0 and y.v < -1 then reinit(y.v, -0.25*pre(y.v)); end when;
    end Again;""")
    first, speed = np.sqrt(0.4 / G), 0.25 * np.sqrt(0.4 * G)
    below, period, fall = first + (speed + 1) / G, 1.25 / G, (1 - 0.25**2) / (2 * G)
    count, rest = divmod(2.0 - below, period)
    right = (speed**2 - 1) / (2 * G) - count * fall + 0.25 * rest - G * rest**2 / 2
    for solver in ("taylor", *SOLVERS):
        assert model.simulate(at=[2.0], solver=solver, tolerance=1e-9)["y.s"][-1] == pytest.approx(right, abs=1e-9), solver


WALLS = [
    ("b.s > wall", "0", 3.0, [1.0, 1.5, 3.0]),  # it goes away, and waits elsewhere
    ("b.s > wall", "0", 0.5, [1.0, 1.5, 3.0]),  # it appears behind what rests at it
    ("wall*b.s > 1", "0", 0.25, [1.0, 1.5, 3.0]),
    ("der(b.s) > wall", "wall", 2.0, [1.9, 3.5, 5.5]),  # a limit of speed
]


@pytest.mark.parametrize(("condition", "value", "wall", "right"), WALLS)
def test_a_wall_that_events_move(scene: Write, condition: str, value: str, wall: float, right: list[float]) -> None:
    """What rests at it is held, and let go when it moves: it had been stopped once, and went on through it."""
    model = scene(f"""model Wall
      World world(gravity = {{0, 0}});
      Block b(m = 1, base = world, v(start = 1));
      AppliedForce push(at = b.center, force = {{1, 0}});
      discrete Real wall(start = 1);
    equation
      when time > 2 then wall = {wall}; end when;
      when {condition} then reinit(b.v, {value}); end when;
    end Wall;""")
    for solver in SOLVERS:
        run = model.simulate(at=[1.9, 3.0, 4.0], solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["b.s"], right, rtol=0, atol=1e-9, err_msg=solver)


def test_a_stop_of_the_library_that_events_move(scene: Write) -> None:
    """Its gap was refused, as if discrete variables had accelerations."""
    run = scene("""model Lift
      World world(gravity = {0, -10});
      Prismatic y(a = world, along = {0, 1});
      PointMass p(m = 1, center = y.b);
      discrete Length level(start = 0);
      Stop floor(gap = y.s - level);
      output Force F = floor.force;
    equation
      when time > 1 then level = -5; end when;
    end Lift;""").simulate(at=[0.5, 1.5, 3.0], tolerance=1e-9)
    np.testing.assert_allclose(run["y.s"], [0.0, -1.25, -5.0], rtol=0, atol=1e-9)
    np.testing.assert_allclose(run["F"], [10.0, 0.0, 10.0], rtol=0, atol=1e-8)


JUMPS = [
    ("gap = 0.5 + step(time - 1) - b.s", "", "", [0.5, 0.625, 1.0, 1.5]),  # gone, and back in its way
    ("gap = (if time < 1 then 0.5 else 0.25) - b.s", "", "", [0.5, 0.625, 1.0, 2.5]),  # behind what rested at it
    ("gap = w - b.s", "Real w;", "when sample(0, 1) then w = 0.5 + time/1[s]; end when;", [0.5, 0.625, 1.0, 2.5]),
]


@pytest.mark.parametrize(("gap", "declared", "sampled", "right"), JUMPS)
def test_a_wall_that_jumps_in_time(scene: Write, gap: str, declared: str, sampled: str, right: list[float]) -> None:
    """What rested at it had gone with it, 1 m at once, or stayed where it had been."""
    model = scene(f"""model Jump
      World world(gravity = {{0, 0}});
      Block b(m = 1, base = world, v(start = 1));
      AppliedForce push(at = b.center, force = {{1, 0}});
      Stop wall({gap});
      {declared}
    equation
      {sampled}
    end Jump;""")
    for solver in SOLVERS:
        run = model.simulate(at=[0.9, 1.5, 2.0, 3.0], solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["b.s"], right, rtol=0, atol=1e-9, err_msg=solver)


KINKS = [  # the start, the wall w in time, and the places at 0.6, 1.1, 1.5 and 2 s
    (1.25, "max(0, 0.1*(time/1[s] - 1))", [0.0, 0.01, 0.05, 0.1]),  # fell from 0.5 s on
    (1.25, "min(0, 0.1*(1 - time/1[s]))", [0.0, -0.01, -0.05, -0.1]),
    (0.0, "0.1*abs(time/1[s] - 1) - 0.1", [-0.06, -0.09, -0.05, 0.0]),  # went on through it at 1 s
    (0.0, "max(0, min(0.1, 0.1*(time/1[s] - 1)))", [0.0, 0.01, 0.05, 0.1]),  # stayed at 0 until 2 s
    (0.05, "0.1*abs(abs(time/1[s] - 1) - 0.5)", [0.01, 0.04, 0.0, 0.05]),  # went on through it at 1.5 s
    (0.0, "max(0.1*(time/1[s] - 1), max(0.2*(time/1[s] - 1.5), 0))", [0.0, 0.01, 0.05, 0.1]),  # stayed at 0 until 1.5 s
    (0.0, "0.1*max(0, min(0.5, sin(time/1[s] - 1)))", [0.0, 0.1*np.sin(0.1), 0.1*np.sin(0.5), 0.05]),  # implicit: stayed at 0
]


@pytest.mark.parametrize(("start", "wall", "right"), KINKS)
def test_a_wall_whose_pace_changes(scene: Write, start: float, wall: str, right: list[float]) -> None:
    """What time decides in max, min and abs is an event for what rests, too, and tells how fast its gap goes."""
    model = scene(f"""model Kink
      World world(gravity = {{0, -10}});
      Prismatic y(a = world, along = {{0, 1}}, s(start = {start}));
      PointMass p(m = 1, center = y.b);
      Stop floor(gap = y.s - ({wall}));
    end Kink;""")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.6, 1.1, 1.5, 2.0], solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["y.s"], right, rtol=0, atol=1e-8, err_msg=solver)


LEAST = [  # what is declared, the wall, and when it changes: by rounding of what stands there
    ("discrete Length l(start = 0.3);", "l - 0.3", "when time > 1 then l = 0.1 + 0.2; end when;"),
    ("discrete Length l(start = 0);", "l", "when sample(0.5, 0.5) then l = pre(l) + 1e-16; end when;"),
    ("parameter Length a = 0.1, b = 0.2, c = 0.3;", "(if time < 1 then c else a + b) - c", ""),
]


@pytest.mark.parametrize(("declared", "wall", "event"), LEAST)
def test_a_wall_that_rounding_moves(scene: Write, declared: str, wall: str, event: str) -> None:
    """What rests at 0 has no size: the place of the wall jumped by 5.6e-17 m, and nothing held any more."""
    model = scene(f"""model Least
      World world(gravity = {{0, -10}});
      Prismatic y(a = world, along = {{0, 1}});
      PointMass p(m = 1, center = y.b);
      {declared}
      Stop floor(gap = y.s - ({wall}));
    {"equation " + event if event else ""}
    end Least;""")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.7, 1.5, 3.0], solver=solver, tolerance=1e-9)
        np.testing.assert_allclose(run["y.s"], 0, rtol=0, atol=1e-10, err_msg=solver)


@pytest.mark.parametrize(("wall", "right"), [
    ("if time < 0.2 then 0 else -4e-4", -2e-4), ("if x.s < 0.7 then 0 else -4e-4", -2e-4),
    ("if x.s < 0.7 then 0 else 5e-3", -2e-4)])
def test_what_is_pressed_hard_is_not_carried_by_walls_that_jump(scene: Write, wall: str, right: float) -> None:
    """1 g behind a spring of 10 N: it was 0.4 mm lower at once, or lifted by 5 mm, at tolerances of 1e-6 and more."""
    model = scene(f"""model Valve
      World world(gravity = {{0, 0}});
      Prismatic x(a = world, s(start = 0.5), v(start = 1)), y(a = x.b, along = {{0, 1}});
      PointMass p(m = 0.001, center = y.b);
      AppliedForce f(at = y.b, force = {{0, -1000[N/m]*y.s - 10[N]}});
      Stop seat(gap = y.s - ({wall}));
    end Valve;""")
    after = np.arccos(1 + right/0.01)/1000
    for tolerance in (1e-4, 1e-6):
        assert model.simulate(at=[0.2 + after], tolerance=tolerance)["y.s"][0] == pytest.approx(right, rel=30*tolerance)


LEDGES = [  # a wall that ends at 1 m, and where what slides on it at 1 m/s from 0.5 m is at 0.2, 0.5, 0.8 and 1.2 s
    ("if x.s < 1 then 0 else -1", [0.0, 0.0, -0.45, -1.0]),  # was on its lower part at once, or hung on in the air
    ("-floor(x.s/1[m])*1[m]", [0.0, 0.0, -0.45, -1.0]),
    ("if x.s < 1 then 0 else 0.5", [0.0, 0.0, -0.45, -2.45]),  # behind what it ran into: was lifted
]


@pytest.mark.parametrize(("wall", "right"), LEDGES)
def test_a_wall_that_jumps_along_the_way(scene: Write, wall: str, right: list[float]) -> None:
    model = scene(f"""model Ledge
      World world(gravity = {{0, -10}});
      Prismatic x(a = world, s(start = 0.5), v(start = 1)), y(a = x.b, along = {{0, 1}});
      PointMass p(m = 1, center = y.b);
      Stop ground(gap = y.s - ({wall}));
    end Ledge;""")
    for solver in ("auto", "erk", "implicit"):
        run = model.simulate(at=[0.2, 0.5, 0.8, 1.2], solver=solver, tolerance=1e-6)
        np.testing.assert_allclose(run["y.s"], right, rtol=0, atol=1e-7, err_msg=solver)


HELD_NOT = ["y.s < 0 and x.s < 1 or y.s < -1", "not (y.s >= 0 or x.s > 1) or x.s > 9", "y.v < 0 or x.s > 2"]


@pytest.mark.parametrize("condition", HELD_NOT)
def test_an_alternative_that_holds_nothing_is_told(scene: Write, condition: str) -> None:
    """What fell went on through the table, after one reset, without a word."""
    (warning,) = scene(edge(condition, (0.5, 1.0), (0.0, 0.0))).warnings
    assert "L0224" in warning and "beside `or` it is no contact" in warning
    assert not scene(edge("y.s < 0 and (x.s < 1 or x.s > 2)", (0.5, 1.0), (0.0, 0.0))).warnings
    assert not scene(edge("x.s > 1 or time > 1", (0.5, 1.0), (0.0, 0.0))).warnings


@pytest.mark.parametrize("force", [1.0, -1.0])
def test_what_is_largest_of_both_sides_is_a_wall_on_both(scene: Write, force: float) -> None:
    """It falls onto -1/2 or 1/2 in 1 s."""
    run = scene(f"""model Post
      World world(gravity = {{0, 0}});
      Block b(m = 1, base = world, s(start = {-force}));
      AppliedForce load(at = b.center, force = {{{force}, 0}});
    equation
      when max(b.s, -b.s) < 0.5 then reinit(b.v, 0); end when;
    end Post;""").simulate(at=[0.5, 3.0])
    assert run["b.s"][-2:] == pytest.approx([-force * 0.875, -force * 0.5], abs=1e-9)


RING = """model Ring
  World world(gravity = {{0, 0}}); Block b(m = 1, base = world, s(start = {0}), v(start = {1})), c(m = 1, base = world);
equation
  when b.s > 0.5 then reinit(b.v, -1); end when;
  when b.v < -0.5 then reinit(c.v, 0.25); end when;
  when c.v > 0.2 then reinit(b.v, 0.1); end when;
end Ring;"""


@pytest.mark.parametrize(("place", "rate"), [(0.1, 0.7), (-0.02, 1.31), (0.13, 0.42)])
def test_resets_in_a_ring(scene: Write, place: float, rate: float) -> None:
    """Places stay at an instant: what came true there comes once, though its rate is turned round and back. It was -0.93 m."""
    for solver in ("auto", "erk5", "erk9", "pirk", "implicit", "taylor"):
        run = scene(RING.format(place, rate)).simulate(at=[2.0], solver=solver, tolerance=1e-8)
        assert run["b.s"][0] == pytest.approx(0.5 + 0.1 * (2 - (0.5 - place) / rate), abs=1e-9), solver
        assert run["der(c.s)"][0] == 0.25


def test_what_has_gone_back_comes_again(scene: Write) -> None:
    """A block that a reset sends back to a spring's side, from where it comes again, each time: twice in 2.5 s."""
    model = scene("""model Back
      World world(gravity = {0, 0}); Block b(m = 1, base = world, v(start = 1)); discrete Integer n(start = 0);
      AppliedForce f(at = b.center, force = {1, 0});
    equation
      when b.s > 0.3 then reinit(b.v, -1); n = pre(n) + 1; end when;
    end Back;""")
    first = np.sqrt(1.6) - 1
    for solver in ("auto", "erk5", "pirk", "implicit"):
        run = model.simulate(at=[first + 1.9, first + 2.1], solver=solver)
        assert list(run["n"]) == [1, 2], solver
