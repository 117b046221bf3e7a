"""The equations of motion by SymPy: against textbooks by symbolic equality, and against CasADi's functions by numbers."""

from pathlib import Path
from typing import NoReturn

import numpy as np
import pytest
import sympy as sp
from sympy import cos, sin

import lagrangia as lag
from helpers.random_trees import random_tree
from helpers.symbolic_scenes import EXAMPLES, WRITTEN, Derived, derived, vanishes
from lagrangia.paper.equations import constants_of_motion
from lagrangia.paper.linear_matrices import linearize
from lagrangia.paper.sheet import parameter_values


@pytest.fixture
def written(tmp_path: Path):
    """The equations of a scene from its text."""

    def write(text: str) -> Derived:
        (tmp_path / "scene.lag").write_text(text, encoding="utf-8")
        return derived(tmp_path / "scene.lag")

    return write


def values(d: Derived, path: Path) -> dict[sp.Expr, float]:
    scene = d.equations.scene
    from lagrangia.compile.pipeline import compile_energies

    numbers = parameter_values(compile_energies(path)[0])
    return {p.symbol: numbers[p.name] for p in scene.parameters}


def no_start() -> NoReturn:
    raise AssertionError("closed forms need no start")


# ---------------------------------------------------------------- textbooks


def test_suspended_bar() -> None:
    """m x'' + (k1+k2) x + L/2 (k2-k1) sin theta = P and so on, as courses on vibration have it."""
    d = derived(EXAMPLES / "suspended_bar.lag")
    x, theta, v, w = d["guide.s"], d["tilt.phi"], d["der(guide.s)"], d["der(tilt.phi)"]
    m, L, a, k1, k2, c1, c2, inertia, P = (d[n] for n in ("m", "L", "a", "k1", "k2", "c1", "c2", "bar.I", "P.force"))
    f_x = -(c1 + c2) * v - (c2 - c1) * L / 2 * cos(theta) * w
    f_theta = -L / 2 * cos(theta) * (c2 - c1) * v - (L * cos(theta) / 2) ** 2 * (c1 + c2) * w
    assert vanishes(d.motion(0) - (m * d["der(der(guide.s))"] + (k1 + k2) * x + L / 2 * (k2 - k1) * sin(theta) - P - f_x))
    assert vanishes(d.motion(1) - (inertia * d["der(der(tilt.phi))"] + L / 2 * (k2 - k1) * x * cos(theta)
                                   + L**2 / 4 * (k1 + k2) * sin(theta) * cos(theta) - P * (a - L / 2) * cos(theta) - f_theta))
    assert vanishes(d.equations.dD_dv[0] + f_x)
    assert vanishes(d.equations.dD_dv[1] + f_theta)
    (load,) = d.equations.scene.given
    assert load.value == 50 * sin(3 * d["t"])
    assert constants_of_motion(d.equations) == ()


def test_suspended_bar_in_small_motion() -> None:
    d = derived(EXAMPLES / "suspended_bar.lag")
    L, a, k1, k2, c1, c2, P = (d[n] for n in ("L", "a", "k1", "k2", "c1", "c2", "P.force"))
    linear = linearize(d.equations, values(d, EXAMPLES / "suspended_bar.lag"), no_start)
    assert linear.point == (0, 0)
    assert sp.Matrix(linear.M) == sp.diag(d["m"], d["bar.I"])
    for found, one, two in ((linear.K, k1, k2), (linear.C, c1, c2)):
        wanted = sp.Matrix([[one + two, L * (two - one) / 2], [L * (two - one) / 2, L**2 * (one + two) / 4]])
        assert sp.simplify(sp.Matrix(found) - wanted) == sp.zeros(2)
    assert sp.simplify(sp.Matrix(linear.load) - sp.Matrix([P, P * (a - L / 2)])) == sp.zeros(2, 1)


def test_disc_and_block() -> None:
    d = derived(EXAMPLES / "disc_and_block.lag")
    x, theta = d["block.s"], d["axle.phi"]
    m, inertia, k1, k2, r, moment = (d[n] for n in ("m", "I", "k1", "k2", "r", "drive.torque"))
    assert vanishes(d.motion(0) - (m * d["der(der(block.s))"] + (k1 + k2) * x - k2 * r * theta))
    assert vanishes(d.motion(1) - (inertia * d["der(der(axle.phi))"] - k2 * r * x + k2 * r**2 * theta - moment))
    linear = linearize(d.equations, values(d, EXAMPLES / "disc_and_block.lag"), no_start)
    assert sp.Matrix(linear.M) == sp.diag(m, inertia)
    assert sp.Matrix(linear.K) == sp.Matrix([[k1 + k2, -k2 * r], [-k2 * r, k2 * r**2]])
    assert linear.load == (0, moment)


def test_double_pendulum() -> None:
    """In absolute angles, from the horizontal (two uniform bars); our second coordinate is the bend of the elbow."""
    d = derived(EXAMPLES / "double_pendulum.lag")
    a, bend = d["shoulder.phi"], d["elbow.phi"]
    va, vb = d["der(shoulder.phi)"], d["der(shoulder.phi)"] + d["der(elbow.phi)"]
    wa, wb = d["der(der(shoulder.phi))"], d["der(der(shoulder.phi))"] + d["der(der(elbow.phi))"]
    m1, m2, l1, l2, g = (d[n] for n in ("upper.m", "lower.m", "upper.L", "lower.L", "world.gravity"))
    inertia = {d["upper.I"]: m1 * l1**2 / 12, d["lower.I"]: m2 * l2**2 / 12}
    b = a + bend
    first = ((m1 / 3 + m2) * l1**2 * wa + m2 * l1 * l2 / 2 * (wb * cos(a - b) + vb**2 * sin(a - b))
             + (m1 / 2 + m2) * g * l1 * cos(a))
    second = m2 * l2**2 / 3 * wb + m2 * l1 * l2 / 2 * (wa * cos(a - b) - va**2 * sin(a - b)) + m2 * g * l2 / 2 * cos(b)
    assert vanishes(d.motion(0).subs(inertia) - (first + second))  # the shoulder carries both
    assert vanishes(d.motion(1).subs(inertia) - second)


def test_cart_pole() -> None:
    d = derived(EXAMPLES / "cart_pole.lag")
    x, phi, v, w = d["cart.s"], d["hinge.phi"], d["der(cart.s)"], d["der(hinge.phi)"]
    M, m, L, inertia, g = (d[n] for n in ("M", "m", "L", "pole.I", "world.gravity"))
    force = d["ks"] * x + d["cs"] * v - d["kp"] * phi - d["cp"] * w
    a, alpha = d["der(der(cart.s))"], d["der(der(hinge.phi))"]
    assert vanishes(d.motion(0) - ((M + m) * a - m * L / 2 * (alpha * cos(phi) - w**2 * sin(phi)) - force))
    assert vanishes(d.motion(1) - ((inertia + m * L**2 / 4) * alpha - m * L / 2 * a * cos(phi) - m * g * L / 2 * sin(phi)))


def test_spring_pendulum() -> None:
    d = derived(EXAMPLES / "spring_pendulum.lag")
    x, y, m, L, k, g = (d[n] for n in ("bob.center.x", "bob.center.y", "m", "L", "k", "world.gravity"))
    pull = k * (1 - L / sp.sqrt(x**2 + y**2))
    assert vanishes(d.motion(0) - (m * d["der(der(bob.center.x))"] + pull * x))
    assert vanishes(d.motion(1) - (m * d["der(der(bob.center.y))"] + pull * y + m * g))


def test_rolling_disc_on_an_incline() -> None:
    """(I + m r^2) phi'' + k r^2 phi = -m g r sin(slope), s = -r phi."""
    d = derived(EXAMPLES / "incline_disc.lag")
    phi, m, r, slope, g, k = (d[n] for n in ("track.phi", "m", "r", "slope", "world.gravity", "spring.k"))
    wanted = 3 * m * r**2 / 2 * d["der(der(track.phi))"] + k * r**2 * phi + m * g * r * sin(slope)
    assert vanishes(d.motion(0).subs(d["disc.I"], m * r**2 / 2) - wanted)
    assert d.equations.scene.dependents == {"track.s": -r * phi}


def test_four_bar_with_multipliers() -> None:
    """Crank a, coupler b (absolute), rocker c: the loop a + b - c = base, its multipliers on the right rows of J."""
    d = derived(EXAMPLES / "four_bar.lag")
    e = d.equations
    a, c = d["O.phi"], d["C.phi"]
    b = a + d["A.phi"]
    l1, l2, l3 = (d[n] for n in ("crank.L", "coupler.L", "rocker.L"))
    assert vanishes(e.rows[0] + (l1 * cos(a) + l2 * cos(b) - l3 * cos(c) - 1))
    assert vanishes(e.rows[1] + (l1 * sin(a) + l2 * sin(b) - l3 * sin(c)))
    m1, m2, m3, g = (d[n] for n in ("crank.m", "coupler.m", "rocker.m", "world.gravity"))
    bars = (("crank", m1, l1), ("coupler", m2, l2), ("rocker", m3, l3))
    inertia = {d[f"{name}.I"]: m * length**2 / 12 for name, m, length in bars}
    va, vb = d["der(O.phi)"], d["der(O.phi)"] + d["der(A.phi)"]
    wa, wb, wc = d["der(der(O.phi))"], d["der(der(O.phi))"] + d["der(der(A.phi))"], d["der(der(C.phi))"]
    one, two = d["lambda_1"], d["lambda_2"]
    coupler = (m2 * l2**2 / 3 * wb + m2 * l1 * l2 / 2 * (wa * cos(a - b) - va**2 * sin(a - b)) + m2 * g * l2 / 2 * cos(b)
               + one * l2 * sin(b) - two * l2 * cos(b))
    crank = ((m1 / 3 + m2) * l1**2 * wa + m2 * l1 * l2 / 2 * (wb * cos(a - b) + vb**2 * sin(a - b))
             + (m1 / 2 + m2) * g * l1 * cos(a) + one * l1 * sin(a) - two * l1 * cos(a))
    rocker = m3 * l3**2 / 3 * wc + m3 * g * l3 / 2 * cos(c) - one * l3 * sin(c) + two * l3 * cos(c)
    at = {name: k for k, name in enumerate(e.scene.names)}
    assert vanishes(d.motion(at["A.phi"]).subs(inertia) - coupler)
    assert vanishes(d.motion(at["O.phi"]).subs(inertia) - (crank + coupler))
    assert vanishes(d.motion(at["C.phi"]).subs(inertia) - rocker)


# ---------------------------------------------------------------- constants of the motion, given functions


def test_a_prescribed_coordinate_is_a_given_function_of_time() -> None:
    d = derived(EXAMPLES / "crank_press.lag")
    (given,) = d.equations.scene.given
    assert (given.name, given.what, given.value) == ("O.phi", "coordinate", d["speed"] * d["t"])
    assert (given.rate, given.acceleration) == (d["speed"], 0)
    assert "O.phi" not in d.equations.scene.names
    assert any(x.has(given.symbol) for x in d.equations.h)


def test_a_road_is_a_given_function_of_time() -> None:
    """m2 x2'' = ... + k2 h(t): the bump keeps its name in every energy."""
    d = derived(EXAMPLES / "quarter_car.lag")
    (given,) = d.equations.scene.given
    assert (given.name, given.what) == ("bump", "function")
    assert given.value.has(sp.Piecewise)
    assert not any(x.has(sp.Piecewise) for x in (*d.equations.left, d.equations.V_elastic))
    m, k1, k2, c1, x, y = (d[n] for n in ("m2", "k1", "k2", "c1", "wheel.s", "car.s"))
    assert vanishes(d.motion(0) - (m * d["der(der(wheel.s))"] + c1 * (d["der(wheel.s)"] - d["der(car.s)"]) + k1 * (x - y)
                                   + k2 * (x - d["bump"])))


def test_a_prescribed_acceleration_acts(written) -> None:
    """A mass on a hand that is moved as x(t): the spring's other end is dragged, and inertia answers with x''."""
    d = written("""
        model Dragged
          World world(gravity = {0, 0});
          Block hand(m = 1, base = world), load(m = 2, base = hand.center);
          Motion push(of = hand.s, to = 0.1*sin(3*time));
          Spring spring(k = 5, stretch = load.s);
        end Dragged;""")
    (given,) = d.equations.scene.given
    m, k, x = d["load.m"], d["spring.k"], d["load.s"]
    assert vanishes(d.motion(0) - (m * (d["der(der(load.s))"] + given.acceleration) + k * x))
    assert str(given.acceleration) == "der(der(hand.s))"


def test_constants_of_motion() -> None:
    found = {c.name: c for c in constants_of_motion(derived(EXAMPLES / "pendulum.lag").equations)}
    assert set(found) == {"energy"}
    free = derived(EXAMPLES / "free_bar.lag")
    names = [(c.name, free.equations.scene.names[c.coordinate] if c.coordinate is not None else "") for c in
             constants_of_motion(free.equations)]
    assert names == [("momentum", "bar.center.x"), ("momentum", "bar.center.phi"), ("energy", "")]
    assert constants_of_motion(derived(EXAMPLES / "torsion_rotor.lag").equations) == ()


@pytest.mark.parametrize("name", ["double_pendulum", "slider_crank", "four_bar", "skate", "rolling_disc"])
def test_constants_stay_constant(name: str) -> None:
    """Along a run of the native integrator, which knows nothing of this algebra."""
    path = EXAMPLES / f"{name}.lag"
    d = derived(path)
    scene, numbers = d.equations.scene, values(derived(path), path)
    loads = {g.symbol: g.value for g in scene.given}
    run = lag.load(path).simulate(stop=1.0, tolerance=1e-11, interval=0.05)
    rows = [run[n] for n in (*scene.names, *(f"der({n})" for n in scene.names))]
    constants = constants_of_motion(d.equations)
    assert constants
    for c in constants:
        function = sp.lambdify([scene.q + scene.v], c.value.subs(loads).subs(numbers), "numpy")
        along = np.array([function(state) for state in zip(*rows, strict=True)], dtype=float)
        assert np.ptp(along) < 1e-7 * max(1.0, float(np.abs(along).max()))


def test_a_bead_on_a_turning_wire_keeps_jacobis_integral(written) -> None:
    d = written("""
        model Bead
          parameter AngularVelocity Omega = 3;
          World world(gravity = {0, 0});
          Prismatic wire(a = turn(world, Omega*time));
          PointMass bead(m = 2, center = wire.b);
        end Bead;""")
    (constant,) = constants_of_motion(d.equations)
    s, v, m, Omega = d["wire.s"], d["der(wire.s)"], d["bead.m"], d["Omega"]
    assert constant.name == "Jacobi"
    assert vanishes(constant.value - (m * v**2 / 2 - m * Omega**2 * s**2 / 2))
    assert vanishes(d.motion(0) - (m * d["der(der(wire.s))"] - m * Omega**2 * s))


# ---------------------------------------------------------------- against CasADi


@pytest.mark.parametrize("path", WRITTEN, ids=lambda path: path.stem)
def test_the_two_derivations_agree(path: Path) -> None:
    the_two_derivations_agree(path, derived(path))


@pytest.mark.slow
@pytest.mark.parametrize("first", [0, 6])
def test_they_agree_on_random_trees(first: int, tmp_path: Path) -> None:
    """Bars and discs on hinges, sliders and moving bases, with springs, dampers and loads anywhere."""
    for seed in range(first, first + 6):
        path = tmp_path / "tree.lag"
        path.write_text(random_tree(1000 + seed, 1 + (seed % 4 == 2)).text, encoding="utf-8")
        the_two_derivations_agree(path, derived(path, has_named_supports=True))


def the_two_derivations_agree(path: Path, d: Derived) -> None:
    """SymPy's derivatives and CasADi's, at 20 random states: M, h - f, Phi, J and the accelerations to 1e-10."""
    e = d.equations
    scene = e.scene
    model = lag.load(path)
    functions, p = model.functions(), model.parameter_values()
    assert scene.names == model.coordinate_names
    given: dict[sp.Expr, sp.Expr] = {}
    for g in scene.given:
        value = g.value
        for x in g.moving:
            given[x], value = value, value.diff(scene.t)
    known = values(Derived(e), path)
    given = {x: value.xreplace(given).xreplace(known) for x, value in given.items()}

    def numeric(rows):
        return sp.lambdify([scene.t, scene.q, scene.v], [x.xreplace(given).xreplace(known) for x in rows], "numpy", cse=True)

    n, m = e.n, len(e.rows)
    M, force = numeric([x for row in e.M for x in row]), numeric([h - f for h, f in zip(e.h, e.f, strict=True)])
    rows, J = numeric(e.rows[: scene.holonomic]), numeric([x for row in e.J for x in row])
    random = np.random.default_rng(7)
    for _ in range(20):
        t, q, v = random.uniform(0, 1), random.uniform(0.2, 1.2, n), random.uniform(-2, 2, n)
        call = [np.array(functions[name](t, q, v, [], p)) for name in ("M", "h", "rhs")]
        mine = np.array(M(t, q, v), dtype=float).reshape(n, n), np.array(force(t, q, v), dtype=float)
        close(mine[0], call[0])
        close(mine[1], call[1].ravel())
        if not m:
            close(np.linalg.solve(mine[0], -mine[1]), call[2].ravel())
            continue
        jacobian = np.array(J(t, q, v), dtype=float).reshape(m, n)
        close(jacobian, np.array(functions["J"](t, q, v, [], p)))
        close(np.array(rows(t, q, v), dtype=float), np.array(functions["Phi"](t, q, v, [], p)).ravel())


def close(mine: np.ndarray, theirs: np.ndarray) -> None:
    scale = max(1e-300, float(np.abs(theirs).max(initial=0.0)))
    assert mine.shape == theirs.shape
    assert float(np.abs(mine - theirs).max(initial=0.0)) < 1e-10 * scale or float(np.abs(theirs - mine).max()) < 1e-14
