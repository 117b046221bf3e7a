"""Runs random models and random command lines, each in a process of its own, and says what no command may do.

As a program: `python tests/helpers/fuzz_commands.py FIRST COUNT` prints the faults of these seeds, each kind once; with `valid`
before them, of models that are right.
"""

import contextlib
import io
import json
import os
import random
import re
import resource
import signal
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from fuzz_models import random_model
from fuzz_valid import valid_model

WALL, CPU = 60.0, 20  # seconds that one command may take
_LEAKS = re.compile(r"Traceback|^bug:|RuntimeWarning|UserWarning|DeprecationWarning|site-packages|File \"|casadi\."
                    r"|numpy|\.py:\d|Assertion(?!Level)", re.M)
FILES = ("scene.lag", "scene.lag", "scene.lag", "scene.lag", "scene.lag", "scene.lag", "folder", "missing.lag", "loop.lag",
    "secret.lag", "fifo.lag",
         "/dev/null", "/dev/zero", "", ".", "scene.lag/x", "x.fmu", "empty.lag", "binary.lag", "table.csv", "\udcff.lag",
             "a\nb.lag", "socket.lag")
COMMANDS = ("check", "simulate", "simulate", "simulate", "explain", "equations", "modes", "equilibrium", "linearize",
    "response", "export",
            "sweep", "help", "fmu", "bench")
VALUES = ("1", "0", "-1", "nan", "inf", "-inf", "1e308", "1e-310", "1e400", "x", "", "{1,2}", "{", "1[kg]", "1[", "true",
    "99999999999999999999",
          "1,2,3", "1:3:1", "3:1:1", "0:1:0", "linspace(0,1,3)", "normal(1,0)", "uniform(1", "ü", "\x1b[31m", "a,b", "1e9",
              "0x10", "--", "'", "$")
NAMES = ("m", "p", "L", "u", "c1.m", "c1", "c1.phi", "hinge.phi", "der(c1.s)", "world.gravity", "x", "time", "", "[",
    "c1[0]", "'a b'", "n", "ü", "=")
WORDS = {
    "--solver": ("auto", "erk", "erk5", "linear", "implicit", "pirk", "taylor", "casadi:cvodes", "casadi:", "foo", ""),
    "--engine": ("auto", "tape", "native", "x"), "--to": ("fmu", "python", "casadi", "modelica", "sympy", "latex", "c", "",
        "c1.phi"),
    "--form": ("lagrange", "lagrangian", "elastic", "energies", "matrix", "first-order", "linear", "worked", "x"),
    "--format": ("text", "markdown", "latex", "html", "sympy", "x"), "--about": ("start", "equilibrium", "x", "c1.phi=1", "="),
    "--dump": ("syntax", "flat", "graph", "kinematics", "energies", "motion", "needs", "c", "x"), "--model": ("M", "x", "",
        "Bar"),
    "--range": ("1:10", "0:1", "10:1", "a:b", "1", ":"), "--sampling": ("lhs", "random", "x"), "--runs": ("table.csv",
        "folder", "missing.csv", "fifo.csv"),
    "--outputs": ("c1.phi", "max(time)", "energy", "at(1, c1.s)", "max(", "x", "", "time", "first_time(c1.s > 0)",
        "mean(energy)"),
    "-o": ("out", "-", "folder", "/dev/full", "/dev/null", "scene.lag", "missing/x", "", "out.csv", "out.json", "out.mat",
        "out.npz", "out.parquet", "out.xyz"),
    "--plot": ("x.png", "x.svg", "x.xyz", "folder", "", "/dev/full"), "--names": ("c1.phi=a", "x=y", "=", "c1.phi=\\x",
        "c1.phi=def"),
    "--kind": ("me", "cs", "x", ""), "--fmi": ("2", "3", "both", "1"), "--platforms": ("host", "x", ""),
        "--allow": ("L0224", "x", ""),
    "--info": ("author=x", "x",
        "version=\"\"\""), "--from": ("u", "c1", "", "x"), "--tolerances": ("1e-3", "x", ""), "--solvers": ("erk", "x", ""),
}
NUMBERS = ("--stop", "--start", "--tolerance", "--interval", "--at", "--max-step", "--max-steps", "--jobs", "--samples",
    "--seed", "--starts",
           "--points", "--time", "--repeat", "--seconds-per-run")
PAIRS = ("-p", "--initial", "-u")
FLAGS = ("--quiet", "--stats", "--strict", "--reactions", "--json", "--force", "--numbers", "--together", "--dry-run",
    "--restart",
         "--mass-normalised", "--no-sources", "--help")
OPTIONS = {
    "check": (), "help": (), "fmu": (),
    "simulate": ("--model", "--start", "--stop", "--tolerance", "--interval", "--at", *PAIRS, "--outputs", "--reactions",
        "-o", "--plot", "--solver",
                 "--engine", "--max-step", "--max-steps", "--kind", "--stats", "--quiet", "--dump"),
    "explain": ("--model", "-p", "--json"), "bench": ("--stop", "--points", "--tolerances", "--solvers", "--repeat", "-o"),
    "equations": ("--model", "--form", "--form", "--format", "--names", "--numbers", "--about", "-p", "--force", "-o"),
    "modes": (*PAIRS, "--time", "--about", "--mass-normalised", "-o", "--plot"), "equilibrium": (*PAIRS, "--time",
        "--starts", "-o"),
    "linearize": (*PAIRS, "--time", "--about", "--from", "--to", "-o"),
    "response": (*PAIRS, "--time", "--about", "--from", "--to", "--range", "--points", "--at", "-o", "--plot"),
    "export": ("--model", "-p", "--names", "--force", "--fmi", "--kind", "--platforms", "--no-sources", "--outputs",
        "--info", "-o"),
    "sweep": (*PAIRS, "-p", "--runs", "--together", "--samples", "--sampling", "--seed", "--outputs", "--start", "--stop",
        "--tolerance", "--interval",
              "--solver", "--engine", "--max-step", "--max-steps", "--seconds-per-run", "--jobs", "-o", "--restart",
                  "--dry-run", "--quiet"),
}
ORDINARY = (("check", "scene.lag"), ("simulate", "scene.lag", "--stop", "0.3", "--interval", "0.1", "--max-steps", "20000",
    "--engine", "tape", "-o", "out.csv"),
            ("explain", "scene.lag"), ("equations", "scene.lag"), ("modes", "scene.lag"), ("equilibrium", "scene.lag",
                "--starts", "4"),
            ("linearize", "scene.lag"), ("equations", "scene.lag", "--form", "worked"), ("equations", "scene.lag", "--form",
                "linear"),
            ("export", "scene.lag", "--to", "python", "-o", "-"), ("export", "scene.lag", "--to", "modelica", "-o", "-"),
            ("export", "scene.lag", "--to", "sympy", "-o", "-"), ("simulate", "scene.lag", "--dump", "flat"),
            ("simulate", "scene.lag", "--dump", "c"), ("sweep", "scene.lag", "--samples", "2", "--stop", "0.1", "--jobs",
                "1", "-o", "-"))


@dataclass(frozen=True)
class Case:
    text: str
    command: tuple[str, ...]
    memory: int = 0  # bytes, of address space beyond what is in use; 0: no limit


@dataclass(frozen=True)
class Outcome:
    code: int
    out: str
    err: str
    seconds: float
    rows: str = ""


def random_case(seed: int) -> Case:
    """Four of five: a model under an ordinary command; else a random command line on a scene that is right, or not."""
    chance = random.Random(-seed - 1)
    if chance.random() < 0.8:
        return Case(random_model(seed), chance.choice(ORDINARY[:2]) if chance.random() < 0.5 else chance.choice(ORDINARY))
    text = SCENE if chance.random() < 0.7 else random_model(seed)
    return Case(text, _command(chance), 300_000_000 if chance.random() < 0.05 else 0)


def valid_case(seed: int) -> Case:
    """A model that is right, mostly to be simulated."""
    chance = random.Random(-seed)
    run = ("simulate", "scene.lag", "--interval", "0.1", "--engine", "tape", "--max-steps", "100000", "-o", "out.csv")
    return Case(valid_model(seed), run if chance.random() < 0.7 else chance.choice(ORDINARY))


SCENE = ("model M\n  parameter Mass m = 1; parameter Length L = 1; parameter Integer n = 1; input Torque u(start = 0);\n"
         "  Revolute c1(a = world, phi(start = 1)); Bar bar(m = m, L = L, a = c1.b); "
         "AppliedTorque d(on = c1.b, torque = u);\nend M;\n")


def _command(chance: random.Random) -> tuple[str, ...]:
    name = chance.choice(COMMANDS)
    if name == "help":
        return (name, chance.choice(("language", "library", "solver", "x", "", "sweep")))
    words = [name, *(["check"] if name == "fmu" else []), chance.choice(FILES)]
    if name in ("simulate", "sweep"):
        words += ["--stop", "0.2"]
    if name == "bench":
        words += ["--stop", "0.1", "--repeat", "1", "--solvers", "erk", "--tolerances", "1e-3"]
    if name == "export":
        words += ["--to", chance.choice(WORDS["--to"])]
    known = OPTIONS[name] if chance.random() < 0.9 else (*WORDS, *NUMBERS, *PAIRS, *FLAGS)
    for option in chance.choices(known, k=chance.choice((0, 1, 1, 2, 3))) if known else ():
        words.append(option)
        if option in PAIRS:
            words.append(chance.choice((f"{chance.choice(NAMES)}={chance.choice(VALUES)}", chance.choice(VALUES),
                "table.csv", "fifo.csv", "folder.csv")))
        elif option in NUMBERS or (option not in FLAGS and chance.random() < 0.2):
            words.append(chance.choice(VALUES[:24] if chance.random() < 0.5 else ("0.1", "1", "2", "3")))
        elif option not in FLAGS:
            words.append(chance.choice(WORDS[option]))
    return tuple(words)


# ---------------------------------------------------------------- running


def furnish(folder: Path, text: str) -> None:
    """The files that a command may be given."""
    (folder / "scene.lag").write_bytes(text.encode("utf-8", "surrogateescape"))
    (folder / "folder").mkdir()
    (folder / "folder.csv").mkdir()
    (folder / "loop.lag").symlink_to("loop.lag")
    (folder / "loop.svg").symlink_to("loop.svg")
    (folder / "secret.lag").write_text(SCENE)
    (folder / "secret.lag").chmod(0)
    os.mkfifo(folder / "fifo.lag")
    os.mkfifo(folder / "fifo.csv")
    (folder / "x.fmu").write_bytes(b"PK\x03\x04 no archive")
    (folder / "empty.lag").write_bytes(b"")
    (folder / "binary.lag").write_bytes(bytes(range(256)))
    (folder / "table.csv").write_text("time,u,m\n0,0,1\n1,1,2\n")


def run(case: Case) -> Outcome:
    """The command in a fork of this process, in a folder of its own."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        furnish(folder, case.text)
        began = time.monotonic()
        sys.stdout.flush()
        sys.stderr.flush()
        child = os.fork()
        if child == 0:
            _be_the_command(case, folder)
        code = _wait(child, began + WALL)
        rows = folder / "out.csv"
        kept = rows.read_text(errors="replace") if rows.is_file() and rows.stat().st_size < 1e7 else ""
        said = [(folder / part).read_bytes()[:300_000].decode("utf-8", "replace") for part in (".out", ".err")]
        return Outcome(code, said[0], said[1], time.monotonic() - began, kept)


def _be_the_command(case: Case, folder: Path) -> None:
    """Never returns."""
    os.chdir(folder)
    os.setsid()
    for number, part in ((0, os.devnull), (1, ".out"), (2, ".err")):
        os.dup2(os.open(part, os.O_RDWR | os.O_CREAT, 0o600), number)
    sys.stdin, sys.stdout, sys.stderr = open(0), open(1, "w", encoding="utf-8"), open(2, "w", encoding="utf-8")  # noqa: SIM115
    resource.setrlimit(resource.RLIMIT_CPU, (CPU, CPU + 1))
    resource.setrlimit(resource.RLIMIT_FSIZE, (200_000_000, 200_000_000))
    resource.setrlimit(resource.RLIMIT_CORE, (0, 0))
    pages = Path("/proc/self/statm")
    used = int(pages.read_text().split()[0]) * resource.getpagesize() if pages.exists() else 0
    limit = used + (case.memory or 3_000_000_000)
    resource.setrlimit(resource.RLIMIT_AS, (limit, limit))
    code = 99
    try:
        from lagrangia.command.cli import main

        code = main(case.command)
    except SystemExit as stop:
        code = int(stop.code or 0)
    except BaseException:
        import traceback

        traceback.print_exc()
    for stream in (sys.stdout, sys.stderr):
        with contextlib.suppress(OSError, ValueError):
            stream.flush()
    os._exit(code)


def _wait(child: int, deadline: float) -> int:
    while time.monotonic() < deadline:
        done, status = os.waitpid(child, os.WNOHANG)
        if done:
            return os.waitstatus_to_exitcode(status)
        time.sleep(0.002)
    os.kill(child, signal.SIGKILL)
    os.waitpid(child, 0)
    return -signal.SIGALRM


# ---------------------------------------------------------------- judging


def faults(case: Case, outcome: Outcome) -> list[str]:
    """What this command must not have done, each as a kind and what shows it."""
    found = []
    if outcome.code in (-signal.SIGXCPU, -signal.SIGKILL, -signal.SIGALRM):
        found.append(f"hang: {outcome.seconds:.0f} s")
    elif outcome.code not in (0, 1, 2):
        found.append(f"exit code {outcome.code}")
    if leak := _LEAKS.search(outcome.err):
        start = outcome.err.rfind("\n", 0, leak.start()) + 1
        found.append(f"leak: {outcome.err[start:start + 300].strip()}")
    if outcome.code == 0 and re.search(r"^error", outcome.err, re.M):
        found.append("an error, and exit code 0")
    if outcome.code in (1, 2) and not re.search(r"error|usage|warning\[|nothing|found|invalid|✗|fail",
        outcome.err + outcome.out):
        found.append("fails without a word")
    if case.command[0] == "check" and case.command[1] == "scene.lag":
        found += [f"no place: {first(line)}" for line in _without_place(outcome.err)]
    found += [f"in the library: {first(block)}" for block in _blocks(outcome.err)
              if block.startswith("error") and re.search(r"--> .*library", block) and "scene.lag" not in block]
    if outcome.code == 0 and re.search(r"\b(nan|inf)\b", outcome.rows):
        found.append("rows that are no numbers, and exit code 0")
    return found


def first(block: str) -> str:
    return block.partition("\n")[0]


def _blocks(text: str) -> list[str]:
    return re.split(r"\n(?=(?:error|warning|note|bug)\b)", text)


def _without_place(text: str) -> list[str]:
    return [block for block in _blocks(text) if re.match(r"error\[L0[1-6]", block) and "-->" not in block]


def kind(fault: str) -> str:
    """The same for faults of one kind: numbers and names do not count."""
    return re.sub(r"'[^']*'|\"[^\"]*\"|\d+", "_", fault)[:110]


def warm() -> None:
    """What every command would load is loaded once, before the forks."""
    import sympy  # noqa: F401

    import lagrangia.paper.equations  # noqa: F401
    from lagrangia.command.cli import main

    with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()) as said, \
            contextlib.redirect_stderr(said):
        scene = Path(name) / "scene.lag"
        scene.write_text(f"{SCENE}// {time.time_ns()}")
        main(["check", str(scene)])
        main(["check", str(scene) + "missing"])


def fuzz(seeds: Sequence[int], seconds: float = float("inf"), report: bool = False, is_valid: bool = False
         ) -> dict[str, list[tuple[int, str]]]:
    """The faults of these seeds by kind, until the time is over."""
    warm()
    known: dict[str, list[tuple[int, str]]] = {}
    began, count, done = time.monotonic(), 0, 0
    for seed in seeds:
        if time.monotonic() - began > seconds:
            break
        case = valid_case(seed) if is_valid else random_case(seed)
        count += 1
        outcome = run(case)
        done += outcome.code == 0
        if report and sys.argv[1] == "-v":
            print(seed, case.command, outcome.code, round(outcome.seconds, 2), first(outcome.err))
        for fault in faults(case, outcome):
            told = known.setdefault(kind(fault), [])
            told.append((seed, fault))
            if report and len(told) <= 3:
                print(f"{seed}: {' '.join(map(ascii, case.command))}: {fault}", flush=True)
    if report:
        total = sum(map(len, known.values()))
        print(f"{done} done; {count} commands in {time.monotonic() - began:.0f} s, {total} faults of {len(known)} kinds")
    return known


def judged(text: str, *command: str) -> tuple[Outcome, list[str]]:
    """One command on one scene."""
    case = Case(text, command)
    outcome = run(case)
    return outcome, faults(case, outcome)


if __name__ == "__main__":
    first_seed, count = map(int, sys.argv[-2:])
    if sys.argv[1] == "kept":
        warm()
        outcomes = [judged(text, *command) for text, command in json.loads(sys.argv[2])]
        print(json.dumps([(outcome.code, outcome.out + outcome.err, found) for outcome, found in outcomes]))
    fuzz(range(first_seed, first_seed + count), report=True, is_valid=sys.argv[1] == "valid")
