"""A statement -> its lines: where the author ended lines at places that suit, and where one would be too long."""

from collections.abc import Sequence

from lagrangia.base.records import dataclass
from lagrangia.editor.spacing import Gap, gaps_of
from lagrangia.editor.statements import Statement
from lagrangia.editor.words import COMMENT, Piece

WIDTH = 130
INDENT = "  "
_BREAKS_BEFORE = frozenset("+-*/")


@dataclass(slots=True)
class Laid:
    """A statement with what stands between its words, and the place of the name, where it declares one (or None). `wider` are
    spaces before words that align them with the lines above and below."""

    statement: Statement
    pieces: Sequence[Piece]
    gaps: list[Gap]
    name: int | None
    wider: dict[int, int]

    def offset(self, place: int) -> int:
        """Of a word from the begin of the statement, where all of it stands in one line."""
        return _length(self, range(place)) + self.gaps[place].space + self.wider.get(place, 0)


def prepare(statement: Statement) -> Laid:
    """Without what its neighbours do to it."""
    gaps = gaps_of(statement.pieces)
    return Laid(statement, statement.pieces, gaps, _name_of(statement.pieces, gaps), {})


def lines_of(laid: Laid) -> list[str]:
    """Of the statement, indented, without comments behind it."""
    indent = len(INDENT) * laid.statement.depth
    kept = _kept(laid)
    if len(kept) == 1 and len(line := line_of(laid)) <= WIDTH:
        return [line]
    name_column = indent + laid.offset(laid.name) if laid.name is not None else None
    rows: list[tuple[int, list[int]]] = []
    hanging = indent
    for first, last in kept:
        row = range(first, last)
        while row:
            if rows:
                indent, hanging = _indent(laid, row[0], indent, hanging, name_column)
            end = _fitting(laid, row, indent)
            rows.append((indent, list(row[:end])))
            row = row[end:]
            indent = len(INDENT) * laid.statement.depth
    return [" " * indent + _joined(laid, row) for indent, row in rows]


def line_of(laid: Laid) -> str:
    """The statement in one line."""
    return INDENT * laid.statement.depth + _joined(laid, range(len(laid.pieces)))


def _indent(laid: Laid, first: int, indent: int, hanging: int, name_column: int | None) -> tuple[int, int]:
    """Of a line that goes on, and from where the next ones count: further declarations stand below the first."""
    gap = laid.gaps[first]
    if name_column is not None and gap.depth == 0 and laid.pieces[first - 1].text == ",":
        return name_column, name_column
    return hanging + len(INDENT), hanging


def _kept(laid: Laid) -> list[tuple[int, int]]:
    """From where to where the lines go that are ended on purpose."""
    starts, last = [0], len(laid.pieces)
    for k, piece in enumerate(laid.pieces):
        if piece.lines and k:  # a comment up to the end of its line has an end of a line behind it
            is_behind = k > 1 and laid.pieces[k - 1].text in _BREAKS_BEFORE and laid.gaps[k - 1].readiness > 0
            if laid.gaps[k].readiness or laid.pieces[k - 1].text.startswith("//"):
                starts.append(k)
            elif is_behind and starts[-1] != k - 1:
                starts.append(k - 1)
    return list(zip(starts, [*starts[1:], last], strict=True))


def _fitting(laid: Laid, row: range, indent: int) -> int:
    """How many of these words one line takes: all, or up to the best place to end it."""
    if indent + _length(laid, row) <= WIDTH:
        return len(row)
    best, length = None, indent
    for k in row[1:]:
        length += _length(laid, range(k - 1, k))
        gap = laid.gaps[k]
        if length > WIDTH and best is not None:
            break
        key = (gap.depth, gap.readiness)
        if gap.readiness and (best is None or key <= best[0]):
            best = key, k - row[0]
    return len(row) if best is None else best[1]


def _length(laid: Laid, row: Sequence[int]) -> int:
    """Of these words in one line, with the spaces between them and before."""
    wider = sum(laid.wider.get(k, 0) for k in row) if laid.wider else 0
    return sum(len(laid.pieces[k].text) + (laid.gaps[k].space if k else 0) for k in row) + wider


def _joined(laid: Laid, row: Sequence[int]) -> str:
    pieces, gaps, wider = laid.pieces, laid.gaps, laid.wider
    if wider:
        words = [" " * (gaps[k].space + wider.get(k, 0)) + pieces[k].text for k in row]
    else:
        words = [f" {pieces[k].text}" if gaps[k].space else pieces[k].text for k in row]
    return "".join(words).lstrip(" ")


def _name_of(pieces: Sequence[Piece], gaps: Sequence[Gap]) -> int | None:
    """The first name behind a type, or the first word of an energy."""
    for k in range(1, len(pieces)):
        kind, before = pieces[k].kind, pieces[k - 1]
        if pieces[0].kind == "ENERGY" and before.kind != COMMENT:
            return k
        if gaps[k].depth == 0 and kind == "NAME" and (before.kind == "NAME" or before.text == "]"):
            return k
        if pieces[k].text in ("(", "=", ":="):
            return None
    return None
