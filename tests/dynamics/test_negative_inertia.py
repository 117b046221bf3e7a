"""Kinetic energies of people's own that are negative for some motion end a run, and say where they stand."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag

Write = Callable[[str], lag.Model]
ADDED = """model Added Block b(m = 1, base = world, s(start = 1));
  parameter Mass m = 2; parameter Real sign = -1; Spring k(k = 1, stretch = b.s);
energy
  kinetic sign*m*b.v^2/2; end Added;"""
PLACED = """model Placed World world(gravity = {0, 0}); coordinate Length x(start = 1), y(start = 0.3);
  parameter Mass m = 0.5;
energy
  kinetic (m + 1[kg/m]*x)*der(x)^2/2 + 1[kg]*der(y)^2/2 + 0.3[kg]*der(x)*der(y);
  potential 1[N/m]*x^2/2 + 1[N/m]*y^2; end Placed;"""
TIMED = """model Timed coordinate Length x(start = 1);
energy
  kinetic (1[kg] - 1[kg/s]*time)*der(x)^2/2; potential 1[N/m]*x^2/2; end Timed;"""


def test_what_takes_more_than_there_is(scene: Write) -> None:
    """-2 kg beside 1 kg; 2 kg with them are 3."""
    model = scene(ADDED)
    with pytest.raises(lag.RunError, match=r"kinetic energy that is negative for some motion \(.*:4:3\)"):
        model.simulate(stop=1)
    np.testing.assert_allclose(model.simulate(at=[2.0], parameters={"sign": 1})["b.s"], np.cos(2 / np.sqrt(3)), atol=1e-7)
    with pytest.raises(lag.RunError, match="kinetic energy"):
        model.modes()


@pytest.mark.parametrize("solver", ["auto", "erk5", "implicit"])
@pytest.mark.parametrize(("text", "parameters"), [(PLACED, {}), (PLACED, {"m": -2.0}), (TIMED, {})])
def test_what_comes_to_be_negative(text: str, parameters: dict[str, float], solver: str, scene: Write) -> None:
    """0.5 + x is 0.09 at x = -0.41; of the third, the mass is gone after a second."""
    model = scene(text.replace("Mass m", 'Real m(unit = "kg")'))
    with pytest.raises(lag.RunError, match="kinetic energy that is negative for some motion"):
        model.simulate(stop=3, solver=solver, parameters=parameters, initial={"x": 1.2} if text == PLACED else None)


def test_runs_of_a_sweep_fail_one_by_one(scene: Write) -> None:
    sweep = scene(ADDED).simulate_many(parameters={"sign": [-1.0, -0.25, 1.0]}, stop=1.0)
    assert list(sweep.failures) == [0]


@pytest.mark.parametrize(("n", "is_told"), [(60, False), (61, True)])
def test_scenes_that_are_too_large_to_look_at_are_told(n: int, is_told: bool, scene: Write) -> None:
    each = " ".join(f"kinetic 1[kg]*der(x{i})^2/2; potential 1[N/m]*x{i}^2;" for i in range(n))
    told = scene(f"model Many coordinate Length {', '.join(f'x{i}' for i in range(n))}; energy {each} end Many;").warnings
    assert any("L0745" in warning for warning in told) == is_told


def test_pages_functions_and_fmus_tell_it_as_runs_do(scene: Write, tmp_path: Path) -> None:
    """They wrote equations of -1 kg, gave accelerations and an FMU that cannot start."""
    model = scene(ADDED.replace("sign = -1", "sign = 1"))
    for write in (lambda given: model.equations(parameters=given, numbers=True),
                  lambda given: model.export_fmu(tmp_path / "added.fmu", parameters=given)):
        assert write({"sign": -0.25})
        with pytest.raises(lag.LagError, match=r"L0506(.|\n)*:4:3"):
            write({"sign": -1})
    rhs = model.functions(given="sign")["rhs"]
    for sign, right in ((-0.25, -2), (-1, np.nan)):
        found = float(rhs(0, 1, 0, [], model.parameter_values({"sign": sign})))
        np.testing.assert_allclose(found, right)
