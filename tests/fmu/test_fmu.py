"""FMUs of all examples, in FMPy: valid, and the same motion as that of `lag simulate`."""

import zipfile
from pathlib import Path

import casadi as ca
import numpy as np
import pytest

pytest.importorskip("fmpy")

import fmpy
from fmpy.validation import validate_fmu

import lagrangia as lag
from helpers.fmus import EXAMPLES, EXPORTED, KINDS, VERSIONS, fmu_of, model_of, reported, simulated
from lagrangia.command.cli import main
from lagrangia.fmu.check import check_fmu
from lagrangia.fmu.variables import build_fmu_model

# Each scene with one version of the standard: what differs between them does not depend on the scene.
EXPORTS = [(path, VERSIONS[k % 2]) for k, path in enumerate(EXPORTED)]
NAMES = [f"{path.stem}-{version}" for path, version in EXPORTS]
# Far apart after a while, whatever the solver: the time up to which two runs are compared, in s.
CHAOTIC = {"double_pendulum": 3, "chain": 2, "n_four_bars": 2, "spring_pendulum": 3, "pantograph": 3, "parallelogram": 2,
           "four_bar": 2, "slider_crank": 1}


@pytest.mark.parametrize(("path", "version"), EXPORTS, ids=NAMES)
def test_fmpy_has_nothing_to_say(path: Path, version: str) -> None:
    assert validate_fmu(str(fmu_of(path, version))) == []


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize(("path", "version"), EXPORTS, ids=NAMES)
def test_the_motion_is_that_of_the_native_run(path: Path, kind: str, version: str) -> None:
    model = model_of(path)
    scene = model.scene
    names = reported(path)
    stop = min(scene.stop, CHAOTIC.get(path.stem, scene.stop))
    # CVode's own error, from step to step, is a hundred times its tolerance after a while.
    tolerance = 1e-8 if kind == "CoSimulation" else 1e-10
    found = simulated(path, version, kind, names, stop_time=stop, step_size=stop / 100, output_interval=stop / 100,
                      relative_tolerance=tolerance)
    is_last = np.append(np.diff(found["time"]) > 0, True)  # of two rows at an event the second one
    before, found = found[np.append(True, is_last[:-1])], found[is_last]  # outputs may jump there: then one of them agrees
    native = model.simulate(stop=stop, at=found["time"], tolerance=1e-9)
    assert found["time"][-1] == pytest.approx(stop, rel=1e-12)
    groups = {column.unit for column in scene.told_positions}
    size = {unit: max(np.abs(native[c.name]).max() for c in scene.told_positions if c.unit == unit) for unit in groups}
    for column in (*scene.told_positions, *scene.own_outputs):
        scale = max(np.abs(native[column.name]).max(), size.get(column.unit, 0.0), 1.0 if column.unit == "rad" else 1e-6)
        error, other = (np.abs(rows[column.name] - native[column.name]) for rows in (found, before))
        assert (np.minimum(error, other) if column in scene.own_outputs else error).max() < 1e-6 * scale, column.name


def test_into_a_folder(tmp_path: Path) -> None:
    written = lag.load(EXAMPLES / "pendulum.lag").export_fmu(tmp_path, fmi="both")
    assert written == [tmp_path / "Pendulum_fmi2.fmu", tmp_path / "Pendulum_fmi3.fmu"]
    assert all(path.stat().st_size for path in written)


def test_what_stands_still_has_no_rounding_for_a_nominal_value(tmp_path: Path) -> None:
    (tmp_path / "truss.lag").write_text("""model Truss
      Link l1(L = 1, a = world, b = p.center), l2(L = 1.2, a = shift(world, {1, 0}), b = p.center);
      PointMass p(m = 2, center(x(start = 0.3), y(start = 0.8)));
      AppliedForce f(at = p.center, force = {3*time, 1});
    end Truss;""")
    assert build_fmu_model(lag.load(tmp_path / "truss.lag")).nominal == (0.1, 0.1, 1.0, 1.0)


def test_a_locked_linkage_has_no_rounding_for_a_nominal_value() -> None:
    """Its start is found to 4e-12 rad/s, which was the size of its rates: CVode made 4e6 evaluations a second of it."""
    model = lag.loads("""model Locked
  World world(gravity = {0, 0, -9.81});
  Revolute turning(a = world, phi(start = 0), w(start = 8));
  Body crank(m = 1, I = {0.001, 0.02, 0.02}, center = shift(turning.b, {0.15, 0, 0}));
  Prismatic slide(a = world, along = {1, 0, 0}, s(start = 1.4));
  Body block(m = 1.5, I = {0.001, 0.05, 0.05}, center = slide.b);
  Universal near(a = shift(turning.b, {0.3, 0, 0}));
  Body rod(m = 2, I = {0.002, 0.2, 0.2}, center = shift(near.b, {0.55, 0, 0}));
  Spherical far(a = shift(near.b, {1.1, 0, 0}), b = slide.b);
  Real i(start = 1.5);
  AppliedTorque motor(on = crank.center, torque = {0, 0, 0.6*i});
equation
  0.05*der(i) = 12 - 2*i - 0.6*turning.w;
end Locked;""")
    assert min(build_fmu_model(model).nominal) >= 1


def test_a_scene_without_c_names_and_one_at_rest(tmp_path: Path) -> None:
    """Blanks, accents, 300 characters; no states; no parameters."""
    texts = {
        "'Größe mit Blanks'": "Block p(m = 1, base = world, along = {1, 0}); Spring s(k = 3, stretch = p.s + 0.1);",
        "N" * 300: "Revolute h(a = world); Bar b(m = 1, L = 1, a = h.b);",
        "Still": "Weld clamp(a = world); Bar b(m = 1, L = 1, a = clamp.b); output Force F[2] = clamp.reaction;",
    }
    for name, body in texts.items():
        (tmp_path / "scene.lag").write_text(f"model {name} {body} end {name};", encoding="utf-8")
        for path in lag.load(tmp_path / "scene.lag").export_fmu(tmp_path / "x.fmu", fmi="both"):
            assert validate_fmu(str(path)) == []
            for kind in KINDS:
                fmpy.simulate_fmu(str(path), fmi_type=kind, stop_time=0.5)


def test_equal_input_gives_equal_bytes(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("SOURCE_DATE_EPOCH", "1700000000")
    model = model_of(EXAMPLES / "pendulum.lag")
    (one,), (other,) = (model.export_fmu(tmp_path / f"{k}.fmu", fmi="3") for k in range(2))
    assert one.read_bytes() == other.read_bytes()
    assert b"2023-11-14T22:13:20Z" in zipfile.ZipFile(one).read("modelDescription.xml")


def test_nothing_of_the_standard_is_inside(tmp_path: Path) -> None:
    """Sources are complete but for the headers of the standard, which are not ours to give away."""
    for version in VERSIONS:
        names = zipfile.ZipFile(fmu_of(EXAMPLES / "pendulum.lag", version)).namelist()
        assert not [name for name in names if name.endswith(("Functions.h", "FunctionTypes.h", "Platform.h", "PlatformTypes.h"))]
        assert "sources/scene.c" in names and "sources/buildDescription.xml" in names


def test_what_cannot_be_exported_is_said(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    file = str(EXAMPLES / "pendulum.lag")
    for options in (["--fmi", "1"], ["--kind", "xx"], ["--platforms", "amiga"], ["--info", "color=red"], ["-p", "m=-1"],
                    ["-p", "nothing=1"], ["--no-sources", "--platforms", ""], ["-o", "/nowhere/at/all.fmu"]):
        assert main(["export", file, "--to", "fmu", *options]) == 2
        assert "error[L" in capsys.readouterr().err


def test_what_is_infinite_is_said_with_its_place(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    forces = {"force": ("AppliedForce f(at = b.center, force = {1e308*10, 0});", "{1e308*10, 0}"),
              "name": ("Force F = 1e200*1e200; AppliedForce f(at = b.center, force = {F, 0});", "1e200*1e200")}
    for name, (text, pointed) in forces.items():
        path = tmp_path / f"{name}.lag"
        path.write_text(f"model M Block b(m = 1, base = world); {text} end M;")
        assert main(["export", str(path), "--to", "fmu", "-o", str(tmp_path / "x.fmu")]) == 2
        told = capsys.readouterr().err
        assert "error[L0605]" in told and pointed in told and "^" in told


def test_documents_say_what_is_inside(tmp_path: Path) -> None:
    for version, path in zip(VERSIONS, model_of(EXAMPLES / "suspended_bar.lag").export_fmu(tmp_path, fmi="both"), strict=True):
        archive = zipfile.ZipFile(path)
        page = archive.read("documentation/index.html").decode()
        for text in ("SuspendedBar", "mass of the bar", "N.s/m", "Equations of motion", "<svg", "tilt.phi"):
            assert text in page
        assert archive.read("model.png" if version == "2" else "terminalsAndIcons/icon.png")[:4] == b"\x89PNG"
        (folder,) = {name.rpartition("/")[0] for name in archive.namelist() if name.startswith("extra/")}
        assert b"model SuspendedBar" in archive.read(f"{folder}/suspended_bar.lag")
        functions = ca.StringDeserializer(archive.read(f"{folder}/functions.casadi").decode()).unpack()
        assert "rhs" in [function.name() for function in functions]


def test_flanges_are_terminals(tmp_path: Path) -> None:
    """A component with an input and a reported quantity is a mechanical flange of FMI 3."""
    (tmp_path / "pushed.lag").write_text("""
model Flange Frame a; input Force f "push"; output Length s = a.x "place"; energy work f on a.x; end Flange;
model Pushed
  Block block(m = 2, base = world, along = {1, 0}); Spring spring(k = 50, stretch = block.s); Flange left(a = block.center);
end Pushed;
""")
    (path,) = lag.Model(tmp_path / "pushed.lag", outputs=("left.s",)).export_fmu(tmp_path / "x.fmu", fmi="3")
    terminals = zipfile.ZipFile(path).read("terminalsAndIcons/terminalsAndIcons.xml").decode()
    assert '<Terminal name="left" matchingRule="bus" terminalKind="mechanical flange">' in terminals
    assert 'variableName="left.f"' in terminals and 'variableName="left.s"' in terminals
    assert not check_fmu(path).faults
