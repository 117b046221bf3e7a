"""Arrays of FMI 3: vectors and matrices of scenes, poses of space; FMI 2 has scalars with the same values."""

import ctypes
import zipfile
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")

import fmpy
from fmpy.validation import validate_fmu

import lagrangia as lag
from helpers.broken_fmus import DESCRIPTION, broken
from helpers.fmus import Instance, fmu_of, simulated
from lagrangia.command.cli import main
from lagrangia.fmu.check import check_fmu
from lagrangia.fmu.description import element_of, labels, place_of
from lagrangia.fmu.variables import build_fmu_model

SCENE = """
model Turns
  parameter Real a = 2, mixed[2] = {a, 3}, follows[2] = {a, 2*a}, M[2,3] = {{1, 2, 3}, {4, 5, 6}};
  input Torque T[2]; parameter Length l[3] = {0, 0.1, 0.2};
  World world(gravity = {0, 0, -9.81});
  Spherical joint(a = world, S(start = axis_angle({1, 2, 3}, 0.4)));
  Body body(m = 2, I = {0.1, 0.2, 0.25}, center = shift(joint.b, l));
  AppliedTorque load(on = body.center, torque = {T[1], M[2,3]*T[2], follows[2]*1[N.m]});
  output Length r[3] = body.center.r; output Real R[3,3] = body.center.R; output Real Q[4] = body.center.Q;
  output Torque part = T[1];
  annotation(experiment(StopTime = 0.5, Tolerance = 1e-9));
end Turns;
"""
SHAPES = {"joint.S": (4,), "joint.w": (3,), "der(joint.S)": (4,), "der(joint.w)": (3,), "r": (3,), "R": (3, 3), "Q": (4,),
          "T": (2,), "M": (2, 3), "l": (3,), "follows": (2,), "body.I": (3,), "world.gravity": (3,)}


@pytest.fixture(scope="module")
def turns(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("arrays") / "turns.lag"
    path.write_text(SCENE)
    return path


def test_arrays_are_variables_with_dimensions(turns: Path) -> None:
    path = fmu_of(turns, "3")
    assert validate_fmu(str(path)) == [] and not check_fmu(path).faults
    description = fmpy.read_model_description(str(path))
    found = {v.name: v for v in description.modelVariables}
    assert {name: tuple(found[name].shape) for name in SHAPES} == SHAPES
    assert "mixed[2]" in found and not found["mixed[2]"].shape and "mixed" not in found  # one is free, one follows
    assert found["follows"].causality == "calculatedParameter"
    assert found["M"].start.split() == ["1.0", "2.0", "3.0", "4.0", "5.0", "6.0"]
    assert description.numberOfContinuousStates == 7 and len(description.derivatives) == 2
    assert [u.variable.name for u in description.outputs] == ["r", "R", "Q", "part"]
    assert not any(v.shape for v in fmpy.read_model_description(str(fmu_of(turns, "2"))).modelVariables)


def test_the_motion_is_that_of_the_scene(turns: Path) -> None:
    names = [f"r[{k}]" for k in (1, 2, 3)] + ["R[1,2]", "R[3,1]", "Q[4]", "joint.S[2]"]
    for kind, tolerance in (("CoSimulation", 1e-8), ("ModelExchange", 1e-5)):
        found = simulated(turns, "3", kind, names)
        native = lag.load(turns).simulate(at=found["time"], inputs={"T[1]": 0.0, "T[2]": 0.0})
        for name in names:
            assert np.abs(found[name] - native[name]).max() < tolerance, (kind, name)


def test_values_go_row_by_row(turns: Path) -> None:
    one, other = (Instance(turns, version, "ModelExchange") for version in "32")
    values = {"M[2,3]": 7.0, "l[1]": 0.05, "T[2]": 0.5, "joint.w[2]": 1.5}
    one.start(values)
    other.start(values)
    assert one.whole("M") == [1, 2, 3, 4, 5, 7] and one.whole("T") == [0, 0.5] and one.whole("follows") == [2, 4]
    for name, shape in SHAPES.items():
        assert one.whole(name) == other.get(*labels(name, shape)), name
    assert one.slopes() == pytest.approx(other.slopes(), rel=0, abs=0)


def test_wrong_sizes_and_elements_are_errors(turns: Path) -> None:
    from fmpy.fmi1 import FMICallException

    one = Instance(turns, "3", "CoSimulation")
    at = one.reference["M"]
    for count in (1, 5, 7):
        with pytest.raises(FMICallException):
            one.fmu.getFloat64([at], nValues=count)
        with pytest.raises(FMICallException):
            one.fmu.setFloat64([at], [9.0] * count)
    for references, values in (([at], [9, 9, np.nan, 9, 9, 9]), ([at, one.reference["follows"]], [9.0] * 8)):
        with pytest.raises(FMICallException):
            one.fmu.setFloat64(references, values)
    with pytest.raises(FMICallException):
        one.fmu.getFloat64([at + 1])
    one.start()
    assert one.whole("M") == [1, 2, 3, 4, 5, 6]  # nothing of what was refused was set
    with pytest.raises(FMICallException):
        one.fmu.getDirectionalDerivative([one.reference["r"]], [one.reference["T"]], [1.0], nSensitivity=3)


def test_derivatives_are_those_of_all_elements(turns: Path) -> None:
    """Along whole arrays, and adjoint, beside those of FMI 2's scalars."""
    one, other = (Instance(turns, version, "ModelExchange").start({"T[1]": 0.3}) for version in "32")
    rows = labels("der(joint.w)", (3,)) + labels("R", (3, 3))
    columns = labels("joint.S", (4,)) + labels("T", (2,)) + labels("M", (2, 3))
    jacobian = np.array([other.forward(rows, [name], [1.0]) for name in columns]).T
    seed = np.linspace(-1, 2, len(columns))
    assert one.forward(rows, columns, list(seed)) == pytest.approx(list(jacobian @ seed), rel=1e-12, abs=1e-13)
    weights = np.linspace(2, -1, len(rows))
    assert one.adjoint(rows, columns, list(weights)) == pytest.approx(list(weights @ jacobian), rel=1e-12, abs=1e-13)
    assert np.abs(jacobian).max() > 1


def dependencies(one: Instance, name: str) -> set[tuple[int, str, int, int]]:
    """Element, known, its element, kind."""
    library, at = one.fmu.dll, one.reference[name]
    count = ctypes.c_size_t()
    assert library.fmi3GetNumberOfVariableDependencies(one.fmu.component, at, ctypes.byref(count)) == 0
    n = count.value
    of, elements = (ctypes.c_size_t * n)(), (ctypes.c_size_t * n)()
    knowns, kinds = (ctypes.c_uint32 * n)(), (ctypes.c_int * n)()
    call = (one.fmu.component, ctypes.c_uint32(at), of, knowns, elements, kinds)
    assert library.fmi3GetVariableDependencies(*call, ctypes.c_size_t(n)) == 0
    assert library.fmi3GetVariableDependencies(*call, ctypes.c_size_t(n + 1)) == 3
    named = {reference: name for name, reference in one.reference.items()}
    return {(i, named[known], k, kind) for i, known, k, kind in zip(of, knowns, elements, kinds, strict=True)}


def test_each_element_tells_what_it_depends_on(turns: Path) -> None:
    one = Instance(turns, "3", "ModelExchange")
    assert one.description.modelExchange.providesPerElementDependencies
    assert dependencies(one, "follows") == {(1, "a", 0, 1), (2, "a", 0, 1)}
    one.start()
    found = dependencies(one, "der(joint.w)")
    assert {(i, k) for i, known, k, _ in found if known == "T"} == {(i, k) for i in (1, 2, 3) for k in (1, 2)}
    assert {k for _, known, k, _ in found if known == "M"} == {6}
    assert dependencies(one, "part") == {(0, "T", 1, 1)}


def test_arrays_are_given_whole_or_by_element(turns: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = str(fmu_of(turns, "3"))
    rows = []
    for values in (["-p", "M={{1,2,3},{4,5,7}}", "-u", "T={0,0.5}"], ["-p", "M[2,3]=7", "-u", "T[2]=0.5"]):
        assert main(["simulate", path, *values, "--interval", "0.1", "-o", "-", "--quiet", "--outputs", "M,r[2]"]) == 0
        rows.append(capsys.readouterr().out)
    assert rows[0] == rows[1] and rows[0].splitlines()[0].endswith('"M[2,2]","M[2,3]"') and rows[0].count("r[2]") == 1
    for wrong, told in ((["-p", "M=3"], "array of 2 by 3 values"), (["-p", "M[3,1]=1"], "'M' is an array of 2 by 3"),
                        (["-p", "l={1,2}"], "array of 3 values"), (["-p", "a[1]=1"], "'a' is a scalar"),
                        (["-p", "l={1,2,3}", "-p", "l[1]=2"], "given twice"), (["-p", "follows[1]=2"], "follows from other")):
        assert main(["simulate", path, *wrong, "-o", str(tmp_path / "x.csv")]) == 2
        assert told in capsys.readouterr().err


def test_faults_of_arrays_are_told(turns: Path, tmp_path: Path) -> None:
    for old, new, told in (('start="1.0 2.0 3.0 4.0 5.0 6.0"', 'start="1.0 2.0"', "has 6 elements and 2 start values"),
                           ('<Dimension start="2"/>', "<Dimension/>", "neither a start nor a variable"),
                           ('<Dimension start="2"/>', '<Dimension valueReference="0"/>', "is no structural parameter")):
        change = {DESCRIPTION: lambda text, old=old, new=new: text.replace(old, new)}
        changed = broken(fmu_of(turns, "3"), tmp_path / "x.fmu", change)
        assert any(told in fault.message for fault in check_fmu(changed).faults), told
    assert main(["simulate", str(changed), "-o", str(tmp_path / "x.csv")]) in (1, 2)


def test_terminals_name_whole_arrays(tmp_path: Path) -> None:
    (tmp_path / "pushed.lag").write_text("""
model Flange Frame a; input Force f[2]; output Length s[2] = a.r; energy work f on a.r; end Flange;
model Pushed
  PointMass p(m = 2); AxialSpring spring(k = 50, a = world, b = p.center, along = {1, 0}); Flange left(a = p.center);
end Pushed;
""")
    model = lag.Model(tmp_path / "pushed.lag", outputs=("left.s",))
    (path,) = model.export_fmu(tmp_path / "x.fmu", fmi="3")
    terminals = zipfile.ZipFile(path).read("terminalsAndIcons/terminalsAndIcons.xml").decode()
    assert 'variableName="left.f" memberName="f"' in terminals and "[" not in terminals
    assert not check_fmu(path).faults
    asked = build_fmu_model(lag.Model(tmp_path / "pushed.lag", outputs=("left.s[1]",)))  # one element is a scalar
    assert [array.name for array in asked.arrays if "left" in array.name] == ["left.f"]


def test_names_of_elements() -> None:
    assert [element_of(name) for name in ("x[2]", "b[1].x", "der(M[1,2])", "der(y[3],2)", "'x[1]'")] == [
        ("x", (2,)), None, ("der(M)", (1, 2)), ("der(y,2)", (3,)), None]
    assert labels("der(y,2)", (2,)) == ["der(y[1],2)", "der(y[2],2)"] and labels("x", ()) == ["x"]
    assert [place_of(index, (2, 3)) for index in ((1, 1), (2, 3), (3, 1), (1,), (0, 1))] == [0, 5, None, None, None]


def test_scalars_for_importers_without_arrays(turns: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = tmp_path / "x.fmu"
    assert main(["export", str(turns), "--to", "fmu", "--fmi", "3", "--no-arrays", "-o", str(path)]) == 0
    assert validate_fmu(str(path)) == []
    assert {v.name for v in fmpy.read_model_description(str(path)).modelVariables} == {
        v.name for v in fmpy.read_model_description(str(fmu_of(turns, "2"))).modelVariables}
    capsys.readouterr()
    assert main(["export", str(turns), "--to", "fmu", "--no-arrays", "-o", str(path)]) == 2
    assert "FMI 2 has no arrays" in capsys.readouterr().err
