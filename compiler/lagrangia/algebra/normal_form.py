"""Normal form of expressions: sums of rational numbers x powers of atoms x the cosine or sine of one sum of angles.

    2 cos a cos b = cos(a - b) + cos(a + b)    2 sin a sin b = cos(a - b) - cos(a + b)    2 sin a cos b = sin(a + b) + sin(a - b)

In it every identity between sines and cosines has become the cancellation of equal terms (the Poisson series of celestial
mechanics; Deprit and Rom, 1968), so nothing is ever guessed. Roots and quotients of sums are atoms. The work is bounded by a
count of products, never by a clock.
"""

from collections.abc import Iterable, Mapping
from fractions import Fraction
from itertools import combinations

import sympy as sp

from lagrangia.algebra.with_sympy import TIME, Expr, exact, slope
from lagrangia.base.records import dataclass

Number = int | Fraction  # whole numbers are int where they are made: sums, products and hashes of these take a tenth of the time
Powers = tuple[tuple[int, Number], ...]  # of atoms, by their numbers
Angle = tuple[tuple[int, Number], ...]  # sum of coefficient x atom
Key = tuple[Powers, Angle, bool]  # the last: sine
Series = dict[Key, Number]

CONSTANT: Key = ((), (), False)


class TooLarge(Exception):
    """The normal form would take more products, or have more terms, than allowed: `terms` is how many there are at least.

    `kinetic` is T, where that much is known.
    """

    def __init__(self, terms: int, kinetic: Expr | None = None) -> None:
        self.terms, self.kinetic = terms, kinetic
        super().__init__(f"more than {terms} terms")


@dataclass(frozen=True)
class Term:
    """number x powers of atoms x trigonometric factors."""

    number: Fraction
    powers: tuple[tuple[Expr, Fraction], ...]
    trigonometric: tuple[tuple[Expr, int], ...]  # sin(..) or cos(..) with exponents

    def expression(self) -> Expr:
        """As SymPy writes it."""
        factors = [sp.Pow(atom, _rational(k)) for atom, k in self.powers] + [f**k for f, k in self.trigonometric]
        return sp.Mul(_rational(self.number), *factors)


class Ring:
    """Numbers the atoms, and counts the work. Sums of `kept` symbols alone stay as they are: phi' + psi'."""

    def __init__(self, most_products: int, kept: frozenset[Expr] = frozenset()) -> None:
        self.most, self.products, self.kept = most_products, 0, kept
        self.atoms: list[Expr] = []
        self.numbers: dict[Expr, int] = {}
        self.composite: dict[int, Series] = {}  # atoms that are sums: their whole powers are multiplied out
        self.squares: dict[int, Series] = {}  # of atoms by others
        self.roots: dict[int, Fraction] = {}  # atoms that are square roots of numbers: the numbers
        self._known: dict[Expr, Series] = {}
        self._inside: dict[int, frozenset[Expr]] = {}  # symbols of atoms
        self.stated: set[tuple[Angle, bool]] = set()  # sines and cosines that were met as such
        self.whole = {self._atom(sp.pi)}  # atoms of angles that are not halved: pi, and what depends on time alone
        self.pi = 0

    def know_square(self, atom: Expr, square: Expr) -> None:
        """From now on the square of an atom is this sum of others: of unit quaternions."""
        number = self._number(atom)
        self.squares[number] = self.series(square)

    def tidy(self, expression: Expr) -> Expr:
        """The expression in normal form, as few terms as the pairing of sines and cosines gives."""
        return self._tidied(self.series(expression))

    def _tidied(self, series: Series) -> Expr:
        """Known by what it came from: nothing is multiplied out again, unless SymPy knows more of a function, |x|^2 = x^2."""
        found = sp.Add(*(term.expression() for term in self._written(series)))
        if not any(self.atoms[n].is_Function for powers, _, _ in series for n, _ in powers):
            self._known[found] = series
        return found

    def slope(self, expression: Expr, x: Expr) -> Expr:
        """d/dx, tidy: term by term, where x stands by itself or in a sum of angles."""
        found = self._slope(self.series(expression), x)
        return self.tidy(slope(expression, x)) if found is None else self._tidied(found)

    def along(self, expression: Expr, pairs: Iterable[tuple[Expr, Expr]]) -> Expr:
        """sum of d/dx times dx over the pairs (x, dx), tidy."""
        pairs = list(pairs)
        slopes = [(self._slope(self.series(expression), x), dx) for x, dx in pairs]
        if any(series is None for series, _ in slopes):
            return self.tidy(sp.Add(*(slope(expression, x) * dx for x, dx in pairs if expression.has(x))))
        return self._tidied(_sum(self.product(series, self.series(dx)) for series, dx in slopes if series))

    def terms(self, expression: Expr) -> list[Term]:
        """The terms of the normal form."""
        return self._written(self.series(expression))

    def is_zero(self, expression: Expr) -> bool:
        """Whether nothing is left of it in the normal form."""
        return not self.series(expression)

    # ------------------------------------------------------------ expression -> series

    def series(self, expression: Expr) -> Series:
        """Raises TooLarge."""
        if expression not in self._known:
            self._known[expression] = self._series(sp.sympify(expression))
        return self._known[expression]

    def _series(self, e: Expr) -> Series:
        if e.is_Rational:
            return {CONSTANT: _number_of(e)} if e != 0 else {}
        if e.is_Float and e.is_finite:
            return self._series(exact(float(e)))
        if e.is_Symbol or e.is_Number or isinstance(e, sp.NumberSymbol):
            return self._atom_series(e)
        if e.is_Add and self.kept and all(x.as_coeff_Mul()[1] in self.kept for x in e.args):
            return self._atom_series(e)
        if e.is_Add:
            return _sum(self.series(x) for x in e.args)
        if e.is_Mul:
            total: Series = {CONSTANT: 1}
            for x in e.args:
                total = self.product(total, self.series(x))
            return total
        if e.is_Pow:
            return self._power(e)
        if isinstance(e, sp.sin | sp.cos):
            return self._wave(e)
        return self._opaque(e)

    def _power(self, e: Expr) -> Series:
        base, exponent = e.args
        if exponent.is_Integer and exponent > 0:
            return self._whole_power(self.series(base), int(exponent))
        if not exponent.is_Rational:
            return self._opaque(e)
        inner = self.series(base)
        k = _number_of(exponent)
        if len(inner) == 1:
            ((powers, angle, is_sine), number), = inner.items()
            if exponent.is_Integer and not angle:
                raised = tuple((n, x * k) for n, x in powers)
                return self.product({(raised, (), False): Fraction(number) ** int(exponent)}, {CONSTANT: 1})
            if angle and exponent.is_Integer:
                sign, wave = self._wave_expression(angle, is_sine)
                whole = self._merged(tuple((n, x * k) for n, x in powers), ((self._number(wave), k),))
                return {(whole, (), False): Fraction(sign * number) ** int(exponent)}
        tidy = sp.Add(*(t.expression() for t in self._written(inner)))
        found = sp.Pow(tidy, exponent)
        if found.is_Pow and found.args == (tidy, exponent) and tidy.is_Add:
            number_of = self._number(tidy)
            self.composite[number_of] = inner
            return {(((number_of, k),), (), False): 1}
        return self._atom_series(found) if found == e or not found.is_Mul else self.series(found)

    def _whole_power(self, base: Series, exponent: int) -> Series:
        total: Series = {CONSTANT: 1}
        for bit in f"{exponent:b}":
            total = self.product(total, total)
            if bit == "1":
                total = self.product(total, base)
        return total

    def _wave(self, e: Expr) -> Series:
        """sin or cos of a sum of multiples of anything that is no sum."""
        inner = self.series(e.args[0])
        if any(angle for _, angle, _ in inner):
            return self._opaque(e)
        parts: dict[int, Number] = {}
        for (powers, _, _), number in inner.items():
            atom = sp.Mul(*(sp.Pow(self.atoms[n], _rational(k)) for n, k in powers))
            where = self._number(atom)
            parts[where] = parts.get(where, 0) + number
        key, sign = self._oriented(_sorted(parts), isinstance(e, sp.sin))
        self.stated.add(key)
        return {} if sign == 0 else {((), *key): sign}

    def _oriented(self, angle: Angle, is_sine: bool) -> tuple[tuple[Angle, bool], int]:
        """The same wave with its first coefficient positive and whole quarter turns taken out."""
        sign, parts = 1, dict(angle)
        turns = parts.pop(self.pi, 0)
        if parts and next(iter(sorted(parts.items())))[1] < 0:
            parts, turns = {n: -x for n, x in parts.items()}, -turns
            sign = -sign if is_sine else sign
        quarters = int((turns * 2) // 1)
        turns -= Fraction(quarters, 2)
        for _ in range(quarters % 4):  # sin(x + pi/2) = cos x, cos(x + pi/2) = -sin x
            sign, is_sine = (sign, False) if is_sine else (-sign, True)
        if turns:
            parts[self.pi] = turns
        if not parts:
            return ((), False), 0 if is_sine else sign
        return (_sorted(parts), is_sine), sign

    def _opaque(self, e: Expr) -> Series:
        if e.args and not isinstance(e, sp.Piecewise):
            e = e.func(*(self.tidy(x) if isinstance(x, sp.Expr) else x for x in e.args))
        return self._series(e) if e.is_Add or e.is_Mul or e.is_Number else self._atom_series(e)

    def _atom_series(self, e: Expr) -> Series:
        n = self._number(e)
        if e.is_Pow and e.exp == sp.S.Half and e.base.is_Rational:
            self.roots[n] = Fraction(int(e.base.p), int(e.base.q))
        return {(((n, 1),), (), False): 1}

    def _atom(self, e: Expr) -> int:
        self.numbers[e] = len(self.atoms)
        if TIME in e.free_symbols:
            self.whole.add(len(self.atoms))
        self.atoms.append(e)
        return self.numbers[e]

    def _number(self, e: Expr) -> int:
        return self.numbers[e] if e in self.numbers else self._atom(e)

    # ------------------------------------------------------------ derivatives

    def _slope(self, series: Series, x: Expr) -> Series | None:
        """None where x stands inside an atom: under a root, in a function."""
        total: Series = {}
        here = self._number(x)
        for (powers, angle, is_sine), number in series.items():
            for n, _ in (*powers, *angle):
                if n != here and self._depends(n, x):
                    return None
            for k in (k for n, k in powers if n == here):
                less = tuple((n, p - (n == here)) for n, p in powers if n != here or p != 1)
                _add(total, (less, angle, is_sine), number * k)
            for k in (k for n, k in angle if n == here):
                _add(total, (powers, angle, not is_sine), number * k if is_sine else -number * k)
        return {key: value for key, value in total.items() if value}

    def _depends(self, n: int, x: Expr) -> bool:
        if n not in self._inside:
            self._inside[n] = frozenset(self.atoms[n].free_symbols)
        return x in self._inside[n]

    # ------------------------------------------------------------ products

    def product(self, a: Series, b: Series) -> Series:
        """a b in normal form. Raises TooLarge."""
        self.products += len(a) * len(b)
        if self.products > self.most:
            raise TooLarge(max(len(a), len(b), len(a) * len(b)))
        total: Series = {}
        again: list[Series] = []
        for (powers_a, angle_a, sine_a), x in a.items():
            for (powers_b, angle_b, sine_b), y in b.items():
                powers = self._merged(powers_a, powers_b)
                waves = self._waves(angle_a, sine_a, angle_b, sine_b)
                into = total if not any(self._opens(n, k) for n, k in powers) else {}
                for angle, is_sine, halves in waves:
                    key = (powers, angle, is_sine)
                    into[key] = into.get(key, 0) + x * y * halves
                if into is not total:
                    again.append(self._multiplied_out(powers, _of_halves(into)))
        return _sum([_of_halves(total), *again])

    def _opens(self, n: int, k: Number) -> bool:
        return (k >= 1 and n in self.composite) or (k >= 2 and n in self.squares) or (n in self.roots and k not in (0, 1))

    def _multiplied_out(self, powers: Powers, terms: Series) -> Series:
        """Whole powers of sums, left when roots met, and squares that are known: of roots of numbers those that divide, too."""
        whole = {n: int(k) for n, k in powers if n in self.composite and k >= 1}
        twice = {n: int(k) // 2 for n, k in powers if n in self.squares and k >= 2}
        of_numbers = {n: int(k // 2) for n, k in powers if n in self.roots}
        taken = whole | {n: 2 * k for n, k in (twice | of_numbers).items()}
        for n, k in of_numbers.items():
            terms = {key: x * self.roots[n] ** k for key, x in terms.items()}
        rest = tuple((n, k - taken.get(n, 0)) for n, k in powers if k != taken.get(n, 0))
        found: Series = {(rest, angle, is_sine): x for (_, angle, is_sine), x in terms.items()}
        for n, k in whole.items():
            found = self.product(found, self._whole_power(self.composite[n], k))
        for n, k in twice.items():
            found = self.product(found, self._whole_power(self.squares[n], k))
        return found

    @staticmethod
    def _merged(a: Powers, b: Powers) -> Powers:
        if not a or not b:
            return a or b
        total = dict(a)
        for n, k in b:
            total[n] = total.get(n, 0) + k
        return tuple(sorted((n, k) for n, k in total.items() if k))

    def _waves(self, a: Angle, sine_a: bool, b: Angle, sine_b: bool) -> list[tuple[Angle, bool, int]]:
        """The waves of a product, each with how often half of it is there."""
        if not a or not b:
            return [(a or b, sine_a or sine_b, 2)]
        plus, minus = _added(a, b, 1), _added(a, b, -1)
        if sine_a and sine_b:
            found = [(minus, False, 1), (plus, False, -1)]
        elif sine_a:
            found = [(plus, True, 1), (minus, True, 1)]
        elif sine_b:
            found = [(plus, True, 1), (minus, True, -1)]
        else:
            found = [(minus, False, 1), (plus, False, 1)]
        turned = []
        for angle, is_sine, halves in found:
            key, sign = self._oriented(angle, is_sine)
            if sign:
                turned.append((*key, halves * sign))
        return turned

    # ------------------------------------------------------------ series -> terms

    def _written(self, series: Series) -> list[Term]:
        groups: dict[Powers, dict[_Wave, Number]] = {}
        for (powers, angle, is_sine), x in series.items():
            groups.setdefault(powers, {})[angle, is_sine] = x
        terms = []
        for powers, waves in groups.items():
            atoms = tuple((self.atoms[n], k) for n, k in powers)
            for number, factors in _paired(waves, self.whole, self.stated):
                x = number
                merged: dict[Expr, int] = {}
                for angle, is_sine in factors:
                    sign, wave = self._wave_expression(angle, is_sine)
                    merged[wave] = merged.get(wave, 0) + 1
                    x *= sign
                terms.append(_term(x, atoms, merged))
        return terms

    def _wave_expression(self, angle: Angle, is_sine: bool) -> tuple[Number, Expr]:
        """A number times what SymPy makes of the wave, who writes -sin(a - b) for sin(b - a), 1/2 for cos(pi/3)."""
        total = sp.Add(*(_rational(k) * self.atoms[n] for n, k in angle))
        number, wave = (sp.sin(total) if is_sine else sp.cos(total)).as_coeff_Mul(rational=True)
        return _number_of(number), wave


# -------------------------------------------------------------------- pairing

_Wave = tuple[Angle, bool]


def _paired(waves: dict[_Wave, Number], whole: set[int], stated: set[_Wave]) -> list[tuple[Number, list[_Wave]]]:
    """1 - cos 2a = 2 sin^2 a, 1 + cos 2a = 2 cos^2 a, and beside another constant cos 2a = 2 cos^2 a - 1; sin 2a = 2 sin a cos a,
    unless sin 2a is stated somewhere; cos p + cos q and its like as products, where that leaves fewer angles in all."""
    waves, found = dict(waves), []
    constant: _Wave = ((), False)
    for wave in sorted(waves):
        angle, is_sine = wave
        half = _halved(angle, whole)
        if half is None or wave not in waves:
            continue
        if not is_sine and abs(waves.get(constant, 0)) == abs(waves[wave]):
            x = waves.pop(constant)
            found.append((2 * x, [(half, waves.pop(wave) == -x)] * 2))  # 1 - cos: twice the square of a sine; 1 + cos
        elif is_sine and (waves[wave].denominator % 2 == 0 or _is_double(wave, whole, stated)):
            found.append((2 * waves.pop(wave), [(half, True), (half, False)]))
        elif not is_sine and constant in waves and _is_double(wave, whole, stated):
            waves[constant] -= waves[wave]
            found.append((2 * waves.pop(wave), [(half, False)] * 2))
    for one, other in combinations(sorted(waves), 2):
        if one in waves and other in waves:
            product = _as_product(one, other, waves[one], waves[other], whole)
            if product is not None:
                del waves[one], waves[other]
                found.append(product)
    found += [(x, [wave] if wave[0] else []) for wave, x in waves.items()]
    return found


def _is_double(wave: _Wave, whole: set[int], stated: set[_Wave]) -> bool:
    """Of an angle whose half cannot be halved once more, and not stated as such."""
    half = _halved(wave[0], whole)
    return wave not in stated and half is not None and _halved(half, whole) is None


def _as_product(p: _Wave, q: _Wave, x: Number, y: Number, whole: set[int]) -> tuple[Number, list[_Wave]] | None:
    if p[1] != q[1] or abs(x) != abs(y) or not p[0] or not q[0]:
        return None
    is_mixed = all(any(n in whole for n, _ in angle) and any(n not in whole for n, _ in angle) for angle in (p[0], q[0]))
    kept: set[int] = set() if is_mixed else whole  # sin(a + 3t) and sin(a - 3t) are made of sin a cos 3t
    half, gap = _halved(_added(p[0], q[0], 1), kept), _halved(_added(p[0], q[0], -1), kept)
    if not half or not gap or len(half) + len(gap) >= len(p[0]) + len(q[0]):
        return None
    turned = gap[0][1] < 0
    gap = tuple((n, -k) for n, k in gap) if turned else gap
    flip = -1 if turned else 1  # sin(-gap)
    if p[1]:  # sin p + sin q = 2 sin cos,  sin p - sin q = 2 cos sin
        return (2 * x, [(half, True), (gap, False)]) if x == y else (2 * x * flip, [(half, False), (gap, True)])
    return (2 * x, [(half, False), (gap, False)]) if x == y else (-2 * x * flip, [(half, True), (gap, True)])


def _term(number: Number, powers: Iterable[tuple[Expr, Number]], factors: Mapping[Expr, int]) -> Term:
    """What is no wave any more, sin(asin x) = x, is among the powers."""
    whole, waves = dict(powers), {}
    for x, k in factors.items():
        if isinstance(x, sp.sin | sp.cos):
            waves[x] = k
        elif x != 1:
            whole[x] = whole.get(x, 0) + k
    return Term(Fraction(number), tuple((x, Fraction(k)) for x, k in whole.items() if k), tuple(waves.items()))


def _halved(angle: Angle, whole: set[int]) -> Angle | None:
    """Half the angle, when it has even coefficients and no constant part, and does not belong to a given function of time."""
    if not angle or any(n in whole or k.denominator != 1 or k.numerator % 2 for n, k in angle):
        return None
    return tuple((n, k // 2) for n, k in angle)


def _added(a: Angle, b: Angle, sign: int) -> Angle:
    total = dict(a)
    for n, k in b:
        total[n] = total.get(n, 0) + sign * k
    return _sorted(total)


def _sorted(parts: dict[int, Number]) -> Angle:
    return tuple(sorted((n, k) for n, k in parts.items() if k))


def _of_halves(twice: Series) -> Series:
    """The numbers halved."""
    return {key: x // 2 if isinstance(x, int) and x % 2 == 0 else Fraction(x, 2) for key, x in twice.items()}


def _add(total: Series, key: Key, x: Number) -> None:
    total[key] = total.get(key, 0) + x


def _sum(series: Iterable[Series]) -> Series:
    total: Series = {}
    for one in series:
        for key, x in one.items():
            total[key] = total.get(key, 0) + x
    return {key: x for key, x in total.items() if x}


def _number_of(x: Expr) -> Number:
    return int(x.p) if x.q == 1 else Fraction(int(x.p), int(x.q))


def _rational(x: Number) -> Expr:
    return sp.Rational(x.numerator, x.denominator)
