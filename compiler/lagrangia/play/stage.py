"""A scene's drawing -> what a page draws its strokes from at any moment: rows of one function, and all that stays as it is."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.compile.instructions import tape_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.picture import SHORTEST_ARM, arms_between, is_load, words_of
from lagrangia.draw.reel import build_reel
from lagrangia.draw.scenery import Scenery
from lagrangia.draw.values import States, build_drawn
from lagrangia.language.flat import Figure
from lagrangia.native.tapes import Tape

MOST_HANDLES = 500  # frames that can be dragged
_MOST_KNOTS = 2000  # of a table that the tape of a drawing has written out


@dataclass(frozen=True)
class Stage:
    """`drawing` gives the rows from t, q, v, u, p; `data` is what picture() of figures.js takes, and where the scene is seen."""

    drawing: Tape
    data: Mapping[str, Any]


def build_stage(c: Compilation, figures: Sequence[Figure], states: States, names: Mapping[str, str],
                traces: Sequence[str]) -> Stage:
    """The sizes of symbols, and where loose parts stand, are those that suit the motion of `states`. Raises LagError."""
    require_short_tables(c)
    reel = build_reel(c, figures, states, names, traces)
    scenery = reel.scenery
    words = words_of(c, scenery, names)
    found = []
    ways = []
    for k in sorted(scenery.shown, key=lambda k: not is_load(scenery, k)):
        if scenery.numbers.items[k].word == "trace":
            ways.append([scenery.numbers.items[k].frames[0], *_places(scenery, k)[0]])
        else:
            label = [[text, int(italic), int(lowered)] for text, italic, lowered in words[k].pieces] if k in words else None
            found.append({**_figure(scenery, k), "words": label})
    ways += [[frame, *_frame(scenery, frame)] for frame in traces]
    moving = [frame for frame in scenery.numbers.frames if frame not in scenery.tree.grounded]
    data = {"figures": found, "arms": [[_frame(scenery, frame) for frame in pair] for pair in arms_between(scenery)],
            "traces": ways, "frames": [_frame(scenery, frame) for frame in moving[:MOST_HANDLES]], "symbol": scenery.symbol,
            "shortest": SHORTEST_ARM, "low": reel.low.tolist(), "high": reel.high.tolist()}
    return Stage(tape_of(build_drawn(c, figures, for_tape=True).function), data)


def require_short_tables(c: Compilation) -> None:
    """Raises LagError L0901 for one that no page draws."""
    for table in c.kinematics.algebra.index.tables:
        if table.n > _MOST_KNOTS:
            fail("L0901", f"not supported yet: a page that computes and draws a table of {table.n} rows", None,
                 f"at most {_MOST_KNOTS}; lag animate shows one run")


def _figure(scenery: Scenery, k: int) -> dict[str, Any]:
    """As draw/strokes.py's Given has it, rows instead of numbers."""
    item, given = scenery.numbers.items[k], scenery.given(k, 0)
    held = [[j, *way.tolist()] for j, way in scenery.held_ends(k, given.places[:, :2])]
    return {"word": item.word, "at": _places(scenery, k), "n": [list(rows) for rows in item.numbers],
            "o": {name: list(rows) for name, rows in item.options.items()}, "fill": given.fill, "line": given.line,
            "trims": list(given.trims), "ref": float(given.reference), "measure": given.measure, "lane": float(given.lane),
            "ground": bool(given.is_ground), "reach": list(given.reach), "lean": given.lean.tolist(), "held": held}


def _places(scenery: Scenery, k: int) -> list[list[float]]:
    """Rows, and how far from them it is drawn, m."""
    ends = scenery.layout.ends.get(k)
    if ends is None:
        item = scenery.numbers.items[k]
        return [[row, *(scenery.layout.offset(frame) if frame else np.zeros(2)).tolist()]
                for row, frame in zip(item.places, item.frames, strict=True)]
    found = []
    for end in ends:
        row, x, y = _frame(scenery, end.frame)
        off = scenery.layout.offset(end.frame) if end.is_wall else np.zeros(2)
        found.append([row, x + float(end.shift[0] - off[0]), y + float(end.shift[1] - off[1])])
    return found


def _frame(scenery: Scenery, frame: str) -> list[float]:
    return [scenery.numbers.frames[frame], *scenery.layout.offset(frame).tolist()]
