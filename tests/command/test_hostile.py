"""Hostile files and circumstances, through the command line.

Exit code 2 for wrong input, 1 for runs that fail, never a traceback, and nothing that was written before is lost.
"""

import csv
import hashlib
import os
import resource
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from lagrangia.base.result_files import Target
from lagrangia.command.cli import DONE, FAILED, INTERRUPTED, WRONG, main

PENDULUM = """model Pendulum
  parameter Mass m = 1; parameter Length L = 1; parameter Integer n = 1;
  Revolute hinge[n]; Bar bar[n](each m = m, each L = L); input Torque M0(start = 0);
  AppliedTorque drive(on = bar[1].center, torque = M0);
equation
  connect(world, hinge[1].a);
  for i in 1:n loop connect(hinge[i].b, bar[i].a); end for;
  for i in 1:n-1 loop connect(bar[i].b, hinge[i + 1].a); end for;
initial equation
  hinge[1].phi = 1;
end Pendulum;
"""
# s'' = 6 s^2 from s = 1, s' = 2 is s = 1/(1 - t)^2: infinite at t = 1.
EXPLOSION = """model Explosion
  coordinate Length s(start = 1); Velocity v(start = 2) = der(s);
energy
  kinetic 1[kg]*v^2/2; potential -2[J/m3]*s^3;
  annotation(experiment(StopTime = 3));
end Explosion;
"""
OLD = "an older result\n"
Run = Callable[..., tuple[int, str]]


@pytest.fixture(autouse=True)
def folder(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    monkeypatch.chdir(tmp_path)
    Path("pendulum.lag").write_text(PENDULUM)
    Path("explosion.lag").write_text(EXPLOSION)
    return tmp_path


@pytest.fixture
def lag(capsys: pytest.CaptureFixture[str]) -> Run:
    """Runs the command in this process: its exit code and all that it said."""

    def run(*arguments: str) -> tuple[int, str]:
        try:
            code = main(arguments)
        except SystemExit as stop:
            code = int(stop.code or 0)
        said = "".join(capsys.readouterr())
        assert "Traceback" not in said and "bug:" not in said
        return code, said

    return run


def start(*arguments: str, **options: object) -> subprocess.Popen[str]:
    """The command as a process of its own."""
    command = [sys.executable, "-m", "lagrangia.command.cli", *arguments]
    return subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, **options)  # type: ignore[call-overload]


def finish(process: subprocess.Popen[str]) -> tuple[int, str]:
    out, err = process.communicate(timeout=100)
    assert "Traceback" not in err and "bug:" not in err
    return process.returncode, out + err


def rows(file: str) -> list[list[float]]:
    with open(file, newline="") as stream:
        return [[float(cell) for cell in row] for row in list(csv.reader(stream))[1:]]


# ---------------------------------------------------------------- files


def tower(element: str, storeys: int = 1_000) -> str:
    """A model that has the element with the next model in it, and so on."""
    floors = (f"model A{k} {element.replace('NEXT', f'A{k + 1}')} end A{k};\n" for k in range(storeys))
    return f"{''.join(floors)} model A{storeys} PointMass p(m = 1); end A{storeys}; model M A0 a; end M;"


FILES = {
    "empty": (b"", "has no model to run"),
    "spaces": (b" \n\t\n", "has no model to run"),
    "binary": (bytes(range(256)) * 4, "NUL|not a text file"),
    "nul": (b"model M\0 end M;", "NUL"),
    "latin-1": ("model M \"Masse m\u00fcde\" end M;".encode("latin-1"), "byte 0xfc"),
    "parentheses": (b"model M parameter Real x = " + b"(" * 10_000 + b"1" + b")" * 10_000 + b"; end M;",
                    "nested deeper than 100"),
    "modifications": (b"model M Bar b" + b"(a" * 10_000 + b")" * 10_000 + b"; end M;", "nested deeper than 100"),
    "conditions": (b"model M parameter Real x = " + b"if true then 1 else " * 20_000 + b"1; end M;", "nested deeper than 100"),
    "sum": (b"model M parameter Real x = " + b"+".join([b"1"] * 100_000) + b"; end M;", "more than 2000 operands"),
    "signs": (b"model M parameter Real x = " + b"-" * 10_000 + b"1; end M;", "unexpected '-'"),
    "huge number": (b"model M parameter Real x = 1e400; end M;", "too large for a number"),
    "huge array": (b"model M parameter Real x[1000000000] = 0; end M;", "at most 100000 are"),
    "huge arrays of components": (b"model M Bar b[1000, 1000](each m = 1, each L = 1); end M;", "1000000 elements; at most"),
    "long line": (b"model M parameter Length " + b"x" * 1_000_000 + b" = 1; Revolte h; end M;", "did you mean 'Revolute'"),
    "many equal names": (b"model M " + b"Real y = 2; " * 2_000 + b"end M;", "and 1979 more"),
    "a comment that looks nested": (b"// " + b"(" * 200 + b"\nmodel M Revolte h; end M;", "did you mean 'Revolute'"),
}


@pytest.mark.parametrize("name", FILES)
def test_hostile_file(name: str, lag: Run) -> None:
    content, expected = FILES[name]
    Path("hostile.lag").write_bytes(content)
    code, said = lag("check", "hostile.lag")
    assert code == WRONG
    assert any(part in said for part in expected.split("|"))
    assert max(map(len, said.splitlines())) < 400


@pytest.mark.parametrize("text", [
    "\ufeff" + PENDULUM, PENDULUM.replace("\n", "\r\n"), PENDULUM.replace("\n", " "), PENDULUM + "\n" * 100_000,
    tower("NEXT a;"), tower("extends NEXT;"),
], ids=["byte order mark", "CRLF", "one line", "empty lines", "deep components", "deep extends"])
def test_unusual_but_right(text: str, lag: Run) -> None:
    Path("unusual.lag").write_bytes(text.encode())
    assert lag("check", "unusual.lag")[0] == DONE


# ---------------------------------------------------------------- options

WRONG_OPTIONS = {
    "-p m=nan": "a finite number is needed",
    "-p m=inf": "a finite number is needed",
    "-p m=-1": "'m' is -1 kg, less than its minimum 0 kg",
    "-p L=1e200": "'bar[1].I' has no finite value",
    "-p q=1": "no parameter 'q'",
    "-p m": "not of the form NAME=VALUE",
    "-p =1": "not of the form NAME=VALUE",
    "-p m=one": "'one' is no number",
    "-p m=1[kg": "a ']' is missing",
    "-p m={1": "a '}' is missing",
    "-p m=1[m]": "it is in m, but kg is wanted",
    "-p m=1[stone]": "'stone' is not a unit",
    "-p m={1,2}": "one number is needed, not 2",
    "-p world.gravity={0}": "2 numbers in braces are needed, not 1",
    "-p world.gravity=1": "2 numbers in braces are needed, not one",
    "-p world.gravity={1[m],2}": "it is in m, but m/s2 is wanted",
    "-p n=1.5": "'n' must be an integer, not 1.5",
    "-p n=many": "'n' must be an integer",
    "-p n=0": "'hinge' has 0 elements, not 1",
    "-p n=-1": "'hinge' has the negative size -1",
    "-p n=1e9": "at most 100000 are",
    "--initial foo=1": "no coordinate or rate 'foo'",
    "--initial hinge=1": "no coordinate or rate 'hinge'",
    "--initial hinge[1].phi=nan": "a finite number is needed",
    "--initial hinge[1].phi=30[m]": "it is in m",
    "--outputs foo": "no quantity 'foo'",
    "-u foo=1": "no input 'foo'",
    "-u M0=1[s]": "it is in s",
    "-u missing.csv": "'missing.csv' cannot be read: No such file or directory",
    "--at 1,0": "finite and rising",
    "--at nan": "finite and rising",
    "--at 0,x": "'x' after --at is no number",
    "--at 5,6 --stop 2": "must lie between 0 and 2",
    "--stop -1": "must be later",
    "--stop nan": "the stop time must be a finite number",
    "--stop inf": "the stop time must be a finite number",
    "--tolerance 0": "must lie between 0 and 1",
    "--tolerance -1": "must lie between 0 and 1",
    "--interval 0": "the interval must be a positive number",
    "--interval -1": "the interval must be a positive number",
    "--interval 1e-12 --stop 10": "choose a longer interval",
    "--max-step -1": "the largest step must be a positive number",
    "--max-steps -1": "the number of steps must not be negative",
    "--plot x.xyz": "no picture that can be drawn",
    "--plot missing/x.png": "cannot be written",
    "--plot x.png --plot-quantities foo": "no quantity 'foo'",
    "--solver foo": "there is no solver 'foo'",
    "--solver casadi:foo": "no integrator 'foo'",
    "--dump foo": "there is no phase 'foo'",
    "--model Foo": "has no model 'Foo'",
    "--foo": "unrecognized arguments",
    "-o missing/x.csv": "cannot be written: No such file or directory",
    "-o pendulum.lag/x.csv": "cannot be written: Not a directory",
    "-o .": "cannot be written: Is a directory",
}


@pytest.mark.parametrize("options", WRONG_OPTIONS)
def test_wrong_option(options: str, lag: Run) -> None:
    code, said = lag("simulate", "pendulum.lag", *options.split())
    assert code == WRONG
    assert WRONG_OPTIONS[options] in said


@pytest.mark.parametrize("table", [b"", b"time\n", b"t,M0\n0,1\n", b"time,M0\n0\n", b"time,M0\n0,one\n", b"time,M0\n1,0\n0,0\n",
                                   b"time,M0\n0,nan\n", b"time,foo\n0,1\n", b"\xff\xfe\0"])
def test_wrong_table(table: bytes, lag: Run) -> None:
    Path("table.csv").write_bytes(table)
    assert lag("simulate", "pendulum.lag", "-u", "table.csv")[0] == WRONG


# ---------------------------------------------------------------- runs that fail


@pytest.mark.parametrize(("value", "expected", "words"), [("0", WRONG, "L0504"), ("1e308", FAILED, "t = 0")])
def test_a_mass_that_no_motion_can_have_is_told_with_its_coordinate(value: str, expected: int, words: str, lag: Run) -> None:
    code, said = lag("simulate", "pendulum.lag", "-p", f"m={value}")
    assert code == expected
    assert words in said and "hinge[1].phi" in said


def test_an_explosion_is_told_and_its_rows_are_kept(lag: Run) -> None:
    code, said = lag("simulate", "explosion.lag", "-o", "x.csv")
    assert code == FAILED
    assert "beyond t = 1:" in said and "der(s)" in said
    kept = rows("x.csv")
    assert 0.9 < kept[-1][0] < 1
    assert all(abs(s*(1 - t)**2 - 1) < 1e-5 for t, s, _ in kept)


def test_too_many_steps_keep_the_rows(lag: Run) -> None:
    code, said = lag("simulate", "pendulum.lag", "--max-steps", "3", "-o", "x.csv")
    assert code == FAILED and "raise --max-steps" in said
    assert 0 < len(rows("x.csv")) < 501


def test_a_spring_of_no_length_at_the_start(lag: Run) -> None:
    """distance(a, b) has no derivative where a = b: the run goes on with finite numbers, or says that it cannot."""
    Path("spring.lag").write_text("model M World world(gravity = {0, 0}); PointMass p(m = 1);\n"
                                  "Spring s(k = 3, s_rel0 = 1, a = world, b = p.center); end M;")
    assert lag("simulate", "spring.lag", "-o", "x.csv")[0] in (DONE, FAILED)
    assert all(abs(x) < 10 for row in rows("x.csv") for x in row)


# ---------------------------------------------------------------- compiler and cache


@pytest.fixture
def neither(monkeypatch: pytest.MonkeyPatch) -> None:
    """A machine without a C compiler, where the package came without a run time (with one: tests/native/test_prebuilt.py)."""
    monkeypatch.setenv("LAGRANGIA_CC", "none")
    monkeypatch.setattr("lagrangia.native.prebuilt.find", lambda *_, **__: None)


def test_without_a_c_compiler(lag: Run, request: pytest.FixtureRequest) -> None:
    assert lag("simulate", "pendulum.lag", "--tolerance", "1e-10", "-o", "native.csv")[0] == DONE
    request.getfixturevalue("neither")
    code, said = lag("simulate", "pendulum.lag", "--tolerance", "1e-10", "-o", "casadi.csv")
    assert code == DONE and "no run time came with the package, and no C compiler was found" in said
    pairs = zip(rows("native.csv"), rows("casadi.csv"), strict=True)
    assert max(abs(x - y) for row, other in pairs for x, y in zip(row, other, strict=True)) < 1e-6
    code, said = lag("simulate", str(Path(__file__).parents[2] / "models" / "examples" / "bouncing_ball.lag"))
    assert code == WRONG and "error[L0909]" in said and "cvodes is used" not in said


@pytest.mark.parametrize("options", ["--solver erk", "--solver linear", "--engine native", "--engine tape"])
def test_what_is_asked_for_by_name_is_not_replaced_for_want_of_a_compiler(options: str, lag: Run,
                                                                          neither: None) -> None:
    Path("block.lag").write_text("model M Block b(m = 1, base = world, along = {1, 0}, s(start = 1)); end M;")
    code, said = lag("simulate", "block.lag", *options.split())
    assert code == WRONG and "error[L0704]" in said and f"'{options.split()[1]}' needs a C compiler" in said
    assert not Path("block.csv").exists()


@pytest.mark.parametrize("variable", ["LAGRANGIA_CC", "CC"])
def test_a_compiler_that_no_shell_would_take(variable: str, lag: Run, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("LAGRANGIA_CC", raising=False)
    monkeypatch.setenv(variable, "gcc 'x")
    code, said = lag("simulate", "pendulum.lag")
    assert code == WRONG and f"error[L0706]: the environment variable {variable} holds no command: gcc 'x" in said


DAMAGES: dict[str, Callable[[str], str]] = {
    "empty": lambda text: "", "cut": lambda text: text[: len(text) // 2], "no digest": lambda text: text.partition("\n")[2],
    "a number changed": lambda text: text.replace("1.0", "2.0"),
    "no object": lambda text: signed("[]"), "null": lambda text: signed("null"),
    "imports a list": lambda text: signed(f"[]\n{scene_of(text)}"), "no scene": lambda text: signed("{}\n{}"),
}


def scene_of(text: str) -> str:
    """What stands behind the digest and the imports."""
    return text.split("\n", 2)[2]


def signed(text: str) -> str:
    return f"{hashlib.sha256(text.encode()).hexdigest()}\n{text}"


@pytest.mark.parametrize("damage", DAMAGES)
def test_damaged_cache(damage: str, lag: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """A damaged scene is compiled anew, with the same result."""
    monkeypatch.setenv("LAGRANGIA_CACHE", str(folder / "cache"))
    lag("check", "pendulum.lag")
    (scene,) = (folder / "cache" / "scenes").iterdir()
    whole = scene.read_text()
    scene.write_text(DAMAGES[damage](whole))
    assert lag("check", "pendulum.lag")[0] == DONE
    assert scene_of(scene.read_text()) == scene_of(whole)


def test_a_wrong_scene_leaves_nothing_half_built(folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """The compiler was started on the run time meanwhile."""
    monkeypatch.setenv("LAGRANGIA_CACHE", str(folder / "cache"))
    Path("wrong.lag").write_text("model Wrong\n  World w(\nend Wrong;\n")
    assert finish(start("simulate", "wrong.lag"))[0] == WRONG
    assert (folder / "cache").is_dir()
    assert not [entry for entry in (folder / "cache").iterdir() if entry.name.startswith(".")]


@pytest.mark.parametrize("settings", [
    {}, {"HOME": "/proc"}, {"LAGRANGIA_CACHE": "/proc/none"}, {"LAGRANGIA_CACHE": "pendulum.lag"},
], ids=["no home", "unwritable home", "no place for a cache", "a file for a cache"])
def test_no_place_for_a_cache(settings: dict[str, str], folder: Path) -> None:
    kept = {name: value for name, value in os.environ.items() if name not in ("HOME", "LAGRANGIA_CACHE", "XDG_CACHE_HOME")}
    code, _ = finish(start("simulate", "pendulum.lag", "--quiet", env=kept | {"TMPDIR": str(folder)} | settings))
    assert code == DONE


def test_every_cache_on_a_full_disk_is_told_by_its_name(lag: Run, folder: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    compiler = folder / "full-cc"
    compiler.write_text("#!/bin/sh\necho 'fatal error: No space left on device'\nexit 1\n")
    compiler.chmod(0o755)
    monkeypatch.setenv("LAGRANGIA_CC", str(compiler))
    monkeypatch.setenv("LAGRANGIA_CACHE", str(folder / "cache"))
    code, said = lag("simulate", "pendulum.lag")
    assert code == FAILED and said.startswith(f"error: '{folder / 'cache'}': no room for compiled code")


# ---------------------------------------------------------------- results in the place of what is read

TABLE = "time,M0\n0,0\n1,1\n"
RUNS = "m\n1\n2\n"
IN_PLACE = [
    "simulate pendulum -o pendulum", "sweep pendulum -p m=1,2 -o pendulum", "equations pendulum -o pendulum",
    "export pendulum --to sympy -o pendulum", "export pendulum --to casadi -o pendulum", "export pendulum --to fmu -o pendulum",
    "simulate pendulum -u pendulum.csv", "simulate pendulum -u pendulum.csv -o ./pendulum.csv",
    "simulate pendulum -u pendulum.csv -o link.csv", "sweep pendulum --runs runs.csv -o runs.csv",
    "sweep pendulum --runs pendulum_sweep.csv", "sweep pendulum -p m=1,2 -u pendulum.csv -o pendulum.csv",
    "sweep pendulum --runs x.csv.part -o x.csv", "response pendulum -u pendulum.csv --from M0 -o pendulum.csv",
    "equations pendulum -o explosion.lag", "export pendulum --to sympy -o explosion.lag",
]


@pytest.mark.parametrize("command", IN_PLACE)
def test_no_result_takes_the_place_of_what_is_read(command: str, lag: Run) -> None:
    """Under whatever name; nor that of a scene, which may be imported."""
    Path("pendulum").write_text(PENDULUM)
    Path("pendulum.csv").write_text(TABLE)
    Path("link.csv").symlink_to("pendulum.csv")
    for name in ("runs.csv", "pendulum_sweep.csv", "x.csv.part"):
        Path(name).write_text(RUNS)
    before = {path: path.read_bytes() for path in Path().iterdir()}
    code, said = lag(*command.split())
    assert code == WRONG and "error[L0004]" in said and "does not take its place" in said
    assert {path: path.read_bytes() for path in Path().iterdir()} == before


# ---------------------------------------------------------------- interrupted runs and places that cannot be written

ENDLESS = ("simulate", "pendulum.lag", "--stop", "1e7", "--interval", "0.5", "-p", "n=2", "-o", "x.csv")


def parts_of(process: int) -> list[Path]:
    """What it is writing: files with names, and those without that it has open."""
    opened = [file for file in Path(f"/proc/{process}/fd").glob("*") if os.path.islink(file)
              and os.readlink(file).startswith(f"{Path.cwd().resolve()}/#") and file.exists()]
    return [*Path().glob(".x.csv*.part"), *opened]


@pytest.fixture
def endless() -> Iterator[subprocess.Popen[str]]:
    """A run in the middle of writing x.csv, where an older result is."""
    Path("x.csv").write_text(OLD)
    process = start(*ENDLESS)
    deadline = time.monotonic() + 60
    while not any(part.stat().st_size > 100_000 for part in parts_of(process.pid)):
        assert process.poll() is None and time.monotonic() < deadline
        time.sleep(0.05)
    yield process
    process.kill()
    process.wait()


def test_a_killed_run_leaves_the_older_result(endless: subprocess.Popen[str]) -> None:
    endless.kill()
    endless.wait()
    assert Path("x.csv").read_text() == OLD
    with Target(Path("y.csv")) as target:
        is_nameless = target.is_nameless  # as the file system has it
        target.put("later")
    assert is_nameless != bool(list(Path().glob("*.part"))) and Path("y.csv").read_text() == "later"


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_an_interrupted_run_keeps_its_rows(endless: subprocess.Popen[str], number: signal.Signals) -> None:
    endless.send_signal(number)
    code, said = finish(endless)
    assert code == INTERRUPTED and "interrupted at t =" in said
    assert len(rows("x.csv")) > 100
    assert not list(Path().glob("*.part"))


def test_broken_pipe() -> None:
    process = start("simulate", "pendulum.lag", "-o", "-", "--interval", "1e-5")
    assert process.stdout is not None and process.stdout.readline().startswith("time,")
    process.stdout.close()
    assert process.stderr is not None
    said = process.stderr.read()
    assert process.wait(100) == FAILED
    assert "Traceback" not in said and "Broken" not in said and "bug" not in said


def test_a_full_disk_leaves_the_older_result() -> None:
    Path("x.csv").write_text(OLD)
    process = start("simulate", "pendulum.lag", "-o", "x.csv", "--interval", "1e-5",
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (1_000_000, 1_000_000)))
    code, said = finish(process)
    assert code == FAILED and "'x.csv': File too large" in said
    assert Path("x.csv").read_text() == OLD
    assert not list(Path().glob(".x.csv*"))


def test_a_compiler_that_cannot_write_is_told() -> None:
    process = start("simulate", "pendulum.lag", "--engine", "native",
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_FSIZE, (8_000, 8_000)))
    code, said = finish(process)
    assert code == FAILED and "error: " in said


def test_standard_output_on_a_full_disk() -> None:
    with open("/dev/full", "w") as full:
        command = [sys.executable, "-m", "lagrangia.command.cli", "simulate", "pendulum.lag", "-o", "-", "--quiet"]
        done = subprocess.run(command, stdout=full, stderr=subprocess.PIPE, text=True, check=False)
    assert done.returncode == FAILED
    assert done.stderr.strip() == "error: No space left on device"


def test_what_is_no_file_is_written_to_and_stays_what_it_is(lag: Run) -> None:
    """Such as a device: a file that took the place of /dev/null would break the machine. A named pipe is as good a test."""
    os.mkfifo("pipe")
    read: list[str] = []
    reader = threading.Thread(target=lambda: read.append(Path("pipe").read_text()), daemon=True)
    reader.start()
    assert lag("simulate", "pendulum.lag", "-o", "pipe", "--quiet")[0] == DONE
    reader.join(10)
    assert Path("pipe").is_fifo()
    assert len(read[0].splitlines()) == 502


def test_what_is_open_already_is_gone_on_with(lag: Run) -> None:
    """>> log -o /dev/stdout: a file of its own would take the place of all that the log said before."""
    Path("log").write_text(OLD)
    with open("log", "a") as log:
        command = [sys.executable, "-m", "lagrangia.command.cli", "simulate", "pendulum.lag", "-o", "/dev/stdout", "--quiet"]
        subprocess.run(command, stdout=log, check=True)
    said = Path("log").read_text()
    assert said.startswith(OLD) and len(said.splitlines()) == len(OLD.splitlines()) + 502
    assert lag("simulate", "pendulum.lag", "-o", "/dev/fd/987")[0] == WRONG


@pytest.mark.parametrize("command", ["simulate", "sweep -p m=1,2"])
def test_names_of_results_are_as_long_as_they_may_be(command: str, lag: Run) -> None:
    """In bytes; what is too long is told before the run."""
    name = 80 * "\u4e2d" + ".csv"
    words = [*command.split(), "-o"]
    words.insert(1, "pendulum.lag")
    assert lag(*words, name, "--quiet")[0] == DONE and Path(name).is_file()
    assert lag(*words, f"{name}{'x' * 20}")[0] == WRONG
    assert not list(Path().glob(".*part*"))


def test_a_link_is_followed(lag: Run) -> None:
    Path("real.csv").write_text(OLD)
    Path("link.csv").symlink_to("real.csv")
    assert lag("simulate", "pendulum.lag", "-o", "link.csv", "--quiet")[0] == DONE
    assert Path("link.csv").is_symlink() and len(rows("real.csv")) == 501


def test_little_memory() -> None:
    """Whatever gives way first: an exit code of the run, in words."""
    limit = 400 << 20
    process = start("simulate", "pendulum.lag", "-p", "n=1000",
                    preexec_fn=lambda: resource.setrlimit(resource.RLIMIT_AS, (limit, limit)))
    code, said = finish(process)
    assert code in (DONE, FAILED) and (code == DONE or said.startswith("error:"))
