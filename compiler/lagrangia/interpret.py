"""Evaluates a tape in Python: for what is asked once a run, where neither CasADi nor the run time is at hand."""

import math
import operator
from collections.abc import Callable, Mapping, Sequence

from lagrangia.tapes import Op, Tape

_FUNCTIONS: Mapping[Op, Callable[..., float]] = {
    Op.ASSIGN: lambda a, b: a, Op.ADD: operator.add, Op.SUB: operator.sub, Op.MUL: operator.mul, Op.DIV: operator.truediv,
    Op.NEG: lambda a, b: -a, Op.SQ: lambda a, b: a * a, Op.TWICE: lambda a, b: 2 * a, Op.INV: lambda a, b: 1 / a,
    Op.POW: math.pow, Op.CONSTPOW: math.pow, Op.FABS: lambda a, b: abs(a), Op.FMOD: math.fmod, Op.COPYSIGN: math.copysign,
    Op.SIGN: lambda a, b: float((a > 0) - (a < 0)), Op.ATAN2: math.atan2,
    Op.FMIN: lambda a, b: b if math.isnan(a) or b < a else a, Op.FMAX: lambda a, b: b if math.isnan(a) or b > a else a,
    Op.FLOOR: lambda a, b: float(math.floor(a)), Op.CEIL: lambda a, b: float(math.ceil(a)),
    Op.LT: lambda a, b: float(a < b), Op.LE: lambda a, b: float(a <= b), Op.EQ: lambda a, b: float(a == b),
    Op.NE: lambda a, b: float(a != b), Op.NOT: lambda a, b: float(a == 0), Op.AND: lambda a, b: float(a != 0 and b != 0),
    Op.OR: lambda a, b: float(a != 0 or b != 0), Op.IF_ELSE_ZERO: lambda a, b: b if a != 0 else 0.0,
}
_OF_ONE = (Op.SQRT, Op.SIN, Op.COS, Op.TAN, Op.ASIN, Op.ACOS, Op.ATAN, Op.EXP, Op.LOG, Op.SINH, Op.COSH, Op.TANH, Op.ASINH,
           Op.ACOSH, Op.ATANH, Op.ERF)


def _of_one(name: str) -> Callable[[float, float], float]:
    function = getattr(math, name)
    return lambda a, b: float(function(a))


_TABLE = {**_FUNCTIONS, **{op: _of_one(op.name.lower()) for op in _OF_ONE}}


def evaluate(tape: Tape, *inputs: Sequence[float]) -> list[list[float]]:
    """The outputs of a tape; NaN wherever something cannot be computed, a division by zero among them."""
    work = [0.0] * tape.n_work
    outputs = [[0.0] * size for size in tape.out_sizes]
    for k in range(0, len(tape.code), 4):
        op, out, a, b = tape.code[k : k + 4]
        if op == Op.INPUT:
            work[out] = float(inputs[a][b])
        elif op == Op.OUTPUT:
            outputs[out][b] = work[a]
        elif op == Op.CONST:
            work[out] = tape.constants[a]
        else:
            try:
                work[out] = _TABLE[op](work[a], 0.0 if op in _OF_ONE else work[b])
            except (ValueError, ArithmeticError):
                work[out] = math.nan
    return outputs
