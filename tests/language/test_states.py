"""First-order states, der(z) = f, and the signals of the library made of them: beside SciPy, closed forms and exact matrices."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.linalg import expm

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import main
from lagrangia.fmu.build import host_platform
from lagrangia.fmu.export import Export, export_fmu
from lagrangia.native.prebuilt import find_fmu
from lagrangia.run.library import has_runtime

Scene = Callable[[str], lag.Model]
pytestmark = pytest.mark.skipif(not has_runtime(), reason="no run time")

LUGRE = """model LuGre "Block pulled by a spring over bristles (Canudas de Wit et al., 1995)"
  parameter Stiffness s0 = 1e4[N/m]; parameter Damping s1 = 30, s2 = 0.4;
  parameter Force Fc = 1, Fs = 1.5; parameter Velocity vs = 0.01;
  Block block(m = 1, base = world);
  Length z(start = 0) "deflection of the bristles";
  Force g = Fc + (Fs - Fc)*exp(-(block.v/vs)^2);
  Force F = s0*z + s1*der(z) + s2*block.v;
  AppliedForce friction(at = block.center, force = {-F, 0}), pull(at = block.center, force = {2[N/m]*(0.1*time - block.s), 0});
equation
  der(z) = block.v - s0*abs(block.v)/g*z;
  annotation(experiment(StopTime = 6));
end LuGre;"""


@pytest.fixture(scope="module")
def slid() -> np.ndarray:
    """x, v and z at three times, by SciPy."""
    def slope(t: float, y: np.ndarray) -> list[float]:
        g = 1 + 0.5 * np.exp(-((y[1] / 0.01) ** 2))
        rate = y[1] - 1e4 * abs(y[1]) / g * y[2]
        return [y[1], 2 * (0.1 * t - y[0]) - 1e4 * y[2] - 30 * rate - 0.4 * y[1], rate]

    return solve_ivp(slope, (0, 12), np.zeros(3), method="Radau", rtol=1e-11, atol=1e-14, t_eval=[3, 7, 12]).y


@pytest.mark.parametrize("solver", ["auto", "erk", "erk9", "implicit", "casadi:cvodes"])
def test_bristles(solver: str, scene: Scene, slid: np.ndarray) -> None:
    run = scene(LUGRE).simulate(at=[3, 7, 12], tolerance=1e-11, solver=solver)
    close = 1e-10 if solver != "casadi:cvodes" else 1e-7
    assert np.array([run[name] for name in ("block.s", "der(block.s)", "z")]) == pytest.approx(slid, abs=close)
    assert np.abs(run.energy.residual).max() < 1e-9  # of the mechanism alone


FILTERS = """model Filters "What the block's force goes through, and what it moves"
  Block block(m = 2, base = world, s(start = 0.3));
  FirstOrder lag(T = 0.2, k = 3, u = block.s/1[m], y(start = 1));
  SecondOrder sway(w = 4, zeta = 0.3, u = sin(2*time));
  Integrator sum(k = 2, u = 1);
  Sensor sensor(T = 0.5, gain = 10, offset = 1, u = lag.y);
  RateLimiter slow(up = 0.5, down = 0.25, T = 1e-3, u = if time < 1 then 1 else 0);
  Limiter cut(low = -1, high = 2, u = sum.y);
  AppliedForce f(at = block.center, force = {-1[N]*lag.y, 0});
  output Real clipped = cut.y; output Real y = sway.y;
end Filters;"""


@pytest.mark.parametrize("solver", ["auto", "erk", "pirk", "taylor", "adams"])
def test_filters_by_their_matrices(solver: str, scene: Scene) -> None:
    model = scene(FILTERS)
    if solver in ("taylor", "pirk") and solver in model.scene.refused:
        return
    run = model.simulate(at=[0.7, 1.5], tolerance=1e-11, solver=solver)
    # x, v, lag.y, sensor.y, sum.y, sway.y, its rate, sin 2t, cos 2t, 1
    A = np.zeros((10, 10))
    A[0, 1] = 1
    A[1, 2] = -0.5
    A[2, [0, 2]] = 3 / 0.2, -1 / 0.2
    A[3, [2, 3, 9]] = 20, -2, 2
    A[4, 9] = 2
    A[5, 6] = 1
    A[6, [5, 6, 7]] = -16, -2.4, 16
    A[7, 8], A[8, 7] = 2, -2
    start = np.array([0.3, 0, 1, 0, 0, 0, 0, 0, 1, 1.0])
    names = ("block.s", "der(block.s)", "lag.y", "sensor.y", "sum.y", "sway.y", "sway.rate")
    for k, t in enumerate((0.7, 1.5)):
        assert [run[name][k] for name in names] == pytest.approx((expm(A * t) @ start)[:7].tolist(), abs=1e-10)
    assert run["clipped"] == pytest.approx([1.4, 2.0], abs=1e-11)
    assert run["slow.y"] == pytest.approx([0.35, 0.5 - 0.125], abs=1e-3)
    assert run["y"].tolist() == run["sway.y"].tolist()


SERVO = """model Servo "Shaft that a motor brings to an angle"
  parameter Real high = 24;
  Revolute axle(a = world); Disc rotor(m = 2, r = 0.1, center = axle.b);
  DCMotor motor(a = world, b = rotor.center, R = 1, L = 0.01, k = 0.5);
  Sensor sensor(T = 0.002);
  PID control(k = 20, Ti = 0.5, Td = 0.05, low = -high, high = high, set = 1);
  TorsionDamper damper(a = world, b = rotor.center, c = 0.01);
  output Angle phi = axle.phi;
equation
  connect(axle.phi, sensor.u);
  connect(sensor.y, control.u);
  connect(control.y, motor.V);
end Servo;"""
STATES = ("axle.phi", "der(axle.phi)", "motor.i", "sensor.y", "control.I", "control.slow")


def closed_loop(y: np.ndarray, high: float) -> np.ndarray:
    phi, w, i, s, integral, slow = y
    e = 1 - s
    wanted = 20 * (e + integral + 10 * (e - slow))
    V = np.clip(wanted, -high, high)
    back = (V - wanted) / (20 * np.sqrt(0.5 * 0.05))
    return np.array([w, (0.5 * i - 0.01 * w) / 0.01, (V - i - 0.5 * w) / 0.01, (phi - s) / 0.002, e / 0.5 + back,
                     (e - slow) * 10 / 0.05])


@pytest.mark.parametrize("high", [24.0, 1e6])
def test_a_servo_within_limits_and_without(high: float, scene: Scene) -> None:
    model = scene(SERVO)
    run = model.simulate(at=[0.05, 0.4, 1.0], tolerance=1e-11, parameters={"high": high})
    other = solve_ivp(lambda t, y: closed_loop(y, high), (0, 1), np.zeros(6), method="Radau", rtol=1e-11, atol=1e-13,
                      t_eval=[0.05, 0.4, 1.0]).y
    assert np.array([run[name] for name in STATES]) == pytest.approx(other, abs=2e-8)
    sweep = model.simulate_many(parameters={"high": [high]}, outputs=["final(axle.phi)"], stop=1.0, tolerance=1e-11)
    assert sweep["final(axle.phi)"] == pytest.approx([run["axle.phi"][-1]], abs=1e-9)


def test_rest_and_small_motion_of_a_servo(scene: Scene) -> None:
    """The states rest as well; A is that of the closed loop, which differences give to rounding where nothing is clipped."""
    model = scene(SERVO)
    rest = model.equilibrium()[0]
    found = [rest.position[name] for name in ("axle.phi", "motor.i", "sensor.y", "control.I")]
    assert found == pytest.approx([1, 0, 1, 0], abs=1e-12)
    assert rest.stability == "asymptotically stable"
    linear = model.linearize(excitations=["control.set"], outputs=["phi"])
    at = np.array([1, 0, 0, 1, 0, 0.0])
    columns = [(closed_loop(at + x, 1e9) - closed_loop(at - x, 1e9)) / 2 for x in np.eye(6)]
    places = [linear.states.index(name) for name in STATES]
    assert linear.A[np.ix_(places, places)] == pytest.approx(np.array(columns).T, abs=1e-9)
    assert linear.B[places, 0] == pytest.approx(np.array([0, 0, 20 * 11 / 0.01, 0, 2, 200]), rel=1e-12)
    steady = model.response("control.set", "phi", frequencies=[1e-6])
    assert np.abs(steady.values).ravel() == pytest.approx([1.0], abs=1e-6)
    with pytest.raises(lag.LagError, match="natural modes of scenes with first-order states"):
        model.modes()


def test_fmus_have_states(scene: Scene, tmp_path: Path) -> None:
    if not find_fmu(data_folder("runtime"), "3"):
        pytest.skip("no library for FMUs")
    path = tmp_path / "servo.fmu"
    export_fmu(scene(SERVO), Export("3", platforms=(host_platform(),), engine="tape", sources=False), path)
    assert main(["fmu", "check", str(path)]) == 0


def test_starts_events_and_columns(scene: Scene, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A tank that is emptied when it is full; its level has a column, and no integral has one."""
    model = scene("""model Tank
      Block float(m = 1, base = world);
      parameter Real first = 0.25;
      Real level(start = first, fixed = true);
      AppliedForce push(at = float.center, force = {1[N]*level, 0});
    equation
      der(level) = 0.5[1/s];
      when level > 1 then reinit(level, 0); end when;
    end Tank;""")
    run = model.simulate(at=[1.0, 2.0], tolerance=1e-10)
    assert run["level"] == pytest.approx([0.75, 0.25], abs=1e-10)
    area = 0.25 * 1.5 + 0.25 * 1.5**2  # until 1.5 s, and from there on anew
    assert run["der(float.s)"][1] == pytest.approx(area + 0.25 * 0.5**2, abs=1e-9)
    energy = run.energy  # what empties the tank does nothing to the float
    assert (energy.dissipated[-1], energy.work[-1]) == pytest.approx((0.0, run["der(float.s)"][1] ** 2 / 2), abs=1e-9)
    assert model.simulate(at=[1.0], initial={"level": 0.1})["level"] == pytest.approx([0.6], abs=1e-10)
    assert model.simulate(at=[1.0], parameters={"first": 0.0})["level"] == pytest.approx([0.5], abs=1e-10)
    run.to_csv(tmp_path / "rows.csv")
    assert (tmp_path / "rows.csv").read_text().splitlines()[0] == "time,float.s,der(float.s),level"
    assert list(run.to_pandas().columns) == ["float.s", "der(float.s)", "level"]
    assert main(["check", str(model.path)]) == 0
    told = capsys.readouterr().out
    assert "1 degree of freedom" in told and "first-order states level" in told
    with pytest.raises(lag.LagError, match="written equations of scenes with first-order states"):
        model.equations()


def test_a_controller_does_not_lengthen_chains(scene: Scene) -> None:
    """Accelerations of many links still come along the tree of bodies."""
    links, joined = "Revolute h[20]; Bar l[20](each m = 1, each L = 0.5);", """connect(world, h[1].a);
      for i in 1:20 loop connect(h[i].b, l[i].a); end for; for i in 1:19 loop connect(l[i].b, h[i+1].a); end for;"""
    plain = scene(f"model Chain {links} equation {joined} end Chain;")
    held = scene(f"""model Held {links} AppliedTorque m(on = l[1].center, torque = -1[N.m]*z); Real z(start = 0);
      equation {joined} der(z) = 5[1/s]*(h[1].phi - z); end Held;""")
    assert held.scene.notes["rhs_operations"] < 1.1 * plain.scene.notes["rhs_operations"] + 20


@pytest.mark.parametrize("equation", ["T*der(F) = 10 - F", "10 - F = der(F)*T", "der(F) + F/T = 10/T", "F - 10 = -(T*der(F))",
                                      "der(F)/2 = (10 - F)/(2*T)", "10 - T*der(F) = F"])
def test_equations_are_solved_for_rates(equation: str, scene: Scene) -> None:
    """T F' = u - F had been refused where it was not written as F' = ..."""
    model = scene(f"""model Lag
      parameter Time T = 0.2; Force F;
      Block b(m = 1, base = world); AppliedForce push(at = b.center, force = {{F, 0}});
    equation
      {equation.replace("10", "10[N]")};
    end Lag;""")
    assert model.simulate(at=[0.5])["F"][-1] == pytest.approx(10 * (1 - np.exp(-2.5)), abs=1e-7)


BRISTLES = """model A
  Block b(m = 1, base = world); Spring pull(k = 2, stretch = 0.1[m/s]*time - b.s);
  coordinate Length z; Velocity rate = b.v - abs(b.v)*1e3[1/m]*z;
  AppliedForce rub(at = b.center, force = {-(1e3[N/m]*z + 30[N.s/m]*rate), 0});
equation
  der(z) = rate;
  MORE
end A;"""


@pytest.mark.parametrize("more", ["", "der(b.s)", "F = 2*z;", "der(F) = -2[1/s]*z;",
                                  "F = z; when time > 2 then reinit(z, 0); end when;"])
def test_coordinates_that_forces_alone_read_are_states(more: str, scene: Scene) -> None:
    """der(z) may be anything: nothing holds it, as z moves no mass."""
    text = BRISTLES.replace("MORE", more if "=" in more else "")
    text = text.replace("der(z) = rate", "der(z) = b.v - abs(der(b.s))*1e3[1/m]*z") if more == "der(b.s)" else text
    text = text.replace("coordinate", "output Length F; coordinate") if "=" in more else text
    model, plain = scene(text), lag.loads(text.replace("coordinate Length z", "Length z(start = 0)"))
    assert "z" in model.scene.signals.values()
    assert model.simulate(at=[1, 3])["z"] == pytest.approx(plain.simulate(at=[1, 3])["z"], rel=1e-12)


@pytest.mark.parametrize("more", ["z = 1e-3*b.s;", "potential", "frame"])
def test_coordinates_that_move_something_are_none(more: str, scene: Scene) -> None:
    text = BRISTLES.replace("MORE", more if "=" in more else "")
    text = text.replace("equation\n", "energy potential 3[N/m]*z^2;\nequation\n") if more == "potential" else text
    text = text.replace("coordinate", "PointMass p(m=1, center = shift(world, {z, 0})); coordinate") if more == "frame" else text
    with pytest.raises(lag.LagError, match="L0412"):
        scene(text)


def test_an_array_of_states_is_told(scene: Scene) -> None:
    """It was a KeyError."""
    with pytest.raises(lag.LagError, match=r"L0906.*array of coordinates 'f'"):
        scene("""model Lags
          Block b(m = 1, base = world, v(start = 2));
          coordinate Length f[2];
        equation
          for i in 1:2 loop 0.1*i*der(f[i]) + f[i] = b.s; end for;
        end Lags;""")
