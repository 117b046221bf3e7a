"""C programs of the run time under the sanitizers of gcc and clang."""

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from helpers.one_process import one_process_at_a_time
from lagrangia.base.folders import data_folder
from lagrangia.native.build import find_compiler
from lagrangia.native.prebuilt import joined, sources

needs_sanitizers = pytest.mark.skipif(sys.platform == "win32", reason="needs the sanitizers of gcc or clang")
_OPTIONS = ("-std=c99", "-g1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def run_sanitized(folder: Path, files: Mapping[str, str], others: Sequence[Path] = (), flags: Sequence[str] = ()) -> str:
    """What a program of these files, by their names, of others and of all of the run time prints: exit code 0, nothing found.

    The first to ask compiles the run time, for all tests and processes of this run. `flags` are for the program's own files.
    """
    for name, text in files.items():
        (folder / name).write_text(text)
    compiler, program = find_compiler(), folder / "driver"
    assert compiler is not None
    command, runtime = [*compiler.command, *_OPTIONS], data_folder("runtime")
    objects = _objects([*command, f"-I{runtime}"], sources(runtime), sorted(runtime.rglob("*.h")))
    own = [*files, *map(str, others)]
    _compile([*command, *flags, f"-I{runtime}"], folder, ["-o", str(program), *own, *map(str, objects), "-lm"])
    done = subprocess.run([program], capture_output=True, text=True, check=False, timeout=3600)
    assert done.returncode == 0, done.stderr[-3000:]
    return done.stdout


def _objects(command: Sequence[str], shared: Sequence[Path], headers: Sequence[Path]) -> list[Path]:
    base = Path(os.environ["LAGRANGIA_CACHE"]).parent  # a folder of this run's own: conftest.own_cache
    content = b"".join(file.name.encode() + file.read_bytes() for file in (*shared, *headers))
    kept = base / f"sanitized-{hashlib.sha256(content).hexdigest()[:16]}"
    with one_process_at_a_time(kept.with_suffix(".lock")):
        if not kept.exists():
            made = Path(tempfile.mkdtemp(dir=base))
            _compile(command, made, ["-c", *map(str, joined(shared, made))])
            made.rename(kept)
    return sorted(kept.glob("*.o"))


def _compile(command: Sequence[str], folder: Path, arguments: Sequence[str]) -> None:
    done = subprocess.run([*command, *arguments], cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode != 0:
        probe = [*command, "-x", "c", "-", "-o", str(folder / "probe")]
        empty = "int main(void) { return 0; }"
        if subprocess.run(probe, input=empty, text=True, capture_output=True, check=False).returncode != 0:
            pytest.skip("this compiler has no sanitizers")
        raise AssertionError(done.stderr[-3000:])
