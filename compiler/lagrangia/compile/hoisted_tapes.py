"""Functions -> tapes, out of which is taken what they compute of parameters alone: once a run instead of in every call.

Small functions have that behind them (hoisting.py), with constants drawn together, expression by expression. Of large ones the
instructions are told apart, all at once, by the run time where it is at hand (runtime/model/hoist.c): the same tapes.
"""

from collections.abc import Mapping, Sequence
from dataclasses import field
from struct import Struct, iter_unpack

import casadi as ca

from lagrangia.base.records import dataclass
from lagrangia.compile.casadi_instructions import read_instructions
from lagrangia.compile.functions import Functions
from lagrangia.compile.instructions import KINDS, arranged, kind_of, tapes_together
from lagrangia.native.tapes import Op, Tape
from lagrangia.run.arranging import BINARY, COMMUTES, OP, take_out
from lagrangia.run.library import Runtime, find_runtime

_INPUT, _OUTPUT, _CONST = map(int, (Op.INPUT, Op.OUTPUT, Op.CONST))  # members of an enumeration are slow to compare
_WORDS = Struct("=4i")


def tapes_of(functions: Functions) -> dict[str, Tape]:
    """All tapes. Raises NotImplementedError for an operation that the run time lacks."""
    table, hoist = functions.table, functions.table["hoist"]
    if functions.settled == hoist.numel_out(0):
        return dict(zip(table, tapes_together([*table.values()]), strict=True))
    reading = ["hoist", *(name for name, function in table.items() if "c" in function.name_in())]
    arguments = [0, *(table[name].index_in("c") for name in reading[1:])]
    others = [name for name in table if name not in reading]
    everything, runtime = [read_instructions(table[name]) for name in (*reading, *others)], find_runtime()
    read = everything[: len(reading)]
    if runtime is not None and runtime.is_ready:
        made, count = take_out(runtime, read, arguments, functions.settled, KINDS)
    else:
        made, count = _taken_out(read, arguments, functions.settled)
    programs = dict(zip((*reading, *others), (*made, *everything[len(reading) :]), strict=True))
    return {name: _tape(function, programs[name], count if name in reading else None, name == "hoist", runtime)
            for name, function in table.items()}


def _tape(function: ca.Function, program: bytes, count: int | None, is_hoist: bool, runtime: Runtime | None) -> Tape:
    """With so many hoisted values, where it reads or gives some."""
    sizes_in = [count if name == "c" and count is not None else function.numel_in(k) for k, name in enumerate(function.name_in())]
    sizes_out = [count] if is_hoist and count is not None else [function.numel_out(k) for k in range(function.n_out())]
    return arranged(program, sizes_in, sizes_out, runtime)


@dataclass
class _Values:
    """What is computed of parameters, as the instructions of one program."""

    settled: int
    code: list[bytes] = field(default_factory=list)
    known: dict[tuple[int, ...], int] = field(default_factory=dict)  # places in the code
    slots: dict[int, int] = field(default_factory=dict)  # by places in the code, those among the hoisted values
    count: int = 0  # of hoisted values

    def number(self, op: int, a: int, b: int) -> int:
        """The place of a value."""
        key = (op, b, a) if b < a and kind_of(op) & COMMUTES else (op, a, b)
        if key not in self.known:
            self.known[key] = len(self.code)
            self.code.append(_WORDS.pack(op, len(self.code), a, b))
        return self.known[key]

    def slot(self, value: int) -> int:
        """Its place among the hoisted values, of which it becomes one."""
        if value not in self.slots:
            self.slots[value] = self.count
            self.give(value, self.count)
            self.count += 1
        return self.slots[value]

    def give(self, value: int, slot: int) -> None:
        """As a result."""
        self.code.append(_WORDS.pack(_op_named(_OUTPUT), 0, value, slot))


class _Program:
    """One that is passed through: what its places hold that does not move, values by their places, leaves before they are any."""

    def __init__(self, values: _Values, argument: int, named: Mapping[int, int], offset: int) -> None:
        self.values, self.argument, self.named, self.offset = values, argument, named, offset
        self.held: dict[int, int | tuple[int, int, int]] = {}
        self.loaded: set[int] = set()
        self.code: list[bytes] = []

    def value(self, place: int) -> int | None:
        """None for what moves."""
        held = self.held.get(place)
        if isinstance(held, tuple):
            op, a, b = held
            if kind_of(op) & OP == _CONST:
                held = self.values.number(op, a, b)
            else:
                held = self.named[b] if b < self.offset else self.values.number(op, 0, b - self.offset)
        return held

    def load(self, place: int) -> None:
        """Puts what a place holds there, for an instruction that moves."""
        held = self.held.get(place)
        if held is None or place in self.loaded:
            return
        self.loaded.add(place)
        if isinstance(held, tuple) and kind_of(held[0]) & OP == _CONST:
            self.code.append(_WORDS.pack(held[0], place, *held[1:]))
        else:
            value = self.value(place)
            assert value is not None
            self.code.append(_WORDS.pack(_op_named(_INPUT), place, self.argument, self.values.slot(value)))

    def put(self, place: int, held: int | tuple[int, int, int] | None) -> None:
        """What a place holds from now on."""
        self.loaded.discard(place)
        if held is None:
            self.held.pop(place, None)
        else:
            self.held[place] = held

    def compute(self, op: int, out: int, a: int, b: int) -> None:
        """An operation."""
        operands = (a, b) if kind_of(op) & BINARY else (a,)
        values = [value for place in operands if (value := self.value(place)) is not None]
        if len(values) == len(operands):
            self.put(out, self.values.number(op, values[0], values[-1]))
            return
        for place in operands:
            self.load(place)
        self.code.append(_WORDS.pack(op, out, a, b))
        self.put(out, None)

    def follow(self, read: bytes, named: dict[int, int] | None) -> None:
        """All its instructions. `named`: of the first program, what stays of its results."""
        for op, out, a, b in iter_unpack("=4i", read):
            own = kind_of(op) & OP
            if own == _CONST or (own == _INPUT and a == self.argument):
                self.put(out, (op, a, b))
            elif own == _INPUT:
                self.code.append(_WORDS.pack(op, out, a, b))
                self.put(out, None)
            elif own != _OUTPUT:
                self.compute(op, out, a, b)
            elif named is None:
                self.load(a)
                self.code.append(_WORDS.pack(op, out, a, b))
            elif b < self.values.settled:
                value = self.value(a)
                assert value is not None
                named[b] = value
                self.values.slots.setdefault(value, b)
                self.values.give(value, b)


def _op_named(own: int) -> int:
    """The operation of CasADi."""
    return next(op for op, kind in enumerate(KINDS) if kind >= 0 and kind & OP == own)


def _taken_out(read: Sequence[bytes], arguments: Sequence[int], settled: int) -> tuple[list[bytes], int]:
    """The programs, and how many hoisted values there are: see runtime/model/hoist.h."""
    values, named = _Values(settled, count=settled), dict[int, int]()
    made = []
    for k, (program, argument) in enumerate(zip(read, arguments, strict=True)):
        passed = _Program(values, argument, named, settled if k else 0)
        passed.follow(program, None if k else named)
        made.append(b"".join(passed.code))
    return [b"".join(values.code), *made[1:]], values.count
