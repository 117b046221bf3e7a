"""FMUs of scenes for the tests, each exported once in a session, and runs of them by FMPy."""

from functools import cache
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import numpy as np

import lagrangia as lag
from lagrangia.fmu import Export, export_fmu
from lagrangia.fmu_build import host_platform

EXAMPLES = Path(__file__).parent.parent / "models" / "examples"
_FOLDER = TemporaryDirectory(prefix="lagrangia-fmus-")
VERSIONS, KINDS = ("2", "3"), ("CoSimulation", "ModelExchange")


@cache
def model_of(path: Path) -> lag.Model:
    return lag.load(path)


@cache
def fmu_of(path: Path, version: str) -> Path:
    """For this machine alone, with sources."""
    target = Path(_FOLDER.name) / f"{path.stem}-{abs(hash(path))}-{version}.fmu"
    export_fmu(model_of(path), Export(version, platforms=(host_platform() or "host",)), target)
    return target


@cache
def unpacked(path: Path, version: str) -> Path:
    folder = fmu_of(path, version).with_suffix("")
    fmpy.extract(str(fmu_of(path, version)), str(folder))
    return folder


def simulated(path: Path, version: str, kind: str, names: list[str], **options: object) -> np.ndarray:
    scene = model_of(path).scene
    step = (scene.stop - scene.start) / 100
    settings = {"start_time": scene.start, "stop_time": scene.stop, "step_size": step, "output_interval": step,
                "relative_tolerance": 1e-8, "solver": "CVode"} | options
    return fmpy.simulate_fmu(str(unpacked(path, version)), fmi_type=kind, output=names, **settings)
