"""The instructions of a CasADi Function, all at once.

CasADi tells them one after another, in 2.4 us each by the methods of Function. What these call takes 0.7 us, where it is given
what a Function wraps.
"""

from collections.abc import Callable
from itertools import chain, repeat
from typing import Any

import casadi as ca
import numpy as np
from numpy.typing import NDArray

SIZE = 16  # bytes of an instruction
APART = {"live_variables": False}  # options of a Function whose results each have a place of their own: counted, not asked for
_AT_ONCE = 4096  # what is asked of so many fits into the processor's caches
_ID: Callable[[Any, int], int] = ca._casadi.Function_instruction_id
_INPUT: Callable[[Any, int], list[int]] = ca._casadi.Function_instruction_input
_OUTPUT: Callable[[Any, int], list[int]] = ca._casadi.Function_instruction_output
_CONSTANT: Callable[[Any, int], float] = ca._casadi.Function_instruction_constant


def read_instructions(function: ca.Function) -> bytes:
    """Four numbers (int32) each, as runtime/model/arrange.h reads them."""
    count, made, found = function.n_instructions(), 0, list[bytes]()
    are_apart = function.sz_w() == count - function.nnz_out()  # nothing takes the place of anything
    for k in range(0, count, _AT_ONCE):
        places = range(k, min(k + _AT_ONCE, count))
        ops = np.fromiter(map(_ID, repeat(function.this), places), np.int32, len(places))
        found.append(_read(function.this, places, ops, made if are_apart else None))
        made += int(np.count_nonzero(ops != ca.OP_OUTPUT))
    return b"".join(found)


def _read(function: Any, places: range, ops: NDArray[np.int32], first: int | None) -> bytes:
    """Operation, place of the result, places of the operands (the same twice of one); argument and element of inputs; operand and
    element of outputs; a constant in the last two. `first`: the place of the first result, where they stand one after another."""
    a, b = _ends([*map(_INPUT, repeat(function), places)])
    told = np.arange(len(places)) if first is None else np.flatnonzero(ops == ca.OP_OUTPUT)
    out = np.cumsum(ops != ca.OP_OUTPUT, dtype=np.int32) + np.int32((first or 0) - 1)
    out[told], elements = _ends([_OUTPUT(function, places[k]) for k in told.tolist()])
    b[told] = np.where(ops[told] == ca.OP_OUTPUT, elements, b[told])
    table = np.stack([ops, out, a, b], axis=1)
    for k in np.flatnonzero(ops == ca.OP_CONST):
        table[k, 2:] = np.array([_CONSTANT(function, places[k])]).view(np.int32)
    return table.tobytes()


def _ends(lists: list[list[int]]) -> tuple[NDArray[np.int32], NDArray[np.int32]]:
    """The first numbers and the last ones; anything of what has none."""
    counts = np.fromiter(map(len, lists), np.intp, len(lists))
    ends = np.cumsum(counts)
    numbers = np.fromiter(chain(chain.from_iterable(lists), (0,)), np.int32)
    return numbers[ends - counts], numbers[np.maximum(ends - 1, 0)]
