"""What events say: conditions as numbers that are positive where they are true, the rates that are reset, and contacts.

A contact keeps x from falling below 0:  when x < 0 then reinit(der(x), ...).  The force that holds it there is contact_force(x).
"""

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.language.flat import FlatModel, Reset, When
from lagrangia.language.frame_attributes import as_element, is_velocity, place_of
from lagrangia.language.tree import Binary, Boolean, Call, Flat, FrameRef, Number, Ref, Unary

COMPARED = ("<", "<=", ">", ">=")


def parts_of(node: Flat) -> Iterator[Flat]:
    """What all has to be true."""
    if isinstance(node, Binary) and node.operator == "and":
        yield from (*parts_of(node.left), *parts_of(node.right))
    else:
        yield node


def level_of(node: Flat) -> Flat:
    """Positive where a condition is true: continuous, as what it compares is. Raises LagError L0225."""
    match node:
        case Binary(("<" | "<="), left, right, span):
            return Binary("-", right, left, span)
        case Binary((">" | ">="), left, right, span):
            return Binary("-", left, right, span)
        case Binary("and" | "or" as operator, left, right, span):
            return Call("min" if operator == "and" else "max", (level_of(left), level_of(right)), (), span)
        case Unary("not", operand, span):
            return Unary("-", level_of(operand), span)
        case Boolean(value, span):
            return Number(1.0 if value else -1.0, None, span)
    fail("L0225", "an event comes where a comparison comes true: this is none that does", node.span,
         "compare with <, <=, > or >=, as x < 0; conditions go together with and, or, not")


def position_of(reset: Reset, model: FlatModel) -> Flat:
    """That of which a rate is reset. Raises LagError L0225."""
    position = _moved_at(reset.rate, model)
    if position is not None:
        return position
    fail("L0225", "reinit sets a rate, this is none", reset.rate.span,
         "write: reinit(der(x), value), for any position or angle x")


def _moved_at(node: Flat, model: FlatModel) -> Flat | None:
    """That of which an expression is the rate; None where it is none."""
    while isinstance(node, Ref) and not node.index and (variable := model.variables[node.name]).kind == "variable":
        assert variable.binding is not None
        node = variable.binding
    match node:
        case Call("der", (position,), _, _) if not (isinstance(position, Call) and position.function == "der"):
            return position
        case FrameRef(_, attribute) if is_velocity(attribute) and (place := place_of(node)) is not None:
            return replace(node, attribute=place)
    return None


def contact_of(kept: Sequence[Flat | None], x: Flat) -> int | None:
    """The first event that is a contact of x, by its place among all, of which `held_by` tells."""
    return next((k for k, own in enumerate(kept) if are_alike(own, x)), None)


def kept_by(model: FlatModel, when: When) -> Flat | None:
    """The x of which an event is a contact: x < 0 comes true."""
    return next((x for small, x in _below(model, when) if are_alike(small, x)), None)


def held_by(model: FlatModel, when: When) -> Flat | None:
    """The x of which an event is a contact, or which it lets go one way: der(x) < 0 comes true."""
    return next((x for small, x in _below(model, when) if are_alike(small, x) or are_alike(_moved_at(small, model), x)), None)


def _below(model: FlatModel, when: When) -> Iterator[tuple[Flat, Flat]]:
    """What falls below zero, beside each position of which a rate is reset."""
    positions = [position_of(reset, model) for reset in when.resets]
    for node in parts_of(when.condition):
        if (small := _below_zero(node)) is not None:
            yield from ((small, x) for x in positions)


def name_of_contact(event: int) -> str:
    """By which the evaluator asks for the force that holds what rests at the contact of an event."""
    return f"contact_force({event})"


def _below_zero(node: Flat) -> Flat | None:
    """Of x < 0, or 0 > x: x."""
    if not (isinstance(node, Binary) and node.operator in COMPARED):
        return None
    small, large = (node.left, node.right) if node.operator.startswith("<") else (node.right, node.left)
    return small if isinstance(large, Number) and large.value == 0 else None


def are_alike(a: Any, b: Any) -> bool:
    """The same expression, wherever it is written."""
    if a.__class__ is not b.__class__:
        return False
    if isinstance(a, FrameRef):
        return a.name == b.name and as_element(a) == as_element(b)
    if isinstance(a, tuple):
        return len(a) == len(b) and all(map(are_alike, a, b))
    if not is_dataclass(a):
        return bool(a == b)
    return all(are_alike(getattr(a, f.name), getattr(b, f.name)) for f in fields(a) if f.name != "span")
