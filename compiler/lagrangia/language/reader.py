"""Text -> what an actor makes of it, by tables of an LALR(1) parser (Aho, Sethi, Ullman, Compilers, 1986, section 4.7).

The tables are those that Lark makes of the grammar (grammar_tables.py), as plain data. Lark itself is not needed to read a text:
loading it, and the patterns of its many lexers, takes ten times as long as reading a scene does.
"""

import re
from collections.abc import Mapping, Sequence
from functools import cached_property
from typing import Any, Protocol

from lagrangia.base.records import dataclass

END = "$END"


class Word(str):
    """A terminal's text, with its name and where it stands."""

    type: str
    start_pos: int
    end_pos: int

    def __new__(cls, kind: str, text: str, start: int, end: int) -> "Word":
        word = super().__new__(cls, text)
        word.type, word.start_pos, word.end_pos = kind, start, end
        return word


@dataclass(frozen=True, slots=True)
class Place:
    """Where a node begins and ends; 0 and 0 where it has no text at all."""

    start_pos: int = 0
    end_pos: int = 0


NOWHERE = Place()


class Actor(Protocol):
    """Has a method for each rule that makes something: of its place and the children."""


class NotReadError(Exception):
    """The text is wrong."""


# A rule: what it is of, how many symbols it has, the actor's method or None where its children are those of the rule above,
# whether a single child stands for it, the children kept (place, whether its own children are meant, how many absent ones come
# before), and how many absent ones come at the end.
Rule = tuple[str, int, str | None, bool, Sequence[tuple[int, bool, int]], int]


@dataclass(frozen=True)
class Tables:
    """`rows`: by symbol the next state, or -1 - rule; `row_of` the row of each state; `words`: by their text the terminals that
    they may be, each with what has to follow ("" for anything), of which the first counts that a state accepts; `patterns`
    of the other terminals, in the order in which they are tried, and of what is ignored; `plain`: the texts of those of one."""

    start: int
    end: int
    row_of: Sequence[int]
    rows: Sequence[Mapping[str, int]]
    rules: Sequence[Rule]
    words: Mapping[str, Sequence[tuple[str, str]]]
    patterns: Sequence[tuple[str, str]]
    plain: Mapping[str, str]

    @cached_property
    def pattern(self) -> str:
        """Matches one word, named by its terminal, or NAME."""
        return "|".join(f"(?P<{name}>{pattern})" for name, pattern in self.patterns)

    @cached_property
    def match(self) -> Any:
        """Matches a word at a place of a text."""
        return re.compile(self.pattern).match

    @cached_property
    def of_states(self) -> Sequence[Mapping[str, int]]:
        """The row of each state."""
        return [self.rows[number] for number in self.row_of]

    @cached_property
    def passes(self) -> Sequence[bool]:
        """Of each rule, whether it hands on its only symbol as it is."""
        return [method is not None and is_alone and size == 1 and list(map(tuple, kept)) == [(0, False, 0)] and not absent
                for _, size, method, is_alone, kept, absent in self.rules]

    def meant(self, word: str, row: Mapping[str, int], text: str, end: int) -> str | None:
        """The terminal that a word, which ends there, is in a state; None for a name."""
        for other, following in self.words.get(word, ()):
            if other in row and (not following or re.compile(following).match(text, end)):
                return other
        return None

    def terminal(self, found: re.Match[str], row: Mapping[str, int]) -> tuple[str, int]:
        """Which one of those that a word may be is meant in a state, and where it ends there. It may be one that does not fit."""
        kind, end = str(found.lastgroup), found.end()
        if kind == "NAME":
            kind = self.meant(found.group(), row, found.string, end) or kind
        if kind in row:
            return kind, end
        for other, pattern in self.patterns:  # one that is tried later, and may be shorter
            if other in row and (shorter := re.compile(pattern).match(found.string, found.start())):
                return other, shorter.end()
        return kind, end

    @cached_property
    def finditer(self) -> Any:
        """All words of a text, and what is ignored between them."""
        return re.compile(self.pattern).finditer


def read(text: str, tables: Tables, actor: Actor) -> Any:
    """What the actor makes of the whole. Raises NotReadError."""
    stack = _Stack(tables, actor)
    at, size = 0, len(text)
    while at < size:
        found = tables.match(text, at)
        if found is None:
            raise NotReadError
        end = found.end()
        if found.lastgroup != "ignored":
            kind, end = tables.terminal(found, tables.of_states[stack.states[-1]])
            stack.take(kind, Word, text[at:end], at, end)
        at = end
    return stack.finish()


class _Stack:
    """States of the parser, and for each the value made and the text it takes up (start, end), None where that is none."""

    def __init__(self, tables: Tables, actor: Actor) -> None:
        self.tables, self.actor = tables, actor
        self.states = [tables.start]
        self.values: list[Any] = []
        self.spans: list[tuple[int, int] | None] = []

    def take(self, kind: str, make: type[Word], word: str, start: int, end: int) -> None:
        """Raises NotReadError where it cannot stand here."""
        rows, states = self.tables.of_states, self.states
        while True:
            action = rows[states[-1]].get(kind)
            if action is None:
                raise NotReadError
            if action >= 0:
                break
            self.reduce(-1 - action)
        states.append(action)
        self.values.append(make(kind, word, start, end))
        self.spans.append((start, end))

    def finish(self) -> Any:
        """At the end of the text."""
        tables, states = self.tables, self.states
        while states[-1] != tables.end:
            action = tables.of_states[states[-1]].get(END)
            if action is None or action >= 0:
                raise NotReadError
            self.reduce(-1 - action)
        return self.values[-1]

    def reduce(self, number: int) -> None:
        """The symbols of a rule become what it is of."""
        tables, states = self.tables, self.states
        name, size, method, stands_alone, kept, absent = tables.rules[number]
        if tables.passes[number]:  # as a third of all do
            states.pop()
            states.append(tables.of_states[states[-1]][name])
            return
        values: list[Any] = []
        spans: list[tuple[int, int]] = []
        if size:
            values, spans = self.values[-size:], [span for span in self.spans[-size:] if span is not None]
            del self.values[-size:], self.spans[-size:], states[-size:]
        span = (spans[0][0], spans[-1][1]) if spans else None
        children: list[Any] = []
        for place, is_open, before in kept:
            children.extend([None] * before)
            if is_open and not children:
                children = values[place]  # it was the stack's alone: a repetition grows by one, and is not copied
            elif is_open:
                children.extend(values[place])
            else:
                children.append(values[place])
        children.extend([None] * absent)
        if method is None:
            made: Any = children
        elif stands_alone and len(children) == 1:
            made = children[0]
        else:
            made = getattr(self.actor, method)(Place(*span) if span else NOWHERE, children)
        self.values.append(made)
        self.spans.append(span)
        states.append(tables.of_states[states[-1]][name])
