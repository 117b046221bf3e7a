"""In which order events of one instant come: each after those that give the discrete variables which it reads (Modelica 3.6,
section 8.3.5 and appendix B).

The rank of a `when` is above those of all that give what its conditions and values read. pre(n) is n before the instant: where a
`when` of a lower rank gives n its value, it is n.before, which follows n behind all others (changes.py).
"""

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

from lagrangia.base.diagnostics import fail
from lagrangia.language.changes import before
from lagrangia.language.discrete import Event, meant_by
from lagrangia.language.elsewhen import come_apart
from lagrangia.language.flat import When
from lagrangia.language.mentions import nodes, read_now, rebuilt
from lagrangia.language.tree import Call, Flat, Ref

Bindings = Mapping[str, Flat | None]
Givers = dict[str, list[Event]]


def is_ordered(whens: Iterable[When]) -> bool:
    """Whether some come after others at one instant, or instead of them."""
    return any(when.order[0] or when.order[2] for when in whens)


def in_order(events: Sequence[Event], bindings: Bindings) -> tuple[list[Event], dict[str, Ref]]:
    """The events with their ranks, and the variables whose values before the instant are read behind others. Raises LagError
    L0212 for those that read each other's values."""
    givers = _givers(events)
    if not givers:
        return [*events], {}
    ranks = _ranks(events, givers, bindings)
    past = dict[str, Ref]()
    found = []
    for event in events:
        rank = ranks.get(id(event.chain), 0)
        late = {name for name, giving in givers.items() if ranks.get(id(giving[0].chain), 0) < rank}
        found.append(replace(_with_past(event, late, bindings, past), rank=rank) if late and not event.is_start else event)
    return found, past


def _givers(events: Iterable[Event]) -> Givers:
    """The events that give each discrete variable its values."""
    found = Givers()
    for event in events:
        for reset in event.resets:
            if not event.is_start and reset.is_kept and isinstance(reset.rate, Ref):
                found.setdefault(reset.rate.name, []).append(event)
    return found


def _links(events: Iterable[Event], givers: Givers, bindings: Bindings) -> Iterator[tuple[str, Event, Event]]:
    """What an event reads, the one that gives it, and itself."""
    for event in events:
        read = () if event.is_start else read_now([event.condition, *(x.value for x in event.resets)], bindings)
        for name in read:
            for other in givers.get(name, ()):
                if other.chain is not event.chain:
                    yield name, other, event


def _ranks(events: Sequence[Event], givers: Givers, bindings: Bindings) -> dict[int, int]:
    """By the `when` of events. Where those that may come at one instant alone are in a row, that counts."""
    links = [*_links(events, givers, bindings)]
    try:
        return _depths(links)
    except CycleError:
        links = [link for link in links if not come_apart(link[1].condition, link[2].condition)]
    try:
        return _depths(links)
    except CycleError as error:
        circle = error.args[1]
        names, places = list[str](), list[Event]()
        for giver, reader in pairwise(circle):
            name, event = next((x, one) for x, one, other in links if (id(one.chain), id(other.chain)) == (giver, reader))
            names.append(name)
            places.append(event)
        named = " and ".join(repr(name) for name in names)
        fail("L0212", f"{named} follow from each other where their events come at one instant", places[0].resets[0].span,
             *(f"'{name}' is given its value at {event.span}" for name, event in zip(names[1:], places[1:], strict=True)),
             f"pre({names[0]}) is the value before")


def _depths(links: Iterable[tuple[str, Event, Event]]) -> dict[int, int]:
    """How many stand before each, in a row. Raises CycleError."""
    graph: dict[int, set[int]] = {}
    for _, giver, reader in links:
        graph.setdefault(id(reader.chain), set()).add(id(giver.chain))
    found: dict[int, int] = {}
    for chain in TopologicalSorter(graph).static_order():
        found[chain] = max((found[x] + 1 for x in graph.get(chain, ())), default=0)
    return found


def _with_past(event: Event, late: set[str], bindings: Bindings, past: dict[str, Ref]) -> Event:
    """pre(n) is n.before where n has its new value by then."""

    def was(node: Flat) -> Flat | None:
        if not isinstance(node, Ref):
            return None
        if node.name in late:
            past[node.name] = node
            return before(node)
        binding = None if late.isdisjoint(read_now([node], bindings)) else meant_by(node, bindings)
        return binding and rebuilt(binding, was)

    def meant(node: Flat) -> Flat | None:
        if isinstance(node, Call) and node.function == "pre":
            return Call("pre", (rebuilt(node.arguments[0], was),), (), node.span)
        return None

    read = (event.condition, *(x.value for x in event.resets))
    if not any(isinstance(node, Call) and node.function == "pre" for node in nodes(*read)):
        return event
    resets = tuple(replace(x, value=rebuilt(x.value, meant)) for x in event.resets)
    return replace(event, condition=rebuilt(event.condition, meant), resets=resets)
