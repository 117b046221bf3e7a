"""Pictures of a scene for its FMU: an icon of the mechanism at its start, and the component graph."""

import io
from collections.abc import Mapping
from xml.sax.saxutils import escape

from lagrangia.compile.pipeline import Compilation
from lagrangia.fmu.variables import Exportable

_PIXELS, _DPI = 128, 64
_MOST_FRAMES = 400  # shown in a picture
_COLUMN, _ROW = 170, 34


def draw_icon(model: Exportable, start: tuple[float, ...]) -> bytes:
    """A PNG of 128 x 128: rigid connections between frames as lines, joints as dots, the ground hatched."""
    from matplotlib.figure import Figure

    graph = model.compilation.kinematics.graph
    places = _places(model, start)
    figure = Figure(figsize=(_PIXELS / _DPI, _PIXELS / _DPI), dpi=_DPI)
    axis = figure.add_axes((0.02, 0.02, 0.96, 0.96))
    for edge in graph.edges:
        if edge.parent in places and edge.child in places:
            (x0, y0), (x1, y1) = places[edge.parent], places[edge.child]
            if edge.is_rigid:
                axis.plot([x0, x1], [y0, y1], color="#1f4e79", linewidth=3, solid_capstyle="round", zorder=2)
            else:
                axis.plot([x0, x1], [y0, y1], color="#c55a11", linewidth=1.2, linestyle=":", marker="o", markersize=4, zorder=3)
    x, y = places.get("world", (0.0, 0.0))
    axis.plot([x], [y], marker="^", color="#595959", markersize=9, zorder=1)
    axis.set_aspect("equal", adjustable="datalim")
    axis.margins(0.15)
    axis.set_axis_off()
    buffer = io.BytesIO()
    figure.savefig(buffer, format="png", dpi=_DPI, metadata={"Software": None})
    return buffer.getvalue()


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
