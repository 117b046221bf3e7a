"""Many runs of one model in C, seen from Python: runtime/run/batch.h and reduce.h field by field.

While a batch advances the interpreter is free (ctypes lets go of its lock), so that one thread a core is enough.
"""

import ctypes as c
import math
from collections.abc import Mapping, Sequence
from enum import IntEnum
from functools import cache
from types import TracebackType
from typing import TYPE_CHECKING, Any, NamedTuple, Self

from lagrangia.base.records import dataclass
from lagrangia.run.library import Runtime
from lagrangia.run.mirrors import Mirrored, check_mirrors
from lagrangia.run.runtime import Model, Run, Settings

if TYPE_CHECKING:
    import numpy as np

_DOUBLES = c.POINTER(c.c_double)
_INTS = c.POINTER(c.c_int)
ABREAST = 8  # runs that go on together: LAG_ABREAST of wide.h


class Kind(IntEnum):
    """LAG_REDUCE_... of reduce.h."""

    AT = 0
    MIN = 1
    MAX = 2
    TIME_OF_MIN = 3
    TIME_OF_MAX = 4
    RANGE = 5
    OVERSHOOT = 6
    MEAN = 7
    RMS = 8
    INTEGRAL = 9
    FIRST_ABOVE = 10
    FIRST_BELOW = 11
    LAST_ABOVE = 12
    LAST_BELOW = 13
    COUNT_ABOVE = 14
    COUNT_BELOW = 15
    DURATION_ABOVE = 16
    DURATION_BELOW = 17
    PERIOD_ABOVE = 18
    PERIOD_BELOW = 19
    PERIOD = 20
    SETTLING = 21
    DAMAGE = 22
    PEAK_FREQUENCY = 23
    PEAK_AMPLITUDE = 24


class Ending(IntEnum):
    """LAG_RUN_... of batch.h; NOT_RUN stands for a run that has had no turn yet."""

    NOT_RUN = -1
    DONE = 0
    FAILED = 1
    PARAMETER = 2
    OVERTIME = 3
    OPEN = 4


@dataclass(frozen=True)
class Reduction:
    """One number of a motion: what of which column of a row, its absolute value or not, between the times `start` and `end`.

    `value` is a time, a level, a share or an exponent, see reduce.h. `rate` is the column of the quantity's rate, where there is
    one: then most steps need no closer look.
    """

    kind: Kind
    column: int
    absolute: bool = False
    value: float = 0.0
    rate: int = -1
    or_equal: bool = False  # the condition holds at the level, too; of AT: at the end of a run that ends before
    start: float = -math.inf  # s
    end: float = math.inf
    size: float = 1.0  # by which ranges of cycles are divided
    keeps_cycles: bool = False


@dataclass(frozen=True)
class Sweep:
    """What a batch does; see LagSweep."""

    settings: Settings
    window: float  # s
    seconds: float  # s of wall time a run may take, 0: no limit
    reductions: Sequence[Reduction]
    varied: Sequence[int]  # parameter k, n_parameters + k for (q, v)[k]; behind them input k, held, and the number of a case
    given: Sequence[float]
    mask: Sequence[float]
    start: Sequence[float]
    least: Sequence[float]
    most: Sequence[float]
    input_times: Sequence[float] = ()
    input_values: Sequence[float] = ()
    input_cases: Sequence[tuple[Sequence[float], Sequence[float]]] = ()  # times and values, of which a run has one
    is_driven: bool = False  # something is moved in time, and may bring energy whatever the steps
    row_times: Sequence[float] = ()  # s: whole rows that are kept of each run
    in_lanes: bool = False  # runs may go on together, eight a core, where that serves


class Lanes(NamedTuple):
    """Runs that ended in lanes, those that were begun there and made alone after all; steps of both, and what there was room
    for; how often runs left their lanes for events."""

    runs: int = 0
    alone: int = 0
    steps: int = 0
    room: int = 0
    left: int = 0

    def plus(self, other: "Lanes") -> "Lanes":
        """Both together."""
        return Lanes(*(a + b for a, b in zip(self, other, strict=True)))


class _Reduction(c.Structure):
    _fields_ = (("kind", c.c_int32), ("column", c.c_int32), ("rate", c.c_int32), ("absolute", c.c_int32), ("value", c.c_double),
                ("size", c.c_double), ("centre", c.c_double), ("from", c.c_double), ("to", c.c_double),
                ("or_equal", c.c_int32), ("keeps_cycles", c.c_int32))


class _Cycle(c.Structure):
    _fields_ = (("range", c.c_double), ("mean", c.c_double), ("count", c.c_double))


class _Sweep(c.Structure):
    _fields_ = (
        ("t_start", c.c_double), ("t_stop", c.c_double), ("window", c.c_double), ("seconds", c.c_double),
        ("n_reductions", c.c_int), ("reductions", c.POINTER(_Reduction)),
        ("n_varied", c.c_int), ("varied", _INTS),
        ("given", _DOUBLES), ("mask", _DOUBLES), ("start", _DOUBLES), ("least", _DOUBLES), ("most", _DOUBLES),
        ("is_driven", c.c_int), ("in_lanes", c.c_int), ("n_rows", c.c_int), ("row_times", _DOUBLES),
    )  # fmt: skip


GUARD_BITS = 31  # LAG_GUARD_BITS of batch.h: `warned` is a bit for each guard, the last one for all beyond
# LagOutcome as a NumPy type: one record a run, in memory, on disk and between machines.
OUTCOME = [
    ("kind", "<i4"), ("warned", "<i4"), ("status", "<i4"), ("index", "<i4"), ("rate", "<i4"), ("padding2", "<i4"),
    ("time", "<f8"), ("value", "<f8"), ("steps", "<i8"), ("energy", "<f8"), ("methods", "<i8"),
]  # fmt: skip
MIRRORS: Mapping[str, Mirrored] = {
    "LagReduction": _Reduction, "LagSweep": _Sweep, "LagOutcome": OUTCOME, "LagCycle": _Cycle, "LAG_REDUCE": Kind,
    "LAG_RUN": Ending,
}  # fmt: skip


@cache
def outcome_type() -> "np.dtype[Any]":
    """LagOutcome, for arrays."""
    import numpy as np

    return np.dtype(OUTCOME)


@cache
def _declare(library: c.CDLL) -> None:
    check_mirrors(library, MIRRORS)
    library.lag_batch_new.restype, library.lag_batch_new.argtypes = c.c_void_p, (c.c_void_p, c.c_void_p, c.POINTER(_Sweep))
    library.lag_batch_free.restype, library.lag_batch_free.argtypes = None, (c.c_void_p,)
    library.lag_batch_cycles.restype = c.POINTER(_Cycle)
    library.lag_batch_cycles.argtypes = (c.c_void_p, c.c_int, c.POINTER(c.c_int64))
    library.lag_batch_lanes.restype, library.lag_batch_lanes.argtypes = None, (c.c_void_p, c.POINTER(c.c_int64))
    library.lag_batch_advance.restype = c.c_int64
    library.lag_batch_advance.argtypes = (c.c_void_p, c.c_int64, *(c.c_void_p,) * 5, c.POINTER(c.c_int32))


class Batch:
    """A run that is driven again and again; use it in a `with` statement, in one thread at a time."""

    def __init__(self, runtime: Runtime, model: Model, sweep: Sweep) -> None:
        self._library = runtime.library
        _declare(self._library)
        self.n_reductions, self.n_varied = len(sweep.reductions), len(sweep.varied)
        self._sweep, self._states = sweep, len(sweep.given) + len(sweep.start)
        varied = [place for place in sweep.varied if place < self._states]
        self._run = Run(self._library, model, sweep.settings)
        if sweep.input_values:
            self._run.set_inputs(sweep.input_times, sweep.input_values)
        reductions = (_Reduction * self.n_reductions)(
            *(_Reduction(int(r.kind), r.column, r.rate, int(r.absolute), r.value, r.size, 0.0, r.start, r.end, int(r.or_equal),
                         int(r.keeps_cycles)) for r in sweep.reductions))
        vectors = ((c.c_double * len(v))(*v) for v in (sweep.given, sweep.mask, sweep.start, sweep.least, sweep.most))
        struct = _Sweep(sweep.settings.t_start, sweep.settings.t_stop, sweep.window or math.inf, sweep.seconds,
                        self.n_reductions, reductions, len(varied), (c.c_int * len(varied))(*varied), *vectors,
                        int(sweep.is_driven), int(sweep.in_lanes), len(sweep.row_times),
                        (c.c_double * len(sweep.row_times))(*sweep.row_times))
        self.n_rows = len(sweep.row_times)
        self._batch: int | None = self._library.lag_batch_new(c.byref(model.struct), self._run.handle, c.byref(struct))
        if not self._batch:
            self._run.close()
            raise MemoryError("no memory for a run of this model")

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    def close(self) -> None:
        """Frees what C holds."""
        self._library.lag_batch_free(self._batch)
        self._batch = None
        self._run.close()

    def advance(self, values: "np.ndarray", stop: Any = None, held: "np.ndarray | None" = None,
                rows: "np.ndarray | None" = None) -> "tuple[np.ndarray, np.ndarray, np.ndarray]":
        """values (runs, n_varied) -> results (done, n_reductions), outcomes (done,) and rows (done, row_times, width), which are
        put into `rows` where that is given. `held`: (runs, row_times - 1, inputs) from each row to the next.

        All are done unless `stop` (a ctypes c_int32) is set to 1 by another thread meanwhile.
        """
        import numpy as np

        values = np.ascontiguousarray(values, dtype=np.float64)
        runs = len(values)
        if values.shape != (runs, self.n_varied):
            raise ValueError(f"values of the shape {(runs, self.n_varied)} are needed, not {values.shape}")
        results, outcomes = np.empty((runs, self.n_reductions)), np.zeros(runs, dtype=outcome_type())
        rows = np.empty((runs, self.n_rows, self._run.width)) if rows is None else rows
        stopped = stop if stop is not None else c.c_int32(0)
        is_input = np.array(self._sweep.varied, dtype=int) >= self._states
        own = np.ascontiguousarray(values[:, ~is_input])
        first = 0
        for last in self._changes(values[:, is_input]):
            if is_input.any():
                self._set_inputs(values[first, is_input].tolist())
            u = None if held is None else held[first:].ctypes.data
            told = (array[first:].ctypes.data for array in (results, outcomes, rows))
            values_from = own[first:].ctypes.data
            done = self._library.lag_batch_advance(self._batch, last - first, values_from, u, *told, c.byref(stopped))
            if done < last - first:
                return results[: first + done], outcomes[: first + done], rows[: first + done]
            first = last
        return results, outcomes, rows

    @staticmethod
    def _changes(inputs: "np.ndarray") -> list[int]:
        """The ends of runs one after another that have the same inputs."""
        import numpy as np

        if not inputs.size:
            return [len(inputs)] if len(inputs) else []
        return [*(np.flatnonzero((inputs[1:] != inputs[:-1]).any(axis=1)) + 1).tolist(), len(inputs)]

    def _set_inputs(self, values: Sequence[float]) -> None:
        """Those of the next runs: a case, and single ones that are held."""
        import numpy as np

        sweep = self._sweep
        places = [place - self._states for place in sweep.varied if place >= self._states]
        chosen = dict(zip(places, values, strict=True))
        count = len(sweep.input_values) // len(sweep.input_times)
        times, table = (sweep.input_times, sweep.input_values) if count not in chosen else sweep.input_cases[int(chosen[count])]
        rows = np.array(table, dtype=float).reshape(len(times), count)
        for place, value in chosen.items():
            if place < count:
                rows[:, place] = value
        self._run.set_inputs(times, rows.ravel().tolist())

    @property
    def lanes(self) -> Lanes:
        """How full they were so far."""
        counts = (c.c_int64 * len(Lanes._fields))()
        self._library.lag_batch_lanes(self._batch, counts)
        return Lanes(*counts)

    def cycles(self, reduction: int) -> "np.ndarray":
        """Of the latest run, by a reduction that keeps them: (cycles, 3), range, mean and count (1 or 1/2) of each."""
        import numpy as np

        count = c.c_int64(0)
        place = self._library.lag_batch_cycles(self._batch, reduction, c.byref(count))
        if not count.value:
            return np.empty((0, 3))
        return np.array(np.ctypeslib.as_array(c.cast(place, _DOUBLES), (count.value, 3)))
