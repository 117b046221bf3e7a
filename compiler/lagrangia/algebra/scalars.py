"""CasADi scalars with quick operators.

`a * b` on ca.SX looks through every signature that CasADi's Python interface knows: 12 us, where the product itself takes less
than two. ca.SX.binary goes straight to it, and what wraps a ca.SX (`this`) is told from others at once: 1.9 us, not 3.4.
Expressions are ca.SX in every other respect.
"""

from collections.abc import Callable, Sequence
from functools import lru_cache
from operator import attrgetter
from typing import Any

import casadi as ca

_MOST_CONSTANTS = 10_000  # few numbers stand in many expressions
_NUMBERS = (float, int)
_OPERANDS = (ca.SX, float, int)
_binary, _unary = ca.SX.binary, ca.SX.unary
_THIS = attrgetter("this")


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


def symbol(name: str) -> Expression:
    """A new symbol."""
    return as_expression(ca.SX.sym(name))


def as_expression(x: Any) -> Expression:
    """A number as an Expression; a ca.SX becomes one."""
    if x.__class__ is ca.SX:
        x.__class__ = Expression
    if x.__class__ is Expression:
        return x
    if isinstance(x, _NUMBERS) and x != 0:  # 0.0 and -0.0 are one key
        return _constant(float(x))
    return _wrapped(x)


def column(*values: Any) -> ca.SX:
    """Numbers and expressions, one below the other; (0, 1) of none. Of what wraps expressions, CasADi looks at each twice."""
    if not values:
        return ca.SX(0, 1)
    try:
        return ca.vertcat(*map(_THIS, values))
    except AttributeError:  # of a number
        return ca.vertcat(*(x.this if isinstance(x, ca.SX) else as_expression(x).this for x in values))


def scalars_in(column: ca.SX) -> list[Any]:
    """The elements of a column: Expressions, and the float 0 for what is identically zero."""
    return [0.0 if x.is_zero() else as_expression(x) for x in column.elements()]


def symbols_in(x: ca.SX) -> frozenset[int]:
    """The hashes of the symbols that an expression mentions."""
    return frozenset(s.__hash__() for s in ca.symvar(x))


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
