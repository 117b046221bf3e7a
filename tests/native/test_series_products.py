"""Recurrences with fewer products of series give what they gave."""

import operator
import random
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.native.series import find_series
from lagrangia.native.series_products import in_factors, in_squares, late_last, with_numbers_inside
from lagrangia.native.series_writer import OPERANDS, Instruction, Writer
from lagrangia.native.tapes import JetOp, Tape

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
KNOWN = 4
VALUES: Mapping[JetOp, Callable[..., float]] = {
    JetOp.NEG: operator.neg, JetOp.TWICE: lambda a: 2 * a, JetOp.ADD: operator.add, JetOp.SUB: operator.sub,
    JetOp.SCALE: operator.mul, JetOp.PRODUCT: operator.mul, JetOp.SQUARE: lambda a: a * a,
    JetOp.PRODUCT_AND: lambda a, b, c: a * b + c, JetOp.PRODUCT_FROM: lambda a, b, c: c - a * b}
DRAWN = (JetOp.NEG, JetOp.TWICE, JetOp.SCALE, *4 * (JetOp.ADD, JetOp.SUB), *5 * (JetOp.PRODUCT,))


def empty() -> Writer:
    return Writer(Tape([1], [1], 0, [], []), n_jets=KNOWN)


def rewritten(writer: Writer, found: Sequence[int]) -> list[Instruction]:
    shared = in_factors(writer, in_squares(writer.instructions, found), found)
    return late_last(with_numbers_inside(writer, shared, found), found, frozenset({0, 1}))


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


def test_a_double_pendulum_sums_twelve_products() -> None:
    """14 before factors were shared; three of both are squares."""
    assert products(find_series(lag.load(EXAMPLES / "double_pendulum.lag").scene.tapes["rhs"]).instructions) == 12
