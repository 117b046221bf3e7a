"""Expressions of a text -> nodes of the syntax tree, one method for each rule of the grammar."""

import re
from collections.abc import Sequence
from typing import Any, cast

from lagrangia.base.diagnostics import Report, Source, Span
from lagrangia.base.spelling import plain_text
from lagrangia.language.reader import Place, Word
from lagrangia.language.tree import (
    Array,
    Binary,
    Boolean,
    Call,
    Comprehension,
    Expression,
    IfExpression,
    Last,
    Matrix,
    Number,
    Part,
    Range,
    Reference,
    Results,
    String,
    Unary,
    Whole,
)

_LONGEST_CHAIN = 2000  # operands in one unbracketed sum or product

_ESCAPED = re.compile(r'\\(["\\nt])')
_UNESCAPES = {"n": "\n", "t": "\t"}


def text_of(token: Word | None) -> str:
    """What a text in quotes says; "" for none."""
    if token is None:
        return ""
    return plain_text(_ESCAPED.sub(lambda found: _UNESCAPES.get(found[1], found[1]), str(token)[1:-1]))


def name_of(token: Word) -> str:
    """A quoted name 'a b' stands for itself without the quotes."""
    return plain_text(str(token))


class _ExpressionNodes:
    """One method a rule; children come in the order of the grammar, None for an absent [part]."""

    def __init__(self, source: Source) -> None:
        self.source = source
        self.report = Report()

    def _span(self, meta: Place | Word) -> Span:
        return Span(self.source, meta.start_pos, meta.end_pos)

    def _between(self, first: Span, last: Span) -> Span:
        return self._span(Place(first.start, max(first.end, last.end)))

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
        return self._fold(children[0], children[1:], self._span(meta))

    def signed_chain(self, meta: Place, children: list[Any]) -> Expression:
        whole = self._span(meta)
        span = self._between(self._span(children[0]), children[1].span) if children[2:] else whole
        first = Unary(str(children[0]), children[1], span)
        return self._fold(first, children[2:], whole)

    def _fold(self, left: Expression, rest: Sequence[Any], whole: Span) -> Expression:
        """The last one stands in the whole, with the brackets that it begins and ends with."""
        for k in range(0, len(rest), 2):
            operator, right = rest[k : k + 2]
            left = Binary(str(operator), left, right, self._between(left.span, right.span) if k < len(rest) - 2 else whole)
        return left

    def logical_not(self, meta: Place, children: list[Any]) -> Unary[Expression]:
        return Unary("not", children[0], self._span(meta))

    def power(self, meta: Place, children: list[Any]) -> Binary[Expression]:
        base, operator, exponent = children
        return Binary(str(operator), base, exponent, self._span(meta))

    def signed_power(self, meta: Place, children: list[Any]) -> Binary[Expression]:
        base, operator, sign, exponent = children
        return Binary(str(operator), base, Unary(str(sign), exponent, exponent.span), self._span(meta))

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
        return String(text_of(children[0]), self._span(meta))

    def true(self, meta: Place, children: list[Any]) -> Boolean:
        return Boolean(True, self._span(meta))

    def false(self, meta: Place, children: list[Any]) -> Boolean:
        return Boolean(False, self._span(meta))

    def parenthesis(self, meta: Place, children: list[Any]) -> Expression:
        (inner,) = children
        return cast(Expression, inner)

    def results(self, meta: Place, children: list[Any]) -> Results:
        return Results(tuple(children), self._span(meta))

    def matrix(self, meta: Place, children: list[Any]) -> Matrix:
        return Matrix(tuple(children), self._span(meta))

    def matrix_row(self, meta: Place, children: list[Any]) -> tuple[Expression, ...]:
        return tuple(children)

    def last(self, meta: Place, children: list[Any]) -> Last:
        return Last(self._span(meta))

    def array(self, meta: Place, children: list[Any]) -> Array[Expression]:
        return Array(tuple(c for c in children if c is not None), self._span(meta))

    def array_comprehension(self, meta: Place, children: list[Any]) -> Comprehension:
        return Comprehension("", children[0], children[1], self._span(meta))

    def reduction(self, meta: Place, children: list[Any]) -> Comprehension:
        return Comprehension(_called(children[0]), children[1], children[2], self._span(meta))

    def call(self, meta: Place, children: list[Any]) -> Call[Expression]:
        function, *arguments = children
        named = tuple(a for a in arguments if isinstance(a, tuple))
        positional = tuple(a for a in arguments if a is not None and not isinstance(a, tuple))
        return Call(_called(function), positional, named, self._span(meta))

    def named_argument(self, meta: Place, children: list[Any]) -> tuple[str, Expression]:
        return name_of(children[0]), children[1]

    def reference(self, meta: Place, children: list[Any]) -> Reference:
        return Reference(tuple(children), self._span(meta))

    def reference_part(self, meta: Place, children: list[Any]) -> Part:
        return Part(name_of(children[0]), children[1] or (), self._span(meta))

    def subscripts(self, meta: Place, children: list[Any]) -> tuple[Expression, ...]:
        return tuple(children)

    def whole(self, meta: Place, children: list[Any]) -> Whole:
        return Whole(self._span(meta))


def _called(function: Reference) -> str:
    """The name of a function; spaces and comments may stand about its dots."""
    return str(function) if any(part.subscripts for part in function.parts) else ".".join(part.name for part in function.parts)
