"""A page of formulas: headings, paragraphs, displayed formulas and tables, printed by pages.py."""

from collections.abc import Sequence
from typing import TypeAlias

from lagrangia.base.records import dataclass
from lagrangia.paper.layout import Node

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
    """Formulas on lines of their own."""

    formulas: tuple[Node, ...]


@dataclass(frozen=True)
class Table:
    """Rows of cells under a head."""

    head: tuple[str, ...]
    rows: tuple[tuple[Inline, ...], ...]


Block: TypeAlias = Heading | Paragraph | Display | Table


@dataclass(frozen=True)
class Document:
    """A title and what stands below it."""

    title: str
    blocks: tuple[Block, ...]


def paragraph(*parts: Inline) -> Paragraph:
    """Words and formulas, one after the other."""
    return Paragraph(tuple(parts))


def display(formulas: Sequence[Node]) -> list[Block]:
    """Nothing for no formulas."""
    return [Display(tuple(formulas))] if formulas else []
