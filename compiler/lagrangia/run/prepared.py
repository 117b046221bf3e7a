"""One run of a scene that is done again and again, from other starts and with other parameters."""

import math
import sys
import time
import weakref
from array import array
from collections.abc import Sequence
from ctypes import POINTER, addressof, c_double, cast
from typing import TYPE_CHECKING

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.run.engines import Engine
from lagrangia.run.request import Experiment, Values, check_parameters
from lagrangia.run.runtime import Statistics, Status
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import explain, fail_start, loss, progress_of, shortcomings, start_run

if TYPE_CHECKING:
    import numpy as np

_PAUSE = 0.1  # seconds between two looks at the keyboard
_ZERO = array("d", (0.0,))
_LARGEST = sys.float_info.max
_OK, _PAUSED = int(Status.OK), int(Status.PAUSED)


class PreparedRun:
    """Callable: the rows from these start values, with these parameters. For one thread at a time."""

    def __init__(self, scene: Scene, engine: Engine, experiment: Experiment, values: Values, initial: Sequence[str],
                 parameters: Sequence[str]) -> None:
        """`initial` and `parameters` are the names of what each call gives. Raises LagError, RunError."""
        known = {p.name: k for k, p in enumerate(scene.parameters)}
        started: list[int] = [_start_place(scene, name) for name in initial]
        varied = [known[name] for name in parameters]
        self.scene, self.experiment = scene, experiment
        self.columns = ("time", *(c.name for c in (*scene.coordinates, *scene.rates, *scene.outputs)), "T", "V", "H",
                        "dissipated", "work")
        self._turned = [self.columns.index(name) for name in scene.turned]
        self._engine, self._started, self._varied = engine, started, varied
        self._run = start_run(scene, engine, experiment, values)
        weakref.finalize(self, self._run.close)
        self._library, self._handle = engine.runtime.library, self._run.handle
        self._times = array("d", [t for portion in experiment.times() for t in portion])
        self._given = (c_double * len(values.parameters))(*values.parameters)
        self._mask = (c_double * len(values.mask))(*values.mask)
        for place in varied:
            self._mask[place] = 1.0
        self._start = (c_double * (2 * scene.n))(*values.q, *values.v)
        self._rates = cast(addressof(self._start) + 8 * scene.n, POINTER(c_double))
        limits = [(p.minimum, p.maximum) for p in scene.parameters]
        self._limits = [(-_LARGEST if a is None else a, _LARGEST if b is None else b) for a, b in limits]
        self._seconds = 0.0

    def __call__(self, start: Sequence[float] = (), parameters: Sequence[float] = ()) -> "np.ndarray":
        """Rows (times, columns), in the order of `columns`; values in SI units in the order in which their names were given.

        Raises LagError for values the scene cannot have, RunError when the run cannot go on.
        """
        import numpy as np

        begin = time.perf_counter()
        if len(start) != len(self._started) or len(parameters) != len(self._varied):
            fail("L0702", f"{len(self._started)} start values and {len(self._varied)} parameters are needed, "
                          f"not {len(start)} and {len(parameters)}")
        if not math.isfinite(sum(start)):
            self._refuse(start)
        for place, value in zip(self._started, start, strict=True):
            self._start[place] = value
        if parameters:
            self._set(parameters)
        if self._library.lag_run_start(self._handle, self._start, self._rates) != _OK:
            fail_start(self.scene, self._run.failure, self._run.parameters)
        values = self._advance()
        self._seconds = time.perf_counter() - begin
        if self._engine.upgrade is not None:
            self._engine.look(self._seconds, 0.0)
        rows = np.frombuffer(values).reshape(-1, self._run.width)
        rows[:, self._turned] = math.nan  # numbers that say nothing without what attitudes are counted from
        return rows

    @property
    def statistics(self) -> Statistics:
        """Of the latest run."""
        return self._run.statistics

    @property
    def warnings(self) -> list[str]:
        """What kept the latest run from its tolerance, in words; empty when nothing did."""
        progress = progress_of(self.scene, self.experiment, rows=len(self._times), time=self._run.time, seconds=self._seconds,
                               statistics=self._run.statistics)
        return [*filter(None, [loss(progress)]), *shortcomings(progress)]

    def _set(self, parameters: Sequence[float]) -> None:
        for place, value in zip(self._varied, parameters, strict=True):
            self._given[place] = value
        self._library.lag_run_set_parameters(self._handle, self._given, self._mask)
        found = self._library.lag_run_parameters(self._handle)[: len(self._limits)]
        if not all(a <= x <= b for x, (a, b) in zip(found, self._limits, strict=True)):
            check_parameters(self.scene, found)

    def _advance(self) -> "array[float]":
        count, width, done = len(self._times), self._run.width, self._run.done
        values = _ZERO * (count * width)
        times, place, reached = self._times.buffer_info()[0], values.buffer_info()[0], 0
        while reached < count:
            status = self._library.lag_run_advance(self._handle, times + 8 * reached, count - reached,
                                                   place + 8 * width * reached, done, _PAUSE)
            reached += done[0]
            if status == Status.ENDED:
                return values[: reached * width]
            if status not in (_OK, _PAUSED):
                raise RunError(explain(self.scene, self._run.failure, self._run.parameters))
        return values

    def _refuse(self, start: Sequence[float]) -> None:
        names = [c.name for c in (*self.scene.coordinates, *self.scene.rates)]
        for place, value in zip(self._started, start, strict=True):
            if not math.isfinite(value):
                fail("L0605", f"the initial value of '{names[place]}' must be a finite number, not {value}")


def _start_place(scene: Scene, name: str) -> int:
    slot = scene.slot(name)
    if name in scene.attitudes:
        fail("L0702", f"the attitude '{name}' is three numbers, 4 tan(angle/4) along the axis", None,
             f"prepare the run for its coordinates: {', '.join(scene.attitudes[name])}")
    if slot is None:
        fail("L0901", f"not supported yet: a prepared run from other starts of '{name}', which other coordinates give", None,
             "prepare it for the coordinates themselves, or call simulate")
    return slot
