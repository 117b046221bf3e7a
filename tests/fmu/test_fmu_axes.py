"""Directional derivatives of FMUs where axes of hinges are parameters that lie along others: angles of theirs have none there."""

import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy.fmi1 import FMICallException

import lagrangia as lag
from lagrangia.fmu.importer import Importer

GIMBALS = """
model Gimbals
  World world(gravity = {0, 0, -9.81});
  Revolute outer(a = world, w(start = 0.2));
  Body ring(m = 2, I = {0.02, 0.015, 0.01}, center = outer.b);
  Revolute inner(a = outer.b, axis = {1, 0, 0}, phi(start = 60[deg]));
  Body cradle(m = 1, I = {0.004, 0.003, 0.006}, center = inner.b);
  Revolute spinning(a = inner.b, w(start = 150));
  Body rotor(m = 1.5, I = {0.002, 0.002, 0.0035}, center = shift(spinning.b, {0, 0, 0.02}));
end Gimbals;
"""


@pytest.mark.parametrize("version", ["2", "3"])
def test_states_and_masses_have_theirs(tmp_path: Path, version: str) -> None:
    """By an axis there is none, and that is answered: not a number that is none."""
    model = lag.loads(GIMBALS)
    (archive,) = model.export_fmu(tmp_path / "gimbals.fmu", fmi=version)
    zipfile.ZipFile(archive).extractall(tmp_path)
    importer = Importer(str(tmp_path), "ModelExchange")
    importer.initialise(0.0, 1.0, 1e-8, {}, lambda: None)

    def along(name: str) -> list[float]:
        """Derivatives of the accelerations."""
        variable, place, _ = importer.find(name)
        whole = int(np.prod(variable.shape or ()))
        seed = [float(k == place) for k in range(whole)]
        rates = [importer.find(f"der({rate})")[0].valueReference for rate in ("outer.w", "inner.w", "spinning.w")]
        return importer.along(rates, [variable.valueReference], seed, 3)

    q, v, p = np.array([0, np.pi / 3, 0]), np.array([0.2, 0, 150]), model.parameter_values()
    wanted = np.array(model.functions()["jacobian"](0, q, v, [], p))
    for k, name in enumerate(("outer.phi", "inner.phi", "spinning.phi", "outer.w", "inner.w", "spinning.w")):
        np.testing.assert_allclose(along(name), wanted[:, k], rtol=1e-9, atol=1e-9)
    by_parameters = np.array(model.derivatives()["jacobian_p"](0, q, v, [], p))
    for name in ("rotor.m", "inner.axis[2]"):
        wanted = by_parameters[:, model.parameter_names.index(name)]
        np.testing.assert_allclose(along(name), wanted, rtol=1e-9, atol=1e-9)
    with pytest.raises(FMICallException):
        along("outer.axis[1]")
