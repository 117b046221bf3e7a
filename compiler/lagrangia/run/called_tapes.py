"""Tapes that Python asks for again and again, by the run time: a hundredth of the time of interpret.evaluate."""

import ctypes as c
from typing import Any

from lagrangia.native.tapes import Tape
from lagrangia.run.runtime import function_of


class CalledTape:
    """Callable: the number that a tape gives of one vector, as it is just now."""

    def __init__(self, library: c.CDLL, tape: Tape, given: Any) -> None:
        """`given`: doubles, as ctypes has them. Raises ValueError where the tape reaches outside its vectors."""
        function = function_of(tape)
        if not library.lag_tape_valid(c.byref(function)):
            raise ValueError("the tape is not valid")
        found, work = [(c.c_double * size)() for size in tape.out_sizes], (c.c_double * tape.n_work)()
        vectors = (c.c_void_p * (1 + len(found)))(c.addressof(given), *map(c.addressof, found))
        self._run, self._found, self._kept = library.lag_tape_run, found[0], (function, given, vectors, found)
        self._arguments = function.tape, c.addressof(vectors), c.addressof(vectors) + c.sizeof(c.c_void_p), work

    def __call__(self) -> float:
        self._run(*self._arguments)
        return self._found[0]
