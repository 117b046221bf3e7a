"""The variables of an FMU as FMI 3 has them: scalars, and arrays with what their elements have in common."""

from collections.abc import Iterator, Mapping
from dataclasses import replace

from lagrangia.base.records import dataclass
from lagrangia.fmu.arrays import Array
from lagrangia.fmu.description import element_of
from lagrangia.fmu.variable import Variable
from lagrangia.fmu.variables import FmuModel


@dataclass(frozen=True)
class Entry:
    """A variable of FMI 3: a scalar, or an array with what its elements have in common."""

    variable: Variable
    shape: tuple[int, ...]
    elements: tuple[Variable, ...]


def as_in_fmi3(model: FmuModel) -> FmuModel:
    """An array some of whose elements have a start that follows from parameters starts as a whole where these say."""
    variables = list(model.variables)
    for array in model.arrays:
        own = [variables[k] for k in array.references]
        if len({v.initial for v in own}) > 1:
            for v in own:
                variables[v.reference] = replace(v, initial="calculated", start=None)
    return replace(model, variables=tuple(variables))


def entries(model: FmuModel) -> Iterator[Entry]:
    """In the order of the scalars."""
    arrays = {array.reference: array for array in model.arrays}
    inside = {k for array in model.arrays for k in array.references[1:]}
    for variable in model.variables:
        array = arrays.get(variable.reference)
        if array is not None:
            yield Entry(_whole(model, variable, array), array.shape, tuple(model.variables[k] for k in array.references))
        elif variable.reference not in inside:
            yield Entry(variable, (), (variable,))


def _whole(model: FmuModel, first: Variable, array: Array) -> Variable:
    head = element_of(first.name)
    index = f"[{','.join(map(str, head[1]))}]" if head is not None else ""
    texts = {model.variables[k].description for k in array.references}
    text = first.description if len(texts) == 1 else first.description.replace(index, "")
    of = None if first.derivative_of is None else array.name[len("der(") : -1]
    aliases = tuple(alias.replace(index, "") for alias in first.aliases)
    return replace(first, name=array.name, description=text, derivative_of=of, aliases=aliases)


def places(model: FmuModel) -> Mapping[str, int]:
    """The value reference, in FMI 3, of the variable that each scalar is or is an element of."""
    found = {variable.name: variable.reference for variable in model.variables}
    return found | {model.variables[k].name: array.reference for array in model.arrays for k in array.references}
