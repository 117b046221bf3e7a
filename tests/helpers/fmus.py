"""FMUs of scenes for the tests, each exported once in a session, and runs of them by FMPy."""

import ctypes
from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import fmpy.fmi2
import fmpy.fmi3
import numpy as np

import lagrangia as lag
from lagrangia.base.folders import data_folder
from lagrangia.fmu.build import host_platform
from lagrangia.fmu.export import Export, export_fmu
from lagrangia.native.prebuilt import find_fmu

EXAMPLES = Path(__file__).parents[2] / "models" / "examples"
EXPORTED = sorted(EXAMPLES.glob("*.lag"))
_FOLDER = TemporaryDirectory(prefix="lagrangia-fmus-")
_ENGINE = "tape" if find_fmu(data_folder("runtime"), "2") else "native"
VERSIONS, KINDS = ("2", "3"), ("CoSimulation", "ModelExchange")


@cache
def model_of(path: Path) -> lag.Model:
    return lag.load(path)


def reported(path: Path) -> list[str]:
    """Names of positions, as importers have them, and of outputs."""
    scene = model_of(path).scene
    return [c.name for c in (*scene.told_positions, *scene.own_outputs)]


def fmu_of(path: Path, version: str, engine: str = _ENGINE) -> Path:
    """For this machine alone, with sources; by the library that comes with the package, where it did."""
    return _exported(path, version, engine)


def unpacked(path: Path, version: str, engine: str = _ENGINE) -> Path:
    return _unpacked(path, version, engine)


@cache
def _exported(path: Path, version: str, engine: str) -> Path:
    target = Path(_FOLDER.name) / f"{path.stem}-{abs(hash(path))}-{version}-{engine}.fmu"
    export_fmu(model_of(path), Export(version, platforms=(host_platform() or "host",), engine=engine), target)
    return target


@cache
def _unpacked(path: Path, version: str, engine: str) -> Path:
    folder = fmu_of(path, version, engine).with_suffix("")
    fmpy.extract(str(fmu_of(path, version, engine)), str(folder))
    return folder


def simulated(path: Path, version: str, kind: str, names: list[str], **options: object) -> np.ndarray:
    scene = model_of(path).scene
    step = (scene.stop - scene.start) / 100
    settings = {"start_time": scene.start, "stop_time": scene.stop, "step_size": step, "output_interval": step,
                "relative_tolerance": 1e-8, "solver": "CVode"} | options
    return fmpy.simulate_fmu(str(unpacked(path, version)), fmi_type=kind, output=names, **settings)


def instance_of(path: Path, version: str, kind: str, name: str = "one") -> "Instance":
    return Instance(path, version, kind, name)


class Instance:
    """One instance of an FMU, called in the same words for both versions."""

    def __init__(self, path: Path, version: str, kind: str, name: str = "one", engine: str = _ENGINE, **options: object) -> None:
        self.version, self.kind = version, kind
        self.description = fmpy.read_model_description(str(fmu_of(path, version, engine)))
        self.reference = {v.name: v.valueReference for v in self.description.modelVariables}
        interface = self.description.coSimulation if kind == "CoSimulation" else self.description.modelExchange
        module = fmpy.fmi2 if version == "2" else fmpy.fmi3
        cls = getattr(module, f"FMU{version}{'Slave' if kind == 'CoSimulation' else 'Model'}")
        token = self.description.guid or self.description.instantiationToken
        self.fmu = cls(guid=token, modelIdentifier=interface.modelIdentifier,
                       unzipDirectory=str(unpacked(path, version, engine)), instanceName=name)
        self.fmu.instantiate(**options)

    def start(self, values: dict[str, float] | None = None, tolerance: float = 1e-8, begin: float = 0.0) -> "Instance":
        self.set(values or {})
        if self.version == "2":
            self.fmu.setupExperiment(tolerance=tolerance, startTime=begin)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=begin)
        self.fmu.exitInitializationMode()
        if self.kind == "ModelExchange":
            self.update()
            self.fmu.enterContinuousTimeMode()
        return self

    def update(self) -> tuple:
        """needs another, terminates, nominals changed, values changed, next event defined, next event."""
        return self.fmu.newDiscreteStates() if self.version == "2" else self.fmu.updateDiscreteStates()

    def get(self, *names: str) -> list[float]:
        references = [self.reference[name] for name in names]
        return list(self.fmu.getReal(references) if self.version == "2" else self.fmu.getFloat64(references))

    def set(self, values: dict[str, float]) -> None:
        references = [self.reference[name] for name in values]
        if references:
            (self.fmu.setReal if self.version == "2" else self.fmu.setFloat64)(references, list(values.values()))

    def step(self, t: float, h: float) -> object:
        return self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)

    def forward(self, unknowns: list[str], knowns: list[str], seed: list[float]) -> list[float]:
        at = [self.reference[name] for name in unknowns], [self.reference[name] for name in knowns]
        return list(self.fmu.getDirectionalDerivative(*at, seed))

    def adjoint(self, unknowns: list[str], knowns: list[str], seed: list[float]) -> list[float]:
        at = [self.reference[name] for name in unknowns], [self.reference[name] for name in knowns]
        return list(self.fmu.getAdjointDerivative(*at, seed, nSensitivity=len(knowns)))

    def states(self) -> list[float]:
        names = [u.variable.derivative.name for u in self.description.derivatives]
        return self.get(*names)

    def set_states(self, x: list[float]) -> None:
        buffer = np.array(x, dtype=float)
        pointer = buffer.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        self.fmu.setContinuousStates(pointer, len(buffer))

    def slopes(self) -> np.ndarray:
        buffer = np.zeros(len(self.description.derivatives))
        pointer = buffer.ctypes.data_as(ctypes.POINTER(ctypes.c_double))
        (self.fmu.getDerivatives if self.version == "2" else self.fmu.getContinuousStateDerivatives)(pointer, len(buffer))
        return buffer

    def free(self) -> None:
        self.fmu.terminate()
        self.fmu.freeInstance()
