"""Text -> what an actor makes of it, by tables of an LALR(1) parser (Aho, Sethi, Ullman, Compilers, 1986, section 4.7).

The tables are those that Lark makes of the grammar (grammar_tables.py), as plain data. Lark itself is not needed to read a text
that is right: loading it, and the patterns of its many lexers, takes ten times as long as reading a scene does. Where this reader
does not see its way it says so, and Lark decides.
"""

import re
from collections.abc import Iterator, Mapping, Sequence
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
    """The text is wrong, or is cut into words in another way than this reader's."""


# A rule: what it is of, how many symbols it has, the actor's method or None where its children are those of the rule above,
# whether a single child stands for it, the children kept (place, whether its own children are meant, how many absent ones come
# before), and how many absent ones come at the end.
Rule = tuple[str, int, str | None, bool, Sequence[tuple[int, bool, int]], int]


@dataclass(frozen=True)
class Tables:
    """`rows`: by symbol the next state, or -1 - rule; `row_of` the row of each state; `words`: by their text the terminals that
    they may be, each with what has to follow ("" for anything), of which the first counts that a state accepts; `pattern` matches
    one word, named by its terminal, or NAME."""

    start: int
    end: int
    row_of: Sequence[int]
    rows: Sequence[Mapping[str, int]]
    rules: Sequence[Rule]
    words: Mapping[str, Sequence[tuple[str, str]]]
    pattern: str

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
        kind = found.lastgroup
        if kind != "ignored":
            word = found.group()
            stack.take(stack.terminal(kind, word, text, found.end()), Word, word, at, found.end())
        at = found.end()
    return stack.finish()


class _Stack:
    """States of the parser, and for each the value made and the text it takes up (start, end), None where that is none."""

    def __init__(self, tables: Tables, actor: Actor) -> None:
        self.tables, self.actor = tables, actor
        self.states = [tables.start]
        self.values: list[Any] = []
        self.spans: list[tuple[int, int] | None] = []

    def terminal(self, kind: str, word: str, text: str, end: int) -> str:
        """Which one of those that a word may be is meant here."""
        row = self.tables.of_states[self.states[-1]]
        return self.tables.meant(word, row, text, end) or kind if kind == "NAME" else kind

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


def walk(tree: Any, actor: Actor) -> Any:
    """The same of a tree of Lark's."""
    meta = tree.meta
    place = NOWHERE if meta.empty else Place(meta.start_pos, meta.end_pos)
    return getattr(actor, str(tree.data))(place, list(_walked(tree.children, actor)))


def _walked(children: Sequence[Any], actor: Actor) -> Iterator[Any]:
    for child in children:
        if child is None:
            yield None
        elif isinstance(child, str):
            yield Word(child.type, str(child), child.start_pos, child.end_pos)  # type: ignore[attr-defined]
        else:
            yield walk(child, actor)
