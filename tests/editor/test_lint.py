"""`lag lint`: what could be written better, by codes that can be allowed."""

from pathlib import Path

import pytest

from lagrangia.command.cli import main

SCENE = """partial model Lonely "used by nothing"
  Frame a;
end Lonely;

function Soft "called as a class is"
  input Length s;
  output Length y = s;
end Soft;

model Spring "as the library's"
  parameter Real k(unit = "N/m");
  Frame a, b;
equation
  distance(a, b) = 0.5[m];
energy
  potential k*distance(a, b)^2/2;
end Spring;

model M
  Block Sledge(m = 1, base = world);
  Spring spring(k = 1, a = shift(world, {0, 0.5}), b = Sledge.center);
  Real i = sum(2*i for i in 1:3);
  output Real unit = i*90[deg] + 1[m]/Soft(1);
  annotation(experiment(StopTime = 1));
end M;
"""
CODES = {"L0801": ["Lonely"], "L0802": ["'Spring' hides the library's", "this 'i' hides"], "L0803": ["0.5[m] stands"],
         "L0804": ["the name of a function", "'Sledge' is called as classes are"], "L0805": ['Real(unit = "N/m") has a name']}


def lint(text: str, folder: Path, *options: str) -> int:
    file = folder / "scene.lag"
    file.write_text(text)
    return main(["lint", str(file), *options])


def test_each_is_told_once_with_its_code(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lint(SCENE, tmp_path) == 1
    told = capsys.readouterr().err
    for code, words in CODES.items():
        assert told.count(f"warning[{code}]") == len(words), told
        assert all(word in told for word in words)
    assert "L0806" not in told and "90[deg]" not in told.replace(SCENE, "")


def test_what_stands_in_packages_and_in_formulas_of_variables(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """Names that a package gives to others of its own are not proposed there."""
    assert lint("""package P
  function sin "hides a function"
    input Real x;
    output Real y = 7*x;
  end sin;

  model Torque
    parameter Real k(unit = "N.m") = 2, power(unit = "W") = 3[W];
    Real pi = 3;
    Length s = 2[m] + sin(pi)*1[m], t = 2[m];
  end Torque;
end P;
""", tmp_path) == 1
    told = capsys.readouterr().err
    for code, words in (("L0802", "'sin' hides the language's"), ("L0802", "'pi' hides the constant"),
                        ("L0803", "2[m] stands in"), ("L0805", '"W") has a name')):
        assert f"warning[{code}]: " in told and told.count(words) == 1
    assert "N.m" not in told.replace('k(unit = "N.m")', "")


def test_codes_are_allowed_by_the_command_line_and_by_classes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lint(SCENE, tmp_path, "--allow", ",".join(CODES)) == 0
    text = SCENE.replace('annotation(experiment(StopTime = 1))', 'annotation(experiment(StopTime = 1), allow = "L0802,L0804")')
    capsys.readouterr()
    assert lint(text, tmp_path, "--strict") == 2
    told = capsys.readouterr().err
    assert "this 'i' hides" not in told and "'Sledge'" not in told.partition("L0804")[2].partition("-->")[0]
    assert "'Spring' hides" in told, "which another class says"
    assert lint(SCENE, tmp_path, "--allow", "L0999") == 2


def test_layout_is_looked_at(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lint("model M\n  Block b(m=1, base = world);\nend M;\n", tmp_path) == 1
    told = capsys.readouterr().err
    assert "warning[L0806]" in told and "scene.lag:2:1" in told


def test_what_check_warns_of_is_told_too_and_errors_are_errors(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert lint("model M\n  parameter Mass idle = 1;\n  Block b(m = 1, base = world);\nend M;\n", tmp_path) == 1
    assert "warning[L0224]" in capsys.readouterr().err
    assert lint("model M\n  Blok b(m = 1, base = world);\nend M;\n", tmp_path) == 2
    assert "error[L0201]" in capsys.readouterr().err


def test_models_in_packages_are_looked_at_as_check_does(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    text = "package P\n  model A\n    parameter Length L = 3;\n    Block b(m = 1, base = world);\n  end A;\nend P;\n"
    assert lint(text, tmp_path) == 1
    assert "nothing reads the parameter 'L'" in capsys.readouterr().err


def test_our_own_texts_are_clean(capsys: pytest.CaptureFixture[str]) -> None:
    models = Path(__file__).parents[2] / "models"
    files = [*sorted((models / "examples").glob("*.lag"))[::6], *sorted((models / "library").glob("[bj]*.lag"))]
    assert main(["lint", *map(str, files)]) == 0, capsys.readouterr().err
