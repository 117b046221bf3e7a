"""Events whose conditions ask for forces: what breaks, load cells, counters of loads, contacts that their force ends."""

from collections.abc import Callable, Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from helpers.fmus import VERSIONS, simulated
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "erk9", "pirk", "implicit", "taylor")
G = 9.81

STRING = """model Breaks
  parameter Length L = 1; parameter Force most = 25;
  PointMass ball(m = 1);
  Length slack = L - distance(world, ball.center);
  Force T = contact_force(slack);
  {declared}
initial equation
  ball.center.x = -L; ball.center.y = 0; ball.center.v[1] = 0; ball.center.v[2] = -1;
equation
  {events}
  annotation(experiment(StopTime = 1.2));
end Breaks;"""
BY_ITSELF = STRING.format(declared="", events="when slack < 0 and T < most then reinit(der(slack), 0); end when;")
BY_NAME = STRING.format(declared="Boolean holds = slack < 0 and not T >= most;",
                        events="when holds then reinit(der(slack), 0); end when;")
REMEMBERED = STRING.format(declared="discrete Boolean broken(start = false);", events="""
  when T > most then broken = true; end when;
  when slack < 0 and not broken then reinit(der(slack), 0); end when;""")


def flown(t: float, most: float = 25) -> list[float]:
    """On the string w^2 = 1 + 2 g sin a and T = 1 + 3 g sin a, with the angle a below the level; from T = most on it flies."""
    a = np.arcsin((most - 1) / (3 * G))
    w = np.sqrt(1 + 2 * G * np.sin(a))
    span = solve_ivp(lambda x, y: [1 / np.sqrt(1 + 2 * G * np.sin(x))], (0, a), [0.0], rtol=1e-13, atol=1e-14).y[0, -1]
    d = t - span
    return [-np.cos(a) + w * np.sin(a) * d, -np.sin(a) - w * np.cos(a) * d - G * d**2 / 2]


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("text", [BY_ITSELF, BY_NAME, REMEMBERED])
def test_string_that_breaks(scene: Write, text: str, solver: str) -> None:
    """All were refused."""
    run = scene(text).simulate(at=[1.2], tolerance=1e-10, solver=solver)
    np.testing.assert_allclose([run["ball.center.x"][-1], run["ball.center.y"][-1]], flown(1.2), rtol=1e-9)
    assert run["broken"][-1] == 1


def test_string_that_is_strong_enough(scene: Write) -> None:
    run = scene(BY_ITSELF).simulate(at=[0.8], tolerance=1e-10, parameters={"most": 31})
    x, y = run["ball.center.x"][-1], run["ball.center.y"][-1]
    assert run["broken"][-1] == 0
    assert np.hypot(x, y) == pytest.approx(1, abs=1e-9)


def test_what_forces_break_in_sweeps(scene: Write) -> None:
    model = scene(BY_ITSELF)
    for most in (15.0, 20.0, 29.0):
        run = model.simulate(at=[1.2], tolerance=1e-10, parameters={"most": most})
        np.testing.assert_allclose([run["ball.center.x"][-1], run["ball.center.y"][-1]], flown(1.2, most), rtol=1e-8)


PUSHED = "World world(gravity = {0, 0}); Block m(m = 2, base = world, along = {0, 1});"
SCENES: Mapping[str, tuple[str, float, Mapping[str, float]]] = {
    "bearing": ("""World world(gravity = {0, 0}); Weld fixed(a = world); Disc d(m = 1, r = 1, center = fixed.b);
      AppliedTorque drive(on = fixed.b, torque = 10[N.m/s]*time); Block other(m = 1, base = world);
      discrete Real at(start = 0); discrete Boolean torn(start = false);
    equation
      when abs(fixed.reaction_torque) > 7 then torn = true; at = time; reinit(other.v, 3); end when;""",
                1.5, {"at": 0.7, "torn": 1, "other.s": 2.4}),
    "constraint": ("""World world(gravity = {0, 0}); Block m(m = 2, base = world), other(m = 1, base = world);
      discrete Real at(start = 0);
    equation
      m.s = 0.1[m]*sin(3[1/s]*time);
      when constraint_force(m.s) > 1 then at = time; reinit(other.v, 1); end when;""",
                   2.0, {"at": (np.pi + np.arcsin(1 / 1.8)) / 3, "other.s": 2 - (np.pi + np.arcsin(1 / 1.8)) / 3}),
    "lifts": ("""Block m(m = 1, base = world, along = {0, 1}); Length table = 0.1[m]*(1 - cos(12[1/s]*time));
      Length gap = m.s - table; discrete Integer n(start = 0); discrete Real at(start = 0);
    equation
      when gap < 0 then reinit(der(gap), 0); end when;
      when contact_force(gap) < 2 then n = pre(n) + 1; at = time; end when;""",
              0.2, {"n": 1, "at": np.arccos((2 - G) / 14.4) / 12}),
    "floor": (f"""{PUSHED} AppliedForce push(at = m.center, force = {{0, -10[N/s]*time}});
    equation
      when m.s < 0 and contact_force(m.s) < 5 then reinit(m.v, -0.5*pre(m.v)); end when;""",
              1.5, {"broken": 1, "m.s": -2.5 * ((1.5**3 - 0.125) / 3 - 0.25)}),
    "at the start": ("""Block m(m = 2, base = world, along = {0, 1});
    equation
      when m.s < 0 and contact_force(m.s) < 5 then reinit(m.v, 0); end when;""", 1.0, {"broken": 1, "m.s": -G / 2}),
    "by what it stops": ("""Block m(m = 1, base = world, along = {0, 1}, s(start = 1));
    equation
      when m.s < 0 and contact_force(m.s) < 5 then reinit(m.v, 0); end when;""",
                         1.0, {"broken": 1, "m.s": -G / 2 * (1 - np.sqrt(2 / G))**2}),
    "rests": ("""Block m(m = 1, base = world, along = {0, 1}, s(start = 1)); discrete Integer n(start = 0);
    equation
      when m.s < 0 then reinit(m.v, -0.5*pre(m.v)); end when;
      when contact_force(m.s) > 5 then n = pre(n) + 1; end when;""", 3.0, {"n": 1, "m.s": 0}),
    "Atwood": ("""Block a(m = 1, base = world, along = {0, 1}), b(m = 2, base = world, along = {0, 1});
      AppliedForce push(at = a.center, force = {0, -6[N/s]*time}); discrete Real at(start = 0);
    equation
      a.s = -b.s;
      when abs(constraint_force(a.s)) > 20 then at = time; end when;""", 2.0, {"at": 5 - G / 3, "a.s": (2 * G - 8) / 3}),
    "sticks": ("""World world(gravity = {0, 0}); Weld base(a = world); Block m(m = 1, base = base.b);
      DryFriction f(rate = m.v, F = 4); AppliedForce push(at = m.center, force = {5[N/s]*time, 0});
      discrete Real at(start = 0);
    equation
      when abs(base.reaction[1]) > 3 then at = time; end when;""", 2.0, {"at": 0.6, "m.s": 5 / 6 * 1.2**3}),
    "jumps in time": ("""World world(gravity = {0, 0}); Weld base(a = world); PointMass m(m = 1, center = base.b);
      AppliedForce f(at = base.b, force = {if mod(time, 0.5) > 0.25 then 10 else 0, 0}); discrete Integer n(start = 0);
    equation
      when abs(base.reaction[1]) > 5 then n = pre(n) + 1; end when;""", 2.1, {"n": 4}),
    "stop": ("""Block a(m = 1, base = world, along = {0, 1}); Stop floor(a = world, b = a.center, along = {0, 1});
      AppliedForce push(at = a.center, force = {0, -10[N/s]*time}); discrete Real at(start = 0), later(start = 0);
    equation
      when norm(floor.reaction) > 20 then at = time; end when;
      when floor.force > 22 then later = time; end when;""", 1.5, {"at": (20 - G) / 10, "later": (22 - G) / 10}),
}


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("name", SCENES)
def test_forces_on_paper(scene: Write, name: str, solver: str) -> None:
    text, t, right = SCENES[name]
    run = scene(f"model Scene {text} end Scene;").simulate(at=[t / 2, t], tolerance=1e-10, solver=solver)
    np.testing.assert_allclose([run[x][-1] for x in right], list(right.values()), rtol=1e-8, atol=1e-9)


SWINGS = """model Swings
  Revolute hinge(a = world, phi(start = 0.3)); Bar bar(m = 1, L = 1, a = hinge.b);
  Boolean over = norm(hinge.reaction) > 20;
  discrete Integer n(start = 0), ends(start = 0), changes(start = 0); discrete Real at(start = 0);
equation
  when edge(over) then n = pre(n) + 1; at = time; elsewhen not over then ends = pre(ends) + 1; end when;
  when change(over) then changes = pre(changes) + 1; end when;
end Swings;"""


def loads_of_swing(stop: float) -> np.ndarray:
    """When the bearing comes to bear 20 N."""
    def beyond(t: float, y: np.ndarray) -> float:
        phi, w, turns = *y, -1.5 * G * np.cos(y[0])
        x = -(np.sin(phi) * turns + np.cos(phi) * w**2) / 2
        return float(np.hypot(x, (np.cos(phi) * turns - np.sin(phi) * w**2) / 2 + G) - 20)
    beyond.direction = 1  # type: ignore[attr-defined]
    found = solve_ivp(lambda t, y: [y[1], -1.5 * G * np.cos(y[0])], (0, stop), [0.3, 0], rtol=1e-12, atol=1e-13, events=beyond)
    return np.asarray(found.t_events[0])


@pytest.mark.parametrize("solver", SOLVERS)
def test_loads_are_counted(scene: Write, solver: str) -> None:
    times = loads_of_swing(3.0)
    run = scene(SWINGS).simulate(at=[3.0], tolerance=1e-10, solver=solver)
    assert [run[x][-1] for x in ("n", "ends", "changes")] == [len(times), len(times), 2 * len(times)]
    assert run["at"][-1] == pytest.approx(times[-1], abs=1e-8)


LOOP = """model Loop
  Revolute h1(a = world, phi(start = 1.2)); Bar l1(m = 1, L = 1, a = h1.b);
  Revolute h2(a = l1.b); Bar l2(m = 1, L = 2, a = h2.b);
  Revolute h3(a = l2.b); Bar l3(m = 1, L = 1.5, a = h3.b);
  Frame ground; Revolute h4(a = l3.b, b = ground);
  discrete Integer n(start = 0); discrete Real at(start = 0);
equation
  ground = shift(world, {2, 0});
  when norm(h4.reaction) > 20 then n = pre(n) + 1; at = time; end when;
  annotation(experiment(StopTime = 2));
end Loop;"""


@pytest.mark.parametrize("solver", ["auto", "erk5", "erk9", "pirk", "implicit"])
def test_joint_of_a_loop(scene: Write, solver: str) -> None:
    """As its reaction says in rows beside it."""
    model = scene(LOOP.replace("discrete Integer", "output Force R = norm(h4.reaction); discrete Integer"))
    run = model.simulate(tolerance=1e-10, solver=solver)
    at = run["at"][-1]
    assert run["n"][-1] == 1
    beside = model.simulate(at=[at], tolerance=1e-11, solver="erk9")
    assert beside["R"][-1] == pytest.approx(20, abs=1e-7)


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
@pytest.mark.parametrize("version", VERSIONS)
def test_string_breaks_in_fmus(tmp_path: Path, version: str, kind: str) -> None:
    path = tmp_path / "breaks.lag"
    path.write_text(BY_ITSELF, encoding="utf-8")
    names = ["ball.center.x", "ball.center.y"]
    found = simulated(path, version, kind, names, stop_time=1.2, output_interval=0.024, relative_tolerance=1e-9)[-1]
    np.testing.assert_allclose([found[x] for x in names], flown(1.2), rtol=1e-5 if kind == "ModelExchange" else 1e-8)


@pytest.mark.parametrize("events", [
    "when slack < 0 and norm(hinge.reaction) < 3 then reinit(der(slack), 0); end when;",  # a contact that another force ends
    "when slack < 0 then reinit(der(slack), T/1[kg/s]); end when;",
    "when norm(hinge.reaction) > 3 then n = T/1[N]; end when; when slack < 0 then reinit(der(slack), 0); end when;",
])
def test_what_is_not_there_is_told(scene: Write, events: str) -> None:
    declared = "Revolute hinge(a = world); Bar bar(m = 1, L = 1, a = hinge.b); discrete Real n(start = 0);"
    text = STRING.format(declared=declared, events=events)
    text = text if "n = " in events else text.replace("discrete Real n(start = 0);", "")
    with pytest.raises(lag.LagError, match="L0914"):
        assert scene(text).scene


def test_events_that_undo_each_other_are_told(scene: Write) -> None:
    """Where a load acts, the bearing bears more, which takes it off."""
    model = scene("""model ToAndFro
      World world(gravity = {0, 0}); Weld base(a = world); PointMass m(m = 1, center = base.b);
      discrete Real F(start = 10);
      AppliedForce f(at = base.b, force = {F*(if time > 1 then 1 else 0), 0});
    equation
      when abs(base.reaction[1]) > 5 then F = 1; elsewhen abs(base.reaction[1]) < 2 then F = 10; end when;
    end ToAndFro;""")
    with pytest.raises(lag.RunError, match="event"):
        model.simulate(at=[2.0])
