"""`lag simulate X.fmu`: any FMU beside the native run, with the same options."""

import csv
import math
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("fmpy")

from helpers.fmus import EXAMPLES, VERSIONS, fmu_of, model_of
from lagrangia.command.cli import DONE, FAILED, WRONG, main

Table = dict[str, np.ndarray]
Simulate = Callable[..., Table]
DRIVEN = """
model Driven "A mass on a hardening spring, pushed from outside"
  parameter Mass m = 2; parameter Stiffness k = 50;
  input Force F(start = 1) "push";
  Block block(m = m, base = world, along = {1, 0}, s(start = 0.3));
  Spring spring(k = k, stretch = block.s + block.s^3/1[m2]);
  AppliedForce push(at = block.center, force = {F + (if time < 0.5 then 0 else 2), 0});
  output Acceleration felt = der(block.v);
  annotation(experiment(StopTime = 2, Tolerance = 1e-9));
end Driven;
"""


KICKED = """
model Kicked "A pendulum on a slider that begins to move at once, and a free mass on it"
  Frame slider = shift(world, {0.5*ramp(time, 1, 1), 0});
  Revolute hinge(a = slider); PointMass ball(m = 3, center = shift(hinge.b, {0, -1}));
  Block mass(m = 2, base = slider);
  annotation(experiment(StopTime = 3, Tolerance = 1e-9));
end Kicked;
"""


@pytest.fixture
def simulate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Simulate:
    monkeypatch.chdir(tmp_path)

    def run(path: Path, *options: str) -> Table:
        assert main(["simulate", str(path), "-o", "x.csv", *options]) == DONE, capsys.readouterr().err
        with Path("x.csv").open(newline="") as stream:
            names, *rows = csv.reader(stream)
        return dict(zip(names, np.array(rows, dtype=float).T, strict=True))

    return run


@pytest.fixture(scope="module")
def driven(tmp_path_factory: pytest.TempPathFactory) -> Path:
    path = tmp_path_factory.mktemp("driven") / "driven.lag"
    path.write_text(DRIVEN)
    return path


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", ["me", "cs"])
def test_impulses_are_passed_on(kind: str, version: str, tmp_path: Path, simulate: Simulate) -> None:
    path = tmp_path / "kicked.lag"
    path.write_text(KICKED)
    times = [0.0, 0.5, 1.5, 2.5, 3.0]
    found = simulate(fmu_of(path, version), "--kind", kind, "--at", ",".join(map(str, times)), "--tolerance", "1e-9", "--outputs",
                     "energy.residual")
    native = model_of(path).simulate(at=times, tolerance=1e-11)
    assert abs(native["hinge.phi"][2]) > 0.1
    assert found["hinge.phi"] == pytest.approx(native["hinge.phi"], abs=1e-7)
    assert found["mass.s"] == pytest.approx([0, 0, -0.25, -0.5, -0.5], abs=1e-7)
    assert np.abs(found["energy.residual"]).max() < 1e-6


@pytest.mark.parametrize("version", VERSIONS)
@pytest.mark.parametrize("kind", ["me", "cs"])
def test_it_is_the_native_motion(kind: str, version: str, driven: Path, simulate: Simulate) -> None:
    """At given times, with a parameter, a start value and an input of their own; a jump of a load in between."""
    found = simulate(fmu_of(driven, version), "--kind", kind, "--at", "0,0.3,0.5,1.25,2", "-p", "m=2500[g]", "--initial",
                     "block.s=10[cm]", "-u", "F=1.5", "--outputs", "energy.residual", "--tolerance", "1e-9")
    native = model_of(driven).simulate(at=[0, 0.3, 0.5, 1.25, 2], tolerance=1e-10, parameters={"m": 2.5},
                                       initial={"block.s": 0.1}, inputs={"F": 1.5})
    assert list(found) == ["time", "block.s", "block.v", "felt", "energy.residual"]
    for name in ("block.s", "felt"):
        np.testing.assert_allclose(found[name], native[name], rtol=1e-6, atol=1e-7)
    assert np.abs(found["energy.residual"]).max() < 1e-6


@pytest.mark.parametrize("kind", ["me", "cs"])
def test_tables_of_inputs(kind: str, driven: Path, simulate: Simulate) -> None:
    """Straight lines and a jump; Co-Simulation of FMI 2 follows the slopes, Model Exchange gets the values at all stages."""
    times, values = [0, 0.7, 0.7, 1.4, 2], [0, 3, -1, 2, 2]
    Path("u.csv").write_text("time,F\n" + "".join(f"{t},{v}\n" for t, v in zip(times, values, strict=True)))
    found = simulate(fmu_of(driven, "2"), "--kind", kind, "-u", "u.csv", "--interval", "0.25", "--tolerance", "1e-9")
    native = model_of(driven).simulate(interval=0.25, tolerance=1e-10, inputs=(times, {"F": values}))
    np.testing.assert_allclose(found["time"], native.time)
    np.testing.assert_allclose(found["block.s"], native["block.s"], atol=2e-7)


def test_a_table_of_one_input(driven: Path, simulate: Simulate) -> None:
    """In a unit of its own, and with rows that hold."""
    Path("u.csv").write_text("t [ms],F [kN]\n0,0.003\n1000,0.001\n2000,0.001\n")
    for named, values in (("u.csv", [3, 1, 1]), ("u.csv:steps", [3, 3, 1, 1, 1])):
        found = simulate(fmu_of(driven, "2"), "--kind", "me", "-u", f"F={named}", "--interval", "0.5", "--tolerance", "1e-9")
        times = [0, 1, 2] if len(values) == 3 else [0, 1, 1, 2, 2]
        native = model_of(driven).simulate(interval=0.5, tolerance=1e-10, inputs=(times, {"F": values}))
        np.testing.assert_allclose(found["block.s"], native["block.s"], atol=2e-7)


def test_defaults_are_those_of_the_experiment(simulate: Simulate, capsys: pytest.CaptureFixture[str]) -> None:
    path = EXAMPLES / "suspended_bar.lag"
    found = simulate(fmu_of(path, "3"), "--plot", "x.png", "--stats")
    native = model_of(path).simulate()
    np.testing.assert_allclose(found["time"], native.time, atol=1e-12)
    np.testing.assert_allclose(found["y"], native["y"], atol=1e-9)
    assert Path("x.png").stat().st_size > 10_000
    said = capsys.readouterr().out
    assert "FMI 3.0, Co-Simulation; 4 states, 0 to 10 s, tolerance 1e-08" in said
    assert "501 rows in x.csv, picture in x.png" in said and "500 communication steps" in said and "made by Lagrangia" in said


def test_a_stop_that_is_no_multiple_gets_a_row(simulate: Simulate) -> None:
    found = simulate(fmu_of(EXAMPLES / "pendulum.lag", "2"), "--start", "1", "--stop", "1.75", "--interval", "0.5",
                     "--plot-quantities", "energy.total", "--plot", "x.svg")
    assert found["time"].tolist() == [1, 1.5, 1.75]
    assert "energy.total" in found and "energy.total" in Path("x.svg").read_text()
    later = simulate(fmu_of(EXAMPLES / "pendulum.lag", "2"), "--at", "0.5,1")
    assert later["time"].tolist() == [0.5, 1], "no row at the start unless it is asked for"


WRONGS = {
    ("--solver", "erk"): "not supported for an FMU: --solver", ("--engine", "tape"): "not supported for an FMU: --engine",
    ("--reactions",): "not supported for an FMU: --reactions", ("--dump", "c"): "not supported for an FMU: --dump",
    ("--model", "M"): "not supported for an FMU: --model", ("--max-step", "1"): "not supported for an FMU: --max-step",
    ("--max-steps", "9"): "not supported for an FMU: --max-steps", ("--kind", "xx"): "there is no kind of FMU 'xx'",
    ("-p", "mm=1"): "did you mean 'm'?", ("-p", "block.s=1"): "'block.s' is no parameter", ("-p", "m=1[s]"): "kg is wanted",
    ("-p", "m=x"): "is no number", ("-p", "m"): "NAME=VALUE", ("-p", "m=-1"): "the FMU says it lies from 0",
    ("--initial", "m=1"): "give it by -p", ("--initial", "F=1"): "give it by -u", ("--initial", "felt=1"): "computed by the FMU",
    ("-u", "m=1"): "'m' is no input", ("-u", "G=1"): "the FMU has no variable 'G'", ("-u", "none.csv"): "cannot be read",
    ("-u", "F=none.csv"): "cannot be read", ("-u", "m=none.csv"): "'m' is no input", ("-u", "F=u.csv:cubic"): "as a smooth table",
    ("--outputs", "fell"): "did you mean 'felt'?", ("--plot", "x.doc"): "is no picture", ("--stop", "-1"): "must be later",
    ("--tolerance", "2"): "between 0 and 1", ("--interval", "0"): "a positive number",
    ("--interval", "1e-7"): "are more than", ("--interval", "1e-9"): "rows are asked for",
    ("--at", "1,0"): "finite and rising", ("--at", "0,9", "--stop", "2"): "must lie between", ("--at", "a"): "is no number",
    ("--stop", "nan"): "a finite number", ("-o", "/nowhere/x.csv"): "cannot be written",
}


@pytest.mark.parametrize("options", WRONGS, ids=" ".join)
def test_what_cannot_be_done_is_said(
    options: tuple[str, ...], driven: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    assert main(["simulate", str(fmu_of(driven, "2")), *options]) == WRONG
    told = capsys.readouterr().err
    assert WRONGS[options] in told and "error[L" in told and "Traceback" not in told


def test_what_was_computed_is_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """s'' = 6 s^2 from s = 1, s' = 2 is 1/(1 - t)^2: infinite at t = 1."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "explosion.lag"
    path.write_text("model Explosion coordinate Length s(start = 1); Velocity v(start = 2) = der(s); "
                    "energy kinetic 1[kg]*v^2/2; potential -2[J/m3]*s^3; annotation(experiment(StopTime = 3)); end Explosion;")
    for kind in ("cs", "me"):
        assert main(["simulate", str(fmu_of(path, "2")), "--kind", kind, "--interval", "0.3", "--tolerance", "1e-7"]) == FAILED
        told = capsys.readouterr().err
        assert "error: at t = 0.9" in told and "rows before it are kept in" in told
        (table,) = tmp_path.glob("*.csv")
        rows = np.genfromtxt(table, delimiter=",", names=True)
        assert rows["time"][-1] == pytest.approx(0.9) and rows["s"][-1] == pytest.approx(100, rel=1e-3 if kind == "cs" else 0.2)
        table.unlink()


def test_kinds_belong_to_fmus(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(EXAMPLES / "pendulum.lag"), "--kind", "cs"]) == WRONG
    assert "--kind belongs to FMUs" in capsys.readouterr().err


def test_without_fmpy(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    import lagrangia.fmu.process

    path = fmu_of(EXAMPLES / "pendulum.lag", "2")
    monkeypatch.setattr(lagrangia.fmu.process, "find_spec", lambda name: None)
    for command in ("simulate",), ("fmu", "check"):
        assert main([*command, str(path)]) == WRONG
        assert 'pip install "lagrangia[fmu]"' in capsys.readouterr().err


def test_rows_to_standard_output(capsys: pytest.CaptureFixture[str]) -> None:
    assert main(["simulate", str(fmu_of(EXAMPLES / "pendulum.lag", "3")), "--at", "0,1", "-o", "-", "--quiet"]) == DONE
    names, first, second = capsys.readouterr().out.splitlines()
    assert names.startswith("time,hinge.phi,") and first.startswith("0.0,") and second.startswith("1.0,")
    assert all(math.isfinite(float(x)) for x in second.split(","))


def test_ramps_in_co_simulation_of_fmi_3(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """x'' = F/m, F = 6 t on 2 kg from rest: v = 1.5 t^2, x = t^3/2; steps that hold inputs err, and it is said."""
    (tmp_path / "cart.lag").write_text("""model Cart
      Block b(m = 2, base = world); input Force F(start = 0); AppliedForce f(at = b.center, force = {F, 0}); output Force y = F;
    end Cart;""")
    (tmp_path / "ramp.csv").write_text("time,F\n0,0\n3,18\n")
    assert main(["export", str(tmp_path / "cart.lag"), "--to", "fmu", "--fmi", "3", "-o", str(tmp_path / "c.fmu")]) == 0
    capsys.readouterr()
    command = ["simulate", str(tmp_path / "c.fmu"), "--kind", "cs", "--stop", "3", "--interval", "0.01", "-u",
               str(tmp_path / "ramp.csv")]
    assert main([*command, "-o", str(tmp_path / "x.csv")]) == 0
    assert "cannot follow slopes of inputs" in capsys.readouterr().err
    lines = (tmp_path / "x.csv").read_text().splitlines()
    last = dict(zip(lines[0].split(","), lines[-1].split(","), strict=True))
    assert float(last["b.v"]) == pytest.approx(13.5, rel=1e-9) and float(last["b.s"]) == pytest.approx(13.5, rel=1e-4)
    assert float(last["y"]) == pytest.approx(18, rel=1e-12)


STEP = """model Step
  World world(gravity = {0, 0});
  Block b(m = 1, base = world, s(start = -0.6, fixed = true), v(start = 1, fixed = true));
energy
  potential noEvent(if b.s > 0 then 0.4[J] else 0);
  annotation(experiment(StopTime = 1.2), allow = "L0744");
end Step;"""


def test_what_an_fmu_says_is_told(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> None:
    """An account that does not close fails the run, as in the scene's own; an assertion that warns does not."""
    monkeypatch.chdir(tmp_path)
    path = tmp_path / "step.lag"
    path.write_text(STEP)
    asked = ["simulate", str(fmu_of(path, "3")), "--kind", "cs", "--quiet", "-o", "x.csv", "--stop"]
    assert main([*asked, "1.2"]) == FAILED
    assert "s on the energy account misses by 4.0e-01 J" in capsys.readouterr().err
    assert main([*asked, "0.5"]) == DONE  # before it comes to the step
    assert capsys.readouterr().err == ""
    path.write_text("""model Falls
  Prismatic a(a = world, along = {0, 1}); PointMass m(m = 1, center = a.b);
equation
  assert(a.v > -4, "quick", AssertionLevel.warning);
end Falls;""")
    assert main(["simulate", str(fmu_of(path.rename(tmp_path / "falls.lag"), "2")), "--quiet", "-o", "x.csv"]) == DONE
    assert "an assertion does not hold (quick)" in capsys.readouterr().err
