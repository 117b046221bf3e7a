"""Document -> text, Markdown, LaTeX, HTML."""

from collections.abc import Callable, Mapping
from html import escape

from lagrangia.paper.document import Block, Display, Document, Heading, Inline, Paragraph, Table
from lagrangia.paper.latex import latex, latex_escape
from lagrangia.paper.layout import Cases, Grid, Node, Pieces, Relation, broken
from lagrangia.paper.mathml import mathml
from lagrangia.paper.typeset import line, text

WIDTH = 100


def _lines(formula: Node, letter: str = "") -> list[Node]:
    """A formula on as many lines as it needs, with room for its letter; one with a matrix stays whole."""
    room = len(letter) + 4 if letter else 0
    return [formula] if _has_grid(formula) else broken(formula, lambda node: len(line(node)), WIDTH - 2 - room)


def _has_grid(node: Node) -> bool:
    return isinstance(node, Grid | Cases) or (isinstance(node, Relation) and (_has_grid(node.left) or _has_grid(node.right))) or \
        any(_has_grid(item) for item in getattr(node, "items", ()) if not isinstance(item, tuple | int))


# -------------------------------------------------------------------- text


def as_text(document: Document) -> str:
    """For a terminal, in Unicode."""
    parts = [f"{document.title}\n{'=' * len(document.title)}", *(_text_block(block) for block in document.blocks)]
    return "\n\n".join(part for part in parts if part)


def _text_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"{words}\n{'-' * len(words)}" if level <= 2 else f"{words}:"
        case Paragraph(parts):
            return _wrapped("".join(part if isinstance(part, str) else line(part) for part in parts))
        case Display():
            return "\n".join(_indented(formula, letter) for formula, letter in block.lettered())
        case Table(_, rows):
            return _text_table([[part if isinstance(part, str) else line(part) for part in row] for row in rows])


def _text_table(cells: list[list[str]]) -> str:
    """Columns side by side, the words of the last one wrapped."""
    widths = [max(len(row[k]) for row in cells) for k in range(len(cells[0]))] if cells else []
    before = sum(widths[:-1]) + 2 * len(widths)
    lines = []
    for row in cells:
        first, *rest = _wrapped(row[-1], max(20, WIDTH - before)).split("\n")
        lines.append("  ".join([*(cell.ljust(w) for cell, w in zip(row[:-1], widths, strict=False)), first]))
        lines += [" " * (before - 2) + words for words in rest]
    return "\n".join("  " + row.rstrip() for row in lines)


def _wrapped(words: str, width: int = WIDTH) -> str:
    lines, here = [], ""
    for word in words.split(" "):
        if here and len(here) + len(word) + 1 > width:
            lines.append(here)
            here = word
        else:
            here = f"{here} {word}" if here else word
    return "\n".join([*lines, here])


def _indented(formula: Node, letter: str) -> str:
    found = []
    for k, part in enumerate(_lines(formula, letter)):
        found += ["  " + "    " * (k > 0) + row.rstrip() for row in text(part).lines]
    if letter:
        found[-1] = found[-1].ljust(WIDTH - len(letter) - 2) + f"({letter})"
    return "\n".join(found)


# -------------------------------------------------------------------- Markdown


def as_markdown(document: Document) -> str:
    """With formulas in LaTeX between dollars, as GitHub, Jupyter and pandoc read them."""
    return "\n\n".join([f"# {_markdown_words(document.title)}", *(_markdown_block(block) for block in document.blocks)])


def _markdown_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"{'#' * max(2, level)} {_markdown_words(words)}"
        case Paragraph(parts):
            return "".join(_markdown_words(part) if isinstance(part, str) else f"${latex(part)}$" for part in parts)
        case Display():
            return "\n\n".join(f"$$\n{_aligned(_lines(formula))}{_tag(letter)}\n$$" for formula, letter in block.lettered())
        case Table(head, rows):
            def cell(part: Inline) -> str:
                return _markdown_words(part) if isinstance(part, str) else f"${latex(part)}$"

            body = ["| " + " | ".join(cell(part) for part in row) + " |" for row in rows]
            return "\n".join([f"| {' | '.join(map(_markdown_words, head))} |", "|" + " --- |" * len(head), *body])


def _markdown_words(words: str) -> str:
    return "".join(f"\\{c}" if c in "\\`*_[]<>|$" else c for c in words)


# -------------------------------------------------------------------- LaTeX


def as_latex(document: Document) -> str:
    """A document that pdflatex and lualatex read; amsmath and booktabs are all it needs."""
    body = "\n\n".join(_latex_block(block) for block in document.blocks)
    return (f"\\documentclass[11pt]{{article}}\n\\usepackage[utf8]{{inputenc}}\n\\usepackage[T1]{{fontenc}}\n"
            f"\\usepackage[a4paper,margin=22mm]{{geometry}}\n\\usepackage{{amsmath,amssymb,booktabs}}\n\\allowdisplaybreaks\n"
            f"\\setlength{{\\parindent}}{{0pt}}\\setlength{{\\parskip}}{{6pt}}\n\\title{{{latex_escape(document.title)}}}\n\\date{{}}\n"
            f"\\begin{{document}}\n\\maketitle\n\n{body}\n\n\\end{{document}}")


def _latex_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"\\{'section' if level <= 2 else 'subsection' if level == 3 else 'paragraph'}*{{{latex_escape(words)}}}"
        case Paragraph(parts):
            return "".join(_latex_inline(part) for part in parts)
        case Display():
            lines = [_aligned(_lines(formula)) + _tag(letter, is_labelled=True) for formula, letter in block.lettered()]
            body = " \\\\\n".join(lines)
            return f"\\begin{{gather*}}\n{body}\n\\end{{gather*}}"
        case Table(head, rows):
            body = " \\\\\n".join(" & ".join(_latex_inline(part) for part in row) for row in rows)
            titles = " & ".join(latex_escape(words) for words in head)
            return (f"\\begin{{center}}\n\\begin{{tabular}}{{{'l' * len(head)}}}\n\\toprule\n{titles} \\\\\n\\midrule\n"
                    f"{body} \\\\\n\\bottomrule\n\\end{{tabular}}\n\\end{{center}}")


def _latex_inline(part: Inline) -> str:
    return latex_escape(part) if isinstance(part, str) else f"${latex(part)}$"


def _tag(letter: str, is_labelled: bool = False) -> str:
    return f" \\tag{{{letter}}}" + (f"\\label{{lag:{letter}}}" if is_labelled else "") if letter else ""


def _aligned(lines: list[Node]) -> str:
    if len(lines) == 1:
        return latex(lines[0])
    body = " \\\\\n".join(("& " if k == 0 else "& \\quad ") + latex(part) for k, part in enumerate(lines))
    return f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"


# -------------------------------------------------------------------- HTML

_STYLE = """
  :root { color-scheme: light; }
  body { font: 17px/1.5 "STIX Two Text", "Latin Modern Roman", "Libertinus Serif", Cambria, Georgia, "Times New Roman", serif;
         color: #1b1b1b; max-width: 50rem; margin: 3rem auto; padding: 0 1.5rem; }
  math { font-family: "STIX Two Math", "Latin Modern Math", "Cambria Math", "Libertinus Math", "DejaVu Math TeX Gyre", math; }
  h1 { font-size: 1.7rem; margin: 0 0 .3rem; border-bottom: 2px solid #1b1b1b; padding-bottom: .3rem; font-weight: 600; }
  h2 { font-size: 1.25rem; margin: 2rem 0 .5rem; font-weight: 600; }
  h3, h4 { font-size: 1.05rem; margin: 1.3rem 0 .3rem; font-weight: 600; }
  p { margin: .6rem 0; }
  figure { margin: 1.2rem auto; text-align: center; break-inside: avoid; }
  figure svg { width: min(100%, 30rem); height: auto; }
  .formula { margin: .7rem 0 .7rem 1.6rem; overflow-x: auto; break-inside: avoid; }
  .formula .more { margin-left: 2.2rem; }
  .formula .letter { float: right; }
  .formula > div { margin: .5rem 0; }
  table.list { border-collapse: collapse; margin: .8rem 0 .8rem 1.2rem; }
  table.list td, table.list th { padding: .18rem 1.1rem .18rem 0; text-align: left; vertical-align: baseline;
                                 font-weight: normal; }
  table.list thead th { border-bottom: 1px solid #888; color: #555; font-size: .85rem; }
  table.list td code { font-size: .82rem; color: #555; }
  mtable mtd { padding: .25em .5em; }
  footer { margin-top: 3rem; color: #777; font-size: .8rem; }
  @media print { body { font-size: 11pt; margin: 0; max-width: none; padding: 0; } h2, h3, h4 { break-after: avoid; }
                 footer { display: none; } @page { margin: 20mm; } }
"""


_NAMESPACE = ' xmlns="http://www.w3.org/2000/svg"'  # which files of their own need, and HTML does not


def as_html(document: Document) -> str:
    """One file that needs no script, no font and no network: the formulas are MathML."""
    figure = f"<figure>{document.figure.replace(_NAMESPACE, '')}</figure>\n" if document.figure else ""
    body = figure + "\n".join(_html_block(block) for block in document.blocks)
    return (f'<!DOCTYPE html>\n<html lang="en">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{escape(document.title)}</title>\n'
            f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{escape(document.title)}</h1>\n{body}\n"
            "<footer>Derived by Lagrangia from the model's energies.</footer>\n</body>\n</html>")


def _html_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"<h{max(2, level)}>{escape(words)}</h{max(2, level)}>"
        case Paragraph(parts):
            return f"<p>{''.join(_html_inline(part) for part in parts)}</p>"
        case Display():
            return f'<div class="formula">{"".join(_html_formula(*pair) for pair in block.lettered())}</div>'
        case Table(head, rows):
            titles = "".join(f"<th>{escape(words)}</th>" for words in head)
            cells = ["".join(f"<td>{_html_cell(part, k)}</td>" for k, part in enumerate(row)) for row in rows]
            body = "".join(f"<tr>{row}</tr>" for row in cells)
            return f'<table class="list"><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table>'


def _html_cell(part: Inline, place: int) -> str:
    return f"<code>{escape(part)}</code>" if isinstance(part, str) and place == 1 else _html_inline(part)


def _html_inline(part: Inline) -> str:
    return escape(part) if isinstance(part, str) else f"<math>{mathml(part)}</math>"


def _html_formula(formula: Node, letter: str) -> str:
    lines = _lines(formula)
    found = []
    for k, part in enumerate(lines):
        mark = f'<span class="letter">({letter})</span>' if letter and k == len(lines) - 1 else ""
        place = f' id="{letter}"' if mark else ""
        found.append(f'<div{" class=more" if k else ""}{place}>{mark}<math displaystyle="true">{mathml(part)}</math></div>')
    return "".join(found)


PRINTERS: Mapping[str, Callable[[Document], str]] = {
    "text": as_text, "markdown": as_markdown, "latex": as_latex, "html": as_html,
}
__all__ = ["PRINTERS", "Pieces"]
