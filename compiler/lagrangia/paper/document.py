"""A page of formulas: headings, paragraphs, displayed formulas and tables, printed by pages.py."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TypeAlias

from lagrangia.paper.layout import Node

Inline: TypeAlias = str | Node


@dataclass(frozen=True)
class Heading:
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
    head: tuple[str, ...]
    rows: tuple[tuple[Inline, ...], ...]


Block: TypeAlias = Heading | Paragraph | Display | Table


@dataclass(frozen=True)
class Document:
    title: str
    blocks: tuple[Block, ...]


def paragraph(*parts: Inline) -> Paragraph:
    return Paragraph(tuple(parts))


def display(formulas: Sequence[Node]) -> list[Block]:
    """Nothing for no formulas."""
    return [Display(tuple(formulas))] if formulas else []
