"""A motion -> what moves in its picture: strokes that stand, strokes that ride on a frame, strokes that change their shape."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.joints import Tree
from lagrangia.draw.page import Words, bounds_of
from lagrangia.draw.picture import arms_of, constants_of, fit_scenery, is_load, words_of
from lagrangia.draw.scenery import Scenery
from lagrangia.draw.strokes import Spot, Stroke
from lagrangia.draw.values import States, evaluate_figures
from lagrangia.language.flat import Figure

Vector = NDArray[np.float64]
_LOOKS = 24  # moments at which the extent of a motion is looked at
_MOST_LOOKED_AT = 3000  # figures at all these moments
_OWN = ("circle", "box", "line", "polyline", "polygon", "arc")  # words that ride on one body


@dataclass(frozen=True)
class Moving:
    """A stroke over time. `poses`: of a rider (T, 3), m and rad, whose points are in that frame's axes; else `points` (T, n, 2),
    NaN where there is nothing to be seen; neither where it stands."""

    stroke: Stroke
    poses: Vector | None = None
    points: Vector | None = None


@dataclass(frozen=True)
class Caption:
    """A label over time: (T, 2), m."""

    words: Words
    at: Vector
    aside: Vector


@dataclass(frozen=True)
class Reel:
    """All that is seen of a motion; `low` and `high` are its corners, m, `symbol` the size of symbols, m."""

    t: Vector
    strokes: tuple[Moving, ...]
    captions: tuple[Caption, ...]
    traces: tuple[tuple[str, Vector], ...]  # (T, 2) each
    low: Vector
    high: Vector
    symbol: float
    scenery: Scenery


def build_reel(c: Compilation, figures: Sequence[Figure], states: States, names: Mapping[str, str],
               traces: Sequence[str]) -> Reel:
    """`traces` are names of frames, beside those that drawing sections ask for. Raises LagError."""
    numbers = evaluate_figures(c, figures, states)
    count = states.t.shape[1]
    most = int(np.clip(_MOST_LOOKED_AT / (1 + len(figures)), 3, _LOOKS))
    looks = sorted({0, *np.linspace(0, count - 1, min(count, most)).astype(int).tolist()})
    scenery = fit_scenery(numbers, Tree(c.graph, constants_of(c, states)), looks, False)
    strokes: list[Moving] = []
    captions = []
    words = words_of(c, scenery, names)
    for k in sorted(scenery.shown, key=lambda k: not is_load(scenery, k)):
        if numbers.items[k].word != "trace":
            found, spots = _over_time(scenery, k, count)
            strokes += found
            if k in words and spots:
                captions.append(_caption(words[k], spots))
    strokes += _arms(scenery, count)
    low, high = _corners(strokes, scenery.symbol)
    return Reel(states.t[0], tuple(strokes), tuple(captions), _traces(scenery, traces, count), low, high, scenery.symbol, scenery)


def _over_time(scenery: Scenery, k: int, count: int) -> tuple[list[Moving], list[Spot | None]]:
    """A figure's strokes, and where its label belongs at each moment."""
    poses = _ridden(scenery, k, count)
    if poses is not None:
        shape, first = scenery.shape(k, 0), poses[0]
        local = [stroke.moved(-first[:2], 0.0).moved(np.zeros(2), -first[2]) for stroke in shape.strokes]
        spots: list[Spot | None] = [None] * count
        if shape.spot is not None:
            own = _turned(shape.spot.at - first[:2], -first[2]), _turned(shape.spot.aside, -first[2])
            spots = [Spot(pose[:2] + _turned(own[0], pose[2]), _turned(own[1], pose[2]), shape.spot.room) for pose in poses]
        return [Moving(stroke, poses=poses) for stroke in local], spots
    shapes = [scenery.shape(k, moment) for moment in range(count)]
    return _varying([shape.strokes for shape in shapes]), [shape.spot for shape in shapes]


def _ridden(scenery: Scenery, k: int, count: int) -> Vector | None:
    """The poses of the frame on which a figure of constant sizes rides as a whole."""
    item, numbers = scenery.numbers.items[k], scenery.numbers
    if item.word not in _OWN or k in scenery.layout.ends or not item.frames or "" in item.frames:
        return None
    if len({scenery.tree.bodies[frame] for frame in item.frames}) > 1:
        return None
    rows = [row for found in (*item.numbers, *item.options.values()) for row in found]
    if any(np.ptp(numbers.values[row]) > 1e-12 * np.abs(numbers.values[row]).max() for row in rows):
        return None
    poses = numbers.place(item.frames[0]).T[:count].copy()
    poses[:, :2] += scenery.layout.offset(item.frames[0])
    return poses if np.isfinite(poses).all() else None


def _varying(moments: Sequence[Sequence[Stroke]]) -> list[Moving]:
    found = []
    for j in range(max((len(strokes) for strokes in moments), default=0)):
        there = [strokes[j] for strokes in moments if j < len(strokes)]
        size = max(len(stroke.points) for stroke in there)
        points = np.full((len(moments), size, 2), np.nan)
        for k, strokes in enumerate(moments):
            if j < len(strokes):
                own = strokes[j].points
                points[k, : len(own)] = own
                points[k, len(own) :] = own[-1]
        is_still = np.isfinite(points).all() and float(np.ptp(points, axis=0).max()) == 0.0
        found.append(Moving(there[0], points=None if is_still else points))
    return found


def _arms(scenery: Scenery, count: int) -> list[Moving]:
    return _varying([arms_of(scenery, moment) for moment in range(count)])


def _caption(words: Words, spots: Sequence[Spot | None]) -> Caption:
    at = np.array([spot.at if spot is not None else np.full(2, np.nan) for spot in spots])
    aside = np.array([spot.aside if spot is not None and not any(spot.room) else np.zeros(2) for spot in spots])
    lengths = np.linalg.norm(aside, axis=1, keepdims=True)
    return Caption(words, at, aside / np.where(lengths > 0, lengths, 1.0))


def _traces(scenery: Scenery, chosen: Sequence[str], count: int) -> tuple[tuple[str, Vector], ...]:
    found = []
    for k in scenery.shown:
        if scenery.numbers.items[k].word == "trace":
            label = scenery.numbers.items[k].frames[0]
            found.append((label, np.array([scenery.places(k, moment)[0, :2] for moment in range(count)])))
    for frame in chosen:
        found.append((frame, scenery.numbers.place(frame)[:2].T[:count] + scenery.layout.offset(frame)))
    return tuple(found)


def _corners(strokes: Sequence[Moving], symbol: float) -> tuple[Vector, Vector]:
    found = []
    for moving in strokes:
        if moving.points is not None:
            points = moving.points.reshape(-1, 2)
            points = points[np.isfinite(points).all(axis=1)]
        elif moving.poses is not None:
            reach = float(np.linalg.norm(moving.stroke.points, axis=1).max(initial=0.0))
            points = np.concatenate([moving.poses[:, :2] - reach, moving.poses[:, :2] + reach])
        else:
            points = moving.stroke.points
        found.append(Stroke(points, 0, radius=moving.stroke.radius))
    low, high = bounds_of(found)
    return low - symbol, high + symbol


def _turned(vector: Vector, angle: float) -> Vector:
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def strokes_at(reel: Reel, moment: int) -> list[Stroke]:
    """All strokes at one moment, m."""
    found = []
    for moving in reel.strokes:
        if moving.poses is not None:
            x, y, angle = moving.poses[moment]
            found.append(moving.stroke.moved(np.zeros(2), angle).moved(np.array([x, y]), 0.0))
        elif moving.points is None:
            found.append(moving.stroke)
        elif np.isfinite(moving.points[moment]).all():
            s = moving.stroke
            found.append(Stroke(moving.points[moment], s.layer, s.line, s.fill, s.is_closed, s.radius))
    return found


def ways_until(reel: Reel, moment: int) -> list[Vector]:
    """The traces up to a moment, (points, 2) each, m."""
    ways = [points[: moment + 1] for _, points in reel.traces]
    ways = [way[np.isfinite(way).all(axis=1)] for way in ways]
    return [way for way in ways if len(way) > 1]


def in_order(reel: Reel) -> list[Moving]:
    """What is drawn later hides what was drawn before; small things lie on large ones."""
    return sorted(reel.strokes, key=lambda moving: (moving.stroke.layer, -moving.stroke.extent))
