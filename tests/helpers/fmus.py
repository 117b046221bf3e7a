"""FMUs of scenes for the tests, each exported once for all tests and processes of a run, and runs of them by FMPy."""

import ctypes
import os
from collections.abc import Callable
from contextlib import nullcontext, suppress
from functools import cache
from hashlib import sha256
from math import prod
from pathlib import Path
from tempfile import mkdtemp

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np

import lagrangia as lag
from helpers.one_process import one_process_at_a_time
from lagrangia.base.folders import data_folder, stamps
from lagrangia.base.store import key_of
from lagrangia.fmu.build import host_platform
from lagrangia.fmu.description import element_of, labels
from lagrangia.fmu.export import Export, Extras, archive, model_files
from lagrangia.fmu.pictures import draw_graph, draw_icon
from lagrangia.fmu.variables import build_fmu_model
from lagrangia.native.prebuilt import find_fmu

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
EXPORTED = sorted(EXAMPLES.glob("*.lag"))
_ENGINE = "tape" if find_fmu(data_folder("runtime"), "2") else "native"
VERSIONS, KINDS = ("2", "3"), ("CoSimulation", "ModelExchange")


def of_this_run(kind: str) -> Path:
    """A folder that all processes of this run share: conftest.own_cache."""
    return Path(os.environ["LAGRANGIA_CACHE"]).parent / kind


def model_of(path: Path) -> lag.Model:
    return _model_at(_place_of(path))


@cache
def _model_at(place: Path) -> lag.Model:
    return lag.load(place)


def _place_of(path: Path) -> Path:
    """The same place for the same text, so that all tests that write it find it exported; its own beside files it may read."""
    if EXAMPLES in path.parents or any(
            file.is_file() and file.suffix != ".fmu" for file in path.parent.iterdir() if file != path):
        return path
    text = path.read_bytes()
    return _once(of_this_run("texts") / sha256(text).hexdigest() / path.name, lambda place: place.write_bytes(text))


def _once(place: Path, make: Callable[[Path], object]) -> Path:
    """Made by the process that asks first, beside its place, where the others find it whole."""
    if not place.exists():
        place.parent.mkdir(parents=True, exist_ok=True)
        made = Path(mkdtemp(dir=place.parent)) / place.name
        make(made)
        with suppress(OSError):  # another process was faster
            made.rename(place)
    return place


@cache
def _runtime() -> tuple[object, ...]:
    return tuple(stamps(data_folder("runtime"), ".c", ".h"))


def reported(path: Path) -> list[str]:
    """Names of positions, as importers have them, and of outputs."""
    scene = model_of(path).scene
    return [c.name for c in (*scene.told_positions, *scene.own_outputs)]


def fmu_of(path: Path, version: str, engine: str = _ENGINE, arrays: bool = True) -> Path:
    """For this machine alone, with sources; by the library that comes with the package, where it did. Without what takes longer
    to make than all else, and is no more than `equations` and `functions` of the model say."""
    place = _place_of(path)
    name = f"{place.stem}-{key_of(str(place), place.read_bytes(), version, engine, arrays, _runtime())}.fmu"
    return _once(of_this_run("fmus") / name, lambda target: _export(place, target, Export(
        version, platforms=(host_platform() or "host",), engine=engine, arrays=arrays)))


def unpacked(path: Path, version: str, engine: str = _ENGINE, arrays: bool = True) -> Path:
    archived = fmu_of(path, version, engine, arrays)
    return _once(archived.with_suffix(""), lambda folder: fmpy.extract(str(archived), str(folder)))


def _export(place: Path, target: Path, wanted: Export) -> None:
    model = _model_at(place)
    described = build_fmu_model(model)
    extras = Extras(draw_icon(model, described.state_start), draw_graph(model.compilation), "", model_files(model))
    beside = nullcontext() if wanted.engine == "tape" else one_process_at_a_time(of_this_run("native.lock"))
    with beside:  # the first that is compiled compiles the run time, too
        target.write_bytes(archive(described, wanted, extras))


def simulated(path: Path, version: str, kind: str, names: list[str], **options: object) -> np.ndarray:
    scene = model_of(path).scene
    step = (scene.stop - scene.start) / 100
    settings = {"start_time": scene.start, "stop_time": scene.stop, "step_size": step, "output_interval": step,
                "relative_tolerance": 1e-8, "solver": "CVode"} | options
    description = fmpy.read_model_description(str(fmu_of(path, version)))
    known = {v.name: v for v in description.modelVariables}
    whole = list(dict.fromkeys(name if name in known else element_of(name)[0] for name in names))
    return _by_element(fmpy.simulate_fmu(str(unpacked(path, version)), fmi_type=kind, output=whole, **settings), known)


def _by_element(found: np.ndarray, known: dict) -> np.ndarray:
    """Rows with a column for each element of an array, as FMI 2 has them."""
    columns = {"time": found["time"]}
    for name in found.dtype.names[1:]:
        values = found[name].reshape(len(found), -1)
        columns |= dict(zip(labels(name, known[name].shape), values.T, strict=True))
    return np.rec.fromarrays(list(columns.values()), dtype=[(name, column.dtype) for name, column in columns.items()])


def instance_of(path: Path, version: str, kind: str, name: str = "one") -> "Instance":
    return Instance(path, version, kind, name)


class Instance:
    """One instance of an FMU, called in the same words for both versions."""

    def __init__(self, path: Path, version: str, kind: str, name: str = "one", engine: str = _ENGINE, **options: object) -> None:
        self.version, self.kind = version, kind
        self.description = fmpy.read_model_description(str(fmu_of(path, version, engine)))
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        self.elements = {label: (v.name, k, prod(v.shape)) for v in self.description.modelVariables if v.shape
                         for k, label in enumerate(labels(v.name, v.shape))}
        interface = self.description.coSimulation if kind == "CoSimulation" else self.description.modelExchange
        module = fmpy.fmi2 if version == "2" else fmpy.fmi3
        cls = getattr(module, f"FMU{version}{'Slave' if kind == 'CoSimulation' else 'Model'}")
        token = self.description.guid or self.description.instantiationToken
        self.fmu = cls(guid=token, modelIdentifier=interface.modelIdentifier,
                       unzipDirectory=str(unpacked(path, version, engine)), instanceName=name)
        self.fmu.instantiate(**options)
        self.has_begun = False

    def start(self, values: dict[str, float] | None = None, tolerance: float = 1e-8, begin: float = 0.0) -> "Instance":
        self.has_begun = False
        self.set(values or {})
        if self.version == "2":
            self.fmu.setupExperiment(tolerance=tolerance, startTime=begin)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=begin)
        self.fmu.exitInitializationMode()
        self.has_begun = True
        if self.kind == "ModelExchange":
            self.update()
            self.fmu.enterContinuousTimeMode()
        return self

    def update(self) -> tuple:
        """needs another, terminates, nominals changed, values changed, next event defined, next event."""
        return self.fmu.newDiscreteStates() if self.version == "2" else self.fmu.updateDiscreteStates()

    def get(self, *names: str) -> list[float]:
        """Numbers: arrays, which FMI 3 has, by their elements."""
        if self.version == "2":
            return list(self.fmu.getReal([self.reference[name] for name in names]))
        return [self.whole(self.elements[name][0])[self.elements[name][1]] if name in self.elements
                else self.fmu.getFloat64([self.reference[name]])[0] for name in names]

    def whole(self, name: str) -> list[float]:
        """Of an array."""
        size = next(count for array, _, count in self.elements.values() if array == name)
        return list(self.fmu.getFloat64([self.reference[name]], nValues=size))

    def _present(self, array: str) -> list[float]:
        """Of what is to be set: its start until it is initialised, when nothing can be read."""
        (variable,) = (v for v in self.description.modelVariables if v.name == array)
        return self.whole(array) if self.has_begun else [float(text) for text in variable.start.split()]

    def set(self, values: dict[str, float]) -> None:
        arrays: dict[str, list[float]] = {}
        for name in [*values]:
            if name in self.elements:
                array, place, _ = self.elements[name]
                arrays.setdefault(array, self._present(array))[place] = values[name]
        scalars = {name: value for name, value in values.items() if name not in self.elements}
        numbers = [*scalars.values(), *(x for own in arrays.values() for x in own)]
        references = [self.reference[name] for name in (*scalars, *arrays)]
        if references:
            (self.fmu.setReal if self.version == "2" else self.fmu.setFloat64)(references, numbers)

    def step(self, t: float, h: float) -> object:
        return self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def forward(self, unknowns: list[str], knowns: list[str], seed: list[float]) -> list[float]:
        of, by = self._arrays(unknowns), self._arrays(knowns)
        found = self.fmu.getDirectionalDerivative(*self._at(of, by), self._seed(by, knowns, seed), **self._size(of))
        return self._taken(of, unknowns, found)

    def _arrays(self, names: list[str]) -> dict[str, int]:
        """The whole variables, and how many numbers each is."""
        found = [self.elements.get(name, (name, 0, 1)) for name in names]
        return {name: size for name, _, size in found}

    def _at(self, *of: dict[str, int]) -> list[list[int]]:
        return [[self.reference[name] for name in whole] for whole in of]

    def _size(self, of: dict[str, int]) -> dict[str, int]:
        return {} if self.version == "2" else {"nSensitivity": sum(of.values())}

    def _places(self, of: dict[str, int], names: list[str]) -> list[int]:
        first = dict(zip(of, np.cumsum([0, *of.values()]).tolist(), strict=False))
        return [first[whole] + k for whole, k, _ in (self.elements.get(name, (name, 0, 1)) for name in names)]

    def _seed(self, of: dict[str, int], names: list[str], seed: list[float]) -> list[float]:
        whole = np.zeros(sum(of.values()))
        np.add.at(whole, self._places(of, names), seed)
        return whole.tolist()

    def _taken(self, of: dict[str, int], names: list[str], values: list[float]) -> list[float]:
        return [list(values)[k] for k in self._places(of, names)]

    def adjoint(self, unknowns: list[str], knowns: list[str], seed: list[float]) -> list[float]:
        of, by = self._arrays(unknowns), self._arrays(knowns)
        found = self.fmu.getAdjointDerivative(*self._at(of, by), self._seed(of, unknowns, seed), **self._size(by))
        return self._taken(by, knowns, found)

    def state_names(self) -> list[str]:
        """Of numbers, in the order of the vector of states."""
        states = [u.variable.derivative for u in self.description.derivatives]
        return [label for state in states for label in labels(state.name, state.shape)]

    def unknown_names(self) -> list[str]:
        """Of derivatives, then of outputs, by their numbers."""
        rows = [u.variable for u in (*self.description.derivatives, *self.description.outputs)]
        return [label for row in rows for label in labels(row.name, row.shape)]

    def input_names(self) -> list[str]:
        return [label for v in self.description.modelVariables if v.causality == "input" for label in labels(v.name, v.shape)]

    def states(self) -> list[float]:
        return self.get(*self.state_names())

    def set_states(self, x: list[float]) -> None:
        buffer = np.array(x, dtype=float)
        pointer = buffer.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self.fmu.setContinuousStates(pointer, len(buffer))

    def slopes(self) -> np.ndarray:
        buffer = np.zeros(self.description.numberOfContinuousStates)
        pointer = buffer.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        (self.fmu.getDerivatives if self.version == "2" else self.fmu.getContinuousStateDerivatives)(pointer, len(buffer))
        return buffer

    def free(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
