"""Equations with virtual(x): of gears they run; a force that would act where it does not hold is refused, never dropped."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
TWO = "World world(gravity = {0, 0}); Block A(m = 1, base = world), B(m = 2, base = world);"
RIDES = "World world(gravity = {0, 0}); Block B(m = 2, base = world), A(m = 1, base = B.center);"
REFUSED = {
    "on another body": (TWO, "A.s + virtual(B.s) = 0.1*sin(3[rad/s]*time);", "acts on what it does not hold"),
    "on the other alone": (TWO, "A.s + virtual(B.s) - virtual(A.s) = 0.1*sin(3[rad/s]*time);", "acts on what it does not hold"),
    "on what carries it": (RIDES, "A.s + virtual(B.s) - virtual(A.s) = 0.1*sin(3[rad/s]*time);", "acts on what it does not hold"),
    "on nothing": (TWO, "A.s - virtual(A.s) = 0.1*sin(3[rad/s]*time);", "acts on nothing that could make it hold"),
    "of a rod": ("PointMass A(m = 1), B(m = 1);", "distance(world, A.center) + virtual(B.center.x) = 1[m];", "does not hold"),
    "by a parameter that is 0 as declared": ("parameter Real k = 0; " + TWO, "A.s + k*virtual(B.s) = 0.1*sin(3[rad/s]*time);",
                                             "acts on what it does not hold"),
    "by one that cancels": ("parameter Real k = 1; " + TWO, "A.s + (k - 1)*virtual(B.s) = 0.1*sin(3[rad/s]*time);",
                            "acts on what it does not hold"),
    "by an input": ("input Real u; " + TWO, "A.s + u*virtual(B.s) = 0.1*sin(3[rad/s]*time);", "acts on what it does not hold"),
    "later": (TWO, "A.s + (if time > 2 and time < 3 then 1 else 0)*virtual(B.s) = 0.1*sin(3[rad/s]*time);",
              "acts on what it does not hold"),
    "beside the start": ("PointMass A(m = 1), B(m = 1);", "distance(world, A.center) + B.center.x/1[m]*virtual(B.center.x) "
                         "= 1[m]; initial equation A.center.x = 1; B.center.x = 0;", "does not hold"),
    "of a tie": (TWO, "A.s + 2*virtual(A.s) = 3*B.s;", "acts on what it does not hold"),
}
SHAFTS = "Revolute p(a = {a}), q(a = shift({a}, {{0.3, 0}})); Disc P(m = 1, r = 0.1, center = p.b), "\
         "Q(m = 1, r = 0.2, center = q.b);"
HELD = {
    "a gear": SHAFTS.format(a="world") + "Gear g(r_a = 0.1, r_b = 0.2, a = p.b, b = q.b, carrier = world);",
    "a gear on an arm": "Revolute h(a = world); Bar arm(m = 1, L = 1, center = h.b);" + SHAFTS.format(a="arm.center")
                        + "Belt g(r_a = 0.1, r_b = 0.2, a = p.b, b = q.b, carrier = arm.center);",
    "a gear in a loop": "Revolute h(a = world, phi(start = 0.3)), k(a = shift(world, {1, 0}), phi(start = 0.3)); "
                        "Bar l(m = 1, L = 1, a = h.b), r(m = 1, L = 1, a = k.b); Bar arm(m = 1, L = 1); "
                        "Revolute u(a = l.b, b = arm.a), w(a = r.b, b = arm.b);" + SHAFTS.format(a="arm.center")
                        + "Gear g(r_a = 0.1, r_b = 0.2, a = p.b, b = q.b, carrier = arm.center);",
    "a gear by an equation": "Revolute h(a = world); Bar arm(m = 1, L = 1, center = h.b); parameter Real n = q_r/0.1; "
                             "parameter Real q_r = 0.2;" + SHAFTS.format(a="arm.center")
                             + "equation p.phi + n*q.phi + (n - q_r/0.1)*virtual(h.phi) = 0;",
    "twice what is said": TWO + "equation A.s + 2*virtual(A.s) = 0.1*sin(3[rad/s]*time);",
}


@pytest.mark.parametrize("case", REFUSED)
def test_a_force_elsewhere_is_refused(case: str, scene: Write) -> None:
    parts, equation, told = REFUSED[case]
    with pytest.raises(lag.LagError, match=f"L0917.*{told}"):
        scene(f"model M {parts} equation {equation} end M;")


@pytest.mark.parametrize("case", HELD)
def test_a_share_of_bearings_is_not(case: str, scene: Write) -> None:
    run = scene(f"model M {HELD[case]} end M;").simulate(stop=0.1)
    assert run.time[-1] == 0.1


@pytest.mark.parametrize(("equation", "is_told"), [
    ("A.s = 1[m/s]*time + (virtual(B.s) - virtual(B.s));", True),
    ("A.s = 1[m/s]*time + 0*virtual(B.s);", True),
    ("A.s + 2*virtual(A.s) - virtual(B.s) = 0.1*sin(3[rad/s]*time) - virtual(B.s);", True),
    ("A.s = 1[m/s]*time + virtual(2[m]);", True),
    ("A.s + 2*virtual(A.s) = 0.1*sin(3[rad/s]*time);", False),
    ("A.center.r[1] + virtual(A.center.x) = 1[m/s]*time;", False),
])
def test_a_displacement_that_is_none_is_told(equation: str, is_told: bool, scene: Write) -> None:
    warnings = scene(f"model M {TWO} equation {equation} end M;").warnings
    assert any("L0224" in warning and "virtual(x) is 0 here" in warning for warning in warnings) == is_told


def test_what_components_of_the_library_say_virtually_is_theirs(scene: Write) -> None:
    """Axles that stand still turn about nothing."""
    model = scene("model M Revolute r[2](each a = world); Disc d[2](each m = 1, each r = 1, center = {r[1].b, r[2].b}); "
                  "Gear g(r_a = 1, r_b = 2, a = r[1].b, b = r[2].b, carrier = world); end M;")
    assert model.warnings == []
