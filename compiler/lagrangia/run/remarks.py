"""What a run does that nobody asked for: inputs that nothing is given for, tables of inputs that end before it does, parameters
that change nothing beside others that are given, or make an inertia of no body; and rows that are no motion of the scene."""

import sys
import warnings
from collections.abc import Collection, Iterable, Mapping
from typing import Any, Protocol

from lagrangia.base.checked_values import by_name
from lagrangia.base.diagnostics import InputWarning, RunWarning
from lagrangia.run.overridden import all_names, may_be_overridden, overridden_remarks
from lagrangia.run.request import Experiment, Request, check_values, plan
from lagrangia.run.scene import Scene
from lagrangia.run.simulate import Progress, loss

_OWN = "lagrangia."


class Told(Protocol):
    """A Model, as far as it is asked here."""

    @property
    def scene(self) -> Scene:
        """Its scene."""

    @property
    def readers(self) -> Mapping[str, list[str]]:
        """Of parameters that nothing reads but others that can be given, these."""


def input_remarks(scene: Scene, experiment: Experiment, given: Any, later: Collection[str] = ()) -> list[str]:
    """Warnings, as `lag` prints them. `given` as in a Request; the names `later` get their values during the run."""
    times, columns = given if isinstance(given, tuple) else ((), given or {})
    found = []
    for known in scene.inputs:
        if known.name not in columns and not known.is_stated and known.name not in later and not known.name.startswith("der("):
            value = f"{known.value or 0:g} {known.unit}".rstrip()
            found.append(f"warning[L0708]: nothing is given for the input '{known.name}': it is {value} throughout\n"
                         f"   = give it with -u {known.name}=VALUE, or -u FILE.csv")
    if len(times) and (times[-1] < experiment.stop or times[0] > experiment.start):
        found.append(f"warning[L0709]: the table of inputs goes from {times[0]:g} to {times[-1]:g} s, the run from "
                     f"{experiment.start:g} to {experiment.stop:g} s: beyond its ends the inputs keep their values")
    if (between := next((a for a, b in zip(times, times[2:], strict=False) if a == b), None)) is not None:
        found.append(f"warning[L0709]: the table of inputs has more than two rows at {between:g} s: those between the first and "
                     "the last have no effect")
    return found


def given_remarks(model: Told, request: Request, more: Iterable[str] = ()) -> list[str]:
    """The same of parameters that change nothing beside others, or make an inertia that no rigid body has; `more` are names of
    what each run of a sweep has its own of."""
    several = list(more)
    parameters, initial = all_names(request.parameters, several), all_names(request.initial, several)
    is_asked = may_be_overridden(parameters, all_names(request.initial))
    vain = overridden_remarks(model.scene, model.readers, parameters, initial) if is_asked else []
    given = by_name("parameters", request.parameters)
    if not given or "inertias" not in model.scene.notes or {p.name for p in model.scene.parameters} & {*several}:
        return vain  # the sweep tells of its runs
    from lagrangia.run.odd_inertias import odd_inertia_remarks

    return [*vain, *odd_inertia_remarks(model.scene, given)]


def warn_of_given(model: Told, request: Request, more: Iterable[str] = (), later: Collection[str] = (),
                  others: Iterable[str] = ()) -> None:
    """The same in Python and `others`, as InputWarnings at the line that called who calls this, but those that the model allows;
    inputs may be a list of those of several runs. Raises LagError for a request that is none."""
    scene, found = model.scene, dict[str, None]()
    by_name("parameters", request.parameters)
    by_name("start values", request.initial)
    if scene.inputs:  # else what is given all the same the run refuses
        experiment = plan(scene, request)
        for given in request.inputs if isinstance(request.inputs, list) else [request.inputs]:
            check_values(scene, inputs=given)
            found |= dict.fromkeys(input_remarks(scene, experiment, given, later))
    _warn(scene, [*found, *given_remarks(model, request, more), *others])


def warn_of_vain(model: Told, parameters: Any, initial: Any = None) -> None:
    """The same of parameters and start values alone."""
    _warn(model.scene, given_remarks(model, Request(parameters=parameters, initial=initial)))


def _warn(scene: Scene, texts: Iterable[str]) -> None:
    for text in texts:
        warn_of_text(scene, text)


def warn_of_text(scene: Scene, text: str) -> None:
    """An InputWarning that `lag` would print, but where the model allows it."""
    head, _, message = text.partition("\n")[0].partition(": ")
    if head.removeprefix("warning[").removesuffix("]") not in scene.notes["allowed"]:
        warn_of_run(f"{message} ({head[8:13]})", InputWarning)


def warn_of_loss(progress: Progress) -> None:
    """Of rows that cannot be those of the scene, a RunWarning."""
    if why := loss(progress):
        warn_of_run(why)


def warn_of_run(why: str, kind: type[Warning] = RunWarning) -> None:
    """A warning at the line that called what belongs to this package."""
    frame, level = sys._getframe(), 1
    while frame.f_back is not None and frame.f_globals.get("__name__", "").startswith(_OWN):
        frame, level = frame.f_back, level + 1
    warnings.warn(why, kind, stacklevel=level)
