"""CasADi Functions -> assignments in the words of another language: one an operation."""

import math
from collections.abc import Callable, Mapping, Sequence

import casadi as ca

Entry = Callable[[int], str]  # of an argument, by its place


def texts_of(words: Mapping[str, str]) -> Mapping[int, str]:
    """Formats of operations by their numbers, from those by CasADi's names."""
    return {getattr(ca, f"OP_{name}"): text for name, text in words.items()}


def finite(value: float) -> str:
    """A number as most languages have it. Raises NotImplementedError for what is none."""
    if not math.isfinite(value):
        raise NotImplementedError(f"the value {value!r}")
    return repr(value)


def statements(function: ca.Function, arguments: Sequence[Entry], texts: Mapping[int, str], prefix: str = "w",
               number: Callable[[float], str] = finite) -> tuple[list[str], list[list[str]]]:
    """Assignments w0 = ..., and the entries of each output (column by column, zeros in their places) as names or numbers.

    `texts` are formats of operations by their numbers. Raises NotImplementedError for an operation that has none.
    """
    lines: list[str] = []
    work = [""] * max(1, function.sz_w())
    found = [["0.0"] * function.numel_out(i) for i in range(function.n_out())]
    for k in range(function.n_instructions()):
        op, read, write = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            work[write[0]] = arguments[read[0]](read[1])
        elif op == ca.OP_CONST:
            text = number(function.instruction_constant(k))
            work[write[0]] = f"({text})" if text.startswith("-") else text
        elif op == ca.OP_OUTPUT:
            rows, columns = function.sparsity_out(write[0]).get_triplet()
            place = rows[write[1]] + columns[write[1]] * function.size1_out(write[0])
            found[write[0]][place] = work[read[0]]
        elif op in texts:
            lines.append(f"{prefix}{len(lines)} = {texts[op].format(*(work[place] for place in read))}")
            work[write[0]] = f"{prefix}{len(lines) - 1}"
        else:
            raise NotImplementedError(f"the operation {op} of CasADi in '{function.name()}'")
    return lines, found


def entries_read(function: ca.Function, argument: int) -> list[int]:
    """The places of an argument's entries that are read."""
    read = (function.instruction_input(k) for k in range(function.n_instructions()) if function.instruction_id(k) == ca.OP_INPUT)
    return sorted({place for which, place in read if which == argument})
