"""Linkages in space: as mobile as they are known to be, without hints; their loops stay shut and their energy is kept."""

from math import asin, cos, pi, radians, sin

import pytest

import lagrangia as lag

A, B, TWIST = 0.3, 0.45, radians(30)
OTHER = asin(B * sin(TWIST) / A)  # Bennett's condition: a/sin(alpha) = b/sin(beta)
BENNETT = f"""
  Revolute h1(a = world, axis = {{0, 0, 1}}, phi(start = 0.7, fixed = true), w(start = 2, fixed = true));
  Body l1(m = 1, I = {{0.001, 0.01, 0.01}}, center = shift(h1.b, {{{A / 2}, 0, 0}}));
  Revolute h2(a = turn(shift(h1.b, {{{A}, 0, 0}}), {TWIST!r}, {{1, 0, 0}}), phi(start = -1));
  Body l2(m = 1, I = {{0.001, 0.01, 0.01}}, center = shift(h2.b, {{{B / 2}, 0, 0}}));
  Revolute h3(a = turn(shift(h2.b, {{{B}, 0, 0}}), {OTHER!r}, {{1, 0, 0}}), phi(start = 1));
  Body l3(m = 1, I = {{0.001, 0.01, 0.01}}, center = shift(h3.b, {{{A / 2}, 0, 0}}));
  Revolute h4(a = turn(shift(h3.b, {{{A}, 0, 0}}), {TWIST!r}, {{1, 0, 0}}), phi(start = -1),
              b = turn(shift(world, {{{-B}, 0, 0}}), {-OTHER!r}, {{1, 0, 0}}));
"""
SLIDER_CRANK = """
  Revolute crank(a = turn(world, 30[deg], {1, 0, 0}), phi(start = 0.4, fixed = true), w(start = 6, fixed = true));
  Body wheel(m = 1, I = {0.01, 0.01, 0.02}, center = crank.b);
  Spherical pin(a = shift(crank.b, {0.1, 0, 0}));
  Body rod(m = 0.5, I = {0.001, 0.01, 0.01}, center = shift(pin.b, {0.2, 0, 0}));
  Universal eye(a = shift(pin.b, {0.4, 0, 0}), axis_a = {0, 1, 0}, axis_b = {0, 0, 1});
  Prismatic guide(a = world, along = {1, 0, 0}, b = eye.b, s(start = 0.45));
  Body block(m = 1, I = {0.01, 0.01, 0.01}, center = guide.b);
"""


def hexapod() -> str:
    """A plate on six legs of tubes and rods, with springs along them."""
    lines = ["Cylinder plate(m = 10, r = 0.5, h = 0.05);"]
    for k in range(6):
        side = -1 if k % 2 else 1
        foot, top = (f"{{{r * cos(angle)!r}, {r * sin(angle)!r}, 0}}"
                     for r, angle in ((1, radians(60 * k - 10 * side)), (0.5, radians(60 * k + 20 * side))))
        lines += [f"Universal foot{k}(a = shift(world, {foot}), phi_a(start = 0.1), phi_b(start = 0.1));",
                  f"Body tube{k}(m = 0.5, I = {{0.01, 0.01, 0.001}}, center = shift(foot{k}.b, {{0, 0, 0.2}}));",
                  f"Prismatic leg{k}(a = foot{k}.b, along = {{0, 0, 1}}, s(start = 1));",
                  f"Body rod{k}(m = 0.5, I = {{0.01, 0.01, 0.001}}, center = shift(leg{k}.b, {{0, 0, -0.2}}));",
                  f"Spherical ball{k}(a = leg{k}.b, b = shift(plate.center, {top}));",
                  f"Spring push{k}(k = 4000, s_rel0 = 1.1, a = foot{k}.a, b = ball{k}.a);"]
    return "\n".join(lines)


@pytest.mark.parametrize(("text", "degrees", "repeats", "most"), [
    (BENNETT, 1, True, 600), (SLIDER_CRANK, 1, False, 500), (hexapod(), 6, False, 10_000),
], ids=["bennett", "slider crank", "hexapod"])  # fmt: skip
def test_linkages_in_space(text: str, degrees: int, repeats: bool, most: int) -> None:
    """`most` operations a call."""
    model = lag.loads(f"model M World world(gravity = {{0, 0, -9.81}}); {text} end M;")
    freedom = model.freedom
    assert freedom["degrees_of_freedom"] == degrees and bool(freedom["repeated"]) is repeats
    assert not repeats or "not unique" in freedom["repeated"][0]
    assert model.scene.notes["rhs_operations"] <= most
    run = model.simulate(stop=0.5, interval=0.25, tolerance=1e-10)
    assert run.statistics.constraint_residual < 1e-12
    assert run.energy.total == pytest.approx([run.energy.total[0]] * run.time.size, abs=1e-8)


JACK = """model Jack "a nut on a screw lifts a rod that moves a lever"
  World world(gravity = {0, 0, -9.81});
  {nut}
  Revolute pin(a = shift(bearing.b, {0.1, 0, 0}), axis = {0, 1, 0});
  Body rod(m = 0.5, I = {0.001, 0.01, 0.01}, center = shift(pin.b, {0.2, 0, 0}));
  Revolute lever(a = shift(world, {0.5, 0, 0.3}), axis = {0, 1, 0});
  Body arm(m = 2, I = {0.01, 0.02, 0.02}, center = shift(lever.b, {0, 0, -0.15}));
  Revolute last(a = shift(pin.b, {0.4, 0, 0}), b = shift(lever.b, {0, 0, -0.3}), axis = {0, 1, 0});
end Jack;
"""


def test_a_constraint_along_which_nothing_moves_where_a_run_begins() -> None:
    """Of a hinge that closes a loop, whose axis the nut turns: its row is 0 there, and accelerations were 0/0. Against
    a slider with the mass that the turning nut is felt as."""
    screw = ("Screw screw(a = world, axis = {0, 0, 1}, pitch = 0.2, w(start = 5));"
             " Revolute bearing(a = screw.b, axis = {0, 0, 1}); Body nut(m = 1, I = {0.01, 0.01, 0.02}, center = screw.b);")
    per = 0.2 / (2 * pi)
    slider = (f"Prismatic bearing(a = world, along = {{0, 0, 1}}, v(start = {5 * per}));"
              f" Body nut(m = {1 + 0.02 / per**2}, I = {{0.01, 0.01, 0.02}}, center = bearing.b);"
              f" AppliedForce lift(at = nut.center, force = {{0, 0, {9.81 * 0.02 / per**2}}});")
    turned, slid = (lag.loads(JACK.replace("{nut}", nut)).simulate(at=[0, 0.3], tolerance=1e-11) for nut in (screw, slider))
    assert turned["lever.phi"][-1] == pytest.approx(slid["lever.phi"][-1], abs=1e-10)
    assert per * turned["screw.phi"][-1] == pytest.approx(slid["bearing.s"][-1], abs=1e-10)
