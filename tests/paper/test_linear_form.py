"""`lag equations --form linear` where constraints hold, coordinates are prescribed and frames move: textbooks, and the numbers of
`lag linearize`, which are found by another derivation."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import sympy as sp

import lagrangia as lag
from helpers.symbolic_scenes import EXAMPLES, Derived
from lagrangia.command.cli import WRONG, main
from lagrangia.compile.pipeline import compile_energies
from lagrangia.paper.equations import derive
from lagrangia.paper.linear_matrices import Linear, linearize
from lagrangia.paper.sheet import parameter_values, start_of
from lagrangia.paper.symbolic import build_symbolic

Small = Callable[[str], tuple[Derived, Linear]]


def small_motion(path: Path) -> tuple[Derived, Linear]:
    kinematics, constraints = compile_energies(path)
    d = Derived(derive(build_symbolic(kinematics, constraints, is_small=True), 10**6))
    numbers = parameter_values(kinematics)
    values = {p.symbol: numbers[p.name] for p in d.equations.scene.parameters}
    values |= {g.symbol: float(g.value.subs(values)) for g in d.equations.scene.given if not g.value.has(d.equations.scene.t)}
    return d, linearize(d.equations, values, lambda: start_of({}, path))


@pytest.mark.parametrize(("text", "varies"), [
    ("Frame pivot = shift(world, {0, 0.02*cos(300*time)}); Revolute h(a = pivot);"
     "PointMass b(m = 1, center = shift(h.b, {0, -1}));", True),
    ("Frame pivot = shift(world, {0.02*cos(300*time), 0}); Revolute h(a = pivot);"
     "PointMass b(m = 1, center = shift(h.b, {0, -1}));", False),
    ("Revolute h(a = world); Bar b(m = 1, L = 1, a = h.b); AppliedForce F(at = b.b, force = {0, 2[N]*sin(3*time)});", True),
    ("Block b(m = 1, base = world); Spring s(k = 3, stretch = b.s);"
     "AppliedForce F(at = b.center, force = {2[N]*sin(3*time), 0});", False),
    ("World world(gravity = {0, 0}); Prismatic w(a = turn(world, 0.5*time)); PointMass b(m = 1, center = w.b);"
     "Spring s(k = 3, stretch = w.s);", False),
])
def test_coefficients_that_vary_are_told(text: str, varies: bool, small, tmp_path: Path, capsys) -> None:
    """A vertical vibration of the pivot stiffens the pendulum, a horizontal one drives it; a steady turn does neither."""
    assert small(text)[1].varies == varies
    assert main(["equations", str(tmp_path / "scene.lag"), "--form", "linear"]) == 0
    assert ("taken at a standstill" in capsys.readouterr().out) == varies


@pytest.fixture
def small(tmp_path: Path) -> Small:
    def read(text: str) -> tuple[Derived, Linear]:
        (tmp_path / "scene.lag").write_text(f"model Scene {text} end Scene;", encoding="utf-8")
        return small_motion(tmp_path / "scene.lag")

    return read


def is_same(found: object, wanted: object) -> bool:
    return bool(sp.simplify(sp.Matrix(found) - sp.Matrix(wanted)) == sp.zeros(*sp.Matrix(wanted).shape))


# ---------------------------------------------------------------- constraints


SWING = """parameter Length L = 1, d = 2; parameter Mass m = 2, M = 3;
    Revolute h1(a = world, phi(start = -80[deg])), h2(a = left.b, phi(start = 80[deg])),
             h3(a = shift(world, {d, 0}), phi(start = -80[deg])), h4(a = right.b, b = coupler.b);
    Bar left(m = m, L = L, a = h1.b), coupler(m = M, L = d, a = h2.b), right(m = m, L = L, a = h3.b);"""


def test_a_swing_on_two_bars(small: Small) -> None:
    """(2 m/3 + M) L^2 phi'' + (m + M) g L phi = 0, in the parameters' names; half of the seat hangs on the loop."""
    d, linear = small(SWING)
    m, M, L, l_d, g = (d[name] for name in ("m", "M", "L", "d", "world.gravity"))
    assert not linear.is_numeric
    assert linear.point == (-sp.pi / 2, sp.pi / 2, -sp.pi / 2)
    assert is_same([linear.multipliers], [[0, -M * g / 2]])
    assert is_same(linear.J, [[L, 0, -L], [l_d, l_d, 0]])
    r = linear.reduced
    assert r is not None
    inertias = {d["left.I"]: m * L**2 / 12, d["right.I"]: m * L**2 / 12}
    assert sp.simplify(r.M[0][0].subs(inertias) - (2 * m / 3 + M) * L**2) == 0
    assert sp.simplify(r.K[0][0] - (m + M) * g * L) == 0
    assert is_same([linear.load], [[0, 0, 0]])


def test_a_rod_gives_its_mass_stiffness(small: Small) -> None:
    """A point kept at a distance: all its stiffness is the multiplier's, m g/L."""
    _, linear = small("PointMass p(m = 2, center(x(start = 0.1), y(start = -0.6))); Link rod(L = 0.7, a = world, b = p.center);")
    assert linear.is_numeric
    assert [float(x) for x in linear.multipliers] == pytest.approx([2 * 9.81])
    r = linear.reduced
    assert r is not None
    assert float(r.K[0][0] / r.M[0][0]) == pytest.approx(9.81 / 0.7)


@pytest.mark.parametrize("name", ["four_bar", "crank_press", "parallelogram", "ellipse_trammel", "suspended_bar", "cart_pole",
                                  "spring_pendulum", pytest.param("andrews_squeezer", marks=pytest.mark.slow)])
def test_the_matrices_are_those_of_lag_linearize(name: str) -> None:
    """SymPy's derivatives, multipliers and reduction against CasADi's, at the same point in the same coordinates."""
    d, linear = small_motion(EXAMPLES / f"{name}.lag")
    other = lag.load(EXAMPLES / f"{name}.lag").linearize()
    scene = d.equations.scene
    numbers = parameter_values(compile_energies(EXAMPLES / f"{name}.lag")[0])
    values = {p.symbol: numbers[p.name] for p in scene.parameters}
    point = [float(x.subs(values)) for x in linear.point]
    assert point == pytest.approx([other.point[q] for q in scene.names], abs=1e-8)
    r = linear.reduced
    assert (r is None) == (not linear.J)
    if r is not None:
        assert [scene.names[k] for k in r.independent] == list(other.coordinates)
    system = r or linear
    for mine, theirs in ((system.M, other.M), (system.C, other.C), (system.K, other.K)):
        found = np.array([[float(x.subs(values)) for x in row] for row in mine])
        np.testing.assert_allclose(found, theirs, atol=1e-8 * max(np.abs(theirs).max(), 1e-300))


def test_a_blade_is_held_by_its_multiplier(small: Small) -> None:
    """A skate across the slope: held by the constraint on its rates; turning it lets gravity pull."""
    d, linear = small("World world(gravity = {1, 0}); Body skate(m = 70, I = 2, center(phi(start = 80[deg])));"
                      "equation dot(skate.center.v, rotate({0, 1}, skate.center.phi)) = 0;")
    m, g = d["skate.m"], d["world.gravity"]
    assert linear.point[2] == sp.pi / 2
    assert is_same(linear.J, [[-1, 0, 0]])
    assert is_same([linear.multipliers], [[-m * g]])
    assert is_same(linear.K, [[0, 0, 0], [0, 0, m * g], [0, 0, 0]])  # of the weight, what is along the blade
    assert linear.reduced is None


# ---------------------------------------------------------------- what is given


PIVOTS = {
    "Motion": "Prismatic slide(a = world); Motion drive(of = slide.s, to = 0.2*sin(3*time));"
              "Revolute h(a = slide.b, phi(start = -1));",
    "frame": "Frame road = shift(world, {0.2*sin(3*time), 0}); Revolute h(a = road, phi(start = -1));",
    "variable": "Length x = 0.2*sin(3*time); Frame road = shift(world, {x, 0}); Revolute h(a = road, phi(start = -1));",
    "about another place": "Frame road = shift(world, {0.7 + 0.2*sin(3*time), 0}); Revolute h(a = road, phi(start = -1));",
}


@pytest.mark.parametrize("way", PIVOTS)
def test_a_pendulum_on_a_moving_pivot(way: str, small: Small) -> None:
    """m L^2 phi'' + m g L phi = -m L x''."""
    d, linear = small(f"parameter Length L = 0.5; {PIVOTS[way]} PointMass p(m = 3, center = shift(h.b, {{L, 0}}));")
    m, L, g = (d[name] for name in ("p.m", "L", "world.gravity"))
    (given,) = d.equations.scene.given
    assert [A[0][0] for A in (linear.M, linear.K, linear.C)] == [m * L**2, m * g * L, 0]
    assert linear.load == (-m * L * given.acceleration,)
    assert given.value.diff(d.equations.scene.t, 2) == -sp.Rational(9, 5) * sp.sin(3 * d["t"])
    assert linear.resting == {given.symbol: sp.Rational(7, 10) if way == "about another place" else 0}


def test_a_pendulum_in_a_steadily_turning_frame(small: Small) -> None:
    """It keeps turning: phi'' + Omega^2 R/L phi = 0."""
    d, linear = small("parameter AngularVelocity Omega = 3; parameter Length R = 0.8, L = 0.2; World world(gravity = {0, 0});"
                      "Frame arm = shift(turn(world, Omega*time), {R, 0});"
                      "Revolute h(a = arm, phi(start = 0.3)); PointMass p(m = 1, center = shift(h.b, {L, 0}));")
    m, Omega, R, L = (d[name] for name in ("p.m", "Omega", "R", "L"))
    assert linear.point == (0,)
    assert [A[0][0] for A in (linear.M, linear.K)] == [m * L**2, m * Omega**2 * R * L]
    assert linear.load == (0,)


def test_a_car_on_a_road_with_a_damped_tyre(small: Small) -> None:
    """f = k s + c s'."""
    d, linear = small("""World world(gravity = {0, 0}); Block road(m = 1, base = world, along = {0, 1});
        Motion profile(of = road.s, to = 0.1*sin(1*time)); Block axle(m = 320, base = world, along = {0, 1});
        SpringDamper tyre(k = 5e5, c = 15020, stretch = axle.s - road.s);""")
    (given,) = d.equations.scene.given
    assert linear.load == (d["tyre.k"] * given.symbol + d["tyre.c"] * given.rate,)


def test_a_prescribed_crank_in_a_loop() -> None:
    """The press: rod and ram follow the crank, the table feels it through the workpiece."""
    d, linear = small_motion(EXAMPLES / "crank_press.lag")
    crank = d["O.phi"]
    r = linear.reduced
    assert r is not None
    assert [d.equations.scene.names[k] for k in r.independent] == ["table.s"]
    follow = dict(zip(d.equations.scene.names, r.follow, strict=True))
    assert float(follow["pin.phi"].coeff(crank)) == pytest.approx(-1)
    assert float(follow["ram.s"].coeff(crank)) == pytest.approx(-0.1)
    assert [float(r.load[0].coeff(crank)), float(r.K[0][0])] == pytest.approx([2000, 70000])


# ---------------------------------------------------------------- the page, and what is refused


def test_the_page(small: Small, tmp_path: Path, capsys) -> None:
    small(SWING)
    assert main(["equations", str(tmp_path / "scene.lag"), "--form", "linear"]) == 0
    said = capsys.readouterr().out
    assert "λ_2,0 = − ½ M g" in said
    assert "𝐌 Δ𝐪'' + 𝐊 Δ𝐪 + 𝐉ᵀ Δ𝛌 = 0\n  𝐉 Δ𝐪 = 0" in said
    assert "Δφ_h3 = − Δφ_h2" in said and "without multipliers" in said
    for format in ("latex", "html"):
        assert main(["equations", str(tmp_path / "scene.lag"), "--form", "linear", "--format", format]) == 0


def test_about_a_point_of_a_loop(small: Small, tmp_path: Path, capsys) -> None:
    """Coordinates that are not given follow from the constraints."""
    small(SWING)
    assert main(["equations", str(tmp_path / "scene.lag"), "--form", "linear", "--about", "h1.phi=90[deg]"]) == 0
    said = capsys.readouterr().out
    assert "φ_h1,0 = 0.5 π" in said and "4.33333 Δφ_h2'' − 49.05 Δφ_h2 = 0" in said
    for about, code in (("O.phi=9,C.phi=9,A.phi=9", "L0713"), ("O.phi=60[deg]", "L0912")):
        assert main(["equations", str(EXAMPLES / "four_bar.lag"), "--form", "linear", "--about", about]) == WRONG
        assert f"error[{code}]" in capsys.readouterr().err


NO_REST = {
    "a speed": ("L0713", "World world(gravity = {0, 0}); Block b(m = 1, base = world); equation b.v = 2;"),
    "time in a constraint": ("L0912", "PointMass p(m = 1, center(y(start = -1))); Link rod(L = 1, a = world, b = p.center);"
                             "PointMass o(m = 1, center(x(start = 1)));"
                             "equation distance(world, o.center) = 1 + 0.1*sin(3*time);"),
    "time and a coordinate": ("L0912", "Prismatic s(a = world); Block b(m = 1, base = shift(s.b, {s.s*sin(3*time), 0}));"
                              "PointMass p(m = 1, center = s.b);"),
    "falling": ("L0713", "PointMass p(m = 1, center(x(start = 1)));"),
    "no start": ("L0606", "PointMass p(m = 1, center(x(start = 1, fixed = true), y(start = 1, fixed = true)));"
                 "Link rod(L = 1, a = world, b = p.center);"),
}


@pytest.mark.parametrize("what", NO_REST)
def test_what_has_no_linear_form(what: str, tmp_path: Path, capsys) -> None:
    code, text = NO_REST[what]
    (tmp_path / "scene.lag").write_text(f"model Scene {text} end Scene;", encoding="utf-8")
    assert main(["equations", str(tmp_path / "scene.lag"), "--form", "linear"]) == WRONG
    said = capsys.readouterr().err
    assert f"error[{code}]" in said and "Traceback" not in said
