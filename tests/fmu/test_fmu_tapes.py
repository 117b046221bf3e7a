"""FMUs whose binary is the library that comes with the package, and whose scene is a file: the digits of compiled ones; several
in one process; what does not go together is refused."""

import ctypes as c
import shutil
import struct
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from zlib import adler32

import numpy as np
import pytest

pytest.importorskip("fmpy")

import fmpy

import lagrangia as lag
from helpers.fmus import EXAMPLES, KINDS, VERSIONS, Instance, model_of, unpacked
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import main
from lagrangia.fmu.build import standard_headers
from lagrangia.fmu.stored import FMU_MIRRORS, NAME
from lagrangia.native.build import build
from lagrangia.native.prebuilt import find_fmu

RUNTIME = data_folder("runtime")
FAR = "aarch64-linux,x86_64-windows"
pytestmark = pytest.mark.skipif(find_fmu(RUNTIME, "2") is None, reason="the run time was not built with the package")


# ---------------------------------------------------------------- digits


def steps(path: Path, version: str, engine: str) -> list[float]:
    """What thirty steps of Co-Simulation say, and slopes and derivatives of Model Exchange."""
    one = Instance(path, version, "CoSimulation", engine=engine).start()
    scene = model_of(path).scene
    h = min(scene.stop - scene.start, 3.0) / 30
    names = [column.name for column in (*scene.coordinates, *scene.outputs)]
    found = []
    for k in range(30):
        one.step(scene.start + k * h, h)
        found += [*one.states(), *(one.get(*names))]
    one.free()
    other = Instance(path, version, "ModelExchange", engine=engine).start()
    knowns = [u.variable.derivative.name for u in other.description.derivatives]
    unknowns = [u.variable.name for u in other.description.derivatives]
    found += [*other.slopes(), *other.forward(unknowns, knowns, [1.0 + k for k in range(len(knowns))])]
    other.free()
    return found


@pytest.mark.slow  # the first of them compiles the run time
@pytest.mark.parametrize(("name", "version"),
                         [("double_pendulum", "2"), ("four_bar", "3"), ("stick_slip", "2"), ("quarter_car", "3")])
def test_digits_are_those_of_a_compiled_one(name: str, version: str) -> None:
    path = EXAMPLES / f"{name}.lag"
    assert steps(path, version, "tape") == steps(path, version, "native")


def test_scenes_beside_each_other_do_not_meet() -> None:
    """One library, copied, in one process: each has its own scene; several instances of each."""
    paths = [EXAMPLES / f"{name}.lag" for name in ("double_pendulum", "four_bar", "pendulum")]
    alone = [steps(path, "2", "tape") for path in paths]
    many = [Instance(path, version, kind, engine="tape").start() for path in paths for version in VERSIONS for kind in KINDS]
    assert [steps(path, "2", "tape") for path in paths] == alone
    for instance in many:
        instance.free()
    assert [steps(path, "2", "tape") for path in paths] == alone


# ---------------------------------------------------------------- which one is made


def test_auto_takes_what_costs_less(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    model = model_of(EXAMPLES / "pendulum.lag")

    def has_tape(**wanted: str) -> bool:
        (path,) = model.export_fmu(tmp_path / "x.fmu", **wanted)
        import zipfile

        names = zipfile.ZipFile(path).namelist()
        return f"resources/{NAME}" in names and "binaries/linux64/Pendulum.so" in names

    assert has_tape()
    monkeypatch.setattr("lagrangia.fmu.export.saved_seconds", lambda scene, evaluations: 1.0)
    assert not has_tape()
    assert has_tape(engine="tape")
    monkeypatch.setattr("lagrangia.fmu.export.has_compiler", lambda: False)
    assert has_tape()


def test_no_compiler_is_needed(tmp_path: Path) -> None:
    """Neither in PATH nor by name; none is started."""
    command = "import sys; from lagrangia.command.cli import main; sys.exit(main())"
    words = [sys.executable, "-c", command, "export", str(EXAMPLES / "four_bar.lag"), "--to", "fmu", "--fmi", "both"]
    environment = {"PYTHONPATH": ":".join(sys.path), "LAGRANGIA_CC": "none", "PATH": "", "LAGRANGIA_CACHE": f"{tmp_path}/cache"}
    done = subprocess.run(words, cwd=tmp_path, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert not any(path.suffix == ".so" for path in (tmp_path / "cache").rglob("*"))
    assert fmpy.simulate_fmu(str(tmp_path / "FourBar_fmi3.fmu"), stop_time=0.1) is not None


@pytest.mark.parametrize(("words", "said"), [
    (["--engine", "tape", "--platforms", FAR], "only this machine's binary runs tapes"),
    (["--engine", "fast"], "there is no engine of an FMU 'fast'"),
])
def test_what_cannot_be_is_refused(words: list[str], said: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["export", str(EXAMPLES / "pendulum.lag"), "--to", "fmu", "-o", str(tmp_path / "x.fmu"), *words]) == 2
    assert said in capsys.readouterr().err


def test_without_the_library_a_tape_is_refused(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    monkeypatch.setattr("lagrangia.fmu.export.find_fmu", lambda *rest: None)
    with pytest.raises(lag.LagError, match="no library for FMUs came with the package"):
        model_of(EXAMPLES / "pendulum.lag").export_fmu(tmp_path / "x.fmu", engine="tape")


# ---------------------------------------------------------------- files that are not the library's


def instantiated(folder: Path, resources: bytes | None, version: str = "3") -> tuple[bool, str]:
    """Whether an instance came to be, and what was logged."""
    from fmpy import fmi2, fmi3

    description = fmpy.read_model_description(str(folder))
    token = (description.instantiationToken or description.guid).encode()
    binary = folder / "binaries" / ("x86_64-linux" if version == "3" else "linux64") / "Pendulum.so"
    library, told = c.CDLL(str(binary)), []
    if version == "3":
        log = fmi3.fmi3LogMessageCallback(lambda environment, status, category, text: told.append(text.decode()))
        library.fmi3InstantiateModelExchange.restype = c.c_void_p
        made = library.fmi3InstantiateModelExchange(b"one", token, resources, False, False, None, log)
    else:
        logger = fmi2.fmi2CallbackLoggerTYPE(lambda environment, name, status, category, text: told.append(text.decode()))
        callbacks = fmi2.fmi2CallbackFunctions(logger=logger)
        library.fmi2Instantiate.restype = c.c_void_p
        made = library.fmi2Instantiate(b"one", 0, token, resources, c.byref(callbacks), 0, 0)
    if made:
        getattr(library, f"fmi{version}FreeInstance")(c.c_void_p(made))
    return bool(made), " ".join(told)


def _cut(content: bytes) -> bytes:
    return content[:-64]


def _flipped(content: bytes) -> bytes:
    return content[:300] + bytes([content[300] ^ 1]) + content[301:]


def _of_another_version(content: bytes) -> bytes:
    return content[:8] + b"0" * 64 + content[72:]


def _pointing_outside(content: bytes) -> bytes:
    """With a sum that is right."""
    (listed,) = struct.unpack_from("=Q", content, 120)
    (place,) = struct.unpack_from("=Q", content, listed)
    changed = content[:place] + struct.pack("=Q", len(content)) + content[place + 8 :]
    return changed[:80] + struct.pack("=Q", adler32(changed[128:])) + changed[88:]


@pytest.mark.parametrize(("change", "said"), [
    (_cut, "is damaged"), (_flipped, "is damaged"), (_pointing_outside, "is damaged"), (lambda content: b"", "cannot be read"),
    (lambda content: content[:100], "is damaged"), (lambda content: b"x" * len(content), "is no scene of Lagrangia"),
    (_of_another_version, "was written for the library of another version"), (None, "cannot be read"),
])
def test_a_file_of_something_else_is_refused(change: Callable[[bytes], bytes] | None, said: str, tmp_path: Path) -> None:
    folder = tmp_path / "it"
    shutil.copytree(unpacked(EXAMPLES / "pendulum.lag", "3", "tape"), folder)
    file = folder / "resources" / NAME
    if change is None:
        file.unlink()
    else:
        file.write_bytes(change(file.read_bytes()))
    made, told = instantiated(folder, bytes(folder / "resources"))
    assert not made
    assert said in told


@pytest.mark.parametrize("resources", [None, b"", b"x" * 5000])
def test_an_importer_that_tells_no_folder_is_told(resources: bytes | None) -> None:
    made, told = instantiated(unpacked(EXAMPLES / "pendulum.lag", "3", "tape"), resources)
    assert not made
    assert "has to tell the folder of the FMU's resources" in told


@pytest.mark.parametrize(("version", "form"), [
    ("2", "file://{}/re%20s%C3%BC"), ("2", "file:{}/re%20s%c3%bc/"), ("2", "file://localhost{}/re%20s%C3%BC"), ("2", "{}/re sü"),
    ("3", "{}/re sü"), ("3", "{}/re sü/"),
])
def test_folders_are_named_in_many_ways(version: str, form: str, tmp_path: Path) -> None:
    folder = unpacked(EXAMPLES / "pendulum.lag", version, "tape")
    shutil.copytree(folder / "resources", tmp_path / "re sü")
    assert instantiated(folder, form.format(tmp_path).encode(), version) == (True, "")


# ---------------------------------------------------------------- mirrors of C


def numbers(expressions: list[str], headers: str, *include: Path) -> list[int]:
    """Their values in C."""
    rows = ", ".join(f"(long long)({text})" for text in expressions)
    text = f"{headers}\n#include <stddef.h>\nLAG_API extern const long long found[];\nconst long long found[] = {{{rows}}};\n"
    library = c.CDLL(str(build("mirror", text, include=[RUNTIME, *include])))
    return list((c.c_longlong * len(expressions)).in_dll(library, "found"))


def test_every_member_lies_where_c_has_it() -> None:
    mirror = FMU_MIRRORS["LagFmu"]
    names = [name for name, *_ in mirror._fields_]
    found = numbers([*(f"offsetof(LagFmu, {name})" for name in names), "sizeof(LagFmu)"], '#include "fmi/fmu.h"')
    assert found == [*(getattr(mirror, name).offset for name in names), c.sizeof(mirror)]


TYPES = {
    "2": ["fmi2ValueReference", "fmi2Real", "fmi2Integer", "fmi2Boolean", "fmi2String", "fmi2Byte", "fmi2Component",
          "fmi2FMUstate", "fmi2Status", "fmi2Type", "fmi2StatusKind", "fmi2CallbackFunctions", "fmi2EventInfo"],
    "3": ["fmi3Instance", "fmi3InstanceEnvironment", "fmi3FMUState", "fmi3ValueReference", "fmi3Boolean", "fmi3Clock",
          "fmi3String", "fmi3Byte", "fmi3Binary", "fmi3Status", "fmi3DependencyKind", "fmi3IntervalQualifier",
          *(f"fmi3{sign}Int{bits}" for sign in ("", "U") for bits in (8, 16, 32, 64)), "fmi3Float32", "fmi3Float64"],
}
VALUES = {
    "2": ["fmi2OK", "fmi2Warning", "fmi2Discard", "fmi2Error", "fmi2Fatal", "fmi2Pending", "fmi2ModelExchange",
          "fmi2CoSimulation", "fmi2DoStepStatus", "fmi2PendingStatus",
          "fmi2LastSuccessfulTime", "fmi2Terminated", "fmi2True", "fmi2False",
          *(f"offsetof(fmi2CallbackFunctions, {name})" for name in ("logger", "allocateMemory", "freeMemory", "stepFinished",
                                                                   "componentEnvironment")),
          *(f"offsetof(fmi2EventInfo, {name})" for name in (
              "newDiscreteStatesNeeded", "terminateSimulation", "nominalsOfContinuousStatesChanged",
              "valuesOfContinuousStatesChanged", "nextEventTimeDefined", "nextEventTime"))],
    "3": ["fmi3OK", "fmi3Warning", "fmi3Discard", "fmi3Error", "fmi3Fatal", "fmi3Independent", "fmi3Constant", "fmi3Fixed",
          "fmi3Tunable", "fmi3Discrete", "fmi3Dependent", "fmi3IntervalNotYetKnown", "fmi3IntervalUnchanged",
          "fmi3IntervalChanged"],
}


@pytest.mark.parametrize("version", VERSIONS)
def test_own_types_are_those_of_the_standard(version: str) -> None:
    """The package's library is built with the former, all others with the latter."""
    asked = [*(f"sizeof({name})" for name in TYPES[version]), *VALUES[version]]
    header = f'#include "model/model.h"\n#include "fmi{version}Functions.h"'
    own = numbers(asked, header, RUNTIME / "standard")
    assert own == numbers(asked, header, standard_headers())
    assert len({*np.array(own)}) > 3


@pytest.mark.parametrize("version", VERSIONS)
def test_the_library_has_the_functions_of_a_compiled_one(version: str) -> None:
    folders = [unpacked(EXAMPLES / "pendulum.lag", version, engine) / "binaries" for engine in ("tape", "native")]
    found = []
    for folder in folders:
        (file,) = folder.rglob("*.so")
        listed = subprocess.run(["nm", "-D", "--defined-only", str(file)], capture_output=True, text=True, check=True).stdout
        found.append({line.split()[-1] for line in listed.splitlines() if " T " in line})
    assert found[0] == {name for name in found[1] if name.startswith("fmi")}
    assert len(found[0]) > 40
