"""Long runs: chaos to the digit that can be known, 100 000 turns, a million periods, resonance, 1e-9 to 1e9 s."""

import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml
from scipy.special import ellipk

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.solvers import applicable

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Scene = Callable[[str], lag.Model]
ROOT = Path(__file__).resolve().parent.parent
EXAMPLES = ROOT.parent / "models" / "examples"
EPS = np.finfo(float).eps
SOLVERS = ("auto", "erk", "adams", "implicit", "taylor", "conservative")


def those_of(model: lag.Model, *names: str) -> list[str]:
    """The solvers among `names` that can run the model."""
    return [name for name in names if name == "auto" or name in applicable(model.scene)]


@pytest.fixture(scope="module")
def pendulum() -> lag.Model:
    return lag.load(EXAMPLES / "pendulum.lag")


# ---------------------------------------------------------------- chaos


def chaos() -> tuple[lag.Model, np.ndarray, np.ndarray]:
    """The chaotic double pendulum of tests/cases: the model, times to 50 s, and its outputs in 20 digits."""
    model = lag.load(ROOT / "cases" / "double_pendulum_chaotic.lag")
    kept = yaml.safe_load((ROOT / "cases" / "double_pendulum_chaotic.yaml").read_text())["runs"]["DoublePendulum"]
    known = [row for row in kept if float(row["t"]) <= 50]
    names = [column.name for column in model.scene.outputs]
    return model, np.array([float(row["t"]) for row in known]), np.array([[float(row[name]) for name in names] for row in known])


@pytest.mark.parametrize("solver", ["auto", "erk", "adams", "implicit", "taylor"])
def test_chaos_to_the_predictable_digit(solver: str) -> None:
    """Errors grow by exp(1.06 t/s), a digit in 2.2 s: rounding at the start is eps exp(1.06 t/s) later, 1e-2 at 30 s and all
    there is at 50 s. A run at 1e-14 knows every digit that this leaves, and its energy is right beyond."""
    model, times, exact = chaos()
    if solver not in those_of(model, solver):
        pytest.skip(f"{solver} does not run this scene")
    run = model.simulate(at=times, tolerance=1e-14, solver=solver)
    error = np.abs(np.column_stack([run[column.name] for column in model.scene.outputs]) - exact).max(axis=1)
    predictable = times <= 30
    assert np.count_nonzero(predictable) == 4
    assert np.all(error[predictable] < 2 * EPS * np.exp(1.06 * times[predictable]))
    assert error[-1] > 1e-2  # it is chaos
    assert run.statistics.energy_residual < 1e-11 * run.statistics.energy_scale
    assert run.warnings == []


# ---------------------------------------------------------------- a million periods, many turns


def period(model: lag.Model, amplitude: float) -> float:
    """Of the mathematical pendulum, L = 1 m, s: 4 sqrt(L/g) K(sin^2(amplitude/2))."""
    assert model.scene.name == "Pendulum"
    return float(4 * math.sqrt(1 / 9.81) * ellipk(math.sin(amplitude / 2) ** 2))


def swing(model: lag.Model, periods: float, solver: str, tolerance: float) -> tuple[float, float, lag.Trajectory]:
    """Errors after so many periods from 1 rad: of the phase, in radians of a cycle, and of the energy, relative."""
    stop = periods * period(model, 1.0)
    run = model.simulate(at=[0, stop / 2, stop], tolerance=tolerance, solver=solver, initial={"hinge.phi": 1.0})
    assert np.isfinite(run.rows).all()
    depth = 9.81 * (1 - math.cos(1))
    fastest = math.sqrt(2 * depth)
    phase = math.atan2(run["der(hinge.phi)"][-1] / fastest, run["hinge.phi"][-1])
    return abs(phase), abs(run.energy.residual[-1]) / depth, run


@pytest.mark.parametrize("solver", SOLVERS)
def test_ten_thousand_periods(solver: str, pendulum: lag.Model) -> None:
    if solver not in those_of(pendulum, solver):
        pytest.skip(f"{solver} does not run this scene")
    phase, energy, _ = swing(pendulum, 1e4, solver, 1e-12)
    assert phase < (1e-5 if solver == "implicit" else 1e-6)
    assert energy < (1e-8 if solver == "implicit" else 1e-10)


@pytest.mark.slow
@pytest.mark.parametrize("solver", SOLVERS)
def test_a_million_periods(solver: str, pendulum: lag.Model) -> None:
    if solver in ("erk", "implicit", "adams") or solver not in those_of(pendulum, solver):
        pytest.skip(f"{solver} does not run this scene, or far too long")  # ten thousand are asked of all
    phase, energy, _ = swing(pendulum, 1e6, solver, 1e-9 if solver == "conservative" else 1e-12)
    assert phase < 2e-2
    assert energy < 1e-8


CAUGHT = """model Caught "A pendulum that a catch would stop, far above where it swings to"
  extends Pendulum;
equation
  when hinge.phi > 3 then reinit(der(hinge.phi), 0); end when;
end Caught;
"""


def test_errors_that_add_up_are_told(tmp_path: Path, pendulum: lag.Model) -> None:
    """Ten thousand periods at 1e-4 are far from where they should be. Beside events, where steps do not become stricter for what
    energies miss, the run says so."""
    phase, energy, _ = swing(pendulum, 1e4, "erk", 1e-4)
    assert phase > 1e-2 and energy < 1e-3
    scene = tmp_path / "caught.lag"
    scene.write_text((EXAMPLES / "pendulum.lag").read_text() + CAUGHT)
    run = lag.load(scene).simulate(at=[0, 1e4, 2e4], tolerance=1e-5, solver="erk", initial={"hinge.phi": 1.0})
    assert any("errors have added up" in text for text in run.warnings)
    assert swing(pendulum, 10, "erk", 1e-8)[2].warnings == []


@pytest.mark.parametrize(("turns", "tolerance", "error"), [
    (1e3, 1e-8, 1e-3), (-1e3, 1e-8, 1e-3), (1e3, 1e-12, 1e-7), (-1e5, 1e-12, 1e-3)])
def test_many_turns(turns: float, tolerance: float, error: float, pendulum: lag.Model) -> None:
    """Past pi 100 000 times: at 20 rad/s below, a turn takes 4 K(4 g/w^2)/w, and the angle counts them all."""
    w = math.copysign(20.0, turns)
    stop = turns * 4 / w * float(ellipk(4 * 9.81 / w**2))
    run = pendulum.simulate(at=[0, stop / 3, stop], tolerance=tolerance, initial={"hinge.phi": 0.0, "der(hinge.phi)": w})
    assert run["hinge.phi"][-1] == pytest.approx(2 * math.pi * turns, abs=error)
    assert run["der(hinge.phi)"][-1] == pytest.approx(w, rel=1e-6)


def test_the_turn_it_is_in_does_not_matter(scene: Scene) -> None:
    """A chain that starts 100 000 turns away, in some of its hinges, moves as the one at home."""
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    names, at = model.coordinate_names, np.linspace(0, 2, 9)
    home = model.simulate(at=at, tolerance=1e-9)
    away = model.simulate(at=at, tolerance=1e-9, initial={
        name: home[name][0] + 2 * math.pi * k for name, k in zip(names, (100_000, -3), strict=True)})
    for name, k in zip(names, (100_000, -3), strict=True):
        assert away[name] - 2 * math.pi * k == pytest.approx(home[name], abs=1e-7)
    assert abs(away.statistics.steps - home.statistics.steps) < 0.1 * home.statistics.steps


# ---------------------------------------------------------------- resonance

RESONANCE = """model Resonance
  parameter Real w(unit = "1/s") = 1, k = 1;
  coordinate Real x, y;
energy
  kinetic der(x)^2/2 + der(y)^2/2;
  potential k*x^2/2 + y^2/2 + y^4/4;
  work sin(w*time) on x;
end Resonance;
"""


@pytest.mark.parametrize("solver", ["auto", "erk", "adams", "implicit", "taylor"])
@pytest.mark.parametrize("w", [1e-3, 1.0, 1e3])
def test_resonance_grows_linearly(solver: str, w: float, scene: Scene) -> None:
    """x'' + w^2 x = sin w t from rest: x = (sin w t - w t cos w t)/(2 w^2), right to 10 digits after 500 periods; beside it
    rests something nonlinear, so that no exact solver takes the scene."""
    model = scene(RESONANCE)
    if solver not in those_of(model, solver):
        pytest.skip(f"{solver} does not run this scene")
    t = np.linspace(0, 1000 * math.pi / w, 101)
    run = model.simulate(at=t, tolerance=1e-13, solver=solver, parameters={"w": w, "k": w**2})
    exact = (np.sin(w * t) - w * t * np.cos(w * t)) / (2 * w**2)
    assert np.abs(run["x"] - exact).max() < 1e-10 * np.abs(exact).max()
    half = np.abs(run["x"][: 51]).max() / np.abs(run["x"]).max()
    assert half == pytest.approx(0.5, abs=1e-3)


# ---------------------------------------------------------------- horizons


@pytest.mark.parametrize("second", [1e-9, 1e-6, 1e6, 1e9])
@pytest.mark.parametrize("solver", ["auto", "adams", "implicit", "taylor"])
def test_horizons(second: float, solver: str) -> None:
    """The same motion in 3e-9 s and in 3e9 s: gravity is as much stronger or weaker; the same steps and digits."""
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    if solver not in those_of(model, solver):
        pytest.skip(f"{solver} does not run this scene")
    at = np.linspace(0, 3, 13)
    usual = model.simulate(at=at, tolerance=1e-10, solver=solver)
    run = model.simulate(at=at * second, tolerance=1e-10, solver=solver, parameters={"world.gravity[2]": -9.81 / second**2})
    for name in model.coordinate_names:
        assert run[name] == pytest.approx(usual[name], abs=1e-9)
        assert run[f"der({name})"] * second == pytest.approx(usual[f"der({name})"], abs=1e-8)
    assert abs(run.statistics.steps - usual.statistics.steps) <= 0.05 * usual.statistics.steps


@pytest.mark.parametrize("stop", [1e-9, 1e-6, 1e-3])
def test_a_moment(stop: float, pendulum: lag.Model) -> None:
    """From the horizontal, w = -g t until the rod has turned."""
    run = pendulum.simulate(stop=stop, tolerance=1e-10)
    assert run.time[-1] == stop
    assert run["der(hinge.phi)"][1:] == pytest.approx(-9.81 * run.time[1:], rel=1e-9)


@pytest.mark.parametrize("solver", ["auto", "implicit"])
def test_a_damped_pendulum_rests_for_thirty_years(solver: str, scene: Scene) -> None:
    model = scene("""model Rests
  Revolute hinge(a = world, phi(start = 1)); Bar bar(m = 1, L = 1, a = hinge.b);
  TorsionDamper d(a = world, b = bar.center, c = 0.5);
end Rests;""")
    run = model.simulate(stop=1e9, tolerance=1e-9, solver=solver, interval=1e8)
    assert run["hinge.phi"][1:] == pytest.approx(-math.pi / 2, abs=1e-12)
    assert np.abs(run["der(hinge.phi)"][1:]).max() < 1e-12
    assert run.statistics.steps < 5_000
    assert run.energy.dissipated[-1] == pytest.approx(-run.energy.total[-1] + run.energy.total[0], rel=1e-8)
