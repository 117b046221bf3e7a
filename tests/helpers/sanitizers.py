"""C programs of the run time under the sanitizers of gcc and clang."""

import hashlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Mapping, Sequence
from pathlib import Path

import pytest

from lagrangia.base.folders import data_folder
from lagrangia.native.build import find_compiler
from lagrangia.native.prebuilt import sources

needs_sanitizers = pytest.mark.skipif(sys.platform == "win32", reason="needs the sanitizers of gcc or clang")
_OPTIONS = ("-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all")


def run_sanitized(folder: Path, files: Mapping[str, str]) -> None:
    """Builds the files, by their names, with all of the run time, and runs them: exit code 0, and nothing found."""
    compiler, program = find_compiler(), folder / "driver"
    assert compiler is not None
    for name, text in files.items():
        (folder / name).write_text(text)
    objects = map(str, _runtime_objects(compiler.command))
    _compile(compiler.command, folder, ["-o", str(program), *files, *objects, "-lm"])
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr


def _runtime_objects(command: Sequence[str]) -> list[Path]:
    """Those of the run time; the first to ask builds them, for all tests and processes of this run."""
    base = Path(os.environ["LAGRANGIA_CACHE"]).parent  # a folder of this run's own: conftest.own_cache
    files = sorted(data_folder("runtime").rglob("*.[ch]"))
    kept = base / f"sanitized-{hashlib.sha256(b''.join(file.read_bytes() for file in files)).hexdigest()[:16]}"
    if not kept.exists():
        made = Path(tempfile.mkdtemp(dir=base))
        _compile(command, made, ["-c", *map(str, sources(data_folder("runtime")))])
        try:
            made.rename(kept)
        except OSError:  # another process was faster
            assert kept.exists()
    return sorted(kept.glob("*.o"))


def _compile(command: Sequence[str], folder: Path, arguments: Sequence[str]) -> None:
    options = [*_OPTIONS, f"-I{data_folder('runtime')}"]
    if subprocess.run([*command, *options, *arguments], cwd=folder, capture_output=True, check=False).returncode != 0:
        pytest.skip("this compiler has no sanitizers")
