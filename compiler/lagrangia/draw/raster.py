"""Strokes of a page -> grey pixels, for films and icons: a library for figures would take longer than all else of these."""

import numpy as np
from PIL import Image, ImageDraw

from lagrangia.draw.page import LINES, Page
from lagrangia.draw.strokes import Stroke

_FINER = 3  # pixels that become one, along a side
_GREYS = {"white": 255, "grey": 200, "black": 0}
_DASH = (1.2, 0.8)  # mm: drawn, and left out


def rasterise(page: Page, scale: float, width: float = 1.0, size: tuple[int, int] | None = None) -> Image.Image:
    """At `scale` pixels a mm, lines so many times as wide as on paper; of a `size`, in the middle of it, if one is given."""
    own = max(2, round(page.width * scale)), max(2, round(page.height * scale))
    columns, rows = size or own
    image = Image.new("L", (_FINER * columns, _FINER * rows), 255)
    shift = _FINER * np.array([(columns - page.width * scale) / 2, (rows - page.height * scale) / 2])
    canvas = _Canvas(ImageDraw.Draw(image), _FINER * scale, width * page.weight, shift, page.height)
    for path in page.paths:
        canvas.paint(path)
    return image.reduce(_FINER)


class _Canvas:
    """`scale`: pixels a mm; y upwards in mm, downwards in pixels."""

    def __init__(self, draw: ImageDraw.ImageDraw, scale: float, width: float, shift: "np.ndarray", height: float) -> None:
        self.draw, self.scale, self.width, self.shift, self.height = draw, scale, width, shift, height

    def paint(self, path: Stroke) -> None:
        points = (path.points * (1, -1) + (0, self.height)) * self.scale + self.shift
        wide = max(1, round(LINES[path.line] * self.width * self.scale))
        fill = _GREYS.get(path.fill)
        if path.radius > 0:
            (x, y), r = points[0], path.radius * self.scale + wide / 2
            self.draw.ellipse((x - r, y - r, x + r, y + r), fill=fill, outline=0, width=wide)
            return
        if fill is not None and len(points) > 2:
            self.draw.polygon([tuple(p) for p in points], fill=fill)
        line = np.concatenate([points, points[:1]]) if path.is_closed else points
        for part in _dashes(line, [d * self.scale for d in _DASH]) if path.line == "dashed" else [line]:
            self._line(part, wide)

    def _line(self, points: "np.ndarray", wide: int) -> None:
        self.draw.line([tuple(p) for p in points], fill=0, width=wide)
        if wide > 2:  # round joints and ends
            r = (wide - 1) / 2
            for x, y in points:
                self.draw.ellipse((x - r, y - r, x + r, y + r), fill=0)


def _dashes(points: "np.ndarray", lengths: list[float]) -> list["np.ndarray"]:
    """The pieces of a line that are drawn."""
    gone = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    begin = 0.0
    found: list[np.ndarray] = []
    while begin < gone[-1] and len(found) < 5000:
        end = min(begin + lengths[0], float(gone[-1]))
        inner = gone[(gone > begin) & (gone < end)]
        at = np.concatenate([[begin], inner, [end]])
        found.append(np.stack([np.interp(at, gone, points[:, k]) for k in range(2)], axis=1))
        begin += sum(lengths)
    return found
