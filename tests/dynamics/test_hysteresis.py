"""Hysteresis: a relay with two thresholds, which switches by events, against closed forms."""

from pathlib import Path

import fmpy
import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import KINDS, VERSIONS, unpacked

THERMOSTAT = """model Thermostat "x' = y - x between two thresholds"
  parameter Real x0 = 0.5;
  Real x(start = x0);
  Hysteresis relay(low = 0.3, high = 0.7, off = 1, on = 0, u = x);
equation
  der(x) = 1[1/s]*(relay.y - x);
  annotation(experiment(StopTime = 6, Tolerance = 1e-10));
end Thermostat;"""
HALF = np.log(7 / 3)  # from one threshold to the other


@pytest.fixture(scope="module")
def thermostat() -> lag.Model:
    return lag.loads(THERMOSTAT)


def exact(t: np.ndarray) -> np.ndarray:
    """x from 0.5 on, rising."""
    first = np.log(0.5 / 0.3)
    phase = (t - first) % (2 * HALF)
    swinging = np.where(phase < HALF, 0.7 * np.exp(-phase), 1 - 0.7 * np.exp(-(phase - HALF)))
    return np.where(t < first, 1 - 0.5 * np.exp(-t), swinging)


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "adams", "implicit", "taylor", "pirk"])
def test_a_thermostat_swings_with_its_period(thermostat: lag.Model, solver: str) -> None:
    run = thermostat.simulate(at=np.linspace(0, 6, 25), solver=solver)
    assert np.abs(np.diff(run.events) - HALF).max() < 1e-11
    assert np.abs(np.array(run["x"]) - exact(np.linspace(0, 6, 25))).max() < 1e-10


@pytest.mark.parametrize(("x0", "y"), [(0.5, 1.0), (0.9, 0.0), (0.1, 1.0)])
def test_it_starts_as_its_input_says(thermostat: lag.Model, x0: float, y: float) -> None:
    assert thermostat.simulate(at=[0.0], parameters={"x0": x0})["relay.y"][0] == y


@pytest.mark.filterwarnings("error::RuntimeWarning")  # none of NumPy's reaches who compiles it
def test_a_mass_between_two_thresholds_swings_ever_farther() -> None:
    """m x'' = -F y, y = 1 from x = d on, -1 from x = -d on: parabolas, each of which begins with the rate of the one before."""
    model = lag.loads("""model A Block b(m = 1, base = world, along = {1, 0}, s(start = 0), v(start = 1));
  Hysteresis relay(low = -0.1, high = 0.1, off = -1, on = 1, first = -1, u = b.s/1[m]);
  AppliedForce f(at = b.center, force = {-2[N]*relay.y, 0});
  annotation(experiment(StopTime = 4, Tolerance = 1e-11)); end A;""")
    found = np.array(model.simulate(at=[4.0]).events)[::2]  # between these, it is back at the threshold
    times, x, v, sign = [], 0.0, 1.0, 1  # the force acts along `sign` until the threshold there
    for _ in range(len(found)):  # sign v t + t^2 = 0.1 - sign x
        t = (-sign * v + np.sqrt(v * v + 4 * (0.1 - sign * x))) / 2
        times.append(t)
        x, v, sign = 0.1 * sign, v + 2 * sign * t, -sign
    assert len(found) >= 3 and np.abs(found - np.cumsum(times)).max() < 1e-11


STRING = """model Breaks "ball on a string that breaks when it pulls more than 25 N: by the force that the motion takes"
  parameter Length L = 1;
  PointMass ball(m = 1);
  Length slack = L - distance(world, ball.center);
  Force T = ball.m/L*(dot(ball.center.v, ball.center.v) + dot({0, -9.81[m/s2]}, ball.center.r));
  Hysteresis torn(low = -1e9, high = 25, u = T/1[N]);
initial equation
  ball.center.x = -L; ball.center.y = 0; ball.center.v[1] = 0; ball.center.v[2] = -1;
equation
  when slack < 0 and torn.y < 0.5 then reinit(der(slack), 0); end when;
  annotation(experiment(StopTime = 1.2, Tolerance = 1e-9));
end Breaks;"""


def test_a_string_breaks_where_it_pulls_too_much() -> None:
    """Where 3 g sin + 1 = 25; the ball flies on, as by the contact's own force, beside other events."""
    sine, g = 24 / (3 * 9.81), 9.81
    run = lag.loads(STRING).simulate()
    broken = run.events[0]
    left, rate = 1.2 - broken, np.sqrt(1 + 2 * g * sine)
    x, y = -np.sqrt(1 - sine**2) + sine * rate * left, -sine - np.sqrt(1 - sine**2) * rate * left - g * left**2 / 2
    assert len(run.events) == 1 and (run["ball.center.x"][-1], run["ball.center.y"][-1]) == pytest.approx((x, y), abs=1e-8)
    for high in (24.3, 25.35, 25.41):  # found, and then put on the string, a rounding before: another event 1e-14 s later
        assert len(lag.loads(STRING.replace("high = 25", f"high = {high}")).simulate().events) == 1, high
    own = lag.loads(STRING.replace("torn.y < 0.5", "contact_force(slack) < 25")).simulate()
    assert (own["ball.center.x"][-1], own["ball.center.y"][-1]) == pytest.approx((x, y), abs=1e-8)


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_fmus_switch_where_the_run_does(version: str, kind: str, tmp_path: Path) -> None:
    (tmp_path / "scene.lag").write_text(THERMOSTAT)
    run = fmpy.simulate_fmu(str(unpacked(tmp_path / "scene.lag", version)), fmi_type=kind, stop_time=6, step_size=0.02,
                            relative_tolerance=1e-10, output=["x"], output_interval=0.02)
    assert np.abs(run["x"] - exact(run["time"])).max() < (1e-9 if kind == "CoSimulation" else 1e-3)


@pytest.mark.parametrize(("x0", "y"), [(0.1, 1.0), (0.5, 1.0), (0.9, 0.0)])
def test_what_would_switch_to_what_is_says_nothing(thermostat: lag.Model, x0: float, y: float) -> None:
    """Below `low` the relay is at `off` from the start: a line had said that its event holds already."""
    run = thermostat.simulate(at=[0, 0.1], parameters={"x0": x0})
    assert (run["relay.y"] == y).all() and not run.warnings
