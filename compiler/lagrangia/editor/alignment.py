"""Words of neighbouring lines below each other, where their author put them so: names, values, descriptions, comments."""

from collections.abc import Iterator, Sequence
from itertools import accumulate

from lagrangia.base.records import dataclass
from lagrangia.editor.layout import Laid, line_of
from lagrangia.editor.statements import Statement
from lagrangia.editor.words import Piece

_NOWHERE = -1


@dataclass(slots=True)
class _Stop:
    """A word that may be aligned: where it stands in the text, from the begin of its statement, and where it stands without."""

    stand: int
    natural: int


def align_names(statements: Sequence[Laid]) -> None:
    """In declarations and energies."""
    _align(statements, [laid.name for laid in statements])


def align_values(statements: Sequence[Laid], bodies: list[list[str]]) -> None:
    """What is behind them in statements of one line: the first =, then descriptions. `bodies` are their lines."""
    for find in (_value, _description):
        _align(statements, [find(laid) if len(body) == 1 else None for laid, body in zip(statements, bodies, strict=True)])
    for k, laid in enumerate(statements):
        if laid.wider and len(bodies[k]) == 1:
            bodies[k] = [line_of(laid)]


def comment_spaces(statements: Sequence[Laid], bodies: Sequence[list[str]]) -> list[int]:
    """How many spaces are before the comment behind each statement of these lines."""
    widths = [len(body[-1].rpartition("\n")[2]) for body in bodies]
    spaces = [1] * len(statements)
    stops = [_stop(laid, laid.statement.trailing[0], width + 1) if laid.statement.trailing else None
             for laid, width in zip(statements, widths, strict=True)]
    for group in _groups([laid.statement for laid in statements], stops):
        column = max(widths[k] for k in group) + 1
        for k in group:
            spaces[k] = column - widths[k]
    return spaces


def _value(laid: Laid) -> int | None:
    return next((k for k, piece in enumerate(laid.pieces) if piece.text in ("=", ":=") and laid.gaps[k].depth == 0), None)


def _description(laid: Laid) -> int | None:
    return next((k for k, piece in enumerate(laid.pieces) if k and piece.kind == "STRING" and laid.gaps[k].depth == 0), None)


def _align(statements: Sequence[Laid], places: Sequence[int | None]) -> None:
    stops = [None if place is None else _stop(laid, laid.pieces[place], laid.offset(place))
             for laid, place in zip(statements, places, strict=True)]
    for group in _groups([laid.statement for laid in statements], stops):
        if len(group) == 1:
            continue
        naturals = {k: stop.natural for k in group if (stop := stops[k]) is not None}
        column = max(naturals.values())
        for k, natural in naturals.items():
            place = places[k]
            if natural < column and place is not None:
                statements[k].wider[place] = statements[k].wider.get(place, 0) + column - natural


def _groups(statements: Sequence[Statement], stops: Sequence[_Stop | None]) -> Iterator[list[int]]:
    """Neighbours whose words stand below each other. One that has none, or is alone in that it cannot stand so far left, does not
    part them."""
    group: list[int] = []
    marks = [(k, stop) for k, stop in enumerate(stops) if stop is not None]
    blocks = list(accumulate(own.is_apart or own.is_comment or k == 0 or own.depth != statements[k - 1].depth
                             for k, own in enumerate(statements)))
    for j, (k, stop) in enumerate(marks):
        first = stops[group[0]] if group else None
        if first is not None and (blocks[k] != blocks[group[0]] or first.stand != stop.stand or stop.stand == _NOWHERE):
            following = marks[j + 1] if j + 1 < len(marks) and blocks[marks[j + 1][0]] == blocks[group[0]] else None
            if following is not None and following[1].stand == first.stand and stop.natural > first.stand:
                continue
            yield group
            group = []
        group.append(k)
    if group:
        yield group


def _stop(laid: Laid, piece: Piece, natural: int) -> _Stop:
    """It stands nowhere where the begin of its statement is in another line of the text."""
    first = laid.pieces[0]
    lines = first.text.count("\n")
    for other in laid.pieces[1:]:
        if other.start > piece.start:
            break
        lines += other.lines + other.text.count("\n")
    return _Stop(_NOWHERE if lines or piece.lines else piece.start - first.start, natural)
