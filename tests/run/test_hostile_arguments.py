"""What is no text, path, name, mapping or count is refused with words where Python's own exceptions came from deep below."""

from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import lagrangia as lag

TEXT = """model M parameter Real k = 100; input Force F = 1; Block b(m = 1, base = world); Spring s(k = k, stretch = b.s);
  AppliedForce f(at = b.center, force = {F, 0}); annotation(experiment(StopTime = 0.1)); end M;"""
Ask = Callable[[lag.Model, Any], object]
OF_MODELS: list[tuple[Ask, Any, str]] = [
    (lambda _, x: lag.load(x), None, "a path must be a text or a pathlib.Path, not None"),
    (lambda _, x: lag.load(x), 1j, "a path must be a text or a pathlib.Path, not 1j"),
    (lambda _, x: lag.loads(TEXT, model=x), 3, "the name of the model must be a text, not 3"),
    (lambda m, x: lag.Model(m.path, structural=x), [1],
     "the structural parameters must be a mapping of names to values, not [1]"),
    (lambda m, x: lag.Model(m.path, outputs=x), 5, "the outputs must be names, not 5"),
    (lambda m, x: m.equations(form=x), 5, "the form must be a text, not 5"),
    (lambda m, x: m.equations(format=x), None, "the format must be a text, not None"),
    (lambda m, x: m.equations(language=x), b"de", "the language must be a text, not b'de'"),
    (lambda m, x: m.equations(parameters=x), [1], "the parameters must be a mapping of names to values, not [1]"),
    (lambda m, x: m.equations(names=x), "k", "the symbols must be a mapping of names to values, not 'k'"),
    (lambda m, x: m.draw(names=x), 7, "the symbols must be a mapping of names to values, not 7"),
    (lambda m, x: m.telling_reactions(x), [None], "the quantities must be names, not [None]"),
    (lambda m, x: m.study().equilibria(x), float("inf"), "the number of starts must be a whole number, not inf"),
    (lambda m, x: m.study().equilibria(x), 0, "the number of starts must lie between 1 and 10000, not be 0"),
    (lambda m, x: m.equilibrium(starts=x), "3", "the number of starts must be a whole number, not '3'"),
    (lambda m, x: m.start().set(x), [1], "the inputs must be a mapping of names to values, not [1]"),
    (lambda m, x: m.start().restore(x), "abc", "a state must be the bytes that save() has answered, not 'abc'"),
    (lambda m, x: lag.slopes(x, [1, 2, 3]), None, "the times must be a sequence of numbers, not None"),
    (lambda m, x: lag.slopes([0, 1, 2], x), ["a", 2, 3], "the values must be a number, not 'a'"),
    (lambda m, x: lag.slopes([0, 1, 2], [1, 2, 3], x), 3, "the smoothness must be a text, not 3"),
]
OF_RUNS: list[tuple[Callable[[Any, Any], object], Any, str]] = [
    (lambda run, x: run.to_csv(x), 3.5, "a path must be a text or a pathlib.Path, not 3.5"),
    (lambda run, x: run.write(x), None, "a path must be a text or a pathlib.Path, not None"),
    (lambda run, x: run.plot(*x), (3, None), "the quantities must be names, not (3, None)"),
    (lambda run, x: run.plot(spectrum=x), 3, "the spectrum must be names, not 3"),
    (lambda run, x: run.animate("x.html", traces=x), 3, "the traces must be names, not 3"),
    (lambda run, x: run.animate("x.html", quantities=x), [None], "the quantities must be names, not [None]"),
    (lambda run, x: run.animate("x.html", names=x), [1], "the symbols must be a mapping of names to values, not [1]"),
]


@pytest.fixture
def model(scene: Callable[[str], lag.Model], monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> lag.Model:
    monkeypatch.chdir(tmp_path)
    return scene(TEXT)


def test_models_refuse_what_they_are_not_asked_with(model: lag.Model) -> None:
    for ask, given, sentence in OF_MODELS:
        with pytest.raises(lag.LagError) as error:
            ask(model, given)
        assert [(x.code, x.message) for x in error.value.diagnostics] == [("L0702", sentence)]


def test_runs_refuse_what_they_are_not_asked_with(model: lag.Model) -> None:
    run = model.simulate()
    for ask, given, sentence in OF_RUNS:
        with pytest.raises(lag.LagError) as error:
            ask(run, given)
        assert [(x.code, x.message) for x in error.value.diagnostics] == [("L0702", sentence)]
    assert not list(Path().glob("*.html"))


def test_what_is_possible_is_taken(model: lag.Model) -> None:
    """NumPy's numbers, paths, and names in any sequence."""
    assert model.study().equilibria(np.int64(1))[0].position["b.s"] == pytest.approx(0.01, abs=1e-12)
    run = model.simulate()
    run.to_csv(Path("a.csv"))
    run.write("b.csv")
    assert Path("a.csv").read_text() == Path("b.csv").read_text()
    assert lag.slopes(np.array([0, 1, 2]), (0, 1, 2)) == pytest.approx([1, 1, 1])
