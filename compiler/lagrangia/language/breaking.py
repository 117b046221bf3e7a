"""Contacts that their own force ends: `when slack < 0 and contact_force(slack) < most then reinit(der(slack), 0); end when`.

The force is 0 as soon as such a contact lets go, so what breaks has to remember it. `broken`, a discrete variable of its
component, becomes true where the part of the condition that asks for the force becomes false, or is false at the start; a contact
that is broken is none any more.
"""

from collections.abc import Collection, Iterator, Sequence
from dataclasses import replace
from functools import reduce

from lagrangia.base.records import dataclass
from lagrangia.language.consequences import contact_forces_of
from lagrangia.language.discrete import Bindings, Event, compared, opened
from lagrangia.language.events import are_alike, below_zero, parts_of, without_not
from lagrangia.language.flat import Reset, Variable
from lagrangia.language.tree import Binary, Flat, Number, Ref, Unary
from lagrangia.language.truths import NO, truth_of
from lagrangia.language.whole_numbers import WholeNumbers


@dataclass(frozen=True)
class Breaking:
    """All events, and the variables that say what is broken."""

    events: list[Event]
    variables: dict[str, Variable]


def with_breaking(events: Sequence[Event], names: Collection[str], bindings: Bindings, whole: WholeNumbers) -> Breaking:
    """Of all events; `names` are taken."""
    found = Breaking([], {})
    for event in events:
        parts = _parts_of(event, bindings, whole)
        ending = _that_end_it(parts, bindings)
        if not ending or all(x.is_kept for x in event.resets):
            found.events.append(event)
            continue
        name = next(x for x in _names_for(event.component) if x not in names and x not in found.variables)
        broken = Ref(name, (), event.span)
        found.variables[name] = Variable(
            name, "variable", (), "", "", None, None, False, None, None, False, "whether the force of the contact has ended it",
            event.span, type_name="Boolean")
        kept = [x for x in parts if x not in ending] + [Unary("not", truth_of(broken, NO), event.span)]
        found.events.extend((
            Event(Unary("not", _all_of(ending), event.condition.span), (Reset(broken, _yes(event), event.span, is_kept=True),),
                  event.component, event.span, (name, "breaks"), comes_at_start=True),
            replace(event, condition=_all_of(kept))))
    return found


def _parts_of(event: Event, bindings: Bindings, whole: WholeNumbers) -> list[Flat]:
    """What all has to be true, where some of it asks for the force of a contact."""
    is_asked = not event.is_start and bool(contact_forces_of(event.condition, bindings))
    return [] if not is_asked else [*parts_of(without_not(compared(opened(event.condition, bindings), whole)))]


def _that_end_it(parts: Sequence[Flat], bindings: Bindings) -> list[Flat]:
    """Those that ask for the force along a gap that another part compares with 0, and for no other."""
    gaps = [gap for part in parts if (gap := below_zero(part)) is not None]
    asked = [(part, contact_forces_of(part, bindings)) for part in parts]
    return [part for part, forces in asked if forces and all(any(are_alike(x, gap) for gap in gaps) for x in forces)]


def _names_for(component: str) -> Iterator[str]:
    stem = f"{component}.broken" if component else "broken"
    yield stem
    yield from (f"{stem}{k}" for k in range(2, 1000))


def _all_of(parts: Sequence[Flat]) -> Flat:
    return reduce(lambda a, b: Binary("and", a, b, b.span), parts)


def _yes(event: Event) -> Flat:
    return Number(1.0, None, event.span)
