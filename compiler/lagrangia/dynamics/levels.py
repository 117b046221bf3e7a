"""Conditions -> levels: positive where a condition is true, negative where it is not, continuous where its change is an event.

What a < b compares may itself be chosen by conditions, or count whole numbers, and then jumps over 0, or touches it. Such a
condition is taken apart into comparisons of what does not jump. A choice by c, whose level is L, between what has the levels A
and B is true where (c and A) or (not c and B), with the level

    max(min(L, A), min(-L, B), min(A, B))

in which the last term keeps it from 0 where c changes and A and B are both true. Of a function of m = floor(x) the level is that
of the choices among m - 1, m and m + 1 by x >= m and x >= m + 1, from -1 to 1: there neighbours hand over to each other.
"""

from collections.abc import Callable, Iterator
from dataclasses import field
from typing import TypeAlias

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, apply, as_expression, operate, symbol, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, STEPS, operations_in
from lagrangia.base.records import dataclass
from lagrangia.constraints.parameters import parameter_symbols
from lagrangia.frames.kinematics import Kinematics
from lagrangia.language.events import COMPARED
from lagrangia.language.tree import Binary, Flat, Unary

Level: TypeAlias = "ca.SX | bool"  # bool: whatever moves
EDGE = 1e-300  # a level where both sides of <= are equal: it is true there, and others are not changed by so little
JUMPS = STEPS | {ca.OP_ATAN2}  # what is compared may jump with these
_RELATIONS = (ca.OP_LT, ca.OP_LE)
_ATOMS = {*_RELATIONS, ca.OP_EQ, ca.OP_NE, ca.OP_FLOOR}
_MOST_CASES = 256
_BEYOND = 8  # rad: angles beyond their cuts are less
_FAR = 1e30  # of what is decided beside something that moves
_LOOKS, _SIZES, _SAME = 4, (0.1, 1, 10), 1e-9  # numbers of both signs and some sizes: abs(v) is v where v is positive


class _TooManyCasesError(Exception):
    """A condition that cannot be taken apart."""


_Known = dict[int, tuple[float, float]]  # by their numbers, from what on values are, and below what they stay
_Threshold = tuple[int, float, bool]


@dataclass(frozen=True)
class Edge:
    """By how much comparisons are true where both sides are equal, if they say so, and else false: what errors of a share, the
    symbol `size`, in `moving`, a column of positions and rates, make of the difference. What is held is on its level by that."""

    size: ca.SX
    moving: ca.SX

    def of(self, difference: ca.SX) -> ca.SX:
        """That of a comparison by the level of its difference."""
        slopes = ca.densify(ca.jacobian(difference, self.moving))
        return as_expression(self.size * (ca.fabs(slopes) @ (1 + ca.fabs(self.moving)) + self.size))


@dataclass
class Levels:
    """Of conditions on what `moving`, a column of symbols, moves."""

    moving: ca.SX
    numbering: Numbering = field(default_factory=Numbering)
    cases: int = 0
    may_rest: bool = False  # whether both sides of a comparison may be equal for a while
    edge: float = 0.0  # the level where both sides of <= are equal; where both sides of < are, its opposite
    may_stay: bool = False  # whether what moves may stay on levels: knowing x <= k is not knowing x < k then
    beside: Edge | None = None  # and what goes beside it

    def of(self, truth: ca.SX) -> ca.SX | None:
        """Of a condition, 1 where it is true and 0 where it is not; far from 0 where nothing that moves decides. None where it
        cannot be taken apart."""
        self.cases = 0
        try:
            level = self._of_truth(_plain(truth), {})
        except _TooManyCasesError:
            return None
        return ca.SX(_FAR if level else -_FAR) if isinstance(level, bool) else level

    # ------------------------------------------------------------ conditions

    def _of_truth(self, truth: ca.SX, known: _Known) -> Level:
        if not self._moves(truth):
            return bool(float(truth)) if truth.is_constant() else as_expression(_FAR * (2 * truth - 1))
        parts = [truth.dep(k) for k in range(truth.n_dep())]
        match truth.op():
            case ca.OP_LT | ca.OP_LE:
                return self._of_difference(as_expression(parts[1] - parts[0]), truth.op() == ca.OP_LE, known)
            case ca.OP_NOT:
                return _opposite(self._of_truth(parts[0], known))
            case ca.OP_SUB if parts[0].is_constant() and float(parts[0]) == 1:
                return _opposite(self._of_truth(parts[1], known))
            case ca.OP_SUB if parts[0].op() == ca.OP_ADD and parts[1].op() == ca.OP_MUL:
                return _either(*(self._of_truth(parts[0].dep(k), known) for k in range(2)))
            case ca.OP_OR:
                return _either(*(self._of_truth(x, known) for x in parts))
            case ca.OP_MUL | ca.OP_AND:
                return _both(*(self._of_truth(x, known) for x in parts))
            case ca.OP_EQ | ca.OP_NE:
                raise _TooManyCasesError
        return self._of_difference(as_expression(truth - 0.5), False, known)

    def _of_difference(self, d: ca.SX, is_true_at_0: bool, known: _Known) -> Level:
        """Of d > 0, or of d >= 0."""
        atom = self._atom_of(d, known)
        if atom is None:
            self.cases += 1
            if self.cases > _MOST_CASES:
                raise _TooManyCasesError
            return self._of_smooth(d, is_true_at_0, known)
        if atom.op() == ca.OP_FLOOR:
            return self._of_whole(d, is_true_at_0, atom, known)
        if atom.op() not in _RELATIONS:
            raise _TooManyCasesError
        decided = _decided(self._threshold(atom), known)
        levels = [None if decided is not None and decided != is_true else self._of_difference(
            self._with(d, atom, float(is_true)), is_true_at_0, self._learnt(atom, is_true, known)) for is_true in (True, False)]
        if decided is not None:
            return levels[0 if decided else 1]
        then, otherwise = levels
        return _chosen(self._of_truth(atom, known), then, otherwise)

    def _of_smooth(self, d: ca.SX, is_true_at_0: bool, known: _Known) -> Level:
        self.may_rest |= not self._moves(d) and not (d.is_constant() and float(d) != 0)
        if d.is_constant():
            return float(d) >= 0 if is_true_at_0 else float(d) > 0
        if self._moves(d):
            x, place, is_above = _line(d)
            low, high = self._range(x, known)
            place = self._beyond(place) if is_above != is_true_at_0 else place
            return d + self._edge_of(d) * (1 if is_true_at_0 else -1) if low < place < high else (low >= place) == is_above
        return as_expression(_FAR * (2 * (d >= 0 if is_true_at_0 else d > 0) - 1))

    def _of_whole(self, d: ca.SX, is_true_at_0: bool, atom: ca.SX, known: _Known) -> Level:
        """Where a floor(x) is a part of it."""
        x, n = as_expression(atom.dep(0)), symbol("n")
        inner = self._with(d, atom, n)
        step, low, high = ca.jacobian(inner, n), *self._range(x, known)
        is_line = operations_in(inner).isdisjoint(CORNERS) and step.is_constant() and float(step) != 0
        if is_line and not self._moves(inner):
            place = as_expression(-ca.substitute(inner, n, ca.SX(0)) / step)
            self.may_rest |= not place.is_constant() or float(place).is_integer()
            first = _first(float(step), place, is_true_at_0)
            if first.is_constant() and not low < float(first) < high:
                return (low >= float(first)) == (float(step) > 0)
            edge = self._edge_of(as_expression(x - first))
            return as_expression(x - first + edge if float(step) > 0 else first - x - edge)
        level = self._of_difference(inner, is_true_at_0, known)
        if isinstance(level, bool) or not ca.depends_on(level, n):
            return level
        whole = as_expression(ca.floor(x))
        if low > -np.inf:  # what is known never to be is as what is next to it
            whole = as_expression(ca.fmax(whole, np.floor(low)))
        if high < np.inf:
            whole = as_expression(ca.fmin(whole, np.ceil(high) - 1))
        below, here, above = (as_expression(ca.substitute(level, n, whole + k)) for k in (-1, 0, 1))
        if low > -np.inf:
            below = ca.if_else(whole <= low, here, below)
        if high < np.inf:
            above = ca.if_else(whole + 1 >= high, here, above)
        return _among(as_expression(x - whole + self.edge), below, here, above)

    def _edge_of(self, difference: ca.SX) -> ca.SX | float:
        return self.edge + self.beside.of(difference) if self.beside else self.edge

    def _range(self, x: ca.SX, known: _Known) -> tuple[float, float]:
        """Between what numbers x is known to be."""
        low, high = known.get(self.numbering.number(as_expression(-x)), (-np.inf, np.inf))
        return known.get(self.numbering.number(x), (self._beyond(-high), self._beyond(-low)))

    def _beyond(self, k: float) -> float:
        """The next larger number, from which on x > k; k where nothing stays on it."""
        return float(np.nextafter(k, np.inf)) if self.may_stay and np.isfinite(k) else k

    # ------------------------------------------------------------ what jumps in them

    def _moves(self, x: ca.SX) -> bool:
        return not symbols_in(self.moving).isdisjoint(symbols_in(x))

    def _atom_of(self, d: ca.SX, known: _Known) -> ca.SX | None:
        """The outermost condition or whole number that moves and with which d jumps, what is asked first: conditions before whole
        numbers, which they may decide between."""
        atoms = [atom for atom in _atoms_in(d) if self._moves(atom)]
        atoms.sort(key=lambda atom: atom.op() == ca.OP_FLOOR)
        jumping = next((atom for atom in atoms if not self._is_joint(d, atom)), None)
        if jumping is None or jumping.op() != ca.OP_FLOOR:
            return jumping
        inner = self._atom_of(as_expression(jumping.dep(0)), known)
        return atoms[0] if inner is None else inner

    def _is_joint(self, d: ca.SX, atom: ca.SX) -> bool:
        """Whether d goes on where an atom changes, as tables do at their points."""
        if atom.op() not in (*_RELATIONS, ca.OP_FLOOR):
            return False
        if atom.op() == ca.OP_FLOOR:
            x, place = atom.dep(0), symbol("n")
            values = [self._with(d, atom, place - 1), self._with(d, atom, place)]
        else:
            x, place = (atom.dep(k) for k in ((1, 0) if atom.dep(0).is_constant() else (0, 1)))
            values = [self._with(d, atom, 1.0), self._with(d, atom, 0.0)]
        if not self._moves(x) or x.is_constant():
            return False
        return _are_same(*(self._with(value, x, place) for value in values))

    def _with(self, d: ca.SX, part: ca.SX, value: ca.SX | float) -> ca.SX:
        """With another value for a part of it, however that is written."""
        if d.is_constant():
            return d
        if part.is_symbolic():
            return as_expression(ca.substitute(d, part, as_expression(value)))
        number = self.numbering.number(part)

        def make(op: int, numbers: list[int], operands: list[Expression]) -> Expression:
            is_wanted = self.numbering.of(op, numbers) == number
            return as_expression(value) if is_wanted else _simple(op, operands)

        return as_expression(rebuilt([d], self.numbering, make)[0])

    def _threshold(self, atom: ca.SX) -> _Threshold:
        """Of x < k or k <= x with a number k, as x - y < 0 is: the number of x, k, and whether it is true below."""
        a, b, is_inclusive = atom.dep(0), atom.dep(1), atom.op() == ca.OP_LE
        if a.is_constant() and not b.is_constant():
            return self.numbering.number(b), float(a) if is_inclusive else self._beyond(float(a)), False
        x, k = (a, float(b)) if b.is_constant() and not a.is_constant() else (as_expression(a - b), 0.0)
        return self.numbering.number(x), self._beyond(k) if is_inclusive else k, True

    def _learnt(self, atom: ca.SX, is_true: bool, known: _Known) -> _Known:
        x, k, is_below = self._threshold(atom)
        low, high = known.get(x, (-np.inf, np.inf))
        return known | {x: (low, min(high, k)) if is_below == is_true else (max(low, k), high)}


def level_of_parts(condition: Flat, level: Callable[[Flat], ca.SX]) -> ca.SX:
    """Of a condition, by the levels of what is put together in it with and, or, not."""
    match condition:
        case Binary("and", left, right):
            return ca.fmin(level_of_parts(left, level), level_of_parts(right, level))
        case Binary("or", left, right):
            return ca.fmax(level_of_parts(left, level), level_of_parts(right, level))
        case Unary("not", operand):
            return -level_of_parts(operand, level)
    return level(condition)


def least_of(level: ca.SX) -> Iterator[ca.SX]:
    """What all has to be positive where a level is."""
    if level.op() == ca.OP_FMIN:
        yield from (*least_of(level.dep(0)), *least_of(level.dep(1)))
    else:
        yield level


def with_edge(comparison: Flat, difference: ca.SX, edge: Edge | None = None) -> ca.SX:
    """The level of a comparison of what does not jump."""
    is_inclusive = isinstance(comparison, Binary) and comparison.operator in ("<=", ">=")
    level = difference + EDGE if is_inclusive else difference
    return level if edge is None else as_expression(level + edge.of(difference) * (1 if is_inclusive else -1))


def step_of(difference: ca.SX, edge: float) -> Expression:
    """1 where it is positive, else -1; where it is 0 as `edge`, EDGE or -EDGE, is."""
    return as_expression(ca.fmax(ca.fmin((difference + edge)/EDGE, 1), -1))


class Steps:
    """Comparisons of what changes at events and samples alone, which may come true on their very level: n >= 3 beside x > 1."""

    def __init__(self, kinematics: Kinematics) -> None:
        kept = {state.coordinate for state in kinematics.graph.model.states.values() if state.is_kept}
        held = [*kinematics.symbols.held.values(), *(kinematics.symbols.rates[name] for name in sorted(kept))]
        self.held = symbols_in(ca.vertcat(ca.SX(0, 1), *held))
        self.known = self.held | symbols_in(parameter_symbols(kinematics)) if held else frozenset()

    def decide(self, difference: ca.SX) -> bool:
        """Whether nothing else does, however it jumps with them: mod(n, 2) - 1."""
        found = symbols_in(difference)
        return bool(found & self.held) and found <= self.known

    def beside(self, moving: ca.SX) -> ca.SX:
        """What else is `moving`, a column of symbols."""
        return ca.vertcat(ca.SX(0, 1), *(x for x in moving.elements() if self.held.isdisjoint(symbols_in(x))))

    def level(self, comparison: Flat, difference: ca.SX, beside: Edge | None = None) -> ca.SX:
        """That of a comparison of what does not jump otherwise: of what steps 1 where it is true, else -1, so that what moves
        beside it in a condition says where that comes true."""
        if not (self.decide(difference) and isinstance(comparison, Binary) and comparison.operator in COMPARED):
            return with_edge(comparison, difference, beside)
        return step_of(difference, EDGE if comparison.operator in ("<=", ">=") else -EDGE)


class Meetings:
    """How the comparisons in a condition are where rates that resets have set meet what they are compared with."""

    def __init__(self, kinematics: Kinematics) -> None:
        kept = {state.coordinate for state in kinematics.graph.model.states.values() if state.is_kept}
        moving = [rate for coordinate, rate in kinematics.symbols.rates.items() if coordinate not in kept]
        self.rates = ca.vertcat(ca.SX(0, 1), *moving)
        self.at_rest = ca.vertcat(ca.SX(0, 1), *(kinematics.symbols.accelerations[name] for name in sorted(kept)))
        self.kinds = set[int]()  # 1 inclusive, 0 strict, -1 neither
        self.constant = symbols_in(parameter_symbols(kinematics))
        self.places = symbols_in(ca.vertcat(ca.SX(0, 1), *kinematics.symbols.positions.values()))
        self.compared = list[ca.SX]()

    def note(self, node: Flat, difference: ca.SX) -> None:
        """One of the comparisons, and the level of it."""
        self.compared.append(difference)
        if ca.depends_on(difference, self.rates):
            is_plain = isinstance(node, Binary) and node.operator in COMPARED and operations_in(difference).isdisjoint(JUMPS)
            self.kinds.add(int(node.operator in ("<=", ">=")) if isinstance(node, Binary) and is_plain else -1)

    def on_level(self) -> int:
        """Whether the condition is true there; -1: by its parts, or there are none."""
        return min(self.kinds) if len(self.kinds) == 1 else -1

    def of_rates(self) -> int:
        """The same, and 2 more where one comparison of nothing but rates decides; -2: one of nothing but places. Neither may ask
        for the larger of several: what does not count now may later."""
        on_level = self.on_level()
        if len(self.compared) != 1 or not operations_in(self.compared[0]).isdisjoint({*JUMPS, ca.OP_FMIN, ca.OP_FMAX}):
            return on_level
        by = symbols_in(self.compared[0]) - self.constant
        if by <= symbols_in(self.rates):
            return on_level + 2 if on_level >= 0 else on_level
        return -2 if by <= self.places else on_level


    def are_several(self) -> bool:
        """Whether of what may be held more is compared than one rate, or place, with a number that does not change."""
        on_level, known = self.of_rates(), symbols_in(self.rates) | self.places
        return -1 <= on_level <= 1 and any(not known.isdisjoint(symbols_in(x)) for x in self.compared)


def _decided(found: _Threshold, known: _Known) -> bool | None:
    """Whether a comparison is true or false by what is known; None: that is open."""
    x, k, is_below = found
    low, high = known.get(x, (-np.inf, np.inf))
    return is_below if high <= k and low < k else not is_below if low >= k and high > k else None


def _plain(truth: ca.SX) -> ca.SX:
    """With floor in place of ceil, and comparisons in place of signs and of the cuts of angles."""
    def make(op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        if op == ca.OP_CEIL:
            return as_expression(-ca.floor(-operands[0]))
        if op == ca.OP_SIGN:
            return as_expression((operands[0] > 0) - (operands[0] < 0))
        if op == ca.OP_ATAN2:  # each side of its cut goes on beyond it
            (y, x), quarter = operands, ca.pi / 2
            side = _BEYOND * y / ca.sqrt(x * x + y * y)  # below angles where these have cuts of their own
            return as_expression(ca.if_else(side >= 0, quarter + ca.atan2(-x, y), ca.atan2(x, -y) - quarter))
        return None

    return as_expression(rebuilt([truth], Numbering(), make)[0])


def _atoms_in(d: ca.SX) -> list[ca.SX]:
    """Conditions and whole numbers that are in no other ones, each once."""
    seen, found, waiting = set[int](), list[ca.SX](), [d]
    while waiting:
        x = waiting.pop()
        if x.element_hash() in seen or x.is_constant() or x.is_symbolic():
            continue
        seen.add(x.element_hash())
        if x.op() in _ATOMS:
            found.append(x)
        else:
            waiting += [x.dep(k) for k in reversed(range(x.n_dep()))]
    return found


def _simple(op: int, operands: list[Expression]) -> Expression:
    """An operation, done where operands are numbers that decide it."""
    if op in (ca.OP_AND, ca.OP_OR):
        first, second = operands if operands[0].is_constant() else operands[::-1]
        if first.is_constant():
            is_decided = bool(float(first)) == (op == ca.OP_OR)
            return as_expression(float(op == ca.OP_OR)) if is_decided else second
    return operate(op, operands)


def _are_same(a: ca.SX, b: ca.SX) -> bool:
    """Whether two expressions are equal but for rounding, by numbers."""
    symbols = ca.vertcat(ca.SX(0, 1), *ca.symvar(ca.vertcat(a, b)))
    look, random, n = ca.Function("look", [symbols], [a, b]), np.random.default_rng(5), symbols.numel()
    places = [random.uniform(0.4, 1.6, n) for _ in range(_LOOKS)]
    places += [random.uniform(0.4, 1.6, n) * random.choice([-1, 1], n) * size for size in _SIZES for _ in range(_LOOKS)]
    values = np.array([[float(x) for x in look(place)] for place in places])
    known = np.isfinite(values).any(axis=1)  # roots and logarithms have no value at some places
    return bool(np.isfinite(values[:_LOOKS]).all() and np.allclose(values[known, 0], values[known, 1], rtol=_SAME, atol=_SAME))


def _line(d: ca.SX) -> tuple[ca.SX, float, bool]:
    """x, k and whether d > 0 is x > k, not x < k: of d = x - k, or k - x, times a number; else d and 0."""
    place, scale = 0.0, 1.0  # d > 0 is scale*d > place
    while d.n_dep():
        parts = [d.dep(k) for k in range(d.n_dep())]
        constants = [k for k, part in enumerate(parts) if part.is_constant()]
        if d.op() == ca.OP_NEG:
            d, scale = parts[0], -scale
        elif d.op() in (ca.OP_ADD, ca.OP_SUB) and len(constants) == 1:
            k = constants[0]
            place -= scale * float(parts[k]) * (-1 if k == 1 and d.op() == ca.OP_SUB else 1)
            d, scale = parts[1 - k], -scale if k == 0 and d.op() == ca.OP_SUB else scale
        elif d.op() == ca.OP_MUL and len(constants) == 1 and float(parts[constants[0]]) != 0:
            d, scale = parts[1 - constants[0]], scale * float(parts[constants[0]])
        else:
            break
    return as_expression(d), place / scale, scale > 0


def _first(step: float, place: ca.SX, is_true_at_place: bool) -> ca.SX:
    """The whole number n from which on n > place, or n >= place, is true where `step` is positive; n < place or n <= place false,
    where it is negative."""
    return as_expression(ca.ceil(place) if is_true_at_place == (step > 0) else ca.floor(place) + 1)


def _among(rest: ca.SX, below: ca.SX, here: ca.SX, above: ca.SX) -> ca.SX:
    """Of what has these levels for the whole number below the present one, it, and the one above; `rest`: x - floor(x)."""
    places = [(rest, 1 - rest, here), (-rest, below), (rest - 1, above), (1 - rest, below, here), (rest, here, above),
              (below, here, above)]
    lowest = [_folded(ca.OP_FMIN, *terms) for terms in places]
    return as_expression(ca.fmax(ca.fmin(_folded(ca.OP_FMAX, *lowest), 1), -1))


# ------------------------------------------------------------ levels of several


def _folded(op: int, first: ca.SX, *others: ca.SX) -> ca.SX:
    for x in others:
        first = apply(op, first, x)
    return as_expression(first)


def _opposite(level: Level) -> Level:
    return not level if isinstance(level, bool) else as_expression(-level)


def _both(a: Level, b: Level) -> Level:
    if isinstance(a, bool):
        return b if a else False
    if isinstance(b, bool):
        return a if b else False
    return _folded(ca.OP_FMIN, a, b)


def _either(a: Level, b: Level) -> Level:
    return _opposite(_both(_opposite(a), _opposite(b)))


def _chosen(level: Level, then: Level, otherwise: Level) -> Level:
    """Where `then` counts if the condition is true, and `otherwise` if it is not."""
    if isinstance(level, bool):
        return then if level else otherwise
    if isinstance(then, bool) and isinstance(otherwise, bool) and then == otherwise:
        return then
    return _either(_either(_both(level, then), _both(_opposite(level), otherwise)), _both(then, otherwise))
