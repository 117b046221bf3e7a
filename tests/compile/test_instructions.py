"""Functions of CasADi -> tapes: in Python and by the run time alike."""

import math
import struct
from collections.abc import Callable

import casadi as ca
import pytest

from lagrangia.compile import casadi_instructions, instructions
from lagrangia.compile.casadi_instructions import APART, read_instructions
from lagrangia.compile.instructions import count_operations, tape_of
from lagrangia.native.tapes import Tape
from lagrangia.run.interpret import evaluate
from lagrangia.run.library import start_runtime

x, y = ca.SX.sym("x", 3), ca.SX.sym("y", 2)


def chain_of(n: int) -> ca.SX:
    angles = [x[0]]
    for k in range(n):
        angles.append(angles[-1] + (k + 1) * y[k % 2])
    return ca.vertcat(*[ca.sin(a) + 0.5 * ca.cos(a) * x[1] for a in angles])


FUNCTIONS: dict[str, Callable[[], ca.Function]] = {
    "empty": lambda: ca.Function("f", [x, y], [ca.SX(0, 1)]),
    "moved": lambda: ca.Function("f", [x, y], [ca.vertcat(x[2], 3.5, -0.0, 0.0, math.nan, math.nan), y]),
    "same": lambda: ca.Function("f", [x, y], [ca.vertcat(x[0] * x[1] + x[1] * x[0], x[0] - x[1], x[1] - x[0]), x[1] * x[0]]),
    "few sines": lambda: ca.Function("f", [x], [ca.sin(x[0]) + ca.cos(x[0]) + ca.sin(x[1])]),
    "nested sines": lambda: ca.Function("f", [x, y], [ca.sin(ca.cos(x) * ca.sin(x + y[0])) + ca.sin(ca.sin(ca.cos(x)))]),
    "conditions": lambda: ca.Function("f", [x, y], [ca.if_else(x[0] > y[0], ca.atan2(x[1], 2.0), ca.fmax(x[2], y[1]) ** 3)]),
    "apart": lambda: ca.Function("f", [x, y], [chain_of(9), ca.vertcat(2.5, x[2])], ["x", "y"], ["a", "b"], APART),
    "long": lambda: ca.Function("f", [x, y], [chain_of(200), ca.sumsqr(chain_of(20))]),
}


def told(tape: Tape) -> tuple[object, ...]:
    return list(tape.in_sizes), list(tape.out_sizes), tape.n_work, tape.code, tape.constants.tobytes()


@pytest.mark.parametrize("name", FUNCTIONS)
def test_the_run_time_and_python_make_the_same_tapes(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    function = FUNCTIONS[name]()
    assert start_runtime().library  # it is there
    arranged = tape_of(function)
    monkeypatch.setattr(instructions, "find_runtime", lambda: None)
    assert told(arranged) == told(tape_of(function))
    values = [[0.3, -1.2, 0.7], [0.4, 2.0]][: function.n_in()]
    expected = function.call([ca.DM(value) for value in values])
    for found, exact in zip(evaluate(arranged, *values), expected, strict=True):
        assert found == pytest.approx(exact.full().ravel().tolist(), rel=1e-15, nan_ok=True)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_instructions_are_those_that_casadi_tells(name: str, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(casadi_instructions, "_AT_ONCE", 5)
    function, expected = FUNCTIONS[name](), b""
    for k in range(function.n_instructions()):
        op, a, out = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_CONST:
            expected += struct.pack("=iid", op, out[0], function.instruction_constant(k))
        else:
            expected += struct.pack("=4i", op, out[0], a[0], out[1] if op == ca.OP_OUTPUT else a[-1])
    assert read_instructions(function) == expected


@pytest.mark.parametrize("has_runtime", [True, False])
def test_an_operation_that_tapes_lack_is_refused(has_runtime: bool, monkeypatch: pytest.MonkeyPatch) -> None:
    if not has_runtime:
        monkeypatch.setattr(instructions, "find_runtime", lambda: None)
    with pytest.raises(NotImplementedError, match="CasADi"):
        tape_of(ca.Function("f", [x], [ca.erfinv(x[0])]))


def test_operations_of_one_output_are_those_it_needs() -> None:
    tape = tape_of(ca.Function("f", [x], [x[0] * x[1], ca.sin(x[0] * x[1]) + x[2]]))
    assert [count_operations(tape), count_operations(tape, 0), count_operations(tape, 1)] == [3, 1, 3]
    alone = tape_of(ca.Function("f", [x], [x[0] * x[1] + 1, ca.SX(0, 1)]))
    assert count_operations(alone, 0) == count_operations(alone) == 2
