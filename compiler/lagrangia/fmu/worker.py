"""The process in which an FMU runs: `python -m lagrangia.fmu.worker FOLDER`.

FOLDER/job.json says what to do (process.py writes it). Rows of time and values go to FOLDER/rows as doubles while they are
computed, so that they are kept whatever happens; FOLDER/columns.json names them, FOLDER/result.json tells how it ended.
"""

import json
import sys
import time
from array import array
from collections.abc import Mapping
from dataclasses import asdict
from pathlib import Path
from typing import Any

from lagrangia.fmu.confined import confine
from lagrangia.fmu.importer import AskedToEnd, FmuError, Importer, Table
from lagrangia.fmu.integrate import Count, cosimulate, exchange
from lagrangia.fmu.probe import probe_derivatives, probe_reset, probe_saved, probe_states
from lagrangia.fmu.process import ENDED
from lagrangia.fmu.watched import run_watched


def main(folder: Path) -> int:
    """Does the job in a folder, in a process below this one, and writes how it ended; returns the exit code."""
    job = json.loads((folder / "job.json").read_text(encoding="utf-8"))
    return run_watched(lambda: _run(job, folder))


def _run(job: dict[str, Any], folder: Path) -> int:
    _limit(job["limits"])
    result: dict[str, Any] = {"message": ENDED, "faults": [], "is_confined": confine([folder, Path(job["fmu"])]) > 0}
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")  # known where it crashes, or ends all by exit(0)
    result["message"] = ""
    begin = time.perf_counter()
    count = Count()
    try:
        _work(job, folder, result, count)
    except AskedToEnd as error:
        result |= {"message": str(error), "is_asked_for": True}
    except Exception as error:  # whatever FMPy and the FMU make of it is told in the parent's words
        result["message"] = _message(error)
    result |= {"seconds": time.perf_counter() - begin, **asdict(count)}
    (folder / "result.json").write_text(json.dumps(result), encoding="utf-8")
    return 0


def _limit(limits: Mapping[str, int]) -> None:
    """Before anything of the FMU is loaded; no limit of ours raises one that is there."""
    try:
        import resource
    except ImportError:  # Windows
        return
    for name, most in limits.items():
        kind = getattr(resource, name)
        hard = resource.getrlimit(kind)[1]
        least = most if hard == resource.RLIM_INFINITY else min(most, hard)
        resource.setrlimit(kind, (least, least))


def _message(error: Exception) -> str:
    from fmpy.fmi1 import FMICallException

    if isinstance(error, FMICallException):
        status = {1: "warning", 2: "discard", 3: "error", 4: "fatal"}.get(error.status, str(error.status))
        return f"{error.function} answered '{status}'"
    return str(error) if isinstance(error, FmuError) else f"{type(error).__name__}: {error}"


def _work(job: dict[str, Any], folder: Path, result: dict[str, Any], count: Count) -> None:
    importer = Importer(job["fmu"], job["kind"])
    inputs = job["inputs"]
    table = Table(importer, inputs["names"], inputs["times"], inputs["rows"])
    start, stop, tolerance = job["times"][0], job["stop"], job["tolerance"]

    def begin() -> None:
        importer.initialise(start, stop, tolerance, job["values"], lambda: table.apply(start, is_after=True))

    begin()
    if job["probe"]:
        result["faults"] = _probe(importer, begin, start, stop, job["derivatives"])
        return
    read = importer.reader(job["names"])
    (folder / "columns.json").write_text(json.dumps(importer.columns(job["names"])), encoding="utf-8")
    with (folder / "rows").open("wb", buffering=0) as stream:

        def write(t: float) -> None:
            stream.write(array("d", [t, *read()]).tobytes())

        if job["kind"] == "ModelExchange":
            exchange(importer, table, job["times"], stop, tolerance, write, count)
        else:
            cosimulate(importer, table, job["times"], write, count)
        result["warns"] = importer.warns
    importer.fmu.terminate()
    importer.fmu.freeInstance()


def _probe(importer: Importer, begin: Any, start: float, stop: float, derivatives: bool) -> list[str]:
    computed = [v for v in importer.description.modelVariables if v.causality in ("local", "output")]
    numbers = [v.name for v in computed if v.type in ("Real", "Float64") and v.variability == "continuous"]
    read = importer.reader(numbers)
    first = read()
    if importer.kind == "ModelExchange":
        faults = probe_states(importer) + (probe_derivatives(importer) if derivatives else [])
        shifted = [x + 0.01 * max(1.0, abs(x)) for x in importer.states()]
        faults += probe_reset(importer, first, begin, read, lambda: importer.set_states(shifted))
        return faults + probe_saved(importer, read, lambda: importer.set_states(shifted))
    h = (stop - start) / 1000
    reached = [start]

    def go_on() -> None:
        reached[0] = importer.step(start, h)

    faults = probe_reset(importer, first, begin, read, go_on)
    return faults + probe_saved(importer, read, go_on)


if __name__ == "__main__":
    sys.exit(main(Path(sys.argv[1])))
