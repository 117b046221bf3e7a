"""Instructions of CasADi -> a tape, and what they compute of parameters alone taken out of them, by the run time: a twentieth of
the time that Python takes."""

import ctypes as c
from array import array
from collections.abc import Sequence
from itertools import accumulate, pairwise
from mmap import mmap

from lagrangia.run.library import Runtime

OP, BINARY, COMMUTES = 0xFF, 0x100, 0x200  # LAG_ARRANGE_... of runtime/model/arrange.h
_NUMBER = c.c_int32
_ARGUMENTS = (c.c_void_p, _NUMBER, c.c_void_p, _NUMBER, c.c_void_p, c.c_void_p, c.c_void_p)
_OF_HOIST = (c.c_void_p, c.c_void_p, c.c_void_p, _NUMBER, _NUMBER, c.c_void_p, _NUMBER, c.c_void_p, c.c_void_p)
_SIZE = 16  # bytes of an instruction


def arrange(runtime: Runtime, read: bytes, kinds: Sequence[int]) -> "tuple[array[int], array[float], int]":
    """The code of a tape, its constants, and the size of its work vector; `read` and `kinds` as runtime/model/arrange.h has them.
    Raises NotImplementedError for an operation that tapes lack, MemoryError."""
    count = len(read) // _SIZE
    code, constants, sizes = array("i", (0,)) * (4 * count), array("d", (0.0,)) * count, (_NUMBER * 3)()
    function = runtime.library.lag_arrange
    function.argtypes, function.restype = _ARGUMENTS, c.c_int
    known = (_NUMBER * len(kinds))(*kinds)
    answer = function(read, count, known, len(kinds), code.buffer_info()[0], constants.buffer_info()[0], sizes)
    _require(answer)
    del code[4 * sizes[0] :], constants[sizes[1] :]
    return code, constants, sizes[2]


def take_out(runtime: Runtime, programs: Sequence[bytes], arguments: Sequence[int], settled: int, kinds: Sequence[int]
             ) -> tuple[list[bytes], int]:
    """The programs without what they compute of parameters alone, and how many hoisted values there are: see
    runtime/model/hoist.h. Raises as `arrange` does."""
    counts = [len(program) // _SIZE for program in programs]
    sizes = (_NUMBER * (len(programs) + 1))()
    written = mmap(-1, 3 * _SIZE * max(1, sum(counts)))  # memory that is touched where it is written
    function = runtime.library.lag_hoist
    function.argtypes, function.restype = _OF_HOIST, c.c_int
    known_counts, known_arguments, known = ((_NUMBER * len(values))(*values) for values in (counts, arguments, kinds))
    place = c.addressof(c.c_char.from_buffer(written))
    _require(function(b"".join(programs), known_counts, known_arguments, len(programs), settled, known, len(kinds), place, sizes))
    ends = [0, *accumulate(_SIZE * size for size in sizes[:-1])]
    *others, first = (written[a:b] for a, b in pairwise(ends))
    return [first, *others], sizes[-1]


def _require(answer: int) -> None:
    if answer:
        raise (MemoryError("no memory to compile this scene") if answer == 1 else NotImplementedError("an operation of CasADi"))
