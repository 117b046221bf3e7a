"""One degree of freedom and energy kept: half a swing is computed, the rest is read from it."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from scipy.special import ellipj, ellipk

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.request import check_values
from lagrangia.run.runtime import Run, Settings, Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
CRANK = """
model CrankRocker
  World world(gravity = {0, G});
  Revolute O(a = world, phi(start = 40[deg], fixed = true)), A(a = crank.b), B(a = coupler.b, b = rocker.b),
           C(a = shift(world, {1, 0}), phi(start = 75[deg]));
  Bar crank(m = 1, L = 0.3, a = O.b), coupler(m = 2, L = 1, a = A.b), rocker(m = 1.5, L = 0.8, a = C.b);
initial equation
  der(O.phi) = 8;
end CrankRocker;"""


def swing(t: np.ndarray, amplitude: float, length: float = 1.0, g: float = 9.81) -> np.ndarray:
    """The pendulum let go at this angle, by elliptic functions."""
    k, omega = np.sin(amplitude / 2) ** 2, np.sqrt(g / length)
    sn, *_ = ellipj(ellipk(k) - omega * t, k)
    return np.asarray(2 * np.arcsin(np.sin(amplitude / 2) * sn))


@pytest.mark.parametrize(("tolerance", "most"), [(1e-4, 3e-4), (1e-8, 1e-8), (1e-12, 3e-12)])
def test_a_thousand_swings_cost_as_much_as_one(tolerance: float, most: float) -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    at = np.random.default_rng(1).uniform(0, 2000, 300)
    at.sort()
    run = model.simulate(at=at, tolerance=tolerance)
    assert np.abs(run["hinge.phi"] - swing(at, np.pi / 2)).max() < most
    assert run.statistics.rhs_evaluations < 60
    assert run.statistics.solver is Solver.TAYLOR
    assert run.statistics.energy_residual < max(tolerance, 1e-14) * run.statistics.energy_size
    once = model.simulate(at=[1.2], tolerance=tolerance)
    assert run.statistics.rhs_evaluations < 2 * once.statistics.rhs_evaluations + 10


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8])
def test_swings_of_loops_are_read_from_steps_of_collocation(tolerance: float) -> None:
    """Rows inside of them have the digits of their ends; how many rows there are changes nothing but what reads them."""
    model = lag.load(EXAMPLES / "scissor_lift.lag")
    at = np.linspace(0, 40, 2001)
    exact = model.simulate(at=at, stop=40, solver="implicit", tolerance=1e-13)
    run, few = (model.simulate(at=times, stop=40, tolerance=tolerance) for times in (at, at[::1000]))
    assert run.statistics.solver is Solver.PIRK and run.statistics.choice.rule == "swing"
    assert run.statistics.steps < 12 and run.statistics.steps_by[Solver.ORBIT] == 1
    assert run.statistics.steps == few.statistics.steps
    for name in model.coordinate_names:
        assert np.abs(run[name] - exact[name]).max() < 0.1 * tolerance
        assert np.array_equal(run[name][::1000], few[name])


@pytest.mark.parametrize(("phi", "w"), [(0.3, 1.5), (-1.0, 4.0), (3.1, 0.0), (0.0, 6.2), (3.14159, 0.0)])
def test_starts_in_motion_and_near_the_top(phi: float, w: float) -> None:
    """The first turn comes later, or late; rows before it, between the turns and after them."""
    model, at = lag.load(EXAMPLES / "pendulum.lag"), np.linspace(0, 25, 251)
    initial = {"hinge.phi": phi, "der(hinge.phi)": w}
    exact = model.simulate(at=at, initial=initial, tolerance=1e-14, solver="erk")
    for tolerance in (1e-5, 1e-9):
        run, other = (model.simulate(at=at, initial=initial, tolerance=tolerance, solver=solver) for solver in ("auto", "erk"))
        errors = [max(np.abs(x[name] - exact[name]).max() for name in ("hinge.phi", "der(hinge.phi)")) for x in (run, other)]
        assert errors[0] < max(3 * errors[1], 10 * tolerance)


def test_what_goes_round_is_stepped() -> None:
    model, at = lag.load(EXAMPLES / "pendulum.lag"), np.linspace(0, 60, 61)
    initial = {"hinge.phi": 0.0, "der(hinge.phi)": 7.0}
    run = model.simulate(at=at, initial=initial, tolerance=1e-10)
    exact = model.simulate(at=at, initial=initial, tolerance=1e-13, solver="erk")
    assert run["hinge.phi"][-1] > 60
    assert run["hinge.phi"] == pytest.approx(exact["hinge.phi"], abs=1e-6)
    assert run.statistics.rhs_evaluations > 300


def test_closed_loops(scene: Write) -> None:
    model, at = lag.load(EXAMPLES / "four_bar.lag"), np.linspace(0, 8, 81)
    exact = model.simulate(at=at, tolerance=1e-13, solver="erk")
    for tolerance in (1e-5, 1e-8, 1e-11):
        run, other = (model.simulate(at=at, tolerance=tolerance, solver=solver) for solver in ("auto", "erk"))
        errors = [np.abs(x.rows[:, 1 : 1 + model.scene.n] - exact.rows[:, 1 : 1 + model.scene.n]).max() for x in (run, other)]
        assert errors[0] < max(2 * errors[1], 10 * tolerance)
        assert run.statistics.constraint_residual < 1e-13
        assert run.statistics.constraint_rate_residual < 1e-11
        assert run.statistics.rhs_evaluations < 0.6 * other.statistics.rhs_evaluations


@pytest.mark.parametrize("gravity", [0.0, -9.81])
def test_one_coordinate_that_turns_is_no_turn(gravity: float, scene: Write) -> None:
    """The rocker swings while the crank goes round."""
    model, at = scene(CRANK.replace("G}", f"{gravity}}}")), np.linspace(0, 4, 41)
    run, exact = model.simulate(at=at, tolerance=1e-9), model.simulate(at=at, tolerance=1e-13, solver="erk")
    assert run["O.phi"][-1] > 10
    assert np.abs(run.rows[:, 1 : 1 + model.scene.n] - exact.rows[:, 1 : 1 + model.scene.n]).max() < 1e-6


@pytest.mark.parametrize(("text", "is_swing"), [
    ("Revolute h(a = world, phi(start = 1)); Bar b(m = 1, L = 1, a = h.b);", True),
    ("Revolute h(a = world, phi(start = 1)); Bar b(m = 1, L = 1, a = h.b); TorsionDamper d(c = 0.1, twist_rate = h.w);", False),
    ("Revolute h(a = world, phi(start = 1)); Bar b(m = 1, L = 1, a = h.b); AppliedTorque t(on = h.b, torque = 1);", False),
    ("Revolute h(a = shift(world, {0.1*sin(time/1[s]), 0}), phi(start = 1)); Bar b(m = 1, L = 1, a = h.b);", False),
    ("Revolute h(a = world, phi(start = 1)), g(a = b.b); Bar b(m = 1, L = 1, a = h.b), c(m = 1, L = 1, a = g.b);", False),
    ("Bar b(m = 2, L = 2); PointOnLine l(line = world, point = b.a), w(line = turn(world, 90[deg]), point = b.b);", True),
])
def test_which_scenes_swing_back(text: str, is_swing: bool, scene: Write) -> None:
    text = text.replace("TorsionDamper d(c = 0.1, twist_rate = h.w);", "Damper d(c = 0.1, rate = 1[m]*h.w);")
    assert scene(f"model M {text} end M;").scene.sizes["is_swing"] == is_swing


def started(model: lag.Model, stop: float, tolerance: float, solver: Solver = Solver.AUTO) -> Run:
    engine = model.engine
    assert engine is not None
    values = check_values(model.scene)
    run = engine.runtime.run(engine.model, Settings(0, stop, tolerance=tolerance, solver=solver))
    run.set_parameters(values.parameters, values.mask)
    assert run.start(values.q, values.v) is Status.OK
    return run


def test_parameters_that_change_on_the_way() -> None:
    """Another pendulum from there on, with a swing of its own."""
    model = lag.load(EXAMPLES / "pendulum.lag")
    longer = check_values(model.scene, {"L": 2.0})
    rows = []
    for solver in (Solver.AUTO, Solver.ERK):
        with started(model, 30.0, 1e-11, solver) as run:
            run.set_stop(7.3)
            assert run.advance([7.3]).status is Status.OK
            run.set_stop(30.0)
            run.set_parameters(longer.parameters, longer.mask)
            rows.append(np.array(run.advance(np.linspace(8, 30, 23)).values).reshape(23, -1)[:, :3])
            assert run.statistics.rhs_evaluations < 150 or solver is Solver.ERK
    assert rows[0] == pytest.approx(rows[1], abs=1e-8)


def test_rows_do_not_change_it() -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    few, many = (model.simulate(at=at, tolerance=1e-9) for at in ([30.0], np.linspace(0, 30, 3001)))
    assert few["hinge.phi"][-1] == many["hinge.phi"][-1]
    assert few.statistics.rhs_evaluations == many.statistics.rhs_evaluations


def test_extremes_are_looked_for_in_steps() -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    table = model.simulate_many(parameters={"L": [1.0, 2.0]}, outputs=["max(abs(hinge.phi))", "final(hinge.phi)"], stop=20,
                                tolerance=1e-10)
    assert table["max(abs(hinge.phi))"] == pytest.approx(np.pi / 2, abs=1e-8)
    finals = [float(swing(np.array([20.0]), np.pi / 2, L)[0]) for L in (1.0, 2.0)]
    assert table["final(hinge.phi)"] == pytest.approx(finals, abs=1e-8)


def test_a_slow_coordinate_beside_a_quick_one(scene: Write) -> None:
    """A long crank that hardly turns whips a short rocker round: when this one turns, nothing rests."""
    model, at = scene("""
model Whip
  World world(gravity = {0, 0});
  Revolute O(a = world, phi(start = 40[deg], fixed = true)); Disc wheel(m = 500, r = 1, center = O.b);
  Prismatic guide(a = world, along = {0, 1}, s(start = 0.001));
  PointMass bob(m = 1e-3, center = guide.b);
equation
  guide.s = 0.001[m]*sin(200*O.phi);
initial equation
  der(O.phi) = 0.02;
end Whip;"""), np.linspace(0, 20, 41)
    for tolerance in (1e-3, 1e-6):
        run = model.simulate(at=at, tolerance=tolerance)
        assert run["O.phi"] == pytest.approx(np.deg2rad(40) + 0.02 * at, abs=10 * tolerance)
