"""Taylor series of the motion: every operation's recurrence against CasADi's derivatives, and runs against the other methods."""

import math
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from helpers.native_models import FOLDER
from lagrangia.base.diagnostics import LagError, RunError
from lagrangia.compile.instructions import tape_of
from lagrangia.native.build import build
from lagrangia.native.c_code import jet_tape, write_c
from lagrangia.native.series import find_series
from lagrangia.native.tapes import JetOp
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Model, Settings, Solver, Status

Force = Callable[[ca.SX, ca.SX, ca.SX], ca.SX]

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
CASES = Path(__file__).parents[1] / "cases"

# Forces on one coordinate that use one function each; all are smooth near the path from q = 0.4, v = 0.3.
FORCES: dict[str, Force] = {
    "polynomial": lambda t, q, v: q**3 - 2 * q * v + v**2 - 1,
    "quotient": lambda t, q, v: (1 + q) / (2 + v * q) - 1 / (3 + q),
    "squares": lambda t, q, v: -(t * q) * q - v * (q * v) - (3 * v) * v + ca.sqrt(2 + (q * v) * v) * (q * v),
    "sine": lambda t, q, v: ca.sin(q * v) - ca.cos(2 * q) * ca.sin(t),
    "tangent": lambda t, q, v: -ca.tan(q) * (1 + v),
    "root": lambda t, q, v: -ca.sqrt(1 + q**2 + v**2),
    "exponential": lambda t, q, v: -ca.exp(-q * v) * q,
    "logarithm": lambda t, q, v: -ca.log(2 + q * v),
    "power": lambda t, q, v: -((1.5 + q) ** 1.7) + (2 + v) ** -0.5,
    "whole power": lambda t, q, v: -((q - 0.4) ** 5) - q,
    "arcs": lambda t, q, v: -ca.asin(q / 9) - ca.acos(v / 9) + ca.atan(q + v),
    "angle": lambda t, q, v: -ca.atan2(q, 2 + v),
    "hyperbolic": lambda t, q, v: -ca.sinh(q) + ca.cosh(v) * 0.1 - ca.tanh(q * v),
    "numbers": lambda t, q, v: 3 / (2 + q) - (q - 4) / 5 + (1 - v) - (2 * q - 0.5) + 1.5 * t,
    "two angles": lambda t, q, v: -ca.sin(q) + ca.cos(v) - ca.sinh(q - v),
    "time": lambda t, q, v: -q + t**2 * ca.exp(-t) * ca.cos(3 * t),
}


def model_of(force: Force, native: bool = True) -> Model:
    """The model q'' = force(t, q, v), through the compiler's own C, or as tapes."""
    t, q, v, nothing = ca.SX.sym("t"), ca.SX.sym("q"), ca.SX.sym("v"), ca.SX(0, 1)
    rhs = ca.Function("rhs", [t, q, v, nothing, nothing, nothing], [ca.SX(force(t, q, v)), nothing, nothing])
    start = ca.Function("start", [nothing], [ca.SX(0.4), ca.SX(0.3)])
    tapes = {"rhs": tape_of(rhs), "start": tape_of(start)}
    if not native:
        series = jet_tape(tapes)
        assert not isinstance(series, str), series
        sizes, lists, functions = series
        return Model.from_tapes({"n": 1} | sizes, tapes | functions, [1], [0, 0], [], lists)
    return Model.from_library(build("series", write_c("Series", {"n": 1}, tapes, [1], [0, 0], [], {}), include=[FOLDER]))


def end_of(runtime: Runtime, force: Force, solver: Solver, tolerance: float, native: bool = True) -> tuple[np.ndarray, int]:
    """q and v at t = 2, and the steps it took."""
    with runtime.run(model_of(force, native), Settings(t_stop=2.0, tolerance=tolerance, solver=solver)) as run:
        assert run.set_parameters() is Status.OK
        assert run.start() is Status.OK
        return np.array(run.advance([2.0])[0][1:3]), run.statistics.steps


@pytest.mark.parametrize("name", FORCES)
def test_each_recurrence(runtime: Runtime, name: str) -> None:
    """One method checks another: a wrong coefficient shows at once, at rounding level."""
    exact, many = end_of(runtime, FORCES[name], Solver.ERK, 1e-14)
    found, few = end_of(runtime, FORCES[name], Solver.TAYLOR, 1e-13)
    assert np.abs(found - exact).max() < 2e-13
    assert few < 0.7 * many
    interpreted, as_few = end_of(runtime, FORCES[name], Solver.TAYLOR, 1e-13, native=False)
    assert (interpreted.tolist(), as_few) == (found.tolist(), few), "tapes have the digits of native code"


def test_products_are_squares_where_they_can_be() -> None:
    """(t q) q and 3 v v have half of their terms to sum; q v is asked for twice, and stays."""
    t, q, v, nothing = ca.SX.sym("t"), ca.SX.sym("q"), ca.SX.sym("v"), ca.SX(0, 1)
    force = (t * q) * q + (3 * v) * v + (q * v) * v + ca.sin(q * v)
    series = find_series(tape_of(ca.Function("rhs", [t, q, v, nothing, nothing, nothing], [force, nothing, nothing])))
    ops = [i.op for i in series.instructions]
    assert (ops.count(JetOp.SQUARE), ops.count(JetOp.PRODUCT)) == (2, 3)


@pytest.mark.parametrize("function", [ca.fabs, lambda q: ca.fmax(q, 0), lambda q: ca.if_else(q > 0, q, 2 * q)])
def test_corners_have_no_series(runtime: Runtime, function: Callable[[ca.SX], ca.SX]) -> None:
    with runtime.run(model_of(lambda t, q, v: -function(q)), Settings(t_stop=1.0, solver=Solver.TAYLOR)) as run:
        run.set_parameters()
        assert run.start() is Status.BAD_SETTINGS


@pytest.mark.parametrize("path", [
    EXAMPLES / "pendulum.lag", EXAMPLES / "spring_pendulum.lag", EXAMPLES / "vibration_absorber.lag", EXAMPLES / "cart_pole.lag",
    CASES / "gni_fermi_pasta_ulam.lag", CASES / "kepler_orbits.lag",
], ids=lambda path: path.stem)
@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
def test_series_agree_with_runge_kutta(path: Path, tolerance: float) -> None:
    model = lag.load(path)
    at = np.linspace(model.scene.start, model.scene.start + 2.0, 41)[1:]
    states = slice(1, 1 + 2 * model.scene.n)
    exact = model.simulate(at=at, tolerance=1e-14, solver="erk").rows[:, states]
    run = model.simulate(at=at, tolerance=tolerance, solver="taylor")
    assert run.statistics.solver is Solver.TAYLOR
    assert (np.abs(run.rows[:, states] - exact).max(axis=0) < 30 * tolerance * np.abs(exact).max(axis=0) + 1e-13).all()
    assert np.abs(run.energy.residual).max() < 1e3 * tolerance * run.statistics.energy_scale


@pytest.mark.parametrize("tolerance", [0.1, 0.03, 0.01, 1e-3])
def test_the_first_step_from_rest_is_no_longer_than_the_series_bears(tolerance: float) -> None:
    """Nothing has a size yet, and a fast motion of no amplitude is in the series: 4e21 m came of believing it at 0.1."""
    run = lag.load(CASES / "stiff_spring_pendulum.lag").simulate(stop=1, tolerance=tolerance, solver="taylor", interval=0.01)
    assert np.abs(run.energy.residual).max() < 1e-3 * tolerance * run.statistics.energy_scale


@pytest.mark.parametrize("tolerance", [1e-12, 1e-13, 1e-14])
def test_rounding_is_not_taken_for_a_wrong_step(tolerance: float) -> None:
    """A road begins to rise from rest: 1 - cos has four digits there, and no shorter step has more of them."""
    run = lag.load(EXAMPLES / "quarter_car.lag").simulate(stop=3, tolerance=tolerance, solver="taylor")
    assert run.statistics.rejected < 5
    assert np.abs(run.energy.residual).max() < 1e-13 * run.statistics.energy_scale


def test_accelerations_that_are_rounding_bind_no_steps(scene: Callable[[str], lag.Model]) -> None:
    """Centres at rest whose force is along x: what is left of y and z is 1e-20, and so would their units be."""
    model = scene("""model Floats
      World world(gravity = {0, 0, 0});
      Body a(m = 1, I = {0.1, 0.2, 0.3}, center(omega(start = {0.6, 0.1, 0.8})));
      Body b(m = 2, I = {0.4, 0.2, 0.3}, center(r(start = {1, 0, 0}), omega(start = {0.6, 0.1, 0.8})));
      AxialSpring spring(k = 50, s_rel0 = 0.7, a = shift(a.center, {0.1, 0.1, 0}), b = shift(b.center, {-0.2, 0, 0.1}));
    end Floats;""")
    for tolerance in (1e-6, 1e-9, 1e-12):
        run = model.simulate(at=[0, 1], tolerance=tolerance, solver="taylor")
        assert run.statistics.steps < 30 and not run.warnings


def test_inputs_and_events_are_met(tmp_path: Path) -> None:
    """A force that is switched on in time, and a table of inputs with a corner: closed form."""
    path = tmp_path / "driven.lag"
    path.write_text("""model Driven
  input Force F;
  Prismatic x(a = world, along = {1, 0});
  PointMass m(m = 2, center = x.b);
  AppliedForce push(at = x.b, force = {F + (if time < 0.5 then 0 else 3), 0});
end Driven;""")
    model = lag.load(path)
    run = model.simulate(at=[0.25, 0.5, 1.0, 2.0], inputs=([0.0, 1.0, 2.0], {"F": [0.0, 2.0, 2.0]}), solver="taylor")

    def rate(t: float) -> float:
        table = t**2 if t < 1 else 1 + 2 * (t - 1)
        return (table + 3 * max(0.0, t - 0.5)) / 2

    assert run["x.v"] == pytest.approx([rate(t) for t in (0.25, 0.5, 1.0, 2.0)], abs=1e-14)


ROW = """model Row "Masses between two walls, the second one pushed"
  parameter Integer n = 8; parameter Damping c = 0.1; parameter Force F = 1; parameter Length a = 1;
  World  world(gravity = {0, 0});
  Block  mass[n](each m = 2, each base = world, s(start = {a*sin(3*j) for j in 1:n}));
  Link left(k = 3, c = c, stretch = mass[1].s), right(k = 5, c = c, stretch = mass[n].s);
  Link spring[n - 1](each k = 4, each c = c, stretch = {mass[j + 1].s - mass[j].s for j in 1:n - 1});
  AppliedForce push(at = mass[2].center, force = {if time < 2 then 0 else F, 0});
end Row;
"""


@pytest.mark.parametrize("n", [7, 8, 9, 10, 11, 17])
@pytest.mark.parametrize(("solver", "link"), [("taylor", "Spring"), ("erk", "SpringDamper"), ("erk5", "SpringDamper")])
def test_long_states_are_as_good_as_short_ones(tmp_path: Path, n: int, solver: str, link: str) -> None:
    """From 8 coordinates on series, and from 16 on all explicit steps, take several components at once: none may be forgotten."""
    path = tmp_path / "row.lag"
    text = ROW.replace("Link", link)
    path.write_text(text if link == "SpringDamper" else text.replace(", c = c", "").replace(", each c = c", ""))
    model, at, columns = lag.load(path, n=n), np.linspace(0.5, 9.5, 19), slice(1, 1 + 2 * n)
    exact = model.simulate(at=at, solver="implicit", tolerance=1e-13).rows[:, columns]
    for tolerance in (1e-4, 1e-7, 1e-10):
        run = model.simulate(at=at, solver=solver, tolerance=tolerance)
        assert np.abs(run.rows[:, columns] - exact).max() < 30 * tolerance * np.abs(exact).max()
        assert np.abs(run.energy.residual).max() < 100 * tolerance * run.statistics.energy_scale


def test_auto_takes_series_where_they_pay() -> None:
    pendulum = lag.load(EXAMPLES / "pendulum.lag")
    assert pendulum.simulate(stop=1, tolerance=1e-10).statistics.solver is Solver.TAYLOR
    chain = lag.load(EXAMPLES / "chain.lag", n=8)
    assert chain.simulate(stop=0.1, tolerance=1e-10).statistics.solver is Solver.ERK
    with pytest.raises(LagError, match="compile"):
        chain.simulate(stop=1, solver="taylor")


@pytest.mark.parametrize("native", [None, True])
def test_long_series_run_on_tapes_and_in_sweeps(native: bool | None) -> None:
    path = Path(__file__).parents[1] / "benchmarks" / "scenes" / "row.lag"
    series = lag.load(path, n=210)
    series.native = native
    runs = [series.simulate(stop=2, tolerance=1e-11, solver=solver) for solver in ("taylor", "erk")]
    assert runs[0].statistics.solver is Solver.TAYLOR
    assert runs[0]["mass[25].s"] == pytest.approx(runs[1]["mass[25].s"], abs=1e-9)
    table = series.simulate_many(parameters={"mass[25].m": [1.0, 2.0]}, outputs=["at(2, mass[25].s)"], stop=2, solver="taylor")
    assert table["at(2, mass[25].s)"][0] == pytest.approx(runs[1]["mass[25].s"][-1], abs=1e-6)


def test_rows_do_not_change_the_steps() -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    many, few = (model.simulate(at=at, solver="taylor") for at in (np.linspace(0, 10, 1001)[1:], [10.0]))
    assert many.rows[-1, 1] == few.rows[-1, 1]
    assert many.statistics.steps == few.statistics.steps


def test_a_collision_is_not_stepped_over(tmp_path: Path) -> None:
    """A mass that falls into a centre of attraction: the radius of convergence shrinks to nothing, at the right time."""
    path = tmp_path / "fall.lag"
    path.write_text("""model Pull
  Frame a, b;
energy
  potential -1[N.m2]/distance(a, b);
end Pull;
model Fall
  World world(gravity = {0, 0});
  Prismatic x(a = world, along = {1, 0}, s(start = 1));
  PointMass m(m = 1, center = x.b);
  Pull pull(a = world, b = x.b);
end Fall;""")
    with pytest.raises(lag.RunError) as caught:
        lag.load(path).simulate(stop=2, solver="taylor", interval=0.01)
    reached = caught.value.trajectory
    assert reached is not None
    assert reached.time[-1] == pytest.approx(math.pi / math.sqrt(8), abs=0.02)
    assert np.isfinite(reached.rows).all()


def test_what_a_series_cannot_foresee_is_left_to_others(scene: Callable[[str], lag.Model]) -> None:
    """A force like exp(-100) at the start, and within a step the largest of all: no coefficient tells of it."""
    model = scene("""model Bump
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, s(start = 0.1, fixed = true), v(start = 0.3)); Spring k(k = 100, stretch = b.s);
  AppliedForce f(at = b.center, force = {-5[N]*b.s/1e-2[m]*exp(-(b.s/1e-2[m])^2), 0});
end Bump;""")
    at = np.linspace(0.1, 2, 20)
    exact = model.simulate(at=at, tolerance=1e-12, solver="implicit")
    for tolerance in (1e-5, 1e-8, 1e-11):
        run = model.simulate(at=at, tolerance=tolerance)
        assert run.statistics.solver is not Solver.TAYLOR
        assert run["b.s"] == pytest.approx(exact["b.s"], abs=10 * tolerance)


def test_exponentials_of_time_hide_nothing(scene: Callable[[str], lag.Model]) -> None:
    model = scene("""model Dies Block b(m = 1, base = world); Spring k(k = 10, stretch = b.s);
      AppliedForce f(at = b.center, force = {1[N]*exp(1 - 0.5[1/s]*time)*(1 + (b.s/1[m])^2), 0}); end Dies;""")
    assert model.simulate(stop=5.0, tolerance=1e-10).statistics.solver is Solver.TAYLOR


def test_auto_leaves_series_without_coefficients(scene: Callable[[str], lag.Model]) -> None:
    """(1 - cos(s))^1.25 has a slope at 0, but its series divides by 1 - cos(s)."""
    model = scene("""model Power
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, v(start = 1)); Spring k(k = 10, stretch = b.s);
  AppliedForce f(at = b.center, force = {-3[N]*b.s/1[m]*(1 - cos(b.s/1[m]))^1.25, 0});
end Power;""")
    at = [0.5, 1.0, 2.0]
    exact = model.simulate(at=at, tolerance=1e-13, solver="erk")["b.s"]
    run = model.simulate(at=at, tolerance=1e-10)
    assert run["b.s"] == pytest.approx(exact, abs=1e-9)
    assert run.statistics.switches == 1
    assert run.statistics.solver is Solver.ERK
    with pytest.raises(RunError):
        model.simulate(at=at, tolerance=1e-10, solver="taylor")


SATURATED = {
    "tanh": "tanh(b.v/{eps}[m/s])",
    "logistic": "(1 - 2/(1 + exp(2*b.v/{eps}[m/s])))",
    "arc": "2/pi*atan(b.v/{eps}[m/s])",
    "root": "b.v/sqrt(b.v^2 + ({eps}[m/s])^2)",
}


@pytest.mark.parametrize("eps", [1e-2, 1e-3, 1e-5])
@pytest.mark.parametrize("form", SATURATED)
def test_dry_friction_that_is_made_steep(form: str, eps: float, scene: Callable[[str], lag.Model]) -> None:
    """Where tanh is 1, sinh and cosh are infinite; where series have no finite coefficients, `auto` goes on without them."""
    model = scene(f"""model Sticks
  World world(gravity = {{0, 0}});
  Block b(m = 1, base = world, s(start = 0.1, fixed = true)); Spring k(k = 100, stretch = b.s);
  AppliedForce f(at = b.center, force = {{-1[N]*{SATURATED[form].format(eps=eps)}, 0}});
end Sticks;""")
    exact = model.simulate(at=[0.4, 1.0, 3.0], tolerance=1e-12, solver="implicit")
    for tolerance in (1e-5, 1e-8, 1e-10):
        run = model.simulate(at=[0.4, 1.0, 3.0], tolerance=tolerance)
        assert run["b.s"] == pytest.approx(exact["b.s"], abs=3 * tolerance)
    if form != "logistic":
        assert model.simulate(at=[1.0], tolerance=1e-8, solver="taylor")["b.s"][0] == pytest.approx(exact["b.s"][1], abs=1e-8)


@pytest.mark.parametrize("n", [3, 9, 40])
@pytest.mark.parametrize("acceleration", ["0", "time/1[s]"])
def test_many_free_masses_fall_alike(n: int, acceleration: str, scene: Callable[[str], lag.Model]) -> None:
    """Their accelerations are one number, in loops over masses as one by one."""
    model = scene(f"""model M
      PointMass p[{n}](m = {{1 + j for j in 1:{n}}}, center(x(each start = 1), y(start = {{1[m]*j for j in 1:{n}}})));
      AppliedForce f[{n}](at = p.center, force = {{{{(1 + j)*1[N]*({acceleration}), 0}} for j in 1:{n}}});
    end M;""")
    for solver in ("auto", "erk", *(["taylor"] if acceleration == "0" else [])):  # many products are no series
        run = model.simulate(stop=2, interval=0.5, tolerance=1e-11, solver=solver)
        t = run.time
        for j in (1, n):
            np.testing.assert_allclose(run[f"p[{j}].center.y"], j - 9.81 * t**2 / 2, rtol=1e-12, atol=1e-12)
            np.testing.assert_allclose(run[f"p[{j}].center.x"], 1 + (t**3 / 6 if acceleration != "0" else 0 * t), rtol=1e-10)


@pytest.mark.parametrize("stop", [0.03, 0.07, 0.14, 0.23])
def test_ends_within_rounding_behind_a_break(scene: Callable[[str], lag.Model], stop: float) -> None:
    """10*0.07 is not 0.7: what was left of the run was no step, and it ended with "no step is small enough"."""
    run = scene("""model T Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {table(10[m/s]*time,
      {0.1[m]*k for k in 0:29}, {mod(7*k, 5)*1[N] for k in 0:29}), 0}); end T;""").simulate(stop=stop, solver="taylor")
    t, force = np.linspace(0, stop, 20_001), [(7 * k) % 5 for k in range(30)]
    f = np.interp(10 * t, 0.1 * np.arange(30), force)
    v = np.concatenate([[0], np.cumsum((f[1:] + f[:-1]) / 2 * np.diff(t))])
    assert run["b.v"][-1] == pytest.approx(v[-1], rel=1e-6)
