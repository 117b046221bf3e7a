"""Conditions on places that friction holds at their level, and on lengths that are 0."""

from collections.abc import Callable

import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "erk9", "adams", "implicit", "pirk", "taylor")
BLOCK = """
  World world(gravity = {0, 0});  Block b(m = 1, base = world, s(start = %s));  DryFriction f(F = 3, rate = b.v);
  AppliedForce p(at = b.center, force = {%s, 0});
"""
STEADY, SWINGS, TEARS_OFF = BLOCK % (0, "1"), BLOCK % (0, "2*cos(7*time)"), BLOCK % (0, "3*time")
SLOPE = "Block b(m = 1, base = turn(world, -0.2));  DryFriction f(F = 3, rate = b.v);"
SPRING = BLOCK % (0, "1*cos(7*time)") + "Spring k(k = 10, stretch = b.s - 0.1);"
CLUTCH = """
  World world(gravity = {0, 0});  Revolute p(a = world), q(a = world);
  Disc d(m = 1, r = 1, I = 1, center = p.b), e(m = 1, r = 1, I = 2, center = q.b);
  DryFriction f(F = 5, rate = 1[m]*(q.w - p.w));  AppliedTorque T(on = d.center, torque = 2*sin(3*time));
"""


def for_how_long(scene: Write, text: str, condition: str, solver: str) -> float:
    """Of 2 s."""
    model = scene(f"model Timer {text} Time y(start = 0);  equation der(y) = if {condition} then 1 else 0;  end Timer;")
    return float(model.simulate(at=[0.0, 0.5, 1.0, 2.0], solver=solver)["y"][-1])


@pytest.mark.parametrize("text", [STEADY, SWINGS, TEARS_OFF, SLOPE, SPRING])
def test_places_that_friction_holds_at_0_are_there(scene: Write, text: str) -> None:
    """`b.s > 0` was true for 2 s of a block that sticks at 0, or no step was small enough, as rounding of its force chose."""
    moves = 1 if text == TEARS_OFF else 0
    for condition, right in {"b.s > 0": moves, "b.s >= 0": 2, "b.s < 0": 0, "b.s == 0": 2 - moves, "abs(b.s) > 0": moves}.items():
        for solver in SOLVERS:
            assert for_how_long(scene, text, condition, solver) == pytest.approx(right, abs=1e-7), (condition, solver)


@pytest.mark.parametrize(("condition", "right"), [("q.phi > p.phi", 0), ("q.phi >= p.phi", 2), ("q.phi == p.phi", 2)])
def test_places_that_move_together_are_equal(scene: Write, condition: str, right: float) -> None:
    """Of a clutch that does not slip: for 3 to 26 ms they were not."""
    for solver in SOLVERS:
        assert for_how_long(scene, CLUTCH, condition, solver) == pytest.approx(right, abs=1e-7), solver


TWO = """
  parameter Velocity least = 0;
  World world(gravity = {0, 0});  Block b(m = 1, base = world), c(m = 1, base = world, v(start = %s));
  DryFriction f(F = 3, rate = b.v);  AppliedForce p(at = b.center, force = {1, 0});
"""
BOTH = TWO + "DryFriction g(F = 3, rate = c.v);"


@pytest.mark.parametrize("condition", [
    "norm({b.v, c.v}) > 0", "0 < norm({b.v, c.v})", "sqrt(b.v^2 + c.v^2) > 0", "norm({b.v, c.v})^2 > 0", "2*norm({b.v, c.v}) > 0",
    "norm({b.v, c.v, 0.5*b.v}) > 0", "norm({b.v, c.v}) > least", "norm({b.v, c.v}) <> 0", "not norm({b.v, c.v}) <= 0",
    "sign(norm({b.v, c.v})) > 0", "b.v^2 + c.v^2 > 0", "abs(b.v) + abs(c.v) > 0", "max(abs(b.v), abs(c.v)) > 0"])
def test_lengths_of_what_rests_are_0(scene: Write, condition: str) -> None:
    """Roots held 1e-300 there: true for 2 s. Sums were not 0 beside what nothing holds."""
    for text, right in ((BOTH % 0, 0), (BOTH % 1, 1 / 3), (TWO % 0, 0), (TWO % 1, 2)):
        for solver in SOLVERS:
            assert for_how_long(scene, text, condition, solver) == pytest.approx(right, abs=1e-7), (text, solver)


def test_lengths_of_0_are_0_in_rows(scene: Write) -> None:
    """1e-150 was given. What is divided by them is 0."""
    asked = {"a": "norm({b.v, c.v})", "d": "sqrt(b.s^2 + c.s^2)", "e": "distance(P.center, Q.center)",
             "r": "norm({b.v, c.v})^0.5", "g": "sign(norm({b.v, c.v}))",
             "h": "ceil(norm({b.v, c.v})/1[m/s])", "k": "b.v/norm({b.v, c.v})"}
    outputs = ", ".join(f"{name} = {law}" for name, law in asked.items())
    model = scene(f"model Rows {TWO % 0} PointMass P(m = 1), Q(m = 1);  output Real {outputs};  end Rows;")
    for solver in ("auto", "implicit"):
        run = model.simulate(at=[0.0, 1.0], solver=solver)
        assert [run[name][-1] for name in asked] == [0.0] * len(asked), solver


def test_events_ask_for_lengths_of_0(scene: Write) -> None:
    """c stops after 1/3 s, where both rest."""
    model = scene(f"""model Stops {BOTH % 1} discrete Time came(start = 0);  discrete Real n(start = 0);
    equation when norm({{b.v, c.v}}) <= 0 then came = time;  n = pre(n) + 1; end when; end Stops;""")
    for solver in SOLVERS:
        run = model.simulate(at=[0.0, 1.0, 2.0], solver=solver)
        assert (run["n"][-1], run["came"][-1]) == (1, pytest.approx(1 / 3, abs=1e-9)), solver
