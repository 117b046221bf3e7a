"""What is known of the dimensions of values, and of their products and quotients."""

from functools import cache

from lagrangia.base.records import dataclass
from lagrangia.language.tree import Flat, Number
from lagrangia.language.units import ONE, Dimension, divide, multiply, name_of_unit, parse_unit, spell


@dataclass(frozen=True, slots=True)
class Quantity:
    """What is known of a value: its dimension (None: any), and whether it gives way to another one."""

    dimension: Dimension | None
    is_soft: bool = False

    def spell(self) -> str:
        """Its unit for people."""
        return "any unit" if self.dimension is None else spell(self.dimension)


ANY = Quantity(None)
PURE = Quantity(ONE)


@cache
def in_unit(unit: str) -> Quantity:
    """What is declared in it."""
    return Quantity(parse_unit(unit).dimension)


def fits(found: Quantity, wanted: Dimension) -> bool:
    """Whether a value may stand where a dimension is wanted."""
    return found.dimension is None or found.is_soft or found.dimension == wanted


def times(a: Quantity, b: Quantity) -> Quantity:
    """Of a product."""
    if a.dimension is None or b.dimension is None:
        known = a.dimension if a.dimension is not None else b.dimension
        return ANY if known is None else Quantity(known, True)
    return Quantity(multiply(a.dimension, b.dimension), a.is_soft or b.is_soft)


def over(a: Quantity, b: Quantity, divisor: Flat) -> Quantity:
    """Of a quotient."""
    if isinstance(divisor, Number) and divisor.unit is None and divisor.is_integer:
        return a
    if b.dimension is None:
        return ANY if a.dimension is None else Quantity(a.dimension, True)
    return times(a, Quantity(divide(ONE, b.dimension), b.is_soft))


def unit_told(known: Quantity) -> str:
    """The unit that it is in for sure, as a declaration has it; "" where another one would do as well."""
    d = known.dimension
    is_sure = d is not None and not known.is_soft and all(isinstance(p, int) for p in d)
    return name_of_unit(d) if is_sure and d is not None and d != ONE else ""
