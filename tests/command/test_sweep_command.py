"""`lag sweep` as a person uses it: tables, sweeps that are killed and go on, wrong input."""

import csv
import re
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import lagrangia as lag
from command.test_hostile import EXPLOSION, PENDULUM, start
from lagrangia.command.cli import main
from lagrangia.native.build import find_compiler

pytestmark = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
# Long enough to be stopped on the way.
LONG = ("sweep", "pendulum.lag", "-p", "n=2", "-p", "m=normal(1,0.1)", "-p", "L=0.5,1,1.5", "--samples", "1000", "--stop", "40",
        "--outputs", "max(bar[2].b.y),final(hinge[1].phi)", "--jobs", "1")
Run = Callable[..., tuple[int, str]]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("pendulum.lag").write_text(PENDULUM)
    Path("explosion.lag").write_text(EXPLOSION)
    return tmp_path


@pytest.fixture
def run(capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs `lag sweep` in this process: its exit code and all that it said."""

    def command(*arguments: object) -> tuple[int, str]:
        try:
            code = main(["sweep", *map(str, arguments)])
        except SystemExit as stop:
            code = int(stop.code or 0)
        said = "".join(capsys.readouterr())
        assert "Traceback" not in said and "bug:" not in said
        return code, said

    return command


def table(name: str) -> tuple[list[str], list[list[str]]]:
    rows = list(csv.reader(Path(name).read_text().splitlines()))
    return rows[0], rows[1:]


def wait_for(condition: Callable[[], bool], seconds: float = 60) -> None:
    begin = time.monotonic()
    while not condition():
        assert time.monotonic() - begin < seconds
        time.sleep(0.01)


def size(name: str) -> int:
    return Path(name).stat().st_size if Path(name).exists() else 0


# ---------------------------------------------------------------- tables

# A step that no event tells of: what it takes is missing in the account.
STEP = """model Step
  World world(gravity = {0, 0}); parameter Length at = 0;
  Block b(m = 1, base = world, s(start = -0.6, fixed = true), v(start = 10, fixed = true));
energy
  potential noEvent(if b.s > at then 0.4[J] else 0);
  annotation(allow = "L0744");
end Step;
"""


@pytest.mark.parametrize("asked", ["b.s", "max(b.s)"])
def test_open_accounts_are_marked_and_told(run: Run, asked: str) -> None:
    """As by `lag simulate`, whatever is asked for: a row alone judges the account."""
    Path("step.lag").write_text(STEP)
    common = "step.lag", "--stop", "0.5", "--outputs", asked
    code, said = run(*common, "-p", "at=0,5")
    assert code == 1 and "error: the energy account of 1 of 2 runs" in said
    rows = table("step_sweep.csv")[1]
    assert rows[0][3].startswith("the energy account misses by ") and float(rows[0][2]) > 4
    assert rows[1][3] == ""
    code, said = run(*common, "-p", "at=5")
    assert code == 0, said


def test_the_table_holds_what_was_varied_and_what_was_measured(run: Run) -> None:
    code, said = run("pendulum.lag", "-p", "L=0.5,1", "-p", "m=2", "--initial", "hinge[1].phi=10[deg],20[deg]",
                     "--outputs", "max(bar[1].b.x), first_time(hinge[1].phi > 3)", "-u", "M0=0.1", "--stop", "2")
    assert code == 0, said
    names, rows = table("pendulum_sweep.csv")
    assert names == ["run", "L", "hinge[1].phi", "max(bar[1].b.x)", "first_time(hinge[1].phi > 3)", "failure"]
    assert [row[0] for row in rows] == ["0", "1", "2", "3"]
    assert [float(row[1]) for row in rows] == [0.5, 0.5, 1, 1]
    single = lag.load("pendulum.lag").simulate(stop=2, at=np.linspace(0, 2, 2001).tolist(), inputs={"M0": 0.1},
                                               parameters={"L": 1, "m": 2}, initial={"hinge[1].phi": np.radians(20)})
    assert float(rows[3][3]) == pytest.approx(single["bar[1].b.x"].max(), abs=1e-6)
    assert "4 runs, 0 failed" in said
    assert not Path("pendulum_sweep.csv.part").exists()


def test_failed_runs_are_rows_with_a_reason_and_empty_cells(run: Run) -> None:
    code, said = run("explosion.lag", "--initial", "v=2,-2", "--outputs", "at(0.5, s), max(s)", "-o", "-")
    assert code == 0
    rows = list(csv.reader(said.splitlines()[:3]))
    assert rows[1][:2] == ["0", "2.0"]
    assert float(rows[1][2]) == pytest.approx(4)
    assert rows[1][3] == ""
    assert "cannot be continued beyond t = 1" in rows[1][4]
    assert "1 failed: the motion cannot be continued" in said
    assert "nan" not in said.lower()


def test_runs_that_did_not_fail_and_have_no_value_are_told(run: Run) -> None:
    Path("root.lag").write_text("model M parameter Real a = 1; Block b(m = 1, base = world); output Real y = sqrt(a); end M;")
    code, said = run("root.lag", "-p", "a=-2,-1,0,4", "--outputs", "y", "--stop", "0.1")
    assert code == 0 and "4 runs, 0 failed" in said
    assert "final(y): 0 (run 2: a = 0) to 2 (run 3: a = 4); 2 without a value" in said


def test_when_no_run_goes_well_the_sweep_failed(run: Run) -> None:
    code, said = run("explosion.lag", "--initial", "v=2,3")
    assert code == 1
    assert "no run went well" in said
    assert len(table("explosion_sweep.csv")[1]) == 2


def test_parquet_holds_the_same_table(run: Run) -> None:
    parquet = pytest.importorskip("pyarrow.parquet")
    given = ("explosion.lag", "--initial", "v=2,-2,-2.5", "--outputs", "at(0.5, s),max(s)")
    assert run(*given, "-o", "x.parquet")[0] == 0
    assert run(*given, "-o", "x.csv")[0] == 0
    found, (names, rows) = parquet.read_table("x.parquet"), table("x.csv")
    assert found.column_names == names
    assert found.schema.field("v").metadata == {b"unit": b"m/s"}
    for name, cells in zip(names, zip(*rows, strict=True), strict=True):
        assert [cell or None for cell in cells] == [None if x is None else str(x) for x in found[name].to_pylist()]
    frame = lag.load("explosion.lag").simulate_many(initial={"v": [2, -2, -2.5]}, outputs=["at(0.5, s)", "max(s)"]).to_pandas()
    assert frame["max(s)"].isna().tolist() == [True, False, False]
    assert frame["failure"].notna().tolist() == [True, False, False]


def test_without_pyarrow_it_is_said_before_the_runs(run: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    code, said = run("pendulum.lag", "-p", "m=1,2", "-o", "x.parquet")
    assert code == 2
    assert "L0715" in said and "pip install pyarrow" in said


def test_a_dry_run_shows_the_runs(run: Run) -> None:
    code, said = run("pendulum.lag", "-p", "m=1:100:1", "-p", "L=1,2", "--dry-run")
    assert code == 0
    assert "200 runs" in said
    assert "\n1,1.0,2.0\n" in said
    assert not list(Path().glob("*.csv*"))


# ---------------------------------------------------------------- killed, and going on


def uninterrupted() -> bytes:
    assert main([*LONG, "-o", "whole.csv", "--quiet"]) == 0
    return Path("whole.csv").read_bytes()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="kills with SIGKILL")
def test_a_killed_sweep_goes_on_where_it_was(capsys: pytest.CaptureFixture[str]) -> None:
    process = start(*LONG, "-o", "killed.csv")
    wait_for(lambda: size("killed.csv.part") > 20_000)
    process.kill()
    process.communicate()
    part = size("killed.csv.part")
    with Path("killed.csv.part").open("ab") as stream:
        stream.write(b"half an entry, as a machine that went down leaves it")
    assert not Path("killed.csv").exists()
    assert main([*LONG, "-o", "killed.csv"]) == 0
    said = "".join(capsys.readouterr())
    done = int(said.split("killed.csv.part: ")[1].split(" of 3000")[0])
    assert part / 100 < done < 3000
    assert Path("killed.csv").read_bytes() == uninterrupted()
    assert not Path("killed.csv.part").exists()


@pytest.mark.slow
@pytest.mark.skipif(sys.platform == "win32", reason="SIGINT")
def test_control_c_keeps_what_is_done(capsys: pytest.CaptureFixture[str]) -> None:
    process = start(*LONG, "-o", "stopped.csv")
    wait_for(lambda: size("stopped.csv.part") > 20_000)
    process.send_signal(signal.SIGINT)
    begin = time.monotonic()
    _, said = process.communicate(timeout=60)
    assert time.monotonic() - begin < 10
    assert process.returncode == 130
    assert "of 3000 runs are done, and kept in stopped.csv.part" in said
    assert "Traceback" not in said
    assert main([*LONG, "-o", "stopped.csv", "--quiet"]) == 0
    assert Path("stopped.csv").read_bytes() == uninterrupted()


@pytest.mark.skipif(sys.platform == "win32", reason="kills with SIGKILL")
def test_sweeps_are_never_mixed(run: Run) -> None:
    process = start(*LONG, "-o", "x.csv")
    wait_for(lambda: size("x.csv.part") > 20_000)
    code, said = run(*LONG[1:], "-o", "x.csv")
    assert code == 2 and "is running already" in said
    process.kill()
    process.communicate()
    before = Path("x.csv.part").read_bytes()
    for change in (("--seed", "1"), ("--tolerance", "1e-7"), ("--stop", "39"), ("-p", "world.gravity={0,-9.8}")):
        kept = [x for k, x in enumerate(LONG[1:]) if change[0] == "-p" or change[0] not in (x, LONG[k])]
        code, said = run(*kept, *change, "-o", "x.csv")
        assert code == 2 and "belongs to another sweep" in said, change
    assert Path("x.csv.part").read_bytes() == before
    code, said = run(*LONG[1:6], "-p", "L=1", "--samples", "3", "--stop", "1", "--restart", "-o", "x.csv")
    assert code == 0
    assert len(table("x.csv")[1]) == 3


def test_a_file_in_the_way_is_left_alone(run: Run) -> None:
    Path("x.csv.part").write_text("my diary\n")
    code, said = run("pendulum.lag", "-p", "m=1,2", "-o", "x.csv")
    assert code == 2 and "no journal" in said
    assert Path("x.csv.part").read_text() == "my diary\n"
    code, said = run("pendulum.lag", "-p", "m=1,2", "-o", "x.csv", "--restart")
    assert code == 2 and "no journal" in said
    assert Path("x.csv.part").read_text() == "my diary\n"
    Path("x.csv.part").unlink()
    Path("x.csv.part").symlink_to("empty")
    for _ in range(2):  # to nothing, and to a file: it was written through
        code, said = run("pendulum.lag", "-p", "m=1,2", "-o", "x.csv")
        assert code == 2 and "'x.csv.part' cannot be written: it is a link" in said
        Path("empty").touch()
    assert not Path("empty").stat().st_size


def test_a_journal_that_was_cut_off_as_it_was_begun_is_no_obstacle(run: Run) -> None:
    Path("x.csv.part").write_text('{"what": "sweep of')
    assert run("pendulum.lag", "-p", "m=1,2", "--stop", "0.1", "-o", "x.csv")[0] == 0
    assert len(table("x.csv")[1]) == 2 and not Path("x.csv.part").exists()


def test_a_name_too_long_for_a_file_is_told(run: Run) -> None:
    name = "p" * 245
    Path("pendulum.lag").rename(f"{name}.lag")
    code, said = run(f"{name}.lag", "-p", "m=1,2")
    assert code == 2 and "error[L0004]" in said and "too long" in said


def test_without_a_compiler_nothing_is_swept_or_benchmarked(run: Run, monkeypatch: pytest.MonkeyPatch,
                                                            capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    monkeypatch.setattr("lagrangia.native.prebuilt.find", lambda *_, **__: None)
    code, said = run("pendulum.lag", "-p", "m=1,2", "--solver", "erk")
    assert code == 2 and "error[L0901]" in said
    assert main(["bench", "pendulum.lag"]) == 2
    assert "error[L0901]" in capsys.readouterr().err


def test_python_goes_on_too(tmp_path: Path) -> None:
    model = lag.load("pendulum.lag")
    options = {"parameters": {"m": [1, 2, 3]}, "outputs": ["max(hinge[1].phi)"], "stop": 1.0}
    table_ = model.simulate_many(**options, path="x.csv")
    assert table("x.csv")[1][2][2] == repr(table_["max(hinge[1].phi)"][2].item())
    assert table_.names == ["m", "max(hinge[1].phi)"]


# ---------------------------------------------------------------- wrong input

WRONG = {
    "unknown parameter": (["-p", "M=1,2"], "L0701"),
    "unknown coordinate": (["--initial", "hinge.phi=1,2"], "L0701"),
    "unknown quantity": (["--outputs", "max(bar[1].q)"], "L0701"),
    "unknown measure": (["--outputs", "maximum(hinge[1].phi)"], "did you mean 'max'"),
    "measure without a condition": (["--outputs", "first_time(hinge[1].phi)"], "needs a condition"),
    "measure of a formula": (["--outputs", "max(hinge[1].phi + 1)"], "is not the name of a quantity"),
    "measure of a vector": (["--outputs", "max(bar[1].b.r)"], "has 2 elements"),
    "unit of a level": (["--outputs", "first_time(hinge[1].phi > 3[kg])"], "L0711"),
    "time outside": (["--outputs", "at(99, hinge[1].phi)"], "between 0 and"),
    "parenthesis": (["--outputs", "max(hinge[1].phi"], "missing"),
    "empty range": (["-p", "m=1:2:-1"], "there is no way"),
    "step beyond the range": (["-p", "m=1:2:20"], "a step of 20 is longer than the way from 1 to 2"),
    "step beyond the range, down": (["-p", "m=1[kg]:900[g]:-1[kg]"], "a step of -1 is longer than the way from 1 to 0.9"),
    "empty value": (["-p", "m=1,,2"], "before or behind one of the commas"),
    "empty last value": (["-p", "m=1,"], "before or behind one of the commas"),
    "empty argument": (["-p", "m=linspace(1,,2,3)"], "takes 3 numbers"),
    "kind of table": (["-p", "m=1,2", "-o", "x.xlsx"], "its name should end in .csv"),
    "range of two": (["-p", "m=1:2"], "from:to:step"),
    "number of values": (["-p", "m=linspace(1,2,2.5)"], "whole number"),
    "geomspace through zero": (["-p", "m=geomspace(-1,2,3)"], "same sign"),
    "mixed units": (["-p", "L=1,2[mm]"], "some of the numbers have a unit"),
    "wrong unit": (["-p", "L=1[kg],2[kg]"], "L0712"),
    "no number": (["-p", "L=short,long"], "is no number"),
    "another name": (["-p", "m=uniform(1,2),L=3"], "'L' is another name"),
    "distribution in a list": (["-p", "m=1,uniform(1,2)"], "uniform(...) stands alone"),
    "unknown distribution": (["-p", "L=gauss(1,2)", "--samples", "3"], "there is no 'gauss'"),
    "negative deviation": (["-p", "L=normal(1,-2)", "--samples", "3"], "deviation > 0"),
    "arguments": (["-p", "L=normal(1)", "--samples", "3"], "takes 2 numbers"),
    "no number of samples": (["-p", "L=normal(1,0.1)"], "--samples"),
    "samples of nothing": (["-p", "L=1,2", "--samples", "3"], "nothing is random"),
    "no samples": (["-p", "L=normal(1,0.1)", "--samples", "0"], "between 1 and"),
    "sampling": (["-p", "L=normal(1,0.1)", "--samples", "3", "--sampling", "sobol"], "no sampling 'sobol'"),
    "seed": (["-p", "L=normal(1,0.1)", "--samples", "3", "--seed", "-1"], "seed"),
    "too many runs": (["-p", "L=1:2:1e-6", "-p", "m=1:2:1e-6"], "runs; at most"),
    "too many values": (["-p", "L=1:2:1e-12"], "at most"),
    "lengths": (["-p", "L=1,2", "-p", "m=1,2,3", "--together"], "L has 2, m has 3"),
    "given twice": (["-p", "L=1,2", "-p", "L=3"], "given twice"),
    "structural": (["-p", "n=1,2"], "which is compiled in"),
    "jobs": (["-p", "L=1,2", "--jobs", "0"], "jobs must be positive"),
    "solver": (["-p", "L=1,2", "--solver", "casadi:cvodes"], "L0704"),
    "seconds": (["-p", "L=1,2", "--seconds-per-run", "-1"], "L0702"),
    "no table": (["--runs", "none.csv"], "L0713"),
    "table": (["--runs", "pendulum.lag"], "L0713"),
    "folder": (["-p", "L=1,2", "-o", "nowhere/x.csv"], "L0004"),
    "no scheduler": (["-p", "L=1,2", "--dask", "nonsense"], "L0716"),
}


@pytest.mark.parametrize("arguments", WRONG)
def test_wrong_input_is_told(arguments: str, run: Run) -> None:
    given, told = WRONG[arguments]
    code, said = run("pendulum.lag", *given)
    assert code == 2, said
    assert told in said
    assert not list(Path().glob("*.csv*"))


def test_vectors_are_swept(run: Run) -> None:
    """As `lag help sweep` has them: a list of them was read as one vector (L0706)."""
    code, said = run("pendulum.lag", "-p", "world.gravity={0,-9.81},{0,-1.62}", "--stop", "0.1", "-o", "x.csv")
    assert code == 0, said
    rows = Path("x.csv").read_text().splitlines()
    assert rows[0].startswith("run,world.gravity[1],world.gravity[2]")
    assert [row.split(",")[:3] for row in rows[1:]] == [["0", "0.0", "-9.81"], ["1", "0.0", "-1.62"]]


def test_ranges_that_do_not_meet_their_ends_are_told(run: Run) -> None:
    """1:2:0.3 ends at 1.9; with units, downwards, of start values, and in Python."""
    for given in (["-p", "m=1:2:0.3"], ["-p", "m=1[kg]:2000[g]:300[g]"], ["--initial", "hinge[1].phi=10[deg]:-20[deg]:-20[deg]"]):
        code, said = run("pendulum.lag", *given, "--stop", "0.1", "--dry-run")
        assert code == 0
        assert "warning[L0748]" in said, said
        assert "L0748" not in run("pendulum.lag", *given, "--stop", "0.1", "--dry-run", "--allow", "L0748")[1]
        assert run("pendulum.lag", *given, "--stop", "0.1", "--dry-run", "--strict")[0] == 2
    for value in ("0.1:1:0.1", "1:1:1", "3:1:-0.5", "linspace(1, 2, 4)", "1,2"):
        assert "L0748" not in run("pendulum.lag", "-p", f"m={value}", "--dry-run")[1]
    with pytest.warns(lag.InputWarning, match="ends at 1.9, as its step does not meet 2.*L0748"):
        lag.load("pendulum.lag").simulate_many(parameters={"m": "1:2:0.3"}, stop=0.1)


@pytest.mark.parametrize(
    ("text", "told"),
    [("m,L\n1\n", "x.csv:2 has 1 cells, not 2"), ("m,L\n\n1,x\n", "x.csv:3: 'x' for L"), ("m,Lx\n1,1\n", "'Lx'"),
     ("m\n", "at least one row"), ("m,m\n1,1\n", "given twice"), ("m\n\"{1,2}\"\n", "vector"), ("world.gravity\n1\n", "vector")],
)
def test_wrong_tables_are_told(run: Run, text: str, told: str) -> None:
    Path("x.csv").write_text(text)
    code, said = run("pendulum.lag", "--runs", "x.csv", "-o", "out.csv")
    assert code == 2
    assert told in said


def test_python_values_that_are_none(tmp_path: Path) -> None:
    model = lag.load("pendulum.lag")
    for values in ([], ["a"], [1, float("nan")], [[1, 2]], {"x": 1}):
        with pytest.raises(lag.LagError):
            model.simulate_many(parameters={"L": values})


def test_a_simulation_tells_measures_of_its_run(capsys: pytest.CaptureFixture[str]) -> None:
    """They are those of the motion, which the rows agree with."""
    asked = "max(abs(tilt.phi), from=1, to=2), bar.a.y, count(tilt.phi > 0)"
    scene = str(EXAMPLES / "suspended_bar.lag")
    assert main(["simulate", scene, "--outputs", asked, "--stop", "3", "-o", "a.csv"]) == 0
    said = capsys.readouterr().out
    found = dict(line.strip().split(" = ") for line in said.splitlines() if line.startswith(("  max(", "  count(")))
    names, rows = table("a.csv")
    columns = dict(zip(names, np.array(rows, float).T, strict=True))
    phi, times = columns["tilt.phi"], columns["time"]
    shown = np.abs(phi[(times >= 1) & (times <= 2)]).max()
    assert float(found["max(abs(tilt.phi), from=1, to=2)"].removesuffix(" rad")) == pytest.approx(shown, rel=1e-2)
    assert float(found["count(tilt.phi > 0)"]) == (np.diff((phi > 0).astype(int), prepend=0) > 0).sum()
    assert "bar.a.y" in columns
    assert main(["simulate", scene, "--outputs", "maxx(bar.a.y)"]) == 2
    assert "no measure 'maxx'" in capsys.readouterr().err


def test_the_methods_that_ran_are_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
                                        ) -> None:
    """In lanes, which may take others than a run alone, and one by one: nothing told of them."""
    monkeypatch.chdir(tmp_path)
    Path("p.lag").write_text("""model P parameter Mass m = 1; Revolute r[2](each phi(start = 1));
      Bar b[2](each m = m, each L = 1); equation connect(r[1].a, world); connect(b.a, r.b); connect(b[1].b, r[2].a); end P;""")
    for solver, named in (("auto", "(erk9?|pirk|taylor)"), ("pirk", "pirk"), ("implicit", "implicit"), ("adams", "erk, adams")):
        command = f"sweep p.lag -p m=1:9:1 --stop 1 --tolerance 1e-9 --solver {solver} -o y.csv"
        assert main(command.split()) == 0
        assert re.search(f" steps by {named}; the energy", capsys.readouterr().out)


@pytest.mark.parametrize(("scene", "asked", "why"), [
    ("double_pendulum", "--solver pirk", "pirk evaluates the eight stages of one run at once"),
    ("double_pendulum", "--solver adams", "adams has none"), ("vibration_absorber", "", "linear steps from row to row"),
    ("disc_and_block", "--solver linear", "linear steps from row to row"),
    ("spatial_four_bar", "--solver erk", "loops of bodies that turn freely in space"),
    ("parallelogram", "--solver erk", "5 runs do not suit them: constraints that repeat others"),
    ("slider_crank", "", "loops, which"), ("stick_slip", "", "events"), ("pendulum", "", "one degree of freedom that swings"),
    ("double_pendulum", "--max-steps 999", "--max-steps")])
def test_stats_say_why_there_are_no_lanes(scene: str, asked: str, why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch,
                                          capsys: pytest.CaptureFixture[str]) -> None:
    monkeypatch.chdir(tmp_path)
    model = lag.load(EXAMPLES / f"{scene}.lag")
    starts = f"{model.coordinate_names[0]}=linspace(0.3,0.4,5)"
    command = ["sweep", str(EXAMPLES / f"{scene}.lag"), "--initial", starts, "--stop", "0.1", "--stats", *asked.split()]
    assert main([*command, "-o", "y.csv"]) == 0
    assert f"lanes: not used ({why}" in capsys.readouterr().out
