"""Units as they are written in a text, told where they are wrong."""

from lagrangia.base.diagnostics import Span, fail, nearest
from lagrangia.language.tree import Number
from lagrangia.language.units import Unit, known_units, parse_unit, respelled


def read_unit(text: str, span: Span) -> Unit:
    """Raises LagError L0301."""
    try:
        return parse_unit(text)
    except ValueError as error:
        near = nearest(text, known_units()) or ""
        near = near if near.lower() == text.lower() else respelled(text) or near
        habit = "units are written as in the SI: m, mm, kg, kN/m, deg, rad/s, N.m"
        fail("L0301", str(error), span, f"did you mean '{near}'?" if near else habit)


def in_si(node: Number) -> Number:
    """A literal in SI units. Raises LagError L0301."""
    if node.unit is None:
        return node
    unit = read_unit(node.unit, node.span)
    return Number(node.value * unit.factor + unit.offset, node.unit, node.span, False)
