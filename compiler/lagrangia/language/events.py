"""What events say: conditions as numbers that are positive where they are true, the rates that are reset, and contacts.

A contact keeps x from falling below 0:  when x < 0 then reinit(der(x), ...).  The force that holds it there is contact_force(x).
"""

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass, replace
from functools import reduce
from typing import Any

from lagrangia.base.diagnostics import fail
from lagrangia.language.flat import FlatModel, Reset, When
from lagrangia.language.frame_attributes import as_element, is_velocity, place_of
from lagrangia.language.tree import Array, Binary, Boolean, Call, Flat, FrameRef, Number, Ref, Unary

COMPARED = ("<", "<=", ">", ">=")


def parts_of(node: Flat) -> Iterator[Flat]:
    """What all has to be true."""
    if isinstance(node, Binary) and node.operator == "and":
        yield from (*parts_of(node.left), *parts_of(node.right))
    else:
        yield node


def comparisons_in(node: Flat) -> Iterator[Flat]:
    """All comparisons of a condition that is without `not`, also of alternatives."""
    if isinstance(node, Binary) and node.operator in ("and", "or"):
        yield from (*comparisons_in(node.left), *comparisons_in(node.right))
    elif isinstance(node, Binary) and node.operator in COMPARED:
        yield node


def without_not(node: Flat, is_true: bool = True) -> Flat:
    """The same condition, or where not `is_true` its opposite, by De Morgan's laws: not (a > 0 or b > 0) is a <= 0 and b <= 0."""
    match node:
        case Unary("not", operand, _):
            return without_not(operand, not is_true)
        case Binary("and" | "or" as operator, left, right, span):
            kept = operator if is_true else "or" if operator == "and" else "and"
            return Binary(kept, without_not(left, is_true), without_not(right, is_true), span)
        case Binary(("<" | "<=" | ">" | ">=") as operator, left, right, span) if not is_true:
            return Binary({"<": ">=", "<=": ">", ">": "<=", ">=": "<"}[operator], left, right, span)
    return node if is_true else Unary("not", node, node.span)


def condition_of(when: When, model: FlatModel) -> Flat:
    """Without `not`, and with each of what has to be below something, or above it, by itself, so that each may be a contact:
    max(x, y) < 0 is x < 0 and y < 0, unless what is reset is the rate of the largest."""
    return _in_parts(without_not(when.condition), model, [position_of(reset, model) for reset in when.resets])


def _in_parts(node: Flat, model: FlatModel, positions: Sequence[Flat]) -> Flat:
    match node:
        case Binary("and" | "or" as operator, left, right, span):
            return Binary(operator, _in_parts(left, model, positions), _in_parts(right, model, positions), span)
        case Binary(("<" | "<=" | ">" | ">=") as operator, left, right, span):
            is_below = operator.startswith("<")
            for own, wanted in ((left, "max" if is_below else "min"), (right, "min" if is_below else "max")):
                if not any(are_alike(own, x) for x in positions) and (several := _several(own, wanted, model)):
                    sides = (((x, right) if own is left else (left, x)) for x in several)
                    parts = [_in_parts(Binary(operator, *pair, span), model, positions) for pair in sides]
                    return reduce(lambda a, b: Binary("and", a, b, span), parts)
    return node


def _several(node: Flat, wanted: str, model: FlatModel) -> tuple[Flat, ...]:
    """Of what a call of max, or of min as is `wanted`, which may have a name, is the largest or least; else nothing."""
    match node:
        case Ref(name, (), _) if (variable := model.variables[name]).kind == "variable" and not variable.shape:
            return () if variable.binding is None else _several(variable.binding, wanted, model)
        case Call(function, (Array(items, _),), _, _) if function == wanted:
            return items
        case Call(function, arguments, _, _) if function == wanted and len(arguments) > 1:
            return arguments
    return ()


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


def find_changes(whens: Sequence[When]) -> set[int]:
    """The events of a `when` that comes where a condition becomes true, and where it becomes false."""
    groups = dict[tuple[str, int], list[int]]()
    for k, when in enumerate(whens):
        groups.setdefault((when.component, when.span.start), []).append(k)
    return {k for group in groups.values() for k in group for other in group
            if are_alike(without_not(whens[k].condition), without_not(whens[other].condition, False))}


def position_of(reset: Reset, model: FlatModel) -> Flat:
    """That of which a rate is reset. Raises LagError L0225."""
    position = _moved_at(reset.rate, model)
    if position is not None:
        return position
    fail("L0225", "reinit sets a rate, this is none", reset.rate.span,
         "write: reinit(der(x), value), for any position or angle x")


def _moved_at(node: Flat, model: FlatModel, index: tuple[int, ...] = ()) -> Flat | None:
    """That of which an expression, or the element `index` of it, is the rate: sums, and multiples by what is fixed, of der(x) and
    of velocities of frames; None where it is none."""
    match node:
        case Ref(name, own, _) if (variable := model.variables[name]).kind == "variable" and variable.binding is not None:
            return _moved_at(variable.binding, model, (*own, *index))
        case Call("der", (position,), _, _) if not (isinstance(position, Call) and position.function == "der"):
            return _element(position, index)
        case FrameRef(_, attribute) if is_velocity(attribute) and (place := place_of(node)) is not None:
            return _element(replace(node, attribute=place), index)
        case Array(items, span) if index:
            return _moved_at(items[index[0] - 1], model, index[1:])
        case Array(items, span):
            moved = [_moved_at(x, model) for x in items]
            return None if None in moved else Array(tuple(x for x in moved if x is not None), span)
        case Unary("-" | "+" as sign, operand, span):
            x = _moved_at(operand, model, index)
            return x and Unary(sign, x, span)
        case Binary("+" | "-" as operator, left, right, span):
            x, y = _moved_at(left, model, index), _moved_at(right, model, index)
            return x and y and Binary(operator, x, y, span)
        case Binary("*" | "/" as operator, left, right, span) if _is_fixed(right, model):
            x = _moved_at(left, model, index)
            return x and Binary(operator, x, right, span)
        case Binary("*", left, right, span) if _is_fixed(left, model):
            x = _moved_at(right, model, index)
            return x and Binary("*", left, x, span)
    return None


def _element(node: Flat, index: tuple[int, ...]) -> Flat | None:
    """That of what is named; None of other expressions."""
    if not index:
        return node
    return replace(node, index=(*node.index, *index)) if isinstance(node, Ref | FrameRef) else None


def _is_fixed(node: Flat, model: FlatModel) -> bool:
    """Whether an expression is one number during a run, made of numbers and parameters."""
    match node:
        case Number():
            return True
        case Ref(name, index, _):
            variable = model.variables[name]
            return variable.kind in ("parameter", "constant") and len(index) == len(variable.shape)
        case Unary(_, operand, _):
            return _is_fixed(operand, model)
        case Binary(_, left, right, _):
            return _is_fixed(left, model) and _is_fixed(right, model)
    return False


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
    for node in parts_of(condition_of(when, model)):
        if (small := below_zero(node)) is not None:
            yield from ((small, x) for x in positions)


def name_of_contact(event: int) -> str:
    """By which the evaluator asks for the force that holds what rests at the contact of an event."""
    return f"contact_force({event})"


def below_zero(node: Flat) -> Flat | None:
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
