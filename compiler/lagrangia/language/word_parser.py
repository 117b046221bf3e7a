"""A text read word by word, by the reader's tables: what fits at each place can be asked, and another way be tried from it."""

from collections.abc import Iterator, Mapping

from lagrangia.language.reader import END, Tables, Word


class UnexpectedError(Exception):
    """What stands in [start, end) does not fit; `is_strange` where it is no word of the language."""

    def __init__(self, start: int, end: int, is_strange: bool = False) -> None:
        super().__init__()
        self.start, self.end, self.is_strange = start, end, is_strange


class WordParser:
    """The states of the parser behind the words taken so far; no tree is made."""

    def __init__(self, tables: Tables, text: str, position: int = 0, states: list[int] | None = None) -> None:
        self.tables, self.text, self.position = tables, text, position
        self.states = [tables.start] if states is None else states

    def copy(self) -> "WordParser":
        """Another at the same place, which goes its own way."""
        return WordParser(self.tables, self.text, self.position, [*self.states])

    @property
    def row(self) -> Mapping[str, int]:
        """What the table has for the state: terminals that may fit, and names of rules."""
        return self.tables.of_states[self.states[-1]]

    def accepted(self) -> frozenset[str]:
        """The terminals that fit: END of the tables where the text may end."""
        return frozenset(kind for kind in self.row if kind.isupper() and _after(self.tables, [*self.states], kind))

    def take(self, word: Word) -> None:
        """Raises UnexpectedError where it does not fit: rules that end before it have ended then."""
        if not _after(self.tables, self.states, word.type):
            raise UnexpectedError(word.start_pos, word.end_pos)

    def words(self) -> Iterator[Word]:
        """Those that follow, each read when the one before was taken. Raises UnexpectedError."""
        while (word := self._next()) is not None:
            self.position = word.end_pos
            yield word

    def _next(self) -> Word | None:
        text = self.text
        while self.position < len(text):
            found = self.tables.match(text, self.position)
            if found is None:
                raise UnexpectedError(self.position, self.position + 1, True)
            if found.lastgroup == "ignored":
                self.position = found.end()
                continue
            kind, end = self.tables.terminal(found, self.row)
            if kind not in self.row:
                raise UnexpectedError(self.position, end)
            return Word(kind, text[self.position : end], self.position, end)
        return None


def _after(tables: Tables, states: list[int], kind: str) -> bool:
    """Whether a terminal fits behind these states, which become those behind it."""
    while (action := tables.of_states[states[-1]].get(kind)) is not None:
        if action >= 0:
            states.append(action)
            return True
        name, size, *_ = tables.rules[-1 - action]
        del states[len(states) - size :]
        states.append(tables.of_states[states[-1]][name])
        if kind == END and states[-1] == tables.end:
            return True
    return False
