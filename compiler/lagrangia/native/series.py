"""The tape of the right-hand side -> the recurrences of the Taylor coefficients of the motion, as instructions.

Every quantity that changes in time is a jet: its coefficients w_0, w_1, ... in powers of the time since the step began. Each
operation has a recurrence for the next coefficient (A. Jorba, M. Zou, Exp. Math. 14 (2005); E. Hairer et al., Solving Ordinary
Differential Equations I, I.8), in runtime/numbers/jets.h. What is constant in a step is a plain number, computed by a tape.

runtime/model/jet_tape.h runs the instructions, series_code.py writes them as C; both do the same operations in the same order.
"""

from array import array
from collections.abc import Mapping, Sequence
from dataclasses import field

from lagrangia.base.records import dataclass
from lagrangia.native.tapes import BINARY, EXPONENTIALS, JetOp, Op, Tape

LONG = 8  # coordinates from which on loops over all of them pay
ORDERS = 18  # LAG_JET_ORDER of runtime/numbers/jets.h
_MOST_POWER = 8  # integer powers up to this one are products
_FEW, _UNROLLED = 20, 12  # products up to which each order has a function of its own in C; the orders that have one otherwise
# Statements in one order, and what a product adds over all orders; more than so many take longer to compile than they save.
_PRODUCT, _MOST_STATEMENTS = 150, 4000
MOST_OPERANDS = 6
_TIME, _POSITIONS, RATES, _INPUTS = 0, 1, 2, 3  # arguments of rhs that are jets


# What the operands of each are: the present coefficient of a jet, all of it ("J"), a number, an operation of tapes, a count.
OPERANDS: Mapping[JetOp, str] = {
    JetOp.NUMBER: "n", JetOp.DERIVATIVE: "j", JetOp.NEG: "j", JetOp.TWICE: "j", JetOp.ADD: "jj", JetOp.SUB: "jj",
    JetOp.ADD_NUMBER: "jn", JetOp.SUB_NUMBER: "jn", JetOp.NUMBER_SUB: "nj", JetOp.SCALE: "nj", JetOp.OVER_NUMBER: "jn",
    JetOp.IF: "nj", JetOp.PRODUCT: "JJ", JetOp.SQUARE: "J", JetOp.QUOTIENT: "jJ", JetOp.NUMBER_OVER: "nJ", JetOp.SQRT: "j",
    JetOp.POWER: "Jn", JetOp.INTEGRAL: "jJJo", JetOp.MINUS_INTEGRAL: "jJJo", JetOp.SINE: "jJJc", JetOp.COSINE: "jJJc",
    JetOp.ANGLE: "jjJJJJ",
}
_RECURSIVE = frozenset((JetOp.QUOTIENT, JetOp.NUMBER_OVER, JetOp.SQRT, JetOp.POWER))  # these ask for all of their own jet
_PRODUCTS = frozenset(op for op in JetOp if op >= JetOp.PRODUCT)
_SUMS = (Op.ADD, Op.SUB, Op.NEG, Op.TWICE)


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


_Value = Jet | Number


@dataclass(frozen=True)
class Instruction:
    """`out` is the slot of the jet that is computed; operands are as OPERANDS says: slots, places of numbers, or counts."""

    op: JetOp
    out: int
    operands: tuple[int, ...]


@dataclass(frozen=True)
class Series:
    """The first `known` jets are t, q, v and u. `kept` is the place in memory of each jet whose lower orders are asked for again;
    `pitch` is the distance between the coefficients of a jet. `accelerations` and `powers` are slots. `n_products` are sums of
    products, which grow with the order. Accelerations of a long state without products are not kept: the jets of v tell them.
    `numbers` are instructions of a tape: operation and operands, which are places of others; a constant has its value.
    `may_hide`: exponentials of what moves stand in the equations, which can be so faint that no coefficient tells of them, and
    large within a step: exp(-(s/w)^2), or tanh(s/w), which is constant but near 0."""

    instructions: tuple[Instruction, ...]
    numbers: tuple[tuple[int, float, int], ...]
    known: int
    accelerations: tuple[int, ...]
    powers: tuple[int, ...]
    kept: Mapping[int, int]
    pitch: int
    n_products: int
    n_angles: int
    is_long_state: bool
    may_hide: bool

    @property
    def places(self) -> tuple[int, ...]:
        """The jets, by their places, of accelerations that are kept, then of powers."""
        asked = self.powers if self.is_long_state else (*self.accelerations, *self.powers)
        return tuple(self.kept[slot] for slot in asked)

    @property
    def sizes(self) -> dict[str, int]:
        """Integers of LagModel."""
        return {"n_jets": len(self.kept), "jet_pitch": self.pitch, "n_products": self.n_products,
                "is_long_state": int(self.is_long_state), "series_may_hide": int(self.may_hide)}

    def as_tape(self, in_sizes: Sequence[int]) -> "tuple[dict[str, int], dict[str, tuple[int, ...]], Tape]":
        """What runs without a compiler: more integers of LagModel, lists of it, and the function of d and c, whose sizes are
        given, that computes the numbers."""
        slots = dict(self.kept)
        for instruction in self.instructions:
            slots.setdefault(instruction.out, len(slots))
        code: list[int] = []
        for i in self.instructions:
            shown = [slots[x] if kind in "jJ" else x for kind, x in zip(OPERANDS[i.op], i.operands, strict=True)]
            code += [i.op, slots[i.out], *shown, *[0] * (MOST_OPERANDS - len(shown))]
        sizes = {"n_jet_instructions": len(self.instructions), "n_jet_slots": len(slots), "n_angles": self.n_angles}
        lists = {"jet_code": tuple(code), "jet_rates": tuple(slots[slot] for slot in self.accelerations)}
        return sizes, lists, _tape_of(self.numbers, in_sizes)


def _tape_of(numbers: Sequence[tuple[int, float, int]], in_sizes: Sequence[int]) -> Tape:
    code, constants = array("i"), array("d")
    for place, (op, a, b) in enumerate(numbers):
        if op == Op.CONST:
            code.extend((op, place, len(constants), 0))
            constants.append(a)
        else:
            code.extend((op, place, int(a), b))
        code.extend((Op.OUTPUT, 0, place, place))
    return Tape(list(in_sizes), [len(numbers)], len(numbers), code, constants)


@dataclass
class _Writer:
    tape: Tape
    values: dict[int, _Value] = field(default_factory=dict)
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

    def jet(self, op: JetOp, *operands: _Value | int) -> Jet:
        """A new jet."""
        jet = Jet(self.n_jets)
        self.n_jets += 1
        plain = (x.slot if isinstance(x, Jet) else x.place if isinstance(x, Number) else x for x in operands)
        self.instructions.append(Instruction(op, jet.slot, tuple(plain)))
        return jet

    def number(self, op: int, a: float, b: int = 0) -> Number:
        key = (op, repr(a), b)
        if key not in self.named:
            self.named[key] = Number(len(self.numbers))
            self.numbers.append((op, a, b))
        return self.named[key]

    def literal(self, value: float) -> Number:
        return self.number(Op.CONST, value)

    def derivative(self, u: Jet) -> Jet:
        """k u_k, which the recurrences of elementary functions ask for."""
        if u.slot not in self.derivatives:
            self.derivatives[u.slot] = self.jet(JetOp.DERIVATIVE, u)
        return self.derivatives[u.slot]

    def product(self, a: _Value, b: _Value) -> _Value:
        if isinstance(a, Jet) and isinstance(b, Jet):
            return self.jet(JetOp.SQUARE, a) if a == b else self.jet(JetOp.PRODUCT, a, b)
        if isinstance(a, Number) and isinstance(b, Number):
            return self.number(Op.MUL, a.place, b.place)
        return self.jet(JetOp.SCALE, a, b) if isinstance(a, Number) else self.jet(JetOp.SCALE, b, a)

    def quotient(self, a: _Value, b: Jet) -> Jet:
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

    def unary(self, op: int, a: Jet) -> _Value:
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

    def inverse_function(self, op: int, a: Jet) -> _Value:
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

    def binary(self, op: int, a: _Value, b: _Value) -> _Value:
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

    def sum(self, op: int, a: _Value, b: _Value) -> _Value:
        if isinstance(a, Jet) and isinstance(b, Jet):
            return self.jet(JetOp.ADD if op == Op.ADD else JetOp.SUB, a, b)
        if op == Op.SUB:
            return self.jet(JetOp.SUB_NUMBER if isinstance(a, Jet) else JetOp.NUMBER_SUB, a, b)
        return self.jet(JetOp.ADD_NUMBER, *((a, b) if isinstance(a, Jet) else (b, a)))

    def power(self, a: Jet, exponent: Number) -> _Value:
        """A small whole power is a product: its recurrence would divide by the base."""
        op, known, _ = self.numbers[exponent.place]
        if op == Op.CONST and float(known).is_integer() and 2 <= known <= _MOST_POWER:
            value: _Value = a
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

    def read(self, argument: int, element: int) -> _Value:
        if argument not in (_TIME, _POSITIONS, RATES, _INPUTS):
            return self.number(Op.INPUT, argument - _INPUTS - 1, element)
        return Jet(sum(self.tape.in_sizes[:argument]) + element)

    def step(self, op: int, out: int, a: int, b: int) -> None:
        if op == Op.INPUT:
            self.values[out] = self.read(a, b)
        elif op == Op.CONST:
            self.values[out] = self.literal(self.tape.constants[a])
        elif op == Op.ASSIGN:
            self.values[out] = self.values[a]
        else:
            self.values[out] = self.compute(op, self.values[a], self.values[b] if op in BINARY else None)

    def compute(self, op: int, a: _Value, b: _Value | None) -> _Value:
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


def find_series(tape: Tape) -> Series:
    """Of the motion by the tape of rhs: t, q, v, u, d, c -> a, power, lambda. Raises NoSeriesError."""
    known = sum(tape.in_sizes[: _INPUTS + 1])
    writer = _Writer(tape, n_jets=known)
    wanted = _wanted(tape)
    places: dict[tuple[int, int], int] = {}
    for k in range(0, len(tape.code), 4):
        op, out, a, b = tape.code[k : k + 4]
        if k not in wanted:
            continue
        if op != Op.OUTPUT:
            writer.step(op, out, a, b)
            continue
        value = writer.values[a]
        places[(out, b)] = (value if isinstance(value, Jet) else writer.jet(JetOp.NUMBER, value)).slot
    instructions = tuple(map(_alone, writer.instructions) if writer.n_angles == 1 else writer.instructions)
    products = sum(i.op in _PRODUCTS for i in instructions)
    if orders_apart(products, len(instructions)) == 0:
        raise NoSeriesError(f"its {products} products of series would take longer to compile than they save")
    n, found = tape.in_sizes[_POSITIONS], [places[key] for key in sorted(places)]
    is_long = products == 0 and n >= LONG
    kept = _kept(instructions, known, found[n:] if is_long else found)
    pitch = 1 if products else -(-len(kept) // 4) * 4
    return Series(instructions, tuple(writer.numbers), known, tuple(found[:n]), tuple(found[n:]), kept, pitch, products,
                  writer.n_angles if writer.n_angles > 1 else 0, is_long, writer.may_hide)


def orders_apart(products: int, statements: int) -> int:
    """How many orders have a function of their own in C; 0: there are too many products."""
    for orders in (ORDERS if products <= _FEW else _UNROLLED, _UNROLLED):
        if _written_out(products, statements, orders) <= _MOST_STATEMENTS:
            return orders
    return 1 if products == 0 else 0


def statements_in_all(products: int, statements: int) -> int:
    """What a C compiler has to do for all orders."""
    return _written_out(products, statements, orders_apart(products, statements)) if statements else 0


def _written_out(products: int, statements: int, orders: int) -> int:
    return products * _PRODUCT + statements * (orders + 1)


def _alone(i: Instruction) -> Instruction:
    """Four sines take as long as one of a mathematical library, one alone takes longer."""
    if i.op not in (JetOp.SINE, JetOp.COSINE):
        return i
    op, function = (JetOp.INTEGRAL, Op.SIN) if i.op is JetOp.SINE else (JetOp.MINUS_INTEGRAL, Op.COS)
    return Instruction(op, i.out, (*i.operands[:3], function))


def _kept(instructions: Sequence[Instruction], known: int, places: Sequence[int]) -> dict[int, int]:
    """The place in memory of each jet whose lower orders are asked for again; the others pass by."""
    again = {x for i in instructions for kind, x in zip(OPERANDS[i.op], i.operands, strict=True) if kind == "J"}
    again |= {i.out for i in instructions if i.op in _RECURSIVE}
    return {slot: k for k, slot in enumerate(sorted({*range(known), *places, *again}))}


def _wanted(tape: Tape) -> set[int]:
    """Instructions that accelerations and powers depend on; multipliers are left out."""
    needed: set[int] = set()
    wanted: set[int] = set()
    for k in range(len(tape.code) - 4, -1, -4):
        op, out, a, b = tape.code[k : k + 4]
        if op == Op.OUTPUT:
            if out < 2:
                wanted.add(k)
                needed.add(a)
        elif out in needed:
            wanted.add(k)
            needed.discard(out)
            if op not in (Op.INPUT, Op.CONST):
                needed.update((a, b) if op in BINARY else (a,))
    return wanted
