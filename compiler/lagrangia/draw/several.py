"""Several runs of a scene in one reel: the first as it is, the others by thin lines."""

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from lagrangia.base.diagnostics import fail
from lagrangia.draw.animation import Curve
from lagrangia.draw.reel import Moving, Reel
from lagrangia.draw.strokes import BODIES, RODS, SPRINGS

_SHOWN = (RODS, SPRINGS, BODIES)  # of the others: their supports and arrows would hide those of the first


def joined(first: Reel, others: Sequence[Reel]) -> Reel:
    """What moves in the others below what is seen of the first. Raises LagError L0702 where times differ."""
    strokes: list[Moving] = []
    for reel in others:
        if not np.array_equal(reel.t, first.t):
            fail("L0702", "runs are shown together that have the same times, and one of them ended early", None,
                 "an earlier --stop shows them")
        strokes += [replace(moving, stroke=replace(moving.stroke, line="thin", fill="none"))
                    for moving in reel.strokes if _is_shown(moving)]
    low = np.min([reel.low for reel in (first, *others)], axis=0)
    high = np.max([reel.high for reel in (first, *others)], axis=0)
    traces = tuple(trace for reel in others for trace in reel.traces)
    return replace(first, strokes=(*strokes, *first.strokes), traces=(*first.traces, *traces), low=low, high=high)


def _is_shown(moving: Moving) -> bool:
    moves = moving.poses is not None or moving.points is not None
    return moves and moving.stroke.layer in _SHOWN and moving.stroke.line != "dashed"


def labelled(curves: Sequence[Curve], label: str) -> list[Curve]:
    """Those of another run, by its values."""
    return [replace(curve, name=f"{curve.name}, {label}") for curve in curves]
