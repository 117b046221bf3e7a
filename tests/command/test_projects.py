"""`lag new` and `lag test`: a project begins right, and its tests find what goes wrong."""

from pathlib import Path

import pytest

from lagrangia.command.cli import main


@pytest.fixture
def project(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "my_swing"]) == 0
    monkeypatch.chdir(tmp_path / "my_swing")
    return tmp_path / "my_swing"


def test_a_new_project_passes_all_that_its_line_for_ci_asks(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["format", "--check", "."]) == 0
    assert main(["lint", "my_swing.lag", "parts.lag"]) == 0
    capsys.readouterr()
    assert main(["test"]) == 0
    assert "1 passed, 0 failed" in capsys.readouterr().out
    assert main(["simulate", "my_swing.lag", "--quiet", "--stop", "1"]) == 0


def test_what_differs_is_told_with_time_and_size(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    table = project / "tests" / "TestSmallStretch.csv"
    table.write_text(table.read_text().replace("0.5,0.0540", "0.5,0.0541"))
    assert main(["test"]) == 1
    told = capsys.readouterr().out
    assert "FAILED TestSmallStretch" in told and "block.s differs by 0.0001 at t = 0.5 s" in told and "0 passed, 1 failed" in told
    assert main(["test", "--tolerance", "1e-2"]) == 0
    assert main(["test", "--tolerance", "nan"]) == 2
    table.write_text("time,block.s\n0,0.1\n1,nan\n")
    capsys.readouterr()
    assert main(["test"]) == 1 and "has nan for block.s at t = 1 s" in capsys.readouterr().out
    assert main(["test", "--update"]) == 0
    told = capsys.readouterr().out
    assert "updated TestSmallStretch" in told and "1 updated, 0 failed" in told
    assert main(["test", "--tolerance", "1e-9"]) == 0
    assert "der(block.s)" in table.read_text()


def test_runs_that_fail_and_texts_that_are_wrong(project: Path, capsys: pytest.CaptureFixture[str]) -> None:
    tests = project / "tests" / "more.lag"
    tests.write_text("model TestFalls Block b(m = 1, base = world, s(start = 1), v(start = -1));\n"
                     "  AppliedForce f(at = b.center, force = {-1[N.m2]/b.s^2, 0}); end TestFalls;\n")
    assert main(["test"]) == 1
    assert "FAILED TestFalls" in capsys.readouterr().out
    tests.write_text("model TestWrong Blok b(m = 1); end TestWrong;\n")
    assert main(["test"]) == 2
    assert "error[L0201]" in capsys.readouterr().out


def test_where_there_is_nothing_to_test_that_is_said(tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                                     capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["test"]) == 2
    assert "there is no .lag file in 'tests'" in capsys.readouterr().err
    (tmp_path / "tests").mkdir()
    (tmp_path / "tests" / "parts.lag").write_text("model M Block b(m = 1, base = world); end M;\n")
    assert main(["test"]) == 2
    assert "there is nothing to test" in capsys.readouterr().err
    assert main(["test", "tests/parts.lag"]) == 0


def test_names_that_cannot_be(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["new", "1 2"]) == 2 and "is no name for a project" in capsys.readouterr().err
    for taken in ("parts", "Real", "world", "spring", "softening_spring"):
        assert main(["new", taken]) == 2 and "is the name of something else" in capsys.readouterr().err
    (tmp_path / "there").mkdir()
    assert main(["new", "there"]) == 2 and "exists" in capsys.readouterr().err


def test_help_knows_commands_too(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["help", "lint"]) == 2
    assert "of the command: lag lint --help" in capsys.readouterr().err
