"""What people mean who write C, Python, MATLAB, typeset text or another tongue: one hint for what does not parse."""

import re
import unicodedata
from collections.abc import Iterator, Mapping

from lagrangia.base.diagnostics import nearest
from lagrangia.language.functions import CALLED
from lagrangia.language.open_blocks import open_blocks
from lagrangia.language.reader import Word
from lagrangia.language.recovery import Stop
from lagrangia.language.units import parse_unit

# Signs, which are told together with the character before or behind them.
FOREIGN_SIGNS: Mapping[str, str] = {
    "==": "an equation and a value given have one '='; '==' compares", "**": "a power is written a^b", "&&": "write: and",
    "||": "write: or", "!=": "write: <>", "!": "write: not", "#": "a comment begins with //", "&": "write: and",
    "=>": "an equation has a '=' alone; greater or equal is >=", "|": "write: abs(x); and a or b of conditions",
    ":=": "an equation has '='; ':=' assigns, in the algorithm of a function",
    "->": "frames are joined by connect(a, b), or a = b", "+=": "write: x := x + ...", "-=": "write: x := x - ...",
    "within": "`within P;` stands first in a file", "?": "write: if c then a else b", "%": "the remainder is mod(a, b)",
    "*/": "no comment is open here", "≤": "write: <=", "≥": "write: >=", "≠": "write: <>", "√": "write: sqrt(x)",
    "°": "degrees stand in brackets behind their number: 30[deg]",
    **dict.fromkeys("−–", "write the minus sign of the keyboard: -"), **dict.fromkeys("×·", "write: *"),
    **dict.fromkeys("“”", 'a text stands in straight quotes: "..."'), "²": "a power is written a^2",
    **dict.fromkeys("@$\\`~", "this sign has no meaning in the language"),
}
_BRANCHES = {**dict.fromkeys(("elif", "elsif", "elseif"), "elseif"), "endif": "end if;", "endfor": "end for;",
             "endwhen": "end when;"}
_TONGUES = {"wenn": "if", "falls": "if", "si": "if", "für": "for", "pour": "for", "dann": "then", "sonst": "else", "ende": "end"}
_BEFORE_TYPES = {"const": "constant", "private": "protected", "final": "final"}
_SECTIONS = ("equation", "initial", "energy", "algorithm", "drawing", "protected", "public")
_IDLE = ("var", "let", "static", "auto", "new", "val", "local")
_KEPT = ("parameter", "constant", "coordinate", "input", "output", "discrete", "protected")
_ENERGIES = ("kinetic", "potential", "dissipation", "work")
_WRITTEN = {"connect": "write: connect(a, b);", "assert": 'write: assert(x > 0, "what is wrong otherwise");'}
_OPEN = {"(": ")", "[": "]", "{": "}"}


def guesses_of_habits(stop: Stop) -> Iterator[str]:
    """From the surest on."""
    yield from _of_signs(stop)
    yield from _of_blocks(stop)
    yield from _of_energies(stop)
    yield from _of_headers(stop)
    yield from _of_declarations(stop)
    yield from _of_formulas(stop)


def statement_of(stop: Stop) -> list[Word]:
    """The words of the statement that does not parse, up to where it stops."""
    words: list[Word] = []
    for word in reversed(stop.before):
        if word.type in ("SEMICOLON", "EQUATION", "ALGORITHM", "__ANON_0", "DRAWING", "VISIBILITY"):
            break
        words.append(word)
    return words[::-1]


def _adjoins(stop: Stop) -> bool:
    return bool(stop.before) and stop.before[-1].end_pos == stop.span.start


def _of_signs(stop: Stop) -> Iterator[str]:
    word, last = stop.word, stop.last(1)
    if last == ("NAME",) and word.startswith("'") and _adjoins(stop):
        yield f"a rate is written der({stop.before[-1]})"
    elif word == "'":
        yield "a name in single quotes ends with one"
    is_dashes = word == "-" and last == ("ADD",) and _adjoins(stop) and len(statement_of(stop)) == 1
    if is_dashes or (word == "%" and ("END" in stop.accepted or not stop.before)):
        yield "a comment begins with //"
    if word in FOREIGN_SIGNS:
        yield FOREIGN_SIGNS[word]
    if len(word) == 1 and not word.isascii() and not word.isalpha():
        plain = unicodedata.normalize("NFKC", word)
        if unicodedata.category(word) == "Cf":
            yield "a character that nobody sees stands here: delete it"
        elif plain.isspace() or word.isspace():
            yield "this is another space than that of the keyboard: write one anew"
        elif len(plain) == 1 and plain.isascii() and plain != word:
            yield f"write the sign of the keyboard: {plain}"
    text = stop.source.text[: stop.span.start].rstrip()
    if text.endswith("*/") and text.count("/*", text.rfind("*/", 0, -2) + 1) > 1:
        yield "a comment holds no other one: it ends at the first */"


def _of_blocks(stop: Stop) -> Iterator[str]:
    word, accepted, before = stop.word, stop.accepted, stop.before
    opens = next((name for name in ("THEN", "LOOP") if name in accepted), "").lower()
    if opens and word in ("{", "do", ":", "dann"):
        yield f"write `{opens}`, and `end ...;` behind the last statement"
    if opens == "loop" and word == "=" and stop.last(2) == ("FOR", "NAME"):
        yield f"write: for {before[-1]} in 1:n loop"
    if stop.last(1) == ("NUMBER",) and before[-1].endswith(".") and re.fullmatch(r"\.\d+", word):
        yield f"a range is written {before[-1][:-1]}:{word[1:]}"
    if word == "else" and "ELSEWHEN" in accepted:
        yield "a `when` has no else: write elsewhen with its condition"
    if stop.last(1) == ("NAME",) and before[-1].lower() in _BRANCHES and word not in ("=", "."):
        yield f"write: {_BRANCHES[before[-1].lower()]}"
    if word in _SECTIONS and (hint := open_block_hint(stop)):
        yield hint


def open_block_hint(stop: Stop) -> str:
    """Which block is open where the text, a section or a class ends; "" where none is."""
    blocks = open_blocks(stop)
    if not blocks:
        return ""
    begin, kind = blocks[-1].word, str(blocks[-1].word)
    joined = next((word for word in reversed(stop.before) if word in ("endif", "endfor", "endwhen")), "")
    if joined:
        return f"write: {_BRANCHES[joined]}"
    if blocks[-1].has_else_if:
        return "`else if` begins another if, which has its own `end if;`: write elseif"
    line, column = stop.source.line_and_column(begin.start_pos)
    return f"the '{kind}' at {line}:{column} is still open: end {kind};"


def _of_headers(stop: Stop) -> Iterator[str]:
    word, last, before = stop.word, stop.last(2), stop.before
    if last == ("CLASS_KIND", "NAME") and before[-2] == "function" and word == "(":
        name = before[-1]
        yield f"inputs are declared: function {name} input Real x; output Real y; algorithm y := 2*x; end {name};"
    elif last == ("CLASS_KIND", "NAME") and word == "(":
        yield "a model has no list of arguments: what it is given are parameters, declared in it: parameter Real a;"
    elif last == ("CLASS_KIND", "NAME") and word == "-":
        yield f"a name is made of letters, digits and _: {before[-1]}_{_behind(stop) or 'b'}"
    if last == ("CLASS_KIND", "NAME") and word == ":":
        yield f"no ':' stands behind the name: {before[-2]} {before[-1]}"
    if last[1:] and last[1] in ("EQUATION", "ALGORITHM", "__ANON_0", "DRAWING") and word == ":":
        yield f"no ':' stands behind `{before[-1]}`"
    is_joined = stop.source.text[stop.span.end : stop.span.end + 1].isidentifier()
    if word.isdigit() and is_joined and "NAME" in stop.accepted and not {"LPAR", "NUMBER"} & stop.accepted:
        yield "a name begins with a letter"
    if word == "as" and "import" in statement_of(stop):
        name = before[-1]
        yield f"another name is given so: import {_behind(stop) or 'n'} = {name};"


def _behind(stop: Stop) -> str:
    match = re.compile(r"\s*(\w+)").match(stop.source.text, stop.span.end)
    return match[1] if match else ""


def _of_declarations(stop: Stop) -> Iterator[str]:
    word, accepted, before = stop.word, stop.accepted, stop.before
    statement = statement_of(stop)
    kinds = tuple(token.type for token in statement)
    if stop.last(2) == ("EQUAL", "NAME") and before[-1] == "new":
        yield f"a component is made by its declaration: {word} name(parameter = value);"
    if kinds[-1:] == ("NAME",) and accepted >= {"EQUAL", "RPAR"} and "SEMICOLON" not in accepted:
        if word == ":":
            yield f"write: {before[-1]} = ..."
        if word[:1].isdigit():
            yield f"write: {before[-1]} = {word}"
    if kinds[-2:] == ("NAME", "LPAR") and word[:1].isdigit() and "NUMBER" not in accepted:
        yield f"sizes stand in square brackets: {before[-2]}[{word}]"
    if kinds[-2:] == ("NAME", "NAME") and accepted >= {"SEMICOLON", "EQUAL", "LPAR"}:
        yield from _of_two_names(str(before[-2]), str(before[-1]), word)
    if accepted >= {"NAME", "LSQB", "DOT"} and "SEMICOLON" not in accepted and "ADD" not in accepted and kinds[-1:] == ("NAME",):
        name = statement[-1]
        if word == "=" and name in ("Real", "Integer", "Boolean", "String"):
            yield f"a name is missing behind the type '{name}'"
        elif word == "=" and nearest_energy(stop) == "":
            yield (f"a declaration has a type before its name: {' '.join([*map(str, statement[:-1]), 'Real', name])} = ...; "
                   "and an equation stands under `equation`")
        if word == ":":
            yield f"the type stands before the name: {_behind(stop) or 'Real'} {name};"


def _of_two_names(first: str, second: str, word: str) -> Iterator[str]:
    if word == "{":
        yield f"what is modified stands in round brackets: {second}(... = ...)"
    elif word == "-":
        yield f"a name is made of letters, digits and _: {second}_b"
    elif word == ":" and first in _IDLE:
        yield f"the type stands before the name: Real {second};"
    elif word.isidentifier() and first in _IDLE:
        yield f"leave the word out: {second} {word}"
    elif word.isidentifier() or word in ("*", "/", "+", "^", "("):
        known = _KEPT if word.isidentifier() else _ENERGIES
        if meant := _BEFORE_TYPES.get(first) or nearest(first, known):
            yield f"did you mean '{meant}'?"


def nearest_energy(stop: Stop) -> str:
    """What the energy is called that a statement `T = ...` of the section energy states; "" elsewhere."""
    sections = ("EQUATION", "ALGORITHM", "__ANON_0", "DRAWING", "CLASS_KIND")
    if next((word.type for word in reversed(stop.before) if word.type in sections), "") != "__ANON_0":
        return ""
    return {"T": "kinetic", "K": "kinetic", "D": "dissipation", "R": "dissipation"}.get(str(stop.before[-1]), "potential")


def _of_energies(stop: Stop) -> Iterator[str]:
    word, before = stop.word, stop.before
    if stop.last(1) == ("ENERGY",) and word in ("=", ":", ":="):
        yield f"no '{word}' stands behind it: {before[-1]} ...;"
    if word == "=" and stop.last(1) == ("NAME",) and len(statement_of(stop)) == 1 and (kind := nearest_energy(stop)):
        yield f"write: {kind} ...; an energy has no name"
    if stop.last(1) == ("NAME",) and before[-1] in ("force", "torque") and nearest_energy(stop):
        yield f"write: work {word} on ...;"
    if stop.accepted == {"ON"} or ("ON" in stop.accepted and word in (";", "for")):
        yield "write: work force on position;"
    if stop.last(2) == ("ENERGY", "NAME") and before[-1] == "energy":
        yield f"write: {before[-2]} {word} ...;"


def _of_formulas(stop: Stop) -> Iterator[str]:
    word, accepted, before = stop.word, stop.accepted, stop.before
    statement = statement_of(stop)
    if word == "," and stop.last(1) == ("NUMBER",) and not _innermost(before) and (behind := _behind(stop)).isdigit():
        yield f"decimals have a point: {before[-1]}.{behind}"
    if word == "=" and sum(token == "=" for token in statement) == 1 and "SEMICOLON" in accepted:
        yield ("one equation has one '=': a = b; b = c;" if statement[0].type != "NAME" or statement[1].type != "NAME" else
               "values are compared by '=='")
    if word == "else" and "if" in statement:
        yield "write: if c then a else b"
    is_operand = word[:1].isdigit() or word.isidentifier()
    if stop.last(1) == ("NAME",) and is_operand and not stop.is_first_of_line and "ADD" in accepted:
        if (name := str(before[-1])) in CALLED:
            yield _WRITTEN.get(name) or f"what {name} is of stands in brackets: {name}({word})"
        elif name.lower() in _TONGUES:
            yield f"the words of the language are English: {_TONGUES[name.lower()]}"
        elif name in _IDLE:
            yield f"leave '{name}' out; variables are declared before the sections: Real {word};"
    if stop.last(1) in (("NUMBER",), ("NAME",)) and is_operand and (inner := _innermost(before)) and "COMMA" in accepted:
        yield "elements are separated by ',': {1, 2}" if inner in ("[", "{") else "is a ',' or an operator missing before it?"
    if stop.last(1) == ("NUMBER",) and word in ("e", "E") and _adjoins(stop):
        yield f"an exponent has digits: {before[-1]}e3"
    elif stop.last(1) == ("NUMBER",) and word.isidentifier() and not (_is_unit(word) or _is_word(stop) or stop.is_first_of_line):
        yield f"a product has its sign: {before[-1]}*{word}"


def _innermost(before: tuple[Word, ...]) -> str:
    opened: list[str] = []
    for token in before:
        if token in _OPEN:
            opened.append(str(token))
        elif token in _OPEN.values() and opened:
            opened.pop()
    return opened[-1] if opened else ""


def _is_unit(word: str) -> bool:
    try:
        parse_unit(word)
    except ValueError:
        return False
    return True


def _is_word(stop: Stop) -> bool:
    """Whether it is a word of the language, or of a number written otherwise (1_000, 0x10)."""
    number = str(stop.before[-1])
    return stop.word in ("if", "then", "else", "for", "loop", "end", "and", "or", "not", "on", "in") or (
        _adjoins(stop) and (stop.word.startswith("_") or (number == "0" and stop.word[:1].lower() in "xob")))
