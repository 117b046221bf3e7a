"""Colours of texts by Pygments, for Sphinx, MkDocs and minted. Its entry point is in pyproject.toml; nothing else imports it."""

from typing import ClassVar

from pygments.lexer import RegexLexer, bygroups, words
from pygments.token import Comment, Keyword, Name, Number, Operator, Punctuation, String, Whitespace

from lagrangia.language.classes import BUILTIN_TYPES
from lagrangia.language.functions import FRAME_FUNCTIONS, FUNCTIONS
from lagrangia.language.syntax import tables

_WORDS = tables().words  # of the grammar, by what they may be
_CONSTANTS = ("true", "false")
_DECLARED = ("PREFIX", "ARGUMENT_PREFIX", "PARTIAL", "CLASS_KIND", "VISIBILITY", "SCOPE")
_DECLARING = tuple(sorted(word for word, kinds in _WORDS.items() if {kind for kind, _ in kinds} & set(_DECLARED)))
_OPERATORS = ("and", "or", "not")
_OTHERS = tuple(sorted({*_WORDS} - {*_DECLARING, *_CONSTANTS, *_OPERATORS}))


class LagrangiaLexer(RegexLexer):  # type: ignore[misc]  # Pygments has no types
    """Words are those of the grammar; a unit behind a number has a colour of its own."""

    name = "Lagrangia"
    aliases: ClassVar[list[str]] = ["lagrangia", "lag"]
    filenames: ClassVar[list[str]] = ["*.lag"]
    tokens: ClassVar[dict[str, list[object]]] = {
        "root": [
            (r"\s+", Whitespace),
            (r"//[^\n]*", Comment.Single),
            (r"/\*[^*]*(?:\*(?!/)[^*]*)*\*/", Comment.Multiline),
            (r'"(?:[^"\\]|\\.)*"', String.Double),
            (r"'(?:[^'\\\n]|\\.)+'", Name),
            (r"(end)(\s+)(for|if|when|while)\b", bygroups(Keyword, Whitespace, Keyword)),
            (r"(end)(\s+)([^\W\d]\w*)", bygroups(Keyword, Whitespace, Name.Class)),
            (r"(model|function|type|record|package|block|connector|class)(\s+)([^\W\d]\w*)",
             bygroups(Keyword.Declaration, Whitespace, Name.Class)),
            (words(_CONSTANTS, suffix=r"\b"), Keyword.Constant),
            (words(_OPERATORS, suffix=r"\b"), Operator.Word),
            (words(_DECLARING, suffix=r"\b"), Keyword.Declaration),
            (words(_OTHERS, suffix=r"\b"), Keyword),
            (words(sorted(BUILTIN_TYPES), suffix=r"\b"), Keyword.Type),
            (r"(?:" + "|".join(sorted((*FUNCTIONS, *FRAME_FUNCTIONS), reverse=True)) + r")(?=\s*\()", Name.Builtin),
            (r"(?:time|world|pi)\b", Name.Builtin.Pseudo),
            (r"((?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?)([ \t]*)(\[[^\[\]\n{}();]*\])",
             bygroups(Number, Whitespace, Number.Other)),
            (r"(?:\d+(?:\.\d*)?|\.\d+)(?:[eE][+-]?\d+)?", Number),
            (r"[^\W\d]\w*", Name),
            (r":=|==|<>|<=|>=|\.[*/^+-]|[-+*/^=<>:]", Operator),
            (r"[\[\](){};,.]", Punctuation),
        ],
    }
