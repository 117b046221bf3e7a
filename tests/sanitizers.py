"""C programs of the run time under the sanitizers of gcc and clang."""

import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

import pytest

from lagrangia.folders import data_folder
from lagrangia.native import find_compiler

needs_sanitizers = pytest.mark.skipif(sys.platform == "win32", reason="needs the sanitizers of gcc or clang")


def run_sanitized(folder: Path, files: Mapping[str, str]) -> None:
    """Builds the files, by their names, with all of the run time, and runs them: exit code 0, and nothing found."""
    compiler, runtime, program = find_compiler(), data_folder("runtime"), folder / "driver"
    assert compiler is not None
    for name, text in files.items():
        (folder / name).write_text(text)
    sources = [*(str(folder / name) for name in files), *map(str, sorted(runtime.glob("*.c")))]
    options = ["-std=c99", "-g", "-fsanitize=address,undefined", "-fno-sanitize-recover=all", f"-I{runtime}", "-o", str(program)]
    if subprocess.run([*compiler.command, *options, *sources, "-lm"], capture_output=True, check=False).returncode != 0:
        pytest.skip("this compiler has no sanitizers")
    done = subprocess.run([program], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
