"""Errors as data: what is wrong, where, and what to do next.

Code ranges, one a phase:

    L00xx  files and the command line      L04xx  component graph, kinematics
    L01xx  syntax                          L05xx  energies and equations of motion
    L02xx  names, modifications, arrays    L06xx  values, initial conditions, the run
    L03xx  units and dimensions            L07xx  commands, outputs; L08xx  style; L09xx  not supported yet
"""

import re
from bisect import bisect_right
from collections.abc import Iterable
from dataclasses import field, replace
from functools import cached_property
from math import isfinite
from typing import Any, Literal, NoReturn

from lagrangia.base.records import dataclass
from lagrangia.base.spelling import plain_text

# The codes of warnings: those that can be allowed.
WARNINGS = ("L0224", "L0237", "L0238", "L0239", "L0305", "L0306", "L0607", "L0608", "L0609", "L0610", "L0708", "L0709", "L0740",
            "L0741", "L0742", "L0743", "L0744", "L0745", "L0746", "L0747", "L0748", "L0749", "L0801", "L0802", "L0803", "L0804",
            "L0805", "L0806")
Severity = Literal["error", "warning", "note"]
LIBRARY = "library/"  # with which the names of its sources begin
_LONGEST_LINE = 160
_LONGEST_MESSAGE = 6000  # a name in it may be any text, as those of foreign files are
_MOST_SHOWN = 20
_ELEMENT = re.compile(r"\[\d+(, ?\d+)*\]")


@dataclass(frozen=True, eq=False)
class Source:
    """A text and the name people know it by."""

    name: str
    text: str

    def line_and_column(self, offset: int) -> tuple[int, int]:
        """One-based line and column of a character offset."""
        line = bisect_right(self._line_starts, min(offset, len(self.text)))
        return line, min(offset, len(self.text)) - self._line_starts[line - 1] + 1

    @cached_property
    def _line_starts(self) -> list[int]:
        return [0, *(match.end() for match in re.finditer("\n", self.text))]


@dataclass(frozen=True, slots=True)
class Span:
    """The characters start <= i < end of a source."""

    source: Source
    start: int
    end: int

    def to(self, other: "Span") -> "Span":
        """From the start of this one to the end of another one."""
        return Span(self.source, self.start, max(self.end, other.end))

    def within(self, place: "Span") -> "Span":
        """This, where it is a part of `place`; else that: what a component says is told where it was declared."""
        is_inside = self.source is place.source and place.start <= self.start and self.end <= place.end
        return self if is_inside else place

    @property
    def text(self) -> str:
        """What stands there."""
        return self.source.text[self.start : self.end]

    def __str__(self) -> str:
        line, column = self.source.line_and_column(self.start)
        return f"{self.source.name}:{line}:{column}"

    @property
    def excerpt(self) -> str:
        """Its line, with carets under it."""
        return "\n".join(_excerpt(self, "", "", ""))


@dataclass(frozen=True)
class Diagnostic:
    """What is wrong, or doubtful, with a code, a place, a label at the place, and hints for what to do."""

    severity: Severity
    code: str
    message: str
    span: Span | None = None
    label: str = ""
    hints: tuple[str, ...] = ()
    excerpt: str = ""  # what shows the place where the text itself is no longer at hand
    interval: tuple[float, float] | None = None  # of runs, s: it holds for those that neither begin earlier nor end later

    def placed(self, place: Span, other: str = "") -> "Diagnostic":
        """The same at `place`, where it was found in a line of the library, which is then a hint; `other`: what follows it."""
        if self.span is None or not self.span.source.name.startswith(LIBRARY):
            return self
        return replace(self, span=place, label="", hints=(*self.hints, f"it is read at {self.span}: {self.span.text}{other}"))

    def render(self, color: bool = False) -> str:
        """The message, the line it is about with a caret under the text, and the hints: names of files and columns among them are
        data, and command no terminal."""
        paint = _PAINT[self.severity] if color else ""
        bold, reset = ("\033[1m", "\033[0m") if color else ("", "")
        lines = [f"{paint}{self.severity}[{self.code}]{reset}{bold}: {_shown(self.message)}{reset}"]
        if self.span is not None:
            lines += _excerpt(self.span, self.label, paint, reset)
        lines += self.excerpt.splitlines()
        lines += [f"   = {_shown(hint)}" for hint in self.hints]
        return "\n".join(lines)


class Error(Exception):
    """What Lagrangia raises: LagError for wrong input, RunError for a run that failed."""


class LagError(Error):
    """The input is wrong. `diagnostics` says how; the command line prints them and exits with 2."""

    def __init__(self, diagnostics: Iterable[Diagnostic]) -> None:
        self.diagnostics = tuple(diagnostics)
        super().__init__("\n".join(d.render() for d in self.diagnostics))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.diagnostics,)

    def placed(self, place: Span) -> "LagError":
        """The same where what was found in a line of the library is told at `place`, where people asked for it."""
        return type(self)(found.placed(place) for found in self.diagnostics)


class TooMuchError(LagError):
    """The input asks for work without bound: nothing more of it is looked at, not even for other errors."""


class RunError(Error):
    """The run failed although the input is well formed; the command line exits with 1.

    `trajectory` holds what was computed before, when the run was asked for through Model.simulate.
    """

    trajectory: Any = None


class Interrupted(KeyboardInterrupt):
    """Ctrl-C ended what Model.simulate or simulate_many did; the command line exits with 130.

    `result` holds the Trajectory, or the Sweep, of what was computed before.
    """

    result: Any = None

    @classmethod
    def with_result(cls, result: Any, when: str) -> "Interrupted":
        """What was computed, and when that ended."""
        error = cls(f"interrupted {when}")
        error.result = result
        return error


class InputWarning(UserWarning):
    """An input has no value (L0708), a table of inputs ends before the run does (L0709), a parameter is given in vain (L0747), a
    range does not meet its end (L0748), an inertia that is given is of no rigid body (L0746). `message` has the code."""


class RunWarning(UserWarning):
    """Rows are no motion of the scene, as their energy account tells: the run that `lag simulate` ends with exit code 1 for."""


class EngineWarning(UserWarning):
    """Another engine runs than a Model takes where it can."""


@dataclass
class Report:
    """Collects what a phase finds wrong, so that several errors are told together."""

    diagnostics: list[Diagnostic] = field(default_factory=list)
    _told: set[tuple[Any, ...]] = field(default_factory=set)

    def error(self, code: str, message: str, span: Span | None = None, *hints: str, label: str = "") -> None:
        """Adds one."""
        self.add([Diagnostic("error", code, message, span, label, hints)])

    def warning(self, code: str, message: str, span: Span | None = None, *hints: str,
                interval: tuple[float, float] | None = None) -> None:
        """Adds one."""
        self.add([Diagnostic("warning", code, message, span, "", hints, interval=interval)])

    def error_in(self, statement: Span, part: Span, code: str, message: str, *hints: str) -> None:
        """Adds one of a statement, with the line of the library in a hint where a part of it stands there."""
        self.add([Diagnostic("error", code, message, part if part.source.name.startswith(LIBRARY) else statement, "", hints
                             ).placed(statement)])

    def in_order(self) -> "Report":
        """The same by the places in each text."""
        texts = {name: k for k, name in enumerate(dict.fromkeys(d.span.source.name for d in self.diagnostics if d.span))}
        return Report(sorted(self.diagnostics, key=lambda d: (texts[d.span.source.name], d.span.start) if d.span else (-1, 0)))

    def add(self, found: Iterable[Diagnostic]) -> None:
        """Each is told once, of the first element, however many elements of an array the same text is wrong for."""
        for diagnostic in found:
            what = [diagnostic.message, diagnostic.label, *diagnostic.hints]
            if diagnostic.span is not None:
                what = [_ELEMENT.sub("[]", text) for text in what]
            if (key := (diagnostic.severity, diagnostic.code, diagnostic.span, *what)) not in self._told:
                self._told.add(key)
                self.diagnostics.append(diagnostic)

    @property
    def errors(self) -> list[Diagnostic]:
        """Those that are no warnings."""
        return [d for d in self.diagnostics if d.severity == "error"]

    def raise_errors(self) -> None:
        """Raises LagError with all errors, if there are any."""
        if self.errors:
            raise LagError(self.errors)


def fail(code: str, message: str, span: Span | None = None, *hints: str, label: str = "") -> NoReturn:
    """Raise a LagError with one diagnostic."""
    raise LagError([Diagnostic("error", code, message, span, label, hints)])


def tell_miss(gap: float, unit: str) -> str:
    """By how much an equation fails to hold."""
    nowhere = "it has no finite value, or no finite slope, wherever it was looked for"
    return f"it misses by {abs(gap):.3g} ({unit})" if isfinite(gap) else nowhere


def nearest(word: str, known: Iterable[str]) -> str | None:
    """The known word that differs in capitals only, else the most similar one."""
    import difflib

    names = sorted(set(known))
    near = [name for name in names if name.lower() == word.lower()] or difflib.get_close_matches(word, names, n=1, cutoff=0.6)
    return near[0] if near else None


def suggest(word: str, known: Iterable[str]) -> str:
    """`did you mean 'k'?` for the nearest known word, or a list of the known ones when it is short."""
    names = sorted(set(known))
    if near := nearest(word, names):
        return f"did you mean '{near}'?"
    return f"known here: {', '.join(names)}" if 0 < len(names) <= 12 else ""


def render_all(diagnostics: Iterable[Diagnostic], color: bool = False) -> str:
    """All diagnostics under each other, at most a screenful."""
    found = list(diagnostics)
    shown = [d.render(color) for d in found[:_MOST_SHOWN]]
    if len(found) > _MOST_SHOWN:
        shown.append(f"... and {len(found) - _MOST_SHOWN} more")
    return "\n\n".join(shown)


_PAINT = {"error": "\033[1;31m", "warning": "\033[1;33m", "note": "\033[1;36m"}


def _shown(text: str) -> str:
    """As a terminal may have it, without the middle of what is longer than people read."""
    if len(text) > _LONGEST_MESSAGE:
        text = f"{text[: _LONGEST_MESSAGE // 2]} [...] {text[-_LONGEST_MESSAGE // 2 :]}"
    return plain_text(text)


def _excerpt(span: Span, label: str, paint: str, reset: str) -> list[str]:
    """The source line with carets; of a very long line only the part around the caret."""
    line, column = span.source.line_and_column(span.start)
    begin = span.start - (column - 1)
    stop = span.source.text.find("\n", begin)
    text = span.source.text[begin : stop if stop >= 0 else None].rstrip("\r")
    width = max(1, min(span.end, begin + len(text)) - span.start)
    if len(text) > _LONGEST_LINE:
        first = max(0, column - 1 - _LONGEST_LINE // 2)
        text, column = text[first : first + _LONGEST_LINE], column - first
        width = min(width, _LONGEST_LINE - column + 1)
    text = "".join(c if c.isprintable() else " " for c in text)
    margin = " " * len(str(line))
    caret = f"{paint}{'^' * width}{' ' + label if label else ''}{reset}"
    return [f"{margin}--> {plain_text(str(span))}", f"{margin} |", f"{line} | {text}", f"{margin} | {' ' * (column - 1)}{caret}"]
