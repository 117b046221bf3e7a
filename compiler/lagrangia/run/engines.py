"""Scene -> run time with the scene in it: as a tape of instructions, as native code, or as a tape until the native code is ready.

Compiling costs tenths of a second and more once, interpreting nanoseconds for each operation of each evaluation. So every scene
starts on its tape. When what the tape has cost, over all runs, and will cost in this one exceeds what compiling costs, the
compiler is started beside the run, and the run changes over when it is done; what an earlier process has had compiled is there
soon. The operations are the same in the same order, and so are the results, to the last digit. The library stays in the cache.
"""

import contextlib
import math
import threading
import time
import weakref
from collections.abc import Mapping, Sequence
from dataclasses import field, replace
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING

from lagrangia.base.folders import data_folder
from lagrangia.base.records import dataclass
from lagrangia.native.tapes import Tape
from lagrangia.run.library import Runtime, find_runtime
from lagrangia.run.rules import Code, Moment, decide
from lagrangia.run.runtime import Model, Solver
from lagrangia.run.scene import Scene

if TYPE_CHECKING:
    from lagrangia.native.build import Build, Compiler

# The model of costs, measured with gcc 12 on the examples and on a chain of 2 to 1000 links: seconds to start a compiler, for
# each instruction at -O1 (-O2 takes half as long again and gives the same speed), and for each statement of series in all orders;
# seconds for each operation of one evaluation.
_START, _COMPILE, _SERIES = 0.08, 1e-4, 1.8e-4
_TAPE, _NATIVE = 2.0e-9, 0.6e-9
_SHORT = 2_000  # instructions for which -O2 takes no longer
_SEEN = 50_000  # instructions that are written out in no time, to see whether they were compiled before
# Seconds of all runs that are worth writing the scene out, to see whether it was compiled before; before their lengths are told.
_SEEK, _LOOK = 0.015, 0.1
# Instructions up to which these are compiled. Runs ask for equations of start values some tens of times each (slices of longer
# ones are made of their tape: runtime/model/slice.h), for the others once where parameters vary; the last are data.
_LONGEST = {"initial": 1_999, "momentum": 1_999, "requirements": 999,
            **dict.fromkeys(("parameters", "hoist", "start", "series"), 400), **dict.fromkeys(("events", "linear", "waves"), 0)}
_LARGEST_JACOBIAN = 400  # instructions


@dataclass
class Engine:
    """A loaded run time and the scene's model in it."""

    runtime: Runtime
    model: Model
    how: str  # "native", "tape", or "tape, then native"
    seconds: float  # spent on compiling and loading before the run could start
    upgrade: "Upgrade | None" = None

    def look(self, spent: float, left: float) -> None:
        """Between two portions of a run, or of runs: seconds since the last look, and about so many to come."""
        upgrade = self.upgrade
        if upgrade is not None and upgrade.look(spent, left):
            self.how, self.upgrade = "tape, then native" if upgrade.is_late else "native", None


@dataclass
class Upgrade:
    """Native code for models that run on their tapes, a scene and its islands: whether to make it, and its making."""

    runtime: Runtime
    parts: Sequence[tuple[Scene, Model]]
    is_implicit: bool = False
    spent: float = 0.0  # in all runs so far
    is_late: bool = False  # something was computed on the tapes that is worth mentioning
    _is_sought: bool = False
    _thread: threading.Thread | None = None
    _built: list[Sequence[Path]] = field(default_factory=list)
    _lock: threading.Lock = field(default_factory=threading.Lock)

    def look(self, spent: float, left: float) -> bool:
        """Starts the compiler when it pays; puts the native functions into the models when they are there. True: they are."""
        with self._lock:
            self.spent += spent
            if not self._built and self._thread is None and self.spent > _SEEK:
                self._begin(left)
            if not self._built:
                return False
            for (_, model), library in zip(self.parts, self._built[0], strict=True):
                model.adopt(Model.from_library(library))
            return True

    @cached_property
    def compiling(self) -> float:
        """Seconds."""
        return sum(compile_seconds(scene, self.is_implicit) for scene, _ in self.parts)

    def _begin(self, left: float) -> None:
        if not self._is_sought:
            self._is_sought = True
            self._seek()
        facts = {"is_built": bool(self._built), "looks": self.spent > _LOOK, "spent": self.spent,
                 "saved": left * (1 - _NATIVE / _TAPE), "compiling": self.compiling}
        if decide(Moment.UPGRADE, facts).takes is Code.NATIVE and not self._built and self.runtime.compiler is not None:
            self.is_late = True
            self._thread = threading.Thread(target=self._make, daemon=True)
            self._thread.start()

    def _seek(self) -> None:
        """What an earlier process has had compiled. Where none has, no compiler is looked for."""
        from lagrangia.native.build import has_builds

        if not has_builds("scene") or (compiler := self.runtime.compiler) is None:
            return
        found = [_find_library(scene, compiler, self.is_implicit) for scene, _ in self.parts]
        libraries = [library for library in found if library is not None]
        if len(libraries) == len(found):
            self._built.append(libraries)

    def _make(self) -> None:
        from lagrangia.native.build import CompilerError

        compiler, libraries = self.runtime.compiler, []
        assert compiler is not None
        with contextlib.suppress(CompilerError, OSError):  # the tape does as well
            for scene, _ in self.parts:
                build = _start_scene_build(scene, compiler, _often(scene, self.is_implicit), self.is_implicit)
                weakref.finalize(scene, build.cancel)  # also when Python ends
                libraries.append(build.finish())
            self._built.append(libraries)


def load_engine(
    scene: Scene, runtime: Runtime | None = None, native: bool | None = None, solver: Solver = Solver.AUTO
) -> Engine | None:
    """The run time with the scene in it. None when there is neither a run time nor a C compiler.

    `native`: True compiles it as a whole first (raises CompilerError where there is no compiler), False never compiles it.
    `solver` is sure to be run: Jacobians are compiled for implicit steps however long they are.
    """
    engine = _load_whole(scene, runtime, native, solver is Solver.IMPLICIT)
    return divided(engine, scene, native) if engine is not None and scene.sizes.get("solver") == Solver.ISLANDS else engine


def divided(engine: Engine, scene: Scene, native: bool | None = None) -> Engine:
    """The engine with the scene's islands in it."""
    if engine.model.struct.n_islands:
        return engine
    parts = [(places, island, _load_whole(island, engine.runtime, native, False)) for places, island in scene.islands]
    islands = [(places, island, part.model) for places, island, part in parts if part is not None]
    model = engine.model.divided([(places, own) for places, _, own in islands])
    upgrade = None
    if native is None:
        upgrade = Upgrade(engine.runtime, [(scene, model), *((island, own) for _, island, own in islands)])
    return replace(engine, model=model, upgrade=upgrade)


def _load_whole(
    scene: Scene, runtime: Runtime | None = None, native: bool | None = None, is_implicit: bool = False
) -> Engine | None:
    begin = time.perf_counter()
    runtime = runtime or find_runtime()
    if runtime is None:
        return None
    model = _of_tapes(scene)
    if native:
        from lagrangia.native.build import require_compiler

        build = _start_scene_build(scene, runtime.compiler or require_compiler(), scene.tapes, is_implicit)
        model.adopt(Model.from_library(build.finish()))  # what is asked of tapes beside the code, as lanes do, is there, too
    _ = runtime.library  # built and loaded now
    upgrade = Upgrade(runtime, [(scene, model)], is_implicit) if native is None else None
    return Engine(runtime, model, "native" if native else "tape", time.perf_counter() - begin, upgrade)


def _of_tapes(scene: Scene) -> Model:
    return Model.from_tapes(scene.sizes, scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                            scene.tables)


def compile_seconds(scene: Scene, is_implicit: bool = False) -> float:
    """What the model of costs says of the functions that a run calls often."""
    from lagrangia.native.series import statements_in_all

    series = statements_in_all(scene.sizes.get("n_products", 0), scene.sizes.get("n_jet_instructions", 0))
    return _START + _COMPILE * _instructions(_often(scene, is_implicit)) + _SERIES * series


def saved_seconds(scene: Scene, evaluations: int) -> float:
    """What native code saves in so many evaluations of the right-hand side."""
    return float(evaluations * scene.notes["rhs_operations"] * (_TAPE - _NATIVE))


def describe(scene: Scene) -> str:
    """The model of costs, for people."""
    operations = scene.notes["rhs_operations"]
    seconds = compile_seconds(scene)
    gain = operations * (_TAPE - _NATIVE)
    return (f"{_instructions(_often(scene))} instructions compile in about {seconds:.2g} s; an evaluation takes about "
            f"{operations * _TAPE * 1e6:.3g} us on the tape, {operations * _NATIVE * 1e6:.3g} us natively: "
            + (f"pays from {seconds / gain:.2g} evaluations" if gain > 0 else "never pays"))


def _often(scene: Scene, is_implicit: bool = False) -> Mapping[str, Tape]:
    long = _long_jacobians(scene, is_implicit)
    return {name: tape for name, tape in scene.tapes.items()
            if name not in long and _instructions({name: tape}) <= _LONGEST.get(name, math.inf)}


def _long_jacobians(scene: Scene, is_implicit: bool) -> list[str]:
    """Only implicit steps need Jacobians, and not all the time: longer ones are compiled when such steps are asked for."""
    found = () if is_implicit else tuple(name for name in ("jacobian", "tangent") if name in scene.tapes)
    return [name for name in found if _instructions({name: scene.tapes[name]}) > _LARGEST_JACOBIAN]


def _instructions(tapes: Mapping[str, Tape]) -> int:
    return sum(len(tape.code) // 4 for tape in tapes.values())


def _find_library(scene: Scene, compiler: "Compiler", is_implicit: bool) -> Path | None:
    """The functions called often, where an earlier run had them compiled."""
    from lagrangia.native.build import find_build

    tapes = _often(scene, is_implicit)
    if _instructions(tapes) > _SEEN:
        return None
    source = _source(scene, tapes, is_implicit)
    return find_build("scene", source, include=[data_folder("runtime")], level=_level(tapes), compiler=compiler)


def _start_scene_build(scene: Scene, compiler: "Compiler", tapes: Mapping[str, Tape], is_implicit: bool) -> "Build":
    from lagrangia.native.build import start_build

    source = _source(scene, tapes, is_implicit)
    return start_build("scene", source, include=[data_folder("runtime")], level=_level(tapes), compiler=compiler)


def _source(scene: Scene, tapes: Mapping[str, Tape], is_implicit: bool) -> str:
    from lagrangia.native.c_code import write_c

    return write_c(scene.name, scene.sizes, tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                   _long_jacobians(scene, is_implicit), lanes=True)


def _level(tapes: Mapping[str, Tape]) -> str:
    return "-O2" if _instructions(tapes) <= _SHORT else "-O1"
