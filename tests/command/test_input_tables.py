"""-u NAME=FILE: inputs as columns of files, each with its own times and units."""

import contextlib
from pathlib import Path

import numpy as np
import pytest

from lagrangia.command.cli import main

SCENE = """model In
  input Force F; input Force G; input Force H(start = 2);
  Block a(m = 1, base = world), b(m = 1, base = world), c(m = 1, base = world);
  AppliedForce f(at = a.center, force = {F, 0}), g(at = b.center, force = {G, 0}), h(at = c.center, force = {H, 0});
end In;"""


@pytest.fixture
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "in.lag").write_text(SCENE)
    (tmp_path / "F.csv").write_text("t [ms];F [kN];other\n0;0;1\n500;1;1\n2000;0,5;1\n")
    (tmp_path / "G.csv").write_text("0,0\n0.3,1\n1,2\n")
    return tmp_path


def last(folder: Path) -> dict[str, float]:
    names, *_, row = (folder / "out.csv").read_text().splitlines()
    return dict(zip(names.split(","), map(float, row.split(",")), strict=True))


def test_files_of_their_own_times_and_units(folder: Path) -> None:
    assert main("simulate in.lag -u F=F.csv -u G=G.csv -u H=3 -o out.csv".split()) == 0
    t = np.linspace(0, 1, 100_001)  # has all corners
    areas = [np.trapezoid(np.interp(t, *points), t) for points in (([0, 0.5, 2], [0, 1000, 500]), ([0, 0.3, 1], [0, 1, 2]))]
    found = last(folder)
    assert [found[f"der({name}.s)"] for name in "abc"] == pytest.approx([*areas, 3.0], rel=1e-12)


@pytest.mark.parametrize(("given", "what"), [
    ("-u F=F.csv -u F=3", "'F' is given twice"), ("-u F=F.csv -u F=G.csv", "'F' is given twice"),
    ("-u Q=F.csv", "the scene has no input 'Q'"), ("-u F=no.csv", "cannot be read"),
    ("-u G=F.csv", "no column 'G', and 3 columns"),
    ("-u F=F.csv -o F.csv", "a result does not take its place"), ("-u F=wrong.csv", "is in mm, and N is wanted"),
    ("-u alone.csv", "has no column beside its time"),
])
def test_what_is_wrong(given: str, what: str, folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    (folder / "wrong.csv").write_text("t,F [mm]\n0,1\n1,2\n")
    (folder / "alone.csv").write_text("time\n0\n1\n")
    assert main(f"simulate in.lag {given}".split()) == 2
    assert what in capsys.readouterr().err


def test_what_is_not_given_is_said(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main("simulate in.lag -u F=F.csv -o out.csv".split()) == 0
    told = capsys.readouterr().err
    assert "nothing is given for the input 'G': it is 0 N" in told and "'H'" not in told
    assert last(folder)["der(c.s)"] == pytest.approx(2.0)


def test_tables_of_inputs_as_spreadsheets_write_them(folder: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """A mark of the order of bytes is none of a name; 1_0 is no number; what no moment has is told, lines as the file counts."""
    table = folder / "T.csv"
    table.write_bytes(b"\xef\xbb\xbftime,F,G,H\n0,0,0,0\n\n1,0,0,0\n1,9,0,0\n1,0,0,0\n2,0,0,0\n")
    assert main(["simulate", "in.lag", "--stop", "2", "-u", "T.csv", "-o", "out.csv"]) == 0
    assert last(folder)["a.s"] == 0
    assert "more than two rows at 1 s: those between the first and the last have no effect" in capsys.readouterr().err
    table.write_text("time,F\n0,0\n\n1,1_0\n")
    assert main(["simulate", "in.lag", "-u", "T.csv", "-o", "out.csv"]) == 2
    assert "T.csv:4: '1_0' is no number" in capsys.readouterr().err
    assert main(["simulate", "in.lag", "-u", "F=1_0", "-o", "out.csv"]) == 2
    capsys.readouterr()
    for option, text in (("--stop", "1_0"), ("--stop", "١٠"), ("--max-steps", "1_0"), ("--at", "0,1_0"), ("--interval", "1_0")):
        with contextlib.suppress(SystemExit):
            assert main(["simulate", "in.lag", option, text, "-o", "out.csv"]) == 2
        told = capsys.readouterr()
        assert text.removeprefix("0,") in told.err and not told.out
