"""A reel -> an SVG that plays by itself, for ever: animations as SMIL has them (SVG 1.1, chapter 19), no script."""

import numpy as np
from numpy.typing import NDArray

from lagrangia.draw.animation import speed_of
from lagrangia.draw.page import LINES, View, view_of, weight_of
from lagrangia.draw.reel import Moving, Reel, in_order
from lagrangia.draw.strokes import Stroke
from lagrangia.draw.svg import FILLS, millimetres

Vector = NDArray[np.float64]
_MOST = 240  # moments; between them places change evenly
_SHORTEST = 0.01  # s


def write_moving_svg(reel: Reel) -> str:
    """The whole file."""
    length = float(reel.t[-1] - reel.t[0])
    kept = np.unique(np.linspace(0, len(reel.t) - 1, min(len(reel.t), _MOST)).round().astype(int))
    view = view_of([Stroke(np.array([reel.low, reel.high]), 0)], np.inf)
    lasts, weight = max(_SHORTEST, length / speed_of(length)), weight_of(reel.symbol * view.scale)
    writer = _Writer(view, kept, reel.t[kept] - reel.t[0], lasts, weight)
    width, height = millimetres(view.width), millimetres(view.height)
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}" '
            f'fill="none" stroke="#000" stroke-width="{writer.pen("normal")}" stroke-linecap="round" stroke-linejoin="round">')
    ground = f'<rect width="{width}" height="{height}" fill="#fff" stroke="none"/>'
    ways = [writer.way(points[kept]) for _, points in reel.traces]
    return "\n".join([head, ground, *ways, *(writer.stroke(moving) for moving in in_order(reel)), "</svg>"]) + "\n"


class _Writer:
    """`t`: of the moments, s from the first; `lasts`: of one round, s."""

    def __init__(self, view: View, kept: "np.ndarray", t: Vector, lasts: float, weight: float) -> None:
        self.view, self.kept, self.lasts, self.weight = view, kept, lasts, weight
        self.times = t / t[-1] if len(t) > 1 and t[-1] > 0 else np.linspace(0, 1, len(t))
        even = np.linspace(0, 1, len(t))
        self.is_even = bool(np.abs(self.times - even).max() < 1e-6)

    def pen(self, line: str) -> str:
        """The width of a line, mm."""
        return millimetres(LINES[line] * self.weight)

    def stroke(self, moving: Moving) -> str:
        """Standing, riding on a frame, or changing its shape."""
        stroke = moving.stroke
        if moving.poses is not None:
            poses = moving.poses[self.kept]
            own = self._shape(stroke, stroke.points * (1, -1) * self.view.scale, "")
            places = self._page(poses[:, :2])
            turn = self._transform("rotate", [f"{-x:.2f}" for x in np.degrees(np.unwrap(poses[:, 2]))])
            move = self._transform("translate", [self._pair(p) for p in places])
            return f"<g>{move}<g>{turn}{own}</g></g>"
        if moving.points is None:
            return self._shape(stroke, self._page(stroke.points), "")
        points = moving.points[self.kept]
        seen: NDArray[np.bool_] = np.isfinite(points).all(axis=(1, 2))
        if not seen.any():
            return ""
        shown = points[np.maximum.accumulate(np.where(seen, np.arange(len(seen)), np.argmax(seen)))]  # as it was seen last
        inside = "" if seen.all() else self._animate("visibility", ["visible" if x else "hidden" for x in seen], "discrete")
        outlines = [self._page(row) for row in shown]
        if stroke.radius > 0:
            for k, name in enumerate(("cx", "cy")):
                inside += self._animate(name, [millimetres(outline[0, k]) for outline in outlines])
        else:
            inside += self._animate("points", [" ".join(map(self._pair, outline)) for outline in outlines])
        return self._shape(stroke, outlines[0], inside)

    def way(self, points: Vector) -> str:
        """A trace that grows."""
        points = points[np.isfinite(points).all(axis=1)]
        if len(points) < 2:
            return ""
        gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
        rest = 1 - gone / (gone[-1] or 1.0)
        grows = self._animate("stroke-dashoffset", [f"{x:.4g}" for x in rest]) if len(rest) == len(self.times) else ""
        looks = f' stroke="#c0392b" stroke-width="{self.pen("thin")}" pathLength="1" stroke-dasharray="1"'
        return f'<polyline points="{" ".join(map(self._pair, self._page(points)))}"{looks}>{grows}</polyline>'

    def _page(self, points: Vector) -> Vector:
        found: Vector = self.view.points(points) * (1, -1) + (0, self.view.height)
        return found

    @staticmethod
    def _pair(place: Vector) -> str:
        return f"{millimetres(round(place[0], 2))},{millimetres(round(place[1], 2))}"

    def _shape(self, stroke: Stroke, points: Vector, inside: str) -> str:
        looks = f' stroke-width="{self.pen(stroke.line)}"' if LINES[stroke.line] != LINES["normal"] else ""
        looks += ' stroke-dasharray="1.2 0.8"' if stroke.line == "dashed" else ""
        looks += f' fill="{FILLS[stroke.fill]}"' if stroke.fill != "none" else ""
        if stroke.radius > 0:
            (x, y), r = points[0], millimetres(stroke.radius * self.view.scale)
            return f'<circle cx="{millimetres(x)}" cy="{millimetres(y)}" r="{r}"{looks}>{inside}</circle>'
        word = "polygon" if stroke.is_closed else "polyline"
        return f'<{word} points="{" ".join(map(self._pair, points))}"{looks}>{inside}</{word}>'

    def _animate(self, name: str, values: list[str], mode: str = "linear") -> str:
        return f'<animate attributeName="{name}" {self._timing(values, mode)}/>'

    def _transform(self, kind: str, values: list[str]) -> str:
        return f'<animateTransform attributeName="transform" type="{kind}" {self._timing(values, "linear")}/>'

    def _timing(self, values: list[str], mode: str) -> str:
        times = "" if self.is_even and mode == "linear" else f' keyTimes="{";".join(f"{x:.5g}" for x in self.times)}"'
        told = f' calcMode="{mode}"' if mode != "linear" else ""
        return f'values="{";".join(values)}"{times}{told} dur="{self.lasts:.4g}s" repeatCount="indefinite"'
