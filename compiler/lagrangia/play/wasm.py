"""The C run time as WebAssembly: built by zig when a page is first written, kept by what it was built from.

The module is a reactor (no main; `_initialize` is called once) and asks its page for one thing, a clock.
"""

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from importlib.util import find_spec
from pathlib import Path

from lagrangia.base.diagnostics import fail
from lagrangia.base.folders import cache_folder, data_folder, is_trusted, note_use
from lagrangia.native.prebuilt import digest, joined, sources

_FILES = ("cosimulation", "evaluations", "exchange", "exchange_steps", "image", "life", "log", "partial", "play", "saved",
          "settle", "states", "values")
# No page makes many runs, compares structures, or compiles.
_UNUSED = ("batch", "reduce", "layout", "arrange", "hoist", "numbering")
_CALLS = ("room", "new", "message", "reset", "inputs", "set", "begin", "step", "values", "events", "drawing")
# As prebuilt.py has them: the same operations in the same order.
_FLAGS = ("-target", "wasm32-wasi", "-mexec-model=reactor", "-std=c99", "-ffp-contract=off", "-fno-math-errno", "-O2",
          "-fvisibility=hidden", "-Wno-pass-failed", "-Wl,--strip-all", *(f"-Wl,--export=lag_play_{call}" for call in _CALLS))


def zig() -> list[str] | None:
    """The command of zig's C compiler: PyPI's, or the system's."""
    if find_spec("ziglang"):
        return [sys.executable, "-m", "ziglang", "cc"]
    return ["zig", "cc"] if shutil.which("zig") else None


def require_zig() -> list[str]:
    """Its command. Raises LagError L0706 where there is none, unless the module was built before."""
    command = zig()
    if command is None and _whole(_kept()) is None:
        fail("L0706", "a page that computes needs zig, which compiles the run time to WebAssembly", None, "pip install ziglang")
    return command or []


def _kept() -> Path:
    key = hashlib.sha256(repr((digest(data_folder("runtime")), _FLAGS, _FILES, _UNUSED)).encode()).hexdigest()[:32]
    return cache_folder() / f"page-{key}" / "run_time.wasm"


def build_wasm() -> bytes:
    """The module. Raises LagError L0706 where there is no zig, or it refuses."""
    kept = _kept()
    found = _whole(kept)
    if found is not None:
        return found
    made = _compiled(require_zig(), data_folder("runtime"))
    kept.parent.mkdir(mode=0o700, parents=True, exist_ok=True)
    for file, content in ((kept, made), (_sum(kept), hashlib.sha256(made).hexdigest().encode())):
        with tempfile.NamedTemporaryFile(dir=kept.parent, delete=False) as fresh:
            fresh.write(content)
        os.replace(fresh.name, file)
    return made


def _sum(file: Path) -> Path:
    return file.with_suffix(".sha256")


def _whole(file: Path) -> bytes | None:
    """What was built before, with the bytes it was built with."""
    try:
        if not all(map(is_trusted, (file.parent, file, _sum(file)))):
            return None
        content = file.read_bytes()
        note_use(file)
        return content if _sum(file).read_text() == hashlib.sha256(content).hexdigest() else None
    except OSError:
        return None


def _compiled(command: list[str], runtime: Path) -> bytes:
    files = [file for file in sources(runtime) if file.stem not in _UNUSED]
    files += [runtime / "fmi" / f"{name}.c" for name in _FILES]
    with tempfile.TemporaryDirectory(prefix="lagrangia-") as folder:
        made = Path(folder) / "run_time.wasm"
        done = subprocess.run([*command, *_FLAGS, f"-I{runtime}", f'-DLAG_BUILD="{digest(runtime)}"',
                               *map(str, joined(files, Path(folder))), "-o", str(made)],
                              cwd=folder, capture_output=True, text=True, check=False)
        if done.returncode != 0:
            fail("L0706", "zig does not compile the run time to WebAssembly", None, *done.stderr.splitlines()[:3])
        return made.read_bytes()
