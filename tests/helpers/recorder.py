"""What all scenes give, as hashes in a file: proof that a refactoring changes nothing.

    python tests/helpers/recorder.py record before.json [NAME ...]
    python tests/helpers/recorder.py compare before.json after.json

Recorded are, of each model in models/examples and tests/cases: the rows at two tolerances, column by column, and what they cost;
the files of its FMUs; of each example what commands print; of each wrong model in tests/errors what is said about it. With names
only files of these names are looked at. What differs is told by its path, and makes `compare` end with 1.
"""

import hashlib
import io
import json
import os
import sys
import tempfile
import time
import zipfile
from collections.abc import Callable, Iterable, Iterator
from contextlib import redirect_stderr, redirect_stdout
from pathlib import Path
from typing import Any

import numpy as np

import lagrangia as lag
from lagrangia.command.cli import main as lag_command
from lagrangia.compile.pipeline import read_files

ROOT = Path(__file__).resolve().parents[2]
TOLERANCES = (1e-5, 1e-9)
LONGEST = 10.0  # seconds of motion
ROWS = 100
LARGE = 30  # coordinates: what is not tried at more
COMMANDS = (
    ("check",), ("equations",), ("equations", "--form", "worked", "--format", "latex"), ("equations", "--form", "energies"),
    ("equations", "--form", "linear", "--format", "html"), ("modes",), ("equilibrium",), ("explain",),
    *(("export", "--to", target, "-o", "-") for target in ("modelica", "python", "sympy")), ("simulate", "--dump", "c"),
)
Record = dict[str, Any]


def hashed(content: bytes) -> str:
    """Short: 48 bits."""
    return hashlib.sha256(content).hexdigest()[:12]


# ---------------------------------------------------------------- what is recorded


def models_of(file: Path) -> list[str]:
    """Models of a scene that are no parts of others."""
    classes = read_files(file)[0].classes
    parts = {element.type_name for item in classes for element in item.elements}
    return [item.name for item in classes if item.kind == "model" and not item.is_partial and item.name not in parts]


def attempt(what: Callable[[], Any]) -> Any:
    """What is found, or the words in which it is refused."""
    try:
        return what()
    except (lag.LagError, lag.RunError) as error:
        return f"{type(error).__name__}: {error}"


def rows(model: lag.Model, tolerance: float) -> Record:
    """Each column's bytes, the energies', and evaluations and steps."""
    scene = model.scene
    times = np.linspace(scene.start, min(scene.stop, scene.start + LONGEST), ROWS + 1)
    run = model.simulate(start=scene.start, stop=float(times[-1]), at=list(times), tolerance=tolerance)
    width = len(run.names)
    columns = {name: hashed(run.rows[:, k].tobytes()) for k, name in enumerate(run.names)}
    counts = {name: getattr(run.statistics, name) for name in ("steps", "rejected", "rhs_evaluations", "events", "projections")}
    return columns | {"energies": hashed(run.rows[:, width:].tobytes()), "counts": counts, "warnings": run.warnings}


def fmu(model: lag.Model, version: str) -> Record:
    """Each file of the FMU, without a binary; those of the run time as one."""
    with tempfile.TemporaryDirectory() as folder:
        (path,) = model.export_fmu(Path(folder) / "it.fmu", fmi=version, platforms="")
        with zipfile.ZipFile(path) as archive:
            files = {name: archive.read(name) for name in sorted(archive.namelist())}
    runtime = [name for name in files if name.startswith("sources/") and "scene" not in name and name.endswith((".c", ".h"))]
    together = b"".join(name.encode() + files.pop(name) for name in runtime)
    return {name: hashed(content) for name, content in files.items()} | {"run time": f"{len(runtime)} files {hashed(together)}"}


def scene_record(file: Path, name: str) -> Record:
    """Of one model: on the tape, for which nothing is compiled."""
    model = lag.load(file, model=name)
    model.native = False
    found: Record = {f"rows at {tolerance:g}": attempt(lambda tolerance=tolerance: rows(model, tolerance))
                     for tolerance in TOLERANCES}
    if model.scene.n <= LARGE:
        found |= {f"FMI {version}": attempt(lambda version=version: fmu(model, version)) for version in "23"}
    return found


def said(arguments: Iterable[str]) -> Record:
    """Exit code and both streams of a command."""
    out, err = (io.TextIOWrapper(io.BytesIO(), encoding="utf-8") for _ in range(2))
    with redirect_stdout(out), redirect_stderr(err):
        code = lag_command(list(arguments))
    texts = []
    for stream in (out, err):
        stream.flush()
        texts.append(stream.buffer.getvalue())  # type: ignore[attr-defined]
    begins = (texts[0] or texts[1])[:80].decode(errors="replace")
    return {"code": code, "out": hashed(texts[0]), "err": hashed(texts[1]), "begins": begins}


# ---------------------------------------------------------------- records


def everything(wanted: list[str]) -> Iterator[tuple[str, Record]]:
    """A record for each model, example and wrong model, by its path."""

    def files(folder: str) -> list[Path]:
        return [file for file in sorted(Path(folder).glob("*.lag")) if not wanted or file.stem in wanted]

    for file in (*files("models/examples"), *files("tests/cases")):
        for name in models_of(file):
            yield f"{file}: {name}", attempt(lambda file=file, name=name: scene_record(file, name))
    for file in files("models/examples"):
        yield f"{file}: commands", {" ".join(words): said([words[0], str(file), *words[1:]]) for words in COMMANDS}
    for file in files("tests/errors"):
        yield str(file), said(["check", str(file)])


def record(target: Path, wanted: list[str]) -> None:
    """Writes all that is found; the cache stays that of the environment."""
    os.environ["SOURCE_DATE_EPOCH"] = "1700000000"
    begun = time.monotonic()
    found = {}
    for name, what in everything(wanted):
        found[name] = what
        print(f"{time.monotonic() - begun:6.1f} s  {name}", file=sys.stderr)
    target.write_text(json.dumps(found, indent=1, ensure_ascii=False), encoding="utf-8")


def differences(a: Any, b: Any, path: str = "") -> Iterator[str]:
    """Paths at which two records are not the same."""
    if isinstance(a, dict) and isinstance(b, dict):
        for name in dict.fromkeys((*a, *b)):
            yield from differences(a.get(name), b.get(name), f"{path} / {name}" if path else name)
    elif a != b:
        yield f"{path}: {a} and {b}" if len(f"{a}{b}") < 200 else path


def compare(a: Path, b: Path) -> int:
    """The number of differences that are told, at most 1 as an exit code."""
    first, second = (json.loads(file.read_text(encoding="utf-8")) for file in (a, b))
    found = list(differences(first, second))
    print(*found, f"{len(found)} differences among {sum(1 for _ in leaves(first))} hashes, numbers and texts", sep="\n")
    return min(1, len(found))


def leaves(record: Any) -> Iterator[Any]:
    """All that is compared."""
    for item in record.values() if isinstance(record, dict) else ():
        yield from leaves(item) if isinstance(item, dict) else [item]


if __name__ == "__main__":
    what, *given = sys.argv[1:]
    files = [Path(name).resolve() for name in given[:2]]
    os.chdir(ROOT)
    if what == "compare":
        sys.exit(compare(*files))
    record(files[0], given[1:])
