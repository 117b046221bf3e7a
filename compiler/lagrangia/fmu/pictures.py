"""Pictures of a scene for its FMU: its schematic at the start as an icon, and the component graph."""

import io
from collections.abc import Mapping, Sequence
from dataclasses import replace
from html import escape

import numpy as np

from lagrangia.base.records import dataclass
from lagrangia.compile.pipeline import Compilation
from lagrangia.draw.drawing import figures_of
from lagrangia.draw.drive_train import icon_of_train
from lagrangia.draw.page import LINES
from lagrangia.draw.raster import rasterise
from lagrangia.draw.strokes import Stroke
from lagrangia.draw.svg import write_svg
from lagrangia.draw.values import States
from lagrangia.fmu.exportable import Exportable
from lagrangia.fmu.states import state_columns
from lagrangia.language.flat import Figure
from lagrangia.run.input_pieces import held_at_first
from lagrangia.solids.showing import icon_of

_PIXELS, _MARGIN, _LINE = 128, 2, 1.5  # of the icon, at its borders, and of a line
_MOST_FRAMES, _MOST_FIGURES = 400, 400  # shown in a picture
_COLUMN, _ROW = 170, 34
_BOX = np.array([[1.0, 1.0], [6.0, 1.0], [6.0, 6.0], [1.0, 6.0]])  # mm, on the smallest page


@dataclass(frozen=True)
class Icon:
    """The same picture in both formats that importers show."""

    png: bytes
    svg: bytes


def draw_icon(model: Exportable, start: Sequence[float]) -> Icon:
    """The schematic, without names, for which an icon has no room: 128 x 128 pixels, and as lines."""
    scene = model.scene
    parameters = model.parameter_values()
    told, turned = dict(zip((c.name for c in state_columns(scene)), start, strict=True)), scene.notes.get("attitudes", {})
    q = [told.get(c.name, 0.0) for c in scene.coordinates]  # attitudes are not turned against themselves
    kept = [*(told[f"{name}[{k}]"] for name in turned for k in range(1, 5)), *held_at_first(scene, list(map(float, parameters)))]
    columns = ([scene.start], q, start[-scene.n :] if scene.n else (), [*(known.value or 0.0 for known in scene.inputs), *kept],
               parameters)
    states = States(*(np.array(column, dtype=float).reshape(-1, 1) for column in columns))
    page = icon_of(model.compilation, _told_apart(figures_of(model)), states)
    if not page.paths:  # a drive train; or a scene of energies alone, whose components have no drawing: a box, as of any block
        page = icon_of_train(model.compilation.flat) or replace(page, paths=(Stroke(_BOX, 0, "normal", "none", True),))
    scale = (_PIXELS - 2 * _MARGIN) / max(page.width, page.height)
    image = rasterise(page, scale, _LINE / (LINES["normal"] * scale), (_PIXELS, _PIXELS))
    png = io.BytesIO()
    image.convert("RGB").save(png, format="PNG", optimize=True)
    return Icon(png.getvalue(), write_svg(page).encode())


def _told_apart(figures: Sequence[Figure]) -> Sequence[Figure]:
    """Of many those of every so-manieth component: more would not be seen in an icon."""
    if len(figures) <= _MOST_FIGURES:
        return figures
    components = list(dict.fromkeys(figure.component for figure in figures))
    kept = set(components[:: 1 + len(figures) // _MOST_FIGURES])
    return [figure for figure in figures if figure.component in kept]


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
