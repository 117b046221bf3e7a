"""Units as they are written in a text, told where they are wrong."""

from lagrangia.base.diagnostics import Span, fail, nearest
from lagrangia.language.folding import fold
from lagrangia.language.tree import Array, Binary, Call, Flat, Number, Unary
from lagrangia.language.units import (
    ONE,
    Dimension,
    Unit,
    divide,
    known_units,
    multiply,
    name_of_unit,
    parse_unit,
    power,
    respelled,
)


def read_unit(text: str, span: Span) -> Unit:
    """Raises LagError L0301."""
    try:
        return parse_unit(text)
    except ValueError as error:
        near = nearest(text, known_units()) or ""
        near = near if near.lower() == text.lower() else respelled(text) or near
        habit = "units are written as in the SI: m, mm, kg, kN/m, deg, rad/s, N.m"
        fail("L0301", str(error), span, f"did you mean '{near}'?" if near else habit)


def read_own_unit(text: str, span: Span) -> Unit:
    """The unit that a variable is declared in, in which its numbers are. Raises LagError L0301 for one that is not of the SI."""
    unit = read_unit(text, span)
    if unit.factor != 1 or unit.offset != 0:
        own = name_of_unit(unit.dimension) if unit.dimension != ONE else "1" if text == "%" else "rad"
        fail("L0301", f"the numbers of a variable are in SI units, not in {text}", span,
             f'write: unit = "{own}", displayUnit = "{text}"; and values with their unit, as 3[{text}]')
    return unit


def in_si(node: Number) -> Number:
    """A literal in SI units. Raises LagError L0301."""
    if node.unit is None:
        return node
    unit = read_unit(node.unit, node.span)
    return Number(node.value * unit.factor + unit.offset, node.unit, node.span, False)


def dimension_of_known(node: Flat) -> Dimension | None:
    """Of an expression of numbers; None where none of them has a unit."""
    match node:
        case Number(_, unit) if unit is not None:
            return parse_unit(unit).dimension
        case Unary(_, operand):
            return dimension_of_known(operand)
        case Call("abs" | "min" | "max" | "sum" | "floor" | "ceil", (first, *_)):
            return dimension_of_known(first)
        case Array((first, *_)):
            return dimension_of_known(first)
        case Binary("+" | "-", left, right):
            return dimension_of_known(left) or dimension_of_known(right)
        case Binary("*" | "/" as operator, left, right):
            a, b = dimension_of_known(left), dimension_of_known(right)
            if a is None and b is None:
                return None
            one = parse_unit("1").dimension
            return (multiply if operator == "*" else divide)(a or one, b or one)
        case Binary("^", base, exponent) if (found := dimension_of_known(base)) is not None:
            known = fold(exponent)
            return power(found, int(known)) if known is not None and float(known).is_integer() else None
    return None
