"""A reel -> one HTML file that plays it: no network, no library, the numbers beside the page's own script."""

import base64
import json
import re
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.page import Words
from lagrangia.draw.reel import Caption, Moving, Reel, in_order

Vector = NDArray[np.float64]
_GONE, _LAST = 65535, 65534  # of sixteen bits: nothing there; the far corner
PLAYER = [Path(__file__).with_suffix(suffix) for suffix in (".css", ".html", ".js")]  # of what is played; its scene comes after
_COMMON = ("page.css", "page.js", "captions.js", "graphs.js")  # of all pages
_LITTLE = 1e-3  # of its values, a curve that is told above a base
_MOST_MARKS = 1000  # of events
_WATCHED = 8.0  # s: a motion is played so that it takes about as long, by a round factor


@dataclass(frozen=True)
class Curve:
    """A quantity over time, in the unit it is shown in."""

    name: str
    unit: str
    values: Vector


def write_animation(reel: Reel, title: str, curves: Sequence[Curve], energies: Sequence[Curve],
                    events: Vector | None = None) -> str:
    """The whole file; `events` are times that curves mark, s."""
    return written([*PLAYER, Path(__file__).with_name("flat.js")], title,
                   {**played(reel.t, curves, energies, events), **_seen(reel)})


def written(parts: Sequence[Path], title: str, data: Mapping[str, Any]) -> str:
    """A page of its parts, those that all pages have before them: styles (.css), what is seen (.html), scripts (.js)."""
    own = Path(__file__)
    whole = [*(own.with_name(name) for name in _COMMON), *parts]
    text = own.with_name("page.html").read_text(encoding="utf-8")
    for place, kind in (("STYLE", ".css"), ("BODY", ".html"), ("SCRIPT", ".js")):
        found = [part.read_text(encoding="utf-8").rstrip() for part in whole if part.suffix == kind]
        text = text.replace(f"@{place}@", "\n".join(found))
    told = json.dumps(data, separators=(",", ":"), allow_nan=False).replace("<", "\\u003c")  # a name cannot end the script
    return re.sub("@(TITLE|DATA)@", lambda place: escape(title) if place[1] == "TITLE" else told, text)


def played(t: Vector, curves: Sequence[Curve], energies: Sequence[Curve], events: Vector | None) -> dict[str, Any]:
    """What all players take: times, curves, bars of energies, marks."""
    least = [float(np.nanmin(curve.values, initial=0.0)) for curve in energies]
    total = sum((curve.values - low for curve, low in zip(energies, least, strict=True)), np.zeros(len(t)))
    length = float(t[-1] - t[0]) if len(t) > 1 else 0.0
    return {
        "t": as_text(t.astype("<f8")), "speed": speed_of(length), "curves": [_curve(curve) for curve in curves],
        "energies": [{**_curve(curve), "least": low} for curve, low in zip(energies, least, strict=True)],
        "most": float(np.nanmax(total, initial=0.0)) if len(energies) else 0.0,
        "events": [] if events is None else _plain(events[:_MOST_MARKS]),
    }


def _seen(reel: Reel) -> dict[str, Any]:
    span = float(np.max(reel.high - reel.low)) or 1.0
    return {
        "low": _plain(reel.low), "high": _plain(reel.high), "span": span, "symbol": reel.symbol,
        "strokes": [_stroke(moving, reel, span) for moving in in_order(reel)],
        "captions": [_caption(caption, reel, span) for caption in reel.captions],
        "traces": [{"name": name, "at": _small(points, reel, span)} for name, points in reel.traces],
    }


def speed_of(length: float) -> float:
    """At which a motion so long, s, is watched."""
    return length / _WATCHED if length and not 2.0 <= length <= 2 * _WATCHED else 1.0


def _caption(caption: Caption, reel: Reel, span: float) -> dict[str, Any]:
    return {"words": spelt(caption.words),
            "at": _small(caption.at, reel, span), "side": as_text(np.nan_to_num(caption.aside).astype("<f4"))}


def spelt(words: Words) -> list[list[Any]]:
    """As captions.js takes them."""
    return [[text, int(is_italic), int(is_lowered)] for text, is_italic, is_lowered in words.pieces]


def _stroke(moving: Moving, reel: Reel, span: float) -> dict[str, Any]:
    s = moving.stroke
    found: dict[str, Any] = {"l": s.line, "f": s.fill, "c": int(s.is_closed), "r": float(f"{s.radius:.7g}"), "n": len(s.points)}
    if moving.points is not None:
        return found | {"n": moving.points.shape[1], "points": _small(moving.points, reel, span)}
    found["p"] = _plain(s.points.ravel())
    return found if moving.poses is None else found | {"poses": as_text(moving.poses.astype("<f4"))}


def _small(points: Vector, reel: Reel, span: float) -> str:
    """Places in sixteen bits each: a step is a 65534th of the scene's size."""
    scaled = np.clip(np.round((points - reel.low) / span * _LAST), 0, _LAST)
    return as_text(np.where(np.isfinite(points), scaled, _GONE).astype("<u2"))


def _curve(curve: Curve) -> dict[str, Any]:
    """By numbers of four bytes; above a base where it varies so little that these would not tell it."""
    known = curve.values[np.isfinite(curve.values)]
    base = float(known[0]) if known.size and np.ptp(known) < _LITTLE * np.abs(known).max() else 0.0
    told = {"name": curve.name, "unit": curve.unit, "y": as_text((curve.values - base).astype("<f4"))}
    return told | ({"base": base} if base else {})


def as_text(values: Any) -> str:
    """Numbers as they lie in memory, in letters."""
    return base64.b64encode(np.ascontiguousarray(values).tobytes()).decode()


def _plain(values: Vector) -> list[float]:
    return [float(f"{x:.9g}") for x in values]
