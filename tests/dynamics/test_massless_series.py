"""Joints in series with nothing on the frame between them share a rate: what acts along them is in balance there."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.command.cli import main

Write = Callable[[str], lag.Model]
TIMES = np.linspace(0, 2, 5)
SLIDES = """model M Prismatic p1(a = world{}), p2(a = p1.b{}); PointMass m(m = 1, center = p2.b); {}
  Spring k1(k = 100, stretch = p1.s), k2(k = 50, stretch = p2.s); {} end M;"""


def run(model: lag.Model) -> lag.Trajectory:
    return model.simulate(stop=2, interval=0.5, tolerance=1e-10)


def test_two_slides_with_a_spring_each(scene: Write) -> None:
    model = scene(SLIDES.format(", s(start = 0.1)", "", "", ""))
    found, omega = run(model), np.sqrt(100 / 3)
    np.testing.assert_allclose(found["m.center.x"], 0.3 * np.cos(omega * TIMES), atol=1e-10)
    np.testing.assert_allclose(found["p2.s"], 2 * found["p1.s"], atol=1e-14)
    assert model.freedom["degrees_of_freedom"] == 1
    assert "k_k1 s_p1 = 0" not in model.equations() and "= 0\n" not in model.equations(form="first-order")


def test_two_hinges_on_one_pin(scene: Write) -> None:
    """20 and 30 N.m/rad in series are 12 to the bar."""
    found = run(scene("""model M Revolute n(a = world), h(a = n.b, phi(start = 0.5)); Bar b(m = 1, L = 1, a = h.b);
      TorsionSpring k1(a = world, b = n.b, k = 20), k2(a = n.b, b = h.b, k = 30); output Angle s = n.phi + h.phi; end M;"""))
    right = solve_ivp(lambda t, y: [y[1], 3 * (-12 * y[0] - 9.81 / 2 * np.cos(y[0]))], (0, 2), [1.25, 0], method="DOP853",
                      rtol=1e-12, atol=1e-13, t_eval=TIMES).y[0]
    np.testing.assert_allclose(found["s"], right, atol=1e-8)
    np.testing.assert_allclose(20 * found["n.phi"], 30 * found["h.phi"], atol=1e-13)


def test_a_damper_beside_one_of_three(scene: Write) -> None:
    """s2 is held back by 3 N.s/m and 50 N/m; the other two are springs of 20 N/m in series."""
    found = run(scene("""model M
      Prismatic p1(a = world, along = {0, 1}), p2(a = p1.b, along = {0, 1}), p3(a = p2.b, along = {0, 1});
      PointMass m(m = 1, center = p3.b); Damper c(c = 3, rate = p2.v);
      Spring k1(k = 100, stretch = p1.s), k2(k = 50, stretch = p2.s), k3(k = 25, stretch = p3.s);
      initial equation m.center.y = 0.3; m.center.v[2] = 0; end M;"""))
    right = solve_ivp(lambda t, y: [(20 * (y[1] - y[0]) - 50 * y[0]) / 3, y[2], -20 * (y[1] - y[0]) - 9.81], (0, 2), [0, 0.3, 0],
                      method="DOP853", rtol=1e-12, atol=1e-13, t_eval=TIMES).y
    np.testing.assert_allclose(found["p2.s"], right[0], atol=1e-9)
    np.testing.assert_allclose(found["m.center.y"], right[1], atol=1e-9)


def test_by_a_ratio_that_is_a_parameter(scene: Write) -> None:
    """x and r phi share the mass: springs of 100 and 7/r^2 in series."""
    model = scene("""model M parameter Length r = 0.3; coordinate Length x; coordinate Angle phi(start = 0.4);
      energy kinetic 2[kg]*(der(x) + r*der(phi))^2/2; potential 100[N/m]*x^2/2 + 7[N.m]*phi^2/2; end M;""")
    for r in (0.3, 0.5):
        found = model.simulate(stop=2, interval=0.5, tolerance=1e-10, parameters={"r": r})
        np.testing.assert_allclose(found["phi"], 0.4 * np.cos(np.sqrt(1 / (1 / 100 + r**2 / 7) / 2) * TIMES), atol=1e-9)
        np.testing.assert_allclose(100 * found["x"] * r, 7 * found["phi"], atol=1e-12)


def test_inside_of_a_loop(scene: Write) -> None:
    """A bar on a slide of its own, pinned to the second of two slides in series."""
    found = run(scene("""model M World world(gravity = {0, 0});
      Prismatic p1(a = world), p2(a = p1.b), p3(a = world, s(start = 0.3));
      PointMass m(m = 1, center = p2.b); Bar bar(m = 1, L = 1, a = p3.b); Revolute pin(a = p2.b, b = bar.b);
      Spring k1(k = 100, stretch = p1.s), k2(k = 50, stretch = p2.s); end M;"""))
    np.testing.assert_allclose(found["m.center.x"], 1.3 * np.cos(np.sqrt(100 / 6) * TIMES), atol=1e-9)


def test_a_stop_that_both_run_into(scene: Write) -> None:
    """The stop presses along the sum, where the mass is: the balance of the springs holds in contact, too."""
    found = scene(SLIDES.format(", s(start = 0.1)", "", "Stop stop(gap = p1.s + p2.s + 0.2, e = 1);", "")).simulate(
        stop=2, interval=0.01, tolerance=1e-10)
    assert found["m.center.x"].min() > -0.2 - 1e-9
    energy = found.energy
    assert np.abs(energy.residual).max() < 1e-9 and found["m.center.x"].max() == pytest.approx(0.3, abs=1e-3)


@pytest.mark.parametrize(("text", "said"), [
    ("model M Revolute n(a = world), h(a = n.b, phi(start = 0.3)); Bar b(m = 1, L = 1, a = h.b); end M;",
     r"'n.phi' moves no mass where it takes others with it \(h.phi by -1 of it\), and no spring or damper"),
    (SLIDES.format("", "", "DryFriction rub(F = 1, rate = p1.v);", ""), "not linear in rates, as friction"),
    (SLIDES.format("", "", "Stop stop(gap = p1.s + 0.2);", ""), "a contact or an event acts on it"),
    ("""model M Prismatic p(a = world), q(a = h.b, s(start = 0.5)); Revolute h(a = p.b); PointMass m(m = 1, center = q.b);
       Spring k1(k = 100, stretch = p.s), k2(k = 50, stretch = q.s); TorsionSpring k3(a = p.b, b = h.b, k = 4); end M;""",
     "p.s, q.s, h.phi move no mass together, along a way that depends on where they are"),
])
def test_what_nothing_decides(scene: Write, text: str, said: str) -> None:
    with pytest.raises(lag.LagError, match=f"L0504.*{said}"):
        scene(text)


def test_an_fmu_of_it(scene: Write, tmp_path: Path) -> None:
    with pytest.raises(lag.LagError, match=r"L0704.*'p1.s' moves no mass while parameters are as declared"):
        scene(SLIDES.format("", "", "", "")).export_fmu(tmp_path)
    along = ", final along = {1, 0}"
    assert scene(SLIDES.format(along, along, "", "")).export_fmu(tmp_path)


def test_starts_that_are_moved_are_told(scene: Write, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    model = scene(SLIDES.format(", s(start = 0.1)", ", s(start = 0.3)", "", ""))
    assert main(["simulate", str(model.path), "--stop", "0.1", "-o", str(tmp_path / "out.csv")]) == 0
    told = capsys.readouterr().out
    assert "p1.s begins at 0.125 m, not at 0.1 m" in told and "p2.s begins at 0.25 m, not at 0.3 m" in told


def test_starts_that_were_given_are_not_told(scene: Write) -> None:
    """Of two places without mass in a row, with a damper at the second, whoever states one is told of the other alone."""
    row = ("model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic n1(a = world{}), n2(a = world{}); Spring "
           "k1(k = 100, stretch = m.s - n1.s), k2(k = 50, stretch = n1.s - n2.s); Damper c(c = 5, rate = n2.v); end M;")
    (told,) = scene(row.format("", "")).simulate(at=[0], initial={"n2.s": 0.02}).notes
    assert told == "n1.s begins at 0.07333 m, where the forces on it are in balance"
    (told,) = scene(row.format(", s(start = 0.05)", ", s(start = 0.02)")).simulate(at=[0]).notes
    assert told == "n2.s begins at -0.05 m, not at 0.02 m: the equations ask for it"


def test_starts_that_time_alone_gives_are_told(scene: Write) -> None:
    text = """model M Revolute h(a = world, phi(start = %s)), g(a = b.b); Bar b(m = 1, L = 1, a = h.b), c(m = 1, L = 1, a = g.b);
      Motion drive(of = h.phi, to = 1 + 0.2[1/s]*time); end M;"""
    (warning,) = scene(text % "0.5").warnings
    assert "L0608" in warning and "'h.phi' is given by time alone, and begins at 1" in warning
    assert not scene(text % "1").warnings
