"""Loops, unrolled: the values that iterators take."""

from collections.abc import Iterable, Sequence
from math import floor, prod
from typing import Any, Protocol

from lagrangia.base.diagnostics import Diagnostic, LagError, Span, TooMuchError, fail
from lagrangia.base.records import dataclass
from lagrangia.language.elements import element, length
from lagrangia.language.enumerations import Enumerations, from_to
from lagrangia.language.folding import fold
from lagrangia.language.implied_ranges import sizes_asked
from lagrangia.language.instances import Scope, StructuralValues
from lagrangia.language.mentions import children
from lagrangia.language.tree import (
    Assignment,
    Binary,
    Call,
    Comprehension,
    EnumerationLiteral,
    Expression,
    Flat,
    ForBlock,
    IfBlock,
    Iterator,
    Number,
    Range,
    Ref,
    Reference,
    Results,
    Unary,
    WhileBlock,
)
from lagrangia.language.units import name_of_unit, parse_unit
from lagrangia.language.units_written import dimension_of_known

_ONE_UNIT = "write: 0[m]:0.5[m]:2[m]"
_UNROLLED = "the loops and sums of this model unroll to"
_MOST_ITERATIONS = 100_000  # of one loop
_MOST_OPERATIONS = 300_000  # of all loops of a model, each times the clauses in it: some 10 us each
_SLACK = 1e-9  # of a step: 0:0.1:0.3 has four values, though 0.3/0.1 is a little less than 3


@dataclass
class Work:
    """How many clauses, elements, and operations of functions the loops of a model were unrolled to."""

    operations: int = 0

    def foresee(self, count: int, span: Span) -> None:
        """Raises TooMuchError L0209 where so many more operations would be too many."""
        Work(self.operations).spend(count, span)

    def spend(self, count: int, span: Span, how: str = _UNROLLED, hint: str = "those inside each other multiply") -> None:
        """Raises TooMuchError L0209 before more is unrolled than can be looked at in good time."""
        self.operations += count
        if self.operations > _MOST_OPERATIONS:
            what = f"{how} more than {_MOST_OPERATIONS} operations"
            raise TooMuchError([Diagnostic("error", "L0209", what, span, "", (hint,))])


class Loops(Enumerations, StructuralValues, Protocol):
    """What runs over iterators, of names.py."""

    work: Work

    def flatten(self, node: Expression, scope: Scope) -> Flat:
        """An expression with full names. Raises LagError."""

    def number(self, expression: Expression, scope: Scope, what: str) -> float:
        """The number that an expression must be. Raises LagError L0210."""

    def size(self, ref: Ref) -> int | None:
        """Of the next dimension of a variable; None where it has none."""

    def loop(self, iterators: tuple[Iterator, ...], scope: Scope, body: Sequence[Any]) -> Iterable[Scope]:
        """The scopes of all passes of a loop over clauses or expressions, the last iterator running fastest. Raises LagError
        L0209, L0214."""
        scopes = [scope]
        for iterator in iterators:
            passes: list[Scope] = []
            for outer in scopes:
                passes += [outer.bind(iterator.name, value) for value in self._passes(iterator, outer, body)]
                if len(passes) > _MOST_ITERATIONS:
                    fail("L0209", f"a loop of more than {_MOST_ITERATIONS} passes", iterator.span)
            scopes = passes
        names = frozenset(iterator.name for iterator in iterators) | _given(body)
        ahead = sum(self._foreseen(part, scopes[0], names) for part in body) if scopes else 0
        self.work.foresee(len(scopes) * ahead, iterators[0].span)
        self.work.spend(len(scopes) * len(body), iterators[0].span)
        return scopes

    def _foreseen(self, node: Any, scope: Scope, names: frozenset[str]) -> int:
        """At least how many clauses or terms one inside a loop is unrolled to, by ranges in it that do not follow from `names`,
        of the iterators around it."""
        if isinstance(node, Binary | Unary | Call):
            return max(1, sum(self._foreseen(part, scope, names) for part in children(node) if _may_unroll(part)))
        if not isinstance(node, ForBlock | Comprehension):
            return 1
        ranges = [iterator.range for iterator in node.iterators]
        inside = names.union(iterator.name for iterator in node.iterators)
        if not all(isinstance(r, Range) and all(_is_free(end, inside) for end in (r.start, r.stop, r.step)) for r in ranges):
            return 1
        try:
            passes = prod(len(self._range(r, scope)) for r in ranges if isinstance(r, Range))
        except LagError:  # told at its place
            return 1
        body = node.body if isinstance(node, ForBlock) else (node.body,)
        return passes * sum(self._foreseen(part, scope, inside) for part in body)

    def _passes(self, iterator: Iterator, scope: Scope, body: Sequence[Any]) -> Sequence[int | Flat]:
        if iterator.range is not None:
            return self._values(iterator.range, scope)
        asked = sizes_asked(iterator.name, body, iterator.span)
        counts = {self.integer(size, scope, "a size"): size for size in asked}
        if not counts:
            fail("L0214", f"the range of '{iterator.name}' is missing, and it picks no element of an array alone", iterator.span,
                 "write: for i in 1:n")
        if len(counts) > 1:
            fail("L0214", f"the range of '{iterator.name}' is missing, and it picks elements of arrays of "
                 f"{' and '.join(map(str, sorted(counts)))}", iterator.span, "write: for i in 1:n")
        return range(1, next(iter(counts)) + 1)

    def _values(self, node: Expression, scope: Scope) -> Sequence[int | Flat]:
        """Of a range, an enumeration, or the elements of an array: integers as such, where they are known. Raises LagError
        L0214."""
        if isinstance(node, Range):
            return self._range(node, scope)
        if isinstance(node, Reference) and (literals := self.literals(node)):
            return literals
        flat = self.flatten(node, scope)
        count = length(flat, self.size)
        if count is None:
            fail("L0214", "a loop runs over a range, an enumeration or an array", node.span, "write: for i in 1:n")
        items = [element(flat, k, self.size) for k in range(1, count + 1)]
        if items and length(items[0], self.size) is not None:
            fail("L0214", "a loop runs over an array of one dimension, not over a matrix", node.span,
                 "run over its rows: for i in 1:size(A, 1)")
        whole = [_whole(item) for item in items]
        return items if None in whole else [k for k in whole if k is not None]

    def _range(self, node: Range, scope: Scope) -> Sequence[int | Flat]:
        """Raises LagError L0209, L0210, L0214."""
        parts = [end for end in (node.start, node.stop, node.step) if end is not None]
        ends = [self.flatten(end, scope) for end in parts]
        if isinstance(ends[0], EnumerationLiteral) and node.step is None:
            return from_to(ends[0], ends[1])
        values = [self.number(end, scope, "the end of a range") for end in (node.start, node.stop)]
        unit = _unit_of(parts, ends, node.span)
        step = 1.0 if unit is None else parse_unit(unit).factor
        if node.step is not None:
            step = self.number(node.step, scope, "the step of a range")
        if step == 0 or (values[1] - values[0]) / step > _MOST_ITERATIONS:
            fail("L0209", f"a range of more than {_MOST_ITERATIONS} values", node.span)
        count = max(0, floor((values[1] - values[0]) / step + _SLACK) + 1)
        if unit is None and values[0].is_integer() and step.is_integer():
            return range(int(values[0]), int(values[0]) + count * int(step), int(step))
        return [Number(values[0] + k * step, unit, node.span) for k in range(count)]


def _unit_of(parts: Sequence[Expression], ends: Sequence[Flat], span: Span) -> str | None:
    """The unit that the ends and the step of a range have, where one has any: `parts` as written and `ends` as they are known.
    0 takes that of the others; so does another bare number, in SI units, beside names alone: beside a literal with its unit it
    may be meant in that. Raises LagError L0210 where it is not one."""
    in_place = all(isinstance(part, Reference) or (_is_literal(part) and _written(part) is None) for part in parts)
    bare = [end for part, end in zip(parts, ends, strict=True)
            if dimension_of_known(end) is None and fold(end) != 0 and not (in_place and _is_literal(part))]
    dimensions = {found for end in ends if (found := dimension_of_known(end)) is not None}
    written = {unit for end in ends if (unit := _written(end)) is not None}
    if len(dimensions) > 1 or (len(written) > 1 and len(ends) < 3) or (dimensions and bare):
        fail("L0210", "the ends and the step of a range have one unit", span, _ONE_UNIT)
    if not dimensions:
        return None
    return next(iter(written)) if len(written) == 1 else name_of_unit(next(iter(dimensions)))


def _given(body: Sequence[Any]) -> frozenset[str]:
    """Names of variables that clauses of an algorithm give values."""
    found = set[str]()
    for clause in body:
        if isinstance(clause, Assignment):
            targets = clause.target.items if isinstance(clause.target, Results) else (clause.target,)
            found |= {target.parts[0].name for target in targets if isinstance(target, Reference)}
        elif isinstance(clause, ForBlock | WhileBlock):
            found |= _given(clause.body)
        elif isinstance(clause, IfBlock):
            found |= _given((*clause.then, *clause.otherwise))
    return frozenset(found)


def _may_unroll(node: Any) -> bool:
    return isinstance(node, Comprehension | Binary | Unary | Call)


def _is_free(node: Any, names: frozenset[str]) -> bool:
    """Whether an end of a range is a number, or follows from plain names that are none of these."""
    if isinstance(node, Binary | Unary):
        return all(_is_free(part, names) for part in children(node))
    if isinstance(node, Reference):
        return len(node.parts) == 1 and not node.parts[0].subscripts and node.parts[0].name not in names
    return node is None or isinstance(node, Number)


def _is_literal(node: Expression) -> bool:
    return isinstance(node.operand if isinstance(node, Unary) else node, Number)


def _written(node: Expression | Flat) -> str | None:
    """The unit of a number, also of a negative one."""
    if isinstance(node, Unary):
        return _written(node.operand)
    return node.unit if isinstance(node, Number) else None


def _whole(item: Flat) -> int | None:
    """The integer that a value is, where it is known and has no unit; else None."""
    known = fold(item) if isinstance(item, Number) and not item.unit else None
    return int(known) if known is not None and not isinstance(known, bool) and float(known).is_integer() else None
