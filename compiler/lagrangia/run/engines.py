"""Scene -> run time with the scene in it: as native code, as a tape, or as a tape until the native code is ready.

Compiling costs seconds once, interpreting nanoseconds for each operation of each evaluation. Small scenes are compiled at
once: it takes a moment, and they are run again and again. A large scene starts on its tape; when what the tape has cost and
will cost in the run exceeds what compiling costs, the compiler is started beside the run, and the run changes over when it is
done: the operations are the same in the same order, and so are the results, to the last digit. The library stays in the cache.
"""

import contextlib
import threading
import time
import weakref
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from lagrangia.base.folders import data_folder
from lagrangia.native.build import Build, Compiler, CompilerError, find_build, require_compiler, start_build
from lagrangia.native.c_code import write_c
from lagrangia.native.tapes import Tape
from lagrangia.run.library import Runtime, find_runtime
from lagrangia.run.rules import Code, Moment, decide
from lagrangia.run.runtime import Model, Solver
from lagrangia.run.scene import Scene

# The model of costs, measured with gcc 12 on a chain of 2 to 1000 links: seconds to start a compiler, and for each instruction at
# -O1 (-O2 takes half as long again and gives the same speed); seconds for each operation of one evaluation.
_START, _COMPILE = 0.05, 1.2e-4
_TAPE, _NATIVE = 2.0e-9, 0.6e-9
_SHORT = 2_000  # instructions for which -O2 takes no longer
_SEEN = 50_000  # instructions that are written out in no time, to see whether they were compiled before
_LOOK = 0.2  # seconds of a run before its length can be told
# Called once for each set of parameters, or data: not worth compiling in a large scene.
_RARE = ("parameters", "hoist", "start", "initial", "momentum", "events", "linear", "waves")
_LARGEST_JACOBIAN = 400  # instructions


@dataclass
class Engine:
    """A loaded run time and the scene's model in it."""

    runtime: Runtime
    model: Model
    how: str  # "native", "tape", or "tape, then native"
    seconds: float  # spent on compiling and loading before the run could start
    upgrade: "Upgrade | None" = None

    def look(self, elapsed: float, done: float) -> None:
        """Between two portions of a run: so many seconds took it to this share of the whole, from 0 to 1."""
        if self.upgrade is not None and self.upgrade.look(self.model, elapsed, done):
            self.how, self.upgrade = "tape, then native", None


@dataclass
class Upgrade:
    """Native code for a model that runs on its tapes: whether to make it, and its making."""

    scene: Scene
    compiler: Compiler
    is_implicit: bool = False
    spent: float = 0.0  # in runs before this one
    last: float = 0.0
    _thread: threading.Thread | None = None
    _built: list[Model] = field(default_factory=list)

    def look(self, model: Model, elapsed: float, done: float) -> bool:
        """Starts the compiler when it pays; puts the native functions into the model when they are there."""
        if self._built:
            model.adopt(self._built[0])
            return True
        if elapsed < self.last:
            self.spent += self.last  # another run
        self.last = elapsed
        if self._thread is None and elapsed > _LOOK and done > 0:
            left = elapsed / done - elapsed
            facts = {"spent": self.spent + elapsed, "saved": left * (1 - _NATIVE / _TAPE),
                     "compiling": compile_seconds(self.scene, self.is_implicit)}
            if decide(Moment.UPGRADE, facts).takes is Code.NATIVE:
                self._thread = threading.Thread(target=self._make, daemon=True)
                self._thread.start()
        return False

    def _make(self) -> None:
        build = _start_scene_build(self.scene, self.compiler, _often(self.scene, self.is_implicit), self.is_implicit)
        weakref.finalize(self.scene, build.cancel)  # also when Python ends
        with contextlib.suppress(CompilerError, OSError):  # the tape does as well
            self._built.append(Model.from_library(build.finish()))


def start_building() -> Runtime | None:
    """The run time, made meanwhile where it has to be; None when there is none, and no C compiler for one."""
    return find_runtime()


def load_engine(
    scene: Scene, runtime: Runtime | None = None, native: bool | None = None, solver: Solver = Solver.AUTO
) -> Engine | None:
    """The run time with the scene in it. None when there is neither a run time nor a C compiler.

    Without a compiler scenes run on their tapes. `native` decides instead of the model of costs (True: raises CompilerError where
    there is none). `solver` is sure to be run: series are C in any case, and Jacobians are compiled for implicit steps however
    long they are.
    """
    if native is None and solver is Solver.TAYLOR:
        native = True
    engine = _load_whole(scene, runtime, native, solver is Solver.IMPLICIT)
    return divided(engine, scene, native) if engine is not None and scene.sizes.get("solver") == Solver.ISLANDS else engine


def divided(engine: Engine, scene: Scene, native: bool | None = None) -> Engine:
    """The engine with the scene's islands in it."""
    if engine.model.struct.n_islands:
        return engine
    parts = [(places, _load_whole(island, engine.runtime, native, False)) for places, island in scene.islands]
    return replace(engine, model=engine.model.divided([(places, part.model) for places, part in parts if part is not None]))


def _load_whole(
    scene: Scene, runtime: Runtime | None = None, native: bool | None = None, is_implicit: bool = False
) -> Engine | None:
    begin = time.perf_counter()
    runtime = runtime or start_building()
    if runtime is None:
        return None
    compiler = runtime.compiler
    facts = {"has_compiler": compiler is not None, "compiling": compile_seconds(scene, is_implicit)}
    if native if native is not None else decide(Moment.ENGINE, facts).takes is Code.NATIVE:
        scene_build = _start_scene_build(scene, compiler or require_compiler(), scene.tapes, is_implicit)
        return _engine(runtime, Model.from_library(scene_build.finish()), "native", begin)
    model = Model.from_tapes(scene.sizes, scene.tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns)
    if native is not None or compiler is None:
        return _engine(runtime, model, "tape", begin)
    if (compiled := _find_library(scene, compiler, is_implicit)) is not None:
        model.adopt(Model.from_library(compiled))
        return _engine(runtime, model, "native", begin)
    return _engine(runtime, model, "tape", begin, Upgrade(scene, compiler, is_implicit))


def _engine(runtime: Runtime, model: Model, how: str, begin: float, upgrade: Upgrade | None = None) -> Engine:
    _ = runtime.library  # built and loaded now
    return Engine(runtime, model, how, time.perf_counter() - begin, upgrade)


def compile_seconds(scene: Scene, is_implicit: bool = False) -> float:
    """What the model of costs says of the functions that a run calls often."""
    return _START + _COMPILE * _instructions(_often(scene, is_implicit))


def describe(scene: Scene) -> str:
    """The model of costs, for people."""
    operations = scene.notes["rhs_operations"]
    seconds = compile_seconds(scene)
    is_native = decide(Moment.ENGINE, {"has_compiler": True, "compiling": seconds}).takes is Code.NATIVE
    gain = operations * (_TAPE - _NATIVE)
    return (f"{_instructions(_often(scene))} instructions compile in about {seconds:.2g} s; an evaluation takes about "
            f"{operations * _TAPE * 1e6:.3g} us on the tape, {operations * _NATIVE * 1e6:.3g} us natively: "
            + ("compiled at once" if is_native else f"pays from {seconds / gain:.2g} evaluations"))


def _often(scene: Scene, is_implicit: bool = False) -> Mapping[str, Tape]:
    rare = {*_RARE, *_long_jacobians(scene, is_implicit)}
    return {name: tape for name, tape in scene.tapes.items() if name not in rare}


def _long_jacobians(scene: Scene, is_implicit: bool) -> list[str]:
    """Only implicit steps need Jacobians, and not all the time: longer ones are compiled when such steps are asked for."""
    found = () if is_implicit else tuple(name for name in ("jacobian", "tangent") if name in scene.tapes)
    return [name for name in found if _instructions({name: scene.tapes[name]}) > _LARGEST_JACOBIAN]


def _instructions(tapes: Mapping[str, Tape]) -> int:
    return sum(len(tape.code) // 4 for tape in tapes.values())


def _find_library(scene: Scene, compiler: Compiler, is_implicit: bool) -> Path | None:
    """The functions called often, where an earlier run had them compiled."""
    tapes = _often(scene, is_implicit)
    if _instructions(tapes) > _SEEN:
        return None
    source = _source(scene, tapes, is_implicit)
    return find_build("scene", source, include=[data_folder("runtime")], level=_level(tapes), compiler=compiler)


def _start_scene_build(scene: Scene, compiler: Compiler, tapes: Mapping[str, Tape], is_implicit: bool) -> Build:
    source = _source(scene, tapes, is_implicit)
    return start_build("scene", source, include=[data_folder("runtime")], level=_level(tapes), compiler=compiler)


def _source(scene: Scene, tapes: Mapping[str, Tape], is_implicit: bool) -> str:
    return write_c(scene.name, scene.sizes, tapes, scene.coordinate_kind, scene.fixed, scene.event_kind, scene.patterns,
                   _long_jacobians(scene, is_implicit))


def _level(tapes: Mapping[str, Tape]) -> str:
    return "-O2" if _instructions(tapes) <= _SHORT else "-O1"
