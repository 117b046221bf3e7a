"""Rows of parallelograms that fold flat on their way, where each may open in two ways, at any tolerance."""

from contextlib import suppress
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import RunError
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
TOLERANCES = np.logspace(-3, -12, 37)


@pytest.mark.slow
@pytest.mark.parametrize("n", [2, 10, 100])
def test_flat_positions_are_passed_at_any_tolerance(n: int) -> None:
    """A step may end anywhere near them. Where rounding is magnified too much for the tolerance to be reached, the run goes on
    and says so."""
    model = lag.load(EXAMPLES / "n_four_bars.lag", n=n)
    exact = model.simulate(stop=2, interval=0.5, tolerance=1e-12)
    size = np.abs(exact.rows[:, 1 : 1 + 2 * model.scene.n]).max()
    for tolerance in TOLERANCES[:: 4 if n == 100 else 1]:
        run = model.simulate(stop=2, interval=0.5, tolerance=tolerance)
        error = np.abs((run.rows - exact.rows)[:, 1 : 1 + 2 * model.scene.n]).max() / size
        assert error < 10 * tolerance + 1e-10, f"at {tolerance:.1e}"
        assert (run.statistics.tolerance_missed > 0) == bool(run.warnings)


WHIP = """model Whip "a pendulum on a link passes a small magnet quickly; no position is singular"
  parameter Real mu(unit = "N.m2") = 0.05; parameter Length gap = 0.01;
  Link rod(L = 1, a = world, b = bob.center);
  PointMass bob(m = 1, center(x(start = 0.8, fixed = true), y(start = -0.6)));
  GeneralSpring magnet(a = shift(world, {0, -1 - gap}), b = bob.center, V = -mu/magnet.stretch);
  annotation(experiment(StopTime = 2));
end Whip;
model Hinged "the same with a hinge"
  parameter Real mu(unit = "N.m2") = 0.05; parameter Length gap = 0.01;
  Revolute hinge(a = world, phi(start = asin(0.8), fixed = true));
  PointMass bob(m = 1, center = shift(hinge.b, {0, -1}));
  GeneralSpring magnet(a = shift(world, {0, -1 - gap}), b = bob.center, V = -mu/magnet.stretch);
  annotation(experiment(StopTime = 2));
end Hinged;"""


@pytest.mark.parametrize("solver", ["erk", "erk5", "auto"])
@pytest.mark.parametrize(("gap", "mu"), [(0.003, 0.02), (0.005, 0.08), (0.006, 0.01), (0.01, 0.06), (0.02, 0.1)])
def test_quick_passages_are_no_singular_positions(gap: float, mu: float, solver: str, tmp_path: Path) -> None:
    path = tmp_path / "whip.lag"
    path.write_text(WHIP)
    how = {"interval": 0.1, "parameters": {"gap": gap, "mu": mu}}
    exact = lag.load(path, model="Hinged").simulate(tolerance=1e-13, solver="taylor", **how)["bob.center.x"]
    held = lag.load(path, model="Whip")
    for tolerance in np.logspace(-4, -12, 17):
        run = held.simulate(tolerance=tolerance, solver=solver, **how)
        assert np.abs(run["bob.center.x"] - exact).max() < 20 * tolerance + 1e-11, f"at {tolerance:.1e}"
        assert run.statistics.tolerance_missed == 0


def test_steep_friction_in_a_closed_loop(tmp_path: Path) -> None:
    """A crank that comes to rest again and again: its friction turns round within 0.1 ms, where nothing is singular. How well
    steps meet that is chance: of starts beside each other the median counts."""
    path = tmp_path / "rubs.lag"
    path.write_text("""model Rubs
  Revolute A(a = world, phi(start = 1.2)); Bar crank(m = 1, L = 1, a = A.b);
  Revolute B(a = crank.b); Bar coupler(m = 1, L = 2, a = B.b);
  Revolute C(a = shift(world, {2, 0})); Bar rocker(m = 1, L = 1.5, a = C.b);
  Revolute D(a = coupler.b, b = rocker.b);
  AppliedTorque friction(on = crank.a, torque = -0.6[N.m]*tanh(A.w/1e-3[rad/s]) - 0.05[N.m.s/rad]*A.w);
end Rubs;""")
    model, at, starts = lag.load(path), np.linspace(1, 12, 12), [{"A.phi": 1.2 + 1e-6 * k} for k in range(5)]
    exact = [model.simulate(solver="erk", tolerance=1e-12, at=at, initial=start)["A.phi"] for start in starts]
    for solver, tolerance, error in (("auto", 1e-5, 1e-4), ("auto", 1e-8, 1e-6), ("auto", 1e-10, 1e-7), ("erk5", 1e-8, 1e-6),
                                     ("implicit", 1e-10, 1e-8), ("implicit", 1e-12, 1e-9)):
        runs = [model.simulate(solver=solver, tolerance=tolerance, at=at, initial=start)["A.phi"] for start in starts]
        errors = [np.abs(run - known).max() for run, known in zip(runs, exact, strict=True)]
        assert np.median(errors) < error, f"{solver} at {tolerance}"


CHANGE_POINTS = """model ChangePoints "each turn these four bars lie in one line, where they could go two ways"
  parameter Length crank = 0.4, coupler = 1.2, rocker = 0.4, ground = 1.2;
  World world(gravity = {0, 0});
  Revolute A(a = world, phi(start = %s, fixed = true), w(start = 3, fixed = true)), B(a = b1.b, b = c.a), C(a = c.b, b = b2.b),
           D(a = shift(world, {ground, 0}), phi(start = %s));
  Bar b1(m = 1, L = crank, a = A.b), b2(m = 1, L = rocker, a = D.b), c(m = 1, L = coupler);
  annotation(experiment(StopTime = 10));
end ChangePoints;"""


@pytest.mark.parametrize("tolerance", [1e-6, 1e-9, 1e-12])
def test_a_crossed_parallelogram_turns_through_its_change_points(tmp_path: Path, tolerance: float) -> None:
    """Its reference: the quadrature of the energy, one equation on the crossed branch. Rounding is magnified where it lies flat,
    the more the shorter the steps are: of 16 speeds none ran through at 1e-12."""
    path = tmp_path / "crossed.lag"
    path.write_text(CHANGE_POINTS % (1.5, -1.5))
    run = lag.load(path).simulate(initial={"der(A.phi)": 2}, tolerance=tolerance, at=[0, 10], max_steps=5000)
    assert run["A.phi"][-1] == pytest.approx(21.388420288, abs=max(10 * tolerance, 5e-9))


def test_sweeps_pass_change_points_as_single_runs_do(tmp_path: Path) -> None:
    """Where one choice is lost another begins again a little before: by itself each loses 20 to 56 of 60 speeds at 1e-12."""
    path, speeds = tmp_path / "crossed.lag", np.linspace(2, 6, 12)
    path.write_text(CHANGE_POINTS % (1.5, -1.5))
    model, ends = lag.load(path), {}
    for tolerance in (1e-8, 1e-12):
        run, ends[tolerance] = model.prepare({"der(A.phi)": 2}, tolerance=tolerance, at=[0, 10]), np.full(12, np.nan)
        for k, speed in enumerate(speeds):
            with suppress(lag.RunError):
                row = run([speed])[-1]
                ends[tolerance][k] = np.nan if run.statistics.energy_is_open else row[run.columns.index("A.phi")]
    apart = np.abs(ends[1e-12] - ends[1e-8])
    assert np.isnan(apart).sum() <= 1 and np.nanmax(apart) < 1e-6


@pytest.mark.parametrize(("tolerance", "crank", "coupler", "rocker", "ground", "phi", "psi"), [
    (1e-9, 1, 0.5, 0.5, 1, 0.2, 2.5), (1e-9, 0.4, 0.7, 0.9, 1.2, 1.5, 1.8), (1e-12, 0.4, 0.7, 0.9, 1.2, 1.5, 1.8),
])
def test_kites_turn_through_their_change_points(tmp_path: Path, tolerance: float, crank: float, coupler: float, rocker: float,
                                                ground: float, phi: float, psi: float) -> None:
    path = tmp_path / "kite.lag"
    path.write_text(CHANGE_POINTS % (phi, psi))
    model = lag.load(path)
    lengths = {"crank": crank, "coupler": coupler, "rocker": rocker, "ground": ground}
    lost = []
    for speed in np.linspace(2, 6, 25):
        run = model.simulate(parameters=lengths, tolerance=tolerance, initial={"der(A.phi)": speed}, max_steps=10_000)
        lost.append(np.abs(run.energy.residual).max() / run.energy.total[0])
    assert np.median(lost) < max(tolerance, 3e-12)
    assert np.quantile(lost, 0.8) < 1e-8  # rounding decides at which speeds it is magnified more
    assert max(lost) < 1e-5


STOP = """model Stop
  parameter Real k = 1e3;
  Revolute A(a = world, phi(start = 1.2)); Bar crank(m = 1, L = 1, a = A.b);
  Revolute B(a = crank.b); Bar coupler(m = 1, L = 2, a = B.b);
  Revolute C(a = shift(world, {2, 0})); Bar rocker(m = 1, L = 1.5, a = C.b);
  Revolute D(a = coupler.b, b = rocker.b);
  AppliedTorque stop(on = crank.a, torque = k*1[N.m]*max(0, -1.5 - A.phi));
end Stop;"""
_EXACT: dict[float, np.ndarray] = {}  # by stiffness: 30 000 short steps each


@pytest.mark.parametrize(("k", "solver", "tolerance", "error"), [
    (10, "auto", 1e-9, 1e-6), (1e3, "auto", 1e-10, 1e-6), (1e3, "auto", 1e-12, 1e-7), (1e5, "auto", 1e-9, 1e-6),
    (1e5, "auto", 1e-12, 1e-6), (1e3, "erk5", 1e-8, 1e-5), (1e3, "erk5", 1e-12, 1e-6), (1e5, "erk5", 1e-12, 1e-6),
])
def test_a_stop_in_a_closed_loop(tmp_path: Path, k: float, solver: str, tolerance: float, error: float) -> None:
    """A torque that bends where nothing is singular: errors fall slowly there, and are none of rounding."""
    path, at = tmp_path / "stop.lag", np.linspace(0.25, 6, 24)
    path.write_text(STOP)
    model = lag.load(path)
    if k not in _EXACT:
        _EXACT[k] = model.simulate(parameters={"k": k}, solver="erk", tolerance=1e-13, max_step=2e-4, at=at)["A.phi"]
    run = model.simulate(parameters={"k": k}, solver=solver, tolerance=tolerance, at=at)
    assert np.abs(run["A.phi"] - _EXACT[k]).max() < error
    assert run.statistics.tolerance_missed == 0


def test_what_ends_where_all_choices_end_says_what_ended_it(tmp_path: Path) -> None:
    """1 mg between 398 g and 457 t: the account opened, every other choice stopped, and the run "stopped at t = 0: ok"."""
    path = tmp_path / "uneven.lag"
    path.write_text("""model Uneven
      World world(gravity = {0.05, -8.247});
      PointMass b1(m = 0.398); Link r1(L = 0.9819434810619194, a = shift(world, {-0.553, -0.959}), b = b1.center);
      PointMass b2(m = 1.02e-06); Link r2(L = 1.110531854563389, a = b1.center, b = b2.center);
      PointMass b3(m = 457000.0); Link r3(L = 0.7879086241436882, a = b2.center, b = b3.center);
    initial equation
      b1.center.x = 0.18999999999999995; b1.center.y = -0.31699999999999995; b2.center.x = 1.149; b2.center.y = -0.877;
      b3.center.x = 1.533; b3.center.y = -1.565;
    end Uneven;""", encoding="utf-8")
    model = lag.Model(path)
    model.native = False
    try:
        told = " ".join(model.simulate(tolerance=1e-12, at=[0, 0.25, 0.5, 0.75, 1]).warnings)
    except RunError as error:
        told = str(error)
    assert "account" in told or "the motion cannot be continued beyond t = 0.576" in told
