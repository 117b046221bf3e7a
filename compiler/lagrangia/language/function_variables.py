"""Variables of functions: numbers, arrays of them, and records, as trees whose leaves have names of their own.

An array is a tuple of its elements; a record has a tree for each of its parts, which is an array where the record is one.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence, Set
from typing import Literal, TypeAlias

from lagrangia.base.diagnostics import Span, fail, suggest
from lagrangia.base.records import dataclass
from lagrangia.language.elements import Size, element, length
from lagrangia.language.mentions import nodes
from lagrangia.language.tree import Array, EnumerationLiteral, Flat, Local

Tree: TypeAlias = "str | tuple[Tree, ...] | dict[str, Tree]"  # leaves: names
Values: TypeAlias = "Flat | tuple[Values, ...] | dict[str, Values]"


@dataclass(frozen=True)
class FlatFunction:
    """A result, the value of `output` after the steps, each an assignment to a local name; of numbers."""

    name: str
    inputs: tuple[str, ...]
    units: Mapping[str, str]  # declared unit of each variable, "" when none
    steps: tuple[tuple[str, Flat], ...]
    output: str
    span: Span
    whole_inputs: frozenset[str] = frozenset()  # those that are Integer


@dataclass(frozen=True)
class Given:
    """What a call gives a function, as far as the function is another one by it: the shapes of what it gives, and the values of
    texts, enumerations, Integer and Boolean inputs that are known."""

    shapes: Mapping[str, tuple[int, ...]]
    constants: Mapping[str, Flat]

    def signature(self) -> str:
        """Of functions of the same name."""
        texts = [f"{name}={','.join(map(str, shape))}{_text_of(self.constants.get(name))}"
                 for name, shape in self.shapes.items()]
        return f"({'; '.join(texts)})"


def _text_of(constant: Flat | None) -> object:
    return constant.name if isinstance(constant, EnumerationLiteral) else getattr(constant, "value", "")


@dataclass(frozen=True)
class Assertion:
    """What a function asserts: each comparison is one with 0 of a function of its inputs, called with their names."""

    condition: Flat
    text: str
    kind: Literal["warning", "error"]


@dataclass(frozen=True)
class Built:
    """A function for what is given: its results' trees have names of `functions`, which take the leaves of `inputs`; `truths`:
    those of leaves and functions that stand for what is true or false (truths.py)."""

    inputs: Mapping[str, Tree]
    outputs: Mapping[str, Tree]
    functions: Mapping[str, FlatFunction]
    assertions: tuple[Assertion, ...] = ()
    truths: Set[str] = frozenset()


def leaves_of(tree: Tree) -> Iterator[str]:
    """All names, in their order."""
    if isinstance(tree, str):
        yield tree
    else:
        for part in tree.values() if isinstance(tree, dict) else tree:
            yield from leaves_of(part)


def array_of(path: str, sizes: Sequence[int], leaf: Callable[[str], Tree], index: tuple[int, ...] = ()) -> Tree:
    """An array of so many elements in each dimension, called path[1,1], ..."""
    if not sizes:
        return leaf(f"{path}[{','.join(map(str, index))}]" if index else path)
    return tuple(array_of(path, sizes[1:], leaf, (*index, k)) for k in range(1, sizes[0] + 1))


def flat_of(tree: Tree, leaf: Callable[[str], Flat], span: Span) -> Flat:
    """An expression of numbers and arrays. Raises LagError L0216 of a record."""
    if isinstance(tree, str):
        return leaf(tree)
    if isinstance(tree, dict):
        fail("L0216", "this is a record, not a value", span, f"name one of its parts: {', '.join(tree)}")
    return Array(tuple(flat_of(part, leaf, span) for part in tree), span)


def dealt(value: Flat, tree: Tree, size: Size, what: str) -> Iterator[tuple[str, Flat]]:
    """The leaves of an array, or a number, with what an expression has for each. Raises LagError L0303."""
    if isinstance(tree, dict):
        fail("L0302", f"{what} is a record, this is none", value.span,
             "a record is a name of one, or made by its constructor: R(a = 1)")
    count = length(value, size)
    if isinstance(tree, str):
        if count is not None:
            fail("L0303", f"{what} is a number, this is an array of {count}", value.span)
        yield tree, value
        return
    if count != len(tree):
        given = "a number" if count is None else f"an array of {count}"
        fail("L0303", f"{what} is an array of {len(tree)}, this is {given}", value.span)
    for k, part in enumerate(tree, 1):
        yield from dealt(element(value, k, size), part, size, what)


def part_of(tree: Tree, name: str, span: Span) -> Tree:
    """What a record has under a name. Raises LagError L0216."""
    if not isinstance(tree, dict):
        fail("L0216", f"this is no record, and has no '{name}'", span)
    if name not in tree:
        fail("L0216", f"the record has no '{name}'", span, *filter(None, [suggest(name, list(tree))]))
    return tree[name]


def needed(steps: list[tuple[str, Flat]], output: str) -> tuple[tuple[str, Flat], ...]:
    """The assignments that a result follows from."""
    wanted, found = {output}, []
    for place, value in reversed(steps):
        if place in wanted:
            found.append((place, value))
            wanted.remove(place)
            wanted |= {node.name for node in nodes(value) if isinstance(node, Local)}
    return tuple(reversed(found))


def renamed(tree: Tree, stem: str) -> Tree:
    """The same variable of another name: stem.name."""
    if isinstance(tree, str):
        return f"{stem}.{tree}"
    if isinstance(tree, dict):
        return {name: renamed(part, stem) for name, part in tree.items()}
    return tuple(renamed(part, stem) for part in tree)
