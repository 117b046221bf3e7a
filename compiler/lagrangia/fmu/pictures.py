"""Pictures of a scene for its FMU: an icon of the mechanism at its start, and the component graph."""

import struct
import zlib
from collections.abc import Mapping
from typing import TYPE_CHECKING
from xml.sax.saxutils import escape

from lagrangia.compile.pipeline import Compilation
from lagrangia.fmu.variables import Exportable

if TYPE_CHECKING:
    import numpy as np

_PIXELS, _MARGIN = 128, 20
_RIGID, _JOINT, _GROUND = (0x1F, 0x4E, 0x79), (0xC5, 0x5A, 0x11), (0x59, 0x59, 0x59)
_THICK, _THIN, _DOT, _DASH = 2.7, 1.1, 3.5, 4.0  # pixels
_MOST_FRAMES = 400  # shown in a picture
_COLUMN, _ROW = 170, 34


def draw_icon(model: Exportable, start: tuple[float, ...]) -> bytes:
    """A PNG of 128 x 128: rigid connections between frames as lines, joints as dots, the ground as a triangle.

    Painted here: importing a library for pictures would take longer than all else of an FMU.
    """
    graph = model.compilation.kinematics.graph
    places = {"world": (0.0, 0.0), **_places(model, start)}
    canvas = _Canvas(places)
    canvas.ground("world")
    edges = [edge for edge in graph.edges if edge.parent in places and edge.child in places]
    for edge in sorted(edges, key=lambda edge: not edge.is_rigid):
        if edge.is_rigid:
            canvas.line(edge.parent, edge.child, _THICK, _RIGID)
        else:
            canvas.line(edge.parent, edge.child, _THIN, _JOINT, is_dashed=True)
            canvas.line(edge.child, edge.child, 2 * _DOT, _JOINT)
    return _png(canvas.pixels)


class _Canvas:
    """White pixels (rows, columns, 3), into which all places fit, with y upwards."""

    def __init__(self, places: Mapping[str, tuple[float, float]]) -> None:
        import numpy as np

        found = np.array(list(places.values()))
        found[~np.isfinite(found)] = 0.0
        size = max(float(np.ptp(found, axis=0).max()), 1e-9)
        middle = (found.max(axis=0) + found.min(axis=0)) / 2
        scaled = (found - middle) / size * (_PIXELS - 2 * _MARGIN) * (1, -1) + _PIXELS / 2
        self._places = dict(zip(places, scaled, strict=True))
        self.pixels = np.full((_PIXELS, _PIXELS, 3), 255.0)
        grid = np.arange(_PIXELS) + 0.5
        self._x, self._y = grid[None, :], grid[:, None]

    def line(self, first: str, last: str, width: float, color: tuple[int, int, int], is_dashed: bool = False) -> None:
        """With round ends, its borders smoothed over a pixel. A place to itself is a dot."""
        import numpy as np

        (x, y), (dx, dy) = self._places[first], self._places[last] - self._places[first]
        length = float(np.hypot(dx, dy))
        along = np.clip(((self._x - x) * dx + (self._y - y) * dy) / max(length, 1e-9) ** 2, 0.0, 1.0)
        cover = np.clip(width / 2 + 0.5 - np.hypot(self._x - x - along * dx, self._y - y - along * dy), 0.0, 1.0)
        if is_dashed:
            cover = cover * (along * length % _DASH < _DASH / 2)
        self._paint(cover, color)

    def ground(self, at: str) -> None:
        """A triangle below it."""
        import numpy as np

        x, y = self._places[at]
        down = self._y - y + 6
        self._paint(np.clip(down * 0.6 - abs(self._x - x), 0.0, 1.0) * np.clip(12 - down, 0.0, 1.0), _GROUND)

    def _paint(self, cover: "np.ndarray", color: tuple[int, int, int]) -> None:
        self.pixels += cover[:, :, None] * (color - self.pixels)


def _png(pixels: "np.ndarray") -> bytes:
    """The image file of colours between 0 and 255 (Portable Network Graphics, W3C 2003)."""
    rows = pixels.round().astype("uint8")
    height, width, _ = rows.shape
    content = zlib.compress(b"".join(b"\0" + row.tobytes() for row in rows), 9)
    header = struct.pack(">2I5B", width, height, 8, 2, 0, 0, 0)
    chunks = ((b"IHDR", header), (b"IDAT", content), (b"IEND", b""))
    return b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(text)) + kind + text + struct.pack(">I", zlib.crc32(kind + text))
                                           for kind, text in chunks)


def _places(model: Exportable, start: tuple[float, ...]) -> Mapping[str, tuple[float, float]]:
    """Positions of the first frames at the start, in m."""
    from lagrangia.compile.functions import observer

    compilation = model.compilation
    scene, graph = model.scene, compilation.kinematics.graph
    frames = list(dict.fromkeys((*(root.frame for root in graph.roots), *(edge.child for edge in graph.edges))))[:_MOST_FRAMES]
    _labels, function = observer(compilation.kinematics, compilation.motion, compilation.constraints,
                                 tuple(f"{frame}.r" for frame in frames))
    inputs = [known.value or 0.0 for known in scene.inputs]
    n = scene.n
    found = [float(x) for x in function(scene.start, start[:n], start[n:], inputs, model.parameter_values()).full().ravel()]
    return {frame: (found[2 * k], found[2 * k + 1]) for k, frame in enumerate(frames)}


def draw_graph(compilation: Compilation) -> str:
    """The component graph as SVG: frames in columns by their distance from the ground, joints in colour, loop cuts dashed."""
    graph = compilation.kinematics.graph
    depth = {root.frame: 0 for root in graph.roots}
    for edge in graph.edges:
        depth[edge.child] = depth.get(edge.parent, 0) + 1
    frames = list(depth)[:_MOST_FRAMES]
    rows: dict[int, int] = {}
    place: dict[str, tuple[int, int]] = {}
    for frame in frames:
        row = rows.get(depth[frame], 0)
        rows[depth[frame]] = row + 1
        place[frame] = (20 + _COLUMN * depth[frame], 20 + _ROW * row)
    lines = [_line(place, edge.parent, edge.child, "#1f4e79" if edge.is_rigid else "#c55a11", ", ".join(edge.coordinates))
             for edge in graph.edges]
    lines += [_line(place, closure.a, closure.b, "#7f7f7f", f"closed {closure.kind}", "4 3") for closure in graph.closures]
    texts = [f'<circle cx="{x}" cy="{y}" r="4"/><text x="{x + 7}" y="{y + 12}">{escape(name)}</text>'
             for name, (x, y) in place.items()]
    width, height = 40 + _COLUMN * (max(rows, default=0) + 1), 40 + _ROW * max(rows.values(), default=1)
    return "\n".join([f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}" height="{height}" font-family="sans-serif" '
                      'font-size="11">', *filter(None, lines), *texts, "</svg>"])


def _line(place: Mapping[str, tuple[int, int]], a: str, b: str, color: str, text: str, dashes: str = "") -> str:
    if a not in place or b not in place:
        return ""
    (x0, y0), (x1, y1) = place[a], place[b]
    style = f' stroke-dasharray="{dashes}"' if dashes else ""
    label = f'<text x="{(x0 + x1) // 2}" y="{(y0 + y1) // 2 - 3}" fill="{color}">{escape(text)}</text>' if text else ""
    return f'<line x1="{x0}" y1="{y0}" x2="{x1}" y2="{y1}" stroke="{color}"{style}/>{label}'
