"""Small motion about states that move while loops or rolling hold them."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
Write = Callable[[str], lag.Model]

COIN = """
model Coin "An upright disc"
  parameter Length r = 0.25;
  World world(gravity = {0, 0, -9.81});
  PlanarJoint path(a = world, x(start = 0), phi(start = 0));
  Prismatic height(a = path.b, along = {0, 0, 1});
  Revolute lean(a = height.b, axis = {1, 0, 0}, phi(start = 0), w(start = 0));
  Revolute spin(a = lean.b, axis = {0, 1, 0}, w(start = 8, fixed = true));
  Body disc(m = 2, I = {0.03, 0.0625, 0.03}, center = spin.b);
  RollingDisc rolling(r = r, axis = {0, 1, 0}, base = world, center = disc.center);
  AppliedTorque push(on = lean.b, torque = {0, 0, 1 + 0*time});
end Coin;
"""


def test_a_loop_that_moves() -> None:
    """A is the slope of the motion itself, by differences of starts that are closed anew."""
    model = lag.load(EXAMPLES / "four_bar.lag")
    start = {"O.phi": 0.7, "O.w": 3.0}
    linear = model.linearize(about="start", initial=start)
    assert linear.states == ("O.phi", "der(O.phi)") and "not steady" in linear.notes[-1]

    def acceleration(**moved: float) -> float:
        run = model.start(initial=start | {f"O.{name}": start[f"O.{name}"] + x for name, x in moved.items()})
        state, n = np.array(run.state), len(model.coordinate_names)
        return float(model.functions()["rhs"](0, state[:n], state[n:], [], model.parameter_values()).full()[0, 0])

    h = 1e-4
    slopes = [(acceleration(**{name: h}) - acceleration(**{name: -h})) / (2 * h) for name in ("phi", "w")]
    assert linear.A[1] == pytest.approx(slopes, rel=1e-6)
    assert linear.drift[1] == pytest.approx(acceleration(), rel=1e-12)
    assert model.modes(about="start", initial=start).damped and not len(model.modes(about="start", initial=start))


SHAKEN = """model Shaken "a four-bar, one of whose bearings is shaken"
  World world;
  Prismatic lift(a = world, along = {0, 1}, s(start = 0.3));
  Revolute A(a = world, phi(start = 1.2), w(start = 2)); Bar crank(m = 1, L = 0.4, a = A.b);
  Revolute B(a = crank.b); Bar coupler(m = 1, L = 1, a = B.b);
  Revolute C(a = shift(lift.b, {1.2, 0})); Bar rocker(m = 1, L = 0.8, a = C.b);
  Revolute D(a = coupler.b, b = rocker.b);
equation
  lift.s = 0.3*cos(5*time);
end Shaken;"""


def test_a_small_change_goes_on_as_the_matrices_of_a_shaken_loop_say() -> None:
    """Runs from starts beside each other, closed anew, part as x'' = A21 x + A22 x' over a short while."""
    model, t, h = lag.loads(SHAKEN), 1e-3, 1e-3
    linear = model.linearize(about="start")
    assert linear.states == ("A.phi", "der(A.phi)")
    assert "not steady" in linear.notes[0] and "time goes on" in linear.notes[1]

    def end(phi: float, w: float) -> np.ndarray:
        run = model.simulate(at=[0, t, 2 * t], tolerance=1e-13, initial={"A.phi": 1.2 + phi, "A.w": 2 + w})
        return np.array([-3, 4, -1]) @ np.array(run["der(A.phi)"]) / (2 * t)  # its rate at the start, to t^2

    slopes = [(end(h, 0) - end(-h, 0)) / (2 * h), (end(0, h) - end(0, -h)) / (2 * h)]
    assert linear.A[1] == pytest.approx(slopes, rel=1e-4)
    assert linear.drift[1] == pytest.approx(end(0, 0), rel=1e-4)


def test_a_shaken_loop_is_closed_at_the_time_that_is_looked_at() -> None:
    """As the same loop whose support is ahead by as much; digits by runs from starts beside each other, to 2e-5."""
    later = lag.loads(SHAKEN).linearize(about="start", time=0.4)
    ahead = lag.loads(SHAKEN.replace("5*time", "5*(time + 0.4)")).linearize(about="start")
    assert later.point == pytest.approx(ahead.point, abs=1e-12) and later.point["B.phi"] == pytest.approx(-2.38207, abs=1e-5)
    for linear in (later, ahead):
        assert linear.A[1] == pytest.approx([10.420434, 2.453858], rel=3e-5)
        assert linear.drift[1] == pytest.approx(-16.244673, rel=3e-5)
    fixed = lag.loads(SHAKEN.replace("s(start = 0.3)", "s(start = 0.3, fixed = true)")).linearize(about="start", time=0.4)
    assert (fixed.A == later.A).all()


@pytest.mark.parametrize(("against", "slopes", "drift"), [
    ("0", [3.15975, -0.07438], -16.09785), ("der(lift.s)", [6.80538, -0.07438], -11.51670)])
def test_a_shaken_loop_that_rubs(against: str, slopes: list[float], drift: float) -> None:
    """Against the world or the support. Digits by runs from starts beside each other, to 5e-5."""
    rubbing = SHAKEN.replace("0.3*cos(5*time)", "0.3 + 0.1*sin(8*time)").replace("w(start = 2)", "w(start = 0.5)")
    linear = lag.loads(rubbing.replace("equation", f"energy\n  dissipation 3*abs(der(D.a.y) - {against});\nequation")
                       ).linearize(about="start")
    assert linear.A[1] == pytest.approx(slopes, rel=6e-4, abs=1e-4) and linear.drift[1] == pytest.approx(drift, rel=1e-4)
    assert not any("L0743" in note for note in linear.notes)  # it slips


SWING = """model Swing "two ropes on a lift"
  World world;
  Prismatic lift(a = world, along = {0, 1});
  Revolute A(a = lift.b, phi(start = -pi/2)); Bar left(m = 1, L = 1, a = A.b);
  Revolute B(a = left.b, phi(start = pi/2)); Bar seat(m = 1, L = 1, a = B.b);
  Revolute C(a = shift(lift.b, {1, 0}), phi(start = -pi/2)); Bar right(m = 1, L = 1, a = C.b);
  Revolute D(a = seat.b, b = right.b);
equation
  lift.s = 0.3*cos(5*time);
end Swing;"""
PENDULUM = """model Pendulum
  World world;
  Prismatic lift(a = world, along = {0, 1});
  Revolute h(a = lift.b, phi(start = 0.4), w(start = 1));
  PointMass m(m = 1, center = shift(h.b, {0, -1}));
equation
  lift.s = 0.3*cos(5*time);
end Pendulum;"""


@pytest.mark.parametrize("phi", [0.0, 1e-7])
def test_time_goes_on_about_the_start_in_balance_or_not(phi: float) -> None:
    """Weight is m (g + s''), s'' = -7.5 m/s2 at the start."""
    model, start = lag.loads(SWING), {"A.phi": phi - np.pi / 2}
    linear, still = model.linearize(about="start", initial=start), model.linearize(initial=start)
    assert linear.A[1, 0] == pytest.approx(-1.2 * (9.81 - 7.5), rel=1e-9) and "time goes on" in linear.notes[1]
    assert still.A[1, 0] == pytest.approx(-1.2 * 9.81, rel=1e-9) and "stopped at 0 s" in still.notes[-1]


def test_time_goes_on_about_the_start_of_a_pendulum_on_a_lift() -> None:
    model, weight = lag.loads(PENDULUM), 9.81 - 7.5
    linear = model.linearize(about="start")
    assert linear.A[1] == pytest.approx([-weight * np.cos(0.4), 0], rel=1e-12)
    assert linear.drift[1] == pytest.approx(-weight * np.sin(0.4), rel=1e-12)
    assert "time goes on" in linear.notes[0] and "which goes on" in linear.notes[1]
    hanging = model.linearize(about="start", initial={"h.phi": 0, "h.w": 0})
    assert hanging.is_equilibrium and hanging.A[1, 0] == pytest.approx(-weight, rel=1e-12)


@pytest.mark.parametrize("spin", [2.0, 8.0])
def test_a_disc_that_rolls_upright(spin: float) -> None:
    """E.J. Routh: it stays upright above a speed, and else falls. What turns it about the vertical answers as it should."""
    m, r, A, C, g = 2.0, 0.25, 0.03, 0.0625, 9.81
    model = lag.loads(COIN)
    linear = model.linearize(about="start", initial={"spin.w": spin}, excitations=["push.torque[3]"], outputs=["path.phi"])
    squared = (m * g * r - (C + m * r * r) * C * spin**2 / A) / (A + m * r * r)
    assert linear.free_rates == ("der(path.phi)", "der(lean.phi)", "der(spin.phi)") and "steady" in linear.notes[-1]
    found = linear.eigenvalues[-2:]
    assert found**2 == pytest.approx([squared] * 2, rel=1e-12)
    k = linear.free_rates.index("der(path.phi)")
    assert linear.M[k, k] == pytest.approx(A, rel=1e-14) and linear.F[0][k, 0] == pytest.approx(1)
    s, other = 1.7, model.response(excitations=["push.torque[3]"], outputs=["path.phi"], about="start",
                                   frequencies=[1.7 / (2 * np.pi)], initial={"spin.w": spin})
    known = (-s * s - m * g * r / (A + m * r * r)) / (A * -s * s * (-s * s - squared))  # of the two coupled equations
    assert complex(other.values[0, 0, 0]) == pytest.approx(known, rel=1e-10)


def test_what_is_not_there(tmp_path: Path) -> None:
    model = lag.loads(COIN)
    with pytest.raises(lag.LagError, match="L0916"):
        model.modes(about="start").plot(tmp_path / "x.png")
    with pytest.raises(lag.LagError, match="supports that are moved"):
        lag.load(EXAMPLES / "four_bar.lag").linearize(about="start", excitations=["C.a.x"])


def test_states_are_what_the_model_starts() -> None:
    """Balls of cut joints, of which it says nothing, begin unturned: five of the six places were theirs."""
    model = lag.load(EXAMPLES / "hexapod.lag")
    for about in ("equilibrium", "start"):
        names = model.linearize(about=about).coordinates
        assert len(names) == 6 and all(name.startswith(("pose.", "leg[")) for name in names)
