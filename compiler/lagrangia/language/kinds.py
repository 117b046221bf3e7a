"""What variables that are known when the scene is compiled may be."""

from lagrangia.base.diagnostics import fail
from lagrangia.language.classes import ENUMERATION
from lagrangia.language.instances import Slot
from lagrangia.language.tree import Array, Boolean, EnumerationLiteral, Flat, Number, String


def require_kind(slot: Slot, value: Flat) -> None:
    """Of what is known when the scene is compiled. Raises LagError L0210."""
    if isinstance(value, Array):
        for item in value.items:
            require_kind(slot, item)
        return
    wanted = {"Integer": "an integer", "Boolean": "true or false", "String": "a text",
              ENUMERATION: f"a value of {slot.enumeration}"}.get(slot.base, "a number")
    good = {"Integer": isinstance(value, Number) and value.value.is_integer(), "Boolean": isinstance(value, Boolean),
            "String": isinstance(value, String), ENUMERATION: isinstance(value, EnumerationLiteral)
            and value.type_name == slot.enumeration}.get(slot.base, isinstance(value, Number))
    if not good:
        what = f", not {value.value:g}" if isinstance(value, Number) else ""
        fail("L0210", f"'{slot.path}' must be {wanted}{what}", value.span)
