"""Friction written as a coefficient of its rate, of which a length divides one term: -v (F/|v| + c)."""

from math import log

import numpy as np
import pytest

import lagrangia as lag

SOLVERS = ("auto", "erk5", "erk9", "pirk", "implicit", "taylor", "adams")
LAWS = ("-v*(2/abs(v) + 0.1)", "-(0.1 + 2/abs(v))*v", "-v*(0.2 + 4/sqrt(v^2))/2",
        "-2*v*((if b.s < 9[m] then 1/abs(v) else 0) + 0.05)",
        "-k*v", "-(v*(4/abs(v) + 0.2))/2", "-2*(v*(0.05 - (-1)/(3*abs(v))*3))", "-v*drag(v)",
        "-v*(0.1 + (if G > 0 then 2/abs(v) else 2/sqrt(v^2 + 1)))")


@pytest.mark.parametrize("solver", SOLVERS)
@pytest.mark.parametrize("law", LAWS)
def test_friction_in_a_coefficient_holds(law: str, solver: str) -> None:
    """v' = -2 - 0.1 v stops at t = 10 log(1.05) after 10 - 200 log(1.05) m, and stays. It went on to -112 m, and 67 m/s."""
    model = lag.loads(f"""
      function drag input Real v; output Real y; algorithm y := 2/abs(v) + 0.1; end drag;
      model Slider
        World world(gravity = {{0, 0}}); Block b(m = 1, base = world, v(start = 1));
        parameter Real G = 1; Real v = b.v; Real k = 2/abs(v) + 0.1;
        AppliedForce f(at = b.center, force = {{{law}, 0}});
      end Slider;""")
    run = model.simulate(at=[0.2, 2.0], solver=solver, tolerance=1e-10)
    assert run["b.s"] == pytest.approx([210 * (1 - np.exp(-0.02)) - 20 * 0.2, 10 - 200 * log(1.05)], abs=1e-8)
    assert run["der(b.s)"][1] == 0


def test_friction_in_a_coefficient_holds_in_the_plane() -> None:
    """Along a line, with half of the above for twice the mass."""
    run = lag.loads("""model Puck
      World world(gravity = {0, 0}); PointMass p(m = 2);
      AppliedForce f(at = p.center, force = -(4[N]/norm(p.center.v) + 0.2[N.s/m])*p.center.v);
    initial equation
      p.center.x = 0; p.center.y = 0; p.center.v[1] = 0.6; p.center.v[2] = 0.8;
    end Puck;""").simulate(at=[2.0], tolerance=1e-10)
    stop = 10 - 200 * log(1.05)
    assert [run["p.center.x"][0], run["p.center.y"][0]] == pytest.approx([0.6 * stop, 0.8 * stop], abs=1e-8)
    assert run["der(p.center.x)"][0] == 0
