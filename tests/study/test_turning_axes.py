"""Small motion about motions that turn, beside closed forms: in axes that turn along."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.study.linearization import Linearization

DISC = lag.load(Path(__file__).parents[2] / "models" / "examples" / "rolling_disc_space.lag")
HINGES = """
model Hinges "The same disc, by hinges"
  parameter Angle lean0 = 60[deg];
  World world(gravity = {0, 0, -9.81});
  PlanarJoint path(a = world, x(start = 0), y(start = 0), phi(start = 0));
  Prismatic height(a = path.b, along = {0, 0, 1}, s(start = 0.25*sin(lean0)));
  Revolute lean(a = height.b, axis = {1, 0, 0}, phi(start = lean0), w(start = 0));
  Revolute spin(a = lean.b, axis = {0, 0, 1}, phi(start = 0));
  Disc disc(m = 2, r = 0.25, center = spin.b);
  RollingDisc rolling(r = 0.25, base = world, center = spin.b);
end Hinges;
"""
TOP = """
model Top
  World world(gravity = {0, 0, -9.81});
  Spherical tip(a = world, S(start = angles("zxz", 0.3, 0.7, 0.4)));
  Body top(m = 0.5, I = {0.0008, 0.0008, 0.001}, center = shift(tip.b, {0, 0, 0.1}));
end Top;
"""
CENTRE = """
model Centre
  parameter Real k = 1;
  World world(gravity = {0, 0});
  Planar p(a = world, x(start = 1), y(start = 0), phi(start = 0));
  Body b(m = 1, I = 1, center = p.b);
  energy potential -k/sqrt(p.x^2 + p.y^2);
end Centre;
"""
STEADY = "steady in axes that turn"


def nearest(linear: Linearization, omega: float) -> float:
    return float(np.abs(linear.eigenvalues - 1j * omega).min())


@pytest.mark.parametrize(("theta", "turning"), [(np.pi / 3, 1.5), (1.2, 3.0), (0.3, 9.0)])
def test_a_disc_in_a_circle(theta: float, turning: float) -> None:
    """(A + m r^2) theta'' = A phi'^2 s c - (C + m r^2) w3 phi' s - m g r c, A (phi' s)' = (C w3 - A phi' c) theta',
    (C + m r^2) w3' = m r^2 phi' s theta', about where it stays: the same in hinges and in a Rotation."""
    m, r, g = 2, 0.25, 9.81
    A, C, s, c = m * r**2 / 4, m * r**2 / 2, np.sin(theta), np.cos(theta)
    J = C + m * r**2
    w3 = (A * turning**2 * s * c - m * g * r * c) / (J * turning * s)
    by_theta = A * turning**2 * np.cos(2 * theta) - J * w3 * turning * c + m * g * r * s
    by_turning, by_spin = (2 * A * turning * c - J * w3) * s, -J * turning * s
    square = by_theta + by_turning * (C * w3 - 2 * A * turning * c) / (A * s) + by_spin * m * r**2 * turning * s / J
    omega = np.sqrt(-square / (A + m * r**2))
    free = DISC.linearize(about="start", parameters={"lean": theta},
                          initial={"der(disc.center.S)[2]": turning * s, "der(disc.center.S)[3]": w3})
    hinged = lag.loads(HINGES).linearize(about="start", parameters={"lean0": theta},
                                         initial={"der(path.phi)": turning, "spin.w": w3 - turning * c})
    for linear in (free, hinged):
        assert STEADY in linear.notes[-1] and not linear.drift.any()
        assert nearest(linear, omega) < 1e-9 * omega and nearest(linear, turning) < 1e-9 * turning  # a circle beside it
    aside = DISC.linearize(about="start", parameters={"lean": theta}, initial={"der(disc.center.S)[3]": 0.9 * w3})
    assert any("not steady" in note for note in aside.notes)


def test_a_disc_that_rolls_straight_in_a_rotation() -> None:
    m, r, g, w = 2, 0.25, 9.81, 8.0
    A, C = m * r**2 / 4, m * r**2 / 2
    damped = DISC.modes(about="start", parameters={"lean": np.pi / 2}, initial={"der(disc.center.S)[2]": 0}).damped
    omega = np.sqrt((C * (C + m * r**2) * w**2 / A - m * g * r) / (A + m * r**2))
    assert [mode.omega for mode in damped if mode.omega] == pytest.approx([omega], rel=1e-10)


@pytest.mark.parametrize("k", [0, 1])
def test_a_top_nods_about_its_steady_precessions(k: int) -> None:
    """V = (p - C w cos)^2/(2 A sin^2) + m g l cos: V''/A at the tilt that stays, of the fast and the slow precession."""
    A, C, mgl, theta, w = 0.0008 + 0.5 * 0.01, 0.001, 0.5 * 9.81 * 0.1, 0.7, 150.0
    s, c = np.sin(theta), np.cos(theta)
    turning = np.roots([A * c, -C * w, mgl])[k]
    initial = {"tip.w[1]": turning * s * np.sin(0.4), "tip.w[2]": turning * s * np.cos(0.4), "tip.w[3]": w}
    linear = lag.loads(TOP).linearize(about="start", initial=initial)
    omega = np.hypot(C * w / A - 2 * turning * c, turning * s)
    assert STEADY in linear.notes[-1] and nearest(linear, omega) < 1e-9 * omega


def test_a_body_on_a_circle_about_a_centre() -> None:
    """In x and y: n^2 of 1/r is the square of the rate of the circle; what is no circle is not told as steady."""
    centre = lag.loads(CENTRE)
    circle, other = (centre.linearize(about="start", initial={"der(p.y)": rate}) for rate in (1.0, 1.2))
    assert STEADY in circle.notes[-1] and nearest(circle, 1.0) < 1e-9 and circle.eigenvalues.real.max() < 1e-4
    assert not any(STEADY in note for note in other.notes)


def test_masses_that_nothing_joins_turn_no_axes() -> None:
    """Two on tracks of their own that swing alike, a quarter of a turn apart: A is constant, and nothing has a heading."""
    tracks = lag.loads("""
        model Tracks
          parameter Mass m = 1; parameter Real k(unit = "N/m") = 4;
          coordinate Length a(start = 1, fixed = true), b(start = 0, fixed = true);
          Velocity va(start = 0, fixed = true) = der(a), vb(start = 2, fixed = true) = der(b);
        energy
          kinetic m*der(a)^2 + 0.5*m*der(b)^2;
          potential k*a^2 + 0.5*k*b^2;
        end Tracks;""")
    modes, linear = tracks.modes(about="start"), tracks.linearize(about="start")
    assert [mode.omega for mode in modes.damped] == pytest.approx([2, 2], rel=1e-12)
    assert not any(STEADY in note for note in linear.notes)
