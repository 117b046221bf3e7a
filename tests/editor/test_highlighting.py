"""Colours: Pygments' lexer and the TextMate grammar of the VS Code extension know the words of the grammar."""

import json
import re
import tomllib
from pathlib import Path

import pytest

from lagrangia.language.syntax import tables

pygments = pytest.importorskip("pygments")
ROOT = Path(__file__).parents[2]
EXTENSION = ROOT / "grammar" / "vscode"
TEXTS = sorted((ROOT / "models").rglob("*.lag"))


def test_pygments_colours_all_of_our_texts() -> None:
    from pygments.token import Error

    from lagrangia.editor.highlighting import LagrangiaLexer

    lexer = LagrangiaLexer(stripnl=False)
    for file in TEXTS:
        text = file.read_text(encoding="utf-8")
        found = list(lexer.get_tokens(text))
        assert not [value for kind, value in found if kind is Error], file
        assert "".join(value for _, value in found) == text


def test_words_units_and_names_have_colours_of_their_own() -> None:
    from pygments.token import Comment, Keyword, Name, Number

    from lagrangia.editor.highlighting import LagrangiaLexer

    text = 'model M // c\n  parameter Length L = 1.5[kN/m]; equation when sin(time) > 0 then end when; end M;'
    kinds = {value: kind for kind, value in LagrangiaLexer().get_tokens(text)}
    assert kinds["M"] is Name.Class and kinds["// c"] is Comment.Single and kinds["parameter"] is Keyword.Declaration
    assert kinds["1.5"] is Number and kinds["[kN/m]"] is Number.Other and kinds["sin"] is Name.Builtin
    assert kinds["when"] is Keyword and kinds["equation"] is Keyword and kinds["L"] is Name


def test_pygments_finds_it_by_its_entry_point() -> None:
    project = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
    place = project["entry-points"]["pygments.lexers"]["lagrangia"]
    module, _, name = place.partition(":")
    assert hasattr(__import__(module, fromlist=[name]), name)


def test_the_extension_knows_the_words_of_the_grammar() -> None:
    grammar = json.loads((EXTENSION / "syntaxes" / "lag.tmLanguage.json").read_text(encoding="utf-8"))
    known = {word for pattern in grammar["repository"]["words"]["patterns"]
             for word in re.search(r"\((.*)\)", pattern["match"])[1].split("|")}
    assert sorted(tables().words.keys() - known) == []


def test_the_extension_names_files_that_exist() -> None:
    package = json.loads((EXTENSION / "package.json").read_text(encoding="utf-8"))
    given = package["contributes"]
    names = [package["main"], given["languages"][0]["configuration"], given["grammars"][0]["path"]]
    assert all((EXTENSION / name).is_file() for name in names)
    json.loads((EXTENSION / "language-configuration.json").read_text(encoding="utf-8"))
    assert given["languages"][0]["extensions"] == [".lag"]


def test_its_patterns_are_right_for_a_text() -> None:
    """Those that Python's expressions can try, on words of a text."""
    rules = json.loads((EXTENSION / "syntaxes" / "lag.tmLanguage.json").read_text(encoding="utf-8"))["repository"]
    assert re.fullmatch(rules["numbers"]["match"], "1.5[kN/m]")[2] == "[kN/m]"
    assert re.match(rules["ends"]["match"], "end Spring;")[2] == "Spring" and not re.match(rules["ends"]["match"], "end for;")
    assert re.match(rules["classes"]["match"], "model Spring")[2] == "Spring"
