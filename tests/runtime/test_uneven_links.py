"""Links between masses a thousand to a thousand million times apart, and supports that shake: what steps learn of sizes, and
when they take errors for rounding."""

from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

RODS = """model Rods "a double pendulum of points on links"
  PointMass P1(m = 0.001), P2(m = 1000);
  Link r1(L = 1, a = world, b = P1.center), r2(L = 1, a = P1.center, b = P2.center);
  output Length rod1 = distance(world, P1.center), rod2 = distance(P1.center, P2.center);
initial equation
  P1.center.x = 1; P1.center.y = 0; P2.center.x = 1; P2.center.y = -1;
  annotation(experiment(StopTime = 2));
end Rods;
model Kapitza "a pendulum on a link whose support shakes; it starts at rest"
  Frame pivot = shift(world, {0, 0.03*cos(250*time)});
  PointMass P(m = 1);
  Link rod(a = pivot, b = P.center, L = 1);
initial equation
  P.center.x = 1[m]*sin(2.8); P.center.y = 0.03[m] - 1[m]*cos(2.8); P.center.v[1] = 0;
  annotation(experiment(StopTime = 1));
end Kapitza;"""
# P2 at 2 s, by SciPy's DOP853 at 2e-14 on the equations of the double pendulum in its angles.
RIGHT = {1e3: (-0.252403642106681, -1.933072160711239), 1e6: (-0.251189497519, -1.938291307789)}


@pytest.fixture(scope="module")
def scenes(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("links") / "links.lag"
    path.write_text(RODS)
    return path


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "erk9", "adams", "pirk", "implicit"])
def test_uneven_masses_on_links(scenes: Path, solver: str) -> None:
    """Where both links lie in line the light mass passes within 1e-6 s. Steps that ran away told sizes: rods of 9 m."""
    model = lag.load(scenes, model="Rods")
    for ratio, right in RIGHT.items():
        for tolerance in (1e-3, 1e-4, 1e-5, 1e-6, 1e-8, 1e-12):
            run = model.simulate(solver=solver, tolerance=tolerance, at=[0, 0.5, 1, 2], parameters={"P1.m": 1000 / ratio})
            error = np.hypot(run["P2.center.x"][-1] - right[0], run["P2.center.y"][-1] - right[1])
            assert error < 20 * tolerance + 1e-9, f"{ratio:.0e} at {tolerance}"
            assert np.abs(np.array([run["rod1"], run["rod2"]]) - 1).max() < 1e-14


@pytest.mark.parametrize("solver", ["auto", "erk", "erk5", "erk9", "adams", "pirk", "implicit"])
def test_a_shaken_start_from_rest_is_no_singular_position(scenes: Path, solver: str) -> None:
    """By SciPy's DOP853 at 3e-14 on the equation of its angle. Nothing moves at first, which says nothing."""
    model = lag.load(scenes, model="Kapitza")
    for tolerance in (1e-5, 1e-8, 1e-11, 1e-12, 1e-13):
        run = model.simulate(solver=solver, tolerance=tolerance, at=[0, 1])
        assert run["P.center.x"][-1] == pytest.approx(-0.1879703992528, abs=10 * tolerance + 1e-12)
        assert run.statistics.tolerance_missed == 0
