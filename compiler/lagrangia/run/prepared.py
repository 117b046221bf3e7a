"""One run of a scene that is done again and again, from other starts and with other parameters."""

import math
import time
import weakref
from array import array
from collections.abc import Callable, Iterable, Sequence
from ctypes import addressof, c_char, c_double, c_void_p, cast
from typing import TYPE_CHECKING, NoReturn

from lagrangia.base.diagnostics import RunError, fail
from lagrangia.run.called_tapes import CalledTape
from lagrangia.run.engines import Engine
from lagrangia.run.formulas import feel_masses
from lagrangia.run.remarks import warn_of_loss, warn_of_text
from lagrangia.run.request import Experiment, Values, check_parameters
from lagrangia.run.requirements import asks_for
from lagrangia.run.runtime import Statistics, Status
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import DOUBTFUL, Progress, explain, fail_start, loss, progress_of, shortcomings, start_run

if TYPE_CHECKING:
    import numpy as np

_PAUSE, _SOON = 0.1, 1e-3  # seconds between two looks at the keyboard; of runs before one for native code
_OK, _PAUSED = int(Status.OK), int(Status.PAUSED)


class PreparedRun:
    """Callable: the rows from these start values, with these parameters. For one thread at a time."""

    _uneven: "PreparedRun | None" = None  # in formulas for any masses, from when some call needs them
    _latest: "PreparedRun | None" = None  # that one, if it made the latest run

    def __init__(self, scene: Scene, engine: Engine, experiment: Experiment, values: Values, initial: Sequence[str],
                 parameters: Sequence[str], any_mass: Callable[[], tuple[Scene, Engine | None]]) -> None:
        """`initial` and `parameters` are the names of what each call gives; `any_mass`: the scene in formulas for any masses, and
        the run time with it. Raises LagError, RunError."""
        known = {p.name: k for k, p in enumerate(scene.parameters)}
        started: list[int] = [_start_place(scene, name) for name in initial]
        varied = [known[name] for name in parameters]
        import numpy as np

        self.scene, self.experiment, self._rows = scene, experiment, np.ndarray
        self.columns = ("time", *(c.name for c in (*scene.coordinates, *scene.rates, *scene.outputs)), "T", "V", "H",
                        "dissipated", "work")
        self._turned = _in_rows(self.columns.index(name) for name in scene.turned)
        self._engine, self._started, self._varied = engine, started, varied
        self._run = start_run(scene, engine, experiment, values)
        weakref.finalize(self, self._run.close)
        self._library, self._handle = engine.runtime.library, self._run.handle
        self._begin, self._go_on = self._library.lag_run_start, self._library.lag_run_advance  # looked up once
        self._times = array("d", [t for portion in experiment.times() for t in portion])
        self._first_time, self._shape = self._times.buffer_info()[0], (len(self._times), self._run.width)
        self._given = (c_double * len(values.parameters))(*values.parameters)
        self._mask = (c_double * len(values.mask))(*values.mask)
        for place in varied:
            self._mask[place] = 1.0
        self._start = (c_double * (2 * scene.n))(*values.q, *values.v)
        self._starts = (self._handle, addressof(self._start), addressof(self._start) + 8 * scene.n)  # numbers pass soonest
        place = cast(self._library.lag_run_parameters(self._handle), c_void_p).value or addressof(self._given)
        self._found = (c_double * len(values.parameters)).from_address(place)  # all parameters, as C has them
        self._unevenness = CalledTape(self._library, scene.unevenness, self._found) \
            if scene.unevenness is not None and feel_masses(scene, parameters) else None
        self._made = values, initial, parameters, any_mass
        self._counts = self._run.counts  # what C counts of the latest run
        self._asks_loss = min(scene.notes["thresholds"], default=math.inf) < experiment.tolerance
        self._oddness = self._ask_oddness()
        self._limits, self._kept = self._place_limits()
        self._is_over = False  # terminate(...) has ended the latest run
        self._seconds = self._untold = 0.0  # of the latest run, and what the engine does not know of yet
        self._told = time.thread_time()  # when it last was

    def __call__(self, start: Sequence[float] = (), parameters: Sequence[float] = ()) -> "np.ndarray":
        """Rows (times, columns), in the order of `columns`; values in SI units in the order in which their names were given.

        Raises LagError for values the scene cannot have, or whose formulas its solver cannot take: L0704 by "taylor" in a large
        scene where a mass is 0, or far from the others, as such a call has formulas of its own; RunError when the run cannot go
        on. Of rows that are no motion of the scene a RunWarning tells.
        """
        begin, self._is_over, self._latest = time.perf_counter(), False, None
        starts, varied = self._started, self._varied
        if len(start) != len(starts) or len(parameters) != len(varied):
            fail("L0702", f"{len(self._started)} start values and {len(self._varied)} parameters are needed, "
                          f"not {len(start)} and {len(parameters)}")
        if not math.isfinite(sum(start)):
            self._refuse(start)
        own = self._start
        for place, value in zip(starts, start):  # noqa: B905 (of one length, as was seen)
            own[place] = value
        if varied:
            self._set(parameters)
            if self._unevenness is not None and self._unevenness() != 0:
                self._latest = self._for_any_mass()
                return self._latest(start, parameters)
        if self._begin(*self._starts) != _OK:
            fail_start(self.scene, self._run.failure, self._run.parameters)
        rows = self._rows(self._shape)
        count = self._advance(addressof(c_char.from_buffer(rows.data)))
        self._seconds = time.perf_counter() - begin
        self._untold += self._seconds
        if self._untold > _SOON:
            self._tell()
        s = self._counts
        if s.energy_is_open or s.unsure or self._asks_loss or s.energy_residual > DOUBTFUL * s.energy_scale:
            warn_of_loss(self._progress())
        for columns in self._turned:
            rows[columns] = math.nan  # numbers that say nothing without what attitudes are counted from
        return rows if count == len(rows) else rows[:count].copy()

    def __reduce__(self) -> NoReturn:
        """It lies in the memory of its process. Raises TypeError, as pickle and copy expect."""
        raise TypeError("a prepared run cannot leave its process, nor be copied: send the model, and call prepare there")

    def _tell(self) -> None:
        """The engine has the processor time of the runs: not more than this thread had in all, which is asked for once for many
        runs, as that takes a microsecond."""
        if self._engine.upgrade is not None:
            before, self._told = self._told, time.thread_time()
            self._engine.look(max(min(self._untold, self._told - before), 0.0), 0.0)
        self._untold = 0.0

    @property
    def statistics(self) -> Statistics:
        """Of the latest run."""
        return (self._latest or self)._run.statistics

    @property
    def ended(self) -> str:
        """When terminate(...) has ended the latest run, and what it says; empty for one that went on to the end."""
        latest = self._latest or self
        return explain(latest.scene, latest._run.failure) if latest._is_over else ""

    @property
    def warnings(self) -> list[str]:
        """What kept the latest run from its tolerance, in words; empty when nothing did."""
        progress = (self._latest or self)._progress()
        return [*filter(None, [loss(progress)]), *shortcomings(progress)]

    def _progress(self) -> Progress:
        return progress_of(self.scene, self.experiment, rows=len(self._times), time=self._run.time, seconds=self._seconds,
                           statistics=self._run.statistics)

    def _set(self, parameters: Sequence[float]) -> None:
        given = self._given
        for place, value in zip(self._varied, parameters):  # noqa: B905 (of one length)
            given[place] = value
        self._set_parameters(*self._told_given)
        if self._find_wrong(*self._limits) >= 0:
            check_parameters(self.scene, self._found[:])
        if self._oddness is not None and self._oddness(self._handle) >= 0:
            self._tell_odd()

    def _place_limits(self) -> tuple[tuple[int | None, int, int], object]:
        """What asks for parameters that are beyond their limits, and what has to stay where that says."""
        limits = tuple((c_double * len(side))(*side) for side in self.scene.limits)
        self._set_parameters = self._library.lag_run_set_parameters
        self._told_given = self._handle, addressof(self._given), addressof(self._mask)
        self._find_wrong = self._library.lag_run_wrong_parameter if asks_for(self.scene, self._varied) else \
            self._library.lag_run_parameter_beyond
        return (self._handle, addressof(limits[0]), addressof(limits[1])), limits

    def _ask_oddness(self) -> Callable[..., int] | None:
        """What tells which inertia is of no body, or -1, where calls may make one so."""
        from lagrangia.run.odd_inertias import reached_inertias

        scene, found = self.scene, self._found
        self._inertias = [(one, slice(one[1], one[1] + math.prod(one[2]))) for one in reached_inertias(scene, self._varied)]
        self._odd = {name: found[its] for (name, _, _), its in self._inertias}  # the values that each was told with
        is_asked = self._inertias and "L0746" not in scene.notes["allowed"]
        return self._library.lag_run_told_parameter if is_asked else None

    def _tell_odd(self) -> None:
        """Of inertias that no body has, and which were told with other values, if at all."""
        from lagrangia.run.odd_inertias import told_odd_inertias

        for one, its in self._inertias:
            if (own := self._found[its]) != self._odd[one[0]]:
                for text in told_odd_inertias([one], self._found[:]):
                    self._odd[one[0]] = own
                    warn_of_text(self.scene, text)

    def _for_any_mass(self) -> "PreparedRun":
        if self._uneven is None:
            values, initial, parameters, any_mass = self._made
            scene, engine = any_mass()
            assert engine is not None  # as there is one of this scene
            self._uneven = PreparedRun(scene, engine, self.experiment, values, initial, parameters, any_mass)
            self._uneven._oddness = None  # of which this one tells
        return self._uneven

    def _advance(self, place: int) -> int:
        """Rows to where they belong; how many."""
        (count, width), done, reached = self._shape, self._run.done, 0
        while reached < count:
            status = self._go_on(self._handle, self._first_time + 8 * reached, count - reached, place + 8 * width * reached, done,
                                 _PAUSE)
            reached += done[0]
            if status == Status.ENDED:
                self._is_over = True
                break
            if status not in (_OK, _PAUSED):
                raise RunError(explain(self.scene, self._run.failure, self._run.parameters))
        return reached

    def _refuse(self, start: Sequence[float]) -> None:
        names = [c.name for c in (*self.scene.coordinates, *self.scene.rates)]
        for place, value in zip(self._started, start, strict=True):
            if not math.isfinite(value):
                fail("L0605", f"the initial value of '{names[place]}' must be a finite number, not {value}")


def _in_rows(columns: Iterable[int]) -> list[tuple[slice, slice]]:
    """All rows of these columns: those that stand together at once, as numpy writes few slices soonest."""
    runs: list[list[int]] = []
    for k in sorted(columns):
        if runs and k == runs[-1][1]:
            runs[-1][1] += 1
        else:
            runs.append([k, k + 1])
    return [(slice(None), slice(*run)) for run in runs]


def _start_place(scene: Scene, name: str) -> int:
    slot = scene.slot(name)
    if name in scene.attitudes:
        fail("L0702", f"the attitude '{name}' is three numbers, 4 tan(angle/4) along the axis", None,
             f"prepare the run for its coordinates: {', '.join(scene.attitudes[name])}")
    if slot is None:
        fail("L0901", f"not supported yet: a prepared run from other starts of '{name}', which other coordinates give", None,
             "prepare it for the coordinates themselves, or call simulate")
    return slot
