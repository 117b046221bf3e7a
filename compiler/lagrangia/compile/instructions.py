"""CasADi Function -> tape: instructions (op, out, a, b) on one work vector, as runtime/model/tape.h states.

What is the same is computed once, and sines and cosines stand together, which computes four at a time. The run time does that
where it is at hand (runtime/model/arrange.c): the same tapes.
"""

from array import array
from collections import Counter
from collections.abc import Mapping, Sequence
from math import copysign
from struct import iter_unpack, unpack_from

import casadi as ca

from lagrangia.compile.casadi_instructions import SIZE, read_instructions
from lagrangia.native.tapes import BINARY as BINARIES
from lagrangia.native.tapes import SINES, Op, Tape
from lagrangia.run.arranging import BINARY, COMMUTES, OP, arrange
from lagrangia.run.library import Runtime, find_runtime

# An operation has the same name in CasADi and in runtime/model/tape.h.
_INPUT, _OUTPUT, _CONST = _MOVES = int(Op.INPUT), int(Op.OUTPUT), int(Op.CONST)  # members of an enumeration are slow keys
_OPS: Mapping[int, int] = {getattr(ca, f"OP_{op.name}"): int(op) for op in Op if op not in _MOVES}
_COMMUTATIVE = (ca.OP_ADD, ca.OP_MUL)
_Instruction = tuple[int, int, int, int]  # op, out, a, b
_MADE = {**_OPS, ca.OP_INPUT: _INPUT, ca.OP_OUTPUT: _OUTPUT, ca.OP_CONST: _CONST}
# By operation, for the run time.
KINDS = [-1 if (own := _MADE.get(op)) is None else own | BINARY * (own in BINARIES) | COMMUTES * (op in _COMMUTATIVE)
          for op in range(max(_MADE) + 1)]
_LEAVES = (_INPUT, _CONST)
_FEWEST_TOGETHER = 4  # the library takes less time for three


def tape_of(function: ca.Function) -> Tape:
    """The instructions of an SX Function; of inputs and outputs what is not structurally 0.

    Raises NotImplementedError for an operation that the run time lacks.
    """
    return tapes_together([function])[0]


def tapes_together(functions: Sequence[ca.Function]) -> list[Tape]:
    """Of each. Raises NotImplementedError as `tape_of` does."""
    runtime = find_runtime()
    return [arranged(read_instructions(f), [f.nnz_in(i) for i in range(f.n_in())], [f.nnz_out(i) for i in range(f.n_out())],
                     runtime) for f in functions]


def arranged(read: bytes, sizes_in: Sequence[int], sizes_out: Sequence[int], runtime: Runtime | None) -> Tape:
    """The tape of instructions as runtime/model/arrange.h reads them, by that of `find_runtime`, which looks at files to tell.

    Raises NotImplementedError as `tape_of` does.
    """
    if runtime is not None and runtime.is_ready:
        code, constants, n_work = arrange(runtime, read, KINDS)
    else:
        instructions, constants = _values(read)
        code, n_work = _placed(_with_sines_together(instructions))
    return Tape(sizes_in, sizes_out, n_work, code, constants)


def _values(read: bytes) -> tuple[list[_Instruction], "array[float]"]:
    """The instructions, with the places of those that made their operands in this list instead of places in w; the constants."""
    found: list[_Instruction] = []
    constants: array[float] = array("d")
    known, held = dict[tuple[float, ...], int](), dict[int, int]()
    for k, (op, out, left, right) in enumerate(iter_unpack("=4i", read)):
        kind = kind_of(op)
        own = kind & OP
        if own == _OUTPUT:
            found.append((_OUTPUT, out, held[left], right))
            continue
        if own == _INPUT:
            key: tuple[float, ...] = (_INPUT, left, right)
            made = _INPUT, 0, left, right
        elif own == _CONST:
            (number,) = unpack_from("=d", read, SIZE * k + 8)
            key, made = (number, copysign(1.0, number)), (_CONST, 0, len(constants), 0)
            if key not in known:
                constants.append(number)
        else:
            a = held[left]
            b = held[right] if kind & BINARY else a
            key, made = (own, b, a) if b < a and kind & COMMUTES else (own, a, b), (own, 0, a, b)
        place = held[out] = known.setdefault(key, len(found))
        if place == len(found):
            found.append(made)
    return found, constants


def kind_of(op: int) -> int:
    """What is known of an operation of CasADi. Raises NotImplementedError for one that the run time lacks."""
    kind = KINDS[op] if op < len(KINDS) else -1
    if kind < 0:
        raise NotImplementedError(f"the operation {op} of CasADi")
    return kind


def _with_sines_together(instructions: list[_Instruction]) -> list[_Instruction]:
    """The same in another order: what the sines and cosines of the first level need, then these, and so on; at last the rest.

    Those of a level need none of each other's results: unless they are few, they are computed together; see runtime/model/tape.h.
    """
    order, place = list[int](), [-1] * len(instructions)

    def add(more: list[int]) -> None:
        for k in more:
            place[k] = len(order)
            order.append(k)

    to_come: dict[int, int] = {}
    for sines in _levels(instructions):
        number = {a: n for n, a in enumerate(dict.fromkeys(instructions[k][2] for k in sines))}
        add(_needed_first(list(number), instructions, place))
        paired = [k for _, k in sorted((number[instructions[k][2]], k) for k in sines)]
        if len(paired) >= _FEWEST_TOGETHER:
            to_come |= {k: len(paired) - i for i, k in enumerate(paired)}
        add(paired)
    add([k for k in range(len(instructions)) if place[k] < 0])
    return [_moved(instructions[k], place, to_come.get(k, 0)) for k in order]


def _levels(instructions: list[_Instruction]) -> list[list[int]]:
    """Sines and cosines by how many others lie one within another below them."""
    level, found = [0] * len(instructions), list[list[int]]()
    for k, (op, _, a, b) in enumerate(instructions):
        if op in SINES:
            if level[a] == len(found):
                found.append([])
            found[level[a]].append(k)
            level[k] = level[a] + 1
        elif op not in _MOVES:
            level[k] = max(level[a], level[b])
    return found


def _needed_first(wanted: list[int], instructions: list[_Instruction], place: list[int]) -> list[int]:
    """The instructions without a place that these depend on, and these, in their order."""
    found: set[int] = set()
    pending = wanted
    while pending:
        k = pending.pop()
        if place[k] < 0 and k not in found:
            found.add(k)
            if instructions[k][0] not in _LEAVES:
                pending.extend(instructions[k][2:])
    return sorted(found)


def _moved(instruction: _Instruction, place: list[int], to_come: int) -> _Instruction:
    op, out, a, b = instruction
    if op in _LEAVES:
        return instruction
    if op == _OUTPUT:
        return op, out, place[a], b
    return op, out, place[a], to_come if op in SINES else place[b]


def _placed(instructions: list[_Instruction]) -> tuple["array[int]", int]:
    """The code and the size of w, where a place is free for others after its last reader."""
    last = [0] * len(instructions)
    for k, (op, _, a, b) in enumerate(instructions):
        if op == _OUTPUT or op in SINES:
            last[a] = k
        elif op not in _LEAVES:
            last[a] = last[b] = k
    code: array[int] = array("i")
    place, free, size = [0] * len(instructions), list[int](), 0
    for k, (op, out, a, b) in enumerate(instructions):
        left, right = a, b
        if op not in _LEAVES:
            left = place[a]
            if op != _OUTPUT and op not in SINES:
                right = place[b]
                if last[b] == k and a != b:
                    free.append(right)
            if last[a] == k:
                free.append(left)
        if op == _OUTPUT:
            place[k] = out
        else:
            if not free:
                free.append(size)
                size += 1
            place[k] = free.pop()
        code.extend((op, place[k], left, right))
    return code, max(1, size)


def count_operations(tape: Tape, output: int | None = None) -> int:
    """Instructions that compute something; those alone that one of the outputs needs."""
    if output is None or not any(size for k, size in enumerate(tape.out_sizes) if k != output):  # nothing is there for nothing
        found = Counter(tape.code[::4])
        return sum(found.values()) - sum(found[op] for op in _MOVES)
    needed: set[int] = set()
    count = 0
    for op, out, a, b in zip(*(reversed(tape.code[k::4]) for k in range(4)), strict=True):
        if op == _OUTPUT:
            if out == output:
                needed.add(a)
        elif out in needed:
            needed.remove(out)
            if op not in _LEAVES:
                count += 1
                needed.add(a)
                if op not in SINES:
                    needed.add(b)
    return count
