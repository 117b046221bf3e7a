"""What Python gives in the place of numbers, names and mappings is refused with words, whatever it is."""

from collections.abc import Callable
from typing import Any

import numpy as np
import pytest

import lagrangia as lag

SCENE = """model M parameter Real k = 100; input Force F = 1; Block b(m = 1, base = world); Spring s(k = k, stretch = b.s);
  AppliedForce f(at = b.center, force = {F, 0}); annotation(experiment(StopTime = 0.1)); end M;"""
TIMES = [0, 0.1]
WAYS: dict[str, Callable[[lag.Model, Any], object]] = {
    "at": lambda model, x: model.simulate(at=x), "stop": lambda model, x: model.simulate(stop=x),
    "parameters": lambda model, x: model.simulate(parameters=x), "initial": lambda model, x: model.simulate(initial=x),
    "inputs": lambda model, x: model.simulate(inputs=x), "table": lambda model, x: model.simulate(inputs=(TIMES, {"F": x})),
    "solver": lambda model, x: model.simulate(solver=x), "from_": lambda model, x: model.simulate(from_=x),
    "controllers": lambda model, x: model.simulate(controllers=x, every=0.1), "prepare": lambda model, x: model.prepare(x),
    "measure": lambda model, x: model.measure(x), "outputs": lambda model, x: model.simulate_many(outputs=x),
    "rainflow": lambda model, x: model.rainflow(x), "runs": lambda model, x: model.simulate_many(runs={"k": x}),
    "modes": lambda model, x: model.modes(parameters=x), "version": lambda model, x: model.export_fmu("x.fmu", fmi=x),
    "rollout from": lambda model, x: model.rollout(q0=x, times=TIMES), "rollout at": lambda model, x: model.rollout(times=x),
    "rollout of": lambda model, x: model.rollout(p=x, times=TIMES),
    "rollout by": lambda model, x: model.rollout(u=x, times=TIMES),
    "rollout each": lambda model, x: model.rollout(p={"k": x}, times=TIMES),
}
WRONG = ["x", float("nan"), [[1, 2], [3]], np.array([1.0, np.nan]), {"a": 1}, b"x", object(), 1 + 2j, 10**400]

MORE: dict[str, list[Any]] = {"parameters": [np.array(3), []], "at": [np.array(3), []], "table": [[]], "measure": [np.array(3)]}


def test_what_is_wrong_is_refused_with_words(scene: Callable[[str], lag.Model]) -> None:
    model = scene(SCENE)
    for way, ask in WAYS.items():
        for wrong in (*WRONG, *MORE.get(way, [])):
            with pytest.raises((lag.LagError, lag.RunError)):
                ask(model, wrong)


@pytest.mark.parametrize("dt", ["1", 1j, None, np.array([0.2]), np.True_])
def test_a_step_of_no_number_leaves_the_run_as_it_was(scene: Callable[[str], lag.Model], dt: object) -> None:
    live = scene("model M Block b(m = 1, base = world, v(start = 1)); end M;").start()
    live.step(0.1)
    with pytest.raises(lag.LagError, match="L0702"):
        live.step(dt)  # type: ignore[arg-type]
    live.restore(live.save())
    live.step(0.1)
    assert live["b.s"] == pytest.approx(0.2, abs=1e-15)


def test_numpys_booleans_are_no_numbers_as_pythons_are_none(scene: Callable[[str], lag.Model]) -> None:
    with pytest.raises(lag.LagError, match="must be a number, not "):
        scene("model M Block b(m = 1, base = world); end M;").simulate(stop=np.True_)


def test_inputs_that_vary_are_told_how_they_are_given(scene: Callable[[str], lag.Model]) -> None:
    model = scene("""model M
      input Real u; Block b(m = 1, base = world); AppliedForce f(at = b.center, force = {u*1[N], 0}); end M;""")
    with pytest.raises(lag.LagError, match=r"'u' must be a number, not \[0.0, 1.0\](.|\n)*inputs=\(times, \{'u': values\}\)"):
        model.simulate(stop=1, inputs={"u": [0.0, 1.0]})
    assert model.simulate(at=[0, 1], inputs=([0, 1], {"u": [0, 6]}))["b.s"][-1] == pytest.approx(1, abs=1e-12)
