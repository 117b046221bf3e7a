"""Assertions and ends of a run, in words."""

from collections.abc import Iterator, Mapping
from typing import Any

from lagrangia.base.diagnostics import Diagnostic, LagError
from lagrangia.run.runtime import Failure, Run, Status
from lagrangia.run.scene import Scene


def of_guard(scene: Scene, failure: Failure) -> str:
    """What has ended a run, when, where it is written, and what its condition compares there."""
    guard = _guards(scene)[failure.index]
    told = f"{guard['text']} ({guard['condition']}, {_place(guard)}"
    if failure.status is Status.ENDED:
        return f"ended at t = {failure.time:.9g}: {told})"
    first = sum(len(before["seen"]) for before in _guards(scene)[: failure.index])
    values = [f"{name} = {value:.9g}" for name, value in zip(guard["seen"], failure.seen[first:], strict=False)]
    when = "of parameters does not hold" if guard["is_of_parameters"] else f"does not hold at t = {failure.time:.9g}"
    return f"an assertion {when}: {told}{': ' if values else ''}{', '.join(values)})"


def refuse_parameters(scene: Scene, failure: Failure) -> None:
    """Raises LagError L0605 where it is by its parameters that a run has failed an assertion."""
    if failure.status is not Status.ASSERTED or not _guards(scene)[failure.index]["is_of_parameters"]:
        return
    hint, excerpt = "choose others of the parameters that it compares", str(_guards(scene)[failure.index]["excerpt"])
    raise LagError([Diagnostic("error", "L0605", of_guard(scene, failure), hints=(hint,), excerpt=excerpt)])


def warnings_of(scene: Scene, run: Run) -> Iterator[Diagnostic]:
    """Those that are news, but where the model allows them."""
    for index, time in run.warnings() if "guards" in scene.notes else ():
        guard = _guards(scene)[index]
        if "L0610" not in scene.notes["allowed"]:
            what = f"an assertion does not hold, first at t = {time:.9g}: {guard['text']} ({guard['condition']}, {_place(guard)})"
            yield Diagnostic("warning", "L0610", what, excerpt=str(guard["excerpt"]))


def guard_in_general(scene: Scene, index: int) -> str:
    """What does not hold, and where it is written."""
    guard = _guards(scene)[index]
    return f"an assertion does not hold: {guard['text']} ({guard['condition']}, {_place(guard)})"


def broken_in_general(scene: Scene, index: int, before: str, after: str) -> Diagnostic:
    """The same as a warning, between what else there is to say."""
    what = f"{before}{guard_in_general(scene, index)}{after}"
    return Diagnostic("warning", "L0610", what, excerpt=str(_guards(scene)[index]["excerpt"]))


def _guards(scene: Scene) -> list[Mapping[str, Any]]:
    found: list[Mapping[str, Any]] = scene.notes["guards"]
    return found


def _place(guard: Mapping[str, Any]) -> str:
    return f"{guard['component']}, {guard['place']}" if guard["component"] else str(guard["place"])
