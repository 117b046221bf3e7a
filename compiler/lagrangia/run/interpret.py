"""Evaluates a tape in Python: for what is asked once a run, where neither CasADi nor the run time is at hand."""

import math
import operator
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Any

from lagrangia.native.tapes import Op, Tape

if TYPE_CHECKING:
    import numpy as np

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


_BY_NUMBER = {int(op): function for op, function in (*_FUNCTIONS.items(), *((op, _of_one(op.name.lower())) for op in _OF_ONE))}
_LIKE_NUMBERS = {int(op) for op in (Op.ASSIGN, Op.ADD, Op.SUB, Op.MUL, Op.NEG, Op.SQ, Op.TWICE, Op.FABS)}  # arrays, too
_QUOTIENTS = {int(Op.DIV), int(Op.INV)}
_INPUT, _OUTPUT, _CONST = int(Op.INPUT), int(Op.OUTPUT), int(Op.CONST)
_UNARY = {int(op) for op in _OF_ONE}


def evaluate(tape: Tape, *inputs: Sequence[float]) -> list[list[float]]:
    """The outputs of a tape; NaN wherever something cannot be computed, a division by zero among them."""
    return _evaluate(tape, inputs, _apply)


def evaluate_each(tape: Tape, *inputs: "Sequence[np.ndarray | float]") -> "list[list[np.ndarray | float]]":
    """The same for many sets of inputs at once: arrays (sets,) in the place of numbers, or numbers that all sets share."""
    return _evaluate(tape, inputs, _apply_to_arrays)


def _evaluate(tape: Tape, inputs: Sequence[Sequence[Any]], apply: Callable[[int, Any, Any], Any]) -> list[list[Any]]:
    work = [0.0] * tape.n_work
    outputs = [[0.0] * size for size in tape.out_sizes]
    places = iter(tape.code)
    for op, out, a, b in zip(places, places, places, places, strict=True):
        if op == _INPUT:
            work[out] = inputs[a][b]
        elif op == _OUTPUT:
            outputs[out][b] = work[a]
        elif op == _CONST:
            work[out] = tape.constants[a]
        else:
            work[out] = apply(op, work[a], 0.0 if op in _UNARY else work[b])
    return outputs


def _apply(op: int, a: float, b: float) -> float:
    try:
        return _BY_NUMBER[op](a, b)
    except (ValueError, ArithmeticError):
        return math.nan


def _apply_to_arrays(op: int, a: Any, b: Any) -> Any:
    import numpy as np

    if isinstance(a, float) and isinstance(b, float):
        return _apply(op, a, b)
    if op in _LIKE_NUMBERS:
        return _BY_NUMBER[op](a, b)
    if op in _QUOTIENTS:
        above, below = (1.0, a) if op == Op.INV else (a, b)
        is_zero = below == 0
        return np.where(is_zero, np.nan, above / np.where(is_zero, 1.0, below))
    with np.errstate(all="ignore"):
        return np.asarray(np.frompyfunc(partial(_apply, op), 2, 1)(a, b), float)
