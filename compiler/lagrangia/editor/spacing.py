"""What stands between the words of a statement: nothing or a space, and where a line may end."""

from collections.abc import Sequence
from functools import cache
from typing import NamedTuple

from lagrangia.editor.statements import CLOSE, OPEN
from lagrangia.editor.words import COMMENT, Piece

_TIGHT = frozenset(("*", "/", "^", ":"))
_SPACED = frozenset(("=", ":=", "==", "<>", "<", "<=", ">", ">=", ".*", "./", ".^", ".+", ".-"))
_SIGNS = frozenset("+-")
_OPERATORS = _TIGHT | _SPACED | _SIGNS
# After these a bracket or a sign begins an expression of its own; after other words it belongs to them: annotation(, der(.
_BEFORE_EXPRESSIONS = frozenset(
    "and or not if then else elseif when elsewhen in loop on for while return work kinetic potential dissipation".split())
_STAND_FOR_ALL = frozenset(("NAME", "NUMBER", "QUANTITY", "STRING", COMMENT))  # kinds of which a text does not matter
# What a line may begin with inside of a statement, the sooner the lower.
_LOGICAL, _SUM, _PRODUCT = 5, 6, 7
_BEGINS = {"annotation": 2, "constrainedby": 2, "if": 3, "then": 4, "else": 4, "elseif": 4, "for": 4, "on": 4,
           "and": _LOGICAL, "or": _LOGICAL, "+": _SUM, "-": _SUM, "*": _PRODUCT, "/": _PRODUCT}
_AFTER_COMMA, _DESCRIPTION = 1, 2
_GLUED, _APART, _OPERATOR, _SIGN = 0, 1, 2, 3


class Gap(NamedTuple):
    """Before a word: whether there is a space, in how many brackets, and how readily a line begins here (0: never)."""

    space: bool
    depth: int
    readiness: int


def gaps_of(pieces: Sequence[Piece]) -> list[Gap]:
    """One for each piece."""
    gaps: list[Gap] = []
    indices: list[bool] = []  # of the brackets that are open, whether they hold indices
    ranges = _ranges(pieces)
    before, tight = "", True  # the word before; whether nothing stands behind it, if it is an operator
    for k, piece in enumerate(pieces):
        word = piece[0] if piece[0] in _STAND_FOR_ALL else piece[1]
        if word in CLOSE and indices:
            indices.pop()
        between, begins, readiness = _between(before, word)
        if between == _OPERATOR and word == ".*" and pieces[0].text == "import":
            space = False
        elif between == _OPERATOR:
            tight = word in _TIGHT or (word in _SIGNS and (ranges[k] or indices[-1:] == [True]))
            space = not tight
        elif before in _OPERATORS:
            space, tight = not tight or word == COMMENT, True
        else:
            space = between != _GLUED
            tight = True
        if between == _SIGN:
            space, tight = space and before != "", True
        if readiness == _DESCRIPTION and indices and word == "STRING":
            readiness = 0
        gaps.append(Gap(space, len(indices), readiness))
        if word in OPEN:
            indices.append(word == "[" and not begins)
        before = word
    return gaps


@cache
def _between(before: str, word: str) -> tuple[int, bool, int]:
    """What stands there if they are no operators, or that the second is one; whether the second begins an expression; and how
    readily a line begins with it."""
    begins = before in ("", ",", ";") or before in OPEN or before in _OPERATORS or before in _BEFORE_EXPRESSIONS
    is_sign = word in _SIGNS and begins
    if word in _OPERATORS and not is_sign:
        between = _OPERATOR
    else:
        between = _SIGN if is_sign and _is_apart(before, word) else int(_is_apart(before, word))
    return between, begins, 0 if is_sign and before not in (",", ";") else _readiness(before, word)


def _is_apart(before: str, word: str) -> bool:
    if COMMENT in (before, word) or before in (",", ";"):
        return True
    if not before or word in (",", ";", ".") or word in CLOSE or before in OPEN or before == ".":
        return False
    return word not in OPEN or before in _BEFORE_EXPRESSIONS


def _readiness(before: str, word: str) -> int:
    if before in (",", ";"):
        return _AFTER_COMMA
    if word == "STRING":
        return _DESCRIPTION if before not in _OPERATORS else 0
    return 0 if not before or before in OPEN else _BEGINS.get(word, 0)


def _ranges(pieces: Sequence[Piece]) -> list[bool]:
    """Whether each stands in a range, from:to, of which the operands are written without spaces."""
    found = [False] * len(pieces)
    if all(piece.text != ":" for piece in pieces):
        return found
    starts = [0]  # of the operands in each open bracket
    for k, (kind, text, _, _) in enumerate(pieces):
        if text in OPEN:
            starts.append(k + 1)
        elif text in CLOSE and len(starts) > 1:
            starts.pop()
        elif text in (",", ";", "=", ":=", "in", "loop") and kind != "NAME":
            starts[-1] = k + 1
        elif text == ":":
            found[starts[-1] : k] = [True] * (k - starts[-1])
            _mark_end(pieces, found, k)
    return found


def _mark_end(pieces: Sequence[Piece], found: list[bool], start: int) -> None:
    depth = 0
    for k in range(start, len(pieces)):
        text = pieces[k].text
        depth += (text in OPEN) - (text in CLOSE)
        if depth < 0 or (depth == 0 and (text in (",", ";") or (text in ("loop", "for") and pieces[k].kind != "NAME"))):
            break
        found[k] = True
