"""Sweeps as Python asks for them: runs from a DataFrame, inputs from run to run, a bar for somebody who watches."""

import io
import sys
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

import lagrangia as lag
from lagrangia.base.diagnostics import LagError
from lagrangia.native.build import find_compiler
from lagrangia.run import interpret
from lagrangia.study.sweep import progress

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
Scene = Callable[[str], lag.Model]
PUSHED = """model Pushed
  parameter Mass m = 2; input Force F = 1, G = 0;
  Block b(m = m, base = world, along = {1, 0}); AppliedForce p(at = b.center, force = {F + G, 0});
  annotation(experiment(StopTime = 2));
end Pushed;
"""


def test_what_formulas_the_declared_parameters_need_is_asked_once(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Sweeps over starts evaluate no parameters in Python, but the first; those over parameters do, each time, and a model in the
    formulas of others goes back to those declared. F = 1: s = F t^2/(2 m) + s0."""
    model, asked = scene(PUSHED), list[int]()
    other = model._in(replace(model.formulas, massless=("m",)))
    inner = interpret._evaluate
    monkeypatch.setattr(interpret, "_evaluate", lambda *given: asked.append(1) or inner(*given))
    counts = []
    for one in (model, model, other):
        sweep = one.simulate_many(initial={"b.s": [0.0, 1.0]}, inputs={"F": 1, "G": 0}, outputs="b.s")
        assert sweep["final(b.s)"] == pytest.approx([1.0, 2.0], abs=1e-12)
        counts.append(len(asked))
    assert counts[0] == counts[1] < counts[2]
    masses = model.simulate_many(parameters={"m": [2.0, 4.0]}, inputs={"F": 1, "G": 0}, outputs="b.s")
    assert masses["final(b.s)"] == pytest.approx([1.0, 0.5], abs=1e-12) and len(asked) > counts[2]


def test_quantities_that_are_not_declared_keep_the_engine_and_their_model(scene: Scene) -> None:
    """A position that is no output, by the engine that was asked for; the same model serves the next call. s = F t^2/(2 m)."""
    model = scene(PUSHED)
    for native in (True, False, False):
        model.native = native
        sweep = model.simulate_many(inputs={"F": 1, "G": 0}, outputs="final(b.center.x)")
        assert sweep["final(b.center.x)"] == pytest.approx([1.0], abs=1e-12)
        reporting = model.reporting(["b.center.x"])
        assert reporting is not model and reporting is model.reporting(["b.center.x"])
        assert reporting.native is native and (reporting.engine_for("erk").how == "native") is native
    assert model.reporting(["b.center.y"]) is not reporting


def test_a_frame_has_a_row_for_each_run(scene: Scene) -> None:
    """Of parameters, inputs that are held, and start values; in SI units or those it says. s = F t^2/(2 m) + v t."""
    pandas = pytest.importorskip("pandas")
    model = scene(PUSHED)
    table = {"m": [1.0, 2.0, 4.0], "F": [3.0, 4.0, 5.0], "b.v": [0.0, 1.0, 0.0]}
    frame = pandas.DataFrame({**table, "m": [1000.0, 2000.0, 4000.0]})
    frame.attrs["units"] = {"m": "g"}
    expected = [(F + 0.5) * 4 / (2 * m) + 2 * v for m, F, v in zip(*table.values(), strict=True)]
    for runs in (table, pandas.DataFrame(table), frame):
        sweep = model.simulate_many(runs=runs, inputs={"G": 0.5}, outputs="b.s")
        assert sweep["b.s"] == pytest.approx(expected, abs=1e-12)
        assert sweep["m"].tolist() == table["m"] and list(sweep.units()) == ["kg", "N", "m/s", "m"]
    again = model.simulate_many(runs=sweep.to_pandas()[["m", "F", "b.v"]], inputs={"G": 0.5}, outputs="b.s")
    assert again["b.s"].tolist() == sweep["b.s"].tolist()
    assert again.experiment == "0 to 2 s, tolerance 1e-08, looked at every 0.04 s at least"
    assert repr(again) == f"<3 runs of Pushed, {again.experiment}: m, F, b.v, final(b.s)>"


def test_each_run_has_inputs_of_its_own(scene: Scene) -> None:
    """Constants and tables in all combinations with a parameter, as each of them alone has them; trajectories, too."""
    model = scene(PUSHED)
    inputs = [{"F": 1.0}, {"F": 3.0, "G": 1.0}, ([0.0, 1.0, 2.0], {"F": [0.0, 1.0, 0.0]})]
    sweep = model.simulate_many(parameters={"m": [1, 2]}, inputs=inputs, outputs="max(b.s), b.s", keep=True, interval=0.5)
    assert sweep["inputs"].tolist() == [0, 1, 2, 0, 1, 2] and list(sweep.units())[:2] == ["kg", ""]
    for k, (m, given) in enumerate((m, given) for m in (1, 2) for given in inputs):
        alone = model.simulate(parameters={"m": m}, inputs=given, interval=0.5)
        assert sweep["b.s"][k] == pytest.approx(alone["b.s"][-1], abs=1e-12)
        assert np.allclose(sweep.to_xarray()["b.s"][k], alone["b.s"], atol=1e-12)
    both = model.simulate_many(parameters={"m": [1, 2]}, inputs=inputs[:2], outputs="b.s", together=True)
    assert both["b.s"].tolist() == [sweep["b.s"][0], sweep["b.s"][4]]


@pytest.mark.parametrize(("asked", "said"), [
    ({"inputs": []}, "list of inputs is empty"), ({"inputs": [{"F": 1}, {"H": 1}]}, "no input 'H'"),
    ({"inputs": [{"F": 1}, {"F": 2}], "parameters": {"m": [1, 2, 3]}, "together": True}, "inputs has 2"),
    ({"runs": 3}, "columns by name"), ({"runs": {}}, "columns by name"), ({"runs": {"m": []}}, "has no row"),
    ({"runs": {"m": [1, 2], "F": [1]}}, "a number for each run"), ({"runs": {"q": [1]}}, "no parameter 'q'"),
    ({"runs": {"q": [1]}}, "'q' is a column of the table of runs"), ({"runs": {"b.x": [1]}}, r"did you mean 'b\.[sv]'"),
    ({"runs": {"m": ["a"]}}, "something else than numbers"), ({"runs": {"m": [1 + 1j]}}, "holds complex numbers"),
    ({"runs": {"F": [float("nan")]}}, "must be finite"),
    ({"runs": {"F": [1.0]}, "inputs": {"F": 2}}, "'F' is given twice"),
    ({"runs": {"m": [1]}, "parameters": {"m": 3}}, "'m' is given twice"),
    ({"runs": {"F": [1.0]}, "inputs": [{"F": 2}, {"F": 3}]}, "'F' is given twice"),
])
def test_what_cannot_be_runs_is_told(scene: Scene, asked: dict, said: str) -> None:
    with pytest.raises(LagError, match=said):
        scene(PUSHED).simulate_many(**asked)


def test_a_bar_is_shown_where_somebody_looks(scene: Scene, monkeypatch: pytest.MonkeyPatch) -> None:
    """Our own without tqdm, tqdm's with it; none where nobody looks, or where none is wanted."""
    model = scene(PUSHED)
    monkeypatch.setattr(progress, "_BAR_AFTER", 0.0)

    def shown(wanted: bool | None, is_terminal: bool) -> str:
        stream = io.StringIO()
        stream.isatty = lambda: is_terminal  # type: ignore[method-assign]
        monkeypatch.setattr(sys, "stderr", stream)
        model.simulate_many(parameters={"m": [1, 2, 3]}, progress=wanted)
        return stream.getvalue()

    monkeypatch.setattr(progress, "find_spec", lambda name: None)
    assert shown(None, False) == shown(False, True) == ""
    assert "3 of 3 runs" in shown(None, True) and "3 of 3 runs" in shown(True, False)
    monkeypatch.setattr(progress, "find_spec", lambda name: name)
    told: list[int] = []

    class Tqdm:
        def __init__(self, **asked: object) -> None:
            self.n, self.total = asked["initial"], asked["total"]

        def update(self, by: int) -> None:
            self.n += by  # type: ignore[operator]
            told.append(self.n)  # type: ignore[arg-type]

        def close(self) -> None:
            told.append(-1)

    monkeypatch.setattr(progress, "import_module", lambda name: type("Module", (), {"tqdm": Tqdm}))
    assert shown(True, False) == "" and told[-2:] == [3, -1]
