"""The matrix exponential: closed forms, 50-digit exponentials, resonance, pieces of loads, inputs, and what is not linear."""

import math
from collections.abc import Callable, Sequence
from itertools import pairwise
from pathlib import Path
from typing import Any

import mpmath as mp
import numpy as np
import pytest

import lagrangia as lag
from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.base.diagnostics import LagError
from lagrangia.native.build import find_compiler
from lagrangia.native.c_code import write_c
from lagrangia.run.request import check_values
from lagrangia.run.runtime import Run, Settings, Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

Scene = Callable[[str], lag.Model]
EPS = np.finfo(float).eps


def bound(omega: float, t: float) -> float:
    """The error allowed, relative to the largest position or rate."""
    return max(1e-12, 100 * EPS * omega * t)


def started(model: lag.Model, stop: float, parameters: dict[str, float] | None = None, start: float = 0.0,
            initial: dict[str, float] | None = None, **settings: Any) -> Run:
    engine = model.engine
    assert engine is not None
    values = check_values(model.scene, parameters, initial)
    run = engine.runtime.run(engine.model, Settings(start, stop, solver=Solver.LINEAR, **settings))
    run.set_parameters(values.parameters, values.mask)
    assert run.start(values.q, values.v) is Status.OK
    return run


def states(model: lag.Model, times: Sequence[float], **given: Any) -> np.ndarray:
    """Rows (q, v) at the times, by the solver `linear`."""
    with started(model, times[-1], **given) as run:
        rows = run.advance(np.array(times, dtype=float))
        assert rows.status is Status.OK, rows.status
        return np.array(rows.values).reshape(len(times), -1)[:, 1 : 1 + 2 * model.scene.n]


# ---------------------------------------------------------------- against exponentials in 50 digits


def exponential(A: Any, t: float) -> Any:
    """exp(A t) by scaling and squaring, with 25 digits to spare."""
    norm = max(1, mp.mnorm(A, 1) * abs(mp.mpf(t)))
    with mp.workdps(int(75 + mp.log10(norm) * 2)):
        doublings = int(mp.ceil(mp.log(norm, 2))) + 4
        X = A * (mp.mpf(t) / 2**doublings)
        total, term = mp.eye(A.rows), mp.eye(A.rows)
        for k in range(1, 45):
            term = term * X / k
            total += term
        for _ in range(doublings):
            total = total * total
        return total


def general(n: int) -> str:
    """A scene of n coordinates with any M, C, K, and constant and oscillating loads."""
    pairs = [(i, j) for i in range(1, n + 1) for j in range(i, n + 1)]
    lines = [f"  parameter Real m{i}_{j} = {int(i == j)}, c{i}_{j} = 0, k{i}_{j} = {int(i == j)};" for i, j in pairs]
    lines += [f"  coordinate Real x{i}; parameter Real b{i} = 0, s{i} = 0;" for i in range(1, n + 1)] + ["energy"]
    for i, j in pairs:
        half = "/2" if i == j else ""
        lines += [f"  kinetic m{i}_{j}*der(x{i})*der(x{j}){half};", f"  potential k{i}_{j}*x{i}*x{j}{half};",
                  f"  dissipation c{i}_{j}*der(x{i})*der(x{j}){half};"]
    lines += [f"  work b{i} + s{i}*exp(-0.05*time)*sin(1.5*time) on x{i};" for i in range(1, n + 1)]
    return "\n".join([f"model General{n}", *lines, f"end General{n};"])


def numbered(letter: str, matrix: np.ndarray) -> dict[str, float]:
    n = len(matrix)
    return {f"{letter}{i + 1}_{j + 1}": float(matrix[i, j]) for i in range(n) for j in range(i, n)}


def reference(M: np.ndarray, C: np.ndarray, K: np.ndarray, b: np.ndarray, s: np.ndarray, x: np.ndarray, t: float) -> np.ndarray:
    """(q, v) at t in 50 digits, from (q, v) at 0."""
    n = len(M)
    with mp.workdps(75):
        rows = mp.inverse(mp.matrix(M.tolist())) * mp.matrix(np.hstack([-K, -C, b[:, None], s[:, None], 0 * s[:, None]]).tolist())
        A = mp.zeros(2 * n + 3)
        for i in range(n):
            A[i, n + i] = 1
            for j in range(2 * n + 3):
                A[n + i, j] = rows[i, j]
        A[2 * n + 1, 2 * n + 1] = A[2 * n + 2, 2 * n + 2] = -mp.mpf(0.05)
        A[2 * n + 1, 2 * n + 2], A[2 * n + 2, 2 * n + 1] = mp.mpf(1.5), -mp.mpf(1.5)
        start = mp.matrix([*map(float, x), 1, 0, 1])
        return np.array([float(value) for value in (exponential(A, t) * start)[: 2 * n]])


def compare(model: lag.Model, M: np.ndarray, C: np.ndarray, K: np.ndarray, x: np.ndarray, times: Sequence[float],
            b: np.ndarray | None = None, s: np.ndarray | None = None) -> None:
    n = len(M)
    b, s = (np.zeros(n) if a is None else a for a in (b, s))
    values = numbered("m", M) | numbered("c", C) | numbered("k", K)
    values |= {f"b{i + 1}": b[i] for i in range(n)} | {f"s{i + 1}": s[i] for i in range(n)}
    initial = {f"x{i + 1}": x[i] for i in range(n)} | {f"der(x{i + 1})": x[n + i] for i in range(n)}
    found = states(model, times, parameters=values, initial=initial)
    omega = math.sqrt(max(np.abs(np.linalg.eigvals(np.linalg.solve(M, K))).max(), 2.25))
    for t, row in zip(times, found, strict=True):
        exact = reference(M, C, K, b, s, x, t)
        for part in (slice(0, n), slice(n, 2 * n)):
            scale = np.abs(exact[part]).max()
            assert np.abs(row[part] - exact[part]).max() <= bound(omega, t) * scale, (t, part)


def definite(random: np.random.Generator, n: int, spread: float) -> np.ndarray:
    """Symmetric positive definite, with eigenvalues from 1 to 10^spread."""
    Q, _ = np.linalg.qr(random.normal(size=(n, n)))
    A = Q * 10 ** (spread * random.uniform(size=n)) @ Q.T
    return np.triu(A) + np.triu(A, 1).T


@pytest.mark.parametrize("n", [1, 2, 3, 5, 8, 12])
def test_random_scenes_against_50_digits(n: int, scene: Scene) -> None:
    model, random = scene(general(n)), np.random.default_rng(n)
    for spread in (0, 4) if n < 8 else (2,):
        M, C, K = definite(random, n, 1), 0.1 * definite(random, n, 1), definite(random, n, spread)
        times = [0.1, 0.2, 0.3, 20] if n < 8 else [0.2, 4.0]
        compare(model, M, C, K, random.normal(size=2 * n), times, random.normal(size=n), random.normal(size=n))


@pytest.mark.parametrize("damping", [0, 0.3, 1e6, 1e12])
def test_stiffness_ratio_of_1e12(damping: float, scene: Scene) -> None:
    """The slow motion keeps its digits beside springs 1e12 times as stiff: the sums of their stiffnesses are not rounded."""
    model = scene("""
model Chain
  parameter Stiffness k1 = 1.1, k2 = 1e12, k3 = 3.3e6; parameter Damping c = 0; parameter Mass m1 = 1, m2 = 0.7, m3 = 2;
  World world(gravity = {0, 0});
  Block a(m = m1, base = world), b(m = m2, base = world), d(m = m3, base = world);
  Spring s1(k = k1, stretch = a.s), s2(k = k2, stretch = b.s - a.s), s3(k = k3, stretch = d.s - b.s);
  Damper d2(c = c, rate = der(b.s) - der(a.s));
end Chain;""")
    D = np.array([[1, 0, 0], [-1, 1, 0], [0, -1, 1]])
    with mp.workdps(75):
        Dm, M = mp.matrix(D.tolist()), mp.diag([1, mp.mpf(0.7), 2])
        K = Dm.T * mp.diag([mp.mpf(1.1), mp.mpf(1e12), mp.mpf(3.3e6)]) * Dm
        C = Dm.T * mp.diag([0, mp.mpf(damping), 0]) * Dm
        A = mp.zeros(6)
        A[:3, 3:], A[3:, :3], A[3:, 3:] = mp.eye(3), -mp.inverse(M) * K, -mp.inverse(M) * C
    times, x = [1e-9, 1e-3, 0.5, 7.25, 1000], [1, 1, 1, 0.5, 0.5, 0.5]
    names = ["a.s", "b.s", "d.s"]
    initial = dict(zip([*names, *(f"der({name})" for name in names)], map(float, x), strict=True))
    found = states(model, times, parameters={"c": damping}, initial=initial)
    for t, row in zip(times, found, strict=True):
        exact = np.array([float(y) for y in exponential(A, t) * mp.matrix(x)])
        for part in (slice(0, 3), slice(3, 6)):  # the slow motion has some 0.5/s: no stiff part is set off
            assert np.abs(row - exact)[part].max() <= bound(0.55, t) * np.abs(exact[part]).max(), t


@pytest.mark.parametrize("horizon", [1e-9, 1.0, 1e4, 1e9])
@pytest.mark.parametrize("rows", [1, 300])
def test_horizons(horizon: float, rows: int, scene: Scene) -> None:
    model = scene(general(2))
    omega, times = math.sqrt(3.0), np.linspace(0, horizon, rows + 1)[1:]
    found = states(model, times, parameters={"k1_1": 3.0, "k2_2": 0.25}, initial={"x1": 1.0, "der(x2)": 2.0})
    exact = [[mp.cos(mp.sqrt(3) * t), 4 * mp.sin(mp.mpf(t) / 2)] for t in map(float, times)]
    assert np.abs(found[:, 0] - [float(x) for x, _ in exact]).max() <= bound(omega, horizon)
    assert np.abs(found[:, 1] - [float(x) for _, x in exact]).max() <= bound(omega, horizon) * min(4, 2 * horizon)


STIFF_PAIR = """
model Pair
  parameter Real k = 1, k2 = 1; coordinate Real x(start = 1), y(start = 1); parameter Real c = 0;
energy
  kinetic der(x)^2/2 + der(y)^2/2; potential k*x^2/2 + k2*(y - x)^2/2 + k*y^2/2; dissipation c*der(x)^2/2 + c*der(y)^2/2;
end Pair;"""


@pytest.mark.parametrize("k2", [1.0, 1e4, 1e12])
@pytest.mark.parametrize("c", [0.0, 0.01])
def test_thousands_of_equal_steps(k2: float, c: float, scene: Scene) -> None:
    """Most are taken in doubles where that loses nothing. Both masses swing alike, whatever lies between them."""
    model, interval = scene(STIFF_PAIR), 0.037
    run = model.simulate(stop=4000 * interval, interval=interval, solver="linear", parameters={"k2": k2, "c": c})
    rate, speed = mp.mpf(c) / 2, mp.sqrt(1 - (mp.mpf(c) / 2) ** 2)
    exact = [float(mp.exp(-rate * t) * (mp.cos(speed * t) + rate / speed * mp.sin(speed * t))) for t in map(float, run.time)]
    assert np.abs(run["x"] - exact).max() < 1e-12
    assert np.abs(run["y"] - exact).max() < 1e-12
    assert np.abs(run.energy.residual).max() < 1e-12


def test_a_ladder_of_120_states(scene: Scene) -> None:
    """A mode of a row of 60 masses, over rows 2000 s apart and over many equal small ones."""
    n, k = 60, 7
    model, a = scene(row(n, (1.0, 0.0), 0.0)), k * mp.pi / (n + 1)
    speed, initial = 2 * mp.sin(a / 2), {f"x{j}": float(mp.sin(j * a)) for j in range(1, n + 1)}
    for times in ([2000.0, 4000.0, 6000.0], list(np.arange(1, 1500) * 2.5)):
        found = states(model, times, initial=initial)
        exact = np.array([[float(mp.cos(speed * t) * mp.sin(j * a)) for j in (1, 30, 60)] for t in times])
        assert np.abs(found[:, [0, 29, 59]] - exact).max() < bound(float(speed), times[-1])


def test_auto_takes_it_where_it_costs_less(scene: Scene) -> None:
    text = STIFF_PAIR.replace("end Pair", "annotation(experiment(StopTime = {stop}));\nend Pair")
    for stop, k2, solver in ((10, 1, "linear"), (10, 1e8, "taylor"), (1000, 1, "linear"), (1e6, 1, "linear")):
        run = scene(text.format(stop=stop)).simulate(parameters={"k2": k2}, interval=stop / 10)
        assert run.statistics.solver.name.lower() == solver


# ---------------------------------------------------------------- closed forms


def test_critical_damping_and_rigid_bodies_have_defective_matrices(scene: Scene) -> None:
    model = scene(general(2))
    times = [0.1, 1, 2, 3, 4.5, 30]
    found = states(model, times, parameters={"c1_1": 2.0, "k2_2": 0.0, "b2": 0.5}, initial={"x1": 1.0, "der(x2)": 3.0})
    t = np.array(times)
    assert found[:, 0] == pytest.approx((1 + t) * np.exp(-t), rel=1e-13)
    assert found[:, 1] == pytest.approx(3 * t + 0.25 * t**2, rel=1e-14)


def test_resonance_grows_linearly(scene: Scene) -> None:
    """x'' + x = sin t from rest: x = (sin t - t cos t)/2."""
    model = scene("model R\n  coordinate Real x;\nenergy\n  kinetic der(x)^2/2; potential x^2/2; work sin(1*time) on x;\nend R;")
    t = np.linspace(0, 1e5, 1001)
    found = states(model, t[1:])[:, 0]
    exact = (np.sin(t) - t * np.cos(t))[1:] / 2
    assert np.abs(found - exact).max() < 1e-10 * np.abs(exact).max()


def test_resonance_of_a_product_of_loads(scene: Scene) -> None:
    """sin 2t cos t has the frequencies 1 and 3; t^2 exp(-t) and a constant come on top."""
    model = scene("""model R
  coordinate Real x;
energy
  kinetic der(x)^2/2; potential x^2/2; work sin(2*time)*cos(1*time) + (1*time)^2*exp(-1*time) - 1 on x;
end R;""")
    t = np.linspace(0, 40, 81)[1:]
    resonant, third = (np.sin(t) - t * np.cos(t)) / 4, (3 * np.sin(t) - np.sin(3 * t)) / 16
    decaying = np.exp(-t) * (t**2 + 2 * t + 1) / 2 - np.cos(t) / 2 - np.sin(t) / 2
    assert states(model, t)[:, 0] == pytest.approx(resonant + third + decaying - (1 - np.cos(t)), abs=2e-13)


def test_energy_account_closes_and_tells_what_is_dissipated(scene: Scene) -> None:
    model = scene("""model D
  parameter Real c = 0.2; coordinate Real x(start = 1);
energy
  kinetic der(x)^2/2; potential x^2/2; dissipation c*der(x)^2/2; work 3 on x;
end D;""")
    for stop, interval in ((10, 0.1), (1e4, 1e4), (3, 1.1)):
        run = model.simulate(stop=stop, interval=interval, solver="linear")
        assert np.asarray(run.energy.work)[-1] == pytest.approx(3 * (run["x"][-1] - 1), rel=1e-13)
        assert np.abs(run.energy.residual).max() < 2e-14 * max(np.abs(run.energy.work).max(), 1)
    assert np.asarray(model.simulate(stop=1e4, solver="linear").energy.dissipated)[-1] == pytest.approx(2.0, rel=1e-12)


# ---------------------------------------------------------------- many masses

def row(n: int, mass: tuple[float, float], c: float) -> str:
    """Springs of 1 N/m between n masses and two walls, with dampers beside them; the mass matrix has three diagonals."""
    inner, beside = mass
    lines = [f"model Row\n  parameter Real c = {c};", *(f"  coordinate Real x{i};" for i in range(1, n + 1)), "energy"]
    for i in range(n + 1):
        change = f"x{i + 1} - x{i}" if 0 < i < n else "x1" if i == 0 else f"x{n}"
        lines += [f"  potential ({change})^2/2;", f"  dissipation c*der({change})^2/2;"]
        if 0 < i < n and beside:
            lines.append(f"  kinetic {beside}*der(x{i})*der(x{i + 1});")
    return "\n".join([*lines, *(f"  kinetic {inner}*der(x{i})^2/2;" for i in range(1, n + 1)), "end Row;"])


@pytest.mark.parametrize("mass", [(1.0, 0.0), (2 / 3, 1 / 6)], ids=["lumped", "consistent"])
@pytest.mark.parametrize("c", [0.0, 0.02])
def test_modes_of_a_long_row(mass: tuple[float, float], c: float, scene: Scene) -> None:
    """x_j = sin(j a), a = k pi/(n + 1): oscillates with w^2 = 2 (1 - cos a)/(m + 2 m' cos a), damped by c w^2/2."""
    n, times = 150, [0.3, 1.0, 2.0, 3.0, 250.0]
    model = scene(row(n, mass, c))
    for k in (1, 40, 150):
        a = k * mp.pi / (n + 1)
        shape = [mp.sin(j * a) for j in range(1, n + 1)]
        square = 2 * (1 - mp.cos(a)) / (mp.mpf(mass[0]) + 2 * mp.mpf(mass[1]) * mp.cos(a))
        decay, speed = mp.mpf(c) * square / 2, mp.sqrt(square - (mp.mpf(c) * square / 2) ** 2)
        found = states(model, times, initial={f"x{j + 1}": float(x) for j, x in enumerate(shape)})
        for t, there in zip(times, found, strict=True):
            factor = mp.exp(-decay * t) * (mp.cos(speed * t) + decay / speed * mp.sin(speed * t))
            exact = np.array([float(factor * x) for x in shape])
            assert np.abs(there[:n] - exact).max() <= max(bound(float(speed), t), 1e-12), (k, t)
    run = model.simulate(stop=40, interval=1, solver="linear", initial={"x5": 1.0})
    assert np.abs(run.energy.residual).max() < 1e-14


# ---------------------------------------------------------------- pieces, inputs, portions

PIECES = """model P
  parameter Real A = 2; input Real u; coordinate Real x, y(start = 0.3);
energy
  kinetic der(x)^2/2 + der(y)^2; potential 2*x^2 + (y - x)^2; dissipation 0.05*der(x)^2;
  work A*pulse(time, 0.7, 1.1) + ramp(time, 2, 0.5)*sin(4*time) + u on x;
  work (if time < 1.3 then (1*time)^2 else exp(1.3 - 1*time)) on y;
end P;"""


def test_pieces_and_inputs_agree_with_integration(scene: Scene) -> None:
    model = scene(PIECES)
    inputs = ([0.0, 1.0, 1.0, 2.5], {"u": [0.0, 1.0, -1.0, 0.5]})
    exact = model.simulate(stop=6, solver="linear", inputs=inputs)
    other = model.simulate(stop=6, solver="erk", tolerance=1e-13, inputs=inputs)
    for name in ("x", "y", "der(x)", "der(y)"):
        assert exact[name] == pytest.approx(other[name], abs=3e-12)
    assert exact.energy.work == pytest.approx(other.energy.work, abs=1e-11)
    assert np.abs(exact.energy.residual).max() < 1e-13
    assert exact.statistics.events == other.statistics.events


def test_rows_do_not_depend_on_each_other(scene: Scene) -> None:
    model = scene(PIECES)
    even = states(model, np.linspace(0, 4, 401))
    some = [0.01, 0.013, 0.7, 1.31, 2.0, 2.03, 3.33, 4.0]
    found = states(model, some)
    for t, row in zip(some, found, strict=True):
        k = round(t * 100)
        if abs(t - k / 100) < 1e-12:
            assert row == pytest.approx(even[k], abs=1e-14)
    with started(model, 4.0) as run:
        alone = [run.advance([t])[0][1:5] for t in some]
        assert np.array(alone) == pytest.approx(found, abs=0)


def test_rows_within_steps_of_its_own(scene: Scene) -> None:
    model = scene(general(1))
    with started(model, 10.0, initial={"x1": 1.0}, max_step=2.5) as run:
        assert run.advance_steps(2).count == 2
        assert run.time == 5.0
        (row,) = (run.advance([4.0])[0],)
        assert row[1] == pytest.approx(math.cos(4), abs=1e-15)
        assert run.advance([7.0])[0][1] == pytest.approx(math.cos(7), abs=1e-15)
        assert run.advance([6.0]).status is Status.OK
        assert run.advance([1.0]).status is Status.TIME_PASSED


def test_portions_with_inputs_and_parameters_in_between(scene: Scene) -> None:
    """As a co-simulation does: the stop moves on, inputs are held; and a spring that becomes stiffer half-way."""
    model = scene("""model F
  parameter Real k = 1; input Real u; coordinate Real x;
energy
  kinetic der(x)^2/2; potential k*x^2/2; work u on x;
end F;""")
    engine = model.engine
    assert engine is not None
    with started(model, 0.0) as run:
        x, v, k = 0.0, 0.0, 1.0
        grid = [0.01 * i for i in range(601)]
        for i, (t, t_next) in enumerate(pairwise(grid)):
            u = 1.0 if i < 300 else -0.5
            if i == 450:
                k = 9.0
                run.set_parameters([k], [1.0])
            run.set_inputs([t], [u])
            run.set_stop(t_next)
            (row,) = (run.advance([t_next])[0],)
            h, w = t_next - t, math.sqrt(k)
            x, v = (u / k + (x - u / k) * math.cos(w * h) + v / w * math.sin(w * h),
                    -(x - u / k) * w * math.sin(w * h) + v * math.cos(w * h))
            assert row[1:3] == pytest.approx([x, v], abs=1e-13)
        assert run.statistics.energy_residual < 1e-13


# ---------------------------------------------------------------- hygiene

DRIVER = """
#include "run/run.h"
#include <stdlib.h>
extern const LagModel lag_model;
int main(void)
{
    const LagSettings settings = {.t_stop = 10, .tolerance = 1e-9, .solver = LAG_SOLVER_LINEAR};
    const double times[] = {0, 0.5, 1, 1.5, 2, 2.5, 2.6, 7.3, 10}, corners[] = {2, 3, 3}, values[] = {0, 1, 2};
    double *rows = malloc(9 * (size_t)lag_run_row_width(&lag_model) * sizeof *rows);
    LagRun *run = lag_run_new(&lag_model, &settings);
    int done = 0;
    lag_run_set_parameters(run, NULL, NULL);
    lag_run_set_inputs(run, corners, values, 3);
    for (int i = 0; i < 2; ++i)
        if (lag_run_start(run, NULL, NULL) != LAG_OK || lag_run_advance(run, times, 9, rows, &done, 0) != LAG_OK || done != 9)
            return 1;
    lag_run_free(run);
    free(rows);
    return 0;
}
"""


@needs_sanitizers
@pytest.mark.slow
def test_sanitizers_find_nothing(scene: Scene, tmp_path: Path) -> None:
    plain = scene(PIECES).scene
    text = write_c(plain.name, plain.sizes, plain.tapes, plain.coordinate_kind, plain.fixed, plain.event_kind, plain.patterns)
    run_sanitized(tmp_path, {"driver.c": DRIVER, "scene.c": text})


# ---------------------------------------------------------------- what is not linear

NOT_LINEAR = {
    "small angles": "potential 9.81*(1 - cos(x));",
    "absolute value": "potential abs(x);",
    "condition": "potential (if x > 0 then x^2 else 2*x^2);",
    "friction": "dissipation abs(der(x));",
    "cubic": "potential x^2 + 1e-30*x^4;",
    "parametric": "potential (1 + 0.1*sin(1*time))*x^2;",
    "product": "potential x*y^2;",
    "velocity squared": "work der(x)*der(y) on x;",
    "mass that moves": "kinetic (1 + x^2)*der(y)^2;",
    "rectified": "work max(0, x) on x;",
    "floor": "work floor(x) on x;",
    "chirp": "work sin((1*time)^2) on x;",
    "quotient": "work 1/(1 + 1*time) on x;",
    "input times state": "work u*x on x;",
}


@pytest.mark.parametrize("statement", NOT_LINEAR.values(), ids=NOT_LINEAR.keys())
def test_what_is_not_linear_is_never_taken(statement: str, scene: Scene) -> None:
    model = scene(f"""model N
  input Real u; coordinate Real x(start = 0.1), y;
energy
  kinetic der(x)^2 + der(y)^2; potential y^2 + x^2; {statement}
end N;""")
    assert model.scene.refused["linear"]
    assert not model.scene.sizes.get("solver", 0)
    with pytest.raises(LagError, match="L0704"):
        model.simulate(stop=1, solver="linear")


def test_the_run_time_refuses_it_too(scene: Scene) -> None:
    model = scene("model N\n  coordinate Real x(start = 1);\nenergy\n  kinetic der(x)^2; potential 1*cos(x);\nend N;")
    assert model.engine is not None
    with model.engine.runtime.run(model.engine.model, Settings(solver=Solver.LINEAR)) as run:
        assert run.set_parameters() is Status.OK
        assert run.start() is Status.BAD_SETTINGS


def test_springs_that_events_switch_are_linear_in_pieces(scene: Scene) -> None:
    model = scene("""model S
  coordinate Real x(start = 1);
energy
  kinetic der(x)^2/2; potential (if time < 1 then 1 else 4)*x^2/2;
end S;""")
    x, v = math.cos(1), -math.sin(1)
    found = states(model, [1.0, 2.5])
    assert found[0] == pytest.approx([x, v], abs=1e-15)
    assert found[1, 0] == pytest.approx(x * math.cos(3) + v / 2 * math.sin(3), abs=1e-15)


def test_a_mass_matrix_that_is_not_definite_is_told(scene: Scene) -> None:
    model = scene("""model M
  parameter Real m = 1; coordinate Real x(start = 1);
energy
  kinetic m*der(x)^2/2; potential x^2;
end M;""")
    with pytest.raises(lag.RunError):
        model.simulate(stop=1, solver="linear", parameters={"m": -1.0})


def test_rates_beyond_all_measure_end_the_run(scene: Scene) -> None:
    """1e150 radians a second: rungs without end were climbed, deaf to signals."""
    model = scene("""model Huge World world(gravity = {0, 0}); Block g(m = 1e-150, base = world, s(start = 1));
      Spring s(k = 1e150, stretch = g.s); end Huge;""")
    with pytest.raises(lag.RunError, match="beyond the range of numbers"):
        model.simulate(stop=1, solver="linear")
