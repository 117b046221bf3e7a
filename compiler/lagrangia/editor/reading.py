"""A text as it is being written -> what is wrong with it, and what its names mean: of a broken one, of what is left of it."""

import re
from collections.abc import Callable
from functools import cached_property
from pathlib import Path

from lagrangia.base.diagnostics import Diagnostic, LagError, Report, Source, Span
from lagrangia.base.memory import without_collections
from lagrangia.compile.elsewhere import faults_beside
from lagrangia.compile.packages import Packages
from lagrangia.compile.pipeline import deep_recursion, flatten_files, read_files
from lagrangia.editor.live_text import LiveText
from lagrangia.editor.meanings import Index, members
from lagrangia.editor.surroundings import statement_start, without_texts
from lagrangia.language.classes import ClassTable, build_class_table
from lagrangia.language.component_library import library_classes
from lagrangia.language.dimensions import check_dimensions
from lagrangia.language.flat import FlatModel
from lagrangia.language.kept_components import KeptScene
from lagrangia.language.reader import Word
from lagrangia.language.syntax import _Nodes, parse
from lagrangia.language.tree import ClassDefinition, Syntax

Read = Callable[[Path], Source]
_LACKS_A_VALUE = "L0211"
_ENDS_EARLY = "L0105"
_OPENING = re.compile(r"^[ \t]*(?:\w+[ \t]+)*?(?:model|function|record|package|connector|block|class)[ \t]+(?:extends\s+)?"
                      r"[^\W\d]\w*\b(?!\s*=)", re.MULTILINE)
_CLOSING = re.compile(r"\bend\s+(?!if\b|for\b|when\b|while\b)[^\W\d]\w*\s*;")
_MOST_MENDED = 8  # statements that are left out


class Reading:
    """What a text says; `flat` is None while its last model is wrong. `is_part` where that is one for others, with parameters or
    ports that are open."""

    def __init__(self, source: Source, diagnostics: tuple[Diagnostic, ...], flat: FlatModel | None,
                 find: Callable[[], Index | None], is_part: bool = False) -> None:
        self.source, self.diagnostics, self.flat, self._find, self.is_part = source, diagnostics, flat, find, is_part

    @cached_property
    def index(self) -> Index | None:
        """What its names mean; None while nothing of it can be read."""
        with deep_recursion(), without_collections():
            return self._find()


class Known:
    """What is kept of texts from one reading to the next: their trees, and what was made of the model of each."""

    def __init__(self) -> None:
        self.texts: dict[str, LiveText] = {}
        self.components: dict[str, KeptScene] = {}

    def tree(self, source: Source) -> Syntax:
        """Of a text as it is now; that of its last one is good no longer. Raises LagError."""
        return self.texts.setdefault(source.name, LiveText()).tree(source)

    def forget(self, name: str) -> None:
        """A text that nobody writes any more."""
        self.texts.pop(name, None)
        self.components.pop(name, None)


def read_text(path: Path, read: Read, known: Known | None = None) -> Reading:
    """Of a file and all that it imports, as `read` gives them: errors and warnings of syntax, names and units. With what is
    `known` of the last reading it takes less time."""
    with deep_recursion(), without_collections():
        source = read(path)
        report = Report()
        flat = None
        try:
            syntax, imported = read_files(path, read, known.tree if known is not None else parse)
            source = syntax.source
            table = build_class_table(library_classes(), [syntax, *imported], Packages(syntax).find)
        except LagError as error:
            return Reading(source, error.diagnostics, None, lambda: _index_of_mended(path, source, read))
        last = next((c for c in reversed(syntax.classes) if c.kind == "model" and not c.is_partial), None)
        kept = known.components.setdefault(source.name, KeptScene()) if known is not None else None
        is_part = last is None or _is_part(last, table)
        try:
            if last is not None:
                flat = check_dimensions(flatten_files(syntax, imported, kept=kept))
                report.add(flat.warnings)
        except LagError as error:
            report.add(found for found in error.diagnostics if not (is_part and found.code == _LACKS_A_VALUE and _is_open(found)))
        told = {diagnostic.render() for diagnostic in report.diagnostics}
        try:
            beside = faults_beside(table, syntax)
        except LagError as error:  # as of imports, by which nothing in the file is known
            beside = list(error.diagnostics)
        report.add(found for found in beside if found.render() not in told)
        return Reading(source, tuple(report.diagnostics), flat, lambda: Index(syntax, table), is_part)


def _is_part(last: ClassDefinition, table: ClassTable) -> bool:
    """Whether a model leaves something to who uses it."""
    is_run = any(argument.name == "experiment" for argument in last.annotation)
    return not is_run and any(d.binding is None and ("parameter" in d.prefixes or d.type_name == "Frame")
                              for d in members(table, last).values())


def _is_open(found: Diagnostic) -> bool:
    """Whether the value that lacks is the model's own, and not one of its components'."""
    return "needs a value" not in found.message


class _AnyEnd(_Nodes):
    """Of a class that ends by another name, as where an inner one lacks its end."""

    def _check_end(self, name: Word, end_name: Word) -> None:
        pass


def _tolerant(source: Source) -> Syntax:
    return parse(source, _AnyEnd)


def _index_of_mended(path: Path, source: Source, read: Read) -> Index | None:
    """Of a text with errors: with the ends that lack, and without the statements that hold them."""
    text, is_ended = source.text, False
    for _ in range(_MOST_MENDED):
        try:
            syntax, imported = read_files(path, _in_place(path, Source(source.name, text), read), _tolerant)
            return Index(syntax, build_class_table(library_classes(), [syntax, *imported], Packages(syntax).find))
        except LagError as error:
            here = [d for d in error.diagnostics if d.span is not None and d.span.source.name == source.name]
            lacks_end = not is_ended and any(d.code == _ENDS_EARLY for d in here)
            is_ended |= lacks_end
            other = text + _ends(text) if lacks_end else without_statements(text, [d.span for d in here if d.span is not None])
            if other == text:
                break
            text = other
    try:
        syntax = _tolerant(Source(source.name, text))  # it may be what it imports that is wrong
        return Index(syntax, build_class_table(library_classes(), [syntax]))
    except LagError:
        return None


def _ends(text: str) -> str:
    """What closes the classes that are open where a text ends."""
    plain = without_texts(text)
    return "\nend it;" * max(0, len(_OPENING.findall(plain)) - len(_CLOSING.findall(plain)))


def _in_place(path: Path, source: Source, read: Read) -> Read:
    return lambda other: source if other == path else read(other)


def without_statements(text: str, places: list[Span]) -> str:
    """With spaces in place of the statements around these places, so that all others stand where they stood."""
    for place in places:
        start, end = statement_around(text, place.start)
        text = text[:start] + "".join(c if c == "\n" else " " for c in text[start:end]) + text[end:]
    return text


def statement_around(text: str, offset: int) -> tuple[int, int]:
    """From behind what ends the statement before a place, to the end of the line or statement there, or of the class."""
    ends = [end for end in (text.find("\n", offset), text.find(";", offset) + 1) if end > 0]
    start, end = statement_start(without_texts(text[:offset])), min(ends, default=len(text))
    closing = _CLOSING.search(text, start, end)  # where brackets are open, an `end` is read as what stands in them
    return start, closing.start() if closing is not None else end
