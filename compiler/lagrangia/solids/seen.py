"""Figures of a scene in space, at the moments of a motion -> a stage."""

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.names import label_all
from lagrangia.draw.page import Words
from lagrangia.draw.values import States, measure_of
from lagrangia.frames.joints import component_of
from lagrangia.language.flat import Figure
from lagrangia.language.tree import String
from lagrangia.solids.rows import HINGE, Asked, Rows, build_rows
from lagrangia.solids.shapes import Solid, across, arc, arrow, box, brake, cylinder, dashpot, helix, moved, sphere, turns_of
from lagrangia.solids.stage import SHADES, Body, Caption, Line, Stage, quaternions

Vector = NDArray[np.float64]
_SYMBOLS_ACROSS = 14.0
SHORTEST_ROD = 0.02  # symbols
LONGEST_ARROW = 3.0  # symbols
_MOST_LABELS = 40
_TOUCHING = 0.3  # symbols: what joins two places that are never farther apart resists how one turns against the other
SEGMENTS = 48  # of a circle that is a line
_BODIES = ("circle", "box", "cuboid", "cylinder", "cone", "ball")
LOADS = ("force", "torque", "other")


@dataclass(frozen=True)
class Given:
    """A figure in numbers: `poses` (T, 3) and (T, 3, 3) of its places, `numbers` and `options` (T, n) each."""

    figure: Figure
    frames: tuple[str, ...]
    poses: tuple[tuple[Vector, Vector], ...]
    numbers: tuple[Vector, ...]
    options: Mapping[str, Vector]
    measure: str
    symbol: float
    is_ground: bool  # whether its first place stands for ever

    @property
    def size(self) -> float:
        """Of this symbol, m."""
        return self.symbol * float(self.options["size"][0, 0]) if "size" in self.options else self.symbol

    def number(self, k: int) -> float | None:
        """A size at the first moment; None where it was left out."""
        return abs(float(self.numbers[k][0, 0])) if k < len(self.numbers) else None

    @property
    def shade(self) -> str:
        """Of a solid, which has none that is see-through."""
        found = self.choice("fill", "white")
        return found if found in SHADES else "white"

    def choice(self, name: str, usual: str) -> str:
        """Of fill or style."""
        found = self.figure.options.get(name)
        return found.value if isinstance(found, String) else usual

    @property
    def axis(self) -> Vector:
        """Along what it stands, in the axes of its frame."""
        found: Vector = self.options["along"][0] if "along" in self.options else np.array([0.0, 0.0, 1.0])
        return found

    @property
    def stroke(self) -> str:
        """Of a spring or a damper: thin about a hinge, which it would hide."""
        return self.choice("style", "normal" if self.hinge is None else "thin")

    @property
    def hinge(self) -> Vector | None:
        """Of a spring or damper of torsion: unit vectors (T, 3) along the axis of its hinge, in the world's axes."""
        if HINGE not in self.options or {"of", "along"} & self.figure.options.keys():
            return None
        (a, _), (b, _) = self.poses
        if np.nanmax(np.linalg.norm(b - a, axis=1), initial=0.0) > _TOUCHING * self.symbol:
            return None
        axes = self.options[HINGE]
        found: Vector = axes / np.linalg.norm(axes, axis=1, keepdims=True)
        return found


@dataclass
class _Shown:
    """What one figure adds."""

    bodies: list[Body] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)


@dataclass(frozen=True)
class Looked:
    """Figures at the moments of `states`: their rows and what these are there, `symbol` the size of symbols, m, `greatest` the
    loads by their kinds, `grounded` the frames that stand for ever."""

    rows: Rows
    values: Vector
    given: tuple[Given, ...]
    symbol: float
    greatest: Mapping[str, float]
    grounded: set[str]

    def place(self, frame: str) -> Vector:
        """(T, 3), m."""
        return _pose(self.values[:, self.rows.frames[frame]])[0]

    @property
    def up(self) -> Vector:
        """The direction that points upwards on paper."""
        return _upwards(self.values[0, self.rows.up])


def look(c: Compilation, figures: Sequence[Figure], states: States) -> Looked:
    """Raises LagError."""
    rows = build_rows(c, figures)
    function = rows.function
    values = np.array(function(states.t, states.q, states.v, states.u, states.p), dtype=float)
    values = values.reshape(function.numel_out(0), -1).T
    sizes = [float(np.abs(values[0, at]).max()) for asked in rows.asked if asked.figure.word in _BODIES for at in asked.numbers]
    largest = max((x for x in sizes if np.isfinite(x)), default=0.0)
    grounded = _grounded(c)
    symbol = _symbol({name: _pose(values[:, at])[0] for name, at in rows.frames.items()}, grounded, largest)
    given = tuple(_given(c, asked, values, symbol, grounded) for asked in rows.asked)
    return Looked(rows, values, given, symbol, _greatest(given), grounded)


def build_stage(c: Compilation, figures: Sequence[Figure], states: States, names: Mapping[str, str],
                traces: Sequence[str]) -> Stage:
    """`traces` are names of frames, beside those that drawing sections ask for. Raises LagError."""
    return stage_of(c, look(c, figures, states), states.t[0], names, traces)


def stage_of(c: Compilation, looked: Looked, t: Vector, names: Mapping[str, str], traces: Sequence[str]) -> Stage:
    """As build_stage, of what was looked at at these times."""
    given = looked.given
    found = [_shown(g, looked.greatest) for g in given if g.poses and g.figure.word in SHOWN]
    ways = [(g.frames[0], g.poses[0][0]) for g in given if g.poses and g.figure.word == "trace"]
    ways += [(name, looked.place(name)) for name in traces]
    rods = [Line(np.stack([looked.place(a), looked.place(b)], axis=1), "thick", name=component_of(b))
            for a, b in rods_of(c, looked)]
    named = [Caption(words, np.mean([origin for origin, _ in given[k].poses], axis=0)) for k, words in words_of(c, given, names)]
    return Stage(t, tuple(body for one in found for body in one.bodies),
                 (*(line for one in found for line in one.lines), *rods), tuple(named), tuple(ways), looked.symbol, looked.up)


def _shown(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """What the figure adds, by the name of its component."""
    found, name = SHOWN[g.figure.word](g, greatest), g.figure.component
    return _Shown([replace(body, name=name) for body in found.bodies], [replace(line, name=name) for line in found.lines])


def _given(c: Compilation, asked: Asked, values: Vector, symbol: float, grounded: set[str]) -> Given:
    frames = asked.frames
    return Given(asked.figure, frames, tuple(_pose(values[:, at]) for at in asked.places),
                 tuple(values[:, at] for at in asked.numbers), {name: values[:, at] for name, at in asked.options.items()},
                 measure_of(c.flat, asked.figure), symbol, bool(frames) and (not frames[0] or frames[0] in grounded))


def _pose(values: Vector) -> tuple[Vector, Vector]:
    return values[:, :3], values[:, 3:].reshape(-1, 3, 3)


def _grounded(c: Compilation) -> set[str]:
    """Frames that keep their place for ever."""
    found = {root.frame for root in c.graph.roots if root.is_ground}
    for edge in c.graph.edges:
        if edge.is_rigid and edge.parent in found:
            found.add(edge.child)
    return found


def _upwards(against_gravity: Vector) -> Vector:
    """z where nothing weighs anything."""
    return against_gravity if np.isfinite(against_gravity).all() and against_gravity.any() else np.array([0.0, 0.0, 1.0])


def _symbol(origins: Mapping[str, Vector], grounded: Collection[str], largest: float) -> float:
    """The size of symbols, m: by how far apart frames are at first, those that move at any moment, and by the largest size of a
    body; by how far they come where that is nothing."""
    points = np.stack([*origins.values()]) if origins else np.zeros((0, 1, 3))
    moving = points[[name not in grounded for name in origins]]
    reach = max(2 * largest, _spread(points[:, :1]), _spread(moving)) or _spread(points.reshape(-1, 1, 3))
    return reach / _SYMBOLS_ACROSS if reach > 0 else 0.1


def _spread(points: Vector) -> float:
    """Across frames, (F, T, 3), at one moment: the largest, m."""
    is_there = np.isfinite(points).all(axis=2, keepdims=True)
    high = np.where(is_there, points, -np.inf).max(axis=0, initial=-np.inf)
    lengths = np.linalg.norm(high - np.where(is_there, points, np.inf).min(axis=0, initial=np.inf), axis=1)
    return float(lengths[np.isfinite(lengths)].max(initial=0.0))


def _greatest(given: Sequence[Given]) -> dict[str, float]:
    """Of forces, of torques."""
    found: dict[str, float] = {}
    for g in given:
        if g.measure in LOADS:
            sizes = np.linalg.norm(g.numbers[0], axis=1)
            found[g.measure] = max(found.get(g.measure, 0.0), float(np.nanmax(sizes, initial=0.0)))
    return found


def rods_of(c: Compilation, looked: Looked) -> list[tuple[str, str]]:
    """Frames that sit at a fixed place of another one, away from it, are held by a rod."""
    found = []
    drawn = {g.figure.component for g in looked.given}
    for edge in c.graph.edges:
        own = component_of(edge.parent)
        if not edge.is_rigid or edge.parent in looked.grounded or (own == component_of(edge.child) and own in drawn):
            continue
        if float(np.linalg.norm(looked.place(edge.child)[0] - looked.place(edge.parent)[0])) > SHORTEST_ROD * looked.symbol:
            found.append((edge.parent, edge.child))
    return found


def words_of(c: Compilation, given: Sequence[Given], names: Mapping[str, str]) -> list[tuple[int, Words]]:
    """Of figures with labels, by their numbers, but for those of coordinates."""
    labelled = [k for k, g in enumerate(given) if ("label" in g.figure.options or g.figure.word == "text")
                and g.measure not in ("angle", "direction")]
    figures = [given[k].figure for k in labelled]
    labels = [figure.arguments[-1] if figure.word == "text" else figure.options["label"] for figure in figures]
    found = []
    seen = set()
    for k, words in zip(labelled, label_all(c.flat, labels, names), strict=True):
        if words is not None and words.plain not in seen and given[k].poses:
            seen.add(words.plain)
            found.append((k, words))
    return found if len(found) <= _MOST_LABELS else []


# -------------------------------------------------------------------- words


def _riding(g: Given, solid: Solid, shade: str, place: int = 0) -> _Shown:
    """A solid in the axes of a frame."""
    origin, turns = g.poses[place]
    return _Shown([Body(solid, np.concatenate([origin, quaternions(turns)], axis=1), shade)])


def _turned(solid: Solid, axis: Vector) -> Solid:
    return moved(solid, np.zeros(3), across(axis)) if axis[:2].any() else solid


def _circle(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """A thin disc or, without a fill, a ring; a ball where it is a symbol."""
    radius = g.number(0)
    if radius is None:
        return _ball(g, greatest)
    if g.choice("fill", "none") == "none":
        angles = np.linspace(0.0, 2 * np.pi, SEGMENTS + 1)
        ring = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) @ across(g.axis).T
        return _Shown(lines=[_line_in(g, ring)])
    return _riding(g, _turned(cylinder(radius, 0.12 * radius), g.axis), g.shade)


def _line_in(g: Given, points: Vector) -> Line:
    origin, turns = g.poses[0]
    return Line(origin[:, None] + points @ turns.transpose(0, 2, 1), g.choice("style", "normal"))


def _ball(g: Given, greatest: Mapping[str, float]) -> _Shown:
    radius = g.number(0)
    return _riding(g, sphere(0.25 * g.size if radius is None else radius), g.shade)


def _cylinder(g: Given, greatest: Mapping[str, float]) -> _Shown:
    radius, height = g.number(0), g.number(1)
    solid = cylinder(0.15 * g.size if radius is None else radius, 0.5 * g.size if height is None else height)
    return _riding(g, _turned(solid, g.axis), g.shade)


def _cone(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """Its centre of mass, a quarter above its base, is where it stands."""
    radius, height = g.number(0) or 0.0, g.number(1) or 0.0
    return _riding(g, _turned(moved(cylinder(radius, height, 0.0), np.array([0.0, 0.0, height / 4])), g.axis),
                   g.shade)


def _box(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """As high as it is deep; a slender one where its height was left out."""
    length, height = g.number(0), g.number(1)
    thick = height if height is not None else (0.25 if length is not None else 0.5) * g.size
    along = g.options["along"][0] if "along" in g.options else np.array([1.0, 0.0, 0.0])
    solid = box(0.6 * g.size if length is None else length, thick, thick)
    turn = across(along) @ across(np.array([1.0, 0.0, 0.0])).T if along[1:].any() else None
    return _riding(g, solid if turn is None else moved(solid, np.zeros(3), turn), g.shade)


def _cuboid(g: Given, greatest: Mapping[str, float]) -> _Shown:
    return _riding(g, box(*(g.number(k) or 0.0 for k in range(3))), g.shade)


def _hatch(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """A plate, where it stands on the ground."""
    return _Shown() if not g.is_ground else _riding(g, box(0.8 * g.size, 0.8 * g.size, 0.1 * g.size), "grey")


def _way(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """A line, a polyline, a rail."""
    return _Shown(lines=[Line(np.stack([origin for origin, _ in g.poses], axis=1), g.choice("style", "normal"))])


def _polygon(g: Given, greatest: Mapping[str, float]) -> _Shown:
    places = [origin for origin, _ in (*g.poses, g.poses[0])]
    return _Shown(lines=[Line(np.stack(places, axis=1), g.choice("style", "normal"))])


def _arc(g: Given, greatest: Mapping[str, float]) -> _Shown:
    radius, begin, end = (float(g.numbers[k][0, 0]) for k in range(3))
    angles = np.linspace(begin, end, SEGMENTS)
    return _Shown(lines=[_line_in(g, radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1))])


def _zigzag(g: Given, greatest: Mapping[str, float]) -> _Shown:
    a, b = (origin for origin, _ in g.poses)
    turns, radius, axes = turns_of(a, b, g.symbol), 0.2 * g.symbol, g.hinge
    if axes is not None:
        a, b, turns, radius = helix(a, axes, g.symbol)
    return _Shown(lines=[Line(np.stack([a, b], axis=1), g.stroke, turns, radius)])


def _dashpot(g: Given, greatest: Mapping[str, float]) -> _Shown:
    a, b = (origin for origin, _ in g.poses)
    axes = g.hinge
    parts = dashpot(a, b, g.symbol) if axes is None else brake(a, axes, g.symbol)
    return _Shown(lines=[Line(points, g.stroke) for points in parts])


def _arrow(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """Of a load; directions of coordinates are told by no arrow in space."""
    if g.measure not in (*LOADS, "length") or g.numbers[0].shape[1] != 3:
        return _Shown()
    scale = 1.0 if g.measure == "length" else LONGEST_ARROW * g.symbol / (greatest.get(g.measure) or 1.0)
    at = g.poses[0][0]
    return _Shown(lines=[Line(arrow(at, at + scale * g.numbers[0], g.symbol), "thick")])


def _curved_arrow(g: Given, greatest: Mapping[str, float]) -> _Shown:
    """Of a torque: about its axis, which a vector is in the world and a number has in its frame."""
    if g.measure not in LOADS:
        return _Shown()
    origin, turns = g.poses[0]
    value = g.numbers[0]
    about = value if value.shape[1] == 3 else np.sign(value) * (turns @ g.axis)
    sizes = np.linalg.norm(value, axis=1)
    axes = np.array([across(way) if size > 0 else np.eye(3) for way, size in zip(about, sizes, strict=True)])
    radius = 0.8 * g.symbol
    points = arc(origin, axes, radius, 1.5 * np.pi)
    points[sizes == 0] = np.nan
    return _Shown(lines=[Line(points, "thick")])


SHOWN = {
    "line": _way, "polyline": _way, "rail": _way, "polygon": _polygon, "circle": _circle, "arc": _arc, "box": _box,
    "cuboid": _cuboid, "cylinder": _cylinder, "cone": _cone, "ball": _ball, "zigzag": _zigzag, "dashpot": _dashpot,
    "arrow": _arrow, "curved_arrow": _curved_arrow, "hatch": _hatch,
}  # gears and belts are of the plane
