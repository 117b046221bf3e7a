"""Names of what is in an element of an array, as link[i].b: followed once, and in every other pass of a loop written down for the
element that the subscripts say, where all elements are alike."""

from collections.abc import Callable
from typing import Any

from lagrangia.base.records import dataclass
from lagrangia.language.alike_elements import Alike
from lagrangia.language.folding import fold
from lagrangia.language.instances import FrameSlot, Instance, Iterators, Scope, Slot
from lagrangia.language.tree import Binary, Expression, Flat, FrameRef, Number, Ref, Reference, Unary

_OPERATORS = frozenset("+-*")


@dataclass
class ElementReference:
    """A reference that was followed: what it is, but for the element."""

    node: Reference
    scope: Scope  # one of those in which it stands, which keeps its instance
    sizes: tuple[int, ...]
    subscripts: Callable[[Iterators], tuple[int, ...]]
    before: str  # the subscripts, and what stands behind them
    behind: str
    attribute: str | None  # of a frame; None for a variable
    index: tuple[int, ...]
    is_spatial: bool = False

    def at(self, iterators: Iterators) -> Flat | None:
        """What it stands for in another pass; None for what is not among the elements, or not said by integers there."""
        try:
            picked = self.subscripts(iterators)
            is_inside = all(1 <= k <= size for k, size in zip(picked, self.sizes, strict=True))
        except TypeError:
            return None
        if not is_inside:
            return None
        name = f"{self.before}{','.join(map(str, picked))}{self.behind}"
        if self.attribute is None:
            return Ref(name, self.index, self.node.span)
        return FrameRef(name, self.attribute, self.index, self.node.span, self.is_spatial)


def element_reference(node: Reference, scope: Scope, found: Flat, integer: Callable[[Expression, Scope, str], int]
                      ) -> ElementReference | None:
    """Of a reference and what it stands for; None where other passes have to follow it anew."""
    first, *rest = node.parts
    if not (scope.iterators and first.subscripts and isinstance(found, Ref | FrameRef)):
        return None
    member: Any = scope.instance.members.get(first.name)
    sizes, stem = [], member.stem if isinstance(member, Alike) else ""
    while isinstance(member, Alike):
        sizes.append(len(member))
        member = member[0]
    if len(sizes) != len(first.subscripts) or not isinstance(member, Instance):
        return None
    for part in rest:
        if any(not isinstance(s, Number) for s in part.subscripts) or isinstance(member, list):
            return None
        if not isinstance(member, FrameSlot):  # of which the rest is an attribute
            member = member.members.get(part.name) if isinstance(member, Instance) else None
    if isinstance(member, Slot) and member.dimensions:
        return None
    texts = [_text(subscript, scope, integer) for subscript in first.subscripts]
    if None in texts or not found.name.startswith(stem):
        return None
    behind = found.name[found.name.index("]", len(stem)) :]
    read: Callable[[Iterators], tuple[int, ...]] = eval(f"lambda its: ({''.join(f'{text}, ' for text in texts)})")
    attribute, is_spatial = (found.attribute, found.is_spatial) if isinstance(found, FrameRef) else (None, False)
    return ElementReference(node, scope, tuple(sizes), read, stem, behind, attribute, found.index, is_spatial)


def _text(node: Expression, scope: Scope, integer: Callable[[Expression, Scope, str], int]) -> str | None:
    """An integer that iterators make, in Python; None for what is not as simple."""
    match node:
        case Number() if (value := fold(node)) is not None and float(value).is_integer():
            return str(int(value))
        case Reference((part,), _) if not part.subscripts:
            if part.name not in scope.iterators:
                return str(integer(node, scope, "a subscript"))
            return f"its[{part.name!r}]" if isinstance(scope.iterators[part.name], int) else None
        case Unary("-", operand, _):
            inner = _text(operand, scope, integer)
            return f"(-{inner})" if inner is not None else None
        case Binary(operator, left, right, _) if operator in _OPERATORS:
            a, b = _text(left, scope, integer), _text(right, scope, integer)
            return f"({a} {operator} {b})" if a is not None and b is not None else None
    return None
