"""rumoca, a Modelica compiler: our equations, written out as a flat Modelica model."""

from typing import Any

import casadi as ca
import numpy as np

from lagrangia.bench.peers import Prepared, Solver, Unsuitable
from lagrangia.bench.problem import Problem

_LARGEST = 3_000  # instructions: beyond, rumoca takes minutes to compile
_TEXT = {
    "ASSIGN": "{0}", "ADD": "{0} + {1}", "SUB": "{0} - {1}", "MUL": "{0}*{1}", "DIV": "{0}/{1}", "NEG": "-{0}", "SQ": "{0}*{0}",
    "TWICE": "2.0*{0}", "INV": "1.0/{0}", "SQRT": "sqrt({0})", "SIN": "sin({0})", "COS": "cos({0})", "TAN": "tan({0})",
    "EXP": "exp({0})", "LOG": "log({0})", "ATAN2": "atan2({0}, {1})", "CONSTPOW": "{0}^{1}", "POW": "{0}^{1}",
}


def prepare(problem: Problem, tolerance: float) -> Prepared:
    import rumoca

    if len(problem.pieces) > 1:
        raise Unsuitable("events in time are not written out")
    model = rumoca.Session().loads(write_modelica(problem), model="Scene")
    config = rumoca.SimConfig(rtol=tolerance, atol=tolerance)
    names = [f"y{k}" for k in range(problem.n)]
    begin, end = problem.experiment.start, problem.times[-1]
    gap = (end - begin) / len(problem.times)

    def run(_: Any) -> Any:
        return model.simulate(t=(begin, end), dt=gap, config=config)

    return Prepared(run, lambda result: np.array(result.to_numpy(names)).T[1:])


SOLVER = Solver("rumoca", "rumoca", prepare)


def write_modelica(problem: Problem) -> str:
    """One variable an instruction."""
    function: ca.Function = problem.pieces[0].slope
    if function.n_instructions() > _LARGEST:
        raise Unsuitable("rumoca takes minutes to compile it")
    operations = {getattr(ca, f"OP_{name}"): text for name, text in _TEXT.items()}
    declarations = [f"  Real y{k}(start = {value!r}, fixed = true);" for k, value in enumerate(problem.start.tolist())]
    equations, work = [], [""] * max(1, function.sz_w())
    for k in range(function.n_instructions()):
        op, read, write = function.instruction_id(k), function.instruction_input(k), function.instruction_output(k)
        if op == ca.OP_INPUT:
            work[write[0]] = "time" if read[0] == 0 else f"y{read[1]}"
        elif op == ca.OP_CONST:
            work[write[0]] = f"({function.instruction_constant(k)!r})"
        elif op == ca.OP_OUTPUT:
            equations.append(f"  der(y{write[1]}) = {work[read[0]]};")
        elif op in operations:
            declarations.append(f"  Real w{k};")
            equations.append(f"  w{k} = {operations[op].format(*(work[place] for place in read))};")
            work[write[0]] = f"w{k}"
        else:
            raise Unsuitable(f"the operation {op} of CasADi is not written out")
    return "\n".join(["model Scene", *declarations, "equation", *equations, "end Scene;", ""])
