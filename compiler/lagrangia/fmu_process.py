"""Runs an FMU in a process of its own (fmu_worker.py): what crashes there is told here, with the rows that were computed."""

import json
import os
import signal
import subprocess
import sys
from array import array
from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, field
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

from lagrangia.diagnostics import fail

KINDS = {"me": "ModelExchange", "cs": "CoSimulation"}
SPOKEN = {"me": "Model Exchange", "cs": "Co-Simulation"}
_MOST_LOG = 20_000  # characters
_LINES = 6  # of the log, in a message


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

    @property
    def width(self) -> int:
        return 1 + len(self.columns)

    @property
    def explanation(self) -> str:
        """The message, and what the FMU said last."""
        said = [line for line in self.log.splitlines() if line.strip()][-_LINES:]
        return "\n".join([self.message, *(f"  {line[:300]}" for line in said)]) if self.message else ""


def require_fmpy() -> None:
    """Raises LagError L0720."""
    if find_spec("fmpy") is None:
        fail("L0720", "FMPy, which runs FMUs, is not installed", None, 'pip install "lagrangia[fmu]"')


def run_job(job: Job, seconds: float | None = None) -> Outcome:
    """`seconds`: after so many the run is given up."""
    with TemporaryDirectory(prefix="lagrangia-run-") as name:
        folder = Path(name)
        (folder / "job.json").write_text(json.dumps(asdict(job) | {"kind": KINDS[job.kind]}), encoding="utf-8")
        with (folder / "log").open("wb") as log:
            ended = _wait(folder, log, seconds)
        return _collect(folder, job, ended)


def _wait(folder: Path, log: Any, seconds: float | None) -> dict[str, Any]:
    """What the worker itself cannot tell of its end."""
    home = str(Path(__file__).resolve().parent.parent)
    paths = [home, *filter(None, [os.environ.get("PYTHONPATH")])]
    environment = os.environ | {"PYTHONPATH": os.pathsep.join(paths), "PYTHONIOENCODING": "utf-8"}
    command = [sys.executable, "-m", "lagrangia.fmu_worker", str(folder)]
    process = subprocess.Popen(command, stdout=log, stderr=subprocess.STDOUT, cwd=folder, env=environment)
    try:
        code = process.wait(seconds)
    except subprocess.TimeoutExpired:
        _end(process)
        return {"message": f"it was given up after {seconds:g} s", "is_given_up": True}
    except KeyboardInterrupt:
        _end(process)
        return {"interrupted": True}
    return {} if code == 0 else {"message": f"the FMU has crashed ({_spoken(code)})"}


def _end(process: "subprocess.Popen[bytes]") -> None:
    process.kill()
    process.wait()


def _spoken(code: int) -> str:
    try:
        return signal.Signals(-code).name
    except ValueError:
        return f"exit code {code}"


def _collect(folder: Path, job: Job, ended: Mapping[str, Any]) -> Outcome:
    def read(name: str) -> bytes:
        file = folder / name
        return file.read_bytes() if file.exists() else b""

    columns = tuple(json.loads(read("columns.json") or b"[]"))
    rows: array[float] = array("d")
    content = read("rows")
    width = 8 * (1 + len(columns))
    rows.frombytes(content[: len(content) // width * width])
    result = json.loads(read("result.json") or b"{}")
    log = read("log").decode(errors="replace")[-_MOST_LOG:]
    reached = rows[-1 - len(columns)] if rows else job.times[0]
    told = {"message": "", **result, **ended, "faults": tuple(result.get("faults", ())), "time": reached}
    return Outcome(columns, rows, log=log, **told)
