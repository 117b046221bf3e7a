"""CasADi Function -> tape: instructions (op, out, a, b) on one work vector, as runtime/tape.h states."""

from array import array
from collections.abc import Mapping

import casadi as ca

from lagrangia.runtime import Op, Tape

# An operation has the same name in CasADi and in runtime/tape.h.
_MOVES = (Op.INPUT, Op.OUTPUT, Op.CONST)
_UNARY = frozenset(Op[name] for name in (
    "ASSIGN", "NEG", "SQ", "TWICE", "INV", "SQRT", "SIN", "COS", "TAN", "ASIN", "ACOS", "ATAN", "EXP", "LOG", "FABS", "SIGN",
    "FLOOR", "CEIL", "NOT", "SINH", "COSH", "TANH", "ASINH", "ACOSH", "ATANH", "ERF"))
_OPS: Mapping[int, Op] = {getattr(ca, f"OP_{op.name}"): op for op in Op if op not in _MOVES}


def tape_of(function: ca.Function) -> Tape:
    """The instructions of an SX Function with dense inputs and outputs.

    Raises NotImplementedError for an operation that the run time lacks.
    """
    code: array[int] = array("i")
    constants: array[float] = array("d")
    for k in range(function.n_instructions()):
        op, inputs, outputs = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            code.extend((Op.INPUT, outputs[0], inputs[0], inputs[1]))
        elif op == ca.OP_OUTPUT:
            code.extend((Op.OUTPUT, outputs[0], inputs[0], outputs[1]))
        elif op == ca.OP_CONST:
            code.extend((Op.CONST, outputs[0], len(constants), 0))
            constants.append(function.instruction_constant(k))
        elif op in _OPS:
            code.extend((_OPS[op], outputs[0], inputs[0], inputs[1] if len(inputs) > 1 else 0))
        else:
            raise NotImplementedError(f"the operation {op} of CasADi in '{function.name()}'")
    sizes_in = [function.numel_in(i) for i in range(function.n_in())]
    sizes_out = [function.numel_out(i) for i in range(function.n_out())]
    return Tape(sizes_in, sizes_out, max(1, function.sz_w()), code, constants)


def count_operations(tape: Tape, output: int | None = None) -> int:
    """Instructions that compute something; those alone that one of the outputs needs."""
    code = tape.code
    if output is None:
        return sum(1 for op in code[::4] if op not in _MOVES)
    needed: set[int] = set()
    count = 0
    for k in range(len(code) - 4, -4, -4):
        op, out, a, b = code[k : k + 4]
        if op == Op.OUTPUT:
            if out == output:
                needed.add(a)
        elif out in needed:
            needed.remove(out)
            if op not in _MOVES:
                count += 1
                needed.add(a)
                if op not in _UNARY:
                    needed.add(b)
    return count
