"""Blocks of statements (if, for, when, while) that are open where parsing stopped."""

from collections.abc import Iterator

from lagrangia.base.records import dataclass
from lagrangia.language.reader import Word
from lagrangia.language.recovery import Stop

_BLOCKS = ("IF", "FOR", "WHEN", "WHILE")
_HEADS = (*_BLOCKS, "ELSEIF", "ELSEWHEN")
_SECTIONS = ("EQUATION", "ALGORITHM", "__ANON_0", "DRAWING")


@dataclass(frozen=True)
class OpenBlock:
    """The word that begins it, and whether it is an `else if`, or holds one."""

    word: Word
    has_else_if: bool


def open_blocks(stop: Stop) -> list[OpenBlock]:
    """From the outermost to the innermost. The ifs of expressions are none."""
    opened: list[OpenBlock] = []
    before: Word | None = None
    for word in _first_words(stop):
        if before is not None and before.type == "END":
            if word.type in _BLOCKS and opened:
                opened.pop()
            elif word.type == "NAME":
                opened.clear()  # a class ends
        elif word.type in _BLOCKS:
            is_else_if = before is not None and before.type == "ELSE"
            if is_else_if and opened:
                opened[-1] = OpenBlock(opened[-1].word, True)
            opened.append(OpenBlock(word, is_else_if))
        before = word
    return opened


def _first_words(stop: Stop) -> Iterator[Word]:
    """What statements, branches and sections begin with, and what stands behind `end`."""
    is_first, is_head, is_behind_end = False, False, False
    for word in stop.before:
        if is_first or is_behind_end:
            yield word
            is_head = word.type in _HEADS and not is_behind_end
        is_behind_end = is_first and word.type == "END"
        opens = is_head and word.type in ("THEN", "LOOP")
        is_first = word.type in ("SEMICOLON", *_SECTIONS) or opens or (is_first and word.type == "ELSE")
        is_head = is_head and not opens
