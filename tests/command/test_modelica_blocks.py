"""Blocks of the Modelica Standard Library that are imported: switches, tables, controllers; by closed forms and SciPy."""

from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.command.cli import main

SWITCHED = """model Switched
  import Modelica.Blocks.Interfaces;
  Interfaces.RealInput load "outside" annotation(Placement());
  Modelica.Blocks.Interfaces.RealOutput speed;
  Modelica.Mechanics.Rotational.Components.Inertia J(J=2, w(start=0, fixed=true), phi(start=0, fixed=true));
  Modelica.Mechanics.Rotational.Sources.Torque torque;
  Modelica.Mechanics.Rotational.Sensors.SpeedSensor sensor;
  Modelica.Blocks.Logical.Switch switch1;
  Modelica.Blocks.Logical.And and1;
  Modelica.Blocks.Sources.BooleanStep early(startTime=1), late(startTime=3, startValue=true);
  Modelica.Blocks.Sources.Constant on(k=4), off(k=0);
  Modelica.Blocks.Nonlinear.DeadZone dead(uMax=1);
  Modelica.Blocks.Math.Add add;
equation
  connect(early.y, and1.u1); connect(late.y, and1.u2); connect(and1.y, switch1.u2);
  connect(on.y, switch1.u1); connect(off.y, switch1.u3); connect(switch1.y, add.u1);
  connect(load, dead.u); connect(dead.y, add.u2); connect(add.y, torque.tau);
  connect(torque.flange, J.flange_a); connect(J.flange_b, sensor.flange); connect(sensor.w, speed);
end Switched;
"""
CONTROLLED = """model Controlled
  Modelica.Blocks.Continuous.LimPID PI(k=100, Ti=0.1, yMax=12, Ni=0.1, wd=0.5, limiter(u(start=0)), withFeedForward=false,
    controllerType=Modelica.Blocks.Types.SimpleController.%s, Td=0.1);
  Modelica.Mechanics.Rotational.Components.Inertia J(J=1, w(fixed=true, start=0), phi(fixed=true, start=0));
  Modelica.Mechanics.Rotational.Sources.Torque torque;
  Modelica.Mechanics.Rotational.Sensors.SpeedSensor sensor;
  Modelica.Blocks.Sources.TimeTable set(table=[0, 0; 0.5, 0; 1.5, 2; 3, 2]);
equation
  connect(torque.flange, J.flange_a); connect(sensor.flange, J.flange_b);
  connect(PI.y, torque.tau); connect(sensor.w, PI.u_m); connect(set.y, PI.u_s);
end Controlled;
"""
SIGNALS = """model Signals
  Modelica.Blocks.Sources.TimeTable rows(table=[0, 0; 1, 2; 1, 3; 4, 0], startTime=0.5, offset=1);
  Modelica.Blocks.Sources.CombiTimeTable two(table=[0, 0, 1; 2, 4, 5], offset={1, 2}, tableOnFile=false,
    extrapolation=Modelica.Blocks.Types.Extrapolation.LastTwoPoints);
  Modelica.Blocks.Sources.ExpSine dying(f=0.5, damping=2, amplitude=3, startTime=1);
  Modelica.Blocks.Sources.BooleanPulse pulse(width=25, period=2);
  Modelica.Blocks.Math.BooleanToReal number(realTrue=5, realFalse=-1);
  Modelica.Blocks.Logical.GreaterThreshold high(threshold=2); Modelica.Blocks.Logical.Not low;
  Modelica.Blocks.Math.BooleanToReal is_low; Modelica.Blocks.Math.Max larger;
  Modelica.Blocks.Interfaces.RealOutput a = rows.y, b = dying.y, c = number.y, d = is_low.y, e = larger.y;
  Modelica.Blocks.Interfaces.RealOutput f = two.y[1], g = two.y[2];
  Modelica.Mechanics.Rotational.Components.Inertia J(J=1, w(start=1, fixed=true));
equation
  connect(pulse.y, number.u); connect(rows.y, high.u); connect(high.y, low.u); connect(low.y, is_low.u);
  connect(rows.y, larger.u1); connect(dying.y, larger.u2);
end Signals;
"""
RELAY = """model Relay
  Modelica.Mechanics.Rotational.Components.Inertia J(J=1, w(fixed=true, start=0), phi(fixed=true, start=1.5));
  Modelica.Mechanics.Rotational.Components.Spring spring(c=4); Modelica.Mechanics.Rotational.Components.Fixed fixed;
  Modelica.Mechanics.Rotational.Sensors.AngleSensor a; Modelica.Mechanics.Rotational.Sources.Torque torque;
  Modelica.Blocks.Logical.Hysteresis hyst(uLow=-0.5, uHigh=0.5, pre_y_start=true);
  Modelica.Blocks.Logical.Switch sw; Modelica.Blocks.Sources.Constant p(k=-1), q(k=1);
  Modelica.Blocks.Tables.CombiTable1Ds tab(table=[-1, 1, 0; 0, 0, 0; 1, 1, 3]);
  Modelica.Blocks.Tables.CombiTable1D old(table=[-1, 1; 0, 0; 1, 1], smoothness=Modelica.Blocks.Types.Smoothness.%s);
  Modelica.Blocks.Interfaces.RealOutput y = tab.y[2], z = old.y[1];
equation
  connect(spring.flange_a, fixed.flange); connect(spring.flange_b, J.flange_a);
  connect(J.flange_b, a.flange); connect(a.phi, hyst.u); connect(hyst.y, sw.u2); connect(p.y, sw.u1); connect(q.y, sw.u3);
  connect(sw.y, torque.tau); connect(torque.flange, J.flange_b); connect(a.phi, tab.u); connect(a.phi, old.u[1]);
end Relay;
"""


def imported(folder: Path, text: str) -> lag.Model:
    (folder / "m.mo").write_text(text)
    assert main(["import", str(folder / "m.mo")]) == 0
    return lag.load(folder / "m.lag")


def test_switches_and_inputs(tmp_path: Path) -> None:
    run = imported(tmp_path, SWITCHED).simulate(at=[2.0, 4.0], inputs={"load": 3.0})
    assert run["speed"] == pytest.approx([(4 * 1 + 2 * 2) / 2, (4 * 2 + 2 * 4) / 2], abs=1e-9)


@pytest.mark.parametrize("kind", ["P", "PI", "PID"])
def test_controllers_with_limits(kind: str, tmp_path: Path) -> None:
    """The output is at its limit, and the integral follows it, while the wheel is run up."""
    def slope(t: float, x: np.ndarray) -> list[float]:
        w, i, f = x
        e = np.interp(t, [0.5, 1.5], [0, 2]) - w
        lead = 0.5 * (e + w) - w
        wanted = 100 * (e + ("I" in kind) * i + ("D" in kind) * 10 * (lead - f))
        y = np.clip(wanted, -12, 12)
        return [y, (e + (y - wanted) / 10) / 0.1, (lead - f) * 100]

    at = np.linspace(0.2, 3, 8)
    right = solve_ivp(slope, (0, 3), [0, 0, 0], "Radau", t_eval=at, rtol=1e-10, atol=1e-12, max_step=1e-2).y[0]
    run = imported(tmp_path, CONTROLLED % kind).simulate(at=[*at], tolerance=1e-10)
    assert run["J.w"] == pytest.approx(right, abs=1e-6)
    assert main(["export", str(tmp_path / "m.lag"), "--to", "modelica", "--components", "-o", str(tmp_path / "back.mo")]) == 0
    (tmp_path / "m.lag").unlink()
    again = imported(tmp_path, (tmp_path / "back.mo").read_text())
    assert [*again.simulate(at=[*at], tolerance=1e-10)["J.w"]] == [*run["J.w"]]


def test_sources_and_logic(tmp_path: Path) -> None:
    t = np.array([0.25, 1.0, 1.75, 2.25, 5.5])
    run = imported(tmp_path, SIGNALS).simulate(at=[*t])
    rows = np.where(t < 0.5, 1, 1 + np.where(t < 1.5, 2 * (t - 0.5), 3 - (t - 1.5)))
    dying = np.where(t < 1, 0, 3 * np.exp(-2 * (t - 1)) * np.sin(np.pi * (t - 1)))
    assert run["a"] == pytest.approx(rows) and run["b"] == pytest.approx(dying, abs=1e-12)
    assert [*run["c"]] == [5, -1, -1, 5, -1] and [*run["d"]] == [*(rows <= 2)]
    assert run["f"] == pytest.approx(1 + 2 * t) and run["g"] == pytest.approx(3 + 2 * t)
    assert run["e"] == pytest.approx(np.maximum(rows, dying))


def relayed(t: float) -> float:
    """The angle: about -1/4 until it falls below -1/2, about 1/4 until it rises above 1/2, and so on."""
    x, w, side, begin = 1.5, 0.0, 1, 0.0
    while True:
        size, phase = np.hypot(x + side / 4, w / 2), np.arctan2(-w / 2, x + side / 4)
        turns = (side * np.arccos(-side / 4 / size) - phase) % (2 * np.pi) / 2
        s = min(t - begin, turns)
        x, w = size * np.cos(2 * s + phase) - side / 4, -2 * size * np.sin(2 * s + phase)
        if t - begin <= turns:
            return x
        begin, side = begin + turns, -side


def test_hysteresis_and_tables_of_signals(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    at = np.linspace(0.1, 8, 12)
    run = imported(tmp_path, RELAY % "LinearSegments").simulate(at=[*at], tolerance=1e-10)
    phi = run["J.phi"]
    assert phi == pytest.approx([relayed(t) for t in at], abs=1e-8)
    assert run["y"] == pytest.approx(np.maximum(3 * phi, 0), abs=1e-14) and run["z"] == pytest.approx(np.abs(phi), abs=1e-14)
    (tmp_path / "m.mo").write_text(RELAY % "ConstantSegments")
    assert main(["import", str(tmp_path / "m.mo"), "-o", str(tmp_path / "told.lag")]) == 1
    assert "smoothness=Smoothness.ConstantSegments of old" in capsys.readouterr().err
