"""CasADi scalars with quick operators.

`a * b` on ca.SX looks through every signature that CasADi's Python interface knows: 12 us, where the product itself takes less
than two. ca.SX.binary goes straight to it, and what wraps a ca.SX (`this`) is told from others at once: 1.9 us, not 3.4.
Expressions are ca.SX in every other respect.

What belongs to many alike elements comes as columns, and mostly goes into other columns: Cells stand for the elements, and what
is made of columns of them is indexed. Each becomes an Expression when something is done with it alone.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from itertools import accumulate, repeat
from operator import add, attrgetter
from typing import Any

import casadi as ca

_MOST_CONSTANTS = 10_000  # few numbers stand in many expressions
_NUMBERS = (float, int)
_OPERANDS = (ca.SX, float, int)
_binary, _unary = ca.SX.binary, ca.SX.unary
_THIS, _SOURCE, _PLACE = attrgetter("this"), attrgetter("source"), attrgetter("place")
_FEWEST = 8  # elements of a column that are worth Cells
_MUCH = 2  # times as many elements as are wanted: whole columns are put together at once
_SINGLY = 16  # of so many elements one is looked up alone; more of them are all at once


def _operators(operation: int) -> tuple[Callable[[Any, Any], Any], Callable[[Any, Any], Any]]:
    """The operator and its reflection. What is no number and no ca.SX answers by an operator of its own (Dual)."""
    def forward(self: Any, other: Any) -> Any:
        if other.__class__ is not Expression:
            if not isinstance(other, _OPERANDS):
                return NotImplemented
            other = as_expression(other)
        made = _binary(operation, self.this, other.this)
        made.__class__ = Expression
        return made

    def reflected(self: Any, other: Any) -> Any:
        if not isinstance(other, _OPERANDS):
            return NotImplemented
        made = _binary(operation, as_expression(other).this, self.this)
        made.__class__ = Expression
        return made

    return forward, reflected


class Expression(ca.SX):  # type: ignore[misc]
    """A scalar ca.SX whose operators give Expressions."""

    this: Any  # what is wrapped

    __add__, __radd__ = _operators(ca.OP_ADD)
    __sub__, __rsub__ = _operators(ca.OP_SUB)
    __mul__, __rmul__ = _operators(ca.OP_MUL)
    __truediv__, __rtruediv__ = _operators(ca.OP_DIV)

    def __neg__(self) -> "Expression":
        return apply_to_one(ca.OP_NEG, self)


class _Source:
    """A column whose elements Cells stand for."""

    def __init__(self, column: ca.SX) -> None:
        self.column = column
        self.asked = 0
        self.elements: list[ca.SX] = []

    def wrapped(self, place: int) -> Any:
        """What wraps an element."""
        self.asked += 1
        if not self.elements and self.asked * _SINGLY < self.column.numel():
            return self.column[place].this
        self.elements = self.elements or self.column.elements()
        return self.elements[place].this


class Cell(Expression):
    """An element of a column, which nobody has looked up yet."""

    def __init__(self, source: _Source, place: int) -> None:
        self.source = source
        self.place = place

    def __getattr__(self, name: str) -> Any:
        if name != "this":
            raise AttributeError(name)
        self.this = self.source.wrapped(self.place)
        self.__class__ = Expression
        return self.this


def symbol(name: str) -> Expression:
    """A new symbol."""
    return as_expression(ca.SX.sym(name))


def as_expression(x: Any) -> Expression:
    """A number as an Expression; a ca.SX becomes one."""
    if x.__class__ is ca.SX:
        x.__class__ = Expression
    if x.__class__ is Expression or x.__class__ is Cell:
        return x
    if isinstance(x, _NUMBERS) and x != 0:  # 0.0 and -0.0 are one key
        return _constant(float(x))
    return _wrapped(x)


def column(*values: Any) -> ca.SX:
    """Numbers and expressions, one below the other; (0, 1) of none."""
    kinds = {*map(type, values)} if len(values) >= _FEWEST else {ca.SX}
    if Cell in kinds:
        return _gathered(values)
    if kinds.issubset(_NUMBERS):
        return ca.SX(ca.DM([*values]))
    if not values:
        return ca.SX(0, 1)
    try:
        return _stacked([*map(_THIS, values)])
    except AttributeError:  # of a number
        return _stacked([x.this if isinstance(x, ca.SX) else as_expression(x).this for x in values])


def _stacked(wrapped: Sequence[Any]) -> ca.SX:
    """Of what wraps expressions: CasADi looks at each twice. Scalars beside each other take less than below each other."""
    if len(wrapped) < _FEWEST:
        return ca.vertcat(*wrapped)
    row = ca.horzcat(*wrapped)
    return ca.reshape(row, row.numel(), 1) if row.numel() == len(wrapped) else ca.vertcat(*wrapped)


def _gathered(values: Sequence[Any]) -> ca.SX:
    """A column of which elements of others are a part."""
    own = [x for x in values if x.__class__ is Cell]
    found = _elements(own)
    if len(own) == len(values):
        return found
    others = _stacked([x.this if isinstance(x, ca.SX) else as_expression(x).this for x in values if x.__class__ is not Cell])
    is_own = [x.__class__ is Cell for x in values]
    if all(is_own[len(values) - len(own) :]):
        return ca.vertcat(others, found)
    places, rest = iter(range(len(own))), iter(range(len(own), len(values)))
    return ca.vertcat(found, others)[[next(places if is_cell else rest) for is_cell in is_own]]


def _elements(own: Sequence[Cell]) -> ca.SX:
    """The column of what these stand for."""
    sources, places = [*map(_SOURCE, own)], [*map(_PLACE, own)]
    keys = [*map(id, sources)]
    known = dict(zip(keys, sources, strict=True))
    if len(known) == 1:
        return sources[0].column[places]
    columns = [source.column for source in known.values()]
    ends = [*accumulate(x.numel() for x in columns)]
    if ends[-1] <= _MUCH * len(own):
        begins = dict(zip(known, (0, *ends), strict=False))
        return ca.vertcat(*columns)[[*map(add, map(begins.__getitem__, keys), places)]]
    taken: dict[int, tuple[list[int], list[int]]] = {key: ([], []) for key in known}
    for k, (key, place) in enumerate(zip(keys, places, strict=True)):
        taken[key][0].append(k)
        taken[key][1].append(place)
    parts = ca.vertcat(*[known[key].column[chosen] for key, (_, chosen) in taken.items()])
    order = [k for own_places, _ in taken.values() for k in own_places]
    back = [0] * len(order)
    for k, place in enumerate(order):
        back[place] = k
    return parts[back]


def cells(matrix: ca.SX) -> list[Expression]:
    """The elements of a dense matrix, column by column."""
    count = matrix.numel()
    if count >= _FEWEST and matrix.is_dense():
        return [*map(Cell, repeat(_Source(ca.vec(matrix)), count), range(count))]
    found: list[Expression] = matrix.elements()
    for x in found:
        x.__class__ = Expression
    return found


def scalars_in(column: ca.SX) -> list[Any]:
    """The elements of a dense column: Expressions, and the float 0 for what is identically zero."""
    found: list[Any] = [0.0] * column.numel()
    others = cells(column)
    for k in ca.sparsify(column).row():
        found[k] = others[k]
    return found


def symbols_in(x: ca.SX) -> frozenset[int]:
    """The hashes of the symbols that an expression mentions."""
    return frozenset(map(ca.SX.element_hash, ca.symvar(x)))


def places_in(x: ca.SX, symbols: ca.SX) -> list[set[int]]:
    """Of each row, the places of the symbols that it depends on."""
    found = [set[int]() for _ in range(x.numel())]
    for row, column in zip(*ca.jacobian_sparsity(ca.densify(x), symbols).get_triplet(), strict=True):
        found[row].add(column)
    return found


def apply(operation: int, a: Any, b: Any) -> Any:
    """One of CasADi's OP_... of two operands."""
    if a.__class__ is not Expression:
        a = as_expression(a)
    if b.__class__ is not Expression:
        b = as_expression(b)
    made = _binary(operation, a.this, b.this)
    made.__class__ = Expression
    return made


def apply_to_one(operation: int, x: ca.SX) -> Expression:
    """An operation of CasADi on one argument."""
    made = _unary(operation, x.this)
    made.__class__ = Expression
    return made  # type: ignore[no-any-return]


def operate(operation: int, operands: Sequence[Any]) -> Expression:
    """One of CasADi's OP_... of one operand or two."""
    return as_expression(apply_to_one(operation, *operands) if len(operands) == 1 else apply(operation, *operands))


def _wrapped(x: Any) -> Expression:
    made = ca.SX(x)
    made.__class__ = Expression
    return made  # type: ignore[no-any-return]


_constant = lru_cache(_MOST_CONSTANTS)(_wrapped)
