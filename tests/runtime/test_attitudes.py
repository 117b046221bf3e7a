"""Attitudes of rigid bodies against a reference that steps move along: written in C by hand, without the compiler."""

import math
from array import array
from ctypes import CDLL

import numpy as np
import pytest

import lagrangia as lag
from helpers.native_models import compiled, started
from lagrangia.native.build import find_compiler
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Model, Run, Settings, Solver, Status

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

QUATERNION = """
    const double *s = q, *r = d, square = (s[0]*s[0] + s[1]*s[1] + s[2]*s[2])/16, half = 0.5/(1 + square);
    const double w = (1 - square)/(1 + square), x = s[0]*half, y1 = s[1]*half, z = s[2]*half;
    y[0] = r[0]*w - r[1]*x - r[2]*y1 - r[3]*z; y[1] = r[1]*w + r[0]*x + r[2]*z - r[3]*y1;
    y[2] = r[2]*w + r[0]*y1 + r[3]*x - r[1]*z; y[3] = r[3]*w + r[0]*z + r[1]*y1 - r[2]*x;
"""
# Of M a + h = 0 with M = diag(I), h = w x (I w): by a, by v and by q, column by column.
JACOBIAN = """
    for (int i = 0; i < 27; ++i) out[i/9][i%9] = 0;
    out[0][0] = I1; out[0][4] = I2; out[0][8] = I3;
    out[1][1] = (I1 - I3)*v[2]; out[1][2] = (I2 - I1)*v[1]; out[1][3] = (I3 - I2)*v[2];
    out[1][5] = (I2 - I1)*v[0]; out[1][6] = (I3 - I2)*v[1]; out[1][7] = (I1 - I3)*v[0];
"""
PATTERN = "(const int[]){0, 3, 6, 9, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2, 0, 1, 2}"


def top(I: tuple[float, float, float], start: str = "d[0] = 1; d[1] = d[2] = d[3] = 0;") -> Model:
    """A rigid body that nothing acts on; its unit quaternion is put out."""
    inertia = "".join(f"const double I{k + 1} = {value!r}; (void)I{k + 1};" for k, value in enumerate(I))
    return compiled(
        3, kinds=[0, 0, 0],
        numbers=", .n_modes = 4, .n_outputs = 4, .n_attitudes = 1, .attitudes = (const int[]){0, 0}"
                f", .n_entries = 9, .n_colours = 3, .jacobian_pattern = {PATTERN}",
        modes=start,
        rhs=inertia + "a[0] = (I2-I3)/I1*v[1]*v[2]; a[1] = (I3-I1)/I2*v[2]*v[0]; a[2] = (I1-I2)/I3*v[0]*v[1];",
        outputs=QUATERNION,
        jacobian=inertia + JACOBIAN,
        energies=inertia + "E[0] = E[2] = (I1*v[0]*v[0] + I2*v[1]*v[1] + I3*v[2]*v[2])/2; E[1] = 0;",
    )


FREE = {  # euler_top_free of the shared cases: t, w in body axes, unit quaternion
    1: ((1.10660649711645790, 0.355592324829391964, -0.764964549417952858),
        (0.778719777329934418, 0.427800014898702710, 0.299612306196769717, -0.347584697049999891)),
    10: ((-1.05122541303702233, 0.515928576471262326, -0.734261499430866179),
         (0.699042422505348825, 0.164308163409162285, -0.633812223093282067, 0.287444924868248543)),
    100: ((-0.429538745200096243, -1.15871375292061900, -0.429592259298665553),
          (-0.0129917318653554476, 0.134151818372757411, -0.165129295560495689, -0.977019355119496020)),
}


SOLVERS = [Solver.ERK, Solver.ERK5, Solver.ERK9, Solver.IMPLICIT, Solver.PIRK]


@pytest.mark.parametrize("solver", SOLVERS)
def test_free_top_turns_as_its_closed_form_says(runtime: Runtime, solver: Solver) -> None:
    """Rows fall into steps; the sign of the quaternion is continuous."""
    with started(runtime, top((1.3, 2.1, 3.0)), [0, 0, 0], [0.8, 0.9, -0.6], t_stop=100, tolerance=1e-13, solver=solver) as run:
        rows = run.advance([*FREE])
        for k, (w, quaternion) in enumerate(FREE.values()):
            assert rows[k][4:7] == pytest.approx(w, abs=1e-12)
            assert rows[k][7:11] == pytest.approx(quaternion, abs=1e-12)


@pytest.mark.parametrize(("solver", "order"), [(Solver.ERK5, 5), (Solver.ERK, 8), (Solver.ERK9, 9), (Solver.IMPLICIT, 5),
                                               (Solver.PIRK, 8)])
def test_attitudes_keep_the_order_of_a_method(runtime: Runtime, solver: Solver, order: int) -> None:
    """From tolerance to tolerance the error falls as evaluations to the power of the order."""
    found = []
    for tolerance in (1e-5, 1e-9):
        with started(runtime, top((1.3, 2.1, 3.0)), [0, 0, 0], [0.8, 0.9, -0.6], t_stop=10, tolerance=tolerance,
                     solver=solver) as run:
            row = run.advance([10])[0]
            found.append((np.linalg.norm(np.array(row[7:11]) - FREE[10][1]), run.statistics.rhs_evaluations))
    (coarse, few), (fine, many) = found
    assert coarse < 1e-4 and fine < 1e-8
    assert math.log(coarse / fine) / math.log(many / few) > 0.75 * order


def test_ten_thousand_turns_leave_the_norm(runtime: Runtime) -> None:
    """About an axis aslant, from an attitude that parameters say in no particular length, with a negative real part."""
    axis, turns = np.array([0.36, 0.48, 0.8]), 10_000
    model = top((2, 2, 2), "d[0] = -3; d[1] = 4; d[2] = d[3] = 0;")
    with started(runtime, model, [math.nan] * 3, [*axis], t_stop=2 * math.pi * turns, tolerance=1e-10) as run:
        rows = run.advance([0, 2 * math.pi, 2 * math.pi * turns])
        begin, once, end = (np.array(rows[k][7:11]) for k in range(3))
        assert [*begin] == pytest.approx([0.6, -0.8, 0, 0], abs=1e-15)
        assert [*once] == pytest.approx([*-begin], abs=1e-12)
        assert abs(np.linalg.norm(end) - 1) < 1e-15
        assert [*end] == pytest.approx([*begin], abs=2e-8)  # a turn is known to 1e-12 of itself
        assert run.statistics.steps > 3 * turns


def snapshot(library: CDLL, run: Run) -> bytes:
    taken = array("b", bytes(library.lag_snapshot_size(run.handle)))
    library.lag_snapshot_take(run.handle, taken.buffer_info()[0])
    return taken.tobytes()


@pytest.mark.parametrize("solver", SOLVERS)
def test_events_cut_a_turn_anywhere(runtime: Runtime, solver: Solver) -> None:
    """Steps that end at events, stops that move on, and a state that is brought back."""
    with started(runtime, top((1.3, 2.1, 3.0)), [0, 0, 0], [0.8, 0.9, -0.6], t_stop=0.3, tolerance=1e-12, solver=solver) as run:
        for k in range(1, 7):
            run.set_stop(0.3 * k)
            run.advance([0.3 * k])
        saved = snapshot(runtime.library, run)
        run.set_stop(10)
        first = run.advance([10])[0]
        assert runtime.library.lag_snapshot_restore(run.handle, saved, len(saved)) == Status.OK
        run.set_stop(10)
        again = run.advance([10])[0]
        assert [*first] == [*again]
        assert again[7:11] == pytest.approx(FREE[10][1], abs=1e-11)


def test_methods_that_know_no_attitudes_do_not_begin(runtime: Runtime) -> None:
    for solver in (Solver.ADAMS, Solver.TAYLOR, Solver.CONSERVATIVE, Solver.LINEAR):
        run = runtime.run(top((1, 2, 3)), Settings(t_stop=1, solver=solver))
        run.set_parameters()
        assert run.start([0, 0, 0], [1, 0, 0]) is Status.BAD_SETTINGS
    with started(runtime, top((1, 2, 3)), [0, 0, 0], [1, 2, 3], t_stop=1, tolerance=1e-8) as run:
        assert run.advance([1]).status is Status.OK and run.statistics.solver in SOLVERS


@pytest.mark.parametrize("solver", [Solver.ERK, Solver.TAYLOR, Solver.PIRK])
def test_norms_are_kept_where_steps_turn_far(solver: Solver) -> None:
    """More than half a turn each: the norm's excess grew by |cos(half of that)| a step, to 0.3 after 270 steps of series."""
    for tolerance in (1e-2, 1e-3, 1e-4):
        model = lag.loads("""model Ball World world(gravity = {0, 0, 0}); Spherical j(a = world, w(start = {0, 0, 100}));
            Body b(m = 1, I = {1, 1, 1}, center = j.b); end Ball;""")
        run = model.simulate(at=np.linspace(0, 10, 21), solver=solver.name.lower(), tolerance=tolerance)
        S = np.array([run[f"j.S[{k}]"] for k in (1, 2, 3, 4)])
        assert np.abs(np.linalg.norm(S, axis=0) - 1).max() < 1e-14
        assert np.abs(S[0] - np.cos(50 * run["time"])).max() < 5 * tolerance
