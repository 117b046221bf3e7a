"""Scene, experiment, values -> rows of results: drives the run time, and tells what kept a run from its tolerance.

The run time itself is C (runtime/); rows come in portions, so that memory stays bounded and a run can be watched and stopped.
"""

import math
import time
from collections import Counter
from collections.abc import Callable, Generator, Iterator, Sequence
from dataclasses import field, replace
from pathlib import Path
from typing import Any, NoReturn

from lagrangia.base.diagnostics import Diagnostic, LagError, RunError, tell_miss
from lagrangia.base.records import dataclass
from lagrangia.run.engines import Engine
from lagrangia.run.event_log import log_events
from lagrangia.run.formulas import zero_directions, zero_masses
from lagrangia.run.guards import of_guard, refuse_parameters, warnings_of
from lagrangia.run.request import Experiment, Values, check_parameters
from lagrangia.run.runtime import GUARDED, Failure, Run, Settings, Statistics, Status
from lagrangia.run.scene import Scene
from lagrangia.run.solvers import number_of

_PAUSE, _FIRST = 0.1, 0.02  # seconds between two looks at the clock and the keyboard; before the first one on a tape
_MANY_STEPS, _MUCH = 100, 100.0
_MOST_STEPS, _MOST_A_ROW = 20_000, 50  # beyond which a run is told why its steps are short
DOUBTFUL = 0.1  # of all energy: an account that misses by more
HOPELESS = 0.5  # the same: no errors of integrals alone
_BESIDE, _NO_LENGTH, _MOST_LENGTHS = "1e-3", 1e-9, 100  # m: a start beside 0, what is 0, and how many are tried
_TIGHT, _FAINT = 1e-9, 1e-5  # a tolerance, and a miss of all energy, that may be near what rounding allows
_LITTLE = 1e-9  # J: less may be rounding of energies that cancel


@dataclass
class Progress:
    """What is known of a run while it goes on and when it has ended."""

    experiment: Experiment
    rows: int = 0
    time: float = math.nan
    seconds: float = 0.0
    statistics: Statistics | None = None
    parameters: list[float] = field(default_factory=list)
    has_power: bool = False  # the account holds integrals of powers, which have errors of their own
    is_driven: bool = False  # something is moved in time, and may bring energy whatever the steps
    contacts: tuple[str, ...] = ()  # of each event, what to call it
    outputs: tuple[str, ...] = ()  # their names
    thresholds: tuple[float, ...] = ()  # with which rates are compared where forces jump
    jumping: tuple[str, ...] = ()  # places of energies that jump with positions or rates
    interrupted: bool = False
    engine: str = ""  # native, tape, or an integrator of CasADi
    events: Sequence[float] = ()  # times of the first ones, s
    ended: str = ""  # what terminate(...) has said, and when
    limits: Counter[int] = field(default_factory=Counter)  # what limited steps when somebody looked, as Statistics.worst has it
    failed: Status | None = None  # how the run time ended the run, where that raised RunError
    warned: list[Diagnostic] = field(default_factory=list)  # assertions that warn and do not hold, and since when


# -------------------------------------------------------------------- the run


def simulate(
    scene: Scene, engine: Engine, experiment: Experiment, values: Values, watch: Callable[[Progress], None] | None = None,
    complete: Callable[[], Engine | None] | None = None,
) -> "tuple[Progress, Iterator[Sequence[float]]]":
    """The progress, and an iterator over portions of rows (flat; t, q, v, y, T, V, H, dissipated, work). `complete` gives
    the engine of the scene with the matrix of implicit steps, where it has none yet.

    Raises LagError for values the scene cannot have, at once; the iterator raises RunError when the run cannot go on, after the
    rows computed so far. KeyboardInterrupt ends the rows and marks the progress.
    """
    run = start_run(scene, engine, experiment, values)
    progress = progress_of(scene, experiment, parameters=run.parameters, engine=engine.how)
    parts = _Parts(scene, engine, run, values, complete)
    return progress, _all_rows(parts, progress, watch)


def progress_of(scene: Scene, experiment: Experiment, **known: Any) -> Progress:
    """With what the scene tells of any of its runs."""
    return Progress(experiment, has_power=scene.sizes["n_power"] > 0, is_driven=bool(scene.notes["is_driven"]),
                    contacts=tuple(scene.notes["contacts"]), outputs=tuple(x.name for x in scene.outputs),
                    thresholds=tuple(scene.notes["thresholds"]), jumping=tuple(scene.notes["jumping"]), **known)


def start_run(scene: Scene, engine: Engine, experiment: Experiment, values: Values) -> Run:
    """A run of the run time, assembled and ready to advance; to be closed. Raises LagError, RunError."""
    run = _given_run(scene, engine, experiment, values)
    try:
        status = run.start(values.q, values.v)
        if status is not Status.OK:
            failure = run.failure
            beside = _beside(scene, engine, experiment, values, run) if status is Status.NOT_FINITE else ""
            fail_start(scene, failure, run.parameters, beside)
    except BaseException:
        run.close()
        raise
    return run


def _given_run(scene: Scene, engine: Engine, experiment: Experiment, values: Values) -> Run:
    """One that has its parameters and inputs, and no start yet. Raises LagError."""
    settings = Settings(experiment.start, experiment.stop, experiment.tolerance, experiment.max_step, 0.0, experiment.max_steps,
                        number_of(experiment.solver, scene))
    run = engine.runtime.run(engine.model, settings)
    try:
        run.set_parameters(values.parameters, values.mask)
        check_parameters(scene, run.parameters)
        if scene.inputs:
            run.set_inputs(values.input_times_from(experiment.start), values.input_values)
        run.set_lost(values.lost or [math.nan] * (2 * scene.sizes["n_lost"]))
    except BaseException:
        run.close()
        raise
    return run


def _beside(scene: Scene, engine: Engine, experiment: Experiment, values: Values, failed: Run) -> str:
    """A length that is 0 where the run cannot begin, as it can a little beside: as of a slider that a mere point turns."""
    at = failed.row().values
    for k, column in enumerate(scene.coordinates[:_MOST_LENGTHS]):
        if column.unit == "m" and abs(at[1 + k]) <= _NO_LENGTH:
            with _given_run(scene, engine, experiment, values) as other:
                if other.start([*values.q[:k], float(_BESIDE), *values.q[k + 1 :]], values.v) is Status.OK:
                    return column.name
    return ""


@dataclass
class _Parts:
    """What runs, and with which values."""

    scene: Scene
    engine: Engine
    run: Run
    values: Values
    complete: Callable[[], Engine | None] | None

    def completed(self, experiment: Experiment) -> "_Parts":
        """The run from its start, where implicit steps can go on."""
        engine = self.complete() if self.complete is not None else None
        assert engine is not None
        return replace(self, engine=engine, run=start_run(self.scene, engine, experiment, self.values), complete=None)


def _all_rows(parts: _Parts, progress: Progress, watch: Callable[[Progress], None] | None) -> Iterator[Sequence[float]]:
    """A run that wants the matrix of implicit steps, which waits in large scenes, is done once more with it: up to there its
    steps are the same, so that rows that were told before are not told again."""
    while (yield from _rows(parts, progress, watch)):
        parts = parts.completed(progress.experiment)


def _rows(parts: _Parts, progress: Progress, watch: Callable[[Progress], None] | None
          ) -> Generator[Sequence[float], None, bool]:
    """Those that were not told before; returns whether it wants the matrix of implicit steps."""
    begin, told, known = time.perf_counter() - progress.seconds, progress.rows, 0
    looks, run = _Looks(parts.engine, progress), parts.run
    log = log_events(parts.engine.runtime.library, run, parts.scene, parts.values)
    with run:
        for times in progress.experiment.times():
            done = 0
            while done < len(times):
                pause = looks.pause()
                try:
                    rows = run.advance(times[done:], pause)
                except KeyboardInterrupt:
                    progress.interrupted = True
                    return False
                finally:
                    progress.seconds, progress.statistics, progress.time = time.perf_counter() - begin, run.statistics, run.time
                    progress.limits[progress.statistics.worst] += 1
                    if log is not None:
                        progress.events = log.times()
                    progress.warned += warnings_of(parts.scene, run)
                looks.look()
                done += rows.count
                new = min(rows.count, max(0, known + rows.count - told))
                known += rows.count
                progress.rows += new
                if new:
                    yield rows.values[(rows.count - new) * rows.width :]
                if watch is not None:
                    watch(progress)
                if rows.status is Status.WANTS_JACOBIAN and parts.complete is not None:
                    return True
                if rows.status is Status.ENDED:
                    progress.ended, progress.time = explain(parts.scene, run.failure), run.failure.time
                    return False
                if rows.status not in (Status.OK, Status.PAUSED):
                    progress.failed = rows.status
                    raise RunError(explain(parts.scene, run.failure, run.parameters))
    return False


@dataclass
class _Looks:
    """Tells an engine between portions what a run has taken, and will take: of a processor, as others may have it meanwhile."""

    engine: Engine
    progress: Progress
    spent: float = 0.0
    _begin: float = 0.0

    def pause(self) -> float:
        """Seconds until the next look: soon at first, as native code may be there."""
        self._begin = time.thread_time()
        return _FIRST if self.engine.upgrade is not None and not self.spent else _PAUSE

    def look(self) -> None:
        progress, seconds = self.progress, time.thread_time() - self._begin
        self.spent += seconds
        span = progress.experiment.stop - progress.experiment.start
        done = (progress.time - progress.experiment.start) / span if span > 0 else 1.0
        self.engine.look(seconds, self.spent / done - self.spent if done > 0 else 0.0)
        progress.engine = self.engine.how


def fail_start(scene: Scene, failure: Failure, parameters: Sequence[float] = (), beside: str = "") -> NoReturn:
    """Raises LagError where start values or parameters miss what they have to satisfy, RunError where there is no start;
    `beside`: the length that may not be 0."""
    refuse_parameters(scene, failure)
    if failure.status is Status.INITIAL_FAILED:
        what, excerpt = scene.initial_places[failure.index]
        raise LagError([Diagnostic("error", "L0606", f"{what}: {_miss_at_start(scene, failure)}", None, "",
                                   ("change the parameters it depends on, or the start values it is solved from",), excerpt)])
    is_turned = beside and 0 <= failure.index < scene.n and scene.coordinates[failure.index].unit == "rad"
    why = " (a slider of no length has no direction, where a mere point turns it)" if is_turned else ""
    told = f"; it begins where {beside} is not 0{why}: --initial {beside}={_BESIDE}" if beside else ""
    raise RunError(explain(scene, failure, parameters) + told)


def explain(scene: Scene, failure: Failure, parameters: Sequence[float] = ()) -> str:
    """When, where and what to try; of what moves no mass, which masses are 0 among all `parameters`, where they are known."""
    if failure.status is Status.INITIAL_FAILED:
        return f"{start_in_general(scene, failure.index)}: {_miss_at_start(scene, failure)}"
    places = ", ".join(scene.notes["kinetic"][:2])
    kinetic = f"a kinetic energy that is negative for some motion ({places}), " if places else ""
    column = (scene.rates if failure.rate else scene.coordinates)[failure.index] if 0 <= failure.index < scene.n else None
    where = f" ({column.name})" if column else ""
    if failure.status in (Status.NOT_FINITE, Status.STEP_TOO_SMALL) and scene.notes["felt"]:
        return (f"the motion cannot be continued beyond t = {failure.time:.9g}: the friction that feels reactions "
                f"({scene.notes['felt']}) presses by them more than it takes, so that there is no solution, or several "
                f"(Painleve's paradox), or accelerations are not finite{where} for another reason; try less friction")
    if failure.status is Status.NOT_FINITE:
        told, directions = (_are_zero(find(scene, parameters)) if parameters else "" for find in (zero_masses, zero_directions))
        axis = f"an axis, or another direction, of the length 0{directions}, " if directions else ""
        return (f"at t = {failure.time:.6g} the accelerations are not finite{where}: {axis}a coordinate that moves no "
                f"mass{told}, {kinetic}points that coincide, or a function outside its domain; look at the parameters and "
                "start values")
    if failure.status is Status.STEP_TOO_SMALL:
        return _of_short_steps(scene, failure, where, kinetic)
    if failure.status in (Status.EVENTS_GO_ON, Status.NO_IMPULSE):
        return f"the motion cannot be continued beyond t = {failure.time:.9g}: {_of_events(scene, failure)}"
    if failure.status is Status.CONSTRAINTS_OPEN:
        return (f"the constraints do not close at t = {failure.time:.6g}: one is open by {failure.value:.1e} of the motion, near "
                "a singular position or between masses too uneven for the tolerance; try a smaller one, or another solver")
    if failure.status is Status.NO_PROGRESS:
        return (f"there is no progress at t = {failure.time:.9g}{where}: the rest would take {failure.value:.1e} steps as short "
                "as are needed there, where something jumps, bends or vibrates; try another solver or a larger tolerance, or let "
                "it go on with --max-steps")
    if failure.status is Status.TURNED_OFF:
        return (f"the motion cannot be continued beyond t = {failure.time:.9g}{where}: two ways of moving meet there, in a "
                "singular position (a dead point, a linkage folded flat), and rounding led from one to the other; try another "
                "tolerance or solver, or a start beside it")
    if failure.status in (Status.TABLE_ENDED, Status.INPUT_JUMPS, Status.BAD_INTERVAL, Status.BAD_DELAY):
        return _of_given(scene, failure)
    if failure.status in GUARDED:
        return of_guard(scene, failure)
    if failure.status is Status.TOO_MANY_STEPS:
        return (f"the limit of steps is reached at t = {failure.time:.6g}{where}; raise --max-steps, or loosen the tolerance")
    return f"the run stopped at t = {failure.time:.6g}: {failure.status.name.lower().replace('_', ' ')}"


def start_in_general(scene: Scene, index: int) -> str:
    """What is wrong when this initial equation misses, and the file and line where it stands."""
    what, excerpt = scene.initial_places[index]
    place = excerpt.partition("\n")[0].removeprefix(" --> ").rpartition(":")[0]
    return f"{what} ({Path(place).name})"


def _miss_at_start(scene: Scene, failure: Failure) -> str:
    return tell_miss(failure.value, "m or rad" if failure.index < scene.sizes["n_initial_positions"] else "m/s or rad/s")


def _are_zero(names: Sequence[str]) -> str:
    told = ", ".join(map("'{}'".format, names[:4]))
    return f" ({told} {'are' if len(names) > 1 else 'is'} 0)" if names else ""


def _of_short_steps(scene: Scene, failure: Failure, where: str, kinetic: str) -> str:
    """What may be there, where no step is small enough: `where` names a coordinate, `kinetic` energies that may be negative."""
    dead = ("a dead point of a linkage driven in time, near which rounding decides (auto goes on there by each of its "
            "choices; try a larger tolerance), " if scene.sizes["loops_know_time"] else "")
    return (f"the motion cannot be continued beyond t = {failure.time:.9g}: no step is small enough{where}; {kinetic}{dead}a "
            "singularity (a collision, a spring of zero length, a division by zero) or values beyond the range of numbers")


def _of_given(scene: Scene, failure: Failure) -> str:
    """What is given over time, and does not go on: tables, inputs, instants."""
    if failure.status is Status.TABLE_ENDED:
        return (f"the table '{scene.tables[int(failure.value)].name}' ends, and the run goes on: it says nothing after "
                f"t = {failure.time:.9g}; stop earlier, or say what holds beyond its ends, as with beyond = \"hold\"")
    if failure.status is Status.INPUT_JUMPS:
        name = scene.inputs[failure.index].name
        return (f"the input '{name}' moves places, and jumps by {failure.value:.3g} at t = {failure.time:.9g}: what it moves "
                f"would have no speed; give der({name}) and der(der({name})) with it, or all of it as a table before the run")
    if failure.status is Status.BAD_DELAY:
        place = scene.notes["delays"][failure.index]
        if failure.rate:
            return (f"the delay at {place} was to become {failure.value:g} s during the run; delays stay as they are until it "
                    "starts anew")
        return f"the delay at {place} must be positive, and is {failure.value:g} s"
    return (f"the interval of the sampled values at {scene.notes['samplers'][failure.index]} must be positive, and is "
            f"{failure.value:g} s")


def _of_events(scene: Scene, failure: Failure) -> str:
    """What does not end or go together, with the place of one of those events: 1 + its number is the failure's value."""
    first = f", one of them {scene.notes['contacts'][int(failure.value) - 1]}" if failure.value > 0 else ""
    if failure.status is Status.EVENTS_GO_ON:
        return (f"events that reset rates bring each other about without end{first}; look at what `when` and reinit make of each "
                "other there")
    if failure.rate:
        return (f"a contact does not turn back what approaches{first.replace('one of them ', '')}: what it sets did so for the "
                "parameters as they are declared (e >= 0), and does not now; declare those of this run in the file, so that its "
                "events are known for these")
    return (f"contacts and their friction have neither forces nor impulses that go together{first} (Painleve's paradox: rigid "
            "bodies jam); try less friction, or springs in between")


def short_steps(scene: Scene, progress: Progress) -> str:
    """What limits the steps of a run that takes very many, by what was seen now and then; empty for other runs."""
    s = progress.statistics
    if s is None or s.steps < _MOST_STEPS or s.steps < _MOST_A_ROW * progress.rows or not progress.limits:
        return ""
    span = progress.time - progress.experiment.start
    most, times = progress.limits.most_common(1)[0]
    names = (*scene.coordinates, *scene.rates)
    if not 0 <= most < len(names):
        return ""
    share = times / progress.limits.total()
    often = "" if share == 1 else f", in {100 * share:.0f} % of the looks at it"
    lengths = f"its steps are short, {span / s.steps:.2g} s on average and {s.smallest_step:.2g} s at least"
    if 2 * s.events > s.steps:
        return f"{lengths}: {s.events} events cut them, as of corners of tables and conditions in time"
    return f"{lengths}: {names[most].name} limits them{often}, as the forces on it change that quickly"


def shortcomings(progress: Progress) -> list[str]:
    """What kept a run from its tolerance, in words; empty when nothing did.

    Beside what the run time counted: an energy account that closes MUCH worse than the tolerance shows that errors have added up,
    in runs of many steps (in a few, the rounding of the first state can be all that moves). Where powers are integrated, whose
    errors do not limit steps, they may be those of the account alone; where that is DOUBTFUL as a whole, so is the motion, and
    where it is HOPELESS the run has failed.
    """
    statistics, tolerance = progress.statistics, progress.experiment.tolerance
    if statistics is None:
        return []
    found = []
    if statistics.tolerance_raised:
        found.append("the tolerance was raised to 1e-14, the smallest that double precision can keep")
    if statistics.tolerance_missed:
        steps = f"{statistics.tolerance_missed} step{'s' if statistics.tolerance_missed != 1 else ''}"
        found.append(f"{steps} missed the tolerance, as happens near singular positions, and where little but rounding is left")
    if statistics.passed:
        what = progress.contacts[statistics.passed - 1]
        is_place = what.startswith("the contact")
        found.append(f"{what} holds at the start already, and comes when it has been false" if not is_place else
                     f"{what} is passed at the start already, so that nothing strikes it before it has been left: "
                     "start outside it")
    if statistics.jammed:
        at_start = statistics.jam_time == progress.experiment.start
        found.append(f"{progress.contacts[statistics.jammed - 1]} jams at t = {statistics.jam_time:.9g}: friction presses what "
                     "slides further, and no force holds it (Painleve's paradox); an impulse without a collision stops the slip"
                     f"{', so that rates are not those stated from the first row on' if at_start else ''}")
    missed = _missed_energy(progress)
    if missed > _MUCH * tolerance and not loss(progress):
        what = f"errors have added up until the energy account misses by {missed:.1e} of its size"
        if not progress.has_power:
            found.append(f"the tolerance {tolerance:g} was not kept to the end: {what}")
        else:
            doubt = "; more likely the motion itself is wrong: compare with a smaller tolerance, or another solver"
            found.append(f"{what}, perhaps in its integrals of powers alone{doubt if missed > DOUBTFUL else ''}")
    return found


def loss(progress: Progress) -> str:
    """Why rows cannot be those of the scene; empty where nothing tells so.

    The run time judges the energy account at each row, by the tolerance, the number of steps and what these know of the errors of
    its integrals of powers; CasADi's integrators tell nothing of that.
    """
    s = progress.statistics
    if s is None:
        return ""
    if s.unsure:
        rows = f"{s.unsure} rows" if s.unsure > 1 else "one row"
        return (f"'{progress.outputs[s.unsure_output]}' is not known at t = {s.unsure_time:.9g}, so near a singular position "
                f"that rounding decides it: what is so in {rows} is written as NaN; ask for other times")
    small = min(progress.thresholds, default=math.inf)
    if small < progress.experiment.tolerance and s.events:
        return (f"a force jumps where a rate passes {small:g}, which rates are not told from 0 by at the tolerance "
                f"{progress.experiment.tolerance:g}: ask whether it rests (v == 0), or take a smaller tolerance")
    if not (s.energy_is_open or _is_beyond_doubt(progress)):
        return ""
    relative, reason = s.energy_residual / s.energy_size, ""
    what = (f"misses by {s.energy_residual:.1e} J, {relative:.1e} of its size, more than the tolerance "
            f"{progress.experiment.tolerance:g} explains,")
    if relative > DOUBTFUL:
        what, reason = "does not close at all", "has a singularity (a collision, a division by zero) or "
        if progress.is_driven:
            reason = f"is moved in time by what jumps where nothing tells beforehand, {reason}"
    since = f" from t = {s.energy_open:.6g} on" if s.energy_is_open else ""
    if progress.jumping:
        return (f"the energy account {what}{since}: {tell_jumps(progress.jumping)}: the rows there are not the motion of this "
                "scene, which needs one that rises over a short way")
    return (f"the energy account {what}{since}: the rows there are not the motion of this scene, which {reason}needs "
            f"{remedy(progress.experiment.tolerance, relative)}")


def tell_jumps(places: Sequence[str]) -> str:
    """Why no solver closes the account of a scene whose energies jump at these places."""
    return f"an energy jumps with a position or rate, at {', '.join(places[:2])}, which gives no impulse (L0744)"


def remedy(tolerance: float, missed: float) -> str:
    """What is FAINT at a tolerance that is TIGHT already may be rounding, which no smaller tolerance mends."""
    usual = "a smaller tolerance, or another solver"
    if tolerance > _TIGHT or missed > _FAINT:
        return usual
    return f"{usual}; or, where rounding decides, as between masses far apart, a tolerance of no less than {missed:.0e}"


def _is_beyond_doubt(progress: Progress) -> bool:
    missed = _missed_energy(progress)
    if missed <= max(DOUBTFUL, _MUCH * progress.experiment.tolerance):
        return False
    return not progress.has_power or missed > HOPELESS or _rises_from_nothing(progress)


def _rises_from_nothing(progress: Progress) -> bool:
    """Whether H rose by MUCH more than powers ever gave it: however badly they are integrated, they would have shown. What is
    moved in time may have energy whether steps saw it move or not."""
    s = progress.statistics
    return s is not None and not progress.is_driven and s.energy_risen > max(DOUBTFUL * s.energy_stored, _MUCH * s.energy_given)


def _missed_energy(progress: Progress) -> float:
    """By how much the energy account misses, relative; 0 where rounding explains it, and for short runs, unless that is
    DOUBTFUL and more than LITTLE. CasADi's integrators do not tell their steps."""
    s = progress.statistics
    if s is None or not 0 < s.energy_size < math.inf or s.energy_residual <= s.energy_rounding:
        return 0.0
    missed = s.energy_residual / s.energy_size
    is_long = (s.steps or progress.rows) > _MANY_STEPS
    return missed if is_long or (missed > DOUBTFUL and s.energy_residual > _LITTLE) else 0.0

