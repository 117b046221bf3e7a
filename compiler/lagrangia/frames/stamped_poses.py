"""Poses along chains of frames that are placed alike, one after the other: derived for one link and stamped out (scans.py).

A way goes from a frame on towards the end that is farthest. Where the kinds of its edges repeat, so many edges are a link.
"""

from collections.abc import Callable, Iterator, Sequence
from functools import partial
from typing import Any, TypeAlias

from lagrangia.algebra.duals import Dual, Scalar
from lagrangia.algebra.scans import scan
from lagrangia.frames.edges import Edge
from lagrangia.language.frame_steps import Step

FEWEST = 24  # links of a chain
_LONGEST = 16  # edges of a link
Pose: TypeAlias = Any  # as of frames/geometry.py: a record of scalars
Along = Callable[[Step, Any, Pose], Pose]  # the pose after a step of this amount
Placed: TypeAlias = Pose | Callable[[], Pose]  # one that is put together when somebody asks for it


def ways(edges: Sequence[Edge]) -> list[list[Edge]]:
    """All edges, those of a way one after the other; the way that leads to where one begins stands before it."""
    behind: dict[str, int] = {}  # how many edges follow at most
    main: dict[str, Edge] = {}
    for edge in reversed(edges):
        count = behind.get(edge.child, 0) + 1
        if count > behind.get(edge.parent, 0):
            behind[edge.parent], main[edge.parent] = count, edge
    found: list[list[Edge]] = []
    by_end: dict[str, list[Edge]] = {}
    for edge in edges:
        if main[edge.parent] is edge and (way := by_end.pop(edge.parent, None)) is not None:
            way.append(edge)
        else:
            way = [edge]
            found.append(way)
        by_end[edge.child] = way
    return found


def place_way(way: Sequence[Edge], amounts: Sequence[Sequence[Any]], pose: Pose, along: Along) -> list[Placed]:
    """The poses of the children of its edges. `amounts`: of the steps of each; `pose`: where it begins."""
    numbers: dict[Any, int] = {}
    kinds = [numbers.setdefault(_kind(edge, own), len(numbers)) for edge, own in zip(way, amounts, strict=True)]
    placed: list[Placed] = []
    k = 0
    while k < len(way):
        size, count = _link(kinds, k)
        if count >= FEWEST:
            found, pose = _place_links(way[k : k + size], amounts[k : k + size * count], pose, along)
            placed += found
            k += size * count
        else:
            pose = _follow(way[k], amounts[k], pose, along)
            placed.append(pose)
            k += 1
    return placed


def _kind(edge: Edge, amounts: Sequence[Any]) -> tuple[Any, ...]:
    return tuple((step.kind, step.is_inverse, _shape(x)) for step, x in zip(edge.steps, amounts, strict=True))


def _link(kinds: Sequence[int], begin: int) -> tuple[int, int]:
    """How many edges the link that begins there has, and how many links there are of its kind."""
    for size in range(1, _LONGEST + 1):
        end = begin + size
        while end < len(kinds) and kinds[end] == kinds[end - size]:
            end += 1
        if (end - begin) // size >= FEWEST:
            return size, (end - begin) // size
    return 1, 1


def _place_links(link: Sequence[Edge], amounts: Sequence[Sequence[Any]], pose: Pose, along: Along) -> tuple[list[Placed], Pose]:
    """Of links whose edges are of the kinds of the first one's, and the last pose."""
    placed: list[Placed] = []
    size = len(link)
    for k in range(0, len(amounts), size):
        begin, own = pose, list[Pose]()
        for edge, steps in zip(link, amounts[k : k + size], strict=True):
            pose = _follow(edge, steps, pose, along)
            own.append(pose)
        placed += own
        if _kind_of_pose(pose) == _kind_of_pose(begin):
            found, last = _stamped(link, amounts[k + size :], own, along)
            return placed + found, last
    return placed, pose


def _stamped(link: Sequence[Edge], amounts: Sequence[Sequence[Any]], last: Sequence[Pose], along: Along
             ) -> tuple[list[Placed], Pose]:
    """Behind a link with the poses `last`: all poses have the forms that these have."""
    forms, size = amounts[: len(link)], len(link)

    def step(state: list[Scalar], inputs: list[Scalar]) -> tuple[list[Scalar], list[Scalar]]:
        pose, values, found = end(state), iter(inputs), list[Scalar]()
        for edge, form in zip(link, forms, strict=True):
            pose = _follow(edge, [_like(x, values) for x in form], pose, along)
            found += _leaves_of_pose(pose)
        return _leaves_of_pose(pose), found

    makers, at = list[Callable[[list[Scalar]], Pose]](), 0
    for form in last:
        makers.append(_maker(form, at))
        at += len(_leaves_of_pose(form))
    end = _maker(last[-1], 0)
    inputs = [[x for own in amounts[k : k + size] for amount in own for x in _leaves(amount)]
              for k in range(0, len(amounts), size)]
    state, results = scan(step, _leaves_of_pose(last[-1]), inputs)
    return [partial(make, found) for found in results for make in makers], end(state)


def _follow(edge: Edge, amounts: Sequence[Any], pose: Pose, along: Along) -> Pose:
    for step, amount in zip(edge.steps, amounts, strict=True):
        pose = along(step, amount, pose)
    return pose


# -------------------------------------------------------------------- values, taken apart and put together


def _leaves(value: Any) -> list[Scalar]:
    """The scalars that Duals and vectors are made of."""
    if isinstance(value, Dual):
        return [*_leaves(value.value), *_leaves(value.rate)]
    return [x for item in value for x in _leaves(item)] if isinstance(value, tuple) else [value]


def _like(form: Any, values: Iterator[Scalar]) -> Any:
    """What is made of other scalars as this is."""
    if isinstance(form, Dual):
        return Dual(_like(form.value, values), _like(form.rate, values))
    return tuple(_like(item, values) for item in form) if isinstance(form, tuple) else next(values)


def _shape(value: Any) -> Any:
    if isinstance(value, Dual):
        return "rate", _shape(value.value), _shape(value.rate)
    return tuple(map(_shape, value)) if isinstance(value, tuple) else value if isinstance(value, float | int) else None


def _numbers_of(pose: Pose) -> list[Any]:
    return [getattr(pose, name) for name in type(pose).__match_args__]


def _leaves_of_pose(pose: Pose) -> list[Scalar]:
    return [leaf for x in _numbers_of(pose) for leaf in _leaves(x)]


def _kind_of_pose(pose: Pose) -> list[Any]:
    return [_shape(x) for x in _numbers_of(pose)]


def _maker(form: Pose, at: int) -> Callable[[list[Scalar]], Pose]:
    """Of a list in which the scalars stand from a place on: the pose that is made of them as this one is."""
    places = iter(range(at, at + len(_leaves_of_pose(form))))

    def text(x: Any) -> str:
        return f"Dual({text(x.value)}, {text(x.rate)})" if isinstance(x, Dual) else f"x[{next(places)}]"

    numbers = ", ".join(map(text, _numbers_of(form)))
    made: Callable[[list[Scalar]], Pose] = eval(f"lambda x: Pose({numbers})", {"Dual": Dual, "Pose": type(form)})
    return made
