"""Pieces of a text -> its statements, in the order in which they stand: what takes a line, or several, of its own."""

from collections.abc import Sequence
from dataclasses import field
from itertools import islice

from lagrangia.base.records import dataclass
from lagrangia.editor.words import COMMENT, Piece

_SECTIONS = frozenset(("equation", "initial", "energy", "algorithm", "drawing", "public", "protected"))
_OPENERS = {"if": "then", "for": "loop", "when": "then", "while": "loop"}
_BRANCHES = {"elseif": "then", "elsewhen": "then", "else": ""}
OPEN, CLOSE = frozenset("([{"), frozenset(")]}")


@dataclass(slots=True)
class Statement:
    """Words from one line's begin on. `depth` counts what it stands in; `is_apart` where an empty line stands before it."""

    pieces: list[Piece]
    depth: int
    is_apart: bool
    trailing: list[Piece] = field(default_factory=list)  # comments behind it, on its last line

    @property
    def is_comment(self) -> bool:
        """Whether it is nothing else."""
        return self.pieces[0].kind == COMMENT


def statements_of(pieces: Sequence[Piece]) -> list[Statement]:
    """All of a text without errors of syntax."""
    return _Cutter(pieces).statements


class _Cutter:
    """`inside` has for each class or block that is open whether it is a class."""

    def __init__(self, pieces: Sequence[Piece]) -> None:
        self.pieces, self.at = pieces, 0
        self.inside: list[bool] = []
        self.statements: list[Statement] = []
        self.was_opened = True  # a class, a section or a block begins: no empty line after that
        self.was_class = False  # one has ended: an empty line after that
        while self.at < len(pieces):
            self._next()

    def _next(self) -> None:
        piece = self.pieces[self.at]
        if piece.kind == COMMENT:
            if self.statements and piece.lines == 0 and not self.statements[-1].is_comment:
                self.statements[-1].trailing.append(piece)
                self.at += 1
            else:
                self._take(self.at + 1, len(self.inside))
            return
        word = piece.text if piece.kind != "NAME" else ""
        if word == "end":
            self._close()
        elif word in _SECTIONS and self.inside and self.inside[-1]:
            self._take(self.at + (2 if word == "initial" else 1), len(self.inside) - 1, opens=True)
        elif word in _BRANCHES and self.inside:
            end = self._head(_BRANCHES[word]) if _BRANCHES[word] else self.at + 1
            self._take(end, len(self.inside) - 1, opens=True)
        elif word in _OPENERS:
            self._take(self._head(_OPENERS[word]), len(self.inside), opens=True)
            self.inside.append(False)
        elif (head := self._class_head()) is not None:
            self._take(head, len(self.inside), opens=True, is_class=True)
            self.inside.append(True)
        else:
            self._take(self._end(self.at), len(self.inside))

    def _take(self, end: int, depth: int, opens: bool = False, is_class: bool = False) -> None:
        """The pieces up to `end` are a statement."""
        taken = list(self.pieces[self.at : end])
        is_first = is_class and bool(self.statements) and not self.statements[-1].is_comment
        is_apart = not self.was_opened and (taken[0].lines > 1 or is_first or self.was_class)
        self.statements.append(Statement(taken, depth, is_apart))
        self.was_opened, self.was_class, self.at = opens, False, end

    def _close(self) -> None:
        is_class = self.inside.pop() if self.inside else True
        self.was_opened = True  # no empty line before it
        self._take(self._end(self.at), len(self.inside))
        self.was_class = is_class

    def _end(self, start: int) -> int:
        """Behind the next semicolon that is in no bracket."""
        depth = 0
        for k in range(start, len(self.pieces)):
            text = self.pieces[k].text
            if text in OPEN:
                depth += 1
            elif text in CLOSE:
                depth -= 1
            elif text == ";" and depth == 0:
                return k + 1
        return len(self.pieces)

    def _head(self, last: str) -> int:
        """Behind the word that ends the head of a block; conditions in it have some of their own."""
        waiting = depth = 0
        for k in range(self.at + 1, len(self.pieces)):
            kind, text = self.pieces[k][:2]
            depth += (text in OPEN) - (text in CLOSE)
            if depth or kind == "NAME":
                continue
            if text in ("if", "elseif"):
                waiting += 1
            elif text == last and waiting == 0:
                return k + 1
            elif text == "then":
                waiting -= 1
        return len(self.pieces)

    def _class_head(self) -> int | None:
        """Behind the head of a class that has an end of its own; None where no such class begins."""
        k = self.at
        while k < len(self.pieces) and self.pieces[k].kind not in ("NAME", "CLASS_KIND") and self.pieces[k].text.isalpha():
            k += 1
        if k == len(self.pieces) or self.pieces[k].kind != "CLASS_KIND":
            return None
        words = list(islice((j for j in range(k + 1, len(self.pieces)) if self.pieces[j].kind != COMMENT), 3))
        extends = bool(words) and self.pieces[words[0]].text == "extends" and self.pieces[words[0]].kind != "NAME"
        names = words[1:] if extends else words
        if len(names) < 2 or self.pieces[names[0]].kind != "NAME" or self.pieces[names[1]].text == "=":
            return None
        end = names[0]
        if extends and self.pieces[names[1]].text == "(":
            end = self._closed(names[1])
        follows = next((j for j in range(end + 1, len(self.pieces)) if self.pieces[j].kind != COMMENT), end)
        return follows + 1 if self.pieces[follows].kind == "STRING" else end + 1

    def _closed(self, start: int) -> int:
        """Where the bracket ends that begins here."""
        depth = 0
        for k in range(start, len(self.pieces)):
            depth += (self.pieces[k].text in OPEN) - (self.pieces[k].text in CLOSE)
            if depth == 0:
                return k
        return len(self.pieces) - 1
