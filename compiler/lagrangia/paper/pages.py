"""Document -> text, Markdown; and the table of all printers."""

import re
from collections.abc import Callable, Iterator, Mapping

from lagrangia.paper.document import Block, Display, Document, Heading, Inline, Paragraph, Table, words_of
from lagrangia.paper.html_page import as_html
from lagrangia.paper.latex import latex
from lagrangia.paper.latex_page import aligned, as_latex, tag, typeset_lines
from lagrangia.paper.layout import Name, Node, Pieces, broken
from lagrangia.paper.typeset import line, text

WIDTH = 100
_TAG = re.compile("<(?=[A-Za-z/!?])")


def _lines(formula: Node, letter: str = "") -> list[Node]:
    """A formula on as many lines as it needs, with room for its letter."""
    room = len(letter) + 4 if letter else 0
    return broken(formula, lambda node: len(line(node)), WIDTH - 2 - room)


# -------------------------------------------------------------------- text


def as_text(document: Document) -> str:
    """For a terminal, in Unicode."""
    title = words_of(document.title)
    parts = [f"{title}\n{'=' * len(title)}", *(_text_block(block) for block in document.blocks)]
    return "\n\n".join(part for part in parts if part)


def _text_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"{words}\n{'-' * len(words_of(words))}" if level <= 2 else f"{words}:"
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
    return "\n\n".join([f"# {_markdown_words(words_of(document.title))}", *(_markdown_block(block) for block in document.blocks)])


def _markdown_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"{'#' * max(2, level)} {_markdown_words(words_of(words))}"
        case Paragraph(parts):
            return "".join(map(_markdown_inline, parts))
        case Display():
            return "\n\n".join(f"$$\n{_no_tags(aligned(typeset_lines(formula)))}{tag(letter)}\n$$"
                               for formula, letter in block.lettered())
        case Table(head, rows):
            body = ["| " + " | ".join(map(_markdown_cell, row)) + " |" for row in rows]
            titles = " | ".join(_markdown_words(words_of(words)) for words in head)
            return "\n".join([f"| {titles} |", "|" + " --- |" * len(head), *body])


def _markdown_inline(part: Inline) -> str:
    return _markdown_words(part) if isinstance(part, str) else f"${_no_tags(latex(part))}$"


def _markdown_cell(part: Inline) -> str:
    """No stroke of a formula ends a cell."""
    found = _markdown_inline(part)
    return found if isinstance(part, str) else found.replace(r"\|", r"\Vert ").replace("|", r"\vert ")


def _no_tags(formula: str) -> str:
    """Readers of Markdown that know no formulas take what looks like a tag of HTML for one."""
    return _TAG.sub(r"\\lt ", formula)


def _markdown_words(words: str) -> str:
    return "".join(f"\\{c}" if c in "\\`*_[]<>|$" else c for c in words)


class Page(str):
    """A printed page: its text. Notebooks show the formulas typeset."""

    document: Document | None = None  # what was printed; scripts have none
    idle: tuple[str, ...] = ()  # letters of the page that were named and stand nowhere on it
    warnings: tuple[str, ...] = ()  # of the model, but those that it allows: what it says in vain
    files: tuple[str, ...] = ()  # tables that the model reads

    def _repr_markdown_(self) -> str:
        return as_markdown(self.document) if self.document is not None else f"```python\n{self}\n```"


def names_in(x: object) -> Iterator[Name]:
    """All names in the formulas of a document, or of a part of one."""
    if isinstance(x, Name):
        yield x
    elif isinstance(x, tuple):
        for part in x:
            yield from names_in(part)
    elif not isinstance(x, str) and hasattr(x, "__match_args__"):
        for member in x.__match_args__:
            yield from names_in(getattr(x, member))


def printed(printer: Callable[[Document], str], document: Document) -> Page:
    """The page that a printer makes of a document."""
    page = Page(printer(document))
    page.document = document
    return page


PRINTERS: Mapping[str, Callable[[Document], str]] = {
    "text": as_text, "markdown": as_markdown, "latex": as_latex, "html": as_html,
}
__all__ = ["PRINTERS", "Pieces"]
