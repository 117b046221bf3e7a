"""Changes of a text that are asked for: what a hint of a diagnostic says, another name for something."""

import re
from collections.abc import Iterable, Iterator

from lagrangia.base.diagnostics import LIBRARY, Diagnostic, Span, fail
from lagrangia.base.records import dataclass
from lagrangia.editor.meanings import Index, Occurrence
from lagrangia.language.syntax import RESERVED
from lagrangia.language.tree import ClassDefinition

_MEANT = re.compile(r"^did you mean '([^']+)'")
_WRITE = re.compile(r"^write: end ([^\W\d]\w*);$")
_NAME = re.compile(r"[^\W\d]\w*")


@dataclass(frozen=True)
class Change:
    """A text in place of what stands at a place."""

    span: Span
    text: str


def fixes(diagnostic: Diagnostic) -> Iterator[tuple[str, Change]]:
    """What the hints of a diagnostic propose, with words for it."""
    if diagnostic.span is None:
        return
    for hint in diagnostic.hints:
        for meant in (_MEANT.search(hint), _WRITE.search(hint)):
            if meant is not None and (place := _place(diagnostic)) is not None:
                yield f"write '{meant[1]}'", Change(place, meant[1])
    if diagnostic.message == "a ';' is missing":
        end = diagnostic.span.end
        yield "write ';'", Change(Span(diagnostic.span.source, end, end), ";")


def _place(diagnostic: Diagnostic) -> Span | None:
    """Of the wrong name: the place itself, or where the name that the message quotes stands in it."""
    span = diagnostic.span
    assert span is not None
    if _NAME.fullmatch(span.text):
        return span
    for quoted in re.findall(r"'([^']+)'", diagnostic.message):
        name = quoted.rpartition(".")[2]
        if len(found := list(re.finditer(rf"\b{re.escape(name)}\b", span.text))) == 1:
            return Span(span.source, span.start + found[0].start(), span.start + found[0].end())
    return None


def same(index: Index, key: tuple[str, int]) -> list[Occurrence]:
    """Where what has this key is named in a file."""
    return [found for found in index.occurrences if found.meaning.key == key]


def renamed(found: Occurrence, name: str, files: Iterable[Index]) -> list[Change]:
    """In all these files. Raises LagError (L0108, L0202, L0901) where that cannot be."""
    meaning = found.meaning
    if meaning.place.source.name.startswith(LIBRARY):
        fail("L0901", f"'{meaning.name}' is of the library, which is not changed here", found.span)
    if not _NAME.fullmatch(name) or name in RESERVED:
        fail("L0108", f"'{name}' cannot be a name", found.span)
    changes = []
    for index in files:
        places = same(index, meaning.key)
        for place in places:
            taken = index.table.user if isinstance(meaning.node, ClassDefinition) else index.members(place.owner)
            if name in taken and name != meaning.name:
                fail("L0202", f"there is a '{name}' already", taken[name].name_span)
        changes += [Change(place.span, name) for place in places]
    return changes
