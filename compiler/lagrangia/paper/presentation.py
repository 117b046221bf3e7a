"""Equations, momenta, quotients and energies -> layouts: what stands in which place of a sum; see terms.py for its terms."""

from fractions import Fraction

import sympy as sp

from lagrangia.algebra.with_sympy import Expr
from lagrangia.base.records import dataclass
from lagrangia.paper.grouping import Group, Symbols
from lagrangia.paper.layout import Bracket, Node, Numeral, Power, Quotient, Relation, Total, product, total
from lagrangia.paper.shapes import Powers
from lagrangia.paper.stated import StatedTerms, opened, pulled_out
from lagrangia.paper.terms import Signed, positive_first
from lagrangia.paper.typeset import line


@dataclass
class Presentation(StatedTerms):
    """Lays the formulas of a scene out."""

    def equation(self, left: Expr, right: Expr = sp.S.Zero, own: int | None = None) -> Relation:
        """left = right, what depends on neither coordinates nor rates on the right, the acceleration of `own` first."""
        stays, goes = self._sides(left)
        if not stays:
            stays, goes = goes, []
        stretches, goes = self._stretches(stays, goes)
        here = self._accelerations(sp.Add(*(x for x in stays if x not in [s for s, *_ in stretches])), own)
        items = [*opened(here), *(item for _, item in stretches)] if stretches else opened(here)
        return Relation(total(items), self.sum(right - sp.Add(*goes)))

    def _sides(self, left: Expr) -> tuple[list[Expr], list[Expr]]:
        s = self.symbols
        kept = {*s.coordinates, *s.rates, *s.accelerations, *s.multipliers}
        terms = [term.expression() for term in self.ring.terms(left)]
        given = [x for x in terms if not x.free_symbols & kept
                 or (x.free_symbols & s.loads and not x.free_symbols & (kept - set(s.coordinates)))]
        return [x for x in terms if x not in given], given

    def _stretches(self, stays: list[Expr], goes: list[Expr]) -> tuple[list[tuple[Expr, tuple[int, Node]]], list[Expr]]:
        """k s and - k L0 as k (s - L0), where no other term is linear in s: the terms that are so held, and what still goes."""
        found: list[tuple[Expr, tuple[int, Node]]] = []
        for q in self.symbols.coordinates:
            mine = [x for x in stays if x.has(q) and not self.symbols.moves(x / q)]
            pairs = [(x, g) for x in mine if len(mine) == 1 for g in goes if _is_offset(-g / (x / q))]
            if len(pairs) == 1 and len(stays) > 1:
                x, g = pairs[0]
                bracket = Bracket(total([(1, self.node(q)), *((-sign, node) for sign, node in opened(self.sum(-g / (x / q))))]))
                (group,) = self.grouping.groups(x / q, self.ring)
                found.append((x, self.term(group, [bracket])))
                goes = [y for y in goes if y != g]
        return found, goes

    def kept(self, left: Expr, right: Expr, own: int | None = None) -> Relation:
        """left = right as they are, the acceleration of `own` first."""
        return Relation(self._accelerations(left, own), self._accelerations(right, None))

    def momentum(self, expression: Expr, own: int | None = None) -> Node:
        """A sum of coefficients times rates, that of `own` first."""
        items: Signed = []
        rest = expression
        rates = list(self.symbols.rates)
        if own is not None:
            rates.insert(0, rates.pop(own))
        for v in rates:
            mine = sp.Add(*(x for x in sp.Add.make_args(rest) if x.has(v)))
            items += self._factored(mine, v) if mine != 0 else []
            rest = rest - mine
        items += [item for group in (self._groups(rest) if rest != 0 else []) for item in self.items(group)]
        return total(positive_first(items))

    def motion(self, expression: Expr) -> Node:
        """A velocity as the kinematics made it, sums of rates kept together."""
        found = self.sum(expression, self.gathered)
        return found.inside if isinstance(found, Bracket) else found

    def quotient(self, top: Expr, bottom: Expr) -> Node:
        """top/bottom in lowest terms; divided out where the bottom is one term and that is no longer."""
        if len(self.ring.terms(bottom)) != 1:
            return Quotient(self.sum(top), self.coefficient(bottom))
        divided, groups = self.sum(top / bottom), self._groups(top / bottom)
        shared = dict(groups[0].common + groups[0].dynamic) if groups else {}
        for g in groups[1:]:
            here = dict(g.common + g.dynamic)
            shared = {x: max(k, here[x]) for x, k in shared.items() if here.get(x, 0) < 0 and k < 0}
        below = sp.Mul(*(sp.Pow(x, -sp.Rational(k.numerator, k.denominator)) for x, k in shared.items() if k < 0))
        if below == 1 or len(groups) == 1:
            return divided
        whole = Quotient(self.sum(top / bottom * below), self.sum(below))
        return divided if len(line(divided)) <= len(line(whole)) else whole

    @staticmethod
    def over(top: Node, bottom: Node) -> Node:
        """The quotient of two formulas."""
        return Quotient(top, bottom)

    @staticmethod
    def square(base: Node) -> Node:
        """The square of a formula."""
        return Power(base, Numeral(Fraction(2)))

    def _groups(self, expression: Expr) -> list[Group]:
        return self.grouping.groups(expression, self.ring)

    def _accelerations(self, expression: Expr, own: int | None) -> Node:
        """Terms of one acceleration in one bracket, `own` first."""
        accelerations = list(self.symbols.accelerations)
        if own is not None:
            accelerations.insert(0, accelerations.pop(own))
        terms = [term.expression() for term in self.ring.terms(expression)]
        items: Signed = []
        for a in accelerations:
            mine = sp.Add(*(x for x in terms if x.has(a)))
            items += self._factored(mine, a) if mine != 0 else []
        several = {*accelerations, *self.symbols.multipliers}
        rest = sp.Add(*(x for x in terms if not x.free_symbols & several))
        items += [item for g in self._groups(rest) for item in self.items(g)]
        for x in self.symbols.multipliers:
            mine = sp.Add(*(term for term in terms if term.has(x)))
            items += self._factored(mine, x) if mine != 0 else []
        return total(items)

    def _factored(self, expression: Expr, a: Expr) -> Signed:
        groups = self._groups(expression)
        if len(groups) == 1:
            return [self.term(groups[0])]
        number, pulled, groups = pulled_out(self._groups(expression / a))
        coefficient, sign = self._constants_first(groups), 1
        if isinstance(coefficient, Total) and all(s < 0 for s, _ in coefficient.items):
            coefficient, sign = Total(tuple((-s, item) for s, item in coefficient.items)), -1
        factors = self._shared(number, pulled)
        return [(sign, product([*factors, coefficient, self.symbols.names[a]]))]

    def coefficient(self, expression: Expr) -> Node:
        """A sum with what does not move first, what its terms share outside: an entry of M."""
        number, pulled, groups = pulled_out(self._groups(expression))
        inside, shared = self._constants_first(groups), self._shared(number, pulled)
        if not shared or not isinstance(inside, Total):
            return self._constants_first(self._groups(expression))
        return product([*shared, inside])

    def _shared(self, number: Fraction, powers: Powers) -> list[Node]:
        """Factors that stand before a bracket."""
        numbers: list[Node] = [self.number(number)] if number != 1 else []
        return [*numbers, *(self.power(x, k) for x, k in sorted(powers, key=self._factor_key))]

    def _constants_first(self, groups: list[Group]) -> Node:
        groups = sorted(groups, key=lambda g: not g.is_constant)
        return total(positive_first([item for g in groups for item in self.items(g)]))


def _is_offset(x: Expr) -> bool:
    """A single parameter, or a part of one."""
    return isinstance(x.as_coeff_Mul()[1], sp.Symbol)


__all__ = ["Presentation", "Symbols"]
