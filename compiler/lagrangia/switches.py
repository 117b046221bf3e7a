"""Motion -> switches: what a condition on the state decides, which a step of the run time holds.

Forces bend or jump where such a condition changes: at a stop, at a point of a table along a coordinate, where a rate turns. No
step is short enough to be smooth there. So a step takes what the conditions say at its beginning, and where one of them is found
changed at its end the run goes back to the place: the equations are smooth in every step, and have Taylor series.

The switch s of a < b, of max(a, b), abs(a - b) and sign(a - b) is 1 where g = a - b > 0, and 0 where g < 0. Where forces that
jump with a velocity hold it at their jump (dry friction that sticks), s is the share in between that keeps g at 0: forces are as
linear in s as they can be made (A.F. Filippov, Differential equations with discontinuous righthand sides, 1988).
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from itertools import islice

import casadi as ca

from lagrangia.casadi_algebra import CORNERS, uses
from lagrangia.motion import Motion
from lagrangia.numbering import Numbering
from lagrangia.scalars import Expression, apply, apply_to_one, as_expression, symbol, symbols_in

_RELATIONS = (ca.OP_LT, ca.OP_LE, ca.OP_FMIN, ca.OP_FMAX)
_JUMPS = (ca.OP_LT, ca.OP_LE, ca.OP_SIGN)
_SIGNS = (ca.OP_FABS, ca.OP_SIGN)
_Pair = tuple[int, int]  # the numbers of a and b, the smaller one first
_Make = Callable[[int, list[int], list[Expression]], Expression | None]


@dataclass(frozen=True)
class Switches:
    """`symbols` (k,) for the switches; `values` g (k,) of t, q, v, u, d, p, and `rates` along a motion with accelerations."""

    symbols: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    values: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    rates: ca.SX = field(default_factory=lambda: ca.SX(0, 1))
    places: "dict[_Pair, Expression]" = field(default_factory=dict)  # the symbol of each
    shares: frozenset[int] = frozenset()  # hashes of the symbols that may be between 0 and 1
    numbering: Numbering = field(default_factory=Numbering)

    def hold(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """The same with the symbols in place of what they stand for."""
        return _rebuilt(expressions, self.numbering, self._held) if self.places else list(expressions)

    def _held(self, op: int, numbers: list[int], operands: list[Expression]) -> Expression | None:
        pair = _pair(self.numbering, op, numbers)
        if pair not in self.places:
            return self._shared(op, operands)
        is_positive = self.places[pair]  # a > b, where a has the smaller number
        if op not in _JUMPS:
            is_positive = self._bounded(is_positive)
        if op in _SIGNS:
            sign = as_expression(2 * is_positive - 1 if numbers[0] == pair[0] else 1 - 2 * is_positive)
            return sign if op == ca.OP_SIGN else as_expression(sign * operands[0])
        is_less = is_positive if numbers[1] == pair[0] else self._opposite(is_positive)
        if op in _JUMPS:
            return is_less
        smaller, larger = operands if op == ca.OP_FMIN else operands[::-1]
        return as_expression(self._chosen(is_less, smaller) + self._chosen(self._opposite(is_less), larger))

    def _bounded(self, condition: Expression) -> Expression:
        """Of what does not jump: no part of it is more than the whole, or less than nothing."""
        if self.shares.isdisjoint(symbols_in(condition)):
            return condition
        return as_expression(apply(ca.OP_FMIN, apply(ca.OP_FMAX, condition, 0.0), 1.0))

    def _shared(self, op: int, operands: list[Expression]) -> Expression | None:
        """What CasADi makes of conditions, with shares for conditions."""
        if op not in (ca.OP_NOT, ca.OP_IF_ELSE_ZERO) or self.shares.isdisjoint(symbols_in(operands[0])):
            return None
        return self._opposite(operands[0]) if op == ca.OP_NOT else self._chosen(*operands)

    def _opposite(self, condition: Expression) -> Expression:
        if self.shares.isdisjoint(symbols_in(condition)):
            return as_expression(apply_to_one(ca.OP_NOT, condition))
        return as_expression(1.0 - condition)

    def _chosen(self, condition: Expression, value: Expression) -> Expression:
        """A share of nothing is nothing, even of what has no value there. The condition holds wholly in it, so that forces are
        linear in each share."""
        shares = [s for s in ca.symvar(condition) if s.__hash__() in self.shares]
        if not shares:
            return as_expression(apply(ca.OP_IF_ELSE_ZERO, condition, value))
        if len(ca.symvar(condition)) == 1 and not symbols_in(condition).isdisjoint(symbols_in(value)):
            value = as_expression(ca.substitute(value, shares[0], ca.substitute(condition, shares[0], 1)))
        return as_expression(apply(ca.OP_IF_ELSE_ZERO, condition, condition * value))


def has_corners(motion: Motion) -> bool:
    """Whether forces bend or jump somewhere."""
    return uses(ca.Function("h", ca.symvar(motion.h), [motion.h]), CORNERS)


def find_switches(motion: Motion) -> Switches:
    """Those of the conditions in the forces that the state decides, or time in a way that is not known beforehand."""
    if not has_corners(motion):
        return Switches()
    numbering, found = Numbering(), dict[_Pair, Expression]()
    moving = symbols_in(ca.vertcat(motion.t, motion.q, motion.v, motion.u))

    def note(op: int, numbers: list[int], operands: list[Expression]) -> None:
        pair = _pair(numbering, op, numbers)
        if pair is None or pair in found:
            return
        a, b = operands if op in _RELATIONS else (operands[0], as_expression(0.0))
        g = a - b if numbers[0] == pair[0] else b - a
        if not moving.isdisjoint(symbols_in(g)):
            found[pair] = g

    _rebuilt([motion.h], numbering, note)
    values = ca.vertcat(ca.SX(0, 1), *found.values())
    rates = ca.jtimes(values, ca.vertcat(motion.q, motion.v, motion.t), ca.vertcat(motion.v, motion.a, 1))
    places, velocities = {pair: symbol(f"s_{k}") for k, pair in enumerate(found)}, symbols_in(motion.v)
    shares = frozenset(s.__hash__() for s, g in zip(places.values(), found.values(), strict=True)
                       if not velocities.isdisjoint(symbols_in(g)))
    return Switches(ca.vertcat(ca.SX(0, 1), *places.values()), values, rates, places, shares, numbering)


def live(name: str, functions: Mapping[str, ca.Function]) -> ca.Function:
    """`rhs` or `outputs` of the run time's functions with each switch as its condition is."""
    held, switches = functions[name], functions.get("switches")
    if switches is None:
        return held
    names = [held.name_in(k) for k in range(held.n_in())]
    given = {label: ca.SX.sym(label, held.size1_in(label)) for label in names}
    given["d"] = ca.SX.sym("d", switches.size1_in("d"))
    known = {switches.name_in(k): ca.SX.zeros(switches.size1_in(k)) for k in range(switches.n_in())}
    g = switches.call(known | {label: given[label] for label in names if label in known})["g"]
    found = held.call(given | {"d": ca.vertcat(given["d"], (g > 0) + 0.5 * (g == 0))})
    results = [held.name_out(k) for k in range(held.n_out())]
    return ca.Function(name, [given[label] for label in names], [found[label] for label in results], names, results)


def _pair(numbering: Numbering, op: int, numbers: list[int]) -> _Pair | None:
    if op in _SIGNS:
        numbers = [numbers[0], numbering.of_number(0.0)]
    elif op not in _RELATIONS:
        return None
    a, b = sorted(numbers)
    return (a, b) if a != b else None


def _rebuilt(expressions: Sequence[ca.SX], numbering: Numbering, make: _Make) -> list[ca.SX]:
    """The expressions made anew, with what `make` gives for an instruction, unless that is None."""
    column = ca.vertcat(ca.SX(0, 1), *(e.nz[:] for e in expressions))
    symbols = ca.symvar(column)
    function = ca.Function("rebuilt", symbols, [column])
    held: list[tuple[int, Expression]] = [(0, as_expression(0.0))] * max(1, function.sz_w())
    results = [as_expression(0.0)] * column.numel()
    for k in range(function.n_instructions()):
        op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            held[outputs[0]] = numbering.of_symbol(symbols[inputs[0]]), as_expression(symbols[inputs[0]])
        elif op == ca.OP_CONST:
            number = function.instruction_constant(k)
            held[outputs[0]] = numbering.of_number(number), as_expression(number)
        elif op == ca.OP_OUTPUT:
            results[outputs[1]] = held[inputs[0]][1]
        else:
            numbers, operands = [held[place][0] for place in inputs], [held[place][1] for place in inputs]
            made = make(op, numbers, operands)
            held[outputs[0]] = numbering.of(op, numbers), _applied(op, operands) if made is None else made
    rest = iter(results)
    return [ca.SX(e.sparsity(), ca.vertcat(ca.SX(0, 1), *islice(rest, e.nnz()))) for e in expressions]


def _applied(op: int, operands: list[Expression]) -> Expression:
    made: Expression = apply_to_one(op, *operands) if len(operands) == 1 else apply(op, *operands)
    return made
