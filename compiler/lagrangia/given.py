"""What Python code gives by name: numbers, counts and mappings, or a diagnostic in place of a TypeError deep below."""

import operator
from collections.abc import Mapping
from typing import Any

from lagrangia.diagnostics import fail


def a_number(what: str, value: Any) -> float:
    """Of anything that is one, NumPy's too. Raises LagError L0702."""
    if not isinstance(value, str | bytes | bool):
        try:
            return float(value)
        except (TypeError, ValueError, OverflowError):
            pass
    fail("L0702", f"the {what} must be a number, not {value!r}"[:200])


def a_count(what: str, value: Any) -> int:
    """Raises LagError L0702."""
    if not isinstance(value, bool):
        try:
            return operator.index(value)
        except TypeError:
            pass
    fail("L0702", f"the {what} must be a whole number, not {value!r}"[:200])


def by_name(what: str, given: Any) -> Mapping[str, Any]:
    """Nothing given is nothing. Raises LagError L0702."""
    if given is None:
        return {}
    if not isinstance(given, Mapping):
        fail("L0702", f"the {what} must be a mapping of names to values, not {given!r}"[:200])
    for name in given:
        if not isinstance(name, str):
            fail("L0702", f"the {what} must have names, not {name!r}"[:200])
    return given
