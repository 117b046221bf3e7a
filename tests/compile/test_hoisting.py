"""What is computed once a run, or never: hoisted factors, and numbers that are compiled in."""

from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from lagrangia.compile.hoisting import hoist
from lagrangia.compile.instructions import count_operations, tape_of
from lagrangia.run.interpret import evaluate
from lagrangia.run.request import check_values

Scene = Callable[[str], lag.Model]
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
TILTED = """model M World world(gravity = {gravity});
  Prismatic guide(a = world, along = {along}); Revolute hinge(a = guide.b, phi(start = 1)); Bar bar(m = 2, L = 1, a = hinge.b);
  AxialSpring s(a = world, b = bar.b, k = 50, along = {along}); annotation(experiment(StopTime = 2)); end M;"""


def written(gravity: str, along: str) -> str:
    return TILTED.replace("{gravity}", gravity).replace("{along}", along)


def count(expressions: list[ca.SX], arguments: list[ca.SX]) -> int:
    return count_operations(tape_of(ca.Function("f", arguments, [ca.densify(e) for e in expressions])))


# ---------------------------------------------------------------- factors


X, Y, K, M = (ca.SX.sym(name) for name in ("x", "y", "k", "m"))


@pytest.mark.parametrize(("expression", "operations"), [
    (2 * X * (K / 2), 1), (-(X - Y), 1), (X / M, 1), (-(K * X) / M, 1), (K * X + K * Y, 2), (K * X - M * (-Y), 3),
    (ca.if_else(Y > 0, K * X, 0) / M, 3), (K / (M * X), 1), ((K * X) ** 2 / M, 2), (ca.sin(K * X / M), 2), (K / M, 0),
    (K * ca.sin(X) / 3 * 3 * (-Y), 3), (X + 0 * K, 0),
])
def test_factors_are_drawn_together(expression: ca.SX, operations: int) -> None:
    p = ca.vertcat(K, M)
    found = hoist([[expression]], p)
    (made,), c, values = found.expressions, found.c, found.values
    assert count([made], [X, Y, c]) == operations and found.settled == c.numel()
    assert not ca.depends_on(made, p)
    whole = ca.Function("w", [X, Y, p], [ca.substitute([made], [c], [values])[0] if c.numel() else made])
    plain = ca.Function("f", [X, Y, p], [expression])
    for x, y in ((0.3, 0.7), (-2, -5), (4, 0.1)):
        np.testing.assert_allclose(float(whole(x, y, [3, 7])), float(plain(x, y, [3, 7])), rtol=1e-15)


@pytest.mark.parametrize("seed", range(20))
def test_hoisted_expressions_are_the_same_numbers(seed: int) -> None:
    """Random expressions of three quantities and three parameters, whose parts are used several times."""
    random = np.random.default_rng(seed)
    x, p = ca.SX.sym("x", 3), ca.SX.sym("p", 3)
    known = [*ca.vertsplit(x), *ca.vertsplit(p), ca.SX(2), ca.SX(-0.5)]
    for _ in range(60):
        a, b = (known[k] for k in random.integers(len(known), size=2))
        known.append([a + b, a - b, a * b, -a, a / (2 + ca.sin(b)), ca.sin(a), 2 * a, ca.tanh(a) ** 2, ca.if_else(b > 0, a, 0)]
                     [random.integers(9)])
    wanted = [ca.tanh(e) for e in known[-6:]]
    hoisted = hoist([wanted[:4], wanted[4:]], p)
    made, c, values = hoisted.expressions, hoisted.c, hoisted.values
    assert count(made, [x, c]) <= count(wanted, [x, p])
    place, parameters = random.uniform(-2, 2, 3), random.uniform(-2, 2, 3)
    constants = ca.Function("c", [p], [values])(parameters)
    found = ca.Function("f", [x, c], [ca.vertcat(*made)])(place, constants)
    np.testing.assert_allclose(np.array(found), np.array(ca.Function("g", [x, p], [ca.vertcat(*wanted)])(place, parameters)),
                               rtol=1e-9, atol=1e-12)


def test_a_tape_computes_the_same_once() -> None:
    """Expressions built twice over, products and sums in either order, and 0.0 beside -0.0."""
    products = ca.sin(X * Y) + ca.cos(X + Y), ca.cos(Y + X) - ca.sin(Y * X), ca.sin(X * Y) + ca.cos(Y + X)
    others = X - Y, Y - X, ca.copysign(1, 0.0 * ca.cos(X)), ca.atan2(-0.0, X), ca.atan2(0.0, X)
    function = ca.Function("f", [X, Y], [ca.vertcat(*products), ca.vertcat(*others)])
    tape = tape_of(function)
    assert count_operations(tape, 0) == 6
    for x, y in ((0.3, -0.7), (-2.0, 5.0)):
        assert evaluate(tape, [x], [y]) == [[float(v) for v in np.array(column).ravel()] for column in function(x, y)]


# ---------------------------------------------------------------- numbers that are compiled in


def test_zeros_and_ones_are_compiled_in_and_stay_parameters(scene: Scene) -> None:
    model = scene(written("{0, -9.81}", "{0, 1}"))
    compiled = {p.name: p.compiled for p in model.scene.parameters if p.compiled is not None}
    assert compiled == {"world.gravity[1]": 0, "guide.along[1]": 0, "guide.along[2]": 1, "s.along[1]": 0, "s.along[2]": 1,
                        "s.s_rel0": 0}
    assert "world.gravity[1]" in model.parameter_names
    assert model.scene.notes["rhs_operations"] < 0.8 * model.general.scene.notes["rhs_operations"]
    assert all(p.compiled is None for p in model.general.scene.parameters)


@pytest.mark.parametrize(("given", "gravity", "along"), [
    ({"world.gravity[1]": 3}, "{3, -9.81}", "{0, 1}"), ({"world.gravity[2]": -1.62}, "{0, -1.62}", "{0, 1}"),
    ({"guide.along[1]": 2, "s.along[1]": 2}, "{0, -9.81}", "{2, 1}"),
])
def test_a_number_that_is_compiled_in_can_be_given(scene: Scene, given: dict[str, float], gravity: str, along: str) -> None:
    model = scene(written("{0, -9.81}", "{0, 1}"))
    times = [0.5, 1, 2]
    run = model.simulate(at=times, parameters=given, tolerance=1e-10)
    other = scene(written(gravity, along)).simulate(at=times, tolerance=1e-10)
    assert np.abs(run["hinge.phi"] - model.simulate(at=times, tolerance=1e-10)["hinge.phi"]).max() > 0.01
    for name in ("hinge.phi", "guide.s", "bar.b.x"):
        np.testing.assert_allclose(run[name], other[name], rtol=1e-7, atol=1e-9)
    swept = model.simulate_many(parameters={name: [value] for name, value in given.items()}, outputs=["hinge.phi"], stop=2,
                                tolerance=1e-10)
    assert swept["final(hinge.phi)"][0] == pytest.approx(other["hinge.phi"][-1], rel=1e-7)
    fixed = model.simulate_many(parameters={**given, "bar.m": [2.0]}, outputs=["hinge.phi"], stop=2, tolerance=1e-10)
    assert fixed["final(hinge.phi)"][0] == pytest.approx(other["hinge.phi"][-1], rel=1e-7)


def test_only_other_values_need_other_formulas(scene: Scene) -> None:
    model = scene(written("{0, -9.81}", "{0, 1}"))
    for given, is_same in (({"world.gravity[1]": 0, "world.gravity[2]": -1.62}, True), ({"bar.m": 7}, True),
                           ({"s.s_rel0": 0.1}, False)):
        assert (model.suited(check_values(model.scene, given)) is model) == is_same


def test_functions_for_people_have_all_parameters_open(scene: Scene) -> None:
    model = scene(written("{0, -9.81}", "{0, 1}"))
    rhs, p = model.functions()["rhs"], model.parameter_values()
    weightless = model.parameter_values({"world.gravity[1]": 5})
    a, b = (np.array(rhs(0, [0, 1], [0, 0], [], values)) for values in (p, weightless))
    assert np.abs(a - b).max() > 0.1


def test_what_a_component_evaluates_is_its_own_choice(scene: Scene) -> None:
    """annotation(Evaluate = true) is for everybody's parameters."""
    text = """model Drag parameter Damping c = 0 annotation(Evaluate = VALUE); Velocity rate;
        energy dissipation c*rate^2/2; end Drag;
        model M Block b(m = 1, base = world, v(start = 1)); Drag d(rate = b.v); end M;"""
    for value in ("true", "false"):
        model = scene(text.replace("VALUE", value))
        assert (model.scene.notes["rhs_operations"] == 0) == (value == "true")
        assert model.simulate(at=[1], parameters={"d.c": 1}, tolerance=1e-12)["b.v"][0] == pytest.approx(np.exp(-1), rel=1e-9)
    with pytest.raises(lag.LagError, match="'Evaluate' is true or false"):
        scene(text.replace("VALUE", "1"))


def test_a_direction_of_no_length_is_an_error(scene: Scene) -> None:
    with pytest.raises(lag.LagError, match="division by zero"):
        scene(written("{0, -9.81}", "{0, 0}"))
