"""Positions of rest of loops in space: joints are put together the right way round, and rounding holds nothing."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag

SPACE = """
model Space "A four-bar of a plane, with one axis the other way round"
  World world(gravity = {0, -9.81, 0});
  Revolute h1(a = world, axis = {0, 0, 1}, phi(start = 1));
  Body b1(m = 1, I = {0.01, 0.01, 0.01}, center = shift(h1.b, {0.5, 0, 0}));
  Revolute h2(a = shift(h1.b, {1, 0, 0}), axis = {0, 0, -1}, phi(start = 1.2));
  Body b2(m = 1, I = {0.01, 0.01, 0.01}, center = shift(h2.b, {0.5, 0, 0}));
  Revolute h3(a = shift(h2.b, {1, 0, 0}), axis = {0, 0, 1}, phi(start = 1));
  Revolute h4(a = shift(world, {1.2, 0, 0}), axis = {0, 0, LAST}, b = shift(h3.b, {-0.8, 0, 0}));
  Body b3(m = 1, I = {0.01, 0.01, 0.01}, center = shift(h3.b, {-0.4, 0, 0}));
end Space;
"""
RSSR = """
model Rssr
  World world(gravity = {0, 0, -9.81});
  Revolute crank(a = world, axis = {0, 1, 0}, phi(start = 0.4, fixed = true), w(start = 1, fixed = true));
  Body k(m = 1, I = {0.01, 0.01, 0.01}, center = shift(crank.b, {0.1, 0, 0}));
  Revolute out(a = shift(world, {0.5, 0.05, 0}), axis = {0, 1, 0}, phi(start = 0.5));
  Body o(m = 1, I = {0.01, 0.01, 0.01}, center = shift(out.b, {0.2, 0, 0}));
  Spherical p(a = shift(crank.b, {0.2, 0, 0}));
  Body r(m = 1, I = {0.01, 0.02, 0.02}, center = shift(p.b, {0.25, 0, 0}));
  Spherical q(a = shift(p.b, {0.5, 0, 0}), b = shift(out.b, {0.4, 0, 0}));
end Rssr;
"""
BENNETT = """
model Bennett
  World world(gravity = {0, 0, -9.81});
  Revolute h1(a = world, axis = {0, 0, 1}, phi(start = 0.7, fixed = true), w(start = 2, fixed = true));
  Body l1(m = 1, I = {0.001, 0.01, 0.01}, center = shift(h1.b, {0.15, 0, 0}));
  Revolute h2(a = turn(shift(h1.b, {0.3, 0, 0}), 0.5235987755982988, {1, 0, 0}), phi(start = -1));
  Body l2(m = 1, I = {0.001, 0.01, 0.01}, center = shift(h2.b, {0.225, 0, 0}));
  Revolute h3(a = turn(shift(h2.b, {0.45, 0, 0}), 0.848062078981481, {1, 0, 0}), phi(start = 1));
  Body l3(m = 1, I = {0.001, 0.01, 0.01}, center = shift(h3.b, {0.15, 0, 0}));
  Revolute h4(a = turn(shift(h3.b, {0.3, 0, 0}), 0.5235987755982988, {1, 0, 0}), phi(start = -1),
              b = turn(shift(world, {-0.45, 0, 0}), -0.848062078981481, {1, 0, 0}));
  MORE
end Bennett;
"""


def model(folder: Path, text: str) -> lag.Model:
    path = folder / "m.lag"
    path.write_text(text)
    return lag.load(path)


def test_a_plane_four_bar_rests_where_it_does_in_the_plane(tmp_path: Path) -> None:
    """With rows in space that vanish half a turn away as well, there were eight positions. Energies are those of the same scene
    in two dimensions."""
    found = model(tmp_path, SPACE.replace("LAST", "1")).equilibrium(starts=10)
    energies = {-17.52581: "stable", -6.268636: "stable", 6.268636: "unstable", 17.52581: "unstable"}
    for rest in found:
        near = min(energies, key=lambda x: abs(x - rest.potential))
        assert rest.potential == pytest.approx(near, abs=1e-5) and rest.stability == energies[near]
    assert found.is_reached and len(found) > 2


def test_balls_are_not_put_together_half_a_turn_off(tmp_path: Path) -> None:
    """Where they are, constraints are less independent, and the search failed as a whole."""
    found = model(tmp_path, RSSR).equilibrium(starts=12)
    assert found.is_reached and len(found) > 1
    for rest in found:  # both ends of the rod of 0.5 m
        crank, out = (rest.position[f"{name}.phi"] for name in ("crank", "out"))
        a = np.array([0.2 * np.cos(crank), 0, -0.2 * np.sin(crank)])
        b = np.array([0.5 + 0.4 * np.cos(out), 0.05, -0.4 * np.sin(out)])
        assert np.linalg.norm(b - a) == pytest.approx(0.5, abs=1e-8)
        assert rest.residual < 1e-9


def test_rows_of_rounding_hold_nothing(tmp_path: Path) -> None:
    """At rest the four-bar of Bennett has its links in one plane: a row of it is there of the size of rounding, 1e-17."""
    modes = model(tmp_path, BENNETT.replace("MORE", "")).modes()
    assert len(modes) == 1 and modes.omega[0] == pytest.approx(5.206686, rel=1e-6)


def test_kinetic_energy_of_what_a_cut_joint_keeps(tmp_path: Path) -> None:
    """A flywheel on the joint at which the loop is cut: the account had missed its energy."""
    heavy = model(tmp_path, BENNETT.replace("MORE", "energy kinetic 1/2*0.5*der(h3.phi)^2;"))
    assert np.abs(heavy.simulate(stop=0.2).energy.residual).max() < 1e-6
    first = heavy.start().state
    h3, rate = (heavy.coordinate_names.index("h3.phi") + k * 4 for k in (0, 1))
    assert h3 < rate and abs(first[rate]) > 0.1  # it turns


def test_axes_across_a_plane_that_hold_more_than_their_rates_say(tmp_path: Path) -> None:
    """Its last hinge is across the others: Phi has coordinates that its rate has not, and islands are not cut there."""
    found = model(tmp_path, SPACE.replace("0, 0, LAST", "1, 0, 0")).equilibrium(starts=2)
    assert [x.stability for x in found][:1] == ["fixed"]


def test_small_motion_about_a_start_that_moves(tmp_path: Path) -> None:
    """By differences of starts; later positions are on the constraints again, in the same free coordinate."""
    turned = model(tmp_path, BENNETT.replace("MORE", "energy potential 1/2*20*h4.phi^2;"))
    linear = turned.linearize(about="start")
    assert linear.states == ("h1.phi", "der(h1.phi)") and "not steady" in linear.notes[-1]

    def acceleration(**moved: float) -> float:
        start = {"h1.phi": 0.7, "h1.w": 2.0}
        run = turned.start(initial=start | {f"h1.{name}": start[f"h1.{name}"] + x for name, x in moved.items()})
        state = np.array(run.state)
        return float(turned.functions()["rhs"](0, state[:4], state[4:], [], turned.parameter_values()).full()[0, 0])

    d = 1e-5
    slopes = [(acceleration(**{name: d}) - acceleration(**{name: -d})) / (2 * d) for name in ("phi", "w")]
    np.testing.assert_allclose(linear.A[1], slopes, rtol=1e-6)


def test_one_position_of_several_at_which_nothing_has_mass(tmp_path: Path) -> None:
    """The others are told."""
    text = """
model Bead
  coordinate Real s(start = 0.9), u;
  energy kinetic (der(s)^2 + der(u)^2)/2 + cos(s)*der(s)*der(u);
  energy potential 10*(s^4 - 2*s^2) + 5*u^2;
end Bead;
"""
    found = sorted(model(tmp_path, text).equilibrium(), key=lambda x: x.position["s"])
    assert [x.stability for x in found] == ["stable", "unknown", "stable"]
    assert "moves no mass" in found[1].holding[0] and not found[1].eigenvalues
