"""A file that Lagrangia did not write is kept where nobody named it; what it wrote is written anew."""

import zipfile
from contextlib import nullcontext
from pathlib import Path

import pytest

from lagrangia.base.diagnostics import LagError
from lagrangia.command.cli import main
from lagrangia.command.fmu_export import _keep_others

SCENE = "model R \"a <block> on a spring\" Block b(m = 1, base = world, s(start = 0.1)); Spring s(k = 9, stretch = b.s); end R;"
COMMANDS = {"draw road.lag": "road.svg", "animate road.lag --stop 0.1": "road.html", "export road.lag --to python": "R.py",
            "export road.lag --to modelica": "R.mo", "export road.lag --to sympy": "R.py"}


@pytest.mark.parametrize("command", COMMANDS)
def test_it_is_kept(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("road.lag").write_text(SCENE)
    words, file = command.split(), Path(COMMANDS[command])
    file.write_text("model R // mine\nend R;")
    assert main(words) == 2
    assert "L0004" in (said := capsys.readouterr().err) and "it is kept" in said
    assert file.read_text() == "model R // mine\nend R;"
    assert main([*words, "-o", file.name]) == 0
    first = file.read_text()
    assert main(words) == 0
    assert file.read_text() == first


def test_an_fmu_of_others_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path("road.lag").write_text(SCENE)
    Path("R.fmu").write_text("mine")
    assert main(["export", "road.lag", "--to", "fmu"]) == 2
    assert "it is kept" in capsys.readouterr().err
    for tool, is_kept in (("Other 1.0", True), ("Lagrangia 0.1.0", False)):
        with zipfile.ZipFile("R.fmu", "w") as archive:
            archive.writestr("modelDescription.xml", f'<fmiModelDescription generationTool="{tool}"/>')
        with pytest.raises(LagError, match="it is kept") if is_kept else nullcontext():
            _keep_others("R", ("",))


@pytest.mark.parametrize(("name", "told"), [("q.csv", "is a table"), ("q.fmu", "is an FMU"), ("q.mo", "lag import")])
def test_what_is_no_scene_by_its_name_is_not_read_as_one(name: str, told: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                         capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    Path(name).write_bytes(b"time,x\n0,\xff\n")
    for command in ("check", "explain", *(("simulate",) if name == "q.csv" else ())):
        assert main([command, name]) == 2
        assert "L0001" in (said := capsys.readouterr().err) and told in said


@pytest.mark.parametrize("command", [
    "equations r.lag -o road.csv", "export r.lag --to modelica --components -o road.csv", "simulate r.lag --stop 1 -o road.csv",
    "export r.lag --to modelica --components -o r.lag", "import robot.urdf -o robot.urdf", "import s.xml -o inner.xml",
    "import s.xml -o s.xml", "export drive.lag --to modelica --components -o drive.lag"])
def test_what_is_read_is_no_place_for_a_result(command: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                               capsys: pytest.CaptureFixture[str]) -> None:
    """Tables of the scene, robots, included files and the scene itself: they were written over, exit code 0."""
    monkeypatch.chdir(tmp_path)
    files = {"r.lag": 'model R Block b(m = 1, base = world); output Real y = table(b.s, "road.csv", column = 2); end R;',
             "drive.lag": 'import Rotational.*; model D Inertia a(J = 1); end D;',
             "road.csv": "x,y\n0,0\n1,1\n", "robot.urdf": '<robot name="r"><link name="a"/></robot>',
             "s.xml": '<mujoco><include file="inner.xml"/></mujoco>', "inner.xml": "<mujocoinclude><worldbody><body><freejoint/>"
             '<geom size="0.1" mass="1"/></body></worldbody></mujocoinclude>'}
    for name, text in files.items():
        Path(name).write_text(text)
    assert main(command.split()) == 2
    assert "a result does not take its place" in capsys.readouterr().err
    assert {name: Path(name).read_text() for name in files} == files
