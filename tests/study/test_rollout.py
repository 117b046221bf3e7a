"""Motions from arrays to arrays, against single runs that are told the same."""

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.native.build import find_compiler
from lagrangia.run.batch import Batch

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
PUSHED = """model Pushed
  input Force F; parameter Mass m = 0.1;
  Block    cart(m = 1, base = world, along = {1, 0});
  Revolute hinge(a = turn(cart.center, 90[deg]), phi(start = 0.1));
  Bar      pole(m = m, L = 1, a = hinge.b);
  AppliedForce push(at = cart.center, force = {F, 0});
  output Length tip = pole.b.x;
end Pushed;
"""
Scene = Callable[[str], lag.Model]
TIMES = 0.02 * np.arange(26)


def test_each_run_is_the_one_in_steps(scene: Scene) -> None:
    """To rounding, as runs go in lanes; and bit for bit on however many cores, in any company."""
    model, random = scene(PUSHED), np.random.default_rng(1)
    q0, v0, u = random.normal(size=(9, 2)), random.normal(size=(9, 2)), random.normal(size=(9, 25, 1))
    masses = np.linspace(0.1, 0.5, 9)
    found = model.rollout(q0, v0, {"m": masses}, u, times=TIMES, tolerance=1e-8)
    again = model.rollout(q0, v0, {"m": masses}, u, times=TIMES, tolerance=1e-8, jobs=1)
    assert found.q.shape == found.v.shape == (9, 26, 2) and found.ok.all() and not found.failures
    assert np.array_equal(found.rows, again.rows)
    few = model.rollout(q0[5:], v0[5:], {"m": masses[5:]}, u[5:], times=TIMES, tolerance=1e-8)
    assert np.array_equal(found.rows[5:], few.rows)
    for k in range(9):
        start = dict(zip(("cart.s", "hinge.phi", "der(cart.s)", "der(hinge.phi)"), (*q0[k], *v0[k]), strict=True))
        one = model.start(initial=start, parameters={"m": masses[k]}, inputs={"F": u[k, 0, 0]}, tolerance=1e-8)
        rows = one.steps(u[k], 0.02)
        np.testing.assert_allclose(found.rows[k, 1:], rows[:, : found.rows.shape[2]], rtol=1e-13, atol=1e-14)
        table = np.repeat(TIMES, 2)[1:-1], {"F": np.repeat(u[k, :, 0], 2)}
        exact = model.simulate(at=TIMES, inputs=table, initial=start, parameters={"m": masses[k]}, tolerance=1e-12)
        np.testing.assert_allclose(found["tip"][k], exact["tip"], rtol=0, atol=1e-7)


def test_they_are_told_in_a_line(scene: Scene) -> None:
    """All rows of all runs were printed where one stood at the end of a notebook's cell."""
    found = scene(PUSHED).rollout(u=np.zeros((9, 25, 1)), times=TIMES)
    assert repr(found) == "<9 rollouts of Pushed, 26 times from 0 to 0.5 s: cart.s, hinge.phi, der(cart.s), der(hinge.phi), tip>"


def test_loose_tolerances_take_fewer_orders(scene: Scene) -> None:
    """Short steps had all digits that there are, whatever was asked for. All of a run err by less than one long one may."""
    model, u = scene(PUSHED), np.random.default_rng(3).normal(size=(9, 25, 1))
    exact = model.rollout(u=u, times=TIMES, tolerance=1e-12, solver="erk9").q
    errors = [np.abs(model.rollout(u=u, times=TIMES, tolerance=tolerance).q - exact).max() for tolerance in (1e-3, 1e-8)]
    assert errors[1] < 1e-15 and 2e-15 < errors[0] < 0.004e-3


def test_rows_at_ends_of_steps_have_energies_now_and_then(scene: Scene) -> None:
    """Nobody asks for them, and they take as long as all else of such a row: one in eight has them, and the last one, for the
    account, where parameters vary. All do where a measure asks for them."""
    model, u = scene(PUSHED), np.random.default_rng(2).normal(size=(9, 25, 1))
    job, engine = model.rollout(p={"m": np.linspace(0.1, 0.2, 9)}, u=u, times=TIMES).sweep.job, model.engine_for("auto")
    assert engine is not None
    known = []
    for column in (1, 6):  # a coordinate; the kinetic energy
        reductions = [replace(reduction, column=column) for reduction in job.sweep.reductions]
        with Batch(engine.runtime, engine.model, replace(job.sweep, reductions=reductions)) as batch:
            _, outcomes, rows = batch.advance(job.variations.values(0, job.runs), held=u)
            assert batch.lanes.runs == 9 and (outcomes["energy"] > 0).all() and (outcomes["energy"] < 1e-6).all()
            known += [rows]
    few, whole = known
    asked = [0, 8, 16, 24, 25]
    assert np.array_equal(few[:, :, :-5], whole[:, :, :-5]) and np.isfinite(whole).all()
    assert np.array_equal(few[:, asked], whole[:, asked]) and np.isnan(np.delete(few, asked, axis=1)[:, :, -5:]).all()


@pytest.mark.parametrize(("times", "steps"), [(TIMES, 25), (np.linspace(0, 60, 4), 300)])
@pytest.mark.parametrize("output", ["", "output Length tip = pole.b.x;", "output Acceleration a = der(hinge.w)*1[m] + F/1[kg];"])
def test_rows_of_states_alone_are_those_of_whole_rows(output: str, times: np.ndarray, steps: int, scene: Scene) -> None:
    """Bit for bit, in any company: of runs that are nothing but their states in lanes, until they have made so many steps between
    rows that more is looked at."""
    model = scene(PUSHED.replace("output Length tip = pole.b.x;", output))
    random, engine = np.random.default_rng(4), model.engine_for("auto")
    q0, u = random.normal(size=(21, 2)), random.normal(size=(21, len(times) - 1, 1))
    found = model.rollout(q0, u=u, times=times, tolerance=1e-9)
    job, ledger = found.sweep.job, found.sweep.ledger
    again = model.rollout(q0[::-1], u=u[::-1], times=times, tolerance=1e-9, jobs=1)
    assert np.array_equal(found.rows, again.rows[::-1]) and (ledger.outcomes == again.sweep.ledger.outcomes[::-1]).all()
    assert ledger.lanes.alone == 0 and ledger.lanes.steps >= 21 * steps
    whole = [replace(reduction, column=6) for reduction in job.sweep.reductions]  # the kinetic energy
    assert engine is not None
    with Batch(engine.runtime, engine.model, replace(job.sweep, reductions=whole)) as batch:
        rows = batch.advance(job.variations.values(0, job.runs), held=u)[2]
    assert np.array_equal(found.rows, rows[:, :, : found.rows.shape[2]])


def damped(q: np.ndarray, v: np.ndarray, force: np.ndarray, t: float) -> np.ndarray:
    """s at t: s'' = F - 0.3 s' - 10 s."""
    decay, offset = 0.15, q - force / 10
    pace = np.sqrt(10 - decay**2)
    return force / 10 + np.exp(-decay * t) * (offset * np.cos(pace * t) + (v + decay * offset) / pace * np.sin(pace * t))


def driven(q: np.ndarray, v: np.ndarray, force: np.ndarray, t: float) -> np.ndarray:
    """s at t: s'' = F sin(3 t)."""
    return q + (v + force / 3) * t - force / 9 * np.sin(3 * t)


@pytest.mark.parametrize(
    ("energies", "exact", "tolerance", "error"),
    [
        ("potential 5[N/m]*s^2; work F - 0.3[N.s/m]*v on s;", damped, 1e-3, 3e-10),
        ("work F*sin(3/1[s]*time) on s;", driven, 1e-6, 1e-13),
    ],
)
def test_all_weigh_errors_of_work(
    energies: str, exact: Callable[..., np.ndarray], tolerance: float, error: float, scene: Scene
) -> None:
    """Those that came into lanes after others had ended there did not: their steps were so long that accounts did not close, and
    others in other company."""
    model = scene(f"""model M
      input Force F; coordinate Length s; Velocity v = der(s); energy kinetic 0.5[kg]*v^2; {energies}
    end M;""")
    random, runs = np.random.default_rng(1), 60
    q, v, u = 0.3 * random.normal(size=(runs, 1)), 0.5 * random.normal(size=(runs, 1)), random.normal(size=(runs, 3, 1))
    for times in ([0, 2.0], np.linspace(0, 60, 4)):
        held = u[:, : len(times) - 1]
        found = model.rollout(q, v, u=held, times=times, tolerance=tolerance, solver="taylor")
        again = model.rollout(q[::-1], v[::-1], u=held[::-1], times=times, tolerance=tolerance, solver="taylor", jobs=1)
        assert np.array_equal(found.rows, again.rows[::-1]) and found.sweep.ledger.lanes.alone == 0
        if len(times) == 2:
            miss = np.abs(found.q[:, 1, 0] - exact(q[:, 0], v[:, 0], held[:, 0, 0], 2.0))
            assert np.median(miss) < error


def test_what_is_not_given_is_as_declared(scene: Scene) -> None:
    model = scene(PUSHED)
    alone = model.rollout(times=TIMES)
    assert alone.rows.shape[0] == 1 and alone["hinge.phi"][0, 0] == 0.1
    free = model.simulate(at=TIMES, inputs={"F": 0}, tolerance=1e-12)
    np.testing.assert_allclose(alone["hinge.phi"][0], free["hinge.phi"], atol=1e-7)
    pushed = model.rollout(u=np.ones((3, 25, 1)), times=TIMES)
    assert pushed.rows.shape[0] == 3 and np.array_equal(pushed.rows[0], pushed.rows[2])
    assert pushed["cart.s"][0, -1] > alone["cart.s"][0, -1]
    one_start = model.rollout([0.0, 0.2], p={"m": [0.1, 0.2]}, times=TIMES)
    assert one_start["hinge.phi"][:, 0].tolist() == [0.2, 0.2]


def test_runs_that_fail_are_told_and_the_others_go_on(scene: Scene) -> None:
    model = scene("""model Explosion coordinate Length s(start = 1); Velocity v(start = 2) = der(s);
      energy kinetic 1[kg]*v^2/2; potential -2[J/m3]*s^3; end Explosion;""")
    found = model.rollout([[1.0], [0.1]], [[2.0], [0.0]], times=[0, 0.5, 3])
    assert found.ok.tolist() == [False, True] and [*found.failures] == [0]
    assert np.isnan(found.q[0, 2, 0]) and found.q[0, 1, 0] == pytest.approx(4, rel=1e-6) and np.isfinite(found.q[1]).all()


@pytest.mark.parametrize(("given", "told"), [
    ({"q0": np.zeros((2, 3))}, r"q0 has the shape \(runs, 2\)"), ({"u": np.zeros((2, 25))}, r"u has the shape \(runs, 25, 1\)"),
    ({"u": np.full((2, 25, 1), np.nan)}, r"and u\[0, 0, 0\] is nan"),
    ({"u": np.zeros((0, 25, 1)), "q0": np.zeros((3, 2))}, "'u' is of 0 runs"),
    ({"u": np.ma.masked_greater(np.eye(25)[None, :, :1], 0)}, "1 of it are masked"),
    ({"q0": np.zeros((2, 2)), "u": np.zeros((3, 25, 1))}, "others are of 3"),
    ({"p": {"mass": [1.0, 2.0]}}, "mass"), ({"p": {"m": [-1.0]}}, "m"), ({"q0": [[0.0, np.inf]]}, "finite"),
    ({"times": [0.0]}, "two numbers or more"), ({"times": [1.0, 0.0]}, "finite and rising"),
    ({"solver": "casadi:cvodes"}, "own solvers"), ({"u": np.zeros((2, 25, 1)) + 1j}, "u must be an array of real numbers, not o"),
    ({"q0": [[0.0, 1.0], [2.0]]}, "q0 must be an array of real"), ({"times": "1 s"}, "times must be"), ({"p": [0.1]}, "mapping"),
    ({"p": {"m": "0.1[kg]"}}, "'m' must be an array"), ({"p": {"m": np.ones((2, 2))}}, r"one for each run, not .* \(2, 2\)")])
def test_what_does_not_fit_is_told(given: dict[str, object], told: str, scene: Scene) -> None:
    model = scene(PUSHED.replace("parameter Mass m = 0.1", "parameter Mass m(min = 0) = 0.1"))
    if str(given) == str({"p": {"m": [-1.0]}}):
        assert "minimum" in model.rollout(**given, times=TIMES).failures[0]
        return
    with pytest.raises(lag.LagError, match=told):
        model.rollout(**({"times": TIMES} | given))
