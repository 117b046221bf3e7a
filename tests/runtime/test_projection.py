"""Constrained motion in the run time: order, residuals, redundant and nonholonomic constraints, assembly of closed loops."""

import math

import pytest

pytest.importorskip("casadi")

from helpers.constrained import linkage, pendulum, skate
from helpers.native_models import compiled, started
from lagrangia.native.build import find_compiler
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Model, Run, Settings, Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
ROUNDING = 1e-13

FOUR_BAR = linkage([1, 3, 2], 2.5, [1, 0.5, 1.5])
SWINGING = linkage([1, 2, 1], 2, [-1, 0.1, -0.8, -1.2])
TIMES = [0.05 * i for i in range(201)]


def assembled(runtime: Runtime, model: Model, **settings: float) -> Run:
    """Started from the model's own guesses."""
    run = runtime.run(model, Settings(**settings))
    run.set_parameters()
    assert run.start() is Status.OK
    return run


def test_order_of_convergence(runtime: Runtime) -> None:
    """theta(2 pi) of a pendulum from the bottom at rate 1, by Jacobi's functions; steps of equal length."""
    angle, errors, inside = -0.443944662290258816, [], []
    for h in (math.pi / 8, math.pi / 16):
        fixed = {"tolerance": 1e3, "first_step": h, "max_step": h, "solver": Solver.ERK}
        with started(runtime, pendulum(), [0, 1], [1, 0], t_stop=7, **fixed) as run:
            x, y = run.advance([2 * math.pi])[0][1:3]
            errors.append(abs(math.atan2(x, y) - angle))
        with started(runtime, pendulum(), [0, 1], [1, 0], t_stop=7 + 0.4 * h, **fixed) as run:
            run.advance([2 * math.pi - 0.4 * h])
            x, y = run.advance([2 * math.pi])[0][1:3]
            inside.append(abs(math.atan2(x, y) - angle))
    assert math.log2(errors[0] / errors[1]) > 7
    assert math.log2(inside[0] / inside[1]) > 6.5


def test_a_pendulum_in_cartesian_coordinates(runtime: Runtime) -> None:
    """100 s of going round, 20 turns: angle by Jacobi's functions."""
    with started(runtime, pendulum(), [0, 1], [2.1, 0], t_stop=100, tolerance=1e-12) as run:
        x, y = run.advance([100])[0][1:3]
    assert math.remainder(math.atan2(x, y) - 126.6324510806264510823, 2 * math.pi) == pytest.approx(0, abs=1e-10)


@pytest.mark.parametrize("tolerance", [1e-4, 1e-8, 1e-12])
@pytest.mark.parametrize("model", [FOUR_BAR, SWINGING], ids=["four_bar", "redundant"])
def test_residuals_are_rounding_at_every_row(runtime: Runtime, model: Model, tolerance: float) -> None:
    with assembled(runtime, model, t_stop=10, tolerance=tolerance, solver=Solver.ERK) as run:
        assert run.advance(TIMES).status is Status.OK
        assert run.statistics.dense_outputs > 0
        assert run.statistics.projections > 0
        assert run.statistics.constraint_residual < ROUNDING
        assert run.statistics.constraint_rate_residual < ROUNDING


def test_a_redundant_parallelogram_is_one_pendulum(runtime: Runtime) -> None:
    """Three cranks of mass 1 and a coupler of mass 2 that does not turn: (3/3 + 2) theta'' = -(3/2 + 2) g cos(theta)."""
    with assembled(runtime, SWINGING, t_stop=10, tolerance=1e-12) as run:
        row = run.advance([0, 10])
        cranks, coupler, begin = [row[1][i] for i in (1, 3, 4)], row[1][2], row[0][1]
    one = compiled(1, kinds=[0], rhs="a[0] = -9.81*3.5/3*cos(q[0]);")
    with started(runtime, one, [begin], [0], t_stop=10, tolerance=1e-13) as run:
        angle = run.advance([10])[0][1]
    assert begin == pytest.approx(-1, abs=0.3)
    assert cranks == pytest.approx([angle] * 3, abs=1e-10)
    assert coupler == pytest.approx(0, abs=1e-12)


def test_a_skate_on_a_slope(runtime: Runtime) -> None:
    """It does not slide down for ever: x = sin(2 t)^2 / 8, y = (2 t - sin(2 t) cos(2 t)) / 8."""
    with started(runtime, skate(), [0, 0, 0], [0, 0, 2], t_stop=10, tolerance=1e-12) as run:
        x, y = run.advance([10])[0][1:3]
        assert run.statistics.constraint_rate_residual < ROUNDING
    assert [x, y] == pytest.approx([math.sin(20) ** 2 / 8, (20 - math.sin(20) * math.cos(20)) / 8], abs=1e-10)


def test_without_constraints_nothing_is_projected(runtime: Runtime) -> None:
    with started(runtime, compiled(1, rhs="a[0] = -q[0];"), [1], [0], t_stop=10) as run:
        run.advance([0.5, 10])
        statistics = run.statistics
    assert (statistics.projections, statistics.constraint_residual, statistics.constraint_rate_residual) == (0, 0, 0)


def test_constraints_out_of_reach_end_the_run(runtime: Runtime) -> None:
    """A correction that never shrinks: steps are rejected down to the smallest, at the latest at the second beyond the place."""
    model = compiled(1, numbers=", .n_holonomic = 1, .n_multipliers = 1", rhs="a[0] = -q[0];",
                     place="dq[0] = t > 0.5 ? 1 : 0;", steer="dv[0] = 0;")
    with started(runtime, model, [1], [0], t_stop=1) as run:
        rows = run.advance([0.25, 1])
        assert (rows.status, rows.count) == (Status.STEP_TOO_SMALL, 1)
        assert 0.5 - 1e-9 < run.failure.time < 0.5 + 2 * run.statistics.largest_step


def test_no_row_is_written_whose_constraints_are_open(runtime: Runtime) -> None:
    """Ends of steps, at whole times, are on the constraint; in between nothing leads back to it."""
    for gap, status in ((0.5, Status.CONSTRAINTS_OPEN), (1e-12, Status.OK)):
        model = compiled(1, numbers=", .n_holonomic = 1, .n_multipliers = 1", rhs="a[0] = 0;",
                         place="dq[0] = t == floor(t) ? 0 : 1;", steer="dv[0] = 0;",
                         residual=f"phi[0] = t == floor(t) ? 0 : {gap}; rate[0] = v[0] - 1;")
        with started(runtime, model, [1], [1], t_stop=100, first_step=1, max_step=1, solver=Solver.ERK) as run:
            rows = run.advance([1, 2, 2.5])
            assert (rows.status, rows.count) == (status, 2 if status is Status.CONSTRAINTS_OPEN else 3)
            assert status is Status.OK or (run.failure.time, run.failure.value) == (2.5, pytest.approx(0.125))


# -------------------------------------------------------------------------------------------------------------- assembly


@pytest.mark.parametrize("shift", [-0.5, -0.2, 0.2, 0.5])
def test_a_four_bar_closes_from_afar(runtime: Runtime, shift: float) -> None:
    near = [1.0, 0.4266, 1.1984]  # on the branch that the guess is nearest to
    with assembled(runtime, linkage([1, 3, 2], 2.5, [near[0], near[1] + shift, near[2] - shift]), t_stop=1) as run:
        crank, coupler, rocker = run.row()[0][1:4]
    assert math.cos(crank) + 3 * math.cos(coupler) - 2.5 - 2 * math.cos(rocker) == pytest.approx(0, abs=1e-13)
    assert math.sin(crank) + 3 * math.sin(coupler) - 2 * math.sin(rocker) == pytest.approx(0, abs=1e-13)
    assert [crank, coupler, rocker] == pytest.approx(near, abs=1)


def test_a_guess_at_a_critical_point_is_left(runtime: Runtime) -> None:
    """q = 0 is where the gradient of q^2 = 1 vanishes."""
    model = compiled(1, numbers=", .n_initial = 1", initial="g[0] = q[0]*q[0] - 1; J[0] = 2*q[0]; J[1] = 0;", rhs="a[0] = 0;")
    for _ in range(2):
        with assembled(runtime, model, t_stop=1) as run:
            assert abs(run.row()[0][1]) == pytest.approx(1, rel=1e-14)


def test_a_start_at_a_dead_centre(runtime: Runtime) -> None:
    """Crank and coupler in line: two equations with one gradient, and a solution that is a double root."""
    with assembled(runtime, linkage([1, 1.5, 2], 4.5, [0.1, -0.1, math.pi]), t_stop=1) as run:
        angles = run.row()[0][1:4].tolist()
    assert math.cos(angles[0]) + 1.5 * math.cos(angles[1]) - 2 * math.cos(angles[2]) == pytest.approx(4.5, abs=1e-9)
