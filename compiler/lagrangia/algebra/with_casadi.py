"""The first algebra: CasADi. Conditions on time become modes, so that what is integrated is smooth between time events."""

import math
from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import field
from functools import cached_property, partial
from itertools import accumulate, pairwise
from math import prod
from typing import Any

import casadi as ca

from lagrangia.algebra.coefficients import is_length, signed, spread
from lagrangia.algebra.condition_forms import (
    OPPOSITES,
    are_mirrored,
    chosen_numbers,
    in_one,
    of_sign,
    turned_relation,
    without_sign,
)
from lagrangia.algebra.crossings import Crossing, find_crossing
from lagrangia.algebra.duals import TINY, NotATimeError, Scalar, is_zero, nested_lines, slopes_of, times
from lagrangia.algebra.lengths import exact_lengths
from lagrangia.algebra.lookup_functions import TableUse, in_force, written
from lagrangia.algebra.modes import RELATIONS, Mode, ModeIndex
from lagrangia.algebra.numbering import rebuilt
from lagrangia.algebra.powers import bound_known, length_powers, never_negative, powers_in_exponent
from lagrangia.algebra.scalars import Expression, apply, apply_to_one, as_expression, operate, symbols_in
from lagrangia.algebra.scalars import symbol as make_symbol
from lagrangia.algebra.widths import arms_of, width_beside
from lagrangia.base.diagnostics import Span
from lagrangia.base.records import dataclass
from lagrangia.base.table_data import Beyond, TableData, lines_between

_NUMBERS = (float, int)
_FIRST_TABLE = 2  # kind of the events of table 0
_RATE = 2  # column of the pieces of an input
_MOST_KNOTS = 2_000  # of a table that is written out, as one along a coordinate


@dataclass
class CasadiAlgebra:
    """Scalars are ca.SX or float. Conditions on time and parameters alone become modes, so that the right-hand side is smooth
    between time events and the integrator can stop exactly at them."""

    time: ca.SX
    state: ca.SX  # all symbols that change continuously besides time: q, v, u
    rates: frozenset[int] = frozenset()  # hashes of v
    is_nothing: Callable[[ca.SX], bool] = lambda x: False  # whether an expression of parameters is 0 as they are declared
    modes: list[Mode] = field(default_factory=list)
    index: ModeIndex = field(default_factory=ModeIndex)  # of these modes
    tiny: float = TINY
    most_points: float = math.inf
    _known_changing: tuple[tuple[int, int], frozenset[int]] = field(default=((-1, -1), frozenset()), init=False)

    @property
    def mode_symbols(self) -> ca.SX:
        """The symbols of all modes, (modes, 1)."""
        return ca.vertcat(*[mode.symbol for mode in self.modes])

    def with_modes(self, expressions: list[ca.SX]) -> list[ca.SX]:
        """The same with what modes are in place of their symbols: of time and parameters."""
        if not self.modes:
            return expressions
        found: list[ca.SX] = ca.substitute(expressions, [m.symbol for m in self.modes], [m.value for m in self.modes])
        return found

    def by_inputs(self, expressions: list[ca.SX], slopes: ca.SX | None = None) -> list[ca.SX]:
        """With inputs and their rates, as they are set at the time, in the place of modes that come from them. `slopes`: rates of
        inputs that have no inputs for these, 0 where nothing is given."""
        modes = [mode for mode in self.modes if mode.of_input is not None]
        if not modes:
            return expressions
        values = [m.value for m in modes]
        for k, mode in enumerate(modes if slopes is not None and slopes.numel() else ()):
            if slopes is not None and mode.of_input is not None and mode.of_input[1] < 0 and mode.column == _RATE:
                values[k] = slopes[mode.of_input[0]]
        found: list[ca.SX] = ca.substitute(expressions, [mode.symbol for mode in modes], values)
        return found

    def number(self, value: float) -> Scalar:
        """A plain number, which CasADi takes as it is."""
        return value

    def note_length(self, x: Scalar) -> None:
        """Keeps what is a length on a line, whose sign is known."""
        if isinstance(x, ca.SX):
            self.index.lengths.setdefault(self._number(x), x)

    def call(self, function: str, *arguments: Scalar) -> Scalar:
        """CasADi's function of that name; floor, ceil and signs become modes where time decides on them."""
        if function != "sqrt" or not isinstance(arguments[0], ca.SX) or not self._is_steady(arguments[0]):
            self.index.asked.add(function)
        if function in ("floor", "ceil"):
            arguments = (_exact(self._at_rest(arguments[0])),)
            inner = arguments[0] if function == "floor" else -arguments[0]
            crossing = self._crossing(inner)
            if crossing is not None and not crossing.steps:
                lines, _ = crossing.events([0.0])
                mode = self._mode(("floor", crossing.number), ca.floor(crossing.value), lines, [1] * len(lines))
                return mode if function == "floor" else -mode
        if function == "sign":
            arguments = (of_sign(_exact(arguments[0])),)
        if function == "sign" and (crossing := self._crossing(self._at_rest(arguments[0]), may_wave=True)) is not None:
            return self._sign(crossing)
        if function == "mod":
            a, b = arguments
            if isinstance(b, float | int) and b == 0:
                raise ZeroDivisionError  # which 0 times infinity would hide
            return a - b * self.call("floor", a / b)
        if function == "abs" and isinstance(arguments[0], ca.SX):
            return self._absolute(without_sign(arguments[0]))
        if function in ("fmin", "fmax"):
            arguments = tuple(signed(a, self.rates) for a in arguments)
            if (known := bound_known(function == "fmax", *arguments)) is not None:
                return known
        if all(isinstance(a, float | int) for a in arguments):
            return _call_float(function, *arguments)
        if function == "abs" and (inner := of_sign(arguments[0])) is not arguments[0]:
            return self.compare("<>", inner, 0.0)
        if function in ("sqrt", "pow") and isinstance(arguments[0], ca.SX):
            return self._power(function, *arguments)
        if function == "exp" and (found := powers_in_exponent(arguments[0]))[0]:
            powers = [self.call("pow", x, b) for x, b in found[0]]
            return prod(powers, start=1.0 if found[1].is_zero() else apply_to_one(ca.OP_EXP, found[1]))
        return _SX_FUNCTIONS[function](*arguments)

    def product(self, x: Scalar, y: Scalar) -> Scalar:
        """Of rates with coefficients that are divided by their lengths, by the terms of these."""
        are_both = isinstance(x, ca.SX) and isinstance(y, ca.SX) and self.index.divisors.has_lengths
        made = next((m for a, b in ((x, y), (y, x)) if are_both and (m := spread(a, b, self.rates)) is not None), None)
        return times(x, y) if made is None else made

    def quotient(self, x: Scalar, y: Scalar, place: Span) -> Scalar:
        """By each of two divisors that parameters choose among. Keeps what is divided by parameters alone, and whether quotients
        may turn within a narrow range of what stands under them."""
        if not isinstance(y, ca.SX):
            return x / y
        if self._is_steady(y):
            if isinstance(x, ca.SX) and not y.is_constant() and not self._is_steady(x):
                self.index.divisors.note(as_expression(y), place)
            return x / self._by_factors(y)
        self._note_divisor(y)
        if (arms := arms_of(y)) is not None and self._is_steady(arms[0]):
            return self.choose(arms[0], self.quotient(x, arms[1], place), self.quotient(x, arms[2], place))
        if y.op() == ca.OP_ADD:
            self.index.asked.add("ratio")
        made = x / self._by_factors(y)
        if (beside := width_beside(y, self.rates, self._is_steady)) is None:
            return made
        return self._beside(y, beside[1], made, lambda: self.quotient(x, beside[0], place))

    def _note_divisor(self, y: ca.SX) -> None:
        self.index.divisors.has_lengths |= is_length(y, self.rates)

    def _by_factors(self, x: ca.SX) -> Expression:
        """The same, with the lengths that it is a product of by their factors: of |c x| with c of parameters alone |c| and |x|,
        so that x/|x| is found in c x/|c x|; not where c is a number or a root, which is not 0 at one time and more at another."""
        if x.op() == ca.OP_FABS:
            return self._length(x.dep(0))
        if x.op() in (ca.OP_MUL, ca.OP_DIV):
            return as_expression(apply(x.op(), *(self._by_factors(x.dep(k)) for k in range(2))))
        return as_expression(x)

    def _absolute(self, x: ca.SX) -> Expression:
        """|x|; of quotients by what changes |a|/|b|, as |a/b| has no corner where b passes 0."""
        if x.op() not in (ca.OP_DIV, ca.OP_INV) or self._is_steady(x.dep(x.n_dep() - 1)):
            return apply_to_one(ca.OP_FABS, x)
        return self._by_parts(x, lambda part: self._by_factors(as_expression(self.call("abs", part))))

    def _by_parts(self, x: ca.SX, made: Callable[[ca.SX], Scalar]) -> Expression:
        """The quotient of what is made of both parts of one."""
        parts = [as_expression(made(x.dep(k))) for k in range(x.n_dep())]
        self._note_divisor(parts[-1])
        return operate(x.op(), parts)

    def _length(self, x: ca.SX) -> Expression:
        """|x|, by its factors."""
        parts = [x.dep(k) for k in range(2)] if x.op() in (ca.OP_MUL, ca.OP_DIV) else []
        known = [part for part in parts if self._is_steady(part)]
        if len(known) != 1 or known[0].is_constant() or known[0].op() == ca.OP_SQRT:
            return apply_to_one(ca.OP_FABS, x)
        return as_expression(apply(x.op(), *map(self._length, parts)))

    def _power(self, function: str, base: ca.SX, exponent: Scalar = 0.5) -> Expression:
        """sqrt or pow; of quotients by what changes and is never negative that of both."""
        if not isinstance(exponent, _NUMBERS) or exponent < 0:
            self._note_divisor(base)
        others = () if function == "sqrt" else (exponent,)
        below = base.dep(base.n_dep() - 1) if base.op() in (ca.OP_DIV, ca.OP_INV) else None
        if below is not None and never_negative(below) and not self._is_steady(below):
            return self._by_parts(base, lambda part: self.call(function, part, *others))
        is_whole = isinstance(exponent, _NUMBERS) and float(exponent).is_integer()
        is_root = isinstance(exponent, _NUMBERS) and exponent > 0 and not is_whole
        if is_root and (beside := width_beside(base, self.rates, self._is_steady)) is not None:
            plain = as_expression(_SX_FUNCTIONS[function](base, *others))
            return as_expression(self._beside(plain, beside[1], plain, lambda: self._power(function, beside[0], exponent)))
        lengths, rest = ([], base) if is_whole else length_powers(base, self._is_steady)
        if not lengths:
            return as_expression(_SX_FUNCTIONS[function](base, *others))
        made = as_expression(1.0)
        for length, k in lengths:
            power = k * exponent
            is_even = isinstance(power, _NUMBERS) and power % 2 == 0
            x = length.dep(0) if is_even else self._by_factors(as_expression(self.call("abs", length.dep(0))))
            made = as_expression(made * self.call("pow", x, power))
        return made if rest.is_one() else as_expression(made * self._power(function, rest, exponent))

    def _beside(self, x: ca.SX, width: ca.SX, made: Scalar, alone: Callable[[], Scalar]) -> Scalar:
        """What is made of x, v^2 + w^2 or its root, and of v^2 `alone` where the width w^2 is 0, if it is declared so."""
        if self.is_nothing(width):
            return self.choose(self.compare("==", width, 0.0), alone(), made)
        self.index.divisors.roots[self._number(x)] = as_expression(width)
        return made

    def _is_steady(self, x: ca.SX) -> bool:
        """Whether it follows from parameters alone, as the length of an axis does."""
        symbols = symbols_in(x)
        return self.changing.isdisjoint(symbols) and symbols_in(self.time).isdisjoint(symbols)

    def compare(self, operator: str, a: Scalar, b: Scalar, of_rates: bool = False) -> Scalar:
        """Of numbers 0 or 1; a mode where time decides, else CasADi's condition."""
        self.index.asked.add("choice")
        a, b = (signed(_exact(self._at_rest(x)), self.rates) for x in (a, b))
        if isinstance(a, float | int) and isinstance(b, float | int):
            return float(_COMPARE[operator](a, b))
        if isinstance(b, float | int) and (chosen := chosen_numbers(a)) is not None:  # as the choice says
            condition, *numbers = chosen
            here, there = (self.compare(operator, x, b, of_rates) for x in numbers)
            if isinstance(here, float) and isinstance(there, float):
                return here if here == there else condition if here else self.logic("not", condition)
            return self.logic("or", self.logic("and", condition, here),
                              self.logic("and", self.logic("not", condition), there))
        if is_zero(b) or is_zero(a):
            a, b = (of_sign(in_one(x)) for x in (a, b))
        if operator in ("==", "<>") and is_zero(b) and isinstance(a, ca.SX):
            a = without_sign(a)
        difference = a - b
        crossing = self._crossing(difference, of_rates) if operator not in ("==", "<>") else None
        return as_expression(_COMPARE[operator](a, b)) if crossing is None else self._relation(operator, crossing)

    def _relation(self, operator: str, crossing: Crossing) -> ca.SX:
        """The mode that says on which side of 0 it is."""
        arguments, kinds = crossing.events([0.0])
        told, told_in_pieces = (None if x is None else as_expression(_COMPARE[operator](x, 0))
                                for x in (crossing.value, crossing.in_pieces))
        return self._mode((operator, crossing.number), told, arguments, kinds, in_pieces=told_in_pieces)

    def side(self, x: Scalar) -> Scalar:
        """The sign of x; of modes where time decides."""
        return self.call("sign", x)

    def _sign(self, crossing: Crossing) -> ca.SX:
        return as_expression(self._relation(">", crossing) - self._relation("<", crossing))

    def choose(self, condition: Scalar, then: Scalar, otherwise: Scalar) -> Scalar:
        """The sum of both, each of which is 0 where the condition says so."""
        self.index.asked.add("choice")
        if isinstance(condition, float | int):
            return then if condition else otherwise
        opposite = apply_to_one(ca.OP_NOT, condition)
        return apply(ca.OP_IF_ELSE_ZERO, condition, then) + apply(ca.OP_IF_ELSE_ZERO, opposite, otherwise)

    @property
    def may_bend(self) -> bool:
        """Whether something may be one of several functions of time, besides what modes say already."""
        return not _BENDING.isdisjoint(self.index.asked)

    def arms_in_force(self, expressions: Sequence[ca.SX]) -> list[ca.SX]:
        """The same with modes for what max, min, abs, sign and comparisons take where time decides: what is made of them, as
        their rates, is that of one arm until the event."""

        def made(op: int, _: list[int], operands: list[Expression]) -> Expression | None:
            a, b = operands if len(operands) > 1 else (operands[0], 0.0)
            crossing = self._crossing(self._at_rest(a - b), may_wave=True) if op in _ARMS else None
            if crossing is None:
                return None
            if op in RELATIONS:
                return as_expression(self._relation(RELATIONS[op], crossing))
            if op in (ca.OP_FMIN, ca.OP_FMAX):
                return as_expression(self.choose(self._relation("<" if op == ca.OP_FMIN else ">", crossing), a, b))
            sign = self._sign(crossing)
            return as_expression(sign if op == ca.OP_SIGN else sign * a)

        is_bent = any(not _ARMS.isdisjoint(operations_in(x)) for x in expressions)
        return rebuilt(expressions, self.index.numbering, made) if is_bent else list(expressions)

    def logic(self, operator: str, *conditions: Scalar) -> Scalar:
        """Of a condition and its mirror image, as v > 0 or v < 0, it is said whether both are equal: see dynamics/switches.py."""
        if operator == "not":
            opposite = turned_relation(conditions[0], OPPOSITES)
            return 1.0 - conditions[0] if opposite is None else opposite
        a, b = conditions
        asks, tells = (ca.OP_LE, ca.OP_EQ) if operator == "and" else (ca.OP_LT, ca.OP_NE)
        if are_mirrored(a, b, asks):
            return apply(tells, a.dep(0), a.dep(1))
        return a * b if operator == "and" else a + b - a * b

    def lines(self, x: Scalar, xs: Sequence[Scalar], ys: Sequence[Scalar]) -> tuple[Scalar, Callable[[], Scalar]]:
        """The table's value as a sum of kinks, and its slope."""
        self.index.asked.add("choice")
        if not isinstance(x, ca.SX):
            return nested_lines(self, x, xs, ys)
        columns = [[xs[0], *xs], [ys[0], *ys], [0.0, *slopes_of(xs, ys), 0.0]]
        rest = self._at_rest(x)
        crossing = self._crossing(rest) if self._are_fixed([*xs, *ys]) else None
        if crossing is not None and crossing.is_straight and all(isinstance(entry, _NUMBERS) for entry in (*xs, *ys)):
            place, value, slope = self.pieces(x, self._literal(xs, ys))
            return value + (x - place) * slope, lambda: slope
        where = _cases([apply(ca.OP_LT, crossing.value, at) if crossing else self.compare("<", rest, at) for at in xs], xs)
        found = [in_force(where, column) for column in columns]
        if crossing:
            key, (arguments, kinds) = (crossing.number, *(self._key(entry) for entry in (*xs, *ys))), crossing.events(xs)
            found = [self._mode(("lines", k, key), value, arguments, kinds) for k, value in enumerate(found)]
        place, value, slope = found
        return value + (x - place) * slope, lambda: slope

    def pieces(self, x: Scalar, table: TableData) -> list[Scalar]:
        """Place and coefficients of the piece in force: modes, where time alone decides; else sums over all pieces."""
        self.index.asked.add("choice")
        if not isinstance(x, ca.SX):
            return list(table.piece(float(x)))
        rest = self._at_rest(x)
        crossing = self._crossing(rest)
        if crossing is not None and crossing.is_straight:
            return self._pieces_in_time(crossing.number, x, table)
        if table.n > _MOST_KNOTS or table.beyond is Beyond.ERROR:
            raise NotATimeError(table)
        moved: Scalar = 0.0
        if table.beyond is Beyond.PERIODIC:
            moved = self.call("floor", (rest - table.knot(0)) / table.period) * table.period
        place, *coefficients = written(table, [self.compare("<", rest - moved, at) for at in table.knots()])
        return [place + moved, *coefficients]

    def _pieces_in_time(self, number: int, x: ca.SX, table: TableData) -> list[Scalar]:
        known = next((k for k, other in enumerate(self.index.tables) if other.is_like(table)), len(self.index.tables))
        if known == len(self.index.tables):
            self.index.tables.append(table)
        use, arguments = TableUse(table, known, x), [x]
        return [self._mode(("table", known, column, number), None, arguments, [_FIRST_TABLE + known], use, column)
                for column in range(2 + table.degree)]

    def pieces_of_input(self, places: tuple[int, int, int], y: ca.SX, rate: Scalar, second: Scalar) -> list[ca.SX]:
        """Place and coefficients of what an input is in time, modes that the run time fills in: LAG_PIECE of inputs.h. Elsewhere
        it goes on from the present time with its rates."""
        values, arguments = (self.time, y, rate, second / 2, 0.0), list[ca.SX]()
        return [self._mode(("input", column, places[0]), as_expression(value), arguments, (), column=column, of_input=places)
                for column, value in enumerate(values)]

    def held(self, name: str, sampler: tuple[int, int], first: ca.SX, arguments: Sequence[ca.SX]) -> ca.SX:
        """A value that only changes where one of the arguments is a whole number, by what the run time asks for there; the number
        of its sampler and its rank."""
        return self._mode(("held", name), first, arguments, [1] * len(arguments), of_sampler=sampler)

    def reference(self, attitude: str, part: int, first: ca.SX) -> ca.SX:
        """A part of the reference of an attitude."""
        made = self._mode(("attitude", attitude, part), first, [], ())
        self.modes[-1].of_attitude = attitude
        self.index.hashes.discard(made.__hash__())
        self.index.references.add(made.__hash__())
        return made

    def _literal(self, xs: Sequence[float], ys: Sequence[float]) -> TableData:
        """Straight lines between points, held beyond their ends."""
        key = "points", tuple(xs), tuple(ys)
        if key not in self.index.literals:
            self.index.literals[key] = lines_between(xs, ys)
        return self.index.literals[key]

    def _at_rest(self, x: Scalar) -> Scalar:
        """What decides about conditions."""
        return self.index.displacements.at_rest(x) if isinstance(x, ca.SX) else x

    def _are_fixed(self, values: list[Scalar]) -> bool:
        """Whether they depend on parameters alone."""
        return self.changing.isdisjoint(symbols_in(ca.vertcat(ca.SX(0, 1), *values)))

    @property
    def changing(self) -> frozenset[int]:
        """The hashes of all symbols but parameters."""
        sizes = len(self.index.hashes), len(self.index.references)  # which grow, or hand over to each other
        if self._known_changing[0] != sizes:
            self._known_changing = sizes, self._moving | self.index.hashes | self.index.references | {self.time.__hash__()}
        return self._known_changing[1]

    def _key(self, value: Scalar) -> Hashable:
        """The same for what says the same, of numbers and of expressions of parameters."""
        return ("expression", self._number(value)) if isinstance(value, ca.SX) else float(value)

    def _crossing(self, value: Scalar, may_wave: bool = False) -> Crossing | None:
        """Of what depends on time, and on nothing else that changes, in such a way that its crossings can be computed. None for
        all else: what depends on other modes than relations and one floor stays a plain condition."""
        if not isinstance(value, ca.SX):
            return None
        hashes = symbols_in(value)
        if not hashes.isdisjoint(self._moving) or not hashes.isdisjoint(self.index.references):
            return None
        if may_wave and not hashes.isdisjoint(symbols_in(self.time)):  # of several bends, one within the other
            (value,) = self.arms_in_force([value])
            hashes = symbols_in(value)
        modes = [] if hashes.isdisjoint(self.index.hashes) else [mode for mode in self.index.modes if mode.hash in hashes]
        return find_crossing(value, self.time, modes, self.index.numbering, self._is_straight,
                             lambda x: jumps_with(x, self.time), may_wave)

    def _is_straight(self, value: ca.SX) -> bool:
        """a + b t; a slope does not tell of jumps."""
        steps = uses(ca.Function("value", ca.symvar(value), [value]), STEPS)
        return not steps and not ca.depends_on(ca.jacobian(value, self.time), self.time)

    def _number(self, value: ca.SX) -> int:
        return self.index.numbering.number(value)

    @cached_property
    def _moving(self) -> frozenset[int]:
        return frozenset(x.__hash__() for x in self.state.elements())

    def _mode(self, key: Hashable, value: ca.SX | None, arguments: Sequence[ca.SX], kinds: Sequence[int],
              use: TableUse | None = None, column: int = 0, of_input: tuple[int, int, int] | None = None,
              of_sampler: tuple[int, int] | None = None, in_pieces: ca.SX | None = None) -> ca.SX:
        if key not in self.index.symbols:
            made = self.index.symbols[key] = make_symbol(f"d_{len(self.modes)}")
            self.index.hashes.add(made.__hash__())
            mode = Mode(made, value, arguments, kinds, use, column, of_input, of_sampler, in_pieces)
            self.modes.append(mode)
            self.index.modes.append(mode)
        return self.index.symbols[key]


def _exact(x: Scalar) -> Scalar:
    """What decides about conditions: a length that is 0 at 0."""
    return as_expression(exact_lengths([x])[0]) if isinstance(x, ca.SX) else x


def _cases(less: list[Scalar], xs: Sequence[Scalar]) -> list[Scalar]:
    """Which point x is first less than: one condition each, the last where there is none. Parameters may make points fall."""
    if not all(isinstance(at, _NUMBERS) for at in xs):
        less = list(accumulate(less, lambda a, b: apply(ca.OP_OR, a, b)))
    return [less[0], *(b - a for a, b in pairwise(less)), apply_to_one(ca.OP_NOT, less[-1])]


STEPS = frozenset(getattr(ca, f"OP_{name}") for name in ("FLOOR", "CEIL", "SIGN", "FMOD", "COPYSIGN", "LT", "LE", "EQ", "NE",
                                                         "IF_ELSE_ZERO"))
CORNERS = STEPS | {ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX}


def operations_in(expression: ca.SX) -> frozenset[int]:
    """CasADi's operations that it is made by. All symbols are one vector: CasADi warns of functions with thousands of inputs."""
    function = ca.Function("made", [ca.vertcat(ca.SX(0, 1), *ca.symvar(expression))], [expression])
    return frozenset(map(function.instruction_id, range(function.n_instructions())))


def jumps_with(expression: ca.SX, places: ca.SX) -> bool:
    """Whether it takes another value at once where these symbols pass some place, as signs, conditions and whole numbers do."""
    known = symbols_in(places)
    others = ca.vertcat(ca.SX(0, 1), *[x for x in ca.symvar(expression) if x.__hash__() not in known])
    function = ca.Function("looked", [places, others], [expression])
    moved: dict[int, bool] = {}
    for k in range(function.n_instructions()):
        operation, read = function.instruction_id(k), function.instruction_input(k)
        is_moved = read[0] == 0 if operation == ca.OP_INPUT else any(moved[place] for place in read if operation != ca.OP_CONST)
        if is_moved and operation in _JUMPS:
            return True
        moved |= dict.fromkeys(function.instruction_output(k), is_moved)
    return False


def uses(function: ca.Function, operations: frozenset[int]) -> bool:
    """Whether one of CasADi's operations is among a function's instructions."""
    return not operations.isdisjoint(function.instruction_id(k) for k in range(function.n_instructions()))


_BENDING = frozenset({"abs", "fmin", "fmax", "sign", "choice"})  # of what an algebra is asked for
_ARMS = frozenset({ca.OP_FABS, ca.OP_FMIN, ca.OP_FMAX, ca.OP_SIGN}) | RELATIONS.keys()
_JUMPS = frozenset({ca.OP_LT, ca.OP_LE, ca.OP_EQ, ca.OP_NE, ca.OP_SIGN, ca.OP_FLOOR, ca.OP_CEIL})
_SX_FUNCTIONS: Mapping[str, Callable[..., Any]] = {
    **{name: partial(apply_to_one, getattr(ca, f"OP_{name.upper()}")) for name in (
        "sin", "cos", "tan", "asin", "acos", "atan", "sinh", "cosh", "tanh", "asinh", "acosh", "atanh", "exp", "log", "sqrt",
        "floor", "ceil", "sign")},
    **{name: partial(apply, getattr(ca, f"OP_{name.upper()}")) for name in ("fmin", "fmax", "atan2")},
    "abs": partial(apply_to_one, ca.OP_FABS), "log10": lambda x: as_expression(ca.log10(x)),
    "pow": lambda a, b: as_expression(a**b),
}
_COMPARE: Mapping[str, Callable[[Any, Any], Any]] = {
    "<": lambda a, b: a < b, "<=": lambda a, b: a <= b, ">": lambda a, b: a > b, ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b, "<>": lambda a, b: a != b,
}
_FLOAT_FUNCTIONS: Mapping[str, Callable[..., float]] = {
    "abs": abs, "fmin": min, "fmax": max, "sign": lambda x: math.copysign(1.0, x) if x else 0.0,
    "floor": lambda x: float(math.floor(x)), "ceil": lambda x: float(math.ceil(x)),
    "pow": math.pow,
}


def _call_float(function: str, *arguments: float) -> float:
    """Raises ValueError or ArithmeticError outside the function's domain."""
    chosen = _FLOAT_FUNCTIONS.get(function) or getattr(math, function)
    return float(chosen(*arguments))
