"""Nothing that is written is ignored, nothing of others is overwritten, and what is printed is text: as a user would see it."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest

import lagrangia as lag
from lagrangia.command.cli import main
from lagrangia.native.build import find_compiler

needs_compiler = pytest.mark.skipif(find_compiler() is None, reason="no C compiler")
BLOCK = "model Road\n  Block b(m = 1, base = world, v(start = 1));\nend Road;\n"
SWING = "model Swing\n  Revolute h(a = world, phi(start = 1)); PointMass p(m = 1, center = shift(h.b, {0, -1}));\nend Swing;\n"


@pytest.fixture(autouse=True)
def _folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)


def write(text: str, name: str = "scene.lag") -> str:
    Path(name).write_text(text, encoding="utf-8")
    return name


def lag_process(*arguments: str, **environment: str) -> "subprocess.CompletedProcess[str]":
    return subprocess.run([sys.executable, "-m", "lagrangia", *arguments], check=False, capture_output=True, text=True,
                          timeout=60, env={**os.environ, **environment})


@pytest.mark.parametrize("how", ["final", "protected"])
def test_locked_parameters_cannot_be_set_from_the_command_line(how: str, capsys: pytest.CaptureFixture[str]) -> None:
    word = "final parameter Mass m = 2;" if how == "final" else "protected parameter Mass m = 2;"
    file = write(f"model Part\n  {word}\npublic\n  Block b(m = m, base = world);\nend Part;\n"
                 "model Whole\n  Part part;\nend Whole;\n")
    for command in (["simulate", file, "-p", "part.m=7"], ["sweep", file, "-p", "part.m=7,8"]):
        assert main(command) == 2
        assert f"the parameter 'part.m' is {how}: it cannot be set" in capsys.readouterr().err
    with pytest.raises(lag.LagError, match="cannot be set"):
        lag.load(file).simulate(parameters={"part.m": 7})


@needs_compiler
def test_an_experiment_is_inherited(capsys: pytest.CaptureFixture[str]) -> None:
    base = BLOCK.replace("end Road", "  annotation(experiment(StopTime = 3, Tolerance = 1e-6));\nend Road")
    file = write(base + "model Child\n  extends Road;\n  annotation(experiment(StopTime = 4));\nend Child;\n")
    scene = lag.load(file).scene
    assert (scene.stop, scene.tolerance) == (4, 1e-6)


@needs_compiler
def test_files_of_others_are_kept(capsys: pytest.CaptureFixture[str]) -> None:
    write(BLOCK, "road.lag")
    measured = "x,measured\n0,0.02\n1,0.03\n"
    write(measured, "road.csv")
    assert main(["simulate", "road.lag", "--quiet"]) == 2
    assert "holds none of these results" in capsys.readouterr().err
    assert Path("road.csv").read_text() == measured
    assert main(["simulate", "road.lag", "--quiet", "-o", "road.csv"]) == 0  # it was named
    assert main(["simulate", "road.lag", "--quiet", "--stop", "2"]) == 0  # results of this scene
    assert "b.s" in Path("road.csv").read_text()


@needs_compiler
def test_inputs_that_nobody_gives_are_told(capsys: pytest.CaptureFixture[str]) -> None:
    file = write("model Pushed\n  input Force F;\n  Block b(m = 1, base = world);\n"
                 "  AppliedForce push(at = b.center, force = {F, 0});\nend Pushed;\n")
    assert main(["simulate", file]) == 0
    assert "warning[L0708]: nothing is given for the input 'F': it is 0 N throughout" in capsys.readouterr().err
    write("time,F\n0,1\n0.5,1\n", "push.csv")
    assert main(["simulate", file, "-u", "push.csv"]) == 0
    told = capsys.readouterr().err
    assert "L0708" not in told
    assert "warning[L0709]: the table of inputs goes from 0 to 0.5 s" in told


@needs_compiler
@pytest.mark.parametrize("solver", ["auto", "pirk", "adams", "implicit", "erk9"])
def test_the_summary_names_what_ran(solver: str, capsys: pytest.CaptureFixture[str]) -> None:
    file = write("model Slip\n  Block b(m = 1, base = world, v(start = 1));\n  DryFriction f(F = 2, rate = b.v);\n"
                 "  Spring k(k = 30, stretch = b.s);\nend Slip;\n")
    assert main(["simulate", file, "--solver", solver]) == 0
    line = next(text for text in capsys.readouterr().out.splitlines() if "evaluations" in text)
    run = lag.load(file).simulate(solver=solver)
    assert sum(run.statistics.steps_by) == run.statistics.steps - 1  # at rest from 0.47 s on
    assert "at rest (1 steps)" in line
    counts = [int(count) for count in re.findall(r"\((\d+) steps\)", line)]
    assert sum(counts) == (run.statistics.steps if counts else 0)
    assert solver == "auto" or solver in line
    assert re.search(r"erk|pirk|adams|implicit|linear|taylor", line)


@pytest.mark.parametrize("unit, value", [("slug", 14.593902937206364), ("oz", 0.028349523125), ("mph", 0.44704), ("in", 0.0254),
                                         ("kn", 1852 / 3600), ("kgf", 9.80665), ("kp", 9.80665), ("kip", 4448.2216152605),
                                         ("dyn", 1e-5), ("hp", 745.6998715822702), ("PS", 735.49875),
                                         ("ozf", 0.27801385095378125),
                                         ("lbf/in", 4.4482216152605 / 0.0254), ("min", 60.0), ("mm", 1e-3)])
def test_units_that_engineers_use(unit: str, value: float) -> None:
    from lagrangia.language.units import parse_unit

    assert parse_unit(unit).factor == pytest.approx(value, rel=1e-15)


def test_python_m(capsys: pytest.CaptureFixture[str]) -> None:
    told = lag_process("--version")
    assert (told.returncode, told.stdout) == (0, f"lagrangia {lag.__version__}\n")


def test_streams_that_are_closed_or_know_ascii_alone() -> None:
    file = write(SWING)
    shown = lag_process("equations", file, PYTHONIOENCODING="ascii")
    assert shown.returncode == 0
    assert "phi''" in shown.stdout
    assert shown.stdout.isascii()
    closed = subprocess.run(f'"{sys.executable}" -m lagrangia check {file} >&-', shell=True, capture_output=True, text=True,
                            timeout=60, check=False)
    assert (closed.returncode, closed.stderr) == (0, "")


@needs_compiler
def test_no_text_of_a_model_commands_a_terminal(capsys: pytest.CaptureFixture[str]) -> None:
    file = write('model Red "a\033]0;owned\007\033[31mred\u202e"\n  Block b(m = 1, base = world);\nend Red;\n')
    for command in ("simulate", "equations", "check", "explain"):
        assert main([command, file]) == 0
        told = capsys.readouterr()
        assert not set("\033\007\u202e") & set(told.out + told.err)


@needs_compiler
def test_a_dollar_in_a_name_begins_no_formula() -> None:
    file = write("model Dollar \"a $ and $_$\"\n  Block '$_$'(m = 1, base = world, s(start = 1));\nend Dollar;\n")
    assert main(["simulate", file, "--plot", "x.png"]) == 0
    assert Path("x.png").stat().st_size > 1000


def test_largest_and_sum_of_one_number_and_directions_of_one(capsys: pytest.CaptureFixture[str]) -> None:
    file = write("model One\n  parameter Real y = max(1), z = min(2) + sum(3) + product(4);\n"
                 "  Block b(m = y + z, base = world);\nend One;\n")
    model = lag.load(file)
    assert dict(zip(model.parameter_names, model.parameter_values(), strict=True))["b.m"] == 10
    for text in ("Prismatic j(a = world, along = {1}); PointMass p(m = 1, center = j.b);",
                 "Weld w(a = world, offset = {1, 2, 3, 4}); PointMass p(m = 1); Spring s(a = w.b, b = p.center, k = 1);"):
        assert main(["check", write(f"model Short\n  {text}\nend Short;\n", "short.lag")]) == 2
        assert "error[L0303]" in capsys.readouterr().err


IDLE = """model Idle
  parameter Real unused = 3;
  Block b(m = 1, base = world, v(start = 1));
  Spring s(s_rel0 = 0.1, k = 4, stretch = b.s);
  DryFriction f(F = 2, rate = b.v);
%send Idle;
"""


@needs_compiler
@pytest.mark.parametrize("command", ["check", "simulate", "modes", "export", "equations", "explain"])
def test_warnings_are_silenced_by_code_or_taken_for_errors(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    more = ["--to", "python", "-o", "made.py"] if command == "export" else []
    file = write(IDLE % "")
    assert main([command, file, *more]) == 0
    assert "warning[L0224]" in capsys.readouterr().err
    assert main([command, file, "--strict", *more]) == 2
    assert "which --strict takes for errors" in capsys.readouterr().err
    assert main([command, file, "--strict", "--allow", "L0224", "--allow", "L0741,L0708", *more]) == 0
    assert capsys.readouterr().err == ""
    file = write(IDLE % '  annotation(allow = "L0224, L0741");\n')
    assert main([command, file, "--strict", *more]) == 0
    assert capsys.readouterr().err == ""


def test_what_is_allowed_is_a_code(capsys: pytest.CaptureFixture[str]) -> None:
    for wrong in ('"everything"', "3", '""'):
        assert main(["check", write(IDLE % f"  annotation(allow = {wrong});\n")]) == 2
        assert "'allow' is a text with codes of warnings" in capsys.readouterr().err


def test_what_makes_steps_short_is_told(capsys: pytest.CaptureFixture[str]) -> None:
    file = write("""model Stiff World world(gravity = {0, 0}); Block a(m = 1, base = world, s(start = 1));
      Block b(m = 1, base = world, s(start = 1));
      energy potential 1[N/m3]*a.s^4; potential 1e8[N/m3]*b.s^4; potential 1[N/m]*(a.s - b.s)^2; end Stiff;""")
    assert main(["simulate", file, "--stop", "0.8", "--interval", "0.01"]) == 0
    assert re.search(r"its steps are short, 2.\d?e-05 s on average and 1.\d?e-05 s at least: (der\(b\.s\)|b\.s) limits them",
                     capsys.readouterr().out)
    assert main(["simulate", file, "--stop", "0.02", "--interval", "0.01"]) == 0
    assert "its steps are short" not in capsys.readouterr().out
    runs = [lag.load(file).simulate(stop=stop, interval=0.01) for stop in (0.8, 0.02)]
    assert [any("limits them" in note for note in run.notes) for run in runs] == [True, False]
    cut = lag.load(write("model Cut Block b(m = 1, base = world); AppliedForce f(at = b.center, "
                         "force = {if mod(1e5[1/s]*time, 2) < 1 then 1 else 2, 0}); end Cut;")).simulate(at=[0.3])
    assert re.search(r"s at least: 29999 events cut them", cut.notes[0])
