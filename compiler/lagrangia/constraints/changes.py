"""By how much expressions are changed by what moves, wherever it is, and without asking where they have corners.

Slopes at some places say nothing of max(0, x - 2). So all that is no sum or product, as max, a comparison or a sine, is taken for
a number of its own of which nothing is known but what it depends on; equal ones are one number. What is left are polynomials, and
one that is the same at places taken at random is the same everywhere (J. T. Schwartz, Fast probabilistic algorithms for
verification of polynomial identities, 1980). That sin^2 + cos^2 is 1 is not seen: it counts as changing.
"""

from collections.abc import Callable, Container, Sequence

import casadi as ca
import numpy as np
from numpy.typing import NDArray

from lagrangia.algebra.duals import Scalar
from lagrangia.algebra.numbering import Numbering
from lagrangia.algebra.scalars import column

_PLACES = 4
_SUMS: dict[int, Callable[..., NDArray[np.float64]]] = {
    ca.OP_ADD: lambda a, b: a + b, ca.OP_SUB: lambda a, b: a - b, ca.OP_MUL: lambda a, b: a * b, ca.OP_NEG: lambda a: -a,
    ca.OP_TWICE: lambda a: a + a, ca.OP_SQ: lambda a: a * a, ca.OP_ASSIGN: lambda a: a,
}
_Known = tuple[int, NDArray[np.float64], bool]  # of an instruction: its number, its value at each place, whether it moves


def changes_of(values: Sequence[Scalar], still: Container[int]) -> NDArray[np.float64]:
    """Of each value, how it differs from one place to the others, (n, 3), where all moves but symbols with the hashes `still`;
    infinite where it is no finite number."""
    whole = column(*values)
    symbols = ca.symvar(whole)
    if all(x.__hash__() in still for x in symbols):
        return np.zeros((len(values), _PLACES - 1))
    found = _Walk(still).follow(whole, symbols)
    differences = found[:, 1:] - found[:, :1]
    return np.where(np.isfinite(differences), differences, np.inf)


class _Walk:
    """Through the instructions of an expression."""

    def __init__(self, still: Container[int]) -> None:
        self.still = still
        self.numbering = Numbering()
        self.random = np.random.default_rng(1)
        self.atoms: dict[int, _Known] = {}

    def follow(self, whole: ca.SX, symbols: Sequence[ca.SX]) -> NDArray[np.float64]:
        """The values at each place."""
        function = ca.Function("values", [ca.vertcat(*symbols)], [ca.densify(whole)])
        held: list[_Known] = [self._constant(0.0)] * max(1, function.sz_w())
        results = np.zeros((whole.numel(), _PLACES))
        for k in range(function.n_instructions()):
            op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
            if op == ca.OP_OUTPUT:
                results[outputs[1]] = held[inputs[0]][1]
            elif op == ca.OP_INPUT:
                symbol = symbols[inputs[1]]
                held[outputs[0]] = self._atom(self.numbering.of_symbol(symbol), symbol.__hash__() not in self.still)
            elif op == ca.OP_CONST:
                held[outputs[0]] = self._constant(function.instruction_constant(k))
            else:
                held[outputs[0]] = self._made(op, [held[place] for place in inputs])
        return results

    def _constant(self, number: float) -> _Known:
        return self.numbering.of_number(number), np.full(_PLACES, number), False

    def _made(self, op: int, operands: Sequence[_Known]) -> _Known:
        numbers, values, moving = zip(*operands, strict=True)
        number, moves = self.numbering.of(op, list(numbers)), any(moving)
        if op in _SUMS:
            return number, _SUMS[op](*values), moves
        if op == ca.OP_DIV:
            return number, values[0] * self._inverse(operands[1]), moves
        if op == ca.OP_IF_ELSE_ZERO:
            holds = self._atom(self.numbering.of(ca.OP_IF_ELSE_ZERO, [numbers[0]]), moving[0])[1]  # 1 or 0
            return number, holds * values[1], moves
        return self._atom(number, moves)

    def _inverse(self, operand: _Known) -> NDArray[np.float64]:
        number, value, moves = operand
        if self.numbering.keys[number][0] == ca.OP_CONST:
            return 1 / value
        return self._atom(self.numbering.of(ca.OP_INV, [number]), moves)[1]

    def _atom(self, number: int, moves: bool) -> _Known:
        if number not in self.atoms:
            value = self.random.uniform(0.3, 1.7, _PLACES) if moves else np.full(_PLACES, self.random.uniform(0.3, 1.7))
            self.atoms[number] = number, value, moves
        return self.atoms[number]
