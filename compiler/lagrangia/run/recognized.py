"""Parameters with which an event is not what it was taken for when its scene was compiled, a contact or a kick, in words."""

from collections.abc import Mapping, Sequence
from typing import Any

from lagrangia.base.diagnostics import Report
from lagrangia.run.interpret import evaluate
from lagrangia.run.scene import Scene


def require_recognized(scene: Scene, parameters: Sequence[float], report: Report) -> None:
    """Raises LagError L0605 for the first of the comparisons that does not hold."""
    tape = scene.tapes.get("recognized")
    if tape is not None and (first := int(evaluate(tape, parameters)[0][0])) >= 0:
        values = ", ".join(_valued(scene, scene.notes["recognized"][first], parameters))
        report.error("L0605", tell_unrecognized(scene, first, parameters), None,
                     f"what it is, is decided by parameters as they are declared: declare {values}")
        report.raise_errors()


def tell_unrecognized(scene: Scene, index: int, parameters: Sequence[float]) -> str:
    """What the comparison with this place says where it does not hold for all these parameters."""
    known = scene.notes["recognized"][index]
    return f"{_what(known)} with {', '.join(_valued(scene, known, parameters))}"


def tell_recognized(known: Mapping[str, Any]) -> str:
    """The same, whatever the parameters are."""
    return f"{_what(known)} with these {', '.join(known['parameters'])}"


def _what(known: Mapping[str, Any]) -> str:
    what = "becomes" if known["makes"] else "ceases to be"
    return f"the event at '{known['event']}' {what} a contact, which holds what rests there,"


def _valued(scene: Scene, known: Mapping[str, Any], parameters: Sequence[float]) -> list[str]:
    asked = set(known["parameters"])
    return [f"{p.name} = {x:g}" for p, x in zip(scene.parameters, parameters, strict=True) if p.name in asked]
