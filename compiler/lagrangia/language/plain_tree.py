"""Syntax trees as plain data and back: lists, tuples, numbers and texts, which unlike a pickle can run nothing.

A node is a list: the number of its class, then its fields; a source stands once, and nodes say its number.
"""

import marshal
from collections.abc import Callable, Sequence
from dataclasses import fields
from typing import Any

from lagrangia.base.diagnostics import Source, Span
from lagrangia.language import tree
from lagrangia.language.tree import Syntax

_CLASSES = [Span, *sorted((c for c in vars(tree).values() if isinstance(c, type) and "__dataclass_fields__" in vars(c)
                           and c.__module__ == tree.__name__), key=lambda c: c.__name__)]
_NUMBERS = {node: k for k, node in enumerate(_CLASSES)}


def write_trees(files: Sequence[Syntax]) -> bytes:
    """Files of syntax as bytes that marshal reads back."""
    sources = [file.source for file in files]
    places = {id(source): k for k, source in enumerate(sources)}
    named = [tuple(field.name for field in fields(node)) for node in _CLASSES]

    def plain(node: Any) -> Any:
        if isinstance(node, tuple):
            return tuple(plain(item) for item in node)
        if isinstance(node, Source):
            return ["source", places[id(node)]]
        number = _NUMBERS.get(type(node))
        return node if number is None else [number, *(plain(getattr(node, name)) for name in named[number])]

    return marshal.dumps(([(source.name, source.text) for source in sources], plain(tuple(files))))


def read_trees(content: bytes) -> tuple[Syntax, ...]:
    """Raises ValueError, EOFError or TypeError for what is none."""
    named, files = marshal.loads(content)
    sources = [Source(name, text) for name, text in named]
    makers: list[Callable[..., Any]] = list(_CLASSES)

    def tree_of(node: Any) -> Any:
        if type(node) is list:
            if node[0] == 0:
                return Span(sources[node[1][1]], node[2], node[3])
            if node[0] == "source":
                return sources[node[1]]
            return makers[node[0]](*map(tree_of, node[1:]))
        return tuple(map(tree_of, node)) if type(node) is tuple else node

    found: tuple[Syntax, ...] = tree_of(files)
    return found
