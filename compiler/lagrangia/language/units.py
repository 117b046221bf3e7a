"""Units and dimensions: "kN/m" -> factor 1000 and dimension kg.s-2.

The radian counts as 1, as in the SI. Source: BIPM, The International System of Units, 9th edition (2019).
"""

import re
from fractions import Fraction
from functools import cache
from operator import add, sub

from lagrangia.base.records import dataclass

_BASES = ("kg", "m", "s", "A", "K", "mol", "cd")
Dimension = tuple[int | Fraction, ...]
ONE: Dimension = (0,) * len(_BASES)


@dataclass(frozen=True, slots=True)
class Unit:
    """A quantity in this unit times `factor` (after adding `offset`) is the quantity in SI."""

    factor: float
    dimension: Dimension
    offset: float = 0.0


_OTHER_SIGNS = str.maketrans({"²": "2", "³": "3", "·": ".", "×": "."})
_OTHER_WORDS = {"sec": "s", "secs": "s", "second": "s", "seconds": "s", "meter": "m", "meters": "m", "newton": "N",
                "newtons": "N", "degree": "deg", "degrees": "deg", "radian": "rad", "radians": "rad", "turn": "rev",
                "turns": "rev", "nms": "N.m.s"}
_FACTORS = ("N", "kN", "kg", "W", "A", "V", "lbf")  # that people write others behind without a dot
_RADIANS_A_SECOND = ("rpm", "rad/s", "deg/s")


def dimension(**powers: int) -> Dimension:
    """From powers of base units, by name."""
    return tuple(powers.get(base, 0) for base in _BASES)


_KG, _M, _S, _A, _K = (dimension(**{base: 1}) for base in _BASES[:5])
_NEWTON = dimension(kg=1, m=1, s=-2)
_JOULE = dimension(kg=1, m=2, s=-2)
_WATT = dimension(kg=1, m=2, s=-3)
_PI = 3.141592653589793

_UNITS = {
    "1": Unit(1, ONE), "m": Unit(1, _M), "g": Unit(1e-3, _KG), "s": Unit(1, _S), "A": Unit(1, _A), "K": Unit(1, _K),
    "mol": Unit(1, dimension(mol=1)), "cd": Unit(1, dimension(cd=1)),
    "rad": Unit(1, ONE), "deg": Unit(_PI / 180, ONE), "°": Unit(_PI / 180, ONE), "rev": Unit(2 * _PI, ONE), "%": Unit(0.01, ONE),
    "N": Unit(1, _NEWTON), "J": Unit(1, _JOULE), "W": Unit(1, _WATT), "Pa": Unit(1, dimension(kg=1, m=-1, s=-2)),
    "Hz": Unit(1, dimension(s=-1)), "rpm": Unit(_PI / 30, dimension(s=-1)),
    "min": Unit(60, _S), "h": Unit(3600, _S), "d": Unit(86400, _S),
    "t": Unit(1000, _KG), "lb": Unit(0.45359237, _KG), "L": Unit(1e-3, dimension(m=3)), "l": Unit(1e-3, dimension(m=3)),
    "inch": Unit(0.0254, _M), "ft": Unit(0.3048, _M), "bar": Unit(1e5, dimension(kg=1, m=-1, s=-2)),
    "in": Unit(0.0254, _M), "yd": Unit(0.9144, _M), "mi": Unit(1609.344, _M), "mph": Unit(0.44704, dimension(m=1, s=-1)),
    "kn": Unit(1852 / 3600, dimension(m=1, s=-1)), "oz": Unit(0.028349523125, _KG), "slug": Unit(14.593902937206364, _KG),
    "lbf": Unit(4.4482216152605, _NEWTON), "ozf": Unit(0.27801385095378125, _NEWTON), "kip": Unit(4448.2216152605, _NEWTON),
    "kgf": Unit(9.80665, _NEWTON), "kp": Unit(9.80665, _NEWTON), "dyn": Unit(1e-5, _NEWTON),
    "hp": Unit(745.6998715822702, _WATT), "PS": Unit(735.49875, _WATT), "eV": Unit(1.602176634e-19, _JOULE),
    "C": Unit(1, dimension(A=1, s=1)), "V": Unit(1, dimension(kg=1, m=2, s=-3, A=-1)),
    "Ohm": Unit(1, dimension(kg=1, m=2, s=-3, A=-2)), "F": Unit(1, dimension(kg=-1, m=-2, s=4, A=2)),
    "H": Unit(1, dimension(kg=1, m=2, s=-2, A=-2)), "Wb": Unit(1, dimension(kg=1, m=2, s=-2, A=-1)),
    "T": Unit(1, dimension(kg=1, s=-2, A=-1)), "degC": Unit(1, _K, 273.15),
}
_PREFIXES = {"q": -30, "r": -27, "y": -24, "z": -21, "a": -18, "f": -15, "p": -12, "n": -9, "u": -6, "µ": -6, "μ": -6, "m": -3,
             "c": -2, "d": -1, "da": 1, "h": 2, "k": 3, "M": 6, "G": 9, "T": 12, "P": 15, "E": 18, "Z": 21, "Y": 24}
_NO_PREFIX = {"1", "deg", "°", "rev", "%", "rpm", "min", "h", "d", "lb", "inch", "ft", "lbf", "degC", "kg",
              "in", "yd", "mi", "mph", "kn", "oz", "slug", "ozf", "kip", "kgf", "kp", "hp", "PS"}
_FACTOR = re.compile(r"(1|[A-Za-z°%µμ]+)(?:\^?([+-]?\d+))?")


@cache
def parse_unit(text: str) -> Unit:
    """The unit written `text`, as "N.m/rad", "kg.m2", "m/s2", "km/h", "1/s", "N.s/(m.rad)".

    Raises ValueError with the part that is not understood.
    """
    compact = text.replace(" ", "").replace("*", ".").replace("·", ".")
    above, *below = compact.split("/")
    if not compact or len(below) > 1:
        raise ValueError(f"'{text}' is not a unit" if not compact else f"'{text}' has more than one '/'; write a/(b.c)")
    result = _product(above)
    if below:
        under = _product(below[0].removeprefix("(").removesuffix(")"))
        result = Unit(result.factor / under.factor, divide(result.dimension, under.dimension))
    return result


def _product(text: str) -> Unit:
    factors = text.split(".")
    if len(factors) == 1 and text in _UNITS:
        return _UNITS[text]
    factor, total = 1.0, ONE
    for part in factors:
        match = _FACTOR.fullmatch(part)
        if match is None:
            raise ValueError(f"'{part}' is not a unit")
        base, exponent = _prefixed(match[1]), int(match[2] or 1)
        factor *= base.factor**exponent
        total = multiply(total, power(base.dimension, exponent))
    return Unit(factor, total)


def _prefixed(name: str) -> Unit:
    if name in _UNITS:
        return _UNITS[name]
    for length in (1, 2):
        prefix, rest = name[:length], name[length:]
        if prefix in _PREFIXES and rest in _UNITS and rest not in _NO_PREFIX:
            unit, exponent = _UNITS[rest], _PREFIXES[prefix]
            if rest == "g":
                exponent -= 3
                return Unit(10.0**exponent, unit.dimension)
            return Unit(unit.factor * 10.0**exponent, unit.dimension)
    raise ValueError(f"'{name}' is not a unit")


def respelled(text: str) -> str:
    """The unit that was meant by m², N·m, m**2, Nm or sec, as it is written here; nothing where none is told from it."""
    plain = text.translate(_OTHER_SIGNS).replace("**", "").replace(" ", "")
    split = (f"{factor}.{plain.removeprefix(factor)}" for factor in _FACTORS if plain.startswith(factor))
    for candidate in (plain, _OTHER_WORDS.get(plain.lower(), ""), *split):
        try:
            parse_unit(candidate)
        except ValueError:
            continue
        return candidate if candidate != text else ""
    return ""


def known_units() -> list[str]:
    """Names of units for hints."""
    return [*sorted(set(_UNITS) - {"1"}), "kg", "mm", "kN"]


def multiply(a: Dimension, b: Dimension) -> Dimension:
    """The dimension of a product."""
    return tuple(map(add, a, b))


def divide(a: Dimension, b: Dimension) -> Dimension:
    """The dimension of a quotient."""
    return tuple(map(sub, a, b))


def per_second(unit: str) -> str:
    """The unit of a rate, as text: m/s -> m/s2, N.m -> N.m/s."""
    above, slash, below = unit.partition("/")
    if not unit or unit == "1":
        return "1/s"
    if not slash:
        return f"{unit}/s"
    return f"{above}/s2" if below == "s" else f"{above}/({below.strip('()')}.s)"


def power(a: Dimension, exponent: int | Fraction) -> Dimension:
    """The dimension of a power."""
    exponent = exponent.numerator if exponent.denominator == 1 else exponent  # fractions are slow
    found = [x * exponent for x in a]
    return tuple(x.numerator if x.denominator == 1 else x for x in found)


_NAMED = {_NEWTON: "N", _JOULE: "J (or N.m)", _WATT: "W", dimension(s=-1): "1/s", dimension(kg=1, s=-2): "N/m",
          dimension(kg=1, s=-1): "N.s/m", _M: "m", _KG: "kg", _S: "s", ONE: "rad (or no unit)"}


def name_of_unit(d: Dimension) -> str:
    """The unit of the SI that a dimension has, as a literal may have it."""
    return spell(d).partition(" (")[0]


def mixes_turns(told: str, wanted: str) -> bool:
    """Whether one counts turns a second and the other radians: SI takes them for the same, 6.28 apart."""
    return (told == "Hz" and wanted in _RADIANS_A_SECOND) or (wanted == "Hz" and told in _RADIANS_A_SECOND)


def spell(d: Dimension) -> str:
    """A dimension as people write it: "N/m", "kg.m2/s"."""
    if d in _NAMED:
        return _NAMED[d]

    def side(sign: int) -> list[str]:
        return [base + ("" if p * sign == 1 else str(p * sign)) for base, p in zip(_BASES, d, strict=True) if p * sign > 0]

    above, below = side(1), side(-1)
    under = below[0] if len(below) == 1 else f"({'.'.join(below)})"
    return (".".join(above) or "1") + (f"/{under}" if below else "")
