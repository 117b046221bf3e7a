"""Many runs: what is varied, what is kept of each run, failures, journals, tables, and the command `lag sweep`."""

import math
import threading
from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import numpy as np
import pytest
from scipy.optimize import brentq

import lagrangia as lag
from constraints.test_constraints import MASSLESS
from helpers.sanitizers import needs_sanitizers, run_sanitized
from lagrangia.base.folders import data_folder
from lagrangia.native.build import find_compiler
from lagrangia.study.sweep.pieces import Pieces

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

FOLDER = data_folder("runtime")
EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
# s = s0 cos(w t) with w = sqrt(k/m)
OSCILLATOR = """model Oscillator "a block on a spring"
  parameter Mass m = 2; parameter Stiffness k = 8; parameter Length s0 = 0.5; parameter Mass half = m/2;
  Block block(m = m, base = world, along = {1, 0}, s(start = s0));
  Spring spring(k = k, stretch = block.s);
  output Length shifted = block.s + 1;
  output Real swell = time*block.s/1[m.s];
  output Real quick = sin(40[1/s]*time);
  output Real steady = 2;
  output Real square = if time > 1 and time < 2 then 1 else 0;
  annotation(experiment(StopTime = 4, Tolerance = 1e-11));
end Oscillator;
"""
# s'' = 6 s^2 from s = 1, s' = v0 = 2 is s = 1/(1 - t)^2: infinite at t = 1.
EXPLOSION = """model Explosion
  parameter Velocity v0 = 2; parameter Real a = 2;
  coordinate Length s(start = 1); Velocity v(start = v0) = der(s);
energy
  kinetic 1[kg]*v^2/2; potential -a*1[J/m3]*s^3;
  annotation(experiment(StopTime = 3));
end Explosion;
"""
Scene = Callable[[str], lag.Model]


# ---------------------------------------------------------------- what is kept of a run


def rms(w: float, stop: float) -> float:
    """Of 0.5 cos(w t) over 0 .. stop."""
    return 0.5 * math.sqrt(0.5 + math.sin(2 * w * stop) / (4 * w * stop))


def turn_of_swell(w: float) -> float:
    """The last minimum of t cos(w t) in 0 .. 4."""
    begin = {2.0: 3.0, 3.0: 9.0}[w]
    return brentq(lambda x: math.cos(x) - x * math.sin(x), begin, begin + 1, xtol=1e-14) / w


def mean_of_absolute(w: float, stop: float) -> float:
    """Of 0.5 cos(w t): pieces between zeros."""
    zeros = [0.0, *(math.pi * (k + 0.5) / w for k in range(100) if math.pi * (k + 0.5) / w < stop), stop]
    return sum(abs(math.sin(w * b) - math.sin(w * a)) for a, b in pairwise(zeros)) * 0.5 / w / stop


@pytest.mark.parametrize(
    ("measure", "expected"),
    [
        ("final(block.s)", lambda w: 0.5 * math.cos(4 * w)),
        ("block.s", lambda w: 0.5 * math.cos(4 * w)),
        ("initial(block.s)", lambda w: 0.5),
        ("at(1.3, block.s)", lambda w: 0.5 * math.cos(1.3 * w)),
        ("at(1300[ms], abs(block.s))", lambda w: abs(0.5 * math.cos(1.3 * w))),
        ("min(block.s)", lambda w: -0.5),
        ("max(shifted)", lambda w: 1.5),
        ("max(abs(der(block.s)))", lambda w: 0.5 * w),
        ("min(abs(block.s))", lambda w: 0.0),
        ("time_of_min(swell)", turn_of_swell),
        ("min(swell)", lambda w: turn_of_swell(w) * 0.5 * math.cos(w * turn_of_swell(w))),
        ("range(shifted)", lambda w: 1.0),
        ("mean(block.s)", lambda w: 0.5 * math.sin(4 * w) / (4 * w)),
        ("mean(abs(block.s))", lambda w: mean_of_absolute(w, 4)),
        ("rms(block.s)", lambda w: rms(w, 4)),
        ("first_time(block.s < 0)", lambda w: math.pi / 2 / w),
        ("first_time(block.s < -501[mm])", lambda w: math.nan),
        ("first_time(shifted > 1)", lambda w: 0.0),
        ("first_time(shifted >= 1.5)", lambda w: 0.0),
        ("first_time(block.s <= 0.5)", lambda w: 0.0),
        ("first_time(der(block.s) >= 0)", lambda w: 0.0),
        ("first_time(der(block.s) > 0)", lambda w: math.pi / w),
        ("last_time(steady >= 2)", lambda w: 4.0),
        ("first_time(steady <= 2)", lambda w: 0.0),
        ("last_time(steady > 2)", lambda w: math.nan),
        ("last_time(block.s >= 0.25)", lambda w: {2.0: math.pi + math.acos(0.5) / 2, 3.0: 4.0}[w]),
        ("first_time(abs(block.s) < 0.1)", lambda w: math.acos(0.2) / w),
        ("last_time(abs(der(block.s)) > 0.4)", lambda w: 4.0),
        ("last_time(block.s > 0.25)", lambda w: {2.0: math.pi + math.acos(0.5) / 2, 3.0: 4.0}[w]),
        ("max(time)", lambda w: 4.0),
        ("max(energy.kinetic)", lambda w: 0.25 * w * w),
        ("mean(energy.potential)", lambda w: w * w * rms(w, 4) ** 2),
        ("rms(square)", lambda w: 0.5),
        ("first_time(square > 0.5)", lambda w: 1.0),
        ("last_time(square > 0.5)", lambda w: 2.0),
        ("max(quick)", lambda w: 1.0),
    ],
)
@pytest.mark.parametrize("k", [8.0, 18.0])
def test_measures_are_those_of_the_motion(scene: Scene, measure: str, expected: Callable[[float], float], k: float) -> None:
    """Against the closed solution, far closer than rows on a grid could be."""
    w = math.sqrt(k / 2)
    found = scene(OSCILLATOR).simulate_many(parameters={"k": k}, outputs=[measure])
    assert found.failures == {}
    assert found[measure][0] == pytest.approx(expected(w), abs=2e-8, nan_ok=True)


def top(y: np.ndarray) -> float:
    """Of the parabola through the largest value and its neighbours."""
    k = int(y.argmax())
    if k in (0, len(y) - 1):
        return float(y[k])
    before, value, after = y[k - 1 : k + 2]
    return float(value + (after - before) ** 2 / (8 * (2 * value - before - after)))


def test_measures_agree_with_rows_of_chaotic_runs(tmp_path: Path) -> None:
    """Extremes and crossings against 20 000 rows of the same runs."""
    model = lag.load(EXAMPLES / "double_pendulum.lag")
    phi = np.linspace(-1.5, 1.5, 13)
    texts = ["max(lower.b.y)", "time_of_min(lower.b.x)", "range(der(elbow.phi))", "first_time(lower.b.y > 0.1)",
             "last_time(abs(elbow.phi) < 1)", "mean(lower.b.y)", "rms(der(shoulder.phi))", "max(abs(elbow.phi))"]
    table = model.simulate_many(initial={"elbow.phi": phi}, outputs=texts, stop=5, tolerance=1e-9)
    times = np.linspace(0, 5, 20_001)
    for k, angle in enumerate(phi):
        run = model.simulate(at=times.tolist(), tolerance=1e-9, initial={"elbow.phi": float(angle)})
        x, y, elbow, rate = run["lower.b.x"], run["lower.b.y"], run["elbow.phi"], run["der(shoulder.phi)"]
        above, near = times[y > 0.1], times[np.abs(elbow) < 1]
        whip = run["der(elbow.phi)"]
        expected = [top(y), times[x.argmin()], top(whip) + top(-whip), above[0] if len(above) else math.nan,
                    near[-1] if len(near) else math.nan, np.trapezoid(y, times) / 5, math.sqrt(np.trapezoid(rate**2, times) / 5),
                    top(np.abs(elbow))]
        for text, value in zip(texts, expected, strict=True):
            slack = 3e-4 if "time" in text else 1e-6 * max(1, abs(value))
            assert table[text][k] == pytest.approx(value, abs=slack, nan_ok=True), (text, angle)


def test_an_interval_shows_what_oscillates_within_a_step(scene: Scene) -> None:
    model = scene(OSCILLATOR.replace("40[1/s]", "2000[1/s]"))
    coarse = model.simulate_many(outputs=["rms(quick)"])["rms(quick)"][0]
    fine = model.simulate_many(outputs=["rms(quick)"], interval=1e-3)["rms(quick)"][0]
    exact = math.sqrt(0.5 - math.sin(2 * 2000 * 4) / (4 * 2000 * 4))
    assert fine == pytest.approx(exact, abs=1e-6)
    assert abs(coarse - exact) > 1e-4, "or the test shows nothing"


def test_islands_are_asked_for_rows_alone(scene: Scene) -> None:
    """They do not go back to look what was between two rows; `auto` takes them only where nobody wants to know."""
    model = scene("""model Two
  Revolute hinge(a = world, phi(start = 1)); Bar bar(m = 1, L = 1, a = hinge.b);
  Block block(m = 1, base = world, s(start = 0.1)); Spring spring(k = 1e5, stretch = block.s);
  annotation(experiment(StopTime = 2));
end Two;""")
    outputs = ["mean(hinge.phi)", "max(block.s)", "at(1.3, block.s)"]
    alone = model.simulate_many(parameters={"block.m": [1.0, 2.0]}, outputs=outputs, interval=0.01)
    whole = model.simulate_many(parameters={"block.m": [1.0, 2.0]}, outputs=outputs, solver="erk")
    for name in outputs:
        assert alone[name] == pytest.approx(whole[name], abs=1e-6)
    with pytest.raises(lag.LagError, match="between rows"):
        model.simulate_many(outputs=outputs, solver="islands", interval=0.01)
    apart = model.simulate_many(parameters={"block.m": [1.0, 2.0]}, outputs=["at(1.3, block.s)"], solver="islands")
    assert apart["at(1.3, block.s)"] == pytest.approx(whole["at(1.3, block.s)"], abs=1e-6)


def test_the_exact_solver_is_looked_at_as_closely_as_asked(scene: Scene) -> None:
    """Its steps say nothing of how quick the motion is."""
    model = scene(OSCILLATOR)
    outputs = ["max(block.s)", "rms(block.s)", "last_time(block.s > 0.25)", "first_time(square > 0.5)", "at(1.3, block.s)"]
    with pytest.raises(lag.LagError, match="--interval"):
        model.simulate_many(outputs=outputs, solver="linear")
    exact, other, usual = (model.simulate_many(parameters={"k": [8, 18]}, outputs=outputs, solver=solver, interval=interval)
                           for solver, interval in (("linear", 0.1), ("erk", None), ("auto", None)))
    assert exact.ledger.results == pytest.approx(other.ledger.results, abs=1e-8)
    assert exact.ledger.outcomes["steps"].max() < 50 < other.ledger.outcomes["steps"].min()
    assert usual.ledger.results == pytest.approx(other.ledger.results, abs=1e-7)
    assert model.simulate_many(outputs=["block.s"], solver="linear")["block.s"][0] == pytest.approx(0.5 * math.cos(8), abs=1e-12)


def test_a_stiff_linear_scene_goes_over_to_implicit_steps() -> None:
    """Looked at between rows, it is no matter for the exact solver; explicit steps would be 10 million."""
    model = lag.load(EXAMPLES / "quarter_car.lag")
    found = model.simulate_many(parameters={"m2": [1e-6, 1e-3]}, outputs=["max(car.s)", "wheel.s"], stop=1)
    assert found.ledger.outcomes["steps"].max() < 1000
    exact = model.simulate(parameters={"m2": 1e-6}, solver="linear", at=[0, 1])
    assert found["wheel.s"][0] == pytest.approx(exact["wheel.s"][-1], abs=1e-9)


def test_runs_do_not_depend_on_each_other(tmp_path: Path) -> None:
    """Bit by bit: in any order, on one thread or three; also of constrained scenes. As simulate has it, or (lanes) as exactly."""
    for name, given, chosen in (("double_pendulum", "elbow.phi", "shoulder.phi"), ("four_bar", None, None)):
        model = lag.load(EXAMPLES / f"{name}.lag")
        quantity = chosen or model.coordinate_names[0]
        parameter = next(p for p in model.scene.parameters if p.value and p.minimum is not None)
        values = (parameter.value or 0) * np.linspace(0.98, 1.02, 12)
        initial = {given: 1.1} if given else {}
        outputs = [f"final({quantity})", f"max(der({quantity}))"]
        options = {"outputs": outputs, "stop": 2.0, "tolerance": 1e-7, "initial": initial}
        forward, again, backward = (model.simulate_many(parameters={parameter.name: v}, jobs=jobs, **options).ledger.results
                                    for v, jobs in ((values, 1), (values, 3), (values[::-1], 1)))
        assert np.isfinite(forward).all()
        assert forward.tobytes() == again.tobytes() == np.ascontiguousarray(backward[::-1]).tobytes()
        single = model.simulate(at=[2.0], tolerance=1e-7, parameters={parameter.name: float(values[5])}, initial=initial)
        ends = model.simulate_many(parameters={parameter.name: values}, **options | {"outputs": outputs[:1]}).ledger.results
        assert single[quantity][-1] == pytest.approx(ends[5, 0], rel=1e-7 if name == "double_pendulum" else 0)
        assert ends[5, 0] == pytest.approx(forward[5, 0], rel=1e-6)


def test_masses_that_vanish_in_some_runs_get_formulas_that_hold(scene: Scene) -> None:
    bar = "Revolute A(a = crank.b), B(a = coupler.b, b = rocker.b); Bar coupler(m = 1, L = 1, a = A.b);"
    model = scene(MASSLESS.format(coupler=bar))
    table = model.simulate_many(parameters={"coupler.m": [1, 0]}, outputs=["O.phi"], stop=2, tolerance=1e-11)
    assert table.failures == {}
    for k, m in enumerate((1, 0)):
        single = model.simulate(at=[2], tolerance=1e-11, parameters={"coupler.m": m})
        assert table["O.phi"][k] == pytest.approx(single["O.phi"][-1], abs=1e-8)


# ---------------------------------------------------------------- what is varied


def test_experiments_nest(scene: Scene) -> None:
    """Each design of a table with each value of a list."""
    table = scene(OSCILLATOR).simulate_many(runs={"m": [1, 2], "k": [20, 10]}, initial={"block.s": [0.1, 0.2]})
    assert [table[name].tolist() for name in ("m", "k", "block.s")] == [[1, 1, 2, 2], [20, 20, 10, 10], [0.1, 0.2, 0.1, 0.2]]


def test_all_combinations_the_last_changing_fastest(scene: Scene) -> None:
    table = scene(OSCILLATOR).simulate_many(parameters={"m": [1, 2], "k": "10:30:10"}, initial={"block.s": (0.1, 0.2)})
    assert table.runs == 12
    assert table["m"].tolist() == [1.0] * 6 + [2.0] * 6
    assert table["k"].tolist() == [10.0, 10, 20, 20, 30, 30] * 2
    assert table["block.s"].tolist() == [0.1, 0.2] * 6
    w = np.sqrt(table["k"] / table["m"])
    assert table["final(block.s)"] == pytest.approx(table["block.s"] * np.cos(4 * w), abs=1e-9)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("100:2000:50", list(range(100, 2001, 50))),
        ("0:1:0.1", [k / 10 for k in range(11)]),
        ("3:1:-1", [3, 2, 1]),
        ("0:1:0.4", [0, 0.4, 0.8]),
        ("1, 2 ,5", [1, 2, 5]),
        ("1[kN/m],20[N/cm]", [1000, 2000]),
        ("linspace(1, 2, 5)", [1, 1.25, 1.5, 1.75, 2]),
        ("geomspace(1[N/m], 1[kN/m], 4)", [1, 10, 100, 1000]),
    ],
)
def test_values_as_they_are_written(scene: Scene, text: str, expected: list[float]) -> None:
    table = scene(OSCILLATOR).simulate_many(parameters={"k": text}, stop=0.01)
    assert table["k"] == pytest.approx(expected, rel=1e-14)


def test_dependent_parameters_follow_and_vectors_are_varied_whole(scene: Scene) -> None:
    model = scene("model P PointMass p(m = 1); end P;")
    table = model.simulate_many(parameters={"world.gravity": "{0,-9.81},{0,-1.62}"}, outputs=["p.center.y"], stop=2)
    assert table.names == ["world.gravity[1]", "world.gravity[2]", "final(p.center.y)"]
    assert table["p.center.y"] == pytest.approx([-2 * 9.81, -2 * 1.62])
    assert model.simulate_many(parameters={"world.gravity": [[0, -2], [0, -3]]}, outputs=["p.center.y"], stop=2)[
        "p.center.y"] == pytest.approx([-4, -6])


def test_a_list_of_one_value_is_a_column(scene: Scene) -> None:
    """One value alone is none."""
    model = scene(OSCILLATOR)
    for given in ([8], (8,), np.array([8.0]), "linspace(8, 8, 1)", "8:8:1"):
        table = model.simulate_many(parameters={"k": given, "m": 2}, outputs=["max(block.s)"], stop=0.1)
        assert (table.names, table["k"].tolist()) == (["k", "max(block.s)"], [8])
    for alone in (8, "8", np.float64(8)):
        assert model.simulate_many(parameters={"k": alone}, outputs=["max(block.s)"], stop=0.1).names == ["max(block.s)"]
    gravity = {"world.gravity": [[0, -2]]}
    assert model.simulate_many(parameters=gravity, stop=0.1).names[:2] == ["world.gravity[1]", "world.gravity[2]"]
    assert model.simulate_many(parameters={"world.gravity": [0, -2]}, stop=0.1).names[0] == "final(block.s)"
    table = model.simulate_many(parameters={"m": [1, 2, 3], "k": [4]}, together=True, stop=0.1)
    assert (table["m"].tolist(), table["k"].tolist()) == ([1, 2, 3], [4, 4, 4])


def test_a_text_alone_is_a_list_of_measures(scene: Scene) -> None:
    model = scene(OSCILLATOR)
    assert model.simulate_many(outputs="max(block.s)", stop=0.1).names == ["max(block.s)"]
    assert model.simulate_many(outputs="at(0.05, block.s), min(block.s)", stop=0.1).names == ["at(0.05, block.s)", "min(block.s)"]


@pytest.mark.parametrize("given", [
    {"parameters": [("k", [1])]}, {"parameters": {3: [1]}}, {"parameters": "k=1"}, {"initial": 3}, {"outputs": [3]},
    {"outputs": 3}, {"jobs": "2"}, {"jobs": 1.5}, {"samples": 3.0, "parameters": {"k": "normal(8,1)"}}, {"seed": "a"},
    {"stop": "2"}, {"start": []}, {"tolerance": "1e-8"}, {"interval": "a"}, {"max_step": None},
    {"max_steps": 1.5}, {"seconds_per_run": "a"}, {"solver": 3},
    {"sampling": 3}, {"path": "table.xlsx"}, {"path": "scene.lag"},
], ids=str)
def test_values_of_a_wrong_type_are_told(scene: Scene, given: dict[str, object]) -> None:
    model = scene(OSCILLATOR)
    with pytest.raises(lag.LagError):
        model.simulate_many(**{"parameters": {"k": [8, 9]}, "stop": 0.1} | given)


@pytest.mark.parametrize("given", [{"stop": "2"}, {"parameters": [1]}, {"parameters": {"m": "2"}}, {"initial": {"block.s": [1]}}],
                         ids=str)
def test_a_run_tells_wrong_types_too(scene: Scene, given: dict[str, object]) -> None:
    with pytest.raises(lag.LagError, match="must be"):
        scene(OSCILLATOR).simulate(**given)


def test_numbers_of_numpy_are_numbers(scene: Scene, tmp_path: Path) -> None:
    table = scene(OSCILLATOR).simulate_many(
        parameters={"k": "normal(8,1)"}, samples=np.int32(3), seed=np.int64(1), max_steps=np.int64(10_000), jobs=np.int8(1),
        interval=np.float32(0.1), stop=np.float64(1), path=tmp_path / "x.csv")
    assert table.ok.all() and len(table["k"]) == 3


def test_lists_side_by_side_and_a_table(scene: Scene, tmp_path: Path) -> None:
    model = scene(OSCILLATOR)
    table = model.simulate_many(parameters={"m": [1, 2, 3], "k": [4, 5, 6]}, together=True)
    assert table["m"].tolist() == [1, 2, 3]
    assert table["k"].tolist() == [4, 5, 6]
    (tmp_path / "runs.csv").write_text("k, block.s\n8,100[mm]\n\n18,0.2\n")
    table = model.simulate_many(runs=tmp_path / "runs.csv", parameters={"m": [2, 8]}, outputs=["block.s", "max(block.s)"])
    assert table["k"].tolist() == [8, 8, 18, 18]
    assert table["max(block.s)"] == pytest.approx([0.1, 0.1, 0.2, 0.2])


@pytest.mark.parametrize(
    ("text", "mean", "deviation"),
    [
        ("normal(100, 5)", 100, 5),
        ("uniform(2, 8)", 5, 6 / math.sqrt(12)),
        ("triangular(0, 3, 6)", 3, 6 / math.sqrt(24)),
        ("lognormal(10, 0.2)", 10 * math.exp(0.02), 10 * math.exp(0.02) * math.sqrt(math.exp(0.04) - 1)),
        ("loguniform(1, 10)", 9 / math.log(10), math.sqrt(99 / 2 / math.log(10) - (9 / math.log(10)) ** 2)),
    ],
)
@pytest.mark.parametrize("sampling", ["random", "lhs"])
def test_random_values_have_their_distribution(scene: Scene, text: str, mean: float, deviation: float, sampling: str) -> None:
    model, count = scene(OSCILLATOR), 4000
    first, again, other = (model.simulate_many(parameters={"k": text, "s0": "uniform(0,1)"}, samples=count, seed=seed, stop=0.01,
                                               sampling=sampling) for seed in (7, 7, 8))
    k = first["k"]
    assert (k == again["k"]).all()
    assert (k != other["k"]).any()
    assert k.mean() == pytest.approx(mean, abs=(4 if sampling == "random" else 0.1) * deviation / math.sqrt(count))
    assert k.std() == pytest.approx(deviation, rel=0.06)
    assert abs(np.corrcoef(k, first["s0"])[0, 1]) < 0.07
    if sampling == "lhs":
        assert np.sort(np.floor(first["s0"] * count)).tolist() == list(range(count))


# ---------------------------------------------------------------- failures


def test_failures_are_recorded_and_the_rest_goes_on(scene: Scene) -> None:
    table = scene(EXPLOSION).simulate_many(parameters={"a": [2, -0.1, 0]}, outputs=["at(0.5, s)", "max(s)", "first_time(s > 3)"])
    assert list(table.failures) == [0]
    assert "t = 1" in table.failures[0]
    assert table["at(0.5, s)"][0] == pytest.approx(4, rel=1e-6), "what was known before stays"
    assert table["first_time(s > 3)"][0] == pytest.approx(1 - 1 / math.sqrt(3), abs=1e-7)
    assert math.isnan(table["max(s)"][0])
    assert table["max(s)"][1:] == pytest.approx([21 ** (1 / 3), 7], rel=1e-7)
    assert table.ok.tolist() == [False, True, True]


def test_parameters_out_of_their_limits_fail_alone(scene: Scene) -> None:
    table = scene(OSCILLATOR).simulate_many(parameters={"m": [1, -1, 2]})
    assert list(table.failures) == [1]
    assert "'m' is -1 kg, less than its minimum 0 kg" in table.failures[1]


def test_limits_of_steps_and_of_time(scene: Scene) -> None:
    table = scene(OSCILLATOR).simulate_many(parameters={"k": [1e-3, 1e6]}, max_steps=100, solver="erk")
    assert "limit of steps" in table.failures[1]
    assert list(table.failures) == [1]
    for outputs in (["final(block.s)"], ["max(block.s)"]):
        table = scene(OSCILLATOR).simulate_many(parameters={"k": [1e-3, 1e12]}, seconds_per_run=0.2, outputs=outputs,
                                               solver="erk")
        assert table.failures[1].startswith("out of time at t = ")
        assert list(table.failures) == [1]


def test_initial_equations_that_cannot_hold(scene: Scene) -> None:
    model = scene("""model Start parameter Length h = 0.5; Revolute hinge(a = world); Bar bar(m = 1, L = 1, a = hinge.b);
                  initial equation bar.b.y = h; end Start;""")
    table = model.simulate_many(parameters={"h": [0.5, 3, -0.5]}, outputs=["initial(bar.b.y)"], stop=0.1)
    assert list(table.failures) == [1]
    assert table.failures[1] == "this cannot hold at the start (scene.lag:2): it misses by 2 (m or rad)"
    assert table["initial(bar.b.y)"][[0, 2]] == pytest.approx([0.5, -0.5], abs=1e-9)


def test_loops_that_do_not_close_are_named() -> None:
    """Rows and summary name the loop, as a run alone does, where rates do not go together, and where lengths do not."""
    press = lag.load(EXAMPLES / "crank_press.lag").simulate_many(initial={"der(pin.phi)": [1, 3, -2]}, stop=0.1)
    told = ("the rates that are stated at the start do not go together in the loop "
            "world - O - crank - pin - rod - wrist - ram - world (crank_press.lag:3)")
    assert press.failures[1] == f"{told}: it misses by 5.03 (m/s or rad/s)" and len(press.failures) == 3
    assert press.common_failures() == [(told, 3)]
    bars = lag.load(EXAMPLES / "four_bar.lag").simulate_many(parameters={"coupler.L": [1, 0.01, 9]}, stop=0.1)
    told = "the loop world - O - crank - A - coupler - B - rocker - C - world cannot close (four_bar.lag:4)"
    assert list(bars.failures) == [1, 2] and all(why.startswith(f"{told}: it misses by ") for why in bars.failures.values())
    assert bars.common_failures() == [(told, 2)]


# The oscillator in C: two batches of one model, runs that fail, that have no time, that are out of their limits.
DRIVER = """
#include "run/batch.h"
#include <math.h>
static int parameters(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = in[1][0] != 0 ? in[0][0] : 1; return 0; }
static int hoist(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = in[0][0]; return 0; }
static int start(const double *const *in, double *const *out, double *work)
{ (void)in; (void)work; out[0][0] = 1; out[1][0] = 0; return 0; }
static int rhs(const double *const *in, double *const *out, double *work)
{ (void)work; out[0][0] = in[5][0] < 100 ? -in[5][0]*in[1][0] : NAN; return 0; }
static const int kind[] = {1}, fixed[] = {0, 0};
static const LagModel model = {.n = 1, .n_parameters = 1, .n_hoisted = 1, .coordinate_kind = kind, .fixed = fixed,
    .parameters = {.code = parameters}, .hoist = {.code = hoist}, .start = {.code = start}, .rhs = {.code = rhs}};
#define WITHIN(what, of, its_rate, size_alone, number, begin, end) {.kind = LAG_REDUCE_##what, .column = of, .rate = its_rate, \\
    .absolute = size_alone, .value = number, .size = 1, .from = begin, .to = end, .keeps_cycles = 1}
#define WHOLE(what, of, its_rate, size_alone, number) WITHIN(what, of, its_rate, size_alone, number, -INFINITY, INFINITY)
static const LagReduction reductions[] = {WHOLE(AT, 1, 2, 0, 3), WHOLE(MAX, 1, 2, 1, 0), WHOLE(MEAN, 1, 2, 1, 0),
    WHOLE(FIRST_BELOW, 1, -1, 0, 0), WHOLE(LAST_ABOVE, 2, -1, 1, 0.5), WHOLE(AT, 2, -1, 0, 1), WHOLE(DAMAGE, 1, 2, 0, 3),
    WITHIN(SETTLING, 1, 2, 0, 0.5, 1, 2), WITHIN(PERIOD, 1, 2, 0, 0, 0.1, INFINITY),
    WITHIN(DURATION_BELOW, 1, -1, 1, 0.5, -INFINITY, 2.3), WHOLE(PEAK_FREQUENCY, 1, 2, 0, 0)};
enum { KEPT = sizeof reductions / sizeof *reductions };
static LagBatch *batch_of(LagRun *run, int n_varied)
{
    static const int varied[] = {0, 1};
    static const double row_times[] = {1, 3}, one[] = {1}, none[] = {0}, free_start[] = {NAN, NAN}, least[] = {0};
    static const double most[] = {1000};
    const LagSweep sweep = {.t_stop = 3, .window = 0.3, .n_reductions = KEPT, .reductions = reductions, .n_varied = n_varied,
        .n_rows = 2, .row_times = row_times,
        .varied = varied, .given = one, .mask = none, .start = free_start, .least = least, .most = most};
    return lag_batch_new(&model, run, &sweep);
}
int main(void)
{
    const LagSettings settings = {.t_stop = 3, .tolerance = 1e-9};
    const double values[] = {1, 1, 4, 0.5, -1, 1, 400, 1, 9, 2};
    double results[5 * KEPT], again[2 * KEPT], kept[5 * 2 * 8];
    LagOutcome outcomes[5];
    const volatile int32_t go = 0, stop = 1;
    LagRun *run = lag_run_new(&model, &settings), *other = lag_run_new(&model, &settings);
    LagBatch *two = batch_of(run, 2), *none = batch_of(other, 0);
    if (lag_batch_advance(two, 5, values, NULL, results, outcomes, kept, &go) != 5)
        return 1;
    if (outcomes[3].kind != LAG_RUN_FAILED || lag_batch_advance(none, 2, values, NULL, again, outcomes + 3, kept, &go) != 2)
        return 1;
    if (lag_batch_advance(two, 5, values, NULL, results, outcomes, kept, &stop) != 0)
        return 2;
    const int kinds[] = {LAG_RUN_DONE, LAG_RUN_DONE, LAG_RUN_PARAMETER};
    for (int i = 0; i < 3; ++i)
        if (outcomes[i].kind != kinds[i])
            return 3;
    if (fabs(results[0] - cos(3)) > 1e-8 || fabs(results[KEPT + 3] - acos(0)/2) > 1e-8)
        return 4;
    if (!isnan(results[2 * KEPT]) || again[0] != again[KEPT] || isnan(again[0]))
        return 5;
    if (kept[0] != 1 || fabs(kept[1] - cos(1)) > 1e-8 || kept[8] != 3)
        return 7;
    int64_t cycles = 0;
    if (fabs(results[6] - 0.5*pow(1 - cos(3), 3)) > 1e-7 || !lag_batch_cycles(none, 6, &cycles) || cycles != 1)
        return 6;
    lag_batch_free(two), lag_batch_free(none);
    lag_run_free(run), lag_run_free(other);
    return 0;
}
"""


@needs_sanitizers
@pytest.mark.slow
def test_sanitizers_find_nothing(tmp_path: Path) -> None:
    run_sanitized(tmp_path, {"driver.c": DRIVER})


def test_pieces_are_handed_out_once() -> None:
    pieces, taken, lock = Pieces([(0, 10), (15, 400)], 3), [], threading.Lock()

    def work() -> None:
        while (piece := pieces.take(7)) is not None:
            with lock:
                taken.extend(range(*piece))

    threads = [threading.Thread(target=work) for _ in range(4)]
    [thread.start() for thread in threads]
    [thread.join() for thread in threads]
    assert sorted(taken) == [*range(10), *range(15, 400)]
