"""Expressions -> sums of products of sines and cosines, each product turned into a sum, so that what is equal meets and cancels.

A term is a number times whole powers of quantities times the sine or cosine of one angle; an angle is a sum of quantities with
numbers in front. sin a cos b = (sin(a + b) + sin(a - b))/2 and its like leave no products of sines: c*(c*w*w) + s*(s*w*w) becomes
w*w. Sums in a denominator, roots and other functions are left as they are, quantities of their own.
"""

import math
from collections.abc import Callable, Mapping, Sequence, Set
from dataclasses import field

import casadi as ca

from lagrangia.algebra.scalars import Expression, apply, apply_to_one, as_expression, symbols_in
from lagrangia.base.records import dataclass

_MOST_PRODUCTS = 2_500  # of two terms, some 2 us each: a chain of six takes 1 500
_ROUNDING = 1e-14
_HIGHEST_POWER = 4

Powers = tuple[tuple[int, int], ...]  # (quantity, exponent), sorted
Angle = tuple[tuple[Powers, float], ...]  # (product of quantities, number in front), sorted
Key = tuple[Powers, Angle, bool]  # a sine? No angle, no sine: the cosine of 0
Sum = dict[Key, float]


class TooLarge(Exception):
    """There are more terms than are worth it."""


@dataclass
class Harmonics:
    """The quantities met so far, by number. `given` are sums that stand for symbols, by their hashes; `fixed` and `levers` are
    the hashes of symbols whose differences are quantities of their own in products: (R - r)^2 multiplied out loses its digits
    where r is nearly R. Levers have either sign: of them sums are, too."""

    given: Mapping[int, Sum] = field(default_factory=dict)
    fixed: Set[int] = frozenset()
    levers: Set[int] = frozenset()
    quantities: list[Expression] = field(default_factory=list)
    is_fixed: list[bool] = field(default_factory=list)
    is_lever: list[bool] = field(default_factory=list)
    numbers: dict[int, int] = field(default_factory=dict)  # by the hash of the expression
    differences: dict[tuple[tuple[Powers, float], ...], Expression] = field(default_factory=dict)
    left: int = _MOST_PRODUCTS

    def quantity(self, x: Expression) -> Sum:
        """The term that is x itself."""
        number = self.numbers.setdefault(x.__hash__(), len(self.quantities))
        if number == len(self.quantities):
            self.quantities.append(x)
            symbols = symbols_in(x)
            self.is_fixed.append(symbols <= self.fixed | self.levers)
            self.is_lever.append(not symbols.isdisjoint(self.levers))
        return {(((number, 1),), (), False): 1.0}

    def sums(self, column: ca.SX) -> list[Sum]:
        """The elements of a column. Raises TooLarge."""
        column = ca.cse(column)
        symbols = ca.symvar(column)
        if not symbols:
            return [_number(float(x)) for x in column.elements()]
        function = ca.Function("harmonics", [ca.vertcat(*symbols)], [ca.densify(column)])
        leaves = [self.given.get(s.__hash__()) or self.quantity(as_expression(s)) for s in symbols]
        work: dict[int, tuple[Expression, Sum]] = {}
        found: list[Sum] = [{} for _ in range(column.numel())]
        for k in range(function.n_instructions()):
            op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if op == ca.OP_OUTPUT:
                found[outputs[1]] = work[inputs[0]][1]
            elif op == ca.OP_INPUT:
                work[outputs[0]] = as_expression(symbols[inputs[1]]), leaves[inputs[1]]
            elif op == ca.OP_CONST:
                number = function.instruction_constant(k)
                work[outputs[0]] = as_expression(number), _number(number)
            else:
                work[outputs[0]] = self._made(op, [work[place] for place in inputs])
        return found

    def _made(self, op: int, operands: list[tuple[Expression, Sum]]) -> tuple[Expression, Sum]:
        values = [value for value, _ in operands]
        value = apply_to_one(op, values[0]) if len(values) == 1 else apply(op, *values)
        rule = _RULES.get(op)
        found = rule(self, *(terms for _, terms in operands)) if rule is not None else None
        return value, self.quantity(value) if found is None else found

    # ------------------------------------------------------------ rules; None where the result is a quantity of its own

    def product(self, a: Sum, b: Sum) -> Sum:
        """a b by sums and differences of angles. Raises TooLarge."""
        a, b = self._drawn(a), self._drawn(b)
        self.left -= len(a) * len(b)
        if self.left < 0:
            raise TooLarge
        total: Sum = {}
        for (powers_a, angle_a, sine_a), x in a.items():
            for (powers_b, angle_b, sine_b), y in b.items():
                powers = _merged(powers_a, powers_b)
                for angle, is_sine, weight in _waves(angle_a, sine_a, angle_b, sine_b):
                    _add(total, (powers, angle, is_sine), x * y * weight)
        return total

    def _drawn(self, a: Sum) -> Sum:
        """The same sum, with differences of what is fixed drawn together: L v - R/r L v is (1 - R/r) L v, and s + L with s."""
        if len(a) < 2 or not self.fixed:
            return a
        groups: dict[Key, dict[Powers, float]] = {}
        for (powers, angle, is_sine), x in a.items():
            own, other = (tuple(factor for factor in powers if self.is_fixed[factor[0]] == kind) for kind in (True, False))
            groups.setdefault((other, angle, is_sine), {})[own] = x
        total: Sum = {}
        for (other, angle, is_sine), parts in groups.items():
            has_lever = len(parts) > 1 and any(self.is_lever[n] for powers in parts for n, _ in powers)
            is_difference = has_lever or min(parts.values()) < 0 < max(parts.values())
            drawn = self._difference(parts) if is_difference else parts
            total |= {(_merged(own, other), angle, is_sine): x for own, x in drawn.items()}
        return total

    def _difference(self, parts: Mapping[Powers, float]) -> dict[Powers, float]:
        """One term: what all have in common, times a quantity that begins with 1."""
        named = {n for powers in parts for n, _ in powers}
        common = tuple(sorted((n, min(dict(powers).get(n, 0) for powers in parts)) for n in named))
        common = tuple((n, k) for n, k in common if k)
        rest = sorted((_merged(powers, tuple((n, -k) for n, k in common)), x) for powers, x in parts.items())
        first = rest[0][1]
        total = as_expression(0.0)
        for powers, x in rest:
            product = as_expression(x / first)
            for n, k in powers:
                product = as_expression(product * self.quantities[n] ** k)
            total = as_expression(total + product)
        key = tuple((powers, x / first) for powers, x in rest)
        (((own, _, _), _),) = self.quantity(self.differences.setdefault(key, total)).items()
        return {_merged(common, own): first}

    def quotient(self, a: Sum, b: Sum) -> Sum | None:
        """By a single term without an angle."""
        if len(b) != 1:
            return None
        (((powers, angle, _), x),) = b.items()
        if angle or not a:
            return None if angle else {}
        return self.product(a, {(tuple((n, -k) for n, k in powers), (), False): 1 / x})

    def power(self, a: Sum, b: Sum) -> Sum | None:
        """a^b for small whole b; None for others."""
        exponent = b.get(_ONE, 0.0) if set(b) <= {_ONE} else 0.5
        if exponent != int(exponent) or not 1 <= exponent <= _HIGHEST_POWER:
            return None
        total = a
        for _ in range(int(exponent) - 1):
            total = self.product(total, a)
        return total

    def circular(self, a: Sum, is_sine: bool) -> Sum | None:
        """sin a or cos a of a linear a; None for others."""
        if any(angle for _, angle, _ in a):
            return None
        turned = _oriented(tuple(sorted((powers, x) for (powers, _, _), x in a.items())), is_sine)
        return {} if turned is None else {((), turned[0], turned[1]): turned[2]}


_ONE: Key = ((), (), False)


def _number(x: float) -> Sum:
    return {_ONE: x} if x else {}


def _add(total: Sum, key: Key, x: float) -> None:
    before = total.get(key)
    if before is None:
        total[key] = x
    elif abs(before + x) <= _ROUNDING * abs(x):
        del total[key]
    else:
        total[key] = before + x


def added(a: Sum, b: Sum, factor: float = 1.0) -> Sum:
    """a + factor b"""
    total = dict(a)
    for key, x in b.items():
        _add(total, key, factor * x)
    return total


def scaled(a: Sum, factor: float) -> Sum:
    """a times a number."""
    return {key: factor * x for key, x in a.items()} if factor else {}


def _merged(a: Powers, b: Powers) -> Powers:
    if not a or not b:
        return a or b
    total = dict(a)
    for number, exponent in b:
        total[number] = total.get(number, 0) + exponent
    return tuple(sorted((number, exponent) for number, exponent in total.items() if exponent))


def _waves(a: Angle, sine_a: bool, b: Angle, sine_b: bool) -> list[tuple[Angle, bool, float]]:
    """The product of two waves as a sum."""
    if not a or not b:
        return [(a or b, sine_a or sine_b, 1.0)]
    minus, plus = _angle(a, b, -1.0), _angle(a, b, 1.0)
    if sine_a and sine_b:
        pairs = [(minus, False, 0.5), (plus, False, -0.5)]
    elif sine_a or sine_b:
        pairs = [(plus, True, 0.5), (minus, True, 0.5 if sine_a else -0.5)]
    else:
        pairs = [(minus, False, 0.5), (plus, False, 0.5)]
    found = []
    for angle, is_sine, weight in pairs:
        turned = _oriented(angle, is_sine)
        if turned is not None:
            found.append((turned[0], turned[1], weight * turned[2]))
    return found


def _angle(a: Angle, b: Angle, sign: float) -> Angle:
    total = dict(a)
    for powers, x in b:
        total[powers] = total.get(powers, 0.0) + sign * x
    return tuple(sorted((powers, x) for powers, x in total.items() if abs(x) > _ROUNDING))


def _oriented(angle: Angle, is_sine: bool) -> tuple[Angle, bool, float] | None:
    """With the first number positive, and without quarter turns; a sign in front. None: zero."""
    sign = 1.0
    quarters = dict(angle).get((), 0.0) / (math.pi / 2)
    if quarters and abs(quarters - round(quarters)) < _ROUNDING * max(1.0, abs(quarters)):
        angle = tuple((powers, x) for powers, x in angle if powers)
        for _ in range(round(quarters) % 4):  # sin(x + pi/2) = cos x, cos(x + pi/2) = -sin x
            is_sine, sign = not is_sine, sign if is_sine else -sign
    if not angle:
        return None if is_sine else ((), False, sign)
    if angle[-1][1] < 0:
        angle = tuple((powers, -x) for powers, x in angle)
        sign = -sign if is_sine else sign
    return angle, is_sine, sign


_RULES: Mapping[int, Callable[..., Sum | None]] = {
    ca.OP_ADD: lambda h, a, b: added(a, b), ca.OP_SUB: lambda h, a, b: added(a, b, -1.0), ca.OP_MUL: Harmonics.product,
    ca.OP_NEG: lambda h, a: scaled(a, -1.0), ca.OP_TWICE: lambda h, a: scaled(a, 2.0), ca.OP_ASSIGN: lambda h, a: a,
    ca.OP_SQ: lambda h, a: h.product(a, a), ca.OP_DIV: Harmonics.quotient, ca.OP_INV: lambda h, a: h.quotient({_ONE: 1.0}, a),
    ca.OP_POW: Harmonics.power, ca.OP_CONSTPOW: Harmonics.power,
    ca.OP_SIN: lambda h, a: h.circular(a, True), ca.OP_COS: lambda h, a: h.circular(a, False),
}


def combined(rows: Sequence[Sequence[float]], sums: Sequence[Sum]) -> list[Sum]:
    """The matrix of numbers times the column of sums."""
    found = []
    for row in rows:
        total: Sum = {}
        for x, terms in zip(row, sums, strict=True):
            if x:
                total = added(total, terms, x)
        found.append(total)
    return found
