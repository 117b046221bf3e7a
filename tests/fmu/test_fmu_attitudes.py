"""FMUs of scenes with attitudes: unit quaternions as states, whose length no importer has to keep."""

from pathlib import Path

import numpy as np
import pytest

from helpers.fmus import KINDS, VERSIONS, Instance, model_of, reported, simulated

SCENE = """
model Two
  parameter Angle tilt = 0.4;
  input Torque push = 0.02;
  World world(gravity = {0, 0, -9.81});
  Prismatic slide(a = world, along = {1, 0, 0}, s(start = 0.1));
  PointMass cart(m = 1, center = slide.b);
  Spherical tip(a = slide.b, S(start = angles("zxz", 0, tilt, 0)), w(start = {0, 0.3, 2}));
  Body top(m = 0.5, I = {0.0008, 0.0011, 0.001}, center = shift(tip.b, {0, 0.02, 0.1}));
  Damper rub(a = top.center, b = world, c = 0.2);
  Body satellite(m = 2, I = {0.1, 0.2, 0.25}, center(r(start = {1, 2, 0}), omega(start = {0.01, 1, 0.02})));
  energy work {0, push, 0} on satellite.center.attitude;
  output Length height = top.center.z;
  output Real[3, 3] R = satellite.center.R;
  annotation(experiment(StopTime = 2, Tolerance = 1e-9));
end Two;
"""
Q = [f"satellite.center.S[{k}]" for k in range(1, 5)]
TIP = [f"tip.S[{k}]" for k in range(1, 5)]


@pytest.fixture(scope="module")
def two(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("attitudes") / "two.lag"
    path.write_text(SCENE)
    return path


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", KINDS)
def test_motion_and_account_are_those_of_the_native_run(two: Path, kind: str, version: str) -> None:
    """The residual of the account is an error of the importer's, as large as those of its states."""
    names = [*reported(two), "energy.residual", "energy.dissipated", "energy.work"]
    found = simulated(two, version, kind, names, relative_tolerance=1e-12)
    native = model_of(two).simulate(at=found["time"], tolerance=1e-12)
    for name in reported(two):
        np.testing.assert_allclose(found[name], native[name], atol=1e-8, rtol=0)
    for name in ("dissipated", "work"):
        np.testing.assert_allclose(found[f"energy.{name}"], native[f"energy.{name}"], atol=1e-8, rtol=0)
    assert native["energy.dissipated"][-1] > 0.05
    assert np.abs(found["energy.residual"]).max() < 1e-8


def test_the_length_of_a_quaternion_says_nothing_and_decays(two: Path) -> None:
    """dQ/dt = P (0, w)/2 + k (P - Q) with P = Q/|Q|, k = 100/(stop - start)."""
    instance = Instance(two, "3", "ModelExchange").start()
    names = instance.state_names()
    places = [names.index(name) for name in Q]
    x, outputs = np.array(instance.states()), [f"R[{i},{j}]" for i in (1, 2, 3) for j in (1, 2, 3)]
    before, shown = instance.slopes(), instance.get(*outputs)
    longer = x.copy()
    longer[places] *= 1.01
    instance.set_states(longer)
    np.testing.assert_allclose(instance.get(*outputs), shown, atol=1e-15)
    pull = np.zeros(len(x))
    pull[places] = -50 * 0.01 * x[places]
    np.testing.assert_allclose(instance.slopes(), before + pull, atol=1e-13)
    w = [0.01, 1, 0.02]
    np.testing.assert_allclose(before[places], 0.5 * np.array([0.0, *w]), atol=1e-15)
    longer[places] = 0
    with pytest.raises(Exception, match=r"status 2"):
        instance.set_states(longer)
    instance.free()


@pytest.mark.parametrize("kind", KINDS)
def test_starts_of_attitudes_are_set_and_those_of_parameters_are_not(two: Path, kind: str) -> None:
    instance = Instance(two, "2", kind)
    given = {variable.name: variable.initial for variable in instance.description.modelVariables}
    assert {given[name] for name in TIP} == {"calculated"}
    assert {given[name] for name in Q} == {"exact"}
    turned = [np.cos(0.3), 0.0, -2 * np.sin(0.3), 0.0]  # is made one, and its real part is not negative
    instance.start({**dict(zip(Q, [-np.cos(0.3), 0.0, np.sin(0.3), 0.0], strict=True)), "tilt": 0.6})
    np.testing.assert_allclose(instance.get(*TIP), [np.cos(0.3), np.sin(0.3), 0, 0], atol=1e-15)
    turned[2] /= 2
    np.testing.assert_allclose(instance.get(*Q), turned, atol=1e-15)
    instance.fmu.reset()
    instance.set(dict.fromkeys(Q, 0.0))
    with pytest.raises(Exception, match="status 3"):
        instance.start()
    instance.fmu.freeInstance()
