"""Expressions that are parabolas in one quantity: time*(2 - time)."""

from collections.abc import Iterable

from lagrangia.language.events import are_alike
from lagrangia.language.folding import fold
from lagrangia.language.mentions import leaves
from lagrangia.language.tree import Binary, Flat, Unary

Coefficients = tuple[float, float, float]  # c, b, a of c + b x + a x^2
_SAME = 1e-14  # relative: of products of coefficients


def touches_zero(node: Flat) -> int:
    """1 for a parabola that is above 0 but for its lowest place, which is 0; -1 for one below; 0 for anything else."""
    named = leaves([node], {})
    if not named or not all(are_alike(named[0], other) for other in named):
        return 0
    found = _coefficients(node, named[0])
    if found is None or found[2] == 0:
        return 0
    c, b, a = found
    is_double = abs(b*b - 4*a*c) <= _SAME * (b*b + abs(4*a*c))
    return (1 if a > 0 else -1) if is_double else 0


def _coefficients(node: Flat, x: Flat) -> Coefficients | None:
    """None for what is no polynomial of degree 2 at most."""
    value = fold(node)
    if isinstance(value, int | float):
        return float(value), 0.0, 0.0
    if are_alike(node, x):
        return 0.0, 1.0, 0.0
    match node:
        case Unary("-", operand):
            return _times((-1.0, 0.0, 0.0), _coefficients(operand, x))
        case Binary("+" | "-" as operator, left, right):
            one, other = _coefficients(left, x), _coefficients(right, x)
            return None if one is None or other is None else _sum(one, other, 1.0 if operator == "+" else -1.0)
        case Binary("*", left, right):
            return _times(_coefficients(left, x), _coefficients(right, x))
        case Binary("/", left, right) if isinstance(by := fold(right), int | float) and by:
            return _times((1/by, 0.0, 0.0), _coefficients(left, x))
        case Binary("^", left, right) if fold(right) == 2:
            base = _coefficients(left, x)
            return _times(base, base)
    return None


def _sum(one: Iterable[float], other: Iterable[float], sign: float) -> Coefficients:
    c, b, a = (p + sign*q for p, q in zip(one, other, strict=True))
    return c, b, a


def _times(one: Coefficients | None, other: Coefficients | None) -> Coefficients | None:
    if one is None or other is None:
        return None
    (c, b, a), (f, e, d) = one, other
    return None if a*e + b*d or a*d else (c*f, c*e + b*f, c*d + b*e + a*f)
