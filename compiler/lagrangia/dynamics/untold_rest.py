"""Forces -> a refusal of those that say something else of rest than of motion without saying what.

An even function of the sign of a rate, sign(v)^2, is 1 except where v rests: `F*(3 - sign(v)^2)*sign(v)` rubs with 2 F, and
nobody knows whether it holds up to 3 F. Forces are looked at as functions of each sign s: at s = 1 and s = -1, where it moves,
and with value and slope at s = 0. What is told of rest lies between the two sides; what is odd as a whole, s^3 s^2, has no
slope there, and holds as much as it rubs (A.F. Filippov, Differential equations with discontinuous righthand sides, 1988).

What asks whether something rests in a shape that nobody knows (v^4 > 0, max(v, -v) > 0, exp(abs(v)) > 1) is found by values:
with all signs as in a direction, forces at rest are not those of ever slower motion that way.
"""

from collections.abc import Iterator, Sequence
from dataclasses import replace

import casadi as ca
import numpy as np

from lagrangia.algebra.numbering import Numbering, rebuilt
from lagrangia.algebra.orthogonal import Vector
from lagrangia.algebra.scalars import Expression, as_expression, operate, symbol, symbols_in
from lagrangia.algebra.with_casadi import CORNERS, STEPS
from lagrangia.base.diagnostics import LagError, Span, fail
from lagrangia.dynamics.acting_rates import groups_of_rates
from lagrangia.dynamics.directions import Direction, length_power
from lagrangia.dynamics.dissipation import gradient_by_rates
from lagrangia.dynamics.driven_conditions import Pair
from lagrangia.dynamics.energies import Energies
from lagrangia.dynamics.found_conditions import conditions_in
from lagrangia.dynamics.held_switches import SIGNS, WHOLE, Holding, ordered, pair_of, rest_asked
from lagrangia.dynamics.motion import Motion
from lagrangia.dynamics.switches import bends

_ASKING = (ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, *WHOLE)
_TURNING = (ca.OP_LT, ca.OP_LE, ca.OP_SIGN, ca.OP_FABS)
_PRODUCTS = (ca.OP_MUL, ca.OP_IF_ELSE_ZERO)
_KEEPING = (ca.OP_NEG, ca.OP_TWICE, ca.OP_ADD, ca.OP_SUB, ca.OP_NOT)  # what is linear in all operands
_LITTLE = 1e-30  # m/s or rad/s: of a rate that moves
_NOTHING, _SAME, _ZERO = 1e-9, 1e-6, 1e-12  # relative: of a value; of slopes; of a rate that is another one's multiple
_SLOW, _JUMP = 1e-11, 10.0  # m/s or rad/s: of slow motion; a force changes more from rest to there than from there to twice
_POINTS = 3
_SCALES = (1.0, 1.0, 1.0, 1e3, 1e6, 1e9)  # of places and all else that is given: what has limits reaches them far away
_HINT = ("what holds at rest is told by F_static, mu_static or tau_static of the component, or by "
         "`if abs(v) > 0 then ... else ...`: the second value is that at rest, with its sign, as -Fs*sign(v): any force up to Fs")


def refuse_untold_rest(energies: Energies, motion: Motion) -> None:
    """Raises LagError L0918, placed at the term of the energies that jumps so, or at the load; L0914 for conditions of them that
    are not taken."""
    if not motion.operations.isdisjoint(STEPS):
        _refuse_equal(energies, motion)
    stepped = symbols_in(motion.stepped)  # discrete variables neither move nor rest
    v = ca.vertcat(ca.SX(0, 1), *(x for x in motion.v.elements() if x.__hash__() not in stepped))
    if not bends(motion) or not _is_untold((motion.unsolved or motion).h, v):
        return
    untold = _untold_rates(motion.unsolved or motion, v)
    for force, span in _apart(energies, motion.v):
        if untold.numel() and _is_untold(force, untold):
            _refuse(span)
    if untold.numel():
        _refuse(None)


def _untold_rates(known: Motion, v: ca.SX) -> ca.SX:
    """Of those, the groups of which the own forces are so: for others what is at rest is on its level (held_motion.py)."""
    groups, moving, found = groups_of_rates(known), symbols_in(v), ca.SX(0, 1)
    for group in dict.fromkeys(groups):
        rows = [k for k, own in enumerate(groups) if own == group]
        own = ca.vertcat(ca.SX(0, 1), *(x for x in known.v[rows].elements() if x.__hash__() in moving))
        if own.numel() and _is_untold(ca.densify(known.h)[rows], own):
            found = ca.vertcat(found, own)
    return found


def _refuse_equal(energies: Energies, motion: Motion) -> None:
    for force, span in _apart(energies, motion.v):
        try:
            conditions_in([ca.densify(force)], ca.vertcat(motion.t, motion.q, motion.v, motion.u), motion.v, Numbering())
        except LagError as error:
            raise LagError(replace(found, span=span) for found in error.diagnostics) from None


def _refuse(span: Span | None) -> None:
    fail("L0918", "not supported yet: a force that is another one just where a rate rests, as sign(v)^2 is, so that it is not "
         "told what holds there", span, _HINT)


def _apart(energies: Energies, v: ca.SX) -> Iterator[tuple[ca.SX, Span]]:
    """The force of each load and of each term of dissipation, with its place."""
    for load in energies.loads:
        yield ca.vertcat(*load.force), load.statement.span
    for term in energies.dissipation:
        yield gradient_by_rates(ca.SX(term.value), v), term.statement.span


def _is_untold(force: ca.SX, v: ca.SX) -> bool:
    probe = _Probe(v, Numbering())
    (held,) = rebuilt([ca.densify(force)], probe.numbering, probe.made)
    if probe.asks_rest and _rests_beyond(force, held, probe, v):
        return True
    if probe.is_asking and any(_is_apart(values) for values in _values_from_rest(held, probe, v)):
        return True
    return probe.is_doubtful and any(_tells_nothing(values) for values in _values_of(held, probe, v))


def _rests_beyond(force: ca.SX, moving: ca.SX, probe: "_Probe", v: ca.SX) -> bool:
    """Whether a force that jumps with the sign of a rate is told at rest without that sign, and not between both sides: what
    holds there is a share of what rubs (switches.py)."""
    probe.is_resting = True
    (resting,) = rebuilt([ca.densify(force)], probe.numbering, probe.made)
    probe.is_resting = False
    signs = ca.vertcat(ca.SX(0, 1), *(pair[1] for pair in probe.found.values()))
    if not signs.numel() or not ca.jacobian(resting, signs).is_zero() or ca.jacobian(moving, signs).is_zero():
        return False
    n = moving.numel()
    for ahead, back, rest, _ in _values_of(ca.vertcat(moving, resting), probe, v):
        sides, at_rest = np.array([ahead[:n], back[:n]]), rest[n:]
        little = _NOTHING * np.abs(sides).max(axis=0)
        if ((at_rest < sides.min(axis=0) - little) | (at_rest > sides.max(axis=0) + little)).any():
            return True
    return False


def _is_apart(values: Sequence[Vector]) -> bool:
    """Of forces at rest, at a slow motion and at twice that: whether they jump as it begins."""
    if not np.isfinite(values).all():
        return False
    rest, slow, twice = values
    return bool((np.abs(slow - rest) > _JUMP * np.abs(twice - slow) + _NOTHING * np.abs(values).max(axis=0)).any())


def _values_from_rest(held: ca.SX, probe: "_Probe", v: ca.SX) -> Iterator[Sequence[Vector]]:
    """In a few directions, with the signs that rates have in each also at rest."""
    forces, moving, symbols = _functions_of(held, probe, v)
    random, n = np.random.default_rng(2), v.numel()
    for _ in range(_POINTS):
        at = random.uniform(0.5, 1.5, symbols.numel())
        way = random.uniform(0.5, 1.5, n) * random.choice([-1.0, 1.0], n)
        for turn in (1.0, -1.0):
            at[:n] = 0.0
            rates, J = (np.array(x) for x in moving(at))
            signs, values = np.sign(np.where(rates.ravel() == 0, turn * (J @ way), rates.ravel())), []
            for speed in (0.0, _SLOW, 2 * _SLOW):
                at[:n] = turn * speed * way
                now = np.array(moving(at)[0]).ravel()
                values.append(np.array(forces(at, now, np.sign(now) if speed else signs)[0]).ravel())
            yield values


def _tells_nothing(values: Sequence[Vector]) -> bool:
    """Of forces where a rate is positive, negative and 0, and their slopes there."""
    ahead, back, rest, slope = values
    if not np.isfinite(values).all():
        return bool(np.isfinite([ahead, back]).all())
    size = np.abs([ahead, back, rest]).max(axis=0)
    little = _NOTHING * size
    is_outside = (rest < np.minimum(ahead, back) - little) | (rest > np.maximum(ahead, back) + little)
    sides = np.sort([ahead - rest, rest - back], axis=0)
    near = little + _SAME * np.abs(slope)
    is_other = (np.abs(slope) > little) & ((slope < sides[0] - near) | (slope > sides[1] + near))
    return bool((is_outside | is_other).any())


def _values_of(held: ca.SX, probe: "_Probe", v: ca.SX) -> Iterator[tuple[Vector, Vector, Vector, Vector]]:
    """Of each rate, at a few general places where it rests."""
    forces, moving, symbols = _functions_of(held, probe, v)
    random = np.random.default_rng(1)
    for scale in _SCALES:
        place = scale * random.uniform(0.5, 1.5, symbols.numel())
        for k in range(len(probe.found)):
            at, found, J = place.copy(), *map(np.array, moving(place))
            if not (weight := J[k] @ J[k]) > 0:
                continue
            way = J[k] / weight
            at[: v.numel()] -= way * found[k, 0]
            found, J = np.array(moving(at)[0]).ravel(), np.array(moving(at)[1])
            together = np.abs(found) < _ZERO * np.maximum(1.0, np.abs(J).sum(axis=1))
            turned = np.where(together, np.sign(J @ way), 0.0)
            others = np.where(together, 0.0, found)
            ahead, back, rest = (forces(at, others + d * _LITTLE * turned, np.sign(others) + d * turned) for d in (1, -1, 0))
            f = [np.array(values[0]).ravel() for values in (ahead, back, rest)]
            if scale == 1.0 or np.isfinite(f).all():
                yield f[0], f[1], f[2], np.array(rest[1]) @ turned


def _functions_of(held: ca.SX, probe: "_Probe", v: ca.SX) -> tuple[ca.Function, ca.Function, ca.SX]:
    """Forces and their slopes by signs, of all symbols x, the rates and their signs; rates and their slopes by v, of x; and x."""
    rates, pairs = ca.vertcat(ca.SX(0, 1), *probe.rates.values()), list(probe.found.values())
    G, s = (ca.vertcat(ca.SX(0, 1), *(pair[k] for pair in pairs)) for k in (0, 1))
    own = symbols_in(ca.vertcat(G, s))
    x = ca.vertcat(v, *(y for y in ca.symvar(ca.veccat(held, rates)) if y.__hash__() not in own | symbols_in(v)))
    forces = ca.Function("forces", [x, G, s], [held, ca.densify(ca.jacobian(held, s))])
    return forces, ca.Function("rates", [x], [rates, ca.densify(ca.jacobian(rates, v))]), x


class _Probe(Holding):
    """Makes forces anew with a symbol for each rate whose sign they ask for, and one for the sign."""

    def __init__(self, v: ca.SX, numbering: Numbering) -> None:
        super().__init__({}, frozenset(), {}, numbering)
        self.moving = symbols_in(v)
        self.rates = dict[Pair, Expression]()
        self.found = dict[Pair, tuple[Expression, Expression]]()  # the symbols of a rate and of its sign
        self.jumping, self.cornered = set[int](), set[int]()  # numbers of what jumps with a sign, and of what is not smooth
        self.is_doubtful = False  # whether forces are more than linear in a sign
        self.asks_rest = self.is_resting = False  # whether something asks if a rate rests; and what it is told
        self.is_asking = False  # whether they compare rates in another way than by what is known to ask whether one rests

    def made(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression:
        """An instruction: as in motion, where it asks whether something rests."""
        number, is_smooth = self.numbering.of(op, numbers), self.cornered.isdisjoint(numbers)
        if op in CORNERS or not is_smooth:
            self.cornered.add(number)
        is_of_rate = op in CORNERS and not self.moving.isdisjoint(symbols_in(ca.veccat(*operands)))
        asked = rest_asked(self.numbering, op, numbers) if is_of_rate else None
        if asked is not None:
            self.asks_rest = True
            return as_expression(1.0 if asked[1] == self.is_resting else 0.0)
        self.is_asking |= is_of_rate and op in _ASKING
        if is_of_rate and op in _TURNING and (made := self._of_rate(op, numbers, operands, is_smooth)) is not None:
            return made
        directed = self._directed(op, numbers, operands)
        self._note(op, number, numbers, directed is not None)
        return operate(op, operands) if directed is None else directed

    def _of_rate(self, op: int, numbers: list[int], operands: list[Expression], is_smooth: bool) -> Expression | None:
        number, zero = self.numbering.of(op, numbers), as_expression(0.0)
        if op == ca.OP_SIGN and (not is_smooth or operands[0].op() == ca.OP_SQ):  # it jumps, and not as the sign of a rate
            self.is_doubtful = True
            self.jumping.add(number)
            if is_smooth:
                root = as_expression(operands[0].dep(0))
                return operate(op, [self.made(ca.OP_FABS, [self.numbering.number(root)], [root])])
        pair = pair_of(self.numbering, op, numbers) if is_smooth else None
        if pair is None:
            return None
        a, b = operands if op not in SIGNS else (operands[0], zero)
        if pair not in self.found:
            self.rates[pair] = a - b if numbers[0] == pair[0] else b - a
            self.found[pair] = symbol("rate"), symbol("sign")
            self.moving |= symbols_in(ca.vertcat(*self.found[pair]))
        if op == ca.OP_SIGN:
            self.jumping.add(number)
            return self._sign(pair, numbers[0])
        if op == ca.OP_FABS:
            return operate(op, [self.found[pair][0]])
        self.jumping.add(number)
        return operate(op, [self._sign(pair, numbers[0]), zero])

    def _share(self, found: Direction, component: Expression, length: Expression, is_below: bool) -> Expression | None:
        pair = ordered(found.component, self.numbering.of_number(0.0))
        if len(found.components) > 1 or pair not in self.found:
            return None
        sign = as_expression(self._sign(pair, found.component) / found.ratio)
        if length_power(self.numbering, found.length) is None:
            return sign
        exponent = 0.5 if length.op() == ca.OP_SQRT else length.dep(1)
        return as_expression(sign * length.dep(0) ** ca.fmax(0, 1 - exponent if is_below else 1 + exponent))

    def _sign(self, pair: Pair, number: int) -> Expression:
        sign = self.found[pair][1]
        return sign if number == pair[0] else -sign

    def _combined(self, op: int, operands: Sequence[Expression]) -> Expression:
        return operate(op, operands)

    def _note(self, op: int, number: int, numbers: list[int], is_sign: bool) -> None:
        """Whether a value jumps, and may do so otherwise than linearly."""
        jumping = [k in self.jumping for k in numbers]
        if any(jumping) or is_sign:
            self.jumping.add(number)
        is_linear = op in _KEEPING or (op in _PRODUCTS and sum(jumping) == 1) or (op == ca.OP_DIV and not jumping[1])
        self.is_doubtful |= any(jumping) and not is_linear
