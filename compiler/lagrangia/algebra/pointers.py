"""CasADi Functions of numbers, called through C pointers: 2 us, where CasADi's own call takes 10, and as much for each result."""

from collections.abc import Sequence
from threading import Lock
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Pointer:
    """A function of numbers and vectors, dense ones. Threads may share it.

    Outputs come as CasADi stores them, by columns: rows are the columns of a matrix; a single column comes as a vector.
    """

    def __init__(self, function: ca.Function) -> None:
        self._function, self._lock = function, Lock()
        self._buffer, self._evaluate = function.buffer()
        self._in = [np.zeros(function.numel_in(k)) for k in range(function.n_in())]
        self._sparsities = [function.sparsity_out(k) for k in range(function.n_out())]
        self._entries = [np.zeros(x.nnz()) for x in self._sparsities]
        self._places = [None if x.is_dense() else np.array(x.find(), int) for x in self._sparsities]  # of entries by columns
        for k, vector in enumerate(self._in):
            self._buffer.set_arg(k, memoryview(vector.data))
        for k, found in enumerate(self._entries):
            self._buffer.set_res(k, memoryview(found.data))

    def outputs(self, *values: Any) -> "list[NDArray[Any]]":
        """All of them. Raises ArithmeticError where the function gives up."""
        return [found.reshape(x.size2(), x.size1()) if x.size2() > 1 else found
                for found, x in zip(self._by_columns(values), self._sparsities, strict=True)]

    def matrices(self, *values: Any) -> "list[NDArray[Any]]":
        """All outputs, each (rows, columns), from matrices and vectors. Raises ArithmeticError where the function gives up."""
        return [np.ascontiguousarray(found.reshape(x.size2(), x.size1()).T)
                for found, x in zip(self._by_columns(values), self._sparsities, strict=True)]

    def _by_columns(self, values: Sequence[Any]) -> "list[NDArray[Any]]":
        """The outputs, zeros among them, one column after the other."""
        with self._lock:
            for vector, value in zip(self._in, values, strict=True):
                vector[:] = value if np.ndim(value) < 2 else value.ravel("F")
            self._evaluate()
            if self._buffer.ret():
                raise ArithmeticError(f"{self._function.name()} gave up")
            return [entries.copy() if places is None else _spread(entries, places, x.numel())
                    for entries, places, x in zip(self._entries, self._places, self._sparsities, strict=True)]

    def __call__(self, *values: Any) -> "NDArray[Any]":
        """The first output. Raises ArithmeticError where the function gives up."""
        return self.outputs(*values)[0]


def _spread(entries: "NDArray[Any]", places: "NDArray[Any]", size: int) -> "NDArray[Any]":
    whole = np.zeros(size)
    whole[places] = entries
    return whole
