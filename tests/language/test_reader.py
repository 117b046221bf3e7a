"""The reader of texts makes what Lark's parser makes of them, whose tables it reads by."""

import random
import subprocess
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import pytest
from lark import Lark, UnexpectedInput

from lagrangia.base.diagnostics import LagError, Source
from lagrangia.base.folders import data_folder
from lagrangia.compile.pipeline import flatten_file
from lagrangia.language.grammar_tables import lark_parser
from lagrangia.language.reader import NOWHERE, Actor, NotReadError, Place, Word, read
from lagrangia.language.syntax import _Nodes, grammar_file, parse, tables

TEXTS = {file.name: file.read_text(encoding="utf-8") for file in sorted(data_folder("models").rglob("*.lag"))}
# Words and pieces of words that mean one thing here and another one there.
BITS = (*"end for if then final each input energy kinetic work on not and endfor ifx model initial equation true falsey".split(),
        *'" \' /* */ // := : = == <> .5 1. 2[m] [ ] ( ) { } . , ; ^ - + e5 1e in1 x.y'.split(), "3 [kN/m]", "\n", "é", "\ufeff",
        " ", '"a\\"b"', "'a b'")


@cache
def lark() -> Lark:
    return lark_parser(grammar_file())


def walk(tree: Any, actor: Actor) -> Any:
    """What an actor makes of a tree of Lark's."""
    place = NOWHERE if tree.meta.empty else Place(tree.meta.start_pos, tree.meta.end_pos)
    return getattr(actor, str(tree.data))(place, list(walked(tree.children, actor)))


def walked(children: Sequence[Any], actor: Actor) -> Iterator[Any]:
    for child in children:
        is_word = isinstance(child, str)
        yield (None if child is None else Word(child.type, str(child), child.start_pos, child.end_pos) if is_word  # type: ignore[attr-defined]
               else walk(child, actor))


def both(text: str) -> tuple[object, object]:
    """What the reader makes of it and what Lark does, with the errors told; None for what is not read."""
    source = Source("x", text)
    found: list[object] = []
    for make in (lambda nodes: read(text, tables(), nodes), lambda nodes: walk(lark().parse(text), nodes)):
        nodes = _Nodes(source)
        try:
            found.append((make(nodes), [str(error) for error in nodes.report.errors]))
        except (NotReadError, UnexpectedInput):
            found.append(None)
    return found[0], found[1]


@pytest.mark.parametrize("name", TEXTS)
def test_the_same_is_read_with_the_same_places(name: str) -> None:
    own, larks = both(TEXTS[name])
    assert own is not None
    assert own == larks
    assert repr(own) == repr(larks), "with all spans"


def test_what_is_nearly_a_text_is_read_alike_or_not_at_all() -> None:
    short = [text for text in TEXTS.values() if len(text) < 2500]
    choice = random.Random(5)
    read_by_both = 0
    for _ in range(400):
        text = choice.choice(short)
        for _ in range(choice.choice((1, 1, 2, 3))):
            at = choice.randrange(len(text))
            bit = choice.choice(("", choice.choice(BITS), f" {choice.choice(BITS)} "))
            text = text[:at] + bit + text[at + choice.choice((0, 0, 1, 2, 5)) :]
        own, larks = both(text)
        if own is not None:
            assert repr(own) == repr(larks), text
            read_by_both += 1
    assert 50 < read_by_both < 350


def test_words_that_another_lexer_cuts_are_left_to_it(tmp_path: Path) -> None:
    """`.5` is a number to the reader, and to Lark a dot and what cannot stand behind it; a text in a comment is none to both."""
    file = tmp_path / "x.lag"
    file.write_text("model M\n  Real x = world.5;\nend M;")
    with pytest.raises(LagError, match="L0103"):
        flatten_file(file)
    assert both('model M /* "a */ Real b = 1 /*"*/; end M;')[0] is not None


def test_words_are_whole_where_no_name_fits() -> None:
    """A keyword that another word begins with is not cut off it, as Lark's lexer does: what is unexpected is told whole."""
    with pytest.raises(LagError, match="unexpected 'ifx'"):
        parse(Source("x", "model M\n  Body b(m = 1 ifx 2);\nend M;\n"))


def test_what_is_wrong_is_told_without_lark() -> None:
    program = """
import sys
from lagrangia.base.diagnostics import LagError, Source
from lagrangia.language.syntax import parse
try:
    parse(Source("x", "model M Real x = (1; end M;"))
except LagError as error:
    print(error)
sys.exit("lark" in sys.modules)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, check=True)
    assert "unexpected ';'" in done.stdout
    assert "expected" in done.stdout
