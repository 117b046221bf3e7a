"""Gears with losses by the equations of the Modelica Standard Library's LossyGear, and what else its examples need."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.draw.film import animate_run
from lagrangia.editor.modelica_import import imported

Scene = Callable[[str], lag.Model]
Rows = list[list[float]]


def loss(tau: float, sign: float, row: np.ndarray) -> float:
    """tauLoss at a torque of flange_a: quadrants 1 to 4 of LossyGear, whose side that drives is found with tau_bf_a."""
    eta1, eta2, bf1, bf2 = row
    bearing = (bf1 - bf2) / (eta1 - 1 / eta2) if eta1 * eta2 < 1 else bf1 / 2
    if tau - sign * bearing >= 0:
        return (1 - eta1) * tau + bf1 if sign > 0 else (1 - 1 / eta2) * tau - bf2
    return (1 - 1 / eta2) * tau + bf2 if sign > 0 else (1 - eta1) * tau - bf1


class Drive:
    """J = 1 and 1.5 beside a gear of ratio 2, driven by 10 sin(2 pi t) and held back by 2.5 t."""

    def __init__(self, table: Rows) -> None:
        self.rows = np.array(table)

    def row(self, w: float) -> np.ndarray:
        first, last = self.rows[0], self.rows[-1]
        return first[1:] + (last[1:] - first[1:]) * abs(w) / max(last[0], 1e-300) if len(self.rows) > 1 else first[1:]

    def acceleration(self, t: float, w: float, sign: float) -> float:
        """By bisection of the torque of flange_a, which the equation of the second wheel decides."""
        low, high = -1e3, 1e3
        for _ in range(100):
            tau = (low + high) / 2
            miss = -5 * t + 4 * (tau - loss(tau, sign, self.row(w))) - 1.5 * (first(t) - tau)
            low, high = (low, tau) if miss > 0 else (tau, high)
        return first(t) - (low + high) / 2

    def excess(self, t: float) -> tuple[float, float]:
        """By how much more than there is it takes to hold it, forward and backward."""
        needed, row = first(t) - 1.25 * t, self.row(0)
        return needed - loss(first(t), 1.0, row), loss(first(t), -1.0, row) - needed

    def torn_off(self, t: float, end: float) -> tuple[float, float]:
        """When what stands still moves again, and to which side."""
        over = next((s for s in np.linspace(t, end, 20_001) if max(self.excess(s)) > 0), end)
        low, high = max(t, over - (end - t) / 20_000), over
        for _ in range(60):
            middle = (low + high) / 2
            low, high = (low, middle) if max(self.excess(middle)) > 0 else (middle, high)
        return high, 1.0 if self.excess(over)[0] > 0 else -1.0


def first(t: float) -> float:
    return float(10 * np.sin(2 * np.pi * t))


def moved(drive: Drive, end: float) -> np.ndarray:
    """Angle and rate of flange_a."""
    t, y, sign = 0.0, np.zeros(2), 0.0
    while t < end:
        if sign == 0:
            t, sign = drive.torn_off(t, end)

        def stops(_: float, y: np.ndarray) -> float:
            return float(y[1])
        stops.terminal, stops.direction = True, -sign  # type: ignore[attr-defined]
        found = solve_ivp(lambda s, y, sign=sign: [y[1], drive.acceleration(s, y[1], sign)], (t, end), y, "DOP853", rtol=1e-10,
                          atol=1e-13, events=stops)
        t, y = found.t[-1], found.y[:, -1]
        if found.status == 1:
            y[1], sign = 0.0, 0.0 if max(drive.excess(t)) <= 0 else -sign
    return y


@pytest.mark.parametrize("table", [
    [[0, 0.5, 0.5, 0, 0]], [[0, 0.8, 0.6, 0.1, 0.15]], [[0, 0.8, 0.8, 0.1, 0.1], [1, 0.7, 0.6, 0.2, 0.3]], [[0, 0.25, 0.3, 0, 0]],
    [[0, 1, 1, 0.2, 0.2]]])
def test_a_lossy_gear(scene: Scene, table: Rows) -> None:
    """As in LossyGearDemo1, forward, stuck and backward, with tables of other losses; self-locking ones among them."""
    rows = "; ".join(", ".join(map(str, row)) for row in table)
    run = scene(f"""model M import Rotational.*;
      Inertia a(J = 1), b(J = 1.5); Torque m(tau = 10[N.m]*sin(2*pi*time/1[s]), flange = a.flange_a);
      Torque load(tau = -2.5[N.m/s]*time, flange = b.flange_b);
      LossyGear gear(ratio = 2, lossTable = [{rows}], flange_a = a.flange_b, flange_b = b.flange_a); end M;
      """).simulate(at=[0.9], tolerance=1e-11)
    assert [run["a.phi"][-1], run["a.w"][-1]] == pytest.approx(moved(Drive(table), 0.9), abs=1e-8)


def test_torques_of_clutches_that_stick(scene: Scene) -> None:
    """While it sticks a clutch hands on what the second wheel takes: 2/3 of the torque."""
    run = scene("""model M import Rotational.*;
      output Real tau = c.tau; Inertia a(J = 1), b(J = 2); Torque m(tau = 3, flange = a.flange_a);
      Clutch c(fn_max = 5, f_normalized = 1, flange_a = a.flange_b, flange_b = b.flange_a); end M;""").simulate(at=[0.5, 1.0])
    assert np.abs(run["tau"]) == pytest.approx([2.0, 2.0], rel=1e-12)
    slips = scene("""model M import Rotational.*;
      output Real tau = c.tau; Inertia a(J = 1, w(start = 10)), b(J = 2);
      Clutch c(fn_max = 5, f_normalized = 1, flange_a = a.flange_b, flange_b = b.flange_a); end M;""").simulate(at=[0.5])
    assert slips["tau"][-1] == pytest.approx(-2.5, rel=1e-12)  # flange_b is behind


def test_a_backlash_whose_damper_acts_at_once(scene: Scene) -> None:
    """ElastoBacklash2, with its steps of the torque, beside SciPy."""
    run = scene("""model M import Rotational.*;
      Inertia a(J = 5, phi(start = 1)); Fixed f;
      ElastoBacklash2 e(c = 2e3, d = 50, b = 0.6, flange_a = f.flange, flange_b = a.flange_a); end M;
      """).simulate(at=[1.0], tolerance=1e-11)
    side, t, y = 1.0, 0.0, np.array([1.0, 0.0])
    while t < 1:  # pressed to one side, until nothing presses; then free, until it is at a side
        def force(y: np.ndarray, side: float = side) -> float:
            return 2e3 * (y[0] - side * 0.3) + 50 * y[1]

        ends = [lambda _, y: force(y)] if side else [lambda _, y: y[0] - 0.3, lambda _, y: y[0] + 0.3]
        for k, end in enumerate(ends):
            end.terminal, end.direction = True, -side if side else (1, -1)[k]  # type: ignore[attr-defined]
        found = solve_ivp(lambda _, y, side=side: [y[1], -force(y) / 5 if side else 0.0], (t, 1.0), y, "DOP853", rtol=1e-12,
                          atol=1e-13, events=ends)
        t, y = found.t[-1], found.y[:, -1]
        side = 0.0 if side else float(np.sign(y[1]))
    assert [run["a.phi"][-1], run["a.w"][-1]] == pytest.approx(y, abs=1e-8)


def test_starts_of_relative_positions(scene: Scene) -> None:
    """Fixed, they are initial equations; guesses have no effect, and this is told."""
    model = scene("""model M import Translational.*;
      Fixed f(s0 = 1); Spring s(c = 100, s_rel0 = 1, s_rel(start = 1.5, fixed = true)); Mass m(m = 1, L = 1, v(start = 0));
      SpringDamper d(c = 10, d = 1, s_rel(start = 2, fixed = true), v_rel(fixed = true)); Mass n(m = 2);
    equation
      connect(f.flange, s.flange_a); connect(s.flange_b, m.flange_a);
      connect(m.flange_b, d.flange_a); connect(d.flange_b, n.flange_a);
    end M;""")
    run = model.simulate(at=[0.0])
    assert [run["m.s"][0], run["n.s"][0]] == pytest.approx([1 + 1.5 + 0.5, 1 + 1.5 + 1 + 2], abs=1e-12)
    guess = scene("""model M import Translational.*; Fixed f; Mass m(m = 1, s(start = 2));
      Spring s(c = 1, s_rel(start = 7), flange_a = f.flange, flange_b = m.flange_a); end M;""")
    assert any("L0608" in text for text in guess.warnings)
    assert guess.simulate(at=[0.0])["m.s"][0] == 2.0


def test_sensors_of_several_quantities(scene: Scene) -> None:
    run = scene("""model M import Rotational.*;
      output Real tau = s.tau; output Power power = s.power;
      Inertia a(J = 1), b(J = 2); Torque m(tau = 3, flange = a.flange_a);
      MultiSensor s(flange_a = a.flange_b, flange_b = b.flange_a); end M;""").simulate(at=[2.0])
    assert [run["tau"][-1], run["power"][-1]] == pytest.approx([2.0, 4.0], rel=1e-11)


def test_arguments_without_a_meaning_are_left_out(tmp_path: Path) -> None:
    """What tells Modelica's tools how to begin, and flows of connectors."""
    found = imported("""model A
      Modelica.Mechanics.Rotational.Components.OneWayClutch c(fn_max = 3, startForward(fixed = true), stuck(fixed=true),
        peak = 2);
      Modelica.Units.SI.Power P = c.flange_a.tau*2;
    end A;""")
    assert "c(fn_max = 3, peak = 2)" in " ".join(found.text.split())
    assert found.left_out == ("Modelica.Units.SI.Power P = c.flange_a.tau*2;",)


def test_an_animation_without_a_picture_says_so(scene: Scene, tmp_path: Path) -> None:
    model = scene("model M import Rotational.*; Inertia a(J = 1, w(start = 1)); Damper d(d = 1, flange_a = a.flange_b); Fixed f; "
                  "equation connect(d.flange_b, f.flange); end M;")
    told = list[str]()
    animate_run(model.simulate(stop=1.0), tmp_path / "drive.html", note=told.append)
    assert ["has a drawing" in text for text in told] == [True]
