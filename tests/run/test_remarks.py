"""Python is told what the command line tells: inputs without a value, tables of inputs that end before the run."""

import math
import warnings
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.inertias import are_of_a_body
from lagrangia.command.cli import main

SCENE = "model M input Force u; Block b(m = 1, base = world, s(start = 0.1)); Spring s(k = 100, stretch = b.s); " \
        "AppliedForce f(at = b.center, force = {u, 0}); annotation(experiment(StopTime = 2)%s); end M;"
TABLE = ([0, 1], {"u": [0, 1]})
WAYS: dict[str, Callable[[lag.Model, object], object]] = {
    "simulate": lambda model, inputs: model.simulate(inputs=inputs),
    "prepare": lambda model, inputs: model.prepare({}, {}, inputs=inputs),
    "measure": lambda model, inputs: model.measure("max(b.s)", inputs=inputs),
    "rainflow": lambda model, inputs: model.rainflow("b.s", inputs=inputs),
    "simulate_many": lambda model, inputs: model.simulate_many(parameters={"s.k": [1, 2]}, inputs=inputs),
}


@pytest.mark.parametrize("way", WAYS)
def test_what_nobody_gave_is_told(scene: Callable[[str], lag.Model], way: str) -> None:
    model = scene(SCENE % "")
    with pytest.warns(lag.InputWarning, match="nothing is given for the input 'u'.*L0708") as told:
        WAYS[way](model, None)
    assert told[0].filename == __file__
    with pytest.warns(lag.InputWarning, match="goes from 0 to 1 s, the run from 0 to 2 s.*L0709"):
        WAYS[way](model, TABLE)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        WAYS[way](model, {"u": 1.0})
        WAYS[way](scene(SCENE % ', allow = "L0708, L0709"'), TABLE)


def test_an_input_is_given_once(scene: Callable[[str], lag.Model]) -> None:
    model = scene(SCENE % "")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        model.simulate(controllers={"u": lambda t, run: 1.0}, every=0.5)
    with pytest.raises(lag.LagError, match="'u' is given twice"):
        model.simulate(controllers={"u": lambda t, run: 1.0}, every=0.5, inputs={"u": 3})
    with pytest.raises(lag.LagError, match="the interval has no effect"):
        model.simulate(at=[1], interval=0.1, inputs={"u": 3})


GIVEN = """model M parameter Length L = 1[m]; parameter Length two = 2*L; parameter Angle phi0 = 0.1;
  parameter Angle G[2] = {phi0, 2*phi0}; parameter Real k = 1;
  Revolute r(a = world, phi(start = sum(G))), t(a = world); Bar p(m = 1, L = two, a = r.b), o(m = k*1[kg], L = 1, a = t.b);
  annotation(experiment(StopTime = 0.01)%s); end M;"""
IN_VAIN: list[tuple[dict[str, float], dict[str, float], str]] = [
    ({"L": 2, "p.L": 3}, {}, "'L' changes nothing: 'p.L' is given"),
    ({"L": 2, "two": 3}, {}, "'L' changes nothing: 'two' is given"),
    ({"two": 2, "p.L": 3}, {}, "'two' changes nothing: 'p.L' is given"),
    ({"phi0": 2}, {"r.phi": 3}, "'phi0' changes nothing: 'r.phi' is given"),
    ({"phi0": 2, "G[1]": 1, "G[2]": 3}, {}, "'phi0' changes nothing: 'G' is given"),
    ({"L": 2, "phi0": 3}, {"der(r.phi)": 1}, ""),
    ({"p.L": 2, "p.m": 3, "o.L": 2, "k": 1}, {"r.phi": 1}, ""),
]


def test_what_is_given_in_vain_is_told(scene: Callable[[str], lag.Model]) -> None:
    model, allowing = (scene(GIVEN % allowed) for allowed in ("", ', allow = "L0747"'))
    for parameters, initial, told in IN_VAIN:
        asked = {"parameters": parameters, "initial": initial}
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            model.measure("max(r.phi)", **asked)
            allowing.measure("max(r.phi)", **asked)
        texts = [str(warning.message) for warning in found]
        assert len(texts) == (told != "") and all(told in text and text.endswith("(L0747)") for text in texts), asked
    with pytest.warns(lag.InputWarning, match="'L' changes nothing.*L0747"):
        model.simulate_many(runs={"L": [1, 2], "p.L": [3, 4]})
    with pytest.warns(lag.InputWarning, match="'L' changes nothing.*L0747"):
        model.rollout(p={"L": [1, 2], "p.L": [3, 4]}, times=[0, 0.01])
    with pytest.warns(lag.InputWarning, match="'phi0' changes nothing.*L0747"):
        model.rollout(q0=[1, 0], p={"phi0": 0.3}, times=[0, 0.01])


@pytest.mark.parametrize("command", ["simulate", "sweep", "explain", "bench --rhs", "export --to fmu -o {out}", "modes"])
def test_all_commands_tell_what_is_in_vain(command: str, scene: Callable[[str], lag.Model], tmp_path: Path,
                                           capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch) -> None:
    """--strict takes it for an error, and --allow leaves it out."""
    monkeypatch.chdir(tmp_path)
    path = scene(GIVEN % "").path
    words = [part.format(out=tmp_path / "x.fmu") for part in command.split()]
    given = [*words, str(path), "-p", "L=2", "-p", "p.L=3"]
    assert main([*given, "--strict"]) == 2
    assert "warning[L0747]: the value given for 'L' changes nothing" in capsys.readouterr().err
    main([*given, "--allow", "L0747"])
    assert "L0747" not in capsys.readouterr().err


def test_an_interval_beyond_the_run_leaves_both_ends(scene: Callable[[str], lag.Model]) -> None:
    model = scene(SCENE % ', allow = "L0708"')
    assert [list(model.simulate(stop=stop, interval=1e9).time) for stop in (0.3, 2.0)] == [[0, 0.3], [0, 2]]


def test_a_start_is_given_once_and_steps_where_there_are_any(scene: Callable[[str], lag.Model]) -> None:
    """b.v is der(b.s): the last of both had been taken without a word."""
    model = scene(SCENE % "")
    with pytest.raises(lag.LagError, match=r"'b.v' is given twice, as 'der\(b.s\)' too"):
        model.simulate(initial={"der(b.s)": 1, "b.v": 3}, inputs={"u": 0})
    casadi, limits = "casadi:cvodes", ({"max_step": 0.1}, {"max_steps": 9})
    for solver, limit in (("linear", limits[0]), (casadi, limits[0]), (casadi, limits[1])):
        with pytest.raises(lag.LagError, match="has no effect: "):
            model.simulate(solver=solver, inputs={"u": 0}, **limit)


def test_inertias_that_are_given_and_no_body_has_are_told(scene: Callable[[str], lag.Model], capsys: pytest.CaptureFixture[str],
                                                          monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """As those that are declared so; by what they follow from, too."""
    monkeypatch.chdir(tmp_path)
    text = ("model M parameter Inertia J = 1; World world(gravity = {0, 0, -9.81}); Universal u(a = world, phi_a(start = 1)); "
            "Body b(m = 1, I = {1, 1, J}, center = u.b), c(m = 1, I = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}, center = u.b); "
            "annotation(experiment(StopTime = 0.1)%s); end M;")
    allowing, model = (scene(text % allowed) for allowed in (', allow = "L0746"', ""))
    for name, value, told in [("b.I[1]", 5, "'b.I': about x it is 5 kg.m2"), ("J", 3, "'b.I': about z it is 3 kg.m2"),
                              ("J", 2, ""), ("c.I[2,2]", 3, "'c.I': about y it is 3 kg.m2"), ("b.m", 2, "")]:
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            model.simulate(parameters={name: value})
            allowing.simulate(parameters={name: value})
        texts = [str(warning.message) for warning in found]
        assert len(texts) == (told != "") and all(told in text and text.endswith("(L0746)") for text in texts), name
        assert main(["modes", str(model.path), "-p", f"{name}={value}", "--strict"]) == (2 if told else 0)
        assert f"warning[L0746]: no rigid body has the inertia {told}" in capsys.readouterr().err or not told


def test_inertias_that_runs_of_a_sweep_make_are_told(scene: Callable[[str], lag.Model], capsys: pytest.CaptureFixture[str],
                                                     tmp_path: Path) -> None:
    """Of sweeps, rollouts and prepared runs, which were silent; those that are negative are refused, and not told twice."""
    model = scene("model M parameter Inertia J = 1; parameter Inertia K = 0; World world(gravity = {0, 0, -9.81}); "
                  "Universal u(a = world, phi_a(start = 1)); Body b(m = 1, I = {1, 1, J}, center = u.b), "
                  "c(m = 1, I = {{1, K, 0}, {K, 1, 0}, {0, 0, 1}}, center = u.b); annotation(experiment(StopTime = 0.1)); end M;")
    run = model.prepare(parameters={"J": 1, "K": 0}, at=[0, 0.1])
    of_b = "no rigid body has the inertia 'b.I': about z it is 3 kg.m2, more than about the other two together, 2"
    for ask, told in (
            (lambda: model.simulate_many(parameters={"J": [1.5, 3, 4], "K": [0, 0.4]}), f"{of_b}: the first of 4 of 6 sets"),
            (lambda: model.simulate_many(parameters={"J": [1.5, 2]}, initial={"u.phi_b": [0, 0.1]}), ""),
            (lambda: model.rollout(p={"J": [1, 3, 1]}, times=[0, 0.1]), f"{of_b}: the first of 1 of 3 sets"),
            (lambda: model.rollout(p={"J": 3}, times=[0, 0.1]), f"{of_b} (L0746)"),  # one set for however many runs
            (lambda: model.rollout(p={"J": 3, "b.m": [1, 2]}, times=[0, 0.1]), f"{of_b} (L0746)"),
            (lambda: model.simulate_many(parameters={"J": 3, "b.m": [1, 2]}), f"{of_b} (L0746)"),
            (lambda: model.simulate_many(parameters={"J": [1, 3], "b.m": [1, 2, 3]}), f"{of_b}: the first of 3 of 6 sets"),
            (lambda: model.rollout(p={"K": [0, 2]}, times=[0, 0.1]), ""),  # negative: that run fails
            (lambda: run([], [3, 0]), of_b), (lambda: run([], [3, 0]), ""), (lambda: run([], [1, 0]), ""),
            (lambda: model.start(parameters={"J": 3}), of_b),
            (lambda: model.study(parameters={"J": 3}), of_b), (lambda: model.equilibrium(parameters={"J": 3}, starts=1), of_b),
            (lambda: model.linearize(parameters={"J": 3}, about="start"), of_b)):
        with warnings.catch_warnings(record=True) as found:
            warnings.simplefilter("always")
            ask()
        texts = [str(warning.message) for warning in found]
        assert len(texts) == (told != "") and all(text.startswith(told) and text.endswith("(L0746)") for text in texts), texts
        assert all(warning.filename == __file__ for warning in found)
    assert model.prepare(parameters={"b.m": 1}, at=[0, 0.1])._oddness is None, "it asks in no call of those it cannot change"
    assert main(["sweep", str(model.path), "-p", "J=1:3:1", "-o", str(tmp_path / "o.csv"), "--strict"]) == 2
    assert f"warning[L0746]: {of_b}: the first of 1 of 3 sets of parameters" in capsys.readouterr().err


def test_inertias_are_of_a_body_by_their_numbers_as_by_principal_axes() -> None:
    """Half the trace less the matrix is the matrix of second moments, which are negative along no axis."""
    random = np.random.default_rng(3)
    for second in random.uniform(-0.3, 1, (200, 3)):
        moments, (axes, _) = second.sum() - second, np.linalg.qr(random.normal(size=(3, 3)))
        whole = axes @ np.diag(moments) @ axes.T
        expected = bool(second.min() > 0)
        assert all(are_of_a_body(own.ravel().tolist()) == expected for own in (moments, np.diag(moments), whole)), second
    assert are_of_a_body([1, 1, 2]) and not are_of_a_body([math.nan, 1, 1])
