"""`lag format`: one layout, nothing lost, and the same meaning, over all texts of the repository and broken or strange ones."""

import dataclasses
import random
import re
import shutil
import time
from pathlib import Path
from typing import Any

import pytest

from helpers.fuzz_models import random_model
from helpers.fuzz_valid import valid_model
from lagrangia.base.diagnostics import LagError, Source, Span
from lagrangia.command.cli import main
from lagrangia.compile.pipeline import flatten_file
from lagrangia.editor.formatting import formatted
from lagrangia.editor.layout import WIDTH
from lagrangia.editor.spacing import gaps_of
from lagrangia.editor.words import Piece, pieces_of
from lagrangia.language.syntax import parse

ROOT = Path(__file__).parents[2]
MODELS = sorted((ROOT / "models").rglob("*.lag"))
TESTS = sorted((ROOT / "tests").rglob("*.lag"))
CRAMPED = """model M "d" // heading
parameter Real     x=1   "one";parameter Length long_one[ 3 ]={1,-2 , 3}; /* between */ Frame a,
b;Spring s(k=2*( 3+x ),a=world) if x>0;// behind
equation
for i in 1 : 2+1 loop
if x > 0 then long_one[i - 1] = - x^-2; elseif not (x<1 and x>2) then x=if x>0 then 1 else -1; else x=[ 1,2;3,4 ]; end if;

end for;
when x<0 then reinit(der(x),-pre(der(x))); end when;
energy kinetic -x; work x on a.r;
end M;
model N
end N;
"""
LAID_OUT = """model M "d" // heading
  parameter Real x = 1 "one";
  parameter Length long_one[3] = {1, -2, 3}; /* between */
  Frame a,
        b;
  Spring s(k = 2*(3 + x), a = world) if x > 0; // behind
equation
  for i in 1:2+1 loop
    if x > 0 then
      long_one[i-1] = -x^-2;
    elseif not (x < 1 and x > 2) then
      x = if x > 0 then 1 else -1;
    else
      x = y[1, 2];
    end if;
  end for;
  when x < 0 then
    reinit(der(x), -pre(der(x)));
  end when;
energy
  kinetic -x;
  work x on a.r;
end M;

model N
end N;
"""


def laid_out(text: str) -> str:
    return formatted(Source("scene.lag", text))


def meaning(node: Any) -> Any:
    """A tree, or a flat model, without places."""
    if isinstance(node, Source | Span):
        return None
    if dataclasses.is_dataclass(node):
        return type(node).__name__, [meaning(getattr(node, field.name)) for field in dataclasses.fields(node)]
    if isinstance(node, dict) and all(isinstance(key, int) for key in node):
        return len(node)  # by the places of expressions in memory: which of them are alike
    if isinstance(node, dict):
        return {key: meaning(value) for key, value in node.items()}
    return [meaning(item) for item in node] if isinstance(node, tuple | list) else repr(node)


def flat(file: Path, text: str) -> Any:
    """What a file means if this is its text, or what is wrong with it."""
    file.write_text(text, encoding="utf-8")
    try:
        return meaning(flatten_file(file)[1])
    except LagError as error:
        return [(found.code, re.sub(r"\.lag:[\d:]+", "", found.message)) for found in error.diagnostics]


def test_the_one_layout() -> None:
    text = CRAMPED.replace("[ 1,2;3,4 ]", "y[ 1,2 ]")
    assert laid_out(text) == LAID_OUT


@pytest.mark.parametrize("file", MODELS, ids=lambda file: file.stem)
def test_our_own_models_are_laid_out_so(file: Path) -> None:
    assert laid_out(file.read_text(encoding="utf-8")) == file.read_text(encoding="utf-8")


def test_texts_stay_what_they_are() -> None:
    """The same trees, and again the same text; all words and comments, in their order."""
    read = 0
    for file in [*MODELS, *TESTS]:
        text = file.read_text(encoding="utf-8")
        try:
            tree = parse(Source("x", text))
        except LagError:
            continue
        new = laid_out(text)
        read += 1
        assert laid_out(new) == new, file
        assert meaning(parse(Source("x", new)).classes) == meaning(tree.classes), file
    assert read > 300


@pytest.mark.slow
def test_models_mean_the_same_and_wrong_ones_are_as_wrong(tmp_path: Path) -> None:
    """All texts of the repository beside what they import, and those of the fuzzer, crowded to the left."""
    for part in ("models", "tests"):
        shutil.copytree(ROOT / part, tmp_path / part, ignore=shutil.ignore_patterns("__pycache__"))
    given = {tmp_path / file.relative_to(ROOT): re.sub(r"(?m)^ +", "", file.read_text(encoding="utf-8"))
             for file in [*MODELS, *TESTS] if file.parent.name != "library"}
    given |= {tmp_path / f"{seed}.lag": text for seed in range(30) for text in [random_model(seed)]}
    given |= {tmp_path / f"valid{seed}.lag": text for seed in range(30) for text in [valid_model(seed)]}
    right = 0
    for file, text in given.items():
        try:
            new = laid_out(text)
        except LagError:
            continue
        before = flat(file, text)
        right += isinstance(before, tuple)
        assert flat(file, new) == before, file
    assert right > 200


def test_strange_texts_stay_what_they_are() -> None:
    """Of the fuzzer, and these with spaces, ends of lines and comments anywhere between their words."""
    choice, read = random.Random(3), 0
    for seed in range(150):
        text = random_model(seed)
        try:
            parse(Source("x", text))
        except LagError:
            continue
        pieces, read = pieces_of(Source("x", text)), read + 1
        gaps = [choice.choice((" ", " ", "  ", "\n", "\n\n\n", " // c\n", " /* c\nd */ ", "\t")) for _ in pieces]
        scattered = "".join(gap + piece.text + ("\n" if piece.text.startswith("//") else "")
                            for gap, piece in zip(gaps, pieces, strict=True))
        for given in (text, scattered):
            new = laid_out(given)
            assert laid_out(new) == new, given
            assert meaning(parse(Source("x", new)).classes) == meaning(parse(Source("x", given)).classes)
    assert read > 80


def test_lines_that_are_too_long_end_where_it_suits() -> None:
    terms = " + ".join(f"some_name_{k}*another_{k}" for k in range(30))
    lines = laid_out(f'model M Real x = {terms} "{"d" * 150}"; Spring {", ".join(f"spring_number_{k}(k = 2)" for k in range(9))};'
                     " end M;").splitlines()
    assert all(len(line) <= WIDTH for line in lines if '"' not in line)
    assert lines[2].startswith("    + some_name")
    assert sum(line.startswith("         spring_number") for line in lines) >= 1


def test_words_of_modelica_stand_as_there() -> None:
    """What the grammar may come to know is laid out by its words, whatever reads it."""
    def spaced(*words: str) -> str:
        pieces = [Piece("NAME" if word.isidentifier() and word != "import" else word, word, 0, 0) for word in words]
        return "".join(" " * gap.space + piece.text for gap, piece in zip(gaps_of(pieces), pieces, strict=True))

    assert spaced("import", "A", ".", "B", ".*", ";") == "import A.B.*;"
    assert spaced("x", "=", "[", "1", ",", "2", ";", "3", ",", "-", "4", "]", ".*", "y", ";") == "x = [1, 2; 3, -4] .* y;"


def test_ten_thousand_lines_take_half_a_second() -> None:
    """Measured: 0.45 s of processor time; what is asked for here leaves room for busy machines, and none for another order."""
    text = "".join(file.read_text(encoding="utf-8") for file in MODELS)
    text *= 10_000 // text.count("\n") + 1
    start = time.process_time()
    laid_out(text)
    assert time.process_time() - start < 2


# ---------------------------------------------------------------- the command


def test_files_are_written_as_a_whole_or_not_at_all(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    good, wrong = tmp_path / "good.lag", tmp_path / "sub" / "wrong.lag"
    wrong.parent.mkdir()
    good.write_text("model M Real x = 1; end M;")
    wrong.write_text("model M Real x y z; end M;")
    assert main(["format", "--check", str(good)]) == 1
    assert main(["format", "--diff", str(good)]) == 0
    assert good.read_text() == "model M Real x = 1; end M;"
    assert "+  Real x = 1;" in capsys.readouterr().out
    assert main(["format", str(tmp_path)]) == 2
    assert good.read_text() == "model M\n  Real x = 1;\nend M;\n"
    assert wrong.read_text() == "model M Real x y z; end M;"
    told = capsys.readouterr()
    assert "error[L0103]: unexpected 'y'" in told.err and "wrong.lag:1:16" in told.err
    assert sorted(file.name for file in tmp_path.iterdir()) == ["good.lag", "sub"]
    assert main(["format", "--check", str(good)]) == 0


def test_what_is_not_there_is_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["format", str(tmp_path), str(tmp_path / "none.lag")]) == 2
    told = capsys.readouterr().err
    assert "there is no .lag file in" in told and "there is no file" in told
