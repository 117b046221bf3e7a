"""Parameters that do not meet what the compiler asks of them beyond their limits (compile/requirements.py), in words."""

from collections.abc import Collection, Mapping, Sequence
from typing import Any

from lagrangia.base.diagnostics import Diagnostic, LagError
from lagrangia.run.interpret import evaluate
from lagrangia.run.scene import Scene


def check_requirements(scene: Scene, parameters: Sequence[float]) -> None:
    """Raises LagError L0605 for the first that is not met."""
    tape = scene.tapes.get("requirements")
    if tape is not None and (first := int(evaluate(tape, parameters)[0][0])) >= 0:
        known = scene.notes["requirements"][first]
        values = ", ".join(_valued(scene, known, parameters))
        hint = known["advice"] or (f"what it is, is decided by parameters as they are declared: declare {values}" if values else
                                   f"declared at {known['place']}")
        said = tell_unmet(scene, first, parameters)
        raise LagError([Diagnostic("error", "L0605", said, hints=(hint,), excerpt=known["excerpt"])])


def asks_for(scene: Scene, places: Collection[int]) -> bool:
    """Whether values of the parameters at these places enter any of them."""
    tape = scene.tapes.get("requirements")
    return tape is not None and bool(tape.reached(scene.tapes["parameters"].reached({(0, k) for k in places})))


def tell_unmet(scene: Scene, index: int, parameters: Sequence[float]) -> str:
    """What the requirement with this place says where all these parameters do not meet it."""
    known = scene.notes["requirements"][index]
    return " with ".join(filter(None, (known["said"], ", ".join(_valued(scene, known, parameters)))))


def tell_requirement(known: Mapping[str, Any]) -> str:
    """The same, whatever the parameters are."""
    asked = known["parameters"]
    return f"{known['said']} with these {', '.join(asked)}" if asked else str(known["said"])


def _valued(scene: Scene, known: Mapping[str, Any], parameters: Sequence[float]) -> list[str]:
    asked = set(known["parameters"])
    return [f"{p.name} = {x:g}" for p, x in zip(scene.parameters, parameters, strict=True) if p.name in asked]
