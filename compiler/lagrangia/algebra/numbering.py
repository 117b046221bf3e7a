"""Numbers for the values of expressions: what is the same has one number, however its expression was built."""

from collections.abc import Callable, Sequence
from dataclasses import field
from itertools import islice

import casadi as ca

from lagrangia.algebra.scalars import Expression, as_expression, operate
from lagrangia.base.records import dataclass

_COMMUTATIVE = (ca.OP_ADD, ca.OP_MUL)
_Key = tuple[float, ...]
Make = Callable[[int, list[int], list[Expression]], Expression | None]


@dataclass
class Numbering:
    """Of the values of all instructions that it was shown."""

    numbers: dict[_Key, int] = field(default_factory=dict)
    keys: list[_Key] = field(default_factory=list)  # by number

    def number(self, value: ca.SX) -> int:
        """Of a scalar expression."""
        symbols = ca.symvar(value)
        function = ca.Function("value", symbols, [value])
        held, made = [0] * max(1, function.sz_w()), 0
        for k in range(function.n_instructions()):
            op, inputs = function.instruction_id(k), function.instruction_input(k)
            if op == ca.OP_INPUT:
                made = self.of_symbol(symbols[inputs[0]])
            elif op == ca.OP_CONST:
                made = self.of_number(function.instruction_constant(k))
            elif op == ca.OP_OUTPUT:
                made = held[inputs[0]]
                break
            else:
                made = self.of(op, [held[place] for place in inputs])
            held[function.instruction_output(k)[0]] = made
        return made

    def of_symbol(self, symbol: ca.SX) -> int:
        """That of a symbol."""
        return self._numbered((ca.OP_INPUT, symbol.__hash__()))

    def of_number(self, number: float) -> int:
        """That of a constant."""
        return self._numbered((ca.OP_CONST, number))

    def of(self, op: int, operands: list[int]) -> int:
        """Of an operation on values with these numbers."""
        if op == ca.OP_SUB:  # a - 1 is a + -1
            op, operands = ca.OP_ADD, [operands[0], self._negative(operands[1])]
        return self._numbered((op, *(sorted(operands) if op in _COMMUTATIVE else operands)))

    def _numbered(self, key: _Key) -> int:
        if key not in self.numbers:
            self.numbers[key] = len(self.keys)
            self.keys.append(key)
        return self.numbers[key]

    def _negative(self, number: int) -> int:
        op, *operands = self.keys[number]
        return self.of_number(-operands[0]) if op == ca.OP_CONST else self._numbered((ca.OP_NEG, number))


def rebuilt(expressions: Sequence[ca.SX], numbering: Numbering, make: Make) -> list[ca.SX]:
    """The expressions made anew, with what `make` gives for an instruction, unless that is None."""
    column = ca.vertcat(ca.SX(0, 1), *(e.nz[:] for e in expressions))
    symbols = ca.symvar(column)
    function = ca.Function("rebuilt", [ca.vertcat(ca.SX(0, 1), *symbols)], [column])  # one input: CasADi warns of thousands
    held: list[tuple[int, Expression]] = [(0, as_expression(0.0))] * max(1, function.sz_w())
    results = [as_expression(0.0)] * column.numel()
    for k in range(function.n_instructions()):
        op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            held[outputs[0]] = numbering.of_symbol(symbols[inputs[1]]), as_expression(symbols[inputs[1]])
        elif op == ca.OP_CONST:
            number = function.instruction_constant(k)
            held[outputs[0]] = numbering.of_number(number), as_expression(number)
        elif op == ca.OP_OUTPUT:
            results[outputs[1]] = held[inputs[0]][1]
        else:
            numbers, operands = [held[place][0] for place in inputs], [held[place][1] for place in inputs]
            made = make(op, numbers, operands)
            held[outputs[0]] = numbering.of(op, numbers), operate(op, operands) if made is None else made
    rest = iter(results)
    return [ca.SX(e.sparsity(), ca.vertcat(ca.SX(0, 1), *islice(rest, e.nnz()))) for e in expressions]
