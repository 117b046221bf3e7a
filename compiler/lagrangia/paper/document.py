"""A page of formulas: headings, paragraphs, displayed formulas and tables, printed by pages.py."""

from collections.abc import Sequence
from dataclasses import replace
from itertools import product
from string import ascii_lowercase
from typing import TypeAlias

from lagrangia.base.records import dataclass
from lagrangia.paper.layout import Letter, Node, Words

Inline: TypeAlias = str | Node


@dataclass(frozen=True)
class Heading:
    """A title of a part; level 1 is the page's largest."""

    text: str
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

    head: tuple[str, ...]
    rows: tuple[tuple[Inline, ...], ...]


Block: TypeAlias = Heading | Paragraph | Display | Table


@dataclass(frozen=True)
class Document:
    """A title and what stands below it; `figure` is the text of an SVG, which pages that show none leave out."""

    title: str
    blocks: tuple[Block, ...]
    figure: str = ""


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
        if isinstance(block, Paragraph):
            return Paragraph(tuple(Words(f"({letters[x.label]})") if isinstance(x, Letter) else x for x in block.parts))
        return block

    return replace(document, blocks=tuple(map(put, document.blocks)))
