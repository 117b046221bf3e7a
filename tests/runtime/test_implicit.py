"""Implicit steps: coefficients, linear algebra, Jacobians, order, stiff scenes, and everything a method owes a run."""

import ctypes
import math
import re
from collections.abc import Callable
from pathlib import Path

import casadi as ca
import mpmath as mp
import numpy as np
import pytest

import lagrangia as lag
from helpers.native_models import FOLDER, OSCILLATOR, compiled
from lagrangia.compile.pipeline import compile_file
from lagrangia.native.build import build, find_compiler
from lagrangia.run.engines import load_engine
from lagrangia.run.library import Runtime
from lagrangia.run.request import check_values
from lagrangia.run.runtime import Rows, Settings, Solver, Status
from whole import test_cases

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
Write = Callable[[str], lag.Model]


def march(model: lag.Model, times: list[float], q: dict[str, float] | None = None, **settings: float) -> tuple[Rows, object]:
    """Rows of a run by implicit steps, and its statistics: closer to the run time than Model.simulate."""
    engine = load_engine(model.scene, solver=Solver.IMPLICIT)
    assert engine is not None
    values = check_values(model.scene, initial=q)
    with engine.runtime.run(engine.model, Settings(t_stop=times[-1], solver=Solver.IMPLICIT, **settings)) as run:
        run.set_parameters(values.parameters, values.mask)
        assert run.start(values.q, values.v) is Status.OK
        return run.advance(times), run.statistics


# --------------------------------------------------------------------------------------------------------- coefficients


def tableau(stages: int) -> dict[str, np.ndarray]:
    text = (FOLDER / "methods" / "radau_tableau.h").read_text()
    found = re.findall(rf"lag_radau{stages}_(\w+)\[\] = \{{(.*?)\}};", text, re.S)
    return {name: np.array([float(x) for x in body.split(",")]) for name, body in found}


@pytest.mark.parametrize("s", [3, 5, 7])
def test_coefficients_are_those_of_collocation(s: int) -> None:
    table = tableau(s)
    c, a, inverse = table["node"], table["a"].reshape(s, s), table["inverse"].reshape(s, s)
    polynomial = np.polynomial.Polynomial([0, 1]) ** (s - 1) * np.polynomial.Polynomial([-1, 1]) ** s
    assert np.abs(polynomial.deriv(s - 1)(c)).max() < 1e-11 * math.factorial(2 * s - 1) / math.factorial(s)
    for k in range(1, s + 1):
        assert a @ c ** (k - 1) == pytest.approx(c**k / k, abs=1e-15)
    for k in range(1, 2 * s):  # order 2 s - 1
        assert a[-1] @ c ** (k - 1) == pytest.approx(1 / k, abs=1e-15)
    assert abs(a[-1] @ c ** (2 * s - 1) - 1 / (2 * s)) > 1e-10
    assert c[-1] == 1  # the last stage is the end: stiffly accurate
    assert inverse @ a == pytest.approx(np.eye(s), abs=3e-14)


@pytest.mark.parametrize("s", [3, 5, 7])
def test_coefficients_take_the_stages_apart(s: int) -> None:
    table = tableau(s)
    blocks = np.zeros((s, s))
    blocks[0, 0] = table["eigenvalue"][0]
    for k in range(1, s, 2):
        re_, im = table["eigenvalue"][k : k + 2]
        blocks[k : k + 2, k : k + 2] = [[re_, -im], [im, re_]]
    back = table["from"].reshape(s, s)
    assert back @ table["to"].reshape(s, s) == pytest.approx(np.eye(s), abs=2e-13)
    assert back @ blocks @ table["to"].reshape(s, s) == pytest.approx(table["inverse"].reshape(s, s), abs=2e-12)


@pytest.mark.parametrize("s", [3, 5, 7])
def test_coefficients_of_error_and_inside(s: int) -> None:
    table = tableau(s)
    c, a = table["node"], table["a"].reshape(s, s)
    for k in range(1, s + 1):  # slopes t^(k - 1): Z = c^k / k
        assert (k == 1) + table["error"] @ (c**k / k) == pytest.approx(0, abs=1e-13 * np.abs(table["error"]).max())
    assert table["error"] @ a == pytest.approx(table["error_place"], abs=1e-13)
    legendre = table["legendre"].reshape(s + 1, s)
    for k in range(1, s + 1):
        series = np.polynomial.Legendre(legendre @ c**k, domain=[0, 1])
        x = np.linspace(0, 1, 7)
        assert series(x) == pytest.approx(x**k, abs=1e-14)


# -------------------------------------------------------------------------------------------------------- linear algebra

ELIMINATION = """
#include <stdlib.h>
#include "numbers/dense_lu.c"
#define length sparse_length
#define scale_rows sparse_scale_rows
#define subtract sparse_subtract
#define eliminate sparse_eliminate
#include "numbers/sparse_lu.c"
__attribute__((visibility("default"))) void solve_sparse(int size, int lower, int upper, const int *start, const int *row,
    const int *order, double *re, double *im, int times, double *x, double *y)
{
    LagSparseLu lu = {0};
    LagArena arena = {0};
    lag_sparse_lu_layout(&lu, size, lower, upper, &arena);
    arena.base = calloc(arena.used + 1, sizeof(double));
    arena.used = 0;
    lag_sparse_lu_layout(&lu, size, lower, upper, &arena);
    for (int i = 0; i < times; ++i, re += start[size], im += start[size], x += size, y += size) {
        const LagSparseMatrix matrix = {start, row, order, re, im};
        lag_sparse_lu_factor(&lu, &matrix);
        lag_sparse_lu_solve(&lu, order, x, y);
    }
    free(arena.base);
}
__attribute__((visibility("default"))) void solve_dense(int size, const double *re, const double *im, double *x, double *y)
{
    LagDenseLu lu = {0};
    LagArena arena = {0};
    lag_dense_lu_layout(&lu, size, im != NULL, &arena);
    arena.base = calloc(arena.used + 1, sizeof(double));
    arena.used = 0;
    lag_dense_lu_layout(&lu, size, im != NULL, &arena);
    for (int i = 0; i < size * size; ++i) {
        lu.re[i] = re[i];
        if (im)
            lu.im[i] = im[i];
    }
    lag_dense_lu_factor(&lu);
    lag_dense_lu_solve(&lu, x, im ? y : NULL);
    free(arena.base);
}
"""


@pytest.fixture(scope="module")
def elimination() -> ctypes.CDLL:
    return ctypes.CDLL(str(build("elimination", ELIMINATION, include=[FOLDER])))


def pointer(x: np.ndarray) -> ctypes.c_void_p:
    assert x.flags["C_CONTIGUOUS"]
    return x.ctypes.data_as(ctypes.c_void_p)


def solve_dense(library: ctypes.CDLL, matrix: np.ndarray, b: np.ndarray) -> np.ndarray:
    parts = [np.ascontiguousarray(part.T) for part in (matrix.real, matrix.imag)]
    x, y = np.array(b.real), np.array(b.imag)
    im = pointer(parts[1]) if np.iscomplexobj(matrix) else None
    library.solve_dense(len(b), pointer(parts[0]), im, pointer(x), pointer(y))
    return x + 1j * y if np.iscomplexobj(matrix) else x


def test_one_number_is_solved_with_the_digits_that_it_has_beside_another(elimination: ctypes.CDLL) -> None:
    for a in (3.0, -7e-11, 1e305, 1e-310, 0.0):
        pair = solve_dense(elimination, np.diag([a, 1.0]), np.array([0.1, 1.0]))
        np.testing.assert_array_equal(solve_dense(elimination, np.array([[a]]), np.array([0.1])), pair[:1])


def solve_sparse(library: ctypes.CDLL, sparsity: ca.Sparsity, matrices: list[np.ndarray], b: np.ndarray) -> np.ndarray:
    """One solution a matrix; all have the same pattern, and the factors of the first serve the others."""
    reflectors, upper, _, order = sparsity.qr_sparse(True)
    columns, rows = sparsity.get_triplet()[1], sparsity.row()
    values = np.array([m[rows, columns] for m in matrices])
    numbers = [np.array(x, dtype=np.int32) for x in (sparsity.colind(), rows, order)]
    re_, im, x, y = (np.ascontiguousarray(z) for z in (values.real, values.imag, np.tile(b.real, (len(matrices), 1)),
                                                       np.tile(b.imag, (len(matrices), 1))))
    library.solve_sparse(len(b), reflectors.nnz(), upper.nnz(), *map(pointer, numbers), pointer(re_), pointer(im), len(matrices),
                         pointer(x), pointer(y))
    return x + 1j * y


@pytest.mark.parametrize("size", [1, 2, 5, 30])
@pytest.mark.parametrize("kind", [float, complex])
def test_full_matrices(elimination: ctypes.CDLL, size: int, kind: type) -> None:
    random = np.random.default_rng(size)
    matrix = random.normal(size=(size, size)).astype(kind)
    if kind is complex:
        matrix += 1j * random.normal(size=(size, size))
    matrix *= 10.0 ** random.uniform(-8, 8, (size, 1))  # rows in units of their own
    x = random.normal(size=size).astype(kind)
    assert solve_dense(elimination, matrix, matrix @ x) == pytest.approx(x, rel=1e-9, abs=1e-10)


@pytest.mark.parametrize("size", [1, 3, 20, 150])
def test_sparse_matrices(elimination: ctypes.CDLL, size: int) -> None:
    """Unsymmetric, with empty diagonals, which pivoting must leave; three on one pattern, the last without its pivots."""
    random = np.random.default_rng(size)
    pattern = np.eye(size)[random.permutation(size)] + (random.random((size, size)) < 2 / size) > 0
    sparsity = ca.DM(pattern.astype(float)).sparsity().unite(ca.Sparsity.diag(size))
    matrices = [pattern * (random.normal(size=(size, size)) + 1j * random.normal(size=(size, size))) for _ in range(3)]
    matrices[2] = matrices[2] * np.where(np.eye(size) > 0, 1e-9, 1)
    b = random.normal(size=size) + 1j * random.normal(size=size)
    for x, matrix in zip(solve_sparse(elimination, sparsity, matrices, b), matrices, strict=True):
        scale = np.abs(matrix) @ np.abs(x) + np.abs(b)
        assert np.abs(matrix @ x - b).max() < 1e-11 * scale.max()


def constrained_matrix(random: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
    """Four coordinates, three constraints, of which the first and the last say the same in other units."""
    J = random.normal(size=(3, 4))
    J[2] = -1e4 * J[0]
    M = random.normal(size=(4, 4))
    matrix = np.block([[M @ M.T, J.T], [J, np.zeros((3, 3))]])
    return matrix, matrix @ np.append(random.normal(size=4), [0.3, 0, -0.7])


def test_what_repeats_another_constraint_is_left_out(elimination: ctypes.CDLL) -> None:
    for seed in range(20):
        matrix, b = constrained_matrix(np.random.default_rng(seed))
        full = np.diag([1.0] * 7) != 0
        sparsity = ca.DM((full | (matrix != 0)).astype(float)).sparsity()
        expected = np.linalg.lstsq(matrix, b, rcond=1e-12)[0][:4]
        for x in (solve_dense(elimination, matrix, b), solve_sparse(elimination, sparsity, [matrix, matrix], b)[1].real):
            assert x[:4] == pytest.approx(expected, rel=1e-8, abs=1e-9)
            assert matrix @ x == pytest.approx(b, rel=1e-8, abs=1e-7)


# ------------------------------------------------------------------------------------------------------------- Jacobians


@pytest.mark.parametrize(("file", "n"), [("double_pendulum", 2), ("four_bar", 1), ("chain", 12), ("n_four_bars", 3),
                                         ("quarter_car", 2), ("skate", 1), ("rolling_disc", 1)])
def test_the_matrix_of_a_step_is_that_of_the_accelerations(file: str, n: int) -> None:
    """(mu - J_v - J_q/mu) x = r by S0, S1, S2 and by the derivatives of the accelerations, on the constraints."""
    compilation = compile_file(EXAMPLES / f"{file}.lag", structural={"n": n} if file in ("chain", "n_four_bars") else {})
    scene, table = compilation.scene, compilation.functions.table
    model = lag.load(EXAMPLES / f"{file}.lag", **({"n": n} if file in ("chain", "n_four_bars") else {}))
    run = model.simulate(at=[0.31])
    q, v = ([run[c.name][-1] for c in columns] for columns in (scene.coordinates, scene.rates))
    p = model.parameter_values()
    c, d = table["hoist"](p), table["modes"](0.31, p, 0) if "modes" in table else ca.DM(0, 1)
    u = ca.DM.zeros(len(scene.inputs))
    a, _, multipliers = table["rhs"](0.31, q, v, u, d, c)
    parts = matrices(scene, table, [0.31, q, v, a, multipliers, u, d, c])
    jacobian = model.functions()["jacobian"](0.31, q, v, u, p).full()
    Jq, Jv = jacobian[:, : scene.n], jacobian[:, scene.n :]
    mu, r = 7.3 + 2.1j, np.cos(np.arange(scene.n) + 1.0)
    expected = np.linalg.solve(mu * np.eye(scene.n) - Jv - Jq / mu, r)
    whole = mu * parts[0] + parts[1] + parts[2] / mu
    found = np.linalg.lstsq(whole, parts[0][:, : scene.n] @ r, rcond=1e-13)[0][: scene.n]
    assert found == pytest.approx(expected, rel=1e-8, abs=1e-9)


def matrices(scene: object, table: dict[str, ca.Function], arguments: list) -> list[np.ndarray]:
    """S0, S1, S2, from values or from products with all directions."""
    size, n, entries = scene.n + scene.sizes["n_multipliers"], scene.n, scene.sizes["n_entries"]
    places = scene.patterns["jacobian_pattern"]
    pattern = ca.Sparsity(size, size, list(places[: size + 1]), list(places[size + 1 : size + 1 + entries]))
    if "jacobian" in table:
        return [ca.DM(pattern, part).full() for part in table["jacobian"](*arguments)]
    parts = [np.zeros((size, size)) for _ in range(3)]
    for k in range(n):
        along, still = np.eye(n)[k], np.zeros(n)
        parts[2][:, k] = table["tangent"](*arguments, along, still)[1].full().ravel()
        first, second = table["tangent"](*arguments, still, along)
        parts[0][:, k], parts[1][:, k] = first.full().ravel(), second.full().ravel()
    parts[1][:n, n:] = parts[0][n:, :n].T
    return parts


# ----------------------------------------------------------------------------------------------------------------- order


OSCILLATION = """model Oscillation
  Block block(m = 1, base = world, s(start = 1));
  SpringDamper spring(k = 3, c = 0.4, stretch = block.s);
end Oscillation;
"""


def pade(s: int, z: "mp.matrix") -> "mp.matrix":
    """The stability function of the method with s stages: the Pade approximation (s - 1, s) of exp."""
    numerator, denominator = mp.pade(mp.taylor(mp.exp, 0, 2 * s), s - 1, s)
    powers = [z**k for k in range(s + 1)]
    top, bottom = (sum((x * powers[k] for k, x in enumerate(poly)), mp.zeros(2)) for poly in (numerator, denominator))
    return bottom**-1 * top


@pytest.mark.parametrize("h", [0.05, 0.2, 0.5])
def test_steps_on_linear_scenes_are_rational_functions(scene: Write, h: float) -> None:
    """Exactly: ten steps with 3 stages, then ten with 5, then 7, as contraction allows; order and damping follow."""
    model = scene(OSCILLATION)
    times = [h * k for k in range(1, 36)]
    rows, statistics = march(model, times, tolerance=0.5, first_step=h, max_step=h)
    assert statistics.steps == len(times)
    with mp.workdps(30):
        y = mp.matrix([1, 0])
        step = {s: pade(s, mp.matrix([[0, h], [-3 * h, -0.4 * h]])) for s in (3, 5, 7)}
        for k in range(len(times)):
            y = step[3 if k < 10 else 5 if k < 20 else 7] * y
            assert rows[k][1:3].tolist() == pytest.approx([float(x) for x in y], abs=3e-13)


@pytest.mark.parametrize("name", ["four_bar", "chain", "slider_crank", "andrews_squeezer"])
def test_the_error_falls_with_the_tolerance(name: str) -> None:
    model = lag.load(EXAMPLES / f"{name}.lag")
    stop = model.scene.stop / 5
    at = np.linspace(0, stop, 12)
    exact = model.simulate(at=at, tolerance=1e-13, solver="erk")
    for tolerance in (1e-4, 1e-6, 1e-8, 1e-10):
        run = model.simulate(at=at, tolerance=tolerance, solver="implicit")
        for column in model.scene.coordinates:
            size = np.abs(exact[column.name]).max()
            assert np.abs(run[column.name] - exact[column.name]).max() < 5 * tolerance * size
        assert run.statistics.constraint_residual < 1e-13


KNOWN = ("msl_double_pendulum", "quarter_car_bus_ctms", "stiff_spring_pendulum", "msl_pendulum_spring_damper",
         "cart_pole_barto_sutton", "linear_2dof_vibration")


@pytest.mark.parametrize("case", [case for case in test_cases.CASES if case.file in KNOWN], ids=str)
def test_known_problems(case: test_cases.Case) -> None:
    reference = test_cases.columns(case)
    sizes = test_cases.amplitudes(case)
    for tolerance in (1e-6, 1e-9, 1e-12):
        run = test_cases.scene(case).simulate(at=reference["t"], tolerance=tolerance, solver="implicit")
        worst = max(np.abs(run[name] - reference[name]).max() / size for name, size in sizes.items())
        assert worst < max(30 * case.constant * tolerance, 1e-13)


# ---------------------------------------------------------------------------------------------------------- stiff scenes

FOLLOWER = """model Follower "The spring and the damper force the block to follow a known motion: sin(t)"
  parameter Stiffness k = 1e6; parameter Damping c = 1e3; parameter Length A = 1; parameter AngularVelocity w = 1;
  Block block(m = 1, base = world, s(start = 0));
  SpringDamper tie(k = k, c = c, stretch = block.s - A*sin(w*time));
  AppliedForce force(at = block.center, force = {-A*w^2*block.m*sin(w*time), 0});
initial equation
  block.v = A*w;
end Follower;
"""


@pytest.mark.parametrize("k", [1e2, 1e6, 1e10, 1e14])
@pytest.mark.parametrize("damping", [0, 2, 200])
def test_stiff_ties_cost_no_steps(scene: Write, k: float, damping: float) -> None:
    """A. Prothero, A. Robinson (1974), for a second-order equation: s'' = -k (s - sin t) - c (s' - cos t) - sin t."""
    model = scene(FOLLOWER)
    at = np.linspace(0, 10, 101)
    run = model.simulate(at=at, tolerance=1e-9, parameters={"k": k, "c": damping * math.sqrt(k)}, solver="implicit")
    assert np.abs(run["block.s"] - np.sin(at)).max() < 1e-9
    assert np.abs(run["block.v"] - np.cos(at)).max() < 3e-8
    assert run.statistics.steps < 150


DRIVEN = """model Driven "Pulled by a chirp, then let go; a stiff cubic spring and a damper, and an input"
  parameter Stiffness k = 1e5; parameter Damping c = 30;
  input Force F = 0;
  Block block(m = 1, base = world, s(start = 0.01));
  DuffingSpring spring(k = k, k3 = 1e7, stretch = block.s);
  Damper damper(c = c, rate = der(block.s));
  AppliedForce force(at = block.center, force = {if time < 0.5 then 200 + F else F, 0});
end Driven;
"""


def test_the_energy_account_closes(scene: Write) -> None:
    model = scene(DRIVEN)
    for tolerance in (1e-6, 1e-9, 1e-12):
        run = model.simulate(stop=1, tolerance=tolerance, solver="implicit", inputs=([0, 0.2, 0.7], {"F": [0, 50, -20]}))
        assert run.statistics.events == 3
        assert run.energy.dissipated[-1] > 0.1
        assert np.abs(run.energy.residual).max() < 10 * tolerance * run.statistics.energy_scale


def test_events_and_inputs_are_met_exactly(scene: Write) -> None:
    model, at = scene(DRIVEN), [0.2, 0.5, 0.50001, 0.7, 1]
    inputs = ([0, 0.2, 0.7, 0.7], {"F": [0, 50, -20, 300]})
    exact = model.simulate(at=at, tolerance=1e-13, solver="erk", inputs=inputs)
    run = model.simulate(at=at, tolerance=1e-10, solver="implicit", inputs=inputs)
    assert run["block.s"] == pytest.approx(exact["block.s"], abs=1e-10 * np.abs(exact["block.s"]).max())


def test_rows_and_pauses_change_nothing() -> None:
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    at = [0.03 * k for k in range(60)]
    whole, _ = march(model, at, tolerance=1e-8)
    engine = load_engine(model.scene, solver=Solver.IMPLICIT)
    values = check_values(model.scene)
    with engine.runtime.run(engine.model, Settings(t_stop=at[-1], tolerance=1e-8, solver=Solver.IMPLICIT)) as run:
        run.set_parameters(values.parameters, values.mask)
        for _ in range(2):  # a run may be started again
            run.start()
            pieces = [run.advance([t], seconds=1e-9) for t in at]
            while pieces[-1].status is Status.PAUSED:
                pieces[-1] = run.advance([at[-1]])
        for k, piece in enumerate(pieces):
            assert piece.count == 0 or piece[0].tolist() == whole[k].tolist()
        assert sum(piece.count for piece in pieces) > 50


def test_the_end_may_move_and_parameters_change(scene: Write) -> None:
    """As in a co-simulation."""
    model = scene(DRIVEN)
    exact = model.simulate(at=[0.1, 0.2, 0.3], tolerance=1e-13, solver="erk")
    engine, values = load_engine(model.scene, solver=Solver.IMPLICIT), check_values(model.scene)
    with engine.runtime.run(engine.model, Settings(t_stop=0, tolerance=1e-10, solver=Solver.IMPLICIT)) as run:
        run.set_parameters(values.parameters, values.mask)
        run.start(values.q, values.v)
        for k in range(300):
            run.set_stop((k + 1) / 1000)
            row = run.advance([(k + 1) / 1000])[0]
        assert row[1] == pytest.approx(exact["block.s"][-1], abs=1e-9)
        names = [p.name for p in model.scene.parameters]
        run.set_parameters([1e-9 if name == "c" else x for name, x in zip(names, values.parameters, strict=True)], values.mask)
        run.set_stop(0.4)
        run.advance([0.4])
        assert run.statistics.energy_residual < 1e-8 * run.statistics.energy_scale


def test_large_stiff_scenes_take_sparse_matrices(scene: Write) -> None:
    """A row of 60 masses tied by stiff dampers: eliminated sparse, it moves as the matrix exponential says."""
    n = 60
    ties = "\n".join(f"  SpringDamper s{i}(k = 1e4, c = 1e4, stretch = b[{i + 1}].s - b[{i}].s);" for i in range(1, n))
    model = scene(f"""model Row
  Block b[{n}](each m = 1, each base = world);
  SpringDamper wall(k = 1e4, c = 1, stretch = b[1].s);
{ties}
initial equation
  b[{n}].s = 1;
end Row;
""")
    assert model.completed().scene.sizes["n_lower"] > 0
    tie = 2 * np.eye(n) - np.eye(n, k=1) - np.eye(n, k=-1)
    tie[0, 0] = tie[-1, -1] = 1
    K, C = 1e4 * tie, 1e4 * tie
    K[0, 0] += 1e4
    C[0, 0] += 1
    from scipy.linalg import expm

    exact = expm(np.block([[np.zeros((n, n)), np.eye(n)], [-K, -C]]) * 0.7)[:, n - 1]
    run = model.simulate(at=[0.7], tolerance=1e-9, solver="implicit")
    assert [run[f"b[{i + 1}].s"][-1] for i in range(n)] == pytest.approx(exact[:n], abs=1e-9)
    assert run.statistics.steps < 300


# --------------------------------------------------------------------------------------------------------------- hygiene


def test_a_model_without_the_matrix_is_refused(runtime: Runtime) -> None:
    with runtime.run(compiled(1, rhs=OSCILLATOR), Settings(t_stop=1, solver=Solver.IMPLICIT)) as run:
        run.set_parameters()
        assert run.start() is Status.BAD_SETTINGS


def test_a_singularity_ends_the_run(scene: Write) -> None:
    model = scene("""model Fall "into a centre of attraction"
  parameter Real k(unit = "N.m2") = 1;
  Block block(m = 1, base = world, s(start = 1));
  AppliedForce pull(at = block.center, force = {-k/block.s^2, 0});
end Fall;
""")
    with pytest.raises(lag.RunError, match="no step is small enough") as error:
        model.simulate(stop=2, tolerance=1e-9, solver="implicit")
    assert error.value.trajectory.time[-1] < math.pi / (2 * math.sqrt(2))


def test_more_code_is_compiled_when_implicit_steps_are_asked_for() -> None:
    """Long Jacobians are data otherwise; both give the same motion."""
    model = lag.load(EXAMPLES / "chain.lag", n=4)
    runs = []
    for solver in (Solver.AUTO, Solver.IMPLICIT):
        engine, values = load_engine(model.scene, solver=solver), check_values(model.scene)
        with engine.runtime.run(engine.model, Settings(t_stop=1, solver=Solver.IMPLICIT)) as run:
            run.set_parameters(values.parameters, values.mask)
            run.start(values.q, values.v)
            runs.append(run.advance([1])[0].tolist())
    assert runs[0] == pytest.approx(runs[1], rel=1e-12, abs=1e-12)
    assert runs[0][0] == 1


@pytest.mark.parametrize("tolerance", [1e-3, 1e-7])
def test_what_hardly_moves_at_first_does_not_hold_up_the_rest(tolerance: float) -> None:
    """From rest, the rates of the last links begin at 1e-30 of those of the first: they count as much as these let them."""
    model = lag.load(EXAMPLES / "chain.lag", n=60)
    runs = [model.simulate(stop=0.5, tolerance=tolerance, solver="implicit"), model.simulate(stop=0.5, tolerance=1e-11)]
    assert runs[0].statistics.rejected < 12
    assert runs[0].statistics.smallest_step > 1e-5
    for k in (1, 30, 60):
        assert runs[0][f"hinge[{k}].phi"] == pytest.approx(runs[1][f"hinge[{k}].phi"], abs=30 * tolerance)


@pytest.mark.parametrize("what", ["Revolute h(a = world, phi(start = -0.5)); PointMass p(m = 1, center = shift(h.b, {0, -1})); "
                                  "DryFriction f(F = 0, rate = h.w*1[m]);",
                                  "Block b(m = 1, base = turn(world, 0), s(start = 0.3)); "
                                  "AppliedForce f(at = b.center, force = {-9.81*sin(1[rad/m]*b.s), 0});"])
@pytest.mark.parametrize("stop", [1e4, 10820.0582, 5.24e5, 1e6])
def test_motion_is_the_same_however_far_it_goes_on(scene: Write, what: str, stop: float) -> None:
    """First steps are the longer the later a run ends, and stages a whole number of turns apart see one and the same force."""
    model = scene(f"model Far {what} end Far;")
    right = model.simulate(at=[0.5, 2.0], tolerance=1e-10)
    with pytest.raises(lag.RunError, match="limit of steps") as stopped:
        model.simulate(at=[0.5, 2.0, stop], tolerance=1e-3, solver="implicit", max_steps=60)
    run = stopped.value.trajectory
    name = model.coordinate_names[0]
    assert run[name] == pytest.approx(right[name], abs=1e-2)
