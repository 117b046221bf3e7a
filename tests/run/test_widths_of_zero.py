"""Widths that smooth friction, v/sqrt(v^2 + eps^2), where they are 0: what is left is dry friction, or a division by zero."""

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag

SOLVERS = ("auto", "erk5", "erk9", "pirk", "implicit", "taylor", "adams")
ROOTS = ("-2*v/sqrt(v^2 + eps^2)", "-2*v/norm({v, eps})", "-2*v/(v^2 + eps^2)^0.5", "-2*v/(3*sqrt(v^2/9 + eps))",
         "-2*v/(abs(v) + eps)", "-2*v/max(abs(v), eps)", "-2*v/(if eps == 0 then abs(v) else sqrt(v^2 + eps^2))",
         "-2*smooth(v, eps)", "-2/sqrt(v^2 + eps^2)*v", "-2*v*(1/norm({v, eps}))", "-2*v*(v^2 + eps^2)^(-0.5)",
         "-v*(if b.s < 9 then 2/sqrt(v^2 + eps^2) else 0)", "-v*(1/sqrt(v^2 + eps^2) + 1/(abs(v) + eps))")
QUOTIENTS = ("tanh(v/eps)", "atan(v/eps)", "min(max(v/eps, -1), 1)", "(v/eps)/sqrt(1 + (v/eps)^2)", "1 - exp(-abs(v)/eps)")


def block(force: str, eps: float = 0.0, start: str = "1") -> lag.Model:
    return lag.loads(f"""
      function smooth input Real v; input Real eps; output Real y; algorithm y := v/sqrt(v^2 + eps^2); end smooth;
      model Slider
        World world(gravity = {{0, 0}}); Block b(m = 1, base = world, v(start = {start}));
        parameter Real eps = {eps}; parameter Real push = 0; Real v = b.v;
        AppliedForce f(at = b.center, force = {{{force} + push, 0}});
      end Slider;""")


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("law", ROOTS)
def test_a_root_without_a_width_is_dry_friction(law: str, solver: str) -> None:
    """v = 1 - 2 t stops at s = 0.25 and stays, as F sign(v) would; less than 2 N moves nothing then."""
    for push in (0.0, 1.0):
        run = block(law).simulate(at=[0.2, 4.0], solver=solver, tolerance=1e-9, parameters={"push": push}, max_steps=5_000)
        stops = 1 / (2 - push)
        assert run["b.s"] == pytest.approx([0.2 - (2 - push) * 0.02, stops / 2], abs=1e-8)
        assert run["der(b.s)"][1] == 0


def test_a_width_that_is_declared_0_may_be_given() -> None:
    """Beside SciPy; the rate decays and is not held."""
    for eps in (1.0, 1e-2):
        run = block(ROOTS[0]).simulate(at=[0.3, 2.0], tolerance=1e-10, parameters={"eps": eps, "push": 1.0})
        right = solve_ivp(lambda t, y, w=eps: [y[1], 1 - 2 * y[1] / np.hypot(y[1], w)], (0, 2), [0, 1], "Radau", [0.3, 2.0],
                          rtol=1e-11, atol=1e-13)
        assert run["b.s"] == pytest.approx(right.y[0], abs=1e-8)
        assert run["der(b.s)"] == pytest.approx(right.y[1], abs=1e-8)


def test_a_root_without_a_width_in_the_plane() -> None:
    """From above, |v| = 1 - 2.5 t along a line; it stops after 0.2 m."""
    run = lag.loads("""model Puck
      World world(gravity = {0, 0}); PointMass p(m = 2); parameter Velocity w = 0;
      AppliedForce f(at = p.center, force = -5*p.center.v/sqrt(p.center.v[1]^2 + p.center.v[2]^2 + w^2));
    initial equation
      p.center.x = 0; p.center.y = 0; p.center.v[1] = 0.6; p.center.v[2] = 0.8;
    end Puck;""").simulate(at=[0.2, 3.0], tolerance=1e-10)
    assert np.hypot(run["p.center.x"], run["p.center.y"]) == pytest.approx([0.15, 0.2], abs=1e-9)
    assert run["der(p.center.x)"][1] == 0


@pytest.mark.parametrize("law", ROOTS[:6])
def test_a_width_that_became_0_is_named(law: str) -> None:
    """What is smooth as declared has no conditions by which friction holds."""
    model = block(law, 0.5)
    model.simulate(parameters={"eps": 1e-2}, stop=0.1)
    with pytest.raises(lag.LagError, match=r"(?s)L0605.*where it jumps, with eps = 0.*eps = 0\.5;.*\^.*declare eps = 0"):
        model.simulate(parameters={"eps": 0}, stop=1)


@pytest.mark.parametrize("law", QUOTIENTS)
def test_a_division_by_a_parameter_that_is_0_is_named(law: str) -> None:
    for declared in (0.0, 0.5):
        model = block(f"-2*({law})", declared)
        with pytest.raises(lag.LagError, match=r"(?s)L0605.*division by zero with eps = 0.*\^"):
            model.simulate(parameters={"eps": 0}, stop=1)
        model.simulate(parameters={"eps": 0.5}, stop=0.1)


def test_a_division_by_0_that_no_force_asks_for_is_none() -> None:
    """By a choice of parameters; a series of springs one of which is none; a drag that only bends."""
    run = block("if eps > 0 then -2*tanh(v/eps) else -2*sign(v)").simulate(at=[2.0])
    assert run["b.s"] == pytest.approx([0.25], abs=1e-9)
    assert block("-1/(1/eps + 1/4)*b.s").simulate(at=[2.0])["b.s"] == pytest.approx([2.0])
    right = solve_ivp(lambda t, y: [y[1], -2 * y[1] * abs(y[1]) - 3 * y[0]], (0, 2), [0, 1], "DOP853", [2.0], rtol=1e-11,
                      atol=1e-13)
    run = block("-2*v*sqrt(v^2 + eps^2) - 3*b.s").simulate(at=[2.0], tolerance=1e-10)
    assert run["b.s"] == pytest.approx(right.y[0], abs=1e-8)


def test_a_root_beside_places_has_no_width() -> None:
    """It vanishes where v and s do, and is no friction elsewhere: beside SciPy."""
    model = block("-1[N]*v/sqrt(v^2 + b.s^2/1[s2] + eps^2) - 1[N/m]*b.s", 0.1)
    run = model.simulate(at=[0.7, 3.0], tolerance=1e-10, parameters={"eps": 0})
    right = solve_ivp(lambda t, y: [y[1], -y[1] / np.hypot(*y) - y[0]], (0, 3), [0, 1], "DOP853", [0.7, 3.0], rtol=1e-12,
                      atol=1e-14)
    assert run["b.s"] == pytest.approx(right.y[0], abs=1e-8)


def test_rows_of_sweeps_fail_where_a_width_is_0() -> None:
    found = block(ROOTS[0], 0.5).simulate_many(parameters={"eps": [0.0, 0.1]}, stop=1)
    assert "where it jumps, with eps = 0" in str(found.failures[0])
    assert found["final(b.s)"][1] == pytest.approx(0.2587422890, abs=1e-6)
