"""The pages' own words in other languages: no phrase is missing, none is left over, and the formulas are the same."""

import ast
import re
from pathlib import Path

import pytest

from helpers.symbolic_scenes import EXAMPLES
from lagrangia import paper
from lagrangia.command.cli import WRONG, main
from lagrangia.paper.document import Document, paragraph, say
from lagrangia.paper.layout import Cases, Name
from lagrangia.paper.pages import as_text
from lagrangia.paper.phrase_table import LANGUAGES, PHRASES
from lagrangia.paper.phrases import spoken

ROOM = Path(paper.__file__).parent
SAID_OTHERWISE = {"for", "otherwise", "Derived by Lagrangia from the model's energies."}


def said() -> set[str]:
    found = set()
    for file in ROOM.glob("*.py"):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if isinstance(node, ast.Call) and isinstance(node.func, ast.Name) and node.func.id == "say":
                first = node.args[0]
                assert isinstance(first, ast.Constant), f"{file.name}:{node.lineno}: the words of a phrase are one string"
                found.add(first.value)
    return found


def test_every_phrase_is_in_the_table_and_no_other() -> None:
    assert said() | SAID_OTHERWISE == set(PHRASES)


@pytest.mark.parametrize("text", PHRASES)
def test_translations_have_the_same_places(text: str) -> None:
    places = set(re.findall(r"\{\d\}", text))
    assert len(PHRASES[text]) == len(LANGUAGES) - 1
    for words in PHRASES[text]:
        assert words and set(re.findall(r"\{\d\}", words)) == places
        assert (words[-1] in ".:,") == (text[-1] in ".:,")


def page(capsys: pytest.CaptureFixture[str], name: str, *options: str) -> str:
    assert main(["equations", str(EXAMPLES / f"{name}.lag"), "--form", "worked", *options]) == 0
    return capsys.readouterr().out


@pytest.mark.parametrize("language", LANGUAGES[1:])
@pytest.mark.parametrize("name", ["suspended_bar", "slider_crank", "bouncing_ball"])
def test_pages_differ_in_words_alone(name: str, language: str, capsys: pytest.CaptureFixture[str]) -> None:
    """Paragraphs in both have the same formulas, and no word of English is left."""
    english, other = page(capsys, name), page(capsys, name, "--language", language)
    assert english.count("\n\n") == other.count("\n\n")
    shown = [[row for row in text.split("\n") if row.startswith("  ") and "=" in row] for text in (english, other)]
    assert shown[0] == shown[1] and len(shown[0]) > 5
    authors = " ".join(row for row in english.split("\n") if row.startswith("  ")) + english.split("\n\n")[2]
    words = set(re.findall(r"[a-z]+", other.lower())) - set(re.findall(r"[a-z]+", authors.lower()))
    assert not {"the", "of", "with", "and", "is"} & words


def test_html_says_its_language(capsys: pytest.CaptureFixture[str]) -> None:
    shown = page(capsys, "suspended_bar", "--language", "de", "--format", "html")
    assert '<html lang="de">' in shown and "Bewegungsgleichungen" in shown and "hergeleitet" in shown


def test_conditions_of_cases_are_told_too() -> None:
    cases = Cases(((Name("a"), Name("b")), (Name("c"), None)))
    shown = as_text(spoken(Document("", (paragraph(say("For {0}:", cases)),), language="fr")))
    assert "pour b" in shown and "sinon" in shown and "Pour" in shown


def test_a_language_that_is_not_there(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["equations", str(EXAMPLES / "suspended_bar.lag"), "--language", "dutch"]) == WRONG
    assert "the languages are en, pt, de, fr, es" in capsys.readouterr().err
