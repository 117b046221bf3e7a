"""Forces along a line without length, or one whose length never changes, are pointed at; those that act are not."""

from collections.abc import Callable

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
SPUN = "model Spun Revolute r(a = world, w(start = 1)); Disc d(m = 1, r = 1, center = r.b); %s end Spun;"
SLID = "model Slid World world(gravity = {0, 0}); Block b(m = 1, base = world%s); %s end Slid;"
LOOSE = "model Loose World world(gravity = {0, 0}); PointMass b(m = 1%s); %s end Loose;"


@pytest.mark.parametrize("text", [
    SPUN % "DryFriction f(F = 1, a = world, b = d.center);",
    SPUN % "Damper f(c = 1, a = world, b = d.center);",
    SPUN % "Spring f(k = 1, s_rel0 = 0.1, a = world, b = d.center);",
    SPUN % "ForcePair f(force = 1, a = world, b = d.center);",
    SPUN % "SpringDamper f(k = 1, c = 1, a = d.center, b = shift(d.center, {1, 0}));",
    SPUN % "Damper f(c = 1, a = world, b = shift(d.center, {0.5, 0}));",  # turns about the place it is tied to
    SLID % ("", "DryFriction f(F = 1, a = b.center, b = b.center);"),
    "model Bars Revolute r[2](each a = world); Bar d[2](each m = 1, each L = 1, a = {r[1].b, r[2].b}); "
    "Friction f(mu = 1, normal = 2, a = d[1].a, b = d[2].a); end Bars;",
])
def test_what_never_does_anything(scene: Write, text: str) -> None:
    (warning,) = scene(text).warnings
    assert "L0224" in warning and "'f' does nothing" in warning and "scene.lag:1:" in warning


@pytest.mark.parametrize("text", [
    SLID % ("", "Spring f(k = 1, s_rel0 = 0.5, a = world, b = b.center);"),
    LOOSE % ("", "Spring f(k = 1, s_rel0 = 0.5, a = world, b = b.center);"),
    LOOSE % ("", "SpringDamper f(k = 1, c = 1, s_rel0 = -0.5, a = world, b = b.center);"),
    LOOSE % ("", "ForcePair f(force = 2*cos(1[rad/s]*time), a = world, b = b.center);"),
])
def test_a_force_that_begins_with_no_direction(scene: Write, text: str) -> None:
    (warning,) = scene(text).warnings
    assert "L0607" in warning and "'f'" in warning and "scene.lag:1:" in warning


@pytest.mark.parametrize("text", [
    SLID % ("", "Spring f(k = 1, a = world, b = b.center); Damper d(c = 1, a = world, b = b.center);"),
    SLID % ("", "Spring f(k = 1, stretch = b.s - 0.5);"),
    SLID % (", s(start = 0.1)", "Spring f(k = 1, s_rel0 = 0.5, a = world, b = b.center);"),
    LOOSE % (", center(v(start = {1, 0}))", "Spring f(k = 1, s_rel0 = 0.5, a = world, b = b.center);"),
    LOOSE % ("", "DryFriction f(F = 1, a = world, b = b.center);"),
    "model Given parameter Length d = 0; Revolute r(a = world); Disc w(m = 1, r = 1, center = r.b); "
    "Spring f(k = 1, s_rel0 = 0, a = world, b = shift(w.center, {d, 0})); Damper g(c = 1, a = shift(world, {1, 0}), "
    "b = shift(w.center, {d, 0})); end Given;",
    "model Driven Prismatic p(a = world); PointMass m(m = 1, center = p.b); Motion d(of = p.s, to = 1[m]*sin(1[rad/s]*time)); "
    "Damper f(c = 1, a = world, b = m.center); end Driven;",
])
def test_what_acts_is_not_warned_of(scene: Write, text: str) -> None:
    assert scene(text).warnings == []


@pytest.mark.parametrize(("force", "start", "end"), [
    ("DryFriction f(F = 1, a = world, b = b.center);", 1.0, 1 - 0.5),
    ("Friction f(mu = 0.1, normal = 10, a = world, b = b.center);", 1.0, 1 - 0.5),
    ("Damper f(c = 1, a = world, b = b.center);", 1.0, 1 - np.exp(-1)),
    ("DryFriction f(F = 1, a = world, b = b.center); AppliedForce p(at = b.center, force = {0.9, 0});", 0.0, 0.0),
    ("DryFriction f(F = 1, F_static = 1.5, a = world, b = b.center); AppliedForce p(at = b.center, force = {2, 0});", 0.0, 0.5),
])
def test_what_resists_from_one_place_on(scene: Write, force: str, start: float, end: float) -> None:
    """The direction is that of the motion: closed forms for a unit mass after 1 s."""
    model = scene(LOOSE % (f", center(v(start = {{{start}, 0}}))", force))
    assert model.simulate(at=[1.0], tolerance=1e-10)["b.center.x"][-1] == pytest.approx(end, abs=1e-9)


def test_starts_of_coordinates_that_others_give_are_no_places(scene: Write) -> None:
    """As once was a crash."""
    run = scene("""model M Revolute p(a = world, phi(start = 0.2)), q(a = shift(world, {1, 0}), phi(start = 0.4));
      Bar b(m = 1, L = 1, a = p.b), c(m = 1, L = 1, a = q.b); Coupler tie(a = q.phi, b = p.phi, ratio = 2);
      Spring s(a = b.b, b = c.b, k = 10); end M;""").simulate(stop=0.1)
    assert run["p.phi"][0] == pytest.approx(2 * run["q.phi"][0])


def test_a_line_whose_length_initial_equations_give_has_a_direction() -> None:
    """The guesses are one place; the start is not."""
    model = lag.loads("""model M PointMass p(m = 1, center(x(start = 0.1)));
      Spring s(a = world, b = p.center, k = 10, s_rel0 = 1);
      initial equation s.stretch = 0.2; p.center.y = -1; end M;""")
    assert not any("L0607" in warning for warning in model.warnings)
    text = """model M PointMass p(m = 1); Spring s(a = world, b = p.center, k = 10, s_rel0 = 1);
      initial equation p.center.x = 0; p.center.y = %s; end M;"""
    assert not any("L0607" in warning for warning in lag.loads(text % "-1").warnings)
    assert any("L0607" in warning for warning in lag.loads(text % "0").warnings)
