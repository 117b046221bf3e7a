"""Inputs that stand where functions of time do: in places, in equations that hold the motion, in energies, or under der().

Such an input is a polynomial of time between the times at which it is given, so that all that follows from its rates is known.
One that moves places, or masses, has two more inputs beside it, der(y) and der(der(y)): for who gives it now and then, and knows
them.
"""

from collections.abc import Iterator
from dataclasses import replace

from lagrangia.language.flat import FlatModel, Variable
from lagrangia.language.mentions import nodes, reached
from lagrangia.language.tree import Call, Flat, Ref
from lagrangia.language.units import per_second


def rate_names(name: str) -> tuple[str, str]:
    """Of the inputs beside one that moves places: its first two derivatives."""
    return f"der({name})", f"der(der({name}))"


def rate_inputs(model: FlatModel) -> frozenset[str]:
    """The inputs that are rates of others."""
    return frozenset(name for of, is_placing in model.moving_inputs.items() if is_placing for name in rate_names(of))


def with_moving_inputs(model: FlatModel) -> FlatModel:
    """The model that knows of each such input whether its rates matter, with the inputs that are these rates."""
    inputs = {name for name, variable in model.variables.items() if variable.kind == "input"}
    if not inputs:
        return model
    bindings = {name: variable.binding for name, variable in model.variables.items()}

    def among(roots: Iterator[Flat]) -> set[str]:
        return {node.name for node in reached(roots, bindings) if isinstance(node, Ref) and node.name in inputs}

    placing = among(_places(model))
    valued = among(energy.value for energy in model.energies if energy.kind == "potential")
    moving = {name: name in placing for name in model.variables if name in placing | valued}
    added = {new.name: new for name, is_placing in moving.items() if is_placing for new in _rates(model.variables[name])}
    return replace(model, moving_inputs=moving, variables={**model.variables, **added}) if moving else model


def _places(model: FlatModel) -> Iterator[Flat]:
    """What is differentiated in time."""
    yield from (side for frames in model.frame_equations for side in (frames.left, frames.right))
    yield from (side for equation in model.constraints for side in (equation.left, equation.right))
    yield from (energy.value for energy in model.energies if energy.kind == "kinetic" and not energy.is_signal)
    everything: list[Flat] = [x for v in model.variables.values() for x in (v.binding,) if x is not None]
    everything += [energy.value for energy in model.energies] + [x for work in model.works for x in (work.force, work.position)]
    everything += [x for equation in model.initial_equations for x in (equation.left, equation.right)]
    everything += model.looks()
    everything += [state.rate for state in model.states.values()]
    for node in nodes(*everything):
        if isinstance(node, Call) and node.function == "der" and not _is_state(model, node.arguments[0]):
            yield from node.arguments


def _is_state(model: FlatModel, node: Flat) -> bool:
    return isinstance(node, Ref) and node.name in model.states


def _rates(variable: Variable) -> tuple[Variable, Variable]:
    first, second = rate_names(variable.name)
    unit = per_second(variable.unit) if variable.unit else ""
    rate = replace(variable, name=first, unit=unit, display_unit="", binding=None, start=None, minimum=None, maximum=None,
                   is_output=False, description=f"rate of the input {variable.name}, which moves places")
    return rate, replace(rate, name=second, unit=per_second(unit) if unit else "", description=f"rate of {first}")

