"""The C run time, seen from Python: models as libraries or tapes, and runs.

The structures mirror runtime/*.h field by field. Only the standard library is used, so that a scene that was compiled
before starts at once; numpy arrays are welcome wherever a buffer of doubles is.
"""

import ctypes as c
import math
from array import array
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import field
from enum import IntEnum
from mmap import mmap
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from lagrangia.base.records import dataclass
from lagrangia.base.table_data import TableData
from lagrangia.native.tapes import JetOp, Op, Tape
from lagrangia.run.choice import Choice, Decision, Facts, Rule, told
from lagrangia.run.mirrors import Mirrored, check_mirrors
from lagrangia.run.model_mirror import FUNCTIONS, Doubles, FunctionMirror, Ints, ModelMirror, TableMirror, TapeMirror, mirrored


class Status(IntEnum):
    """LagStatus of status.h."""

    OK = 0
    PAUSED = 1
    STEP_TOO_SMALL = 2
    NOT_FINITE = 3
    INITIAL_FAILED = 4
    TOO_MANY_STEPS = 5
    TIME_PASSED = 6
    PAST_STOP = 7
    NOT_STARTED = 8
    BAD_SETTINGS = 9
    BAD_INPUTS = 10
    OUT_OF_MEMORY = 11
    EVENTS_GO_ON = 12
    NO_IMPULSE = 13
    CONSTRAINTS_OPEN = 14
    NO_PROGRESS = 15
    WANTS_JACOBIAN = 16
    TABLE_ENDED = 17
    INPUT_JUMPS = 18
    TURNED_OFF = 19
    BAD_INTERVAL = 20
    BAD_DELAY = 21
    ASSERTED = 22
    ENDED = 23


_STATUS = tuple(Status)
GUARDED = (Status.ASSERTED, Status.ENDED)
_ZERO = array("d", (0.0,))
_LARGE = 1 << 17  # numbers of rows
_OF_CHOICE = {"rule", "chosen", "facts"}


class Solver(IntEnum):
    """LAG_SOLVER_... of settings.h."""

    AUTO = 0
    ERK = 1
    LINEAR = 2
    IMPLICIT = 3
    ISLANDS = 4
    CONSERVATIVE = 5
    TAYLOR = 6
    ERK5 = 7
    ADAMS = 8
    STEPWISE = 9
    TRANSITION = 10
    ORBIT = 11
    ERK9 = 12
    PIRK = 13


@dataclass(frozen=True)
class Settings:
    """Limits of a run; 0 stands for "none" or "automatic"."""

    t_start: float = 0.0
    t_stop: float = math.inf
    tolerance: float = 1e-8
    max_step: float = 0.0
    first_step: float = 0.0
    max_steps: int = 0
    solver: Solver = Solver.AUTO


@dataclass(frozen=True)
class Statistics:
    """What a run has done so far; `worst` counts positions 0 … n-1, then rates."""

    steps: int
    rejected: int
    rhs_evaluations: int
    dense_outputs: int
    events: int
    smallest_step: float
    largest_step: float
    energy_residual: float
    energy_scale: float
    worst: int
    tolerance_raised: bool
    tolerance_missed: int = 0
    projections: int = 0
    constraint_residual: float = 0.0
    constraint_rate_residual: float = 0.0
    solver: Solver = Solver.ERK
    switches: int = 0
    implicit_steps: int = 0
    jacobians: int = 0
    factorisations: int = 0
    energy_stored: float = 0.0
    energy_risen: float = 0.0
    energy_given: float = 0.0
    passed: int = 0
    jammed: int = 0
    jam_time: float = 0.0
    unsure: int = 0
    unsure_output: int = 0
    unsure_time: float = 0.0
    energy_open: float = 0.0
    energy_rounding: float = 0.0
    energy_is_open: bool = False
    steps_by: tuple[int, ...] = ()  # of them all, those of each solver, by its number
    choice: Choice = field(default_factory=Choice)  # the row that decided last which solver goes on

    @property
    def energy_size(self) -> float:
        """What the residual of the account is measured by, J."""
        return max(self.energy_scale, self.energy_stored)


@dataclass(frozen=True)
class Failure:
    """Why, where and when a run stopped: `index` of a coordinate (its rate when `rate`) or of an initial equation."""

    status: Status
    index: int
    rate: bool
    time: float
    value: float
    seen: tuple[float, ...] = ()  # what the conditions of guards compare there, where one of them ends the run


@dataclass(slots=True)
class Rows:
    """Rows of results, one after another in `values`: t, q, v, y, T, V, H, dissipated, work."""

    status: Status
    width: int
    count: int
    values: "array[float]"

    def __getitem__(self, row: int) -> "array[float]":
        if not 0 <= row < self.count:
            raise IndexError(row)
        return self.values[row * self.width : (row + 1) * self.width]


class _Settings(c.Structure):
    _fields_ = (
        ("t_start", c.c_double),
        ("t_stop", c.c_double),
        ("tolerance", c.c_double),
        ("max_step", c.c_double),
        ("first_step", c.c_double),
        ("max_steps", c.c_int64),
        ("solver", c.c_int32),
    )


class _Statistics(c.Structure):
    _fields_ = (
        ("steps", c.c_int64),
        ("rejected", c.c_int64),
        ("rhs_evaluations", c.c_int64),
        ("dense_outputs", c.c_int64),
        ("events", c.c_int64),
        ("projections", c.c_int64),
        ("implicit_steps", c.c_int64),
        ("jacobians", c.c_int64),
        ("factorisations", c.c_int64),
        ("smallest_step", c.c_double),
        ("largest_step", c.c_double),
        ("energy_residual", c.c_double),
        ("energy_scale", c.c_double),
        ("energy_stored", c.c_double),
        ("energy_risen", c.c_double),
        ("energy_given", c.c_double),
        ("energy_open", c.c_double),
        ("energy_rounding", c.c_double),
        ("unsure_time", c.c_double),
        ("jam_time", c.c_double),
        ("constraint_residual", c.c_double),
        ("constraint_rate_residual", c.c_double),
        *((name, c.c_int32) for name in ("worst", "tolerance_raised", "tolerance_missed", "solver", "switches", "energy_is_open",
                                         "passed", "jammed", "unsure", "unsure_output", "rule", "chosen")),
        ("steps_by", c.c_int64 * (max(Solver) + 1)),
        ("facts", Facts),
    )


class _Failure(c.Structure):
    _fields_ = (("status", c.c_int32), ("index", c.c_int32), ("rate", c.c_int32), ("time", c.c_double), ("value", c.c_double))


# By their names in runtime/run/layout.c.
MIRRORS: Mapping[str, Mirrored] = {
    "LagTape": TapeMirror, "LagTable": TableMirror,
    "LagFunction": FunctionMirror, "LagModel": ModelMirror, "LagSettings": _Settings, "LagStatistics": _Statistics,
    "LagFacts": Facts, "LagDecision": Decision, "LagRule": Rule,
    "LagFailure": _Failure, "LagStatus": Status, "LAG_SOLVER": Solver, "LagOp": Op, "LagJetOp": JetOp,
}  # fmt: skip
_RUN = c.c_void_p
_SIGNATURES: Mapping[str, tuple[Any, tuple[Any, ...]]] = {
    "lag_read_numbers": (c.c_int64, (c.c_char_p, c.c_int, c.c_int, c.c_int, Doubles, c.c_int64)),
    "lag_table_slopes": (None, (c.POINTER(TableMirror), c.c_int, Doubles, Doubles)),
    "lag_tape_valid": (c.c_int, (c.POINTER(FunctionMirror),)),
    "lag_tape_run": (None, (c.POINTER(TapeMirror), c.c_void_p, c.c_void_p, Doubles)),
    "lag_run_new": (_RUN, (c.POINTER(ModelMirror), c.POINTER(_Settings))),
    "lag_run_solver": (c.c_int32, (c.POINTER(ModelMirror), c.POINTER(_Settings), c.POINTER(Decision))),
    "lag_rule": (c.POINTER(Rule), (c.c_int32,)),
    "lag_run_free": (None, (_RUN,)),
    "lag_run_set_parameters": (c.c_int, (_RUN, c.c_void_p, c.c_void_p)),
    "lag_run_parameters": (Doubles, (_RUN,)),
    "lag_run_parameter_beyond": (c.c_int, (_RUN, c.c_void_p, c.c_void_p)),
    "lag_run_wrong_parameter": (c.c_int, (_RUN, c.c_void_p, c.c_void_p)),
    "lag_run_told_parameter": (c.c_int, (_RUN,)),
    "lag_run_set_inputs": (c.c_int, (_RUN, Doubles, Doubles, c.c_int)),
    "lag_run_set_lost": (None, (_RUN, Doubles)),
    "lag_run_start": (c.c_int, (_RUN, c.c_void_p, c.c_void_p)),
    "lag_run_set_stop": (None, (_RUN, c.c_double)),
    "lag_run_row_width": (c.c_int, (c.POINTER(ModelMirror),)),
    "lag_run_advance": (c.c_int, (_RUN, c.c_void_p, c.c_int, c.c_void_p, Ints, c.c_double)),
    "lag_run_advance_steps": (c.c_int, (_RUN, c.c_int, c.c_void_p, Ints, c.c_double)),
    "lag_run_steps": (c.c_int, (_RUN, c.c_double, c.c_double, c.c_int64, c.c_int, c.c_void_p, c.c_void_p, Ints, c.c_double)),
    "lag_snapshot_size": (c.c_size_t, (_RUN,)),
    "lag_snapshot_take": (None, (_RUN, c.c_void_p)),
    "lag_snapshot_restore": (c.c_int, (_RUN, c.c_char_p, c.c_size_t)),
    "lag_run_row": (c.c_int, (_RUN, Doubles)),
    "lag_run_time": (c.c_double, (_RUN,)),
    "lag_run_statistics": (c.POINTER(_Statistics), (_RUN,)),
    "lag_run_failure": (c.POINTER(_Failure), (_RUN,)),
    "lag_run_warning": (c.c_int, (_RUN, Doubles)),
    "lag_run_seen": (Doubles, (_RUN,)),
}


def _buffer(values: Any) -> Any:
    """A ctypes view or copy of doubles: buffers of doubles are not gone through one by one."""
    if values is None:
        return None
    try:
        view = memoryview(values)
        if view.format == "d" and view.c_contiguous:
            return (c.c_double * (view.nbytes // 8)).from_buffer_copy(view)
    except TypeError:
        pass
    return (c.c_double * len(values))(*values)


def _ints(values: Sequence[int]) -> Any:
    return (c.c_int * len(values))(*values)


class Model:
    """A LagModel, and whatever memory it points to."""

    def __init__(self, struct: ModelMirror, kept: object) -> None:
        self.struct = struct
        self._kept = kept

    @classmethod
    def from_library(cls, path: Path) -> Self:
        """The model that a compiled scene exports as `lag_model`."""
        library = c.CDLL(str(path))
        return cls(ModelMirror.in_dll(library, "lag_model"), library)

    @classmethod
    def from_tapes(
        cls,
        sizes: Mapping[str, int],
        functions: Mapping[str, Tape],
        coordinate_kind: Sequence[int],
        fixed: Sequence[int],
        event_kind: Sequence[int] = (),
        patterns: Mapping[str, Sequence[int]] | None = None,
        tables: Sequence[TableData] = (),
    ) -> Self:
        """A model from plain data. `sizes` has the names of LagModel's integers, those left out are 0; likewise `functions`.

        `patterns` are lists of places by the names of their members of LagModel.
        """
        struct = ModelMirror(coordinate_kind=_ints(coordinate_kind), fixed=_ints(fixed), event_kind=_ints(event_kind))
        for name, size in sizes.items():
            setattr(struct, name, size)
        for name, places in (patterns or {}).items():
            setattr(struct, name, _ints(places))
        for name, tape in functions.items():
            setattr(struct, name, function_of(tape))
        if tables:
            struct.tables = mirrored(tables)
        return cls(struct, tables)  # whose numbers stay where they are

    def check_tapes(self, runtime: c.CDLL) -> None:
        """Raises ValueError when a tape reaches outside its vectors or holds an unknown op."""
        for name in (*FUNCTIONS, "series"):
            function = getattr(self.struct, name)
            if function.tape and not runtime.lag_tape_valid(c.byref(function)):
                raise ValueError(f"the tape of {name!r} is not valid")

    def divided(self, islands: "Sequence[tuple[Sequence[int], Model]]") -> "Model":
        """The same model with its islands: their coordinates, and each as a model of its own."""
        struct = ModelMirror.from_buffer_copy(self.struct)
        places = (c.c_void_p * len(islands))(*(c.addressof(model.struct) for _, model in islands))
        struct.n_islands = len(islands)
        struct.island = _ints([k for coordinates, _ in islands for k in coordinates])
        struct.islands = c.addressof(places)
        return Model(struct, (self, islands, places))

    def adopt(self, other: "Model") -> None:
        """Calls the code of another model of the same scene from now on, where that has some; also in runs under way."""
        for name in FUNCTIONS:
            code = getattr(other.struct, name).code
            if code:
                getattr(self.struct, name).code = code
        for name in ("wide", "wide_whole", "wide_each", "wide_roots", "wide_energies", "taylor", "wide_taylor"):
            setattr(self.struct, name, getattr(other.struct, name))
        self._kept = (self._kept, other)


def function_of(tape: Tape) -> FunctionMirror:
    """As the run time has it."""
    code = bytes(memoryview(tape.code).cast("B"))
    numbers = (c.c_int32 * (len(code) // 4)).from_buffer_copy(code)
    constants = _buffer(tape.constants)
    struct = TapeMirror(len(numbers) // 4, len(constants), numbers, constants)
    return FunctionMirror(
        len(tape.in_sizes), len(tape.out_sizes), _ints(tape.in_sizes), _ints(tape.out_sizes), tape.n_work, None, c.pointer(struct)
    )


def load_runtime(path: Path) -> c.CDLL:
    """A library of the run time. Raises LagError L0707 when its structures are not those mirrored here."""
    library = c.CDLL(str(path))
    check_mirrors(library, MIRRORS)
    for name, (result, arguments) in _SIGNATURES.items():
        function = getattr(library, name)
        function.restype, function.argtypes = result, arguments
    return library


def first_choice(runtime: c.CDLL, model: Model, settings: Settings) -> Choice:
    """What a run with these settings begins with, and why."""
    decision = Decision()
    solver = runtime.lag_run_solver(c.byref(model.struct), c.byref(_plain(settings)), c.byref(decision))
    return told(runtime, decision.rule, solver, decision.facts)


def _plain(settings: Settings) -> _Settings:
    return _Settings(*(getattr(settings, name) for name, *_ in _Settings._fields_))


class Run:
    """A run of a model; use it in a `with` statement. Methods answer a Status; `failure` tells more."""

    def __init__(self, library: c.CDLL, model: Model, settings: Settings) -> None:
        self._library = library
        self._model = model
        self._run: int | None = self._library.lag_run_new(c.byref(model.struct), c.byref(_plain(settings)))
        if not self._run:
            raise MemoryError("no memory for a run of this model")
        self.width: int = self._library.lag_run_row_width(c.byref(model.struct))
        self.done = (c.c_int * 1)()  # rows of the latest call

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self.close()

    @property
    def handle(self) -> int | None:
        """The LagRun itself, for those who drive it in C."""
        return self._run

    def close(self) -> None:
        """Frees what C holds."""
        self._library.lag_run_free(self._run)
        self._run = None

    def set_parameters(self, given: Sequence[float] | None = None, mask: Sequence[float] | None = None) -> Status:
        """Values of all parameters, and a mask that is 1 where they count; without: all from their bindings."""
        return Status(self._library.lag_run_set_parameters(self._run, _buffer(given), _buffer(mask)))

    @property
    def parameters(self) -> list[float]:
        """Their values as C has them, with those that follow from others."""
        return list(self._library.lag_run_parameters(self._run)[: self._model.struct.n_parameters])

    def set_inputs(self, times: Any, values: Any) -> Status:
        """A table of inputs: times[rows], values[rows * n_inputs] row by row; linear in between, held outside."""
        return Status(self._library.lag_run_set_inputs(self._run, _buffer(times), _buffer(values), len(times)))

    def set_lost(self, given: Sequence[float]) -> None:
        """Start values of the model's lost coordinates, then of their rates, NaN where nothing is given, for starts to come."""
        self._library.lag_run_set_lost(self._run, _buffer(given))

    def start(self, q: Sequence[float] | None = None, v: Sequence[float] | None = None) -> Status:
        """Find start values and evaluate once; NaN in q and v where nothing is given."""
        return Status(self._library.lag_run_start(self._run, _buffer(q), _buffer(v)))

    def set_stop(self, t_stop: float) -> None:
        """Moves the end of the run, s."""
        self._library.lag_run_set_stop(self._run, t_stop)

    def advance(self, times: Any, seconds: float = 0.0) -> Rows:
        """Rows at ascending times, as many as could be reached (within so many seconds of wall time, if not 0)."""
        if times.__class__ is not array or times.typecode != "d":
            times = array("d", times)
        done, most, size = self.done, len(times), len(times) * self.width
        if size > _LARGE:
            return self._few_of(times, size, seconds)
        values = _ZERO * size
        status = self._library.lag_run_advance(self._run, times.buffer_info()[0], most, values.buffer_info()[0], done, seconds)
        return self._rows(status, values, done[0])

    def _few_of(self, times: "array[float]", size: int, seconds: float) -> Rows:
        """The same of many numbers, of which a portion may reach a few: memory is touched where it is written."""
        done, first = self.done, c.c_char.from_buffer(memory := mmap(-1, 8 * size))
        status = self._library.lag_run_advance(self._run, times.buffer_info()[0], len(times), c.addressof(first), done, seconds)
        values: array[float] = array("d")
        values.frombytes(memoryview(memory)[: 8 * done[0] * self.width])
        return self._rows(status, values, done[0])

    def advance_steps(self, most: int, seconds: float = 0.0) -> Rows:
        """Rows after each step, until t_stop or `most` of them."""
        values, done = _ZERO * (most * self.width), self.done
        status = self._library.lag_run_advance_steps(self._run, most, values.buffer_info()[0], done, seconds)
        return self._rows(status, values, done[0])

    def _rows(self, status: int, values: "array[float]", done: int) -> Rows:
        del values[done * self.width :]
        return Rows(_STATUS[status], self.width, done, values)

    def row(self) -> Rows:
        """The row of the present time."""
        values = array("d", bytes(8 * self.width))
        status = Status(self._library.lag_run_row(self._run, (c.c_double * self.width).from_buffer(values)))
        return Rows(status, self.width, int(status is Status.OK), values)

    @property
    def time(self) -> float:
        """The time reached, s."""
        return float(self._library.lag_run_time(self._run))

    @property
    def counts(self) -> _Statistics:
        """What C counts, as it stands at any moment."""
        found: _Statistics = self._library.lag_run_statistics(self._run).contents
        return found

    @property
    def energy_is_open(self) -> c.c_int32:
        """Whether the energy account is, at any moment."""
        return c.c_int32.from_buffer(self.counts, _Statistics.energy_is_open.offset)

    @property
    def statistics(self) -> Statistics:
        """What the run has done so far."""
        struct = self.counts
        values = {name: getattr(struct, name) for name, *_ in _Statistics._fields_ if name not in _OF_CHOICE}
        found = {name: bool(values[name]) for name in ("tolerance_raised", "energy_is_open")}
        choice = told(self._library, struct.rule, struct.chosen, struct.facts)
        return Statistics(**values | found | {"solver": Solver(struct.solver), "steps_by": tuple(struct.steps_by)}, choice=choice)

    @property
    def failure(self) -> Failure:
        """What went wrong, where and when; its status says whether anything did."""
        struct = self._library.lag_run_failure(self._run).contents
        status = Status(struct.status)
        seen = tuple(self._library.lag_run_seen(self._run)[: self._model.struct.n_seen]) if status in GUARDED else ()
        return Failure(status, struct.index, bool(struct.rate), struct.time, struct.value, seen)

    def warnings(self) -> Iterator[tuple[int, float]]:
        """Guards that warn and have broken since this was asked, by their places, and when they did so first, s."""
        time = (c.c_double * 1)()
        while broken := self._library.lag_run_warning(self._run, time):
            yield broken - 1, time[0]
