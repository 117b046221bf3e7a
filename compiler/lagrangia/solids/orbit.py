"""A stage -> one HTML file that plays it and is turned by hand: no network, no library."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.animation import PLAYER, Curve, as_text, played, spelt, written
from lagrangia.solids.stage import Body, Line, Stage

Vector = NDArray[np.float64]


def write_orbit(stage: Stage, title: str, curves: Sequence[Curve], energies: Sequence[Curve],
                events: Vector | None = None) -> str:
    """The whole file; `events` are times that curves mark, s."""
    here = Path(__file__)
    parts = [*PLAYER, *(here.with_suffix(suffix) for suffix in (".css", ".html", ".js"))]
    return written(parts, title, {**played(stage.t, curves, energies, events), **_seen(stage)})


def _seen(stage: Stage) -> dict[str, Any]:
    low, high = stage.corners
    return {
        "low": low.tolist(), "high": high.tolist(), "symbol": stage.symbol, "up": np.asarray(stage.up, float).tolist(),
        "bodies": [_body(body) for body in stage.bodies], "lines": [_line(line) for line in stage.lines],
        "captions": [{"words": spelt(c.words), "at": as_text(c.at.astype("<f4"))} for c in stage.captions],
        "traces": [{"name": name, "at": as_text(points.astype("<f4"))} for name, points in stage.traces],
    }


def _body(body: Body) -> dict[str, Any]:
    solid = body.solid
    return {"v": as_text(solid.vertices.astype("<f4")), "f": [list(face) for face in solid.faces],
            "e": [[*edge, int(solid.is_sharp(edge))] for edge in solid.edges], "s": body.shade,
            "poses": as_text(body.poses.astype("<f4"))}


def _line(line: Line) -> dict[str, Any]:
    return {"l": line.line, "n": line.points.shape[1], "points": as_text(line.points.astype("<f4")),
            "turns": line.turns, "radius": line.radius}
