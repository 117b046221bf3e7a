"""A text in the one layout of the language: indents, spaces, ends of lines. Words and comments stay, in their order."""

from lagrangia.base.diagnostics import Source
from lagrangia.base.memory import without_collections
from lagrangia.editor.alignment import align_names, align_values, comment_spaces
from lagrangia.editor.layout import lines_of, prepare
from lagrangia.editor.statements import statements_of
from lagrangia.editor.words import pieces_of, same_words


def formatted(source: Source) -> str:
    """The same words and comments, laid out. Raises LagError (L01xx) for a text with errors of syntax."""
    with without_collections():
        return _formatted(source)


def _formatted(source: Source) -> str:
    laid = [prepare(statement) for statement in statements_of(pieces_of(source))]
    align_names(laid)
    bodies = [lines_of(one) for one in laid]
    align_values(laid, bodies)
    rows: list[str] = []
    for one, body, spaces in zip(laid, bodies, comment_spaces(laid, bodies), strict=True):
        if one.statement.is_apart:
            rows.append("")
        rows += body
        if one.statement.trailing:
            rows[-1] += " " * spaces + " ".join(comment.text for comment in one.statement.trailing)
    text = "".join(f"{row}\n" for row in rows)
    assert same_words(source.text, text), f"{source.name} would not be the same"
    return text
