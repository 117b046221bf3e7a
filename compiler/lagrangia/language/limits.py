"""The least and the largest value that a declaration allows: min and max."""

import operator

from lagrangia.base.diagnostics import fail
from lagrangia.language.folding import fold
from lagrangia.language.instances import Slot
from lagrangia.language.names import Names
from lagrangia.language.tree import Array, Flat, Number

_BEYOND = (("min", "less than its minimum", operator.lt), ("max", "more than its maximum", operator.gt))


def read_limit(names: Names, slot: Slot, attribute: str) -> float | None:
    """A number, or None where there is no limit. Raises LagError L0208."""
    bound = slot.attributes.get(attribute)
    if bound is None:
        return None
    value = fold(names.flatten_bound(bound))
    if value is None or isinstance(value, bool):
        fail("L0208", f"'{attribute}' must be a number", bound.expression.span)
    return float(value)


def require_within(names: Names, slot: Slot, value: Flat) -> None:
    """Of a structural number, which no run can change, or of each in an array. Raises LagError L0605."""
    kind = "constant" if "constant" in slot.declaration.prefixes else "parameter"
    for attribute, words, is_beyond in _BEYOND:
        limit = read_limit(names, slot, attribute)
        for item in value.items if isinstance(value, Array) else (value,):
            if limit is not None and isinstance(item, Number) and is_beyond(item.value, limit):
                fail("L0605", f"the {kind} '{slot.path}' is {item.value:g}, {words} {limit:g}", item.span,
                     f"declared at {slot.declaration.name_span}")
