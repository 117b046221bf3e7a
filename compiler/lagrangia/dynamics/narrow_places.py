"""Motion -> where its forces may turn within less than a step.

A bump exp(-(x/w)^2), 1/(1 + (x/w)^2) or 1/cosh(x/w), a step tanh(x/w) or x/sqrt(w^2 + x^2) is a smooth function, so that no
step is cut there; but what is 2 mm wide lies between all stages of a step of decimetres. What stands inside tells where to look:
g = -(x/w)^2, -log(1 + (x/w)^2), x/w; it passes through 0 there, or turns round. High powers are exponentials of logarithms:
cos(x)^n is as narrow as exp(-n x^2/2), 1/(1 + (x/w)^2)^n as exp(-n (x/w)^2), however they are multiplied out.
"""

import math
from collections.abc import Sequence
from dataclasses import field

import casadi as ca

from lagrangia.algebra.duals import TINY
from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.scalars import Expression, as_expression, symbols_in
from lagrangia.base.records import dataclass
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.switches import Switches

_FADING = frozenset({ca.OP_EXP, ca.OP_TANH, ca.OP_COSH, ca.OP_ATAN, ca.OP_ERF, ca.OP_ASINH})
_ROOTS = frozenset({ca.OP_SQRT, ca.OP_LOG, ca.OP_POW, ca.OP_CONSTPOW})
_WAVES = frozenset({ca.OP_COS, ca.OP_SIN})
_EVEN = _WAVES | {ca.OP_SQ}
_ASKED = frozenset({"exp", "tanh", "cosh", "sinh", "atan", "erf", "asinh", "sqrt", "log", "pow", "ratio"})
_DIVIDING = frozenset({ca.OP_DIV, ca.OP_INV, ca.OP_TAN, ca.OP_POW, ca.OP_CONSTPOW})
_BENDING = frozenset({ca.OP_FABS, ca.OP_SQ, ca.OP_FMIN, ca.OP_FMAX})
_HIGH = 6  # power from which on a factor that turns makes something narrow
_FEW = 8  # factors of a product that are looked at
_FAINT = 37.0  # logarithm of what is rounding beside 1
_FLAT = 3.0  # change of logarithm in a whole turn that makes nothing narrow


@dataclass
class _Products:
    """The powers of what moves that stand in products, quotients and roots, by the numbers of values."""

    numbering: Numbering
    moving: set[int]  # values that do
    straight: set[int]  # values that are linear in what moves
    powers: dict[int, dict[int, float]] = field(default_factory=dict)
    factors: dict[int, Expression] = field(default_factory=dict)
    highest: dict[int, float] = field(default_factory=dict)  # those of each factor: the largest and ...
    lowest: dict[int, float] = field(default_factory=dict)  # ... the smallest

    def note(self, op: int, numbers: list[int], operands: list[Expression]) -> None:
        """An instruction, after those that it is made of."""
        if self.moving.isdisjoint(numbers):
            return
        made = self.numbering.of(op, numbers)
        self.moving.add(made)
        if self._is_straight(op, numbers):
            self.straight.add(made)
            return
        found: dict[int, float] = {}
        for k, power in enumerate(_exponents(op, operands)):
            for factor, inner in self._powers_of(numbers[k], operands[k]).items():
                found[factor] = found.get(factor, 0.0) + power * inner
        if not 0 < len(found) <= _FEW:
            return
        self.powers[made] = found
        for factor, power in found.items():
            self.highest[factor] = max(power, self.highest.get(factor, 0.0))
            self.lowest[factor] = min(power, self.lowest.get(factor, 0.0))

    def _powers_of(self, number: int, value: Expression) -> dict[int, float]:
        if number not in self.moving:
            return {}
        if number not in self.powers:
            self.powers[number] = {number: 1.0}
            self.factors[number] = value
        return self.powers[number]

    def _is_straight(self, op: int, numbers: list[int]) -> bool:
        moving = [number for number in numbers if number in self.moving]
        if not self.straight.issuperset(moving):
            return False
        is_scaled = len(moving) == 1 and (op == ca.OP_MUL or (op == ca.OP_DIV and moving[0] == numbers[0]))
        return is_scaled or op in (ca.OP_ADD, ca.OP_SUB, ca.OP_NEG)

    def place(self, factor: int, moving: frozenset[int]) -> Expression | None:
        """What turns where its powers do within little; None where they do not."""
        value, low, high = self.factors[factor], self.lowest.get(factor, 0.0), self.highest.get(factor, 0.0)
        if low < 0 and (least := _least(value, moving, -low)) is not None:
            return as_expression(low * ca.log(ca.fabs(value / least)))
        if low <= -_HIGH or (low < 0 and factor in self.straight):
            return as_expression(low * ca.log(ca.fabs(value)))  # a pole
        if high < _HIGH or factor in self.straight:
            return None
        return _logarithm(value, as_expression(high))


def _exponents(op: int, operands: list[Expression]) -> tuple[float, ...]:
    """Of the operands, in a product, a quotient, a power or a root."""
    if op in (ca.OP_POW, ca.OP_CONSTPOW):
        return (float(operands[1]),) if operands[1].is_constant() else ()
    return {ca.OP_MUL: (1.0, 1.0), ca.OP_DIV: (1.0, -1.0), ca.OP_INV: (-1.0,), ca.OP_SQ: (2.0,), ca.OP_SQRT: (0.5,)}.get(op, ())


def find_narrow_places(motion: Motion, switches: Switches) -> ca.SX:
    """g (k,) of t, q, v, u, d, p: what stands inside of functions in the forces that fade, or settle, where it is large."""
    if motion.asked.isdisjoint(_ASKED):
        return ca.SX(0, 1)
    known = motion.unsolved or motion
    rest = symbols_in(motion.a)
    if known.felt is not None:
        rest = rest | symbols_in(known.felt.reactions)
    powers = [known.dissipated_power, known.source_power]  # which alone tell of what moves nothing but its support
    acting = switches.hold([known.h, *powers])
    return _find(acting, ca.vertcat(motion.t, motion.q, motion.v), symbols_in(motion.v), rest)


def find_hiding_places(motion: Motion, switches: Switches) -> ca.SX:
    """The same of conditions that time alone decides: these may come and go within a step, whatever its stages are."""
    if not ca.depends_on(switches.values, motion.t):
        return ca.SX(0, 1)
    moved = symbols_in(ca.vertcat(motion.q, motion.v, motion.a))
    timed = [as_expression(g) for g in ca.vertsplit(switches.values) if moved.isdisjoint(symbols_in(g))]
    inner = _find(timed, motion.t, frozenset(), moved) if not motion.asked.isdisjoint(_ASKED) else ca.SX(0, 1)
    return ca.vertcat(inner, *[g for g in timed if _is_sharp(g, motion.t)])


def _is_sharp(g: Expression, time: ca.SX) -> bool:
    """Whether it may turn back within little: where what is no straight line is squared, or has a corner, or is divided by."""
    found = list[Expression]()

    def note(op: int, _: list[int], operands: list[Expression]) -> None:
        if op in _DIVIDING:
            found.extend([operands[-1]] if ca.depends_on(operands[-1], time) else [])
        elif op in _BENDING:
            slope = ca.jacobian(operands[0] - operands[1] if len(operands) > 1 else operands[0], time)
            found.extend([operands[0]] if ca.depends_on(slope, time) else [])

    if ca.depends_on(g, time):
        rebuilt([g], Numbering(), note)
    return bool(found)


def _find(expressions: list[ca.SX], coordinates: ca.SX, rates: frozenset[int], rest: frozenset[int]) -> ca.SX:
    """Of expressions, by what moves in them; nothing of what depends on the rest."""
    moving, numbering, found = symbols_in(coordinates), Numbering(), dict[tuple[bool, int], Expression]()
    starts = {numbering.of_symbol(symbol) for symbol in ca.symvar(coordinates)}
    products = _Products(numbering, starts, set(starts))

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        products.note(op, numbers, operands)
        has_name = op == ca.OP_POW and not operands[1].is_constant()  # the power is a parameter
        inner, key = operands[0], (op in _ROOTS, numbering.of(op, numbers) if has_name else numbers[0])
        if key in found or op not in _FADING | _ROOTS or moving.isdisjoint(symbols := symbols_in(inner)):
            return
        if op == ca.OP_SQRT and rates.isdisjoint(symbols):
            return  # of positions: find_roots has them
        if op in _FADING:
            found[key] = inner
        elif has_name:
            least = as_expression(1.0) if _has(_EVEN, inner, moving) else _least(inner, moving, math.inf)
            if least is not None and moving.isdisjoint(symbols_in(operands[1])):
                found[key] = _logarithm(as_expression(inner / least), operands[1])
        elif (least := _least(inner, moving)) is not None:
            found[key] = as_expression(-ca.log(ca.fabs(inner / least)))

    rebuilt(expressions, numbering, note)
    for factor in products.factors:
        if (place := products.place(factor, moving)) is not None:
            found[True, factor] = place
    return ca.vertcat(ca.SX(0, 1), *(g for g in found.values() if rest.isdisjoint(symbols_in(g))))


def _logarithm(value: Expression, power: Expression) -> Expression:
    """Of the power of what may be 0, from where that is more than rounding beside 1."""
    return as_expression(power / 2 * ca.log(value * value + ca.exp(-2 * _FAINT / ca.fabs(power))))


def _least(x: Expression, moving: frozenset[int], power: float = 1.0) -> Expression | None:
    """w^2 of w^2 + what is even in a difference that may be 0, or swings; None of anything else, of low powers of what swings,
    where all methods see that, and where it swings so little that this power is narrow nowhere."""
    steady, others = as_expression(0.0), list[Expression]()
    waiting = [x]
    while waiting:
        term = waiting.pop()
        if moving.isdisjoint(symbols_in(term)):
            steady = steady + term
        elif term.op() == ca.OP_ADD:
            waiting += _operands(term)
        elif term.op() == ca.OP_SUB and _has(_WAVES, _operands(term)[1], moving):
            waiting.append(_operands(term)[0])
            others.append(_operands(term)[1])
        else:
            others.append(term)
    is_sum = all(_has(_EVEN, term, moving) for term in others)
    is_nothing = steady.is_constant() and abs(float(steady)) <= TINY  # which keeps lengths of 0 from dividing
    if not is_sum or is_nothing or (power < _HIGH and any(_has(_WAVES, term, moving) for term in others)):
        return None
    middle, swing = abs(float(steady)) if steady.is_constant() else 0.0, sum(_swing(term) for term in others)
    return None if middle > swing and power * math.log((middle + swing) / (middle - swing)) < _FLAT else steady


def _swing(x: Expression) -> float:
    """The largest value of a wave or of its square, times a number; infinite of anything else."""
    if x.op() in _WAVES:
        return 1.0
    operands = _operands(x)
    if x.op() == ca.OP_SQ:
        return _swing(operands[0]) ** 2
    numbers = [abs(float(operand)) for operand in operands if operand.is_constant()]
    if x.op() == ca.OP_MUL and numbers:
        return numbers[0] * _swing(operands[operands[0].is_constant()])
    return _swing(operands[0]) / numbers[0] if x.op() == ca.OP_DIV and numbers and numbers[0] > 0 else math.inf


def _has(operations: frozenset[int], x: Expression, moving: frozenset[int]) -> bool:
    """Whether it is one of these, or a multiple of one, of what moves."""
    if x.op() in operations:
        return True
    factors: Sequence[Expression] = _operands(x) if x.op() in (ca.OP_MUL, ca.OP_DIV) else []
    steady = [moving.isdisjoint(symbols_in(factor)) for factor in factors]
    if x.op() == ca.OP_MUL and any(steady):
        return _has(operations, factors[steady.index(False)], moving)
    return x.op() == ca.OP_DIV and steady[1] and _has(operations, factors[0], moving)


def _operands(x: Expression) -> list[Expression]:
    return [as_expression(x.dep(k)) for k in range(x.n_dep())]
