"""Friction of what presses with the force of a contact: at rest, sliding, and in impacts."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.fmus import KINDS, VERSIONS, simulated
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "taylor", "erk", "erk5", "adams", "implicit")
G = 9.81

THROWN = """model Thrown "a block is thrown along a rough floor"
  parameter Real mu = 0.3;
  Prismatic x(a = world, along = {1, 0}, v(start = 2)), y(a = x.b, along = {0, 1});
  PointMass block(m = 2, center = y.b);
  RoughStop floor(a = world, b = y.b, mu = mu, e = 0.5);
  output Force N = floor.force;
end Thrown;"""

SPINNING = """model Spinning "a disc with back spin bounces on a rough floor, until it rolls"
  parameter Real mu = 0.3, e = 0.7; parameter Length r = 0.1;
  Prismatic x(a = world, along = {1, 0}, v(start = 1)), y(a = x.b, along = {0, 1}, s(start = 1));
  Revolute turn(a = y.b, w(start = 40));
  Disc ball(m = 1, r = r, center = turn.b);
  Stop floor(e = e, gap = ball.center.y - r);
  Friction rub(mu = mu, normal = floor.force, rate = der(x.s) + r*der(turn.phi));
end Spinning;"""

SLOPE = """model Slope "a block on a slope"
  parameter Real mu = 0.4; parameter Angle slope = 0.35;
  Planar p(a = world);
  Body block(m = 2, I = 0.1, center = p.b);
  RoughStop plane(a = world, b = p.b, along = {-sin(slope), cos(slope)}, mu = mu);
end Slope;"""

STACK = """model Stack "the lower one of two blocks is pulled: the upper one goes along, or is left behind"
  parameter Real mu = 0.2, floor_mu = 0.1; parameter Force F = 10;
  Prismatic x1(a = world, along = {1, 0}), y1(a = x1.b, along = {0, 1});
  Prismatic x2(a = world, along = {1, 0}), y2(a = x2.b, along = {0, 1});
  PointMass low(m = 2, center = y1.b), up(m = 1, center = y2.b);
  RoughStop floor(a = world, b = y1.b, mu = floor_mu), between(a = y1.b, b = y2.b, mu = mu);
  AppliedForce P(at = low.center, force = {F, 0});
end Stack;"""

BOX = """model Box "a box falls on its corners, tumbles and slides until it rests"
  parameter Real mu = 0.4, e = 0.3;
  Planar p(a = world, y(start = 1), phi(start = 0.3));
  Body box(m = 2, I = 0.1, center = p.b);
  RoughStop corner[4](each a = world, each mu = mu, each e = e);
equation
  connect(corner[1].b, shift(p.b, {-0.2, -0.1})); connect(corner[2].b, shift(p.b, {0.2, -0.1}));
  connect(corner[3].b, shift(p.b, {0.2, 0.1})); connect(corner[4].b, shift(p.b, {-0.2, 0.1}));
initial equation
  der(p.x) = 1;
end Box;"""


BENCH = """model Bench "a bench falls on its feet, with a stiff rod on it, and is pushed to and fro: it slides where that is most"
  parameter Force F = 16.823; parameter AngularFrequency w = 6.483; parameter Real mu1 = 0.065, mu2 = 0.803, e = 0.3;
  parameter TorsionStiffness k = 1.893e5; parameter TorsionDamping c = 10.81;
  Planar p(a = world, y(start = 0.36), phi(start = -0.075));
  Body b(m = 2.257, I = 0.123, center = p.b);
  RoughStop f1(a = world, b = shift(p.b, {-0.3, -0.1}), mu = mu1, e = e);
  RoughStop f2(a = world, b = shift(p.b, {0.3, -0.1}), mu = mu2, e = e);
  Revolute h(a = shift(p.b, {0, 0.1}), phi(start = 0.005));
  Bar rod(m = 0.647, L = 0.5, a = h.b);
  TorsionSpringDamper spring(a = p.b, b = h.b, k = k, c = c);
  AppliedForce P(at = p.b, force = {F*sin(w*time), 0});
end Bench;"""


def spinning_on_paper(end: float, mu: float = 0.3, e: float = 0.7, r: float = 0.1) -> tuple[float, float]:
    """x and phi: in each impact friction takes mu P, or what leaves no slip (1 + m r^2/I = 3 for a disc); so on the floor."""
    x, u, phi, w, y, v, t = 0.0, 1.0, 0.0, 40.0, 1 - r, 0.0, 0.0
    while (flight := (v + np.sqrt(v * v + 2 * G * y)) / G) > 1e-14:
        last = min(flight, end - t)
        t, x, phi, v, y = t + last, x + u * last, phi + w * last, v - G * last, 0.0
        if last < flight:
            return x, phi
        slip, v = u + r * w, -e * v
        taken = -np.copysign(min(mu * (1 + e) / e * v, abs(slip) / 3), slip)
        u, w = u + taken, w + 2 * taken / r
    slip = u + r * w
    slides, a = min(abs(slip) / (3 * mu * G), end - t), -np.copysign(mu * G, slip)
    x, phi = x + u * slides + a * slides**2 / 2, phi + w * slides + a / r * slides**2
    u, w, left = u + a * slides, w + 2 * a / r * slides, end - t - slides
    return x + u * left, phi + w * left


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-11])
def test_it_slides_to_rest(solver: str, tolerance: float, scene: Write) -> None:
    """v^2/(2 mu g), and the account has all that friction took."""
    run = scene(THROWN).simulate(at=[0.2, 0.5, 3.0], tolerance=tolerance, solver=solver)
    stops = 2 / (0.3 * G)
    np.testing.assert_allclose(run["x.s"], [2 * t - 0.15 * G * t**2 for t in (0.2, 0.5, stops)], rtol=1e-13)
    np.testing.assert_allclose(run["N"], 2 * G, rtol=1e-13)
    assert abs(run["der(x.s)"][-1]) < 1e-14
    assert run.statistics.energy_residual < 1e-13
    assert run.statistics.steps < 40


def test_contacts_of_ones_own(scene: Write) -> None:
    """Without the library: a position of a frame, said in two ways."""
    model = scene("""model Own
      Prismatic x(a = world, along = {1, 0}, v(start = 2)), y(a = x.b, along = {0, 1});
      PointMass block(m = 2, center = y.b);
    equation
      when 0 > block.center.y then reinit(block.center.v[2], 0); end when;
    energy
      work -0.3*contact_force(block.center.y)*sign(block.center.v[1]) on block.center.x;
    end Own;""")
    np.testing.assert_allclose(model.simulate(at=[3.0])["x.s"], 2 / (0.3 * G), rtol=1e-12)


@pytest.mark.parametrize("solver", SOLVERS)
def test_impacts_rub(solver: str, scene: Write) -> None:
    """In all 40 bounces, and on the floor after them."""
    run = scene(SPINNING).simulate(at=[0.5, 1.0, 2.0, 3.0], tolerance=1e-8, solver=solver)
    wanted = np.array([spinning_on_paper(t) for t in (0.5, 1.0, 2.0, 3.0)])
    np.testing.assert_allclose(np.column_stack([run["x.s"], run["turn.phi"]]), wanted, rtol=1e-11)
    assert run.statistics.energy_residual < 1e-12


@pytest.mark.parametrize("mu", [0.02, 0.3, 2.0])
def test_impacts_slip_or_stick(mu: float, scene: Write) -> None:
    """With little friction a disc slips for long, with much it is without slip after the first impact."""
    run = scene(SPINNING).simulate(at=[3.0], tolerance=1e-9, parameters={"mu": mu})
    np.testing.assert_allclose([run["x.s"][0], run["turn.phi"][0]], spinning_on_paper(3.0, mu), rtol=1e-11)


@pytest.mark.parametrize("mu", [0.2, 0.36, 0.37, 1.0])
def test_a_block_on_a_slope(mu: float, scene: Write) -> None:
    """tan(0.35) = 0.365: it sticks above."""
    run = scene(SLOPE).simulate(at=[2.0], tolerance=1e-9, parameters={"mu": mu})
    a = max(np.sin(0.35) - mu * np.cos(0.35), 0) * G
    down = -(run["p.x"][0] * np.cos(0.35) + run["p.y"][0] * np.sin(0.35))
    np.testing.assert_allclose(down, 2 * a, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize(("F", "a"), [
    (2.9, (0, 0)), (6.0, ((6 - 0.3 * G) / 3, (6 - 0.3 * G) / 3)), (12.0, ((12 - 0.5 * G) / 2, 0.2 * G))])
def test_blocks_on_each_other(F: float, a: tuple[float, float], solver: str, scene: Write) -> None:
    """mu (m1 + m2) g holds both, mu m2 g the upper one."""
    run = scene(STACK).simulate(at=[1.5], tolerance=1e-8, parameters={"F": F}, solver=solver)
    np.testing.assert_allclose([run["x1.s"][0], run["x2.s"][0]], np.array(a) * 1.5**2 / 2, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize("mu", [0.1, 0.4, 1.2])
def test_solvers_agree_on_a_box(mu: float, scene: Write) -> None:
    """Dozens of impacts at up to two corners, what slides and sticks between them, and rest: it lies flat."""
    model = scene(BOX)
    ends = []
    for solver in ("erk", "auto", "implicit"):
        for tolerance in (1e-6, 1e-9):
            run = model.simulate(stop=3, interval=0.5, tolerance=tolerance, solver=solver, parameters={"mu": mu})
            assert run.statistics.energy_residual < 1e-5 * run.statistics.energy_scale
            ends.append([run["p.x"][-1], run["p.y"][-1], run["p.phi"][-1]])
    np.testing.assert_allclose(ends, np.tile(ends[0], (len(ends), 1)), rtol=2e-6, atol=2e-7)
    assert abs(np.sin(2 * ends[0][2])) < 1e-6


@pytest.mark.parametrize("tolerance", [1e-5, 1e-6, 1e-8])
def test_no_slip_is_passed(tolerance: float, scene: Write) -> None:
    """Where a bench stands, an implicit step may pass all of a push: its conditions are looked at, however often that was in vain
    while it bounced."""
    model = scene(BENCH)
    ends = [model.simulate(stop=3, interval=0.5, tolerance=tolerance, solver=solver)["p.x"]
            for solver in ("auto", "erk", "implicit")]
    np.testing.assert_allclose(ends, np.tile(ends[2], (3, 1)), rtol=1e-5, atol=max(1e-7, tolerance / 10))
    np.testing.assert_allclose(ends[0][-1], -0.0555185876, rtol=1e-5)


def test_rows_change_nothing(scene: Write) -> None:
    """Of two that happen in one step the first is found, though it is over at its end: which one was hung on rounding, and so on
    the rows that were asked for."""
    numbers = {"k": 1995.0, "c": 1.779, "mu1": 0.59, "mu2": 0.791, "e": 0.0, "F": 11.065, "w": 5.645, "b.m": 2.762, "b.I": 0.115,
               "rod.m": 0.466}
    initial = {"h.phi": -0.284, "p.y": 0.381, "p.phi": 0.107}
    model = scene(BENCH)
    ends = [model.simulate(at=np.linspace(0, 3, rows)[1:], tolerance=1e-8, parameters=numbers, initial=initial)["p.x"][-1]
            for rows in (2, 4, 7, 13, 61, 601)]
    np.testing.assert_allclose(ends, 0.0455579003, rtol=1e-8)


@pytest.mark.parametrize("c", [0.3, 1.0, 10.0])
def test_feet_that_lift_off_while_they_stick(c: float, scene: Write) -> None:
    """The force that presses goes through nothing as the rod swings: the share of friction is infinite there, and the last that
    was known no impulse to stop with. Energies grew ten thousandfold."""
    numbers = {"k": 1.051e5, "c": c, "mu1": 0.137, "mu2": 0.552, "e": 0.0, "F": 6.38, "h.phi": -0.282}
    initial = {"h.phi": numbers.pop("h.phi"), "p.y": 0.162, "p.phi": 0.097}
    model = scene(BENCH)
    runs = [model.simulate(stop=2, interval=0.5, tolerance=tolerance, solver=solver, parameters=numbers, initial=initial)
            for solver, tolerance in (("erk", 1e-7), ("auto", 1e-8), ("auto", 1e-5), ("implicit", 1e-8))]
    for run in runs:
        assert run.statistics.energy_stored < 1.001 * runs[-1].statistics.energy_stored
        np.testing.assert_allclose(run["p.x"], runs[-1]["p.x"], rtol=0, atol=5e-3)


def test_equal_and_opposite_errors_are_not_taken_for_none(scene: Write) -> None:
    """What an impact has stopped is v + w l = 0: errors of v and w in opposite directions make none of it, and a corner was
    stopped again and again."""
    model = scene("""model Tumbling "a box tumbles on smooth ground, another body falls"
      Planar p(a = world, y(start = 0.605), phi(start = -0.101)), q(a = world);
      Body b(m = 2.74, I = 0.104, center = p.b), other(m = 1, I = 1, center = q.b);
      RoughStop s1(a = world, b = shift(p.b, {-0.156, -0.263}), mu = 0);
      RoughStop s2(a = world, b = shift(p.b, {0.156, -0.263}), mu = 0, e = 0.201);
    initial equation
      der(p.x) = 0.234; der(p.phi) = 2.846;
    end Tumbling;""")
    for tolerance in 10.0 ** -np.arange(5, 10, 0.25):
        for solver in ("erk", "implicit"):
            run = model.simulate(stop=2, interval=1, tolerance=tolerance, solver=solver)
            np.testing.assert_allclose([run["p.x"][-1], run["p.y"][-1]], [0.234 * 2, -0.263], rtol=1e-9)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("version", VERSIONS)
def test_fmus_rub(tmp_path: Path, version: str, kind: str) -> None:
    path = tmp_path / "spinning.lag"
    path.write_text(SPINNING, encoding="utf-8")
    found = simulated(path, version, kind, ["x.s", "turn.phi"], stop_time=2.0, output_interval=0.02, relative_tolerance=1e-9)[-1]
    precise = 1e-6 if kind == "ModelExchange" else 1e-11
    np.testing.assert_allclose([found["x.s"], found["turn.phi"]], spinning_on_paper(2.0), rtol=precise)


def test_equations_for_people_are_refused(scene: Write) -> None:
    with pytest.raises(lag.LagError, match="L0914"):
        scene(THROWN).equations()


def test_forces_are_not_told_afterwards(scene: Write) -> None:
    """From positions and rates alone nobody knows what friction or a contact holds: there was silence, and no force."""
    model = scene(THROWN)
    run = model.simulate(at=[0.5])
    for name in ("floor.force", "floor.reaction[2]", "der(floor.slip)"):
        with pytest.raises(lag.LagError, match="L0908"):
            run[name]
    asked = lag.Model(model.path, outputs=["floor.reaction", "der(floor.slip)"]).simulate(at=[0.5])
    np.testing.assert_allclose(asked["floor.reaction[2]"], 2 * G, rtol=1e-12)
    np.testing.assert_allclose(asked["der(floor.slip)"], -0.3 * G, rtol=1e-12)
