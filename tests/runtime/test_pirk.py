"""Iterated collocation: its coefficients, the same digits however it is evaluated, rows inside steps, and when auto takes it."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from helpers.native_models import FOLDER, compiled, started
from lagrangia.native.build import find_compiler
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Solver, Status
from runtime.test_stiffness import FLEXIBLE

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Write = Callable[[str], lag.Model]
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
RARE = """model Rare "A chain that is moved by the rarer functions, and a disc that has turned a million times"
  Revolute one(a = world, phi(start = 0.5)), two(a = upper.b, w(start = 2));
  Bar upper(m = 1, L = 1, a = one.b), lower(m = 1, L = 0.7, a = two.b);
  Revolute axle(a = world, phi(start = 2e6), w(start = 3)); Disc disc(m = 1, r = 1, center = axle.b);
  Real x = upper.b.x/1[m], y = lower.b.y/1[m];
  AppliedTorque
    far(on = disc.center, torque = 1[N.m]*cos(axle.phi)),
    others(on = lower.center, torque = 1[N.m]*(atan2(x, 2 + y) + log(3 + x)*asin(x/4) + (2 + y)^0.3 + sqrt(3 + x*y) - tan(y/9)
           + cosh(x/3) + tanh(x) + exp(y/5) + acos(x/5)*atan(y))),
    both(on = upper.center, torque = 1[N.m]*(if time < 0.7 then sinh(y) + two.phi^3/9 else -x));
end Rare;"""
FOLDING = """model Folding "A parallelogram that falls through its flat position again and again"
  Revolute E(a = shift(world, {5, 0}), phi(start = 0.3)); Bar left(m = 1, L = 1, a = E.b);
  Revolute F(a = shift(world, {7, 0})); Bar right(m = 1, L = 1, a = F.b);
  Revolute G(a = left.b); Bar link(m = 0.5, L = 2, a = G.b);
  Revolute H(a = link.b, b = right.b);
  AppliedTorque hardly(on = left.a, torque = 1e-9*sin(1[rad/s]*time));
end Folding;"""


def tables(name: str) -> np.ndarray:
    text = (FOLDER / "methods" / "pirk_tableau.h").read_text()
    body = re.search(rf"lag_pirk_{name}(?:\[[\w +]+\])+ = \{{(.*?)\}};", text, re.S)
    assert body
    numbers = np.array([float(x) for x in re.findall(r"-?\d+\.\d+(?:e-?\d+)?", body[1])])
    return numbers.reshape(-1, 8) if len(numbers) == 64 else numbers


def positions(model: lag.Model, **settings: object) -> tuple[np.ndarray, lag.Trajectory]:
    run = model.simulate(**settings)  # type: ignore[arg-type]
    return run.rows[:, 1 : 1 + model.scene.n], run


def test_tables_integrate_polynomials() -> None:
    """To degree 7 at the stages, to degree 15 (positions: 14) at the end; and with 16 nodes to degree 31."""
    c, rate, place, end = tables("node"), tables("rate").T, tables("place").T, tables("end")
    for k in range(8):
        np.testing.assert_allclose(rate @ c**k, c ** (k + 1) / (k + 1), rtol=1e-13, atol=1e-17)
        np.testing.assert_allclose(place @ c**k, c ** (k + 2) / ((k + 1) * (k + 2)), rtol=1e-13, atol=1e-17)
        basis = np.prod([c[k] - c[j] for j in range(8) if j != k])
        assert tables("basis")[k] == pytest.approx(1 / basis, rel=1e-13)
    for k in range(16):
        assert end[:, 1] @ c**k == pytest.approx(1 / (k + 1), rel=1e-14)
        assert k == 15 or end[:, 0] @ c**k == pytest.approx(1 / ((k + 1) * (k + 2)), rel=1e-14)
    for column, degree in zip((2, 3, 4, 5, 6, 7), (7, 6, 3, 2, 5, 4), strict=True):
        legendre = np.polynomial.Legendre.basis(degree)(2 * c - 1)
        np.testing.assert_allclose(end[:, column], (2 * degree + 1) * end[:, 1] * legendre, atol=2e-15)
    node, weight = tables("dense_node"), tables("dense_weight")
    for k in range(32):
        assert weight @ node**k == pytest.approx(1 / (k + 1), rel=1e-14)


def test_one_step_is_exact_for_polynomials(runtime: Runtime) -> None:
    """At its end, and inside it."""
    model = compiled(1, rhs="a[0] = 1 - 30 * pow(t, 4) + 182 * pow(t, 12);")
    with started(runtime, model, [0], [0], t_stop=1, tolerance=1e3, first_step=1, solver=Solver.PIRK) as run:
        rows = run.advance([0.3, 0.8, 1.0])
        assert rows.status is Status.OK
        assert run.statistics.steps <= 5  # the first one is a tenth at most
    for t, q, v in (rows[k][:3] for k in range(3)):
        assert q == pytest.approx(t**2 / 2 - t**6 + t**14, rel=1e-13)
        assert v == pytest.approx(t - 6 * t**5 + 14 * t**13, rel=1e-13)


@pytest.mark.parametrize(("text", "sizes"), [(RARE, {}), ("chain", {"n": 3}), ("andrews_squeezer", {}), ("four_bar", {})])
def test_tapes_and_native_code_have_the_same_digits(scene: Write, text: str, sizes: dict[str, int]) -> None:
    """Also one state after another, as the scene without its wide code has it."""
    def rows(is_native: bool, solver: str) -> tuple[list[list[float]], lag.Trajectory]:
        model = scene(text) if text == RARE else lag.load(EXAMPLES / f"{text}.lag", **sizes)
        model.native = is_native
        run = model.simulate(stop=0.03 if text == "andrews_squeezer" else 1.0, interval=0.01, tolerance=1e-9, solver=solver)
        return run.rows.tolist(), run

    (tape, _), (native, run) = rows(False, "pirk"), rows(True, "pirk")
    assert tape == native
    assert run.statistics.solver is Solver.PIRK
    np.testing.assert_allclose(native, rows(True, "erk")[0], rtol=0, atol=1e-7 * np.abs(native).max())


def test_rows_that_repeat_each_other_are_evaluated_abreast() -> None:
    """Bricard's six-bar, where the way of independent rows is in doubt for good: as one state after another, natively and on
    tapes. Planar loops, where no row repeats others but for a moment, pay nothing for it."""
    model, plain, planar = (lag.load(EXAMPLES / f"{name}.lag") for name in ("bricard", "bricard", "four_bar"))
    for each in (model, planar):
        each.native = True
    plain.native = False
    run, tape = (each.simulate(at=[0, 1], tolerance=1e-8, solver="pirk") for each in (model, plain))
    assert run.rows.tolist() == tape.rows.tolist()
    known = model.simulate(at=[0, 1], tolerance=1e-13, solver="erk")
    assert run.rows[-1, 1:7] == pytest.approx(known.rows[-1, 1:7], abs=1e-8)
    planar.simulate(stop=0.1)
    assert model.engine.model.struct.wide_whole and not planar.engine.model.struct.wide_whole


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6])
def test_sweeps_that_ran_away_foresee_nothing(tolerance: float) -> None:
    """Bricard's six-bar: after a step far too long shorter ones began with what its sweeps had come to, and their sweeps
    ran away the farther the shorter they were, until Runge-Kutta steps took over."""
    model = lag.load(EXAMPLES / "bricard.lag")
    model.native = False
    run, known = (model.simulate(at=[0, 2], tolerance=x, solver=solver) for x, solver in ((tolerance, "auto"), (1e-12, "erk9")))
    assert run.statistics.steps_by[Solver.PIRK] == run.statistics.steps
    assert run.rows[-1, 1:7] == pytest.approx(known.rows[-1, 1:7], abs=tolerance)


def test_a_step_far_too_long_is_no_sign_of_a_singular_position() -> None:
    """Bricard's six-bar, 10 s: a step at which sweeps came nearer, but whose error was 844, was left to Runge-Kutta steps, with
    all to come, at four of these tolerances: errors of 1e-9 in place of 1e-12."""
    model = lag.load(EXAMPLES / "bricard.lag")
    model.native = False
    known = model.simulate(at=[0, 10], tolerance=1e-13, solver="pirk")
    for tolerance in (4e-10, 6.3e-10, 8e-10, 1e-9):
        run = model.simulate(at=[0, 10], tolerance=tolerance)
        assert run.statistics.steps_by[Solver.PIRK] == run.statistics.steps
        assert run.rows[-1, 1:7] == pytest.approx(known.rows[-1, 1:7], abs=1e-11)


@pytest.mark.parametrize(("name", "stop", "sizes"), [
    ("double_pendulum", 2, {}), ("pendulum", 10, {}), ("spring_pendulum", 5, {}), ("chain", 1, {"n": 17}), ("four_bar", 2, {}),
    ("andrews_squeezer", 0.03, {}), ("suspended_bar", 5, {}), ("slider_crank", 1, {})])
def test_a_tolerance_means_what_it_does_elsewhere(name: str, stop: float, sizes: dict[str, int]) -> None:
    """In rows as well, which lie inside steps. Eight evaluations at once take about as long as one or two."""
    model = lag.load(EXAMPLES / f"{name}.lag", **sizes)
    at = np.linspace(stop / 100, stop, 100)
    exact, _ = positions(model, at=at, tolerance=1e-14, solver="erk")
    size = np.abs(exact).max()
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10, 1e-12):
        found, run = positions(model, at=at, tolerance=tolerance, solver="pirk")
        few, _ = positions(model, at=at[[-1]], tolerance=tolerance, solver="pirk")
        others, other = positions(model, at=at, tolerance=tolerance, solver="erk")
        assert run.statistics.solver is Solver.PIRK
        assert np.abs(found - exact).max() < max(10 * tolerance * size, 3 * np.abs(others - exact).max())
        assert np.array_equal(few[-1], found[-1])
        assert run.statistics.energy_residual < max(100 * tolerance, 1e-13) * run.statistics.energy_scale
        assert run.statistics.rhs_evaluations / 8 < 0.9 * other.statistics.rhs_evaluations


def test_auto_takes_it_where_nothing_needs_others(scene: Write) -> None:
    def taken(model: lag.Model, tolerance: float = 1e-6, rows: int = 3) -> Solver:
        run = model.simulate(at=np.linspace(0, 0.5, rows), tolerance=tolerance)
        assert run.statistics.switches == 0
        return run.statistics.solver

    chain, crank, pair = (lag.load(EXAMPLES / f"{name}.lag") for name in ("chain", "slider_crank", "double_pendulum"))
    assert {taken(chain), taken(crank), taken(pair), taken(chain, 1e-12), taken(chain, rows=100)} == {Solver.PIRK}
    assert taken(chain, rows=5000) is Solver.ERK  # many rows in each step
    assert taken(pair, rows=500) is Solver.TAYLOR
    assert taken(lag.load(EXAMPLES / "chain.lag", n=25), rows=20_000) is Solver.ADAMS
    assert Solver.PIRK not in (taken(chain, 1e-2), taken(crank, 1e-3))  # steps as long as errors would allow are too long
    assert taken(lag.load(EXAMPLES / "bricard.lag"), 1e-2) is Solver.PIRK  # long equations of few coordinates
    assert taken(lag.load(EXAMPLES / "scissor_lift.lag"), 1e-2) is not Solver.PIRK  # so are these, but it swings back
    assert taken(lag.load(EXAMPLES / "spring_pendulum.lag")) is Solver.TAYLOR  # what vibrates
    assert taken(lag.load(EXAMPLES / "four_bar.lag"), rows=5000) is Solver.PIRK  # its steps are kept: it may swing back
    assert taken(scene(RARE)) is not Solver.PIRK  # what may be narrow within a step


@pytest.mark.parametrize("tolerance", [1e-4, 1e-5, 1e-6, 1e-7, 1e-8, 1e-9, 1e-10, 1e-11, 1e-12])
def test_singular_positions_are_left_to_others(scene: Write, tolerance: float) -> None:
    model = scene(FOLDING)
    run = model.simulate(at=[1, 20], tolerance=tolerance)
    assert model.simulate(at=[0.05], stop=0.05, tolerance=tolerance).statistics.solver is Solver.PIRK
    assert run.statistics.solver is Solver.ERK
    assert run.statistics.energy_residual < 1e3 * tolerance * run.statistics.energy_scale
    assert run.statistics.constraint_residual < 1e-13


def test_stiff_scenes_are_left_to_implicit_steps(scene: Write) -> None:
    model = scene(FLEXIBLE)
    exact, _ = positions(model, at=[0.5, 1], tolerance=1e-11, solver="implicit")
    found, run = positions(model, at=[0.5, 1], tolerance=1e-6)
    assert run.statistics.solver is Solver.IMPLICIT
    assert run.statistics.rhs_evaluations < 10_000
    assert np.abs(found - exact).max() < 1e-5


@pytest.mark.parametrize("tolerance", [1e-4, 1e-6, 1e-9])
def test_segments_of_a_few_steps_add_no_error(scene: Write, tolerance: float) -> None:
    """Each row of a table of inputs begins anew, where nobody knows how quickly sweeps come nearer: 160 tolerances off, once."""
    model = scene("""model Driven
      input Torque M;
      Revolute h[3]; Bar l[3](each m = 1, each L = 0.5);
      AppliedTorque drive(on = l[1].center, torque = M);
    equation
      connect(world, h[1].a);
      for i in 1:3 loop connect(h[i].b, l[i].a); end for;
      for i in 1:2 loop connect(l[i].b, h[i+1].a); end for;
    end Driven;""")
    t = np.linspace(0, 2, 201)
    inputs = (t.tolist(), {"M": np.sin(7 * t).tolist()})
    exact, _ = positions(model, at=[1, 2], tolerance=1e-13, inputs=inputs, solver="erk")
    found, run = positions(model, at=[1, 2], tolerance=tolerance, inputs=inputs)
    assert run.statistics.solver is Solver.PIRK and run.statistics.events == 199
    assert np.abs(found - exact).max() < 10 * tolerance


@pytest.mark.parametrize("force", ["tanh(x)", "x/sqrt(1 + x^2)", "2/pi*atan(x)"])
def test_layers_narrower_than_stages_are_apart_are_seen(scene: Write, force: str) -> None:
    """Friction rubbed smooth within 1 mm/s: of 100 tolerances each, 6, 5 and 5 were off by more than 100 and up to 6e6."""
    model = scene(f"""model Layer
      Block b(m = 1, base = world, s(start = 1)); Spring spring(a = world, b = b.center, k = 4, s_rel0 = 0);
      Real x = b.v/0.001[m/s]; AppliedForce rub(at = b.center, force = {{-0.3[N]*({force}), 0}});
    end Layer;""")
    assert model.scene.sizes["may_be_narrow"] and not lag.load(EXAMPLES / "andrews_squeezer.lag").scene.sizes["may_be_narrow"]
    exact, _ = positions(model, at=[1, 2, 3, 4, 5], tolerance=1e-13, solver="erk9")
    for tolerance in np.logspace(-4, -11, 30):
        found, run = positions(model, at=[1, 2, 3, 4, 5], tolerance=float(tolerance), solver="pirk")
        assert np.abs(found - exact).max() < 100 * tolerance and not run.statistics.energy_is_open
