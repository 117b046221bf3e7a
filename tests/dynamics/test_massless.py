"""Places that move no mass, between springs, dampers and gears: they follow from the balance of forces."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

import lagrangia as lag
from helpers.reference import Array

Write = Callable[[str], lag.Model]
TIMES = np.linspace(0, 2, 5)


def reference(slopes: Callable[[float, Array], list[float]], start: list[float]) -> Array:
    return np.asarray(solve_ivp(slopes, (0, 2), start, method="DOP853", rtol=1e-12, atol=1e-13, t_eval=TIMES).y)


def run(model: lag.Model) -> lag.Trajectory:
    return model.simulate(stop=2, interval=0.5, tolerance=1e-10)


def assert_closed(found: lag.Trajectory) -> None:
    energy = found.energy
    assert np.abs(energy.residual).max() < 1e-9 * np.abs(energy.kinetic + energy.potential).max()


def test_springs_in_a_row_are_one_spring(scene: Write) -> None:
    found = run(scene("""model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic a(a = world), b(a = world);
      Spring k1(k = 100, stretch = m.s - a.s), k2(k = 50, stretch = a.s - b.s), k3(k = 30, stretch = b.s); end M;"""))
    k = 1 / (1 / 100 + 1 / 50 + 1 / 30)
    np.testing.assert_allclose(found["m.s"], 0.1 * np.cos(np.sqrt(k) * TIMES), atol=1e-12)
    np.testing.assert_allclose(30 * found["b.s"], k * found["m.s"], atol=1e-12)
    assert_closed(found)


def test_shafts_that_gears_without_inertia_join(scene: Write) -> None:
    model = scene("""model M World world(gravity = {0, 0});
      Revolute A(a = world), gA(a = world), gB(a = shift(world, {0.3, 0})), B(a = shift(world, {0.3, 0}));
      Body flyA(m = 0, I = 4, center = A.b), flyB(m = 0, I = 0.5, center = B.b);
      TorsionSpring sA(a = A.b, b = gA.b, k = 3000), sB(a = gB.b, b = B.b, k = 800);
      Gear mesh(a = gA.b, b = gB.b, carrier = world, r_a = 0.2, r_b = 0.1); end M;""")
    frequencies = sorted(model.modes().frequencies)
    assert frequencies[0] == pytest.approx(0, abs=1e-6)
    assert frequencies[1] == pytest.approx(5.423636, rel=1e-6)


@pytest.mark.parametrize(("beside", "k0"), [("", 0.0), ("Spring k0(k = 20, stretch = m.s);", 20.0)])
def test_a_spring_and_a_damper_in_a_row(scene: Write, beside: str, k0: float) -> None:
    """Maxwell's element, and that of the standard linear solid."""
    found = run(scene(f"""model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic node(a = world); {beside}
      Spring k(k = 100, stretch = m.s - node.s); Damper c(c = 5, rate = node.v); end M;"""))
    s, _, node = reference(lambda t, y: [y[1], -k0 * y[0] - 100 * (y[0] - y[2]), 20 * (y[0] - y[2])], [0.1, 0, 0])
    np.testing.assert_allclose(found["m.s"], s, atol=1e-9)
    np.testing.assert_allclose(found["node.s"], node, atol=1e-9)
    assert_closed(found)


def test_a_damper_between_two_places_without_mass(scene: Write) -> None:
    """No rate is in the sum of both balances: 100 (m.s - a.s) = 50 b.s."""
    found = run(scene("""model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic a(a = world), b(a = world);
      Spring k1(k = 100, stretch = m.s - a.s), k2(k = 50, stretch = b.s); Damper c(c = 4, rate = a.v - b.v); end M;"""))
    np.testing.assert_allclose(found["b.s"], 2 * (found["m.s"] - found["a.s"]), atol=1e-12)
    s, _, a = reference(lambda t, y: [y[1], -100 * (y[0] - y[2]), (2 * y[1] + 25 * (y[0] - y[2])) / 3], [0.1, 0, found["a.s"][0]])
    np.testing.assert_allclose(found["m.s"], s, atol=1e-9)
    np.testing.assert_allclose(found["a.s"], a, atol=1e-9)


def test_a_spring_that_is_not_linear_in_a_row(scene: Write) -> None:
    found = run(scene("""model M Block m(m = 1, base = world, s(start = 0.5)); Prismatic a(a = world);
      Spring k(k = 100, stretch = m.s - a.s); GeneralSpring g(V = 20*a.s^2 + 500*a.s^4); end M;"""))

    def place(s: float) -> float:
        return float(brentq(lambda z: 40 * z + 2000 * z**3 - 100 * (s - z), -5, 5, xtol=1e-15))

    s, _ = reference(lambda t, y: [y[1], -100 * (y[0] - place(y[0]))], [0.5, 0])
    np.testing.assert_allclose(found["m.s"], s, atol=1e-9)
    np.testing.assert_allclose(found["a.s"], [place(x) for x in s], atol=1e-9)


KNOT = """model M PointMass m(m = 1), knot({} = 0);
  Spring a(a = shift(world, {{0, 0.5}}), b = knot.center, k = 100, s_rel0 = 0.1);
  Spring b(a = shift(world, {{1, 0.5}}), b = knot.center, k = 80, s_rel0 = 0.2);
  Spring c(a = knot.center, b = m.center, k = 50, s_rel0 = 0.3);
initial equation m.center.x = 0.5; m.center.y = -1; end M;"""


def test_a_knot_of_springs_in_the_plane(scene: Write) -> None:
    """As with a mass on it that is next to nothing; a mass that is given later is one."""
    model = scene(KNOT.format("m"))
    found = run(model)
    place, pulls = found["knot.center.r"], np.zeros((TIMES.size, 2))
    for end, k, length in (([0, 0.5], 100, 0.1), ([1, 0.5], 80, 0.2), (found["m.center.r"], 50, 0.3)):
        way = np.asarray(end) - place
        size = np.linalg.norm(way, axis=1)[:, None]
        pulls += k * (size - length) * way / size
    np.testing.assert_allclose(pulls, 0, atol=1e-9)
    assert_closed(found)
    light = model.simulate(stop=0.1, interval=0.1, tolerance=1e-6, solver="implicit", parameters={"knot.m": 1e-4})
    assert light["m.center.y"][-1] == pytest.approx(model.simulate(stop=0.1, interval=0.1)["m.center.y"][-1], abs=5e-3)


def test_an_fmu_of_a_place_whose_mass_is_a_parameter(scene: Write, tmp_path: Path) -> None:
    with pytest.raises(lag.LagError, match=r"L0704.*\n.*write `final`"):
        scene(KNOT.format("m")).export_fmu(tmp_path)


def test_equations_have_the_balance_in_them(scene: Write) -> None:
    pages = scene("""model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic node(a = world);
      Spring k(k = 100, stretch = m.s - node.s); Damper c(c = 5, rate = node.v); end M;""")
    assert "c s_node' − k s_m + k s_node = 0" in pages.equations()
    assert "/0" not in pages.equations(form="first-order")


@pytest.mark.parametrize(("scene_of", "said"), [
    ("input Force u; Spring k2(k = 50, stretch = a.s); AppliedForce f(at = a.b, force = {u, 0});", "an input acts on it"),
    ("Spring k2(k = 50, stretch = a.s); AppliedForce f(at = a.b, force = {if time > 1 then 1 else 0, 0});", "acts on it jumps"),
    ("Spring k2(k = 50, stretch = a.s); Stop stop(gap = a.s + 0.01);", "a contact or an event acts on it"),
    ("DryFriction rub(F = 1, rate = a.v);", "not linear in rates, as friction"),
    ("Spring k2(k = -200, stretch = a.s);", "a maximum of the potential"),
])
def test_what_is_not_known_of_such_places(scene: Write, scene_of: str, said: str) -> None:
    with pytest.raises(lag.LagError, match=f"L0504.*'a.s' moves no mass.*{said}"):
        run(scene(f"""model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic a(a = world);
          Spring k1(k = 100, stretch = m.s - a.s); {scene_of} end M;"""))


def test_a_place_that_nothing_holds(scene: Write) -> None:
    with pytest.raises(lag.LagError, match=r"L0504.*'a.s' moves no mass, and no spring or damper says where it is"):
        run(scene("""model M Block m(m = 1, base = world, s(start = 0.1)); Prismatic a(a = world), b(a = world);
          Spring k(k = 100, stretch = b.s - a.s); end M;"""))


def test_a_place_that_a_constraint_holds_in_part(scene: Write) -> None:
    with pytest.raises(lag.LagError, match=r"L0504.*'k.center.x' moves no mass, and constraints do not say all of where it is"):
        run(scene("""model M PointMass m(m = 1), k(m = 0); Link l(a = world, b = k.center, L = 0.5);
          Spring c(a = k.center, b = m.center, k = 50, s_rel0 = 0.3);
        initial equation m.center.x = 0.5; m.center.y = -1; end M;"""))


@pytest.mark.parametrize("spring", ["Spring k1(k = 100, ", "DuffingSpring k1(k = 100, k3 = 1000, "])
@pytest.mark.parametrize("order", [("n1", "n2"), ("n2", "n1")])
def test_a_place_that_a_damper_holds_begins_where_it_is(scene: Write, spring: str, order: tuple[str, str]) -> None:
    """Springs in a row behind a damper: the place between the springs follows; it had been the damped one, by -0.2 m, where that
    was declared last, and untold where a spring is not linear."""
    run = scene(f"""model Row
      Block m(m = 1, base = world, s(start = 0.1));
      Prismatic {order[0]}(a = world), {order[1]}(a = world);
      {spring}stretch = m.s - n1.s);
      Spring k2(k = 50, stretch = n1.s - n2.s);
      Damper c(c = 5, rate = n2.v);
    end Row;""").simulate(at=[0.0])
    n1 = run["n1.s"][0]
    assert run["n2.s"][0] == 0.0 and run["m.s"][0] == 0.1
    assert 100 * (0.1 - n1) + ("k3" in spring) * 1000 * (0.1 - n1) ** 3 == pytest.approx(50 * n1, abs=1e-9)


KNOT_ON_A_LINE = """model M PointMass m(m = 1), q(m = 2), k(m = 0%s); Damper d(a = world, b = k.center, c = 20);
  Spring a(a = q.center, b = k.center, k = 100), c(a = k.center, b = m.center, k = 70);
initial equation m.center.x = 1; m.center.y = 0.3; q.center.x = -1; q.center.y = 0.2; end M;"""


@pytest.mark.parametrize(("at", "solver"), [("", "auto"), (", center(x(start = -0.1), y(start = 0.1))", "auto"),
                                            (", center(x(start = -0.1), y(start = 0.1))", "implicit")])
def test_a_damper_whose_line_turns(at: str, solver: str, scene: Write) -> None:
    """The springs pull at C, the mean of their ends, so that the knot is on the line from the damper to C; along it 20 rho' =
    170 (|C| - rho). It begins in the damper's other end where nobody says more: masses have no speed by that."""
    found = scene(KNOT_ON_A_LINE % at).simulate(stop=2, interval=0.5, tolerance=1e-9, solver=solver)
    begins = found["k.center.r"][0]

    def slopes(t: float, y: Array) -> list[float]:
        m, q = y[:2], y[2:4]
        mean = (100 * q + 70 * m) / 170
        size = np.linalg.norm(mean)
        knot = y[8] * mean / size
        return [*y[4:8], *(70 * (knot - m) + [0, -9.81]), *(50 * (knot - q) + [0, -9.81]), 8.5 * (size - y[8])]

    right = reference(slopes, [1, 0.3, -1, 0.2, 0, 0, 0, 0, float(np.linalg.norm(begins))])
    np.testing.assert_allclose(found["m.center.r"], right[:2].T, atol=2e-7)
    np.testing.assert_allclose(np.linalg.norm(found["k.center.r"], axis=1), right[8], atol=2e-7)
    assert_closed(found)


def test_two_dampers_whose_lines_turn(scene: Write) -> None:
    """As with masses that are next to nothing, which were 1.3e-4, then 1.1e-5 off for 1e-4 and 1e-5 kg."""
    found = scene("""model M PointMass m(m = 1), k(m = 0), l(m = 0); Damper d(a = shift(world, {0.3, 2}), b = k.center, c = 20);
      Spring a(a = shift(world, {-1, 0}), b = k.center, k = 100), b(a = k.center, b = l.center, k = 80);
      Spring e(a = l.center, b = m.center, k = 60); Damper d2(a = shift(world, {2, 0.3}), b = l.center, c = 10);
      initial equation m.center.x = 0.1; m.center.y = -1.2; end M;""").simulate(at=[2.0], tolerance=1e-9)
    np.testing.assert_allclose(found["m.center.r"][-1], [-1.17093, -0.13135], atol=1e-5)


def test_pages_show_both_balances_where_the_line_turns(scene: Write) -> None:
    pages = scene(KNOT_ON_A_LINE % "").equations()
    assert "+ (k_a + k_c) x_k = 0" in pages and "+ (k_a + k_c) y_k = 0" in pages


def test_what_turns_without_mass_beside_places_without_mass(scene: Write) -> None:
    """Springs say where it is, and nothing how it is turned: the check passed, and no acceleration was finite."""
    with pytest.raises(lag.LagError, match=r"L0504.*'n.phi' moves no mass"):
        scene("""model M Planar n(a = world, x(start = 0.3)); PointMass m(m = 1); Spring a(a = n.b, b = world, k = 100);
          Spring c(a = n.b, b = m.center, k = 70); initial equation m.center.x = 2; end M;""")
