"""A page of formulas: headings, paragraphs, displayed formulas and tables, printed by pages.py."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from string import ascii_lowercase
from typing import TypeAlias

from lagrangia.base.records import dataclass
from lagrangia.paper.layout import Letter, Node, Phrase, Words

Inline: TypeAlias = str | Node


@dataclass(frozen=True)
class Heading:
    """A title of a part; level 1 is the page's largest."""

    text: Inline
    level: int = 1


@dataclass(frozen=True)
class Paragraph:
    """Words and formulas in a line."""

    parts: tuple[Inline, ...]


@dataclass(frozen=True)
class Display:
    """Formulas on lines of their own; `labels` of those that have a letter, else "": first names, then the letters themselves."""

    formulas: tuple[Node, ...]
    labels: tuple[str, ...] = ()

    def lettered(self) -> Sequence[tuple[Node, str]]:
        """Each formula with its letter."""
        return list(zip(self.formulas, self.labels or ("",) * len(self.formulas), strict=True))


@dataclass(frozen=True)
class Table:
    """Rows of cells under a head."""

    head: tuple[Inline, ...]
    rows: tuple[tuple[Inline, ...], ...]


Block: TypeAlias = Heading | Paragraph | Display | Table


@dataclass(frozen=True)
class Document:
    """A title and what stands below it, in the language of the pages' own words.

    `figure` is the text of an SVG on pages of HTML, and of TikZ in LaTeX; other pages leave it out.
    """

    title: Inline
    blocks: tuple[Block, ...]
    figure: str = ""
    language: str = "en"


def say(text: str, *values: Inline | list[Inline]) -> Phrase:
    """Words of the pages' own: say("For {0}:", q)."""
    return Phrase(text, tuple(tuple(value) if isinstance(value, list) else value for value in values))


def words_of(part: Inline) -> str:
    """What is told without formulas: of a title, once its phrase is spoken."""
    assert isinstance(part, str)
    return part


def paragraph(*parts: Inline) -> Paragraph:
    """Words and formulas, one after the other."""
    return Paragraph(tuple(parts))


def display(formulas: Sequence[Node], labels: Sequence[str] = ()) -> list[Block]:
    """Nothing for no formulas."""
    return [Display(tuple(formulas), tuple(labels))] if formulas else []


def lettered(document: Document, first: str = "a") -> Document:
    """With letters from `first` on in place of the labels, in the order of the formulas; what refers to them follows."""
    names = [*ascii_lowercase, *("".join(pair) for pair in product(ascii_lowercase, repeat=2))]
    free = iter(names[names.index(first) :])
    letters: dict[str, str] = {}
    for block in document.blocks:
        for label in block.labels if isinstance(block, Display) else ():
            if label and label not in letters:
                letters[label] = next(free)

    def put(block: Block) -> Block:
        if isinstance(block, Display):
            return replace(block, labels=tuple(letters.get(label, "") for label in block.labels))
        return Paragraph(tuple(map(named, block.parts))) if isinstance(block, Paragraph) else block

    def named(part: Inline) -> Inline:
        if isinstance(part, Letter):
            return Words(f"({letters[part.label]})")
        return replace(part, values=tuple(map(all_named, part.values))) if isinstance(part, Phrase) else part

    def all_named(value: Inline | tuple[Inline, ...]) -> Inline | tuple[Inline, ...]:
        return tuple(map(named, value)) if isinstance(value, tuple) else named(value)

    return replace(document, blocks=tuple(map(put, document.blocks)))
