"""Values that are given to variables of an FMU: which can be, of arrays whole or element by element, and what becomes of them."""

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any, NoReturn

from lagrangia.base.diagnostics import fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.fmu.description import Description, Quantity, element_of, labels, number_in

_SET = ("input", "parameter", "structuralParameter")
_LARGEST = 1_000_000  # numbers of an array


@dataclass(frozen=True)
class Settable:
    """`names` are those of its numbers: the elements of an array, row by row, or one of them; a scalar's own."""

    quantity: Quantity
    shape: tuple[int, ...]
    names: tuple[str, ...]


def settable(description: Description, name: str) -> Settable:
    """A variable, or an element of one, that has a start value to be set. Raises LagError L0701, L0901."""
    element = description.element(name)
    quantity = element[0] if element is not None else description.by_name.get(name)
    if quantity is None:
        refuse_unknown(description, name, [q.name for q in description.quantities if _can_be_set(q)])
    if not _can_be_set(quantity):
        fail("L0701", f"'{name}' cannot be set: it is "
             + ("constant" if quantity.variability == "constant" else "computed by the FMU"), None,
             *_instead(description, quantity))
    shape = shape_of(description, quantity)
    return Settable(quantity, shape, (name,) if element is not None else tuple(labels(name, shape)))


def _instead(description: Description, quantity: Quantity) -> list[str]:
    if quantity.causality == "calculatedParameter":
        return ["it follows from other parameters: set those, or export the scene with a value for it (-p), with which it is a "
                "parameter of its own"]
    if any(state.reference == quantity.reference for state, _ in description.states()):
        return ["where this state starts follows from parameters: set those"]
    return []


def refuse_unknown(description: Description, name: str, known: Iterable[str]) -> NoReturn:
    """Raises LagError L0701 for a name that is neither a variable nor an element of one."""
    part = element_of(name)
    array = description.by_name.get(part[0]) if part is not None else None
    shape = description.shape(array) if array is not None else None
    if array is not None and shape is not None:
        what = f"an array of {' by '.join(map(str, shape))}" if shape else "a scalar"
        fail("L0701", f"the FMU has no variable '{name}'", None, f"'{array.name}' is {what}")
    fail("L0701", f"the FMU has no variable '{name}'", None, *filter(None, [suggest(name, known)]))


def shape_of(description: Description, quantity: Quantity) -> tuple[int, ...]:
    """() of a scalar. Raises LagError L0901 for dimensions that are no numbers, or too many."""
    shape = description.shape(quantity)
    if shape is None:
        fail("L0901", f"not supported yet: the array '{quantity.name}', the size of which the description does not tell",
             quantity.element.span())
    size = 1
    for extent in shape:
        size *= extent
    if size > _LARGEST:
        fail("L0901", f"not supported yet: the array '{quantity.name}' of {size} numbers", quantity.element.span())
    return shape


def _can_be_set(q: Quantity) -> bool:
    return q.variability != "constant" and (q.initial in ("exact", "approx") or q.causality in _SET)


def check_values(description: Description, values: Mapping[str, Any]) -> None:
    """Raises LagError for what cannot be set, or lies outside its bounds."""
    for name, value in values.items():
        quantity = settable(description, name).quantity
        low, high = number_in(quantity.get("min")), number_in(quantity.get("max"))
        if isinstance(value, float) and (value < low or value > high):
            limits = f"from {-math.inf if math.isnan(low) else low} to {math.inf if math.isnan(high) else high}"
            fail("L0605", f"'{name}' is {value:g}, and the FMU says it lies {limits}")
        if quantity.causality == "structuralParameter" and any(
                description.find(dimension.get("valueReference")) is quantity
                for dimension in description.root.all("ModelVariables", "*", "Dimension")):
            fail("L0901", f"not supported yet: '{name}', by which arrays change their size")


def whole_values(description: Description, values: Mapping[str, Any]) -> dict[str, Any]:
    """By variables: arrays are set as a whole, with their starts where nothing is given. Raises LagError L0732."""
    found: dict[str, Any] = {}
    for name, value in values.items():
        element = description.element(name)
        if element is None:
            found[name] = value
        else:
            quantity, place = element
            found.setdefault(quantity.name, start_values(description, quantity))[place] = value
    return found


def start_values(description: Description, quantity: Quantity) -> list[Any]:
    """Of all elements of an array, as numbers where they are ones. Raises LagError L0732."""
    size, starts = len(labels(quantity.name, shape_of(description, quantity))), quantity.starts
    if len(starts) not in (1, size):
        fail("L0732", f"'{quantity.name}' has {size} elements and {len(starts)} start values", quantity.value.span("start"))
    texts = starts * size if len(starts) == 1 else starts
    if quantity.kind in ("String", "Boolean"):
        return texts
    try:
        return list(map(float, texts))
    except ValueError:
        fail("L0732", f"the start values of '{quantity.name}' are no numbers", quantity.value.span("start"))


def with_whole_arrays(description: Description, columns: Mapping[str, Sequence[float]], rows: int) -> dict[str, list[float]]:
    """Inputs over time, with the other elements of each array at their starts: importers set arrays as a whole."""
    found: dict[str, list[float]] = {}
    for name in columns:
        element = description.element(name)
        if element is None:
            found[name] = list(columns[name])
            continue
        quantity = element[0]
        for other, start in zip(labels(quantity.name, shape_of(description, quantity)), start_values(description, quantity),
                                strict=True):
            found[other] = list(columns[other]) if other in columns else [float(start)] * rows
    return found
