"""A page as a matplotlib figure, for PNG and PDF: the same strokes as in the SVG."""

from typing import Any

from matplotlib.figure import Figure
from matplotlib.font_manager import FontProperties
from matplotlib.patches import Circle, PathPatch
from matplotlib.path import Path as Outline
from matplotlib.textpath import TextPath
from matplotlib.transforms import Affine2D

from lagrangia.draw.page import FONT, Label, Page
from lagrangia.draw.strokes import Stroke
from lagrangia.draw.svg import FILLS, LOWERED

_POINT = 25.4 / 72  # mm


def paint_page(page: Page) -> Figure:
    """As large as the page."""
    figure = Figure(figsize=(page.width / 25.4, page.height / 25.4))
    axes = figure.add_axes((0.0, 0.0, 1.0, 1.0))
    axes.set_axis_off()
    axes.set_xlim(0, page.width)
    axes.set_ylim(0, page.height)
    for order, path in enumerate(page.paths):
        _paint(axes, path, order, page.pen(path.line))
    for label in page.labels:
        _write(axes, label, len(page.paths))
    return figure


def _paint(axes: Any, path: Stroke, order: int, pen: float) -> None:
    looks = {"linewidth": pen / _POINT, "edgecolor": "black", "facecolor": FILLS[path.fill], "zorder": order,
             "linestyle": (0, (4, 3)) if path.line == "dashed" else "solid", "capstyle": "round", "joinstyle": "round"}
    if path.radius > 0:
        axes.add_patch(Circle((float(path.points[0, 0]), float(path.points[0, 1])), path.radius, **looks))
    elif len(path.points) > 1:
        axes.add_patch(PathPatch(Outline(path.points, closed=False) if not path.is_closed else Outline(
            [*path.points, path.points[0]], closed=True), **looks))


def _write(axes: Any, label: Label, order: int) -> None:
    """As outlines, so that letters with subscripts stand as in the SVG."""
    x, outlines = 0.0, []
    for text, is_italic, is_lowered in label.words.pieces:
        size = FONT * (0.7 if is_lowered else 1.0)
        font = FontProperties(family=["STIXGeneral", "DejaVu Serif"], style="italic" if is_italic else "normal")
        literal = text.replace("$", r"\$")  # or else two of them would begin and end a formula
        outline = TextPath((0, 0), literal, size=size, prop=font)
        width = TextPath((0, 0), literal + "|", size=size, prop=font).get_extents().x1 - TextPath(
            (0, 0), "|", size=size, prop=font).get_extents().x1
        outlines.append(outline.transformed(Affine2D().translate(x, -LOWERED * FONT if is_lowered else 0.0)))
        x += width
    at = Affine2D().translate(label.at[0] - x / 2, label.at[1] - 0.33 * FONT)
    for outline in outlines:
        axes.add_patch(PathPatch(outline.transformed(at), facecolor="black", edgecolor="none", zorder=order))
