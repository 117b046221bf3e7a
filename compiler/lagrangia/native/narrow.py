"""Whether forces may turn within so narrow a range that a wide step has no stage in it."""

from lagrangia.native.series_writer import RATES
from lagrangia.native.tapes import BINARY, EXPONENTIALS, Op, Tape

_NARROW = frozenset(map(int, (Op.DIV, Op.INV, Op.SQRT, Op.ATAN, Op.ATAN2, Op.LOG, Op.POW, Op.CONSTPOW, Op.ASINH, Op.ERF)))


def may_hide(tape: Tape) -> bool:
    """Whether it has exponentials of what changes."""
    return not set(tape.code[::4]).isdisjoint(EXPONENTIALS)


def may_be_narrow(tape: Tape) -> bool:
    """Whether it has those, or functions of rates that turn within a narrow range of them: v/sqrt(v^2 + w^2), atan(v/w), of
    accelerations by t, q, v, ... Inertial forces have none, as they are quadratic in rates."""
    if may_hide(tape):
        return True
    code, depends = tape.code, set[int]()
    for k in range(0, len(code), 4):
        op, out, a, b = code[k : k + 4]
        if op == Op.OUTPUT:
            continue
        operands = {a, b} if op in BINARY else {a} if op not in (Op.CONST, Op.INPUT) else set[int]()
        if op in _NARROW and not depends.isdisjoint({b} if op == Op.DIV else operands):
            return True
        if a == RATES if op == Op.INPUT else not depends.isdisjoint(operands):
            depends.add(out)
        else:
            depends.discard(out)
    return False
