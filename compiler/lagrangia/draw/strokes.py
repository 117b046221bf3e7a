"""The words of a drawing section -> strokes: polylines and circles in metres, and where their labels belong."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import NDArray

Vector = NDArray[np.float64]
RAILS, RODS, SPRINGS, BODIES, HINGES, ARROWS = range(6)  # what is drawn later hides what was drawn before
_FEWEST, _MOST = 5, 14  # coils of a spring
_ARC = np.deg2rad(6.0)  # between two points of an arc
_FLAT = 0.3  # of a symbol: half the width of a spring that is stretched as far as it will be
_WIDE = 0.75


@dataclass(frozen=True)
class Stroke:
    """A polyline (n, 2), m; with a radius a circle about its one point. `line` and `fill` as in a drawing section."""

    points: Vector
    layer: int
    line: str = "normal"
    fill: str = "none"
    is_closed: bool = False
    radius: float = 0.0

    @property
    def extent(self) -> float:
        """How large it is, if it hides what lies below: small things lie on large ones."""
        return 2 * self.radius + (float(np.ptp(self.points, axis=0).max()) if self.fill != "none" else 0.0)

    def moved(self, shift: Vector, angle: float) -> "Stroke":
        """Turned about the origin, then shifted."""
        c, s = np.cos(angle), np.sin(angle)
        return replace(self, points=self.points @ np.array([[c, s], [-s, c]]) + shift)


@dataclass(frozen=True)
class Spot:
    """Where a label belongs: about a point, m, rather towards `aside`; `room` is the half width and height it may fill inside."""

    at: Vector
    aside: Vector
    room: tuple[float, float] = (0.0, 0.0)


@dataclass
class Shape:
    """What one figure looks like."""

    strokes: list[Stroke] = field(default_factory=list)
    spot: Spot | None = None


@dataclass(frozen=True)
class Given:
    """What a figure is drawn from: places (k, 3) in m and rad, numbers, the size of symbols in m; `trims`: how much of a line
    another drawing hides at its ends, m; `reference`: the greatest length it will have, or of an arrow the greatest value."""

    places: Vector
    numbers: list[Vector]
    symbol: float
    options: Mapping[str, Vector]
    fill: str
    line: str
    trims: tuple[float, float] = (0.0, 0.0)
    reference: float = 0.0
    measure: str = ""
    lane: float = 0.0  # how far it stands aside, in symbols
    is_ground: bool = False
    reach: tuple[float, float] = (0.0, 0.0)  # of a rail: from where to where the slider goes, along it
    lean: Vector = field(default_factory=lambda: np.array([0.0, 1.0]))  # where a support has room; where an angle is measured to

    @property
    def size(self) -> float:
        """Of this symbol, m."""
        return self.symbol * float(self.options["size"][0]) if "size" in self.options else self.symbol

    def number(self, k: int) -> float | None:
        """One of its sizes; None where it was left out."""
        return float(self.numbers[k][0]) if k < len(self.numbers) else None

    def way(self) -> Vector:
        """Along what it stands, in the world's axes."""
        along = self.options.get("along", np.array([1.0, 0.0]))
        length = float(np.linalg.norm(along))
        return turned(along / length if length > 0 else np.array([1.0, 0.0]), float(self.places[0, 2]))


def turned(vector: Vector, angle: float) -> Vector:
    """Counter-clockwise."""
    c, s = np.cos(angle), np.sin(angle)
    return np.array([c * vector[0] - s * vector[1], s * vector[0] + c * vector[1]])


def left_of(way: Vector) -> Vector:
    """Across, to the left."""
    return np.array([-way[1], way[0]])


# -------------------------------------------------------------------- lines between two places


def _line(g: Given) -> Shape:
    a, b, _, across = _ends(g)
    layer = HINGES if g.line in ("thin", "dashed") else RODS  # marks lie on top of what they mark
    return Shape([Stroke(np.array([a, b]), layer, g.line)], Spot((a + b) / 2, across))


def _ends(g: Given) -> tuple[Vector, Vector, Vector, Vector]:
    """Two ends, less what is hidden, the way from one to the other, and across."""
    a, b = g.places[0, :2], g.places[1, :2]
    length = float(np.linalg.norm(b - a))
    way = (b - a) / length if length > 0 else np.array([1.0, 0.0])
    across = left_of(way)
    hidden = min(1.0, length / (sum(g.trims) or 1.0))
    return a + hidden * g.trims[0] * way, b - hidden * g.trims[1] * way, way, across


def _polyline(g: Given) -> Shape:
    return Shape([Stroke(g.places[:, :2], RODS, g.line)], Spot(g.places[:, :2].mean(axis=0), np.array([0.0, 1.0])))


def _polygon(g: Given) -> Shape:
    points = g.places[:, :2]
    spot = Spot(points.mean(axis=0), np.array([0.0, 1.0]), (g.size, g.size))
    return Shape([Stroke(points, BODIES, g.line, g.fill, True)], spot)


def _zigzag(g: Given) -> Shape:
    a, b, way, across = _ends(g)
    length = float(np.linalg.norm(b - a))
    if length < 0.3 * g.symbol:
        return _spiral(g)
    coil = 0.7  # the rest is straight
    span = coil * max(g.reference, length)
    count = 2 * int(np.clip(round(span / (0.5 * g.symbol)), _FEWEST, _MOST))
    wire = np.hypot(span / count, 2 * _FLAT * g.symbol)
    width = np.sqrt(max(wire**2 - (coil * length / count) ** 2, 0.0)) / 2
    width = float(np.clip(width, 0.05 * g.symbol, _WIDE * g.symbol))
    begin = (1 - coil) / 2
    steps = np.concatenate([[0.0, begin], begin + coil * (np.arange(count) + 0.5) / count, [1 - begin, 1.0]])
    heights = np.concatenate([[0.0, 0.0], width * (-1.0) ** np.arange(count), [0.0, 0.0]])
    points = a + np.outer(steps * length, way) + np.outer(heights, across)
    return _beside(g, [Stroke(points, SPRINGS, g.line)], a, b, across, width)


def _beside(g: Given, strokes: list[Stroke], a: Vector, b: Vector, across: Vector, width: float) -> Shape:
    """In its lane, with what leads there."""
    aside = g.lane * g.symbol * across
    if g.lane:
        ends = [Stroke(np.array([end, end + aside]), SPRINGS, g.line) for end in (a, b)]
        strokes = [replace(stroke, points=stroke.points + aside) for stroke in strokes] + ends
    side = across if g.lane >= 0 else -across
    return Shape(strokes, Spot((a + b) / 2 + aside + side * width, side))


def _spiral(g: Given) -> Shape:
    """A spring between two that turn about one place."""
    angles = np.arange(0.0, 5.2 * np.pi, _ARC)
    radii = g.symbol * (0.25 + 0.65 * angles / angles[-1])
    points = g.places[0, :2] + np.stack([radii * np.cos(angles), radii * np.sin(angles)], axis=1)
    return Shape([Stroke(points, HINGES, "thin")], Spot(points[-1], np.array([1.0, 0.5])))


def _dashpot(g: Given) -> Shape:
    a, b, way, across = _ends(g)
    length = float(np.linalg.norm(b - a))
    if length < 0.3 * g.symbol:
        return _brake(g)
    whole = max(g.reference, length)
    begin, end = 0.25 * length, 0.25 * length + 0.4 * whole
    end = min(end, 0.8 * length) if length > 0.4 * whole else 0.8 * length
    piston = float(np.clip(length - 0.45 * whole, begin + 0.15 * (end - begin), end - 0.15 * (end - begin)))
    half = 0.26 * g.symbol

    def at(x: float, y: float) -> Vector:
        return np.asarray(a + x * way + y * across)

    strokes = [np.array([at(0, 0), at(begin, 0)]), np.array([at(end, half), at(begin, half), at(begin, -half), at(end, -half)]),
               np.array([at(piston, 0.75 * half), at(piston, -0.75 * half)]), np.array([at(piston, 0), at(length, 0)])]
    return _beside(g, [Stroke(points, SPRINGS, g.line) for points in strokes], a, b, across, half)


def _brake(g: Given) -> Shape:
    """A damper between two that turn about one place."""
    at, radius = g.places[0, :2], 0.8 * g.symbol
    strokes = [Stroke(_arc_points(at, radius * scale, begin, begin + np.deg2rad(span)), HINGES, g.line)
               for scale, begin, span in ((1.0, np.deg2rad(200.0), 110.0), (0.75, np.deg2rad(225.0), 60.0))]
    return Shape(strokes, Spot(at + radius * np.array([-0.6, -0.8]), np.array([-0.6, -0.8])))


# -------------------------------------------------------------------- bodies


def _circle(g: Given) -> Shape:
    radius = g.number(0)
    radius = 0.5 * g.size if radius is None else abs(radius)
    at = g.places[0, :2]
    layer = HINGES if radius <= 0.3 * g.symbol else BODIES
    inside = (0.8 * radius, 0.4 * radius) if radius > g.symbol and g.fill != "black" else (0.0, 0.0)
    far = radius * np.array([0.6, 0.8])
    spot = Spot(at + 0.45 * radius * np.array([0.0, 1.0]) if inside[0] else at + far, far, inside)  # clear of the hub
    return Shape([Stroke(g.places[:1, :2], layer, g.line, g.fill, True, radius)], spot)


def _arc(g: Given) -> Shape:
    at, angle = g.places[0, :2], float(g.places[0, 2])
    radius, begin, end = (g.number(k) or 0.0 for k in range(3))
    points = _arc_points(at, radius, angle + begin, angle + end)
    return Shape([Stroke(points, RODS, g.line)], Spot(points[len(points) // 2], points[len(points) // 2] - at))


def _arc_points(at: Vector, radius: float, begin: float, end: float) -> Vector:
    count = max(2, int(abs(end - begin) / _ARC) + 2)
    angles = np.linspace(begin, end, min(count, 400))
    points: Vector = at + radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return points


def _box(g: Given) -> Shape:
    length, height = g.number(0), g.number(1)
    is_slim = length is not None and height is None
    half = (g.size if length is None else 0.5 * length,
            0.5 * height if height is not None else (0.2 if is_slim else 0.7) * g.size)
    angle = float(g.options["angle"][0]) if "angle" in g.options else 0.0
    way = turned(g.way(), angle)
    at = g.places[0, :2]
    corners = [(half[0], half[1]), (-half[0], half[1]), (-half[0], -half[1]), (half[0], -half[1])]
    points = np.array(corners)
    if g.line == "round":
        points = np.concatenate([_arc_points(np.array([side * half[0], 0.0]), half[1], begin, begin + np.pi)
                                 for side, begin in ((1.0, -np.pi / 2), (-1.0, np.pi / 2))])
    world = at + np.outer(points[:, 0], way) + np.outer(points[:, 1], left_of(way))
    line = "normal" if g.line == "round" else g.line
    beside = at + left_of(way) * half[1] + 0.3 * half[0] * way  # in the middle a joint may be
    room = (half[0], half[1]) if not is_slim else (0.0, 0.0)
    return Shape([Stroke(world, BODIES, line, g.fill, True)], Spot(at if room[0] else beside, left_of(way), room))


# -------------------------------------------------------------------- arrows


def _arrow(g: Given) -> Shape:
    vector = g.numbers[0]
    value = float(np.linalg.norm(vector))
    if value == 0:
        return Shape()
    way = vector / value
    at = g.places[0, :2]
    if g.measure == "direction":
        begin = at + left_of(way) * g.symbol * 1.25 * (1 if left_of(way)[1] >= 0 else -1)
        return _headed(begin, begin + 1.4 * g.symbol * way, g.symbol, "thin", has_foot=True)
    if g.measure == "length":
        return _headed(at, at + vector, g.symbol, g.line)
    length = g.symbol * (0.6 + 2.4 * min(1.0, value / g.reference)) if g.reference > 0 else 2.5 * g.symbol
    free = g.trims[0] * way
    up = left_of(way) if way[0] > 0 else -left_of(way)
    at = at + (0.5 * g.symbol * up if g.trims[0] > 0 and abs(way[0]) > 0.5 else 0.0)  # clear of what pulls at the middle
    begin = at + free if vector[1] >= -0.5 * value else at - free - way * length  # what pushes down stands above
    shape = _headed(begin, begin + way * length, g.symbol, "thick")
    return Shape(shape.strokes, Spot(begin + way * length / 2, left_of(way)))


def _headed(a: Vector, b: Vector, symbol: float, line: str, has_foot: bool = False) -> Shape:
    length = float(np.linalg.norm(b - a))
    if length == 0:
        return Shape()
    way = (b - a) / length
    head = min(0.45 * symbol, 0.6 * length)
    across = 0.3 * symbol * left_of(way)
    foot = [Stroke(np.array([a + across, a - across]), ARROWS, "thin")] if has_foot else []
    shaft = Stroke(np.array([a, b - 0.8 * head * way]), ARROWS, line)
    return Shape([shaft, _head(b, way, head), *foot], Spot(b, way + left_of(way)))


def _head(tip: Vector, way: Vector, size: float) -> Stroke:
    base, across = tip - size * way, left_of(way)
    points = np.array([tip, base + 0.35 * size * across, base - 0.35 * size * across])
    return Stroke(points, ARROWS, "thin", "black", True)


def _curved_arrow(g: Given) -> Shape:
    at, value = g.places[0, :2], float(g.numbers[0][0])
    if g.measure == "angle":
        return _angle(g, at, value)
    sweep = np.deg2rad(60 + 170 * min(1.0, abs(value) / g.reference)) if g.reference > 0 else np.deg2rad(200.0)
    sign = 1.0 if value >= 0 else -1.0
    radius = 1.15 * g.symbol if not any(g.trims) else g.trims[0] + 0.5 * g.symbol
    middle = np.deg2rad(60.0)
    points = _arc_points(at, radius, middle - sign * sweep / 2, middle + sign * sweep / 2)
    return _round_headed(points, g.symbol, "thick", points[len(points) // 2] - at)


def _angle(g: Given, at: Vector, value: float) -> Shape:
    """From where its frame's x axis, or what hangs on it, would be, to where it is."""
    begin = float(g.places[0, 2]) + float(np.arctan2(g.lean[1], g.lean[0]))
    shown = value if abs(value) > np.deg2rad(8.0) else np.deg2rad(28.0) * (1 if value >= 0 else -1)
    shown = float(np.clip(shown, -1.75 * np.pi, 1.75 * np.pi))
    radius = 1.9 * g.symbol
    points = _arc_points(at, radius, begin, begin + shown)
    axis = at + 1.25 * radius * np.array([np.cos(begin), np.sin(begin)])
    shape = _round_headed(points, g.symbol, "thin", points[len(points) // 2] - at)
    return Shape([Stroke(np.array([at, axis]), RAILS, "dashed"), *shape.strokes], shape.spot)


def _round_headed(points: Vector, symbol: float, line: str, aside: Vector) -> Shape:
    steps = np.linalg.norm(np.diff(points, axis=0), axis=1)
    size = min(0.4 * symbol, 0.6 * float(steps.sum()))
    gone = np.concatenate([[0.0], np.cumsum(steps)])
    end = max(0.0, float(gone[-1]) - 0.9 * size)
    base = np.array([np.interp(end, gone, points[:, k]) for k in range(2)])
    kept = np.concatenate([points[gone < end], base[None]])
    gap = float(np.linalg.norm(points[-1] - base))
    way = (points[-1] - base) / gap if gap > 0 else np.array([1.0, 0.0])
    strokes = [Stroke(kept, ARROWS, line)] if len(kept) > 1 else []
    return Shape([*strokes, _head(points[-1], way, size)], Spot(points[len(points) // 2], aside))


# -------------------------------------------------------------------- ground, rails, wheels


def hatched(at: Vector, way: Vector, half: float, symbol: float) -> list[Stroke]:
    """A line of the ground, half as long, m; the ground is to its right."""
    count = max(2, min(200, round(2 * half / (0.4 * symbol))))
    starts = np.linspace(-half, half, count + 1)[1:]
    slant = -0.4 * symbol * way - 0.4 * symbol * left_of(way)
    strokes = [Stroke(np.array([at - half * way, at + half * way]), RAILS, "normal")]
    return strokes + [Stroke(np.array([at + x * way, at + x * way + slant]), RAILS, "thin") for x in starts]


def _hatch(g: Given) -> Shape:
    at = g.places[0, :2]
    if not g.is_ground:
        return Shape()
    if "along" in g.options:
        return Shape(hatched(at, g.way(), 1.5 * g.size, g.symbol))
    down = g.lean
    foot, across = at + 0.85 * g.size * down, left_of(down)
    triangle = np.array([at, foot + 0.6 * g.size * across, foot - 0.6 * g.size * across])
    layer = HINGES if g.trims[0] > g.symbol else RODS  # a wheel would hide it
    ground = [replace(stroke, layer=max(layer, stroke.layer)) if layer == HINGES else stroke
              for stroke in hatched(foot, across, g.size, g.symbol)]
    return Shape([Stroke(triangle, layer, "normal", "white", True), *ground])


def _rail(g: Given) -> Shape:
    way = g.way()
    under = -left_of(way)
    under = -under if under[1] > 1e-6 else under
    offset = float(g.options["offset"][0]) * 0.7 * g.symbol if "offset" in g.options else 0.0
    low, high = g.reach[0] - 1.7 * g.symbol, g.reach[1] + 1.7 * g.symbol
    at = g.places[0, :2] + offset * under + (low + high) / 2 * way
    right = way if -left_of(way) @ under > 0 else -way
    if g.is_ground:
        return Shape(hatched(at, right, (high - low) / 2, g.symbol))
    return Shape([Stroke(np.array([at - (high - low) / 2 * way, at + (high - low) / 2 * way]), RAILS, "thin")])


def _wheels(g: Given, is_crossed: bool) -> Shape:
    radii = [abs(g.number(0) or 0.0), abs(g.number(1) or 0.0)]
    centres = g.places[:, :2]
    strokes = [Stroke(centres[k : k + 1], HINGES, "dashed", "none", True, radii[k]) for k in range(2)]
    gap = centres[1] - centres[0]
    length = float(np.linalg.norm(gap))
    if not is_crossed and length > abs(radii[0] - radii[1]):
        angle = float(np.arccos((radii[0] - radii[1]) / length))
        for sign in (1.0, -1.0):
            normal = turned(gap / length, sign * angle)
            strokes.append(Stroke(np.array([centres[k] + radii[k] * normal for k in range(2)]), HINGES, "normal"))
    return Shape(strokes)


def _text(g: Given) -> Shape:
    return Shape([], Spot(g.places[0, :2], np.array([0.0, 1.0])))


SHAPES: Mapping[str, Callable[[Given], Shape]] = {
    "line": _line, "polyline": _polyline, "polygon": _polygon, "circle": _circle, "arc": _arc, "box": _box, "zigzag": _zigzag,
    "dashpot": _dashpot, "arrow": _arrow, "curved_arrow": _curved_arrow, "hatch": _hatch, "rail": _rail, "text": _text,
    "gears": lambda g: _wheels(g, True), "belt": lambda g: _wheels(g, False),
}
