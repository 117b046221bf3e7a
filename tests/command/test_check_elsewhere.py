"""`lag check` looks at all of a file, not at what its last model uses alone."""

from pathlib import Path

import pytest

from lagrangia.base.diagnostics import Source
from lagrangia.command.cli import main
from lagrangia.compile import pipeline
from lagrangia.editor import whole
from lagrangia.editor.whole import read_back
from lagrangia.language.syntax import parse

SCENE = "model M Block b(m = 1, base = world); end M;"
WRONG = {  # beside the scene; what is told of it
    "partial model P Foo f; end P;": "there is no model or type 'Foo'",
    "partial model P Real k = kk; end P;": "'kk' is not known in P",
    "function f input Real x; output Real y = x + zz; end f;": "'zz' is not known in f",
    "function f input Length x; input Time t; output Real y = x + t; end f;": "m and s cannot be added",
    "function 'a b' input Real x; output Real y = 'a b'(x); end 'a b';": "calls itself",
    'type T = Real(unit = "fooo"); type V = Foo;': "'fooo' is not a unit",
    "model P Block q(m = 3, base = world, s(start = 3[s])); end P;": "the start of 'q.s' is in m",
}
RIGHT = ("partial model P Frame a, b; parameter Stiffness k; Length s = distance(a, b); end P; partial model Q extends P; end Q;",
         "function f input Length x; output Length y = x + g(1)*x; end f; function g input Real x; output Real y = x^2; end g;",
         'type T = Real(unit = "m"); type U = Integer(min = 0); type V = T(min = 0);',
         "model P parameter Mass m; Frame a; PointMass p(m = m, center = a); end P;")


@pytest.mark.parametrize("text", WRONG)
def test_what_is_wrong_beside_the_last_model_is_told_once(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(f"{text} {SCENE}")
    assert main(["check", str(file)]) == 2
    assert capsys.readouterr().err.count(WRONG[text]) == 1


@pytest.mark.parametrize("text", RIGHT)
def test_what_is_right_or_unfinished_is_not(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(f"{text} {SCENE}")
    assert main(["check", str(file)]) == 0, capsys.readouterr().err


def test_values_out_of_their_limits_are_told_by_every_command(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text("model M parameter Real x(max = 5) = 7; Block b(m = 1, base = world); output Real y = x*b.s; end M;")
    for command in ("check", "explain", "equations"):
        assert main([command, str(file)]) == 2
        assert "L0605" in capsys.readouterr().err
    file.write_text("model M parameter Real x(max = 5) = 3; Block b(m = 1, base = world); output Real y = x*b.s; end M;")
    assert main(["explain", str(file), "-p", "x=6"]) == 2
    assert main(["explain", str(file), "-p", "x=4"]) == 0


EARLIER = {  # before the scene; what of the motion is told of it
    "model A Block b(m = -1, base = world); end A;": "'b.m' is -1 kg",
    "model A Revolute h(a = world); end A;": "'h.phi' moves no mass",
    "model A PointMass p(m = 1); initial equation p.center.x = 1; p.center.x = 2; end A;": "is given two initial values",
    "model A Frame a; PointMass p(m = -2, center = a); end A;": "'p.m' is -2 kg",
    "package P model A Block b(m = -1, base = world); end A; end P;": "'b.m' is -1 kg",
}
PARTS = ("model A Frame a; Revolute h(a = world, b = a); end A;",
         "model A parameter Mass m = 1; end A; model B extends A; end B;",
         "model A input Real u = 1; output Real y = 2*u; end A;")


@pytest.mark.parametrize("text", EARLIER)
def test_earlier_scenes_are_compiled_whole(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(f"{text} {SCENE}")
    assert main(["check", str(file)]) == 2
    assert capsys.readouterr().err.count(EARLIER[text]) == 1


@pytest.mark.parametrize("text", PARTS)
def test_parts_need_not_move_by_themselves(text: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(f"{text} {SCENE}")
    assert main(["check", str(file)]) == 0, capsys.readouterr().err
    assert capsys.readouterr().out.count(": 1 degree") == 1


def test_packages_and_several_scenes_are_described(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(f"{SCENE.replace('M', 'First')} {SCENE}")
    assert main(["check", str(file)]) == 0
    assert [line.split(": ")[1] for line in capsys.readouterr().out.splitlines() if ": " in line] == ["First", "M"]
    file.write_text("package P model A Frame a; PointMass p(m = 1, center = a); end A; end P;")
    assert main(["check", str(file)]) == 0
    assert "1 model for others to use: P.A" in capsys.readouterr().out


def test_an_editor_is_told_of_earlier_scenes(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    file = tmp_path / "scene.lag"
    file.write_text(f"model A Block b(m = -1, base = world); end A; {SCENE.replace('m = 1', 'm = -2')}")
    assert whole.main([str(file)]) == 0
    found = read_back(capsys.readouterr().out, Source(str(file), file.read_text()))
    assert [(one.code, one.message[:23]) for one in found] == [("L0605", "the parameter 'b.m' is ")] * 2
    assert found[0].span is not None and found[1].span is not None and found[0].span.start > found[1].span.start


def test_a_file_of_many_models_is_read_once(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
                                            ) -> None:
    """Each of them had it read anew: 100 models took 19 s."""
    count = []
    monkeypatch.setattr(pipeline, "parse", lambda source: count.append(source) or parse(source))
    path = tmp_path / "many.lag"
    path.write_text("".join(f"model M{k} Block b(m = {k}, base = world); end M{k};\n" for k in range(1, 5)))
    assert main(["check", str(path)]) == 0
    assert capsys.readouterr().out.count("1 degree of freedom") == 4
    assert len(count) == 1
