"""Functions as instructions, as runtime/model/tape.h and jet_tape.h run them.

Only the standard library is used: what was compiled before is read without CasADi.
"""

from collections.abc import Collection, Sequence
from enum import IntEnum
from typing import Any

from lagrangia.base.records import dataclass


class Op(IntEnum):
    """LagOp of tape.h."""

    INPUT = 0
    OUTPUT = 1
    CONST = 2
    ASSIGN = 3
    ADD = 4
    SUB = 5
    MUL = 6
    DIV = 7
    NEG = 8
    SQ = 9
    TWICE = 10
    INV = 11
    SQRT = 12
    SIN = 13
    COS = 14
    TAN = 15
    ASIN = 16
    ACOS = 17
    ATAN = 18
    ATAN2 = 19
    EXP = 20
    LOG = 21
    POW = 22
    CONSTPOW = 23
    FABS = 24
    SIGN = 25
    FMIN = 26
    FMAX = 27
    FLOOR = 28
    CEIL = 29
    FMOD = 30
    COPYSIGN = 31
    LT = 32
    LE = 33
    EQ = 34
    NE = 35
    NOT = 36
    AND = 37
    OR = 38
    IF_ELSE_ZERO = 39
    SINH = 40
    COSH = 41
    TANH = 42
    ASINH = 43
    ACOSH = 44
    ATANH = 45
    ERF = 46


class JetOp(IntEnum):
    """LagJetOp of jet_tape.h."""

    NUMBER = 0
    DERIVATIVE = 1
    NEG = 2
    TWICE = 3
    ADD = 4
    SUB = 5
    ADD_NUMBER = 6
    SUB_NUMBER = 7
    NUMBER_SUB = 8
    SCALE = 9
    OVER_NUMBER = 10
    IF = 11
    FIRST_AND = 12
    OVER_REST = 13
    SCALE_AND = 14
    SCALE_FROM = 15
    SCALE_LESS = 16
    PRODUCT = 17
    SQUARE = 18
    QUOTIENT = 19
    NUMBER_OVER = 20
    SQRT = 21
    POWER = 22
    INTEGRAL = 23
    MINUS_INTEGRAL = 24
    SINE = 25
    COSINE = 26
    ANGLE = 27
    PRODUCT_AND = 28
    PRODUCT_FROM = 29
    LOWER = 30


# Too faint, perhaps, to tell of themselves where they are large a little later.
EXPONENTIALS = (int(Op.EXP), int(Op.SINH), int(Op.COSH), int(Op.TANH))
# Their b says how many that go together, this one among them, are still to come. Plain numbers: members are slow to compare.
SINES = (int(Op.SIN), int(Op.COS))
BINARY = frozenset(map(int, (
    Op.ADD, Op.SUB, Op.MUL, Op.DIV, Op.POW, Op.CONSTPOW, Op.ATAN2, Op.FMIN, Op.FMAX, Op.FMOD, Op.COPYSIGN, Op.LT, Op.LE, Op.EQ,
    Op.NE, Op.AND, Op.OR, Op.IF_ELSE_ZERO,
)))


@dataclass(frozen=True)
class Tape:
    """A function as instructions (op, out, a, b), flat in a buffer of int32; `constants` is a buffer of doubles."""

    in_sizes: Sequence[int]
    out_sizes: Sequence[int]
    n_work: int
    code: Any
    constants: Any

    def reached(self, places: Collection[tuple[int, int]]) -> set[tuple[int, int]]:
        """The results that numbers of its arguments enter; both by (which, place)."""
        found: set[tuple[int, int]] = set()
        marked: set[int] = set()
        for k in range(0, len(self.code), 4):
            op, out, a, b = self.code[k : k + 4]
            if op == Op.OUTPUT:
                if a in marked:
                    found.add((out, b))
                continue
            if op == Op.INPUT:
                enters = (a, b) in places
            else:
                enters = op != Op.CONST and (a in marked or (op in BINARY and b in marked))
            (marked.add if enters else marked.discard)(out)
        return found
