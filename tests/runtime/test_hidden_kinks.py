"""Forces that bend or jump where a length passes through zero: no step crosses the place unseen, whatever the solver."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.special import beta

import lagrangia as lag
from helpers.fmus import simulated
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "erk9", "adams", "pirk", "taylor", "implicit")

ANCHOR = """model Anchor "a mass on a line through the anchor of its spring"
  World world(gravity = {-0.8, 0});
  Prismatic line(a = world, along = {1, 0}, s(start = -1.06), v(start = 0.16));
  PointMass p(m = 1, center = line.b);
  DuffingSpring spring(a = world, b = p.center, k = 20, k3 = 40, s_rel0 = 0.4);
end Anchor;"""
TURNING = """model Turning "a slider on a bar that turns: the direction of the spring is known by its angle alone"
  Revolute h(a = world, phi(start = 0.3));
  Prismatic p(a = h.b, along = {3, 4}, s(start = 0.8));
  PointMass m(m = 1, center = p.b);
  Bar b(m = 3, L = 1, center = h.b);
  Spring f(a = h.b, b = m.center, k = 60, s_rel0 = 0.3);
  Damper d(a = h.b, b = m.center, c = 0.2);
end Turning;"""
WRITTEN = """function far
  input Real x; input Real y;
  output Real r = sqrt(x^2 + y*y);
end far;
model Written "the same lengths, written out"
  World world(gravity = {0, 0});
  Block a(m = 1, base = world, s(start = -0.3), v(start = 1));
  Spring f(k = 10, stretch = 1[m]*far(a.s/1[m], 0) - 0.2), g(k = 3, stretch = norm({a.s - 0.1, 0}) - 0.1);
  Spring h(k = 2, stretch = sqrt((a.s + 0.2)^2) - 0.1);
end Written;"""
PENDULUM = """model Pendulum "a spring to the lowest point of its circle: two points meet, and nothing changes its sign"
  Revolute h(a = world, phi(start = 0.9));
  PointMass m(m = 1, center = shift(h.b, {0, -1}));
  Spring f(a = shift(world, {0, -1}), b = m.center, k = 20, s_rel0 = 0.4);
end Pendulum;"""
FREE = """model Free "a free point on a line through the anchor"
  World world(gravity = {0, 0});
  PointMass m(m = 1, center(x(start = 0.6), y(start = 0.8)));
  Spring f(a = world, b = m.center, k = 20, s_rel0 = 0.4);
end Free;"""


def from_kink_to_kink(force: Callable[[np.ndarray, float], list[float]], places: list[float], y: list[float], stop: float,
                      which: int = 0) -> np.ndarray:
    """DOP853 at 1e-13: dy/dt = force(y, signs), which holds the signs of y[which] - place between two kinks."""
    t, state = 0.0, np.array(y)
    signs = [np.sign(state[which] - x) or np.sign(state[-1]) for x in places]
    while t < stop:
        events = [lambda _, s, x=x, sign=sign: sign * (s[which] - x) + 1e-15 for x, sign in zip(places, signs, strict=True)]
        for event in events:
            event.terminal, event.direction = True, -1
        run = solve_ivp(lambda _, s, signs=signs: force(s, signs), (t, stop), state, "DOP853", rtol=1e-13, atol=1e-15,
                        events=events)
        t, state = run.t[-1], run.y[:, -1]
        signs = [-sign if len(found) else sign for sign, found in zip(signs, run.t_events, strict=True)]
    return state


def test_through_the_anchor_on_a_line(scene: Write) -> None:
    """The right value is that of one equation with the jump as an event."""
    def force(y: np.ndarray, sign: list[float]) -> list[float]:
        stretch = sign[0] * y[0] - 0.4
        return [y[1], -0.8 - sign[0] * (20 * stretch + 40 * stretch**3)]

    right = from_kink_to_kink(force, [0.0], [-1.06, 0.16], 3)
    assert right[0] == pytest.approx(-0.45983793558, abs=2e-11)
    model = scene(ANCHOR)
    for solver in SOLVERS:
        for tolerance in (1e-6, 1e-9, 1e-12):
            run = model.simulate(at=[3.0], tolerance=tolerance, solver=solver)
            assert run["line.s"][-1] == pytest.approx(right[0], abs=max(100 * tolerance, 2e-11)), (solver, tolerance)
            assert run.statistics.events == 4


def test_through_the_hinge_of_a_turning_bar(scene: Write) -> None:
    def force(y: np.ndarray, sign: list[float]) -> list[float]:
        phi, s, w, v = y[1], y[0], y[2], y[3]
        angle, g = phi + np.arctan2(4, 3), 9.81
        return [v, w, (-g * s * np.cos(angle) - 2 * s * v * w) / (3 / 12 + s * s),
                s * w * w - g * np.sin(angle) - sign[0] * 60 * (sign[0] * s - 0.3) - 0.2 * v]

    right = from_kink_to_kink(force, [0.0], [0.8, 0.3, 0, 0], 3)
    model = scene(TURNING)
    for solver in SOLVERS:
        run = model.simulate(at=[3.0], tolerance=1e-10, solver=solver)
        assert run["p.s"][-1] == pytest.approx(right[0], abs=1e-8), solver
        assert run["h.phi"][-1] == pytest.approx(right[1], abs=1e-8), solver


def test_lengths_that_are_written_out(scene: Write) -> None:
    def force(y: np.ndarray, sign: list[float]) -> list[float]:
        a, b, c = sign
        return [y[1], -10 * a * (a * y[0] - 0.2) - 3 * b * (b * (y[0] - 0.1) - 0.1) - 2 * c * (c * (y[0] + 0.2) - 0.1)]

    right = from_kink_to_kink(force, [0.0, 0.1, -0.2], [-0.3, 1], 3)
    model = scene(WRITTEN)
    for solver in ("auto", "erk", "pirk", "implicit"):
        run = model.simulate(at=[3.0], tolerance=1e-10, solver=solver)
        assert run["a.s"][-1] == pytest.approx(right[0], abs=1e-9), solver


def test_points_that_meet_by_chance(scene: Write) -> None:
    """What is found out at the ends of steps is repeated in shorter ones: as good as the tolerance, but no better."""
    def swing(y: np.ndarray, sign: list[float]) -> list[float]:  # the length is 2 sin(phi/2)
        half = y[0] / 2
        return [y[1], -9.81 * np.sin(y[0]) - 20 * (sign[0] * 2 * np.sin(half) - 0.4) * sign[0] * np.cos(half)]

    right = from_kink_to_kink(swing, [0.0], [0.9, 0], 3)[0]
    w = np.sqrt(20)
    model = scene(PENDULUM)
    for solver in SOLVERS:
        for tolerance in (1e-6, 1e-9):
            run = model.simulate(at=[3.0], tolerance=tolerance, solver=solver)
            assert run["h.phi"][-1] == pytest.approx(right, abs=300 * tolerance), (solver, tolerance)
    free = scene(FREE)
    quarter = np.arccos(-0.4 / 0.6) / w  # from 1 m to the anchor; from there to the other side and back
    phase = (3 - quarter) % (2 * quarter)
    passed = int((3 - quarter) // (2 * quarter))
    length = 0.4 + 0.6 * np.cos(w * (phase - quarter))
    for solver in SOLVERS:
        for tolerance in (1e-6, 1e-9):
            run = free.simulate(at=[3.0], tolerance=tolerance, solver=solver)
            place = (-1) ** (passed + 1) * length * np.array([0.6, 0.8])
            np.testing.assert_allclose([run["m.center.x"][-1], run["m.center.y"][-1]], place, rtol=0, atol=300 * tolerance)


ANGLES = {"atan2": "atan2(sin(h.phi), cos(h.phi))", "mod": "mod(h.phi + pi, 2*pi) - pi",
          "floor": "h.phi - 2*pi*floor(h.phi/(2*pi) + 0.5)", "ceil": "h.phi - 2*pi*ceil(h.phi/(2*pi) - 0.5)"}
NATURAL = """model Round "a spring by an angle between -pi and pi, which is wound back as it goes round"
  constant Real pi = 3.14159265358979323846;
  Revolute h(a = world, phi(start = 2.9), w(start = 5)); Disc d(m = 1, r = 1, I = 1, center = h.b);
  AppliedTorque t(on = h.b, torque = -4[N.m]*({angle})); end Round;"""


@pytest.mark.parametrize("angle", list(ANGLES))
def test_an_angle_that_begins_anew(angle: str, scene: Write) -> None:
    """It jumps by a turn where it passes pi, seven times: an event each. Taylor series had gone on by 41 rad, Gauss's method
    by 0.04."""
    def force(y: np.ndarray, sign: list[float]) -> list[float]:
        return [y[1], -4 * (y[0] - 2 * np.pi * sum(s > 0 for s in sign))]

    right = from_kink_to_kink(force, [np.pi * (2 * k + 1) for k in range(8)], [2.9, 5], 6)[0]
    assert right == pytest.approx(41.7799334191, abs=1e-9)
    model = scene(NATURAL.replace("{angle}", ANGLES[angle]))
    for solver in SOLVERS:
        if solver == "taylor" and angle != "atan2":
            continue  # refused, as there are no series of whole numbers
        for tolerance in (1e-6, 1e-9):
            run = model.simulate(at=[6.0], tolerance=tolerance, solver=solver)
            assert run["h.phi"][-1] == pytest.approx(right, abs=30 * tolerance), (solver, tolerance)
            assert run.statistics.events >= 7


def test_a_start_in_the_anchor(scene: Write) -> None:
    """Which side it goes to is its rate's to say."""
    text = ANCHOR.replace("start = -1.06", "start = 0").replace("{-0.8, 0}", "{0, 0}").replace("k3 = 40", "k3 = 0")
    w, v = np.sqrt(20), 0.16
    right = 0.4 * (1 - np.cos(w * 0.3)) + v / w * np.sin(w * 0.3)
    model = scene(text)
    for solver in SOLVERS:
        run = model.simulate(at=[0.3], tolerance=1e-10, solver=solver)
        assert run["line.s"][-1] == pytest.approx(right, abs=1e-10), solver


def test_sweeps_and_islands_have_them(scene: Write) -> None:
    other = "Block other(m = 1, base = world, s(start = 1)); Spring o(k = 9, stretch = other.s);"
    text = ANCHOR.replace("end Anchor;", f"{other}\nend Anchor;")
    model = scene(text)
    alone = model.simulate(at=[3.0], tolerance=1e-9, solver="islands")
    assert alone["line.s"][-1] == pytest.approx(-0.45983793558, abs=1e-8)
    sweep = model.simulate_many(parameters={"o.k": [9.0, 10.0]}, stop=3.0, tolerance=1e-9)
    np.testing.assert_allclose(sweep["final(line.s)"], -0.45983793558, rtol=0, atol=1e-8)


def test_ordinary_springs_cost_nothing(scene: Write) -> None:
    """What never comes near its anchor has no events, and the solver that it would have without a sign."""
    run = scene(ANCHOR.replace("start = -1.06", "start = 0.5")).simulate(stop=2.0, tolerance=1e-9)
    assert run.statistics.events == 0
    assert run.statistics.solver.name == "TAYLOR"


@pytest.mark.parametrize(("kind", "error"), [("CoSimulation", 1e-7), ("ModelExchange", 1e-5)])
def test_fmus_have_them(tmp_path: Path, kind: str, error: float) -> None:
    path = tmp_path / "anchor.lag"
    path.write_text(ANCHOR, encoding="utf-8")
    found = simulated(path, "2", kind, ["line.s"], stop_time=3.0, output_interval=0.1, relative_tolerance=1e-9)
    assert found["line.s"][-1] == pytest.approx(-0.45983793558, abs=error)


@pytest.mark.parametrize("stretch", ["distance(world.r, P.center.r) - 0.5", "abs(j.s) - 0.5"])
def test_equal_steps_give_way(scene: Write, stretch: str) -> None:
    """They cross what bends: others go on with error control, and are named."""
    model = scene(f"""model Through
      World world(gravity = {{0, 0}});
      Prismatic j(a = world, along = {{1, 0}}, s(start = 1.02));
      PointMass P(m = 1, center = j.b);
      Spring f(k = 1, stretch = {stretch});
    end Through;""")
    for tolerance in (1e-6, 1e-12):
        run = model.simulate(at=[10.0], tolerance=tolerance, solver="conservative")
        assert run["j.s"][-1] == pytest.approx(0.5609145768268, abs=max(tolerance, 2e-12))
        assert run.statistics.solver.name == "ERK"
        assert run.statistics.steps < 200
    calm = model.simulate(at=[10.0], tolerance=1e-9, solver="conservative", initial={"j.s": 0.9})
    assert calm.statistics.solver.name == "CONSERVATIVE"


@pytest.mark.parametrize("power", [4 / 3, 1.5])
@pytest.mark.parametrize("tolerance", [1e-3, 1e-9, 1e-12])
def test_where_no_series_leads_through_others_do(scene: Write, power: float, tolerance: float) -> None:
    """Their radius ends at the kink: auto at tight tolerances ended with "no step is small enough" on the way to it."""
    model = scene(f"""model Root
      World world(gravity = {{0, 0}});
      Block b(m = 1, base = world, s(start = 1));
    energy
      potential 1[J]*abs(b.s/1[m])^({power!r});
    end Root;""")
    quarter = beta(1 / power, 0.5) / power / np.sqrt(2)
    run = model.simulate(at=[quarter, 2 * quarter, 8 * quarter], tolerance=tolerance)
    np.testing.assert_allclose(run["b.s"], [0, -1, 1], rtol=0, atol=10 * tolerance + 1e-12)


@pytest.mark.parametrize("way", [0.0, 0.7])
def test_two_masses_that_drift_pass_through_each_other(way: float, scene: Write) -> None:
    """Rates were known to no more than rounding of places over a step: the shorter steps became, the less the jump counted (300
    tolerances of 1e-10, and an open account), and series took it for rounding."""
    c, s = math.cos(way), math.sin(way)
    pair = scene(f"""model Pair
      World world(gravity = {{0, 0}});
      PointMass a(m = 1, center(x(start = {-2 / 3 * c}), y(start = {-2 / 3 * s})));
      PointMass b(m = 2, center(x(start = {c / 3}), y(start = {s / 3})));
      Spring f(a = a.center, b = b.center, k = 10, s_rel0 = 0.4);
    initial equation
      der(a.center.x) = 0.8; der(a.center.y) = 1.04; der(b.center.x) = 0.8; der(b.center.y) = 1.04;
    end Pair;""")
    for solver in ("erk", "erk9", "adams", "pirk", "taylor", "implicit"):
        for tolerance in (1e-9, 1e-11):
            run = pair.simulate(solver=solver, tolerance=tolerance, at=[0.5, 1, 2])
            apart = c * (run["b.center.x"] - run["a.center.x"]) + s * (run["b.center.y"] - run["a.center.y"])
            assert apart == pytest.approx([0.1854407514, -0.8478781913, 0.4686495809], abs=2 * tolerance + 1e-10)
            assert not run.statistics.energy_is_open
