"""Text -> words and comments as they stand, by the tables of the parser: whatever the grammar says, is read here as well."""

import re
from functools import cache
from typing import NamedTuple

from lagrangia.base.diagnostics import Source
from lagrangia.language.reader import END, NotReadError, Tables
from lagrangia.language.syntax import parse, tables

COMMENT = "COMMENT"


class Piece(NamedTuple):
    """A word, or a comment. `kind` is the terminal that it is here, also of words that may be names elsewhere; `lines` how
    many lines end between the one before and this."""

    kind: str
    text: str
    start: int
    lines: int


def pieces_of(source: Source) -> list[Piece]:
    """Of a text without errors of syntax. Raises LagError (L01xx)."""
    try:
        return _recognized(source.text, tables())
    except NotReadError:
        parse(source)  # which says what is wrong
        return _cut(source.text, tables())


def same_words(one: str, other: str) -> bool:
    """Whether two texts differ in nothing but spaces and ends of lines."""
    return _plain(one) == _plain(other)


def _plain(text: str) -> list[str]:
    return [word.rstrip() for word in _splitter().findall(text) if not word.isspace()]


@cache
def _splitter() -> re.Pattern[str]:
    return re.compile(re.sub(r"\(\?P<\w+>", "(?:", tables().pattern))


@cache
def _moves() -> tuple[list[dict[str, int]], list[tuple[str, int]]]:
    """Of each state what comes after it, and of each rule what it is of and how long it is."""
    found = tables()
    return [dict(found.rows[row]) for row in found.row_of], [(rule[0], rule[1]) for rule in found.rules]


def _recognized(text: str, found: Tables) -> list[Piece]:
    """As reader.read, but that nothing is made of it. Raises NotReadError."""
    rows, rules = _moves()
    states, row = [found.start], rows[found.start]
    pieces = _cut(text, found)
    for k, piece in enumerate((*pieces, Piece(END, "", len(text), 0))):
        kind = piece.kind
        if kind == COMMENT:
            continue
        if kind == "NAME" and piece.text in found.words:
            kind = found.meant(piece.text, row, text, piece.start + len(piece.text)) or kind
            pieces[k] = piece._replace(kind=kind)
        while True:
            if (action := row.get(kind)) is None:
                raise NotReadError
            if action >= 0:
                break
            name, size = rules[-1 - action]
            if size:
                del states[-size:]
            states.append(rows[states[-1]][name])
            row = rows[states[-1]]
            if kind == END and states[-1] == found.end:
                return pieces
        states.append(action)
        row = rows[action]
    raise NotReadError


def _cut(text: str, found: Tables) -> list[Piece]:
    """Words and comments, whether or not they can stand where they do. Raises NotReadError for what is no word."""
    pieces: list[Piece] = []
    at = lines = 0
    for match in found.finditer(text):
        if match.start() != at:
            raise NotReadError
        at = match.end()
        kind, word = match.lastgroup, match.group()
        if kind != "ignored":
            pieces.append(Piece(kind, word, match.start(), lines))
            lines = 0
        elif word[0] == "/":
            pieces.append(Piece(COMMENT, word.rstrip(), match.start(), lines))
            lines = 0
        else:
            lines += word.count("\n")
    if at != len(text):
        raise NotReadError
    return pieces
