"""Arrays whose elements follow from one another, in any order: v[1] = 1; v[2] = 2*v[1]."""

from collections.abc import Callable
from typing import Any

from lagrangia.base.diagnostics import Span, fail
from lagrangia.frames.arrays import array_of
from lagrangia.language.flat import Variable
from lagrangia.language.tree import Array, Flat

Index = tuple[int, ...]


class Elements:
    """The elements of an array that is bound to {..., ...}, each evaluated once, when it is first asked for."""

    def __init__(self, name: str, shape: Index, binding: Array[Flat], span: Span, evaluate: Callable[[Flat, Index], Any]) -> None:
        """`evaluate` gives the value of an item at its index; `span` is where the array is declared."""
        self._name, self._shape, self._binding, self._span, self._evaluate = name, shape, binding, span, evaluate
        self._known: dict[Index, Any] = {}
        self._pending: list[Index] = []

    def value(self, index: Index = ()) -> Any:
        """What stands at an index, the array itself at (). Raises LagError L0212 where it follows from itself."""
        node: Flat = self._binding
        depth = 0
        while isinstance(node, Array) and depth < len(index) and index[depth] <= len(node.items):
            node, depth = node.items[index[depth] - 1], depth + 1
        if isinstance(node, Array) and depth < len(self._shape):
            return array_of(tuple(self.value((*index, k)) for k in range(1, len(node.items) + 1)), node.span)
        value = self._item(node, index[:depth])
        for k in index[depth:]:
            value = value[k - 1]
        return value

    def _item(self, node: Flat, index: Index) -> Any:
        if index in self._pending:
            chain = [self._called(each) for each in (*self._pending[self._pending.index(index) :], index)]
            fail("L0212", f"'{chain[0]}' depends on itself", self._span, " > ".join(chain))
        if index not in self._known:
            self._pending.append(index)
            self._known[index] = self._evaluate(node, index)
            self._pending.pop()
        return self._known[index]

    def _called(self, index: Index) -> str:
        return f"{self._name}[{','.join(map(str, index))}]"


def whole(begun: dict[tuple[str, int], Elements], variable: Variable, binding: Flat, evaluate: Callable[[Flat, Index], Any],
          level: int = 0) -> Any:
    """What a variable is bound to: `evaluate` gives the value of the binding, or of what stands at an index of it. Meanwhile its
    elements are found in `begun`."""
    if not isinstance(binding, Array) or not variable.shape:
        return evaluate(binding, ())
    key = variable.name, level
    begun[key] = Elements(variable.name, variable.shape, binding, variable.span, evaluate)
    try:
        return begun[key].value()
    finally:
        del begun[key]
