"""The tape of the right-hand side -> the recurrences of the Taylor coefficients of the motion, as instructions.

Every quantity that changes in time is a jet: its coefficients w_0, w_1, ... in powers of the time since the step began. Each
operation has a recurrence for the next coefficient (A. Jorba, M. Zou, Exp. Math. 14 (2005); E. Hairer et al., Solving Ordinary
Differential Equations I, I.8), in runtime/numbers/jets.h. What is constant in a step is a plain number, computed by a tape.

runtime/model/jet_tape.h runs the instructions, series_code.py writes them as C; both do the same operations in the same order.
"""

from array import array
from collections.abc import Iterable, Mapping, Sequence

from lagrangia.base.records import dataclass
from lagrangia.native.series_products import (
    in_factors,
    in_squares,
    late_last,
    scaled_inside,
    with_numbers_inside,
    with_numbers_outside,
    without_quotients,
)
from lagrangia.native.series_writer import (
    INPUTS,
    MOST_OPERANDS,
    OPERANDS,
    POSITIONS,
    Instruction,
    Jet,
    NoSeriesError,
    Writer,
)
from lagrangia.native.tapes import BINARY, JetOp, Op, Tape
from lagrangia.native.turned_series import TurnedWriter

LONG = 8  # coordinates from which on loops over all of them pay
ORDERS = 18  # LAG_JET_ORDER of runtime/numbers/jets.h
_FEW, _UNROLLED = 20, 12  # products up to which each order has a function of its own in C; the orders that have one otherwise
# Statements in one order, and what a product adds over all orders; more than so many take longer to compile than they save.
_PRODUCT, _MOST_STATEMENTS = 150, 4000
_RECURSIVE = frozenset((JetOp.QUOTIENT, JetOp.NUMBER_OVER, JetOp.SQRT, JetOp.POWER))  # these ask for all of their own jet
_PRODUCTS = frozenset(op for op in JetOp if op >= JetOp.PRODUCT)


@dataclass(frozen=True)
class Series:
    """The first `known` jets are t, q, v and u. `kept` is the place in memory of each jet whose lower orders are asked for again;
    `pitch` is the distance between the coefficients of a jet. `accelerations` and `powers` are slots, and `attitudes` are the
    places of attitudes among the coordinates, whose quaternions are the last known jets. `n_products` are sums of products,
    which grow with the order, as they were before factors were shared, and `n_weighed` jets that are kept, as they were with
    quotients: choices weigh costs by both. Accelerations of a long state without products are not kept: the jets of v tell them.
    `numbers` are instructions of a tape: operation and operands, which are places of others; a constant has its value.
    `may_hide`: exponentials of what moves stand in the equations, which can be so faint that no coefficient tells of them, and
    large within a step: exp(-(s/w)^2), or tanh(s/w), which is constant but near 0."""

    instructions: tuple[Instruction, ...]
    numbers: tuple[tuple[int, float, int], ...]
    known: int
    accelerations: tuple[int, ...]
    powers: tuple[int, ...]
    attitudes: tuple[int, ...]
    kept: Mapping[int, int]
    pitch: int
    n_products: int
    n_weighed: int
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
                "n_weighed": self.n_weighed, "is_long_state": int(self.is_long_state), "series_may_hide": int(self.may_hide)}

    def as_tape(self, in_sizes: Sequence[int]) -> "tuple[dict[str, int], dict[str, tuple[int, ...]], Tape]":
        """What runs without a compiler: more integers of LagModel, lists of it, and the function of d and c, whose sizes are
        given, that computes the numbers."""
        slots, quads = dict(self.kept), 4 * len(self.attitudes)
        for instruction in self.instructions:
            slots.setdefault(instruction.out, len(slots) + quads)
        code: list[int] = []
        for i in self.instructions:
            shown = [slots[x] if kind in "jJ" else x for kind, x in zip(OPERANDS[i.op], i.operands, strict=True)]
            code += [i.op, slots[i.out], *shown, *[0] * (MOST_OPERANDS - len(shown))]
        sizes = {"n_jet_instructions": len(self.instructions), "n_jet_slots": len(slots) + quads, "n_angles": self.n_angles}
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


def find_series(tape: Tape, attitudes: Sequence[int] = ()) -> Series:
    """Of the motion by the tape of rhs: t, q, v, u, d, c -> a, power, lambda; `attitudes`: LagModel.attitudes. Raises
    NoSeriesError."""
    known = sum(tape.in_sizes[: INPUTS + 1])
    pairs = zip(attitudes[::2], attitudes[1::2], strict=True)
    turned = {place: (mode, known + 4 * k) for k, (place, mode) in enumerate(pairs)}
    known += 4 * len(turned)
    writer = TurnedWriter(tape, n_jets=known, attitudes=turned) if turned else Writer(tape, n_jets=known)
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
    n, found = tape.in_sizes[POSITIONS], [places[key] for key in sorted(places)]
    plain = _asked_for(in_squares(writer.instructions, found), found)
    shared = _asked_for(in_factors(writer, plain, found), found)
    early = frozenset(range(known)).difference(range(1 + n, 1 + 2 * n))
    inside = with_numbers_inside(writer, shared, found)
    coupled = _asked_for(without_quotients(writer, inside, found), found)
    outside = with_numbers_outside(writer, coupled, found)
    written = scaled_inside(late_last(outside, found, early), found)
    instructions = tuple(map(_alone, written) if writer.n_angles == 1 else written)
    products = sum(i.op in _PRODUCTS for i in plain)
    if not turned and orders_apart(products, len(instructions)) == 0:
        raise NoSeriesError(f"its {products} products of series would take longer to compile than they save")
    is_long = products == 0 and n >= LONG
    kept, weighed = (_kept(each, known, found[n:] if is_long else found) for each in (instructions, inside))
    pitch = 1 if products else -(-len(kept) // 4) * 4
    n_angles = writer.n_angles if writer.n_angles > 1 else 0
    return Series(instructions, tuple(writer.numbers), known, tuple(found[:n]), tuple(found[n:]), tuple(attitudes[::2]), kept,
                  pitch, products, len(weighed), n_angles, is_long, writer.may_hide)


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


def _asked_for(instructions: Sequence[Instruction], wanted: Iterable[int]) -> tuple[Instruction, ...]:
    """Those that slots depend on."""
    by_slot, asked, left = {i.out: i for i in instructions}, set[int](), list(wanted)
    while left:
        slot = left.pop()
        if slot in by_slot and slot not in asked:
            asked.add(slot)
            i = by_slot[slot]
            left += [x for kind, x in zip(OPERANDS[i.op], i.operands, strict=True) if kind in "jJ"]
    return tuple(i for i in instructions if i.out in asked)


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
