"""A page as SVG: plain text, which any browser and any writer of papers reads."""

from html import escape

from lagrangia.draw.page import FONT, Label, Page
from lagrangia.draw.strokes import Stroke

FILLS = {"none": "none", "white": "#fff", "grey": "#c8c8c8", "black": "#000"}
FAMILY = "'STIX Two Text','Times New Roman',Times,serif"
LOWERED = 0.28  # of the font: how far a subscript is set below


def write_svg(page: Page) -> str:
    """The whole file."""
    width, height = millimetres(page.width), millimetres(page.height)
    head = (f'<svg xmlns="http://www.w3.org/2000/svg" width="{width}mm" height="{height}mm" viewBox="0 0 {width} {height}" '
            f'fill="none" stroke="#000" stroke-width="{millimetres(page.pen("normal"))}" '
            'stroke-linecap="round" stroke-linejoin="round">')
    title = [f"<title>{escape(page.title)}</title>"] if page.title else []
    paths = [_path(path, page) for path in page.paths]
    labels = [_label(label, page.height) for label in page.labels]
    words = [f'<g fill="#000" stroke="none" font-family="{FAMILY}" font-size="{FONT}" text-anchor="middle">', *labels, "</g>"]
    return "\n".join([head, *title, *paths, *(words if labels else []), "</svg>"]) + "\n"


def _path(path: Stroke, page: Page) -> str:
    height, pen = page.height, page.pen(path.line)
    looks = f' stroke-width="{millimetres(pen)}"' if pen != page.pen("normal") else ""
    looks += ' stroke-dasharray="1.2 0.8"' if path.line == "dashed" else ""
    looks += f' fill="{FILLS[path.fill]}"' if path.fill != "none" else ""
    if path.radius > 0:
        x, y = path.points[0]
        return f'<circle cx="{millimetres(x)}" cy="{millimetres(height - y)}" r="{millimetres(path.radius)}"{looks}/>'
    points = " ".join(f"{millimetres(x)},{millimetres(height - y)}" for x, y in path.points)
    return f'<{"polygon" if path.is_closed else "polyline"} points="{points}"{looks}/>'


def _label(label: Label, height: float) -> str:
    x, y = label.at
    pieces, low = [], False
    for text, is_italic, is_lowered in label.words.pieces:
        shift = "" if is_lowered == low else f' dy="{millimetres((1 if is_lowered else -1) * LOWERED * FONT)}"'
        looks = (' font-style="italic"' if is_italic else "") + (f' font-size="{millimetres(0.7 * FONT)}"' if is_lowered else "")
        pieces.append(f"<tspan{shift}{looks}>{escape(text)}</tspan>")
        low = is_lowered
    return f'<text x="{millimetres(x)}" y="{millimetres(height - y + 0.33 * FONT)}">{"".join(pieces)}</text>'


def millimetres(x: float) -> str:
    """A length on the page, to a thousandth."""
    text = f"{x:.3f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text
