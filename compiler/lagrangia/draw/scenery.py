"""Numbers and layout -> the shapes of a moment: each figure with what hides its ends and how far it will reach."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.joints import Tree
from lagrangia.draw.placing import End, Layout, place_parts
from lagrangia.draw.strokes import SHAPES, Given, Shape, hatched, left_of
from lagrangia.draw.values import Item, Numbers
from lagrangia.frames.planar import SIZE
from lagrangia.language.tree import Ref

Vector = NDArray[np.float64]
_SYMBOLS_ACROSS = 9.0  # symbols in a scene of bodies
_OF_A_BAR = 0.8  # a symbol is no larger than that part of the usual bar
_OF_A_DISC = 0.9  # nor than that part of the usual radius
_OF_A_GAP = 0.8  # nor than that part of the way from one of many points to the next
_MANY, _ASKED = 40, 200  # points; so many of them are asked for their neighbours
MOST_COORDINATES = 12  # that are shown as arrows
_LINES = ("line", "zigzag", "dashpot")
_FILLED = ("box", "circle")


@dataclass
class Scenery:
    """A scene at so many moments, with symbols of one size, m; what is loose is laid out as it is at the `moment`."""

    numbers: Numbers
    tree: Tree
    moment: int
    symbol: float
    is_still: bool = False  # one moment alone is shown: forces by their directions

    @cached_property
    def layout(self) -> Layout:
        """Where loose parts stand."""
        return place_parts(self.numbers, self.tree, self.moment, self.symbol, self.extents)

    @cached_property
    def shown(self) -> list[int]:
        """Of all figures those that can be drawn."""
        coordinates = {c.name for c in self.tree.graph.coordinates}
        are_few = len(coordinates) <= MOST_COORDINATES
        found = []
        for k, item in enumerate(self.numbers.items):
            label = item.figure.options.get("label")
            name = label.name if isinstance(label, Ref) and item.measure in ("angle", "direction") else ""
            is_coordinate = name in self.tree.model.variables and self.tree.model.variables[name].kind == "coordinate"
            is_there = (bool(item.places) and self._is_seen(item)) or k in self.layout.ends
            if is_there and (not is_coordinate or (name in coordinates and are_few)):
                found.append(k)
        return found

    def _is_seen(self, item: Item) -> bool:
        """The ground is drawn where it is, and at positions that are given: nobody else can say where it is."""
        return item.word != "hatch" or not item.frames[0] or item.frames[0] in self.tree.grounded

    # ------------------------------------------------------------ places

    def places(self, k: int, moment: int) -> Vector:
        """(places, SIZE): m, rad."""
        item = self.numbers.items[k]
        if k in self.layout.ends:
            return np.array([self._end(end, moment) for end in self.layout.ends[k]])
        found = np.array([self.numbers.values[row : row + SIZE, moment] for row in item.places])
        for place, frame in zip(found, item.frames, strict=True):
            if frame:
                place[:2] += self.layout.offset(frame)
        return found

    def _end(self, end: End, moment: int) -> Vector:
        place = self.numbers.place(end.frame)[:, moment].copy()
        place[:2] += end.shift + (0.0 if end.is_wall else self.layout.offset(end.frame))
        return place

    # ------------------------------------------------------------ shapes

    def shape(self, k: int, moment: int) -> Shape:
        """What a figure looks like at a moment; a trace is made of many."""
        if self.numbers.items[k].word == "trace":
            return Shape()
        given = self.given(k, moment)
        if not all(np.isfinite(x).all() for x in (given.places, *given.numbers, *given.options.values())):
            return Shape()
        shape = SHAPES[self.numbers.items[k].word](given)
        walls = [stroke for at, way in self._walls(k, given.places[:, :2])
                 for stroke in hatched(at, -left_of(way), 1.3 * self.symbol, self.symbol)]
        return Shape([*shape.strokes, *walls], shape.spot) if walls else shape

    def _walls(self, k: int, places: Vector) -> list[tuple[Vector, Vector]]:
        """Where a line is held by the ground, and the way into the scene; supports draw their own."""
        return [(places[j], way) for j, way in self.held_ends(k, places)]

    def held_ends(self, k: int, places: Vector) -> list[tuple[int, Vector]]:
        """Which ends of a line the ground holds, and the way from each into the scene, of length 1."""
        item = self.numbers.items[k]
        if item.word not in _LINES:
            return []
        if k in self.layout.ends:
            ends = self.layout.ends[k]
            fixed = [end.is_wall or (end.frame in self.tree.grounded and not end.is_rim) for end in ends]
            own = [end.way for end in ends]
        else:
            fixed = [frame in self.tree.grounded for frame in item.frames]
            own = [np.zeros(2), np.zeros(2)]
        first = self.places(k, self.moment)[:, :2]
        ways = [own[j] if own[j].any() else _upright(first[1 - j] - first[j]) for j in range(2)]
        return [(j, ways[j]) for j in range(2)
                if fixed[j] and not any(float(np.linalg.norm(places[j] - spot)) < 0.5 * self.symbol for spot in self._supports)]

    @cached_property
    def _supports(self) -> list[Vector]:
        """Where hinges stand on the ground."""
        items = self.numbers.items
        hinges = [k for k in self.shown if items[k].word == "hatch" and "along" not in items[k].options]
        return [self.places(k, self.moment)[0, :2] for k in hinges if items[k].frames[0] in self.tree.grounded]

    def given(self, k: int, moment: int) -> Given:
        """What a figure is drawn from at a moment."""
        item = self.numbers.items[k]
        values = self.numbers.values
        places = self.places(k, moment)
        numbers = [values[list(rows), self._telling(item, moment)] for rows in item.numbers]
        options = {name: values[list(rows), moment] for name, rows in item.options.items()}
        is_solid = item.word == "box" or (item.word == "circle" and not item.numbers)
        lane = float(options["offset"][0]) if "offset" in options and item.word != "rail" else self.layout.lanes.get(k, 0.0) * 0.9
        is_ground = bool(item.frames) and item.frames[0] in self.tree.grounded
        if item.word == "hatch" and not is_ground and not item.frames[0]:
            is_ground = True  # a position says itself where the ground is
        return Given(places, numbers, self.symbol, options, item.choices.get("fill", "white" if is_solid else "none"),
                     item.choices.get("style", "normal"), self._trims(k), self._reference(k), item.measure, lane, is_ground,
                     self._reach(k), self._lean(k, moment))

    def _telling(self, item: Item, moment: int) -> int:
        """The moment, or where a still shows a load that is as good as nothing then, that of its greatest value."""
        if not self.is_still or item.measure not in ("force", "torque", "other"):
            return moment
        values = self.numbers.values[list(item.numbers[0])]
        sizes = np.where(np.isfinite(values).all(axis=0), np.linalg.norm(values, axis=0), 0.0)
        if sizes[moment] > 0.05 * sizes.max():
            return moment
        telling = (sizes >= 0.3 * sizes.max()) & (values.sum(axis=0) > 0)  # rather as its formula is written, without the sign
        return int(np.argmax(telling if telling.any() else sizes))

    def _trims(self, k: int) -> tuple[float, float]:
        item = self.numbers.items[k]
        if item.word in ("arrow", "curved_arrow"):
            return self.extents.get(item.frames[0], 0.0), 0.0
        if item.word == "hatch":
            on_it = (self.extents.get(frame, 0.0) for frame in self.tree.below.get(item.frames[0], ()))
            return max(on_it, default=0.0), 0.0
        if item.word not in _LINES or (item.word == "line" and k not in self.layout.ends):
            return 0.0, 0.0
        ends = self.layout.ends.get(k)
        if ends is None:
            a, b = item.frames
            return self.extents.get(a, 0.0), self.extents.get(b, 0.0)
        first, second = (0.0 if end.is_wall or end.shift.any() else self.extents.get(end.frame, 0.0) for end in ends)
        return first, second

    def _reference(self, k: int) -> float:
        """The greatest length of a spring, the greatest of all forces or torques."""
        item = self.numbers.items[k]
        if item.word in ("zigzag", "dashpot"):
            return self._longest.get(k, 0.0)
        return self._greatest.get(item.measure, 0.0) if not self.is_still and item.word in ("arrow", "curved_arrow") else 0.0

    @cached_property
    def _longest(self) -> dict[int, float]:
        found = {}
        for k, item in enumerate(self.numbers.items):
            if item.word in ("zigzag", "dashpot") and (item.places or k in self.layout.ends):
                moments = range(0, self.numbers.values.shape[1], max(1, self.numbers.values.shape[1] // 50))
                lengths = [float(np.linalg.norm(np.diff(self.places(k, m)[:2, :2], axis=0))) for m in (*moments, self.moment)]
                found[k] = max((x for x in lengths if np.isfinite(x)), default=0.0) - sum(self._trims(k))
        return found

    @cached_property
    def _greatest(self) -> dict[str, float]:
        found: dict[str, float] = {}
        for item in self.numbers.items:
            if item.measure in ("force", "torque", "other"):
                values = self.numbers.values[list(item.numbers[0])]
                sizes = np.linalg.norm(values, axis=0)
                found[item.measure] = max(found.get(item.measure, 0.0), float(np.nanmax(sizes, initial=0.0)))
        return found

    def _reach(self, k: int) -> tuple[float, float]:
        item = self.numbers.items[k]
        if item.word != "rail":
            return 0.0, 0.0
        moments = np.unique(np.linspace(0, self.numbers.values.shape[1] - 1, 60).astype(int))
        found = []
        for m in {*moments.tolist(), self.moment}:
            base, slider = self.places(k, m)
            along = self.numbers.values[list(item.options["along"]), m] if "along" in item.options else np.array([1.0, 0.0])
            c, s = np.cos(base[2]), np.sin(base[2])
            way = np.array([c * along[0] - s * along[1], s * along[0] + c * along[1]]) / (float(np.linalg.norm(along)) or 1.0)
            found.append(float((slider - base)[:2] @ way))
        found = [x for x in found if np.isfinite(x)]
        return (min(found), max(found)) if found else (0.0, 0.0)

    def _lean(self, k: int, moment: int) -> Vector:
        """Of a support: away from what hangs on it at first, where it stays; of an angle: to where what it turns reaches,
        in its own axes."""
        item = self.numbers.items[k]
        if item.word == "hatch" and item.frames[0]:
            hanging = [self._far(frame, self.moment) for frame in self.tree.below.get(item.frames[0], [])]
            total = sum((turned for _, turned in hanging), np.zeros(2))
            return np.array([0.0, 1.0 if total[1] < -1e-9 * self.symbol else -1.0])
        if item.measure == "angle" and item.frames[0]:
            label = item.figure.options.get("label")
            joint = self.tree.joints.get(label.name) if isinstance(label, Ref) else None
            if joint is not None:
                own, _ = self._far(joint.child, moment)
                return own
        return np.array([1.0, 0.0])

    def _far(self, frame: str, moment: int) -> tuple[Vector, Vector]:
        """The farthest place that is rigid with a frame: along the frame's axes, and along the world's."""
        here = self.numbers.place(frame)[:, moment]
        ahead = [self.numbers.place(name)[:2, moment] - here[:2] for name in self.tree.body_of(frame)[:200]]
        c, s = np.cos(here[2]), np.sin(here[2])
        own = [np.array([c * x + s * y, c * y - s * x]) for x, y in ahead]
        best = max(range(len(own)), key=lambda j: (round(float(np.linalg.norm(own[j])) / self.symbol, 6), own[j][0]), default=0)
        if not own or np.linalg.norm(own[best]) < 1e-9 * self.symbol:
            return np.array([1.0, 0.0]), np.zeros(2)
        return own[best], ahead[best]

    @cached_property
    def extents(self) -> dict[str, float]:
        """Half of what is drawn about each frame, m: it hides the ends of lines that lead there."""
        return extents_of(self.numbers, self.tree, self.moment, self.symbol)


def _upright(way: Vector) -> Vector:
    """The axis that is nearest to it: ground stands, whatever hangs on it."""
    axis = int(np.argmax(np.abs(way)))
    found = np.zeros(2)
    found[axis] = -1.0 if way[axis] < 0 else 1.0
    return found


def extents_of(numbers: Numbers, tree: Tree, moment: int, symbol: float) -> dict[str, float]:
    """By frames; those of a body in one place share it."""
    def key(frame: str) -> tuple[str, int, int]:
        x, y, *_ = numbers.place(frame)[:, moment] / symbol
        return tree.bodies.get(frame, frame), *((round(x * 1e6), round(y * 1e6)) if np.isfinite(x) and np.isfinite(y) else (0, 0))

    drawn: dict[tuple[str, int, int], float] = {}
    for item in numbers.items:
        if item.word not in _FILLED or not item.frames or not item.frames[0] or item.choices.get("fill") == "none":
            continue
        size = symbol * float(numbers.values[item.options["size"][0], moment]) if "size" in item.options else symbol
        if item.numbers and item.word == "circle":
            half = abs(float(numbers.values[item.numbers[0][0], moment])) if item.choices.get("fill") == "white" else 0.0
        else:
            half = 0.0 if item.numbers else size if item.word == "box" else size / 2
        place = numbers.values[item.places[0] : item.places[0] + 2, moment]
        if float(np.linalg.norm(place - numbers.place(item.frames[0])[:2, moment])) < 1e-6 * symbol:
            where = key(item.frames[0])
            drawn[where] = max(drawn.get(where, 0.0), half)
    return {frame: drawn[where] for frame in numbers.frames if (where := key(frame)) in drawn}


def natural_size(numbers: Numbers, moments: Sequence[int]) -> tuple[float, float, float]:
    """The extent of the scene as it is, m, the usual length of its bars and radius of its discs; 0 where there are none."""
    places = [numbers.values[row : row + 2][:, list(moments)] for item in numbers.items for row in item.places]
    def sizes(word: str) -> list[float]:
        rows = [item.numbers[0][0] for item in numbers.items if item.word == word and item.numbers]
        return [abs(float(numbers.values[row, moments[0]])) for row in rows]

    radii, bars = sizes("circle"), sizes("box")
    points = np.concatenate(places, axis=1) if places else np.zeros((2, 1))
    points = points[:, np.isfinite(points).all(axis=0)]
    spread = float(np.ptp(points, axis=1).max()) if points.size else 0.0
    return (max(spread, 2 * max(radii, default=0.0)), float(np.median(bars)) if bars else 0.0,
            float(np.median(radii)) if radii else 0.0)


def first_symbol(numbers: Numbers, moments: Sequence[int]) -> tuple[float, float]:
    """The size of symbols to begin with, m, and the largest that its bars leave room for."""
    size, bar, disc = natural_size(numbers, moments)
    size = size if size > 0 and np.isfinite(size) else 1.0
    most = min(_OF_A_BAR * bar if bar > 0 else np.inf, _OF_A_DISC * disc if disc > 0 else np.inf,
               _OF_A_GAP * crowding(numbers, moments[0]))
    return min(size / _SYMBOLS_ACROSS, most), most


def crowding(numbers: Numbers, moment: int) -> float:
    """The usual distance from one point or block to the next, m, where there are many; else infinity."""
    rows = [item.places[0] for item in numbers.items if item.word in _FILLED and item.places and not item.numbers]
    places = np.unique(np.array([numbers.values[row : row + 2, moment] for row in rows]).reshape(-1, 2), axis=0)
    places = places[np.isfinite(places).all(axis=1)]
    if len(places) < _MANY:
        return float(np.inf)
    gaps = [np.partition(np.hypot(*(places - place).T), 1)[1] for place in places[:: 1 + len(places) // _ASKED]]
    return float(np.median(gaps))
