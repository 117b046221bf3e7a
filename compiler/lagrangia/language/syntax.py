"""Text -> Syntax: the parser. The grammar is grammar/lag.lark; each method below makes the node of one rule."""

import marshal
import re
from collections.abc import Iterator as IteratorType
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any, cast

from lagrangia.base.diagnostics import Report, Source, Span, fail
from lagrangia.base.folders import data_folder
from lagrangia.base.spelling import plain_text
from lagrangia.language.reader import NotReadError, Place, Tables, Word, read, walk
from lagrangia.language.shipped import made_of
from lagrangia.language.tree import (
    Argument,
    Array,
    Assignment,
    Binary,
    Boolean,
    Call,
    CallEquation,
    ClassDefinition,
    Comprehension,
    Declaration,
    EnergyKind,
    EnergyTerm,
    Equality,
    Expression,
    Extends,
    ForBlock,
    IfBlock,
    IfExpression,
    ImportFile,
    Iterator,
    Number,
    Part,
    Range,
    Reference,
    Section,
    String,
    Syntax,
    Unary,
    WhenBlock,
    Whole,
    WorkTerm,
)

_DEEPEST = 100  # brackets in brackets, conditions in conditions, loops in loops
_NESTING = re.compile(
    r"""(?P<text>"(?:[^"\\]|\\.)*"? | //[^\n]* | /\*(?:.*?\*/|.*)) | (?P<open>[(\[{]) | (?P<close>[)\]}])
    | (?P<condition>\b(?:else)?if\b) | (?P<done>\bend\s+for\b) | (?P<loop>\bloop\b) | ;""", re.DOTALL | re.VERBOSE)
RESERVED = frozenset(
    "algorithm and annotation coordinate connect constant der drawing each else elseif end energy equation extends false final "
    "for function if import initial input loop model not or output package parameter partial protected public record then time "
    "true type when".split()
)
_LONGEST_CHAIN = 2000  # operands in one unbracketed sum or product


def parse(source: Source) -> Syntax:
    """The syntax tree of one file. Raises LagError (L01xx)."""
    _check_text(source)
    nodes = _Nodes(source)
    try:
        items = read(source.text, tables(), nodes)
    except NotReadError:
        nodes = _Nodes(source)
        items = _parsed_by_lark(source, nodes)
    nodes.report.raise_errors()
    imports = tuple(item for item in items if isinstance(item, ImportFile))
    classes = tuple(item for item in items if isinstance(item, ClassDefinition))
    return Syntax(source, imports, classes)


@cache
def tables() -> Tables:
    """The tables of the parser."""
    return Tables(*marshal.loads(made_of("reader", [grammar_file()], reader_tables)))


def grammar_file() -> Path:
    """The grammar of the language."""
    return data_folder("grammar") / "lag.lark"


def reader_tables() -> bytes:
    """The tables of reader.py, as plain data that marshal reads back."""
    from lagrangia.language.grammar_tables import make_tables

    return make_tables(grammar_file())


def _parsed_by_lark(source: Source, nodes: "_Nodes") -> Any:
    """What the reader has not read. Raises LagError (L0103 to L0105, L0901)."""
    from lark import UnexpectedInput

    from lagrangia.language.expectations import refuse
    from lagrangia.language.grammar_tables import lark_parser

    parser = lark_parser(grammar_file())
    try:
        tree = parser.parse(source.text)
    except UnexpectedInput:
        refuse(source, parser)
    return walk(tree, nodes)


def _check_text(source: Source) -> None:
    """Refuse what is no text, and nesting deep enough to exhaust the recursion of later phases."""
    if "\0" in source.text:
        at = source.text.index("\0")
        fail("L0101", f"{source.name} is not a text file: it holds a NUL character", Span(source, at, at + 1))
    depth = conditions = loops = 0
    for mark in _NESTING.finditer(source.text):
        depth = max(0, depth + (mark.lastgroup == "open") - (mark.lastgroup == "close"))
        conditions = 0 if mark[0] == ";" else conditions + (mark.lastgroup == "condition")
        loops = max(0, loops + (mark.lastgroup == "loop") - (mark.lastgroup == "done"))
        if max(depth, conditions, loops) > _DEEPEST:
            what = "brackets" if depth > _DEEPEST else "conditions" if conditions > _DEEPEST else "loops"
            fail("L0102", f"{what} nested deeper than {_DEEPEST}", Span(source, mark.start(), mark.end()),
                 "one loop runs over several: for i in 1:3, j in 1:4 loop" if what == "loops" else
                 "name a part of the expression with a variable of its own")


_UNESCAPES = {'\\"': '"', "\\\\": "\\", "\\n": "\n", "\\t": "\t"}


def _text(token: Word | None) -> str:
    if token is None:
        return ""
    text = str(token)[1:-1]
    for escape, character in _UNESCAPES.items():
        text = text.replace(escape, character)
    return plain_text(text)


def _name(token: Word) -> str:
    """A quoted name 'a b' stands for itself without the quotes."""
    return plain_text(str(token))


class _Nodes:
    """One method a rule; children come in the order of the grammar, None for an absent [part]."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.report = Report()

    def _span(self, meta: Place | Word) -> Span:
        return Span(self.source, meta.start_pos, meta.end_pos)

    # ---------------------------------------------------------------- file and classes

    def file(self, meta: Place, children: list[Any]) -> list[Any]:
        return children

    def import_file(self, meta: Place, children: list[Any]) -> ImportFile:
        return ImportFile(_text(children[0]), self._span(meta))

    def class_definition(self, meta: Place, children: list[Any]) -> ClassDefinition:
        head = [c for c in children if isinstance(c, Word)]
        is_partial = head[0].type == "PARTIAL"
        kind, name, *rest = head[1:] if is_partial else head
        end_name = rest[-1]
        if str(end_name) != str(name):
            self.report.error("L0106", f"'{name}' ends as '{end_name}'", self._span(end_name), f"write: end {name};",
                              label=f"expected {name}")
        description = rest[0] if len(rest) > 1 else None
        elements: list[Declaration | Extends] = []
        annotation: tuple[Argument, ...] = ()
        hidden: frozenset[str] = frozenset()
        for item in (c for c in children if not isinstance(c, Word)):
            if isinstance(item, tuple) and item and item[0] == "annotation":
                annotation += item[1]
            elif isinstance(item, tuple) and item and item[0] == "visibility":
                hidden = frozenset({"protected"}) & {item[1]}
            elif isinstance(item, list):
                elements += [replace(declaration, prefixes=declaration.prefixes | hidden) for declaration in item]
            elif isinstance(item, Extends):
                elements.append(item)
        sections = tuple(c for c in children if isinstance(c, Section))
        return ClassDefinition(str(kind), is_partial, _name(name), _text(description), tuple(elements), sections,
                               annotation, self._span(meta), self._span(name))

    def short_class(self, meta: Place, children: list[Any]) -> ClassDefinition:
        kind, name, base, arguments, description = children
        extends = Extends(base[0], arguments or (), self._span(meta))
        return ClassDefinition(str(kind), False, _name(name), _text(description), (extends,), (), (), self._span(meta),
                               self._span(name))

    def visibility(self, meta: Place, children: list[Any]) -> tuple[str, str]:
        return "visibility", str(children[0])

    def extends(self, meta: Place, children: list[Any]) -> Extends:
        (name, _), arguments, _ = children
        return Extends(name, arguments or (), self._span(meta))

    def annotation(self, meta: Place, children: list[Any]) -> tuple[str, tuple[Argument, ...]]:
        return "annotation", children[0]

    def annotation_item(self, meta: Place, children: list[Any]) -> tuple[str, tuple[Argument, ...]]:
        result: tuple[str, tuple[Argument, ...]] = children[0]
        return result

    def type_name(self, meta: Place, children: list[Any]) -> tuple[str, Span]:
        return ".".join(map(str, children)), self._span(meta)

    def declaration(self, meta: Place, children: list[Any]) -> list[Declaration]:
        prefixes = frozenset(str(c) for c in children if isinstance(c, Word))
        (type_name, type_span), dimensions, *declarators = [c for c in children if not isinstance(c, Word)]
        return [
            Declaration(prefixes, type_name, type_span, name, own or dimensions or (), arguments or (), binding, condition,
                        description, span, name_span, annotation)
            for name, own, arguments, binding, condition, description, span, name_span, annotation in declarators
        ]

    def declarator(self, meta: Place, children: list[Any]) -> tuple[Any, ...]:
        name, dimensions, arguments, binding, condition, description, annotation = children
        if str(name) in RESERVED:
            self.report.error("L0108", f"'{name}' is a word of the language and cannot be a name", self._span(name))
        return (_name(name), dimensions, arguments, binding, condition, _text(description), self._span(meta),
                self._span(name), annotation[1] if annotation else ())

    def modification(self, meta: Place, children: list[Any]) -> tuple[Argument, ...]:
        return tuple(c for c in children if c is not None)

    def argument(self, meta: Place, children: list[Any]) -> Argument:
        *prefixes, name, arguments, value = children
        return Argument(frozenset(map(str, prefixes)), _name(name), arguments or (), value, self._span(meta),
                        self._span(name))

    # ---------------------------------------------------------------- sections

    def equation_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("equation", tuple(children), self._span(meta))

    def initial_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("initial", tuple(children), self._span(meta))

    def energy_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("energy", tuple(children), self._span(meta))

    def algorithm_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("algorithm", tuple(children), self._span(meta))

    def drawing_section(self, meta: Place, children: list[Any]) -> Section:
        return Section("drawing", tuple(children), self._span(meta))

    def equality(self, meta: Place, children: list[Any]) -> Equality:
        left, right, description = children
        return Equality(left, right, _text(description), self._span(meta))

    def call_equation(self, meta: Place, children: list[Any]) -> CallEquation:
        return CallEquation(children[0], self._span(meta))

    def energy_term(self, meta: Place, children: list[Any]) -> EnergyTerm:
        kind, value, description = children
        return EnergyTerm(cast(EnergyKind, str(kind)), value, _text(description), self._span(meta))

    def work_term(self, meta: Place, children: list[Any]) -> WorkTerm:
        force, position, description = children
        return WorkTerm(force, position, _text(description), self._span(meta))

    def assignment(self, meta: Place, children: list[Any]) -> Assignment:
        target, value = children
        return Assignment(target, value, self._span(meta))

    def for_block(self, meta: Place, children: list[Any]) -> ForBlock:
        return ForBlock(children[0], tuple(children[1:]), self._span(meta))

    def else_if(self, meta: Place, children: list[Any]) -> tuple[Any, ...]:
        return "else if", children[0], tuple(children[1:]), self._span(meta)

    def else_branch(self, meta: Place, children: list[Any]) -> tuple[Any, ...]:
        return "else", tuple(children)

    def if_block(self, meta: Place, children: list[Any]) -> IfBlock:
        condition, *rest = children
        branches = [c for c in rest if isinstance(c, tuple)]
        then = tuple(c for c in rest if c is not None and not isinstance(c, tuple))
        otherwise: tuple[Any, ...] = ()
        for branch in reversed(branches):
            otherwise = branch[1] if branch[0] == "else" else (IfBlock(branch[1], branch[2], otherwise, branch[3]),)
        return IfBlock(condition, then, otherwise, self._span(meta))

    def when_block(self, meta: Place, children: list[Any]) -> WhenBlock:
        return WhenBlock(children[0], tuple(children[1:]), self._span(meta))

    def iterators(self, meta: Place, children: list[Any]) -> tuple[Iterator, ...]:
        return tuple(children)

    def iterator(self, meta: Place, children: list[Any]) -> Iterator:
        return Iterator(_name(children[0]), children[1], self._span(meta))

    # ---------------------------------------------------------------- expressions

    def if_expression(self, meta: Place, children: list[Any]) -> Expression:
        *pairs, otherwise = children
        result: Expression = otherwise
        span = self._span(meta)
        for condition, value in zip(pairs[-2::-2], pairs[-1::-2], strict=True):
            result = IfExpression(condition, value, result, span)
        return result

    def range(self, meta: Place, children: list[Any]) -> Range:
        return Range(children[0], None, children[1], self._span(meta))

    def stepped_range(self, meta: Place, children: list[Any]) -> Range:
        return Range(children[0], children[1], children[2], self._span(meta))

    def chain(self, meta: Place, children: list[Any]) -> Expression:
        if len(children) > 2 * _LONGEST_CHAIN:
            self.report.error("L0102", f"more than {_LONGEST_CHAIN} operands in a row", self._span(meta),
                              "use sum(... for i in 1:n), or name parts of it with variables")
            return cast(Expression, children[0])
        return self._fold(children[0], iter(children[1:]))

    def signed_chain(self, meta: Place, children: list[Any]) -> Expression:
        first = Unary(str(children[0]), children[1], self._span(children[0]).to(children[1].span))
        return self._fold(first, iter(children[2:]))

    @staticmethod
    def _fold(left: Expression, rest: IteratorType[Any]) -> Expression:
        for operator, right in zip(rest, rest, strict=True):
            left = Binary(str(operator), left, right, left.span.to(right.span))
        return left

    def logical_not(self, meta: Place, children: list[Any]) -> Unary[Expression]:
        return Unary("not", children[0], self._span(meta))

    def power(self, meta: Place, children: list[Any]) -> Binary[Expression]:
        return Binary("^", children[0], children[1], self._span(meta))

    def signed_power(self, meta: Place, children: list[Any]) -> Binary[Expression]:
        base, sign, exponent = children
        return Binary("^", base, Unary(str(sign), exponent, exponent.span), self._span(meta))

    def number(self, meta: Place, children: list[Any]) -> Number:
        return self._number(str(children[0]), None, self._span(meta))

    def quantity(self, meta: Place, children: list[Any]) -> Number:
        value, unit = str(children[0])[:-1].split("[")
        return self._number(value.strip(), unit.strip(), self._span(meta))

    def _number(self, text: str, unit: str | None, span: Span) -> Number:
        value = float(text)
        if value == float("inf"):
            from lagrangia.language.expectations import shortened

            self.report.error("L0107", f"{shortened(text)} is too large for a number", span, "the largest is 1.8e308")
        return Number(value, unit, span, text.isdigit())

    def string(self, meta: Place, children: list[Any]) -> String:
        return String(_text(children[0]), self._span(meta))

    def true(self, meta: Place, children: list[Any]) -> Boolean:
        return Boolean(True, self._span(meta))

    def false(self, meta: Place, children: list[Any]) -> Boolean:
        return Boolean(False, self._span(meta))

    def parenthesis(self, meta: Place, children: list[Any]) -> Expression:
        (inner,) = children
        return cast(Expression, inner)

    def array(self, meta: Place, children: list[Any]) -> Array[Expression]:
        return Array(tuple(c for c in children if c is not None), self._span(meta))

    def array_comprehension(self, meta: Place, children: list[Any]) -> Comprehension:
        return Comprehension("", children[0], children[1], self._span(meta))

    def reduction(self, meta: Place, children: list[Any]) -> Comprehension:
        return Comprehension(str(children[0]), children[1], children[2], self._span(meta))

    def call(self, meta: Place, children: list[Any]) -> Call[Expression]:
        function, *arguments = children
        named = tuple(a for a in arguments if isinstance(a, tuple))
        positional = tuple(a for a in arguments if a is not None and not isinstance(a, tuple))
        return Call(str(function), positional, named, self._span(meta))

    def named_argument(self, meta: Place, children: list[Any]) -> tuple[str, Expression]:
        return _name(children[0]), children[1]

    def reference(self, meta: Place, children: list[Any]) -> Reference:
        return Reference(tuple(children), self._span(meta))

    def reference_part(self, meta: Place, children: list[Any]) -> Part:
        return Part(_name(children[0]), children[1] or (), self._span(meta))

    def subscripts(self, meta: Place, children: list[Any]) -> tuple[Expression, ...]:
        return tuple(children)

    def whole(self, meta: Place, children: list[Any]) -> Whole:
        return Whole(self._span(meta))
