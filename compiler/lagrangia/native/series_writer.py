"""Instructions of a tape, one after another -> recurrences of Taylor coefficients, as series.py tells of them."""

from collections.abc import Mapping, Sequence
from dataclasses import field
from math import prod

from lagrangia.base.records import dataclass
from lagrangia.native.tapes import BINARY, EXPONENTIALS, JetOp, Op, Tape

TIME, POSITIONS, RATES, INPUTS, MODES = 0, 1, 2, 3, 4  # arguments of rhs; all but the last are jets
_MOST_POWER = 8  # integer powers up to this one are products
MOST_OPERANDS = 6
_SUMS = (Op.ADD, Op.SUB, Op.NEG, Op.TWICE)
# What the operands of each are: the present coefficient of a jet, all of it ("J"), a number, an operation of tapes, a count.
OPERANDS: Mapping[JetOp, str] = {
    JetOp.NUMBER: "n", JetOp.DERIVATIVE: "j", JetOp.NEG: "j", JetOp.TWICE: "j", JetOp.ADD: "jj", JetOp.SUB: "jj",
    JetOp.ADD_NUMBER: "jn", JetOp.SUB_NUMBER: "jn", JetOp.NUMBER_SUB: "nj", JetOp.SCALE: "nj", JetOp.OVER_NUMBER: "jn",
    JetOp.IF: "nj", JetOp.PRODUCT: "JJ", JetOp.SQUARE: "J", JetOp.QUOTIENT: "jJ", JetOp.NUMBER_OVER: "nJ", JetOp.SQRT: "j",
    JetOp.POWER: "Jn", JetOp.INTEGRAL: "jJJo", JetOp.MINUS_INTEGRAL: "jJJo", JetOp.SINE: "jJJc", JetOp.COSINE: "jJJc",
    JetOp.ANGLE: "jjJJJJ", JetOp.PRODUCT_AND: "JJj", JetOp.PRODUCT_FROM: "JJj", JetOp.FIRST_AND: "Jjj", JetOp.OVER_REST: "jJnn",
    JetOp.LOWER: "JJ", JetOp.SCALE_AND: "njj", JetOp.SCALE_FROM: "njj", JetOp.SCALE_LESS: "njj",
}


class NoSeriesError(Exception):
    """Why the motion has no Taylor series, or none that is worth its compilation."""


@dataclass(frozen=True)
class Jet:
    """A quantity that changes within a step."""

    slot: int


@dataclass(frozen=True)
class Number:
    """One that does not: its place among those of a Series."""

    place: int


Value = Jet | Number


@dataclass(frozen=True)
class Instruction:
    """`out` is the slot of the jet that is computed; operands are as OPERANDS says: slots, places of numbers, or counts."""

    op: JetOp
    out: int
    operands: tuple[int, ...]


@dataclass
class Writer:
    """What was written of a tape so far; values by the places of the tape."""

    tape: Tape
    values: dict[int, Value] = field(default_factory=dict)
    numbers: list[tuple[int, float, int]] = field(default_factory=list)
    named: dict[tuple[int, str, int], Number] = field(default_factory=dict)
    instructions: list[Instruction] = field(default_factory=list)
    n_jets: int = 0
    pairs: dict[tuple[Op, int], tuple[Jet, Jet]] = field(default_factory=dict)
    derivatives: dict[int, Jet] = field(default_factory=dict)
    n_angles: int = 0  # coordinates whose sines and cosines are computed together
    even: set[int] = field(default_factory=lambda: {0})  # jets that grow evenly with time
    may_hide: bool = False

    # ------------------------------------------------------------ pieces

    def jet(self, op: JetOp, *operands: Value | int) -> Jet:
        """A new jet."""
        jet = Jet(self.n_jets)
        self.n_jets += 1
        plain = (x.slot if isinstance(x, Jet) else x.place if isinstance(x, Number) else x for x in operands)
        self.instructions.append(Instruction(op, jet.slot, tuple(plain)))
        return jet

    def number(self, op: int, a: float, b: int = 0) -> Number:
        """An operation on numbers, once each."""
        key = (op, repr(a), b)
        if key not in self.named:
            self.named[key] = Number(len(self.numbers))
            self.numbers.append((op, a, b))
        return self.named[key]

    def literal(self, value: float) -> Number:
        """A number that is known now."""
        return self.number(Op.CONST, value)

    def multiplied(self, places: Sequence[int]) -> int:
        """The product of numbers, by their places; those that are known are multiplied now."""
        known = [self.numbers[place][1] for place in places if self.numbers[place][0] == Op.CONST]
        found = [place for place in places if self.numbers[place][0] != Op.CONST]
        if known and (not found or prod(known) != 1):
            found.append(self.literal(prod(known)).place)
        total = Number(found[0])
        for place in found[1:]:
            total = self.number(Op.MUL, total.place, place)
        return total.place

    def derivative(self, u: Jet) -> Jet:
        """k u_k, which the recurrences of elementary functions ask for."""
        if u.slot not in self.derivatives:
            self.derivatives[u.slot] = self.jet(JetOp.DERIVATIVE, u)
        return self.derivatives[u.slot]

    def product(self, a: Value, b: Value) -> Value:
        """a b."""
        if isinstance(a, Jet) and isinstance(b, Jet):
            return self.jet(JetOp.SQUARE, a) if a == b else self.jet(JetOp.PRODUCT, a, b)
        if isinstance(a, Number) and isinstance(b, Number):
            return self.number(Op.MUL, a.place, b.place)
        return self.jet(JetOp.SCALE, a, b) if isinstance(a, Number) else self.jet(JetOp.SCALE, b, a)

    def quotient(self, a: Value, b: Jet) -> Jet:
        """a/b."""
        return self.jet(JetOp.QUOTIENT if isinstance(a, Jet) else JetOp.NUMBER_OVER, a, b)

    def circular(self, u: Jet, sine: Op, cosine: Op) -> tuple[Jet, Jet]:
        """sin and cos, or sinh and cosh, of one argument: s' = c u', c' = -s u' or s u'."""
        if (sine, u.slot) not in self.pairs:
            du, s, c = self.derivative(u), Jet(self.n_jets), Jet(self.n_jets + 1)
            if sine is Op.SIN and u.slot < self.n_jets - len(self.instructions):
                self.jet(JetOp.SINE, u, du, c, self.n_angles)
                self.jet(JetOp.COSINE, u, du, s, self.n_angles)
                self.n_angles += 1
            else:
                self.jet(JetOp.INTEGRAL, u, du, c, sine)
                self.jet(JetOp.MINUS_INTEGRAL if sine is Op.SIN else JetOp.INTEGRAL, u, du, s, cosine)
            self.pairs[(sine, u.slot)] = s, c
        return self.pairs[(sine, u.slot)]

    def integral(self, function: Op, slope: Jet, u: Jet) -> Jet:
        """w with w' = slope u', w_0 the function of u_0."""
        du = self.derivative(u)
        return self.jet(JetOp.INTEGRAL, u, du, slope, function)

    # ------------------------------------------------------------ operations

    def unary(self, op: int, a: Jet) -> Value:
        """An operation of tapes on a jet."""
        if op in (Op.NEG, Op.TWICE):
            return self.jet(JetOp.NEG if op == Op.NEG else JetOp.TWICE, a)
        if op == Op.SQ:
            return self.product(a, a)
        if op == Op.INV:
            return self.quotient(self.literal(1.0), a)
        if op == Op.SQRT:
            return self.jet(JetOp.SQRT, a)
        if op in (Op.SIN, Op.COS):
            return self.circular(a, Op.SIN, Op.COS)[op == Op.COS]
        if op in (Op.SINH, Op.COSH):
            return self.circular(a, Op.SINH, Op.COSH)[op == Op.COSH]
        if op == Op.EXP:
            du = self.derivative(a)
            return self.jet(JetOp.INTEGRAL, a, du, Jet(self.n_jets), Op.EXP)
        if op == Op.LOG:
            return self.integral(Op.LOG, self.quotient(self.literal(1.0), a), a)
        return self.inverse_function(op, a)

    def inverse_function(self, op: int, a: Jet) -> Value:
        """Functions whose slope is a simpler one."""
        if op == Op.TAN:
            sine, cosine = self.circular(a, Op.SIN, Op.COS)
            return self.quotient(sine, cosine)
        if op == Op.TANH:
            return self.hyperbolic_tangent(a)
        square = self.product(a, a)
        assert isinstance(square, Jet)
        one = self.literal(1.0)
        if op == Op.ATAN:
            return self.integral(Op.ATAN, self.quotient(one, self.jet(JetOp.ADD_NUMBER, square, one)), a)
        if op in (Op.ASIN, Op.ACOS):
            root = self.jet(JetOp.SQRT, self.jet(JetOp.NUMBER_SUB, one, square))
            return self.integral(Op(op), self.quotient(one if op == Op.ASIN else self.literal(-1.0), root), a)
        raise NoSeriesError(f"'{Op(op).name.lower()}' stands in its equations, which has no Taylor series")

    def hyperbolic_tangent(self, u: Jet) -> Jet:
        """w' = (1 - w^2) u': no sinh and cosh, which would be infinite where w is 1."""
        du = self.derivative(u)
        w = self.jet(JetOp.INTEGRAL, u, du, Jet(self.n_jets + 2), Op.TANH)
        square = self.product(w, w)
        self.jet(JetOp.NUMBER_SUB, self.literal(1.0), square)
        return w

    def binary(self, op: int, a: Value, b: Value) -> Value:
        """An operation of tapes on two values, of which one is a jet."""
        if op in (Op.ADD, Op.SUB):
            return self.sum(op, a, b)
        if op == Op.MUL:
            return self.product(a, b)
        if op == Op.DIV:
            return self.quotient(a, b) if isinstance(b, Jet) else self.jet(JetOp.OVER_NUMBER, a, b)
        if op in (Op.POW, Op.CONSTPOW) and isinstance(a, Jet) and isinstance(b, Number):
            return self.power(a, b)
        if op == Op.ATAN2 and isinstance(a, Jet) and isinstance(b, Jet):
            return self.angle(a, b)
        if op == Op.IF_ELSE_ZERO and isinstance(a, Number) and isinstance(b, Jet):
            return self.jet(JetOp.IF, a, b)
        raise NoSeriesError(f"'{Op(op).name.lower()}' stands in its equations, which has no Taylor series")

    def sum(self, op: int, a: Value, b: Value) -> Value:
        """a + b, or a - b."""
        if isinstance(a, Jet) and isinstance(b, Jet):
            return self.jet(JetOp.ADD if op == Op.ADD else JetOp.SUB, a, b)
        if op == Op.SUB:
            return self.jet(JetOp.SUB_NUMBER if isinstance(a, Jet) else JetOp.NUMBER_SUB, a, b)
        return self.jet(JetOp.ADD_NUMBER, *((a, b) if isinstance(a, Jet) else (b, a)))

    def power(self, a: Jet, exponent: Number) -> Value:
        """A small whole power is a product: its recurrence would divide by the base."""
        op, known, _ = self.numbers[exponent.place]
        if op == Op.CONST and float(known).is_integer() and 2 <= known <= _MOST_POWER:
            value: Value = a
            for _ in range(int(known) - 1):
                value = self.product(value, a)
            return value
        return self.jet(JetOp.POWER, a, exponent)

    def angle(self, a: Jet, b: Jet) -> Jet:
        """atan2(a, b): w' = (b a' - a b')/(a^2 + b^2)."""
        aa, bb = self.product(a, a), self.product(b, b)
        radius = self.binary(Op.ADD, aa, bb)
        assert isinstance(radius, Jet)
        x, y = self.quotient(b, radius), self.quotient(a, radius)
        da, db = self.derivative(a), self.derivative(b)
        return self.jet(JetOp.ANGLE, a, b, da, db, x, y)

    # ------------------------------------------------------------ the tape

    def read(self, argument: int, element: int) -> Value:
        """An element of an argument of the tape."""
        if argument not in (TIME, POSITIONS, RATES, INPUTS):
            return self.number(Op.INPUT, argument - MODES, element)
        return Jet(sum(self.tape.in_sizes[:argument]) + element)

    def step(self, op: int, out: int, a: int, b: int) -> None:
        """An instruction of the tape."""
        if op == Op.INPUT:
            self.values[out] = self.read(a, b)
        elif op == Op.CONST:
            self.values[out] = self.literal(self.tape.constants[a])
        elif op == Op.ASSIGN:
            self.values[out] = self.values[a]
        else:
            self.values[out] = self.compute(op, self.values[a], self.values[b] if op in BINARY else None)

    def compute(self, op: int, a: Value, b: Value | None) -> Value:
        """An operation of tapes on any values."""
        if isinstance(a, Number) and not isinstance(b, Jet):
            return self.number(op, a.place, b.place if b is not None else 0)
        jets = [x for x in (a, b) if isinstance(x, Jet)]
        is_even = all(jet.slot in self.even for jet in jets)
        self.may_hide |= op in EXPONENTIALS and not is_even
        found = self.binary(op, a, b) if b is not None else self.unary(op, jets[0])
        scales = op == Op.MUL or (op == Op.DIV and isinstance(b, Number))
        if isinstance(found, Jet) and is_even and (op in _SUMS or (scales and len(jets) == 1)):
            self.even.add(found.slot)
        return found
