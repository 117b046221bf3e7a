"""The C run time as a library of the parts that a scene needs.

Each source is compiled once, into an object that is kept; a library is linked of the core and of the parts asked for, and of
runtime/parts.c, which says what is there. The core is compiled while the scene is. zig keeps objects by itself and makes one
at a time: it builds the whole at once.
"""

from ctypes import CDLL
from functools import cache
from pathlib import Path
from threading import Lock

from lagrangia.folders import cache_folder, data_folder
from lagrangia.native import Build, Compiler, Objects, build, require_compiler, start_build
from lagrangia.runtime import Model, Run, Settings, Solver, load_runtime

# The sources of what few scenes need. A part that the core knows by runtime/parts.h is left out by LAG_WITHOUT_<PART>.
PARTS = {
    "assembly": ("assemble", "linear", "metric", "newton"),
    "linear": ("dd", "dd_tape", "dd_vector", "linear_ladder", "linear_method", "linear_pace", "linear_series", "linear_system"),
    "islands": ("islands",),
    "conservative": ("equal_steps", "gauss", "nystrom"),
    "batch": ("batch", "reduce"),
    "snapshot": ("snapshot",),
}
_OF_PARTS = frozenset(name for names in PARTS.values() for name in names)
ALL = frozenset(PARTS)


class Runtime:
    """The run time: made when it is needed, as libraries with the parts that are needed."""

    def __init__(self, compiler: Compiler, level: str) -> None:
        self.compiler = compiler
        self._level = level
        self._folder = data_folder("runtime")
        self._lock = Lock()
        self._loaded: dict[frozenset[str], CDLL] = {}
        self._core = self._objects({file.stem for file in self._folder.glob("*.c")} - _OF_PARTS - {"parts"})
        self._whole: Build | None = None
        if compiler.is_zig:
            self._whole = start_build("runtime", sorted(self._folder.glob("*.c")), include=[self._folder], level=level,
                                      compiler=compiler)
        elif not any(cache_folder().glob("runtime-*")):
            self._core.start()

    def run(self, model: Model, settings: Settings) -> Run:
        """A run that can be started. Raises CompilerError, MemoryError."""
        return Run(self.library_for(model, settings.solver), model, settings)

    def library_for(self, model: Model, solver: Solver = Solver.AUTO, more: frozenset[str] = frozenset()) -> CDLL:
        """The library that runs this model, with more parts. Raises CompilerError."""
        parts = _parts(model, solver) | more
        with self._lock:
            for there, library in self._loaded.items():
                if parts <= there:
                    return library
            return self._loaded.setdefault(parts, load_runtime(self.path(parts)))

    def path(self, parts: frozenset[str] = ALL) -> Path:
        """The file of the library with these parts. Raises CompilerError."""
        if self._whole is not None:
            return self._whole.finish()
        rest = self._objects({name for part in parts for name in PARTS[part]})
        return build("runtime", [self._folder / "parts.c"], include=[self._folder], level=self._level, compiler=self.compiler,
                     objects=[self._core, rest], defines=[f"LAG_WITHOUT_{part.upper()}" for part in sorted(ALL - parts)])

    def _objects(self, names: set[str]) -> Objects:
        return Objects([self._folder / f"{name}.c" for name in sorted(names)], [self._folder], self._level, self.compiler)


def _parts(model: Model, solver: Solver) -> frozenset[str]:
    own = Solver(model.struct.solver) if solver == Solver.AUTO else solver
    if own == Solver.ISLANDS:
        return frozenset({"assembly", "linear", "islands"})  # each island has its solver and its start
    parts = {"assembly"} if model.struct.n_initial else set()
    if own in (Solver.LINEAR, Solver.CONSERVATIVE):
        parts.add(own.name.lower())
    return frozenset(parts)


def start_runtime(compiler: Compiler | None = None, level: str = "-O2") -> Runtime:
    """A process makes it once, however many scenes ask for it meanwhile. Raises CompilerError when there is no compiler."""
    return _runtime(cache_folder(), compiler or require_compiler(), level)


@cache
def _runtime(_cache: Path, compiler: Compiler, level: str) -> Runtime:
    return Runtime(compiler, level)
