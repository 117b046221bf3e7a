"""The C run time: events, inputs, assembly, accounts, failures and tapes."""

import math
from array import array

import pytest

from helpers.native_models import OSCILLATOR, compiled, started
from lagrangia.native.build import find_compiler
from lagrangia.native.tapes import Op, Tape
from lagrangia.run.library import Runtime
from lagrangia.run.runtime import Model, Settings, Solver, Status
from runtime.test_accuracy import CASES

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

# ---------------------------------------------------------------------------------------------------- events and inputs


def test_mode_changes_exactly_at_its_time(runtime: Runtime) -> None:
    model = compiled(
        1,
        numbers=", .n_modes = 1, .n_events = 1, .n_outputs = 1",
        events="a[0] = -0.7; b[0] = 1;",
        modes="d[0] = t > 0.7;",
        rhs="a[0] = d[0];",
        outputs="y[0] = d[0];",
    )
    with started(runtime, model, [0], [0], t_stop=2, tolerance=1e-6) as run:
        rows = run.advance([0.5, 0.7, 0.7 + 1e-9, 2])
        assert run.statistics.events == 1
        assert [rows[i][3] for i in range(4)] == [0, 0, 1, 1]
        assert rows[3][1] == pytest.approx(1.3**2 / 2, rel=1e-15)


def test_integer_events_make_a_square_wave(runtime: Runtime) -> None:
    model = compiled(
        1,
        event_kind="1",
        numbers=", .n_modes = 1, .n_events = 1",
        events="a[0] = 0.25; b[0] = -10;",
        modes="d[0] = fmod(floor(0.25 - 10*t), 2) == 0 ? 1 : -1;",
        rhs="a[0] = d[0];",
    )
    with started(runtime, model, [0], [0], t_stop=100, tolerance=1e-6) as run:
        rows = run.advance([0.025, 0.125, 100])
        assert run.statistics.events == 1000
        assert [rows[i][2] for i in range(2)] == pytest.approx([0.025, -0.075], abs=1e-15)
        assert rows[2][2] == pytest.approx(0, abs=1e-12)


def test_event_at_the_start_has_already_happened(runtime: Runtime) -> None:
    model = compiled(
        1,
        numbers=", .n_modes = 1, .n_events = 1",
        events="a[0] = -0.3; b[0] = 1;",
        modes="d[0] = t > 0.3 ? 2 : -7;",
        rhs="a[0] = d[0];",
    )
    with started(runtime, model, [0], [0], t_start=0.3, t_stop=1.3) as run:
        assert run.advance([1.3])[0][2] == pytest.approx(2, rel=1e-15)
        assert run.statistics.events == 0


def test_event_times_that_differ_by_rounding_are_one(runtime: Runtime) -> None:
    model = compiled(
        1,
        event_kind="0, 0",
        numbers=", .n_events = 2",
        events="a[0] = -0.3; b[0] = 1; a[1] = -0.1; b[1] = 1/3.0;",  # 0.1 / (1/3.0) is 0.3 and a bit
        rhs=OSCILLATOR,
    )
    with started(runtime, model, [1], [0], t_stop=1) as run:
        assert run.advance([1])[0][1] == pytest.approx(math.cos(1), rel=1e-9)
        assert run.statistics.events == 1


def test_the_shortest_times_pass(runtime: Runtime) -> None:
    """One unit in the last place between an event and the stop."""
    model = compiled(1, numbers=", .n_events = 1", events="a[0] = -0.5; b[0] = 1;", rhs="a[0] = -1e9*q[0];")
    stop = math.nextafter(0.5, 1)
    with started(runtime, model, [1], [0], t_stop=stop, max_steps=100_000) as run:
        assert run.advance([0.5, stop]).status is Status.OK
        assert run.time == stop


def test_values_lost_at_an_event_are_reported_as_often_as_asked(runtime: Runtime) -> None:
    model = compiled(
        1,
        numbers=", .n_modes = 1, .n_events = 1",
        events="a[0] = -0.5; b[0] = 1;",
        modes="d[0] = t > 0.5 ? NAN : 1;",
        rhs="a[0] = d[0];",
    )
    with started(runtime, model, [0], [0], t_stop=1) as run:
        for _ in range(2):
            rows = run.advance([0.5, 1])
            assert (rows.status, rows.count, run.failure.time) == (Status.NOT_FINITE, 1, 0.5)


def test_a_short_step_to_the_stop_is_not_remembered(runtime: Runtime) -> None:
    model = compiled(1, rhs=OSCILLATOR)
    with started(runtime, model, [1], [0], t_stop=20) as run:
        run.advance([20])
        whole = run.statistics.steps
    with started(runtime, model, [1], [0], t_stop=10) as run:
        for stop in (10, 10 + 1e-9, 20):
            run.set_stop(stop)
            run.advance([stop])
        assert run.statistics.steps <= whole + 4


def test_inputs_are_integrated_over_ramps_and_jumps(runtime: Runtime) -> None:
    model = compiled(1, numbers=", .n_inputs = 1", rhs="a[0] = u[0];")
    with runtime.run(model, Settings(t_stop=6, tolerance=1e-5)) as run:
        run.set_parameters()
        # a ramp from (1, 0) to (2, 3), a jump to -1 held to 4, then 5 for ever
        assert run.set_inputs([1, 2, 2, 4, 4], [0, 3, -1, -1, 5]) is Status.OK
        run.start()
        rows = run.advance([1, 2, 4, 6])
    assert [rows[i][2] for i in range(4)] == pytest.approx([0, 1.5, -0.5, 9.5], abs=1e-14)


def test_inputs_may_change_while_running(runtime: Runtime) -> None:
    """As in a co-simulation: the end moves on and inputs change at communication points."""
    model = compiled(1, numbers=", .n_inputs = 1", rhs="a[0] = u[0];")
    with runtime.run(model, Settings(t_stop=0, tolerance=1e-6)) as run:
        run.set_parameters()
        run.start()
        for i in range(10):
            run.set_inputs([0], [i])
            run.set_stop(0.1 * (i + 1))
            assert run.advance([0.1 * (i + 1)]).status is Status.OK
        assert run.row()[0][2] == pytest.approx(4.5, rel=1e-14)


def test_energy_account(runtime: Runtime) -> None:
    """A damped oscillator whose spring is stiffened at t = 2: the jump of its energy is work."""
    model = compiled(
        1,
        numbers=", .n_power = 2, .n_modes = 1, .n_events = 1",
        events="a[0] = -2; b[0] = 1;",
        modes="d[0] = t > 2 ? 9 : 1;",
        rhs="a[0] = -d[0]*q[0] - 0.2*v[0] + cos(t); power[0] = 0.2*v[0]*v[0]; power[1] = v[0]*cos(t);",
        energies="E[0] = v[0]*v[0]/2; E[1] = d[0]*q[0]*q[0]/2; E[2] = E[0] + E[1];",
    )
    with started(runtime, model, [1], [0], t_stop=10, tolerance=1e-10) as run:
        T, V, H, dissipated, work = run.advance([10])[0][3:]
        assert dissipated > 0.1
        assert pytest.approx(T + V) == H
        assert abs(H - 0.5 + dissipated - work) < 1e-8
        assert 0 < run.statistics.energy_residual < 1e-8
        assert run.statistics.energy_scale > 0.5


def test_rounding_does_not_grow_with_the_number_of_steps(runtime: Runtime) -> None:
    model = compiled(1, rhs=OSCILLATOR, energies="E[0] = v[0]*v[0]/2; E[1] = q[0]*q[0]/2; E[2] = E[0] + E[1];")
    with started(runtime, model, [1], [0], t_stop=300, max_step=1e-3) as run:
        run.advance([300])
        assert run.statistics.steps >= 300_000
        assert run.statistics.energy_residual < 3e-15  # without compensation 2e-14


# -------------------------------------------------------------------------------------------- parameters and assembly


def test_parameters_given_and_bound(runtime: Runtime) -> None:
    model = compiled(
        1,
        numbers=", .n_parameters = 2, .n_hoisted = 1",
        parameters="p[0] = mask[0] != 0 ? given[0] : 2; p[1] = mask[1] != 0 ? given[1] : 10*p[0];",
        hoist="c[0] = p[1]/p[0];",
        rhs="a[0] = c[0];",
        start="q[0] = p[0];",
    )
    for given, mask, expected in ((None, None, [2, 20]), ([3, 0], [1, 0], [3, 30]), ([0, 8], [0, 1], [2, 8])):
        with runtime.run(model, Settings(t_stop=1)) as run:
            run.set_parameters(given, mask)
            assert run.parameters == expected
            run.start()
            row = run.advance([1])[0]
            assert row[1:3].tolist() == pytest.approx([expected[0] + expected[1] / expected[0] / 2, expected[1] / expected[0]])


CIRCLE = "g[0] = q[0]*q[0] + q[1]*q[1] - 25; J[0] = 2*q[0]; J[1] = 2*q[1]; J[2] = J[3] = 0;"
TWICE = """
    g[0] = q[0]*q[0] + q[1]*q[1] - 25; g[1] = 1e6*g[0]; g[2] = q[0]*v[0] + q[1]*v[1];
    const double row[3][4] = {{2*q[0], 2*q[1], 0, 0}, {2e6*q[0], 2e6*q[1], 0, 0}, {v[0], v[1], q[0], q[1]}};
    for (int i = 0; i < 3; ++i) for (int j = 0; j < 4; ++j) J[4*i + j] = row[i][j];"""
FREE = "a[0] = a[1] = 0;"


def test_assembly_goes_to_the_nearest_solution(runtime: Runtime) -> None:
    model = compiled(2, numbers=", .n_initial = 1", initial=CIRCLE, start="q[0] = 3.5; q[1] = 3.5;", rhs=FREE)
    with runtime.run(model, Settings(t_stop=1)) as run:
        run.set_parameters()
        assert run.start() is Status.OK
        assert run.row()[0][1:3].tolist() == pytest.approx([5 / math.sqrt(2)] * 2, rel=1e-15)


def test_assembly_leaves_given_values_alone(runtime: Runtime) -> None:
    model = compiled(2, numbers=", .n_initial = 1", initial=CIRCLE, start="q[0] = 1; q[1] = 1;", rhs=FREE)
    with runtime.run(model, Settings(t_stop=1)) as run:
        run.set_parameters()
        assert run.start([3, math.nan]) is Status.OK
        assert run.row()[0][1:3].tolist() == pytest.approx([3, 4], rel=1e-15)


def test_assembly_takes_redundant_equations(runtime: Runtime) -> None:
    model = compiled(2, numbers=", .n_initial = 3", initial=TWICE, start="q[0] = 3; q[1] = 4.5; v[0] = 1;", rhs=FREE)
    with runtime.run(model, Settings(t_stop=1)) as run:
        run.set_parameters()
        assert run.start() is Status.OK
        x, y, vx, vy = run.row()[0][1:5]
        assert math.hypot(x, y) == pytest.approx(5, rel=1e-15)
        assert x * vx + y * vy == pytest.approx(0, abs=1e-14)


def test_assembly_names_the_equation_that_fails(runtime: Runtime) -> None:
    model = compiled(
        1,
        numbers=", .n_initial = 2",
        initial="g[0] = q[0] - 1; g[1] = v[0]*v[0] + 4; J[0] = 1; J[1] = J[2] = 0; J[3] = 2*v[0];",
        rhs=OSCILLATOR,
    )
    with runtime.run(model, Settings(t_stop=1)) as run:
        run.set_parameters()
        assert run.start([math.nan], [0.5]) is Status.INITIAL_FAILED
        assert (run.failure.index, run.failure.value) == (1, 4.25)
        assert run.advance([1]).status is Status.NOT_STARTED


# -------------------------------------------------------------------------------------------------------------- failures


def test_a_singularity_ends_the_run_and_keeps_its_rows(runtime: Runtime) -> None:
    fall = math.pi / (2 * math.sqrt(2))  # from rest at distance 1 into a centre of attraction
    with started(runtime, compiled(1, rhs="a[0] = -1/(q[0]*q[0]);"), [1], [0], t_stop=2, tolerance=1e-9) as run:
        rows = run.advance([0.5, 1.0, 1.5, 2.0])
        assert (rows.status, rows.count) == (Status.STEP_TOO_SMALL, 2)
        assert run.failure.time == pytest.approx(fall, rel=1e-6)
        assert run.failure.index == 0


def test_a_value_that_ends_is_approached(runtime: Runtime) -> None:
    with started(runtime, compiled(1, rhs="a[0] = sqrt(1 - t) * 0 - q[0];"), [1], [0], t_stop=2, tolerance=1e-9) as run:
        rows = run.advance([0.999, 1.5])
        assert (rows.status, rows.count) == (Status.STEP_TOO_SMALL, 1)
        assert run.failure.time == pytest.approx(1, abs=1e-9)
        assert rows[0][1] == pytest.approx(math.cos(0.999), rel=1e-8)


def test_a_start_that_is_not_finite_is_named(runtime: Runtime) -> None:
    model = compiled(3, rhs="a[0] = 1; a[1] = 1/q[1]; a[2] = sqrt(q[2]);")
    with runtime.run(model, Settings(t_stop=1)) as run:
        run.set_parameters()
        assert run.start([0, 1, -1]) is Status.NOT_FINITE
        assert run.failure.index == 2
        assert run.start([0, 0, 1]) is Status.NOT_FINITE
        assert run.failure.index == 1
        assert run.start([0, 1, 1]) is Status.OK


def test_limits(runtime: Runtime) -> None:
    model = compiled(1, rhs=OSCILLATOR)
    with started(runtime, model, [1], [0], t_stop=100, tolerance=1e-20, max_steps=10) as run:
        assert run.statistics.tolerance_raised
        assert run.advance([100]).status is Status.TOO_MANY_STEPS
        assert run.statistics.steps == 10
        assert run.advance([0]).status is Status.TIME_PASSED
        assert run.advance([101]).status is Status.PAST_STOP
    with started(runtime, model, [1], [0], t_stop=10, max_step=0.01) as run:
        run.advance([10 * (1 + 1e-16)])
        assert run.statistics.largest_step <= 0.01 * (1 + 1e-9)
        assert run.statistics.steps >= 1000


def test_a_pause_loses_nothing(runtime: Runtime) -> None:
    model = compiled(1, rhs=OSCILLATOR)
    times = [10.0 * i for i in range(101)]
    with started(runtime, model, [1], [0], t_stop=1000, tolerance=1e-10) as run:
        whole = run.advance(times).values
    with started(runtime, model, [1], [0], t_stop=1000, tolerance=1e-10) as run:
        pieces, pauses = array("d"), 0
        while len(pieces) < len(whole):
            rows = run.advance(times[len(pieces) // run.width :], seconds=1e-9)
            pieces.extend(rows.values)
            pauses += rows.status is Status.PAUSED
    assert pieces == whole
    assert pauses > 5


@pytest.mark.parametrize(
    "settings", [Settings(t_stop=-1), Settings(tolerance=0), Settings(tolerance=math.nan), Settings(t_start=math.inf)]
)
def test_bad_settings(runtime: Runtime, settings: Settings) -> None:
    with runtime.run(compiled(1, rhs=OSCILLATOR), settings) as run:
        run.set_parameters()
        assert run.start() is Status.BAD_SETTINGS


def test_bad_inputs(runtime: Runtime) -> None:
    with runtime.run(compiled(1, numbers=", .n_inputs = 1", rhs="a[0] = u[0];"), Settings()) as run:
        assert run.set_inputs([0, 2, 1], [0, 0, 0]) is Status.BAD_INPUTS
        assert run.set_inputs([math.nan], [0]) is Status.BAD_INPUTS
        assert run.set_inputs([0, 1, 1], [0, 0, 0]) is Status.OK


# ----------------------------------------------------------------------------------------------------------------- tapes


def tape_of(function: "object") -> Tape:
    """A CasADi SX function as a tape."""
    import casadi as ca

    assert isinstance(function, ca.Function)
    names = {getattr(ca, f"OP_{op.name}"): op for op in Op}
    code, constants = array("i"), array("d")
    for k in range(function.n_instructions()):
        op, i, o = names[function.instruction_id(k)], function.instruction_input(k), function.instruction_output(k)
        if op is Op.CONST:
            code.extend((op, o[0], len(constants), 0))
            constants.append(function.instruction_constant(k))
        elif op is Op.INPUT:
            code.extend((op, o[0], i[0], i[1]))
        elif op is Op.OUTPUT:
            code.extend((op, o[0], i[0], o[1]))
        else:
            code.extend((op, o[0], i[0], i[-1]))
    sizes = ([function.numel_in(i) for i in range(function.n_in())], [function.numel_out(i) for i in range(function.n_out())])
    return Tape(*sizes, function.sz_w(), code, constants)


def state_function(n: int, n_u: int, result: "object", *, outputs: bool = False) -> Tape:
    """A tape with the inputs of rhs (or of outputs); `result` maps the symbols (q, v, u) to a list of expressions."""
    import casadi as ca

    t, q, v, a, l, u, d, c = (ca.SX.sym(name, size) for name, size in zip("tqvaludc", (1, n, n, n, 0, n_u, 0, 0), strict=True))
    symbols = [t, q, v, a, l, u, d, c] if outputs else [t, q, v, u, d, c]
    return tape_of(ca.Function("f", symbols, result(q, v, u)))


@pytest.mark.parametrize(("x", "y"), [(0.3, -0.7), (-1.4, 0.5), (0.0, 1.0), (2.5, 0.0), (3.0, 3.0)])
def test_every_operation_of_a_tape(runtime: Runtime, x: float, y: float) -> None:
    ca = pytest.importorskip("casadi")
    unary = "sqrt sin cos tan asin acos atan exp log fabs sign floor ceil sinh cosh tanh asinh acosh atanh erf logic_not"
    binary = "atan2 fmin fmax fmod copysign logic_and logic_or"

    def everything(_q: "object", _v: "object", u: list) -> list:
        a, b = u[0], u[1]
        single = [getattr(ca, name)(a) for name in unary.split()] + [-a, 1 / a, 2 * a, a**2, a**3]
        double = [getattr(ca, name)(a, b) for name in binary.split()]
        double += [a + b, a - b, a * b, a / b, a**b, 0.1 + a, a < b, a <= b, a == b, a != b]
        return [ca.vertcat(*single, *double, ca.if_else(a > b, a, 1 / b))]

    function = ca.Function("f", [u := ca.SX.sym("u", 2)], everything(None, None, u))
    outputs = state_function(0, 2, everything, outputs=True)
    start = tape_of(ca.Function("start", [ca.SX.sym("p", 0)], [ca.SX(0, 1), ca.SX(0, 1)]))
    model = Model.from_tapes({"n_inputs": 2, "n_outputs": outputs.out_sizes[0]}, {"start": start, "outputs": outputs}, [], [])
    model.check_tapes(runtime.library)
    assert set(outputs.code[0::4]) >= set(Op) - {Op.ASSIGN, Op.CONSTPOW}
    with runtime.run(model, Settings(t_stop=1)) as run:
        run.set_parameters()
        run.set_inputs([0], [x, y])
        assert run.start() is Status.OK
        computed = run.row()[0][1 : 1 + outputs.out_sizes[0]].tolist()
    assert computed == pytest.approx([float(z) for z in function([x, y]).full().flat], rel=1e-15, nan_ok=True)


def test_a_tape_runs_like_compiled_code(runtime: Runtime) -> None:
    ca = pytest.importorskip("casadi")
    rhs = state_function(2, 0, lambda q, v, u: [-q / ca.sumsqr(q) ** 1.5, ca.SX(0, 1)])
    start = tape_of(ca.Function("start", [ca.SX.sym("p", 0)], [ca.SX([0.4, 0]), ca.SX([0, 2])]))
    model = Model.from_tapes({"n": 2}, {"start": start, "rhs": rhs}, [1, 1], [0] * 4)
    with runtime.run(model, Settings(t_stop=20, tolerance=1e-12)) as run:
        run.set_parameters()
        run.start()
        assert run.advance([20])[0][1:5].tolist() == pytest.approx(CASES["Kepler 0.6"].reference[20], abs=1e-9)


@pytest.mark.parametrize(
    "instruction",
    [(Op.ADD, 0, 1, 9), (99, 0, 0, 0), (Op.INPUT, 0, 7, 0), (Op.OUTPUT, 0, 0, 5), (Op.CONST, 0, 1, 0), (Op.SIN, -1, 0, 0)],
)
def test_a_tape_that_reaches_outside_is_refused(runtime: Runtime, instruction: tuple[int, ...]) -> None:
    tape = Tape([1], [1], 2, array("i", [Op.INPUT, 0, 0, 0, *instruction]), array("d", [1.0]))
    model = Model.from_tapes({}, {"hoist": tape}, [], [])
    with pytest.raises(ValueError, match="hoist"):
        model.check_tapes(runtime.library)


# --------------------------------------------------------------------------------------------------------------- hygiene


def test_work_without_end_is_bounded(runtime: Runtime) -> None:
    """1e13 vibrations a second from t = 0.5 on; and equal steps where a force jumps, which would be 1e6 times as many
    as others. A limit of steps given takes the place of both bounds."""
    model = compiled(1, rhs="a[0] = t < 0.5 ? 0 : -1e26*q[0];")
    with started(runtime, model, [1], [0], t_stop=1, solver=Solver.ERK) as run:
        assert run.advance([1]).status is Status.NO_PROGRESS
        assert run.failure.time == pytest.approx(0.5, abs=1e-6) and run.failure.value > 1e10
    jump = compiled(1, numbers=", .is_separable = 1", rhs="a[0] = -10*(fabs(q[0]) - 0.4)*(q[0] > 0 ? 1 : -1);",
                    energies="E[0] = v[0]*v[0]/2; E[1] = 5*(fabs(q[0]) - 0.4)*(fabs(q[0]) - 0.4); E[2] = E[0] + E[1];")
    settings = {"t_stop": 2, "tolerance": 1e-12, "solver": Solver.CONSERVATIVE}
    with started(runtime, jump, [1], [0], **settings) as run:
        assert run.advance([2]).status is Status.NO_PROGRESS
        assert run.statistics.steps == 0
    with started(runtime, jump, [1], [0], max_steps=100, **settings) as run:
        assert run.advance([2]).status is Status.TOO_MANY_STEPS
