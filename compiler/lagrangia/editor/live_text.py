"""A text that is being written, and its syntax tree: of a change within the statements of a class these alone are read anew.

All other nodes stay as they are; their places are moved to where they stand in the new text. So a tree is good until the next
change of its text, and who kept what an older one said sees it at its new place.
"""

import re
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import Any

from lagrangia.base.diagnostics import LagError, Source, Span
from lagrangia.base.records import dataclass
from lagrangia.language.reader import Place, Word
from lagrangia.language.syntax import _Nodes, parse
from lagrangia.language.tree import ClassDefinition, Declaration, Extends, Syntax

_NOTHING = re.compile(r"(?:\s|//[^\n]*\n|/\*.*?\*/)*", re.DOTALL)
_SAID_OF_ALL = re.compile(r"\b(?:protected|public|annotation)\b")  # also of what stands behind it, or of the whole class
_WORDS: Mapping[str, str] = {"initial": "initial equation"}  # of sections, where they are not their kinds
# What puts a place elsewhere; a frozen one is moved by nobody else.
_put_source, _put_start, _put_end = (getattr(Span, name).__set__ for name in ("source", "start", "end"))


class _Recorder(_Nodes):
    """Keeps all places that it makes, and of declarations that of the statement which makes them."""

    def __init__(self, source: Source) -> None:
        super().__init__(source)
        self.spans: list[Span] = []
        self.statements: dict[int, Span] = {}  # by the ids of the places of names

    def _span(self, meta: Place | Word) -> Span:
        made = super()._span(meta)
        self.spans.append(made)
        return made

    def declaration(self, meta: Place, children: list[Any]) -> list[Declaration]:
        """Of one statement."""
        found, whole = super().declaration(meta, children), self._span(meta)
        self.statements |= {id(made.name_span): whole for made in found}
        return found


@dataclass(frozen=True)
class _Run:
    """Statements one after the other, the elements of a class (section -1) or the clauses of a section, with their places."""

    definition: ClassDefinition
    section: int
    items: Sequence[Any]
    places: Sequence[Span]


@dataclass(frozen=True)
class _Change:
    """Of the text from `start` to `end`."""

    start: int
    end: int


class LiveText:
    """The tree of one file, as its text changes; while the text is wrong, that of the last right one is kept."""

    def __init__(self) -> None:
        self.syntax: Syntax | None = None
        self.recorder = _Recorder(Source("", ""))

    def tree(self, source: Source) -> Syntax:
        """Of the text as it is now. Raises LagError (L01xx)."""
        if self.syntax is not None and self.syntax.source.text == source.text:
            return self.syntax
        self.syntax = self._changed(self.syntax, source) or self._whole(source)
        return self.syntax

    def _whole(self, source: Source) -> Syntax:
        made: list[_Recorder] = []

        def make(source: Source) -> _Nodes:
            made.append(_Recorder(source))
            return made[-1]

        found = parse(source, make)
        self.recorder = made[-1]
        return found

    def _changed(self, old: Syntax | None, source: Source) -> Syntax | None:
        """None where more than some statements of a class have to be read."""
        if old is None:
            return None
        change = _change_of(old.source.text, source.text)
        for run in self._runs(old):
            places = run.places
            first = next((k for k, place in enumerate(places) if place.end > change.start), len(places))
            last = next((k for k, place in enumerate(places) if place.end > change.end), len(places))
            if last < len(places) and (first or change.start > places[0].start):
                while last + 1 < len(places) and places[last + 1] is places[last]:
                    last += 1
                return self._with_statements(old, run, first, last, run.places[last].end, source)
            if places and change.start >= places[-1].end and _NOTHING.fullmatch(old.source.text, places[-1].end, change.end):
                k = next(k for k, place in enumerate(places) if place is places[-1])
                return self._with_statements(old, run, k, len(places) - 1, change.end, source)
        return None

    def _runs(self, syntax: Syntax) -> list[_Run]:
        found = []
        for c in syntax.classes:
            places = [e.span if isinstance(e, Extends) else self.recorder.statements[id(e.name_span)] for e in c.elements
                      if isinstance(e, Extends) or id(e.name_span) in self.recorder.statements]
            if len(places) == len(c.elements):  # but of enumerations and short classes
                found.append(_Run(c, -1, c.elements, places))
            found += [_Run(c, k, s.clauses, [x.span for x in s.clauses]) for k, s in enumerate(c.sections)]
        return found

    def _with_statements(self, old: Syntax, run: _Run, first: int, last: int, end: int, source: Source
                         ) -> Syntax | None:
        """With others in the place of these and of what stands behind them, up to `end`. What they begin behind is the end of
        another one, or the first one's first letter, and what they end with a semicolon, or spaces and comments behind one: all
        as it was, so that words are cut there as before."""
        was, shift = old.source.text, len(source.text) - len(old.source.text)
        start = run.places[first - 1].end if first else run.places[0].start
        text, gaps, at = source.text[start : end + shift], [], start
        for place in dict.fromkeys(run.places[first : last + 1]):
            gaps.append(was[at : place.start])
            at = place.end
        if text[-1:] not in (";", " ", "\n") or not all(map(_NOTHING.fullmatch, gaps)):
            return None
        if _SAID_OF_ALL.search(text) or "annotation" in was[start:end]:
            return None
        found = self._statements(text, run)
        if found is None:
            return None
        items, recorder = found
        if run.section < 0:
            known = [x for x in run.items[max(0, first - 1) : last + 1] if isinstance(x, Declaration)]
            if not known:
                return None
            items = tuple(_hidden(x) for x in items) if "protected" in known[0].prefixes else items
        self._move(recorder, start, end, shift, source)
        made = (*run.items[:first], *items, *run.items[last + 1 :])
        sections = list(run.definition.sections)
        if run.section >= 0:
            sections[run.section] = replace(sections[run.section], clauses=made)
        definition = replace(run.definition, elements=made if run.section < 0 else run.definition.elements,
                             sections=tuple(sections))
        return replace(old, source=source, classes=tuple(definition if c is run.definition else c for c in old.classes))

    @staticmethod
    def _statements(text: str, run: _Run) -> tuple[tuple[Any, ...], _Recorder] | None:
        """What such a piece of text alone says, and where; None where it is wrong, or no such statements."""
        section = run.definition.sections[run.section] if run.section >= 0 else None
        head = f"model M Real x; {_WORDS.get(section.kind, section.kind) if section else ''} "
        made: list[_Recorder] = []

        def make(source: Source) -> _Nodes:
            made.append(_Recorder(source))
            return made[-1]

        try:
            syntax = parse(Source("", f"{head}{text}end M;"), make)
        except LagError:
            return None
        (c, *others), recorder = syntax.classes, made[-1]
        _, *elements = c.elements
        if any((others, c.classes, c.imports, c.annotation, syntax.named)) or len(c.sections) != (section is not None):
            return None
        if section is not None and elements:
            return None
        recorder.spans = [span for span in recorder.spans if span.start >= len(head) and span.end <= len(head) + len(text)]
        for span in recorder.spans:
            _put_start(span, span.start - len(head))
            _put_end(span, span.end - len(head))
        return tuple(c.sections[0].clauses if section is not None else elements), recorder

    def _move(self, new: _Recorder, start: int, end: int, shift: int, source: Source) -> None:
        """All places to where they are now; those of the statements between `start` and `end` are forgotten."""
        last = start + max(span.end for span in new.spans)  # of the last statement, with which what is around may end
        kept = [span for span in self.recorder.spans if span.start < start or span.start >= end]
        for span in kept:
            _put_source(span, source)
            if span.start >= end:
                _put_start(span, span.start + shift)
                _put_end(span, span.end + shift)
            elif span.end > start:
                _put_end(span, span.end + shift if span.end > end else last)
        for span in new.spans:
            _put_source(span, source)
            _put_start(span, span.start + start)
            _put_end(span, span.end + start)
        self.recorder.spans = kept + new.spans
        known = set(map(id, self.recorder.spans))
        self.recorder.statements = {key: place for key, place in (self.recorder.statements | new.statements).items()
                                    if id(place) in known}


def _change_of(old: str, new: str) -> _Change:
    """What is not the same at the beginning, nor at the end."""
    least = min(len(old), len(new))
    start = _most(least, lambda n: old[:n] == new[:n])
    behind = _most(least - start, lambda n: old[len(old) - n :] == new[len(new) - n :])
    return _Change(start, len(old) - behind)


def _hidden(x: Declaration | Extends) -> Declaration | Extends:
    return replace(x, prefixes=x.prefixes | {"protected"}) if isinstance(x, Declaration) else x


def _most(limit: int, holds: Any) -> int:
    """The largest n for which this holds, as it does for all smaller ones."""
    low = 0
    while low < limit:
        middle = (low + limit + 1) // 2
        low, limit = (middle, limit) if holds(middle) else (low, middle - 1)
    return low
