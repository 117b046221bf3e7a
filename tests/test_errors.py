"""Wrong models and what is said about them: tests/errors/NAME.lag, and beside it NAME.txt as `lag check NAME.lag` prints it.

The first line of each model says what is wrong with it. Only commands are called here, as a user would call them.
"""

import re
from collections.abc import Iterable
from pathlib import Path

import pytest

from lagrangia.cli import WRONG, main
from lagrangia.expectations import SPOKEN
from lagrangia.folders import data_folder

FOLDER = Path(__file__).parent / "errors"
MODELS = sorted(FOLDER.glob("*.lag"))
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
    compiler = Path(__file__).parents[1] / "compiler" / "lagrangia"
    raised = codes(r'"(L0[1-69]\d\d)"', compiler.glob("*.py"))
    assert sorted(raised - codes(r"error\[(L\d{4})\]", FOLDER.glob("*.txt")) - ELSEWHERE) == []


def codes(pattern: str, files: Iterable[Path]) -> set[str]:
    return {code for file in files for code in re.findall(pattern, file.read_text(encoding="utf-8"))}


def test_every_pattern_of_the_grammar_has_a_spoken_name() -> None:
    grammar = (data_folder("grammar") / "lag.lark").read_text(encoding="utf-8")
    patterns = {name for name in re.findall(r"^([A-Z_]+)(?:\.\d+)?:", grammar, re.MULTILINE) if name != "COMMENT"}
    assert sorted(patterns - SPOKEN.keys()) == []


# Told by `lag simulate` only (tests/test_hostile.py), or about bytes that no file of text can hold.
ELSEWHERE = {"L0101", "L0102", "L0605", "L0606", "L0909", "L0912", "L0916"}
