"""The pages' own words in the language that is asked for: Phrase -> words and formulas, and the words inside of formulas."""

import re
from collections.abc import Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from lagrangia.paper.document import Block, Display, Document, Heading, Inline, Paragraph, Table
from lagrangia.paper.layout import Cases, Node, Phrase
from lagrangia.paper.phrase_table import LANGUAGES, PHRASES

_PLACE = re.compile(r"\{(\d)\}")


def translated(text: str, language: str) -> str:
    """A phrase, by its English words. KeyError for one that the table does not have."""
    return text if language == "en" else PHRASES[text][LANGUAGES.index(language) - 1]


def spoken(document: Document) -> Document:
    """The document with words and formulas in place of its phrases, all in its language."""
    language = document.language
    return replace(document, title="".join(map(str, _parts(document.title, language))),
                   blocks=tuple(_block(block, language) for block in document.blocks))


def _block(block: Block, language: str) -> Block:
    match block:
        case Heading(words, level):
            return Heading("".join(map(str, _parts(words, language))), level)
        case Paragraph(parts):
            return Paragraph(tuple(_sentence([x for part in parts for x in _parts(part, language)])))
        case Display():
            return replace(block, formulas=tuple(_formula(x, language) for x in block.formulas))
        case Table(head, rows):
            return Table(tuple(_cell(x, language) for x in head), tuple(tuple(_cell(x, language) for x in row) for row in rows))


def _cell(part: Inline, language: str) -> Inline:
    found = _parts(part, language)
    return found[0] if len(found) == 1 else "".join(map(str, found))


def _parts(part: Inline, language: str) -> list[Inline]:
    """A phrase as its words and what stands between them."""
    if not isinstance(part, Phrase):
        return [part if isinstance(part, str) else _formula(part, language)]
    found: list[Inline] = []
    for k, piece in enumerate(_PLACE.split(translated(part.text, language))):
        if k % 2 == 0:
            found += [piece] if piece else []
            continue
        value = part.values[int(piece)]
        for x in value if isinstance(value, Sequence) and not isinstance(value, str) else (value,):
            found += _parts(x, language)
    return found or [""]


def _sentence(parts: Sequence[Inline]) -> list[Inline]:
    """Neighbouring words in one piece."""
    found: list[Inline] = []
    for part in parts:
        if isinstance(part, str) and found and isinstance(found[-1], str):
            found[-1] += part
        else:
            found.append(part)
    return found


def _formula(node: Node, language: str) -> Node:
    return node if language == "en" else _reworded(node, language)


def _reworded(node: Any, language: str) -> Any:
    """A formula whose conditions are told in the language."""
    if isinstance(node, tuple):
        return tuple(_reworded(x, language) for x in node)
    if not is_dataclass(node) or isinstance(node, type):
        return node
    changed = {f.name: _reworded(getattr(node, f.name), language) for f in fields(node)}
    if isinstance(node, Cases):
        changed["words"] = tuple(translated(word, language) for word in node.words)
    return type(node)(**changed)
