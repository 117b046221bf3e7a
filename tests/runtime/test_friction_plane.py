"""Dry friction in the plane, seen from above: its force has no direction at rest, and holds in any."""

from collections.abc import Callable

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
SOLVERS = ("auto", "erk", "erk5", "implicit", "adams", "taylor")


def puck(law: str, more: str = "", u: float = 0.0, v: float = 0.0) -> str:
    return f"""model Puck
      World world(gravity = {{0, 0}}); PointMass p(m = 2); {law} {more}
    initial equation
      p.center.x = 0; p.center.y = 0; p.center.v[1] = {u}; p.center.v[2] = {v};
    end Puck;"""


COMPONENT = "SlidingFriction f(a = world, b = p.center, mu = 0.5, normal = 10);"
EXPRESSION = "AppliedForce f(at = p.center, force = -5*p.center.v/norm(p.center.v));"


def load(x: str, y: str) -> str:
    return f"AppliedForce q(at = p.center, force = {{{x}, {y}}});"


def sliding(F: Callable[[float], tuple[float, float]], begin: list[float], span: tuple[float, float]) -> np.ndarray:
    """Where it is at the end, if it never stops."""
    def slope(t: float, y: np.ndarray) -> list[float]:
        speed, (x, z) = np.hypot(y[2], y[3]), F(t)
        return [y[2], y[3], (x - 5 * y[2] / speed) / 2, (z - 5 * y[3] / speed) / 2]

    return solve_ivp(slope, span, begin, method="DOP853", rtol=1e-12, atol=1e-15, max_step=0.02).y[:2, -1]


def turning_back(t: float, force: float, speed: float) -> float:
    """On a line, against a force of more than 5 N."""
    stop = 2 * speed / (force + 5)
    return speed * stop / 2 - (force - 5) / 4 * (t - stop) ** 2


@pytest.mark.parametrize("law", [COMPONENT, EXPRESSION], ids=["component", "expression"])
@pytest.mark.parametrize("solver", SOLVERS)
def test_a_puck_stops_and_stays(scene: Write, law: str, solver: str) -> None:
    """v^2/(2 F/m) on, in its direction."""
    model = scene(puck(law, u=1, v=0.5))
    for tolerance in (1e-5, 1e-10):
        run = model.simulate(at=[0.4, 1.0, 1e4], tolerance=tolerance, solver=solver)
        way = np.array([0.4 * np.sqrt(1.25) - 1.25 * 0.16, 0.25, 0.25])
        np.testing.assert_allclose(run["p.center.x"], way * 2 / np.sqrt(5), rtol=0, atol=1e-11)
        np.testing.assert_allclose(run["p.center.y"], way / np.sqrt(5), rtol=0, atol=1e-11)
        assert run.statistics.rhs_evaluations < 2000
        assert run.statistics.energy_residual < 1e-9


@pytest.mark.parametrize("law", [COMPONENT, EXPRESSION], ids=["component", "expression"])
def test_a_puck_is_pushed_aside(scene: Write, law: str) -> None:
    model = scene(puck(law, load("6*cos(1[rad/s]*time)", "6*sin(1[rad/s]*time)"), u=1))
    wanted = sliding(lambda t: (6 * np.cos(t), 6 * np.sin(t)), [0, 0, 1, 0], (0, 3))
    for solver in ("auto", "implicit"):
        run = model.simulate(at=[3.0], tolerance=1e-9, solver=solver)
        np.testing.assert_allclose([run["p.center.x"][-1], run["p.center.y"][-1]], wanted, rtol=0, atol=1e-8)


def test_a_puck_turns_back(scene: Write) -> None:
    """It passes rest, where friction turns round with it."""
    model = scene(puck(COMPONENT, load("-8", "-4"), u=1, v=0.5))
    along = turning_back(2, np.sqrt(80), np.sqrt(1.25))
    for solver in SOLVERS:
        run = model.simulate(at=[2.0], tolerance=1e-9, solver=solver)
        np.testing.assert_allclose([run["p.center.x"][-1], run["p.center.y"][-1]], [along * 2 / np.sqrt(5), along / np.sqrt(5)],
                                   rtol=0, atol=2e-9)


@pytest.mark.parametrize("law", [COMPONENT, EXPRESSION], ids=["component", "expression"])
def test_a_puck_is_held_in_any_direction(scene: Write, law: str) -> None:
    """By less than 5 N: components of up to 4.9 N each, not both, would be held by two brakes."""
    run = scene(puck(law, load("4.9*sin(1[rad/s]*time)", "4.9*cos(1[rad/s]*time)"))).simulate(stop=20, tolerance=1e-8)
    assert max(np.abs(run["p.center.x"]).max(), np.abs(run["p.center.y"]).max()) < 1e-10
    assert run.statistics.rhs_evaluations < 1000


@pytest.mark.parametrize(("static", "torn"), [(0.5, 1.0), (0.7, 1.4)])
def test_a_puck_is_torn_off(scene: Write, static: float, torn: float) -> None:
    """By a load of (4 t, 3 t): 5 t is more than mu_static 10 N, then (5 t - 5)/2 accelerates it."""
    law = COMPONENT.replace("mu = 0.5", f"mu = 0.5, mu_static = {static}")
    model, since = scene(puck(law, load("4[N/s]*time", "3[N/s]*time"))), 2 - torn
    way = 2.5 * (since**3 / 6 + (torn - 1) * since**2 / 2)
    for solver in ("auto", "implicit"):
        run = model.simulate(at=[torn - 1e-3, 2.0], tolerance=1e-9, solver=solver)
        np.testing.assert_allclose(run["p.center.x"], [0, 0.8 * way], rtol=0, atol=1e-7)
        np.testing.assert_allclose(run["p.center.y"], [0, 0.6 * way], rtol=0, atol=1e-7)


def test_a_puck_on_a_turntable(scene: Write) -> None:
    """It goes along with it while mu g is more than w^2 r, and takes its momentum."""
    model = scene("""model Table
      World world(gravity = {0, 0}); Revolute t(a = world, w(start = 2)); Disc d(m = 10, r = 1, center = t.b);
      PointMass p(m = 1); SlidingFriction f(a = t.b, b = p.center, mu = 0.5, normal = 10);
    initial equation
      p.center.x = 0.3; p.center.y = 0; p.center.v[1] = 0; p.center.v[2] = 0.6;
    end Table;""")
    run = model.simulate(at=[3.0], tolerance=1e-9)
    np.testing.assert_allclose(run["t.phi"], 6, rtol=1e-9)
    np.testing.assert_allclose([run["p.center.x"][-1], run["p.center.y"][-1]], [0.3 * np.cos(6), 0.3 * np.sin(6)], atol=1e-8)


@pytest.mark.parametrize("solver", ["auto", "erk", "implicit"])
def test_a_dissipation_of_a_speed_is_dry_friction_too(solver: str, scene: Callable[[str], lag.Model]) -> None:
    """D = F |v| written by hand: it stops at v0^2/(2 F/m), where it stays."""
    model = scene("model Puck\n  World world(gravity = {0, 0});\n  PointMass p(m = 2);\n"
                  "  GeneralDamper d(D = 5*norm(p.center.v));\n"
                  "initial equation\n  p.center.x = 0; p.center.y = 0; der(p.center.x) = 2; der(p.center.y) = 1;\nend Puck;\n")
    run = model.simulate(at=[0, 0.4, 2, 100], stop=100, solver=solver, max_steps=5000)
    np.testing.assert_allclose(run["p.center.x"][2:], 2 / 5**0.5, atol=1e-9)
    np.testing.assert_allclose(run["p.center.y"][2:], 1 / 5**0.5, atol=1e-9)


@pytest.mark.parametrize(("rubbed", "is_narrow"), [
    ("Revolute h(a = world); Bar b(m = 1, L = 2, a = h.b); {f}(a = world, b = b.b, mu = 0.3, normal = 10);", True),
    ("Prismatic s(a = world, along = {{1, 2}}); PointMass p(m = 1, center = s.b);"
     "{f}(a = world, b = p.center, mu = 1, normal = 1);", True),
    ("PointMass p(m = 1); Link l(a = world, b = p.center, L = 1); {f}(a = world, b = p.center, mu = 1, normal = 1);", True),
    ("Revolute h(a = world); Bar b(m = 1, L = 2, a = h.b); Revolute e(a = b.b); Bar c(m = 1, L = 1, a = e.b);"
     "{f}(a = world, b = c.b, mu = 0.3, normal = 10);", False),
    ("Body p(m = 1, I = 1); {f}(a = world, b = p.center, mu = 0.3, normal = 10);", False),
], ids=["arm", "rail", "link", "two bars", "body"])
def test_a_slip_that_goes_one_way_only_is_pointed_at(rubbed: str, is_narrow: bool, scene: Write) -> None:
    told = "\n".join(scene(f"model M {rubbed.format(f='SlidingFriction f')} end M;").warnings)
    assert ("warning[L0608]: the slip of 'f' can only go one way" in told) is is_narrow, told
