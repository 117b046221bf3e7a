"""delay(x, T): the method of steps against closed forms, and against steps by another integrator."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from helpers.fmus import VERSIONS, Instance, instance_of

TIMES = np.linspace(0, 5, 26)
OSCILLATOR = """model Late "x'' + 4 x = 1.5 x(t - T)"
  parameter Time T = 0.7;
  Block b(m = 1, base = world, along = {1, 0}, s(start = 0.3));
  Spring s(k = 4, stretch = b.s);
  Delay late(T = T, u = b.s);
  AppliedForce f(at = b.center, force = {1.5[N/m]*late.y, 0});
  annotation(experiment(StopTime = 5, Tolerance = 1e-11));
end Late;"""


def by_steps(slope: Callable[..., object], first: list[float], lag_time: float) -> Callable[[float], float]:
    """x of y' = slope(t, y, x(t - lag)), at rest before the start: an integration a lag, each with the one before as its past."""
    solutions, y = [], np.array(first)
    for k in range(int(np.ceil(5 / lag_time))):
        past = solutions[-1] if solutions else lambda t: np.array(first)
        begin, end = k * lag_time, (k + 1) * lag_time
        found = solve_ivp(lambda t, y, past=past: slope(t, y, past(t - lag_time)[0]), (begin, end), y, method="DOP853",
                          rtol=1e-13, atol=1e-15, dense_output=True, max_step=lag_time / 8)
        solutions.append(found.sol)
        y = found.y[:, -1]
    return lambda t: float(solutions[min(int(t / lag_time + 1e-9), len(solutions) - 1)](t)[0])


def test_a_delay_equation_is_its_polynomials() -> None:
    """x' = -x(t - 1), 1 before: the sum of (-1)^k (t - k + 1)^k / k! (R. Bellman, K.L. Cooke, 1963)."""
    model = lag.loads("model A Real x(start = 1); equation der(x) = -1[1/s]*delay(x, 1);"
                      " annotation(experiment(StopTime = 5, Tolerance = 1e-12)); end A;")
    run = model.simulate(at=TIMES)
    exact, factor = np.ones(len(TIMES)), 1.0
    for k in range(1, 7):
        factor /= -k
        exact += np.where(k - 1 < TIMES, factor * np.maximum(TIMES - (k - 1), 0) ** k, 0)
    assert np.abs(np.array(run["x"]) - exact).max() < 1e-14
    assert run.statistics.events == 4  # at 1, 2, 3, 4: what breaks at the start comes back


@pytest.mark.parametrize("solver", ["auto", "erk5", "adams", "implicit"])
def test_an_oscillator_with_late_feedback(solver: str) -> None:
    exact = by_steps(lambda t, y, late: [y[1], -4 * y[0] + 1.5 * late], [0.3, 0], 0.7)
    run = lag.loads(OSCILLATOR).simulate(at=TIMES, solver=solver)
    assert np.abs(np.array(run["b.s"]) - [exact(t) for t in TIMES]).max() < 1e-11


def test_what_was_before_the_start_is_stated() -> None:
    model = lag.loads("model A parameter Time T = 1; Real x(start = 0);"
                      " equation der(x) = -pi/2*1[1/s]*delay(x, T, before = sin(pi/2*1[1/s]*time));"
                      " annotation(experiment(StopTime = 5, Tolerance = 1e-12)); end A;")
    assert np.abs(np.array(model.simulate(at=TIMES)["x"]) - np.sin(np.pi / 2 * TIMES)).max() < 1e-13


@pytest.mark.parametrize(("first", "late"), [(1.0, 0.5), (1.0137, 0.5), (1.0, 0.4)])
def test_a_relay_that_acts_late_swings_between_straight_lines(first: float, late: float) -> None:
    """Its period is four delays; where it switches at a time at which something comes back as well, too."""
    model = lag.loads("model A parameter Real x0 = 1; parameter Time T = 0.5; Real x(start = x0);"
                      " equation der(x) = -1[1/s]*delay(if x > 0 then 1 else -1, T);"
                      " annotation(experiment(StopTime = 9, Tolerance = 1e-6)); end A;")
    times = np.linspace(0, 9, 37)
    phase = (times - first - late) % (4 * late)
    exact = np.where(times < first + late, first - times, np.where(phase < 2 * late, phase - late, 3 * late - phase))
    run = model.simulate(at=times, parameters={"x0": first, "T": late})
    assert np.abs(np.array(run["x"]) - exact).max() < 1e-13


def test_jumps_come_back_sharp() -> None:
    """Of a ball that bounces, of what is held, of an input, and of a delay of a delay."""
    model = lag.loads("""model A input Real u; Real h(start = 0); Real x(start = 0);
  Block b(m = 1, base = world, along = {0, 1}, s(start = 1));
  output Velocity v = delay(b.v, 0.2); output Real held = delay(h, 0.05); output Real given = delay(u, 0.35);
  output Real twice = delay(delay(u, 0.2), 0.15);
equation
  der(x) = 1[1/s]*given;
  when b.s < 0 then reinit(der(b.s), -0.8*der(b.s)); end when;
  when sample(0, 0.1) then h = time*1[1/s]; end when;
  annotation(experiment(StopTime = 2, Tolerance = 1e-10)); end A;""")
    times, table = np.linspace(0.41, 2, 16), ([0.0, 1.0, 1.0, 2.0], {"u": [0.0, 1.0, -1.0, 2.0]})
    late, early = model.simulate(at=times, inputs=table), model.simulate(at=times - 0.2, inputs=table)
    given = np.interp(times - 0.35, [0, 1, 1 + 1e-12, 2], [0, 1, -1, 2])
    assert np.abs(np.array(late["v"]) - np.array(early["b.v"])).max() < 1e-9
    assert np.abs(np.array(late["held"]) - np.floor((times - 0.05) / 0.1 + 1e-9) / 10).max() < 1e-12
    assert np.abs(np.array(late["given"]) - given).max() < 1e-11
    assert np.abs(np.array(late["twice"]) - given).max() < 1e-11
    rise, fall = (1.0**2) / 2, -1 * 0.65 + 3 * 0.65**2 / 2
    assert abs(late["x"][-1] - (rise + fall)) < 1e-9


def test_steps_snapshots_and_sweeps_have_their_own_past() -> None:
    model = lag.loads(OSCILLATOR)
    run = model.start()
    for _ in range(100):
        run.step(0.02)
    kept = run.save()
    first = [run.step(0.02) for _ in range(100)][-1]
    other = model.start()
    other.restore(kept)
    assert np.array_equal(first, [other.step(0.02) for _ in range(100)][-1])
    assert abs(first[0] - model.simulate(at=[4.0])["b.s"][0]) < 1e-11
    swept = model.simulate_many(parameters={"T": [0.3, 0.7, 2.0]}, outputs="final(b.s)")
    alone = [model.simulate(at=[5.0], parameters={"T": T})["b.s"][0] for T in (0.3, 0.7, 2.0)]
    assert np.abs(np.array(swept["final(b.s)"]) - alone).max() < 1e-12


@pytest.mark.parametrize(("text", "message"), [
    ("Real x(start = 1); equation der(x) = -1[1/s]*delay(x);", "L0215.*delay takes"),
    ("Real x(start = 1); equation der(x) = -1[1/s]*delay(x, 0);", "L0605.*must be positive"),
    ("Real x(start = 1); equation der(x) = -1[1/s]*delay(x, 1[m]);", "L0304.*a delay is in s"),
    ("Real x(start = 1); equation der(x) = -1[1/s]*delay(x, 1[s] + x*1[s]);", "L0901.*a delay that changes"),
    ("Real x(start = 1); output Real y = der(delay(x, 1)); equation der(x) = -1[1/s]*x;", "L0901.*the rate of a delayed value"),
    ("Block b(m = 1, base = world, along = {1, 0}); Spring s(k = 1, stretch = delay(b.s, 1));", "L0901.*in a potential energy"),
    ("Real x(start = 1); output Real y = x + delay(y, 1); equation der(x) = -1[1/s]*x;", "L0212.*follows from itself"),
    ("parameter Time T = delay(1, 2); Real x(start = 1); equation der(x) = -x/T;", "L06.*delay"),
    ("Block b(m = 1, base = world, along = {1, 0}); output Real y = delay(der(der(b.s)), 1);", "L0901.*delay of accelerations"),
])
def test_what_cannot_be_late_is_refused(text: str, message: str) -> None:
    with pytest.raises(lag.LagError, match=message):
        lag.loads(f"model A {text} end A;").simulate(at=[1.0])


def test_functions_have_no_past() -> None:
    with pytest.raises(lag.LagError, match=r"L0901.*delay in a function"):
        lag.loads("function f input Real x; output Real y = delay(x, 1); end f;"
                  " model A Real x(start = 1); output Real y = f(x); equation der(x) = -1[1/s]*x; end A;").simulate(at=[1.0])


def test_a_sum_with_its_own_past_is_a_comb() -> None:
    """y(t) = 1 + y(t - 1)/2, 2 before: it stays 2; 0 before: 1, 1.5, 1.75, ..., with jumps at all times and for good."""
    for before, wanted in ((2.0, [2.0, 2.0, 2.0]), (0.0, [1.0, 1.5, 2 - 0.5**12])):
        model = lag.loads(f"model A Real y = 1 + 0.5*delay(y, 1, before = {before}); Real x(start = 0); output Real z = y;"
                          " equation der(x) = 1[1/s]*y; annotation(experiment(StopTime = 13)); end A;")
        assert model.simulate(at=[0.5, 1.5, 12.5])["z"].tolist() == pytest.approx(wanted, abs=1e-14)


def test_delays_longer_than_the_run() -> None:
    model = lag.loads("model A Real x(start = 1); equation der(x) = -1[1/s]*delay(x, 1e6); end A;")
    assert model.simulate(at=[1.0])["x"][0] == pytest.approx(0, abs=1e-12)


def test_what_delays_have_not_is_refused_with_its_reason() -> None:
    model = lag.loads(OSCILLATOR)
    for ask in (model.linearize, model.modes, model.equilibrium, model.equations, model.functions):
        with pytest.raises(lag.LagError, match=r"L0901.*with delays"):
            ask()
    with pytest.raises(lag.LagError, match=r"cannot run this scene.*acts late"):
        model.simulate(at=[1.0], solver="taylor")
    with pytest.raises(lag.RunError, match="must be positive"):
        model.simulate(at=[1.0], parameters={"T": 0.0})


@pytest.mark.parametrize("version", VERSIONS)
def test_fmus_for_cosimulation_keep_the_past(version: str, tmp_path: Path) -> None:
    """A state that was saved has it, too; for Model Exchange there is none."""
    (tmp_path / "scene.lag").write_text(OSCILLATOR)
    with pytest.raises(lag.LagError, match=r"L0901.*Model Exchange"):
        lag.load(tmp_path / "scene.lag").export_fmu(tmp_path / "one.fmu", kind="me")
    one, other = (instance_of(tmp_path / "scene.lag", version, "CoSimulation", name) for name in ("one", "other"))

    def run(instance: Instance, first: int, last: int) -> float:
        for k in range(first, last):
            instance.step(0.05 * k, 0.05)
        return instance.get("b.s")[0]

    one.start(tolerance=1e-11)
    other.start(tolerance=1e-11)
    run(one, 0, 20)
    saved = one.fmu.getFMUState()
    first = run(one, 20, 80)
    one.fmu.setFMUState(saved)
    read = (other.fmu.deSerializeFMUstate if version == "2" else other.fmu.deserializeFMUState)(one.fmu.serializeFMUState(saved))
    other.fmu.setFMUState(read)
    assert first == run(one, 20, 80) == run(other, 20, 80)
    assert abs(first - lag.loads(OSCILLATOR).simulate(at=[4.0])["b.s"][0]) < 1e-11
    one.free()
    other.free()
