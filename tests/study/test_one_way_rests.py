"""What conditions on rates hold at rest, as a ratchet's pawl does, wherever it stands, against closed forms."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

G = 9.81
Write = Callable[[str], lag.Model]
_SPRING = """model R World world(gravity = {0, 0}); Block b(m = 1, base = world, s(start = PLACE));
  Spring k(k = 4, stretch = b.s - 0.3);
  equation when CONDITION then reinit(b.v, LEVEL); end when; end R;"""


def _spring(place: float, condition: str, level: float, scene: Write) -> lag.Model:
    return scene(_SPRING.replace("PLACE", str(place)).replace("CONDITION", condition).replace("LEVEL", str(level)))


@pytest.mark.parametrize(("place", "condition", "force"), [
    (0.5, "b.v < 0", 0.8), (0.1, "b.v > 0", 0.8), (-2e3, "b.v > 0", 4 * 2000.3), (0.5, "2*b.v < 0", 0.8), (0.0, "b.v > 0", 1.2)])
def test_a_pawl_holds_where_it_is_pushed_against(place: float, condition: str, force: float, scene: Write) -> None:
    """At its start, wherever the coordinate counts from; nothing moves there, and a run stays."""
    model = _spring(place, condition, 0, scene)
    first = model.equilibrium()[0]
    assert first.position["b.s"] == place and first.stability == "fixed"
    assert first.contacts == pytest.approx({condition: force}, rel=1e-12)
    assert not model.modes().omega.size and model.simulate(stop=50.0)["b.s"][-1] == place


@pytest.mark.parametrize("place", [0.9, 0.3])
def test_a_pawl_lets_go_the_other_way(place: float, scene: Write) -> None:
    """It is drawn to where the spring is relaxed, and just touches there."""
    first = _spring(place, "b.v > 0", 0, scene).equilibrium()[0]
    assert first.position["b.s"] == pytest.approx(0.3, abs=1e-12) and first.stability == "one-sided"


@pytest.mark.parametrize(("place", "condition", "level"), [
    (0.3, "b.v > 0.5", 0.5), (-0.3, "b.v > 0.5", 0.5), (0.1, "b.v < -0.5", -0.5), (0.7, "b.v < -1e-3", -1e-3)])
def test_a_limit_of_speed_holds_nothing_at_rest(place: float, condition: str, level: float, scene: Write) -> None:
    model = _spring(place, condition, level, scene)
    first = model.equilibrium()[0]
    assert first.position["b.s"] == pytest.approx(0.3, abs=1e-12) and first.stability == "stable" and not first.contacts
    np.testing.assert_allclose(model.modes().omega, [2], rtol=1e-12)


def test_nothing_rests_where_a_condition_drives(scene: Write) -> None:
    with pytest.raises(lag.RunError, match="no equilibrium"):
        _spring(0.1, "b.v < 0.5", 0.5, scene).modes()


def test_what_is_beside_a_pawl_moves(scene: Write) -> None:
    """m w^2 = k of the other mass; from a start that moves the pawl holds nothing."""
    text = """model Two World world(gravity = {0, 0}); Block b(m = 1, base = world, s(start = 0.5), v(start = V)),
      c(m = 2, base = world, s(start = 0.8)); Spring k(k = 4, stretch = b.s), j(k = 8, stretch = c.s - b.s - 0.2);
      equation when b.v < 0 then reinit(b.v, 0); end when; end Two;"""
    model = scene(text.replace("V)", "0)"))
    first, modes = model.equilibrium()[0], model.modes()
    np.testing.assert_allclose([first.position["b.s"], first.position["c.s"]], [0.5, 0.7], atol=1e-12)
    assert first.contacts == pytest.approx({"b.v < 0": 2.0}, rel=1e-9) and modes[0].shape["b.s"] == 0
    np.testing.assert_allclose(modes.omega, [2], rtol=1e-12)
    moving = scene(text.replace("V)", "1)")).modes(about="start")
    np.testing.assert_allclose(moving.omega, np.sqrt(8 + np.array([-1, 1]) * np.sqrt(48)), rtol=1e-9)


def test_a_free_wheel_that_is_pressed(scene: Write) -> None:
    """Both shafts turn as one: 6 a + 12 b = 0 with b = a + 0.2, 3 w^2 = 18."""
    model = scene("""model Wheel World world(gravity = {0, 0}); Revolute a(a = world), b(a = world);
      Body A(m = 0, I = 1, center = a.b), B(m = 0, I = 2, center = b.b);
      TorsionSpring s(a = world, b = b.b, k = 12), t(a = world, b = a.b, k = 6);
      initial equation a.phi = 0.1; b.phi = 0.3;
      equation when b.w - a.w < 0 then reinit(b.w - a.w, 0); end when; end Wheel;""")
    first, modes = model.equilibrium()[0], model.modes()
    np.testing.assert_allclose([first.position["a.phi"], first.position["b.phi"]], [-0.4 / 3, 0.2 / 3], atol=1e-12)
    assert first.contacts == pytest.approx({"b.w - a.w < 0": 0.8}) and modes[0].shape["a.phi"] == modes[0].shape["b.phi"]
    np.testing.assert_allclose(modes.omega, [np.sqrt(6)], rtol=1e-12)


def test_a_pawl_in_a_loop_and_under_a_pendulum(scene: Write) -> None:
    """A slider that may only rise carries a spring's weight; a second pendulum swings beneath a first that is held."""
    slider = scene("""model Slider Revolute c(a = world, phi(start = 1)); Body f(m = 1, I = 0.1, center = c.b);
      Block s(m = 2, base = world, along = {0, 1}), t(m = 0.5, base = world, along = {0, 1});
      Spring k(k = 50, stretch = t.s - s.s);
      equation s.s = 0.1*sin(c.phi); when s.v < 0 then reinit(s.v, 0); end when; end Slider;""")
    first = slider.equilibrium()[0]
    assert first.position["c.phi"] == pytest.approx(1, abs=1e-9) and first.contacts == pytest.approx({"s.v < 0": 2.5 * G})
    np.testing.assert_allclose(slider.modes().omega, [10], rtol=1e-9)
    pendulum = scene("""model Double Revolute h(a = world, phi(start = 0.5)), g(a = shift(h.b, {0, -1}), phi(start = -0.2));
      PointMass p(m = 1, center = shift(h.b, {0, -1})), r(m = 1, center = shift(g.b, {0, -0.5}));
      equation when h.w < 0 then reinit(h.w, 0); end when; end Double;""")
    first = pendulum.equilibrium()[0]
    np.testing.assert_allclose([first.position["h.phi"], first.position["g.phi"]], [0.5, -0.5], atol=1e-9)
    assert first.contacts == pytest.approx({"h.w < 0": 2 * G * np.sin(0.5)})
    np.testing.assert_allclose(pendulum.modes().omega, [np.sqrt(2 * G)], rtol=1e-9)


@pytest.mark.parametrize("held", ["DryFriction f(F = 3, rate = b.v);", "equation when b.v < 0 then reinit(b.v, 0); end when;"])
def test_what_is_held_stays_while_another_comes_to_a_stop(held: str, scene: Write) -> None:
    """c comes to rest on a stop that it does not touch at the start; b was drawn to 0.366667 by its springs instead."""
    first = scene("""model Three World world(gravity = {0, 0}); Block b(m = 1, base = world, s(start = 0.5)),
      c(m = 2, base = world, s(start = 0.8)), d(m = 3, base = world, s(start = 2)); Stop w(gap = c.s - 0.75);
      Spring k(k = 4, stretch = b.s), j(k = 8, stretch = c.s - b.s - 0.2), l(k = 27, stretch = d.s - b.s - 1.5);
      """ + held + " end Three;").equilibrium()[0]
    np.testing.assert_allclose([first.position[x] for x in ("b.s", "c.s", "d.s")], [0.5, 0.75, 2], atol=1e-12)
    assert first.contacts["w"] == pytest.approx(0.4)
    assert [*first.friction.values(), (first.contacts.get("b.v < 0"),)][0][0] == pytest.approx(1.6)
