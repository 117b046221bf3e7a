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


def test_what_bounces_beside_light_rods_does_not_stick() -> None:
    """A step that ended just before the impact had rates told apart by 0.2 m/s, as rounding of positions in so short a step, and
    the block stayed at its stop: 0.851 m for 0.727 with erk at 1e-6 and pirk at 1e-9, without a word."""
    scene = lag.loads("""model Beside World world(gravity = {-0.668, -7.143});
      Prismatic j1(a = shift(world, {0.114, -0.767}), along = {0.6325152699855466, -0.7745478895685606}, s(start = 0.367),
                   v(start = 0.351));
      PointMass b1(m = 2.116, center = j1.b);
      Stop c0(a = shift(world, {0.14021251236884374, -1.3918478449685339}), b = j1.b,
              along = {0.5173884213966127, 0.8557506771278193}, e = 0.5);
      Stop c1(a = shift(world, {0.5286497794368765, -0.9984607495665103}), b = j1.b,
              along = {-0.9606140808009522, -0.2778859258165868}, e = 0.8);
      PointMass b2(m = 1.1e-05); Link r2(L = 0.7370861550727974, a = shift(world, {0.956, -0.925}), b = b2.center);
      PointMass b3(m = 1030); Link r3(L = 0.37768902552232053, a = b2.center, b = b3.center);
      PointMass b4(m = 2.3e-05); Link r4(L = 0.7594537510605895, a = b3.center, b = b4.center);
    initial equation
      b2.center.x = 1.692; b2.center.y = -0.965; b3.center.x = 2.06; b3.center.y = -0.88;
      b4.center.x = 2.629; b4.center.y = -1.383;
    end Beside;""")
    scene.native = False
    for solver, tolerance in (("erk", 1e-6), ("erk", 9e-7), ("pirk", 1e-9)):
        found = scene.simulate(solver=solver, tolerance=tolerance, at=[1])
        assert found["j1.s"][-1] == pytest.approx(0.727365224489, abs=1e-8)
