"""The reference of the language: short, and whole."""

import re

from lagrangia.base.folders import data_folder
from lagrangia.language.functions import REWRITTEN
from lagrangia.language.matrices import ARRAY_FUNCTIONS
from lagrangia.language.syntax import tables

TEXT = (data_folder("grammar") / "reference.md").read_text(encoding="utf-8")


def test_the_reference_is_of_at_most_600_lines() -> None:
    assert TEXT.count("\n") <= 600
    assert max(map(len, TEXT.splitlines())) <= 130


def test_every_word_of_the_grammar_and_every_function_of_arrays_stands_in_it() -> None:
    known = set(re.findall(r"\w+", TEXT))
    words = {word for word in tables().words if word not in ("discrete", "public")}
    assert sorted((words | ARRAY_FUNCTIONS.keys() | REWRITTEN.keys()) - known) == []
