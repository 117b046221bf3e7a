"""SymPy expressions -> layouts in the order of a textbook.

Terms are collected by what moves: (k1 + k2) x, all terms of one acceleration together, products of rates with one factor
together. In a product stand the number, the parameters (masses and stiffnesses, then g, then lengths), sums of parameters, what
moves, and sines and cosines last. Accelerations come first in a sum, then rates, then positions, then multipliers.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from fractions import Fraction

import sympy as sp

from lagrangia.algebra.normal_form import Ring, Term
from lagrangia.algebra.with_sympy import Expr
from lagrangia.paper.layout import (
    ONE,
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
from lagrangia.paper.typeset import line

Powers = tuple[tuple[Expr, Fraction], ...]
Waves = tuple[tuple[Expr, int], ...]
Polynomial = tuple[tuple[Fraction, Powers], ...]


@dataclass(frozen=True)
class Symbols:
    """What each SymPy symbol is: its name on paper, its rank in a product, and whether it moves."""

    names: Mapping[Expr, Name]
    ranks: Mapping[Expr, int]  # of parameters
    coordinates: tuple[Expr, ...]
    rates: tuple[Expr, ...]
    accelerations: tuple[Expr, ...]
    multipliers: tuple[Expr, ...]
    given: frozenset[Expr]
    digits: int = 0
    lengths: Mapping[Expr, Name] = field(default_factory=dict)  # names of square roots, by what stands under them

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


@dataclass
class Presentation:
    """Lays expressions out. `most_products` bounds the work of its normal forms; a ring that is given knows some already."""

    symbols: Symbols
    most_products: int
    known: Ring | None = None
    ring: Ring = field(init=False)
    gathered: Ring = field(init=False)

    def __post_init__(self) -> None:
        self.ring = Ring(self.most_products) if self.known is None else self.known
        self.ring.most = max(self.ring.most, self.most_products)
        self.gathered = Ring(self.most_products, frozenset(self.symbols.rates))
        self._moving = self.symbols.moving

    # ------------------------------------------------------------ sums

    def sum(self, expression: Expr, ring: Ring | None = None) -> Node:
        """The expression as a sum of collected terms, a positive one first where there is one."""
        groups = self._groups(expression, ring or self.ring)
        return total(_positive_first([item for group in groups for item in self._items(group)]))

    def _items(self, g: Group) -> list[tuple[int, Node]]:
        """A bare sum of parameters is opened."""
        if g.common or g.dynamic or g.waves or g.rates or len(g.sum) == 1:
            return [self._signed(g)]
        return [self._small(g.number * number, powers) for number, powers in g.sum]

    def equation(self, left: Expr, right: Expr = sp.S.Zero, own: int | None = None) -> Relation:
        """left = right, what depends on neither coordinates nor rates on the right, the acceleration of `own` first."""
        stays: list[Expr] = []
        goes: list[Expr] = []
        s = self.symbols
        kept = {*s.coordinates, *s.rates, *s.accelerations, *s.multipliers}
        for term in self.ring.terms(left):
            x = term.expression()
            (stays if x.free_symbols & kept else goes).append(x)
        if not stays:
            stays, goes = goes, []
        return Relation(self._accelerations(sp.Add(*stays), own), self.sum(right - sp.Add(*goes)))

    def kept(self, left: Expr, right: Expr, own: int | None = None) -> Relation:
        """left = right as they are, the acceleration of `own` first."""
        return Relation(self._accelerations(left, own), self._accelerations(right, None))

    def momentum(self, expression: Expr) -> Node:
        """A sum of coefficients times rates."""
        items: list[tuple[int, Node]] = []
        rest = expression
        for v in self.symbols.rates:
            mine = sp.Add(*(x for x in sp.Add.make_args(rest) if x.has(v)))
            items += self._factored(mine, v) if mine != 0 else []
            rest = rest - mine
        items += [item for group in (self._groups(rest, self.ring) if rest != 0 else []) for item in self._items(group)]
        return total(_positive_first(items))

    def motion(self, expression: Expr) -> Node:
        """A velocity as the kinematics made it, sums of rates kept together."""
        return self.sum(expression, self.gathered)

    def quotient(self, top: Expr, bottom: Expr) -> Node:
        """top/bottom, divided out where the bottom is one term."""
        whole = self.over(self.sum(top), self.coefficient(bottom))
        is_single = len(self.ring.terms(bottom)) == 1
        return self.sum(top / bottom) if is_single and (top.is_Mul or top == 0 or len(line(whole)) > _LONGEST_QUOTIENT) else whole

    @staticmethod
    def over(top: Node, bottom: Node) -> Node:
        """The quotient of two formulas."""
        return Quotient(top, bottom)

    @staticmethod
    def square(base: Node) -> Node:
        """The square of a formula."""
        return Power(base, Numeral(Fraction(2)))

    def _accelerations(self, expression: Expr, own: int | None) -> Node:
        """Terms of one acceleration in one bracket, `own` first."""
        accelerations = list(self.symbols.accelerations)
        if own is not None:
            accelerations.insert(0, accelerations.pop(own))
        terms = [term.expression() for term in self.ring.terms(expression)]
        items: list[tuple[int, Node]] = []
        for a in accelerations:
            mine = sp.Add(*(x for x in terms if x.has(a)))
            items += self._factored(mine, a) if mine != 0 else []
        several = {*accelerations, *self.symbols.multipliers}
        rest = [g for x in [sp.Add(*(x for x in terms if not x.free_symbols & several))] for g in self._groups(x, self.ring)]
        items += [item for g in rest for item in self._items(g)]
        for x in self.symbols.multipliers:
            mine = sp.Add(*(term for term in terms if term.has(x)))
            items += self._factored(mine, x) if mine != 0 else []
        return total(items)

    def _factored(self, expression: Expr, a: Expr) -> list[tuple[int, Node]]:
        groups = self._groups(expression, self.ring)
        if len(groups) == 1:
            return [self._signed(groups[0])]
        pulled, groups = _pulled(self._groups(expression / a, self.ring))
        coefficient, sign = self._constants_first(groups), 1
        if isinstance(coefficient, Total) and all(s < 0 for s, _ in coefficient.items):
            coefficient, sign = Total(tuple((-s, item) for s, item in coefficient.items)), -1
        factors = [self._power(x, k) for x, k in sorted(pulled, key=self._parameter_key)]
        return [(sign, product([*factors, coefficient, self.symbols.names[a]]))]

    def coefficient(self, expression: Expr) -> Node:
        """A sum with what does not move first: an entry of M."""
        return self._constants_first(self._groups(expression, self.ring))

    def _constants_first(self, groups: list[Group]) -> Node:
        groups = sorted(groups, key=lambda g: bool(g.dynamic or g.waves or g.rates))
        return total(_positive_first([item for g in groups for item in self._items(g)]))

    def gentle(self, expression: Expr) -> Node:
        """As the component stated it: squares of sums stay, their insides are collected; unless the plain sum is shorter."""
        plain = self.sum(expression)
        items: list[tuple[int, Node]] = []
        for addend in sp.Add.make_args(expression):
            items += self._gentle_term(addend)
        stated = total(items)
        return stated if len(line(stated)) < len(line(plain)) else plain

    def _gentle_term(self, addend: Expr) -> list[tuple[int, Node]]:
        factors = sp.Mul.make_args(addend)
        sums = [x for x in factors if x.is_Add or (x.is_Pow and x.base.is_Add and x.exp.is_Integer and x.exp > 0)]
        rest = sp.Mul(*(x for x in factors if x not in sums))
        outside = self.ring.terms(rest)
        if len(sums) != 1 or len(outside) != 1:
            return self._opened(self.sum(addend, self.gathered))
        inside, power = (sums[0].base, int(sums[0].exp)) if sums[0].is_Pow else (sums[0], 1)
        pulled, groups = _pulled(self._groups(inside, self.gathered))
        layout = total(_positive_first([item for group in groups for item in self._items(group)]))
        rest = sp.Mul(rest, *(sp.Pow(x, sp.Rational(k.numerator, k.denominator)) for x, k in pulled)) ** 1
        if power > 1 and pulled:
            layout, rest = self.sum(inside, self.gathered), outside[0].expression()
        if not isinstance(layout, Total) or len(layout.items) == 1 :
            return self._opened(self.sum(addend, self.gathered))
        sign, coefficient = self._signed(self._groups(rest, self.ring)[0])
        bracket: Node = Bracket(layout) if power == 1 else Power(Bracket(layout), Numeral(Fraction(power)))
        items: list[Node] = list(coefficient.items) if isinstance(coefficient, Product) else [coefficient]
        items = [] if coefficient == ONE else items
        return [(sign, product([*items, bracket]))]

    @staticmethod
    def _opened(node: Node) -> list[tuple[int, Node]]:
        return list(node.items) if isinstance(node, Total) else [(1, node)]

    # ------------------------------------------------------------ grouping

    def _groups(self, expression: Expr, ring: Ring) -> list[Group]:
        parts: dict[tuple[Powers, Waves], list[tuple[Fraction, Powers]]] = {}
        for term in ring.terms(expression):
            still, dynamic = self._split(term)
            parts.setdefault((dynamic, self._sorted_waves(term.trigonometric)), []).append((term.number, still))
        groups = []
        for (dynamic, waves), polynomial in parts.items():
            number, common, rest = _factor(polynomial)
            groups.append(Group(number, common, tuple(sorted(rest, key=self._polynomial_key)), (), dynamic, waves))
        return sorted(self._merged_rates(groups), key=self._group_key)

    def _split(self, term: Term) -> tuple[Powers, Powers]:
        dynamic = tuple(sorted(((x, k) for x, k in term.powers if x.free_symbols & self._moving), key=self._dynamic_key))
        return tuple((x, k) for x, k in term.powers if not x.free_symbols & self._moving), dynamic

    def _sorted_waves(self, waves: Waves) -> Waves:
        return tuple(sorted(waves, key=lambda item: (isinstance(item[0], sp.cos), str(item[0]))))

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
            ordered = tuple(sorted(polynomial, key=lambda item: (item[0] < 0, len(item[1]), str(item[1]))))
            found.append(Group(number, common, rest, ordered, others, waves))
        return found

    # ------------------------------------------------------------ order

    def _group_key(self, g: Group) -> tuple[object, ...]:
        s = self.symbols
        symbols = {y for x, _ in (*g.dynamic, *(p for _, powers in g.rates for p in powers)) for y in x.free_symbols}
        kinds = ((symbols & set(s.accelerations), 0), (g.rates or self._rate_degree(g) > 1, 1), (symbols & set(s.rates), 2),
                 (symbols & set(s.multipliers), 4), (symbols & set(s.given), 5), (symbols or g.waves, 3), (True, 6))
        kind = next(rank for holds, rank in kinds if holds)
        waves = {y for x, _ in g.waves for y in x.free_symbols}
        everything = [k for group in (s.accelerations, s.rates, s.coordinates, s.multipliers) for k, x in enumerate(group)
                      if x in symbols | waves]
        degree = len([1 for x, k in g.dynamic for _ in range(int(abs(k)))])
        is_quotient = any(k < 0 for _, k in g.dynamic)
        last = str(g.dynamic), str(g.waves)
        return kind, kind == 1 and len(g.dynamic) > 1, is_quotient, sorted(everything), not symbols, -degree, *last

    def _rate_degree(self, g: Group) -> Fraction:
        return sum((k for x, k in g.dynamic if x.free_symbols & set(self.symbols.rates)), Fraction(0))

    def _dynamic_key(self, item: tuple[Expr, Fraction]) -> tuple[int, int, str]:
        s = self.symbols
        for rank, group in enumerate((s.multipliers, s.coordinates, s.rates, s.accelerations)):
            if item[0] in group:
                return rank, group.index(item[0]), ""
        return 4, 0, str(item[0])

    def _parameter_key(self, item: tuple[Expr, Fraction]) -> tuple[int, str]:
        return -1 if item[0].is_number else self.symbols.ranks.get(item[0], 5), str(self.symbols.names.get(item[0], item[0]))

    def _polynomial_key(self, item: tuple[Fraction, Powers]) -> tuple[object, ...]:
        return item[0] < 0, sorted(map(self._parameter_key, item[1])), str(item[1])

    # ------------------------------------------------------------ terms

    def _signed(self, g: Group) -> tuple[int, Node]:
        sign = -1 if g.number < 0 else 1
        above: list[Node] = []
        below: list[Node] = []
        for x, k in (*sorted(g.common, key=self._parameter_key), ):
            (above if k > 0 else below).append(self._power(x, abs(k)))
        if len(g.sum) > 1:
            above.append(Bracket(total(_positive_first([self._small(number, powers) for number, powers in g.sum]))))
        for x, k in g.dynamic:
            (above if k > 0 else below).append(self._power(x, abs(k)))
        if g.rates:
            above.append(Bracket(total(_positive_first([self._small(number, powers) for number, powers in g.rates]))))
        for x, power in g.waves:
            (above if power > 0 else below).append(self.wave(x, abs(power)))
        number = abs(g.number)
        if below and 1 < number.denominator < 100 and not self.symbols.digits:
            below.insert(0, Numeral(Fraction(number.denominator)))
            number = Fraction(number.numerator)
        if number != 1 or not above:
            above.insert(0, self.number(number))
        return sign, Quotient(product(above), product(below)) if below else product(above)

    def _small(self, number: Fraction, powers: Powers) -> tuple[int, Node]:
        return self._signed(Group(number, powers, ((Fraction(1), ()),), (), (), ()))

    def number(self, value: Fraction) -> Numeral:
        """Exact where a person would write a fraction, else a decimal."""
        digits = self.symbols.digits
        is_whole = value.denominator == 1 and abs(value) < 100000
        is_short = value.denominator in _FRACTIONS and abs(value.numerator) < 100 and not digits
        return Numeral(value, 0 if is_whole or is_short else digits or 6)

    def _power(self, x: Expr, k: Fraction) -> Node:
        if k.denominator == 2 and x in self.symbols.lengths:
            name = self.symbols.lengths[x]
            return name if k.numerator == 1 else Power(name, Numeral(Fraction(k.numerator)))
        if k.denominator == 2:
            root = Root(self.node(x))
            return root if k.numerator == 1 else Power(Bracket(root), Numeral(Fraction(k.numerator)))
        base = self.node(x)
        if k == 1:
            return Bracket(base) if isinstance(base, Total) else base
        loose = isinstance(base, Total | Product | Quotient | Apply | Relation)
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
            return self._power(e.base, Fraction(int(e.exp.p), int(e.exp.q)))
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


def _pulled(groups: list[Group]) -> tuple[Powers, list[Group]]:
    """The parameters that all groups share, and the groups without them."""
    common = dict(groups[0].common) if len(groups) > 1 else {}
    for g in groups[1:]:
        here = dict(g.common)
        common = {x: min(k, here[x]) for x, k in common.items() if x in here and k > 0 and here[x] > 0}
    common = {x: k for x, k in common.items() if k > 0}
    if not common:
        return (), groups

    def less(powers: Powers) -> Powers:
        return tuple((x, k - common.get(x, Fraction(0))) for x, k in powers if k != common.get(x))

    return tuple(common.items()), [replace(g, common=less(g.common)) for g in groups]


def _positive_first(items: list[tuple[int, Node]]) -> list[tuple[int, Node]]:
    first = next((k for k, (sign, _) in enumerate(items) if sign > 0), 0)
    return [items[first], *items[:first], *items[first + 1 :]] if items else items


def _factor(polynomial: list[tuple[Fraction, Powers]]) -> tuple[Fraction, Powers, Polynomial]:
    """number, powers that all terms share, and what is left; the number is negative only when all terms are."""
    numbers = [number for number, _ in polynomial]
    common = dict(polynomial[0][1])
    for _, powers in polynomial[1:]:
        here = dict(powers)
        both = {x: (k, here[x]) for x, k in common.items() if x in here and k * here[x] > 0}
        common = {x: min(pair, key=abs) for x, pair in both.items()}
    common = {x: k for x, k in common.items() if k}
    number = max(abs(x) for x in numbers) * (-1 if all(x < 0 for x in numbers) else 1)
    rest = []
    for x, powers in polynomial:
        left = dict(powers)
        for atom, k in common.items():
            left[atom] = left.get(atom, Fraction(0)) - k
        rest.append((x / number, tuple((atom, k) for atom, k in left.items() if k)))
    return number, tuple(common.items()), tuple(rest)


_LONGEST_QUOTIENT = 90
_FRACTIONS = {1, 2, 3, 4, 6, 8, 12, 16, 24}
_RELATIONS = {"<": "<", "<=": "≤", ">": ">", ">=": "≥", "==": "=", "!=": "≠"}
_FUNCTIONS: Mapping[str, str] = {"Abs": "abs", "log": "ln", "sign": "sgn", "asin": "arcsin", "acos": "arccos", "atan": "arctan",
                                 "Min": "min", "Max": "max", "ceiling": "ceil"}
