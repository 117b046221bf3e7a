"""What large functions compute of parameters alone is taken out of their tapes, in Python and by the run time alike."""

import casadi as ca
import numpy as np
import pytest

from lagrangia.compile import hoisted_tapes, hoisting, instructions
from lagrangia.compile.functions import Functions
from lagrangia.compile.hoisted_tapes import tapes_of
from lagrangia.compile.hoisting import hoist
from lagrangia.compile.instructions import count_operations
from lagrangia.native.tapes import Op, Tape
from lagrangia.run.interpret import evaluate
from lagrangia.run.library import start_runtime

X, P = ca.SX.sym("x", 2), ca.SX.sym("p", 3)
SMALL = ca.sin(X[0]) * P[0] * 2 / P[1]
LARGE = ca.vertcat(
    X[0] * ca.sin(P[0] * 3) + X[1] * (P[1] - ca.cos(P[2])), P[0] * 3 - P[1], ca.cos(P[2]) * X[1] + (P[2] + 2.5) * X[0], P[1], 4.0,
    ca.atan2(X[0], -0.0) + 2 * P[0] / P[1] * X[1], X[0] + 0.5,
)


def made(groups: list[ca.SX], monkeypatch: pytest.MonkeyPatch) -> Functions:
    """Functions f0, f1, ... of x, c, of which those of more than 12 nodes are large."""
    monkeypatch.setattr(hoisting, "_MOST_OPERATIONS", 12)
    found = hoist([[group] for group in groups], P)
    table = {"hoist": ca.Function("hoist", [P], [found.values], ["p"], ["c"]), "other": ca.Function("other", [X], [2 * X])}
    table |= {f"f{k}": ca.Function(f"f{k}", [X, found.c], [e], ["x", "c"], ["y"]) for k, e in enumerate(found.expressions)}
    return Functions(table, (), (), 0, False, {}, {}, {}, None, found.settled)


def told(tape: Tape) -> tuple[object, ...]:
    return list(tape.in_sizes), list(tape.out_sizes), tape.n_work, tape.code, tape.constants.tobytes()


@pytest.mark.parametrize("groups", [[LARGE], [SMALL, LARGE], [LARGE, SMALL, 2 * LARGE], [SMALL]])
def test_the_run_time_and_python_take_out_the_same(groups: list[ca.SX], monkeypatch: pytest.MonkeyPatch) -> None:
    functions = made(groups, monkeypatch)
    assert start_runtime().library  # it is there
    tapes = tapes_of(functions)
    for module in (hoisted_tapes, instructions):
        monkeypatch.setattr(module, "find_runtime", lambda: None)
    assert {name: told(tape) for name, tape in tapes.items()} == {name: told(tape) for name, tape in tapes_of(functions).items()}
    x, p = [0.3, -1.2], [1.5, 0.4, -2.0]
    (c,) = evaluate(tapes["hoist"], p)
    for k, group in enumerate(groups):
        (found,) = evaluate(tapes[f"f{k}"], x, c)
        assert found == pytest.approx(np.array(ca.Function("g", [X, P], [group])(x, p)).ravel().tolist(), rel=1e-15)
    assert evaluate(tapes["other"], x) == [[0.6, -2.4]]


def test_nothing_is_left_that_parameters_decide(monkeypatch: pytest.MonkeyPatch) -> None:
    tapes = tapes_of(made([LARGE, ca.vertcat(LARGE, P[0])], monkeypatch))
    assert count_operations(tapes["f0"]) == 10  # five products, four sums, an angle
    assert Op.SIN not in tapes["f0"].code[::4] and Op.SIN in tapes["hoist"].code[::4]
    assert tapes["f1"].in_sizes == tapes["f0"].in_sizes == [2, *tapes["hoist"].out_sizes] == [2, 8]
    assert tapes["f1"].out_sizes == [8]
