"""What scenes in space do not have yet: each is refused by name where it is asked for, until its row is struck out."""

from collections.abc import Mapping

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.flat import FlatModel
from lagrangia.language.mentions import reached
from lagrangia.language.tree import Call, Flat, FrameRef

# What is refused, and what can be done instead.
NOT_YET: Mapping[str, tuple[str, str]] = {
    "events": ("events and contacts of frames", "events of coordinates are there: when hinge.phi < 0 then ..."),
    "massless": ("places without mass beside torques on attitudes", "give what moves there a mass"),
    "probes": ("responses to frames that are moved", "of inputs and of prescribed coordinates they are there"),
}


def refuse_in_space(model: FlatModel, what: str, span: Span | None = None) -> None:
    """Raises LagError L0901 for a scene in space that asks for a row of the table."""
    if not model.space.is_spatial or what not in NOT_YET:
        return
    told, instead = NOT_YET[what]
    fail("L0901", f"not supported yet: {told} in space", span or model.span, instead, *why_spatial(model))


def why_spatial(model: FlatModel) -> tuple[str, ...]:
    """What makes the scene spatial, for people."""
    found = model.found
    return (f"the scene is in space since {found.why} ({found.span})",) if found.span is not None else ()


def refuse_statements_in_space(model: FlatModel) -> None:
    """Raises LagError L0901 for what a scene in space states and cannot have yet."""
    if not model.space.is_spatial:
        return
    bindings = {name: variable.binding for name, variable in model.variables.items()}
    for when in model.whens:
        if any(map(_reads_frames, reached(when.expressions(), bindings))):
            refuse_in_space(model, "events", when.span)


def _reads_frames(node: Flat) -> bool:
    return isinstance(node, FrameRef) or (isinstance(node, Call) and node.function == "distance")
