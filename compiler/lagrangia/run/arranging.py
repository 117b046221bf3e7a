"""Instructions of CasADi -> a tape, by the run time: a twentieth of the time that Python takes."""

import ctypes as c
from array import array
from collections.abc import Sequence

from lagrangia.run.library import Runtime

BINARY, COMMUTES = 0x100, 0x200  # LAG_ARRANGE_... of runtime/model/arrange.h, beside the number of the operation
_NUMBER = c.c_int32
_ARGUMENTS = (c.c_void_p, _NUMBER, c.c_void_p, _NUMBER, c.c_void_p, c.c_void_p, c.c_void_p)


def arrange(runtime: Runtime, read: bytes, kinds: Sequence[int]) -> "tuple[array[int], array[float], int]":
    """The code of a tape, its constants, and the size of its work vector; `read` and `kinds` as runtime/model/arrange.h has them.
    Raises NotImplementedError for an operation that tapes lack, MemoryError."""
    count = len(read) // 16
    code, constants, sizes = array("i", bytes(16 * count)), array("d", bytes(8 * count)), (_NUMBER * 3)()
    function = runtime.library.lag_arrange
    function.argtypes, function.restype = _ARGUMENTS, c.c_int
    known = (_NUMBER * len(kinds))(*kinds)
    answer = function(read, count, known, len(kinds), code.buffer_info()[0], constants.buffer_info()[0], sizes)
    if answer:
        raise (MemoryError("no memory to compile this scene") if answer == 1 else NotImplementedError("an operation of CasADi"))
    del code[4 * sizes[0] :], constants[sizes[1] :]
    return code, constants, sizes[2]
