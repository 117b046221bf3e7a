"""Other importers: fmutool, ecos, CMake by FMPy, CasADi; and what an FMU is called, made of and exported from."""

import importlib.util
import shutil
import subprocess
import sys
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")

import fmpy

import lagrangia as lag
from helpers.broken_fmus import broken
from helpers.fmus import EXAMPLES, VERSIONS, fmu_of, model_of, simulated, unpacked
from lagrangia.fmu.check import check_fmu

CASADI = ("chain", "suspended_bar", "quarter_car", "rolling_disc", "four_bar", "skate")
LOOPS = ("four_bar", "slider_crank", "pantograph", "crank_press")


@pytest.mark.skipif(importlib.util.find_spec("fmu_manipulation_toolbox") is None, reason="needs fmu-manipulation-toolbox")
@pytest.mark.parametrize("version", VERSIONS)
def test_fmutool_has_nothing_to_say(version: str) -> None:
    tool = Path(sys.executable).parent / "fmutool"
    done = subprocess.run([tool, "-input", fmu_of(EXAMPLES / "suspended_bar.lag", version), "-check"], capture_output=True,
                          text=True, check=True)
    said = done.stdout + done.stderr
    assert "seems to be compliant" in said and "No semantic error" in said


@pytest.mark.parametrize("version", VERSIONS)
def test_ecos_steps_it(version: str) -> None:
    try:
        import ecospy
    except (ImportError, OSError):
        pytest.skip("ecospy, or its libtbb, is not installed")
    path = EXAMPLES / "four_bar.lag"
    with ecospy.EcosSimulationStructure() as structure:
        structure.add_model("m", str(fmu_of(path, version)))
        with ecospy.EcosSimulation(step_size=0.005, structure=structure) as simulation:
            simulation.init()
            simulation.step(200)
            names = [c.name for c in model_of(path).scene.coordinates]
            found = [simulation.get_real(f"m::{name}") for name in names]
    native = model_of(path).simulate(at=[1.0], stop=1)
    np.testing.assert_allclose(found, [native[name][0] for name in names], atol=1e-7)


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("cmake") is None or shutil.which("gcc") is None, reason="needs cmake and gcc")
@pytest.mark.parametrize("version", VERSIONS)
def test_sources_compile_elsewhere(version: str, tmp_path: Path) -> None:
    """By FMPy's CMake project, without our binary; what it makes has no fault, and moves as the native run does.

    Without optimisation, which takes most of the time and which our own binaries have in other tests."""
    good = fmu_of(EXAMPLES / "pendulum.lag", version)
    binaries = [name for name in zipfile.ZipFile(good).namelist() if name.startswith("binaries/")]
    target = broken(good, tmp_path / "x.fmu", dict.fromkeys(binaries))
    subprocess.run([sys.executable, "-m", "fmpy", "compile", str(target), "--configuration", "Debug"], check=True,
                   capture_output=True)
    checked = check_fmu(target, lag.Model)
    assert not checked.faults and not checked.has_failed and len(checked.told) == 2


@pytest.mark.parametrize("name", CASADI)
def test_casadi_has_the_same_jacobian(name: str) -> None:
    """States and Jacobian of the slopes by the FMU's exact derivatives, at the start, against those by parts of them."""
    ca = pytest.importorskip("casadi")
    path = EXAMPLES / f"{name}.lag"
    dae = ca.DaeBuilder("model", str(unpacked(path, "3", arrays=False)), {"debug": False})  # which knows no arrays
    scene = model_of(path).scene
    assert len(dae.x()) == 2 * scene.n
    if scene.sizes["n_multipliers"]:
        return  # its slopes lead back to the constraints: tests/fmu/test_fmu_api.py compares them with differences
    f = dae.create("f", ["t", "x", "u", "p"], ["ode"])
    start = model_of(path).simulate(at=[scene.start]).rows[0][1 : 1 + 2 * scene.n]
    order = [dae.x().index(state) for state in _states(path)]
    x = np.zeros(2 * scene.n)
    x[order] = start
    arguments = [scene.start, x, [dae.get(known) for known in dae.u()], [dae.get(known) for known in dae.p()]]
    jacobian = np.array(ca.densify(f.factory("J", f.name_in(), ["jac:ode:x"])(*arguments)))[np.ix_(order, order)]
    u = [p.value or 0.0 for p in scene.inputs]
    model = model_of(path)
    place = scene.start, start[: scene.n], start[scene.n :], u, model.parameter_values()
    expected = np.array(model.functions()["jacobian"](*place))
    size = max(1.0, float(np.abs(expected).max()))
    np.testing.assert_allclose(jacobian[scene.n :], expected, atol=1e-10 * size)
    np.testing.assert_allclose(jacobian[: scene.n], np.eye(2 * scene.n)[scene.n :], atol=1e-14)


def _states(path: Path) -> list[str]:
    return [u.variable.derivative.name for u in fmpy.read_model_description(str(fmu_of(path, "3", arrays=False))).derivatives]


@pytest.mark.parametrize("name", LOOPS)
def test_loops_stay_closed_in_an_importers_solver(name: str) -> None:
    """Below 1e-6 of the size of the mechanism over 10 s, by CVode at 1e-8."""
    path = EXAMPLES / f"{name}.lag"
    scene = model_of(path).scene
    names = [c.name for c in scene.coordinates]
    found = simulated(path, "2", "ModelExchange", names, stop_time=10, output_interval=0.02)
    constraints, p = model_of(path).functions()["Phi"], model_of(path).parameter_values()
    u = np.zeros(len(scene.inputs))
    v = np.zeros(scene.n)
    residual = max(np.abs(np.array(constraints(row["time"], [row[n] for n in names], v, u, p))).max() for row in found)
    assert residual < 1e-6 * max(p.value or 0.0 for p in scene.parameters if p.unit == "m")


# ---------------------------------------------------------------- names, places, nothing to tell


def test_models_of_one_name_in_two_folders(tmp_path: Path) -> None:
    """They are two FMUs, and each carries the files that it was made from, as they lie to each other."""
    found = []
    for folder, mass in (("a", 1), ("b", 2)):
        (tmp_path / folder / "parts").mkdir(parents=True)
        (tmp_path / folder / "parts" / "scene.lag").write_text(f"model Arm extends Bar(m = {mass}, L = 1); end Arm;")
        (tmp_path / folder / "scene.lag").write_text(
            'import "parts/scene.lag"; import "../shared/scene.lag";\n'
            "model Scene Revolute h(a = world, phi(start = 1)); Arm arm(a = h.b); Drag d(a = world, b = h.b); end Scene;")
        (tmp_path / "shared").mkdir(exist_ok=True)
        (tmp_path / "shared" / "scene.lag").write_text("model Drag extends TorsionDamper(c = 0.1); end Drag;")
        (path,) = lag.load(tmp_path / folder / "scene.lag").export_fmu(tmp_path / f"{folder}.fmu")
        found.append(path)
        names = [n for n in zipfile.ZipFile(path).namelist() if n.endswith(".lag")]
        start = "extra/io.github.lagrangia"
        assert sorted(names) == [f"{start}/{folder}/parts/scene.lag", f"{start}/{folder}/scene.lag", f"{start}/shared/scene.lag"]
        checked = check_fmu(path, lag.Model)
        assert not checked.faults and not checked.has_failed and "of the native run" in checked.told[0][0]
    one, other = (fmpy.read_model_description(str(path)) for path in found)
    assert one.modelName == other.modelName == "Scene" and one.guid != other.guid
    together = [fmpy.simulate_fmu(str(path), stop_time=1, output=["h.phi", "energy.total"])["energy.total"][0] for path in found]
    assert together[1] == pytest.approx(2 * together[0])


@pytest.mark.parametrize("text", [
    "model M coordinate Length s(start = 1); energy kinetic 1[kg]*der(s)^2/2; potential 3[N/m]*s^2/2; end M;",
    'model \'a "b" \\\\ <&> ä\' Block p(m = 1, base = world, along = {1, 0}, s(start = 1)); Spring s(k = 3, stretch = p.s); '
    'output Length y = p.s "is < 1 & > -1: \\"quoted\\""; end \'a "b" \\\\ <&> ä\';',
], ids=["no parameters of its own", "odd names"])
def test_odd_scenes_have_no_fault(text: str, tmp_path: Path) -> None:
    (tmp_path / "sc ene ü.lag").write_text(text, encoding="utf-8")
    for path in lag.load(tmp_path / "sc ene ü.lag").export_fmu(tmp_path / "x.fmu", fmi="both"):
        checked = check_fmu(path, lag.Model)
        assert not checked.faults, [d.message for d in checked.faults]
        assert not checked.has_failed and "of the native run" in checked.told[1][0], checked.told
