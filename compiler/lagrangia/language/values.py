"""Values on the command line: `2`, `1.5[kN/m]`, `30[deg]`, `{0, -1.62}`."""

import math

from lagrangia.base.spelling import read_number
from lagrangia.language.units import ONE, parse_unit, spell


def read_value(text: str, unit: str) -> float | list[float]:
    """The value in SI units. Raises ValueError when it is none, or its unit does not fit `unit`."""
    text = text.strip()
    if text.startswith("{"):
        if not text.endswith("}"):
            raise ValueError("a '}' is missing")
        return [_scalar(part, unit) for part in text[1:-1].split(",")]
    return _scalar(text, unit)


def _scalar(text: str, unit: str) -> float:
    number, bracket, given = text.strip().partition("[")
    try:
        value = read_number(number)
    except ValueError:
        raise ValueError(f"'{text.strip()}' is no number") from None
    if not math.isfinite(value):
        raise ValueError("a finite number is needed")
    if not bracket:
        return value
    if not given.endswith("]"):
        raise ValueError("a ']' is missing")
    found = parse_unit(given[:-1])
    wanted = parse_unit(unit).dimension if unit else ONE
    if unit and found.dimension != wanted:
        raise ValueError(f"it is in {spell(found.dimension)}, but {spell(wanted)} is wanted")
    return value * found.factor + found.offset
