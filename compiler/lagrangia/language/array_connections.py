"""connect(a, b) of whole arrays of components, or of slices of them: connections of their elements, one by one."""

from collections.abc import Iterator
from typing import Any, Protocol, TypeAlias

from lagrangia.base.diagnostics import fail
from lagrangia.language.instances import Instance, Member, Scope, Slot
from lagrangia.language.loops import Work
from lagrangia.language.tree import Array, Call, Expression, Number, Part, Range, Reference, Whole

_Elements: TypeAlias = "Reference | list[_Elements]"


class Names(Protocol):
    """What names mean (names.py)."""

    work: Work

    def picks(self, node: Expression, scope: Scope, member: Member, dimension: int) -> int | list[int]:
        """Which elements a subscript means. Raises LagError."""


def joined_elements(call: Call[Expression], scope: Scope, names: Names) -> list[Call[Expression]]:
    """One connect for each pair of elements; none where connect(a, b) names no array of components. Raises LagError L0303."""
    if not any(_is_array(argument, scope.instance) for argument in call.arguments):
        return []
    a, b = (_elements(argument, scope, names) for argument in call.arguments)
    if a is None or b is None:
        return []
    if (first := _shape(a)) != (second := _shape(b)):
        fail("L0303", f"{_spoken(first)} and {_spoken(second)} cannot be connected", call.span,
             "connect joins arrays of the same sizes, element by element" if first and second else
             "element by element: for i in 1:n loop connect(a[i], b); end for;")
    pairs = list(zip(_flat(a), _flat(b), strict=True))
    names.work.spend(len(pairs), call.span)
    return [Call("connect", pair, (), call.span) for pair in pairs]


def _is_array(node: Expression, within: Instance) -> bool:
    """Whether a name leaves open which element of an array of components it means."""
    found: Any = within
    for part in node.parts if isinstance(node, Reference) else ():
        found = found.members.get(part.name) if isinstance(found, Instance) else None
        subscripts = list(part.subscripts)
        while isinstance(found, list):
            if not subscripts or isinstance(subscripts.pop(0), Range | Array | Whole):
                return True
            found = found[0] if found else None
    return False


def _elements(node: Expression, scope: Scope, names: Names) -> "_Elements | None":
    """The names of all elements that a name means, in rows; the name itself of what is no array; None for what is no name."""
    if not isinstance(node, Reference) or (member := scope.instance.members.get(node.parts[0].name)) is None:
        return None

    def below(member: Any, at: int, used: tuple[int, ...], done: tuple[Part, ...]) -> "_Elements | None":
        part, k = node.parts[at], len(used)
        size = len(member) if isinstance(member, list) else member.dimensions[k] if (
            isinstance(member, Slot) and k < len(member.dimensions)) else None
        if size is not None:
            picked = names.picks(part.subscripts[k], scope, member, k) if k < len(part.subscripts) else [*range(1, size + 1)]
            for pick in [picked] if isinstance(picked, int) else picked:
                if not 1 <= pick <= size:
                    fail("L0214", f"'{part.name}' has {size} elements, not {pick}", part.span)
            rows = [below(member[pick - 1] if isinstance(member, list) else member, at, (*used, pick), done)
                    for pick in ([picked] if isinstance(picked, int) else picked)]
            return None if any(row is None for row in rows) else rows[0] if isinstance(picked, int) else rows  # type: ignore[return-value]
        done = (*done, Part(part.name, tuple(Number(float(pick), None, part.span, True) for pick in used), part.span))
        if at + 1 == len(node.parts):
            return Reference(done, node.span)
        inner = member.members.get(node.parts[at + 1].name) if isinstance(member, Instance) else None
        return None if inner is None else below(inner, at + 1, (), done)

    return below(member, 0, (), ())


def _shape(elements: _Elements) -> tuple[int, ...]:
    if isinstance(elements, Reference):
        return ()
    return (len(elements), *(_shape(elements[0]) if elements else ()))


def _spoken(shape: tuple[int, ...]) -> str:
    return f"an array of {' by '.join(map(str, shape))}" if shape else "a single end"


def _flat(elements: _Elements) -> Iterator[Reference]:
    if isinstance(elements, Reference):
        yield elements
    else:
        for one in elements:
            yield from _flat(one)
