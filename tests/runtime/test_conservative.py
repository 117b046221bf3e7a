"""Symplectic steps: order, bounded energy error over many periods, and who may take them."""

import re
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.base.folders import data_folder
from lagrangia.run.runtime import Solver

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
CASES = Path(__file__).parents[1] / "cases"
CALM = {"shoulder.phi": 0.5, "elbow.phi": 0.3}


def tableaux() -> list[dict[str, np.ndarray]]:
    """The rows of gauss_tableau.h as arrays."""
    text = (data_folder("runtime") / "methods" / "gauss_tableau.h").read_text()
    body = text[text.index("LAG_GAUSS[] = {") :]
    numbers = [float(x) for x in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", body.split("=", 1)[1])]
    found = []
    while numbers:
        s = int(numbers.pop(0))
        sizes = {"c": s, "b": s, "low": s, "a": s * s, "start": s * s}
        parts = {}
        for name, size in sizes.items():
            parts[name], numbers = np.array(numbers[:size]), numbers[size:]
        found.append({name: x.reshape(s, s) if x.size == s * s and name in ("a", "start") else x for name, x in parts.items()})
    return found


@pytest.mark.parametrize("tableau", tableaux(), ids=lambda t: f"{t['b'].size} stages")
def test_the_coefficients(tableau: dict[str, np.ndarray]) -> None:
    """Order 2 s of the quadrature, order s of the stages, symplecticity, and continuation of polynomials of degree s - 1."""
    a, b, c, s = tableau["a"], tableau["b"], tableau["c"], tableau["b"].size
    for k in range(1, 2 * s + 1):
        assert b @ c ** (k - 1) == pytest.approx(1 / k, abs=1e-15)
    for k in range(1, s + 1):
        assert a @ c ** (k - 1) == pytest.approx(c**k / k, abs=1e-15)
        assert tableau["start"] @ c ** (k - 1) == pytest.approx((1 + c) ** (k - 1), rel=1e-9)
    assert np.abs(b[:, None] * a + (b[:, None] * a).T - np.outer(b, b)).max() < 1e-16
    assert np.abs(tableau["low"]).max() < 1e-16


@pytest.mark.parametrize(("name", "initial"), [("pendulum", {}), ("double_pendulum", CALM), ("spring_pendulum", {})])
def test_it_agrees_with_runge_kutta(name: str, initial: dict[str, float]) -> None:
    model = lag.load(EXAMPLES / f"{name}.lag")
    at = np.linspace(0, 3, 61)[1:]
    exact = model.simulate(at=at, tolerance=1e-14, initial=initial, solver="erk").rows
    for tolerance in (1e-4, 1e-8, 1e-12):
        run = model.simulate(at=at, tolerance=tolerance, initial=initial, solver="conservative")
        assert run.statistics.solver is Solver.CONSERVATIVE
        states = slice(1, 1 + 2 * model.scene.n)
        size = np.abs(exact[:, states]).max(axis=0)
        assert (np.abs(run.rows - exact)[:, states].max(axis=0) < 100 * tolerance * size + 1e-12).all()


@pytest.mark.parametrize(("name", "order"), [("pendulum", 6), ("double_pendulum", 8)])
def test_the_order(name: str, order: int) -> None:
    """Halving the steps of the splitting divides the error by 2^6, of Gauss collocation with four stages by 2^8."""
    model, initial = lag.load(EXAMPLES / f"{name}.lag"), CALM if name == "double_pendulum" else {}
    exact = model.simulate(at=[2.0], tolerance=1e-14, initial=initial, solver="erk").rows[0, 1 : 1 + model.scene.n]
    errors = []
    for h in (0.08, 0.04) if name == "pendulum" else (0.01, 0.005):
        run = model.simulate(at=[2.0], tolerance=1e-5, max_step=h, initial=initial, solver="conservative")
        assert run.statistics.steps == round(2 / h)
        errors.append(np.abs(run.rows[0, 1 : 1 + model.scene.n] - exact).max())
    assert order - 0.7 < np.log2(errors[0] / errors[1]) < order + 0.7


@pytest.mark.parametrize(("name", "initial", "stop", "tolerance", "bound"), [
    ("pendulum", {}, 2000, 1e-5, 1e-5), ("pendulum", {}, 2000, 1e-11, 1e-11), ("spring_pendulum", {}, 1000, 1e-6, 1e-6),
    ("double_pendulum", CALM, 1000, 1e-7, 1e-7), pytest.param("pendulum", {}, 2e6, 1e-8, 1e-8, marks=pytest.mark.slow),
])
def test_the_energy_error_stays(name: str, initial: dict[str, float], stop: float, tolerance: float, bound: float) -> None:
    """What it is in the first tenth of the run it is in the last, within a factor that no drift would keep."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    run = model.simulate(stop=stop, interval=stop / 2000, tolerance=tolerance, initial=initial, solver="conservative")
    residual = np.abs(run.energy.residual) / run.statistics.energy_scale
    assert residual.max() < bound
    assert residual[-200:].max() < 4 * residual[:200].max()


def test_steps_are_explicit_where_masses_are_constant() -> None:
    kept = {name: lag.load(EXAMPLES / f"{name}.lag").scene for name in ("pendulum", "double_pendulum", "suspended_bar")}
    assert {name: scene.sizes["is_separable"] for name, scene in kept.items()} == {
        "pendulum": 1, "double_pendulum": 0, "suspended_bar": 0}
    assert {name for name, scene in kept.items() if "velocity" in scene.tapes} == {"double_pendulum"}


@pytest.mark.parametrize("tolerance", [1e-4, 1e-7, 1e-10])
def test_the_energy_error_is_what_was_asked_for(tolerance: float) -> None:
    """Of explicit steps: no more, and not less by far, which would have cost steps."""
    model = lag.load(CASES / "gni_fermi_pasta_ulam.lag")
    run = model.simulate(stop=200.0, interval=0.5, tolerance=tolerance, solver="conservative")
    error = np.abs(run.energy.residual).max() / run.statistics.energy_scale
    assert tolerance / 20 < error < 1.5 * tolerance


def test_rows_do_not_change_the_steps() -> None:
    model = lag.load(EXAMPLES / "pendulum.lag")
    many, few = (model.simulate(at=at, solver="conservative") for at in (np.linspace(0, 10, 1001)[1:], [10.0]))
    assert many.rows[-1, 1] == few.rows[-1, 1]
    assert many.statistics.steps == few.statistics.steps


def test_time_runs_backwards() -> None:
    """Symmetry: from the end, with reversed rates, the motion goes back to where it began."""
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    there = model.simulate(at=[3.0], tolerance=1e-5, max_step=0.01, initial=CALM, solver="conservative").rows[0]
    initial = {"shoulder.phi": there[1], "elbow.phi": there[2], "der(shoulder.phi)": -there[3], "der(elbow.phi)": -there[4]}
    back = model.simulate(at=[3.0], tolerance=1e-5, max_step=0.01, initial=initial, solver="conservative").rows[0]
    assert back[1:3] == pytest.approx(list(CALM.values()), abs=1e-8)


@pytest.mark.parametrize(("file", "reason"), [
    ("suspended_bar", "d1 takes energy out"), ("disc_and_block", "drive puts energy in"),
    ("quarter_car", "takes energy out"), ("four_bar", "not supported yet with constraints"), ("cart_pole", "push puts energy in"),
])
def test_who_does_not_keep_energy_is_told(file: str, reason: str) -> None:
    with pytest.raises(LagError, match=reason):
        lag.load(EXAMPLES / f"{file}.lag").simulate(solver="conservative")


def test_an_edge_of_the_potential_ends_the_run(scene: Callable[[str], lag.Model]) -> None:
    """The force has no value beyond 1 rad: steps of 1e-30 s were taken without end."""
    model = scene("""model Edge parameter Real k(unit = "J") = 1; World world(gravity = {0, 0});
      Revolute g(a = world, phi(start = 1, fixed = true)); Disc m(m = 1, r = 1, center = g.b);
      initial equation der(g.phi) = 1; energy potential k*(1 - g.phi)^2.5; end Edge;""")
    with pytest.raises(lag.RunError, match="no step is small enough"):
        model.simulate(stop=1, solver="conservative")
