"""The C run time as a library: the one that came with the package, or one that is compiled here.

A source tree whose sources have changed since has to compile: each source into an object that is kept, while the scene is
compiled, too. zig keeps objects by itself and makes one at a time: it builds the whole at once. Who names a compiler in
LAGRANGIA_CC has the run time from it.
"""

import os
from ctypes import CDLL
from functools import cache
from pathlib import Path
from threading import Lock
from typing import TYPE_CHECKING

from lagrangia.base.folders import cache_folder, data_folder, stamps
from lagrangia.base.records import dataclass
from lagrangia.base.store import find_kept, keep, key_of
from lagrangia.native import prebuilt
from lagrangia.run.runtime import Model, Run, Settings, load_runtime

if TYPE_CHECKING:
    from lagrangia.native.build import Build, Compiler, Objects


class Runtime:
    """The run time, made and loaded when it is needed: what is `ready`, or what a compiler makes of the sources."""

    def __init__(self, compiler: "Compiler | None", level: str = prebuilt.LEVEL, ready: Path | None = None) -> None:
        self._compiler = compiler
        self._lock = Lock()
        self._library: CDLL | None = None
        self._path = ready
        self._level = level
        self._work: Build | _Linked | None = None if ready is not None else self._start()

    @property
    def compiler(self) -> "Compiler | None":
        """What scenes are compiled with, looked for when it is first asked for; None where there is none."""
        return self._compiler if self._work is not None or self._compiler is not None else _find_compiler()

    @property
    def is_ready(self) -> bool:
        """Whether nothing has to be made first."""
        return self._library is not None or self._path is not None

    def run(self, model: Model, settings: Settings) -> Run:
        """A run that can be started. Raises CompilerError, MemoryError."""
        return Run(self.library, model, settings)

    @property
    def library(self) -> CDLL:
        """Raises CompilerError."""
        with self._lock:
            if self._library is None:
                self._library = load_runtime(self.path())
            return self._library

    def path(self) -> Path:
        """The file of the library. Raises CompilerError."""
        if self._path is None:
            assert self._work is not None
            self._path = self._work.finish()
        return self._path

    def _start(self) -> "Build | _Linked":
        from lagrangia.native.build import Objects, require_compiler, start_build

        compiler, folder = self._compiler or require_compiler(), data_folder("runtime")
        files = prebuilt.sources(folder)
        if compiler.is_zig:
            return start_build("runtime", files, include=[folder], level=self._level, compiler=compiler)
        objects = Objects(files, [folder], self._level, compiler)
        objects.start()
        return _Linked(objects, self._level, compiler)


@dataclass(frozen=True)
class _Linked:
    """A library of objects in the making."""

    objects: "Objects"
    level: str
    compiler: "Compiler"

    def finish(self) -> Path:
        """Raises CompilerError."""
        from lagrangia.native.build import build

        return build("runtime", [], level=self.level, compiler=self.compiler, objects=[self.objects])


def start_runtime(compiler: "Compiler | None" = None, level: str = prebuilt.LEVEL) -> Runtime:
    """A process makes it once, however many scenes ask for it meanwhile.

    Raises CompilerError when there is neither a compiler nor a run time that came with the package.
    """
    if compiler is None and level == prebuilt.LEVEL and (ready := _ready()) is not None:
        return _taken(cache_folder(), ready)
    from lagrangia.native.build import require_compiler

    return _made(cache_folder(), compiler or require_compiler(), level)


def find_runtime() -> Runtime | None:
    """That of `start_runtime`, or None where there is neither a compiler nor a run time that came with the package."""
    if (ready := _ready()) is not None:
        return _taken(cache_folder(), ready)
    return start_runtime() if _find_compiler() is not None else None


def has_runtime() -> bool:
    """Whether scenes can be run here."""
    return _ready() is not None or _find_compiler() is not None


def has_compiler() -> bool:
    """Whether scenes can be compiled here."""
    return _find_compiler() is not None


def _ready() -> Path | None:
    """What came with the package, unless a compiler is asked for by name. Raises LagError L0706 for a name that is none."""
    is_other = _is_compiler_named() and _find_compiler() is not None
    return None if is_other else prebuilt.find(data_folder("runtime"), digest_of=_digest)


@cache
def _digest(runtime: Path) -> str:
    """That of prebuilt.py, kept by what is told of the sources without reading them."""
    key = key_of("runtime", stamps(runtime, ".c", ".h"))
    if (kept := find_kept("texts", key)) is not None:
        return kept.decode()
    found = prebuilt.digest(runtime)
    keep("texts", key, found.encode())
    return found


def _is_compiler_named() -> bool:
    if "LAGRANGIA_CC" not in os.environ and "CC" not in os.environ:
        return False  # at once
    from lagrangia.native.build import is_compiler_named

    return is_compiler_named()


def _find_compiler() -> "Compiler | None":
    from lagrangia.native.build import find_compiler

    return find_compiler()


@cache
def _taken(_cache: Path, ready: Path) -> Runtime:
    return Runtime(None, ready=ready)


@cache
def _made(_cache: Path, compiler: "Compiler", level: str) -> Runtime:
    return Runtime(compiler, level)
