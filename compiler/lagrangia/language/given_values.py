"""Values that are given for parameters, put in the place of those declared: what they decide follows them, as if written."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import replace

from lagrangia.base.checked_values import a_number
from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.language.dimensions import units_of_given
from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.tree import Array, Flat, Number, Ref
from lagrangia.language.values import read_value

Given = Mapping[str, float | list[float] | str]  # of parameters, elements or whole arrays; texts may carry units


def redeclared(model: FlatModel, given: Given) -> FlatModel:
    """The model with these values declared. Raises LagError L0701, L0702 for names of no parameter that can be set, L0605 for
    what is beyond its limits, L0706 for what is no finite value."""
    chosen = _chosen(model, given)
    variables = dict(model.variables)
    for variable in model.variables.values():
        if variable.kind == "parameter" and any(label in chosen for label, _ in variable.elements()):
            variables[variable.name] = replace(variable, binding=_binding(variable, chosen))
    return replace(model, variables=variables)


def _chosen(model: FlatModel, given: Given) -> dict[str, float]:
    """Element by element, in SI units."""
    parameters = [v for v in model.variables.values() if v.kind == "parameter"]
    owners = {label: v for v in parameters for label, _ in v.elements()}
    units, chosen = units_of_given(model), dict[str, float]()
    for name, text in given.items():
        mine = [label for label in owners if label == name or label.startswith(name + "[")]
        if not mine:
            fail("L0702", f"there is no parameter '{name}'", None, *filter(None, [suggest(name, [*owners, *model.structural])]))
        variable = owners[mine[0]]
        if variable.locked:
            fail("L0701", f"the parameter '{name}' is {variable.locked}: it cannot be set", None, f"declared at {variable.span}")
        value = _read(name, text, units[variable.name])
        several = value if isinstance(value, list) else [value]
        if not all(math.isfinite(a_number(f"parameter '{name}'", x)) for x in several):
            fail("L0706", f"parameter '{name}' = {text}: a finite number is needed")
        for label, x in zip(mine, several, strict=False):
            _require_within(variable, label, x)
        if len(several) != len(mine):
            fail("L0706", f"{name} = {text}: {len(mine)} number{'s are' if len(mine) > 1 else ' is'} needed")
        chosen |= dict(zip(mine, several, strict=True))
    return chosen


def _require_within(variable: Variable, label: str, value: float) -> None:
    for limit, what, is_beyond in ((variable.minimum, "less than its minimum", float.__lt__),
                                   (variable.maximum, "more than its maximum", float.__gt__)):
        if limit is not None and is_beyond(float(value), limit):
            fail("L0605", f"the parameter '{label}' is {value:g} {variable.unit}".rstrip() + f", {what} {limit:g}", None,
                 f"declared at {variable.span}")


def _read(name: str, value: float | list[float] | str, unit: str) -> float | list[float]:
    if not isinstance(value, str):
        return value
    try:
        return read_value(value, unit)
    except ValueError as error:
        fail("L0706", f"{name} = {value}: {error}")


def _binding(variable: Variable, chosen: Mapping[str, float]) -> Flat:
    declared = variable.binding
    span = declared.span if declared is not None else variable.span
    items = iter(_element(variable, declared, label, index, chosen, span) for label, index in variable.elements())
    return _nested(items, variable.shape, span)


def _element(variable: Variable, declared: Flat | None, label: str, index: tuple[int, ...], chosen: Mapping[str, float],
             span: Span) -> Flat:
    if label in chosen:
        return Number(chosen[label], None, span)
    item = declared
    for place in index:
        if isinstance(item, Array):
            item = item.items[place - 1]
        elif isinstance(item, Ref):
            item = Ref(item.name, (*item.index, place), span)
        else:
            fail("L0901", f"not supported yet: one element alone of '{variable.name}'", None, "give all of its elements")
    assert item is not None
    return item


def _nested(items: Iterator[Flat], shape: tuple[int, ...], span: Span) -> Flat:
    return Array(tuple(_nested(items, shape[1:], span) for _ in range(shape[0])), span) if shape else next(items)
