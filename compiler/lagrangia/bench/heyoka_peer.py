"""heyoka's adaptive Taylor method on our equations: CasADi's instructions become heyoka's expressions.

Source: Biscani, Izzo, Revisiting high-order Taylor methods for astrodynamics and celestial mechanics (2021).
"""

from collections.abc import Callable, Mapping
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from lagrangia.bench.peers import Prepared, Unsuitable
from lagrangia.bench.problem import Problem

if TYPE_CHECKING:
    from numpy.typing import NDArray

_LARGEST_UNROLLED = 700  # instructions: twice as fast as compact mode, but LLVM takes minutes for 1400


def prepare_heyoka(problem: Problem, tolerance: float) -> Prepared:
    """heyoka's adaptive Taylor integrator for a scene, compiled. Raises Unsuitable."""
    import heyoka

    integrators = []
    for piece in problem.pieces:
        names = [f"y{k}" for k in range(2 * problem.n)]
        variables = heyoka.make_vars(*names)
        slopes = translate(piece.slope, [[heyoka.time], variables])
        is_large = piece.slope.n_instructions() > _LARGEST_UNROLLED
        integrators.append(heyoka.taylor_adaptive(list(zip(variables, slopes, strict=True)), [0.0] * len(names), time=piece.begin,
                                                  tol=max(tolerance, float(np.finfo(float).eps)), compact_mode=is_large))

    def begin() -> None:
        for piece, integrator in zip(problem.pieces, integrators, strict=True):
            integrator.time = piece.begin
        integrators[0].state[:] = problem.start

    def run(_: Any) -> "list[NDArray[Any]]":
        portions: list[NDArray[Any]] = []
        for piece, integrator in zip(problem.pieces, integrators, strict=True):
            if portions:
                integrator.state[:] = portions[-1][-1]
            outcome, *_, states = integrator.propagate_grid([piece.begin, *piece.grid])
            if outcome != heyoka.taylor_outcome.time_limit:
                raise ArithmeticError(f"heyoka stopped: {outcome}")
            portions.append(states[1:])
        return portions

    return Prepared(run, problem.collect, begin)


def translate(function: ca.Function, inputs: list[list[Any]]) -> list[Any]:
    """The elements of the first output as expressions of heyoka. Raises Unsuitable for an operation it lacks."""
    import heyoka

    operations = _operations(heyoka)
    work: list[Any] = [None] * max(1, function.sz_w())
    found: list[Any] = [heyoka.expression(0.0)] * function.numel_out(0)
    for k in range(function.n_instructions()):
        op, read, write = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            work[write[0]] = inputs[read[0]][read[1]]
        elif op == ca.OP_CONST:
            work[write[0]] = heyoka.expression(function.instruction_constant(k))
        elif op == ca.OP_OUTPUT:
            found[write[1]] = work[read[0]]
        elif op in operations:
            work[write[0]] = operations[op](*(work[place] for place in read))
        else:
            raise Unsuitable(f"heyoka lacks the operation {op} of CasADi")
    return found


def _operations(hy: Any) -> Mapping[int, Callable[..., Any]]:
    zero, one = hy.expression(0.0), hy.expression(1.0)
    plain = {"SIN": hy.sin, "COS": hy.cos, "TAN": hy.tan, "ASIN": hy.asin, "ACOS": hy.acos, "ATAN": hy.atan, "ATAN2": hy.atan2,
             "SINH": hy.sinh, "COSH": hy.cosh, "TANH": hy.tanh, "ASINH": hy.asinh, "ACOSH": hy.acosh, "ATANH": hy.atanh,
             "EXP": hy.exp, "LOG": hy.log, "SQRT": hy.sqrt, "ERF": hy.erf, "LT": hy.lt, "LE": hy.lte, "EQ": hy.eq, "NE": hy.neq}
    made: dict[str, Callable[..., Any]] = {
        "ASSIGN": lambda a: a, "ADD": lambda a, b: a + b, "SUB": lambda a, b: a - b, "MUL": lambda a, b: a * b,
        "DIV": lambda a, b: a / b, "NEG": lambda a: -a, "SQ": lambda a: a * a, "TWICE": lambda a: 2.0 * a,
        "INV": lambda a: 1.0 / a, "POW": lambda a, b: a**b, "CONSTPOW": lambda a, b: a**b,
        "FABS": lambda a: hy.select(hy.lt(a, zero), -a, a), "FMIN": lambda a, b: hy.select(hy.lt(a, b), a, b),
        "FMAX": lambda a, b: hy.select(hy.lt(a, b), b, a), "NOT": lambda a: hy.eq(a, zero),
        "AND": lambda a, b: hy.logical_and([a, b]), "OR": lambda a, b: hy.logical_or([a, b]),
        "IF_ELSE_ZERO": lambda a, b: hy.select(a, b, zero),
        "SIGN": lambda a: hy.select(hy.lt(a, zero), -one, hy.select(hy.eq(a, zero), zero, one)),
    }
    return {getattr(ca, f"OP_{name}"): make for name, make in {**plain, **made}.items()}
