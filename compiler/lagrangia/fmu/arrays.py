"""Scalars -> the arrays that FMI 3 has them as (FMI 3.0.2, 2.4.7.3): numbers in a row, whose names count through all places of a
vector or matrix, row by row. FMI 2 has scalars alone, and so have Integers and Booleans here.

An array has the value reference of its first element, those of the others are no variables: runtime/fmi/fmu.h.
"""

from collections import Counter
from collections.abc import Collection, Sequence
from itertools import product
from math import prod

from lagrangia.base.records import dataclass
from lagrangia.fmu.description import element_of
from lagrangia.fmu.variable import Variable

_GROUPS = ("state", "output", "input", "parameter")  # slopes go with their states


@dataclass(frozen=True)
class Array:
    """`reference` is that of its first element, by which its place in the list of scalars is counted as well."""

    name: str
    reference: int
    shape: tuple[int, ...]

    @property
    def size(self) -> int:
        """How many numbers it has."""
        return prod(self.shape)

    @property
    def references(self) -> range:
        """Those of its elements, as scalars."""
        return range(self.reference, self.reference + self.size)


def find_arrays(variables: Sequence[Variable], single: Collection[str]) -> tuple[Array, ...]:
    """Of variables in the order of their value references. `single` are names that were asked for as scalars."""
    names = {variable.name for variable in variables}
    sizes = Counter(part[0] for variable in variables if (part := element_of(variable.name)) is not None)
    found: list[Array] = []
    k = 0
    while k < len(variables):
        array = _array_at(k, variables, single) if variables[k].group in _GROUPS else None
        if array is None or array.name in names or sizes[array.name] != array.size:
            k += 1
        else:
            found.append(array)
            k += array.size
    slopes = {v.derivative_of: v.reference for v in variables if v.derivative_of is not None}
    along = [Array(f"der({a.name})", slopes[variables[a.reference].name], a.shape)
             for a in found if variables[a.reference].group == "state"]
    return tuple(sorted((*found, *along), key=lambda array: array.reference))


def _array_at(first: int, variables: Sequence[Variable], single: Collection[str]) -> Array | None:
    head = element_of(variables[first].name)
    is_number = variables[first].kind == "Real"
    if head is None or not is_number or variables[first].name in single or any(k != 1 for k in head[1]):
        return None
    indices = []
    for variable in variables[first:]:
        here = element_of(variable.name)
        alike = here is not None and here[0] == head[0] and _common(variable, here[1]) == _common(variables[first], head[1])
        if here is None or not alike or variable.name in single:
            break
        indices.append(here[1])
    shape = indices[-1]
    is_whole = indices == list(product(*(range(1, size + 1) for size in shape)))
    return Array(head[0], first, shape) if is_whole else None


def _common(v: Variable, index: tuple[int, ...]) -> object:
    """What all elements of an array must share."""
    parts = [element_of(alias) for alias in v.aliases]
    others = [part[0] if part is not None and part[1] == index else alias for part, alias in zip(parts, v.aliases, strict=True)]
    return v.group, v.kind, v.causality, v.variability, v.unit, v.display_unit, v.minimum, v.maximum, others


def even_nominals(arrays: Sequence[Array], nominal: Sequence[float], first: int) -> tuple[float, ...]:
    """Of states, the first of which has the value reference `first`: an array has one for all of its elements, the largest."""
    found = list(nominal)
    for array in arrays:
        if first <= array.reference < first + len(found):
            own = slice(array.reference - first, array.reference - first + array.size)
            found[own] = [max(found[own])] * array.size
    return tuple(found)
