"""What a communication step of an FMU costs beside the native run: 1 000 steps of 1 ms of the double pendulum at 1e-6.

    python tests/benchmarks/fmu_steps.py [--scene NAME] [--repeats N] [--engine native|tape]

Both are called from a loop in C: fmiDoStep of the binary in the FMU, and lag_run_advance for the 1 000 times at once. Then the
same with the states read by fmiGetReal after each step. Initialisation is not counted, in neither. The ways take turns, and the
shortest of many times counts: others only add to it.
"""

import argparse
import ctypes
from collections.abc import Callable
from pathlib import Path
from tempfile import TemporaryDirectory

import fmpy
import fmpy.fmi2
import fmpy.fmi3

import lagrangia as lag
from lagrangia.fmu.build import host_platform
from lagrangia.fmu.export import Export, export_fmu
from lagrangia.native.build import build
from lagrangia.run.engines import load_engine
from lagrangia.run.runtime import Settings

EXAMPLES = Path(__file__).resolve().parents[2] / "models" / "examples"
STEPS, H, TOLERANCE = 1000, 1e-3, 1e-6
CLOCK = """
#define _POSIX_C_SOURCE 199309L
#include <stdbool.h>
#include <stddef.h>
#include <time.h>

typedef int DoStep2(void *c, double t, double h, int flag);
typedef int DoStep3(void *c, double t, double h, bool flag, bool *event, bool *stops, bool *early, double *last);
typedef int Get2(void *c, const unsigned *r, size_t n, double *v);
typedef int Get3(void *c, const unsigned *r, size_t n, double *v, size_t m);
typedef int Advance(void *run, const double *times, int rows, double *results, int *done, double seconds);
#define EXPORTED __attribute__((visibility("default")))

static double now(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

/* Seconds of all steps, with n values read after each of them; -1 when one of them failed. */
EXPORTED double clock_fmi2(DoStep2 *step, Get2 *get, void *c, double h, int steps, const unsigned *r, size_t n, double *v);
EXPORTED double clock_fmi3(DoStep3 *step, Get3 *get, void *c, double h, int steps, const unsigned *r, size_t n, double *v);
EXPORTED double clock_native(Advance *advance, void *run, const double *times, int rows, double *results);

double clock_fmi2(DoStep2 *step, Get2 *get, void *c, double h, int steps, const unsigned *r, size_t n, double *v)
{
    const double begin = now();
    int worst = 0;
    for (int k = 0; k < steps; ++k) {
        worst |= step(c, k * h, h, 1);
        if (n > 0)
            worst |= get(c, r, n, v);
    }
    return worst ? -1 : now() - begin;
}

double clock_fmi3(DoStep3 *step, Get3 *get, void *c, double h, int steps, const unsigned *r, size_t n, double *v)
{
    const double begin = now();
    int worst = 0;
    for (int k = 0; k < steps; ++k) {
        bool event, stops, early;
        double last;
        worst |= step(c, k * h, h, true, &event, &stops, &early, &last);
        if (n > 0)
            worst |= get(c, r, n, v, n);
    }
    return worst ? -1 : now() - begin;
}

double clock_native(Advance *advance, void *run, const double *times, int rows, double *results)
{
    const double begin = now();
    int done = 0;
    return advance(run, times, rows, results, &done, 0) != 0 || done != rows ? -1 : now() - begin;
}
"""
Way = Callable[[], float]


def pointer(function: object) -> ctypes.c_void_p:
    return ctypes.cast(function, ctypes.c_void_p)  # type: ignore[arg-type]


class Fmu:
    """One instance, reset before each run."""

    def __init__(self, clock: ctypes.CDLL, folder: Path, version: str) -> None:
        self.version, self.clock = version, getattr(clock, f"clock_fmi{version}")
        description = fmpy.read_model_description(str(folder))
        cls = fmpy.fmi2.FMU2Slave if version == "2" else fmpy.fmi3.FMU3Slave
        self.fmu = cls(guid=description.guid, unzipDirectory=str(folder), instanceName="one",
                       modelIdentifier=description.coSimulation.modelIdentifier)
        self.fmu.instantiate()
        states = [u.variable.derivative.valueReference for u in description.derivatives]
        self.references = (ctypes.c_uint * len(states))(*states)
        get = "fmi2GetReal" if version == "2" else "fmi3GetFloat64"
        self.functions = [pointer(getattr(self.fmu.dll, name)) for name in (f"fmi{version}DoStep", get)]

    def seconds(self, values: int) -> float:
        fmu = self.fmu
        fmu.reset()
        if self.version == "2":
            fmu.setupExperiment(tolerance=TOLERANCE)
            fmu.enterInitializationMode()
        else:
            fmu.enterInitializationMode(tolerance=TOLERANCE)
        fmu.exitInitializationMode()
        room = (ctypes.c_double * max(1, len(self.references)))()
        return float(self.clock(*self.functions, ctypes.c_void_p(fmu.component), ctypes.c_double(H), STEPS, self.references,
                                ctypes.c_size_t(min(values, len(self.references))), room))


def native_way(clock: ctypes.CDLL, model: lag.Model) -> Way:
    engine = load_engine(model.scene, native=True)
    assert engine is not None, "this benchmark needs a C compiler"
    times = (ctypes.c_double * STEPS)(*(H * (k + 1) for k in range(STEPS)))
    advance = pointer(engine.runtime.library.lag_run_advance)

    def seconds() -> float:
        with engine.runtime.run(engine.model, Settings(0.0, H * STEPS, TOLERANCE, 0.0, 0.0, 0, 0)) as run:
            run.set_parameters()
            run.start()
            rows = (ctypes.c_double * (STEPS * run.width))()
            return float(clock.clock_native(advance, ctypes.c_void_p(run.handle), times, STEPS, rows))

    return seconds


def measure(scene: str, repeats: int, engine: str) -> dict[str, float]:
    """Shortest time of each way, in s."""
    clock = ctypes.CDLL(str(build("fmu_clock", CLOCK)))
    for name in ("clock_fmi2", "clock_fmi3", "clock_native"):
        getattr(clock, name).restype = ctypes.c_double
    model = lag.load(EXAMPLES / f"{scene}.lag")
    with TemporaryDirectory() as folder:
        ways: dict[str, Way] = {"native": native_way(clock, model)}
        for version in ("2", "3"):
            path = Path(folder) / f"{version}.fmu"
            export_fmu(model, Export(version, platforms=(host_platform() or "host",), engine=engine), path)
            fmu = Fmu(clock, Path(fmpy.extract(str(path))), version)
            ways[f"FMI {version}"] = lambda fmu=fmu: fmu.seconds(0)  # type: ignore[misc]
            ways[f"FMI {version}, states read"] = lambda fmu=fmu: fmu.seconds(99)  # type: ignore[misc]
        times: dict[str, list[float]] = {name: [] for name in ways}
        for _ in range(repeats):
            for name, way in ways.items():
                times[name].append(way())
        assert min(map(min, times.values())) > 0, "a step failed"
    return {name: min(found) for name, found in times.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--scene", default="double_pendulum")
    parser.add_argument("--repeats", type=int, default=300)
    parser.add_argument("--engine", choices=("native", "tape"), default="native", help="of the FMUs")
    options = parser.parse_args()
    found = measure(options.scene, options.repeats, options.engine)
    for name, seconds in found.items():
        ratio = seconds / found["native"]
        print(f"{name:22} {1e6 * seconds:8.1f} us for {STEPS} steps of {H:g} s, {ratio:.2f} times the native run")


if __name__ == "__main__":
    main()
