"""grammar/lag.lark -> the tables of reader.py, by Lark."""

import marshal
import re
from pathlib import Path
from typing import Any

from lark import Lark
from lark.grammar import Rule as LarkRule

from lagrangia.language.reader import Rule

# The pattern of a terminal that is one of some words, each perhaps by what follows, and of all such alternatives.
_WORDS = r"(?:\(\?:[\w|]+\)|\w+)(?:\\b|\(\?[=!](?:[^()\[\]]|\[(?:\\.|[^\]\\])*\])+\))"
_WHOLE_WORDS = re.compile(rf"{_WORDS}(?:\|{_WORDS})*")
_SAME_WORDS = re.compile(r"(?:\(\?:)?([\w|]+)\)?(\\b|\(\?[=!](?:[^()\[\]]|\[(?:\\.|[^\]\\])*\])+\))")


def lark_parser(grammar: Path) -> Lark:
    """Lark's parser of a grammar: half a second of work."""
    text = grammar.read_text(encoding="utf-8")
    return Lark(text, parser="lalr", start="file", propagate_positions=True, maybe_placeholders=True)


def make_tables(grammar: Path) -> bytes:
    """The members of reader.Tables, in their order, likewise."""
    parser: Any = lark_parser(grammar)
    table = parser.parser.parser._parse_table
    rules: dict[LarkRule, int] = {}
    rows: dict[tuple[tuple[str, int], ...], int] = {}
    states = sorted(table.states)
    row_of = []
    for state in states:
        row = []
        for symbol, (action, target) in table.states[state].items():
            is_reduction = str(action) == "Reduce"
            row.append((str(symbol), -1 - rules.setdefault(target, len(rules)) if is_reduction else states.index(target)))
        row_of.append(rows.setdefault(tuple(sorted(row)), len(rows)))
    start, end = (states.index(found["file"]) for found in (table.start_states, table.end_states))
    words, patterns = _words_of(parser)
    plain: Any = (start, end, tuple(row_of), tuple(map(dict, rows)), tuple(_rule_of(rule) for rule in rules), words, patterns,
                  {t.name: t.pattern.value for t in parser.terminals if type(t.pattern).__name__ == "PatternStr"})
    return marshal.dumps(plain)


def _rule_of(rule: LarkRule) -> Rule:
    options, size = rule.options, len(rule.expansion)
    absent = [0] * (size + 1)
    place = 0
    for is_empty in options.empty_indices or ():
        if is_empty:
            absent[place] += 1
        else:
            place += 1
    kept, waiting = [], 0
    for k, symbol in enumerate(rule.expansion):
        waiting += absent[k]
        if options.keep_all_tokens or not (symbol.is_term and getattr(symbol, "filter_out", False)):
            kept.append((k, not symbol.is_term and symbol.name.startswith("_"), waiting))
            waiting = 0
    name = str(rule.origin.name)
    method = None if name.startswith("_") and not rule.alias else str(rule.alias or name)
    return name, size, method, bool(options.expand1 and not rule.alias), tuple(kept), waiting + absent[size]


def _words_of(parser: Any) -> tuple[dict[str, tuple[tuple[str, str], ...]], tuple[tuple[str, str], ...]]:
    """Words with the terminals they may be, and the patterns of all others; both in the order in which Lark tries them."""
    ordered = sorted(parser.terminals, key=lambda t: (-t.priority, -t.pattern.max_width, -len(t.pattern.value), t.name))
    words: dict[str, list[tuple[str, str]]] = {}
    ignored, patterns = [], []
    for terminal in ordered:
        value, is_plain = terminal.pattern.value, type(terminal.pattern).__name__ == "PatternStr"
        if terminal.name in parser.ignore_tokens:
            ignored.append(terminal.pattern.to_regexp())
        elif is_plain and value.isidentifier():
            words.setdefault(value, []).append((terminal.name, ""))
        elif not is_plain and _WHOLE_WORDS.fullmatch(value):
            for same in _SAME_WORDS.finditer(value):
                for word in same[1].split("|"):
                    words.setdefault(word, []).append((terminal.name, "" if same[2] == "\\b" else same[2]))
        else:
            patterns.append((terminal.name, terminal.pattern.to_regexp()))
    return {word: tuple(names) for word, names in words.items()}, (("ignored", "|".join(ignored)), *patterns)
