"""Values on the command line: `2`, `1.5[kN/m]`, `30[deg]`, `{0, -1.62}`."""

import math

from lagrangia.base.spelling import read_number
from lagrangia.language.units import ONE, mixes_turns, parse_unit, spell


def read_value(text: str, unit: str | None) -> float | list[float]:
    """The value in SI units. Raises ValueError when it is none, or its unit does not fit `unit`: "" where nothing says one, and
    there are only numbers, as 30[deg] and 50[%] are; None where another one looks at units."""
    text = text.strip()
    if text.startswith("{"):
        if not text.endswith("}"):
            raise ValueError("a '}' is missing")
        return [_scalar(part, unit) for part in text[1:-1].split(",")]
    return _scalar(text, unit)


def _scalar(text: str, unit: str | None) -> float:
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
    if unit == "" and found.dimension != ONE:
        raise ValueError(f"it is in {spell(found.dimension)}, but no unit is declared: write the number alone")
    if unit and found.dimension != (wanted := parse_unit(unit).dimension):
        raise ValueError(f"it is in {spell(found.dimension)}, but {spell(wanted)} is wanted")
    if unit and mixes_turns(given[:-1], unit):
        raise ValueError(f"turns and radians a second are 6.28 apart, and {unit} is wanted")
    return value * found.factor + found.offset
