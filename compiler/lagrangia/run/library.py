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

from lagrangia.base.folders import cache_folder, data_folder
from lagrangia.native import prebuilt
from lagrangia.native.build import Build, Compiler, Objects, build, find_compiler, require_compiler, start_build
from lagrangia.run.runtime import Model, Run, Settings, load_runtime


class Runtime:
    """The run time, made and loaded when it is needed. `compiler` is what scenes are compiled with; None where there is none."""

    def __init__(self, compiler: Compiler | None, level: str = prebuilt.LEVEL, ready: Path | None = None) -> None:
        self.compiler = compiler
        self._lock = Lock()
        self._library: CDLL | None = None
        self._path = ready
        self._level = level
        self._work: Build | Objects | None = None if ready is not None else self._start()

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
            self._path = self._work.finish() if isinstance(self._work, Build) else self._linked(self._work)
        return self._path

    def _start(self) -> Build | Objects:
        compiler, folder = self.compiler or require_compiler(), data_folder("runtime")
        files = prebuilt.sources(folder)
        if compiler.is_zig:
            return start_build("runtime", files, include=[folder], level=self._level, compiler=compiler)
        objects = Objects(files, [folder], self._level, compiler)
        objects.start()
        return objects

    def _linked(self, objects: Objects) -> Path:
        return build("runtime", [], level=self._level, compiler=self.compiler, objects=[objects])


def start_runtime(compiler: Compiler | None = None, level: str = prebuilt.LEVEL) -> Runtime:
    """A process makes it once, however many scenes ask for it meanwhile.

    Raises CompilerError when there is neither a compiler nor a run time that came with the package.
    """
    return _runtime(cache_folder(), compiler or find_compiler(), compiler is not None, level)


def find_runtime() -> Runtime | None:
    """That of `start_runtime`, or None where there is neither a compiler nor a run time that came with the package."""
    compiler = find_compiler()
    return None if compiler is None and _prebuilt() is None else _runtime(cache_folder(), compiler, False, prebuilt.LEVEL)


def has_runtime() -> bool:
    """Whether scenes can be run here."""
    return find_compiler() is not None or _prebuilt() is not None


def _prebuilt() -> Path | None:
    return prebuilt.find(data_folder("runtime"))


@cache
def _runtime(_cache: Path, compiler: Compiler | None, is_asked_for: bool, level: str) -> Runtime:
    is_named = is_asked_for or (compiler is not None and "LAGRANGIA_CC" in os.environ)
    return Runtime(compiler, level, None if is_named or level != prebuilt.LEVEL else _prebuilt())
