"""M and the inertial forces of a few coordinates, collected: what cancels in world axes is not reckoned at all.

T is a sum of products of sines and cosines of the bodies' angles, in which most products cancel or combine: a pendulum's
(L cos(phi) w)^2 + (L sin(phi) w)^2 is L^2 w^2. The coordinates are the angles of the bodies themselves (psi = S q, with whole
numbers in S), in which the forces of a chain have no products of different rates. What is left is written with one sine and
cosine for each angle that is no sum or difference of others, and with factors drawn out where several terms have them. The
accelerations of a double pendulum take 33 operations so, 84 along the tree.
"""

from collections import Counter
from collections.abc import Sequence
from dataclasses import field
from functools import reduce
from itertools import pairwise

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.harmonics import Angle, Harmonics, Key, Powers, Sum, TooLarge, combined
from lagrangia.algebra.scalars import Expression, apply_to_one, as_expression, symbols_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.energies import Term
from lagrangia.frames.evaluation import scalars_of
from lagrangia.frames.kinematics import Kinematics

MOST_COORDINATES = 6  # that act on each other
_TOGETHER = 4  # so many sines take the time of one (runtime/numbers/sines.h)


@dataclass(frozen=True)
class Collected:
    """M psi'' + force = what remains of the loads, psi = S q."""

    basis: ca.DM  # S, (n, n)
    mass: ca.SX  # (n, n), in psi
    force: ca.SX  # (n,), in psi: what was handed in

    def momentum(self, v: ca.SX) -> ca.SX:
        """M v"""
        S = ca.SX(ca.sparsify(self.basis))
        return ca.densify(S.T @ (self.mass @ (S @ v)))

    def generalised(self) -> ca.SX:
        """The force in the scene's coordinates."""
        return ca.densify(ca.SX(ca.sparsify(self.basis)).T @ self.force)

    def accelerations(self, rest: ca.SX) -> ca.SX:
        """a of M a + force + rest = 0."""
        return self._solved(-(self.force + self._inverse.T @ rest))

    def solve(self, r: ca.SX) -> ca.SX:
        """x of M x = r."""
        return self._solved(self._inverse.T @ r)

    @property
    def _inverse(self) -> ca.SX:
        return ca.SX(ca.sparsify(ca.DM(_inverted(self.basis.full()))))

    def _solved(self, r: ca.SX) -> ca.SX:
        diagonal, upper, order = ca.ldl(self.mass, True)
        return self._inverse @ ca.ldl_solve(r, diagonal, upper, order)


def blocks_of(M: ca.Sparsity) -> list[list[int]]:
    """Groups of coordinates that M does not couple."""
    _, members, starts = M.scc()
    return [sorted(members[i:j]) for i, j in pairwise(starts)]


def collect(kinematics: Kinematics, M: ca.SX, force: ca.SX, is_held: bool) -> Collected | None:
    """The same, in the bodies' angles where there are such; None where it is too large. `is_held`: by closed loops, which ask for
    sines and cosines of the bodies' angles, too."""
    n = len(kinematics.symbols.rates)
    are_given = is_held and n > _TOGETHER
    basis, known, levers = _absolute_angles(kinematics), _parameters(kinematics), _lengths(kinematics)
    positions, rates = (list(x.values()) for x in (kinematics.symbols.positions, kinematics.symbols.rates))
    mass, forces = ca.SX(n, n), ca.SX.zeros(n)
    for block in blocks_of(ca.sparsify(M).sparsity() + basis.sparsity() + basis.sparsity().T):
        if len(block) > MOST_COORDINATES:
            return None
        try:
            own, moved = ([as_expression(values[k]) for k in block] for values in (positions, rates))
            part = _Block(basis.full()[np.ix_(block, block)], own, moved, known, levers)
            mass[block, block], forces[block] = part.collected(M[block, block], force[block], are_given)
        except TooLarge:
            return None
    return Collected(basis, ca.sparsify(mass), forces)


class _Block:
    """Coordinates that M does not couple with others: S, they and their rates; hashes of all parameters and of the coordinates
    that are lengths."""

    def __init__(self, basis: NDArray[np.float64], positions: Sequence[Expression], rates: Sequence[Expression],
                 parameters: set[int], levers: set[int]) -> None:
        self.basis, self.positions, self.rates = basis, positions, rates
        self.harmonics = Harmonics(fixed=parameters, levers=levers)

    def collected(self, M: ca.SX, force: ca.SX, are_given: bool) -> tuple[ca.SX, ca.SX]:
        """M and the force in the bodies' angles, whose sines are made of others unless they are given. Raises TooLarge."""
        n, harmonics = len(self.rates), self.harmonics
        inverse = _inverted(self.basis).tolist()
        moved = [as_expression(x) for x in (ca.SX(ca.sparsify(ca.DM(self.basis))) @ ca.vertcat(*self.rates)).elements()]
        own = combined(inverse, [harmonics.quantity(x) for x in moved])
        harmonics.given = {rate.__hash__(): total for rate, total in zip(self.rates, own, strict=True)}
        entries = [M[i, j] for j in range(n) for i in range(j + 1)]
        sums = harmonics.sums(ca.densify(ca.vertcat(*entries, force)))
        turned = [list(column) for column in zip(*inverse, strict=True)]  # S^-T
        half = [[sums[max(i, j) * (max(i, j) + 1) // 2 + min(i, j)] for i in range(n)] for j in range(n)]
        left = [combined(turned, column) for column in half]  # S^-T M, by columns
        mass = [combined(turned, [column[i] for column in left]) for i in range(n)]  # S^-T M S^-1, by rows
        upper = [mass[i][j] for j in range(n) for i in range(j + 1)]
        written = _Writer(harmonics, self._angles() if are_given else []).written([*upper, *combined(turned, sums[-n:])])
        return _symmetric(written, n), ca.densify(ca.vertcat(*written[-n:]))

    def _angles(self) -> list[Angle]:
        """Those of the bodies."""
        keys = [next(iter(self.harmonics.quantity(x)))[0] for x in self.positions]
        return [tuple(sorted((key, float(x)) for key, x in zip(keys, row, strict=True) if x)) for row in self.basis]


def _inverted(S: NDArray[np.float64]) -> NDArray[np.float64]:
    """Of whole numbers, as S itself."""
    return np.asarray(np.round(np.linalg.inv(S)))


def _symmetric(upper: Sequence[ca.SX], n: int) -> ca.SX:
    """The sparse matrix whose upper triangle begins the list, by columns."""
    M = ca.SX(n, n)
    for j in range(n):
        for i in range(j + 1):
            value = upper[j * (j + 1) // 2 + i]
            if not value.is_zero():
                M[i, j] = M[j, i] = value
    return M


def split_weights(kinematics: Kinematics, terms: Sequence[Term]) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """The potential terms that are linear in each coordinate, sine and cosine, as weights are, and the others: springs are
    squares of differences, and lose digits when these are multiplied out."""
    positions, fixed = {x.__hash__() for x in kinematics.symbols.positions.values()}, _parameters(kinematics)
    weights, others = list[Term](), list[Term]()
    for term in terms:
        harmonics = Harmonics()
        try:
            (total,) = harmonics.sums(ca.densify(ca.SX(term.value)))
        except TooLarge:
            others.append(term)
            continue
        coordinates = {n for n, x in enumerate(harmonics.quantities) if x.__hash__() in positions}
        is_known = all(n in coordinates or symbols_in(x) <= fixed for n, x in enumerate(harmonics.quantities))
        is_weight = is_known and all(_is_linear(key, coordinates) for key in total)
        (weights if is_weight else others).append(term)
    return tuple(weights), tuple(others)


def _is_linear(key: Key, coordinates: set[int]) -> bool:
    """`coordinates`: the numbers of quantities that are such."""
    powers, angle, _ = key
    turning = (x for parts, x in angle if any(n in coordinates for n, _ in parts))
    return all(k == 1 for n, k in powers if n in coordinates) and all(abs(x) == 1 for x in turning)


def _parameters(kinematics: Kinematics) -> set[int]:
    """Hashes of the symbols."""
    variables = kinematics.graph.model.variables.values()
    values = [kinematics.symbols.values[v.name] for v in variables if v.kind == "parameter"]
    return {x.__hash__() for value in values for x in scalars_of(value)}


def _lengths(kinematics: Kinematics) -> set[int]:
    """Hashes of the coordinates that are lengths."""
    coordinates = zip(kinematics.graph.coordinates, kinematics.symbols.positions.values(), strict=True)
    return {x.__hash__() for coordinate, x in coordinates if coordinate.unit == "m"}


def _absolute_angles(kinematics: Kinematics) -> ca.DM:
    """S that puts in the place of each angle of a joint that of the body behind it; the unit matrix where it would have no
    inverse, or would not be of whole numbers, and in space."""
    graph, positions = kinematics.graph, kinematics.symbols.positions
    number = {name: k for k, name in enumerate(positions)}
    turning = [(edge.child, number[name]) for edge in graph.edges for name in edge.coordinates if name in number]
    S = np.eye(len(number))
    if kinematics.geometry.by_rates:
        return ca.DM.eye(len(number))  # bodies have no angles there
    angles = ca.vertcat(ca.SX(0, 1), *[kinematics.pose(frame, 0).phi for frame, _ in turning])
    slopes = ca.jacobian(angles, ca.vertcat(*positions.values()))
    if not slopes.is_constant():
        return ca.DM.eye(len(number))
    for (_, k), slope in zip(turning, ca.DM(slopes).full(), strict=True):
        if slope[k] != 0:  # else it shifts
            S[k, :] = slope
    is_whole = bool((np.round(S) == S).all()) and abs(round(np.linalg.det(S))) == 1
    return ca.sparsify(ca.DM(S)) if is_whole else ca.DM.eye(len(number))


# -------------------------------------------------------------------- sums -> expressions

_Amount = tuple[tuple[Powers, float], ...]  # what depends on parameters alone; the first number is 1


@dataclass(frozen=True, order=True)
class _Wave:
    """The amount times the sine or cosine of the angle."""

    amount: _Amount
    angle: Angle
    is_sine: bool


@dataclass(frozen=True, order=True)
class _Quantity:
    number: int
    is_inverse: bool


_Factor = _Wave | _Quantity
_Term = tuple[float, "Counter[_Factor]"]
_ALONE: _Amount = (((), 1.0),)


@dataclass
class _Writer:
    harmonics: Harmonics
    given: Sequence[Angle]  # their sines and cosines are there
    known: dict[Angle, tuple[Angle, Angle, float] | None] = field(default_factory=dict)  # each a sum of two others, or not
    values: dict[_Wave, Expression] = field(default_factory=dict)

    def written(self, sums: Sequence[Sum]) -> list[Expression]:
        angles = {angle for terms in sums for _, angle, _ in terms if angle}
        self.known = dict.fromkeys(self.given, None)
        for angle in sorted(angles - self.known.keys(), key=lambda a: (len(a), a)):
            self.known[angle] = self._parts(angle)
        return [self._sum(self._terms(terms, self.harmonics.is_fixed)) for terms in sums]

    def _parts(self, angle: Angle) -> tuple[Angle, Angle, float] | None:
        for one in self.known:
            rest = dict(angle)
            for powers, x in one:
                rest[powers] = rest.get(powers, 0.0) - x
            other = tuple(sorted((powers, x) for powers, x in rest.items() if x))
            for sign in (1.0, -1.0):
                if (found := tuple((powers, sign * x) for powers, x in other)) in self.known:
                    return one, found, sign
        return None

    def _terms(self, terms: Sum, constant: Sequence[bool]) -> list[_Term]:
        groups: dict[Key, list[tuple[Powers, float]]] = {}
        for (powers, angle, is_sine), x in terms.items():
            moving = tuple((n, k) for n, k in powers if not constant[n])
            groups.setdefault((moving, angle, is_sine), []).append((tuple((n, k) for n, k in powers if constant[n]), x))
        found: list[_Term] = []
        for (moving, angle, is_sine), parts in groups.items():
            parts.sort()
            first = parts[0][1]
            amount = tuple((powers, x / first) for powers, x in parts)
            factors: Counter[_Factor] = Counter()
            if angle or amount != _ALONE:
                factors[_Wave(amount, angle, is_sine)] = 1
            for n, k in moving:
                factors[_Quantity(n, k < 0)] = abs(k)
            found.append((first, factors))
        return found

    def _sum(self, terms: list[_Term]) -> Expression:
        """Draws out the factor that most terms have, again and again."""
        if not terms:
            return as_expression(0.0)
        uses = Counter(factor for _, factors in terms for factor in factors)
        best = max(uses, key=lambda factor: (uses[factor], isinstance(factor, _Wave)), default=None)
        if best is None or uses[best] < 2:
            return self._plain(terms)
        inside = [(x, factors - Counter({best: 1})) for x, factors in terms if best in factors]
        outside = [(x, factors) for x, factors in terms if best not in factors]
        product = as_expression(self._value(best) * self._sum(inside))
        return as_expression(product + self._sum(outside)) if outside else product

    def _plain(self, terms: list[_Term]) -> Expression:
        total: Expression | None = None
        for x, factors in sorted(terms, key=lambda term: term[0] < 0):
            product = self._product(factors)
            size = product if abs(x) == 1 else as_expression(abs(x) * product)
            if total is None:
                total = size if x > 0 else -size
            else:
                total = as_expression(total + size if x > 0 else total - size)
        assert total is not None
        return total

    def _product(self, factors: "Counter[_Factor]") -> Expression:
        waves = sorted(factor for factor in factors.elements() if isinstance(factor, _Wave))
        quantities = sorted(factor for factor in factors.elements() if isinstance(factor, _Quantity))
        values = [*map(self._value, waves), *map(self._value, quantities)]
        return reduce(lambda a, b: as_expression(a * b), values) if values else as_expression(1.0)

    def _value(self, factor: _Factor) -> Expression:
        if isinstance(factor, _Quantity):
            quantity = self.harmonics.quantities[factor.number]
            return as_expression(1.0 / quantity) if factor.is_inverse else quantity
        if factor not in self.values:
            size = self._amount(factor.amount)
            wave = self._wave(factor.angle, factor.is_sine) if factor.angle else None
            self.values[factor] = size if wave is None else wave if size.is_one() else as_expression(size * wave)
        return self.values[factor]

    def _amount(self, amount: _Amount) -> Expression:
        total: Expression | None = None
        for powers, x in amount:
            product = as_expression(x)
            for n, k in powers:
                for _ in range(abs(k)):
                    factor = self.harmonics.quantities[n]
                    product = as_expression(product * factor if k > 0 else product / factor)
            total = product if total is None else as_expression(total + product)
        assert total is not None
        return total

    def _wave(self, angle: Angle, is_sine: bool) -> Expression:
        factor = _Wave(_ALONE, angle, is_sine)
        if factor not in self.values:
            parts = self.known.get(angle)
            self.values[factor] = self._of_sum(*parts, is_sine) if parts else self._plain_wave(angle, is_sine)
        return self.values[factor]

    def _of_sum(self, a: Angle, b: Angle, sign: float, is_sine: bool) -> Expression:
        """sin(a + b) = sin a cos b + cos a sin b, cos(a + b) = cos a cos b - sin a sin b"""
        first = self._wave(a, is_sine) * self._wave(b, False)
        second = self._wave(a, not is_sine) * self._wave(b, True)
        return as_expression(first + second if (sign > 0) == is_sine else first - second)

    def _plain_wave(self, angle: Angle, is_sine: bool) -> Expression:
        argument: Expression | None = None
        for powers, x in angle:
            product = self._amount(((powers, x),))
            argument = product if argument is None else as_expression(argument + product)
        assert argument is not None
        return apply_to_one(ca.OP_SIN if is_sine else ca.OP_COS, argument)
