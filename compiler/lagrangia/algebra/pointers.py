"""CasADi Functions of numbers, called through C pointers: 2 us, where CasADi's own call takes 10, and as much for each result."""

from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

if TYPE_CHECKING:
    from numpy.typing import NDArray


class Pointer:
    """A function of numbers and vectors, whose outputs are dense.

    They come as CasADi stores them, by columns: rows are the columns of a matrix; a single column comes as a vector.
    """

    def __init__(self, function: ca.Function) -> None:
        self._function = function
        self._buffer, self._evaluate = function.buffer()
        self._in = [np.zeros(function.numel_in(k)) for k in range(function.n_in())]
        sizes = (function.size_out(k) for k in range(function.n_out()))
        self._out = [np.zeros((columns, rows) if columns > 1 else rows) for rows, columns in sizes]
        for k, vector in enumerate(self._in):
            self._buffer.set_arg(k, memoryview(vector.data))
        for k, found in enumerate(self._out):
            self._buffer.set_res(k, memoryview(found.data))

    def outputs(self, *values: Any) -> "list[NDArray[Any]]":
        """All of them. Raises ArithmeticError where the function gives up."""
        for vector, value in zip(self._in, values, strict=True):
            vector[:] = value
        self._evaluate()
        if self._buffer.ret():
            raise ArithmeticError(f"{self._function.name()} gave up")
        return [found.copy() for found in self._out]

    def __call__(self, *values: Any) -> "NDArray[Any]":
        """The first output. Raises ArithmeticError where the function gives up."""
        return self.outputs(*values)[0]
