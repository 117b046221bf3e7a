"""SymPy expressions -> groups of terms that stand together on paper, in the order of a textbook.

Terms are collected by what moves: (k1 + k2) x, products of rates with one factor together. Accelerations come first in a sum,
then products of rates, rates, positions, weights, multipliers, given functions.
"""

from collections.abc import Mapping
from dataclasses import field
from fractions import Fraction
from functools import lru_cache
from typing import TypeAlias

import sympy as sp

from lagrangia.algebra.normal_form import Ring, Term
from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.records import dataclass
from lagrangia.paper.layout import Name
from lagrangia.paper.shapes import Polynomial, Powers, factored_out

Waves: TypeAlias = tuple[tuple[Expr, int], ...]
Rank: TypeAlias = tuple[int, int]
_MOST_SPELLED = 10_000  # expressions; a page sorts the same few hundred again and again


@lru_cache(_MOST_SPELLED)
def spelled(x: Expr) -> str:
    """How SymPy writes an expression, as the last word where an order is wanted."""
    return str(x)


def _listed(powers: Powers | Waves) -> str:
    """As Python writes the tuple."""
    inside = ", ".join(f"({spelled(x)}, {k!r})" for x, k in powers)
    return f"({inside},)" if len(powers) == 1 else f"({inside})"


@dataclass(frozen=True)
class Symbols:
    """What each SymPy symbol is: its name on paper, its rank in a product, and whether it moves."""

    names: Mapping[Expr, Name]
    ranks: Mapping[Expr, Rank]  # of parameters and loads: what kind, and where in the model it is declared
    coordinates: tuple[Expr, ...]
    rates: tuple[Expr, ...]
    accelerations: tuple[Expr, ...]
    multipliers: tuple[Expr, ...]
    given: frozenset[Expr]
    digits: int = 0
    lengths: Mapping[Expr, Name] = field(default_factory=dict)  # names of square roots, by what stands under them
    loads: frozenset[Expr] = frozenset()  # of the given: forces and torques
    weights: frozenset[Expr] = frozenset()  # gravity

    def moves(self, expression: Expr) -> bool:
        """Whether it changes during a motion."""
        return bool(expression.free_symbols & self.moving)

    @property
    def moving(self) -> set[Expr]:
        """All symbols that change during a motion."""
        return {*self.coordinates, *self.rates, *self.accelerations, *self.multipliers, *self.given}


@dataclass(frozen=True)
class Group:
    """number x common powers x (sum of parameters) x (sum of rates) x what moves x waves."""

    number: Fraction
    common: Powers
    sum: Polynomial
    rates: Polynomial
    dynamic: Powers
    waves: Waves

    @property
    def is_constant(self) -> bool:
        """Whether it is made of parameters alone."""
        return not (self.dynamic or self.waves or self.rates)


@dataclass
class Grouping:
    """Collects the terms of expressions by what moves."""

    symbols: Symbols

    def __post_init__(self) -> None:
        self._moving = self.symbols.moving
        self._places = {x: (rank, k) for rank, group in enumerate(
            (self.symbols.multipliers, (), self.symbols.coordinates, (), self.symbols.rates, self.symbols.accelerations))
            for k, x in enumerate(group)}

    def groups(self, expression: Expr, ring: Ring) -> list[Group]:
        """The groups of an expression, in their order. Raises TooLarge."""
        parts: dict[tuple[Powers, Waves], list[tuple[Fraction, Powers]]] = {}
        for term in ring.terms(expression):
            still, dynamic = self._split(term)
            parts.setdefault((dynamic, self._sorted_waves(term.trigonometric)), []).append((term.number, still))
        groups = []
        for (dynamic, waves), polynomial in parts.items():
            number, common, rest = factored_out(polynomial)
            groups.append(Group(number, common, tuple(sorted(rest, key=self.term_key)), (), dynamic, waves))
        return sorted(self._merged_rates(groups), key=self._group_key)

    def _split(self, term: Term) -> tuple[Powers, Powers]:
        powers = _cubes(dict(term.powers))
        dynamic = tuple(sorted(((x, k) for x, k in powers.items() if x.free_symbols & self._moving), key=self._dynamic_key))
        return tuple((x, k) for x, k in powers.items() if not x.free_symbols & self._moving), dynamic

    def _sorted_waves(self, waves: Waves) -> Waves:
        return tuple(sorted(waves, key=lambda item: (isinstance(item[0], sp.cos), self._places_of(item[0]), spelled(item[0]))))

    def _places_of(self, x: Expr) -> list[tuple[int, int]]:
        return sorted(self._places.get(s, (9, 0)) for s in x.free_symbols)

    def _merged_rates(self, groups: list[Group]) -> list[Group]:
        """Products of two rates with the same other factors: (2 phi' psi' + psi'^2)."""
        rates = set(self.symbols.rates)
        found: list[Group] = []
        alike: dict[object, list[Group]] = {}
        for g in groups:
            mine = tuple(x for x in g.dynamic if x[0] in rates)
            if sum(k for _, k in mine) == 2 and not any(x.free_symbols & rates for x, _ in g.dynamic if x not in rates):
                others = tuple(x for x in g.dynamic if x[0] not in rates)
                alike.setdefault((g.common, g.sum, others, g.waves), []).append(g)
            else:
                found.append(g)
        for several in alike.values():
            common, rest, waves = several[0].common, several[0].sum, several[0].waves
            others = tuple(x for x in several[0].dynamic if x[0] not in rates)
            if len(several) == 1 or not (common or rest or waves):
                found += several
                continue
            number = min(abs(g.number) for g in several) * (-1 if all(g.number < 0 for g in several) else 1)
            polynomial = tuple((g.number / number, tuple(x for x in g.dynamic if x[0] in rates)) for g in several)
            ordered = sorted(polynomial, key=lambda item: (item[0] < 0, len(item[1]), list(map(self._dynamic_key, item[1]))))
            found.append(Group(number, common, rest, tuple(ordered), others, waves))
        return found

    # ------------------------------------------------------------ order

    def _group_key(self, g: Group) -> tuple[object, ...]:
        s = self.symbols
        symbols = {y for x, _ in (*g.dynamic, *(p for _, powers in g.rates for p in powers)) for y in x.free_symbols}
        atoms = {x for x, _ in (*g.common, *(p for _, powers in g.sum for p in powers))}
        kinds = ((symbols & set(s.accelerations), 0), (g.rates or self._rate_degree(g) > 1, 1), (symbols & set(s.rates), 2),
                 (symbols & set(s.multipliers), 5), (symbols & s.loads, 6), ((symbols or g.waves) and not atoms & s.weights, 3),
                 (symbols or g.waves, 4), (True, 7))
        kind = next(rank for rank, (holds, _) in enumerate(kinds) if holds)
        order = kinds[kind][1]
        waves = {y for x, _ in g.waves for y in x.free_symbols}
        everything = [k for group in (s.accelerations, s.rates, s.coordinates, s.multipliers) for k, x in enumerate(group)
                      if x in symbols | waves]
        degree = len([1 for x, k in g.dynamic for _ in range(int(abs(k)))])
        is_quotient = any(k < 0 for _, k in g.dynamic)
        last = _listed(g.dynamic), _listed(g.waves)
        return order, order == 1 and len(g.dynamic) > 1, is_quotient, sorted(everything), not symbols, -degree, *last

    def _rate_degree(self, g: Group) -> Fraction:
        return sum((k for x, k in g.dynamic if x.free_symbols & set(self.symbols.rates)), Fraction(0))

    def _dynamic_key(self, item: tuple[Expr, Fraction]) -> tuple[int, int, str]:
        """Multipliers, given functions, coordinates, sizes, rates, accelerations, all else."""
        x = item[0]
        if x in self._places:
            return *self._places[x], ""
        return 1 if x in self.symbols.given else 3 if isinstance(x, sp.Abs) else 6, 0, spelled(x)

    def rank(self, x: Expr) -> Rank:
        """Where an atom stands in a product: numbers, loads, masses and stiffnesses, g, lengths, all else."""
        return (-2, 0) if x.is_number else self.symbols.ranks.get(x) or min(
            (self.symbols.ranks[y] for y in x.free_symbols if y in self.symbols.ranks), default=(5, 0))

    def term_key(self, item: tuple[Fraction, Powers]) -> tuple[object, ...]:
        """The order of the terms of a sum of parameters: positive ones first, then those with the fewest factors."""
        ranks = sorted((*self.rank(x), spelled(x)) for x, _ in item[1])
        return item[0] < 0, len(item[1]), ranks, _listed(item[1])


def _cubes(powers: dict[Expr, Fraction]) -> dict[Expr, Fraction]:
    """x^2 |x| as |x|^3."""
    for x in [x for x in powers if isinstance(x, sp.Abs)]:
        k = powers.get(x.args[0], Fraction(0))
        if k > 0 and k % 2 == 0:
            powers[x] += powers.pop(x.args[0])
    return powers
