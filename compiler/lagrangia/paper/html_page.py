"""Document -> one HTML file: MathML, no script, nothing from elsewhere; prints on A4 with nothing cut."""

from html import escape

from lagrangia.paper.document import Block, Display, Document, Heading, Inline, Paragraph, Table, words_of
from lagrangia.paper.latex import latex
from lagrangia.paper.latex_page import aligned
from lagrangia.paper.layout import Node, broken
from lagrangia.paper.mathml import mathml
from lagrangia.paper.phrases import translated
from lagrangia.paper.widths import typeset_width

_LINE = 68.0  # half ems of a line: less than on paper, as fonts that browsers find are wider, DejaVu Math by an eighth

_STYLE = """
  :root { color-scheme: light dark; --ink: #1b1b1b; --paper: #fff; --faint: #666; --line: #999; }
  @media (prefers-color-scheme: dark) { :root { --ink: #e4e4e4; --paper: #16181b; --faint: #a0a0a0; --line: #777; } }
  body { font: 17px/1.5 "STIX Two Text", "Latin Modern Roman", "Libertinus Serif", Cambria, Georgia, "Times New Roman", serif;
         color: var(--ink); background: var(--paper); max-width: 50rem; margin: 3rem auto; padding: 0 1.5rem; }
  math { font-family: "STIX Two Math", "Latin Modern Math", "Cambria Math", "Libertinus Math", "DejaVu Math TeX Gyre", math; }
  h1 { font-size: 1.7rem; margin: 0 0 .3rem; border-bottom: 2px solid var(--ink); padding-bottom: .3rem; font-weight: 600; }
  h2 { font-size: 1.25rem; margin: 2rem 0 .5rem; font-weight: 600; }
  h3, h4 { font-size: 1.05rem; margin: 1.3rem 0 .3rem; font-weight: 600; }
  p { margin: .6rem 0; }
  figure { margin: 1.2rem auto; text-align: center; break-inside: avoid; }
  figure svg { width: min(100%, 30rem); height: auto; max-height: 24rem; background: #fff; color: #000; border-radius: 4px; }
  .formula { margin: .7rem 0 .7rem 1.6rem; }
  .formula > div { display: flex; align-items: baseline; gap: 1rem; margin: .05rem 0; break-inside: avoid; }
  .formula math { text-align: left; margin: 0; }
  .formula .shown { overflow: auto hidden; padding-block: .35rem; min-width: 0; }
  .formula .more { margin-left: 2.2rem; }
  .formula .letter { margin-left: auto; }
  .formula details { font: 12px/1.4 ui-monospace, monospace; color: var(--faint); margin-left: auto; text-align: right; }
  .formula .letter + details { margin-left: 0; }
  .formula summary { list-style: none; cursor: pointer; opacity: .35; }
  .formula summary:hover, .formula summary:focus, .formula details[open] summary { opacity: 1; }
  .formula details code { user-select: all; display: block; text-align: left; max-width: 26rem; white-space: pre-wrap;
                          overflow-wrap: anywhere; }
  table.list { border-collapse: collapse; margin: .8rem 0 .8rem 1.2rem; }
  table.list tr { break-inside: avoid; }
  table.list td, table.list th { padding: .18rem 1.1rem .18rem 0; text-align: left; vertical-align: baseline;
                                 font-weight: normal; }
  table.list thead th { border-bottom: 1px solid var(--line); color: var(--faint); font-size: .85rem; }
  table.list td code { font-size: .82rem; color: var(--faint); overflow-wrap: anywhere; }
  mtable mtd { padding: .25em .5em; }
  footer { margin-top: 3rem; color: var(--faint); font-size: .8rem; }
  @media print {
    :root { color-scheme: light; --ink: #000; --paper: #fff; --faint: #444; --line: #888; }
    body { font-size: 11pt; margin: 0; max-width: none; padding: 0; }
    h2, h3, h4 { break-after: avoid; }
    p:has(+ .formula), p:has(+ table) { break-after: avoid; }
    p { orphans: 2; widows: 2; }
    .formula { margin-left: 1rem; }
    .formula .shown { overflow: visible; }
    .formula details, footer { display: none; }
    @page { size: A4; margin: 20mm; }
  }
"""


_FOOTER = "Derived by Lagrangia from the model's energies."
_NAMESPACE = ' xmlns="http://www.w3.org/2000/svg"'  # which files of their own need, and HTML does not


def as_html(document: Document) -> str:
    """One file that needs no script, no font and no network: the formulas are MathML."""
    title = escape(words_of(document.title))
    figure = f"<figure>{document.figure.replace(_NAMESPACE, '')}</figure>\n" if document.figure else ""
    body = figure + "\n".join(_html_block(block) for block in document.blocks)
    return (f'<!DOCTYPE html>\n<html lang="{document.language}">\n<head>\n<meta charset="utf-8">\n'
            f'<meta name="viewport" content="width=device-width, initial-scale=1">\n<title>{title}</title>\n'
            f"<style>{_STYLE}</style>\n</head>\n<body>\n<h1>{title}</h1>\n{body}\n"
            f"<footer>{escape(translated(_FOOTER, document.language))}</footer>\n</body>\n</html>")


def _html_block(block: Block) -> str:
    match block:
        case Heading(words, level):
            return f"<h{max(2, level)}>{escape(words_of(words))}</h{max(2, level)}>"
        case Paragraph(parts):
            return f"<p>{''.join(_html_inline(part) for part in parts)}</p>"
        case Display():
            return f'<div class="formula">{"".join(_html_formula(*pair) for pair in block.lettered())}</div>'
        case Table(head, rows):
            titles = "".join(f"<th>{escape(words_of(words))}</th>" for words in head)
            cells = ["".join(f"<td>{_html_cell(part, k)}</td>" for k, part in enumerate(row)) for row in rows]
            body = "".join(f"<tr>{row}</tr>" for row in cells)
            return f'<table class="list"><thead><tr>{titles}</tr></thead><tbody>{body}</tbody></table>'


def _html_cell(part: Inline, place: int) -> str:
    return f"<code>{escape(part)}</code>" if isinstance(part, str) and place == 1 else _html_inline(part)


def _html_inline(part: Inline) -> str:
    return escape(part) if isinstance(part, str) else _math(part, "inline")


def _html_formula(formula: Node, letter: str) -> str:
    """A formula on its lines, with its letter and its LaTeX, which a click selects."""
    lines = broken(formula, typeset_width, _LINE)
    source = escape(aligned(lines))
    found = []
    for k, part in enumerate(lines):
        is_last = k == len(lines) - 1
        mark = f'<span class="letter">({letter})</span>' if letter and is_last else ""
        place = f' id="{letter}"' if mark else ""
        note = f"<details><summary>TeX</summary><code>{source}</code></details>" if is_last else ""
        shown = f'<span class="shown">{_math(part, "block")}</span>'
        found.append(f'<div{" class=more" if k else ""}{place}>{shown}{mark}{note}</div>')
    return "".join(found)


def _math(node: Node, display: str) -> str:
    """With LaTeX as its annotation, for who copies it."""
    note = f'<annotation encoding="application/x-tex">{escape(latex(node))}</annotation>'
    return f'<math display="{display}"><semantics>{mathml(node)}{note}</semantics></math>'
