"""The libraries Rotational and Translational beside closed forms, and beside SciPy where there are none."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.command.library_topic import DRIVES

Scene = Callable[[str], lag.Model]
R, T = "import Rotational.*;", "import Translational.*;"


def run(scene: Scene, text: str, at: list[float], imports: str = R, tolerance: float = 1e-11) -> lag.Trajectory:
    return scene(f"model M {imports} {text} end M;").simulate(at=at, tolerance=tolerance)


def test_a_clutch_that_closes_slowly(scene: Scene) -> None:
    """fn = 5 t: the torque 2.5 t brings both to the rate 10/3 at t = sqrt(16/3), where they stick."""
    found = run(scene, """Inertia a(J = 1, w(start = 10)), b(J = 2);
      Clutch c(fn_max = 5, f_normalized = time/1[s], flange_a = a.flange_b, flange_b = b.flange_a);""", [1.0, 5.0])
    meet = np.sqrt(16 / 3)
    assert found["a.phi"] == pytest.approx([10 - 1.25 / 3, 10 * meet - 1.25 * meet**3 / 3 + 10 / 3 * (5 - meet)], abs=1e-10)
    assert found["b.w"][1] == found["a.w"][1] == pytest.approx(10 / 3, abs=1e-12)


def test_bearings_stop_a_wheel(scene: Scene) -> None:
    """w' = -(1 + w/10) from 5: rest at 10 log(1.5), and for ever."""
    found = run(scene, """Inertia a(J = 1, w(start = 5)); BearingFriction f(tau_pos = [0, 1; 10, 2], flange_a = a.flange_b);""",
                [2.0, 30.0])
    assert found["a.w"] == pytest.approx([15 * np.exp(-0.2) - 10, 0], abs=1e-11)
    assert found["a.phi"][1] == pytest.approx(50 - 100 * np.log(1.5), abs=1e-9)


def test_bearings_hold_up_to_their_peak(scene: Scene) -> None:
    """A torque that grows as t is held until 1.5, and moves against 1 from there on."""
    found = run(scene, """Inertia a(J = 1); BearingFriction f(peak = 1.5, flange_a = a.flange_a);
      Torque m(tau = 1[N.m/s]*time, flange = a.flange_b);""", [1.4, 3.5])
    assert found["a.phi"] == pytest.approx([0, 2**3 / 6 + 0.5 * 2**2 / 2], abs=1e-9)


def test_a_brake_with_slip_and_a_support_that_gives_way(scene: Scene) -> None:
    """The housing turns on a spring: held together they swing as one."""
    found = run(scene, """Inertia a(J = 1, w(start = 1)), housing(J = 2); Spring s(c = 12, flange_a = housing.flange_a);
      Fixed f(flange = s.flange_b);
      Brake b(useSupport = true, support = housing.flange_b, flange_a = a.flange_b, fn_max = 1e3, f_normalized = 1);""", [3.0])
    slip = 1 / (500 * (1 + 1 / 2))  # until both turn alike, the spring has hardly moved
    assert found["a.w"] == pytest.approx(np.cos(2 * 3.0) / 3, abs=3 * slip)
    assert found["housing.w"] == pytest.approx(found["a.w"], abs=1e-12)


def test_a_one_way_clutch_rubs_and_carries(scene: Scene) -> None:
    """b never falls behind a; it takes 0.5 from b where b runs ahead, and can pull b back by as much where both turn alike."""
    found = run(scene, """Inertia a(J = 1), b(J = 2); Torque m(tau = 3[N.m]*sin(2[rad/s]*time), flange = a.flange_a);
      OneWayClutch c(fn_max = 1, f_normalized = 1, flange_a = a.flange_b, flange_b = b.flange_a);""", [1.5, 2.5])
    leave = (np.pi + np.arcsin(0.25)) / 2
    w, ahead = (1 - np.cos(2 * leave)) / 2, 2.5 - leave
    assert found["b.w"] == pytest.approx([(1 - np.cos(3)) / 2, w - 0.25 * ahead], abs=1e-9)
    assert found["a.w"][1] == pytest.approx(w + 0.5 * ahead + 1.5 * (np.cos(2 * leave) - np.cos(5)), abs=1e-9)


def test_gears_share_inertias(scene: Scene) -> None:
    """sun, carrier and ring with a constant torque; a gear on a housing that turns."""
    found = run(scene, """Inertia s(J = 1), c(J = 2), r(J = 3); ConstantTorque m(tau_constant = 3, flange = s.flange_a);
      IdealPlanetary p(ratio = 3, sun = s.flange_b, carrier = c.flange_a, ring = r.flange_a);""", [2.0])
    share = np.array([1, 3]) / 4
    a = np.linalg.solve(np.diag([1.0, 3]) + 2 * np.outer(share, share), [3.0, 0])
    assert [found["s.phi"][0], found["r.phi"][0]] == pytest.approx(2 * a, abs=1e-12)
    found = run(scene, """Inertia a(J = 1), b(J = 2), housing(J = 5); ConstantTorque m(tau_constant = 3, flange = a.flange_a);
      IdealGear g(ratio = -4, useSupport = true, flange_a = a.flange_b, flange_b = b.flange_a, support = housing.flange_a);""",
                [2.0])
    turned = np.array([[-4.0, 5], [1, 0], [0, 1]])  # a, b, housing by those of b and the housing
    a = np.linalg.solve(turned.T @ np.diag([1.0, 2, 5]) @ turned, turned.T @ [3.0, 0, 0])
    assert [found["b.phi"][0], found["housing.phi"][0]] == pytest.approx(2 * a, abs=1e-12)


def test_backlash(scene: Scene) -> None:
    """The damper takes no more than the spring: beside SciPy, with a step that ends at each change."""
    found = run(scene, """Inertia a(J = 1, w(start = 2)); Fixed f;
      ElastoBacklash e(c = 50, d = 3, b = 0.2, flange_a = f.flange, flange_b = a.flange_a);""", [1.0, 2.0, 3.0])

    def slope(t: float, y: np.ndarray) -> list[float]:
        twist = max(y[0] - 0.1, 0) + min(y[0] + 0.1, 0)
        return [y[1], -50 * twist - max(-50 * abs(twist), min(50 * abs(twist), 3 * y[1]))]

    right = solve_ivp(slope, (0, 3), [0, 2], rtol=1e-12, atol=1e-13, max_step=1e-3, t_eval=[1, 2, 3]).y
    assert found["a.phi"] == pytest.approx(right[0], abs=1e-8)
    assert found["a.w"] == pytest.approx(right[1], abs=1e-7)


def test_sensors(scene: Scene) -> None:
    found = scene(f"""model M {R} Inertia a(J = 1), b(J = 3); Torque m(tau = 2[N.m]*time/1[s], flange = a.flange_a);
      PowerSensor p(flange_a = a.flange_b, flange_b = b.flange_a); AccSensor s(flange = b.flange_b);
      SpeedSensor v(flange = a.flange_a); RelAngleSensor r(flange_a = a.flange_a, flange_b = b.flange_b);
      output Real tau = p.tau, power = p.power, acc = s.a, rate = v.w, rel = r.phi_rel; end M;""").simulate(at=[2.0])
    assert [found[x][0] for x in ("tau", "power", "acc", "rate", "rel")] == pytest.approx([3, 3, 1, 1, 0], abs=1e-12)


def test_prescribed_shafts(scene: Scene) -> None:
    """A wheel on a spring whose other end is turned: by an angle, and at a rate."""
    for source in ("Position d(phi_ref = 1 - cos(2[rad/s]*time))", "Speed d(w_ref = 2[rad/s]*sin(2[rad/s]*time))"):
        found = run(scene, f"{source}; Inertia a(J = 1); Spring s(c = 9, flange_a = d.flange, flange_b = a.flange_a);",
                    [1.3])
        t = 1.3  # phi'' + 9 phi = 9 - 9 cos 2t
        assert found["a.phi"] == pytest.approx(1 - 9 / 5 * np.cos(2 * t) + 4 / 5 * np.cos(3 * t), abs=1e-10)


def test_accelerated_shafts(scene: Scene) -> None:
    """Integrals of the acceleration, the torque that it takes, and no energy of its own; light and heavy shafts."""
    for J in (1e-9, 1.0, 1e5):
        found = run(scene, f"""Accelerate d(a_ref = 2[rad/s2]*sin(3[rad/s]*time), phi(start = 1), w(start = -1));
          Inertia a(J = {J}, flange_a = d.flange), b(J = {J}); Spring s(c = {J}, flange_a = a.flange_b, flange_b = b.flange_a);
          output Real tau = d.tau;""", [1.3])
        assert found["d.phi"][0] == pytest.approx(1 - 1.3 / 3 - 2 / 9 * np.sin(3.9), abs=1e-10)
        assert found["d.w"][0] == pytest.approx(-1 / 3 - 2 / 3 * np.cos(3.9), abs=1e-10)
        assert found["tau"][0] == pytest.approx(J * (2 * np.sin(3.9) + found["d.phi"][0] - found["b.phi"][0]), rel=1e-6)
        kinetic = J * (found["d.w"][0] ** 2 + found["b.w"][0] ** 2) / 2
        assert found.energy.kinetic[0] == pytest.approx(kinetic, rel=1e-12)
        assert np.abs(found.energy.residual).max() < 1e-9 * J


def test_what_is_accelerated_against_a_housing(scene: Scene) -> None:
    """By a signal; the housing is free, and takes what acts: momentum stays."""
    found = run(scene, """Accelerate d(useSupport = true); Mass a(m = 1, flange_a = d.flange), b(m = 3, flange_a = d.support);
      Blocks.Ramp r(height = 6, duration = 2); equation connect(r.y, d.a_ref);""", [2.0], T)
    assert [found["a.s"][0], found["b.s"][0], found["a.v"][0]] == pytest.approx([3, -1, 4.5], abs=1e-11)
    with pytest.raises(lag.LagError, match="moves no mass"):
        run(scene, "Accelerate d(a_ref = 1); Spring s(c = 1, flange_a = d.flange); Mass a(m = 1, flange_a = s.flange_b);", [1], T)


HEAT = """import R = Rotational; import T = Translational;
  R.Inertia i(J = 1, w(start = 10)), k(J = 2, w(start = -1)), m(J = 1, w(start = 4)), n(J = 3);
  R.Damper d(d = 0.3, flange_a = i.flange_a, flange_b = world_r.flange);
  R.BearingFriction b(tau_pos = [0, 1; 10, 2], flange_a = i.flange_b);
  R.Clutch c(fn_max = 10, f_normalized = 0.4, cgeo = 0.1, flange_a = i.flange_b, flange_b = k.flange_a);
  R.ElastoBacklash e(c = 100, d = 3, b = 0.1, flange_a = k.flange_b, flange_b = world_r.flange);
  R.SpringDamper sd(c = 20, d = 0.2, flange_a = k.flange_b, flange_b = world_r.flange);
  R.Brake r(fn_max = 2, f_normalized = 1, flange_a = m.flange_b);
  R.LossyGear g(ratio = 2, lossTable = [0, 0.9, 0.8, 0.1, 0.2], flange_a = m.flange_b, flange_b = n.flange_a);
  R.Fixed world_r;
  T.Mass x(m = 1, v(start = 3)), y(m = 2, s(start = 0.2));
  T.Damper td(d = 0.4, flange_a = x.flange_b, flange_b = y.flange_a);
  T.SpringDamper ts(c = 5, d = 0.2, flange_a = x.flange_b, flange_b = y.flange_a);
  T.ElastoGap gap(c = 100, d = 1, flange_a = world_t.flange, flange_b = y.flange_a);
  T.SupportFriction sf(f_pos = [0, 0.3], flange_a = x.flange_a);
  T.Brake tb(fn_max = 1, f_normalized = 0.5, flange_a = y.flange_b);
  T.Fixed world_t;
  output Energy heat(start = 0, fixed = true);
equation
  der(heat) = d.lossPower + b.lossPower + c.lossPower + e.lossPower + sd.lossPower + r.lossPower + g.lossPower
    + td.lossPower + ts.lossPower + gap.lossPower + sf.lossPower + tb.lossPower;"""
STOPS = """import Translational.*; output Energy heat(start = 0, fixed = true); MassWithStopAndFriction p(m = 1, v(start = 9));
equation der(heat) = p.lossPower;"""


@pytest.mark.parametrize("text", [HEAT, STOPS])
def test_what_becomes_heat(scene: Scene, text: str) -> None:
    """The account counts as much."""
    found = run(scene, text, [2.0], "", 1e-10)
    assert found["heat"][0] > 10
    assert found["heat"][0] == pytest.approx(found.energy.dissipated[0] - found.energy.work[0], rel=1e-10)


def test_brakes_by_eddy_currents(scene: Scene) -> None:
    """J w' = -2 tau x/(1 + x^2): log x + x^2/2 falls as 2 tau t/(J w_nominal), hot discs have a higher w_nominal."""
    for text, imports in (("EddyCurrentTorque e(tau_nominal = 50, w_nominal = 10, alpha20 = 0.004, T = 343.15); "
                           "Inertia a(J = 2, w(start = 20), flange_a = e.flange);", R),
                          ("EddyCurrentForce e(f_nominal = 50, v_nominal = 10, alpha20 = 0.004, T = 343.15); "
                           "Mass a(m = 2, v(start = 20), flange_a = e.flange);", T)):
        found = run(scene, f"{text} output Real loss = e.lossPower;", [0.7], imports)
        x = found[f"a.{'w' if imports is R else 'v'}"][0] / 12
        before = 20 / 12
        assert np.log(before / x) + (before**2 - x**2) / 2 == pytest.approx(2 * 50 * 0.7 / (2 * 12), abs=1e-10)
        assert found.energy.dissipated[0] == pytest.approx(144 * (before**2 - x**2), abs=1e-8)
        assert found["loss"][0] == pytest.approx(100 * x**2 / (1 + x**2) * 12, rel=1e-9)
    found = run(scene, """EddyCurrentTorque e(tau_nominal = 50, w_nominal = 10, useExcitationInput = true);
      Blocks.Step r(startTime = 1); Inertia a(J = 1, w(start = 20), flange_a = e.flange);
      equation connect(r.y, e.excitation);""", [1.0, 1.1])
    assert found["a.w"][0] == 20 and found["a.w"][1] < 17


def test_loads_that_turn_round_or_stay(scene: Scene) -> None:
    """The torque of a fan turns round where TorqueDirection is false, as in the Modelica Standard Library."""
    for name, speed in (("Linear", 0.5), ("Quadratic", 0.25)):
        for stays in ("true", "false"):
            found = run(scene, f"""ConstantSpeed d(w_fixed = -0.5); TorqueSensor s(flange_a = d.flange);
              {name}SpeedDependentTorque l(tau_nominal = -1, w_nominal = 1, TorqueDirection = {stays}, flange = s.flange_b);
              Inertia a(J = 1, flange_a = s.flange_b); output Real tau = s.tau;""", [1.0])
            assert found["tau"][0] == pytest.approx(speed if stays == "true" else -speed, abs=1e-12)
            found = run(scene, f"""ConstantSpeed d(v_fixed = -0.5); ForceSensor s(flange_a = d.flange);
              {name}SpeedDependentForce l(f_nominal = -1, v_nominal = 1, ForceDirection = {stays}, flange = s.flange_b);
              Mass a(m = 1, flange_a = s.flange_b); output Real f = s.f;""", [1.0], T)
            assert found["f"][0] == pytest.approx(speed if stays == "true" else -speed, abs=1e-12)


def test_a_vehicle_rolls_out(scene: Scene) -> None:
    """M v' = -c - k v^2, until it stands; on a hill that is too flat it stays, and on a steep one it rolls back."""
    found = run(scene, "Vehicle a(m = 100, J = 2, R = 0.25, v(start = 10)); output Real axle = a.flangeR.phi;", [1.0, 200.0], T)
    c, k, M = 0.015 * 100 * 9.80665, 0.3, 132
    v = np.sqrt(c / k) * np.tan(np.arctan(10 * np.sqrt(k / c)) - np.sqrt(c * k) / M)
    assert found["a.v"] == pytest.approx([v, 0], abs=1e-9)
    assert found["a.s"][1] == pytest.approx(M / (2 * k) * np.log(1 + k * 100 / c), abs=1e-8)
    assert found["axle"][1] == pytest.approx(found["a.s"][1] / 0.25, rel=1e-12)
    found = run(scene, """Vehicle a(m = 100, J = 0, R = 1, A = 0, useInclinationInput = true, useCrInput = true);
      Vehicle b(m = 20, J = 0, R = 1, A = 0);
      Blocks.Step r(height = 0.1, startTime = 1); Blocks.Constant cr(k = 0.03);
      equation connect(a.inclination, r.y); connect(cr.y, a.cr); connect(a.flangeT, b.flangeT);""", [1.0, 2.0], T)
    pull = 9.80665 * (100 * (0.1 - 0.03) / np.hypot(1, 0.1) - 20 * 0.015) / 120
    assert found["b.s"] == pytest.approx([0, -pull / 2], abs=1e-10)
    headwind = run(scene, "Vehicle a(m = 1, J = 0, R = 1, vWindConstant = -2, CrConstant = 0);", [1.0], T)["a.v"][0]
    assert headwind == pytest.approx(1 / (0.5 + 0.3) - 2, abs=1e-10)  # 1/(v + 2) grows by 0.3 t


def test_a_hinge_has_a_shaft(scene: Scene) -> None:
    """A pendulum that turns a rotor by a gear: small swings."""
    found = run(scene, """Revolute hinge(a = world, phi(start = -pi/2 + 1e-4)); Bar bar(m = 3, L = 2, a = hinge.b);
      HingeFlange h(of = hinge.phi); IdealGear g(ratio = 10, flange_b = h.flange);
      Inertia rotor(J = 0.02, flange_b = g.flange_a);""", [1.0])
    w = np.sqrt(3 * 9.81 * 1 / (3 * 4 / 3 + 100 * 0.02))
    assert (found["hinge.phi"][0] + np.pi / 2) * 1e4 == pytest.approx(np.cos(w), abs=1e-7)


def test_stops_without_rebound(scene: Scene) -> None:
    """Pushed with 15 net newtons onto a stop and held there; pulled off when the pull exceeds what it takes at rest."""
    found = run(scene, """MassWithStopAndFriction m(m = 1, smax = 1, smin = -2, F_prop = 0, F_Stribeck = 0);
      Force f(f = if time < 1 then 20[N] else -1[N/s]*(time - 1[s]), flange = m.flange_a);""", [0.3, 0.9, 5.9, 8.0], T)
    slid = (8.0 - 6.0) ** 3 / 6
    assert found["m.s"] == pytest.approx([0.5 * 15 * 0.09, 1, 1, 1 - slid], abs=1e-9)


def test_stribeck(scene: Scene) -> None:
    """Mass under a constant push over friction 3 v + 5 + 10 exp(-2 v): beside SciPy; and held below 15 N."""
    found = run(scene, """MassWithStopAndFriction m(m = 2, F_prop = 3); Force f(f = 18, flange = m.flange_a);
      MassWithStopAndFriction o(m = 1); Force g(f = 14.9, flange = o.flange_a);""", [1.0, 2.0], T)
    right = solve_ivp(lambda t, v: (18 - 3 * v - 5 - 10 * np.exp(-2 * v)) / 2, (0, 2), [0.0], rtol=1e-12, atol=1e-13,
                      t_eval=[1, 2]).y[0]
    assert found["m.v"] == pytest.approx(right, abs=1e-9)
    assert found["o.s"] == pytest.approx([0, 0], abs=1e-12)


def test_a_gap_only_presses(scene: Scene) -> None:
    found = run(scene, """Mass m(m = 1, s(start = 0.5), v(start = -1)); Fixed wall;
      ElastoGap g(c = 100, d = 5, s_rel0 = 0.2, flange_a = wall.flange, flange_b = m.flange_a);""", [0.5, 1.0], T)

    def slope(t: float, y: np.ndarray) -> list[float]:
        pressed = max(0.2 - y[0], 0)
        return [y[1], 100 * pressed - max(-100 * pressed, min(100 * pressed, 5 * y[1]))]

    right = solve_ivp(slope, (0, 1), [0.5, -1], rtol=1e-12, atol=1e-13, max_step=1e-3, t_eval=[0.5, 1]).y
    assert found["m.s"] == pytest.approx(right[0], abs=1e-8)


def test_wheel_and_rack(scene: Scene) -> None:
    found = run(scene, """Rotational.Inertia a(J = 1); Mass m(m = 10, L = 0.5); Rotational.IdealRollingWheel w(radius = 0.3);
      Rotational.ConstantTorque t(tau_constant = 2, flange = a.flange_a); Rod r(L = 2); Mass n(m = 5); ForceSensor s;
      equation connect(a.flange_b, w.flangeR); connect(w.flangeT, m.flange_a); connect(m.flange_b, r.flange_a);
      connect(r.flange_b, s.flange_a); connect(s.flange_b, n.flange_a);""", [1.0], T)
    a = 2 / (1 + 0.09 * 15)
    assert found["a.phi"] == pytest.approx(a / 2, abs=1e-12)
    assert found["n.s"] - found["m.s"] == pytest.approx(2.25, abs=1e-12)


def test_the_scene_of_the_help_text(scene: Scene) -> None:
    """The clutch is closed while the motor runs at 500 rad/s: both sides meet, and stay together; its work is told."""
    text = DRIVES[: DRIVES.index("end DriveTrain;")] + "  annotation(experiment(StopTime = 12));\nend DriveTrain;"
    found = scene(text).simulate(tolerance=1e-10)
    slip = found["load.w"] * 5 - found["rotor.w"]
    assert slip[20] < -1 and abs(slip[-1]) < 1e-9
    momentum = 0.02 * 25 + 1.5  # as of one wheel, by angles of the load
    w = found["load.w"]
    late = found.time > 11
    assert np.diff(w[late]) / np.diff(found.time[late]) == pytest.approx(4 * 5 / momentum, rel=1e-6)
    assert np.abs(found.energy.residual).max() < 1e-6
