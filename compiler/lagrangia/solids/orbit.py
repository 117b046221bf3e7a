"""A stage -> one HTML file that plays it and is turned by hand: no network, no library."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.animation import PLAYER, Curve, as_text, played, spelt, written
from lagrangia.solids.shapes import Solid
from lagrangia.solids.stage import Body, Line, Stage

VECTORS = [Path(__file__).with_name("vectors.js")]
SEEN_BY_HAND = [Path(__file__).with_name(name) for name in ("orbit.css", "orbit.html", "eye.js")]  # of any page, after its player
Vector = NDArray[np.float64]


def write_orbit(stage: Stage, title: str, curves: Sequence[Curve], energies: Sequence[Curve],
                events: Vector | None = None) -> str:
    """The whole file; `events` are times that curves mark, s."""
    parts = [*VECTORS, *PLAYER, *SEEN_BY_HAND, Path(__file__).with_suffix(".js")]
    return written(parts, title, {**played(stage.t, curves, energies, events), **_seen(stage)})


def _seen(stage: Stage) -> dict[str, Any]:
    return {
        **told_whole(stage), "bodies": [_body(body) for body in stage.bodies], "lines": [_line(line) for line in stage.lines],
        "captions": [{"words": spelt(c.words), "at": as_text(c.at.astype("<f4"))} for c in stage.captions],
        "traces": [{"name": name, "at": as_text(points.astype("<f4"))} for name, points in stage.traces],
    }


def told_whole(stage: Stage) -> dict[str, Any]:
    """What eye.js takes beside solids and lines."""
    low, high = stage.corners
    return {"low": low.tolist(), "high": high.tolist(), "symbol": stage.symbol, "up": np.asarray(stage.up, float).tolist()}


def told_form(solid: Solid) -> dict[str, Any]:
    """Its shape."""
    return {"v": as_text(solid.vertices.astype("<f4")), "f": [list(face) for face in solid.faces],
            "e": [[*edge, int(solid.is_sharp(edge))] for edge in solid.edges]}


def _body(body: Body) -> dict[str, Any]:
    return {**told_form(body.solid), "s": body.shade, "poses": as_text(body.poses.astype("<f4"))}


def _line(line: Line) -> dict[str, Any]:
    return {"l": line.line, "n": line.points.shape[1], "points": as_text(line.points.astype("<f4")),
            "turns": line.turns, "radius": line.radius}
