"""Shapes -> a page: paths and words in millimetres, y upwards; labels where nothing else is."""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.strokes import Shape, Spot, Stroke

Vector = NDArray[np.float64]
WIDTH, MOST_HEIGHT, MARGIN = 80.0, 105.0, 3.5  # mm
FONT = 3.0  # mm, of a letter
LINES = {"normal": 0.35, "round": 0.35, "thin": 0.2, "dashed": 0.2, "thick": 0.6}  # mm, as wide as a pen draws
_LIGHT, _LIGHTEST = 1.5, 0.1  # symbols smaller than that, mm, are drawn by lighter lines
_BASE, _SUB = 0.56, 0.38  # of the font: how wide a letter is
_REACH = np.array([0.7, 1.2, 1.8, 2.6, 3.6, 5.0, 7.0, 9.0, 12.0, 16.0])  # of a label from its spot, in half letters
_DIRECTIONS = 16


@dataclass(frozen=True)
class Words:
    """Text in pieces: (text, is_italic, is_lowered)."""

    pieces: tuple[tuple[str, bool, bool], ...]

    @property
    def width(self) -> float:
        """mm, about."""
        return FONT * sum(len(text) * (_SUB if lowered else _BASE) for text, _, lowered in self.pieces)

    @property
    def plain(self) -> str:
        """Without its looks."""
        return "".join(text for text, _, _ in self.pieces)


@dataclass(frozen=True)
class Label:
    """Words about a place, mm."""

    words: Words
    at: tuple[float, float]


@dataclass(frozen=True)
class Page:
    """mm; `paths` in the order in which they are drawn, by lines so many times as wide as LINES says."""

    width: float
    height: float
    paths: tuple[Stroke, ...]
    labels: tuple[Label, ...]
    title: str = ""
    weight: float = 1.0

    def pen(self, line: str) -> float:
        """The width of a line, mm."""
        return LINES[line] * self.weight


@dataclass(frozen=True)
class View:
    """How metres become millimetres: x_mm = scale (x - origin)."""

    scale: float
    origin: Vector
    width: float
    height: float

    def points(self, points: Vector) -> Vector:
        """(n, 2), mm."""
        moved: Vector = (points - self.origin) * self.scale
        return moved


def view_of(strokes: Sequence[Stroke], most: float) -> View:
    """The view in which all strokes fill a page, but no larger than `most` mm a metre, so that symbols stay symbols."""
    low, high = bounds_of(strokes)
    size = high - low
    room = np.array([WIDTH, MOST_HEIGHT]) - 2 * MARGIN
    with np.errstate(divide="ignore"):
        scale = float(np.min(room / np.maximum(size, 1e-300)))
    scale = min(scale, most)
    width, height = size * scale + 2 * MARGIN
    return View(scale, low - MARGIN / scale, float(width), float(height))


def bounds_of(strokes: Sequence[Stroke]) -> tuple[Vector, Vector]:
    """The lowest and the highest corner, m."""
    corners = [np.array([s.points.min(axis=0) - s.radius, s.points.max(axis=0) + s.radius]) for s in strokes if len(s.points)]
    if not corners:
        return np.zeros(2), np.zeros(2)
    found = np.array(corners)
    return found[:, 0].min(axis=0), found[:, 1].max(axis=0)


def weight_of(symbol: float) -> float:
    """Of the lines of a page, whose symbols are so large, mm."""
    return float(np.clip(symbol / _LIGHT, _LIGHTEST, 1.0))


def build_page(shapes: Sequence[tuple[Shape, Words | None]], view: View, title: str = "", weight: float = 1.0) -> Page:
    """Paths by their layers, and labels; those that find no room make the page larger."""
    strokes = [stroke for shape, _ in shapes for stroke in shape.strokes]
    order = sorted(range(len(strokes)), key=lambda k: (strokes[k].layer, -strokes[k].extent))
    paths = [_in_mm(strokes[k], view) for k in order]
    boxes: list[Vector] = []
    labels = []
    wanted = [(shape.spot, words) for shape, words in shapes if words is not None and words.pieces and shape.spot is not None]
    taken = _sampled(paths) if wanted else np.zeros((0, 2))
    for spot, words in sorted(wanted, key=lambda pair: -min(pair[0].room)):
        centre = _place_label(spot, words, view, taken, boxes)
        half = _half(words)
        boxes.append(np.array([centre - half, centre + half]))
        labels.append(Label(words, (float(centre[0]), float(centre[1]))))
    return _grown(Page(view.width, view.height, tuple(paths), tuple(labels), title, weight), boxes)


def stacked(upper: Page, lower: Page) -> Page:
    """Two pictures on one page, with the title and the pen of the upper one."""
    width = max(upper.width, lower.width)
    paths: list[Stroke] = []
    labels: list[Label] = []
    for page, up in ((upper, lower.height), (lower, 0.0)):
        shift = np.array([(width - page.width) / 2, up])
        paths += [replace(path, points=path.points + shift) for path in page.paths]
        labels += [Label(x.words, (x.at[0] + float(shift[0]), x.at[1] + up)) for x in page.labels]
    return replace(upper, width=width, height=upper.height + lower.height, paths=tuple(paths), labels=tuple(labels))


def _in_mm(stroke: Stroke, view: View) -> Stroke:
    return replace(stroke, points=view.points(stroke.points), radius=stroke.radius * view.scale)


def _half(words: Words) -> Vector:
    return np.array([words.width / 2 + 0.35, FONT * (0.66 if any(lowered for _, _, lowered in words.pieces) else 0.52)])


def _place_label(spot: Spot, words: Words, view: View, taken: Vector, boxes: list[Vector]) -> Vector:
    """The first of many places about its spot that hides least, near ones on the side it belongs to before others."""
    half = _half(words)
    at: Vector = view.points(spot.at[None])[0]
    room = np.array(spot.room) * view.scale
    if room[0] > half[0] + 0.4 and room[1] > half[1] and _cost(at, half, taken, boxes, view) < 1:
        return at
    length = float(np.linalg.norm(spot.aside))
    aside = spot.aside / length if length > 0 else np.array([0.0, 1.0])
    best, least = at, np.inf
    for k, reach in enumerate(_REACH):
        for j in range(_DIRECTIONS):
            angle = (j + 1) // 2 * (1 if j % 2 else -1) * 2 * np.pi / _DIRECTIONS
            c, s = np.cos(angle), np.sin(angle)
            way = np.array([c * aside[0] - s * aside[1], s * aside[0] + c * aside[1]])
            centre: Vector = at + way * (float(np.abs(way) @ half) + 0.25 * FONT * reach)
            cost = 12 * _cost(centre, half, taken, boxes, view) + 1.2 * k + 0.5 * abs(angle)
            if cost < least:
                best, least = centre, cost
    return best


def _cost(centre: Vector, half: Vector, taken: Vector, boxes: list[Vector], view: View) -> float:
    low, high = centre - half, centre + half
    hidden = float(np.count_nonzero(np.all((taken > low) & (taken < high), axis=1))) if len(taken) else 0.0
    over = sum(1 for box in boxes if np.all(low < box[1]) and np.all(high > box[0]))
    outside = float(np.maximum(0.0, np.concatenate([-low, high - np.array([view.width, view.height])])).max())
    return hidden + 40 * over + 0.3 * outside


def _sampled(paths: Sequence[Stroke]) -> Vector:
    """Points along all lines, half a millimetre apart."""
    found = []
    for path in paths:
        points = path.points
        if path.radius > 0:
            angles = np.linspace(0, 2 * np.pi, max(8, min(400, int(4 * np.pi * path.radius))))
            points = points + path.radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
        elif path.is_closed:
            points = np.concatenate([points, points[:1]])
        steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
        for a, b, step in zip(points, points[1:], steps, strict=False):
            count = max(1, min(400, int(2 * step)))
            found.append(a + np.linspace(0, 1, count + 1)[:, None] * (b - a))
    return np.concatenate(found) if found else np.zeros((0, 2))


def _grown(page: Page, boxes: Sequence[Vector]) -> Page:
    """Large enough for its labels."""
    if not boxes:
        return page
    corners = np.array(boxes)
    low = np.minimum(0.0, corners[:, 0].min(axis=0) - 0.8)
    high = np.maximum([page.width, page.height], corners[:, 1].max(axis=0) + 0.8)
    paths = tuple(replace(path, points=path.points - low) for path in page.paths)
    labels = tuple(Label(x.words, (x.at[0] - float(low[0]), x.at[1] - float(low[1]))) for x in page.labels)
    width, height = high - low
    return replace(page, width=float(width), height=float(height), paths=paths, labels=labels)
