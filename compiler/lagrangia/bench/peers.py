"""The solvers a benchmark measures: ours, CasADi's and SciPy's. heyoka's is in heyoka_peer.py.

A solver prepares a run at a tolerance: everything that is done once (compiling, setting options) happens there. `Prepared.run` is
what is timed: the integration from the start to the last output time, and nothing else. `Prepared.read` makes positions of what
the run returned.
"""

import math
import shlex
import time
from array import array
from collections.abc import Callable
from dataclasses import field, replace
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import casadi as ca
import numpy as np

from lagrangia.algebra.pointers import Pointer
from lagrangia.base.records import dataclass
from lagrangia.bench.problem import Piece, Problem
from lagrangia.native.build import build, find_compiler
from lagrangia.run.request import check_values
from lagrangia.run.runtime import Run, Status
from lagrangia.run.simulate import explain, start_run

if TYPE_CHECKING:
    from numpy.typing import NDArray

_MOST_STEPS = 10_000_000
_LEVEL = "-O3"
# erk: explicit Runge-Kutta 5(4); rosenbrock: order 5(4); cvodes, idas: BDF of SUNDIALS; adams: Adams' methods of CVODES.
CASADI_METHODS = ("erk", "rosenbrock", "cvodes", "adams", "idas")
SCIPY_METHODS = ("DOP853", "Radau", "LSODA")
_EXPORT = "#define GCC_HASCLASSVISIBILITY\n"  # so that CasADi marks what is seen from outside


class Unsuitable(Exception):
    """The solver cannot represent the scene, with the reason."""


@dataclass(frozen=True)
class Prepared:
    """A solver that has compiled all it can before its time is taken."""

    run: Callable[[Any], Any]  # of what `begin` made
    read: "Callable[[Any], NDArray[Any]]"  # (len(times), n) of what `run` returned
    begin: Callable[[], Any] = field(default=lambda: None)  # before each run, not timed


@dataclass(frozen=True)
class Solver:
    """`prepare(problem, tolerance)` raises Unsuitable. `package` must be installed."""

    name: str
    package: str
    prepare: Callable[[Problem, float], Prepared]

    @property
    def version(self) -> str | None:
        """None when its package is not installed."""
        try:
            return version(self.package)
        except PackageNotFoundError:
            return "from its sources" if self.is_ours else None

    @property
    def is_ours(self) -> bool:
        """Whether it is one of this product's."""
        return self.package == "lagrangia"


# -------------------------------------------------------------------- ours


def prepare_ours(solver: str, problem: Problem, tolerance: float) -> Prepared:
    """Our own run of the scene, with its rows. Raises Unsuitable."""
    scene, engine, times = problem.model.scene, problem.model.engine, array("d", problem.times)
    if solver in scene.refused:
        raise Unsuitable(scene.refused[solver])
    if engine is None:
        raise Unsuitable("no C compiler was found")
    experiment = replace(problem.experiment, tolerance=tolerance, solver=solver)
    values = check_values(scene, problem.parameters)
    one = start_run(scene, engine, experiment, values)

    def begin() -> Run:
        one.start(values.q, values.v)
        return one

    def advance(run: Run) -> Any:
        rows = run.advance(times)
        if rows.status is not Status.OK:
            raise ArithmeticError(explain(scene, run.failure))
        return rows.values

    def read(rows: Any) -> "NDArray[Any]":
        return np.asarray(rows).reshape(len(times), -1)[:, 1 : 1 + problem.n]

    return Prepared(advance, read, begin)


# -------------------------------------------------------------------- CasADi


def prepare_casadi(name: str, problem: Problem, tolerance: float) -> Prepared:
    """erk and rosenbrock are written out as C with their equations; cvodes and idas call compiled equations.

    idas gets closed loops as the index-1 system M a + h + J^T lambda = 0, J a + bias = 0, a and lambda algebraic.
    """
    solvers = [Pointer(_integrator(name, piece, problem, tolerance)) for piece in problem.pieces]

    def run(_: Any) -> "list[NDArray[Any]]":
        y, portions = problem.start, []
        for solve in solvers:
            portions.append(solve(y).reshape(-1, y.size))
            y = portions[-1][-1]
        return portions

    return Prepared(run, problem.collect)


def _integrator(name: str, piece: Piece, problem: Problem, tolerance: float) -> ca.Function:
    """A function of the start that gives the states on the piece's grid as columns."""
    t, y = ca.SX.sym("t"), ca.SX.sym("y", piece.slope.numel_in(1))
    options: dict[str, Any] = {"abstol": tolerance, "reltol": tolerance, "max_num_steps": _MOST_STEPS}
    is_written_out = name in ("erk", "rosenbrock")
    if not is_written_out:
        compiler = find_compiler()
        if compiler is None:
            raise Unsuitable("no C compiler was found")
        options |= {"jit": True, "compiler": "shell",
                    "jit_options": {"compiler": shlex.join(compiler.command), "flags": [_LEVEL], "verbose": False}}
    if name == "adams":
        options |= {"linear_multistep_method": "adams", "nonlinear_solver_iteration": "functional"}
    method = {"adams": "cvodes"}.get(name, name)
    equations = {"t": t, "x": y, "ode": piece.slope(t, y)}
    guess: dict[str, Any] = {}
    if name == "idas" and problem.is_constrained:
        equations, z0 = _implicit(problem, t, y)
        guess, options = {"z0": z0}, options | {"calc_ic": True, "suppress_algebraic": True}
    integrator = ca.integrator("run", method, equations, piece.begin, piece.grid, options)
    x = ca.MX.sym("x", y.numel())
    function = ca.Function("run", [x], [integrator(x0=x, **guess)["xf"]])
    return compiled(function) if is_written_out else function


def _implicit(problem: Problem, t: ca.SX, y: ca.SX) -> tuple[dict[str, ca.SX], Any]:
    """The equations with accelerations and multipliers unknown, and a guess of these."""
    n, functions = problem.n, problem.model.functions(given=problem.parameters)
    p = problem.model.parameter_values(problem.parameters)
    u = ca.DM(list(check_values(problem.model.scene).input_values))
    M, h, J, bias = (functions[name](t, y[:n], y[n:], u, p) for name in ("M", "h", "J", "bias"))
    a, forces = ca.SX.sym("a", n), ca.SX.sym("forces", J.size1())
    alg = ca.vertcat(M @ a + h + J.T @ forces, J @ a + bias)
    z0 = ca.vertcat(*[functions[name](problem.pieces[0].begin, problem.start[:n], problem.start[n:], u, p)
                      for name in ("rhs", "lambda")])
    return {"t": t, "x": y, "z": ca.vertcat(a, forces), "ode": ca.vertcat(y[n:], a), "alg": alg}, z0


def compiled(function: ca.Function, level: str = _LEVEL) -> ca.Function:
    """The same function, compiled by the C compiler."""
    generator = ca.CodeGenerator("function.c", {"casadi_int": "long long int"})
    generator.add(function, True)
    return ca.external(function.name(), str(build("function", _EXPORT + generator.dump(), level=level)))


# -------------------------------------------------------------------- SciPy


def prepare_scipy(method: str, problem: Problem, tolerance: float, seconds: float = math.inf) -> Prepared:
    """The equations, and for implicit methods their Jacobian, are compiled and called through pointers. A run that takes longer
    than `seconds` raises TimeoutError."""
    from scipy.integrate import solve_ivp

    is_implicit = method == "Radau"
    pieces = [(p, Pointer(compiled(p.slope)), {"jac": _jacobian(p)} if is_implicit else {}) for p in problem.pieces]

    def run(_: Any) -> Any:
        y, portions, deadline = problem.start, [], time.perf_counter() + seconds
        for piece, pointer, extra in pieces:
            slope = pointer if seconds == math.inf else _until(deadline, pointer)
            found = solve_ivp(slope, (piece.begin, piece.end), y, method, t_eval=piece.grid, rtol=max(tolerance, 2.3e-14),
                              atol=tolerance, **extra)
            if not found.success:
                raise ArithmeticError(found.message)
            portions.append(found.y)
            y = found.y[:, -1]
        return portions

    return Prepared(run, lambda portions: problem.collect([states.T for states in portions]))


def _until(deadline: float, slope: "Pointer") -> "Callable[..., NDArray[Any]]":
    def limited(*values: Any) -> "NDArray[Any]":
        if time.perf_counter() > deadline:
            raise TimeoutError
        return slope(*values)

    return limited


def _jacobian(piece: Piece) -> "Callable[[float, NDArray[Any]], NDArray[Any]]":
    t, y = ca.SX.sym("t"), ca.SX.sym("y", piece.slope.numel_in(1))
    jacobian = ca.densify(ca.jacobian(piece.slope(t, y), y))
    by_columns = Pointer(compiled(ca.Function("jacobian", [t, y], [ca.cse(jacobian)])))
    return lambda t, y: by_columns(t, y).T


__all__ = ["Pointer", "Prepared", "Solver", "Unsuitable", "compiled"]
