"""Energies and their slopes as they are stated: squares of stretches stay, their insides are collected."""

from dataclasses import replace
from fractions import Fraction
from typing import TypeAlias

import sympy as sp

from lagrangia.algebra.with_sympy import Expr, slope
from lagrangia.base.records import dataclass
from lagrangia.paper.grouping import Group, spelled
from lagrangia.paper.layout import Bracket, Node, Numeral, Power, Total, total
from lagrangia.paper.shapes import Powers, merged, usual_number
from lagrangia.paper.terms import Signed, Terms, positive_first
from lagrangia.paper.typeset import line

Kept: TypeAlias = tuple[Expr, tuple[tuple[Expr, int], ...]]  # a factor, and sums with their powers that stay as they are


@dataclass
class StatedTerms(Terms):
    """Lays sums out without multiplying them out."""

    def gentle(self, expression: Expr) -> Node:
        """As the component stated it, with no sums of sums; or collected, where that is shorter."""
        plain, stated = self.sum(expression), self.stated(expression, is_nested=False)
        return stated if len(line(stated)) < len(line(plain)) else plain

    def stated(self, expression: Expr, is_nested: bool = True) -> Node:
        """Not multiplied out: brackets and squares of sums stay, in brackets too if `is_nested`; their insides are collected."""
        addends = sorted(sp.Add.make_args(expression), key=self.stated_key)
        return total(positive_first([item for x in addends for item in self._term_of(self._parted(x), is_nested)]))

    def stated_key(self, addend: Expr) -> tuple[object, ...]:
        """Loads last, before them weights; else by the parameters, in the order of the model."""
        symbols, s = addend.free_symbols, self.symbols
        places = sorted(self.grouping.rank(x)[1] for x in symbols if x in s.ranks and s.ranks[x][0] == 0)
        return bool(symbols & s.loads), bool(symbols & s.weights), places, spelled(addend)

    def stated_slope(self, expression: Expr, x: Expr, sign: int = 1) -> Node:
        """d/dx of what is stated, as the chain rule gives it: no bracket is multiplied out."""
        found: Signed = []
        for addend in sorted(sp.Add.make_args(expression), key=self.stated_key):
            rest, sums = self._parted(addend)
            changes: list[Kept] = [(slope(rest, x) * sign, sums)]
            for k, (base, power) in enumerate(sums):
                inner = self.ring.slope(base, x)
                others = tuple((b, p - (j == k)) for j, (b, p) in enumerate(sums) if p > 1 or j != k)
                is_sum = inner.is_Add and self.symbols.moves(inner)
                changes.append((rest * power * sign * (1 if is_sum else inner), (*others, *(((inner, 1),) if is_sum else ()))))
            found += [item for change in changes if change[0] != 0 for item in self._term_of(change, is_nested=False)]
        return total(positive_first(found))

    def _parted(self, addend: Expr) -> Kept:
        factors = sp.Mul.make_args(addend)
        sums = [x for x in factors if _is_sum(x) and self.symbols.moves(x)]
        rest = sp.Mul(*(x for x in factors if x not in sums))
        return rest, tuple((x.base, int(x.exp)) if x.is_Pow else (x, 1) for x in sums)

    def _term_of(self, kept: Kept, is_nested: bool) -> Signed:
        rest, sums = kept
        groups = self.grouping.groups(rest, self.ring)
        if not sums or len(groups) != 1:
            return self._multiplied_out(kept)
        sign, brackets, (outside,) = 1, [], groups
        for inside, power in sums:
            layout, number, pulled = self._inside(inside, is_nested, is_pulled=power == 1)
            if not isinstance(layout, Total):
                return self._multiplied_out(kept)
            if all(s < 0 for s, _ in layout.items):
                layout, sign = Total(tuple((1, node) for _, node in layout.items)), sign * (-1) ** power
            outside = replace(outside, number=outside.number * number, common=merged(outside.common, pulled))
            brackets.append(Bracket(layout) if power == 1 else Power(Bracket(layout), Numeral(Fraction(power))))
        outer, node = self.term(outside, brackets)
        if len(sums) == 1 and node == brackets[0] and isinstance(brackets[0], Bracket):
            return [(s * outer * sign, x) for s, x in opened(brackets[0].inside)]
        return [(outer * sign, node)]

    def _multiplied_out(self, kept: Kept) -> Signed:
        rest, sums = kept
        return opened(self.sum(sp.Mul(rest, *(base**power for base, power in sums)), self.gathered))

    def _inside(self, expression: Expr, is_nested: bool, is_pulled: bool) -> tuple[Node, Fraction, Powers]:
        if is_nested and any(_is_sum(x) and x.is_Pow for x in sp.preorder_traversal(expression)):
            return self.stated(expression), Fraction(1), ()
        groups = self.grouping.groups(expression, self.gathered)
        number, pulled, groups = pulled_out(groups) if is_pulled else (Fraction(1), (), groups)
        return total(positive_first([item for group in groups for item in self.items(group)])), number, pulled


def opened(node: Node) -> Signed:
    """The terms of a sum, or the one that it is."""
    return list(node.items) if isinstance(node, Total) else [] if node == Numeral(Fraction(0)) else [(1, node)]


def _is_sum(x: Expr) -> bool:
    return bool(x.is_Add or (x.is_Pow and x.base.is_Add and x.exp.is_Integer and x.exp > 0))


def pulled_out(groups: list[Group]) -> tuple[Fraction, Powers, list[Group]]:
    """The number and the parameters that all groups share, and the groups without them."""
    number = abs(usual_number([g.number for g in groups])) if len(groups) > 1 else Fraction(1)
    common = dict(groups[0].common) if len(groups) > 1 else {}
    for g in groups[1:]:
        here = dict(g.common)
        common = {x: min(k, here[x]) for x, k in common.items() if x in here and k > 0 and here[x] > 0}
    common = {x: k for x, k in common.items() if k > 0}
    def less(powers: Powers) -> Powers:
        return tuple((x, k - common.get(x, Fraction(0))) for x, k in powers if k != common.get(x))

    return number, tuple(common.items()), [replace(g, number=g.number / number, common=less(g.common)) for g in groups]
