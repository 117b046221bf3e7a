"""One instance of any FMU, through FMPy, in the same words for both versions and both kinds. Lives in a process of its own
(worker.py), since what is inside an FMU may crash."""

import ctypes
import math
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from itertools import pairwise
from math import prod
from typing import Any

from lagrangia.fmu.description import element_of, labels, place_of

_BEFORE = ("exact", "approx")  # `initial` of what may be set before initialization
_RECORDED = ("Real", "Float32", "Float64", "Integer", "Int8", "UInt8", "Int16", "UInt16", "Int32", "UInt32", "Int64", "UInt64",
             "Enumeration", "Boolean")
_MOST_UPDATES = 1000
WARNING, DISCARD = 1, 2


class FmuError(Exception):
    """What an FMU answered instead of going on."""


class AskedToEnd(FmuError):
    """In the way that the standard has for it."""


class Importer:
    """`kind`: ModelExchange or CoSimulation; `folder` holds the unpacked FMU."""

    def __init__(self, folder: str, kind: str) -> None:
        import fmpy
        from fmpy.simulation import instantiate_fmu

        self.kind = kind
        self.description = fmpy.read_model_description(folder, validate=False)
        self.is_fmi2 = self.description.fmiVersion == "2.0"
        self.variables = {v.name: v for v in self.description.modelVariables}
        self.fmu = instantiate_fmu(folder, self.description, kind)
        if not self.fmu.component:
            raise FmuError("no instance could be made")
        interface = self.description.modelExchange if kind == "ModelExchange" else self.description.coSimulation
        self.interface = interface
        self.next_event: float | None = None
        self.warns = False  # the latest step was answered by a warning
        self._heed(("fmi2" if self.is_fmi2 else "fmi3") + ("DoStep" if kind == "CoSimulation" else "CompletedIntegratorStep"))

    def _heed(self, name: str) -> None:
        """Keeps the status of a function, which FMPy does not pass on where it is no error."""
        inner = getattr(self.fmu, name)

        def heeded(*arguments: Any) -> Any:
            status = inner(*arguments)
            self.warns = status == WARNING
            return status

        setattr(self.fmu, name, heeded)

    # ---------------------------------------------------------------- values

    def getter(self, kind: str) -> Callable[..., Any]:
        """The function of the FMU that reads variables of a kind."""
        return self._function("get", kind)

    def setter(self, kind: str) -> Callable[..., Any]:
        """The function of the FMU that writes variables of a kind."""
        return self._function("set", kind)

    def _function(self, what: str, kind: str) -> Callable[..., Any]:
        enumeration = "Integer" if self.is_fmi2 else "Int64"
        found: Callable[..., Any] = getattr(self.fmu, what + (enumeration if kind == "Enumeration" else kind))
        return found

    def find(self, name: str) -> tuple[Any, int, int]:
        """A variable, and which of its values are meant, from 0: the first, and their number. x[1,2] is an element of x."""
        variable = self.variables.get(name)
        if variable is not None:
            return variable, 0, prod(variable.shape or ())
        array, index = element_of(name) or (name, ())
        place = place_of(index, self.variables[array].shape or ())
        if place is None:
            raise FmuError(f"there is no variable '{name}'")
        return self.variables[array], place, 1

    def along(self, unknowns: Sequence[int], knowns: Sequence[int], seed: Sequence[float], size: int) -> list[float]:
        """The directional derivatives of unknowns, `size` numbers in all; one seed for each number of the knowns."""
        more = {} if self.is_fmi2 else {"nSensitivity": size}
        found: list[float] = self.fmu.getDirectionalDerivative(unknowns, knowns, seed, **more)
        return found

    def columns(self, names: Sequence[str]) -> list[str]:
        """Elements of arrays have a column each."""
        whole = {name: self.variables[name].shape for name in names if name in self.variables}
        return [label for name in names for label in labels(name, whole.get(name))]

    def reader(self, names: Sequence[str]) -> Callable[[], list[float]]:
        """Reads these variables as numbers; one call of the FMU for each type."""
        groups: dict[str, dict[int, int]] = {}  # by value reference: the first of its values among those of its type
        sizes: Counter[str] = Counter()
        parts: list[tuple[str, int, int]] = []
        for name in names:
            variable, element, count = self.find(name)
            known = groups.setdefault(variable.type, {})
            if variable.valueReference not in known:
                known[variable.valueReference] = sizes[variable.type]
                sizes[variable.type] += prod(variable.shape or ())
            parts.append((variable.type, known[variable.valueReference] + element, count))
        calls = {kind: (self.getter(kind), list(known), sizes[kind]) for kind, known in groups.items()}

        def read() -> list[float]:
            values = {kind: getter(references) if self.is_fmi2 else getter(references, nValues=size)
                      for kind, (getter, references, size) in calls.items()}
            return [float(value) for kind, begin, count in parts for value in values[kind][begin : begin + count]]

        return read

    def get(self, names: Sequence[str]) -> list[float]:
        """Values of variables, by name."""
        return self.reader(names)() if names else []

    def set(self, values: Mapping[str, Any]) -> None:
        """Start values, as FMPy sets them."""
        from fmpy.simulation import apply_start_values

        apply_start_values(self.fmu, self.description, dict(values))

    # ---------------------------------------------------------------- life

    def initialise(self, start: float, stop: float, tolerance: float, values: Mapping[str, Any],
                   begin: Callable[[], None]) -> None:
        """`begin` sets the inputs."""
        early = {name: value for name, value in values.items() if self.variables[name].initial in _BEFORE}
        if self.is_fmi2:
            self.fmu.setupExperiment(tolerance=tolerance, startTime=start, stopTime=stop)
        structural = {name: early.pop(name) for name in [*early] if self.variables[name].causality == "structuralParameter"}
        if structural:
            self.fmu.enterConfigurationMode()
            self.set(structural)
            self.fmu.exitConfigurationMode()
        self.set(early)
        if self.is_fmi2:
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(tolerance=tolerance, startTime=start, stopTime=stop)
        self.set({name: value for name, value in values.items() if name not in early and name not in structural})
        begin()
        self.fmu.exitInitializationMode()
        if self.kind == "ModelExchange":
            self.settle()
            self.fmu.enterContinuousTimeMode()

    def settle(self) -> None:
        """Events are iterated until nothing changes. Raises AskedToEnd when the FMU wants to stop."""
        for _ in range(_MOST_UPDATES):
            again, stops, _nominals, _values, defined, when = (
                self.fmu.newDiscreteStates() if self.is_fmi2 else self.fmu.updateDiscreteStates())
            self.next_event = when if defined else None
            if stops:
                raise AskedToEnd("the FMU asked to end the simulation")
            if not again:
                return
        raise FmuError(f"its event did not settle in {_MOST_UPDATES} iterations")

    def handle_event(self, set_inputs: Callable[[], None]) -> None:
        """Enters event mode, sets inputs, settles, and leaves it again."""
        self.fmu.enterEventMode()
        set_inputs()
        self.settle()
        self.fmu.enterContinuousTimeMode()

    def completed_step(self) -> bool:
        """Whether it asks for an event."""
        if not self.interface.needsCompletedIntegratorStep:
            return False
        event, stops = self.fmu.completedIntegratorStep()
        if stops:
            raise AskedToEnd("the FMU asked to end the simulation")
        return bool(event)

    def step(self, t: float, h: float) -> float:
        """A communication step; returns the time reached."""
        from fmpy.fmi1 import FMICallException
        from fmpy.fmi2 import fmi2Terminated

        if not self.is_fmi2:
            _event, stops, early, reached = self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)
            if stops:
                raise AskedToEnd("the FMU asked to end the simulation")
            return float(reached) if early and reached < t + h else t + h
        try:
            self.fmu.doStep(currentCommunicationPoint=t, communicationStepSize=h)
        except FMICallException as error:
            if error.status == DISCARD and self.fmu.getBooleanStatus(fmi2Terminated):
                raise AskedToEnd("the FMU asked to end the simulation") from None
            raise
        return t + h

    def reset(self) -> None:
        """Back to what it was when it was made."""
        self.fmu.reset()
        self.next_event = None

    # ---------------------------------------------------------------- vectors of Model Exchange

    def states(self) -> list[float]:
        """Continuous states."""
        return self._vector(self.fmu.getContinuousStates)

    def slopes(self) -> list[float]:
        """Their derivatives."""
        return self._vector(self.fmu.getDerivatives if self.is_fmi2 else self.fmu.getContinuousStateDerivatives)

    def nominals(self) -> list[float]:
        """Their nominal sizes."""
        return self._vector(self.fmu.getNominalsOfContinuousStates)

    def set_states(self, x: Sequence[float]) -> None:
        """Puts continuous states in."""
        self.fmu.setContinuousStates((ctypes.c_double * len(x))(*x), len(x))

    def _vector(self, function: Callable[[Any, int], Any]) -> list[float]:
        n = self.description.numberOfContinuousStates
        values = (ctypes.c_double * max(n, 1))()
        if n > 0:
            function(values, n)
        return list(values)[:n]


def is_recorded(kind: str) -> bool:
    """Whether variables of a kind can stand in rows of results."""
    return kind in _RECORDED


class Table:
    """Inputs over time: straight lines between rows, a jump where a time stands twice, held beyond the ends. Of an array all
    elements are among the names."""

    def __init__(self, importer: Importer, names: Sequence[str], times: Sequence[float], rows: Sequence[Sequence[float]]) -> None:
        self.importer, self.names, self.times, self.rows = importer, names, times, rows
        self.jumps = [a for a, b in pairwise(times) if a == b]
        self.passed = -math.inf  # time of the latest event, after which inputs have jumped
        groups: dict[str, dict[int, dict[int, int]]] = {}  # kind, value reference, element: place among the names
        for k, name in enumerate(names):
            variable, element, _ = importer.find(name)
            groups.setdefault(variable.type, {}).setdefault(variable.valueReference, {})[element] = k
        self.setters = [(importer.setter(kind), list(found), [own[k] for own in found.values() for k in sorted(own)], kind)
                        for kind, found in groups.items()]

    def next_jump(self, t: float) -> float | None:
        """The first time after t at which an input jumps; None after the last."""
        return next((jump for jump in self.jumps if jump > t), None)

    def next_corner(self, t: float) -> float | None:
        """The first time after t at which an input may bend; None after the last."""
        return next((corner for corner in self.times if corner > t), None) if self.names else None

    def at(self, t: float, is_after: bool) -> tuple[list[float], list[float]]:
        """Values and slopes; at a jump those before it or after it."""
        from bisect import bisect_left, bisect_right

        k = bisect_right(self.times, t) if is_after else bisect_left(self.times, t)
        if k == 0 or k == len(self.times):
            return list(self.rows[0 if k == 0 else -1]), [0.0] * len(self.names)
        a, b = self.times[k - 1], self.times[k]
        pairs = list(zip(self.rows[k - 1], self.rows[k], strict=True))
        return [x + (y - x) * (t - a) / (b - a) for x, y in pairs], [(y - x) / (b - a) for x, y in pairs]

    def hold(self, t: float, end: float) -> None:
        """The means over a step, for FMUs that cannot follow slopes: the impulse of a force is exact then."""
        first, last = self.at(t, True)[0], self.at(end, False)[0]
        for setter, references, places, kind in self.setters:
            is_float = kind in ("Real", "Float32", "Float64")
            setter(references, [_as(kind, (first[k] + last[k]) / 2 if is_float else first[k]) for k in places])

    def apply(self, t: float, is_after: bool, with_slopes: bool = False) -> None:
        """Sets all inputs as at t, on one side of a jump; with their slopes where the FMU takes them."""
        if not self.names:
            return
        self.passed = t if is_after else self.passed
        values, slopes = self.at(t, is_after or t == self.passed)
        for setter, references, places, kind in self.setters:
            setter(references, [_as(kind, values[k]) for k in places])
            if with_slopes and kind == "Real":
                self.importer.fmu.setRealInputDerivatives(references, [1] * len(places), [slopes[k] for k in places])


def _as(kind: str, value: float) -> float | int | bool:
    if kind in ("Real", "Float32", "Float64"):
        return value
    return value != 0 if kind == "Boolean" else round(value)
