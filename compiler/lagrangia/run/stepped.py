"""A run that the caller's clock drives: inputs are set, a step is made, the state is read; it can be kept and gone back to."""

import math
import time
import weakref
from array import array
from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from lagrangia.base.checked_values import a_number, an_array, by_name
from lagrangia.base.diagnostics import RunError, fail, suggest
from lagrangia.run.engines import Engine
from lagrangia.run.remarks import warn_of_loss
from lagrangia.run.request import Experiment, Values
from lagrangia.run.runtime import Statistics, Status
from lagrangia.run.scene import ENERGY_NAMES, Scene
from lagrangia.run.simulate import Progress, explain, loss, progress_of, shortcomings, start_run

if TYPE_CHECKING:
    import numpy as np

_PAUSE = 0.1  # seconds between two looks at the keyboard
_PACE = 32  # bytes: where equal steps began, how long they are, how many there were; and those of `ended`
_LOOK = 1000  # steps between two looks at what the engine could become


class SteppedRun:
    """A motion in the caller's hands, for one thread at a time.

        run = model.start(initial={"hinge.phi": 0.1})
        while run.time < 5:
            run.set(F=-45*run["hinge.phi"])
            run.step(0.01)

    Inputs are held over a step, and change without a step of the method going across. `run["x"]` is the present value of a
    column: a coordinate, rate, output or energy; `run.row` are all of them in the order of `columns`.
    """

    def __init__(self, scene: Scene, engine: Engine, experiment: Experiment, values: Values) -> None:
        """Raises LagError, RunError where the start cannot be found."""
        import numpy as np

        if experiment.solver == "islands":
            fail("L0704", "the solver 'islands' has no steps in common", None, "choose auto, or another one")
        if len(values.input_times) > 1:
            fail("L0703", "inputs of a run in steps are constants to begin with, no tables", None, "steps(U, dt) takes an array")
        self.scene, self._engine, self._experiment = scene, engine, experiment
        self._run = start_run(scene, engine, experiment, values)
        weakref.finalize(self, self._run.close)
        self._library, self._handle, self._done = engine.runtime.library, self._run.handle, self._run.done
        names = ("time", *(c.name for c in (*scene.coordinates, *scene.rates, *scene.outputs)), *ENERGY_NAMES)
        self.columns = names
        self._place = {name: k for k, name in enumerate(names)}
        self._input = {item.name: k for k, item in enumerate(scene.inputs)}
        self._u = np.array(values.input_values[: len(scene.inputs)] if scene.inputs else (), dtype=float)
        self._row = np.array(self._run.row().values)
        self._state = self._row[1 : 1 + 2 * scene.n]
        self._turned = [self._place[name] for name in scene.turned]
        self._row[self._turned] = math.nan
        self._pointers = self._u.ctypes.data if len(self._u) else None, self._row.ctypes.data
        self._begin, self._dt, self._count = self.time, math.nan, 0  # the present is so many equal steps after
        self._steps = 0
        self._is_open, self.told_open = self._run.energy_is_open, 0  # the account's, of C, and what was told of it
        self.ended = ""  # what terminate(...) has said, and when: no step goes on from there

    @property
    def time(self) -> float:
        """s."""
        return float(self._row[0])

    @property
    def state(self) -> "np.ndarray":
        """q, then v: a view (2 n,) of the present, which the next step changes; NaN for the coordinates of attitudes, whose
        quaternions are columns."""
        return self._state

    @property
    def row(self) -> "np.ndarray":
        """A copy of all columns at the present, (columns,)."""
        return self._row.copy()

    @property
    def inputs(self) -> dict[str, float]:
        """What is held now."""
        return dict(zip(self._input, self._u.tolist(), strict=True))

    @property
    def parameters(self) -> list[float]:
        """All of them, with those that follow from others."""
        return self._run.parameters

    @property
    def engine(self) -> str:
        """What runs: native, tape."""
        return self._engine.how

    @property
    def statistics(self) -> Statistics:
        """What the run has done so far."""
        return self._run.statistics

    @property
    def warnings(self) -> list[str]:
        """What kept the run from its tolerance so far, in words; empty when nothing did."""
        progress = self._progress()
        return [*filter(None, [loss(progress)]), *shortcomings(progress)]

    def _progress(self) -> Progress:
        return progress_of(self.scene, self._experiment, rows=self._steps, time=self.time, statistics=self._run.statistics)

    def _tell_open(self) -> None:
        """A RunWarning once an account is open, which may close again."""
        self.told_open = self._is_open.value
        if self.told_open:
            warn_of_loss(self._progress())

    def __getitem__(self, name: str) -> float:
        """Raises LagError L0701."""
        place = self._place.get(name)
        if place is None:
            slot = self.scene.slot(name)
            if slot is None:
                fail("L0701", f"a run in steps has no column '{name}'", None, *filter(None, [suggest(name, self.columns)]),
                     "ask for it when the model is made: lagrangia.Model(path, outputs=[name])")
            place = self._place[name] = 1 + slot
        return float(self._row[place])

    def set(self, given: Mapping[str, float] | None = None, **named: float) -> None:
        """Inputs that hold from now on, in SI units. Raises LagError L0605, L0701."""
        for name, value in ({**by_name("inputs", given), **named} if given is not None else named).items():
            place = self._input.get(name)
            if place is None:
                fail("L0701", f"the scene has no input '{name}'", None, *filter(None, [suggest(name, self._input)]))
            if not math.isfinite(a_number(f"input '{name}'", value)):
                fail("L0605", f"the input '{name}' must be a finite number, not {value}")
            self._u[place] = value

    def step(self, dt: float) -> "np.ndarray":
        """Goes on by dt (s); answers the state, as `state`: where terminate(...) comes before, that at the `ended` run's end.
        A RunWarning tells of an energy account that opens. Raises LagError L0702, RunError when the run cannot go on."""
        if dt != self._dt:
            self._pace(dt)
        u, row = self._pointers
        looks = self._engine.upgrade is not None and self._steps % _LOOK == 0
        begin = time.thread_time() if looks else 0.0
        status = self._library.lag_run_steps(self._handle, self._begin, self._dt, self._count, 1, u, row, self._done, 0.0)
        if status != 0:
            self._end(Status(status))
        if self._turned:
            self._row[self._turned] = math.nan
        self._count += 1
        self._steps += 1
        if self._is_open.value != self.told_open:
            self._tell_open()
        if looks:  # one step stands for those until the next look
            self._engine.look(_LOOK * (time.thread_time() - begin), 0.0)
        return self._state

    def steps(self, inputs: Any, dt: float) -> "np.ndarray":
        """A step of dt (s) for each row of `inputs`, (steps, inputs) in the order of `inputs`, or so many, where it is a number,
        with what is held. Answers (steps, columns), fewer where terminate(...) ends the run. Raises LagError L0702, L0605,
        RunError, KeyboardInterrupt."""
        import numpy as np

        count, u = self._rows_of(inputs)
        if dt != self._dt:
            self._pace(dt)
        looks = self._engine.upgrade is not None
        rows, done, begin = np.empty((count, len(self.columns))), 0, time.thread_time() if looks else 0.0
        while done < count:
            place = None if u is None else u.ctypes.data + 8 * done * len(self._u)
            target = rows[done:].ctypes.data
            status = Status(self._library.lag_run_steps(self._handle, self._begin, self._dt, self._count, count - done, place,
                                                        target, self._done, _PAUSE))
            done += self._done[0]
            self._count += self._done[0]
            rows[:done, self._turned] = math.nan
            if done:
                self._row[:] = rows[done - 1]
            if u is not None and done:
                self._u[:] = u[min(done, count - 1)]
            if self._is_open.value != self.told_open:
                self._tell_open()
            if status not in (Status.OK, Status.PAUSED):
                self._end(status)
                rows[done], done = self._row, done + 1
                break
        if looks:
            self._engine.look(time.thread_time() - begin, 0.0)
        return rows[:done]

    def _pace(self, dt: float) -> None:
        """Equal steps end where multiples of them do, however they are asked for."""
        seconds = a_number("step", dt)
        if not 0 < seconds < math.inf:
            fail("L0702", f"a step must be a positive number of seconds, not {dt}")
        self._begin, self._dt, self._count = self.time, seconds, 0

    def _rows_of(self, inputs: Any) -> "tuple[int, np.ndarray | None]":
        import numpy as np

        if isinstance(inputs, int):
            if inputs < 1:
                fail("L0702", f"the number of steps must be positive, not {inputs}")
            return inputs, np.tile(self._u, (inputs, 1)) if len(self._u) else None
        u = np.ascontiguousarray(an_array("inputs", inputs))
        wanted = len(self._u)
        if u.ndim == 1 and wanted == 1:
            u = u[:, np.newaxis]
        if u.ndim != 2 or u.shape[1] != wanted or not np.isfinite(u).all():
            fail("L0702", f"inputs are an array of finite numbers of the shape (steps, {wanted}), not {u.shape}")
        return len(u), u if wanted else None

    def save(self) -> bytes:
        """The whole state of the run, to come back to: it then goes on bit for bit as it went on from here."""
        taken = array("b", bytes(self._library.lag_snapshot_size(self._handle)))
        self._library.lag_snapshot_take(self._handle, taken.buffer_info()[0])
        ended = self.ended.encode()
        pace = array("d", (self._begin, self._dt, self._count, len(ended)))
        return pace.tobytes() + self._row.tobytes() + self._u.tobytes() + taken.tobytes() + ended

    def restore(self, kept: bytes) -> None:
        """Back to where `save` was called, of this run or another of the same model. Raises LagError L0702 for other bytes."""
        import numpy as np

        if not isinstance(kept, bytes):
            fail("L0702", f"a state must be the bytes that save() has answered, not {kept!r}"[:200])
        row, u = _PACE + self._row.nbytes, self._u.nbytes
        pace = np.frombuffer(kept[:_PACE]).tolist() if len(kept) > row + u else []
        end = len(kept) - int(pace[3]) if pace and 0 <= pace[3] <= len(kept) else 0
        inner = kept[row + u : end]
        if self._library.lag_snapshot_restore(self._handle, inner, len(inner)) != 0:
            fail("L0702", "these bytes are no state of this run", None, "give what save() has answered, of the same model")
        self.ended = kept[end:].decode()
        self._begin, self._dt, self._count = pace[0], pace[1], int(pace[2])
        self._row[:] = np.frombuffer(kept[_PACE:row])
        self._u[:] = np.frombuffer(kept[row : row + u])

    def _end(self, status: Status) -> None:
        """The row at which terminate(...) has ended the run. Raises RunError where something else did, or it ended before."""
        said = explain(self.scene, self._run.failure, self._run.parameters)
        if status is not Status.ENDED or self.ended:
            raise RunError(said)
        self.ended = said
        self._row[:] = self._run.row().values
        self._row[self._turned] = math.nan

    def __repr__(self) -> str:
        names = ", ".join(self.columns[1:7]) + (", ..." if len(self.columns) > 7 else "")
        return f"<{self.scene.name} at t = {self.time:g} s: {names}>"
