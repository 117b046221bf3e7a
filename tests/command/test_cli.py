"""The command `lag` as a person uses it: in a folder of their own, by what it prints, writes and returns."""

import csv
import math
import os
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

import numpy as np
import pytest
from matplotlib.image import imread

from helpers.reference import pendulum_angle
from lagrangia import __version__
from lagrangia.command.cli import main
from lagrangia.compile.pipeline import PHASES
from lagrangia.run.solvers import WAYS

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
PUSHED = """
model Pushed "A block pushed by two inputs"
  parameter Mass m = 2;
  input Force F;
  input Force G(start = 3);
  Block block(m = m, base = world, along = {1, 0});
  AppliedForce push(at = block.center, force = {F + G, 0});
end Pushed;
"""


class Outcome(NamedTuple):
    code: int
    out: str
    err: str


Lag = Callable[..., Outcome]


@pytest.fixture
def lag(tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]) -> Lag:
    """Runs `lag` in an empty folder."""
    monkeypatch.chdir(tmp_path)

    def run(*arguments: object) -> Outcome:
        try:
            code = main([str(argument) for argument in arguments])
        except SystemExit as stop:
            code = int(stop.code or 0)
        return Outcome(code, *capsys.readouterr())

    return run


def simulate(lag: Lag, example: str, *arguments: object) -> Outcome:
    """A run that must succeed."""
    outcome = lag("simulate", EXAMPLES / f"{example}.lag", *arguments)
    assert outcome.code == 0, outcome.err
    return outcome


def table(path: str | Path) -> dict[str, np.ndarray]:
    with Path(path).open(newline="", encoding="utf-8") as stream:
        names, *rows = csv.reader(stream)
    return dict(zip(names, np.array(rows, float).T, strict=True))


# ---------------------------------------------------------------- results


def test_a_run_prints_a_summary_and_writes_its_rows_here(lag: Lag) -> None:
    said = simulate(lag, "suspended_bar").out
    rows = table("suspended_bar.csv")
    assert list(rows) == ["time", "guide.s", "tilt.phi", "der(guide.s)", "der(tilt.phi)", "y"]
    np.testing.assert_allclose(rows["time"], np.linspace(0, 10, 501), rtol=1e-14)
    assert rows["tilt.phi"][0] == np.radians(5)
    assert "SuspendedBar: Bar hung on two vertical springs" in said
    assert "2 coordinates (guide.s, tilt.phi), 0 to 10 s, tolerance 1e-08" in said
    assert "energy account closes to" in said
    assert "501 rows in suspended_bar.csv, one every 0.02 s" in said


def test_stop_tolerance_interval_output_and_plot(lag: Lag) -> None:
    simulate(lag, "chain", "--stop", 5, "--tolerance", 1e-10, "--interval", 0.01, "-o", "result.csv", "--plot", "chain.png")
    assert table("result.csv")["time"].tolist() == pytest.approx(np.linspace(0, 5, 501))
    assert not Path("chain.csv").exists()
    picture = imread("chain.png")
    height, width = picture.shape[:2]
    assert width > 500
    assert height > 200
    assert len(np.unique(picture.reshape(-1, picture.shape[2]), axis=0)) > 50, "five curves in five colours, smoothed"


@pytest.mark.parametrize("suffix", ["svg", "pdf"])
def test_plot_of_chosen_quantities(lag: Lag, suffix: str) -> None:
    simulate(lag, "pendulum", "--plot", f"p.{suffix}", "--plot-quantities", "hinge.phi,bob.center.y")
    assert Path(f"p.{suffix}").stat().st_size > 5000


def test_times_parameters_start_values_and_statistics(lag: Lag) -> None:
    options = ["--at", "0,0.5,1.25", "-p", "L=2", "-p", "m=0.3", "--initial", "hinge.phi=1.2", "--stats", "--tolerance", 1e-12]
    said = simulate(lag, "pendulum", *options).out
    rows = table("pendulum.csv")
    assert rows["time"].tolist() == [0, 0.5, 1.25]
    np.testing.assert_allclose(rows["hinge.phi"], pendulum_angle(rows["time"], L=2, phi0=1.2), atol=1e-10)
    for word in ("steps", "rejected", "dense outputs", "nodes", "taylor, tape"):
        assert word in said


def test_values_may_carry_units(lag: Lag) -> None:
    simulate(lag, "pendulum", "-p", "L=200[cm]", "--initial", "hinge.phi=70[deg]", "--at", "0,1", "-o", "a.csv")
    simulate(lag, "pendulum", "-p", "L=2", "--initial", f"hinge.phi={math.radians(70)!r}", "--at", "0,1", "-o", "b.csv")
    assert Path("a.csv").read_text() == Path("b.csv").read_text()


def test_start_value_of_a_rate_under_both_its_names(lag: Lag) -> None:
    for name in ("hinge.w", "der(hinge.phi)"):
        simulate(lag, "pendulum", "--initial", f"{name}=2.5", "--at", "0", "-o", "a.csv")
        assert table("a.csv")["der(hinge.phi)"].tolist() == [2.5]


def test_an_array_parameter_is_set_as_a_whole(lag: Lag) -> None:
    simulate(lag, "free_bar", "-p", "world.gravity={0,-1.62}", "--at", "0,2")
    assert table("free_bar.csv")["bar.center.y"][-1] == pytest.approx(4 * 2 - 1.62 * 2**2 / 2)


def test_start_time(lag: Lag) -> None:
    simulate(lag, "torsion_rotor", "--start", 0.5, "--stop", 1.5, "--interval", 0.25)
    rows = table("torsion_rotor.csv")
    assert rows["time"].tolist() == [0.5, 0.75, 1, 1.25, 1.5]
    assert rows["twist"][1] != 0, "the motor runs from 0.5 s on"


@pytest.mark.parametrize("arguments", [("--start", "-1e0", "--interval", "0.5"), ("--start", "-1.", "--at", "-1,-5e-1,0")])
def test_negative_numbers_are_values_however_written(arguments: tuple[str, ...], lag: Lag) -> None:
    simulate(lag, "torsion_rotor", *arguments, "--stop", "0")
    assert table("torsion_rotor.csv")["time"].tolist() == [-1, -0.5, 0]


def test_rows_on_standard_output(lag: Lag) -> None:
    outcome = simulate(lag, "pendulum", "-o", "-", "--at", "0,1")
    assert [len(line.split(",")) for line in outcome.out.splitlines()] == [3, 3, 3]
    assert "Pendulum" in outcome.err
    assert not list(Path().iterdir())


def test_names_with_commas_are_quoted_in_files_and_on_standard_output(lag: Lag) -> None:
    Path("grid.lag").write_text("""model Grid
  Block b[1,2](each m = 1, each base = world, each along = {1, 0}, s(each start = 2));
end Grid;""")
    shown = lag("simulate", "grid.lag", "-o", "-", "--at", "0").out
    assert lag("simulate", "grid.lag", "-o", "grid.csv", "--at", "0").code == 0
    assert shown == Path("grid.csv").read_text()
    assert next(csv.reader(shown.splitlines())) == ["time", "b[1,1].s", "b[1,2].s", "der(b[1,1].s)", "der(b[1,2].s)"]


def test_quiet_says_nothing(lag: Lag) -> None:
    assert simulate(lag, "pendulum", "--quiet") == (0, "", "")
    assert Path("pendulum.csv").exists()


def test_quiet_keeps_warnings_back_but_not_from_strict(lag: Lag) -> None:
    """Of what does nothing, and of inputs that nobody gave; errors are told whatever is said."""
    Path("idle.lag").write_text("model Idle parameter Mass idle = 1; input Force u; Block b(m = 1, base = world);"
                                " AppliedForce f(at = b.center, force = {u, 0}); end Idle;")
    for command in ("simulate", "sweep"):
        loud = lag(command, "idle.lag", "-o", "loud.csv")
        assert loud.code == 0 and "L0224" in loud.err and "L0708" in loud.err
        assert lag(command, "idle.lag", "-o", "quiet.csv", "--quiet") == (0, "", "")
        strict = lag(command, "idle.lag", "-o", "strict.csv", "--quiet", "--strict")
        assert strict.code == 2 and "L0224" in strict.err and "L0710" in strict.err


def test_outputs_adds_columns(lag: Lag) -> None:
    simulate(lag, "double_pendulum", "--outputs", "elbow.b.r,der(elbow.w)", "--at", "0,1")
    rows = table("double_pendulum.csv")
    assert list(rows)[-3:] == ["elbow.b.r[1]", "elbow.b.r[2]", "der(elbow.w)"]
    assert np.hypot(rows["elbow.b.r[1]"], rows["elbow.b.r[2]"]).tolist() == pytest.approx([1, 1]), "the first link is 1 m long"


def test_outputs_that_are_columns_anyway_are_written_once(lag: Lag) -> None:
    given = "elbow.phi,der(elbow.phi),elbow.b.r[1],elbow.b.r,elbow.w"
    simulate(lag, "double_pendulum", "--outputs", given, "--at", "0,1", "-o", "a.csv")
    names = Path("a.csv").read_text().splitlines()[0].split(",")
    assert names == ["time", "shoulder.phi", "elbow.phi", "der(shoulder.phi)", "der(elbow.phi)", "elbow.b.r[1]", "elbow.b.r[2]",
                     "elbow.w"]


@pytest.mark.parametrize("name", ["x.feather", "x.xlsx", "x.CSVX", "x.png"])
def test_a_table_of_another_kind_is_refused(name: str, lag: Lag) -> None:
    outcome = lag("simulate", EXAMPLES / "pendulum.lag", "-o", name)
    assert outcome.code == 2
    assert f"'{name}' is no table that can be written\n   = its name should end in .csv" in outcome.err
    assert not list(Path().iterdir())


@pytest.mark.parametrize("name", ["x.CSV", "x.txt", "rows", "rows_0.5"])
def test_names_that_say_table_or_nothing_are_taken(name: str, lag: Lag) -> None:
    simulate(lag, "pendulum", "-o", name, "--at", "0,1")
    assert len(Path(name).read_text().splitlines()) == 3


def test_reactions_adds_those_of_every_joint(lag: Lag) -> None:
    simulate(lag, "slider_crank", "--reactions", "--at", "0,1")
    names = [name for name in table("slider_crank.csv") if "reaction" in name]
    assert names == [f"{joint}.{what}" for joint in ("O", "guide", "pin", "wrist")
                     for what in ("reaction[1]", "reaction[2]", "reaction_torque")]


ARCH = """model Arch "Two bars and a load"
  Revolute left(a = world, phi(start = 40[deg])), right(a = shift(world, {2, 0}), phi(start = 140[deg])), apex(a = l.b, b = r.b);
  Bar l(m = 4, L = 1.25, a = left.b), r(m = 4, L = 1.25, a = right.b);
  AppliedForce load(at = l.b, force = {0, -100});
end Arch;"""
CANTILEVER = """model Cantilever
  Weld wall(a = world); Bar beam(m = 2, L = 1, a = wall.b); AppliedForce load(at = beam.b, force = {0, -100[N/s]*time});
end Cantilever;"""


@pytest.mark.parametrize(("text", "told"), [
    (ARCH, {"apex": (92.8267, -50, 0), "left": (92.8267, 89.24, 0), "right": (-92.8267, 89.24, 0)}),
    (CANTILEVER, {"wall": (0, 119.62, 109.81)}),
], ids=["arch", "cantilever"])
def test_a_scene_that_cannot_move_tells_its_reactions(text: str, told: dict[str, tuple], lag: Lag) -> None:
    Path("still.lag").write_text(text)
    out = lag("simulate", "still.lag", "--stop", "1").out
    _head, _, below = out.partition("no freedom is left, so it stands still")
    assert below.splitlines()[1].split() == ["F_x", "[N]", "F_y", "[N]", "M", "[N.m]"]
    found = {words[0]: tuple(map(float, words[1:])) for words in map(str.split, below.splitlines()[2:]) if words}
    assert found == told
    torques = [name for name in table("still.csv") if name.endswith("reaction_torque")]
    assert torques == [f"{joint}.reaction_torque" for joint in told]
    assert "0 degrees of freedom, so it stands still: statics" in lag("check", "still.lag").out


def test_integrators_of_casadi_refuse_constraints(lag: Lag) -> None:
    outcome = lag("simulate", EXAMPLES / "four_bar.lag", "--solver", "casadi:cvodes")
    assert outcome.code == 2
    assert "error[L0909]: not supported yet: constraints that stay in the equations" in outcome.err


def test_the_last_model_runs_unless_another_is_named(lag: Lag) -> None:
    Path("two.lag").write_text("model A Block s(m = 1, base = world); end A; model B Block t(m = 1, base = world); end B;")
    lag("simulate", "two.lag", "-o", "b.csv")
    lag("simulate", "two.lag", "--model", "A", "-o", "a.csv")
    assert "t.s" in table("b.csv")
    assert "s.s" in table("a.csv")


def test_a_run_that_reaches_its_limit_of_steps_keeps_its_rows(lag: Lag) -> None:
    outcome = lag("simulate", EXAMPLES / "pendulum.lag", "--max-steps", 4)
    assert outcome.code == 1
    assert "limit of steps" in outcome.err
    assert 1 < len(table("pendulum.csv")["time"]) < 501


def test_max_step_bounds_the_steps(lag: Lag) -> None:
    said = simulate(lag, "free_bar", "--solver", "erk", "--max-step", 0.01, "--stats").out
    steps = int(said.partition(" steps,")[0].split()[-1])
    assert 200 <= steps < 250


# ---------------------------------------------------------------- inputs, structure, solvers


@pytest.fixture
def pushed(lag: Lag) -> Path:
    """A scene with the inputs F and G in the present folder."""
    scene = Path("pushed.lag")
    scene.write_text(PUSHED)
    return scene


def test_constant_inputs(lag: Lag, pushed: Path) -> None:
    assert lag("simulate", pushed, "-u", "F=1[kN]", "--at", "0,2").code == 0
    assert table("pushed.csv")["block.s"].tolist() == pytest.approx([0, (1000 + 3) / 2 * 2**2 / 2])


def test_input_table(lag: Lag, pushed: Path) -> None:
    """F rises to 6 N in 1 s, jumps to -3 N and stays: v is the area under F/m."""
    Path("push.csv").write_text("time,F\n0,0\n1,6\n1,-3\n2,-3\n")
    assert lag("simulate", pushed, "-u", "push.csv", "-u", "G=0", "--at", "0,1,2,3", "--tolerance", 1e-12).code == 0
    rows = table("pushed.csv")
    np.testing.assert_allclose(rows["der(block.s)"], [0, 1.5, 0, -1.5], atol=1e-12)


def test_a_structural_parameter_is_compiled_in(lag: Lag) -> None:
    simulate(lag, "chain", "-p", "n=20", "-p", "link[20].m=2", "--stop", 0.1)
    assert [name for name in table("chain.csv") if name.endswith("].phi")] == [f"hinge[{k}].phi" for k in range(1, 21)]


@pytest.mark.parametrize("example", ["pendulum", "cart_pole", "torsion_rotor"])
@pytest.mark.parametrize("integrator", ["cvodes", "idas"])
def test_integrators_of_casadi_agree(lag: Lag, example: str, integrator: str) -> None:
    options = ["--stop", 2, "--interval", 0.1, "--tolerance", 1e-9]
    simulate(lag, example, *options, "-o", "ours.csv")
    said = simulate(lag, example, *options, "-o", "casadi.csv", "--solver", f"casadi:{integrator}").out
    assert f"casadi:{integrator}" in said
    ours, theirs = table("ours.csv"), table("casadi.csv")
    assert list(ours) == list(theirs)
    for name, values in ours.items():
        np.testing.assert_allclose(theirs[name], values, rtol=0, atol=1e-6 * np.abs(values).max(), err_msg=name)


def test_changing_numbers_compiles_nothing(lag: Lag, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    cache = tmp_path / "cache"
    monkeypatch.setenv("LAGRANGIA_CACHE", str(cache))

    def kept() -> dict[Path, int]:
        return {path: path.stat().st_mtime_ns for path in cache.rglob("*") if path.is_file()}

    simulate(lag, "disc_and_block")
    first = kept()
    simulate(lag, "disc_and_block", "-p", "m=3", "--initial", "block.s=0.1", "--stop", 1, "--tolerance", 1e-6)
    assert first
    assert kept() == first
    simulate(lag, "chain", "-p", "n=2")
    assert len(kept()) > len(first)


# ---------------------------------------------------------------- looking without running


@pytest.mark.parametrize("phase", PHASES)
def test_every_phase_can_be_printed(lag: Lag, phase: str) -> None:
    outcome = simulate(lag, "disc_and_block", "--dump", phase)
    assert len(outcome.out.splitlines()) >= 4
    assert not list(Path().iterdir()), "nothing is run"


def test_check_tells_of_each_file_in_turn(lag: Lag) -> None:
    """That it accepts every example is what a command of the README shows (tests/whole/test_readme.py)."""
    files = sorted(EXAMPLES.glob("c[hr]*.lag"))
    outcome = lag("check", *files)
    assert outcome.code == 0
    heads = [line for line in outcome.out.splitlines() if not line.startswith("  ")]
    assert [line.partition(": ")[0] for line in heads] == list(map(str, files))
    assert "chain.lag: Chain: 5 degrees of freedom\n  coordinates hinge[1].phi, hinge[2].phi" in outcome.out


def checked(lag: Lag, text: str) -> list[str]:
    """What `lag check` says of a scene, behind its file's name."""
    Path("scene.lag").write_text(text)
    outcome = lag("check", "scene.lag")
    assert outcome.code == 0, outcome.err
    return outcome.out.removeprefix("scene.lag: ").splitlines()


def test_check_tells_loops_and_what_repeats(lag: Lag) -> None:
    said = lag("check", EXAMPLES / "parallelogram.lag").out.splitlines()
    assert said[0].endswith("Parallelogram: 1 degree of freedom")
    assert said[1] == "  coordinates hook[1].phi, hook[2].phi, hook[3].phi, eye[1].phi; 4 constraints, 2 closed loops"
    assert said[2].startswith("  the loop world - hook[3]")
    assert said[2].endswith("repeats in part what others already impose")


def test_check_tells_what_others_give(lag: Lag) -> None:
    said = lag("check", EXAMPLES / "gear_train.lag").out.splitlines()[1:]
    assert said == ["  coordinates shaft[1].phi", "  given by others: shaft[2].phi, shaft[3].phi"]


def test_check_tells_a_singular_start(lag: Lag) -> None:
    said = checked(lag, """model Flat
      Revolute O(a = world), A(a = crank.b), B(a = coupler.b, b = rocker.b), C(a = shift(world, {1, 0}));
      Bar crank(m = 1, L = 0.4, a = O.b), coupler(m = 1, L = 1, a = A.b), rocker(m = 1, L = 0.4, a = C.b); end Flat;""")
    assert said[0] == "Flat: 1 degree of freedom"
    assert said[2] == ("  the start is a singular position, where 2 ways of moving meet: A.phi = -1 O.phi, C.phi = 1 O.phi; "
                       "or O.phi = -0.428571 A.phi, C.phi = 1 A.phi")


@pytest.mark.parametrize(("tie", "what"), [
    ("bar.b.x = 0.6", "so it stands still: statics"),
    ("hinge.phi = 0.3*sin(2[rad/s]*time)", "its motion is prescribed"),
])
def test_check_tells_scenes_without_freedom(lag: Lag, tie: str, what: str) -> None:
    said = checked(lag, f"""model M Revolute hinge(a = world, phi(start = 0.5)); Bar bar(m = 1, L = 1, a = hinge.b);
      equation {tie}; end M;""")
    assert said[0].startswith("M: 0 degrees of freedom")
    assert said[0].endswith(what)


def test_check_tells_a_loop_that_cannot_close(lag: Lag) -> None:
    Path("open.lag").write_text("""model Open Revolute left(a = world), right(a = shift(world, {2, 0}));
      Bar bar(m = 1, L = 1, a = left.b, b = right.b); end Open;""")
    outcome = lag("check", "open.lag")
    assert (outcome.code, outcome.out) == (2, "")
    assert "error[L0606]: the loop world - right - bar - left - world cannot close: it misses by 1 (m or rad)" in outcome.err
    assert "open.lag:1:" in outcome.err


@pytest.mark.parametrize("command", ["simulate", "modes"])
def test_a_loop_that_parameters_keep_open_is_shown(command: str, lag: Lag) -> None:
    """Also by a scene that was compiled before, whose text is no longer read."""
    Path("open.lag").write_text("""model Open
  parameter Length L = 2;
  Revolute left(a = world, phi(start = 0.5)), right(a = shift(world, {2, 0}));
  Bar crank(m = 1, L = 1, a = left.b), rod(m = 1, L = L, b = right.b);
  Revolute pin(a = crank.b, b = rod.a);
end Open;""")
    assert lag("simulate", "open.lag", "--quiet").code == 0
    outcome = lag(command, "open.lag", "-p", "L=7")
    assert (outcome.code, outcome.out) == (2, "")
    assert "error[L0606]: the loop world - left - crank - pin - rod - right - world cannot close" in outcome.err
    assert "\n5 |   Revolute pin(a = crank.b, b = rod.a);\n  |            ^^^\n" in outcome.err


def test_check_goes_on_after_a_wrong_file(lag: Lag) -> None:
    Path("wrong.lag").write_text("model Wrong Bar bar(m = 1, l = 2); end Wrong;")
    outcome = lag("check", "wrong.lag", EXAMPLES / "pendulum.lag")
    assert outcome.code == 2
    assert "error[L0203]" in outcome.err
    assert "wrong.lag:1:" in outcome.err
    assert "1 degree of freedom\n  coordinates hinge.phi" in outcome.out


def test_help_lists_topics_and_each_has_a_text(lag: Lag) -> None:
    topics = [line.split()[0] for line in lag("help").out.splitlines() if line.startswith("  ")]
    assert len(topics) >= 3
    for topic in topics:
        assert len(lag("help", topic).out) > 200, topic


def test_help_tells_of_every_solver(lag: Lag) -> None:
    paragraphs = {line.split()[0] for line in lag("help", "solver").out.splitlines() if line[:1].strip()}
    assert {*WAYS, "auto"} <= paragraphs


@pytest.mark.parametrize("arguments", [[], ["fly"], ["simulate"], ["simulate", "x.lag", "--stop", "soon"]])
def test_a_wrong_command_line_is_an_error_like_others(lag: Lag, arguments: list[str]) -> None:
    outcome = lag(*arguments)
    assert outcome.code == 2
    assert outcome.err.startswith("error[L0700]: ")


def test_the_installed_command_says_its_version() -> None:
    command = Path(sys.executable).with_name("lag.exe" if os.name == "nt" else "lag")
    said = subprocess.run([command, "--version"], capture_output=True, text=True, check=True).stdout
    assert said == f"lagrangia {__version__}\n"


def test_casadi_solvers_close_the_energy_account_too(lag: Lag) -> None:
    outcome = simulate(lag, "suspended_bar", "--solver", "casadi:cvodes", "--tolerance", "1e-10")
    residual = float(outcome.out.split("energy account closes to ")[1].split()[0])
    assert 0 < residual < 1e-6


# ---------------------------------------------------------------- prescribed motion, energies, redundancy

TURNED = """
model Turned
  Revolute hinge(a = world);
  Bar bar(m = 1, L = 1, a = hinge.b);
equation
  hinge.w = 10;
end Turned;
"""
DRIVEN = """
model Driven
  Prismatic arm(a = world);
  Bar bar(m = 1, L = 1, center = arm.b);
  Motion drive(of = arm.s, to = 2[m/s]*time);
  PointMass free(m = 1);
  Revolute nothing(a = world, b = world);
end Driven;
"""


def test_a_prescribed_rate_is_no_standstill(lag: Lag) -> None:
    Path("turned.lag").write_text(TURNED)
    assert "0 degrees of freedom: its motion is prescribed" in lag("check", "turned.lag").out
    said = lag("simulate", "turned.lag").out
    assert "no freedom is left: its motion is prescribed" in said
    assert "stands still" not in said


def test_what_is_prescribed_cannot_be_started(lag: Lag) -> None:
    Path("driven.lag").write_text(DRIVEN)
    for name in ("arm.s", "der(arm.s)"):
        said = lag("simulate", "driven.lag", "--initial", f"{name}=2").err
        assert f"'{name}' is prescribed as a function of time" in said
        assert "declare a start" not in said


def test_a_loop_that_repeats_is_told_once(lag: Lag) -> None:
    Path("driven.lag").write_text(DRIVEN)
    assert lag("check", "driven.lag").out.count("the loop world - nothing - world repeats") == 1


def test_energies_among_outputs_are_where_they_are(lag: Lag) -> None:
    said = lag("simulate", EXAMPLES / "pendulum.lag", "--outputs", "energy.kinetic").err
    assert "final(energy.kinetic)" in said and "run.energy.kinetic" in said


def test_modes_seen_from_a_point_that_is_left_say_no_more(lag: Lag) -> None:
    said = lag("modes", EXAMPLES / "double_pendulum.lag", "--about", "start").out
    assert "no equilibrium" in said and "not symmetric" not in said
