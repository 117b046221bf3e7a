"""Text that does not parse -> what was expected there, in words, and what is likely to be meant."""

import re
from collections.abc import Iterator
from itertools import pairwise
from typing import NoReturn

from lagrangia.base.diagnostics import LagError, Report, Source, Span, nearest
from lagrangia.language.foreign_words import FOREIGN_PAIRS, FOREIGN_TYPES, FOREIGN_WORDS
from lagrangia.language.habits import FOREIGN_SIGNS, guesses_of_habits, open_block_hint
from lagrangia.language.reader import Tables, Word
from lagrangia.language.recovery import Stop, find_stops

# Terminals that are patterns; the others are said as they are written.
SPOKEN = {
    "$END": "the end of the file", "NAME": "a name", "NUMBER": "a number", "QUANTITY": "a number", "STRING": "a text in quotes",
    "CLASS_KIND": "'model'", "PARTIAL": "'partial'", "PREFIX": "'parameter'", "VISIBILITY": "'protected'",
    "ARGUMENT_PREFIX": "'each'", "ENERGY": "an energy", "TRUE": "'true'", "FALSE": "'false'", "OR": "'or'", "AND": "'and'",
    "ADD": "'+'", "MULTIPLY": "'*'", "COMPARE": "'<'", "EACH_ADD": "'.+'", "EACH_MULTIPLY": "'.*'", "POWER": "'^'",
    "SCOPE": "'replaceable'", "LAST": "'end'",
}
# Many terminals that are one thing to people: said when all of the first are possible, and then for all of the second.
_GROUPS = (
    ("an expression", {"NUMBER", "NAME", "LPAR", "LBRACE"}, {"QUANTITY", "STRING", "TRUE", "FALSE", "ADD", "IF", "NOT", "LSQB",
                                                             "LAST"}),
    ("a declaration", {"PREFIX", "NAME"}, {"VISIBILITY", "EXTENDS", "ANNOTATION", "SCOPE", "CLASS_KIND", "PARTIAL", "IMPORT"}),
    ("a model", {"CLASS_KIND", "PARTIAL", "PREFIX"}, {"SCOPE"}),
    ("a section", {"EQUATION", "INITIAL", "ALGORITHM"}, {"__ANON_0", "DRAWING"}),
    ("an operator", {"ADD", "MULTIPLY", "COMPARE"}, {"POWER", "AND", "OR", "COLON", "EACH_ADD", "EACH_MULTIPLY"}),
    ("an operator", {"ADD", "MULTIPLY"}, {"POWER", "AND", "OR", "COLON", "EACH_ADD", "EACH_MULTIPLY", "COMPARE"}),
    ("the rest of a declaration", {"SEMICOLON", "ANNOTATION", "CONSTRAINEDBY"}, {"COMMA", "IF", "LPAR", "EQUAL", "LSQB",
                                                                                 "STRING"}),
    ("a modification", {"NAME", "ARGUMENT_PREFIX", "SCOPE"}, {"BREAK"}),
    ("the end of the statement", {"SEMICOLON", "ANNOTATION"}, {"STRING"}),
)
_SECTIONS = ("equation", "algorithm", "energy", "initial")  # which stand in models
_KINDS = {"class": "model", "block": "model", "struct": "record", "def": "function", "include": "import", "from": "import"}
_BASES, _BEHIND = ("x", "o", "b"), (";", ")", ",", "")
_ENERGIES = ("kinetic", "potential", "dissipation", "work")
_CLOSES = {")": "(", "]": "[", "}": "{"}


def refuse(source: Source, tables: Tables) -> NoReturn:
    """Raise the LagError (L0103 to L0105, L0901) for a text that the parser refuses. It is parsed once more, token by token."""
    report = Report()
    for stop in find_stops(source, tables):
        _tell(report, _widened(stop), tables)
    raise LagError(report.errors)


def _tell(report: Report, stop: Stop, tables: Tables) -> None:
    if _tell_unsupported(report, stop):
        return
    if stop.source.text.startswith("/*", stop.span.start):
        begin = Span(stop.source, stop.span.start, stop.span.start + 2)
        report.error("L0104", "this comment has no end", begin, "a comment that begins with /* ends with */")
    elif stop.word == '"':
        report.error("L0104", "this text has no closing quote", stop.span)
    elif not stop.word:
        label = _label(stop, tables, "after this, expected")
        report.error("L0105", "the file ends too early", _end_of(stop), *_end_hints(stop), label=label)
    elif stop.lacks_semicolon:
        report.error("L0103", "a ';' is missing", _end_of(stop), label="after this")
    else:
        report.error("L0103", f"unexpected '{shortened(stop.word)}'", stop.span, *_hints(stop),
                     label=_label(stop, tables, "expected"))


def _tell_unsupported(report: Report, stop: Stop) -> bool:
    """What is Modelica's, but not ours; it was read as a type or a name, or is the word that did not fit."""
    here = (stop.word, stop.span) if stop.word else None
    types, texts = stop.last(4), [str(token) for token in stop.before[-4:]]
    if texts[-1:] == ["when"] and types[-1:] == ("NAME",):
        return _unsupported(report, _place(stop, -1), "`when` in algorithms", "events stand among the equations of a model: "
                            "when x > 1 then reinit(der(x), v); end when;")
    if texts[-1:] == ["function"] and "(" in map(str, _open_brackets(stop)):
        return _unsupported(report, _place(stop, -1), "functions as arguments", "call the function where its value is needed, or "
                            "let it be replaceable: replaceable function f = g;")
    if types[:1] == ("CLASS_KIND",) and texts[2:3] == ["="] and texts[3:4] and texts[3] in FOREIGN_WORDS:
        return _unsupported(report, _place(stop, -1), *FOREIGN_WORDS[texts[3]])
    told = [(str(t), Span(stop.source, t.start_pos, t.end_pos)) for t in stop.before[-6:] if t.type not in ("STRING",)]
    for (first, place), (second, end) in pairwise(told):
        if second == "extends" and (first, second) in FOREIGN_PAIRS:
            report.error("L0901", f"not of this language: {FOREIGN_PAIRS[first, second][0]}", place.to(end),
                         FOREIGN_PAIRS[first, second][1])
            return True
    last = told[-3:]
    words = [*last, *([here] if here is not None else [])]
    if here is not None and (behind := re.compile(r"\s+([^\W\d]\w*)").match(stop.source.text, stop.span.end)):
        words.append((behind[1], Span(stop.source, *behind.span(1))))
    for (first, place), (second, end) in pairwise(words):
        if (first, second) in FOREIGN_PAIRS:
            what, instead = FOREIGN_PAIRS[first, second]
            report.error("L0901", f"not of this language: {what}", place.to(end), instead)
            return True
    begins = [k for k, (word, _) in enumerate(words) if word in FOREIGN_WORDS and (k == 0 or words[k - 1][0] not in (".", "="))]
    if begins and begins[0] > 0 and words[begins[0] - 1][0] == "end":
        return True  # its beginning was told
    for word, place in (words[k] for k in begins[:1]):
        what, instead = FOREIGN_WORDS[word]
        report.error("L0901", f"not of this language: {what}", place, instead)
        return True
    return False


def _place(stop: Stop, at: int) -> Span:
    token = stop.before[at]
    return Span(stop.source, token.start_pos, token.end_pos)


def _unsupported(report: Report, place: Span, what: str, instead: str) -> bool:
    report.error("L0901", f"not of this language: {what}", place, instead)
    return True


def _widened(stop: Stop) -> Stop:
    """With the character before or behind it, where both are a sign of another language."""
    start = stop.span.start
    for first, last in ((start - 1, start + 1), (start, start + 2)):
        if stop.source.text[max(0, first) : last] in FOREIGN_SIGNS:
            before = tuple(token for token in stop.before if token.end_pos <= max(0, first))
            return Stop(stop.source, Span(stop.source, max(0, first), last), before, stop.accepted)
    return stop


def _end_of(stop: Stop) -> Span:
    """The last character before the stop that is no space."""
    end = stop.before[-1].end_pos if stop.before else 1
    return Span(stop.source, max(0, (end or 1) - 1), end or 1)


# -------------------------------------------------------------------- what was expected


def _label(stop: Stop, tables: Tables, before: str) -> str:
    names, said = set(stop.accepted), []
    if "RPAR" in names:
        names.discard("STRING")  # which is rare there
    for phrase, needed, taken in _GROUPS:
        if names >= needed:
            said.append(phrase)
            names -= needed | taken
    said += sorted({_spoken(name, tables) for name in names})
    return f"{before} {_either(said)}" if said else ""


def _spoken(name: str, tables: Tables) -> str:
    if name in SPOKEN:
        return SPOKEN[name]
    return f"'{tables.plain[name]}'"


def _either(said: list[str]) -> str:
    return " or ".join([", ".join(said[:-1]), said[-1]] if len(said) > 1 else said)


def shortened(word: str) -> str:
    """A word of the text in one line of 40 characters."""
    word = word.replace("\n", " ")
    return word if len(word) <= 40 else word[:37] + "..."


# -------------------------------------------------------------------- what is meant


def _hints(stop: Stop) -> Iterator[str]:
    """At most one guess: the first that fits."""
    return (hint for hint in [next(_guesses(stop), "")] if hint)


def _guesses(stop: Stop) -> Iterator[str]:
    word, accepted = stop.word, stop.accepted
    yield from guesses_of_habits(stop)
    if stop.before and stop.before[-1].type == "STRING" and "\n" in stop.before[-1]:
        line, column = stop.source.line_and_column(stop.before[-1].start_pos)
        yield f"the text that ends before it begins at {line}:{column}: is a quote missing?"
    if word == "+" and stop.last(1) == ("STRING",):
        yield "a text stands in one pair of quotes"
    if word in _CLOSES and stop.last(1) == ("COMMA",):
        yield "is the ',' before it one too many?"
    if word in _CLOSES and not _open_brackets(stop):
        yield f"no '{_CLOSES[word]}' is open that it could close"
    if stop.last(2) == ("CLASS_KIND", "NAME") and word == "{":
        yield "a model has no braces: model Name ... end Name;"
    if word == "." and {"EQUAL", "RPAR"} <= accepted and stop.before:
        yield f"a part of a part is modified in brackets: {stop.before[-1]}(... = ...)"
    if word == ".":
        yield "a name has no dot before it, and parts are picked from names: r = f(x), r.a"
    if word == ";" and accepted & {"CLASS_KIND", "END"}:
        yield "this ';' is one too many: no statement is empty"
    if word == "=" and next((token for token in reversed(stop.before) if token in ("drawing", *_SECTIONS)), "") == "drawing":
        yield "shapes stand here: line(bar.a, bar.b); an equation stands under `equation`"
    if "CLASS_KIND" in accepted:
        near = nearest(word, ["model", "function", "type", "import", "partial"]) if word not in _SECTIONS else ""
        if meant := _KINDS.get(word, near):
            yield f"did you mean '{meant}'?"
        elif "END" not in accepted:
            yield "declarations and equations stand in a model: model Name ... end Name;"
    if stop.last(1) == ("END",) and accepted <= {"FOR", "IF", "WHEN", "WHILE"}:
        yield f"an inner block is still open: end {min(accepted).lower()};"
    if stop.last(1) == ("END",):
        yield "say what ends: end Name;"
    yield from _guesses_of_modelica(stop)
    yield from _guesses_from_neighbours(stop)
    if (opened := _open_brackets(stop)) and (word == ";" or word in _CLOSES):
        line, column = stop.source.line_and_column(opened[-1].start_pos)
        yield f"the '{opened[-1]}' at {line}:{column} is still open"
    if "SEMICOLON" in accepted and word.isidentifier():
        yield "is an operator or a ';' missing before it?"


def _guesses_of_modelica(stop: Stop) -> Iterator[str]:
    """Where its habits, or those of other languages of formulas, meet what is not here."""
    word, accepted, last = stop.word, stop.accepted, stop.last(3)
    if word.startswith('"') and accepted >= {"CLASS_KIND", "END"}:
        yield "a text stands behind what it describes, before its ';'"
    if last[-1:] == ("ADD",) and word == stop.before[-1] and stop.source.text[stop.span.end : stop.span.end + 1] in _BEHIND:
        yield f"nothing is added by '{word}{word}': write n {word} 1"
    elif last[-1:] in (("ADD",), ("MULTIPLY",), ("EACH_ADD",), ("EACH_MULTIPLY",)) and word in ("+", "-"):
        yield f"a sign behind an operator stands in brackets: a {stop.before[-1]} ({word}b)"
    if word == "^" and "POWER" not in accepted and "POWER" in stop.last(2):
        yield "a power of a power stands in brackets: (a^b)^c, or a^(b^c)"
    if word == "not" and last[-1:] == ("NOT",):
        yield "write: not (not x)"
    if last[-1:] in (("RPAR",), ("RBRACE",), ("RSQB",)) and word == "[":
        yield "an element is picked from a name: Real v[3] = {1, 2, 3}; v[2]"
    if word == "[" and {"EQUAL", "RPAR"} <= accepted:
        yield f"the elements of an array are given together: {stop.before[-1]} = {{1, 2, 3}}"
    if word == ";" and "ELSE" in accepted:
        yield "an if expression has an else: if c then a else b"
    if word == "=" and _section(stop) == "ALGORITHM":
        yield "in an algorithm: name := expression;"
    if word == ")" and last[1:] == ("ENUMERATION", "LPAR"):
        yield "it has at least one value: enumeration(low, high)"
    if word == ":" and "NAME" in accepted:
        yield "a ':' alone stands for all of a size or an index: Real x[:], A[:, 1]"


def _written_otherwise(stop: Stop) -> str:
    """How a number is written that begins as in another language: 0x10, 0b11, 1_000."""
    number, word = str(stop.before[-1]) if stop.last(1) == ("NUMBER",) else "", stop.word
    if not number or stop.before[-1].end_pos != stop.span.start:
        return ""
    if number == "0" and word[:1].lower() in _BASES and word[1:].isalnum():
        try:
            return f"numbers are decimal: {int(number + word, 0)}"
        except ValueError:
            return "numbers are decimal"
    if word.replace("_", "").isdigit() and word.startswith("_"):
        return f"digits stand together: {number}{word.replace('_', '')}"
    return ""


def _section(stop: Stop) -> str:
    """The word that the section around the stop begins with; "" in front of the first."""
    words = ("EQUATION", "ALGORITHM", "ENERGY", "DRAWING", "CLASS_KIND")
    found = next((token.type for token in reversed(stop.before) if token.type in words), "")
    return "" if found == "CLASS_KIND" else found


def _guesses_from_neighbours(stop: Stop) -> Iterator[str]:
    last, word = stop.last(2), stop.word
    if hint := _written_otherwise(stop):
        yield hint
    elif last[-1:] == ("NUMBER",) and (word in ("[", "(") or word.isidentifier()) and not stop.is_first_of_line:
        yield "a unit stands in brackets behind its number: 2[mm], 1.5[kN/m]"
    if word in ("<", ">", "<=", ">=") and "AND" in stop.accepted:
        yield "comparisons are joined by `and`: a < b and b < c"
    if last == ("NUMBER", "COMMA") and word.isdigit():
        yield f"decimals have a point: {stop.before[-2]}.{word}"
    if last[1:] == ("NAME",) and stop.before[-1] in _ENERGIES and stop.before[-2] in (";", "equation"):
        yield f"'{stop.before[-1]}' stands in a section of its own: write `energy` before it"
    if last == ("NAME", "NAME") and stop.accepted >= {"SEMICOLON", "ANNOTATION"}:
        kind, name = stop.before[-2:]
        yield f"this is read as the declaration of '{name}', of type '{kind}'"
    if last[-1:] == ("NAME",) and word == "(" and "SEMICOLON" not in stop.accepted:
        yield "an equation stands in a section: write `equation` before it"
    is_type = last[-1:] == ("NAME",) and (stop.before[-1][0].isupper() or stop.before[-1] in FOREIGN_TYPES)
    if is_type and word.isidentifier() and stop.accepted >= {"SEMICOLON", "EQUAL", "DOT"}:
        yield "a declaration stands before the sections equation, initial equation, energy and algorithm"


def _end_hints(stop: Stop) -> Iterator[str]:
    if opened := _open_brackets(stop):
        line, column = stop.source.line_and_column(opened[-1].start_pos)
        yield f"the '{opened[-1]}' at {line}:{column} is still open"
        return
    opened_classes: list[Word] = []
    for before, name, behind in zip(stop.before, stop.before[1:], (*stop.before[2:], None), strict=False):
        if before.type == "CLASS_KIND" and (behind is None or behind.type != "EQUAL"):
            opened_classes.append(name)
        elif before.type == "END" and name.type == "NAME" and opened_classes:
            opened_classes.pop()
    if block := open_block_hint(stop):
        yield block
    elif opened_classes and "END" in stop.accepted:
        yield f"is 'end {opened_classes[-1]};' missing?"


def _open_brackets(stop: Stop) -> list[Word]:
    """Brackets before the stop that are not closed there."""
    opened: list[Word] = []
    for token in stop.before:
        if token in ("(", "[", "{"):
            opened.append(token)
        elif token in _CLOSES and opened:
            opened.pop()
    return opened
