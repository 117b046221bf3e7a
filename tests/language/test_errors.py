"""Wrong models and what is said about them: tests/errors/NAME.lag, and beside it NAME.txt as `lag check NAME.lag` prints it.

The first line of each model says what is wrong with it. Only commands are called here, as a user would call them.
"""

import random
import re
from collections.abc import Iterable
from pathlib import Path

import pytest

from lagrangia.base.diagnostics import LagError, Source
from lagrangia.base.folders import data_folder
from lagrangia.command.cli import WRONG, main
from lagrangia.compile.pipeline import flatten_file, read_files
from lagrangia.language.expectations import SPOKEN
from lagrangia.language.syntax import parse

FOLDER = Path(__file__).parents[1] / "errors"
MODELS = sorted(FOLDER.glob("*.lag"))
LIBRARY = sorted((data_folder("models") / "library").glob("*.lag"))
# Words of the compiler's inside, which nobody who writes models should meet.
INNER_WORDS = re.compile(r"__|Traceback|lagrangia|\b(?:ANON|Flat\w*|FrameRef|Slot|[LR]PAR|[LR]SQB|Token|None|prefix|NAME)\b")


@pytest.mark.parametrize("model", MODELS, ids=lambda path: path.stem)
def test_told(model: Path, compare, capsys, monkeypatch) -> None:
    monkeypatch.chdir(FOLDER)
    assert main(["check", model.name]) == WRONG
    told = capsys.readouterr()
    assert told.out == ""
    assert not INNER_WORDS.search(told.err.replace(model.stem, ""))
    compare(told.err, model.with_suffix(".txt"))


@pytest.mark.parametrize("model", MODELS, ids=lambda path: path.stem)
def test_says_what_is_wrong(model: Path) -> None:
    first = model.read_text(encoding="utf-8").splitlines()[0]
    assert first.startswith("// ") and first.endswith(".")


def test_every_expectation_has_its_model() -> None:
    assert {file.stem for file in FOLDER.glob("*.txt")} == {model.stem for model in MODELS}


def test_every_code_of_models_is_covered() -> None:
    """Codes of files, syntax, names, units, graph, energies, initial values: all that `lag check` can say."""
    compiler = Path(__file__).parents[2] / "compiler" / "lagrangia"
    raised = codes(r'"(L0[1-69]\d\d)"', compiler.rglob("*.py"))
    assert sorted(raised - codes(r"error\[(L\d{4})\]", FOLDER.glob("*.txt")) - ELSEWHERE) == []


def codes(pattern: str, files: Iterable[Path]) -> set[str]:
    return {code for file in files for code in re.findall(pattern, file.read_text(encoding="utf-8"))}


def test_every_pattern_of_the_grammar_has_a_spoken_name() -> None:
    grammar = (data_folder("grammar") / "lag.lark").read_text(encoding="utf-8")
    patterns = {name for name in re.findall(r"^([A-Z_]+)(?:\.\d+)?:", grammar, re.MULTILINE) if name != "COMMENT"}
    assert sorted(patterns - SPOKEN.keys()) == []


@pytest.mark.parametrize("file", LIBRARY, ids=lambda file: file.stem)
def test_a_fault_of_the_text_is_told_once(file: Path) -> None:
    """One, two or three signs are taken away or replaced: no more is told than was broken."""
    text, chance = file.read_text(encoding="utf-8"), random.Random(file.stem)
    signs = [sign.start() for sign in re.finditer(r"[;,=()\[\]{}]", text)]
    for _ in range(12):
        count = chance.randint(1, 3)
        places = sorted(chance.sample(signs, count), reverse=True)
        broken = text
        for place in places:
            broken = broken[:place] + chance.choice(("", "?", ")", "= =", "+;")) + broken[place + 1 :]
        try:
            parse(Source(file.name, broken))
        except LagError as error:
            assert len(error.diagnostics) <= count, broken


# Told by `lag simulate` only (tests/command/test_hostile.py), a warning (below), or about bytes that no file of text can hold.
ELSEWHERE = {"L0101", "L0102", "L0224", "L0237", "L0239", "L0305", "L0306", "L0605", "L0606", "L0607", "L0608", "L0609", "L0610",
             "L0908", "L0909", "L0912", "L0916"}


# ---------------------------------------------------------------- warnings

IGNORED = """
model Cart "Its damper is there on demand, and its damping is no false alarm"
  parameter Boolean damped = false;
  parameter Damping c = 1;
  Frame base;
  Block block(m = 1, base = base);
  Damper brake(c = c, rate = block.v) if damped;
end Cart;
model Marker
  parameter Length above = 0;
  Frame at;
  Length height = at.y - above;
end Marker;
model Ignored
  Cart cart(base = world, c = 2);
  Marker marker(at = cart.block.center, above = 2);
  Disc disc(m = 1, r = 0.1, I = 2, center = cart.block.center);
  Spring both(k = 10, s_rel0 = 0.1, a = world, b = cart.block.center, stretch = cart.block.s);
  GeneralSpring other(V = 1[N/m]*cart.block.s^2, s_rel0 = 0.2);
end Ignored;
"""


@pytest.mark.parametrize("command", ["check", "simulate", "modes", "sweep -p both.k=1,2"])
def test_what_is_given_and_read_by_nothing_is_told(command: str, tmp_path: Path, capsys, monkeypatch) -> None:
    monkeypatch.chdir(tmp_path)
    Path("ignored.lag").write_text(IGNORED)
    first, *others = command.split()
    assert main([first, "ignored.lag", *others]) == 0
    told = capsys.readouterr().err
    assert told.count("warning[L0224]") == 2
    assert "nothing reads 's_rel0', 'a' and 'b' of Spring 'both', though they are given" in told
    assert "write stretch = cart.block.s - 0.1" in told
    assert "only 'stretch' reads 's_rel0', and nothing reads 'stretch'" in told


TESTS = FOLDER.parent
FOLDERS = TESTS.parent / "models" / "examples", TESTS / "cases", TESTS / "benchmarks" / "scenes"
SCENES = [file for folder in FOLDERS for file in sorted(folder.glob("*.lag"))]


@pytest.mark.parametrize("file", SCENES, ids=lambda file: file.stem)
def test_no_scene_of_ours_gives_anything_in_vain(file: Path) -> None:
    classes = read_files(file)[0].classes
    parts = {element.type_name for item in classes for element in item.elements}
    models = [item.name for item in classes if item.kind == "model" and not item.is_partial and item.name not in parts]
    assert models
    assert [flatten_file(file, name)[1].warnings for name in models] == [()] * len(models)
