"""Names as people write them -> expressions: `hinge.phi`, `der(hinge.phi)`, `bar.center.x`, `P.force[2]`."""

import re

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.flat import FlatModel
from lagrangia.language.frame_attributes import REACTIONS
from lagrangia.language.instances import held_port
from lagrangia.language.tree import Call, Flat, FrameRef, Ref

_INDEXED = re.compile(r"(.*)\[([\d,]+)\]")


def observe(model: FlatModel, name: str) -> Flat:
    """The expression that a name stands for. Raises LagError L0701 for an unknown one, with the nearest known."""
    text = name.strip()
    if text.startswith("der(") and text.endswith(")"):
        return Call("der", (observe(model, text[4:-1]),), (), model.span)
    found = _variable(model, text, model.span) or _frame(model, text, model.span) or _reaction(model, text, model.span)
    if found is None:
        _refuse_of_other_space(model, text)
        known = [*model.variables, *(f"{frame}.x" for frame in model.frames)]
        fail("L0701", f"there is no quantity '{name}' in {model.name}", None, *filter(None, [suggest(text, known)]))
    return found


def _variable(model: FlatModel, text: str, span: Span) -> Flat | None:
    if text in model.variables:
        return Ref(text, (), span)
    match = _INDEXED.fullmatch(text)
    if match and match[1] in model.variables:
        index = tuple(int(i) for i in match[2].split(","))
        shape = model.variables[match[1]].shape
        if len(index) <= len(shape) and all(1 <= i <= size for i, size in zip(index, shape, strict=False)):
            return Ref(match[1], index, span)
    return None


def _indexed(text: str) -> tuple[str, tuple[int, ...]]:
    """P.r[2] -> P.r and (2,)."""
    match = _INDEXED.fullmatch(text)
    return (match[1], tuple(map(int, match[2].split(",")))) if match else (text, ())


def _frame(model: FlatModel, text: str, span: Span) -> Flat | None:
    path, index = _indexed(text)
    frame, _, attribute = path.rpartition(".")
    known = model.space.attributes
    if frame in model.frames and attribute in model.space.of_any_frame and known[attribute].has_element(index):
        return FrameRef(frame, attribute, index, span, model.space.is_spatial)
    return None


def _refuse_of_other_space(model: FlatModel, text: str) -> None:
    """What a frame has in the plane alone, and what to ask for instead."""
    frame, _, attribute = _indexed(text)[0].rpartition(".")
    if frame in model.frames and attribute in model.space.missing:
        fail("L0701", f"there is no quantity '{text}' in {model.name}", None, model.space.missing[attribute])


def _reaction(model: FlatModel, text: str, span: Span) -> Flat | None:
    path, index = _indexed(text)
    joint, _, attribute = path.rpartition(".")
    frames = [name.rpartition(".")[2] for name in model.frames if name.rpartition(".")[0] == joint and not name.endswith("]")]
    port = held_port(frames) if attribute in REACTIONS and model.space.attributes[attribute].has_element(index) else None
    return FrameRef(f"{joint}.{port}", attribute, index, span, model.space.is_spatial) if port is not None else None
