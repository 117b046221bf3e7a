"""Whether forces may turn within so narrow a range that a wide step has no stage in it."""

from lagrangia.native.series_writer import RATES
from lagrangia.native.tapes import BINARY, EXPONENTIALS, Op, Tape

_NARROW = frozenset(map(int, (Op.DIV, Op.INV, Op.SQRT, Op.ATAN, Op.ATAN2, Op.LOG, Op.POW, Op.CONSTPOW, Op.ASINH, Op.ERF)))
_DIV, _INPUT, _OUTPUT, _CONST = map(int, (Op.DIV, Op.INPUT, Op.OUTPUT, Op.CONST))  # members are slow to compare
_LEAVES = (_INPUT, _CONST)


def may_hide(tape: Tape) -> bool:
    """Whether it has exponentials of what changes."""
    return not set(tape.code[::4]).isdisjoint(EXPONENTIALS)


def may_be_narrow(tape: Tape) -> bool:
    """Whether it has those, or functions of rates that turn within a narrow range of them: v/sqrt(v^2 + w^2), atan(v/w), of
    accelerations by t, q, v, ... Inertial forces have none, as they are quadratic in rates."""
    if may_hide(tape):
        return True
    code, depends = tape.code, bytearray(tape.n_work)
    for op, out, a, b in zip(*(code[k::4] for k in range(4)), strict=True):
        if op in BINARY:
            is_moved = depends[a] | depends[b]
            if op in _NARROW and (depends[b] if op == _DIV else is_moved):
                return True
        elif op in _LEAVES:
            is_moved = op == _INPUT and a == RATES
        elif op == _OUTPUT:
            continue
        else:
            is_moved = depends[a]
            if is_moved and op in _NARROW:
                return True
        depends[out] = is_moved
    return False
