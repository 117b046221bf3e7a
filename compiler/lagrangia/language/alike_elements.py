"""Elements of arrays of components that are alike: the first is made from its class, the others are copies of it.

What differs is the path, and what is dealt out to each: the index of the first element is an object of its own, by which a copy
knows what was dealt out.
"""

from collections.abc import Iterable
from dataclasses import replace
from typing import Any

from lagrangia.language.instances import Bound, FrameSlot, Instance, Member, Scope, Slot
from lagrangia.language.tree import Boolean, Number, String, Whole

FEWEST = 8  # elements in all dimensions: fewer are as soon made one by one
_LITERALS = (Number, Boolean, String)


class First(int):
    """The index 1 of the first element, in whatever was dealt out to it."""

    def deals(self, bound: Bound | None) -> bool:
        """Whether the value is a part of what was dealt out."""
        return bound is not None and any(index is self for index, _ in bound.selection)

    def dealt(self, bound: Bound, index: int) -> Bound:
        """The part of another element."""
        return Bound(bound.expression, bound.scope, tuple((index if k is self else k, size) for k, size in bound.selection),
                     bound.is_each)


class Alike(list[Any]):
    """The elements of an array in its first dimension, all but the first copies of it. Full names of what is in them begin with
    `stem` and the index: "x[" of x[n], "x[1," of a row of x[n, m]."""

    def __init__(self, elements: Iterable[Any], mark: First, stem: str) -> None:
        super().__init__(elements)
        self.mark, self.stem = mark, stem


def can_be_copied(element: Member, mark: First) -> bool:
    """Whether nothing of the first element's structure depends on what was dealt out to it."""
    if isinstance(element, list):
        return all(can_be_copied(item, mark) for item in element)
    if not isinstance(element, Instance):
        return _is_plain(element, mark)
    return not (element.outer or element.classes) and all(can_be_copied(member, mark) for member in element.members.values())


def _is_plain(member: Slot | FrameSlot, mark: First) -> bool:
    if isinstance(member, FrameSlot):
        return True
    if any(mark.deals(bound) for name, bound in member.attributes.items() if name != "start"):
        return False
    if not mark.deals(member.binding):
        return True
    sizes = member.declaration.dimensions  # its type may have more
    has_own_size = len(sizes) < len(member.dimensions) or any(isinstance(size, Whole) for size in sizes)
    return not (member.is_structural or has_own_size)


def copies_of(element: Member, parent: Instance, mark: First, size: int, stem: str) -> Alike:
    """The elements of an array in `parent`, in which this is the first one; `stem`: see Alike."""
    cut, scope = len(stem) + len(str(mark)), Scope(parent)
    others = (_Copier(cut, f"{stem}{k}", mark, k).member(element, parent, scope) for k in range(2, size + 1))
    return Alike([element, *others], mark, stem)


class _Copier:
    """Makes the copy of a component at another path."""

    def __init__(self, cut: int, path: str, mark: First, index: int) -> None:
        self.cut, self.path, self.mark, self.index = cut, path, mark, index
        self.scopes: dict[int, Scope] = {}  # of copies, by the ids of what they are copies of

    def instance(self, x: Instance, parent: Instance | None) -> Instance:
        made = Instance(self.path + x.path[self.cut :], x.definition, x.span, {}, x.clauses, None, parent, x.absent, x.outer,
                        x.inner, x.classes, x.protected, x.description)
        self.scopes[id(x)] = scope = Scope(made)
        if x.frame is not None:
            made.frame = self.frame(x.frame, made)
        if x.joined_to is not None:
            made.joined_to = self.bound(x.joined_to)
        made.members = {name: self.member(member, made, scope) for name, member in x.members.items()}
        return made

    def member(self, x: Member, parent: Instance, scope: Scope) -> Member:
        if isinstance(x, Slot):
            return self.slot(x, scope)
        if isinstance(x, FrameSlot):
            return self.frame(x, parent)
        if isinstance(x, Instance):
            return self.instance(x, parent)
        made = [self.member(item, parent, scope) for item in x]
        return Alike(made, x.mark, self.path + x.stem[self.cut :]) if isinstance(x, Alike) else made

    def slot(self, x: Slot, scope: Scope) -> Slot:
        attributes = x.attributes
        if any(bound.expression.__class__ not in _LITERALS for bound in attributes.values()):
            attributes = {name: self.bound(bound) for name, bound in attributes.items()}
        binding = self.bound(x.binding) if x.binding is not None else None
        return Slot(self.path + x.path[self.cut :], x.declaration, x.base, attributes, binding, scope, x.dimensions,
                    x.is_final, x.enumeration)

    def frame(self, x: FrameSlot, parent: Instance) -> FrameSlot:
        starts = {name: self.bound(bound) for name, bound in x.starts.items()}
        binding = self.bound(x.binding) if x.binding is not None else None
        return FrameSlot(self.path + x.path[self.cut :], x.span, starts, x.fixed, binding, parent)

    def bound(self, x: Bound) -> Bound:
        """The same, read where the copy stands if it was written within it."""
        scope = self.scopes.get(id(x.scope.instance))
        if scope is not None:
            return replace(x, scope=Scope(scope.instance, x.scope.iterators) if x.scope.iterators else scope)
        return self.mark.dealt(x, self.index) if x.selection else x
