"""Arrays of discrete variables: each element is a variable of its own, called n[1], as those in arrays of components are."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from itertools import product

from lagrangia.base.diagnostics import Span, fail
from lagrangia.language.elements import Size, element, length
from lagrangia.language.flat import Variable
from lagrangia.language.instances import DISCRETE_TYPES, Slot
from lagrangia.language.tree import Array, Flat, Ref
from lagrangia.language.truths import NO, truth_of


def is_dealt_out(slot: Slot) -> bool:
    """Whether a variable is such an array."""
    is_discrete = slot.base in DISCRETE_TYPES or "discrete" in slot.declaration.prefixes
    return bool(slot.dimensions) and is_discrete and not slot.is_structural


def referred(slot: Slot, subscripts: Sequence[int | list[int]], span: Span) -> Flat:
    """A variable, or what of it is picked."""
    is_dealt, sizes = is_dealt_out(slot), slot.dimensions

    def build(index: tuple[int, ...], left: Sequence[int | list[int]]) -> Flat:
        if left:
            picked, others = left[0], left[1:]
            return build((*index, picked), others) if isinstance(picked, int) else (
                Array(tuple(build((*index, i), others) for i in picked), span))
        if is_dealt and len(index) < len(sizes):
            return build(index, [list(range(1, size + 1)) for size in sizes[len(index) :]])
        ref = Ref(_name(slot.path, index), (), span) if is_dealt else Ref(slot.path, index, span)
        return truth_of(ref, NO) if slot.base == "Boolean" else ref

    return build((), subscripts)


def variables_of(slot: Slot, variables: Mapping[str, Variable]) -> list[Variable]:
    """What a declaration of a model stands for; nothing where it is structural."""
    names = [_name(slot.path, index) for index in _indices(slot.dimensions)] if is_dealt_out(slot) else [slot.path]
    return [variables[name] for name in names if name in variables]


def dealt_out(variable: Variable, size: Size) -> Iterator[Variable]:
    """The elements of such an array."""
    for index in _indices(variable.shape):
        values = [variable.binding, variable.start]
        for k in index:
            values = [value and element(value, k, size) for value in values]
        yield replace(variable, name=_name(variable.name, index), shape=(), binding=values[0], start=values[1])


def _indices(sizes: Sequence[int]) -> Iterator[tuple[int, ...]]:
    return product(*(range(1, n + 1) for n in sizes))


def _name(path: str, index: tuple[int, ...]) -> str:
    return f"{path}[{','.join(map(str, index))}]"


def dealt_sides(left: Flat, right: Flat, size: Size) -> list[tuple[Flat, Flat]]:
    """What each element on the left is given. Raises LagError L0303."""
    if not isinstance(left, Array):
        return [(left, right)]
    count = length(right, size)
    if count != len(left.items):
        given = "a number" if count is None else f"an array of {count}"
        fail("L0303", f"an array of {len(left.items)} is given {given}", right.span)
    return [pair for k, item in enumerate(left.items, 1) for pair in dealt_sides(item, element(right, k, size), size)]
