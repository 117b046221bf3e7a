"""A page as TikZ, for LaTeX: a tikzpicture in millimetres, whose labels are set in the document's own font."""

from lagrangia.draw.page import Label, Page
from lagrangia.draw.strokes import Stroke
from lagrangia.draw.svg import millimetres
from lagrangia.paper.latex import latex, latex_escape
from lagrangia.paper.layout import Name
from lagrangia.paper.notation import GREEK

_GREYS = {"none": "", "white": "fill=white", "grey": "fill=black!22", "black": "fill=black"}


def write_tikz(page: Page) -> str:
    """The text of a file for \\input; the document loads the package tikz."""
    head = [f"% {line}" for line in page.title.splitlines()]
    begin = (f"\\begin{{tikzpicture}}[x=1mm, y=1mm, line width={millimetres(page.pen('normal'))}mm, "
             "line cap=round, line join=round, "
             "every node/.style={inner sep=0, font=\\small}]")
    bounds = f"\\useasboundingbox (0,0) rectangle ({millimetres(page.width)},{millimetres(page.height)});"
    paths = [_path(path, page) for path in page.paths]
    return "\n".join([*head, begin, bounds, *paths, *map(_label, page.labels), "\\end{tikzpicture}"]) + "\n"


def _path(path: Stroke, page: Page) -> str:
    pen = page.pen(path.line)
    looks = [f"line width={millimetres(pen)}mm"] if pen != page.pen("normal") else []
    looks += ["dash pattern=on 1.2mm off 0.8mm"] if path.line == "dashed" else []
    looks += [_GREYS[path.fill]] if path.fill != "none" else []
    options = f"[{', '.join(looks)}] " if looks else " "
    points = [f"({millimetres(x)},{millimetres(y)})" for x, y in path.points]
    if path.radius > 0:
        return f"\\draw{options}{points[0]} circle[radius={millimetres(path.radius)}];"
    return f"\\draw{options}{' -- '.join(points)}{' -- cycle' if path.is_closed else ''};"


def _label(label: Label) -> str:
    x, y = label.at
    words, low = "", False
    for text, is_italic, is_lowered in label.words.pieces:
        words += "_{" if is_lowered and not low else "}" if low and not is_lowered else ""
        is_word = len(text) > 1 and text.isascii() and text.isalpha()
        letters = "".join(map(_letter, text))
        words += f"\\mathrm{{{letters}}}" if is_word or not (is_italic or is_lowered) else letters
        low = is_lowered
    return f"\\node at ({millimetres(x)},{millimetres(y)}) {{${words}{'}' if low else ''}$}};"


def _letter(c: str) -> str:
    if c in GREEK:
        return f"{latex(Name(GREEK[c]))} "
    return c if c.isascii() and (c.isalnum() or c in "(),+-=") else f"\\text{{{latex_escape(c)}}}" if c != " " else "\\ "
