"""Runs an FMU in a process of its own (worker.py): what crashes there is told here, with the rows that were computed.

What it prints is read and all but its end forgotten; processes that it starts end with it. Where a time is allowed, memory and
the size of files have limits, too.
"""

import contextlib
import json
import os
import signal
import stat
import subprocess
import threading
import time
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import asdict, field
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.base.own_python import own_command, own_environment
from lagrangia.base.records import dataclass
from lagrangia.base.spelling import plain_text

KINDS = {"me": "ModelExchange", "cs": "CoSimulation"}
SPOKEN = {"me": "Model Exchange", "cs": "Co-Simulation"}
_MOST_LOG = 20_000  # bytes
_MOST_FILE = 1 << 30  # bytes
_MOST_TOLD = 1 << 27  # bytes of names and of how it ended
_MOST_MESSAGE, _MOST_FAULTS = 2000, 100  # characters of each
_MEMORY = (2 << 30, 8 << 30)  # bytes: half of the machine's, within these
_PATIENCE = 5  # seconds: of processor time beyond the time that is allowed; for the end of the log
_LINES = 6  # of the log, in a message
_CONFINED = "(what it writes outside the folders of its run is refused here, by Landlock: it needs some other program if it must)"
ENDED = "the FMU ended the process that ran it"
_RUN = "LAGRANGIA_FMU_RUN"  # in the environment of all processes of a run: the name of its folder
_TOLD = {"message": str, "seconds": float, "steps": int, "evaluations": int, "events": int, "is_asked_for": bool, "warns": bool,
         "is_confined": bool}
_PAUSE, _MOST_LOOKS = 0.02, 100  # seconds, for processes to end, and how often


@dataclass(frozen=True)
class Inputs:
    """A table, linear between rows; a time that stands twice is a jump."""

    names: Sequence[str] = ()
    times: Sequence[float] = (0.0,)
    rows: Sequence[Sequence[float]] = ((),)


@dataclass(frozen=True)
class Job:
    """`fmu` is the folder of the unpacked FMU, `kind` "me" or "cs"; rows are wanted at `times`, whose first is the start."""

    fmu: str
    kind: str
    times: Sequence[float]
    stop: float
    tolerance: float
    names: Sequence[str] = ()
    values: Mapping[str, Any] = field(default_factory=dict)
    inputs: Inputs = field(default_factory=Inputs)
    probe: bool = False
    derivatives: bool = False  # a look at directional derivatives is worth while


@dataclass(frozen=True)
class Outcome:
    """`rows` are flat, of time and `columns`; `message` says what ended the run early, and is empty when all is well."""

    columns: tuple[str, ...]
    rows: "array[float]"
    message: str
    log: str
    faults: tuple[str, ...] = ()
    time: float = 0.0
    seconds: float = 0.0
    steps: int = 0
    evaluations: int = 0
    events: int = 0
    interrupted: bool = False
    is_asked_for: bool = False  # by the FMU, in the way that the standard has for it
    is_given_up: bool = False  # after the time that was allowed
    warns: bool = False  # the last step was answered by a warning
    is_confined: bool = False  # the system kept it from writing elsewhere

    @property
    def width(self) -> int:
        """Numbers a row: the time and the columns."""
        return 1 + len(self.columns)

    @property
    def said(self) -> list[str]:
        """What the FMU said last, line by line."""
        return [plain_text(line[:300]) for line in self.log.splitlines() if line.strip()][-_LINES:]

    @property
    def explanation(self) -> str:
        """The message, what the FMU said last, and what it may not do."""
        kept = [_CONFINED] if self.is_confined and not self.is_given_up else []
        return "\n".join([self.message, *(f"  {line}" for line in (*self.said, *kept))]) if self.message else ""


def require_fmpy() -> None:
    """Raises LagError L0720."""
    if find_spec("fmpy") is None:
        fail("L0720", "FMPy, which runs FMUs, is not installed", None, 'pip install "lagrangia[fmu]"')


def run_job(job: Job, seconds: float | None = None) -> Outcome:
    """`seconds`: after so many the run is given up, and there are limits to what it may take."""
    with TemporaryDirectory(prefix="lagrangia-run-", ignore_cleanup_errors=True) as name:
        folder = Path(name)
        told = asdict(job) | {"kind": KINDS[job.kind], "limits": {} if seconds is None else _limits(seconds)}
        (folder / "job.json").write_text(json.dumps(told), encoding="utf-8")
        log, ended = _wait(folder, seconds)
        return _collect(folder, job, log, ended)


def _limits(seconds: float) -> dict[str, int]:
    """By the names that the module `resource` has for them."""
    least, most = _MEMORY
    try:
        memory = os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") // 2
    except (AttributeError, OSError, ValueError):
        memory = least
    return {"RLIMIT_AS": min(max(memory, least), most), "RLIMIT_FSIZE": _MOST_FILE, "RLIMIT_CPU": int(seconds) + _PATIENCE,
            "RLIMIT_CORE": 0}


class _Tail(threading.Thread):
    """Reads all of a stream and keeps its end."""

    def __init__(self, stream: Any) -> None:
        super().__init__(daemon=True)
        self.stream, self.kept = stream, b""
        self.start()

    def run(self) -> None:
        while block := self.stream.read1(1 << 16):
            self.kept = (self.kept + block)[-_MOST_LOG:]


def _wait(folder: Path, seconds: float | None) -> tuple[bytes, dict[str, Any]]:
    """The end of what was printed, and what the worker itself cannot tell of its end."""
    environment = own_environment() | {"PYTHONIOENCODING": "utf-8", "OPENBLAS_NUM_THREADS": "1", _RUN: folder.name}
    command = [*own_command("lagrangia.fmu.worker"), str(folder)]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, cwd=folder, env=environment,
                               start_new_session=True)
    tail = _Tail(process.stdout)
    ended: dict[str, Any] = {}
    try:
        code = process.wait(seconds)
        ended = {} if code == 0 else {"message": f"the FMU has crashed ({_spoken(code)})"}
    except subprocess.TimeoutExpired:
        ended = {"message": f"it was given up after {seconds:g} s", "is_given_up": True}
    except KeyboardInterrupt:
        ended = {"interrupted": True}
    finally:
        _end(process, folder.name)
    tail.join(_PATIENCE)
    return tail.kept, ended


def _end(process: "subprocess.Popen[bytes]", run: str) -> None:
    """With all that it has started: as watched.py does it, where that does not the group, and those that have left it, but not
    forgotten which run they are of."""
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        process.terminate()
        process.wait(_PATIENCE)
    with contextlib.suppress(OSError):
        if hasattr(os, "killpg"):
            os.killpg(process.pid, signal.SIGKILL)
        else:
            process.kill()
    process.wait()
    for _ in range(_MOST_LOOKS):
        if not (others := _processes_of(run)):
            break
        for other in others:
            with contextlib.suppress(OSError):
                os.kill(other, signal.SIGKILL)
        time.sleep(_PAUSE)


def _processes_of(run: str) -> list[int]:
    """Those that live and have its name in their environment, where the system tells."""
    told, found = f"{_RUN}={run}\0".encode(), []
    for file in Path("/proc").glob("[0-9]*/environ"):
        with contextlib.suppress(OSError):
            if told in file.read_bytes():
                found.append(int(file.parent.name))
    return found


def _spoken(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit code {code}"


def _collect(folder: Path, job: Job, log: bytes, ended: Mapping[str, Any]) -> Outcome:
    """What the worker has written, as far as it is what it writes: the FMU may have changed it."""
    columns = tuple(name for name in _plain(folder / "columns.json", list) if isinstance(name, str))
    rows: array[float] = array("d")
    content = _read(folder / "rows")
    width = 8 * (1 + len(columns))
    rows.frombytes(content[: len(content) // width * width])
    result = _plain(folder / "result.json", dict)
    known = {name: result[name] for name, kind in _TOLD.items() if type(result.get(name)) is kind}
    faults = result.get("faults")
    reached = rows[-1 - len(columns)] if rows else job.times[0]
    told = {"message": "", **known, **ended, "time": reached}
    told["faults"] = tuple(str(fault)[:_MOST_MESSAGE] for fault in faults[:_MOST_FAULTS]) if isinstance(faults, list) else ()
    told["message"] = plain_text(told["message"][:_MOST_MESSAGE])
    return Outcome(columns, rows, log=log.decode(errors="replace"), **told)


def _plain(file: Path, kind: type) -> Any:
    """What a file says in JSON, an empty one of the kind where that is none of it."""
    try:
        found = json.loads(_read(file, _MOST_TOLD) or b"null")
    except (ValueError, RecursionError):
        found = None
    return found if isinstance(found, kind) else kind()


def _read(file: Path, most: int = -1) -> bytes:
    """The begin of a file that is one, and no link, pipe or device; empty where it is not there."""
    try:
        with open(os.open(file, os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | getattr(os, "O_NONBLOCK", 0)), "rb") as stream:
            return stream.read(most) if stat.S_ISREG(os.fstat(stream.fileno()).st_mode) else b""
    except OSError:
        return b""
