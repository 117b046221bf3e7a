"""Polynomials of parameters in the shape that a person gives them: of three shapes the one with the fewest symbols.

    multiplied out  I + m1 r^2 + m2 r^2      in factors  (m + I/r^2) (R - r)^2      a symbol drawn out  I + (m1 + m2) r^2

Powers may be negative or fractions. Signs of sums are not decided here: who lays them out turns R - r and r - R alike.
"""

from collections import Counter
from collections.abc import Iterable, Sequence
from fractions import Fraction
from math import lcm
from typing import TypeAlias

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.records import dataclass

Powers: TypeAlias = tuple[tuple[Expr, Fraction], ...]
Polynomial: TypeAlias = tuple[tuple[Fraction, Powers], ...]
_ONE = Fraction(1)
_MOST_TERMS, _MOST_ATOMS = 24, 10  # of what is factored
_MOST_SEARCHED = 10  # terms of which all ways of drawing symbols out are tried: their number doubles with each term
_MOST_OWN = 12  # larger whole numbers are data, 50 N, and not of squares and halves


@dataclass(frozen=True)
class Shaped:
    """number x factors to their powers; a factor is an atom or a sum of such products."""

    number: Fraction
    factors: tuple[tuple["Expr | Sum", Fraction], ...]

    @property
    def size(self) -> int:
        """How many symbols it is written with."""
        return sum(sum(x.size for x in f.items) if isinstance(f, Sum) else 1 for f, _ in self.factors)


@dataclass(frozen=True)
class Sum:
    """A sum of products."""

    items: tuple[Shaped, ...]

    @property
    def negated(self) -> "Sum":
        """The same with every sign turned."""
        return Sum(tuple(Shaped(-x.number, x.factors) for x in self.items))

    @property
    def key(self) -> frozenset[Shaped]:
        """Equal for sums that differ in their order alone."""
        return frozenset(self.items)


def shaped(polynomial: Sequence[tuple[Fraction, Powers]]) -> Shaped:
    """The shape with the fewest symbols; of several the one in factors, then the one that is multiplied out."""
    number, common, rest = factored_out(polynomial)
    if len(rest) == 1:
        return Shaped(number * rest[0][0], common)
    plain = _grouped(rest)
    factors = _factors(rest) if len(rest) <= _MOST_TERMS else None
    whole = Shaped(number * plain.number, (*common, *plain.factors))
    if factors is None:
        return whole
    product = _distributed(factors, common)
    product = Shaped(product.number * number, product.factors)
    return product if product.size <= whole.size else whole


def factored_out(polynomial: Sequence[tuple[Fraction, Powers]]) -> tuple[Fraction, Powers, Polynomial]:
    """number, powers that all terms share, and what is left; the number is negative only when all terms are."""
    common = dict(polynomial[0][1])
    for _, powers in polynomial[1:]:
        here = dict(powers)
        both = {x: (k, here[x]) for x, k in common.items() if x in here and k * here[x] > 0}
        common = {x: min(pair, key=abs) for x, pair in both.items()}
    common = {x: k for x, k in common.items() if k}
    number = usual_number([x for x, _ in polynomial])
    return number, tuple(common.items()), tuple((x / number, _divided(powers, common)) for x, powers in polynomial)


def usual_number(numbers: Sequence[Fraction]) -> Fraction:
    """The factor that leaves the fewest numbers, its own counted, and whole ones whole: 1 for a - L/2, 1/2 for I/2 + m/8, 2 for
    4 k + 2 m; negative when all are."""
    sizes = [abs(x) for x in numbers]
    is_whole = all(x.denominator == 1 and x <= _MOST_OWN for x in sizes)

    def cost(number: Fraction) -> tuple[int, bool, bool, Fraction]:
        breaks = is_whole and any((x / number).denominator != 1 for x in sizes)
        return (number != 1) + sum(x != number for x in sizes), breaks, number not in sizes, -number

    return min({_ONE, *sizes}, key=cost) * (-1 if all(x < 0 for x in numbers) else 1)


def _divided(powers: Powers, by: dict[Expr, Fraction]) -> Powers:
    left = dict(powers)
    for x, k in by.items():
        left[x] = left.get(x, Fraction(0)) - k
    return tuple((x, k) for x, k in left.items() if k)


# -------------------------------------------------------------------- a symbol drawn out of some terms


def _grouped(polynomial: Polynomial) -> Shaped:
    """The sum as it is, or with a power drawn out of the terms that have it, where that leaves fewer symbols; of long sums, that
    which most terms have."""
    best = Sum(tuple(Shaped(x, powers) for x, powers in polynomial))
    if len(polynomial) > 2:
        counts = Counter(p for _, powers in polynomial for p in powers)
        partly = [power for power, count in counts.items() if 1 < count < len(polynomial)]
        tried = partly if len(polynomial) <= _MOST_SEARCHED else sorted(partly, key=lambda p: -counts[p])[:1]
        found = [_drawn_out(polynomial, power) for power in tried]
        best = min([best, *found], key=lambda s: sum(x.size for x in s.items))
    return Shaped(_ONE, ((best, _ONE),))


def _drawn_out(polynomial: Polynomial, power: tuple[Expr, Fraction]) -> Sum:
    mine = [term for term in polynomial if power in term[1]]
    number, common, rest = factored_out(mine)
    inner = _grouped(rest)
    others = _grouped(tuple(term for term in polynomial if term not in mine)) if len(polynomial) - len(mine) > 1 else None
    left = others.factors[0][0].items if others else tuple(Shaped(x, p) for x, p in polynomial if (x, p) not in mine)
    return Sum((*left, Shaped(number, (*common, *inner.factors))))


# -------------------------------------------------------------------- factors


def _factors(polynomial: Polynomial) -> Shaped | None:
    """By SymPy's factorisation over the rationals; None where there is but one factor."""
    atoms = list(dict.fromkeys(x for _, powers in polynomial for x, _ in powers))
    if len(atoms) > _MOST_ATOMS or not atoms:
        return None
    depth = lcm(*(k.denominator for _, powers in polynomial for _, k in powers))
    least = {x: min(Fraction(0), *(dict(powers).get(x, Fraction(0)) for _, powers in polynomial)) for x in atoms}
    ring, *_ = sp.ring([f"x{k}" for k in range(len(atoms))], sp.QQ)
    whole = ring.from_dict({tuple(int((dict(powers).get(x, Fraction(0)) - least[x]) * depth) for x in atoms):
                            sp.QQ(number.numerator, number.denominator) for number, powers in polynomial})
    number, factors = whole.factor_list()
    if sum(len(f) > 1 for f, _ in factors) == 1 and max(k for f, k in factors if len(f) > 1) == 1:
        return None
    found, outside = Fraction(int(number.numerator), int(number.denominator)), dict(least)
    sums: list[tuple[Expr | Sum, Fraction]] = []
    for factor, k in factors:
        terms = tuple((Fraction(int(c.numerator), int(c.denominator)), tuple((x, Fraction(n, depth)) for x, n in
                      zip(atoms, powers, strict=True) if n)) for powers, c in factor.terms())
        if len(terms) == 1:
            outside = {x: k0 + dict(terms[0][1]).get(x, Fraction(0)) * k for x, k0 in outside.items()}
            found *= terms[0][0] ** k
            continue
        size = usual_number([x for x, _ in terms])
        found *= size**k
        sums.append((Sum(tuple(Shaped(x / size, powers) for x, powers in terms)), Fraction(k)))
    return Shaped(found, (*((x, k) for x, k in outside.items() if k), *sums))


def _distributed(product: Shaped, common: Powers) -> Shaped:
    """With quotients put into the sum that becomes shorter by them: (m + I/r^2) for (m r^2 + I)/r^2; sums by what they share."""
    outside = dict(common)
    for x, k in product.factors:
        if not isinstance(x, Sum):
            outside[x] = outside.get(x, Fraction(0)) + k
    sums = sorted(((_terms(x), k) for x, k in product.factors if isinstance(x, Sum)), key=lambda entry: entry[1])
    for x in [x for x, k in outside.items() if k < 0]:
        for place, (terms, k) in enumerate(sums):
            share = outside[x] / k
            divided = tuple((n, merged(powers, ((x, share),))) for n, powers in terms)
            if share.denominator == 1 and _letters(divided) <= _letters(terms):
                sums[place], outside[x] = (divided, k), Fraction(0)
                break
    factors: list[tuple[Expr | Sum, Fraction]] = [(x, k) for x, k in outside.items() if k]
    number = product.number
    for terms, k in sums:
        size, shared, rest = factored_out(terms)
        inner = _grouped(rest)
        number *= size ** int(k) * inner.number ** int(k)
        factors += [(x, power * k) for x, power in shared] + [(x, power * k) for x, power in inner.factors]
    return Shaped(number, _collected(factors))


def _terms(s: Sum) -> Polynomial:
    return tuple((x.number, tuple((f, k) for f, k in x.factors if not isinstance(f, Sum))) for x in s.items)


def _letters(polynomial: Polynomial) -> int:
    return sum(len(powers) for _, powers in polynomial)


def merged(powers: Powers, more: Powers) -> Powers:
    """The product of powers."""
    return _divided(powers, {x: -k for x, k in more})


def _collected(factors: Iterable[tuple["Expr | Sum", Fraction]]) -> tuple[tuple["Expr | Sum", Fraction], ...]:
    found: dict[Expr | Sum, Fraction] = {}
    for x, k in factors:
        found[x] = found.get(x, Fraction(0)) + k
    return tuple((x, k) for x, k in found.items() if k)
