"""Document -> LaTeX: a document, or a fragment for one's own."""

from collections.abc import Sequence

from lagrangia.paper.document import Block, Display, Document, Heading, Inline, Paragraph, Table, words_of
from lagrangia.paper.latex import latex, latex_escape
from lagrangia.paper.layout import Node, broken
from lagrangia.paper.widths import typeset_width

_LINE = 78.0  # half ems of a line, of the 86 that a page of A4 has between margins of 22 mm at 11 pt: letters stand beside
_ROOM, _COLUMN_GAP, _LEAST_COLUMN, _LETTER = 82.0, 2.2, 12.0, 1.06  # of tables, half ems
_MOST_ROWS = 30  # of a table on a page, some of several lines
_HEADINGS = {1: "section", 2: "section", 3: "subsection"}


def typeset_lines(formula: Node) -> list[Node]:
    """A formula on as many lines as it needs on a page of A4."""
    return broken(formula, typeset_width, _LINE)


def as_latex(document: Document) -> str:
    """A document that pdflatex and lualatex read; amsmath is all it needs, and tikz where it has a figure."""
    figure = f"\\begin{{center}}\n{document.figure.strip()}\n\\end{{center}}\n\n" if document.figure else ""
    package = "\\usepackage{tikz}\n" if document.figure else ""
    return (f"\\documentclass[11pt]{{article}}\n\\usepackage[utf8]{{inputenc}}\n\\usepackage[T1]{{fontenc}}\n"
            f"\\usepackage[a4paper,margin=22mm]{{geometry}}\n\\usepackage{{amsmath}}\n{package}\\allowdisplaybreaks\n"
            f"\\setlength{{\\parindent}}{{0pt}}\\setlength{{\\parskip}}{{6pt}}\\sloppy\n\\title{{{latex_escape(words_of(document.title))}}}\n\\date{{}}\n"
            f"\\begin{{document}}\n\\maketitle\n\n{figure}{as_fragment(document)}\n\n\\end{{document}}")


def as_fragment(document: Document) -> str:
    """What stands in a document of one's own that loads amsmath: formulas have labels lag:a, lag:b, ..."""
    return "\n\n".join(_block(block) for block in document.blocks)


def _block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"\\{_HEADINGS.get(level, 'paragraph')}*{{{latex_escape(words_of(words))}}}"
        case Paragraph(parts):
            return "".join(_inline(part) for part in parts)
        case Display():
            lines = [aligned(typeset_lines(formula)) + tag(letter, is_labelled=True) for formula, letter in block.lettered()]
            body = " \\\\\n".join(lines)
            return f"\\begin{{gather*}}\n{body}\n\\end{{gather*}}"
        case Table(head, rows):
            return _table(head, rows)


def _inline(part: Inline) -> str:
    return latex_escape(part) if isinstance(part, str) else f"${latex(part)}$"


def tag(letter: str, is_labelled: bool = False) -> str:
    """What puts the letter beside a formula."""
    return f" \\tag{{{letter}}}" + (f"\\label{{lag:{letter}}}" if is_labelled else "") if letter else ""


def aligned(lines: list[Node]) -> str:
    """Lines of a formula, those after the first moved in."""
    if len(lines) == 1:
        return latex(lines[0])
    body = " \\\\\n".join(("& " if k == 0 else "& \\quad ") + latex(part) for k, part in enumerate(lines))
    return f"\\begin{{aligned}}\n{body}\n\\end{{aligned}}"


def _table(head: Sequence[Inline], rows: Sequence[Sequence[Inline]]) -> str:
    """Words of the last column are wrapped in the room that is left; a long table stands in parts that fit on a page."""
    taken = sum(max(map(_width, column)) + _COLUMN_GAP for column in list(zip(head, *rows, strict=True))[:-1])
    last = max(_LEAST_COLUMN, _ROOM - taken) / 2
    titles = " & ".join(latex_escape(words_of(words)) for words in head)
    parts = []
    for first in range(0, len(rows), _MOST_ROWS):
        body = " \\\\\n".join(" & ".join(_inline(part) for part in row) for row in rows[first : first + _MOST_ROWS])
        columns = f"{'l' * (len(head) - 1)}p{{{last:.1f}em}}"
        parts.append(f"\\begin{{center}}\n\\begin{{tabular}}{{{columns}}}\n{titles} \\\\\n\\hline\n{body}\n\\end{{tabular}}\n"
                     "\\end{center}")
    return "\n\n".join(parts)


def _width(cell: Inline) -> float:
    return _LETTER * len(cell) if isinstance(cell, str) else typeset_width(cell)
