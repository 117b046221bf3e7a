"""`initial equation equilibrium();`: starts at rest by the parameters and inputs of each run, in sweeps and FMUs, too."""

from pathlib import Path

import fmpy
import numpy as np
import pytest
from scipy.optimize import brentq

import lagrangia as lag
from helpers.fmus import KINDS, VERSIONS, unpacked


def model(folder: Path, text: str) -> lag.Model:
    (folder / "scene.lag").write_text(f"model M\n{text}\ninitial equation\n  equilibrium();\nend M;")
    return lag.load(folder / "scene.lag")


HUNG = """  parameter Stiffness k = 40; input Force F;
  Prismatic g(a = world, along = {0, 1});
  PointMass p(m = 2, center = g.b);
  AxialSpring s(a = world, b = g.b, k = k, along = {0, 1});
  AppliedForce f(at = g.b, force = {0, F});"""


def test_loads_parameters_and_inputs_decide(tmp_path: Path) -> None:
    """s = (F - m g)/k, and it stays there."""
    scene = model(tmp_path, HUNG)
    run = scene.simulate(stop=1, parameters={"k": 50.0}, inputs={"F": 3.0})
    assert run["g.s"] == pytest.approx((3 - 2 * 9.81) / 50, abs=1e-13)
    run = scene.simulate(start=1, stop=2, inputs=([0, 2], {"F": [0, 6]}))
    assert run["g.s"][0] == pytest.approx((3 - 2 * 9.81) / 40, abs=1e-13)
    found = scene.simulate_many(parameters={"k": [20.0, 40.0, 80.0]}, outputs=["max(g.s)", "max(abs(g.v))"], stop=1)
    assert found["max(g.s)"] == pytest.approx(-2 * 9.81 / np.array([20.0, 40.0, 80.0]), abs=1e-13)
    assert max(found["max(abs(g.v))"]) < 1e-12


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_fmus(version: str, kind: str, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder = tmp_path_factory.mktemp("fmu")
    model(folder, HUNG)
    run = fmpy.simulate_fmu(str(unpacked(folder / "scene.lag", version)), fmi_type=kind, stop_time=1, step_size=0.1,
                            start_values={"k": 50.0, "F": 3.0}, output=["g.s", "der(g.s)"])
    assert run["g.s"] == pytest.approx((3 - 2 * 9.81) / 50, abs=1e-9)


def test_the_branch_nearest_to_the_guess(tmp_path: Path) -> None:
    """A pendulum in a spring: m g L/2 cos phi = -k phi has several solutions."""
    for guess in (-2.0, 1.4):
        scene = model(tmp_path, f"""  Revolute h(a = world, phi(start = {guess})); Bar b(m = 2, L = 1, a = h.b);
  TorsionSpring s(a = world, b = h.b, k = 1);""")
        run = scene.simulate(at=[0, 0.01])
        roots = [brentq(lambda phi: 9.81 * np.cos(phi) + phi, *ends) for ends in ((-2.5, -1), (1.5, 3))]
        assert run["h.phi"][0] == pytest.approx(min(roots, key=lambda x: abs(x - guess)), abs=1e-12)
        assert run["der(h.phi)"][0] == 0


def test_a_loop_and_states(tmp_path: Path) -> None:
    """As lag equilibrium has it; a filter is what it measures."""
    scene = model(tmp_path, """  Revolute o(a = world, phi(start = 1)), p(a = crank.b), q(a = rod.b);
  Revolute e(a = shift(world, {0.9, 0}), b = rocker.a);
  Bar crank(m = 1, L = 0.3, a = o.b), rod(m = 1, L = 1, a = p.b), rocker(m = 1, L = 0.8, b = q.b);
  TorsionSpring s(a = world, b = o.b, k = 8, phi_rel0 = 1.2);
  Sensor sensor(T = 0.1, u = o.phi);""")
    run = scene.simulate(stop=1)
    rest = scene.equilibrium()[0].position
    for name in ("o.phi", "p.phi", "e.phi"):
        assert run[name] == pytest.approx(rest[name], abs=1e-9)
    assert run["sensor.y"] == pytest.approx(rest["o.phi"], abs=1e-9)


def test_what_cannot_rest(tmp_path: Path) -> None:
    scene = model(tmp_path, """  Block b(m = 1, base = world);
  AppliedForce f(at = b.center, force = {1, 0});""")
    with pytest.raises(lag.LagError, match="L0606"):
        scene.simulate()
    with pytest.raises(lag.LagError, match="contacts may decide"):
        model(tmp_path, """  Prismatic g(a = world, along = {0, 1}, s(start = 1)); PointMass p(m = 1, center = g.b);
equation
  when g.s < 0 then reinit(g.v, -0.5*pre(g.v)); end when;""")
