"""In which order events and samples of one instant come: each after those that give the discrete variables which it reads
(Modelica 3.6, section 8.3.5 and appendix B).

The rank of a `when` is above those of all that give what its conditions and values read; what is held is found before the events
of its own rank. pre(n) is n before the instant: where n has its new value by then, it is n.before, which follows n behind all
others (changes.py).
"""

from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from dataclasses import replace
from graphlib import CycleError, TopologicalSorter
from itertools import pairwise

from lagrangia.base.diagnostics import Span, fail
from lagrangia.base.records import dataclass
from lagrangia.language.changes import before
from lagrangia.language.discrete import Event, meant_by
from lagrangia.language.elsewhen import come_apart
from lagrangia.language.flat import Held, Sampler, When
from lagrangia.language.mentions import nodes, read_now, rebuilt
from lagrangia.language.tree import Call, Flat, Ref

Bindings = Mapping[str, Flat | None]
Givers = Mapping[str, Sequence["_Clause"]]


@dataclass(frozen=True)
class _Clause:
    """What is done at once at an instant: an event, or what is held, whose instants no condition tells."""

    when: int  # what all events of one `when` have in common
    gives: tuple[str, ...]
    reads: tuple[Flat, ...]
    place: Span
    span: Span  # of the first value
    condition: Flat | None = None

    @property
    def is_held(self) -> bool:
        return self.condition is None


def is_ordered(whens: Iterable[When]) -> bool:
    """Whether some come after others at one instant, or instead of them."""
    return any(when.order[0] or when.order[2] for when in whens)


@dataclass(frozen=True)
class InOrder:
    """Events and samplers with their ranks, and the variables whose values before the instant are read behind others."""

    events: list[Event]
    samplers: list[Sampler]
    past: dict[str, Ref]


def in_order(events: Sequence[Event], samplers: Sequence[Sampler], bindings: Bindings) -> InOrder:
    """Raises LagError L0212 for those that read each other's values."""
    clauses = {id(event): _of_event(event) for event in events if not event.is_start}
    clauses |= {id(held): _of_held(held) for sampler in samplers for held in sampler.held}
    givers: dict[str, list[_Clause]] = {}
    for clause in clauses.values():
        for name in clause.gives:
            givers.setdefault(name, []).append(clause)
    if not givers:
        return InOrder([*events], [*samplers], {})
    ranks = _ranks([*clauses.values()], givers, bindings)
    past = dict[str, Ref]()

    def put(item: Event | Held) -> tuple[int, Callable[[Flat], Flat]]:
        """Its rank, and what its expressions are there."""
        clause = clauses[id(item)]
        late = _late(clause, ranks, givers)
        return ranks.get(clause.when, 0), lambda value: _with_past(value, late, bindings, past)

    def put_event(event: Event) -> Event:
        rank, there = put(event)
        resets = tuple(replace(x, value=there(x.value)) for x in event.resets)
        return replace(event, condition=there(event.condition), resets=resets, rank=rank)

    def put_held(held: Held) -> Held:
        rank, there = put(held)
        return replace(held, value=there(held.value), rank=rank)

    return InOrder([event if event.is_start else put_event(event) for event in events],
                   [replace(x, held=tuple(map(put_held, x.held))) for x in samplers], past)


def _of_event(event: Event) -> _Clause:
    given = tuple(x.rate.name for x in event.resets if x.is_kept and isinstance(x.rate, Ref))
    return _Clause(id(event.chain), given, (event.condition, *(x.value for x in event.resets)), event.span,
                   event.resets[0].span if event.resets else event.span,
                   event.condition)


def _of_held(held: Held) -> _Clause:
    return _Clause(id(held), (held.name,), (held.value,), held.span, held.span)


def _links(clauses: Iterable[_Clause], givers: Givers, bindings: Bindings) -> Iterator[tuple[str, _Clause, _Clause]]:
    """What a clause reads, the one that gives it, and itself."""
    for clause in clauses:
        for name in read_now(clause.reads, bindings):
            yield from ((name, giver, clause) for giver in givers.get(name, ()) if giver.when != clause.when)


def _ranks(clauses: Sequence[_Clause], givers: Givers, bindings: Bindings) -> dict[int, int]:
    """By the `when` of events. Where those that may come at one instant alone are in a row, that counts."""
    links = [*_links(clauses, givers, bindings)]
    try:
        return _depths(links)
    except CycleError:
        links = [link for link in links if not _come_apart(link[1], link[2])]
    try:
        return _depths(links)
    except CycleError as error:
        circle = error.args[1]
        names, places = list[str](), list[_Clause]()
        for giver, reader in pairwise(circle):
            name, clause = next((x, one) for x, one, other in links if (one.when, other.when) == (giver, reader))
            names.append(name)
            places.append(clause)
        named = " and ".join(repr(name) for name in names)
        fail("L0212", f"{named} follow from each other where their events come at one instant", places[0].span,
             *(f"'{name}' is given its value at {clause.place}" for name, clause in zip(names[1:], places[1:], strict=True)),
             f"pre({names[0]}) is the value before")


def _come_apart(a: _Clause, b: _Clause) -> bool:
    return a.condition is not None and b.condition is not None and come_apart(a.condition, b.condition)


def _depths(links: Iterable[tuple[str, _Clause, _Clause]]) -> dict[int, int]:
    """How many events stand before each, in a row. Raises CycleError."""
    graph: dict[int, dict[int, int]] = {}
    for _, giver, reader in links:
        graph.setdefault(reader.when, {})[giver.when] = int(not giver.is_held)
    found: dict[int, int] = {}
    for when in TopologicalSorter(graph).static_order():
        found[when] = max((found[giver] + step for giver, step in graph.get(when, {}).items()), default=0)
    return found


def _late(clause: _Clause, ranks: Mapping[int, int], givers: Givers) -> set[str]:
    """What has its new value by then: what is of a lower rank, or held and of the same, if an event reads it."""
    rank = ranks.get(clause.when, 0)
    return {name for name, (giver, *_) in givers.items() if giver.when != clause.when and
            ranks.get(giver.when, 0) + int(not giver.is_held or clause.is_held) <= rank}


def _with_past(value: Flat, late: set[str], bindings: Bindings, past: dict[str, Ref]) -> Flat:
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

    if not any(isinstance(node, Call) and node.function == "pre" for node in nodes(value)):
        return value
    return rebuilt(value, meant)
