"""Syntax trees as plain data and back: lists, tuples, numbers and texts, which unlike a pickle can run nothing.

A node is a list: the number of its class, then its fields; a source stands once, and nodes say its number. The classes of a file
are bytes each, so that those alone are made that a scene names.
"""

import marshal
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import fields
from typing import Any

from lagrangia.base.diagnostics import Source, Span
from lagrangia.language import tree
from lagrangia.language.tree import ClassDefinition, Syntax

_CLASSES = [Span, *sorted((c for c in vars(tree).values() if isinstance(c, type) and "__dataclass_fields__" in vars(c)
                           and c.__module__ == tree.__name__), key=lambda c: c.__name__)]
_NUMBERS = {node: k for k, node in enumerate(_CLASSES)}
_OF_FILES = tuple(field.name for field in fields(Syntax))


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

    def file_of(file: Syntax) -> Any:
        classes = tuple(["class", c.name, c.kind, marshal.dumps(plain(c))] for c in file.classes)
        return [_NUMBERS[Syntax], *(classes if name == "classes" else plain(getattr(file, name)) for name in _OF_FILES)]

    return marshal.dumps(([(source.name, source.text) for source in sources], tuple(map(file_of, files))))


def read_trees(content: bytes) -> tuple[Syntax, ...]:
    """Raises ValueError, EOFError or TypeError for what is none."""
    named, files = marshal.loads(content)
    found: tuple[Syntax, ...] = _reader([Source(name, text) for name, text in named])(files)
    return found


class PlainClasses(Mapping[str, ClassDefinition]):
    """The classes of files by their names, each made when it is asked for; the files define none twice."""

    def __init__(self, content: bytes) -> None:
        """Raises ValueError, EOFError or TypeError for what is none."""
        named, files = marshal.loads(content)
        self.sources = tuple(Source(name, text) for name, text in named)
        classes = [found for file in files for found in file[1 + _OF_FILES.index("classes")]]
        self._plain = {name: body for _, name, _, body in classes}
        self.kinds = {name: kind for _, name, kind, _ in classes}
        self._made: dict[str, ClassDefinition] = {}
        self._read = _reader(self.sources)

    def __getitem__(self, name: str) -> ClassDefinition:
        found = self._made.get(name)
        return found if found is not None else self._made.setdefault(name, self._read(marshal.loads(self._plain[name])))

    def __iter__(self) -> Iterator[str]:
        return iter(self._plain)

    def __len__(self) -> int:
        return len(self._plain)


def _reader(sources: Sequence[Source]) -> Callable[[Any], Any]:
    makers: list[Callable[..., Any]] = list(_CLASSES)

    def tree_of(node: Any) -> Any:
        if type(node) is list:
            if node[0] == 0:
                return Span(sources[node[1][1]], node[2], node[3])
            if node[0] == "source":
                return sources[node[1]]
            if node[0] == "class":
                return tree_of(marshal.loads(node[3]))
            return makers[node[0]](*map(tree_of, node[1:]))
        return tuple(map(tree_of, node)) if type(node) is tuple else node

    return tree_of
