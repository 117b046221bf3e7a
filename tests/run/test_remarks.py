"""Python is told what the command line tells: inputs without a value, tables of inputs that end before the run."""

import warnings
from collections.abc import Callable

import pytest

import lagrangia as lag

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
