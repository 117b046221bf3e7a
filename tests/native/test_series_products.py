"""Recurrences with fewer products of series give what they gave."""

import operator
import random
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.native.series import find_series
from lagrangia.native.series_products import (
    in_factors,
    in_squares,
    late_last,
    with_numbers_inside,
    with_numbers_outside,
    without_quotients,
)
from lagrangia.native.series_writer import OPERANDS, Instruction, Writer
from lagrangia.native.tapes import JetOp, Tape

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
KNOWN = 4
VALUES: Mapping[JetOp, Callable[..., float]] = {
    JetOp.NEG: operator.neg, JetOp.TWICE: lambda a: 2 * a, JetOp.ADD: operator.add, JetOp.SUB: operator.sub,
    JetOp.SCALE: operator.mul, JetOp.PRODUCT: operator.mul, JetOp.SQUARE: lambda a: a * a,
    JetOp.PRODUCT_AND: lambda a, b, c: a * b + c, JetOp.PRODUCT_FROM: lambda a, b, c: c - a * b}
DRAWN = (*2 * (JetOp.NEG, JetOp.TWICE, JetOp.SCALE), *4 * (JetOp.ADD, JetOp.SUB), *5 * (JetOp.PRODUCT,))


def empty() -> Writer:
    return Writer(Tape([1], [1], 0, [], []), n_jets=KNOWN)


def rewritten(writer: Writer, found: Sequence[int]) -> list[Instruction]:
    shared = in_factors(writer, in_squares(writer.instructions, found), found)
    inside = with_numbers_inside(writer, shared, found)
    return late_last(with_numbers_outside(writer, inside, found), found, frozenset({0, 1}))


def values(writer: Writer, instructions: Sequence[Instruction], found: Sequence[int]) -> list[float]:
    """Of jets, as plain numbers, each made before it is asked for."""
    known = {k: 0.7 + 0.31 * k for k in range(KNOWN)}
    for i in instructions:
        operands = [writer.numbers[x][1] if kind == "n" else known[x] for kind, x in zip(OPERANDS[i.op], i.operands, strict=True)]
        known[i.out] = VALUES[i.op](*operands)
    return [known[slot] for slot in found]


def products(instructions: Sequence[Instruction]) -> int:
    return sum(i.op >= JetOp.PRODUCT for i in instructions)


@pytest.mark.parametrize("seed", range(60))
def test_what_is_asked_for_stays(seed: int) -> None:
    draw, writer = random.Random(seed), empty()
    for _ in range(30):
        op = draw.choice(DRAWN)
        slots = [draw.randrange(max(0, writer.n_jets - 9), writer.n_jets) for kind in OPERANDS[op] if kind != "n"]
        if op is JetOp.PRODUCT and slots[0] == slots[1]:
            continue
        numbers = [writer.literal(draw.choice((-1.5, 0.5, 2.0, 3.0))).place] if op is JetOp.SCALE else []
        writer.jet(op, *numbers, *slots)
    found = [writer.n_jets - 1, writer.n_jets - 3]
    before = list(writer.instructions)
    after = rewritten(writer, found)
    assert products(after) <= products(before)
    assert values(writer, after, found) == pytest.approx(values(writer, before, found), rel=1e-9)


def test_common_factors_are_taken_out() -> None:
    """2 a b - a (3 c) is a (2 b - 3 c)."""
    writer = empty()
    three = writer.literal(3.0).place
    b, c = writer.jet(JetOp.PRODUCT, 0, 1), writer.jet(JetOp.SCALE, three, 2)
    found = writer.jet(JetOp.SUB, writer.jet(JetOp.TWICE, b), writer.jet(JetOp.PRODUCT, 0, c))
    after = rewritten(writer, [found.slot])
    assert [i.op for i in after if i.op >= JetOp.PRODUCT] == [JetOp.PRODUCT]


@pytest.mark.parametrize(("scene", "sums"), [("double_pendulum", 10), ("cart_pole", 7)])
def test_what_elimination_leaves_has_no_quotient(scene: str, sums: int) -> None:
    """n w = e + c (a + m c w) in place of w = (e + a c)/(n - m c^2): 12 and 9 sums with the quotient, 14 and 9 before."""
    instructions = find_series(lag.load(EXAMPLES / f"{scene}.lag").scene.tapes["rhs"]).instructions
    assert JetOp.QUOTIENT not in [i.op for i in instructions]
    assert products(instructions) == sums


CASES = {"e + c a": (True, True), "e, and c w is asked for": (False, True), "c a alone": (True, False)}


@pytest.mark.parametrize("case", CASES)
def test_coupled_recurrences_give_the_quotient(case: str) -> None:
    """Coefficients of w = (e + c a)/(3 - 2 c^2) and of -1.5 c w to order 9, by both."""
    has_own, has_rest = CASES[case]
    writer = Writer(Tape([1], [1], 0, [], []), n_jets=KNOWN)
    two, three, less = (writer.literal(value).place for value in (2.0, 3.0, -1.5))
    square = writer.jet(JetOp.SCALE, two, writer.jet(JetOp.SQUARE, 0))
    product = writer.jet(JetOp.PRODUCT, 1, 0) if has_own else None
    top = product if not has_rest else writer.jet(JetOp.SUB, 2, product) if product else writer.jet(JetOp.NEG, 2)
    w = writer.jet(JetOp.QUOTIENT, top, writer.jet(JetOp.NUMBER_SUB, three, square))
    again = writer.jet(JetOp.PRODUCT, w, writer.jet(JetOp.SCALE, less, 0))
    found = [w.slot, again.slot]
    after = without_quotients(writer, writer.instructions, found)
    assert JetOp.QUOTIENT not in [i.op for i in after] and again.slot in [i.out for i in after]
    assert coefficients(writer, after, found) == pytest.approx(coefficients(writer, writer.instructions, found), rel=1e-11)


def coefficients(writer: Writer, instructions: Sequence[Instruction], found: Sequence[int], orders: int = 10) -> list[float]:
    """Of jets, order by order; those that are known are 1/(2 + slot + k)."""
    jets = {slot: [1 / (2 + slot + k) for k in range(orders)] for slot in range(KNOWN)}
    jets |= {i.out: [0.0] * orders for i in instructions}
    number = [value for _, value, _ in writer.numbers]

    def total(a: int, b: int, first: int, k: int) -> float:
        return sum(jets[a][j] * jets[b][k - j] for j in range(first, k + 1))

    rules: Mapping[JetOp, Callable[..., float]] = {
        JetOp.NEG: lambda k, a: -jets[a][k], JetOp.ADD: lambda k, a, b: jets[a][k] + jets[b][k],
        JetOp.SUB: lambda k, a, b: jets[a][k] - jets[b][k], JetOp.SCALE: lambda k, n, a: number[n] * jets[a][k],
        JetOp.NUMBER_SUB: lambda k, n, a: (number[n] if k == 0 else 0) - jets[a][k], JetOp.SQUARE: lambda k, a: total(a, a, 0, k),
        JetOp.PRODUCT: lambda k, a, b: total(a, b, 0, k),
        JetOp.QUOTIENT: lambda k, a, b: (jets[a][k] - total(b, w_of[a, b], 1, k)) / jets[b][0],
        JetOp.LOWER: lambda k, a, b: total(a, b, 1, k), JetOp.FIRST_AND: lambda k, a, b, c: jets[a][0] * jets[b][k] + jets[c][k],
        JetOp.OVER_REST: lambda k, a, c, n, m: jets[a][k] / (number[n] - number[m] * jets[c][0] ** 2)}
    w_of = {i.operands: i.out for i in instructions if i.op is JetOp.QUOTIENT}
    for k in range(orders):
        for i in instructions:
            jets[i.out][k] = rules[i.op](k, *i.operands)
    return [x for slot in found for x in jets[slot]]
