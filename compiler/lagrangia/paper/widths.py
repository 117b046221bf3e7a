"""Layout -> how wide it is when typeset, in half ems: about as many as the columns that a terminal needs.

By the letters of Computer Modern and TeX's spaces; the fonts of browsers are like them within a tenth.
"""

from lagrangia.paper.layout import (
    LETTERS,
    Apply,
    Bracket,
    Cases,
    Grid,
    Listing,
    Name,
    Node,
    Numeral,
    Pieces,
    Power,
    Product,
    Quotient,
    Relation,
    Root,
    Slope,
    Total,
    Words,
)
from lagrangia.paper.typeset import decimal, is_loose

_WIDE, _WIDE_LETTER, _LETTER, _DIGIT = "mwMW", 1.9, 1.2, 1.0
_BRACKETS, _TALL_BRACKETS, _GAP, _SIGN, _BAR = 1.6, 2.4, 0.34, 2.5, 0.5
_SMALL = 0.72  # of indices and exponents
_COLUMN_GAP = 1.9  # of matrices


def typeset_width(node: Node) -> float:
    """Of a formula in display style, half ems."""
    match node:
        case Name(base, sub, _, argument, is_bold, prefix):
            inner = 1.0 if base in LETTERS else _letters(base)
            below = _SMALL * sum(_letters(part) if part not in LETTERS else _LETTER for part in sub.split())
            return inner * (1.15 if is_bold else 1) + below + 1.1 * len(prefix) + (_BRACKETS + 0.8 if argument else 0.0)
        case Words(words):
            return 1.0 * len(words)
        case Numeral(value, digits):
            if digits:
                return _DIGIT * len(decimal(value, digits)) + 1
            if value.denominator == 1:
                return _digits(value.numerator)
            return _SMALL * max(_digits(value.numerator), _digits(value.denominator)) + _BAR
        case Product(items):
            return sum(map(_factor, items)) + _GAP * (len(items) - 1)
        case Total(items):
            signs = sum(_SIGN for _ in items[1:]) + (_SIGN if items and items[0][0] < 0 else 0)
            return signs + sum(typeset_width(item) for _, item in items)
        case Quotient(top, bottom):
            return max(typeset_width(top), typeset_width(bottom)) + _BAR
        case Power(base, exponent):
            return _tight(base) + _SMALL * typeset_width(exponent)
        case Apply(function, argument, power):
            if function == "abs":
                return typeset_width(argument) + 1.2
            inside = typeset_width(argument) + (0 if isinstance(argument, Name | Bracket | Listing) else _brackets(argument))
            return 1.0 * len(function) + _GAP + inside + (_SMALL if power != 1 else 0)
        case Root(inside):
            return typeset_width(inside) + 2
        case Bracket(inside):
            return typeset_width(inside) + _brackets(inside)
        case _:
            return _large(node)


def _large(node: Node) -> float:
    match node:
        case Listing(items):
            return sum(map(typeset_width, items)) + 1.2 * len(items) + _BRACKETS
        case Grid(rows):
            columns = [max(map(typeset_width, column)) for column in zip(*rows, strict=True)]
            return sum(columns) + _COLUMN_GAP * (len(columns) - 1) + _TALL_BRACKETS
        case Cases(items):
            values = max(typeset_width(value) for value, _ in items)
            return values + max(typeset_width(when) + 4 if when is not None else 9 for _, when in items) + _TALL_BRACKETS + 2
        case Slope(top, bottom, is_total):
            return max(typeset_width(top) if top is not None else 0.0, typeset_width(bottom)) + (1.1 if is_total else 1.2) + _BAR
        case Relation(left, right):
            return typeset_width(left) + typeset_width(right) + _SIGN
        case Pieces(items):
            return sum(typeset_width(item) + _SIGN * len(sign.split()) for sign, item in items)
        case _:
            raise AssertionError(node)


def _letters(text: str) -> float:
    return sum(_WIDE_LETTER if c in _WIDE else _DIGIT if c.isdigit() else _LETTER for c in text)


def _digits(number: int) -> float:
    return _DIGIT * len(str(abs(number)))


def _brackets(inside: Node) -> float:
    return _TALL_BRACKETS if is_tall(inside) else _BRACKETS


def is_tall(node: Node) -> bool:
    """Whether it is clearly taller than letters: more than the small fraction of a number."""
    match node:
        case Quotient() | Grid() | Cases() | Slope() | Root():
            return True
        case Product(items) | Listing(items):
            return any(map(is_tall, items))
        case Total(items) | Pieces(items):
            return any(is_tall(item) for _, item in items)
        case Power(base, exponent) | Relation(base, exponent):
            return is_tall(base) or is_tall(exponent)
        case Bracket(inside) | Apply(_, inside):
            return is_tall(inside)
        case _:
            return False


def _factor(node: Node) -> float:
    return typeset_width(node) + (_brackets(node) if isinstance(node, Total) else 0)


def _tight(node: Node) -> float:
    return typeset_width(node) + (_brackets(node) if is_loose(node) else 0)
