"""Figures of a scene in space, at the moments of a motion -> a stage."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.compile.functions import observer_of
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.names import label_all
from lagrangia.draw.values import States, measure_of, root_of
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.joints import component_of
from lagrangia.frames.kinematics import Kinematics
from lagrangia.frames.steps import Step
from lagrangia.language.figures import CHOICES, WORDS
from lagrangia.language.flat import Figure, places_of
from lagrangia.language.tree import Call, Flat, FrameRef, String
from lagrangia.solids.shapes import Solid, across, arc, arrow, box, cylinder, dashpot, moved, sphere, turns_of
from lagrangia.solids.stage import SHADES, Body, Caption, Line, Stage, quaternions

Vector = NDArray[np.float64]
_SYMBOLS_ACROSS = 14.0
_OF_A_POSE = 12  # numbers: an origin, and a matrix by its rows
_LONGEST_ARROW = 3.0  # symbols
_MOST_LABELS = 40
_SEGMENTS = 48  # of a circle that is a line
_BODIES = ("circle", "box", "cuboid", "cylinder", "cone", "ball")
_LOADS = ("force", "torque", "other")


@dataclass
class _Rows:
    """Scalars, in the order in which they are asked for."""

    kinematics: Kinematics
    scalars: list[ca.SX] = field(default_factory=list)

    def add(self, values: Sequence[ca.SX]) -> slice:
        self.scalars += [ca.SX(x) for x in values]
        return slice(len(self.scalars) - len(values), len(self.scalars))

    def value(self, node: Flat) -> slice:
        return self.add(scalars_of(self.kinematics.evaluator.value(node)))

    def place(self, node: Flat) -> slice:
        """Of a frame, or of a position, whose axes are the world's."""
        pose = self._pose(node)
        if pose is None:
            return self.add([*scalars_of(self.kinematics.evaluator.value(node)), *np.eye(3).ravel()])
        origin, axes = (self.kinematics.geometry.attribute_of(pose, name) for name in ("r", "R"))
        return self.add([*origin, *(x for row in axes for x in row)])

    def _pose(self, node: Flat) -> Any:
        if isinstance(node, FrameRef) and not node.attribute:
            return self.kinematics.pose(node.name, 0)
        if not isinstance(node, Call) or node.function not in ("shift", "turn"):
            return None
        base, amount, *axis = node.arguments
        step = Step(node.function, amount, False, axis[0] if axis else None)
        return self.kinematics.step(step, self._pose(base), 0)


@dataclass(frozen=True)
class _Given:
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


@dataclass
class _Shown:
    """What one figure adds."""

    bodies: list[Body] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)


def build_stage(c: Compilation, figures: Sequence[Figure], states: States, names: Mapping[str, str],
                traces: Sequence[str]) -> Stage:
    """`traces` are names of frames, beside those that drawing sections ask for. Raises LagError."""
    rows, lost = _Rows(c.kinematics), set(c.graph.unused_frames)
    shown = [figure for figure in figures if not any(root_of(place) in lost for place in _places(figure))]
    asked = [_ask(rows, figure) for figure in shown]
    frames = {name: rows.place(FrameRef(name, "", (), c.flat.frames[name].span)) for name in c.flat.frames if name not in lost}
    up = rows.add(_up(c.kinematics))
    observe = observer_of(c.kinematics, c.motion, c.constraints, ca.densify(ca.vertcat(*rows.scalars)))
    values = np.array(observe(states.t, states.q, states.v, states.u, states.p), dtype=float).reshape(len(rows.scalars), -1).T
    places = {name: _pose(values[:, at]) for name, at in frames.items()}
    sizes = [float(np.abs(values[0, at]).max()) for figure, (_, numbers, _) in zip(shown, asked, strict=True)
             if figure.word in _BODIES for at in numbers]
    symbol = _symbol([origins for origins, _ in places.values()], max((x for x in sizes if np.isfinite(x)), default=0.0))
    grounded = _grounded(c)
    given = [_given(c, figure, asks, values, symbol, grounded) for figure, asks in zip(shown, asked, strict=True)]
    greatest = _greatest(given)
    found = [SHOWN[g.figure.word](g, greatest) for g in given if g.poses and g.figure.word in SHOWN]
    ways = [(g.frames[0], g.poses[0][0]) for g in given if g.poses and g.figure.word == "trace"]
    ways += [(name, places[name][0]) for name in traces]
    rods = _rods(c, places, {g.figure.component for g in given}, grounded, symbol)
    return Stage(states.t[0], tuple(body for one in found for body in one.bodies),
                 (*(line for one in found for line in one.lines), *rods), tuple(_captions(c, given, names)), tuple(ways), symbol,
                 _upwards(values[0, up]))


def _ask(rows: _Rows, figure: Figure) -> tuple[list[slice], list[slice], dict[str, slice]]:
    takes = WORDS[figure.word].takes
    kinds = [takes[min(k, len(takes) - 1)] for k in range(len(figure.arguments))]
    numbers = [rows.value(node) for node, kind in zip(figure.arguments, kinds, strict=True) if kind not in ("place", "text")]
    options = {name: rows.value(node) for name, node in figure.options.items() if name not in ("label", "of", *CHOICES)}
    return [rows.place(place) for place in _places(figure)], numbers, options


def _places(figure: Figure) -> list[Flat]:
    takes = WORDS[figure.word].takes
    return [place for k, node in enumerate(figure.arguments) if takes[min(k, len(takes) - 1)] == "place"
            for place in places_of(node)]


def _given(c: Compilation, figure: Figure, asked: tuple[list[slice], list[slice], dict[str, slice]], values: Vector,
           symbol: float, grounded: set[str]) -> _Given:
    places, numbers, options = asked
    frames = tuple(root_of(place) for place in _places(figure))
    return _Given(figure, frames, tuple(_pose(values[:, at]) for at in places),
                  tuple(values[:, at] for at in numbers), {name: values[:, at] for name, at in options.items()},
                  measure_of(c.flat, figure), symbol, bool(frames) and (not frames[0] or frames[0] in grounded))


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


def _up(kinematics: Kinematics) -> Sequence[Any]:
    """Against gravity, where there is any."""
    return [-x for x in scalars_of(kinematics.symbols.values.get("world.gravity", (0.0, 0.0, 0.0)))]


def _symbol(origins: Sequence[Vector], largest: float) -> float:
    """The size of symbols, m: by how far apart frames are, and by the largest size of a body."""
    points = np.concatenate(origins) if origins else np.zeros((0, 3))
    points = points[np.isfinite(points).all(axis=1)]
    reach = max(2 * largest, float(np.linalg.norm(np.ptp(points, axis=0))) if len(points) else 0.0)
    return reach / _SYMBOLS_ACROSS if reach > 0 else 0.1


def _greatest(given: Sequence[_Given]) -> dict[str, float]:
    """Of forces, of torques."""
    found: dict[str, float] = {}
    for g in given:
        if g.measure in _LOADS:
            sizes = np.linalg.norm(g.numbers[0], axis=1)
            found[g.measure] = max(found.get(g.measure, 0.0), float(np.nanmax(sizes, initial=0.0)))
    return found


def _rods(c: Compilation, places: Mapping[str, tuple[Vector, Vector]], drawn: set[str], grounded: set[str], symbol: float
          ) -> list[Line]:
    """Frames that sit at a fixed place of another one, away from it, are held by a rod."""
    found = []
    for edge in c.graph.edges:
        own = component_of(edge.parent)
        if not edge.is_rigid or edge.parent in grounded or (own == component_of(edge.child) and own in drawn):
            continue
        ends = np.stack([places[edge.parent][0], places[edge.child][0]], axis=1)
        if float(np.linalg.norm(ends[0, 1] - ends[0, 0])) > 0.02 * symbol:
            found.append(Line(ends, "thick"))
    return found


def _captions(c: Compilation, given: Sequence[_Given], names: Mapping[str, str]) -> list[Caption]:
    """Of figures with labels, but for those of coordinates."""
    labelled = [g for g in given if ("label" in g.figure.options or g.figure.word == "text")
                and g.measure not in ("angle", "direction")]
    labels = [g.figure.arguments[-1] if g.figure.word == "text" else g.figure.options["label"] for g in labelled]
    found = []
    seen = set()
    for g, words in zip(labelled, label_all(c.flat, labels, names), strict=True):
        if words is not None and words.plain not in seen and g.poses:
            seen.add(words.plain)
            found.append(Caption(words, np.mean([origin for origin, _ in g.poses], axis=0)))
    return found if len(found) <= _MOST_LABELS else []


# -------------------------------------------------------------------- words


def _riding(g: _Given, solid: Solid, shade: str, place: int = 0) -> _Shown:
    """A solid in the axes of a frame."""
    origin, turns = g.poses[place]
    return _Shown([Body(solid, np.concatenate([origin, quaternions(turns)], axis=1), shade)])


def _turned(solid: Solid, axis: Vector) -> Solid:
    return moved(solid, np.zeros(3), across(axis)) if axis[:2].any() else solid


def _circle(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """A thin disc or, without a fill, a ring; a ball where it is a symbol."""
    radius = g.number(0)
    if radius is None:
        return _ball(g, greatest)
    if g.choice("fill", "none") == "none":
        angles = np.linspace(0.0, 2 * np.pi, _SEGMENTS + 1)
        ring = radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1) @ across(g.axis).T
        return _Shown(lines=[_line_in(g, ring)])
    return _riding(g, _turned(cylinder(radius, 0.12 * radius), g.axis), g.shade)


def _line_in(g: _Given, points: Vector) -> Line:
    origin, turns = g.poses[0]
    return Line(origin[:, None] + points @ turns.transpose(0, 2, 1), g.choice("style", "normal"))


def _ball(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    radius = g.number(0)
    return _riding(g, sphere(0.25 * g.size if radius is None else radius), g.shade)


def _cylinder(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    radius, height = g.number(0), g.number(1)
    solid = cylinder(0.15 * g.size if radius is None else radius, 0.5 * g.size if height is None else height)
    return _riding(g, _turned(solid, g.axis), g.shade)


def _cone(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """Its centre of mass, a quarter above its base, is where it stands."""
    radius, height = g.number(0) or 0.0, g.number(1) or 0.0
    return _riding(g, _turned(moved(cylinder(radius, height, 0.0), np.array([0.0, 0.0, height / 4])), g.axis),
                   g.shade)


def _box(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """As high as it is deep; a slender one where its height was left out."""
    length, height = g.number(0), g.number(1)
    thick = height if height is not None else (0.25 if length is not None else 0.5) * g.size
    along = g.options["along"][0] if "along" in g.options else np.array([1.0, 0.0, 0.0])
    solid = box(0.6 * g.size if length is None else length, thick, thick)
    turn = across(along) @ across(np.array([1.0, 0.0, 0.0])).T if along[1:].any() else None
    return _riding(g, solid if turn is None else moved(solid, np.zeros(3), turn), g.shade)


def _cuboid(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    return _riding(g, box(*(g.number(k) or 0.0 for k in range(3))), g.shade)


def _hatch(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """A plate, where it stands on the ground."""
    return _Shown() if not g.is_ground else _riding(g, box(0.8 * g.size, 0.8 * g.size, 0.1 * g.size), "grey")


def _way(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """A line, a polyline, a rail."""
    return _Shown(lines=[Line(np.stack([origin for origin, _ in g.poses], axis=1), g.choice("style", "normal"))])


def _polygon(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    places = [origin for origin, _ in (*g.poses, g.poses[0])]
    return _Shown(lines=[Line(np.stack(places, axis=1), g.choice("style", "normal"))])


def _arc(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    radius, begin, end = (float(g.numbers[k][0, 0]) for k in range(3))
    angles = np.linspace(begin, end, _SEGMENTS)
    return _Shown(lines=[_line_in(g, radius * np.stack([np.cos(angles), np.sin(angles), 0 * angles], axis=1))])


def _zigzag(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    a, b = (origin for origin, _ in g.poses)
    ends = np.stack([a, b], axis=1)
    return _Shown(lines=[Line(ends, g.choice("style", "normal"), turns_of(a, b, g.symbol), 0.2 * g.symbol)])


def _dashpot(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    a, b = (origin for origin, _ in g.poses)
    return _Shown(lines=[Line(points, g.choice("style", "normal")) for points in dashpot(a, b, g.symbol)])


def _arrow(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """Of a load; directions of coordinates are told by no arrow in space."""
    if g.measure not in (*_LOADS, "length") or g.numbers[0].shape[1] != 3:
        return _Shown()
    scale = 1.0 if g.measure == "length" else _LONGEST_ARROW * g.symbol / (greatest.get(g.measure) or 1.0)
    at = g.poses[0][0]
    return _Shown(lines=[Line(arrow(at, at + scale * g.numbers[0], g.symbol), "thick")])


def _curved_arrow(g: _Given, greatest: Mapping[str, float]) -> _Shown:
    """Of a torque: about its axis, which a vector is in the world and a number has in its frame."""
    if g.measure not in _LOADS:
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
