"""Functions and exports of scenes with attitudes: quaternions among the positions, integrated by others."""

import runpy
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

import lagrangia as lag
from lagrangia.command.cli import main

SCENE = """
model Two
  World world(gravity = {0, 0, -9.81});
  Prismatic slide(a = world, along = {1, 0, 0}, s(start = 0.1));
  PointMass cart(m = 1, center = slide.b);
  Spherical tip(a = slide.b, S(start = angles("zxz", 0, 0.4, 0)), w(start = {0, 0.3, 2}));
  Body top(m = 0.5, I = {0.0008, 0.0011, 0.001}, center = shift(tip.b, {0, 0.02, 0.1}));
  Body satellite(m = 2, I = {0.1, 0.2, 0.25}, center(r(start = {1, 2, 0}), omega(start = {0.01, 1, 0.02})));
  output Length height = top.center.z;
  annotation(experiment(StopTime = 0.5, Tolerance = 1e-10));
end Two;
"""


@pytest.fixture(scope="module")
def file(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("exports") / "two.lag"
    path.write_text(SCENE)
    return path


def runge_kutta(slope, y: np.ndarray, stop: float, steps: int) -> np.ndarray:
    h = stop / steps
    for k in range(steps):
        a = slope(k * h, y)
        b, c = slope((k + 0.5) * h, y + h / 2 * a), None
        c = slope((k + 0.5) * h, y + h / 2 * b)
        y = y + h / 6 * (a + 2 * b + 2 * c + slope((k + 1) * h, y + h * c))
    return y


def test_python_moves_as_the_native_run(file: Path, tmp_path: Path) -> None:
    assert main(["export", str(file), "--to", "python", "-o", str(tmp_path / "two.py")]) == 0
    module = runpy.run_path(str(tmp_path / "two.py"))
    model = lag.load(file)
    names = [*model.position_names, *(rate.name for rate in model.scene.rates)]
    assert module["COORDINATES"] == list(model.position_names) and len(module["START"]) == 22
    native = model.simulate(at=[0.0, 0.5], tolerance=1e-12)
    assert module["START"] == pytest.approx([native[name][0] for name in names], abs=1e-15)
    found = runge_kutta(module["slope"], module["START"], 0.5, 1000)
    assert found == pytest.approx([native[name][1] for name in names], abs=1e-9)


def test_functions_know_quaternions_of_any_length(file: Path, tmp_path: Path) -> None:
    model = lag.load(file)
    functions, p = model.functions(), model.parameter_values()
    run = model.simulate(at=[0.3], stop=0.5)
    q, v = (np.array([run[c.name][0] for c in columns]) for columns in (model.scene.told_positions, model.scene.rates))
    longer = q.copy()
    places = [model.position_names.index(f"tip.S[{k}]") for k in range(1, 5)]
    longer[places] *= 1.7
    M, h, rhs, jacobian = (functions[name] for name in ("M", "h", "rhs", "jacobian"))
    a = rhs(0, q, v, [], p).full().ravel()
    assert M(0, q, v, [], p).full() @ a + h(0, q, v, [], p).full().ravel() == pytest.approx(0, abs=1e-12)
    assert rhs(0, longer, v, [], p).full().ravel() == pytest.approx(a, abs=1e-11)
    slopes = jacobian(0, q, v, [], p).full()
    assert slopes.shape == (10, 22) and slopes[:, places] @ q[places] == pytest.approx(0, abs=1e-10)
    for k in (*places, len(q) + 2):
        step = 1e-6 * (np.arange(22) == k)
        ends = [rhs(0, q + side * step[:12], v + side * step[12:], [], p).full().ravel() for side in (-1, 1)]
        assert (ends[1] - ends[0]) / 2e-6 == pytest.approx(slopes[:, k], abs=1e-6 * np.abs(slopes).max())
    assert functions["outputs"](0, q, v, [], p).full().ravel()[-1] == pytest.approx(run["height"][0], abs=1e-14)
    assert main(["export", str(file), "--to", "casadi", "-o", str(tmp_path / "two.casadi")]) == 0
    unpacker = ca.FileDeserializer(str(tmp_path / "two.casadi"))
    table, names = {f.name(): f for f in unpacker.unpack()}, unpacker.unpack()
    assert names["q"] == list(model.position_names)
    assert table["turning"](0, q, v, [], p).full().ravel()[0] == v[0]


def test_integrators_of_casadi_have_quaternions(file: Path) -> None:
    model = lag.load(file)
    start = {"tip.S": [1, 0.2, 0, 0.1]}
    native, other = (model.simulate(at=[0.0, 0.25, 0.5], initial=start, tolerance=1e-11, solver=solver)
                     for solver in ("auto", "casadi:cvodes"))
    for column in (*model.scene.told_positions, *model.scene.rates, *model.scene.own_outputs):
        assert other[column.name] == pytest.approx(native[column.name], abs=2e-8), column.name
    assert np.abs(other.energy.residual).max() < 1e-8


LOOP = """
model Loop "a body on a ball joint whose tip hangs on a rod"
  World world(gravity = {0, 0, -9.81});
  Spherical joint(a = world, S(start = axis_angle({1, 2, 0}, 0.4)), w(start = {0.5, 1, 2}));
  Body body(m = 2, I = {0.1, 0.2, 0.25}, center = shift(joint.b, {0.3, 0, 0.4}));
  Link rod(L = 1.1, a = shift(joint.b, {0.6, 0, 0.8}), b = shift(world, {1.2, 0.3, 0.2}));
end Loop;
"""


@pytest.mark.parametrize("name", ["two", "loop"])
def test_modelica_has_eulers_equations_and_quaternions(name: str, file: Path, tmp_path: Path,
                                                       capsys: pytest.CaptureFixture[str]) -> None:
    """rumoca integrates them: two attitudes in a tree, one in a loop whose rod and quaternion stay of their lengths."""
    rumoca = pytest.importorskip("rumoca")
    scene = file if name == "two" else tmp_path / "loop.lag"
    if name == "loop":
        scene.write_text(LOOP)
    assert main(["export", str(scene), "--to", "modelica", "-o", "-"]) == 0
    text, model = capsys.readouterr().out, lag.load(scene)
    shown = {line.split()[1].partition("(")[0]: line.rpartition('"')[0].rpartition('"')[2]
             for line in text.splitlines() if "fixed = true" in line}
    assert len(shown) == len(model.scene.told_positions) + model.scene.n
    run = rumoca.Session().loads(text, model=model.name).simulate(t=(0.0, 0.4), dt=0.2,
                                                                  config=rumoca.SimConfig(rtol=1e-11, atol=1e-11))
    found = np.array(run.to_numpy(list(shown)))
    wanted = model.simulate(at=np.linspace(0, 0.4, found.shape[1]), tolerance=1e-12)
    for row, source in zip(found, shown.values(), strict=True):
        assert np.abs(row - wanted[source]).max() < 1e-7, source
