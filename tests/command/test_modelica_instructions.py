"""`lag export --to modelica` of scenes whose equations are too large to be read: by instructions, which are read here."""

import re
from collections.abc import Mapping
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import lagrangia as lag
from helpers.flat_modelica import FlatModelica
from helpers.symbolic_scenes import EXAMPLES
from lagrangia.command.cli import WRONG, main
from lagrangia.command.scene_export import exported_text

MANY = """
model Many "drums in a row, and what is in none of the examples"
  World world(gravity = {0, -9.81});
  input Force F[2](each start = 0.3);
  parameter Real k(unit = "N/m") = 3;
  parameter Mass half = 2*m[1].m;
  Block m[25](m = {1 + 0.1*k for k in 1:25}, each base = world, s(start = {0.2[m]*sin(k) for k in 1:25}),
    v(start = {1[m/s]*cos(k) for k in 1:25}));
  AppliedForce a(at = m[1].center, force = {F[1] - k*m[1].s*abs(m[1].s)/1[m] + 2[N/m]*min(m[2].s, 0.1[m]), 0});
  AppliedForce b(at = m[2].center, force = {if m[2].s > 0.1 and time < 2 then 2*F[2] else -0.7[N], 0});
  AppliedForce c(at = m[3].center, force = {3[N]*tanh(m[3].v/0.1[m/s]) - 1[N]*atan2(m[3].s, 2[m])/1[rad], 0});
  AppliedForce d(at = m[4].center, force = {table(m[4].s, {-1, 0, 0.1, 2}, {1, 0.5, -0.3, 2}), 0});
  AppliedForce e(at = m[5].center, force = {2[N]*mod(time, 0.25)/1[s] + 1[N]*sign(m[5].v), 0});
  AppliedForce f(at = m[6].center, force = {1[N]*asinh(m[6].s/1[m]) - half*1e-3[m/s2]*floor(3*m[6].s/1[m]), 0});
  AppliedForce g(at = m[7].center, force = {if not (m[7].s < 0 or m[7].s > 1) then -1[N] else 1[N]*max(m[7].s, m[8].s)/1[m], 0});
  Spring springs[24](each k = k, stretch = {m[k + 1].s - m[k].s for k in 1:24});
  output Real y[2](each unit = "m") = {m[3].s, 2*m[4].s} "two places";
  output Real pull(unit = "m/s2") = der(m[1].v);
end Many;
"""


@pytest.fixture
def many(tmp_path: Path) -> Path:
    path = tmp_path / "many.lag"
    path.write_text(MANY, encoding="utf-8")
    return path


def compared(model: lag.Model, read: FlatModelica, times: list[float], parameters: Mapping[str, float] | None = None,
             **changes: float) -> float:
    """The largest difference of accelerations, relative to the largest one, and of the rates of positions, along a run."""
    names = [*model.position_names, *(rate.name for rate in model.scene.rates)]
    assert [*read.sources.values()] == names
    run, functions, worst, n = model.simulate(at=times), model.functions(), 0.0, len(model.position_names)
    inputs = [x.value or 0.0 for x in model.scene.inputs]
    for k, t in enumerate(times):
        y = np.array([run[name][k] for name in names])
        given = (t, y[:n], y[n:], inputs, model.parameter_values(parameters))
        a = functions["rhs"](*given).full().ravel()
        pace = functions["turning"](*given).full().ravel() if "turning" in functions else y[n:]
        found = read.slope(t, y, **changes)
        worst = max(worst, np.abs(found[n:] - a).max() / np.abs(a).max(), np.abs(found[:n] - pace).max())
    return worst


@pytest.mark.parametrize("name", ["robot_arm", "bicycle", "scissor_lift", "hexapod"])
def test_accelerations_are_ours(name: str) -> None:
    """At the start, and on the way: a tree, what rolls, loops, loops with attitudes. All were refused as too large (L0712)."""
    model = lag.load(EXAMPLES / f"{name}.lag")
    text = exported_text(model, "modelica")
    assert "// by instructions, as the equations are too large to be read" in text
    assert compared(model, FlatModelica(text), [0.0, 0.4] if name == "hexapod" else [0.0, 0.1, 0.4, 1.0]) < 1e-12


def test_parameters_stay_open() -> None:
    model = lag.load(EXAMPLES / "robot_arm.lag")
    read = FlatModelica(exported_text(model, "modelica", {"m[2]": "heavy", "joint[1].phi": "theta"}))
    assert read.sources["theta"] == "joint[1].phi" and read.values["heavy"] == model.parameter_values()[
        model.parameter_names.index("m[2]")]
    names = [*model.position_names, *(rate.name for rate in model.scene.rates)]
    run = model.simulate(at=[0.3], parameters={"m[2]": 9.0})
    y = np.array([run[name][0] for name in names])
    given = (0.3, y[:6], y[6:], [], model.parameter_values({"m[2]": 9.0}))
    known = read.solved(0.3, dict(zip(read.starts, y.tolist(), strict=True)), heavy=9.0)
    assert read.slope(0.3, y, heavy=9.0)[6:] == pytest.approx(model.functions()["rhs"](*given).full().ravel(), rel=1e-13)
    wanted = dict(zip(model.output_names, model.functions()["outputs"](*given).full().ravel(), strict=True))
    told = {f"{name}[{k}]": x for name, text in read.outputs.items()
            for k, x in enumerate(eval(text.replace("{", "[").replace("}", "]"), {}, known), 1)}
    assert told == pytest.approx(wanted, rel=1e-13) and len(told) == 9


@pytest.mark.parametrize("name", ["robot_arm", "bicycle"])
def test_it_moves_as_ours(name: str) -> None:
    model = lag.load(EXAMPLES / f"{name}.lag")
    read = FlatModelica(exported_text(model, "modelica"))
    run = solve_ivp(read.slope, (0, 0.3), [*read.starts.values()], "DOP853", rtol=1e-10, atol=1e-11)
    wanted = model.simulate(at=[0.3], tolerance=1e-12)
    assert run.y[:, -1] == pytest.approx([wanted[source][0] for source in read.sources.values()], abs=1e-8)


def test_gaps_close() -> None:
    """A loop that stands open by 1e-3 m closes by itself, as exp(-10 t)."""
    model = lag.load(EXAMPLES / "scissor_lift.lag")
    read = FlatModelica(exported_text(model, "modelica"))
    y = np.array([*read.starts.values()])
    y[0] += 1e-3
    n, p = model.scene.n, model.parameter_values()

    def gap(t: float, y: np.ndarray) -> float:
        return float(np.abs(model.functions()["Phi"](t, y[:n], y[n:], [], p).full()).max())

    run = solve_ivp(read.slope, (0, 0.5), y, "DOP853", rtol=1e-9, atol=1e-11)
    assert gap(0.5, run.y[:, -1]) == pytest.approx(gap(0, y) * np.exp(-5), rel=0.02)


def test_all_operations_and_inputs(many: Path) -> None:
    model = lag.load(many)
    text = exported_text(model, "modelica", {"m[1].m": "first"})
    read = FlatModelica(text)
    assert compared(model, read, [0.0, 0.3, 0.7, 1.1]) < 1e-14
    assert compared(model, read, [0.0], {"k": 4.0, "m[1].m": 3.0}, k=4.0, first=3.0) < 1e-14
    assert "input Real F_1(start = 0.3); // F[1]" in text and "half" not in read.values
    assert re.search(r'output Real y\[2\]\(each unit = "m"\) = \{\w+, \w+\} "two places";', text)
    assert {*read.outputs} == {"y", "pull"}


def test_what_is_not_written_is_told(many: Path, capsys: pytest.CaptureFixture[str]) -> None:
    many.write_text(MANY.replace("end Many", "Real z(start = 1); equation der(z) = -z*1[1/s]; end Many"), encoding="utf-8")
    for file, told in ((many, "first-order states ('z')"),
                       (EXAMPLES / "rough_road.lag", "of 121 points in the export to modelica")):
        assert main(["export", str(file), "--to", "modelica", "-o", str(many.with_suffix(".mo"))]) == WRONG
        said = capsys.readouterr().err
        assert "error[L0901]" in said and told in said, said


def test_endless_ones_are_refused(many: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setattr("lagrangia.paper.modelica_instructions._MOST", 100)
    assert main(["export", str(many), "--to", "modelica", "-o", str(many.with_suffix(".mo"))]) == WRONG
    assert "error[L0712]: the equations are too large to be written out" in capsys.readouterr().err
    assert main(["export", str(many), "--to", "modelica", "--names", "x=y", "-o", "-"]) == WRONG
    assert "error[L0711]: --names: there is no symbol 'x'" in capsys.readouterr().err


def test_a_modelica_compiler_takes_it(tmp_path: Path) -> None:
    """rumoca: two loops."""
    rumoca = pytest.importorskip("rumoca")
    model = lag.load(EXAMPLES / "scissor_lift.lag")
    text = exported_text(model, "modelica")
    read = FlatModelica(text)
    run = rumoca.Session().loads(text, model=model.name).simulate(t=(0.0, 0.4), dt=0.2,
                                                                  config=rumoca.SimConfig(rtol=1e-10, atol=1e-10))
    found = np.array(run.to_numpy([*read.sources]))
    wanted = model.simulate(at=np.linspace(0, 0.4, found.shape[1]), tolerance=1e-12)
    for row, source in zip(found, read.sources.values(), strict=True):
        assert np.abs(row - wanted[source]).max() < 1e-7, source
