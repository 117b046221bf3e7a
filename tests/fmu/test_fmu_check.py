"""`lag fmu check`: an FMU is broken in one way after the other, and each is found and told."""

import re
import shutil
import subprocess
import zipfile
from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("fmpy")

from fmpy.validation import validate_fmu

from helpers.broken_fmus import DESCRIPTION, broken, described, replaced
from helpers.fmus import EXAMPLES, VERSIONS, fmu_of
from lagrangia import Model
from lagrangia.base.diagnostics import Diagnostic
from lagrangia.command.cli import DONE, FAILED, WRONG, main
from lagrangia.fmu.check import check_fmu, read_faults
from lagrangia.fmu.run import open_fmu
from lagrangia.fmu.xmltree import Element

PATH = EXAMPLES / "double_pendulum.lag"
BUILD, TERMINALS = "sources/buildDescription.xml", "terminalsAndIcons/terminalsAndIcons.xml"
MANIFEST = (b'<m xmlns:l="http://fmi-standard.org/fmi-ls-manifest" l:fmi-ls-name="org.y" l:fmi-ls-description="d"%s/>')
Break = Callable[[Path, Path], Path]


def text(pattern: str, by: str, count: int = 1) -> Break:
    """A change of the model description."""
    return lambda path, target: described(path, target, pattern, by, count)


def file(name: str, change: Callable[[str], str] | bytes | None, **written: int) -> Break:
    return lambda path, target: broken(path, target, {name: change}, **written)


def found(target: Path) -> list[Diagnostic]:
    """By our own rules."""
    return list(read_faults(open_fmu(target)))


@pytest.mark.parametrize("version", VERSIONS)
def test_what_we_make_has_no_fault(version: str) -> None:
    checked = check_fmu(fmu_of(PATH, version), Model)
    assert checked.faults == [] and not checked.has_failed
    assert [told.partition(" from")[0] for told, _ in checked.told] == ["Model Exchange", "Co-Simulation"]
    assert all("of the native run" in told for told, _ in checked.told)


# ---------------------------------------------------------------- what no other checker finds

# A wrong index, start values out of bounds, listed sources that are not there, a build description for another version, a state
# that is not continuous: version, what is done to the FMU, and what is said of it.
SILENT = {
    "derivative of another state": ("2", text(r'(name="der\(shoulder.phi\)"[^\n]*\n[^\n]*derivative=)"2"', r'\1"3"'),
                                    "'der(shoulder.phi)' is said to be the derivative of 'elbow.phi', but its name says"),
    "derivative of another unit": ("2", text(r'(name="der\(shoulder.phi\)"[^\n]*\n[^\n]*derivative=)"2"', r'\1"4"'),
                                   "'der(shoulder.phi)' is said to be the derivative of 'shoulder.w'"),
    "derivative of a parameter": ("3", text(r'(name="der\(elbow.phi\)"[^\n]*derivative=)"2"', r'\1"16"'),
                                  "which is no state but of the kind parameter"),
    "its own derivative": ("3", text(r'(name="der\(elbow.phi\)" valueReference="(\d+)"[^\n]*derivative=)"2"', r'\1"\2"'),
                           "'der(elbow.phi)' is its own derivative"),
    "start below its minimum": ("2", text(r'(min="0.0"[^\n]*start=)"1.0"', r'\1"-1.0"'), "starts at -1, below its minimum 0"),
    "start above its maximum": ("3", text(r'min="0.0" start="1.0"', 'max="0.5" start="1.0"'),
                                "starts at 1, above its maximum 0.5"),
    "listed source missing, FMI 2": ("2", file("sources/run.c", None), "there is no file 'sources/run.c'"),
    "listed source missing, FMI 3": ("3", file("sources/run.c", None), "there is no file 'sources/run.c'"),
    "built for another version, FMI 2": ("2", file(BUILD, replaced('"3.0"', '"2.0"')), "The value '2.0' is not accepted"),
    "built for another version, FMI 3": ("3", file(BUILD, replaced('"3.0"', '"3.0.1"')), "it is for FMI '3.0.1', and "),
    "state that is discrete, FMI 2": ("2", text(r'(name="elbow.phi"[^\n]*variability=)"continuous"', r'\1"discrete"'),
                                      "'elbow.phi' is a state and discrete"),
    "state that is discrete, FMI 3": ("3", text(r'(name="elbow.w"[^\n]*variability=)"continuous"', r'\1"discrete"'),
                                      "'elbow.w' is a state and discrete"),
    "flag of FMI 2 in FMI 3": ("3", text("canGetAndSetFMUState", "canGetAndSetFMUstate"), "is the spelling of FMI 2"),
}


@pytest.mark.parametrize("case", SILENT)
def test_silent_faults_are_found(case: str, tmp_path: Path) -> None:
    version, spoil, message = SILENT[case]
    target = spoil(fmu_of(PATH, version), tmp_path / "x.fmu")
    assert validate_fmu(str(target)) == [], "FMPy has nothing to say"
    assert any(message in d.message and d.severity == "error" for d in found(target))


def test_states_that_only_a_run_tells_apart(tmp_path: Path) -> None:
    """Both angles are exchanged: every name, unit and number in the description is a possible one."""
    def exchanged(content: str) -> str:
        content = re.sub(r'(name="der\(shoulder.phi\)"[^\n]*derivative=)"1"', r'\1"x"', content)
        content = re.sub(r'(name="der\(elbow.phi\)"[^\n]*derivative=)"2"', r'\1"1"', content)
        content = content.replace('derivative="x"', 'derivative="2"').replace('"structured"', '"flat"')
        return content.replace('name="der(shoulder.phi)"', 'name="a"').replace('name="der(elbow.phi)"', 'name="b"')

    target = broken(fmu_of(PATH, "3"), tmp_path / "x.fmu", {DESCRIPTION: exchanged})
    assert validate_fmu(str(target)) == [] and found(target) == []
    checked = check_fmu(target, Model)
    assert any("the state 1 is" in told and "'elbow.phi'" in told for told, is_fault in checked.told if is_fault)


# ---------------------------------------------------------------- what others find too, or only some


FAULTS = {
    "no start": ("2", text(r'(name="upper.m"[^\n]*\n[^\n]*) start="[^"]*"', r"\1"), "L0732", "has no start value"),
    "start of what is computed": ("2", text(r'(name="der\(elbow.w\)"[^\n]*\n[^\n]*<Real)', r'\1 start="1.0"'), "L0732",
                                  "is a calculated variable and has a start value"),
    "empty range": ("3", text('min="0.0"', 'min="2.0" max="1.0"'), "L0732", "is at least 2 and at most 1"),
    "nominal 0": ("3", text('nominal="[^"]*"', 'nominal="0"'), "L0732", "importers divide by it"),
    "type that is not there": ("2", text('declaredType="Mass"', 'declaredType="Weight"'), "L0732", "which is not defined"),
    "alias set twice": ("2", text(r'(name="lower.m" valueReference=)"\d+"', r'\1"16"'), "L0732", "both are set from outside"),
    "empty unit": ("2", text('unit="kg"(?! )', 'unit=""'), "L0733", "is empty"),
    "unit that is not defined": ("3", text(r'(name="upper.m"[^\n]*)unit="kg"', r'\1unit="stone"'), "L0733", "is not defined"),
    "display unit of another unit": ("3", text(r'(name="elbow.w"[^\n]*)displayUnit="deg/s"', r'\1displayUnit="rpm"'), "L0733",
                                     "is none of 'rad/s'"),
    "unit defined twice": ("2", text(r'(<Unit name="J">[\s\S]*?</Unit>)', r"\1\1"), "L0733", "is defined twice"),
    "row that points nowhere": ("2", text('<Unknown index="6"', '<Unknown index="600"'), "L0734", "has the index 600"),
    "dependency that points nowhere": ("3", text('dependencies="3"', 'dependencies="777"'), "L0734", "valueReference 777"),
    "row twice": ("3", text(r'(\n *<InitialUnknown [^\n]*)', r"\1\1"), "L0734", "stands twice among the initial unknowns"),
    "flag of FMI 3 in FMI 2": ("2", text("canGetAndSetFMUstate", "canGetAndSetFMUState"), "L0735", "is the spelling of FMI 3"),
    "identifier that is none": ("3", text('modelIdentifier="DoublePendulum"', 'modelIdentifier="Double-Pendulum"', 2), "L0735",
                                "is no C identifier"),
    "experiment backwards": ("2", text('stopTime="10.0"', 'stopTime="-1"'), "L0735", "stops before it starts"),
    "build of another model": ("3", file(BUILD, replaced("DoublePendulum", "Other")), "L0736", "no interface is called 'Other'"),
    "build description that is no XML": ("2", file(BUILD, b"<a>"), "L0730", "this is no XML"),
    "no build description": ("3", file(BUILD, None), "L0736", "says how to compile them"),
    "terminal that names nothing": ("3", file(TERMINALS, replaced(
        "</fmiTerminalsAndIcons>", '<Terminals><Terminal name="t" matchingRule="bus"><TerminalMemberVariable '
        'variableName="nobody" memberName="m" variableKind="signal"/></Terminal></Terminals></fmiTerminalsAndIcons>')),
        "L0738", "names 'nobody'"),
    "terminals out of order": ("3", file(TERMINALS, replaced("<Graphical", '<Terminals><Terminal name="t" matchingRule="bus"/>'
                                                             "</Terminals><Graphical")), "L0728", "Expected is"),
    "no scaling of the icon": ("3", file(TERMINALS, replaced(' suggestedScalingFactorTo_mm="[^"]*"', "")), "L0728",
                               "'suggestedScalingFactorTo_mm' is required but missing"),
    "definition without a name": ("2", file(BUILD, replaced(' name="LAG_STATIC"', "")), "L0728",
                                  "'name' is required but missing"),
    "manifest that says nothing": ("2", file("extra/org.x/fmi-ls-manifest.xml", MANIFEST % b""), "L0728", "no fmi-ls-version"),
    "link": ("2", file("resources/link", b"/etc/passwd", external_attr=0o120777 << 16), "L0731", "is a link"),
    "packed by LZMA": ("2", file("resources/a", b"a" * 99, compress_type=zipfile.ZIP_LZMA), "L0731", "packed by lzma"),
    "ZIP64": ("2", file("resources/a", b"a", extract_version=45), "L0731", "needs version 4.5 of ZIP"),
    "leads out": ("2", file("../a", b"a"), "L0731", "leads out of the archive"),
    "dot before the name": ("2", file("./resources/a", b"a"), "L0731", "not found by its plain name"),
}
WARNINGS = {
    "unit 1": ("3", text(r'<UnitDefinitions>([\s\S]*)(name="upper.m"[^\n]*)unit="kg"',
                         r'<UnitDefinitions><Unit name="1"/>\1\2unit="1"'), "L0733", "is '1'"),
    "headers of the standard": ("2", file("sources/fmi2Functions.h", b"/* */"), "L0736", "header of the standard"),
    "capitals alone": ("2", file("modeldescription.xml", b"<a/>"), "L0731", "where capitals do not count"),
    "manifest of another": ("3", file("extra/org.x/fmi-ls-manifest.xml", MANIFEST % b' l:fmi-ls-version="1"'), "L0728",
                            "lies in the folder of 'org.x'"),
    "platform nobody knows": ("3", file("binaries/amiga/DoublePendulum.so", b"x"), "L0737", "no importer knows"),
    "depends on what is not known": ("2", text(r'(<Derivatives>\s*<Unknown index="\d+" dependencies=)"\d+"', r'\1"14"'),
                                     "L0734", "which is not known before it"),
}


@pytest.mark.parametrize("case", [*FAULTS, *WARNINGS])
def test_faults_are_told_with_their_place(case: str, tmp_path: Path) -> None:
    version, spoil, code, message = (FAULTS | WARNINGS)[case]
    target = spoil(fmu_of(PATH, version), tmp_path / "x.fmu")
    told = [d for d in found(target) if d.code == code and message in d.message]
    assert told, [d.message for d in found(target)]
    assert told[0].severity == ("warning" if case in WARNINGS else "error")
    rendered = told[0].render()
    assert told[0].span is None or ("x.fmu/" in rendered and "^" in rendered)


def test_what_fmpy_finds_is_told_once(tmp_path: Path) -> None:
    good = fmu_of(PATH, "2")
    missing = check_fmu(described(good, tmp_path / "x.fmu", r"(<InitialUnknowns>\n)[^\n]*\n", r"\1"))
    assert [d.code for d in missing.faults] == ["L0739"] and "expected set of variables" in missing.faults[0].message
    both = check_fmu(described(good, tmp_path / "y.fmu", r'(name="upper.m"[^\n]*\n[^\n]*) start="[^"]*"', r"\1"))
    assert [d.code for d in both.faults] == ["L0732"], "FMPy says the same of the same line"


def test_names_with_backslashes(tmp_path: Path) -> None:
    """Python's own writer turns them round, so they are put into the bytes."""
    target = broken(fmu_of(PATH, "2"), tmp_path / "x.fmu", {"resources/a_b": b"a"})
    target.write_bytes(target.read_bytes().replace(b"resources/a_b", b"resources\\a_b"))
    assert any(d.code == "L0731" and "has a backslash" in d.message for d in found(target))


def test_binaries_are_looked_into(tmp_path: Path) -> None:
    host = fmu_of(PATH, "3")
    name = next(name for name in zipfile.ZipFile(host).namelist() if name.startswith("binaries/x86_64-linux/"))
    binary = zipfile.ZipFile(host).read(name)
    cases = {
        b"no library": "is no shared library", b"\x7fELF\2\1": "is no shared library", binary[:3000]: "is no shared library",
        binary[:18] + b"\xb7" + binary[19:]: "is made for aarch64-linux",
        binary.replace(b"libm.so.6", b"libq.so.6"): "needs libq.so.6, which is not in the FMU",
        binary.replace(b"GLIBC_2.2.5", b"GLIBC_2.39\0"): "needs glibc 2.39",
        binary.replace(b"fmi3DoStep\0", b"fmi3DoSteq\0"): "has no function fmi3DoStep",
    }
    for content, message in cases.items():
        target = broken(host, tmp_path / "x.fmu", {name: content})
        assert any(message in d.message for d in found(target)), message
    for other, message in ((name.replace("x86_64-linux", "linux64"), "is the spelling of FMI 2"),
                           (name.replace("DoublePendulum", "other"), f"there is no '{name}'")):
        target = broken(host, tmp_path / "x.fmu", {name: None, other: binary})
        assert any(message in d.message for d in found(target))


# ---------------------------------------------------------------- the command


def nested(path: Path, target: Path) -> Path:
    with zipfile.ZipFile(path) as source, zipfile.ZipFile(target, "w") as archive:
        for name in source.namelist():
            archive.writestr(f"model/{name}", source.read(name))
    return target


def cut(path: Path, target: Path) -> Path:
    target.write_bytes(path.read_bytes()[:-100])
    return target


def spoilt(path: Path, target: Path) -> Path:
    """The bytes of the description are others than its sum says."""
    content = bytearray(path.read_bytes())
    content[200:260] = bytes(60)
    target.write_bytes(content)
    return target


def plain(content: bytes) -> Break:
    def write(path: Path, target: Path) -> Path:
        target.write_bytes(content)
        return target

    return write


BOMB = b'<!DOCTYPE a [<!ENTITY b "' + b"x" * 1000 + b'"><!ENTITY c "' + b"&b;" * 1000 + b'">]><fmiModelDescription a="&c;"/>'
HOSTILE = {
    "empty": (plain(b""), "it is empty"), "text": (plain(b"hello"), "is no ZIP archive"), "cut": (cut, "is no ZIP archive"),
    "spoilt": (spoilt, "cannot be read"), "nested": (nested, "pack what is in that folder"),
    "without description": (file(DESCRIPTION, None), f"there is no {DESCRIPTION} at its top"),
    "no XML": (file(DESCRIPTION, b"<fmiModelDescription>\n<a></b>"), "this is no XML: mismatched tag"),
    "nothing": (file(DESCRIPTION, b""), "is no XML: no element found in line 1"),
    "bomb": (file(DESCRIPTION, BOMB), "document types and entities are not read"),
    "not UTF-8": (file(DESCRIPTION, b"<a>\xff</a>"), "is not the text"),
    "another root": (file(DESCRIPTION, b"<a fmiVersion='2.0'/>"), "the root is <a>"),
    "no version": (file(DESCRIPTION, b"<fmiModelDescription/>"), "'' is no version of FMI"),
    "FMI 1": (text('fmiVersion="2.0"', 'fmiVersion="1.0"'), "not supported yet: FMI 1.0"),
    "FMI 4": (text('fmiVersion="2.0"', 'fmiVersion="4.0"'), "'4.0' is no version"),
    "variable without a name": (text('name="elbow.phi" ', ""), "a variable has no name"),
    "reference that is none": (text('valueReference="3"', 'valueReference="three"'), "a value reference is a whole number"),
    "nothing but its root": (file(DESCRIPTION, b'<fmiModelDescription fmiVersion="2.0"/>'), "neither Model Exchange"),
}


@pytest.mark.parametrize("case", HOSTILE)
def test_hostile_files_are_told_of(case: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    spoil, message = HOSTILE[case]
    target = spoil(fmu_of(PATH, "2"), tmp_path / "x.fmu")
    commands = [["fmu", "check", "--no-run"], ["simulate", "-o", str(tmp_path / "x.csv")]]
    for command in commands[: 1 if case == "nothing but its root" else 2]:
        assert main([*command, str(target)]) == WRONG
        told = capsys.readouterr().err
        assert message in told and "Traceback" not in told and "bug:" not in told
    assert not (tmp_path / "x.csv").exists()


def test_missing_files_and_folders(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for path in (tmp_path, tmp_path / "none.fmu"):
        assert main(["fmu", "check", str(path)]) == WRONG
    told = capsys.readouterr().err
    assert "is a folder" in told and "there is no file" in told


def test_exit_codes(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """0 all is well, also with a warning; 1 what it does is wrong; 2 what is written in it is."""
    good = fmu_of(PATH, "2")
    warned = file("sources/fmi2Functions.h", b"/* */")(good, tmp_path / "warned.fmu")
    assert main(["fmu", "check", "--no-run", str(good), str(warned)]) == DONE
    assert "1 warning" in capsys.readouterr().out
    other = tmp_path / "other.fmu"  # its source has another motion
    broken(good, other, {"extra/io.github.lagrangia/double_pendulum.lag": replaced(
        r'(model DoublePendulum "[^"]*")', r"\1 AppliedTorque more(on = lower.center, torque = 0.01);")})
    assert main(["fmu", "check", str(other)]) == FAILED
    assert "away from the native run" in capsys.readouterr().err
    assert main(["fmu", "check", "--no-run", str(good), str(tmp_path / "none.fmu")]) == WRONG


def test_without_a_binary_for_this_machine(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good = fmu_of(PATH, "2")
    names = [name for name in zipfile.ZipFile(good).namelist() if name.startswith("binaries/")]
    target = broken(good, tmp_path / "x.fmu", dict.fromkeys(names))
    assert main(["fmu", "check", str(target)]) == DONE
    assert "it was not run" in capsys.readouterr().out
    assert main(["simulate", str(target)]) == WRONG
    assert "error[L0737]" in capsys.readouterr().err


@pytest.mark.skipif(shutil.which("gcc") is None, reason="needs gcc")
def test_what_crashes_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """The FMU runs in a process of its own."""
    monkeypatch.chdir(tmp_path)
    (tmp_path / "a.c").write_text("#include <stdlib.h>\n__attribute__((constructor)) static void f(void) { abort(); }\n")
    subprocess.run(["gcc", "-shared", "-fPIC", "-o", "a.so", "a.c"], check=True)
    good = fmu_of(PATH, "2")
    (name,) = (name for name in zipfile.ZipFile(good).namelist() if name.startswith("binaries/"))
    target = broken(good, tmp_path / "x.fmu", {name: (tmp_path / "a.so").read_bytes()})
    assert main(["simulate", str(target)]) == FAILED
    assert "the FMU has crashed (SIGABRT)" in capsys.readouterr().err
    assert main(["fmu", "check", str(target)]) == WRONG
    assert "the FMU has crashed" in capsys.readouterr().err


@pytest.mark.parametrize("name", ["'\u00e4'", "'a`b'", "'a\"b'"])
def test_names_beyond_the_structured_convention(name: str, tmp_path: Path) -> None:
    """It has some signs of ASCII alone between quotes: such names are flat ones."""
    text = f"model M parameter Mass {name} = 1; Block b(m = {name}, base = world); end M;"
    (tmp_path / "x.lag").write_text(text, encoding="utf-8")
    Model(tmp_path / "x.lag").export_fmu(tmp_path / "x.fmu")
    assert found(tmp_path / "x.fmu") == []


@pytest.mark.parametrize("identifier", ["../" * 9 + "tmp/outside", "/tmp/outside", "a\\\\b", "sub/a", ".."])
def test_no_library_outside_is_loaded(identifier: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    target = described(fmu_of(PATH, "2"), tmp_path / "x.fmu", 'modelIdentifier="[^"]*"', f'modelIdentifier="{identifier}"', 2)
    assert main(["fmu", "check", str(target)]) == WRONG
    told = capsys.readouterr()
    assert "is no C identifier" in told.err and "it was not run" in told.out
    assert main(["simulate", str(target), "-o", str(tmp_path / "x.csv")]) == WRONG
    assert "error[L0735]" in capsys.readouterr().err


def test_a_model_that_only_computes_is_an_fmu_without_states(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A torque between two others, of their angles and speeds."""
    model = tmp_path / "adaptor.lag"
    model.write_text("""model Adaptor input Angle phi; input AngularVelocity w;
      parameter TorsionStiffness c = 1e4; parameter TorsionDamping d = 10; output Torque tau = c*phi + d*w; end Adaptor;""")
    assert main(["export", str(model), "--to", "fmu", "-o", str(tmp_path / "adaptor.fmu")]) == DONE
    assert main(["fmu", "check", str(tmp_path / "adaptor.fmu")]) == DONE
    assert "0 states, 2 inputs, 1 output" in capsys.readouterr().out
    assert main(["simulate", str(model), "--at", "0,1", "-u", "phi=0.5", "-u", "w=2", "-o", str(tmp_path / "a.csv")]) == DONE
    assert (tmp_path / "a.csv").read_text().splitlines()[-1] == "1.0,5020.0"
    assert "stands still" not in capsys.readouterr().out


def test_what_friction_holds_has_derivatives_of_nothing(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """The differences of a force that is held are rounding, and no fault."""
    (tmp_path / "held.lag").write_text("model S Block b(m = 1, base = world); Spring p(k = 20, stretch = 0.1[m/s]*time - b.s); "
                                       "DryFriction rub(F = 2, F_static = 3, rate = b.v); end S;")
    Model(tmp_path / "held.lag").export_fmu(tmp_path / "held.fmu")
    assert main(["fmu", "check", str(tmp_path / "held.fmu")]) == 0
    assert "no fault" in capsys.readouterr().out


def test_what_is_no_number_and_texts_without_end_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A start that was no number ended in 'bug:', and a name of 50 MB was printed whole."""
    for command, old, new in ((("fmu", "check"), r'(causality="parameter"[^<]*<Real [^>]*start=")', r"\1x"),
                              (("simulate", "--stop", "0.01"), 'modelName="', 'modelName="' + "n" * 100_000),
                              (("simulate", "--stop", "0.01"), 'modelIdentifier="', 'modelIdentifier="' + "n" * 100_000)):
        target = broken(fmu_of(PATH, "2"), tmp_path / "x.fmu", {"modelDescription.xml": replaced(old, new)})
        assert main([*command, str(target), *(("-o", str(tmp_path / "x.csv")) if command[0] == "simulate" else ())]) in (0, 1, 2)
        said = capsys.readouterr()
        assert "bug:" not in said.err and len(said.out) < 10_000 and len(said.err) < 20_000


@pytest.mark.parametrize("name", ["", "\0a", "binaries\0/../../a"])
def test_entries_without_a_name_are_told(name: str, tmp_path: Path) -> None:
    """Python's zipfile looks at the last letter of a name that has none: 'bug:'."""
    target = tmp_path / "x.fmu"
    shutil.copy(fmu_of(PATH, "2"), target)
    with zipfile.ZipFile(target, "a") as archive:
        entry = zipfile.ZipInfo("q")
        entry.filename = name
        archive.writestr(entry, b"x")
    assert "is no name of a file" in next(d.message for d in found(target))
    assert main(["simulate", str(target), "-o", str(tmp_path / "o.csv")]) == WRONG


def test_work_grows_as_the_number_of_states(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """It grew as its square: the check of 4000 states took a minute."""
    counts = []
    for n in (100, 200):
        pairs = [(f"x{k}", k, "") for k in range(n)] + [(f"der(x{k})", n + k, f'derivative="{k + 1}"') for k in range(n)]
        variables = (f'<ScalarVariable name="{name}" valueReference="{k}" causality="local" variability="continuous">'
                     f"<Real {more}/></ScalarVariable>" for name, k, more in pairs)
        rows = "".join(f'<Unknown index="{n + k + 1}"/>' for k in range(n))
        text = (f'<fmiModelDescription fmiVersion="2.0" modelName="B" variableNamingConvention="structured"><ModelVariables>'
                f"{''.join(variables)}</ModelVariables><ModelStructure><Derivatives>{rows}</Derivatives></ModelStructure>"
                "</fmiModelDescription>")
        with zipfile.ZipFile(tmp_path / "x.fmu", "w") as archive:
            archive.writestr(DESCRIPTION, text)
        counts.append(0)

        def counted(element: Element, name: str, get: Callable[..., str | None] = Element.get) -> str | None:
            counts[-1] += 1
            return get(element, name)

        with monkeypatch.context() as patched:
            patched.setattr(Element, "get", counted)
            found(tmp_path / "x.fmu")
    assert counts[1] < 2.2 * counts[0]
