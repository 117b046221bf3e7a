"""Text that does not parse -> where parsing stops. After each stop it goes on where a statement, a section or a class begins.

Better too few stops than a wrong one: what may be a consequence of an earlier stop is passed over.
"""

import re
from collections.abc import Iterator
from dataclasses import field
from itertools import pairwise, product

from lagrangia.base.diagnostics import Source, Span
from lagrangia.base.records import dataclass
from lagrangia.language.functions import CALLED
from lagrangia.language.reader import END, Tables, Word
from lagrangia.language.word_parser import UnexpectedError, WordParser

_MOST_TOLD = 10
_MOST_STOPS = 100  # with those that are passed over
_BLOCKS = ("for", "if", "when")
_CLOSERS = (")", "]", "}")
_SECTIONS = {"VISIBILITY": "public", "EQUATION": "equation", "ALGORITHM": "algorithm", "__ANON_0": "energy", "DRAWING": "drawing"}
# What the text is made of, as far as it says where a statement ends: words, texts and comments as a whole.
_LANDMARKS = re.compile(
    r"""(?P<skipped>//[^\n]* | /\*.*?\*/ | "(?:[^"\\\n]|\\[^\n])*" | '(?:[^'\\\n]|\\[^\n])+' | \.\s*\w+) | (?P<comment>/\*)
    | (?P<quote>") | (?P<header>\b(?:partial[ \t]+)?(?:model|function|type|record|package)[ \t]+[^\W\d]\w*)
    | (?P<end>\bend[ \t]+(?!(?:for|if|when)\b)(?P<name>[^\W\d]\w*)) | (?P<inner>\bend\b) | (?P<branch>\belse(?:if)?\b)
    | (?P<section>\b(?:initial(?:\s+equation)?|equation|algorithm|energy|drawing|public|protected)\b)
    | (?P<open>[(\[{]) | (?P<close>[)\]}]) | (?P<semicolon>;) | \w+""", re.DOTALL | re.VERBOSE)
_CLASS_WORDS = ("CLASS_KIND", "PARTIAL")
_STRUCTURE = ("header", "end", "inner", "section")
_NO_STATEMENT = (*_STRUCTURE, "branch")


@dataclass(frozen=True)
class Stop:
    """Where parsing stopped: the text that did not fit, the tokens before it, and the terminals that would have fitted."""

    source: Source
    span: Span
    before: tuple[Word, ...]
    accepted: frozenset[str]

    @property
    def word(self) -> str:
        """The word at which the parser stopped."""
        return self.span.text

    @property
    def is_first_of_line(self) -> bool:
        """Whether nothing stands before it in its line."""
        begin = self.source.text.rfind("\n", 0, self.span.start) + 1
        return bool(self.before) and self.before[-1].end_pos <= begin

    @property
    def lacks_semicolon(self) -> bool:
        """Whether the line before it wants a semicolon."""
        return "SEMICOLON" in self.accepted and self.is_first_of_line and self.word not in ("", *_CLOSERS)

    def last(self, count: int) -> tuple[str, ...]:
        """Types of the tokens just before."""
        return tuple(token.type for token in self.before[-count:])


def find_stops(source: Source, tables: Tables) -> Iterator[Stop]:
    """The first place where the parser refuses the text, and those after it that are wrong for themselves."""
    reading = _Reading(source, WordParser(tables, source.text))
    told = 0
    for _ in range(_MOST_STOPS):
        stop = reading.read()
        if stop is None:
            return
        moved = reading.fitting_section(stop)
        if told == 0 or not reading.is_consequence(stop, moved):
            yield stop
            told += 1
            reading.is_faulty = True
        if told == _MOST_TOLD or not reading.go_on(stop, moved):
            return


@dataclass(frozen=True, eq=False)
class _Mark:
    """The parser where a statement may begin, and how many tokens it has read."""

    parser: WordParser
    count: int


@dataclass(frozen=True)
class _Landing:
    """A place of the text to go on from, and what stands there."""

    kind: str
    position: int


@dataclass
class _Reading:
    """The parser on its way through a text, and the marks it can go back to."""

    source: Source
    parser: WordParser
    before: list[Word] = field(default_factory=list)
    start: int = 0  # of the statement
    resumed: int = -1  # where it went on after the last stop
    line: int = 0  # the last one that was skipped
    is_faulty: bool = False  # a stop was told in this class
    is_torn: bool = False  # a class was left open
    is_strange: bool = False  # no word of the language was there

    def __post_init__(self) -> None:
        self.file = self.body = self.here = _Mark(self.parser.copy(), 0)

    # -------------------------------------------------------------------- reading

    def read(self) -> Stop | None:
        """Reads until a token does not fit, or the file ends too early."""
        start = end = len(self.source.text)
        is_strange = False
        try:
            for token in self.parser.words():
                if self.is_faulty and token in _BLOCKS and self.before[-1].type == "END":
                    start, end = token.start_pos, token.end_pos
                    break  # the block's beginning was skipped; it is no class that is called so
                if self.is_faulty and token.type in _CLASS_WORDS and not self._is_indented(token) and self.body is not self.file:
                    self._land(_Landing("header", token.start_pos))  # no class in the one that is wrong
                    return self.read()
                self.parser.take(token)
                self.before.append(token)
                self._set_mark(token)
        except UnexpectedError as error:
            start, end, is_strange = error.start, error.end, error.is_strange
        self.is_strange = is_strange or self.source.text.startswith("/*", start)
        accepted = self.parser.accepted()
        if start == end and END in accepted:
            return None
        return Stop(self.source, Span(self.source, start, end), tuple(self.before), accepted)

    def _set_mark(self, token: Word) -> None:
        """Where `end` fits, a statement may begin; where the file may end, a class."""
        fitting = self.parser.row
        if "END" not in fitting and END not in fitting:
            if token.type == "EQUAL" and self.here is self.body and len(self.before) == self.here.count + 1:
                self.here = self.body = self.file  # type Name = ...; has no body
            return
        is_in_file = END in fitting
        was_in_file = self.here is self.file
        self.here = _Mark(self.parser.copy(), len(self.before))
        self.start = token.end_pos
        if is_in_file:
            self.file, self.is_faulty = self.here, False
        if is_in_file or was_in_file:
            self.body = self.here

    def _is_indented(self, token: Word) -> bool:
        return self.source.text[max(0, token.start_pos - 1) : token.start_pos] not in ("", "\n")

    # -------------------------------------------------------------------- judging

    @property
    def is_nested(self) -> bool:
        """Whether classes stand in others: which of their ends was lost is not known."""
        return any(token.type == "CLASS_KIND" and self._is_indented(token) and before.type != "PARTIAL"
                   for before, token in pairwise(self.before))

    def is_consequence(self, stop: Stop, moved: "_Reading | None") -> bool:
        """Whether an earlier stop may be the reason of this one."""
        if stop.word == "" and self.is_nested:
            return True
        is_beginning = len(self.before) < self.here.count + 2
        line, _ = self.source.line_and_column(stop.span.start)
        if line <= self.line or (is_beginning and self.start == self.resumed):
            return True
        if self.here is self.file:
            return self.is_torn or self.is_nested
        return self.is_faulty and (stop.word == "" or moved is not None or self._first_landmark(stop) in _NO_STATEMENT)

    def _first_landmark(self, stop: Stop) -> str:
        """What the statement that does not parse begins with."""
        tokens = self.before[self.here.count :]
        begin = tokens[0].start_pos if tokens else stop.span.start
        landmark = _LANDMARKS.match(self.source.text, begin)
        return landmark.lastgroup or "" if landmark else ""

    def fitting_section(self, stop: Stop) -> "_Reading | None":
        """The statement read in another section, where it parses there: it is not what is wrong."""
        if self.here is self.file or self.is_strange or self._first_landmark(stop) in _NO_STATEMENT:
            return None
        if self.before[self.here.count :][:1] and self.before[self.here.count] in CALLED:
            return None  # der x = 2; declares no x
        for mark, kind in product(dict.fromkeys((self.here, self.body)), _SECTIONS):
            trial = _Reading(self.source, mark.parser.copy(), self.before[: mark.count])
            trial.parser.position = self.start
            try:
                trial.parser.take(Word(kind, _SECTIONS[kind], self.start, self.start))
                for token in trial.parser.words():
                    trial.parser.take(token)
                    trial.before.append(token)
                    if token.type == "SEMICOLON":
                        return trial
            except UnexpectedError:
                continue
        return None

    # -------------------------------------------------------------------- going on

    def go_on(self, stop: Stop, moved: "_Reading | None") -> bool:
        """Goes to where reading can go on; False where there is no such place."""
        if stop.lacks_semicolon and stop.span.start != self.resumed and self._first_landmark(stop) != "header":
            semicolon = Word("SEMICOLON", ";", self.before[-1].start_pos, self.before[-1].end_pos)
            self.parser.take(semicolon)
            self._set_mark(semicolon)
            self._resume(self.parser, stop.span.start)
            return True
        if moved is not None:
            last = moved.before[-1]
            self.before = moved.before
            self._resume(moved.parser, last.end_pos)
            self._set_mark(last)
            return True
        landing = self._landing_in_file() if self.here is self.file else self._landing_in_class(stop.span.start)
        if landing is None:
            return False
        self._land(landing)
        return True

    def _resume(self, parser: WordParser, position: int) -> None:
        self.parser = parser
        parser.position = position
        self.start = self.resumed = position

    def _land(self, landing: _Landing) -> None:
        if landing.kind == "header":
            self.is_torn |= self.here is not self.file
            self.is_faulty = False
            self.here = self.body = self.file
        elif landing.kind in ("end", "section"):
            self.here = self.body
        del self.before[self.here.count :]
        self.line, _ = self.source.line_and_column(landing.position - 1)
        self._resume(self.here.parser.copy(), landing.position)

    def _landing_in_class(self, stopped: int) -> _Landing | None:
        """Behind the statement, or at the end, the section or the class that begins before."""
        depth, name = 0, self.before[self.body.count - 1]
        behind: _Landing | None = None
        for landmark in _LANDMARKS.finditer(self.source.text, self.start):
            kind = landmark.lastgroup or ""
            depth += (kind == "open") - (kind == "close")
            if kind == "end" and landmark["name"] != name:
                kind = "inner"
            if kind == "comment":
                return behind
            if kind == "quote":  # nobody knows where the text ends, but its class does there
                ends = re.compile(rf"\bend[ \t]+{re.escape(name)}\b").search(self.source.text, landmark.end())
                return behind or (_Landing("end", ends.start()) if ends else None)
            if kind in _STRUCTURE and landmark.start() != self.resumed:
                return behind or _Landing(kind, landmark.start())
            if depth < 0:
                behind = None  # a stray ';' in brackets: the statement goes on
            if kind == "semicolon" and landmark.start() >= stopped:
                if behind or depth <= 0:
                    return behind or _Landing(kind, landmark.end())
                behind, depth = _Landing(kind, landmark.end()), 0
        return behind

    def _landing_in_file(self) -> _Landing | None:
        """Behind the end of the class whose beginning is wrong, or at the next class."""
        is_ended = False
        for landmark in _LANDMARKS.finditer(self.source.text, self.start):
            kind = landmark.lastgroup or ""
            if kind in ("comment", "quote"):
                return None
            if kind == "header" and landmark.start() != self.resumed:
                return _Landing(kind, landmark.start())
            is_ended |= kind == "end"
            if is_ended and kind == "semicolon":
                return _Landing(kind, landmark.end())
        return None
