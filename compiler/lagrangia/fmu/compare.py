"""An FMU beside the run of the model it was made from, when its source is inside (export.py puts it there)."""

import json
import math
import os
import warnings
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

from lagrangia.base.diagnostics import LagError, RunError, RunWarning
from lagrangia.base.records import dataclass
from lagrangia.base.search_path import searching_in
from lagrangia.fmu.description import labels, number_in
from lagrangia.fmu.export import EXTRA, SCENE
from lagrangia.fmu.process import ENDED, SPOKEN, Job, Outcome, run_job
from lagrangia.fmu.run import Opened
from lagrangia.run.request import Request
from lagrangia.run.scene import Scene

if TYPE_CHECKING:
    import numpy as np

_ROWS = 100
_ALLOWED = 100  # tolerances
_LOOSER = 10  # how much the second native run is looser than the first: shows how errors grow
_TIGHTER = 100  # tolerance of CVode below that of the run: its errors add up from step to step
_TIGHTEST = 1e-12
_GROWN = 1e5  # tolerances: a motion that tells nothing any more


class Native(Protocol):
    """What a model is asked for here."""

    @property
    def scene(self) -> Scene:
        """What there is to compare."""

    def run(self, request: Request) -> Any:
        """The columns of a run, by name."""


Load = Callable[[Path, str | None, Mapping[str, Any], tuple[str, ...]], Native]


@dataclass(frozen=True)
class Comparison:
    """`message` for people; `is_wrong`: the FMU failed, or its motion is another one."""

    message: str
    is_wrong: bool


def source_of(opened: Opened, folder: Path, load: Load) -> Native | None:
    """The model in extra/, as it was exported, by what loads one; None where there is none. Raises LagError."""
    base = f"extra/{EXTRA}/"
    if base + SCENE not in opened.archive.names:
        return None
    try:
        scene = json.loads(opened.archive.read(base + SCENE))
        file, name, structural, outputs = (scene[key] for key in ("file", "model", "structural", "outputs"))
    except (ValueError, KeyError, TypeError):
        return None
    path = Path(os.path.realpath(folder / base / file))
    if not path.is_relative_to(folder.resolve()):
        return None
    inside = [str(place) for place in (folder / base / part for part in scene.get("path", [])) if place.is_dir()]
    with searching_in(inside):
        return load(path, name, structural, tuple(outputs))


def compare(opened: Opened, folder: str, kinds: list[str], load: Load, seconds: float) -> list[Comparison]:
    """Every kind over the default experiment, given up after `seconds`, against the native run where the source is inside."""
    if not kinds:
        return []
    try:
        model = source_of(opened, Path(folder), load)
    except LagError as error:
        return [Comparison(f"the source inside does not compile: {error.diagnostics[0].message}", True)]
    span = experiment_of(opened)
    if model is None:
        return [_alone(folder, kind, *span, seconds) for kind in kinds]
    parameters = _parameters(opened, model)
    try:
        native = _NativeRun(model, span[0], span[1], span[2], parameters)
    except (LagError, RunError) as error:
        return [Comparison(f"the native run of the source inside fails: {error}", True)]
    return [native.compared(opened, folder, kind, seconds) for kind in kinds]


def experiment_of(opened: Opened) -> tuple[float, float, float]:
    """Start, stop, tolerance."""
    start = opened.number("startTime") or 0.0
    stop, tolerance = opened.number("stopTime"), opened.number("tolerance")
    return start, stop if stop is not None and stop > start else start + 1.0, tolerance or 1e-6


def _alone(folder: str, kind: str, start: float, stop: float, tolerance: float, seconds: float) -> Comparison:
    times = [start + (stop - start) * k / _ROWS for k in range(_ROWS)] + [stop]
    outcome = run_job(Job(folder, kind, times, stop, tolerance), seconds)
    if outcome.message:
        return _stopped(kind, outcome)
    return Comparison(f"{SPOKEN[kind]} runs from {start:g} to {stop:g} s", False)


def _stopped(kind: str, outcome: Outcome) -> Comparison:
    """An end that the FMU asked for is none of its faults, nor is our patience."""
    is_wrong = not (outcome.is_asked_for or outcome.is_given_up)
    return Comparison(f"{SPOKEN[kind]}: at t = {outcome.time:.9g}, {outcome.explanation}", is_wrong)


def _parameters(opened: Opened, model: Native) -> dict[str, float]:
    """The start values that the FMU gives to the model's parameters."""
    known = {p.name for p in model.scene.parameters}
    description = opened.description
    free = [q for q in description.quantities if q.causality == "parameter" and q.is_float]
    starts = {name: text for q in free for name, text in zip(labels(q.name, description.shape(q)), q.starts, strict=False)}
    return {name: x for name, text in starts.items() if name in known and not math.isnan(x := number_in(text))}


class _NativeRun:
    """The native run, and how far errors of the size of the tolerance are grown at each time."""

    def __init__(self, model: Native, start: float, stop: float, tolerance: float, parameters: Mapping[str, float]) -> None:
        import numpy as np

        self.model, self.tolerance, self.stop = model, tolerance, stop
        self.times = [start + (stop - start) * k / _ROWS for k in range(_ROWS)] + [stop]
        columns = (*model.scene.told_positions, *model.scene.own_outputs)
        self.names = [column.name for column in columns]
        asked = Request(start, stop, max(tolerance, 1e-14), at=self.times, parameters=parameters)
        run = model.run(asked)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RunWarning)  # how far off it is, is what is asked
            looser = model.run(replace(asked, tolerance=max(tolerance * _LOOSER, 1e-14)))
        self.values = np.array([run[name] for name in self.names])
        self.scale = _scales(columns, self.values)[:, None]
        grown = np.abs(np.array([looser[name] for name in self.names]) - self.values) / self.scale
        self.allowed = _ALLOWED * tolerance + _LOOSER * np.maximum.accumulate(grown.max(axis=0, initial=0.0))

    def compared(self, opened: Opened, folder: str, kind: str, seconds: float) -> Comparison:
        """The motion of the FMU beside its own."""
        import numpy as np

        tolerance = self.tolerance if kind == "cs" else max(self.tolerance / _TIGHTER, _TIGHTEST)
        description = opened.description
        missing = [name for name in self.names if name not in description.by_name and description.element(name) is None]
        if missing:
            return Comparison(f"the source inside has '{missing[0]}', and the FMU does not", True)
        outcomes = []
        for used in (tolerance, *((_LOOSER * tolerance,) if kind == "me" else ())):
            outcomes.append(run_job(Job(folder, kind, self.times, self.stop, used, self.names), seconds))
            if outcomes[-1].message:
                return _stopped(kind, outcomes[-1])
        found = [np.frombuffer(outcome.rows).reshape(-1, 1 + len(self.names))[:, 1:].T for outcome in outcomes]
        if any(rows.shape != self.values.shape for rows in found):  # the FMU has forged them
            return Comparison(f"{SPOKEN[kind]}: {ENDED}", True)
        own = np.abs(found[-1] - found[0]) / self.scale  # errors of CVode, which has no tolerance for the whole
        return self._judged(kind, found[0], self.allowed + _LOOSER * np.maximum.accumulate(own.max(axis=0, initial=0.0)))

    def _judged(self, kind: str, found: "np.ndarray", allowed: "np.ndarray") -> Comparison:
        import numpy as np

        apart = np.nan_to_num(np.abs(found - self.values) / self.scale, nan=np.inf)
        worst = apart.max(axis=0, initial=0.0)
        k = int(np.argmax(worst / allowed))
        where = f"{SPOKEN[kind]} from {self.times[0]:g} to {self.stop:g} s"
        if worst[k] <= allowed[k]:
            grown = float(allowed.max())
            more = f", in which errors as large as the tolerance grow to {grown:.0e}" if grown > _GROWN * self.tolerance else ""
            return Comparison(f"{where}: within {worst.max():.1e} of the native run{more}", False)
        name = self.names[int(np.argmax(apart[:, k]))]
        return Comparison(f"{where}: '{name}' is {worst[k]:.1e} of its size away from the native run at t = {self.times[k]:g}, "
                          f"where {allowed[k]:.1e} could be", True)


def _scales(columns: Any, values: "np.ndarray") -> "np.ndarray":
    """The size of each quantity, at least that of all in its unit; 1 for angles."""
    import numpy as np

    own = np.abs(values).max(axis=1, initial=0.0)
    units = [column.unit for column in columns]
    together = {unit: max(size for size, other in zip(own, units, strict=True) if other == unit) for unit in units}
    return np.array([max(together[unit], 1.0 if unit == "rad" else 1e-6) for unit in units])
