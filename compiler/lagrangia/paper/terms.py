"""SymPy expressions -> layouts: numbers, powers, functions, products and sums.

In a product stand the number, loads, parameters (masses and stiffnesses, then g, then lengths; a sum of parameters as one of
them), what moves, and sines and cosines last. A sum of parameters begins with a positive term, its sign outside, and is turned
one way wherever it stands: R - r, never also r - R.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field
from fractions import Fraction

import sympy as sp

from lagrangia.algebra.normal_form import Ring
from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.records import dataclass
from lagrangia.paper.grouping import Group, Grouping, Symbols, spelled
from lagrangia.paper.layout import (
    Apply,
    Bracket,
    Cases,
    Listing,
    Name,
    Node,
    Numeral,
    Power,
    Product,
    Quotient,
    Relation,
    Root,
    Total,
    Words,
    product,
    total,
)
from lagrangia.paper.shapes import Polynomial, Powers, Shaped, Sum, shaped
from lagrangia.paper.typeset import decimal

Signed = list[tuple[int, Node]]


@dataclass
class Terms:
    """Lays sums of products out. `most_products` bounds the work of its normal forms; a ring that is given knows some already."""

    symbols: Symbols
    most_products: int
    known: Ring | None = None
    ring: Ring = field(init=False)
    gathered: Ring = field(init=False)

    def __post_init__(self) -> None:
        self.ring = Ring(self.most_products) if self.known is None else self.known
        self.ring.most = max(self.ring.most, self.most_products)
        self.gathered = Ring(self.most_products, frozenset(self.symbols.rates))
        self.grouping = Grouping(self.symbols)
        self._shapes: dict[object, Shaped] = {}
        self.turned: dict[frozenset[Shaped], bool] = {}  # sums of parameters by how they have stood so far

    def sum(self, expression: Expr, ring: Ring | None = None) -> Node:
        """The expression as a sum of collected terms, a positive one first where there is one."""
        groups = self.grouping.groups(expression, ring or self.ring)
        return total(positive_first([item for group in groups for item in self.items(group)]))

    def items(self, g: Group) -> Signed:
        """The group as terms; a bare sum of parameters is opened."""
        whole = self._shape(g.number, g.common, g.sum)
        if not g.is_constant or len(whole.factors) != 1 or not isinstance(whole.factors[0][0], Sum) or whole.factors[0][1] != 1:
            return [self.term(g)]
        opened = [Shaped(x.number * whole.number, x.factors) for x in whole.factors[0][0].items]
        return [self._laid(x) for x in sorted(opened, key=self._key)]

    def _shape(self, number: Fraction, common: Powers, polynomial: Polynomial) -> Shaped:
        key = number, common, polynomial
        if key not in self._shapes:
            own = dict(common)
            terms = [(number * x, tuple({**own, **{y: own.get(y, Fraction(0)) + k for y, k in powers}}.items()))
                     for x, powers in polynomial]
            self._shapes[key] = shaped(terms)
        return self._shapes[key]

    # ------------------------------------------------------------ a product

    def term(self, g: Group, brackets: Sequence[Node] = ()) -> tuple[int, Node]:
        """Sign and product of a group; `brackets` are factors of it that stand before sines and cosines."""
        loads = tuple(x for x in g.dynamic if x[0] in self.symbols.loads)
        shape = self._shape(g.number, g.common, g.sum)
        sign, number, above, below = self._factors(Shaped(shape.number, (*loads, *shape.factors)))
        for x, k in g.dynamic:
            if x not in self.symbols.loads:
                (above if k > 0 else below).append(self.power(x, abs(k)))
        if g.rates:
            above.append(Bracket(total(positive_first([self._rates(x, powers) for x, powers in g.rates]))))
        above += brackets
        for x, power in g.waves:
            (above if power > 0 else below).append(self.wave(x, abs(power)))
        return sign, self._put(number, above, below)

    def _rates(self, number: Fraction, powers: Powers) -> tuple[int, Node]:
        return -1 if number < 0 else 1, self._put(abs(number), [self.power(x, k) for x, k in powers], [])

    def _laid(self, x: Shaped) -> tuple[int, Node]:
        sign, number, above, below = self._factors(x)
        return sign, self._put(number, above, below)

    def _factors(self, x: Shaped) -> tuple[int, Fraction, list[Node], list[Node]]:
        sign = -1 if x.number < 0 else 1
        above: list[Node] = []
        below: list[Node] = []
        for factor, k in sorted(x.factors, key=self._factor_key):
            if isinstance(factor, Sum):
                turn, inside = self._bracket(factor, is_odd=k % 2 == 1, sign=sign)
                sign *= turn
                node: Node = Bracket(inside) if abs(k) == 1 else Power(Bracket(inside), self.number(abs(k)))
            else:
                node = self.power(factor, abs(k))
            (above if k > 0 else below).append(node)
        return sign, abs(x.number), above, below

    def _put(self, number: Fraction, above: list[Node], below: list[Node]) -> Node:
        if below and 1 < number.denominator < 100 and not self.symbols.digits and not _is_decimal(number):
            below = [Numeral(Fraction(number.denominator)), *below]
            number = Fraction(number.numerator)
        if number != 1 or not above:
            above = [self.number(number), *above]
        return Quotient(product(above), product(below)) if below else product(above)

    def _bracket(self, s: Sum, is_odd: bool, sign: int) -> tuple[int, Node]:
        """The sum turned as it stood before; at first so that no sign is outside, and begins with what is declared first."""
        if s.key not in self.turned:
            is_mixed = len({x.number < 0 for x in s.items}) == 2
            first = min(s.items, key=lambda x: self._key(Shaped(abs(x.number), x.factors)))
            turned = is_mixed and (sign < 0 if is_odd else first.number < 0)
            self.turned[s.key], self.turned[s.negated.key] = turned, not turned
        turned = self.turned[s.key]
        items = (s.negated if turned else s).items
        laid = [self._laid(x) for x in sorted(items, key=self._key)]
        return -1 if turned and is_odd else 1, total(positive_first(laid))

    def _factor_key(self, item: tuple[Expr | Sum, Fraction]) -> tuple[object, ...]:
        x = item[0]
        if isinstance(x, Sum):
            simplest = min(x.items, key=lambda y: self._key(Shaped(abs(y.number), y.factors)))
            ranks = [self._factor_key(f)[0] for f in simplest.factors]
            return min(ranks, default=5), True, 0, ""  # type: ignore[type-var]
        rank, place = self.grouping.rank(x)
        return rank, False, place, spelled(x)

    def _key(self, x: Shaped) -> tuple[object, ...]:
        ranks = sorted(self._factor_key(f) for f in x.factors)
        return x.number < 0, len(x.factors), ranks

    # ------------------------------------------------------------ atoms

    def number(self, value: Fraction) -> Numeral:
        """Exact where a person would write a fraction, else a decimal."""
        digits = self.symbols.digits
        is_whole = value.denominator == 1 and abs(value) < 100000
        is_short = value.denominator in _FRACTIONS and abs(value.numerator) < 100 and not digits
        return Numeral(value, 0 if is_whole or is_short else digits or _DIGITS)

    def power(self, x: Expr, k: Fraction) -> Node:
        """An atom to a power."""
        if k.denominator == 2 and x in self.symbols.lengths:
            name = self.symbols.lengths[x]
            return name if k.numerator == 1 else Power(name, Numeral(Fraction(k.numerator)))
        if k.denominator == 2:
            root = Root(self.node(x))
            return root if k.numerator == 1 else Power(Bracket(root), Numeral(Fraction(k.numerator)))
        base = self.node(x)
        if k == 1:
            return Bracket(base) if isinstance(base, Total) else base
        loose = isinstance(base, Total | Product | Quotient | Apply | Relation) and not isinstance(x, sp.Abs)
        return Power(Bracket(base) if loose else base, self.number(k))

    def wave(self, x: Expr, k: int = 1) -> Node:
        """A sine or cosine, to a power."""
        return Apply(type(x).__name__, self.sum(x.args[0]), k)

    # ------------------------------------------------------------ anything

    def node(self, e: Expr) -> Node:
        """Any expression that is no sum of several terms is laid out as it stands."""
        if e in self.symbols.names:
            return self.symbols.names[e]
        if isinstance(e, sp.sin | sp.cos):
            return self.wave(e)
        if isinstance(e, sp.Piecewise):
            return self._cases(e)
        if isinstance(e, sp.core.relational.Relational):
            return Relation(self.sum(e.lhs), self.sum(e.rhs), _RELATIONS[e.rel_op])
        if e.is_Symbol or isinstance(e, sp.NumberSymbol):
            return Name(str(e))
        if isinstance(e, sp.And | sp.Or):
            words = Words(" and " if isinstance(e, sp.And) else " or ")
            parts = [part for x in e.args for part in (words, self.node(x))][1:]
            return Product(tuple(parts))
        if e.is_Pow and e.exp.is_Rational:
            return self.power(e.base, Fraction(int(e.exp.p), int(e.exp.q)))
        if e.is_Pow:
            base = self.node(e.base)
            return Power(base if isinstance(base, Name) else Bracket(base), self.sum(e.exp))
        if e.is_Function:
            name, few = _FUNCTIONS.get(type(e).__name__, type(e).__name__), [self.sum(x) for x in e.args]
            return Apply(name, few[0]) if len(few) == 1 else Apply(name, Listing(tuple(few)))
        return self.sum(e) if e.is_Add or e.is_Mul or e.is_Rational else Words(str(e))

    def _cases(self, e: Expr) -> Node:
        flat = sp.piecewise_fold(e)
        return Cases(tuple((self.sum(value), None if when == sp.true else self.node(when)) for value, when in flat.args))


def _is_decimal(number: Fraction) -> bool:
    """Whether it is a decimal of few digits, as 0.12, and no fraction that a person would write."""
    return number.denominator not in _FRACTIONS and Fraction(decimal(number, _DIGITS)) == number


def positive_first(items: Signed) -> Signed:
    """With a positive term in front, where there is one."""
    first = next((k for k, (sign, _) in enumerate(items) if sign > 0), 0)
    return [items[first], *items[:first], *items[first + 1 :]] if items else items


_DIGITS = 6  # of a decimal
_FRACTIONS = {1, 2, 3, 4, 6, 8, 12, 16, 24}
_RELATIONS = {"<": "<", "<=": "≤", ">": ">", ">=": "≥", "==": "=", "!=": "≠"}
_FUNCTIONS: Mapping[str, str] = {"Abs": "abs", "log": "ln", "sign": "sgn", "asin": "arcsin", "acos": "arccos", "atan": "arctan",
                                 "Min": "min", "Max": "max", "ceiling": "ceil"}
