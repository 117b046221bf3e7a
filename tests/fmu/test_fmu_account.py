"""The energy account of Model Exchange: what an importer's method misses is told, what is as right as its tolerance is not."""

from collections.abc import Callable, Iterator
from functools import partial
from math import asin, copysign, pi, sin, sqrt
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")

from fmpy.fmi1 import fmi1Warning

from helpers.fmus import EXAMPLES, VERSIONS, Instance, fmu_of, model_of, unpacked
from lagrangia.fmu.importer import Importer
from lagrangia.fmu.process import Inputs
from lagrangia.fmu.run import open_fmu, simulate_fmu
from lagrangia.run.request import Request

SPRING = """
model Swings
  Block b(m = 1, base = world, s(start = 1)); Spring s(k = 4, stretch = b.s); Damper d(c = 0.01, rate = b.v);
  annotation(experiment(StopTime = 10, Tolerance = 1e-6));
end Swings;
"""


@pytest.fixture(scope="module")
def swings(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("account") / "swings.lag"
    path.write_text(SPRING)
    return path


def answers(one: Instance, step: float, stop: float) -> list[int]:
    """Of completed steps: Euler's explicit method, which winds energy up."""
    name = "fmi2CompletedIntegratorStep" if one.version == "2" else "fmi3CompletedIntegratorStep"
    found: list[int] = []
    inner = getattr(one.fmu, name)
    setattr(one.fmu, name, lambda *arguments: found.append(inner(*arguments)) or found[-1])
    t = 0.0
    while t < stop:
        x = [a + step * b for a, b in zip(one.states(), one.slopes(), strict=True)]
        t += step
        one.fmu.setTime(t)
        one.set_states(x)
        one.fmu.completedIntegratorStep()
    return found


@pytest.mark.parametrize("version", VERSIONS)
def test_a_method_that_winds_energy_up_is_told(version: str, swings: Path, capfd: pytest.CaptureFixture[str]) -> None:
    one = Instance(swings, version, "ModelExchange").start(tolerance=1e-6)
    found = answers(one, 0.02, 4.0)
    first = found.index(fmi1Warning)
    assert 0 < first < 20 and set(found[first:]) == {fmi1Warning}
    assert one.get("energy.residual")[0] > 0.1
    told = capfd.readouterr().out
    assert told.count("energy account misses") == 1 and "smaller steps" in told
    one.fmu.reset()
    one.start(tolerance=1e-6)
    assert set(answers(one, 1e-6, 1e-4)) == {0}  # and forgotten
    one.free()


def test_what_keeps_its_tolerance_says_nothing(swings: Path) -> None:
    """Over 80 swings, and of a ball whose bounces come ever closer: each takes its energy once."""
    run = simulate_fmu(open_fmu(fmu_of(swings, "2")), Request(stop=80 * pi, interval=1.0), "me")
    assert not run.outcome.warns and not run.outcome.said
    names = ("energy.dissipated", "energy.total", "energy.residual")
    ball = simulate_fmu(open_fmu(fmu_of(EXAMPLES / "bouncing_ball.lag", "3")), Request(outputs=names, interval=0.1), "me")
    assert not ball.outcome.warns and abs(ball["energy.residual"]).max() < 1e-5
    assert ball["energy.dissipated"][-1] == pytest.approx(1.2753, abs=1e-5)  # 0.1 kg from 1.3 m, and 0.018 J stay


def test_lag_simulate_heeds_it(swings: Path) -> None:
    """Its importer, which makes it exit code 1."""
    importer = Importer(str(unpacked(swings, "3")), "ModelExchange")
    importer.initialise(0.0, 10.0, 1e-6, {}, lambda: None)
    for t, x, warns in ((0.1, [1.0, 0.0], False), (0.2, [2.0, 0.0], True)):
        importer.fmu.setTime(t)
        importer.set_states(x)
        assert not importer.completed_step() and importer.warns is warns
    importer.fmu.terminate()
    importer.fmu.freeInstance()


@pytest.mark.parametrize("version", VERSIONS)
def test_bends_at_the_start_are_not_passed(version: str, tmp_path: Path) -> None:
    """abs(sin(3 t)) at 0: an importer's first evaluations had -sin, until a step of its own was completed."""
    path = tmp_path / "bends.lag"
    path.write_text("""model Bends
  World world(gravity = {0, 0});
  Block b(m = 1, base = world);
  AppliedForce f(at = b.center, force = {2*abs(sin(3*time)), 0});
end Bends;""")
    one = Instance(path, version, "ModelExchange").start(tolerance=1e-9)
    for t in (0.001, 0.3, 1.0):
        one.fmu.setTime(t)
        assert one.slopes()[1] == pytest.approx(2 * sin(3 * t), rel=1e-12)
    one.free()


def test_long_steps_to_events_are_accounted_for(tmp_path: Path) -> None:
    """A step from row to row that ends at an event is no polynomial: 1.8e-4 J of 2 were told to be missed, with right states."""
    path = tmp_path / "pushed.lag"
    path.write_text("""model Pushed
  World world(gravity = {0, 0});
  Block a(m = 1.2, base = shift(world, {-1, -1}), along = {0, -1}, s(start = 0.5));
  Block b(m = 0.6, base = shift(world, {1, -1}), along = {0, -1}, v(start = 0.5));
  Rope rope(L = 5, a = a.center, pulley = {world}, b = b.center);
  Boolean on(start = false);
  AppliedForce f(at = b.center, force = {0, if on then -3 else 1});
equation
  when sin(4.5*time) > -0.4 then on = not pre(on); elsewhen b.v < -0.3 then on = false; end when;
end Pushed;""")
    run = simulate_fmu(open_fmu(fmu_of(path, "2")), Request(at=(0.0, 0.1, 0.2, 1.0, 3.0), tolerance=1e-9), "me")
    assert not run.outcome.warns and not run.outcome.said


def by_runge_kutta(one: Instance, u: Callable[[float], float], h: float, stop: float) -> Iterator[float]:
    """By RK4 with the input at each stage: the end of each step."""
    def slope(t: float, x: np.ndarray) -> np.ndarray:
        one.fmu.setTime(t)
        one.set({"u": u(t)})
        one.set_states(list(x))
        return one.slopes()

    for t in np.arange(round(stop / h)) * h:
        x = np.array(one.states())
        slope(t + 2 * h, x)  # a step that is too long
        a = slope(t, x)
        b = slope(t + h / 2, x + h / 2 * a)
        c = slope(t + h / 2, x + h / 2 * b)
        d = slope(t + h, x + h * c)
        slope(t + h, x + h / 6 * (a + 2 * b + 2 * c + d))
        one.fmu.completedIntegratorStep()
        yield t + h


@pytest.mark.parametrize("version", VERSIONS)
def test_what_is_held_at_an_input_follows_it_between_steps(version: str, tmp_path: Path) -> None:
    """A block that sticks on a belt: it went on with the rate of the latest event, and asked for one at each step."""
    path = tmp_path / "belt.lag"
    path.write_text("""model Belt
  input Velocity u = 0;
  World world(gravity = {0, 0});
  Block b(m = 1, base = world);
  Spring s(k = 2, stretch = b.s);
  DryFriction f(F = 3, rate = b.v - u);
  output Length s1 = b.s;
  output Velocity v1 = b.v;
end Belt;""")
    t = np.linspace(0, 2, 2001)
    moving = Inputs(("u",), t.tolist(), [[x] for x in (0.5 * np.sin(3 * t)).tolist()])
    wanted = Request(outputs=("s1", "v1"), stop=2.0, interval=0.01, tolerance=1e-6, inputs=moving)
    run = simulate_fmu(open_fmu(fmu_of(path, version)), wanted, "me")
    assert run["s1"] == pytest.approx((1 - np.cos(3 * run["time"])) / 6, abs=2e-4)  # 1.8e-3 off
    assert run["v1"] == pytest.approx(0.5 * np.sin(3 * run["time"]), abs=1e-3)


PUSHED = """
model Pushed
  input Velocity u = 0;
  World world(gravity = {0, 0});
  Block b(m = 1, base = world); Spring s(k = 2, stretch = b.s); %s
end Pushed;"""
HELD = {"friction": "DryFriction f(F = 3, rate = b.v - u);",
        "friction beside a spring": "DryFriction f(F = 3, rate = b.v - u); Spring g(k = 1, stretch = b.s - 0.1[s]*u);",
        "friction beside another's": "DryFriction f(F = 3, rate = b.v - u); Block c(m = 1, base = world); "
                                     "Spring g(k = 9, stretch = c.s - 0.1[s]*u);",
        "reset": "AppliedForce f(at = b.center, force = {-3, 0}); equation when b.v < u then reinit(b.v, u); end when;"}


@pytest.mark.parametrize("held", HELD)
@pytest.mark.parametrize("way", ["time first", "input first", "other inputs tried"])
def test_fixed_steps_of_importers_keep_what_is_held_at_an_input(held: str, way: str, tmp_path: Path) -> None:
    """What a step has drawn away, its event puts back: 4e-2 m/s off, and 1e-2 where inputs are set before the time. One that an
    energy knows, too, was taken for one at rest."""
    path = tmp_path / "pushed.lag"
    path.write_text(PUSHED % HELD[held])
    one = Instance(path, "2", "ModelExchange").start(tolerance=1e-6)

    def slope(t: float, x: np.ndarray) -> np.ndarray:
        one.set({"u": 0.5 * sin(3 * t)} if way == "input first" else {})
        one.fmu.setTime(t)
        for tried in (0.3, -0.2) if way == "other inputs tried" else ():
            one.set({"u": 0.5 * sin(3 * t) + tried})
            one.slopes()
        one.set({"u": 0.5 * sin(3 * t)} if way != "input first" else {})
        one.set_states(list(x))
        return one.slopes()

    h = 0.01
    for t in np.arange(100) * h:
        x = np.array(one.states())
        a = slope(t, x)
        b = slope(t + h / 2, x + h / 2 * a)
        c = slope(t + h / 2, x + h / 2 * b)
        slope(t + h, x + h / 6 * (a + 2 * b + 2 * c + slope(t + h, x + h * c)))
        if one.fmu.completedIntegratorStep()[0]:
            one.fmu.enterEventMode()
            one.fmu.newDiscreteStates()
            one.fmu.enterContinuousTimeMode()
        assert one.get("b.s", "b.v") == pytest.approx([(1 - np.cos(3 * t + 3 * h)) / 6, 0.5 * sin(3 * t + 3 * h)], abs=5e-5)
    one.free()


Slope = Callable[[float, np.ndarray], np.ndarray]


def _heun(slope: Slope, t: float, h: float, x: np.ndarray) -> np.ndarray:
    a = slope(t, x)
    return x + h / 2 * (a + slope(t + h, x + h * a))


def _midpoint(slope: Slope, t: float, h: float, x: np.ndarray) -> np.ndarray:
    return x + h * slope(t + h / 2, x + h / 2 * slope(t, x))


def _rk4(slope: Slope, t: float, h: float, x: np.ndarray) -> np.ndarray:
    a = slope(t, x)
    b = slope(t + h / 2, x + h / 2 * a)
    c = slope(t + h / 2, x + h / 2 * b)
    return x + h / 6 * (a + 2 * b + 2 * c + slope(t + h, x + h * c))


def _by_steps(one: Instance, u: Callable[[float], float], h: float, method: Callable[..., np.ndarray]) -> Iterator[float]:
    """By 60 steps that events come after alone: the end of each."""
    def slope(t: float, x: np.ndarray) -> np.ndarray:
        one.fmu.setTime(t)
        one.set({"u": u(t)})
        one.set_states(list(x))
        return one.slopes()

    for t in np.arange(60) * h:
        slope(t + h, method(slope, t, h, np.array(one.states())))
        if one.fmu.completedIntegratorStep()[0]:
            one.fmu.enterEventMode()
            one.fmu.newDiscreteStates()
            one.fmu.enterContinuousTimeMode()
        yield t + h


BESIDE = "Block c(m = 2, base = world); Spring t(k = 1, stretch = c.s); DryFriction g(F = 1, rate = c.v - u);"


@pytest.mark.parametrize("others", ["", BESIDE])
@pytest.mark.parametrize("method", [_heun, _midpoint, _rk4])
@pytest.mark.parametrize("u", [0.05, 0.5, -1.0])
def test_friction_lets_go_where_an_input_jumps_within_a_step(u: float, method: Callable[..., np.ndarray], others: str,
                                                             tmp_path: Path) -> None:
    """Without an event at the jump a block went along with its belt by any force, to 2.6 m/s for 1."""
    path, rate = tmp_path / "pushed.lag", sqrt(2)
    path.write_text(PUSHED % (HELD["friction"] + others))
    one, h, slips = Instance(path, "2", "ModelExchange").start(tolerance=1e-6), 0.01, asin(abs(u) * rate / 3) / rate
    for t in _by_steps(one, lambda t: u if t > 0.103 else 0.0, h, method):
        since = max(t - 0.103, 0)  # 3 N bring it to the speed of the belt
        speed = 3 / rate * sin(rate * since) if since < slips else abs(u)
        assert abs(one.get("b.v")[0] - copysign(speed, u)) < 3.3 * h
    one.free()


@pytest.mark.parametrize("method", [_heun, _midpoint, _rk4])
@pytest.mark.parametrize("u", [0.02, 0.5])
def test_what_pushes_is_followed_where_an_input_jumps_within_a_step(u: float, method: Callable[..., np.ndarray],
                                                                    tmp_path: Path) -> None:
    """A block stayed ahead of it by 0.6 m/s."""
    path = tmp_path / "pushed.lag"
    path.write_text(PUSHED % HELD["reset"])
    one = Instance(path, "2", "ModelExchange").start(tolerance=1e-6)
    for t in _by_steps(one, lambda t: u if t > 0.103 else 0.0, 0.01, method):
        assert t < 0.125 or one.get("b.v")[0] == pytest.approx(u, abs=1e-6)
    one.free()


def test_what_slips_goes_over_with_an_input_that_jumps(tmp_path: Path) -> None:
    """At an event: a block that the belt has left behind did not come to rest on it, but went on as if, for the next step."""
    path = tmp_path / "pushed.lag"
    path.write_text(PUSHED % HELD["friction"])
    one = Instance(path, "2", "ModelExchange").start(tolerance=1e-6)
    for begin, u, sense in ((0.0, 1.0, 1), (0.1, -2.0, -1), (0.2, 1.5, 1)):
        one.fmu.enterEventMode()
        one.set({"u": u})
        one.fmu.newDiscreteStates()
        one.fmu.enterContinuousTimeMode()
        place, speed = one.states()
        assert abs(speed) < 0.9 and one.slopes()[1] == pytest.approx(3 * sense - 2 * place, rel=1e-12)
        for t in begin + np.arange(1, 11) * 0.01:
            x = _rk4(partial(_slope_at, one), t - 0.01, 0.01, np.array(one.states()))
            _slope_at(one, t, x)
            assert not one.fmu.completedIntegratorStep()[0]
    one.free()


def _slope_at(one: Instance, t: float, x: np.ndarray) -> np.ndarray:
    one.fmu.setTime(t)
    one.set_states(list(x))
    return one.slopes()


@pytest.mark.parametrize("scene", ["Spring s(k = 20, stretch = b.s - 0.1[m]*u/1[m/s]); Damper d(c = 0.1, rate = b.v);",
                                   "DryFriction f(F = 3, rate = b.v - u);",
                                   "AppliedForce f(at = b.center, force = {u*1[kg/s], 0});"])
def test_tables_with_steps_are_accounted_for(scene: str, tmp_path: Path) -> None:
    """0.06 J missed with right rows: after an event the first evaluation had inputs of before it. Rows at steps were left out."""
    path = tmp_path / "stepped.lag"
    path.write_text("model Stepped input Velocity u = 0; World world(gravity = {0, 0}); Block b(m = 1, base = world); "
                    f"{scene} end Stepped;")
    times, values = [0, 0.3, 0.3, 0.6, 0.6, 1], [0.0, 0.0, 1.0, 1.0, -2.0, -2.0]
    moving = Inputs(("u",), times, [[x] for x in values])
    wanted = Request(outputs=("b.v", "energy.residual"), stop=1.0, interval=0.05, tolerance=1e-9, inputs=moving)
    run = simulate_fmu(open_fmu(fmu_of(path, "2")), wanted, "me")
    assert run["time"] == pytest.approx(np.arange(21) * 0.05) and abs(run["energy.residual"]).max() < 1e-6
    native = model_of(path).simulate(stop=1.0, interval=0.05, tolerance=1e-10, inputs=(times, {"u": values}))
    assert run["b.v"] == pytest.approx(native["b.v"], abs=1e-6)


@pytest.mark.parametrize("within", [0.0, 0.004])
@pytest.mark.parametrize("known_to", ["", " Spring g(k = 1, stretch = b.s - 0.1[s]*u);"], ids=["friction", "an energy, too"])
@pytest.mark.parametrize("rate", ["b.v - u", "b.v*(1 + u/1[m/s]) - 0.3[m/s]", "b.v - 0.7*u - u^2/1[m/s]"])
def test_derivatives_know_that_what_is_held_goes_with_its_input(rate: str, known_to: str, within: float, tmp_path: Path) -> None:
    """Against differences of what the FMU gives, at a completed step and behind it: rates of inputs were taken for 0."""
    path = tmp_path / "pushed.lag"
    path.write_text(PUSHED % f"DryFriction f(F = 3, rate = {rate});{known_to}")
    one, ramp = Instance(path, "3", "ModelExchange").start(tolerance=1e-6), lambda t: 0.3 * t + 0.1 * t**2
    t = [*by_runge_kutta(one, ramp, 0.01, 0.2)][-1] + within
    x = np.array(one.states()) + within * one.slopes()

    def acceleration(u: float, v: float) -> float:
        one.fmu.setTime(t)
        one.set({"u": u})
        one.set_states([x[0], v])
        return float(one.slopes()[1])

    assert abs(acceleration(ramp(t), x[1])) > 0.2
    found = [one.forward(["der(b.v)"], [known], [1.0])[0] for known in ("u", "b.v")]
    back = one.adjoint(["der(b.v)"], ["u", "b.v"], [1.0])
    e = 1e-5
    by_u = (acceleration(ramp(t) + e, x[1]) - acceleration(ramp(t) - e, x[1])) / (2 * e)
    by_v = (acceleration(ramp(t), x[1] + e) - acceleration(ramp(t), x[1] - e)) / (2 * e)
    assert found == pytest.approx([by_u, by_v], rel=1e-5, abs=1e-7) and back == pytest.approx(found, rel=1e-10, abs=1e-12)
    one.free()


LOADED = """
model Loaded
  input Real u = 0;
  World world(gravity = {0, 0});
  Block b(m = 1, base = world); Spring s(k = 100, stretch = b.s); AppliedForce w(at = b.center, force = {3*u, 0});
end Loaded;"""


def _euler(slope: Slope, t: float, h: float, x: np.ndarray) -> np.ndarray:
    return x + h * slope(t, x)


@pytest.mark.parametrize(("method", "is_told"), [(_euler, True), (_rk4, False)])
@pytest.mark.parametrize("u", [lambda t: sin(3 * t), lambda t: float(t > 0.103), lambda t: abs(t - 0.303)])
def test_a_load_by_inputs_does_not_silence_the_account(u: Callable[[float], float], method: Callable[..., np.ndarray],
                                                       is_told: bool, tmp_path: Path, capfd: pytest.CaptureFixture[str]) -> None:
    """Any input that was set within a step did for ever: 1e-2 J of 0.1. Jumps and bends within a step are not the method's."""
    path = tmp_path / "loaded.lag"
    path.write_text(LOADED)
    one = Instance(path, "2", "ModelExchange").start({"u": u(0)}, tolerance=1e-6)
    for _ in _by_steps(one, u, 0.01, method):
        pass
    one.free()
    assert ("energy account misses" in capfd.readouterr().out) == is_told


@pytest.mark.parametrize("version", VERSIONS)
def test_inputs_that_move_between_steps_are_accounted_for(version: str, tmp_path: Path) -> None:
    """What they work on a spring, and as a load: their last value was taken for the whole step, 0.05 and 0.02 J."""
    path = tmp_path / "drawn.lag"
    path.write_text("""model Drawn
  input Real u = 0;
  World world(gravity = {0, 0});
  Block b(m = 1, base = world);
  Spring s(k = 100, stretch = b.s - 0.1[m]*u);
  Damper d(c = 0.5, rate = b.v);
  AppliedForce w(at = b.center, force = {3*u, 0});
end Drawn;""")
    one = Instance(path, version, "ModelExchange").start(tolerance=1e-6)
    for _ in by_runge_kutta(one, lambda t: sin(3 * t), 0.01, 1.0):
        assert one.get("energy.residual")[0] == pytest.approx(0, abs=6e-5)
    t, x = 1.004, [a + 0.004 * b for a, b in zip(one.states(), one.slopes(), strict=True)]
    one.fmu.setTime(t)  # between two completed steps
    one.set({"u": sin(3 * t)})
    one.set_states(x)
    assert one.get("energy.residual")[0] == pytest.approx(0, abs=3e-3)
    assert one.get("energy.total")[0] > 0.02
    one.free()
