"""The motion of an FMU at given times: Model Exchange by the CVode that FMPy brings, Co-Simulation by its own steps."""

import math
from collections.abc import Callable, Sequence
from typing import Any

from lagrangia.base.records import dataclass
from lagrangia.fmu.importer import DISCARD, FmuError, Importer, Table

_LONGEST = 1 / 50  # step of Model Exchange, of the time to simulate: events between two steps are overlooked
_MOST_STEPS = 1_000_000  # between two rows
_CLOSE = 1e-12  # of times

Write = Callable[[float], None]


@dataclass
class Count:
    """What was done."""

    steps: int = 0
    evaluations: int = 0
    events: int = 0


def exchange(importer: Importer, table: Table, times: Sequence[float], stop: float, tolerance: float, write: Write,
             count: Count) -> None:
    """Model Exchange from times[0], initialised, in continuous-time mode. A row at an event shows the state before it."""
    t = times[0]
    solver = _solver(importer, table, t, stop, tolerance, count)
    write(t)
    for target in times[1:]:
        while t < target - _CLOSE * max(1.0, abs(target)):
            jump, event = table.next_jump(t), importer.next_event
            if event is not None and event <= t:
                event = None
            end = min(x for x in (target, jump, event) if x is not None)
            is_state_event, _roots, t = solver.step(t, end)
            if solver.failure is not None:
                raise solver.failure
            importer.fmu.setTime(t)
            table.apply(t, is_after=False)
            count.steps += 1
            asks = importer.completed_step()
            reached = t >= end - _CLOSE * max(1.0, abs(end))
            is_event = is_state_event or asks or (reached and end in (jump, event))
            if reached and t >= target - _CLOSE * max(1.0, abs(target)):
                write(target)
            if is_event:
                count.events += 1
                importer.handle_event(lambda t=t: table.apply(t, is_after=True))  # type: ignore[misc]
                solver.reset(t)


def _solver_class(count: Count) -> Any:
    """FMPy's CVode, with errors of the FMU told as such."""
    from fmpy.fmi1 import FMICallException
    from fmpy.sundials import CVodeSolver

    class Solver(CVodeSolver):  # type: ignore[misc]
        failure: Exception | None = None

        def f(self, t: float, y: Any, slope: Any, user_data: Any) -> int:
            """0: done; 1: try a shorter step; -1: give up."""
            count.evaluations += 1
            try:
                super().f(t, y, slope, user_data)
            except FMICallException as error:
                if error.status == DISCARD:
                    return 1
                self.failure = error
                return -1
            except Exception as error:
                self.failure = error
                return -1
            return 0

        def step(self, t: float, end: float) -> tuple[bool, Any, float]:
            try:
                found: tuple[bool, Any, float] = super().step(t, end)
            except (RuntimeError, TypeError) as error:
                told = self.error_info[3] if self.error_info else str(error)
                raise self.failure or FmuError(f"CVode cannot go on from t = {t:.9g}: {told}") from None
            return found

    return Solver


def _solver(importer: Importer, table: Table, t: float, stop: float, tolerance: float, count: Count) -> Any:
    """With inputs at each of its stages."""
    fmu, description = importer.fmu, importer.description

    def set_time(now: float) -> None:
        fmu.setTime(now)
        table.apply(now, is_after=False)

    return _solver_class(count)(
        nx=description.numberOfContinuousStates, nz=description.numberOfEventIndicators,
        get_x=fmu.getContinuousStates, set_x=fmu.setContinuousStates, get_z=fmu.getEventIndicators,
        get_dx=fmu.getDerivatives if importer.is_fmi2 else fmu.getContinuousStateDerivatives,
        get_nominals=fmu.getNominalsOfContinuousStates, set_time=set_time, input=_Input(table), startTime=t,
        maxStep=(stop - t) * _LONGEST if stop > t else math.inf, relativeTolerance=tolerance, maxNumSteps=_MOST_STEPS)


class _Input:
    """What FMPy's solver calls an input."""

    def __init__(self, table: Table) -> None:
        self.table = table

    def apply(self, t: float) -> None:
        self.table.apply(t, is_after=False)


def cosimulate(importer: Importer, table: Table, times: Sequence[float], write: Write, count: Count) -> None:
    """Co-Simulation from times[0], initialised. Inputs go on with their slopes where the FMU can follow them; else their
    means are held over each step, and rows have the values at their times."""
    t = times[0]
    write(t)
    varies = bool(importer.interface.canHandleVariableCommunicationStepSize)
    follows = importer.is_fmi2 and bool(importer.interface.canInterpolateInputs)
    for target in times[1:]:
        while t < target - _CLOSE * max(1.0, abs(target)):
            corner = table.next_corner(t) if varies else None
            end = target if corner is None or corner >= target - _CLOSE * max(1.0, abs(target)) else corner
            if follows:
                table.apply(t, is_after=True, with_slopes=True)
            else:
                table.hold(t, end)
            t = importer.step(t, end - t)
            count.steps += 1
            if abs(t - end) <= _CLOSE * max(1.0, abs(end)):
                t = end
        if not follows:
            table.apply(target, is_after=False)
        write(target)
