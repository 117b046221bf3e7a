"""Forces that are another one just where a rate rests: refused, unless that is told or odd as a whole."""

from collections.abc import Callable

import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
DRAWN = """model Drawn
  Block b(m = 1, base = world);
  %s
  AppliedForce load(at = b.center, force = {2[N/s]*time, 0});
end Drawn;"""
BY_LIMIT = "DryFriction f(F = 1[N]*(%s), rate = b.v);"
BY_FORCE = "AppliedForce f(at = b.center, force = {-1[N]*(%s)*sign(b.v), 0});"
KARNOPP = "AppliedForce f(at = b.center, force = {if %s then -2[N]*sign(b.v) else %s, 0});"
UNTOLD = ("3 - sign(b.v)^2", "3 - abs(sign(b.v))", "3 - sign(abs(b.v))", "3 - sign(b.v^2)", "3 - max(sign(b.v), -sign(b.v))",
          "max(2, min(3, 3 - sign(b.v)^2))", "3 - sign(-2*b.v)^2", "3 - sign(b.v)*sign(3*b.v)", "3 - (b.v/abs(b.v))^2",
          "if sign(b.v)^2 > 0.5 then 2 else 3", "2 + cos(sign(b.v))", "3 - sqrt(abs(sign(b.v)))", "2 + sign(b.v)^4",
          "3 - (if b.v > 0[m/s] then 1 else 0) - (if b.v < 0[m/s] then 1 else 0)", "3 - norm({sign(b.v), 0})",
          "if max(b.v, -2*b.v) > 0[m/s] then 2 else 3", "if b.v*sign(b.v) > 0[m/s] then 2 else 3",
          "if exp(abs(b.v)/1[m/s]) > 1 then 2 else 3",
          "if abs(b.v) + abs(2*b.v) > 0[m/s] then 2 else 3", "2 + min(1, ceil(abs(b.v)/1[m/s]))")


@pytest.mark.parametrize("limit", UNTOLD)
@pytest.mark.parametrize("way", [BY_LIMIT, BY_FORCE], ids=["limit", "force"])
def test_what_is_not_told_of_rest_is_refused(scene: Write, limit: str, way: str) -> None:
    """At the component that says so."""
    with pytest.raises(lag.LagError, match=r"(?s)L0918.*scene.lag:3:.*F_static") as refused:
        scene(DRAWN % (way % limit)).simulate(at=[2.0])
    assert "library" not in str(refused.value)


@pytest.mark.parametrize("text", [
    "AppliedForce f(at = b.center, force = {if b.v > 0[m/s] then -1[N]*(3 - sign(b.v)^2) else 1[N]*(3 - sign(b.v)^2), 0});",
    "AppliedForce f(at = b.center, force = {-3[N]*sign(b.v) + 1[N]*sign(b.v)^3, 0});",
    "AppliedForce f(at = b.center, force = {if b.v > 0[m/s] then -2e5[N] elseif b.v < 0[m/s] then 2e5[N] "
    "else -min(5e5[N], max(-5e5[N], 1e7[N/m]*b.s)), 0});",
    "AppliedForce f(at = b.center, force = {-1[N]*(3 - sign(b.v)^2)*(1.3 + 0.3*sign(b.v))*sign(b.v), 0});",
    KARNOPP % ("abs(b.v) > 0[m/s]", "-max(-3[N], min(3[N], 2[N/s]*time))"), KARNOPP % ("b.v <> 0[m/s]", "-2[N/s]*time"),
    "Friction f(mu = 0.3 - 0.1*sign(b.v)^2, normal = 10, rate = b.v);",
    "Velocity slip = b.v - 0.2[m/s]*cos(1[rad/s]*time); DryFriction f(F = 1[N]*(3 - sign(slip)^2), rate = slip);",
    "Block c(m = 2, base = world); Velocity d = c.v - b.v; DryFriction f(F = 1[N]*(3 - abs(sign(d))), rate = d);",
    "Revolute r(a = world); Disc d(m = 1, r = 1, center = r.b); "
    "TorsionDryFriction f(tau = 1[N.m]*(3 - sign(r.w)^2), a = world, b = r.b);",
])
def test_wherever_it_is_said(scene: Write, text: str) -> None:
    with pytest.raises(lag.LagError, match=r"(?s)L0918.*scene.lag:3:"):
        scene(DRAWN % text).simulate(at=[2.0])


@pytest.mark.parametrize(("text", "static", "sliding"), [
    (BY_FORCE % "2*sign(b.v)^4", 2, 2),
    (BY_FORCE % "if b.v > 0[m/s] then 2 else 1.5", 2, 2),
    (BY_FORCE % "2 + 0.5*sign(b.v)", 2.5, 2.5),
    (BY_LIMIT % "if abs(sign(b.v)) > 0 then 2 else 3", 3, 2),
    (BY_LIMIT % "if b.v^4 > 0 then 2 else 3", 3, 2),
    (BY_LIMIT % "if abs(b.v) > 1[m/s] then 2.5 else 2", 2, 2),
    (BY_LIMIT % "if b.v < 0[m/s] or b.v > 0[m/s] then 2 else 3", 3, 2),
    (BY_FORCE % "if max(b.v, -b.v) > 0[m/s] then 2 else 3", 3, 2),
    ("AppliedForce f(at = b.center, force = {if b.v > 0[m/s] then -2[N] else 2[N], 0});", 2, 2),
    (KARNOPP % ("abs(b.v) > 0[m/s]", "0[N]"), 2, 2),
    (KARNOPP % ("b.v <> 0[m/s]", "-max(-2[N], min(2[N], 2[N/s]*time))"), 2, 2),
    (KARNOPP % ("not b.v == 0[m/s]", "-1[N]*sin(1[rad/s]*time)"), 2, 2),
    (KARNOPP % ("b.v^2 > 0[m2/s2]", "-3[N]*sign(b.v)"), 3, 2),
])
def test_what_is_told_or_odd_runs(scene: Write, text: str, static: float, sliding: float) -> None:
    """Torn off at t0 = static/2; then s = (t^3 - t0^3)/3 - t0^2 (t - t0) - sliding (t - t0)^2/2."""
    t, t0 = 2.0, static / 2
    end = (t**3 - t0**3) / 3 - t0**2 * (t - t0) - sliding * (t - t0) ** 2 / 2
    assert scene(DRAWN % text).simulate(at=[t], tolerance=1e-10)["b.s"][-1] == pytest.approx(end, rel=1e-9)


@pytest.mark.parametrize("rest", ["0[N]", "-max(-2[N], min(2[N], load))", "-2[N]*sin(1[rad/s]*time)"])
def test_laws_with_a_force_of_their_own_at_rest_stop_and_turn_back(scene: Write, rest: str) -> None:
    """As -2 sign(v) does; they took steps without end from their first stop on."""
    text = """model M Block b(m = 1, base = world, v(start = 1)); Force load = 2.5[N]*sin(1[rad/s]*time);
      AppliedForce push(at = b.center, force = {load, 0}); AppliedForce f(at = b.center, force = {%s, 0}); end M;"""
    law = f"if abs(b.v) > 0[m/s] then -2[N]*sign(b.v) else {rest}"
    for solver in ("auto", "erk", "implicit"):
        own, right = (scene(text % x).simulate(at=[0.2, 3.0, 5.0], tolerance=1e-8, solver=solver, max_steps=2000)
                      for x in (law, "-2[N]*sign(b.v)"))
        assert own["b.s"] == pytest.approx(right["b.s"], abs=1e-7)
